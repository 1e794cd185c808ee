"""Efforts: what the free coordinates would need for a motion, by inverse dynamics on whole arrays.

With w = (Ω, q̇), speeds of drive and free coordinates, the effort along a free coordinate is

    r = M(φ, q) q̈ + Q(φ, q)[w, w] + B(φ, q) w + k(φ, q)

exactly: rigid bodies are quadratic in speeds, dampers linear. A motion is free where r vanishes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations_with_replacement
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ....core.elements.joint_elements import JointSpring
from ....kit.arrays import Array
from .rotating_scene import RotatingScene

if TYPE_CHECKING:
    from ....scene.scene import Scene

_BLOCK = 20_000
"""Positions that are assembled at a time: some 100 MB."""


class Terms(NamedTuple):
    """Terms of the efforts at N positions, n free coordinates.

    Attributes:
        mass: M `(N, n, n)`.
        quadratic: Q `(N, n, 1 + n, 1 + n)`, symmetric in the last two.
        linear: B `(N, n, 1 + n)`.
        static: k `(N, n)`.
    """

    mass: Array
    quadratic: Array
    linear: Array
    static: Array

    def flat(self) -> Array:
        """Return all terms as columns `(N, F)`."""
        count = len(self.mass)
        return np.concatenate([item.reshape(count, -1) for item in self], axis=1)

    @staticmethod
    def of_flat(values: Array, free: int) -> Terms:
        """Return terms from columns `(..., F)`, see `flat`."""
        shapes = ((free, free), (free, 1 + free, 1 + free), (free, 1 + free), (free,))
        found, first = [], 0
        for shape in shapes:
            size = int(np.prod(shape))
            found.append(values[..., first : first + size].reshape(*values.shape[:-1], *shape))
            first += size
        return Terms(*found)


class FreeEfforts:
    """Computes the efforts of the free coordinates of a rotating scene."""

    def __init__(self, rotating: RotatingScene) -> None:
        self._free = len(rotating.free)
        self._scene = rotating.driven.replace(outputs=[])
        # Dampers of the coordinates themselves are known without a sweep.
        self._own = np.zeros((self._free, 1 + self._free))
        named, others = rotating.scene.mechanism.coordinates.named, []
        columns = {named[name].column: index for index, name in enumerate(rotating.free)}
        for item in rotating.damping:
            at = columns.get(named[item.joint].column) if isinstance(item, JointSpring) else None
            if isinstance(item, JointSpring) and at is not None:
                self._own[at, 1 + at] += item.damping
            else:
                others.append(item)
        self._dampers = self._scene.replace(elements=others) if others else None
        self._massless = {
            name: 0.0 for name, (body, _) in rotating.scene.mechanism.links.items() if body
        }

    def __call__(self, positions: Array, speeds: Array, accelerations: Array) -> Array:
        """Return the efforts `(N, n)` of given motions.

        Args:
            positions: of drive and free coordinates `(N, 1 + n)`.
            speeds: likewise.
            accelerations: likewise.

        Raises:
            CardanError: as `Scene.sweep`.
        """
        (efforts,) = self.through(positions, [(speeds, accelerations)])
        return efforts[:, 1:]

    def through(self, positions: Array, states: Sequence[tuple[Array, Array]]) -> list[Array]:
        """Return the efforts `(N, 1 + n)` of several motions through the same positions.

        Args:
            positions: of drive and free coordinates `(N, 1 + n)`.
            states: speeds and accelerations of each motion, likewise.

        Returns:
            for each of them the efforts of the drive, then of the free coordinates.

        Raises:
            CardanError: as `Scene.sweep`.
        """
        parts: list[list[Array]] = [[] for _ in states]
        for span in _spans(len(positions)):
            assembled = self._scene.assemble(positions[span])
            for part, (speed, acceleration) in zip(parts, states, strict=True):
                turn = self._scene.sweep(assembled, speed[span], acceleration[span])
                part.append(turn.drive_effort)
        return [np.concatenate(part) for part in parts]

    def terms(self, positions: Array) -> Terms:
        """Return the terms of the efforts at positions `(N, 1 + n)`.

        Raises:
            CardanError: as `Scene.sweep`.
        """
        parts = [self._terms(positions[span]) for span in _spans(len(positions))]
        return Terms(*(np.concatenate(items) for items in zip(*parts, strict=True)))

    def _terms(self, positions: Array) -> Terms:
        count, free = len(positions), self._free
        units, rest = np.eye(1 + free), np.zeros(1 + free)
        assembled = self._scene.assemble(positions)

        def of_dampers(scene: Scene, speed: Array) -> Array:
            ways = (
                scene.sweep(damped, sense * speed, inertia=self._massless).drive_effort
                for sense in (0.5, -0.5)
            )
            return (next(ways) - next(ways))[:, 1:]

        pairs = list(combinations_with_replacement(range(1 + free), 2))
        moves = [(rest, unit) for unit in units[1:]]
        moves += [(units[i] if i == j else units[i] + units[j], rest) for i, j in pairs]
        # Loops and loads are proven by the sweep at rest, motions that are found by sweeps of
        # their own.
        bodies = self._scene.solver.inertial_efforts(assembled, moves)[..., 1:]
        mass = np.swapaxes(bodies[:, :free], 1, 2)
        quadratic = np.zeros((count, free, 1 + free, 1 + free))
        found = dict(zip(pairs, np.moveaxis(bodies[:, free:], 1, 0), strict=True))
        for i, j in pairs:
            alone = found[i, i] + found[j, j]
            both = found[i, j] if i == j else 0.5 * (found[i, j] - alone)
            quadratic[:, :, i, j] = quadratic[:, :, j, i] = both
        linear = np.tile(self._own, (count, 1, 1))
        if self._dampers is not None:
            damped = replace(assembled, solver=self._dampers.solver)
            linear += np.stack([of_dampers(self._dampers, unit) for unit in units], axis=2)
        static = self._scene.sweep(assembled).drive_effort[:, 1:]
        return Terms(mass, quadratic, linear, static)


def _spans(count: int) -> Iterator[slice]:
    return (slice(first, first + _BLOCK) for first in range(0, count, _BLOCK))
