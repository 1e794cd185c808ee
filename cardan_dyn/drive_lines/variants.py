"""Variants: many designs of one line, as positions of its adjustable joints."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..arrays import Array
from ..checks import mapping, numbers
from ..errors import ArgumentError, ModelError, choices
from ..frozen import FrozenDict
from .line_data import LineData
from .parts import Shaft
from .supports import spline_distance, supports

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

_QUARTER = np.pi / 2


class Variants(NamedTuple):
    """Designs of a line.

    Attributes:
        designs: their number D.
        held: adjustable joints to their positions `(D,)` [rad or m], which count from the data.
        shafts: of the line.
    """

    designs: int
    held: FrozenDict[str, Array]
    shafts: tuple[Shaft, ...]


def variants(
    line: LineData,
    *,
    angles: ArrayLike | None = None,
    planes: ArrayLike | None = None,
    fork_offsets: ArrayLike | None = None,
    lengths: ArrayLike | None = None,
    misalignments: Mapping[str, ArrayLike] | None = None,
) -> Variants:
    """Return designs of a line; see `DriveLine.variants`."""
    found = line.geometry
    given: dict[str, Array] = {}
    if angles is not None:
        values = _columns("angles", angles, line.count)
        if not np.all((values >= 0.0) & (values < _QUARTER)):
            worst = values[~((values >= 0.0) & (values < _QUARTER))][0]
            raise ArgumentError(
                f"angles has {worst:.6g}, expected joint angles from 0 to below π/2 rad: a "
                "universal joint passes on no rotation at 90°"
            )
        given |= _differences("joint_angle", values, found.joint_angles)
    if planes is not None:
        values = _columns("planes", planes, line.count)
        given |= _differences("joint_plane", values, found.plane_offsets)
    if fork_offsets is not None:
        values = _columns("fork_offsets", fork_offsets, line.count - 1)
        given |= _differences("fork_offset", values, line.fork_offsets)
    if lengths is not None:
        values = _columns("lengths", lengths, line.count - 1)
        _check_lengths(line, values)
        changes = _differences("shaft_length", values, found.lengths[1:-1])
        rigid = [k for k, shaft in enumerate(line.shafts[1:-1], 1) if shaft.spline is None]
        given |= changes | {f"tube_length_{k}": changes[f"shaft_length_{k}"] for k in rigid}
    given |= _misaligned(line, misalignments, given)
    _check_centrings(line, given)
    sizes = {name: np.shape(value) for name, value in given.items()}
    counts = {shape[0] for shape in sizes.values() if shape != (1,)} or {1}
    if len(counts) > 1:
        raise ArgumentError(f"variants differ in number: {sorted(counts)}; give as many of each")
    count = counts.pop()
    if not count:
        raise ArgumentError("there are no designs; give one at least")
    held = {name: np.broadcast_to(value, (count,)) for name, value in given.items()}
    arrays = FrozenDict({name: np.array(value) for name, value in held.items()})
    return Variants(count, arrays, line.shafts)


def _check_centrings(line: LineData, given: Mapping[str, Array]) -> None:
    """Refuse designs that would move a coupling piece: its centring says where it lies."""
    for k in line.centred:
        for name in (
            *(f"joint_{what}_{joint}" for what in ("angle", "plane") for joint in (k, k + 1)),
            *(f"{what}_{k}" for what in ("shaft_length", "tube_length", "offset_y", "offset_z")),
        ):
            if np.any(given.get(name, np.zeros(1))) and name != f"joint_plane_{k}":
                raise ArgumentError(
                    f"{name} moves the coupling piece {line.shaft_names[k]}, which its centring "
                    "puts in its place; make a line of its own of each such design"
                )


def _check_lengths(line: LineData, values: Array) -> None:
    """Refuse lengths `(D, n - 1)` on which bearings and splines of the data have no room."""
    if not np.all(values > 0.0):
        raise ArgumentError(f"lengths has {np.min(values):.6g}, expected more than 0 m")
    for k, shaft in enumerate(line.shafts[1:-1], 1):
        least, what = (
            (0.0, "") if shaft.spline is None else (spline_distance(line, k), "its spline")
        )
        for item in supports(line).bearings if shaft.bearings else ():
            # A bearing behind the spline keeps its distance from the rear joint.
            length = float(line.geometry.lengths[k])
            room = length - item.distance if item.behind else item.distance
            if item.shaft == k and room > least:
                least, what = room, f"its bearing {item.name}"
        shortest = float(np.min(values[:, k - 1], initial=np.inf))
        if shortest < least:
            raise ArgumentError(
                f"lengths has {shortest:.6g} for {line.shaft_names[k]}, expected at least "
                f"{least:.6g} m, up to where {what} is"
            )


def _columns(name: str, values: ArrayLike, count: int) -> Array:
    """Return values as `(D, count)`."""
    array = numbers(name, values)
    if not count:
        raise ArgumentError(f"{name} is given, but a line of one joint has no intermediate shafts")
    if array.ndim < 2:
        array = array.reshape(1, -1)
    if array.ndim != 2 or array.shape[1] not in (1, count):
        raise ArgumentError(
            f"{name} has shape {np.shape(values)}, expected ({count},) or designs × {count}"
        )
    return np.broadcast_to(array, (len(array), count))


def _differences(name: str, values: Array, nominal: Array) -> dict[str, Array]:
    """Return the positions of adjustable joints `name_k` that make values of nominal ones."""
    return {f"{name}_{k}": values[:, k - 1] - nominal[k - 1] for k in range(1, len(nominal) + 1)}


def _misaligned(
    line: LineData, misalignments: Mapping[str, ArrayLike] | None, given: Mapping[str, Array]
) -> dict[str, Array]:
    """Return the positions of single adjustable joints."""
    result = {}
    known = adjustable_names(line)
    for name, values in mapping("misalignments", misalignments).items():
        if name not in known:
            raise ModelError(
                f"{name!r} is no adjustable joint of the line; these are: {choices(known, name)}",
                name=name,
            )
        if name in given:
            raise ArgumentError(f"{name} is given twice: by its own name and with all of its kind")
        array = numbers(name, values)
        if array.ndim > 1:
            raise ArgumentError(f"{name} has shape {array.shape}, expected a value per design")
        result[name] = np.atleast_1d(array)
    return result


def adjustable_names(line: LineData) -> list[str]:
    """Return the names of the adjustable joints of a line's description."""
    names = []
    for k in range(1, line.count + 1):
        names += [f"joint_angle_{k}", f"joint_plane_{k}"]
    for k in range(1, line.count):
        names += [f"fork_offset_{k}", f"shaft_length_{k}", f"offset_y_{k}", f"offset_z_{k}"]
        names += [f"tube_length_{k}"] if line.shafts[k].spline is None else []
    for item in supports(line).bearings:
        names += [f"support_{item.name}_y", f"support_{item.name}_z"]
    return names
