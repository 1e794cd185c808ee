"""Visuals of SDF: the shapes of its links."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ....kit.arrays import Array, inverse
from ....kit.errors import ModelError, choices
from ..elements import at_point, numbers, only
from ..visual import SIZES, Rgba, Visual, positive, read_each, rgba, scale_of
from .elements import number, pose, text
from .frames import NamedFrames
from .plain import plain
from .reader import version_of

_NUMBERS = {
    "box": (("size", 3),),
    "sphere": (("radius", 1),),
    "cylinder": (("radius", 1), ("length", 1)),
    "capsule": (("radius", 1), ("length", 1)),
    "ellipsoid": (("radii", 3),),
    "plane": (("size", 2),),
}
"""What states the size of a shape, and how many numbers that has."""


def visuals(
    root: ElementTree.Element, path: Path | None, name: str | None = None
) -> tuple[list[Visual], list[str]]:
    """Return the visuals of a model that was read before, and messages about others.

    Args:
        root: its outermost element.
        path: the file, beside which meshes are found; None for text.
        name: of the model; None where there is only one.
    """
    version = version_of(root, "SDF")
    model, _ = plain(root, version, "SDF", strict=False, model=name)
    frames = NamedFrames(model, version, "SDF")
    items = [
        (link.get("name", ""), visual)
        for link in model.findall("link")
        for visual in link.findall("visual")
    ]
    names = [(link, f"visual {visual.get('name')!r}") for link, visual in items]
    folder = None if path is None else path.parent
    return read_each(names, lambda index: _visual(*items[index], frames, folder))


def _visual(
    link: str, element: ElementTree.Element, frames: NamedFrames, folder: Path | None
) -> Visual | None:
    geometry = only(element, "geometry", "it")
    shapes = [] if geometry is None else list(geometry)
    if len(shapes) == 1 and shapes[0].tag == "empty":
        return None
    if len(shapes) != 1 or shapes[0].tag not in SIZES:
        kinds = ", ".join(item.tag for item in shapes) or "nothing"
        raise ModelError(f"its <geometry> is {kinds}; one of {choices(SIZES)} is read")
    shape, kind = shapes[0], shapes[0].tag
    color, place = _color(element), _placement(link, element, frames)
    if kind == "mesh":
        scale = scale_of(text(shape, "scale", "1 1 1", "mesh"), "mesh scale")
        submesh = only(shape, "submesh", "mesh")
        part = "" if submesh is None else text(submesh, "name", "", "submesh")
        file = text(shape, "uri", "", "mesh")
        return Visual(link, kind, (), place, color, file, folder, scale=scale, part=part)
    size = np.concatenate(
        [numbers(text(shape, tag, "", kind), n, "", f"{kind} {tag}") for tag, n in _NUMBERS[kind]]
    )
    if kind == "plane":
        normal = numbers(text(shape, "normal", "0 0 1", kind), 3, "0 0 1", "plane normal")
        return Visual(link, kind, tuple(size.tolist()), place @ _upright(normal), color)
    return Visual(link, kind, positive(size, f"{kind}: its size"), place, color)


def _placement(link: str, element: ElementTree.Element, frames: NamedFrames) -> Array:
    """Return the `(4, 4)` placement of a visual in its link."""
    place = pose(element, "it")
    stated = only(element, "pose", "it")
    base = None if stated is None else (stated.get("relative_to") or stated.get("frame"))
    if not base:
        return place
    link_frame = frames.placement(link, "it")
    return np.asarray(inverse(link_frame) @ frames.placement(base, "pose") @ place)


def _color(element: ElementTree.Element) -> Rgba | None:
    """Return the colour that light makes visible, or else the one in the shade."""
    material = only(element, "material", "it")
    transparency = number(element, "transparency", "0", "it")
    for tag in () if material is None else ("diffuse", "ambient"):
        stated = text(material, tag, "", "material") if material is not None else ""
        if stated:
            words = stated.split()
            red, green, blue, opacity = rgba(" ".join([*words, "1"][:4]), f"material {tag}")
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
    result = at_point(np.zeros(3))
    result[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    return result
