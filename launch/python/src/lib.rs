//! The Python package `biped`: plant, controller, recordings and sessions with NumPy arrays.
//!
//! This crate converts between Python and the crates of the workspace and computes nothing itself. Its Python half is `launch/python/biped`.
//!
//! | what | where |
//! |---|---|
//! | exceptions | `error.rs` |
//! | numbers and texts of arguments | `arguments.rs` |
//! | arrays in and out, layout of messages | `arrays.rs` |
//! | `Scene` | `scene.rs` |
//! | `Plant`, its run, and its state | `plant.rs`, `run.rs`, `snapshot.rs` |
//! | `PlantBatch`: many plants on all cores | `batch.rs`, `helper_threads.rs` |
//! | `Controller` | `controller.rs` |
//! | `Session`: a running session | `session.rs`, `ports.rs`, `owned.rs`, `interrupt.rs` |
//! | `PlantSession`: a plant of one's own in a session | `plant_session.rs`, `lockstep_plant.rs` |
//! | recordings | `recording.rs` |

mod arguments;
mod arrays;
mod batch;
mod controller;
mod error;
mod helper_threads;
mod interrupt;
mod lockstep_plant;
mod owned;
mod plant;
mod plant_session;
mod ports;
mod recording;
mod run;
mod scene;
mod session;
mod snapshot;

use pyo3::prelude::*;

/// The compiled half of the package `biped`.
#[pymodule]
mod _biped {
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        crate::error::set_exit_codes(module.py())
    }

    #[pymodule_export]
    use crate::arrays::{layout, names};
    #[pymodule_export]
    use crate::batch::PlantBatch;
    #[pymodule_export]
    use crate::controller::Controller;
    #[pymodule_export]
    use crate::error::{
        AbsentError, ControllerError, EndedError, Error, InputError, NoEffectError, RecordingError, RefusedError,
        SceneError, SessionError, SimulationError,
    };
    #[pymodule_export]
    use crate::plant::Plant;
    #[pymodule_export]
    use crate::plant_session::PlantSession;
    #[pymodule_export]
    use crate::recording::{read_recording, read_table};
    #[pymodule_export]
    use crate::run::rust_loop;
    #[pymodule_export]
    use crate::scene::Scene;
    #[pymodule_export]
    use crate::session::Session;
    #[pymodule_export]
    use crate::snapshot::{ControllerSnapshot, Snapshot};
}
