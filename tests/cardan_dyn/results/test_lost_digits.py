"""Lost digits: the condition counts where wrenches are great, and not where they vanish."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn.core.results.lost_digits import WELL, digits, lost_part, near_singular

EPS = np.finfo(float).eps


@pytest.mark.parametrize(
    ("condition", "sizes", "part"),
    [
        ([1e3, 1e15], [2.0, 0.0], 1e3 * EPS),
        ([1e3, 1e9], [2.0, 2.0], 1e9 * EPS),
        ([1e3, 1e9], [2.0, 2e-3], 1e6 * EPS),
        ([1e5], [2.0, 0.5], 1e5 * EPS),
        ([1e3, np.nan], [2.0, 0.5], np.inf),
        ([1e3, np.nan], [2.0, np.nan], 1e3 * EPS),
        ([1e3, 1e3], [0.0, 0.0], 0.0),
    ],
)
def test_part_that_is_rounding(condition: list[float], sizes: list[float], part: float) -> None:
    assert lost_part(np.array(condition), np.array(sizes)) == pytest.approx(part)


def test_words() -> None:
    assert near_singular(0.5 * WELL * EPS) == ""
    assert "some 6 digits" in near_singular(5e-7)
    assert "some 0 digits" in near_singular(np.inf)
    assert (digits(0.0), digits(1e-12)) == (15, 12)
