"""Transmissions: what motors of a URDF bring along, their rotors and the bounds of their efforts.

Rotors stand in the `<actuator>` of a `<transmission>`.

Drake has words for them, in a namespace of its own: `<drake:rotor_inertia value="..."/>` [kg·m²]
and `<drake:gear_ratio value="..."/>`, 1 without, by which the rotor turns faster than the joint.
Along a slide the ratio is in rad/m. `<mechanicalReduction>` of ROS says nothing of any inertia.

`<ros2_control>` bounds the efforts that a joint is commanded: `<command_interface name="effort">`
with `<param name="min">` and `<param name="max">` [N·m or N].
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from xml.etree.ElementTree import Element

from ...kit.errors import ModelError, choices
from .description import UNBOUNDED, JointDescription
from .elements import SINGLE_TYPES, armature, bound, number, only

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


def with_commanded_efforts(
    robot: Element, joints: Sequence[JointDescription], where: str
) -> list[JointDescription]:
    """Return joints whose limits of effort are no wider than those of `<ros2_control>`.

    Limits of zero are none, as URDF requires some.

    Raises:
        ModelError: a bound is no number, or nothing lies between both.
    """
    found = {joint.name: joint for joint in joints}
    for element in robot.iterfind("ros2_control/joint"):
        joint = found.get(element.get("name", ""))
        for command in element.iterfind("command_interface[@name='effort']"):
            at = f"{where}: ros2_control: joint {element.get('name')!r}: effort"
            stated = {item.get("name"): (item.text or "").strip() for item in command}
            least, greatest = (
                bound(stated.get(name), sign, repr(sign * sys.float_info.max), f"{at} {name}")
                for name, sign in (("min", -1.0), ("max", 1.0))
            )
            if not least <= greatest:
                raise ModelError(f"{at}: min {least:g} is above max {greatest:g}")
            if joint is not None:
                ends = joint.limits.efforts if any(joint.limits.efforts) else UNBOUNDED
                limits = replace(
                    joint.limits,
                    least_effort=max(least, ends[0]),
                    effort=min(greatest, ends[1]),
                )
                joint = found[joint.name] = replace(joint, limits=limits)
    return list(found.values())
