"""Drive lines from a file to forces: what users see of the whole."""

from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.drive_lines import DriveLine

FILE = """
speed_rpm = 1500
torque_nm = 300
[[shafts]]
slope_side_deg = -3
bearings = [{ distance_mm = 60 }, { distance_mm = 180 }]
[[shafts]]
length_mm = 1200
slope_side_deg = 6
tube = { outer_diameter_mm = 90, wall_mm = 3 }
spline = {}
[[shafts]]
slope_side_deg = -3
bearings = [{ distance_mm = 70 }, { distance_mm = 220 }]
"""


def test_a_z_arrangement_from_its_file() -> None:
    line = DriveLine.from_toml(FILE)
    turn = line.analyse()
    assert np.degrees(line.joint_angles) == pytest.approx([9, 9])
    assert np.ptp(turn.ratio[:, -1]) < 1e-13
    assert np.ptp(turn.ratio[:, 1]) == pytest.approx(np.sin(np.radians(9)) * np.tan(np.radians(9)))
    # With the drive pin across the plane of the shafts: T tan β / a and T sin β / (f cos β).
    greatest = dict(zip(turn.bearings, turn.static.bearing_radial.max(axis=0), strict=True))
    assert greatest["A"] == pytest.approx(300 * np.tan(np.radians(9)) / 0.12, rel=1e-12)
    assert greatest["F"] == pytest.approx(300 * np.tan(np.radians(9)) / 0.15, rel=1e-12)
    assert turn.inertial is not None
    assert np.all(turn.inertial.bearing_radial.max(axis=0) > 0.1)


def test_the_description_alone_gives_the_same() -> None:
    line = DriveLine.from_toml(FILE)
    scene = cd.Scene(cd.load(line.to_urdf()), loads={"bearing_out": -300.0})
    sweep = scene.sweep(np.radians(np.arange(0, 360)))
    turn = line.analyse(speed=0, torque_at="output")
    found = np.linalg.norm(sweep["support_A"].force, axis=1)
    assert found == pytest.approx(np.linalg.norm(turn.total.bearing_force[:, 1], axis=1), rel=1e-11)
    assert np.all(sweep.unique)
