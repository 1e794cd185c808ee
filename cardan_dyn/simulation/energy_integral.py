"""Energy integral: the motion of a conservative mechanism with one free coordinate, by quadrature.

Its speed follows from its position, I φ̇² / 2 + U = E, so that time is an integral over position:
dt = √(I / (2 (E - U))) dφ. Where the drive turns through, the integrand repeats with each turn.
Where it swings between two positions at which E = U, φ = c - r cos θ makes it a smooth function of
θ that repeats with each swing. Both are summed by Fourier series to rounding; Newton's method
inverts them. So a thousand turns cost no more than one, and energy does not drift.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from .energy_functions import EnergyFunctions, NotSuitableError
from .fourier import Fourier

_MOST = 16384
"""Greatest number of nodes of an integral."""
_FEWEST = 64
_SCANNED = 1024
"""Positions per period at which potential and energy are compared."""
_NEWTON_STEPS = 60
_PERIODS = 2
"""Periods of the drive within which a swing may end, on either side."""


class Law(NamedTuple):
    """Position, speed and acceleration of the drive at times, each `(N,)`."""

    position: Array
    speed: Array
    acceleration: Array


class EnergyIntegral:
    """The motion of the drive as a function of time.

    Attributes:
        period: time of a turn or swing [s]; inf if the mechanism stays where it is.
        swings: whether it swings between two positions.
    """

    def __init__(self, functions: EnergyFunctions, position: float, speed: float) -> None:
        """Integrate over a turn or a swing.

        Args:
            functions: of the mechanism.
            position: of the drive at time 0 [rad].
            speed: of the drive at time 0 [rad/s].

        Raises:
            NotSuitableError: a constant torque speeds the drive up without end, or energy is so
                close to what passes a maximum of the potential that the integral does not converge.
        """
        self._functions = functions
        self._work = functions.force.integral()
        self._start, self._speed = position, speed
        inertia = float(functions.inertia.at(position)[0])
        self._energy = 0.5 * inertia * speed * speed
        """Kinetic energy at the start; potential energy counts from there."""
        force = float(functions.force.at(position)[0])
        self.swings = False
        scale = float(np.max(np.abs(functions.force.coefficients)))
        if speed == 0.0 and abs(force) <= functions.error * scale:
            self.period = np.inf
            return
        limits = self._limits(speed, force)
        self.swings = limits is not None
        if limits is not None:
            self._take_swing(*limits)
        else:
            self._take_turn(scale)

    def _kinetic(self, way: float) -> float:
        """Return the kinetic energy after a way; negative where the energy is too small."""
        return float(self._energy + self._work.gained(self._start, np.array([way]))[0, 0])

    def _limits(self, speed: float, force: float) -> tuple[float, float] | None:
        """Return the ways from the start to the ends of the swing, None if it turns through."""
        turn = 2.0 * np.pi / self._functions.inertia.frequency
        count = max(_SCANNED, 4 * self._work.coefficients.shape[1])
        work = self._work.on_grid(self._start, count)[0]
        trend = float(self._work.slope[0]) * turn
        ends = []
        for sign in (-1.0, 1.0):
            if speed == 0.0 and sign * force < 0.0:
                ends.append(0.0)
                continue
            turns = np.repeat(np.arange(_PERIODS), count)
            indices = np.tile(np.arange(count), _PERIODS)
            if sign > 0.0:
                gained = work[indices] - work[0] + turns * trend
            else:
                # The position before the start is the last one of the period before.
                gained = work[(-indices) % count] - work[0] - (turns + (indices > 0)) * trend
            short = self._energy + gained < 0.0
            if not np.any(short):
                return None
            first, step = int(np.argmax(short)), turn / count
            ends.append(self._end(sign * (first - 1) * step, sign * step))
        return ends[0], ends[1]

    def _end(self, inside: float, more: float) -> float:
        """Return the way to where kinetic energy vanishes, between `inside` and `more` further."""
        low, high = 0.0, more
        while True:
            middle = 0.5 * (low + high)
            if middle in (low, high):
                return inside + middle
            if self._kinetic(inside + middle) >= 0.0:
                low = middle
            else:
                high = middle

    def _take_turn(self, scale: float) -> None:
        """Integrate over a turn of the drive."""
        turn = 2.0 * np.pi / self._functions.inertia.frequency
        trend = abs(float(self._work.slope[0]))
        if trend > self._functions.error * max(scale, self._energy / turn):
            raise NotSuitableError("a constant torque speeds the drive up")
        # With fewer nodes than its harmonics, the inertia would be cut short.
        harmonics = self._functions.inertia.coefficients.shape[1]
        count = max(_FEWEST, 2 ** int(np.ceil(np.log2(2 * harmonics))))
        while count <= _MOST:
            series = Fourier.of(self._pace(count)[None, :], turn)
            if series.tail()[0] < self._functions.error:
                self._series = series.shortened(1e-17)
                self._elapsed = self._series.integral()
                self.period = float(self._elapsed.slope[0]) * turn
                return
            count *= 2
        raise NotSuitableError("the energy is close to what passes a maximum of the potential")

    def _pace(self, count: int) -> Array:
        """Return times per way [s/rad] at equidistant positions over a turn from the start.

        Raises:
            NotSuitableError: kinetic energy vanishes at one of them.
        """
        work = self._work.on_grid(self._start, count)[0]
        kinetic = self._energy + work - work[0]
        if np.min(kinetic) <= 0.0:
            raise NotSuitableError("the energy is close to a maximum of the potential")
        inertia = self._functions.inertia.on_grid(self._start, count)[0]
        return np.asarray(np.sqrt(0.5 * inertia / kinetic))

    def _take_swing(self, low: float, high: float) -> None:
        """Integrate over a swing between two positions, ways from the start."""
        self._middle, self._reach = self._start + 0.5 * (low + high), 0.5 * (high - low)
        self._ends = self._start + low, self._start + high
        # From the ways to both ends, as the cosine has no digits near them.
        phase = 2.0 * float(np.arctan2(np.sqrt(-low), np.sqrt(high)))
        self._phase = -phase if self._speed < 0.0 else phase
        count = _FEWEST
        while count <= _MOST:
            half = (np.arange(count) + 0.5) * np.pi / count
            pace = self._swing_pace(half)
            # The pace is even in θ: samples over half a turn give those over a whole one.
            series = _even_series(pace)
            if series.tail()[0] < self._functions.error:
                self._series = series.shortened(1e-17)
                self._elapsed = self._series.integral()
                self.period = 2.0 * np.pi * float(self._elapsed.slope[0])
                return
            count *= 2
        raise NotSuitableError("the energy is close to what passes a maximum of the potential")

    def _swing_pace(self, phases: Array) -> Array:
        """Return times per phase at phases in (0, π) [s/rad]."""
        low, high = self._ends
        from_low = 2.0 * self._reach * np.sin(0.5 * phases) ** 2
        to_high = 2.0 * self._reach * np.cos(0.5 * phases) ** 2
        is_low = phases < 0.5 * np.pi
        # From the nearer end, where kinetic energy vanishes, so that no digits are lost.
        kinetic = np.where(
            is_low,
            self._work.gained(low, from_low)[0],
            self._work.gained(high, -to_high)[0],
        )
        if np.min(kinetic) <= 0.0:
            raise NotSuitableError("the energy is close to an extremum of the potential")
        inertia = self._functions.inertia(low + from_low)[0]
        return np.asarray(np.sqrt(0.5 * inertia / kinetic) * self._reach * np.sin(phases))

    def at(self, times: Array) -> Law:
        """Return the motion of the drive at times `(N,)` [s]."""
        if not np.isfinite(self.period):
            rest = np.zeros_like(times)
            return Law(rest + self._start, rest, rest)
        turns = np.floor(times / self.period)
        rest = times - turns * self.period
        if self.swings:
            phases = self._inverted(self._phase, rest, 1.0)
            position = self._middle - self._reach * np.cos(phases)
            speed = self._reach * np.sin(phases) / self._series(phases)[0]
        else:
            sign = 1.0 if self._speed > 0.0 else -1.0
            nodes = self._inverted(0.0, rest, sign)
            turn = 2.0 * np.pi / self._functions.inertia.frequency
            position = self._start + nodes + sign * turn * turns
            speed = sign / self._series(nodes)[0]
        inertia, force = self._functions.inertia, self._functions.force
        slope = inertia.derivative()(position)[0]
        push = force(position)[0] - 0.5 * slope * speed**2
        return Law(position, speed, push / inertia(position)[0])

    def _inverted(self, start: float, times: Array, sign: float) -> Array:
        """Return where the elapsed time since `start` is `times (N,)`, in the sense of `sign`."""
        mean = float(self._elapsed.slope[0])
        begun = float(self._elapsed.at(start)[0])
        found = start + sign * times / mean
        for _ in range(_NEWTON_STEPS):
            missing = times - sign * (self._elapsed(found)[0] - begun)
            step = missing / self._series(found)[0]
            # Where the pace varies much, a whole step may overshoot.
            found = found + sign * np.clip(step, -0.5, 0.5)
            if np.max(np.abs(step)) < 1e-9:
                break
        missing = times - sign * (self._elapsed(found)[0] - begun)
        return np.asarray(found + sign * missing / self._series(found)[0])


def _even_series(samples: Array) -> Fourier:
    """Return the even function of period 2π with samples `(N,)` at (j + 1/2) π / N."""
    from scipy.fft import dct  # Only simulations need it.

    count = len(samples)
    coefficients = dct(samples, type=2) / count
    coefficients[0] *= 0.5
    return Fourier(coefficients[None, :].astype(complex), 1.0)
