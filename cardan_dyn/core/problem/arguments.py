"""Arguments: what a user hands to a scene, checked against the mechanism."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...kit.arrays import Array, cardan_angles, cardan_quaternion
from ...kit.checks import (
    described,
    flag,
    mapping,
    names,
    numbers,
    semidefinite,
    several,
    shortened,
    text,
    vector,
)
from ...kit.errors import ArgumentError, MobilityError, choices
from ...kit.frozen import frozen
from ..elements.link_loads import LinkLoad, Wrench
from ..mechanism.joints import Joint
from ..mechanism.mechanism import Mechanism
from .coordinate_names import check_single, coordinates_of, each_coordinate
from .problem import Problem

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ..elements.element import Element

_MOST_TURNS = 1000.0
"""Turns from zero at which a joint may be held or start; it is followed through all of them."""
_MOST_LENGTHS = 6000.0
"""The same for slides, in lengths of the mechanism: a thousand turns are 6283 rad."""
_UNIT = 1e-6
"""Deviation of a quaternion's length from 1 that counts as rounding of the numbers given."""


def checked(
    mechanism: Mechanism,
    *,
    drive: str | Sequence[str] | None = None,
    free: str | Sequence[str] | None = None,
    held: Mapping[str, ArrayLike] | str | Sequence[str] | None = None,
    loads: Mapping[str, object] | None = None,
    gravity: ArrayLike | str | None = None,
    outputs: Sequence[str] | None = None,
    compliance: Mapping[str, ArrayLike] | None = None,
    strict: bool = False,
    near: Mapping[str, ArrayLike] | str | None = None,
    branch: str = "A",
    elements: Iterable[Element] | None = None,
) -> Problem:
    """Return the problem that a scene's arguments pose; see `Scene` for them and the errors."""
    if not isinstance(mechanism, Mechanism):
        raise ArgumentError(
            f"a scene needs a mechanism from load(), not {type(mechanism).__name__}"
        )
    is_keyframe = isinstance(near, str)
    near, loads = mapping("near", keyframe(mechanism, near)), mapping("loads", loads)
    held = by_coordinate(mechanism, "held", held_there(mechanism, held, near))
    if is_keyframe:
        near = {name: value for name, value in near.items() if name not in held}
    if drive is None and not free:
        drive = [name for name in mechanism.independent_coordinates if name not in held]
    in_list = drive is not None and not isinstance(drive, str)
    drive = each_coordinate(mechanism, names("drive", () if drive is None else drive))
    free = each_coordinate(mechanism, names("free", () if free is None else free))
    independent = (*drive, *free)
    efforts = [name for name, value in loads.items() if _is_effort(mechanism, name, value)]
    acting: tuple[Element, ...] = ()
    if elements is not None:
        from .element_arguments import elements_on, listed  # Most scenes have none.

        acting = listed(elements)
        efforts += [name for element in acting for name in element.joints]
    moving = (*independent, *held)
    mechanism = with_named(mechanism, (*moving, *near, *efforts), moving)
    if acting:
        acting = elements_on(mechanism, acting)
    held_at = held_positions(mechanism, held, "held")
    near_at, near_balls = near_positions(mechanism, near)
    for name in held_at.keys() & near_at.keys():
        if held_at[name] != near_at[name]:
            raise ArgumentError(
                f"joint {name!r} is held at {held_at[name]:g} and cannot start at "
                f"{near_at[name]:g}; leave it out of near"
            )
    joint_loads, link_loads = split_loads(mechanism, loads)
    return Problem(
        mechanism=mechanism,
        independent=_independent(mechanism, drive, free, held_at),
        listed=in_list,
        free=free,
        held=frozen(held_at),
        near=frozen(near_at),
        near_balls=frozen(near_balls),
        branch=text("branch", branch),
        joint_loads=frozen(joint_loads),
        link_loads=frozen(link_loads),
        gravity=(
            np.zeros(3)
            if gravity is None
            else vector("gravity", of_description(mechanism, gravity), 3)
        ),
        outputs=wanted_outputs(mechanism, outputs),
        all_outputs=outputs is None,
        compliance=frozen(compliances(mechanism, compliance)),
        strict=flag("strict", strict),
        elements=acting,
    )


def of_description(mechanism: Mechanism, gravity: object) -> object:
    """Return the gravity that an argument means: that of the description if it says so.

    Raises:
        ArgumentError: the description has none.
    """
    if not (isinstance(gravity, str) and gravity == "description"):
        return gravity
    if mechanism.description.gravity is None:
        raise ArgumentError(
            f"{mechanism.name}: gravity='description', and the description has none: <option "
            "gravity> of MJCF, <gravity> of a world of SDF and pin.Model.gravity are read; give "
            "gravity=(0, 0, -9.81)"
        )
    return mechanism.description.gravity


def keyframe(mechanism: Mechanism, near: object) -> object:
    """Return what `near` means: a keyframe of the description if it is the name of one.

    Raises:
        ArgumentError: the description has no keyframe of this name.
    """
    if not isinstance(near, str):
        return near
    keyframes = mechanism.description.keyframes
    if near not in keyframes:
        raise ArgumentError(
            f"near is {near!r}: {mechanism.name} has no keyframe {near!r}; keyframes of MJCF "
            f"and reference configurations: {choices(keyframes, near)}; or give a mapping of names "
            "of joints to positions"
        )
    return keyframes[near]


def with_named(mechanism: Mechanism, named: Iterable[str], moving: Iterable[str] = ()) -> Mechanism:
    """Return the mechanism in which balls are turns of which a coordinate is named.

    Args:
        mechanism: any variant of it.
        named: joints and coordinates.
        moving: adjustable joints that are not fixed; other names make no difference.
    """
    drivable, every = mechanism.base.drivable, set(named)
    # The slides of a floating joint are no angles of its ball.
    turning = (drivable[name] for name in every & drivable.keys() if not drivable[name].slides)
    adjusted = {name for name in moving if mechanism.is_adjustable(name)}
    return mechanism.variant({item.joint for item in turning}, adjusted)


def _independent(
    mechanism: Mechanism,
    drives: tuple[str, ...],
    free: tuple[str, ...],
    held: Mapping[str, float],
) -> tuple[str, ...]:
    """Return the names of the driven, then of the free joints and coordinates."""
    for role, given in (("drive", drives), ("free joint", free)):
        for name in given:
            check_single(mechanism, name, role)
    independent = (*drives, *free)
    if not independent:
        raise MobilityError(
            "a scene needs at least one coordinate that is driven or free; joints: "
            f"{choices(mechanism.drivable)}"
        )
    if len(set(independent)) != len(independent) or set(independent) & set(held):
        named = f"drives {list(drives)}, free {list(free)}, held {list(held)}"
        raise ArgumentError(f"a joint is either driven, free or held, and named once: {named}")
    return independent


def by_coordinate(mechanism: Mechanism, role: str, given: object) -> dict[str, Any]:
    """Return positions by coordinate, where those of a joint of several are given in a row.

    Args:
        mechanism: any variant of it.
        role: how messages call the argument.
        given: joints and coordinates to positions; joints of n coordinates to `(..., n)`, balls
            also to unit quaternions, as `Configuration.positions` has them. Other values stay.

    Raises:
        ArgumentError: no mapping, wrong numbers, or a coordinate that is given twice.
    """
    if not (several := mechanism.coordinates_together):
        return mapping(role, given)
    result: dict[str, Any] = {}
    for name, value in mapping(role, given).items():
        parts, coordinates = {name: value}, several.get(name)
        if coordinates and (value is None or np.ndim(value)):
            label = f"{role}[{name!r}]"
            columns = (
                [None] * len(coordinates)
                if value is None
                else _angles(mechanism, mechanism.joints[name], label, value)
            )
            parts = dict(zip(coordinates, columns, strict=True))
        if twice := result.keys() & parts.keys():
            raise ArgumentError(f"{role}: {choices(twice)} is given by itself and with its joint")
        result |= parts
    return result


def held_there(mechanism: Mechanism, held: object, near: object) -> object:
    """Return what holds joints: those of several coordinates, by names alone, where they start.

    Or else at zero.
    """
    listed, several = [held] if isinstance(held, str) else held, mechanism.coordinates_together
    if not isinstance(listed, list | tuple) or not listed:
        return held
    if not all(isinstance(name, str) and name in several for name in listed):
        return held  # Where one coordinate is held is said.
    at = by_coordinate(mechanism, "near", keyframe(mechanism, near))
    return {name: at.get(name, 0.0) for name in each_coordinate(mechanism, names("held", listed))}


def _angles(mechanism: Mechanism, joint: Joint, label: str, given: object) -> Array:
    """Return values `(n, ...)` of a joint's n coordinates from an array with them last."""
    rows = numbers(label, given)
    values = np.moveaxis(rows, -1, 0)
    if joint.has_ball and len(values) == joint.nv + 1:
        values = np.concatenate([values[:-4], cardan_angles(_unit(label, values[-4:]))])
    if len(values) != joint.nv:
        raise ArgumentError(
            f"{label} has shape {rows.shape}, expected (..., {joint.nv}); or "
            f"{coordinates_of(mechanism, joint.name)}"
        )
    return values


def _unit(label: str, quaternion: Array) -> Array:
    """Return quaternions `(4, ...)` at length 1, from which rounding alone takes them."""
    length = np.linalg.norm(quaternion, axis=0)
    if np.any(np.abs(length - 1.0) > _UNIT):
        raise ArgumentError(
            f"{label}: the quaternion {quaternion.tolist()} has length {np.max(length):g}, "
            "expected 1"
        )
    return np.asarray(quaternion / length)


def held_positions(mechanism: Mechanism, given: object, role: str) -> dict[str, float]:
    """Return positions of joints and coordinates, from the argument called `role`.

    Raises:
        ModelError: no such joint or coordinate.
        ArgumentError: no mapping, no number, or too far away to be followed to.
    """
    positions = {}
    for name, value in mapping(role, given).items():
        check_single(mechanism, name, f"{role} joint")
        label = f"{role}[{shortened(repr(name))}]"
        array = numbers(label, value)
        if array.ndim:
            raise ArgumentError(
                f"{label} has shape {array.shape}, expected a number; to move this joint, "
                "make it a drive"
            )
        check_distance(mechanism, name, label, float(array))
        positions[name] = float(array)
    return positions


def held_designs(held: Collection[str], given: object) -> dict[str, Array]:
    """Return positions `(D,)` of held joints in D designs, from the argument called `held`.

    Args:
        held: names of all joints that the scene holds.
        given: some of them to their positions, a number or several, as many for each.

    Raises:
        ArgumentError: no such mapping, or another joint.
    """
    designs = {
        name: several(f"held[{name!r}]", values) for name, values in mapping("held", given).items()
    }
    if len(set(map(len, designs.values()))) > 1:
        raise ArgumentError("held gives joints different numbers of positions")
    for name in designs:
        if name not in held:
            raise ArgumentError(f"{name!r} is not held by the scene, and cannot take positions")
    return designs


def near_positions(
    mechanism: Mechanism, given: object
) -> tuple[dict[str, float], dict[str, Array]]:
    """Return positions of coordinates, and unit quaternions `(4,)` of balls, from `near`.

    A joint of several coordinates may be given by all of them in a row, as
    `Configuration.positions` has it.

    Raises:
        ModelError: no such joint or coordinate.
        ArgumentError: no mapping, wrong numbers, or too far away to be followed to.
    """
    rest, balls = {}, {}
    for name, value in mapping("near", given).items():
        joint = mechanism.joints.get(name) if isinstance(name, str) else None
        if joint is None or joint.nv == 1 or not joint.coordinates or np.ndim(value) != 1:
            rest[name] = value
            continue
        row = _row(mechanism, joint, numbers(f"near[{name!r}]", value))
        columns = mechanism.coordinates.columns[name]
        scalars = [item for item in joint.coordinates if item in mechanism.coordinates.named]
        for coordinate in scalars:
            column = mechanism.coordinates.named[coordinate].column
            rest.setdefault(coordinate, row[column - columns.start])
        if len(scalars) < joint.nv:
            balls[name] = row[-4:]
    return held_positions(mechanism, rest, "near"), balls


def _row(mechanism: Mechanism, joint: Joint, values: Array) -> Array:
    """Return the coordinates of a joint as the mechanism has them: quaternion or angles."""
    columns = mechanism.coordinates.columns[joint.name]
    size = columns.stop - columns.start
    # Where a coordinate of a ball is named, it is three turns, and has no ball any more.
    turns = joint.type in ("spherical", "floating")
    has_quaternion = turns and len(values) == joint.nv + 1
    has_angles = turns and len(values) == joint.nv
    if len(values) != size and not (has_quaternion or has_angles):
        raise ArgumentError(
            f"near[{joint.name!r}] has shape {values.shape}, expected ({size},); or "
            f"{coordinates_of(mechanism, joint.name)}"
        )
    if has_angles and size > len(values):
        return np.concatenate([values[:-3], cardan_quaternion(values[-3:])])
    if not has_quaternion:
        return values
    quaternion = _unit(f"near[{joint.name!r}]", values[-4:])
    if size == len(values):
        return np.concatenate([values[:-4], quaternion])
    return np.concatenate([values[:-4], cardan_angles(quaternion)])


def check_distance(mechanism: Mechanism, name: str, label: str, position: float) -> None:
    """Refuse a position that is too far from zero to be followed to."""
    if not mechanism.drivable[name].slides:
        turns = abs(position) / (2.0 * np.pi)
        if turns > _MOST_TURNS:
            raise ArgumentError(
                f"{label} is {position:g} rad, {turns:.3g} turns; positions count whole turns, "
                f"{_MOST_TURNS:g} at most: take the angle within one turn"
            )
    elif abs(position) > _MOST_LENGTHS * mechanism.characteristic_length:
        raise ArgumentError(
            f"{label} is {position:g} m; joints slide {_MOST_LENGTHS:g} times the length of the "
            f"mechanism at most, which is {mechanism.characteristic_length:g} m"
        )


def wanted_outputs(mechanism: Mechanism, outputs: object) -> tuple[str, ...]:
    """Return the names of the joints whose wrenches are kept.

    Raises:
        ModelError: no such joint.
        ArgumentError: no sequence of names.
    """
    if outputs is None:
        return tuple(mechanism.joints)
    given = names("outputs", outputs)
    return tuple(dict.fromkeys(mechanism.joint(name).name for name in given))


def compliances(mechanism: Mechanism, given: object) -> dict[str, Array]:
    """Return `(6, 6)` compliances of joints.

    Raises:
        ModelError: no such joint.
        ArgumentError: not 6 values or `(6, 6)`, not symmetric, or negative.
    """
    result = {}
    for name, value in mapping("compliance", given).items():
        mechanism.joint(name)
        label = f"compliance[{name!r}]"
        result[name] = semidefinite(label, value, "force first [m/N, rad/(N·m)]")
    return result


def split_loads(
    mechanism: Mechanism, loads: object
) -> tuple[dict[str, Array], dict[str, LinkLoad]]:
    """Return efforts at joints and wrenches on links.

    Raises:
        ArgumentError: no mapping, the name is neither a joint nor a link, the value has a wrong
            shape, or the wrench acts on a link that cannot move.
    """
    efforts: dict[str, Array] = {}
    wrenches: dict[str, LinkLoad] = {}
    for name, value in mapping("loads", loads).items():
        label = f"loads[{shortened(repr(name))}]"
        if _is_effort(mechanism, name, value):
            check_single(mechanism, name, "loaded joint")
            if callable(value):
                raise ArgumentError(
                    f"{label} is not an array of real numbers but a function: Scene.simulate takes "
                    "such loads, or an Actuator among elements; a sweep takes a value for each "
                    "position"
                )
            efforts[name] = numbers(label, value)
            if not efforts[name].size:
                raise ArgumentError(f"{label} is empty")
        elif mechanism.is_adjustable(name) and name not in mechanism.links:
            check_single(mechanism, name, "loaded joint")
        elif name in mechanism.link_frames:
            wrenches[name] = _link_load(mechanism, name, label, value)
        else:
            known = choices(mechanism.link_frames, name)
            raise ArgumentError(
                f"{label}: no joint or link has this name; joints: "
                f"{choices(mechanism.drivable, name)}; links: {known}"
            )
    return efforts, wrenches


def _is_effort(mechanism: Mechanism, name: str, value: object) -> bool:
    """Return whether a load acts along a coordinate, not on a link.

    The names of joints come before those of links, and both before those of coordinates.
    """
    if isinstance(value, Wrench):
        return False
    is_coordinate = name not in mechanism.links and name.rpartition(".")[0] in mechanism
    return name in mechanism or is_coordinate


def _link_load(mechanism: Mechanism, name: str, label: str, value: object) -> LinkLoad:
    """Return a wrench on a link, checked."""
    body, frame = mechanism.link_frame(name)
    if body == 0:
        raise ArgumentError(f"{label}: link {name!r} is fixed to the world; nothing can move it")
    if not isinstance(value, Wrench):
        array = numbers(label, value)
        if array.shape[-1:] != (6,) or not array.size:
            raise ArgumentError(
                f"{label} has shape {array.shape}; a link takes force and moment, (6,) or (..., 6)"
            )
        value = Wrench(array[..., :3], array[..., 3:])
    if not isinstance(value.frame, str) or value.frame not in ("link", "world"):
        raise ArgumentError(
            f"{label}: frame {described(value.frame)} is unknown; frames: link, world"
        )
    force = _vectors(f"{label}.force", value.force)
    moment = _vectors(f"{label}.moment", value.moment)
    in_world, point = value.frame == "world", vector(f"{label}.point", value.point, 3)
    return LinkLoad(body - 1, frame.rotation, frame.translation, force, moment, in_world, point)


def _vectors(label: str, given: object) -> Array:
    """Return vectors `(..., 3)`."""
    array = numbers(label, given)
    if array.shape[-1:] != (3,) or not array.size:
        raise ArgumentError(f"{label} has shape {array.shape}, expected (3,) or (..., 3)")
    return array
