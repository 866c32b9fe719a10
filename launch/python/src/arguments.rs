//! Numbers and texts of arguments. A value that Python can hold but this program cannot is refused with a sentence.

use crate::error::InputError;
use pyo3::exceptions::{PyException, PyOverflowError};
use pyo3::prelude::*;
use pyo3::types::PyString;

/// Longest part of a value that an error shows [characters].
const SHOWN: usize = 60;

/// A value as Python prints it, cut where it is long.
pub fn printed(value: &Bound<'_, PyAny>) -> String {
    // Python refuses to print a number with thousands of digits.
    let text = value.repr().map_or_else(|_| "the given value".into(), |text| text.to_string());
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

fn too_large(value: &Bound<'_, PyAny>, largest: &str) -> PyErr {
    InputError::new_err(format!("{} is too large: the largest number is {largest}", printed(value)))
}

/// Whether an error is about an argument. It is not if it is Ctrl-C or the exit of a signal handler, which can occur in any call of Python.
pub fn is_of_argument(py: Python<'_>, error: &PyErr) -> bool {
    error.is_instance_of::<PyException>(py)
}

/// The result of a conversion by Python, or `None` if Python refuses the argument. An exception of a signal handler stays an error.
pub fn accepted<T>(py: Python<'_>, converted: PyResult<T>) -> PyResult<Option<T>> {
    match converted {
        Err(error) if is_of_argument(py, &error) => Ok(None),
        converted => converted.map(Some),
    }
}

/// A whole number that is not negative, of any type that Python takes as one.
#[derive(Clone, Copy)]
pub struct Natural(pub u64);

impl<'py> FromPyObject<'_, 'py> for Natural {
    type Error = PyErr;

    fn extract(argument: Borrowed<'_, 'py, PyAny>) -> PyResult<Natural> {
        argument.extract().map(Natural).map_err(|error: PyErr| {
            let is_too_large =
                error.is_instance_of::<PyOverflowError>(argument.py()) && argument.gt(0).unwrap_or(false);
            match is_of_argument(argument.py(), &error) {
                false => error,
                true if is_too_large => too_large(&argument, "2**64 - 1"),
                true => InputError::new_err(format!("{} is not a whole number of 0 or more", printed(&argument))),
            }
        })
    }
}

/// A number of any type that Python takes as one.
#[derive(Clone, Copy)]
pub struct Real(pub f64);

impl<'py> FromPyObject<'_, 'py> for Real {
    type Error = PyErr;

    fn extract(argument: Borrowed<'_, 'py, PyAny>) -> PyResult<Real> {
        argument.extract().map(Real).map_err(|error: PyErr| {
            match error.is_instance_of::<PyOverflowError>(argument.py()) {
                true => too_large(&argument, "1.8e308"),
                false => error,
            }
        })
    }
}

/// A text, or a path such as `pathlib.Path`.
pub struct Text(pub String);

impl<'py> FromPyObject<'_, 'py> for Text {
    type Error = PyErr;

    fn extract(argument: Borrowed<'_, 'py, PyAny>) -> PyResult<Text> {
        let is_path = !argument.is_instance_of::<PyString>() && argument.hasattr("__fspath__")?;
        let text = if is_path { argument.call_method0("__fspath__")? } else { argument.to_owned() };
        let text = text.cast::<PyString>()?;
        let words = || InputError::new_err(format!("{} has letters that are no Unicode text", printed(text)));
        text.to_str().map(|text| Text(text.into())).map_err(|_| words())
    }
}
