"""Zero: how pins and shafts of a line stand while the input fork's pin is horizontal.

The driving pin of a joint stands at the angle γ from its bending plane, and the cross turns about
it by a, the next shaft about the driven pin by b: e' = (cos β, sin β cos γ, -sin β sin γ) is the
next shaft's direction in axes with x along the shaft and y along the pin. The rotation about y by a
and then about z by b is a swing of the shaft by β and a twist τ about it with tan(τ/2) =
tan(a/2) tan(b/2): the lead of the next shaft over this one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..arrays import Array
from .geometry import Geometry

if TYPE_CHECKING:
    from .line_data import LineData


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


def line_zero(line: LineData) -> Zero:
    """Return how the pins and shafts of a line stand."""
    even = [joint.kind == "constant_velocity" for joint in line.joints]
    return zero(line.geometry, line.fork_offsets, even)


def zero(found: Geometry, fork_offsets: Array, even: Sequence[bool] = ()) -> Zero:
    """Return how the pins and shafts of a line stand.

    Args:
        found: geometry of the line.
        fork_offsets: `(n - 1,)` see `Shaft` [rad].
        even: which joints are those of constant velocity; none unless given. Of these both turns
            are those of the front half, which bends by half the joint angle.
    """
    count = len(found.joint_angles)
    driving, driven, rotations = np.zeros(count), np.zeros(count), np.zeros(count + 1)
    for k, (beta, plane) in enumerate(zip(found.joint_angles, found.plane_offsets, strict=True)):
        pin = rotations[k] - plane
        if k:
            pin += math.pi / 2 + fork_offsets[k - 1]
        if len(even) and even[k]:
            driven[k] = math.asin(math.sin(beta / 2.0) * math.cos(pin))
            driving[k] = math.atan2(math.sin(beta / 2.0) * math.sin(pin), math.cos(beta / 2.0))
            rotations[k + 1] = pin
            continue
        driven[k] = math.asin(math.sin(beta) * math.cos(pin))
        driving[k] = math.atan2(math.sin(beta) * math.sin(pin), math.cos(beta))
        rotations[k + 1] = pin + float(lead(driving[k], driven[k]))
    return Zero(driving, driven, rotations)


def lead(driving: Array | float, driven: Array | float) -> Array:
    """Return by how much a shaft leads the one before it, from the turns about both pins [rad].

    2 atan(tan(a/2) tan(b/2)), exact for joint angles below 90°.
    """
    return np.asarray(2.0 * np.arctan(np.tan(np.divide(driving, 2)) * np.tan(np.divide(driven, 2))))
