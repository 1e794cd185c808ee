"""Taped: samples solved by tapes of a scene's equations, each of which judges itself.

A tape has an order of elimination that was chosen at some closed configurations of the motion. At
any other one it serves where the elimination does not grow, Newton's last step leaves rounding, and
the loops are closed. Samples that fail are solved by a second tape, whose order was chosen where
the first one does not serve. Of those that no tape serves for, the loops are closed by all that is
known of the motion, which says where they cannot be; tapes are asked again there, and at last the
same equations are solved with an order that is chosen at the sample itself.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from copy import copy
from functools import cached_property, partial

import numpy as np

from ...kit.arrays import Array, some
from ...kit.errors import (
    AssemblyError,
    MobilityError,
    ModelError,
    SingularConfigurationError,
    choices,
)
from ...kit.threads import in_turn
from ..elements.link_loads import LinkLoad
from ..kinematics.assembly import Assembly
from ..kinematics.closing.all_groups import ClosedState
from ..kinematics.following.orders import Orders
from ..kinematics.loops.closure_blocks import closure_blocks, with_rods
from ..kinematics.loops.groups import Group
from ..kinematics.tolerances import SINGULAR_CONDITION
from ..mechanics.bodies import Tree, tree_of
from ..mechanics.elimination import Order, UnsuitableError
from ..mechanics.reactions import Compliance
from ..mechanics.sample import Roles
from ..mechanics.teeth import gears_of
from ..mechanism.mechanism import Mechanism
from ..problem.problem import Problem
from .inverse_dynamics import UNIQUE_TOLERANCE, Inputs, InverseDynamics, JointRates, Solution
from .tape import SAMPLES, Equations, Found, Kind, LinkKind, Prescribed, Tape
from .velocity_ratios import VelocityRatios

MOST_TAPES = 3
"""Orders that are tried at samples of one kind."""
_MOST_OWN = 64
"""Tapes of orders chosen at samples that are kept: designs of a line of three joints have 49."""
_MOST_STEPS = 3
"""Further Newton steps of a guess; each squares what is left."""


class TapedSolver:
    """Solves samples of a problem by tapes, which are made when a kind of samples is first met."""

    def __init__(
        self,
        problem: Problem,
        varied: Sequence[str],
        groups: Sequence[tuple[Group, bool]],
        wrenches: Sequence[int],
        assembly: Assembly,
        efforts_alone: bool = False,
    ) -> None:
        """Begin without tapes.

        Args:
            problem: of the scene.
            varied: names of the held joints that differ from sample to sample.
            groups: those that are solved, and whether their forces are, too.
            wrenches: indices of those that are wanted.
            assembly: at whose scouts orders of elimination are chosen.
            efforts_alone: whether of all forces the efforts of drives are wanted alone.
        """
        self.problem, self._mechanism = problem, problem.mechanism
        self._wrenches, self._assembly = wrenches, assembly
        mechanism, coordinates = problem.mechanism, problem.mechanism.coordinates
        self._groups = [group for group, _ in groups]
        self._varied = coordinates.columns_of(varied)
        self._solved = (
            [index for group in self._groups for index in group.loops],
            [index for group in self._groups for index in group.couplings],
            # What is left out is counted with the forces of others.
            {
                body
                for group, wanted in groups
                if wanted or efforts_alone
                for body in group.inertial_bodies
            },
        )
        spinning = {rate for group in self._groups for rod in group.idle for rate in rod.columns}
        self._idle: list[int] = []
        if spinning:  # Few mechanisms have rods that spin idly.
            idle = coordinates.columns_moved_by(np.array(sorted(spinning), dtype=int))
            self._idle = np.intersect1d(idle, coordinates.angle_columns).tolist()
        self._sizes = coordinates.size, mechanism.wrench_count, len(mechanism.couplings)
        self._trees: dict[tuple[str, ...], Tree] = {}
        self._roles = Roles(
            tuple(coordinates.rates_of(problem.independent)),
            tuple(coordinates.rates_of(problem.held)),
            closure_blocks(groups),
            tuple(sorted(mechanism.wrench_indices.values())),
            efforts_alone,
            self._compliances(),
        )
        self._tapes: dict[tuple[Kind, bytes], dict[int, Tape | None]] = {}
        self.key = (
            self._roles,
            tuple(self._varied),
            tuple(sorted(wrenches)),
            tuple(group.key for group in self._groups),
        )
        self._equations = mechanism.kept.of("equations", self.key, dict[Kind, Equations])

    def of(self, problem: Problem) -> TapedSolver:
        """Return that of a problem which differs in elements and what sweeps say anew."""
        result = copy(self)
        result.problem = problem
        return result

    def solution(
        self,
        dynamics: InverseDynamics,
        x: Array,
        inputs: Inputs,
        close: Callable[[Array], ClosedState],
    ) -> Solution:
        """Return what a sweep keeps of samples, and the residuals of all that is found.

        Args:
            dynamics: of the scene.
            x: `(n, size)` coordinates near closed ones, exact in the drives.
            inputs: what is prescribed.
            close: closes the loops of samples, by their indices, or says why it cannot.

        Raises:
            AssemblyError, SingularConfigurationError: see `Assembly.close`.
            MobilityError: a moment acts about the line of a rod that has no inertia about it.
            ModelError: a coupling without teeth shares the moment of some.
        """
        found, influence, loose = self.found(x, inputs, close)
        if self._tree(()).spins and found.a.any():
            inputs = inputs._replace(has_rates=True)
        count, drives = len(x), len(self._roles.drives)
        rates = JointRates(found.ratios.reshape(count, -1, drives), found.v, found.a)
        wrenches = found.wrenches.reshape(count, -1, 6)
        of_joints = wrenches, found.efforts, found.couplings
        claim = dynamics.claim(found.x, inputs, rates, *of_joints)
        residuals = dynamics.bodies.check(claim)
        return Solution(
            x=found.x,
            v=found.v,
            a=found.a,
            velocity_ratios=VelocityRatios.of(rates.velocity_ratios, dynamics.depends),
            wrenches=wrenches[:, self.problem.output_indices],
            efforts=found.efforts.take(self.problem.prescribed_columns, 1),
            coupling_moments=found.couplings,
            # A copy, since it is kept longer than all that it is a row of.
            closure_condition=found.condition.copy(),
            loop_error=np.maximum(found.error, residuals.loop_error),
            residuals=residuals,
            influence=influence,
            indeterminate_couplings=loose,
        )

    def moved(self, x: Array, inputs: Inputs, close: Callable[[Array], ClosedState]) -> Found:
        """Return what is found of the motion of samples alone; arguments as of `solution`."""
        with np.errstate(all="ignore"):  # What overflows is refused where it is kept.
            rows = np.ascontiguousarray(x.T)
            return self._found(rows, inputs, [], close, moves_alone=True)[0]

    def found(
        self,
        x: Array,
        inputs: Inputs,
        close: Callable[[Array], ClosedState],
        links: Sequence[LinkLoad] | None = None,
    ) -> tuple[Found, Array, set[int]]:
        """Return what is found of samples, and what statics leaves open, see `Solution`.

        Elements exert what follows of the motion alone.

        Args:
            x: `(n, size)` coordinates near closed ones, exact in the drives.
            inputs: what is prescribed.
            close: see `solution`, as well as for errors.
            links: wrenches on links in place of those of elements and inputs.
        """
        elements = self.problem.element_forces if links is None else None
        pushed = list(inputs.link_loads.values()) if links is None else links
        rows = np.ascontiguousarray(x.T)
        with np.errstate(all="ignore"):  # What overflows is refused where results are judged.
            if elements is not None:
                moved, _, _ = self._found(rows, inputs, [], close, moves_alone=True)
                turned = moved.x + 2.0 * np.pi * inputs.turns
                acted = elements.at(turned, moved.v, inputs.time)
                rows = np.ascontiguousarray(moved.x.T)
                inputs = inputs._replace(loads=inputs.loads + acted.efforts)
                pushed = [*pushed, *acted.link_loads(self._mechanism)]
            found, influence, loose = self._found(rows, inputs, pushed, close)
        for teeth in self._mechanism.teeth:
            if teeth.coupling in loose:
                influence = influence.copy()
                influence[[self._mechanism.wrench_indices[name] for name in teeth.joints]] = 1.0
        self._refuse_shared(found)
        if self._idle:
            found.x[:, self._idle] -= 2.0 * np.pi * np.rint(found.x[:, self._idle] / (2.0 * np.pi))
        return found, influence, loose

    def _refuse_shared(self, found: Found) -> None:
        """Refuse couplings that have teeth, and share their moment with others.

        Raises:
            ModelError: there is one.
        """
        for teeth in self._mechanism.teeth:
            rest = np.abs(found.rests[:, teeth.coupling]).max()
            if rest > UNIQUE_TOLERANCE * np.abs(found.couplings[:, teeth.coupling]).max():
                raise ModelError(
                    f"{self._mechanism.couplings[teeth.coupling].name} has teeth, and shares its "
                    "moment with couplings without them, so that nothing tells what its teeth "
                    'bear: state forces="mesh" of all of them, or leave out those that are surplus'
                )

    def _refuse_unheld(self, unheld: Array) -> None:
        """Refuse a moment about the line of a rod that nothing resists, by numbers of rods.

        Raises:
            MobilityError: there is one.
        """
        if not np.any(unheld > 0.0):
            return
        line = int(unheld.max()) - 1
        rods = next(
            group.idle
            for group, end in zip(
                self._groups, np.cumsum([len(group.idle) for group in self._groups]), strict=True
            )
            if line < end
        )
        names = self._mechanism.coordinates.names_of({rate for rod in rods for rate in rod.columns})
        raise MobilityError(
            f"a load acts about the line of an idle rod without inertia ({choices(names)}), "
            "which nothing can hold; give the rod mass, take the load off, or drive or hold "
            "its spin",
            free=names,
        )

    def _found(
        self,
        x: Array,
        inputs: Inputs,
        links: Sequence[LinkLoad],
        close: Callable[[Array], ClosedState],
        moves_alone: bool = False,
    ) -> tuple[Found, Array, set[int]]:
        """Return what is found of n samples, and what is open, without forces of elements.

        Args:
            x: `(size, n)` coordinates near closed ones.
            inputs: what is prescribed.
            links: wrenches on links.
            close: see `solution`, as well as for errors.
            moves_alone: whether the motion is wanted without forces.
        """
        kind = self.kind_of(inputs, links, moves_alone)
        equations, count = self.equations_of(kind), x.shape[1]
        offsets = self.offsets(equations.tree, inputs.turns)
        rows = Prescribed.of(inputs, vectors(links), offsets, kind)
        every = np.arange(count)
        opened: list[tuple[Array, set[int]]] = []
        found, left = self._by_tapes(equations, kind, rows, x, every, None, opened)
        if found is None:
            found = equations.found(np.empty((equations.outputs, count)))
        if len(left):
            try:
                state = close(left)
            except (AssemblyError, SingularConfigurationError):
                close(every)  # So that it tells of a sample by its number.
                raise
            closed = x.copy()
            closed[:, left] = state.x.T
            kind = kind._replace(is_closed=False)
            equations = self.equations_of(kind)
            _, alone = self._by_tapes(equations, kind, rows, closed, left, found, opened)
            if len(alone):
                told = alone[some(len(alone), SAMPLES)]
                acting = np.ones(len(rows.acting()), dtype=bool)
                for tape, own in self._own_tapes(equations, kind, closed, alone, acting):
                    result = tape.run(rows.of_lanes(own, count), closed[:, own])
                    self._refuse_unheld(result.unheld)
                    found.write(own, result.rows)
                    at = np.searchsorted(left, own)
                    found.error[own], found.condition[own] = state.residual[at], state.condition[at]
                    if len(some_own := np.intersect1d(own, told)):
                        of = rows.of_lanes(some_own, count), closed[:, some_own]
                        opened.append(tape.openings(*of))
        influence = self._silent
        for item, _ in opened:
            influence = np.maximum(influence, item)
        return found, influence, set().union(*(loose for _, loose in opened))

    def _by_tapes(
        self,
        equations: Equations,
        kind: Kind,
        rows: Prescribed,
        x: Array,
        left: Array,
        found: Found | None,
        opened: list[tuple[Array, set[int]]],
    ) -> tuple[Found | None, Array]:
        """Return what tapes find of n samples, and those of them that they do not hold for.

        What is unique at some samples is unique wherever tapes hold.

        Args:
            equations: of the kind.
            kind: of the samples.
            rows: what is given.
            x: `(size, n)` coordinates near closed ones.
            left: indices of the samples that are solved, ascending.
            found: of n samples, written; None where nothing is found yet.
            opened: what statics leaves open is added to it.
        """
        count = x.shape[1]
        for index in range(MOST_TAPES):
            own = rows if len(left) == count else rows.of_lanes(left, count)
            near = x if len(left) == count else x[:, left]
            result = self._run(index, equations, kind, own, near)
            if result is None:
                continue
            tape, closed = result
            holds = _closed(tape, own, closed)
            (lanes,) = holds.nonzero()
            if found is None:
                found = closed
            else:
                found.write(left[lanes], closed.rows.take(lanes, 1))
            if not (opened or kind.moves_alone) and len(lanes):
                at = closed.x.T
                if len(holds) > 1:  # Which a single sample would pay for.
                    lanes = lanes[some(len(lanes), SAMPLES)]
                    own, at = own.of_lanes(lanes, len(holds)), at[:, lanes]
                opened.append(tape.openings(own, at))
            left = left[~holds]
            if not len(left):
                break
        return found, left

    def _own_tapes(
        self, equations: Equations, kind: Kind, x: Array, samples: Array, acting: Array
    ) -> Iterator[tuple[Tape, Array]]:
        """Yield tapes of the orders chosen at samples themselves, and the samples of each.

        Which samples are beside a sample changes no bit of what its tape finds.

        Args:
            equations: of the kind.
            kind: of the samples.
            x: `(size, n)` coordinates, closed at the samples.
            samples: indices of some of n.
            acting: see `Tape`.
        """
        for order, shadows, own in self.orders_at(equations, x[:, samples]):
            if self._roles.compliances:
                yield Tape(equations, order, shadows, acting), samples[own]
                continue
            key = self.key, kind, tuple(order.places)
            make = partial(Tape, equations, order, shadows, acting)
            yield self._mechanism.kept.of("own tapes", key, make, _MOST_OWN), samples[own]

    def orders_at(self, equations: Equations, x: Array) -> Iterator[tuple[Order, Array, Array]]:
        """Yield orders that are chosen at samples, where, and the samples (index) of each.

        Args:
            equations: of their kind.
            x: `(size, n)` their closed coordinates.

        Raises:
            UnsuitableError: there is none at a sample.
        """
        shadows = x / equations.tree.coordinate_units(len(x))[:, None]
        for order, own in self._roles.orders(equations.tree, shadows, 1.0 / SINGULAR_CONDITION):
            # What compliances decide is chosen where a tape is traced.
            for part in own[:, None] if self._roles.compliances else [own]:
                yield order, shadows[:, part[:1]], part

    @cached_property
    def _silent(self) -> Array:
        """Influence `(b, 6)` of couplings that state no forces."""
        mechanism = self._mechanism
        result = np.zeros((mechanism.wrench_count, 6))
        if not mechanism.undescribed:
            return result
        from ..mechanism.undescribed import greatest_changes  # Few mechanisms have couplings.

        indices = mechanism.wrench_indices
        result[list(indices.values())] = greatest_changes(mechanism.undescribed, indices)
        return result

    @cached_property
    def orders(self) -> Orders | None:
        """Orders of elimination: the same for all scenes of the mechanism that move alike.

        None where the motion shows no scouts.
        """
        with suppress(AssemblyError, SingularConfigurationError):
            return self._assembly.orders(self._tree(()), self._roles)
        return None

    def _tree(self, factored: tuple[str, ...]) -> Tree:
        """Return the mechanism for tapes with factors on some links."""
        if factored not in self._trees:
            groups = tuple(group.key for group in self._groups)
            key = factored, groups, frozenset(self._solved[-1])
            self._trees[factored] = self._mechanism.kept.of(
                "trees", key, lambda: self.tree_at(self._mechanism, factored)
            )
        return self._trees[factored]

    def tree_at(self, mechanism: Mechanism, factored: tuple[str, ...]) -> Tree:
        """Return the mechanism, or one like it in which joints lie elsewhere, for tapes."""
        tree = tree_of(mechanism, factored, *self._solved)
        tree = with_rods(tree, mechanism, self._groups)
        return tree._replace(gears=gears_of(tree, mechanism))

    def _compliances(self) -> tuple[Compliance, ...]:
        """Return how joints give way, in the units of trees."""
        problem, mechanism = self.problem, self._mechanism
        if not problem.compliance:
            return ()
        units = np.repeat([1.0, self._tree(()).length], 3) * self._tree(()).length
        result = []
        for name, matrix in problem.compliance.items():
            parts = mechanism.joints[name].parts
            result.append(
                Compliance(
                    mechanism.wrench_indices[name],
                    parts[0].id - 1 if parts else -1,
                    tuple(map(tuple, (matrix * np.outer(units, units)).tolist())),
                )
            )
        return tuple(result)

    def _run(
        self, index: int, equations: Equations, kind: Kind, rows: Prescribed, x: Array
    ) -> tuple[Tape, Found] | None:
        """Return what the tape of an order (index) finds, which considers all that acts.

        None where no tape can have this order.
        """
        chosen = self.orders and self.orders.at(index)
        if not (self.orders and chosen):
            return None
        own = kind, chosen.scene
        if own not in self._tapes:
            kept = self._mechanism.kept
            key = self.key, self.orders.key, *own
            self._tapes[own] = kept.of("tapes", key, dict[int, Tape | None])
        tapes = self._tapes[own]

        def made(acting: Array) -> Tape | None:
            in_turn()
            try:
                tapes[index] = Tape(equations, chosen.order, chosen.at, acting)
            except UnsuitableError:
                tapes[index] = None
            return tapes[index]

        tape = tapes[index] if index in tapes else made(rows.acting())
        if tape is None:
            return None
        found = tape.run(rows, x)
        if np.count_nonzero(found.left_out):
            tape = made(rows.acting() | tape.acting)
            if tape is None:
                return None
            found = tape.run(rows, x)
        return tape, found

    def kind_of(self, inputs: Inputs, links: Sequence[LinkLoad], moves_alone: bool) -> Kind:
        """Return the kind of some samples."""
        factored = tuple(name for name, factor in inputs.inertia.items() if np.any(factor != 1.0))
        length = self._tree(()).length
        of_links = tuple(
            LinkKind(
                load.body,
                None if load.in_world else tuple(map(tuple, load.rotation.T.tolist())),
                tuple((load.place / length).tolist()),
            )
            for load in links
            if load.body >= 0
        )
        return Kind(inputs.has_rates, of_links, factored, moves_alone, inputs.is_closed)

    def equations_of(self, kind: Kind) -> Equations:
        """Return the equations of a kind of samples."""
        if kind not in self._equations:
            of = self._tree(kind.factored), self._roles, kind, self._sizes
            self._equations[kind] = Equations(*of, self._wrenches, self._varied)
        return self._equations[kind]

    def offsets(self, tree: Tree, turns: Array) -> Array:
        """Return the offsets `(c, n)` of couplings, with the whole turns coordinates lack."""
        result = np.empty((len(tree.couplings), len(turns)))
        if not len(result):
            return result
        columns = {item.rate: item.column for item in self._mechanism.coordinates.named.values()}
        for row, coupling in zip(result, tree.couplings, strict=True):
            row[:] = coupling.offset
            for rate in coupling.predecessors:
                row += 2.0 * np.pi * coupling.ratio * turns[:, columns[rate]]
            for rate in coupling.successors:
                row -= 2.0 * np.pi * turns[:, columns[rate]]
        return result


def vectors(links: Sequence[LinkLoad]) -> list[tuple[Array, Array]]:
    """Return forces and moments on links that are not the world's."""
    return [(load.force, load.moment) for load in links if load.body >= 0]


def _closed(tape: Tape, rows: Prescribed, found: Found) -> Array:
    """Return `(n,)` which samples a tape holds for, after further steps where these are needed."""
    # Comparisons with NaN say no.
    holds = found.failure <= 1.0
    for _ in range(_MOST_STEPS):
        if np.count_nonzero(holds) == len(holds):
            break
        (again,) = (~holds & (found.instability <= 1.0)).nonzero()
        if not len(again):
            break
        of_again = rows.of_lanes(again, len(holds)), found.x.T.take(again, 1)
        found.write(again, tape.run(*of_again).rows)
        holds = found.failure <= 1.0
    return np.asarray(holds)
