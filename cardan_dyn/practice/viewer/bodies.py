"""Bodies of the viewer: where they are over the shown samples, and how their links are drawn."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...core.results.sweep import Sweep
from ...kit.arrays import Array
from ...kit.errors import ModelError
from . import shapes as forms
from .commands import STEADY, Color, Drawing, Pose, node_name
from .default_shapes import (
    Attachment,
    Body,
    Pieces,
    Travel,
    attachments_of,
    bearing,
    cross,
    downwards,
    is_cross,
    rod_radius,
    sleeve_on,
    travel_of,
)
from .still import Still
from .vectors import beside
from .visuals import few_enough, shapes_of

GROUND = Color.of("#6f7780")
"""Colour of what stands still, where nothing states another."""
PALETTE = tuple(
    Color.of(css) for css in ("#0072b2", "#a08400", "#a8417e", "#008f68", "#6d62c9", "#b84600")
)
"""Colours of bodies of which nothing states one, in turn. Neighbours in the list differ for all
eyes, and each stands out from a light and from a dark background (WCAG 2.2: at least 3 to 1)."""


class Bodies:
    """The bodies of a sweep's mechanism over the samples that are shown.

    Args:
        sweep: over one dimension.
        samples: `(n,)` indices of the samples that are shown.
        visuals: whether the shapes of the links are drawn; rods between the joints otherwise.

    Attributes:
        loops: names of the joints that close loops.
        shapes: the visuals of the links whose motion is known.
        notes: what is drawn otherwise than the description says, and why.
    """

    def __init__(self, sweep: Sweep | Still, samples: Array, visuals: bool) -> None:
        mechanism = sweep.mechanism
        self._mechanism, self._samples = mechanism, samples
        self.loops = frozenset(loop.joint for loop in mechanism.loops)
        # Rotations and positions [m] of joints and bodies, as far as the sweep knows them.
        self._frames: dict[str, tuple[Array, Array]] = {}
        for name in mechanism.joints:
            with suppress(ModelError):
                self._frames[name] = sweep.rotation(name)[samples], sweep.origin(name)[samples]
        self._placements = {
            mechanism.joints[name].id: frame
            for name, frame in self._frames.items()
            if name not in self.loops
        }
        self._placements[0] = np.eye(3)[None], np.zeros((1, 3))
        self._standing = {body for body in self._placements if self._stands(body)}
        self._link_of_body: dict[int, str] = {}
        for name, (body, _) in mechanism.links.items():
            self._link_of_body.setdefault(body, name)
        # Those with a mass first, among which massless ones would break the turn of colours.
        ordered = sorted(
            self._link_of_body, key=lambda body: (body > 0 and self._centre(body) is None, body)
        )
        self._order = {body: index for index, body in enumerate(ordered)}
        self._attachments = attachments_of(mechanism)
        shapes, self.notes = shapes_of(mechanism) if visuals else ([], ())
        self.shapes = [shape for shape in shapes if shape.body in self._placements]

    def points(self) -> Array:
        """Return the points `(n, 3)` between which the mechanism moves [m]; none if unknown."""
        stated = self._stated_points
        if not len(stated):
            return stated
        corners = [
            self._swept(item.body, forms.corners(np.concatenate([v for v, _ in surfaces])))
            for item in self._defaults
            if item.pose is None and (surfaces := (*item.parts.link, *item.parts.pins))
        ]
        return np.concatenate([stated, *corners])

    def normal(self) -> int | None:
        """Return across which axis, 0 to 2, joints lie in a plane; None where they do not."""
        origins = [origin for _, origin in self._frames.values()] or [np.zeros((1, 3))]
        extents = np.ptp(np.concatenate(origins), axis=0)
        least, between, most = np.sort(extents)
        flat = least < 0.2 * between and between > STEADY * most
        return int(np.argmin(extents)) if flat else None

    @cached_property
    def _stated_points(self) -> Array:
        """Points `(n, 3)` of joints and visuals [m]."""
        centres = (
            self._swept(body, centre[None])
            for body in self._attachments
            if body and body not in self._drawn and body in self._placements
            if (centre := self._centre(body)) is not None
        )
        return np.concatenate(
            [
                np.zeros((0, 3)),
                *(origin for _, origin in self._frames.values()),
                *centres,
                *(self._swept(shape.body, shape.corners()) for shape in self.shapes),
            ]
        )

    @cached_property
    def _defaults(self) -> list[_Default]:
        """What stands for the links without visuals, and for universal joints."""
        found: list[_Default] = []
        for body, items in self._attachments.items():
            if (
                body in self._drawn
                or body not in self._link_of_body
                or body not in self._placements
            ):
                continue
            if body in self._standing:
                found += self._bearings(body, items)
            elif body not in self._sleeves:
                parts = Body(items, self._centre(body), self._crosses, self._travel, self._rod)
                found.append(_Default(self._path(body), body, parts.parts()))
        made_up = {item.body for item in found} - {0, *self._sleeves}
        return [*found, *self._made_up_crosses(made_up)]

    @cached_property
    def _drawn(self) -> set[int]:
        """Bodies that have visuals; a floor alone holds no bearings."""
        return {shape.body for shape in self.shapes if shape.kind != "plane"}

    @cached_property
    def _rod(self) -> float:
        """Radius of rods [m]."""
        extent = float(np.linalg.norm(np.ptp(self._stated_points, axis=0)))
        return rod_radius(
            self._attachments.values(), extent / 2.0 or self._mechanism.characteristic_length
        )

    @cached_property
    def _crosses(self) -> frozenset[int]:
        """Bodies that are crosses of universal joints."""
        return frozenset(
            body
            for body, items in self._attachments.items()
            if body and is_cross(items, self._centre(body), self._rod)
        )

    @cached_property
    def _sleeves(self) -> dict[int, Attachment]:
        """Bodies that are sleeves about shafts, and in which joint these turn."""
        return {
            body: item
            for body, items in self._attachments.items()
            if body not in self._drawn and body in self._placements and self._centre(body) is None
            if (item := sleeve_on(items, self._rod)) is not None
        }

    @cached_property
    def _travel(self) -> dict[str, Travel]:
        """Where each slide goes over the shown samples."""
        found = {}
        for body, items in self._attachments.items():
            for item in items:
                if item.kind == "slide" and not item.is_child:
                    others, span = self._attachments[item.other], self._span(item, body)
                    free = not (body in self._standing or item.other in self._standing)
                    way = travel_of(item, items, others, span, self._rod)
                    found[item.joint] = way._replace(is_free=free)
        return found

    def _path(self, body: int, *more: str) -> str:
        names = (self._link_of_body[body], *more)
        return f"/mechanism/{' '.join(map(node_name, names))}"

    def _made_up_crosses(self, made_up: set[int]) -> Iterator[_Default]:
        """Yield the crosses of universal joints that have no link for them.

        Args:
            made_up: bodies that have default shapes, of which a joint has at least one.
        """
        for body, items in self._attachments.items():
            for item in items:
                known = body in self._placements and item.other in self._placements
                if (
                    item.kind == "cross"
                    and item.is_child
                    and known
                    and {body, item.other} & made_up
                ):
                    turn, place = self._placements[body]
                    own = np.broadcast_to(turn @ item.axis, (len(self._samples), 3))
                    other = self._other_end(item)
                    across = np.broadcast_to(
                        self._placements[item.other][0] @ other.axis, own.shape
                    )
                    axes = np.stack([across, own, np.cross(across, own)], axis=2)
                    pose = Pose(place + turn @ item.point, forms.quaternions(axes))
                    parts = cross([*np.eye(3)[:2]], np.zeros(3), self._rod)
                    yield _Default(self._path(body, item.joint), body, parts, pose)

    def _other_end(self, item: Attachment) -> Attachment:
        """Return a joint as the body on its other side has it."""
        return next(end for end in self._attachments[item.other] if end.joint == item.joint)

    def _bearings(self, body: int, items: list[Attachment]) -> Iterator[_Default]:
        """Yield the bearings of what moves on a body that stands still.

        Of sleeves in which shafts turn, they are housings.
        """
        turn = self._placements[body][0][0].T
        down = turn @ downwards(self._attachments.get(0, ()))
        for item in items:
            shaft, along, travel = self._sleeves.get(item.other), 0.0, Travel()
            if body in self._sleeves:
                continue
            if shaft is not None:
                way = turn @ self._placements[item.other][0][0] @ shaft.axis
                item = item._replace(kind="turn", axis=way)
            elif item.other in self._standing or item.other not in self._placements:
                continue
            else:
                way = turn @ self._placements[item.other][0][0] @ self._leaving(item)
                travel = self._travel.get(item.joint, travel)
                along = beside(self._mechanism, self._mechanism.joints[item.joint], np.inf)
            parts = bearing(item, down, way, along, self._crosses, travel, self._rod)
            yield _Default(f"/bearings/{node_name(item.joint)}", body, parts)

    def _centre(self, body: int) -> Array | None:
        """Return the centre of a body's mass `(3,)` in it [m]; None where it has none."""
        inertia = self._mechanism.model.inertias[body]
        return inertia.lever if inertia.mass > 0.0 else None

    def _leaving(self, item: Attachment) -> Array:
        """Return where the body on the other side of a joint leaves it `(3,)`, in that body."""
        start = self._other_end(item).point
        others = self._attachments[item.other]
        points = [other.point for other in others if other.joint != item.joint]
        centre = self._centre(item.other)
        points += [] if centre is None else [centre]
        arm = np.mean([point - start for point in points], axis=0) if points else np.zeros(3)
        length = float(np.linalg.norm(arm))
        return np.asarray(arm / length) if length else np.zeros(3)

    def _span(self, item: Attachment, body: int) -> tuple[float, float]:
        """Return the least and the greatest coordinate of a slide over the shown samples [m]."""
        if item.joint not in self._frames or body not in self._placements:
            return 0.0, 0.0
        (_, origin), (rotation, position) = self._frames[item.joint], self._placements[body]
        start, axis = position + rotation @ item.point, rotation @ item.axis
        way = np.sum((origin - start) * axis, axis=1)
        return float(np.min(way)), float(np.max(way))

    def on_ground(self) -> frozenset[str]:
        """Return the joints that carry what moves on what stands still over the shown samples."""
        return frozenset(
            item.joint
            for body, items in self._attachments.items()
            for item in items
            if body in self._standing and item.other not in self._standing
        )

    def _stands(self, body: int) -> bool:
        """Return whether a body does not move; of one sample alone, whether it is the ground."""
        rotation, position = self._placements[body]
        turns = np.max(np.ptp(rotation, axis=0)) > STEADY
        shifts = np.max(np.ptp(position, axis=0)) > STEADY * self._mechanism.characteristic_length
        return body == 0 or (len(self._samples) > 1 and not (turns or shifts))

    def draw(self, drawing: Drawing) -> None:
        """Draw the shapes of the links, default ones for those that have none."""
        shapes, note = few_enough(self.shapes, drawing.size)
        self.notes += (note,) if note else ()
        for body in sorted({shape.body for shape in shapes}):
            node = self._path(body)
            drawing.nodes[node] = self._pose(body)
            for count, shape in enumerate(item for item in shapes if item.body == body):
                color = self._color(body)
                if shape.color is not None:
                    # The viewer's lights together are brighter than one: white keeps its shades.
                    color = _shaded(Color(*shape.color), 0.85)
                elif shape.kind == "plane":
                    color = color._replace(opacity=0.35)  # What is below is seen as well.
                path = f"{node}/{node_name(shape.link)} {count}"
                drawing.add(path, shape.drawn(drawing.size), color, shape.placement)
        stand_in = [self._link_of_body[item.body] for item in self._defaults if item.body]
        if self.notes and stand_in:
            self.notes += (f"made up from joints: {', '.join(dict.fromkeys(stand_in))}",)
        for item in self._defaults:
            drawing.nodes[item.path] = item.pose or self._pose(item.body)
            color = self._color(item.body)
            darker = _shaded(color, 0.6)
            link = color if item.pose is None else darker
            for name, surfaces, shade in (
                ("shape", item.parts.link, link),
                ("pins", item.parts.pins, darker),
            ):
                if surfaces:
                    drawing.add(f"{item.path}/{name}", forms.joined(*surfaces), shade)

    def _pose(self, body: int) -> Pose:
        rotation, position = self._placements[body]
        if body in self._standing:
            rotation, position = rotation[:1], position[:1]
        return Pose(position, forms.quaternions(rotation))

    def _swept(self, body: int, points: Array) -> Array:
        """Return the points `(n, 3)` through which points `(k, 3)` of a body move [m]."""
        # They only decide how much the camera has to see: every eighth sample is enough.
        rotation, position = (array[::8] for array in self._placements[body])
        turned = np.einsum("nij,kj->nki", rotation, points)
        return np.asarray((turned + position[:, None]).reshape(-1, 3))

    def _color(self, body: int) -> Color:
        """Return the colour of a body of which nothing states one."""
        return GROUND if body in self._standing else PALETTE[self._order[body] % len(PALETTE)]


class _Default(NamedTuple):
    """What is drawn of a body without visuals, of a bearing on it, or of a cross that it holds.

    Attributes:
        path: of the node.
        body: index of the body.
        parts: in the frame of the node.
        pose: of the node; that of the body if None.
    """

    path: str
    body: int
    parts: Pieces
    pose: Pose | None = None


def _shaded(color: Color, share: float) -> Color:
    """Return a share of a colour."""
    red, green, blue = (share * value for value in (color.red, color.green, color.blue))
    return Color(red, green, blue, color.opacity)
