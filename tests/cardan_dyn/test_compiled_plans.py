"""Plans of compiled functions are made only if all in them fits."""

from __future__ import annotations

import pickle
from collections.abc import Iterator

import numpy as np
import pytest
from testkit.claims import coupled_wheels, four_bar, universal
from testkit.compiled_functions import needs_kernel

from cardan_dyn.compiled import Plan
from cardan_dyn.elements import stepping

pytestmark = needs_kernel

KINDS = {"closure", "moves", "stepping"}
FAR = 1 << 40
COMPARED_LATER = {
    "closure": {1: (1, {0})},
    "moves": {index: (1, {0}) for index in range(4)},
}
"""Tables, how many numbers a row of them has, and which of these are no indices (flags, signs,
keys), or are compared with what the functions are given."""


@pytest.fixture(scope="module")
def plans() -> Iterator[dict[str, list[Plan]]]:
    """Plans of every kind, as sweeps make them."""
    found: dict[str, list[Plan]] = {}
    make = Plan.__init__

    def noted(self: Plan, kind: str, *arrays: object) -> None:
        make(self, kind, *arrays)  # type: ignore[arg-type]
        found.setdefault(kind, []).append(self)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Plan, "__init__", noted)
        for scene in (universal(), universal(gravity=None), four_bar(), coupled_wheels()):
            columns = scene.mechanism.coordinates.columns_of(scene.drives)
            start = scene.solver.assembly.start[columns]
            for _ in range(3):
                scene.sweep(start + np.linspace(0.0, 0.1, 40)[:, None], speed=1.0)
        stepping._plan.__wrapped__()  # It is the same in all scenes.
    yield found


def test_every_kind_is_made(plans: dict[str, list[Plan]]) -> None:
    assert set(plans) == KINDS


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_arrays_of_other_sizes_are_refused(kind: str, plans: dict[str, list[Plan]]) -> None:
    for plan in plans[kind]:
        _, integers, numbers = plan._given
        given = {"integers": integers, "numbers": numbers}
        for name, arrays in given.items():
            for index, array in enumerate(arrays):
                if len(array) == 0:
                    continue
                changed = [*arrays[:index], array[:-1], *arrays[index + 1 :]]
                with pytest.raises(ValueError, match=f"plan of {kind} do not fit"):
                    Plan(kind, **{**given, name: changed})
        for other in (([*integers, [0]], numbers), (integers, [*numbers, [0.0]])):
            with pytest.raises(ValueError, match="do not fit"):
                Plan(kind, *other)


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_what_is_no_index_is_refused(kind: str, plans: dict[str, list[Plan]]) -> None:
    for plan in plans[kind][:4]:
        _, integers, numbers = plan._given
        for index, array in enumerate(integers):
            fields, free = COMPARED_LATER.get(kind, {}).get(index, (1, set()))
            for place in range(len(array)):
                if place % fields in free:
                    continue
                for bad in (-FAR, FAR):
                    changed = [each.copy() for each in integers]
                    changed[index][place] = bad
                    with pytest.raises(ValueError, match="do not fit"):
                        Plan(kind, changed, numbers)


def test_plans_can_be_sent(plans: dict[str, list[Plan]]) -> None:
    for own in plans.values():
        again = pickle.loads(pickle.dumps(own[0]))
        assert again.handle is not own[0].handle
        for one, other in zip(own[0]._given[1], again._given[1], strict=True):
            np.testing.assert_array_equal(one, other)


def test_kinds_that_are_none_are_refused() -> None:
    for kind in ("spring", "", None, 3):
        with pytest.raises(ValueError, match="no plans of"):
            Plan(kind, [], [])  # type: ignore[arg-type]
