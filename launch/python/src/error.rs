//! The exceptions of the package. Each has one sentence.

use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};

create_exception!(biped, Error, PyException, "Base of all exceptions of this package.");
create_exception!(
    biped,
    SceneError,
    Error,
    "A scene is unknown or invalid. The message names the key and the values that are allowed."
);
create_exception!(
    biped,
    InputError,
    Error,
    "An argument has the wrong shape or type, is not finite, or is out of range."
);
create_exception!(biped, EndedError, Error, "The run has ended: there is no further control period.");
create_exception!(
    biped,
    SimulationError,
    Error,
    "The simulation has diverged, or a contact problem could not be solved."
);
create_exception!(
    biped,
    ControllerError,
    Error,
    "The controller does not fit the robot, or has no torques for its posture."
);
create_exception!(
    biped,
    NoEffectError,
    ControllerError,
    "Set-points for a robot that only stands, or whose walk ends already."
);
create_exception!(
    biped,
    RecordingError,
    Error,
    "A file is not a recording of this program, or has another wire format."
);
create_exception!(
    biped,
    SessionError,
    Error,
    "A session fails: shared memory, a call of another thread or process, or a closed session."
);
create_exception!(
    biped,
    AbsentError,
    SessionError,
    "No session of that name is running, or its other side does not answer."
);
create_exception!(
    biped,
    RefusedError,
    SessionError,
    "The session refuses: it has another contract or a controller already, or a request cannot be done."
);

/// Gives each class the exit code of a controller that ends with this exception; docs/WIRE.md lists them. Subclasses inherit the code.
pub fn set_exit_codes(py: Python<'_>) -> PyResult<()> {
    let codes = [
        (py.get_type::<Error>(), 4),
        (py.get_type::<SceneError>(), 2),
        (py.get_type::<InputError>(), 2),
        (py.get_type::<RecordingError>(), 2),
        (py.get_type::<SessionError>(), 6),
        (py.get_type::<AbsentError>(), 3),
        (py.get_type::<RefusedError>(), 5),
    ];
    codes.iter().try_for_each(|(class, code)| class.setattr("exit_code", code))
}

/// Does `work`. A panic is a defect of the program. It becomes a failure with a sentence.
pub fn without_panic<T, E>(failure: impl FnOnce(String) -> E, work: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
    let defect = || failure("a defect of this program; standard error has the details".into());
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| Err(defect()))
}
