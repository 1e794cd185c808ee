"""Runs: what a method of simulation found, as states at any times."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...core.dynamics.problem_solver import ProblemSolver
from ...core.problem.samples import Targets
from ...core.results.collect import motion_at
from ...kit.arrays import Array
from .continuity import States
from .energy_integral import EnergyIntegral
from .free_balls import FreeBall, WithBalls
from .integration import Integration
from .scalar_equation import ScalarEquation
from .system import Rows, System


class Run:
    """What a method of simulation found; by itself, of steps with a tolerance.

    Attributes:
        times: of its own steps `(N,)` [s].
        period: time after which speeds, and the work done since time 0, come back [s]; inf if
            never.
        is_exact: whether states are exact to rounding, and not to the tolerance of steps.
        boundless: velocity coordinates whose values have no bound: angles that are read off
            rotations.
        regular: has these rotations; None where there are none.
    """

    times: Array
    period = np.inf
    is_exact = False
    boundless: frozenset[int] = frozenset()
    regular: WithBalls | None = None

    @property
    def balls(self) -> Sequence[FreeBall]:
        """What is integrated as a rotation."""
        return self.regular.balls if self.regular else ()

    def late(self, times: Array) -> Array:
        """Return by how much rounding of time may move what happens at times `(N,)` [s]."""
        return np.zeros_like(times)

    def drives_alone(self, times: Array) -> States | None:
        """Return the drives at times, turns counted; None if all coordinates are needed for it."""
        return None

    def rows(self, times: Array, drives: States | None = None) -> Rows:
        """Return the states at times within the run; `drives` is what `drives_alone` returned."""
        raise NotImplementedError


class ConstrainedRun(Run):
    """States that were integrated in all coordinates."""

    def __init__(self, integration: Integration, system: System) -> None:
        self._integration, self._system = integration, system
        self.times = integration.times
        mechanism = system.model.mechanism
        self.regular = mechanism if isinstance(mechanism, WithBalls) else None
        self.boundless = frozenset(ball.rate + k for ball in self.balls for k in range(3))

    def rows(self, times: Array, drives: States | None = None) -> Rows:
        """See `Run.rows`."""
        return self._system.rows(*self._integration.columns(times))


class OneCoordinateRun(Run):
    """States that follow from the motion of the only drive."""

    def __init__(
        self, solver: ProblemSolver, times: Array, law: EnergyIntegral | IntegratedLaw
    ) -> None:
        """Make the run.

        Args:
            solver: of the scene.
            times: see `Run.times`.
            law: the drive's motion.
        """
        self._solver, self.times, self._law = solver, times, law
        if isinstance(law, EnergyIntegral):
            self.period, self.is_exact = law.period, True

    def late(self, times: Array) -> Array:
        """See `Run.late`."""
        law = self._law
        return law.late(times) if isinstance(law, EnergyIntegral) else super().late(times)

    def drives_alone(self, times: Array) -> States:
        """See `Run.drives_alone`; no loop has to be closed for it."""
        return States(*(values[:, None] for values in self._law.at(times)))

    def rows(self, times: Array, drives: States | None = None) -> Rows:
        """See `Run.rows`."""
        drives = drives or self.drives_alone(times)
        motion = motion_at(self._solver, Targets.of_positions(drives.x), drives.v, drives.a)
        exist = np.ones(motion.v.shape, dtype=bool)
        read = self._law.read(times) if isinstance(self._law, IntegratedLaw) else None
        return Rows(motion.x, motion.turns, motion.v, motion.a, exist, read=read)


class IntegratedLaw:
    """The drive's motion as a scalar equation was integrated: a function of times `(N,)`."""

    def __init__(self, integration: Integration, equation: ScalarEquation) -> None:
        self._integration, self._equation = integration, equation

    def at(self, times: Array) -> States:
        """Return the motion at times, each `(N,)`."""
        y, turns, rates = self._integration.columns(times)
        return States(y[:, 0] + 2.0 * np.pi * turns[:, 0], y[:, 1], rates[:, 1])

    def read(self, times: Array) -> tuple[Array, Array]:
        """Return coordinates `(N, size)` and velocities `(N, nv)` that forces were told of."""
        y, turns, _ = self._integration.columns(times)
        x, v = zip(*map(self._equation.read, y, turns), strict=True)
        return np.array(x), np.array(v)
