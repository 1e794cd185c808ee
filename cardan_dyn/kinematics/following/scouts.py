"""Scouts: closed configurations all over the motion, which follow from the start alone.

Decisions that hold for a whole scene, such as an order of elimination, are taken at them, so that
they do not depend on what was asked for first.
"""

from __future__ import annotations

import numpy as np

from ...arrays import Array, generic
from ..closing.all_groups import Kinematics
from ..tolerances import CLOSURE_TOLERANCE, REGULAR_CONDITION
from .lines import OnLines, samples_on_lines

_LINES = 5
"""Straight lines of the drives that are followed."""
_SHARES = np.linspace(0.0, 1.0, 17)[1:]
"""Parts of them at which there is a scout: near the start, and as far as lines lead."""
_WAY = np.pi
"""Greatest way of a drive [rad, or half of it lengths of the mechanism]: most of a turn, from one
side to the other."""


def scouts(kinematics: Kinematics, start: Array) -> Array:
    """Return closed configurations `(S, size)` that are not singular; the start is the first one.

    Lines that lead nowhere count as far as they go.

    Args:
        kinematics: of the drives and the groups that they move.
        start: `(size,)` closed coordinates.
    """
    columns = kinematics.coordinates.column_of(kinematics.drives).tolist()
    scale = kinematics.coordinates.scale[columns]
    slides = np.isin(columns, kinematics.coordinates.angle_columns, invert=True)
    way = np.where(slides, 0.1, _WAY) / scale
    ends = start[columns] + way * generic(_LINES, len(columns))
    line, share = np.repeat(np.arange(_LINES), len(_SHARES)), np.tile(_SHARES, _LINES)
    with np.errstate(all="ignore"):  # Lines that lead out of reach may overflow.
        found = samples_on_lines(kinematics, start[None, :], columns, ends, OnLines(line, share))
        closed = kinematics.close(found.x)
    serves = (closed.residual < CLOSURE_TOLERANCE) & (closed.condition < REGULAR_CONDITION)
    return np.concatenate([start[None, :], closed.x[serves]])
