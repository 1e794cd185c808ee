"""Are the reactions as exact after a million turns as in the first?

Universal joint at 50° and four-bar linkage; 50-digit reference at the very double that stands for
the position.
"""

from __future__ import annotations

import numpy as np

from .descriptions import mechanics
from .maps import verdict
from .methods import methods
from .stress import Case, Point, measure

NAME, LABEL = "turns", "turns made"
GRID = (1.0, 10.0, 1e2, 1e3, 1e4, 1e5, 1e6)


def points(grid: tuple[float, ...] = GRID) -> list[Point]:
    """Return the map."""
    measured = []
    for method in methods():
        for sign, sense in ((1.0, "forwards"), (-1.0, "backwards")):
            for turns in grid:
                positions = tuple(sign * (2.0 * np.pi * turns + x) for x in (0.1, 0.7, 5.0))
                joint = Case(
                    mechanics("universal_joint"),
                    "bearing_in",
                    positions,
                    {"joint_angle": float(np.deg2rad(50.0))},
                    {"bearing_out": -1.0},
                    method=method,
                )
                measured.append(measure(NAME, f"universal joint, {sense}", turns, joint))
                linkage = Case(
                    mechanics("four_bar"),
                    "crank_bearing",
                    positions,
                    {},
                    {"rocker_bearing": -1.0},
                    method=method,
                )
                measured.append(measure(NAME, f"four-bar, {sense}", turns, linkage))
    return sorted(measured, key=lambda point: (point.method, point.case))


def answer(measured: list[Point]) -> str:
    """Return where digits are lost."""
    return verdict(
        measured,
        "Turns lose no digits: the drive position enters as it is given, and sine and cosine of a "
        "large angle are exact to rounding.",
    )
