//! `biped view FILE`: the page of a recording, as the report of that run has it.

use super::admission::{html, nothing};
use super::server::Door;
use crate::record::Recorder;
use crate::recording::Reader;
use crate::report;
use crate::summary::Summary;
use hyper::Method;
use hyper::body::Bytes;
use messages::load;
use messages::wire::Truth;
use shared::exit::{Exit, Failure, check_interrupt};
use shared::output::{log, print_text, refuse_overwriting_input, write_atomically, write_failure};
use shared::progress::BatchProgress;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

/// Between two looks at whether the user has had enough.
const LOOK: Duration = Duration::from_millis(50);
/// Records between two looks at how far it has been read.
const OFTEN: u64 = 1 << 12;

/// Writes the page, or serves it until the user's patience ends.
///
/// # Errors
/// See [`Reader::open`]; if there is nothing in it to show, the page cannot be written, or the port is in use.
pub fn run(file: &Path, out: Option<&Path>, place: SocketAddr, quiet: bool, stop: &AtomicBool) -> Result<(), Failure> {
    if let Some(out) = out {
        refuse_overwriting_input(file, out)?;
    }
    let page = page(file, quiet, stop)?;
    if let Some(out) = out {
        write_atomically(out, &page).map_err(|error| write_failure(out, &error))?;
        print_text(format_args!("{}: open {}\n", file.display(), out.display()));
        return Ok(());
    }
    let door = Door::open(place)?;
    print_text(format_args!("{}: open {}\n", file.display(), door.address));
    let page = Bytes::from(page);
    std::thread::spawn(move || {
        door.serve(move |method, path, _, _| match (method, path) {
            (&Method::GET, "/") => html(&page),
            _ => nothing(),
        });
    });
    while !stop.load(Relaxed) {
        std::thread::sleep(LOOK);
    }
    Ok(())
}

/// The page of the last run that is recorded.
fn page(file: &Path, quiet: bool, stop: &AtomicBool) -> Result<String, Failure> {
    let mut reader = Reader::open(file)?;
    let scene = reader.scene().clone();
    let (mut recorder, mut truth, mut runs, mut count) = (Recorder::new(&scene), Truth::default(), 0, 0);
    let megabytes = std::fs::metadata(file).map_or(0, |about| about.len() >> 20);
    let progress = BatchProgress::new(quiet, megabytes as usize, 0, "MB");
    let mut run = None;
    while reader.next_truth(&mut truth).is_some() {
        if run.replace(truth.stamp.run) != Some(truth.stamp.run) {
            (recorder, runs) = (Recorder::new(&scene), runs + 1);
        }
        recorder.push(&truth);
        count += 1;
        if count % OFTEN == 0 {
            progress.set_done(reader.read() >> 20);
            check_interrupt(stop)?;
        }
    }
    progress.finish();
    if recorder.rows.is_empty() {
        return Err(Failure::new(Exit::Usage, format!("{}: there is nothing in it to be shown", file.display())));
    }
    if runs > 1 {
        log(format_args!("{} has {runs} runs: the page shows the last", file.display()));
    }
    let name = file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let mut summary = Summary::new(&name, &recorder, Duration::ZERO, 0);
    if let Some(why) = reader.cut {
        log(format_args!("{} is cut short: {why}; the page has all before that", file.display()));
        summary.cut_short_by = Some("the recording ends here");
    }
    Ok(report::page(&report::figures(&recorder), &recorder, &summary, &scene, &load::text(&scene)))
}
