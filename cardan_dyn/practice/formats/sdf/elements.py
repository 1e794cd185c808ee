"""Elements of SDFormat: numbers, words and poses, which stand as text between tags."""

from __future__ import annotations

import math
from collections.abc import Iterable
from xml.etree.ElementTree import Element

import numpy as np

from ....core.description.elements import bound, numbers, only, rotation, rotation_of_quaternion
from ....kit.arrays import Array
from ....kit.errors import ModelError

_WORDS = {"true": True, "1": True, "false": False, "0": False}
"""Truth values, in small letters."""
_UNLIMITED = 1e16
"""Magnitude from which on a limit counts as none: older versions write this in the place of it."""
_NO_LIMIT = {1.0: ("", "inf", "+inf", "infinity"), -1.0: ("", "-inf", "-infinity")}
"""Sign of a limit to the words, in small letters, that say that there is none."""


def inside(element: Element, tag: str, at: str) -> Element:
    """Return the child element of a kind; an empty one where there is none."""
    child = only(element, tag, at)
    return Element(tag) if child is None else child


def text(element: Element, tag: str, default: str, at: str) -> str:
    """Return the text of a child element without blanks around it; empty means the default."""
    return (inside(element, tag, at).text or "").strip(" \t\r\n") or default


def number(element: Element, tag: str, default: str, at: str) -> float:
    """Return the number that a child element states."""
    return float(numbers(text(element, tag, default, at), 1, default, f"{at}: {tag}")[0])


def flag(value: str, at: str) -> bool:
    """Return whether a word is true.

    Raises:
        ModelError: it is no truth value.
    """
    word = value.strip().lower()
    if word not in _WORDS:
        raise ModelError(f"{at} is {value!r}, expected true or false")
    return _WORDS[word]


def acting(element: Element, tags: Iterable[str], name: str, where: str) -> list[str]:
    """Return what child elements state but zeros, behind the name of what they belong to."""
    values = {tag: number(element, tag, "0", f"{where}: {name}") for tag in tags}
    stated = ", ".join(f"{tag} {value:g}" for tag, value in values.items() if value)
    return [f"{name}: {stated}"] if stated else []


def limit(element: Element, tag: str, sign: float, at: str) -> float:
    """Return a limit of an axis; `sign` times infinite where there is none.

    Args:
        element: the `<limit>`.
        tag: which of them.
        sign: -1 for the lower limit of position, else 1.
        at: how messages name the axis.
    """
    value = text(element, tag, "", at)
    if value.lower() in _NO_LIMIT[sign]:
        return sign * math.inf
    found = bound(value, sign, "", f"{at}: limit {tag}")
    is_negative_rate = tag in ("effort", "velocity") and found < 0.0
    return sign * math.inf if sign * found >= _UNLIMITED or is_negative_rate else found


def base_of(element: Element) -> str:
    """Return the frame that an element's `<pose>` names; empty where it names none."""
    stated = element.find("pose")
    return "" if stated is None else stated.get("relative_to", "")


def pose(element: Element, at: str) -> Array:
    """Return the `(4, 4)` placement that an element's `<pose>` states; identity without one.

    Raises:
        ModelError: these are not six numbers, or seven with a quaternion.
    """
    stated, result = inside(element, "pose", at), np.eye(4)
    if not (stated.text or "").strip():
        return result
    at = f"{at}: pose"
    kind = stated.get("rotation_format", "euler_rpy")
    in_degrees = flag(stated.get("degrees", "false"), f"{at}: degrees")
    if kind == "quat_xyzw":
        if in_degrees:
            raise ModelError(f"{at}: degrees has no meaning for quat_xyzw")
        values = numbers(stated.text, 7, "", at)
        result[:3, :3] = rotation_of_quaternion(np.roll(values[3:], 1), at)
    elif kind == "euler_rpy":
        values = numbers(stated.text, 6, "", at)
        angles = values[3:] * (math.pi / 180.0 if in_degrees else 1.0)
        result[:3, :3] = rotation(*angles.tolist())
    else:
        raise ModelError(f"{at}: rotation_format {kind!r} is unknown: euler_rpy or quat_xyzw")
    result[:3, 3] = values[:3]
    return result
