"""Prescribed motion: how a drive moves in a simulation, with its speed and acceleration."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..arrays import Array
from ..checks import described
from ..errors import ArgumentError
from .system import Motion

_SAMPLES = 64
"""Intervals of the duration over which the derivatives of a function are compared with it."""
_DIFFERENCE = 1e-5
"""Greatest difference between a function and the integral of its derivative over an interval, as a
fraction of the greatest value of the latter times the interval: quadrature has smaller errors, and
a jump inside an interval is seen after it was halved some times."""
_HALVINGS = 20
_ADVICE = (
    "give a speed, a function of time that returns position, speed and acceleration, three "
    "functions, or times and positions, which a spline then connects"
)


def prescribed_motion(name: str, value: Any, start: float, duration: float) -> Motion:
    """Return how a drive moves.

    Args:
        name: of the drive.
        value: a constant speed [rad/s or m/s]; a function of time that returns position, speed and
            acceleration; three functions; or times and positions `(K,)`, K at least 6.
        start: position at time 0 where a speed is given [rad or m].
        duration: of the simulation [s].

    Raises:
        ArgumentError: none of these, not finite, or derivatives that are none.
    """
    label = f"motion[{name!r}]"
    if callable(value):
        return _checked(label, _returning_three(label, value), duration)
    if np.ndim(value) == 0 and not isinstance(value, (str, bytes)):
        return _constant(label, value, start)
    if isinstance(value, Sequence) and len(value) == 3 and all(map(callable, value)):
        position, speed, acceleration = value
        return _checked(
            label,
            lambda time: (
                float(position(time)),
                float(speed(time)),
                float(acceleration(time)),
            ),
            duration,
        )
    if isinstance(value, Sequence) and len(value) == 2:
        times, positions = value
        return _spline(label, times, positions, duration)
    raise ArgumentError(f"{label} is {described(value)}; {_ADVICE}")


def _constant(label: str, value: Any, start: float) -> Motion:
    try:
        speed = float(value)
    except (TypeError, ValueError):
        raise ArgumentError(f"{label} is {described(value)}; {_ADVICE}") from None
    if not np.isfinite(speed):
        raise ArgumentError(f"{label} is {speed}; a speed is finite")
    return lambda time: (start + speed * time, speed, 0.0)


def _returning_three(label: str, function: Callable[[float], Any]) -> Motion:
    def motion(time: float) -> tuple[float, float, float]:
        try:
            position, speed, acceleration = map(float, function(time))
        except (TypeError, ValueError):
            raise ArgumentError(
                f"{label} returns {described(function(time))} at time {time:g} s, expected "
                f"position, speed and acceleration; {_ADVICE}"
            ) from None
        return position, speed, acceleration

    return motion


def _spline(label: str, times: Any, positions: Any, duration: float) -> Motion:
    """Return the quintic spline through positions, whose second derivative is smooth."""
    from scipy.interpolate import make_interp_spline  # Few motions need it.

    try:
        times, positions = np.asarray(times, dtype=float), np.asarray(positions, dtype=float)
    except (TypeError, ValueError):
        raise ArgumentError(f"{label}: times and positions are no numbers; {_ADVICE}") from None
    if times.ndim != 1 or times.shape != positions.shape or times.size < 6:
        raise ArgumentError(
            f"{label}: times {times.shape} and positions {positions.shape}, expected two arrays "
            "(K,) with K at least 6"
        )
    if not (np.all(np.isfinite(times)) and np.all(np.isfinite(positions))):
        raise ArgumentError(f"{label}: times and positions have to be finite")
    if np.any(np.diff(times) <= 0.0):
        raise ArgumentError(f"{label}: times have to increase")
    if times[0] > 0.0 or times[-1] < duration:
        raise ArgumentError(
            f"{label}: times from {times[0]:g} to {times[-1]:g} s do not span the simulation, "
            f"0 to {duration:g} s"
        )
    position = make_interp_spline(times, positions, k=5)
    speed, acceleration = position.derivative(1), position.derivative(2)
    return lambda time: (float(position(time)), float(speed(time)), float(acceleration(time)))


def _checked(label: str, motion: Motion, duration: float) -> Motion:
    """Return a motion after its derivatives were compared with it.

    Raises:
        ArgumentError: not finite, or speed or acceleration are not the derivatives.
    """
    times = np.linspace(0.0, duration, _SAMPLES + 1)
    ends = np.array([motion(time) for time in times.tolist()])
    if not np.all(np.isfinite(ends)):
        bad = times[int(np.argmax(~np.all(np.isfinite(ends), axis=1)))]
        raise ArgumentError(f"{label} is not finite at time {bad:g} s")
    for order, what in ((0, "speed"), (1, "acceleration")):
        scale = max(float(np.max(np.abs(ends[:, order + 1]))), 1e-300)
        for first, last in zip(times[:-1].tolist(), times[1:].tolist(), strict=True):
            time = _jump(motion, order, first, last, scale)
            if time is not None:
                raise ArgumentError(
                    f"{label}: its {what} is not the derivative of its "
                    f"{('position', 'speed')[order]} near time {time:g} s, or jumps there; "
                    "prescribed motion needs continuous second derivatives"
                )
    return motion


def _jump(motion: Motion, order: int, first: float, last: float, scale: float) -> float | None:
    """Return where a derivative is not that of a motion within an interval, None if nowhere."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (first + last)
        error = [
            _quadrature_error(motion, order, *pair) for pair in ((first, middle), (middle, last))
        ]
        worst = int(np.argmax(error))
        if error[worst] <= _DIFFERENCE * scale:
            return None
        first, last = ((first, middle), (middle, last))[worst]
    return 0.5 * (first + last)


def _quadrature_error(motion: Motion, order: int, first: float, last: float) -> float:
    """Return the mean difference of a derivative from that of a motion over an interval."""
    nodes, weights = np.polynomial.legendre.leggauss(5)
    half = 0.5 * (last - first)
    inner: Array = np.array([motion(first + half * (1.0 + node))[order + 1] for node in nodes])
    gained = motion(last)[order] - motion(first)[order]
    return abs(float(weights @ inner) * half - gained) / (2.0 * half)
