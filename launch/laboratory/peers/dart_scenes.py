"""DART: the ground is a large box, servos are springs and dampers in the joints (implicit).

Time is CPU time of a Python loop over `World.step`, which adds some tenths of a microsecond per step.
"""

import dartpy as dart
import numpy as np

from simulation import Traced

ENGINE = "DART"
VERSION = dart.__version__
DTS = [1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4]
METHODS = {
    "Dantzig (default)": None,
    "NSGS": dart.constraint.NsgsFrictionSolver,
}


class Simulation(Traced):
    """One scene under one solver."""

    def __init__(self, scene, method, dt):
        self.scene, self.method, self.dt = scene, method, dt
        self.reset()

    def reset(self):
        """Builds the scene again."""
        scene = self.scene
        body = dart.utils.DartLoader().parseSkeletonString(scene.urdf, dart.common.Uri())
        base = body.getRootJoint()
        w, x, y, z = scene.quaternion
        place = dart.math.Isometry3()
        place.set_rotation(dart.math.Quaternion(w, x, y, z).to_rotation_matrix())
        place.set_translation(scene.position)
        base.setTransform(place)
        base.setLinearVelocity(scene.velocity)
        base.setAngularVelocity(scene.spin)
        for hinge in scene.joints:
            joint = body.getJoint(hinge.name)
            joint.setPosition(0, hinge.angle)
            joint.setVelocity(0, hinge.rate)
            joint.setRestPosition(0, hinge.rest)
            joint.setSpringStiffness(0, hinge.stiffness)
            joint.setDampingCoefficient(0, hinge.damping)
        self.world, self.body = dart.simulation.World(), body
        self.world.setTimeStep(self.dt)
        self.world.setGravity(scene.gravity_vector)
        self.world.setCollisionDetector(dart.simulation.CollisionDetectorType.BULLET)
        if METHODS[self.method]:
            self.world.getConstraintSolver().setBoxedLcpSolver(METHODS[self.method]())
        self.world.addSkeleton(body)
        if scene.contact:
            self.world.addSkeleton(_ground())
        for skeleton in [self.world.getSkeleton(i) for i in range(self.world.getNumSkeletons())]:
            for node in skeleton.getBodyNodes():
                for shape in node.getShapeNodes():
                    if shape.hasDynamicsAspect():
                        shape.getDynamicsAspect().setFrictionCoeff(scene.friction)

    def run(self, steps):
        """Advances, recording nothing."""
        for _ in range(steps):
            self.world.step()

    def row(self):
        """State, as simulation.py has it."""
        if not self.scene.contact:
            return [self.body.computeKineticEnergy()]
        poses = [self.body.getBodyNode(body.name).getWorldTransform() for body in self.scene.touching]
        turns = [dart.math.Quaternion(pose.rotation()) for pose in poses]
        states = [[*np.ravel(pose.translation()), turn.w(), turn.x(), turn.y(), turn.z()] for pose, turn in zip(poses, turns)]
        return np.concatenate(states)


def _ground():
    """A box whose top is the plane z = 0."""
    ground = dart.dynamics.Skeleton("ground")
    _, node = ground.createWeldJointAndBodyNodePair()
    shape = node.createShapeNode(dart.dynamics.BoxShape([100.0, 100.0, 1.0]))
    shape.createCollisionAspect()
    shape.createDynamicsAspect()
    shape.setRelativeTranslation([0.0, 0.0, -0.5])
    return ground
