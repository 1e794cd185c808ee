"""Viewer's scene: a sweep as bodies, axes, arrows, traces and labels that move."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...core.mechanism.joints import Joint
from ...core.results.sweep import Sweep
from ...core.results.wrench import WITHOUT_AXIS
from ...figures.wrenches import PARTS, together
from ...kit.arrays import NOTHING, Array
from ...kit.errors import ArgumentError
from . import shapes as forms
from .bodies import Bodies
from .commands import Color, Drawing, Pose, mesh, meshcat, node_name
from .still import Still
from .vectors import Vectors, collect, legible

TORSION = Color.of("#c2185b", on_top=True, layer=4)
BENDING = Color.of("#1b7f3b", on_top=True, layer=5)
TOTAL = Color.of("#222222", on_top=True, layer=3)
FORCE = Color.of("#5e35b1", on_top=True, layer=6)
AXIAL = Color.of("#00838f", on_top=True, layer=5)
SHEAR = Color.of("#b35900", on_top=True, layer=6)
AXIS = Color.of("#5f6b7a", opacity=0.75, on_top=True, layer=1)
LOOP = Color.of("#0091b3", opacity=0.9, on_top=True, layer=2)
LOAD = Color.of("#b71c1c", on_top=True, layer=7)
DRIVE = Color.of("#00695c", opacity=0.9, on_top=True, layer=2)
GRAVITY = Color.of("#455a64", on_top=True, layer=2)
_LABEL = Color.of("#333333")

# Lengths in the drawing are fractions of the radius of the scene, chosen for legibility.
_HALF_AXIS, _AXIS_RADIUS, _BALL_RADIUS = 0.26, 0.005, 0.022
"""Half the length of a joint axis, its radius and that of traces, and that of the balls at the ends
of a loop's."""
_TRACE_POINTS = 180
"""About how many points make a trace: one every 2° of a revolution looks smooth."""
MEANINGS = {
    "torsion": "torsion: moment along the joint axis",
    "bending": "bending: moment across the joint axis",
    "force": "force in a joint without an axis",
    "axial": "axial: force along the joint axis",
    "shear": "shear: force across the joint axis",
}
"""What arrows of the parts of wrenches mean."""
_SMALLEST_SHOWN = 1e-3
"""Length below which an arrow or a trace is not drawn: less than a pixel on a screen on which the
scene is about 1000 pixels wide."""
_DIRECTION_KNOWN = 1e-4
"""Length below which an arrow keeps its last direction: that of so short a vector may be
rounding, and the arrow would flicker."""


@dataclass(frozen=True)
class Parts:
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

    visuals: bool = True
    moments: bool = True
    forces: bool = True
    axes: bool = True
    traces: bool = True
    labels: bool = True
    elements: bool = True
    loads: bool = True


class Meaning(NamedTuple):
    """What a colour means: its CSS notation, a text, and the first step of what has it."""

    color: str
    text: str
    part: str


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


@dataclass(frozen=True)
class Scenery:
    """A scene ready to be shown.

    Attributes:
        drawing: its objects.
        legend: what the colours mean.
        scales: how long arrows are.
        points: `(n, 3)` what the camera has to see [m].
        notes: what of the links is drawn otherwise than their description says, and why.
        bearings: joints of those that are drawn which are on the ground; all where none is. Their
            wrenches are asked for first. The nodes of a joint are `/force/NAME`, `/torsion/NAME`,
            `/bending/NAME`, `/moment/NAME`, `/traces/NAME`, `/axes/NAME` and `/labels/NAME`.
        spread: extents of where joints are along x, y and z [m]; by these a linkage is flat.
    """

    drawing: Drawing
    legend: tuple[Meaning, ...]
    scales: tuple[Scale, ...]
    points: Array
    notes: tuple[str, ...] = ()
    bearings: tuple[str, ...] = ()
    spread: tuple[float, ...] = (0.0, 0.0, 0.0)


def build(
    sweep: Sweep | Still,
    joints: tuple[str, ...],
    parts: Parts,
    samples: Array,
    swings: frozenset[str] = frozenset(),
) -> Scenery:
    """Draw a sweep.

    Args:
        sweep: over one dimension.
        joints: whose wrenches, axes and names are drawn.
        parts: what is drawn.
        samples: `(n,)` indices of the samples that are shown.
        swings: coordinates that swing as in a mode, and are driven by nothing.

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
    builder = _Builder(Drawing(radius), radius, points, bodies.loops)
    bodies.draw(builder.drawing, radius)
    vectors = collect(sweep, joints, samples, radius)
    if parts.loads and isinstance(sweep, Sweep):
        from .load_shapes import without_loads  # Most stills have none.

        vectors = without_loads(vectors, sweep, samples, radius)
    if parts.axes:
        builder.draw_axes(vectors, sweep.mechanism.joints)
    if parts.moments or parts.traces:
        builder.draw_moments(vectors, arrows=parts.moments, traces=parts.traces)
    if parts.forces:
        builder.draw_forces(vectors)
    if parts.labels:
        builder.draw_labels(vectors)
    if parts.elements and sweep.elements:
        builder.draw_elements(sweep, samples)
    if parts.loads and isinstance(sweep, Sweep):
        builder.draw_loads(sweep, samples)
        builder.draw_drives(sweep, samples, [name for name in sweep.drives if name not in swings])
        builder.draw_gravity(sweep, points)
    on_ground = bodies.on_ground()
    bearings = tuple(name for name in joints if name in on_ground) or joints
    made = builder.scenery()
    return replace(made, notes=bodies.notes, bearings=bearings, spread=bodies.spread())


class _Builder:
    """Draws what belongs to joints, and collects the legend and what the camera has to see.

    Args:
        drawing: what it draws on.
        radius: of the scene [m].
        points: `(n, 3)` between which the mechanism moves [m].
        loops: names of the joints that close loops.
    """

    def __init__(
        self, drawing: Drawing, radius: float, points: Array, loops: frozenset[str]
    ) -> None:
        self.drawing = drawing
        self._radius = radius
        self._loops = loops
        self._seen = [points]
        self._legend: list[Meaning] = []
        self._scales: list[Scale] = []
        self._arrow_surface = forms.arrow(forms.ARROW_RADIUS)
        self._thin_surface = forms.arrow(forms.ARROW_RADIUS / 2.0)

    def scenery(self) -> Scenery:
        """Return what has been drawn."""
        points = forms.extremes(np.concatenate(self._seen))
        return Scenery(self.drawing, tuple(self._legend), tuple(self._scales), points)

    def draw_axes(self, vectors: list[Vectors], joints: Mapping[str, Joint]) -> None:
        """Draw the axes of joints, a ball for a joint without one; mark those of loops.

        That of a slide goes from one end of its stroke to the other, and stays with the parent.
        """
        half, thin = _HALF_AXIS * self._radius, _AXIS_RADIUS * self._radius
        ball = meshcat().geometry.Sphere(_BALL_RADIUS * self._radius)
        end = mesh(forms.rod(_BALL_RADIUS * self._radius, -thin, thin))
        for item in vectors:
            path, loop = f"/axes/{node_name(item.name)}", item.name in self._loops
            color = LOOP if loop else AXIS
            if not has_axis(joints[item.name]):
                self.drawing.place(path, Pose.of(item.origin))
                self.drawing.add(f"{path}/point", ball, color)
                continue
            low, high = float(np.min(item.slide)), float(np.max(item.slide))
            strokes = high - low > _SMALLEST_SHOWN * self._radius
            low, high = (low, high) if strokes else (-half, half)
            middle = item.origin - (item.slide[:, None] * item.axis if strokes else 0.0)
            self.drawing.place(path, Pose.of(middle, forms.towards(item.axis)))
            self.drawing.add(f"{path}/line", mesh(forms.rod(thin, low, high)), color)
            for index, height in enumerate((low, high) if loop or strokes else ()):
                surface = ball if loop else end
                self.drawing.add(f"{path}/end {index}", surface, color, _shift(height))
            self._include(middle + low * item.axis, middle + high * item.axis)
        self._legend.append(Meaning(AXIS.css, "joint axis, of a slide its stroke", "axes"))
        if any(item.name in self._loops for item in vectors):
            self._legend.append(Meaning(LOOP.css, "joint that closes a loop", "axes"))

    def draw_moments(self, vectors: list[Vectors], arrows: bool, traces: bool) -> None:
        """Draw torsion and bending as arrows, whole moments with their traces, and their scale."""
        found = self._scale_of("moment", "N·m", vectors)
        if found is None:
            return
        scale, least = 1.0 / found.per_metre, NOTHING * found.per_metre * self._radius
        shown = [item for item in vectors if item.greatest_moment > least]
        drawn = self._draw_parts(shown, scale, {"torsion": TORSION, "bending": BENDING}, arrows)
        turning = [item for item in shown if traces and item.turns]
        traced = [item.name for item in turning if self._draw_trace(item, scale)]
        if traced:
            text = "moment 𝔐 and its trace in the shaft"
            self._legend.append(Meaning(TOTAL.css, text, "moment"))
        if drawn or traced:
            self._scales.append(found)

    def draw_forces(self, vectors: list[Vectors]) -> None:
        """Draw forces as arrows along and across the axes of joints, and their scale."""
        found = self._scale_of("force", "N", vectors)
        if found is not None:
            colors = {"force": FORCE, "axial": AXIAL, "shear": SHEAR}
            self._draw_parts(vectors, 1.0 / found.per_metre, colors)
            self._scales.append(found)

    def _scale_of(self, kind: str, unit: str, vectors: list[Vectors]) -> Scale | None:
        """Return how long arrows of forces or moments are; None where these are rounding."""
        force = max((item.greatest_force for item in vectors), default=0.0)
        moment = max((item.greatest_moment for item in vectors), default=0.0)
        greatest = force if kind == "force" else moment
        if not greatest > NOTHING * together(force, moment, self._radius)[unit]:
            return None
        longest = legible(getattr(item, kind) for item in vectors)
        cut = longest if longest < greatest else None
        return Scale(kind, unit, longest / (forms.ARROW * self._radius), cut)

    def draw_labels(self, vectors: list[Vectors]) -> None:
        """Write the names of joints."""
        for item in vectors:
            loop = item.name in self._loops
            path, color = f"/labels/{node_name(item.name)}", LOOP if loop else _LABEL
            self.drawing.label(path, item.name, color, Pose.of(item.anchor))

    def draw_elements(self, sweep: Sweep | Still, samples: Array) -> None:
        """Draw the force elements at some samples."""
        from .element_shapes import draw_elements  # Most scenes have none.

        drawn = draw_elements(self.drawing, sweep, samples, self._radius)
        self._legend += [Meaning(color, text, "elements") for color, text in drawn.legend]
        self._include(drawn.points)

    def draw_loads(self, sweep: Sweep, samples: Array) -> None:
        """Draw loads: arrows for forces, arcs for moments, each as great as the greatest of all."""
        from .load_shapes import draw_loads  # Most stills have none.

        drawn = draw_loads(self.drawing, sweep, samples, self._radius, LOAD)
        if len(drawn):
            self._legend.append(Meaning(LOAD.css, "load", "loads"))
            self._include(drawn)

    def draw_drives(self, sweep: Sweep, samples: Array, drives: Sequence[str]) -> None:
        """Draw in which sense drives grow."""
        from .load_shapes import draw_drives

        drawn = draw_drives(self.drawing, sweep, samples, drives, self._radius, DRIVE)
        if len(drawn):
            self._legend.append(Meaning(DRIVE.css, "drive: sense in which it grows", "drive"))
            self._include(drawn)

    def draw_gravity(self, sweep: Sweep, points: Array) -> None:
        """Draw gravity, if it is the same at all samples."""
        from .load_shapes import draw_gravity

        if sweep.gravity.ndim == 1 and np.any(sweep.gravity):
            drawn = draw_gravity(self.drawing, sweep.gravity, points, self._radius, GRAVITY)
            self._legend.append(Meaning(GRAVITY.css, "gravity", "loads"))
            self._include(drawn)

    def _draw_parts(
        self, vectors: list[Vectors], scale: float, colors: Mapping[str, Color], arrows: bool = True
    ) -> set[str]:
        """Draw parts of wrenches as arrows, and what they mean; return which there are."""
        drawn = {
            kind
            for item in vectors
            for kind in (colors if arrows else ())
            if kind in item.parts
            and self._draw_arrow(
                f"/{kind}/{node_name(item.name)}",
                item.anchor if kind in PARTS["moment"] else item.origin,
                scale * item.parts[kind],
                colors[kind],
            )
        }
        self._legend += [
            Meaning(colors[kind].css, MEANINGS[kind], kind) for kind in colors if kind in drawn
        ]
        return drawn

    def _draw_arrow(
        self, path: str, tail: Array, vectors: Array, color: Color, thin: bool = False
    ) -> bool:
        """Draw vectors `(N, 3)` [m] as an arrow; return whether any is long enough to be seen."""
        direction, length = forms.filled(vectors, _DIRECTION_KNOWN * self._radius)
        length = np.minimum(length, forms.ARROW * self._radius)
        if np.max(length) < _SMALLEST_SHOWN * self._radius:
            return False
        length = np.maximum(length, forms.LEAST_SCALE * self._radius)
        self.drawing.place(path, Pose.of(tail, forms.towards(direction), length))
        self.drawing.add(path, mesh(self._thin_surface if thin else self._arrow_surface), color)
        self._include(tail + direction * length[:, None])
        return True

    def _draw_trace(self, item: Vectors, scale: float) -> bool:
        """Draw the moment and the trace of its tip in the joint; return whether it leaves one.

        A moment that stays along the axis leaves none: the arrow of its torsion says all of it.
        """
        if (
            scale * np.max(np.linalg.norm(item.parts["bending"], axis=1))
            < _SMALLEST_SHOWN * self._radius
        ):
            return False
        curve = scale * item.moment
        size = np.linalg.norm(curve, axis=1, keepdims=True)
        curve = curve * np.minimum(1.0, forms.ARROW * self._radius / np.maximum(size, NOTHING))
        stride = max(1, len(curve) // _TRACE_POINTS)
        points = np.concatenate([curve[::stride], curve[-1:]])
        wire = forms.path(points, _AXIS_RADIUS * self._radius)
        moment = np.einsum("nij,nj->ni", item.rotation, curve)
        name = node_name(item.name)
        self._draw_arrow(f"/moment/{name}", item.anchor, moment, TOTAL, thin=True)
        extent = np.max(np.ptp(points, axis=0))
        if not len(wire[0]) or extent < _SMALLEST_SHOWN * self._radius:
            return False
        path = f"/traces/{name}"
        self.drawing.place(path, Pose.of(item.anchor, forms.quaternions(item.rotation)))
        self.drawing.add(path, mesh(wire), TOTAL)
        return True

    def _include(self, *points: Array) -> None:
        """Make sure that the camera sees points `(3,)` or `(n, 3)` [m]."""
        self._seen += [np.atleast_2d(item) for item in points]


def has_axis(joint: Joint) -> bool:
    """Return whether a joint has one axis that its child keeps."""
    return joint.type not in (*WITHOUT_AXIS, "universal")


def _shift(height: float) -> Array:
    """Return the placement `(4, 4)` at a height along z [m]."""
    placement = np.eye(4)
    placement[2, 3] = height
    return placement
