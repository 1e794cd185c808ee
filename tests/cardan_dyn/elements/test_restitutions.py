"""Restitutions: against the condition itself in 40 digits, and against integrated impacts."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cardan_dyn.core.elements.restitutions import (
    loss_of_restitution,
    restitution_of_damping_ratio,
    restitution_of_loss,
)


def condition(loss: float, restitution: mpmath.mpf) -> mpmath.mpf:
    h = mpmath.mpf(loss)
    return h * (1 + restitution) - mpmath.log((1 + h) / (1 - h * restitution))


@pytest.mark.parametrize("loss", [1e-9, 1e-4, 0.1, 0.249, 0.251, 1.0, 5.0, 18.0])
def test_restitution_of_loss_solves_the_condition(loss: float) -> None:
    found = restitution_of_loss(loss)
    with mpmath.workdps(60):
        e = mpmath.mpf(found)
        # One step of Newton's method in 60 digits from what was found.
        slope = mpmath.mpf(loss) - mpmath.mpf(loss) / (1 - mpmath.mpf(loss) * e)
        error = condition(loss, e) / slope
        assert abs(float(error)) < 1e-14


@pytest.mark.parametrize("wanted", [0.001, 0.02, 0.06, 0.3, 0.5, 0.8, 0.95, 0.999, 1.0 - 1e-9])
def test_loss_and_restitution_are_inverse(wanted: float) -> None:
    loss = loss_of_restitution(wanted)
    assert restitution_of_loss(loss) == pytest.approx(wanted, rel=1e-14)


def test_limits_of_the_loss() -> None:
    assert loss_of_restitution(1.0) == 0.0
    assert restitution_of_loss(0.0) == 1.0
    # h -> 3 (1 - e) / 2 near 1, and 1 / e near 0.
    assert loss_of_restitution(1.0 - 1e-6) == pytest.approx(1.5e-6, rel=1e-5)
    assert loss_of_restitution(1e-3) == pytest.approx(1e3, rel=1e-12)


@pytest.mark.parametrize("ratio", [0.0, 0.05, 0.25, 0.7, 0.99999999, 1.0, 1.00000001, 3.0])
def test_a_damper_loses_what_an_integrated_impact_loses(ratio: float) -> None:
    def vanishes(_: float, y: np.ndarray) -> float:
        return float(y[0] + 2.0 * ratio * y[1])

    vanishes.terminal, vanishes.direction = True, -1  # type: ignore[attr-defined]
    run = solve_ivp(
        lambda _, y: [y[1], -y[0] - 2.0 * ratio * y[1]],
        (0.0, 50.0),
        [1e-300, 1.0],
        method="DOP853",
        events=vanishes,
        rtol=1e-12,
        atol=1e-14,
    )
    assert restitution_of_damping_ratio(ratio) == pytest.approx(-run.y[1, -1], rel=1e-10)


def test_a_critical_damper() -> None:
    assert restitution_of_damping_ratio(1.0) == pytest.approx(math.exp(-2.0), rel=1e-15)
