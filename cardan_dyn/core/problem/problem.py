"""Problem: what a scene solves, as frozen data that every later step reads and none changes."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ...kit.arrays import Array, consecutive
from ...kit.errors import MobilityError, choices
from ...kit.frozen import FrozenDict, Record, frozen, read_only
from ..elements.link_loads import LinkLoad
from ..mechanism.mechanism import Mechanism
from .acting import AT_ZERO, Acting

if TYPE_CHECKING:
    from ..elements.element import Element
    from ..elements.element_forces import ElementForces

FIRST_MODE = "A"
"""Name of the assembly mode that the description's zero leads to, see `mode_name`."""
_DECIDE_ASSEMBLY = frozenset(
    {"mechanism", "independent", "held", "near", "near_balls", "branch", "outputs", "all_outputs"}
)
"""Attributes of a problem that decide how its loops are closed."""
_DECIDE_EQUATIONS = frozenset({"listed", "free", "compliance"})
"""Those that decide, besides, how wrenches are solved: sweeps are told anew what acts."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Problem(Record):
    """A mechanism, what decides its motion, and what acts on it; all of it was checked.

    Attributes:
        mechanism: the mechanism, with those balls as turns of which a coordinate is named.
        independent: names of the joints that decide the motion: those that are driven, then those
            that are free. Loops are closed and wrenches solved alike for both. Of a joint with
            several coordinates these and the following attributes name a coordinate, see
            `Mechanism.drivable`.
        listed: whether they were named in a list: then the last axis of their positions, speeds
            and accelerations may be one of length 1 where the list has one name.
        free: those among them whose motion is to be found.
        held: joints whose position is fixed, to that position [rad or m].
        near: joints that are brought to a position before the drives take over.
        near_balls: joints whose balls start at a unit quaternion `(4,)`.
        branch: name of the assembly mode.
        joint_loads: joint to the effort added there, of any shape [N·m or N].
        link_loads: link to the wrench that acts on it.
        gravity: `(3,)` acceleration of free fall in world axes [m/s²].
        outputs: names of the joints whose wrenches are wanted.
        all_outputs: whether these are all joints, since none was named.
        compliance: joint to its `(6, 6)` compliance, force first [m/N, rad/(N·m)].
        strict: whether statically indeterminate components are refused.
        elements: springs, bushings, friction and actuators.
    """

    mechanism: Mechanism
    independent: tuple[str, ...]
    listed: bool
    free: tuple[str, ...]
    held: FrozenDict[str, float]
    near: FrozenDict[str, float]
    near_balls: FrozenDict[str, Array]
    branch: str
    joint_loads: FrozenDict[str, Array]
    link_loads: FrozenDict[str, LinkLoad]
    gravity: Array
    outputs: tuple[str, ...]
    all_outputs: bool
    compliance: FrozenDict[str, Array]
    strict: bool
    elements: tuple[Element, ...] = ()

    def differs_from(self, other: Problem, among: Collection[str] | None = None) -> set[str]:
        """Return the names of the attributes that have other values in another problem.

        Mechanisms and loads on links count as equal only if they are the same objects.

        Args:
            other: the other problem.
            among: names of the attributes that are compared; all if None.
        """
        own, others = self.__dict__, other.__dict__
        return {
            name
            for name in among or self.__dataclass_fields__
            if own[name] is not others[name] and not _equal(own[name], others[name])
        }

    def moves_like(self, other: Problem) -> bool:
        """Return whether the loops of another problem are closed alike."""
        if self.differs_from(other, _DECIDE_ASSEMBLY):
            return False
        return self.element_bodies == other.element_bodies

    def solved_like(self, other: Problem) -> bool:
        """Return whether the same equations serve a problem that moves like it."""
        return not self.differs_from(other, _DECIDE_EQUATIONS)

    def holding(self, positions: Mapping[str, float]) -> Problem:
        """Return the problem with held joints at other positions; what acts is known of both."""
        result = object.__new__(Problem)
        known = {name: value for name, value in self.__dict__.items() if name != "held_row"}
        result.__dict__.update(known, held=frozen({**self.held, **positions}))
        return result

    def held_elsewhere(self, other: Problem) -> tuple[str, ...]:
        """Return the held joints that stand elsewhere than in another problem, in their order.

        Nothing but these then decides where a scene of the first assembly mode starts. There are
        none where more differs, or where joints are brought to positions that these may carry them
        from.
        """
        names = list(self.held)
        stays = set(self.near) <= set(self.independent) and not self.near_balls
        if self.free or not stays or self.branch != FIRST_MODE or names != list(other.held):
            return ()
        if self.differs_from(other) != {"held"}:
            return ()
        return tuple(name for name in names if self.held[name] != other.held[name])

    def driving(self, names: tuple[str, ...]) -> Problem:
        """Return the problem in which some held joints are independent, after the others."""
        if not names:
            return self
        held = {name: value for name, value in self.held.items() if name not in names}
        return replace(self, independent=(*self.independent, *names), held=frozen(held))

    @cached_property
    def drives(self) -> tuple[str, ...]:
        """Names of the joints whose motion is prescribed."""
        return tuple(name for name in self.independent if name not in self.free)

    def refuse_free(self, what: str) -> None:
        """Refuse what needs the motion of all coordinates where some are free.

        Raises:
            MobilityError: some are.
        """
        if self.free:
            verb = "is" if len(self.free) == 1 else "are"
            raise MobilityError(
                f"{what} needs the motion of every coordinate, and {choices(self.free)} {verb} "
                "free; drive it or hold it, as scene.replace(drive=[*scene.drives, *scene.free]) "
                "does, or find its motion: Scene.simulate, Scene.equilibrium, cardan_dyn.vibration",
                mobility=len(self.free),
            )

    @cached_property
    def prescribed_columns(self) -> Array:
        """Velocity coordinates `(p,)` of the independent joints, then of those that are held."""
        names = (*self.independent, *self.held)
        return np.array(self.mechanism.coordinates.rates_of(names), dtype=int)

    @cached_property
    def passive_columns(self) -> Array:
        """Velocity coordinates, ascending, that are neither independent nor held."""
        passive = np.ones(self.mechanism.model.nv, dtype=bool)
        passive[self.prescribed_columns] = False
        return np.nonzero(passive)[0]

    @cached_property
    def acting(self) -> Acting:
        """What acts in the scene at rest: all that a sweep without other arguments needs to know.

        Made once, since sweeps of few positions would take as long to make it as to use it.
        """
        still = read_only(np.zeros(len(self.independent)))
        loads = self.joint_loads, self.link_loads
        return Acting(still, still, *loads, self.gravity, frozen({}), AT_ZERO)

    @cached_property
    def acting_everywhere(self) -> Acting | None:
        """The same over samples of any number and shape, None if a load has a shape of its own."""
        if any(self.acting.shapes.values()):
            return None
        everywhere = self.acting.flat((1,))
        for values in (everywhere.speeds, everywhere.gravity, everywhere.time):
            read_only(values)
        return everywhere

    def load_rows(self, efforts: Mapping[str, Array]) -> Array:
        """Return efforts `(N,)` or `(1,)` added at coordinates along all of them, `(…, nv)`."""
        count = max((len(effort) for effort in efforts.values()), default=1)
        rows = np.zeros((count, self.mechanism.model.nv))
        for name, effort in efforts.items():
            rows[:, self.mechanism.coordinates.named[name].rate] += effort
        return rows

    @cached_property
    def loads_everywhere(self) -> Array:
        """The `load_rows` of `acting_everywhere`."""
        assert self.acting_everywhere is not None
        return read_only(self.load_rows(self.acting_everywhere.joint_loads))

    @cached_property
    def held_row(self) -> Array:
        """Positions of the held joints, `(1, h)` [rad or m]."""
        return read_only(np.array([list(self.held.values())], dtype=float))

    @property
    def wanted_bodies(self) -> set[int] | None:
        """Bodies (0-based) whose joint wrenches are wanted, None for all."""
        if self.all_outputs:
            return None
        joints = self.mechanism.joints
        bodies = {joints[name].id - 1 for name in self.outputs}
        for loop in self.mechanism.loops:
            # A `fixed` loop moves no body; it is solved with the bodies that it connects.
            if loop.joint in self.outputs and not joints[loop.joint].parts:
                bodies |= {loop.predecessor - 1, loop.successor - 1}
        return bodies - {-1}

    @cached_property
    def element_forces(self) -> ElementForces | None:
        """What the elements exert; None without any."""
        if not self.elements:
            return None
        from ..elements.element_forces import ElementForces  # Most scenes have no elements.

        return ElementForces(self.mechanism, self.elements)

    @cached_property
    def element_bodies(self) -> frozenset[int]:
        """Bodies (0-based) whose motion is solved for the forces of elements alone.

        There are none where the outputs need all motion anyway.
        """
        if not (self.elements and self.wanted_bodies):
            return frozenset()
        mechanism = self.mechanism
        joints = (mechanism.drivable[name].joint for item in self.elements for name in item.joints)
        bodies = {mechanism.joints[name].id - 1 for name in joints}
        links = (name for item in self.elements for name in item.links)
        return frozenset(bodies | {mechanism.link_frames[name][0] - 1 for name in links}) - {-1}

    @cached_property
    def output_indices(self) -> Array | slice:
        """Index of every output among all wrenches, see `consecutive`."""
        indices = [self.mechanism.wrench_indices[name] for name in self.outputs]
        return consecutive(np.array(indices, dtype=int))


def _equal(first: object, second: object) -> bool:
    """Return whether two attributes of the same name are equal."""
    if isinstance(first, dict) and isinstance(second, dict):
        # The order counts: joints are brought to their positions one after the other.
        return list(first) == list(second) and all(map(_equal, first.values(), second.values()))
    if isinstance(first, np.ndarray):
        return np.array_equal(first, second)  # type: ignore[arg-type]
    return first is second or bool(first == second)
