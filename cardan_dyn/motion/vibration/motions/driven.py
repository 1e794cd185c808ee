"""Driven motion: periodic motion of a scene whose drive is moved by a torque.

The drive gives way to what the joint asks of it, so that its speed varies within a period. With
its position φ as the variable, unknown are its speed w(φ), the free coordinates q(φ) and what the
drive's characteristic T(w) lacks, s:

    effort of the drive = T(w) + s,  efforts along the free coordinates = 0,
    mean of 1/w over φ = 1/Ω.

Newton's method solves them at the nodes of the mechanism's period. A drive without inertia to give
way, held at speed, is the case w = Ω.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ....kit.arrays import NOTHING, Array
from ....kit.checks import described, numbers
from ....kit.differences import displacements, slopes
from ....kit.errors import ArgumentError, VibrationError
from ....kit.periodic import derivatives, interpolation, next_size, nodes, tail
from ..model.efforts import FreeEfforts, LocalEfforts

_STEPS = 12
_CONVERGED = 1e-10
"""Residual, as a fraction of the efforts, at which a motion is found."""
_MOST_LEFT = 1e-8
"""Residual with which none is returned, and highest orders that are."""
_SLOW = 0.05
"""Residual after a step, as a fraction of that before, from which on derivatives are renewed."""


@dataclass(frozen=True)
class Characteristic:
    """Torque of a drive, constant or a function of its speed.

    Attributes:
        torque: a number [N·m], or a function of the speed [rad/s] that returns one.

    Raises:
        ArgumentError: it is neither.
    """

    torque: float | Callable[[float], float]

    def __post_init__(self) -> None:
        if not callable(self.torque):
            object.__setattr__(self, "torque", _number("torque", self.torque))

    def __call__(self, speed: float) -> float:
        """Return the torque at a speed.

        Raises:
            ArgumentError: the function fails, or returns no finite number.
        """
        if not callable(self.torque):
            return self.torque
        at = f"torque at {speed:g} rad/s"
        try:
            value = self.torque(speed)
        except Exception as error:
            raise ArgumentError(f"{at} fails: {type(error).__name__}: {error}") from error
        return _number(at, value)

    def at(self, speeds: Array) -> Array:
        """Return the torques at speeds of any shape."""
        if not callable(self.torque):
            return np.full(speeds.shape, self.torque)
        return np.array([self(speed) for speed in speeds.ravel().tolist()]).reshape(speeds.shape)

    def slope(self, speeds: Array) -> Array:
        """Return derivatives of the torque by the speed [N·m·s/rad]."""
        if not callable(self.torque):
            return np.zeros(speeds.shape)
        unit = np.ones(1)
        torques = np.array([self.at(speeds * (1.0 + part)) for part in displacements(unit)[:, 0]])
        return np.asarray(slopes(torques, unit)[..., 0] / speeds)


def _number(label: str, value: Any) -> float:
    """Return one finite number."""
    found = numbers(label, value)
    if found.size != 1:
        raise ArgumentError(f"{label} is {described(value)}, expected a number")
    return float(found.reshape(()))


class Driven(NamedTuple):
    """Motions under a torque: S of them at N nodes of the mechanism's period, n free coordinates.

    Attributes:
        speed: mean speeds of the drive over time `(S,)` [rad/s].
        pace: its speeds at the nodes `(S, N)` [rad/s].
        position: of the free coordinates `(S, N, n)` [rad or m].
        rate: their speeds `(S, N, n)` [rad/s or m/s].
        torque: mean effort of the drive over its position `(S,)` [N·m].
        lack: what the characteristic lacks of it `(S,)` [N·m]; negative where it has more.
    """

    speed: Array
    pace: Array
    position: Array
    rate: Array
    torque: Array
    lack: Array


class _Grid(NamedTuple):
    """Nodes of a period.

    Attributes:
        size: N, their number.
        period: [rad].
    """

    size: int
    period: float

    @property
    def derivatives(self) -> tuple[Array, Array]:
        """Matrices `(N, N)` of first and second derivatives by the drive's position."""
        return derivatives(self.size, self.period)

    def states(self, pace: Array, q: Array) -> tuple[Array, Array, Array]:
        """Return positions, speeds, accelerations `(S, N, 1 + n)` of drive and coordinates."""
        first, second = self.derivatives
        rate, bend = (np.einsum("ij,sjk->sik", item, q) for item in (first, second))
        w = pace[..., None]
        pull = (pace * (pace @ first.T))[..., None]
        drive = np.broadcast_to(nodes(self.size, self.period), pace.shape)[..., None]
        return (
            np.concatenate([drive, q], axis=2),
            np.concatenate([w, w * rate], axis=2),
            np.concatenate([pull, w**2 * bend + pull * rate], axis=2),
        )


class DrivenMotions:
    """Finds motions under a torque near those at constant speed."""

    def __init__(
        self, efforts: FreeEfforts, period: float, units: Array, torque: Characteristic | None
    ) -> None:
        """Take a scene.

        Args:
            efforts: of its coordinates.
            period: of the mechanism [rad].
            units: of the free coordinates `(n,)`.
            torque: characteristic of the drive; None where it is held at constant speed.
        """
        self._efforts, self._period, self._units = efforts, period, units
        self._is_held, self._given = torque is None, torque or Characteristic(0.0)

    def of(self, speed: Array, q: Array, divisor: int) -> Driven:
        """Return the motions near others.

        Args:
            speed: mean speeds `(S,)` [rad/s].
            q: motions `(S, N, n)` at constant speed, at the nodes of a part of the period.
            divisor: how many of these parts the period has.

        Raises:
            VibrationError: there is none near one of them.
            CardanError: as `Scene.sweep`.
        """
        q, period = self._repeated(speed, q, divisor)
        pace = np.repeat(speed[:, None], q.shape[1], axis=1)
        if self._is_held:
            return self._driven(_Grid(q.shape[1], period), speed, pace, q)
        return self._solved(_Grid(q.shape[1], period), speed, pace, q)

    def _repeated(self, speed: Array, q: Array, divisor: int) -> tuple[Array, float]:
        """Return motions over the part of the period after which the drive's effort repeats too."""
        count, period = q.shape[1], self._period / divisor
        if divisor == 1:
            return q, period
        pace = np.repeat(speed[:, None], count, axis=1)
        states = _Grid(count, period).states(pace, q)
        later = states[0] + period * np.eye(1 + q.shape[2])[0]
        efforts, others = (self._at(place, states[1:])[0] for place in (states[0], later))
        if np.max(np.abs(efforts - others)) <= NOTHING * np.max(np.abs(efforts)):
            return q, period
        places = nodes(next_size(divisor * count), self._period)
        weights = interpolation(places, count, period)
        return np.einsum("kj,sjn->skn", weights, q), self._period

    def _solved(self, grid: _Grid, speed: Array, pace: Array, q: Array) -> Driven:
        """Return motions by Newton's method, near those given."""
        size, count, free = q.shape
        lack, least, matrix = np.zeros(size), np.full(size, np.inf), None
        scale = self._scale(grid, pace, q)
        for _ in range(_STEPS):
            left = self._left(grid, speed, pace, q, lack, scale)
            now = np.max(np.abs(left), axis=1) / scale
            if np.all(now <= _CONVERGED) or np.all(now > 0.5 * least):
                break
            if matrix is None or np.any((now > _SLOW * least) & (now > _CONVERGED)):
                matrix = self._jacobian(grid, speed, pace, q, scale)
            least = now
            step = np.linalg.solve(matrix, -left[..., None])[..., 0]
            pace = pace + step[:, :count] * speed[:, None]
            q = q + step[:, count:-1].reshape(size, count, free) * self._units
            lack = lack + step[:, -1] * scale
            if not np.all(pace * speed[:, None] > 0.0):
                now = np.where(np.all(pace * speed[:, None] > 0.0, axis=1), now, np.inf)
                break
        rough = np.maximum(tail(pace, 1), np.max(tail(q, 1) * np.max(np.abs(q), axis=1), axis=1))
        wrong = ~(np.maximum(now, rough) <= _MOST_LEFT)
        if np.any(wrong):
            at = float(speed[np.argmax(wrong)])
            raise VibrationError(
                "no periodic motion was found in which a torque moves the drive with a mean speed "
                f"of {at:.12g} rad/s: its inertia may be too small to turn through",
                speed=at,
            )
        return self._driven(grid, speed, pace, q, lack)

    def _driven(
        self, grid: _Grid, speed: Array, pace: Array, q: Array, lack: Array | None = None
    ) -> Driven:
        place, *moves = grid.states(pace, q)
        torque = np.mean(self._at(place, moves)[0][..., 0], axis=1)
        # Free coordinates move by w q'.
        return Driven(speed, pace, q, moves[0][..., 1:], torque, torque if lack is None else lack)

    def _scale(self, grid: _Grid, pace: Array, q: Array) -> Array:
        """Return sizes of the efforts `(S,)`: those while nothing accelerates, and the torque."""
        place, speed, acceleration = grid.states(pace, q)
        still = self._at(place, (speed, 0.0 * acceleration))[0]
        given = np.max(np.abs(self._given.at(pace)), axis=1)
        return np.asarray(np.maximum(np.max(np.abs(still), axis=(1, 2)), given) + 1e-300)

    def _left(
        self, grid: _Grid, speed: Array, pace: Array, q: Array, lack: Array, scale: Array
    ) -> Array:
        """Return what is left of the equations `(S, N (1 + n) + 1)`."""
        place, *moves = grid.states(pace, q)
        effort = self._at(place, moves)[0]
        effort[..., 0] -= self._given.at(pace) + lack[:, None]
        time = np.mean(speed[:, None] / pace, axis=1) - 1.0
        return np.concatenate([effort.reshape(len(q), -1), (time * scale)[:, None]], axis=1)

    def _at(self, position: Array, *moves: Sequence[Array]) -> list[Array]:
        """Return efforts `(S, N, 1 + n)` at positions, for each pair of speeds, accelerations."""
        shape = position.shape
        flat = [(v.reshape(-1, shape[2]), a.reshape(-1, shape[2])) for v, a in moves]
        found = self._efforts.through(position.reshape(-1, shape[2]), flat)
        return [item.reshape(shape) for item in found]

    def _jacobian(self, grid: _Grid, speed: Array, pace: Array, q: Array, scale: Array) -> Array:
        """Return derivatives `(S, K, K)` of the equations by pace / Ω, q / unit and lack / size."""
        size, count, free = q.shape
        first, second = grid.derivatives
        rate, bend = (np.einsum("ij,sjk->sik", item, q) for item in (first, second))
        change, w, own = (pace @ first.T)[..., None], pace[..., None], np.eye(count)
        place, *moves = grid.states(pace, q)
        flat = self._efforts.local(*(item.reshape(-1, 1 + free) for item in (place, *moves)))
        local = LocalEfforts(*(item.reshape(size, count, *item.shape[1:]) for item in flat))
        # Speeds are w and w q', accelerations w w' and w² q'' + w w' q'.
        ahead = np.concatenate([np.ones_like(w), rate], axis=2)
        plain = np.concatenate([change, 2.0 * w * bend + change * rate], axis=2)
        steep = np.einsum("sjik,sjk->sji", local.by_acceleration, ahead) * w
        direct = np.einsum("sjik,sjk->sji", local.by_acceleration, plain)
        direct += np.einsum("sjik,sjk->sji", local.by_speed, ahead)
        direct[..., 0] -= self._given.slope(pace)
        by_pace = np.einsum("sji,jl->sjil", direct, own) + np.einsum("sji,jl->sjil", steep, first)
        slope = w[..., None] * local.by_speed[..., 1:]
        slope += (w * change)[..., None] * local.by_acceleration[..., 1:]
        curve = w[..., None] ** 2 * local.by_acceleration[..., 1:]
        by_q = np.zeros((size, count, 1 + free, count, free))
        for part, along in ((local.by_position, own), (slope, first), (curve, second)):
            by_q += np.einsum("sjik,jl->sjilk", part, along)
        rows = count * (1 + free)
        matrix = np.zeros((size, rows + 1, rows + 1))
        matrix[:, :-1, :count] = by_pace.reshape(size, rows, count) * speed[:, None, None]
        matrix[:, :-1, count:-1] = (by_q * self._units).reshape(size, rows, count * free)
        matrix[:, : rows : 1 + free, -1] = -scale[:, None]
        matrix[:, -1, :count] = -((speed[:, None] / pace) ** 2) / count * scale[:, None]
        return matrix
