"""The double shaft: uniform output, misphased forks, and the chain of moments through it."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.scenes import double, relative, text

import cardan_dyn as cd
from cardan_dyn.analytic import grossmann, single_joint

LENGTH = 0.9


def misphased() -> str:
    """The double shaft with the fork at joint 2 turned by 90° on the intermediate shaft."""
    urdf = text("double_shaft_z")
    start = urdf.index('<joint name="pin_2_in"')
    end = urdf.index("</joint>", start)
    urdf = urdf[:start] + urdf[start:end].replace('"0 0 1"', '"0 1 0"') + urdf[end:]
    start = urdf.index('<loop name="pin_2_out"')
    return urdf[:start] + urdf[start:].replace('"0 1 0"', '"0 0 1"')


@pytest.mark.parametrize("beta_deg", [0.0, 1.0, 8.5, 30.0, 50.0, 80.0])
def test_equal_angles_turn_uniformly(
    shaft: cd.Mechanism, positions: np.ndarray, beta_deg: float
) -> None:
    beta = np.deg2rad(beta_deg)
    turn = double(shaft, beta, beta).sweep(positions)
    assert np.max(np.abs(turn.motion.position("bearing_out") - positions)) < 1e-13
    assert np.max(np.abs(turn.motion.ratio("bearing_out") - 1.0)) < 1e-13
    assert np.max(np.abs(turn.drive_effort - 1.0)) < 1e-13
    assert np.all([turn[name].unique for name in shaft.joint_names])
    assert np.max(np.abs(turn.motion.position("slip"))) < 1e-14


@pytest.mark.parametrize("beta_deg", [8.5, 30.0, 50.0])
def test_a_fork_turned_by_90_degrees_squares_the_ratio(
    positions: np.ndarray, beta_deg: float
) -> None:
    beta = np.deg2rad(beta_deg)
    turn = double(cd.load(misphased()), beta, beta).sweep(positions)
    ratio = turn.motion.ratio("bearing_out")
    assert abs(np.min(ratio) / np.cos(beta) ** 2 - 1.0) < 1e-13
    assert abs(np.max(ratio) * np.cos(beta) ** 2 - 1.0) < 1e-13
    middle = single_joint.output_angle(beta, positions)
    product = single_joint.speed_ratio(beta, positions) * single_joint.speed_ratio(beta, middle)
    assert relative(ratio, product) < 1e-13


@pytest.mark.parametrize(("beta_1", "beta_2"), [(30.0, 20.0), (20.0, 30.0), (30.0, -20.0)])
def test_unequal_angles_compose_two_joints(
    shaft: cd.Mechanism, positions: np.ndarray, beta_1: float, beta_2: float
) -> None:
    """Joint 2 is driven by the fork that stands normal to its plane: Weisbach's zero."""
    first, second = np.deg2rad([beta_1, abs(beta_2)])
    turn = double(shaft, first, np.deg2rad(beta_2)).sweep(positions)
    middle = single_joint.output_angle(first, positions)
    last = single_joint.output_angle(second, middle, zero="normal")
    assert relative(turn.motion.position("bearing_out"), last) < 1e-14
    ratio = single_joint.speed_ratio(first, positions)
    ratio = ratio * single_joint.speed_ratio(second, middle, zero="normal")
    assert relative(turn.motion.ratio("bearing_out"), ratio) < 1e-13
    assert relative(turn.drive_effort, ratio) < 1e-13


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["Z", "W"])
def test_force_of_the_intermediate_shaft(
    shaft: cd.Mechanism, positions: np.ndarray, sign: float
) -> None:
    """P = (M₁ − M₂) × e₂ / L from the equilibrium of the intermediate shaft alone."""
    beta = np.deg2rad(25.0)
    turn = double(shaft, beta, sign * beta, load=-50.0).sweep(positions)
    e_2 = np.array([np.cos(beta), np.sin(beta), 0.0])
    moment_1 = turn.wrench("pin_1_out", "world").moment
    moment_2 = turn.wrench("pin_2_in", "world").moment
    force = np.cross(moment_1 - moment_2, e_2) / LENGTH
    scale = np.max(np.abs(moment_1))
    for name in ("pin_1_out", "slip", "pin_2_in"):
        found = turn.wrench(name, "world").force
        assert np.max(np.abs(np.abs(found) - np.abs(force))) < 1e-13 * scale / LENGTH
    # The spline slides freely: no force along the shaft, neither in it nor in its joints.
    assert np.max(np.abs(turn["slip"].axial)) < 1e-13 * scale / LENGTH
    # Catalogue, drive pin in the plane of the shafts: T cos β₁ (tan β₁ + σ tan β₂) / L.
    torque = turn.drive_effort[0]
    expected = 0.0 if sign > 0.0 else torque * 2.0 * np.sin(beta) / LENGTH
    assert np.linalg.norm(force[0]) == pytest.approx(expected, abs=1e-12 * torque)


def test_torques_and_bending_along_the_line(shaft: cd.Mechanism, positions: np.ndarray) -> None:
    beta = np.deg2rad(40.0)
    turn = double(shaft, beta, beta).sweep(positions)
    closed = grossmann.moments(beta, positions)
    assert relative(turn["slip"].torsion, closed.torsion_2) < 1e-13
    assert relative(turn["bearing_in"].bending, closed.bending_1) < 1e-13
    assert relative(turn["bearing_out"].bending, closed.bending_1) < 1e-13
    assert relative(turn["bearing_out"].torsion, -np.ones_like(positions)) < 1e-15
