"""Inertias: bodies of shafts and crosses, from what is given or from their dimensions."""

from __future__ import annotations

import math
from typing import NamedTuple

from .line_data import LineData
from .parts import ShaftJoint
from .supports import spline_distance


class Body(NamedTuple):
    """A body that is symmetric about x.

    Attributes:
        mass: [kg]; greater than 0.
        centre: x of its centre of mass in its link [m].
        inertia: about x [kg·m²].
        transverse: about y and z through its centre of mass [kg·m²].
    """

    mass: float
    centre: float
    inertia: float
    transverse: float


def shaft_bodies(line: LineData, index: int) -> tuple[Body | None, Body | None]:
    """Return the bodies of a shaft: before its spline, or all of it, and behind its spline.

    Distances count from the joint at its front, for the input shaft from joint 1 with x along the
    power flow. A shaft with a spline is divided there like a rod of constant cross section, unless
    its centre or transverse inertia is given; then all of its mass is before the spline.
    """
    shaft = line.shafts[index]
    given = float(line.geometry.lengths[index])
    length = 0.0 if math.isnan(given) else given
    tube = shaft.tube
    mass = shaft.mass
    if mass is None:
        mass = tube.density * tube.area * length if tube else 0.0
    if mass == 0.0:
        return None, None
    inertia = shaft.inertia
    if inertia is None:
        # J = m (D² + d²) / 8
        squares = tube.outer_diameter**2 + tube.inner_diameter**2 if tube else 0.0
        inertia = mass * squares / 8.0
    centre = length / 2.0 if shaft.centre is None else shaft.centre
    transverse = shaft.transverse_inertia
    if transverse is None:
        transverse = mass * length**2 / 12.0 + inertia / 2.0
    if index == 0:
        return Body(mass, -centre, inertia, transverse), None
    if shaft.spline is None or shaft.centre is not None or shaft.transverse_inertia is not None:
        return Body(mass, centre, inertia, transverse), None
    cut = spline_distance(line, index)
    front = _piece(mass, inertia, length, 0.0, cut)
    return front, _piece(mass, inertia, length, cut, length)


def cross_inertia(joint: ShaftJoint) -> tuple[float, float]:
    """Return the inertias of a cross about its pins and about their normal [kg·m²].

    Two slender rods of half the mass each, m s²/24 and m s²/12.
    """
    square = joint.cross_mass * joint.cross_span**2
    return square / 24.0, square / 12.0


def _piece(mass: float, inertia: float, length: float, start: float, end: float) -> Body | None:
    """Return a piece of a rod; its centre counts from the start of the rod."""
    share = (end - start) / length
    if share <= 0.0:
        return None
    own, about = mass * share, inertia * share
    return Body(own, (start + end) / 2.0, about, own * (end - start) ** 2 / 12.0 + about / 2.0)
