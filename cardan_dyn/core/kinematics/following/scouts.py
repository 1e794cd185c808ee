"""Scouts: closed configurations all over the motion, which follow from the start alone.

Decisions that hold for a whole scene, such as an order of elimination or which closure rows are
redundant, are taken at them, so that they do not depend on what was asked for first.
"""

from __future__ import annotations

import numpy as np

from ....kit.arrays import ROUNDED, Array, generic, some
from ...mechanism.kept import Kept
from ..closing.all_groups import Kinematics
from ..tolerances import CLOSURE_TOLERANCE, REGULAR_CONDITION
from .branch import Branch
from .lines import along_lines

_WAY = np.pi
"""Greatest way of a drive [rad, or half of it lengths of the mechanism]: most of a turn, from one
side to the other."""


def scouts(kinematics: Kinematics, start: Array, kept: Kept) -> Array:
    """Return closed configurations `(S, size)` that are not singular; the start is the first one.

    Of a single drive, they are nodes of its branch, of several on straight lines. What leads
    nowhere counts as far as it goes.

    Args:
        kinematics: of the drives and the groups that they move.
        start: `(size,)` closed coordinates.
        kept: of the mechanism.
    """
    columns = kinematics.coordinates.column_of(kinematics.drives).tolist()
    scale = kinematics.coordinates.scale[columns]
    slides = np.isin(columns, kinematics.coordinates.angle_columns, invert=True)
    way = np.where(slides, 0.1, _WAY) / scale
    # What follows a polynomial may turn a million times meanwhile.
    most = 2.0 * _WAY if kinematics.curving_columns.size else np.inf
    with np.errstate(all="ignore"):  # What leads out of reach may overflow.
        if len(columns) == 1:
            x = Branch.shared(kinematics, start, kept).states(float(way[0]), most)
            x = x[some(len(x), 80)]
        else:
            # Places near the start, and as far as five lines lead.
            shares = np.arange(1, 17)[:, None] / 16
            ways = shares * (way * generic(5, len(columns)))[:, None]
            ends = start[columns] + ways.reshape(-1, len(columns))
            x, _ = along_lines(kinematics, start[None, :], columns, ends, most)
        state = kinematics.close(np.concatenate([start[None, :], x]))
    # Where bars are in line but for rounded numbers, loops close with an error that grows toward
    # singular positions, and has equations next to these that are none elsewhere.
    closed = state.residual < ROUNDED
    if not closed[1:].any():
        closed = state.residual < CLOSURE_TOLERANCE
    most = min(REGULAR_CONDITION, REGULAR_CONDITION**0.5 * float(state.condition.min()))
    serves = (closed & (state.condition < most))[1:]
    return np.concatenate([start[None, :], state.x[1:][serves]])
