//! `cargo bench -- --peers`: this simulator compared with the libraries MuJoCo and Pinocchio and four QP solvers, alternating on one core.
//!
//! | what | where |
//! |---|---|
//! | this simulator, on the common states | [`ours`] |
//! | the common states and quadratic programs as files | [`given`] |
//! | MuJoCo in C, Pinocchio in C++, so that no Python is timed | `peers/mujoco.c`, `peers/pinocchio.cpp` |
//! | DAQP, OSQP, PIQP, ProxQP, timed by themselves | `peers/programs.py` |

mod given;
mod ours;

use crate::core::Core;
use crate::link;
use crate::robot::{Activity, Recording};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Rounds in which all engines alternate.
const ROUNDS: usize = 8;
/// Runs of the whole walk in each round.
const WALKS_A_TURN: usize = 9;

/// Times by situation and stage, one per round [ns].
type Times = BTreeMap<(String, String), Vec<f64>>;

/// Prints the table.
pub fn print() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("peers");
    std::fs::create_dir_all(&folder).expect("a folder");
    let [python, packages] = install(&folder);
    let recordings = Activity::ALL.map(|activity| (activity, Recording::of(activity, &[])));
    let (states, programs) = (folder.join("states.txt"), folder.join("programs.json"));
    std::fs::write(&states, given::states(&recordings)).expect("a file");
    std::fs::write(&programs, given::programs(&recordings)).expect("a file");
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let robot = |name: &str| here.join("tests/bench/peers").join(name);
    let engines = [
        ("MuJoCo", mujoco(&folder, &packages).map(|program| [program, robot("biped8.xml"), states.clone()])),
        ("Pinocchio", pinocchio(&folder, &packages).map(|program| [program, robot("biped8.urdf"), states.clone()])),
        ("", Some([python, here.join("tests/bench/peers/programs.py"), programs])),
    ];
    let (mut own, mut others) = (Times::new(), Times::new());
    for _ in 0..ROUNDS {
        walks(&mut own);
        let _core = Core::hold();
        ours::measure(&recordings, &mut own);
        for (engine, command) in &engines {
            if let Some([program, arguments @ ..]) = command {
                let output = Command::new(program).args(arguments).output().expect("it starts");
                let text = String::from_utf8_lossy(&output.stdout);
                text.lines().for_each(|line| note(&mut others, engine, line));
            }
        }
    }
    table(&own, &others);
}

/// Time of a control period of the whole walk on all processors, with the time of a step in flight as a reference for the speed of the machine.
fn walks(times: &mut Times) {
    for (name, flag) in link::WALKS {
        let periods: Vec<_> = (0..WALKS_A_TURN).map(|_| 1e6 / link::walk(flag)).collect();
        times.entry(("flying".into(), name.to_string())).or_default().push(median(&periods));
    }
}

/// Takes a line `situation stage nanoseconds …` of an engine.
fn note(times: &mut Times, engine: &str, line: &str) {
    let words: Vec<_> = line.split_whitespace().collect();
    match (words.as_slice(), words.get(2).and_then(|word| word.parse().ok())) {
        ([situation, stage, _, remarks @ ..], Some(ns)) => {
            let (situation, stage) = (situation.to_string(), format!("{engine} {stage}"));
            let key = (situation, stage.trim().to_string());
            if let ([error, failed], true) = (remarks, times.get(&key).is_none()) {
                println!("{} on {}: off by {error}, {failed} not solved", key.1, key.0);
            }
            times.entry(key).or_default().push(ns);
        }
        (["version", version], _) if !times.keys().any(|(_, stage)| stage.starts_with(engine)) => {
            println!("{engine} {version}");
        }
        (["left", ..], _) => println!("{line}"),
        _ => (),
    }
}

/// Solvers of quadratic programs.
const PROGRAMS: [&str; 4] = ["DAQP", "OSQP", "PIQP", "ProxQP"];
/// The compared stages: one of this simulator, and those of others.
const PAIRS: [(&str, &[&str]); 15] = [
    (link::WALKS[0].0, &["MuJoCo step"]),
    (link::WALKS[1].0, &["MuJoCo step"]),
    ("contacts", &["MuJoCo contacts"]),
    ("step", &["MuJoCo step"]),
    ("step of second order", &["MuJoCo step"]),
    ("dynamics", &["Pinocchio dynamics", "Pinocchio aba"]),
    ("kinematics", &["MuJoCo kinematics", "Pinocchio kinematics"]),
    ("inertia", &["MuJoCo inertia", "Pinocchio inertia"]),
    ("bias", &["MuJoCo bias", "Pinocchio bias"]),
    ("factor", &["MuJoCo factor", "Pinocchio factor"]),
    ("constraint", &["MuJoCo constraint"]),
    ("Coulomb's law, warm", &["MuJoCo solve"]),
    ("Coulomb's law, cold", &PROGRAMS),
    ("convex law, cold", &PROGRAMS),
    ("rate QP within bounds", &PROGRAMS),
];

/// Medians over the rounds, and the best rounds, which are comparable even if a hypervisor takes processor time in some rounds.
fn table(own: &Times, others: &Times) {
    println!("\n| what | situation | ours ns | of others | its ns | its / ours | least ns | its | its / ours |");
    println!("|---|---|---|---|---|---|---|---|---|");
    for (stage, rivals) in PAIRS {
        for ((situation, _), times) in own.iter().filter(|((_, name), _)| name == stage) {
            for rival in rivals {
                let Some(others) = others.get(&(situation.clone(), rival.to_string())) else { continue };
                let (ours, theirs) = (median(times), median(others));
                let [best, their_best] =
                    [times, others].map(|times| times.iter().copied().fold(f64::INFINITY, f64::min));
                if theirs > 0.0 {
                    print!("| {stage} | {situation} | {ours:.0} | {rival} | {theirs:.0} | {:.2} |", theirs / ours);
                    println!(" {best:.0} | {their_best:.0} | {:.2} |", their_best / best);
                }
            }
        }
    }
}

/// The median.
fn median(times: &[f64]) -> f64 {
    let mut sorted = times.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

/// The Python interpreter of a virtual environment, and its packages.
fn install(folder: &Path) -> [PathBuf; 2] {
    let cache = std::env::var_os("XDG_CACHE_HOME").map(PathBuf::from);
    let home = || PathBuf::from(std::env::var_os("HOME").unwrap_or_default()).join(".cache");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bench/peers/install.py");
    let place = cache.unwrap_or_else(home).join("biped-peers");
    let output = Command::new("python3").arg(script).arg(place).current_dir(folder).output().expect("python3 starts");
    let text = String::from_utf8_lossy(&output.stdout);
    let found = |name: &str| text.lines().find_map(|line| line.strip_prefix(name)).map(PathBuf::from);
    text.lines().filter(|line| line.contains("left out")).for_each(|line| println!("{line}"));
    ["python ", "packages "].map(|name| found(name).expect("something that can be installed"))
}

fn mujoco(folder: &Path, packages: &Path) -> Option<PathBuf> {
    let home = packages.join("mujoco");
    let mut files = std::fs::read_dir(&home).ok()?.flatten().map(|entry| entry.path());
    let library = files.find(|path| path.to_string_lossy().contains("libmujoco.so"))?;
    let flags = ["-O2".into(), format!("-I{}/include", home.display()), format!("-Wl,-rpath,{}", home.display())];
    build(folder, "cc", "mujoco.c", &[], &[&flags[..], &[library.display().to_string()]].concat())
}

fn pinocchio(folder: &Path, packages: &Path) -> Option<PathBuf> {
    let home = packages.join("cmeel.prefix");
    let home = home.to_str().filter(|_| home.exists())?;
    let before = ["", "/eigen3", "/urdfdom", "/urdfdom_headers"].map(|name| format!("-I{home}/include{name}"));
    // the flags of its own build system
    let limits =
        "-DBOOST_MPL_LIMIT_LIST_SIZE=30 -DBOOST_MPL_LIMIT_VECTOR_SIZE=30 -DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS";
    let own =
        format!("-O3 -std=c++17 -DNDEBUG -DPINOCCHIO_ENABLE_TEMPLATE_INSTANTIATION -DPINOCCHIO_WITH_URDFDOM {limits}");
    let after = [format!("-L{home}/lib"), format!("-Wl,-rpath,{home}/lib,--disable-new-dtags")];
    let libraries =
        ["pinocchio_default", "pinocchio_parsers", "urdfdom_model", "boost_filesystem", "boost_serialization"];
    let before = [&own.split(' ').map(String::from).collect::<Vec<_>>()[..], &before].concat();
    build(folder, "c++", "pinocchio.cpp", &before, &[&after[..], &libraries.map(|name| format!("-l{name}"))].concat())
}

/// Compiles one of the programs here against a peer's library, unless it is already compiled.
fn build(folder: &Path, compiler: &str, source: &str, before: &[String], after: &[String]) -> Option<PathBuf> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bench/peers").join(source);
    let program = folder.join(source.file_stem()?);
    let age = |path: &Path| path.metadata().and_then(|about| about.modified()).ok();
    if age(&program) > age(&source) {
        return Some(program);
    }
    let mut command = Command::new(compiler);
    let output = command.args(before).arg(&source).arg("-o").arg(&program).args(after).output().ok()?;
    if !output.status.success() {
        println!("{} left out, it does not compile: {}", source.display(), String::from_utf8_lossy(&output.stderr));
    }
    output.status.success().then_some(program)
}
