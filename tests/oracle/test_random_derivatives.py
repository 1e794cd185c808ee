"""Derivatives of random chains against differences in fifty digits.

More of them: `python tests/oracle/run.py derivatives --seeds 500`.
"""

from __future__ import annotations

import pytest
import random_derivatives

# Among them what opens loops, balls, crosses, couplings, moving bases, what is held twice, springs.
QUICK = 3, 9, 28, 32, 36, 37, 48, 55, 65, 70


@pytest.mark.parametrize("seed", QUICK)
def test_derivatives_of_a_random_chain(seed: int) -> None:
    assert not random_derivatives.ask(seed)[0]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [seed for seed in range(40) if seed not in QUICK])
def test_derivatives_of_more_random_chains(seed: int) -> None:
    assert not random_derivatives.ask(seed)[0]
