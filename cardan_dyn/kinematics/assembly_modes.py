"""Assembly modes: the ways in which the loops can be closed with the drives where they start."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from .all_groups import Kinematics
from .tolerances import CLOSURE_TOLERANCE, SINGULAR_CONDITION

_STARTS = 400
"""Random starts of the search. The Stewart platform's 40 modes need some 300 to show up all."""
_SEED = 1
"""The same starts at every call, so that the names of modes stay what they are."""
_NEWTON_STEPS = 60
"""Starts lie anywhere, and steps are limited to half a radian."""
_DISTINCT = 1e-6
"""Distance of `Coordinates.shape` from which two modes are different ones."""


def assembly_modes(
    kinematics: Kinematics, passives: Array, first: Array, length: float
) -> list[Array]:
    """Return closed coordinates `(size,)` of every assembly mode that was found.

    Args:
        kinematics: with all rows that open loops can reach.
        passives: velocity coordinates that the loops decide.
        first: `(size,)` closed coordinates of the description's own mode.
        length: characteristic length [m]: how far slides start from where they are.

    Returns:
        The description's own mode first, the others by their distance from it.
    """
    coordinates = kinematics.coordinates
    generator = np.random.default_rng(_SEED)
    starts = np.repeat(first[None, :], _STARTS, axis=0)
    moves = coordinates.moves(passives)
    step = generator.uniform(-np.pi, np.pi, (_STARTS, len(passives)))
    step[:, moves.slides] *= length / np.pi
    step[0] = 0.0
    moves.apply(starts, step)
    with np.errstate(all="ignore"):  # Starts that lead nowhere are not used.
        state = kinematics.close(starts, most=_NEWTON_STEPS)
    closed = (state.residual < CLOSURE_TOLERANCE) & (state.condition < SINGULAR_CONDITION)
    own = coordinates.shape(first[None, :])
    order = np.argsort(np.linalg.norm(coordinates.shape(state.x) - own, axis=1), kind="stable")
    modes: list[Array] = []
    shapes: list[Array] = []
    for row in order[closed[order]]:
        shape = coordinates.shape(state.x[[row]])[0]
        if all(np.linalg.norm(shape - other) > _DISTINCT for other in shapes):
            shapes.append(shape)
            modes.append(state.x[row])
    return modes


def mode_name(index: int) -> str:
    """Return the name of an assembly mode: A … Z, A1 … Z1, …."""
    letter = chr(ord("A") + index % 26)
    return letter if index < 26 else f"{letter}{index // 26}"
