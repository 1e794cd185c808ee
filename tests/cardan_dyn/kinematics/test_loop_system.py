"""Loop system: loops of a mechanism for any drives, and joints brought to positions."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.design_line import design_line, nominal
from testkit.planar_linkages import (
    COUPLER,
    four_bar,
    joint,
    link,
    pin_distance,
    rocker_range,
    values,
)

import cardan_dyn as cd
from cardan_dyn.core.kinematics.following.branch import Branch
from cardan_dyn.core.kinematics.loop_system import LoopSystem


@pytest.fixture(scope="module")
def mechanism() -> cd.Mechanism:
    """A four-bar with a swing S beside it."""
    return four_bar(0.3, 0.8, 1.0, link("s"), joint("S", "ground", "s", (3.0, 0.0)))


def columns(mechanism: cd.Mechanism, *names: str) -> np.ndarray:
    return np.array([mechanism.coordinates.velocity_columns[name].start for name in names])


def test_joints_on_loops_are_known(mechanism: cd.Mechanism) -> None:
    system = LoopSystem(mechanism, {})
    assert {name: system.is_on_loops(name) for name in mechanism} == {
        **dict.fromkeys("ABDC", True),
        "S": False,
    }
    assert system.held == {}


def test_any_joint_can_drive(mechanism: cd.Mechanism) -> None:
    system = LoopSystem(mechanism, {"S": 0.5})
    for drive in "ABD":
        passives = np.setdiff1d(columns(mechanism, *"ABDC"), columns(mechanism, drive))
        groups = system.groups((drive,), passives)
        assert groups[0].loops == (0,)
        np.testing.assert_array_equal(groups[0].passives, passives)
        np.testing.assert_array_equal(groups[0].known, columns(mechanism, drive))
        kinematics = system.kinematics((drive,), groups)
        np.testing.assert_array_equal(kinematics.drives, columns(mechanism, drive))
        assert kinematics.reductions[0].rows[0].shape == (6, 6)
        x = mechanism.coordinates.neutral()[None]
        x[0, mechanism.coordinates.columns[drive].start] = 0.05
        state = kinematics.with_open_reductions(x[0]).close(x)
        np.testing.assert_allclose(pin_distance(mechanism, state.x), COUPLER, rtol=1e-13)


@pytest.mark.parametrize("value", [-2.0, 0.4, 5.0])
def test_passives_follow_a_joint_that_moves(mechanism: cd.Mechanism, value: float) -> None:
    system = LoopSystem(mechanism, {})
    start = mechanism.coordinates.neutral()
    before = start.copy()
    state = system.moved(start, "A", value, columns(mechanism, *"BDC"), set())
    np.testing.assert_array_equal(start, before)
    assert values(mechanism, state, "A") == value
    assert values(mechanism, state, "S") == 0.0
    assert pin_distance(mechanism, state[None])[0] == pytest.approx(COUPLER, rel=1e-12)
    low, high = rocker_range()
    assert low <= values(mechanism, state, "D") <= high
    back = system.moved(state, "A", 0.0, columns(mechanism, *"BDC"), set())
    np.testing.assert_allclose(back, start, atol=1e-9)


def test_joints_on_no_loop_move_alone(mechanism: cd.Mechanism) -> None:
    system = LoopSystem(mechanism, {})
    start = mechanism.coordinates.neutral()
    state = system.moved(start, "S", 7e8, columns(mechanism, *"ABDC"), set())
    assert values(mechanism, state, "S") == 7e8
    assert values(mechanism, start, "S") == 0.0
    for name in "ABDC":
        assert values(mechanism, state, name) == values(mechanism, start, name)
    assert system.moved(state, "S", 7e8, columns(mechanism, "A"), set()) is state


def test_what_need_not_follow_stays(mechanism: cd.Mechanism) -> None:
    system = LoopSystem(mechanism, {})
    start = mechanism.coordinates.neutral()
    passives = columns(mechanism, *"BDC")
    state = system.moved(start, "A", 0.4, passives, set(passives.tolist()))
    assert values(mechanism, state, "A") == 0.4
    for name in "BDC":
        assert values(mechanism, state, name) == values(mechanism, start, name)


def test_a_joint_cannot_move_out_of_reach(mechanism: cd.Mechanism) -> None:
    system = LoopSystem(mechanism, {})
    start = mechanism.coordinates.neutral()
    with pytest.raises(cd.AssemblyError) as caught:
        system.moved(start, "D", 3.0, columns(mechanism, *"ABC"), set())
    assert caught.value.nearest == pytest.approx(rocker_range()[1], abs=1e-9)


def test_branches_of_slides_count_in_lengths() -> None:
    mechanism = cd.load("slider_crank")
    system = LoopSystem(mechanism, {})
    start = mechanism.coordinates.neutral()
    for drive, unit in (("crank_bearing", 1.0), ("piston_guide", mechanism.characteristic_length)):
        all_columns = np.arange(mechanism.model.nv)
        passives = np.setdiff1d(all_columns, columns(mechanism, drive))
        kinematics = system.kinematics((drive,), system.groups((drive,), passives))
        branch = Branch(kinematics, start)
        assert branch.unit == unit
        assert branch.kinematics is kinematics
        at = start[mechanism.coordinates.columns[drive].start]
        assert branch.span == (at, at)


def test_several_joints_share_finer_groups_and_move_one_by_one() -> None:
    mechanism = cd.load(design_line(3))
    system = LoopSystem(mechanism, {})
    coordinates = mechanism.coordinates
    names = ("angle_1", "angle_3", "phase_2")
    resting = columns(mechanism, "bearing_0", *nominal(3))
    passives = np.setdiff1d(np.arange(mechanism.model.nv), resting)
    start = coordinates.neutral()
    together = system.together(start, names, passives, set())
    assert together is not None
    assert [solver.group.loops for solver in together.solvers] == [(0,), (1,), (2,)]
    for name, loops in (("angle_1", [0, 1, 2]), ("phase_2", [2]), ("angle_3", [2])):
        own = together.of_drive(coordinates.named[name].rate)
        assert [loop for solver in own.solvers for loop in solver.group.loops] == loops
        moved = system.moved(start, name, 0.3, passives, set(), together)
        alone = system.moved(start, name, 0.3, passives, set())
        np.testing.assert_allclose(moved, alone, rtol=0.0, atol=1e-12)


def test_joints_that_share_no_finer_groups_move_as_before(mechanism: cd.Mechanism) -> None:
    system = LoopSystem(mechanism, {})
    passives = columns(mechanism, *"BDC")
    assert system.together(mechanism.coordinates.neutral(), ("A", "S"), passives, set()) is None
