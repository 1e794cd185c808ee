"""Visuals of SDF: the shapes of its links."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from xml.etree.ElementTree import Element, fromstring

from ....core.description.description import SourceText
from ....kit.arrays import inverse
from ....kit.errors import ModelError, choices
from ..visual import SIZES, Rgba, Visual, read_in_links, rgba, shape_of
from .elements import base_of, inside, number, pose, text
from .frames import NamedFrames
from .plain import FIRST_WITH_FRAMES, plain, version_of


def visuals(source: SourceText) -> tuple[list[Visual], list[str]]:
    """Return the visuals of a model that was read before, and messages about others."""
    root = fromstring(source.text)
    has_names = version_of(root, "SDF") >= FIRST_WITH_FRAMES
    model, _ = plain(root, "SDF", strict=False, model=source.model)
    frames = NamedFrames(model, "SDF", has_names)
    return read_in_links(model, partial(_visual, frames, source.folder))


def _visual(frames: NamedFrames, folder: Path | None, link: str, element: Element) -> Visual | None:
    shapes = [*inside(element, "geometry", "it")]
    kinds = [item.tag for item in shapes]
    if kinds == ["empty"]:
        return None
    if len(shapes) != 1 or kinds[0] not in SIZES:
        stated = ", ".join(kinds) or "nothing"
        raise ModelError(f"its <geometry> is {stated}; one of {choices(SIZES)} is read")
    (shape,), (kind,) = shapes, kinds
    color, place, base = _color(element), pose(element, "it"), base_of(element)
    if base:
        link_frame = frames.placement(link, "it")
        place = inverse(link_frame) @ frames.placement(base, "pose") @ place
    part = text(inside(shape, "submesh", "mesh"), "name", "", "submesh") if kind == "mesh" else ""
    word = partial(text, shape, default="", at=kind)
    return shape_of(link, kind, word, place, color, folder, part)


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
