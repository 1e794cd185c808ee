"""Reach: between which positions a drive can move, and errors for positions beyond.

Whoever follows a branch notices its end at a position that nobody asked for. Users are told of the
position that they asked for, and of what can be reached.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...errors import AssemblyError, CardanError, SingularConfigurationError, as_text
from .branch import Branch

_REACH_OF_SLIDE = 10.0
"""Characteristic lengths over which a sliding drive is followed to each side of the start before
its range counts as unlimited there. A slide that loops limit moves by about the lengths of their
links."""
_REACH_OF_ANGLE = 4.0 * np.pi
"""Displacement [rad] over which a turning drive that does not repeat is followed to find its
limits: they lie within a turn of each other, and the start lies less than a turn from them."""
_GREATEST_ANGLE = 2.0 * np.pi
"""Position [rad] beyond which a joint that cannot be reached was probably given in degrees."""
_ROUNDING = 1e-12
"""Limit [rad or m] below which it is written as zero: limits are found less exactly than that."""


class Aim(NamedTuple):
    """A position that was asked for.

    Attributes:
        who: what was to be brought there, and how, in words.
        position: of the drive or joint [rad or m].
        slides: whether it is a length.
        sample: index of it in a sweep; None elsewhere.
        joint: name of the held or started joint; None for drives.
    """

    who: str
    position: float
    slides: bool
    sample: int | None = None
    joint: str | None = None

    @property
    def hint(self) -> str:
        """A question whether degrees were meant, where that is likely."""
        return "" if self.slides else degrees_hint(self.position)


def degrees_hint(position: float) -> str:
    """Return what to add to a message if an angle [rad] was probably given in degrees."""
    if not abs(position) > _GREATEST_ANGLE:
        return ""
    return (
        f". Positions are in rad; if {position:g} degrees were meant, give "
        f"{np.deg2rad(position):.6g}"
    )


def reach_of(branch: Branch, slides: bool, length: float) -> tuple[float, float]:
    """Return the limits of a drive [rad or m], ±inf where it has none.

    Args:
        branch: of the drive.
        slides: whether it slides.
        length: characteristic length of the mechanism [m].
    """
    reach = _REACH_OF_SLIDE * length
    if not slides:
        try:
            if branch.find_period():
                return -np.inf, np.inf
        except (AssemblyError, SingularConfigurationError):
            pass  # It does not turn through; the limits say how far it goes.
        reach = _REACH_OF_ANGLE
    return branch.limit(branch.start - reach), branch.limit(branch.start + reach)


def out_of_reach(
    aim: Aim,
    error: AssemblyError | SingularConfigurationError,
    reach: tuple[float, float] | None = None,
) -> CardanError:
    """Return the error that says of a position asked for what is known of an end of the branch.

    Args:
        aim: the position that was asked for.
        error: that the end of the branch was reported with: an `AssemblyError` or a
            `SingularConfigurationError`.
        reach: limits of the drive, if they are known.
    """
    nearest, hints = nearest_of(error), aim.hint + error.hint
    where = "" if reach is None else f"; it moves {_between(reach)}"
    which = "" if aim.sample is None else f" (sample {aim.sample})"
    what = f"{aim.who} {aim.position:.9g}{which}"
    details = {**error.details, "joint": aim.joint, "sample": aim.sample, "reach": reach}
    if isinstance(error, SingularConfigurationError):
        return SingularConfigurationError(
            f"{what}{where}: position {_number(nearest)} is singular (condition "
            f"{error.condition:.1e}), {error.finding}; the way on is not unique. Stay on one "
            f"side of it, begin beyond it with near=, or choose another drive{hints}",
            **details,
        )
    return AssemblyError(
        f"{what}{where}: the nearest position that can be reached is {_number(nearest)}, where "
        f"{error.finding}{hints}",
        **{**details, "position": aim.position},
    )


def nearest_of(error: AssemblyError | SingularConfigurationError) -> object:
    """Return the nearest position that was reached on the way that an error ended."""
    return error.position if isinstance(error, SingularConfigurationError) else error.nearest


def all_out_of_reach(
    names: tuple[str, ...], driven: list[int], positions: Array, error: AssemblyError
) -> AssemblyError:
    """Return the error for a sample of several drives, or varied held joints, out of reach.

    Args:
        names: of the drives and held joints.
        driven: indices of those that are drives.
        positions: `(N, d)` of the sweep.
        error: with the sample, its position `(d,)` and the nearest that was reached `(d,)`.
    """
    asked, nearest = np.asarray(error.position), np.asarray(error.nearest)
    far = int(np.argmax(np.abs(asked - nearest)))
    which, where = "drive positions", ""
    if len(driven) < len(names):
        which, where = "positions", f" of {', '.join(names)}"
    role = "drive" if far in driven else "held joint"
    return AssemblyError(
        f"the loops cannot be closed at {which} {as_text(asked)}{where} (sample {error.sample} of "
        f"{len(positions)}); on the straight way there the nearest that were reached are "
        f"{as_text(nearest)}, where {role} {names[far]!r} has the farthest to go{error.hint}",
        **error.details,
    )


def _between(reach: tuple[float, float]) -> str:
    low, high = map(_number, reach)
    if np.isinf(reach[0]):
        return f"up to {high}"
    if np.isinf(reach[1]):
        return f"from {low} on"
    return f"only between {low} and {high}"


def _number(position: object) -> str:
    """Return a limit as text; what it is off from zero by rounding is left out."""
    value = float(position)  # type: ignore[arg-type]
    return f"{0.0 if abs(value) < _ROUNDING else value:.9g}"
