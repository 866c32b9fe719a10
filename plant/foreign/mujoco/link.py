"""A plant's end of a biped session, in lockstep: what docs/WIRE.md asks of a simulator, or of a robot's driver. Nothing of
MuJoCo is in here. It has no control service: `biped pause`, `push` and the like say that nobody answers.

Exit codes are those of biped: 0 at the end of the scene, 2 for what cannot be done, 3 without a controller, 4 after a
fault, 5 where the contract differs, 130 on TERM.
"""

import os
import secrets
import signal
import sys
import time
from math import isfinite, tau
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "controller/foreign/python"))

import iceoryx2 as iox2
import session
import wire

FAULT = 4
HOLD, DAMP = 0.01, 0.1  # age up to which torques are held, and joints damped [s]
BLEND = 0.005  # time over which the torques change from a controller to its successor [s]
DAMPING = 2.0  # of a joint without recent commands [N·m·s/rad]
NONSENSE, FULL_SWING = 4.0, 2.0  # a command with a greater torque or torque jump is refused [torque limits]
LINGER = iox2.Duration.from_secs(3)  # longest wait for a recorder to begin


class Link(session.Session):
    """Sensors and truth out, commands in."""

    def __init__(self):
        super().__init__("plant")
        self.truth = self.topic("biped/truth", wire.Truth, readers=3, buffer=1024, history=0, overflow=False)
        builder = self.truth.publisher_builder().max_loaned_samples(1)
        # no unlimited wait: Python handles no SIGTERM while it waits
        self.recorder = builder.backpressure_strategy(iox2.BackpressureStrategy.DiscardData).create()
        self.begun = self.event("biped/truth").listener_builder().create()

    def wait(self):
        """The next command, if one arrives soon. Otherwise processes that have joined meanwhile get the sensors."""
        command = self.read()
        if command is None:
            self.writer.update_connections()
            self.notifier.notify()
        return command

    def record(self, truth):
        """Writes a truth, and counts it as unrecorded if a recorder's buffer, of 1024, had no room."""
        recorders = self.truth.dynamic_config.number_of_subscribers
        truth.tally.unrecorded += max(0, recorders - self.recorder.send_copy(session.sealed(truth)))

    def linger(self):
        """Stays until a recorder has begun to read, if there is one."""
        if self.truth.dynamic_config.number_of_subscribers > 0:
            try:
                self.begun.timed_wait(LINGER)
            except iox2.ListenerWaitError:
                pass  # a signal came


class Intake:
    """From commands to the torques of the drives: validation, newest accepted command and its age, watchdog."""

    def __init__(self, run, scene, tally):
        self.run, self.tally, self.limit = run, tally, scene["plant"]["torque_limit"]
        self.hold, self.damp = (max(1, round(time * scene["rate"])) for time in (HOLD, DAMP))
        self.count_rate = scene["rate"] * tau / 2 ** scene["plant"]["encoder_bits"]
        self.newest, self.fresh, self.retired = None, False, set()
        self.mode, self.age, self.before = "wait", 0, [0] * wire.JOINTS
        self.blend = self.gone = max(1, round(BLEND * scene["rate"]))
        self.applied = self.outgoing = [0.0] * wire.JOINTS

    def refusal(self, command, now):
        """Index of the first reason in wire.REFUSED, or None."""
        stamp, torque, newest = command.stamp, command.torques.torque[:], self.newest
        ours = newest is not None and newest.stamp.epoch == stamp.epoch
        clamped = [max(-self.limit, min(self.limit, t)) for t in newest.torques.torque] if newest else [0.0] * len(torque)
        reasons = (
            lambda: (stamp.magic, stamp.schema) != (wire.MAGIC, wire.SCHEMA),
            lambda: stamp.run != self.run,
            lambda: stamp.epoch in self.retired,
            lambda: not session.is_sound(command),
            lambda: ours and stamp.seq <= newest.stamp.seq,
            lambda: stamp.ack > now,
            lambda: not all(map(isfinite, torque)),
            lambda: max(map(abs, torque)) > NONSENSE * self.limit,
            lambda: max(abs(t - b) for t, b in zip(torque, clamped)) > FULL_SWING * self.limit,
        )
        return next((index for index, reason in enumerate(reasons) if reason()), None)

    def hear(self, command, now):
        """A command comes while the newest sensors sent are number `now`."""
        reason = self.refusal(command, now)
        if reason is not None:
            self.tally.refused[reason] += 1
            return
        if self.newest and self.newest.stamp.epoch != command.stamp.epoch:
            self.retired.add(self.newest.stamp.epoch)
            self.tally.takeovers += 1
            self.gone, self.outgoing = 0, self.applied
        elif self.newest:
            self.tally.lost += command.stamp.seq - self.newest.stamp.seq - 1
        self.newest, self.fresh = command, True

    def torques(self, counts, now):
        self.applied = self.judged(counts, now)
        return self.applied

    def judged(self, counts, now):
        """For the period that begins with these counts, number `now` [N·m]; the drives clamp them."""
        before, self.before = self.before, counts
        if self.newest is None:
            return [0.0] * wire.JOINTS
        self.age, fresh, self.fresh = now - self.newest.stamp.ack, self.fresh, False
        if self.mode == "fault" or self.age > self.damp:
            self.mode = "fault"
            self.tally.faulted += 1
            return [0.0] * wire.JOINTS
        if self.age > self.hold:
            self.mode = "damp"
            self.tally.damped += 1
            return [-DAMPING * self.count_rate * (c - b) for c, b in zip(counts, before)]
        self.mode = "run" if fresh else "hold"
        self.tally.held += not fresh
        self.gone = min(self.gone + 1, self.blend)
        w = self.gone / self.blend
        return [(1 - w) * old + w * new for old, new in zip(self.outgoing, self.newest.torques.torque)]


def serve(make):
    """Runs the scene to its end. `make(scene, mjcf)` gives a plant, whose `counts()` are those of the encoders, whose
    `report(truth)` fills in what is known beside, and whose `advance(torques)` goes on by one control period."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(session.INTERRUPTED))
    link = Link()
    sensors, truth, scene = wire.Sensors(), wire.Truth(), link.scene
    try:
        if "pace=lockstep" not in os.environ["BIPED_CONTRACT"].splitlines():
            session.fail(2, "this plant goes in lockstep alone: leave out --realtime")
        if "link" in scene:
            session.fail(2, "this plant hears every command: leave out the scene's [link]")
        plant, stamp = make(scene, os.environ["BIPED_MJCF"]), sensors.stamp
        stamp.run, stamp.epoch = 1 + secrets.randbits(63), secrets.randbits(64)
        intake, periods = Intake(stamp.run, scene, truth.tally), round(scene["duration"] * scene["rate"])
        for now in range(1, periods + 2):
            counts, sensors.last = plant.counts(), int(now > periods)
            sensors.encoders.counts[:] = counts
            stamp.seq, stamp.sim_ns = now, round((now - 1) * 1e9 / scene["rate"])
            stamp.mono_ns = sent = time.monotonic_ns()
            link.send(sensors)
            truth.stamp, truth.state, truth.age = stamp, wire.STATE.index(intake.mode), intake.age
            plant.report(truth)
            link.record(truth)
            if sensors.last:
                break
            if scene.get("controller"):
                wait(link, intake, stamp)
            answered = time.monotonic_ns()
            plant.advance(intake.torques(counts, now))
            truth.plant_ns, truth.wait_ns = time.monotonic_ns() - answered, answered - sent
            if intake.newest:
                answer, truth.telemetry = intake.newest.stamp, intake.newest.telemetry
                truth.reply_ns = max(0, answer.mono_ns - sent) if answer.ack == now else 0
        link.linger()
        if intake.mode == "fault":
            session.fail(FAULT, f"no good command for {intake.age} control periods: the drives were switched off")
    finally:
        if not sensors.last:  # the controller gets a goodbye after an early end, too
            sensors.last, sensors.stamp.seq = 1, sensors.stamp.seq + 1
            link.send(sensors)
        link.close()


def wait(link, intake, asked):
    """Until the answer to these very sensors has come; at first, until a command has been accepted."""
    began, told = time.monotonic(), 1.0
    while True:
        command = link.wait()
        if command is not None:
            intake.hear(command, asked.seq)
            if intake.newest and (command.stamp.run, command.stamp.ack) == (asked.run, asked.seq):
                return
        waited = time.monotonic() - began
        if waited > link.patience:
            refused = {wire.REFUSED[k]: n for k, n in enumerate(intake.tally.refused) if n}
            session.fail(session.PEER_MISSING, f"no controller answered within {link.patience} s; refused: {refused or 'none'}")
        if waited > told:
            told += 1.0
            print(f"waiting for the controller ({waited:.0f} s)", file=sys.stderr)
