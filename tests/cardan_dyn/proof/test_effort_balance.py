"""Efforts along the coordinates against the virtual work of the joint wrenches."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.ball_rods import as_a_floating_rod
from testkit.kinematics import frames_of
from testkit.mixed_chain import MIXED, rows

import cardan_dyn as cd
from cardan_dyn.core.proof.effort_balance import EffortBalance
from cardan_dyn.core.proof.screws import Screw, Screws, in_world, power
from cardan_dyn.core.proof.vectors import greatest

COUNT = 4


TEXTS = {"mixed": MIXED, "floating": as_a_floating_rod()}


@pytest.fixture(scope="module", params=[*TEXTS, "stewart_platform", "slider_crank"])
def mechanism(request: pytest.FixtureRequest) -> cd.Mechanism:
    return cd.load(TEXTS.get(request.param, request.param))


class Claimed:
    """Random wrenches of some joints, and their work per unit of each rate."""

    def __init__(self, mechanism: cd.Mechanism, joints: list[int] | None = None) -> None:
        self.screws = screws = Screws(frames_of(mechanism))
        self.joints = list(range(len(screws.frames.joints))) if joints is None else joints
        self.placed = screws.placing.placed(list(rows(mechanism, COUNT).T))
        forces = np.random.default_rng(7).normal(size=(len(self.joints), 2, 3, COUNT))
        self.wrenches: list[Screw] = [(tuple(force), tuple(moment)) for force, moment in forces]
        frames = screws.placing.joint_frames(self.placed)
        self.in_world = [
            in_world(wrench, frames[joint])
            for joint, wrench in zip(self.joints, self.wrenches, strict=True)
        ]
        self.efforts = np.zeros((mechanism.model.nv, COUNT))
        for row, unit in enumerate(screws.units(self.placed)):
            joint = screws.frames.motions[screws.owners[row]].joint
            if joint in self.joints:
                wrench = self.in_world[self.joints.index(joint)]
                self.efforts[screws.rates[row]] = power(wrench, unit)

    def imbalance(self, given: np.ndarray, scale: np.ndarray | None = None) -> np.ndarray:
        scales = [1.0] * len(given) if scale is None else scale.tolist()
        balance = EffortBalance(self.screws, self.joints, scales)
        found = balance.imbalances(self.placed, self.wrenches, self.in_world, list(given))
        return np.broadcast_to(greatest(found), COUNT)


def test_what_wrenches_do_along_the_rates_is_in_balance(mechanism: cd.Mechanism) -> None:
    claimed = Claimed(mechanism)
    assert np.max(np.abs(claimed.efforts)) > 1.0
    assert np.max(claimed.imbalance(claimed.efforts)) < 1e-12


def test_what_is_not_given_is_the_imbalance(mechanism: cd.Mechanism) -> None:
    """Of every rate, at one sample, and multiplied with the scale of the rate."""
    claimed, nv = Claimed(mechanism), mechanism.model.nv
    scale = 1.0 + np.arange(nv)
    for rate in range(nv):
        given = claimed.efforts.copy()
        given[rate, 2] += 0.5
        expected = np.zeros(COUNT)
        expected[2] = 0.5 * scale[rate]
        np.testing.assert_allclose(claimed.imbalance(given, scale), expected, atol=1e-11 * nv)


def test_rates_of_joints_without_a_claimed_wrench_do_not_count(mechanism: cd.Mechanism) -> None:
    every = len(frames_of(mechanism).joints)
    claimed = Claimed(mechanism, list(range(0, every, 2))[::-1])
    screws = claimed.screws
    for row, rate in enumerate(screws.rates):
        changed = claimed.efforts.copy()
        changed[rate] += 3.0
        counts = screws.frames.motions[screws.owners[row]].joint in claimed.joints
        expected = 3.0 if counts else 0.0
        np.testing.assert_allclose(claimed.imbalance(changed), expected, atol=1e-12)


def test_no_claimed_wrench_is_in_balance(mechanism: cd.Mechanism) -> None:
    claimed = Claimed(mechanism, [])
    given = np.ones((mechanism.model.nv, COUNT))
    np.testing.assert_array_equal(claimed.imbalance(given), np.zeros(COUNT))
