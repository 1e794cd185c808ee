"""Errors of the package: one base class, and an error per kind of failure with its numbers.

Also how positions and names are written in messages and attributes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import wraps
from types import MappingProxyType
from typing import TYPE_CHECKING, ParamSpec, TypeVar

if TYPE_CHECKING:
    import numpy as np


_MOST_LISTED = 10
"""Names that a message lists: those of a large mechanism would fill the screen."""
_LEAST_SIMILARITY = 0.6
"""Similarity from which on a name is suggested, see `difflib.get_close_matches`: its default."""


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
        self.__dict__.update(details)


class ModelError(CardanError):
    """A description is malformed, or a name is given that it does not contain.

    Attributes:
        name: the unknown name of a joint or link; None where it is something else.
    """

    name: str | None = None


class ArgumentError(CardanError, ValueError):
    """An argument has a wrong shape, is not finite or is out of its range."""


class ImmutableError(CardanError, AttributeError, TypeError):
    """Something was to be changed that cannot be changed; make another one instead."""


class AssemblyError(CardanError):
    """The loops cannot be closed at a position.

    Attributes:
        position: position at which the loops were to be closed, as it was asked for [rad or m]: of
            the drive, `(d,)` of d drives, or of `joint`. None where none was asked for.
        nearest: nearest position that was reached on the way there, likewise; None where the
            mechanism was not moved.
        residual: closure error that remained, see `Sweep.loop_residual`.
        finding: what ends the way there, in words; empty where it is not known.
        hint: what else the message says about it, for example of gimbal lock; mostly empty.
        joint: the held or started joint that was to be brought there; None where it is the drives.
        sample: index of the drive position among those of the sweep; None elsewhere.
        reach: lower and upper limit of the positions that can be reached; None where they are not
            known, ±inf where there is no limit.
    """

    position: float | np.ndarray | None = None
    nearest: float | np.ndarray | None = None
    residual: float = float("nan")
    finding: str = ""
    hint: str = ""
    joint: str | None = None
    sample: int | None = None
    reach: tuple[float, float] | None = None


class SingularConfigurationError(CardanError):
    """The drive does not determine the motion at a position: a dead point, meeting modes.

    Attributes:
        position: the singular position of the drive, `(d,)` of d drives, or of `joint`.
        condition: condition number of the closure equations there.
        joints: names of the coordinates, as in `Mechanism.drivable`, that lose their freedom there;
            none where assembly modes meet.
        moving: names of those that can move there while the drives rest.
        finding: the same in words; empty where it is not known.
        hint: what else the message says about it, for example of gimbal lock; mostly empty.
        joint: the held or started joint that was to be moved past it; None where it is the drives.
        sample: index of the drive position that was asked for in the sweep; None elsewhere.
        reach: lower and upper limit of the positions that can be reached; None where they are not
            known, ±inf where there is no limit.
    """

    position: float | np.ndarray | None = None
    condition: float = float("inf")
    joints: tuple[str, ...] = ()
    moving: tuple[str, ...] = ()
    finding: str = ""
    hint: str = ""
    joint: str | None = None
    sample: int | None = None
    reach: tuple[float, float] | None = None


class SimulationError(CardanError):
    """A simulation could not go on.

    Attributes:
        trajectory: the `Trajectory` up to there.
        time: when it ended [s].
    """

    trajectory: object = None
    time: float = float("nan")


class EquilibriumError(CardanError):
    """No equilibrium was found.

    Attributes:
        position: of the drives where the search ended `(d,)`.
        effort: what the drives still need there `(d,)`.
    """

    position: np.ndarray | None = None
    effort: np.ndarray | None = None


class VibrationError(CardanError):
    """No periodic motion was found.

    Attributes:
        speed: of the drive [rad/s].
    """

    speed: float = float("nan")


class MobilityError(CardanError):
    """The drives do not match the mobility of the mechanism.

    Attributes:
        mobility: number of drives that the scene needs; None where it was not determined.
        free: names of the coordinates whose motion is not determined, as in `Mechanism.drivable`.
        advised: names of coordinates that decide it, once they are driven or held as well.
        advice: in words, which of all that decide it are likely.
        surplus: names of drives and held joints, one of which is too many.
    """

    mobility: int | None = None
    free: Sequence[str] = ()
    advised: Sequence[str] = ()
    advice: str = ""
    surplus: Sequence[str] = ()


class IndeterminateError(CardanError):
    """Requested components are not unique, and the scene is strict.

    Statics does not determine them, or a coupling does not say which forces it exerts.

    Attributes:
        components: joint to the names of its components that are not unique.
    """

    components: Mapping[str, list[str]] = MappingProxyType({})


class AccuracyError(CardanError):
    """A result exceeds its tolerance and is therefore not returned.

    Attributes:
        residual: the residual that was too great; nan where it is not a matter of size.
        tolerance: its greatest permitted value.
        position: drive position of the worst sample, a number for one drive, `(d,)` for d drives;
            None where the error does not belong to a single sample.
    """

    residual: float = float("nan")
    tolerance: float = float("nan")
    position: float | np.ndarray | None = None


class MissingExtraError(CardanError):
    """An optional part of the package is not installed."""


class NoAttributeError(AttributeError):
    """There is no such attribute; the message, made when it is shown, says which one is meant.

    Attributes:
        kind: the class that does not have it.
    """

    def __init__(self, kind: type, name: str, own: Iterable[str] = ()) -> None:
        """Make the error.

        Args:
            kind: see the attribute.
            name: that was tried.
            own: names of attributes that the object has besides those of its class.
        """
        # With a name and without an object, Python adds no suggestion of its own.
        super().__init__(kind, name, name=name)
        self.kind, self._tried, self._own = kind, name, tuple(own)

    def __reduce__(self) -> tuple[object, ...]:
        return NoAttributeError, (self.kind, self._tried, self._own)

    def __str__(self) -> str:
        message = f"{self.kind.__name__} has no attribute {self._tried!r}"
        meant = guessed(self._tried, getattr(self.kind, "_meant", {}))
        if meant:
            return f"{message}; {meant}"
        names = [name for name in (*dir(self.kind), *self._own) if not name.startswith("_")]
        similar = _similar(self._tried, names)
        return f"{message}{similar}" if similar else f"{message}; see dir()"


def guessed(name: str, meant: Mapping[str, str]) -> str:
    """Return what is meant by a name that someone tried; empty if it is not known.

    Args:
        name: the name.
        meant: names that people try, those that mean the same separated by blanks, to what there
            is instead.
    """
    return next((told for names, told in meant.items() if name.lower() in names.split()), "")


_Given = ParamSpec("_Given")
_Returned = TypeVar("_Returned")


def hinting(
    meant: Mapping[str, str],
) -> Callable[[Callable[_Given, _Returned]], Callable[_Given, _Returned]]:
    """Return a decorator of functions, which tells of unknown arguments which one is meant.

    Args:
        meant: see `guessed`.
    """

    def decorate(function: Callable[_Given, _Returned]) -> Callable[_Given, _Returned]:
        @wraps(function)
        def call(*args: _Given.args, **kwargs: _Given.kwargs) -> _Returned:
            try:
                return function(*args, **kwargs)
            except TypeError as error:
                message = _of_unknown(function, kwargs, meant)
                if not message:
                    raise
                refused = TypeError(message)
                refused.__cause__ = error.__cause__
            raise refused

        return call

    return decorate


def _of_unknown(
    function: Callable[..., object], given: Mapping[str, object], meant: Mapping[str, str]
) -> str:
    """Return what to say of arguments that a function does not have; empty if it has them all."""
    from inspect import signature  # Imported here: only errors need it.

    known = [name for name in signature(function).parameters if name != "self"]
    unknown = next((name for name in given if name not in known), None)
    if unknown is None:
        return ""
    called = function.__qualname__.removesuffix(".__init__")
    told = guessed(unknown, meant)
    instead = told or f"arguments: {choices(known, unknown, most=len(known))}"
    return f"{called} has no argument {unknown!r}; {instead}"


def _similar(name: str, names: Iterable[str]) -> str:
    """Return a question after the most similar names, empty if none is."""
    _, _, question = choices(names, name, most=1).partition(" (did")
    return f" (did{question}" if question else ""


def as_position(position: np.ndarray) -> float | np.ndarray:
    """Return a drive position `(d,)` as errors carry it: a number for one drive."""
    return float(position[0]) if len(position) == 1 else position


def choices(
    names: Iterable[str],
    near: object = None,
    most: int = _MOST_LISTED,
    *,
    ranked: bool = False,
) -> str:
    """Return valid names, sorted and with commas between them, for the end of a message.

    Joints come before coordinates of joints, such as `ball.x`, which are seldom meant, and
    turns about axes behind positions along them, as in rows of a pose.

    Args:
        names: all of them.
        near: an unknown name, after which the message asks for the most similar valid ones.
        most: how many names are listed; the others are counted.
        ranked: whether they stay in their order.
    """
    listed = list(dict.fromkeys(names))
    if not ranked:
        listed.sort(key=lambda name: ("." in name, name.replace(".turn_", ".~")))
    if not listed:
        return "none"
    similar: list[str] = []
    if isinstance(near, str):
        from difflib import get_close_matches  # Imported here: only errors need it.

        similar = get_close_matches(near, listed, n=3, cutoff=_LEAST_SIMILARITY)
    # A single name takes no more room than "and 1 more".
    count = len(listed) if len(listed) <= most + 1 else most
    text = ", ".join(listed[:count])
    if count < len(listed):
        text += f" and {len(listed) - count} more"
    return f"{text} (did you mean {' or '.join(map(repr, similar))}?)" if similar else text


def as_text(position: Iterable[float]) -> str:
    """Return a drive position `(d,)` as text for a message, with 12 digits."""
    return ", ".join(f"{value:.12g}" for value in position)
