"""Installs the peers of the bench. Prints their location as `python PATH` and `packages PATH`, and names each package that cannot be installed."""

import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "launch/laboratory/peers"))
import run

run.PACKAGES |= {
    "pinocchio": [*run.PACKAGES["pinocchio"], "cmeel-eigen==3.4.1", "cmeel-urdfdom-headers==3.0.0"],
    "daqp": ["daqp==0.11.0"],
    "osqp": ["osqp==1.1.3", "scipy==1.17.1"],
    "piqp": ["piqp==0.7.0", "scipy==1.17.1"],
    "proxsuite": ["proxsuite==0.8.0"],
}

python = run.environment(Path(sys.argv[1]))
if python is None:
    sys.exit(1)
for name in ("mujoco", "pinocchio", "daqp", "osqp", "piqp", "proxsuite"):
    run.installed(python, name)
where = subprocess.run([python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"], capture_output=True, text=True)
print(f"python {python}\npackages {where.stdout.strip()}")
