"""Checks of single arguments: each returns a plain value of the expected type, or says what it is.

Whatever an argument does when it is looked at (compare, iterate, become an array), nothing but an
`ArgumentError` comes of it.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, KeysView, Mapping, Set
from contextlib import contextmanager
from itertools import islice
from typing import Any

import numpy as np

from .arrays import Array
from .errors import ArgumentError

_MOST_NAMES = 100_000
"""Names are counted up to here, since an iterator may never end."""


@contextmanager
def _looking_at(name: str, expected: str) -> Iterator[None]:
    """Turn whatever an argument raises when it is looked at into an `ArgumentError`."""
    try:
        yield
    except ArgumentError:
        raise
    except Exception as error:
        raise ArgumentError(f"{name} is not {expected} ({_said(error)})") from error


def _said(error: Exception) -> str:
    """Return an error's message, short and on one line; its type if it cannot even say that."""
    try:
        return " ".join(str(error).split())[:200] or type(error).__name__
    except Exception:
        return type(error).__name__


def described(value: object) -> str:
    """Return an argument for a message: what it is if that is short, else its type."""
    if value is None or isinstance(value, (bool, int, float, complex, str, bytes)):
        try:
            return shortened(repr(value))
        except Exception:  # A number of too many digits, a class with a repr of its own.
            return f"of type {type(value).__name__}"
    if isinstance(value, np.ndarray):
        return f"an array of type {value.dtype}"
    return f"of type {type(value).__name__}"


def shortened(text: str, most: int = 80) -> str:
    """Return a text cut to a length that suits a message."""
    return text if len(text) <= most else f"{text[: most - 3]}..."


def flag(name: str, value: object) -> bool:
    """Return an argument that is True or False.

    Args:
        name: how messages call the argument.
        value: a bool, Python's or NumPy's.

    Raises:
        ArgumentError: it is anything else.
    """
    if not isinstance(value, (bool, np.bool_)):
        raise ArgumentError(f"{name} is {described(value)}, expected True or False")
    return bool(value)


def text(name: str, value: object) -> str:
    """Return an argument that is a name or a word.

    Args:
        name: how messages call the argument.
        value: a string, Python's or NumPy's.

    Raises:
        ArgumentError: it is anything else.
    """
    if not isinstance(value, str):
        raise ArgumentError(f"{name} is {described(value)}, expected a string")
    return str(value)


def names(name: str, value: object) -> tuple[str, ...]:
    """Return an argument that is one name, or several in an order.

    Args:
        name: how messages call the argument.
        value: a string, or strings that can be iterated: a sequence, an array, a generator. A set
            is none, since it has no order.

    Raises:
        ArgumentError: it is anything else.
    """
    if isinstance(value, str):
        return (str(value),)
    expected = "a name or a sequence of names"
    unordered = isinstance(value, Set) and not isinstance(value, KeysView)
    if unordered or isinstance(value, (Mapping, bytes, bytearray, memoryview)):
        detail = ", which has no order" if unordered else ""
        raise ArgumentError(f"{name} is {described(value)}{detail}; expected {expected}")
    if not isinstance(value, Iterable):
        raise ArgumentError(f"{name} is {described(value)}, expected {expected}")
    with _looking_at(name, expected):
        # An array of one name without a dimension is that name.
        items = [value.item()] if isinstance(value, np.ndarray) and not value.ndim else value
        listed = list(islice(items, _MOST_NAMES + 1))
    if len(listed) > _MOST_NAMES:
        raise ArgumentError(f"{name} has more than {_MOST_NAMES} names")
    return tuple(text(f"{name}[{place}]", item) for place, item in enumerate(listed))


def mapping(name: str, value: object) -> dict[str, Any]:
    """Return an argument that maps names to values, as a dictionary of its own.

    Args:
        name: how messages call the argument.
        value: a mapping whose keys are strings; None is an empty one.

    Raises:
        ArgumentError: it is anything else.
    """
    if value is None:
        return {}
    expected = "a mapping of names to values"
    if not isinstance(value, Mapping):
        raise ArgumentError(f"{name} is {described(value)}, expected {expected}")
    with _looking_at(name, expected):
        pairs = list(value.items())
    return {text(f"a key of {name}", key): item for key, item in pairs}


def numbers(name: str, value: object) -> Array:
    """Return an argument as an array of finite numbers, which shares no memory with it.

    Raises:
        ArgumentError: it is not numeric or not finite.
    """
    with _looking_at(name, "an array of real numbers"), np.errstate(all="ignore"):
        if isinstance(value, (bytes, bytearray)):
            raise TypeError(f"it is {described(value)}")
        array = np.asarray(value)
        if array.dtype.kind not in "iuf":
            raise TypeError(f"it is {described(value)}" if array.ndim == 0 else _type_of(array))
        masked = sys.modules.get("numpy.ma")  # Where nobody imported it, nothing is masked.
        if masked is not None and masked.is_masked(value):
            raise ValueError("some are masked")
        # What a longer type holds beyond a double's range becomes infinite here.
        array = array.astype(float)
    if not np.all(np.isfinite(array)):
        where = np.argwhere(~np.isfinite(array))[0].tolist()
        raise ArgumentError(f"{name} is not finite{f' at index {where}' if where else ''}")
    return array


def _type_of(array: Array) -> str:
    return f"its elements are of type {array.dtype}"


def vector(name: str, value: object, size: int) -> Array:
    """Return an argument as a vector of finite numbers."""
    array = numbers(name, value)
    if array.shape != (size,):
        raise ArgumentError(f"{name} has shape {array.shape}, expected ({size},)")
    return array


def samples(name: str, value: object, drives: int, count: int | None) -> Array:
    """Return drive positions, speeds or accelerations as `(N, d)`.

    Args:
        name: how messages call the argument.
        value: a number, `(N,)` for one drive, `(d,)` for one sample of d drives, or `(N, d)`.
        drives: number of drives d.
        count: number of samples N that single numbers are spread to; None if the argument
            itself decides.
    """
    array = numbers(name, value)
    given = array.shape
    if array.size == 0:
        raise ArgumentError(f"{name} is empty")
    if array.ndim == 0:
        array = np.full((1, drives), float(array))
    elif array.ndim == 1:
        array = array[:, None] if drives == 1 else array[None, :]
    if array.ndim != 2 or array.shape[1] != drives:
        wanted = "(N,)" if drives == 1 else f"(N, {drives})"
        raise ArgumentError(f"{name} has shape {given}, expected a number or {wanted}")
    if count is not None and len(array) != count:
        if len(array) != 1:
            raise ArgumentError(f"{name} has {len(array)} samples, position has {count}")
        array = np.repeat(array, count, axis=0)
    return array
