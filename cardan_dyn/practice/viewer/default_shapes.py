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

from ...core.mechanism.joints import Joint
from ...core.mechanism.mechanism import Mechanism
from ...kit.arrays import Array
from . import shapes as forms

Surface = tuple[Array, Array]
_ROD, _LEAST_ROD, _OF_SHORTEST = 0.02, 0.008, 0.2
"""Radius of a rod as a fraction of the radius of the scene, its least one, and the fraction of the
shortest distance between two joints of a body that it does not exceed."""
_PARALLEL = 0.95
"""Cosine of an angle up to which directions count as parallel."""
_ON_LINE = 0.1
"""Sine of the angle, and share of the distance, up to which points count as on a line or plane."""
# Multiples of the radius of a rod.
_EYE, _EYE_HALF = 1.9, 1.15
_CHEEK, _GAP, _CHEEK_WIDTH, _REACH = 0.6, 1.3, 1.6, 3.4
"""Thickness of a fork's cheek, half the gap between both, half their width, and their reach."""
_PIN, _PIN_HALF = 0.75, 2.2
_CROSS_HALF, _CROSS_PIN, _CROSS_HUB = 3.2, 0.8, 1.25
_YOKE_REACH = 4.6
_BALL, _SOCKET = 1.9, 2.4
_BLOCK, _BLOCK_HALF, _RAIL = 1.7, 2.6, 0.8
_TUBE, _TELESCOPE = 1.5, 8.0
"""Radius of the tube of a slide, and the least coordinate for which there is one."""
_PLATE_RIM, _PLATE_HALF = 1.5, 0.6
_FOOT_AT, _FOOT_HALF, _FOOT_HEIGHT, _HATCHES, _HATCH = 5.0, 3.6, 0.5, 6, 1.3
_FLANGE, _FLANGE_HALF = 3.4, 0.5
_ARM, _BEYOND = 2.0, 5.0
"""Least distance of the centre of a mass from a joint for it to count, and how far a shaft that
turns about an axis through it goes on behind it, where its bearing is."""
_NODES = 0.2
"""Distance of points, in radii of a rod, up to which they count as one."""


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
        kind = _KINDS.get(joint.type, "other")
        first, last = _axes(joint)
        if joint.parts:
            parent = int(mechanism.model.parents[joint.parts[0].id])
            frame = mechanism.model.jointPlacements[joint.parts[0].id]
        else:
            parent, frame = loops[name].predecessor, loops[name].predecessor_placement
        child, end = joint.id, None
        if name in loops:
            child, end = loops[name].successor, loops[name].successor_placement
        turn = np.eye(3) if end is None else end.rotation
        place = np.zeros(3) if end is None else end.translation
        found.setdefault(parent, []).append(
            Attachment(name, kind, frame.translation, frame.rotation @ first, False, child)
        )
        found.setdefault(child, []).append(Attachment(name, kind, place, turn @ last, True, parent))
    return found


def _axes(joint: Joint) -> tuple[Array, Array]:
    """Return the axis of a joint as its parent and as its child has it, each in the joint frame."""
    if joint.type == "universal":
        return joint.parts[0].axis, joint.parts[-1].axis
    return joint.axis, joint.axis


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
class Parts:
    """What is drawn of a body, in its frame.

    Attributes:
        link: surfaces in the colour of the link.
        pins: surfaces of pins and balls, which are darker.
    """

    link: tuple[Surface, ...] = ()
    pins: tuple[Surface, ...] = ()

    def __add__(self, other: Parts) -> Parts:
        return Parts((*self.link, *other.link), (*self.pins, *other.pins))


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
        self._points = np.array([node[0].point for node in nodes_of(attachments, rod)])
        self._centre = centre

    def parts(self) -> Parts:
        """Return what is drawn of it."""
        if is_cross(self._all, self._centre, self._rod):
            return self._cross()
        points, rod = self._points, self._rod
        tubes = [telescope(item, self._travel, rod) for item in self._all]
        if len(points) < 3 and any(tubes):
            start, end, _ = next(tube for tube in tubes if tube is not None)
            return self._fittings((start + end) / 2.0, False)
        if len(points) == 1:
            return self._alone()
        middle, normal = _plane(points)
        if normal is None and len(points) > 2:
            order = np.argsort((points - middle) @ _direction(points[-1] - points[0]))
            points = points[order[[0, -1]]]
            return self._bar(points[0], points[1]) + self._fittings(None, False)
        if len(points) == 2:
            return self._bar(*points) + self._fittings(None, False)
        assert normal is not None
        flat = np.max(np.abs((points - middle) @ normal)) < _ON_LINE * _span(points)
        if flat:
            plate = _plate(points, middle, normal, _PLATE_RIM * rod, _PLATE_HALF * rod)
            return Parts((plate,)) + self._fittings(middle, True)
        star = [self._rod_between(middle, point) for point in points]
        hub = forms.moved(forms.capsule(1.5 * rod, 0.0), np.eye(3), middle)
        return Parts((*star, hub)) + self._fittings(middle, True)

    def _alone(self) -> Parts:
        """Return what is drawn of a body all of whose joints share one point."""
        point, rod = self._points[0], self._rod
        arm = np.zeros(3) if self._centre is None else self._centre - point
        length = float(np.linalg.norm(arm))
        turning = [item for item in self._all if item.kind == "turn"]
        if length > _ARM * rod and any(
            abs(arm @ item.axis) > _PARALLEL * length for item in turning
        ):
            end = point + arm + _BEYOND * rod * arm / length
            disc = forms.rod(_FLANGE * rod, -_FLANGE_HALF * rod, _FLANGE_HALF * rod)
            flange = forms.moved(disc, forms.upright(arm), end)
            # Where nothing holds it in the joint's point, another shaft may be there.
            held = any(abs(arm @ item.axis) < _PARALLEL * length for item in turning)
            bar = self._bar(point if held else point + 0.5 * arm, end)
            return Parts((flange,)) + bar + self._fittings(end, False)
        if len(self._all) > 1 or length < _ARM * rod:
            hubs = [self._stub(item) for item in turning[:1] if len(self._all) == 1]
            return sum(hubs, self._fittings(point + _across(self._all[0].axis), True))
        tip = point + arm
        weight = forms.moved(forms.capsule(1.8 * rod, 0.0), np.eye(3), tip)
        return Parts((weight,)) + self._bar(point, tip) + self._fittings(tip, False)

    def _stub(self, item: Attachment) -> Parts:
        """Return a short hub about the axis of a joint, for a body that has nothing else."""
        hub = forms.rod(1.4 * self._rod, -2.0 * self._rod, 2.0 * self._rod)
        return Parts((forms.moved(hub, forms.upright(item.axis), item.point),))

    def _cross(self) -> Parts:
        """Return the cross of a universal joint: a hub and pins along its axes."""
        axes = _distinct([item.axis for item in self._all if item.kind == "turn"])
        return cross(axes, self._all[0].point, self._rod)

    def _bar(self, start: Array, end: Array) -> Parts:
        """Return a rod between two nodes, which leaves room for the fittings at both."""
        way = _direction(end - start)
        length = float(np.linalg.norm(end - start))
        low, high = self._room(start, way), self._room(end, -way)
        if low + high > 0.9 * length:
            low, high = 0.45 * length * low / (low + high), 0.45 * length * high / (low + high)
        return Parts((self._rod_between(start + low * way, end - high * way),))

    def _room(self, point: Array, way: Array) -> float:
        """Return how far from a node its rod starts [m]."""
        rooms = [0.0]
        for item in self._at(point):
            if item.kind == "cross" or (item.kind == "turn" and item.other in self._crosses):
                if abs(item.axis @ way) < _PARALLEL:
                    rooms.append(_YOKE_REACH - 0.5 * _CHEEK)
            elif item.kind == "turn" and not item.is_child and abs(item.axis @ way) < _PARALLEL:
                rooms.append(_REACH - 0.5 * _CHEEK)
            elif item.kind == "ball" and not item.is_child:
                rooms.append(_SOCKET - 0.2)
        return max(rooms) * self._rod

    def _at(self, point: Array) -> list[Attachment]:
        return [
            item for item in self._all if np.linalg.norm(item.point - point) < _NODES * self._rod
        ]

    def _rod_between(self, start: Array, end: Array) -> Surface:
        return rod_between(start, end, self._rod)

    def _fittings(self, middle: Array | None, plate: bool) -> Parts:
        """Return what the body has at its joints.

        Args:
            middle: `(3,)` to which its rods lead from each joint; None for the farthest joint.
            plate: whether a plate or several rods lead there, where a fork has no room.
        """
        result = Parts()
        for item in self._all:
            inner = middle
            if inner is None:
                away = np.linalg.norm(self._points - item.point, axis=1)
                inner = self._points[np.argmax(away)]
            result += self._fitting(item, _direction(inner - item.point), plate)
        return result

    def _fitting(self, item: Attachment, way: Array, plate: bool) -> Parts:
        """Return what the body has at a joint, with its rod in a direction."""
        rod, along = self._rod, abs(item.axis @ way) > _PARALLEL
        if item.kind == "ball":
            return ball(item.point, way, rod) if item.is_child else socket(item.point, way, rod)
        if item.kind == "slide":
            tube = telescope(item, self._travel, rod)
            if tube is not None:
                return Parts((rod_between(*tube),))
            if item.is_child:
                return block(item.point, item.axis, rod)
            # It begins where the body's rods end.
            ends = self._travel[item.joint]
            ends = ends._replace(low=min(ends.low, 0.0), high=max(ends.high, 0.0))
            return Parts((rail(item.point, item.axis, ends, rod),))
        if item.kind == "cross" or (item.kind == "turn" and item.other in self._crosses):
            return Parts() if along or plate else yoke(item.point, item.axis, way, rod)
        if item.kind != "turn":
            return Parts()
        if along:
            return Parts() if item.is_child else sleeve(item.point, item.axis, rod)
        if item.is_child:
            return eye(item.point, item.axis, rod)
        return pin(item.point, item.axis, rod) if plate else fork(item.point, item.axis, way, rod)


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
    if not is_free or least < _TELESCOPE * rod or greatest - tube > longest:
        return None
    if not item.is_child:
        start = item.point + behind * axis
        return start, start + tube * axis, _TUBE * rod
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
) -> Parts:
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
    across = down - (down @ axis) * axis
    if item.kind == "slide":
        foot = _direction(across) if np.linalg.norm(across) > 0.3 else _across(axis)
        low, high, *_ = travel
        bar = rail(point, axis, travel, rod)
        ends = [low - 1.7 * _BLOCK_HALF * rod, high + 1.7 * _BLOCK_HALF * rod]
        posts = [_post(point + end * axis, axis, foot, 0.5 * rod, rod) for end in ends]
        return Parts((bar, *itertools.chain.from_iterable(posts)))
    if item.kind == "other":
        return Parts()
    if item.kind == "ball":
        foot = down
        cup = (ball if item.is_child else socket)(point, down, rod)
        stem = rod_between(point + 1.5 * rod * foot, point + _FOOT_AT * rod * foot, rod)
        return cup + Parts((stem, *_foot(point, foot, _across(foot), rod)))
    shaft = abs(way @ axis) > _PARALLEL
    if shaft:
        point = point + beside * axis
    if np.linalg.norm(across) > 0.3:
        foot = _direction(across)
    else:
        foot = -axis if way @ axis > 0.0 else axis
    upright = abs(foot @ axis) > _PARALLEL
    if item.kind == "cross" or item.other in crosses:
        if upright:
            return Parts(_foot(point, foot, _across(foot), rod)) + sleeve(point, axis, rod)
        stem = rod_between(
            point + (_YOKE_REACH - 0.3) * rod * foot, point + (_YOKE_REACH + 1.6) * rod * foot, rod
        )
        base = point + (_YOKE_REACH + 1.4 - _FOOT_AT) * rod * foot
        return yoke(point, axis, foot, rod) + Parts((stem, *_foot(base, foot, axis, rod)))
    if upright:
        stem = rod_between(point, point + _FOOT_AT * rod * foot, 1.3 * rod)
        return Parts((stem, *_foot(point, foot, _across(foot), rod))) + sleeve(point, axis, rod)
    if shaft or item.is_child:
        half = _EYE_HALF * rod
        ring = forms.ring(1.05 * rod, _EYE * rod, -half, half)
        hub = forms.moved(ring, forms.upright(axis), point)
        plates = [_cheek(point, axis, foot, _EYE * rod, _FOOT_AT * rod, -0.6 * half, 0.6 * half)]
        if not shaft:
            return Parts((hub, *plates, *_foot(point, foot, axis, rod)))
        # The shaft goes through: the web starts below it.
        plates = list(_post(point, axis, foot, 0.7 * half, rod))
        return Parts((hub, *plates))
    low, high = _GAP * rod, (_GAP + _CHEEK) * rod
    cheeks = [
        _cheek(point, axis, foot, _CHEEK_WIDTH * rod, _FOOT_AT * rod, *ends)
        for ends in ((low, high), (-high, -low))
    ]
    return Parts((*cheeks, *_foot(point, foot, axis, rod))) + pin(point, axis, rod)


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


def nodes_of(attachments: Sequence[Attachment], rod: float) -> list[list[Attachment]]:
    """Return attachments that share a point, by point."""
    nodes: list[list[Attachment]] = []
    for item in attachments:
        for node in nodes:
            if np.linalg.norm(node[0].point - item.point) < _NODES * rod:
                node.append(item)
                break
        else:
            nodes.append([item])
    return nodes


def rod_between(start: Array, end: Array, radius: float) -> Surface:
    """Return a rod from a point to another."""
    length = float(np.linalg.norm(end - start))
    return forms.moved(forms.rod(radius, 0.0, length), forms.upright(end - start), start)


def eye(point: Array, axis: Array, rod: float) -> Parts:
    """Return the eye of a rod about a pin."""
    drum = forms.rod(_EYE * rod, -_EYE_HALF * rod, _EYE_HALF * rod)
    return Parts((forms.moved(drum, forms.upright(axis), point),))


def pin(point: Array, axis: Array, rod: float) -> Parts:
    """Return a pin."""
    bolt = forms.rod(_PIN * rod, -_PIN_HALF * rod, _PIN_HALF * rod)
    return Parts((), (forms.moved(bolt, forms.upright(axis), point),))


def sleeve(point: Array, axis: Array, rod: float) -> Parts:
    """Return a sleeve about a shaft."""
    half = _EYE_HALF * rod
    ring = forms.ring(1.05 * rod, _EYE * rod, -half, half)
    return Parts((forms.moved(ring, forms.upright(axis), point),))


def fork(point: Array, axis: Array, way: Array, rod: float) -> Parts:
    """Return a fork whose cheeks hold a pin, with its rod in a direction."""
    gap = (_GAP * rod, (_GAP + _CHEEK) * rod)
    return Parts(_fork(point, axis, way, gap, _REACH * rod, rod)) + pin(point, axis, rod)


def yoke(point: Array, axis: Array, way: Array, rod: float) -> Parts:
    """Return the fork of a universal joint, which holds two ends of a cross."""
    gap = ((_CROSS_HALF - 1.4 * _CHEEK) * rod, (_CROSS_HALF - 0.2 * _CHEEK) * rod)
    return Parts(_fork(point, axis, way, gap, _YOKE_REACH * rod, rod))


def _fork(
    point: Array, axis: Array, way: Array, gap: tuple[float, float], reach: float, rod: float
) -> tuple[Surface, ...]:
    """Return two cheeks and the bridge between them."""
    width = _CHEEK_WIDTH * rod
    angles = np.linspace(0.5 * np.pi, 1.5 * np.pi, 11)
    outline = np.concatenate(
        [
            width * np.stack([np.cos(angles), np.sin(angles)], axis=1),
            [[reach, -width], [reach, width]],
        ]
    )
    frame = forms.upright(axis, way)
    low, high = gap
    thick = _CHEEK * rod
    bridge = np.array(
        [[reach - thick, -width], [reach, -width], [reach, width], [reach - thick, width]]
    )
    pieces = (
        forms.prism(outline, low, high),
        forms.prism(outline, -high, -low),
        forms.prism(bridge, -low, low),
    )
    return tuple(forms.moved(piece, frame, point) for piece in pieces)


def cross(axes: Sequence[Array], point: Array, rod: float) -> Parts:
    """Return a hub with pins along its axes."""
    half = _CROSS_HALF * rod
    pins = tuple(
        forms.moved(forms.rod(_CROSS_PIN * rod, -half, half), forms.upright(axis), point)
        for axis in axes
    )
    hub = forms.moved(forms.capsule(_CROSS_HUB * rod, 0.0), np.eye(3), point)
    return Parts((*pins, hub))


def ball(point: Array, way: Array, rod: float) -> Parts:
    """Return a ball."""
    return Parts((), (forms.moved(forms.capsule(_BALL * rod, 0.0), forms.upright(way), point),))


def socket(point: Array, way: Array, rod: float) -> Parts:
    """Return the cup around a ball, open away from its rod."""
    cup = forms.cup(1.04 * _BALL * rod, _SOCKET * rod)
    return Parts((forms.moved(cup, forms.upright(way), point),))


def block(point: Array, axis: Array, rod: float) -> Parts:
    """Return what slides along a rail."""
    width, half = _BLOCK * rod, _BLOCK_HALF * rod
    square = width * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    return Parts((forms.moved(forms.prism(square, -half, half), forms.upright(axis), point),))


def rail(point: Array, axis: Array, travel: Travel, rod: float) -> Surface:
    """Return the rail along which a block slides."""
    low, high, *_ = travel
    room, width = 2.0 * _BLOCK_HALF * rod, _RAIL * rod
    square = width * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    bar = forms.prism(square, low - room, high + room)
    return forms.moved(bar, forms.upright(axis), point)


def _cheek(
    point: Array, axis: Array, foot: Array, top: float, height: float, low: float, high: float
) -> Surface:
    """Return a plate across an axis from around it to a foot, where it is twice as wide."""
    angles = np.linspace(0.5 * np.pi, 1.5 * np.pi, 11)
    outline = np.concatenate(
        [
            top * np.stack([np.cos(angles), np.sin(angles)], axis=1),
            [[height, -1.7 * top], [height, 1.7 * top]],
        ]
    )
    return forms.moved(forms.prism(outline, low, high), forms.upright(axis, foot), point)


def _post(point: Array, axis: Array, foot: Array, half: float, rod: float) -> tuple[Surface, ...]:
    """Return a plate below an axis, and its foot."""
    start, end = 0.7 * rod, _FOOT_AT * rod
    outline = np.array(
        [[start, -1.2 * rod], [end, -2.4 * rod], [end, 2.4 * rod], [start, 1.2 * rod]]
    )
    plate = forms.moved(forms.prism(outline, -half, half), forms.upright(axis, foot), point)
    return (plate, *_foot(point, foot, axis, rod))


def _foot(point: Array, foot: Array, axis: Array, rod: float) -> tuple[Surface, ...]:
    """Return a slab at some distance from a point, hatched below."""
    wide, thick = _FOOT_HALF * rod, 0.75 * _FOOT_HALF * rod
    top = _FOOT_AT * rod
    bottom = top + _FOOT_HEIGHT * rod
    frame = forms.upright(axis, foot)
    slab = np.array([[top, -wide], [bottom, -wide], [bottom, wide], [top, wide]])
    pieces = [forms.moved(forms.prism(slab, -thick, thick), frame, point)]
    pitch = 2.0 * wide / _HATCHES
    for index in range(_HATCHES):
        start = -wide + (index + 0.95) * pitch
        low = bottom + _HATCH * rod
        line = np.array(
            [
                [bottom, start],
                [low, start - _HATCH * rod],
                [low, start - _HATCH * rod + 0.3 * pitch],
                [bottom, start + 0.3 * pitch],
            ]
        )
        pieces.append(forms.moved(forms.prism(line[::-1], -thick, thick), frame, point))
    return tuple(pieces)


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


def _span(points: Array) -> float:
    return float(np.linalg.norm(np.ptp(points, axis=0)))


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


def _across(axis: Array) -> Array:
    return _direction(np.cross(np.eye(3)[np.argmin(np.abs(axis))], axis))
