"""Geometry: where the shafts and joints of a line are, its joint angles, planes and fork phases.

World axes: x forward, y left, z up. The side view shows x and z, the plan view x and y. The slopes
of a shaft are its directions in these views, e = (1, tan slope_plan, tan slope_side) / |...|.

Frame k has x along shaft k, and bends chain the frames together: about x by the plane offset p_k,
so that y lies in the bending plane of joint k, then about z by the joint angle. Frame 0 has its y
axis horizontal, to the left. Angles about a shaft are positive by the right-hand rule about the
power flow; the catalogue's direction p of a bending plane, from up to the left, is the other way
round.

How pins and shafts stand while the input fork's pin is horizontal: the driving pin of a joint
stands at the angle γ from its bending plane, and the cross turns about it by a, the next shaft
about the driven pin by b: e' = (cos β, sin β cos γ, -sin β sin γ) is the next shaft's direction in
axes with x along the shaft and y along the pin. The rotation about y by a and then about z by b is
a swing of the shaft by β and a twist τ about it with tan(τ/2) = tan(a/2) tan(b/2): the lead of the
next shaft over this one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cardan_dyn.analytic import drive_line

from ....kit.arrays import EPS, NOTHING, ROUNDED, Array
from ....kit.errors import ModelError
from ....kit.frozen import read_only
from .parts import Shaft

MEETING = 1e-6
"""Greatest distance between points that are to be the same [m], and of fork phases from where rules
want them [rad]: below what anything is made to, and above what data are rounded to."""


@dataclass(frozen=True, eq=False)
class Geometry:
    """Where everything is in a line of n joints at rest; arrays cannot be written to.

    Attributes:
        directions: `(n + 1, 3)` unit vectors of the shafts along the power flow.
        lengths: `(n + 1,)` of the shafts [m]; NaN for an end shaft without one.
        centres: `(n, 3)` of the joints [m]. Joint 1 is the origin unless points say otherwise.
        joint_angles: `(n,)` [rad].
        plane_offsets: `(n,)` p_k, angle from the y axis of frame k - 1 to the bending plane of
            joint k: of joint 1 from the horizontal, of others from the bending plane before it, π
            in Z and 0 in W arrangements; 0 at a straight joint [rad].
        fork_phases: `(n,)` γ_k, angle from the bending plane of joint k to its input pin while
            the line's rotation is zero, that is while the input fork's pin is horizontal [rad].
            They are those of `analytic.drive_line`.
        frames: `(n + 1, 3, 3)` rotations that take components in frame k to world axes.
    """

    directions: Array
    lengths: Array
    centres: Array
    joint_angles: Array
    plane_offsets: Array
    fork_phases: Array
    frames: Array

    @property
    def views(self) -> Array:
        """Joint angles in the plan and in the side view, `(n, 2)` [rad]: differences of slopes.

        NaN for shafts that do not lead forward.
        """
        forward = np.where(self.directions[:, :1] > 0.0, self.directions[:, :1], np.nan)
        return np.diff(np.arctan(self.directions[:, 1:] / forward), axis=0)


def geometry(shafts: Sequence[Shaft]) -> Geometry:
    """Return the geometry of the shafts of a line.

    Raises:
        ModelError: lengths that are missing or do not meet, or a joint angle of 90° or more.
    """
    directions, lengths = _directions_and_lengths(shafts)
    centres = np.zeros((len(shafts) - 1, 3))
    for k in range(1, len(centres)):
        centres[k] = centres[k - 1] + lengths[k] * directions[k]
    centres += _placed(shafts, centres)
    angles, offsets, frames = _bends(shafts, directions)
    steps = math.pi / 2 + np.array([shaft.fork_offset for shaft in shafts[1:-1]]) - offsets[1:]
    phases = np.concatenate([[0.0 - offsets[0]], steps]).cumsum()
    arrays = (directions, lengths, centres, angles, offsets, phases, frames)
    return Geometry(*map(read_only, arrays))


def centring_places(shafts: Sequence[Shaft], found: Geometry, index: int) -> tuple[float, float]:
    """Return where the axes beside a coupling piece meet.

    Args:
        shafts: of the line.
        found: its geometry.
        index: of the shaft with the centring.

    Returns:
        Distances of the centring along the flow behind the joint before the piece, and before the
        joint behind it [m].
    """
    front, rear = found.joint_angles[index - 1 : index + 1]
    return _centring(shafts[index], float(found.lengths[index]), float(front + rear))[1:]


def _centring(piece: Shaft, length: float, angle: float) -> tuple[float, float, float]:
    """Return the angle of the joint before a coupling piece, and `centring_places`.

    By the sine rule in the triangle of both joints and the centring.
    """
    kind = piece.centring
    if kind is None or kind.kind == "disc" or kind.equal_at is None:
        arm = length / 2.0 / math.cos(angle / 2.0)
        return angle / 2.0, arm, arm
    fixed = length / 2.0 / math.cos(kind.equal_at / 2.0)
    sine = fixed * math.sin(angle) / length
    if sine >= 1.0:
        raise ModelError(
            f"angle of {math.degrees(angle):.6g}° between the shafts beside a coupling piece is "
            f"out of the reach of a centring made for {math.degrees(kind.equal_at):.6g}°; give a "
            "smaller one"
        )
    sliding = math.asin(sine)
    along = length * math.cos(sliding) - fixed * math.cos(angle)
    if kind.fixed_to == "rear":
        return sliding, along, fixed
    return angle - sliding, fixed, along


def called(shafts: Sequence[Shaft], index: int) -> str:
    """Return how messages call a shaft."""
    name = shafts[index].name
    return f"shafts[{index}]" + (f" ({name!r})" if name else "")


def direction(slope_side: float, slope_plan: float) -> Array:
    """Return the unit vector `(3,)` of a shaft with these slopes [rad] in both views."""
    vector = np.array([1.0, math.tan(slope_plan), math.tan(slope_side)])
    return np.asarray(vector / np.linalg.norm(vector))


def levelled(axis: Array) -> Array:
    """Return axes `(3, 3)`, as columns: along a shaft, horizontal to its left, and upwards.

    To the left of a shaft that is vertical is y.
    """
    left = np.array([-axis[1], axis[0], 0.0])
    size = float(np.hypot(*left[:2]))
    left = left / size if size > NOTHING else np.array([0.0, 1.0, 0.0])
    return np.stack([axis, left, np.cross(axis, left)], axis=1)


def _directions_and_lengths(shafts: Sequence[Shaft]) -> tuple[Array, Array]:
    directions, lengths = np.empty((len(shafts), 3)), np.full(len(shafts), np.nan)
    pieces = [index for index, shaft in enumerate(shafts) if shaft.centring is not None]
    for index, shaft in enumerate(shafts):
        at = called(shafts, index)
        if shaft.length is not None:
            lengths[index] = shaft.length
        if index in pieces:
            if index in (0, len(shafts) - 1) or shafts[index - 1].centring is not None:
                raise ModelError(
                    f"centring of {at}: a coupling piece lies between two shafts that are none"
                )
            if shaft.length is None:
                raise ModelError(f"{at} has no length; give the distance of its joints")
            continue
        if shaft.end is None:
            directions[index] = direction(shaft.slope_side or 0.0, shaft.slope_plan or 0.0)
            if shaft.length is None and 0 < index < len(shafts) - 1:
                raise ModelError(f"{at} has no length; give length, or the points start and end")
            continue
        span = np.subtract(shaft.end, _start(shafts, index))
        size = float(np.linalg.norm(span))
        if size <= MEETING:
            raise ModelError(f"{at} starts and ends at {shaft.end}; give two points")
        if shaft.length is not None and abs(size - shaft.length) > MEETING:
            raise ModelError(
                f"length = {shaft.length:.9g} m of {at} is not the distance {size:.9g} m between "
                "its points; leave out one of them"
            )
        directions[index], lengths[index] = span / size, size
    for index in pieces:
        before, behind = directions[index - 1], directions[index + 1]
        normal = np.cross(before, behind)
        sine = float(np.linalg.norm(normal))
        angle = math.atan2(sine, float(before @ behind))
        first = _centring(shafts[index], float(lengths[index]), angle)[0]
        across = np.cross(normal, before) / sine if angle > ROUNDED else np.zeros(3)
        directions[index] = math.cos(first) * before + math.sin(first) * across
        directions[index] /= np.linalg.norm(directions[index])
    return directions, lengths


def _start(shafts: Sequence[Shaft], index: int) -> tuple[float, float, float]:
    """Return the point where a shaft begins, which may be where the one before it ends."""
    shaft = shafts[index]
    if shaft.start is not None:
        return shaft.start
    before = shafts[index - 1].end if index else None
    if before is None:
        raise ModelError(
            f"end of {called(shafts, index)} is given, but not where it begins; give start"
        )
    return before


def _placed(shafts: Sequence[Shaft], centres: Array) -> Array:
    """Return by how much all centres `(n, 3)` are to be moved to where points say `(3,)`."""
    given = [
        (index, end, point)
        for index, shaft in enumerate(shafts)
        for end, point in ((0, shaft.start), (1, shaft.end))
        if point is not None and 0 <= index - 1 + end < len(centres)
    ]
    if not given:
        return np.zeros(3)
    index, end, point = given[0]
    shift = np.subtract(point, centres[index - 1 + end])
    for index, end, point in given:
        found = centres[index - 1 + end] + shift
        gap = float(np.linalg.norm(found - point))
        if gap > MEETING:
            raise ModelError(
                f"{('start', 'end')[end]} = {point} of {called(shafts, index)} is {gap:.6g} m from "
                f"the centre of joint {index + end}, {tuple(float(x) for x in found.round(9))}, to "
                "which the other shafts lead; shafts have to meet in the centres of their joints"
            )
    return shift


def _bends(shafts: Sequence[Shaft], directions: Array) -> tuple[Array, Array, Array]:
    """Return joint angles `(n,)`, plane offsets `(n,)` and frames `(n + 1, 3, 3)`."""
    count = len(directions) - 1
    angles, offsets, frames = np.zeros(count), np.zeros(count), np.empty((count + 1, 3, 3))
    frames[0] = levelled(directions[0])
    for k in range(count):
        before, after = directions[k], directions[k + 1]
        normal = np.cross(before, after)
        sine = float(np.linalg.norm(normal))
        angle = math.atan2(sine, float(before @ after))
        if angle >= math.pi / 2 - ROUNDED:
            raise ModelError(
                f"joint {k + 1} between {called(shafts, k)} and {called(shafts, k + 1)} has an "
                f"angle of {math.degrees(angle):.6g}°; a universal joint passes on no rotation at "
                "90°, and angles have to be less"
            )
        if angle > ROUNDED:  # The rounding of directions has no plane.
            normal /= sine
            angles[k] = angle
            # 0.0 - x is never -0.0, so that a W arrangement has +π.
            offsets[k] = math.atan2(0.0 - normal @ frames[k, :, 1], normal @ frames[k, :, 2])
        else:
            normal = frames[k, :, 2]
        across = np.cross(normal, after)
        across /= np.linalg.norm(across)
        frames[k + 1] = np.stack([after, across, np.cross(after, across)], axis=1)
    return angles, offsets, frames


class Zero(NamedTuple):
    """Where pins and shafts stand.

    Attributes:
        driving: `(n,)` turns of the crosses about the driving pins [rad], 0 in a straight joint.
        driven: `(n,)` turns of the next shafts about the driven pins [rad].
        rotations: `(n + 1,)` rotations of the shafts from frame k, counted from where their front
            fork's pin is along z; of the input shaft, from where its fork's pin is along y [rad].
    """

    driving: Array
    driven: Array
    rotations: Array


def zero(found: Geometry, fork_offsets: Array, even: Sequence[bool] | Array = ()) -> Zero:
    """Return how the pins and shafts of a line stand while the input fork's pin is horizontal.

    Args:
        found: geometry of the line.
        fork_offsets: `(n - 1,)` see `Shaft` [rad].
        even: see `standing`.
    """
    return standing(found.joint_angles, found.plane_offsets, fork_offsets, np.zeros(()), even)


def standing(
    joint_angles: Sequence[Array] | Array,
    plane_offsets: Sequence[Array] | Array,
    fork_offsets: Sequence[Array] | Array,
    rotation: Array,
    even: Sequence[bool] | Array = (),
) -> Zero:
    """Return how pins and shafts stand in samples `(…)`, which come first in what is returned.

    Args:
        joint_angles: of n joints, each of a shape that broadcasts with the samples [rad].
        plane_offsets: likewise.
        fork_offsets: of the intermediate shafts, likewise; see `Shaft` [rad].
        rotation: of the input shaft, from where its fork's pin is along y; likewise.
        even: which joints are those of constant velocity; none unless given. Of these both turns
            are those of the front half, which bends by half the joint angle.
    """
    driving, driven, rotations = [], [], [rotation]
    for k, (beta, plane) in enumerate(zip(joint_angles, plane_offsets, strict=True)):
        pin = rotations[k] - plane
        if k:
            pin = pin + (np.pi / 2 + fork_offsets[k - 1])
        is_even = len(even) and even[k]
        bend = beta / 2.0 if is_even else beta
        along, across = np.sin(bend) * np.cos(pin), np.sin(bend) * np.sin(pin)
        # The arc sine would lose digits towards 90°.
        driven.append(np.arctan2(along, np.hypot(across, np.cos(bend))))
        driving.append(np.arctan2(across, np.cos(bend)))
        rotations.append(pin if is_even else pin + lead(driving[k], driven[k]))
    return Zero(*(_last(item) for item in (driving, driven, rotations)))


def _last(arrays: Sequence[Array]) -> Array:
    """Return arrays that broadcast, side by side on a last axis."""
    return np.stack(np.broadcast_arrays(*arrays), axis=-1)


def lead(driving: Array | float, driven: Array | float) -> Array:
    """Return by how much a shaft leads the one before it, from the turns about both pins [rad].

    2 atan(tan(a/2) tan(b/2)), exact for joint angles below 90°.
    """
    return np.asarray(2.0 * np.arctan(np.tan(np.divide(driving, 2)) * np.tan(np.divide(driven, 2))))


def residual_angles(betas: Array, phases: Array) -> Array:
    """Return the residual angles behind all joints `(..., n)` [rad].

    Their squares are differences of those of joint angles: what is within the rounding of these,
    is 0.

    Args:
        betas: `(n,)` joint angles [rad].
        phases: `(..., n)` fork phases [rad].
    """
    ends = np.arange(1, len(betas) + 1)
    found = np.stack(
        [drive_line.residual_angle(betas[:end], phases[..., :end]) for end in ends], axis=-1
    )
    rounding = 4.0 * EPS * ends * np.cumsum(np.square(betas))
    return np.where(found**2 <= rounding, 0.0, found)
