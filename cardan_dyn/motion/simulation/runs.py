"""Runs: what a method of simulation found, as states at any times."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from ...core.dynamics.problem_solver import ProblemSolver
from ...core.problem.samples import Targets
from ...core.results.collect import motion_at
from ...kit.arrays import Array
from .continuity import States
from .energy_integral import EnergyIntegral
from .free_balls import WithBalls
from .integration import Integration
from .system import Rows, System


class Run(Protocol):
    """What a method of simulation found."""

    @property
    def times(self) -> Array:
        """Times of its own steps `(N,)` [s]."""
        ...

    @property
    def period(self) -> float:
        """Time after which speeds, and the work done since time 0, come back [s]; inf if never."""
        ...

    @property
    def is_exact(self) -> bool:
        """Whether states are exact to rounding, and not to the tolerance of steps."""
        ...

    @property
    def boundless(self) -> frozenset[int]:
        """Velocity coordinates whose values have no bound: angles that are read off rotations."""
        ...

    def late(self, times: Array) -> Array:
        """Return by how much rounding of time may move what happens at times `(N,)` [s]."""
        ...

    def drives_alone(self, times: Array) -> States | None:
        """Return the drives at times, turns counted; None if all coordinates are needed for it."""
        ...

    def rows(self, times: Array, drives: States | None = None) -> Rows:
        """Return the states at times within the run; `drives` is what `drives_alone` returned."""
        ...


class ConstrainedRun:
    """States that were integrated in all coordinates; see `Run`."""

    def __init__(self, integration: Integration, system: System) -> None:
        self._integration, self._system = integration, system
        self.times = integration.times
        self.period, self.is_exact = np.inf, False

    @property
    def boundless(self) -> frozenset[int]:
        """See `Run.boundless`."""
        mechanism = self._system.model.mechanism
        balls = mechanism.balls if isinstance(mechanism, WithBalls) else ()
        return frozenset(ball.rate + k for ball in balls for k in range(3))

    def late(self, times: Array) -> Array:
        """See `Run.late`; steps are as long as their ends are apart."""
        return np.zeros_like(times)

    def drives_alone(self, times: Array) -> None:
        """See `Run.drives_alone`."""

    def rows(self, times: Array, drives: States | None = None) -> Rows:
        """See `Run.rows`."""
        return self._system.rows(*self._integration.columns(times))


class OneCoordinateRun:
    """States that follow from the motion of the only drive; see `Run`."""

    def __init__(
        self,
        solver: ProblemSolver,
        times: Array,
        law: Callable[[Array], States],
        integral: EnergyIntegral | None = None,
    ) -> None:
        """Make the run.

        Args:
            solver: of the scene.
            times: see `Run.times`.
            law: the drive's motion at times `(N,)`.
            integral: whose law it is; None if it was integrated.
        """
        self._solver, self.times, self._law, self._integral = solver, times, law, integral
        self.period = integral.period if integral else np.inf
        self.is_exact = integral is not None
        self.boundless: frozenset[int] = frozenset()

    def late(self, times: Array) -> Array:
        """See `Run.late`."""
        return self._integral.late(times) if self._integral else np.zeros_like(times)

    def drives_alone(self, times: Array) -> States:
        """See `Run.drives_alone`; no loop has to be closed for it."""
        return States(*(values[:, None] for values in self._law(times)))

    def rows(self, times: Array, drives: States | None = None) -> Rows:
        """See `Run.rows`."""
        drives = drives or self.drives_alone(times)
        motion = motion_at(self._solver, Targets.of_positions(drives.x), drives.v, drives.a)
        return Rows(motion.x, motion.turns, motion.v, motion.a, np.ones(motion.v.shape, dtype=bool))


class IntegratedLaw:
    """The drive's motion as a scalar equation was integrated: a function of times `(N,)`."""

    def __init__(self, integration: Integration) -> None:
        self._integration = integration

    def __call__(self, times: Array) -> States:
        """Return the motion at times, each `(N,)`."""
        y, turns, rates = self._integration.columns(times)
        return States(y[:, 0] + 2.0 * np.pi * turns[:, 0], y[:, 1], rates[:, 1])
