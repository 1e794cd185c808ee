"""Plans of compiled functions are made only if all in them fits."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from testkit.compiled_functions import needs_kernel

from cardan_dyn.core.compiled import Plan
from cardan_dyn.core.elements import stepping

pytestmark = needs_kernel


def test_arrays_of_other_sizes_are_refused() -> None:
    kind, integers, numbers = stepping._plan()._given
    for index, array in enumerate(numbers):
        changed = [*numbers[:index], array[:-1], *numbers[index + 1 :]]
        with pytest.raises(ValueError, match=f"plan of {kind} do not fit"):
            Plan(kind, integers, changed)
    for other in (([*integers, [0]], numbers), (integers, [*numbers, [0.0]])):
        with pytest.raises(ValueError, match="do not fit"):
            Plan(kind, *other)


def test_plans_can_be_sent() -> None:
    own = stepping._plan()
    again = pickle.loads(pickle.dumps(own))
    assert again.handle is not own.handle
    for one, other in zip(own._given[2], again._given[2], strict=True):
        np.testing.assert_array_equal(one, other)


def test_kinds_that_are_none_are_refused() -> None:
    for kind in ("spring", "", None, 3):
        with pytest.raises(ValueError, match="no plans of"):
            Plan(kind, [], [])  # type: ignore[arg-type]
