//! `Plant`: robot, ground and drives, one control period at a time.

use crate::arrays::{OutputArray, record, torques};
use crate::error::{Error, InputError, SceneError, SimulationError};
use crate::run::Run;
use crate::scene::Scene;
use messages::wire::{JOINTS, STATES};
use numpy::{Ix1, PyArray1};
use plant::{PlantError, SimulationSnapshot};
use pyo3::prelude::*;
use std::sync::{Mutex, MutexGuard, TryLockError};

/// Largest impulse [N·s] and longest duration [s] of a push, as for a running session.
const MAX_PUSH: (f64, f64) = (1000.0, 60.0);

/// The plant of a scene.
#[pyclass(frozen, module = "biped")]
pub struct Plant {
    scene: Py<Scene>,
    run: Mutex<Run>,
    counts: OutputArray<i64, Ix1>,
    angles: OutputArray<f64, Ix1>,
    radians_per_count: f64,
}

/// The state of a plant, to return to.
#[pyclass(frozen, module = "biped")]
pub struct Snapshot {
    scene: Py<Scene>,
    snapshot: SimulationSnapshot,
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

    #[pyo3(signature = (*, seed = None))]
    fn reset(&self, py: Python<'_>, seed: Option<u64>) -> PyResult<Py<PyArray1<i64>>> {
        let mut run = self.lock()?;
        run.reset(seed).map_err(failed)?;
        self.publish(py, &run)?;
        Ok(self.counts.view(py))
    }

    #[pyo3(signature = (torques = None, periods = 1))]
    fn step(&self, py: Python<'_>, torques: Option<&Bound<'_, PyAny>>, periods: u64) -> PyResult<Py<PyArray1<i64>>> {
        let torques = torques.map(self::torques).transpose()?;
        let mut run = self.lock()?;
        let outcome = {
            let run: &mut Run = &mut run;
            py.detach(|| run.advance(torques, periods))
        };
        self.publish(py, &run)?;
        outcome?;
        Ok(self.counts.view(py))
    }

    #[pyo3(signature = (impulse, *, body = None, duration = 0.05))]
    fn push(&self, impulse: [f64; 3], body: Option<&Bound<'_, PyAny>>, duration: f64) -> PyResult<()> {
        let body = self.scene.get().body_or_trunk(body)?;
        let (greatest, longest) = MAX_PUSH;
        if !impulse.iter().all(|part| part.abs() <= greatest) || !(0.0..=longest).contains(&duration) {
            return Err(InputError::new_err(format!(
                "a push of {impulse:?} N·s over {duration} s is out of range: at most {greatest} N·s per axis, and 0 to {longest} s"
            )));
        }
        let mut run = self.lock()?;
        run.simulation.push(body, impulse, duration);
        Ok(())
    }

    fn truth<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        record(py, "Truth", &self.lock()?.simulation.truth())
    }

    fn snapshot(&self, py: Python<'_>) -> PyResult<Snapshot> {
        Ok(Snapshot { scene: self.scene.clone_ref(py), snapshot: self.lock()?.simulation.snapshot() })
    }

    fn restore(&self, py: Python<'_>, snapshot: &Snapshot) -> PyResult<Py<PyArray1<i64>>> {
        let (ours, theirs) = (self.scene.get(), snapshot.scene.get());
        if ours.scene != theirs.scene {
            return Err(InputError::new_err(format!(
                "the snapshot is of another scene than the plant ({} and {}): use a plant with equal settings",
                theirs.name, ours.name
            )));
        }
        let mut run = self.lock()?;
        run.restore(&snapshot.snapshot);
        self.publish(py, &run)?;
        Ok(self.counts.view(py))
    }

    #[getter]
    fn scene(&self, py: Python<'_>) -> Py<Scene> {
        self.scene.clone_ref(py)
    }

    #[getter]
    fn counts(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i64>>> {
        self.publish(py, &*self.lock()?)?; // a batch may have stepped the plant
        Ok(self.counts.view(py))
    }

    #[getter]
    fn angles(&self, py: Python<'_>) -> PyResult<Py<PyArray1<f64>>> {
        self.publish(py, &*self.lock()?)?;
        Ok(self.angles.view(py))
    }

    #[getter]
    fn time(&self) -> PyResult<f64> {
        Ok(self.lock()?.time())
    }

    #[getter]
    fn ended(&self) -> PyResult<bool> {
        Ok(self.lock()?.ended())
    }

    #[getter]
    fn state(&self) -> PyResult<&'static str> {
        Ok(STATES[self.lock()?.state() as usize])
    }

    #[getter]
    fn energy(&self) -> PyResult<f64> {
        let totals = self.lock()?.totals();
        Ok(totals.kinetic + totals.potential)
    }

    #[getter]
    fn fallen(&self) -> PyResult<bool> {
        Ok(self.lock()?.fallen())
    }

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
