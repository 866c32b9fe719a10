//! Monitoring a run: its truth goes to the recorder, the progress display and the recording file.

use super::set_points::SetPoints;
use messages::port::RecorderPort;
use messages::scene::Scene;
use messages::wire::{Stamp, Truth};
use records::analysis::RunAnalysis;
use records::recording::{McapRecorder, RecordingEnd};
use shared::exit::{Exit, Failure, check_interrupt};
use shared::output::log;
use shared::progress::RunProgress;
use std::sync::atomic::AtomicBool;

/// All receivers of the truth of a run.
pub struct RunMonitor {
    scene: Scene,
    /// Creates the recorder of a new run.
    new_recorder: fn(&Scene) -> RunAnalysis,
    pub recorder: RunAnalysis,
    pub progress: RunProgress,
    /// Stamp of the latest truth.
    pub latest: Stamp,
    /// The set-points that were changed by request.
    pub set_points: SetPoints,
    /// The recording file, as long as it is written.
    pub recording: Option<McapRecorder>,
    /// Why the recording file ended before the run, if it did.
    pub recording_end: Option<RecordingEnd>,
    /// Number of control periods whose truth was dropped by the transport.
    pub lost: u64,
}

impl RunMonitor {
    /// A monitor of a run of `scene`. The recorder keeps rows only for a report.
    pub fn new(scene: &Scene, has_report: bool, quiet: bool) -> RunMonitor {
        let new_recorder = if has_report { RunAnalysis::new } else { RunAnalysis::without_rows };
        let (recorder, progress) = (new_recorder(scene), RunProgress::new(scene, quiet));
        RunMonitor {
            scene: scene.clone(),
            new_recorder,
            recorder,
            progress,
            latest: Stamp::default(),
            set_points: SetPoints::default(),
            recording: None,
            recording_end: None,
            lost: 0,
        }
    }

    /// Records the next truth. If it belongs to a new run, after a reset or a restart of the plant, the recorder starts again.
    pub fn record(&mut self, truth: &Truth) {
        if self.latest.run != truth.stamp.run && self.latest.seq > 0 {
            let requests = std::mem::take(&mut self.recorder.requests); // they include the reset
            self.recorder = (self.new_recorder)(&self.scene);
            self.recorder.requests = requests;
            self.latest.seq = 0;
        }
        self.lost += truth.stamp.seq.saturating_sub(self.latest.seq.saturating_add(1)); // a foreign plant may number them differently
        self.latest = truth.stamp;
        self.progress.update(truth);
        if self.recorder.time_of_completed_fall().is_some() {
            return; // the plant goes on until it is stopped: analysis and recording end with the same control period
        }
        self.recorder.push(truth);
        let written = self.recording.as_mut().map_or(Ok(()), |tape| tape.push(truth));
        self.continue_without_recording(written);
    }

    /// If the recording file has ended, prints why, and continues the run without it.
    fn continue_without_recording(&mut self, written: Result<(), RecordingEnd>) {
        if let Err(end) = written {
            self.progress.bar.suspend(|| log(format_args!("{}; the run continues", end.message)));
            (self.recording, self.recording_end) = (None, Some(end));
        }
    }

    /// Receives and records all messages that are waiting, and updates the progress display.
    pub fn drain(&mut self, port: &mut RecorderPort) -> Result<(), Failure> {
        while let Some(truth) = port.read()? {
            self.receive_requests(port)?; // those before this truth
            self.record(&truth);
        }
        self.receive_requests(port)?;
        self.show_progress();
        Ok(())
    }

    fn receive_requests(&mut self, port: &RecorderPort) -> Result<(), Failure> {
        while let Some(served) = port.served()? {
            self.set_points.note(&served);
            self.recorder.requests.push(&served);
            let written = self.recording.as_mut().map_or(Ok(()), |tape| tape.served(&served));
            self.continue_without_recording(written);
        }
        Ok(())
    }

    /// Updates the progress display from the latest truth.
    pub fn show_progress(&mut self) {
        if let Some(last) = &self.recorder.last {
            self.progress.show(&last.truth);
        }
    }
}

/// Checks whether a run should continue.
///
/// # Errors
/// If the robot has fallen and come to rest, or the user has interrupted the program.
pub fn check_run(recorder: &RunAnalysis, stop: &AtomicBool) -> Result<(), Failure> {
    check_interrupt(stop)?;
    recorder.time_of_completed_fall().map_or(Ok(()), |time| Err(fall_failure(time)))
}

/// The failure that reports a fall at a simulated time [s].
pub fn fall_failure(time: f64) -> Failure {
    Failure::new(Exit::Fell, format!("the robot fell after {time:.2} s"))
}
