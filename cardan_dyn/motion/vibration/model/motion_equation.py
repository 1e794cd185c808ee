"""Motion equation: efforts along periodic motions, and what small changes of these add to them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ....kit.arrays import EPS, NOTHING, ROUNDED, Array, generic
from ....kit.errors import AccuracyError, ArgumentError, CardanError, ModelError
from ....kit.periodic import MOST_NODES, TAIL, amplitudes, next_size, nodes, tail
from .efforts import FreeEfforts, LocalEfforts, with_drive
from .rotating_scene import RotatingScene

_PROBES, _ASIDE = 3, 0.0125
"""Places at which coefficients are looked at over a period, the first one at the start, and how far
the others are from it, in units of the coordinates: what is even there alone is told from what is
even everywhere."""


class Course(NamedTuple):
    """Motions of n free coordinates at N nodes of one period, of S speeds.

    Attributes:
        q: `(S, N, n)` positions [rad or m].
        rate, bend: first and second derivatives by the drive's position, `(S, N, n)`.
        speed: `(S,)` of the drive [rad/s].
    """

    q: Array
    rate: Array
    bend: Array
    speed: Array

    def part(self, chosen: Array | slice | list[int]) -> Course:
        """Return some of them, by a mask, indices or a slice."""
        return Course(*(item[chosen] for item in self))

    @property
    def velocities(self) -> Array:
        """Speeds w `(S, N, 1 + n)` of drive and free coordinates."""
        return with_drive(self.speed[:, None], self.speed[:, None, None] * self.rate)

    @property
    def accelerations(self) -> Array:
        """Accelerations `(S, N, 1 + n)`, 0 of the drive."""
        return with_drive(np.zeros(1), self.speed[:, None, None] ** 2 * self.bend)


class LocalEquation(NamedTuple):
    """Efforts along motions, and what small changes of these add to them.

    Attributes:
        efforts: `(S, N, n)`.
        scale: `(S, n)` greatest sum of the sizes of their terms: inertia by accelerations, what
            goes with speeds, and the rest.
        mass, damping, stiffness: `(S, N, n, n)` derivatives of the efforts by accelerations, speeds
            and positions of the free coordinates.
        slope: `(S, N, n)` derivatives of the efforts by the drive's speed, the course kept.
    """

    efforts: Array
    scale: Array
    mass: Array
    damping: Array
    stiffness: Array
    slope: Array


@dataclass(frozen=True, eq=False)
class MotionEquation:
    """The equation of periodic motions, on the nodes of one period.

    Attributes:
        efforts: of the scene.
        period: of the equation in the drive's position [rad], a divisor of the mechanism's.
        divisor: how many of them the mechanism's period holds.
        units: of the free coordinates `(n,)`.
        most: farthest that a free coordinate may be from its mean, in its unit.
        count: number of nodes.
    """

    efforts: FreeEfforts
    period: float
    divisor: int
    units: Array
    most: float
    count: int

    @property
    def positions(self) -> Array:
        """Positions of the drive at the nodes `(N,)` [rad]."""
        return nodes(self.count, self.period)

    def on(self, count: int) -> MotionEquation:
        """Return the same on another number of nodes."""
        return replace(self, count=count)

    def along(self, course: Course) -> LocalEquation:
        """Return efforts and their derivatives along motions; NaN where the mechanism cannot go."""
        try:
            return self._along(course)
        except CardanError:
            if len(course.speed) > 1:
                each = [self.along(course.part([row])) for row in range(len(course.speed))]
                return LocalEquation(*(np.concatenate(items) for items in zip(*each, strict=True)))
        size, count, free = course.q.shape
        none = np.full((size, count, free, free), np.nan)
        return LocalEquation(none[..., 0], none[:, 0, :, 0], none, none, none, none[..., 0])

    def _along(self, course: Course) -> LocalEquation:
        w, a = course.velocities, course.accelerations
        every = self.efforts.local(with_drive(self.positions, course.q), w, a)
        # What moves the drive is not asked for.
        local = LocalEfforts(*(item[:, :, 1:] for item in every))
        inertia = (local.by_acceleration @ a[..., None])[..., 0]
        moved = (local.by_speed @ w[..., None])[..., 0]
        # Of squares of speeds, the derivative has twice as much as there is.
        parts = inertia, 0.5 * moved, local.efforts - inertia - 0.5 * moved
        return LocalEquation(
            efforts=local.efforts,
            scale=np.max(np.sum(np.abs(parts), axis=0), axis=1),
            mass=local.by_acceleration[..., 1:],
            damping=local.by_speed[..., 1:],
            stiffness=local.by_position,
            slope=(2.0 * inertia + moved) / course.speed[:, None, None],
        )


def motion_equation(rotating: RotatingScene, most: float) -> MotionEquation:
    """Return the equation of a scene, on as many nodes as its coefficients need.

    Args:
        rotating: the scene.
        most: see `MotionEquation`.

    Raises:
        ArgumentError: efforts do not repeat after a period.
        ModelError: nothing that has mass moves with a free coordinate.
        AccuracyError: the coefficients are too uneven.
        CardanError: as `Scene.sweep`.
    """
    efforts, units, free = FreeEfforts(rotating), rotating.units, len(rotating.free)
    places = generic(_PROBES, free)
    places[0] = 0.0
    places = rotating.start[1:] + min(_ASIDE, most) * units * places
    # Springs and inertia are alike where all moves about as fast as it swings.
    moves = generic(2 * _PROBES, 1 + free).reshape(2, _PROBES, -1) + 1.5
    scale = np.append(1.0, units)

    def at(drive: Array) -> list[Array]:
        """Return efforts, and what coefficients make of such moves `(P, N, F)`."""
        count = len(drive)
        q = np.repeat(places, count, axis=0)
        w, a = (np.repeat(scale * item, count, axis=0) for item in moves)
        found = efforts.local(with_drive(np.tile(drive, _PROBES), q), pace * w, pace**2 * a)
        powers = 1.0, units, pace * scale, pace**2 * scale
        return [
            (item[:, 1:] * power).reshape(_PROBES, count, -1)
            for item, power in zip(found, powers, strict=True)
        ]

    position = with_drive(nodes(_PROBES, rotating.period), places)
    still = np.zeros_like(position)
    local = efforts.local(position, still, still)
    mass = local.by_acceleration[:, 1:, 1:]
    _refuse_massless(rotating, mass)
    stiffest, heaviest = (
        float(np.max(np.abs(item * units))) for item in (local.by_position[:, 1:], mass)
    )
    pace = np.sqrt(stiffest / heaviest) or 1.0
    # Dampers may be none: what they do is measured in what inertia does.
    least = pace**2 * heaviest
    drive = position[:, 0]
    gap = max(
        float(np.max(np.abs(later - here))) / max(float(np.max(np.abs(here))), least)
        for here, later in zip(at(drive), at(drive + rotating.period), strict=True)
    )
    if gap > NOTHING:
        raise ArgumentError(
            f"after a period of {rotating.drive}, {rotating.period:g} rad, the efforts of "
            f"{', '.join(rotating.free)} differ by {gap:.1e} of their size, so that there is no "
            "periodic motion; does a spring wind up on a coordinate that turns on and on?"
        )
    count = next_size(0)
    while True:
        drive = nodes(count, rotating.period)
        found = at(drive)
        sizes = [max(float(np.max(np.abs(item))), least) for item in found]
        values = np.concatenate(
            [item / size for item, size in zip(found, sizes, strict=True)], axis=2
        )
        if np.max(tail(values, 1) * np.max(np.abs(values), axis=1)) <= ROUNDED:
            break
        if count >= MOST_NODES:
            raise AccuracyError(
                f"{count} positions of {rotating.drive} do not resolve the efforts of "
                f"{', '.join(rotating.free)} over its period",
            )
        count = next_size(count + 1)
    orders = np.max(np.abs(amplitudes(values, 1)), axis=(0, 2))
    divisor = 2 if np.max(orders[1::2], initial=0.0) <= ROUNDED else 1
    needed = 2 * int(np.max(np.nonzero(orders > TAIL)[0], initial=0)) // divisor + 5
    return MotionEquation(
        efforts, rotating.period / divisor, divisor, units, most, next_size(needed)
    )


def _refuse_massless(rotating: RotatingScene, mass: Array) -> None:
    """Refuse free coordinates, or ways in which several move together, that move no mass.

    Args:
        rotating: the scene.
        mass: M at some positions `(K, n, n)`.
    """
    scaled = mass * np.outer(rotating.units, rotating.units)
    own = np.diagonal(scaled, axis1=1, axis2=2)
    rounding = len(rotating.scene.mechanism.joints) * EPS
    light = np.min(own, axis=0) <= rounding * np.max(own)
    advice = (
        "what has no mass does not vibrate, but follows its springs at once. Give the links that "
        "move mass and inertia, or hold a coordinate instead of letting it free"
    )
    if np.any(light):
        named = " and ".join(
            repr(name) for name, is_light in zip(rotating.free, light, strict=True) if is_light
        )
        raise ModelError(f"no mass moves with the free coordinate {named} alone: {advice}")
    size = np.sqrt(own)
    alike = scaled / (size[:, :, None] * size[:, None, :])
    if np.min(np.linalg.eigvalsh(alike)) <= rounding:
        raise ModelError(
            f"{', '.join(rotating.free)} can move together so that no mass moves: {advice}"
        )
