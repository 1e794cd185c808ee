"""Errors found in the sources: what is printed, what is right, and numbers that show it.

Three kinds are kept apart:

- "wrong": as printed it gives a wrong value;
- "scan": introduced by the scanning of the copy in circulation, or not to be told from that;
- "scope": right, but only under a condition that is not stated.

References:
    The documents named in each entry; `analytic.single_joint`, `thoma`, `grossmann`,
    `compound_angle`, `clearance` and `impact` cite them in full.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from ._data import read

__all__ = ["ERRATA", "Erratum", "PrintedNumber", "errata"]


@dataclass(frozen=True)
class PrintedNumber:
    """One number, as the printed statement gives it and as it is.

    `printed` is None where the printed statement gives no real number.
    """

    what: str
    printed: float | None
    right: float


@dataclass(frozen=True)
class Erratum:
    """One error of a source."""

    key: str
    source: str
    place: str
    kind: Literal["wrong", "scan", "scope"]
    printed: str
    right: str
    numbers: tuple[PrintedNumber, ...] = ()


def _erratum(key: str, numbers: Iterable[Mapping[str, Any]] = (), **words: Any) -> Erratum:
    compared = (PrintedNumber(item["what"], item.get("printed"), item["right"]) for item in numbers)
    return Erratum(key, **words, numbers=tuple(compared))


ERRATA: tuple[Erratum, ...] = tuple(
    _erratum(key, **row) for key, row in read("errata.toml").items()
)
"""All errors, in the order of the sources."""


def errata(source: str | None = None) -> tuple[Erratum, ...]:
    """Errors found in the sources, or in one of them.

    Args:
        source: name of a source as it stands in the table, or None for all.

    Returns:
        The entries, in the order of the sources.

    Raises:
        ValueError: no entry has this source.

    Source:
        `ERRATA`.

    >>> [erratum.place for erratum in errata("Grossmann 1939")]
    ['(8), second form']
    """
    if source is None:
        return ERRATA
    matching = tuple(erratum for erratum in ERRATA if erratum.source == source)
    if not matching:
        names = ", ".join(repr(name) for name in dict.fromkeys(e.source for e in ERRATA))
        raise ValueError(f"source = {source!r} is not one of {names}")
    return matching
