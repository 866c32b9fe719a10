//! `Snapshot`: the state of a plant, also as bytes for another process.

use crate::error::InputError;
use crate::scene::Scene;
use messages::load;
use messages::wire::{FNV_START, fnv1a};
use plant::SimulationSnapshot;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde::{Deserialize, Serialize};

/// The first words of a snapshot's bytes.
const KIND: &str = "biped snapshot";
/// The version that has written them. Another one may have other fields.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The state of a plant, from :meth:`Plant.snapshot`. It cannot be changed. It can be copied, pickled and sent to another process.
#[pyclass(frozen, module = "biped")]
pub struct Snapshot {
    pub scene: Py<Scene>,
    pub state: SimulationSnapshot,
}

/// What precedes the state in the bytes of a snapshot.
#[derive(Serialize, Deserialize)]
struct Header<'a> {
    kind: &'a str,
    version: &'a str,
    /// Hash of the scene.
    scene: u64,
    /// Hash of the bytes of the state.
    state: u64,
}

#[pymethods]
impl Snapshot {
    /// The snapshot of a plant of this scene, from :meth:`to_bytes`.
    ///
    /// :raises InputError: of another scene, from another version, or damaged
    #[staticmethod]
    fn from_bytes(scene: Py<Scene>, data: &[u8]) -> PyResult<Snapshot> {
        let damaged = || InputError::new_err("these bytes are no snapshot of a plant, or they are damaged");
        let (header, state) = postcard::take_from_bytes::<Header>(data).map_err(|_| damaged())?;
        let name = &scene.get().name;
        if header.kind != KIND {
            return Err(damaged());
        }
        if header.version != VERSION {
            let version = header.version;
            return Err(InputError::new_err(format!(
                "the snapshot is of biped {version}, but this is biped {VERSION}"
            )));
        }
        if header.scene != hash(scene.get()) {
            return Err(InputError::new_err(format!(
                "the snapshot is of another scene than {name}: use a scene with equal settings"
            )));
        }
        match postcard::from_bytes(state) {
            Ok(decoded) if header.state == fnv1a(FNV_START, state) => Ok(Snapshot { scene, state: decoded }),
            _ => Err(damaged()),
        }
    }

    /// The state as bytes, with the version of this package and a hash of the scene.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let failed = |error| InputError::new_err(format!("the snapshot cannot be written: {error}"));
        let state = postcard::to_allocvec(&self.state).map_err(failed)?;
        let scene = hash(self.scene.get());
        let header = Header { kind: KIND, version: VERSION, scene, state: fnv1a(FNV_START, &state) };
        let header = postcard::to_allocvec(&header).map_err(failed)?;
        Ok(PyBytes::new(py, &[header, state].concat()))
    }

    #[allow(clippy::type_complexity, reason = "what pickle asks for")]
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Py<Scene>, Bound<'py, PyBytes>))> {
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

fn hash(scene: &Scene) -> u64 {
    fnv1a(FNV_START, load::text(&scene.scene).as_bytes())
}
