"""Needs: which groups have to be solved for the wanted outputs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..mechanism.mechanism import Mechanism
from .loop_groups import Group


class Needs(NamedTuple):
    """What the wanted outputs need.

    Attributes:
        motion: numbers of the groups whose motion is solved.
        forces: numbers of those whose closure forces are solved.
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
) -> Needs:
    """Return what the wrenches of some bodies' joints need.

    The closure forces of a group need those of every later group that loads one of its passive
    joints; its motion needs that of the groups which decide what moves its bodies.

    Args:
        mechanism: the mechanism.
        groups: from `partition`.
        wanted: bodies (0-based) whose joint wrenches are wanted; None for all, the empty set for
            the drive efforts alone.
    """
    everything = set(range(len(groups)))
    bodies = set(range(mechanism.model.njoints - 1))
    if not wanted:
        forces = everything if wanted is None else set()
        complete = bodies if wanted is None else set()
        return Needs(sorted(everything), forces, complete, wanted is not None)
    carriers: dict[int, set[int]] = {body: set() for body in bodies}
    for number, group in enumerate(groups):
        for body in group.bodies:
            carriers[body].add(number)
    owner = {
        column: part.id - 1
        for part in mechanism.coordinates.parts
        for column in range(
            mechanism.model.idx_vs[part.id], mechanism.model.idx_vs[part.id] + part.nv
        )
    }
    decider = {
        owner[int(column)]: number
        for number, group in enumerate(groups)
        for column in group.passives
    }
    forces = set()
    open_groups = [number for body in wanted for number in carriers[body]]
    while open_groups:
        number = open_groups.pop()
        if number not in forces:
            forces.add(number)
            for column in groups[number].passives:
                open_groups.extend(carriers[owner[int(column)]])
    motion: set[int] = set()
    open_groups = list(forces)
    while open_groups:
        number = open_groups.pop()
        if number not in motion:
            motion.add(number)
            group = groups[number]
            movers = {*group.bodies, *(owner[int(column)] for column in group.known)}
            open_groups.extend(decider[body] for body in movers if body in decider)
    complete = {body for body, numbers in carriers.items() if numbers and numbers <= forces}
    return Needs(sorted(motion), forces, complete, False)


def solved_couplings(groups: list[Group], needed: Needs) -> list[int]:
    """Return the numbers of the couplings whose moments are solved, ascending."""
    return sorted(number for place in needed.forces for number in groups[place].couplings)


def columns_of(groups: list[Group]) -> np.ndarray:
    """Return the passives of several groups."""
    parts = [group.passives for group in groups]
    return np.sort(np.concatenate([np.zeros(0, dtype=int), *parts]))
