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
    for item in source.couplings:
        if coupled := {item.predecessor, item.successor}.intersection(types):
            raise ModelError(
                f"joint {min(coupled)!r} cannot have clearance: a coupling depends on it"
            )
        if item.higher:
            raise ModelError(
                f"coupling {item.name!r} has a ratio that changes, beside which no joint opens; "
                "leave it out, or hold its joints"
            )

    def renamed(name: str) -> str:
        return f"{name}.turn" if name in types else name

    def of_opened(element: Any) -> Any:
        names = [name for name in element.joints if name in types]
        return replace(element, joint=renamed(names[0])) if names else element

    description = _with_rotor(source, scene.drives[0], rotor) if rotor else source
    mechanism = Mechanism(description.with_types(types))
    mechanism = mechanism.variant(cardan=scene.mechanism.coordinates.cardan)
    contacts: dict[str, tuple[int, ...]] = {}
    elements = [of_opened(item) for item in scene.elements]
    for pin in pins:
        added = _contacts(source, pin)
        contacts[pin.joint] = tuple(range(len(elements), len(elements) + len(added)))
        elements += added
    start: dict[str, Any] = {
        name: np.append(np.zeros(mechanism.joint(name).nv - 1), value) if name in types else value
        for name, value in scene.configuration().positions.items()
    }
    drive = renamed(scene.drives[0])
    result = Scene(
        mechanism,
        drive=drive,
        free=_free_coordinates(scene, mechanism, list(types)),
        held={renamed(name): value for name, value in scene.held.items()},
        loads={renamed(name): value for name, value in scene.loads.items()},
        gravity=scene.gravity,
        near=start,
        elements=elements,
    )
    return Opened(result, drive, contacts)


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


def _free_coordinates(scene: Scene, mechanism: Mechanism, joints: Sequence[str]) -> list[str]:
    """Return coordinates of open joints that decide how the pins move."""
    closed, coordinates = scene.mechanism, scene.mechanism.coordinates
    freedoms = {
        closed.joint(joint).parts[0].id: mechanism.joint(joint).parts[:-1] for joint in joints
    }
    opened = OpenedMechanism(
        closed,
        {body: [(part.kind, part.axis) for part in parts] for body, parts in freedoms.items()},
        coordinates.rates_of([scene.drives[0], *scene.held]),
        {},
    )
    rates = opened.ways(scene.configuration().x)
    names: list[str] = []
    rows: list[Array] = []
    for joint, (body, parts) in zip(joints, freedoms.items(), strict=True):
        slides = np.array([part.kind == "prismatic" for part in parts])
        scale = np.where(slides, closed.characteristic_length, 1.0)
        own = rates[opened.added[body]] / scale[:, None]
        if np.linalg.norm(own) < NOTHING:
            raise ModelError(
                f"the other joints hold the pin of joint {joint!r}, whatever clearance it has; a "
                "joint whose pin has two bearings opens with radius={name: distance}"
            )
        names += mechanism.joint(joint).coordinates[:-1]
        rows.append(own)
    chosen = _independent(np.concatenate(rows))
    if len(chosen) < rates.shape[1]:
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
        places = [(pin.reach, f"{pin.joint}+"), (-pin.reach, f"{pin.joint}-")]
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
