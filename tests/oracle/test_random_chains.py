"""Random chains: the package against free bodies that share nothing with it.

More of them: `python tests/oracle/run.py --seeds 2000`, and with `--turned`.
"""

from __future__ import annotations

import pytest
from compare import differences, sweep_of
from scenes import draw


@pytest.mark.parametrize("seed", range(80))
def test_a_random_chain_agrees_with_its_free_bodies(seed: int) -> None:
    case = draw(seed)
    differing = differences(case, sweep_of(case))
    assert not differing, f"{sorted(case.features)}: " + "; ".join(map(str, differing))


@pytest.mark.parametrize("seed", range(40))
def test_loops_may_be_turned_along_their_freedoms(seed: int) -> None:
    case = draw(seed, turns=True)
    differing = differences(case, sweep_of(case))
    assert not differing, f"{sorted(case.features)}: " + "; ".join(map(str, differing))
