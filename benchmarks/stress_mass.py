"""What do mass ratios from 1e-9 to 1e9 do to the reactions of a double shaft?

Mass and inertia of one link times the parameter; at speed (30 rad/s, 5 rad/s²), and at rest under
gravity.
"""

from __future__ import annotations

from .descriptions import mechanics, with_mass
from .maps import verdict
from .methods import methods
from .stress import Case, Point, measure

NAME, LABEL = "mass", "mass over that of the description"
GRID = (1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9)
LINKS = ("tube", "cross_1", "shaft_out")
HELD = {"joint_angle_1": 0.4, "joint_angle_2": 0.3}
POSITIONS = (0.0, 0.9, 2.0)


def points(grid: tuple[float, ...] = GRID, links: tuple[str, ...] = LINKS) -> list[Point]:
    """Return the map."""
    measured = []
    for method in methods():
        for link in links:
            for factor in grid:
                urdf = with_mass(mechanics("double_shaft_z"), link, factor)
                case = ("bearing_in", POSITIONS, HELD, {"bearing_out": -1.0})
                weight = Case(urdf, *case, gravity=(0.0, 0.0, -9.81), method=method)
                measured.append(measure(NAME, f"{link}, gravity", factor, weight))
                fast = Case(urdf, *case, 30.0, 5.0, method=method)
                measured.append(measure(NAME, f"{link}, at speed", factor, fast))
    return sorted(measured, key=lambda point: (point.method, point.case))


def answer(measured: list[Point]) -> str:
    """Return where digits are lost."""
    return verdict(
        measured,
        "Mass ratios as such lose no digits: the equations of the loops do not contain masses. At "
        "speed the inertial wrenches m L² ω² of single joint motions nearly cancel in shafts that "
        "turn about themselves, and what is left is that much less exact.",
    )
