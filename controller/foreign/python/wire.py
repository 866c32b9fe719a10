"""The wire format of biped. Made by `biped wire python`: do not edit."""

import ctypes

MAGIC = 0x42504944
SCHEMA = 0xcb822b76123a5e4b
JOINTS = 8
CONTACTS = 16

# Telemetry.phase
PHASE = ["stand", "sway", "lift", "walk", "land", "rest"]
# Truth.state, Reply.state
STATE = ["wait", "run", "paused", "hold", "damp", "fault"]
# Request.kind
REQUEST = ["pause", "resume", "step", "reset", "push", "rearm", "set", "stop"]
# Reply.verdict
VERDICT = ["done", "this request is for the other process", "no such body", "a number is out of range", "damaged request", "this program does not serve the request", "the robot stands or stops, so the request has no effect"]
# Tally.refused
REFUSED = ["of another version", "for another run", "of a controller that has been replaced", "damaged", "not newer than the last", "ahead of the sensors", "not finite", "beyond four times the torque limit", "a jump beyond twice the torque limit"]


class Stamp(ctypes.Structure):
    """Stamp at the head of every message."""

    _fields_ = [
        ("magic", ctypes.c_uint32),
        ("check", ctypes.c_uint32),
        ("schema", ctypes.c_uint64),
        ("run", ctypes.c_uint64),
        ("epoch", ctypes.c_uint64),
        ("seq", ctypes.c_uint64),
        ("ack", ctypes.c_uint64),
        ("sim_ns", ctypes.c_uint64),
        ("mono_ns", ctypes.c_uint64),
    ]

    @staticmethod
    def type_name() -> str:
        return "biped.Stamp"


assert ctypes.sizeof(Stamp) == 64


class Encoders(ctypes.Structure):
    """Reading of the joint encoders."""

    _fields_ = [
        ("counts", ctypes.c_int64 * 8),
    ]

    @staticmethod
    def type_name() -> str:
        return "biped.Encoders"


assert ctypes.sizeof(Encoders) == 64


class Torques(ctypes.Structure):
    """Torque command for the drives."""

    _fields_ = [
        ("torque", ctypes.c_double * 8),
    ]

    @staticmethod
    def type_name() -> str:
        return "biped.Torques"


assert ctypes.sizeof(Torques) == 64


class Telemetry(ctypes.Structure):
    """State of the controller, for display and recording. The plant does not use it."""

    _fields_ = [
        ("phase", ctypes.c_uint32),
        ("support", ctypes.c_uint32),
        ("steps", ctypes.c_uint64),
        ("com", ctypes.c_double * 3),
        ("swing", ctypes.c_double * 3),
        ("pendulum", ctypes.c_double * 4),
        ("energy", ctypes.c_double * 2),
        ("energy_ref", ctypes.c_double * 2),
        ("landing", ctypes.c_double),
        ("surface", ctypes.c_double * 8),
    ]

    @staticmethod
    def type_name() -> str:
        return "biped.Telemetry"


assert ctypes.sizeof(Telemetry) == 200


class Sensors(ctypes.Structure):
    """Plant to controller: data that a real robot could measure."""

    _fields_ = [
        ("stamp", Stamp),
        ("encoders", Encoders),
        ("last", ctypes.c_uint64),
    ]

    @staticmethod
    def type_name() -> str:
        return "biped.Sensors"


assert ctypes.sizeof(Sensors) == 136


class Command(ctypes.Structure):
    """Controller to plant."""

    _fields_ = [
        ("stamp", Stamp),
        ("torques", Torques),
        ("telemetry", Telemetry),
    ]

    @staticmethod
    def type_name() -> str:
        return "biped.Command"


assert ctypes.sizeof(Command) == 328


class Tally(ctypes.Structure):
    """Counters of the plant since the start of its run."""

    _fields_ = [
        ("refused", ctypes.c_uint64 * 9),
        ("lost", ctypes.c_uint64),
        ("held", ctypes.c_uint64),
        ("damped", ctypes.c_uint64),
        ("faulted", ctypes.c_uint64),
        ("skipped", ctypes.c_uint64),
        ("takeovers", ctypes.c_uint64),
        ("unrecorded", ctypes.c_uint64),
        ("requests", ctypes.c_uint64),
    ]

    @staticmethod
    def type_name() -> str:
        return "biped.Tally"


assert ctypes.sizeof(Tally) == 136


class Truth(ctypes.Structure):
    """Data that only the simulation knows, for recording. Never for control."""

    _fields_ = [
        ("stamp", Stamp),
        ("base_position", ctypes.c_double * 3),
        ("base_orientation", ctypes.c_double * 4),
        ("base_velocity", ctypes.c_double * 3),
        ("base_spin", ctypes.c_double * 3),
        ("angle", ctypes.c_double * 8),
        ("rate", ctypes.c_double * 8),
        ("torque", ctypes.c_double * 8),
        ("contact_force", ctypes.c_double * 48),
        ("natural_map", ctypes.c_double),
        ("signorini", ctypes.c_double),
        ("slip_misalignment", ctypes.c_double),
        ("energy_gain", ctypes.c_double),
        ("penetration", ctypes.c_double),
        ("hash", ctypes.c_uint64),
        ("fallbacks", ctypes.c_uint64),
        ("pivots", ctypes.c_uint64),
        ("plant_ns", ctypes.c_uint64),
        ("wait_ns", ctypes.c_uint64),
        ("late_ns", ctypes.c_uint64),
        ("reply_ns", ctypes.c_uint64),
        ("state", ctypes.c_uint32),
        ("age", ctypes.c_uint32),
        ("tally", Tally),
        ("telemetry", Telemetry),
        ("command", Stamp),
        ("asked", Torques),
        ("encoders", Encoders),
    ]

    @staticmethod
    def type_name() -> str:
        return "biped.Truth"


assert ctypes.sizeof(Truth) == 1376


class Request(ctypes.Structure):
    """Request to the control service of the plant or of the controller."""

    _fields_ = [
        ("stamp", Stamp),
        ("kind", ctypes.c_uint64),
        ("count", ctypes.c_uint64),
        ("seed", ctypes.c_uint64),
        ("impulse", ctypes.c_double * 3),
        ("duration", ctypes.c_double),
        ("period", ctypes.c_double),
        ("speed", ctypes.c_double),
    ]

    @staticmethod
    def type_name() -> str:
        return "biped.Request"


assert ctypes.sizeof(Request) == 136


class Reply(ctypes.Structure):
    """Answer of the control service."""

    _fields_ = [
        ("stamp", Stamp),
        ("verdict", ctypes.c_uint64),
        ("state", ctypes.c_uint64),
    ]

    @staticmethod
    def type_name() -> str:
        return "biped.Reply"


assert ctypes.sizeof(Reply) == 80


class Served(ctypes.Structure):
    """A request with its answer, for recorders."""

    _fields_ = [
        ("stamp", Stamp),
        ("request", Request),
        ("verdict", ctypes.c_uint64),
    ]

    @staticmethod
    def type_name() -> str:
        return "biped.Served"


assert ctypes.sizeof(Served) == 208
