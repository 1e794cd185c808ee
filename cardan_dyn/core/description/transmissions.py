"""Transmissions: rotors that the `<actuator>` of a URDF's `<transmission>` states.

Drake has words for them, in a namespace of its own: `<drake:rotor_inertia value="..."/>` [kg·m²]
and `<drake:gear_ratio value="..."/>`, 1 without, by which the rotor turns faster than the joint.
Along a slide the ratio is in rad/m. `<mechanicalReduction>` of ROS says nothing of any inertia.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from xml.etree.ElementTree import Element

from ...kit.errors import ModelError, choices
from .description import JointDescription
from .elements import SINGLE_TYPES, armature, number, only

_INERTIA, _RATIO = "rotor_inertia", "gear_ratio"


def with_rotors(
    robot: Element, joints: Sequence[JointDescription], where: str
) -> list[JointDescription]:
    """Return joints whose armatures have the rotors of transmissions in them.

    Raises:
        ModelError: a rotor does not turn with one joint alone that has one coordinate, its inertia
            is negative, or it is stated twice.
    """
    found = {joint.name: joint for joint in joints}
    single = [joint.name for joint in joints if joint.type in SINGLE_TYPES]
    every = (
        (item, of) for item in robot.findall("transmission") for of in item.findall("actuator")
    )
    for transmission, actuator in every:
        at = f"{where}: transmission {transmission.get('name')!r}: "
        rotor, gear = (only(actuator, f"{{*}}{tag}", at[:-2]) for tag in (_INERTIA, _RATIO))
        if rotor is None:
            continue
        ratio = 1.0 if gear is None else number(gear.get("value"), "", f"{at}{_RATIO}")
        at += _INERTIA
        names = [joint.get("name", "") for joint in transmission.findall("joint")]
        if len(names) != 1 or names[0] not in single:
            raise ModelError(
                f"{at}: it belongs to one joint with one coordinate, not to {choices(names)}; "
                f"joints: {choices(single, names[0] if names else None)}"
            )
        reflected = number(rotor.get("value"), "", at) * ratio**2
        joint = found[names[0]]
        total = reflected + sum(joint.armature)
        armature([reflected], joint.type, at)
        found[joint.name] = replace(joint, armature=armature([total], joint.type, at))
    return list(found.values())
