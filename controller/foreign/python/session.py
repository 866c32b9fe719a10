"""The controller's end of a biped session. If the Python package `biped` is installed, it carries the messages. Otherwise ports.py
does: the protocol of docs/WIRE.md over iceoryx2, to read and to port.

    python3 -m pip install .                               # in a clone: the package, for every Linux and any Python from 3.10 on
    python3 -m pip install iceoryx2==0.10.0 numpy xxhash   # or without it

    biped run stand --controller "python3 controller/foreign/python/stand.py"

or, from anywhere else that shares /dev/shm, such as a debugger or another terminal:

    biped plant stand --session lab
    python3 controller/foreign/python/stand.py --session lab

Exit codes are those of biped: 0 after the plant's goodbye, 3 without a plant, 5 if the contract differs, 130 on Ctrl-C or SIGTERM.
"""

import fcntl
import json
import os
import pwd
import secrets
import signal
import sys
import time
from pathlib import Path

try:
    import biped
except ModuleNotFoundError:
    biped = None
import ports
import wire
from ports import INTERRUPTED, PEER_MISSING, Session, Waiting, fail, is_sound

if biped is None and ports.MISSING:
    fail(2, f"the Python package {ports.MISSING} is missing: pip install iceoryx2==0.10.0 numpy xxhash")

NoEffect = biped.NoEffectError if biped else ports.NoEffect  # what a controller raises for a request without effect
NO_SESSION = 'start this program by: biped run SCENE --controller "python3 …", or with --session NAME of a running session'


def prefix_of(name, user=os.getuid()):
    """The first part of the names of all files of a user's session of that name."""
    hash = 0xCBF29CE484222325
    for byte in user.to_bytes(4, "little") + name.encode():
        hash = (hash ^ byte) * 0x100000001B3 & 0xFFFF_FFFF_FFFF_FFFF
    return f"biped_{hash & 0xFFFF_FFFF:08x}_"


def is_running(prefix):
    """Whether a process is a member of the session."""
    try:
        with open(f"/dev/shm/{prefix}members", "rb") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        pass
    return False


def absence(name):
    """A sentence that says why there is no session of this name for this user."""
    for user in pwd.getpwall():
        if user.pw_uid != os.getuid() and Path(f"/dev/shm/{prefix_of(name, user.pw_uid)}members").exists():
            return f"no session `{name}` is running: the session of that name belongs to user {user.pw_name}, and only their processes can join it"
    return f"no session `{name}` is running: start one by biped plant SCENE --session {name}"


def attach(name, patience=10.0):
    """The environment of a running session, which its plant has published; waits for it for `patience` seconds."""
    prefix, waiting = prefix_of(name), Waiting("session", patience)
    while True:
        try:
            if is_running(prefix):
                return json.loads(Path(f"/dev/shm/{prefix}environment").read_text()) | {"BIPED_PATIENCE": str(patience)}
        except FileNotFoundError:
            pass  # the session is just starting
        if waiting.has_expired():
            fail(PEER_MISSING, absence(name))
        time.sleep(0.005)


def environment():
    """The environment of the session to join: `--session NAME`, BIPED_SESSION, or what `biped run` has set."""
    if "--session" in sys.argv[:-1]:
        return attach(sys.argv[sys.argv.index("--session") + 1])
    if "BIPED_SESSION" in os.environ and "BIPED_CONTRACT" not in os.environ:
        return attach(os.environ["BIPED_SESSION"], float(os.environ.get("BIPED_PATIENCE", 10.0)))
    if "BIPED_SESSION" not in os.environ:
        fail(2, NO_SESSION)
    return os.environ


def serve(make):
    """Answers the plant until its goodbye. `make(scene, rate)` returns a controller whose `tick(counts, telemetry)` returns eight
    torques [N·m] and may fill in the telemetry. Each run of the plant gets a new controller. A controller with a method
    `set(speed, period)` gets the requests of `biped set`. An argument that is None stays as it is. ValueError refuses the request as out
    of range, NoEffect as one without effect. A method `stop()` gets the requests of `biped set --stop`. A method `begin_at(time)` gets the
    simulated time of the first reading before that reading [s]; it is not zero after a takeover."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: sys.exit(INTERRUPTED))
    if biped:
        return serve_by_package(make, environment())
    session = Session(environment())
    try:
        answer = wire.Command()
        answer.stamp.epoch = secrets.randbits(64)
        controller, waiting = make(session.scene, session.scene["rate"]), Waiting("plant", session.patience)
        while True:
            session.answer_requests(controller, answer.stamp)
            sensors = session.read()
            if sensors is None or not is_sound(sensors):
                if waiting.has_expired():
                    fail(PEER_MISSING, f"no plant sent sensors within {session.patience} s")
                continue
            if sensors.last:
                return
            waiting.restart()
            asked, stamp = sensors.stamp, answer.stamp
            if stamp.run != asked.run:  # a new run of the plant
                if stamp.run:
                    controller = make(session.scene, session.scene["rate"])
                begin(controller, asked.sim_ns * 1e-9)
                stamp.run, stamp.seq, stamp.ack = asked.run, 0, 0
            if stamp.ack != asked.seq:  # repeated sensors get the same answer
                answer.torques.torque[:] = controller.tick(sensors.encoders.counts[:], answer.telemetry)
            stamp.seq, stamp.ack, stamp.sim_ns = stamp.seq + 1, asked.seq, asked.sim_ns
            stamp.mono_ns = time.monotonic_ns()
            session.send(answer)
    finally:
        session.close()


def begin(controller, time):
    """Tells a controller that has a method `begin_at` the simulated time of its first reading [s]."""
    getattr(controller, "begin_at", lambda _: None)(time)


def answer_by(controller, session):
    """Makes the methods of a controller answer the requests of a session of the package."""
    session.on_set, session.on_stop = (getattr(controller, method, None) for method in ("set", "stop"))


def serve_by_package(make, environment):
    """The same, with the package `biped`."""
    os.environ.update(environment)
    try:
        with biped.attach() as session:
            scene, telemetry = json.loads(environment["BIPED_SCENE"]), wire.Telemetry()
            controller, runs = make(scene, scene["rate"]), 0
            answer_by(controller, session)
            for counts in session:
                if session.begins:
                    controller, runs = controller if runs == 0 else make(scene, scene["rate"]), runs + 1
                    answer_by(controller, session)
                    begin(controller, session.time)
                session.write(controller.tick(counts.tolist(), telemetry), telemetry)
    except biped.Error as error:
        fail(error.exit_code, error)
