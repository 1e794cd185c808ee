"""Derivatives of random chains against differences in fifty digits.

More of them: `python tests/oracle/run.py derivatives --seeds 500`.
"""

from __future__ import annotations

import pytest
import random_derivatives

# Among them what opens loops, balls, crosses, moving bases, what is held twice, springs.
QUICK = 9, 32, 36, 37


@pytest.mark.parametrize("seed", QUICK)
def test_derivatives_of_a_random_chain(seed: int) -> None:
    assert not random_derivatives.ask(seed)[0]


@pytest.mark.slow
@pytest.mark.parametrize("seed", sorted({*range(40), 48, 55, 65, 70, 99210} - {*QUICK}))
def test_derivatives_of_more_random_chains(seed: int) -> None:
    assert not random_derivatives.ask(seed)[0]
