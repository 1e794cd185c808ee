"""Needs: which groups have to be solved for the wanted outputs."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from typing import NamedTuple

import numpy as np
import pinocchio

from ....kit.arrays import Array
from ...mechanism.mechanism import Mechanism
from ...mechanism.tree import ancestors
from .groups import Group


class Needs(NamedTuple):
    """What the wanted outputs need.

    Attributes:
        motion: indices of the groups whose motion is solved, ascending.
        forces: indices of those whose closure forces are solved.
        known_bodies: bodies (0-based) on which every wrench is known.
        efforts_alone: whether no wrench is wanted, only the drive efforts.
    """

    motion: list[int]
    forces: set[int]
    known_bodies: set[int]
    efforts_alone: bool


def needs(
    mechanism: Mechanism,
    groups: list[Group],
    wanted: set[int] | None,
    moving_bodies: Collection[int] = (),
) -> Needs:
    """Return what the wrenches of some bodies' joints need.

    The closure forces of a group need those of every later group that loads one of its passive
    joints; its motion needs that of the groups which decide what moves its bodies, and of those
    that place its base.

    Args:
        mechanism: the mechanism.
        groups: from `partition`.
        wanted: bodies (0-based) whose joint wrenches are wanted; None for all, the empty set for
            the drive efforts alone.
        moving_bodies: bodies whose motion is wanted besides, since forces depend on it.
    """
    all_groups = set(range(len(groups)))
    bodies = set(range(mechanism.model.njoints - 1))
    if wanted is None:
        return Needs(sorted(all_groups), all_groups, bodies, False)
    if not wanted:
        return Needs(sorted(all_groups), set(), set(), True)
    body_of = _body_of_columns(mechanism.model)
    # The bodies of each group, its base, and all that the base hangs from.
    below = [{*group.bodies, *ancestors(mechanism.model, group.base + 1)} for group in groups]
    # For each body the groups whose bodies hang from it, or that it is in.
    carriers = {body: {index for index, own in enumerate(below) if body in own} for body in bodies}
    owner = {body: index for index, group in enumerate(groups) for body in group.inertial_bodies}
    decider = {
        body_of[column]: index
        for index, group in enumerate(groups)
        for column in group.passives.tolist()
    }

    def loading(index: int) -> set[int]:
        """Return the groups whose closure forces load the passive joints of a group."""
        passives = groups[index].passives.tolist()
        return {carrier for column in passives for carrier in carriers[body_of[column]]}

    def moving(index: int) -> set[int]:
        """Return the groups that decide joints which move the bodies of a group, or place them."""
        group = groups[index]
        movers = below[index] | {body_of[column] for column in group.known.tolist()}
        deciding = {decider[body] for body in movers if body in decider}
        return deciding | ({owner[group.base]} if group.base >= 0 else set())

    forces = reached((index for body in wanted for index in carriers[body]), loading)
    carried = {item for body in moving_bodies for item in ancestors(mechanism.model, body + 1)}
    placing = {decider[body] for body in carried if body in decider}
    motion = reached(forces | placing, moving)
    known_bodies = {body for body, indices in carriers.items() if indices and indices <= forces}
    return Needs(sorted(motion), forces, known_bodies, False)


def needs_of_finer(
    mechanism: Mechanism,
    finer: list[Group],
    groups: list[Group],
    needed: Needs,
    wanted: set[int] | None,
    moving_bodies: Collection[int] = (),
) -> Needs:
    """Return what wrenches need of finer groups: all loops whose closure forces are solved anyway.

    What is statically indeterminate is chosen over all joints that are solved, so it would change
    with fewer of them.

    Args:
        mechanism: the mechanism.
        finer: the groups into which some of `groups` were divided.
        groups: from `partition`, with the equations of open loops.
        needed: which of those are needed.
        wanted: see `needs`.
        moving_bodies: see `needs`.
    """
    if wanted:
        body_of = _body_of_columns(mechanism.model)
        decided = columns_of([groups[index] for index in needed.forces]).tolist()
        wanted = wanted | {body_of[column] for column in decided}
    return needs(mechanism, finer, wanted, moving_bodies)


def solved_couplings(groups: list[Group], needed: Needs) -> list[int]:
    """Return the indices of the couplings whose moments are solved, ascending."""
    return sorted(coupling for index in needed.forces for coupling in groups[index].couplings)


def columns_of(groups: list[Group]) -> Array:
    """Return the velocity coordinates that several groups decide, ascending."""
    passives = [group.passives for group in groups]
    return np.sort(np.concatenate([np.zeros(0, dtype=int), *passives]))


def _body_of_columns(model: pinocchio.Model) -> list[int]:
    """Return for each velocity coordinate the body (0-based) that it moves."""
    return [index - 1 for index in range(1, model.njoints) for _ in range(model.nvs[index])]


def reached(starts: Iterable[int], successors: Callable[[int], Iterable[int]]) -> set[int]:
    """Return the nodes of a graph that can be reached from some of them, these included."""
    found: set[int] = set()
    pending = list(starts)
    while pending:
        node = pending.pop()
        if node not in found:
            found.add(node)
            pending.extend(successors(node))
    return found
