"""A controller's ports in a session over iceoryx2, for programs without the Python package `biped`: docs/WIRE.md, to read and to port.

    python3 -m pip install iceoryx2==0.10.0 numpy xxhash
"""

import fcntl
import json
import shutil
import sys
import time
from pathlib import Path

import wire

MISSING = None  # name of the package that is missing
try:
    import iceoryx2 as iox2
    import numpy  # noqa: F401, the controllers need it
    import xxhash
except ModuleNotFoundError as missing:
    MISSING, iox2 = missing.name, None

PEER_MISSING, INCOMPATIBLE, INTERRUPTED = 3, 5, 130  # exit codes
SPIN_NS = 50_000  # a reader polls for this long before it sleeps
SLICE = iox2 and iox2.Duration.from_millis(10)  # longest sleep
UNCHANGED = float("inf")  # in a request: this set-point stays as it is


def fail(code, sentence):
    """Ends this process. The launcher shows the text after `error: `."""
    print(f"error: {sentence}", file=sys.stderr)
    sys.exit(code)


class Waiting:
    """A wait of at most `limit` seconds for the other side. Each second it reports itself on standard error."""

    def __init__(self, awaited, limit):
        self.awaited, self.limit = awaited, limit
        self.restart()

    def restart(self):
        self.start, self.reported = time.monotonic(), 0

    def has_expired(self):
        waited = time.monotonic() - self.start
        if self.reported < int(waited) and waited < self.limit:
            self.reported = int(waited)
            print(f"waiting for the {self.awaited}: {self.reported} of {self.limit:g} s", file=sys.stderr, flush=True)
        return waited >= self.limit


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


class Session:
    """A controller's end of the session that an environment describes: sensors to read, commands to write, requests to answer."""

    def __init__(self, environment):
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
        self.contract = verifier(contract)
        self.reader = self.topic("biped/sensors", wire.Sensors).subscriber_builder().buffer_size(1).create()
        self.notifier = self.event("biped/command").notifier_builder().create()
        self.listener = self.event("biped/sensors").listener_builder().create()
        self.writer = self.only_writer(self.topic("biped/command", wire.Command).publisher_builder().max_loaned_samples(1))
        self.served = self.topic("biped/served", wire.Served, writers=4, readers=3, history=0, buffer=64).publisher_builder().create()
        self.requests = self.control_service({"wire schema": contract["wire schema"]})

    def topic(self, name, message, writers=1, readers=4, history=1, buffer=1):
        """Opens or creates a topic as docs/WIRE.md specifies, with the contract as its attributes."""
        builder = self.node.service_builder(iox2.ServiceName.new(name)).publish_subscribe(message)
        builder = builder.max_publishers(writers).max_subscribers(readers).history_size(history)
        builder = builder.subscriber_max_buffer_size(buffer).subscriber_max_borrowed_samples(1).enable_safe_overflow(True)
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

    def control_service(self, schema):
        """Where `biped set` sends its requests."""
        name, schema = "biped/controller/desk", verifier(schema)

        def service():
            builder = self.node.service_builder(iox2.ServiceName.new(name)).request_response(wire.Request, wire.Reply)
            return builder.max_servers(1).open_or_create_with_attributes(schema)

        return with_retries(lambda: service().server_builder().create(), name)

    def answer_requests(self, controller, stamp):
        """Answers all requests that have arrived, by the methods of the controller: `serve` of session.py."""
        while (pending := self.requests.receive()) is not None:
            request = wire.Request.from_buffer_copy(pending.payload().contents)
            verdict = wire.VERDICT.index(judge(request, controller))
            self.served.send_copy(sealed(wire.Served(stamp=stamp, request=request, verdict=verdict)))
            if pending.is_connected:
                pending.send_copy(sealed(wire.Reply(stamp=stamp, verdict=verdict)))
            pending.delete()

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


def verifier(attributes):
    """The attributes that iceoryx2 compares when a process opens a topic."""
    verifier = iox2.AttributeVerifier.new()
    for key, value in attributes.items():
        verifier = verifier.require(iox2.AttributeKey.new(key), iox2.AttributeValue.new(value))
    return verifier


class NoEffect(Exception):
    """A request without effect: the robot only stands, or its walk ends already."""


def judge(request, controller):
    """Carries out a request, and returns the result: one of wire.VERDICT."""
    if not is_sound(request) or request.kind >= len(wire.REQUEST):
        return "damaged request"
    kind = wire.REQUEST[request.kind]
    if kind not in ("set", "stop"):
        return "this request is for the other process"
    method = getattr(controller, kind, None)
    if method is None:
        return "this program does not serve the request"
    points = {"speed": request.speed, "period": request.period} if kind == "set" else {}
    try:
        method(**{key: None if value == UNCHANGED else value for key, value in points.items()})
    except NoEffect:
        return "the robot stands or stops, so the request has no effect"
    except ValueError:
        return "a number is out of range"
    return "done"


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
