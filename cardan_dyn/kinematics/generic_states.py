"""Generic states: closed configurations around one, in which ranks are those of the motion.

At single configurations, dead points and change points, fewer closure equations are independent
than anywhere else. A few others nearby show how many there are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array, generic
from .damped_closure import closed_from
from .first_assembly import assembled_near, unclosed
from .group_solver import GroupSolver
from .group_state import GroupState
from .loop_groups import independent_groups
from .stacked import ranks
from .structure import Structure
from .tolerances import CLOSURE_TOLERANCE

_STATES = 6
"""Configurations in which ranks are measured: one alone may be singular."""
_AROUND = 0.05
"""How far from the first one the others start [rad, or lengths of the mechanism]: far enough to
leave a singular configuration, and near enough to be closed in the same assembly mode."""


class GenericStates(NamedTuple):
    """Closed configurations of loops and couplings that have no joint in common with others.

    Attributes:
        x: `(K, size)` closed configurations in which as many equations as possible are independent;
            the one that they lie around is the first, if it is one of them.
        group: their closure equations there, all of them.
        rank: how many are independent there.
        rank_at_start: how many are independent at the coordinates that were given, or where the
            loops are assembled near them.
    """

    x: Array
    group: GroupState
    rank: int
    rank_at_start: int


def generic_states(
    structure: Structure, most_coordinates: int, x: Array
) -> list[GenericStates | GroupSolver]:
    """Return generic states of all independent sets of loops and couplings.

    Args:
        structure: of the mechanism.
        most_coordinates: of a set; of a larger one only its solver is returned.
        x: `(size,)` coordinates near which the loops are closed.

    Raises:
        AssemblyError: loops cannot be closed.
    """
    mechanism = structure.mechanism
    every = np.arange(mechanism.model.nv)
    result: list[GenericStates | GroupSolver] = []
    for group in independent_groups(structure, every):
        solver = GroupSolver(mechanism, group)
        if group.passives.size > most_coordinates:
            result.append(solver)
            continue
        first, residual = assembled_near(structure, x, every, group.passives)
        if not residual < CLOSURE_TOLERANCE:
            _, worst = assembled_near(structure, x, every, every)
            raise unclosed(mechanism, worst)
        result.append(states_around(solver, first))
    return result


def states_around(solver: GroupSolver, first: Array) -> GenericStates:
    """Return generic states around closed coordinates `(size,)`; only the passives move."""
    step = _AROUND * generic(_STATES, len(solver.group.passives))
    step[0] = 0.0
    starts = solver.moved(np.repeat(first[None, :], _STATES, axis=0), step)
    reached, residual = closed_from(solver, starts)
    is_closed = residual < CLOSURE_TOLERANCE
    # The first one was closed by the caller, if only to the rounding of its badly conditioned rows.
    is_closed[0] = True
    reached = reached[is_closed]
    full = solver.equations.full()
    state, _ = solver.evaluate(reached, full)
    rank = ranks(state.scaled_rows)
    greatest = int(np.max(rank))
    reached = reached[rank == greatest]
    regular, _ = solver.evaluate(reached, full)
    return GenericStates(reached, regular, greatest, int(rank[0]))
