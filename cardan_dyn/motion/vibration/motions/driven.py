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

from typing import Any, NamedTuple

import numpy as np

from ....core.elements.law import Law
from ....kit.arrays import EPS, NOTHING, ROUNDED, Array
from ....kit.differences import displacements, slopes
from ....kit.errors import VibrationError
from ....kit.periodic import derivatives, interpolation, next_size, nodes, tail
from ..model.efforts import with_drive
from .harmonic_balance import Motions
from .search import MotionSearch

_MOST_LEFT = float(np.sqrt(EPS))
"""Residual, and highest orders, as a fraction of the whole, with which no motion is returned."""


def drive_torque(given: Any) -> Law:
    """Return the torque of a drive [N·m] as a law of its speed [rad/s].

    Raises:
        ArgumentError: it is no number, no function and no table.
    """
    return Law.checked("torque", given, "speed", ("speed",))


def torque_at(law: Law, speeds: Array) -> Array:
    """Return the torques of a drive at speeds of any shape; errors as of `Law.at`."""
    return law.at("torque", speed=speeds.ravel()).reshape(speeds.shape)


def torque_slope(law: Law, speeds: Array) -> Array:
    """Return derivatives of the torque by the speed [N·m·s/rad], not 0."""
    unit = np.ones(1)
    torques = [torque_at(law, speeds * (1.0 + part)) for part in displacements(unit)[:, 0]]
    return np.asarray(slopes(np.array(torques), unit)[..., 0] / speeds)


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


class DrivenMotions:
    """Finds motions under a torque near those at constant speed."""

    def __init__(self, search: MotionSearch, torque: Law | None) -> None:
        """Take a scene.

        Args:
            search: of the scene.
            torque: of the drive; None where it is held at constant speed.
        """
        self._efforts, self._units = search.model.efforts, search.rotating.units
        self._period = search.rotating.period
        self._is_held, self._given = torque is None, torque or drive_torque(0.0)

    def of(self, motions: Motions) -> Driven:
        """Return the motions near others at constant speed.

        Raises:
            VibrationError: there is none near one of them.
            CardanError: as `Scene.sweep`.
        """
        speed = motions.course.speed
        q, period = self._repeated(speed, motions.course.q, motions.model.divisor)
        pace = np.repeat(speed[:, None], q.shape[1], axis=1)
        if self._is_held:
            found, _ = self._driven(period, speed, pace, q)
            return found._replace(lack=found.torque)
        return self._solved(period, speed, pace, q)

    def _repeated(self, speed: Array, q: Array, divisor: int) -> tuple[Array, float]:
        """Return motions over the part of the period after which the drive's effort repeats too."""
        count, period = q.shape[1], self._period / divisor
        if divisor == 1:
            return q, period
        place, *moves = _states(period, np.repeat(speed[:, None], count, axis=1), q)
        later = place + period * np.eye(1 + q.shape[2])[0]
        efforts, others = (self._efforts(at, *moves) for at in (place, later))
        if np.max(np.abs(efforts - others)) <= NOTHING * np.max(np.abs(efforts)):
            return q, period
        places = nodes(next_size(divisor * count), self._period)
        weights = interpolation(places, count, period)
        return np.einsum("kj,sjn->skn", weights, q), self._period

    def _solved(self, period: float, speed: Array, pace: Array, q: Array) -> Driven:
        """Return motions by Newton's method, near those given."""
        size, count, free = q.shape
        lack, length, is_open = np.zeros(size), np.full(size, np.inf), np.ones(size, dtype=bool)
        while np.any(is_open):
            matrix, left, scale = self._linear(period, speed, pace, q, lack)
            step, before = np.linalg.solve(matrix, -left[..., None])[..., 0], length
            pace = pace + step[:, :count] * speed[:, None]
            q = q + step[:, count:-1].reshape(size, count, free) * self._units
            lack = lack + step[:, -1] * scale
            turns = np.all(pace * speed[:, None] > 0.0, axis=1)
            # Steps that shrink no more are rounding, or lead nowhere.
            length = np.max(np.abs(step), axis=1)
            is_open &= np.all(turns) & (length > ROUNDED) & (length < 0.5 * before)
        rough = np.maximum(tail(pace, 1), np.max(tail(q, 1) * np.max(np.abs(q), axis=1), axis=1))
        wrong = ~(turns & (rough <= _MOST_LEFT))
        if not np.any(wrong):
            found, efforts = self._driven(period, speed, pace, q, lack)
            wrong = ~(np.max(np.abs(efforts), axis=(1, 2)) <= _MOST_LEFT * scale)
            if not np.any(wrong):
                return found
        at = float(speed[np.argmax(wrong)])
        raise VibrationError(
            "no periodic motion was found in which a torque moves the drive with a mean speed "
            f"of {at:.12g} rad/s: its inertia may be too small to turn through",
            speed=at,
        )

    def _driven(
        self, period: float, speed: Array, pace: Array, q: Array, lack: Array | float = 0.0
    ) -> tuple[Driven, Array]:
        """Return motions, and efforts `(S, N, 1 + n)` that sweeps find beyond what acts."""
        place, *moves = _states(period, pace, q)
        efforts = self._efforts(place, *moves)
        torque = np.mean(efforts[..., 0], axis=1)
        efforts[..., 0] -= torque_at(self._given, pace) + np.reshape(lack, (-1, 1))
        # Free coordinates move by w q'.
        return Driven(speed, pace, q, moves[0][..., 1:], torque, np.asarray(lack)), efforts

    def _linear(
        self, period: float, speed: Array, pace: Array, q: Array, lack: Array
    ) -> tuple[Array, Array, Array]:
        """Return the equations about motions, by pace / Ω, q / unit and lack / size.

        Returns:
            Derivatives `(S, K, K)` and values `(S, K)`, in sizes of the efforts `(S,)`: of those
            while nothing accelerates, and of the torque; and these.
        """
        size, count, free = q.shape
        first, second = derivatives(count, period)
        states = _states(period, pace, q)
        local, given = self._efforts.local(*states), torque_at(self._given, pace)
        still = local.efforts - (local.by_acceleration @ states[2][..., None])[..., 0]
        scale = np.maximum(np.max(np.abs(still), axis=(1, 2)), np.max(np.abs(given), axis=1))
        scale = np.where(scale > 0.0, scale, 1.0)
        local.efforts[..., 0] -= given + lack[:, None]
        time = np.mean(speed[:, None] / pace, axis=1, keepdims=True) - 1.0
        left = np.hstack([local.efforts.reshape(size, -1) / scale[:, None], time])
        # Speeds are w and w q', accelerations w w' and w² q'' + w w' q'.
        unit = np.eye(count * (1 + free))
        dw, dq = unit[:count, None], unit[count:].reshape(count, free, -1)
        dw_1, dq_1 = (np.tensordot(first, item, 1) for item in (dw, dq))
        dq_2 = np.tensordot(second, dq, 1)
        w, w_1 = pace[..., None, None], (pace @ first.T)[..., None, None]
        rate, bend = (first @ q)[..., None], (second @ q)[..., None]
        pull = w_1 * dw + w * dw_1
        moved = np.concatenate([dw + 0.0 * w, rate * dw + w * dq_1], axis=2)
        bent = 2.0 * w * bend * dw + w**2 * dq_2 + rate * pull + w * w_1 * dq_1
        every = local.by_position @ dq + local.by_speed @ moved
        every += local.by_acceleration @ np.concatenate([pull, bent], axis=2)
        every[:, :, :1] -= torque_slope(self._given, pace)[..., None, None] * dw
        # By pace / Ω, q / unit, and lack / size.
        every[..., :count] *= speed[:, None, None, None]
        every[..., count:] *= np.tile(self._units, count)
        matrix = np.zeros((size, len(unit) + 1, len(unit) + 1))
        matrix[:, :-1, :-1] = every.reshape(size, len(unit), -1) / scale[:, None, None]
        matrix[:, : -1 : 1 + free, -1] = -1.0
        matrix[:, -1, :count] = -((speed[:, None] / pace) ** 2) / count
        return matrix, left, scale


def _states(period: float, pace: Array, q: Array) -> tuple[Array, Array, Array]:
    """Return positions, speeds, accelerations `(S, N, 1 + n)` of drive and coordinates.

    Args:
        period: [rad], of which the nodes are.
        pace: of the drive `(S, N)` [rad/s].
        q: `(S, N, n)`.
    """
    first, second = derivatives(q.shape[1], period)
    rate, bend = first @ q, second @ q
    pull, w = pace * (pace @ first.T), pace[..., None]
    return (
        with_drive(nodes(q.shape[1], period), q),
        with_drive(pace, w * rate),
        with_drive(pull, w**2 * bend + pull[..., None] * rate),
    )
