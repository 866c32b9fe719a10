//! `Scene`: a checked scene.

use crate::arguments::{Text, accepted, printed};
use crate::error::{InputError, SceneError};
use messages::load::{self, load, parse, validate};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyString, PyTuple};
use records::analysis::KinematicTree;
use shared::list::SCENES;

/// A scene: robot, ground, controller settings and duration. It cannot be changed.
///
/// ``Scene("walk")`` is a built-in scene, ``Scene("my.toml")`` a file. Settings change values:
/// ``Scene("walk", "plant.friction=0.3")`` or ``Scene("walk", {"plant.friction": 0.3, "robot": "my.urdf"})``.
#[pyclass(frozen, module = "biped")]
pub struct Scene {
    pub name: String,
    pub scene: messages::scene::Scene,
}

fn refused(error: load::SceneError) -> PyErr {
    SceneError::new_err(error.to_string())
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (name, *settings))]
    fn new(name: Text, settings: &Bound<'_, PyTuple>) -> PyResult<Scene> {
        let (Text(name), mut texts) = (name, vec![]);
        for setting in settings {
            match setting.cast::<PyDict>() {
                Ok(pairs) => {
                    for (key, value) in pairs {
                        let Text(key) = key.extract()?;
                        texts.push(format!("{key}={}", toml(&value, DEEPEST)?));
                    }
                }
                Err(_) => {
                    let Text(text) = accepted(setting.py(), setting.extract())?.ok_or_else(|| {
                        InputError::new_err("a setting must be a text \"key=value\" or a dict {\"key\": value}")
                    })?;
                    texts.push(text);
                }
            }
        }
        let scene = load(&name, &texts, SCENES).map_err(refused)?;
        Ok(Scene { name, scene })
    }

    /// A scene from its TOML text. Errors call it by ``name``.
    #[staticmethod]
    #[pyo3(signature = (text, name = "scene"))]
    fn parse(text: &str, name: &str) -> PyResult<Scene> {
        let scene = parse(text, name).map_err(refused)?;
        validate(&scene, name).map_err(refused)?;
        Ok(Scene { name: name.into(), scene })
    }

    /// Names of the built-in scenes.
    #[staticmethod]
    fn built_in() -> Vec<&'static str> {
        SCENES.iter().map(|(name, _)| *name).collect()
    }

    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// The scene as TOML, with every default written out.
    #[getter]
    fn text(&self) -> String {
        load::text(&self.scene)
    }

    /// Length of an integration step [s].
    #[getter]
    fn dt(&self) -> f64 {
        self.scene.plant.dt
    }

    /// Control periods per second [Hz].
    #[getter]
    fn rate(&self) -> f64 {
        self.scene.rate
    }

    /// Length of a run [s].
    #[getter]
    fn duration(&self) -> f64 {
        self.scene.duration
    }

    /// Largest torque of a drive [N·m].
    #[getter]
    fn torque_limit(&self) -> f64 {
        self.scene.plant.torque_limit
    }

    /// Angle of one encoder count [rad].
    #[getter]
    pub fn radians_per_count(&self) -> f64 {
        self.scene.plant.radians_per_count()
    }

    /// Names of the joints, in the order of all arrays.
    #[getter]
    fn joints(&self) -> Vec<String> {
        KinematicTree::new(&self.scene).joint_names().into_iter().map(Into::into).collect()
    }

    /// Names of the bodies.
    #[getter]
    fn bodies(&self) -> Vec<&str> {
        self.scene.bodies.iter().map(|body| body.name.as_str()).collect()
    }

    /// Joint angles at time zero [rad].
    #[getter]
    fn start(&self) -> Vec<f64> {
        self.scene.initial.joints.clone()
    }

    /// Mass of the robot, with its payload [kg].
    #[getter]
    fn mass(&self) -> f64 {
        KinematicTree::new(&self.scene).mass
    }

    /// Whether the scene has settings for the walking controller.
    #[getter]
    fn has_controller(&self) -> bool {
        self.scene.controller.is_some()
    }

    fn __eq__(&self, other: &Scene) -> bool {
        self.scene == other.scene
    }

    fn __repr__(&self) -> String {
        let Scene { name, scene } = self;
        format!("<biped.Scene {name}: {} s at {} Hz, dt {} s>", scene.duration, scene.rate, scene.plant.dt)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String, String))> {
        Ok((py.get_type::<Scene>().getattr("parse")?, (self.text(), self.name.clone())))
    }
}

impl Scene {
    /// Number of a body; by default of the base.
    pub fn body_or_base(&self, body: Option<&Bound<'_, PyAny>>) -> PyResult<usize> {
        body.map_or_else(|| Ok(self.scene.base_body()), |body| self.body(body))
    }

    /// Number of a body that is given by its name or number.
    fn body(&self, body: &Bound<'_, PyAny>) -> PyResult<usize> {
        let bodies = &self.scene.bodies;
        let found = match body.extract::<String>() {
            Ok(name) => bodies.iter().position(|body| body.name == name),
            Err(_) => accepted(body.py(), body.extract())?.filter(|number| *number < bodies.len()),
        };
        found.ok_or_else(|| {
            let names = self.bodies().join(", ");
            InputError::new_err(format!("scene {} has no body {}; its bodies are {names}", self.name, printed(body)))
        })
    }
}

/// Lists within lists of a value. No key of a scene has more.
const DEEPEST: usize = 4;

/// A value as TOML, of at most `depth` lists within lists. A text stays as it is, as on the command line.
fn toml(value: &Bound<'_, PyAny>, depth: usize) -> PyResult<String> {
    if let Ok(value) = value.cast::<PyBool>() {
        return Ok(value.is_true().to_string());
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(text.to_string());
    }
    if value.is_instance_of::<PyInt>() {
        return Ok(value.to_string());
    }
    if let Ok(number) = value.cast::<PyFloat>() {
        return Ok(format!("{:?}", number.value()).to_lowercase()); // TOML's nan
    }
    let refused = |use_instead| {
        InputError::new_err(format!("{} cannot be a value of a scene: use {use_instead}", printed(value)))
    };
    let Some(depth) = depth.checked_sub(1) else { return Err(refused("fewer lists within lists")) };
    if let Some(number) = accepted(value.py(), value.call_method0("item"))? {
        return toml(&number, depth); // a NumPy scalar
    }
    if value.is_instance_of::<PyDict>() {
        return Err(refused("a key with dots, such as \"plant.friction\""));
    }
    let parts = accepted(value.py(), value.try_iter())?.ok_or_else(|| refused("numbers, texts and lists"))?;
    let quoted = |part: Bound<'_, PyAny>| match part.cast::<PyString>() {
        Ok(text) => Ok(format!("{:?}", text.to_string())),
        Err(_) => toml(&part, depth),
    };
    let parts = parts.map(|part| quoted(part?)).collect::<PyResult<Vec<_>>>()?;
    Ok(format!("[{}]", parts.join(", ")))
}
