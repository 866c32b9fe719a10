//! Ctrl-C while a call waits without the GIL, and exceptions of Python functions that run during the wait.

use messages::port::Verdict;
use pyo3::prelude::*;
use std::sync::{Mutex, PoisonError};

/// The exception that ends a wait: of Ctrl-C, of another signal handler, or of a function in Python.
#[derive(Default)]
pub struct Interrupt(Mutex<Option<PyErr>>);

impl Interrupt {
    /// Whether there is no exception yet, so that the call continues to wait.
    pub fn is_absent(&self) -> bool {
        let mut raised = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if raised.is_none() {
            *raised = Python::attach(|py| py.check_signals()).err();
        }
        raised.is_none()
    }

    /// The verdict of a function in Python. An exception ends the wait.
    pub fn keep(&self, function: impl FnOnce(Python<'_>) -> PyResult<Verdict>) -> Verdict {
        Python::attach(function).unwrap_or_else(|error| {
            *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
            Verdict::NotServed
        })
    }

    /// Raises the exception, if there is one.
    pub fn check(self) -> PyResult<()> {
        self.0.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)
    }
}
