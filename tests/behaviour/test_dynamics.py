"""Masses and speed: laws of motion, and Pinocchio's own constrained dynamics."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from testkit.scenes import double, forward_accelerations, relative, text, universal

import cardan_dyn as cd

GRAVITY = (0.0, 0.0, -9.81)
DENSITY = 7850.0


def scenes(joint: cd.Mechanism, shaft: cd.Mechanism, beta_deg: float) -> dict[str, cd.Scene]:
    beta = np.deg2rad(beta_deg)
    return {
        "universal": universal(joint, beta, load=-300.0, gravity=GRAVITY),
        "double": double(shaft, beta, 0.7 * beta, load=-300.0, gravity=GRAVITY),
    }


@pytest.mark.parametrize("speed", [100.0, 1000.0])
@pytest.mark.parametrize("beta_deg", [0.0, 8.5, 50.0, 80.0])
def test_balance_of_bodies_and_power(
    joint: cd.Mechanism,
    shaft: cd.Mechanism,
    positions: np.ndarray,
    beta_deg: float,
    speed: float,
) -> None:
    for scene in scenes(joint, shaft, beta_deg).values():
        turn = scene.sweep(positions, speed=speed, acceleration=-40.0)
        assert turn.loop_residual < 1e-13
        assert turn.balance_residual < 1e-11
        assert turn.power_residual < 1e-11


@pytest.mark.parametrize("beta_deg", [0.0, 8.5, 30.0, 60.0])
@pytest.mark.parametrize("name", ["universal", "double"])
def test_constrained_forward_dynamics_agrees(
    joint: cd.Mechanism, shaft: cd.Mechanism, name: str, beta_deg: float
) -> None:
    """Pinocchio, given the efforts, finds the motion and the same wrench in every joint."""
    scene = scenes(joint, shaft, beta_deg)[name]
    mechanism = scene.mechanism
    turn = scene.sweep(np.linspace(0.0, 2.0 * np.pi, 25), speed=100.0, acceleration=50.0)
    scale = np.max(np.abs(turn.motion.a))
    wrenches = {joint: turn[joint] for joint in mechanism.joint_names}
    size = max(np.max(np.abs(wrench.moment)) for wrench in wrenches.values())
    for sample in range(len(turn)):
        efforts = {"bearing_out": -300.0, "bearing_in": float(turn.drive_effort[sample])}
        efforts |= {name: float(value[sample]) for name, value in turn.holding_effort.items()}
        a, data, _ = forward_accelerations(mechanism, turn, sample, efforts)
        assert np.max(np.abs(a - turn.motion.a[sample])) < 1e-9 * scale
        for joint_name, wrench in wrenches.items():
            expected = data.f[mechanism.joints[joint_name].id].vector
            actual = np.concatenate([wrench.force[sample], wrench.moment[sample]])
            difference = np.where(wrench.unique, actual - expected, 0.0)
            assert np.max(np.abs(difference)) < 1e-9 * size, joint_name


def test_weights_at_rest(joint: cd.Mechanism) -> None:
    """At rest the bearings and the housing together carry all moving links."""
    turn = universal(joint, 0.5, load=0.0, gravity=GRAVITY).sweep(np.linspace(0.0, 6.0, 7))
    moving = sum(inertia.mass for inertia in list(joint.model.inertias)[1:])
    carried = turn.wrench("bearing_in", "world").force + turn.wrench("joint_angle", "world").force
    np.testing.assert_allclose(carried[:, 2], 9.81 * moving, rtol=1e-13)
    assert np.max(np.abs(carried[:, :2])) < 1e-11


def test_wrenches_on_links(shaft: cd.Mechanism) -> None:
    """A wrench on a link in link axes, in world axes, and as the load of its joint."""
    positions = np.linspace(0.0, 2.0 * np.pi, 37)
    held = {"joint_angle_1": 0.5, "joint_angle_2": 0.5}

    def sweep(load: object, name: str = "shaft_out") -> cd.Sweep:
        scene = cd.Scene(shaft, drive="bearing_in", held=held, loads={name: load})
        return scene.sweep(positions)

    by_joint = sweep(-40.0, "bearing_out")
    by_link = sweep([0.0, 0.0, 0.0, -40.0, 0.0, 0.0])
    in_world = sweep(cd.Wrench(moment=(-40.0, 0.0, 0.0), frame="world"))
    assert relative(by_link.drive_effort, by_joint.drive_effort) < 1e-14
    # Z with equal angles: the output shaft is parallel to the world's x axis.
    assert relative(in_world.drive_effort, by_joint.drive_effort) < 1e-14
    # A load belongs to its joint; a wrench on the link does not.
    assert relative(by_joint["bearing_out"].torsion, np.full(37, -40.0)) < 1e-14
    assert np.max(np.abs(by_link["bearing_out"].torsion)) < 1e-13
    assert relative(by_link["pin_2_out"].moment, by_joint["pin_2_out"].moment) < 1e-13
    # A force on the tube is carried by the joints to both sides of it, and does no harm to power.
    pushed = sweep(cd.Wrench(force=(0.0, 0.0, -500.0), frame="world"), "tube")
    assert pushed.balance_residual < 1e-13
    assert pushed.power_residual < 1e-13
    carried = pushed.wrench("bearing_in", "world").force[:, 2]
    carried = carried + pushed.wrench("joint_angle_1", "world").force[:, 2]
    np.testing.assert_allclose(carried, 500.0, rtol=1e-13)


def test_loads_may_vary_along_the_sweep(joint: cd.Mechanism) -> None:
    positions = np.linspace(0.0, 2.0 * np.pi, 600)  # more than one block
    load = -1.0 - np.sin(positions) ** 2
    scene = cd.Scene(
        joint, drive="bearing_in", held={"joint_angle": 0.5}, loads={"bearing_out": load}
    )
    unit = universal(joint, 0.5).sweep(positions)
    turn = scene.sweep(positions)
    assert relative(turn.drive_effort, -load * unit.drive_effort) < 1e-14
    wrench = np.stack([np.zeros_like(load)] * 3 + [load] + [np.zeros_like(load)] * 2, axis=1)
    by_link = cd.Scene(
        joint, drive="bearing_in", held={"joint_angle": 0.5}, loads={"shaft_out": wrench}
    ).sweep(positions)
    assert relative(by_link.drive_effort, turn.drive_effort) < 1e-14


def test_outputs_choose_the_wrenches(shaft: cd.Mechanism) -> None:
    turn = double(shaft, 0.5, 0.5, outputs=["bearing_out", "slip"]).sweep([0.0, 1.0], speed=5.0)
    whole = double(shaft, 0.5, 0.5).sweep([0.0, 1.0], speed=5.0)
    np.testing.assert_array_equal(turn["slip"].force, whole["slip"].force)
    np.testing.assert_array_equal(turn["bearing_out"].moment, whole["bearing_out"].moment)
    with pytest.raises(cd.ModelError, match=r"was not asked for; .* which are: bearing_out, slip"):
        turn["bearing_in"]
    with pytest.raises(cd.ModelError, match="no joint 'bearing'"):
        turn["bearing"]


@pytest.mark.parametrize("name", ["universal_joint", "double_shaft_z"])
def test_inertias_follow_from_the_dimensions(name: str) -> None:
    """Every link's inertia is the sum of its visual primitives in steel."""
    from xml.etree import ElementTree

    for link in ElementTree.fromstring(text(name)).findall("link"):
        bodies = []
        for visual in link.findall("visual"):
            inertia = primitive(visual)
            bodies.append(inertia)
        if link.find("inertial") is None:
            assert not bodies  # A place behind an adjustable joint.
            continue
        total = bodies[0]
        for body in bodies[1:]:
            total = total + body
        inertial = link.find("inertial")
        centre = np.array(inertial.find("origin").get("xyz").split(), dtype=float)
        given = {key: float(value) for key, value in inertial.find("inertia").items()}
        assert float(inertial.find("mass").get("value")) == pytest.approx(total.mass, rel=1e-9)
        np.testing.assert_allclose(centre, total.lever, atol=1e-11)
        tensor = [[given["ixx"], given["ixy"], given["ixz"]], [given["ixy"], given["iyy"], 0.0]]
        np.testing.assert_allclose(tensor, total.inertia[:2], atol=1e-11)
        assert given["izz"] == pytest.approx(total.inertia[2, 2], rel=1e-9)


def primitive(visual) -> pin.Inertia:
    origin = visual.find("origin")
    centre = np.array(origin.get("xyz").split(), dtype=float)
    roll, pitch, yaw = map(float, (origin.get("rpy") or "0 0 0").split())
    rotation = pin.rpy.rpyToMatrix(roll, pitch, yaw)
    box = visual.find("geometry/box")
    if box is not None:
        x, y, z = map(float, box.get("size").split())
        mass = DENSITY * x * y * z
        moments = mass / 12.0 * np.array([y * y + z * z, x * x + z * z, x * x + y * y])
    else:
        cylinder = visual.find("geometry/cylinder")
        outer, length = float(cylinder.get("radius")), float(cylinder.get("length"))
        name = visual.get("name")
        inner = 0.0
        if "_wall_" in name:
            inner = outer - 1e-3 * float(name.split("_wall_")[1].removesuffix("mm"))
        mass = DENSITY * np.pi * (outer**2 - inner**2) * length
        across = mass * (3.0 * (outer**2 + inner**2) + length**2) / 12.0
        moments = np.array([across, across, 0.5 * mass * (outer**2 + inner**2)])
    return pin.Inertia(mass, centre, rotation @ np.diag(moments) @ rotation.T)
