//! A new controller in Rust.

use super::template::{NewFile, Template, code, in_clone, shell_word, usage};
use controller::foreign;
use shared::exit::Failure;
use std::path::Path;

/// A package with a controller. With `tree`, its crates come from there.
pub fn controller(folder: &Path, from: Template, tree: Option<&Path>) -> Result<Vec<NewFile>, Failure> {
    let name = folder.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let first = name.starts_with(|first: char| first.is_ascii_lowercase());
    if !first || !name.bytes().all(|byte| matches!(byte, b'a'..=b'z' | b'0'..=b'9' | b'-' | b'_')) {
        return Err(usage(format!(
            "{name:?} cannot name a Rust package: use lower-case letters, digits, - and _, beginning with a letter"
        )));
    }
    let (scene, text, test) = match from {
        Template::Stand => ("stand", foreign::RUST_STAND, STAND_TEST),
        Template::Walk => ("walk", foreign::RUST_WALK, WALK_TEST),
    };
    let head = text.lines().next().unwrap_or_default();
    let main = format!("{head} README.md says how to run it.\n\n#[cfg(test)]\nmod tests;\n\n{}", code(text, "use "));
    Ok(vec![
        ("Cargo.toml", manifest(name, from, tree)?),
        ("README.md", readme(name, folder, scene, tree.is_some())),
        ("src/main.rs", main),
        ("src/tests.rs", test.into()),
    ])
}

fn manifest(name: &str, from: Template, tree: Option<&Path>) -> Result<String, Failure> {
    let version = env!("CARGO_PKG_VERSION");
    let crates: &[&str] = match from {
        Template::Stand => &["messages"],
        Template::Walk => &["controller", "messages"],
    };
    let dependency = |name: &&str| format!("{name} = {{ package = \"biped-{name}\", version = \"{version}\" }}\n");
    let dependencies: String = crates.iter().map(dependency).collect();
    let patch = match tree {
        Some(tree) => {
            let tree = in_clone(tree, "messages/Cargo.toml")?;
            let patch = |name: &&str| format!("biped-{name}.path = {:?}\n", tree.join(name).display().to_string());
            format!("\n[patch.crates-io] # from the clone instead\n{}", crates.iter().map(patch).collect::<String>())
        }
        None => String::new(),
    };
    Ok(format!(
        "[package]\nname = \"{name}\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\n\
         [dependencies] # both sides of a session need the same version\n{dependencies}\n\
         [workspace] # a package of its own, wherever its folder is\n{patch}"
    ))
}

fn readme(name: &str, folder: &Path, scene: &str, has_tree: bool) -> String {
    let (program, manifest) = (folder.join("target/release").join(name), shell_word(&folder.join("Cargo.toml")));
    let program = shell_word(&program);
    let build = format!("cargo build --release --manifest-path {manifest}");
    let unpublished = "If crates.io does not have the crates of biped yet, make this folder again by\n\
                       `biped new controller NAME --rust --tree CLONE`, with a clone of the repository of biped.\n";
    format!(
        "# A controller for biped\n\n\
         {build}\n\
         biped run {scene} --controller \"{program}\"   # started by biped\n\
         biped plant {scene} --session lab & {program} --session lab   # started by hand, for example in a debugger\n\
         biped conform --controller \"{program}\"     # checks it against the rules of the wire\n\
         cargo test --release --manifest-path {manifest}\n{}",
        if has_tree { String::new() } else { format!("\n{unpublished}") }
    )
}

const STAND_TEST: &str = r#"//! Claims about the controller.

use super::*;

#[test]
fn eight_finite_torques_within_the_limit() {
    let scene = messages::load::built_in("stand").expect("a built-in scene");
    let mut stand = Stand::new(&scene).expect("it fits");
    let torques = stand.tick(&Encoders::default()).expect("torques").torques.torque;
    assert!(torques.iter().all(|torque| torque.abs() <= scene.plant.torque_limit), "{torques:?}");
}
"#;

const WALK_TEST: &str = r#"//! Claims about the controller.

use super::*;

#[test]
fn eight_finite_torques_within_the_limit() {
    let scene = messages::load::built_in("walk").expect("a built-in scene");
    let mut walk = Walk::new(&scene).expect("it fits");
    let count = std::f64::consts::TAU / f64::from(scene.plant.encoder_bits).exp2();
    let mut counts = [0; 8];
    counts.iter_mut().zip(&scene.initial.joints).for_each(|(count_of, angle)| *count_of = (angle / count).round() as i64);
    let torques = walk.tick(&Encoders { counts }).expect("torques").torques.torque;
    assert!(torques.iter().all(|torque| torque.abs() <= scene.plant.torque_limit), "{torques:?}");
}
"#;
