"""Benchmarks of many designs and of short calls: complete records, and errors of the right size."""

from __future__ import annotations

import pytest

pytest.importorskip("mpmath")

import numpy as np
from testkit.design_line import design_line as reference_line
from testkit.design_line import nominal

import cardan_dyn as cd
from benchmarks import many_designs, short_calls
from benchmarks.descriptions import design_line, random_designs
from benchmarks.engines import pinocchio_by_hand

pytestmark = pytest.mark.slow


def test_random_designs_of_the_universal_joint_are_exact() -> None:
    records = {record.method: record for record in many_designs.universal_joint(fast=True)}
    assert set(records) == {"one drive", "two drives", "held per sample", "Pinocchio by hand"}
    for name in ("two drives", "held per sample"):
        assert records[name].error is not None
        assert records[name].error < 1e-12
    assert all(record.microseconds and record.ratio for record in records.values())


def test_the_peer_takes_an_angle_per_sample() -> None:
    beta, phi = np.array([0.2, 0.9, 0.5]), np.array([0.3, 4.0, -1.0])
    found = pinocchio_by_hand.prepare(beta, phi)()
    for k in range(3):
        alone = pinocchio_by_hand.prepare(float(beta[k]), phi[[k]])()
        np.testing.assert_allclose(found[[k]], alone, rtol=1e-14)


@pytest.mark.campaign
def test_platform_and_line_have_complete_records() -> None:
    for records in (many_designs.platform(fast=True), many_designs.line(fast=True)):
        assert records[0].ratio == 1.0
        assert all(record.microseconds and record.flat()["samples"] for record in records)
        assert "times the reference" in many_designs.answer(records)


def test_lines_of_designs_have_the_joints_of_the_tests_own() -> None:
    line, other = cd.load(design_line(3)), cd.load(reference_line(3))
    assert set(nominal(3)) == set(random_designs(3, 2))
    assert set(nominal(3)) <= set(line) & set(other)
    held = {name: float(values[1, 0]) for name, values in random_designs(3, 2).items()}
    ratios = [
        cd.Scene(mechanism, drive="bearing_0", held=held).sweep(1.3).motion.ratio("bearing_3")
        for mechanism in (line, other)
    ]
    np.testing.assert_allclose(ratios[0], ratios[1], rtol=1e-12)


@pytest.mark.campaign
def test_short_calls_have_complete_records() -> None:
    records = short_calls.measure(fast=True)
    assert len(records) == 7
    assert all(record.ratio and record.ratio > 1.0 for record in records)
    assert "one position: " in short_calls.answer(records)
