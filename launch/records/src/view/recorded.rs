//! `biped view FILE`: the page of a recording, equal to the page in the report of that run.

use super::access::{html, not_found};
use super::server::PageServer;
use crate::analysis::RunAnalysis;
use crate::recording::RecordingReader;
use crate::report;
use crate::summary::Summary;
use hyper::Method;
use hyper::body::Bytes;
use messages::load;
use messages::wire::Truth;
use shared::exit::{Exit, Failure, check_interrupt};
use shared::output::{create_failure, log, print_text, refuse_overwriting_input, write_atomically};
use shared::progress::BatchProgress;
use shared::thread;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

/// Time between checks whether the user has stopped the program.
const POLL_INTERVAL: Duration = Duration::from_millis(50);
/// Number of records between updates of the progress display.
const RECORDS_PER_UPDATE: u64 = 1 << 12;

/// Writes the page into a file, or serves it until the user stops the program.
///
/// # Errors
/// See [`RecordingReader::open`]. Also if the recording is empty, the page cannot be written, or the port is in use.
pub fn run(
    file: &Path,
    out: Option<&Path>,
    address: SocketAddr,
    quiet: bool,
    stop: &AtomicBool,
) -> Result<(), Failure> {
    if let Some(out) = out {
        refuse_overwriting_input(file, out)?;
    }
    let page = page(file, quiet, stop)?;
    if let Some(out) = out {
        write_atomically(out, &page).map_err(|error| create_failure(out, &error))?;
        print_text(format_args!("{}: open {}\n", file.display(), out.display()));
        return Ok(());
    }
    let server = PageServer::open(address)?;
    print_text(format_args!("{}: open {}\n", file.display(), server.url));
    let page = Bytes::from(page);
    thread::start(move || {
        server.serve(move |method, path, _, _| match (method, path) {
            (&Method::GET, "/") => html(&page),
            _ => not_found(),
        });
    })?;
    while !stop.load(Relaxed) {
        std::thread::sleep(POLL_INTERVAL);
    }
    Ok(())
}

/// The page of the last run in the recording.
fn page(file: &Path, quiet: bool, stop: &AtomicBool) -> Result<String, Failure> {
    let mut reader = RecordingReader::open(file)?;
    let scene = reader.scene().clone();
    let (mut analysis, mut truth, mut runs, mut count) = (RunAnalysis::new(&scene), Truth::default(), 0, 0);
    let megabytes = std::fs::metadata(file).map_or(0, |metadata| metadata.len() >> 20);
    let progress = BatchProgress::new(quiet, megabytes as usize, 0, "MB");
    let mut run = None;
    while reader.next_truth(&mut truth).is_some() {
        if run.replace(truth.stamp.run) != Some(truth.stamp.run) {
            (analysis, runs) = (RunAnalysis::new(&scene), runs + 1);
        }
        analysis.push(&truth);
        count += 1;
        if count % RECORDS_PER_UPDATE == 0 {
            progress.set_done(reader.bytes_read() >> 20);
            check_interrupt(stop)?;
        }
    }
    progress.finish();
    if analysis.rows.is_empty() {
        return Err(Failure::new(Exit::Usage, format!("{}: the recording contains no valid records", file.display())));
    }
    if runs > 1 {
        log(format_args!("{} contains {runs} runs: the page shows the last one", file.display()));
    }
    let name = file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let mut summary = Summary::new(&name, &analysis, Duration::ZERO, 0);
    if let Some(why) = reader.truncated_by {
        log(format_args!("{} is cut short: {why}; the page shows everything before that", file.display()));
        summary.cut_short_by = Some("the recording ends here");
    }
    Ok(report::page(&report::figures(&analysis), &analysis, &summary, &scene, &load::text(&scene)))
}
