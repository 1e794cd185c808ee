"""Taped: blocks of samples solved by a tape of the scene's equations.

The equations of a sample (`mechanics`) are traced for a scene, and run for all samples of a block
side by side. A tape has an order of elimination that was chosen at some samples, so each sample
judges itself: its closure errors are rounding, its last step of Newton's method and the growth of
its elimination are small. Samples that fail are solved by a second tape, whose order was chosen at
such samples, and at last by the general path, which judges ranks and singular positions.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..elements.link_loads import LinkLoad
from ..errors import AssemblyError, SingularConfigurationError
from ..mechanics.bodies import Tree, slides, tree_of
from ..mechanics.elimination import THRESHOLD, Pivot, Unsuitable, pivots
from ..mechanics.placements import placed
from ..mechanics.closure import rows as closure_rows
from ..kinematics.tolerances import REGULAR_CONDITION
from ..mechanics.sample import Given, LinkForce, Roles, passive_rows, solved
from ..problem.problem import Problem
from ..tape import Program, Trace
from .inverse_dynamics import InverseDynamics, Inputs, JointRates, Solution
from .reactions import wrenches_in_norm
from .velocity_ratios import VelocityRatios

if TYPE_CHECKING:
    from .problem_solver import ProblemSolver

SHADOWS = 16
"""Samples at which an order of elimination is chosen."""
_GROWTH = 1.0 / THRESHOLD
"""Growth of an elimination up to which a sample is handed out: what its order has where it was
chosen. A sample with more loses digits in proportion."""
_STEP = 1e-3
"""Error [rad, or lengths of the mechanism] of a guess that Newton's method is left to take off."""
_EXACT_STEP = float(np.sqrt(np.finfo(float).eps))
"""Step of Newton's method that leaves rounding: its square."""
_PASSES = 3
"""Further steps of Newton's method that a guess gets: each squares what is left."""
_MOST_ORDERS = 3
"""Tapes of a scene and kind, each with an order of its own."""


class Kind(NamedTuple):
    """What a tape is traced for: what vanishes at all samples falls away.

    Attributes:
        speeds, accelerations: whether each drive has one.
        gravity: which components act, in the tree's axes.
        loads: loaded velocity coordinates.
        links: loads on links, by what does not depend on the sample.
        factored: links with factors.
    """

    speeds: tuple[bool, ...]
    accelerations: tuple[bool, ...]
    gravity: tuple[bool, ...]
    loads: tuple[int, ...]
    links: tuple[tuple[Any, ...], ...]
    factored: tuple[str, ...]


class Found(NamedTuple):
    """What a tape finds of n samples.

    Attributes:
        x: `(n, size)` coordinates.
        v, a: `(n, nv)`.
        ratios: `(n, k)`, see `VelocityRatios`.
        wrenches: `(n, b, 6)`.
        efforts: `(n, nv)` what drives and held joints exert.
        couplings: `(n, G)`.
        error: `(n,)` closure error, as a fraction of the mechanism's length.
    """

    x: Array
    v: Array
    a: Array
    ratios: Array
    wrenches: Array
    efforts: Array
    couplings: Array
    error: Array


class Tape:
    """The equations of a scene for one kind of samples, with one order of elimination.

    Attributes:
        order: of the elimination.
        moved: `(nv, d)`, see `VelocityRatios`.
        rounding: closure error, as a fraction of the mechanism's length, up to which loops count as
            closed: that of as many sums of lengths as there are bodies.
    """

    def __init__(
        self, problem: Problem, tree: Tree, roles: Roles, kind: Kind, bodies: Sequence[int],
        order: Sequence[Pivot], shadows: Mapping[int, Array], varied: Sequence[int],
    ) -> None:
        """Trace the equations.

        Args:
            problem: of the scene.
            tree: its mechanism.
            roles: of its coordinates.
            kind: what is traced.
            bodies: indices of the wrenches that are wanted, `fixed` loops after all bodies.
            order: of the elimination.
            shadows: column of coordinate rows to values `(S,)` at which orders are chosen.
            varied: columns of held joints that differ from sample to sample.

        Raises:
            Unsuitable: samples do not tell which self-stresses are independent.
        """
        self.order = order
        self._tree = tree
        farthest = max(
            (float(np.abs(value).max()) for point in placed(tree, shadows).points for value in point),
            default=1.0,
        )
        self.rounding = len(tree.bodies) * float(np.finfo(float).eps) * max(1.0, farthest)
        self._size, self._nv = problem.mechanism.coordinates.size, problem.mechanism.model.nv
        self._count = len(tree.bodies) + sum(loop.is_fixed for loop in tree.loops)
        trace = Trace()
        moving = {*roles.passives, *roles.drives}
        self._per_sample = {
            *varied,
            *(column for body in tree.bodies if moving.issuperset(body.rates) for column in body.columns),
        }
        x = {
            column: trace.input(f"x{column}", values, uniform=column not in self._per_sample)
            for column, values in shadows.items()
        }

        def given(name: str, flags: Sequence[bool]) -> list[Any]:
            return [
                trace.input(f"{name}{index}", 1.0) if flag else 0.0
                for index, flag in enumerate(flags)
            ]

        forces = []
        for index, (body, rotation, lever, force, moment) in enumerate(kind.links):
            forces.append(
                LinkForce(
                    body, rotation, lever,
                    tuple(given(f"f{index}_", force)), tuple(given(f"m{index}_", moment)),
                )
            )
        found = solved(
            tree,
            roles,
            Given(
                x,
                given("v", kind.speeds),
                given("a", kind.accelerations),
                tuple(given("g", kind.gravity)),
                {rate: trace.input(f"l{rate}", 1.0) for rate in kind.loads},
                forces,
                {name: trace.input(f"i{name}", 1.5) for name in kind.factored},
                [trace.input(f"o{index}", 0.0) for index in range(len(tree.couplings))],
            ),
            order,
        )
        length = tree.length
        units = np.ones(self._nv)
        units[list(slides(tree))] = length
        judged = found.step, found.error / tree.norm_length, found.growth, found.narrowness
        outputs: list[Any] = list(judged)
        self._x: list[tuple[int, int]] = []
        self._v: list[tuple[int, int]] = []
        self._a: list[tuple[int, int]] = []
        self._wrenches: list[tuple[int, int]] = []
        self._efforts: list[tuple[int, int]] = []

        def put(where: list[tuple[int, int]], index: int, value: Any, unit: float) -> None:
            if type(value) is not float or value != 0.0:
                where.append((index, len(outputs)))
                outputs.append(value * unit)

        passives = set(roles.passives)
        self._constant: list[int] = []
        for body in tree.bodies:
            for column in body.columns:
                if passives.issuperset(body.rates):
                    unit = length if body.kind == "prismatic" else 1.0
                    put(self._x, column, found.x[column], unit)
                else:
                    self._constant.append(column)
        for rate, value in found.v.items():
            put(self._v, rate, value, units[rate])
        for rate, value in found.a.items():
            put(self._a, rate, value, units[rate])
        drives = len(roles.drives)
        self.moved = np.full((self._nv, drives), -1)
        self._first_ratio, count = len(outputs), 0
        for rate in range(self._nv):
            for drive in range(drives):
                value = found.ratios[drive].get(rate, 0.0)
                if type(value) is not float or value != 0.0:
                    self.moved[rate, drive] = count
                    outputs.append(value * (units[rate] / units[roles.drives[drive]]))
                    count += 1
        self._ratios = count
        fixed = dict(enumerate(found.fixed, len(tree.bodies)))
        for index in bodies:
            force, moment = fixed[index] if index in fixed else found.wrenches[index]
            for component in range(3):
                put(self._wrenches, 6 * index + component, force[component], length)
                put(self._wrenches, 6 * index + 3 + component, moment[component], length**2)
        for rate, value in found.exerted.items():
            put(self._efforts, rate, value, length**2 / units[rate])
        self._first_moment = len(outputs)
        for coupling, value in zip(tree.couplings, found.couplings, strict=True):
            unit = units[coupling.successors[0]] if coupling.successors else 1.0
            outputs.append(value * (length**2 / unit))
        self._program = Program(trace, outputs)

    def run(self, given: Mapping[str, Array | float], x: Array, count: int) -> tuple[Found, Array]:
        """Solve samples.

        Args:
            given: inputs but for those of `x`.
            x: `(size, count)` coordinates near closed ones.
            count: number of samples.

        Returns:
            What is found; and `(4, count)` step, error, growth and narrowness, see `Solved`.
        """
        length = self._tree.length
        inputs = dict(given)
        for body in self._tree.bodies:
            for column in body.columns:
                row = x[column] if column in self._per_sample else x[column, 0]
                inputs[f"x{column}"] = row / length if body.kind == "prismatic" else row
        outputs = self._program.run(inputs, count)

        def rows(where: list[tuple[int, int]], size: int) -> Array:
            if where and where == [(k, where[0][1] + k) for k in range(size)]:
                return outputs[where[0][1] : where[0][1] + size]
            result = np.zeros((size, count))
            for index, row in where:
                result[index] = outputs[row]
            return result

        found_x = rows(self._x, self._size) if not self._constant else np.array(x)
        if self._constant:
            for index, row in self._x:
                found_x[index] = outputs[row]
        moments = outputs[self._first_moment :]
        ratios = outputs[self._first_ratio : self._first_ratio + self._ratios]
        wrenches = rows(self._wrenches, 6 * self._count) if self._count else np.zeros((0, count))
        found = Found(
            found_x.T,
            rows(self._v, self._nv).T,
            rows(self._a, self._nv).T,
            ratios.T,
            wrenches.T.reshape(count, self._count, 6),
            rows(self._efforts, self._nv).T,
            moments.T,
            outputs[1],
        )
        return found, outputs[:4]


class TapedSolver:
    """Solves samples of a problem by tapes.

    Its tapes are kept, and made when a kind of samples is first met.
    """

    def __init__(
        self,
        problem: Problem,
        varied: Sequence[str],
        passives: Array,
        bodies: Sequence[int],
    ) -> None:
        """Read the mechanism.

        Args:
            problem: of the scene.
            varied: held joints that differ from sample to sample.
            passives: velocity coordinates that the loops decide.
            bodies: indices of the wrenches that are wanted.
        """
        mechanism = problem.mechanism
        self._problem, self._bodies = problem, list(bodies)
        coordinates = mechanism.coordinates
        self._varied = coordinates.columns_of(varied)
        self._roles = Roles(
            tuple(coordinates.rates_of(problem.independent)),
            tuple(coordinates.rates_of(problem.held)),
            tuple(passives.tolist()),
            tuple(sorted(wrenches_in_norm(mechanism))),
        )
        self._trees: dict[tuple[str, ...], Tree] = {}
        self._tapes: dict[Kind, list[Tape]] = {}
        # Which wrenches are unique, found once in the general way.
        self._known: Solution | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        varied = [name for name, item in self._problem.mechanism.coordinates.named.items() if item.column in self._varied]
        return TapedSolver, (self._problem, varied, np.array(self._roles.passives, dtype=int), self._bodies)

    def solve(self, x: Array, inputs: Inputs) -> tuple[Found, Array, Array]:
        """Solve samples.

        Args:
            x: `(n, size)` coordinates near closed ones, exact in the drives.
            inputs: what is prescribed.

        Returns:
            What is found; `(n,)` which samples it holds for; and `moved` of `VelocityRatios`.

        Raises:
            Unsuitable: no order suits the samples.
        """
        links = {name: load for name, load in inputs.link_loads.items() if load.body >= 0}
        factored = tuple(
            name for name, factor in inputs.inertia.items() if np.any(factor != 1.0)
        )
        if factored not in self._trees:
            self._trees[factored] = tree_of(self._problem.mechanism, factored)
        tree = self._trees[factored]
        kind, given = self._given(tree, inputs, links, factored)
        tapes = self._tapes.setdefault(kind, [])
        count, rows = len(x), np.ascontiguousarray(x.T)
        is_good, pending = np.zeros(count, dtype=bool), np.arange(count)
        found: Found | None = None
        for index in range(_MOST_ORDERS):
            if index == len(tapes):
                chosen = pending[_spread(len(pending))]
                tapes.append(self._tape(tree, kind, rows[:, chosen]))
            own, holds = _closed_by(tapes[index], given, rows, pending, count)
            if found is None:
                found = own
                is_good[:] = holds
            else:
                for all_rows, some in zip(found, own, strict=True):
                    all_rows[pending[holds]] = some[holds]
                is_good[pending[holds]] = True
            pending = pending[~holds]
            if len(pending) < SHADOWS:
                break
        assert found is not None
        return found, is_good, tapes[0].moved

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
            found, is_good, moved = self.solve(x, inputs)
            if self._known is None:
                some = np.sort(_spread(len(x)))
                self._known = in_general(some)
            (left,) = np.nonzero(~is_good)
            if 2 * len(left) > len(x):
                return None
            if len(left):
                _write(found, left, in_general(left), moved)
        except (Unsuitable, AssemblyError, SingularConfigurationError):
            return None
        ratios = np.zeros((len(x), *moved.shape))
        rates, drives = np.nonzero(moved >= 0)
        ratios[:, rates, drives] = found.ratios[:, moved[rates, drives]]
        residuals = dynamics.residuals(
            found.x,
            inputs,
            JointRates(ratios, found.v, found.a),
            found.wrenches,
            found.efforts,
            found.couplings,
        )
        known = self._known
        return Solution(
            x=found.x,
            v=found.v,
            a=found.a,
            velocity_ratios=VelocityRatios.of(ratios, dynamics.depends),
            wrenches=found.wrenches,
            efforts=found.efforts,
            coupling_moments=found.couplings,
            magnification=None,
            cancellation=residuals.cancellation,
            closure_condition=np.full(len(x), known.closure_condition.max()),
            loop_error=np.maximum(found.error, residuals.loop_error),
            residuals=residuals,
            influence=known.influence,
            indeterminate_couplings=known.indeterminate_couplings,
        )

    def _tape(self, tree: Tree, kind: Kind, rows: Array) -> Tape:
        """Return a tape whose order is chosen at samples `(size, S)`."""
        roles, length = self._roles, tree.length
        shadows = {}
        for body in tree.bodies:
            for column in body.columns:
                shadows[column] = rows[column] / length if body.kind == "prismatic" else rows[column]
        at = placed(tree, shadows)
        moving = {*roles.drives, *roles.passives}
        order = pivots(passive_rows(closure_rows(tree, at, moving), roles))
        return Tape(
            self._problem, tree, roles, kind, self._bodies, order, shadows, self._varied
        )

    def _given(
        self, tree: Tree, inputs: Inputs, links: Mapping[str, LinkLoad], factored: tuple[str, ...]
    ) -> tuple[Kind, dict[str, Array | float]]:
        """Return the kind of some samples, and the inputs of its tapes but for coordinates."""
        length, roles = tree.length, self._roles
        units = np.ones(inputs.loads.shape[1])
        units[list(slides(tree))] = length
        given: dict[str, Array | float] = {}

        def put(name: str, columns: Array) -> tuple[bool, ...]:
            """Take columns `(n, k)` whose values are not rounding of zero beside all of them."""
            size = np.abs(columns)
            acts = size.max(axis=0) > 1e-15 * size.max(initial=0.0)
            for index in np.flatnonzero(acts).tolist():
                given[f"{name}{index}"] = columns[:, index]
            return tuple(acts.tolist())

        drive_units = units[list(roles.drives)]
        speeds = put("v", inputs.speeds / drive_units)
        accelerations = put("a", inputs.accelerations / drive_units)
        gravity = put("g", tree.in_axes(inputs.gravity) / length)
        efforts = inputs.loads / (length**2 / units)
        loads = tuple(np.flatnonzero(efforts.any(axis=0)).tolist())
        given |= {f"l{rate}": efforts[:, rate] for rate in loads}
        given |= {f"i{name}": inputs.inertia[name] for name in factored}
        stated = []
        for index, load in enumerate(links.values()):
            force, moment = load.force, load.moment
            rotation = None
            if load.in_world:
                force, moment = tree.in_axes(force), tree.in_axes(moment)
            else:
                rotation = tuple(map(tuple, load.rotation.T.tolist()))
            flags = put(f"f{index}_", force / length), put(f"m{index}_", moment / length**2)
            stated.append((load.body, rotation, tuple((load.place / length).tolist()), *flags))
        given |= self._offsets(tree, inputs, units)
        return Kind(speeds, accelerations, gravity, loads, tuple(stated), factored), given

    def _offsets(self, tree: Tree, inputs: Inputs, units: Array) -> dict[str, Array | float]:
        """Return the offsets of couplings, with the whole turns that coordinates lack."""
        if not tree.couplings:
            return {}
        mechanism = self._problem.mechanism
        column = {item.rate: item.column for item in mechanism.coordinates.named.values()}
        turns = {rate: 2.0 * np.pi * inputs.turns[:, at] for rate, at in column.items()}
        result: dict[str, Array | float] = {}
        pairs = zip(mechanism.couplings, tree.couplings, strict=True)
        for index, (stated, coupling) in enumerate(pairs):
            unit = units[coupling.successors[0]] if coupling.successors else 1.0
            offset: Array | float = stated.offset / unit
            for rate in coupling.predecessors:
                offset = offset + coupling.ratio * turns[rate]
            for rate in coupling.successors:
                offset = offset - turns[rate]
            result[f"o{index}"] = offset
        return result


def _closed_by(
    tape: Tape, given: Mapping[str, Array | float], rows: Array, lanes: Array, count: int
) -> tuple[Found, Array]:
    """Return what a tape finds of some lanes, and which of them it holds for."""
    is_all = len(lanes) == count
    own = given if is_all else _of(given, lanes, count)
    found, judged = tape.run(own, rows if is_all else rows[:, lanes], len(lanes))
    step, error, growth, narrowness = judged
    is_stable = (growth <= _GROWTH) & (narrowness <= REGULAR_CONDITION) & (step <= _STEP)
    for _ in range(_PASSES):
        (again,) = np.nonzero(is_stable & (step > _EXACT_STEP))
        if not len(again):
            break
        better, judged[:, again] = tape.run(
            _of(own, again, len(lanes)), np.ascontiguousarray(found.x[again].T), len(again)
        )
        for all_rows, some in zip(found, better, strict=True):
            all_rows[again] = some
        is_stable &= (growth <= _GROWTH) & (narrowness <= REGULAR_CONDITION)
    return found, is_stable & (step <= _EXACT_STEP) & (error <= tape.rounding)


def _write(found: Found, samples: Array, general: Solution, moved: Array) -> None:
    """Write what the general way found of some samples."""
    ratios = general.velocity_ratios
    assert ratios is not None and general.v is not None and general.a is not None
    found.x[samples], found.v[samples], found.a[samples] = general.x, general.v, general.a
    found.wrenches[samples], found.efforts[samples] = general.wrenches, general.efforts
    found.couplings[samples] = general.coupling_moments
    found.error[samples] = general.loop_error
    for rate, drive in zip(*np.nonzero(moved >= 0), strict=True):
        own = ratios.moved[rate, drive]
        values = ratios.values[:, own] if own >= 0 else 0.0
        found.ratios[samples, moved[rate, drive]] = values


def taped_solver(solver: ProblemSolver) -> TapedSolver | None:
    """Return what solves the samples of a scene by tapes; None where it has what they do not know.

    These are elements, teeth, rods that spin idly, compliances, and outputs that leave loops out.
    """
    problem, assembly = solver.problem, solver.assembly
    needed, kinematics = assembly.needed, assembly.kinematics
    closing = {
        index for index, group in enumerate(assembly.groups) if group.loops or group.couplings
    }
    if (
        problem.elements
        or problem.compliance
        or problem.mechanism.teeth
        or needed.efforts_alone
        or solver.unsolved
        or len(kinematics.idle_columns)
        or not closing <= set(needed.forces)
        or len(needed.motion) < len(assembly.groups)
    ):
        return None
    bodies = solver.inverse_dynamics.claimed
    return TapedSolver(problem, solver.varied, assembly.decided, bodies)


def _of(given: Mapping[str, Array | float], lanes: Array, count: int) -> dict[str, Any]:
    """Return the inputs of some lanes."""
    return {
        name: value[lanes] if np.size(value) == count > 1 else value
        for name, value in given.items()
    }


def _spread(count: int) -> Array:
    """Return indices of some of so many samples, in no regular order: multiples of the golden mean."""
    fractions = (np.arange(1, SHADOWS + 1) * 0.6180339887498949) % 1.0
    return (fractions * count).astype(int)
