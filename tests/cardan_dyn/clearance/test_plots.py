"""Results with clearance draw themselves, by the figures that `clearance.drawing` has."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from testkit.loose_needle_drive import JOINT, simulated
from testkit.pin_rigs import scene

pytest.importorskip("matplotlib", reason="figures need matplotlib")

import cardan_dyn as cd
from cardan_dyn.clearance import Scan, influence, scan, scan_map

GIVEN: dict[str, Any] = {"radius": 0.018, "clearance": 2e-5, "stiffness": 5e7, "bearings": "pin_in"}


@pytest.fixture(scope="module")
def scanned() -> Scan:
    crank = cd.Scene(cd.load("slider_crank"), drive="crank_bearing", loads={"piston_guide": -300.0})
    return scan(crank, 120.0, clearance=1e-4, stiffness=1e8, damping_ratio=0.2)


@pytest.mark.slow
def test_a_scan_draws_its_ranking_and_more(scanned: Scan) -> None:
    forces, _ = scanned.plot().axes
    assert [label.get_text() for label in forces.get_yticklabels()] == scanned.ranking
    assert len(scanned.plot.reversals().axes) == len(scanned.ranking)
    assert scanned.plot.peak_factor().axes and scanned.plot.influence("mass").axes
    (axes,) = scanned.plot("peak", x="position", marker="o").axes
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), scanned.table().columns()["peak"][0])
    with pytest.raises(cd.ArgumentError, match="no option 'color' of this figure"):
        scanned.plot(color="red")


def test_all_polar_diagrams_of_a_scan_have_one_scale(scanned: Scan) -> None:
    widths = {round(float(np.ptp(axes.get_xlim())), 6) for axes in scanned.plot.reversals().axes}
    assert len(widths) == 1


@pytest.mark.slow
def test_joints_and_maps_draw_themselves() -> None:
    rig = scene("thoma_rig", 0.3)
    joint = scan(rig, 100.0, joints="cross", **GIVEN)["cross"]
    assert [line.get_label() for line in joint.plot().axes[0].lines[:2]] == ["pin_in+", "pin_in-"]
    held = {"joint_angle": np.radians([10.0, 30.0])}
    mapped = scan_map(rig, [300.0, 100.0], "cross", held=held, **GIVEN)
    assert len(mapped.plot().axes[0].lines) == 4


def test_an_influence_says_where_its_estimate_holds(scanned: Scan) -> None:
    # Of pins whose force vanishes, and of one whose force turns through.
    worst = min(
        (item for one in scanned.values() for item in one.reversals),
        key=lambda item: item.turn_through,
    )
    found = influence(worst, "clearance")
    middle = len(found.factor) // 2
    assert found.flown[middle] == pytest.approx(worst.flown)
    # Wider clearances take longer to cross: the angle flown grows with their root or faster.
    assert np.all(np.diff(found.flown) > 0.0)
    np.testing.assert_array_equal(
        found.holds,
        np.isfinite(found.peak)
        & (found.tau >= 3.0)
        & (found.flown <= 0.4)
        & (found.turn_through <= 0.03),
    )
    assert found.turn_through[middle] == pytest.approx(worst.turn_through)
    faster = influence(worst, "slope", [0.5, 1.0, 2.0])
    assert faster.flown[0] > worst.flown > faster.flown[2]
    (axes,) = found.plot().axes
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), found.peak)


@pytest.mark.slow
def test_a_simulation_draws_force_and_orbit() -> None:
    simulation = simulated()
    (axes,) = simulation.plot(turns=9.0).axes
    assert JOINT in axes.get_ylabel()
    assert simulation.plot.orbit().axes[0].get_xlabel().startswith("way 1")
    (axes,) = simulation[JOINT].plot().axes
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), simulation[JOINT].force)
