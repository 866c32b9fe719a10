"""MuJoCo as the plant: the robot of `biped export mjcf`, walked by whatever controller is at the other end.

    python3 -m pip install . mujoco   # in a clone of biped: its Python package
    biped run walk --plant "python3 plant/foreign/mujoco/plant.py"

MuJoCo's contacts give way and its friction creeps; STEP, TIME_CONSTANT, IMPEDANCE and IMPRATIO make them as hard as they
stay stable. docs/WIRE.md says how close the walk comes, and how little it takes.
"""

import sys
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
LACKING = ("latency_ticks", "stale_probability", "restitution", "push_impulse")  # keys that this plant does not support


class Plant:
    def __init__(self, scene, mjcf):
        plant = scene["plant"]
        for key in LACKING:
            if np.any(plant[key]):
                link.fail(2, f"this plant has no plant.{key}: leave it at zero")
        if "ground" in plant:
            link.fail(2, "the ground of this plant is the plane z = 0: leave out plant.ground")
        self.model = mujoco.MjModel.from_xml_string(mjcf)
        option, self.period = self.model.opt, 1.0 / scene["rate"]
        self.steps = int(np.ceil(self.period / STEP - 1e-9))
        option.timestep = self.period / self.steps
        option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        option.cone, option.solver = mujoco.mjtCone.mjCONE_ELLIPTIC, mujoco.mjtSolver.mjSOL_NEWTON
        option.impratio, option.iterations, option.tolerance = IMPRATIO, 100, 1e-12
        option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET  # what diverges shall be seen
        self.model.geom_solref[:] = [TIME_CONSTANT * option.timestep, 1.0]
        self.model.geom_solimp[:] = IMPEDANCE
        self.data = mujoco.MjData(self.model)
        mujoco.mj_resetDataKeyframe(self.model, self.data, self.model.keyframe("start").id)

        named = [body["name"].replace(" ", "_").replace("-", "_") for body in scene["bodies"]]
        self.base = next(self.model.body(name).id for name, b in zip(named, scene["bodies"]) if not b.get("joint"))
        joints = self.model.actuator_trnid[:, 0]  # motors are in wire order
        self.angles, self.rates = self.model.jnt_qposadr[joints], self.model.jnt_dofadr[joints]
        # contact points are counted by the order of the scene's bodies
        bodies = [self.model.body(name) for name in named]
        geoms = [geom for body in bodies for geom in body.geomadr[0] + np.arange(body.geomnum[0])]
        self.points = [geom for geom in geoms if self.model.geom_contype[geom] == 1]
        self.point = {int(geom): k for k, geom in enumerate(self.points)}

        self.counts_per_radian = 2 ** plant["encoder_bits"] / tau
        self.torque = np.zeros(JOINTS)
        self.force = np.zeros((CONTACTS, 3))
        mujoco.mj_step1(self.model, self.data)

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
        truth.natural_map = truth.signorini = truth.slip_misalignment = truth.energy_gain = np.nan  # not its terms
        truth.penetration = max(0.0, -heights.min(initial=0.0))

    def advance(self, torques):
        joints, wrench = len(self.angles), np.zeros(6)
        limits = self.model.actuator_ctrlrange
        self.data.ctrl[:] = self.torque[:joints] = np.clip(torques[:joints], limits[:, 0], limits[:, 1])
        self.force[:] = 0.0
        for _ in range(self.steps):
            mujoco.mj_step2(self.model, self.data)
            for k, contact in enumerate(self.data.contact):
                at = self.point[max(contact.geom)]  # the ground is geom 0; its force on the point is along the normal
                if at < CONTACTS:
                    mujoco.mj_contactForce(self.model, self.data, k, wrench)
                    self.force[at] += contact.frame.reshape(3, 3).T @ wrench[:3] / self.steps
            mujoco.mj_step1(self.model, self.data)
        if not np.isfinite(self.data.qpos).all():
            link.fail(4, f"MuJoCo's state is not finite after {self.data.time:.3f} s")


if __name__ == "__main__":
    link.serve(Plant)
