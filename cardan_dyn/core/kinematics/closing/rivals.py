"""Rivals: another assembly about as near to an open drawing as the one that was found.

Where a linkage is drawn nearly stretched and its loops do not close, two assemblies lie beside the
drawing, one crossed and one not, and its numbers do not tell which one is meant.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ....kit.arrays import Array
from ....kit.errors import choices
from ...mechanism.mechanism import Mechanism
from ..tolerances import CLOSURE_TOLERANCE, MOVES
from .far import closed_from, starts_about
from .group_solver import GroupSolver

_COMPARABLE = 1.5
"""Ratio of two distances from a drawing up to which it does not tell which of the two is meant."""


def nearest_of_rivals(
    mechanism: Mechanism, solvers: Iterable[GroupSolver], zero: Array, x: Array
) -> tuple[Array, str]:
    """Return the nearest of assemblies beside an open drawing, and what is to be said of another.

    Args:
        mechanism: the mechanism.
        solvers: of its loops; what is no passive of theirs stays.
        zero: `(size,)` coordinates of the drawing.
        x: `(size,)` closed coordinates that were found near it.

    Returns:
        Closed coordinates `(size,)`, and a sentence if another assembly is comparably near.
    """
    told = ""
    for solver in solvers:
        if not len(solver.group.passives) or solver.group.idle:
            continue  # Of a rod that may spin, every turn is another configuration.
        away = _away(mechanism, x[None, :], zero)[0]
        starts = starts_about(solver, x, (1.0 + _COMPARABLE) * away)
        found, residual = closed_from(solver, starts)
        found = found[residual < CLOSURE_TOLERANCE]
        found = found[_away(mechanism, found, x) > MOVES]
        if not len(found):
            continue
        distances = _away(mechanism, found, zero)
        first = int(np.argmin(distances))
        other, beyond = found[first], float(distances[first])
        if beyond < away:
            x, other, away, beyond = other, x, beyond, away
        if beyond <= _COMPARABLE * away:
            told = (
                f"{mechanism.name}: loops are open at the description's zero, and two assemblies "
                f"lie beside it: {_named(mechanism, solver, x)}, {away:.3g} rad or lengths of the "
                f"mechanism away, is taken; {_named(mechanism, solver, other)}, {beyond:.3g} away, "
                "is not; near= says which one is meant"
            )
    return x, told


def _away(mechanism: Mechanism, x: Array, other: Array) -> Array:
    """Return how far coordinates `(N, size)` are from others, those of loops' joints aside."""
    coordinates = mechanism.coordinates
    x = np.array(x)
    for loop in mechanism.loops:
        if loop.joint in coordinates.columns:
            own = coordinates.columns[loop.joint]
            x[:, own] = other[own]
    return np.asarray(np.linalg.norm(coordinates.apart(x, other), axis=1))


def _named(mechanism: Mechanism, solver: GroupSolver, x: Array) -> str:
    """Return where the joints of a group are, in words."""
    passives = set(solver.group.passives.tolist())
    named = mechanism.coordinates.named.items()
    places = [f"{name} {x[item.column]:.4g}" for name, item in named if item.rate in passives]
    return choices(places)
