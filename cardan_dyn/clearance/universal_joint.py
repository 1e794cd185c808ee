"""Universal joint: the two pins of a cross, and what their bearings carry."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import ModelError, choices
from ..mechanism.joints import Part
from ..mechanism.mechanism import Mechanism

if TYPE_CHECKING:
    from ..results.sweep import Sweep

_PARALLEL = 0.1
"""Sine of the angle between two pins below which they make no cross."""
_SIGNS = {"+": 1.0, "-": -1.0}


class UniversalPin(NamedTuple):
    """A pin of a cross.

    Attributes:
        name: of the joint, or `joint.coordinate` of a joint of type `universal`.
        joint: that carries its wrench.
        part: its turn in the mechanism's model.
    """

    name: str
    joint: str
    part: Part


class Bearing(NamedTuple):
    """A bearing of a cross.

    Attributes:
        name: of the pin, with `+` or `-`: the end to which its axis points, or the other.
        pin: 0 or 1.
        sign: +1 or -1.
    """

    name: str
    pin: int
    sign: float


class Pins(NamedTuple):
    """Where the pins of a cross are during a sweep, all in the world.

    Attributes:
        axes: `(2, N, 3)` unit vectors along the pins.
        offsets: `(2,)` from the origin of each pin's joint to its centre, along the axis [m]. Where
            the axes do not meet, the centres are the feet of their common normal.
        normal: `(N, 3)` unit vector along which the cross passes its moment on.
        across: `(2, N, 3)` unit vectors t, across each pin and the normal. Both are fixed in the
            cross.
    """

    axes: Array
    offsets: Array
    normal: Array
    across: Array


def universal_pins(mechanism: Mechanism, name: str) -> tuple[UniversalPin, UniversalPin]:
    """Return both pins of a universal joint.

    Args:
        mechanism: that has it.
        name: of a joint of type `universal`, or of the link that is the cross.

    Raises:
        ModelError: it is none.
    """
    if name in mechanism.joints:
        joint = mechanism.joints[name]
        if joint.type != "universal":
            raise ModelError(
                f"joint {name!r} is of type {joint.type}; name a joint of type universal, or the "
                "link that is the cross"
            )
        first, second = (
            UniversalPin(coordinate, name, part)
            for coordinate, part in zip(joint.coordinates, joint.parts, strict=True)
        )
        return first, second
    if name not in mechanism.links:
        raise ModelError(f"no link or joint {name!r}; {choices(mechanism.links, name)}")
    description = mechanism.description
    ends = {item.name: (item.parent, item.child) for item in description.joints}
    ends.update({loop.name: (loop.predecessor, loop.successor) for loop in description.loops})
    pins = [
        UniversalPin(joint.name, joint.name, joint.parts[0])
        for joint in mechanism.joints.values()
        if name in ends[joint.name] and len(joint.parts) == 1 and joint.parts[0].kind == "revolute"
    ]
    if len(pins) != 2:
        raise ModelError(
            f"link {name!r} is no cross: {len(pins)} joints that turn about one axis hold it, "
            "not two"
        )
    return pins[0], pins[1]


def pins_of(sweep: Sweep, pins: tuple[UniversalPin, UniversalPin]) -> Pins:
    """Return where the pins of a cross are.

    Args:
        sweep: over `N` positions, with both pins among its outputs.
        pins: see `universal_pins`.

    Raises:
        ModelError: the pins are parallel.
    """
    axes = np.array([_axis(sweep, pin) for pin in pins])
    normal = np.cross(axes[0], axes[1])
    sine = np.linalg.norm(normal, axis=-1, keepdims=True)
    if np.min(sine) < _PARALLEL:
        raise ModelError(f"{pins[0].name!r} and {pins[1].name!r} are parallel, and make no cross")
    normal = normal / sine
    between = (sweep.origin(pins[1].joint) - sweep.origin(pins[0].joint))[0]
    # Of the lines o₁ + d₁ a₁ and o₂ + d₂ a₂ the points nearest to each other.
    first, second = axes[:, 0]
    skew = np.cross(first, second) / sine[0] ** 2
    offsets = np.array([np.cross(between, second) @ skew, np.cross(between, first) @ skew])
    return Pins(axes, offsets, normal, np.cross(normal, axes))


def _axis(sweep: Sweep, pin: UniversalPin) -> Array:
    """Return the axis of a pin in the world `(N, 3)`."""
    rotation = sweep.rotation(pin.joint)
    joint = sweep.mechanism.joint(pin.joint)
    if pin.part is joint.parts[-1]:
        return np.asarray(rotation @ pin.part.axis)
    # The joint's frame stays with the child, which has turned about the second axis.
    column = sweep.mechanism.coordinates.columns[pin.joint].start + 1
    angle = sweep.motion._x[:, column, None]
    first, second = (part.axis for part in joint.parts)
    along = second * (first @ second)
    turned = along + np.cos(angle) * (first - along) - np.sin(angle) * np.cross(second, first)
    return np.asarray(np.einsum("nij,nj->ni", rotation, turned))


def bearing_forces(
    sweep: Sweep,
    pins: tuple[UniversalPin, UniversalPin],
    placed: Pins,
    bearings: tuple[Bearing, ...],
    radii: Array,
) -> Array:
    """Return what bearings carry across their pins, F± = f/2 ± (m × a)/(2 r).

    Args:
        sweep: over `N` positions.
        pins: of the cross.
        placed: where they are.
        bearings: of which the forces are wanted.
        radii: `(2,)` from the centre of the joint to the middle of the bearings of each pin [m].

    Returns:
        `(N, B, 2)` along t and the normal [N], exerted on the pin's child link.

    Source:
        Own derivation: a pin held at two places by forces across it.
    """
    found = np.empty((placed.axes.shape[1], len(bearings), 2))
    for column, bearing in enumerate(bearings):
        axis, across = placed.axes[bearing.pin], placed.across[bearing.pin]
        wrench = sweep.wrench(pins[bearing.pin].joint, "world")
        moment = wrench.moment - placed.offsets[bearing.pin] * np.cross(axis, wrench.force)
        pair = np.cross(moment, axis) / (2.0 * radii[bearing.pin])
        force = 0.5 * wrench.force + bearing.sign * pair
        found[:, column, 0] = np.sum(force * across, axis=1)
        found[:, column, 1] = np.sum(force * placed.normal, axis=1)
    return found


def bearings_of(
    pins: tuple[UniversalPin, UniversalPin], asked: tuple[str, ...]
) -> tuple[Bearing, ...]:
    """Return bearings by their names, in the order of the pins.

    Args:
        pins: of the cross.
        asked: names of bearings, or of pins for both of theirs.

    Raises:
        ModelError: one is unknown.
    """
    known = {
        f"{pin.name}{sign}": Bearing(f"{pin.name}{sign}", index, value)
        for index, pin in enumerate(pins)
        for sign, value in _SIGNS.items()
    }
    both = {pin.name: [f"{pin.name}{sign}" for sign in _SIGNS] for pin in pins}
    wanted = set()
    for name in asked:
        if name not in known and name not in both:
            raise ModelError(f"no bearing {name!r}; {choices([*both, *known], name)}")
        wanted.update(both.get(name, [name]))
    return tuple(bearing for name, bearing in known.items() if name in wanted)
