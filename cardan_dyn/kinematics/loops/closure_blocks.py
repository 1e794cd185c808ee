"""Closure blocks: groups as rows and columns of the equations of one sample."""

from __future__ import annotations

from collections.abc import Sequence

from ...mechanics.sample import Block
from .groups import Group


def closure_blocks(groups: Sequence[tuple[Group, bool]]) -> tuple[Block, ...]:
    """Return the closure rows of groups: six of each loop in turn, then one of each coupling.

    Args:
        groups: in the order of motion, each with whether its forces are wanted.
    """
    loops = [index for group, _ in groups for index in group.loops]
    couplings = [index for group, _ in groups for index in group.couplings]
    result = []
    for group, is_balanced in groups:
        rows = [6 * loops.index(loop) + row for loop in group.loops for row in range(6)]
        rows += [6 * len(loops) + couplings.index(coupling) for coupling in group.couplings]
        result.append(Block(tuple(rows), tuple(group.passives.tolist()), is_balanced))
    return tuple(result)
