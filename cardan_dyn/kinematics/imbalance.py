"""Imbalance: why the drives of a scene do not decide its motion, and what would mend it.

What is judged are generic configurations, in which as many closure equations as possible are
independent: a scene that starts in a dead point does not lack a drive, and one that starts where a
locked mechanism can be shaken is locked.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import (
    CardanError,
    MobilityError,
    SingularConfigurationError,
    as_position,
    as_text,
    choices,
)
from ..mechanism.mechanism import Mechanism
from ..mechanism.tree import ancestors
from .freedoms import Freedoms, Surroundings
from .gimbal_lock import gimbal_note
from .motion_text import motion_text
from .singularities import Singularity
from .structure import Structure

_MOST_MOTIONS = 3
"""Motions that a message describes; the others are counted."""
_MOST_TRIED = 100
"""Held joints, and drives, that are left out by way of trial, each of which takes some time."""


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


def imbalance(
    mechanism: Mechanism,
    x: Array,
    drives: tuple[str, ...],
    held: list[str],
    passives: set[int],
    condition: float,
) -> CardanError:
    """Return the error that says why a scene's drives do not decide its motion.

    Args:
        mechanism: the mechanism.
        x: `(size,)` closed coordinates.
        drives: names of the driven joints.
        held: names of the held joints.
        passives: velocity coordinates that something must decide.
        condition: of the closure equations at the closed coordinates.
    """
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
        reasons.append(_locked(surplus, bool(held)))
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
            "they lead; give start={joint: position} to begin farther from it"
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
        f"scene starts, is singular: {singularity.text}. Give start={{joint: position}} to begin "
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
    """Return the held joints and drives that are one too many: without any of them it moves.

    Args:
        scene: its drives and held joints.
        around: the configurations to judge by.
        needed: velocity coordinates whose motion matters.
    """
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
    return f"it is locked: {release}check loops and couplings"


def _too_many(still: list[str], surplus: list[str], drives: tuple[str, ...], excess: int) -> str:
    """Return which drives cannot move or contradict what is held, and what to do about it.

    Args:
        still: drives that cannot move.
        surplus: drives and held joints any of which is one too many.
        drives: all of them.
        excess: how many drives are too many.
    """
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
