"""Phasing against exhaustive search, the textbook, and the mechanism."""

import itertools
import math

import numpy as np
import pytest
from testkit.exhaustive import least_residual, slopes_line
from testkit.line_data import double_shaft, random_line

from cardan_dyn import ArgumentError, ModelError
from cardan_dyn.analytic import drive_line
from cardan_dyn.drive_lines import DriveLine, Shaft, arrangements
from cardan_dyn.practice.drive_lines.design.phasing import with_forks


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(40))
def test_no_exhaustive_search_is_better(seed: int) -> None:
    rng = np.random.default_rng(seed)
    line = slopes_line(2 + seed % 4, rng)
    found, searched = line.phasing(), least_residual(line)
    assert found.proven
    assert math.cos(found.value) >= math.cos(searched) - 1e-15
    assert found.value == pytest.approx(searched, abs=2e-4)
    assert found.value <= found.given_value
    again = drive_line.residual_angle(found.line.joint_angles, found.line.fork_phases)
    # β_E² is known to rounding, so that one of zero may be some 1e-8.
    assert again == pytest.approx(found.value, rel=1e-12, abs=1e-7)


@pytest.mark.parametrize("beta", [0.05, 0.3, 1.0])
def test_z_and_w_have_the_forks_of_the_textbook(beta: float) -> None:
    for make in (arrangements.z_arrangement, arrangements.w_arrangement):
        found = with_forks(make(beta, 1.0), np.array([0.7])).phasing()
        assert found.fork_offsets == pytest.approx([0.0], abs=1e-15)
        assert found.value == 0.0
        assert math.cos(found.line.fork_phases[1] - found.line.fork_phases[0]) == pytest.approx(
            0.0, abs=1e-15
        )


@pytest.mark.parametrize(
    "slopes", [(0, 5, 10, 15), (0, 12, 4, 15, 2), (3, 9, -4, 6, 6, 12), (0, 20, 10, 0, 8)]
)
def test_planar_lines_are_exact_products(slopes: tuple[int, ...]) -> None:
    # Forks of 0 and 90° in all combinations: cos β_E is a product of cos β_k and their inverses.
    shafts = [Shaft(length=1.0, slope_side=math.radians(s)) for s in slopes]
    line = DriveLine(shafts=shafts)
    cosines = np.cos(line.joint_angles)
    products = [
        abs(sum(sign * math.log(c) for sign, c in zip((1, *signs), cosines, strict=True)))
        for signs in itertools.product((1, -1), repeat=len(cosines) - 1)
    ]
    found = line.phasing(teeth=4)
    assert math.cos(found.value) == pytest.approx(math.exp(-min(products)), abs=1e-14)
    assert set(np.degrees(np.abs(found.fork_offsets)).round(9)) <= {0.0, 90.0}
    assert found.proven
    assert line.phasing().value <= found.value + 1e-7


def test_a_residual_that_cannot_vanish() -> None:
    line = DriveLine(
        shafts=[
            Shaft(length=1.0, slope_side=a, slope_plan=b)
            for a, b in ((0.0, 0.0), (0.4, 0.1), (0.5, 0.1), (0.5, 0.2))
        ]
    )
    found = line.phasing()
    cosines = np.sort(np.cos(line.joint_angles))
    assert math.cos(found.value) == pytest.approx(cosines[0] / np.prod(cosines[1:]), rel=1e-14)
    assert found.value > 0.3
    assert found.value == pytest.approx(found.bound, rel=1e-12)


@pytest.mark.parametrize(
    ("bends", "degrees"),
    [
        ((6, 10, 12), 0.037033221952),
        ((20, 25, 15), 0.043132871372),
        ((5, 12, 4), 0.453869997385),
    ],
)
def test_what_stays_of_three_joints_that_cannot_run_evenly(
    bends: tuple[int, ...], degrees: float
) -> None:
    """arcsin tanh(d/2), where d = -ln cos of the greatest angle is left over by the others'."""
    slopes = np.radians(np.cumsum([0, *bends]))
    found = DriveLine(shafts=[Shaft(length=1.0, slope_side=slope) for slope in slopes]).phasing()
    assert math.degrees(found.angle_error) == pytest.approx(degrees, abs=1e-11)


def test_the_mechanism_turns_evenly() -> None:
    line = random_line(3, seed=5)
    found = line.phasing()
    turn = np.linspace(0, np.pi, 181)
    ratio = found.line.analyse(speed=0.0, torque=1.0, positions=turn).ratio[:, -1]
    expected = 1.0 / math.cos(found.value) - math.cos(found.value)
    assert np.ptp(ratio) == pytest.approx(expected, abs=1e-3 * expected + 1e-9)
    assert found.angle_error == pytest.approx(math.asin(math.tan(found.value / 2) ** 2))


def test_alternatives_are_as_good() -> None:
    line = slopes_line(3, np.random.default_rng(12))
    found = line.phasing()
    assert found.value == pytest.approx(0.0, abs=1e-6)
    assert len(found.alternatives) == 1
    other = with_forks(line, found.alternatives[0].fork_offsets)
    assert drive_line.residual_angle(other.joint_angles, other.fork_phases) < 1e-6
    assert np.abs(other.fork_offsets - found.fork_offsets).max() > 0.1


def test_chosen_shafts() -> None:
    line = slopes_line(4, np.random.default_rng(3))
    output, both = line.phasing(), line.phasing(shafts=["shaft_2", "output"])
    assert both.proven
    assert both.value == pytest.approx(both.residual_angles[[1, 3]].max())
    assert output.residual_angles[[1, 3]].max() >= both.value - 1e-9
    assert both.residual_angles[3] >= output.value - 1e-9


def test_teeth_are_steps_from_the_given_forks() -> None:
    line = slopes_line(3, np.random.default_rng(2))
    found = line.phasing(teeth={"shaft_1": 16, 2: 18})
    steps = (found.fork_offsets - line.fork_offsets) / (2 * np.pi / np.array([16, 18]))
    halves = steps[:, None] + np.arange(2) * np.array([[8], [9]])
    assert np.abs(halves - np.rint(halves)).min(axis=1) == pytest.approx([0, 0], abs=1e-12)
    assert found.proven
    assert found.value >= line.phasing().value
    assert [item.value for item in found.alternatives] == sorted(
        item.value for item in found.alternatives
    )


def test_forks_that_cannot_be_bettered_stay() -> None:
    straight = DriveLine(shafts=[Shaft(length=1.0, fork_offset=k * 0.2) for k in (0, 1, 2, 0)])
    assert straight.phasing().fork_offsets == pytest.approx([0.2, 0.4])
    best = slopes_line(3, np.random.default_rng(12)).phasing()
    again = best.line.phasing()
    assert again.fork_offsets == pytest.approx(best.fork_offsets, abs=1e-15)
    assert len(again.alternatives) == len(best.alternatives) == 1


def test_fixed_forks_stay() -> None:
    line = slopes_line(3, np.random.default_rng(4))
    found = line.phasing(fixed=["shaft_1"])
    assert math.tan(found.fork_offsets[0]) == pytest.approx(math.tan(line.fork_offsets[0]))
    assert line.phasing().value <= found.value <= found.given_value
    still = line.phasing(fixed=[1, 2])
    assert still.value == pytest.approx(still.given_value)


@pytest.mark.slow
@pytest.mark.parametrize("count", [2, 3, 4])
def test_bearing_forces_against_a_grid(count: int) -> None:
    line = random_line(count, seed=10 + count)
    found = line.phasing("bearing_force", torque=80.0)
    assert not found.proven
    turn = np.linspace(0, np.pi, 181)
    total = found.line.analyse(speed=0.0, torque=80.0, positions=turn).total
    assert found.value == pytest.approx(total.bearing_radial.max(), rel=2e-4)
    steps = {2: 360, 3: 40, 4: 14}[count]
    stepped = line.phasing("bearing_force", torque=80.0, teeth=steps)
    assert found.value <= stepped.value * (1 + 1e-4)
    assert found.value <= found.given_value


@pytest.mark.slow
def test_a_z_arrangement_has_the_least_forces_by_its_closed_form() -> None:
    # In Z with equal angles forks in line leave only the couples T tan β / a and T tan β / f.
    line = double_shaft((0.0, 0.3, 0.0))
    found = line.phasing("bearing_force", torque=100.0, teeth=36)
    assert found.proven
    assert found.value >= 100.0 * math.tan(0.3) / 0.15
    every = [
        with_forks(line, np.array([2 * math.pi * k / 36]))
        .analyse(speed=0.0, torque=100.0, positions=np.linspace(0, np.pi, 181))
        .total.bearing_radial.max()
        for k in range(18)
    ]
    assert found.value == pytest.approx(min(every), rel=2e-4)


@pytest.mark.slow
def test_chosen_bearings() -> None:
    line = random_line(3, seed=1)
    everything, one = (
        line.phasing("bearing_force", torque=10.0, bearings=bearings) for bearings in (None, ["E"])
    )
    assert one.value < everything.value


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"objective": "residual"}, ArgumentError, "did you mean 'residual_angle'"),
        ({"bearings": ["A"]}, ArgumentError, "bearings has no meaning for the objective"),
        ({"objective": "bearing_force"}, ArgumentError, "need a torque; give torque"),
        (
            {"objective": "bearing_force", "torque": 1.0, "bearings": ["Z"]},
            ModelError,
            "no bearing",
        ),
        ({"objective": "bearing_force", "torque": math.inf}, ArgumentError, "torque is inf"),
        ({"teeth": 1}, ArgumentError, "teeth of shaft_1 is 1, expected a whole number from 2"),
        ({"teeth": {"shaft_9": 12}}, ModelError, "no intermediate shaft 'shaft_9'"),
        ({"teeth": {"output": 12}}, ModelError, "no intermediate shaft 'output'"),
        ({"teeth": {1: 12}, "fixed": [1]}, ArgumentError, "shaft_1 is fixed and has teeth"),
        ({"shafts": ["input"]}, ModelError, "no shaft behind a joint 'input'"),
        ({"shafts": []}, ArgumentError, "shafts is empty"),
        ({"count": 0}, ArgumentError, "count is 0, expected a whole number from 1"),
    ],
)
def test_what_cannot_be_asked_for(
    arguments: dict[str, object], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        random_line(3, seed=1).phasing(**arguments)


def test_a_single_joint_has_no_forks_to_turn() -> None:
    with pytest.raises(ArgumentError, match="one joint and no intermediate shaft"):
        DriveLine(shafts=[Shaft(), Shaft(slope_side=0.1)]).phasing()


def test_texts_of_phasings_say_what_was_gained() -> None:
    line = arrangements.z_arrangement(np.radians(10.0), 1.0).replace(name="z")
    assert repr(line.phasing()) == "<Phasing of 'z' by residual_angle: 0°, given 0°; proven>"


@pytest.mark.slow
@pytest.mark.parametrize("count", [33, 70])
def test_lines_of_more_joints_than_arrays_have_dimensions(count: int) -> None:
    line = random_line(count, seed=count, bend=0.05)
    found = line.phasing()
    assert found.proven and found.value == pytest.approx(0.0, abs=1e-6)
    held = line.phasing(fixed=[*range(2, count - 1)])
    assert held.value <= held.given_value
