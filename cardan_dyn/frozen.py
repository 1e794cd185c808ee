"""Frozen: objects and mappings that cannot be changed, and arrays that cannot be written to."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NoReturn, TypeVar

import numpy as np

from .errors import ImmutableError

_Key = TypeVar("_Key")
_Value = TypeVar("_Value")


class Frozen:
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
