//! Claims about observers, `biped view` and `biped top`: they find the session or say why not, and never block it.

#[path = "common/live.rs"]
mod live;

use live::{Running, biped};
use messages::port::{Contract, Pace, PlantPort};
use messages::scene::Scene;
use messages::session::Session;
use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::process::{Command, Output};

#[test]
fn a_session_without_a_scene_description_is_refused_by_view() {
    // A foreign plant can open a session without a scene description.
    let session = Session::named(&format!("test-{}-silent", std::process::id())).expect("a good name");
    let contract = Contract::of(&Scene::default(), Pace::Lockstep);
    let plant = PlantPort::open(&session, &contract).expect("a session");
    for text in [None, Some("bodies = 1")] {
        text.map_or(Ok(()), |text| session.publish_scene(text)).expect("room");
        let Output { status, stderr, .. } =
            biped(&["view", "--session", session.name(), "--port", "0"]).output().expect("the program runs");
        let printed = String::from_utf8_lossy(&stderr);
        assert!(status.code() == Some(5) && printed.contains("has published no scene"), "{status}: {printed}");
        assert_eq!(printed.lines().count(), 1, "{printed}");
    }
    drop(plant);
}

#[test]
fn a_used_port_and_a_missing_session_give_a_sentence_and_an_exit_code() {
    let failure = |arguments: &[&str]| {
        let Output { status, stderr, .. } = biped(arguments).output().expect("the program runs");
        (status.code(), String::from_utf8_lossy(&stderr).into_owned())
    };
    for what in ["view", "top"] {
        let (code, printed) = failure(&[what, "--session", "nowhere"]);
        assert!(code == Some(3) && printed.contains("no session `nowhere`"), "{what}: {code:?} {printed}");
    }
    let walk = Running::unobserved("port");
    let taken = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = taken.local_addr().expect("its number").port().to_string();
    let (code, printed) = failure(&["view", "--session", walk.session.name(), "--port", &port]);
    assert!(code == Some(2) && printed.contains(&port) && printed.contains("--port"), "{code:?} {printed}");
    for (address, fault) in
        [("nowhere", "such as 0.0.0.0 or ::1"), ("192.0.2.1", "--listen needs an address of this machine")]
    {
        let (code, printed) = failure(&["view", "--session", walk.session.name(), "--listen", address, "--port", "0"]);
        assert!(code == Some(2) && printed.contains(address) && printed.contains(fault), "{code:?} {printed}");
    }
    walk.end();
}

#[test]
fn top_prints_plain_lines_to_a_pipe_and_updates_in_place_on_a_terminal() {
    let walk = Running::unobserved("top");
    let mut top = biped(&["top", "--session", walk.session.name()]).spawn().expect("the program starts");
    let lines: Vec<String> =
        BufReader::new(top.stdout.as_mut().expect("a pipe")).lines().take(3).map(|line| line.expect("text")).collect();
    let last = &lines[2];
    assert!(
        ["t ", " Hz ", "run", " foot", "E2 -0.0", "age 0", "refused 0"].iter().all(|part| last.contains(part)),
        "{last}"
    );
    assert!(!last.contains('\x1b'), "{last}");
    top.kill().expect("our own child");
    top.wait().expect("it ends");

    let on_terminal = |colours: bool| {
        let program = format!("timeout 2 {} top --session {}", env!("CARGO_BIN_EXE_biped"), walk.session.name());
        let mut terminal = Command::new("script");
        terminal.args(["-qec", &program, "/dev/null"]).env("TERM", "xterm").env_remove("NO_COLOR");
        let output = if colours { terminal.output() } else { terminal.env("NO_COLOR", "1").output() };
        String::from_utf8_lossy(&output.expect("util-linux").stdout).into_owned()
    };
    let (coloured, plain) = (on_terminal(true), on_terminal(false));
    assert!(plain.contains("energies") && plain.matches("pace").count() > 2, "{plain}");
    assert!(plain.contains("\x1b[") && !plain.contains("\x1b[32m"), "in place, without colours: {plain:?}");
    assert!(coloured.contains("\x1b[32m"), "{coloured:?}");
    walk.end();
}
