//! `PlantBatch`: many plants that step together, on all cores.

use crate::arguments::Natural;
use crate::arrays::{OutputArray, converted};
use crate::error::InputError;
use crate::helper_threads::for_each;
use crate::plant::Plant;
use crate::run::{Run, Stopped};
use messages::wire::JOINTS;
use numpy::{Ix2, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::sync::{Mutex, PoisonError};

/// Plants that step together on all cores, with the GIL released.
#[pyclass(frozen, module = "biped")]
pub struct PlantBatch {
    plants: Vec<Py<Plant>>,
    radians_per_count: Vec<f64>,
    counts: OutputArray<i64, Ix2>,
    angles: OutputArray<f64, Ix2>,
}

#[pymethods]
impl PlantBatch {
    #[new]
    fn new(py: Python<'_>, plants: Vec<Py<Plant>>) -> PyResult<PlantBatch> {
        if plants.is_empty() {
            return Err(InputError::new_err("a batch needs at least one plant: this list is empty"));
        }
        let shape = [plants.len(), JOINTS];
        let (counts, angles) = (OutputArray::new(py, shape)?, OutputArray::new(py, shape)?);
        let radians_per_count = plants.iter().map(|plant| plant.get().radians_per_count()).collect();
        let batch = PlantBatch { plants, radians_per_count, counts, angles };
        batch.each(py, |_, _| Ok(()))?;
        Ok(batch)
    }

    /// As :meth:`Plant.step` for every plant, with torques of shape (plants, 8) [N·m]. Returns :attr:`counts`. If some plants fail, all
    /// others have stepped, and the error names the first that failed.
    #[pyo3(signature = (torques = None, periods = Natural(1)), text_signature = "($self, torques=None, periods=1)")]
    fn step(
        &self,
        py: Python<'_>,
        torques: Option<&Bound<'_, PyAny>>,
        periods: Natural,
    ) -> PyResult<Py<PyArray2<i64>>> {
        let torques = torques.map(|torques| self.torques(torques)).transpose()?;
        let torques_of = |plant: usize| torques.as_ref().map(|torques| torques[plant]);
        if let Some((plant, stopped)) = self.each(py, |plant, run| run.advance(torques_of(plant), periods.0))? {
            return Err(named(py, plant, stopped.into()));
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

    /// Does `work` with every plant, on all cores and with the GIL released, and writes its sensors into the arrays. Returns the first failure.
    fn each(
        &self,
        py: Python<'_>,
        work: impl Fn(usize, &mut Run) -> Result<(), Stopped> + Sync,
    ) -> PyResult<Option<(usize, Stopped)>> {
        let mut locks = self.plants.iter().map(|plant| plant.get().lock()).collect::<PyResult<Vec<_>>>()?;
        let (mut counts, mut angles) = (self.counts.written(py), self.angles.written(py));
        let rows = counts.as_slice_mut()?.as_chunks_mut().0.iter_mut().zip(angles.as_slice_mut()?.as_chunks_mut().0);
        let members = locks.iter_mut().map(|lock| &mut **lock).zip(&self.radians_per_count).zip(rows);
        let members = members.map(|((run, &radians_per_count), (counts, angles))| Member {
            run,
            radians_per_count,
            counts,
            angles,
        });
        let members: Vec<Mutex<Member>> = members.map(Mutex::new).collect();
        let failures = Mutex::new(vec![]);
        py.detach(|| {
            for_each(members.len(), &|plant| {
                let mut member = members[plant].lock().unwrap_or_else(PoisonError::into_inner);
                if let Err(stopped) = work(plant, member.run) {
                    failures.lock().unwrap_or_else(PoisonError::into_inner).push((plant, stopped));
                }
                member.publish();
            });
        });
        let failures = failures.into_inner().unwrap_or_else(PoisonError::into_inner);
        Ok(failures.into_iter().min_by_key(|(plant, _)| *plant))
    }
}

/// A plant of the batch: its run, and its rows of the arrays.
struct Member<'a> {
    run: &'a mut Run,
    radians_per_count: f64,
    counts: &'a mut [i64; JOINTS],
    angles: &'a mut [f64; JOINTS],
}

impl Member<'_> {
    /// Writes the sensors into the arrays.
    fn publish(&mut self) {
        *self.counts = self.run.simulation.sensors().encoders.counts;
        *self.angles = self.counts.map(|count| count as f64 * self.radians_per_count);
    }
}

/// An error with the number of its plant.
fn named(py: Python<'_>, plant: usize, error: PyErr) -> PyErr {
    let sentence = format!("plant {plant}: {}", error.value(py));
    PyErr::from_type(error.get_type(py), sentence)
}
