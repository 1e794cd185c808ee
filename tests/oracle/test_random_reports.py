"""Random reports of few samples against closed forms.

`python tests/oracle/run.py reports` runs as many as are wanted.
"""

from __future__ import annotations

import numpy as np
import pytest
import random_reports


@pytest.mark.parametrize("seed", [*range(10), 25, 73])  # Two peaks that were missed once.
def test_extremes_of_few_samples_are_those_of_the_range(seed: int) -> None:
    assert random_reports.ask(seed)[0] == []


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.parametrize("seed", [*range(10, 25), *range(26, 60)])
def test_more_of_them(seed: int) -> None:
    assert random_reports.ask(seed)[0] == []


@pytest.mark.slow
def test_the_judge_sees_extremes_that_are_missed() -> None:
    """A report of the samples alone would fail: sharp peaks lie between them."""
    missed = 0
    for seed in range(12):
        case = random_reports.draw(seed)
        if case.varies:
            continue
        for (owner, quantity), formula in case.told.items():
            if quantity != "drive effort":
                values = np.asarray(getattr(case.sweep[owner], quantity))
                most = random_reports.greatest(formula, case.low, case.high)
                missed += bool(values.max() < (1.0 - 1e-4) * most)
    assert missed >= 8
