"""Element forms of the viewer: coils, spirals, brakes and arrows, as arrays.

Each is about or along z, in units that its function names.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from . import shapes as forms

_WINDINGS, _STEPS, _STRAIGHT = 8, 12, 0.15
"""Windings of a coil, steps of a winding, and the part of its length that is straight at each end:
a spring that everybody knows as one."""
_SPIRAL_TURNS, _SPIRAL_STEPS, _SPIRAL_START = 2.5, 30, 0.25
"""Turns of a spiral, steps of a turn, and where it starts, as a fraction of its radius."""
_ROD, _CUP, _CUP_ENDS = 0.25, 1.0, (0.3, 0.75)
"""Radii of a damper's rod and cup, as fractions of its own, and where the cup is along it."""
_SHOE, _SHOE_STEPS = 0.45, 8
"""Half the angle that a brake shoe covers [rad], and its steps."""
_ARC, _HEAD, _ARC_STEPS = 4.2, 0.7, 48
"""Angle of an arc arrow up to its head, that of the head [rad], and steps of both together."""
_ARC_INNER, _ARC_HEIGHT, _HEAD_OVER = 0.88, 0.07, 0.1
"""Inner radius, half the height and overhang of the head of an arc arrow of radius 1."""


def coil(radius: float) -> Array:
    """Return the points `(n, 3)` of a coil of length 1 along z, with straight ends on its axis.

    Args:
        radius: of the windings.
    """
    turn = np.linspace(0.0, 2.0 * np.pi * _WINDINGS, _WINDINGS * _STEPS + 1)
    height = np.linspace(_STRAIGHT, 1.0 - _STRAIGHT, len(turn))
    windings = np.stack([radius * np.cos(turn), radius * np.sin(turn), height], axis=1)
    low, high = [[0.0, 0.0, 0.0], [0.0, 0.0, _STRAIGHT]], [[0.0, 0.0, 1.0 - _STRAIGHT], [0, 0, 1]]
    return np.concatenate([low, windings, high])


def spiral(radius: float) -> Array:
    """Return the points `(n, 3)` of a spiral across z from near it to the point `(radius, 0, 0)`.

    Args:
        radius: of its outer end.
    """
    turn = np.linspace(-2.0 * np.pi * _SPIRAL_TURNS, 0.0, int(_SPIRAL_TURNS * _SPIRAL_STEPS) + 1)
    size = radius * np.linspace(_SPIRAL_START, 1.0, len(turn))
    windings = np.stack([size * np.cos(turn), size * np.sin(turn), np.zeros_like(turn)], axis=1)
    return np.concatenate([[[0.0, 0.0, 0.0]], windings])


def dashpot(radius: float) -> tuple[Array, Array]:
    """Return vertices and faces of a damper of length 1 along z: a rod into a cup.

    Args:
        radius: of the cup.
    """
    low, high = _CUP_ENDS
    rod = forms.rod(_ROD * radius, 0.0, 1.0)
    return forms.joined(rod, forms.rod(_CUP * radius, low, high))


def drum(radius: float) -> tuple[Array, Array]:
    """Return vertices and faces of a damper about z: a disc with a rim.

    Args:
        radius: of the rim.
    """
    disc = forms.rod(0.9 * radius, -0.06 * radius, 0.06 * radius)
    return forms.joined(disc, forms.ring(0.86 * radius, radius, -0.22 * radius, 0.22 * radius))


def brake_disc(radius: float) -> tuple[Array, Array]:
    """Return vertices and faces of the ring about z that turns in a brake.

    Args:
        radius: of its rim.
    """
    return forms.ring(0.72 * radius, radius, -0.1 * radius, 0.1 * radius)


def brake_shoes(radius: float) -> tuple[Array, Array]:
    """Return vertices and faces of two shoes outside a ring about z.

    Args:
        radius: of the ring.
    """
    inner, outer, half = 1.04 * radius, 1.3 * radius, 0.2 * radius
    profile = np.array([[inner, -half], [outer, -half], [outer, half], [inner, half]])
    angles = np.linspace(-_SHOE, _SHOE, _SHOE_STEPS + 1)
    return forms.joined(*(forms.swept(profile, middle + angles) for middle in (0.0, np.pi)))


def pads(size: float) -> tuple[Array, Array]:
    """Return vertices and faces of two pads beside a rod along z.

    Args:
        size: half their length.
    """
    near, far = 0.25 * size, 0.7 * size
    profile = np.array([[near, -size], [far, -size], [far, size], [near, size]])
    angles = np.linspace(-0.7, 0.7, 5)
    return forms.joined(*(forms.swept(profile, middle + angles) for middle in (0.0, np.pi)))


def arc_arrow() -> tuple[Array, Array]:
    """Return vertices and faces of an arrow about z, in the sense of a turn, of radius 1."""
    middle = 0.5 * (1.0 + _ARC_INNER)
    shaft_half, head_half = 0.5 * (1.0 - _ARC_INNER), 0.5 * (1.0 - _ARC_INNER) + _HEAD_OVER
    angles = np.linspace(0.0, _ARC, _ARC_STEPS)
    even, closing = np.ones(len(angles)), np.linspace(1.0, 0.02, 9)
    shaft = forms.swept(_band(middle, shaft_half * even, _ARC_HEIGHT * even), angles)
    head = forms.swept(
        _band(middle, head_half * closing, head_half * closing),
        np.linspace(_ARC, _ARC + _HEAD, len(closing)),
    )
    return forms.joined(shaft, head)


def _band(middle: float, half: Array, height: Array) -> Array:
    """Return rectangles `(m, 4, 2)` of half widths and heights `(m,)` about a radius."""
    low, high, inner, outer = -height, height, middle - half, middle + half
    corners = [(inner, low), (outer, low), (outer, high), (inner, high)]
    return np.stack([np.stack(corner, axis=-1) for corner in corners], axis=1)
