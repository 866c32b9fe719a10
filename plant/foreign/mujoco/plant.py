"""MuJoCo as the plant: the robot of `biped export mjcf`, for any controller at the other end of the session.

    python3 -m pip install . mujoco   # in a clone of biped: its Python package
    biped run walk --plant "python3 plant/foreign/mujoco/plant.py"

MuJoCo's contacts are compliant and its friction creeps. STEP, TIME_CONSTANT, IMPEDANCE and IMPRATIO make them as hard as is
still stable. With `plant.py --soft` MuJoCo keeps its defaults: the pyramid, one step in each period, 20 ms, .9 to .95, 1.
docs/WIRE.md compares the walk with that of the built-in plant.
"""

import sys
from functools import partial
from math import tau

try:
    import link
    import mujoco
    import numpy as np
except ModuleNotFoundError as missing:
    sentence = f"Python has no {missing.name}: pip install CLONE numpy mujoco, with a clone of the repository of biped"
    print(f"error: {sentence}", file=sys.stderr)
    sys.exit(2)

JOINTS, CONTACTS = 8, 16  # of the messages
STEP = 0.5e-3  # at most [s]
TIME_CONSTANT = 2.0  # of a contact, the least that MuJoCo calls stable [steps]
IMPEDANCE = [0.99, 0.999, 1e-4, 0.5, 2.0]  # d_0, d_width, width [m], midpoint, power
IMPRATIO = 100.0  # stiffness of friction constraints relative to the normal direction [-]
LACKING = ("latency_ticks", "stale_probability", "restitution")  # keys that this plant does not support


class Plant:
    def __init__(self, scene, mjcf, soft=False):
        plant = scene["plant"]
        for key in LACKING:
            if np.any(plant[key]):
                link.fail(2, f"this plant has no plant.{key}: leave it at zero")
        if "ground" in plant:
            link.fail(2, "the ground of this plant is the plane z = 0: leave out plant.ground")
        self.model = mujoco.MjModel.from_xml_string(mjcf)
        option, self.period = self.model.opt, 1.0 / scene["rate"]
        self.steps = 1 if soft else int(np.ceil(self.period / STEP - 1e-9))
        option.timestep = self.period / self.steps
        option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET  # a simulation that diverges must not restart silently
        if not soft:
            option.cone, option.solver = mujoco.mjtCone.mjCONE_ELLIPTIC, mujoco.mjtSolver.mjSOL_NEWTON
            option.impratio, option.iterations, option.tolerance = IMPRATIO, 100, 1e-12
            self.model.geom_solref[:] = [TIME_CONSTANT * option.timestep, 1.0]
            self.model.geom_solimp[:] = IMPEDANCE
        self.data = mujoco.MjData(self.model)
        mujoco.mj_resetDataKeyframe(self.model, self.data, self.model.keyframe("start").id)

        names = [body["name"] for body in scene["bodies"]]
        bodies = [self.model.body(name.replace(" ", "_").replace("-", "_")) for name in names]
        self.bodies = {name: body.id for name, body in zip(names, bodies)}
        self.base = next(self.bodies[body["name"]] for body in scene["bodies"] if not body.get("joint"))
        joints = self.model.actuator_trnid[:, 0]  # motors are in wire order
        self.angles, self.rates = self.model.jnt_qposadr[joints], self.model.jnt_dofadr[joints]
        # contact points are counted by the order of the scene's bodies
        geoms = [geom for body in bodies for geom in body.geomadr[0] + np.arange(body.geomnum[0])]
        self.points = [geom for geom in geoms if self.model.geom_contype[geom] == 1]
        self.point = {int(geom): k for k, geom in enumerate(self.points)}

        self.counts_per_radian = 2 ** plant["encoder_bits"] / tau
        self.torque = np.zeros(JOINTS)
        self.force = np.zeros((CONTACTS, 3))
        self.push(*(plant[f"push_{key}"] for key in ("impulse", "time", "duration", "body")))
        mujoco.mj_step1(self.model, self.data)

    def push(self, impulse, time, duration, body=""):
        """Pushes a body's centre of mass, by default the base's, from a time on [s]: an impulse in the world frame [N·s], spread over
        a duration [s]."""
        step = self.model.opt.timestep
        first, count = round(time / step), max(1, round(duration / step))
        self.pushed, self.pushed_steps = self.bodies.get(body, self.base), range(first, first + count)
        self.push_force = np.array(impulse) / (count * step)

    def counts(self):
        counts = [round(angle * self.counts_per_radian) for angle in self.data.qpos[self.angles].tolist()]
        return counts + [0] * (JOINTS - len(counts))

    def report(self, truth):
        data, joints = self.data, len(self.angles)
        motion = np.zeros(6)
        mujoco.mj_objectVelocity(self.model, data, mujoco.mjtObj.mjOBJ_XBODY, self.base, motion, 0)
        truth.base_position[:], truth.base_orientation[:] = data.xpos[self.base], data.xquat[self.base]
        truth.base_spin[:], truth.base_velocity[:] = motion[:3], motion[3:]
        truth.angle[:joints], truth.rate[:joints] = data.qpos[self.angles].tolist(), data.qvel[self.rates].tolist()
        truth.torque[:], truth.contact_force[:] = self.torque, self.force.ravel()
        heights = data.geom_xpos[self.points, 2] - self.model.geom_size[self.points, 0]
        truth.natural_map = truth.signorini = truth.slip_misalignment = truth.energy_gain = np.nan  # not defined for MuJoCo
        truth.penetration = max(0.0, -heights.min(initial=0.0))

    def advance(self, torques):
        joints, wrench = len(self.angles), np.zeros(6)
        limits = self.model.actuator_ctrlrange
        self.data.ctrl[:] = self.torque[:joints] = np.clip(torques[:joints], limits[:, 0], limits[:, 1])
        self.force[:] = 0.0
        for _ in range(self.steps):
            is_pushed = round(self.data.time / self.model.opt.timestep) in self.pushed_steps
            self.data.xfrc_applied[self.pushed, :3] = self.push_force * is_pushed
            mujoco.mj_step2(self.model, self.data)
            contacts = self.data.contact
            for k, (geoms, frame) in enumerate(zip(contacts.geom.tolist(), contacts.frame.reshape(-1, 3, 3))):
                at = self.point[max(geoms)]  # the ground is geom 0; its force on the point is along the normal
                if at < CONTACTS:
                    mujoco.mj_contactForce(self.model, self.data, k, wrench)
                    self.force[at] += wrench[:3] @ frame / self.steps
            mujoco.mj_step1(self.model, self.data)
        if not np.isfinite(self.data.qpos).all():
            link.fail(4, f"MuJoCo's state is not finite after {self.data.time:.3f} s")


if __name__ == "__main__":
    if sys.argv[1:] not in ([], ["--soft"]):
        link.fail(2, "the only option is --soft: contacts with MuJoCo's own parameters")
    link.serve(partial(Plant, soft="--soft" in sys.argv))
