"""Drake: discrete point contact at the corners, its default of a soft ground (1 mm under the weight).

A box that lies on a half space touches in one point there, so the corners are points, as Drake's users make them.
Servos are springs and dampers in the joints. Time is that of `Simulator.AdvanceTo`, which loops in C++.
"""

import re
from importlib.metadata import version

import numpy as np
from pydrake.geometry import HalfSpace, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction, DiscreteContactApproximation
from pydrake.multibody.tree import RevoluteSpring
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

import scenes as s
from simulation import Traced

ENGINE = "Drake"
VERSION = version("drake")
DTS = [1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4]
METHODS = {
    "lagged (default)": DiscreteContactApproximation.kLagged,
    "SAP": DiscreteContactApproximation.kSap,
    "TAMSI": DiscreteContactApproximation.kTamsi,
}


class Simulation(Traced):
    """One scene under one approximation of contact."""

    def __init__(self, scene, method, dt):
        self.scene, self.dt = scene, dt
        builder = DiagramBuilder()
        self.plant, graph = AddMultibodyPlantSceneGraph(builder, time_step=dt)
        plant = self.plant
        plant.set_discrete_contact_approximation(METHODS[method])
        Parser(plant).AddModelsFromString(re.sub("<collision>.*?</collision>", "", scene.urdf), "urdf")
        plant.mutable_gravity_field().set_gravity_vector(scene.gravity_vector)
        for hinge in scene.joints:
            joint = plant.GetJointByName(hinge.name)
            joint.set_default_damping(hinge.damping)
            if hinge.stiffness:
                plant.AddForceElement(RevoluteSpring(joint, hinge.rest, hinge.stiffness))
        self.watched = [plant.GetBodyByName(body.name) for body in scene.touching]
        touching = [(body, point) for body, given in zip(self.watched, scene.touching) for point in given.points]
        friction = CoulombFriction(scene.friction, scene.friction)
        if scene.contact:
            ground, radius = plant.world_body(), scene.touching[0].radius or s.TIP
            plant.RegisterCollisionGeometry(ground, RigidTransform(), HalfSpace(), "ground", friction)
            for i, (body, point) in enumerate(touching):
                plant.RegisterCollisionGeometry(body, RigidTransform(point), Sphere(radius), f"corner {i}", friction)
        plant.Finalize()
        self.simulator = Simulator(builder.Build())
        self.root = self.simulator.get_mutable_context()
        self.context = plant.GetMyMutableContextFromRoot(self.root)
        self.reset()

    def reset(self):
        """Back to the start of the scene."""
        scene, plant = self.scene, self.plant
        q, v = np.zeros(plant.num_positions()), np.zeros(plant.num_velocities())
        q[:7] = [*scene.quaternion, *scene.position]
        v[:6] = [*scene.spin, *scene.velocity]
        for hinge in scene.joints:
            joint = plant.GetJointByName(hinge.name)
            q[joint.position_start()], v[joint.velocity_start()] = hinge.angle, hinge.rate
        self.root.SetTime(0)
        plant.SetPositions(self.context, q)
        plant.SetVelocities(self.context, v)
        self.simulator.Initialize()
        self.steps = 0

    def run(self, steps):
        """Advances, recording nothing."""
        self.steps += steps
        self.simulator.AdvanceTo(self.steps * self.dt)

    def row(self):
        """State, as simulation.py has it."""
        if not self.scene.contact:
            return [self.plant.CalcKineticEnergy(self.context)]
        if len(self.watched) == 1:  # the base, whose coordinates are its pose
            q = self.plant.GetPositions(self.context)
            return [*q[4:7], *q[:4]]
        poses = [body.EvalPoseInWorld(self.context) for body in self.watched]
        return np.concatenate([[*pose.translation(), *pose.rotation().ToQuaternion().wxyz()] for pose in poses])
