"""Bushings: large rotations against quaternions, and what they refuse."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pinocchio
import pytest

import cardan_dyn as cd

K = np.arange(1.0, 7.0)
REST = np.zeros((1, 6))


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-4, 0.49, 0.51, 1.0, 2.5, 3.09])
def test_the_moment_is_the_slope_of_the_energy_at_any_rotation(angle: float) -> None:
    """Against Pinocchio's logarithm of rotations, turned on by small steps."""
    root = np.random.default_rng(1).uniform(-1.0, 1.0, (6, 6))
    stiffness = root @ root.T
    bushing = cd.Bushing("a", "b", np.zeros(3), stiffness)
    axis = np.array([0.48, -0.6, 0.64])
    rotation, span = pinocchio.exp3(angle * axis), np.array([0.3, -0.2, 0.5])
    force = bushing.force((angle * axis)[None], span[None], REST, "")

    def energy(turn: np.ndarray, shift: np.ndarray) -> float:
        d = np.concatenate([span + shift, pinocchio.log3(pinocchio.exp3(turn) @ rotation)])
        return 0.5 * d @ stiffness @ d

    step, slope, none = 1e-4, np.empty(6), np.zeros(3)
    for index, unit in enumerate(np.eye(3)):
        for row, at in (
            (index, lambda h, unit=unit: energy(none, h * unit)),
            (3 + index, lambda h, unit=unit: energy(h * unit, none)),
        ):
            near, far = at(step) - at(-step), at(2.0 * step) - at(-2.0 * step)
            slope[row] = (8.0 * near - far) / (12.0 * step)
    np.testing.assert_allclose(force.wrench[0], -slope, atol=1e-9 * (1.0 + np.max(np.abs(slope))))
    assert force.energy[0] == pytest.approx(energy(none, none))


def test_damping_acts_on_the_velocity_seen_from_the_first_link() -> None:
    damping = np.diag([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    damping[0, 4] = damping[4, 0] = 0.5
    bushing = cd.Bushing("a", "b", np.zeros(3), np.zeros(6), damping)
    rate = np.array([[1.0, -1.0, 2.0, 0.5, 3.0, -2.0]])
    force = bushing.force(np.array([[1.0, 2.0, 0.5]]), rate[:, :3], rate, "")
    np.testing.assert_allclose(force.wrench, -rate @ damping)
    assert force.dissipation == pytest.approx((rate @ damping @ rate.T)[0, 0])
    assert force.energy == pytest.approx(0.0)


def test_beyond_half_a_turn_the_moment_has_to_be_along_the_axis() -> None:
    bushing, turn = cd.Bushing("a", "b", np.zeros(3), K), np.array([[20.0 * np.pi, 0.0, 0.0]])
    force = bushing.force(turn, np.zeros((1, 3)), REST, "e")
    np.testing.assert_allclose(force.wrench, [[0.0, 0.0, 0.0, -80.0 * np.pi, 0.0, 0.0]])
    with pytest.raises(cd.ArgumentError, match=r"e: it is wound by 3.12 rad, and its moment then"):
        bushing.force(np.array([[0.0, 3.12 * 0.6, 3.12 * 0.8]]), np.zeros((1, 3)), REST, "e")


def test_diagonals_points_and_rounded_placements_are_completed() -> None:
    bushing = cd.Bushing("a", "b", (1.0, 2.0, 3.0), K)
    np.testing.assert_array_equal(bushing.stiffness, np.diag(K))
    assert not np.any(bushing.damping)
    assert bushing.origin[:3, 3].tolist() == [1.0, 2.0, 3.0]
    rounded = np.eye(4)
    rounded[:3, :3] = np.round(pinocchio.exp3(np.array([0.1, 0.2, 0.3])), 8)
    placed = cd.Bushing("a", "b", rounded, K, origin_b=rounded)
    rotation = placed.origin[:3, :3]
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-15)
    np.testing.assert_array_equal(placed.origin_b, placed.origin)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: cd.Bushing("a", "a", np.zeros(3), K), "both ends are on link 'a'"),
        (lambda: cd.Bushing("a", "b", np.zeros(2), K), "origin has shape (2,), expected (3,) or"),
        (lambda: cd.Bushing("a", "b", 2.0 * np.eye(4), K), "origin is no placement"),
        (lambda: cd.Bushing("a", "b", np.diag([1, 1, -1, 1]), K), "origin is no placement"),
        (lambda: cd.Bushing("a", "b", np.zeros(3), np.ones(5)), "stiffness has shape (5,)"),
        (lambda: cd.Bushing("a", "b", np.zeros(3), -K), "stiffness is negative in some direction"),
        (lambda: cd.Bushing("a", "b", np.zeros(3), np.triu(np.ones((6, 6)))), "is not symmetric"),
        (lambda: cd.Bushing("a", "b", np.zeros(3), K, -K), "damping is negative in some"),
        (lambda: cd.Bushing("a", "b", np.zeros(3), K * np.nan), "stiffness is not finite"),
        (lambda: cd.Bushing("a", "b", np.zeros(3), K, origin_b=np.eye(3)), "origin_b has shape"),
    ],
)
def test_bad_values_are_refused(make: Callable[[], object], message: str) -> None:
    with pytest.raises(cd.ArgumentError, match=re.escape(message)):
        make()


ARM = """<robot name="arm"><link name="base"/><link name="arm"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link><link name="other"/>
<joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/>
<axis xyz="0 0 {sense}"/></joint><joint name="mimic" type="continuous"><parent link="base"/>
<child link="other"/><axis xyz="0 0 1"/><mimic joint="hinge" multiplier="-1" offset="4"/></joint>
</robot>"""


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("half", [np.pi, -np.pi, np.pi - 1e-12, 3.12])
def test_half_a_turn_at_zero_is_in_no_sense(sense: int, half: float) -> None:
    """Rounding would say in which: +15.7 or -15.7 N·m."""

    def swept(angle: float) -> cd.Sweep:
        end = pinocchio.SE3(pinocchio.utils.rotate("z", angle), np.zeros(3)).homogeneous
        bushing = cd.Bushing("base", "arm", np.zeros(3), (1, 1, 1, 5, 5, 5), origin_b=end)
        mechanism = cd.load(ARM.format(sense=sense))
        return cd.Scene(mechanism, drive="hinge", elements=[bushing]).sweep([0.0, 1.0, -4.0])

    with pytest.raises(cd.ArgumentError, match="half a turn at the description's zero"):
        swept(half)
    found = swept(sense * 3.0)
    np.testing.assert_allclose(found.drive_effort, [15.0, 20.0, -5.0], atol=1e-12)


def test_zero_of_a_mimic_is_where_its_offset_puts_it() -> None:
    """At the description's zero it is without deformation, 4 rad away from its coordinate's."""
    bushing = cd.Bushing("base", "other", np.zeros(3), (0, 0, 0, 5, 5, 5))
    scene = cd.Scene(cd.load(ARM.format(sense=1)), drive="hinge", elements=[bushing])
    way = np.array([0.0, 0.5, -2.0, 7.0])
    np.testing.assert_allclose(scene.sweep(way).drive_effort, 5.0 * way, atol=1e-12)
