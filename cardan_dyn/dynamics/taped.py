"""Taped: many samples solved by tapes of a scene's equations, each of which judges itself.

A tape has an order of elimination that was chosen at some samples. At any other one it serves where
the elimination does not grow, Newton's last step leaves rounding, and the loops are closed. Samples
that fail are solved by a second tape, whose order was chosen at such samples, and at last by the
general path, which judges ranks and singular positions and says what is wrong.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ..arrays import Array, some
from ..elements.link_loads import LinkLoad
from ..errors import AssemblyError, SingularConfigurationError
from ..kinematics.loops.closure_blocks import closure_blocks
from ..kinematics.loops.groups import Group
from ..kinematics.tolerances import REGULAR_CONDITION
from ..mechanics.bodies import Tree, tree_of
from ..mechanics.closure import rows as closure_rows
from ..mechanics.elimination import THRESHOLD, UnsuitableError
from ..mechanics.placements import placed
from ..mechanics.sample import Roles
from ..problem.problem import Problem
from .inverse_dynamics import Inputs, InverseDynamics, JointRates, Solution
from .reactions import wrenches_in_norm
from .tape import Found, Kind, LinkKind, Tape
from .velocity_ratios import VelocityRatios

_EPS = float(np.finfo(float).eps)
_SHADOWS = 16
"""Samples at which an order of elimination is chosen."""
_MOST_TAPES = 3
"""Orders that are tried at samples of one kind."""
_MOST_KINDS = 8
"""Kinds of samples whose tapes are kept, the last ones: of most scenes there are one or two."""
_GROWTH = 1.0 / THRESHOLD
"""Growth of an elimination up to which its order serves: what is allowed where it is chosen."""
_FAR = 1e-3
"""Newton step [rad, or lengths] that is left to the general path, which knows how far off a guess
may be: between dense samples, guesses are off by 1e-6."""
_EXACT = float(np.sqrt(_EPS))
"""Newton step that leaves rounding: its square."""
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
    ) -> None:
        """Begin without tapes.

        Args:
            problem: of the scene.
            varied: names of the held joints that differ from sample to sample.
            groups: those that are solved, and whether their forces are, too.
            wrenches: indices of those that are wanted.
        """
        mechanism = problem.mechanism
        coordinates = mechanism.coordinates
        self._arguments = problem, varied, groups, wrenches
        self._problem, self._mechanism, self._wrenches = problem, mechanism, wrenches
        self._varied = coordinates.columns_of(varied)
        self._solved = (
            [index for group, _ in groups for index in group.loops],
            [index for group, _ in groups for index in group.couplings],
            # As in the general way, which counts what it leaves out with the forces of others.
            {body for group, wanted in groups if wanted for body in group.inertial_bodies},
        )
        fixed = sum(loop.is_fixed for loop in mechanism.loops)
        self._sizes = mechanism.model.njoints - 1 + fixed, len(mechanism.couplings)
        self._roles = Roles(
            tuple(coordinates.rates_of(problem.independent)),
            tuple(coordinates.rates_of(problem.held)),
            closure_blocks(groups),
            tuple(sorted(wrenches_in_norm(mechanism))),
        )
        self._trees: dict[tuple[str, ...], Tree] = {}
        self._tapes: dict[Kind, list[Tape]] = {}

    def __reduce__(self) -> tuple[object, ...]:
        return TapedSolver, self._arguments

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
                found, holds = self._with_elements(np.ascontiguousarray(x.T), inputs)
            (left,) = np.nonzero(~holds)
            if 2 * len(left) > len(x):
                return None
            # What is unique at these samples is unique wherever tapes hold.
            known = in_general(some(len(x), _SHADOWS))
            if len(left):
                rest = in_general(left)
                found.write(left, _as_found(rest))
                known = _with_openings(known, rest)
        except (UnsuitableError, AssemblyError, SingularConfigurationError):
            return None
        count, drives = len(x), len(self._roles.drives)
        rates = JointRates(found.ratios.reshape(count, -1, drives), found.v, found.a)
        wrenches = found.wrenches.reshape(count, -1, 6)
        of_joints = wrenches, found.efforts, found.couplings
        residuals = dynamics.residuals(found.x, inputs, rates, *of_joints)
        return known._replace(
            x=found.x,
            v=found.v,
            a=found.a,
            velocity_ratios=VelocityRatios.of(rates.velocity_ratios, dynamics.depends),
            wrenches=wrenches,
            efforts=found.efforts,
            coupling_moments=found.couplings,
            magnification=None,
            cancellation=residuals.cancellation,
            closure_condition=np.full(count, known.closure_condition.max()),
            loop_error=np.maximum(found.error, residuals.loop_error),
            residuals=residuals,
        )

    def _with_elements(self, x: Array, inputs: Inputs) -> tuple[Found, Array]:
        """Return what `_found` does; elements exert what follows of the motion alone."""
        elements = self._problem.element_forces
        links = list(inputs.link_loads.values())
        if elements is None:
            return self._found(x, inputs, links)
        moved, moves = self._found(x, inputs, [], moves_alone=True)
        if not moves.any():
            return moved, moves
        # Where the motion is not known, elements exert what they do at another sample.
        known = np.where(moves, np.arange(len(moves)), moves.argmax())
        time = inputs.time[known] if len(inputs.time) == len(known) else inputs.time
        acted = elements.at((moved.x + 2.0 * np.pi * inputs.turns)[known], moved.v[known], time)
        x = np.where(moves, moved.x.T, x)
        inputs = inputs._replace(loads=inputs.loads + acted.efforts)
        found, holds = self._found(x, inputs, links + acted.link_loads(self._mechanism))
        return found, holds & moves

    def _found(
        self, x: Array, inputs: Inputs, links: Sequence[LinkLoad], moves_alone: bool = False
    ) -> tuple[Found, Array]:
        """Return what tapes find of n samples, and `(n,)` which of them it holds for.

        Args:
            x: `(size, n)` coordinates near closed ones.
            inputs: what is prescribed.
            links: wrenches on links.
            moves_alone: whether the motion is wanted without forces.

        Raises:
            UnsuitableError: no order suits the samples.
        """
        factored = tuple(name for name, factor in inputs.inertia.items() if np.any(factor != 1.0))
        if factored not in self._trees:
            self._trees[factored] = tree_of(self._mechanism, factored, *self._solved)
        tree = self._trees[factored]
        kind, given = self._given(tree, inputs, links, factored)
        kind = kind._replace(moves_alone=moves_alone)
        if kind not in self._tapes and len(self._tapes) == _MOST_KINDS:
            self._tapes.pop(next(iter(self._tapes)))
        tapes = self._tapes.setdefault(kind, [])
        if not tapes:
            tapes.append(self._made(tree, kind, x[:, some(x.shape[1], _SHADOWS)]))
        found, holds = _closed(tapes[0], given, x)
        for index in range(1, _MOST_TAPES):
            (left,) = np.nonzero(~holds)
            if not len(left):
                break
            if index == len(tapes):
                if len(left) < _SHADOWS:
                    break
                tapes.append(self._made(tree, kind, x[:, left[some(len(left), _SHADOWS)]]))
            of_left = np.ascontiguousarray(x[:, left])
            others, serves = _closed(tapes[index], _of_lanes(given, left, x.shape[1]), of_left)
            found.write(left[serves], [values[serves] for values in others])
            holds[left[serves]] = True
        return found, holds

    def _made(self, tree: Tree, kind: Kind, x: Array) -> Tape:
        """Return a tape whose order is chosen at samples `(size, S)`."""
        shadows = {
            column: x[column] / (tree.length if body.kind == "prismatic" else 1.0)
            for body in tree.bodies
            for column in body.columns
        }
        roles = self._roles
        rows = closure_rows(tree, placed(tree, shadows), {*roles.drives, *roles.passives})
        wanted = self._sizes, self._wrenches
        return Tape(tree, roles, kind, *wanted, roles.order(rows), shadows, self._varied)

    def _given(
        self,
        tree: Tree,
        inputs: Inputs,
        stated: Sequence[LinkLoad],
        factored: tuple[str, ...],
    ) -> tuple[Kind, dict[str, Any]]:
        """Return the kind of some samples, and the inputs of its tapes but for coordinates."""
        given: dict[str, Any] = {f"i{name}": inputs.inertia[name] for name in factored}

        def put(name: str, columns: Array, rounding: float = 0.0) -> tuple[bool, ...]:
            """Take columns `(n, k)` that are at some sample no rounding of zero beside others."""
            sizes = np.abs(columns)
            acts = (sizes > rounding * sizes.max(axis=1, keepdims=True)).any(axis=0)
            for index in np.flatnonzero(acts).tolist():
                given[f"{name}{index}"] = columns[:, index]
            return tuple(acts.tolist())

        units = tree.units[list(self._roles.drives)]
        speeds, accelerations = (
            put("v", inputs.speeds / units),
            put("a", inputs.accelerations / units),
        )
        gravity = put("g", tree.in_axes(inputs.gravity) / tree.length, _EPS)
        loads = inputs.loads / tree.effort_units
        loaded = tuple(np.flatnonzero(loads.any(axis=0)).tolist())
        given |= {f"l{rate}": loads[:, rate] for rate in loaded}
        links: list[LinkKind] = []
        for load in stated:
            if load.body < 0:
                continue
            force, moment, rotation = load.force, load.moment, None
            if load.in_world:
                force, moment = tree.in_axes(force), tree.in_axes(moment)
            else:
                rotation = tuple(map(tuple, load.rotation.T.tolist()))
            acts = (
                put(f"f{len(links)}_", force / tree.length, _EPS),
                put(f"m{len(links)}_", moment / tree.length**2, _EPS),
            )
            lever = tuple((load.place / tree.length).tolist())
            links.append(LinkKind(load.body, rotation, lever, *acts))
        given |= self._offsets(tree, inputs.turns)
        return Kind(speeds, accelerations, gravity, loaded, tuple(links), factored, False), given

    def _offsets(self, tree: Tree, turns: Array) -> dict[str, Array]:
        """Return the offsets of couplings, with the whole turns `(n, size)` coordinates lack."""
        columns = {item.rate: item.column for item in self._mechanism.coordinates.named.values()}
        result = {}
        for coupling in tree.couplings:
            lacking = np.zeros(len(turns))
            for rate in coupling.predecessors:
                lacking += coupling.ratio * turns[:, columns[rate]]
            for rate in coupling.successors:
                lacking -= turns[:, columns[rate]]
            result[f"o{coupling.number}"] = coupling.offset + 2.0 * np.pi * lacking
        return result


def _with_openings(known: Solution, rest: Solution) -> Solution:
    """Return a solution with what is open at other samples as well, and their conditions."""
    conditions = known.closure_condition, rest.closure_condition
    return known._replace(
        influence=np.maximum(known.influence, rest.influence),
        indeterminate_couplings=known.indeterminate_couplings | rest.indeterminate_couplings,
        closure_condition=np.concatenate(conditions),
    )


def _closed(tape: Tape, given: Mapping[str, Any], x: Array) -> tuple[Found, Array]:
    """Return what a tape finds of n samples, and `(n,)` which of them it holds for.

    With x `(size, n)`.
    """
    count = x.shape[1]
    found, judged = tape.run(given, x)
    step, error, growth, narrowness = judged

    def is_stable() -> Array:
        # Comparisons with NaN say no.
        serves = (growth <= _GROWTH) & (narrowness <= REGULAR_CONDITION)
        return np.asarray(serves & (step <= _FAR))

    for _ in range(_MOST_STEPS):
        (again,) = np.nonzero(is_stable() & (step > _EXACT))
        if not len(again):
            break
        near = np.ascontiguousarray(found.x[again].T)
        others, judged[:, again] = tape.run(_of_lanes(given, again, count), near)
        found.write(again, others)
    return found, is_stable() & (step <= _EXACT) & (error <= tape.rounding)


def _of_lanes(given: Mapping[str, Any], lanes: Array, count: int) -> dict[str, Any]:
    """Return the inputs of some of n samples."""
    return {
        name: value[lanes] if len(value) == count > 1 else value for name, value in given.items()
    }


def _as_found(general: Solution) -> list[Array]:
    """Return a solution of the general path in the order of `Found`."""
    ratios, v, a = general.velocity_ratios, general.v, general.a
    assert ratios is not None and v is not None and a is not None
    count = len(general.x)
    dense = np.where(ratios.moved >= 0, ratios.values[:, ratios.moved], 0.0).reshape(count, -1)
    wrenches = general.wrenches.reshape(count, -1)
    of_joints = wrenches, general.efforts, general.coupling_moments
    return [general.x, v, a, dense, *of_joints, general.loop_error]
