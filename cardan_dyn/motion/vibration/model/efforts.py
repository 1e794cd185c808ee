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
from ....kit.arrays import LARGE_BLOCK, Array
from .rotating_scene import RotatingScene


class LocalEfforts(NamedTuple):
    """Efforts of drive and free coordinates in states of any shape, and their derivatives.

    Attributes:
        efforts: `(…, 1 + n)`.
        by_position: `(…, 1 + n, n)`, by the free coordinates.
        by_speed, by_acceleration: `(…, 1 + n, 1 + n)`, the drive's first.
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
        """Return the efforts `(…, 1 + n)` of drive and free coordinates in given motions.

        Args:
            positions: of drive and free coordinates `(…, 1 + n)`.
            speeds: likewise.
            accelerations: likewise.

        Raises:
            CardanError: as `Scene.sweep`.
        """
        states = _flat(positions, speeds, accelerations)
        parts = [self._scene.sweep(*part).drive_effort for part in _parts(states)]
        return np.concatenate(parts).reshape(positions.shape)

    def local(self, positions: Array, speeds: Array, accelerations: Array) -> LocalEfforts:
        """Return efforts and their derivatives; arguments and errors as of a call.

        They are not proven: motions that are found are held against sweeps.
        """
        states, solver = _flat(positions, speeds, accelerations), self._others.solver
        parts = []
        for places, *moves in _parts(states):
            assembled = solver.assembled_in_turn(targets_of(solver.problem, places))
            acting = acting_on(solver.problem, *moves)
            parts.append(efforts_by(solver, assembled, acting, self._names))
        efforts, slopes = (np.concatenate(items) for items in zip(*parts, strict=True))
        efforts += self._stiffness * states[0] - self._pull + self._damping * states[1]
        found = np.split(slopes, [self._count - 1, 2 * self._count - 1], axis=2)
        found[0] += np.diag(self._stiffness)[:, 1:]
        found[1] += np.diag(self._damping)
        every = (item.reshape(*positions.shape, *item.shape[2:]) for item in (efforts, *found))
        return LocalEfforts(*every)


def with_drive(drive: Array, free: Array) -> Array:
    """Return what free coordinates have `(…, n)` behind what the drive has `(…)`."""
    own = np.broadcast_to(drive[..., None], (*free.shape[:-1], 1))
    return np.concatenate([own, free], axis=-1)


def _flat(*states: Array) -> list[Array]:
    return [item.reshape(-1, item.shape[-1]) for item in states]


def _parts(states: Sequence[Array]) -> Iterator[list[Array]]:
    """Return positions, speeds and accelerations of as many samples as are worked on at a time."""
    for first in range(0, len(states[0]), LARGE_BLOCK):
        yield [item[first : first + LARGE_BLOCK] for item in states]
