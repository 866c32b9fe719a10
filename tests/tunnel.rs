//! Claims about sessions across two machines. The tunnel itself is a foreign program that takes long to build. These tests check its
//! configuration; docs/WIRE.md documents a real transfer.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod common;

#[path = "common/live.rs"]
mod live;

use common::fresh_path;
use live::{Running, biped, eventually};
use messages::port::{Contract, Pace, PlantPort};
use messages::scene::Scene;
use messages::session::Session;
use std::os::unix::fs::PermissionsExt;
use std::process::Output;

fn tunnel(session: &str, path: &str) -> (Option<i32>, String) {
    let arguments = ["tunnel", "--session", session, "--listen", "tcp/127.0.0.1:7447"];
    let Output { status, stderr, .. } = biped(&arguments).env("PATH", path).output().expect("the program starts");
    (status.code(), String::from_utf8_lossy(&stderr).into_owned())
}

#[test]
fn a_missing_session_and_a_missing_tunnel_program_are_reported() {
    let (code, printed) = tunnel("nobody", "");
    assert!(code == Some(3) && printed.contains("`nobody` is not running"), "{code:?}: {printed}");
    let walk = Running::start("untunnelled", &["--realtime"]);
    let (code, printed) = tunnel(walk.session.name(), "");
    assert!(code == Some(2) && printed.contains("cargo install iceoryx2-"), "{code:?}: {printed}");
    walk.end();
}

#[test]
fn the_tunnel_gets_the_location_of_the_session_and_ends_with_it() {
    let folder = fresh_path("tunnel");
    std::fs::create_dir(&folder).expect("a folder");
    let (program, received) = (folder.join("iox2-link-tunnel-zenoh"), folder.join("received"));
    let script = format!(
        "#!/bin/sh\n(echo \"$@\"; cat config/iceoryx2.toml zenoh.json5) > {0}.new; mv {0}.new {0}; exec sleep 60\n",
        received.display()
    );
    std::fs::write(&program, script).expect("a script");
    std::fs::set_permissions(&program, PermissionsExt::from_mode(0o755)).expect("a script");
    let walk = Running::start("tunnelled", &["--realtime"]);
    let path = format!("{}:{}", folder.display(), std::env::var("PATH").expect("a path"));
    let arguments = ["tunnel", "--session", walk.session.name(), "--listen", "tcp/127.0.0.1:7447"];
    let tunnel = biped(&arguments).env("PATH", path).spawn().expect("the program starts");
    eventually("the start of the tunnel", || received.exists());
    let printed = std::fs::read_to_string(&received).expect("its arguments");
    for word in ["--poll 1", "--allow biped/sensors --allow biped/command", "/dev/shm/biped_", "tcp/127.0.0.1:7447"] {
        assert!(printed.contains(word), "{word:?} is not in {printed}");
    }
    walk.end();
    let Output { status, stderr, .. } = tunnel.wait_with_output().expect("it ends");
    assert_eq!(status.code(), Some(0), "{}", String::from_utf8_lossy(&stderr));
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn a_second_plant_is_refused_with_and_without_a_tunnel() {
    let contract = Contract::of(&Scene::default(), Pace::Lockstep);
    for tunnel in [true, false] {
        let session = Session::unique();
        let _first = PlantPort::open(&session, &contract.with_tunnel(tunnel)).expect("a plant");
        assert!(PlantPort::open(&session, &contract.with_tunnel(tunnel)).is_err());
    }
}
