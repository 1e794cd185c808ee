"""Solids: masses of collision shapes, for links whose inertia SDF computes."""

from __future__ import annotations

import math
from functools import partial
from xml.etree.ElementTree import Element

import numpy as np

from ....kit.arrays import Array
from ....kit.errors import ModelError, choices
from ..together import Massive, together
from ..visual import positive, sizes_of
from .elements import base_of, inside, number, pose, text

_ADVICE = "`gz sdf -p --expand-auto-inertials FILE` writes the inertia into the file"


def solid(link: Element, inertial: Element, at: str) -> Massive:
    """Return mass, centre `(3,)` and inertia `(3, 3)` about it of a link's collision shapes.

    Args:
        link: the `<link>`.
        inertial: what it says of its inertia, the density of shapes that state none.
        at: how messages name it.

    Raises:
        ModelError: there is no shape, or one whose inertia is not computed here.
    """
    for tag in ("mass", "pose", "inertia"):
        if inertial.find(tag) is not None:
            raise ModelError(f'{at}: <{tag}> and auto="true" exclude each other; keep one')
    density, parts = number(inertial, "density", "1000", at), []
    for item in link.findall("collision"):
        where = f"{at}: collision {item.get('name')!r}"
        if base_of(item):
            raise ModelError(
                f"{where}: a pose relative to another frame is not read here; {_ADVICE}"
            )
        frame = pose(item, where)
        mass, moments = _of_shape(item, where)
        mass *= number(item, "density", str(density), where)
        turn = frame[:3, :3]
        parts.append((mass, frame[:3, 3], turn @ np.diag(mass * moments) @ turn.T))
    if not sum(part[0] for part in parts) > 0.0:
        raise ModelError(f"{at}: no <collision> of which its inertia would be computed; {_ADVICE}")
    return together(parts)


def _of_shape(collision: Element, at: str) -> tuple[float, Array]:
    """Return the volume of a shape, and its moments of inertia `(3,)` per unit of mass."""
    shapes = [*inside(collision, "geometry", at)]
    if len(shapes) != 1:
        raise ModelError(f"{at}: <geometry> has {len(shapes)} shapes, expected one")
    kind, known = shapes[0].tag, ("box", "sphere", "cylinder", "capsule", "ellipsoid")
    if kind not in known:
        raise ModelError(
            f"{at}: the inertia of <{kind}> is not computed here, only of {choices(known)}; "
            f"{_ADVICE}"
        )
    stated = sizes_of(kind, partial(text, shapes[0], default="", at=at), at)
    sizes = [size for tag, found in stated for size in positive(found, f"{at}: {tag}")]
    if kind == "box":
        x, y, z = sizes
        return x * y * z, np.array([y * y + z * z, x * x + z * z, x * x + y * y]) / 12.0
    if kind in ("ellipsoid", "sphere"):
        a, b, c = sizes * (3 // len(sizes))
        squares = np.array([b * b + c * c, a * a + c * c, a * a + b * b])
        return 4.0 / 3.0 * math.pi * a * b * c, squares / 5.0
    radius, length = sizes
    rod, ball = math.pi * radius**2 * length, 4.0 / 3.0 * math.pi * radius**3
    across, along = rod * (radius**2 / 4.0 + length**2 / 12.0), rod * radius**2 / 2.0
    if kind == "cylinder":
        return rod, np.array([across, across, along]) / rod
    # Two half balls, whose centres of mass are 3/8 of the radius beyond the ends of the rod.
    middle = 3.0 / 8.0 * radius
    across += ball * (0.4 * radius**2 - middle**2 + (length / 2.0 + middle) ** 2)
    along += ball * 0.4 * radius**2
    return rod + ball, np.array([across, across, along]) / (rod + ball)
