//! The exceptions of the package. Each has one sentence.

use pyo3::create_exception;
use pyo3::exceptions::PyException;

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
