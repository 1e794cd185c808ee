"""Forces: what joints carry over a period without clearance, and where that swings round."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...core.problem.samples import Targets
from ...core.response.response import Response
from ...core.results.collect import motion_at
from ...kit.arrays import NOTHING, ROUNDED, Array
from ...kit.checks import described
from ...kit.errors import AccuracyError, ArgumentError, IndeterminateError
from ...kit.periodic import Fourier, highest
from ...kit.roots import rising
from .arguments import period_of
from .opened_joint import BearingForces, OpenedJoint

if TYPE_CHECKING:
    from ...core.results.motion import Motion
    from ...scene.scene import Scene

_SAMPLES, _MOST_SAMPLES = 720, 11_520
"""Positions over a period; doubled until the forces' series ends."""
_ROUGH = float(np.sqrt(ROUNDED))
"""Last harmonics of a force, and depth of a dip in its size, as a fraction of the greatest, that
may be rounding: a force is exact beside the greatest of all joints alone."""
_FLAT = 1e-4
"""Slope per radian, as a fraction of the greatest force, up to which a force that vanishes only
touches zero: it comes back the way it went, and a ramp is not what it follows."""


class ForceSource:
    """Where forces come from: sweeps of a scene, or its response, which takes none.

    Attributes:
        solver: of the scene.
        problem: what it solves.
        period: of the drive, after which everything repeats [rad].
        is_inertial: whether inertia alone acts.
    """

    def __init__(self, given: Scene | Response) -> None:
        """Keep it."""
        from ...scene.scene import Scene  # Known to who has one.

        if not isinstance(given, (Scene, Response)):
            raise ArgumentError(f"scene is {described(given)}; expected a scene or its response")
        if isinstance(given, Response) and np.isfinite(given.interval[0]):
            raise ArgumentError(
                f"the response holds from {given.interval[0]:g} to {given.interval[1]:g} alone; "
                "make one of the whole turn: scene.response()"
            )
        self._given, self.solver = given, given.solver
        self.problem = problem = given.solver.problem
        self.period = period_of(given.solver)
        acts = any(np.any(effort) for effort in problem.joint_loads.values())
        self.is_inertial = not (
            acts or problem.link_loads or np.any(problem.gravity) or problem.elements
        )

    def motion(self, positions: Array, speed: float = 0.0) -> Motion:
        """Return the motion at drive positions `(K,)`."""
        return motion_at(self.solver, Targets.of_positions(positions[:, None]), speed)

    def closed(self, positions: list[float]) -> Array:
        """Return closed coordinates `(K, size)` at drive positions."""
        if not positions:
            return np.zeros((0, self.problem.mechanism.coordinates.size))
        return self.motion(np.asarray(positions)).rows

    def forces(
        self, speed: float, joints: Mapping[str, OpenedJoint], *, refuse: bool
    ) -> tuple[Array, dict[str, BearingForces], dict[str, ForceCourse], dict[str, str]]:
        """Return the forces of joints.

        Args:
            speed: of the drive [rad/s].
            joints: by name.
            refuse: forces that are indeterminate; else their joints are left out.

        Returns:
            Positions of the drive over a period `(N,)` [rad]; joints to the forces of their open
            bearings there, to the same as functions of the position, and, of those that are left
            out, to why.
        """
        count = _SAMPLES
        while True:
            positions = self.period / count * np.arange(count)
            every = self._turn(positions, speed, joints)
            left_out = {name: item.open_for for name, item in every.items() if item.open_for}
            if refuse and left_out:
                name, reason = next(iter(left_out.items()))
                raise IndeterminateError(f"joint {name!r}: {reason}")
            found = {name: item for name, item in every.items() if name not in left_out}
            sizes = {name: float(np.max(np.abs(item.local))) for name, item in found.items()}
            greatest = max(sizes.values(), default=0.0)
            for name, size in sizes.items():
                if size <= NOTHING * max(greatest, joints[name].inertia * speed**2):
                    world, local, _ = found[name]
                    found[name] = BearingForces(0.0 * world, 0.0 * local, "")
            courses = {name: ForceCourse(item.local, self.period) for name, item in found.items()}
            rough = [name for name, course in courses.items() if course.tail > _ROUGH * greatest]
            if not rough:
                break
            if count >= _MOST_SAMPLES:
                raise AccuracyError(
                    f"{count} positions do not resolve the force of joint {rough[0]!r} over a "
                    "period"
                )
            count *= 2
        if not (self.is_inertial or self.problem.elements):
            resting = self._turn(positions, 0.0, {name: joints[name] for name in found})
            for name, item in found.items():
                inertial = item.local - resting[name].local
                courses[name] = ForceCourse(item.local, self.period, inertial)
        return positions, found, courses, left_out

    def _turn(
        self, positions: Array, speed: float, joints: Mapping[str, OpenedJoint]
    ) -> dict[str, BearingForces]:
        """Return forces over a period."""
        given = self._given
        sweep = given.sweep(positions, speed)
        # A response knows no places of joints: it keeps the motion that gives them.
        motion = given.turn(len(positions)) if isinstance(given, Response) else sweep.motion
        return {name: joint.forces(sweep, motion) for name, joint in joints.items()}


class Swing(NamedTuple):
    """A position at which the force of a joint is least, so that it swings round.

    Attributes:
        position: of the drive [rad].
        least: size of the force there [N].
        slope: size of its rate there [N/rad].
        direction: `(B d,)` unit vector of the rate as the drive turns in its sense.
        way: how far the drive turns until the force is greatest [rad].
        growth: by which power of the speed the force's rate per time grows, d ln(slope Ω) / d ln Ω:
            3 if inertia alone acts.
    """

    position: float
    least: float
    slope: float
    direction: Array
    way: float
    growth: float


class ForceCourse:
    """The force of a joint over one period of a mechanism, those of its bearings stacked.

    Attributes:
        tail: greatest of the last harmonics of all components [N].
    """

    def __init__(self, forces: Array, period: float, inertial: Array | None = None) -> None:
        """Make the course.

        Args:
            forces: `(N, B, d)` of bearings at equidistant positions of the drive from 0 [N].
            period: after which they repeat [rad].
            inertial: `(N, B, d)` that part of them which grows with the square of the speed, the
                rest not depending on it; None if it is all of them.
        """
        count, self._period = len(forces), period
        self._each = np.linalg.norm(forces, axis=2)
        self._forces = forces.reshape(count, -1)
        self._sizes = np.linalg.norm(self._each, axis=1)
        series = Fourier.of(self._forces.T, period)
        self.tail = float(np.max(highest(self._forces)))
        self._local = _with_derivatives(series)
        self._inertial: Fourier | None = None
        if inertial is not None:
            self._inertial = _with_derivatives(Fourier.of(inertial.reshape(count, -1).T, period))

    @property
    def most(self) -> float:
        """Greatest force of a bearing among the samples [N]."""
        return float(np.max(self._each))

    def at(self, positions: Array) -> Array:
        """Return the stacked forces `(K, B d)` at positions of the drive `(K,)` [N]."""
        return np.asarray(self._local(positions)[: self._forces.shape[1]].T)

    def greatest(self, position: float, way: float, sense: float) -> Array:
        """Return the greatest force of each bearing `(B,)` [N] over a way of the drive."""
        count = len(self._forces)
        since = sense * (self._period / count * np.arange(count) - position) % self._period
        return np.asarray(np.max(self._each[since <= way], axis=0, initial=0.0))

    def swings(self, sense: float) -> list[Swing]:
        """Return where the stacked force is least, in the order of positions.

        Args:
            sense: +1 or -1, in which the drive turns.
        """
        sizes = self._sizes
        step, greatest = self._period / len(sizes), float(np.max(sizes))
        found = []
        for index in _dips(sizes):
            position = self._least_near(index * step, step)
            force, rate, curvature = self._local.at(position).reshape(3, -1)
            slope, least = float(np.linalg.norm(rate)), float(np.linalg.norm(force))
            if slope == 0.0 or max(slope, least) <= _FLAT * greatest:
                continue
            # The period's end is its beginning, to rounding.
            place = position % self._period
            after = np.roll(sizes[:: int(sense)], -index if sense > 0 else index + 1)
            falls = np.append(after[1:] < after[:-1], [False, True])
            found.append(
                Swing(
                    position=place if self._period - place > ROUNDED * self._period else 0.0,
                    least=least,
                    slope=slope,
                    direction=sense * rate / slope,
                    way=int(np.argmax(falls)) * step,
                    growth=self._growth(position, force, rate, curvature),
                )
            )
        return found

    def _least_near(self, position: float, step: float) -> float:
        """Return where the force is least, within a step, as F · F' rises through zero there."""

        def rate_of_square(at: Array, _: Array) -> tuple[Array, Array]:
            force, rate, curvature = self._local(at).reshape(3, -1)
            return np.array([force @ rate]), np.array([rate @ rate + force @ curvature])

        middle = np.array([position])
        return float(rising(rate_of_square, middle - step, middle + step)[0])

    def _growth(self, position: float, force: Array, rate: Array, curvature: Array) -> float:
        """Return by which power of the speed the rate per time grows, the least force moving."""
        if self._inertial is None:
            return 3.0
        # By d ln Ω the force grows by twice its inertial part, at one position.
        grown, grown_rate, _ = 2.0 * self._inertial.at(position).reshape(3, -1)
        moved = -(grown @ rate + force @ grown_rate) / (rate @ rate + force @ curvature)
        return float(1.0 + rate @ (curvature * moved + grown_rate) / (rate @ rate))


def _dips(sizes: Array) -> list[int]:
    """Return where sizes over a period are least, but for dips that may be rounding."""
    is_least = (sizes < np.roll(sizes, 1)) & (sizes <= np.roll(sizes, -1))
    found, least = np.nonzero(is_least)[0].tolist(), _ROUGH * float(np.max(sizes))
    if np.ptp(sizes) <= least:
        return []
    while len(found) > 1:
        between = [
            np.max(np.roll(sizes, -low)[: (high - low) % len(sizes)])
            for low, high in zip(found, [*found[1:], found[0]], strict=True)
        ]
        rises = np.minimum(between, np.roll(between, 1)) - sizes[found]
        if np.min(rises) > least:
            break
        del found[int(np.argmin(rises))]
    return [int(index) for index in found]


def _with_derivatives(series: Fourier) -> Fourier:
    """Return functions, their first and their second derivatives in one series."""
    rate = series.derivative()
    every = (series, rate, rate.derivative())
    return Fourier(np.concatenate([item.coefficients for item in every]), series.frequency)
