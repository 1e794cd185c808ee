"""Data of a response: copies of any kind keep it as it is, and nobody can write to it."""

from __future__ import annotations

import copy
import dataclasses
import pickle
from collections.abc import Callable

import numpy as np
import pytest

from cardan_dyn.core.response.columns import ACCELERATION, SPEED_SQUARED, Layout
from cardan_dyn.core.response.data import Proof, ResponseData
from cardan_dyn.core.response.domain import Domain
from cardan_dyn.core.response.series import Series
from cardan_dyn.kit.frozen import frozen

PROOF = Proof(
    tolerance=1e-9,
    error=1e-10,
    condition=2.0,
    cancellation=3.0,
    loop_residual=1e-15,
    balance_residual=float("nan"),
    power_residual=2e-15,
    rate_residual=3e-15,
    unproven=("slip",),
)
COPIES: dict[str, Callable[[ResponseData], ResponseData]] = {
    "itself": lambda data: data,
    "copied": copy.copy,
    "deeply copied": copy.deepcopy,
    "pickled": lambda data: pickle.loads(pickle.dumps(data)),
}


def response_data() -> ResponseData:
    layout = Layout((SPEED_SQUARED, ACCELERATION), (), ("a",), ("mesh",))
    return ResponseData(
        layout,
        Series(np.arange(64.0).reshape(4, 16), Domain(0.3, 2.0 * np.pi, True)),
        np.array([True, False, False, False]),
        np.array([False, False, True, False]),
        np.ones((0, 6), dtype=bool),
        frozen({"mesh": False}),
        PROOF,
    )


@pytest.mark.parametrize("name", COPIES)
def test_copies_hold_the_same(name: str) -> None:
    data = response_data()
    again = COPIES[name](data)
    assert again.layout == data.layout
    assert again.series.domain == data.series.domain
    np.testing.assert_array_equal(again.series.values, data.series.values)
    np.testing.assert_array_equal(again.zero, data.zero)
    np.testing.assert_array_equal(again.constant, data.constant)
    np.testing.assert_array_equal(again.unique, data.unique)
    assert again.coupling_unique == {"mesh": False}
    # A residual may be nan, which equals nothing.
    assert repr(again.proof) == repr(PROOF)


@pytest.mark.parametrize("name", COPIES)
def test_nothing_can_be_changed(name: str) -> None:
    data = COPIES[name](response_data())
    for array in (data.series.values, data.zero, data.constant):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
    assert not data.unique.flags.writeable
    for record, field in ((data, "zero"), (data.proof, "error")):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(record, field, None)
    with pytest.raises(TypeError):
        data.coupling_unique["mesh"] = True
