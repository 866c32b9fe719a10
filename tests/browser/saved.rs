//! Pages of finished runs: a report opened from disk, and a recording.

use super::live::biped;
use super::{address_of, open, report, screenshot};
use crate::chromium::Browser;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::json;

#[test]
fn the_report_plays_scrubs_and_draws_without_network_access_or_errors() {
    let (folder, address) = report(&[], &[]);
    let size = std::fs::metadata(folder.join("report.html")).unwrap().len();
    assert!(size < 5_000_000, "{size} bytes");
    let mut page = open(&address, 1280, 720);

    // It plays automatically, and the robot in the view is at the position of the trajectory.
    page.until("player.time > .3");
    page.value("player.play(false)");
    page.value("player.seek(2)");
    page.until("!player.isStale && !stage.isStale");
    let early = screenshot(&mut page, "report-early");
    let place = |page: &mut Browser| page.number("robot.base.getWorldPosition(new THREE.Vector3()).x");
    let before = place(&mut page);
    // Scrubbing changes the time, and with it the robot, the cursors and the view.
    page.value("byId('scrub').value = 12, byId('scrub').dispatchEvent(new Event('input'))");
    page.until("!player.isStale && !stage.isStale");
    assert_eq!(page.number("player.time"), 12.0);
    let gone = place(&mut page) - before;
    assert!((1.8..2.2).contains(&gone), "{gone} m in 10 s at .2 m/s");
    let shown =
        page.number("plots.panels[0].plot.posToVal(new DOMMatrix(plots.panels[0].head.style.transform).e, 'x')");
    assert!((shown - 12.0).abs() < 1e-3, "the cursor is at {shown} s");
    assert_ne!(screenshot(&mut page, "report"), early, "the picture moved");

    // The drawing matches the record: by the kinematic tree, the loaded contact points are on the ground.
    let lowest = page.number("Math.min(...robot.contacts().map((point) => point.z))");
    assert!(lowest.abs() < 1e-3, "the lowest contact point is {lowest} m above the ground");
    let prints = page.number("markers.prints.children.filter((print) => print.visible).length");
    assert!((25.0..45.0).contains(&prints), "{prints} footprints after 34 steps");
    let force = page.number("markers.arrows.filter((arrow) => arrow.visible).length");
    assert!(force >= 1.0, "no force holds it");

    // A step is one row. Playback stops at the end of the trajectory. Other window sizes and colour schemes are drawn too.
    page.value("byId('forth').click()");
    page.until("!player.isStale");
    assert!((page.number("player.time") - 12.005).abs() < 1e-5);
    page.value("player.seek(13.9), player.play(true)");
    page.until("!player.isPlaying && player.time === trajectory.end");
    page.value("player.seek(9.1)");
    for (scheme, width, height) in [("dark", 1280, 720), ("light", 390, 844), ("dark", 390, 844)] {
        page.prefers(scheme);
        page.resize(width, height);
        let paper = if scheme == "dark" { "12161b" } else { "eef1f4" };
        page.until(&format!(
            "stage.scene.background.getHexString() === '{paper}' && !player.isStale && !stage.isStale"
        ));
        assert_eq!(page.number("document.documentElement.scrollWidth"), f64::from(width), "wider than its screen");
        screenshot(&mut page, &format!("report-{scheme}-{width}"));
    }
    page.value("byId('theme').click()");
    assert_eq!(page.value("isDark()"), json!(false));
    assert_eq!(page.complaints, Vec::<String>::new());
    assert_eq!(page.requests, [address], "it fetches nothing but itself");
    drop(page);
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_recording_opens_as_the_same_page_as_the_report_of_its_run() {
    let (folder, address) = report(&["duration=3"], &[]);
    let recording = folder.join("run.mcap");
    let file = recording.to_str().unwrap();
    let run = ["run", "walk", "--in-process", "--quiet", "--set", "duration=3", "--record", file];
    assert!(biped(&run).output().unwrap().status.success());

    // Written to a file, the page has exactly the frames of the report.
    let page = folder.join("recording.html");
    let written = biped(&["view", file, "--out", page.to_str().unwrap()]).output().unwrap();
    assert!(written.status.success(), "{}", String::from_utf8_lossy(&written.stderr));
    let frames = "Array.from(trajectory.floats.subarray(0, trajectory.length * trajectory.width)).filter((_, place) => !measured.has(place % trajectory.width)).join()";
    let measured = "globalThis.measured = new Set(['reply', 'late'].map((name) => trajectory.columns.get(name)[0]))";
    let mut all_frames = vec![];
    for address in [address, format!("file://{}", page.display())] {
        let mut page = open(&address, 1280, 720);
        page.value(measured);
        all_frames.push(page.value(frames));
        assert_eq!((page.complaints.clone(), page.requests.clone()), (vec![], vec![address]));
    }
    assert!(all_frames[0].as_str().unwrap().len() > 100_000 && all_frames[0] == all_frames[1]);

    // Served by `biped view`, the page plays, and the server ends in order.
    let mut view = biped(&["view", file, "--port", "0"]).spawn().unwrap();
    let mut page = open(&address_of(&mut view), 1280, 720);
    page.value(measured);
    assert_eq!(page.value(frames), all_frames[0]);
    page.until("player.time > 1");
    assert_eq!(page.value("byId('controls').hidden"), json!(true));
    screenshot(&mut page, "recording");
    assert_eq!(page.complaints, Vec::<String>::new());
    drop(page);
    kill(Pid::from_raw(view.id() as i32), Signal::SIGTERM).unwrap();
    assert!(view.wait().unwrap().success());
    std::fs::remove_dir_all(folder).unwrap();
}
