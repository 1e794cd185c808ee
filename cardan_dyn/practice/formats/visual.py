"""Visual: the shape of a link as plain data, and what the readers of all notations share."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from ...core.description.elements import numbers
from ...kit.arrays import Array
from ...kit.errors import ModelError

SIZES: dict[str, dict[str, int]] = {
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "capsule": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
    "ellipsoid": {"radii": 3},
    "plane": {"size": 2},
    "mesh": {},
}
"""Kinds of visuals to what states their size, and how many numbers that has.

Lengths are along z, that of a capsule between the centres of its ends. A plane without end has the
size 0; that of a mesh is in its file.
"""
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
    items: Iterable[tuple[str, str, Callable[[], Visual | None]]],
) -> tuple[list[Visual], list[str]]:
    """Return visuals, and messages about those that are refused.

    Args:
        items: of each the link, its name, and what reads it; None for what is not to be seen.
    """
    found, messages = [], []
    for link, name, read in items:
        try:
            visual = read()
        except ModelError as error:
            messages.append(f"link {link!r}: {name} is not drawn: {error}")
        else:
            found += [] if visual is None else [visual]
    return found, messages


def read_in_links(
    model: Element, read: Callable[[str, Element], Visual | None]
) -> tuple[list[Visual], list[str]]:
    """Return what is read of each `<visual>` in the links of a model, see `read_each`."""
    return read_each(
        (
            name,
            f"visual {own!r}" if (own := visual.get("name")) else "a visual",
            partial(read, name, visual),
        )
        for link in model.findall("link")
        for name in [link.get("name", "")]
        for visual in link.findall("visual")
    )


def sizes_of(
    kind: str, word: Callable[[str], str], at: str, mark: str = ": "
) -> Iterator[tuple[str, Array]]:
    """Yield what states the size of a kind of shape, and its numbers.

    Args:
        kind: of `SIZES`, but no mesh.
        word: the text that the shape states by a name; empty where it states none.
        at: how messages name the shape.
        mark: between that and the name of a size.
    """
    for name, count in SIZES[kind].items():
        yield name, numbers(word(name), count, "", f"{at}{mark}{name}")


def shape_of(
    link: str,
    kind: str,
    word: Callable[[str], str],
    place: Array,
    color: Rgba | None,
    folder: Path | None,
    part: str = "",
) -> Visual:
    """Return the visual of a shape; see `sizes_of` and `Visual`."""
    if kind == "mesh":
        scale = scale_of(word("scale") or "1 1 1", "mesh scale")
        return Visual(link, kind, (), place, color, word("uri"), folder, scale=scale, part=part)
    size = np.concatenate([found for _, found in sizes_of(kind, word, kind, " ")])
    if kind == "plane":
        normal = numbers(word("normal") or "0 0 1", 3, "", "plane normal")
        return Visual(link, kind, tuple(size.tolist()), place @ _upright(normal), color)
    return Visual(link, kind, positive(size, f"{kind}: its size"), place, color)


def _upright(normal: Array) -> Array:
    """Return a `(4, 4)` placement whose z axis is along a vector."""
    length = float(np.linalg.norm(normal))
    if length == 0.0:
        raise ModelError("plane normal: a vector of zeros has no direction")
    z = normal / length
    x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
    x /= np.linalg.norm(x)
    result = np.eye(4)
    result[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    return result


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
