"""Figures of clearance in pin bearings, against the scans that they show."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="figures need matplotlib")

from testkit.pin_rigs import scene

from cardan_dyn import ArgumentError, figures
from cardan_dyn.clearance import scan, scan_map
from cardan_dyn.motion.clearance import drawing

GIVEN: dict[str, Any] = {"radius": 0.018, "clearance": 2e-5, "stiffness": 5e7, "bearings": "pin_in"}
HELD = {"joint_angle": np.radians([10.0, 30.0])}


@pytest.mark.slow
def test_forces_and_peaks_over_the_angle(tmp_path: Path) -> None:
    found = scan(scene("thoma_rig", 0.3), 100.0, joints="cross", **GIVEN)["cross"]
    figure = drawing.pin_forces(found)
    assert all(path.stat().st_size > 5000 for path in figures.save(figure, tmp_path / "forces"))
    (axes,) = figure.axes
    first, second, points = axes.get_lines()
    assert [first.get_label(), second.get_label()] == ["pin_in+", "pin_in-"]
    np.testing.assert_allclose(first.get_ydata(), np.linalg.norm(found.force[:, 0], axis=1))
    np.testing.assert_allclose(points.get_ydata(), [item.peak for item in found.reversals])
    np.testing.assert_allclose(points.get_xdata(), [0.0, 90.0, 180.0, 270.0], atol=1e-9)
    assert points.get_label() == "peak with clearance"


@pytest.mark.slow
def test_peaks_over_speed(tmp_path: Path) -> None:
    found = scan_map(scene("thoma_rig", 0.3), [300.0, 100.0], "cross", held=HELD, **GIVEN)
    figure = drawing.pin_peaks(found)
    assert all(path.stat().st_size > 5000 for path in figures.save(figure, tmp_path / "peaks"))
    (axes,) = figure.axes
    lines = axes.get_lines()
    # At 30° and 300 rad/s the two-mass model knows no peak: then it is that without clearance.
    assert lines[2].get_ydata()[1] == lines[3].get_ydata()[1]
    assert [line.get_label() for line in lines[::2]] == [
        "joint_angle 10°, with clearance",
        "joint_angle 30°, with clearance",
    ]
    for index in (0, 1):
        np.testing.assert_array_equal(lines[2 * index].get_xdata(), [100.0, 300.0])
        np.testing.assert_allclose(lines[2 * index].get_ydata(), found.peak[index, ::-1])
        np.testing.assert_allclose(lines[2 * index + 1].get_ydata(), found.rigid_peak[index, ::-1])


@pytest.mark.slow
def test_one_speed_makes_no_line() -> None:
    found = scan_map(scene("thoma_rig", 0.3), 100.0, "cross", held=HELD, **GIVEN)
    with pytest.raises(ArgumentError, match="one speed only"):
        drawing.pin_peaks(found)
