"""Words: what a misspelled word of a description was meant to be."""

from __future__ import annotations

from collections.abc import Iterable

from ..errors import ModelError, choices

_LONG = 6
"""Letters from which on a word may have two mistakes; shorter ones may have one. Words of published
robots that mean something else are farther from URDF's: `gear_velocity`, `surface`, `rotor`."""


def similar_word(word: str, known: Iterable[str]) -> str | None:
    """Return the known word that a misspelled one stands for, if there is one."""
    mistakes = {other: _mistakes(word, other) for other in sorted(known)}
    allowed = 1 if len(word) < _LONG else 2
    nearest = min(mistakes, key=mistakes.__getitem__, default=None)
    if nearest is None or sorted(nearest) == sorted(word):
        return nearest
    return nearest if mistakes[nearest] <= allowed else None


def _mistakes(word: str, other: str) -> int:
    """Return how many letters are wrong, missing, too many or swapped with their neighbour."""
    above: list[int] = []
    row = list(range(len(other) + 1))
    for i, letter in enumerate(word, start=1):
        before, above, row = above, row, [i]
        for j, wanted in enumerate(other, start=1):
            cost = min(above[j] + 1, row[j - 1] + 1, above[j - 1] + (letter != wanted))
            if i > 1 and j > 1 and word[i - 2 : i] == other[j - 1] + other[j - 2]:
                cost = min(cost, before[j - 2] + 1)
            row.append(cost)
    return row[-1]


def unknown_keys(
    keys: Iterable[object], known: Iterable[str], where: str, strict: bool
) -> list[str]:
    """Return warnings about keys of a mapping that are not known.

    Args:
        keys: of the mapping.
        known: keys that it may have.
        where: how messages name the mapping.
        strict: whether to refuse keys that resemble known ones.

    Raises:
        ModelError: a key is misspelled.
    """
    known = sorted(known)
    unknown = dict.fromkeys(str(key) for key in keys if key not in known)
    for key in unknown if strict else ():
        similar = similar_word(key.lower(), known)
        if similar:
            raise ModelError(
                f"{where}: key {key!r} is unknown and would be passed over; did you mean "
                f"{similar!r}? keys: {choices(known)}; load(..., strict=False) passes it over"
            )
    return [f"{where}: {key} is unknown and was passed over" for key in unknown]
