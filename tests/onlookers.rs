//! Claims about those who look on, `biped view` and `biped top`: they find the session or say why not, and never hold it up.

#![expect(clippy::expect_used, clippy::panic, reason = "a test may panic")]

#[path = "common/live.rs"]
mod live;

use live::{Running, biped, eventually};
use messages::port::{Ask, Contract, Pace, PlantPort};
use messages::scene::Scene;
use messages::session::Session;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Output};

/// A session in lockstep that lasts longer than any test, with nobody of ours listening.
fn walking(name: &str) -> Running {
    let mut walk = Running::start(name, &["--set", "duration=100000"]);
    walk.leave();
    walk
}

/// The view of a session, its port and its token.
fn view(session: &Session) -> (Child, u16, String) {
    let mut view = biped(&["view", "--session", session.name(), "--port", "0"]).spawn().expect("the program starts");
    let mut line = String::new();
    BufReader::new(view.stdout.as_mut().expect("a pipe")).read_line(&mut line).expect("a line");
    let address = line.split_once("127.0.0.1:").and_then(|(_, rest)| rest.trim().split_once("/?token="));
    let (port, token) = address.unwrap_or_else(|| panic!("no address: {line}"));
    (view, port.parse().expect("a port"), token.into())
}

fn get(port: u16, path: &str) -> String {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).expect("a server");
    write!(stream, "GET {path} HTTP/1.0\r\nConnection: close\r\n\r\n").expect("listening");
    let mut answer = vec![];
    stream.read_to_end(&mut answer).expect("an answer");
    String::from_utf8_lossy(&answer).into()
}

#[test]
fn without_its_token_a_page_is_refused_and_a_reader_that_stalls_stalls_nobody() {
    let walk = walking("view");
    let (view, port, token) = view(&walk.session);
    assert!(get(port, &format!("/?token={token}")).contains("<title>biped: session test-"));
    assert!(get(port, &format!("/frames?token={token}")).contains("Next: "));
    for path in ["/".into(), "/?token=".into(), format!("/frames?token={}0", &token[1..]), "/ask".into()] {
        let answer = get(port, &path);
        assert!(answer.contains("403") && answer.contains("`biped view` printed last"), "{path}: {answer}");
    }
    // Browsers that ask for the page again and again and never read it: more than fits between us, from each.
    let waiting = || std::fs::read_dir(format!("/proc/{}/task", view.id())).expect("threads").count();
    let before = waiting();
    let stalled: Vec<TcpStream> = (0..8)
        .map(|_| {
            let mut stream = TcpStream::connect(("127.0.0.1", port)).expect("a server");
            let request = format!("GET /?token={token} HTTP/1.1\r\nHost: x\r\n\r\n");
            stream.write_all(request.repeat(12).as_bytes()).expect("listening");
            stream
        })
        .collect();
    eventually("eight answers that nobody takes", || waiting() >= before + 8);
    let begin = walk.ask(Ask::Resume).stamp.sim_ns;
    eventually("twenty seconds of lockstep", || walk.ask(Ask::Resume).stamp.sim_ns > begin + 20_000_000_000);
    assert!(get(port, &format!("/?token={token}")).contains("<title>"), "others wait for them");
    eventually("an end of patience with each", || waiting() <= before);
    for mut stream in stalled {
        let mut rest = vec![];
        let end = stream.read_to_end(&mut rest);
        assert!(
            end.is_err() || rest.len() < 12_000_000,
            "all of it was kept for whoever never read: {} bytes",
            rest.len()
        );
    }
    walk.end_with(view);
}

#[test]
fn a_session_that_does_not_say_what_its_scene_is_cannot_be_drawn_and_that_is_said() {
    // As a plant of somebody else's makes it, who has no word of ours.
    let session = Session::named(&format!("test-{}-silent", std::process::id())).expect("a good name");
    let contract = Contract::of(&Scene::default(), Pace::Lockstep);
    let plant = PlantPort::open(&session, &contract).expect("a session");
    for text in [None, Some("bodies = 1")] {
        text.map_or(Ok(()), |text| session.tell_scene(text)).expect("room");
        let Output { status, stderr, .. } =
            biped(&["view", "--session", session.name(), "--port", "0"]).output().expect("the program runs");
        let words = String::from_utf8_lossy(&stderr);
        assert!(status.code() == Some(5) && words.contains("does not say what its scene is"), "{status}: {words}");
        assert_eq!(words.lines().count(), 1, "{words}");
    }
    drop(plant);
}

#[test]
fn a_port_in_use_and_a_missing_session_are_a_sentence_and_an_exit_code() {
    let failure = |arguments: &[&str]| {
        let Output { status, stderr, .. } = biped(arguments).output().expect("the program runs");
        (status.code(), String::from_utf8_lossy(&stderr).into_owned())
    };
    for what in ["view", "top"] {
        let (code, words) = failure(&[what, "--session", "nowhere"]);
        assert!(code == Some(3) && words.contains("no session `nowhere`"), "{what}: {code:?} {words}");
    }
    let walk = walking("port");
    let taken = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = taken.local_addr().expect("its number").port().to_string();
    let (code, words) = failure(&["view", "--session", walk.session.name(), "--port", &port]);
    assert!(code == Some(2) && words.contains(&port) && words.contains("--port"), "{code:?} {words}");
    walk.end();
}

#[test]
fn top_tells_rates_gait_and_drives_in_plain_lines_in_a_pipe_and_in_place_on_a_terminal() {
    let walk = walking("top");
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
