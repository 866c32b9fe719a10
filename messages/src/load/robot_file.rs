//! What a reader of a robot's file gives to its caller.

use crate::robot::Robot;

/// A robot as a file describes it, and what the program does not take from the file.
pub(super) struct RobotFile {
    pub(super) robot: Robot,
    /// Sentences on parts of the file that have no effect, and on values that look wrong.
    pub(super) notes: Vec<String>,
    /// Sentence on a joint that holds the robot in other programs.
    pub(super) mount: Option<String>,
}
