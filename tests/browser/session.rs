//! The page of a running session.

use super::live::{Running, biped};
use super::{address_of, open, screenshot};
use crate::chromium::Browser;
use messages::port::Action;
use serde_json::json;
use std::process::Child;

/// Pauses a session at the start of a frame of the page. There is one every five control periods.
fn pause(page: &mut Browser, walk: &mut Running) {
    page.value("byId('pause').click()");
    page.until("byId('answer').textContent.endsWith('paused')");
    let past = (walk.ask(Action::Pause).stamp.seq - 1) % 5;
    step(page, walk, 10 - past);
    page.value("globalThis.from = trajectory.length - 1");
}

/// Advances a paused session, and waits until the page shows it. Returns the impulse of the ground along x, ∫ F dt [N s].
fn step(page: &mut Browser, walk: &mut Running, periods: u64) -> f64 {
    walk.observe();
    let (end, mut ground) = (walk.ask(Action::Step { periods }).stamp.seq + periods, 0.0);
    let truth = walk.until("some periods", |truth| {
        ground += 1e-3 * truth.contact_force.iter().step_by(3).sum::<f64>();
        truth.stamp.seq == end
    });
    walk.stop_observing();
    page.until(&format!("Math.abs(trajectory.end - {}) < 1e-3", truth.stamp.time()));
    ground
}

/// Advances by 100 periods. Returns the external impulse on the robot along x: its change of momentum minus the impulse of the ground,
/// m Δv − ∫ F dt [N s].
fn external_impulse(page: &mut Browser, walk: &mut Running) -> f64 {
    let ground = step(page, walk, 100);
    14.0 * page.number("trajectory.get(trajectory.length - 1, 'velocity', 0) - trajectory.get(from, 'velocity', 0)")
        - ground
}

/// A robot that steps in place in a session of this name, the server of its page, and the page when it shows the robot.
fn stepping_in_place(name: &str) -> (Running, Child, Browser) {
    let mut walk = Running::start(name, &["--set", "duration=100000", "--set", "controller.speed=0"]);
    walk.until("stepping", |truth| truth.telemetry.steps > 4);
    walk.stop_observing();
    let mut view = biped(&["view", "--session", walk.session.name(), "--port", "0"]).spawn().unwrap();
    let mut page = open(&address_of(&mut view), 1280, 720);
    page.until("trajectory.length > 200 && player.time > 0");
    (walk, view, page)
}

#[test]
fn the_page_of_a_running_session_shows_and_controls_pushes_speed_pause_and_reset() {
    let (mut walk, view, mut page) = stepping_in_place("page");

    // The page removes the token from its address. A reload without the token still works.
    assert_eq!(page.value("location.search + document.cookie"), json!(""));
    page.value("globalThis.isOld = true, location.reload()");
    page.until(
        "!globalThis.isOld && typeof trajectory === 'object' && trajectory.length > 200 && location.search === ''",
    );
    page.until("performance.getEntriesByName('open').length === 1");
    page.complaints.retain(|complaint| !complaint.contains("403")); // the reload causes one expected 403

    // The arrows on the push buttons show the direction of each push in the view of every camera: left, right, forward, back.
    let quarter = std::f64::consts::FRAC_PI_2;
    let seen = [
        ("side", [None, None, Some(0.0), Some(2.0 * quarter)]),
        ("front", [Some(0.0), Some(2.0 * quarter), None, None]),
        ("top", [Some(-quarter), Some(quarter), Some(0.0), Some(2.0 * quarter)]),
    ];
    for (camera, angles) in seen {
        page.value(&format!(
            "[...byId('cameras').children].find((button) => button.textContent === '{camera}').click()"
        ));
        page.until("!stage.isStale && !player.isStale");
        let marks = "[...document.querySelectorAll('#controls [data-push] i')].map((mark) => [mark.textContent, parseFloat(mark.style.transform.slice(7))])";
        let marks: Vec<(String, Option<f64>)> = serde_json::from_value(page.value(marks)).unwrap();
        for ((mark, angle), expected) in marks.iter().zip(angles) {
            let is_right = match (expected, angle) {
                (Some(expected), Some(angle)) => {
                    mark == "→" && (angle - expected).sin().abs() < 0.2 && (angle - expected).cos() > 0.0
                }
                (None, None) => mark == "⊙" || mark == "⊗",
                _ => false,
            };
            assert!(is_right, "{camera}: {marks:?}");
        }
        screenshot(&mut page, &format!("live-{camera}"));
    }
    assert_eq!(
        page.value("stage.screenDirection(markers.com.position, new THREE.Vector3(0, 0, 1)).depth > .9"),
        json!(true),
        "from above"
    );

    // The change of momentum is the impulse of the push.
    pause(&mut page, &mut walk);
    page.value("byId('strength').value = 2, document.querySelector('[data-push=\"1,0,0\"]').click()");
    page.until("byId('answer').textContent.startsWith('push: done')");
    let impulse = external_impulse(&mut page, &mut walk);
    assert!((impulse - 2.0).abs() < 0.02, "{impulse} N s, not 2");
    let before = page.number("trajectory.end");
    page.value("byId('advance').click()");
    page.until("byId('answer').textContent.startsWith('step: done')");
    page.until(&format!("Math.abs(trajectory.end - {before} - .01) < 1e-4"));
    page.value("byId('resume').click()");
    page.until("byId('answer').textContent.startsWith('resume: done')");

    // The walking speed follows its set-point.
    page.value("byId('pace').value = .15, byId('set').click()");
    page.until("/^set: done at t [0-9.]+ s$/.test(byId('answer').textContent)");
    let speed = "(() => { const row = trajectory.row(trajectory.end - 3); \
                 return (trajectory.get(trajectory.length - 1, 'com', 0) - trajectory.get(row, 'com', 0)) / (trajectory.end - trajectory.get(row, 'time')); })()";
    let end = page.number("trajectory.end");
    page.until(&format!("trajectory.end > {end} + 10 && Math.abs({speed} - .15) < .03"));
    screenshot(&mut page, "live");
    page.prefers("dark");
    page.until("stage.scene.background.getHexString() === '12161b' && !stage.isStale");
    screenshot(&mut page, "live-dark");
    page.prefers("light");
    page.value("byId('pace').value = 9, byId('set').click()");
    page.until("byId('answer').textContent.includes('refused: a number is out of range')");

    // The robot stops, and then refuses other set-points.
    page.value("byId('halt').click()");
    page.until("/^stop: done at t [0-9.]+ s$/.test(byId('answer').textContent)");
    let end = page.number("trajectory.end");
    page.until(&format!("trajectory.end > {end} + 8 && Math.abs({speed}) < .001"));
    page.value("byId('pace').value = .1, byId('set').click()");
    page.until("byId('answer').textContent.includes('refused: the robot stands or stops')");
    page.complaints.retain(|complaint| !complaint.contains("409")); // Chromium logs the refused requests

    // A reset starts a new trajectory. In lockstep a run can advance far between two checks, so the session is paused first.
    page.value("byId('pause').click()");
    page.until("byId('answer').textContent.endsWith('paused')");
    page.value("byId('reset').click()");
    page.until("live.run === 2 && trajectory.length > 0 && trajectory.begin < 1");
    page.value("byId('resume').click()");
    page.until("byId('answer').textContent.startsWith('resume: done')");
    page.resize(390, 844);
    page.until("!stage.isStale || trajectory.length > 0");
    assert_eq!(page.number("document.documentElement.scrollWidth"), 390.0);
    screenshot(&mut page, "live-390");
    assert_eq!(page.complaints, Vec::<String>::new());
    drop(page);
    walk.end_with(view);
}

#[test]
fn a_drag_on_the_robot_pushes_it_by_the_drawn_impulse_and_a_drag_elsewhere_rotates_the_camera() {
    let (mut walk, view, mut page) = stepping_in_place("drag");
    page.value("byId('cameras').querySelectorAll('button')[1].click()"); // side view
    pause(&mut page, &mut walk);
    page.until("!player.isStale && !stage.isStale");
    let trunk = |page: &mut Browser| {
        let place = "(() => { const box = stage.renderer.domElement.getBoundingClientRect(), \
                     [x, y] = stage.onScreen(robot.centre(runInfo.trunk)); return [box.left + x, box.top + y]; })()";
        serde_json::from_value::<[f64; 2]>(page.value(place)).unwrap()
    };

    // During the drag, the arrow ends at the pointer, and its label is its length.
    let [x, y] = trunk(&mut page);
    page.drag(&[[x, y], [x + 20.0, y], [x + 70.0, y - 10.0]]);
    assert_eq!(page.value("drag.arrow.visible && !drag.label.hidden"), json!(true));
    let reach = "(() => { const tip = robot.centre(runInfo.trunk).addScaledVector(drag.hold.impulse, METRES_PER_NEWTON_SECOND); \
                 const [from, to] = [robot.centre(runInfo.trunk), tip].map((place) => stage.onScreen(place)); \
                 return Math.hypot(to[0] - from[0] - 70, to[1] - from[1] + 10); })()";
    assert!(page.number(reach) < 0.5, "the arrow does not follow the pointer");
    let wanted: [f64; 3] = serde_json::from_value(page.value("drag.hold.impulse.toArray()")).unwrap();
    let length = wanted.iter().map(|part| part * part).sum::<f64>().sqrt();
    assert_eq!(page.value("drag.label.textContent"), json!(format!("{length:.1} N·s")));
    assert!((0.5..5.0).contains(&length) && wanted[0] > 0.95 * length, "{wanted:?}");
    screenshot(&mut page, "live-drag");
    page.drop_at([x + 70.0, y - 10.0]);
    page.until("byId('answer').textContent.startsWith('push: done')");
    assert_eq!(page.value("drag.arrow.visible || !drag.label.hidden"), json!(false));
    let impulse = external_impulse(&mut page, &mut walk);
    assert!((impulse / wanted[0] - 1.0).abs() < 0.01, "{impulse} N s, not {}", wanted[0]);

    // A drag beside the robot rotates the camera. A cancelled drag and a click push nothing.
    page.value("byId('answer').textContent = 'nothing'");
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
    assert_eq!(page.value("byId('answer').textContent"), json!("nothing"));

    // A drag by touch pushes too.
    page.resize(390, 844);
    page.until("!player.isStale && !stage.isStale");
    let [x, y] = trunk(&mut page);
    page.swipe(&[[x, y], [x + 10.0, y], [x + 40.0, y]]);
    page.until("byId('answer').textContent.startsWith('push: done')");
    screenshot(&mut page, "live-drag-390");
    assert_eq!(page.complaints, Vec::<String>::new());
    drop(page);
    walk.end_with(view);
}
