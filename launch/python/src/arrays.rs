//! Arrays in and out. Arguments are checked; results are views of memory that the object reuses.

use crate::arguments::is_of_argument;
use crate::error::InputError;
use messages::wire::{JOINTS, LAYOUT, PHASES, STATES};
use numpy::{Element, PyArray, PyArray1, PyArrayDyn, PyArrayMethods, PyReadwriteArray, PyUntypedArrayMethods, dtype};
use pyo3::PyTypeInfo;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

/// An array that Rust fills and Python reads.
pub struct OutputArray<T, D> {
    written: Py<PyArray<T, D>>,
    /// The same memory, read-only.
    view: Py<PyArray<T, D>>,
}

impl<T: Element, D: numpy::ndarray::Dimension> OutputArray<T, D> {
    pub fn new(py: Python<'_>, shape: impl numpy::ndarray::IntoDimension<Dim = D>) -> PyResult<OutputArray<T, D>> {
        let written = PyArray::zeros(py, shape, false);
        let view = written.call_method0("view")?;
        view.getattr("flags")?.setattr("writeable", false)?;
        Ok(OutputArray { view: view.cast_into()?.unbind(), written: written.unbind() })
    }

    /// The content, for writing.
    pub fn written<'py>(&self, py: Python<'py>) -> PyReadwriteArray<'py, T, D> {
        self.written.bind(py).readwrite()
    }

    /// Replaces the content, row by row.
    pub fn write(&self, py: Python<'_>, values: impl Iterator<Item = T>) -> PyResult<()> {
        self.written(py).as_slice_mut()?.iter_mut().zip(values).for_each(|(place, value)| *place = value);
        Ok(())
    }

    /// The array that Python reads.
    pub fn view(&self, py: Python<'_>) -> Py<PyArray<T, D>> {
        self.view.clone_ref(py)
    }
}

/// The torques of an argument [N·m].
pub fn torques(argument: &Bound<'_, PyAny>) -> PyResult<[f64; JOINTS]> {
    let torques = eight("torques", argument)?;
    match torques.iter().position(|torque: &f64| !torque.is_finite()) {
        None => Ok(torques),
        Some(joint) => Err(InputError::new_err(format!(
            "torques[{joint}] is {}, but every torque must be a finite number [N·m]",
            torques[joint]
        ))),
    }
}

/// The encoder counts of an argument.
pub fn counts(argument: &Bound<'_, PyAny>) -> PyResult<[i64; JOINTS]> {
    eight("counts", argument)
}

/// A vector in W.
pub fn vector(what: &str, argument: &Bound<'_, PyAny>) -> PyResult<[f64; 3]> {
    let numbers = converted(what, argument, &[3])?;
    numbers.try_into().map_err(|_| InputError::new_err(format!("{what} must be 3 numbers")))
}

/// Eight numbers of an argument.
fn eight<T: Element + Copy>(what: &str, argument: &Bound<'_, PyAny>) -> PyResult<[T; JOINTS]> {
    if let Ok(array) = argument.cast::<PyArray1<T>>()
        && let Some(numbers) = array.readonly().as_slice().ok().and_then(|slice| slice.try_into().ok())
    {
        return Ok(numbers);
    }
    let numbers = converted::<T>(what, argument, &[JOINTS])?;
    numbers.try_into().map_err(|_| InputError::new_err(format!("{what} must be {JOINTS} numbers")))
}

/// The numbers of an argument, row by row. The argument need not be an array.
pub fn converted<T: Element + Copy>(what: &str, argument: &Bound<'_, PyAny>, shape: &[usize]) -> PyResult<Vec<T>> {
    if let Ok(array) = argument.cast::<PyArrayDyn<T>>()
        && array.shape() == shape
        && let Ok(numbers) = array.readonly().as_slice()
    {
        return Ok(numbers.to_vec());
    }
    let py = argument.py();
    // Called for an error only, because Python computes the name of the type.
    let refused = |reason: String| -> PyErr {
        let name = dtype::<T>(py).getattr("name").and_then(|name| name.extract::<String>());
        let sentence = |name| format!("{what} must be an array of {name} with the shape {}{reason}", tuple(shape));
        name.map_or_else(|error| error, |name| InputError::new_err(sentence(name)))
    };
    let convert = || {
        let array = py.import("numpy")?.call_method1("asarray", (argument,))?;
        let casting = PyDict::new(py);
        casting.set_item("casting", "safe")?; // never from float to integer, nor beyond the range
        let array = array.call_method("astype", (dtype::<T>(py),), Some(&casting))?;
        Ok(array.cast_into::<PyArrayDyn<T>>()?)
    };
    let array = convert().map_err(|error: PyErr| match is_of_argument(py, &error) {
        true => refused(format!(": {}", error.value(py))),
        false => error,
    })?;
    if array.shape() != shape {
        return Err(refused(format!(", but it has the shape {}", tuple(array.shape()))));
    }
    Ok(array.readonly().as_array().iter().copied().collect())
}

/// A shape as Python writes it.
fn tuple(shape: &[usize]) -> String {
    match shape {
        [length] => format!("({length},)"),
        _ => format!("({})", shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")),
    }
}

/// The layout of every message: name, size [bytes], and fields with name, type, offset [bytes] and meaning.
#[pyfunction]
#[allow(clippy::type_complexity, reason = "a plain list for Python")]
pub fn layout() -> Vec<(&'static str, usize, Vec<(&'static str, &'static str, usize, String)>)> {
    let fields = |message: &messages::wire::Message| {
        let fields = message.fields.iter();
        fields.map(|field| (field.name, field.kind, field.offset, field.doc.join(" ").trim().into())).collect()
    };
    LAYOUT.iter().map(|message| (message.name, message.size, fields(message))).collect()
}

/// A message from the bytes of an object, such as a NumPy record or a structure of `ctypes`.
pub fn message<T: bytemuck::Pod>(what: &str, object: &Bound<'_, PyAny>) -> PyResult<T> {
    let bytes = PyBytes::type_object(object.py()).call1((object,))?.cast_into::<PyBytes>()?;
    let length = bytes.as_bytes().len();
    bytemuck::try_pod_read_unaligned(bytes.as_bytes())
        .map_err(|_| InputError::new_err(format!("{what} has {length} bytes, but the message has {}", size_of::<T>())))
}

/// Names of the phases of the gait, and of the states of the plant.
#[pyfunction]
pub fn names() -> (Vec<&'static str>, Vec<&'static str>) {
    (PHASES.to_vec(), STATES.to_vec())
}

/// A message as a NumPy record.
pub fn record<'py, T: bytemuck::Pod>(py: Python<'py>, name: &str, message: &T) -> PyResult<Bound<'py, PyAny>> {
    let bytes = PyBytes::new(py, bytemuck::bytes_of(message));
    py.import("biped.records")?.call_method1("record", (name, bytes))
}
