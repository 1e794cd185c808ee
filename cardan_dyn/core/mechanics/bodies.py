"""Bodies: a mechanism's tree, loops and couplings as plain numbers, read from Pinocchio's model.

Numbers are in the mechanism's own units: lengths in a power of two near its length, so that no
rounding is added, and axes in which the first joint on the world stands at its zero, so that what
is planar or parallel there shows exact zeros however the mechanism stands in the world.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pinocchio

from ...kit.arrays import EPS, Array
from ...kit.frozen import FrozenDict
from ..mechanism.mechanism import Mechanism
from ..mechanism.tree import placed_inertia
from ..mechanism.welds import Coupling as Stated
from .vectors import UNTURNED, Rotation, Scalar, Vector, less

_ROUNDING = 4.0 * EPS
"""Entries of a rotation, or lengths in units of the mechanism's, that are rounding of zero."""


class Mass(NamedTuple):
    """Mass that a body carries.

    Attributes:
        mass: [kg].
        centre: of mass, in the body's frame.
        inertia: about the centre, in the body's axes.
        link: whose factor, less one, multiplies all of it; empty for what counts as it is.
    """

    mass: float
    centre: Vector
    inertia: Rotation
    link: str


class Body(NamedTuple):
    """A body of the tree and the elementary joint that carries it.

    Attributes:
        parent: index of the body that carries it, -1 for the world.
        rotation, translation: the joint's frame at its zero, in the parent.
        kind: `revolute`, `prismatic` or `spherical`.
        axis: unit axis in the joint's frame; the number 0, 1 or 2 where it is one of these.
        column: of coordinate rows at which its coordinates begin.
        rates: its velocity coordinates.
        masses: what it carries.
    """

    parent: int
    rotation: Rotation
    translation: Vector
    kind: str
    axis: int | Vector
    column: int
    rates: tuple[int, ...]
    masses: tuple[Mass, ...]

    @property
    def columns(self) -> range:
        """Columns of coordinate rows that are its coordinates."""
        return range(self.column, self.column + (4 if self.kind == "spherical" else 1))

    @property
    def directions(self) -> Sequence[Vector]:
        """Unit vectors along or about which its velocity coordinates move it, in its frame."""
        if self.kind == "spherical":
            return UNTURNED
        return (UNTURNED[self.axis] if isinstance(self.axis, int) else self.axis,)


class End(NamedTuple):
    """Where a loop is welded.

    Attributes:
        body: index, -1 for the world.
        rotation, translation: of the weld in the body.
    """

    body: int
    rotation: Rotation
    translation: Vector


class Loop(NamedTuple):
    """A weld of two bodies; the loop's joint is one of the tree.

    Attributes:
        predecessor, successor: its ends.
        wrench: index of its wrench, after those of all bodies, if its joint has no body; else -1.
    """

    predecessor: End
    successor: End
    wrench: int


class Coupling(NamedTuple):
    """The successor's displacement is a polynomial of the predecessor's.

    Attributes:
        number: its index in the mechanism.
        ratio, offset: its first coefficients.
        predecessors, successors: velocity coordinates that are summed up.
        higher: its further coefficients.
    """

    number: int
    ratio: float
    offset: float
    predecessors: tuple[int, ...]
    successors: tuple[int, ...]
    higher: tuple[float, ...] = ()


class Spin(NamedTuple):
    """A rod that nothing else keeps from turning about its line, see `spins`.

    Attributes:
        body: index of the rod.
        frame: body relative to which it is told how the rod turns, -1 for the world.
        line, across: unit vectors along its line and at right angles to it, in the rod's frame.
        line_at_zero, across_at_zero: both at the description's zero, seen from the frame.
        rates: velocity coordinates of the joints at its ends.
    """

    body: int
    frame: int
    line: Vector
    across: Vector
    line_at_zero: Vector
    across_at_zero: Vector
    rates: tuple[int, ...]


class Gear(NamedTuple):
    """One of two gears whose teeth keep a coupling, see `teeth`.

    Attributes:
        coupling: its position among the couplings that are solved.
        body: index of the gear.
        rotation, lever: placement of its joint's frame in it.
        axis: of the joint, in that frame.
        column: of the joint's angle.
        sense: 1 if the gear is the joint's child, -1 if it is the parent.
        linear, radial: force and moment on the gear about the joint's origin, in the joint's frame
            at zero, per moment of the coupling and per size of it.
    """

    coupling: int
    body: int
    rotation: Rotation
    lever: Vector
    axis: Vector
    column: int
    sense: float
    linear: tuple[Vector, Vector]
    radial: tuple[Vector, Vector]


class Tree(NamedTuple):
    """All of a mechanism.

    Attributes:
        length: the unit of length [m].
        norm_length: the mechanism's characteristic length, in this unit.
        axes: `(3, 3)` rotation of the tree's axes in the world.
        origin: `(3,)` of the tree in the world [m].
        bodies: in Pinocchio's order.
        loops, couplings: those that are solved.
        units: `(nv,)` of velocity coordinates: the length for slides, else 1.
        spins: rods that spin idly, whose closure rows follow those of the couplings.
        gears: whose teeth keep couplings.
        armature: velocity coordinate to the inertia of rotors along it, where there are any.
    """

    length: float
    norm_length: float
    axes: Array
    origin: Array
    bodies: tuple[Body, ...]
    loops: tuple[Loop, ...]
    couplings: tuple[Coupling, ...]
    units: Array
    spins: tuple[Spin, ...] = ()
    gears: tuple[Gear, ...] = ()
    armature: Mapping[int, float] = FrozenDict({})

    def of_rotors(self, a: Mapping[int, Scalar]) -> dict[int, Scalar]:
        """Return what accelerates rotors, of accelerations, both by velocity coordinates."""
        return {rate: a[rate] * inertia for rate, inertia in self.armature.items() if rate in a}

    def beside_rotors(
        self, efforts: Mapping[int, Scalar], a: Mapping[int, Scalar]
    ) -> dict[int, Scalar]:
        """Return what is left of efforts once rotors are accelerated, likewise."""
        left = dict(efforts)
        for rate, taken in self.of_rotors(a).items():
            left[rate] = left.get(rate, 0.0) - taken
        return left

    @property
    def effort_units(self) -> Array:
        """Units `(nv,)` of what acts along velocity coordinates [N·m, N per unit]."""
        return np.asarray(self.length**2 / self.units)

    def coordinate_units(self, size: int) -> Array:
        """Return the units `(size,)` of coordinate rows: the length for slides, else 1."""
        units = np.ones(size)
        units[[body.column for body in self.bodies if body.kind == "prismatic"]] = self.length
        return units

    def in_axes(self, vector: Array) -> Array:
        """Return vectors `(..., 3)` in world axes in those of the tree."""
        return np.asarray(vector @ self.axes)

    def apart(self, first: int, second: int) -> tuple[list[int], list[int]]:
        """Return the bodies from each of two inwards to what carries both, without that."""
        result: tuple[list[int], list[int]] = [], []
        bodies = [first, second]
        while bodies[0] != bodies[1]:
            # What carries a body has a smaller index.
            side = int(bodies[1] > bodies[0])
            result[side].append(bodies[side])
            bodies[side] = self.bodies[bodies[side]].parent
        return result

    def around(self, loop: Loop) -> set[int]:
        """Return the bodies on a loop, and the one that carries both sides of it, if any does."""
        first, second = self.apart(loop.predecessor.body, loop.successor.body)
        ends = first[-1:] or second[-1:]
        return {*first, *second, *(self.bodies[end].parent for end in ends)} - {-1}

    def part(self, bodies: Sequence[int]) -> Tree:
        """Return the tree of some bodies that only the world connects with others.

        Velocity coordinates and columns keep their numbers.

        Args:
            bodies: their indices, ascending.
        """
        own = {-1: -1, **{body: index for index, body in enumerate(bodies)}}
        rates = {rate for body in bodies for rate in self.bodies[body].rates}
        return self._replace(
            bodies=tuple(
                self.bodies[body]._replace(parent=own[self.bodies[body].parent]) for body in bodies
            ),
            loops=tuple(
                loop._replace(
                    predecessor=loop.predecessor._replace(body=own[loop.predecessor.body]),
                    successor=loop.successor._replace(body=own[loop.successor.body]),
                )
                for loop in self.loops
                if {loop.predecessor.body, loop.successor.body} <= own.keys()
            ),
            couplings=tuple(
                item
                for item in self.couplings
                if rates.issuperset((*item.predecessors, *item.successors))
            ),
        )

    def hung(self, bodies: Sequence[int], base: int, origin: Vector) -> Tree:
        """Return the tree of some bodies as seen from the one that carries them all, at rest.

        Velocity coordinates and columns keep their numbers.

        Args:
            bodies: their indices, each after what carries it.
            base: index of the body that carries all of them, -1 for the world.
            origin: of the result, in the frame of the base.
        """
        own = {base: -1, **{body: index for index, body in enumerate(bodies)}}

        def hangs(body: int, rotation: Rotation, shift: Vector) -> tuple[int, Rotation, Vector]:
            index = own[body]
            return index, rotation, shift if index >= 0 else less(shift, origin)

        def placed(body: Body) -> Body:
            parent, rotation, translation = hangs(body.parent, body.rotation, body.translation)
            return body._replace(parent=parent, rotation=rotation, translation=translation)

        return self._replace(
            axes=self.axes if base < 0 else np.eye(3),
            bodies=tuple(placed(self.bodies[body]) for body in bodies),
            loops=tuple(
                Loop(End(*hangs(*loop.predecessor)), End(*hangs(*loop.successor)), loop.wrench)
                for loop in self.loops
            ),
        )

    def path(self, body: int) -> list[int]:
        """Return the bodies from one inwards."""
        path = []
        while body >= 0:
            path.append(body)
            body = self.bodies[body].parent
        return path


def tree_of(
    mechanism: Mechanism,
    factored: tuple[str, ...] = (),
    loops: Sequence[int] | None = None,
    couplings: Sequence[int] | None = None,
    massive: Collection[int] | None = None,
) -> Tree:
    """Return a mechanism as plain numbers.

    Args:
        mechanism: the mechanism.
        factored: links whose mass and inertia are multiplied by factors.
        loops: indices of those that are solved, all of them if None.
        couplings: likewise.
        massive: likewise bodies whose mass counts.
    """
    model, coordinates = mechanism.model, mechanism.coordinates
    length = 2.0 ** round(math.log2(mechanism.characteristic_length))
    base = next(
        (model.jointPlacements[k] for k in range(1, model.njoints) if not model.parents[k]),
        pinocchio.SE3.Identity(),
    )
    column_of = dict(zip((part.id for part in coordinates.parts), coordinates.starts, strict=True))
    parts = {part.id: part for part in coordinates.parts}
    auxiliary = set(mechanism.auxiliary_bodies)
    links = {link.name: link for link in mechanism.description.links} if factored else {}
    bodies = []
    for index in range(1, model.njoints):
        placement, parent = model.jointPlacements[index], model.parents[index]
        if not parent:
            placement = base.actInv(placement)
        masses = []
        if index not in auxiliary and (massive is None or index - 1 in massive):
            masses.append(_mass(model.inertias[index], length, ""))
            for name in factored:
                carrier, frame = mechanism.link(name)
                if carrier == index:
                    inertia = placed_inertia(links[name], frame)
                    masses.append(_mass(inertia, length, name))
        part = parts[index]
        start = model.idx_vs[index]
        bodies.append(
            Body(
                parent - 1,
                *_placed(placement, length),
                part.kind,
                _axis(part.axis),
                column_of[index],
                tuple(range(start, start + part.nv)),
                tuple(item for item in masses if item.mass > 0.0 or np.any(item.inertia)),
            )
        )
    fixed = [index for index, loop in enumerate(mechanism.loops) if loop.is_fixed]
    welds = []
    for index in range(len(mechanism.loops)) if loops is None else loops:
        loop = mechanism.loops[index]
        ends = [
            End(body - 1, *_placed(placement if body else base.actInv(placement), length))
            for body, placement in (
                (loop.predecessor, loop.predecessor_placement),
                (loop.successor, loop.successor_placement),
            )
        ]
        wrench = len(bodies) + fixed.index(index) if loop.is_fixed else -1
        welds.append(Loop(ends[0], ends[1], wrench))
    solved = range(len(mechanism.couplings)) if couplings is None else couplings
    units = np.ones(model.nv)
    for body in bodies:
        if body.kind == "prismatic":
            units[list(body.rates)] = length
    return Tree(
        length,
        mechanism.characteristic_length / length,
        np.array([[*map(_exact, row)] for row in base.rotation.tolist()]),
        np.array(base.translation),
        tuple(bodies),
        tuple(welds),
        tuple(_coupling(index, mechanism.couplings[index], units) for index in solved),
        units,
        armature={
            rate: float(inertia * (units[rate] / length) ** 2)
            for rate, inertia in enumerate(model.armature)
            if inertia
        },
    )


def massless(mechanism: Mechanism, loops: Iterable[int], couplings: Iterable[int]) -> Tree:
    """Return a mechanism as plain numbers, which it keeps, without masses.

    Args:
        mechanism: the mechanism.
        loops: indices of those that the tree has.
        couplings: likewise.
    """
    whole = mechanism.kept.of("tree", "", lambda: tree_of(mechanism, massive=()))
    return whole._replace(
        loops=tuple(whole.loops[index] for index in loops),
        couplings=tuple(whole.couplings[index] for index in couplings),
    )


def _coupling(index: int, stated: Stated, units: Array) -> Coupling:
    """Return a coupling of displacements in units of the length."""
    first, second = (
        units[columns[0]] if columns else 1.0
        for columns in (stated.predecessor_columns, stated.successor_columns)
    )
    return Coupling(
        index,
        stated.ratio * first / second,
        stated.offset / second,
        stated.predecessor_columns,
        stated.successor_columns,
        tuple(value * first**power / second for power, value in enumerate(stated.higher, 2)),
    )


def _placed(placement: pinocchio.SE3, length: float) -> tuple[Rotation, Vector]:
    """Return a rotation by its columns, and a translation in units of the length."""
    rotation = tuple(tuple(map(_exact, column)) for column in placement.rotation.T.tolist())
    if rotation == UNTURNED:
        rotation = UNTURNED
    translation = tuple(_without_rounding(x / length) for x in placement.translation.tolist())
    return rotation, translation


def _axis(axis: Array) -> int | Vector:
    """Return a unit axis, by its number if it is that of x, y or z."""
    values = tuple(map(_exact, axis.tolist()))
    return UNTURNED.index(values) if values in UNTURNED else values


def _mass(inertia: pinocchio.Inertia, length: float, link: str) -> Mass:
    """Return mass in units of the length."""
    centre = tuple(_without_rounding(x / length) for x in inertia.lever.tolist())
    about = np.array(inertia.inertia) / length**2
    # Beside the moments about both axes: one of a thin rod is small, and no rounding.
    sizes = np.sqrt(np.abs(np.diag(about)))
    least = _ROUNDING * np.outer(sizes, sizes)
    entries = np.where(np.abs(about) > least, about, 0.0)
    return Mass(float(inertia.mass), centre, tuple(map(tuple, entries.T.tolist())), link)


def _without_rounding(value: float) -> float:
    """Return a number, zero where it is rounding of zero beside one."""
    return value if abs(value) > _ROUNDING else 0.0


def _exact(value: float) -> float:
    """Return an entry of a unit vector, exactly 0, 1 or -1 where it is that but for rounding."""
    nearest = float(round(value))
    return nearest if abs(value - nearest) <= _ROUNDING else value
