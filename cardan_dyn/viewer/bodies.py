"""Bodies of the viewer: where they are over the shown samples, and how their links are drawn."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import ModelError
from ..results.sweep import Sweep
from . import shapes as forms
from .commands import Color, Drawing, Pose, mesh, meshcat, node_name
from .still import Still
from .visuals import Shape, shapes

ROD_COLOR = Color.of("#7a8794")
"""Colour of the rods that stand for a body without visuals."""
_ROD_RADIUS = 0.008
"""Radius of these rods, as a fraction of the radius of the scene."""
_CORNER_STRIDE = 8
"""Every how manieth sample the corners of the shapes are followed: they only decide how much the
camera has to see, and between two such samples a corner moves little."""
_Y_TO_Z = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])
"""Turns meshcat's cylinders, which stand along y, to stand along z."""


class Bodies:
    """The bodies of a sweep's mechanism over the samples that are shown.

    Args:
        sweep: over one dimension.
        samples: `(n,)` indices of the samples that are shown.
        visuals: whether the shapes of the links are drawn; rods between the joints otherwise.

    Attributes:
        loops: names of the joints that close loops.
        shapes: the visuals of the links whose motion is known.
    """

    def __init__(self, sweep: Sweep | Still, samples: Array, visuals: bool) -> None:
        mechanism = sweep.mechanism
        self._sweep, self._samples = sweep, samples
        self.loops = frozenset(loop.joint for loop in mechanism.loops)
        self._joint_of_body = {
            joint.id: name
            for name, joint in mechanism.joints.items()
            if joint.id and name not in self.loops
        }
        self._link_of_body: dict[int, str] = {}
        for name, (body, _) in mechanism.links.items():
            self._link_of_body.setdefault(body, name)
        self.shapes = [
            shape for shape in (shapes(mechanism) if visuals else []) if self._known(shape.body)
        ]

    def points(self) -> Array:
        """Return the points `(n, 3)` between which the mechanism moves [m]; none if unknown."""
        origins = (self._origin(name) for name in self._sweep.mechanism.joints)
        return np.concatenate(
            [
                np.zeros((0, 3)),
                *(points for points in origins if points is not None),
                *(self._swept_corners(shape) for shape in self.shapes),
            ]
        )

    def draw(self, drawing: Drawing, radius: float) -> None:
        """Draw the shapes of the links, or rods if there are none.

        Args:
            drawing: what they are drawn on.
            radius: of the scene [m].
        """
        if self.shapes:
            self._draw_shapes(drawing)
        else:
            self._draw_rods(drawing, radius)

    def _known(self, body: int) -> bool:
        """Return whether the sweep knows how a body moves."""
        return body == 0 or (
            body in self._joint_of_body and self._origin(self._joint_of_body[body]) is not None
        )

    def _origin(self, joint: str) -> Array | None:
        """Return where a joint is `(n, 3)` [m]; None if the sweep leaves it out."""
        try:
            return self._sweep.origin(joint)[self._samples]
        except ModelError:
            return None

    def _placement(self, body: int) -> tuple[Array, Array]:
        """Return rotations and positions [m] of a known body, one each for the fixed base."""
        if body == 0:
            return np.eye(3)[None], np.zeros((1, 3))
        joint, samples = self._joint_of_body[body], self._samples
        return self._sweep.rotation(joint)[samples], self._sweep.origin(joint)[samples]

    def _pose(self, body: int) -> Pose:
        rotation, position = self._placement(body)
        return Pose.of(position, forms.quaternions(rotation))

    def _swept_corners(self, shape: Shape) -> Array:
        """Return the points `(n, 3)` through which the corners of a shape move [m]."""
        rotation, position = (array[::_CORNER_STRIDE] for array in self._placement(shape.body))
        turned = np.einsum("nij,kj->nki", rotation, shape.corners())
        return np.asarray((turned + position[:, None]).reshape(-1, 3))

    def _draw_shapes(self, drawing: Drawing) -> None:
        count = 0
        for body in sorted({shape.body for shape in self.shapes}):
            node = f"/mechanism/{node_name(self._link_of_body[body])}"
            drawing.place(node, self._pose(body))
            for shape in (item for item in self.shapes if item.body == body):
                color = Color(*shape.color[:3], opacity=shape.color[3])
                geometry, placement = _geometry(shape)
                drawing.add(f"{node}/{node_name(shape.link)} {count}", geometry, color, placement)
                count += 1

    def _draw_rods(self, drawing: Drawing, radius: float) -> None:
        """Draw each body as rods from the middle of its joints to each of them."""
        for body, joints in self._joints_of_bodies().items():
            if not self._known(body) or len(joints) < 2:
                continue
            rotation, position = (array[0] for array in self._placement(body))
            ends = np.array(
                [
                    rotation.T @ (self._sweep.origin(name)[self._samples][0] - position)
                    for name in joints
                ]
            )
            middle = ends.mean(axis=0)
            surfaces = [forms.path(np.array([middle, end]), _ROD_RADIUS * radius) for end in ends]
            # Joints that share their origin have no distance that a rod could span.
            rods = [surface for surface in surfaces if len(surface[0])]
            if not rods:
                continue
            node = f"/mechanism/{node_name(self._link_of_body.get(body, str(body)))}"
            drawing.place(node, self._pose(body))
            for index, rod in enumerate(rods):
                drawing.add(f"{node}/rod {index}", mesh(rod), ROD_COLOR)

    def _joints_of_bodies(self) -> dict[int, list[str]]:
        """Return which joints each body carries."""
        mechanism = self._sweep.mechanism
        joints_of: dict[int, list[str]] = {}
        for name, joint in mechanism.joints.items():
            ends = {joint.id} if name not in self.loops else set()
            if joint.parts:
                ends.add(int(mechanism.model.parents[joint.parts[0].id]))
            for body in ends:
                joints_of.setdefault(body, []).append(name)
        for loop in mechanism.loops:
            joints_of.setdefault(loop.successor, []).append(loop.joint)
        return joints_of


def _geometry(shape: Shape) -> tuple[Any, Array]:
    """Return a shape as meshcat's geometry, and its placement `(4, 4)` in its body."""
    geometry = meshcat().geometry
    if shape.kind == "box":
        return geometry.Box(shape.size), shape.placement
    if shape.kind == "sphere":
        return geometry.Sphere(shape.size[0]), shape.placement
    if shape.kind == "cylinder":
        return geometry.Cylinder(shape.size[1], shape.size[0]), shape.placement @ _Y_TO_Z
    return geometry.TriangularMeshGeometry(shape.vertices, shape.faces), shape.placement
