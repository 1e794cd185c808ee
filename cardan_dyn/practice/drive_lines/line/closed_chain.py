"""Closed chain: the URDF+ description of a drive line.

A chain of places bends where the joints are: `frame_k` has its origin at the centre of joint k and
x along shaft k, `frame_0` lies at joint 1 along the input shaft. Housings of bearings stand on it.
The links that turn are `shaft_k`, behind its spline `slide_k`, its rear fork `fork_k`, and
`cross_k`. At zero the input fork's pin is horizontal, and all loops are closed.

- `pin_k_in` and `pin_k_out` are the pins of joint k, `slip_k` is the spline of shaft k.
  It has its origin at the spline, or at joint k if all bearings of the shaft are behind that.
- `support_A` and so on are the bearings. They are balls, which unless locating sit in a cage that
  slides along the axis. A shaft with bearings turns in a sleeve that does not: its first bearing
  keeps the sleeve from turning, so that a torque that drives or loads the shaft from outside is the
  moment about x in it.
- `bearing_k` turns shaft k in its sleeve. `bearing_in` and `bearing_out`, of the end shafts, have
  their origins at the centres of the first and the last joint; an end shaft without bearings turns
  on its place in this one alone.

- A joint of constant velocity bends about `pin_k_in`, `pin_k_bend` and `pin_k_out`, of which the
  last one follows the first: so its halves are mirror images, and it passes on all rotation.
- `centring_k` is the centring of the coupling piece k: a ball between the shafts beside it. A ball
  that slides along one of them has a cage on it; where both reach into a disc, `centring_k` holds
  the shaft behind the piece and `centring_front_k` the one before it, in cages that slide through
  the disc, and the disc slides in the middle plane of the piece. Studs are as long as the angles of
  the data need.

Shafts with bearings hang from their places, and a loop joins them to the cross before them; others
hang from that cross. So no chain of links is longer than it has to be.

Adjustable joints, zero where the data are: `joint_angle_k` adds to the joint angle in its bending
plane, `joint_plane_k` turns the bending plane, and all behind it, about the shaft before it;
`fork_offset_k` turns the rear fork of shaft k; `shaft_length_k` moves what lies behind shaft k
along it, and the bearings behind its spline; a shaft without a spline follows with `tube_length_k`;
`offset_y_k` and `offset_z_k` move what lies behind shaft k across it, to the left and upwards in
the data; `support_A_y` and `support_A_z` do so with a bearing.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from ....core.description.elements import rotation, words
from ....core.description.write import angles_of
from ....kit.arrays import Array
from .data import LineData
from .geometry import centring_places, levelled
from .parts import ShaftJoint
from .supports import Support, hangs_by_rear, in_order, spline_distance, supports
from .visuals import cross_visuals, rear_fork_visuals, shaft_visuals

X, Y, Z = np.eye(3)
NONE = np.zeros(3)
_RANGE = {"revolute": 3.15, "prismatic": 1.0}
"""Limits that URDF asks for [rad, m]; scenes do not regard them."""


def urdf(line: LineData) -> str:
    """Return the line as a closed-chain URDF+ description, which `cardan_dyn.load` reads.

    `closed_chain` says what its links and joints are. All that is a matter of design is an
    adjustable joint.

    Raises:
        ModelError: what is missing for the line to be held.
    """
    return _Writer(line).text()


class _Writer:
    """A description of a line that is being written, element by element."""

    def __init__(self, line: LineData) -> None:
        self.element = ElementTree.Element("robot", name=line.name or "drive_line")
        self.line = line
        self.supports = supports(line)
        self.zero = line.zero
        self.links: set[str] = set()
        self.rears: dict[int, str] = {}

    def text(self) -> str:
        """Write the places, then the shafts along the power flow, and return all as text."""
        self.places()
        fork = "shaft_0"
        for k in range(self.line.count + 1):
            if k:
                self.cross(k)
                turn = self.zero.driving[k - 1] * Y
                self.joint(f"pin_{k}_in", "continuous", fork, f"cross_{k}", Y, rpy=turn)
            self.rears[k] = fork = self.shaft(k)
            if k > 1 and self.line.shafts[k - 1].centring is not None:
                self.centring(k - 1)
        ElementTree.indent(self.element)
        return ElementTree.tostring(self.element, encoding="unicode") + "\n"

    def centring(self, k: int) -> None:
        """Write the centring of coupling piece k between the shafts beside it."""
        found, kind = self.line.geometry, self.line.shafts[k].centring
        if kind is None:
            return
        before, behind = centring_places(self.line.shafts, found, k)
        front, rear = (self.rears[k - 1], before), (f"shaft_{k + 1}", -behind)
        if kind.kind == "ball":
            fixed, along = (rear, front) if kind.fixed_to == "rear" else (front, rear)
            self.caged(f"centring_{k}", along, fixed)
            return
        # Where the disc is in the piece: that turns at zero as its pins do.
        turn = rotation(-self.zero.rotations[k], 0.0, 0.0)
        place = turn @ found.frames[k].T @ (before * found.directions[k - 1])
        self.joint(f"disc_slide_{k}_y", "prismatic", f"shaft_{k}", f"disc_{k}_y", Y, xyz=place)
        self.joint(f"disc_slide_{k}_z", "prismatic", f"disc_{k}_y", f"disc_{k}", Z)
        self.caged(f"centring_front_{k}", (f"disc_{k}", 0.0), front)
        self.caged(f"centring_{k}", (f"disc_{k}", 0.0), rear)

    def caged(self, name: str, along: tuple[str, float], fixed: tuple[str, float]) -> None:
        """Write a ball fixed to one link in a cage that slides along x of another one."""
        cage, at = f"cage_{name}", along[1] * X
        self.joint(f"cage_slide_{name}", "prismatic", along[0], cage, X, xyz=at)
        self.loop(name, "spherical", (cage, NONE, NONE), (fixed[0], fixed[1] * X, NONE))

    def cross(self, k: int) -> None:
        """Write the cross of a joint, with x along the normal of its pins."""
        joint = self.line.joints[k - 1]
        pin, normal = cross_inertia(joint)
        body = Body(joint.cross_mass, 0.0, normal, pin)
        self.link(f"cross_{k}", body, cross_visuals(self.line, k))

    def places(self) -> None:
        """Write the chain of places."""
        found, last = self.line.geometry, self.line.count
        self.link("base")
        axes = angles_of(found.frames[0])
        self.joint("seat", "fixed", "base", "frame_0", X, xyz=found.centres[0], rpy=axes)
        before = "frame_0"
        for k in range(1, last + 1):
            plane, bend = found.plane_offsets[k - 1] * X, found.joint_angles[k - 1] * Z
            self.adjustable(f"joint_plane_{k}", "revolute", before, f"plane_{k}", X, rpy=plane)
            self.adjustable(f"joint_angle_{k}", "revolute", f"plane_{k}", f"frame_{k}", Z, rpy=bend)
            if k < last:
                end = found.lengths[k] * X
                self.adjustable(
                    f"shaft_length_{k}", "prismatic", f"frame_{k}", f"end_{k}", X, xyz=end
                )
                before = self.moved(f"offset_{{}}_{k}", k, f"end_{k}", 0.0)

    def moved(self, name: str, index: int, parent: str, at: float) -> str:
        """Write a place that can be moved across shaft `index`, and return its link."""
        found = self.line.geometry
        _, left, up = (found.frames[index].T @ levelled(found.directions[index])).T
        for letter, axis in (("y", left), ("z", up)):
            joint = name.format(letter)
            child = f"{joint}_place"
            self.adjustable(joint, "prismatic", parent, child, axis, xyz=at * X)
            parent, at = child, 0.0
        return parent

    def shaft(self, k: int) -> str:
        """Write a shaft with its bearings, joined to its cross, and return its rear fork's link."""
        front, behind = shaft_bodies(self.line, k)
        self.link(f"shaft_{k}", front, shaft_visuals(self.line, k))
        if self.line.shafts[k].spline is not None:
            start = spline_distance(self.line, k)
            self.link(f"slide_{k}", behind and behind._replace(centre=behind.centre - start))
        of_shaft = in_order(self.supports, k)
        first = of_shaft[0] if of_shaft else None
        has_place = first is not None or k in (0, self.line.count)
        if has_place:
            self.placed(k, first)
        if k:
            self.driven(k, has_place)
        carrier = self.rear_piece(k)
        for item in of_shaft[1:]:
            self.further_bearing(item, of_shaft[0])
        return self.rear_fork(k, carrier) if 0 < k < self.line.count else f"shaft_{k}"

    def placed(self, k: int, first: Support | None) -> None:
        """Write what a shaft turns in: the sleeve in its first bearing, or its place alone."""
        name = {0: "bearing_in", self.line.count: "bearing_out"}.get(k, f"bearing_{k}")
        turn, carrier = self.zero.rotations[k] * X, f"frame_{k}"
        there, carried = 0.0, f"shaft_{k}"
        if first is not None:
            place, carrier = self.bearing_place(first), f"sleeve_{k}"
            there, carried = self.on_shaft(first)
            self.joint(first.joint, "universal", place, carrier, Y, axis2=Z)
        turning = self.joint(name, "continuous", carrier, carried, X, xyz=-there * X, rpy=turn)
        if k == 0:
            turning.set("independent", "true")

    def further_bearing(self, item: Support, first: Support) -> None:
        """Write a bearing on the sleeve of the first one, or on the piece behind the spline."""
        place, k = self.bearing_place(item), item.shaft
        carried, there, turn = f"sleeve_{k}", item.along - first.along, 0.0
        if item.behind != first.behind:
            there, carried = self.on_shaft(item)
            turn = -self.zero.rotations[k]  # The ball then stands straight at zero.
        self.loop(item.joint, "spherical", (place, NONE, NONE), (carried, there * X, turn * X))

    def on_shaft(self, item: Support) -> tuple[float, str]:
        """Return x of a bearing in the link that it carries, and this link."""
        if item.behind:
            return item.distance - spline_distance(self.line, item.shaft), f"slide_{item.shaft}"
        return item.along, f"shaft_{item.shaft}"

    def bearing_place(self, item: Support) -> str:
        """Write the place of a bearing, and return its link, whose origin is the bearing."""
        name, frame, at = item.joint + "_{}", f"frame_{item.shaft}", item.along
        if item.behind:
            frame, at = f"end_{item.shaft}", at - float(self.line.geometry.lengths[item.shaft])
        place = self.moved(name, item.shaft, frame, at)
        if item.locating:
            return place
        cage = f"cage_{item.name}"
        self.joint(f"cage_slide_{item.name}", "prismatic", place, cage, X)
        return cage

    def driven(self, k: int, has_place: bool) -> None:
        """Write the driven pin of joint k, which is a loop if the shaft has a place of its own."""
        turn = self.zero.driven[k - 1] * Z
        if self.line.even[k - 1]:
            self.driven_evenly(k, has_place)
        elif has_place:
            ends = (f"cross_{k}", NONE, turn), (f"shaft_{k}", NONE, NONE)
            self.loop(f"pin_{k}_out", "continuous", *ends, axis=Z)
        else:
            self.joint(f"pin_{k}_out", "continuous", f"cross_{k}", f"shaft_{k}", Z, rpy=turn)

    def driven_evenly(self, k: int, has_place: bool) -> None:
        """Write the rear half of a joint of constant velocity, the mirror image of the front."""
        bend, turn = 2.0 * self.zero.driven[k - 1] * Z, self.zero.driving[k - 1] * Y
        self.joint(f"pin_{k}_bend", "continuous", f"cross_{k}", f"half_{k}", Z, rpy=bend)
        name, end = f"pin_{k}_out", f"shaft_{k}"
        if has_place:
            name, end = f"pin_{k}_turn", f"follower_{k}"
        follower = self.joint(name, "continuous", f"half_{k}", end, Y, rpy=turn)
        # Both halves of a joint of constant velocity turn alike, which takes moments alone.
        following = {"joint": f"pin_{k}_in", "multiplier": "1", "offset": "0", "forces": "none"}
        ElementTree.SubElement(follower, "mimic", following)
        if has_place:
            self.loop(f"pin_{k}_out", "fixed", (end, NONE, NONE), (f"shaft_{k}", NONE, NONE))

    def rear_piece(self, k: int) -> str:
        """Join what lies behind a shaft's spline; return its link, or the shaft's without one.

        If the rear piece hangs from its place, the front piece hangs from it: the slip then has the
        front piece as its child, and still grows when it is drawn out.
        """
        if self.line.shafts[k].spline is None:
            return f"shaft_{k}"
        start, name = spline_distance(self.line, k), f"slide_{k}"
        ends, axis = (f"shaft_{k}", name), X
        if hangs_by_rear(self.supports, k):
            ends, axis, start = ends[::-1], -X, -start
        self.joint(f"slip_{k}", "prismatic", *ends, axis, xyz=start * X)
        return name

    def rear_fork(self, k: int, carrier: str) -> str:
        """Write the rear fork of an intermediate shaft, and return its link."""
        shaft, end = self.line.shafts[k], float(self.line.geometry.lengths[k])
        self.link(f"fork_{k}", visuals=rear_fork_visuals(self.line, k))
        if shaft.spline is None:
            at = end * X
            self.adjustable(f"tube_length_{k}", "prismatic", carrier, f"tube_end_{k}", X, xyz=at)
            carrier, end = f"tube_end_{k}", 0.0
        else:
            end -= spline_distance(self.line, k)
        origin = {"xyz": end * X, "rpy": (math.pi / 2 + shaft.fork_offset) * X}
        self.adjustable(f"fork_offset_{k}", "revolute", carrier, f"fork_{k}", X, **origin)
        return f"fork_{k}"

    def link(
        self, name: str, body: Body | None = None, visuals: Iterable[ElementTree.Element] = ()
    ) -> None:
        """Write a link with its inertia, if it has any, and its shapes."""
        self.links.add(name)
        link = ElementTree.SubElement(self.element, "link", name=name)
        if body is not None and body.mass:
            inertial = ElementTree.SubElement(link, "inertial")
            ElementTree.SubElement(inertial, "origin", xyz=words(body.centre * X))
            ElementTree.SubElement(inertial, "mass", value=words([body.mass]))
            about, across = words([body.inertia]), words([body.transverse])
            products = dict.fromkeys(("ixy", "ixz", "iyz"), "0")
            ElementTree.SubElement(inertial, "inertia", products, ixx=about, iyy=across, izz=across)
        link.extend(visuals)

    def joint(
        self,
        name: str,
        kind: str,
        parent: str,
        child: str,
        axis: Array,
        *,
        xyz: Iterable[float] = NONE,
        rpy: Iterable[float] = NONE,
        axis2: Array | None = None,
    ) -> ElementTree.Element:
        """Write a tree joint, and its child where that has not been written."""
        if child not in self.links:
            self.link(child)
        joint = ElementTree.SubElement(self.element, "joint", name=name, type=kind)
        ElementTree.SubElement(joint, "parent", link=parent)
        ElementTree.SubElement(joint, "child", link=child)
        ElementTree.SubElement(joint, "origin", xyz=words(xyz), rpy=words(rpy))
        if kind != "fixed":
            ElementTree.SubElement(joint, "axis", xyz=words(axis))
        if axis2 is not None:
            ElementTree.SubElement(joint, "axis2", xyz=words(axis2))
        if kind == "prismatic":
            _limit(joint, kind)
        return joint

    def adjustable(
        self, name: str, kind: str, parent: str, child: str, axis: Array, **origin: Array
    ) -> None:
        """Write a joint that is fixed unless a scene holds it."""
        joint = self.joint(name, "fixed", parent, child, axis, **origin)
        joint.set("adjustable", kind)
        ElementTree.SubElement(joint, "axis", xyz=words(axis))
        _limit(joint, kind)

    def loop(
        self,
        name: str,
        kind: str,
        predecessor: tuple[str, Array, Array],
        successor: tuple[str, Array, Array],
        axis: Array | None = None,
    ) -> None:
        """Write a loop between two links, with the place and turn of its frame in each."""
        loop = ElementTree.SubElement(self.element, "loop", name=name, type=kind)
        sides = {"predecessor": predecessor, "successor": successor}
        for side, (link, xyz, rpy) in sides.items():
            end = ElementTree.SubElement(loop, side, link=link)
            ElementTree.SubElement(end, "origin", xyz=words(xyz), rpy=words(rpy))
        if axis is not None:
            ElementTree.SubElement(loop, "axis", xyz=words(axis))


def _limit(joint: ElementTree.Element, kind: str) -> None:
    size = _RANGE[kind]
    limit = {"lower": f"{-size}", "upper": f"{size}", "effort": "1e6", "velocity": "10"}
    ElementTree.SubElement(joint, "limit", limit)


class Body(NamedTuple):
    """A body that is symmetric about x.

    Attributes:
        mass: [kg]; greater than 0.
        centre: x of its centre of mass in its link [m].
        inertia: about x [kg·m²].
        transverse: about y and z through its centre of mass [kg·m²].
    """

    mass: float
    centre: float
    inertia: float
    transverse: float


def shaft_bodies(line: LineData, index: int) -> tuple[Body | None, Body | None]:
    """Return the bodies of a shaft: before its spline, or all of it, and behind its spline.

    Distances count from the joint at its front, for the input shaft from joint 1 with x along the
    power flow. A shaft with a spline is divided there like a rod of constant cross section, unless
    its centre or transverse inertia is given; then all of its mass is before the spline.
    """
    shaft = line.shafts[index]
    given = float(line.geometry.lengths[index])
    length = 0.0 if math.isnan(given) else given
    tube, mass = shaft.tube, shaft.mass_at(length)
    if mass == 0.0:
        return None, None
    inertia = shaft.inertia
    if inertia is None:
        # J = m (D² + d²) / 8
        squares = tube.outer_diameter**2 + tube.inner_diameter**2 if tube else 0.0
        inertia = mass * squares / 8.0
    centre = length / 2.0 if shaft.centre is None else shaft.centre
    transverse = shaft.transverse_inertia
    if transverse is None:
        transverse = mass * length**2 / 12.0 + inertia / 2.0
    if index == 0:
        return Body(mass, -centre, inertia, transverse), None
    if shaft.spline is None or shaft.centre is not None or shaft.transverse_inertia is not None:
        return Body(mass, centre, inertia, transverse), None
    cut = spline_distance(line, index)
    front = _piece(mass, inertia, length, 0.0, cut)
    return front, _piece(mass, inertia, length, cut, length)


def cross_inertia(joint: ShaftJoint) -> tuple[float, float]:
    """Return the inertias of a cross about its pins and about their normal [kg·m²].

    Two slender rods of half the mass each, m s²/24 and m s²/12.
    """
    square = joint.cross_mass * joint.cross_span**2
    return square / 24.0, square / 12.0


def _piece(mass: float, inertia: float, length: float, start: float, end: float) -> Body | None:
    """Return a piece of a rod; its centre counts from the start of the rod."""
    share = (end - start) / length
    if share <= 0.0:
        return None
    own, about = mass * share, inertia * share
    return Body(own, (start + end) / 2.0, about, own * (end - start) ** 2 / 12.0 + about / 2.0)
