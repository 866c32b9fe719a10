//! A contact problem that ended a run, as a file.

use crate::whole::write_whole;
use messages::scene::Law;
use plant::PlantError;
use plant::contact::Problem;
use plant::process::PlantProcessError;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A contact problem, and what became of it in a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Integration step of the run.
    pub step: u64,
    /// Simulated time [s].
    pub time: f64,
    /// Law that did not solve it.
    pub law: Law,
    /// Residual that the law left; absent if it left no impulse at all.
    pub residual: Option<f64>,
    /// Residual that was asked for.
    pub tolerance: f64,
    /// The problem.
    pub problem: Problem,
}

impl Case {
    /// The case that a plant failed with, if it did with one.
    pub fn of(error: PlantProcessError) -> Option<Case> {
        match error {
            PlantProcessError::Plant(PlantError::Unsolved { step, time, law, residual, tolerance, problem }) => {
                let residual = Some(residual).filter(|residual| residual.is_finite());
                Some(Case { step, time, law, residual, tolerance, problem: *problem })
            }
            _ => None,
        }
    }

    /// Writes it to a file in the working folder; says where, or why not.
    pub fn keep(&self) -> String {
        let path = PathBuf::from(format!("contact-{}-step-{}.json", std::process::id(), self.step));
        let text = serde_json::to_string_pretty(self).unwrap_or_default();
        match write_whole(&path, &(text + "\n")) {
            Ok(()) => format!("; it is in {0}: see `biped contact {0}`", path.display()),
            Err(error) => format!("; it cannot be written: {error}"),
        }
    }

    /// Reads a case.
    ///
    /// # Errors
    /// Why the file cannot be read, or is no contact problem.
    pub fn read(file: &Path) -> Result<Case, String> {
        let text = messages::file::text(file).map_err(|error| error.to_string())?;
        let case: Case = serde_json::from_str(&text).map_err(|error| format!("not a contact problem: {error}"))?;
        case.problem.check().map_err(|reason| format!("not a contact problem: {reason}"))?;
        Ok(case)
    }
}
