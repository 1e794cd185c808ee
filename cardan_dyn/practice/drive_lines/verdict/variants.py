"""Variants: many designs of one line, as positions of its adjustable joints."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ....kit.arrays import Array
from ....kit.checks import mapping, numbers
from ....kit.errors import ArgumentError, ModelError, choices
from ....kit.frozen import FrozenDict
from ..line.data import LineData
from ..line.parts import Shaft
from ..line.supports import spline_distance, supports

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


class Adjustable(NamedTuple):
    """A joint of the description that designs may move; see `closed_chain`.

    Attributes:
        kind: `joint_angle`, `joint_plane`, `fork_offset`, `shaft_length`, `tube_length`,
            `offset_y`, `offset_z`, `support_y` or `support_z`.
        of: number of the joint or shaft, or name of the bearing.
    """

    kind: str
    of: int | str

    @property
    def name(self) -> str:
        """Its name in the description, like `joint_angle_1` or `support_A_y`."""
        if isinstance(self.of, str):
            return f"support_{self.of}_{self.kind[-1]}"
        return f"{self.kind}_{self.of}"

    @property
    def unit(self) -> str:
        """Unit of its position: `rad` or `m`."""
        return "rad" if self.kind in ("joint_angle", "joint_plane", "fork_offset") else "m"

    @property
    def misaligns(self) -> bool:
        """Whether it moves shafts or bearings off their axes."""
        return self.kind.startswith(("offset", "support"))


class Variants(NamedTuple):
    """Designs of a line.

    Attributes:
        designs: their number D.
        moved: adjustable joints to their positions `(D,)` [rad or m], which count from the data.
        shafts: of the line.
    """

    designs: int
    moved: FrozenDict[Adjustable, Array]
    shafts: tuple[Shaft, ...]

    @property
    def held(self) -> FrozenDict[str, Array]:
        """Names of adjustable joints to their positions `(D,)` [rad or m]."""
        return FrozenDict({joint.name: values for joint, values in self.moved.items()})


def variants(
    line: LineData,
    *,
    angles: ArrayLike | None = None,
    planes: ArrayLike | None = None,
    fork_offsets: ArrayLike | None = None,
    lengths: ArrayLike | None = None,
    misalignments: Mapping[str, ArrayLike] | None = None,
) -> Variants:
    """Return D designs of the line, for `analyse`; what is not given is as in the data.

    Args:
        line: the line.
        angles: joint angles `(D, n)` [rad].
        planes: plane offsets `(D, n)` [rad]; see `Geometry`.
        fork_offsets: `(D, n - 1)` of the intermediate shafts [rad]; `(D, 1)` for all of them but
            the coupling pieces of centred joints.
        lengths: `(D, n - 1)` of the intermediate shafts [m]. Bearings stay at their distances
            from the joints at the fronts of their shafts, those behind a spline from the
            joints at the rears. Splines are drawn out, tubes without one longer; masses stay.
        misalignments: names of adjustable joints, see `closed_chain`, to positions `(D,)` [rad
            or m]: `offset_y_k` and `offset_z_k` move what lies behind shaft k across it,
            `support_A_y` and `support_A_z` a bearing.

    Raises:
        ArgumentError: a value is not finite or out of its range, or shapes do not match.
        ModelError: unknown adjustable joint.
    """
    found = line.geometry
    given: dict[Adjustable, Array] = {}
    if angles is not None:
        values = _columns("angles", angles, line.count)
        wrong = values[(values < 0.0) | (values >= np.pi / 2)]
        if wrong.size:
            raise ArgumentError(
                f"angles has {wrong[0]:.6g}, expected joint angles from 0 to below π/2 rad: a "
                "universal joint passes on no rotation at 90°"
            )
        given |= _differences("joint_angle", values, found.joint_angles)
    if planes is not None:
        values = _columns("planes", planes, line.count)
        given |= _differences("joint_plane", values, found.plane_offsets)
    if fork_offsets is not None:
        values = _columns("fork_offsets", fork_offsets, line.count - 1)
        if np.shape(fork_offsets)[-1:] != (line.count - 1,):
            # One offset for all forks is not meant for pieces that are one forging.
            inner = np.isin(np.arange(1, line.count), line.centred)
            values = np.where(inner, line.fork_offsets, values)
        given |= _differences("fork_offset", values, line.fork_offsets)
    if lengths is not None:
        values = _columns("lengths", lengths, line.count - 1)
        _check_lengths(line, values)
        changes = _differences("shaft_length", values, found.lengths[1:-1])
        rigid = [k for k, shaft in enumerate(line.shafts[1:-1], 1) if shaft.spline is None]
        given |= changes
        given |= {
            Adjustable("tube_length", k): changes[Adjustable("shaft_length", k)] for k in rigid
        }
    given |= _misaligned(line, misalignments, given)
    _check_centrings(line, given)
    counts = {len(values) for values in given.values() if len(values) != 1} or {1}
    if len(counts) > 1:
        raise ArgumentError(f"variants differ in number: {sorted(counts)}; give as many of each")
    count = counts.pop()
    if not count:
        raise ArgumentError("there are no designs; give one at least")
    moved = {joint: np.array(np.broadcast_to(item, (count,))) for joint, item in given.items()}
    return Variants(count, FrozenDict(moved), line.shafts)


def _check_centrings(line: LineData, given: Mapping[Adjustable, Array]) -> None:
    """Refuse designs that would move a coupling piece: its centring says where it lies."""
    for k in line.centred:
        held = {("joint_angle", k), ("joint_angle", k + 1), ("joint_plane", k + 1)}
        held |= {(kind, k) for kind in ("shaft_length", "tube_length", "offset_y", "offset_z")}
        for joint, values in given.items():
            if tuple(joint) in held and np.any(values):
                raise ArgumentError(
                    f"{joint.name} moves the coupling piece {line.shaft_names[k]}, which its "
                    "centring puts in its place; make a line of its own of each such design"
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


def _differences(kind: str, values: Array, nominal: Array) -> dict[Adjustable, Array]:
    """Return the positions of adjustable joints that make values of nominal ones."""
    return {
        Adjustable(kind, k): values[:, k - 1] - nominal[k - 1] for k in range(1, len(nominal) + 1)
    }


def _misaligned(
    line: LineData,
    misalignments: Mapping[str, ArrayLike] | None,
    given: Mapping[Adjustable, Array],
) -> dict[Adjustable, Array]:
    """Return the positions of single adjustable joints."""
    result = {}
    known = {joint.name: joint for joint in adjustables(line)}
    for name, values in mapping("misalignments", misalignments).items():
        if name not in known:
            raise ModelError(
                f"{name!r} is no adjustable joint of the line; these are: {choices(known, name)}",
                name=name,
            )
        if known[name] in given:
            raise ArgumentError(f"{name} is given twice: by its own name and with all of its kind")
        array = numbers(name, values)
        if array.ndim > 1:
            raise ArgumentError(f"{name} has shape {array.shape}, expected a value per design")
        result[known[name]] = np.atleast_1d(array)
    return result


def adjustables(line: LineData) -> list[Adjustable]:
    """Return the adjustable joints of a line's description."""
    found = []
    for k in range(1, line.count + 1):
        found += [Adjustable("joint_angle", k), Adjustable("joint_plane", k)]
    for k in range(1, line.count):
        kinds = ["fork_offset", "shaft_length", "offset_y", "offset_z"]
        kinds += ["tube_length"] if line.shafts[k].spline is None else []
        found += [Adjustable(kind, k) for kind in kinds]
    for item in supports(line).bearings:
        found += [Adjustable("support_y", item.name), Adjustable("support_z", item.name)]
    return found
