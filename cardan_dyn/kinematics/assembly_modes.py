"""Assembly modes: the ways in which the loops can be closed with the drives where they start."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from ..arrays import Array
from ..mechanism.mechanism import Mechanism
from .all_groups import Kinematics
from .tolerances import CLOSURE_TOLERANCE, SINGULAR_CONDITION

_STARTS = 400
"""Random starts of the search. It finds modes, but does not prove that there are no others. The
bundled four-bar has two modes, which 100 starts find. With all legs of the bundled Stewart platform
driven, 100, 200, 400 and 800 starts find 52, 101, 200 and 357 modes. They have the same 8 poses of
the platform at each of these numbers. All else in which they differ are joints with intersecting
axes, such as universal joints, which have two positions for the same direction."""
_SEED = 1
"""The same starts at every call, so that a mode has the same name every time. Any seed would do:
for the seeds 1, 2 and 3, 400 starts find 200, 196 and 196 modes of the Stewart platform."""
_NEWTON_STEPS = 60
"""Greatest number of Newton steps per start. Starts lie anywhere within half a turn of the joints,
and the solver limits a step to half a radian, so many steps may pass before it converges."""
_DISTINCT = 1e-6
"""Distance in `Coordinates.shape` from which on two closed states are different modes. It is far
above the closure tolerance, up to which states of the same mode may differ."""
_LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"


def assembly_modes(
    kinematics: Kinematics,
    passives: Array,
    first: Array,
    length: float,
    idle: Collection[str] = (),
) -> list[Array]:
    """Return closed coordinates `(size,)` of every assembly mode that the search finds.

    Args:
        kinematics: with all rows that open loops can reach.
        passives: velocity coordinates that the loops decide.
        first: `(size,)` closed coordinates of the description's own mode.
        length: characteristic length [m]; slides start within it from where they are.
        idle: joints at the ends of idle rods, which may have any position in every mode.

    Returns:
        The description's own mode first, the others by their distance from it.
    """
    coordinates = kinematics.coordinates
    with np.errstate(all="ignore"):  # Starts that do not converge may overflow; they are not used.
        state = kinematics.close(_starts(kinematics, passives, first, length), most=_NEWTON_STEPS)
    is_closed = (state.residual < CLOSURE_TOLERANCE) & (state.condition < SINGULAR_CONDITION)
    x = state.x.copy()
    for name in idle:
        x[:, coordinates.columns[name]] = first[coordinates.columns[name]]
    difference = coordinates.shape(x) - coordinates.shape(first[None, :])
    order = np.argsort(np.linalg.norm(difference, axis=1), kind="stable")
    modes: list[Array] = []
    shapes: list[Array] = []
    for row in order[is_closed[order]]:
        shape = coordinates.shape(x[[row]])[0]
        if all(np.linalg.norm(shape - known) > _DISTINCT for known in shapes):
            shapes.append(shape)
            modes.append(state.x[row])
    return modes


def _starts(kinematics: Kinematics, passives: Array, first: Array, length: float) -> Array:
    """Return coordinates `(_STARTS, size)` to search from, the first of them unchanged."""
    generator = np.random.default_rng(_SEED)
    starts = np.repeat(first[None, :], _STARTS, axis=0)
    moves = kinematics.coordinates.moves(passives)
    step = generator.uniform(-np.pi, np.pi, (_STARTS, len(passives)))
    step[:, moves.slides] *= length / np.pi
    step[0] = 0.0
    moves.apply(starts, step)
    return starts


def mode_name(index: int) -> str:
    """Return the name of an assembly mode: A … Z for the indices 0 … 25, then A1 … Z1, A2 …."""
    cycle, letter = divmod(index, len(_LETTERS))
    return f"{_LETTERS[letter]}{cycle}" if cycle else _LETTERS[letter]


def positions_of(mechanism: Mechanism, drives: tuple[str, ...], state: Array) -> dict[str, float]:
    """Return the positions of all coordinates that turn or slide [m, or rad between -π and π].

    Args:
        mechanism: the mechanism.
        drives: coordinates that count whole turns.
        state: `(size,)` coordinates.
    """
    positions = {}
    for name, coordinate in mechanism.coordinates.named.items():
        value = float(state[coordinate.column])
        if name not in drives and not coordinate.slides:
            value -= 2.0 * np.pi * float(np.rint(value / (2.0 * np.pi)))
        positions[name] = value
    return positions
