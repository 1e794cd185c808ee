"""Motions: coordinates with their turns, rates by joint, velocity ratios by drive."""

from __future__ import annotations

import copy
import pickle
from operator import attrgetter

import numpy as np
import pinocchio as pin
import pytest
from testkit.mixed_chain import MIXED, moved, rows
from testkit.planar_linkages import four_bar

import cardan_dyn as cd
from cardan_dyn.core.dynamics.velocity_ratios import VelocityRatios
from cardan_dyn.core.results.motion import Motion

COUNT = 4
DRIVES = ("turn", "slide")


def random_motion(drives: tuple[str, ...] = DRIVES, shape: tuple[int, ...] | None = None) -> Motion:
    mechanism = cd.load(MIXED)
    x = rows(mechanism, COUNT)
    rng = np.random.default_rng(2)
    turns = np.zeros_like(x)
    turns[:, mechanism.coordinates.columns["turn"]] = [[-1.0], [0.0], [2.0], [5e5]]
    nv = mechanism.model.nv
    rates = (rng.normal(size=(COUNT, nv)), rng.normal(size=(COUNT, nv)))
    ratios = VelocityRatios.of(rng.normal(size=(COUNT, nv, 2)))
    return Motion(mechanism, drives, x, turns, (*rates, ratios), shape)


def test_positions_count_whole_turns() -> None:
    motion = random_motion()
    columns = motion.mechanism.coordinates.columns
    angle = motion.x[:, columns["turn"]][:, 0]
    expected = angle + 2.0 * np.pi * np.array([-1.0, 0.0, 2.0, 5e5])
    np.testing.assert_array_equal(motion.position("turn"), expected)
    np.testing.assert_array_equal(motion.position("hinge"), motion.x[:, columns["hinge"]][:, 0])
    assert len(motion) == COUNT


def test_joints_with_several_coordinates_give_columns() -> None:
    mechanism = cd.load(
        '<robot name="r"><link name="base"/><link name="a"/><link name="b"/>'
        '<joint name="free" type="floating"><parent link="base"/><child link="a"/></joint>'
        '<joint name="cross" type="universal"><parent link="a"/><child link="b"/>'
        '<axis xyz="0 1 0"/><axis2 xyz="1 0 0"/></joint></robot>'
    )
    x = rows(mechanism, COUNT)
    rates = np.arange(COUNT * 8.0).reshape(COUNT, 8)
    ratios = VelocityRatios.of(rates[:, :, None])
    motion = Motion(mechanism, (), x, np.zeros_like(x), (rates, -rates, ratios))
    assert motion.position("free").shape == (COUNT, 7)
    np.testing.assert_allclose(np.linalg.norm(motion.position("free")[:, 3:], axis=1), 1.0)
    assert motion.position("cross").shape == (COUNT, 2)
    for name, columns in (("free", slice(0, 6)), ("cross", slice(6, 8))):
        np.testing.assert_array_equal(motion.velocity(name), rates[:, columns])
        np.testing.assert_array_equal(motion.acceleration(name), -rates[:, columns])
        np.testing.assert_array_equal(motion.ratio(name), rates[:, columns])


def test_configurations_are_pinocchios() -> None:
    """Velocities of the motion move Pinocchio's configurations as its integrator does."""
    motion = random_motion()
    model, step = motion.mechanism.model, 1e-7
    still = np.zeros_like(motion.a)
    later = moved(motion.mechanism, motion.x, motion.v, still, step)
    later_q = motion.mechanism.coordinates.configuration(later)
    for q, v, expected in zip(motion.q, motion.v, later_q, strict=True):
        # Rounding of coordinates of size 1 remains.
        np.testing.assert_allclose(pin.integrate(model, q, step * v), expected, atol=1e-15)
        assert pin.isNormalized(model, q, 1e-14)


def test_rates_belong_to_their_joints() -> None:
    motion = random_motion()
    model, joints = motion.mechanism.model, motion.mechanism.joints
    for name in ("turn", "slide", "swing", "hinge"):
        column = model.idx_vs[joints[name].id]
        np.testing.assert_array_equal(motion.velocity(name), motion.v[:, column])
        np.testing.assert_array_equal(motion.acceleration(name), motion.a[:, column])
        for index, drive in enumerate(DRIVES):
            expected = motion.velocity_ratios.values[:, 2 * column + index]
            for given in (index, np.int64(index), drive):
                np.testing.assert_array_equal(motion.ratio(name, given), expected)


@pytest.mark.parametrize("drive", [-1, 2, True, 0.0, None, "hinge", np.timedelta64(0, "s"), [0]])
def test_unknown_drives_are_refused(drive: object) -> None:
    with pytest.raises(cd.ArgumentError, match=r"no drive .*; drives: 0 \(turn\), 1 \(slide\)$"):
        random_motion().ratio("hinge", drive)  # type: ignore[arg-type]


def test_drives_without_names_are_listed_by_index() -> None:
    with pytest.raises(cd.ArgumentError, match=r"no drive 7; drives: 0, 1$"):
        random_motion(()).ratio("hinge", 7)


@pytest.mark.parametrize("shape", [(4,), (2, 2), (1, 4), (2, 1, 2)])
def test_samples_may_have_several_dimensions(shape: tuple[int, ...]) -> None:
    row, motion = random_motion(), random_motion(shape=shape)
    model = motion.mechanism.model
    assert motion.shape == shape
    assert len(motion) == shape[0]
    for name, trailing in (("q", (model.nq,)), ("v", (model.nv,)), ("a", (model.nv,))):
        expected = getattr(row, name).reshape(*shape, *trailing)
        np.testing.assert_array_equal(getattr(motion, name), expected)
    for joint in motion.mechanism.coordinates.columns:
        for quantity in ("position", "velocity", "acceleration", "ratio"):
            expected = getattr(row, quantity)(joint)
            found = getattr(motion, quantity)(joint)
            np.testing.assert_array_equal(found, expected.reshape(*shape, *expected.shape[1:]))
        for found, expected in zip(
            motion.joint_placement(joint), row.joint_placement(joint), strict=True
        ):
            np.testing.assert_array_equal(found, expected.reshape(*shape, *expected.shape[1:]))


def test_joints_without_coordinates_are_refused() -> None:
    motion = random_motion()
    for method in (motion.position, motion.velocity, motion.acceleration, motion.ratio):
        with pytest.raises(cd.ModelError, match="no joint 'lever'; joints: "):
            method("lever")
        with pytest.raises(cd.ModelError, match=r"'bolt' is fixed .* that have one: .*turn"):
            method("bolt")
    with pytest.raises(cd.ModelError, match="no joint 'lever'"):
        motion.joint_placement("lever")


@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda m: pickle.loads(pickle.dumps(m))]
)
@pytest.mark.parametrize("shape", [None, (2, 2)])
def test_copies_are_equal_and_as_closed_to_writing(
    copied: object, shape: tuple[int, ...] | None
) -> None:
    motion = random_motion(shape=shape)
    again = copied(motion)  # type: ignore[operator]
    assert again.shape == motion.shape
    for name in ("x", "turns", "v", "a", "velocity_ratios.values", "velocity_ratios.moved"):
        array = attrgetter(name)(again)
        np.testing.assert_array_equal(array, attrgetter(name)(motion))
        assert not array.flags.writeable
    assert again.drives == DRIVES
    with pytest.raises(cd.ImmutableError, match="v of a Motion cannot be changed"):
        again.v = None


def test_arrays_of_the_solver_stay_writeable() -> None:
    mechanism = cd.load(MIXED)
    x, rates = rows(mechanism, 1), np.zeros((1, mechanism.model.nv))
    ratios = VelocityRatios.of(rates[:, :, None])
    motion = Motion(mechanism, (), x, np.zeros_like(x), (rates, rates, ratios))
    assert not (motion.v.flags.writeable or motion.a.flags.writeable)
    x[0], rates[0] = 1.0, 2.0


def test_rates_of_a_sweep_are_derivatives_of_its_positions() -> None:
    """Central differences of positions, and of velocities, along a given motion of the drive."""
    scene = cd.Scene(four_bar(), drive="A")
    speed, acceleration, step = 2.0, -3.0, 1e-5
    start = np.linspace(0.0, 6.0, 7)
    moments = [-step, 0.0, step]
    before, now, after = (
        scene.sweep(
            start + speed * t + 0.5 * acceleration * t**2, speed + acceleration * t, acceleration
        ).motion
        for t in moments
    )
    for name in "ABD":
        velocity = (after.position(name) - before.position(name)) / (2.0 * step)
        rate = (after.velocity(name) - before.velocity(name)) / (2.0 * step)
        # Rounding eps / step = 2e-11, and terms of third order.
        np.testing.assert_allclose(now.velocity(name), velocity, atol=1e-8)
        np.testing.assert_allclose(now.acceleration(name), rate, atol=1e-7)
        np.testing.assert_allclose(now.ratio(name), now.velocity(name) / speed, rtol=1e-13)
