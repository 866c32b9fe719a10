//! The ports of a session, and what both kinds of sessions share: durations, failures, functions that serve requests.

use crate::arguments::Real;
use crate::error::{AbsentError, Error, InputError, NoEffectError, RefusedError, SessionError};
use biped_c::end::ControllerHandle;
use biped_c::failure::{BIPED_INCOMPATIBLE, BIPED_MISUSE, BIPED_NO_PLANT, CallFailure};
use messages::port::{GaitRequest, RecorderPort, Verdict};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::time::Duration;

/// The ports of a session. They stay in the thread that opened them.
#[derive(Default)]
pub struct Ports {
    pub controller: Option<ControllerHandle>,
    pub recorder: Option<RecorderPort>,
    /// The functions of `on_set` and `on_stop`.
    pub gait: GaitFunctions,
    /// Whether the last reading was the first one of a run.
    pub begins: bool,
}

impl Ports {
    /// The controller's end.
    pub fn controller(&mut self) -> PyResult<&mut ControllerHandle> {
        let missing = "this process is not the controller of the session: open it with control=True";
        self.controller.as_mut().ok_or_else(|| SessionError::new_err(missing))
    }
}

/// Functions in Python that carry out requests to the gait.
#[derive(Default)]
pub struct GaitFunctions {
    pub on_set: Option<Py<PyAny>>,
    pub on_stop: Option<Py<PyAny>>,
}

impl GaitFunctions {
    pub fn clone_ref(&self, py: Python<'_>) -> GaitFunctions {
        let clone = |function: &Option<Py<PyAny>>| function.as_ref().map(|function| function.clone_ref(py));
        GaitFunctions { on_set: clone(&self.on_set), on_stop: clone(&self.on_stop) }
    }

    /// Passes a request to its function.
    pub fn carry_out(&self, py: Python<'_>, request: GaitRequest) -> PyResult<Verdict> {
        let words = PyDict::new(py);
        let function = match request {
            GaitRequest::Set { period, speed } => {
                words.set_item("period", period)?;
                words.set_item("speed", speed)?;
                &self.on_set
            }
            GaitRequest::Stop => &self.on_stop,
        };
        let Some(function) = function else { return Ok(Verdict::NotServed) };
        match function.call(py, (), Some(&words)) {
            Ok(_) => Ok(Verdict::Done),
            Err(error) if error.is_instance_of::<NoEffectError>(py) => Ok(Verdict::NoEffect),
            Err(error) if error.is_instance_of::<Error>(py) || error.is_instance_of::<PyValueError>(py) => {
                Ok(Verdict::OutOfRange)
            }
            Err(error) => Err(error),
        }
    }
}

/// A number of seconds.
pub fn seconds(what: &str, Real(value): Real) -> PyResult<Duration> {
    Duration::try_from_secs_f64(value).map_err(|error| InputError::new_err(format!("{what} is {value:?} s: {error}")))
}

/// A failure of the session as an exception.
pub fn failed(failure: CallFailure) -> PyErr {
    let sentence = failure.to_string();
    match failure.code() {
        BIPED_MISUSE => InputError::new_err(sentence),
        BIPED_NO_PLANT => AbsentError::new_err(sentence),
        BIPED_INCOMPATIBLE => RefusedError::new_err(sentence),
        _ => SessionError::new_err(sentence),
    }
}
