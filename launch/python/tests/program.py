"""The program ``biped``, for the tests: its path is in the environment variable BIPED."""

import contextlib
import os
import secrets
import subprocess
from pathlib import Path

BIPED = os.environ.get("BIPED", str(Path(__file__).parents[3] / "target" / "release" / "biped"))


def run(*arguments):
    """Runs the program to its end, and returns its output."""
    return subprocess.run([BIPED, *arguments], check=True, capture_output=True, text=True, timeout=120).stdout


def session_name():
    return "py-" + secrets.token_hex(4)


@contextlib.contextmanager
def plant(*arguments):
    """A plant in a process of its own, in a session with a new name."""
    name = session_name()
    process = subprocess.Popen([BIPED, "plant", *arguments, "--session", name], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        yield name, process
    finally:
        process.terminate()
        process.communicate(timeout=30)
