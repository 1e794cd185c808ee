"""Errors of the package: one base class, and an error per kind of failure with its numbers.

Also how positions and names are written in messages and attributes.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np


class CardanError(Exception):
    """Base class of every error that this package raises on purpose.

    The message says what is wrong, where, and what to do. Keyword arguments of the constructor
    become attributes of the error, so that a script can react to them.

    Attributes:
        details: the keyword arguments of the constructor.
    """

    def __init__(self, message: str, **details: object) -> None:
        super().__init__(message)
        self.details = details

    def __getattr__(self, name: str) -> object:
        details = self.__dict__.get("details", {})
        if name in details:
            return details[name]
        raise AttributeError(f"{type(self).__name__} has no attribute {name!r}")


class ModelError(CardanError):
    """A description is malformed, or a name is given that it does not contain."""


class ArgumentError(CardanError, ValueError):
    """An argument has a wrong shape, is not finite or is out of its range."""


class ImmutableError(CardanError, AttributeError, TypeError):
    """Something was to be changed that cannot be changed; make another one instead."""


class AssemblyError(CardanError):
    """The loops cannot be closed at a position.

    Attributes:
        position: drive position at which the loops were to be closed [rad or m]; a number for one
            drive, `(d,)` for d drives; None where no drive position was at fault.
        nearest: nearest drive position that was reached on the branch, likewise; None where no
            branch was followed.
        residual: closure error that remained there, see `Sweep.loop_residual`.
    """


class SingularConfigurationError(CardanError):
    """The drive does not determine the motion at a position: a dead point, a locked joint.

    Attributes:
        position: drive position, a number for one drive, `(d,)` for d drives.
        condition: condition number of the closure equations there.
    """


class MobilityError(CardanError):
    """The drives do not match the mobility of the mechanism.

    Attributes:
        mobility: number of drives that the scene needs.
        free: names of the joints whose motion is not determined.
    """


class IndeterminateError(CardanError):
    """Requested components are statically indeterminate, and the scene is strict.

    Attributes:
        components: joint to the names of its statically indeterminate components.
    """


class AccuracyError(CardanError):
    """A result exceeds its tolerance and is therefore not returned.

    Attributes:
        residual: the residual that was too great; nan where it is not a matter of size.
        tolerance: its greatest permitted value.
        position: drive position of the worst sample, a number for one drive, `(d,)` for d drives;
            None where the error does not belong to a single sample.
    """


class MissingExtraError(CardanError):
    """An optional part of the package is not installed."""


def as_position(position: np.ndarray) -> float | np.ndarray:
    """Return a drive position `(d,)` as errors carry it: a number for one drive."""
    return float(position[0]) if len(position) == 1 else position


def choices(names: Iterable[str]) -> str:
    """Return valid names, sorted and with commas between them, for the end of a message."""
    listed = sorted(names)
    return ", ".join(listed) if listed else "none"


def as_text(position: Iterable[float]) -> str:
    """Return a drive position `(d,)` as text for a message, with 12 digits."""
    return ", ".join(f"{value:.12g}" for value in position)
