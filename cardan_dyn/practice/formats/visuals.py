"""Visuals: the shapes of links that a text describes, for the viewer; read only when shown.

A visual that cannot be read is left out with a message: no wrench depends on it.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from importlib import import_module
from pathlib import Path
from xml.etree.ElementTree import Element, fromstring

from ...core.description.description import Description
from ...core.description.elements import only, placement
from ...kit.errors import ModelError, choices
from .visual import SIZES, Rgba, Visual, read_in_links, rgba, shape_of


def visuals_of(description: Description) -> tuple[list[Visual], list[str]]:
    """Return the visuals of a description, and messages about those that cannot be read."""
    source = description.text
    if source is None:
        return [], []
    if source.guest:
        read: tuple[list[Visual], list[str]] = import_module(f"{source.guest}.visuals").visuals(
            source
        )
        return read
    return _of_urdf(fromstring(source.text), source.folder)


def _of_urdf(robot: Element, folder: Path | None) -> tuple[list[Visual], list[str]]:
    # A material is known by its name wherever it stands; those of the robot come first.
    materials: dict[str, Element] = {}
    for element in (
        *robot.findall("material"),
        *robot.findall("link/visual/material"),
    ):
        if element.find("color") is not None:
            materials.setdefault(element.get("name", ""), element)
    return read_in_links(robot, partial(urdf_visual, materials, folder))


def urdf_visual(
    materials: Mapping[str, Element],
    folder: Path | None,
    link: str,
    element: Element,
) -> Visual:
    """Return a `<visual>` of a URDF.

    Args:
        materials: by their names.
        folder: where relative paths start; None for text.
        link: name of the link.
        element: the visual.

    Raises:
        ModelError: it has no shape, or several, or a size that is none.
    """
    geometry = only(element, "geometry", "it")
    shapes = [] if geometry is None else [item for item in geometry if item.tag in SIZES]
    if len(shapes) != 1:
        raise ModelError(
            f"<geometry> needs one of {choices(('box', 'cylinder', 'sphere', 'mesh'))}"
        )
    (shape,) = shapes
    words = {"uri": shape.get("filename", ""), **shape.attrib}
    color = _urdf_color(only(element, "material", "it"), materials)
    return shape_of(
        *(link, shape.tag, lambda name: words.get(name, "").strip(" \t\r\n")),
        *(placement(element, "it"), color, folder),
    )


def _urdf_color(material: Element | None, materials: Mapping[str, Element]) -> Rgba | None:
    """Return the colour of a material, its own or that of its name."""
    if material is None:
        return None
    color = only(material, "color", "material")
    if color is None and material.get("name", "") in materials:
        color = only(materials[material.get("name", "")], "color", "material")
    return None if color is None else rgba(color.get("rgba"), "color rgba")
