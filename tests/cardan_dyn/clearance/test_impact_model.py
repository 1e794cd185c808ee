"""The two-mass model by its numbers: the paper's example, and stiffness that follows the peak."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from cardan_dyn import ArgumentError
from cardan_dyn.analytic.damped_impact import damped_peak
from cardan_dyn.clearance import ImpactModel, PinGeometry

PAPER = ImpactModel(3.6, 1e7, 1e-4, 360e3, start="rest")
PIN = PinGeometry(0.02, 0.01, seat_stiffness=3e7)


def test_the_papers_example() -> None:
    found = PAPER.estimate
    assert round(float(found.peak), 2) == 2181.89
    assert (round(float(found.rigid), 2), round(float(found.added), 2)) == (1191.31, 990.58)
    assert [round(float(e), 3) for e in PAPER.exponents] == [1.909, 0.636, 0.364, 0.318, 0.045]
    assert round(float(replace(PAPER, start="release").estimate.peak)) == 1833


@pytest.mark.parametrize("seat", [None, 3e7])
@pytest.mark.parametrize("damping", [0.0, 0.25])
def test_the_stiffness_is_that_at_the_peak(seat: float | None, damping: float) -> None:
    pin = PinGeometry(0.02, 0.01, seat_stiffness=seat)
    model = ImpactModel(2.0, pin, 1e-4, 1e6, damping)

    def beyond(force: float) -> float:
        stiffness = float(pin.stiffness(np.array(force), 1e-4))
        return float(damped_peak(2.0, stiffness, 0.5e-4, 1e6, damping)) - force

    expected = brentq(beyond, 10.0, 0.9 * pin.limit(1e-4), xtol=1e-9, rtol=1e-14)
    assert float(model.estimate.peak) == pytest.approx(expected, rel=1e-11)
    assert float(model.estimate.stiffness) == pytest.approx(
        float(pin.stiffness(np.array(expected), 1e-4)), rel=1e-11
    )


@pytest.mark.parametrize("law", [1e8, PIN])
@pytest.mark.parametrize("damping", [0.0, 0.25])
@pytest.mark.parametrize("start", ["release", "rest"])
def test_exponents_are_those_of_differences(law: Any, damping: float, start: Any) -> None:
    model = ImpactModel(2.0, law, 1e-4, 1e6, damping, start)
    steps = 1e-4 * np.array([-2.0, -1.0, 1.0, 2.0])
    for name in ("mass", "clearance", "slope", "stiffness"):
        if name == "stiffness" and isinstance(law, PinGeometry):
            continue
        given = getattr(model, name)
        peaks = [
            float(replace(model, **{name: given * np.exp(step)}).estimate.peak) for step in steps
        ]
        expected = np.log(peaks) @ [1.0, -8.0, 8.0, -1.0] / 12e-4
        assert float(getattr(model.exponents, name)) == pytest.approx(expected, abs=2e-9)
    assert float(model.exponents.speed) == pytest.approx(3.0 * float(model.exponents.slope))


def test_a_factor_on_the_stiffness_of_a_geometry() -> None:
    """All moduli and the seat times a factor: stiffness at a factor of the force."""
    model = ImpactModel(2.0, PIN, 1e-4, 1e6, 0.25)
    peaks = []
    for step in (-1e-4, 1e-4):

        def beyond(force: float, factor: float = np.exp(step)) -> float:
            stiffness = factor * float(PIN.stiffness(np.array(force), 1e-4))
            return float(damped_peak(2.0, stiffness, 0.5e-4, 1e6, 0.25)) - force

        peaks.append(brentq(beyond, 10.0, 1e5, xtol=1e-10, rtol=1e-14))
    expected = np.log(peaks[1] / peaks[0]) / 2e-4
    assert float(model.exponents.stiffness) == pytest.approx(expected, rel=1e-6)


def test_without_a_peak_there_is_no_exponent() -> None:
    model = ImpactModel(2.0, PIN, 1e-7, 1e7)
    assert np.isnan(model.estimate.peak)
    assert np.isfinite(model.estimate.tau)
    assert np.isnan(model.exponents).all()


def test_a_soft_contact_may_get_stiff_enough_for_a_peak() -> None:
    """None with the stiffness of a small force, and one with that of the peak."""
    pin = PinGeometry(4.6e-5, 0.01, seat_stiffness=1e7)
    model = ImpactModel(2.0, pin, 1e-4, 1e6)
    soft = float(pin.stiffness(np.array(0.1 * pin.limit(1e-4)), 1e-4))
    assert np.isnan(replace(model, stiffness=soft).estimate.peak)
    found = model.estimate
    again = replace(model, stiffness=float(pin.stiffness(found.peak, 1e-4))).estimate
    assert float(again.peak) == pytest.approx(float(found.peak), rel=1e-12)


def test_a_peak_beyond_the_contact_is_refused() -> None:
    with pytest.raises(ArgumentError, match=r"the peak exceeds .* a line contact"):
        _ = ImpactModel(2.0, PinGeometry(1e-5, 0.01, seat_stiffness=1e9), 1e-4, 1e7).estimate


def test_whole_arrays() -> None:
    masses, slopes = np.array([2.0, 3.0, 4.0]), np.array([1e6, 2e6, 5e5])
    found = ImpactModel(1.0, PIN, 1e-4, 1e6, 0.2).of(mass=masses, slope=slopes)
    for index, (mass, slope) in enumerate(zip(masses, slopes, strict=True)):
        one = ImpactModel(mass, PIN, 1e-4, slope, 0.2).estimate
        for name, value in one._asdict().items():
            assert float(getattr(found, name)[index]) == pytest.approx(float(value), rel=1e-13)


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"mass": 0.0}, "mass is 0"),
        ({"stiffness": float("inf")}, "stiffness is not finite"),
        ({"clearance": -1.0}, "clearance is -1"),
        ({"clearance": PIN}, "clearance"),
        ({"slope": [1.0, 2.0]}, r"slope has shape \(2,\), expected a number"),
        ({"damping_ratio": 1.0}, "damping_ratio"),
        ({"start": "run"}, "start is 'run'"),
    ],
)
def test_bad_input(change: dict[str, Any], match: str) -> None:
    with pytest.raises(ArgumentError, match=match):
        replace(PAPER, **change)


def added(stiffness: float, half: float) -> float:
    """What the clearance adds to the ramp at an undamped peak [N]."""
    found = ImpactModel(3.6, stiffness, 2.0 * half, 360e3).estimate
    return float(found.added)


def power(values: list[float], sizes: list[float]) -> float:
    return float(np.log(values[1] / values[0]) / np.log(sizes[1] / sizes[0]))


def test_what_the_play_adds_where_contacts_are_stiff() -> None:
    """∛(18 s² k / m) √(c m): as s^(2/3) and √c, where τ is great."""
    stiff, small = [1e12, 4e12], [1e-6, 4e-6]
    assert power([added(c, 1e-6) for c in stiff], stiff) == pytest.approx(0.5, abs=0.05)
    assert power([added(1e12, s) for s in small], small) == pytest.approx(2.0 / 3.0, abs=0.05)
    predicted = np.cbrt(18.0 * 1e-12 * 360e3 / 3.6) * np.sqrt(1e12 * 3.6)
    assert added(1e12, 1e-6) == pytest.approx(predicted, rel=0.05)


def test_the_rigid_force_is_the_limit_only_if_the_play_vanishes_fast_enough() -> None:
    """Along c ∝ s^(-p) the added part falls as s^(2/3 - p/2): for p below 4/3 alone."""
    small = [1e-7, 1e-9]
    for p, falls in ((1.0, 1.0 / 6.0), (1.6, -2.0 / 15.0)):
        parts = [added(1e13 * (s / 1e-7) ** -p, s) for s in small]
        assert power(parts, small) == pytest.approx(falls, abs=0.05)


def test_a_given_play_and_ever_stiffer_contacts() -> None:
    stiff = [1e12, 1e14]
    peaks = [float(ImpactModel(3.6, c, 1e-4, 360e3).estimate.peak) for c in stiff]
    assert power(peaks, stiff) == pytest.approx(0.5, abs=0.005)
