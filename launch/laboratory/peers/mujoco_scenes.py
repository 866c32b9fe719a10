"""MuJoCo. Runs are traced by `mujoco.rollout` and timed by `mj_step(model, data, nstep)`: both loop in C."""

import mujoco
import numpy as np
from mujoco import rollout

import scenes as s

ENGINE = "MuJoCo"
VERSION = mujoco.__version__
DTS = [1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4]
METHODS = {
    "default": {},
    "elliptic": {"cone": "elliptic"},
    "CG": {"solver": "CG"},
    "PGS": {"solver": "PGS"},
    "implicitfast": {"integrator": "implicitfast"},
    "RK4": {"integrator": "RK4"},
    "noslip": {"cone": "elliptic", "noslip_iterations": 10},
    "stiff": {"cone": "elliptic", "impratio": 100, "solref": 2},
    "stiff discrete": {"cone": "elliptic", "impratio": 1000, "solref": 2, "integrator": "discrete"},
}
FASTER = int(mujoco.mjtDisableBit.mjDSBL_ISLAND | mujoco.mjtDisableBit.mjDSBL_AUTORESET)  # one body: one island
SENSOR = int(mujoco.mjtDisableBit.mjDSBL_SENSOR)  # read in traces only
BAD = [mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC]
QUICK = ["default", "stiff discrete"]


class Simulation:
    """One scene with one method; `solref`, where given, is the time constant of contacts in step lengths."""

    def __init__(self, scene, method, dt):
        settings = dict(METHODS[method])
        solref = settings.pop("solref", None)
        spec = _spec(scene)
        for geom in spec.geoms:
            geom.friction[0] = scene.friction
            if solref:
                geom.solref = [solref * dt, 1]
        spec.option.timestep = dt
        spec.option.gravity = scene.gravity_vector
        for key, value in settings.items():
            enum = {"cone": "mjtCone", "solver": "mjtSolver", "integrator": "mjtIntegrator"}.get(key)
            name = {"cone": "mjCONE_", "solver": "mjSOL_", "integrator": "mjINT_"}.get(key, "") + str(value).upper()
            setattr(spec.option, key, getattr(getattr(mujoco, enum), name) if enum else value)
        spec.option.disableflags |= SENSOR | FASTER
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.scene = scene
        self.reset()

    def reset(self):
        """Back to the start of the scene."""
        scene, data = self.scene, self.data
        mujoco.mj_resetData(self.model, data)
        data.qpos[:7] = [*scene.position, *scene.quaternion]
        rotation = np.zeros(9)
        mujoco.mju_quat2Mat(rotation, data.qpos[3:7])
        data.qvel[:6] = [*scene.velocity, *rotation.reshape(3, 3).T @ scene.spin]  # spin is in the body's frame
        data.qpos[7:], data.qvel[6:] = [[getattr(joint, key) for joint in scene.joints] for key in ("angle", "rate")]

    def run(self, steps):
        """Advances, recording nothing."""
        mujoco.mj_step(self.model, self.data, steps)

    def trace(self, steps, stride):
        """Rows as simulation.py has them, from the start of the scene on."""
        self.reset()
        self.model.opt.disableflags &= ~SENSOR
        start = np.empty(mujoco.mj_stateSize(self.model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
        mujoco.mj_getState(self.model, self.data, start, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        # A row of sensors belongs to the state before its step, so one more step gives the last state.
        _, sensors = rollout.rollout(self.model, self.data, start[None], nstep=steps + 1)
        self.model.opt.disableflags |= SENSOR
        blown_up = any(self.data.warning[int(bad)].number for bad in BAD)  # a rollout then repeats its last row
        return sensors[0, ::stride] * (np.nan if blown_up else 1)


def _spec(scene):
    """The scene's bodies on a plane, with sensors for the trace."""
    spec = mujoco.MjSpec()
    spec.compiler.degree = False  # rest angles of springs
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1], contype=2, conaffinity=1, condim=3)
    nodes = []
    for body in scene.bodies:
        joint = body.joint
        parent, place = (nodes[joint.parent], joint.anchor) if joint else (spec.worldbody, [0, 0, 0])
        inertia = dict(mass=body.mass, ipos=body.com, inertia=body.inertia, explicitinertial=True)
        node = parent.add_body(name=body.name, pos=place, **inertia)
        nodes.append(node)
        if joint:
            hinge = node.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=joint.axis)
            hinge.stiffness[0], hinge.damping[0], hinge.springref = joint.stiffness, joint.damping, joint.rest  # linear terms
        else:
            node.add_freejoint()
        _touch(node, body)
    if not scene.contact:
        spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
        _sensor(spec, mujoco.mjtSensor.mjSENS_E_KINETIC)
        return spec
    for body in scene.touching:
        _sensor(spec, mujoco.mjtSensor.mjSENS_FRAMEPOS, body.name)
        _sensor(spec, mujoco.mjtSensor.mjSENS_FRAMEQUAT, body.name)
    return spec


def _touch(node, body):
    """Adds the shapes that may touch the plane."""
    touching = {"contype": 1, "conaffinity": 2, "condim": 3}
    if body.box:
        node.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, pos=body.com, size=[a / 2 for a in body.box], **touching)
        return
    for point in body.points:
        node.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[body.radius or s.TIP, 0, 0], pos=point, **touching)


def _sensor(spec, kind, body=None):
    at = {"objtype": mujoco.mjtObj.mjOBJ_XBODY, "objname": body} if body else {}
    spec.add_sensor(type=kind, **at)
