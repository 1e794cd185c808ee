"""Digits: with what precision the numbers of a description are written.

A text states no errors, but how many digits it has: a length of 0.123457 is off by half a millionth
at most, an angle of 1.5708 that stands for a right one by four. Numbers of few digits, such as 0.15
or 0.5, are taken as exact.
"""

from __future__ import annotations

import math
from decimal import Decimal, InvalidOperation
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterator
    from xml.etree.ElementTree import Element

    from .description import Description

_ROUNDED = 4
"""Digits of a number from which on it counts as rounded."""
_ANGLE, _DIGITS_OF_ANGLE = math.pi / 12.0, 3
"""Multiples of what angles mean that differ from them by their last digit, from three digits on."""
_ELSEWHERE = frozenset(
    [
        "inertial",
        "visual",
        "collision",
        "geom",
        "asset",
        "camera",
        "light",
        "sensor",
        "actuator",
        "default",
        "keyframe",
    ]
)
"""Elements whose numbers do not place joints."""
_PLACES, _ANGLES, _UNITS = (
    frozenset(names.split()) for names in ("xyz pos anchor", "rpy euler", "axis quat xyaxes zaxis")
)
"""Attributes, or names of elements, that are lengths [m], angles, or numbers of size one."""


class Precision(NamedTuple):
    """By how much numbers of a description may be off.

    Attributes:
        length: [m].
        angle: [rad].
    """

    length: float
    angle: float


def precision_of(description: Description) -> Precision:
    """Return the precision of a description's text; zeros where it has no rounded numbers."""
    return Precision(0.0, 0.0) if description.text is None else _precision(description.text.text)


@lru_cache(maxsize=1)  # Each pitch of a description asks.
def _precision(text: str) -> Precision:
    from xml.etree.ElementTree import fromstring

    root = fromstring(text)
    degrees = root.tag == "mujoco" and all(
        item.get("angle", "degree") == "degree" for item in root.iter("compiler")
    )
    length = angle = 0.0
    for name, words in _numbers(root):
        for index, word in enumerate(words):
            if name in _PLACES or (name == "pose" and index < 3):
                length = max(length, _half_of_last(word))
            elif name in _UNITS:
                angle = max(angle, _half_of_last(word))
            elif name == "euler" and degrees:
                angle = max(angle, math.radians(_half_of_last(word)))
            elif name in _ANGLES or name == "pose":
                angle = max(angle, _half_of_last(word), _off_a_whole_part(word))
    return Precision(length, angle)


def _numbers(element: Element) -> Iterator[tuple[str, list[str]]]:
    """Yield names and words of what places joints."""
    is_axis = element.tag in ("axis", "axis2")
    for name, text in element.attrib.items():
        yield "axis" if is_axis and name == "xyz" else name, text.split()
    if element.text:
        yield element.tag, element.text.split()
    for child in element:
        if is_axis and child.tag == "xyz":
            yield "axis", (child.text or "").split()
        elif child.tag not in _ELSEWHERE:
            yield from _numbers(child)


def _digits(word: str) -> tuple[int, float]:
    """Return how many digits a number has, and the half of its last one."""
    try:
        number = Decimal(word).as_tuple()
    except InvalidOperation:
        return 0, 0.0
    if not isinstance(number.exponent, int) or number.exponent >= 0:
        return 0, 0.0
    return len(number.digits) if any(number.digits) else 0, 0.5 * 10.0**number.exponent


def _half_of_last(word: str) -> float:
    """Return half of the last digit of a number that counts as rounded, else zero."""
    digits, half = _digits(word)
    return half if digits >= _ROUNDED else 0.0


def _off_a_whole_part(word: str) -> float:
    """Return how far an angle is off one that it means, zero where it means none."""
    digits, half = _digits(word)
    if digits < _DIGITS_OF_ANGLE:
        return 0.0
    angle = float(word)
    off = abs(angle - _ANGLE * round(angle / _ANGLE))
    return off if off <= half else 0.0
