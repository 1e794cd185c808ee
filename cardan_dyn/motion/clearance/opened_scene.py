"""Opened scene: a scene in which some pins are free in the clearance of their bushes.

The joint that turned about one axis slides across it as well (`planar`); or, if its pin has two
bearings at a distance, it slides and tilts (`loose`) and is held along its axis alone. What is then
free to move are further drives, which a simulation leaves to the contact.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...core.elements.contact_laws import ContactLaw
from ...core.elements.pin_contact import PinContact
from ...core.mechanism.mechanism import Mechanism
from ...kit.arrays import NOTHING, Array, inverse
from ...kit.errors import ArgumentError, ModelError, choices
from ...scene.scene import Scene
from .opened_mechanism import OpenedMechanism

if TYPE_CHECKING:
    from ...core.description.description import Description
    from ...core.mechanism.configuration import Configuration


class OpenPin(NamedTuple):
    """What is free in a joint.

    Attributes:
        joint: its name.
        clearance: difference 2 s of the diameters of bush and pin [m].
        law: of the contact.
        friction: coefficient.
        pin_radius: of the pin [m].
        reach: distance of both bearings from the joint's origin along its axis [m]; None for one
            bush in which the pin stays parallel to itself.
    """

    joint: str
    clearance: float
    law: ContactLaw
    friction: float
    pin_radius: float
    reach: float | None

    @property
    def type(self) -> str:
        """Type of the joint once it is open."""
        return "planar" if self.reach is None else "loose"


class Opened(NamedTuple):
    """A scene with open joints.

    Attributes:
        scene: driven like the scene with tight joints; what the clearance frees is free.
        drive: name of the drive.
        contacts: joint to the indices of its contacts among the elements of the scene.
    """

    scene: Scene
    drive: str
    contacts: Mapping[str, tuple[int, ...]]


def opened(scene: Scene, pins: Sequence[OpenPin], rotor: float = 0.0) -> Opened:
    """Return a scene with open joints, closed as the scene with tight ones starts.

    Args:
        scene: with one drive.
        pins: of joints that turn about one axis.
        rotor: inertia that turns with the drive beside its link's [kg m²].
    """
    types = {item.joint: item.type for item in pins}
    source = scene.mechanism.description
    coupled = {
        name for item in source.couplings for name in (item.predecessor, item.successor)
    }.intersection(types)
    if coupled:
        raise ModelError(f"joint {min(coupled)!r} cannot have clearance: a coupling depends on it")
    curved = [item.name for item in source.couplings if item.higher]
    if curved:
        raise ModelError(
            f"coupling {curved[0]!r} has a ratio that changes, beside which no joint opens; "
            "leave it out, or hold its joints"
        )
    if rotor:
        source = _with_rotor(source, scene.drives[0], rotor)
    description = source.with_types(types)
    cardan = scene.mechanism.coordinates.cardan
    mechanism = Mechanism(description).variant(cardan=cardan)
    configuration = scene.configuration()
    x = _coordinates(configuration, mechanism, types)
    drive = _renamed(scene.drives[0], types)
    held = {_renamed(name, types): value for name, value in scene.held.items()}
    free = _free_coordinates(mechanism, x, [drive, *held], list(types))
    contacts: dict[str, tuple[int, ...]] = {}
    elements = [_renamed_element(item, types) for item in scene.elements]
    for item in pins:
        added = _contacts(source, item)
        contacts[item.joint] = tuple(range(len(elements), len(elements) + len(added)))
        elements += added
    positions = configuration.positions
    start: dict[str, Any] = {
        name: np.append(np.zeros(mechanism.joint(name).nv - 1), value) if name in types else value
        for name, value in positions.items()
    }
    result = Scene(
        mechanism,
        drive=drive,
        free=free,
        held=held,
        loads={_renamed(name, types): value for name, value in scene.loads.items()},
        gravity=scene.gravity,
        near=start,
        elements=elements,
    )
    return Opened(result, drive, contacts)


def _renamed(name: str, types: Mapping[str, str]) -> str:
    """Return the name of a coordinate once joints are open."""
    return f"{name}.turn" if name in types else name


def _renamed_element(element: Any, types: Mapping[str, str]) -> Any:
    """Return an element whose joint may be open now."""
    if any(name in types for name in element.joints):
        return replace(element, joint=_renamed(element.joint, types))
    return element


def _with_rotor(description: Description, drive: str, inertia: float) -> Description:
    """Return a description with an inertia that turns with the drive."""
    joint = next((item for item in description.joints if item.name == drive), None)
    if joint is None or joint.type not in ("revolute", "continuous"):
        raise ArgumentError(
            f"rotor turns with a drive that is a turning joint of the tree; {drive!r} is none"
        )
    turning = replace(joint, armature=(sum(joint.armature) + inertia,))
    joints = tuple(turning if item is joint else item for item in description.joints)
    # Its text knows nothing of the rotor.
    return replace(description, joints=joints, source=None)


def _coordinates(closed: Configuration, mechanism: Mechanism, types: Mapping[str, str]) -> Array:
    """Return the closed coordinates of the opened mechanism with the pins in the middle."""
    x = np.zeros(mechanism.coordinates.size)
    for name, columns in mechanism.coordinates.columns.items():
        own = closed.mechanism.coordinates.columns[name]
        if name in types:
            x[columns.stop - 1] = closed.x[own.start]
        else:
            x[columns] = closed.x[own]
    return x


def _free_coordinates(
    mechanism: Mechanism, x: Array, fixed: Sequence[str], joints: Sequence[str]
) -> list[str]:
    """Return coordinates of open joints that decide how the pins move."""
    coordinates = mechanism.coordinates
    scale = np.where(coordinates.rate_scale != 1.0, mechanism.characteristic_length, 1.0)
    opened = OpenedMechanism(mechanism, {}, coordinates.rates_of(fixed), {})
    ways = opened.ways(x).rates / scale[:, None]
    names = [name for joint in joints for name in mechanism.joint(joint).coordinates[:-1]]
    chosen = _independent(ways[[coordinates.named[name].rate for name in names]])
    for joint in joints:
        own = mechanism.joint(joint).coordinates[:-1]
        if np.linalg.norm(ways[[coordinates.named[name].rate for name in own]]) < NOTHING:
            raise ModelError(
                f"the other joints hold the pin of joint {joint!r}, whatever clearance it has; a "
                "joint whose pin has two bearings opens with radius={name: distance}"
            )
    if len(chosen) < ways.shape[1]:
        raise ModelError(
            f"with {choices(joints)} open, more than these pins can move; decide the motion of "
            "the rest first, by joints or held positions"
        )
    return [names[index] for index in chosen]


def _independent(rows: Array) -> list[int]:
    """Return which rows are independent, the greatest first, in ascending order."""
    left, chosen = rows.copy(), []
    for _ in range(min(rows.shape)):
        sizes = np.linalg.norm(left, axis=1)
        best = int(np.argmax(sizes))
        if sizes[best] < NOTHING:
            break
        direction = left[best] / sizes[best]
        left -= np.outer(left @ direction, direction)
        chosen.append(best)
    return sorted(chosen)


def _contacts(description: Description, pin: OpenPin) -> list[PinContact]:
    """Return the contacts of an open joint: one, or one for each of its bearings."""
    link_a, in_bush, link_b, in_pin, axis = _sides(description, pin.joint)
    places = [(0.0, pin.joint)]
    if pin.reach is not None:
        places = [
            (pin.reach, f"{pin.joint}+"),
            (-pin.reach, f"{pin.joint}-"),
        ]
    return [
        PinContact(
            link_a,
            in_bush[:3, 3] + in_bush[:3, :3] @ (distance * axis),
            in_bush[:3, :3] @ axis,
            link_b,
            in_pin[:3, 3] + in_pin[:3, :3] @ (distance * axis),
            pin.clearance,
            pin.law,
            friction=pin.friction,
            radius=pin.pin_radius,
            name=name,
        )
        for distance, name in places
    ]


def _sides(description: Description, joint: str) -> tuple[str, Array, str, Array, Array]:
    """Return both links of a joint, where its frame is in them, and its axis there."""
    for own in description.joints:
        if own.name == joint:
            return own.parent, own.origin, own.child, inverse(own.child_placement), own.axis
    item = next(loop for loop in description.loops if loop.name == joint)
    ends = item.predecessor_origin, item.successor_origin
    return item.predecessor, ends[0], item.successor, ends[1], item.axis
