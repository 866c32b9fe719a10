//! `biped info`: contents of a recording.

use super::reader::{Payload, RecordingReader};
use clap::Args;
use shared::exit::{Failure, check_interrupt};
use shared::output::print_text;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Arguments of `biped info`.
#[derive(Args)]
pub struct InfoArgs {
    /// The recording
    file: PathBuf,
    /// Print the recorded scene as TOML instead
    #[arg(long)]
    scene: bool,
}

/// Prints the contents.
///
/// # Errors
/// See [`RecordingReader::open`].
pub fn run(args: &InfoArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let mut reader = RecordingReader::open(&args.file)?;
    if args.scene {
        print_text(reader.metadata("scene"));
        return Ok(());
    }
    let scene = reader.scene().clone();
    let (mut counts, mut end, mut hash) = (BTreeMap::<Arc<str>, u64>::new(), 0, None);
    while let Some(message) = reader.next_message() {
        check_interrupt(stop)?;
        *counts.entry(message.topic).or_default() += 1;
        end = message.time;
        if let Payload::Truth(truth) = message.payload {
            hash = Some(truth.hash);
        }
    }
    let seconds = end as f64 * 1e-9;
    let line = |key: &str, value: String| print_text(format_args!("  {key:<13}{value}\n"));
    print_text(format_args!("{}\n", args.file.display()));
    line("written by", format!("biped {}, wire schema {}", reader.metadata("version"), reader.metadata("schema")));
    line("begun", reader.metadata("begun").into());
    line("robot", format!("{} bodies, {:.1} kg", scene.bodies.len(), scene.bodies.iter().map(|b| b.mass).sum::<f64>()));
    line("length", format!("{seconds:.3} s of {:.3} s, control at {:.0} Hz", scene.duration, scene.rate));
    line("size", size(&args.file));
    for (topic, count) in counts {
        line(&topic, format!("{count} messages"));
    }
    if let Some(hash) = hash {
        line("states", format!("hash {hash:016x}, as in summary.json"));
    }
    if let Some(why) = reader.truncated_by {
        line("cut short", format!("nothing can be read after {seconds:.3} s: {why}"));
    }
    Ok(())
}

fn size(file: &std::path::Path) -> String {
    let bytes = std::fs::metadata(file).map_or(0, |metadata| metadata.len());
    format!("{:.1} MB", bytes as f64 * 1e-6)
}
