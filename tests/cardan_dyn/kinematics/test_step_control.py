"""Step control: cubic growth, approach of singular configurations, and targets hit exactly."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cardan_dyn.kinematics.following.branch import REJECTED_EXCESS, StepControl, allowed_correction

LONGEST = 2.0 * np.pi / 8.0


def regular(target: float, step: float = 0.1, unit: float = 1.0) -> StepControl:
    result = StepControl(1.0, target, unit, margin=1.0)
    result.step = step
    return result


@pytest.mark.parametrize("unit", [1.0, 0.02])
def test_the_first_step_is_shorter_near_singular_configurations(unit: float) -> None:
    assert StepControl(1.0, 9.0, unit, margin=1.0).step == pytest.approx(unit * np.pi / 8.0)
    assert StepControl(1.0, 9.0, unit, margin=1e-4).step == pytest.approx(3e-4 * unit)


def test_a_singular_start_cannot_be_left() -> None:
    assert StepControl(1.0, 9.0, 1.0, margin=0.0).is_stopped
    assert not StepControl(1.0, 9.0, 1.0, margin=1e-6).is_stopped


@pytest.mark.parametrize("excess", [0.1, 0.5, 1.0, 3.9])
def test_the_next_step_is_the_one_whose_cubic_error_is_allowed(excess: float) -> None:
    control = regular(9.0)
    control.accept(0.1, excess, margin=1.0)
    # An error of `excess` at a step of 0.1 is one of 1 at the next step.
    assert excess * (control.step / 0.1) ** 3 == pytest.approx(1.0)


def test_growth_is_limited() -> None:
    control = regular(9.0)
    control.accept(0.1, 0.0, margin=1.0)
    assert control.step == pytest.approx(0.25)
    control = regular(9.0, unit=0.5)
    control.accept(0.3, 1e-9, margin=1.0)
    assert control.step == 0.5 * LONGEST


def test_rejected_steps_shrink_until_they_stop() -> None:
    control = regular(9.0, unit=0.5)
    steps = []
    while not control.is_stopped:
        steps.append(control.step)
        control.reject()
        assert len(steps) < 100
    assert all(later < 0.5 * earlier for earlier, later in pairwise(steps))
    assert steps[-1] >= 0.5e-9 > control.step


@pytest.mark.parametrize("slope", [0.1, 1.0 / 3.0])
def test_a_singular_configuration_is_approached_and_never_reached(slope: float) -> None:
    """The reciprocal condition number falls in proportion to the distance from it."""
    singular, position = 2.0, 0.0
    control = StepControl(1.0, 5.0, 1.0, margin=slope * singular)
    while not control.is_stopped:
        reached = control.next_position(position)
        assert reached < singular
        control.accept(reached - position, 0.5, margin=slope * (singular - reached))
        position = reached
    assert singular - position < 1e-8


def test_steps_away_from_a_singular_configuration_grow() -> None:
    control = StepControl(1.0, 5.0, 1.0, margin=1e-3)
    first = control.step
    control.accept(first, 0.01, margin=4e-3)
    assert control.step == pytest.approx(2.5 * first)


@given(
    sign=st.sampled_from([-1.0, 1.0]),
    start=st.floats(-100.0, 100.0),
    distance=st.floats(1e-6, 20.0),
    strengths=st.lists(st.floats(0.0, 100.0), min_size=1, max_size=5),
)
def test_the_target_is_hit_exactly_and_never_passed(
    sign: float, start: float, distance: float, strengths: list[float]
) -> None:
    target = start + sign * distance
    control = StepControl(sign, target, 1.0, margin=1.0)
    position = start
    for trial in range(10_000):
        remaining = control.remaining(position)
        if remaining <= 0.0:
            break
        reached = control.next_position(position)
        assert 0.0 <= control.remaining(reached) < remaining
        step = abs(reached - position)
        excess = strengths[trial % len(strengths)] * step**3
        if excess < REJECTED_EXCESS:
            control.accept(step, excess, margin=1.0)
            position = reached
        else:
            control.reject()
    assert position == target


def test_allowed_corrections_shrink_with_bad_conditions() -> None:
    conditions = np.array([1.0, 100.0, 200.0, 1e6])
    np.testing.assert_allclose(allowed_correction(conditions), [0.03, 0.03, 0.015, 3e-6])
