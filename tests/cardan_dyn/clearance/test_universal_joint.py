"""Pins of a cross and the forces in their bearings, against moments put together again."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.pin_rigs import compound, displaced, scene

import cardan_dyn as cd
from cardan_dyn import ModelError
from cardan_dyn.clearance.universal_joint import (
    bearing_forces,
    bearings_of,
    pins_of,
    universal_pins,
)

BETA, RADIUS = 0.4, np.array([0.05, 0.04])
PHI = np.linspace(0.0, 6.0, 7)


@pytest.fixture(scope="module")
def turn() -> cd.Sweep:
    """A cross with mass and weight, so that both pins carry forces as well as moments."""
    held = {"joint_angle": BETA}
    still = cd.Scene(
        cd.load("universal_joint"), drive="bearing_in", held=held, gravity=(0.0, 0.0, -9.81)
    )
    return still.sweep(PHI, 150.0)


def test_forces_of_both_bearings_are_force_and_moment_of_the_pin(turn: cd.Sweep) -> None:
    pins = universal_pins(turn.mechanism, "cross")
    assert [pin.name for pin in pins] == ["pin_in", "pin_out"]
    placed = pins_of(turn, pins)
    bearings = bearings_of(pins, ("pin_in", "pin_out"))
    found = bearing_forces(turn, pins, placed, bearings, RADIUS)
    for index, pin in enumerate(pins):
        axis, wrench = placed.axes[index], turn.wrench(pin.joint, "world")
        first, second = (
            found[:, 2 * index + k, :1] * placed.across[index]
            + found[:, 2 * index + k, 1:] * placed.normal
            for k in (0, 1)
        )
        across = wrench.force - axis * np.sum(wrench.force * axis, axis=1, keepdims=True)
        np.testing.assert_allclose(first + second, across, atol=1e-9)
        assert np.max(np.abs(across)) > 1.0
        moment = np.cross(RADIUS[index] * axis, first - second)
        expected = wrench.moment - axis * np.sum(wrench.moment * axis, axis=1, keepdims=True)
        np.testing.assert_allclose(moment, expected, atol=1e-9)


def test_a_joint_of_type_universal_has_the_same_pins() -> None:
    own, plain = (scene(urdf, BETA).sweep(PHI) for urdf in (compound(), "thoma_rig"))
    pins = universal_pins(own.mechanism, "coupling")
    assert [pin.name for pin in pins] == ["coupling.turn_1", "coupling.turn_2"]
    found = pins_of(own, pins)
    expected = pins_of(plain, universal_pins(plain.mechanism, "cross"))
    np.testing.assert_allclose(found.axes, expected.axes, atol=1e-12)
    np.testing.assert_allclose(found.normal, expected.normal, atol=1e-12)
    np.testing.assert_allclose(found.across, expected.across, atol=1e-12)


def test_centres_are_found_where_axes_meet() -> None:
    """Where along its pin a joint has its origin changes nothing in the pairs of forces."""
    pairs = []
    for urdf, offsets in (("thoma_rig", (0.0, 0.0)), (displaced(), (-0.01, -0.02))):
        turn = scene(urdf, BETA).sweep(PHI, 150.0)
        pins = universal_pins(turn.mechanism, "cross")
        placed = pins_of(turn, pins)
        np.testing.assert_allclose(placed.offsets, offsets, atol=1e-15)
        bearings = bearings_of(pins, ("pin_in", "pin_out"))
        forces = bearing_forces(turn, pins, placed, bearings, RADIUS)
        pairs.append(forces[:, ::2] - forces[:, 1::2])
    np.testing.assert_allclose(pairs[1], pairs[0], atol=1e-9 * np.max(np.abs(pairs[0])))


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("slip", "is of type prismatic; name a joint of type universal"),
        ("crs_1", "no link or joint 'crs_1'; .*did you mean 'cross_1'"),
        ("spline_shaft", "is no cross: 1 joints that turn"),
    ],
)
def test_what_is_no_universal_joint(name: str, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        universal_pins(cd.load("double_shaft_z"), name)


def test_parallel_pins_make_no_cross() -> None:
    mechanism = cd.load("four_bar")
    turn = cd.Scene(mechanism, drive="crank_bearing").sweep([0.1])
    with pytest.raises(ModelError, match="'crank_pin' and 'rocker_pin' are parallel"):
        pins_of(turn, universal_pins(mechanism, "coupler"))


def test_bearings_by_name() -> None:
    pins = universal_pins(cd.load("thoma_rig"), "cross")
    found = bearings_of(pins, ("pin_out-", "pin_in", "pin_in+"))
    assert [item.name for item in found] == ["pin_in+", "pin_in-", "pin_out-"]
    assert [(item.pin, item.sign) for item in found] == [(0, 1.0), (0, -1.0), (1, -1.0)]
    with pytest.raises(ModelError, match=r"no bearing 'pin_on'; .*did you mean 'pin_in'"):
        bearings_of(pins, ("pin_on",))
