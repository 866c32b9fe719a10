//! `PlantBatch`: many plants that step together, on all cores.

use crate::arrays::{OutputArray, converted};
use crate::error::InputError;
use crate::plant::Plant;
use crate::run::Run;
use messages::wire::JOINTS;
use numpy::{Ix2, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use rayon::prelude::*;

/// Plants that step together on all cores, with the GIL released.
#[pyclass(frozen, module = "biped")]
pub struct PlantBatch {
    plants: Vec<Py<Plant>>,
    counts: OutputArray<i64, Ix2>,
    angles: OutputArray<f64, Ix2>,
}

#[pymethods]
impl PlantBatch {
    #[new]
    fn new(py: Python<'_>, plants: Vec<Py<Plant>>) -> PyResult<PlantBatch> {
        let shape = [plants.len(), JOINTS];
        let (counts, angles) = (OutputArray::new(py, shape)?, OutputArray::new(py, shape)?);
        let batch = PlantBatch { plants, counts, angles };
        batch.publish(py)?;
        Ok(batch)
    }

    /// As :meth:`Plant.step` for every plant, with torques of shape (plants, 8) [N·m]. Returns :attr:`counts`. If some plants fail, all
    /// others have stepped, and the error names the first that failed.
    #[pyo3(signature = (torques = None, periods = 1))]
    fn step(&self, py: Python<'_>, torques: Option<&Bound<'_, PyAny>>, periods: u64) -> PyResult<Py<PyArray2<i64>>> {
        let torques = torques.map(|torques| self.torques(torques)).transpose()?;
        let mut locks = self.plants.iter().map(|plant| plant.get().lock()).collect::<PyResult<Vec<_>>>()?;
        let mut runs: Vec<&mut Run> = locks.iter_mut().map(|lock| &mut **lock).collect();
        let outcomes: Vec<_> = py.detach(|| {
            let torques_of = |plant: usize| torques.as_ref().map(|torques| torques[plant]);
            let runs = runs.par_iter_mut().enumerate();
            runs.map(|(plant, run)| run.advance(torques_of(plant), periods)).collect()
        });
        drop(runs);
        drop(locks);
        self.publish(py)?;
        for (plant, outcome) in outcomes.into_iter().enumerate() {
            outcome.map_err(|stopped| named(py, plant, stopped.into()))?;
        }
        Ok(self.counts.view(py))
    }

    #[getter]
    fn plants<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, &self.plants)
    }

    /// Encoder counts after the last ``step`` of the batch, shape (plants, 8). A read-only view.
    #[getter]
    fn counts(&self, py: Python<'_>) -> Py<PyArray2<i64>> {
        self.counts.view(py)
    }

    /// Joint angles after the last ``step`` of the batch, shape (plants, 8) [rad]. A read-only view.
    #[getter]
    fn angles(&self, py: Python<'_>) -> Py<numpy::PyArray2<f64>> {
        self.angles.view(py)
    }

    fn __len__(&self) -> usize {
        self.plants.len()
    }
}

impl PlantBatch {
    /// The torques of every plant [N·m].
    fn torques(&self, argument: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; JOINTS]>> {
        let numbers: Vec<f64> = converted("torques", argument, &[self.plants.len(), JOINTS])?;
        if let Some(place) = numbers.iter().position(|torque| !torque.is_finite()) {
            let (plant, joint) = (place / JOINTS, place % JOINTS);
            return Err(InputError::new_err(format!(
                "torques[{plant}, {joint}] is {}, but every torque must be a finite number [N·m]",
                numbers[place]
            )));
        }
        Ok(numbers.as_chunks::<JOINTS>().0.to_vec())
    }

    /// Writes the sensors of all plants into the arrays.
    fn publish(&self, py: Python<'_>) -> PyResult<()> {
        let locks = self.plants.iter().map(|plant| plant.get().lock()).collect::<PyResult<Vec<_>>>()?;
        let counts = || locks.iter().flat_map(|run| run.simulation.sensors().encoders.counts);
        self.counts.write(py, counts())?;
        let angle = self.plants.iter().flat_map(|plant| [plant.get().radians_per_count(); JOINTS]);
        self.angles.write(py, counts().zip(angle).map(|(count, angle)| count as f64 * angle))
    }
}

/// An error with the number of its plant.
fn named(py: Python<'_>, plant: usize, error: PyErr) -> PyErr {
    let sentence = format!("plant {plant}: {}", error.value(py));
    PyErr::from_type(error.get_type(py), sentence)
}
