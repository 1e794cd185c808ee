"""Overclosed: accelerations of chains whose loops have redundant rows only while they are closed.

Bennett's linkage moves although its four hinges leave no freedom by count: three closure equations
follow from the others on closed positions, and nowhere else. Within a step of an integration states
are a little open, where all six equations are independent and leave the chain no motion: taken as
they are, accelerations jump with the size of the gap. Here the equations keep the rank that they
have where loops are closed, their weakest combinations left out, so that accelerations are smooth.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio

from ..arrays import Array
from .closed_directions import ClosedDirections

_OPEN = 1e-3
"""Displacement [rad, or a fraction of the length] by which loops are opened to see their rank."""
_MOVED = (0.02, 0.05)
"""Displacements after which they are closed again to see it."""


def overclosed_or_none(
    model: Any,
    constraints: Any,
    couplings: Array,
    prescribed: Array,
    state: Array,
    closed: Callable[[Array], Array],
    gaps: Callable[[Array], Array],
) -> ClosedDirections | None:
    """Return how a chain moves if closure equations are redundant only where its loops are closed.

    Args:
        model: see `ClosedDirections`.
        constraints: see `ClosedDirections`.
        couplings: see `ClosedDirections`.
        prescribed: see `ClosedDirections`.
        state: a closed configuration.
        closed: closes a configuration that is a little open.
        gaps: see `ClosedDirections`.
    """
    if not len(constraints):
        return None
    made_of = model, constraints, couplings, prescribed
    every = ClosedDirections(*made_of, rank=model.nv)
    free = np.delete(np.arange(model.nv), prescribed)
    ways = np.zeros((len(_MOVED) + 1, model.nv))
    ways[:, free] = np.random.default_rng(0).normal(size=(len(ways), free.size))

    def displaced(size: float, way: Array) -> Array:
        return np.asarray(pinocchio.integrate(model, state, size * way))

    opened = every.rank(displaced(_OPEN, ways[-1]))
    here = every.rank(state)
    if here == opened:
        return None
    # The state itself may be singular.
    moved = [closed(displaced(size, way)) for size, way in zip(_MOVED, ways, strict=False)]
    rank = max(here, *map(every.rank, moved))
    return None if rank == opened else ClosedDirections(*made_of, rank=rank, gaps=gaps)
