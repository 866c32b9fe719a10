#!/usr/bin/env python3
"""Runs other engines on the twelve comparison scenes and writes what they err by and what they cost.

    python3 run.py --out FILE [--quick] [--scenes slide rock] [--engines mujoco drake] [--dated] [--venv FOLDER]

Engines are installed by name, with the versions below, into a virtual environment of their own. One that does not
install, or crashes, is named with its reason and left out; the others go on.
"""

import argparse
import csv
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
COLUMNS = ["view", "scene", "engine", "method", "dt", "metric", "error", "cpu_s_per_sim_s", "us_per_step"]
NUMPY = "numpy==2.4.6"
DEBIAN = Path("/usr/bin/python3")
VERSIONS = []  # of the engines that ran
CORES = queue.SimpleQueue()  # those that no engine is held on
ONE_INSTALLS = threading.Lock()
CRASHES = 5  # an engine that crashed this often is left alone


def main():
    """Installs, measures, writes, prints a table."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    arguments.add_argument("--out", type=Path, required=True, help="CSV to write")
    arguments.add_argument("--quick", action="store_true", help="mujoco only, 3 scenes, 2 step lengths")
    arguments.add_argument("--scenes", nargs="+", metavar="NAME", default=[], help="those whose errors count; default: all")
    arguments.add_argument("--dated", action="store_true", help="begin FILE with `#` lines: day, machine, versions")
    arguments.add_argument("--engines", nargs="+", choices=PACKAGES, default=list(PACKAGES), help="default: all")
    arguments.add_argument("--venv", type=Path, default=cache / "biped-peers", help="default: %(default)s")
    arguments = arguments.parse_args()
    wishes = [*(["--scenes", *arguments.scenes] if arguments.scenes else []), *(["--quick"] if arguments.quick else [])]
    engines = ["mujoco"] if arguments.quick else arguments.engines
    python = environment(arguments.venv.absolute())
    if python is None:
        sys.exit("nothing can be installed, nothing is measured")
    cores = sorted(os.sched_getaffinity(0))[:2]
    for core in cores:
        CORES.put(core)
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(len(cores)) as pool:
        parts = list(pool.map(lambda engine: measure(python, engine, Path(folder), wishes), engines))
        rows = [row for part in parts if part.exists() for row in csv.reader(part.open())]
    if not rows:
        sys.exit("no engine could be measured")
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    with arguments.out.open("w", newline="") as file:
        if arguments.dated:
            file.write(f"# {time.strftime('%Y-%m-%d')}, {machine()}, one thread\n# {', '.join(dict.fromkeys(VERSIONS))}\n")
        csv.writer(file, lineterminator="\n").writerows([COLUMNS, *rows])
    print_tables(rows)
    print(f"{len(rows)} rows in {arguments.out}")


def environment(folder):
    """Interpreter of the virtual environment, made if need be; None if that cannot be."""
    python = folder / "bin" / "python"
    if not python.exists():
        say(f"making a virtual environment in {folder}")
        made = subprocess.run([sys.executable, "-m", "venv", folder], capture_output=True, text=True)
        if made.returncode:
            say(f"no virtual environment: {last_line(made.stdout + made.stderr)}")
            return None
    return python


def measure(python, engine, folder, wishes):
    """Installs and runs one engine; the file of its rows."""
    part = folder / f"{engine}.csv"
    if engine == "siconos":
        python = DEBIAN
    if installed(python, engine):
        core = CORES.get()
        run(python, engine, part, core, wishes)
        CORES.put(core)
    return part


def installed(python, engine):
    """Whether the engine is there, or could be installed."""
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
    """Whether the program that drives rapier could be built, into the folder of the environment."""
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


def run(python, engine, part, core, wishes):
    """Measures one engine in a process of its own, past crashes."""
    job, crashes = -1, 0
    settings = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "PYTHONDONTWRITEBYTECODE")
    while True:
        command = [python, "-u", HERE / "measure.py", f"{engine}_scenes", part, "--core", str(core), "--from", str(job + 1)]
        complaints = tempfile.TemporaryFile("w+")
        process = subprocess.Popen(
            [*command, *wishes],
            env=os.environ | dict.fromkeys(settings, "1"),
            cwd=part.parent,  # engines leave logs where they run
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
            if line.startswith(("version ", "left out: ", doing)):  # the rest is an engine's own talk
                say(f"{engine}: {line.strip()}")
        code = process.wait()
        if code == 0:
            return
        complaints.seek(0)
        say(f"{engine}: crashed (exit {code}) at {doing}; left out: {last_line(complaints.read())}")
        crashes += 1
        if job < 0 or crashes == CRASHES:
            return


def print_tables(rows):
    """Errors at 1 ms, and time per step."""
    rows = [dict(zip(COLUMNS, row)) for row in rows]
    errors = {}
    for row in rows:
        if row["view"] == "precision" and float(row["dt"]) == 1e-3:
            errors.setdefault((row["engine"], row["method"]), {})[row["scene"], row["metric"]] = float(row["error"])
    columns = list(dict.fromkeys(key for line in errors.values() for key in line))
    print(f"\n{'errors at 1 ms':32}" + "".join(f"{scene:>10}" for scene, _ in columns))
    print(" " * 32 + "".join(f"{metric[:9]:>10}" for _, metric in columns))
    for (engine, method), line in errors.items():
        print(f"{engine + ' ' + method:32}" + "".join(f"{line.get(key, float('nan')):10.1e}" for key in columns))
    times = {}
    for row in rows:
        if row["view"] == "step":
            times.setdefault((row["engine"], row["method"]), {})[row["scene"]] = float(row["us_per_step"])
    print(f"\n{'us per step at 1 ms':32}{'free':>10}{'slide':>10}{'stand0':>10}")
    for (engine, method), line in times.items():
        cells = (line.get(scene, float("nan")) for scene in ("free", "slide", "stand0"))
        print(f"{engine + ' ' + method:32}" + "".join(f"{us:10.2f}" for us in cells))


def machine():
    """The processor's name."""
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def last_line(text):
    """The line of a log that says most."""
    return next((line.strip() for line in reversed(text.splitlines()) if line.strip()), "no reason given")


def say(text):
    """Progress, at once."""
    print(text, flush=True)


if __name__ == "__main__":
    main()
