"""Chains: the parts of a mechanism that neither bodies nor loops nor couplings connect.

What one of them does changes the accelerations of no other: equations of each by itself grow with
the number of chains, those of all at once with its third power.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..mechanism.mechanism import Mechanism
from ..mechanism.welds import Loop
from .free_balls import WithBalls

_TOGETHER = 16
"""Velocity coordinates up to which chains are taken together: fewer cost as many calls."""


class Chain(NamedTuple):
    """Bodies that are connected with others by the world alone, or some such parts together.

    Attributes:
        bodies: their indices in `Mechanism.model`, ascending.
        columns: their columns in a row of coordinates.
        rates: their velocity coordinates.
        loops: welds between them, whose bodies are counted within the chain, 0 for the world.
        couplings: indices of the couplings between them.
    """

    bodies: list[int]
    columns: Array
    rates: Array
    loops: list[Loop]
    couplings: list[int]


def chains_of(mechanism: Mechanism | WithBalls) -> list[Chain]:
    """Return the chains of a mechanism, small ones together."""
    model = mechanism.model
    body_of = np.repeat(np.arange(model.njoints), list(model.nvs))
    ends = [[body, int(model.parents[body])] for body in range(1, model.njoints)]
    ends += [[loop.predecessor, loop.successor] for loop in mechanism.loops]
    coupled = [
        body_of[[*item.predecessor_columns, *item.successor_columns]].tolist()
        for item in mechanism.couplings
    ]
    bundles: list[list[int]] = []
    for bodies in _connected(model.njoints, [*ends, *coupled]):
        if bundles and _size(mechanism, [*bundles[-1], *bodies]) <= _TOGETHER:
            bundles[-1] += bodies
        else:
            bundles.append(bodies)
    return [
        _chain(
            mechanism,
            sorted(bodies),
            [index for index, own in enumerate(coupled) if set(own).issubset(bodies)],
        )
        for bodies in bundles
    ]


def _connected(count: int, connections: list[list[int]]) -> list[list[int]]:
    """Return which of the numbers from 1 on are connected, 0 connecting nothing."""
    first = list(range(count))

    def root(number: int) -> int:
        while first[number] != number:
            number = first[number]
        return number

    for numbers in connections:
        roots = sorted({root(number) for number in numbers if number})
        for other in roots[1:]:
            first[other] = roots[0]
    members: dict[int, list[int]] = {}
    for number in range(1, count):
        members.setdefault(root(number), []).append(number)
    return list(members.values())


def _size(mechanism: Mechanism | WithBalls, bodies: list[int]) -> int:
    return sum(int(mechanism.model.nvs[body]) for body in bodies)


def _chain(mechanism: Mechanism | WithBalls, bodies: list[int], couplings: list[int]) -> Chain:
    coordinates, own = mechanism.coordinates, {0: 0}
    own.update({body: index for index, body in enumerate(bodies, start=1)})
    columns: list[int] = []
    rates: list[int] = []
    for part, column in zip(coordinates.parts, coordinates.starts, strict=True):
        if part.id in own:
            columns += range(column, column + (4 if part.kind == "spherical" else 1))
            start = mechanism.model.idx_vs[part.id]
            rates += range(start, start + part.nv)
    loops = [
        loop._replace(predecessor=own[loop.predecessor], successor=own[loop.successor])
        for loop in mechanism.loops
        if loop.predecessor in own
        and loop.successor in own
        and (loop.predecessor or loop.successor)
    ]
    return Chain(bodies, np.array(columns, dtype=int), np.array(rates, dtype=int), loops, couplings)
