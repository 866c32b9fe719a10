//! Claims about the pages, in a real browser. Pictures of them are left in `target/tmp/pages/`.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

#[path = "common/chromium.rs"]
mod chromium;
mod common;
#[path = "common/live.rs"]
mod live;

use chromium::Browser;
use common::fresh_path;
use live::{Running, biped};
use messages::port::Ask;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::json;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

/// Keeps what the page looks like.
fn keep(browser: &mut Browser, name: &str) -> Vec<u8> {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("pages");
    std::fs::create_dir_all(&folder).unwrap();
    let picture = browser.picture();
    std::fs::write(folder.join(name).with_extension("png"), &picture).unwrap();
    picture
}

/// Opens a page, picture and all.
fn open(address: &str, width: u32, height: u32) -> Browser {
    let mut page = Browser::open(address, width, height);
    page.until("performance.getEntriesByName('open').length === 1");
    page
}

/// A report, and where it is.
fn report(settings: &[&str]) -> (PathBuf, String) {
    let folder = fresh_path("page");
    let run = Command::new(env!("CARGO_BIN_EXE_biped"))
        .args(["run", "walk", "--in-process", "--quiet", "--out"])
        .arg(&folder)
        .args(settings.iter().flat_map(|setting| ["--set", setting]))
        .stdout(Stdio::null())
        .status();
    assert!(run.unwrap().success());
    let address = format!("file://{}/report.html", folder.display());
    (folder, address)
}

#[test]
fn the_report_walks_scrubs_and_draws_without_a_network_or_an_error() {
    let (folder, address) = report(&[]);
    let size = std::fs::metadata(folder.join("report.html")).unwrap().len();
    assert!(size < 5_000_000, "{size} bytes");
    let mut page = open(&address, 1280, 720);

    // It plays by itself; the robot in the picture is where the film has it.
    page.until("player.time > .3");
    page.value("player.play(false)");
    page.value("player.seek(2)");
    page.until("!player.isStale && !stage.isStale");
    let early = keep(&mut page, "report-early");
    let place = |page: &mut Browser| page.number("robot.base.getWorldPosition(new THREE.Vector3()).x");
    let before = place(&mut page);
    // The scrub moves time and with it the robot, the cursors and the picture.
    page.value("part('scrub').value = 12, part('scrub').dispatchEvent(new Event('input'))");
    page.until("!player.isStale && !stage.isStale");
    assert_eq!(page.number("player.time"), 12.0);
    let gone = place(&mut page) - before;
    assert!((1.8..2.2).contains(&gone), "{gone} m in 10 s at .2 m/s");
    let shown =
        page.number("plots.panels[0].plot.posToVal(new DOMMatrix(plots.panels[0].head.style.transform).e, 'x')");
    assert!((shown - 12.0).abs() < 1e-3, "the cursor is at {shown} s");
    assert_ne!(keep(&mut page, "report"), early, "the picture moved");

    // What is drawn is what was recorded: the joint tree gives the contact points that carry, on the ground.
    let lowest = page.number("Math.min(...robot.contacts().map((point) => point.z))");
    assert!(lowest.abs() < 1e-3, "the lowest contact point is {lowest} m above the ground");
    let prints = page.number("marks.prints.children.filter((print) => print.visible).length");
    assert!((25.0..45.0).contains(&prints), "{prints} footprints after 34 steps");
    let force = page.number("marks.arrows.filter((arrow) => arrow.visible).length");
    assert!(force >= 1.0, "no force holds it");

    // A step is one row; the end of the film ends playing; other sizes and schemes draw as well.
    page.value("part('forth').click()");
    page.until("!player.isStale");
    assert!((page.number("player.time") - 12.005).abs() < 1e-5);
    page.value("player.seek(13.9), player.play(true)");
    page.until("!player.isPlaying && player.time === film.end");
    page.value("player.seek(9.1)");
    for (scheme, width, height) in [("dark", 1280, 720), ("light", 390, 844), ("dark", 390, 844)] {
        page.prefers(scheme);
        page.resize(width, height);
        let paper = if scheme == "dark" { "12161b" } else { "eef1f4" };
        page.until(&format!(
            "stage.scene.background.getHexString() === '{paper}' && !player.isStale && !stage.isStale"
        ));
        assert_eq!(page.number("document.documentElement.scrollWidth"), f64::from(width), "wider than its screen");
        keep(&mut page, &format!("report-{scheme}-{width}"));
    }
    page.value("part('theme').click()");
    assert_eq!(page.value("isDark()"), json!(false));
    assert_eq!(page.complaints, Vec::<String>::new());
    assert_eq!(page.requests, [address], "it fetches nothing but itself");
    drop(page);
    std::fs::remove_dir_all(folder).unwrap();
}

/// How long until the picture and the plots are there, as the page itself says [ms].
const OPEN: &str = "performance.getEntriesByName('open')[0].startTime";

/// Times of a page: until it is open, and for each place that is scrubbed to [ms].
fn times(address: &str) -> [f64; 2] {
    let mut page = open(address, 1280, 720);
    page.value("player.play(false)");
    let steps =
        "performance.getEntriesByType('mark').map(({name, startTime}) => `${name} ${startTime.toFixed(0)}`).join(', ')";
    println!("{address}: {}", page.value(steps));
    let scrub = page.number(
        "(() => { const begin = performance.now(), end = film.end; \
         for (let i = 0; i < 100; i++) { player.seek(end * i / 100); player.tick(0); stage.draw(marks.com.position.toArray()); } \
         return (performance.now() - begin) / 100; })()",
    );
    assert_eq!(page.complaints, Vec::<String>::new());
    [page.number(OPEN), scrub]
}

/// Run by `cargo test --release --test browser ten_minutes -- --nocapture` it prints the times.
#[test]
fn ten_minutes_open_and_scrub_within_twice_the_time_of_fourteen_seconds() {
    let (short, long) = (report(&[]), report(&["duration=600"]));
    let mut all = [[vec![], vec![]], [vec![], vec![]]];
    for run in 0..6 {
        let (folder, address) = [&short, &long][run % 2];
        let size = std::fs::metadata(folder.join("report.html")).unwrap().len() as f64 * 1e-6;
        let times = times(address);
        println!("{size:.1} MB: open after {:.0} ms, {:.1} ms per place that is scrubbed to", times[0], times[1]);
        all[run % 2].iter_mut().zip(times).for_each(|(all, time)| all.push(time));
    }
    for (index, what) in ["opens", "scrubs"].into_iter().enumerate() {
        let [short, long] = [0, 1].map(|film| all[film][index].iter().copied().fold(f64::INFINITY, f64::min));
        let ratio = long / short;
        println!("ten minutes take {ratio:.2} times as long as 14 s: it {what}");
        assert!(ratio < 2.0, "it {what} {ratio:.2} times as slowly");
    }
    [short, long].into_iter().for_each(|(folder, _)| std::fs::remove_dir_all(folder).unwrap());
}

#[test]
fn a_recording_opens_as_the_page_that_its_run_left() {
    let (folder, address) = report(&["duration=3"]);
    let recording = folder.join("run.mcap");
    let file = recording.to_str().unwrap();
    let run = ["run", "walk", "--in-process", "--quiet", "--set", "duration=3", "--record", file];
    assert!(biped(&run).output().unwrap().status.success());

    // Written: the very frames of the report.
    let page = folder.join("recording.html");
    let written = biped(&["view", file, "--out", page.to_str().unwrap()]).output().unwrap();
    assert!(written.status.success(), "{}", String::from_utf8_lossy(&written.stderr));
    let film = "Array.from(film.floats.subarray(0, film.length * film.width)).filter((_, place) => !measured.has(place % film.width)).join()";
    let measured = "globalThis.measured = new Set(['reply', 'late'].map((name) => film.places.get(name)[0]))";
    let mut films = vec![];
    for address in [address, format!("file://{}", page.display())] {
        let mut page = open(&address, 1280, 720);
        page.value(measured);
        films.push(page.value(film));
        assert_eq!((page.complaints.clone(), page.requests.clone()), (vec![], vec![address]));
    }
    assert!(films[0].as_str().unwrap().len() > 100_000 && films[0] == films[1]);

    // Served: it plays, and ends in order.
    let mut view = biped(&["view", file, "--port", "0"]).spawn().unwrap();
    let mut page = open(&address_of(&mut view), 1280, 720);
    page.value(measured);
    assert_eq!(page.value(film), films[0]);
    page.until("player.time > 1");
    assert_eq!(page.value("part('desk').hidden"), json!(true));
    keep(&mut page, "recording");
    assert_eq!(page.complaints, Vec::<String>::new());
    drop(page);
    kill(Pid::from_raw(view.id() as i32), Signal::SIGTERM).unwrap();
    assert!(view.wait().unwrap().success());
    std::fs::remove_dir_all(folder).unwrap();
}

/// Where a view that has been started is found.
fn address_of(view: &mut Child) -> String {
    let mut line = String::new();
    BufReader::new(view.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
    line.split_once("open ").unwrap().1.trim().into()
}

/// Pauses a session where a frame of the page begins; they come every five periods.
fn pause(page: &mut Browser, walk: &mut Running) {
    page.value("part('pause').click()");
    page.until("part('answer').textContent.endsWith('paused')");
    let past = (walk.ask(Ask::Pause).stamp.seq - 1) % 5;
    step(page, walk, 10 - past);
    page.value("globalThis.from = film.length - 1");
}

/// Lets a paused session go on, and the page show it; returns what the ground gave along x, ∫ F dt [N s].
fn step(page: &mut Browser, walk: &mut Running, periods: u64) -> f64 {
    walk.rejoin();
    let (end, mut ground) = (walk.ask(Ask::Step { periods }).stamp.seq + periods, 0.0);
    let truth = walk.until("some periods", |truth| {
        ground += 1e-3 * truth.contact_force.iter().step_by(3).sum::<f64>();
        truth.stamp.seq == end
    });
    walk.leave();
    page.until(&format!("Math.abs(film.end - {}) < 1e-3", truth.stamp.sim_ns as f64 * 1e-9));
    ground
}

/// Goes on for 100 periods: what the robot has got along x that the ground has not given, m Δv − ∫ F dt [N s].
fn gained(page: &mut Browser, walk: &mut Running) -> f64 {
    let ground = step(page, walk, 100);
    14.0 * page.number("film.get(film.length - 1, 'velocity', 0) - film.get(from, 'velocity', 0)") - ground
}

#[test]
fn a_running_session_shows_and_obeys_pushes_speed_pause_and_reset() {
    let mut walk = Running::start("page", &["--set", "duration=100000", "--set", "controller.speed=0"]);
    walk.until("stamping", |truth| truth.telemetry.steps > 4);
    walk.leave();
    let mut view = biped(&["view", "--session", walk.session.name(), "--port", "0"]).spawn().unwrap();
    let mut page = open(&address_of(&mut view), 1280, 720);
    page.until("film.length > 200 && player.time > 0");

    // What a push gives, the robot has.
    pause(&mut page, &mut walk);
    page.value("part('strength').value = 2, document.querySelector('[data-push=\"1,0,0\"]').click()");
    page.until("part('answer').textContent.startsWith('push: done')");
    let impulse = gained(&mut page, &mut walk);
    assert!((impulse - 2.0).abs() < 0.02, "{impulse} N s, not 2");
    let before = page.number("film.end");
    page.value("part('advance').click()");
    page.until("part('answer').textContent.startsWith('step: done')");
    page.until(&format!("Math.abs(film.end - {before} - .01) < 1e-4"));
    page.value("part('resume').click()");
    page.until("part('answer').textContent.startsWith('resume: done')");

    // Walking speed.
    page.value("part('pace').value = .15, part('set').click()");
    page.until("part('answer').textContent.startsWith('set: done')");
    let speed = "(() => { const row = film.row(film.end - 3); \
                 return (film.get(film.length - 1, 'com', 0) - film.get(row, 'com', 0)) / (film.end - film.get(row, 'time')); })()";
    let end = page.number("film.end");
    page.until(&format!("film.end > {end} + 10 && Math.abs({speed} - .15) < .03"));
    keep(&mut page, "live");
    page.prefers("dark");
    page.until("stage.scene.background.getHexString() === '12161b' && !stage.isStale");
    keep(&mut page, "live-dark");
    page.prefers("light");
    page.value("part('pace').value = 9, part('set').click()");
    page.until("part('answer').textContent.includes('refused: a number is out of range')");
    page.complaints.retain(|complaint| !complaint.contains("409")); // Chromium's own word on it

    // A reset begins another film.
    page.value("part('reset').click()");
    page.until("live.run === 2 && film.begin < 1");
    page.resize(390, 844);
    page.until("!stage.isStale || film.length > 0");
    assert_eq!(page.number("document.documentElement.scrollWidth"), 390.0);
    keep(&mut page, "live-390");
    assert_eq!(page.complaints, Vec::<String>::new());
    drop(page);
    walk.end_with(view);
}

#[test]
fn a_drag_from_the_robot_pushes_it_by_what_is_drawn_and_a_drag_beside_it_turns_the_camera() {
    let mut walk = Running::start("drag", &["--set", "duration=100000", "--set", "controller.speed=0"]);
    walk.until("stamping", |truth| truth.telemetry.steps > 4);
    walk.leave();
    let mut view = biped(&["view", "--session", walk.session.name(), "--port", "0"]).spawn().unwrap();
    let mut page = open(&address_of(&mut view), 1280, 720);
    page.until("film.length > 200 && player.time > 0");
    page.value("part('cameras').querySelectorAll('button')[1].click()"); // from the side
    pause(&mut page, &mut walk);
    page.until("!player.isStale && !stage.isStale");
    let trunk = |page: &mut Browser| {
        let place = "(() => { const box = stage.renderer.domElement.getBoundingClientRect(), \
                     [x, y] = stage.onScreen(robot.centre(about.trunk)); return [box.left + x, box.top + y]; })()";
        serde_json::from_value::<[f64; 2]>(page.value(place)).unwrap()
    };

    // While it is dragged, the arrow reaches as far as the pointer went, and its number is its length.
    let [x, y] = trunk(&mut page);
    page.drag(&[[x, y], [x + 20.0, y], [x + 70.0, y - 10.0]]);
    assert_eq!(page.value("drag.arrow.visible && !drag.label.hidden"), json!(true));
    let reach = "(() => { const tip = robot.centre(about.trunk).addScaledVector(drag.hold.impulse, METRES_PER_NEWTON_SECOND); \
                 const [from, to] = [robot.centre(about.trunk), tip].map((place) => stage.onScreen(place)); \
                 return Math.hypot(to[0] - from[0] - 70, to[1] - from[1] + 10); })()";
    assert!(page.number(reach) < 0.5, "the arrow does not follow the pointer");
    let wanted: [f64; 3] = serde_json::from_value(page.value("drag.hold.impulse.toArray()")).unwrap();
    let length = wanted.iter().map(|part| part * part).sum::<f64>().sqrt();
    assert_eq!(page.value("drag.label.textContent"), json!(format!("{length:.1} N·s")));
    assert!((0.5..5.0).contains(&length) && wanted[0] > 0.95 * length, "{wanted:?}");
    keep(&mut page, "live-drag");
    page.drop_at([x + 70.0, y - 10.0]);
    page.until("part('answer').textContent.startsWith('push: done')");
    assert_eq!(page.value("drag.arrow.visible || !drag.label.hidden"), json!(false));
    let impulse = gained(&mut page, &mut walk);
    assert!((impulse / wanted[0] - 1.0).abs() < 0.01, "{impulse} N s, not {}", wanted[0]);

    // Beside the robot a drag turns the camera; one that is given up, or goes nowhere, pushes nobody.
    page.value("part('answer').textContent = 'nothing'");
    page.until("!player.isStale && !stage.isStale");
    let [x, y] = trunk(&mut page);
    let camera = |page: &mut Browser| page.value("stage.camera.position.toArray().join()");
    let before = camera(&mut page);
    page.drag(&[[x, y], [x + 40.0, y]]);
    page.value("document.body.dispatchEvent(new KeyboardEvent('keydown', { key: 'Escape', bubbles: true }))");
    page.drop_at([x + 40.0, y]);
    page.drag(&[[x, y]]);
    page.drop_at([x, y]);
    assert_eq!(camera(&mut page), before);
    page.drag(&[[x - 180.0, y], [x - 120.0, y]]);
    page.drop_at([x - 120.0, y]);
    assert_ne!(camera(&mut page), before);
    assert_eq!(page.value("part('answer').textContent"), json!("nothing"));

    // A finger does the same.
    page.resize(390, 844);
    page.until("!player.isStale && !stage.isStale");
    let [x, y] = trunk(&mut page);
    page.swipe(&[[x, y], [x + 10.0, y], [x + 40.0, y]]);
    page.until("part('answer').textContent.startsWith('push: done')");
    keep(&mut page, "live-drag-390");
    assert_eq!(page.complaints, Vec::<String>::new());
    drop(page);
    walk.end_with(view);
}
