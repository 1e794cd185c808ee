"""Descriptions whose numbers are all wrong, from which nothing can be taken over."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from typing import TypeVar

import numpy as np

Item = TypeVar("Item")


def disturbed(item: Item) -> Item:
    """Return a record in which every number is wrong that a text states.

    Not limits, damping, friction and springs, which the proof does not use; not the axes of joints
    that have none.
    """
    kept = {"limits", "damping", "friction", "stiffness", "rest", "child_placement", "source"}
    if getattr(item, "type", "") in ("fixed", "floating"):
        kept |= {"axis", "axis_2"}
    changes = {}
    for field in fields(item):  # type: ignore[arg-type]
        value = getattr(item, field.name)
        if field.name in kept:
            continue
        if isinstance(value, (float, np.ndarray)):
            changes[field.name] = value + 7.0
        elif isinstance(value, tuple):
            changes[field.name] = tuple(
                disturbed(part) if is_dataclass(part) else part for part in value
            )
    return replace(item, **changes)  # type: ignore[type-var]
