"""Imbalance: why the drives of a scene do not decide its motion, and what would mend it.

What is judged are generic configurations, in which as many closure equations as possible are
independent: a scene that starts in a dead point does not lack a drive, and one that starts where a
locked mechanism can be shaken is locked.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
import pinocchio

from ...arrays import Array
from ...errors import (
    CardanError,
    MobilityError,
    SingularConfigurationError,
    as_position,
    as_text,
    choices,
)
from ...mechanism.mechanism import Mechanism
from ...mechanism.tree import ancestors
from ...problem.problem import Problem
from ..closing.far import states_around
from ..closing.group_solver import GroupSolver
from ..closing.stacked import ranks
from ..loops.groups import independent_groups
from ..loops.idle_rods import idle_rods
from ..loops.structure import Structure, displacement, unit_twists
from ..tolerances import MOVES
from .singularities import Singularity, gimbal_note

_MOST_MOTIONS = 3
"""Motions that a message describes; the others are counted."""
_MOST_TRIED = 100
"""Held joints, and drives, that are left out by way of trial, each of which takes some time."""
_GOOD = 0.5
"""Part of the fastest candidate's rate with which another one decides a motion as well."""
_SAME = 1e-6
"""Difference of twists, relative to the fastest link of a motion, up to which links move alike, or
rest. Rates of closed configurations are exact to 1e-9 and better where messages describe them."""
_MOST_SETS = 3
"""Sets of links that move alike which a message describes unless it has others to describe."""
_DIGITS = 3
"""Digits of points and directions in a message: enough to find them in a drawing."""


class _Prescribed(NamedTuple):
    """A scene's drives and held joints.

    Attributes:
        mechanism: the mechanism.
        drives: names of the driven joints.
        held: names of the held joints.
    """

    mechanism: Mechanism
    drives: tuple[str, ...]
    held: list[str]

    def columns(self, names: Iterable[str]) -> list[int]:
        """Return velocity coordinates by the names by which scenes drive or hold them."""
        rates = {name: column for column, name in self._names.items()}
        return [rates[name] for name in names]

    def names(self, columns: Iterable[int]) -> list[str]:
        """Return the names of velocity coordinates, see `Coordinates.names_of`."""
        return self.mechanism.coordinates.names_of(set(columns))

    def advice(self, columns: Iterable[int]) -> list[str]:
        """Return the names by which velocity coordinates can be driven or held."""
        return [self._names[column] for column in columns]

    def candidates(self) -> list[int]:
        """Return the coordinates that could be driven, those that the author drives first.

        Those of joints with several come last; near zero, the rates of a ball's three angles are
        the components of its rotation.
        """
        mechanism, drivable = self.mechanism, self.mechanism.drivable
        taken = {*self.drives, *self.held}
        # Motors mostly sit near the ground, and so do the joints that a scene holds.
        near_first = sorted(drivable, key=lambda name: self._depth(drivable[name].joint))
        ordered = dict.fromkeys((*mechanism.independent_coordinates, *near_first))
        free = [name for name in ordered if name in drivable and name not in taken]
        single = [name for name in free if name == drivable[name].joint]
        return self.columns([*single, *(name for name in free if name not in single)])

    @property
    def _names(self) -> dict[int, str]:
        """Names of all velocity coordinates that can be driven."""
        coordinates = self.mechanism.coordinates
        spans = coordinates.velocity_columns
        return {
            spans[item.joint].start + item.offset: name
            for name, item in self.mechanism.drivable.items()
        }

    def _depth(self, name: str) -> int:
        """Return how many bodies carry a joint; a loop comes after all joints of the tree."""
        item = self.mechanism.joints[name]
        is_loop = any(loop.joint == name for loop in self.mechanism.loops)
        return (
            self.mechanism.model.njoints
            if is_loop
            else len(ancestors(self.mechanism.model, item.id))
        )


def imbalance(problem: Problem, x: Array, passives: set[int], condition: float) -> CardanError:
    """Return the error that says why a scene's drives do not decide its motion.

    Args:
        problem: the drives and held joints of the scene.
        x: `(size,)` closed coordinates.
        passives: velocity coordinates that something must decide.
        condition: of the closure equations at the closed coordinates.
    """
    mechanism, drives, held = problem.mechanism, problem.independent, list(problem.held)
    scene = _Prescribed(mechanism, drives, held)
    around = Surroundings(Structure(mechanism), x)
    driven, resting = scene.columns(drives), set(scene.columns(held))
    needed = passives | set(driven)
    found = around.freedoms(resting, set(driven), needed)
    # The first one is where the scene starts, unless that is singular.
    best = found[int(np.argmax([item.rank_of(driven) for item in found]))]
    decided = best.rank_of(driven)
    if _decides([best], driven):
        here = around.freedoms_here(resting, set(driven), needed)
        if not _decides([here], driven):
            return _dead_point(scene, here, best, condition)
        # Then spins of rods are left over that the rule for idle rods does not decide.
        found = around.freedoms(resting, set(driven), needed, with_spins=True)
        best = found[0]
    surplus = []
    if decided < len(drives):
        surplus = _surplus(scene, around, needed)
    loops = f"its loops leave mobility {best.number}" if mechanism.loops else "it has no loop"
    held_text = f" with {choices(held)} held" if held else ""
    left = best.while_resting(driven)
    free = scene.names(left.moving(passives))
    advised = scene.advice(_advised(scene, around, best, needed))
    reasons = []
    coupled = _coupled(scene) if decided < len(drives) else ""
    if coupled:
        reasons.append(coupled)
    elif best.number == 0:
        remedy = mechanism.description.remedy
        reasons.append(_locked(surplus, bool(held)) + (f"; {remedy}" if remedy else ""))
    elif decided < len(drives):
        still = scene.names([column for column in driven if not best.moving([column])])
        reasons.append(_too_many(still, surplus, drives, len(drives) - decided))
        surplus = surplus or still
    if left.number:
        reasons.append(_too_few(scene, best, free, advised))
    if not reasons:
        reasons.append(
            f"{choices(drives)} would decide the motion, but this position is so close to a "
            "singular configuration, where assembly modes meet, that rounding decides which way "
            "they lead; give near={joint: position} to begin farther from it"
        )
    return MobilityError(
        f"{mechanism.name}: driven by {choices(drives)}{held_text}, {loops}: {'; '.join(reasons)}",
        mobility=best.number,
        free=free,
        advised=advised,
        surplus=surplus,
    )


def _advised(
    scene: _Prescribed, around: Surroundings, best: Freedoms, needed: set[int]
) -> list[int]:
    """Return velocity coordinates that decide the motion once they are driven or held as well."""
    driven, resting = scene.columns(scene.drives), set(scene.columns(scene.held))
    result = more = best.chosen(scene.candidates(), driven)
    while more:
        # A rod whose joint is driven is no longer idle, and what else turns with it may be free.
        known = [*driven, *result]
        found = around.freedoms(resting, set(known), needed)
        more = found[0].chosen(scene.candidates(), known)
        result = [*result, *more]
    return result


def _dead_point(
    scene: _Prescribed, here: Freedoms, elsewhere: Freedoms, condition: float
) -> SingularConfigurationError:
    """Return the error for a start that is singular, with the joints that are concerned."""
    mechanism = scene.mechanism
    position = here.x[mechanism.coordinates.columns_of(scene.drives)]
    every = set(range(mechanism.model.nv))
    lost = [
        name
        for name in scene.names(elsewhere.moving(every) - here.moving(every))
        if name not in scene.names(here.moving(every))
    ]
    moving = scene.names(here.while_resting(scene.columns(scene.drives)).moving(every))
    singularity = Singularity(
        tuple(lost), tuple(moving), scene.drives, here.number > elsewhere.number
    )
    passives = every - set(scene.columns([*scene.drives, *scene.held]))
    note = gimbal_note(mechanism.coordinates, here.x, passives)
    return SingularConfigurationError(
        f"{mechanism.name}: position {as_text(position)} of {choices(scene.drives)}, where the "
        f"scene starts, is singular: {singularity.text}. Give near={{joint: position}} to begin "
        f"elsewhere, or choose another drive{note}",
        position=as_position(position),
        condition=condition,
        **singularity.details,
    )


def _coupled(scene: _Prescribed) -> str:
    """Return which couplings connect prescribed joints, and what to do; empty without any.

    Couplings of one joint with another are followed from joint to joint, like a train of wheels.
    """
    prescribed = scene.columns([*scene.drives, *scene.held])
    edges = [
        (item.name, item.predecessor_columns[0], item.successor_columns[0])
        for item in scene.mechanism.couplings
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
            names = choices(scene.advice(both))
            return (
                f"{choices(used)} couple{'s' * (len(used) == 1)} {names}: "
                "drive or hold only one of them"
            )
    return ""


def _surplus(scene: _Prescribed, around: Surroundings, needed: set[int]) -> list[str]:
    """Return the held joints and drives that are one too many: without any of them it moves."""
    driven = scene.columns(scene.drives)
    result = []
    for name in scene.held[:_MOST_TRIED]:
        (released,) = scene.columns([name])
        resting = {column for column in scene.columns(scene.held) if column != released}
        found = around.freedoms(resting, set(driven), needed | {released})
        if _decides(found, driven):
            result.append(name)
    resting = set(scene.columns(scene.held))
    for name in scene.drives[:_MOST_TRIED] if len(scene.drives) > 1 else ():
        others = [column for column in driven if column not in scene.columns([name])]
        if _decides(around.freedoms(resting, set(others), needed), others):
            result.append(name)
    return result


def _decides(found: list[Freedoms], driven: list[int]) -> bool:
    """Return whether drives decide all motions in some generic configuration."""
    return any(item.rank_of(driven) == len(driven) == item.number for item in found)


def _locked(surplus: list[str], holds: bool) -> str:
    """Return what to do about a locked mechanism, some joints of which may be held."""
    if surplus:
        return f"it is locked: stop holding {_one_of(surplus)}"
    release = "stop holding more than one joint, or " if holds else ""
    return f"it is locked: {release}check loops and couplings, and axes, which are x if left out"


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


def _too_few(scene: _Prescribed, best: Freedoms, free: list[str], advised: list[str]) -> str:
    """Return which motions are left, and what can be driven to remove them."""
    driven = scene.columns(scene.drives)
    left = best.while_resting(driven)
    mechanism = scene.mechanism
    columns = scene.columns(advised)
    # Where there are several, what the most links do says enough of each.
    most = None if left.number == 1 else 1
    texts = []
    for column in columns[:_MOST_MOTIONS]:
        others = [other for other in columns if other != column]
        # One motion is left, that moves this joint.
        motion = left.while_resting(others).motions
        texts.append(motion_text(mechanism, best.x, motion @ motion[column], most))
    more = left.number - len(texts)
    listed = "; ".join(texts) + (f"; and {more} more" if more > 0 else "")
    freedoms = "1 freedom is" if left.number == 1 else f"{left.number} freedoms are"
    return (
        f"nothing decides the motion of: {choices(free)}; {freedoms} left over: {listed}; "
        f"{_advice(scene, best, advised)}"
    )


def _advice(scene: _Prescribed, best: Freedoms, advised: list[str]) -> str:
    """Return which joints to drive or hold."""
    if len(advised) > 1:
        return f"drive or hold {len(advised)} of them, such as {choices(advised, most=20)}"
    left = best.while_resting(scene.columns(scene.drives))
    rates = np.linalg.norm(left.motions, axis=1)
    columns = scene.candidates()
    useful = [column for column in columns if rates[column] > 0.1 * np.max(rates[columns])]
    return f"drive or hold one of: {choices(scene.advice(useful))}"


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
        self._near: dict[frozenset[int], list[_SetOfLoops]] = {}

    def freedoms(
        self, held: set[int], drives: set[int], needed: set[int], with_spins: bool = False
    ) -> list[Freedoms]:
        """Return the freedoms in the configurations, in the closed one first unless it is singular.

        Args:
            held: velocity coordinates that rest.
            drives: velocity coordinates of the drives; they move as all others do.
            needed: velocity coordinates whose motion matters.
            with_spins: whether spins of idle rods count as freedoms.
        """
        key = frozenset(held)
        if key not in self._near:
            self._near[key] = [_SetOfLoops.near(solver, self._x) for solver in self._solvers(held)]
        sets = self._near[key]
        count = max((len(item.x) for item in sets), default=1)
        return [
            self._joined(sets, index, held, drives, needed, with_spins) for index in range(count)
        ]

    def freedoms_here(self, held: set[int], drives: set[int], needed: set[int]) -> Freedoms:
        """Return the freedoms in the closed configuration, singular or not; see `freedoms`."""
        sets = [_SetOfLoops.at(solver, self._x) for solver in self._solvers(held)]
        return self._joined(sets, 0, held, drives, needed, False)

    def _solvers(self, held: set[int]) -> Iterator[GroupSolver]:
        """Make what solves each set of loops that has no joint in common with others."""
        free = np.array(self._free(held), dtype=int)
        for group in independent_groups(self._structure, free):
            if group.passives.size:
                yield GroupSolver(self._structure.mechanism, group)

    def _free(self, held: set[int]) -> list[int]:
        return sorted(set(range(self._structure.mechanism.model.nv)) - held)

    def _joined(
        self,
        sets: list[_SetOfLoops],
        index: int,
        held: set[int],
        drives: set[int],
        needed: set[int],
        with_spins: bool,
    ) -> Freedoms:
        """Return the freedoms of all sets of loops and of what is on none; see `freedoms`."""
        mechanism, free = self._structure.mechanism, self._free(held)
        x = self._x.copy()
        for item in sets:
            chosen = item.x[index % len(item.x)]
            x[chosen != self._x] = chosen[chosen != self._x]
        null = [(item.columns, item.null[index % len(item.x)]) for item in sets]
        motions = _block_diagonal(null, free, mechanism.model.nv)
        for rod in () if with_spins else idle_rods(mechanism, set(free) - drives):
            others = [column for column in free if column not in rod.columns]
            motions = motions @ _row_space(motions[others])
        return Freedoms(x, motions @ _row_space(motions[sorted(needed & set(free))]))


class _SetOfLoops(NamedTuple):
    """Loops and couplings that have no joint in common with others, in K configurations.

    Attributes:
        columns: `(p,)` velocity coordinates on them.
        x: `(K, size)` closed configurations.
        null: `(K, p, n)` motions that they leave.
    """

    columns: Array
    x: Array
    null: Array

    @staticmethod
    def near(solver: GroupSolver, x: Array) -> _SetOfLoops:
        """Return generic configurations around closed coordinates `(size,)`."""
        states = states_around(solver, x)
        left, _, _ = np.linalg.svd(states.group.scaled_rows)
        return _SetOfLoops(solver.group.passives, states.x, left[:, :, states.rank :])

    @staticmethod
    def at(solver: GroupSolver, x: Array) -> _SetOfLoops:
        """Return closed coordinates `(size,)` alone, with their own rank."""
        state = solver.evaluate(x[None, :], solver.equations.full)
        left, _, _ = np.linalg.svd(state.scaled_rows)
        rank = int(ranks(state.scaled_rows)[0])
        return _SetOfLoops(solver.group.passives, x[None, :], left[:, :, rank:])


def _block_diagonal(null: list[tuple[Array, Array]], free: list[int], nv: int) -> Array:
    """Return motions `(nv, m)`: those of sets of loops, and each free coordinate on none of them.

    With null `(p,)`.
    """
    on_loops = {int(column) for columns, _ in null for column in columns}
    loose = np.array([column for column in free if column not in on_loops], dtype=int)
    blocks = [*null, (loose, np.eye(len(loose)))]
    motions = np.zeros((nv, sum(block.shape[1] for _, block in blocks)))
    first = 0
    for columns, block in blocks:
        motions[columns, first : first + block.shape[1]] = block
        first += block.shape[1]
    return motions


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


class _Alike(NamedTuple):
    """Links that move as one rigid body.

    Attributes:
        names: of the links.
        twist: `(6,)` linear part at the world's origin, then angular part, in world axes.
        origin: `(3,)` of the first link, in the world.
    """

    names: list[str]
    twist: Array
    origin: Array


def motion_text(mechanism: Mechanism, x: Array, motion: Array, most: int | None = None) -> str:
    """Return in words which links a motion moves, and how.

    Args:
        mechanism: the mechanism.
        x: `(size,)` closed coordinates.
        motion: `(nv,)` joint rates, slides in lengths of the mechanism.
        most: how many sets of links that move alike are described; the others are counted.
    """
    most = most or _MOST_SETS
    sets = sorted(_alike(mechanism, x, motion), key=lambda item: -len(item.names))
    texts = [_text(item, mechanism.characteristic_length) for item in sets[:most]]
    others = sum(len(item.names) for item in sets[most:])
    if others:
        texts.append(f"{others} more {'link' if others == 1 else 'links'} with them")
    return ", ".join(texts) if texts else "no link"


def _alike(mechanism: Mechanism, x: Array, motion: Array) -> list[_Alike]:
    """Return the links that a motion moves, those together that move alike."""
    poses, twists = _bodies(mechanism, x, motion)
    weights = np.repeat([1.0 / mechanism.characteristic_length, 1.0], 3)
    sets: list[_Alike] = []
    moving = []
    for name, (body, placement) in mechanism.links.items():
        origin = np.array((poses[body] * placement).translation)
        # Speeds of the link's own origin: about the world's, rest could not be told from motion
        # where a mechanism is far away.
        twist = twists[body].copy()
        twist[:3] += np.cross(twist[3:], origin)
        moving.append((name, body, origin, np.max(np.abs(twist * weights))))
    fastest = max((speed for *_, speed in moving), default=0.0)
    for name, body, origin, speed in moving:
        if speed <= _SAME * fastest:
            continue
        for item in sets:
            difference = twists[body] - item.twist
            difference[:3] += np.cross(difference[3:], item.origin)
            if np.max(np.abs(difference * weights)) <= _SAME * fastest:
                item.names.append(name)
                break
        else:
            sets.append(_Alike([name], twists[body], origin))
    return sets


def _bodies(
    mechanism: Mechanism, x: Array, motion: Array
) -> tuple[list[pinocchio.SE3], list[Array]]:
    """Return placements and twists `(6,)` of all bodies, by plain forward kinematics."""
    model, coordinates = mechanism.model, mechanism.coordinates
    poses, twists = [pinocchio.SE3.Identity()], [np.zeros(6)]
    for part, start in sorted(
        zip(coordinates.parts, coordinates.starts, strict=True), key=lambda item: item[0].id
    ):
        parent, first = model.parents[part.id], model.idx_vs[part.id]
        moved = displacement(part, x[start : start + 4])
        pose = poses[parent] * model.jointPlacements[part.id] * moved
        units = unit_twists(part, mechanism.characteristic_length)
        own = pose.action @ (units.T @ motion[first : first + part.nv])
        poses.append(pose)
        twists.append(twists[parent] + own)
    return poses, twists


def _text(item: _Alike, length: float) -> str:
    """Return how a set of links moves."""
    several = len(item.names) > 1
    who = f"links {choices(item.names)}" if several else f"link {item.names[0]!r}"
    linear, angular = item.twist[:3], item.twist[3:]
    at_origin = linear + np.cross(angular, item.origin)
    rate = float(np.linalg.norm(angular))
    if rate * length <= _SAME * float(np.linalg.norm(at_origin)):
        return f"{who} {'slide' if several else 'slides'} along {_direction(at_origin)}"
    axis = angular / rate
    # The point of the axis that is nearest to the link's origin.
    point = item.origin + np.cross(axis, at_origin) / rate
    text = f"{who} {'turn' if several else 'turns'} about {_direction(axis)} through "
    text += _vector(point, length)
    if abs(float(axis @ at_origin)) > _SAME * rate * length:
        text += f" and {'slide' if several else 'slides'} along it"
    return text


def _direction(vector: Array) -> str:
    """Return the direction of a line, which has no sign: its greatest component is positive."""
    greatest = vector[int(np.argmax(np.abs(vector) > 0.999 * np.max(np.abs(vector))))]
    return _vector(vector / np.copysign(np.linalg.norm(vector), greatest), 1.0)


def _vector(vector: Array, scale: float) -> str:
    cleaned = np.where(np.abs(vector) < _SAME * scale, 0.0, vector)
    return "(" + ", ".join(f"{value:.{_DIGITS}g}" for value in cleaned) + ")"
