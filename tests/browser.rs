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
use serde_json::json;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// Keeps what the page looks like.
fn keep(browser: &mut Browser, name: &str) -> Vec<u8> {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("pages");
    std::fs::create_dir_all(&folder).unwrap();
    let picture = browser.picture();
    std::fs::write(folder.join(name).with_extension("png"), &picture).unwrap();
    picture
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
    let mut page = Browser::open(&address, 1280, 720);

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
        page.until("!player.isStale && !stage.isStale");
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

#[test]
#[ignore = "prints how long a browser takes over a walk of ten minutes"]
fn ten_minutes_open_and_scrub() {
    let (folder, address) = report(&["duration=600"]);
    let size = std::fs::metadata(folder.join("report.html")).unwrap().len();
    let mut page = Browser::open(&address, 1280, 720);
    let opened = page.number("performance.getEntriesByType('navigation')[0].domComplete");
    page.value("player.play(false)");
    let scrub = page.number(
        "(() => { const begin = performance.now(); \
         for (let i = 0; i < 100; i++) { player.seek(6 * i); player.tick(0); stage.draw(marks.com.position.toArray()); } \
         return (performance.now() - begin) / 100; })()",
    );
    println!("{:.1} MB, open after {opened:.0} ms, {scrub:.1} ms per place that is scrubbed to", size as f64 * 1e-6);
    assert!(page.number("film.end") > 599.0);
    assert_eq!(page.complaints, Vec::<String>::new());
    drop(page);
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_running_session_shows_and_obeys_pushes_speed_pause_and_reset() {
    let mut walk = Running::start("page", &["--set", "duration=100000", "--set", "controller.speed=0"]);
    walk.until("stamping", |truth| truth.telemetry.steps > 4);
    walk.leave();
    let mut view = biped(&["view", "--session", walk.session.name(), "--port", "0"]).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(view.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
    let address = line.split_once("open ").unwrap().1.trim();
    let mut page = Browser::open(address, 1280, 720);
    page.until("film.length > 200 && player.time > 0");

    // What a push gives, the robot keeps as momentum or hands on to the ground: J = m dv - integral of F dt.
    page.value("part('pause').click()");
    page.until("part('answer').textContent.endsWith('paused')");
    let paused = walk.ask(Ask::Pause).stamp;
    let time = paused.sim_ns as f64 * 1e-9;
    page.until(&format!("film.end > {time} - .006"));
    page.value("globalThis.from = film.length - 1");
    page.value("part('strength').value = 2, document.querySelector('[data-push=\"1,0,0\"]').click()");
    page.until("part('answer').textContent.startsWith('push: done')");
    page.value("part('advance').click()");
    page.until("part('answer').textContent.startsWith('step: done')");
    assert!(walk.ask(Ask::Step { periods: 90 }).stamp.seq <= paused.seq + 10);
    page.until(&format!("film.end > {time} + .09"));
    let impulse = page.number(
        "14 * (film.get(film.length - 1, 'velocity', 0) - film.get(from, 'velocity', 0)) - [...Array(film.length - 1 - from).keys()] \
         .map((row) => film.all(from + 1 + row, 'force').filter((_, index) => index % 3 === 0).reduce((sum, force) => sum + force, 0)) \
         .reduce((sum, force) => sum + .005 * force, 0)",
    );
    assert!((1.4..2.6).contains(&impulse), "{impulse} N s, not 2");
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
