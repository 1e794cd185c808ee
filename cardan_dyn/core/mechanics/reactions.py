"""Reactions: the wrenches in all joints of a closed chain, as equations of one sample.

A joint's wrench is that of the parent on the body, about the body's frame. With all loops open,
Newton's and Euler's equations of what a joint carries give it; multipliers of the closure equations
make up for what then acts along joints that nothing drives.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from ...kit.arrays import NOTHING, generic
from ..tape import is_zero, sqrt
from . import closure
from .bodies import Tree
from .elimination import (
    Eliminated,
    Order,
    Pivot,
    Row,
    UnsuitableError,
    combined,
    eliminated,
    product,
)
from .placements import Motion, Placed
from .vectors import (
    UNTURNED,
    ZERO,
    Rotation,
    Scalar,
    Vector,
    added,
    cross,
    dot,
    less,
    seen,
    times,
    turned,
)


class Push(NamedTuple):
    """A wrench on a body.

    Attributes:
        body: index.
        lever: from the body's frame to where the force acts, in its axes.
        force, moment: likewise.
    """

    body: int
    lever: Vector
    force: Vector
    moment: Vector


class Wrenches(NamedTuple):
    """Wrenches about and in the axes of their bodies' frames.

    Attributes:
        forces, moments: body by body.
    """

    forces: list[Vector]
    moments: list[Vector]

    @staticmethod
    def none(tree: Tree) -> Wrenches:
        """Return wrenches that vanish."""
        return Wrenches([ZERO] * len(tree.bodies), [ZERO] * len(tree.bodies))

    def against(self, push: Push) -> None:
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
            among: bodies that it is passed on to, since it vanishes beyond and at others; all of
                them if None.
        """
        forces, moments = list(self.forces), list(self.moments)
        bodies = range(len(tree.bodies)) if among is None else among
        for index in sorted(bodies, reverse=True):
            parent = tree.bodies[index].parent
            if parent >= 0 and (among is None or parent in among):
                force, moment = (turned(at.turns[index], of[index]) for of in (forces, moments))
                forces[parent] = added(forces[parent], force)
                moment = added(moment, cross(at.levers[index], force))
                moments[parent] = added(moments[parent], moment)
        return Wrenches(forces, moments)

    def among(self, bodies: Iterable[int]) -> dict[int, tuple[Vector, Vector]]:
        """Return force and moment of some bodies."""
        return {body: (self.forces[body], self.moments[body]) for body in bodies}

    def and_also(self, other: Wrenches) -> Wrenches:
        """Return the sum of these and others."""
        pairs = zip(self, other, strict=True)
        return Wrenches(*(list(map(added, mine, theirs)) for mine, theirs in pairs))

    def along(self, tree: Tree, rates: Collection[int]) -> dict[int, Scalar]:
        """Return what acts along velocity coordinates."""
        result: dict[int, Scalar] = {}
        for index, body in enumerate(tree.bodies):
            vectors = self.forces if body.kind == "prismatic" else self.moments
            for rate, direction in zip(body.rates, body.directions, strict=True):
                if rate in rates:
                    result[rate] = dot(direction, vectors[index])
        return result


def momentum_rates(tree: Tree, motion: Motion, factors: Mapping[str, Scalar]) -> Wrenches:
    """Return what moves each body by itself (Featherstone 2008, chapter 2).

    Args:
        tree: the bodies.
        motion: with weight as an acceleration of the world.
        factors: link to the factor on its mass and inertia.
    """
    result = Wrenches.none(tree)
    for share in shares(tree, motion, factors):
        force, index = share.force, share.body
        moment = added(cross(share.lever, force), share.moment)
        result.forces[index] = added(result.forces[index], force)
        result.moments[index] = added(result.moments[index], moment)
    return result


class Share(NamedTuple):
    """How a mass that a body carries moves, and what moves it, in the body's axes.

    Attributes:
        body: index.
        lever: from the body's frame to the centre of mass.
        acceleration, force: of the centre.
        spin_rate, moment: about it.
    """

    body: int
    lever: Vector
    acceleration: Vector
    force: Vector
    spin_rate: Vector
    moment: Vector


def shares(tree: Tree, motion: Motion, factors: Mapping[str, Scalar]) -> list[Share]:
    """Return how masses move: forces m a, moments J ω̇ + ω × J ω; see `momentum_rates`."""
    result = []
    for index, body in enumerate(tree.bodies):
        for mass in body.masses:
            factor = factors[mass.link] - 1.0 if mass.link else 1.0
            acceleration = motion.at(index, mass.centre)
            spin, rate = motion.spins[index], motion.spin_rates[index]
            moment = added(turned(mass.inertia, rate), cross(spin, turned(mass.inertia, spin)))
            result.append(
                Share(
                    index,
                    mass.centre,
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


Wrench: TypeAlias = tuple[Vector, Vector]
"""Force and moment."""


class Compliance(NamedTuple):
    """How a joint gives way.

    Attributes:
        wrench: index of its wrench.
        first: body of its first part, whose frame at zero it is told in; -1 for a `fixed` loop,
            whose frame is that of its wrench.
        matrix: `(6, 6)` rows, of force and moment in the units of the tree.
    """

    wrench: int
    first: int
    matrix: tuple[tuple[float, ...], ...]


class Closed(NamedTuple):
    """Wrenches that closure forces exert. What is missing vanishes.

    Attributes:
        wrenches: body to the wrench of its joint, about and in the axes of its frame.
        exchanged: loop to force and moment of the predecessor on the successor about the weld, in
            the tree's axes.
        couplings: to their moments at their successors' joints.
    """

    wrenches: dict[int, Wrench]
    exchanged: dict[int, Wrench]
    couplings: dict[int, Scalar]

    @staticmethod
    def of(
        tree: Tree, at: Placed, multipliers: Mapping[int, Scalar], carried: Wrenches | None = None
    ) -> Closed:
        """Return what multipliers of the closure rows exert, by their rows; others do nothing.

        Args:
            tree: the mechanism.
            at: where it is.
            multipliers: these.
            carried: what moves each body by itself, to be carried besides.
        """
        couplings = 6 * len(tree.loops)
        held = Wrenches(*map(list, carried)) if carried else Wrenches.none(tree)
        exchanged: dict[int, Wrench] = {}
        moments: dict[int, Scalar] = {}
        loaded = set(range(len(tree.bodies))) if carried else set[int]()
        for row in sorted(multipliers):
            index = row // 6
            if couplings <= row < couplings + len(tree.couplings):
                moments[row - couplings] = -multipliers[row]
            elif row < couplings and index not in exchanged:
                loop = tree.loops[index]
                loaded |= tree.around(loop)
                six = [multipliers.get(6 * index + k, 0.0) for k in range(6)]
                force, moment = tuple(six[:3]), tuple(six[3:])
                for end, sign in ((loop.predecessor, 1.0), (loop.successor, -1.0)):
                    pair = (at.in_body(end.body, times(of, sign)) for of in (force, moment))
                    held.against(Push(end.body, end.translation, *pair))
                exchanged[index] = times(force, -1.0), times(moment, -1.0)
        return Closed(held.passed_on(tree, at, loaded).among(loaded), exchanged, moments)

    def with_added(self, factor: Scalar, other: Closed) -> Closed:
        """Return the sum of these and others times a factor."""
        result = Closed(*map(dict, self))
        for own, theirs in zip(result[:2], other[:2], strict=True):
            for index, (force, moment) in theirs.items():
                mine = own.get(index, (ZERO, ZERO))
                own[index] = (
                    added(mine[0], times(force, factor)),
                    added(mine[1], times(moment, factor)),
                )
        for index, moment in other.couplings.items():
            mine = result.couplings.get(index, 0.0)
            result.couplings[index] = mine + moment * factor
        return result

    def exerted(
        self, tree: Tree, at: Placed, loads: Mapping[int, Scalar], rates: Collection[int]
    ) -> dict[int, Scalar]:
        """Return what acts along velocity coordinates beside loads and couplings.

        Args:
            tree: the mechanism.
            at: where it is.
            loads: velocity coordinate to the effort added there.
            rates: these coordinates.
        """
        every = [self.wrenches[index] for index in range(len(tree.bodies))]
        forces, moments = ([pair[k] for pair in every] for k in range(2))
        result = Wrenches(forces, moments).along(tree, rates)
        for rate, effort in result.items():
            result[rate] = effort - loads.get(rate, 0.0)
        for index, moment in self.couplings.items():
            coupling = tree.couplings[index]
            for rate in coupling.successors:
                if rate in result:
                    result[rate] = result[rate] - moment
            for rate in coupling.predecessors:
                if rate in result:
                    result[rate] = result[rate] + closure.slope(coupling, at) * moment
        return result

    def counted(
        self, tree: Tree, at: Placed, wrench: int
    ) -> tuple[Rotation, Vector, Vector] | None:
        """Return the wrench of an index, and the axes that it is seen in; None if it vanishes.

        Axes are told in those of the wrench.
        """
        if wrench in self.wrenches:
            return UNTURNED, *self.wrenches[wrench]
        if wrench < len(tree.bodies):
            return None
        for index, pair in self.exchanged.items():
            if tree.loops[index].wrench == wrench:
                return at.end(tree.loops[index].successor)[0], *pair
        return None


class Statics(NamedTuple):
    """What closes the equations of statics.

    Attributes:
        passives: velocity coordinates along which loads and couplings alone may act.
        counted: indices of the wrenches that the norm counts: of bodies, then of `fixed` loops.
        balanced: closure rows whose forces are wanted; the others exert none.
        compliances: of joints whose elastic energy decides before the norm does.
    """

    passives: Sequence[int]
    counted: Collection[int]
    balanced: Collection[int]
    compliances: Sequence[Compliance] = ()


def closed(
    tree: Tree,
    at: Placed,
    factors: Eliminated,
    carried: Wrenches,
    loads: Mapping[int, Scalar],
    statics: Statics,
) -> Closed:
    """Return the wrenches of the closed chain; what statics leaves open has the least norm.

    Args:
        tree: the mechanism.
        at: where it is.
        factors: of its closure rows for the passive coordinates.
        carried: what moves each body by itself.
        loads: velocity coordinate to the effort added there.
        statics: see there.

    Raises:
        UnsuitableError: compliances decide more at some samples than at others.
    """

    def exerting(multipliers: Mapping[int, Scalar]) -> Closed:
        balanced = {row: value for row, value in multipliers.items() if row in statics.balanced}
        return Closed.of(tree, at, balanced, carried)

    base = factors.balanced(exerting, lambda of: of.exerted(tree, at, loads, statics.passives))
    stresses = SelfStresses.of(tree, at, factors, statics)
    items = stresses.items
    if items and statics.compliances:
        base, items = _of_least_energy(tree, at, factors, base, items, statics.compliances)
    if items:
        of_items = [_entries(tree, at, item, statics.counted) for item in items]
        own = _entries(tree, at, base, statics.counted)
        base = _least(factors, base, items, of_items, own)
    of_trains = [_moments(tree, train) for train in stresses.trains]
    return _least(factors, base, stresses.trains, of_trains, _moments(tree, base))


def _least(
    factors: Eliminated,
    base: Closed,
    items: Sequence[Closed],
    entries: Sequence[Mapping[int, Scalar]],
    own: Mapping[int, Scalar],
) -> Closed:
    """Return the sum of something and of what it may differ by whose entries are least.

    Args:
        factors: see `closed`.
        base: that.
        items: what it may differ by.
        entries: of these.
        own: of that.
    """
    right = [-product(of, own) for of in entries]
    amounts = _factors(_products(entries)).solve(right)
    for column, amount in factors.chosen(amounts).items():
        base = base.with_added(amount, items[column])
    return base


def _of_least_energy(
    tree: Tree,
    at: Placed,
    factors: Eliminated,
    base: Closed,
    items: Sequence[Closed],
    compliances: Sequence[Compliance],
) -> tuple[Closed, list[Closed]]:
    """Return what stores the least elastic energy ½ Σ fᵀ C f, and what changes none of it.

    The energy's matrix is eliminated from the items on that it decides, the strongest first; what
    is left of the others stores nothing.

    Raises:
        UnsuitableError: it decides more at some samples than at others.
    """

    def told(of: Closed) -> tuple[dict[int, Scalar], dict[int, Scalar]]:
        """Return wrenches by six times their index plus the component, and displacements."""
        forces: dict[int, Scalar] = {}
        ways: dict[int, Scalar] = {}
        for wrench, first, matrix in compliances:
            found = of.counted(tree, at, wrench)
            if found is None:
                continue
            rotation, *pair = found
            if first >= 0:
                rotation = at.at_zero(tree, first)
                pair = [at.in_tree(wrench, vector) for vector in pair]
            own = [value for vector in pair for value in seen(rotation, vector)]
            for component, row in enumerate(matrix):
                forces[6 * wrench + component] = own[component]
                ways[6 * wrench + component] = sum(
                    (entry * value for entry, value in zip(row, own, strict=True)), 0.0
                )
        return forces, ways

    every = [told(item) for item in items]
    forces, own = [of for of, _ in every], told(base)[1]
    energy = [
        {
            column: value
            for column, (_, way) in enumerate(every)
            if not is_zero(value := product(of, way))
        }
        for of in forces
    ]
    bounds = [_bound(tree, at, item, compliances) for item in items]
    decided = _decided_by(energy, bounds)
    left = [index for index in range(len(items)) if index not in decided]
    within = [{c: row[c] for c in decided if c in row} for row in energy]
    of_decided = eliminated(
        [within[row] for row in decided],
        Order([Pivot(place, column, 1.0) for place, column in enumerate(decided)]),
    )
    amounts = of_decided.solve([-product(forces[row], own) for row in decided])
    for column, amount in factors.chosen(amounts).items():
        base = base.with_added(amount, items[column])
    silent = []
    for index in left:
        item = items[index]
        right = [-energy[row].get(index, 0.0) for row in decided]
        for column, amount in factors.chosen(of_decided.solve(right)).items():
            item = item.with_added(amount, items[column])
        silent.append(item)
    return base, silent


def _bound(tree: Tree, at: Placed, item: Closed, compliances: Sequence[Compliance]) -> Scalar:
    """Return the energy of a self-stress if all its forces were along the most compliant ways.

    It exerts one unit along the closure row that it belongs to, so that what it leaves of a
    compliant joint's wrench is compared with that: it may be rounding alone.
    """
    result: Scalar = 0.0
    lengths = np.repeat([tree.norm_length, 1.0], 3)
    for wrench, _, matrix in compliances:
        found = item.counted(tree, at, wrench)
        if found is not None:
            _, force, moment = found
            size = float(np.linalg.norm(np.array(matrix) / np.outer(lengths, lengths)))
            scaled = times(force, tree.norm_length)
            result = result + size * (1.0 + dot(scaled, scaled) + dot(moment, moment))
    return result


def _decided_by(energy: Sequence[Row], bounds: Sequence[Scalar]) -> list[int]:
    """Return which items the energy decides, in the order of elimination.

    Raises:
        UnsuitableError: their number differs between samples.
    """
    size = len(energy)
    values = [*(entry for row in energy for entry in row.values()), *bounds]
    samples = max((np.size(_seen(value)) for value in values), default=1)
    matrix = np.zeros((samples, size, size))
    for index, row in enumerate(energy):
        for column, entry in row.items():
            matrix[:, index, column] = _seen(entry)
    greatest = sum(np.broadcast_to(_seen(bound), samples) for bound in bounds)
    own = np.linalg.eigvalsh(matrix)
    # Smaller eigenvalues would choose forces by the rounding of closure equations. Energies grow
    # with the square of forces: along the most compliant ways these would store `greatest`.
    least = np.maximum(NOTHING * np.abs(own).max(axis=1), NOTHING**2 * greatest)
    ranks = np.sum(own > least[:, None], axis=1)
    if np.any(ranks != ranks[0]):
        raise UnsuitableError
    order: list[int] = []
    for _ in range(int(ranks[0])):
        strengths = matrix.diagonal(axis1=1, axis2=2).copy()
        strengths[:, order] = 0.0
        strengths /= strengths.max(axis=1, keepdims=True)
        pivot = int(strengths.min(axis=0).argmax())
        order.append(pivot)
        taken = matrix[:, pivot] / matrix[:, pivot, pivot, None]
        matrix = matrix - matrix[:, :, pivot, None] * taken[:, None]
    return order


class SelfStresses(NamedTuple):
    """Independent self-stresses of a closed chain: wrenches that balance each other.

    Attributes:
        items: the wrenches of each.
        entries: of each, the components that a norm counts, see `_entries`.
        trains: those that load no joint: moments of closed trains of couplings.
    """

    items: list[Closed]
    entries: list[dict[int, Scalar]]
    trains: list[Closed]

    @staticmethod
    def of(tree: Tree, at: Placed, factors: Eliminated, statics: Statics) -> SelfStresses:
        """Return those of redundant closure rows; arguments and errors as of `closed`."""
        every = [
            Closed.of(tree, at, factors.dependence(row))
            for row in factors.redundant
            if row in statics.balanced
        ]
        loading = [(item, _entries(tree, at, item, statics.counted)) for item in every]
        return SelfStresses(
            [item for item, own in loading if own],
            [own for _, own in loading if own],
            [item for item, own in loading if not own],
        )

    def influence(
        self, tree: Tree, at: Placed, counted: Collection[int]
    ) -> tuple[dict[int, list[Scalar]], dict[int, Scalar]]:
        """Return how much of a self-stress of unit norm each component can be, squared.

        With w the component in each self-stress and N the matrix of their products: wᵀ N⁻¹ w.

        Returns:
            Wrench to its six components in its joint's frame, forces times the length; and the
            same of each coupling's moment. What is zero or missing follows from the laws of motion.
        """
        # Once for each self-stress: components are many more.
        normal, count = _factors(_products(self.entries)), len(self.items)
        units = ([float(row == column) for row in range(count)] for column in range(count))
        inverse = [normal.solve(unit) for unit in units]

        def share(parts: Mapping[int, Scalar]) -> Scalar:
            """Return the influence of what has these parts in the self-stresses."""
            if not parts:
                return 0.0
            return sum(
                (
                    part * other * inverse[column][row]
                    for column, part in parts.items()
                    for row, other in parts.items()
                ),
                0.0,
            )

        rows: dict[int, dict[int, list[Scalar]]] = {}
        moments: dict[int, dict[int, Scalar]] = {}
        for index, item in enumerate(self.items):
            for wrench in counted:
                found = item.counted(tree, at, wrench)
                if found is not None:
                    rotation, force, moment = found
                    own = *times(seen(rotation, force), tree.norm_length), *seen(rotation, moment)
                    rows.setdefault(wrench, {})[index] = [*own]
            for coupling, moment in item.couplings.items():
                moments.setdefault(coupling, {})[index] = moment
        wrenches = {
            wrench: [
                share({index: values[k] for index, values in own.items() if not is_zero(values[k])})
                for k in range(6)
            ]
            for wrench, own in rows.items()
        }
        couplings = {coupling: share(own) for coupling, own in moments.items()}
        for train in self.trains:
            total = sum((moment * moment for moment in train.couplings.values()), 0.0)
            for coupling, moment in train.couplings.items():
                own = couplings.get(coupling, 0.0)
                couplings[coupling] = own + moment * moment / total
        return wrenches, couplings


def self_stress(tree: Tree, at: Placed, factors: Eliminated, statics: Statics) -> Closed:
    """Return a self-stress of size one in which all those of redundant closure rows take part.

    Arguments as of `closed`. It vanishes where none of them loads anything that counts.
    """
    rows = [row for row in factors.redundant if row in statics.balanced]
    amounts = generic(len(rows), 1)[:, 0].tolist()
    stress = Closed.of(tree, at, combined([factors.dependence(row) for row in rows], amounts))
    entries = _entries(tree, at, stress, statics.counted), _moments(tree, stress)
    none = Closed(dict.fromkeys(range(len(tree.bodies)), (ZERO, ZERO)), {}, {})
    if not any(entries):
        return none
    return none.with_added(1.0 / sqrt(sum((product(own, own) for own in entries), 0.0)), stress)


def _entries(tree: Tree, at: Placed, of: Closed, counted: Collection[int]) -> dict[int, Scalar]:
    """Return the components that a norm counts and that do not vanish everywhere.

    By six times the wrench's index plus the component; forces times the length.
    """
    result: dict[int, Scalar] = {}
    every = {**of.wrenches, **{tree.loops[k].wrench: pair for k, pair in of.exchanged.items()}}
    for index, (force, moment) in every.items():
        if index in counted:
            for component, value in enumerate((*times(force, tree.norm_length), *moment)):
                if not is_zero(value):
                    result[6 * index + component] = value
    return result


def _moments(tree: Tree, of: Closed) -> dict[int, Scalar]:
    """Return the moments of couplings, forces of slides times the length."""
    slide_rates = {b.rates[0] for b in tree.bodies if b.kind == "prismatic"}
    return {
        index: moment * tree.norm_length
        if slide_rates.intersection(tree.couplings[index].successors)
        else moment
        for index, moment in of.couplings.items()
        if not is_zero(moment)
    }


def _products(entries: Sequence[Mapping[int, Scalar]]) -> list[Row]:
    """Return the matrix of products of several entries, of those that have some in common."""
    owners: dict[int, list[int]] = {}
    for index, own in enumerate(entries):
        for key in own:
            owners.setdefault(key, []).append(index)
    connected: list[set[int]] = [set() for _ in entries]
    for of_key in owners.values():
        for index in of_key:
            connected[index].update(of_key)
    return [
        {other: product(entries[index], entries[other]) for other in sorted(others)}
        for index, others in enumerate(connected)
    ]


def _factors(normal: Sequence[Row]) -> Eliminated:
    """Return the factors of a matrix of products, which any order of its diagonal makes stably."""
    return eliminated(normal, Order([Pivot(row, row, 1.0) for row in range(len(normal))]))


def _seen(entry: Scalar) -> Scalar:
    """Return a scalar's values at the samples at which orders are chosen."""
    return getattr(entry, "shadow", entry)
