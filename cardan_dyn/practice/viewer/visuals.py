"""Visuals of the viewer: the shapes of links that a description has, on the bodies of the model.

They are read from the description only when they are shown. What cannot be shown is told in words.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...core.mechanism.mechanism import Mechanism
from ...kit.arrays import Array
from ...kit.errors import ModelError, choices
from ..formats.visual import Rgba, Visual
from ..formats.visuals import visuals_of
from . import shapes as forms
from .meshes import Colored, creased, find_mesh, read_mesh, searched, thinned
from .shapes import Surface

_MOST_FACES = 100_000
"""Triangles of all meshes above which they are thinned."""


@dataclass(frozen=True, eq=False)
class Shape:
    """One visual of a link, or what of it has one colour.

    Attributes:
        link: name of the link.
        body: index of the link's body in `Mechanism.model`.
        kind: see `formats.visual.SIZES`.
        placement: `(4, 4)` of the shape in the link's body in `Mechanism.model`.
        color: red, green, blue and opacity, 0 to 1; None where nothing states one.
        surface: in its own frame [m]; of a plane without end, one that has no width.
    """

    link: str
    body: int
    kind: str
    placement: Array
    color: Rgba | None
    surface: Surface

    def corners(self) -> Array:
        """Return the corners `(8, 3)` of a box around the shape, in axes of the body [m].

        A plane, which is often a floor without end, has none.
        """
        if self.kind == "plane":
            return np.zeros((0, 3))
        local = forms.corners(self.surface[0])
        return np.asarray(local @ self.placement[:3, :3].T + self.placement[:3, 3])

    def drawn(self, radius: float) -> Surface:
        """Return the surface as it is drawn, planes as large as a scene of a radius [m]."""
        if self.kind == "plane":
            edges = np.ptp(self.surface[0], axis=0)
            width, depth, _ = np.where(edges > 0.0, np.minimum(edges, 3.0 * radius), 3.0 * radius)
            return forms.box(width, depth, 1e-3 * radius)
        return creased(self.surface) if self.kind == "mesh" else self.surface


def surface_of(kind: str, size: Sequence[float]) -> Surface:
    """Return the surface of a kind that is no mesh, see `formats.visual.SIZES`."""
    if kind in ("box", "plane"):
        return forms.box(*size, *[0.0] * (kind == "plane"))
    if kind == "ellipsoid":
        vertices, faces = forms.capsule(1.0)
        return vertices * np.asarray(size), faces
    if kind == "cylinder":
        return forms.rod(size[0], -0.5 * size[1], 0.5 * size[1])
    return forms.capsule(*size)


def shapes_of(mechanism: Mechanism) -> tuple[list[Shape], tuple[str, ...]]:
    """Return the visuals of all links, and notes about those that cannot be shown."""
    visuals, notes = visuals_of(mechanism.description)
    files: dict[tuple[Path, str], tuple[Colored, ...] | str] = {}
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
        read = files[path, visual.part]
        if not isinstance(read, str):
            shapes += [_shape(visual, mechanism, colored) for colored in read]
    notes += [_missing(names, where) for where, names in missing.items()]
    return shapes, tuple(notes)


def _missing(names: dict[str, str], where: str) -> str:
    """Return a note about meshes, by name with their first link, that were not found."""
    listed = (f"{name!r} (link {link!r})" for name, link in names.items())
    count = "a mesh was" if len(names) == 1 else f"{len(names)} meshes were"
    return f"{count} not found: {choices(listed, most=6)}; {where}"


def _shape(visual: Visual, mechanism: Mechanism, colored: Colored | None = None) -> Shape:
    """Return a visual, or what of its mesh has one colour, on its body."""
    body, frame = mechanism.links[visual.link]
    placement, color = frame.homogeneous @ visual.placement, visual.color
    if colored is None:
        surface = surface_of(visual.kind, visual.size)
    else:
        (vertices, faces), color = colored.surface, color or colored.color
        placement = placement @ visual.mesh_placement
        # The side from which a triangle is seen goes by the sense of its corners.
        faces = faces[:, ::-1] if np.prod(visual.scale) < 0.0 else faces
        surface = vertices * visual.scale, faces
    return Shape(visual.link, body, visual.kind, placement, color, surface)


def few_enough(shapes: list[Shape], radius: float) -> tuple[list[Shape], str]:
    """Return shapes whose meshes a browser draws fluently, and a note where some were thinned.

    Points that are nearer to each other than a pixel are one then, or few pixels in huge scenes.

    Args:
        shapes: of all bodies.
        radius: of the scene [m].
    """

    def count(shapes: list[Shape]) -> int:
        return sum(len(shape.surface[1]) for shape in shapes if shape.kind == "mesh")

    before = after = count(shapes)
    thin, cell = shapes, forms.PIXEL * radius
    # Beyond some pixels meshes would be unknowable.
    while after > _MOST_FACES and cell <= 8.0 * forms.PIXEL * radius:
        # Of a mesh that no triangle would be left of, all is.
        thin = [
            replace(shape, surface=surface)
            if shape.kind == "mesh" and len((surface := thinned(shape.surface, cell))[1])
            else shape
            for shape in shapes
        ]
        after, cell = count(thin), 2 * cell
    if after == before:
        return shapes, ""
    return thin, f"meshes are drawn with {after} of their {before} triangles"
