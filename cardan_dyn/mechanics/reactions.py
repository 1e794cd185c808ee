"""Reactions: the wrenches in all joints of a closed chain, as equations of one sample.

A joint's wrench is that of the parent on the body, about the body's frame. With all loops open,
Newton's and Euler's equations of what a joint carries give it; multipliers of the closure equations
make up for what then acts along joints that nothing drives.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

from ..tape import is_zero
from .bodies import Tree
from .elimination import Eliminated, Row, eliminated, pivots
from .placements import Motion, Placed
from .vectors import ZERO, Scalar, Vector, added, cross, dot, less, seen, times, turned


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

    def passed_on(self, tree: Tree, at: Placed, among: Collection[int] | None = None) -> Wrenches:
        """Return what joints carry where these wrenches act on bodies and all that hang there.

        Args:
            tree: the bodies.
            at: where they are.
            among: bodies that it is passed on to, since it vanishes beyond; all of them if None.
        """
        forces, moments = list(self.forces), list(self.moments)
        for index in range(len(tree.bodies) - 1, -1, -1):
            parent = tree.bodies[index].parent
            if parent >= 0 and (among is None or parent in among):
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
    """Return what moves each body by itself (Featherstone 2008, chapter 2, in the tree's axes).

    Args:
        tree: the bodies.
        at: where they are.
        motion: with weight as an acceleration of the world.
        factors: link to the factor on its mass and inertia.
    """
    result = Wrenches.none(tree)
    for share in shares(tree, at, motion, factors):
        force, index = share.force, share.body
        moment = added(cross(share.lever, force), turned(at.rotations[index], share.moment))
        result.forces[index] = added(result.forces[index], force)
        result.moments[index] = added(result.moments[index], moment)
    return result


class Share(NamedTuple):
    """How a mass that a body carries moves, and what moves it.

    Attributes:
        body: index.
        lever: from the body's frame to the centre of mass.
        acceleration, force: of the centre, in the tree's axes.
        spin_rate, moment: about it, in the body's axes.
    """

    body: int
    lever: Vector
    acceleration: Vector
    force: Vector
    spin_rate: Vector
    moment: Vector


def shares(tree: Tree, at: Placed, motion: Motion, factors: Mapping[str, Scalar]) -> list[Share]:
    """Return how masses move: forces m a, moments J ω̇ + ω × J ω; see `momentum_rates`."""
    result = []
    for index, body in enumerate(tree.bodies):
        for mass in body.masses:
            factor = factors[mass.link] - 1.0 if mass.link else 1.0
            rotation = at.rotations[index]
            lever = turned(rotation, mass.centre)
            acceleration = motion.at(index, lever)
            spin, rate = (seen(rotation, of[index]) for of in (motion.spins, motion.spin_rates))
            moment = added(turned(mass.inertia, rate), cross(spin, turned(mass.inertia, spin)))
            result.append(
                Share(
                    index,
                    lever,
                    acceleration,
                    times(acceleration, factor * mass.mass),
                    rate,
                    times(moment, factor),
                )
            )
    return result


def work(forces: Sequence[Share], along: Sequence[Share]) -> Scalar:
    """Return what forces on masses do, per time, along the accelerations of another motion."""
    total: Scalar = 0.0
    for acting, moved in zip(forces, along, strict=True):
        total = total + dot(acting.force, moved.acceleration)
        total = total + dot(acting.moment, moved.spin_rate)
    return total


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
    loaded: set[int] = set()
    for index, loop in enumerate(tree.loops):
        six = [multipliers.get(6 * index + k, 0.0) for k in range(6)]
        if not all(map(is_zero, six)):
            loaded |= tree.around(loop)
        force, moment = tuple(six[:3]), tuple(six[3:])
        for end, sign in ((loop.predecessor, 1.0), (loop.successor, -1.0)):
            lever = at.end(end)[1]
            push = Push(end.body, lever, times(force, sign), times(moment, sign))
            held.against(at, push)
        exchanged.append((times(force, -1.0), times(moment, -1.0)))
    first = 6 * len(tree.loops)
    moments = [-multipliers.get(first + k, 0.0) for k in range(len(tree.couplings))]
    return held.passed_on(tree, at, loaded), exchanged, moments


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
    balanced: Collection[int],
) -> Closed:
    """Return the wrenches of the closed chain; what statics leaves open has the least norm.

    Args:
        tree: the mechanism.
        at: where it is.
        factors: of its closure rows for the passive coordinates.
        open_tree: what joints carry while all loops are open.
        loads: velocity coordinate to the effort added there.
        passives: velocity coordinates along which loads and couplings alone may act.
        counted: indices of the wrenches that the norm counts: of bodies, then of `fixed` loops.
        balanced: closure rows whose forces are wanted; the others exert none.

    Raises:
        UnsuitableError: samples do not tell which self-stresses are independent.
    """
    along = open_tree.along(tree, at, passives)
    multipliers = {
        row: value
        for row, value in factors.solve_transposed(missing(along, loads, passives)).items()
        if row in balanced
    }
    taken, exchanged, couplings = of_multipliers(tree, at, multipliers)
    base = Closed(
        Wrenches(
            list(map(added, open_tree.forces, taken.forces)),
            list(map(added, open_tree.moments, taken.moments)),
        ),
        exchanged,
        couplings,
    )
    stresses = SelfStresses.of(tree, at, factors, counted, balanced)
    own = _entries(tree, base, counted)
    right = [-_product(entries, own) for entries in stresses.entries]
    for column, amount in stresses.normal.solve(right).items():
        base = base.with_added(amount, stresses.items[column])
    return stresses.with_least_moments(tree, base)


class SelfStresses(NamedTuple):
    """Independent self-stresses of a closed chain: wrenches that balance each other.

    Attributes:
        items: the wrenches of each.
        entries: of each, the components that a norm counts, by six times the wrench's index plus
            the component; forces times the length.
        normal: factors of the matrix of their products.
        trains: those that load no joint: moments of closed trains of couplings.
    """

    items: list[Closed]
    entries: list[dict[int, Scalar]]
    normal: Eliminated
    trains: list[Closed]

    @staticmethod
    def of(
        tree: Tree,
        at: Placed,
        factors: Eliminated,
        counted: Sequence[int],
        balanced: Collection[int],
    ) -> SelfStresses:
        """Return those of redundant closure rows; arguments and errors as of `closed`."""
        every = [
            Closed(*of_multipliers(tree, at, factors.dependence(row)))
            for row in factors.redundant
            if row in balanced
        ]
        loading = [(item, _entries(tree, item, counted)) for item in every]
        entries = [own for _, own in loading if own]
        normal = [
            {column: _product(own, other) for column, other in enumerate(entries)}
            for own in entries
        ]
        items = [item for item, own in loading if own]
        trains = [item for item, own in loading if not own]
        return SelfStresses(items, entries, _factors(normal), trains)

    def with_least_moments(self, tree: Tree, of: Closed) -> Closed:
        """Return wrenches once the moments of couplings are as small as trains allow."""
        of_trains = [_moments(tree, train) for train in self.trains]
        normal = [
            {column: _product(own, other) for column, other in enumerate(of_trains)}
            for own in of_trains
        ]
        moments = _moments(tree, of)
        right = [-_product(own, moments) for own in of_trains]
        for column, amount in _factors(normal).solve(right).items():
            of = of.with_added(amount, self.trains[column])
        return of

    def influence(
        self, tree: Tree, at: Placed, counted: Sequence[int]
    ) -> tuple[dict[int, list[Scalar]], list[Scalar]]:
        """Return how much of a self-stress of unit norm each component can be, squared.

        With w the component in each self-stress and N the matrix of their products: wᵀ N⁻¹ w.

        Returns:
            Wrench to its six components in its joint's frame, forces times the length; and the
            same of each coupling's moment. What is zero follows from the laws of motion alone.
        """
        fixed = {loop.wrench: index for index, loop in enumerate(tree.loops)}
        wrenches: dict[int, list[Scalar]] = {}
        for index in counted:
            if index < len(tree.bodies):
                rotation = at.rotations[index]
                own = [(i.wrenches.forces[index], i.wrenches.moments[index]) for i in self.items]
            elif index in fixed:
                rotation = at.end(tree.loops[fixed[index]].successor)[0]
                own = [item.exchanged[fixed[index]] for item in self.items]
            else:
                continue
            rows = [
                [*times(seen(rotation, force), tree.norm_length), *seen(rotation, moment)]
                for force, moment in own
            ]
            wrenches[index] = [self._share(parts) for parts in zip(*rows, strict=True)]
        couplings = [
            self._share(own) for own in zip(*(item.couplings for item in self.items), strict=True)
        ]
        for train in self.trains:
            couplings = couplings or [0.0] * len(tree.couplings)
            total = sum((moment * moment for moment in train.couplings), 0.0)
            for index, moment in enumerate(train.couplings):
                couplings[index] = couplings[index] + moment * moment / total
        return wrenches, couplings

    def _share(self, parts: Sequence[Scalar]) -> Scalar:
        """Return the influence of what has these parts in the self-stresses."""
        shares = self.normal.solve(parts)
        return sum((part * shares[column] for column, part in enumerate(parts)), 0.0)


def _entries(tree: Tree, of: Closed, counted: Sequence[int]) -> dict[int, Scalar]:
    """Return the components that a norm counts and that do not vanish everywhere."""
    fixed = {loop.wrench: index for index, loop in enumerate(tree.loops)}
    result: dict[int, Scalar] = {}
    for index in counted:
        if index < len(tree.bodies):
            force, moment = of.wrenches.forces[index], of.wrenches.moments[index]
        elif index in fixed:
            force, moment = of.exchanged[fixed[index]]
        else:
            continue
        for component, value in enumerate((*times(force, tree.norm_length), *moment)):
            if not is_zero(value):
                result[6 * index + component] = value
    return result


def _moments(tree: Tree, of: Closed) -> dict[int, Scalar]:
    """Return the moments of couplings, forces of slides times the length."""
    slide_rates = {b.rates[0] for b in tree.bodies if b.kind == "prismatic"}
    result: dict[int, Scalar] = {}
    for index, (coupling, moment) in enumerate(zip(tree.couplings, of.couplings, strict=True)):
        if not is_zero(moment):
            slides = slide_rates.intersection(coupling.successors)
            result[index] = moment * tree.norm_length if slides else moment
    return result


def _factors(normal: Sequence[Row]) -> Eliminated:
    """Return the factors of a matrix of products."""
    seen = [{k: _seen(entry) for k, entry in row.items() if not is_zero(entry)} for row in normal]
    return eliminated(normal, pivots(seen))


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
