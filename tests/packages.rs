//! Every package of the workspace can be published: it has a description, holds its licences, and embeds no file of another package.
//! `cargo publish --dry-run --workspace` (CONTRIBUTING.md) builds all of them from what they hold, which takes several minutes.

#![expect(clippy::expect_used, reason = "a test may panic")]

use serde_json::Value;
use std::path::Path;
use std::process::Command;

fn cargo(args: &[&str]) -> String {
    let output =
        Command::new(env!("CARGO")).args(args).current_dir(env!("CARGO_MANIFEST_DIR")).output().expect("cargo");
    assert!(output.status.success(), "cargo {args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

/// The packages of this workspace that can be published, as `cargo metadata` describes them.
fn packages() -> Vec<Value> {
    let all: Value = serde_json::from_str(&cargo(&["metadata", "--no-deps", "--format-version=1"])).expect("JSON");
    let is_published = |package: &&Value| package["publish"] != Value::Array(vec![]);
    all["packages"].as_array().expect("packages").iter().filter(is_published).cloned().collect()
}

fn name(package: &Value) -> &str {
    package["name"].as_str().expect("a name")
}

/// The files that a package would hold.
fn files(package: &Value) -> Vec<String> {
    cargo(&["package", "--list", "--allow-dirty", "--package", name(package)]).lines().map(String::from).collect()
}

/// A path without `..`, from its text alone, because links in a package count as files. A path that leaves the package keeps its `..`.
fn normal(path: &Path) -> String {
    let mut parts: Vec<&str> = vec![];
    for part in path.to_str().expect("text").split('/') {
        match part {
            ".." if parts.last().is_some_and(|last| *last != "..") => drop(parts.pop()),
            _ => parts.push(part),
        }
    }
    parts.join("/")
}

/// Arguments of `include_str!` in a text that are plain paths.
fn included(code: &str) -> impl Iterator<Item = &str> {
    code.split("include_str!(\"").skip(1).filter_map(|rest| rest.split('"').next())
}

#[test]
fn every_package_has_a_description() {
    for package in packages() {
        for key in ["description", "license", "documentation", "readme", "rust_version"] {
            assert!(package[key].as_str().is_some_and(|text| !text.is_empty()), "{}: no {key}", name(&package));
        }
        for key in ["keywords", "categories"] {
            let count = package[key].as_array().map_or(0, Vec::len);
            assert!((1..=5).contains(&count), "{}: {count} {key}; crates.io takes 1 to 5", name(&package));
        }
        assert!(name(&package).starts_with("biped"), "{}: a name that others may have", name(&package));
        for dependency in package["dependencies"].as_array().expect("dependencies") {
            let lacks_version = dependency["path"].is_string() && dependency["req"] == "*";
            assert!(!lacks_version, "{}: no version of {}", name(&package), dependency["name"]);
        }
    }
}

#[test]
fn every_package_holds_its_licences_and_embedded_files() {
    for package in packages() {
        let files = files(&package);
        for file in ["LICENSE-MIT", "LICENSE-APACHE", "README.md"] {
            assert!(files.iter().any(|held| held == file), "{} lacks {file}", name(&package));
        }
        let manifest = Path::new(package["manifest_path"].as_str().expect("a path"));
        let folder = manifest.parent().expect("a folder");
        for file in files.iter().filter(|file| file.ends_with(".rs") && !file.starts_with("tests/")) {
            let code = std::fs::read_to_string(folder.join(file)).expect("a file that is listed");
            let program = code.split("#[cfg(test)]").next().expect("a part");
            let is_program = file.starts_with("src/") || file.starts_with("launch/");
            assert!(
                !is_program || !program.contains("CARGO_MANIFEST_DIR"),
                "{file} looks for files where it was built"
            );
            for path in included(&code) {
                let held = normal(&Path::new(file).parent().expect("a folder").join(path));
                assert!(files.contains(&held), "{}: {file} embeds {held}, which the package lacks", name(&package));
            }
        }
    }
}

#[test]
fn the_messages_hold_the_built_in_scenes() {
    let packages = packages();
    let messages = packages.iter().find(|package| name(package) == "biped-messages").expect("a package");
    let scenes = files(messages).into_iter().filter(|file| file.starts_with("scenes/") && file.ends_with(".toml"));
    assert_eq!(scenes.count(), messages::load::SCENES.len(), "a scene without a line in built_in.rs, or the reverse");
    assert_eq!(messages::load::built_in("walk").expect("a scene").rate, 1000.0);
    let error = messages::load::built_in("wakl").expect_err("no such scene").to_string();
    assert!(error.contains("`wakl`") && error.contains("walk"), "{error}");
}
