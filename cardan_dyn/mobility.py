"""Mobility: whether the drives of a scene decide its motion, no more and no less."""

from __future__ import annotations

import numpy as np

from .closure import RANK_TOLERANCE
from .errors import MobilityError, choices
from .solver import Solver
from .twin import Array


def check_mobility(solver: Solver, states: Array, drives: tuple[str, ...], held: list[str]) -> None:
    """Compare a scene's drives with its mobility, over closed positions.

    Args:
        solver: with the reduction that holds over the motion.
        states: `(K, size)` closed coordinates. At single positions (dead points) the rank may be
            lower than elsewhere, so the greatest one counts.
        drives: names of the driven joints.
        held: names of the held joints.

    Raises:
        MobilityError: too many or too few drives, or drives that leave joints free.
    """
    closure = solver.closure
    mechanism = closure.mechanism
    here, _ = solver.evaluate(states)
    rows = closure.rows(here.twists, solver.reduction)
    passive = rows[:, solver.passive_columns]
    mobility = rows.shape[1] - int(np.max(_ranks(rows)))
    if int(np.max(_ranks(passive))) == passive.shape[1] and mobility == len(drives):
        return
    free = _free_joints(solver, passive)
    loops = f"its loops leave mobility {mobility}" if mechanism.loops else "it has no <loop>"
    if len(drives) > mobility:
        advice = "drop a drive or stop holding a joint"
    elif free:
        advice = f"nothing decides the motion of: {choices(free)}; drive or hold them"
    else:
        advice = f"choose the drives among: {choices(set(solver.coordinates.columns) - set(held))}"
    raise MobilityError(
        f"{mechanism.name}: {len(drives)} drive(s) {list(drives)}, but with {held} held {loops}: "
        f"{advice}",
        mobility=mobility,
        free=free,
    )


def _free_joints(solver: Solver, passive: Array) -> list[str]:
    """Return the joints that can move while the drives rest."""
    best = int(np.argmax(_ranks(passive)))
    vectors, values, _ = np.linalg.svd(passive[best])
    rank = int(np.sum(values > RANK_TOLERANCE * max(values[0], 1.0))) if values.size else 0
    moves = np.max(np.abs(vectors[:, rank:]), axis=1, initial=0.0) > 1e-6
    free = set(solver.passives[moves].tolist())
    return [
        name
        for name, columns in solver.coordinates.velocities.items()
        if free.intersection(range(columns.start, columns.stop))
    ]


def _ranks(rows: Array) -> Array:
    """Return the ranks `(K,)` of stacked closure matrices."""
    if 0 in rows.shape[1:]:
        return np.zeros(len(rows), dtype=int)
    values = np.linalg.svd(rows, compute_uv=False)
    return np.asarray(np.sum(values > RANK_TOLERANCE * np.max(values), axis=1))
