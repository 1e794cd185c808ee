"""Collecting: the sweep or the motion that a user gets, made from a solution."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..dynamics.inverse_dynamics import Solution
from ..dynamics.problem_solver import AssembledPositions, InTurn, ProblemSolver
from ..dynamics.velocity_ratios import VelocityRatios
from ..elements.link_loads import LinkLoad
from ..frozen import FrozenDict, frozen, read_only
from ..problem.acting import Acting
from ..problem.samples import Targets
from .motion import Motion, Rates
from .source import SolvedSource
from .sweep import Sweep
from .wrench import Components, StoredComponents

_NOTHING: FrozenDict[str, Any] = frozen({})


def sweep_of(
    solver: ProblemSolver, assembled: AssembledPositions, acting: Acting, solution: Solution
) -> Sweep:
    """Return a solution as a sweep.

    Args:
        solver: that found it.
        assembled: its positions.
        acting: how fast the drives move and what acts, as it was given.
        solution: what the solver found there.
    """
    problem, couplings, shape = solver.problem, solver.couplings, assembled.targets.shape
    moments: Mapping[str, Array] = _NOTHING
    unique: Mapping[str, bool] = _NOTHING
    if couplings:
        moments = frozen(
            {
                name: solution.coupling_moments[:, index].reshape(shape)
                for index, name in couplings.items()
            }
        )
        unique = frozen(
            {
                name: index not in solution.indeterminate_couplings
                for index, name in couplings.items()
            }
        )
    source = SolutionSource(solver, assembled, acting, solution)
    return Sweep(
        problem=problem,
        source=source,
        unique=solution.unique[problem.output_indices],
        coupling_moment=moments,
        coupling_unique=unique,
        condition=source.condition,
        # All residuals were judged; how great they are is for those who ask.
        proven=partial(
            solution.residuals.proven,
            solution.loop_error,
            solver.inverse_dynamics.bodies.unproven,
        ),
    )


class SolutionSource:
    """A `Source` of a solution, whose arrays take the shape of the samples when they are read.

    Attributes:
        shape: of the samples.
    """

    def __init__(
        self,
        solver: ProblemSolver,
        assembled: AssembledPositions,
        acting: Acting,
        solution: Solution,
    ) -> None:
        """Keep a solution; arguments as of `sweep_of`."""
        self.shape = assembled.targets.shape
        if type(assembled.blocks) is not InTurn or len(assembled.spans) > 1:
            # What made the positions may be large; what is asked of them later is not.
            assembled = replace(assembled, blocks=())
        solution.wrenches.setflags(write=False)
        self._solver, self._assembled = solver, assembled
        self._acting, self._solution = acting, solution

    def __reduce__(self) -> tuple[Any, ...]:
        wrenches = self._solution.wrenches
        return SolvedSource, (
            self.shape,
            wrenches.reshape(*self.shape, *wrenches.shape[1:]),
            self.drive_effort(),
            self.holding_effort(),
            self._motion,
            self.position,
            self.speed,
            self.acceleration,
            self.held,
            self.joint_loads,
            self.link_loads,
            self.gravity,
            self.inertia,
            self.time,
        )

    def __len__(self) -> int:
        return self.shape[0]

    def condition(self) -> Array:
        """Return the condition numbers of the samples, see `Sweep`."""
        magnification = self._solver.magnification_at(self._assembled, self._solution.x)
        return (magnification * self._solution.cancellation).reshape(self.shape)

    @cached_property
    def position(self) -> Array:
        """Drive positions `(...)`, or `(..., d)`."""
        return self._of_drives(self._assembled.targets.given)

    @cached_property
    def speed(self) -> Array:
        """Drive speeds, like `position`."""
        return self._of_drives(self._acting.speeds)

    @cached_property
    def acceleration(self) -> Array:
        """Drive accelerations, like `position`."""
        return self._of_drives(self._acting.accelerations)

    @cached_property
    def held(self) -> Mapping[str, float | Array]:
        """Held joints and their positions."""
        held, varied = self._solver.problem.held, self._assembled.targets.held
        return frozen({**held, **varied}) if varied else held

    @property
    def joint_loads(self) -> Mapping[str, Array]:
        """Loaded joints and their efforts, as they were given."""
        return self._acting.joint_loads

    @property
    def link_loads(self) -> Mapping[str, LinkLoad]:
        """Loaded links and their wrenches, as they were given."""
        return self._acting.link_loads

    @property
    def gravity(self) -> Array:
        """Acceleration of free fall, as it was given."""
        return read_only(self._acting.gravity)

    @property
    def inertia(self) -> Mapping[str, Array]:
        """Links and the factors on their mass and inertia, as they were given."""
        return self._acting.inertia

    @property
    def time(self) -> Array:
        """Times at which actuators act, as they were given."""
        return read_only(self._acting.time)

    def wrench(self, output: int) -> Components:
        """Return the wrench of an output, by its index, in its joint frame."""
        values = self._solution.wrenches[:, output]
        return StoredComponents(values if len(self.shape) == 1 else values.reshape(*self.shape, 6))

    def drive_effort(self) -> Array | None:
        """Return what the drive exerts, None if the outputs leave it out."""
        if not self._solver.knows_drive_efforts:
            return None
        drives = len(self._solver.problem.independent)
        return self._of_drives(self._solution.efforts[:, :drives].reshape(*self.shape, drives))

    def holding_effort(self) -> Mapping[str, Array]:
        """Return what holds the held joints."""
        efforts, columns = self._solution.efforts, self._solver.known_holding_efforts
        return frozen(
            {name: efforts[:, column].reshape(self.shape) for name, column in columns.items()}
        )

    def motion(self) -> Motion:
        """Return positions, speeds and accelerations."""
        return self._motion

    @cached_property
    def _motion(self) -> Motion:
        solution = self._solution
        v, a, ratios = solution.v, solution.a, solution.velocity_ratios
        rates: Rates | Callable[[], Rates]
        if v is None or a is None or ratios is None:
            rates = partial(self._solver.rates_at, self._assembled, solution.x, self._acting)
        else:
            rates = v, a, ratios
        return _motion(self._solver, self._assembled, solution.x, rates)

    def _of_drives(self, values: Array) -> Array:
        """Return values `(..., d)` in the shape of the samples, without an axis for one drive."""
        if values.shape[-1] == 1:
            values, whole = values[..., 0], self.shape
        else:
            whole = (*self.shape, values.shape[-1])
        if values.shape != whole:
            alone = values.size == math.prod(whole)
            values = values.reshape(whole) if alone else np.broadcast_to(values, whole)
        return read_only(values)


class Scattered(NamedTuple):
    """A sweep at more samples than were solved: NaN at the others.

    Attributes:
        known: indices of those that were solved.
        motion: at all N samples.
        acting: likewise.
    """

    known: Array
    motion: Motion
    acting: Acting

    def sweep(self, solved: Sweep, positions: Array) -> Sweep:
        """Return the sweep at all samples.

        Args:
            solved: at the known ones.
            positions: of the drives `(N, d)`.
        """
        source, acting = solved._source, self.acting
        shape = self.motion.shape
        efforts = source.drive_effort()
        each = [source.wrench(index) for index in range(len(solved.outputs))]
        wrenches = [self._values(np.concatenate([w.vector(0), w.vector(3)], axis=1)) for w in each]
        x, v, a = positions, acting.speeds, acting.accelerations.copy()
        a[np.isin(np.arange(len(a)), self.known, invert=True)] = np.nan
        if positions.shape[1] == 1:
            x, v, a = x[:, 0], v[:, 0], a[:, 0]
        every = SolvedSource(
            shape=shape,
            wrenches=read_only(np.stack(wrenches, axis=1)),
            drive_efforts=None if efforts is None else read_only(self._values(efforts)),
            holding_efforts=self._each(source.holding_effort()),
            solved_motion=self.motion,
            position=read_only(x),
            speed=read_only(v),
            acceleration=read_only(a),
            held=source.held,
            joint_loads=acting.joint_loads,
            link_loads=acting.link_loads,
            gravity=acting.gravity,
            inertia=acting.inertia,
            time=acting.time,
        )
        return Sweep(
            problem=solved.problem,
            source=every,
            unique=solved.unique,
            coupling_moment=self._each(solved.coupling_moment),
            coupling_unique=solved.coupling_unique,
            condition=read_only(self._values(solved.condition, np.inf)),
            proven=solved.proven,
        )

    def _values(self, known: Array, other: float = np.nan) -> Array:
        """Return `(N, ...)` known values, and another one elsewhere."""
        values = np.full((len(self.motion), *known.shape[1:]), other)
        values[self.known] = known
        return values

    def _each(self, known: Mapping[str, Array]) -> Mapping[str, Array]:
        return frozen({name: self._values(values) for name, values in known.items()})


def motion_at(
    solver: ProblemSolver, targets: Targets, speeds: Array, accelerations: Array
) -> Motion:
    """Return the motion alone at targets, speeds and accelerations `(N, d)` of the drives.

    As in a sweep, joints that no output needs are not solved, and are NaN.

    Raises:
        AssemblyError: the loops cannot be closed at a position.
        SingularConfigurationError: a position is a dead point.
    """
    assembled = solver.assembled_in_turn(targets)
    from ..dynamics.collected import Rows  # Sweeps of one block do without.

    rows = Rows(targets.size)
    for span, state in zip(assembled.spans, assembled.blocks, strict=True):
        rates = solver.inverse_dynamics.joint_rates(state, speeds[span], accelerations[span])
        ratios = VelocityRatios.of(rates.velocity_ratios, rates.depends)
        rows.put(span, {"x": state.x, "v": rates.v, "a": rates.a, "ratios": ratios.values})
    x, v, a, values = (rows.arrays[name] for name in ("x", "v", "a", "ratios"))
    return _motion(solver, assembled, x, (v, a, ratios._replace(values=values)))


def _motion(
    solver: ProblemSolver,
    assembled: AssembledPositions,
    x: Array,
    rates: Rates | Callable[[], Rates],
) -> Motion:
    """Return a motion from coordinates `(N, size)` and rates (see `Motion`).

    Coordinates that were not solved are NaN: starting guesses could be taken for results.
    """
    problem = solver.problem
    coordinates = problem.mechanism.coordinates
    if solver.unsolved:
        unsolved = set(solver.unsolved)
        x_columns = [
            column
            for name, span in coordinates.velocity_columns.items()
            if unsolved.intersection(range(span.start, span.stop))
            for column in range(*coordinates.columns[name].indices(x.shape[1]))
        ]
        x = _with_nan(x, x_columns)
        solved = rates

        def rates() -> Rates:
            v, a, ratios = solved() if callable(solved) else solved
            v, a = (_with_nan(values, solver.unsolved) for values in (v, a))
            return v, a, ratios.without(solver.unsolved)

    where = x, assembled.turns, rates, assembled.shape
    return Motion(problem.mechanism, problem.independent, *where)


def _with_nan(values: Array, columns: list[int]) -> Array:
    """Return values in which some columns are not numbers."""
    values = values.copy()
    values[:, columns] = np.nan
    return values
