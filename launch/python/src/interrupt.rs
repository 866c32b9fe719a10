//! Ctrl-C while a call waits without the GIL.

use pyo3::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Ctrl-C, or what another signal handler in Python raises, while a call waits.
#[derive(Default)]
pub struct Interrupt(Mutex<Option<PyErr>>);

impl Interrupt {
    /// Whether the call goes on waiting.
    pub fn is_absent(&self) -> bool {
        let raised = Python::attach(|py| py.check_signals()).err();
        let goes_on = raised.is_none();
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = raised;
        goes_on
    }

    /// Raises it.
    pub fn check(self) -> PyResult<()> {
        self.0.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)
    }
}
