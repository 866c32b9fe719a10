"""The controller's end of a biped session. If the Python package `biped` is installed, it carries the messages. Otherwise this
module does: the protocol of docs/WIRE.md over iceoryx2, to read and to port, without requests: `biped set` says that nobody answers.

    python3 -m pip install .                               # in a clone: the package, for every Linux and any Python from 3.10 on
    python3 -m pip install iceoryx2==0.10.0 numpy xxhash   # or without it

    biped run stand --controller "python3 controller/foreign/python/stand.py"

or, from anywhere else that shares /dev/shm, such as a debugger or another terminal:

    biped plant stand --session lab
    python3 controller/foreign/python/stand.py --session lab

Exit codes are those of biped: 0 after the plant's goodbye, 3 without a plant, 5 if the contract differs, 130 on SIGTERM.
"""

import fcntl
import json
import os
import secrets
import shutil
import signal
import sys
import time
from pathlib import Path

try:
    import biped
except ModuleNotFoundError:
    biped = None
try:
    import iceoryx2 as iox2
    import numpy  # noqa: F401, the controllers that import this module need it
    import xxhash
except ModuleNotFoundError as missing:
    if biped is None:
        print(f"error: the Python package {missing.name} is missing: pip install iceoryx2==0.10.0 numpy xxhash", file=sys.stderr)
        sys.exit(2)
    iox2 = None

import wire

PEER_MISSING, INCOMPATIBLE, INTERRUPTED = 3, 5, 130
NO_SESSION = 'start this program by: biped run SCENE --controller "python3 …", or with --session NAME of a running session'
SPIN_NS = 50_000  # a reader polls for this long before it sleeps
SLICE = iox2 and iox2.Duration.from_millis(10)  # longest sleep


def fail(code, sentence):
    """Ends this process. The launcher shows the text after `error: `."""
    print(f"error: {sentence}", file=sys.stderr)
    sys.exit(code)


def check_sum(message):
    """Lower half of XXH3 (64 bits) of all bytes after the field `check`."""
    return xxhash.xxh3_64_intdigest(bytes(message)[wire.Stamp.schema.offset :]) & 0xFFFF_FFFF


def is_sound(message):
    """Whether magic number, schema hash and check sum are right."""
    stamp = message.stamp
    return (stamp.magic, stamp.schema, stamp.check) == (wire.MAGIC, wire.SCHEMA, check_sum(message))


def sealed(message):
    """The message with magic number, schema hash and check sum."""
    message.stamp.magic, message.stamp.schema = wire.MAGIC, wire.SCHEMA
    message.stamp.check = check_sum(message)
    return message


class Members:
    """The lock by which the members of a session know each other. The last member that leaves removes the session's files."""

    def __init__(self, prefix):
        self.prefix = prefix
        self.file = open(f"/dev/shm/{prefix}members", "a+b")
        fcntl.flock(self.file, fcntl.LOCK_SH)

    def leave(self):
        try:
            fcntl.flock(self.file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return  # another process is still in the session
        for path in Path("/dev/shm").glob(self.prefix + "*"):
            shutil.rmtree(path, ignore_errors=True) if path.is_dir() else path.unlink(missing_ok=True)


def prefix_of(name):
    """The first part of the names of all files of this user's session of that name."""
    hash = 0xCBF29CE484222325
    for byte in os.getuid().to_bytes(4, "little") + name.encode():
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


def attach(name, patience=10.0):
    """The environment of a running session, which its plant has published; waits for it for `patience` seconds."""
    prefix, start = prefix_of(name), time.monotonic()
    while True:
        try:
            if is_running(prefix):
                return json.loads(Path(f"/dev/shm/{prefix}environment").read_text()) | {"BIPED_PATIENCE": str(patience)}
        except FileNotFoundError:
            pass  # the session is just starting
        if time.monotonic() - start > patience:
            fail(PEER_MISSING, f"no session `{name}` is running: start one by biped plant SCENE --session {name}")
        time.sleep(0.005)


def environment():
    """The environment of the session to join: `--session NAME`, BIPED_SESSION, or what `biped run` has set."""
    if "--session" in sys.argv[:-1]:
        return attach(sys.argv[sys.argv.index("--session") + 1])
    if "BIPED_SESSION" in os.environ and "BIPED_CONTRACT" not in os.environ:
        return attach(os.environ["BIPED_SESSION"], float(os.environ.get("BIPED_PATIENCE", 10.0)))
    return os.environ


class Session:
    """The two topics of a controller in the session that an environment describes: sensors to read, commands to write."""

    def __init__(self, environment):
        if "BIPED_SESSION" not in environment:
            fail(2, NO_SESSION)
        env = {key[6:].lower(): value for key, value in environment.items() if key.startswith("BIPED_")}
        self.contract_text = env["contract"]
        self.name, self.succeeds = env["session"], "succeeds" in env
        self.scene, self.patience = json.loads(env["scene"]), float(env["patience"])
        contract = dict(line.split("=", 1) for line in env["contract"].splitlines())
        if contract["wire schema"] != f"{wire.SCHEMA:016x}":
            fail(INCOMPATIBLE, f"the session has the wire schema {contract['wire schema']}: generate wire.py again by biped wire python")
        self.members = Members(env["prefix"])
        iox2.set_log_level(iox2.LogLevel.Fatal)
        config = iox2.config.default()
        config.global_cfg.prefix = iox2.FileName.new(env["prefix"])
        config.global_cfg.root_path = iox2.Path.new(env["root"])
        builder = iox2.NodeBuilder.new().config(config)
        # the signal handler of iceoryx2 would swallow SIGTERM
        self.node = builder.signal_handling_mode(iox2.SignalHandlingMode.Disabled).create(iox2.ServiceType.Ipc)
        self.contract = iox2.AttributeVerifier.new()
        for key, value in contract.items():
            self.contract = self.contract.require(iox2.AttributeKey.new(key), iox2.AttributeValue.new(value))
        self.reader = self.topic("biped/sensors", wire.Sensors).subscriber_builder().buffer_size(1).create()
        self.notifier = self.event("biped/command").notifier_builder().create()
        self.listener = self.event("biped/sensors").listener_builder().create()
        self.writer = self.only_writer(self.topic("biped/command", wire.Command).publisher_builder().max_loaned_samples(1))

    def topic(self, name, message):
        """Opens or creates a topic as docs/WIRE.md specifies, with the contract as its attributes."""
        builder = self.node.service_builder(iox2.ServiceName.new(name)).publish_subscribe(message)
        builder = builder.max_publishers(1).max_subscribers(4).history_size(1)
        builder = builder.subscriber_max_buffer_size(1).subscriber_max_borrowed_samples(1).enable_safe_overflow(True)
        return with_retries(lambda: builder.open_or_create_with_attributes(self.contract), name, self.contract_text)

    def only_writer(self, builder):
        """Becomes the only writer of a topic. A successor waits until the present writer has left."""
        while True:
            try:
                return builder.create()
            except iox2.PublisherCreateError:
                if not self.succeeds:
                    fail(INCOMPATIBLE, f"session `{self.name}` already has a controller")
                time.sleep(0.0005)

    def event(self, name):
        return with_retries(lambda: self.node.service_builder(iox2.ServiceName.new(name)).event().open_or_create(), name)

    def read(self):
        """The newest message. Polls first, then sleeps until the other side notifies, at most for one slice."""
        start = time.monotonic_ns()
        while time.monotonic_ns() - start < SPIN_NS:
            message = self.newest()
            if message is not None:
                return message
        try:
            self.listener.timed_wait(SLICE)
        except iox2.ListenerWaitError:
            pass  # a signal, such as SIGCONT
        return self.newest()

    def newest(self):
        """A copy of the newest message, if there is one. Its shared memory is free again at once."""
        sample = self.reader.receive()
        if sample is None:
            return None
        message = wire.Sensors.from_buffer_copy(sample.payload().contents)
        sample.delete()
        return message

    def send(self, message):
        """Seals and writes a message, and notifies the reader."""
        self.writer.send_copy(sealed(message))
        self.notifier.notify()

    def close(self):
        """Closes ports, node and lock, in the reverse order of their creation."""
        members = self.members
        for part in reversed(list(vars(self))):
            delattr(self, part)
        members.leave()


def with_retries(open_it, name, contract=""):
    """Retries for two seconds, because the other side may be creating the same topic at this moment."""
    for attempt in range(200):
        try:
            return open_it()
        except Exception as error:  # the exception classes of iceoryx2 have no common base
            if "Incompatible" in str(error):
                fail(INCOMPATIBLE, f"{name} has another contract than {contract.split()}")
            last = error
            time.sleep(0.01)
    fail(6, f"{name} cannot be opened: {last}")


def serve(make):
    """Answers the plant until its goodbye. `make(scene, rate)` returns a controller whose `tick(counts, telemetry)` returns eight
    torques [N·m] and may fill in the telemetry. Each run of the plant gets a new controller."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(INTERRUPTED))
    if biped:
        return serve_by_package(make, environment())
    session = Session(environment())
    try:
        answer = wire.Command()
        answer.stamp.epoch = secrets.randbits(64)
        controller, last_time = make(session.scene, session.scene["rate"]), time.monotonic()
        while True:
            sensors = session.read()
            if sensors is None or not is_sound(sensors):
                if time.monotonic() - last_time > session.patience:
                    fail(PEER_MISSING, f"no plant sent sensors within {session.patience} s")
                continue
            if sensors.last:
                return
            last_time, asked, stamp = time.monotonic(), sensors.stamp, answer.stamp
            if stamp.run != asked.run:  # a new run of the plant
                if stamp.run:
                    controller = make(session.scene, session.scene["rate"])
                stamp.run, stamp.seq, stamp.ack = asked.run, 0, 0
            if stamp.ack != asked.seq:  # repeated sensors get the same answer
                answer.torques.torque[:] = controller.tick(sensors.encoders.counts[:], answer.telemetry)
            stamp.seq, stamp.ack, stamp.sim_ns = stamp.seq + 1, asked.seq, asked.sim_ns
            stamp.mono_ns = time.monotonic_ns()
            session.send(answer)
    finally:
        session.close()


def serve_by_package(make, environment):
    """The same, with the package `biped`. A controller with a method `set(speed, period)` gets the requests of `biped set`. An argument that
    is None stays as it is. ValueError refuses the request."""
    if "BIPED_SESSION" not in environment:
        fail(2, NO_SESSION)
    os.environ.update(environment)
    try:
        with biped.attach() as session:
            scene, telemetry = json.loads(environment["BIPED_SCENE"]), wire.Telemetry()
            controller, runs = make(scene, scene["rate"]), 0
            session.on_set = getattr(controller, "set", None)
            for counts in session:
                if session.begins:
                    controller, runs = controller if runs == 0 else make(scene, scene["rate"]), runs + 1
                    session.on_set = getattr(controller, "set", None)
                session.write(controller.tick(counts.tolist(), telemetry), telemetry)
    except biped.AbsentError as error:
        fail(PEER_MISSING, error)
    except biped.RefusedError as error:
        fail(INCOMPATIBLE, error)
    except biped.Error as error:
        fail(2, error)
