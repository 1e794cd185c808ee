"""Extremes between samples, against polynomials, closed forms and finer samples."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.line_data import end_bearings, random_line

from cardan_dyn.analytic import grossmann
from cardan_dyn.drive_lines import DriveLine, DutyPoint, Shaft
from cardan_dyn.kit.extremes import greatest
from cardan_dyn.practice.drive_lines.verdict.extremes import greatest_over

SHAPES = np.linspace(-0.9, 0.9, 7)


@pytest.mark.parametrize("count", [95, 96])
def test_greatest_values_of_kernels(count: int) -> None:
    # 1 / |1 - a e^(i(φ - φ₀))|² is greatest at φ₀, or opposite to it, wherever samples are.
    phi = 2.0 * np.pi * np.arange(count) / count
    shapes, places = 0.5 * SHAPES, np.arange(7.0)
    values = 1.0 / np.abs(1.0 - shapes * np.exp(1j * (phi[:, None] - places))) ** 2
    assert greatest(values)[0] == pytest.approx(1.0 / (1.0 - np.abs(shapes)) ** 2, rel=1e-13)
    assert greatest(np.ones((count, 2)))[0] == pytest.approx(1.0, rel=1e-15)
    assert greatest(np.zeros((count, 2)))[0].tolist() == [0.0, 0.0]


def test_of_many_cases_each_place_has_its_own() -> None:
    rng = np.random.default_rng(0)
    waves = rng.normal(size=(3, 5, 4, 2)) + 1j * rng.normal(size=(3, 5, 4, 2))
    waves[:, 0] = 0.0

    def at(count: int) -> np.ndarray:
        return np.fft.irfft(waves, n=count, axis=1) * count

    factors = rng.normal(size=(20, 3))
    found = greatest_over(factors, at(32)).max(axis=0)
    fine = np.linalg.norm(np.tensordot(factors, at(2**15), 1), axis=-1).max(axis=(0, 1))
    assert found == pytest.approx(fine, rel=1e-7)
    assert np.all(found >= fine * (1.0 - 1e-14))
    one = greatest_over(factors, at(32)[..., :1], signed=True).max(axis=0)
    fine = np.tensordot(factors, at(2**15)[..., :1], 1)[..., 0].max(axis=(0, 1))
    assert one == pytest.approx(fine, rel=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("degrees", [5.0, 44.0, 46.0, 60.0, 80.0, 88.0])
def test_verdicts_have_the_greatest_bending_moment_of_the_turn(degrees: float) -> None:
    beta = np.radians(degrees)
    shafts = [Shaft(bearings=end_bearings(0)), Shaft(slope_plan=beta, bearings=end_bearings(1))]
    line = DriveLine(shafts=shafts, torque=100.0)
    rows = {row.quantity: row.value for row in line.verdict() if row.rule == "fork_couples"}
    behind, _ = grossmann.greatest_bending_2(beta)
    exact = {"before": np.tan(beta), "behind": float(behind)}
    for side, value in exact.items():
        assert rows[f"bending moment {side} the joint"] == pytest.approx(100.0 * value, rel=1e-10)


@pytest.mark.slow
def test_no_position_of_a_line_has_more_than_its_verdict() -> None:
    cycle = [DutyPoint(share=0.5, speed=200.0, torque=-300.0)] * 2
    line = random_line(3, 5, bend=0.6, mass=True).replace(duty_cycle=cycle, service_factor=1.5)
    rows = {
        (row.where, row.quantity): row.value
        for row in line.verdict()
        if row.rule == "bearing_forces"
    }
    between = np.linspace(0.0, 2.0 * np.pi, 3001)
    analyses = [
        line.analyse(speed=speed, torque=torque, positions=between, gravity=(0.0, 0.0, -9.81))
        for speed in (0.0, 200.0)
        for torque in (-450.0, 0.0)
    ]
    for index, name in enumerate(analyses[0].bearings):
        most = max(float(item.total.bearing_radial[:, index].max()) for item in analyses)
        found = rows[name, "force across the shaft"]
        assert found == pytest.approx(most, rel=1e-5)
        assert found >= most * (1.0 - 1e-12)
