"""What happens when axes that should meet miss each other by 1e-12 to 1e-3 m?

A double shaft whose spline lets it move nevertheless, and a universal joint between fixed
bearings, which misalignment locks.
"""

from __future__ import annotations

from .descriptions import mechanics, with_miss
from .maps import verdict
from .methods import methods
from .stress import Case, Point, measure

NAME, LABEL = "misalignment", "distance between axes [m]"
GRID = (1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3)
HELD = {"joint_angle_1": 0.4, "joint_angle_2": 0.3}
POSITIONS = (0.1, 0.9, 2.0)


def points(grid: tuple[float, ...] = GRID) -> list[Point]:
    """Return the map."""
    measured = []
    for method in methods():
        for miss in grid:
            free = with_miss(mechanics("double_shaft_z"), "pin_1_out", miss)
            case = ("bearing_in", POSITIONS, HELD, {"bearing_out": -1.0})
            still, fast = Case(free, *case, method=method), Case(free, *case, 30.0, method=method)
            locked = Case(
                with_miss(mechanics("universal_joint"), "pin_out", miss),
                "bearing_in",
                POSITIONS,
                {"joint_angle": 0.7},
                {"bearing_out": -1.0},
                method=method,
            )
            measured += [
                measure(NAME, "double shaft, quasi-static", miss, still),
                measure(NAME, "double shaft, at speed", miss, fast),
                measure(NAME, "joint between fixed bearings", miss, locked),
            ]
    return sorted(measured, key=lambda point: (point.method, point.case))


def answer(measured: list[Point]) -> str:
    """Return where digits are lost."""
    return verdict(
        measured,
        "Where the mechanism can still move, no digits are lost at any distance. Between fixed "
        "bearings a joint with a miss cannot turn: below the closure tolerance of 1e-10 of the "
        "mechanism's length it counts as exact, and the loop residual reports the miss; above it "
        "is refused.",
    )
