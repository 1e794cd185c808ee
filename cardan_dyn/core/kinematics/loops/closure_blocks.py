"""Closure blocks: groups as rows and columns of the equations of one sample."""

from __future__ import annotations

from collections.abc import Sequence

from ...mechanics.bodies import Tree
from ...mechanics.sample import Block
from ...mechanics.spins import spins_of
from ...mechanism.mechanism import Mechanism
from .groups import Group


def closure_blocks(groups: Sequence[tuple[Group, bool]]) -> tuple[Block, ...]:
    """Return the closure rows of groups: six of each loop in turn, then one of each coupling.

    Those of rods that spin idly come last.

    Args:
        groups: in the order of motion, each with whether its forces are wanted.
    """
    loops = [index for group, _ in groups for index in group.loops]
    couplings = [index for group, _ in groups for index in group.couplings]
    spin = 6 * len(loops) + len(couplings)
    result = []
    for group, is_balanced in groups:
        rows = [6 * loops.index(loop) + row for loop in group.loops for row in range(6)]
        rows += [6 * len(loops) + couplings.index(coupling) for coupling in group.couplings]
        rows += range(spin, spin + len(group.idle))
        spin += len(group.idle)
        result.append(Block(tuple(rows), tuple(group.passives.tolist()), is_balanced))
    return tuple(result)


def with_rods(tree: Tree, mechanism: Mechanism, groups: Sequence[Group]) -> Tree:
    """Return a tree with the rods of groups that spin idly, in the order of their rows."""
    rods = [(rod.body, rod.columns, rod.line, rod.frame) for group in groups for rod in group.idle]
    return tree._replace(spins=spins_of(tree, mechanism.zero, rods)) if rods else tree
