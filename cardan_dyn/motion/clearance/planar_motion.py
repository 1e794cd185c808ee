"""Planar motion: a pin that moves across its axis in the clearance of its bush.

The estimate along a line knows one coordinate. A pin has two: it grazes the wall before it strikes,
and slides along it. Here it moves in the plane of its bush, pushed by the force of the mechanism
without clearance as that force turns, with the masses that the opened mechanism moves,

    M(φ) ë + Ω C(φ) ė = -F(φ) - p e / |e|,   p = max(0, c δ + d δ̇),   δ = |e| - s,

linear in the offset e, which is small beside the mechanism. Own derivation: C = dM/dφ and a
gyroscopic part, from the velocities that the closure equations leave and their change along the
motion without clearance.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...kit.arrays import Array
from ...kit.errors import ModelError
from ...kit.extremes import turns
from ...kit.periodic import resampled
from ...kit.roots import zero
from .forces import ForceCourse, ForceSource
from .opened_joint import OpenedJoint, Plane

_GRID = 4096
"""Places over a period between which coefficients are linear."""
_RTOL = 1e-5
_DEFLECTIONS = 10.0
"""Greatest deflections of the wall that a tolerance is meant for, if the clearance is more."""
_SAFETY, _SHRINK, _GROW = 0.9, 0.2, 4.0
_MOST_STEPS = 60_000
"""Of one joint: some seconds."""
_LOOKED_AT = (0.25, 0.5, 0.75)
"""Parts of a step of a flight at which a touch is looked for."""
_PLACES = 240
"""Positions over a period at which masses are asked for; their series goes on between."""
_PERIODS = 12.25
"""That a pin is followed: it never forgets how it slid, and no two turns are alike."""
_STEPS = 12.0
"""In a swing of the contact, at least."""
_SETTLED = 0.25
"""Of a period, after which reversals count, as in comparisons with simulations."""
_MODEL, _PER_OFFSET = 0.03, 20.0
"""By which forces of whole mechanisms lie around those of the pin in its plane, as a fraction, and
how much more per offset of the pin as a fraction of the mechanism's length: found by 483 reversals
of random linkages, three of which lay outside."""
_LOOSE = 0.1
"""Uncertainty of the plane, as a fraction, that is remarked."""
_TOO_STIFF = (
    "so stiff a contact swings too often in a turn for its pin to be followed in the plane, and so "
    "no interval is known: verify"
)


class PinContactNumbers(NamedTuple):
    """What a pin touches.

    Attributes:
        clearance: difference 2 s of the diameters of bush and pin [m].
        stiffness: c [N/m].
        damping: d [N s/m].
    """

    clearance: float
    stiffness: float
    damping: float


class Landing(NamedTuple):
    """A touch that ends a flight.

    Attributes:
        time: [s].
        speed: at which the pin strikes the wall [m/s].
    """

    time: float
    speed: float


class PlanarMotion(NamedTuple):
    """What a pin did in its bush.

    Attributes:
        time: `(K,)` ends of steps, both before and after what jumps there [s].
        pressure: `(K,)` force of the wall [N].
        rate: `(K,)` of that [N/s].
        touches: that ended flights.
        end: until when it was followed [s].
    """

    time: Array
    pressure: Array
    rate: Array
    touches: tuple[Landing, ...]
    end: float

    def greatest(self, start: float, end: float) -> tuple[float, float]:
        """Return the greatest force between two times [N], and when [s]."""
        low, high = np.searchsorted(self.time, [start, end])
        span = slice(max(low - 1, 0), high + 1)
        when, force = turns(self.time[span], self.pressure[span], self.rate[span])
        force = np.where((start <= when) & (when <= end), force, 0.0)
        best = int(np.argmax(force))
        return float(force[best]), float(when[best])


class PlanarModel:
    """The equations of one pin at one speed of the drive."""

    def __init__(self, plane: Plane, contact: PinContactNumbers, speed: float) -> None:
        """Tabulate what the equations need.

        Args:
            plane: of the pin.
            contact: what it touches.
            speed: of the drive [rad/s].
        """
        self.contact, self._speed = contact, speed
        self._duration = plane.period / abs(speed)
        free = -np.einsum("nij,nj->ni", plane.mobility, plane.force)
        drag = -speed * np.einsum("nij,njk->nik", plane.mobility, plane.gyration)
        w = plane.mobility
        columns = np.column_stack(
            [free, drag.reshape(-1, 4), w[:, 0, 0], w[:, 0, 1], w[:, 1, 1], plane.force]
        )
        fine = resampled(columns, _GRID)
        if speed < 0.0:
            fine = np.roll(fine[::-1], 1, axis=0)
        self._force = fine[:, 9:]
        self._table = [tuple(row) for row in fine[:, :9].tolist()]
        self._per_time = _GRID / self._duration

    def begun(self, time: float) -> tuple[float, ...]:
        """Return the state of a pin that the force presses into its wall at a time, riding on."""
        step = 1.0 / self._per_time
        at = [self._seat(time + k * step) for k in (-1, 0, 1)]
        rates = (at[2] - at[0]) / (2.0 * step)
        return (*at[1].tolist(), *rates.tolist())

    def _seat(self, time: float) -> Array:
        force = self._force[round(time * self._per_time) % _GRID]
        size = float(np.hypot(*force))
        return np.asarray(
            -force / size * (0.5 * self.contact.clearance + size / self.contact.stiffness)
        )

    @property
    def greatest(self) -> tuple[float, float]:
        """When the force without clearance is greatest [s], and how great it is [N]."""
        sizes = np.hypot(*self._force.T)
        index = int(np.argmax(sizes))
        return index / self._per_time, float(sizes[index])

    def _rates(self) -> Callable[..., tuple[float, float]]:
        """Return the accelerations as a function of time and state, free or pressed."""
        table, per_time, count = self._table, self._per_time, _GRID
        half = 0.5 * self.contact.clearance
        c, d = self.contact.stiffness, self.contact.damping

        def acceleration(
            t: float, x: float, y: float, u: float, v: float, pressed: bool
        ) -> tuple[float, float]:
            place = t * per_time
            index = int(place)
            part = place - index
            index %= count
            g1, g2, d11, d12, d21, d22, w11, w12, w22 = table[index]
            h1, h2, e11, e12, e21, e22, z11, z12, z22 = table[(index + 1) % count]
            a = g1 + part * (h1 - g1) + (d11 + part * (e11 - d11)) * u
            a += (d12 + part * (e12 - d12)) * v
            b = g2 + part * (h2 - g2) + (d21 + part * (e21 - d21)) * u
            b += (d22 + part * (e22 - d22)) * v
            if pressed:
                r = math.sqrt(x * x + y * y)
                p = (c * (r - half) + d * (x * u + y * v) / r) / r
                cross = w12 + part * (z12 - w12)
                a -= ((w11 + part * (z11 - w11)) * x + cross * y) * p
                b -= (cross * x + (w22 + part * (z22 - w22)) * y) * p
            return a, b

        return acceleration

    def run(self, periods: float, start: float | None = None) -> PlanarMotion:
        """Follow the pin.

        Args:
            periods: of the mechanism.
            start: time of the course at which it begins, pressed [s]; where the force is greatest
                if None.
        """
        begin = self.greatest[0] if start is None else start
        return _Run(self, begin, begin + periods * self._duration).motion()


class _Run:
    """One integration, by the pair of Dormand and Prince with 4 floats in place of arrays."""

    def __init__(self, model: PlanarModel, begin: float, end: float) -> None:
        self._acceleration = model._rates()
        self._contact = model.contact
        self._time, self._end = begin, end
        self._state = model.begun(begin)
        self._half = 0.5 * model.contact.clearance
        force = model.greatest[1]
        deepest = self._half + force / model.contact.stiffness
        # What a step may miss: of the clearance and the wall's deflection, and of the speeds there.
        place = min(self._half, _DEFLECTIONS * (deepest - self._half))
        lightest = max(row[6] + row[8] for row in model._table)
        self._atol = _RTOL * place, _RTOL * math.sqrt(place * force * lightest)
        self._longest = model._duration / 64.0
        self._course: list[tuple[float, float, float]] = []
        self._touches: list[Landing] = []

    def _pressed(self, state: tuple[float, ...]) -> float:
        """Return what is positive where the wall presses [m]."""
        x, y, u, v = state
        r = math.sqrt(x * x + y * y)
        depth = r - self._half
        if r == 0.0:
            return depth
        follows = depth + self._contact.damping / self._contact.stiffness * (x * u + y * v) / r
        return min(depth, follows)

    def _keep(
        self, time: float, state: tuple[float, ...], slope: tuple[float, float], is_pressed: bool
    ) -> None:
        """Keep the force of the wall at a time, and its rate; the slope is the acceleration."""
        pressure = rate = 0.0
        if is_pressed:
            c, d = self._contact.stiffness, self._contact.damping
            (x, y, u, v), (a, b) = state, slope
            r = math.sqrt(x * x + y * y)
            out = (x * u + y * v) / r
            pressure = c * (r - self._half) + d * out
            rate = c * out + d * (u * u + v * v + x * a + y * b - out * out) / r
        self._course.append((time, pressure, rate) if pressure > 0.0 else (time, 0.0, 0.0))

    def motion(self) -> PlanarMotion:
        """Return what the pin did."""
        time, state = self._time, self._state
        is_pressed = self._pressed(state) > 0.0
        step = 1e-3 * self._longest
        slope = self._acceleration(time, *state, is_pressed)
        self._keep(time, state, slope, is_pressed)
        for _ in range(_MOST_STEPS):
            if time >= self._end:
                break
            step = min(step, self._longest, self._end - time + 1e-12 * self._longest)
            after, last, error = self._step(time, state, slope, step, is_pressed)
            if error > 1.0:
                step *= max(_SHRINK, _SAFETY * error**-0.2)
                continue
            grown = step * min(_GROW, _SAFETY * max(error, 1e-10) ** -0.2)
            wrong = (self._pressed(after) > 0.0) != is_pressed
            if not is_pressed and not wrong:
                shorter = self._touched_within(state, after, step)
                if shorter is not None:
                    step *= shorter
                    after, last, _ = self._step(time, state, slope, step, is_pressed)
                    wrong = self._pressed(after) > 0.0
            if wrong:
                step = self._located(time, state, slope, step, is_pressed)
                after, last, _ = self._step(time, state, slope, step, is_pressed)
            time, state = time + step, after
            self._keep(time, state, last, is_pressed)
            if wrong:
                is_pressed = not is_pressed
                slope = self._acceleration(time, *state, is_pressed)
                if is_pressed:
                    x, y, u, v = state
                    speed = (x * u + y * v) / math.sqrt(x * x + y * y)
                    self._touches.append(Landing(time, speed))
                    self._keep(time, state, slope, is_pressed)
                # After a touch the force rises within a swing, which the error then finds.
                step = min(grown, 0.1 * step + 1e-4 * self._longest)
                continue
            slope, step = last, grown
        times, pressures, rates = np.array(self._course).T
        return PlanarMotion(times, pressures, rates, tuple(self._touches), time)

    def _touched_within(
        self, state: tuple[float, ...], after: tuple[float, ...], step: float
    ) -> float | None:
        """Return the part of a flight's step after which it has touched; None if it has not."""
        for part in _LOOKED_AT:
            # The cubic through both ends and their speeds.
            b = part * part * (3.0 - 2.0 * part)
            c, e = part * (1.0 - part) ** 2, part * part * (part - 1.0)
            x, y = (
                (1.0 - b) * state[k] + b * after[k] + step * (c * state[k + 2] + e * after[k + 2])
                for k in (0, 1)
            )
            if math.sqrt(x * x + y * y) > self._half:
                return part
        return None

    def _located(
        self,
        time: float,
        state: tuple[float, ...],
        slope: tuple[float, float],
        step: float,
        is_pressed: bool,
    ) -> float:
        """Return the step at whose end the wall begins or ends to press."""

        def stays(part: float) -> float:
            there, _, _ = self._step(time, state, slope, part, is_pressed)
            return self._pressed(there) if is_pressed else -self._pressed(there)

        return zero(stays, 0.0, step)

    def _step(
        self,
        t: float,
        state: tuple[float, ...],
        slope: tuple[float, float],
        h: float,
        pressed: bool,
    ) -> tuple[tuple[float, ...], tuple[float, float], float]:
        """Return the state after a step, accelerations there, and its error by what is allowed."""
        f = self._acceleration
        x, y, u, v = state
        a1, b1 = slope
        u2, v2 = u + h * 0.2 * a1, v + h * 0.2 * b1
        a2, b2 = f(t + 0.2 * h, x + h * 0.2 * u, y + h * 0.2 * v, u2, v2, pressed)
        p, q = 3.0 / 40.0 * h, 9.0 / 40.0 * h
        u3, v3 = u + p * a1 + q * a2, v + p * b1 + q * b2
        a3, b3 = f(t + 0.3 * h, x + p * u + q * u2, y + p * v + q * v2, u3, v3, pressed)
        p, q, r = 44.0 / 45.0 * h, -56.0 / 15.0 * h, 32.0 / 9.0 * h
        u4, v4 = u + p * a1 + q * a2 + r * a3, v + p * b1 + q * b2 + r * b3
        a4, b4 = f(
            t + 0.8 * h,
            x + p * u + q * u2 + r * u3,
            y + p * v + q * v2 + r * v3,
            u4,
            v4,
            pressed,
        )
        p, q = 19372.0 / 6561.0 * h, -25360.0 / 2187.0 * h
        r, s = 64448.0 / 6561.0 * h, -212.0 / 729.0 * h
        u5 = u + p * a1 + q * a2 + r * a3 + s * a4
        v5 = v + p * b1 + q * b2 + r * b3 + s * b4
        a5, b5 = f(
            t + 8.0 / 9.0 * h,
            x + p * u + q * u2 + r * u3 + s * u4,
            y + p * v + q * v2 + r * v3 + s * v4,
            u5,
            v5,
            pressed,
        )
        p, q, r = 9017.0 / 3168.0 * h, -355.0 / 33.0 * h, 46732.0 / 5247.0 * h
        s, w = 49.0 / 176.0 * h, -5103.0 / 18656.0 * h
        u6 = u + p * a1 + q * a2 + r * a3 + s * a4 + w * a5
        v6 = v + p * b1 + q * b2 + r * b3 + s * b4 + w * b5
        a6, b6 = f(
            t + h,
            x + p * u + q * u2 + r * u3 + s * u4 + w * u5,
            y + p * v + q * v2 + r * v3 + s * v4 + w * v5,
            u6,
            v6,
            pressed,
        )
        p, q, r = 35.0 / 384.0 * h, 500.0 / 1113.0 * h, 125.0 / 192.0 * h
        s, w = -2187.0 / 6784.0 * h, 11.0 / 84.0 * h
        x7 = x + p * u + q * u3 + r * u4 + s * u5 + w * u6
        y7 = y + p * v + q * v3 + r * v4 + s * v5 + w * v6
        u7 = u + p * a1 + q * a3 + r * a4 + s * a5 + w * a6
        v7 = v + p * b1 + q * b3 + r * b4 + s * b5 + w * b6
        a7, b7 = f(t + h, x7, y7, u7, v7, pressed)
        p, q, r = 71.0 / 57600.0 * h, -71.0 / 16695.0 * h, 71.0 / 1920.0 * h
        s, w, z = -17253.0 / 339200.0 * h, 22.0 / 525.0 * h, -h / 40.0
        place, speed = self._atol
        e = (
            (p * u + q * u3 + r * u4 + s * u5 + w * u6 + z * u7) / place,
            (p * v + q * v3 + r * v4 + s * v5 + w * v6 + z * v7) / place,
            (p * a1 + q * a3 + r * a4 + s * a5 + w * a6 + z * a7) / speed,
            (p * b1 + q * b3 + r * b4 + s * b5 + w * b6 + z * b7) / speed,
        )
        error = math.sqrt(0.25 * (e[0] * e[0] + e[1] * e[1] + e[2] * e[2] + e[3] * e[3]))
        return (x7, y7, u7, v7), (a7, b7), error


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
        doubts = []
        if not self.are_alike:
            doubts.append("no two turns are alike, and others may lie outside")
        if self.margin > _LOOSE:
            doubts.append("clearance and deflection are no longer small beside the mechanism")
        return tuple(doubts)


class FollowedPin:
    """The motion of one pin, found when it is first asked for; the same for all reversals.

    Attributes:
        contact: what the pin touches.
    """

    def __init__(
        self,
        opened: OpenedJoint,
        source: ForceSource,
        course: ForceCourse,
        contact: PinContactNumbers,
        mass: float,
        speed: float,
    ) -> None:
        """Keep what is needed.

        Args:
            opened: the mechanism with this joint open, its drive's motion prescribed.
            source: of closed positions.
            course: of the force without clearance.
            contact: what the pin touches.
            mass: mean of the joint [kg].
            speed: of the drive [rad/s].
        """
        self._asked = opened, source, course
        self.contact, self._speed, self._period = contact, speed, source.period
        self._length = source.problem.mechanism.characteristic_length
        self._swing = 2.0 * math.pi * math.sqrt(mass / contact.stiffness)

    def __getstate__(self) -> dict[str, object]:
        # A copy has what was found, and not the mechanism.
        self._found  # noqa: B018
        return {name: value for name, value in vars(self).items() if name != "_asked"}

    @cached_property
    def _found(self) -> PlanarMotion | str:
        """What the pin did, or why it cannot be followed."""
        opened, source, course = self._asked
        if _STEPS * (3.0 + _SETTLED) * self._turn >= _MOST_STEPS * self._swing:
            return _TOO_STIFF
        positions = self._period / _PLACES * np.arange(_PLACES)
        closed = source.motion(positions, 1.0)
        try:
            plane = opened.plane(closed.rows, closed.v, course.at(positions), self._period)
        except ModelError as error:
            return str(error)
        motion = PlanarModel(plane, self.contact, self._speed).run(_PERIODS)
        settled = motion.end - float(motion.time[0]) - _SETTLED * self._turn
        # Any stretch of a period is passed twice in three turns.
        return motion if settled >= 3.0 * self._turn else _TOO_STIFF

    @property
    def reason(self) -> str:
        """Why the pin cannot be followed; empty if it can."""
        return self._found if isinstance(self._found, str) else ""

    @property
    def _turn(self) -> float:
        return self._period / abs(self._speed)

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
        first = (position / self._speed - begun) % turn
        starts = begun + first + turn * np.arange(math.ceil(_PERIODS) + 1)
        starts = starts[(starts >= begun + _SETTLED * turn) & (starts + lasts <= motion.end)]
        rows = [self._passage(motion, start, start + lasts) for start in starts.tolist()]
        forces, times, speeds = np.array(rows).T
        offset = 0.5 * self.contact.clearance + float(np.mean(forces)) / self.contact.stiffness
        place = self._speed * float(times[np.argmax(forces)]) % self._period
        margin = _MODEL + _PER_OFFSET * offset / self._length
        return Passages(forces, speeds, place, margin)

    def _passage(self, motion: PlanarMotion, start: float, end: float) -> tuple[float, ...]:
        """Return the greatest force of one passage, when that is, and its hardest strike."""
        struck = [item.speed for item in motion.touches if start <= item.time < end]
        return *motion.greatest(start, end), max([0.0, *struck])
