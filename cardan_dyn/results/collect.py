"""Collecting: the sweep or the motion that a user gets, made from a solution."""

from __future__ import annotations

import numpy as np

from ..arrays import Array, squeezed
from ..dynamics.inverse_dynamics import Solution
from ..dynamics.problem_solver import AssembledPositions, ProblemSolver
from ..dynamics.velocity_ratios import VelocityRatios
from ..frozen import frozen, read_only
from .motion import Motion
from .source import SolvedSource
from .sweep import Sweep


def sweep_of(
    solver: ProblemSolver,
    assembled: AssembledPositions,
    speeds: Array,
    accelerations: Array,
    solution: Solution,
) -> Sweep:
    """Return a solution as a sweep.

    Args:
        solver: of the scene.
        assembled: its positions.
        speeds: of the drives `(N, d)`.
        accelerations: of the drives `(N, d)`.
        solution: what the solver found there.
    """
    problem, couplings = solver.problem, solver.couplings
    return Sweep(
        problem=problem,
        source=_source(solver, assembled, speeds, accelerations, solution),
        unique=read_only(solution.unique[problem.output_indices]),
        coupling_moment=frozen(
            {name: solution.coupling_moments[:, index] for index, name in couplings.items()}
        ),
        coupling_unique=frozen(
            {
                name: index not in solution.indeterminate_couplings
                for index, name in couplings.items()
            }
        ),
        condition=read_only(solution.condition),
        loop_residual=float(np.max(solution.loop_error)),
        balance_residual=solution.residuals.balance,
        power_residual=solution.residuals.power,
        rate_residual=solution.residuals.rate,
        unproven=solver.inverse_dynamics.bodies.unproven,
    )


def _source(
    solver: ProblemSolver,
    assembled: AssembledPositions,
    speeds: Array,
    accelerations: Array,
    solution: Solution,
) -> SolvedSource:
    """Return the arrays of a solution as a sweep reads them."""
    problem = solver.problem
    coordinates = problem.mechanism.coordinates.named
    efforts = {
        name: solution.efforts[:, coordinates[name].rate]
        for name in (*problem.drives, *problem.held)
        if solver.knows_effort(name)
    }
    drive_efforts = None
    if all(name in efforts for name in problem.drives):
        stacked = np.stack([efforts[name] for name in problem.drives], axis=1)
        drive_efforts = read_only(squeezed(stacked))
    rates = solution.velocity_ratios, solution.v, solution.a
    return SolvedSource(
        wrenches=read_only(solution.wrenches[:, problem.output_indices]),
        drive_efforts=drive_efforts,
        holding_efforts=frozen({name: efforts[name] for name in problem.held if name in efforts}),
        solved_motion=_motion(solver, assembled.turns, solution.x, rates),
        position=read_only(squeezed(assembled.positions)),
        speed=read_only(squeezed(speeds)),
        acceleration=read_only(squeezed(accelerations)),
        joint_loads=problem.joint_loads,
        gravity=problem.gravity,
    )


def motion_at(
    solver: ProblemSolver, positions: Array, speeds: Array, accelerations: Array
) -> Motion:
    """Return the motion alone at positions, speeds and accelerations `(N, d)` of the drives.

    As in a sweep, joints that no output needs are not solved, and are NaN.

    Raises:
        AssemblyError: the loops cannot be closed at a position.
        SingularConfigurationError: a position is a dead point.
    """
    assembled = solver.assembled_in_turn(positions)
    blocks, ratios = [], []
    for span, state in zip(assembled.spans, assembled.blocks, strict=True):
        rates = solver.inverse_dynamics.joint_rates(state, speeds[span], accelerations[span])
        ratios.append(VelocityRatios.of(rates.velocity_ratios, rates.depends))
        blocks.append((state.x, rates.v, rates.a))
    x, v, a = (np.concatenate(arrays) for arrays in zip(*blocks, strict=True))
    return _motion(solver, assembled.turns, x, (VelocityRatios.joined(ratios), v, a))


def _motion(
    solver: ProblemSolver, turns: Array, x: Array, rates: tuple[VelocityRatios, Array, Array]
) -> Motion:
    """Return a motion, in which coordinates that were not solved are NaN.

    Otherwise starting guesses could be taken for results.

    Args:
        solver: of the scene.
        turns: whole turns `(N, size)` that angles lack.
        x: coordinates `(N, size)`.
        rates: velocity ratios; velocities and accelerations `(N, nv)`.
    """
    problem = solver.problem
    coordinates = problem.mechanism.coordinates
    ratios, v, a = rates
    unsolved = set(problem.passive_columns.tolist()) - set(solver.assembly.decided.tolist())
    if unsolved:
        x_columns = [
            column
            for name, span in coordinates.velocity_columns.items()
            if unsolved.intersection(range(span.start, span.stop))
            for column in range(*coordinates.columns[name].indices(x.shape[1]))
        ]
        x = _with_nan(x, x_columns)
        v, a = (_with_nan(values, sorted(unsolved)) for values in (v, a))
        ratios = ratios.without(sorted(unsolved))
    return Motion(problem.mechanism, problem.drives, x, turns, v, a, ratios)


def _with_nan(values: Array, columns: list[int]) -> Array:
    """Return values in which some columns are not numbers."""
    values = values.copy()
    values[:, columns] = np.nan
    return values
