"""Checks of what a user hands to a scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from .coordinates import Array, Coordinates
from .errors import ArgumentError, choices
from .loads import LinkLoad
from .mechanism import Mechanism

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


@dataclass(frozen=True, eq=False)
class Wrench:
    """A wrench that acts on a link, for `Scene(loads={"link": Wrench(...)})`.

    Attributes:
        force: `(3,)` or `(N, 3)` [N].
        moment: `(3,)` or `(N, 3)` [N·m], about the link's origin.
        frame: `link` or `world`: the axes of both.
    """

    force: ArrayLike = (0.0, 0.0, 0.0)
    moment: ArrayLike = (0.0, 0.0, 0.0)
    frame: str = "link"


def numbers(name: str, value: object) -> Array:
    """Return an argument as an array of finite numbers.

    Raises:
        ArgumentError: it is not numeric or not finite.
    """
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "iuf":
            raise TypeError(f"of type {array.dtype}")
        array = array.astype(float)
    except (TypeError, ValueError) as error:
        raise ArgumentError(f"{name} is not an array of real numbers ({error})") from error
    if not np.all(np.isfinite(array)):
        where = np.argwhere(~np.isfinite(array))[0].tolist()
        raise ArgumentError(f"{name} is not finite{f' at index {where}' if where else ''}")
    return array


def vector(name: str, value: object, size: int) -> Array:
    """Return an argument as a vector of finite numbers."""
    array = numbers(name, value)
    if array.shape != (size,):
        raise ArgumentError(f"{name} has shape {array.shape}, expected ({size},)")
    return array


def samples(name: str, value: object, drives: int, count: int | None) -> Array:
    """Return drive positions, speeds or accelerations as `(N, d)`.

    Args:
        name: how messages call the argument.
        value: a number, `(N,)` for one drive, `(d,)` for one sample of d drives, or `(N, d)`.
        drives: number of drives d.
        count: number of samples N that single numbers are spread to; None if the argument
            itself decides.
    """
    array = numbers(name, value)
    given = array.shape
    if array.size == 0:
        raise ArgumentError(f"{name} is empty")
    if array.ndim == 0:
        array = np.full((1, drives), float(array))
    elif array.ndim == 1:
        array = array[:, None] if drives == 1 else array[None, :]
    if array.ndim != 2 or array.shape[1] != drives:
        wanted = "(N,)" if drives == 1 else f"(N, {drives})"
        raise ArgumentError(f"{name} has shape {given}, expected a number or {wanted}")
    if count is not None and len(array) != count:
        if len(array) != 1:
            raise ArgumentError(f"{name} has {len(array)} samples, position has {count}")
        array = np.repeat(array, count, axis=0)
    return array


def coordinate(mechanism: Mechanism, coordinates: Coordinates, name: object, role: str) -> int:
    """Return the column of a joint that a scene drives, holds or loads.

    Raises:
        ModelError: no such joint.
        ArgumentError: the joint has no single coordinate.
    """
    joint = mechanism.joint(name)
    if joint.size != 1:
        single = [item.name for item in mechanism.joints.values() if item.size == 1]
        raise ArgumentError(
            f"{role} {name!r} is a {joint.type} joint; joints with one coordinate: "
            f"{choices(single)}"
        )
    return coordinates.columns[joint.name].start


def held_positions(
    mechanism: Mechanism, coordinates: Coordinates, given: Mapping[str, object], role: str
) -> dict[str, float]:
    """Return positions of joints, from the argument called `role`."""
    positions = {}
    for name, value in given.items():
        coordinate(mechanism, coordinates, name, f"{role} joint")
        array = numbers(f"{role}[{name!r}]", value)
        if array.ndim:
            raise ArgumentError(
                f"{role}[{name!r}] has shape {array.shape}, expected a number; to move this joint, "
                "make it a drive"
            )
        positions[name] = float(array)
    return positions


def wanted_outputs(mechanism: Mechanism, outputs: Sequence[str] | None) -> tuple[str, ...]:
    """Return the names of the joints whose wrenches are kept."""
    if outputs is None:
        return tuple(mechanism.joints)
    names = (outputs,) if isinstance(outputs, str) else tuple(outputs)
    return tuple(dict.fromkeys(mechanism.joint(name).name for name in names))


def compliances(mechanism: Mechanism, given: Mapping[str, ArrayLike]) -> dict[str, Array]:
    """Return `(6, 6)` compliances of joints.

    Raises:
        ModelError: no such joint.
        ArgumentError: not 6 values or `(6, 6)`, not symmetric, or negative.
    """
    result = {}
    for name, value in given.items():
        mechanism.joint(name)
        array = numbers(f"compliance[{name!r}]", value)
        matrix = np.diag(array) if array.shape == (6,) else array
        if matrix.shape != (6, 6) or not np.allclose(matrix, matrix.T, rtol=1e-12, atol=0.0):
            raise ArgumentError(
                f"compliance[{name!r}] has shape {array.shape}; expected 6 values or a symmetric "
                "(6, 6), force first [m/N, rad/(N·m)]"
            )
        least = float(np.linalg.eigvalsh(matrix)[0])
        if least < -1e-12 * float(np.max(np.abs(matrix))):
            raise ArgumentError(f"compliance[{name!r}] is negative in some direction ({least:g})")
        result[name] = matrix
    return result


def split_loads(
    mechanism: Mechanism, coordinates: Coordinates, loads: Mapping[str, object]
) -> tuple[dict[str, Array], dict[str, LinkLoad]]:
    """Return efforts at joints and wrenches on links.

    Raises:
        ArgumentError: the name is neither a joint nor a link, the value has a wrong shape, or
            the wrench acts on a link that cannot move.
    """
    efforts: dict[str, Array] = {}
    wrenches: dict[str, LinkLoad] = {}
    for name, value in loads.items():
        label = f"loads[{name!r}]"
        as_wrench = isinstance(value, Wrench) or name not in mechanism.joints
        if not as_wrench:
            coordinate(mechanism, coordinates, name, "loaded joint")
            efforts[name] = numbers(label, value)
            if efforts[name].ndim > 1:
                raise ArgumentError(f"{label} has shape {efforts[name].shape}, expected (N,)")
        elif name in mechanism.links:
            wrenches[name] = _link_load(mechanism, name, label, value)
        else:
            raise ArgumentError(
                f"{label}: no joint or link has this name; joints: {choices(mechanism.joints)}; "
                f"links: {choices(mechanism.links)}"
            )
    return efforts, wrenches


def _link_load(mechanism: Mechanism, name: str, label: str, value: object) -> LinkLoad:
    body, frame = mechanism.link(name)
    if body == 0:
        raise ArgumentError(f"{label}: link {name!r} is fixed to the world; nothing can move it")
    if not isinstance(value, Wrench):
        array = numbers(label, value)
        if array.shape[-1:] != (6,) or array.ndim > 2:
            raise ArgumentError(
                f"{label} has shape {array.shape}; a link takes force and moment, (6,) or (N, 6)"
            )
        value = Wrench(array[..., :3], array[..., 3:])
    if value.frame not in ("link", "world"):
        raise ArgumentError(f"{label}: frame {value.frame!r} is unknown; frames: link, world")
    parts = []
    for part, given in (("force", value.force), ("moment", value.moment)):
        array = np.atleast_2d(numbers(f"{label}.{part}", given))
        if array.ndim != 2 or array.shape[1] != 3:
            raise ArgumentError(f"{label}.{part} has shape {np.shape(given)}, expected (3,)")
        parts.append(array)
    in_world = value.frame == "world"
    return LinkLoad(body - 1, frame.rotation, frame.translation, parts[0], parts[1], in_world)


def rows_of(load: LinkLoad, rows: slice) -> LinkLoad:
    """Return a link load for a block of samples."""
    return replace(
        load,
        **{
            part: getattr(load, part)[rows] if len(getattr(load, part)) > 1 else getattr(load, part)
            for part in ("force", "moment")
        },
    )
