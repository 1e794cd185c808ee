"""Kinematics of all groups: rates and accelerations against differences of closed positions."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.drive_lines import drive_line
from testkit.many_drives import cranks, stacked
from testkit.planar_linkages import five_bar, four_bar, solver, values

import cardan_dyn as cd
from cardan_dyn.core.kinematics.assembly import Assembly
from cardan_dyn.core.kinematics.closing.all_groups import ClosedState, Kinematics
from cardan_dyn.core.problem.arguments import checked
from cardan_dyn.core.problem.samples import Targets

STEP = 1e-4
SCENES: dict[str, dict[str, object]] = {
    "four_bar": {"drive": "crank_bearing"},
    "slider_crank": {"drive": "crank_bearing"},
    "universal_joint": {"drive": "bearing_in", "held": {"joint_angle": 0.7}},
    "double_shaft_z": {
        "drive": "bearing_in",
        "held": {"joint_angle_1": 0.5, "joint_angle_2": 0.3},
    },
    "needle_drive": {"drive": "main_shaft"},
    "stewart_platform": {"drive": [f"leg_{leg}" for leg in range(1, 7)]},
}


class Motion:
    """Drive positions with constant accelerations, and the closed states along it."""

    def __init__(self, name: str) -> None:
        self.mechanism = cd.load(name)
        self.problem = checked(self.mechanism, **SCENES[name])
        self.assembly = Assembly(self.problem)
        layout = self.mechanism.coordinates
        self.columns = [layout.columns[drive].start for drive in self.problem.drives]
        count = len(self.columns)
        size = 0.1 if count > 1 else 1.0
        self.start = self.assembly.start[self.columns] + 0.3 * size
        self.rates = size * np.linspace(2.0, -1.0, count)
        self.accelerations = size * np.linspace(-1.5, 3.0, count)

    def at(self, time: float) -> tuple[Kinematics, ClosedState, np.ndarray]:
        """Kinematics, the closed state at a time, and the joint rates there."""
        position = self.start + time * self.rates + 0.5 * time**2 * self.accelerations
        guess = self.assembly.guesses(Targets.of_positions(position[None]))
        state = self.assembly.close(guess, position[None])
        kinematics = self.assembly.kinematics
        v = kinematics.rates(state, (self.rates + time * self.accelerations)[None])
        return kinematics, state, v


@pytest.fixture(scope="module", params=SCENES)
def motion(request: pytest.FixtureRequest) -> Motion:
    return Motion(request.param)


def test_rates_are_differences_of_closed_positions(motion: Motion) -> None:
    _, state, v = motion.at(0.0)
    (_, later, _), (_, earlier, _) = motion.at(STEP), motion.at(-STEP)
    slope = (later.x - earlier.x) / (2.0 * STEP)
    computed = motion.mechanism.coordinates.derivative(state.x, v)
    np.testing.assert_allclose(computed, slope, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(slope[0, motion.columns], motion.rates, rtol=1e-9)


def test_accelerations_are_differences_of_rates(motion: Motion) -> None:
    kinematics, state, v = motion.at(0.0)
    (_, _, later), (_, _, earlier) = motion.at(STEP), motion.at(-STEP)
    slope = (later - earlier) / (2.0 * STEP)
    computed = kinematics.accelerations(state, v, motion.accelerations[None])
    np.testing.assert_allclose(computed, slope, rtol=1e-5, atol=1e-6 * np.max(np.abs(slope)))


def test_held_joints_rest(motion: Motion) -> None:
    kinematics, state, v = motion.at(0.0)
    a = kinematics.accelerations(state, v, motion.accelerations[None])
    velocities = motion.mechanism.coordinates.velocity_columns
    for name in motion.problem.held:
        assert not np.any(v[:, velocities[name]])
        assert not np.any(a[:, velocities[name]])


def test_rates_and_accelerations_are_linear_in_the_drives(motion: Motion) -> None:
    kinematics, state, v = motion.at(0.0)
    np.testing.assert_allclose(
        kinematics.rates(state, 3.0 * motion.rates[None]), 3.0 * v, rtol=1e-13, atol=1e-14
    )
    resting = kinematics.accelerations(state, 0.0 * v, motion.rates[None])
    np.testing.assert_allclose(resting, v, rtol=1e-12, atol=1e-14)
    drift = kinematics.accelerations(state, v, 0.0 * motion.accelerations[None])
    doubled = kinematics.accelerations(state, 2.0 * v, 0.0 * motion.accelerations[None])
    scale = np.max(np.abs(drift))
    np.testing.assert_allclose(doubled, 4.0 * drift, atol=1e-12 * max(scale, 1.0))


def test_guesses_stay_as_they_are() -> None:
    mechanism = four_bar()
    kinematics, start = solver(mechanism, "A")
    x = np.repeat(start[None], 2, axis=0)
    x[:, mechanism.coordinates.columns["A"].start] = [0.1, -0.2]
    guess = x.copy()
    closed = kinematics.close(x)
    evaluated = kinematics.evaluate(x)
    np.testing.assert_array_equal(x, guess)
    assert evaluated.x is x
    assert np.max(closed.residual) < 1e-14
    single = kinematics.close(x, most=1)
    assert 0.0 < np.max(single.residual) < np.min(evaluated.residual)


def test_quaternions_of_guesses_get_unit_length() -> None:
    mechanism = cd.load("stewart_platform")
    kinematics, start = solver(mechanism, *(f"leg_{leg}" for leg in range(1, 7)))
    scaled = start.copy()
    scaled[mechanism.coordinates.columns["ball_4"]] *= 1.7
    np.testing.assert_allclose(kinematics.close(scaled[None]).x[0], start, atol=1e-9)


def test_the_worst_group_counts() -> None:
    mechanism = cd.load("needle_drive")
    problem = checked(mechanism, **SCENES["needle_drive"])
    kinematics = Assembly(problem).kinematics
    assert len(kinematics.solvers) > 1
    x = np.repeat(Assembly(problem).start[None], 40, axis=0)
    x += np.random.default_rng(2).uniform(-0.1, 0.1, x.shape)
    state = kinematics.evaluate(x)
    for name, least in (("residual", 0.0), ("condition", 1.0), ("correction", 0.0)):
        each = np.array([getattr(group, name) for group in state.groups])
        np.testing.assert_array_equal(getattr(state, name), np.maximum(least, each.max(axis=0)))
    assert len(set(np.argmax([group.residual for group in state.groups], axis=0).tolist())) > 1
    assert all(a is b.inverse for a, b in zip(state.inverses, state.groups, strict=True))


def test_a_mechanism_without_loops_is_closed_and_well_conditioned() -> None:
    mechanism = cd.load(
        '<robot name="arm"><link name="ground"/><link name="arm"/><joint name="a" '
        'type="continuous"><parent link="ground"/><child link="arm"/><axis xyz="0 0 1"/></joint>'
        "</robot>"
    )
    kinematics, start = solver(mechanism, "a")
    state = kinematics.close(start[None])
    assert (state.residual[0], state.condition[0], state.correction[0]) == (0.0, 1.0, 0.0)
    v = kinematics.rates(state, np.array([[3.0]]))
    assert v.tolist() == [[3.0]]
    assert kinematics.accelerations(state, v, np.array([[-2.0]])).tolist() == [[-2.0]]


def test_reductions_make_new_kinematics() -> None:
    mechanism = four_bar()
    all_rows, start = solver(mechanism, "A")
    all_rows = Kinematics(mechanism.coordinates, all_rows.drives, all_rows.solvers)
    assert all_rows.evaluate(start[None]).groups[0].passive_rows.shape == (1, 3, 6)
    planar = all_rows.with_open_reductions(start)
    assert planar.evaluate(start[None]).groups[0].passive_rows.shape == (1, 3, 3)
    again = all_rows.with_reductions(planar.reductions)
    assert again.reductions is planar.reductions
    assert all_rows.reductions is not planar.reductions


def test_drives_that_meet_in_a_group_are_one_part() -> None:
    kinematics, _ = solver(five_bar(), "A", "D")
    assert kinematics.independent_parts() == [([0, 1], [0])]
    assert kinematics.depends.tolist() == [
        [True, False],
        [True, True],
        [True, True],
        [False, True],
        [True, True],
    ]
    mechanism = stacked(3)
    kinematics, _ = solver(mechanism, *cranks(mechanism))
    parts = kinematics.independent_parts()
    assert [drives for drives, _ in parts] == [[0], [1], [2]]
    for (drive,), groups in parts:
        own = kinematics.part([drive], groups)
        assert own.drives.tolist() == [kinematics.drives[drive]]
        names = {f"{joint}_{drive}" for joint in ("crank", "middle", "rocker", "end")}
        spans = mechanism.coordinates.velocity_columns
        assert sorted(own.moved.tolist()) == sorted(spans[name].start for name in names)
    only, _ = solver(four_bar(), "A")
    assert only.depends is None
    assert only.independent_parts() == [([0], [0])]


def test_two_drives_close_a_five_bar_anywhere() -> None:
    mechanism = five_bar()
    kinematics, start = solver(mechanism, "A", "D")
    x = np.repeat(start[None], 5, axis=0)
    x[:, mechanism.coordinates.columns["A"].start] = np.linspace(-0.3, 0.3, 5)
    x[:, mechanism.coordinates.columns["D"].start] = np.linspace(0.2, -0.1, 5)
    state = kinematics.close(x)
    assert np.max(state.residual) < 1e-14
    a, b, d, e = (values(mechanism, state.x, name) for name in "ABDE")

    def tip(crank: np.ndarray, arm: np.ndarray, pivot: float, reach: float) -> np.ndarray:
        """Tip of an arm (reach, 0.6) on a crank of length 0.4 that stands at (pivot, 0)."""
        both = crank + arm
        along = pivot - 0.4 * np.sin(crank) + reach * np.cos(both) - 0.6 * np.sin(both)
        return np.stack([along, 0.4 * np.cos(crank) + reach * np.sin(both) + 0.6 * np.cos(both)])

    np.testing.assert_allclose(tip(a, b, 0.0, 0.5), tip(d, e, 1.0, -0.5), atol=1e-14)


def test_sides_of_singular_configurations_are_told_apart_by_any_group() -> None:
    kinematics, start = solver(four_bar(), "D")
    state = kinematics.evaluate(np.array([start, start]))
    inverse = state.inverses[0].copy()
    inverse[1, 0] *= -1.0  # The determinant of the second one changes its sign.
    assert kinematics.same_side(state, [inverse]).tolist() == [True, False]
    twice = ClosedState(state.x, state.groups * 2, *state[2:])
    both = [state.inverses[0], inverse]
    assert kinematics.same_side(twice, both).tolist() == [True, False]
    assert kinematics.same_side(twice, both[::-1]).tolist() == [True, False]


def test_the_part_of_a_single_drive_has_the_groups_that_it_moves() -> None:
    mechanism = cd.load(drive_line(3))
    assembly = Assembly(checked(mechanism, drive="bearing_0"))
    alone = assembly.kinematics
    whole = alone.of_drive(int(alone.drives[0]))
    assert [item.group.loops for item in whole.solvers] == [(0,), (1,), (2,)]
    both = Assembly(checked(stacked(2), drive=["crank_0", "crank_1"])).kinematics
    for rate in both.drives.tolist():
        part = both.of_drive(rate)
        assert part.drives.tolist() == [rate]
        (item,) = part.solvers
        assert item.group.known.tolist() == [rate]
