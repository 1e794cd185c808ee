"""Picture: a scene at one of its samples on paper, in parallel projection."""

from __future__ import annotations

import numpy as np

from ...core.results.sweep import Sweep
from ...figures.style import SMALL, Axes, Figure, axes_grid, plain, refuse_grid
from ...kit.arrays import Array
from .commands import Drawing, DrawnObject
from .scenery import Parts, build
from .shapes import upright

_EYE = np.array([0.55, -0.7, 0.45])
"""Towards the eye where a mechanism is not flat: from the front, the right and above."""
_SHADE = 0.45
"""Share of its colour that a surface loses which is seen from the side."""
_LINE, _WORD = 0.04, 0.16
"""Height and width that a name takes of a drawing's extent."""


def picture(sweep: Sweep, sample: int = 0) -> Figure:
    """Draw the bodies, drives, loads and elements of a sweep at one of its samples.

    Raises:
        MissingExtraError: Matplotlib is not installed.
        ArgumentError: the sweep has several dimensions, or its outputs leave nothing to draw.
    """
    refuse_grid(sweep)
    named = len(sweep.outputs) <= 12  # More names would cover the drawing.
    parts = Parts(True, False, False, False, False, named, True, True)
    scenery = build(sweep, sweep.outputs, parts, np.array([sample]))
    right, up, eye = _axes_of_view(scenery.normal)
    drawing = scenery.drawing
    triangles, colors, layers = [], [], []
    for item in drawing.objects:
        corners = _corners(drawing, item)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        sizes = np.linalg.norm(normals, axis=1)
        facing = np.abs(normals @ eye) / np.where(sizes > 0.0, sizes, 1.0)
        tone, light = item.color, 1.0 - _SHADE * (1.0 - facing)
        triangles.append(corners)
        shaded = np.outer(light, [tone.red, tone.green, tone.blue])
        colors.append(np.column_stack([shaded, np.full(len(corners), tone.opacity)]))
        layers.append(np.full(len(corners), item.color.layer))
    every = np.concatenate(triangles)
    # What is far first, so that what is near covers it.
    order = np.lexsort([every.mean(axis=1) @ eye, np.concatenate(layers)])
    from matplotlib.collections import PolyCollection

    flat = np.stack([every @ right, every @ up], axis=-1)[order]
    shades = np.concatenate(colors)[order]
    extent = np.ptp(flat.reshape(-1, 2), axis=0)
    height = min(max(6.0 * extent[1] / (extent[0] or 1.0), 2.0), 5.0)
    figure, axes = axes_grid(size=(6.0, height))
    # Edges in the colour of their faces close the seams between these; glass would show them.
    edges = np.where(shades[:, 3:] < 1.0, 0.0, shades)
    drawn = PolyCollection(list(flat), facecolors=shades.tolist(), edgecolors=edges.tolist())
    drawn.set(linewidth=0.2, rasterized=True)
    axes.add_collection(drawn)
    places: dict[str, tuple[float, float]] = {}
    for label in drawing.labels:
        at = _placed(drawing, label.path)[:3, 3]
        places[label.text] = float(at @ right), float(at @ up)
    _write_names(axes, places, float(max(extent)))
    axes.set_aspect("equal")
    axes.autoscale()
    axes.set_axis_off()
    return figure


def _write_names(axes: Axes, places: dict[str, tuple[float, float]], extent: float) -> None:
    """Write names beside their places; those that would cover each other together."""
    groups: list[tuple[tuple[float, float], list[str]]] = []
    for name, (x, y) in places.items():
        for at, names in groups:
            if abs(y - at[1]) < _LINE * extent and abs(x - at[0]) < _WORD * extent:
                names.append(name)
                break
        else:
            groups.append(((x, y), [name]))
    for at, names in groups:
        axes.annotate(
            ",\n".join(map(plain, names)),
            at,
            xytext=(5.0, 5.0),
            textcoords="offset points",
            fontsize=SMALL,
        )


def _axes_of_view(normal: int | None) -> Array:
    """Return the axes to the right, upwards and towards the eye `(3, 3)`, one by one."""
    world = np.eye(3)
    right, eye = np.cross(world[2], _EYE), _EYE
    if normal is not None:
        # Onto x and y, x and z, y and z, to the right and upwards.
        right, up = np.delete(world, normal, axis=0)
        eye = np.cross(right, up)
    return upright(eye, right).T


def _placed(drawing: Drawing, path: str) -> Array:
    """Return where a node is at the first sample `(4, 4)`, within the nodes above it."""
    from scipy.spatial.transform import Rotation

    above = _placed(drawing, path[: path.rindex("/")]) if path else np.eye(4)
    if path not in drawing.nodes:
        return above
    pose, matrix = drawing.nodes[path], np.eye(4)
    matrix[:3, :3] = Rotation.from_quat(pose.quaternion[0]).as_matrix() * pose.scale[0]
    matrix[:3, 3] = pose.position[0]
    return above @ matrix


def _corners(drawing: Drawing, item: DrawnObject) -> Array:
    """Return the corners of an object's triangles `(n, 3, 3)` in the world [m]."""
    vertices, faces = item.surface
    placement = _placed(drawing, item.path)
    if item.placement is not None:
        placement = placement @ item.placement
    points = vertices @ placement[:3, :3].T + placement[:3, 3]
    return np.asarray(points[np.asarray(faces, dtype=int)])
