"""Redundancy: independent rows of closed linkages, and what is no motion at all."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from testkit.planar_linkages import (
    BASE,
    CRANK,
    ROCKER,
    five_bar,
    four_bar,
    joint,
    link,
    rocker_range,
)

import cardan_dyn as cd
from cardan_dyn.core.kinematics.closing.all_groups import Kinematics
from cardan_dyn.core.kinematics.division import Division
from cardan_dyn.core.kinematics.following.branch import Branch
from cardan_dyn.core.kinematics.loop_system import LoopSystem
from cardan_dyn.core.problem.arguments import checked


class Subject(NamedTuple):
    """The division of a mechanism, what it solves, and the zero position."""

    mechanism: cd.Mechanism
    study: Division
    kinematics: Kinematics
    start: np.ndarray

    def branch(self, low: float, high: float) -> Branch:
        branch = Branch(self.kinematics, self.start)
        branch.cover(low, high)
        return branch


def subject(
    mechanism: cd.Mechanism, drives: list[str], outputs: list[str] | None = None
) -> Subject:
    problem = checked(mechanism, drive=drives, outputs=outputs)
    start = mechanism.coordinates.neutral()
    open_loops = Division.of_open_loops(problem, LoopSystem(mechanism, dict(problem.held)))
    kinematics = open_loops.kinematics.with_open_reductions(start)
    return Subject(mechanism, replace(open_loops, kinematics=kinematics), kinematics, start)


def parallelogram() -> cd.Mechanism:
    """At A = ±90° all links are in line."""
    return four_bar(1.0, 1.0, 2.0)


def in_line(mechanism: cd.Mechanism, side: float) -> np.ndarray:
    """Closed coordinates of the parallelogram with all links in line."""
    x = mechanism.coordinates.neutral()
    for name, sign in (("A", 1.0), ("B", -1.0), ("D", 1.0), ("C", 1.0)):
        x[mechanism.coordinates.columns[name]] = 0.5 * np.pi * sign * side
    return x


def test_a_regular_state_settles_a_linkage_without_redundant_rows() -> None:
    item = subject(four_bar(), ["A"])
    assert item.study.independent(item.start[None]) is item.kinematics
    # A dead point among the states does no harm.
    flat = subject(parallelogram(), ["A"])
    states = np.array([in_line(flat.mechanism, 1.0), flat.start])
    assert flat.study.independent(states) is flat.kinematics


def test_a_single_dead_point_is_refused() -> None:
    """The rocker drives, at the end of its range, where crank and coupler are in line."""
    mechanism = four_bar()
    item = subject(mechanism, ["D"])
    low, _ = rocker_range()
    reach = np.array([BASE - ROCKER * np.sin(low), ROCKER * np.cos(low)])
    crank = np.arctan2(-reach[0], reach[1])
    coupler = np.arctan2(reach[1], reach[0]) - np.arctan2(ROCKER - CRANK, BASE)
    dead = item.start.copy()
    for name, angle in (("A", crank), ("B", coupler - crank), ("D", low), ("C", low - coupler)):
        dead[mechanism.coordinates.columns[name]] = angle
    with pytest.raises(cd.SingularConfigurationError, match="is a dead point") as caught:
        item.study.independent(dead[None])
    assert caught.value.position == low


def test_a_single_position_where_modes_meet_is_singular() -> None:
    """There the loop leaves two freedoms, everywhere else one: no drive is missing."""
    item = subject(parallelogram(), ["A"])
    with pytest.raises(cd.SingularConfigurationError, match="modes meet, and B, C, D can"):
        item.study.independent(in_line(item.mechanism, 1.0)[None])


def test_two_dead_points_are_studied_with_positions_between_them() -> None:
    """Both ends of the parallelogram's motion together show only two of its three rows."""
    item = subject(parallelogram(), ["A"])
    ends = np.array([in_line(item.mechanism, side) for side in (1.0, -1.0)])
    reachable = item.kinematics.evaluate(ends).groups[0].reachable
    assert reachable.rows[0].shape == (6, 2)
    branch = item.branch(-1.5, 1.5)
    between = branch.guess(np.linspace(-1.4, 1.4, 32))
    known = item.study.independent(np.concatenate([ends, between]))
    assert known.reductions[0].rows[0].shape == (6, 3)


def three_rockers(*more: str) -> cd.Mechanism:
    """A parallelogram with a third rocker, whose loop adds an equation too many."""
    return four_bar(
        1.0,
        1.0,
        2.0,
        link("e"),
        joint("E", "ground", "e", (1.0, 0.0)),
        '<loop name="F" type="continuous"><predecessor link="b"><origin xyz="1 0 0"/>'
        '</predecessor><successor link="e"><origin xyz="0 1 0"/></successor>'
        '<axis xyz="0 0 1"/></loop>',
        *more,
    )


def test_surplus_equations_are_never_settled() -> None:
    item = subject(three_rockers(), ["A"])
    known = item.study.independent(item.start[None])
    assert known is not item.kinematics
    state = known.evaluate(item.start[None])
    assert state.groups[0].passive_rows.shape[1:] == (5, 6)
    few = known.reductions
    # Another position shows the same rows.
    branch = item.branch(-0.5, 0.5)
    again = item.study.independent(branch.states(0.5))
    for first, second in zip(few, again.reductions, strict=True):
        for rows, others in zip(first.rows, second.rows, strict=True):
            np.testing.assert_array_equal(rows, others)


def test_too_few_drives_are_refused() -> None:
    item = subject(five_bar(), ["A"])
    with pytest.raises(cd.MobilityError, match="leave mobility 2") as caught:
        item.study.independent(item.start[None])
    assert caught.value.mobility == 2


def test_too_many_drives_are_refused() -> None:
    item = subject(four_bar(), ["A", "D"])
    with pytest.raises(cd.MobilityError, match="drop a drive") as caught:
        item.study.independent(item.start[None])
    assert caught.value.mobility == 1


def test_joints_on_no_loop_have_to_be_driven_whatever_is_wanted() -> None:
    swing = link("s"), joint("S", "ground", "s", (3.0, 0.0))
    item = subject(four_bar(CRANK, ROCKER, BASE, *swing), ["A"], outputs=["B"])
    with pytest.raises(cd.MobilityError, match="nothing decides the motion of: S"):
        item.study.independent(item.start[None])


def test_groups_that_no_output_needs_may_stay_undecided() -> None:
    """Beside the four-bar stands a five-bar that nothing drives."""
    beside = (
        *(link(name) for name in "pqrs"),
        joint("P", "ground", "p", (5.0, 0.0)),
        joint("Q", "p", "q", (0.0, 0.4)),
        joint("R", "ground", "r", (6.0, 0.0)),
        joint("S", "r", "s", (0.0, 0.4)),
        '<loop name="T" type="continuous"><predecessor link="q"><origin xyz="0.5 0.6 0"/>'
        '</predecessor><successor link="s"><origin xyz="-0.5 0.6 0"/></successor>'
        '<axis xyz="0 0 1"/></loop>',
    )
    mechanism = four_bar(CRANK, ROCKER, BASE, *beside)
    wrenches = subject(mechanism, ["A"], outputs=["D"])
    assert len(wrenches.kinematics.solvers) == 1
    assert wrenches.study.independent(wrenches.start[None]) is wrenches.kinematics
    # The same where the rows have to be studied.
    redundant = subject(three_rockers(*beside), ["A"], outputs=["D"])
    assert redundant.study.independent(redundant.start[None]) is not redundant.kinematics
    everything = subject(mechanism, ["A"])
    with pytest.raises(cd.MobilityError, match="leave mobility 3"):
        everything.study.independent(everything.start[None])
