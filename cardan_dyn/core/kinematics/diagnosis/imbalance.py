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
from ..closing.far import states_around
from ..closing.group_solver import GroupSolver
from ..closing.stacked import ranks
from ..loops.groups import independent_groups
from ..loops.idle_rods import idle_rods
from ..loops.structure import Structure
from ..tolerances import MOVES
from .singularities import Singularity, gimbal_note

_MOST = 3
"""Motions, or sets of links that move alike, that a message describes; others are counted."""
_MOST_TRIED = 100
"""Held joints, and drives, that are left out by way of trial, each of which takes some time."""
_GOOD = 0.5
"""Part of the fastest candidate's rate with which another one decides a motion as well."""


def imbalance(problem: Problem, x: Array, passives: set[int], condition: float) -> CardanError:
    """Return the error that says why a scene's drives do not decide its motion.

    Args:
        problem: the drives and held joints of the scene.
        x: `(size,)` closed coordinates.
        passives: velocity coordinates that something must decide.
        condition: of the closure equations at the closed coordinates.
    """
    return _Imbalance(problem, x, passives).error(condition)


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
        self._resting = {self._column_of[name] for name in self._held}
        self._needed = passives | set(self._driven)
        self._around = Surroundings(Structure(mechanism), x)

    def error(self, condition: float) -> CardanError:
        """Return the error; `condition` is that where the scene starts."""
        mechanism, drives, driven = self._mechanism, self._drives, self._driven
        asked = self._resting, set(driven), self._needed
        found = self._around.freedoms(*asked)
        # The first one is where the scene starts, unless that is singular.
        best = found[int(np.argmax([item.rank_of(driven) for item in found]))]
        excess = len(drives) - best.rank_of(driven)
        if _decides([best], driven):
            (here,) = self._around.freedoms(*asked, here=True)
            if not _decides([here], driven):
                return self._dead_point(here, best, condition)
            # Then spins of rods are left over that the rule for idle rods does not decide.
            best = self._around.freedoms(*asked, with_spins=True)[0]
        surplus = self._surplus() if excess else []
        coupled = self._coupled() if excess else ""
        left = best.while_resting(driven)
        free, advised = self._names(left.moving(self._passives)), self._advised(best)
        reasons = []
        if coupled:
            reasons.append(coupled)
        elif best.number == 0:
            reasons.append(self._locked(surplus))
        elif excess:
            still = self._names([column for column in driven if not best.moving([column])])
            reasons.append(_too_many(still, surplus, drives, excess))
            surplus = surplus or still
        if left.number:
            reasons.append(self._too_few(best, left, free, advised))
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
        closing = {loop.joint for loop in mechanism.loops}

        def depth(name: str) -> int:
            """Return how many bodies carry a joint; a loop comes after all joints of the tree."""
            joint = mechanism.joints[drivable[name].joint]
            model = mechanism.model
            return model.njoints if joint.name in closing else len(ancestors(model, joint.id))

        # Motors mostly sit near the ground, and so do the joints that a scene holds.
        ordered = (*mechanism.independent_coordinates, *sorted(drivable, key=depth))
        taken = {*self._drives, *self._held}
        free = [name for name in dict.fromkeys(ordered) if name in drivable and name not in taken]
        free.sort(key=lambda name: name != drivable[name].joint)
        return [self._column_of[name] for name in free]

    def _advised(self, best: Freedoms) -> list[str]:
        """Return what decides the motion once it is driven or held as well."""
        candidates, known = self._candidates(), [*self._driven]
        more = best.chosen(candidates, known)
        while more:
            known += more
            # A rod whose joint is driven is no longer idle, and what turns with it may be free.
            found = self._around.freedoms(self._resting, set(known), self._needed)
            more = found[0].chosen(candidates, known)
        return self._drivable(known[len(self._driven) :])

    def _dead_point(
        self, here: Freedoms, elsewhere: Freedoms, condition: float
    ) -> SingularConfigurationError:
        """Return the error for a start that is singular, with the joints that are concerned."""
        mechanism, every = self._mechanism, set(range(self._mechanism.model.nv))
        position = here.x[mechanism.coordinates.columns_of(self._drives)]
        moving = self._names(here.moving(every))
        lost = self._names(elsewhere.moving(every) - here.moving(every))
        singularity = Singularity(
            tuple(name for name in lost if name not in moving),
            tuple(self._names(here.while_resting(self._driven).moving(every))),
            self._drives,
            here.number > elsewhere.number,
        )
        passives = every - self._resting - set(self._driven)
        note = gimbal_note(mechanism.coordinates, here.x, passives)
        return SingularConfigurationError(
            f"{mechanism.name}: position {as_text(position)} of {choices(self._drives)}, where the "
            f"scene starts, is singular: {singularity.text}. Give near={{joint: position}} to "
            f"begin elsewhere, or choose another drive{note}",
            position=as_position(position),
            condition=condition,
            **singularity.details,
        )

    def _coupled(self) -> str:
        """Return which couplings connect prescribed joints, and what to do; empty without any.

        Couplings of one joint with another are followed from joint to joint, like a train of
        wheels.
        """
        prescribed = [*self._driven, *(self._column_of[name] for name in self._held)]
        edges = [
            (item.name, item.predecessor_columns[0], item.successor_columns[0])
            for item in self._mechanism.couplings
            if len(item.predecessor_columns) == len(item.successor_columns) == 1
        ]
        for first in prescribed:
            reached, used = [first], []
            for column in reached:
                for name, *ends in edges:
                    if column in ends and name not in used:
                        used.append(name)
                        reached += [end for end in ends if end not in reached]
            both = [column for column in reached if column in prescribed]
            if len(both) > 1:
                return (
                    f"{choices(used)} couple{'s' * (len(used) == 1)} "
                    f"{choices(self._drivable(both))}: drive or hold only one of them"
                )
        return ""

    def _surplus(self) -> list[str]:
        """Return held joints and drives that are one too many: without any of them it moves."""
        drives = self._drives[:_MOST_TRIED] if len(self._drives) > 1 else ()
        result = []
        for name in (*self._held[:_MOST_TRIED], *drives):
            released = self._column_of[name]
            driven = [column for column in self._driven if column != released]
            resting, needed = self._resting - {released}, self._needed | {released}
            if _decides(self._around.freedoms(resting, set(driven), needed), driven):
                result.append(name)
        return result

    def _locked(self, surplus: list[str]) -> str:
        """Return what to do about a locked mechanism, some joints of which may be held."""
        remedy = self._mechanism.description.remedy
        advice = "check loops and couplings, and axes, which are x if left out"
        if surplus:
            advice = f"stop holding {_one_of(surplus)}"
        elif self._held:
            advice = f"stop holding more than one joint, or {advice}"
        return f"it is locked: {advice}" + (f"; {remedy}" if remedy else "")

    def _too_few(self, best: Freedoms, left: Freedoms, free: list[str], advised: list[str]) -> str:
        """Return which motions are left, and what can be driven to remove them."""
        columns = [self._column_of[name] for name in advised]
        # Where there are several, what the most links do says enough of each.
        most = _MOST if left.number == 1 else 1
        texts = []
        for column in columns[:_MOST]:
            # One motion is left, that moves this joint.
            motion = left.while_resting([other for other in columns if other != column]).motions
            texts.append(motion_text(self._mechanism, best.x, motion @ motion[column], most))
        more = left.number - len(texts)
        listed = "; ".join(texts) + (f"; and {more} more" if more > 0 else "")
        freedoms = "1 freedom is" if left.number == 1 else f"{left.number} freedoms are"
        if len(advised) > 1:
            advice = f"{len(advised)} of them, such as {choices(advised, most=20)}"
        else:
            rates, candidates = np.linalg.norm(left.motions, axis=1), self._candidates()
            useful = [each for each in candidates if rates[each] > 0.1 * np.max(rates[candidates])]
            advice = f"one of: {choices(self._drivable(useful))}"
        return (
            f"nothing decides the motion of: {choices(free)}; {freedoms} left over: {listed}; "
            f"drive or hold {advice}"
        )


def _decides(found: list[Freedoms], driven: list[int]) -> bool:
    """Return whether drives decide all motions in some generic configuration."""
    return any(item.rank_of(driven) == len(driven) == item.number for item in found)


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
        return _rank(self.motions[columns])

    def while_resting(self, columns: list[int]) -> Freedoms:
        """Return the motions in which some velocity coordinates rest."""
        rows = self.motions[columns]
        if not rows.size:
            return self
        _, _, right = np.linalg.svd(rows)
        return self._replace(motions=self.motions @ right[_rank(rows) :].T)

    def moving(self, columns: Iterable[int]) -> set[int]:
        """Return those of some velocity coordinates that any of the motions moves."""
        moves = np.max(np.abs(self.motions), axis=1, initial=0.0) > MOVES
        return {column for column in columns if moves[column]}

    def chosen(self, candidates: list[int], known: list[int]) -> list[int]:
        """Return velocity coordinates that move independently of each other and of known ones.

        Args:
            candidates: to choose from; of those that serve well, the first ones are taken.
            known: what is decided already; independent of each other or not.
        """
        rows = self.while_resting(known).motions
        result: list[int] = []
        while rows.shape[1]:
            sizes = np.linalg.norm(rows[candidates], axis=1)
            if not sizes.size or np.max(sizes) <= MOVES:
                break
            best = candidates[int(np.argmax(sizes > _GOOD * np.max(sizes)))]
            result.append(best)
            _, _, right = np.linalg.svd(rows[[best]])
            rows = rows @ right[1:].T
        return result


class Surroundings:
    """Generic configurations around a closed one, with any joints held.

    What was found for some held joints is kept: their ranks take longer than all that follows.
    """

    def __init__(self, structure: Structure, x: Array) -> None:
        """Begin with nothing.

        Args:
            structure: of the mechanism.
            x: `(size,)` closed coordinates.
        """
        self._structure = structure
        self._x = x
        self._known: dict[object, list[tuple[Array, Array, Array]]] = {}

    def freedoms(
        self,
        held: set[int],
        drives: set[int],
        needed: set[int],
        with_spins: bool = False,
        here: bool = False,
    ) -> list[Freedoms]:
        """Return the freedoms in the configurations, in the closed one first unless it is singular.

        Args:
            held: velocity coordinates that rest.
            drives: velocity coordinates of the drives; they move as all others do.
            needed: velocity coordinates whose motion matters.
            with_spins: whether spins of idle rods count as freedoms.
            here: whether only the closed configuration is asked for, singular or not.
        """
        mechanism = self._structure.mechanism
        free = sorted(set(range(mechanism.model.nv)) - held)
        key = frozenset(held), here
        if key not in self._known:
            self._known[key] = self._sets_of_loops(free, here)
        sets, found = self._known[key], []
        on_loops = {column for columns, *_ in sets for column in columns.tolist()}
        loose = [column for column in free if column not in on_loops]
        rods = () if with_spins else idle_rods(mechanism, set(free) - drives)
        for index in range(max((len(states) for _, states, _ in sets), default=1)):
            x, motions = self._x.copy(), []
            for columns, states, null in sets:
                chosen = states[index % len(states)]
                x[chosen != self._x] = chosen[chosen != self._x]
                own = null[index % len(states)]
                motions.append(np.zeros((mechanism.model.nv, own.shape[1])))
                motions[-1][columns] = own
            every = np.concatenate([*motions, np.eye(mechanism.model.nv)[:, loose]], axis=1)
            for rod in rods:
                others = [column for column in free if column not in rod.columns]
                every = every @ _row_space(every[others])
            found.append(Freedoms(x, every @ _row_space(every[sorted(needed & set(free))])))
        return found

    def _sets_of_loops(self, free: list[int], here: bool) -> list[tuple[Array, Array, Array]]:
        """Return what is known of each set of loops that has no joint in common with others.

        Returns:
            Velocity coordinates `(p,)`, closed coordinates `(K, size)` and the motions that they
            leave `(K, p, n)`.
        """
        result = []
        for group in independent_groups(self._structure, np.array(free, dtype=int)):
            if not group.passives.size:
                continue
            solver = GroupSolver(self._structure.mechanism, group)
            if here:
                x = self._x[None, :]
                rows = solver.evaluate(x, solver.equations.full).scaled_rows
                rank = int(ranks(rows)[0])
            else:
                states = states_around(solver, self._x)
                x, rows, rank = states.x, states.group.scaled_rows, states.rank
            left, _, _ = np.linalg.svd(rows)
            result.append((group.passives, x, left[:, :, rank:]))
        return result


def _row_space(rows: Array) -> Array:
    """Return an orthonormal basis `(m, rank)` of the combinations of columns that rows feel."""
    if not rows.size:
        return np.zeros((rows.shape[1], 0))
    _, _, right = np.linalg.svd(rows, full_matrices=False)
    return np.asarray(right[: _rank(rows)].T)


def _rank(rows: Array) -> int:
    if not rows.size:
        return 0
    return int(np.sum(np.linalg.svd(rows, compute_uv=False) > MOVES))


def motion_text(mechanism: Mechanism, x: Array, motion: Array, most: int = _MOST) -> str:
    """Return in words which links a motion moves, and how.

    Args:
        mechanism: the mechanism.
        x: `(size,)` closed coordinates.
        motion: `(nv,)` joint rates, slides in lengths of the mechanism.
        most: how many sets of links that move alike are described; the others are counted.
    """
    length, rates = mechanism.characteristic_length, motion * mechanism.coordinates.rate_scale
    moving = []
    for name in mechanism.links:
        frame = CarriedFrame(mechanism, name, np.zeros(3))
        velocity, spin, *_ = (rate[:, 0] for rate in frame.rates(x[None], rates[None]))
        moving.append((name, frame.placed(x[None])[1][0], velocity, spin))

    def size(velocity: Array, spin: Array) -> float:
        return float(np.max(np.abs([velocity / length, spin])))

    fastest = max(size(velocity, spin) for *_, velocity, spin in moving)
    # Links that move as one body: their names, and how the origin of the first one moves.
    sets: list[tuple[list[str], Array, Array, Array]] = []
    for name, origin, velocity, spin in moving:
        if size(velocity, spin) <= MOVES * fastest:
            continue
        for names, first, its_velocity, its_spin in sets:
            there = velocity + np.cross(spin, first - origin)
            if size(there - its_velocity, spin - its_spin) <= MOVES * fastest:
                names.append(name)
                break
        else:
            sets.append(([name], origin, velocity, spin))
    sets.sort(key=lambda item: -len(item[0]))
    texts = [_text(*item, length) for item in sets[:most]]
    others = sum(len(names) for names, *_ in sets[most:])
    if others:
        texts.append(f"{others} more {'link' if others == 1 else 'links'} with them")
    return ", ".join(texts) if texts else "no link"


def _text(names: list[str], origin: Array, velocity: Array, spin: Array, length: float) -> str:
    """Return how links move."""
    several = len(names) > 1
    who = f"links {choices(names)}" if several else f"link {names[0]!r}"
    rate = float(np.linalg.norm(spin))
    if rate * length <= MOVES * float(np.linalg.norm(velocity)):
        return f"{who} {'slide' if several else 'slides'} along {_direction(velocity)}"
    axis = spin / rate
    # The point of the axis that is nearest to the link's origin.
    point = _vector(origin + np.cross(axis, velocity) / rate, length)
    text = f"{who} {'turn' if several else 'turns'} about {_direction(axis)} through {point}"
    if abs(float(axis @ velocity)) > MOVES * rate * length:
        text += f" and {'slide' if several else 'slides'} along it"
    return text


def _direction(vector: Array) -> str:
    """Return the direction of a line, which has no sign: its greatest component is positive."""
    greatest = vector[int(np.argmax(np.abs(vector) > 0.999 * np.max(np.abs(vector))))]
    return _vector(vector / np.copysign(np.linalg.norm(vector), greatest), 1.0)


def _vector(vector: Array, scale: float) -> str:
    cleaned = np.where(np.abs(vector) < MOVES * scale, 0.0, vector)
    return "(" + ", ".join(f"{value:.3g}" for value in cleaned) + ")"
