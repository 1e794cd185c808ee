"""Arrangement: points of both views, angles and bearings in the drawing."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="figures need matplotlib")

from testkit.line_data import random_line

from cardan_dyn.drive_lines import DriveLine, Shaft
from cardan_dyn.drive_lines.drawing import line_points


def test_views_show_points_angles_and_bearings() -> None:
    line = random_line(3, 1)
    side, plan = line.plot().axes
    points = line_points(line)
    for panel, axis in ((side, 2), (plan, 1)):
        drawn = [artist.get_xydata() for artist in panel.lines]
        for k in range(4):
            np.testing.assert_allclose(drawn[k], points[k : k + 2][:, [0, axis]], atol=1e-12)
        assert len(drawn[-1]) == len(line.bearings)
        texts = "\n".join(text.get_text() for text in panel.texts)
        assert f"β3 = {np.degrees(line.joint_angles[2]):.2f}°" in texts
        assert f"fork {np.degrees(line.fork_offsets[0]):.2f}°" in texts
        assert "shaft_2" in texts and "output" in texts
    # A bearing lies on its shaft, behind the joint at its front.
    centre = line.shafts[1].bearings[0]
    place = line.geometry.centres[0] + centre.distance * line.geometry.directions[1]
    assert np.abs(side.lines[-1].get_xydata() - place[[0, 2]]).sum(axis=1).min() < 1e-12


def test_end_shafts_without_length_have_a_stub() -> None:
    line = DriveLine(shafts=[Shaft(), Shaft(length=1.0, slope_side=0.1), Shaft()])
    points = line_points(line)
    np.testing.assert_allclose(points[0], [-0.22, 0.0, 0.0], atol=1e-12)
    assert points[-1, 2] == points[-2, 2]
    assert "drive_line" in line.plot().get_suptitle()


def test_labels_of_close_joints_do_not_overlap() -> None:
    shafts = [Shaft(), Shaft(length=0.1), Shaft(length=1.0), Shaft()]
    panel = DriveLine(shafts=shafts).plot().axes[0]
    heights = [text.xyann[1] for text in panel.texts if text.get_text().startswith("β")]
    assert heights[0] < heights[1] and heights[2] == heights[0]
