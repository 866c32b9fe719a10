//! The contact problem that ended a run, as a JSON file.

use crate::atomic_file::write_atomically;
use messages::scene::Law;
use plant::PlantError;
use plant::contact::Problem;
use plant::process::PlantProcessError;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A contact problem that a law did not solve to the tolerance, and where in the run it occurred.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UnsolvedProblem {
    /// Integration step of the run.
    pub step: u64,
    /// Simulated time [s].
    pub time: f64,
    /// Contact law that did not solve it.
    pub law: Law,
    /// Residual of the law's best impulse; absent if the law returned no impulse.
    pub residual: Option<f64>,
    /// Largest residual that the scene allows.
    pub tolerance: f64,
    /// The problem.
    pub problem: Problem,
}

impl UnsolvedProblem {
    /// The problem inside a plant's error, if the error is about one.
    pub fn from_error(error: PlantProcessError) -> Option<UnsolvedProblem> {
        match error {
            PlantProcessError::Plant(PlantError::Unsolved { step, time, law, residual, tolerance, problem }) => {
                let residual = Some(residual).filter(|residual| residual.is_finite());
                Some(UnsolvedProblem { step, time, law, residual, tolerance, problem: *problem })
            }
            _ => None,
        }
    }

    /// Writes the problem to a file in the working folder. Returns the end of an error message: the path, or why there is no file.
    pub fn save(&self) -> String {
        let path = PathBuf::from(format!("contact-{}-step-{}.json", std::process::id(), self.step));
        let text = serde_json::to_string_pretty(self).unwrap_or_default();
        match write_atomically(&path, &(text + "\n")) {
            Ok(()) => format!("; it is in {0}: see `biped contact {0}`", path.display()),
            Err(error) => format!("; it cannot be written: {error}"),
        }
    }

    /// Reads a problem from a file.
    ///
    /// # Errors
    /// If the file cannot be read, or holds no valid contact problem.
    pub fn read(file: &Path) -> Result<UnsolvedProblem, String> {
        let text = messages::file::text(file).map_err(|error| error.to_string())?;
        let unsolved: UnsolvedProblem =
            serde_json::from_str(&text).map_err(|error| format!("not a contact problem: {error}"))?;
        unsolved.problem.check().map_err(|reason| format!("not a contact problem: {reason}"))?;
        Ok(unsolved)
    }
}
