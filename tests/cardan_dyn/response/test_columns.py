"""Columns and the layout of functions, against indices counted by hand."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn.response.columns import ACCELERATION, GRAVITY, SPEED_SQUARED, Column, Kind, Layout

COLUMNS = (SPEED_SQUARED, Column(Kind.JOINT_LOAD, "gravity x"), *GRAVITY)


@pytest.fixture
def layout() -> Layout:
    return Layout(COLUMNS, ("a", "b"), ("a", "c", "d"), ("mesh",))


@pytest.mark.parametrize(
    ("column", "label"),
    [
        (SPEED_SQUARED, "speed²"),
        (ACCELERATION, "acceleration"),
        (GRAVITY[2], "gravity z"),
        (Column(Kind.JOINT_LOAD, "bearing"), "bearing"),
        (Column(Kind.LINK_LOAD, "rod"), "rod"),
    ],
)
def test_labels(column: Column, label: str) -> None:
    assert column.label == label


def test_a_joint_of_the_same_label_is_another_column() -> None:
    joint = Column(Kind.JOINT_LOAD, "gravity x")
    assert joint.label == GRAVITY[0].label
    assert joint != GRAVITY[0]
    assert Column(Kind.LINK_LOAD, "gravity x") != joint


def test_indices_run_through_wrenches_and_then_scalars(layout: Layout) -> None:
    """Five columns of two wrenches, then five of three efforts and a coupling."""
    listed = [
        index
        for column in COLUMNS
        for output in range(2)
        for index in layout.wrench(column, output)
    ]
    for column in COLUMNS:
        listed += [layout.effort(column, effort) for effort in range(3)]
        listed += [layout.coupling(column, 0)]
    assert listed == list(range(layout.count))
    assert layout.count == 5 * 2 * 6 + 5 * (3 + 1)


def test_joined_functions_lie_at_their_indices(layout: Layout) -> None:
    rng = np.random.default_rng(1)
    wrenches, scalars = rng.normal(size=(5, 2, 6, 7)), rng.normal(size=(5, 4, 7))
    values = layout.joined(wrenches, scalars)
    assert values.shape == (layout.count, 7)
    for index, column in enumerate(COLUMNS):
        for output in range(2):
            np.testing.assert_array_equal(
                values[list(layout.wrench(column, output))], wrenches[index, output]
            )
        for effort in range(3):
            np.testing.assert_array_equal(
                values[layout.effort(column, effort)], scalars[index, effort]
            )
        np.testing.assert_array_equal(values[layout.coupling(column, 0)], scalars[index, 3])
    for part, original in zip(layout.split(values), (wrenches, scalars), strict=True):
        np.testing.assert_array_equal(part, original)


def test_spread_gives_each_function_the_value_of_its_column(layout: Layout) -> None:
    wrenches, scalars = layout.split(layout.spread(np.arange(5.0)))
    for index in range(5):
        np.testing.assert_array_equal(wrenches[index], np.full((2, 6), index))
        np.testing.assert_array_equal(scalars[index], np.full(4, index))


@pytest.mark.parametrize(
    "layout", [Layout((), ("a",), ("a",), ()), Layout((), (), (), ("mesh",))], ids=str
)
def test_without_columns_there_are_no_functions(layout: Layout) -> None:
    assert layout.count == 0
    wrenches, scalars = layout.split(np.zeros((0, 3)))
    assert wrenches.shape == (0, len(layout.outputs), 6, 3)
    assert layout.joined(wrenches, scalars).shape == (0, 3)


def test_without_outputs_there_are_scalars_alone() -> None:
    layout = Layout((SPEED_SQUARED, ACCELERATION), (), ("a",), ())
    assert layout.count == 2
    assert [layout.effort(column, 0) for column in layout.columns] == [0, 1]


def test_a_column_that_the_layout_does_not_have_has_no_index(layout: Layout) -> None:
    with pytest.raises(KeyError):
        layout.effort(ACCELERATION, 0)
