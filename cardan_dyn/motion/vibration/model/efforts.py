"""Efforts: what the free coordinates would need for a motion, by inverse dynamics on whole arrays.

With w = (Ω, q̇), speeds of drive and free coordinates, the effort along a free coordinate is

    r = M(φ, q) q̈ + Q(φ, q)[w, w] + B(φ, q) w + k(φ, q):

rigid bodies are quadratic in speeds, dampers linear. A motion is free where r vanishes. Its
derivatives are those of the equations themselves; springs and dampers of the coordinates are added.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ....core.elements.joint_elements import JointElement, JointSpring
from ....core.problem.samples import acting_on, targets_of
from ....core.results.derivative import efforts_by
from ....kit.arrays import Array
from .rotating_scene import RotatingScene

_BLOCK = 20_000
"""Positions that are assembled at a time: some 100 MB."""


class LocalEfforts(NamedTuple):
    """Efforts of drive and free coordinates at N states, and their derivatives.

    Attributes:
        efforts: `(N, 1 + n)`.
        by_position: `(N, 1 + n, n)`, by the free coordinates.
        by_speed, by_acceleration: `(N, 1 + n, 1 + n)`, the drive's first.
    """

    efforts: Array
    by_position: Array
    by_speed: Array
    by_acceleration: Array


class FreeEfforts:
    """Computes the efforts of drive and free coordinates of a rotating scene."""

    def __init__(self, rotating: RotatingScene) -> None:
        self._count = 1 + len(rotating.free)
        self._scene = rotating.driven.replace(outputs=[])
        # Springs and dampers of the coordinates themselves are known without the mechanism.
        named, others = rotating.scene.mechanism.coordinates.named, []
        columns = {
            named[name].column: index for index, name in enumerate((rotating.drive, *rotating.free))
        }
        self._stiffness, self._damping, self._pull = np.zeros((3, self._count))
        for item in rotating.scene.elements:
            at = columns.get(named[item.joint].column) if isinstance(item, JointElement) else None
            if isinstance(item, JointSpring) and at is not None:
                self._stiffness[at] += item.stiffness
                self._damping[at] += item.damping
                self._pull[at] += item.stiffness * item.rest
            else:
                others.append(item)
        self._others = self._scene.replace(elements=others)
        free, every = rotating.free, self._scene.coordinates
        speeds = (f"{kind}:{name}" for kind in ("speed", "acceleration") for name in every)
        self._names = *free, *speeds

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

    def local(self, positions: Array, speeds: Array, accelerations: Array) -> LocalEfforts:
        """Return efforts and their derivatives; arguments and errors as of a call.

        They are not proven: motions that are found are held against sweeps.
        """
        parts = []
        for span in _spans(len(positions)):
            solver = self._others.solver
            assembled = solver.assembled_in_turn(targets_of(solver.problem, positions[span]))
            acting = acting_on(solver.problem, speeds[span], accelerations[span])
            parts.append(efforts_by(solver, assembled, acting, self._names))
        efforts, slopes = (np.concatenate(items) for items in zip(*parts, strict=True))
        efforts += self._stiffness * positions - self._pull + self._damping * speeds
        found = np.split(slopes, [self._count - 1, 2 * self._count - 1], axis=2)
        found[0] += np.diag(self._stiffness)[:, 1:]
        found[1] += np.diag(self._damping)
        return LocalEfforts(efforts, *found)


def _spans(count: int) -> Iterator[slice]:
    return (slice(first, first + _BLOCK) for first in range(0, count, _BLOCK))
