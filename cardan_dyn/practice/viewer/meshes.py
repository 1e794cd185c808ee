"""Meshes of visuals: where their files are, their triangles and colours, fewer where too many.

`trimesh` reads them (STL, OBJ, GLTF; DAE with `pycollada`); lengths are metres unless a DAE file
states its unit. Axes stay those of the file.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pinocchio

from ...kit.errors import ModelError
from .shapes import SMOOTH, Surface, joined

FORMATS = (".stl", ".obj", ".dae", ".gltf", ".glb", ".ply", ".off")
_NAMED = ("package", "model")
"""Schemes of names that start with that of a package."""
_VARIABLES = (
    "ROS_PACKAGE_PATH",
    *("AMENT_PREFIX_PATH", "GZ_SIM_RESOURCE_PATH", "GAZEBO_MODEL_PATH", "SDF_PATH"),
)
"""Environment variables that list directories of packages or models."""
_is_file = os.path.isfile  # Of a name that is too long, Path.is_file raises an error.


class Colored(NamedTuple):
    """Triangles of one colour.

    Attributes:
        surface: vertices `(n, 3)` [m] and faces `(m, 3)`.
        color: red, green, blue and opacity, 0 to 1; None where the file gives none.
    """

    surface: Surface
    color: tuple[float, float, float, float] | None


def find_mesh(name: str, folder: Path | None) -> Path | None:
    """Return a mesh's file; None if it does not exist, see `searched`.

    Args:
        name: `package://PACKAGE/PATH`, `model://MODEL/PATH`, `file://PATH`, or a path.
        folder: where a relative path starts; None for the current directory.
    """
    scheme, rest = _parted(name)
    if not rest or scheme not in ("", "file", *_NAMED):
        return None
    return next((path for path in _candidates(scheme, rest, folder) if _is_file(path)), None)


def searched(name: str, folder: Path | None) -> str:
    """Return where the file of a mesh was looked for, for messages."""
    scheme, _ = _parted(name)
    if scheme not in ("", "file", *_NAMED):
        return f"{scheme}:// is not read; give a file of this machine"
    start = folder or Path.cwd()
    if scheme not in _NAMED:
        return f"looked in {start}"
    variable = f"{_VARIABLES[0]} ({os.environ.get(_VARIABLES[0]) or 'not set'})"
    return f"looked in {start}, in the directories above it and in those of {variable}"


def _parted(name: str) -> tuple[str, str]:
    """Return the scheme of a name, empty for a path, and the rest."""
    scheme, separator, rest = name.partition("://")
    return (scheme, rest) if separator else ("", name)


def _candidates(scheme: str, rest: str, folder: Path | None) -> Iterator[Path]:
    """Yield the files that a name may mean, the likeliest first."""
    start = folder or Path.cwd()
    if scheme not in _NAMED:
        yield start / rest
        return
    if rest.startswith("/"):
        # `package:///…` has no package: an absolute path, or one from a directory above.
        yield Path(rest)
        rest = rest.lstrip("/")
    above = [start.resolve(), *start.resolve().parents]
    listed = [
        Path(entry)
        for variable in _VARIABLES
        for entry in os.environ.get(variable, "").split(os.pathsep)
        if entry
    ]
    # An entry may be the package itself, hold packages, or be a prefix where they are installed.
    listed = [path for entry in listed for path in (entry, entry.parent, entry / "share")]
    # Robots that are installed beside Pinocchio, as those of example-robot-data.
    listed += [path / "share" for path in Path(pinocchio.__file__).parents]
    for directory in (*above, *listed):
        yield directory / rest
    # The package's own directory may be called otherwise, as that of a clone.
    inside = rest.partition("/")[2]
    for directory in above if inside else ():
        if _is_file(directory / "package.xml"):
            yield directory / inside


def read_mesh(path: Path, part: str = "") -> tuple[Colored, ...]:
    """Return the triangles of a file, one surface for each of its colours.

    Args:
        path: the file.
        part: name of the part that is read; empty for all of it.

    Raises:
        ModelError: its kind is unknown, it cannot be read or has no triangles, or no such part, or
            what reads it is not installed.
    """
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise ModelError(f"{path}: a mesh of this kind is not read; convert it to .stl or .glb")
    try:
        import trimesh  # noqa: F401  # Reported by itself.
    except ImportError as error:
        raise ModelError(f'{path}: meshes need trimesh: pip install "cardan-dyn[viz]"') from error
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Of libraries about files that are read nonetheless.
            found = list(_surfaces(path, part))
    except Exception as error:  # What is broken may break anything in a reader.
        raise ModelError(f"{path}: the mesh cannot be read ({error})") from error
    if not found:
        raise ModelError(f"{path}: the mesh has no triangles" + f" in part {part!r}" * bool(part))
    if not all(np.all(np.isfinite(item.surface[0])) for item in found):
        raise ModelError(f"{path}: the mesh has points that are not finite")
    colors = dict.fromkeys(item.color for item in found)
    return tuple(
        Colored(_together([item.surface for item in found if item.color == color]), color)
        for color in colors
    )


def _surfaces(path: Path, part: str) -> Iterator[Colored]:
    """Yield what trimesh reads, placed in the file's own axes; a DAE file states its unit."""
    import trimesh

    scene = trimesh.load_scene(path, process=False)
    for node in scene.graph.nodes_geometry:
        transform, name = scene.graph[node]
        mesh = scene.geometry[name]
        faces = np.asarray(getattr(mesh, "faces", ()))
        if len(faces) and part in ("", name, node):
            unit = str(mesh.metadata.get("units", "")).partition(" * ")
            scale = float(unit[0]) if unit[1] else 1.0
            vertices = scale * (mesh.vertices @ transform[:3, :3].T + transform[:3, 3])
            yield Colored((vertices, faces), _color(mesh.visual))


def _color(visual: Any) -> tuple[float, float, float, float] | None:
    """Return the colour of a mesh; of a texture, its mean."""
    if visual is None or not visual.defined:
        return None
    material = getattr(visual, "material", None)
    color = visual.main_color if material is None else material.main_color
    if material is not None:
        image = getattr(material, "baseColorTexture", None) or getattr(material, "image", None)
        stated = getattr(material, "baseColorFactor", getattr(material, "diffuse", None))
        if image is not None:
            color = np.asarray(image.convert("RGBA")).reshape(-1, 4).mean(axis=0)
        elif stated is None or np.array_equal(stated, (102, 102, 102, 255)):
            return None  # That is what trimesh gives to a material without one.
    red, green, blue, opacity = (np.asarray(color, dtype=float) / 255.0).round(4).tolist()
    return red, green, blue, opacity


def _together(surfaces: list[Surface]) -> Surface:
    """Return surfaces of one colour as one, without the points that repeat."""
    every = joined(*surfaces)
    size = float(np.max(np.ptp(every[0], axis=0)))
    # Points that are nearer to each other are one in what files mean.
    return thinned(every, 1e-6 * size)


def thinned(surface: Surface, cell: float) -> Surface:
    """Return a surface whose points in one cube are one, and that has no triangle without area.

    Args:
        surface: the surface.
        cell: edge of a cube [m].
    """
    vertices, faces = surface
    low, size = np.min(vertices, axis=0), float(np.max(np.ptp(vertices, axis=0)))
    boxes = ((vertices - low) / (max(cell, size / (1 << 20)) or 1.0)).round().astype(np.int64)
    # Three numbers of 21 bits fit into one.
    keys = boxes @ [1 << 42, 1 << 21, 1]
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    faces = inverse[faces]
    proper = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2])
    faces = faces[proper & (faces[:, 2] != faces[:, 0])]
    used, faces = np.unique(faces, return_inverse=True)
    return vertices[first[used]], faces.reshape(-1, 3)


def creased(surface: Surface) -> Surface:
    """Return a surface whose points are doubled along its edges, which are then seen as edges."""
    import trimesh

    vertices, faces = surface
    whole = trimesh.Trimesh(vertices, faces, process=False)
    flat = whole.face_adjacency[whole.face_adjacency_angles < SMOOTH]
    patches = trimesh.graph.connected_component_labels(flat, node_count=len(faces))
    # A corner is a point of a patch; points that several patches share are doubled.
    count = len(faces)
    corners, faces = np.unique(faces * count + patches[:, None], return_inverse=True)
    return vertices[corners // count], faces.reshape(-1, 3)
