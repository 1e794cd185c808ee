"""Inertia of MJCF bodies: as stated, or from the shapes of their geoms."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ...arrays import Array
from ...errors import ModelError
from ..description import LinkDescription
from ..elements import GREATEST, numbers
from ..urdf import check_inertia
from .elements import Attributes, Compiler, flag, number, pose, segment, several

_LEAST_MASS = 1e-50
_FULL = ("xx", "yy", "zz", "xy", "xz", "yz")
_SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "box": 3, "ellipsoid": 3}
"""Shape to how many numbers its size has."""


@dataclass(frozen=True, eq=False)
class Shape:
    """An `<inertial>` or a `<geom>`.

    Attributes:
        attributes: those of its class included.
        frame: `(4, 4)` placement of the frame around it in the body.
        at: how messages name it.
    """

    attributes: Attributes
    frame: Array
    at: str


@dataclass(frozen=True, eq=False)
class Mass:
    """A mass [kg], its centre `(3,)` [m] and its inertia `(3, 3)` about that [kg·m²]."""

    mass: float
    centre: Array
    inertia: Array


_NOTHING = Mass(0.0, np.zeros(3), np.zeros((3, 3)))


def link(
    name: str,
    inertial: Shape | None,
    geoms: list[Shape],
    compiler: Compiler,
    at: str,
    strict: bool,
    warnings: list[str],
) -> LinkDescription:
    """Return a body as a link with its mass.

    Args:
        name: of the body.
        inertial: what it states, if it does.
        geoms: its shapes.
        compiler: settings of the file.
        at: how messages name the body.
        strict: whether inertias that no body can have are refused.
        warnings: what was accepted is added to them.
    """
    found = None
    if compiler.inertiafromgeom == "true" or (
        compiler.inertiafromgeom == "auto" and inertial is None
    ):
        found = _together([_of_geom(geom, compiler) for geom in geoms])
    if found is None:
        found = _NOTHING if inertial is None else _of_inertial(inertial, compiler, warnings)
    if not np.all(np.abs([found.mass, *found.centre, *found.inertia.flat]) <= GREATEST):
        raise ModelError(
            f"{at}: its mass or inertia is beyond {GREATEST:.0e}; choose units in which numbers "
            "are not so far from 1"
        )
    found = _bounded(found, compiler)
    mass, tensor = found.mass, found.inertia
    if mass == 0.0:
        if np.any(tensor):
            if strict:
                raise ModelError(f"{at}: an inertia needs a mass; load(..., strict=False) drops it")
            warnings.append(f"{at}: mass 0 kg with an inertia: taken as massless")
        return LinkDescription(name)
    if mass < _LEAST_MASS:
        raise ModelError(f"{at}: mass {mass:g} kg is not positive; a massless body has mass 0")
    warning = check_inertia(tensor, at, strict)
    if warning:
        warnings.append(warning)
    return LinkDescription(name, mass, found.centre, tensor)


def scaled_to(links: list[LinkDescription], total: float, where: str) -> list[LinkDescription]:
    """Return links whose masses sum up to a total [kg], their inertias in the same ratio."""
    mass = sum(link.mass for link in links)
    if mass == 0.0:
        raise ModelError(f"{where}: compiler: settotalmass {total:g} kg, but no body has a mass")
    factor = total / mass
    least = min(link.mass for link in links if link.mass > 0.0)
    if least * factor < _LEAST_MASS:
        raise ModelError(f"{where}: compiler: settotalmass {total:g} kg leaves masses of none")
    return [replace(link, mass=link.mass * factor, inertia=link.inertia * factor) for link in links]


def _of_inertial(shape: Shape, compiler: Compiler, warnings: list[str]) -> Mass:
    attributes, at = shape.attributes, shape.at
    for needed in ("pos", "mass"):
        if needed not in attributes:
            raise ModelError(f'{at}: {needed}="..." is missing')
    if "fullinertia" in attributes:
        spare = set(attributes) - {"pos", "mass", "fullinertia"}
        if spare:
            raise ModelError(f"{at}: fullinertia and {min(spare)} exclude each other; keep one")
        values = numbers(attributes["fullinertia"], 6, "", f"{at}: fullinertia")
        xx, yy, zz, xy, xz, yz = values
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    else:
        if "diaginertia" not in attributes:
            warnings.append(f"{at}: it has neither diaginertia nor fullinertia: a point mass")
        values = numbers(attributes.get("diaginertia"), 3, "0 0 0", f"{at}: diaginertia")
        tensor = np.diag(values)
    frame = shape.frame @ pose(attributes, compiler, at)
    turn = frame[:3, :3]
    return Mass(number(attributes, "mass", "", at), frame[:3, 3], turn @ tensor @ turn.T)


def _of_geom(shape: Shape, compiler: Compiler) -> Mass | None:
    """Return the mass of a geom; None where it has none."""
    attributes, at = shape.attributes, shape.at
    kind = attributes.get("type", "sphere")
    first, last = compiler.groups
    if kind in ("plane", "hfield") or not first <= number(attributes, "group", "0", at) <= last:
        return None
    stated = number(attributes, "mass", "0", at) if "mass" in attributes else None
    density = number(attributes, "density", "1000", at)
    if min(density, stated or 0.0) < 0.0:
        raise ModelError(f"{at}: its mass or density is negative")
    if (density if stated is None else stated) == 0.0:
        return None
    if kind not in _SIZES or "mesh" in attributes:
        raise ModelError(
            f"{at}: the inertia of a geom of type {kind!r}"
            f"{' fitted to a mesh' if kind in _SIZES else ''} is not computed here; give the body "
            'an <inertial>, or the geom mass="0"'
        )
    if flag(attributes, "shellinertia", "false", at):
        raise ModelError(f"{at}: shellinertia is not supported; give the body an <inertial>")
    frame, sizes = _frame_and_size(attributes, kind, compiler, at)
    volume, moments = _solid(kind, sizes)
    mass = volume * density if stated is None else stated
    frame = shape.frame @ frame
    turn = frame[:3, :3]
    return Mass(mass, frame[:3, 3], mass * (turn * moments) @ turn.T)


def frame_of(attributes: Attributes, compiler: Compiler, at: str) -> Array:
    """Return the `(4, 4)` placement of a geom or site."""
    if "fromto" not in attributes:
        return pose(attributes, compiler, at)
    kind = attributes.get("type", "sphere")
    if kind not in _SIZES or kind == "sphere":
        raise ModelError(f"{at}: fromto does not suit the type {kind!r}; write pos and size")
    if "pos" in attributes:
        raise ModelError(f"{at}: pos and fromto both place it; keep one of them")
    return segment(attributes, at)[0]


def _frame_and_size(
    attributes: Attributes, kind: str, compiler: Compiler, at: str
) -> tuple[Array, Array]:
    """Return the `(4, 4)` placement of a geom, and radius and half lengths."""
    frame = frame_of(attributes, compiler, at)
    sizes = several(attributes, "size", 1, 3, at)
    if "fromto" in attributes:
        half = segment(attributes, at)[1]
        sizes = np.array([*sizes[:1], *([half] if _SIZES[kind] == 2 else [*sizes[:1], half])])
    sizes = sizes[: _SIZES[kind]]
    if len(sizes) < _SIZES[kind] or not np.all(sizes > 0.0):
        raise ModelError(
            f"{at}: a {kind} needs {_SIZES[kind]} positive size number(s)"
            + (", or fromto and a radius" if kind != "sphere" else "")
        )
    return frame, sizes


def _solid(kind: str, size: Array) -> tuple[float, Array]:
    """Return the volume of a solid [m³] and its principal moments `(3,)` per mass [m²]."""
    if kind in ("box", "ellipsoid"):
        factor, part = (8.0, 1.0 / 3.0) if kind == "box" else (4.0 / 3.0 * math.pi, 0.2)
        squares = part * size**2
        return factor * float(np.prod(size)), np.sum(squares) - squares
    radius = float(size[0])
    ball, ball_moment = 4.0 / 3.0 * math.pi * radius**3, 0.4 * radius**2
    if kind == "sphere":
        return ball, np.full(3, ball_moment)
    length = 2.0 * float(size[1])
    rod = math.pi * radius**2 * length
    across, along = length**2 / 12.0 + radius**2 / 4.0, 0.5 * radius**2
    if kind == "cylinder":
        return rod, np.array([across, across, along])
    share = 1.0 / (1.0 + 0.75 * length / radius)  # ball / (ball + rod)
    # Each half of the ball has its centre 3/8 of the radius beyond the rod's end.
    ends = ball_moment + length**2 / 4.0 + 0.375 * length * radius
    moment = (1.0 - share) * across + share * ends
    return ball + rod, np.array([moment, moment, (1.0 - share) * along + share * ball_moment])


def _together(masses: list[Mass | None]) -> Mass | None:
    """Return several masses as one; None where nothing has a mass."""
    parts = [part for part in masses if part is not None and part.mass > 0.0]
    if not parts:
        return None
    mass = sum(part.mass for part in parts)
    centre = sum((part.mass / mass * part.centre for part in parts), np.zeros(3))
    tensor = np.zeros((3, 3))
    for part in parts:
        arm = part.centre - centre
        tensor += part.inertia + part.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return Mass(mass, centre, tensor)


def _bounded(found: Mass, compiler: Compiler) -> Mass:
    """Apply boundmass, boundinertia and balanceinertia, in MuJoCo's order."""
    if compiler.boundmass <= 0.0 >= compiler.boundinertia and not compiler.balanceinertia:
        return found
    mass, tensor = found.mass, found.inertia
    if compiler.boundmass > 0.0 and mass >= 0.0:
        mass = max(mass, compiler.boundmass)
    moments, axes = np.linalg.eigh(tensor)
    if compiler.boundinertia > 0.0 and np.any(moments < compiler.boundinertia):
        moments = np.maximum(moments, compiler.boundinertia)
        tensor = (axes * moments) @ axes.T
    least, middle, greatest = np.sort(moments)
    if compiler.balanceinertia and least + middle < greatest:
        tensor = np.mean(moments) * np.eye(3)
    return Mass(mass, found.centre, tensor)
