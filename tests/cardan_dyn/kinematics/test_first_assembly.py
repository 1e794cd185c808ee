"""First assembly: mechanisms whose zero is far from closed are closed near it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import draw
from scipy.spatial.transform import Rotation
from testkit.planar_linkages import described, four_bar, joint, link, loop

import cardan_dyn as cd
from cardan_dyn.core.description.description import Description, JointDescription
from cardan_dyn.core.kinematics.closing.far import assembled_near, closed_from
from cardan_dyn.core.kinematics.closing.group_solver import GroupSolver
from cardan_dyn.core.kinematics.loops.groups import independent_groups
from cardan_dyn.core.kinematics.loops.structure import Structure


def displaced(description: Description, rng: np.random.Generator, length: float) -> Description:
    """Move the zero of every joint by up to 0.5 rad or 0.2 lengths, so that no loop is closed."""

    def moved(joint: JointDescription) -> JointDescription:
        motion = np.eye(4)
        turn, slide = rng.uniform(-0.5, 0.5), rng.uniform(-0.2, 0.2)
        if joint.type == "prismatic":
            motion[:3, 3] = slide * length * joint.axis
        elif joint.type == "spherical":
            motion[:3, :3] = Rotation.from_rotvec([turn, 0.0, 0.0]).as_matrix()
        elif joint.type in ("revolute", "continuous"):
            motion[:3, :3] = Rotation.from_rotvec(turn * joint.axis).as_matrix()
        return replace(joint, origin=joint.origin @ motion)

    # Without its text, which the proof would read once more.
    joints = tuple(moved(joint) for joint in description.joints)
    return replace(description, joints=joints, source=None)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(40))
def test_random_chains_are_assembled_from_zeros_that_are_not_closed(seed: int) -> None:
    original = cd.load(draw(seed).chain.text)
    rng = np.random.default_rng(seed)
    mechanism = cd.Mechanism(displaced(original.description, rng, original.characteristic_length))
    zero, every = mechanism.coordinates.neutral(), np.arange(mechanism.model.nv)
    x, residual = assembled_near(Structure(mechanism), zero, every, every)
    assert residual < 1e-7
    if not (mechanism.loops or mechanism.couplings):
        np.testing.assert_array_equal(x, zero)


def test_pinned_joints_stay() -> None:
    mechanism = four_bar()
    velocities, columns = mechanism.coordinates.velocity_columns, mechanism.coordinates.columns
    start = mechanism.coordinates.neutral()
    start[columns["A"]] = 0.8
    free = np.setdiff1d(np.arange(mechanism.model.nv), [velocities["A"].start])
    x, residual = assembled_near(Structure(mechanism), start, free, free)
    assert x[columns["A"].start] == 0.8
    assert residual < 1e-8


def flat(base: float) -> cd.Mechanism:
    """Crank 1, coupler 1.5 and rocker 1, all on the line between two pivots `base` apart."""
    return described(
        *(link(name) for name in "abc"),
        joint("A", "ground", "a"),
        joint("B", "a", "b", (1.0, 0.0)),
        joint("D", "ground", "c", (base, 0.0)),
        loop("b", "c", (1.5, 0.0), (-1.0, 0.0)),
    )


def test_flat_zeros_are_left() -> None:
    """In line, no joint moves the ends along the gap, so the error has no slope to follow."""
    mechanism = flat(3.2)
    zero, every = mechanism.coordinates.neutral(), np.arange(mechanism.model.nv)
    (group,) = independent_groups(Structure(mechanism), every)
    stuck, gap = closed_from(GroupSolver(mechanism, group), zero[None, :])
    np.testing.assert_array_equal(stuck[0], zero)
    assert gap[0] > 0.05
    x, residual = assembled_near(Structure(mechanism), zero, every, every)
    assert residual < 1e-10
    # Of the closed configurations, one near the line: no link has turned by a right angle.
    assert np.max(np.abs(x)) < 0.5 * np.pi


def test_the_least_gap_is_returned_where_nothing_closes() -> None:
    mechanism = flat(4.0)
    zero, every = mechanism.coordinates.neutral(), np.arange(mechanism.model.nv)
    _, residual = assembled_near(Structure(mechanism), zero, every, every)
    assert residual * mechanism.characteristic_length == pytest.approx(0.5, rel=1e-6)


def test_loops_that_nothing_needs_stay_open() -> None:
    mechanism = flat(3.2)
    zero, every = mechanism.coordinates.neutral(), np.arange(mechanism.model.nv)
    x, residual = assembled_near(Structure(mechanism), zero, every, np.zeros(0, dtype=int))
    np.testing.assert_array_equal(x, zero)
    assert residual == 0.0


def test_loops_without_a_free_joint_count() -> None:
    mechanism = flat(3.2)
    zero, every = mechanism.coordinates.neutral(), np.arange(mechanism.model.nv)
    x, residual = assembled_near(Structure(mechanism), zero, np.zeros(0, dtype=int), every)
    np.testing.assert_array_equal(x, zero)
    assert residual > 0.05
