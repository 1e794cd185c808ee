"""Checks of single arguments: each returns a plain value of the expected type, or raises an error.

Arguments may be objects of any class and raise anything when they are compared, iterated or made an
array. Callers get an `ArgumentError` in any case, whose message says what was expected.
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Iterable, Iterator, KeysView, Mapping, Set
from contextlib import contextmanager, suppress
from itertools import islice
from pathlib import Path
from stat import S_IMODE, S_ISREG
from typing import Any

import numpy as np

from .arrays import Array
from .errors import ArgumentError, CardanError

_MOST_NAMES = 100_000
"""Greatest number of names that is read, since an iterator may never end."""
_FLOAT, _NO_NUMBERS = np.dtype(float), np.empty(0, dtype=object)
_LONGEST_REASON = 200
"""Characters of another error's message that are quoted, since it may be of any length."""
_LONGEST_VALUE = 80
"""Characters of a value that are quoted in a message: less than a line."""
_LONGEST_NAME = 255
"""Bytes of the longest name of a file."""
_SYMMETRIC = 1e-12
"""Relative difference of mirrored entries of a matrix that counts as rounding of the numbers that
were given, which may come from a file or from other matrices."""
_RIGID = 1e-6
"""Deviation of a placement's axes from unit vectors at right angles that counts as rounding of the
numbers given."""
_NEGATIVE = -1e-12
"""Least eigenvalue of a matrix, as a fraction of its greatest entry, that counts as the rounding of
a zero."""


@contextmanager
def _reading(name: str, expected: str) -> Iterator[None]:
    """Turn any error that an argument raises when it is read into an `ArgumentError`."""
    try:
        yield
    except ArgumentError:
        raise
    except Exception as error:
        raise ArgumentError(f"{name} is not {expected} ({_reason(error)})") from error


def _reason(error: Exception) -> str:
    """Return an error's message, cut and on one line; its type where the message itself fails."""
    try:
        return " ".join(str(error).split())[:_LONGEST_REASON] or type(error).__name__
    except Exception:
        return type(error).__name__


def described(value: object) -> str:
    """Return an argument for a message: its value if that is a plain one, else its type."""
    if value is None or isinstance(value, (bool, int, float, complex, str, bytes)):
        try:
            return shortened(repr(value))
        except Exception:  # A number of too many digits, a class that overrides repr.
            return f"of type {type(value).__name__}"
    if isinstance(value, np.ndarray):
        return f"an array of type {value.dtype}"
    if isinstance(value, type):
        return f"the class {value.__name__} itself"
    return f"of type {type(value).__name__}"


def shortened(text: str, most: int = _LONGEST_VALUE) -> str:
    """Return a text cut to a greatest number of characters."""
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


def file_path(name: str, value: object) -> Path:
    """Return an argument that must be a path, a string or what `os.fspath` makes one of.

    Raises:
        ArgumentError: it is neither.
    """
    with _reading(name, "a path"):
        if isinstance(value, (str, os.PathLike)):
            return Path(value)
    raise ArgumentError(f"{name} is {described(value)}, expected a path")


@contextmanager
def writing(target: Path) -> Iterator[Path]:
    """Give a path to write to that becomes a file once all is written; nothing is left of a part.

    Whoever is interrupted, or runs out of space, keeps the file that was there before. For what is
    no file, such as a directory or a pipe, it is the path itself.

    Args:
        target: the file, or a directory that is made.

    Raises:
        ArgumentError: it cannot be written.
    """
    part = target
    try:
        real = Path(os.path.realpath(target))  # A link stays one.
        name = f".{real.name}.{os.getpid()}.part{real.suffix}"
        mode = real.stat().st_mode if real.exists() else None
        if mode and S_ISREG(mode):
            real.open("ab").close()  # Whether it may be changed at all.
        if (not mode or S_ISREG(mode)) and len(os.fsencode(name)) <= _LONGEST_NAME:
            part = real.with_name(name)
        yield part
        if part != target and part.is_file():
            if mode:
                part.chmod(S_IMODE(mode))
            part.replace(real)
            part = target
    except CardanError:
        raise
    except (OSError, ValueError) as error:  # Characters that no name of a file has, for one.
        told = str(error).replace(str(part), str(target))
        raise ArgumentError(f"{target}: cannot be written ({told})") from error
    finally:
        if part != target:
            with suppress(OSError, ValueError):
                part.unlink(missing_ok=True)


def whole(name: str, value: object, least: int = 1, most: int | None = None) -> int:
    """Return an argument that is a whole number.

    Args:
        name: how messages call the argument.
        value: an integer, Python's or NumPy's.
        least: smallest number that is accepted.
        most: greatest one; none unless given.

    Raises:
        ArgumentError: it is anything else.
    """
    # NumPy's durations are a subclass of its integers.
    is_whole = isinstance(value, (int, np.integer)) and not isinstance(
        value, (bool, np.timedelta64)
    )
    if not is_whole or value < least or (most is not None and value > most):  # type: ignore[operator]
        end = "on" if most is None else f"to {most}"
        raise ArgumentError(
            f"{name} is {described(value)}, expected a whole number from {least} {end}"
        )
    return int(value)  # type: ignore[call-overload]


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
            is refused, since it has no order.

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
    with _reading(name, expected):
        # An array of one name without a dimension is that name.
        items = [value.item()] if isinstance(value, np.ndarray) and not value.ndim else value
        listed = list(islice(items, _MOST_NAMES + 1))
    if len(listed) > _MOST_NAMES:
        raise ArgumentError(f"{name} has more than {_MOST_NAMES} names")
    return tuple(text(f"{name}[{index}]", item) for index, item in enumerate(listed))


def mapping(name: str, value: object) -> dict[str, Any]:
    """Return an argument that maps names to values, as a new dictionary.

    Args:
        name: how messages call the argument.
        value: a mapping whose keys are strings; None is an empty one.

    Raises:
        ArgumentError: it is anything else.
    """
    if value is None or (isinstance(value, dict) and not value):
        return {}
    expected = "a mapping of names to values"
    if not isinstance(value, Mapping):
        raise ArgumentError(f"{name} is {described(value)}, expected {expected}")
    with _reading(name, expected):
        pairs = list(value.items())
    return {text(f"a key of {name}", key): item for key, item in pairs}


def numbers(name: str, value: object) -> Array:
    """Return an argument as an array of finite numbers, which shares no memory with it.

    Args:
        name: how messages call the argument.
        value: anything that NumPy makes an array of integers or floats of.

    Raises:
        ArgumentError: it is not numeric or not finite.
    """
    kind = type(value)
    if kind is float and math.isfinite(value):  # type: ignore[arg-type]
        return np.array(value)  # What most arguments are left at.
    try:
        # Lists and plain arrays of floats, which most of the others are, need no questions.
        array: Array = np.array(value) if kind is list or kind is np.ndarray else _NO_NUMBERS
        if array.dtype is not _FLOAT:
            array = _as_floats(array if kind is list else value)
    except ArgumentError:
        raise
    except Exception as error:
        raise ArgumentError(f"{name} is not an array of real numbers ({_reason(error)})") from error
    finite = np.isfinite(array)
    if np.count_nonzero(finite) < array.size:
        index = np.argwhere(~finite)[0].tolist()
        raise ArgumentError(f"{name} is not finite{f' at index {index}' if index else ''}")
    return array


def _as_floats(value: object) -> Array:
    """Return numbers as an array of floats; the argument may raise anything while it is read."""
    if isinstance(value, (bytes, bytearray)):
        raise TypeError(f"it is {described(value)}")
    array = np.asarray(value)
    if array.dtype.kind not in "iuf":
        type_of_elements = f"its elements are of type {array.dtype}"
        raise TypeError(type_of_elements if array.ndim else f"it is {described(value)}")
    # Where nobody imported it, or another thread has just begun to, nothing is masked.
    masked = sys.modules.get("numpy.ma")
    if masked is not None and "is_masked" in masked.__dict__ and masked.is_masked(value):
        raise ValueError("some are masked")
    if array.dtype == float:
        return array.astype(float)
    with np.errstate(all="ignore"):
        # Numbers of longer types beyond a double's range become infinite here.
        return array.astype(float)


def number(name: str, value: object, least: float = -math.inf) -> float:
    """Return an argument that is one finite number.

    Args:
        name: how messages call the argument.
        value: see `numbers`.
        least: smallest number that is accepted.

    Raises:
        ArgumentError: it is not numeric, not finite, several numbers, or less.
    """
    array = numbers(name, value)
    if array.ndim:
        raise ArgumentError(f"{name} has shape {array.shape}, expected a number")
    found = float(array)
    if found < least:
        raise ArgumentError(f"{name} is {found:g}; it is not less than {least:g}")
    return found


def positive(name: str, value: object) -> float:
    """Return an argument that is one finite number greater than zero.

    Args:
        name: how messages call the argument.
        value: see `numbers`.

    Raises:
        ArgumentError: it is anything else.
    """
    found = number(name, value)
    if not found > 0.0:
        raise ArgumentError(f"{name} is {found:g}, expected a positive number")
    return found


def several(name: str, value: object) -> Array:
    """Return an argument that is a finite number or several, as an array `(N,)`, N at least 1.

    Args:
        name: how messages call the argument.
        value: see `numbers`.

    Raises:
        ArgumentError: it is not numeric, not finite, empty or of another shape.
    """
    array = np.atleast_1d(numbers(name, value))
    if array.ndim > 1 or not array.size:
        raise ArgumentError(f"{name} has shape {array.shape}, expected a number or several (N,)")
    return array


def positives(name: str, value: object) -> Array:
    """Return an argument that is a number greater than zero or several of them, see `several`.

    Args:
        name: how messages call the argument.
        value: see `numbers`.

    Raises:
        ArgumentError: as `several`, or one of them is not positive.
    """
    array = several(name, value)
    if not np.all(array > 0.0):
        raise ArgumentError(f"{name} holds {np.min(array):g}, expected positive numbers")
    return array


def vector(name: str, value: object, size: int) -> Array:
    """Return an argument as a vector `(size,)` of finite numbers.

    Args:
        name: how messages call the argument.
        value: see `numbers`.
        size: of the vector.

    Raises:
        ArgumentError: it is not numeric, not finite or has another shape.
    """
    array = numbers(name, value)
    if array.shape != (size,):
        raise ArgumentError(f"{name} has shape {array.shape}, expected ({size},)")
    return array


def interval(name: str, value: object) -> tuple[float, float]:
    """Return an argument that is a least and a greatest number.

    Raises:
        ArgumentError: they are none.
    """
    low, high = vector(name, value, 2).tolist()
    if not low < high:
        raise ArgumentError(f"{name}: {low:g} to {high:g} is no range")
    return low, high


def placement(name: str, value: object) -> Array:
    """Return an argument as a placement `(4, 4)`; a point `(3,)` has the axes of its frame.

    Args:
        name: how messages call the argument.
        value: see `numbers`; or a `pin.SE3`, which has the matrix as its `homogeneous`.

    Raises:
        ArgumentError: it is not finite, has another shape, or is not rigid.
    """
    array = numbers(name, getattr(value, "homogeneous", value))
    if array.shape == (3,):
        result = np.eye(4)
        result[:3, 3] = array
        return result
    if array.shape != (4, 4):
        raise ArgumentError(f"{name} has shape {array.shape}, expected (3,) or (4, 4)")
    rotation = array[:3, :3]
    is_rigid = (
        np.allclose(rotation @ rotation.T, np.eye(3), rtol=0.0, atol=_RIGID)
        and np.linalg.det(rotation) > 0.0
        and np.array_equal(array[3], [0.0, 0.0, 0.0, 1.0])
    )
    if not is_rigid:
        raise ArgumentError(
            f"{name} is no placement: a rotation (3, 3) beside a point, above 0, 0, 0, 1"
        )
    left, _, right = np.linalg.svd(rotation)
    array[:3, :3] = left @ right
    return array


def semidefinite(name: str, value: object, expected: str) -> Array:
    """Return an argument as a symmetric `(6, 6)` matrix without a negative direction.

    Args:
        name: how messages call the argument.
        value: 6 diagonal values, or `(6, 6)`.
        expected: order and units of the components, for messages.

    Raises:
        ArgumentError: not 6 values or `(6, 6)`, not finite, not symmetric, or negative.
    """
    array = numbers(name, value)
    matrix = np.diag(array) if array.shape == (6,) else array
    if matrix.shape != (6, 6):
        raise ArgumentError(
            f"{name} has shape {array.shape}; expected 6 values or a symmetric (6, 6), {expected}"
        )
    greatest = float(np.max(np.abs(matrix)))
    # With entries of order one, no product within the eigenvalues overflows.
    scaled = matrix / greatest if greatest > 0.0 else matrix
    if not np.allclose(scaled, scaled.T, rtol=_SYMMETRIC, atol=0.0):
        raise ArgumentError(f"{name} is not symmetric")
    least = float(np.linalg.eigvalsh(scaled)[0])
    if least < _NEGATIVE:
        raise ArgumentError(
            f"{name} is negative in some direction: its least eigenvalue is {least:.3g} "
            f"times its greatest value {greatest:.3g}"
        )
    return matrix
