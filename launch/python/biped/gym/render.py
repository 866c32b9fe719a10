"""A picture of the robot: the boxes of its bodies in orthographic projection. It needs Pillow."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import Scene

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

_SIZE, _SCALE = (480, 480), 500.0  # [pixels], [pixels/m]
_AZIMUTH, _ELEVATION = np.radians(-60.0), np.radians(12.0)
_SKY, _GROUND, _FILL, _EDGE = (255, 255, 255), (228, 228, 222), (138, 170, 204), (40, 60, 90)

# The six faces of a box as corners of ±1, each turning the same way seen from outside.
_CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


class Picture:
    """Draws robots of a scene."""

    def __init__(self, scene: Scene) -> None:
        from PIL import Image, ImageDraw

        self._image, self._pen = Image, ImageDraw
        bodies = tomllib.loads(scene.text)["bodies"]
        self._bodies = {body["name"]: body for body in bodies}
        self._joints = [body["name"] for body in bodies if "joint" in body]
        ahead, up = np.array([np.cos(_AZIMUTH), np.sin(_AZIMUTH), 0.0]), np.array([0.0, 0.0, 1.0])
        look = ahead * np.cos(_ELEVATION) + up * np.sin(_ELEVATION)  # toward the viewer
        right = np.cross(up, ahead)
        self._view = np.array([right, np.cross(look, right), look])

    def draw(self, truth: Any) -> NDArray[np.uint8]:
        """The picture, shape (480, 480, 3)."""
        center = np.array([truth.base_position[0], truth.base_position[1], 0.28])
        image = self._image.new("RGB", _SIZE, _SKY)
        pen = self._pen.Draw(image)
        pen.rectangle((0, float(self._pixels(np.zeros(3), center * [0, 0, 1])[1]), *_SIZE), _GROUND)
        faces = []
        for name, (turn, place) in self._poses(truth).items():
            body = self._bodies[name]
            corners = place + (np.array(body["com"]) + _CORNERS * np.array(body["size"]) / 2) @ turn.T
            for face in _FACES:
                points = corners[list(face)]
                if np.cross(points[1] - points[0], points[2] - points[1]) @ self._view[2] > 0:
                    faces.append((float(points.mean(axis=0) @ self._view[2]), points))
        for _, points in sorted(faces, key=lambda face: face[0]):
            pen.polygon([tuple(self._pixels(point, center)) for point in points], _FILL, _EDGE)
        return np.asarray(image)

    def _pixels(self, point: Any, center: Any) -> Any:
        across, up, _ = self._view @ (point - center)
        return np.array([_SIZE[0] / 2 + _SCALE * across, _SIZE[1] / 2 - _SCALE * up])

    def _poses(self, truth: Any) -> dict[str, tuple[Any, Any]]:
        """Rotation and place of each body's frame, from the base outward."""
        angles = dict(zip(self._joints, truth.angle))
        poses: dict[str, tuple[Any, Any]] = {}

        def pose(name: str) -> tuple[Any, Any]:
            if name not in poses:
                joint = self._bodies[name].get("joint")
                if joint is None:
                    w, *v = truth.base_orientation
                    poses[name] = (_turn(w, np.array(v)), np.array(truth.base_position))
                else:
                    turn, place = pose(joint["parent"])
                    half = angles[name] / 2
                    own = _turn(np.cos(half), np.sin(half) * np.array(joint["axis"]))
                    poses[name] = (turn @ own, place + turn @ np.array(joint["at"]))
            return poses[name]

        for name in self._bodies:
            pose(name)
        return poses


def _turn(w: float, v: Any) -> Any:
    """The matrix of a unit quaternion."""
    cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross
