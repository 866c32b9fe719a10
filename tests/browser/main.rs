//! Claims about the pages, in a real browser. Screenshots are saved in `target/tmp/pages/`.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

#[path = "../common/chromium.rs"]
mod chromium;
#[path = "../common/mod.rs"]
mod common;
#[path = "../common/live.rs"]
mod live;

mod pictures;
mod plots;
mod saved;
mod session;
mod times;

use chromium::Browser;
use common::fresh_path;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

/// Saves and returns a screenshot.
fn screenshot(browser: &mut Browser, name: &str) -> Vec<u8> {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("pages");
    std::fs::create_dir_all(&folder).unwrap();
    let picture = browser.picture();
    std::fs::write(folder.join(name).with_extension("png"), &picture).unwrap();
    picture
}

/// Opens a page, and waits until view and plots are drawn.
fn open(address: &str, width: u32, height: u32) -> Browser {
    let mut page = Browser::open(address, width, height);
    page.until("performance.getEntriesByName('open').length === 1");
    page
}

/// Runs the walk with a report. Returns the folder and the address of the page.
fn report(settings: &[&str], flags: &[&str]) -> (PathBuf, String) {
    report_of("walk", settings, flags)
}

/// Runs any scene with a report. The robot may fall.
fn report_of(scene: &str, settings: &[&str], flags: &[&str]) -> (PathBuf, String) {
    let folder = fresh_path("page");
    let run = Command::new(env!("CARGO_BIN_EXE_biped"))
        .args(["run", scene, "--in-process", "--quiet", "--out"])
        .arg(&folder)
        .args(flags)
        .args(settings.iter().flat_map(|setting| ["--set", setting]))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    assert!(matches!(run.unwrap().code(), Some(0 | 7)));
    let address = format!("file://{}/report.html", folder.display());
    (folder, address)
}

/// The address of a running `biped view`.
fn address_of(view: &mut Child) -> String {
    let mut line = String::new();
    BufReader::new(view.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
    line.split_once("open ").unwrap().1.trim().into()
}
