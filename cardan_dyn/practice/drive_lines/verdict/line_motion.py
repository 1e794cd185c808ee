"""Line motion: rotations, speeds and accelerations of the shafts from the pins of their joints.

With the crosses' turns a and b about the driving and the driven pin, the next shaft is ahead by
`lead`, and its speed is that of this shaft times cos a cos b plus a' sin b: the driven pin is
normal to the next shaft, the driving pin has the component sin b along it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ....core.results.sweep import Sweep
from ....kit.arrays import Array
from ..line.data import LineData
from ..line.geometry import lead


class LineMotion(NamedTuple):
    """Motion of the shafts of a line.

    Attributes:
        rotation: `(…, n + 1)` see `Analysis` [rad].
        ratio: `(…, n + 1)` speeds over that of the input shaft.
        acceleration: `(…, n + 1)` [rad/s²].
        slip: `(…, s)` by how much each spline is drawn out against the data [m].
        mean_lead: `(…, n + 1)` mean of each shaft's rotation minus that of the input shaft over a
            turn of this, for designs without their positions [rad].
    """

    rotation: Array
    ratio: Array
    acceleration: Array
    slip: Array
    mean_lead: Array


def line_motion(
    sweep: Sweep,
    cause: int,
    line: LineData,
    slips: Sequence[str],
    speed: float,
    acceleration: float,
) -> LineMotion:
    """Return the motion of all shafts in a sweep.

    Args:
        sweep: causes × samples.
        cause: index of one with this speed and acceleration of the input shaft.
        line: the line.
        slips: joints of the splines.
        speed: of the input shaft [rad/s].
        acceleration: of the input shaft [rad/s²].
    """
    motion, shape = sweep.motion, sweep.shape[1:]
    rotations = [motion.position("bearing_in")[cause]]
    ratios = [np.ones(shape)]
    accelerations = [np.full(shape, acceleration)]
    turns = []
    for k, (zero_in, zero_out) in enumerate(zip(*line.zero[:2], strict=True), 1):
        if line.even[k - 1]:
            for values in (rotations, ratios, accelerations):
                values.append(values[-1])
            turns.append((np.zeros_like(ratios[-1][..., 0]),) * 2)
            continue
        a = motion.position(f"pin_{k}_in")[cause] + zero_in
        b = motion.position(f"pin_{k}_out")[cause] + zero_out
        along, across = np.cos(a) * np.cos(b), np.sin(b)
        turns.append((a[..., 0], b[..., 0]))
        rotations.append(rotations[-1] + lead(a, b))
        ratio = ratios[-1] * along + motion.ratio(f"pin_{k}_in")[cause] * across
        rate_a, rate_b = (
            motion.velocity(f"pin_{k}_in")[cause],
            motion.velocity(f"pin_{k}_out")[cause],
        )
        change = -rate_a * np.sin(a) * np.cos(b) - rate_b * np.cos(a) * np.sin(b)
        accelerations.append(
            accelerations[-1] * along
            + speed * ratios[-1] * change
            + motion.acceleration(f"pin_{k}_in")[cause] * across
            + rate_a * rate_b * np.cos(b)
        )
        ratios.append(ratio)
    drawn_out = [motion.position(name)[cause] for name in slips]
    slip = np.stack(drawn_out, axis=-1) if drawn_out else np.zeros((*shape, 0))
    driving, driven = (np.stack(item, axis=-1) for item in zip(*turns, strict=True))
    rotation = np.stack(rotations, axis=-1)
    return LineMotion(
        rotation,
        np.stack(ratios, axis=-1),
        np.stack(accelerations, axis=-1),
        slip,
        mean_leads(driving, driven, rotation[..., 0, :]),
    )


def mean_leads(driving: Array, driven: Array, rotations: Array) -> Array:
    """Return mean leads over a turn of the input shaft from how a line stands at one position.

    With γ the angle of the driving pin from the bending plane, sin β cos γ = sin b and
    sin β sin γ = sin a cos b, so that w = tan²(β/2) e^{2iγ} is known, and with it the lead at any
    other rotation x of the shaft before the joint: -arg(1 - w e^{2i(x - x₀)}). Such a lead has no
    mean, and joints in a row are one such joint, turned on by an angle, which is the mean: their
    maps e^{2ix} -> (e^{2ix} - z) / (1 - conj(z) e^{2ix}) with z = conj(w) are composed.

    Args:
        driving: `(…, n)` turns a of the crosses about the driving pins [rad].
        driven: `(…, n)` turns b about the driven pins [rad].
        rotations: `(…, n + 1)` of the shafts [rad].

    Returns:
        `(…, n + 1)` mean of each shaft's rotation minus that of the input shaft [rad]; 0 for this.
    """
    cosine = np.cos(driving) * np.cos(driven)
    half = (np.sin(driven) + 1j * np.sin(driving) * np.cos(driven)) / (1.0 + cosine)
    at_zero = half**2 * np.exp(-2j * rotations[..., :-1])
    means = [np.zeros(at_zero.shape[:-1])]
    corner = np.zeros(at_zero.shape[:-1], dtype=complex)
    for k in range(at_zero.shape[-1]):
        step = np.conj(at_zero[..., k] * np.exp(2j * means[-1]))
        scale = 1.0 - step * np.conj(corner)
        means.append(means[-1] + np.angle(scale))
        corner = (corner - step) / scale
    return np.stack(means, axis=-1)
