"""Reach: errors for positions that cannot be reached, or at which loops cannot be closed.

Whoever follows a branch notices its end at a position that nobody asked for. Users are told of the
position that they asked for, and of what can be reached.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ....kit.arrays import Array
from ....kit.errors import (
    AssemblyError,
    CardanError,
    SingularConfigurationError,
    as_position,
    as_text,
)
from ...mechanism.mechanism import Mechanism
from ..closing.all_groups import ClosedState, Kinematics
from .singularities import gimbal_note, singularity_at


def degrees_hint(position: float, slides: bool = False) -> str:
    """Return what to add to a message if an angle [rad] was probably given in degrees."""
    if slides or not abs(position) > 2.0 * np.pi:
        return ""
    return (
        f". Positions are in rad; if {position:g} degrees were meant, give "
        f"{np.deg2rad(position):.6g}"
    )


def unclosed(
    mechanism: Mechanism,
    residual: float,
    positions: Mapping[str, float] | None = None,
    whose: str = "the joints of start",
) -> AssemblyError:
    """Return the error for loops that cannot be closed.

    Args:
        mechanism: the mechanism.
        residual: the least closure error that was found.
        positions: joints that were kept at their positions [rad or m], if any.
        whose: what these are, in words.
    """
    where, hint, around = "", "", "around the description's zero"
    advice = mechanism.description.remedy or "check the origins of joints and loops"
    if positions:
        listed = ", ".join(f"{name}: {value:g}" for name, value in positions.items())
        around = "there"
        where = f" with {whose} at their positions ({listed})"
        advice = "leave one of them out, or change it"
        slides = {name: mechanism.drivable[name].slides for name in positions}
        hints = (degrees_hint(value, slides[name]) for name, value in positions.items())
        hint = next(filter(None, hints), "")
    return AssemblyError(
        f"{mechanism.name}: the loops cannot be closed{where}; the least closure error found "
        f"{around} is {residual:.1e}, an angle [rad] or a gap in units of the characteristic "
        f"length, {mechanism.characteristic_length:.4g} m: {advice}{hint}",
        residual=residual,
    )


def out_of_reach(
    who: str,
    name: str,
    position: float,
    slides: bool,
    error: AssemblyError | SingularConfigurationError,
    sample: int | None = None,
    reach: tuple[float, float] | None = None,
) -> CardanError:
    """Return the error that says of a position asked for what is known of an end of the branch.

    Args:
        who: what the joint is, in words.
        name: of the joint.
        position: that was asked for [rad or m].
        slides: whether it is a length.
        error: that the end of the branch was reported with.
        sample: index of the position in a sweep.
        reach: limits of the drive, if they are known.
    """
    hints = degrees_hint(position, slides) + error.hint
    which = "" if sample is None else f" (sample {sample})"
    where = "" if reach is None else f"; it moves {_between(*reach)}"
    what = f"{who} {name!r} cannot be brought to {position:.9g}{which}{where}"
    joint = name if sample is None else None
    details = {**error.details, "joint": joint, "sample": sample, "reach": reach}
    nearest = _number(nearest_of(error))
    if isinstance(error, SingularConfigurationError):
        return SingularConfigurationError(
            f"{what}: position {nearest} is singular (condition {error.condition:.1e}), "
            f"{error.finding}; the way on is not unique. Stay on one side of it, begin beyond it "
            f"with near=, or choose another drive{hints}",
            **details,
        )
    return AssemblyError(
        f"{what}: the nearest position that can be reached is {nearest}, where "
        f"{error.finding}{hints}",
        **{**details, "position": position},
    )


def nearest_of(error: AssemblyError | SingularConfigurationError) -> float:
    """Return the nearest position that was reached on the way that an error ended."""
    is_singular = isinstance(error, SingularConfigurationError)
    return float(error.position if is_singular else error.nearest)  # type: ignore[arg-type, union-attr]


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


def beyond_line(
    kinematics: Kinematics,
    columns: list[int],
    target: Array,
    nearest: Array,
    sample: int,
) -> AssemblyError:
    """Return the error for drive positions that a straight line does not reach.

    Args:
        kinematics: that closed the loops.
        columns: columns of the drives in a row of coordinates.
        target: `(d,)` positions that were asked for [rad or m].
        nearest: `(size,)` closed coordinates where the line ended.
        sample: index of the target.
    """
    note = _gimbal_note(kinematics, nearest)
    return AssemblyError(
        f"the loops cannot be closed at drive positions {as_text(target)}; on the way there the "
        f"nearest that were reached are {as_text(nearest[columns])}{note}",
        position=target.copy(),
        nearest=nearest[columns].copy(),
        residual=_residual_at(kinematics, columns, target, nearest),
        sample=sample,
        hint=note,
    )


def beyond_branch(
    kinematics: Kinematics, column: int, target: float, nearest: float, nodes: Array, at_end: bool
) -> CardanError:
    """Return the error for a drive position behind the end of a branch.

    Args:
        kinematics: solves the branch.
        column: of the drive in a row of coordinates.
        target: the position [rad or m].
        nearest: where the branch ends.
        nodes: `(K, size)` closed coordinates on the way there.
        at_end: whether that is the position itself.
    """
    last = nodes[-1]
    singularity = singularity_at(kinematics, last, nodes[len(nodes) // 2])
    hint = _gimbal_note(kinematics, last)
    if singularity.modes_meet or at_end or len(nodes) == 1:
        condition = float(kinematics.evaluate(last[None, :]).condition[0])
        return SingularConfigurationError(
            f"the mechanism cannot be followed past drive position {nearest:.9g}: the closure "
            f"equations become singular there (condition {condition:.1e}), "
            f"{singularity.text}{hint}",
            position=nearest,
            condition=condition,
            hint=hint,
            **singularity.details,
        )
    residual = _residual_at(kinematics, [column], np.array([target]), last)
    return AssemblyError(
        f"the loops cannot be closed at drive position {target:.9g}; the nearest "
        f"position that can be reached is {nearest:.9g}, {singularity.text}{hint}",
        position=target,
        nearest=nearest,
        residual=residual,
        finding=singularity.text,
        hint=hint,
    )


def _residual_at(kinematics: Kinematics, columns: list[int], target: Array, last: Array) -> float:
    """Return how far loops stay open at a position beyond the last closed coordinates."""
    beyond = last[None, :].copy()
    beyond[:, columns] = target
    with np.errstate(all="ignore"):  # From afar steps may overflow.
        return float(kinematics.close(beyond).residual[0])


def open_at(
    position: Array, state: ClosedState, index: int, sample: int, stuck: tuple[str, ...]
) -> AssemblyError:
    """Return the error for loops that are not closed, or on another branch, at a sample.

    Args:
        position: `(d,)` of the drives.
        state: what closing them led to.
        index: of the sample in it.
        sample: index in the sweep.
        stuck: joints of an idle rod that may have kept them open.
    """
    residual, away = float(state.residual[index]), float(state.correction[index])
    rod = (
        f"; {', '.join(stuck)} hold a rod that may spin, and that cannot turn about its line "
        "to where it settles: describe three hinges that meet as one ball"
    )
    return AssemblyError(
        f"the loops cannot be closed on the branch at drive position {as_text(position)} (closure "
        f"error {residual:.1e}, {away:.1e} away from where the branch leads){rod * bool(stuck)}",
        position=as_position(position),
        nearest=None,
        residual=residual,
        sample=sample,
    )


def singular_at(
    kinematics: Kinematics,
    start: Array,
    position: Array,
    state: ClosedState,
    index: int,
    sample: int,
) -> SingularConfigurationError:
    """Return the error for a sample that is singular; `start (size,)` is not, others as above."""
    x, condition = state.x[index], float(state.condition[index])
    singularity, note = singularity_at(kinematics, x, start), _gimbal_note(kinematics, x)
    return SingularConfigurationError(
        f"drive position {as_text(position)} is singular (condition {condition:.1e}), "
        f"{singularity.text}; leave it out or choose another drive{note}",
        position=as_position(position),
        condition=condition,
        sample=sample,
        **singularity.details,
    )


def _gimbal_note(kinematics: Kinematics, x: Array) -> str:
    return gimbal_note(kinematics.coordinates, x, kinematics.passives.tolist())


def _between(low: float, high: float) -> str:
    if np.isinf(low):
        return f"up to {_number(high)}"
    if np.isinf(high):
        return f"from {_number(low)} on"
    return f"only between {_number(low)} and {_number(high)}"


def _number(value: float) -> str:
    """Return a limit as text; what rounds to zero among its digits is zero."""
    return "0" if abs(value) < 1e-12 else f"{value:.9g}"
