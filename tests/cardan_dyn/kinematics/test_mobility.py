"""Mobility: counted by Grübler's rule for planar linkages, and told apart from dead points."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.planar_linkages import (
    BASE,
    CRANK,
    ROCKER,
    described,
    five_bar,
    four_bar,
    joint,
    link,
    rocker_range,
    solver,
)

import cardan_dyn as cd
from cardan_dyn.core.kinematics.closing.stacked import ranks
from cardan_dyn.core.kinematics.division import Division
from cardan_dyn.core.kinematics.loop_system import LoopSystem
from cardan_dyn.core.problem.arguments import checked


def division(mechanism: cd.Mechanism, *drives: str, held: tuple[str, ...] = ()) -> Division:
    problem = checked(mechanism, drive=list(drives), held=dict.fromkeys(held, 0.0))
    return Division.of_open_loops(problem, LoopSystem(mechanism, problem.held))


def check(mechanism: cd.Mechanism, *drives: str, held: tuple[str, ...] = ()) -> None:
    """Check a linkage at three positions near its zero position."""
    kinematics, start = solver(mechanism, *drives, held=held)
    columns = [mechanism.coordinates.columns[name].start for name in drives]
    guess = np.repeat(start[None, :], 3, axis=0)
    guess[:, columns] = np.linspace(0.0, 0.05, 3)[:, None]
    state = kinematics.close(guess)
    division(mechanism, *drives, held=held).independent(state.x)


def test_the_right_number_of_drives_passes() -> None:
    # Grübler: 3 (n - 1) - 2 f, with 4 links and 4 joints, with 5 links and 5 joints.
    check(four_bar(), "A")
    check(four_bar(), "D")
    check(five_bar(), "A", "D")
    check(five_bar(), "A", held=("D",))


@pytest.mark.parametrize("held", [(), ("D",)])
def test_too_many_drives(held: tuple[str, ...]) -> None:
    drives = ("A",) if held else ("A", "D")
    advice = "it is locked: stop holding D$" if held else "drop a drive .*: one of: A, D$"
    with pytest.raises(cd.MobilityError, match=advice) as caught:
        check(four_bar(), *drives, held=held)
    assert caught.value.mobility == (0 if held else 1)
    assert caught.value.free == []


def test_too_few_drives_name_what_stays_free() -> None:
    with pytest.raises(cd.MobilityError, match="its loops leave mobility 2") as caught:
        check(five_bar(), "A")
    assert caught.value.mobility == 2
    assert set(caught.value.free) == set("BCDE")


def test_joints_on_no_loop_are_named() -> None:
    swing = link("swing"), joint("S", "ground", "swing")
    mechanism = four_bar(0.3, 0.8, 1.0, *swing)
    with pytest.raises(cd.MobilityError, match="nothing decides the motion of: S;") as caught:
        check(mechanism, "A")
    assert caught.value.mobility == 2
    assert caught.value.free == ["S"]


def test_a_mechanism_without_loops_is_told_so() -> None:
    pendulum = described(link("a"), link("b"), joint("A", "ground", "a"), joint("B", "a", "b"))
    with pytest.raises(cd.MobilityError, match="it has no loop") as caught:
        check(pendulum, "A")
    assert caught.value.mobility == 2
    assert caught.value.free == ["B"]


def test_a_dead_point_is_not_taken_for_a_missing_drive() -> None:
    """With crank and coupler in line, driving the rocker decides nothing."""
    mechanism = four_bar()
    low, _ = rocker_range()
    kinematics, start = solver(mechanism, "D")
    layout = mechanism.coordinates
    reach = np.array([BASE - ROCKER * np.sin(low), ROCKER * np.cos(low)])
    crank = np.arctan2(-reach[0], reach[1])
    coupler = np.arctan2(reach[1], reach[0]) - np.arctan2(ROCKER - CRANK, BASE)
    dead = start.copy()
    for name, angle in (("A", crank), ("B", coupler - crank), ("D", low), ("C", low - coupler)):
        dead[layout.columns[name]] = angle
    state = kinematics.evaluate(dead[None, :])
    assert state.residual[0] < 1e-12
    with pytest.raises(cd.SingularConfigurationError, match="is a dead point") as caught:
        division(mechanism, "D").independent(state.x)
    assert caught.value.position == low
    assert caught.value.condition > 1e8
    # One regular position among them shows that the drive decides the motion.
    both = kinematics.evaluate(np.array([dead, start]))
    division(mechanism, "D").independent(both.x)


def test_ranks_of_known_matrices() -> None:
    full = np.diag([1.0, 2.0, 3.0])
    lower = np.diag([1.0, 2.0, 1e-12])
    single = np.outer([1.0, 2.0, 3.0], [1.0, 0.0, 1.0])
    assert ranks(np.array([full, lower, single])).tolist() == [3, 2, 1]
    assert ranks(np.zeros((4, 0, 3))).tolist() == [0] * 4
    assert ranks(np.zeros((2, 3, 0))).tolist() == [0] * 2


def test_advice_counts_what_is_missing(joint: cd.Mechanism) -> None:
    with pytest.raises(cd.MobilityError) as caught:
        cd.Scene(joint, drive="bearing_in")
    assert str(caught.value) == (
        "universal_joint: driven by bearing_in, its loops leave mobility 2: nothing decides the "
        "motion of: joint_angle, pin_out; 1 freedom is left over: links housing_out, shaft_out "
        "turn about (0, 0, 1) through (0, 0, 0); drive or hold one of: joint_angle, pin_out"
    )
    assert caught.value.advised == ["joint_angle"]
    held = {"joint_angle": 0.5, "bearing_out": 0.1}
    with pytest.raises(cd.MobilityError, match=r"with bearing_out, joint_angle held, .* is locked"):
        cd.Scene(joint, drive="bearing_in", held=held)


def test_advice_names_joints_that_can_be_driven() -> None:
    with pytest.raises(cd.MobilityError, match="drive or hold 5 of them, such as ") as caught:
        cd.Scene(cd.load("stewart_platform"), drive="leg_1")
    assert len(caught.value.advised) == 5
    assert not any(name.startswith("ball") for name in caught.value.advised)
    # Of the legs' balls, the first is written as three hinges, the others as balls.
    assert {"ball_1_x", "ball_2.x", "leg_2"} <= set(caught.value.free)
    assert set(caught.value.free) <= set(cd.load("stewart_platform").drivable)
