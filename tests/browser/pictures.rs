//! The two pictures of the page in the documents. CONTRIBUTING.md says how they are renewed.

use super::live::biped;
use super::{address_of, open, screenshot};
use crate::common::fresh_path;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

#[test]
#[ignore = "makes a picture: picture-report.png"]
fn the_picture_of_a_report() {
    let folder = fresh_path("picture");
    // two processes: in one there are no commands to draw
    assert!(biped(&["run", "walk", "--quiet", "--out", folder.to_str().unwrap()]).output().unwrap().status.success());
    let mut page = open(&format!("file://{}/report.html", folder.display()), 1280, 720);
    page.value("player.play(false), player.seek(12)");
    page.until("!player.isStale && !stage.isStale");
    screenshot(&mut page, "picture-report");
    drop(page);
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
#[ignore = "makes a picture: picture-view.png"]
fn the_picture_of_a_running_session() {
    let run = ["run", "walk", "--quiet", "--realtime", "--session", "lab", "--set", "duration=60"];
    let mut walk = biped(&run).spawn().unwrap();
    let attached = biped(&["session", "lab", "--wait", "10"]).output().unwrap();
    assert!(attached.status.success(), "{}", String::from_utf8_lossy(&attached.stderr));
    let mut view = biped(&["view", "--session", "lab", "--port", "0"]).spawn().unwrap();
    let mut page = open(&address_of(&mut view), 1280, 760);
    page.until("trajectory.length > 200 && trajectory.end > 12");
    screenshot(&mut page, "picture-view");
    drop(page);
    kill(Pid::from_raw(walk.id().cast_signed()), Signal::SIGTERM).unwrap();
    walk.wait().unwrap();
    view.wait().unwrap();
}
