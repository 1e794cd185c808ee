"""Shapes of the viewer as arrays: arrows, traces, coils, brakes, and where they point.

A surface is its vertices `(n, 3)` and the indices of them at the corners of its triangles `(m, 3)`.
What the functions without another word return is one, about or along z, in units that they name.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...kit.arrays import ROUNDED, Array, quaternion_product

Surface = tuple[Array, Array]
SMOOTH = np.deg2rad(30.0)
"""Angle between two triangles above which their common edge is drawn as one: flatter ones are
steps of a curved surface, here and in most files."""
_SIDES = 20
"""Sides of a surface of revolution, below that angle."""
ARROW, ARROW_RADIUS = 0.42, 0.028
"""Length of the greatest arrow, as a fraction of the radius of the scene, and radius of an arrow's
shaft, as a fraction of its length."""
PIXEL = 1.0 / 500.0
"""Width of a pixel of a picture that shows the whole scene, as a fraction of its radius."""


def arrow(thickness: float = ARROW_RADIUS) -> Surface:
    """Return an arrow of length 1.

    Args:
        thickness: radius of its shaft.
    """
    head, neck = 3.2 * thickness, 1.0 - 9.0 * thickness
    return _turned([(0.0, 0.0), (thickness, 0.0), (thickness, neck), (head, neck), (0.0, 1.0)])


def ring(inner: float, outer: float, low: float, high: float) -> Surface:
    """Return a ring between two radii and two heights."""
    return _turned([(inner, low), (outer, low), (outer, high), (inner, high), (inner, low)])


def rod(radius: float, low: float, high: float) -> Surface:
    """Return a cylinder between two heights."""
    return _turned([(0.0, low), (radius, low), (radius, high), (0.0, high)])


def capsule(radius: float, length: float = 0.0) -> Surface:
    """Return a cylinder with half a ball at each end.

    Args:
        radius: of the cylinder and the balls.
        length: between the centres of the balls.
    """
    turn = np.linspace(0.0, np.pi / 2.0, 7)
    half = np.stack([radius * np.sin(turn), radius * np.cos(turn) + length / 2.0], axis=1)
    upper = half[::-1] if length else half[-2::-1]
    return _turned([*(half * [1.0, -1.0]), *upper])


def cup(inner: float, outer: float) -> Surface:
    """Return half a ball's shell, open towards negative z.

    Args:
        inner: radius of the ball that it holds.
        outer: its own radius.
    """
    turn = np.linspace(0.0, 0.55 * np.pi, 13)
    around = np.stack([np.sin(turn), np.cos(turn)], axis=1)
    return _turned([*(inner * around), *(outer * around[::-1])])


def prism(outline: Array, low: float, high: float) -> Surface:
    """Return a prism between two heights.

    Args:
        outline: corners `(k, 2)` of its convex section, counterclockwise.
        low: height of one end.
        high: height of the other one.
    """
    ends = (np.column_stack([outline, np.full(len(outline), height)]) for height in (high, low))
    return _between(np.stack([*ends]))


def box(x: float, y: float, z: float) -> Surface:
    """Return a box about the origin with edges of these lengths."""
    return prism(rectangle(-0.5 * x, 0.5 * x, 0.5 * y), -0.5 * z, 0.5 * z)


def rectangle(low: float, high: float, half: float) -> Array:
    """Return the corners `(4, 2)` of a rectangle from one x to another, half as wide along y."""
    return np.array([[low, -half], [high, -half], [high, half], [low, half]])


def swept(profile: Array, angles: Array) -> Surface:
    """Return a convex profile that is swept about z, with both ends closed.

    Args:
        profile: corners `(k, 2)`, or `(m, k, 2)` where they differ from angle to angle: radius and
            height, counterclockwise with the height above the radius.
        angles: `(m,)` ascending [rad].
    """
    corners = np.broadcast_to(profile, (len(angles), *profile.shape[-2:]))
    radius, height = corners[..., 0], corners[..., 1]
    cosine, sine = np.cos(angles)[:, None], np.sin(angles)[:, None]
    return _between(np.stack([radius * cosine, radius * sine, height], axis=-1))


def joined(*surfaces: Surface) -> Surface:
    """Return several surfaces as one."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in surfaces[:-1])])
    faces = [faces + start for (_, faces), start in zip(surfaces, starts, strict=True)]
    return np.concatenate([vertices for vertices, _ in surfaces]), np.concatenate(faces)


def moved(surface: Surface, rotation: Array, point: Array, size: float = 1.0) -> Surface:
    """Return a surface that was enlarged, turned by a matrix `(3, 3)` and shifted to a point."""
    return size * surface[0] @ rotation.T + point, surface[1]


def upright(axis: Array, x: Array | None = None) -> Array:
    """Return the rotation `(3, 3)` that turns z along an axis.

    Args:
        axis: of any length.
        x: direction into whose plane with the axis x is turned; any if not given.
    """
    z = axis / np.linalg.norm(axis)
    if x is None or np.linalg.norm(np.cross(z, x)) <= ROUNDED * np.linalg.norm(x):
        x = np.eye(3)[np.argmin(np.abs(z))]
    x = x - (x @ z) * z
    x = x / np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)


def path(points: Array, radius: float) -> Surface:
    """Return a wire along a curve `(n, 3)`; none if it is shorter than the wire is thick."""
    way = np.cumsum([0.0, *np.linalg.norm(np.diff(points, axis=0), axis=1)])
    # Of points that are nearer to each other than that, one is seen.
    kept = points[np.unique(np.floor(way / radius), return_index=True)[1]]
    lengths = np.linalg.norm(np.diff(kept, axis=0), axis=1)
    start, end = kept[:-1][lengths > 0.0], kept[1:][lengths > 0.0]
    steps = (end - start) / lengths[lengths > 0.0, None]
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
    turn = np.linspace(0.0, 16.0 * np.pi, 97)
    height = np.linspace(0.15, 0.85, len(turn))
    windings = np.stack([radius * np.cos(turn), radius * np.sin(turn), height], axis=1)
    ends = np.outer([0.0, height[0], height[-1], 1.0], [0.0, 0.0, 1.0])
    return np.concatenate([ends[:2], windings, ends[2:]])


def spiral(radius: float) -> Array:
    """Return the points `(n, 3)` of a spiral across z from near it to the point `(radius, 0, 0)`.

    Args:
        radius: of its outer end.
    """
    turn = np.linspace(-5.0 * np.pi, 0.0, 76)
    size = radius * np.linspace(0.25, 1.0, len(turn))
    windings = np.stack([size * np.cos(turn), size * np.sin(turn), np.zeros_like(turn)], axis=1)
    return np.concatenate([[[0.0, 0.0, 0.0]], windings])


def dashpot(radius: float) -> Surface:
    """Return a damper of length 1: a rod into a cup.

    Args:
        radius: of the cup.
    """
    return joined(rod(0.25 * radius, 0.0, 1.0), rod(radius, 0.3, 0.75))


def brake_shoes(radius: float) -> Surface:
    """Return two shoes outside a ring.

    Args:
        radius: of the ring.
    """
    return _both(rectangle(1.04 * radius, 1.3 * radius, 0.2 * radius), 0.45)


def pads(size: float) -> Surface:
    """Return two pads beside a rod.

    Args:
        size: half their length.
    """
    return _both(rectangle(0.25 * size, 0.7 * size, size), 0.7)


def _both(profile: Array, angle: float) -> Surface:
    """Return a profile that is swept to both sides of x by an angle [rad], and likewise of -x."""
    angles = np.linspace(-angle, angle, 9)
    return joined(*(swept(profile, middle + angles) for middle in (0.0, np.pi)))


def arc_arrow() -> Surface:
    """Return an arrow about z, in the sense of a turn, of radius 1."""
    angles, closing = np.linspace(0.0, 4.2, 48), np.linspace(1.0, 0.02, 9)
    shaft = swept(np.array([0.94, 0.0]) + rectangle(-0.06, 0.06, 0.07), angles)
    narrowing = closing[:, None, None] * rectangle(-0.16, 0.16, 0.16)
    head = swept(np.array([0.94, 0.0]) + narrowing, np.linspace(4.2, 4.9, len(closing)))
    return joined(shaft, head)


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
    ends = np.stack([np.min(points, axis=0), np.max(points, axis=0)], axis=1)
    return np.array([*itertools.product(*ends)])


def extremes(points: Array, count: int = 96) -> Array:
    """Return those of many points `(n, 3)` that lie outermost in `count` directions."""
    # Directions spread evenly over the sphere: a spiral that advances by the golden angle.
    index = np.arange(count) + 0.5
    height, turn = 1.0 - 2.0 * index / count, np.pi * (1.0 + 5.0**0.5) * index
    width = np.sqrt(1.0 - height**2)
    directions = np.stack([width * np.cos(turn), width * np.sin(turn), height])
    return np.asarray(points[np.unique(np.argmax(points @ directions, axis=0))])


def _between(sections: Array) -> Surface:
    """Return what convex sections `(m, k, 3)` lead through, closed by the first and the last."""
    after = np.roll(sections, -1, axis=1)
    # Corners of every face by itself: the viewer averages normals at shared vertices.
    sides = np.stack([sections[:-1], sections[1:], after[1:], after[:-1]], axis=2).reshape(-1, 4, 3)
    quads = 4 * np.arange(len(sides))[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])
    count = sections.shape[1]
    fan = np.stack([np.zeros(count - 2, int), *(np.arange(count - 2) + k for k in (1, 2))], axis=1)
    ends = [sections[0], sections[-1][::-1]]
    start = 4 * len(sides)
    faces = [quads.reshape(-1, 3), fan + start, fan + start + count]
    return np.concatenate([sides.reshape(-1, 3), *ends]), np.concatenate(faces)


def _turned(corners: Sequence[Any]) -> Surface:
    """Return the surface of revolution of a line through points `(k, 2)`: radius and height."""
    profile = np.asarray(corners, dtype=float)
    steps = np.diff(profile, axis=0)
    angles = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    # The viewer averages normals at shared vertices: where an edge is to be seen, it has two rings.
    edges = np.abs(np.diff(angles)) > SMOOTH
    rings = np.repeat(profile, [1, *(1 + edges), 1], axis=0)
    turn = np.linspace(0.0, 2.0 * np.pi, _SIDES, endpoint=False)
    radius, height = rings[:, 0, None], rings[:, 1, None]
    around = [radius * np.cos(turn), radius * np.sin(turn), height + 0.0 * turn]
    first = _SIDES * np.cumsum([0, *(1 + edges)])[:, None]
    side = np.arange(_SIDES)
    low, low_after = first + side, first + np.roll(side, -1)
    high, high_after = low + _SIDES, low_after + _SIDES
    faces = [
        np.stack(part, axis=-1) for part in ((low, low_after, high_after), (low, high_after, high))
    ]
    return np.stack(around, axis=-1).reshape(-1, 3), np.concatenate(faces).reshape(-1, 3)


def _shortest(source: Array, target: Array) -> Array:
    """Return quaternions of the shortest turns from a unit vector to unit vectors `(N, 3)`."""
    cosine = target @ source
    result = np.concatenate([np.cross(source, target), 1.0 + cosine[:, None]], axis=1)
    opposite = cosine < -1.0 + ROUNDED
    across = np.cross(source, np.eye(3)[np.argmin(np.abs(source))])
    result[opposite] = [*across, 0.0]
    return np.asarray(result / np.linalg.norm(result, axis=1)[:, None])
