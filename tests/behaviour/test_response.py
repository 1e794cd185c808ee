"""The response against direct sweeps and closed forms; its limits and its file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from testkit.linkages import four_bar, loop
from testkit.scenes import double, relative, universal

import cardan_dyn as cd
from analytic import grossmann
from cardan_dyn.response import build as response_build
from cardan_dyn.response.domain import Domain
from cardan_dyn.response.series import Series

POSITIONS = np.random.default_rng(11).uniform(-30.0, 30.0, 200)


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
            start={"crank_bearing": start},
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
        found = response.sweep(POSITIONS, speed, acceleration)
        size = max(np.max(np.abs(direct[name].moment)) for name in shaft.joint_names)
        for name in shaft.joint_names:
            assert np.max(np.abs(found[name].moment - direct[name].moment)) < 1e-12 * size
            assert np.max(np.abs(found[name].force - direct[name].force)) < 1e-12 * size
            np.testing.assert_array_equal(found[name].unique, direct[name].unique)
        assert np.max(np.abs(found.drive_effort - direct.drive_effort)) < 1e-12 * size
        for name, effort in direct.holding_effort.items():
            assert np.max(np.abs(found.holding_effort[name] - effort)) < 1e-12 * size
    world = found.wrench("pin_2_out", "world").moment
    assert np.max(np.abs(world - direct.wrench("pin_2_out", "world").moment)) < 1e-12 * size
    np.testing.assert_allclose(found.motion.v, direct.motion.v, atol=1e-11)
    np.testing.assert_allclose(found.motion.a, direct.motion.a, atol=1e-8)


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
    with pytest.raises(cd.ArgumentError, match="only sweeps over one dimension"):
        grid.wrench("slip", "world")
    with pytest.raises(cd.ArgumentError, match="shapes do not broadcast"):
        response.sweep(positions, np.zeros(3))


def test_gravity_and_link_loads_are_columns(joint: cd.Mechanism) -> None:
    held = {"joint_angle": 0.4}
    push = {"shaft_out": cd.Wrench(force=(0.0, 3.0, 10.0), frame="world")}
    scene = cd.Scene(joint, drive="bearing_in", held=held, gravity=(0.0, 0.0, -9.81), loads=push)
    response = scene.response()
    pull = np.array([1.0, 2.0, -3.0])
    other = cd.Scene(joint, drive="bearing_in", held=held, gravity=pull, loads=push)
    direct = other.sweep(POSITIONS, speed=4.0)
    found = response.sweep(POSITIONS, 4.0, gravity=pull)
    for name in joint.joint_names:
        scale = np.max(np.abs(direct[name].moment)) + np.max(np.abs(direct[name].force))
        assert np.max(np.abs(found[name].moment - direct[name].moment)) < 1e-12 * scale
        assert np.max(np.abs(found[name].force - direct[name].force)) < 1e-12 * scale
    with pytest.raises(cd.ArgumentError, match="no columns for bearing_out, only for"):
        response.sweep(POSITIONS, loads={"bearing_out": 1.0})
    with pytest.raises(cd.ArgumentError, match="no columns for gravity z"):
        universal(joint, 0.4).response().sweep(0.0, gravity=(0.0, 0.0, 1.0))


def test_inertia_and_its_slope(joint: cd.Mechanism) -> None:
    """Kinetic energy of the joint at unit speed is half the inertia."""
    scene = universal(joint, 0.8, load=0.0)
    response = scene.response()
    positions = np.linspace(0.0, 3.0, 7)
    turn = scene.sweep(positions, speed=1.0)
    import pinocchio as pin

    data = joint.model.createData()
    energy = [
        pin.computeKineticEnergy(joint.model, data, q, v)
        for q, v in zip(turn.motion.q, turn.motion.v, strict=True)
    ]
    np.testing.assert_allclose(response.inertia(positions), 2.0 * np.array(energy), rtol=1e-12)
    step = 1e-3
    slope = (response.inertia(positions + step) - response.inertia(positions - step)) / (2 * step)
    np.testing.assert_allclose(response.inertia_derivative(positions), slope, atol=1e-6)
    np.testing.assert_allclose(
        turn.drive_effort, 0.5 * response.inertia_derivative(positions), atol=1e-13
    )
    np.testing.assert_allclose(
        response.ratio("bearing_out", positions), turn.motion.ratio("bearing_out"), rtol=1e-13
    )


def test_a_rocker_on_its_range() -> None:
    scene = cd.Scene(cd.load(four_bar(loop("continuous"))), drive="d", loads={"a": -2.0})
    low, high = scene.motion_range()
    with pytest.raises(cd.CardanError, match=r"cannot be|give the range"):
        scene.response()
    inside = low + 0.1 * (high - low), high - 0.1 * (high - low)
    response = scene.response(1e-12, interval=(inside[0], inside[1]))
    assert response.interval == pytest.approx(inside)
    positions = np.linspace(*inside, 50)
    direct, found = scene.sweep(positions, speed=3.0), response.sweep(positions, 3.0)
    for name in "abcd":
        scale = np.max(np.abs(direct[name].force))
        assert np.max(np.abs(found[name].force - direct[name].force)) < 1e-10 * scale
    with pytest.raises(cd.ArgumentError, match="the response holds for positions from"):
        response.sweep(inside[1] + 0.01)
    with pytest.raises(cd.ArgumentError, match="does not turn through"):
        response.uniform(10)
    with pytest.raises(cd.ArgumentError, match="the interval from 1 to 0 is empty"):
        scene.response(interval=(1.0, 0.0))
    with pytest.raises(cd.ArgumentError, match=r"expected \(low, high\)"):
        scene.response(interval=(1.0,))


def test_a_tolerance_out_of_reach_is_refused(
    joint: cd.Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Towards a dead point forces grow without bound, and no polynomial follows them."""
    rocker = cd.Scene(cd.load(four_bar(loop("continuous"))), drive="d", loads={"a": -2.0})
    low, high = rocker.motion_range()
    monkeypatch.setattr(response_build, "_GREATEST_COUNT", 1024)
    with pytest.raises(cd.AccuracyError, match=r"the response reaches .* not 1e-12") as caught:
        rocker.response(1e-12, interval=(low + 1e-7, high - 1e-7))
    assert caught.value.residual > 1e-12
    scene = universal(joint, 0.5)
    with pytest.raises(cd.ArgumentError, match="tolerance is 0"):
        scene.response(0.0)
    with pytest.raises(cd.ArgumentError, match="a response needs one drive"):
        cd.Scene(joint, drive=["bearing_in", "joint_angle"]).response()


def test_a_response_survives_its_file(joint: cd.Mechanism, tmp_path: Path) -> None:
    scene = universal(joint, 0.5)
    response = scene.response()
    response.save(tmp_path / "response.npz")
    again = universal(joint, 0.5).load_response(tmp_path / "response.npz")
    first, second = response.sweep(POSITIONS, 3.0), again.sweep(POSITIONS, 3.0)
    np.testing.assert_array_equal(first["pin_out"].moment, second["pin_out"].moment)
    assert again.proof == response.proof
    with pytest.raises(cd.CardanError, match="response of another scene; different: held"):
        universal(joint, 0.6).load_response(tmp_path / "response.npz")
    (tmp_path / "other.npz").write_bytes(b"nothing")
    with pytest.raises(cd.CardanError, match="is not a saved response"):
        scene.load_response(tmp_path / "other.npz")


def test_outputs_prune_responses_as_well(shaft: cd.Mechanism) -> None:
    held = {"joint_angle_1": 0.5, "joint_angle_2": 0.4}
    options = {"drive": "bearing_in", "held": held, "loads": {"bearing_out": -5.0}}
    alone = cd.Scene(shaft, **options, outputs=[]).response()
    whole = cd.Scene(shaft, **options).sweep(POSITIONS, speed=9.0)
    found = alone.sweep(POSITIONS, 9.0).drive_effort
    assert relative(found, whole.drive_effort) < 1e-12


@pytest.mark.parametrize("count", [8, 64])
def test_series_of_known_functions(count: int) -> None:
    """A trigonometric polynomial is exact with as many samples as it needs, on any grid."""

    def functions(x: np.ndarray) -> np.ndarray:
        return np.stack([np.ones_like(x), np.cos(3.0 * x) - 2.0 * np.sin(x), np.sin(2.0 * x + 1.0)])

    origin, period = 0.3, 2.0 * np.pi
    nodes = Domain(origin, period, True).nodes(count)
    series = Series(functions(nodes), Domain(origin, period, True))
    rows = np.arange(3)
    x = np.linspace(-50.0, 1e6, 99)
    np.testing.assert_allclose(series.at(rows, series.locate(x)), functions(x), atol=5e-14)
    np.testing.assert_allclose(series.summed(x), functions(x), atol=5e-14)
    for points in (3, 7, 8, 100):
        grid = origin + period * np.arange(points) / points
        np.testing.assert_allclose(series.uniform(rows, points), functions(grid), atol=5e-14)
    low, high = -0.4, 1.1
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    nodes = Domain(middle, half, False).nodes(count)
    assert len(nodes) == count + 1
    cubic = np.stack([nodes**3 - nodes, 1.0 / (2.0 + nodes)])
    series = Series(cubic, Domain(middle, half, False))
    x = np.concatenate([np.linspace(low, high, 33), [high - 1e-13]])
    found = series.at(np.arange(2), series.locate(x))
    np.testing.assert_allclose(found[0], x**3 - x, atol=1e-14)
    np.testing.assert_allclose(series.summed(x)[0], x**3 - x, atol=1e-14)
    assert np.max(np.abs(found[1] - 1.0 / (2.0 + x))) < (1e-5 if count == 8 else 1e-14)
