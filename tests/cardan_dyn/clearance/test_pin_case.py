"""OpenPin and stiffness of several bearings together, by virtual work and springs by hand."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.pin_rigs import scene

from cardan_dyn import ArgumentError, ModelError
from cardan_dyn.clearance.pin_case import PinCase, pin_case

GIVEN = {
    "radius": {"pin_in": 0.05, "pin_out": 0.04},
    "clearance": {"pin_in": 1e-5, "pin_out": 3e-5},
    "stiffness": {"pin_in": 1e8, "pin_out": 5e7},
}


def case(*bearings: str) -> PinCase:
    problem = scene("thoma_rig", 0.3)._problem
    return pin_case(problem, "cross", GIVEN, bearings or None)


def test_a_pair_of_forces_is_one_bearing() -> None:
    """Both move by the same way under the same force: side by side."""
    pair = np.array([1.0, 0.0, -1.0, 0.0]) / np.sqrt(2.0)
    one = case("pin_in")
    assert one.clearance(pair) == pytest.approx(1e-5)
    assert one.stiffness(pair) == pytest.approx(1e8)
    np.testing.assert_allclose(one.closing(pair), [1e-5, 0.0, -1e-5, 0.0])


def test_pins_one_behind_the_other_add_up() -> None:
    """Forces M/(2r): ψ r of the bearing that carries most, and its share of all compliances."""
    sizes = np.array([1.0 / 0.05, 1.0 / 0.04])
    direction = np.array([sizes[0], 0.0, -sizes[0], 0.0, 0.0, sizes[1], 0.0, -sizes[1]])
    direction /= np.linalg.norm(direction)
    every = case()
    turn = 1e-5 / 0.05 + 3e-5 / 0.04
    torsional = 1.0 / (1.0 / (2.0 * 1e8 * 0.05**2) + 1.0 / (2.0 * 5e7 * 0.04**2))
    # The stacked force is |F| = M √(2 Σ 1/(2r)²); what it moves, it moves by M ψ / |F|.
    stacked = np.sqrt(2.0 * np.sum((0.5 * sizes) ** 2))
    greatest = 0.5 * sizes[1] / stacked
    assert every.clearance(direction) == pytest.approx(greatest * turn / stacked)
    assert every.stiffness(direction) == pytest.approx(torsional * stacked**2)
    np.testing.assert_allclose(every.shares(direction)[[0, 2]], 0.5 * sizes / stacked)


def test_split_is_what_cannot_close_at_once() -> None:
    direction = np.array([1.0, 0.0, 1.0, 0.0]) / np.sqrt(2.0)
    both = case("pin_in+", "pin_out+")
    tied = np.array([[1.0, 0.0, 1.0, 0.0]]).T / np.sqrt(2.0)
    free = np.eye(4)
    assert both.split(direction, free) == pytest.approx(0.0, abs=1e-12)
    # The bearings move by 2e-5 each, and wanted 1e-5 and 3e-5.
    assert both.split(direction, tied) == pytest.approx(1.0 / np.sqrt(5.0))
    # A bearing that carries nothing has nothing to close.
    alone = np.array([1.0, 0.0, 0.0, 0.0])
    assert both.split(alone, tied) == pytest.approx(0.0, abs=1e-12)


def test_values_of_pins_without_play_are_not_needed() -> None:
    problem = scene("thoma_rig", 0.3)._problem
    given = {"radius": {"pin_in": 0.05}, "clearance": 1e-5, "stiffness": {"pin_in": 1e8}}
    found = pin_case(problem, "cross", given, "pin_in-")
    assert found.opened == [0]
    np.testing.assert_array_equal(found.radii, [0.05, np.nan])
    with pytest.raises(ArgumentError, match="radius has no value for joint 'pin_out'"):
        pin_case(problem, "cross", given, "pin_out")
    with pytest.raises(ModelError, match="no link or joint 'star'"):
        pin_case(problem, "star", given, None)
