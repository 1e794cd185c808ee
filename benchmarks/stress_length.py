"""Do lengths from 1e-6 to 1e6 m cost digits?

All lengths of a double shaft and of a four-bar linkage times the parameter, masses kept; and the
double shaft that many metres away from the world's origin.
"""

from __future__ import annotations

from .descriptions import mechanics, with_length
from .maps import verdict
from .methods import methods
from .stress import Case, Point, measure

NAME, LABEL = "length", "lengths over those of the description"
GRID = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6)
HELD = {"joint_angle_1": 0.4, "joint_angle_2": 0.3}
POSITIONS = (0.1, 0.9, 2.0)


def distant(urdf: str, distance: float) -> str:
    """Return a double shaft at a distance from the world's origin."""
    first = '<child link="shaft_in"/>'
    second = '<child link="carrier"/>'
    for child in (first, second):
        start = urdf.index(child)
        urdf = urdf[:start] + urdf[start:].replace(
            '<origin xyz="0 0 0"/>', f'<origin xyz="{distance!r} 0 0"/>', 1
        )
    return urdf


def points(grid: tuple[float, ...] = GRID) -> list[Point]:
    """Return the map."""
    measured = []
    for method in methods():
        for factor in grid:
            urdf = with_length(mechanics("double_shaft_z"), factor)
            case = ("bearing_in", POSITIONS, HELD, {"bearing_out": -1.0})
            still = Case(urdf, *case, method=method)
            fast = Case(urdf, *case, 30.0, 5.0, method=method)
            measured.append(measure(NAME, "quasi-static", factor, still))
            measured.append(measure(NAME, "at speed", factor, fast))
            linkage = with_length(mechanics("four_bar"), factor)
            bars = Case(
                linkage,
                "crank_bearing",
                POSITIONS,
                {},
                {"rocker_bearing": -1.0},
                3.0,
                method=method,
            )
            measured.append(measure(NAME, "four-bar at 3 rad/s", factor, bars))
            if factor >= 1.0:
                away = distant(mechanics("double_shaft_z"), factor)
                far = Case(away, *case, method=method)
                measured.append(measure(NAME, "this far from the origin", factor, far))
    return sorted(measured, key=lambda point: (point.method, point.case))


def answer(measured: list[Point]) -> str:
    """Return where digits are lost."""
    return verdict(
        measured,
        "Lengths lose no digits, and the stated condition number is free of their unit.",
    )
