"""Meshcat: a scene as the commands of meshcat's viewer.

Needs the extra `viz` (meshcat); it is imported when the first object is drawn.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import MissingExtraError

STEADY = 1e-7
"""Change of a pose, as a fraction of the scene's size, below which it needs no track: the tracks
are written in single precision, which does not resolve less."""
_FOREVER = 1_000_000_000
"""Repetitions of the animation. The format has no infinite number; this many last for years."""
_FLOAT32_ARRAY = 0x17
"""Extension code of a Float32Array in msgpack-lite, with which meshcat's viewer reads."""


@cache
def meshcat() -> Any:
    """Return meshcat's `geometry` and `commands`, its `pack`, and its viewer's `script`.

    Raises:
        MissingExtraError: meshcat is not installed; the message names the install command.
    """
    try:
        with warnings.catch_warnings():
            # meshcat's server, not used here, imports what newer versions of pyzmq deprecate.
            warnings.simplefilter("ignore")
            from meshcat import commands, geometry, visualizer
            from meshcat.servers import zmqserver
    except ImportError as error:
        raise MissingExtraError(
            'the viewer needs meshcat: pip install "cardan-dyn[viz]"'
        ) from error
    script = Path(zmqserver.VIEWER_ROOT) / "main.min.js"
    return SimpleNamespace(
        geometry=geometry,
        commands=commands,
        pack=visualizer.umsgpack.packb,
        extension=visualizer.umsgpack.Ext,
        script=script.read_text(encoding="utf-8"),
    )


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


class Drawing:
    """Collects the commands of a scene and the tracks of its animation.

    Args:
        size: size of the scene [m]; smaller movements than `STEADY` times it are left out.
        times: `(N,)` of the samples [s]; no animation for a single one.

    Attributes:
        commands: the commands for meshcat's viewer in order, as mappings.
        labels: path, text and CSS colour of each label.
    """

    def __init__(self, size: float, times: Array) -> None:
        self.commands: list[dict[str, Any]] = []
        self.labels: list[tuple[str, str, str]] = []
        self._size = size
        self._times = times
        self._clips: list[dict[str, Any]] = []

    def place(self, path: str, pose: Pose) -> None:
        """Place a node at its first sample, and animate what changes."""
        tracks = []
        for name, kind, values, tolerance in (
            ("position", "vector3", pose.position, STEADY * self._size),
            ("quaternion", "quaternion", pose.quaternion, STEADY),
            ("scale", "vector3", _along_axes(pose.scale), STEADY),
        ):
            self.property(path, name, [float(value) for value in values[0]])
            if len(values) > 1 and np.max(np.ptp(values, axis=0)) > tolerance:
                tracks.append(
                    {
                        "name": f".{name}",
                        "type": kind,
                        "times": _floats(self._times),
                        "values": _floats(values),
                    }
                )
        if tracks:
            # meshcat divides times by the frames per second; with one, they stay in seconds.
            clip = {"fps": 1, "name": "sweep", "tracks": tracks}
            self._clips.append({"path": path, "clip": clip})

    def add(self, path: str, geometry: Any, color: Color, placement: Array | None = None) -> None:
        """Add an object.

        Args:
            path: node that gets it.
            geometry: from `meshcat().geometry`.
            color: how it looks.
            placement: `(4, 4)` of the object in its parent node.
        """
        tools = meshcat()
        material = tools.geometry.MeshPhongMaterial(
            color=color.number,
            opacity=color.opacity,
            transparent=color.opacity < 1.0 or color.on_top,
            side=0,
            depthTest=not color.on_top,
            depthWrite=color.opacity == 1.0 and not color.on_top,
        )
        entries = tuple(path.strip("/").split("/"))
        node = tools.commands.Path(entries)
        self.commands.append(tools.commands.SetObject(geometry, material, node).lower())
        if color.on_top:
            self.property(f"{path}/<object>", "renderOrder", 1 + color.layer)
        if placement is not None:
            self.commands.append(tools.commands.SetTransform(placement, node).lower())

    def label(self, path: str, text: str, color: Color, pose: Pose) -> None:
        """Add a text that faces the camera."""
        self.place(path, pose)
        self.labels.append((path, text, color.css))

    def property(self, path: str, name: str, value: object) -> None:
        """Set a property of a node."""
        # meshcat's own class writes names in lower case, which `renderOrder` is not.
        self.commands.append(
            {"type": "set_property", "path": path, "property": name, "value": value}
        )

    def packed(self) -> list[bytes]:
        """Return all commands, the animation last, in msgpack as meshcat's viewer reads it."""
        pack, commands = meshcat().pack, list(self.commands)
        if self._clips:
            options = {"play": True, "repetitions": _FOREVER}
            commands.append(
                {
                    "type": "set_animation",
                    "path": "",
                    "animations": self._clips,
                    "options": options,
                }
            )
        return [pack(command) for command in commands]


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
    def number(self) -> int:
        """The colour as meshcat's materials take it."""
        return int(self.css[1:], 16)

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


def _along_axes(scale: Array) -> Array:
    """Return scales `(N,)` or `(N, 3)` as `(N, 3)`."""
    return np.repeat(scale[:, None], 3, axis=1) if scale.ndim == 1 else scale


def _floats(values: Array) -> Any:
    return meshcat().extension(_FLOAT32_ARRAY, np.ascontiguousarray(values, dtype="<f4").tobytes())
