"""Assembled: a closed configuration of a mechanism before there is any scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..arrays import Array
from ..checks import mapping
from ..dynamics.problem_solver import ProblemSolver
from ..errors import ArgumentError, AssemblyError
from ..kinematics.first_assembly import assembled_near
from ..kinematics.group_solver import GroupSolver
from ..kinematics.loop_groups import independent_groups
from ..kinematics.structure import Structure
from ..kinematics.tolerances import CLOSURE_TOLERANCE
from ..mechanism.configuration import Configuration
from ..mechanism.mechanism import Mechanism
from ..problem.arguments import checked, held_positions, with_named_balls

_STEP = 0.1
"""Greatest part of a turn [rad], or of the characteristic length, by which the joints of `start`
move at once: so that the rest can follow without a jump to another assembly mode."""


def assembled(
    mechanism: Mechanism,
    *,
    start: Mapping[str, float] | None = None,
    drive: str | Sequence[str] | None = None,
    held: Mapping[str, float] | None = None,
    branch: str = "A",
) -> Configuration:
    """Return a closed configuration of a mechanism; see `Mechanism.assembled`."""
    if drive is not None:
        problem = checked(mechanism, drive=drive, held=held, start=start, branch=branch)
        return configuration_of(ProblemSolver(problem))
    if held is not None or branch != "A":
        raise ArgumentError("held and branch need a drive; without one, give start")
    mechanism = with_named_balls(mechanism, mapping("start", start))
    structure = Structure(mechanism)
    zero = mechanism.zero
    zero_residual = _residual(structure, zero)
    wanted = held_positions(mechanism, start, "start")
    given = zero.copy()
    for name, value in wanted.items():
        given[mechanism.coordinates.named[name].column] = value
    if wanted and _residual(structure, given) < CLOSURE_TOLERANCE:
        return Configuration(mechanism, given, _residual(structure, given), zero_residual)
    x = _closed(structure, zero, {})
    try:
        for share in _shares(mechanism, x, wanted):
            x = _closed(structure, x, wanted, share)
    except AssemblyError:
        # A singular configuration may lie on the way, and the start beyond it.
        x = _closed(structure, given, wanted)
    return Configuration(mechanism, x, _residual(structure, x), zero_residual)


def configuration_of(solver: ProblemSolver) -> Configuration:
    """Return the configuration in which a scene starts, of its solver.

    Raises:
        AssemblyError: loops that the scene leaves out cannot be closed.
    """
    problem, assembly = solver.problem, solver.assembly
    mechanism, x = problem.mechanism, assembly.start
    structure = Structure(mechanism)
    zero_residual = _residual(structure, mechanism.zero)
    left_out = np.setdiff1d(problem.passive_columns, assembly.decided)
    if left_out.size:
        x, _ = assembled_near(structure, x, left_out, left_out)
    residual = _residual(structure, x)
    if not residual < CLOSURE_TOLERANCE:
        raise _unclosed(mechanism, residual, {})
    return Configuration(mechanism, x, residual, zero_residual, problem.branch)


def _residual(structure: Structure, x: Array) -> float:
    """Return the closure error of all loops and couplings at coordinates `(size,)`."""
    mechanism, worst = structure.mechanism, 0.0
    for group in independent_groups(structure, np.arange(mechanism.model.nv)):
        _, _, residual = GroupSolver(mechanism, group).linearised(x[None, :])
        worst = max(worst, float(residual[0]))
    return worst


def _shares(mechanism: Mechanism, x: Array, wanted: Mapping[str, float]) -> list[float]:
    """Return which part of what is left of the way to wanted positions each step takes."""
    coordinates = mechanism.coordinates
    columns = coordinates.columns_of(wanted)
    ways = np.abs(np.array(list(wanted.values())) - x[columns]) * coordinates.scale[columns]
    count = max(int(np.ceil(np.max(ways, initial=0.0) / _STEP)), bool(wanted))
    return [1.0 / left for left in range(count, 0, -1)]


def _closed(
    structure: Structure, x: Array, wanted: Mapping[str, float], share: float = 1.0
) -> Array:
    """Return closed coordinates `(size,)` near others.

    Args:
        structure: of the mechanism.
        x: `(size,)` coordinates to start from.
        wanted: positions that some joints move towards, and at which they are kept.
        share: which part of the way from where they are they move.

    Raises:
        AssemblyError: the loops cannot be closed.
    """
    mechanism = structure.mechanism
    coordinates = mechanism.coordinates
    every = np.arange(mechanism.model.nv)
    moved = x.copy()
    pinned = []
    for name, value in wanted.items():
        column = coordinates.named[name].column
        # The last step ends at the very number that was given.
        moved[column] = value if share == 1.0 else x[column] + share * (value - x[column])
        pinned.append(coordinates.named[name].rate)
    closed, residual = assembled_near(structure, moved, np.setdiff1d(every, pinned), every)
    if not residual < CLOSURE_TOLERANCE:
        raise _unclosed(mechanism, residual, wanted)
    return closed


def _unclosed(mechanism: Mechanism, residual: float, wanted: Mapping[str, float]) -> AssemblyError:
    positions = ", ".join(f"{name}: {value:g}" for name, value in wanted.items())
    where = f" with the joints of start at their positions ({positions})" if wanted else ""
    advice = (
        "leave one of them out, or change it" if wanted else "check the origins of joints and loops"
    )
    return AssemblyError(
        f"{mechanism.name}: the loops cannot be closed{where}; the least closure error found is "
        f"{residual:.1e}, an angle [rad] or a gap in units of the characteristic length, "
        f"{mechanism.characteristic_length:.4g} m: {advice}",
        position=None,
        nearest=None,
        residual=residual,
    )
