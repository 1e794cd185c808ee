"""Opened joint: how easily the two sides of a pin move apart where its bush has clearance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import ModelError
from ..mechanism.mechanism import Mechanism
from ..simulation.fourier import Fourier
from .opened_mechanism import OpenedMechanism, across
from .planar_motion import Plane

_IMMOBILE = 1e-13
"""Mobility along a direction, as a fraction of the greatest, that counts as none."""
_MEAN_OF = 8
_HELD = 1e-9
"""Part of a motion that counts as none."""


def mean_positions(period: float) -> Array:
    """Return positions of the drive over a period, of which mean masses are taken [rad]."""
    return period / _MEAN_OF * np.arange(_MEAN_OF)


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

    def mean_mass(self, states: Array, force: Array) -> float:
        """Return the mass by which a damping ratio is meant [kg], one number of the joint.

        The geometric mean of the reduced masses along the force without play, where a force counts
        as much as it is great.

        Args:
            states: `(N, size)` closed coordinates of the mechanism, at `mean_positions`.
            force: `(N, 3)` there, across the pin in the world [N].

        Raises:
            ModelError: what would move has no mass.
        """
        sizes = np.linalg.norm(force, axis=1)
        kept = sizes > _HELD * np.max(sizes, initial=0.0)
        mobilities = [self.mobility(x) for x in states[kept]]
        masses = [
            item.reduced_mass(direction)
            for item, direction in zip(mobilities, force[kept], strict=True)
        ]
        return float(np.exp(np.sum(sizes[kept] * np.log(masses)) / np.sum(sizes)))

    def plane(self, states: Array, velocities: Array, force: Array, period: float) -> Plane:
        """Return how the pin moves in its bush over a period, the motion of the drive prescribed.

        Args:
            states: `(N, size)` closed coordinates of the mechanism, at equidistant positions of the
                drive from 0.
            velocities: `(N, nv)` of the mechanism per unit of the drive's rate.
            force: `(N, 3)` without play, on the pin's link, in the world [N].
            period: of the drive [rad].

        Raises:
            ModelError: what would move has no mass.
        """
        count, opened = len(states), self._opened
        own, slides = opened.added[self._body], []
        mass, ways = np.empty((count, 2, 2)), np.empty((count, opened.size, 2))
        for k, x in enumerate(states):
            found = opened.ways(x)
            apart = found.rates[own]
            if apart.shape[1] != 2 or np.linalg.matrix_rank(apart, tol=_HELD * self._length) < 2:
                raise ModelError(f"joint {self._name!r} does not move in both ways across its axis")
            turned = np.linalg.inv(apart)
            ways[k], mass[k] = found.rates @ turned, turned.T @ found.inertia @ turned
            slides.append((opened.rotation(self._body) @ self._axes.T).T)
        changes = Fourier.of(ways.reshape(count, -1).T, period).derivative()
        moved = changes(period / count * np.arange(count)).T.reshape(ways.shape)
        along = opened.velocity(velocities)
        gyration = np.array(
            [
                way.T @ opened.coriolis(x, v, way, change)
                for x, v, way, change in zip(states, along, ways, moved, strict=True)
            ]
        )
        across = np.einsum("nki,ni->nk", np.array(slides), force)
        return Plane(np.linalg.inv(mass), gyration, across, period)

    def gives_way(self, x: Array) -> bool:
        """Return whether it can move along both slides.

        Args:
            x: `(size,)` closed coordinates of the mechanism.
        """
        apart = self._opened.ways(x).rates[self._opened.added[self._body]] / self._length
        return bool(np.linalg.matrix_rank(apart, tol=_HELD) == 2)
