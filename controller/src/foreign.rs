//! Controllers in other languages, as source text: the files of `controller/foreign`. `biped new controller` copies them.

/// The name and the text of a file.
pub type File = (&'static str, &'static str);

macro_rules! python {
    ($name:literal) => {
        ($name, include_str!(concat!("../foreign/python/", $name)))
    };
}

/// Modules that every controller in Python imports.
pub const PYTHON: [File; 2] = [python!("session.py"), python!("wire.py")];
/// A controller in Python: a spring and a damper in each joint.
pub const PYTHON_STAND: File = python!("stand.py");
/// The controller of the paper in Python.
pub const PYTHON_WALK: File = python!("walk.py");
/// Further modules that the controller of the paper imports.
pub const PYTHON_GAIT: [File; 2] = [python!("robot.py"), python!("gait.py")];
