"""Shapes of the viewer as arrays: arrows, traces, coils, brakes, and where they point.

Those of elements are about or along z, in units that their functions name.
"""

from __future__ import annotations

import itertools

import numpy as np

from ...kit.arrays import ROUNDED, Array, quaternion_product

_SIDES = 20
"""Sides of a surface of revolution: at the width of an arrow on the screen it looks round."""
_ROUND_STEPS = 6
"""Steps of a quarter of a circle, where a surface of revolution is round."""
_HEAD_RADIUS, _HEAD_LENGTH = 3.2, 9.0
"""Radius and length of an arrow's head, in radii of its shaft."""
_SHORTEST_STEP = 1e-6
"""Steps of a curve below this fraction of the wire's radius are left out: they have no direction
beyond rounding, and are not seen."""
ARROW, ARROW_RADIUS = 0.42, 0.028
"""Length of the greatest arrow, as a fraction of the radius of the scene, and radius of an arrow's
shaft, as a fraction of its length."""
LEAST_SCALE = 1e-5
"""Least size of what changes its size, as a fraction of the radius of the scene. A scale of zero
has no inverse, which the viewer needs for normals."""
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


def arrow(thickness: float) -> tuple[Array, Array]:
    """Return vertices `(n, 3)` and faces `(m, 3)` of an arrow of length 1 along z.

    Args:
        thickness: radius of its shaft.
    """
    head, neck = _HEAD_RADIUS * thickness, 1.0 - _HEAD_LENGTH * thickness
    # Every corner occurs twice: the viewer averages normals at shared vertices, which would
    # make the edges look round.
    profile = [
        *((0.0, 0.0), (thickness, 0.0)),
        *((thickness, 0.0), (thickness, neck)),
        *((thickness, neck), (head, neck)),
        *((head, neck), (0.0, 1.0)),
    ]
    return _turned(np.array(profile))


def ring(inner: float, outer: float, low: float, high: float) -> tuple[Array, Array]:
    """Return vertices and faces of a ring about z between two radii and two heights."""
    corners = [(inner, low), (outer, low), (outer, high), (inner, high), (inner, low)]
    profile = [point for pair in itertools.pairwise(corners) for point in pair]
    return _turned(np.array(profile))


def swept(profile: Array, angles: Array) -> tuple[Array, Array]:
    """Return vertices and faces of a convex profile that is swept about z, with both ends closed.

    Args:
        profile: corners `(k, 2)`, or `(m, k, 2)` where they differ from angle to angle: radius and
            height, counterclockwise with the height above the radius.
        angles: `(m,)` ascending [rad].
    """
    corners = np.broadcast_to(profile, (len(angles), *profile.shape[-2:]))
    radius, height = corners[..., 0], corners[..., 1]
    cosine, sine = np.cos(angles)[:, None], np.sin(angles)[:, None]
    points = np.stack([radius * cosine, radius * sine, height], axis=-1)
    after = np.roll(points, -1, axis=1)
    # Corners of every face by itself: the viewer averages normals at shared vertices.
    sides = np.stack([points[:-1], points[1:], after[1:], after[:-1]], axis=2).reshape(-1, 4, 3)
    ends = [
        np.stack([end[0], *pair]) for end in (points[0], points[-1][::-1]) for pair in _fan(end)
    ]
    vertices = np.concatenate([sides.reshape(-1, 3), *ends])
    quads = 4 * np.arange(len(sides))[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])
    fans = 4 * len(sides) + np.arange(3 * len(ends)).reshape(-1, 3)
    return vertices, np.concatenate([quads.reshape(-1, 3), fans])


def joined(*surfaces: tuple[Array, Array]) -> tuple[Array, Array]:
    """Return vertices and faces of several surfaces as those of one."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in surfaces)])
    return (
        np.concatenate([vertices for vertices, _ in surfaces]),
        np.concatenate(
            [faces + start for (_, faces), start in zip(surfaces, starts[:-1], strict=True)]
        ),
    )


def rod(radius: float, low: float, high: float) -> tuple[Array, Array]:
    """Return vertices and faces of a cylinder along z between two heights."""
    corners = [(0.0, low), (radius, low), (radius, high), (0.0, high)]
    profile = [point for pair in itertools.pairwise(corners) for point in pair]
    return _turned(np.array(profile))


def capsule(radius: float, length: float) -> tuple[Array, Array]:
    """Return vertices and faces of a cylinder about z with half a ball at each end.

    Args:
        radius: of the cylinder and the balls.
        length: between the centres of the balls.
    """
    turn = np.linspace(0.0, np.pi / 2.0, _ROUND_STEPS + 1)
    half = np.stack([radius * np.sin(turn), radius * np.cos(turn) + length / 2.0], axis=1)
    curve = np.concatenate([half * [1.0, -1.0], half[::-1]])
    return _turned(np.repeat(curve, 2, axis=0)[1:-1])


def cup(inner: float, outer: float) -> tuple[Array, Array]:
    """Return vertices and faces of half a ball's shell about z, open towards negative z.

    Args:
        inner: radius of the ball that it holds.
        outer: its own radius.
    """
    turn = np.linspace(0.0, 0.55 * np.pi, 2 * _ROUND_STEPS + 1)
    around = np.stack([np.sin(turn), np.cos(turn)], axis=1)
    curve = np.concatenate([inner * around, outer * around[::-1]])
    return _turned(np.repeat(curve, 2, axis=0)[1:-1])


def prism(outline: Array, low: float, high: float) -> tuple[Array, Array]:
    """Return vertices and faces of a prism along z between two heights.

    Args:
        outline: corners `(k, 2)` of its convex section, counterclockwise.
        low: height of one end.
        high: height of the other one.
    """
    count = len(outline)
    ends = [np.column_stack([outline, np.full(count, height)]) for height in (low, high)]
    after = [np.roll(end, -1, axis=0) for end in ends]
    # Corners of every face by itself: the viewer averages normals at shared vertices.
    sides = np.stack([ends[0], after[0], after[1], ends[1]], axis=1).reshape(-1, 3)
    quads = 4 * np.arange(count)[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])
    fan = np.stack([np.zeros(count - 2), np.arange(1, count - 1), np.arange(2, count)], axis=1)
    top, bottom = fan.astype(int) + 5 * count, fan.astype(int)[:, ::-1] + 4 * count
    return np.concatenate([sides, *ends]), np.concatenate([quads.reshape(-1, 3), bottom, top])


def moved(surface: tuple[Array, Array], rotation: Array, point: Array) -> tuple[Array, Array]:
    """Return a surface that was turned by a matrix `(3, 3)`, then shifted to a point `(3,)`."""
    return surface[0] @ rotation.T + point, surface[1]


def upright(axis: Array, x: Array | None = None) -> Array:
    """Return the rotation `(3, 3)` that turns z along an axis.

    Args:
        axis: of any length.
        x: direction into whose plane with the axis x is turned; any if not given.
    """
    z = axis / np.linalg.norm(axis)
    if x is None or np.linalg.norm(np.cross(z, x)) < _SHORTEST_STEP:
        x = np.eye(3)[np.argmin(np.abs(z))]
    x = x - (x @ z) * z
    x = x / np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)


def path(points: Array, radius: float) -> tuple[Array, Array]:
    """Return vertices and faces of a wire along a curve `(n, 3)`; none if it is a point."""
    steps = np.diff(points, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    kept = lengths > _SHORTEST_STEP * radius
    start, steps = points[:-1][kept], steps[kept] / lengths[kept, None]
    end = points[1:][kept]
    across = np.cross(steps, np.eye(3)[np.argmin(np.abs(steps), axis=1)])
    across /= np.linalg.norm(across, axis=1)[:, None]
    normal = np.cross(steps, across)
    # Three sides are enough for a wire that is a few pixels wide.
    turn = np.arange(3) * 2.0 * np.pi / 3.0
    ring = radius * (
        across[:, None] * np.cos(turn)[:, None] + normal[:, None] * np.sin(turn)[:, None]
    )
    vertices = np.concatenate([start[:, None] + ring, end[:, None] + ring], axis=1)
    sides = np.array([[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]])
    faces = sides + 6 * np.arange(len(steps))[:, None, None]
    return vertices.reshape(-1, 3), faces.reshape(-1, 3)


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
    return joined(rod(_ROD * radius, 0.0, 1.0), rod(_CUP * radius, low, high))


def drum(radius: float) -> tuple[Array, Array]:
    """Return vertices and faces of a damper about z: a disc with a rim.

    Args:
        radius: of the rim.
    """
    disc = rod(0.9 * radius, -0.06 * radius, 0.06 * radius)
    return joined(disc, ring(0.86 * radius, radius, -0.22 * radius, 0.22 * radius))


def brake_disc(radius: float) -> tuple[Array, Array]:
    """Return vertices and faces of the ring about z that turns in a brake.

    Args:
        radius: of its rim.
    """
    return ring(0.72 * radius, radius, -0.1 * radius, 0.1 * radius)


def brake_shoes(radius: float) -> tuple[Array, Array]:
    """Return vertices and faces of two shoes outside a ring about z.

    Args:
        radius: of the ring.
    """
    inner, outer, half = 1.04 * radius, 1.3 * radius, 0.2 * radius
    profile = np.array([[inner, -half], [outer, -half], [outer, half], [inner, half]])
    angles = np.linspace(-_SHOE, _SHOE, _SHOE_STEPS + 1)
    return joined(*(swept(profile, middle + angles) for middle in (0.0, np.pi)))


def pads(size: float) -> tuple[Array, Array]:
    """Return vertices and faces of two pads beside a rod along z.

    Args:
        size: half their length.
    """
    near, far = 0.25 * size, 0.7 * size
    profile = np.array([[near, -size], [far, -size], [far, size], [near, size]])
    angles = np.linspace(-0.7, 0.7, 5)
    return joined(*(swept(profile, middle + angles) for middle in (0.0, np.pi)))


def arc_arrow() -> tuple[Array, Array]:
    """Return vertices and faces of an arrow about z, in the sense of a turn, of radius 1."""
    middle = 0.5 * (1.0 + _ARC_INNER)
    shaft_half, head_half = 0.5 * (1.0 - _ARC_INNER), 0.5 * (1.0 - _ARC_INNER) + _HEAD_OVER
    angles = np.linspace(0.0, _ARC, _ARC_STEPS)
    even, closing = np.ones(len(angles)), np.linspace(1.0, 0.02, 9)
    shaft = swept(_band(middle, shaft_half * even, _ARC_HEIGHT * even), angles)
    head = swept(
        _band(middle, head_half * closing, head_half * closing),
        np.linspace(_ARC, _ARC + _HEAD, len(closing)),
    )
    return joined(shaft, head)


def _band(middle: float, half: Array, height: Array) -> Array:
    """Return rectangles `(m, 4, 2)` of half widths and heights `(m,)` about a radius."""
    low, high, inner, outer = -height, height, middle - half, middle + half
    corners = [(inner, low), (outer, low), (outer, high), (inner, high)]
    return np.stack([np.stack(corner, axis=-1) for corner in corners], axis=1)


def towards(directions: Array) -> Array:
    """Return quaternions `(N, 4)` that turn z into unit vectors `(N, 3)`.

    The twist about the direction is free; it is chosen such that it changes little between
    neighbouring samples, since the viewer interpolates between them.
    """
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    # The shortest turn from the axis that is farthest from being opposite to any direction.
    base = axes[np.argmax(np.min(directions @ axes.T, axis=0))]
    return quaternion_product(
        _shortest(base, directions), _shortest(np.array([0.0, 0.0, 1.0]), base[None])
    )


def quaternions(rotations: Array) -> Array:
    """Return quaternions x, y, z, w `(N, 4)` of rotation matrices `(N, 3, 3)`."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(rotations).as_quat())


def filled(vectors: Array, threshold: float) -> tuple[Array, Array]:
    """Return unit directions `(N, 3)` and lengths `(N,)` of vectors.

    A vector shorter than `threshold` gets the direction of the last longer one before it, or of
    the first one after it; z if all are shorter.
    """
    lengths = np.linalg.norm(vectors, axis=1)
    usable = lengths > threshold
    if not np.any(usable):
        return np.tile([0.0, 0.0, 1.0], (len(vectors), 1)), lengths
    # Index of the last usable sample up to each one; before the first, that one.
    last = np.maximum.accumulate(np.where(usable, np.arange(len(vectors)), -1))
    last[last < 0] = int(np.argmax(usable))
    return vectors[last] / lengths[last, None], lengths


def corners(points: Array) -> Array:
    """Return the corners `(8, 3)` of a box around points `(n, 3)`."""
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    upper = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, 8).T
    return np.where(upper == 0, low, high)


def extremes(points: Array, count: int = 96) -> Array:
    """Return those of many points `(n, 3)` that lie outermost in `count` directions."""
    # Directions spread evenly over the sphere: a spiral that advances by the golden angle.
    index = np.arange(count) + 0.5
    height, turn = 1.0 - 2.0 * index / count, np.pi * (1.0 + 5.0**0.5) * index
    width = np.sqrt(1.0 - height**2)
    directions = np.stack([width * np.cos(turn), width * np.sin(turn), height])
    return np.asarray(points[np.unique(np.argmax(points @ directions, axis=0))])


def _fan(corners: Array) -> list[Array]:
    """Return the pairs of corners `(2, 3)` that make triangles with the first of them."""
    return [corners[index : index + 2] for index in range(1, len(corners) - 1)]


def _turned(profile: Array) -> tuple[Array, Array]:
    """Return the surface of revolution of pairs of points `(2 k, 2)`: radius and height."""
    turn = np.linspace(0.0, 2.0 * np.pi, _SIDES, endpoint=False)
    radius, height = profile[:, 0, None], profile[:, 1, None]
    vertices = np.stack(
        [radius * np.cos(turn), radius * np.sin(turn), height + 0.0 * turn], axis=-1
    ).reshape(-1, 3)
    side, after = np.arange(_SIDES), np.roll(np.arange(_SIDES), -1)
    faces = []
    for low in range(0, len(profile), 2):
        first, second = low * _SIDES, (low + 1) * _SIDES
        faces.append(np.stack([first + side, first + after, second + after], axis=1))
        faces.append(np.stack([first + side, second + after, second + side], axis=1))
    return vertices, np.concatenate(faces)


def _shortest(source: Array, target: Array) -> Array:
    """Return quaternions of the shortest turns from a unit vector to unit vectors `(N, 3)`."""
    cosine = target @ source
    result = np.concatenate([np.cross(source, target), 1.0 + cosine[:, None]], axis=1)
    opposite = cosine < -1.0 + ROUNDED
    across = np.cross(source, np.eye(3)[np.argmin(np.abs(source))])
    result[opposite] = [*across, 0.0]
    return np.asarray(result / np.linalg.norm(result, axis=1)[:, None])
