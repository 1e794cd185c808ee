"""The universal joint against geometry, Grossmann and Thoma: signs, frames, shafts and zeros."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.scenes import CrossGeometry, relative, text, universal

import cardan_dyn as cd
from cardan_dyn.analytic import grossmann, single_joint, thoma

BETAS = [(np.deg2rad(beta), 1e-13) for beta in (0.0, 1e-6, 1.0, 8.5, 20.0, 30.0, 50.0, 65.0, 80.0)]
BETAS.append((np.deg2rad(89.99), 1e-11))
SMALLEST = 1e-300


def magnitude(reference: np.ndarray, scale: float = 1.0) -> np.ndarray:
    """Keep references that are zero at beta = 0 comparable: errors there are absolute."""
    return reference if np.max(np.abs(reference)) > SMALLEST else np.full_like(reference, scale)


def error(found: np.ndarray, reference: np.ndarray) -> float:
    return float(np.max(np.abs(found - reference)) / np.max(np.abs(magnitude(reference))))


@pytest.mark.parametrize(("beta", "tolerance"), BETAS)
def test_grossmann(
    joint: cd.Mechanism, positions: np.ndarray, beta: float, tolerance: float
) -> None:
    turn = universal(joint, beta).sweep(positions)
    torque = turn["bearing_in"].torsion
    closed = grossmann.moments(beta, positions)
    assert np.all(torque > 0.0)
    assert error(turn["bearing_in"].bending / torque, closed.bending_1) < tolerance
    assert error(-turn["bearing_out"].torsion / torque, closed.torsion_2) < tolerance
    assert error(turn["bearing_out"].bending / torque, closed.bending_2) < tolerance
    # Given the output torque, the input torque is the one that power asks for.
    assert error(turn.drive_effort, 1.0 / closed.torsion_2) < tolerance


@pytest.mark.parametrize(("beta", "tolerance"), BETAS)
def test_thoma(joint: cd.Mechanism, positions: np.ndarray, beta: float, tolerance: float) -> None:
    turn = universal(joint, beta).sweep(positions)
    moment = turn.wrench("bearing_out", "parent").moment
    m_x, m_z = thoma.bending_moments(beta, positions)
    assert error(moment[:, 0], -np.ones_like(positions)) < tolerance
    assert error(moment[:, 1], m_x) < tolerance
    assert error(moment[:, 2], m_z) < tolerance


@pytest.mark.parametrize(("beta", "tolerance"), BETAS)
def test_motion(joint: cd.Mechanism, positions: np.ndarray, beta: float, tolerance: float) -> None:
    turn = universal(joint, beta).sweep(positions, speed=3.0, acceleration=-2.0)
    ratio = single_joint.speed_ratio(beta, positions)
    second = single_joint.acceleration_ratio(beta, positions)
    motion = turn.motion
    # The angle is steep near the main positions at 89.99°: 1/cos β of an input rounding error.
    angle = single_joint.output_angle(beta, positions)
    assert np.max(np.abs(motion.position("bearing_out") - angle)) < tolerance
    assert error(motion.ratio("bearing_out"), ratio) < tolerance
    assert error(motion.velocity("bearing_out"), 3.0 * ratio) < tolerance
    assert error(motion.acceleration("bearing_out"), -2.0 * ratio + 9.0 * second) < tolerance
    assert turn.loop_residual < 1e-14


@pytest.mark.parametrize(("beta", "tolerance"), BETAS)
def test_signed_vectors_in_every_frame(
    joint: cd.Mechanism, positions: np.ndarray, beta: float, tolerance: float
) -> None:
    """Every component, with its sign: a swapped shaft or a wrong frame cannot pass."""
    turn = universal(joint, beta, load=-7.0).sweep(positions)
    geometry = CrossGeometry(beta, positions)
    moment = geometry.moment(7.0)
    world = {
        "bearing_in": moment,  # the bearing drives the shaft
        "pin_in": moment,
        "pin_out": moment,
        "bearing_out": -moment,  # the bearing holds the shaft back
    }
    for name, reference in world.items():
        found = turn.wrench(name, "world")
        assert relative(found.moment, reference) < tolerance
        rotation = turn.rotation(name)
        in_joint = np.einsum("nij,ni->nj", rotation, reference)
        assert relative(turn[name].moment, in_joint) < tolerance
        assert np.max(np.abs(found.force)) < 1e-13 * np.max(np.abs(reference))
    # Housing: it swivels about z, and z does not turn, so that all its frames agree there.
    swivel = turn["joint_angle"].moment[:, 2]
    assert error(swivel, -moment[:, 2]) < tolerance
    np.testing.assert_array_equal(swivel, turn.holding_effort["joint_angle"])


@pytest.mark.parametrize("beta", [np.deg2rad(beta) for beta in (1.0, 30.0, 80.0)])
def test_cross_carries_no_moment_along_its_pins(
    joint: cd.Mechanism, positions: np.ndarray, beta: float
) -> None:
    turn = universal(joint, beta).sweep(positions)
    geometry = CrossGeometry(beta, positions)
    for name, pin in (("pin_in", geometry.pin_1), ("pin_out", geometry.pin_2)):
        moment = turn.wrench(name, "world").moment
        along = np.abs(np.sum(moment * pin, axis=1)) / np.linalg.norm(moment, axis=1)
        assert np.max(along) < 1e-13
        assert np.max(np.abs(turn[name].torsion) / np.linalg.norm(moment, axis=1)) < 1e-13


def test_main_positions_exactly(joint: cd.Mechanism) -> None:
    """Position A bends shaft 2 alone, position B shaft 1 alone (Thoma, Abb. 1 and 3)."""
    beta = np.deg2rad(50.0)
    turn = universal(joint, beta).sweep([0.0, 0.5 * np.pi, np.pi, 1.5 * np.pi])
    in_a, in_b = [0, 2], [1, 3]
    assert np.max(turn["bearing_in"].bending[in_a]) < 1e-15
    assert np.max(turn["bearing_out"].bending[in_b]) < 1e-15
    np.testing.assert_allclose(turn["bearing_out"].bending[in_a], np.tan(beta), rtol=1e-14)
    ratio = turn["bearing_in"].bending[in_b] / turn.drive_effort[in_b]
    np.testing.assert_allclose(ratio, np.tan(beta), rtol=1e-14)


def test_turning_the_forks_moves_the_zero_by_a_quarter(positions: np.ndarray) -> None:
    """With the input pin normal to the plane at zero, angles count from Weisbach's position."""
    turned = text("universal_joint")
    start = turned.index('<joint name="pin_in"')
    end = turned.index("</joint>", start)
    turned = turned[:start] + turned[start:end].replace('"0 1 0"', '"0 0 1"') + turned[end:]
    start = turned.index('<loop name="pin_out"')
    turned = turned[:start] + turned[start:].replace('"0 0 1"', '"0 1 0"')
    # At beta = 0 the forks fit as they are; the scene then bends the joint.
    beta = np.deg2rad(30.0)
    turn = universal(cd.load(turned), beta).sweep(positions)
    weisbach = single_joint.output_angle(beta, positions, zero="normal")
    assert relative(turn.motion.position("bearing_out"), weisbach) < 1e-14
    ours = single_joint.output_angle(beta, positions)
    assert np.max(np.abs(turn.motion.position("bearing_out") - ours)) > 0.1


def test_only_the_moments_are_unique(joint: cd.Mechanism, positions: np.ndarray) -> None:
    turn = universal(joint, 0.5).sweep(positions)
    for name in joint.joint_names:
        np.testing.assert_array_equal(turn[name].unique, [False] * 3 + [True] * 3)


def test_thoma_rig(positions: np.ndarray) -> None:
    """Constant input speed, massless cross, flywheel on shaft 2, by inverse dynamics."""
    inertia, speed = 0.37, 120.0
    mechanism = cd.load(rig(inertia))
    for beta_deg in (8.5, 20.0, 45.0):
        beta = np.deg2rad(beta_deg)
        scene = cd.Scene(mechanism, drive="bearing_in", held={"joint_angle": beta})
        turn = scene.sweep(positions, speed=speed)
        second = single_joint.acceleration_ratio(beta, positions)
        torque = inertia * speed**2 * second
        expected = thoma.rig_moments(beta, positions, inertia, speed)
        # Moment of the cross on shaft 2, in the axes of its fixed bearing: (M_t, -M_x, -M_z).
        in_world = turn.wrench("pin_out", "world").moment
        e_2 = np.array([np.cos(beta), np.sin(beta), 0.0])
        across = np.array([-np.sin(beta), np.cos(beta), 0.0])
        assert relative(in_world @ e_2, torque) < 1e-12
        assert relative(in_world @ e_2, expected[0]) < 1e-12
        assert relative(-in_world @ across, expected[1]) < 1e-12
        assert relative(-in_world[:, 2], expected[2]) < 1e-12
        m_x, m_z = thoma.bending_moments(beta, positions, torque)
        assert relative(-in_world @ across, m_x) < 1e-12
        assert relative(-in_world[:, 2], m_z) < 1e-12


def rig(inertia: float) -> str:
    """The universal joint with a massless cross and a flywheel of this inertia on shaft 2."""
    urdf = text("universal_joint")
    start = urdf.index("<inertial>", urdf.index('<link name="cross">'))
    end = urdf.index("</inertial>", start) + len("</inertial>")
    urdf = urdf[:start] + urdf[end:]
    start = urdf.index("<inertial>", urdf.index('<link name="shaft_out">'))
    end = urdf.index("</inertial>", start) + len("</inertial>")
    flywheel = (
        '<inertial><origin xyz="0.4 0 0"/><mass value="20"/>'
        f'<inertia ixx="{inertia!r}" iyy="0.3" izz="0.3" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    return urdf[:start] + flywheel + urdf[end:]
