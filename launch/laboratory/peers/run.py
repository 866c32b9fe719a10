#!/usr/bin/env python3
"""Runs other engines on the scenes that `biped chart --peers` wrote, and writes their traces and costs.

    python3 run.py FOLDER [--quick] [--engines mujoco drake] [--venv FOLDER]

FOLDER holds `scenes.toml`. It gets `runs.jsonl`, a line for each run (see measure.py), the traces that these lines name, and
`origin.txt` with day, machine and versions. `biped chart --peers=FOLDER` computes errors from them.

Engines are installed by name, with the versions below, into a virtual environment of their own. An engine that cannot be installed, or
that crashes, is left out and named with the reason. The others go on.
"""

import argparse
import os
import platform
import queue
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

if sys.version_info < (3, 11):
    sys.exit("run.py needs Python 3.11 or later, as the versions of NumPy and of the engines below do")
HERE = Path(__file__).resolve().parent
PACKAGES = {
    "mujoco": ["mujoco-core==4.0.0"],
    "pinocchio": ["pin==4.1.0"],
    "pybullet": ["pybullet==3.2.7"],
    "drake": ["drake==1.51.1"],
    "dart": ["dartpy==6.20.0"],
    "rapier": [],  # a crate, built by cargo
    "siconos": [],  # a Debian package, used if it is there
}
NUMPY = "numpy==2.4.6"
DEBIAN = Path("/usr/bin/python3")
VERSIONS = []  # of the engines that ran
CORES = queue.SimpleQueue()  # cores that are free
ONE_INSTALLS = threading.Lock()
CRASHES = 5  # an engine that crashed this often is left out


def main():
    """Installs, measures, writes."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    arguments.add_argument("folder", type=Path, help="where scenes.toml is")
    arguments.add_argument("--quick", action="store_true", help="mujoco only, 2 step lengths")
    arguments.add_argument("--engines", nargs="+", choices=PACKAGES, default=list(PACKAGES), help="default: all")
    arguments.add_argument("--venv", type=Path, default=cache / "biped-peers", help="default: %(default)s")
    arguments = arguments.parse_args()
    engines = ["mujoco"] if arguments.quick else arguments.engines
    folder = arguments.folder.resolve()
    if not (folder / "scenes.toml").exists():
        sys.exit(f"{folder / 'scenes.toml'} does not exist; `biped chart --peers` writes it")
    python = environment(arguments.venv.absolute())
    if python is None:
        sys.exit("nothing can be installed, nothing is measured")
    cores = sorted(os.sched_getaffinity(0))[:2]
    for core in cores:
        CORES.put(core)
    for old in [*folder.glob("*.jsonl"), *folder.glob("*.f64")]:
        old.unlink()
    with ThreadPoolExecutor(len(cores)) as pool:
        parts = list(pool.map(lambda engine: measure(python, engine, folder, arguments.quick), engines))
    runs = "".join(part.read_text() for part in parts if part.exists())
    if not runs:
        sys.exit("no engine could be measured")
    (folder / "runs.jsonl").write_text(runs)
    for part in parts:
        part.unlink(missing_ok=True)
    origin = f"{time.strftime('%Y-%m-%d')}, {machine()}, one thread\n{', '.join(dict.fromkeys(VERSIONS))}\n"
    (folder / "origin.txt").write_text(origin)
    print(f"{runs.count(chr(10))} runs in {folder / 'runs.jsonl'}")


def environment(folder):
    """Interpreter of the virtual environment, which is created if necessary; None if that fails."""
    python = folder / "bin" / "python"
    if not python.exists():
        say(f"making a virtual environment in {folder}")
        made = subprocess.run([sys.executable, "-m", "venv", folder], capture_output=True, text=True)
        if made.returncode:
            say(f"no virtual environment: {last_line(made.stdout + made.stderr)}")
            return None
    return python


def measure(python, engine, folder, quick):
    """Installs and runs one engine; returns the file of its runs."""
    part = folder / f"{engine}.jsonl"
    if engine == "siconos":
        python = DEBIAN
    if installed(python, engine):
        core = CORES.get()
        run(python, engine, part, core, quick)
        CORES.put(core)
    return part


def installed(python, engine):
    """Whether the engine is installed, now or before."""
    if python == DEBIAN:
        there = DEBIAN.exists() and subprocess.run([DEBIAN, "-c", "import siconos.numerics"], capture_output=True)
        if not there or there.returncode:
            say("siconos left out, it is not installed: apt-get install python3-siconos")
            return False
        return True
    wanted = [NUMPY, *PACKAGES[engine]]
    stamp = python.parent.parent / f"{engine}.installed"
    if not stamp.exists() or stamp.read_text() != " ".join(wanted):
        pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--only-binary", ":all:"]
        with ONE_INSTALLS:
            say(f"installing {' '.join(wanted)}")
            result = subprocess.run([*pip, *wanted], capture_output=True, text=True)
        if result.returncode:
            say(f"{engine} left out, it does not install: {last_line(result.stderr)}")
            return False
        stamp.write_text(" ".join(wanted))
    return engine != "rapier" or built(python.parent.parent)


def built(folder):
    """Builds the program that drives rapier into the folder of the environment; whether this succeeded."""
    say("building rapier")
    cargo = ["cargo", "build", "--release", "--quiet", "--manifest-path", HERE / "rapier" / "Cargo.toml"]
    target = os.environ | {"CARGO_TARGET_DIR": str(folder / "rapier")}
    try:
        result = subprocess.run(cargo, env=target, capture_output=True, text=True)
    except OSError as error:
        say(f"rapier left out, cargo does not run: {error}")
        return False
    if result.returncode:
        say(f"rapier left out, it does not build: {last_line(result.stderr)}")
    os.environ["RAPIER_SCENES"] = str(folder / "rapier" / "release" / "rapier-scenes")
    return result.returncode == 0


def run(python, engine, part, core, quick):
    """Measures one engine in a process of its own, past crashes."""
    job, crashes = -1, 0
    logs = tempfile.TemporaryDirectory()  # engines leave logs where they run
    settings = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "PYTHONDONTWRITEBYTECODE")
    while True:
        files = [part.with_name("scenes.toml"), part]
        command = [python, "-u", HERE / "measure.py", f"{engine}_scenes", *files, "--core", str(core), "--from", str(job + 1)]
        complaints = tempfile.TemporaryFile("w+")
        process = subprocess.Popen(
            [*command, *(["--quick"] if quick else [])],
            env=os.environ | dict.fromkeys(settings, "1"),
            cwd=logs.name,
            stdout=subprocess.PIPE,
            stderr=complaints,
            text=True,
        )
        doing, shown = "starting", time.monotonic()
        for line in process.stdout:
            if line.startswith("job "):
                number, doing = line[4:].strip().split(": ", 1)
                job = int(number)
                if time.monotonic() - shown < 5:
                    continue
                shown, line = time.monotonic(), doing
            if line.startswith("version "):
                VERSIONS.append(line.removeprefix("version ").strip())
            if line.startswith(("version ", "left out: ", doing)):  # the rest is output of the engine
                say(f"{engine}: {line.strip()}")
        code = process.wait()
        if code == 0:
            return
        complaints.seek(0)
        say(f"{engine}: crashed (exit {code}) at {doing}; left out: {last_line(complaints.read())}")
        crashes += 1
        if job < 0 or crashes == CRASHES:
            return


def machine():
    """The processor's name."""
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def last_line(text):
    """The last non-empty line of a log."""
    return next((line.strip() for line in reversed(text.splitlines()) if line.strip()), "no reason given")


def say(text):
    """Prints progress without delay."""
    print(text, flush=True)


if __name__ == "__main__":
    main()
