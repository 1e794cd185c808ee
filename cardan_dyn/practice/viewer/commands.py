"""Drawing: what a scene shows, as the page reads it.

Needs the extra `viz`: meshcat brings three.js, with which the page draws, and classes of shapes. It
is imported when the first object is drawn.
"""

from __future__ import annotations

import base64
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from ...kit.arrays import Array
from ...kit.errors import MissingExtraError

STEADY = 1e-7
"""Change of a pose, as a fraction of the scene's size, below which it needs no track: the tracks
are written in single precision, which does not resolve less."""
_MOST_SMALL_INDICES = 65535
"""Greatest count of vertices that 16 bits can tell apart."""


@cache
def meshcat() -> Any:
    """Return meshcat's `geometry`, and the `script` in which it brings three.js.

    Raises:
        MissingExtraError: meshcat is not installed; the message names the install command.
    """
    try:
        with warnings.catch_warnings():
            # meshcat's server, not used here, imports what newer versions of pyzmq deprecate.
            warnings.simplefilter("ignore")
            from meshcat import geometry
            from meshcat.servers import zmqserver
    except ImportError as error:
        raise MissingExtraError(
            'the viewer needs meshcat: pip install "cardan-dyn[viz]"'
        ) from error
    script = Path(zmqserver.VIEWER_ROOT) / "main.min.js"
    return SimpleNamespace(geometry=geometry, script=script.read_text(encoding="utf-8"))


@dataclass(frozen=True)
class Pose:
    """Where a node of the scene is, at every sample.

    Attributes:
        position: `(N, 3)` [m], or `(1, 3)` if it does not move.
        quaternion: `(N, 4)` unit quaternions x, y, z, w, or `(1, 4)`.
        scale: `(N,)` uniform scale, or `(1,)`; along three axes `(N, 3)` or `(1, 3)`.
    """

    position: Array
    quaternion: Array
    scale: Array

    @classmethod
    def of(
        cls, position: Array, quaternion: Array | None = None, scale: Array | None = None
    ) -> Pose:
        """Return a pose; what is not given is neither turned nor scaled."""
        upright = np.array([[0.0, 0.0, 0.0, 1.0]])
        return cls(
            np.atleast_2d(position),
            upright if quaternion is None else np.atleast_2d(quaternion),
            np.ones(1) if scale is None else scale,
        )


class DrawnObject(NamedTuple):
    """An object of a scene.

    Attributes:
        path: of its node.
        geometry: from `meshcat().geometry`.
        color: how it looks.
        placement: `(4, 4)` in its parent node; None where the node has a pose.
    """

    path: str
    geometry: Any
    color: Color
    placement: Array | None


class Label(NamedTuple):
    """A text of a scene: path of its node, text and CSS colour."""

    path: str
    text: str
    color: str


class Drawing:
    """Collects the objects of a scene and where they are.

    Args:
        size: size of the scene [m]; smaller movements than `STEADY` times it are left out.

    Attributes:
        nodes: path of each node that has a pose, to it.
        objects: in the order in which they were added.
        labels: the texts.
    """

    def __init__(self, size: float) -> None:
        self.nodes: dict[str, Pose] = {}
        self.objects: list[DrawnObject] = []
        self.labels: list[Label] = []
        self.size = size

    def place(self, path: str, pose: Pose) -> None:
        """Place a node, in its parent node if that has a pose."""
        self.nodes[path] = pose

    def add(self, path: str, geometry: Any, color: Color, placement: Array | None = None) -> None:
        """Add an object.

        Args:
            path: node that gets it.
            geometry: from `meshcat().geometry`.
            color: how it looks.
            placement: `(4, 4)` of the object in its parent node.
        """
        self.objects.append(DrawnObject(path, geometry, color, placement))

    def label(self, path: str, text: str, color: Color, pose: Pose) -> None:
        """Add a text."""
        self.place(path, pose)
        self.labels.append(Label(path, text, color.css))

    def packed(self, arrays: Arrays) -> dict[str, Any]:
        """Return nodes, objects and labels as the page reads them, their arrays in `arrays`."""
        shapes: dict[Any, int] = {}
        objects = []
        for item in self.objects:
            shape = _shape(item.geometry, arrays)
            index = shapes.setdefault(shape, len(shapes))
            color = item.color
            entry: dict[str, Any] = {"path": item.path, "shape": index, "color": color.css}
            if color.opacity < 1.0:
                entry["opacity"] = round(color.opacity, 3)
            if color.on_top:
                entry["layer"] = 1 + color.layer
            if item.placement is not None:
                # Column by column, as three.js has it.
                entry["placement"] = item.placement.T.ravel().tolist()
            objects.append(entry)
        return {
            "nodes": [self._track(path, pose, arrays) for path, pose in self.nodes.items()],
            "shapes": [dict(shape) for shape in shapes],
            "objects": objects,
            "labels": [item._asdict() for item in self.labels],
        }

    def _track(self, path: str, pose: Pose, arrays: Arrays) -> dict[str, Any]:
        """Return a node: its pose at the first sample, and the arrays of what changes."""
        node: dict[str, Any] = {"path": path}
        scale = pose.scale
        scale = np.repeat(scale[:, None], 3, axis=1) if scale.ndim == 1 else scale
        for name, values, tolerance in (
            ("position", pose.position, STEADY * self.size),
            ("quaternion", pose.quaternion, STEADY),
            ("scale", scale, STEADY),
        ):
            if len(values) > 1 and np.max(np.ptp(values, axis=0)) > tolerance:
                node[name] = arrays.add(values)
            else:
                node[name] = [float(value) for value in values[0]]
        return node


class Place(NamedTuple):
    """Where an array of a page is: its first byte, how many numbers it has, and their type."""

    at: int
    size: int
    kind: str


class Arrays:
    """Arrays of a page, one after the other; the same one only once."""

    def __init__(self) -> None:
        self._chunks: list[bytes] = []
        self._known: dict[tuple[str, bytes], int] = {}
        self._size = 0

    def add(self, values: Array, kind: str = "f4") -> Place:
        """Add numbers, in single precision or as integers without sign, and return their place."""
        content = np.ascontiguousarray(values, dtype=f"<{kind}").tobytes()
        at = self._known.get((kind, content))
        if at is None:
            at = self._known[kind, content] = self._size
            # Views of typed arrays start at multiples of the size of a number.
            self._chunks.append(content + bytes(-len(content) % 8))
            self._size += len(self._chunks[-1])
        return Place(at, int(np.size(values)), kind)

    def base64(self) -> str:
        """Return all arrays as one text."""
        return base64.b64encode(b"".join(self._chunks)).decode("ascii")


@dataclass(frozen=True)
class Color:
    """How an object looks.

    Attributes:
        red, green, blue, opacity: 0 to 1.
        on_top: whether it is drawn over objects that are nearer to the camera.
        layer: of objects on top, the one with the greater number covers the other.
    """

    red: float
    green: float
    blue: float
    opacity: float = 1.0
    on_top: bool = False
    layer: int = 0

    @property
    def css(self) -> str:
        """The colour as `#rrggbb`."""
        channels = (round(255 * value) for value in (self.red, self.green, self.blue))
        return "#" + "".join(f"{channel:02x}" for channel in channels)

    @classmethod
    def of(cls, css: str, **more: Any) -> Color:
        """Return the colour `#rrggbb`, with `more` of the attributes."""
        red, green, blue = (int(css[start : start + 2], 16) / 255 for start in (1, 3, 5))
        return cls(red, green, blue, **more)


def mesh(surface: tuple[Array, Array]) -> Any:
    """Return vertices `(n, 3)` [m] and faces `(m, 3)` as meshcat's geometry."""
    return meshcat().geometry.TriangularMeshGeometry(*surface)


def node_name(name: str) -> str:
    """Return a name as one step of a path: a slash in it would start another step."""
    return name.replace("/", "∕") or "-"


def _shape(geometry: Any, arrays: Arrays) -> tuple[tuple[str, Any], ...]:
    """Return a geometry as what the page makes it of, in pairs that can be compared."""
    kinds = meshcat().geometry
    if isinstance(geometry, kinds.Box):
        return (("kind", "box"), ("size", _numbers(geometry.lengths)))
    if isinstance(geometry, kinds.Sphere):
        return (("kind", "sphere"), ("radius", float(geometry.radius)))
    if isinstance(geometry, kinds.Cylinder):
        size = (geometry.radiusTop, geometry.radiusBottom, geometry.height)
        return (("kind", "cylinder"), ("size", _numbers(size)))
    if not isinstance(geometry, kinds.TriangularMeshGeometry):
        raise TypeError(f"the page draws no {type(geometry).__name__}; give its triangles")
    small = len(geometry.vertices) <= _MOST_SMALL_INDICES
    vertices = arrays.add(geometry.vertices)
    faces = arrays.add(geometry.faces, "u2" if small else "u4")
    return (("kind", "mesh"), ("vertices", vertices), ("faces", faces))


def _numbers(values: Sequence[float]) -> tuple[float, ...]:
    return tuple(float(value) for value in values)
