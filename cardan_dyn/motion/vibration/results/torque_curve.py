"""Torque curve: what periodic motions ask of their drive over speed, and where resonances hold it.

A drive whose torque falls short of what a resonance absorbs stays on its rising flank (Sommerfeld
effect): any rise of speed costs more than it has.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....core.elements.law import Law
from ....kit.arrays import ROUNDED, Array
from ....kit.extremes import greatest, peak
from ....kit.periodic import amplitudes, orders_of
from ..model.modes import averaged, sense_name
from ..motions.continuation import motions_of
from ..motions.driven import DrivenMotions
from ..motions.harmonic_balance import Motions
from ..motions.linear import averaged_motions
from ..motions.residuals import residuals
from ..motions.search import MotionSearch
from ..motions.steady_path import SteadyPath
from .campbell import modes_about


class TorqueBarrier(NamedTuple):
    """A resonance as the drive meets it.

    Attributes:
        speed: mean speed of the drive at which it lacks most [rad/s].
        torque: mean torque over a revolution that the periodic motion absorbs there [N·m]: a
            constant torque has to be greater to pass slowly.
        available: mean torque of the drive there [N·m]; NaN where its motion is prescribed.
        order: of the resonance, cycles per revolution of the drive.
        mode: its number by ascending natural frequency at that speed, from 1.
        whirl: `forward`, `backward`, `planar`.
        holds: speed on the rising flank at which drive and motion are in balance [rad/s], so that
            a slow run stays there; NaN where there is none.
    """

    speed: float
    torque: float
    available: float
    order: float
    mode: int
    whirl: str
    holds: float

    @property
    def is_passed(self) -> bool:
        """Whether the drive has more than the resonance absorbs; True if it is prescribed."""
        return not abs(self.available) < abs(self.torque)

    def __str__(self) -> str:
        what = f"order {self.order:g}, mode {self.mode} ({self.whirl})"
        return f"{what}: up to {self.torque:.4g} N·m at {self.speed:.5g} rad/s"


class Predicted(NamedTuple):
    """What constant mean speeds predict, S of them; its names are those of `RunUp`."""

    predicted_speed: Array
    predicted: Array
    linear: Array
    predicted_torque: Array
    predicted_lack: Array


class TorqueCurve:
    """Torque that the motions along a path absorb."""

    def __init__(self, search: MotionSearch, path: SteadyPath, torque: Law | None) -> None:
        """Take a path.

        Args:
            search: that found it.
            path: of motions at constant speed.
            torque: of the drive; None where its motion is prescribed.
        """
        self._search, self._path, self._is_prescribed = search, path, torque is None
        self._motions = DrivenMotions(search, torque)

    def predicted(self) -> Predicted:
        """Return what the path predicts, speeds without a motion among it.

        Raises:
            VibrationError: a torque cannot move the drive with one of the speeds.
            CardanError: as `Scene.sweep`.
        """
        missed, free = np.array(self._path.missed), len(self._search.rotating.free)
        size = len(self._path.points) + len(missed)
        swing, linear = np.full((2, size, free), np.nan)
        torque, lack = np.full((2, size), np.nan)
        for motions in motions_of(self._path.points):
            if self._is_prescribed:
                residuals(motions)
            found = self._motions.of(motions)
            swing[motions.index] = half_swings(found.position)
            linear[motions.index] = half_swings(averaged_motions(motions))
            torque[motions.index], lack[motions.index] = found.torque, found.lack
        speed = np.concatenate([self._path.speed, missed])
        order = np.argsort(speed * self._path.sense, kind="stable")
        return Predicted(*(item[order] for item in (speed, swing, linear, torque, lack)))

    def barriers(self, found: Predicted) -> tuple[TorqueBarrier, ...]:
        """Return the resonances that the path meets, in its order.

        Args:
            found: what the path predicts.

        Raises:
            CardanError: as `predicted`.
        """
        from scipy.signal import find_peaks  # Most scripts run nothing up.

        there, sense = np.isfinite(found.predicted_lack), np.sign(found.predicted_speed[0])
        speed, lack = found.predicted_speed[there], sense * found.predicted_lack[there]
        if len(lack) < 3 or not np.ptp(lack) > 0.0:
            return ()
        # A low one before a high one may be what holds a weak drive.
        tops, _ = find_peaks(lack, prominence=np.sqrt(ROUNDED) * np.ptp(lack))
        return tuple(self._barrier(speed, lack, int(top), sense) for top in tops)

    def _barrier(self, speed: Array, lack: Array, top: int, sense: float) -> TorqueBarrier:
        """Return the barrier near one of the speeds of the path."""
        ends, known = (speed[top - 1], speed[top + 1]), (speed[top], lack[top])
        at, _ = peak(lambda at: self._lack(at, sense), *ends, known)
        (motions,) = self._path.near(at)
        driven = self._motions.of(motions)
        torque, missing = float(driven.torque[0]), float(driven.lack[0])
        order, mode, whirl = self._resonance(motions)
        return TorqueBarrier(
            speed=float(at),
            torque=torque,
            available=np.nan if self._is_prescribed else torque - missing,
            order=order,
            mode=mode,
            whirl=whirl,
            holds=self._held(speed[: top + 1], lack[: top + 1], at, sense),
        )

    def _held(self, speed: Array, lack: Array, top: float, sense: float) -> float:
        """Return where a run that speeds up stays before a barrier; NaN if it does not."""
        slows = abs(speed[-1]) < abs(speed[0])
        below = np.nonzero((lack[:-1] < 0.0) & (lack[1:] >= 0.0))[0]
        ends = (speed[below[-1]], speed[below[-1] + 1]) if below.size else (speed[-1], top)
        if self._is_prescribed or slows or not np.any(lack < 0.0):
            return np.nan
        if not self._lack(ends[1], sense) > 0.0:
            return np.nan
        from scipy.optimize import brentq

        return float(brentq(self._lack, *ends, args=(sense,), xtol=ROUNDED * abs(top)))

    def _lack(self, speed: float, sense: float) -> float:
        """Return what the drive lacks at a speed; -inf where the path has ended."""
        found = self._path.near(speed)
        return sense * float(self._motions.of(found[0]).lack[0]) if found else -np.inf

    def _resonance(self, motions: Motions) -> tuple[float, int, str]:
        """Return order, mode and whirl that move most in a motion."""
        speed = motions.course.speed
        mass, _, _ = averaged(motions.equation)
        waves = amplitudes(motions.course.q, 1)[0]
        waves = waves if speed[0] > 0.0 else waves.conj()
        order = orders_of(len(waves), motions.model.period)
        energy = order**2 * np.einsum("ki,ij,kj->k", waves.conj(), mass[0], waves).real
        wave = int(np.argmax(energy))
        about = modes_about(self._search, speed, [motions])
        mode = int(np.argmax(np.abs(np.linalg.pinv(about.shape[0]) @ waves[wave])))
        return float(order[wave]), mode + 1, sense_name(float(about.whirl[0, mode]))


def half_swings(q: Array) -> Array:
    """Return half the way from peak to peak `(S, n)` of motions `(S, N, n)` over their period."""
    values = np.moveaxis(q, 1, 0).reshape(q.shape[1], -1)
    swings = greatest(values)[0] + greatest(-values)[0]
    return 0.5 * swings.reshape(q.shape[0], q.shape[2])
