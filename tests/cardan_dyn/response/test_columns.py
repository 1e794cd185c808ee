"""Columns and the layout of functions, against indices counted by hand."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn.core.response.columns import (
    ACCELERATION,
    GRAVITY,
    SPEED_SQUARED,
    Acts,
    Column,
    Layout,
)

COLUMNS = (SPEED_SQUARED, Column(Acts.JOINT_LOAD, "gravity x"), *GRAVITY)


@pytest.fixture
def layout() -> Layout:
    return Layout(COLUMNS, ("a", "b"), ("a", "c", "d"), ("mesh",))


@pytest.mark.parametrize(
    ("column", "label"),
    [
        (SPEED_SQUARED, "speed²"),
        (ACCELERATION, "acceleration"),
        (GRAVITY[2], "gravity z"),
        (Column(Acts.JOINT_LOAD, "bearing"), "bearing"),
        (Column(Acts.LINK_LOAD, "rod"), "rod"),
    ],
)
def test_labels(column: Column, label: str) -> None:
    assert column.label == label


def test_a_joint_of_the_same_label_is_another_column() -> None:
    joint = Column(Acts.JOINT_LOAD, "gravity x")
    assert joint.label == GRAVITY[0].label
    assert joint != GRAVITY[0]
    assert Column(Acts.LINK_LOAD, "gravity x") != joint


def test_functions_are_those_of_one_column_after_the_other(layout: Layout) -> None:
    """Two wrenches, three efforts and a coupling are 16 functions of each of five columns."""
    assert (layout.wrenches, layout.moments, layout.size) == (12, 15, 16)
    rows = [layout.row(column, function) for column in COLUMNS for function in range(16)]
    assert rows == list(range(80))
    wrenches, others = layout.split(np.arange(80.0))
    assert wrenches.shape == (5, 2, 6) and others.shape == (5, 4)
    assert wrenches[2, 1, 3] == layout.row(COLUMNS[2], 6 + 3)
    assert others[4, 3] == layout.row(COLUMNS[4], layout.moments)


def test_without_columns_there_are_no_functions() -> None:
    wrenches, others = Layout((), ("a",), ("a",), ()).split(np.zeros(0))
    assert wrenches.shape == (0, 1, 6) and others.shape == (0, 1)
    with pytest.raises(ValueError, match="not in tuple"):
        Layout((), ("a",), ("a",), ()).row(ACCELERATION, 0)
