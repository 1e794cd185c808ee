"""How close to a dead point can reactions be computed, and how exact are they there?

The four-bar linkage driven by its rocker, from 1e-1 to 1e-12 rad before both ends of the rocker's
range, where crank and coupler are in line.
"""

from __future__ import annotations

import re

from mpmath import mp, mpf

from .descriptions import mechanics
from .exact import DIGITS
from .maps import verdict
from .methods import methods
from .stress import Case, Point, measure

NAME, LABEL = "dead_point", "distance from the dead point [rad]"
GRID = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 3e-8, 1e-8, 3e-9, 1e-9, 1e-10, 1e-11, 1e-12)
ENDS = {"upper end": (-1, -1), "lower end": (1, 1)}


def dead_point(coupler_sign: int) -> mpf:
    """Return the rocker's coordinate with crank and coupler in line, with 50 digits.

    Args:
        coupler_sign: 1 where they are stretched, -1 where they are folded.
    """
    mp.dps = DIGITS
    urdf = mechanics("four_bar")
    crank, coupler, rocker, frame = (mpf(0.08), mpf(0.4), mpf(0.25), mpf(0.47))
    (zero,) = re.findall(r'<origin xyz="0.47 0 0" rpy="0 0 ([^"]*)"', urdf)
    reach = coupler + coupler_sign * crank
    cosine = (reach**2 - frame**2 - rocker**2) / (2 * frame * rocker)
    return mp.acos(cosine) - mpf(float(zero))


def points(grid: tuple[float, ...] = GRID) -> list[Point]:
    """Return the map."""
    measured = []
    for method in methods():
        for end, (fold, inwards) in ENDS.items():
            for distance in grid:
                position = float(dead_point(fold) + inwards * mpf(distance))
                for speed, kind in ((0.0, "quasi-static"), (3.0, "at speed")):
                    case = Case(
                        mechanics("four_bar"),
                        "rocker_bearing",
                        (position,),
                        {},
                        {"crank_bearing": -1.0},
                        speed,
                        method=method,
                        span=tuple(sorted((position, position + inwards * 0.1))),
                    )
                    measured.append(measure(NAME, f"{end}, {kind}", distance, case))
    return sorted(measured, key=lambda point: (point.method, point.case))


def answer(measured: list[Point]) -> str:
    """Return where digits are lost."""
    return verdict(
        measured,
        "At a distance δ the condition number of the closure equations is of the order δ^-½. It "
        "magnifies the rounding of the positions, and rates and reactions magnify that once more: "
        "the stated condition number and the errors grow with 1/δ, for the drive "
        "position itself is not known better than eps in δ.",
    )
