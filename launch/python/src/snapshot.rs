//! `Snapshot` and `ControllerSnapshot`: the state of a plant or of a controller, also as bytes for another process.

use crate::error::InputError;
use crate::scene::Scene;
use messages::load;
use messages::wire::{FNV_START, fnv1a};
use plant::SimulationSnapshot;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// The first words of the bytes of a plant's snapshot, and of a controller's.
const PLANT: &str = "biped snapshot";
const CONTROLLER: &str = "biped controller snapshot";
/// The version that writes a snapshot. Another version may have other fields.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The part of a snapshot's bytes before the state.
#[derive(Serialize, Deserialize)]
struct Header<'a> {
    kind: &'a str,
    version: &'a str,
    /// Hash of the scene.
    scene: u64,
    /// Hash of the bytes of the state.
    state: u64,
}

/// The bytes of a state of this scene.
fn write<'py>(py: Python<'py>, kind: &str, scene: &Py<Scene>, state: &impl Serialize) -> PyResult<Bound<'py, PyBytes>> {
    let failed = |error| InputError::new_err(format!("the snapshot cannot be written: {error}"));
    let state = postcard::to_allocvec(state).map_err(failed)?;
    let header = Header { kind, version: VERSION, scene: hash(scene.get()), state: fnv1a(FNV_START, &state) };
    let header = postcard::to_allocvec(&header).map_err(failed)?;
    Ok(PyBytes::new(py, &[header, state].concat()))
}

/// The state of these bytes.
fn read<State: DeserializeOwned>(kind: &str, of: &str, scene: &Scene, data: &[u8]) -> PyResult<State> {
    let damaged = || InputError::new_err(format!("these bytes are no snapshot of a {of}, or they are damaged"));
    let (header, state) = postcard::take_from_bytes::<Header>(data).map_err(|_| damaged())?;
    if header.kind != kind {
        return Err(damaged());
    }
    if header.version != VERSION {
        let version = header.version;
        return Err(InputError::new_err(format!("the snapshot is of biped {version}, but this is biped {VERSION}")));
    }
    if header.scene != hash(scene) {
        let name = &scene.name;
        let words = format!("the snapshot is of another scene than {name}: use a scene with equal settings");
        return Err(InputError::new_err(words));
    }
    match postcard::from_bytes(state) {
        Ok(decoded) if header.state == fnv1a(FNV_START, state) => Ok(decoded),
        _ => Err(damaged()),
    }
}

fn hash(scene: &Scene) -> u64 {
    fnv1a(FNV_START, load::text(&scene.scene).as_bytes())
}

/// What pickle asks for: a function and its arguments.
type Recipe<'py> = (Bound<'py, PyAny>, (Py<Scene>, Bound<'py, PyBytes>));

/// The state of a plant, from :meth:`Plant.snapshot`. It cannot be changed. It can be copied, pickled and sent to another process.
#[pyclass(frozen, module = "biped")]
pub struct Snapshot {
    pub scene: Py<Scene>,
    pub state: SimulationSnapshot,
}

#[pymethods]
impl Snapshot {
    /// The snapshot of a plant of this scene, from :meth:`to_bytes`.
    ///
    /// :raises InputError: of another scene, from another version, or damaged
    #[staticmethod]
    fn from_bytes(scene: Py<Scene>, data: &[u8]) -> PyResult<Snapshot> {
        Ok(Snapshot { state: read(PLANT, "plant", scene.get(), data)?, scene })
    }

    /// The state as bytes, with the version of this package and a hash of the scene.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        write(py, PLANT, &self.scene, &self.state)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Recipe<'py>> {
        let read = py.get_type::<Snapshot>().getattr("from_bytes")?;
        Ok((read, (self.scene.clone_ref(py), self.to_bytes(py)?)))
    }

    fn __copy__(this: Py<Self>) -> Py<Self> {
        this
    }

    fn __deepcopy__(this: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        this
    }
}

/// The state of a controller, from :meth:`Controller.snapshot`. It cannot be changed. It can be copied, pickled and sent to another process.
#[pyclass(frozen, module = "biped")]
pub struct ControllerSnapshot {
    pub scene: Py<Scene>,
    pub state: controller::ControllerSnapshot,
}

#[pymethods]
impl ControllerSnapshot {
    /// The snapshot of a controller of this scene, from :meth:`to_bytes`.
    ///
    /// :raises InputError: of another scene, from another version, or damaged
    #[staticmethod]
    fn from_bytes(scene: Py<Scene>, data: &[u8]) -> PyResult<ControllerSnapshot> {
        Ok(ControllerSnapshot { state: read(CONTROLLER, "controller", scene.get(), data)?, scene })
    }

    /// The state as bytes, with the version of this package and a hash of the scene.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        write(py, CONTROLLER, &self.scene, &self.state)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Recipe<'py>> {
        let read = py.get_type::<ControllerSnapshot>().getattr("from_bytes")?;
        Ok((read, (self.scene.clone_ref(py), self.to_bytes(py)?)))
    }

    fn __copy__(this: Py<Self>) -> Py<Self> {
        this
    }

    fn __deepcopy__(this: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        this
    }
}
