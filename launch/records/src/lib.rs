//! What a run leaves, and how it is looked at: figures, report, recording, page, terminal.

pub mod analysis;
pub mod recording;
pub mod report;
pub mod summary;
pub mod top;
pub mod trajectory_csv;
pub mod view;
