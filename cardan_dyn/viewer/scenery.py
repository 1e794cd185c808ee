"""Viewer's scene: a sweep as bodies, axes, arrows, traces and labels that move."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import ArgumentError, ModelError
from ..mechanism.joints import Joint
from ..results.sweep import Sweep
from . import shapes as forms
from .commands import Color, Drawing, Pose, meshcat
from .vectors import Vectors, collect
from .visuals import Shape, shapes

TORSION = Color.of("#c2185b", on_top=True, layer=4)
BENDING = Color.of("#1b7f3b", on_top=True, layer=5)
TOTAL = Color.of("#222222", on_top=True, layer=3)
FORCE = Color.of("#5e35b1", on_top=True, layer=6)
AXIS = Color.of("#5f6b7a", opacity=0.75, on_top=True, layer=1)
LOOP = Color.of("#0091b3", opacity=0.9, on_top=True, layer=2)

_ARROW = 0.42
"""Length of the greatest arrow, as a fraction of the radius of the scene."""


@dataclass(frozen=True)
class Parts:
    """What of a scene is drawn.

    Attributes:
        visuals: the shapes of the links.
        moments: torsion and bending as arrows.
        forces: forces as arrows.
        axes: the joint axes.
        traces: what the moment draws in the shafts that turn in bearings which stand still.
        labels: the joint names.
    """

    visuals: bool = True
    moments: bool = True
    forces: bool = True
    axes: bool = True
    traces: bool = True
    labels: bool = True


@dataclass(frozen=True)
class Scenery:
    """A scene ready to be shown.

    Attributes:
        drawing: its objects.
        legend: CSS colour and meaning of what is drawn.
        scales: what the reference arrows stand for.
        points: `(n, 3)` what the camera has to see [m].
    """

    drawing: Drawing
    legend: tuple[tuple[str, str], ...]
    scales: tuple[str, ...]
    points: Array


def build(
    sweep: Sweep, joints: tuple[str, ...], parts: Parts, times: Array, rows: Array
) -> Scenery:
    """Draw a sweep.

    Args:
        sweep: over one dimension.
        joints: whose wrenches, axes and names are drawn.
        parts: what is drawn.
        times: `(n,)` when each sample is shown [s].
        rows: `(n,)` which samples are shown.

    Raises:
        ArgumentError: no position is known of anything that could be drawn.
        MissingExtraError: meshcat is not installed.
    """
    return _Builder(sweep, joints, parts, times, rows).build()


class _Builder:
    def __init__(
        self, sweep: Sweep, joints: tuple[str, ...], parts: Parts, times: Array, rows: Array
    ) -> None:
        self.sweep, self.parts, self.rows = sweep, parts, rows
        self.joints = joints
        self.loops = {loop.joint for loop in sweep.mechanism.loops}
        self.links: dict[int, str] = {}
        for name, (body, _) in sweep.mechanism.links.items():
            self.links.setdefault(body, name)
        self.carriers = {
            joint.id: name
            for name, joint in sweep.mechanism.joints.items()
            if joint.id and name not in self.loops
        }
        self.shapes = [
            shape
            for shape in (shapes(sweep.mechanism) if parts.visuals else [])
            if self._known(shape.body)
        ]
        reached = [self._origins()]
        for shape in self.shapes:
            rotation, position = self._body(shape.body)
            moved = np.einsum("nij,kj->nki", rotation[::8], shape.corners())
            reached.append((moved + position[::8, None]).reshape(-1, 3))
        self.points = np.concatenate(reached)
        if not len(self.points):
            raise ArgumentError(
                f"{sweep.mechanism.name}: the scene's outputs leave nothing to draw"
            )
        self.low, self.high = np.min(self.points, axis=0), np.max(self.points, axis=0)
        self.radius = float(np.linalg.norm(self.high - self.low)) / 2.0
        self.radius = self.radius or sweep.mechanism.characteristic_length
        self.drawing = Drawing(self.radius, times)
        self.legend: list[tuple[str, str]] = []
        self.scales: list[str] = []
        self.arrow = forms.arrow(0.028)
        self.thin = forms.arrow(0.013)

    def build(self) -> Scenery:
        for node, hidden in (("/Grid", True), ("/Axes", True)):
            self.drawing.property(node, "visible", not hidden)
        self.drawing.property("/Background", "top_color", [0.90, 0.93, 0.96])
        self.drawing.property("/Background", "bottom_color", [1.0, 1.0, 1.0])
        self._mechanism()
        vectors = collect(self.sweep, self.joints, self.rows, self.radius)
        if self.parts.axes:
            self._axes(vectors)
        if self.parts.moments or self.parts.traces:
            self._moments(vectors)
        if self.parts.forces:
            self._forces(vectors)
        if self.parts.labels:
            self._labels(vectors)
        return Scenery(
            self.drawing,
            tuple(self.legend),
            tuple(self.scales),
            forms.extremes(self.points),
        )

    # Bodies ---------------------------------------------------------------------------------

    def _known(self, body: int) -> bool:
        return body == 0 or (
            body in self.carriers and self._origin(self.carriers[body]) is not None
        )

    def _origin(self, joint: str) -> Array | None:
        """Return where a joint is, None if the sweep leaves it out."""
        try:
            return self.sweep.origin(joint)[self.rows]
        except ModelError:
            return None

    def _body(self, body: int) -> tuple[Array, Array]:
        if body == 0:
            return np.eye(3)[None], np.zeros((1, 3))
        name = self.carriers[body]
        return self.sweep.rotation(name)[self.rows], self.sweep.origin(name)[self.rows]

    def _origins(self) -> Array:
        found = [self._origin(name) for name in self.sweep.mechanism.joints]
        known = [points for points in found if points is not None]
        return np.concatenate([np.zeros((0, 3)), *known])

    def _mechanism(self) -> None:
        used: set[str] = set()
        for body in sorted({shape.body for shape in self.shapes}):
            name = f"/mechanism/{_entry(self.links[body])}"
            rotation, position = self._body(body)
            self.drawing.place(name, Pose.of(position, quaternions(rotation)))
            for shape in (item for item in self.shapes if item.body == body):
                path = f"{name}/{_entry(shape.link)} {len(used)}"
                used.add(path)
                self._shape(path, shape)
        if not self.shapes:
            self._lines()

    def _shape(self, path: str, shape: Shape) -> None:
        geometry, placement = meshcat().geometry, shape.placement
        made: Any
        if shape.kind == "box":
            made = geometry.Box(shape.size)
        elif shape.kind == "sphere":
            made = geometry.Sphere(shape.size[0])
        elif shape.kind == "cylinder":
            made = geometry.Cylinder(shape.size[1], shape.size[0])
            placement = placement @ np.array(
                [[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]]
            )  # meshcat's cylinders stand along y.
        else:
            made = geometry.TriangularMeshGeometry(shape.vertices, shape.faces)
        self.drawing.add(path, made, Color(*shape.color[:3], opacity=shape.color[3]), placement)

    def _lines(self) -> None:
        """Draw each body as rods between its joints: a description without visuals."""
        for body, joints in self._joints_of_bodies().items():
            if not self._known(body) or len(joints) < 2:
                continue
            rotation, position = self._body(body)
            local = np.array(
                [
                    rotation[0].T @ (self.sweep.origin(name)[self.rows][0] - position[0])
                    for name in joints
                ]
            )
            middle = local.mean(axis=0)
            rods = [forms.path(np.array([middle, end]), 0.008 * self.radius) for end in local]
            rods = [item for item in rods if len(item[0])]
            if not rods:
                continue
            name = f"/mechanism/{_entry(self.links.get(body, str(body)))}"
            self.drawing.place(name, Pose.of(position, quaternions(rotation)))
            for number, item in enumerate(rods):
                grey = Color.of("#7a8794")
                self.drawing.add(f"{name}/rod {number}", _mesh(item), grey)

    def _joints_of_bodies(self) -> dict[int, list[str]]:
        model = self.sweep.mechanism.model
        found: dict[int, list[str]] = {}
        for name, joint in self.sweep.mechanism.joints.items():
            ends = {joint.id} if name not in self.loops else set()
            if joint.parts:
                ends.add(int(model.parents[joint.parts[0].id]))
            for body in ends:
                found.setdefault(body, []).append(name)
        for loop in self.sweep.mechanism.loops:
            found.setdefault(loop.successor, []).append(loop.joint)
        return found

    # Joints ---------------------------------------------------------------------------------

    def _axes(self, vectors: list[Vectors]) -> None:
        half = 0.26 * self.radius
        line = _mesh(forms.rod(0.005 * self.radius, -half, half))
        any_loop = False
        for item in vectors:
            path, loop = f"/axes/{_entry(item.name)}", item.name in self.loops
            any_loop |= loop
            color = LOOP if loop else AXIS
            turned = has_axis(self.sweep.mechanism.joints[item.name])
            quaternion = forms.towards(item.axis) if turned else None
            self.drawing.place(path, Pose.of(item.origin, quaternion))
            ball = meshcat().geometry.Sphere(0.022 * self.radius)
            if turned:
                self.drawing.add(f"{path}/line", line, color)
                for number, end in enumerate((-half, half) if loop else ()):
                    self.drawing.add(f"{path}/end {number}", ball, color, _shift(end))
                self._reach(item.origin + half * item.axis, item.origin - half * item.axis)
            else:
                self.drawing.add(f"{path}/point", ball, color)
        self.legend.append((AXIS.css, "joint axis"))
        if any_loop:
            self.legend.append((LOOP.css, "joint that closes a loop"))

    def _moments(self, vectors: list[Vectors]) -> None:
        greatest = max((item.greatest_moment for item in vectors), default=0.0)
        if not greatest > 0.0:
            return
        scale = _ARROW * self.radius / greatest
        shown = [item for item in vectors if item.greatest_moment > 1e-9 * greatest]
        drawn = set()
        for item in shown if self.parts.moments else ():
            for kind, values, color in (
                ("torsion", item.torsion, TORSION),
                ("bending", item.bending, BENDING),
            ):
                if self._arrow(f"/{kind}/{item.name}", item.anchor, scale * values, color):
                    drawn.add(kind)
        traced = [item for item in shown if self.parts.traces and item.turns]
        traced = [item for item in traced if self._trace(item, scale)]
        if "torsion" in drawn:
            self.legend.append((TORSION.css, "torsion: moment along the joint axis"))
        if "bending" in drawn:
            self.legend.append((BENDING.css, "bending: moment across the joint axis"))
        if traced:
            names = " and ".join(item.name for item in traced)
            self.legend.append((TOTAL.css, f"moment 𝔐 and its trace in the shaft: {names}"))
        if drawn or traced:
            self._reference("moment", "N·m", greatest, scale, 0)

    def _forces(self, vectors: list[Vectors]) -> None:
        greatest = max((item.greatest_force for item in vectors), default=0.0)
        moment = max((item.greatest_moment for item in vectors), default=0.0)
        if not greatest > 1e-9 * moment / self.radius:
            return
        scale = _ARROW * self.radius / greatest
        for item in vectors:
            self._arrow(f"/force/{item.name}", item.origin, scale * item.force, FORCE)
        self.legend.append((FORCE.css, "force, at the joint"))
        self._reference("force", "N", greatest, scale, 1)

    def _labels(self, vectors: list[Vectors]) -> None:
        for item in vectors:
            loop = item.name in self.loops
            text = f"{item.name} (loop)" if loop else item.name
            color = LOOP if loop else Color.of("#333333")
            self.drawing.label(f"/labels/{_entry(item.name)}", text, color, Pose.of(item.label))
            self._reach(item.label)

    def _arrow(
        self, path: str, tail: Array, vectors: Array, color: Color, thin: bool = False
    ) -> bool:
        """Draw vectors `(N, 3)` [m] as an arrow of changing length; not if they are all zero."""
        head, _, name = path.rpartition("/")
        path = f"{head}/{_entry(name)}"
        direction, length = forms.filled(vectors, 1e-4 * self.radius)
        if np.max(length) < 1e-3 * self.radius:
            return False
        # A scale of zero has no inverse, which the viewer needs for its normals.
        length = np.maximum(length, 1e-5 * self.radius)
        self.drawing.place(path, Pose.of(tail, forms.towards(direction), length))
        self.drawing.add(path, _mesh(self.thin if thin else self.arrow), color)
        self._reach(tail + vectors)
        return True

    def _trace(self, item: Vectors, scale: float) -> bool:
        """Draw the tip of the moment as a curve in the joint's own axes."""
        curve = scale * item.moment
        stride = max(1, len(curve) // 180)
        points = np.concatenate([curve[::stride], curve[-1:]])
        wire = forms.path(points, 0.006 * self.radius)
        total = np.einsum("nij,nj->ni", item.rotation, curve)
        self._arrow(f"/moment/{item.name}", item.anchor, total, TOTAL, thin=True)
        if not len(wire[0]) or np.max(np.ptp(points, axis=0)) < 1e-3 * self.radius:
            return False
        path = f"/traces/{_entry(item.name)}"
        self.drawing.place(path, Pose.of(item.anchor, quaternions(item.rotation)))
        self.drawing.add(path, _mesh(wire), TOTAL)
        return True

    def _reference(self, kind: str, unit: str, greatest: float, scale: float, number: int) -> None:
        """Draw an arrow of a round size beside the mechanism, with its size."""
        value = forms.rounded(greatest)
        color = TOTAL if kind == "moment" else FORCE
        tail = np.array(
            [self.low[0], self.low[1] - 0.12 * self.radius, self.low[2] - 0.12 * self.radius]
        ) - number * np.array([0.0, 0.0, 0.16 * self.radius])
        path = f"/scale/{kind}"
        tip = tail + np.array([scale * value, 0.0, 0.0])
        self._arrow(path, tail[None], (tip - tail)[None], color)
        text = f"{value:g} {unit}"
        beside = tip + np.array([0.12 * self.radius, 0.0, 0.0])
        self.drawing.label(f"{path} text", text, color, Pose.of(beside))
        self._reach(tail, tip, beside)
        self.scales.append(f"scale arrow: {kind} of {text}, greatest {greatest:.4g} {unit}")

    def _reach(self, *points: Array) -> None:
        self.points = np.concatenate([self.points, *(np.atleast_2d(item) for item in points)])


def has_axis(joint: Joint) -> bool:
    """Return whether a joint has one axis that its child keeps."""
    return joint.type not in ("spherical", "universal", "floating", "fixed")


def quaternions(rotations: Array) -> Array:
    """Return quaternions x, y, z, w `(N, 4)` of rotation matrices `(N, 3, 3)`."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(rotations).as_quat())


def _mesh(surface: tuple[Array, Array]) -> Any:
    return meshcat().geometry.TriangularMeshGeometry(surface[0], surface[1])


def _shift(height: float) -> Array:
    placement = np.eye(4)
    placement[2, 3] = height
    return placement


def _entry(name: str) -> str:
    """Return a name as one step of a meshcat path."""
    return name.replace("/", "∕") or "-"
