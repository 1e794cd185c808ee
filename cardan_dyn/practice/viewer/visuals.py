"""Visuals of the viewer: the shapes of links that a description has, on the bodies of the model.

They are read from the description only when they are shown. What cannot be shown is told in words.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ...core.description.visual import Rgba, Visual
from ...core.description.visuals import visuals_of
from ...core.mechanism.mechanism import Mechanism
from ...kit.arrays import Array
from ...kit.errors import ModelError
from . import shapes as forms
from .commands import mesh, meshcat
from .meshes import Surface, creased, find_mesh, read_mesh, searched, thinned

_MOST_LISTED = 6
"""Meshes that a note names, so that it stays readable."""
_MOST_FACES = 100_000
"""Triangles of all meshes above which they are thinned."""
_PIXEL = 1.0 / 500.0
"""Width of a pixel of a picture that shows the whole scene, as a fraction of its radius."""
_COARSEST = 8.0 * _PIXEL
"""Distance of points, likewise, beyond which meshes are not thinned: they would be unknowable."""
_Y_TO_Z = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])
"""Turns meshcat's cylinders, which stand along y, to stand along z."""
_FLOOR = 1.5
"""Half the edge of a plane without end, as it is drawn, in radii of the scene."""


@dataclass(frozen=True, eq=False)
class Shape:
    """One visual of a link, or what of it has one colour.

    Attributes:
        link: name of the link.
        body: index of the link's body in `Mechanism.model`.
        kind: see `description.visual.SIZES`.
        size: likewise [m].
        placement: `(4, 4)` of the shape in the link's body in `Mechanism.model`.
        color: red, green, blue and opacity, 0 to 1; None where nothing states one.
        vertices: `(n, 3)` of a mesh [m].
        faces: `(m, 3)` of a mesh, indices of vertices.
    """

    link: str
    body: int
    kind: str
    size: tuple[float, ...]
    placement: Array
    color: Rgba | None
    vertices: Array = field(default_factory=lambda: np.zeros((0, 3)))
    faces: Array = field(default_factory=lambda: np.zeros((0, 3), dtype=np.uint32))

    def corners(self) -> Array:
        """Return the corners `(8, 3)` of a box around the shape, in axes of the body [m].

        A plane, which is often a floor without end, has none.
        """
        if self.kind == "plane":
            return np.zeros((0, 3))
        if self.kind == "mesh":
            local = forms.corners(self.vertices)
        else:
            half = self._half()
            local = forms.corners(np.array([-half, half]))
        return np.asarray(local @ self.placement[:3, :3].T + self.placement[:3, 3])

    def _half(self) -> Array:
        """Return half the extents `(3,)` of a kind that is no mesh [m]."""
        size = np.array(self.size)
        if self.kind == "box":
            return size / 2.0
        if self.kind == "ellipsoid":
            return size
        if self.kind == "sphere":
            return np.full(3, size[0])
        ends = size[0] if self.kind == "capsule" else 0.0
        return np.array([size[0], size[0], size[1] / 2.0 + ends])

    def drawn(self, radius: float) -> tuple[Any, Array]:
        """Return the shape as meshcat's geometry, and its placement `(4, 4)` in its body.

        Args:
            radius: of the scene [m].
        """
        geometry = meshcat().geometry
        if self.kind == "box":
            return geometry.Box(self.size), self.placement
        if self.kind == "sphere":
            return geometry.Sphere(self.size[0]), self.placement
        if self.kind == "cylinder":
            return geometry.Cylinder(self.size[1], self.size[0]), self.placement @ _Y_TO_Z
        if self.kind == "capsule":
            return mesh(forms.capsule(*self.size)), self.placement
        if self.kind == "ellipsoid":
            vertices, faces = forms.capsule(1.0, 0.0)
            return mesh((vertices * self.size, faces)), self.placement
        if self.kind == "plane":
            most = 2.0 * _FLOOR * radius
            width, depth = (min(edge, most) if edge > 0.0 else most for edge in self.size)
            return geometry.Box((width, depth, 1e-3 * radius)), self.placement
        surface = creased(Surface(self.vertices, self.faces, None))
        return mesh((surface.vertices, surface.faces)), self.placement


def shapes_of(mechanism: Mechanism) -> tuple[list[Shape], tuple[str, ...]]:
    """Return the visuals of all links, and notes about those that cannot be shown."""
    visuals, notes = visuals_of(mechanism.description)
    files: dict[tuple[Path, str], tuple[Surface, ...] | str] = {}
    missing: dict[str, dict[str, str]] = {}
    shapes: list[Shape] = []
    for visual in visuals:
        if visual.link not in mechanism.links:
            continue  # A frame of a notation, which is no link of the mechanism.
        if visual.kind != "mesh":
            shapes.append(_shape(visual, mechanism))
            continue
        path = find_mesh(visual.file, visual.folder)
        if path is None:
            where = searched(visual.file, visual.folder)
            missing.setdefault(where, {}).setdefault(visual.file, visual.link)
            continue
        if (path, visual.part) not in files:
            try:
                files[path, visual.part] = read_mesh(path, visual.part)
            except ModelError as error:
                files[path, visual.part] = str(error)
                notes.append(f"link {visual.link!r}: {error}")
        surfaces = files[path, visual.part]
        if not isinstance(surfaces, str):
            shapes += [_shape(visual, mechanism, surface) for surface in surfaces]
    notes += [_missing(names, where) for where, names in missing.items()]
    return shapes, tuple(notes)


def _missing(names: dict[str, str], where: str) -> str:
    """Return a note about meshes, by name with their first link, that were not found."""
    listed = [f"{name!r} (link {link!r})" for name, link in names.items()][:_MOST_LISTED]
    more = len(names) - len(listed)
    text = ", ".join(listed) + (f" and {more} more" if more else "")
    count = "a mesh was" if len(names) == 1 else f"{len(names)} meshes were"
    return f"{count} not found: {text}; {where}"


def _shape(visual: Visual, mechanism: Mechanism, surface: Surface | None = None) -> Shape:
    """Return a visual, or one surface of its mesh, on its body."""
    body, frame = mechanism.links[visual.link]
    placement = frame.homogeneous @ visual.placement
    if surface is None:
        return Shape(visual.link, body, visual.kind, visual.size, placement, visual.color)
    mirrored = np.prod(visual.scale) < 0.0
    return Shape(
        *(visual.link, body, "mesh", (), placement @ visual.mesh_placement),
        color=visual.color or surface.color,
        vertices=surface.vertices * visual.scale,
        # The side from which a triangle is seen goes by the sense of its corners.
        faces=surface.faces[:, ::-1] if mirrored else surface.faces,
    )


def few_enough(shapes: list[Shape], radius: float) -> tuple[list[Shape], str]:
    """Return shapes whose meshes a browser draws fluently, and a note where some were thinned.

    Points that are nearer to each other than a pixel are one then, or few pixels in huge scenes.

    Args:
        shapes: of all bodies.
        radius: of the scene [m].
    """
    before = after = sum(len(shape.faces) for shape in shapes)
    cell = _PIXEL * radius
    thin = shapes
    while after > _MOST_FACES and cell <= _COARSEST * radius:
        thin = [_thinned(shape, cell) for shape in shapes]
        after, cell = sum(len(shape.faces) for shape in thin), 2.0 * cell
    if after == before:
        return shapes, ""
    return thin, f"meshes are drawn with {after} of their {before} triangles"


def _thinned(shape: Shape, cell: float) -> Shape:
    """Return a shape whose mesh has points in different cubes alone, if any triangle is left."""
    if shape.kind != "mesh":
        return shape
    vertices, faces, _ = thinned(Surface(shape.vertices, shape.faces, None), cell)
    if not len(faces):
        return shape
    return Shape(
        *(shape.link, shape.body, shape.kind, shape.size, shape.placement, shape.color),
        *(vertices, faces),
    )
