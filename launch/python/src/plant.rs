//! `Plant`: robot, ground and drives, one control period at a time.

use crate::arguments::{Natural, Real};
use crate::arrays::{OutputArray, record, torques, vector};
use crate::error::{Error, InputError, SceneError, SimulationError};
use crate::run::Run;
use crate::scene::Scene;
use crate::snapshot::Snapshot;
use messages::wire::{JOINTS, STATES};
use numpy::{Ix1, PyArray1};
use plant::PlantError;
use plant::process::{MAX_PUSH_DURATION, MAX_PUSH_IMPULSE, is_push_accepted};
use pyo3::prelude::*;
use std::sync::{Mutex, MutexGuard, TryLockError};

/// Robot, ground and drives of a scene, one control period at a time.
///
/// It has the command pipeline of ``biped run``: a ``[link]`` table of the scene delays and loses commands, and torques beyond four
/// times the limit are refused. The same torques give the same bits as in ``biped run``.
///
/// A plant serves one thread at a time. Different plants run in parallel, because a step releases the GIL.
#[pyclass(frozen, module = "biped")]
pub struct Plant {
    scene: Py<Scene>,
    run: Mutex<Run>,
    counts: OutputArray<i64, Ix1>,
    angles: OutputArray<f64, Ix1>,
    radians_per_count: f64,
}

fn failed(error: PlantError) -> PyErr {
    SimulationError::new_err(error.to_string())
}

#[pymethods]
impl Plant {
    #[new]
    fn new(py: Python<'_>, scene: Py<Scene>) -> PyResult<Plant> {
        let Scene { name, scene: inner } = scene.get();
        let run = Run::new(inner).map_err(|error| SceneError::new_err(format!("scene {name}: {error}")))?;
        let plant = Plant {
            counts: OutputArray::new(py, [JOINTS])?,
            angles: OutputArray::new(py, [JOINTS])?,
            radians_per_count: scene.get().radians_per_count(),
            run: Mutex::new(run),
            scene,
        };
        plant.publish(py, &*plant.lock()?)?;
        Ok(plant)
    }

    /// Starts again from time zero, with another seed of all random numbers if one is given. Returns :attr:`counts`.
    #[pyo3(signature = (*, seed = None))]
    fn reset(&self, py: Python<'_>, seed: Option<Natural>) -> PyResult<Py<PyArray1<i64>>> {
        let mut run = self.lock()?;
        run.reset(seed.map(|Natural(seed)| seed)).map_err(failed)?;
        self.publish(py, &run)?;
        Ok(self.counts.view(py))
    }

    /// Simulates control periods with these torques, shape (8,) [N·m]. Returns :attr:`counts`.
    ///
    /// Without torques the plant gets no command: it holds the last ones for 10 ms, then damps the joints. Stops at the end of the run.
    ///
    /// :raises InputError: wrong shape, not finite, or refused by the plant
    /// :raises EndedError: the run had already ended
    /// :raises SimulationError: the simulation failed; only ``reset`` and ``restore`` help then
    #[pyo3(signature = (torques = None, periods = Natural(1)), text_signature = "($self, torques=None, periods=1)")]
    fn step(
        &self,
        py: Python<'_>,
        torques: Option<&Bound<'_, PyAny>>,
        periods: Natural,
    ) -> PyResult<Py<PyArray1<i64>>> {
        let torques = torques.map(self::torques).transpose()?;
        let mut run = self.lock()?;
        let outcome = {
            let run: &mut Run = &mut run;
            py.detach(|| run.advance(torques, periods.0))
        };
        self.publish(py, &run)?;
        outcome?;
        Ok(self.counts.view(py))
    }

    /// Pushes a body's centre of mass from now on: impulse in the world frame, shape (3,) [N·s], spread over a duration [s]. Without
    /// a body it pushes the base, which is the trunk of a biped.
    #[pyo3(signature = (impulse, *, body = None, duration = Real(0.05)), text_signature = "($self, impulse, *, body=None, duration=0.05)")]
    fn push(&self, impulse: &Bound<'_, PyAny>, body: Option<&Bound<'_, PyAny>>, duration: Real) -> PyResult<()> {
        let Real(duration) = duration;
        let (impulse, body) = (vector("impulse", impulse)?, self.scene.get().body_or_base(body)?);
        if !is_push_accepted(&impulse, duration) {
            return Err(InputError::new_err(format!(
                "a push of {impulse:?} N·s over {duration} s is out of range: at most {MAX_PUSH_IMPULSE} N·s per axis, \
                 over more than 0 and at most {MAX_PUSH_DURATION} s"
            )));
        }
        let mut run = self.lock()?;
        run.simulation.push(body, impulse, duration);
        Ok(())
    }

    /// Data that only the simulation knows, as a NumPy record: ``base_position`` [m], ``contact_force`` [N] and so on; docs/WIRE.md, Truth.
    /// For evaluation. A real robot cannot measure it.
    fn truth<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        record(py, "Truth", &self.lock()?.simulation.truth())
    }

    /// The present state.
    fn snapshot(&self, py: Python<'_>) -> PyResult<Snapshot> {
        Ok(Snapshot { scene: self.scene.clone_ref(py), state: self.lock()?.simulation.snapshot() })
    }

    /// Returns to a state of this plant, or of another plant of an equal scene. What follows has the same bits. Returns :attr:`counts`.
    fn restore(&self, py: Python<'_>, snapshot: &Snapshot) -> PyResult<Py<PyArray1<i64>>> {
        let (ours, theirs) = (self.scene.get(), snapshot.scene.get());
        if ours.scene != theirs.scene {
            return Err(InputError::new_err(format!(
                "the snapshot is of another scene than the plant ({} and {}): use a plant with equal settings",
                theirs.name, ours.name
            )));
        }
        let mut run = self.lock()?;
        run.restore(&snapshot.state)?;
        self.publish(py, &run)?;
        Ok(self.counts.view(py))
    }

    #[getter]
    fn scene(&self, py: Python<'_>) -> Py<Scene> {
        self.scene.clone_ref(py)
    }

    /// Encoder counts of the joints, shape (8,), as the wire carries them. A read-only view: it changes with each step of this plant, and
    /// after a step of a batch when it is asked for again.
    #[getter]
    fn counts(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i64>>> {
        self.publish(py, &*self.lock()?)?; // a batch may have stepped the plant
        Ok(self.counts.view(py))
    }

    /// Joint angles from the encoder counts, shape (8,) [rad]. A read-only view that changes with each step.
    #[getter]
    fn angles(&self, py: Python<'_>) -> PyResult<Py<PyArray1<f64>>> {
        self.publish(py, &*self.lock()?)?;
        Ok(self.angles.view(py))
    }

    /// Simulated time [s].
    #[getter]
    fn time(&self) -> PyResult<f64> {
        Ok(self.lock()?.time())
    }

    /// Whether the run has reached its duration.
    #[getter]
    fn ended(&self) -> PyResult<bool> {
        Ok(self.lock()?.ended())
    }

    /// What drove the robot in the last control period: one of ``STATES``.
    #[getter]
    fn state(&self) -> PyResult<&'static str> {
        Ok(STATES[self.lock()?.state() as usize])
    }

    /// Kinetic energy, and potential energy of gravity [J].
    #[getter]
    fn energy(&self) -> PyResult<f64> {
        let totals = self.lock()?.totals();
        Ok(totals.kinetic + totals.potential)
    }

    /// Whether the posture is that of a fallen robot, by the rule of ``biped run``.
    #[getter]
    fn fallen(&self) -> PyResult<bool> {
        Ok(self.lock()?.fallen())
    }

    /// Hash of all states since time zero. Equal hashes mean equal bits.
    #[getter]
    fn hash(&self) -> PyResult<u64> {
        Ok(self.lock()?.simulation.truth().hash)
    }

    fn __repr__(&self) -> PyResult<String> {
        Ok(format!("<biped.Plant of {} at t = {} s>", self.scene.get().name, self.lock()?.time()))
    }
}

impl Plant {
    /// The run, unless another thread uses it.
    pub fn lock(&self) -> PyResult<MutexGuard<'_, Run>> {
        match self.run.try_lock() {
            Ok(run) => Ok(run),
            Err(TryLockError::Poisoned(run)) => Ok(run.into_inner()),
            Err(TryLockError::WouldBlock) => Err(Error::new_err(
                "this plant is in use by another thread, or twice in one call: give each thread its own plant",
            )),
        }
    }

    pub fn radians_per_count(&self) -> f64 {
        self.radians_per_count
    }

    /// Writes the sensors of a run into the arrays.
    pub fn publish(&self, py: Python<'_>, run: &Run) -> PyResult<()> {
        let counts = run.simulation.sensors().encoders.counts;
        self.counts.write(py, counts.into_iter())?;
        self.angles.write(py, counts.into_iter().map(|count| count as f64 * self.radians_per_count))
    }
}
