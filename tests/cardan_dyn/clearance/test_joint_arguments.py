"""Joints that are asked for: bearings of a cross, and several together, by virtual work by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from testkit.pin_rigs import compound, displaced, scene

import cardan_dyn as cd
from cardan_dyn import ArgumentError, ModelError
from cardan_dyn.clearance import PinGeometry
from cardan_dyn.motion.clearance.arguments import opened_joints, universal_pins
from cardan_dyn.motion.clearance.opened_joint import OpenedJoint
from cardan_dyn.motion.clearance.pin_geometry import StiffnessLaw

GIVEN = {
    "radius": {"pin_in": 0.05, "pin_out": 0.04},
    "clearance": {"pin_in": 1e-5, "pin_out": 3e-5},
    "stiffness": {"pin_in": 1e8, "pin_out": 5e7},
}


def case(*bearings: str, **given: Any) -> OpenedJoint:
    solver = scene("thoma_rig", 0.3).solver
    joints, _ = opened_joints(solver, None, "cross", bearings or None, **{**GIVEN, **given})
    return joints["cross"]


def test_a_pair_of_forces_is_one_bearing() -> None:
    """Both move by the same way under the same force: side by side."""
    pair = np.array([1.0, 0.0, -1.0, 0.0]) / np.sqrt(2.0)
    one = case("pin_in")
    assert one.clearance(pair) == pytest.approx(1e-5)
    assert one.stiffness(pair) == pytest.approx(1e8)


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


def test_values_of_pins_without_clearance_are_not_needed() -> None:
    given: dict[str, Any] = {"radius": {"pin_in": 0.05}, "stiffness": {"pin_in": 1e8}}
    found = case("pin_in-", clearance=1e-5, **given)
    assert found.radii is not None
    np.testing.assert_array_equal(found.radii, [0.05, np.nan])
    with pytest.raises(ArgumentError, match="radius has no value for joint 'pin_out'"):
        case("pin_out", clearance=1e-5, **given)
    with pytest.raises(ModelError, match="no link or joint 'star'"):
        opened_joints(scene("thoma_rig", 0.3).solver, None, "star", None, 1e-5, 1e8, 0.05)


def test_geometries_are_in_series_like_numbers() -> None:
    """As springs one behind the other, each at the force that it carries."""
    pin = PinGeometry(0.02, 0.01, seat_stiffness=3e7)
    sizes = np.array([1.0 / 0.05, 1.0 / 0.04])
    direction = np.array([sizes[0], 0.0, -sizes[0], 0.0, 0.0, sizes[1], 0.0, -sizes[1]])
    direction /= np.linalg.norm(direction)
    mixed = case(stiffness={"pin_in": pin, "pin_out": 5e7})
    law, whole = mixed.stiffness(direction), mixed.clearance(direction)
    assert isinstance(law, StiffnessLaw)
    force, shares = 800.0, mixed.shares(direction)
    first = float(pin.stiffness(np.array(0.8 * force), 1e-5))
    wanted = 1.0 / (2.0 * shares[0] ** 2 / first + 2.0 * shares[2] ** 2 / 5e7)
    assert float(law.stiffness(np.array(force), whole)) == pytest.approx(wanted)
    assert law.limit(whole) == pytest.approx(pin.limit(1e-5) / 0.8)
    near = [float(law.stiffness(np.array(force * np.exp(k)), whole)) for k in (-1e-4, 1e-4)]
    hardening = np.log(near[1] / near[0]) / 2e-4
    assert float(law.hardening(np.array(force), whole)) == pytest.approx(hardening, rel=1e-6)
    one = case("pin_in", stiffness=pin)
    pair = np.array([1.0, 0.0, -1.0, 0.0]) / np.sqrt(2.0)
    alone = one.stiffness(pair)
    assert isinstance(alone, StiffnessLaw)
    expected = float(pin.stiffness(np.array(force), 1e-5))
    assert float(alone.stiffness(np.array(force), 1e-5)) == pytest.approx(expected)


BETA, RADIUS = 0.4, np.array([0.05, 0.04])
PHI = np.linspace(0.0, 6.0, 7)


STILL = cd.Scene(
    cd.load("universal_joint"),
    drive="bearing_in",
    held={"joint_angle": BETA},
    gravity=(0.0, 0.0, -9.81),
)
"""A cross with mass and weight, so that both pins carry forces as well as moments."""


@pytest.fixture(scope="module")
def turn() -> cd.Sweep:
    return STILL.sweep(PHI, 150.0)


def axes_of(turn: cd.Sweep) -> list[np.ndarray]:
    """Axes of the pins of a rig in the world, from the motion of their joints."""
    found = []
    for name in ("pin_in", "pin_out"):
        (part,) = turn.mechanism.joint(name).parts
        found.append(turn.rotation(name) @ part.axis)
    return found


def test_forces_of_both_bearings_are_the_moment_of_the_pin(turn: cd.Sweep) -> None:
    pins = universal_pins(turn.mechanism, "cross")
    assert [pin.name for pin in pins] == ["pin_in", "pin_out"]
    radius = dict(zip(("pin_in", "pin_out"), RADIUS.tolist(), strict=True))
    joints, _ = opened_joints(STILL.solver, None, "cross", None, 1e-5, 1e8, radius)
    found = joints["cross"].forces(turn, turn.motion).world
    for index, (pin, axis) in enumerate(zip(pins, axes_of(turn), strict=True)):
        wrench = turn.wrench(pin.joint, "world")
        first, second = found[:, 2 * index], found[:, 2 * index + 1]
        moment = np.cross(RADIUS[index] * axis, first - second)
        expected = wrench.moment - axis * np.sum(wrench.moment * axis, axis=1, keepdims=True)
        np.testing.assert_allclose(moment, expected, atol=1e-9)


def test_a_joint_of_type_universal_has_the_same_pins() -> None:
    own, plain = scene(compound(), BETA), scene("thoma_rig", BETA)
    pins = universal_pins(own.mechanism, "coupling")
    assert [pin.name for pin in pins] == ["coupling.turn_1", "coupling.turn_2"]
    forces = []
    for still, name in ((own, "coupling"), (plain, "cross")):
        turn = still.sweep(PHI, 150.0)
        joints, _ = opened_joints(still.solver, None, name, None, 1e-5, 1e8, 0.05)
        forces.append(joints[name].forces(turn, turn.motion).world)
        frames = [joints[name].mobility(x).frames for x in turn.motion.rows]
        for index, axis in enumerate(axes_of(turn) if still is plain else ()):
            across = np.array([frame[2 * index] for frame in frames])
            np.testing.assert_allclose(np.cross(across[:, 0], across[:, 1]), axis, atol=1e-12)
    np.testing.assert_allclose(forces[0], forces[1], atol=1e-9 * np.max(np.abs(forces[1])))


def test_centres_are_found_where_axes_meet() -> None:
    """Where along its pin a joint has its origin changes nothing in the pairs of forces."""
    pairs = []
    for urdf in ("thoma_rig", displaced()):
        still = scene(urdf, BETA)
        turn = still.sweep(PHI, 150.0)
        joints, _ = opened_joints(still.solver, None, "cross", None, 1e-5, 1e8, 0.05)
        forces = joints["cross"].forces(turn, turn.motion).local
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
    bar = cd.Scene(cd.load("four_bar"), drive="crank_bearing")
    with pytest.raises(ModelError, match="'crank_pin' and 'rocker_pin' are parallel"):
        cd.clearance.scan(bar, 1.0, joints="coupler", radius=0.01, clearance=1e-5, stiffness=1e8)


def test_bearings_by_name() -> None:
    found = case("pin_out-", "pin_in", "pin_in+").bearings
    assert [item.name for item in found] == ["pin_in+", "pin_in-", "pin_out-"]
    assert [(item.pin, item.sign) for item in found] == [(0, 1.0), (0, -1.0), (1, -1.0)]
    with pytest.raises(ModelError, match=r"no bearing 'pin_on'; .*did you mean 'pin_in'"):
        case("pin_on")


def test_joints_with_a_bush_beside_universal_ones() -> None:
    joints, left_out = opened_joints(
        STILL.solver, None, ["bearing_out", "cross"], "pin_in", 1e-5, 1e8, 0.05
    )
    assert list(joints) == ["bearing_out", "cross"] and left_out == {}
    assert [joint.is_cross for joint in joints.values()] == [False, True]
