//! What is made of the truth while a run goes on: record, progress, tape; and whether it goes on.

use messages::port::RecorderPort;
use messages::scene::Scene;
use messages::wire::{Stamp, Truth};
use records::analysis::RunAnalysis;
use records::recording::{McapRecorder, RecordingEnd};
use shared::exit::{Exit, Failure, unless};
use shared::output::tell;
use shared::progress::Progress;
use std::sync::atomic::AtomicBool;

/// Whatever listens to a run.
pub struct Watch {
    scene: Scene,
    /// Makes the recorder of a run.
    record: fn(&Scene) -> RunAnalysis,
    pub recorder: RunAnalysis,
    pub progress: Progress,
    pub latest: Stamp,
    pub tape: Option<McapRecorder>,
    /// Why that has ended already.
    pub end: Option<RecordingEnd>,
    /// Gaps in the sequence: records that were dropped on the way.
    pub lost: u64,
}

impl Watch {
    /// Only a report needs rows.
    pub fn new(scene: &Scene, reports: bool, quiet: bool) -> Watch {
        let record = if reports { RunAnalysis::new } else { RunAnalysis::without_rows };
        let (recorder, progress) = (record(scene), Progress::new(scene, quiet));
        Watch {
            scene: scene.clone(),
            record,
            recorder,
            progress,
            latest: Stamp::default(),
            tape: None,
            end: None,
            lost: 0,
        }
    }

    /// Takes the next truth. One of another run, after a reset or of a plant started anew, begins the record anew.
    pub fn take(&mut self, truth: &Truth) {
        if self.latest.run != truth.stamp.run && self.latest.seq > 0 {
            let requests = std::mem::take(&mut self.recorder.requests); // the reset is one of them
            self.recorder = (self.record)(&self.scene);
            self.recorder.requests = requests;
            self.latest.seq = 0;
        }
        self.lost += truth.stamp.seq.saturating_sub(self.latest.seq.saturating_add(1)); // another program may count otherwise
        self.latest = truth.stamp;
        self.recorder.push(truth);
        self.progress.update(truth);
        let written = self.tape.as_mut().map_or(Ok(()), |tape| tape.push(truth));
        self.outlive(written);
    }

    /// Goes on without a recording that has ended.
    fn outlive(&mut self, written: Result<(), RecordingEnd>) {
        if let Err(end) = written {
            self.progress.bar.suspend(|| tell(format_args!("{}; the run goes on", end.message)));
            (self.tape, self.end) = (None, Some(end));
        }
    }

    /// Takes all there is.
    pub fn drain(&mut self, port: &mut RecorderPort) -> Result<(), Failure> {
        while let Some(truth) = port.read()? {
            self.hear_requests(port)?; // that came before it
            self.take(&truth);
        }
        self.hear_requests(port)?;
        self.show();
        Ok(())
    }

    fn hear_requests(&mut self, port: &RecorderPort) -> Result<(), Failure> {
        while let Some(served) = port.served()? {
            self.recorder.requests.push(&served);
            let written = self.tape.as_mut().map_or(Ok(()), |tape| tape.served(&served));
            self.outlive(written);
        }
        Ok(())
    }

    /// Shows the latest of it.
    pub fn show(&mut self) {
        if let Some(last) = &self.recorder.last {
            self.progress.show(&last.truth);
        }
    }
}

/// Whether a run has anything more to show.
///
/// # Errors
/// A fall seen to its end, or a wish of the user's to stop.
pub fn goes_on(recorder: &RunAnalysis, stop: &AtomicBool) -> Result<(), Failure> {
    unless(stop)?;
    recorder.time_of_completed_fall().map_or(Ok(()), |time| Err(fell(time)))
}

pub fn fell(time: f64) -> Failure {
    Failure::new(Exit::Fell, format!("the robot fell after {time:.2} s"))
}
