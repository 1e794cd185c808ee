"""Visual: the shape of a link as plain data, and what the readers of all notations share."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...kit.arrays import Array
from ...kit.errors import ModelError
from .elements import numbers

SIZES = {
    "box": "three edges",
    "cylinder": "radius and length along z",
    "capsule": "radius, and length along z between the centres of its ends",
    "sphere": "radius",
    "ellipsoid": "three radii",
    "plane": "two edges, 0 for one without end",
    "mesh": "nothing; its file says it",
}
"""Kinds of visuals, and what their size lists."""
Rgba = tuple[float, float, float, float]


@dataclass(frozen=True, eq=False)
class Visual:
    """A shape of a link.

    Attributes:
        link: name of the link.
        kind: a key of `SIZES`.
        size: see `SIZES` [m].
        placement: `(4, 4)` in the link's frame [m].
        color: red, green, blue and opacity, 0 to 1; None where the text gives none.
        file: of a mesh, as the text names it.
        folder: where a relative path of it starts; None for text.
        mesh_placement: `(4, 4)` of the file's points, once scaled, in the visual's frame [m].
        scale: `(3,)` along the file's axes.
        part: name of the part of the file that is shown; empty for all of it.
    """

    link: str
    kind: str
    size: tuple[float, ...]
    placement: Array
    color: Rgba | None = None
    file: str = ""
    folder: Path | None = None
    mesh_placement: Array = field(default_factory=lambda: np.eye(4))
    scale: Array = field(default_factory=lambda: np.ones(3))
    part: str = ""


def read_each(
    items: Iterable[tuple[str, str]], reader: Callable[[int], Visual | None]
) -> tuple[list[Visual], list[str]]:
    """Return what a reader makes of each item, and messages about those that it refuses.

    Args:
        items: link and name of each visual.
        reader: gets the index of an item; None for what is not to be seen.
    """
    found, messages = [], []
    for index, (link, name) in enumerate(items):
        try:
            visual = reader(index)
        except ModelError as error:
            messages.append(f"link {link!r}: {name} is not drawn: {error}")
        else:
            found += [] if visual is None else [visual]
    return found, messages


def scale_of(text: str | None, at: str) -> Array:
    """Return the scale `(3,)` of a mesh along its axes; negative ones mirror it.

    Raises:
        ModelError: these are not three numbers other than zero.
    """
    scale = numbers(text, 3, "1 1 1", at)
    if not np.all(scale):
        raise ModelError(f"{at}: {text!r} would leave nothing of the mesh; give three factors")
    return scale


def positive(values: Array, at: str) -> tuple[float, ...]:
    """Return lengths; raise a `ModelError` if one is not positive."""
    if not np.all(values > 0.0):
        raise ModelError(f"{at} has to be positive")
    return tuple(float(value) for value in values)


def rgba(text: str | None, at: str, default: str = "") -> Rgba:
    """Return red, green, blue and opacity, cut to 0 to 1."""
    red, green, blue, opacity = np.clip(numbers(text, 4, default, at), 0.0, 1.0).tolist()
    return red, green, blue, opacity
