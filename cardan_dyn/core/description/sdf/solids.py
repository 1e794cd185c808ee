"""Solids: masses of collision shapes, for links whose inertia SDF computes."""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element

import numpy as np

from ....kit.arrays import Array
from ....kit.errors import ModelError, choices
from ..elements import numbers, only
from ..visual import positive
from .elements import number, pose, text

_ADVICE = "`gz sdf -p --expand-auto-inertials FILE` writes the inertia into the file"


def solid(link: Element, density: float, at: str) -> tuple[float, Array, Array]:
    """Return mass, centre `(3,)` and inertia `(3, 3)` about it of a link's collision shapes.

    Args:
        link: the `<link>`.
        density: of shapes that state none [kg/m³].
        at: how messages name it.

    Raises:
        ModelError: there is no shape, or one whose inertia is not computed here.
    """
    parts = []
    for item in link.findall("collision"):
        where = f"{at}: collision {item.get('name')!r}"
        stated = only(item, "pose", where)
        if stated is not None and (stated.get("relative_to") or stated.get("frame")):
            raise ModelError(
                f"{where}: a pose relative to another frame is not read here; {_ADVICE}"
            )
        frame = pose(item, where)
        mass, moments = _of_shape(item, where)
        mass *= number(item, "density", str(density), where)
        turn = frame[:3, :3]
        parts.append((mass, frame[:3, 3], turn @ np.diag(mass * moments) @ turn.T))
    mass = sum(part[0] for part in parts)
    if not mass > 0.0:
        raise ModelError(f"{at}: no <collision> of which its inertia would be computed; {_ADVICE}")
    centre = sum(part[0] * part[1] for part in parts) / mass
    tensor = np.zeros((3, 3))
    for own, place, inertia in parts:
        arm = place - centre
        tensor += inertia + own * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return mass, np.asarray(centre), tensor


def _of_shape(collision: Element, at: str) -> tuple[float, Array]:
    """Return the volume of a shape, and its moments of inertia `(3,)` per unit of mass."""
    geometry = only(collision, "geometry", at)
    shapes = [] if geometry is None else list(geometry)
    if len(shapes) != 1:
        raise ModelError(f"{at}: <geometry> has {len(shapes)} shapes, expected one")
    (shape,) = shapes

    def sizes(tag: str, count: int) -> tuple[float, ...]:
        found = numbers(text(shape, tag, "", at), count, "", f"{at}: {tag}")
        return positive(found, f"{at}: {tag}")

    if shape.tag == "box":
        x, y, z = sizes("size", 3)
        return x * y * z, np.array([y * y + z * z, x * x + z * z, x * x + y * y]) / 12.0
    if shape.tag == "ellipsoid":
        a, b, c = sizes("radii", 3)
        squares = np.array([b * b + c * c, a * a + c * c, a * a + b * b])
        return 4.0 / 3.0 * math.pi * a * b * c, squares / 5.0
    if shape.tag not in ("sphere", "cylinder", "capsule"):
        known = ("box", "sphere", "cylinder", "capsule", "ellipsoid")
        raise ModelError(
            f"{at}: the inertia of <{shape.tag}> is not computed here, only of "
            f"{choices(known)}; {_ADVICE}"
        )
    (radius,) = sizes("radius", 1)
    ball = 4.0 / 3.0 * math.pi * radius**3
    if shape.tag == "sphere":
        return ball, np.full(3, 0.4 * radius**2)
    (length,) = sizes("length", 1)
    rod = math.pi * radius**2 * length
    across, along = rod * (radius**2 / 4.0 + length**2 / 12.0), rod * radius**2 / 2.0
    if shape.tag == "cylinder":
        return rod, np.array([across, across, along]) / rod
    # Two half balls, whose centres of mass are 3/8 of the radius beyond the ends of the rod.
    beyond = length / 2.0 + 3.0 / 8.0 * radius
    across += ball * (0.4 * radius**2 - (3.0 / 8.0 * radius) ** 2 + beyond**2)
    along += ball * 0.4 * radius**2
    return rod + ball, np.array([across, across, along]) / (rod + ball)
