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

from ..arrays import Array, generic
from ..errors import AssemblyError, SingularConfigurationError
from ..kinematics.tolerances import REGULAR_CONDITION
from ..mechanics.bodies import Tree, tree_of
from ..mechanics.closure import rows as closure_rows
from ..mechanics.elimination import THRESHOLD, UnsuitableError, pivots
from ..mechanics.placements import placed
from ..mechanics.sample import Roles, passive_rows
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
        self, problem: Problem, varied: Sequence[str], passives: Array, wrenches: Sequence[int]
    ) -> None:
        """Begin without tapes.

        Args:
            problem: of the scene.
            varied: names of the held joints that differ from sample to sample.
            passives: velocity coordinates that the loops decide.
            wrenches: indices of those that are wanted.
        """
        coordinates = problem.mechanism.coordinates
        self._arguments = problem, varied, passives, wrenches
        self._mechanism, self._wrenches = problem.mechanism, wrenches
        self._varied = coordinates.columns_of(varied)
        self._roles = Roles(
            tuple(coordinates.rates_of(problem.independent)),
            tuple(coordinates.rates_of(problem.held)),
            tuple(passives.tolist()),
            tuple(sorted(wrenches_in_norm(problem.mechanism))),
        )
        self._trees: dict[tuple[str, ...], Tree] = {}
        self._tapes: dict[Kind, list[Tape]] = {}
        # What of the wrenches is unique: the same at all positions, and found in the general way.
        self._known: Solution | None = None

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
            found, holds = self._found(np.ascontiguousarray(x.T), inputs)
            if self._known is None:
                self._known = in_general(_some(len(x)))
            (left,) = np.nonzero(~holds)
            if 2 * len(left) > len(x):
                return None
            if len(left):
                found.write(left, _as_found(in_general(left)))
        except (UnsuitableError, AssemblyError, SingularConfigurationError):
            return None
        count, drives = len(x), len(self._roles.drives)
        rates = JointRates(found.ratios.reshape(count, -1, drives), found.v, found.a)
        wrenches = found.wrenches.reshape(count, -1, 6)
        of_joints = wrenches, found.efforts, found.couplings
        residuals = dynamics.residuals(found.x, inputs, rates, *of_joints)
        return self._known._replace(
            x=found.x,
            v=found.v,
            a=found.a,
            velocity_ratios=VelocityRatios.of(rates.velocity_ratios, dynamics.depends),
            wrenches=wrenches,
            efforts=found.efforts,
            coupling_moments=found.couplings,
            magnification=None,
            cancellation=residuals.cancellation,
            closure_condition=np.full(count, self._known.closure_condition.max()),
            loop_error=np.maximum(found.error, residuals.loop_error),
            residuals=residuals,
        )

    def _found(self, x: Array, inputs: Inputs) -> tuple[Found, Array]:
        """Return what tapes find of n samples, and `(n,)` which of them it holds for.

        With x `(size, n)`.

        Raises:
            UnsuitableError: no order suits the samples.
        """
        factored = tuple(name for name, factor in inputs.inertia.items() if np.any(factor != 1.0))
        if factored not in self._trees:
            self._trees[factored] = tree_of(self._mechanism, factored)
        tree = self._trees[factored]
        kind, given = self._given(tree, inputs, factored)
        tapes = self._tapes.setdefault(kind, [])
        if not tapes:
            tapes.append(self._made(tree, kind, x[:, _some(x.shape[1])]))
        found, holds = _closed(tapes[0], given, x)
        for index in range(1, _MOST_TAPES):
            (left,) = np.nonzero(~holds)
            if not len(left):
                break
            if index == len(tapes):
                if len(left) < _SHADOWS:
                    break
                tapes.append(self._made(tree, kind, x[:, left[_some(len(left))]]))
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
        order = pivots(passive_rows(rows, roles))
        return Tape(tree, roles, kind, self._wrenches, order, shadows, self._varied)

    def _given(
        self, tree: Tree, inputs: Inputs, factored: tuple[str, ...]
    ) -> tuple[Kind, dict[str, Any]]:
        """Return the kind of some samples, and the inputs of its tapes but for coordinates."""
        given: dict[str, Any] = {f"i{name}": inputs.inertia[name] for name in factored}

        def put(name: str, columns: Array) -> tuple[bool, ...]:
            """Take columns `(n, k)` that are no rounding of zero beside the others."""
            most = np.abs(columns).max(axis=0)
            acts = most > _EPS * most.max(initial=0.0)
            for index in np.flatnonzero(acts).tolist():
                given[f"{name}{index}"] = columns[:, index]
            return tuple(acts.tolist())

        units = tree.units[list(self._roles.drives)]
        speeds, accelerations = (
            put("v", inputs.speeds / units),
            put("a", inputs.accelerations / units),
        )
        gravity = put("g", tree.in_axes(inputs.gravity) / tree.length)
        loads = inputs.loads / tree.effort_units
        loaded = tuple(np.flatnonzero(loads.any(axis=0)).tolist())
        given |= {f"l{rate}": loads[:, rate] for rate in loaded}
        links = []
        for load in inputs.link_loads.values():
            if load.body < 0:
                continue
            force, moment, rotation = load.force, load.moment, None
            if load.in_world:
                force, moment = tree.in_axes(force), tree.in_axes(moment)
            else:
                rotation = tuple(map(tuple, load.rotation.T.tolist()))
            acts = (
                put(f"f{len(links)}_", force / tree.length),
                put(f"m{len(links)}_", moment / tree.length**2),
            )
            lever = tuple((load.place / tree.length).tolist())
            links.append(LinkKind(load.body, rotation, lever, *acts))
        given |= self._offsets(tree, inputs.turns)
        return Kind(speeds, accelerations, gravity, loaded, tuple(links), factored), given

    def _offsets(self, tree: Tree, turns: Array) -> dict[str, Array]:
        """Return the offsets of couplings, with the whole turns `(n, size)` coordinates lack."""
        columns = {item.rate: item.column for item in self._mechanism.coordinates.named.values()}
        result = {}
        for index, coupling in enumerate(tree.couplings):
            lacking = np.zeros(len(turns))
            for rate in coupling.predecessors:
                lacking += coupling.ratio * turns[:, columns[rate]]
            for rate in coupling.successors:
                lacking -= turns[:, columns[rate]]
            result[f"o{index}"] = coupling.offset + 2.0 * np.pi * lacking
        return result


def _some(count: int) -> Array:
    """Return indices of some of so many samples, without a pattern: symmetric positions mislead."""
    return np.unique((0.5 * (1.0 + generic(_SHADOWS, 1)[:, 0]) * count).astype(int) % count)


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
