"""Siconos' contact solvers (Debian's python3-siconos) with a stepper of our own around them, for single bodies.

The step is Moreau and Jean's with theta = 1/2: contacts are those that touch at the predicted middle of the step, and
the configuration moves with the mean of old and new velocity. Siconos' own stepper finds contacts by Bullet in single
precision, which tilts the sliding cube.

Time is that of the solver alone, by the wall clock and the median step with contact: neither detection, nor the matrix,
nor the stepper counts.
"""

import time

import numpy as np
from siconos import numerics

from simulation import Timed

ENGINE = "Siconos"
VERSION = "4.4"  # as Debian has it
DTS = [1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4]
METHODS = {"NSGS (solver time alone)": numerics.SICONOS_FRICTION_3D_NSGS}
TOLERANCE = 1e-12
SINGLE_BODIES = True  # has no stepper for joints
NEAR = 1e-9  # a point no higher than this touches [m]


class Simulation(Timed):
    """One scene under one solver."""

    def __init__(self, scene, method, dt):
        self.scene, self.dt = scene, dt
        [self.body] = scene.bodies
        self.points, self.radius = np.array(self.body.points), self.body.radius
        self.inertia = np.array(self.body.inertia)
        self.options = numerics.SolverOptions(METHODS[method])
        self.options.iparam[numerics.SICONOS_IPARAM_MAX_ITER] = 1000
        self.options.dparam[numerics.SICONOS_DPARAM_TOL] = TOLERANCE
        self.reset()

    def reset(self):
        """Back to the start of the scene."""
        scene = self.scene
        self.place, self.attitude = np.array(scene.position, dtype=float), np.array(scene.quaternion)
        self.velocity, self.spin = np.array(scene.velocity, dtype=float), _turn(self.attitude).T @ scene.spin
        self.impulses = np.zeros(0)

    def step(self):
        """One step; the seconds it took in Siconos."""
        h, inertia, spin = self.dt, self.inertia, self.spin
        velocity = self.velocity + h * self.scene.gravity_vector
        gyroscopic = spin + h * np.cross(inertia * spin, spin) / inertia
        turn = _turn(_rotated(self.attitude, 0.5 * h * spin))
        heights = self.place[2] + 0.5 * h * self.velocity[2] + self.points @ turn[2] - self.radius
        touching = np.flatnonzero(heights <= NEAR)
        seconds = 0.0
        if touching.size:
            # Velocity of a point of the body, or of the lowest of a ball: v + (turn spin) x arm; rows are normal, then tangents.
            arms = [-_cross(turn @ point - (0, 0, self.radius)) @ turn for point in self.points[touching]]
            jacobian = np.concatenate([np.hstack([np.eye(3), arm])[[2, 0, 1]] for arm in arms])
            inverse = np.concatenate([np.full(3, 1 / self.body.mass), 1 / inertia])
            delassus = (jacobian * inverse) @ jacobian.T
            free = jacobian @ np.concatenate([velocity, gyroscopic])
            frictions = np.full(touching.size, self.scene.friction)
            problem = numerics.FrictionContactProblem(3, touching.size, delassus, free, frictions)
            impulses = self.impulses if self.impulses.size == free.size else np.zeros(free.size)
            start = time.perf_counter()
            numerics.fc3d_driver(problem, impulses, np.zeros(free.size), self.options)
            seconds = time.perf_counter() - start
            self.impulses = impulses
            change = inverse * (jacobian.T @ impulses)
            velocity, gyroscopic = velocity + change[:3], gyroscopic + change[3:]
        self.place = self.place + 0.5 * h * (self.velocity + velocity)
        self.attitude = _rotated(self.attitude, 0.5 * h * (spin + gyroscopic))
        self.velocity, self.spin = velocity, gyroscopic
        return seconds

    def row(self):
        """State, as simulation.py has it."""
        return [*self.place, *self.attitude]


def _cross(vector):
    x, y, z = vector
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def _turn(quaternion):
    w, *axis = quaternion
    cross = _cross(axis)
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross


def _rotated(quaternion, way):
    """The attitude after a turn by a rotation vector in the body's frame."""
    angle = np.linalg.norm(way)
    w, *axis = np.cos(angle / 2), *(np.sinc(angle / (2 * np.pi)) / 2 * way)
    a, b = quaternion[0], quaternion[1:]
    turned = np.array([a * w - b @ axis, *(a * np.array(axis) + w * b + np.cross(b, axis))])
    return turned / np.linalg.norm(turned)
