//! Controllers as programs of their own, as source text: the files of `controller/foreign`. `biped new controller` copies them.

/// The name and the text of a file.
pub type File = (&'static str, &'static str);

macro_rules! python {
    ($name:literal) => {
        ($name, include_str!(concat!("../foreign/python/", $name)))
    };
}

/// Modules that every controller in Python imports.
pub const PYTHON: [File; 3] = [python!("session.py"), python!("ports.py"), python!("wire.py")];
/// A controller in Python: a spring and a damper in each joint.
pub const PYTHON_STAND: File = python!("stand.py");
/// The controller of the paper in Python.
pub const PYTHON_WALK: File = python!("walk.py");
/// Further modules that the controller of the paper imports.
pub const PYTHON_GAIT: [File; 4] =
    [python!("robot.py"), python!("pendulum.py"), python!("corrections.py"), python!("gait.py")];
/// A controller in Rust: a spring and a damper in each joint.
pub const RUST_STAND: &str = include_str!("../foreign/rust/stand.rs");
/// The controller of the paper in Rust.
pub const RUST_WALK: &str = include_str!("../foreign/rust/walk.rs");
/// A spring and a damper in each joint, in C. It is a link, because `foreign/c` is another package.
pub const C_STAND: &str = include_str!("foreign/stand.c");
/// In C, with the torques of this crate's controller.
pub const C_WALK: &str = include_str!("foreign/walk.c");
/// Header of the C library.
pub const C_HEADER: File = ("controller.h", include_str!("foreign/controller.h"));
/// A spring and a damper in each joint, in C++.
pub const CPP_STAND: &str = include_str!("../foreign/cpp/stand.cpp");
/// The C library as a class.
pub const CPP_HEADER: File = ("session.hpp", include_str!("../foreign/cpp/session.hpp"));
