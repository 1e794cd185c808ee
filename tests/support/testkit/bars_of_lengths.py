"""A four-bar whose frame is lengthened by a held slide."""

from __future__ import annotations

import numpy as np

import cardan_dyn as cd


def four_bar_of_lengths() -> cd.Mechanism:
    """Return a crank-rocker of 0.1, 0.35 and 0.3 m in a frame of 0.4 m, which `frame` lengthens."""
    along = 0.3 / 2.0 + (0.35**2 - 0.3**2) / (2.0 * 0.3)
    up = float(np.sqrt(0.35**2 - along**2))
    coupler, rocker = np.arctan2(up, along), np.arctan2(up, along - 0.3)
    joint = (
        '<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/>'
        '<origin xyz="{} 0 0" rpy="0 0 {!r}"/><axis xyz="{}"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
    )
    turn = "0 0 1"
    return cd.load(
        '<robot name="bars">'
        + "".join(f'<link name="{name}"/>' for name in ("base", "crank", "bar", "end", "rocker"))
        + joint.format("drive", "continuous", "base", "crank", 0, 0.0, turn)
        + joint.format("pin", "continuous", "crank", "bar", 0.1, float(coupler), turn)
        + joint.format("frame", "prismatic", "base", "end", 0.4, 0.0, "1 0 0")
        + joint.format("bearing", "continuous", "end", "rocker", 0, float(rocker), turn)
        + '<loop name="top" type="continuous"><predecessor link="bar"><origin xyz="0.35 0 0"/>'
        '</predecessor><successor link="rocker"><origin xyz="0.3 0 0"/></successor>'
        '<axis xyz="0 0 1"/></loop></robot>'
    )
