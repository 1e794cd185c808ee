"""Universal joint: the two pins of a cross, and where they are."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...core.mechanism.joints import Part
from ...core.mechanism.mechanism import Mechanism
from ...kit.arrays import Array
from ...kit.errors import ModelError, choices

if TYPE_CHECKING:
    from ...core.results.motion import Motion

_PARALLEL = 0.1
"""Sine of the angle between two pins below which they make no cross."""


class PinAxis(NamedTuple):
    """A pin.

    Attributes:
        name: of the joint, or `joint.coordinate` of a joint of type `universal`.
        joint: that carries its wrench.
        part: its turn in the mechanism's model.
    """

    name: str
    joint: str
    part: Part


class CrossPlaces(NamedTuple):
    """Where the pins of a cross are, all in the world.

    Attributes:
        axes: `(2, N, 3)` unit vectors along the pins.
        offsets: `(2,)` from the origin of each pin's joint to its centre, along the axis [m]. Where
            the axes do not meet, the centres are the feet of their common normal.
        frames: `(2, N, 2, 3)` of each pin two unit vectors, fixed in the cross: t across the pin
            and the normal, and n along the normal, along which the cross passes its moment on.
    """

    axes: Array
    offsets: Array
    frames: Array


def is_universal(mechanism: Mechanism, name: str) -> bool:
    """Return whether a name is that of a universal joint, or of a link that might be a cross."""
    if name in mechanism.joints:
        return mechanism.joints[name].type == "universal"
    return name in mechanism.links


def universal_pins(mechanism: Mechanism, name: str) -> tuple[PinAxis, PinAxis]:
    """Return both pins of a universal joint.

    Args:
        mechanism: that has it.
        name: of a joint of type `universal`, or of the link that is the cross.
    """
    if name in mechanism.joints:
        joint = mechanism.joints[name]
        if joint.type != "universal":
            raise ModelError(
                f"joint {name!r} is of type {joint.type}; name a joint of type universal, or the "
                "link that is the cross"
            )
        first, second = (
            PinAxis(coordinate, name, part)
            for coordinate, part in zip(joint.coordinates, joint.parts, strict=True)
        )
        return first, second
    if name not in mechanism.links:
        raise ModelError(f"no link or joint {name!r}; {choices(mechanism.links, name)}")
    description = mechanism.description
    ends = {item.name: (item.parent, item.child) for item in description.joints}
    ends.update({loop.name: (loop.predecessor, loop.successor) for loop in description.loops})
    pins = [
        PinAxis(joint.name, joint.name, joint.parts[0])
        for joint in mechanism.joints.values()
        if name in ends[joint.name] and len(joint.parts) == 1 and joint.parts[0].kind == "revolute"
    ]
    if len(pins) != 2:
        raise ModelError(
            f"link {name!r} is no cross: {len(pins)} joints that turn about one axis hold it, "
            "not two"
        )
    return pins[0], pins[1]


def cross_places(motion: Motion, pins: tuple[PinAxis, ...]) -> CrossPlaces:
    """Return where the two pins of a cross are over `N` positions."""
    axes = np.array([_axis(motion, pin) for pin in pins])
    normal = np.cross(axes[0], axes[1])
    sine = np.linalg.norm(normal, axis=-1, keepdims=True)
    if np.min(sine) < _PARALLEL:
        raise ModelError(f"{pins[0].name!r} and {pins[1].name!r} are parallel, and make no cross")
    normal = normal / sine
    origins = [motion.joint_placement(pin.joint)[1][0] for pin in pins]
    between = origins[1] - origins[0]
    # Of the lines o₁ + d₁ a₁ and o₂ + d₂ a₂ the points nearest to each other.
    first, second = axes[:, 0]
    skew = np.cross(first, second) / sine[0] ** 2
    offsets = np.array([np.cross(between, second) @ skew, np.cross(between, first) @ skew])
    frames = np.stack([np.cross(normal, axes), np.broadcast_to(normal, axes.shape)], axis=2)
    return CrossPlaces(axes, offsets, frames)


def _axis(motion: Motion, pin: PinAxis) -> Array:
    """Return the axis of a pin in the world `(N, 3)`."""
    rotation = motion.joint_placement(pin.joint)[0]
    joint = motion.mechanism.joint(pin.joint)
    if pin.part is joint.parts[-1]:
        return np.asarray(rotation @ pin.part.axis)
    # The joint's frame stays with the child, which has turned about the second axis.
    angle = np.asarray(motion.position(pin.joint))[:, 1:]
    first, second = (part.axis for part in joint.parts)
    along = second * (first @ second)
    turned = along + np.cos(angle) * (first - along) - np.sin(angle) * np.cross(second, first)
    return np.asarray(np.einsum("nij,nj->ni", rotation, turned))
