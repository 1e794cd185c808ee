"""Inertia of MJCF bodies: as stated, or from the shapes of their geoms."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...arrays import Array
from ...errors import ModelError
from ..description import LinkDescription
from ..elements import GREATEST, LEAST_MASS, numbers
from ..urdf import check_inertia, tensor_of
from .elements import Attributes, Compiler, flag, number, pose, segment, several

_SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "box": 3, "ellipsoid": 3}
"""Shape of a geom to how many numbers its size has."""


@dataclass(frozen=True, eq=False)
class MassElement:
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
    inertial: MassElement | None,
    geoms: list[MassElement],
    compiler: Compiler,
    at: str,
    strict: bool,
) -> tuple[LinkDescription, list[str]]:
    """Return a body as a link with its mass, and warnings about what was accepted.

    Args:
        name: of the body.
        inertial: what it states, if it does.
        geoms: its shapes.
        compiler: settings of the file.
        at: how messages name the body.
        strict: whether inertias that no body can have are refused.

    Raises:
        ModelError: its mass or inertia is malformed, impossible or not computed here.
    """
    body, warning = _mass_of(inertial, geoms, compiler)
    warnings = [warning] if warning else []
    if not np.all(np.abs([body.mass, *body.centre, *body.inertia.flat]) <= GREATEST):
        raise ModelError(
            f"{at}: its mass or inertia is beyond {GREATEST:.0e}; choose units in which numbers "
            "are not so far from 1"
        )
    body = _bounded(body, compiler)
    if body.mass == 0.0:
        if np.any(body.inertia):
            if strict:
                raise ModelError(f"{at}: an inertia needs a mass; load(..., strict=False) drops it")
            warnings.append(f"{at}: mass 0 kg with an inertia: taken as massless")
        return LinkDescription(name), warnings
    if body.mass < LEAST_MASS:
        raise ModelError(f"{at}: mass {body.mass:g} kg is not positive; a massless body has mass 0")
    warning = check_inertia(body.inertia, at, strict)
    if warning:
        warnings.append(warning)
    return LinkDescription(name, body.mass, body.centre, body.inertia), warnings


def _mass_of(
    inertial: MassElement | None, geoms: list[MassElement], compiler: Compiler
) -> tuple[Mass, str]:
    """Return the mass of a body from its geoms or as stated, and a warning if there is one."""
    from_geoms = None
    if compiler.inertiafromgeom == "true" or (
        compiler.inertiafromgeom == "auto" and inertial is None
    ):
        from_geoms = total([_of_geom(geom, compiler) for geom in geoms])
    if from_geoms is not None:
        return from_geoms, ""
    return (_NOTHING, "") if inertial is None else _of_inertial(inertial, compiler)


def scaled_to(links: list[LinkDescription], total: float, where: str) -> list[LinkDescription]:
    """Return links whose masses sum up to a total [kg], inertias scaled by the same factor.

    Raises:
        ModelError: no link has a mass, or one would be too small to compute with.
    """
    mass = sum(link.mass for link in links)
    if mass == 0.0:
        raise ModelError(f"{where}: compiler: settotalmass {total:g} kg, but no body has a mass")
    factor = total / mass
    least = min(link.mass for link in links if link.mass > 0.0)
    if least * factor < LEAST_MASS:
        raise ModelError(f"{where}: compiler: settotalmass {total:g} kg leaves masses of none")
    return [replace(link, mass=link.mass * factor, inertia=link.inertia * factor) for link in links]


def _of_inertial(shape: MassElement, compiler: Compiler) -> tuple[Mass, str]:
    """Return the mass that a body states, and a warning where it states no inertia."""
    attributes, at, warning = shape.attributes, shape.at, ""
    for needed in ("pos", "mass"):
        if needed not in attributes:
            raise ModelError(f'{at}: {needed}="..." is missing')
    if "fullinertia" in attributes:
        excluded = set(attributes) - {"pos", "mass", "fullinertia"}
        if excluded:
            raise ModelError(f"{at}: fullinertia and {min(excluded)} exclude each other; keep one")
        tensor = tensor_of(*numbers(attributes["fullinertia"], 6, "", f"{at}: fullinertia"))
    else:
        if "diaginertia" not in attributes:
            warning = f"{at}: it has neither diaginertia nor fullinertia: a point mass"
        values = numbers(attributes.get("diaginertia"), 3, "0 0 0", f"{at}: diaginertia")
        tensor = np.diag(values)
    frame = shape.frame @ pose(attributes, compiler, at)
    turn = frame[:3, :3]
    mass = Mass(number(attributes, "mass", "", at), frame[:3, 3], turn @ tensor @ turn.T)
    return mass, warning


def _of_geom(shape: MassElement, compiler: Compiler) -> Mass | None:
    """Return the mass of a geom, solid and of constant density; None where it has none."""
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
    frame, sizes = frame_and_size(attributes, kind, compiler, at)
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


def frame_and_size(
    attributes: Attributes, kind: str, compiler: Compiler, at: str
) -> tuple[Array, Array]:
    """Return the `(4, 4)` placement of a geom, and its `(k,)` radius and half lengths [m].

    A shape between two points lists its radius only, or its two half widths.
    """
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
        # Volume of the unit shape, and its mean square of a coordinate.
        unit_volume, mean_square = (
            (8.0, 1.0 / 3.0) if kind == "box" else (4.0 / 3.0 * math.pi, 1.0 / 5.0)
        )
        squares = mean_square * size**2
        return unit_volume * float(np.prod(size)), np.sum(squares) - squares
    radius = float(size[0])
    ball, ball_moment = 4.0 / 3.0 * math.pi * radius**3, 0.4 * radius**2
    if kind == "sphere":
        return ball, np.full(3, ball_moment)
    length = 2.0 * float(size[1])
    rod = math.pi * radius**2 * length
    across, along = length**2 / 12.0 + radius**2 / 4.0, 0.5 * radius**2
    if kind == "cylinder":
        return rod, np.array([across, across, along])
    # A capsule: a rod between the halves of a ball, which have this share of the volume.
    share = 1.0 / (1.0 + 0.75 * length / radius)
    # Each half of the ball has its centre 3/8 of the radius beyond the rod's end.
    ends = ball_moment + length**2 / 4.0 + 0.375 * length * radius
    moment = (1.0 - share) * across + share * ends
    return ball + rod, np.array([moment, moment, (1.0 - share) * along + share * ball_moment])


def total(masses: Sequence[Mass | None]) -> Mass | None:
    """Return several masses as one; None where nothing has a mass."""
    positive = [item for item in masses if item is not None and item.mass > 0.0]
    if not positive:
        return None
    mass = sum(item.mass for item in positive)
    centre = sum((item.mass / mass * item.centre for item in positive), np.zeros(3))
    tensor = np.zeros((3, 3))
    for item in positive:
        arm = item.centre - centre
        tensor += item.inertia + item.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return Mass(mass, centre, tensor)


def _bounded(body: Mass, compiler: Compiler) -> Mass:
    """Apply boundmass, boundinertia and balanceinertia, in MuJoCo's order."""
    if compiler.boundmass <= 0.0 >= compiler.boundinertia and not compiler.balanceinertia:
        return body
    mass, tensor = body.mass, body.inertia
    if compiler.boundmass > 0.0 and mass >= 0.0:
        mass = max(mass, compiler.boundmass)
    moments, axes = np.linalg.eigh(tensor)
    if compiler.boundinertia > 0.0 and np.any(moments < compiler.boundinertia):
        moments = np.maximum(moments, compiler.boundinertia)
        tensor = (axes * moments) @ axes.T
    least, middle, greatest = np.sort(moments)
    if compiler.balanceinertia and least + middle < greatest:
        tensor = np.mean(moments) * np.eye(3)
    return Mass(mass, body.centre, tensor)
