"""Opened joint: how easily the two sides of a pin move apart where its bush has play."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import ModelError
from ..mechanism.mechanism import Mechanism
from .opened_mechanism import OpenedMechanism, across

_IMMOBILE = 1e-13
"""Mobility along a direction, as a fraction of the greatest, that counts as none."""
_HELD = 1e-9
"""Part of a motion that counts as none."""


class Mobility(NamedTuple):
    """How opened joints give way at one position.

    Attributes:
        axes: `(k, d)` orthonormal directions in which sides can be pushed apart: of one pin
            `(2, 3)` across it, in the world; of several bearings in the space of all their forces.
        matrix: `(k, k)` W: acceleration of one side relative to the other per force between them,
            along these axes [1/kg].
    """

    axes: Array
    matrix: Array

    def reduced_mass(self, direction: Array, *, is_guided: bool = False) -> float:
        """Return the mass that a force along a direction `(d,)` has to move [kg].

        Args:
            direction: of the force.
            is_guided: whether the sides are held from moving across the direction; otherwise they
                are free to.
        """
        along = self._along(direction)
        if is_guided:
            values, axes = np.linalg.eigh(self.matrix)
            moves = values > _IMMOBILE * values[-1]
            return float(np.sum((along @ axes)[moves] ** 2 / values[moves]))
        return 1.0 / float(along @ self.matrix @ along)

    def deviation(self, direction: Array) -> float:
        """Return the angle between a force along a direction and the motion it causes [rad]."""
        along = self._along(direction)
        moved = self.matrix @ along
        part = float(along @ moved)
        beside = moved - part * along
        return float(np.arctan2(np.sqrt(beside @ beside), part))

    def _along(self, direction: Array) -> Array:
        along = self.axes @ direction
        return np.asarray(along / np.sqrt(along @ along))


class OpenedJoint:
    """A mechanism in which a turning joint has two slides across its axis.

    All its other joints and loops are closed, its drives prescribed or of a finite inertia:
    W = J [M⁻¹ − M⁻¹Aᵀ(A M⁻¹ Aᵀ)⁻¹A M⁻¹] Jᵀ, computed by the directions that the closure equations
    leave, so that redundant equations do no harm.
    """

    def __init__(
        self, mechanism: Mechanism, joint: str, fixed: Sequence[int], rotors: dict[int, float]
    ) -> None:
        """Open a joint.

        Args:
            mechanism: that has the joint.
            joint: name of a joint that turns about one axis.
            fixed: velocity coordinates that are driven or held.
            rotors: velocity coordinates that move freely to inertias that turn with them [kg m²].
        """
        self._name, self._length = joint, mechanism.characteristic_length
        (part,) = mechanism.joint(joint).parts
        self._body, self._axes = part.id, np.array(across(part.axis))
        slides = [("prismatic", axis) for axis in self._axes]
        self._opened = OpenedMechanism(mechanism, {part.id: slides}, fixed, rotors)

    def mobility(self, x: Array) -> Mobility:
        """Return how the joint gives way.

        Args:
            x: `(size,)` closed coordinates of the mechanism.

        Raises:
            ModelError: what would move has no mass.
        """
        ways, own, rounding = self._opened.ways(x)
        sizes = np.linalg.eigvalsh(own)
        if not sizes.size or sizes[0] <= rounding:
            raise ModelError(
                f"joint {self._name!r}: where it is open, something without mass is free to move; "
                "give all links between it and the drive a mass"
            )
        apart = ways[self._opened.added[self._body]]
        axes = (self._opened.rotation(self._body) @ self._axes.T).T
        return Mobility(axes, apart @ np.linalg.solve(own, apart.T))

    def gives_way(self, x: Array) -> bool:
        """Return whether it can move along both slides.

        Args:
            x: `(size,)` closed coordinates of the mechanism.
        """
        apart = self._opened.ways(x).rates[self._opened.added[self._body]] / self._length
        return bool(np.linalg.matrix_rank(apart, tol=_HELD) == 2)
