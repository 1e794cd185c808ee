"""The force over the drive's position: simulated, without clearance, and estimated peaks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="figures need matplotlib")

from testkit.drawings import check_units_and_files
from testkit.loose_needle_drive import JOINT, SPEED, scanned, simulated

import cardan_dyn as cd
from cardan_dyn.clearance import scan
from cardan_dyn.motion.clearance import drawing


@pytest.mark.slow
def test_the_line_has_every_peak_of_the_simulation(tmp_path: Path) -> None:
    simulation = simulated()
    figure = drawing.contact_course(simulation, JOINT, turns=9.0, title="course")
    check_units_and_files(figure, tmp_path)
    (axes,) = figure.axes
    (line,) = axes.get_lines()
    degrees, force = line.get_data()
    turned = np.rad2deg(simulation[JOINT].position)
    assert degrees[[0, -1]] == pytest.approx(turned[[0, -1]])
    impacts = simulation[JOINT].struck
    assert len(impacts) >= 2
    for item in impacts:
        at = np.rad2deg(simulation.at([item.peak_time])[JOINT].position[0])
        assert np.interp(at, degrees, force) == pytest.approx(item.peak, rel=1e-7)
    # Nothing presses the pin before it strikes.
    before = np.searchsorted(degrees, np.rad2deg(impacts[0].position) - 1.0)
    assert force[before] == 0.0


@pytest.mark.slow
def test_beside_the_force_without_play_and_the_estimates() -> None:
    figure = drawing.contact_course(simulated(), JOINT, scanned=scanned())
    (axes,) = figure.axes
    simulation, rigid, *points = axes.get_lines()
    assert np.ptp(simulation.get_xdata()) == pytest.approx(360.0, abs=5.0)
    drive = cd.Scene(cd.load("needle_drive"), drive="main_shaft")
    angles = np.deg2rad(rigid.get_xdata()[::200])
    force = drive.sweep(angles, speed=SPEED)[JOINT].force[:, :2]
    expected = np.hypot(*force.T)
    drawn = rigid.get_ydata()[::200]
    np.testing.assert_allclose(drawn, expected, atol=2e-4 * np.max(expected))
    found = scanned()[JOINT].reversals
    assert len(points) == 2
    assert sorted(float(p.get_ydata()[0]) for p in points) == sorted(r.peak for r in found)
    struck = [np.rad2deg(r.position + SPEED * r.contact_time) for r in found]
    for point in points:
        turns = (float(point.get_xdata()[0]) - np.array(struck)) / 360.0
        assert np.min(np.abs(turns - np.round(turns))) < 1e-9


@pytest.mark.parametrize("turns", [0.0, -1.0, [1.0, 2.0]])
def test_bad_turns(turns: Any) -> None:
    with pytest.raises(cd.ArgumentError, match="turns"):
        drawing.contact_course(simulated(), JOINT, turns=turns)


def test_what_does_not_belong_together() -> None:
    with pytest.raises(cd.ModelError, match="has clearance"):
        drawing.contact_course(simulated(), "rocker_pin")
    drive = cd.Scene(cd.load("needle_drive"), drive="main_shaft")
    other = scan(drive, 200.0, joints=JOINT, clearance=1e-4, stiffness=1e8)
    with pytest.raises(cd.ArgumentError, match="of 200 rad/s, the simulation of 300"):
        drawing.contact_course(simulated(), JOINT, scanned=other)
