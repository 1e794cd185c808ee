"""Arrangement: points of both views, angles and bearings in the drawing."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="figures need matplotlib")

from testkit.line_data import random_line

from cardan_dyn.drive_lines import DriveLine, Shaft
from cardan_dyn.practice.drive_lines.drawing import line_points


def test_views_say_angles_forks_and_names() -> None:
    line = random_line(3, 1)
    side, plan = ("\n".join(text.get_text() for text in axes.texts) for axes in line.plot().axes)
    angle = f"β3 = {np.degrees(line.joint_angles[2]):.5g}°"
    assert angle in side and angle in plan
    assert f"fork {np.degrees(line.fork_offsets[0]):.6g}°" in plan
    assert all(name in side and name in plan for name in ("input", "shaft_2", "output"))
    assert f"{1000.0 * line.shafts[1].length:.1f}\N{NO-BREAK SPACE}mm" in side


def test_end_shafts_without_length_have_a_stub() -> None:
    line = DriveLine(shafts=[Shaft(), Shaft(length=1.0, slope_side=0.1), Shaft()])
    points = line_points(line)
    np.testing.assert_allclose(points[0], [-0.2, 0.0, 0.0], atol=1e-12)
    assert points[-1, 2] == points[-2, 2]
