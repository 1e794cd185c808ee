"""What is said of reversals in pin bearings."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cardan_dyn.clearance import ImpactModel, PinReversal, PinScan


def reversal(**changes: Any) -> PinReversal:
    model = ImpactModel(mass=2.0, stiffness=1e8, clearance=1e-5, slope=1e5)
    found = {name: float(value) for name, value in model.estimate._asdict().items()}
    given: dict[str, Any] = {
        "position": 1.0,
        "force_slope": 1e5,
        "direction": np.array([0.0, 1.0, 0.0]),
        "reduced_mass": 2.0,
        "guided_mass": 2.0,
        "turn_through": 0.0,
        "flown": 0.2,
        "mass_change": 0.0,
        "deviation": 0.0,
        "slope_growth": 3.0,
        "model": model,
        "share": (1.0, 1.0, 0.5, 0.5),
        **found,
    }
    return PinReversal(**{**given, **changes})


def scan(*reversals: PinReversal) -> PinScan:
    force = np.zeros((360, 4, 3))
    force[10, 2] = [0.0, 30.0, 40.0]
    return PinScan(
        name="cross",
        position=np.radians(np.arange(360.0)),
        force=force,
        reversals=reversals,
        turning=0,
        periods=2.0,
        bearings=("a+", "a-", "b+", "b-"),
        freedoms=5,
        radius={"a": 0.05, "b": 0.04},
        clearance={"a": 1e-5, "b": 2e-5},
        stiffness={"a": 1e8, "b": 1e8},
        speed=12.0,
    )


def test_energy_is_that_of_all_bearings() -> None:
    item = reversal()
    assert item.energy == pytest.approx(2.5 * 0.5 * 2.0 * item.impact_speed**2)
    assert scan(item, item).impact_power == pytest.approx(2.0 * 2.0 * item.energy)


def test_bearings_that_do_not_close_together_are_a_doubt() -> None:
    doubt, _ = reversal(tau=5.0, split=0.2).doubts
    assert doubt == "the bearings do not close together (20 % of the clearance)"
    assert reversal(split=0.2).row()["split"] == 0.2


def test_the_interval_that_pin_bearings_lack_is_a_doubt() -> None:
    """The last of them; single bearings have it as well, and what is printed tells of it."""
    item = reversal(tau=5.0)
    (doubt,) = item.doubts
    assert np.isnan(item.least) and np.isnan(item.greatest)
    assert "no interval is known: simulate" in doubt
    assert doubt in item.verdict and doubt in str(scan(item))
    assert scan(item).by_bearing()["a+"].reversals[0].doubts == (doubt,)


def test_the_greatest_force_is_that_of_one_bearing() -> None:
    assert scan().rigid_peak == pytest.approx(50.0)
    assert scan(reversal()).peak == pytest.approx(reversal().peak)


def test_torsional_clearance_is_of_pins_with_both_bearings_open() -> None:
    assert scan().torsional_clearance == pytest.approx(1e-5 / 0.05 + 2e-5 / 0.04)


def test_table_and_text() -> None:
    frame = scan(reversal(), reversal(position=2.0)).to_dataframe()
    assert list(frame["position"]) == [1.0, 2.0]
    assert set(frame["joint"]) == {"cross"}
    text = str(scan(reversal()))
    assert text.startswith("clearance in a+, a-, b+, b- of cross at 12 rad/s: 1 reversal,")


def test_each_bearing_has_its_share() -> None:
    item = reversal()
    found = scan(item).by_bearing()
    assert list(found) == ["a+", "a-", "b+", "b-"]
    assert found["a-"].reversals[0].peak == item.peak
    assert found["b-"].reversals[0].peak == pytest.approx(0.5 * item.peak)
    assert [found[name].rigid_peak for name in found] == pytest.approx([0.0, 0.0, 50.0, 0.0])
