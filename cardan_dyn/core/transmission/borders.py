"""Borders: where on a line of actuated positions a transmission becomes singular."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...kit.arrays import Array
from ...kit.errors import ArgumentError, as_position
from ...kit.roots import zeros
from .chart import Chart


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


def borders(chart: Chart, start: Array, end: Array, samples: int) -> list[tuple[int, float]]:
    """Return kinds and parts of the borders on a line, see `Transmission.borders`.

    Args:
        chart: whose given side the actuated are.
        start: `(n,)`.
        end: `(n,)`.
        samples: at which the line is looked at.
    """
    parts = np.linspace(0.0, 1.0, samples)
    nodes = start + parts[:, None] * (end - start)
    x, is_there = chart.led(chart.solver.assembly.start[None, :], nodes)
    if not np.any(is_there):
        raise ArgumentError(
            f"nothing of the line from {as_position(start)} to {as_position(end)} can be reached"
        )
    index, found = np.arange(samples), list[tuple[int, float]]()
    for step in (1, -1):
        order = index[::step]
        for at, to in pairwise(order):
            if is_there[at] and not is_there[to]:
                near, ends = chart.led(x[at][None, :], nodes[to][None, :])
                if ends[0]:
                    x[to], is_there[to] = near[0], True
                    continue
                turning = chart.turning(x[at][None, :], nodes[to][None, :], near)
                found.append((2, float(parts[at] + turning.part[0] * (parts[to] - parts[at]))))
    values = np.full(samples, np.nan)
    values[is_there] = np.linalg.det(chart.slopes(x[is_there]))
    found += [(1, float(part)) for part in parts[values == 0.0]]
    (passed,) = np.nonzero(values[:-1] * values[1:] < 0.0)
    if passed.size:
        places = chart.between(x[passed], x[passed + 1])

        def turned(part: Array, edges: Array) -> Array:
            return np.asarray(np.linalg.det(chart.slopes(places(part, edges))))

        span = np.zeros(len(passed)), np.ones(len(passed))
        part = zeros(turned, span, (values[passed], values[passed + 1]))
        found += [(1, float(at)) for at in parts[passed] + part * (parts[1] - parts[0])]
    return sorted(found, key=lambda item: item[1])
