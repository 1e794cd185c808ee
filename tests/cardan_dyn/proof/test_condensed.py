"""Condensed: few samples say what all of them do, whatever others are beside them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from cardan_dyn.core.proof.condensed import condensed
from cardan_dyn.core.proof.residuals import Residuals

COUNT = 2000


def residuals(seed: int, inertia: float = 0.0, wrench: float = 1.0) -> Residuals:
    rng = np.random.default_rng(seed)

    def noise(scale: float) -> np.ndarray:
        return scale * np.exp(2.0 * rng.normal(size=COUNT))

    return Residuals(
        imbalance=noise(1e-15),
        power_imbalance=noise(1e-15),
        loop_error=noise(1e-16),
        rate_error=noise(1e-16),
        wrench=noise(wrench),
        applied=noise(wrench),
        inertia=noise(inertia),
        power_scale=noise(1.0),
        speed_scale=noise(1.0),
        bodies_balanced=True,
        power_balanced=True,
    )


def said(item: Residuals) -> tuple[float, ...]:
    return item.balance, item.power, item.rate, float(np.max(item.loop_error))


CASES: dict[str, Callable[[int], Residuals]] = {
    "loads": lambda seed: residuals(seed),
    "inertia": lambda seed: residuals(seed, 10.0),
    "cancelled": lambda seed: residuals(seed, 1e13, 0.1),
    "nothing acts": lambda seed: residuals(seed, 0.0, 0.0),
    "exact": lambda seed: residuals(seed)._replace(
        imbalance=np.zeros(COUNT), power_imbalance=np.zeros(COUNT)
    ),
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("factor", [1e-3, 1.0, 30.0, 1e9])
def test_the_same_is_said_beside_other_samples(case: str, factor: float) -> None:
    first, second = CASES[case](0), residuals(1, 1.0, factor)
    assert said(condensed(first)) == said(first)
    expected = said(Residuals.joined([first, second]))
    for parts in ([condensed(first), second], [condensed(first), condensed(second)]):
        assert said(Residuals.joined(parts)) == pytest.approx(expected, rel=1e-14)
        assert said(condensed(Residuals.joined(parts))) == pytest.approx(expected, rel=1e-14)


def test_few_samples_are_kept() -> None:
    assert len(condensed(residuals(0)).imbalance) < 40
    assert len(condensed(residuals(0, 10.0)).imbalance) < 40


def test_where_many_decide_all_of_them_are_kept() -> None:
    """Quotients that are the greatest ones one after the other."""
    place = np.linspace(0.0, 0.5 * np.pi, COUNT + 2)[1:-1]
    item = residuals(0)._replace(
        wrench=np.full(COUNT, 1e-3),
        applied=np.zeros(COUNT),
        power_imbalance=np.full(COUNT, 1e-15),
        power_scale=2.0 - np.cos(place),
        speed_scale=2.0 - np.sin(place),
    )
    assert len(condensed(item).imbalance) == COUNT
