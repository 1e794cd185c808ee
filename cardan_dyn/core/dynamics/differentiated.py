"""Differentiated: how what is found of samples changes with numbers that were given, exactly.

The equations of a closed sample are differentiated where they are traced. Forwards, coordinates x
change by -J⁻¹ ∂Φ/∂p, as the implicit function Φ(x, p) = 0 says; rates, accelerations and forces
follow by the chain rule. Backwards, weights of results become those of coordinates, these by J⁻ᵀ
those of closure errors, and all together those of the numbers that were given.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from ...kit.arrays import Array, generic, some
from ...kit.threads import in_turn
from ..elements.link_loads import LinkLoad
from ..kinematics.tolerances import REGULAR_CONDITION
from ..mechanics.bodies import Mass
from ..mechanics.elimination import THRESHOLD, Order, UnsuitableError
from ..mechanics.placements import moved as rates_of
from ..mechanics.placements import moving
from ..mechanics.reactions import momentum_rates
from ..mechanics.sample import (
    Given,
    LinkForce,
    Position,
    Solved,
    passive_rows,
    solved_at,
    stressed_at,
)
from ..mechanics.vectors import UNTURNED, ZERO, times
from ..mechanism.mechanism import Mechanism
from ..proof.derived import derived_errors
from ..tape import NOTHING, Differential, Factor, Scalar, Trace, Variable, greater
from .implicit import Implicit
from .inverse_dynamics import UNIQUE_TOLERANCE, Inputs, JointRates
from .parameters import (
    Numbers,
    OfColumn,
    OfDescription,
    OfElement,
    OfMass,
    OfOrigin,
    OfRow,
    Parameter,
    moved,
    slopes_of,
)
from .problem_solver import ProblemSolver
from .pushing import Pushing
from .tape import SAMPLES, Equations, Kind, Prescribed, Tape
from .taped import MOST_TAPES, TapedSolver, vectors

if TYPE_CHECKING:
    from ..proof.free_bodies import FreeBodies


class Part(NamedTuple):
    """Samples that one tape differentiates.

    Attributes:
        results: `(k, n)` of a run.
        columns: of it that hold; all if None.
        samples: which samples these are, likewise.
    """

    results: Array
    columns: Array | None = None
    samples: Array | None = None

    def holding(self, rows: int | slice) -> Array:
        """Return rows of the results at the samples that hold; others are those of another tape."""
        found = self.results[rows]
        return found if self.columns is None else found[..., self.columns]

    def put(self, values: Array, rows: Array, places: Array) -> None:
        """Write rows of the results into places of values `(…, N)`."""
        if self.columns is None or self.samples is None:
            values[places] = self.results[rows]
        else:
            values[places[:, None], self.samples] = self.results[rows[:, None], self.columns]


class Change(NamedTuple):
    """How what is found of N samples changes with a parameter, per its unit.

    Attributes:
        equations: whose results these are of; velocity ratios are `Samples.ratios`.
        samples: N.
        parts: of samples, and for each row of what is found the row of results that is how it
            changes, -1 where it does not.
        opened: greatest rate at which closure errors grow, in units of the mechanism.
        farthest: greatest rate of what loops decide, likewise.
        picked: which rows of what is found pick up self-stress while the parameter changes, so
            that how they change depends on what statics leaves open.
    """

    equations: Equations
    samples: int
    parts: Sequence[tuple[Part, Array]]
    opened: float
    farthest: float
    picked: Array

    def picks(self, field: str, columns: Any = slice(None)) -> Array:
        """Return which columns of a field of `Found` pick up self-stress."""
        return np.asarray(self.picked[self.equations.place(field)][columns])

    def of(self, field: str, columns: Any = slice(None)) -> Array:
        """Return changes of a field of `Found`, of some of its columns `(N, …)`."""
        return changes_of([self], field, columns)[:, :, 0]


def changes_of(changes: Sequence[Change], field: str, columns: Any = slice(None)) -> Array:
    """Return changes of a field of `Found` with k parameters that were asked for together.

    Those of some of its columns `(N, …, k)`.
    """
    first = changes[0]
    wanted = np.arange(first.equations.outputs)[first.equations.place(field)][columns]
    result = np.zeros((len(wanted), len(changes), first.samples))
    every = result.reshape(len(wanted) * len(changes), first.samples)
    for index, (part, _) in enumerate(first.parts):
        rows = np.column_stack([change.parts[index][1][wanted] for change in changes]).ravel()
        (places,) = np.nonzero(rows >= 0)
        part.put(every, rows[places], places)
    return result.transpose(2, 0, 1)


class Pattern(NamedTuple):
    """What of a sample may change.

    Attributes:
        parameters: with which numbers.
        seeded: rows of `Prescribed` that change besides, with what elements exert.
        weighted: rows of results that are weighted, where derivatives are found backwards; None
            where they are found forwards.
        what: is differentiated: what is found but velocity ratios, these alone, or a self-stress
            in place of what is found.
    """

    parameters: Sequence[Parameter]
    seeded: Sequence[int]
    weighted: Sequence[int] | None
    what: Literal["found", "ratios", "stress"] = "found"


class _Derivatives(Tape):
    """A tape that finds derivatives of closed samples by some parameters.

    Attributes:
        places: of each parameter, rows of results that are derivatives of all that is found, then
            of closure errors that are not made zero; -1 for zeros. Backwards, of what is weighted
            and of each such error, rows that are derivatives by parameters, then by seeded rows.
    """

    def __init__(
        self,
        equations: Equations,
        order: Order,
        shadows: Array,
        acting: Array,
        of: Pattern,
        origins: Callable[[Sequence[OfOrigin]], Mapping[str, Numbers]],
    ) -> None:
        """Trace the derivatives.

        Args:
            equations: that are differentiated.
            order: of the elimination.
            shadows: see `Tape`.
            acting: see `Tape`.
            of: what changes.
            origins: returns derivatives of numbers of the tree and of links, see `slopes_of`.
        """
        self.order, self.acting, self._shadows = order, acting, shadows
        in_turn()
        with Trace() as trace:
            own = [trace.input(f"p{k}", 0.0, uniform=True) for k in range(len(of.parameters))]
            tree, links, adding = equations.tree, equations.links, dict[int, list[Mass]]()
            slopes = origins([item for item in of.parameters if isinstance(item, OfOrigin)])
            for change, item in zip(own, of.parameters, strict=True):
                if isinstance(item, OfOrigin):
                    tree, links = moved((tree, links), slopes[item.name], change)
                elif isinstance(item, OfMass) and item.body >= 0:
                    adding.setdefault(item.body, []).extend(item.adds(change, tree.length))
            self.equations = equations.on(tree, links)
            # What changes of masses exert acts on their bodies; what opens loops is closed again.
            pushed = {
                body: [trace.input(f"z{body}.{k}", 0.0, uniform=True) for k in range(6)]
                for body in adding
            }
            count = 6 * len(tree.loops) + len(tree.couplings) + len(tree.spins)
            opened = [trace.input(f"e{row}", 0.0, uniform=True) for row in range(count)]
            zeros = len(trace.inputs)
            marks = [trace.input(name, 1.0, uniform=True) for name in ("found", "held")]
            self._fixed = np.repeat([[0.0], [1.0]], [zeros, len(marks)], axis=0)
            given, x, _ = self.traced(trace)
            position = Position.of(tree, equations.roles, given.x, given.offsets, order)
            closed = position
            matrix = passive_rows(position.rows, equations.roles)
            factors = Implicit.of(position.factors, matrix, opened, marks)
            position = position._replace(factors=factors)
            pushes = [LinkForce(k, UNTURNED, ZERO, x[:3], x[3:]) for k, x in pushed.items()]
            loaded = given._replace(link_forces=[*given.link_forces, *pushes])
            roles = equations.roles
            if of.what == "stress":
                solved = stressed_at(position, tree, roles)
            elif of.what == "ratios":
                solved = Solved.moving(position, position.ratios(roles), {}, {})
            else:
                solved = solved_at(position, tree, roles, loaded, has_ratios=False)
            differential, inputs = Differential(trace), trace.inputs
            variables = [
                inputs[item.input] if isinstance(item, OfColumn | OfRow) else change
                for change, item in zip(own, of.parameters, strict=True)
            ]
            rows = [inputs[f"r{row}"] for row in of.seeded]
            free = {each: differential.free() for each in dict.fromkeys([*variables, *rows])}
            by, seeded = [free[each] for each in variables], [free[each] for each in rows]
            changes = dict(free)
            masses = {
                own[k]: differential.sum([(Factor(given.factors.get(item.link, 1.0)), by[k])])
                for k, item in enumerate(of.parameters)
                if isinstance(item, OfMass)
            }
            for body, exerted in self._exerted(adding, position, given, solved).items():
                ways = differential.tangents(exerted, masses)
                changes |= zip(pushed[body], ways, strict=True)
            self._close(differential, closed, inputs, opened, changes)
            factors.differentiated(differential, changes)
            found = self.equations.quantities(solved, x)
            errors = [position.errors[row] for row in position.factors.redundant]
            # Which nothing else depends on.
            ends = [
                differential.sum([(Factor(1.0), way)])
                for way in differential.tangents([*found, *errors], changes)
            ]
            unstable = greater(solved.growth * THRESHOLD, solved.narrowness / REGULAR_CONDITION)
            directions: list[dict[int, Scalar]] = []
            if of.weighted is None:
                for k, way in enumerate(by):
                    seeds = {row: trace.input(f"s{k}.{row}", 1.0) for row in seeded}
                    directions.append({**seeds, way: seeds.get(way, 0.0) + 1.0})
                written = differential.forwards(directions, ends, [unstable])
            else:
                weights = {ends[row]: trace.input(f"w{row}", 1.0) for row in of.weighted}
                directions = [weights, *({end: 1.0} for end in ends[len(found) :])]
                for each in directions:
                    each.pop(NOTHING, None)
                written = differential.backwards(directions, [*by, *seeded], [unstable])
            self._program, self.places = written

    def _exerted(
        self,
        adding: Mapping[int, Sequence[Mass]],
        position: Position,
        given: Given,
        solved: Solved,
    ) -> dict[int, list[Scalar]]:
        """Return body to what masses exert that are added to it, about and in axes of its frame."""
        if not adding:
            return {}
        tree, at = self.equations.tree, position.at
        bodies = [
            body._replace(masses=tuple(adding.get(index, ())))
            for index, body in enumerate(tree.bodies)
        ]
        motion = moving(tree, at, solved.v, solved.a, times(given.gravity, -1.0))
        carried = momentum_rates(tree._replace(bodies=tuple(bodies)), motion, {})
        return {
            body: [-value for value in (*carried.forces[body], *carried.moments[body])]
            for body in adding
        }

    def _close(
        self,
        differential: Differential,
        position: Position,
        inputs: Mapping[str, Variable],
        opened: Sequence[Variable],
        changes: dict[Variable, int],
    ) -> None:
        """Let coordinates change so that loops stay closed, and rods turn with their ends.

        Args:
            differential: which is written.
            position: that is closed.
            inputs: of the trace.
            opened: those in place of how far loops are opened.
            changes: of inputs; those of coordinates are added.
        """
        tree = self.equations.tree
        passives, units = set(self.equations.roles.passives), self.equations.units
        bodies = [body for body in tree.bodies if passives.issuperset(body.rates)]
        ends = len(opened) - len(tree.spins), len(opened)
        for rows in filter(len, (range(ends[0]), range(*ends))):
            opening = differential.tangents([position.errors[row] for row in rows], changes)
            closing = {
                opened[row]: differential.sum([(Factor(-1.0), way)])
                for row, way in zip(rows, opening, strict=True)
            }
            step = position.factors.solve([x if x in closing else 0.0 for x in opened])
            moves = [rates_of(body, position.x, step) for body in bodies]
            rates = {column: rate for each in moves for column, rate in each.items()}
            ways = differential.tangents([*rates.values()], closing)
            for column, way in zip(rates, ways, strict=True):
                x = inputs[f"x{column}"]
                own = (Factor(units[column]), way), (Factor(1.0), changes.get(x, NOTHING))
                changes[x] = differential.sum(own)

    def derivatives(
        self, rows: Prescribed, x: Array, others: Sequence[Array]
    ) -> tuple[Array, Array]:
        """Return results of n samples `(k, n)`, see `places`, and where they hold `(n,)`.

        Args:
            rows: what is given.
            x: `(size, n)` closed coordinates.
            others: inputs that derivatives take besides, `(k, n)` or `(k, 1)`.
        """
        given = [self._fixed, *self.with_x(rows, x), *others]
        results = self._program.run_rows(given, x.shape[1])
        return results, results[0] <= 1.0


class Samples:
    """Closed samples and all that acts on them.

    Attributes:
        equations: of these samples.
        first_effort: row of `Prescribed` in which efforts begin.
    """

    def __init__(
        self,
        taped: TapedSolver,
        x: Array,
        inputs: Inputs,
        links: Sequence[tuple[str, LinkLoad]],
        moves_alone: bool = False,
    ) -> None:
        """Keep them.

        Args:
            taped: solves them.
            x: `(N, size)` coordinates.
            inputs: what is prescribed.
            links: names of links, and all wrenches on them, what elements exert included.
            moves_alone: whether the motion is wanted without forces.
        """
        self._taped, self._x = taped, np.ascontiguousarray(x.T)
        self._inputs, self._links, self._moves_alone = inputs, links, moves_alone
        self._kind = self._kind_at(taped.problem.mechanism)
        self.equations = taped.equations_of(self._kind)
        offsets = taped.offsets(self.equations.tree, inputs.turns)
        loads = vectors([load for _, load in links])
        self._rows = Prescribed.of(inputs, loads, offsets, self._kind)
        self.first_effort = 2 * len(inputs.speeds[0]) + 3

    def _kind_at(self, mechanism: Mechanism) -> Kind:
        """Return the kind of the samples, in a mechanism whose joints lie elsewhere."""
        loads = []
        for name, load in self._links:
            _, frame = mechanism.link_frame(name)
            loads.append(replace(load, rotation=frame.rotation, translation=frame.translation))
        return self._taped.kind_of(self._inputs, loads, self._moves_alone)

    def _origins(self, items: Sequence[OfOrigin]) -> Mapping[str, Numbers]:
        """Return derivatives of numbers of the tree and of links, see `slopes_of`."""
        taped, mechanism = self._taped, self._taped.problem.mechanism
        loaded = tuple(name for name, _ in self._links)

        def numbers_at(of: Mechanism) -> Numbers:
            return taped.tree_at(of, self._kind.factored), self._kind_at(of).links

        key = taped.key, self._kind, loaded
        known = mechanism.kept.of("slopes", key, dict[str, Numbers])
        known |= slopes_of([x for x in items if x.name not in known], mechanism, numbers_at)
        return known

    def changes(
        self, parameters: Sequence[Parameter], seeds: Sequence[Mapping[int, Array]] = ()
    ) -> list[Change]:
        """Return how the samples change with each parameter.

        Args:
            parameters: some.
            seeds: for each, rows of `Prescribed` to how they change with it besides, `(N,)`; the
                same rows for all.
        """
        seeded = tuple(seeds[0]) if seeds else ()
        others = [np.reshape([*of.values()], (-1, self._x.shape[1])) for of in seeds]
        of = Pattern(parameters, seeded, None)
        runs = self._runs(of, others)
        changes, count = [], self._x.shape[1]
        opened = _greatest(runs, slice(self._found, None)).max(axis=1, initial=0.0)
        moved = map(self._farthest, _greatest(runs, self._places))
        every = zip(opened, moved, self.picked(parameters), strict=True)
        for k, own in enumerate(every):
            parts = [(part, tape.places[k]) for tape, part in runs]
            changes.append(Change(self.equations, count, parts, *own))
        return changes

    def ratios(self, parameter: Parameter) -> Array:
        """Return how velocity ratios change with a parameter `(N, nv d)`.

        Each drive takes as many operations for them as all velocities together.
        """
        runs = self._runs(Pattern([parameter], (), None, "ratios"), ())
        parts = [(part, tape.places[0]) for tape, part in runs]
        none = np.zeros(self._found, dtype=bool)
        return Change(self.equations, self._x.shape[1], parts, 0.0, 0.0, none).of("ratios")

    @property
    def _found(self) -> int:
        """Number of rows of all that is found."""
        return self.equations.place("rests").stop

    @property
    def _places(self) -> slice:
        """Rows of coordinates."""
        return self.equations.place("x")

    def _farthest(self, rates: Array) -> float:
        """Return the greatest rate of coordinates, in units of the mechanism."""
        return float((rates / self.equations.units).max(initial=0.0))

    def picked(self, parameters: Sequence[Parameter]) -> list[Array]:
        """Return `Change.picked` of each parameter.

        Forces are known up to multiples of a self-stress S, in which all take part here. A result
        c of them is unique if c S = 0; then how it changes is if c S′ = 0 as well.
        """
        none = np.zeros(len(self._sizes), dtype=bool)
        picked = [none] * len(parameters)
        turning = [k for k, item in enumerate(parameters) if isinstance(item, OfColumn | OfOrigin)]
        if not (turning and self.equations.are_stressed):
            return picked
        own = [parameters[k] for k in turning]
        runs = self._runs(Pattern(own, (), None, "stress"), (), self._some)
        for k, item, told in zip(turning, own, _greatest(runs), strict=True):
            rates = told[: self._found] * self._sizes
            # Rounding of how it turns is beside how fast all of it does.
            least = max(self._inverse_unit(item), self._farthest(told[self._places]), rates.max())
            picked[k] = self._with_teeth(~(rates <= UNIQUE_TOLERANCE * least))
        return picked

    def picking(self, parameters: Sequence[Parameter], rows: Collection[int]) -> list[str]:
        """Return names of parameters with which any of some rows of results picks up self-stress.

        None of the parameters opens a loop.
        """
        own = [item for item in parameters if isinstance(item, OfColumn | OfOrigin)]
        asked, sizes = [*rows], np.zeros(len(self._sizes))
        sizes[asked] = self._sizes[asked]
        if not (own and sizes.any() and self.equations.are_stressed):
            return []
        couplings = self.equations.place("couplings")
        sizes[couplings] = self._sizes[couplings]  # Which teeth may press with.
        (weighted,) = sizes.nonzero()
        # A sum of all with generic weights tells, backwards, which parameters are worth a look.
        generics = generic(len(weighted), 1) * sizes[weighted, None]
        of = Pattern(own, (), tuple(weighted.tolist()), "stress")
        rates = _greatest(self._runs(of, [generics], self._some))[0]
        units = np.array([self._inverse_unit(item) for item in own])
        doubtful = [own[k] for k in np.flatnonzero(~(rates <= UNIQUE_TOLERANCE * units))]
        picked = zip(doubtful, self.picked(doubtful), strict=True)
        return [item.name for item, of in picked if of[asked].any()]

    @property
    def _some(self) -> Array:
        """Samples that tell what is open: what is unique at some is wherever tapes hold."""
        return some(self._x.shape[1], SAMPLES)

    @cached_property
    def _sizes(self) -> Array:
        """What brings rows of a self-stress of size one to that of moments; zero for motion."""
        equations, coordinates = self.equations, self._taped.problem.mechanism.coordinates
        tree, sizes = equations.tree, np.zeros(self._found)
        if self._moves_alone:
            return sizes
        lengths = np.repeat([tree.norm_length * tree.length, 1.0], 3)
        sizes[equations.place("wrenches")] = np.tile(lengths, equations.wrenches)
        # No self-stress is in what drives exert: their motion does work on none.
        held = [equations.place("efforts").start + rate for rate in equations.roles.held]
        sizes[held] = coordinates.rate_scale[[*equations.roles.held]]
        sizes[equations.place("couplings")] = 1.0
        return sizes / tree.length**2

    def _inverse_unit(self, item: Parameter) -> float:
        """Return one over an amount that changes a mechanism by about its own size."""
        if isinstance(item, OfOrigin):
            return 1.0 / item.unit
        scale = self._taped.problem.mechanism.coordinates.scale
        return float(scale[item.column]) if isinstance(item, OfColumn) else 1.0

    def _with_teeth(self, picked: Array) -> Array:
        """Return rows with all of joints that teeth press on whose moment is among them."""
        mechanism, equations = self._taped.problem.mechanism, self.equations
        wrenches = picked[equations.place("wrenches")].reshape(-1, 6)  # A view.
        for teeth in mechanism.teeth:
            if picked[equations.place("couplings")][teeth.coupling]:
                wrenches[[mechanism.wrench_indices[name] for name in teeth.joints]] = True
        return picked

    def slopes(
        self, parameters: Sequence[Parameter], weights: Mapping[int, Array]
    ) -> tuple[Array, Array]:
        """Return derivatives of weighted results by parameters, see `Differentiated.slopes`."""
        runs = self._weighted(parameters, weights, ())
        slopes = np.zeros(len(parameters))
        for tape, part in runs:
            (written,) = np.nonzero(tape.places[0] >= 0)
            slopes[written] += part.holding(slice(None)).sum(axis=1)[tape.places[0][written]]
        return slopes, _greatest(runs, of=slice(1, None)).max(axis=0, initial=0.0)

    def acting(self, weights: Mapping[int, Array], rows: Sequence[int]) -> Array:
        """Return derivatives of weighted results by rows of `Prescribed`, `(k, N)`."""
        result = np.zeros((len(rows), self._x.shape[1]))
        for tape, part in self._weighted((), weights, rows):
            (written,) = np.nonzero(tape.places[0] >= 0)
            part.put(result, tape.places[0][written], written)
        return result

    def _weighted(
        self,
        parameters: Sequence[Parameter],
        weights: Mapping[int, Array],
        seeded: Sequence[int],
    ) -> list[tuple[_Derivatives, Part]]:
        """Return what tapes find of results (rows), each times its weights `(N,)`."""
        of = Pattern(parameters, seeded, tuple(weights))
        return self._runs(of, [np.reshape([*weights.values()], (-1, self._x.shape[1]))])

    def _runs(
        self, of: Pattern, others: Sequence[Array], samples: Array | None = None
    ) -> list[tuple[_Derivatives, Part]]:
        """Return tapes, and what each finds of samples.

        Args:
            of: what changes.
            others: what they take besides.
            samples: which ones, ascending; all if None.
        """
        count, kept = self._x.shape[1], self._taped.problem.mechanism.kept
        acting = self._rows.acting()
        acting[[*of.seeded, *[item.row for item in of.parameters if isinstance(item, OfRow)]]] = (
            True
        )
        names = tuple(item.name for item in of.parameters)
        loaded = tuple(name for name, _ in self._links)
        weighted = None if of.weighted is None else tuple(of.weighted)
        changing = names, loaded, tuple(of.seeded), weighted, acting.tobytes()
        key = self._taped.key, self._kind, *changing, of.what
        runs: list[tuple[_Derivatives, Part]] = []
        is_left = np.zeros(count, dtype=bool)
        is_left[slice(None) if samples is None else samples] = True
        for order, shadows, lanes, is_own in self._orders(np.flatnonzero(is_left)):
            chosen = lanes[is_left[lanes]]
            if not len(chosen):
                continue
            # What compliances decide is chosen where a tape is traced, see `orders_at`.
            at = b"" if is_own and not self.equations.roles.compliances else shadows.tobytes()
            own = *key, tuple(order.places), at
            make = partial(_Derivatives, self.equations, order, shadows, acting, of, self._origins)
            try:
                tape = kept.of("derivatives", own, make)
            except UnsuitableError:
                if is_own:
                    raise
                continue
            if len(chosen) == count:
                results, holds = tape.derivatives(self._rows, self._x, others)
            else:
                x, *more = _of_lanes(chosen, [self._x, *others], count)
                results, holds = tape.derivatives(self._rows.of_lanes(chosen, count), x, more)
            holds |= is_own
            if len(chosen) == count and holds.all():
                return [(tape, Part(results))]
            (held,) = holds.nonzero()
            runs.append((tape, Part(results, held, chosen[held])))
            is_left[chosen[held]] = False
            if not is_left.any():
                break
        return runs

    def _orders(self, samples: Array) -> Iterator[tuple[Order, Array, Array, bool]]:
        """Yield orders of elimination, where they were chosen, and samples that they may be for.

        First those of all samples, at last those that are chosen at each sample itself, which the
        last number tells.
        """
        orders = self._taped.orders
        for index in range(MOST_TAPES):
            chosen = orders and orders.at(index)
            if chosen:
                yield chosen.order, chosen.at, samples, False
        for own in self._taped.orders_at(self.equations, self._x):
            yield *own, True


def _greatest(
    runs: Sequence[tuple[_Derivatives, Part]],
    found: slice = slice(None),
    of: slice = slice(None),
) -> Array:
    """Return the greatest magnitudes at all samples of some of what tapes find, see `places`."""
    result = np.zeros(runs[0][0].places[of, found].shape)
    for tape, part in runs:
        places = tape.places[of, found]
        written = places >= 0
        rows = map(part.holding, places[written].tolist())  # Views, where all samples hold.
        most = [np.maximum(row.max(initial=0.0), -row.min(initial=0.0)) for row in rows]
        result[written] = np.maximum(result[written], most)
    return result


def _of_lanes(lanes: Array, parts: Sequence[Array], count: int) -> list[Array]:
    """Return rows of some of so many samples."""
    return [part[:, lanes] if part.shape[1] == count else part for part in parts]


class Differentiated:
    """Closed samples of a scene, differentiated with all that its elements exert."""

    def __init__(self, solver: ProblemSolver, x: Array, v: Array, inputs: Inputs) -> None:
        """Keep them.

        Args:
            solver: of the scene.
            x: `(N, size)` closed coordinates.
            v: `(N, nv)` their velocities, which are read where there are elements.
            inputs: what is prescribed.
        """
        mechanism, elements = solver.problem.mechanism, solver.problem.elements
        taped = solver.taped
        self._solver, self._x, self._inputs = solver, x, inputs
        links = [(name, load) for name, load in inputs.link_loads.items() if load.body >= 0]
        self._pushing: Pushing | None = None
        if elements:
            self._moving = Samples(taped, x, inputs, links, moves_alone=True)
            turned = x + 2.0 * np.pi * inputs.turns
            self._pushing = Pushing(mechanism, elements, turned, v, inputs.time)
            acted = self._pushing.acted()
            first = 6 * len(links) + mechanism.model.nv
            inputs = inputs._replace(loads=inputs.loads + acted.efforts)
            names = [wrench.link for wrench in acted.wrenches]
            links = [*links, *zip(names, acted.link_loads(mechanism), strict=True)]
            own = [*range(mechanism.model.nv), *range(first, first + 6 * len(names))]
        self._samples = Samples(taped, x, inputs, links)
        if elements:
            self._exerted = [self._samples.first_effort + row for row in own]

    def row(self, field: str, column: int) -> int:
        """Return which row of results a column of a field of `Found` is, for `slopes`."""
        place = self._samples.equations.place(field)
        return range(place.start, place.stop)[column]

    def changes(self, parameters: Sequence[Parameter]) -> list[Change]:
        """Return how the samples change with each parameter."""
        if self._pushing is None:
            return self._samples.changes(parameters)
        moved = zip(parameters, self._moving.changes(parameters), strict=True)
        every = np.zeros((len(parameters), len(self._exerted), len(self._x)))
        for own, (item, of) in zip(every, moved, strict=True):
            own += self._pushing.change(item, of.of("x"), of.of("v"))
        acting = np.flatnonzero(every.any(axis=(0, 2)))
        return self._samples.changes(
            parameters, [{self._exerted[k]: own[k] for k in acting} for own in every]
        )

    def ratios(self, parameter: Parameter) -> Array:
        """See `Samples.ratios`."""
        return self._samples.ratios(parameter)

    def slopes(
        self, parameters: Sequence[Parameter], weights: Mapping[int, Array]
    ) -> tuple[Array, Array]:
        """Return derivatives of a weighted sum of results over all samples.

        Args:
            parameters: some.
            weights: rows of results, see `Found`, to their weights, `(N,)`.

        Returns:
            `(k,)` derivatives, and for each the greatest rate at which closure errors grow.
        """
        more = np.zeros(len(parameters))
        if self._pushing is not None:
            acting = self._samples.acting(weights, self._exerted)
            weights = dict(weights)
            still = [np.zeros_like(part) for part in (self._pushing.x, self._pushing.v)]
            for field, values in zip(("x", "v"), still, strict=True):
                for column in range(values.shape[1]):
                    values[:, column] = 1.0
                    own = (acting * self._pushing.change(None, *still)).sum(axis=0)
                    values[:, column] = 0.0
                    if own.any():
                        row = self.row(field, column)
                        weights[row] = weights.get(row, 0.0) + own
            for k, item in enumerate(parameters):
                if isinstance(item, OfOrigin | OfElement):
                    more[k] = np.sum(acting * self._pushing.change(item, *still))
        slopes, opened = self._samples.slopes(parameters, weights)
        return slopes + more, opened

    def picking(self, parameters: Sequence[Parameter], rows: Collection[int]) -> list[str]:
        """See `Samples.picking`."""
        return self._samples.picking(parameters, rows)

    def residuals(self, parameter: Parameter, change: Change) -> tuple[float, float]:
        """Return how fast loops open and bodies lose balance, by the proof; see `Derivative`.

        Args:
            parameter: by which the samples are differentiated.
            change: what was found of it.
        """
        solver, x, inputs = self._solver, self._x, self._inputs
        problem, dynamics = solver.problem, solver.inverse_dynamics
        mechanism, kinematics = problem.mechanism, solver.assembly.kinematics
        found = solver.taped.found(x, inputs, lambda samples: kinematics.evaluate(x[samples]))[0]
        if isinstance(parameter, OfColumn):
            columns = mechanism.coordinates.columns_of([*problem.independent, *problem.held])
            changed = inputs.changed(prescribed=columns.index(parameter.column))
        else:
            changed = inputs.changed(parameter.row if isinstance(parameter, OfRow) else -1)
        claims = []
        for own, read, ratios in (
            (inputs, partial(getattr, found), found.ratios),
            (changed, change.of, self.ratios(parameter)),
        ):
            v = read("v")
            rates = JointRates(ratios.reshape(*v.shape, -1), v, read("a"))
            wrenches = read("wrenches").reshape(len(x), -1, 6)
            of_joints = wrenches, read("efforts"), read("couplings")
            claims.append(dynamics.claim(read("x"), own, rates, *of_joints))
        claim, rate = claims
        others, placed = [], None
        if isinstance(parameter, OfDescription):

            def changed_by(amount: float) -> FreeBodies:
                described = parameter.changed(mechanism.second_reading, amount)
                return dynamics.bodies_of(described, problem.elements)

            if isinstance(parameter, OfOrigin):
                placed = changed_by
            others = [
                (changed_by(node), weight)
                for node, weight in zip(parameter.nodes, parameter.weights, strict=True)
            ]
        elif isinstance(parameter, OfElement):
            for end, sign in zip(parameter.ends, (1.0, -1.0), strict=True):
                elements = parameter.among(problem.elements, end)
                bodies = dynamics.bodies_of(mechanism.second_reading, elements)
                others.append((bodies, sign / parameter.step))
        along = self._pushing and self._pushing.along(parameter, rate.x, rate.v)
        opened, lost = derived_errors(dynamics.bodies, claim, rate, others, along, placed)
        length, coordinates = mechanism.characteristic_length, mechanism.coordinates
        lengths = np.repeat([length, 1.0], 3)
        greatest, size = (
            max(
                np.abs(of.wrenches * lengths).max(initial=0.0),
                np.abs(of.exerted * coordinates.rate_scale).max(initial=0.0),
            )
            for of in claims
        )
        fastest, faster, harder = (
            np.abs(rates / coordinates.rate_scale).max(initial=0.0)
            for rates in (claim.v, rate.v, rate.a)
        )
        # What cancels is of the size of what there is, and of what all bodies together would exert.
        ways = np.abs(rate.x * coordinates.scale).max(initial=0.0)
        # Dampers exert as much by what is fast, of which differences tell.
        size += greatest * max(ways, faster / max(1.0, fastest) if problem.elements else 0.0)
        mass = sum(link.mass for link in mechanism.description.links)
        size += mass * length**2 * (harder + 2.0 * fastest * faster)
        if isinstance(parameter, OfDescription | OfElement):
            step = parameter.step if isinstance(parameter, OfElement) else parameter.nodes[0]
            size += greatest / abs(step)
        return opened, float(lost / size) if size else float("nan")
