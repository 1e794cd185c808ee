"""Collecting: what a user gets of a solution."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..dynamics.problem_solver import AssembledPositions, ProblemSolver
from ..frozen import frozen, read_only
from .motion import Motion
from .source import SolvedSource
from .sweep import Sweep


def sweep_of(
    solver: ProblemSolver,
    assembled: AssembledPositions,
    speeds: Array,
    accelerations: Array,
) -> Sweep:
    """Solve assembled positions, and return what a user gets of them.

    Args:
        solver: of the scene.
        assembled: its positions.
        speeds: of the drives `(N, d)`.
        accelerations: of the drives `(N, d)`.

    Raises:
        ArgumentError: a load has another number of samples.
        AccuracyError: a residual misses its tolerance.
        IndeterminateError: a wanted component is not unique, and the problem is strict.
    """
    solution = solver.solve(assembled, speeds, accelerations)
    problem, outputs = solver.problem, solver.problem.output_indices
    unique = read_only(solution.unique[outputs])
    solver.refuse_indeterminate(unique)
    columns = problem.mechanism.coordinates.velocity_columns
    efforts = {
        name: solution.efforts[:, columns[name].start]
        for name in (*problem.drives, *problem.held)
        if solver.knows_effort(name)
    }
    drive_effort = None
    if all(name in efforts for name in problem.drives):
        drive_effort = read_only(_squeezed(np.stack([efforts[k] for k in problem.drives], axis=1)))
    couplings = solver.couplings
    residuals = solution.residuals
    return Sweep(
        problem=problem,
        source=SolvedSource(
            wrenches=read_only(solution.wrenches[:, outputs]),
            efforts=drive_effort,
            holding=frozen({name: efforts[name] for name in problem.held if name in efforts}),
            moved=_motion(
                solver,
                assembled.turns,
                solution.x,
                (solution.velocity_ratios, solution.v, solution.a),
            ),
            position=read_only(_squeezed(assembled.positions)),
            speed=read_only(_squeezed(speeds)),
            acceleration=read_only(_squeezed(accelerations)),
            joint_loads=problem.joint_loads,
            gravity=problem.gravity,
        ),
        unique=unique,
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
        balance_residual=residuals.balance,
        power_residual=residuals.power,
        rate_residual=residuals.rate,
        unproven=solver.inverse_dynamics.bodies.unproven,
    )


def motion_at(
    solver: ProblemSolver, positions: Array, speeds: Array, accelerations: Array
) -> Motion:
    """Return the motion alone at positions, speeds and accelerations `(N, d)` of the drives.

    As in a sweep, joints that no output needs are not solved, and have no numbers.

    Raises:
        AssemblyError: the loops cannot be closed at a position.
        SingularConfigurationError: a position is a dead point.
    """
    assembled = solver.assembled_in_turn(positions)
    parts = []
    for span, state in zip(assembled.spans, assembled.blocks, strict=True):
        rates = solver.inverse_dynamics.joint_rates(state, speeds[span], accelerations[span])
        parts.append((state.x, *rates))
    x, *joined = (np.concatenate(part) for part in zip(*parts, strict=True))
    return _motion(solver, assembled.turns, x, tuple(joined))


def _motion(solver: ProblemSolver, turns: Array, x: Array, rates: tuple[Array, ...]) -> Motion:
    """Return a motion, in which coordinates that were not solved are NaN.

    Otherwise starting guesses could be taken for results.

    Args:
        solver: what has solved it.
        turns: whole turns `(N, size)` that angles lack.
        x: coordinates `(N, size)`; nobody else's, as are the rates.
        rates: velocity ratios `(N, nv, d)`, velocities and accelerations `(N, nv)`.
    """
    problem = solver.problem
    coordinates = problem.mechanism.coordinates
    skipped = set(problem.passive_columns.tolist()) - set(solver.assembly.decided.tolist())
    for part in rates:
        part[:, list(skipped)] = np.nan
    for name, span in coordinates.velocity_columns.items():
        if skipped.intersection(range(span.start, span.stop)):
            x[:, coordinates.columns[name]] = np.nan
    ratios, v, a = rates
    return Motion(problem.mechanism, problem.drives, x, turns, v, a, ratios)


def _squeezed(values: Array) -> Array:
    """Return values `(N, d)` of one drive as `(N,)`."""
    return values[:, 0] if values.shape[1] == 1 else values
