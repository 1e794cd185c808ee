"""Collecting: the sweep or the motion that a user gets, made from a solution."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ...kit.arrays import Array
from ...kit.frozen import FrozenDict, frozen, read_only
from ..dynamics.inverse_dynamics import Solution
from ..dynamics.problem_solver import AssembledPositions, InTurn, ProblemSolver
from ..dynamics.velocity_ratios import VelocityRatios
from ..problem.acting import Acting
from ..problem.samples import Targets
from ..proof.residuals import Proven
from .motion import Motion, Rates
from .source import SolvedSource
from .sweep import Sweep

_NOTHING: FrozenDict[str, Any] = frozen({})


def sweep_of(solver: ProblemSolver, assembled: AssembledPositions, acting: Acting) -> Sweep:
    """Return what a solver finds at positions, as a sweep.

    Args:
        solver: of the scene.
        assembled: the positions.
        acting: how fast the drives move and what acts, as it was given.

    Raises:
        CardanError: as `ProblemSolver.solve`.
    """
    solution = solver.solve(assembled, acting)
    problem, targets = solver.problem, assembled.targets
    if type(assembled.blocks) is not InTurn or len(assembled.spans) > 1:
        # What made the positions may be large; what is asked of them later is not.
        assembled = replace(assembled, blocks=())
    moments, loose = solution.coupling_moments, solution.indeterminate_couplings
    named = solver.couplings.items()
    return Sweep(
        problem=problem,
        held=targets.held,
        acting=acting,
        source=SolvedSource(
            targets.shape,
            targets.given,
            read_only(solution.wrenches),
            read_only(solution.efforts),
            solver.knows_drive_efforts,
            solver.known_holding_efforts,
            partial(_solved_motion, solver, assembled, acting, solution),
        ),
        unique=solution.unique[problem.output_indices],
        coupling_moment=frozen({name: moments[:, k].reshape(targets.shape) for k, name in named})
        if named
        else _NOTHING,
        coupling_unique=frozen({name: k not in loose for k, name in named}) if named else _NOTHING,
        condition=partial(_condition, solver, assembled, solution),
        # All residuals were judged; how great they are is for those who ask.
        proven=partial(
            solution.residuals.proven,
            solution.loop_error,
            solver.inverse_dynamics.bodies.unproven,
        ),
        solver=solver,
    )


def _condition(solver: ProblemSolver, assembled: AssembledPositions, solution: Solution) -> Array:
    magnification = solver.magnification_at(assembled, solution.x)
    cancellation = solution.cancellation
    if cancellation is None:
        cancellation = solution.residuals.cancellation
    return (magnification * cancellation).reshape(assembled.shape)


def _solved_motion(
    solver: ProblemSolver, assembled: AssembledPositions, acting: Acting, solution: Solution
) -> Motion:
    v, a, ratios = solution.v, solution.a, solution.velocity_ratios
    rates: Rates | Callable[[], Rates]
    if v is None or a is None or ratios is None:
        rates = partial(solver.rates_at, assembled, solution.x, acting)
    else:
        rates = v, a, ratios
    return _motion(solver, assembled, solution.x, rates)


def scattered(
    solver: ProblemSolver,
    parts: Sequence[tuple[Array, Sweep]],
    motion: Motion,
    positions: Array,
    acting: Acting,
) -> Sweep:
    """Return a sweep at samples of which parts were solved: NaN at the others.

    Args:
        solver: of the scene.
        parts: indices of samples, and a sweep at these: of the scene, or of the same motion by
            other free coordinates, with all joints as outputs.
        motion: at all N samples.
        positions: of the drives `(N, d)`.
        acting: likewise.
    """
    problem, sweeps = solver.problem, [sweep for _, sweep in parts]
    known = np.concatenate([indices for indices, _ in parts])

    def spread(found: Callable[[Sweep], Array], other: float = np.nan) -> Array:
        values = np.concatenate([found(sweep) for sweep in sweeps])
        every = np.full((len(motion), *values.shape[1:]), other)
        every[known] = values
        return read_only(every)

    def of_outputs(sweep: Sweep) -> list[int]:
        return [sweep.outputs.index(name) for name in problem.outputs]

    def wrenches(sweep: Sweep) -> Array:
        return np.asarray(_solved_source(sweep).wrenches[:, of_outputs(sweep)])

    def efforts(sweep: Sweep) -> Array:
        values = _solved_source(sweep).efforts.copy()
        pairs = enumerate(zip(sweep.coordinates, problem.independent, strict=True))
        values[:, [column for column, (one, own) in pairs if one != own]] = 0.0
        return values

    unknown = np.isin(np.arange(len(motion)), known, invert=True)
    named = solver.couplings.values()
    return Sweep(
        problem=problem,
        held=sweeps[0]._held,
        acting=acting._replace(
            accelerations=np.where(unknown[:, None], np.nan, acting.accelerations)
        ),
        source=SolvedSource(
            motion.shape,
            positions,
            spread(wrenches),
            spread(efforts),
            solver.knows_drive_efforts,
            solver.known_holding_efforts,
            motion,
        ),
        unique=np.all([sweep.unique[of_outputs(sweep)] for sweep in sweeps], axis=0),
        coupling_moment=frozen({name: spread(partial(_moment, name)) for name in named}),
        coupling_unique=frozen(
            {name: all(sweep.coupling_unique[name] for sweep in sweeps) for name in named}
        ),
        condition=spread(lambda sweep: sweep.condition, np.inf),
        proven=Proven.worst([sweep.proven for sweep in sweeps]),
    )


def _moment(coupling: str, sweep: Sweep) -> Array:
    return sweep.coupling_moment[coupling]


def _solved_source(sweep: Sweep) -> SolvedSource:
    assert isinstance(sweep._source, SolvedSource)
    return sweep._source


def motion_at(
    solver: ProblemSolver,
    targets: Targets,
    speed: Array | float = 0.0,
    acceleration: Array | float = 0.0,
) -> Motion:
    """Return the motion alone.

    As in a sweep, joints that no output needs are not solved, and are NaN.

    Args:
        solver: of the scene.
        targets: N of them.
        speed: of the drives `(N, d)`, or one of all [rad/s or m/s].
        acceleration: likewise.

    Raises:
        AssemblyError: the loops cannot be closed at a position.
        SingularConfigurationError: a position is a dead point.
    """
    assembled = solver.assembled_in_turn(targets)
    from ..dynamics.collected import Rows  # Sweeps of one block do without.

    rows, drives = Rows(targets.size), (targets.size, len(solver.problem.independent))
    speeds, accelerations = (np.broadcast_to(given, drives) for given in (speed, acceleration))
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
