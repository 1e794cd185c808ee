"""Quantities: what words of the command line mean, in SI units and radians."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ...core.elements.link_loads import Wrench
from ...core.mechanism.mechanism import Mechanism
from ...kit import units
from ...kit.errors import ArgumentError
from ...scene.usual_motion import slides
from .options import Words


def assigned(pairs: Sequence[str], option: str, form: str = "JOINT=VALUE") -> dict[str, str]:
    """Return names and texts from `NAME=TEXT`; the last equals sign separates.

    Raises:
        ArgumentError: a pair has another form, or a name comes twice; `option` and `form` are named
            in the message.
    """
    values: dict[str, str] = {}
    for pair in pairs:
        name, _, value = pair.rpartition("=")
        if not name or not value.strip():
            raise ArgumentError(f"{option} {pair!r} is not {form}")
        if name in values:
            raise ArgumentError(f"{option} {name} is given twice, {values[name]} and {value}")
        values[name] = value
    return values


_KINDS = {
    "position": (("angle", "deg"), ("length", "m")),
    "speed": (("speed", "1/min"), ("velocity", "m/s")),
    "acceleration": (("angular_acceleration", "rad/s²"), ("acceleration", "m/s²")),
    "effort": (("torque", "N·m"), ("force", "N")),
}
"""What there is of a coordinate, to the dimension and the unit of a bare number: of one that turns,
and of a slide."""


def value_of(mechanism: Mechanism, joint: str, what: str, text: str, option: str) -> float:
    """Return position, speed, acceleration or effort of a coordinate, in SI units and radians.

    A number without a unit is in degrees, 1/min, rad/s² or N·m, of slides in SI units.

    Args:
        mechanism: whose coordinate it is.
        joint: name of the coordinate.
        what: one of the four.
        text: a number with or without a unit.
        option: for messages.

    Raises:
        CardanError: the text has another form, or there is no such joint.
    """
    dimension, bare = _KINDS[what][slides(mechanism, joint)]
    return units.read(text, dimension, option, bare)


def ends_of(mechanism: Mechanism, joint: str, ends: Sequence[str]) -> tuple[float, float]:
    """Return the positions of `--range` [rad or m]; see `value_of`."""
    low, high = (value_of(mechanism, joint, "position", end, "--range") for end in ends)
    return low, high


def by_coordinate(
    mechanism: Mechanism, what: str, pairs: Sequence[str], option: str, form: str
) -> dict[str, float]:
    """Return what `value_of` does from `JOINT=VALUE`.

    Raises:
        CardanError: a pair has another form, which is told as `form`, or there is no such joint.
    """
    return {
        name: value_of(mechanism, name, what, text, f"{option} {name}")
        for name, text in assigned(pairs, option, form).items()
    }


def positions(
    mechanism: Mechanism, pairs: Sequence[str], option: str = "--held"
) -> dict[str, float]:
    """Return positions [rad or m] from `JOINT=VALUE`; see `by_coordinate`."""
    return by_coordinate(mechanism, "position", pairs, option, "JOINT=VALUE, as joint_angle=30")


def nearest(mechanism: Mechanism, pairs: Sequence[str]) -> dict[str, float] | str | None:
    """Return the positions near which loops are closed, or the name of a keyframe.

    Raises:
        CardanError: see `by_coordinate`.
    """
    if len(pairs) == 1 and "=" not in pairs[0]:
        return pairs[0]
    return positions(mechanism, pairs, "--near") or None


_SENSES = {"forward": 1, "backward": -1}
"""How a joint moves, and the sign of its speed."""


def efforts(
    mechanism: Mechanism,
    pairs: Sequence[str],
    ways: dict[str, tuple[float, int]] | None = None,
) -> dict[str, Any]:
    """Return efforts [N·m, of slides N] from `JOINT=VALUE`, and wrenches from `LINK=X Y Z`.

    Of a link, or a frame fixed in one, three numbers are a force [N], and three more a moment
    [N·m]: in its axes, or in those of the world if the word `world` is behind them.

    Args:
        mechanism: on which they act.
        pairs: as told.
        ways: takes what `JOINT=VALUE@forward` says, see `one_way`; refused if None.

    Raises:
        CardanError: see `value_of`, or a wrench has another form.
    """
    found: dict[str, Any] = {}
    for name, text in assigned(pairs, "--load", "JOINT=VALUE, as bearing_out=-5").items():
        at, (text, is_one_way, sense) = f"--load {name}", text.partition("@")
        if is_one_way:
            if ways is None or sense not in _SENSES:
                raise ArgumentError(
                    f"{at} acts @{sense}: loads of sweep and report may act while their joint "
                    "moves @forward or @backward, all others are constant"
                )
            ways[name] = value_of(mechanism, name, "effort", text, at), _SENSES[sense]
            continue
        if name in mechanism or name not in mechanism.link_frames:
            found[name] = value_of(mechanism, name, "effort", text, at)
            continue
        words = text.split()
        frame = words.pop() if words[-1] in ("link", "world") else "link"
        if len(words) not in (3, 6):
            raise ArgumentError(
                f"{at} is {text!r}: a link takes a force, three numbers, and perhaps a moment, "
                f'three more; write "{name}=0 0 -100", or "{name}=0 0 -100 world" in world axes'
            )
        force = [units.read(word, "force", at, "N") for word in words[:3]]
        moment = [units.read(word, "torque", at, "N·m") for word in words[3:]]
        found[name] = Wrench(force, moment or (0.0, 0.0, 0.0), frame)
    return found


def of_scene(
    mechanism: Mechanism,
    *,
    drive: Words = (),
    held: Sequence[str] = (),
    near: Sequence[str] = (),
    loads: Sequence[str] = (),
    gravity: tuple[float, float, float] | str | None = None,
    ways: dict[str, tuple[float, int]] | None = None,
) -> dict[str, Any]:
    """Return what options of several commands say of a scene, as `default_scene` takes it.

    `ways` takes loads that act one way, see `efforts`.

    Raises:
        CardanError: see `positions`, `nearest` and `efforts`.
    """
    return {
        "drive": drive,
        "held": positions(mechanism, held),
        "near": nearest(mechanism, near),
        "loads": efforts(mechanism, loads, ways),
        "gravity": gravity,
    }


def by_joint(
    values: Sequence[str], option: str, kind: tuple[str, str], mechanism: Mechanism
) -> float | Mapping[str, float]:
    """Return a number of all joints, or numbers by joint; VALUE is of those that have no other.

    Args:
        values: `VALUE` or `JOINT=VALUE`.
        option: for messages.
        kind: dimension, and the unit of numbers without one.
        mechanism: whose joints they are.

    Raises:
        CardanError: a value has another form, or there is no such joint.
    """
    plain = [value for value in values if "=" not in value]
    if len(plain) > 1:
        raise ArgumentError(f"{option} is {' and '.join(plain)}; of all joints it is one number")
    named = [value for value in values if "=" in value]
    given = {
        mechanism.joint(name).name: units.read(text, kind[0], f"{option} {name}", kind[1])
        for name, text in assigned(named, option).items()
    }
    if not plain:
        return given
    common = units.read(plain[0], kind[0], option, kind[1])
    return {**dict.fromkeys(mechanism.joints, common), **given} if given else common


def limits(pairs: Sequence[str]) -> dict[str, float | str]:
    """Return limits of a verdict from `NAME=VALUE`; what has a unit must say it.

    Raises:
        CardanError: a pair has another form, no unit or a wrong one.
    """
    from ..drive_lines.verdict.case import KNOWN

    dimensions = {units.plain(units.si(name)): name for name in units.DIMENSIONS}
    found: dict[str, float | str] = {}
    for name, text in assigned(pairs, "--limit", "NAME=VALUE, as residual_angle=3deg").items():
        dimension = dimensions[units.plain(KNOWN[name].unit)] if name in KNOWN else "number"
        if dimension != "number" and any(character.isdigit() for character in text):
            found[name] = units.read(text, dimension, f"--limit {name}")
            continue
        try:
            found[name] = float(text)
        except ValueError:
            if name in KNOWN and text[0].isdigit():
                raise ArgumentError(
                    f"--limit {name} is {text!r}, expected a finite number [1], as 0.7"
                ) from None
            found[name] = text  # The name of a constant, or what the verdict refuses.
    return found
