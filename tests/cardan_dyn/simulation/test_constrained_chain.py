"""A constrained chain alone, beside a mechanism that has another one."""

from __future__ import annotations

import copy

import numpy as np
import pytest
from testkit.linkages import four_bar, loop
from testkit.many import in_one

import cardan_dyn as cd
from cardan_dyn.simulation.chains import chains_of
from cardan_dyn.simulation.constrained_chain import ConstrainedChain

GRAVITY = np.array([0.3, -9.81, 0.2])


@pytest.fixture(scope="module")
def second() -> ConstrainedChain:
    """The second chain of five four-bars, a single one, whose crank is told how to move."""
    mechanism = cd.load(in_one(four_bar(loop("continuous")), 5))
    chain = chains_of(mechanism)[1]
    drive = mechanism.coordinates.named["a_4"].rate
    state = mechanism.coordinates.neutral()
    return ConstrainedChain(mechanism, chain, [0, drive], GRAVITY, state)


def test_it_knows_its_own_coordinates_alone(second: ConstrainedChain) -> None:
    assert second.model.nv == 4
    assert second.prescribed.tolist() == [0]


def test_it_closes_and_moves_as_it_is_told(second: ConstrainedChain) -> None:
    drifted, v = np.array([1e-5, -2e-5, 3e-5, 1e-5]), np.array([1.0, 0.2, 0.3, -0.4])
    closed, rates = second.closed(drifted, v)
    assert second.closure_error(drifted) > 1e-6
    assert second.closure_error(closed) < 2e-15
    assert (closed[0], rates[0]) == pytest.approx((1e-5, 1.0), abs=1e-15)
    a = second.accelerations(closed, rates, None, np.array([2.5]))
    assert a[0] == pytest.approx(2.5, abs=1e-13)
    # Accelerations differentiate the speeds that close the loops, along the motion.
    step = 1e-5
    after, speeds = second.closed(closed + step * rates + 0.5 * step**2 * a, rates + step * a)
    assert second.closure_error(after) < 2e-15
    assert np.max(np.abs(speeds - rates - step * a)) < 10.0 * step**2


def test_copies_answer_alike(second: ConstrainedChain) -> None:
    x, v = second.closed(np.zeros(4), np.array([1.0, 0.0, 0.0, 0.0]))
    other = copy.deepcopy(second)
    np.testing.assert_array_equal(other.accelerations(x, v), second.accelerations(x, v))
