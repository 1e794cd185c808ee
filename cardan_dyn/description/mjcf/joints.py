"""Joints of MJCF: one joint of a body."""

from __future__ import annotations

import numpy as np

from ...arrays import Array
from ...errors import ModelError
from ..description import JointDescription, Limits
from ..elements import Dynamics, numbers
from .elements import MOST_TERMS, Attributes, Compiler, keyword, number, several, unit

_TYPES = {"hinge": "revolute", "slide": "prismatic", "ball": "spherical", "free": "floating"}
"""MJCF's word for a joint to its type."""
DYNAMICS = {"damping", "stiffness", "frictionloss"}
"""Attributes of a joint of which elements can be made."""


def joint(
    attributes: Attributes,
    name: str,
    ends: tuple[str, str],
    body: Array,
    frame: Array,
    compiler: Compiler,
    at: str,
) -> tuple[JointDescription, str]:
    """Return a joint of a body, and a warning where its zero is elsewhere than in the file.

    Args:
        attributes: those of its class included.
        name: of the joint.
        ends: names of its two links.
        body: `(4, 4)` initial placement of the second link in the first.
        frame: `(4, 4)` placement of the frame around the joint in the second link.
        compiler: settings of the file.
        at: how messages name the joint.

    Raises:
        ModelError: an attribute is malformed.
    """
    kind = keyword(attributes.get("type", "hinge"), _TYPES, f"{at}: type")
    axis = np.array([1.0, 0.0, 0.0])
    if kind == "free":
        return JointDescription(name, _TYPES[kind], *ends, body, axis, axis), ""
    # The joint's frame has the axes of the child link, and its origin at the joint's pos there.
    joint_in_child, child_in_joint = np.eye(4), np.eye(4)
    point = numbers(attributes.get("pos"), 3, "0 0 0", f"{at}: pos")
    joint_in_child[:3, 3] = frame[:3, :3] @ point + frame[:3, 3]
    child_in_joint[:3, 3] = -joint_in_child[:3, 3]
    origin = body @ joint_in_child
    if kind == "ball":
        return JointDescription(name, _TYPES[kind], *ends, origin, axis, axis, child_in_joint), ""
    stated = numbers(attributes.get("axis"), 3, "0 0 1", f"{at}: axis")
    axis = frame[:3, :3] @ unit(stated, f"{at}: axis")
    initial = number(attributes, "ref", "0", at)
    limits = _limits(attributes, initial, compiler, at)
    scale = compiler.angle if kind == "hinge" else 1.0
    limits = Limits(limits.lower * scale, limits.upper * scale)
    joint_type = "continuous" if kind == "hinge" and limits == Limits() else _TYPES[kind]
    warning = f"{at}: its coordinate is zero where the file counts {initial:g} (ref)"
    taken = dynamics_of(attributes, kind, compiler, at)
    described = JointDescription(
        name, joint_type, *ends, origin, axis, axis, child_in_joint, limits, "", *taken
    )
    return described, warning if initial else ""


def dynamics_of(attributes: Attributes, kind: str, compiler: Compiler, at: str) -> Dynamics:
    """Return the damping, friction and spring that a joint states along its coordinate.

    The spring is at rest at `springref`, which counts as the file counts the joint; here the
    initial configuration is zero. What cannot be taken in is zero: see `untaken`.

    Args:
        attributes: those of its class included.
        kind: MJCF's word for its type.
        compiler: settings of the file.
        at: how messages name the joint.

    Raises:
        ModelError: an attribute is no number.
    """
    left = untaken(attributes, kind, at)
    damping, stiffness, friction = (
        0.0 if key in left else float(several(attributes, key, 1, MOST_TERMS, at)[:1].sum())
        for key in ("damping", "stiffness", "frictionloss")
    )
    if not stiffness:
        return Dynamics(damping, friction)
    initial = number(attributes, "ref", "0", at)
    rest = number(attributes, "springref", "0", at) - initial
    scale = compiler.angle if kind == "hinge" else 1.0
    return Dynamics(damping, friction, stiffness, rest * scale)


def untaken(attributes: Attributes, kind: str, at: str) -> set[str]:
    """Return which of the damping, stiffness and friction of a joint no element is made of.

    Those are all of a joint with a ball, higher terms of a polynomial, negative values, and what
    `springdamper` replaces.

    Raises:
        ModelError: an attribute is no number.
    """
    if kind not in ("hinge", "slide"):
        return set(DYNAMICS)
    left = set()
    for key in DYNAMICS:
        terms = several(attributes, key, 1, MOST_TERMS, at)
        if np.any(terms[1:]) or np.any(terms < 0.0):
            left.add(key)
    if np.any(several(attributes, "springdamper", 1, MOST_TERMS, at)):
        left |= {"damping", "stiffness"}
    return left


def _limits(attributes: Attributes, initial: float, compiler: Compiler, at: str) -> Limits:
    """Return the limits of a joint in the file's unit, counted from the initial configuration.

    Raises:
        ModelError: it is open whether they hold, or the range does not ascend.
    """
    lower, upper = numbers(attributes.get("range"), 2, "0 0", f"{at}: range").tolist()
    words = ("false", "true", "auto")
    limited = keyword(attributes.get("limited", "auto"), words, f"{at}: limited")
    if limited == "auto" and lower < upper and not compiler.autolimits:
        raise ModelError(f'{at}: without autolimits, a range needs limited="true" or "false"')
    if limited == "false" or (limited == "auto" and lower >= upper):
        return Limits()
    if lower >= upper:
        raise ModelError(f"{at}: range {lower:g} {upper:g} does not ascend")
    return Limits(lower - initial, upper - initial)
