//! `PlantSession`: a plant of one's own in a session.

use crate::arrays::{OutputArray, counts, message};
use crate::interrupt::Interrupt;
use crate::lockstep_plant::LockstepPlant;
use crate::owned::Owned;
use crate::ports::failed;
use crate::scene::Scene;
use biped_c::failure::CallFailure;
use messages::peer_environment::PeerEnvironment;
use messages::wire::{JOINTS, STATES, Truth};
use numpy::{Ix1, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use send_wrapper::SendWrapper;

/// The session of ``biped run SCENE --plant COMMAND``, for the program COMMAND: a simulator, or the driver of a robot, in lockstep.
///
/// It does what docs/WIRE.md asks of a plant: it numbers and sends sensors and truth, checks commands, delays and loses those of a
/// ``[link]`` table, and announces the end, also after an exception in a ``with`` block. It belongs to the thread that opened it.
#[pyclass(frozen, module = "biped")]
pub struct PlantSession {
    scene: Py<Scene>,
    plant: Owned<LockstepPlant>,
    torques: OutputArray<f64, Ix1>,
}

#[pymethods]
impl PlantSession {
    #[new]
    fn new(py: Python<'_>) -> PyResult<PlantSession> {
        let join = || {
            let environment = PeerEnvironment::from_env(|| false).map_err(CallFailure::from)?;
            let (name, scene) = (environment.session.name().to_string(), environment.scene.clone());
            Ok((Scene { name, scene }, LockstepPlant::join(environment)?))
        };
        let joined: Result<_, CallFailure> = py.detach(|| SendWrapper::new(join())).take();
        let (scene, plant) = joined.map_err(failed)?;
        Ok(PlantSession {
            scene: Py::new(py, scene)?,
            plant: Owned::new(plant),
            torques: OutputArray::new(py, [JOINTS])?,
        })
    }

    /// Sends encoder counts, shape (8,), and waits for the answer. Returns the torques for the control period that begins now, shape (8,)
    /// [N·m], or None at the end of the scene. The torques are a read-only view that the next call overwrites; the drives limit them.
    ///
    /// Truth is a record or bytes of the message Truth, for recordings and figures. Stamps, counters, times and the command need not be
    /// filled in. Counts and truth hold for the same instant.
    ///
    /// :raises AbsentError: no controller answered for the time of the session's patience
    /// :raises InputError: wrong shape or type, or a call after the end
    #[pyo3(signature = (counts, truth = None))]
    fn exchange(
        &self,
        py: Python<'_>,
        counts: &Bound<'_, PyAny>,
        truth: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Option<Py<PyArray1<f64>>>> {
        let counts = self::counts(counts)?;
        let truth: Truth = truth.map_or(Ok(Truth::default()), |data| message("truth", data))?;
        let mut plant = self.plant.open()?;
        let interrupt = Interrupt::default();
        let outcome = {
            let mut plant = SendWrapper::new(&mut *plant);
            py.detach(|| plant.exchange(counts, truth, || interrupt.is_absent()))
        };
        interrupt.check()?;
        let Some(torques) = outcome.map_err(failed)? else { return Ok(None) };
        self.torques.write(py, torques.torque.into_iter())?;
        Ok(Some(self.torques.view(py)))
    }

    /// Announces the end of the run, if that has not happened, and leaves the session. The end of a ``with`` block does so.
    fn close(&self) -> PyResult<()> {
        let plant = self.plant.close()?;
        plant.map_or(Ok(()), |mut plant| plant.leave().map_err(failed))
    }

    #[getter]
    fn scene(&self, py: Python<'_>) -> Py<Scene> {
        self.scene.clone_ref(py)
    }

    /// Simulated time of the last exchange [s].
    #[getter]
    fn time(&self) -> PyResult<f64> {
        Ok(self.plant.open()?.time())
    }

    /// What drives the robot: one of ``STATES``.
    #[getter]
    fn state(&self) -> PyResult<&'static str> {
        Ok(STATES[self.plant.open()?.state() as usize])
    }

    fn __enter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    #[pyo3(signature = (*_reason))]
    fn __exit__(&self, _reason: &Bound<'_, PyTuple>) -> PyResult<()> {
        self.close()
    }
}

impl Drop for PlantSession {
    fn drop(&mut self) {
        // Elsewhere it cannot be closed, and the connection is already lost if the goodbye fails.
        if let Ok(Some(mut plant)) = self.plant.close() {
            let _ = plant.leave();
        }
    }
}
