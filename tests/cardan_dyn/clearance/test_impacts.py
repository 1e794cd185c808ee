"""Impacts of all pins at once: the same as of each alone."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn import ArgumentError
from cardan_dyn.analytic.clearance import contact_time
from cardan_dyn.clearance import ImpactModel, PinGeometry, scan

PIN = PinGeometry(0.02, 0.01, seat_stiffness=5e7)


@pytest.fixture(scope="module")
def drive() -> cd.Scene:
    return cd.Scene(cd.load("needle_drive"), drive="main_shaft")


def test_numbers_and_geometries_side_by_side(drive: cd.Scene) -> None:
    laws: dict[str, Any] = {"coupler_pin": PIN, "needle_pin": 1e8, "rocker_pin": 3e7}
    clearances = {"coupler_pin": 1e-4, "needle_pin": 5e-5, "rocker_pin": 2e-4}
    found = scan(
        drive, 300.0, joints=list(laws), clearance=clearances, stiffness=laws, damping_ratio=0.2
    )
    for name, law in laws.items():
        alone = scan(
            drive, 300.0, joints=name, clearance=clearances, stiffness=laws, damping_ratio=0.2
        )
        for item, other in zip(found[name].reversals, alone[name].reversals, strict=True):
            ratio = item.model.damping_ratio
            model = ImpactModel(item.reduced_mass, law, clearances[name], item.force_slope, ratio)
            assert item.model == model
            assert item.two_mass_peak == pytest.approx(float(model.estimate.peak), rel=1e-12)
            assert item.two_mass_peak == pytest.approx(other.two_mass_peak, rel=1e-12)
            assert item.stiffness == pytest.approx(float(model.estimate.stiffness), rel=1e-12)
    assert found["coupler_pin"].reversals[0].stiffness < 5e7


def test_what_no_contact_carries_names_its_joint(drive: cd.Scene) -> None:
    thin = {"coupler_pin": PinGeometry(2e-5, 0.01), "needle_pin": 1e8}
    with pytest.raises(ArgumentError, match="joint 'coupler_pin': the peak exceeds"):
        scan(drive, 300.0, joints=list(thin), clearance=1e-4, stiffness=thin)


@pytest.mark.slow
def test_contact_alone_is_noted(drive: cd.Scene) -> None:
    bare = PinGeometry(0.02, 0.01)
    found = scan(drive, 300.0, clearance=1e-4, stiffness={**dict.fromkeys(drive.outputs, PIN)})
    assert found.notes == ()
    stiff = scan(drive, 300.0, joints="needle_pin", clearance=1e-4, stiffness=bare)
    assert "about a hundredfold" in stiff.notes[0] and "needle_pin" in stiff.notes[0]
    assert "- note: needle_pin" in str(stiff)
    assert any("line contact alone" in doubt for doubt in stiff["needle_pin"].reversals[0].doubts)


def test_swings_far_from_zero_are_counted_and_dropped() -> None:
    scene = cd.Scene(
        cd.load("slider_crank"), drive="crank_bearing", loads={"piston_guide": -1000.0}
    )
    found = scan(scene, 100.0, joints="piston_pin", clearance=1e-4, stiffness=1e8)["piston_pin"]
    assert found.reversals == () and found.turning == 2
    assert "turns through 2 times" in found.verdict
    sizes = np.linalg.norm(found.force, axis=1)
    least = (sizes < np.roll(sizes, 1)) & (sizes <= np.roll(sizes, -1))
    assert np.count_nonzero(least) == 2 and np.min(sizes) > 100.0


def test_swings_far_from_zero_ask_for_no_stiffness() -> None:
    """Their ramp would make a peak that no such contact carries."""
    scene = cd.Scene(
        cd.load("slider_crank"), drive="crank_bearing", loads={"piston_guide": -1000.0}
    )
    weak = PinGeometry(1e-6, 0.01)
    found = scan(scene, 100.0, joints="piston_pin", clearance=1e-4, stiffness=weak)["piston_pin"]
    assert found.turning == 2
    assert found.peak == found.rigid_peak and "no interval is known: a force of" in found.doubts[0]
    with pytest.raises(ArgumentError, match="joint 'crank_bearing': the peak exceeds"):
        scan(scene, 100.0, joints="crank_bearing", clearance=1e-4, stiffness=weak)


@pytest.mark.parametrize("stiffness", [1e7, PinGeometry(2.0, 0.01, seat_stiffness=1e7)])
def test_released_with_damping_flights_may_last_longer_than_from_rest(
    drive: cd.Scene, stiffness: float | PinGeometry
) -> None:
    """A swing is judged by its own flight: its force may exceed what the ramp gains from rest."""
    contact: dict[str, Any] = {"clearance": 1e-7, "stiffness": stiffness, "damping_ratio": 0.9}
    found = scan(drive, 600.0, joints=["main_shaft", "eccentric_pin"], **contact)
    for name in found:
        assert len(found[name].reversals) == 2
        for item in found[name].reversals:
            from_rest = float(contact_time(item.reduced_mass, 0.5e-7, item.force_slope))
            assert item.turn_through < 1.0 < item.turn_through * item.contact_time / from_rest
    rested = scan(drive, 600.0, joints=["main_shaft", "eccentric_pin"], start="rest", **contact)
    assert not any(rested[name].reversals for name in rested)
