"""Start search: where a scene starts, from closed, open and singular zeros."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.planar_linkages import (
    BASE,
    COUPLER,
    CRANK,
    ROCKER,
    described,
    four_bar,
    joint,
    link,
    loop,
    pin_distance,
    rocker_range,
    values,
)

import cardan_dyn as cd
from cardan_dyn.kinematics.loop_system import LoopSystem
from cardan_dyn.kinematics.start_search import StartSearch
from cardan_dyn.problem.arguments import checked

AT_ZERO = np.arctan2(BASE, ROCKER - CRANK)
"""Angle from the coupler's line of pins to the crank with B at zero."""


def search(mechanism: cd.Mechanism, **options: object) -> StartSearch:
    """The search of a scene that drives A."""
    problem = checked(mechanism, drive="A", **options)
    system = LoopSystem(mechanism, problem.held)
    groups = system.groups(problem.drives, problem.passive_columns)
    kinematics = system.kinematics(problem.drives, groups)
    return StartSearch(problem, system, kinematics, problem.passive_columns)


def open_at_zero() -> cd.Mechanism:
    """A four-bar whose rocker's pivot is 0.3 farther away than where its zero would close."""
    return described(
        *(link(name) for name in "abc"),
        joint("A", "ground", "a"),
        joint("B", "a", "b", (0.0, 0.3)),
        joint("D", "ground", "c", (1.3, 0.0)),
        loop("b", "c", (1.0, 0.5), (0.0, 0.8)),
    )


def test_a_closed_zero_is_the_start() -> None:
    mechanism = four_bar()
    start = search(mechanism).closed_start()
    np.testing.assert_array_equal(start, mechanism.coordinates.neutral())


def test_the_drive_stays_at_zero_if_the_loops_close_there() -> None:
    mechanism = open_at_zero()
    start = search(mechanism).closed_start()[None, :]
    assert values(mechanism, start, "A")[0] == 0.0
    rocker = float(values(mechanism, start, "D")[0])
    pins = np.array([1.3 - 0.8 * np.sin(rocker), 0.8 * np.cos(rocker) - 0.3])
    assert np.linalg.norm(pins) == pytest.approx(np.hypot(1.0, 0.5), abs=1e-13)


@pytest.mark.parametrize("position", [0.3, 0.6])
def test_joints_of_the_start_are_followed_to_their_positions(position: float) -> None:
    mechanism = four_bar()
    start = search(mechanism, start={"D": position}).closed_start()[None, :]
    assert values(mechanism, start, "D")[0] == position
    assert pin_distance(mechanism, start)[0] == pytest.approx(COUPLER, abs=1e-13)
    # No dead point of D was passed: crank and coupler are nowhere in line, as at zero.
    assert np.sign(np.sin(values(mechanism, start, "B")[0] - AT_ZERO)) == -np.sign(np.sin(AT_ZERO))


def test_starts_that_no_motion_leads_to_are_assembled_there() -> None:
    """The rocker on the other side of its pivot: mirrored, its range is disconnected."""
    low, high = rocker_range()
    mechanism = four_bar()
    for position in (np.pi - high + 0.01, np.pi - low - 0.01):
        start = search(mechanism, start={"D": position}).closed_start()[None, :]
        assert values(mechanism, start, "D")[0] == pytest.approx(position, abs=1e-12)
        assert pin_distance(mechanism, start)[0] == pytest.approx(COUPLER, abs=1e-12)


def test_starts_that_nothing_closes_say_how_far_the_joint_came() -> None:
    _, high = rocker_range()
    with pytest.raises(cd.AssemblyError, match=r"joint 'D' cannot be brought to 1\.5") as caught:
        search(four_bar(), start={"D": 1.5}).closed_start()
    assert caught.value.nearest == pytest.approx(high, abs=1e-6)


def test_large_angles_bring_the_question_of_degrees() -> None:
    with pytest.raises(cd.AssemblyError, match=r"if 30 degrees were meant, give 0\.523599"):
        search(four_bar(), start={"D": 30.0}).closed_start()
