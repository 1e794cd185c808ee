"""Prescribed motion: how a drive moves in a simulation, with its speed and acceleration."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from ...kit.arrays import EPS, Array
from ...kit.checks import described, mapping, number, numbers
from ...kit.errors import ArgumentError, MobilityError, choices
from .system import Motion

_SAMPLES = 64
"""Intervals of the duration over which the derivatives of a function are compared with it."""
_DIFFERENCE = 1e-5
"""Greatest difference between a function and the integral of its derivative over an interval, as a
fraction of the greatest value of the latter times the interval: quadrature has smaller errors, and
a jump inside an interval is seen after it was halved some times."""
_ADVICE = (
    "give a speed, a function of time that returns position, speed and acceleration, three "
    "functions, or times and positions, which a spline then connects"
)


@dataclass(frozen=True)
class Uniform:
    """Motion with constant speed.

    Attributes:
        speed: [rad/s or m/s].
        start: position at time 0 [rad or m].
    """

    speed: float
    start: float = 0.0

    def __call__(self, time: float) -> tuple[float, float, float]:
        """Return position, speed and acceleration."""
        return self.start + self.speed * time, self.speed, 0.0


@dataclass(frozen=True)
class Written:
    """Motion that functions return, of a user or of a spline.

    Attributes:
        label: of messages.
        functions: one that returns all three, or three of them.
        kinks: times [s] after which its acceleration is another.
    """

    label: str
    functions: tuple[Callable[[float], Any], ...]
    kinks: tuple[float, ...] = ()

    def __reduce__(self) -> tuple[object, ...]:
        given = self.label, self.functions, self.kinks
        try:
            pickle.dumps(given)
        except (pickle.PicklingError, AttributeError, TypeError):
            return LeftBehind, (self.label,)
        return Written, given

    def __call__(self, time: float) -> tuple[float, float, float]:
        """Return position, speed and acceleration.

        Raises:
            ArgumentError: the functions fail, or return something else.
        """
        try:
            values = [function(time) for function in self.functions]
        except Exception as error:
            raise ArgumentError(
                f"{self.label} failed at time {time:g} s: {type(error).__name__}: {error}"
            ) from error
        try:
            position, speed, acceleration = map(float, values if len(values) > 1 else values[0])
        except (TypeError, ValueError):
            what = described(values if len(values) > 1 else values[0])
            raise ArgumentError(
                f"{self.label} returns {what} at time {time:g} s, expected position, speed and "
                f"acceleration; {_ADVICE}"
            ) from None
        return position, speed, acceleration


@dataclass(frozen=True)
class LeftBehind:
    """Motion whose functions cannot be pickled, such as those that functions return.

    Attributes:
        label: of messages.
    """

    label: str

    def __call__(self, time: float) -> tuple[float, float, float]:
        """Refuse.

        Raises:
            ArgumentError: always.
        """
        raise ArgumentError(
            f"{self.label} is a function that cannot be pickled, so that this copy knows its own "
            f"times and what was asked of it before, and nothing at {time:g} s: ask before it is "
            "copied, trajectory.at(times) for other times, or define the function at the top of a "
            "module"
        )


def prescribed_motions(
    drives: tuple[str, ...], free: tuple[str, ...], motion: Any, duration: float
) -> tuple[dict[str, Motion], dict[str, float]]:
    """Return how driven coordinates move, and where those begin that say it.

    Args:
        drives: of the scene.
        free: likewise.
        motion: see `Scene.simulate`.
        duration: of the simulation [s].

    Raises:
        ArgumentError: a joint is no drive, a drive has no motion, or its motion is none.
        MobilityError: nothing is free.
    """
    if not free:
        raise MobilityError(
            f"a simulation finds the motion of free coordinates, and the scene drives all it has: "
            f"{choices(drives)}; name those that are free: scene.replace(free=...). Scene.sweep "
            "solves prescribed motion",
            mobility=0,
        )
    motions: dict[str, Motion] = {}
    for name, value in mapping("motion", motion).items():
        if name not in drives:
            what = "is free" if name in free else "is no drive of the scene"
            listed = choices(drives, name) if drives else "none; scene.replace(drive=...)"
            raise ArgumentError(f"motion[{name!r}]: the joint {what}; drives: {listed}")
        motions[name] = prescribed_motion(name, value, duration)
    if missing := [name for name in drives if name not in motions]:
        raise ArgumentError(
            f"motion: the scene drives {choices(missing)}, of which nothing says how; give "
            f"motion={{{missing[0]!r}: ...}}, or free it: scene.replace(free=[*scene.free, "
            f"{missing[0]!r}])"
        )
    starts = {name: item(0.0)[0] for name, item in motions.items() if not isinstance(item, Uniform)}
    return motions, starts


def begun_at(motions: Mapping[str, Motion], starts: Mapping[str, float]) -> dict[str, Motion]:
    """Return motions of which those with constant speed begin at given positions."""
    return {
        name: replace(item, start=starts[name]) if isinstance(item, Uniform) else item
        for name, item in motions.items()
    }


def prescribed_motion(name: str, value: Any, duration: float) -> Motion:
    """Return how a drive moves.

    Args:
        name: of the drive.
        value: a constant speed [rad/s or m/s], from 0; a function of time that returns position,
            speed and acceleration; three functions; or times and positions `(K,)`, K at least 6.
        duration: of the simulation [s].

    Raises:
        ArgumentError: none of these, not finite, or derivatives that are none.
    """
    label = f"motion[{name!r}]"
    if isinstance(value, Written):
        return value  # It was checked where it comes from.
    if callable(value):
        return _checked(Written(label, (value,)), duration)
    if isinstance(value, Sequence) and len(value) == 3 and all(map(callable, value)):
        return _checked(Written(label, tuple(value)), duration)
    if isinstance(value, Sequence) and len(value) == 2 and not isinstance(value, (str, bytes)):
        times, positions = value
        return _spline(label, times, positions, duration)
    if not isinstance(value, Sequence) and np.ndim(value) == 0:
        return Uniform(number(label, value))
    raise ArgumentError(f"{label} is {described(value)}; {_ADVICE}")


def _spline(label: str, times: Any, positions: Any, duration: float) -> Motion:
    """Return the quintic spline through positions, whose second derivative is smooth."""
    from scipy.interpolate import make_interp_spline  # Few motions need it.

    times, positions = numbers(f"{label}: times", times), numbers(f"{label}: positions", positions)
    if times.ndim != 1 or times.shape != positions.shape or times.size < 6:
        raise ArgumentError(
            f"{label}: times {times.shape} and positions {positions.shape}, expected two arrays "
            "(K,) with K at least 6"
        )
    if np.any(np.diff(times) <= 0.0):
        raise ArgumentError(f"{label}: times have to increase")
    if times[0] > 0.0 or times[-1] < duration:
        raise ArgumentError(
            f"{label}: times from {times[0]:g} to {times[-1]:g} s do not span the simulation, "
            f"0 to {duration:g} s"
        )
    position = make_interp_spline(times, positions, k=5)
    return Written(label, (position, position.derivative(1), position.derivative(2)))


def _checked(motion: Written, duration: float) -> Written:
    """Return a motion with its kinks, after its derivatives were compared with it."""
    label = motion.label
    # Kinks tend to be at round parts of the duration, where two intervals would part them.
    inner = (np.arange(_SAMPLES) + np.sqrt(0.5)) / _SAMPLES
    times = duration * np.concatenate([[0.0], inner, [1.0]])
    ends = np.array([motion(time) for time in times.tolist()])
    if not np.all(np.isfinite(ends)):
        bad = times[int(np.argmax(~np.all(np.isfinite(ends), axis=1)))]
        raise ArgumentError(f"{label} is not finite at time {bad:g} s")
    sizes = np.maximum(np.max(np.abs(ends[:, 1:]), axis=0), 1e-300).tolist()
    kinks, shortest = list[float](), float(np.sqrt(EPS)) * duration
    after, before = float(np.nextafter(0.0, 1.0)), float(np.nextafter(duration, 0.0))
    for end, beside, kink in ((0.0, after, 0.0), (duration, before, before)):
        if abs(motion(end)[2] - motion(beside)[2]) > _DIFFERENCE * sizes[1]:
            kinks.append(kink)
    for interval in pairwise(times.tolist()):
        parts = [(1, *interval), (0, *interval)]
        while parts:
            order, first, last = parts.pop()
            if (found := _jump(motion, order, first, last, shortest, sizes[order])) is None:
                continue
            width = found[1] - found[0]
            around = (found[0] - width, found[0]), (found[1], found[1] + width)
            beside_it = [_quadrature_error(motion, order, *side) for side in around]
            scale = max(sizes[order], *(greatest for _, greatest in beside_it))
            if not order or any(error > _DIFFERENCE * scale for error, _ in beside_it):
                names = "position", "speed", "acceleration"
                raise ArgumentError(
                    f"{label}: its {names[order + 1]} is not the derivative of its {names[order]} "
                    f"near time {found[0]:g} s" + ("" if order else ", or jumps there")
                )
            kink = _before_jump(motion, *found)
            kinks.append(kink)
            parts += [(1, first, kink), (1, float(np.nextafter(kink, last)), last)]
    return replace(motion, kinks=tuple(sorted(kinks)))


def _before_jump(motion: Motion, before: float, after: float) -> float:
    """Return the last time before the acceleration jumps, within an interval in which it does."""
    left, right = motion(before)[2], motion(after)[2]
    while before < (middle := 0.5 * (before + after)) < after:
        there = motion(middle)[2]
        if abs(there - left) < abs(there - right):
            before = middle
        else:
            after = middle
    return before


def _jump(
    motion: Motion, order: int, first: float, last: float, shortest: float, scale: float
) -> tuple[float, float] | None:
    """Return between which times within an interval a derivative is not that of a motion.

    None if it is throughout.
    """
    while True:
        middle = 0.5 * (first + last)
        halves = (first, middle), (middle, last)
        found = [_quadrature_error(motion, order, *half) for half in halves]
        # What is short beside the intervals is larger inside of one than at all of their ends.
        scale = max(scale, *(greatest for _, greatest in found))
        worst = max(range(2), key=lambda half: found[half][0])
        if found[worst][0] <= _DIFFERENCE * scale:
            return None
        first, last = halves[worst]
        if last - first <= shortest:
            return first, last


def _quadrature_error(motion: Motion, order: int, first: float, last: float) -> tuple[float, float]:
    """Return the mean difference of a derivative from that of a motion, and its greatest value."""
    nodes, weights = np.polynomial.legendre.leggauss(5)
    half = 0.5 * (last - first)
    inner: Array = np.array([motion(first + half * (1.0 + node))[order + 1] for node in nodes])
    gained = motion(last)[order] - motion(first)[order]
    error = abs(float(weights @ inner) * half - gained) / (2.0 * half)
    return error, float(np.max(np.abs(inner)))
