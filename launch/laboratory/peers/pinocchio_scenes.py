"""Pinocchio's cone solvers in a stepper of our own, because Pinocchio has no stepper.

The step is semi-implicit Euler: free velocity, contact impulses of Coulomb's cone (De Saxce's form) at the points that
touch, configuration with the new velocity. A point that has penetrated is not pushed out. Servos are implicit: their stiffness and
damping act as armature.

Time is that spent in Pinocchio's own functions, by the wall clock and the median step, so that the Python between them
does not count; a binding call still costs about a microsecond.
"""

import time

import numpy as np
import pinocchio as pin

from simulation import Timed

ENGINE = "Pinocchio"
VERSION = pin.__version__
DTS = [1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4]
METHODS = {"ADMM 1e-6": ("ADMM", 1e-6), "ADMM 1e-9": ("ADMM", 1e-9), "PGS 1e-9": ("PGS", 1e-9)}
NEAR = 1e-6  # a point no higher than this touches [m]


class Simulation(Timed):
    """One scene under one solver."""

    def __init__(self, scene, method, dt):
        self.scene, self.dt = scene, dt
        self.model = pin.buildModelFromXML(scene.urdf, pin.JointModelFreeFlyer())
        self.stiffness, self.damping, self.rest, angles, rates = np.array(
            [(joint.stiffness, joint.damping, joint.rest, joint.angle, joint.rate) for joint in scene.joints]
        ).reshape(-1, 5).T  # the model has the joints in the order of the bodies
        self.model.armature[6:] = dt * self.damping + dt**2 * self.stiffness
        self.start = angles, rates
        self.watched = [self.model.getJointId(body.joint.name) if body.joint else 1 for body in scene.touching]
        self.radius = scene.touching[0].radius
        points = [(joint, point) for joint, body in zip(self.watched, scene.touching) for point in body.points]
        self.model.gravity.linear = scene.gravity_vector
        self.data = self.model.createData()
        self.points = [(joint, np.array(point)) for joint, point in points] if scene.contact else []
        self.ground = [_contact(self.model, joint, point, scene.friction) for joint, point in self.points]
        solver, tolerance = METHODS[method]
        self.settings = getattr(pin, f"{solver}SolverSettings")()
        for kind in ("feasibility", "complementarity"):
            setattr(self.settings, f"absolute_{kind}_tol", tolerance)
            setattr(self.settings, f"relative_{kind}_tol", 0.0)
        self.settings.max_iterations = 1000
        self.new_solver = getattr(pin, f"{solver}ConstraintSolver")
        self.new_result = getattr(pin, f"{solver}SolverResult")
        self.solvers = {}  # by the set of active points
        self.reset()

    def reset(self):
        """Back to the start of the scene."""
        scene = self.scene
        w, x, y, z = scene.quaternion
        turn = pin.Quaternion(w, x, y, z).matrix()
        angles, rates = self.start
        self.q = np.array([*scene.position, x, y, z, w, *angles])
        self.v = np.array([*turn.T @ scene.velocity, *turn.T @ scene.spin, *rates])
        self.active = None

    def step(self):
        """One step; the seconds it took in Pinocchio."""
        model, data, dt, q, v, clock = self.model, self.data, self.dt, self.q, self.v, time.perf_counter_ns
        torque = np.zeros(model.nv)
        torque[6:] = self.stiffness * (self.rest - q[7:] - dt * v[6:]) - self.damping * v[6:]
        start = clock()
        free = v + dt * pin.aba(model, data, q, v, torque, pin.Convention.WORLD)
        places = data.oMi
        native = clock() - start
        free[:3] += dt * np.cross(v[3:6], v[:3])  # of the base's origin in W, in axes of the base as they are now
        if self.radius:
            self._follow_balls(places)
        gaps = [places[joint].act(point)[2] - self.radius for joint, point in self.points]
        active = tuple(i for i, gap in enumerate(gaps) if gap <= NEAR)
        if active:
            constraints, values, cholesky, solver, result = self._solver(active)
            start = clock()
            pin.crba(model, data, q, pin.Convention.WORLD)
            for constraint, value in zip(constraints, values):
                constraint.calc(model, data, value)
            cholesky.compute(model, data, constraints, values, 1e-10)
            jacobian = pin.getConstraintsJacobian(model, data, constraints, values)
            velocity = jacobian @ free
            delassus = cholesky.getDelassusOperatorCholeskyExpression()
            solver.solve(delassus, velocity, constraints, values, self.settings, result)
            impulse = result.retrieveConstraintImpulses()
            pin.cholesky.decompose(model, data)
            free = free + pin.cholesky.solve(model, data, jacobian.T @ impulse)
            result.setConstraintImpulseGuess(impulse)
            native += clock() - start
        start = clock()
        self.q = pin.integrate(model, q, dt * free)
        native += clock() - start
        way = places[1].rotation @ free[:3]
        self.q[:3] = q[:3] + dt * way
        self.v = free
        self.v[:3] = pin.Quaternion(self.q[3:7]).matrix().T @ way
        return native * 1e-9

    def _follow_balls(self, places):
        """Moves the contacts to the points of the balls that are lowest now."""
        down = np.array((0.0, 0.0, -self.radius))
        touching = [(joint, point + places[joint].rotation.T @ down) for joint, point in self.points]
        self.ground = [_contact(self.model, joint, point, self.scene.friction) for joint, point in touching]
        self.solvers.clear()
        self.active = None

    def _solver(self, active):
        """Constraints, decomposition, solver and result of a set of points; solver and result are new when the set changes."""
        if active not in self.solvers:
            constraints, values = pin.StdVec_ConstraintModel(), pin.StdVec_ConstraintData()
            for i in active:
                constraints.append(self.ground[i])
                values.append(self.ground[i].createData())
            cholesky = pin.ConstraintCholeskyDecomposition(self.model, self.data, constraints, values)
            size = 3 * len(active)
            self.solvers[active] = [constraints, values, cholesky, self.new_solver(size), self.new_result()]
        if active != self.active:
            self.solvers[active][3:] = self.new_solver(3 * len(active)), self.new_result()
            self.active = active
        return self.solvers[active]

    def row(self):
        """State, as simulation.py has it."""
        if not self.scene.contact:
            return [pin.computeKineticEnergy(self.model, self.data, self.q, self.v)]
        if self.watched == [1]:  # the base, whose coordinates are its pose
            return [*self.q[:3], self.q[6], *self.q[3:6]]
        pin.forwardKinematics(self.model, self.data, self.q)
        poses = [pin.SE3ToXYZQUAT(self.data.oMi[joint]) for joint in self.watched]
        return np.concatenate([[*pose[:3], pose[6], *pose[3:6]] for pose in poses])


def _contact(model, joint, point, friction):
    """A point of a body that touches the ground, normal along z of the world."""
    contact = pin.PointContactConstraintModel(model, 0, pin.SE3.Identity(), joint, pin.SE3(np.eye(3), np.array(point)))
    contact.setFriction(friction)
    return pin.ConstraintModel(contact)
