"""Random chains: the package against free bodies that share nothing with it.

More of them: `python tests/oracle/run.py chains --seeds 2000`, `turned`, `cut` and `held`.
"""

from __future__ import annotations

import pytest
from compare import cut_differently, differences, dissimilar, held_elsewhere, sweep_of
from scenes import draw


@pytest.mark.slow
# Of the last one, no self-stress is felt by what gives way.
@pytest.mark.parametrize("seed", [*range(80), 60274])
def test_a_random_chain_agrees_with_its_free_bodies(seed: int) -> None:
    case = draw(seed)
    differing = differences(case, sweep_of(case))
    assert not differing, f"{sorted(case.features)}: " + "; ".join(map(str, differing))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(40))
def test_loops_may_be_turned_along_their_freedoms(seed: int) -> None:
    case = draw(seed, turns=True)
    differing = differences(case, sweep_of(case))
    assert not differing, f"{sorted(case.features)}: " + "; ".join(map(str, differing))


# Among them a rack beside a pinion, closures to the world and masses far from their joints.
@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 3, 11, 43, 83, 138, 158, 203, 207, 288])
def test_a_similar_chain_of_another_size_has_similar_wrenches(seed: int) -> None:
    differing = dissimilar(draw(seed), seed)
    assert not differing, "; ".join(map(str, differing))


# Closures to the world, and bodies whose joints lie far apart.
@pytest.mark.parametrize("seed", [2, 138, 149, 162, 189])
def test_what_is_chosen_does_not_depend_on_where_rings_are_cut(seed: int) -> None:
    differing = cut_differently(draw(seed), seed) or []
    assert not differing, "; ".join(map(str, differing))


# Some cannot be reached, and some hold several joints.
@pytest.mark.parametrize("seed", [*range(500, 512)])
def test_joints_held_elsewhere_are_held_as_in_a_new_scene(seed: int) -> None:
    differing = held_elsewhere(draw(seed), seed) or []
    assert not differing, "; ".join(map(str, differing))
