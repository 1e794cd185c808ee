"""Imbalance: why the drives of a scene do not decide its motion, and what would mend it.

What is judged are generic configurations, in which as many closure equations as possible are
independent: a scene that starts in a dead point does not lack a drive, and one that starts where a
locked mechanism can be shaken is locked.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ....kit.arrays import Array
from ....kit.errors import (
    CardanError,
    MobilityError,
    SingularConfigurationError,
    as_position,
    as_text,
    choices,
)
from ...mechanism.carried import CarriedFrame
from ...mechanism.mechanism import Mechanism
from ...mechanism.tree import ancestors
from ...problem.problem import Problem
from ..closing.all_groups import Kinematics
from ..closing.far import states_around
from ..closing.group_solver import solver_of
from ..loops.groups import independent_groups
from ..loops.idle_rods import idle_rods
from ..loops.structure import Structure
from ..tolerances import MOVES
from .singularities import gimbal_note, singularity_at

_MOST = 3
"""Motions, or sets of links that move alike, that a message describes; others are counted."""


def imbalance(
    problem: Problem, x: Array, passives: set[int], kinematics: Kinematics
) -> CardanError:
    """Return the error that says why a scene's drives do not decide its motion.

    Args:
        problem: the drives and held joints of the scene.
        x: `(size,)` closed coordinates.
        passives: velocity coordinates that something must decide.
        kinematics: of the scene.
    """
    return _Imbalance(problem, x, passives).error(kinematics)


class _Imbalance:
    """A scene whose drives do not decide its motion."""

    def __init__(self, problem: Problem, x: Array, passives: set[int]) -> None:
        self._mechanism = mechanism = problem.mechanism
        self._drives, self._held, self._passives = problem.independent, [*problem.held], passives
        spans = mechanism.coordinates.velocity_columns
        self._column_of = {
            name: spans[item.joint].start + item.offset for name, item in mechanism.drivable.items()
        }
        self._driven = [self._column_of[name] for name in self._drives]
        self._around = Surroundings(
            Structure(mechanism),
            x,
            {self._column_of[name] for name in self._held},
            passives | set(self._driven),
        )

    def error(self, kinematics: Kinematics) -> CardanError:
        """Return the error, see `imbalance`."""
        mechanism, drives, driven = self._mechanism, self._drives, self._driven
        found = self._around.freedoms(driven)
        best = max(found, key=lambda item: item.rank_of(driven))
        excess = len(drives) - best.rank_of(driven)
        if _decides(best, driven):
            (here,) = self._around.freedoms(driven, here=True)
            if not _decides(here, driven):
                return self._dead_point(kinematics, best.x)
            # Then spins of rods are left over that the rule for idle rods does not decide.
            best = self._around.freedoms(driven, with_spins=True)[0]
        surplus = self._surplus() if excess else []
        left = best.while_resting(driven)
        free, advised = self._names(left.moving(self._passives)), self._advised(best)
        reasons = []
        coupled = self._coupled() if excess else ""
        if coupled:
            reasons.append(coupled)
        elif best.number == 0:
            reasons.append(self._locked(surplus))
        elif excess:
            still = self._names([column for column in driven if not best.moving([column])])
            reasons.append(_too_many(still, surplus, drives, excess))
            surplus = surplus or still
        advice = ""
        if excess and not coupled and mechanism.description.remedy:
            reasons.append(mechanism.description.remedy)
        if left.number:
            advice = self._advice(left, advised)
            told = self._left(best, left, free, advised)
            reasons.append(f"{told}; drive or hold {advice}")
        if not reasons:
            reasons.append(
                f"{choices(drives)} would decide the motion, but this position is so close to a "
                "singular configuration, where assembly modes meet, that rounding decides which "
                "way they lead; give near={joint: position} to begin farther from it"
            )
        loops = f"its loops leave mobility {best.number}" if mechanism.loops else "it has no loop"
        held = f" with {choices(self._held)} held" if self._held else ""
        return MobilityError(
            f"{mechanism.name}: driven by {choices(drives)}{held}, {loops}: {'; '.join(reasons)}",
            mobility=best.number,
            free=free,
            advised=advised,
            advice=advice,
            surplus=surplus,
        )

    def _names(self, columns: Iterable[int]) -> list[str]:
        return self._mechanism.coordinates.names_of(set(columns))

    def _drivable(self, columns: Iterable[int]) -> list[str]:
        """Return the names by which velocity coordinates can be driven or held."""
        name_of = {column: name for name, column in self._column_of.items()}
        return [name_of[column] for column in columns]

    def _candidates(self) -> list[int]:
        """Return the coordinates that could be driven, those that the author drives first.

        Those of joints with several come last; near zero, the rates of a ball's three angles are
        the components of its rotation.
        """
        mechanism, drivable = self._mechanism, self._mechanism.drivable
        bodies = {name: mechanism.joints[item.joint].id for name, item in drivable.items()}
        closing = {mechanism.joints[loop.joint].id for loop in mechanism.loops}
        # Motors mostly sit near the ground, and so do the joints that a scene holds.
        ordered = sorted(
            drivable,
            key=lambda name: (
                name != drivable[name].joint,
                name not in mechanism.independent_coordinates,
                bodies[name] in closing,
                len(ancestors(mechanism.model, bodies[name])),
            ),
        )
        taken = {*self._drives, *self._held}
        return [self._column_of[name] for name in ordered if name not in taken]

    def _advised(self, best: Freedoms) -> list[str]:
        """Return what decides the motion once it is driven or held as well."""
        candidates, known = self._candidates(), [*self._driven]
        while more := best.chosen(candidates, known):
            known += more
            # A rod whose joint is driven is no longer idle, and what turns with it may be free.
            best = self._around.freedoms(known)[0]
        return self._drivable(known[len(self._driven) :])

    def _dead_point(self, kinematics: Kinematics, elsewhere: Array) -> SingularConfigurationError:
        """Return the error for a start that is singular, with the joints that are concerned."""
        coordinates, x = self._mechanism.coordinates, self._around.x
        position = x[coordinates.columns_of(self._drives)]
        singularity = singularity_at(kinematics, x, elsewhere)
        note = gimbal_note(coordinates, x, kinematics.passives.tolist())
        return SingularConfigurationError(
            f"{self._mechanism.name}: position {as_text(position)} of {choices(self._drives)}, "
            f"where the scene starts, is singular: {singularity.text}. Give near={{joint: "
            f"position}} to begin elsewhere, or choose another drive{note}",
            position=as_position(position),
            condition=float(kinematics.evaluate(x[None, :]).condition[0]),
            **singularity.details,
        )

    def _coupled(self) -> str:
        """Return which couplings connect prescribed joints, and what to do; empty without any.

        Couplings of one joint with another are followed from joint to joint, like a train of
        wheels.
        """
        prescribed = [*self._driven, *(self._column_of[name] for name in self._held)]
        edges = {
            item.name: {*item.predecessor_columns, *item.successor_columns}
            for item in self._mechanism.couplings
            if len(item.predecessor_columns) == len(item.successor_columns) == 1
        }
        for first in prescribed:
            reached, used = {first}, set[str]()
            for _ in edges:
                used |= {name for name, ends in edges.items() if not ends.isdisjoint(reached)}
                reached = reached.union(*(edges[name] for name in used))
            both = reached.intersection(prescribed)
            if len(both) > 1:
                return (
                    f"{choices(used)} couple{'s' * (len(used) == 1)} "
                    f"{choices(self._drivable(both))}: drive or hold only one of them"
                )
        return ""

    def _surplus(self) -> list[str]:
        """Return held joints and drives that are one too many: without any of them it moves."""
        result = []
        for name in (*self._held, *(self._drives if len(self._drives) > 1 else ())):
            released = self._column_of[name]
            driven = [column for column in self._driven if column != released]
            found = self._around.freedoms(driven, released)
            if any(_decides(item, driven) for item in found):
                result.append(name)
        return result

    def _locked(self, surplus: list[str]) -> str:
        """Return what to do about a locked mechanism, some joints of which may be held."""
        advice = "check loops and couplings, and axes, which are x if left out"
        if surplus:
            advice = f"stop holding {_one_of(surplus)}"
        elif self._held:
            advice = f"stop holding more than one joint, or {advice}"
        return f"it is locked: {advice}"

    def _left(self, best: Freedoms, left: Freedoms, free: list[str], advised: list[str]) -> str:
        """Return which motions are left."""
        columns = [self._column_of[name] for name in advised]
        # Where there are several, what the most links do says enough of each.
        most = _MOST if left.number == 1 else 1
        texts = []
        for column in columns[:_MOST]:
            # One motion is left, that moves this joint.
            motion = left.while_resting([other for other in columns if other != column]).motions
            texts.append(motion_text(self._mechanism, best.x, motion @ motion[column], most))
        # Of a joint that others hold, no link moves.
        texts = [text for text in texts if text]
        more = left.number - len(texts)
        if texts and more > 0:
            texts.append(f"and {more} more")
        listed = f": {'; '.join(texts)}" if texts else ""
        freedoms = "1 freedom is" if left.number == 1 else f"{left.number} freedoms are"
        return f"nothing decides the motion of: {choices(free)}; {freedoms} left over{listed}"

    def _advice(self, left: Freedoms, advised: list[str]) -> str:
        """Return what can be driven or held to remove the motions that are left.

        What its author drives is listed first, then slides, which mostly are cylinders.
        """
        if len(advised) > 1:
            return f"{len(advised)} of them, such as {choices(advised, most=20)}"
        rates, candidates = np.linalg.norm(left.motions, axis=1), self._candidates()
        useful = [each for each in candidates if rates[each] > 0.1 * np.max(rates[candidates])]
        motors, drivable = self._mechanism.independent_coordinates, self._mechanism.drivable
        ranked = sorted(
            self._drivable(useful),
            key=lambda name: (
                name not in motors,
                name != drivable[name].joint or not drivable[name].slides,
                name,
            ),
        )
        return f"one of: {choices(ranked, ranked=True)}"


def _decides(found: Freedoms, driven: list[int]) -> bool:
    """Return whether drives decide all motions."""
    return found.rank_of(driven) == len(driven) == found.number


def _too_many(still: list[str], surplus: list[str], drives: tuple[str, ...], excess: int) -> str:
    """Return which drives cannot move or contradict what is held, and what to do about it."""
    if excess > 1 and not surplus:
        return f"drop {excess} of the drives ({choices(drives)}), or stop holding as many joints"
    if still and not surplus:
        return f"{choices(still)} cannot move, and cannot be driven"
    advice = "drop a drive or stop holding a joint"
    if surplus:
        advice += f": {_one_of(surplus)}"
    return f"{choices(still)} cannot move: {advice}" if still else advice


def _one_of(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"one of: {choices(names)}"


class Freedoms(NamedTuple):
    """Independent motions of a mechanism at a closed configuration.

    Attributes:
        x: `(size,)` the configuration.
        motions: `(nv, m)` joint rates of each motion, slides counted in lengths of the mechanism.
    """

    x: Array
    motions: Array

    @property
    def number(self) -> int:
        """How many there are."""
        return self.motions.shape[1]

    def rank_of(self, columns: list[int]) -> int:
        """Return how many of some velocity coordinates move independently of each other."""
        return self._felt(columns)[0]

    def while_resting(self, columns: list[int]) -> Freedoms:
        """Return the motions in which some velocity coordinates rest."""
        rank, directions = self._felt(columns)
        return self._replace(motions=self.motions @ directions[:, rank:])

    def seen_by(self, columns: list[int]) -> Freedoms:
        """Return as many motions as move some velocity coordinates in different ways."""
        rank, directions = self._felt(columns)
        return self._replace(motions=self.motions @ directions[:, :rank])

    def _felt(self, columns: list[int]) -> tuple[int, Array]:
        """Return directions `(m, m)` among the motions, those that coordinates feel first."""
        _, values, right = np.linalg.svd(self.motions[columns])
        return int(np.sum(values > MOVES)), right.T

    def moving(self, columns: Iterable[int]) -> set[int]:
        """Return those of some velocity coordinates that any of the motions moves."""
        moves = np.max(np.abs(self.motions), axis=1, initial=0.0) > MOVES
        return {column for column in columns if moves[column]}

    def chosen(self, candidates: list[int], known: list[int]) -> list[int]:
        """Return velocity coordinates that move independently of each other and of known ones.

        Args:
            candidates: to choose from; of those half as fast as the fastest, the first are taken.
            known: what is decided already; independent of each other or not.
        """
        left, result = self.while_resting(known), list[int]()
        while left.moving(candidates):
            sizes = np.linalg.norm(left.motions[candidates], axis=1)
            result.append(candidates[int(np.argmax(2.0 * sizes > np.max(sizes)))])
            left = left.while_resting(result[-1:])
        return result


class Surroundings(NamedTuple):
    """A closed configuration, and a generic one beside it.

    Attributes:
        structure: of the mechanism.
        x: `(size,)` closed coordinates.
        held: velocity coordinates that rest.
        needed: velocity coordinates whose motion matters.
    """

    structure: Structure
    x: Array
    held: set[int]
    needed: set[int]

    def freedoms(
        self,
        drives: Iterable[int] = (),
        released: int | None = None,
        with_spins: bool = False,
        here: bool = False,
    ) -> list[Freedoms]:
        """Return the freedoms at the closed configuration, unless it is singular, and beside it.

        Args:
            drives: velocity coordinates of the drives; they move as all others do.
            released: a held one that moves as well, or a drive that is none.
            with_spins: whether spins of idle rods count as freedoms.
            here: whether only the closed configuration is asked for, singular or not.
        """
        mechanism = self.structure.mechanism
        free = set(range(mechanism.model.nv)) - (self.held - {released})
        every = [Freedoms(self.x.copy(), np.eye(mechanism.model.nv)) for _ in range(2 - here)]
        loose = set(free)
        parts: list[list[Array]] = [[] for _ in every]
        for group in independent_groups(self.structure, np.array(sorted(free), dtype=int)):
            states = states_around(solver_of(mechanism, group), self.x, *[1] * here)
            loose.difference_update(group.passives.tolist())
            left, _, _ = np.linalg.svd(states.group.scaled_rows)
            for item, motions, index in zip(every, parts, (0, -1), strict=False):
                own = states.x[index] != self.x
                item.x[own] = states.x[index][own]
                motions.append(np.zeros((mechanism.model.nv, left.shape[1] - states.rank)))
                motions[-1][group.passives] = left[index, :, states.rank :]
        rods = () if with_spins else idle_rods(mechanism, free.difference(drives))
        seen = [sorted(free.difference(rod.columns)) for rod in rods]
        seen.append(sorted(free & (self.needed | {released})))
        found = []
        for item, motions in zip(every, parts, strict=True):
            whole = np.concatenate([*motions, item.motions[:, sorted(loose)]], axis=1)
            found.append(item._replace(motions=whole))
            for columns in seen:
                found[-1] = found[-1].seen_by(columns)
        return found


def motion_text(mechanism: Mechanism, x: Array, motion: Array, most: int = _MOST) -> str:
    """Return in words which links a motion moves, and how; nothing where it moves none.

    Args:
        mechanism: the mechanism.
        x: `(size,)` closed coordinates.
        motion: `(nv,)` joint rates, slides in lengths of the mechanism.
        most: how many sets of links that move alike are described; the others are counted.
    """
    length, rates = mechanism.characteristic_length, motion * mechanism.coordinates.rate_scale
    names, origins, twists = [*mechanism.links], [], []
    for name in names:
        frame = CarriedFrame(mechanism, name, np.zeros(3))
        velocity, spin, *_ = (rate[:, 0] for rate in frame.rates(x[None], rates[None]))
        origins.append(frame.placed(x[None])[1][0])
        twists.append(np.array([velocity / length, spin]))
    least = MOVES * float(np.max(np.abs(twists)))
    moving = [index for index, twist in enumerate(twists) if np.max(np.abs(twist)) > least]

    def is_fixed_to(first: int, index: int) -> bool:
        """Return whether a link moves as a body with another one."""
        velocity, spin = twists[index]
        there = velocity + np.cross(spin, origins[first] - origins[index]) / length
        return bool(np.max(np.abs([there, spin] - twists[first])) <= least)

    sets: dict[int, list[str]] = {}
    for index in moving:
        first = next(first for first in moving if is_fixed_to(first, index))
        sets.setdefault(first, []).append(names[index])
    ordered = sorted(sets, key=lambda first: -len(sets[first]))
    texts = []
    for first in ordered[:most]:
        velocity, spin = twists[first]
        texts.append(_text(sets[first], origins[first], velocity, spin, length))
    others = sum(len(sets[first]) for first in ordered[most:])
    if others:
        texts.append(f"{others} more {'link' if others == 1 else 'links'} with them")
    return ", ".join(texts)


def _text(names: list[str], origin: Array, velocity: Array, spin: Array, length: float) -> str:
    """Return how links move."""
    several = len(names) > 1
    who = f"links {choices(names)}" if several else f"link {names[0]!r}"
    rate = float(np.linalg.norm(spin))
    if rate <= MOVES * float(np.linalg.norm(velocity)):
        return f"{who} {'slide' if several else 'slides'} along {_direction(velocity)}"
    axis = spin / rate
    # The point of the axis that is nearest to the link's origin.
    point = _vector(origin + length * np.cross(axis, velocity) / rate, length)
    text = f"{who} {'turn' if several else 'turns'} about {_direction(axis)} through {point}"
    if abs(float(axis @ velocity)) > MOVES * rate:
        text += f" and {'slide' if several else 'slides'} along it"
    return text


def _direction(vector: Array) -> str:
    """Return the direction of a line, which has no sign: its greatest component is positive."""
    greatest = vector[int(np.argmax(np.abs(vector) > 0.999 * np.max(np.abs(vector))))]
    return _vector(vector / np.copysign(np.linalg.norm(vector), greatest), 1.0)


def _vector(vector: Array, scale: float) -> str:
    cleaned = np.where(np.abs(vector) < MOVES * scale, 0.0, vector)
    return "(" + ", ".join(f"{value:.3g}" for value in cleaned) + ")"
