"""The equations of one sample beside Pinocchio's own algorithms on the same model."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
import pinocchio as pin
import pytest
from scenes import draw
from testkit.scenes import forward_accelerations

import cardan_dyn as cd
from cardan_dyn.core.mechanics.bodies import Tree, tree_of
from cardan_dyn.core.mechanics.placements import Placed, moving, placed, stepped
from cardan_dyn.core.mechanics.reactions import momentum_rates

BOUND = 1e-13
GRAVITY = np.array([0.4, -1.5, -9.6])


class State(NamedTuple):
    """A mechanism at random coordinates, which need not close its loops."""

    mechanism: cd.Mechanism
    model: pin.Model
    tree: Tree
    x: np.ndarray
    at: Placed
    v: np.ndarray
    a: np.ndarray

    @property
    def q(self) -> np.ndarray:
        return self.mechanism.coordinates.configuration(self.x[None, :])[0]

    def in_world(self, vector: object) -> np.ndarray:
        return self.tree.axes @ np.array(vector, dtype=float)

    def by_rate(self, values: np.ndarray) -> dict[int, float]:
        return {rate: float(values[rate] / self.tree.units[rate]) for rate in range(len(values))}


@cache
def state(seed: int) -> State:
    """Return a random chain, with all of its joint types over the seeds."""
    rng = np.random.default_rng(seed)
    mechanism = cd.load(draw(seed).chain.text)
    model = mechanism.model.copy()
    for body in mechanism.auxiliary_bodies:
        model.inertias[body] = pin.Inertia.Zero()
    tree = tree_of(mechanism)
    x = mechanism.coordinates.neutral()[None, :]
    x = mechanism.coordinates.normalised(x + rng.normal(size=x.shape))[0]
    x[mechanism.coordinates.scale != 1.0] *= mechanism.characteristic_length
    units = {
        column: tree.length if body.kind == "prismatic" else 1.0
        for body in tree.bodies
        for column in body.columns
    }
    at = placed(tree, {column: float(x[column] / unit) for column, unit in units.items()})
    v, a = rng.normal(size=(2, model.nv)) * tree.units
    return State(mechanism, model, tree, x, at, v, a)


SEEDS = range(40)


@pytest.mark.slow
def test_seeds_have_all_joints() -> None:
    kinds = {joint.type for seed in SEEDS for joint in state(seed).mechanism.joints.values()}
    wanted = "revolute continuous prismatic fixed universal cylindrical planar spherical floating"
    assert kinds >= {*wanted.split()}


@pytest.mark.parametrize("seed", SEEDS)
def test_placements(seed: int) -> None:
    item = state(seed)
    data = item.model.createData()
    pin.forwardKinematics(item.model, data, item.q)
    size = max(
        1.0, float(np.abs([data.oMi[k].translation for k in range(item.model.njoints)]).max())
    )
    for index in range(item.model.njoints - 1):
        expected = data.oMi[index + 1]
        rotation = item.tree.axes @ np.array(item.at.rotations[index], dtype=float).T
        np.testing.assert_allclose(rotation, expected.rotation, atol=BOUND)
        point = item.in_world(item.at.points[index]) * item.tree.length + item.tree.origin
        np.testing.assert_allclose(point, expected.translation, atol=BOUND * size)


@pytest.mark.parametrize("seed", SEEDS)
def test_velocities_accelerations_and_inverse_dynamics(seed: int) -> None:
    item = state(seed)
    model, tree = item.model, item.tree
    data = model.createData()
    pin.forwardKinematics(model, data, item.q, item.v, item.a)
    rates = item.by_rate(item.v), item.by_rate(item.a)
    motion = moving(tree, item.at, *rates, (0.0, 0.0, 0.0))
    for index in range(len(tree.bodies)):
        v, a = data.v[index + 1], data.a[index + 1]
        size = 1.0 + float(np.linalg.norm(a.vector) / tree.length)
        np.testing.assert_allclose(motion.spins[index], v.angular, atol=BOUND * size)
        np.testing.assert_allclose(motion.spin_rates[index], a.angular, atol=BOUND * size)
        # The acceleration of the point that moves with the frame, not of the one that passes it.
        linear = (a.linear + np.cross(v.angular, v.linear)) / tree.length
        found = motion.accelerations[index]
        np.testing.assert_allclose(found, linear, atol=10.0 * BOUND * size)

    model.gravity.linear = GRAVITY
    expected = pin.rnea(model, data, item.q, item.v, item.a)
    base = tuple(-tree.in_axes(GRAVITY) / tree.length)
    motion = moving(tree, item.at, *rates, base)
    carried = momentum_rates(tree, motion, {}).passed_on(tree, item.at)
    efforts = carried.along(tree, range(model.nv))
    size = max(float(np.abs(data.f[k].vector).max()) for k in range(1, model.njoints)) + 1e-300
    for rate, effort in efforts.items():
        assert abs(effort * tree.effort_units[rate] - expected[rate]) <= 10.0 * BOUND * size
    for index, (force, moment) in enumerate(zip(*carried, strict=True)):
        found = [*np.array(force) * tree.length, *np.array(moment) * tree.length**2]
        np.testing.assert_allclose(found, data.f[index + 1].vector, atol=10.0 * BOUND * size)


@pytest.mark.parametrize("seed", range(12))
def test_steps_are_those_of_the_model_for_small_ones(seed: int) -> None:
    """Quaternions are turned in the axes of their bodies; the rest is of third order."""
    item = state(seed)
    rng = np.random.default_rng(seed)
    for size in (1e-2, 1e-3):
        step = rng.normal(size=item.model.nv) * size * item.tree.units
        expected = pin.integrate(item.model, item.q, step)
        moved, rates = item.x.copy(), item.by_rate(step)
        for body in item.tree.bodies:
            unit = item.tree.length if body.kind == "prismatic" else 1.0
            x = {column: float(item.x[column] / unit) for column in body.columns}
            for column, value in stepped(body, x, rates).items():
                moved[column] = value * unit
        found = item.mechanism.coordinates.configuration(moved[None, :])[0]
        apart = pin.difference(item.model, expected, found) / item.tree.units
        assert np.abs(apart).max(initial=0.0) <= 3.0 * size**3


@pytest.mark.parametrize(
    "name", ["universal_joint", "four_bar", "slider_crank", "stewart_platform"]
)
def test_accelerations_are_those_of_constrained_dynamics(name: str) -> None:
    """What a tape finds that drives exert moves the chain as it was told to move."""
    from cardan_dyn.scene.usual_motion import usual_motion

    usual = usual_motion(cd.load(name), samples=24)
    model = usual.scene.mechanism.model
    scene = usual.scene.replace(gravity=model.gravity.linear.copy())
    turn = scene.sweep(usual.positions, 1.3, 0.7)
    efforts = turn.drive_effort.reshape(len(turn), -1)
    for sample in (0, 7, 19):
        exerted = dict(zip(scene.drives, efforts[sample], strict=True))
        exerted |= {joint: float(turn.holding_effort[joint][sample]) for joint in scene.held}
        for joint, load in scene.loads.items():
            exerted[joint] = exerted.get(joint, 0.0) + float(load)
        a, _, _ = forward_accelerations(scene.mechanism, turn, sample, exerted)
        np.testing.assert_allclose(a, turn.motion.a[sample], atol=1e-6 * (1.0 + np.abs(a).max()))
