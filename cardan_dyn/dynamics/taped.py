"""Taped: samples solved by tapes of a scene's equations, each of which judges itself.

A tape has an order of elimination that was chosen at some closed configurations of the motion. At
any other one it serves where the elimination does not grow, Newton's last step leaves rounding, and
the loops are closed. Samples that fail are solved by a second tape, whose order was chosen where
the first one does not serve, and at last by the general path, which judges ranks and singular
positions and says what is wrong.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np

from ..arrays import Array, some
from ..elements.link_loads import LinkLoad
from ..errors import AssemblyError, SingularConfigurationError
from ..kinematics.assembly import Assembly
from ..kinematics.following.orders import Orders
from ..kinematics.loops.closure_blocks import closure_blocks
from ..kinematics.loops.groups import Group
from ..mechanics.bodies import Tree, tree_of
from ..mechanics.elimination import UnsuitableError
from ..mechanics.sample import Roles
from ..problem.problem import Problem
from ..threads import in_turn
from .inverse_dynamics import Inputs, InverseDynamics, JointRates, Solution
from .reactions import wrenches_in_norm
from .tape import Found, Judged, Kind, LinkKind, Prescribed, Tape
from .velocity_ratios import VelocityRatios

_MOST_TAPES = 3
"""Orders that are tried at samples of one kind."""
_SAMPLES = 16
"""Samples that tell what statics leaves open."""
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
        opened: Array | None,
        assembly: Assembly,
        efforts_alone: bool = False,
    ) -> None:
        """Begin without tapes.

        Args:
            problem: of the scene.
            varied: names of the held joints that differ from sample to sample.
            groups: those that are solved, and whether their forces are, too.
            wrenches: indices of those that are wanted.
            opened: `(b, 6)` influence of couplings that state no forces; None if all do.
            assembly: at whose scouts orders of elimination are chosen.
            efforts_alone: whether of all forces the efforts of drives are wanted alone.
        """
        mechanism = problem.mechanism
        coordinates = mechanism.coordinates
        self._opened, self._assembly = opened, assembly
        self._problem, self._mechanism, self._wrenches = problem, mechanism, wrenches
        self._varied = coordinates.columns_of(varied)
        self._solved = (
            [index for group, _ in groups for index in group.loops],
            [index for group, _ in groups for index in group.couplings],
            # As in the general way, which counts what it leaves out with the forces of others.
            {
                body
                for group, wanted in groups
                if wanted or efforts_alone
                for body in group.inertial_bodies
            },
        )
        fixed = sum(loop.is_fixed for loop in mechanism.loops)
        self._sizes = mechanism.model.njoints - 1 + fixed, len(mechanism.couplings)
        self._roles = Roles(
            tuple(coordinates.rates_of(problem.independent)),
            tuple(coordinates.rates_of(problem.held)),
            closure_blocks(groups),
            tuple(sorted(wrenches_in_norm(mechanism))),
            efforts_alone,
        )
        self._trees: dict[tuple[str, ...], Tree] = {}
        self._tapes: dict[Kind, dict[int, Tape]] = {}
        self._key = (
            self._roles,
            tuple(self._varied),
            tuple(sorted(wrenches)),
            tuple(group.key for group, _ in groups),
        )

    def solution(
        self,
        dynamics: InverseDynamics,
        x: Array,
        inputs: Inputs,
        in_general: Callable[[Array], Solution],
    ) -> Solution | None:
        """Return the solution of samples with its residuals.

        Args:
            dynamics: of the scene.
            x: `(n, size)` coordinates near closed ones, exact in the drives.
            inputs: what is prescribed.
            in_general: solves samples, by their indices, in the general way.

        Returns:
            None where the general way has to solve all of them, also to say why it cannot.
        """
        try:
            with np.errstate(all="ignore"):  # What overflows is refused where results are judged.
                found, holds, openings = self._with_elements(np.ascontiguousarray(x.T), inputs)
            (left,) = (~holds).nonzero()
            if openings is None or 2 * len(left) > len(x):
                return None
            influence, loose = openings
            if self._opened is not None:
                influence = np.maximum(influence, self._opened)
            if len(left):
                rest = in_general(left)
                found.write(left, _as_found(rest))
                influence = np.maximum(influence, rest.influence)
                loose = loose | rest.indeterminate_couplings
        except (UnsuitableError, AssemblyError, SingularConfigurationError):
            return None
        count, drives = len(x), len(self._roles.drives)
        rates = JointRates(found.ratios.reshape(count, -1, drives), found.v, found.a)
        wrenches = found.wrenches.reshape(count, -1, 6)
        of_joints = wrenches, found.efforts, found.couplings
        residuals = dynamics.residuals(found.x, inputs, rates, *of_joints)
        return Solution(
            x=found.x,
            v=found.v,
            a=found.a,
            velocity_ratios=VelocityRatios.of(rates.velocity_ratios, dynamics.depends),
            wrenches=wrenches,
            efforts=found.efforts,
            coupling_moments=found.couplings,
            magnification=None,
            cancellation=residuals.cancellation,
            # A copy, since it is kept longer than all that it is a row of.
            closure_condition=found.condition.copy(),
            loop_error=np.maximum(found.error, residuals.loop_error),
            residuals=residuals,
            influence=influence,
            indeterminate_couplings=loose,
        )

    def _with_elements(
        self, x: Array, inputs: Inputs
    ) -> tuple[Found, Array, tuple[Array, set[int]] | None]:
        """Return what `_found` does; elements exert what follows of the motion alone."""
        elements = self._problem.element_forces
        links = list(inputs.link_loads.values())
        if elements is None:
            return self._found(x, inputs, links)
        moved, moves, _ = self._found(x, inputs, [], moves_alone=True)
        if not moves.any():
            return moved, moves, None
        # Where the motion is not known, elements exert what they do at another sample.
        known = np.where(moves, np.arange(len(moves)), moves.argmax())
        time = inputs.time[known] if len(inputs.time) == len(known) else inputs.time
        acted = elements.at((moved.x + 2.0 * np.pi * inputs.turns)[known], moved.v[known], time)
        x = np.where(moves, moved.x.T, x)
        inputs = inputs._replace(loads=inputs.loads + acted.efforts)
        found, holds, openings = self._found(x, inputs, links + acted.link_loads(self._mechanism))
        return found, holds & moves, openings

    def _found(
        self, x: Array, inputs: Inputs, links: Sequence[LinkLoad], moves_alone: bool = False
    ) -> tuple[Found, Array, tuple[Array, set[int]] | None]:
        """Return what tapes find of n samples, `(n,)` which of them it holds for, and what is open.

        The last one, see `Tape.openings`, is None where no sample holds, or without forces. What is
        unique at some samples is unique wherever tapes hold.

        Args:
            x: `(size, n)` coordinates near closed ones.
            inputs: what is prescribed.
            links: wrenches on links.
            moves_alone: whether the motion is wanted without forces.

        Raises:
            UnsuitableError: no order suits the motion.
        """
        kind, tree = self._kind(inputs, links, moves_alone)
        rows = Prescribed.of(inputs, _vectors(links), self._offsets(tree, inputs.turns), kind)
        count, openings = x.shape[1], None
        for index in range(_MOST_TAPES):
            if not index:
                tape, found, judged = self._run(index, tree, kind, rows, x)
                holds = _closed(tape, rows, found, judged)
                known, own, closed = holds, rows, found
            else:
                (left,) = (~holds).nonzero()
                if not len(left) or self._orders.at(index) is None:
                    break
                own = rows.of_lanes(left, count)
                tape, closed, judged = self._run(index, tree, kind, own, x[:, left])
                known = _closed(tape, own, closed, judged)
                found.write(left[known], [values[known] for values in closed])
                holds[left[known]] = True
            if openings is None and not moves_alone and known.any():
                (lanes,) = known.nonzero()
                lanes = lanes[some(len(lanes), _SAMPLES)]
                openings = tape.openings(own.of_lanes(lanes, len(known)), closed.x[lanes].T)
        return found, holds, openings

    @cached_property
    def _orders(self) -> Orders:
        """Orders of elimination: the same for all scenes of the mechanism that move alike."""
        return self._assembly.orders(self._tree(()), self._roles)

    def _tree(self, factored: tuple[str, ...]) -> Tree:
        """Return the mechanism for tapes with factors on some links."""
        if factored not in self._trees:
            self._trees[factored] = tree_of(self._mechanism, factored, *self._solved)
        return self._trees[factored]

    def _run(
        self, index: int, tree: Tree, kind: Kind, rows: Prescribed, x: Array
    ) -> tuple[Tape, Found, Judged]:
        """Return what the tape of an order (index) finds, which considers all that acts."""
        chosen = self._orders.at(index)
        if chosen is None:
            raise UnsuitableError
        order, samples = chosen
        shadows = dict(enumerate(self._orders.scouts[:, samples]))
        if kind not in self._tapes:
            self._tapes[kind] = self._mechanism.kept.of("tapes", (self._key, kind), dict[int, Tape])
        tapes = self._tapes[kind]

        def made(acting: Array) -> Tape:
            in_turn()
            wanted = self._sizes, self._wrenches, order, shadows, self._varied, acting
            tapes[index] = Tape(tree, self._roles, kind, *wanted)
            return tapes[index]

        tape = tapes.get(index) or made(rows.acting())
        found, judged = tape.run(rows, x)
        if np.count_nonzero(judged.left_out):
            tape = made(rows.acting() | tape.acting)
            found, judged = tape.run(rows, x)
        return tape, found, judged

    def _kind(
        self, inputs: Inputs, links: Sequence[LinkLoad], moves_alone: bool
    ) -> tuple[Kind, Tree]:
        """Return the kind of some samples, and the mechanism for its tapes."""
        factored = tuple(name for name, factor in inputs.inertia.items() if np.any(factor != 1.0))
        tree = self._tree(factored)
        of_links = tuple(
            LinkKind(
                load.body,
                None if load.in_world else tuple(map(tuple, load.rotation.T.tolist())),
                tuple((load.place / tree.length).tolist()),
            )
            for load in links
            if load.body >= 0
        )
        return Kind(inputs.has_rates, of_links, factored, moves_alone), tree

    def _offsets(self, tree: Tree, turns: Array) -> Array:
        """Return the offsets `(c, n)` of couplings, with the whole turns coordinates lack."""
        columns = {item.rate: item.column for item in self._mechanism.coordinates.named.values()}
        result = np.empty((len(tree.couplings), len(turns)))
        for row, coupling in zip(result, tree.couplings, strict=True):
            row[:] = coupling.offset
            for rate in coupling.predecessors:
                row += 2.0 * np.pi * coupling.ratio * turns[:, columns[rate]]
            for rate in coupling.successors:
                row -= 2.0 * np.pi * turns[:, columns[rate]]
        return result


def _vectors(links: Sequence[LinkLoad]) -> list[tuple[Array, Array]]:
    """Return forces and moments on links that are not the world's."""
    return [(load.force, load.moment) for load in links if load.body >= 0]


def _closed(tape: Tape, rows: Prescribed, found: Found, judged: Judged) -> Array:
    """Return `(n,)` which samples a tape holds for, after further steps where these are needed."""
    # Comparisons with NaN say no.
    is_exact = judged.inexactness <= 1.0
    for _ in range(_MOST_STEPS):
        again = ((judged.instability <= 1.0) & ~is_exact).nonzero()[0]
        if not len(again):
            break
        others, rejudged = tape.run(rows.of_lanes(again, len(is_exact)), found.x[again].T)
        found.write(again, others)
        for values, new in zip(judged, rejudged, strict=True):
            values[again] = new
        is_exact = judged.inexactness <= 1.0
    return np.asarray(is_exact & (judged.instability <= 1.0))


def _as_found(general: Solution) -> list[Array]:
    """Return a solution of the general path in the order of `Found`."""
    ratios, v, a = general.velocity_ratios, general.v, general.a
    assert ratios is not None and v is not None and a is not None
    count = len(general.x)
    dense = np.where(ratios.moved >= 0, ratios.values[:, ratios.moved], 0.0).reshape(count, -1)
    wrenches = general.wrenches.reshape(count, -1)
    of_joints = wrenches, general.efforts, general.coupling_moments
    judged = general.loop_error, general.closure_condition
    return [general.x, v, a, dense, *of_joints, *judged]
