"""Sample: all that is computed at one position of a scene, from a guess near it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...kit.arrays import Array
from ..tape import absolute, greater, is_zero
from . import closure, spinning, spins, teeth
from .bodies import Tree
from .elimination import (
    Eliminated,
    Order,
    Row,
    UnsuitableError,
    chosen_at_each,
    combined,
    eliminated,
    product,
)
from .placements import Placed, moving, placed, stepped
from .reactions import (
    Closed,
    Compliance,
    Push,
    SelfStresses,
    Statics,
    Wrench,
    Wrenches,
    closed,
    missing,
    momentum_rates,
    self_stress,
)
from .vectors import ZERO, Scalar, Vector, seen, times, turned


class Block(NamedTuple):
    """Closure rows, and the coordinates that they decide.

    Attributes:
        rows: their indices.
        passives: velocity coordinates.
        is_balanced: whether its forces are wanted.
    """

    rows: tuple[int, ...]
    passives: tuple[int, ...]
    is_balanced: bool


class Roles(NamedTuple):
    """What coordinates are in a scene, by velocity coordinates.

    Attributes:
        drives: prescribed, with rates.
        held: prescribed, at rest.
        blocks: of what loops decide, each after those that it depends on.
        counted: wrenches that the norm of indeterminate forces counts, see `Statics`.
        efforts_alone: whether of all forces the efforts of drives are wanted alone.
        compliances: of joints whose elastic energy decides what is indeterminate.
    """

    drives: tuple[int, ...]
    held: tuple[int, ...]
    blocks: tuple[Block, ...]
    counted: tuple[int, ...]
    efforts_alone: bool = False
    compliances: tuple[Compliance, ...] = ()

    @property
    def passives(self) -> tuple[int, ...]:
        """Velocity coordinates that loops decide."""
        return tuple(rate for block in self.blocks for rate in block.passives)

    @property
    def statics(self) -> Statics:
        """What closes the equations of statics."""
        balanced = {row for block in self.blocks if block.is_balanced for row in block.rows}
        return Statics(self.passives, self.counted, balanced, self.compliances)

    def columns(self, tree: Tree) -> list[int]:
        """Return the columns of the coordinates that loops decide."""
        passives = set(self.passives)
        moved = [body for body in tree.bodies if passives.issuperset(body.rates)]
        return [column for body in moved for column in body.columns]

    def orders(self, tree: Tree, x: Array, nothing: float) -> list[tuple[Order, Array]]:
        """Return orders of elimination and the samples (index) that they are chosen at, each alone.

        Args:
            tree: the mechanism.
            x: coordinates `(size, n)`.
            nothing: pivot that counts as none.

        Raises:
            UnsuitableError: there is none at a sample.
        """
        blocks = [block[:2] for block in self.blocks]
        # Ways around loops may divide what paths along the tree do not.
        together = [([row for rows, _ in blocks for row in rows], self.passives)]
        found: list[tuple[Order, Array]] = []
        left = np.arange(x.shape[1])
        for of in blocks, together:
            rows = closure.rows(tree, placed(tree, dict(enumerate(x[:, left]))), set(self.passives))
            every = [{c: np.broadcast_to(v, len(left)) for c, v in row.items()} for row in rows]
            orders, without = chosen_at_each(every, of, nothing)
            found += [(order, left[own]) for order, own in orders]
            left = left[without]
            if not len(left):
                return found
        raise UnsuitableError


class LinkForce(NamedTuple):
    """A wrench on a link, in the link's axes or in those of the tree.

    Attributes:
        body: index; -1 for the world.
        rotation: of the link's axes in the body; None where the wrench is in the tree's axes.
        lever: from the body's frame to the point, in the body's axes.
        force, moment: about the point.
    """

    body: int
    rotation: Sequence[Vector] | None
    lever: Vector
    force: Vector
    moment: Vector

    def push(self, at: Placed) -> Push:
        """Return it in the body's axes."""
        force, moment = (
            at.in_body(self.body, vector)
            if self.rotation is None
            else turned(self.rotation, vector)
            for vector in (self.force, self.moment)
        )
        return Push(self.body, self.lever, force, moment)


class Given(NamedTuple):
    """What is prescribed at a sample, in the units of a tree.

    Attributes:
        x: column to coordinate; those of passives are near closed ones.
        speeds, accelerations: of the drives.
        gravity: acceleration of free fall.
        loads: velocity coordinate to the effort added there.
        link_forces: wrenches on links.
        factors: link to the factor on its mass and inertia.
        offsets: of the couplings.
    """

    x: Mapping[int, Scalar]
    speeds: Sequence[Scalar]
    accelerations: Sequence[Scalar]
    gravity: Vector
    loads: Mapping[int, Scalar]
    link_forces: Sequence[LinkForce]
    factors: Mapping[str, Scalar]
    offsets: Sequence[Scalar]


class Position(NamedTuple):
    """A sample near its closed position.

    Attributes:
        x: its coordinates.
        at: where its bodies are.
        errors: of the closure rows.
        error: the greatest of those of loops and couplings.
        turned: the greatest of those of rods.
        rows: closure rows of all moving coordinates.
        factors: of those of the passive ones.
    """

    x: Mapping[int, Scalar]
    at: Placed
    errors: list[Scalar]
    error: Scalar
    turned: Scalar
    rows: list[Row]
    factors: Eliminated

    @staticmethod
    def of(
        tree: Tree,
        roles: Roles,
        x: Mapping[int, Scalar],
        offsets: Sequence[Scalar],
        order: Order,
        settles: bool = True,
    ) -> Position:
        """Return a position at coordinates that may be off.

        Unless it settles, rods are left as they are turned.
        """
        at = placed(tree, x)
        errors, error = closure.errors(tree, at, offsets)
        angles = [spins.turned(at, spin) if settles else 0.0 for spin in tree.spins]
        turned: Scalar = 0.0
        for angle in angles:
            turned = greater(turned, absolute(angle))
        rows = closure.rows(tree, at, {*roles.drives, *roles.passives})
        factors = eliminated(passive_rows(rows, roles), order)
        return Position(x, at, errors + angles, error, turned, rows, factors)

    def corrected(self, tree: Tree, roles: Roles) -> tuple[dict[int, Scalar], Scalar]:
        """Return the coordinates after a step of Newton's method, and its greatest part.

        How far rods turn back says nothing of how far off the coordinates are.
        """
        result, longest = dict(self.x), 0.0
        left = [-error for error in self.errors]
        count = len(left) - len(tree.spins)
        step = self.factors.solve([*left[:count], *[0.0] * len(tree.spins)])
        for value in step.values():
            longest = greater(longest, absolute(value))
        if tree.spins:
            back = self.factors.solve([*[0.0] * count, *left[count:]])
            step = {rate: value + back[rate] for rate, value in step.items()}
        passives = set(roles.passives)
        for body in tree.bodies:
            if passives.issuperset(body.rates):
                result.update(stepped(body, self.x, step))
        return result, longest

    def velocities(self, speeds: Mapping[int, Scalar]) -> dict[int, Scalar]:
        """Return velocities of all that moves at speeds of drives, by velocity coordinates."""
        return {**speeds, **self.factors.solve([-value for value in self._changes(speeds)])}

    def ratios(self, roles: Roles) -> list[dict[int, Scalar]]:
        """Return velocities where each drive moves alone, at unit speed."""
        return [self.velocities({drive: 1.0}) for drive in roles.drives]

    def accelerations(
        self, tree: Tree, v: Mapping[int, Scalar], known: Mapping[int, Scalar]
    ) -> dict[int, Scalar]:
        """Return accelerations of all that moves, by velocity coordinates.

        Args:
            tree: the mechanism.
            v: velocities.
            known: accelerations of drives.
        """
        # The accelerations of the rows without those of the passives, which make up for them.
        drifting = moving(tree, self.at, v, known, ZERO)
        drifts = closure.drifts(tree, self.at, drifting)
        loops = len(drifts)
        changes = self._changes(known)[loops : loops + len(tree.couplings)]
        bends = closure.bends(tree, self.at, v)
        drifts += [change + bend for change, bend in zip(changes, bends, strict=True)]
        drifts += [spins.drift(self.at, drifting, spin) for spin in tree.spins]
        return {**known, **self.factors.solve([-drift for drift in drifts])}

    def _changes(self, rates: Mapping[int, Scalar]) -> list[Scalar]:
        """Return how fast the rows' errors grow at rates of some velocity coordinates."""
        return [product(rates, row) for row in self.rows]


def passive_rows(rows: Sequence[Row], roles: Roles) -> list[Row]:
    """Return rows as far as passive coordinates go."""
    passives = set(roles.passives)
    return [{rate: entry for rate, entry in row.items() if rate in passives} for row in rows]


class Solved(NamedTuple):
    """What is found at a sample, in the units of the tree.

    Attributes:
        x: closed coordinates.
        ratios: per drive, velocity coordinate to its rate where that drive alone moves at unit
            speed.
        v, a: velocity coordinate to velocity and acceleration.
        wrenches: body to force and moment on it, in its frame.
        fixed: likewise of `fixed` loops, by the index of their wrench.
        exerted: prescribed velocity coordinate to what acts there beside loads and couplings.
        couplings: to moments at their successors' joints; those that are missing exert none.
        rests: couplings that teeth keep, to what is left of their moments beside the teeth.
        unheld: per rod, see `Spun`.
        step: greatest part of the last step of Newton's method.
        error, turned: greatest errors of the closure rows, see `Position`.
        growth, narrowness: see `Eliminated`.
    """

    x: Mapping[int, Scalar]
    ratios: list[dict[int, Scalar]]
    v: dict[int, Scalar]
    a: dict[int, Scalar]
    wrenches: dict[int, tuple[Vector, Vector]]
    fixed: dict[int, tuple[Vector, Vector]]
    exerted: dict[int, Scalar]
    couplings: dict[int, Scalar]
    rests: dict[int, Scalar]
    unheld: list[Scalar]
    step: Scalar
    error: Scalar
    turned: Scalar
    growth: Scalar
    narrowness: Scalar

    @staticmethod
    def moving(
        position: Position,
        ratios: list[dict[int, Scalar]],
        v: dict[int, Scalar],
        a: dict[int, Scalar],
    ) -> Solved:
        """Return what moves at a position, without forces."""
        return Solved(
            position.x,
            ratios,
            v,
            a,
            wrenches={},
            fixed={},
            exerted={},
            couplings={},
            rests={},
            unheld=[],
            step=0.0,
            error=position.error,
            turned=position.turned,
            growth=position.factors.growth,
            narrowness=position.factors.narrowness,
        )


def solved(
    tree: Tree,
    roles: Roles,
    given: Given,
    order: Order,
    is_closed: bool = False,
    moves_alone: bool = False,
) -> Solved:
    """Return all that is found at a sample.

    Args:
        tree: the mechanism.
        roles: of its coordinates.
        given: what is prescribed.
        order: of the elimination.
        is_closed: whether coordinates are closed already, so that no step is made.
        moves_alone: whether the motion is wanted without ratios and forces, nor with accelerations
            of rods that spin idly, which depend on these.

    Raises:
        UnsuitableError: see `reactions.closed`.
    """
    guess = Position.of(tree, roles, given.x, given.offsets, order)
    if is_closed:
        return solved_at(guess, tree, roles, given, moves_alone)
    x, step = guess.corrected(tree, roles)
    position = Position.of(tree, roles, x, given.offsets, order)
    found = solved_at(position, tree, roles, given, moves_alone)
    return found._replace(step=step, growth=greater(guess.factors.growth, found.growth))


def solved_at(
    position: Position,
    tree: Tree,
    roles: Roles,
    given: Given,
    moves_alone: bool = False,
    has_ratios: bool = True,
) -> Solved:
    """Return all that is found at a closed position; arguments and errors as of `solved`.

    Ratios may be left out, unless efforts alone are wanted, which follow from them.
    """
    at, factors = position.at, position.factors
    if moves_alone or not (has_ratios or roles.efforts_alone):
        # Many drives have one velocity together, and a ratio each.
        ratios: list[dict[int, Scalar]] = [{} for _ in roles.drives]
        v = position.velocities(dict(zip(roles.drives, given.speeds, strict=True)))
    else:
        ratios = position.ratios(roles)
        v = combined(ratios, given.speeds)
    known = {
        rate: value
        for rate, value in zip(roles.drives, given.accelerations, strict=True)
        if not is_zero(value)
    }
    a = dict(known)
    if any(not is_zero(value) for value in v.values()) or known:
        a = position.accelerations(tree, v, known)
    found = Solved.moving(position, ratios, v, a)
    if moves_alone:
        return found
    motion = moving(tree, at, v, a, times(given.gravity, -1.0))
    carried = momentum_rates(tree, motion, given.factors)
    for link_force in given.link_forces:
        carried.against(link_force.push(at))
    loads = tree.beside_rotors(given.loads, a)
    if tree.spins:
        open_tree = carried.passed_on(tree, at)
        added, more, unheld = spinning.spun(tree, at, factors, open_tree, loads, given.factors)
        loads = tree.beside_rotors(loads, added)
        a = {rate: a.get(rate, 0.0) + added.get(rate, 0.0) for rate in {**a, **added}}
        carried = carried.and_also(more)
        found = found._replace(a=a, unheld=unheld)
    if roles.efforts_alone:
        open_tree = carried.passed_on(tree, at)
        efforts = _by_virtual_work(tree, roles, ratios, open_tree, loads)
        return found._replace(exerted=efforts)
    result = closed(tree, at, factors, carried, loads, roles.statics)
    moments, rests = dict(result.couplings), {}
    if tree.gears:
        carried = carried.and_also(teeth.pushes(tree, at, position.x, moments))
        result = closed(tree, at, factors, carried, loads, roles.statics)
        rests = {gear.coupling: result.couplings.get(gear.coupling, 0.0) for gear in tree.gears}
        borne = {coupling: moments.get(coupling, 0.0) for coupling in rests}
        moments = dict(result.couplings)
        for coupling, moment in borne.items():
            moments[coupling] = moments.get(coupling, 0.0) + moment
    efforts = result.exerted(tree, at, loads, {*roles.drives, *roles.held})
    wrenches, fixed = result.wrenches, _fixed(tree, at, result)
    return found._replace(
        wrenches=wrenches, fixed=fixed, exerted=efforts, couplings=moments, rests=rests
    )


def stressed_at(position: Position, tree: Tree, roles: Roles) -> Solved:
    """Return a self-stress in place of what is found at a closed position, see `self_stress`.

    Nothing moves, and of couplings with teeth it has their moments alone.
    """
    at, factors = position.at, position.factors
    stress = self_stress(tree, at, factors, roles.statics)
    efforts = stress.exerted(tree, at, {}, {*roles.drives, *roles.held})
    wrenches, fixed = stress.wrenches, _fixed(tree, at, stress)
    still = Solved.moving(position, [{} for _ in roles.drives], {}, {})
    return still._replace(
        wrenches=wrenches, fixed=fixed, exerted=efforts, couplings=stress.couplings
    )


def openings(
    tree: Tree, roles: Roles, given: Given, order: Order
) -> tuple[dict[int, list[Scalar]], dict[int, Scalar]]:
    """Return what statics leaves open at a closed sample, see `SelfStresses.influence`.

    Arguments and errors as of `solved`.
    """
    position = Position.of(tree, roles, given.x, given.offsets, order)
    stresses = SelfStresses.of(tree, position.at, position.factors, roles.statics)
    return stresses.influence(tree, position.at, roles.counted)


def _fixed(tree: Tree, at: Placed, of: Closed) -> dict[int, Wrench]:
    """Return wrenches of `fixed` loops, see `Solved`."""
    result = {}
    for index, (force, moment) in of.exchanged.items():
        loop = tree.loops[index]
        if loop.wrench >= 0:
            rotation, _ = at.end(loop.successor)
            result[loop.wrench] = seen(rotation, force), seen(rotation, moment)
    return result


def _by_virtual_work(
    tree: Tree,
    roles: Roles,
    ratios: Sequence[Mapping[int, Scalar]],
    open_tree: Wrenches,
    loads: Mapping[int, Scalar],
) -> dict[int, Scalar]:
    """Return what drives exert: closure forces do no work (principle of virtual work)."""
    needed = missing(open_tree.along(tree, range(len(tree.units))), loads, range(len(tree.units)))
    return {drive: product(own, needed) for drive, own in zip(roles.drives, ratios, strict=True)}
