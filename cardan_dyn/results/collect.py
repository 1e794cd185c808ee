"""Collecting: the sweep or the motion that a user gets, made from a solution."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..dynamics.inverse_dynamics import Solution
from ..dynamics.problem_solver import AssembledPositions, ProblemSolver
from ..dynamics.velocity_ratios import VelocityRatios
from ..frozen import frozen, read_only
from ..problem.acting import Acting
from ..problem.samples import Targets
from .motion import Motion, Rates
from .source import SolvedSource
from .sweep import Sweep


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
    problem, couplings, shape = solver.problem, solver.couplings, assembled.shape
    return Sweep(
        problem=problem,
        source=_source(solver, assembled, acting, solution),
        unique=solution.unique[problem.output_indices],
        coupling_moment=frozen(
            {
                name: solution.coupling_moments[:, index].reshape(shape)
                for index, name in couplings.items()
            }
        ),
        coupling_unique=frozen(
            {
                name: index not in solution.indeterminate_couplings
                for index, name in couplings.items()
            }
        ),
        condition=solution.condition.reshape(shape),
        # All residuals were judged; how great they are is for those who ask.
        proven=partial(
            solution.residuals.proven,
            solution.loop_error,
            solver.inverse_dynamics.bodies.unproven,
        ),
    )


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


def _source(
    solver: ProblemSolver, assembled: AssembledPositions, acting: Acting, solution: Solution
) -> SolvedSource:
    """Return the arrays of a solution as a sweep reads them."""
    problem, targets, shape = solver.problem, assembled.targets, assembled.shape

    def of_drives(values: Array) -> Array:
        """Return values `(..., d)` in the shape of the samples, without an axis for one drive."""
        if values.shape[-1] == 1:
            values, whole = values[..., 0], shape
        else:
            whole = (*shape, values.shape[-1])
        if values.shape != whole:
            alone = values.size == math.prod(whole)
            values = values.reshape(whole) if alone else np.broadcast_to(values, whole)
        return values

    efforts, drives = solution.efforts, len(problem.independent)
    drive_efforts = None
    if solver.knows_drive_efforts:
        drive_efforts = of_drives(efforts[:, :drives].reshape(*shape, drives))
    v, a, ratios = solution.v, solution.a, solution.velocity_ratios
    rates: Rates | Callable[[], Rates]
    if v is None or a is None or ratios is None:
        # What made the positions may be large; what rates need of it is not.
        of_rates = replace(assembled, blocks=())

        def rates() -> Rates:
            return solver.rates_at(of_rates, solution.x, acting)
    else:
        rates = v, a, ratios
    wrenches = solution.wrenches
    return SolvedSource(
        shape=shape,
        wrenches=wrenches.reshape(*shape, *wrenches.shape[1:]),
        drive_efforts=drive_efforts,
        holding_efforts=frozen(
            {
                name: efforts[:, column].reshape(shape)
                for name, column in solver.known_holding_efforts.items()
            }
        ),
        solved_motion=_motion(solver, assembled, solution.x, rates),
        position=of_drives(targets.given),
        speed=of_drives(acting.speeds),
        acceleration=of_drives(acting.accelerations),
        held=frozen({**problem.held, **targets.held}) if targets.held else problem.held,
        joint_loads=acting.joint_loads,
        link_loads=acting.link_loads,
        gravity=acting.gravity,
        inertia=acting.inertia,
        time=acting.time,
    )


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
