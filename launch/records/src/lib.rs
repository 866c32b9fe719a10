//! The results of a run and the ways to view them: summary, report, MCAP recording, 3-D page, terminal monitor.

pub mod analysis;
pub mod recording;
pub mod report;
pub mod summary;
pub mod top;
pub mod trajectory_csv;
pub mod view;
