"""What a drive moves by itself, and what several drives move together."""

from __future__ import annotations

from decimal import Decimal, getcontext

import numpy as np
import pytest
from testkit.planar_linkages import COUPLER, five_bar, four_bar, pin_distance, values

import cardan_dyn as cd
from cardan_dyn.kinematics.assembly import Assembly
from cardan_dyn.kinematics.closing.all_groups import Kinematics
from cardan_dyn.kinematics.closing.group_solver import GroupSolver
from cardan_dyn.kinematics.diagnosis.mobility import STATES_STUDIED
from cardan_dyn.kinematics.following.drive_motion import TURN, DriveMotion, turned_back
from cardan_dyn.kinematics.following.joint_motion import JointMotion
from cardan_dyn.problem.arguments import checked
from cardan_dyn.problem.samples import Targets


def part_of(mechanism: cd.Mechanism, *drives: str) -> tuple[DriveMotion | JointMotion, Kinematics]:
    cache = Assembly(checked(mechanism, drive=list(drives)))._cache
    (part,) = cache._parts
    return part, cache.kinematics


def test_there_are_always_enough_states_to_study() -> None:
    mechanism = four_bar()
    part, kinematics = part_of(mechanism, "A")
    assert isinstance(part, DriveMotion)
    part.followed(Targets.of_positions(np.array([[-0.4], [0.3]])), kinematics)
    few = len(part.states)
    assert few < STATES_STUDIED
    more = part.more_states()
    assert more.shape == (STATES_STUDIED, mechanism.coordinates.size)
    np.testing.assert_allclose(pin_distance(mechanism, more), COUPLER, rtol=1e-12)
    low, high = part.branch.span
    np.testing.assert_allclose(values(mechanism, more, "A"), np.linspace(low, high, len(more)))
    part.branch.cover(-30.0, 30.0)
    assert len(part.states) >= STATES_STUDIED
    assert not len(part.more_states())


def test_something_is_new_until_the_way_is_known() -> None:
    part, kinematics = part_of(four_bar(), "A")
    positions = np.array([[0.0], [0.5]])
    ways = [Targets.of_positions(size * positions) for size in (1.0, 1.0, 0.5, 6.0)]
    is_new = [part.followed(way, kinematics).is_new for way in ways]
    assert is_new == [True, False, False, True]


def test_several_drives_remember_the_states_of_the_last_way() -> None:
    mechanism = five_bar()
    part, kinematics = part_of(mechanism, "A", "D")
    assert isinstance(part, JointMotion)
    assert len(part.states) == 1
    positions = np.linspace(0.0, 0.3, 100)[:, None] * [1.0, -1.0]
    followed = part.followed(Targets.of_positions(positions), kinematics)
    assert followed.is_new
    assert np.all(followed.is_there)
    assert 20 < len(part.states) <= 100
    assert not len(part.more_states())
    with pytest.raises(cd.AssemblyError, match=r"drive positions 3, -3 \(sample 1 of 2\)"):
        part.followed(Targets.of_positions(np.array([[0.0, 0.0], [3.0, -3.0]])), kinematics)


def test_whole_turns_are_taken_off_exactly() -> None:
    """Against decimal numbers of fifty digits; a product of floats is off by 1e-10 here."""
    getcontext().prec = 50
    turn = 2 * Decimal("3.14159265358979323846264338327950288419716939937510")
    rng = np.random.default_rng(0)
    for most in (1, 100, 10_000, 1_000_000):
        for of_period in (1, 3):
            angles = rng.uniform(-TURN, TURN, 200) + TURN * rng.integers(-most, most, 200)
            periods = np.floor(angles / (of_period * TURN))
            left = turned_back(angles, periods, of_period * TURN)
            exact = [
                Decimal(float(angle)) - Decimal(float(count)) * of_period * turn
                for angle, count in zip(angles, periods, strict=True)
            ]
            np.testing.assert_allclose(left, [float(item) for item in exact], rtol=0.0, atol=4e-15)


def test_guesses_stay_near_after_many_turns(joint: cd.Mechanism) -> None:
    """One Newton step closes each."""
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.6})
    turns = np.linspace(0.0, 200.0 * TURN, 900)
    scene.sweep(turns)
    sizes: list[int] = []
    evaluate = GroupSolver.evaluate

    def counted(solver: GroupSolver, x: np.ndarray, *arguments: object) -> object:
        sizes.append(len(x))
        return evaluate(solver, x, *arguments)  # type: ignore[arg-type]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(GroupSolver, "evaluate", counted)
        scene.sweep(turns)
    assert sum(sizes) <= 2.02 * len(turns)
