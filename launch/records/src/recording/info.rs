//! `biped info`: contents of a recording.

use super::reader::{Payload, RecordingReader};
use clap::Args;
use messages::wire::Truth;
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
    let (mut counts, mut end, mut last) = (BTreeMap::<Arc<str>, u64>::new(), 0, None::<Box<Truth>>);
    let mut runs = 0;
    while let Some(message) = reader.next_message() {
        check_interrupt(stop)?;
        *counts.entry(message.topic).or_default() += 1;
        end = message.time;
        if let Payload::Truth(truth) = message.payload {
            runs += u32::from(last.is_none_or(|last| last.stamp.run != truth.stamp.run));
            last = Some(truth);
        }
    }
    let seconds = end as f64 * 1e-9;
    let line = |key: &str, value: String| print_text(format_args!("  {key:<13}{value}\n"));
    print_text(format_args!("{}\n", args.file.display()));
    line("written by", format!("biped {}, wire schema {}", reader.metadata("version"), reader.metadata("schema")));
    line("begun", reader.metadata("begun").into());
    line("robot", format!("{} bodies, {:.1} kg", scene.bodies.len(), scene.bodies.iter().map(|b| b.mass).sum::<f64>()));
    let length = match &last {
        Some(last) if runs > 1 => format!("{seconds:.3} s in {runs} runs, the last {:.3} s", last.stamp.time()),
        _ => format!("{seconds:.3} s"),
    };
    line("length", format!("{length} of {:.3} s, control at {:.0} Hz", scene.duration, scene.rate));
    line("size", size(&args.file));
    for (topic, count) in counts {
        line(&topic, format!("{count} message{}", if count == 1 { "" } else { "s" }));
    }
    if let Some(last) = last {
        line("states", format!("hash {:016x}, that of summary.json if the recording is whole", last.hash));
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
