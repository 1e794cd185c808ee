"""Carried frames: where links and what is fixed in them are and how they move, by name.

By plain forward kinematics along the joints that carry them; nothing else of the mechanism is
looked at. Vectors are `(3, N)` in world axes.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ...kit.arrays import Array, cross
from ...kit.errors import ModelError
from .frames import Frames
from .mechanism import Mechanism

_AT_REST = np.zeros((3, 1))
_BLOCK = 4096
"""Samples that are placed at a time: many of them take little more memory than their results, and
frames, 96 bytes for every joint on the way, stay in the cache."""


class Rates(NamedTuple):
    """How a point and the body that carries it move, `(3, N)` each, in world axes.

    Attributes:
        velocity: of the point [m/s].
        spin: angular velocity of the body [rad/s].
        acceleration: of the point [m/s²].
        spin_rate: angular acceleration of the body [rad/s²].
    """

    velocity: Array
    spin: Array
    acceleration: Array
    spin_rate: Array

    def at(self, arm: Array, accelerations: bool) -> Rates:
        """Return the rates of another point of the body, at an arm `(3, N)` from this one."""
        swept = cross(self.spin, arm)
        velocity, acceleration = self.velocity + swept, self.acceleration
        if accelerations:
            acceleration = acceleration + cross(self.spin_rate, arm) + cross(self.spin, swept)
        return Rates(velocity, self.spin, acceleration, self.spin_rate)


class CarriedFrame:
    """A frame that moves with a body of a mechanism: a point of it and axes through that.

    Attributes:
        name: of the link, or of a frame that is fixed in one.
        columns: velocity coordinates `(k,)` that move it, from the world outwards.
    """

    def __init__(self, mechanism: Mechanism, name: object, xyz: Array) -> None:
        """Find what carries it.

        Args:
            mechanism: the mechanism.
            name: of a link; or else of a `fixed` joint of the tree, or of a site or frame of the
                description.
            xyz: `(3,)` the point in the axes of that [m].

        Raises:
            ModelError: unknown name; the message lists the valid ones.
        """
        self._frames = frames = mechanism.frames
        self.name, body, placement = _named(mechanism, frames, name)
        placement = placement.copy()
        placement[:3, 3] = placement[:3, :3] @ xyz + placement[:3, 3]
        last = frames.last[body] if body >= 0 else -1
        self._path = frames.motions_to(last)
        # The point is in the axes of the last motion; what stands in the world has no rates.
        self._last, self._placement = last, placement
        spans = [(frames.motions[k].rate, frames.motions[k].size) for k in self._path]
        self.columns = np.array([rate + k for rate, size in spans for k in range(size)], dtype=int)

    def placed(self, x: Array) -> tuple[Array, Array]:
        """Return rotations `(N, 3, 3)` to world axes, and points `(N, 3)` [m].

        Args:
            x: `(N, size)` coordinates.
        """
        rotations, points = np.empty((len(x), 3, 3)), np.empty((len(x), 3))
        for block in _blocks(len(x)):
            placed = self._frames.placed(x[block], self._path)
            frame = self._frames.fixed_in(placed, self._last, self._placement)
            rotations[block] = frame[:3].transpose(2, 1, 0)
            points[block] = frame[3].T + self._frames.corner
        return rotations, points

    def rates(self, x: Array, v: Array, a: Array | None = None) -> Rates:
        """Return how the point and the body move.

        Args:
            x: `(N, size)` coordinates.
            v: `(N, nv)` joint velocities.
            a: `(N, nv)` joint accelerations; if None, those of the result mean nothing.
        """
        rates = Rates(*np.empty((4, 3, len(x))))
        for block in _blocks(len(x)):
            found = self._rates(x[block], v[block], None if a is None else a[block])
            for values, part in zip(rates, found, strict=True):
                values[:, block] = part
        return rates

    def _rates(self, x: Array, v: Array, a: Array | None) -> Rates:
        """Return the rates of a block of samples, `(3, N)` or `(3, 1)` each."""
        frames, placed = self._frames, self._frames.placed(x, self._path)
        rates, accelerates = Rates(_AT_REST, _AT_REST, _AT_REST, _AT_REST), a is not None
        for index in self._path:
            motion, frame = frames.motions[index], placed[index]
            if motion.before >= 0:
                # Not the difference of two origins, which may be far away.
                arm = _turned(motion.placement[:3, 3], placed[motion.before])
                rates = rates.at(arm, accelerates)
            axes = list(frame[:3]) if motion.kind == "ball" else [_turned(motion.axis, frame)]
            own = further = _sum(axes, v, motion.rate)
            if a is not None:
                further = _sum(axes, a, motion.rate) + cross(rates.spin, own)
            if motion.kind == "slide":
                velocity, spin, acceleration, spin_rate = rates.at(
                    axes[0] * x[:, motion.column], accelerates
                )
                # Coriolis: the axis turns while the point moves along it, and the point with it.
                further = further + cross(spin, own) if accelerates else further
                rates = Rates(velocity + own, spin, acceleration + further, spin_rate)
            else:
                velocity, spin, acceleration, spin_rate = rates
                rates = Rates(velocity, spin + own, acceleration, spin_rate + further)
        if self._path:
            rates = rates.at(_turned(self._placement[:3, 3], placed[self._path[-1]]), accelerates)
        return rates


def _blocks(count: int) -> Iterator[slice]:
    """Iterate over blocks of samples."""
    return (slice(first, first + _BLOCK) for first in range(0, count, _BLOCK))


def _turned(vector: Array, frame: Array) -> Array:
    """Return a vector `(3,)` of a frame `(4, 3, N)` in world axes, `(3, N)`."""
    along = np.flatnonzero(vector)
    if len(along) == 1:
        return np.asarray(frame[along[0]] * vector[along[0]])
    return np.asarray((vector @ frame[:3].reshape(3, -1)).reshape(3, -1))


def _sum(axes: list[Array], rates: Array, first: int) -> Array:
    """Return the sum `(3, N)` of axes times rates `(N, nv)` from the first on."""
    terms = [axis * rates[:, first + k] for k, axis in enumerate(axes)]
    return np.asarray(sum(terms[1:], terms[0]))


def _named(mechanism: Mechanism, frames: Frames, name: object) -> tuple[str, int, Array]:
    """Return the name of a frame, the body that carries it, and its `(4, 4)` placement there.

    Links come first: descriptions may give other things the name of a link.
    """
    if name not in frames.link_frames and name in mechanism:
        described = mechanism.description.joints_and_loops
        joint = next(item for item in described if item.name == name)
        links = [
            getattr(joint, end)
            for end in ("parent", "child", "predecessor", "successor")
            if hasattr(joint, end)
        ]
        raise ModelError(
            f"{mechanism.name}: {name!r} is a joint, between the links {links[0]!r} and "
            f"{links[1]!r}: name one of them, or take origin({name!r}) and rotation({name!r})",
            name=joint.name,
        )
    mechanism.link_frame(name)  # It refuses what is none.
    return str(name), *frames.link_frames[str(name)]
