"""Errors carry their numbers as attributes; messages write positions and names alike."""

from __future__ import annotations

import copy
import inspect
import pickle
import re

import numpy as np
import pytest

from cardan_dyn.kit import errors
from cardan_dyn.kit.errors import (
    AccuracyError,
    ArgumentError,
    AssemblyError,
    CardanError,
    ImmutableError,
    as_position,
    as_text,
    choices,
)

CLASSES = [
    item
    for item in vars(errors).values()
    if inspect.isclass(item) and issubclass(item, CardanError)
]


@pytest.mark.parametrize("kind", CLASSES)
def test_every_error_carries_its_message_and_details(kind: type[CardanError]) -> None:
    error = kind("the message", position=0.5, residual=1e-3)
    assert isinstance(error, CardanError)
    assert str(error) == "the message"
    assert error.details == {"position": 0.5, "residual": 1e-3}
    assert (error.position, error.residual) == (0.5, 1e-3)
    with pytest.raises(AttributeError, match="undocumented"):
        _ = error.undocumented


@pytest.mark.parametrize("kind", CLASSES)
def test_every_documented_attribute_is_there(kind: type[CardanError]) -> None:
    _, _, section = inspect.cleandoc(kind.__doc__ or "").partition("Attributes:\n")
    documented = re.findall(r"^ {4}(\w+):", section, re.MULTILINE)
    error = kind("the message")
    assert set(documented) == set(kind.__annotations__) | {"details"} & set(documented)
    for name in documented:
        getattr(error, name)


def test_errors_can_be_caught_as_pythons_own() -> None:
    assert issubclass(ArgumentError, ValueError)
    assert issubclass(ImmutableError, AttributeError)
    assert issubclass(ImmutableError, TypeError)
    assert not issubclass(AssemblyError, (ValueError, AttributeError, TypeError))


@pytest.mark.parametrize(
    "duplicate",
    [copy.copy, copy.deepcopy, lambda error: pickle.loads(pickle.dumps(error))],
    ids=["copy", "deepcopy", "pickle"],
)
def test_copied_errors_keep_their_details(duplicate: object) -> None:
    """Processes of a pool hand errors over as pickles."""
    error = AccuracyError("too great", residual=2.0, position=np.array([1.0, 2.0]))
    copied = duplicate(error)  # type: ignore[operator]
    assert type(copied) is AccuracyError
    assert str(copied) == "too great"
    assert copied.residual == 2.0
    np.testing.assert_array_equal(copied.position, [1.0, 2.0])


def test_an_error_without_details_has_no_attributes() -> None:
    """Pickle asks for attributes before the constructor has run."""
    empty = CardanError.__new__(CardanError)
    with pytest.raises(AttributeError, match="'details'"):
        _ = empty.details


def test_positions_of_one_drive_are_numbers() -> None:
    position = as_position(np.array([0.25]))
    assert type(position) is float
    assert position == 0.25
    several = np.array([0.25, 0.5])
    assert as_position(several) is several


@pytest.mark.parametrize(
    ("position", "text"),
    [
        ([1.0], "1"),
        ([0.1 + 0.2, -2.5], "0.3, -2.5"),
        (np.array([np.pi]), "3.14159265359"),
        ([1e-20, 123456789012.4], "1e-20, 123456789012"),
    ],
)
def test_positions_in_messages_have_twelve_digits(position: object, text: str) -> None:
    assert as_text(position) == text  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("names", "text"),
    [
        ({"b", "a", "C"}, "C, a, b"),
        ([], "none"),
        (["b", "a", "b"], "a, b"),
        (["one"], "one"),
        (iter("ba"), "a, b"),
        (["b.turn_z", "b.z", "a.turn_x", "b.x"], "a.turn_x, b.x, b.z, b.turn_z"),
    ],
)
def test_choices_are_sorted(names: object, text: str) -> None:
    assert choices(names) == text  # type: ignore[arg-type]
