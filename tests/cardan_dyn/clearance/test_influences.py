"""How peaks change with one parameter, against the closed forms at each value."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn import ArgumentError
from cardan_dyn.analytic import impact
from cardan_dyn.analytic.damped_impact import damped_peak, flight
from cardan_dyn.clearance import ImpactModel, PinGeometry, influence, scan

PAPER = ImpactModel(3.6, 1e7, 1e-4, 360e3, start="rest")
DAMPED = ImpactModel(2.0, 1e8, 1e-4, 1e6, 0.2)
PIN = PinGeometry(0.02, 0.01, seat_stiffness=3e7)


@pytest.mark.parametrize("model", [PAPER, DAMPED])
@pytest.mark.parametrize("name", ["mass", "clearance", "slope", "stiffness", "speed"])
def test_peaks_are_those_of_the_closed_form_at_each_value(model: ImpactModel, name: str) -> None:
    found = influence(model, name)
    assert found.factor[0] == pytest.approx(0.2) and found.factor[-1] == pytest.approx(5.0)
    for index in (0, 20, 48, 96):
        factor = float(found.factor[index])
        values = {key: getattr(model, key) for key in ("mass", "stiffness", "clearance", "slope")}
        if name == "speed":
            values["slope"] *= factor**3
        else:
            values[name] *= factor
            assert found.value[index] == pytest.approx(values[name])
        contact = values["mass"], values["stiffness"], 0.5 * values["clearance"], values["slope"]
        undamped = impact.reversal(*contact, start=model.start)
        peak, speed = undamped.peak, undamped.v_1
        if model.damping_ratio:
            peak = damped_peak(*contact, model.damping_ratio, start=model.start)
            speed = flight(*contact, model.damping_ratio, start=model.start).v_1
        assert float(found.peak[index]) == pytest.approx(float(peak), rel=1e-12, nan_ok=True)
        assert float(found.tau[index]) == pytest.approx(float(undamped.tau), rel=1e-12)
        assert float(found.impact_speed[index]) == pytest.approx(float(speed), rel=1e-12)
    near = influence(model, name, np.exp([-1e-4, 1e-4])).peak
    assert found.exponent == pytest.approx(np.log(near[1] / near[0]) / 2e-4, rel=1e-6)


def test_bild_8_has_a_least_peak_over_the_stiffness() -> None:
    """The soft joint carries the ramp, the stiff one the impact."""
    found = influence(PAPER, "stiffness", np.geomspace(0.05, 5.0, 200))
    least = int(np.argmin(found.peak))
    assert 0 < least < 199
    # d ln g / d ln τ = 1 there.
    at = replace(PAPER, stiffness=float(found.value[least]))
    assert float(at.exponents.stiffness) == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize("name", ["mass", "clearance", "slope", "speed"])
def test_a_geometry_follows_force_and_play(name: str) -> None:
    model = ImpactModel(2.0, PIN, 1e-4, 1e6, 0.2)
    found = influence(model, name, [0.8, 2.0])
    for factor, peak in zip((0.8, 2.0), found.peak, strict=True):
        key, power = ("slope", 3.0) if name == "speed" else (name, 1.0)
        changed = replace(model, **{key: getattr(model, key) * factor**power})
        assert float(peak) == pytest.approx(float(changed.estimate.peak), rel=1e-12, nan_ok=True)


def test_the_stiffness_of_a_geometry_is_varied_from_that_at_the_peak() -> None:
    model = ImpactModel(2.0, PIN, 1e-4, 1e6, 0.2)
    found = influence(model, "stiffness", [1.0, 2.0])
    assert found.value[0] == pytest.approx(float(model.estimate.stiffness))
    assert found.peak[0] == pytest.approx(float(model.estimate.peak), rel=1e-12)


def test_the_speed_of_a_scanned_joint_is_that_of_other_scans() -> None:
    drive = cd.Scene(cd.load("needle_drive"), drive="main_shaft")
    options: dict[str, Any] = {"joints": "coupler_pin", "clearance": 1e-4, "stiffness": 1e8}
    item = scan(drive, 200.0, **options)["coupler_pin"].reversals[0]
    found = influence(item, "speed", [0.5, 2.0])
    for k, (speed, peak) in enumerate(zip((100.0, 400.0), found.peak, strict=True)):
        other = scan(drive, speed, **options)["coupler_pin"].reversals[0]
        assert float(peak) == pytest.approx(other.two_mass_peak, rel=1e-8, nan_ok=True)
        assert found.flown[k] == pytest.approx(other.flown, rel=1e-8)
        # The least force is rounding where it reverses.
        assert found.turn_through[k] == pytest.approx(other.turn_through, rel=1e-6, abs=1e-9)
    loaded = replace(item, slope_growth=2.5)
    with pytest.raises(ArgumentError, match="more than inertia"):
        influence(loaded, "speed")


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        ((PAPER, "length"), "parameter 'length' is unknown"),
        ((3.0, "clearance"), "expected a reversal"),
        ((PAPER, "clearance", [1.0, 0.0]), "positive"),
        ((PAPER, "clearance", [[1.0]]), r"factors has shape \(1, 1\)"),
    ],
)
def test_bad_input(arguments: tuple[Any, ...], match: str) -> None:
    with pytest.raises(ArgumentError, match=match):
        influence(*arguments)


def test_nothing_can_be_written_to() -> None:
    with pytest.raises(ValueError, match="read-only"):
        influence(PAPER, "clearance").peak[0] = 0.0
