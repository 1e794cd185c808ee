"""Fitted: both ways of a transmission within ranges, with their errors, also as C."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from ...kit.arrays import Array
from ...kit.checks import file_path, interval, mapping, text, writing
from ...kit.errors import ArgumentError, ModelError, choices
from ...kit.frozen import frozen
from ..tape import function_name
from .maps import Maps
from .newton import FitError, FittedWay
from .printed import as_file
from .way import SolvedWay


class FittedTransmission(Maps):
    """A transmission within ranges, from `Transmission.fitted`; positions beyond are refused.

    Attributes:
        mechanism: name of the mechanism.
        ranges: each coordinate to its least and greatest position [rad or m].
        errors: `joints_of` and `actuated_of` to how far they are off, see `FitError`: the greatest
            of a thousand positions within and all corners of the range.
    """

    mechanism: str
    ranges: Mapping[str, tuple[float, float]]
    errors: Mapping[str, FitError]
    _forward: FittedWay
    _backward: FittedWay

    def __init__(self, mechanism: str, forward: FittedWay, backward: FittedWay) -> None:
        """Keep both ways of a mechanism, by its name."""
        ranges = {
            name: ends
            for way in (forward, backward)
            for name, *ends in zip(
                way.given.names, way.low.tolist(), way.high.tolist(), strict=True
            )
        }
        self._freeze(
            mechanism=mechanism,
            ranges=frozen({name: (low, high) for name, (low, high) in ranges.items()}),
            errors=frozen({"joints_of": forward.error, "actuated_of": backward.error}),
            _forward=forward,
            _backward=backward,
        )

    def __reduce__(self) -> tuple[object, ...]:
        return FittedTransmission, (self.mechanism, self._forward, self._backward)

    def __repr__(self) -> str:
        worst = max(error.position for error in self.errors.values())
        return (
            f"<FittedTransmission of {self.mechanism!r}: {', '.join(self.actuated)} <-> "
            f"{', '.join(self.joints)}, off by {worst:.1e}>"
        )

    def write_c(self, path: str | os.PathLike[str], name: str = "transmission") -> Path:
        """Write it as a file of C99 that needs nothing, in place of what the file contained.

        It has two functions, which return 0 and write `n` positions and `n * n` derivatives row by
        row (none where `jacobian` is 0), or return 1 and write nothing where a position is outside
        of the range, or no number, or loops do not close to rounding::

            int transmission_joints_of(const double *actuated, double *joints, double *jacobian);
            int transmission_actuated_of(const double *joints, double *actuated, double *jacobian);

        The first lines say names, units, ranges and errors. Efforts follow as in `joints_of`.

        Args:
            path: the file.
            name: with which both functions begin, an identifier of C.

        Raises:
            ArgumentError: no identifier, or the file cannot be written.
        """
        return write_c(path, name, lambda: self)

    def printed(self, name: str) -> str:
        """Return what `write_c` writes."""
        ways = {"joints_of": self._forward, "actuated_of": self._backward}
        return as_file(self.mechanism, name, ways)


def write_c(
    path: str | os.PathLike[str], name: str, made: Callable[[], FittedTransmission]
) -> Path:
    """Write what is made as C, see `FittedTransmission.write_c`.

    Path and name are refused first, since it may take long to make it.
    """
    target, own = file_path("path", path), function_name(text("name", name))
    with writing(target) as part, part.open("w", encoding="utf-8") as file:
        file.write(made().printed(own))
    return target


def fitted(
    name: str,
    ways: tuple[SolvedWay, SolvedWay],
    ranges: tuple[object, object],
) -> FittedTransmission:
    """Return both ways of a mechanism, by its name, within ranges; see `Transmission.fitted`."""
    made = [FittedWay(way, *_range(way, given)) for way, given in zip(ways, ranges, strict=True)]
    return FittedTransmission(name, *made)


def _range(way: SolvedWay, given: object) -> tuple[Array, Array]:
    """Return the least and the greatest positions `(n,)` of a way's given side.

    Raises:
        ModelError: a name of something else.
        ArgumentError: nothing says a range, or it is none.
    """
    side, stated = way.given, {} if given is None else mapping(way.given.role, given)
    if unknown := stated.keys() - set(side.names):
        raise ModelError(
            f"{side.role}: {choices(unknown)} is none of {choices(side.names, min(unknown))}",
            name=min(unknown),
        )
    rows = []
    for name, limits in zip(side.names, side.limits, strict=True):
        label = f"{side.role}[{name!r}]"
        if name not in stated and not np.all(np.isfinite([limits.lower, limits.upper])):
            raise ArgumentError(
                f"{label}: the description does not limit it on both sides; say between which "
                f"positions: {side.role}={{{name!r}: (low, high)}}"
            )
        rows.append(interval(label, stated.get(name, (limits.lower, limits.upper))))
    low, high = np.transpose(rows)
    return low, high
