"""Kept: what was found out for a scene of a mechanism and serves its other scenes as well."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable
from typing import Any, TypeVar

MOST = 32
"""Values of a kind that are kept, those that were asked for last: more than a study has scenes that
differ in what moves, and few enough to be no matter of memory."""

_Value = TypeVar("_Value")


class Kept:
    """Values by all that they follow from. Nobody may change them, and threads may share them.

    They do not refer to the mechanism that keeps them, so that it goes with its last scene.
    """

    def __init__(self) -> None:
        self._values: dict[str, dict[Hashable, Any]] = {}
        self._lock = threading.Lock()

    def of(self, kind: str, key: Hashable, make: Callable[[], _Value], most: int = MOST) -> _Value:
        """Return what is known by a key; nothing is kept where making it raises.

        Args:
            kind: of value; others have keys of their own.
            key: all that the value follows from, besides the mechanism.
            make: makes it if it is not known.
            most: values of this kind that are kept.
        """
        with self._lock:
            values = self._values.setdefault(kind, {})
            if key in values:
                # Read again, it is the last one.
                values[key] = values.pop(key)
                return values[key]
        value = make()
        with self._lock:
            # Of those that threads make at the same time, all of them get the first.
            value = values.setdefault(key, value)
            if len(values) > most:
                del values[next(iter(values))]
        return value

    def part(self, key: Hashable) -> Kept:
        """Return values that follow from a key as well."""
        return self.of("part", key, Kept)

    def forget(self, *kinds: str) -> None:
        """Forget all values of some kinds, so that they are made again."""
        with self._lock:
            for kind in kinds:
                self._values.pop(kind, None)
