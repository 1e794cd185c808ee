"""What is left of the reactions at speeds up to 1e5 rad/s?

A universal joint at 50° and a double shaft, with a unit torque and their masses.
"""

from __future__ import annotations

import numpy as np

from .descriptions import mechanics
from .maps import verdict
from .methods import methods
from .stress import Case, Point, measure

NAME, LABEL = "speed", "speed [rad/s]"
GRID = (1e-2, 1e-1, 1.0, 3.0, 10.0, 30.0, 100.0, 1e3, 1e4, 1e5)
POSITIONS = (0.0, 0.3, 2.0)
CASES = {
    "universal_joint": {"joint_angle": float(np.deg2rad(50.0))},
    "double_shaft_z": {"joint_angle_1": 0.4, "joint_angle_2": 0.4},
    "four_bar": {},
}


def points(grid: tuple[float, ...] = GRID) -> list[Point]:
    """Return the map."""
    measured = []
    for method in methods():
        for name, held in CASES.items():
            drive = "crank_bearing" if name == "four_bar" else "bearing_in"
            load = "rocker_bearing" if name == "four_bar" else "bearing_out"
            for speed in grid:
                case = Case(
                    mechanics(name), drive, POSITIONS, held, {load: -1.0}, speed, method=method
                )
                measured.append(measure(NAME, name.replace("_", " "), speed, case))
    return measured


def answer(measured: list[Point]) -> str:
    """Return where digits are lost."""
    return verdict(
        measured,
        "A linkage whose links truly accelerate loses nothing. In shafts that turn about "
        "themselves the wrench is far less than m L² ω² of single joint motions, and the "
        "stated condition number counts that ratio.",
    )
