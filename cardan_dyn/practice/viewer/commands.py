"""Drawing: what a scene shows, as the page reads it.

Needs the extra `viz`: meshcat brings three.js, with which the page draws.
"""

from __future__ import annotations

import base64
import warnings
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...kit.arrays import Array
from ...kit.errors import MissingExtraError
from .shapes import PIXEL, Surface, arrow, filled, towards

STEADY = 1e-7
"""Change of a pose, as a fraction of the scene's size, below which it needs no track: the tracks
are written in single precision, which does not resolve less."""


@cache
def meshcat() -> str:
    """Return the script in which meshcat brings three.js.

    Raises:
        MissingExtraError: meshcat is not installed; the message names the install command.
    """
    try:
        with warnings.catch_warnings():
            # meshcat's server, not used here, imports what newer versions of pyzmq deprecate.
            warnings.simplefilter("ignore")
            from meshcat.servers import zmqserver
    except ImportError as error:
        raise MissingExtraError(
            'the viewer needs meshcat: pip install "cardan-dyn[viz]"'
        ) from error
    return (Path(zmqserver.VIEWER_ROOT) / "main.min.js").read_text(encoding="utf-8")


class Pose:
    """Where a node of the scene is, at every sample.

    Attributes:
        position: `(N, 3)` [m], or `(1, 3)` if it does not move.
        quaternion: `(N, 4)` unit quaternions x, y, z, w, or `(1, 4)`.
        scale: along three axes `(N, 3)` or `(1, 3)`.
    """

    def __init__(
        self, position: Array, quaternion: ArrayLike = (0, 0, 0, 1), scale: ArrayLike = 1.0
    ) -> None:
        """Keep a pose; one for all samples may have no dimension for them.

        Args:
            position: see above.
            quaternion: see above; not turned if not given.
            scale: see above, or a uniform one, a number or `(N,)`.
        """
        scales = np.asarray(scale, float)
        self.position, self.quaternion = np.atleast_2d(position), np.atleast_2d(quaternion)
        self.scale = np.ones(3) * (scales if scales.ndim == 2 else scales.reshape(-1, 1))


class DrawnObject(NamedTuple):
    """An object of a scene.

    Attributes:
        path: of its node.
        surface: see `shapes`.
        color: how it looks.
        placement: `(4, 4)` in its parent node; None where the node has a pose.
    """

    path: str
    surface: Surface
    color: Color
    placement: Array | None


class Label(NamedTuple):
    """A text of a scene: path of its node, text and CSS colour."""

    path: str
    text: str
    color: str


class Meaning(NamedTuple):
    """What a colour means: its CSS notation, a text, and the first step of what has it."""

    color: str
    text: str
    part: str


class Drawing:
    """Collects the objects of a scene, where they are, and what is told of them.

    Args:
        size: radius of the scene [m]; smaller movements than `STEADY` times it are left out.

    Attributes:
        nodes: path of each node that has a pose, to it.
        objects: in the order in which they were added.
        labels: the texts.
        seen: points `(n, 3)` that the camera has to see [m].
        legend: what the colours mean, each once.
    """

    def __init__(self, size: float) -> None:
        self.nodes: dict[str, Pose] = {}
        self.objects: list[DrawnObject] = []
        self.labels: list[Label] = []
        self.seen: list[Array] = []
        self.size = size
        self.legend: list[Meaning] = []

    def add(
        self,
        path: str,
        surface: Surface,
        color: Color,
        placement: Array | None = None,
        *,
        pose: Pose | None = None,
        means: str = "",
    ) -> None:
        """Add an object.

        Args:
            path: node that gets it.
            surface: see `shapes`.
            color: how it looks.
            placement: `(4, 4)` of the object in its parent node.
            pose: of the node, in its parent node if that has one.
            means: what the legend says of the colour.
        """
        if pose is not None:
            self.nodes[path] = pose
        meaning = Meaning(color.css, means, path.split("/")[1])
        if means and meaning not in self.legend:
            self.legend.append(meaning)
        self.objects.append(DrawnObject(path, surface, color, placement))

    def arrow(
        self,
        path: str,
        tail: Array,
        vectors: Array,
        color: Color,
        means: str,
        surface: Surface | None = None,
    ) -> bool:
        """Add an arrow as long as vectors, unless it is never as long as a pixel.

        Args:
            path: node that gets it.
            tail: `(n, 3)` where it starts [m].
            vectors: `(n, 3)` [m].
            color: how it looks.
            means: see `add`.
            surface: what is drawn instead, about z and as large as 1.

        Returns:
            Whether it was added.
        """
        least = PIXEL * self.size
        # The direction of what is far shorter may be rounding, and the arrow would flicker. A
        # scale of zero would have no inverse, which the page needs for normals.
        direction, length = filled(vectors, 1e-3 * least)
        length = np.maximum(length, 1e-3 * least)
        if np.max(length) < least:
            return False
        pose = Pose(tail, towards(direction), length)
        self.add(path, surface or arrow(), color, pose=pose, means=means)
        self.include(tail, tail + direction * length[:, None])
        return True

    def include(self, *points: Array) -> None:
        """Make sure that the camera sees points `(3,)` or `(n, 3)` [m]."""
        self.seen += [np.atleast_2d(item) for item in points]

    def label(self, path: str, text: str, color: Color, pose: Pose) -> None:
        """Add a text."""
        self.nodes[path] = pose
        self.labels.append(Label(path, text, color.css))

    def packed(self, arrays: Arrays) -> dict[str, Any]:
        """Return nodes, objects and labels as the page reads them, their arrays in `arrays`."""
        shapes: dict[tuple[Place, Place], int] = {}
        objects: list[dict[str, Any]] = []
        for item in self.objects:
            (vertices, faces), color = item.surface, item.color
            # Sixteen bits tell so many vertices apart.
            kind = "u2" if len(vertices) < 1 << 16 else "u4"
            shape = arrays.add(vertices), arrays.add(faces, kind)
            index = shapes.setdefault(shape, len(shapes))
            entry = {"path": item.path, "shape": index, "color": color.css}
            entry |= {"opacity": color.opacity, "layer": color.layer}
            if item.placement is not None:
                # Column by column, as three.js has it.
                entry["placement"] = item.placement.T.ravel().tolist()
            objects.append(entry)
        return {
            "nodes": [self._track(path, pose, arrays) for path, pose in self.nodes.items()],
            "shapes": [*shapes],
            "objects": objects,
            "labels": [item._asdict() for item in self.labels],
        }

    def _track(self, path: str, pose: Pose, arrays: Arrays) -> dict[str, Any]:
        """Return a node: its pose at the first sample, and the arrays of what changes."""
        node: dict[str, Any] = {"path": path}
        for name, values, tolerance in (
            ("position", pose.position, STEADY * self.size),
            ("quaternion", pose.quaternion, STEADY),
            ("scale", pose.scale, STEADY),
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


class Color(NamedTuple):
    """How an object looks.

    Attributes:
        red, green, blue, opacity: 0 to 1.
        layer: 0 among other objects in space; those of a greater one cover those of smaller ones,
            even where these are nearer to the camera.
    """

    red: float
    green: float
    blue: float
    opacity: float = 1.0
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


def node_name(name: str) -> str:
    """Return a name as one step of a path: a slash in it would start another step."""
    return name.replace("/", "∕") or "-"
