"""Borders: where on a line of actuated positions a transmission becomes singular."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...kit.arrays import EPS, Array
from ...kit.errors import ArgumentError, as_position
from ...kit.roots import zeros
from ..problem.samples import targets_of
from .way import SolvedWay

_SECTIONS = 16
"""Parts into which an interval with an end of reach is divided at a time."""


class Border(NamedTuple):
    """A place on a line of actuated positions at which a transmission is singular.

    Attributes:
        kind: 1 where det J is zero, J = ∂joints/∂actuated: some motion of the actuated moves no
            joint, which can take any effort there; 2 where the actuated cannot go on, and joints
            can move while they rest: their efforts grow beyond bounds.
        position: `(n,)` of the actuated coordinates [rad or m]; a number of one.
        part: of the line, from 0 at its start to 1 at its end.

    Source: Gosselin and Angeles (1990).
    """

    kind: int
    position: float | Array
    part: float


def borders(way: SolvedWay, start: Array, end: Array, samples: int) -> list[Border]:
    """Return the borders on a line, see `Transmission.borders`.

    Args:
        way: from the actuated to the joints.
        start: `(n,)`.
        end: `(n,)`.
        samples: at which the line is looked at.
    """

    def placed(parts: Array) -> Array:
        return start + parts[:, None] * (end - start)

    def reached(parts: Array) -> Array:
        return way.solver.assembly.reachable(targets_of(way.problem, placed(parts), None))

    def turned(parts: Array) -> Array:
        return np.asarray(np.linalg.det(way.scaled(way.at(placed(parts))[1])))

    parts = np.linspace(0.0, 1.0, samples)
    is_there = reached(parts)
    if not np.any(is_there):
        raise ArgumentError(
            f"nothing of the line from {as_position(start)} to {as_position(end)} can be reached"
        )
    (changes,) = np.nonzero(is_there[1:] != is_there[:-1])
    inside, outside = (
        np.where(is_there[changes] == side, parts[changes], parts[changes + 1])
        for side in (True, False)
    )
    # What cannot be reached takes long to tell, however many places are asked for.
    while len(inside) and np.max(np.abs(outside - inside)) > np.sqrt(EPS):
        between = np.linspace(inside, outside, _SECTIONS + 1, axis=1)
        goes = reached(between.ravel()).reshape(between.shape)
        goes[:, 0], goes[:, -1] = True, False
        last, each = np.argmin(goes, axis=1), np.arange(len(inside))
        inside, outside = between[each, last - 1], between[each, last]
    found = [(2, float(part)) for part in inside]
    known = parts[is_there]
    values = turned(known)
    rows = [
        pair
        for pair in pairwise(zip(known, values, strict=True))
        if pair[0][1] * pair[1][1] < 0.0 and pair[1][0] - pair[0][0] < 1.5 / (samples - 1)
    ]
    if rows:
        table = np.array(rows)
        ends = table[:, 0, 0], table[:, 1, 0]
        found += [(1, float(x)) for x in zeros(turned, ends, (table[:, 0, 1], table[:, 1, 1]))]
    found += [(1, float(x)) for x in known[values == 0.0]]
    return [
        Border(kind, way.given.shown(placed(np.array([part])))[0], part)
        for kind, part in sorted(found, key=lambda item: item[1])
    ]
