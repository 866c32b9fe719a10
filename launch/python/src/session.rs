//! `Session`: a running session, as its controller or as an observer.

use crate::arguments::{Natural, Real, Text};
use crate::arrays::{OutputArray, message, record, torques, vector};
use crate::error::{InputError, RefusedError};
use crate::interrupt::Interrupt;
use crate::owned::Owned;
use crate::ports::{Ports, failed, seconds};
use crate::scene::Scene;
use biped_c::end::ControllerHandle;
use biped_c::failure::{BIPED_MISUSE, CallFailure};
use biped_c::status::{BIPED_BEGIN, BIPED_GOODBYE};
use messages::peer_environment::PeerEnvironment;
use messages::port::{Action, GaitRequest, RecorderPort, Verdict, ask};
use messages::wire::{JOINTS, Telemetry, Torques};
use numpy::{Ix1, PyArray1};
use pyo3::prelude::*;
use send_wrapper::SendWrapper;
use std::cell::RefMut;
use std::time::{Duration, Instant};

/// Interval at which the session is checked for a record of the truth.
const POLL: Duration = Duration::from_millis(1);

/// A running session, from :func:`biped.attach`. It belongs to the thread that opened it.
///
/// As the controller, answer every reading once: ``for counts in session: session.write(torques)``. The loop ends with the run.
#[pyclass(frozen, module = "biped")]
pub struct Session {
    session: messages::session::Session,
    scene: Py<Scene>,
    ports: Owned<Ports>,
    counts: OutputArray<i64, Ix1>,
    angles: OutputArray<f64, Ix1>,
}

#[pymethods]
impl Session {
    #[new]
    #[pyo3(signature = (name = None, *, patience = Real(10.0), control = true), text_signature = "(name=None, *, patience=10.0, control=True)")]
    fn new(py: Python<'_>, name: Option<Text>, patience: Real, control: bool) -> PyResult<Session> {
        let patience = seconds("patience", patience)?;
        let interrupt = Interrupt::default();
        let join = || {
            let keeps_waiting = || interrupt.is_absent();
            let environment = match &name {
                Some(Text(name)) => PeerEnvironment::attach(name, patience, keeps_waiting),
                None => PeerEnvironment::from_env(keeps_waiting),
            };
            let environment = environment.map_err(CallFailure::from)?;
            let (session, scene) = (environment.session.clone(), environment.scene.clone());
            let controller = control.then(|| ControllerHandle::join(environment, keeps_waiting)).transpose()?;
            Ok((session, scene, Ports { controller, ..Ports::default() }))
        };
        let joined = py.detach(|| SendWrapper::new(join())).take();
        interrupt.check()?;
        let (session, scene, ports) = joined.map_err(failed)?;
        let scene = Py::new(py, Scene { name: session.name().into(), scene })?;
        let (counts, angles) = (OutputArray::new(py, [JOINTS])?, OutputArray::new(py, [JOINTS])?);
        Ok(Session { session, scene, ports: Owned::new(ports), counts, angles })
    }

    /// Waits for the next reading of the encoders. Returns :attr:`counts`, or None after the plant's goodbye.
    ///
    /// :raises AbsentError: no plant sent sensors for the time of the patience
    fn read(&self, py: Python<'_>) -> PyResult<Option<Py<PyArray1<i64>>>> {
        let mut ports = self.ports()?;
        let gait = ports.gait.clone_ref(py);
        let controller = ports.controller()?;
        let interrupt = Interrupt::default();
        let answer = |request| interrupt.keep(|py| gait.carry_out(py, request));
        let outcome = {
            let mut controller = SendWrapper::new(&mut *controller);
            py.detach(|| controller.wait(|| interrupt.is_absent(), answer))
        };
        interrupt.check()?;
        let kind = outcome.map_err(failed)?;
        if kind == BIPED_GOODBYE {
            return Ok(None);
        }
        let counts = controller.encoders().map_err(failed)?.counts;
        ports.begins = kind == BIPED_BEGIN;
        self.counts.write(py, counts.into_iter())?;
        let angle = self.scene.get().radians_per_count();
        self.angles.write(py, counts.into_iter().map(|count| count as f64 * angle))?;
        Ok(Some(self.counts.view(py)))
    }

    /// Answers the reading with torques, shape (8,) [N·m]. Telemetry is a record or bytes of the message Telemetry, for recordings.
    ///
    /// :raises InputError: wrong shape, not finite, or no reading to answer
    #[pyo3(signature = (torques, telemetry = None))]
    fn write(&self, torques: &Bound<'_, PyAny>, telemetry: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let torque = self::torques(torques)?;
        let telemetry: Telemetry = telemetry.map_or(Ok(Telemetry::default()), |data| message("telemetry", data))?;
        let answered = self.ports()?.controller()?.answer(Torques { torque }, telemetry);
        answered.map_err(|failure| match failure.code() {
            BIPED_MISUSE => InputError::new_err("there is no reading to answer: call read, then write once"),
            _ => failed(failure),
        })
    }

    /// The next record of the truth, data that only the simulation knows; None if none arrives within the timeout [s]. In lockstep the
    /// plant waits for those who have begun to read, so go on reading.
    #[pyo3(signature = (timeout = Real(0.0)), text_signature = "($self, timeout=0.0)")]
    fn truth<'py>(&self, py: Python<'py>, timeout: Real) -> PyResult<Option<Bound<'py, PyAny>>> {
        let (start, timeout) = (Instant::now(), seconds("timeout", timeout)?);
        let mut ports = self.ports()?;
        let recorder = match &mut ports.recorder {
            Some(recorder) => recorder,
            none => none.insert(RecorderPort::attach(&self.session).map_err(|error| failed(error.into()))?),
        };
        loop {
            if let Some(truth) = recorder.read().map_err(|error| failed(error.into()))? {
                return record(py, "Truth", &*truth).map(Some);
            }
            if start.elapsed() >= timeout {
                return Ok(None);
            }
            py.detach(|| std::thread::sleep(POLL));
            py.check_signals()?;
        }
    }

    /// Pushes a body, by default the base: impulse in the world frame, shape (3,) [N·s], spread over a duration [s]. As all requests
    /// it returns the simulated time at which it took effect [s].
    ///
    /// :raises RefusedError: no such body, or out of range
    /// :raises AbsentError: the plant does not answer
    #[pyo3(signature = (impulse, *, body = None, duration = Real(0.05)), text_signature = "($self, impulse, *, body=None, duration=0.05)")]
    fn push(
        &self,
        py: Python<'_>,
        impulse: &Bound<'_, PyAny>,
        body: Option<&Bound<'_, PyAny>>,
        duration: Real,
    ) -> PyResult<f64> {
        let Real(duration) = duration;
        let (impulse, body) = (vector("impulse", impulse)?, self.scene.get().body_or_base(body)?);
        self.ask(py, Action::Push { body, impulse, duration })
    }

    /// Asks the session's controller for another walking speed [m/s] or period of two steps [s].
    #[pyo3(signature = (*, speed = None, period = None))]
    fn set(&self, py: Python<'_>, speed: Option<Real>, period: Option<Real>) -> PyResult<f64> {
        let (period, speed) = (period.map(|Real(period)| period), speed.map(|Real(speed)| speed));
        self.ask(py, Action::Gait(GaitRequest::Set { period, speed }))
    }

    /// Asks the session's controller to end the walk.
    fn stop(&self, py: Python<'_>) -> PyResult<f64> {
        self.ask(py, Action::Gait(GaitRequest::Stop))
    }

    /// Stops simulated time.
    fn pause(&self, py: Python<'_>) -> PyResult<f64> {
        self.ask(py, Action::Pause)
    }

    /// Lets simulated time go on.
    fn resume(&self, py: Python<'_>) -> PyResult<f64> {
        self.ask(py, Action::Resume)
    }

    /// Runs a paused session for some control periods.
    #[pyo3(signature = (periods = Natural(1)), text_signature = "($self, periods=1)")]
    fn step(&self, py: Python<'_>, periods: Natural) -> PyResult<f64> {
        self.ask(py, Action::Step { periods: periods.0 })
    }

    /// Starts a new run from time zero.
    #[pyo3(signature = (*, seed = None))]
    fn reset(&self, py: Python<'_>, seed: Option<Natural>) -> PyResult<f64> {
        self.ask(py, Action::Reset { seed: seed.map(|Natural(seed)| seed) })
    }

    /// Switches the drives on again after a fault.
    fn rearm(&self, py: Python<'_>) -> PyResult<f64> {
        self.ask(py, Action::Rearm)
    }

    /// Leaves the session. The end of a ``with`` block does so.
    fn close(&self) -> PyResult<()> {
        self.ports.close().map(drop)
    }

    #[getter]
    fn name(&self) -> &str {
        self.session.name()
    }

    #[getter]
    fn scene(&self, py: Python<'_>) -> Py<Scene> {
        self.scene.clone_ref(py)
    }

    /// Encoder counts of the last reading, shape (8,). A read-only view that the next reading changes.
    #[getter]
    fn counts(&self, py: Python<'_>) -> Py<PyArray1<i64>> {
        self.counts.view(py)
    }

    /// Joint angles of the last reading, shape (8,) [rad]. A read-only view that the next reading changes.
    #[getter]
    fn angles(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        self.angles.view(py)
    }

    /// Whether the last reading was the first one of a run. The controller must start from its initial state then.
    #[getter]
    fn begins(&self) -> PyResult<bool> {
        Ok(self.ports()?.begins)
    }

    /// The function that ``read`` calls for a request of other set-points, with the keywords ``speed`` [m/s] and ``period`` [s], each a number
    /// or None, such as :meth:`Controller.set`. If it raises a :class:`Error` or ``ValueError``, the request is refused as out of range, and
    /// if it raises a :class:`NoEffectError`, as one without effect. Without a function, every request is refused.
    #[getter]
    fn on_set(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        Ok(self.ports()?.gait.clone_ref(py).on_set)
    }

    #[setter]
    fn set_on_set(&self, function: Option<Py<PyAny>>) -> PyResult<()> {
        self.ports()?.gait.on_set = function;
        Ok(())
    }

    /// The function that ``read`` calls, without arguments, for a request to end the walk, such as :meth:`Controller.stop`. Exceptions and
    /// the absence of a function mean the same as for ``on_set``.
    #[getter]
    fn on_stop(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        Ok(self.ports()?.gait.clone_ref(py).on_stop)
    }

    #[setter]
    fn set_on_stop(&self, function: Option<Py<PyAny>>) -> PyResult<()> {
        self.ports()?.gait.on_stop = function;
        Ok(())
    }

    /// Simulated time of the last reading [s].
    #[getter]
    fn time(&self) -> PyResult<f64> {
        Ok(self.ports()?.controller()?.status().time)
    }

    fn __iter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<Py<PyArray1<i64>>>> {
        self.read(py)
    }

    fn __enter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    #[pyo3(signature = (*_reason))]
    fn __exit__(&self, _reason: &Bound<'_, pyo3::types::PyTuple>) -> PyResult<()> {
        self.close()
    }

    fn __repr__(&self) -> String {
        format!("<biped.Session {}>", self.session.name())
    }
}

impl Session {
    /// The ports, for the thread that opened them.
    fn ports(&self) -> PyResult<RefMut<'_, Ports>> {
        self.ports.open()
    }

    /// Sends a request, and returns the simulated time at which it took effect [s].
    fn ask(&self, py: Python<'_>, action: Action) -> PyResult<f64> {
        self.ports.check_open()?;
        let reply = py.detach(|| ask(&self.session, action)).map_err(|error| failed(error.into()))?;
        match reply.verdict == Verdict::Done as u64 {
            true => Ok(reply.stamp.time()),
            false => {
                let role = if action.is_for_controller() { "controller" } else { "plant" };
                let reason = Verdict::text(reply.verdict);
                let name = self.session.name();
                Err(RefusedError::new_err(format!("the {role} of session `{name}` refuses: {reason}")))
            }
        }
    }
}
