"""Viewer's scene: a sweep as bodies, axes, arrows, traces and labels that move."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...core.mechanism.joints import Joint
from ...core.results.limits import efforts
from ...core.results.sweep import Sweep
from ...core.results.wrench import WITHOUT_AXIS
from ...figures.wrenches import PARTS, whole_of
from ...kit.arrays import NOTHING, Array
from ...kit.errors import ArgumentError
from . import shapes as forms
from .bodies import Bodies
from .commands import Color, Drawing, Pose, node_name
from .load_shapes import draw_drives, draw_gravity, draw_loads, without_loads
from .places import Places
from .still import Still
from .vectors import Vectors, collect, greatest, legible

AXIS = Color.of("#5f6b7a", opacity=0.75, layer=1)
LOOP = Color.of("#0091b3", opacity=0.9, layer=2)
PATH = Color.of("#283593", opacity=0.9, layer=1)
_LABEL = Color.of("#333333")

COLORS = {
    "torsion": Color.of("#c2185b", layer=4),
    "bending": Color.of("#1b7f3b", layer=5),
    "moment": Color.of("#222222", layer=3),
    "force": Color.of("#5e35b1", layer=6),
    "axial": Color.of("#00838f", layer=5),
    "shear": Color.of("#b35900", layer=6),
}
"""Colours of the parts of wrenches, as arrows and as curves."""
MEANINGS = {
    "torsion": "torsion: moment along the joint axis",
    "bending": "bending: moment across the joint axis",
    "force": "force in a joint without an axis",
    "axial": "axial: force along the joint axis",
    "shear": "shear: force across the joint axis",
}
"""What arrows of the parts of wrenches mean."""
_THIN = 0.005
"""Radius of axes and traces, in radii of the scene."""


class Parts(NamedTuple):
    """What of a scene is drawn.

    Attributes:
        visuals: the shapes of the links.
        moments: torsion and bending as arrows.
        forces: forces as arrows.
        axes: the joint axes.
        traces: the curve that the moment traces in each shaft that turns in a fixed bearing.
        labels: the joint names.
        elements: springs, dampers, bushings, friction and actuators.
        loads: loads on joints and links.
    """

    visuals: bool
    moments: bool
    forces: bool
    axes: bool
    traces: bool
    labels: bool
    elements: bool
    loads: bool


class Scale(NamedTuple):
    """How long arrows are.

    Attributes:
        kind: `moment` or `force`.
        unit: of their sizes.
        per_metre: size of an arrow as long as one metre.
        longest: size beyond which arrows are cut; None where none is.
    """

    kind: str
    unit: str
    per_metre: float
    longest: float | None


class Scenery(NamedTuple):
    """A scene ready to be shown.

    Attributes:
        drawing: its objects, and what the colours mean.
        scales: how long arrows are.
        points: `(n, 3)` what the camera has to see [m].
        notes: what of the links is drawn otherwise than their description says, and why.
        bearings: joints of those that are drawn which are on the ground or driven; all where none
            is. Their wrenches are asked for first. The nodes of a joint are `/force/NAME`,
            `/torsion/NAME`, `/bending/NAME`, `/moment/NAME`, `/traces/NAME`, `/axes/NAME` and
            `/labels/NAME`.
        normal: of x, y and z, 0 to 2, the one across which the plane of a linkage lies; None of one
            in space.
    """

    drawing: Drawing
    scales: tuple[Scale, ...]
    points: Array
    notes: tuple[str, ...] = ()
    bearings: tuple[str, ...] = ()
    normal: int | None = None


def build(
    sweep: Sweep | Still,
    joints: tuple[str, ...],
    parts: Parts,
    samples: Array,
    swings: frozenset[str] = frozenset(),
    paths: Mapping[str, Array] | None = None,
) -> Scenery:
    """Draw a sweep.

    Args:
        sweep: over one dimension.
        joints: whose wrenches, axes and names are drawn.
        parts: what is drawn.
        samples: `(n,)` indices of the samples that are shown.
        swings: coordinates that swing as in a mode, and are driven by nothing.
        paths: names of points to where they are at all samples `(N, 3)` [m].

    Raises:
        ArgumentError: no position is known of anything that could be drawn.
        MissingExtraError: meshcat is not installed.
    """
    bodies = Bodies(sweep, samples, parts.visuals)
    points = bodies.points()
    if not len(points):
        raise ArgumentError(f"{sweep.mechanism.name}: the scene's outputs leave nothing to draw")
    extent = float(np.linalg.norm(np.max(points, axis=0) - np.min(points, axis=0)))
    radius = extent / 2.0 or sweep.mechanism.characteristic_length
    drawing = Drawing(radius)
    drawing.include(points)
    builder = _Builder(drawing, bodies.loops)
    bodies.draw(drawing)
    on_ground, joint_of = bodies.on_ground(), sweep.mechanism.joints
    vectors = collect(sweep, joints, samples, radius)
    loaded = sweep if parts.loads and isinstance(sweep, Sweep) else None
    places = Places(sweep, samples, radius)
    if loaded:
        vectors = without_loads(vectors, loaded, places)
    if parts.axes:
        builder.draw_axes(vectors, joint_of)
    if parts.moments or parts.traces:
        traced = {
            name
            for name in (on_ground if parts.traces else ())
            if name not in bodies.loops and joint_of[name].type in ("revolute", "continuous")
        }
        builder.draw_moments(vectors, parts.moments, traced)
    if parts.forces:
        builder.draw_forces(vectors)
    for name, path in (paths or {}).items():
        builder.draw_path(name, path, samples)
    if parts.labels:
        builder.draw_labels(vectors)
    if parts.elements and sweep.elements:
        from .element_shapes import draw_elements  # Most scenes have none.

        draw_elements(drawing, sweep.elements, places)
    if loaded:
        draw_loads(drawing, loaded, places)
        draw_drives(drawing, places, [name for name in loaded.drives if name not in swings])
        if loaded.gravity.ndim == 1 and np.any(loaded.gravity):
            draw_gravity(drawing, loaded.gravity, points)
    drivable, driven = sweep.mechanism.drivable, set[str]()
    if isinstance(sweep, Sweep):
        driven = {drivable[name].joint for name in efforts(sweep) if name not in sweep.held}
    bearings = tuple(name for name in joints if name in on_ground or name in driven) or joints
    seen = forms.extremes(np.concatenate(drawing.seen))
    return Scenery(drawing, tuple(builder.scales), seen, bodies.notes, bearings, bodies.normal())


class _Builder:
    """Draws what belongs to joints, and collects how long its arrows are.

    Args:
        drawing: what it draws on.
        loops: names of the joints that close loops.
    """

    def __init__(self, drawing: Drawing, loops: frozenset[str]) -> None:
        self.drawing, self._radius = drawing, drawing.size
        self._loops = loops
        self.scales: list[Scale] = []

    def draw_axes(self, vectors: list[Vectors], joints: Mapping[str, Joint]) -> None:
        """Draw the axes of joints, a ball for a joint without one; mark those of loops.

        That of a slide goes from one end of its stroke to the other, and stays with the parent.
        """
        ball, disc = forms.capsule(0.022), forms.rod(0.022, -_THIN, _THIN)
        for item in vectors:
            path, loop = f"/axes/{node_name(item.name)}", item.name in self._loops
            means = "joint that closes a loop" if loop else "joint axis, of a slide its stroke"
            color = LOOP if loop else AXIS
            turn, size = forms.towards(item.axis), self._radius
            if not has_axis(joints[item.name]):
                pose = Pose(item.origin, turn, size)
                self.drawing.add(path, ball, color, pose=pose, means=means)
                continue
            low, high = (float(end) / self._radius for end in (min(item.slide), max(item.slide)))
            strokes = high - low > forms.PIXEL
            low, high = (low, high) if strokes else (-0.26, 0.26)
            middle = item.origin - (item.slide[:, None] * item.axis if strokes else 0.0)
            ends = np.outer([low, high], [0.0, 0.0, 1.0]) if loop or strokes else ()
            marks = [forms.moved(ball if loop else disc, np.eye(3), end) for end in ends]
            line = forms.joined(forms.rod(_THIN, low, high), *marks)
            pose = Pose(middle, turn, size)
            self.drawing.add(path, line, color, pose=pose, means=means)
            reach = self._radius * item.axis
            self.drawing.include(middle + low * reach, middle + high * reach)

    def draw_moments(self, vectors: list[Vectors], arrows: bool, turning: Collection[str]) -> None:
        """Draw torsion and bending as arrows, and their scale.

        In joints about which shafts are `turning`, whole moments are drawn with their traces.
        """
        found = self._scale_of("moment", "N·m", vectors)
        if found is None:
            return
        scale, least = 1.0 / found.per_metre, NOTHING * found.per_metre * self._radius
        shown = [item for item in vectors if greatest(item.moment) > least]
        drawn = self._draw_parts(shown, scale, PARTS["moment"]) if arrows else False
        traced = [self._draw_trace(item, scale) for item in shown if item.name in turning]
        if drawn or any(traced):
            self.scales.append(found)

    def draw_forces(self, vectors: list[Vectors]) -> None:
        """Draw forces as arrows along and across the axes of joints, and their scale."""
        found = self._scale_of("force", "N", vectors)
        if found is not None:
            kinds = ("force", *PARTS["force"])
            self._draw_parts(vectors, 1.0 / found.per_metre, kinds)
            self.scales.append(found)

    def _scale_of(self, kind: str, unit: str, vectors: list[Vectors]) -> Scale | None:
        """Return how long arrows of forces or moments are; None where these are rounding."""
        most = max((greatest(getattr(item, kind)) for item in vectors), default=0.0)
        if not most > NOTHING * whole_of(vectors, self._radius)[unit]:
            return None
        longest = legible(getattr(item, kind) for item in vectors)
        cut = longest if longest < most else None
        return Scale(kind, unit, longest / (forms.ARROW * self._radius), cut)

    def draw_path(self, name: str, path: Array, samples: Array) -> None:
        """Draw the path of a point, and the point at some of its samples."""
        node, means = f"/paths/{node_name(name)}", f"path of {name}"
        wire = forms.path(path, _THIN * self._radius)
        self.drawing.add(node, wire, PATH, means=means)
        pose = Pose(path[samples], scale=self._radius)
        self.drawing.add(f"{node} point", forms.capsule(3.0 * _THIN), PATH, pose=pose)
        self.drawing.include(path)

    def draw_labels(self, vectors: list[Vectors]) -> None:
        """Write the names of joints."""
        for item in vectors:
            color = LOOP if item.name in self._loops else _LABEL
            path = f"/labels/{node_name(item.name)}"
            self.drawing.label(path, item.name, color, Pose(item.anchor))

    def _draw_parts(self, vectors: list[Vectors], scale: float, kinds: Sequence[str]) -> bool:
        """Draw parts of wrenches as arrows, and return whether there are any."""
        drawn = [
            self.drawing.arrow(
                f"/{kind}/{node_name(item.name)}",
                item.anchor if kind in PARTS["moment"] else item.origin,
                self._cut(scale * item.parts[kind]),
                COLORS[kind],
                MEANINGS[kind],
            )
            for item in vectors
            for kind in kinds
            if kind in item.parts
        ]
        return any(drawn)

    def _cut(self, vectors: Array) -> Array:
        """Return vectors `(N, 3)` [m] that are no longer than the longest arrow."""
        size = np.linalg.norm(vectors, axis=1, keepdims=True)
        return vectors * np.minimum(1.0, forms.ARROW * self._radius / np.maximum(size, NOTHING))

    def _draw_trace(self, item: Vectors, scale: float) -> bool:
        """Draw the moment and the trace of its tip in the joint; return whether it leaves one.

        A moment that stays along the axis leaves none: the arrow of its torsion says all of it.
        """
        least = forms.PIXEL * self._radius
        if scale * np.max(np.linalg.norm(item.parts["bending"], axis=1)) < least:
            return False
        curve = self._cut(scale * item.moment)
        if np.max(np.ptp(curve, axis=0)) < least:
            return False
        moment = np.einsum("nij,nj->ni", item.rotation, curve)
        name, means = node_name(item.name), "moment 𝔐 and its trace in the shaft"
        thin = forms.arrow(0.5 * forms.ARROW_RADIUS)
        self.drawing.arrow(f"/moment/{name}", item.anchor, moment, COLORS["moment"], means, thin)
        pose = Pose(item.anchor, forms.quaternions(item.rotation))
        wire = forms.path(curve, _THIN * self._radius)
        self.drawing.add(f"/traces/{name}", wire, COLORS["moment"], pose=pose)
        return True


def has_axis(joint: Joint) -> bool:
    """Return whether a joint has one axis that its child keeps."""
    return joint.type not in (*WITHOUT_AXIS, "universal")
