"""Visuals: the shapes of links that a text describes, for the viewer; read only when shown.

A visual that cannot be read is left out with a message: no wrench depends on it.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, fromstring

from ...kit.errors import ModelError, choices
from .description import Description
from .elements import only, placement
from .visual import SIZES, Rgba, Visual, read_each, rgba


def visuals_of(description: Description) -> tuple[list[Visual], list[str]]:
    """Return the visuals of a description, and messages about those that cannot be read."""
    source = description.text
    if source is None:
        return [], []
    root = fromstring(source.text)
    if root.tag == "mujoco":
        from .mjcf import visuals as mjcf

        return mjcf.visuals(source)
    if root.tag == "sdf":
        from .sdf import visuals as sdf

        return sdf.visuals(root, source.path, source.model)
    return _of_urdf(root, source.path)


def _of_urdf(robot: Element, path: Path | None) -> tuple[list[Visual], list[str]]:
    items = [
        (link.get("name", ""), visual)
        for link in robot.findall("link")
        for visual in link.findall("visual")
    ]
    # A material is known by its name wherever it stands; those of the robot come first.
    materials: dict[str, Element] = {}
    for element in (
        *robot.findall("material"),
        *(item for _, visual in items for item in visual.findall("material")),
    ):
        if element.find("color") is not None:
            materials.setdefault(element.get("name", ""), element)
    folder = None if path is None else path.parent
    names = [
        (link, f"visual {item.get('name')!r}" if item.get("name") else "a visual")
        for link, item in items
    ]
    return read_each(names, lambda index: _urdf_visual(*items[index], materials, folder))


def _urdf_visual(
    link: str,
    element: Element,
    materials: Mapping[str, Element],
    folder: Path | None,
) -> Visual:
    """Return a `<visual>` of a URDF."""
    geometry = only(element, "geometry", "it")
    shapes = [] if geometry is None else [item for item in geometry if item.tag in SIZES]
    if len(shapes) != 1:
        raise ModelError(
            f"<geometry> needs one of {choices(('box', 'cylinder', 'sphere', 'mesh'))}"
        )
    from .sdf.visuals import shape_of  # Its text is looked for in the way of SDF.

    (stated,) = shapes
    shape = Element(stated.tag)
    for name, value in stated.attrib.items():
        SubElement(shape, "uri" if name == "filename" else name).text = value
    color = _urdf_color(only(element, "material", "it"), materials)
    return shape_of(link, shape, placement(element, "it"), color, folder)


def _urdf_color(material: Element | None, materials: Mapping[str, Element]) -> Rgba | None:
    """Return the colour of a material, its own or that of its name."""
    if material is None:
        return None
    color = only(material, "color", "material")
    if color is None and material.get("name", "") in materials:
        color = only(materials[material.get("name", "")], "color", "material")
    return None if color is None else rgba(color.get("rgba"), "color rgba")
