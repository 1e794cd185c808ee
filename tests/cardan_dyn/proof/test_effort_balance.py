"""Efforts along the coordinates against the virtual work of the joint wrenches."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.kinematics import frames_of
from testkit.mixed_chain import MIXED, rows

import cardan_dyn as cd
from cardan_dyn.proof.effort_balance import EffortBalance
from cardan_dyn.proof.twists import State, Twists
from cardan_dyn.proof.wrenches import JointWrenches, placed_in_world

COUNT = 4


@pytest.fixture(scope="module", params=["mixed", "stewart_platform", "slider_crank"])
def mechanism(request: pytest.FixtureRequest) -> cd.Mechanism:
    return cd.load(MIXED if request.param == "mixed" else request.param)


def random_wrenches(twists: Twists, state: State, joints: list[int]) -> JointWrenches:
    forces = np.random.default_rng(7).normal(size=(len(joints), 2, 3, COUNT))
    return placed_in_world(forces, state.joint_frames[joints])


def efforts(twists: Twists, state: State, joints: list[int], wrenches: JointWrenches) -> np.ndarray:
    """Return the work `(nv, N)` of joint wrenches per unit of each rate."""
    result = np.zeros((len(twists.rates), COUNT))
    for row, rate in enumerate(twists.rates):
        joint = twists.frames.motions[twists.owners[row]].joint
        if joint in joints:
            wrench = wrenches.in_world[joints.index(joint)]
            linear, angular = state.unit_twists[row]
            result[rate] = np.sum(linear * wrench[0] + angular * wrench[1], axis=0)
    return result


def test_what_wrenches_do_along_the_rates_is_in_balance(mechanism: cd.Mechanism) -> None:
    twists = Twists(frames_of(mechanism))
    state = twists.state(rows(mechanism, COUNT))
    joints = list(range(len(twists.frames.joints)))
    wrenches = random_wrenches(twists, state, joints)
    balance = EffortBalance(twists, joints, np.ones(mechanism.model.nv))
    given = efforts(twists, state, joints, wrenches)
    assert np.max(np.abs(given)) > 1.0
    assert np.max(balance.imbalance(state, wrenches, given)) < 1e-12


def test_what_is_not_given_is_the_imbalance(mechanism: cd.Mechanism) -> None:
    """Of every rate, at one sample, and multiplied with the scale of the rate."""
    twists, nv = Twists(frames_of(mechanism)), mechanism.model.nv
    state = twists.state(rows(mechanism, COUNT))
    joints = list(range(len(twists.frames.joints)))
    wrenches = random_wrenches(twists, state, joints)
    scale = 1.0 + np.arange(nv)
    balance = EffortBalance(twists, joints, scale)
    exact = efforts(twists, state, joints, wrenches)
    for rate in range(nv):
        given = exact.copy()
        given[rate, 2] += 0.5
        expected = np.zeros(COUNT)
        expected[2] = 0.5 * scale[rate]
        np.testing.assert_allclose(
            balance.imbalance(state, wrenches, given), expected, atol=1e-11 * nv
        )


def test_rates_of_joints_without_a_claimed_wrench_do_not_count(mechanism: cd.Mechanism) -> None:
    twists = Twists(frames_of(mechanism))
    state = twists.state(rows(mechanism, COUNT))
    joints = list(range(0, len(twists.frames.joints), 2))
    wrenches = random_wrenches(twists, state, joints)
    balance = EffortBalance(twists, joints, np.ones(mechanism.model.nv))
    given = efforts(twists, state, joints, wrenches)
    for row, rate in enumerate(twists.rates):
        changed = given.copy()
        changed[rate] += 3.0
        counts = twists.frames.motions[twists.owners[row]].joint in joints
        worst = balance.imbalance(state, wrenches, changed)
        np.testing.assert_allclose(worst, 3.0 if counts else 0.0, atol=1e-12)


def test_no_claimed_wrench_is_in_balance(mechanism: cd.Mechanism) -> None:
    twists = Twists(frames_of(mechanism))
    state = twists.state(rows(mechanism, COUNT))
    wrenches = random_wrenches(twists, state, [])
    balance = EffortBalance(twists, [], np.ones(mechanism.model.nv))
    given = np.ones((mechanism.model.nv, COUNT))
    np.testing.assert_array_equal(balance.imbalance(state, wrenches, given), np.zeros(COUNT))
