"""Descriptions in which masses, inertias or lengths are multiplied."""

from __future__ import annotations

import re
from collections.abc import Mapping
from xml.etree import ElementTree

import cardan_dyn as cd

_NUMBER = re.compile(r'\b(value|ixx|iyy|izz|ixy|ixz|iyz)="([^"]*)"')


def moving(mechanism: cd.Mechanism) -> list[str]:
    """Return the names of the links that have mass and are not fixed to the world."""
    links = [link.name for link in mechanism.description.links if link.mass > 0.0]
    return [name for name in links if mechanism.link(name)[0]]


def scaled(mechanism: cd.Mechanism, factors: Mapping[str, float]) -> cd.Mechanism:
    """Return a mechanism read from the same URDF text with other masses and inertias."""
    text = mechanism.description.source.text
    for link, factor in factors.items():
        first = text.index(f'<link name="{link}">')
        last = text.index("</link>", first)
        text = text[:first] + _times(factor, text[first:last]) + text[last:]
    return cd.load(text)


def _times(factor: float, element: str) -> str:
    return _NUMBER.sub(
        lambda found: f'{found[1]}="{factor * float(found[2])!r}"',
        element,
    )


def in_lengths(mechanism: cd.Mechanism, factor: float, gyration: float | None = None) -> str:
    """Return a URDF text of the same mechanism with other lengths, and the same masses.

    Args:
        mechanism: read from URDF.
        factor: of lengths, limits of slides among them.
        gyration: of radii of gyration; the same as that of lengths if None.
    """
    root = ElementTree.fromstring(mechanism.description.source.text)
    for origin in root.iter("origin"):
        xyz = [factor * float(word) for word in origin.get("xyz", "0 0 0").split()]
        origin.set("xyz", " ".join(map(repr, xyz)))
    for inertia in root.iter("inertia"):
        for name, value in inertia.attrib.items():
            inertia.set(name, repr((gyration or factor) ** 2 * float(value)))
    for joint in root.iter("joint"):
        for limit in joint.findall("limit") if joint.get("type") == "prismatic" else ():
            for name in ("lower", "upper"):
                limit.set(name, repr(factor * float(limit.get(name, "0"))))
    for link in root.iter("link"):
        for visual in link.findall("visual") + link.findall("collision"):
            link.remove(visual)
    return ElementTree.tostring(root, encoding="unicode")
