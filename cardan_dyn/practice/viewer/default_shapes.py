"""Default shapes of the viewer: bodies without visuals, made up from their joints.

Rods with eyes and forks, plates, crosses, shafts, sliders and balls; on what stands still, bearings
with a hatched foot. All sizes are multiples of the radius of a rod, so that mechanisms of a
millimetre and of ten metres look alike.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio

from ...core.mechanism.mechanism import Mechanism
from ...kit.arrays import Array
from . import shapes as forms
from .shapes import Surface

_ROD, _LEAST_ROD, _OF_SHORTEST = 0.02, 0.008, 0.2
"""Radius of a rod as a fraction of the radius of the scene, its least one, and the fraction of the
shortest distance between two joints of a body that it does not exceed."""
_PARALLEL = 0.95
"""Cosine of an angle up to which directions count as parallel."""
_ON_LINE = 0.1
"""Sine of the angle, and share of the distance, up to which points count as on a line or plane."""
_FOOT_AT = 5.0
"""Distance of the foot of a bearing from its axis, in radii of a rod."""
_ARM = 2.0
"""Least distance of the centre of a mass from a joint for it to count, in radii of a rod."""
_X, _, _Z = np.eye(3)


class Attachment(NamedTuple):
    """A joint as one of its two bodies has it.

    Attributes:
        joint: its name.
        kind: `turn`, `slide`, `ball`, `cross` (of a universal joint) or `other`.
        point: `(3,)` origin of the joint's frame in the body [m].
        axis: `(3,)` unit axis in the body; of a `cross` that of the body's own pins.
        is_child: whether the body is the joint's child.
        other: index of the body on the other side.
    """

    joint: str
    kind: str
    point: Array
    axis: Array
    is_child: bool
    other: int


class Travel(NamedTuple):
    """Where a slide goes, along its axis from the parent's side of it [m].

    Attributes:
        low: least coordinate.
        high: greatest coordinate.
        behind: of the parent's farthest joint on the axis, against it; 0 without one.
        ahead: likewise of the child's, from the child's side; 0 without one.
        is_free: whether both sides move, so that a tube may lead there.
    """

    low: float = 0.0
    high: float = 0.0
    behind: float = 0.0
    ahead: float = 0.0
    is_free: bool = True


_KINDS = {
    "revolute": "turn",
    "continuous": "turn",
    "prismatic": "slide",
    "cylindrical": "slide",
    "spherical": "ball",
    "universal": "cross",
}


def downwards(attachments: Iterable[Attachment]) -> Array:
    """Return where feet are `(3,)` in the world, of a mechanism in a horizontal plane within it."""
    turning = [item.axis for item in attachments if item.kind == "turn"]
    flat = bool(turning) and all(abs(axis[2]) > _PARALLEL for axis in turning)
    return np.array([0.0, -1.0, 0.0] if flat else [0.0, 0.0, -1.0])


def attachments_of(mechanism: Mechanism) -> dict[int, list[Attachment]]:
    """Return the joints of each body of a mechanism that is a link or more of them."""
    loops = {loop.joint: loop for loop in mechanism.loops}
    found: dict[int, list[Attachment]] = {0: []}
    for name, joint in mechanism.joints.items():
        kind, axes = _KINDS.get(joint.type, "other"), (joint.axis, joint.axis)
        if joint.type == "universal":
            axes = joint.parts[0].axis, joint.parts[-1].axis
        if joint.parts:
            parent = int(mechanism.model.parents[joint.parts[0].id])
            frame = mechanism.model.jointPlacements[joint.parts[0].id]
        else:
            parent, frame = loops[name].predecessor, loops[name].predecessor_placement
        child, end = joint.id, pinocchio.SE3.Identity()
        if name in loops:
            child, end = loops[name].successor, loops[name].successor_placement
        ends = ((parent, child, frame, False), (child, parent, end, True))
        for (body, other, placement, is_child), axis in zip(ends, axes, strict=True):
            point, turned = placement.translation, placement.rotation @ axis
            item = Attachment(name, kind, point, turned, is_child, other)
            found.setdefault(body, []).append(item)
    return found


def rod_radius(attachments: Iterable[Sequence[Attachment]], radius: float) -> float:
    """Return the radius of all rods [m].

    Args:
        attachments: of each body.
        radius: of the scene [m].
    """
    distances = [
        float(np.linalg.norm(one.point - other.point))
        for items in attachments
        for one, other in itertools.combinations(items, 2)
    ]
    shortest = min((item for item in distances if item > 1e-3 * radius), default=radius)
    return max(min(_ROD * radius, _OF_SHORTEST * shortest), _LEAST_ROD * radius)


@dataclass(frozen=True, eq=False)
class Pieces:
    """What is drawn of a body: in its frame, or about z in radii of a rod.

    Attributes:
        link: surfaces in the colour of the link.
        pins: surfaces of pins and balls, which are darker.
    """

    link: tuple[Surface, ...] = ()
    pins: tuple[Surface, ...] = ()

    def __add__(self, other: Pieces) -> Pieces:
        return Pieces((*self.link, *other.link), (*self.pins, *other.pins))

    def at(self, point: Array, axis: Array, x: Array | None = None, rod: float = 1.0) -> Pieces:
        """Return them at a point with z along an axis, see `shapes.upright`, in other units."""
        turn = forms.upright(axis, x)
        return Pieces(
            *(
                tuple(forms.moved(surface, turn, point, rod) for surface in surfaces)
                for surfaces in (self.link, self.pins)
            )
        )


def _cheek(top: float, reach: float, foot: float) -> Array:
    """Return the outline of a plate from around an axis to a foot along x, half as wide as told."""
    angles = np.linspace(0.5 * np.pi, 1.5 * np.pi, 11)
    around = top * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return np.concatenate([around, [[reach, -foot], [reach, foot]]])


def _cheeks(outline: Array, low: float, high: float) -> tuple[Surface, Surface]:
    """Return a plate on both sides between two distances."""
    return forms.prism(outline, low, high), forms.prism(outline, -high, -low)


def _fork(low: float, high: float, reach: float) -> Pieces:
    """Return two cheeks about z and the bridge between them at their ends along x."""
    bridge = forms.prism(forms.rectangle(reach - 0.6, reach, 1.6), -low, low)
    return Pieces((*_cheeks(_cheek(1.6, reach, 1.6), low, high), bridge))


def _along_x(radius: float, low: float, high: float) -> Pieces:
    return Pieces((forms.rod(radius, low, high),)).at(np.zeros(3), _X)


# Fittings about the axis of a joint, in radii of a rod, which leads along x.
_EYE = Pieces((forms.rod(1.9, -1.15, 1.15),))
_SLEEVE = Pieces((forms.ring(1.05, 1.9, -1.15, 1.15),))
_PIN = Pieces((), (forms.rod(0.75, -2.2, 2.2),))
_FORK_REACH, _YOKE_REACH, _SOCKET_REACH = 3.4, 4.6, 2.4
"""Where rods begin at them."""
_FORK = _fork(1.3, 1.9, _FORK_REACH)
_YOKE = _fork(2.36, 3.08, _YOKE_REACH)
_BALL = Pieces((), (forms.capsule(1.9),))
_SOCKET = Pieces((forms.cup(1.98, _SOCKET_REACH),))
_HALF_BLOCK = 2.6
_BLOCK = Pieces((forms.prism(forms.rectangle(-1.7, 1.7, 1.7), -_HALF_BLOCK, _HALF_BLOCK),))
# What bearings stand on, along x.
_HATCH = np.array([[0.5, 0.36], [1.8, -0.94], [1.8, -1.3], [0.5, 0.0]])
_FOOT_SHAPES = (
    forms.rectangle(_FOOT_AT, _FOOT_AT + 0.5, 3.6),
    *(_HATCH + np.array([_FOOT_AT, 1.2 * index - 2.46]) for index in range(6)),
)
_FOOT = Pieces(tuple(forms.prism(outline, -2.7, 2.7) for outline in _FOOT_SHAPES))
"""A slab at some distance, hatched behind it."""
_POST_SHAPE = np.array([[0.7, -1.2], [_FOOT_AT, -2.4], [_FOOT_AT, 2.4], [0.7, 1.2]])
_POST = Pieces((forms.prism(_POST_SHAPE, -0.8, 0.8), *_FOOT.link))


class Body:
    """A body that moves, without visuals.

    Args:
        attachments: its joints.
        centre: `(3,)` of its mass; None where it has none.
        crosses: indices of the bodies that are crosses.
        travel: where each joint that slides goes.
        rod: radius of its rods [m].
    """

    def __init__(
        self,
        attachments: Sequence[Attachment],
        centre: Array | None,
        crosses: frozenset[int],
        travel: dict[str, Travel],
        rod: float,
    ) -> None:
        self._all, self._crosses = attachments, crosses
        self._travel, self._rod = travel, rod
        self._points = nodes_of(attachments, rod)
        self._centre = centre

    def parts(self) -> Pieces:
        """Return what is drawn of it."""
        if is_cross(self._all, self._centre, self._rod):
            axes = _distinct([item.axis for item in self._all])
            return cross(axes, self._all[0].point, self._rod)
        points, rod = self._points, self._rod
        tubes = [telescope(item, self._travel, rod) for item in self._all]
        if len(points) < 3 and any(tubes):
            start, end, _ = next(tube for tube in tubes if tube is not None)
            return self._fittings((start + end) / 2.0)
        if len(points) == 1:
            return self._alone()
        middle, normal = _plane(points)
        if normal is None:
            order = np.argsort((points - middle) @ (points[-1] - points[0]))
            return self._bar(*points[order[[0, -1]]]) + self._fittings()
        extent = np.linalg.norm(np.ptp(points, axis=0))
        if np.max(np.abs((points - middle) @ normal)) < _ON_LINE * extent:
            plate = _plate(points, middle, normal, 1.5 * rod, 0.6 * rod)
            return Pieces((plate,)) + self._fittings(middle, plate=True)
        star = [rod_between(middle, point, rod) for point in points]
        hub = Pieces((forms.capsule(1.5),)).at(middle, _Z, rod=rod)
        return Pieces(tuple(star)) + hub + self._fittings(middle, plate=True)

    def _alone(self) -> Pieces:
        """Return what is drawn of a body all of whose joints share one point."""
        point, rod = self._points[0], self._rod
        arm = np.zeros(3) if self._centre is None else self._centre - point
        length = float(np.linalg.norm(arm))
        turning = [item for item in self._all if item.kind == "turn"]
        along = [abs(arm @ item.axis) > _PARALLEL * length for item in turning]
        if length > _ARM * rod and any(along):
            # A shaft that turns about an axis through its mass goes on to its bearing behind it.
            end = point + arm + 5.0 * rod * arm / length
            flange = Pieces((forms.rod(3.4, -0.5, 0.5),)).at(end, arm, rod=rod)
            # Where nothing holds it in the joint's point, another shaft may be there.
            bar = self._bar(point + 0.5 * arm if all(along) else point, end)
            return flange + bar + self._fittings(end)
        if len(self._all) > 1 or length < _ARM * rod:
            parts = self._fittings(point + forms.upright(self._all[0].axis)[:, 0], plate=True)
            if turning and len(self._all) == 1:
                # A short hub, for a body that has nothing else.
                parts += Pieces((forms.rod(1.4, -2.0, 2.0),)).at(point, turning[0].axis, rod=rod)
            return parts
        tip = point + arm
        weight = Pieces((forms.capsule(1.8),)).at(tip, _Z, rod=rod)
        return weight + self._bar(point, tip) + self._fittings(tip)

    def _bar(self, start: Array, end: Array) -> Pieces:
        """Return a rod between two nodes, which leaves room for the fittings at both."""
        way = _direction(end - start)
        length = float(np.linalg.norm(end - start))
        low, high = self._room(start, way), self._room(end, -way)
        shorter = min(1.0, 0.9 * length / (low + high or length))
        ends = start + shorter * low * way, end - shorter * high * way
        return Pieces((rod_between(*ends, self._rod),))

    def _room(self, point: Array, way: Array) -> float:
        """Return how far from a node its rod starts [m]."""
        rooms = [0.0]
        for item in self._all:
            if np.linalg.norm(item.point - point) > self._rod:
                continue
            across = float(abs(item.axis @ way) < _PARALLEL)
            if self._holds_cross(item):
                rooms.append(across * (_YOKE_REACH - 0.3))
            elif item.kind == "turn" and not item.is_child:
                rooms.append(across * (_FORK_REACH - 0.3))
            elif item.kind == "ball" and not item.is_child:
                rooms.append(_SOCKET_REACH - 0.2)
        return max(rooms) * self._rod

    def _holds_cross(self, item: Attachment) -> bool:
        return item.kind == "cross" or (item.kind == "turn" and item.other in self._crosses)

    def _fittings(self, middle: Array | None = None, *, plate: bool = False) -> Pieces:
        """Return what the body has at its joints.

        Args:
            middle: `(3,)` to which its rods lead from each joint; None for the farthest joint.
            plate: whether a plate or several rods lead there, where a fork has no room.
        """
        result = Pieces()
        for item in self._all:
            inner = middle
            if inner is None:
                away = np.linalg.norm(self._points - item.point, axis=1)
                inner = self._points[np.argmax(away)]
            way = _direction(inner - item.point)
            if item.kind == "slide":
                result += self._guide(item)
            elif item.kind == "ball":
                result += (_BALL if item.is_child else _SOCKET).at(item.point, way, rod=self._rod)
            else:
                result += self._fitting(item, way, plate).at(item.point, item.axis, way, self._rod)
        return result

    def _guide(self, item: Attachment) -> Pieces:
        """Return what the body has at a slide: a tube or its rod, or else a block or its rail."""
        tube = telescope(item, self._travel, self._rod)
        if tube is not None:
            return Pieces((rod_between(*tube),))
        if item.is_child:
            return _BLOCK.at(item.point, item.axis, rod=self._rod)
        # It begins where the body's rods end.
        ends = self._travel[item.joint]
        ends = ends._replace(low=min(ends.low, 0.0), high=max(ends.high, 0.0))
        return rail(item.point, item.axis, ends, self._rod)

    def _fitting(self, item: Attachment, way: Array, plate: bool) -> Pieces:
        """Return what the body has at a joint that turns, with its rod in a direction."""
        along = abs(item.axis @ way) > _PARALLEL
        if self._holds_cross(item):
            return Pieces() if along or plate else _YOKE
        if item.kind != "turn" or (along and item.is_child):
            return Pieces()
        if along or item.is_child:
            return _SLEEVE if along else _EYE
        return _PIN if plate else _FORK + _PIN


def travel_of(
    item: Attachment,
    own: Iterable[Attachment],
    others: Iterable[Attachment],
    span: tuple[float, float],
    rod: float,
) -> Travel:
    """Return where a slide goes.

    Args:
        item: the slide as its parent has it.
        own: joints of the parent.
        others: joints of the child.
        span: least and greatest coordinate [m].
        rod: radius of rods [m].
    """
    end = next(other for other in others if other.joint == item.joint)
    own_places, other_places = [0.0, *_on_axis(item, own, rod)], [0.0, *_on_axis(end, others, rod)]
    onwards = sum(span) / 2.0 + max(other_places) - min(own_places)
    back = sum(span) / 2.0 + min(other_places) - max(own_places)
    if -back > onwards:
        return Travel(*span, max(own_places), min(other_places))
    return Travel(*span, min(own_places), max(other_places))


def _on_axis(item: Attachment, others: Iterable[Attachment], rod: float) -> list[float]:
    """Return where other joints of a body are on the axis of one, from its point [m]."""
    found = []
    for other in others:
        arm = other.point - item.point
        along = float(arm @ item.axis)
        if np.linalg.norm(arm - along * item.axis) < rod:
            found.append(along)
    return found


def telescope(
    item: Attachment, travel: dict[str, Travel], rod: float
) -> tuple[Array, Array, float] | None:
    """Return start, end and radius of the tube or the rod of a slide, in its body.

    The tube is the parent's: from its farthest joint on the axis it ends short of the least
    coordinate. The rod is the child's, and as long as the greatest one needs. None where the
    joints of both come too close to each other for a tube, or part farther than the rod reaches.
    """
    if item.kind != "slide":
        return None
    low, high, behind, ahead, is_free = travel[item.joint]
    sign = 1.0
    if low + high + ahead - behind < 0.0:
        low, high, behind, ahead, sign = -high, -low, -behind, -ahead, -1.0
    least, greatest = low + ahead - behind, high + ahead - behind
    axis, tube, longest = sign * item.axis, 0.75 * least, 0.95 * least
    if not is_free or least < 8.0 * rod or greatest - tube > longest:
        return None
    if not item.is_child:
        start = item.point + behind * axis
        return start, start + tube * axis, 1.5 * rod
    start = item.point + ahead * axis
    return start, start - min(greatest - tube + 2.0 * rod, longest) * axis, rod


def bearing(
    item: Attachment,
    down: Array,
    way: Array,
    beside: float,
    crosses: frozenset[int],
    travel: Travel,
    rod: float,
) -> Pieces:
    """Return a bearing on what stands still, with a hatched foot, in the frame of the latter.

    Args:
        item: the joint as the standing body has it.
        down: `(3,)` direction in which its foot is, as far as its axis allows.
        way: `(3,)` direction in which the moving body leaves the joint, in the standing frame.
        beside: how far along its axis from its point the bearing of a shaft is [m].
        crosses: indices of the bodies that are crosses.
        travel: where a slide goes.
        rod: radius of rods [m].
    """
    axis, point = item.axis, item.point
    lies = np.linalg.norm(down - (down @ axis) * axis) > 0.3
    if item.kind == "other":
        return Pieces()
    if item.kind == "slide":
        room = 1.7 * _HALF_BLOCK * rod
        posts = (
            _POST.at(point + end * axis, axis, down if lies else None, rod)
            for end in (travel.low - room, travel.high + room)
        )
        return sum(posts, rail(point, axis, travel, rod))
    ball, of_cross = item.kind == "ball", item.kind == "cross" or item.other in crosses
    shaft = not ball and abs(way @ axis) > _PARALLEL
    point = point + beside * axis * shaft
    if ball or not lies:
        foot = down if ball else -axis if way @ axis > 0.0 else axis
        held = (_BALL if item.is_child else _SOCKET) if ball else _SLEEVE
        parts = _FOOT + held.at(np.zeros(3), _X)
        if ball or not of_cross:
            parts += _along_x(1.0, 1.5, _FOOT_AT) if ball else _along_x(1.3, 0.0, _FOOT_AT)
        return parts.at(point, forms.upright(foot)[:, 0], foot, rod)
    if of_cross:
        stem = _along_x(1.0, _YOKE_REACH - 0.3, _YOKE_REACH + 1.6)
        parts = _YOKE + stem + _FOOT.at(_X, _Z, _X)
    elif shaft:
        parts = _SLEEVE + _POST
    elif item.is_child:
        parts = Pieces((forms.prism(_cheek(1.9, _FOOT_AT, 3.23), -0.69, 0.69),)) + _SLEEVE + _FOOT
    else:
        parts = Pieces(_cheeks(_cheek(1.6, _FOOT_AT, 2.72), 1.3, 1.9)) + _PIN + _FOOT
    return parts.at(point, axis, down, rod)


def is_cross(attachments: Sequence[Attachment], centre: Array | None, rod: float) -> bool:
    """Return whether a body is a cross: all its joints turn in one point, about several axes.

    Its mass, if it has one, is there as well: a shaft whose bearing is described in the middle of
    its universal joint is none.
    """
    if centre is not None and np.linalg.norm(centre - attachments[0].point) > _ARM * rod:
        return False
    if len(nodes_of(attachments, rod)) != 1 or any(item.kind != "turn" for item in attachments):
        return False
    return len(_distinct([item.axis for item in attachments])) > 1


def sleeve_on(attachments: Sequence[Attachment], rod: float) -> Attachment | None:
    """Return the joint in which a shaft turns in a body that is nothing but a sleeve about it.

    Its other joints are its seats, beside that joint on its axis; None for another body.
    """
    turning = [item for item in attachments if item.kind == "turn" and not item.is_child]
    others = [item for item in attachments if item.kind in ("ball", "cross")]
    if len(turning) != 1 or not others or len(attachments) != len(others) + 1:
        return None
    arms = [item.point - turning[0].point for item in others]
    on_axis = all(np.linalg.norm(np.cross(arm, turning[0].axis)) < rod for arm in arms)
    return turning[0] if on_axis else None


def nodes_of(attachments: Sequence[Attachment], rod: float) -> Array:
    """Return the points `(n, 3)` of attachments, one that several share once."""
    nodes: list[Array] = []
    for item in attachments:
        if all(np.linalg.norm(node - item.point) >= rod for node in nodes):
            nodes.append(item.point)
    return np.array(nodes)


def rod_between(start: Array, end: Array, radius: float) -> Surface:
    """Return a rod from a point to another."""
    length = float(np.linalg.norm(end - start))
    return forms.moved(forms.rod(radius, 0.0, length), forms.upright(end - start), start)


def cross(axes: Sequence[Array], point: Array, rod: float) -> Pieces:
    """Return a hub with pins along its axes."""
    pin, hub = Pieces((forms.rod(0.8, -3.2, 3.2),)), Pieces((forms.capsule(1.25),))
    pins = (pin.at(point, axis, rod=rod) for axis in axes)
    return sum(pins, hub.at(point, _Z, rod=rod))


def rail(point: Array, axis: Array, travel: Travel, rod: float) -> Pieces:
    """Return the rail along which a block slides."""
    ends = travel.low / rod - 2.0 * _HALF_BLOCK, travel.high / rod + 2.0 * _HALF_BLOCK
    bar = forms.prism(forms.rectangle(-0.8, 0.8, 0.8), *ends)
    return Pieces((bar,)).at(point, axis, rod=rod)


def _plate(points: Array, middle: Array, normal: Array, rim: float, half: float) -> Surface:
    """Return a plate around points of a plane."""
    from scipy.spatial import ConvexHull

    frame = forms.upright(normal)
    flat = (points - middle) @ frame[:, :2]
    angles = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    circle = rim * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    around = (flat[:, None] + circle).reshape(-1, 2)
    outline = around[ConvexHull(around).vertices]
    return forms.moved(forms.prism(outline, -half, half), frame, middle)


def _plane(points: Array) -> tuple[Array, Array | None]:
    """Return the middle of points and the normal of the plane through them; None on a line."""
    middle = points.mean(axis=0)
    if len(points) < 3:
        return middle, None
    _, spread, axes = np.linalg.svd(points - middle)
    return middle, None if spread[1] < _ON_LINE * spread[0] else axes[2]


def _distinct(axes: Sequence[Array]) -> list[Array]:
    """Return axes that are not parallel to one before."""
    kept: list[Array] = []
    for axis in axes:
        if all(abs(axis @ other) < _PARALLEL for other in kept):
            kept.append(axis)
    return kept


def _direction(vector: Array) -> Array:
    length = float(np.linalg.norm(vector))
    return vector / length if length else np.array([0.0, 0.0, 1.0])
