"""Reactions: the wrenches in all joints of a closed chain, as equations of one sample.

A joint's wrench is that of the parent on the body, about the body's frame. With all loops open,
Newton's and Euler's equations of what a joint carries give it; multipliers of the closure equations
make up for what then acts along joints that nothing drives.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

from ..tape import is_zero
from .bodies import Mass, Tree
from .elimination import Eliminated, eliminated, pivots
from .placements import Motion, Placed
from .vectors import ZERO, Rotation, Scalar, Vector, added, cross, dot, less, seen, times, turned


class Push(NamedTuple):
    """A wrench on a body.

    Attributes:
        body: index.
        lever: from the body's frame to where the force acts.
        force, moment: in the tree's axes.
    """

    body: int
    lever: Vector
    force: Vector
    moment: Vector


class Wrenches(NamedTuple):
    """Wrenches in the tree's axes, each about its body's frame.

    Attributes:
        forces, moments: body by body.
    """

    forces: list[Vector]
    moments: list[Vector]

    @staticmethod
    def none(tree: Tree) -> Wrenches:
        """Return wrenches that vanish."""
        return Wrenches([ZERO] * len(tree.bodies), [ZERO] * len(tree.bodies))

    def against(self, at: Placed, push: Push) -> None:
        """Add what holds a body against a wrench on it."""
        if push.body >= 0:
            moment = added(push.moment, cross(push.lever, push.force))
            self.forces[push.body] = less(self.forces[push.body], push.force)
            self.moments[push.body] = less(self.moments[push.body], moment)

    def passed_on(self, tree: Tree, at: Placed) -> Wrenches:
        """Return what joints carry where these wrenches act on bodies and all that hang there."""
        forces, moments = list(self.forces), list(self.moments)
        for index in range(len(tree.bodies) - 1, -1, -1):
            parent = tree.bodies[index].parent
            if parent >= 0:
                lever = less(at.points[index], at.points[parent])
                forces[parent] = added(forces[parent], forces[index])
                moment = added(moments[index], cross(lever, forces[index]))
                moments[parent] = added(moments[parent], moment)
        return Wrenches(forces, moments)

    def along(self, tree: Tree, at: Placed, rates: Collection[int]) -> dict[int, Scalar]:
        """Return what acts along velocity coordinates."""
        result: dict[int, Scalar] = {}
        for index, body in enumerate(tree.bodies):
            vectors = self.forces if body.kind == "prismatic" else self.moments
            for rate in body.rates:
                if rate in rates:
                    result[rate] = dot(at.directions[rate], vectors[index])
        return result


def momentum_rates(
    tree: Tree, at: Placed, motion: Motion, factors: Mapping[str, Scalar]
) -> Wrenches:
    """Return what moves each body by itself (Featherstone 2008, eq. 2.72, in the tree's axes).

    Args:
        tree: the bodies.
        at: where they are.
        motion: with weight as an acceleration of the world.
        factors: link to the factor on its mass and inertia.
    """
    result = Wrenches.none(tree)
    for index, body in enumerate(tree.bodies):
        for mass in body.masses:
            factor = factors[mass.link] - 1.0 if mass.link else 1.0
            force, moment = _momentum_rate(mass, at.rotations[index], motion, index, factor)
            result.forces[index] = added(result.forces[index], force)
            result.moments[index] = added(result.moments[index], moment)
    return result


def _momentum_rate(
    mass: Mass, rotation: Rotation, motion: Motion, body: int, factor: Scalar
) -> tuple[Vector, Vector]:
    """Return m a and, about the frame, r × m a + R (J ω̇ + ω × J ω)."""
    lever = turned(rotation, mass.centre)
    force = times(motion.at(body, lever), factor * mass.mass)
    spin, spin_rate = (seen(rotation, of[body]) for of in (motion.spins, motion.spin_rates))
    change = added(turned(mass.inertia, spin_rate), cross(spin, turned(mass.inertia, spin)))
    return force, added(cross(lever, force), times(turned(rotation, change), factor))


def missing(
    along: Mapping[int, Scalar], loads: Mapping[int, Scalar], passives: Collection[int]
) -> dict[int, Scalar]:
    """Return what acts along passive coordinates more than loads exert there."""
    return {rate: along[rate] - loads.get(rate, 0.0) for rate in passives}


def of_multipliers(
    tree: Tree, at: Placed, multipliers: Mapping[int, Scalar]
) -> tuple[Wrenches, list[tuple[Vector, Vector]], list[Scalar]]:
    """Return what multipliers of the closure rows take from the wrenches of joints.

    Returns:
        What they add to all wrenches; per loop the force and moment of the predecessor on the
        successor, about the weld; per coupling the moment that it exerts on its successor's joint.
    """
    held = Wrenches.none(tree)
    exchanged: list[tuple[Vector, Vector]] = []
    for index, loop in enumerate(tree.loops):
        six = [multipliers.get(6 * index + k, 0.0) for k in range(6)]
        force, moment = tuple(six[:3]), tuple(six[3:])
        for end, sign in ((loop.predecessor, 1.0), (loop.successor, -1.0)):
            lever = at.end(end)[1]
            push = Push(end.body, lever, times(force, sign), times(moment, sign))
            held.against(at, push)
        exchanged.append((times(force, -1.0), times(moment, -1.0)))
    first = 6 * len(tree.loops)
    moments = [-multipliers.get(first + k, 0.0) for k in range(len(tree.couplings))]
    return held.passed_on(tree, at), exchanged, moments


class Closed(NamedTuple):
    """The wrenches of a closed chain.

    Attributes:
        wrenches: of all joints.
        exchanged: per loop, force and moment of the predecessor on the successor about the weld.
        couplings: moments of the couplings at their successors' joints.
    """

    wrenches: Wrenches
    exchanged: list[tuple[Vector, Vector]]
    couplings: list[Scalar]

    def with_added(self, factor: Scalar, other: Closed) -> Closed:
        """Return the sum of these and others times a factor."""

        def total(first: Vector, second: Vector) -> Vector:
            return added(first, times(second, factor))

        each = zip(self.wrenches, other.wrenches, strict=True)
        wrenches = Wrenches(*(list(map(total, mine, theirs)) for mine, theirs in each))
        exchanged = [
            (total(*forces), total(*moments))
            for forces, moments in (
                zip(mine, theirs, strict=True)
                for mine, theirs in zip(self.exchanged, other.exchanged, strict=True)
            )
        ]
        moments = [
            mine + theirs * factor
            for mine, theirs in zip(self.couplings, other.couplings, strict=True)
        ]
        return Closed(wrenches, exchanged, moments)


def closed(
    tree: Tree,
    at: Placed,
    factors: Eliminated,
    open_tree: Wrenches,
    loads: Mapping[int, Scalar],
    passives: Collection[int],
    counted: Sequence[int],
) -> Closed:
    """Return the wrenches of the closed chain; what statics leaves open has the least norm.

    Args:
        tree: the mechanism.
        at: where it is.
        factors: of its closure rows for the passive coordinates.
        open_tree: what joints carry while all loops are open.
        loads: velocity coordinate to the effort added there.
        passives: velocity coordinates along which loads and couplings alone may act.
        counted: bodies whose joints the norm counts, then `fixed` loops from the number of bodies.

    Raises:
        UnsuitableError: samples do not tell which self-stresses are independent.
    """
    along = open_tree.along(tree, at, passives)
    multipliers = factors.solve_transposed(missing(along, loads, passives))
    taken, exchanged, couplings = of_multipliers(tree, at, multipliers)
    base = Closed(
        Wrenches(
            list(map(added, open_tree.forces, taken.forces)),
            list(map(added, open_tree.moments, taken.moments)),
        ),
        exchanged,
        couplings,
    )
    stresses = [
        Closed(*of_multipliers(tree, at, factors.dependence(row))) for row in factors.redundant
    ]
    loading = [(item, _entries(tree, item, counted)) for item in stresses]
    # Moments of a closed train of couplings load no joint: none is added.
    loading = [(item, entries) for item, entries in loading if entries]
    if not loading:
        return base
    own = _entries(tree, base, counted)
    normal = [
        {column: _product(entries, other) for column, (_, other) in enumerate(loading)}
        for _, entries in loading
    ]
    right = [-_product(entries, own) for _, entries in loading]
    order = pivots(
        [{k: _seen(entry) for k, entry in row.items() if not is_zero(entry)} for row in normal]
    )
    amounts = eliminated(normal, order).solve(right)
    for column, (item, _) in enumerate(loading):
        base = base.with_added(amounts[column], item)
    return base


def _entries(tree: Tree, of: Closed, counted: Sequence[int]) -> dict[int, Scalar]:
    """Return the components that a norm counts and that do not vanish everywhere."""
    fixed = [index for index, loop in enumerate(tree.loops) if loop.is_fixed]
    result: dict[int, Scalar] = {}
    for index in counted:
        if index < len(tree.bodies):
            force, moment = of.wrenches.forces[index], of.wrenches.moments[index]
        else:
            force, moment = of.exchanged[fixed[index - len(tree.bodies)]]
        for component, value in enumerate((*times(force, tree.norm_length), *moment)):
            if not is_zero(value):
                result[6 * index + component] = value
    return result


def _product(first: Mapping[int, Scalar], second: Mapping[int, Scalar]) -> Scalar:
    """Return the sum of products of components that both have."""
    total: Scalar = 0.0
    for key, value in first.items():
        if key in second:
            total = total + value * second[key]
    return total


def _seen(entry: Scalar) -> Scalar:
    """Return a scalar's values at the samples at which orders are chosen."""
    return getattr(entry, "shadow", entry)
