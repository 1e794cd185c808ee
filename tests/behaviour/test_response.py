"""Responses against direct sweeps and closed forms: wrenches, couplings, loads, outputs, ranges."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from testkit.linkages import coupling, four_bar, gears, loop
from testkit.scenes import double, relative, text, universal

import cardan_dyn as cd
from cardan_dyn.analytic import grossmann

POSITIONS = np.random.default_rng(11).uniform(-30.0, 30.0, 200)
FEW_POSITIONS = np.linspace(-3.0, 9.0, 40)


@pytest.mark.parametrize(
    ("beta_deg", "tolerance", "allowed"),
    [
        (1.0, 1e-13, 1e-13),
        (8.5, 1e-13, 1e-13),
        (30.0, 1e-13, 1e-13),
        (50.0, 1e-13, 1e-13),
        (80.0, 1e-13, 1e-13),
        (89.0, 1e-11, 1e-11),
    ],
)
def test_grossmann_everywhere(
    joint: cd.Mechanism, beta_deg: float, tolerance: float, allowed: float
) -> None:
    beta = np.deg2rad(beta_deg)
    response = universal(joint, beta).response(tolerance)
    for sweep, positions in (
        (response.uniform(1000), 2.0 * np.pi * np.arange(1000) / 1000),
        (response.sweep(POSITIONS), POSITIONS),
    ):
        closed = grossmann.moments(beta, positions)
        torque = sweep["bearing_in"].torsion
        assert relative(sweep["bearing_in"].bending / torque, closed.bending_1) < allowed
        assert relative(-sweep["bearing_out"].torsion / torque, closed.torsion_2) < allowed
        assert relative(sweep["bearing_out"].bending / torque, closed.bending_2) < allowed
        assert relative(sweep.drive_effort, 1.0 / closed.torsion_2) < allowed
    # At 1° the wrenches that depend on speed are what rounding leaves of inertial terms.
    assert response.error < (10.0 if beta_deg > 1.0 else 20.0) * tolerance


def test_a_turn_begins_where_the_scene_starts() -> None:
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", loads={"rocker_bearing": -5.0})
    steps = 2.0 * np.pi * np.arange(12) / 12
    # Neither does it matter how much of the motion was known before.
    for start, known in ((0.0, []), (0.0, [-5.0, 1.0]), (0.7, [9.0])):
        begun = cd.Scene(
            scene.mechanism,
            drive="crank_bearing",
            loads={"rocker_bearing": -5.0},
            near={"crank_bearing": start},
        )
        if known:
            begun.sweep(known)
        turn = begun.response().uniform(12)
        np.testing.assert_allclose(turn.motion.position("crank_bearing"), start + steps)
        assert relative(turn.drive_effort, scene.sweep(start + steps).drive_effort) < 1e-12


def test_every_wrench_equals_the_direct_sweep(shaft: cd.Mechanism) -> None:
    scene = double(shaft, 0.7, 0.5, load=-30.0, gravity=(0.0, 3.0, -9.81))
    response = scene.response()
    for speed, acceleration in ((0.0, 0.0), (80.0, 0.0), (0.0, 30.0), (-60.0, 500.0)):
        direct = scene.sweep(POSITIONS, speed=speed, acceleration=acceleration)
        evaluated = response.sweep(POSITIONS, speed, acceleration)
        size = max(np.max(np.abs(direct[name].moment)) for name in shaft.joint_names)
        for name in shaft.joint_names:
            assert np.max(np.abs(evaluated[name].moment - direct[name].moment)) < 1e-12 * size
            assert np.max(np.abs(evaluated[name].force - direct[name].force)) < 1e-12 * size
            np.testing.assert_array_equal(evaluated[name].unique, direct[name].unique)
        assert np.max(np.abs(evaluated.drive_effort - direct.drive_effort)) < 1e-12 * size
        for name, effort in direct.holding_effort.items():
            assert np.max(np.abs(evaluated.holding_effort[name] - effort)) < 1e-12 * size
    world = evaluated.wrench("pin_2_out", "world").moment
    assert np.max(np.abs(world - direct.wrench("pin_2_out", "world").moment)) < 1e-12 * size
    np.testing.assert_allclose(evaluated.motion.v, direct.motion.v, atol=1e-11)
    np.testing.assert_allclose(evaluated.motion.a, direct.motion.a, atol=1e-8)


def test_operating_points_broadcast(shaft: cd.Mechanism) -> None:
    scene = double(shaft, 0.5, 0.5, load=-10.0)
    response = scene.response()
    positions = np.linspace(0.0, 6.0, 5)
    speeds, loads = np.array([0.0, 10.0, 50.0]), np.array([-7.0, 0.0])
    grid = response.sweep(positions[:, None, None], speeds[:, None], loads={"bearing_out": loads})
    torsion = grid["pin_1_out"].bending
    assert torsion.shape == grid.drive_effort.shape == (5, 3, 2)
    assert grid["slip"].force.shape == (5, 3, 2, 3)
    for k, speed in enumerate(speeds):
        for m, load in enumerate(loads):
            single = double(shaft, 0.5, 0.5, load=load).sweep(positions, speed=speed)
            scale = max(1.0, np.max(single["pin_1_out"].bending))
            difference = torsion[:, k, m] - single["pin_1_out"].bending
            assert np.max(np.abs(difference)) < 1e-12 * scale
    turned = grid.wrench("slip", "world").force
    np.testing.assert_allclose(
        turned, np.einsum("...ij,...j->...i", grid.rotation("slip"), grid["slip"].force), atol=1e-12
    )
    with pytest.raises(cd.ArgumentError, match="shapes do not broadcast"):
        response.sweep(positions, np.zeros(3))


def test_gravity_and_link_loads_are_columns(joint: cd.Mechanism) -> None:
    held = {"joint_angle": 0.4}
    push = {"shaft_out": cd.Wrench(force=(0.0, 3.0, 10.0), frame="world")}
    scene = cd.Scene(joint, drive="bearing_in", held=held, gravity=(0.0, 0.0, -9.81), loads=push)
    response = scene.response()
    pull = np.array([1.0, 2.0, -3.0])
    pulled = cd.Scene(joint, drive="bearing_in", held=held, gravity=pull, loads=push)
    direct = pulled.sweep(POSITIONS, speed=4.0)
    evaluated = response.sweep(POSITIONS, 4.0, gravity=pull)
    for name in joint.joint_names:
        scale = np.max(np.abs(direct[name].moment)) + np.max(np.abs(direct[name].force))
        assert np.max(np.abs(evaluated[name].moment - direct[name].moment)) < 1e-12 * scale
        assert np.max(np.abs(evaluated[name].force - direct[name].force)) < 1e-12 * scale
    with pytest.raises(cd.ArgumentError, match="no columns for bearing_out, only for"):
        response.sweep(POSITIONS, loads={"bearing_out": 1.0})
    with pytest.raises(cd.ArgumentError, match="no columns for gravity z"):
        universal(joint, 0.4).response().sweep(0.0, gravity=(0.0, 0.0, 1.0))


def test_a_rocker_on_its_range() -> None:
    scene = cd.Scene(cd.load(four_bar(loop("continuous"))), drive="d", loads={"a": -2.0})
    low, high = scene.motion_range()
    with pytest.raises(cd.CardanError, match=r"moves only between .* give an interval"):
        scene.response()
    inside = low + 0.1 * (high - low), high - 0.1 * (high - low)
    response = scene.response(1e-12, interval=(inside[0], inside[1]))
    assert response.interval == pytest.approx(inside)
    positions = np.linspace(*inside, 50)
    direct, evaluated = scene.sweep(positions, speed=3.0), response.sweep(positions, 3.0)
    for name in "abcd":
        scale = np.max(np.abs(direct[name].force))
        assert np.max(np.abs(evaluated[name].force - direct[name].force)) < 1e-10 * scale
    with pytest.raises(cd.ArgumentError, match="the response holds for positions from"):
        response.sweep(inside[1] + 0.01)
    with pytest.raises(cd.ArgumentError, match="does not turn through"):
        response.uniform(10)
    with pytest.raises(cd.ArgumentError, match="the interval from 1 to 0 is empty"):
        scene.response(interval=(1.0, 0.0))
    with pytest.raises(cd.ArgumentError, match=r"expected \(low, high\)"):
        scene.response(interval=(1.0,))


def test_outputs_prune_responses_as_well(shaft: cd.Mechanism) -> None:
    held = {"joint_angle_1": 0.5, "joint_angle_2": 0.4}
    options = {"drive": "bearing_in", "held": held, "loads": {"bearing_out": -5.0}}
    alone = cd.Scene(shaft, **options, outputs=[]).response()
    complete = cd.Scene(shaft, **options).sweep(POSITIONS, speed=9.0)
    evaluated = alone.sweep(POSITIONS, 9.0).drive_effort
    assert relative(evaluated, complete.drive_effort) < 1e-12


def test_moments_of_couplings_are_functions_like_the_others() -> None:
    mechanism = cd.load(gears(coupling("mesh", "a", "b", -2.5)))
    scene = cd.Scene(mechanism, drive="a", loads={"b": 7.0})
    response = scene.response()
    direct = scene.sweep(FEW_POSITIONS, speed=3.0, acceleration=2.0)
    evaluated = response.sweep(FEW_POSITIONS, 3.0, 2.0)
    assert list(evaluated.coupling_moment) == ["mesh"]
    np.testing.assert_allclose(
        evaluated.coupling_moment["mesh"], direct.coupling_moment["mesh"], rtol=1e-13
    )
    assert evaluated.coupling_unique == direct.coupling_unique == {"mesh": True}
    grid = response.sweep(FEW_POSITIONS[:, None], loads={"b": np.array([0.0, 7.0, -1.0])})
    np.testing.assert_allclose(grid.coupling_moment["mesh"][5], [0.0, -7.0, 1.0], atol=1e-13)
    with pytest.raises(KeyError):
        grid.coupling_moment["b"]


def test_open_moments_of_couplings_are_marked_and_survive_a_file(tmp_path: Path) -> None:
    train = [("ab", "a", "b", -2.0), ("bc", "b", "c", -3.0), ("ca", "c", "a", 1.0 / 6.0)]
    closed = cd.load(gears(*(coupling(*item) for item in train), third=True))
    scene = cd.Scene(closed, drive="a", loads={"c": -4.0})
    response = scene.response()
    response.save(f"{tmp_path}/train")
    direct = scene.sweep(FEW_POSITIONS, speed=1.0)
    for each in (response, scene.load_response(f"{tmp_path}/train")):
        evaluated = each.sweep(FEW_POSITIONS, 1.0)
        assert evaluated.coupling_unique == {"ab": False, "bc": False, "ca": False}
        for name, moment in direct.coupling_moment.items():
            np.testing.assert_allclose(evaluated.coupling_moment[name], moment, atol=1e-12)


@pytest.mark.parametrize("name", ["acceleration", "speed²", "gravity x"])
def test_a_loaded_joint_may_be_called_like_a_column(name: str) -> None:
    urdf = text("universal_joint").replace('"bearing_out"', f'"{name}"')
    scene = cd.Scene(
        cd.load(urdf),
        drive="bearing_in",
        held={"joint_angle": 0.5},
        loads={name: -2.0},
        gravity=(1.0, 0.0, -9.81),
    )
    response = scene.response()
    direct = scene.sweep(FEW_POSITIONS, speed=4.0, acceleration=5.0)
    evaluated = response.sweep(FEW_POSITIONS, 4.0, 5.0)
    assert response.columns.count(name) == 2
    for joint in scene.outputs:
        scale = np.max(np.abs(direct[joint].moment)) + np.max(np.abs(direct[joint].force))
        assert np.max(np.abs(evaluated[joint].moment - direct[joint].moment)) < 1e-12 * scale
    tenfold = response.sweep(FEW_POSITIONS, loads={name: -20.0}).drive_effort
    unloaded = response.sweep(FEW_POSITIONS, loads={name: 0.0}).drive_effort
    loaded = response.sweep(FEW_POSITIONS).drive_effort
    np.testing.assert_allclose(tenfold - unloaded, 10.0 * (loaded - unloaded), atol=1e-11)
