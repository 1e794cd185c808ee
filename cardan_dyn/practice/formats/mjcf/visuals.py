"""Visuals of MJCF: the geoms that MuJoCo shows."""

from __future__ import annotations

from functools import partial
from pathlib import Path, PurePosixPath

import numpy as np

from ....core.description.description import SourceText
from ....kit.arrays import inverse
from ....kit.errors import ModelError
from ..visual import Rgba, Visual, positive, read_each, rgba
from .compiled import Compiled, compiled, placement

_SHOWN_GROUPS = 3
"""MuJoCo shows the first groups of geoms at first, 0 to 2; others are for collisions."""
_GREY = np.array([0.5, 0.5, 0.5, 1.0])
"""Colour of a geom that states none. It counts as none here, and the link gets its own."""
_KINDS = ("plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box")
"""Shapes in the order of MuJoCo's `mjtGeom`."""


def visuals(source: SourceText) -> tuple[list[Visual], list[str]]:
    """Return the visuals of a model that was read before, and messages about others."""
    found = compiled(source.text, source.path, "MJCF", shown=True)
    return read_each(
        (
            link,
            f"geom {name!r}" if name else "a geom",
            partial(_visual, found, index, link, source.folder),
        )
        for index in range(found.model.ngeom)
        for name in [found.model.geom(index).name]
        for link in [found.links[found.model.geom_bodyid[index]][-1]]
    )


def _visual(found: Compiled, index: int, link: str, folder: Path | None) -> Visual | None:
    """Return a geom in the frame of its link; None for one that MuJoCo does not show at first."""
    model = found.model
    color = _color(found, index)
    if model.geom_group[index] >= _SHOWN_GROUPS or (color is not None and color[3] == 0.0):
        return None
    place = placement(model.geom_pos[index], model.geom_quat[index])
    if index in found.meshes:
        mesh, settings = found.meshes[index], found.spec
        if not mesh.file:
            raise ModelError("its mesh names no file")
        file = PurePosixPath(mesh.file)
        if settings.strippath:
            file = PurePosixPath(file.name)
        return Visual(
            *(link, "mesh", (), place, color, str(PurePosixPath(settings.meshdir) / file), folder),
            # The file's points are scaled first, then seen from its reference frame.
            mesh_placement=inverse(mesh.reference),
            scale=mesh.scale,
        )
    kind = _KINDS[model.geom_type[index]] if model.geom_type[index] < len(_KINDS) else "mesh"
    half = model.geom_size[index]
    if kind == "plane":
        return Visual(link, kind, tuple((2.0 * half[:2]).tolist()), place, color)
    if kind in ("hfield", "mesh"):
        raise ModelError(f"a geom of type {kind!r} is not read")
    if kind == "box":
        half = 2.0 * half
    elif kind in ("capsule", "cylinder"):
        half = np.array([half[0], 2.0 * half[1]])
    elif kind == "sphere":
        half = half[:1]
    return Visual(link, kind, positive(half, "its size"), place, color)


def _color(found: Compiled, index: int) -> Rgba | None:
    """Return the colour that a geom states, itself or by its material."""
    model = found.model
    stated, material = model.geom_rgba[index], model.geom_matid[index]
    if np.array_equal(stated, _GREY):
        if material < 0:
            return None
        stated = model.mat_rgba[material]
    return rgba(" ".join(map(str, stated)), "rgba")
