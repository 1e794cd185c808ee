"""How many digits are left of a universal joint's reactions as its angle approaches 90°?

Unit torque, quasi-static, β from 1° to 89.99°; the parameter is 90° − β. Three samples: both main
positions and one between them.
"""

from __future__ import annotations

import numpy as np

from .descriptions import mechanics
from .maps import verdict
from .methods import methods
from .stress import Case, Point, measure

NAME, LABEL = "angle", "90° − β [°]"
GRID = (89.0, 81.5, 60.0, 40.0, 20.0, 10.0, 5.0, 3.0, 1.0, 0.3, 0.1, 0.03, 0.01)
POSITIONS = (0.0, 0.3, 0.5 * np.pi)


def points(grid: tuple[float, ...] = GRID) -> list[Point]:
    """Return the map."""
    urdf = mechanics("universal_joint")
    return [
        measure(
            NAME,
            "universal joint, quasi-static",
            rest,
            Case(
                urdf,
                "bearing_in",
                POSITIONS,
                {"joint_angle": float(np.deg2rad(90.0 - rest))},
                {"bearing_out": -1.0},
                method=method,
            ),
        )
        for method in methods()
        for rest in grid
    ]


def answer(measured: list[Point]) -> str:
    """Return where digits are lost."""
    return verdict(
        measured,
        "Digits are lost in the main position in which the output turns slowest per turn of the "
        "input, D₂ = D₁ cos β, in proportion to 1/cos β, as the condition number says; "
        "everywhere else none are lost.",
    )
