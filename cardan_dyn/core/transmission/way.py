"""Way: from coordinates of one side of a transmission to those of the other."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...kit.arrays import Array
from ...kit.checks import mapping, numbers
from ...kit.errors import (
    ArgumentError,
    AssemblyError,
    SingularConfigurationError,
    as_position,
    choices,
)
from ..description.description import Limits
from ..dynamics.problem_solver import ProblemSolver
from ..kinematics.tolerances import MOVES, SINGULAR_CONDITION
from ..problem.problem import Problem
from ..problem.samples import acting_on, targets_of
from ..results.collect import sweep_of
from ..results.sweep import Sweep


class Side(NamedTuple):
    """Coordinates of one side.

    Attributes:
        role: how arguments of its positions are called: `actuated` or `joints`.
        names: of the n coordinates.
        listed: whether they were named in a list: then their values have a last axis of length n.
        slides: `(n,)` whether each is a slide [m]; else it is an angle [rad].
        units: `(n,)` displacements that count alike: 1 of an angle, the length of the mechanism
            of a slide.
        limits: what the description says of each; infinite where it says nothing.
    """

    role: str
    names: tuple[str, ...]
    listed: bool
    slides: tuple[bool, ...]
    units: Array
    limits: tuple[Limits, ...]

    def rows(self, label: str, value: object) -> Array:
        """Return values of the coordinates `(..., n)`, checked.

        Raises:
            ArgumentError: they are not finite, or have another shape.
        """
        array = numbers(label, value)
        if not self.listed:
            return array[..., None]
        if array.shape[-1:] != (len(self.names),):
            raise ArgumentError(
                f"{label} has shape {array.shape}, expected (..., {len(self.names)}) of "
                f"{choices(self.names)}"
            )
        return array

    def shown(self, values: Array) -> Array:
        """Return values `(..., n)` as they are given."""
        return values if self.listed else values[..., 0][()]


class Mapped(NamedTuple):
    """Coordinates of one side of a transmission; None where the other side has none.

    Attributes:
        position: `(..., n)` [rad or m], of a single name `(...)`.
        speed: likewise [rad/s or m/s].
        effort: likewise [N·m or N].
    """

    position: Array
    speed: Array | None = None
    effort: Array | None = None


class Way(ABC):
    """A way from the coordinates of one side to those of the other.

    Attributes:
        given, found: the sides.
    """

    def __init__(self, given: Side, found: Side) -> None:
        """Keep the sides."""
        self.given, self.found = given, found

    @abstractmethod
    def at(self, position: Array, held: object = None) -> tuple[Array, Array]:
        """Return what coordinates lead to, and its derivatives.

        Args:
            position: `(..., n)` of the given side [rad or m].
            held: held joints to other positions, which broadcast with `(...)`.

        Returns:
            `(..., n)`, and `(..., n, n)`: rows are those of the found side.

        Raises:
            CardanError: a position is out of reach, or out of range.
        """

    def mapped(
        self, position: object, speed: object = None, effort: object = None, held: object = None
    ) -> Mapped:
        """Return what is known of the given side on the other one, see `Maps.joints_of`."""
        of = self.given
        at = of.rows(of.role, position)
        values, jacobian = self.at(at, held)
        moving = forces = None
        if speed is not None:
            rates = of.rows("speed", speed)
            moving = self.found.shown((jacobian @ rates[..., None])[..., 0])
        if effort is not None:
            # What the one side does is what the other takes: Jᵀ forces = effort.
            efforts = of.rows("effort", effort)
            self.refuse_singular(np.broadcast_to(at, values.shape), jacobian)
            forces = np.linalg.solve(np.swapaxes(jacobian, -1, -2), efforts[..., None])[..., 0]
            forces = self.found.shown(forces)
        return Mapped(self.found.shown(values), moving, forces)

    def scaled(self, jacobian: Array) -> Array:
        """Return derivatives of displacements in units that count alike."""
        return jacobian * self.given.units / self.found.units[:, None]

    def refuse_singular(self, position: Array, jacobian: Array) -> None:
        """Refuse positions at which efforts do not follow from those of the given side.

        Args:
            position: `(..., n)`.
            jacobian: `(..., n, n)` there.

        Raises:
            SingularConfigurationError: there is one.
        """
        sizes = np.linalg.svd(self.scaled(jacobian), compute_uv=False)
        ratio = sizes[..., -1] / np.maximum(1.0, sizes[..., 0])
        if not ratio.size or np.min(ratio) * SINGULAR_CONDITION >= 1.0:
            return
        at = position[np.unravel_index(np.argmin(ratio), ratio.shape)]
        with np.errstate(divide="ignore"):
            condition = float(1.0 / np.min(ratio))
        raise SingularConfigurationError(
            f"{choices(self.found.names)} can take any effort at {as_position(at)} of "
            f"{choices(self.given.names)}, which do not move them there (condition number "
            f"{condition:.1e}); keep away from there: Transmission.borders tells where it is",
            position=as_position(at),
            condition=condition,
            joints=self.found.names,
        )


class SolvedWay(Way):
    """A way that sweeps of a scene go, in which the given side drives.

    Attributes:
        problem: of that scene.
        forth: the way from the found side, where that is what moves the mechanism: then positions
            are refused that it does not come back to, see `at`; None where the given side is.
    """

    def __init__(
        self, given: Side, found: Side, problem: Problem, forth: SolvedWay | None = None
    ) -> None:
        """Keep the sides, a problem in which the given one drives, and the way forth."""
        super().__init__(given, found)
        self.problem, self.forth = problem, forth

    @cached_property
    def solver(self) -> ProblemSolver:
        """Solves it; made where it is first needed, since one way may be singular at the start.

        Raises:
            CardanError: as `Scene`.
        """
        return ProblemSolver(self.problem)

    def begun(self) -> SolvedWay:
        """Return it, once it is known to start where its problem says.

        Raises:
            AssemblyError: it starts elsewhere.
            CardanError: what drives does not decide the motion.
        """
        values, _ = self._solved(self.start)
        off = values - [self.problem.near[name] for name in self.found.names]
        turns = np.where(self.found.slides, 0.0, np.rint(off / (2.0 * np.pi)))
        if np.max(np.abs(off - 2.0 * np.pi * turns) / self.found.units) > MOVES:
            raise AssemblyError(
                f"driven by {choices(self.given.names)}, the mechanism does not start where the "
                "scene does; let the scene start elsewhere: near=",
                position=as_position(self.start),
            )
        return self

    def sweep(
        self,
        position: Array,
        speed: Array | float = 0.0,
        acceleration: Array | float = 0.0,
        *,
        held: object = None,
        gravity: object = None,
        inertia: object = None,
    ) -> Sweep:
        """Return a sweep of the scene; arguments as of `Scene.sweep`, with a last axis."""
        problem = self.problem
        acting = acting_on(problem, speed, acceleration, None, gravity, inertia, 0.0)
        shape = np.broadcast_shapes(position.shape, np.shape(speed), np.shape(acceleration))
        with np.errstate(over="ignore", invalid="ignore"):
            targets = targets_of(problem, np.broadcast_to(position, shape), held)
            solver = self.solver.of_varied(targets.varied)
            solver.refuse_too_many(targets.size)
            return sweep_of(solver, solver.assembled_in_turn(targets, False), acting)

    def at(self, position: Array, held: object = None) -> tuple[Array, Array]:
        """See `Way.at`.

        Loops that close are not enough where the found side moves the mechanism: between its start
        and a position it may have to pass a singular configuration, and go another way from there.
        """
        values, jacobian = self._solved(position, held)
        if self.forth is None:
            return values, jacobian
        position = np.broadcast_to(position, values.shape)
        cause, lost = None, np.zeros(position.shape[:-1], dtype=bool)
        try:
            again, _ = self.forth._solved(values, held)
            lost = np.max(np.abs(again - position) / self.given.units, axis=-1) > MOVES
        except (AssemblyError, SingularConfigurationError) as error:
            cause = error
            lost.flat[error.sample or 0] = True
        if np.any(lost):
            at = as_position(position[lost][0])
            raise SingularConfigurationError(
                f"{choices(self.found.names)} do not bring {choices(self.given.names)} from where "
                f"the scene starts to {at}, although loops close there: they would pass a singular "
                "configuration; keep on this side of it (Transmission.borders), or let the scene "
                "start beyond it: near=",
                position=at,
                joints=self.given.names,
            ) from cause
        return values, jacobian

    @cached_property
    def start(self) -> Array:
        """Positions of the given side `(n,)` where the scene starts."""
        return np.array([self.problem.near[name] for name in self.given.names])

    def _solved(self, position: Array, held: object = None) -> tuple[Array, Array]:
        """Return what `at` does, wherever it is."""
        motion = self.sweep(position, held=held).motion
        others = mapping("held", held).values()
        shape = np.broadcast_shapes(position.shape, *((*np.shape(each), 1) for each in others))
        names, drives = self.found.names, range(shape[-1])
        values = np.stack([motion.position(name) for name in names], axis=-1)
        ratios = [np.stack([motion.ratio(name, k) for k in drives], axis=-1) for name in names]
        jacobian = np.stack(ratios, axis=-2)
        return values.reshape(shape), jacobian.reshape(*shape, shape[-1])

    def accelerations(self, position: Array, speed: Array) -> Array:
        """Return accelerations of the found side while the given one does not accelerate."""
        sweep = self.sweep(position, speed)
        names = self.found.names
        found = np.stack([sweep.motion.acceleration(name) for name in names], axis=-1)
        return found.reshape(np.broadcast_shapes(position.shape, speed.shape))

    def inertia(self, position: Array, factors: object = None) -> Array:
        """Return the inertia `(..., n, n)` that the given side feels.

        Args:
            position: `(..., n)` of the given side.
            factors: link to a factor on its mass and inertia, see `Scene.sweep`.
        """
        count = position.shape[-1]
        sweep = self.sweep(position[..., None, :], 0.0, np.eye(count), inertia=factors)
        rows = sweep.drive_effort.reshape(*position.shape, count)
        return np.asarray(0.5 * (rows + np.swapaxes(rows, -1, -2)))
