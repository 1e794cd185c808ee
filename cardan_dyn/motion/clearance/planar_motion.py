"""Planar motion: a pin that moves across its axis in the clearance of its bush.

The estimate along a line knows one coordinate. A pin has two: it grazes the wall before it strikes,
and slides along it. Here it moves in the plane of its bush, pushed by the force of the mechanism
without clearance as that force turns, with the masses that the opened mechanism moves,

    M(φ) ë + Ω C(φ) ė = -F(φ) - p e / |e|,   p = max(0, c δ + d δ̇),   δ = |e| - s,

linear in the offset e, which is small beside the mechanism. Own derivation: C = dM/dφ and a
gyroscopic part, from the velocities that the closure equations leave and their change along the
motion without clearance. Vectors of the plane are complex numbers.
"""

from __future__ import annotations

import math
from functools import cache, cached_property
from operator import mul
from typing import NamedTuple

import numpy as np

from ...core.elements.contact_laws import LinearContact
from ...kit.arrays import Array
from ...kit.errors import ModelError
from ...kit.extremes import turns
from ...kit.periodic import resampled
from ...kit.roots import zero
from .forces import ForceCourse, ForceSource
from .opened_joint import OpenedJoint, Plane

_PLACES, _GRID = 240, 4096
"""Positions over a period at which masses are asked for, and finer ones between which they are
linear."""
_RTOL = 1e-5
_MOST_SWINGS = 5000
"""Swings of the contact that a pin is followed for at most, 12 steps each: some seconds."""
_TURNS = 12
"""That a pin is followed: it never forgets how it slid, and no two turns are alike."""
SETTLED = 0.25
"""Of a period, after which reversals count: what has moved for less tells of how it began."""
_MODEL, _PER_OFFSET = 0.03, 20.0
"""By which forces of whole mechanisms lie around those of the pin in its plane, as a fraction, and
how much more per offset of the pin as a fraction of the mechanism's length: found by 483 reversals
of random linkages, three of which lay outside."""
_TOO_STIFF = (
    "so stiff a contact swings too often in a turn for its pin to be followed in the plane, and so "
    "no interval is known: verify"
)


class PlanarMotion(NamedTuple):
    """What a pin did in its bush.

    Attributes:
        time: `(K,)` ends of steps, both before and after what jumps there [s].
        pressure: `(K,)` force of the wall [N].
        rate: `(K,)` of that [N/s].
        touches: that ended flights: time [s], and speed at which the pin struck the wall [m/s].
        end: until when it was followed [s].
    """

    time: Array
    pressure: Array
    rate: Array
    touches: list[tuple[float, float]]
    end: float

    def greatest(self, start: float, end: float) -> tuple[float, float]:
        """Return the greatest force between two times [N], and when [s]."""
        low, high = np.searchsorted(self.time, [start, end])
        span = slice(max(low - 1, 0), high + 1)
        when, force = turns(self.time[span], self.pressure[span], self.rate[span])
        force = np.where((start <= when) & (when <= end), force, 0.0)
        best = int(np.argmax(force))
        return float(force[best]), float(when[best])


class _State(NamedTuple):
    """Where a pin is [m], its rates [m/s, m/s²], when [s], and whether the wall presses it."""

    time: float
    z: complex
    v: complex
    slope: complex
    is_pressed: bool


class PlanarModel:
    """The equations of one pin at one speed of the drive."""

    def __init__(self, plane: Plane, clearance: float, law: LinearContact, speed: float) -> None:
        """Tabulate what the equations need.

        Args:
            plane: of the pin.
            clearance: difference 2 s of the diameters of bush and pin [m].
            law: of the contact.
            speed: of the drive [rad/s].
        """
        self._half, self._law = 0.5 * clearance, law
        self._duration = plane.period / abs(speed)
        units, w = np.array([1.0, 1.0j]), plane.mobility
        free = -np.einsum("nij,nj->ni", w, plane.force)

        def fine(values: Array) -> Array:
            """Return vectors, or what matrices make of the unit vectors, at the places."""
            found = resampled(values.reshape(len(values), -1), _GRID)
            if speed < 0.0:
                found = np.roll(found[::-1], 1, axis=0)
            return units @ found.reshape(_GRID, 2, -1)

        self._force = fine(plane.force)[:, 0]
        columns = np.hstack([fine(free), fine(-speed * w @ plane.gyration), fine(w)])
        rises = np.roll(columns, -1, axis=0) - columns
        self._table = list(zip(columns.tolist(), rises.tolist(), strict=True))
        self._per_time = _GRID / self._duration
        _, force = self.greatest
        deepest = force / law.stiffness
        # What a step may miss: of the clearance, or of the wall's deflection, and of the speeds.
        place = min(self._half, 10.0 * deepest)
        lightest = float(np.max(np.trace(resampled(w, _GRID), axis1=1, axis2=2)))
        self._atol = _RTOL * place, _RTOL * math.sqrt(place * force * lightest)

    def seat(self, time: float) -> complex:
        """Return where the force presses a pin into its wall at a time."""
        force = complex(self._force[round(time * self._per_time) % _GRID])
        size = abs(force)
        return -force / size * (self._half + size / self._law.stiffness)

    @property
    def greatest(self) -> tuple[float, float]:
        """When the force without clearance is greatest [s], and how great it is [N]."""
        sizes = np.abs(self._force)
        index = int(np.argmax(sizes))
        return index / self._per_time, float(sizes[index])

    def _wall(self, z: complex, v: complex) -> tuple[float, float, float]:
        """Return what is positive where the wall presses [m], its force, and the speed outward."""
        r = abs(z)
        depth, out = r - self._half, (z.conjugate() * v).real / r if r else 0.0
        pressure = self._law.stiffness * depth + self._law.damping * out
        return min(depth, pressure / self._law.stiffness), pressure, out

    def _acceleration(self, time: float, z: complex, v: complex, is_pressed: bool) -> complex:
        """Return the acceleration of a pin that is free or pressed."""
        place = time * self._per_time
        index = int(place)
        part, x, y = place - index, v.real, v.imag
        (free, a, b, m, n), (rise, of_a, of_b, of_m, of_n) = self._table[index % _GRID]
        found = free + a * x + b * y + part * (rise + of_a * x + of_b * y)
        if is_pressed:
            r, x, y = abs(z), z.real, z.imag
            pressed = self._law.stiffness * (r - self._half)
            pressed += self._law.damping * (x * v.real + y * v.imag) / r
            found -= pressed / r * (m * x + n * y + part * (of_m * x + of_n * y))
        return found

    def _step(self, now: _State, step: float) -> tuple[_State, float]:
        """Return the state after a step, pressed or free as before, and its error."""
        slopes, (stages, errors) = [now.slope], _tableau()
        for part, places, rates in stages:
            there = (
                now.time + part * step,
                now.z + step * (part * now.v + step * sum(map(mul, places, slopes))),
                now.v + step * sum(map(mul, rates, slopes)),
            )
            slopes.append(self._acceleration(*there, now.is_pressed))
        off = [abs(sum(map(mul, weights, slopes))) for weights in errors]
        place, speed = self._atol
        error = 0.5 * math.hypot(step * step * off[0] / place, step * off[1] / speed)
        return _State(*there, slopes[-1], now.is_pressed), error

    def run(self, periods: float, start: float | None = None) -> PlanarMotion:
        """Follow the pin.

        Args:
            periods: of the mechanism.
            start: time of the course at which it begins, pressed and riding on [s]; where the force
                is greatest if None.
        """
        time = self.greatest[0] if start is None else start
        end, longest = time + periods * self._duration, self._duration / 64.0
        beside = 1.0 / self._per_time
        rate = (self.seat(time + beside) - self.seat(time - beside)) / (2.0 * beside)
        now, step = self._turned(_State(time, self.seat(time), rate, 0j, False)), 1e-3 * longest
        course, touches = [self._kept(now)], []
        for _ in range(12 * _MOST_SWINGS):
            if now.time >= end:
                break
            step = min(step, longest, end - now.time + 1e-12 * longest)
            after, error = self._step(now, step)
            factor = 0.9 * max(error, 1e-10) ** -0.2
            if error > 1.0:
                step *= max(0.2, factor)
                continue
            grown = step * min(4.0, factor)
            jumps = self._jumps(after)
            if not (now.is_pressed or jumps) and (part := self._touches(now, after)):
                step *= part
                after, _ = self._step(now, step)
                jumps = self._jumps(after)
            if jumps:
                step = self._until_jump(now, step)
                after, _ = self._step(now, step)
                course.append(self._kept(after))
                after = self._turned(after)
                # After a touch the force rises within a swing, which the error then finds.
                grown = min(grown, 0.1 * step + 1e-4 * longest)
                if after.is_pressed:
                    touches.append((after.time, self._wall(after.z, after.v)[2]))
            now, step = after, grown
            course.append(self._kept(now))
        times, pressures, rates = np.array(course).T
        return PlanarMotion(times, pressures, rates, touches, now.time)

    def _jumps(self, state: _State) -> bool:
        """Return whether the wall presses where it should not, or does not where it should."""
        return (self._wall(state.z, state.v)[0] > 0.0) != state.is_pressed

    def _turned(self, state: _State) -> _State:
        """Return the same state, pressed where it was free, and free where it was pressed."""
        time, z, v, _, was_pressed = state
        slope = self._acceleration(time, z, v, not was_pressed)
        return _State(time, z, v, slope, not was_pressed)

    def _kept(self, state: _State) -> tuple[float, float, float]:
        """Return the time, the force of the wall and its rate."""
        time, z, v, slope, is_pressed = state
        _, pressure, out = self._wall(z, v)
        if not is_pressed or pressure <= 0.0:
            return time, 0.0, 0.0
        bend = (abs(v) ** 2 + (z.conjugate() * slope).real - out * out) / abs(z)
        return time, pressure, self._law.stiffness * out + self._law.damping * bend

    def _touches(self, now: _State, after: _State) -> float:
        """Return the part of a flight's step after which it has touched; 0 if it has not."""
        for part in (0.25, 0.5, 0.75):
            # The cubic through both ends and their speeds.
            left, end = 1.0 - part, part * part * (3.0 - 2.0 * part)
            bend = (after.time - now.time) * part * left * (left * now.v - part * after.v)
            if abs((1.0 - end) * now.z + end * after.z + bend) > self._half:
                return part
        return 0.0

    def _until_jump(self, now: _State, step: float) -> float:
        """Return the step at whose end the wall begins or ends to press."""

        def stays(part: float) -> float:
            there, _ = self._step(now, part)
            depth, _, _ = self._wall(there.z, there.v)
            return depth if now.is_pressed else -depth

        return zero(stays, 0.0, step)


@cache
def _tableau() -> tuple[list[tuple[float, list[float], list[float]]], list[list[float]]]:
    """Return the pair of Dormand and Prince for accelerations: stages after the first, and errors.

    Weights of accelerations in places, by the square of the step, and in rates.
    """
    from scipy.integrate import RK45  # Few scripts need it.

    rates = np.zeros((7, 7))
    rates[:6, :5], rates[6, :6] = RK45.A, RK45.B
    places, parts = rates @ rates, np.sum(rates, axis=1)
    stages = [
        (float(parts[k]), places[k, : k - 1].tolist(), rates[k, :k].tolist()) for k in range(1, 7)
    ]
    return stages, [(RK45.E @ rates).tolist(), RK45.E.tolist()]


class Passages(NamedTuple):
    """A stretch of the drive's way in each of `K` turns.

    Attributes:
        forces: `(K,)` greatest on it [N].
        speed: `(K,)` of the hardest strike, normal to the wall [m/s]; 0 if the pin stays on it.
        position: of the drive where the greatest of these forces is [rad].
        margin: by which the force of a whole mechanism may lie beside them, as a fraction.
    """

    forces: Array
    speed: Array
    position: float
    margin: float

    @property
    def least(self) -> float:
        """Lower end of the interval in which the greatest force on the stretch lies [N]."""
        return float(np.min(self.forces)) / (1.0 + self.margin)

    @property
    def greatest(self) -> float:
        """Upper end of this interval [N]."""
        return (1.0 + self.margin) * float(np.max(self.forces))

    @property
    def are_alike(self) -> bool:
        """Whether turns differ by no more than the margin."""
        return bool(np.max(self.forces) <= (1.0 + self.margin) * np.min(self.forces))

    @property
    def doubts(self) -> tuple[str, ...]:
        """What speaks against this interval."""
        doubts = {
            "no two turns are alike, and others may lie outside": not self.are_alike,
            "clearance and deflection are no longer small beside the mechanism": self.margin > 0.1,
        }
        return tuple(doubt for doubt, holds in doubts.items() if holds)


class FollowedPin:
    """The motion of one pin, found when it is first asked for; the same for all reversals."""

    def __init__(
        self,
        opened: OpenedJoint,
        source: ForceSource,
        course: ForceCourse,
        law: LinearContact,
        mass: float,
        speed: float,
    ) -> None:
        """Keep what is needed.

        Args:
            opened: the mechanism with this joint open, its drive's motion prescribed.
            source: of closed positions.
            course: of the force without clearance.
            law: of the contact.
            mass: mean of the joint [kg].
            speed: of the drive [rad/s].
        """
        self._asked = opened, source, course
        self._clearance, self._law = float(opened.clearances[0]), law
        self._speed, self._period = speed, source.period
        self._turn = source.period / abs(speed)
        self._length = source.problem.mechanism.characteristic_length
        self._swing = 2.0 * math.pi * math.sqrt(mass / law.stiffness)

    def __getstate__(self) -> dict[str, object]:
        # A copy has what was found, and not the mechanism.
        self._found  # noqa: B018
        return {name: value for name, value in vars(self).items() if name != "_asked"}

    @cached_property
    def _found(self) -> PlanarMotion | str:
        """What the pin did, or why it cannot be followed."""
        opened, source, course = self._asked
        # Any stretch of a period is passed twice in three turns.
        least = (3.0 + SETTLED) * self._turn
        if least >= _MOST_SWINGS * self._swing:
            return _TOO_STIFF
        positions = self._period / _PLACES * np.arange(_PLACES)
        closed = source.motion(positions, 1.0)
        try:
            plane = opened.plane(closed.rows, closed.v, course.at(positions), self._period)
        except ModelError as error:
            return str(error)
        model = PlanarModel(plane, self._clearance, self._law, self._speed)
        motion = model.run(_TURNS + SETTLED)
        return motion if motion.end - float(motion.time[0]) >= least else _TOO_STIFF

    @property
    def reason(self) -> str:
        """Why the pin cannot be followed; empty if it can."""
        return self._found if isinstance(self._found, str) else ""

    def passages(self, position: float, way: float) -> Passages | None:
        """Return what the pin did from a position on, in every turn; None if it is not followed.

        Args:
            position: of the drive [rad].
            way: that the drive turns from there [rad].
        """
        motion, turn = self._found, self._turn
        if isinstance(motion, str):
            return None
        begun, lasts = float(motion.time[0]), way / abs(self._speed)
        first = begun + (position / self._speed - begun) % turn
        starts = first + turn * np.arange(_TURNS + 2)
        starts = starts[(starts >= begun + SETTLED * turn) & (starts + lasts <= motion.end)]
        struck = np.array(motion.touches).reshape(-1, 2)
        rows = []
        for start in starts.tolist():
            hits = struck[(start <= struck[:, 0]) & (struck[:, 0] < start + lasts), 1]
            rows.append((*motion.greatest(start, start + lasts), np.max(hits, initial=0.0)))
        forces, times, speeds = np.array(rows).T
        offset = 0.5 * self._clearance + float(np.mean(forces)) / self._law.stiffness
        place = self._speed * float(times[np.argmax(forces)]) % self._period
        return Passages(forces, speeds, place, _MODEL + _PER_OFFSET * offset / self._length)
