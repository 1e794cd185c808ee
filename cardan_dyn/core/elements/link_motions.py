"""Link motions: where some links are and how they move, by plain forward kinematics.

The bodies that move them are placed one after the other from the root, as Pinocchio's model has
them; other bodies are not looked at. The proof places links by the description instead.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ...kit.arrays import Array
from ..mechanism.joints import Part
from ..mechanism.mechanism import Mechanism


class LinkMotion(NamedTuple):
    """A frame that moves with a link, in world axes.

    Arrays have one sample or N: one where the frame stands in the world.

    Attributes:
        rotation: `(N, 3, 3)` from its axes to those of the world.
        position: `(N, 3)` of its origin about `LinkMotions.corner` [m].
        velocity: `(N, 3)` of its origin [m/s].
        spin: `(N, 3)` angular velocity [rad/s].
    """

    rotation: Array
    position: Array
    velocity: Array
    spin: Array

    def placed(self, placement: Array) -> LinkMotion:
        """Return a frame fixed in this one, by its `(4, 4)` placement there."""
        arm = self.rotation @ placement[:3, 3]
        return LinkMotion(
            self.rotation @ placement[:3, :3],
            self.position + arm,
            self.velocity + np.cross(self.spin, arm),
            self.spin,
        )


class _Step(NamedTuple):
    """How a body is placed in the one before it.

    Attributes:
        parent: index of the body before it; 0 is the world.
        part: its elementary part.
        placement: `(4, 4)` of its frame, with its part at zero, in that of the body before it.
        column: first column of its coordinates in a row `x`.
        rate: first column of its rates in a velocity.
    """

    parent: int
    part: Part
    placement: Array
    column: int
    rate: int


class LinkMotions:
    """Where some links of a mechanism are.

    Attributes:
        corner: `(3,)` the point about which positions are given, in world axes [m]: the middle of
            all joints on the world, so that no digits are lost far from the world's origin.
    """

    def __init__(
        self, mechanism: Mechanism, links: Iterable[str], bodies: Iterable[int] = ()
    ) -> None:
        """Find what moves the links.

        Args:
            mechanism: the mechanism.
            links: their names.
            bodies: indices of further bodies of `Mechanism.model`, for `bodies_at`.
        """
        model, coordinates = mechanism.model, mechanism.coordinates
        self._links = {name: mechanism.link_frames[name] for name in links}
        wanted: set[int] = set()
        for body in (*(body for body, _ in self._links.values()), *bodies):
            index = body
            while index > 0 and index not in wanted:
                wanted.add(index)
                index = model.parents[index]
        parts = zip(coordinates.parts, coordinates.starts, strict=True)
        placed = {part.id: (part, start) for part, start in parts if part.id in wanted}
        self._steps = {
            index: _Step(
                model.parents[index],
                placed[index][0],
                np.array(model.jointPlacements[index].homogeneous),
                placed[index][1],
                model.idx_vs[index],
            )
            for index in sorted(wanted)
        }
        roots = [
            model.jointPlacements[index].translation
            for index in range(1, model.njoints)
            if model.parents[index] == 0
        ]
        self.corner = np.mean(roots, axis=0) if roots else np.zeros(3)

    def at(self, x: Array, v: Array) -> dict[str, LinkMotion]:
        """Return the motions of the links' frames.

        Args:
            x: `(N, size)` coordinates.
            v: `(N, nv)` joint velocities.
        """
        bodies = self.bodies_at(x, v)
        return {
            name: bodies[body].placed(frame.homogeneous)
            for name, (body, frame) in self._links.items()
        }

    def bodies_at(self, x: Array, v: Array) -> dict[int, LinkMotion]:
        """Return the motions of the bodies that carry the links, and of those between them.

        Args:
            x: `(N, size)` coordinates.
            v: `(N, nv)` joint velocities.
        """
        none = np.zeros((1, 3))
        bodies = {0: LinkMotion(np.eye(3)[None], -self.corner[None], none, none)}
        for index, step in self._steps.items():
            start = bodies[step.parent].placed(step.placement)
            bodies[index] = _moved(start, step, x, v)
        return bodies


def _moved(start: LinkMotion, step: _Step, x: Array, v: Array) -> LinkMotion:
    """Return where a frame is after the motion of its part; `start` has the part at zero."""
    if step.part.kind == "spherical":
        rotation = start.rotation @ _of_quaternion(x[:, step.column : step.column + 4])
        rates = v[:, step.rate : step.rate + 3]
        # The rates of a ball are components in the frame that it moves.
        spin = start.spin + np.einsum("nij,nj->ni", rotation, rates)
        return LinkMotion(rotation, start.position, start.velocity, spin)
    direction = start.rotation @ step.part.axis
    coordinate, rate = x[:, step.column, None], v[:, step.rate, None]
    if step.part.kind == "prismatic":
        arm = direction * coordinate
        velocity = start.velocity + direction * rate + np.cross(start.spin, arm)
        return LinkMotion(start.rotation, start.position + arm, velocity, start.spin)
    # Rodrigues: R = 1 + sin K + (1 - cos) K²; the last factor without cancellation.
    a, b, c = step.part.axis
    skew = np.array([[0.0, -c, b], [c, 0.0, -a], [-b, a, 0.0]])
    sine, versine = np.sin(coordinate)[..., None], 2.0 * np.sin(0.5 * coordinate)[..., None] ** 2
    turn = np.eye(3) + sine * skew + versine * (skew @ skew)
    spin = start.spin + direction * rate
    return LinkMotion(start.rotation @ turn, start.position, start.velocity, spin)


def _of_quaternion(q: Array) -> Array:
    """Return the rotations `(N, 3, 3)` of unit quaternions `(N, 4)`, x, y, z, w."""
    vector, scalar = q[:, :3], q[:, 3, None, None]
    outer = vector[:, :, None] * vector[:, None, :]
    x, y, z = vector.T
    none = np.zeros_like(x)
    rows = [[none, -z, y], [z, none, -x], [-y, x, none]]
    skew = np.array(rows).transpose(2, 0, 1)
    # 1 + 2 (w K + K²), with K² = v vᵀ - |v|².
    square = np.einsum("ni,ni->n", vector, vector)[:, None, None]
    return np.asarray(np.eye(3) + 2.0 * (scalar * skew + outer - square * np.eye(3)))
