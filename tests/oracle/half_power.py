"""Half power of a universal joint's driven torsional rig, by shooting along its branch of motions.

A drive turns at the constant speed Ω behind an elastic shaft (k, c), whose far end with the moment
of inertia J₁ turns by θ = φ + q; a joint with the angle β turns J₂ behind it. With φ = Ω t, dashes
by φ, and the joint's ratio η(θ) = cos β / D, D = 1 - sin²β cos²θ:

    Ω² [(J₁ + J₂ η²) (θ'' = q'') + J₂ η η_θ (1 + q')²] + k q + c Ω q' = 0

A motion repeats after half a turn, over which it is integrated by Runge and Kutta's rule of fourth
order. Its start and Ω are followed by arclength, through folds, from below the resonance of order 2
to above it. Nothing here knows the package under test but `ask`.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import cos, pi, sin

import numpy as np
from scipy.interpolate import CubicSpline
from testkit import elastic_rigs

import cardan_dyn as cd

Array = np.ndarray
_STEPS = 160
"""Of the integration over half a turn, through which the resonance swings once."""
_CHANGE = 1e-6
"""Step of differences."""
_FARTHEST = 0.06
"""Longest way between two points, as a fraction of the greatest amplitude and of the width."""
_PLACES = 40
"""Between two points, at which a spline through all of them is looked at."""
WORST = 5e-3
"""Error of a half-power speed, as a fraction of the width."""


@dataclass(frozen=True)
class Widths:
    """What is known of a resonance.

    Attributes:
        peak: greatest amplitude of order 2 [rad].
        speed: where that is [rad/s].
        lower, upper: least and greatest speed about it at which the amplitude is above peak/√2.
        folds: speeds at which the branch turns back.
    """

    peak: float
    speed: float
    lower: float
    upper: float
    folds: tuple[float, ...]


@dataclass(frozen=True)
class DrivenRig:
    """A rig.

    Attributes:
        front, behind: J₁ and J₂ [kg m²].
        stiffness: k [N m/rad].
        damping: c [N m s/rad].
        beta: joint angle [rad].
    """

    front: float
    behind: float
    stiffness: float
    damping: float
    beta: float

    @property
    def natural(self) -> float:
        """Natural frequency of small motions with the joint stretched [rad/s]."""
        return (self.stiffness / (self.front + self.behind)) ** 0.5

    def bend(self, phi: float, q: float, rate: float, speed: float) -> float:
        """Return q''."""
        theta = phi + q
        c, s = cos(theta), sin(theta)
        square = sin(self.beta) ** 2
        nominal = 1.0 - square * c * c
        ratio = cos(self.beta) / nominal
        slope = -ratio * 2.0 * square * s * c / nominal
        forces = self.behind * ratio * slope * (1.0 + rate) ** 2
        forces += self.stiffness * q / speed**2 + self.damping * rate / speed
        return -forces / (self.front + self.behind * ratio * ratio)

    def course(self, q: float, rate: float, speed: float) -> Array:
        """Return q and q' `(steps + 1, 2)` over half a turn, from a start."""
        h = pi / _STEPS
        found = [(q, rate)]
        for step in range(_STEPS):
            phi = h * step
            a = self.bend(phi, q, rate, speed)
            b = self.bend(phi + h / 2, q + h / 2 * rate, rate + h / 2 * a, speed)
            c = self.bend(phi + h / 2, q + h / 2 * rate + h * h / 4 * a, rate + h / 2 * b, speed)
            d = self.bend(phi + h, q + h * rate + h * h / 2 * b, rate + h * c, speed)
            q, rate = (
                q + h * rate + h * h / 6 * (a + b + c),
                rate + h / 6 * (a + 2 * b + 2 * c + d),
            )
            found.append((q, rate))
        return np.array(found)

    def _miss(self, point: Array) -> Array:
        way = self.course(*point.tolist())
        return way[-1] - way[0]

    def amplitude(self, point: Array) -> float:
        """Return that of order 2 of the motion with a start (q, q', Ω)."""
        q = self.course(*point.tolist())[:-1, 0]
        return float(2.0 * abs(np.mean(q * np.exp(-2j * pi * np.arange(_STEPS) / _STEPS))))

    def _corrected(self, point: Array, across: Array) -> tuple[Array, Array] | None:
        """Return the motion on the plane through a guess across a way, and the way on there."""
        row = across
        for _ in range(12):
            miss = self._miss(point)
            matrix = np.empty((3, 3))
            for column, unit in enumerate((1.0, 1.0, point[2])):
                moved = point.copy()
                moved[column] += _CHANGE * unit
                matrix[:2, column] = (self._miss(moved) - miss) / (_CHANGE * unit)
            matrix[2] = row
            change = np.linalg.solve(matrix, [*-miss, 0.0])
            point = point + change
            if np.max(np.abs(change[:2])) < 1e-9 and abs(change[2]) < 1e-10 * point[2]:
                return point, np.linalg.solve(matrix, [0.0, 0.0, 1.0])
            if np.max(np.abs(change[:2])) > 1.0:
                return None
        return None

    def motion(self, speed: float) -> Array:
        """Return the start of the motion that Newton's method reaches from rest at a speed."""
        found = self._corrected(np.array([0.0, 0.0, speed]), np.array([0.0, 0.0, 1.0]))
        assert found is not None
        return found[0]

    def up_to(self, speed: float, size: float) -> float:
        """Return the speed at which motions without damping reach an amplitude.

        They are followed from a speed towards half of the natural frequency, in steps along the
        rate at the start: what comes back to itself in time has its extreme there, or none.

        Args:
            speed: to begin with [rad/s].
            size: of order 2 [rad].
        """
        point, way = self.motion(speed), np.array([0.0, 0.0, 0.5 * self.natural - speed])
        scale = np.array([1.0, 1.0, abs(way[2])])
        before = np.append(point, self.amplitude(point))
        for _ in range(100):
            ahead = way / np.linalg.norm(way / scale)
            row = ahead / scale**2
            done = self._corrected(point + 0.05 * ahead, row)
            assert done is not None
            point, way = done
            way = way if way @ row > 0.0 else -way
            here = np.append(point, self.amplitude(point))
            if here[3] >= size:
                share = (size - before[3]) / (here[3] - before[3])
                return float(before[2] + share * (here[2] - before[2]))
            before = here
        raise AssertionError("motions stay smaller")

    def branch(self, low: float, high: float, width: float, size: float) -> Array:
        """Return points `(P, 4)` of the branch from one speed to another: a start, Ω, amplitude.

        Args:
            low: speed.
            high: speed.
            width: of the resonance, in which speeds count [rad/s].
            size: of its motions.
        """
        scale = np.array([size, size, width])
        point, way = self.motion(low), np.array([0.0, 0.0, 1.0])
        found, step = [np.append(point, self.amplitude(point))], 0.5
        while point[2] < high:
            ahead = way / np.linalg.norm(way / scale)
            row = ahead / scale**2
            done = self._corrected(point + step * ahead, row)
            # Far away steps may be long, since nothing happens there.
            most = _FARTHEST * max(1.0, abs(point[2] - 0.5 * self.natural) / width)
            gap = (
                np.inf
                if done is None
                else np.linalg.norm((done[0] - point) / scale - step * ahead / scale)
            )
            if done is None or gap > 0.2 * step:
                step /= 2.0
                assert step > 1e-7, f"the branch is lost at {point}"
                continue
            point, way = done
            way = way if way @ row > 0.0 else -way
            found.append(np.append(point, self.amplitude(point)))
            step = min(1.5 * step, most)
            assert len(found) < 3000 and point[2] > 0.8 * low
        return np.array(found)

    def widths(self) -> Widths:
        """Return peak and half power."""
        ratio = self.damping * self.natural / (2.0 * self.stiffness)
        lean = self.behind / (self.front + self.behind) * np.tan(self.beta / 2.0) ** 2
        # Of a linear resonance, and of what the joint's angle makes of greater ones.
        width = 0.5 * self.natural * max(ratio, lean / 2.0)
        size = min(max(lean, 1e-6) / ratio, 0.5)
        found = self.branch(0.36 * self.natural, 0.72 * self.natural, width, size)
        way = np.concatenate(
            [
                [0.0],
                np.cumsum(np.linalg.norm(np.diff(found[:, 2:] / [width, size], axis=0), axis=1)),
            ]
        )
        curve = CubicSpline(way, found[:, 2:])
        fine = np.concatenate(
            [np.linspace(*pair, _PLACES, endpoint=False) for pair in pairwise(way)]
        )
        speed, sizes = curve(fine).T
        top = int(np.argmax(sizes))
        peak = float(sizes[top])
        below = np.nonzero(sizes < peak / np.sqrt(2.0))[0]
        first, last = below[below < top][-1], below[below > top][0]
        inside = speed[first : last + 1]
        turns = np.sign(np.diff(speed))
        folds = speed[np.nonzero(turns[1:] * turns[:-1] < 0.0)[0] + 1]
        return Widths(
            peak, float(speed[top]), float(inside.min()), float(inside.max()), tuple(folds.tolist())
        )


def draw(seed: int) -> DrivenRig:
    """Return the rig of a seed: half of them with damping at which motions grow large."""
    random = np.random.default_rng([seed, 42])
    inertia, natural = float(10.0 ** random.uniform(-2, 0)), float(random.uniform(20.0, 400.0))
    share, beta = float(random.uniform(0.15, 0.9)), float(np.radians(random.uniform(3.0, 20.0)))
    ratio = float(10.0 ** (random.uniform(-2.3, -1.8) if seed % 2 else random.uniform(-1.8, -0.9)))
    k = inertia * natural**2
    return DrivenRig(inertia * (1.0 - share), inertia * share, k, 2.0 * ratio * k / natural, beta)


def scene(rig: DrivenRig) -> cd.Scene:
    """Return the scene of a rig."""
    text = elastic_rigs.torsional_line(rig.front, rig.behind, rig.stiffness, damping_in=rig.damping)
    return elastic_rigs.scene(text, rig.beta)


def row_of(rig: DrivenRig) -> cd.vibration.CriticalSpeed:
    """Return the row of order 2 in the table of a rig."""
    ends = [0.4 * rig.natural, 0.6 * rig.natural]
    found = cd.vibration.critical_speeds(scene(rig), ends, orders=2, instabilities=False)
    (row,) = found
    return row


def ask(seed: int) -> tuple[list[str], list[str]]:
    """Return what is wrong with the half power of a rig, and what kind of resonance it has."""
    rig = draw(seed)
    row, own = row_of(rig), rig.widths()
    width = own.upper - own.lower
    kinds = ["folds" if own.folds else "no folds", row.outcome]
    if row.outcome == "open":
        wrong = [f"at least {row.severity:.6g}, not {own.peak:.6g}"] * (row.severity < own.peak)
        return wrong, kinds
    wrong = []
    for name, limit in (
        ("speed", WORST * width),
        ("lower", WORST * width),
        ("upper", WORST * width),
    ):
        value, expected = getattr(row, name), getattr(own, name)
        if not abs(value - expected) <= limit:
            wrong.append(f"{name} is {value:.8g}, not {expected:.8g}, of a width of {width:.3g}")
    if not abs((row.upper - row.lower) / width - 1.0) <= WORST:
        wrong.append(f"width is {row.upper - row.lower:.6g}, not {width:.6g}")
    if not abs(row.severity / own.peak - 1.0) <= 1e-3:
        wrong.append(f"severity is {row.severity:.8g}, not {own.peak:.8g}")
    if abs(row.frequency - 2.0 * row.speed) > 1e-12 * row.frequency:
        wrong.append(f"frequency is {row.frequency:.8g} at {row.speed:.8g}")
    return wrong, kinds
