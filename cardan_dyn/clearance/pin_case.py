"""Pin case: which bearings of a universal joint have clearance, and what they are together."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..checks import names, positive, text
from ..errors import ArgumentError, ModelError
from ..problem.problem import Problem
from .arguments import of_joint
from .universal_joint import Bearing, UniversalPin, bearings_of, universal_pins

_LONGEST = 1e6
"""Ratio of a radius and the mechanism's length, either way, up to which rounding spares both."""


class PinCase(NamedTuple):
    """A universal joint with play in `B` bearings.

    Attributes:
        name: of the joint or its cross.
        pins: of its cross.
        bearings: that have play.
        opened: indices of the pins that have some of them.
        radii: `(2,)` from the joint's centre to the middle of the bearings [m].
        clearances: `(2,)` differences 2 s of the diameters of bush and pin [m].
        stiffnesses: `(2,)` of a bearing's contact [N/m]; all three are NaN of a pin without play.
    """

    name: str
    pins: tuple[UniversalPin, UniversalPin]
    bearings: tuple[Bearing, ...]
    opened: list[int]
    radii: Array
    clearances: Array
    stiffnesses: Array

    def shares(self, direction: Array) -> Array:
        """Return sizes `(B,)` of the bearings' forces along a unit direction `(2 B,)`."""
        return np.asarray(np.linalg.norm(direction.reshape(-1, 2), axis=1))

    def clearance(self, direction: Array) -> float:
        """Return the play 2 s of all bearings for forces along a direction `(2 B,)` [m].

        Forces that are in equilibrium do the same work as one in the bearing that carries most:
        the ways of bearings one behind the other add up, those beside each other are one.
        """
        shares = self.shares(direction)
        return float(np.max(shares) * (shares @ self.clearances[self._of]))

    def stiffness(self, direction: Array) -> float:
        """Return the stiffness of all bearings for forces along a direction `(2 B,)` [N/m]."""
        return 1.0 / float(np.sum(self.shares(direction) ** 2 / self.stiffnesses[self._of]))

    def closing(self, direction: Array) -> Array:
        """Return the motion `(2 B,)` that closes every bearing along its own force [m]."""
        sizes = np.repeat(self.shares(direction), 2)
        clearances = np.repeat(self.clearances[self._of], 2)
        return np.asarray(clearances * direction / np.where(sizes > 0.0, sizes, 1.0))

    def split(self, direction: Array, movable: Array) -> float:
        """Return the part of the play, as a fraction, that cannot close in all bearings at once.

        Args:
            direction: of the forces `(2 B,)`; a bearing counts as much as it carries.
            movable: `(2 B, f)` motions that the bearings can make together.
        """
        weight = np.repeat(self.shares(direction), 2)
        closing = self.closing(direction)
        wanted = weight * (closing / np.max(np.abs(closing)))
        ways = weight[:, None] * movable
        found = np.linalg.lstsq(ways, wanted, rcond=1e-9)[0]
        return float(np.linalg.norm(ways @ found - wanted) / np.linalg.norm(wanted))

    @property
    def _of(self) -> list[int]:
        return [bearing.pin for bearing in self.bearings]


def pin_case(
    problem: Problem,
    joint: str,
    given: Mapping[str, float | Mapping[str, float]],
    asked: str | Collection[str] | None,
) -> PinCase:
    """Return a checked case.

    Args:
        problem: of the scene.
        joint: of type `universal`, or the link that is the cross.
        given: `radius`, `clearance` and `stiffness`, of both pins or by name.
        asked: names of bearings, or of pins for both of theirs; all four if None.

    Raises:
        ArgumentError: a value is missing or out of range.
        ModelError: there is no such joint or bearing, or its pins are no outputs.
    """
    name = text("joint", joint)
    pins = universal_pins(problem.mechanism, name)
    for pin in pins:
        if pin.joint not in problem.outputs:
            raise ModelError(f"joint {pin.joint!r} is no output of the scene; name it there")
    wanted = tuple(pin.name for pin in pins) if asked is None else names("bearings", asked)
    bearings = bearings_of(pins, wanted)
    if not bearings:
        raise ArgumentError("bearings names none; leave it out for all four")
    opened = sorted({bearing.pin for bearing in bearings})
    values = np.full((3, 2), np.nan)
    for row, label in zip(values, ("radius", "clearance", "stiffness"), strict=True):
        for index in opened:
            row[index] = positive(*of_joint(label, given[label], pins[index].name))
    radii, clearances, stiffnesses = values
    length = problem.mechanism.characteristic_length
    _check_lengths(radii[opened], clearances[opened], length)
    return PinCase(name, pins, bearings, opened, radii, clearances, stiffnesses)


def _check_lengths(radii: Array, clearances: Array, length: float) -> None:
    """Refuse radii beside which the mechanism would be lost in rounding, or they in it.

    OpenPin that is as wide as that turns the joint by angles that are no longer small.

    Raises:
        ArgumentError: one is out of range.
    """
    low, high = length / _LONGEST, length * _LONGEST
    for radius, clearance in zip(radii.tolist(), clearances.tolist(), strict=True):
        if not low <= radius <= high:
            raise ArgumentError(
                f"radius is {radius:g} m; in a mechanism of {length:.3g} m it lies from {low:.3g} "
                f"to {high:.3g} m"
            )
        if not clearance < radius:
            raise ArgumentError(
                f"clearance is {clearance:g} m, no less than the radius of {radius:g} m at which "
                "it is"
            )
