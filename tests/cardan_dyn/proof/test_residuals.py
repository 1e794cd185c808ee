"""Residuals by hand: how they are compared, joined and refused."""

from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.core.proof.residuals import (
    BALANCE_TOLERANCE,
    CHECK_ROUNDING,
    Residuals,
    overflow,
    ratio,
)

POSITIONS = np.array([[0.5], [1.5], [2.5]])
CONDITION = np.array([1.0, 2.0, 3.0])


def residuals(**changes: object) -> Residuals:
    """Return residuals of three samples in exact balance, with some of them changed."""
    zero, one = np.zeros(3), np.ones(3)
    exact: dict[str, object] = {
        "imbalance": zero,
        "power_imbalance": zero,
        "loop_error": zero,
        "rate_error": zero,
        "wrench": 4.0 * one,
        "applied": 2.0 * one,
        "inertia": zero,
        "power_scale": 3.0 * one,
        "speed_scale": 0.5 * one,
        "bodies_balanced": True,
        "power_balanced": True,
    }
    values = {
        name: np.array(value, dtype=float) if isinstance(value, list) else value
        for name, value in changes.items()
    }
    return Residuals(**{**exact, **values})  # type: ignore[arg-type]


def test_exact_balance_is_accepted() -> None:
    exact = residuals()
    exact.prove(POSITIONS, CONDITION)
    assert (exact.balance, exact.rate, exact.power) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("field", "name", "scale"),
    [
        ("loop_error", "loop", 1.0),
        ("rate_error", "rate", 1.0),
        # Wrench, load and inertia; power, and those times the joint speed.
        ("imbalance", "balance", 4.0 + 2.0 + 1.0),
        ("power_imbalance", "power", 3.0 + (4.0 + 2.0 + 1.0) * 0.5),
    ],
)
def test_every_residual_is_refused_above_the_tolerance(field: str, name: str, scale: float) -> None:
    inertia = np.ones(3)
    greatest = BALANCE_TOLERANCE * scale
    below = residuals(inertia=inertia, **{field: [0.0, 0.99 * greatest, 0.5 * greatest]})
    below.prove(POSITIONS, CONDITION)
    above = residuals(inertia=inertia, **{field: [0.0, 3.0 * greatest, 2.0 * greatest]})
    with pytest.raises(
        cd.AccuracyError, match=f"the {name} residual is 3.0e-08 at drive"
    ) as caught:
        above.prove(POSITIONS, CONDITION)
    assert "drive position 1.5, more than 1e-08" in str(caught.value)
    assert "condition 2.0e+00 there: which explains no such error" in str(caught.value)
    assert caught.value.residual == pytest.approx(3.0 * BALANCE_TOLERANCE, rel=1e-12, abs=0.0)
    assert caught.value.tolerance == BALANCE_TOLERANCE
    assert caught.value.position == 1.5


def test_each_sample_is_compared_with_its_own_scale() -> None:
    """A small wrench of one sample is not excused by the great wrenches of the others."""
    error = 2.0 * BALANCE_TOLERANCE
    small = residuals(imbalance=[0.0, 0.0, error], wrench=[1e6, 1e6, 1.0], applied=np.zeros(3))
    with pytest.raises(cd.AccuracyError, match=r"the balance residual is 2.0e-08 .* 2.5,"):
        small.prove(POSITIONS, CONDITION)
    assert small.balance == pytest.approx(error / 1e6, rel=1e-12, abs=0.0)


def test_advice_next_to_singular_configurations() -> None:
    bad = residuals(loop_error=[1.0, 0.0, 0.0])
    with pytest.raises(cd.AccuracyError, match="stay away from this position or choose"):
        bad.prove(POSITIONS, np.array([1e7, 1.0, 1.0]))
    with pytest.raises(cd.AccuracyError, match="please report it with the scene"):
        bad.prove(POSITIONS, np.array([1.0, 1e7, 1e7]))
    worse = residuals(loop_error=[0.5, 0.0, 1.0])
    with pytest.raises(cd.AccuracyError, match="stay away from this position or choose"):
        worse.prove(POSITIONS, np.array([1.0, 1.0, 1e7]))


def test_positions_of_several_drives_in_the_error() -> None:
    bad = residuals(loop_error=[0.0, 0.0, 1.0])
    with pytest.raises(cd.AccuracyError, match="at drive position 3, 4,") as caught:
        bad.prove(np.array([[1.0, 2.0], [2.0, 3.0], [3.0, 4.0]]), CONDITION)
    np.testing.assert_array_equal(caught.value.position, [3.0, 4.0])


@pytest.mark.parametrize(
    "changes",
    [
        {"loop_error": [0.0, np.nan, 0.0]},
        {"rate_error": [0.0, np.inf, 0.0]},
        {"imbalance": [0.0, np.nan, 0.0]},
        {"power_imbalance": [0.0, np.inf, 0.0]},
        {"wrench": [1.0, np.inf, 1.0]},
        {"inertia": [1.0, np.nan, 1.0]},
    ],
)
def test_what_is_not_finite_is_no_proof(changes: dict[str, list[float]]) -> None:
    with pytest.raises(cd.AccuracyError, match=r"at drive position 1\.5 cannot be computed"):
        residuals(**changes).prove(POSITIONS, CONDITION)


def test_bodies_and_power_that_are_not_claimed_are_not_proven() -> None:
    unknown = residuals(
        imbalance=[1.0, 1.0, 1.0],
        power_imbalance=[1.0, 1.0, 1.0],
        bodies_balanced=False,
        power_balanced=False,
    )
    unknown.prove(POSITIONS, CONDITION)
    assert np.isnan(unknown.balance)
    assert np.isnan(unknown.power)


def test_balance_and_power_are_relative_to_the_greatest_wrench() -> None:
    item = residuals(
        imbalance=[0.0, 3e-9, 1e-9],
        power_imbalance=[0.0, 4e-9, 0.0],
        rate_error=[1e-12, 5e-12, 2e-12],
        wrench=[1.0, 2.0, 10.0],
        inertia=[0.0, 8.0, 0.0],
    )
    assert item.balance == pytest.approx(3e-10, rel=1e-6, abs=0.0)
    assert item.power == pytest.approx(4e-9 / (3.0 + 10.0 * 0.5), rel=1e-12, abs=0.0)
    assert item.rate == 5e-12


def test_balance_includes_what_the_rounding_of_inertial_terms_hides() -> None:
    item = residuals(wrench=[1.0, 2.0, 10.0], inertia=[0.0, 8.0, 0.0])
    assert item.balance == pytest.approx(0.8 * CHECK_ROUNDING, rel=1e-12, abs=0.0)
    assert 1e-18 < CHECK_ROUNDING < 1e-16


def test_loads_count_where_wrenches_are_smaller() -> None:
    item = residuals(imbalance=[0.0, 0.0, 2e-9], wrench=np.ones(3), applied=[0.0, 20.0, 0.0])
    assert item.balance == pytest.approx(1e-10, rel=1e-12, abs=0.0)


def test_wrenches_that_are_rounding_are_replaced_by_the_inertial_terms() -> None:
    """Where all inertial terms cancel, what is left of them is no scale."""
    rounding = np.full(3, 1e-16)
    item = residuals(imbalance=rounding, wrench=rounding, applied=np.zeros(3), inertia=np.ones(3))
    assert item.balance < 1e-15


def test_nothing_at_all_has_no_residual() -> None:
    zero = np.zeros(3)
    idle = residuals(wrench=zero, applied=zero, power_scale=zero)
    assert np.isnan(idle.balance)
    assert np.isnan(idle.power)
    idle.prove(POSITIONS, CONDITION)


def test_cancellation_of_inertial_terms() -> None:
    item = residuals(wrench=[4.0, 1.0, 0.0], applied=[2.0, 5.0, 0.0], inertia=[0.0, 10.0, 7.0])
    # None at rest; ten of five; and where nothing remains, as much as remains.
    np.testing.assert_allclose(item.cancellation, [1.0, 3.0, 2.0])


def test_joined_blocks_follow_each_other() -> None:
    first, second = residuals(imbalance=[1.0, 2.0, 3.0]), residuals(imbalance=[4.0, 5.0, 6.0])
    joined = Residuals.joined([first, second._replace(power_balanced=True)])
    np.testing.assert_array_equal(joined.imbalance, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    assert all(len(value) == 6 for value in joined[:-3])
    for flags in ((True, False), (False, True)):
        bodies, power = flags
        block = residuals(bodies_balanced=bodies, power_balanced=power)
        joined = Residuals.joined([block, block])
        assert (joined.bodies_balanced, joined.power_balanced) == flags
    elastic = Residuals.joined([block._replace(elastic=np.ones(3))] * 2).elastic
    assert elastic is not None
    assert len(elastic) == 6


def test_overflow_belongs_to_no_position() -> None:
    error = overflow("the wrenches")
    assert str(error).startswith("the wrenches cannot be computed, since numbers overflow")
    assert np.isnan(error.residual)
    assert error.position is None


def test_ratios_of_zero_and_of_very_small_numbers() -> None:
    zero, tiny = 0.0, 1e-305
    result = ratio(np.array([1.0, zero, zero, 2.0, tiny]), np.array([4.0, zero, 5.0, zero, zero]))
    assert result[:3].tolist() == [0.25, 0.0, 0.0]
    assert result[3] > 1e299
    assert result[4] < 1e-4
    assert np.isnan(ratio(np.array([np.nan]), np.array([1.0]))[0])
