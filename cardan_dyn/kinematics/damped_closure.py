"""Damped closure: close loops from far away, where Newton's method leads nowhere.

The Levenberg–Marquardt method lowers the closure error with every step that it takes, wherever it
starts, and needs no full rank: where the equations are redundant or the position is singular, it
takes the shortest step. All drives, held joints and passives of the chosen loops may move.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from .group_solver import GroupSolver
from .stacked import times, transposed

_MOST_STEPS = 200
"""Greatest number of steps. From half a radian off some 10 suffice; in narrow curved valleys of the
error, as near singular configurations, steps become short."""
_CLOSED = 1e-13
"""Closure error at which a start is closed: some hundred times the rounding of its equations, which
are solved as normal equations and so come no nearer where they are badly conditioned."""
_FIRST_DAMPING = 1e-3
"""First damping relative to the greatest diagonal element of the normal equations: small, so that
starts from nearby take steps like Newton's, and it grows fourfold with every step refused."""
_GREATEST_DAMPING = 1e12
"""Damping at which a start is given up: its steps are mere rounding."""
_LONGEST = 1.0
"""Greatest step of a coordinate [rad, or lengths of the mechanism]. The equations are linearised
only over a fraction of a turn."""
_STATIONARY = 1e-12
"""Predicted relative fall of the squared error at which a start sits in a minimum of the error and
is given up."""
_LEAST_GAIN = 1e-3
"""Least ratio of the actual to the predicted fall of the squared error of a step that is taken."""


def closed_from(solver: GroupSolver, x: Array) -> tuple[Array, Array]:
    """Close the loops of a group from starts that may be far from closed.

    Args:
        solver: of the group; its passives move.
        x: `(N, size)` coordinates to start from; kept as they are.

    Returns:
        Coordinates `(N, size)` and closure errors `(N,)` that were reached; the caller judges them.
    """
    x = x.copy()
    matrices, error, residual = solver.linearised(x)
    squares = np.sum(error**2, axis=1)
    normal = matrices @ transposed(matrices)
    damping = _FIRST_DAMPING * np.max(np.diagonal(normal, axis1=1, axis2=2), axis=1, initial=1e-300)
    growth = np.full(len(x), 2.0)
    identity = np.eye(matrices.shape[1])
    for _ in range(_MOST_STEPS if matrices.shape[1] else 0):
        (active,) = np.nonzero((residual > _CLOSED) & (damping < _GREATEST_DAMPING))
        if not active.size:
            break
        rows = matrices[active]
        gradient = times(rows, error[active])
        shifted = rows @ transposed(rows) + damping[active, None, None] * identity
        step = -np.linalg.solve(shifted, gradient[:, :, None])[:, :, 0]
        longest = np.max(np.abs(step), axis=1)
        step *= np.minimum(1.0, _LONGEST / np.maximum(longest, _LONGEST))[:, None]
        linear = error[active] + times(transposed(rows), step)
        predicted = squares[active] - np.sum(linear**2, axis=1)
        tried = solver.moved(x[active], step)
        new_matrices, new_error, new_residual = solver.linearised(tried)
        new_squares = np.sum(new_error**2, axis=1)
        # Comparisons with numbers that are not finite are false, so these steps are not taken.
        gain = np.minimum((squares[active] - new_squares) / np.maximum(predicted, 1e-300), 1.0)
        taken = gain > _LEAST_GAIN
        better = active[taken]
        x[better], matrices[better], error[better] = (
            tried[taken],
            new_matrices[taken],
            new_error[taken],
        )
        residual[better], squares[better] = new_residual[taken], new_squares[taken]
        # Nielsen's rule: damping falls smoothly where the linear model holds, else grows faster
        # and faster.
        damping[better] *= np.maximum(1.0 / 3.0, 1.0 - (2.0 * gain[taken] - 1.0) ** 3)
        growth[better] = 2.0
        worse = active[~taken]
        damping[worse] *= growth[worse]
        growth[worse] *= 2.0
        damping[active[predicted <= _STATIONARY * squares[active]]] = np.inf
    return x, residual
