"""Origins: lengths and angles of a description by name, and the description in which they can move.

An adjustable joint is one that the description names itself; to move it is to make it what it says.
`origin:JOINT.x` (`y`, `z`, `roll`, `pitch`, `yaw`) is where a joint of the tree is on its parent,
as its text gives it; `origin:LOOP.predecessor.x` and `origin:LOOP.successor.x` where a loop is on
its links. To move one is to put a slide or a turn between the joint and the link that carries it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import reduce
from typing import Any, NamedTuple

import numpy as np
import pinocchio

from ...kit.arrays import EPS, Array
from ...kit.errors import ArgumentError, ModelError, choices
from .description import Description, JointDescription, JointOrLoop, LinkDescription
from .digits import precision_of

PREFIX = "origin:"
_SLIDES, _TURNS = ("x", "y", "z"), ("yaw", "pitch", "roll")
"""Components in the order in which they follow one another, from the carrying link on."""
COMPONENTS = (*_SLIDES, *reversed(_TURNS))


class Origin(NamedTuple):
    """A length or an angle in the placement of a joint.

    Attributes:
        name: as it is asked for.
        joint: the joint or loop.
        carrier: attribute of that with the name of the carrying link.
        field: attribute with the `(4, 4)` placement in it [m].
        component: one of `COMPONENTS`.
        axis: `(3,)` along or about which the joint's frame moves, in the carrying link's axes.
    """

    name: str
    joint: JointOrLoop
    carrier: str
    field: str
    component: str
    axis: Array

    @property
    def turns(self) -> bool:
        """Whether it is an angle."""
        return self.component in _TURNS

    @property
    def placement(self) -> Array:
        """Where the joint's frame is in the carrying link `(4, 4)` [m]."""
        return np.asarray(getattr(self.joint, self.field))

    def displaced(self, description: Description, by: float) -> Description:
        """Return the description in which it is greater by some amount [m or rad]."""
        moved = self.placement.copy()
        placed: dict[str, Any] = {self.field: moved}
        if self.turns:
            moved[:3, :3] = pinocchio.exp3(by * self.axis) @ moved[:3, :3]
        else:
            moved[:3, 3] += by * self.axis
        return _with(description, replace(self.joint, **placed))


def places_of(description: Description) -> dict[str, tuple[JointOrLoop, str, str]]:
    """Return the joints and loops to carrier and field of an `Origin`, by the names of places."""
    return {
        item.name if carrier == "parent" else f"{item.name}.{carrier}": (item, carrier, field)
        for item in description.joints_and_loops
        for carrier, field in item.ENDS
    }


def origin_of(description: Description, name: str) -> Origin:
    """Return what a name says.

    Raises:
        ModelError: no such joint, or its rotation does not tell the angle.
        ArgumentError: no such component.
    """
    places = places_of(description)
    joint, _, component = name.removeprefix(PREFIX).rpartition(".")
    if joint not in places:
        raise ModelError(f"{name!r}: joints are {choices(places, joint)}", name=joint)
    if component not in COMPONENTS:
        raise ArgumentError(f"{name!r}: name a component: {choices(COMPONENTS)}")
    item, carrier, field = places[joint]
    rotation = getattr(item, field)[:3, :3]
    across = np.array([-rotation[1, 0], rotation[0, 0], 0.0])
    level = float(np.linalg.norm(across))
    # A text of 1.5708 means a right angle: that it is greater by its last digit decides no sign.
    if component == "pitch" and level < np.sqrt(EPS) + precision_of(description).angle:
        raise ModelError(
            f"{name!r}: at a pitch of 90°, roll and yaw turn about the same axis, so that the "
            "rotation does not tell the yaw, which decides what the pitch turns about; "
            "take roll and yaw, or place the joint otherwise"
        )
    # Whatever angles write a rotation, these axes are the same.
    axes = {
        **dict(zip(_SLIDES, np.eye(3), strict=True)),
        "yaw": np.array([0.0, 0.0, 1.0]),
        "pitch": across / (level or 1.0),
        "roll": rotation[:, 0],
    }
    return Origin(name, item, carrier, field, component, axes[component])


def with_origins(description: Description, names: Iterable[str]) -> Description:
    """Return the description in which some lengths and angles are joints of these names.

    Where they are zero, everything is where it was.

    Args:
        description: without any such joints.
        names: of adjustable joints; of others see `origin_of`, with its errors.
    """
    every, asked = (*_SLIDES, *_TURNS), {*names}
    for joint in description.joints:
        if joint.adjustable and joint.name in asked:
            asked.remove(joint.name)
            opened = replace(joint, type=joint.adjustable, adjustable="")
            description = _with(description, opened)
    wanted = [origin_of(description, name) for name in sorted(asked)]
    wanted.sort(key=lambda origin: every.index(origin.component))
    return reduce(_opened, wanted, description)


def _opened(description: Description, origin: Origin) -> Description:
    """Return a description with the joint of one more length or angle nearest to its own joint."""
    joint = next(item for item in description.joints_and_loops if item.name == origin.joint.name)
    placement, own = np.eye(4), getattr(joint, origin.field).copy()
    if origin.turns:  # About an axis through the joint's origin.
        placement[:3, 3], own[:3, 3] = own[:3, 3], 0.0
    carried: dict[str, Any] = {origin.carrier: origin.name, origin.field: own}
    between = JointDescription(
        name=origin.name,
        type="revolute" if origin.turns else "prismatic",
        parent=getattr(joint, origin.carrier),
        child=origin.name,
        origin=placement,
        axis=origin.axis,
    )
    order = list(description.order)
    order.insert(order.index(joint.name) if joint.name in order else len(order), origin.name)
    description = _with(description, replace(joint, **carried))
    return replace(
        description,
        links=(*description.links, LinkDescription(origin.name)),
        joints=(*description.joints, between),
        order=tuple(order),
        origins=(*description.origins, origin.name),
    )


def adjusted(description: Description, values: Mapping[str, float]) -> Description:
    """Return the description whose lengths and angles have the values that a scene holds them at.

    Args:
        description: without any that are joints.
        values: of adjustable joints, which stay adjustable from there, and of others; see
            `origin_of`, with its errors [m or rad].
    """
    own = {item.name for item in description.joints if item.adjustable} & {*values}

    def moved(item: Any) -> Any:
        if item.name not in own:
            return item
        movement = _movement(item.adjustable, item.axis, values[item.name])
        return replace(item, origin=item.origin @ movement)

    others = [name for name in values if name not in own]
    return without_origins(with_origins(description, others), values).with_each(moved)


def without_origins(description: Description, values: Mapping[str, float] = {}) -> Description:
    """Return the description in which no length or angle is a joint.

    Args:
        description: with such joints.
        values: where they stand [m or rad]; zero for what is not named.
    """
    between = {item.name: item for item in description.joints if item.name in description.origins}

    def fixed(item: Any) -> Any:
        for carrier, field in item.ENDS:
            while (link := getattr(item, carrier)) in between:
                moving = between[link]
                placed = getattr(item, field)
                if value := values.get(link):
                    placed = _movement(moving.type, moving.axis, value) @ placed
                item = replace(item, **{carrier: moving.parent, field: moving.origin @ placed})
        return item

    description = description.with_each(fixed)
    return replace(
        description,
        links=tuple(item for item in description.links if item.name not in between),
        joints=tuple(item for item in description.joints if item.name not in between),
        order=tuple(name for name in description.order if name not in between),
        origins=(),
    )


def _movement(kind: str, axis: Array, value: float) -> Array:
    """Return the `(4, 4)` displacement by a slide [m] or turn [rad] along or about an axis."""
    result = np.eye(4)
    if kind == "prismatic":
        result[:3, 3] = value * axis
    else:
        result[:3, :3] = pinocchio.exp3(value * axis)
    return result


def _with(description: Description, changed: JointOrLoop) -> Description:
    """Return a description with a joint or loop in place of that of its name."""
    return description.with_each(lambda item: changed if item.name == changed.name else item)
