//! A new controller in Rust.

use super::{NewFile, Template, code, in_clone, usage};
use controller::foreign;
use shared::exit::Failure;
use std::path::Path;

/// A package with a controller. With `tree`, its crates come from there.
pub fn controller(folder: &Path, from: Template, tree: Option<&Path>) -> Result<Vec<NewFile>, Failure> {
    if matches!(from, Template::Walk) {
        return Err(usage(
            "--from walk is there in Python and in C: in Rust, call biped_controller::Controller in `tick`",
        ));
    }
    let name = folder.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let first = name.starts_with(|first: char| first.is_ascii_lowercase());
    if !first || !name.bytes().all(|byte| matches!(byte, b'a'..=b'z' | b'0'..=b'9' | b'-' | b'_')) {
        return Err(usage(format!(
            "{name:?} cannot name a Rust package: use lower-case letters, digits, - and _, beginning with a letter"
        )));
    }
    let main = format!(
        "//! A controller for biped: a spring and a damper at each joint hold the robot upright. README.md says how to run it.\n\n\
         #[cfg(test)]\nmod tests;\n\n{}",
        code(foreign::RUST_STAND, "use ")
    );
    Ok(vec![
        ("Cargo.toml", manifest(name, tree)?),
        ("README.md", readme(name, folder, tree.is_some())),
        ("src/main.rs", main),
        ("src/tests.rs", TEST.into()),
    ])
}

fn manifest(name: &str, tree: Option<&Path>) -> Result<String, Failure> {
    let patch = match tree {
        Some(tree) => {
            let messages = in_clone(tree, "messages/Cargo.toml")?.join("messages");
            format!(
                "\n[patch.crates-io]\nbiped-messages.path = {:?} # instead of crates.io\n",
                messages.display().to_string()
            )
        }
        None => String::new(),
    };
    Ok(format!(
        "[package]\nname = \"{name}\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\n\
         [dependencies]\nctrlc = {{ version = \"3.5.2\", features = [\"termination\"] }} # TERM and Ctrl-C\n\
         messages = {{ package = \"biped-messages\", version = \"{version}\" }} # both sides of a session need the same version\n\n\
         [workspace] # a package of its own, wherever its folder is\n{patch}",
        version = env!("CARGO_PKG_VERSION")
    ))
}

fn readme(name: &str, folder: &Path, has_tree: bool) -> String {
    let folder = folder.display();
    let program = format!("{folder}/target/release/{name}");
    let build = format!("cargo build --release --manifest-path {folder}/Cargo.toml");
    let unpublished = "If crates.io does not have biped-messages yet, make this folder again by\n\
                       `biped new controller NAME --rust --tree CLONE`, with a clone of the repository of biped.\n";
    format!(
        "# A controller for biped\n\n\
         {build}\n\
         biped run stand --controller {program}   # started by biped\n\
         biped plant stand --session lab & {program} --session lab   # started by hand, for example in a debugger\n\
         biped conform --controller {program}     # checks it against the rules of the wire\n\
         cargo test --release --manifest-path {folder}/Cargo.toml\n{}",
        if has_tree { String::new() } else { format!("\n{unpublished}") }
    )
}

const TEST: &str = r#"//! Claims about the controller.

use super::*;

#[test]
fn eight_finite_torques_within_the_limit() {
    let scene = messages::load::built_in("stand").expect("a built-in scene");
    let mut stand = Stand::new(&scene);
    let counts = stand.target.map(|angle| (angle / stand.count).round() as i64);
    let torques = stand.tick(&Encoders { counts }).torque;
    assert!(torques.iter().all(|torque| torque.abs() <= scene.plant.torque_limit), "{torques:?}");
}
"#;
