"""Arguments that raise whenever something reads them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np


class Exploding:
    """Raises whenever it is looked at, but for its name in a test's report."""

    def __repr__(self) -> str:
        return "Exploding()"

    def __getattr__(self, name: str) -> object:
        raise ZeroDivisionError(name)

    def __iter__(self) -> Iterator[str]:
        raise ZeroDivisionError("not to be iterated")

    def __array__(self, *_: object, **__: object) -> np.ndarray:
        raise ZeroDivisionError("no array")

    def __eq__(self, other: object) -> bool:
        raise ZeroDivisionError("not to be compared")

    __hash__ = None  # type: ignore[assignment]


class ExplodingMapping(dict[str, float]):
    """Raises when its items are read."""

    def items(self) -> object:  # type: ignore[override]
        raise ZeroDivisionError("no items")
