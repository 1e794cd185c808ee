"""First assembly: a closed configuration of a mechanism near one that is not closed.

Descriptions often give positions of the joints in which the loops are not quite closed, or not at
all. No drive and no held joint is at its place yet: all joints that are not pinned may move.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..arrays import Array
from ..errors import AssemblyError
from ..mechanism.mechanism import Mechanism
from ..proof.closed_positions import refuse_left
from .damped_closure import closed_from
from .group_solver import GroupSolver
from .loop_groups import Group, independent_groups
from .structure import Structure
from .tolerances import CLOSURE_TOLERANCE

_NEAR = 1e-11
"""Closure error that counts as closed here. Newton's method removes the rest."""
_AMPLITUDES = (0.02, 0.1, 0.3, 1.0, np.pi)
"""Greatest displacements [rad, or lengths of the mechanism] of further starts: small ones leave a
singular position, from which no step leads away, and keep the assembly mode; large ones find a
closed configuration wherever it is."""
_STARTS = 12
"""Starts per amplitude. They are solved together, and the search ends with the first amplitude that
leads to closed loops."""
_SEED = 7
"""The same starts in every call, so that a scene starts in the same configuration every time."""


def assembled_near(
    structure: Structure, x: Array, free: Array, needed: Array
) -> tuple[Array, float]:
    """Return a closed configuration near one that may be far from closed.

    Args:
        structure: of the mechanism.
        x: `(size,)` coordinates to start from.
        free: velocity coordinates that may move.
        needed: velocity coordinates whose loops are closed; others stay as they are.

    Returns:
        Coordinates `(size,)` and their closure error. The error is the least that was found where
        loops could not be closed.
    """
    mechanism, worst = structure.mechanism, 0.0
    groups = [
        group
        for group in independent_groups(structure, free)
        # Of a loop all of whose joints are pinned, no coordinate is free; it has to be closed too.
        if _columns_on(structure, group).intersection(needed.tolist())
    ]
    moving = {column for group in groups for column in group.passives.tolist()}
    # What the joint of a loop can make up for, no other joint has to.
    x = mechanism.fitted(x, set(range(mechanism.model.nv)) - moving)
    for group in groups:
        before = x
        x, residual = _closed_group(GroupSolver(mechanism, group), before)
        if residual < CLOSURE_TOLERANCE:
            refuse_left(mechanism, group.loops, group.couplings, before, x)
        worst = max(worst, residual)
    return x, worst


def _columns_on(structure: Structure, group: Group) -> set[int]:
    """Return the velocity coordinates on the loops and in the couplings of a group."""
    items = (*group.loops, *(len(structure.mechanism.loops) + index for index in group.couplings))
    return {column for item in items for column in structure.coordinates_on(item)}


def _closed_group(solver: GroupSolver, x: Array) -> tuple[Array, float]:
    """Return coordinates in which the loops of a group are closed, and the closure error."""
    best, residual = closed_from(solver, x[None, :])
    if residual[0] < _NEAR:
        return best[0], float(residual[0])
    coordinates = solver.coordinates
    generator = np.random.default_rng(_SEED)
    least, least_residual = best[0], float(residual[0])
    for amplitude in _AMPLITUDES:
        step = generator.uniform(-amplitude, amplitude, (_STARTS, len(solver.group.passives)))
        starts = solver.moved(np.repeat(x[None, :], _STARTS, axis=0), step)
        reached, residual = closed_from(solver, starts)
        closed = residual < _NEAR
        if np.any(closed):
            reached, residual = reached[closed], residual[closed]
            shapes = coordinates.shape(reached) - coordinates.shape(x[None, :])
            nearest = int(np.argmin(np.linalg.norm(shapes, axis=1)))
            return reached[nearest], float(residual[nearest])
        if np.min(residual) < least_residual:
            index = int(np.argmin(residual))
            least, least_residual = reached[index], float(residual[index])
    return least, least_residual


def unclosed(
    mechanism: Mechanism, residual: float, positions: Mapping[str, float] | None = None
) -> AssemblyError:
    """Return the error for loops that cannot be closed.

    Args:
        mechanism: the mechanism.
        residual: the least closure error that was found.
        positions: joints that were kept at their positions [rad or m], if any.
    """
    listed = ", ".join(f"{name}: {value:g}" for name, value in (positions or {}).items())
    where = f" with the joints of start at their positions ({listed})" if positions else ""
    advice = "check the origins of joints and loops"
    if positions:
        advice = "leave one of them out, or change it"
    return AssemblyError(
        f"{mechanism.name}: the loops cannot be closed{where}; the least closure error found "
        f"around the description's zero is {residual:.1e}, an angle [rad] or a gap in units of the "
        f"characteristic length, {mechanism.characteristic_length:.4g} m: {advice}",
        residual=residual,
    )
