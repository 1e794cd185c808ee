"""Frozen: objects and mappings that cannot be changed, and arrays that cannot be written to."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn, TypeVar

import numpy as np

from .errors import ImmutableError, NoAttributeError

_Key = TypeVar("_Key")
_Value = TypeVar("_Value")


class Hinting:
    """Base class of objects that tell what is meant by attributes that they do not have."""

    _meant: ClassVar[Mapping[str, str]] = {}
    """Names that people try, those that mean the same separated by blanks, to what is meant."""

    if not TYPE_CHECKING:  # Types know all attributes; this is for those that are none.

        def __getattr__(self, name: str) -> NoReturn:
            if hasattr(type(self), name):
                # A property raised an AttributeError, which is told as it is.
                return object.__getattribute__(self, name)
            raise NoAttributeError(type(self), name, self.__dict__)


class Frozen(Hinting):
    """Base class of objects whose attributes cannot be set or deleted once `_freeze` was called.

    Constructors call it last, and may leave setting attributes to it, which is faster.
    """

    _is_frozen = False

    def _freeze(self, **attributes: object) -> None:
        self.__dict__.update(attributes, _is_frozen=True)

    def __setattr__(self, name: str, value: object) -> None:
        if self._is_frozen:
            self._refuse(name)
        object.__setattr__(self, name, value)

    def __delattr__(self, name: str) -> None:
        self._refuse(name)

    def _refuse(self, name: str) -> NoReturn:
        kind = type(self).__name__
        raise ImmutableError(f"{name} of a {kind} cannot be changed; make another {kind}")


class FrozenDict(dict[_Key, _Value]):
    """A dictionary that cannot be changed, its arrays included.

    Unlike `MappingProxyType`, it can be pickled.
    """

    def __init__(self, mapping: Mapping[_Key, _Value]) -> None:
        super().__init__(mapping)
        for value in mapping.values():
            if isinstance(value, np.ndarray):
                read_only(value)

    def _refuse(self, *_: object, **__: object) -> NoReturn:
        raise ImmutableError("this mapping cannot be changed; copy it with dict()")

    __setitem__ = __delitem__ = _refuse
    clear = pop = popitem = setdefault = update = __ior__ = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (dict(self),)

    def __str__(self) -> str:
        width = max((len(str(key)) for key in self), default=0)
        return "\n".join(f"{key!s:{width}}  {value}" for key, value in self.items())

    # What cannot be changed need not be copied.
    def __deepcopy__(self, memo: dict[int, object]) -> FrozenDict[_Key, _Value]:
        return self


def read_only(array: np.ndarray) -> np.ndarray:
    """Return the same array, which from now on cannot be written to."""
    array.setflags(write=False)
    return array


def frozen(mapping: Mapping[_Key, _Value]) -> FrozenDict[_Key, _Value]:
    """Return a copy of a mapping that cannot be changed; its arrays are made read-only as well."""
    return mapping if isinstance(mapping, FrozenDict) else FrozenDict(mapping)


class Record:
    """Base class of frozen dataclasses: arrays in their fields are read-only, in copies as well."""

    def __post_init__(self) -> None:
        # Written without calls: sweeps of one position make several records.
        for value in self.__dict__.values():
            if type(value) is np.ndarray:
                value.setflags(write=False)

    def __reduce__(self) -> tuple[Any, ...]:
        # Through the constructor, which closes the arrays of a copy to writing.
        items = fields(self)  # type: ignore[arg-type]
        given = {item.name: getattr(self, item.name) for item in items}
        if any(item.kw_only for item in items):
            return made, (type(self), given, {})
        return type(self), tuple(given.values())


def made(kind: Callable[..., _Value], given: dict[str, object], known: dict[str, object]) -> _Value:
    """Return a copy from its arguments, that knows what is known: `__reduce__` takes no names."""
    copy = kind(**given)
    copy.__dict__.update(known)
    return copy


class Value(Record):
    """A record that `==` compares by its contents.

    Fields declared with `compare=False` do not take part. Values hold arrays and lists of other
    values, of which no hash is computed: they cannot be keys of a dictionary.
    """

    def __eq__(self, other: object) -> bool:
        return self.agrees(other) if isinstance(other, Value) else NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def agrees(self, other: object, tolerance: float = 0.0) -> bool:
        """Return whether another value says the same up to rounding.

        Args:
            other: a value; anything else never agrees.
            tolerance: greatest difference of two numbers relative to the greatest number of their
                array; of a number that stands alone, relative to itself. 0 is what `==` demands.
        """
        return type(self) is type(other) and all(
            _agree(getattr(self, item.name), getattr(other, item.name), tolerance)
            for item in fields(self)  # type: ignore[arg-type]
            if item.compare
        )


def _agree(first: object, second: object, tolerance: float) -> bool:
    """Return whether two fields of values are the same up to a relative tolerance."""
    if isinstance(first, Value):
        return first.agrees(second, tolerance)
    if isinstance(first, tuple):
        return (
            isinstance(second, tuple)
            and len(first) == len(second)
            and all(_agree(a, b, tolerance) for a, b in zip(first, second, strict=True))
        )
    if isinstance(first, (float, np.ndarray)) and second is not None:
        a, b = np.asarray(first), np.asarray(second)
        if np.array_equal(a, b):
            return True
        # An infinite limit agrees with nothing but itself; the difference would be nan.
        if a.shape != b.shape or not (np.all(np.isfinite(a)) and np.all(np.isfinite(b))):
            return False
        return bool(np.max(np.abs(a - b)) <= tolerance * np.max(np.abs(a)))
    return first == second
