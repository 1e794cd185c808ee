"""Bodies of the viewer: where they are over the shown samples, and how their links are drawn."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..description.visual import Rgba
from ..errors import ModelError
from ..results.sweep import Sweep
from . import shapes as forms
from .commands import STEADY, Color, Drawing, Pose, mesh, node_name
from .still import Still
from .visuals import Shape, few_enough, shapes_of

GROUND = Color.of("#6f7780")
"""Colour of what stands still, where nothing states another."""
PALETTE = tuple(
    Color.of(css) for css in ("#0072b2", "#a08400", "#a8417e", "#008f68", "#6d62c9", "#b84600")
)
"""Colours of bodies of which nothing states one, in turn. Neighbours in the list differ for all
eyes, and each stands out from a light and from a dark background (WCAG 2.2: at least 3 to 1)."""
_WHITEST = 0.85
"""Share of a stated colour that is drawn: the viewer's lights together are brighter than one."""
_ROD_RADIUS = 0.008
"""Radius of these rods, as a fraction of the radius of the scene."""
_CORNER_STRIDE = 8
"""Every how manieth sample the corners of the shapes are followed: they only decide how much the
camera has to see, and between two such samples a corner moves little."""


class Bodies:
    """The bodies of a sweep's mechanism over the samples that are shown.

    Args:
        sweep: over one dimension.
        samples: `(n,)` indices of the samples that are shown.
        visuals: whether the shapes of the links are drawn; rods between the joints otherwise.

    Attributes:
        loops: names of the joints that close loops.
        shapes: the visuals of the links whose motion is known.
        notes: what is drawn otherwise than the description says, and why.
    """

    def __init__(self, sweep: Sweep | Still, samples: Array, visuals: bool) -> None:
        mechanism = sweep.mechanism
        self._sweep, self._samples = sweep, samples
        self._length = mechanism.characteristic_length
        self.loops = frozenset(loop.joint for loop in mechanism.loops)
        self._joint_of_body = {
            joint.id: name
            for name, joint in mechanism.joints.items()
            if joint.id and name not in self.loops
        }
        self._link_of_body: dict[int, str] = {}
        for name, (body, _) in mechanism.links.items():
            self._link_of_body.setdefault(body, name)
        shapes, self.notes = shapes_of(mechanism) if visuals else ([], ())
        self.shapes = [shape for shape in shapes if self._known(shape.body)]

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

    def on_ground(self) -> frozenset[str]:
        """Return the joints that carry what moves on what stands still over the shown samples."""
        return frozenset(
            name
            for name, ends in self._ends().items()
            if len({self._stands(body) for body in ends}) == 2
        )

    def _stands(self, body: int) -> bool:
        """Return whether a body does not move; of one sample alone, whether it is the ground."""
        if body == 0 or len(self._samples) == 1 or not self._known(body):
            return body == 0
        rotation, position = self._placement(body)
        moves = np.ptp(rotation, axis=0).max() > STEADY
        return not (moves or np.ptp(position, axis=0).max() > STEADY * self._length)

    def _ends(self) -> dict[str, tuple[int, int]]:
        """Return which bodies each joint connects: its parent's, then its child's."""
        mechanism = self._sweep.mechanism
        ends = {
            name: (int(mechanism.model.parents[joint.parts[0].id]), joint.id)
            for name, joint in mechanism.joints.items()
            if joint.parts
        }
        for loop in mechanism.loops:
            parent = loop.predecessor if loop.is_fixed else ends[loop.joint][0]
            ends[loop.joint] = parent, loop.successor
        return ends

    def draw(self, drawing: Drawing, radius: float) -> None:
        """Draw the shapes of the links, or rods if there are none.

        Args:
            drawing: what they are drawn on.
            radius: of the scene [m].
        """
        if self.shapes:
            self._draw_shapes(drawing, radius)
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

    def _draw_shapes(self, drawing: Drawing, radius: float) -> None:
        shapes, note = few_enough(self.shapes, radius)
        self.notes += (note,) if note else ()
        for body in sorted({shape.body for shape in shapes}):
            node = f"/mechanism/{node_name(self._link_of_body[body])}"
            drawing.place(node, self._pose(body))
            for count, shape in enumerate(item for item in shapes if item.body == body):
                color = self._color(body) if shape.color is None else _lit(shape.color)
                geometry, placement = shape.drawn(radius)
                path = f"{node}/{node_name(shape.link)} {count}"
                drawing.add(path, geometry, color, placement)

    def _color(self, body: int) -> Color:
        """Return the colour of a body of which nothing states one."""
        return PALETTE[(body - 1) % len(PALETTE)] if body else GROUND

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
                drawing.add(f"{node}/rod {index}", mesh(rod), self._color(body))

    def _joints_of_bodies(self) -> dict[int, list[str]]:
        """Return which joints each body carries."""
        joints_of: dict[int, list[str]] = {}
        for name, ends in self._ends().items():
            for body in ends:
                joints_of.setdefault(body, []).append(name)
        return joints_of


def _lit(rgba: Rgba) -> Color:
    """Return a stated colour as it is drawn: pure white would lose its shades in the light."""
    red, green, blue, opacity = rgba
    return Color(_WHITEST * red, _WHITEST * green, _WHITEST * blue, opacity)
