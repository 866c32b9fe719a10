"""PyBullet: bodies as Featherstone multibodies without Bullet's damping, servos as explicit torques.

Time is that spent in `stepSimulation`, by the wall clock and the median step: torques, set from Python, do not count.
"""

import tempfile
import time
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pybullet as p

from simulation import Timed

ENGINE = "PyBullet"
VERSION = version("pybullet")
DTS = [1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4]
METHODS = {
    "default": {},
    "200 iterations": {"numSolverIterations": 200, "solverResidualThreshold": 0},
    "LCP PGS": {"constraintSolverType": p.CONSTRAINT_SOLVER_LCP_PGS},
}


class Simulation(Timed):
    """One scene under one solver."""

    def __init__(self, scene, method, dt):
        self.scene, self.dt, self.settings = scene, dt, METHODS[method]
        self.folder = tempfile.TemporaryDirectory()
        self.urdf = Path(self.folder.name) / "body.urdf"
        self.urdf.write_text(scene.urdf.replace("revolute", "continuous"))
        if not p.isConnected():
            p.connect(p.DIRECT)
        self.reset()

    def reset(self):
        """Back to the start of the scene."""
        scene = self.scene
        p.resetSimulation()
        p.setPhysicsEngineParameter(fixedTimeStep=self.dt, numSubSteps=0, **self.settings)
        p.setGravity(*scene.gravity_vector)
        if scene.contact:
            ground = p.createMultiBody(0, p.createCollisionShape(p.GEOM_PLANE))
            p.changeDynamics(ground, -1, lateralFriction=1)  # frictions are multiplied
        w, x, y, z = scene.quaternion
        self.body = p.loadURDF(str(self.urdf), scene.position, [x, y, z, w], flags=p.URDF_USE_INERTIA_FROM_FILE)
        p.resetBaseVelocity(self.body, scene.velocity, scene.spin)
        links = range(-1, p.getNumJoints(self.body))
        none = ("linearDamping", "angularDamping", "jointDamping", "restitution", "rollingFriction", "spinningFriction")
        for link in links:
            p.changeDynamics(self.body, link, lateralFriction=scene.friction, **dict.fromkeys(none, 0))
            if not scene.contact:
                p.setCollisionFilterGroupMask(self.body, link, 0, 0)
        names = [p.getJointInfo(self.body, joint)[1].decode() for joint in links[1:]]
        self.joints = [names.index(hinge.name) for hinge in scene.joints]
        for joint, hinge in zip(self.joints, scene.joints):
            p.resetJointState(self.body, joint, hinge.angle, hinge.rate)
        if self.joints:
            p.setJointMotorControlArray(self.body, self.joints, p.VELOCITY_CONTROL, forces=[0] * len(self.joints))
        self.watched = [names.index(body.joint.name) if body.joint else -1 for body in scene.touching]

    def step(self):
        """One step; the seconds it took in Bullet."""
        scene = self.scene
        if any(hinge.stiffness for hinge in scene.joints):
            torques = [
                hinge.stiffness * (hinge.rest - state[0]) - hinge.damping * state[1]
                for hinge, state in zip(scene.joints, p.getJointStates(self.body, self.joints))
            ]
            p.setJointMotorControlArray(self.body, self.joints, p.TORQUE_CONTROL, forces=torques)
        start = time.perf_counter()
        p.stepSimulation()
        return time.perf_counter() - start

    def row(self):
        """State, as simulation.py has it."""
        if not self.scene.contact:
            return [self.kinetic_energy()]
        return np.concatenate([self.pose(link) for link in self.watched])

    def pose(self, link):
        """Pose of a link's frame; link -1 is the base."""
        if link < 0:
            position, (x, y, z, w) = p.getBasePositionAndOrientation(self.body)
        else:
            position, (x, y, z, w) = p.getLinkState(self.body, link, computeForwardKinematics=True)[4:6]
        return [*position, w, x, y, z]

    def kinetic_energy(self):
        """Kinetic energy of all links, from their velocities."""
        velocity, spin = p.getBaseVelocity(self.body)
        moving = [(-1, p.getBasePositionAndOrientation(self.body)[1], velocity, spin)]
        for joint in self.joints:
            state = p.getLinkState(self.body, joint, computeLinkVelocity=True, computeForwardKinematics=True)
            moving.append((joint, state[1], state[6], state[7]))
        energy = 0.0
        for link, attitude, velocity, spin in moving:
            mass, _, inertia = p.getDynamicsInfo(self.body, link)[:3]
            spin = np.array(p.getMatrixFromQuaternion(attitude)).reshape(3, 3).T @ spin
            energy += mass * np.dot(velocity, velocity) / 2 + inertia @ spin**2 / 2
        return energy
