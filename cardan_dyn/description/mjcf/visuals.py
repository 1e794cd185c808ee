"""Visuals of MJCF: the geoms that MuJoCo shows."""

from __future__ import annotations

from pathlib import Path, PurePosixPath
from xml.etree import ElementTree

import numpy as np

from ...arrays import Array, inverse
from ...errors import ModelError, choices
from ..elements import at_point, numbers
from ..visual import Rgba, Visual, positive, read_each, rgba, scale_of
from .elements import Attributes, number, rotation_of_quaternion, several
from .inertia import frame_and_size, frame_of
from .reader import MjcfReader, with_includes

_SHOWN_GROUPS = 3
"""MuJoCo shows the first groups of geoms at first, 0 to 2; others are for collisions."""
_GREY = "0.5 0.5 0.5 1"
"""Colour of a geom that states none. It counts as none here, and the link gets its own."""


def visuals(root: ElementTree.Element, path: Path | None) -> tuple[list[Visual], list[str]]:
    """Return the visuals of a model that was read before, and messages about others.

    Args:
        root: its outermost element.
        path: the file, beside which meshes are found; None for text.
    """
    root = with_includes(root, "MJCF", path)
    reader = MjcfReader(root, "MJCF", strict=False)
    for world in root.findall("worldbody"):
        reader.read(world)
    assets = _Assets(root, reader, path)
    geoms = [
        (link, *item)
        for link, content in reader.contents
        for item in content
        if item[0].tag == "geom"
    ]
    names = [
        (link, f"geom {element.get('name')!r}" if element.get("name") else "a geom")
        for link, element, _, _ in geoms
    ]
    return read_each(names, lambda index: assets.visual(*geoms[index]))


class _Assets:
    """Meshes and materials of a model."""

    def __init__(self, root: ElementTree.Element, reader: MjcfReader, path: Path | None) -> None:
        self._compiler, self._classes = reader.compiler, reader.classes
        self._settings: dict[str, str] = {}
        for compiler in root.findall("compiler"):
            self._settings.update(compiler.attrib)
        self._meshes: dict[str, Attributes] = {}
        self._materials: dict[str, Attributes] = {}
        for kind, known in (("mesh", self._meshes), ("material", self._materials)):
            for element in root.iterfind(f"asset/{kind}"):
                attributes = reader.classes.of(element, "main", kind)
                stem = PurePosixPath(attributes.get("file", "")).stem
                known[attributes.get("name", stem)] = attributes
        self._folder = None if path is None else path.parent

    def visual(
        self, link: str, geom: ElementTree.Element, around: Array, childclass: str
    ) -> Visual | None:
        """Return a geom in a frame of its link; None for one that MuJoCo does not show at first."""
        attributes = self._classes.of(geom, childclass, "it")
        if number(attributes, "group", "0", "it") >= _SHOWN_GROUPS:
            return None
        color = self._color(attributes)
        if color is not None and color[3] == 0.0:
            return None
        kind = attributes.get("type", "sphere")
        if "mesh" in attributes:
            return self._mesh(link, attributes, around, color)
        if kind == "plane":
            half = several(attributes, "size", 2, 3, "it")[:2]
            at = around @ frame_of(attributes, self._compiler, "it")
            return Visual(link, kind, tuple(2.0 * half), at, color)
        if kind not in ("sphere", "capsule", "cylinder", "box", "ellipsoid"):
            raise ModelError(f"a geom of type {kind!r} is not read")
        frame, half = frame_and_size(attributes, kind, self._compiler, "it")
        if kind == "box":
            half = 2.0 * half
        elif kind in ("capsule", "cylinder"):
            half = np.array([half[0], 2.0 * half[1]])
        return Visual(link, kind, positive(half, "its size"), around @ frame, color)

    def _color(self, attributes: Attributes) -> Rgba | None:
        """Return the colour that a geom states, itself or by its material."""
        stated = attributes.get("rgba")
        if stated is None and "material" in attributes:
            name = attributes["material"]
            if name not in self._materials:
                raise ModelError(f"no material {name!r}; there are {choices(self._materials)}")
            stated = self._materials[name].get("rgba", "1 1 1 1")
        if stated is None or np.array_equal(numbers(stated, 4, "", "rgba"), _numbers(_GREY)):
            return None
        return rgba(stated, "rgba")

    def _mesh(self, link: str, attributes: Attributes, frame: Array, color: Rgba | None) -> Visual:
        name = attributes["mesh"]
        if name not in self._meshes:
            raise ModelError(f"no mesh {name!r}; there are {choices(self._meshes, name)}")
        asset = self._meshes[name]
        if "file" not in asset:
            raise ModelError(f"the mesh {name!r} names no file")
        file = PurePosixPath(asset["file"])
        if self._settings.get("strippath") == "true":
            file = PurePosixPath(file.name)
        directory = self._settings.get("meshdir", self._settings.get("assetdir", ""))
        # The file's points are scaled first, then seen from its reference frame.
        reference = at_point(numbers(asset.get("refpos"), 3, "0 0 0", "refpos"))
        turn = numbers(asset.get("refquat"), 4, "1 0 0 0", "refquat")
        reference[:3, :3] = rotation_of_quaternion(turn, "refquat")
        place = frame @ frame_of({**attributes, "type": "mesh"}, self._compiler, "it")
        return Visual(
            *(link, "mesh", (), place, color, str(PurePosixPath(directory) / file), self._folder),
            mesh_placement=inverse(reference),
            scale=scale_of(asset.get("scale"), f"mesh {name!r}: scale"),
        )


def _numbers(text: str) -> Array:
    return np.array([float(word) for word in text.split()])
