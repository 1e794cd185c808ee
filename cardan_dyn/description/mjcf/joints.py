"""Joints of MJCF: one joint of a body."""

from __future__ import annotations

import numpy as np

from ...arrays import Array
from ...errors import ModelError
from ..description import JointDescription, Limits
from ..elements import numbers
from .elements import Attributes, Compiler, number, unit
from .schema import keyword

_TYPES = {"hinge": "revolute", "slide": "prismatic", "ball": "spherical", "free": "floating"}


def joint(
    attributes: Attributes,
    name: str,
    ends: tuple[str, str],
    body: Array,
    frame: Array,
    compiler: Compiler,
    at: str,
) -> tuple[JointDescription, str]:
    """Return a joint of a body, and a warning where its coordinate counts otherwise.

    Args:
        attributes: those of its class included.
        name: of the joint.
        ends: names of its two links.
        body: `(4, 4)` initial placement of the second link in the first.
        frame: `(4, 4)` placement of the frame around the joint in the second link.
        compiler: settings of the file.
        at: how messages name the joint.
    """
    kind = keyword(attributes.get("type", "hinge"), _TYPES, f"{at}: type")
    axis = np.array([1.0, 0.0, 0.0])
    if kind == "free":
        return JointDescription(name, _TYPES[kind], *ends, body, axis, axis), ""
    inside, back = np.eye(4), np.eye(4)
    point = numbers(attributes.get("pos"), 3, "0 0 0", f"{at}: pos")
    inside[:3, 3] = frame[:3, :3] @ point + frame[:3, 3]
    back[:3, 3] = -inside[:3, 3]
    origin = body @ inside
    if kind == "ball":
        return JointDescription(name, _TYPES[kind], *ends, origin, axis, axis, back), ""
    stated = numbers(attributes.get("axis"), 3, "0 0 1", f"{at}: axis")
    axis = frame[:3, :3] @ unit(stated, f"{at}: axis")
    initial = number(attributes, "ref", "0", at)
    limits = _limits(attributes, initial, compiler, at)
    scale = compiler.angle if kind == "hinge" else 1.0
    limits = Limits(limits.lower * scale, limits.upper * scale)
    typed = "continuous" if kind == "hinge" and limits == Limits() else _TYPES[kind]
    warning = f"{at}: its coordinate is zero where the file counts {initial:g} (ref)"
    found = JointDescription(name, typed, *ends, origin, axis, axis, back, limits)
    return found, warning if initial else ""


def _limits(attributes: Attributes, initial: float, compiler: Compiler, at: str) -> Limits:
    """Return the limits of a joint in the file's unit, from the initial configuration on."""
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
