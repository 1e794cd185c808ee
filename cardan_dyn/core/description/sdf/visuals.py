"""Visuals of SDF: the shapes of its links."""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from ....kit.arrays import Array, inverse
from ....kit.errors import ModelError, choices
from ..elements import numbers
from ..visual import SIZES, Rgba, Visual, positive, read_each, rgba, scale_of
from .elements import base_of, inside, number, pose, sizes_of, text
from .frames import NamedFrames
from .plain import FIRST_WITH_FRAMES, plain, version_of


def visuals(
    root: Element, path: Path | None, name: str | None = None
) -> tuple[list[Visual], list[str]]:
    """Return the visuals of a model that was read before, and messages about others.

    Args:
        root: its outermost element.
        path: the file, beside which meshes are found; None for text.
        name: of the model; None where there is only one.
    """
    has_names = version_of(root, "SDF") >= FIRST_WITH_FRAMES
    model, _ = plain(root, "SDF", strict=False, model=name)
    frames = NamedFrames(model, "SDF", has_names)
    items = [
        (link.get("name", ""), visual)
        for link in model.findall("link")
        for visual in link.findall("visual")
    ]
    names = [(link, f"visual {visual.get('name')!r}") for link, visual in items]
    folder = None if path is None else path.parent
    return read_each(names, lambda index: _visual(*items[index], frames, folder))


def _visual(link: str, element: Element, frames: NamedFrames, folder: Path | None) -> Visual | None:
    shapes = [*inside(element, "geometry", "it")]
    kinds = [item.tag for item in shapes]
    if kinds == ["empty"]:
        return None
    if len(shapes) != 1 or kinds[0] not in SIZES:
        stated = ", ".join(kinds) or "nothing"
        raise ModelError(f"its <geometry> is {stated}; one of {choices(SIZES)} is read")
    (shape,) = shapes
    color, place, base = _color(element), pose(element, "it"), base_of(element)
    if base:
        link_frame = frames.placement(link, "it")
        place = inverse(link_frame) @ frames.placement(base, "pose") @ place
    return shape_of(link, shape, place, color, folder)


def shape_of(
    link: str, shape: Element, place: Array, color: Rgba | None, folder: Path | None
) -> Visual:
    """Return the visual of a shape, whose numbers and words stand as text in its children."""
    kind = shape.tag
    if kind == "mesh":
        scale = scale_of(text(shape, "scale", "1 1 1", "mesh"), "mesh scale")
        part = text(inside(shape, "submesh", "mesh"), "name", "", "submesh")
        file = text(shape, "uri", "", "mesh")
        return Visual(link, kind, (), place, color, file, folder, scale=scale, part=part)
    size = np.concatenate([found for _, found in sizes_of(shape, kind, " ")])
    if kind == "plane":
        normal = numbers(text(shape, "normal", "0 0 1", kind), 3, "0 0 1", "plane normal")
        return Visual(link, kind, tuple(size.tolist()), place @ _upright(normal), color)
    return Visual(link, kind, positive(size, f"{kind}: its size"), place, color)


def _color(element: Element) -> Rgba | None:
    """Return the colour that light makes visible, or else the one in the shade."""
    material = inside(element, "material", "it")
    transparency = number(element, "transparency", "0", "it")
    for tag in ("diffuse", "ambient"):
        if stated := text(material, tag, "", "material"):
            words = [*stated.split(), "1"][:4]
            red, green, blue, opacity = rgba(" ".join(words), f"material {tag}")
            return red, green, blue, opacity * (1.0 - min(max(transparency, 0.0), 1.0))
    return None


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
