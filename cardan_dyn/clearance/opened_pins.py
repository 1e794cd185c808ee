"""Opened pins: how a universal joint gives way where bearings of its pins have clearance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import ModelError
from ..mechanism.mechanism import Mechanism
from .opened_joint import Mobility
from .opened_mechanism import OpenedMechanism, across
from .universal_joint import Bearing, UniversalPin

_SAME = 1e-9
"""Singular value of the bearings' motions, as a fraction of the greatest, that counts as zero."""
_PUSHED = 1e-7
"""Part of a force that moves what has no mass, as a fraction of it, that counts as none."""


class PinMobility(NamedTuple):
    """How open bearings give way at one position.

    Forces and motions of all `B` open bearings stand below each other, each along t and n.

    Attributes:
        movable: `(2 B, f)` orthonormal: motions of the bearings that the rest of the mechanism
            leaves. What is normal to them are forces that loops leave open.
        mobility: of forces that act on what has mass alone.
        frames: `(B, 2, 3)` t and n of each bearing in the world.
    """

    movable: Array
    mobility: Mobility
    frames: Array

    @property
    def freedoms(self) -> int:
        """In how many ways the open bearings can move."""
        return int(self.movable.shape[1])

    def determined(self, force: Array) -> Array:
        """Return the part of stacked forces `(2 B,)` that the motion of the bearings decides."""
        return np.asarray(self.movable @ (self.movable.T @ force))


class OpenedPins:
    """A mechanism in which some bearings of a universal joint have play.

    Both bearings of a pin stand at ± its radius from the joint's centre and hold the pin across its
    axis; along it, the pin stays held. A bearing that is not opened stays tight.
    W = J [M⁻¹ − M⁻¹Aᵀ(A M⁻¹ Aᵀ)⁻¹A M⁻¹] Jᵀ with the rows J of the open bearings; the tight ones are
    among A. Parts without mass, such as a massless cross, take no force.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        pins: tuple[UniversalPin, UniversalPin],
        bearings: Sequence[Bearing],
        places: Array,
        fixed: Sequence[int],
        rotors: Mapping[int, float],
    ) -> None:
        """Open bearings.

        Args:
            mechanism: that has the joint.
            pins: of the cross.
            bearings: that have play.
            places: `(2, 2)` for each pin where its bearings `+` and `-` are, from the origin of its
                joint along its axis [m].
            fixed: velocity coordinates that are driven or held.
            rotors: velocity coordinates that move freely to inertias that turn with them [kg m²].
        """
        self._pins, self._bearings = pins, tuple(bearings)
        opened = sorted({bearing.pin for bearing in bearings})
        self._basis = {index: across(pins[index].part.axis) for index in opened}
        self._rows = {
            (index, sign): _motion(place)
            for index in opened
            for sign, place in zip((1.0, -1.0), places[index], strict=True)
        }
        is_open = {(bearing.pin, bearing.sign) for bearing in bearings}
        closed = {
            pins[index].part.id: rows
            for (index, sign), rows in self._rows.items()
            if (index, sign) not in is_open
        }
        freedoms = {
            pins[index].part.id: [
                (kind, axis) for kind in ("prismatic", "revolute") for axis in self._basis[index]
            ]
            for index in opened
        }
        self._opened = OpenedMechanism(mechanism, freedoms, fixed, rotors, closed)

    def mobility(self, x: Array) -> PinMobility:
        """Return how the bearings give way.

        Args:
            x: `(size,)` closed coordinates of the mechanism.

        Raises:
            ModelError: no bearing can move, or nothing that would move has mass.
        """
        ways, own, rounding = self._opened.ways(x)
        frames = self._frames()
        apart = self._apart(frames, ways)
        names = ", ".join(bearing.name for bearing in self._bearings)
        left, sizes, _ = np.linalg.svd(apart, full_matrices=False)
        greatest = float(np.max(sizes, initial=0.0))
        rank = int(np.count_nonzero(sizes > _SAME * greatest))
        if not rank:
            raise ModelError(
                f"with clearance in {names} alone nothing can move, since all other bearings are "
                "tight; open both bearings of a pin, or some on each of both pins"
            )
        movable = left[:, :rank]
        inertias, principal = np.linalg.eigh(own)
        is_heavy = inertias > rounding
        apart = apart @ principal
        light = movable.T @ apart[:, ~is_heavy]
        kept, sizes, _ = np.linalg.svd(light)
        count = int(np.count_nonzero(sizes > _SAME * greatest))
        axes = (movable @ kept[:, count:]).T
        if not len(axes):
            raise ModelError(
                f"{names}: what would move there has no mass; give the links on both sides a mass"
            )
        heavy = axes @ apart[:, is_heavy]
        matrix = (heavy / inertias[is_heavy]) @ heavy.T
        return PinMobility(movable, Mobility(axes, matrix), frames)

    def _frames(self) -> Array:
        """Return t and n of each bearing in the world `(B, 2, 3)`."""
        axes = [self._opened.axis(pin.part) for pin in self._pins]
        normal = np.cross(axes[0], axes[1])
        normal /= np.linalg.norm(normal)
        return np.array([[np.cross(normal, axes[item.pin]), normal] for item in self._bearings])

    def _apart(self, frames: Array, ways: Array) -> Array:
        """Return how bearings move per way `(2 B, f)` [m], each along t and n."""
        parts = []
        for bearing, frame in zip(self._bearings, frames, strict=True):
            body = self._pins[bearing.pin].part.id
            slides = np.array(self._basis[bearing.pin]) @ self._opened.rotation(body).T
            motion = self._rows[bearing.pin, bearing.sign] @ ways[self._opened.added[body]]
            parts.append(frame @ slides.T @ motion)
        return np.concatenate(parts)


def _motion(place: float) -> Array:
    """Return how a bearing moves `(2, 4)` with two slides and two tilts, along the slides."""
    return np.array([[1.0, 0.0, 0.0, place], [0.0, 1.0, -place, 0.0]])
