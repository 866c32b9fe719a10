//! `Controller`: the paper's walking controller.

use crate::arguments::Real;
use crate::arrays::{OutputArray, counts, record};
use crate::error::{ControllerError, Error, InputError, NoEffectError, without_panic};
use crate::scene::Scene;
use crate::snapshot::ControllerSnapshot;
use messages::wire::{Encoders, JOINTS};
use numpy::{Ix1, PyArray1};
use pyo3::prelude::*;
use std::sync::{Mutex, MutexGuard, TryLockError};

/// The walking controller of the paper. It must get every reading of a run exactly once.
#[pyclass(frozen, module = "biped")]
pub struct Controller {
    scene: Py<Scene>,
    controller: Mutex<controller::Controller>,
    torques: OutputArray<f64, Ix1>,
}

fn unfit(error: controller::ControllerError) -> PyErr {
    let sentence = error.to_string();
    if error.is_without_effect() { NoEffectError::new_err(sentence) } else { ControllerError::new_err(sentence) }
}

#[pymethods]
impl Controller {
    #[new]
    fn new(py: Python<'_>, scene: Py<Scene>) -> PyResult<Controller> {
        let controller = controller::Controller::new(&scene.get().scene).map_err(unfit)?;
        Ok(Controller { torques: OutputArray::new(py, [JOINTS])?, controller: Mutex::new(controller), scene })
    }

    /// Starts again, with the set-points of the scene. `time` is the simulated time of the next reading [s]: a controller that takes over in
    /// the middle of a run needs it for the scene's stop time.
    #[pyo3(signature = (*, time = Real(0.0)))]
    fn reset(&self, time: Real) -> PyResult<()> {
        let mut controller = self.lock()?;
        *controller = controller::Controller::new(&self.scene.get().scene).map_err(unfit)?;
        controller.begin_at(time.0);
        Ok(())
    }

    /// One control period: encoder counts, shape (8,) int64, to torques, shape (8,) [N·m]. The result is a read-only view that the next
    /// call overwrites.
    fn tick(&self, py: Python<'_>, counts: &Bound<'_, PyAny>) -> PyResult<Py<PyArray1<f64>>> {
        let encoders = Encoders { counts: self::counts(counts)? };
        let mut controller = self.lock()?;
        let torques = without_panic(ControllerError::new_err, || controller.tick(&encoders).map_err(unfit))?;
        self.torques.write(py, torques.torque.into_iter())?;
        Ok(self.torques.view(py))
    }

    /// Changes the set-points of the gait: walking speed [m/s] and period of two steps [s].
    ///
    /// :raises ControllerError: out of the range of this robot; then nothing changes
    /// :raises NoEffectError: the robot only stands, or its walk ends already
    #[pyo3(signature = (*, speed = None, period = None))]
    fn set(&self, speed: Option<Real>, period: Option<Real>) -> PyResult<()> {
        let (period, speed) = (period.map(|Real(period)| period), speed.map(|Real(speed)| speed));
        self.lock()?.set(period, speed).map_err(unfit)
    }

    /// Ends the walk: the robot stops at the end of the step under way. A walk that has ended stays so.
    fn stop(&self) -> PyResult<()> {
        self.lock()?.stop();
        Ok(())
    }

    /// State of the gait in the last control period, as a NumPy record; docs/WIRE.md, Telemetry.
    fn telemetry<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        record(py, "Telemetry", &self.lock()?.telemetry())
    }

    /// The present state, with the set-points.
    fn snapshot(&self, py: Python<'_>) -> PyResult<ControllerSnapshot> {
        Ok(ControllerSnapshot { scene: self.scene.clone_ref(py), state: self.lock()?.snapshot() })
    }

    /// Returns to a state of this controller, or of another controller of an equal scene.
    fn restore(&self, snapshot: &ControllerSnapshot) -> PyResult<()> {
        if snapshot.scene.get().scene != self.scene.get().scene {
            return Err(InputError::new_err("the snapshot is of a controller of another scene"));
        }
        let mut controller = self.lock()?;
        without_panic(ControllerError::new_err, || controller.restore(&snapshot.state).map_err(unfit))
    }

    #[getter]
    fn scene(&self, py: Python<'_>) -> Py<Scene> {
        self.scene.clone_ref(py)
    }

    fn __repr__(&self) -> String {
        format!("<biped.Controller of {}>", self.scene.get().name)
    }
}

impl Controller {
    /// The controller, unless another thread uses it.
    fn lock(&self) -> PyResult<MutexGuard<'_, controller::Controller>> {
        match self.controller.try_lock() {
            Ok(controller) => Ok(controller),
            Err(TryLockError::Poisoned(controller)) => Ok(controller.into_inner()),
            Err(TryLockError::WouldBlock) => Err(Error::new_err("this controller is in use by another thread")),
        }
    }
}
