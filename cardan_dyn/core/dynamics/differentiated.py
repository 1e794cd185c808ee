"""Differentiated: how what is found of samples changes with numbers that were given, exactly.

The equations of a sample are differentiated where they are traced. At closed coordinates x their
step of Newton's method ends at x - J⁻¹ Φ(x, p), and its derivative with x kept is -J⁻¹ ∂Φ/∂p, that
of the implicit function Φ(x, p) = 0; rates, accelerations and forces follow by the chain rule.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ...kit.arrays import EPS, Array, blocks
from ...kit.differences import slope
from ...kit.errors import ModelError
from ..elements.element import Element
from ..elements.element_forces import Acted, ElementForces
from ..elements.link_loads import LinkLoad
from ..mechanics import closure
from ..mechanics.bodies import Mass, Tree
from ..mechanics.elimination import Order, UnsuitableError
from ..mechanics.placements import placed
from ..mechanism.mechanism import Mechanism
from ..tape import Program, Scalar, Trace, Variable, tangents
from .inverse_dynamics import Inputs
from .tape import Equations, Found, Kind, LinkKind, Prescribed, Tape
from .taped import MOST_TAPES, TapedSolver, vectors

_TOLD = Found._fields.index("x") - Found._fields.index("failure")
"""Rows in which a tape tells of itself."""


@dataclass(frozen=True)
class Parameter:
    """A number by which samples are differentiated.

    Attributes:
        name: as it was asked for.
    """

    name: str


@dataclass(frozen=True)
class OfColumn(Parameter):
    """A driven or held coordinate [rad or m], by its column."""

    column: int


@dataclass(frozen=True)
class OfRow(Parameter):
    """A number among what is prescribed, by its row in `Prescribed`."""

    row: int


@dataclass(frozen=True)
class OfMass(Parameter):
    """Mass, centre or inertia of a link.

    Attributes:
        link: its name.
        body: index of the body that carries the link.
        adds: returns the masses that a change adds, by the change and the unit of length.
    """

    link: str
    body: int
    adds: Callable[[Scalar, float], tuple[Mass, ...]]


@dataclass(frozen=True)
class OfOrigin(Parameter):
    """A length or an angle in the placement of a joint.

    Attributes:
        displaced: returns the mechanism in which it is greater by some amount [m or rad].
        unit: amount that changes a mechanism by about its own size.
        nodes, weights: amounts, and the sum of weighted numbers there that is the derivative of all
            numbers of a tree: of polynomials of second degree in a length, of trigonometric ones
            in an angle, which products of two rotations are.
    """

    displaced: Callable[[float], Mechanism]
    unit: float
    nodes: tuple[float, ...]
    weights: tuple[float, ...]

    @classmethod
    def of_length(cls, name: str, displaced: Callable[[float], Mechanism], far: float) -> OfOrigin:
        """Return one of a length, whose numbers are compared at places that far away [m]."""
        return cls(name, displaced, far, (far, -far), (0.5 / far, -0.5 / far))

    @classmethod
    def of_angle(cls, name: str, displaced: Callable[[float], Mechanism]) -> OfOrigin:
        """Return one of an angle."""
        nodes = tuple(np.pi / 4.0 * k for k in (1, 3, -3, -1))
        weights = tuple(
            sign / (8.0 * np.sin(node / 2.0) ** 2)
            for sign, node in zip((1.0, -1.0, 1.0, -1.0), nodes, strict=True)
        )
        return cls(name, displaced, 1.0, nodes, weights)

    def slopes(
        self, numbers_at: Callable[[Mechanism], tuple[Tree, tuple[LinkKind, ...]]]
    ) -> tuple[Any, Any]:
        """Return the derivatives of all numbers of a tree and of links, in their structure.

        Args:
            numbers_at: returns those of a mechanism.

        Raises:
            ModelError: the tree has numbers of other kinds.
        """
        numbers = [numbers_at(self.displaced(node)) for node in self.nodes]
        tree = numbers[0][0]
        if tree.spins or tree.gears:
            raise ModelError(
                f"{self.name}: the lines of idle rods and the teeth of gears depend on it, of "
                "which derivatives are not known; of gears, make the joint adjustable and "
                "differentiate by its coordinate; of rods, drive or hold their spins"
            )
        of_tree, of_links = _slope(numbers, self.weights)
        return of_tree, of_links


def _slope(values: Sequence[Any], weights: Sequence[float]) -> Any:
    """Return a weighted sum of numbers in nested tuples and arrays; 0.0 where rounding is left."""
    first = values[0]
    if isinstance(first, tuple):
        return tuple(_slope(items, weights) for items in zip(*values, strict=True))
    if isinstance(first, np.ndarray):
        return _slope([tuple(value.tolist()) for value in values], weights)
    if isinstance(first, list):
        return _slope([tuple(value) for value in values], weights)
    if not isinstance(first, float):
        return 0.0
    terms = [value * weight for value, weight in zip(values, weights, strict=True)]
    result = sum(terms)
    return result if abs(result) > 4.0 * EPS * sum(map(abs, terms)) else 0.0


def _moved(value: Any, slope: Any, change: Scalar) -> Any:
    """Return numbers in nested tuples and arrays, which change by some times their slopes."""
    if isinstance(value, tuple):
        items = [_moved(*pair, change) for pair in zip(value, slope, strict=True)]
        return type(value)(*items) if hasattr(value, "_fields") else tuple(items)
    if isinstance(value, np.ndarray):
        if not np.any(slope):
            return value
        return np.array(_moved(tuple(map(tuple, value.tolist())), slope, change), dtype=object)
    return value + change * slope if slope else value


@dataclass(frozen=True)
class OfElement(Parameter):
    """A number of an element, in which what it exerts is linear.

    Attributes:
        element: its index.
        ends: elements in its place whose numbers differ by `step`.
    """

    element: int
    ends: tuple[Element, Element]
    step: float


class _Pushing(NamedTuple):
    """What elements exert at samples.

    Attributes:
        mechanism: on which.
        elements: all of them.
        x, v: `(n, size)` and `(n, nv)` of the samples; angles count whole turns.
        time: `(n,)` or `(1,)`.
        units: `(size,)` and `(nv,)` of coordinates and velocities: the length for slides, else 1.
    """

    mechanism: Mechanism
    elements: tuple[Element, ...]
    x: Array
    v: Array
    time: Array
    units: tuple[Array, Array]

    def acted(self) -> Acted:
        """Return what they exert."""
        return ElementForces(self.mechanism, self.elements).at(self.x, self.v, self.time)

    def rows(self) -> Array:
        """Return it as rows `(k, n)`, in the order of `Prescribed`: efforts, wrenches on links."""
        acted = self.acted()
        every = [acted.efforts]
        every += [part for wrench in acted.wrenches for part in (wrench.force, wrench.moment)]
        count = len(acted.efforts)
        return np.concatenate([np.broadcast_to(part, (count, part.shape[1])).T for part in every])

    def change(self, parameter: Parameter, x: Array, v: Array) -> Array:
        """Return how the rows change with a parameter.

        Args:
            parameter: which.
            x: how coordinates change with it.
            v: how velocities do.
        """
        # In units of what the farthest goes.
        fastest = np.maximum(1.0, np.abs(self.v / self.units[1]).max(axis=1, initial=0.0))
        ways = np.abs(x / self.units[0]).max(axis=1, initial=0.0)
        far = np.maximum(ways, np.abs(v / self.units[1]).max(axis=1, initial=0.0) / fastest)
        if isinstance(parameter, OfOrigin):
            far[:] = np.max(far, initial=1.0 / parameter.unit)
        far[far == 0.0] = 1.0

        def moved(at: float) -> Array:
            by = (at / far)[:, None]
            result = self._replace(x=self.x + by * x, v=self.v + by * v)
            if isinstance(parameter, OfOrigin):
                result = result._replace(mechanism=parameter.displaced(at / float(far[0])))
            return result.rows()

        moves = np.any(x) or np.any(v) or isinstance(parameter, OfOrigin)
        change = slope(moved) * far if moves else np.zeros_like(self.rows())
        if isinstance(parameter, OfElement):
            more, less = (self._with(parameter.element, end) for end in parameter.ends)
            change += (more.rows() - less.rows()) / parameter.step
        return change

    def _with(self, index: int, element: Element) -> _Pushing:
        """Return it with another element in place of one."""
        return self._replace(
            elements=(*self.elements[:index], element, *self.elements[index + 1 :])
        )


class Change(NamedTuple):
    """How what was found of N samples changes with a parameter, per its unit.

    Attributes:
        x: `(N, size)` coordinates.
        v, a: `(N, nv)` velocities and accelerations.
        ratios: `(N, nv d)` velocity ratios.
        wrenches: `(N, 6 b)`.
        efforts: `(N, nv)` what drives and held joints exert.
        couplings: `(N, G)` moments.
        opened: `(N,)` rate at which closure errors grow, in units of the mechanism.
    """

    x: Array
    v: Array
    a: Array
    ratios: Array
    wrenches: Array
    efforts: Array
    couplings: Array
    opened: Array


class _Differentiated(Tape):
    """A tape that finds how all that the equations find changes with some parameters."""

    def __init__(
        self,
        equations: Equations,
        order: Order,
        shadows: Array,
        acting: Array,
        parameters: Sequence[Parameter],
        seeded: Sequence[int],
        numbers_at: Callable[[Mechanism], tuple[Tree, tuple[LinkKind, ...]]],
    ) -> None:
        """Trace the derivatives.

        Args:
            equations: that are differentiated.
            order: of the elimination.
            shadows: see `Tape`.
            acting: see `Tape`.
            parameters: by which results are differentiated.
            seeded: rows that change with every parameter, as runs say.
            numbers_at: returns the tree, and the links that wrenches act on, of a mechanism in
                which joints lie elsewhere.
        """
        self._order, self.acting, self._shadows = order, acting, shadows
        rounding = equations.rounding(dict(enumerate(shadows)))
        with Trace() as trace:
            changes = [trace.input(f"p{k}", 0.0, uniform=True) for k in range(len(parameters))]
            tree, links = _changed(equations, parameters, changes, numbers_at)
            self._equations, self._count = equations.on(tree, links), len(parameters)
            given, x, left_out = self._traced(trace)
            outputs = self._equations.results(given, x, order, left_out, rounding)
            judged, found = outputs[:_TOLD], outputs[_TOLD:]
            units = tree.coordinate_units(len(x))
            in_units = {c: found[c] * (1.0 / unit) for c, unit in enumerate(units.tolist())}
            errors, _ = closure.errors(tree, placed(tree, in_units), given.offsets)
            every: list[Scalar] = list(judged)
            for k, parameter in enumerate(parameters):
                seeds: dict[Variable, Scalar] = {}
                for row in seeded:
                    seeds[trace.inputs[f"r{row}"]] = trace.input(f"s{k}.{row}", 1.0)
                if isinstance(parameter, OfColumn):
                    if tree.spins:  # Rates of a spin are not those of its position.
                        raise ModelError(
                            f"{parameter.name}: idle rods turn about their lines with it, of which "
                            "derivatives are not known; drive or hold their spins, or give one "
                            "ball of each the type universal"
                        )
                    seeds[trace.inputs[f"x{parameter.column}"]] = 1.0
                elif isinstance(parameter, OfRow):
                    own = trace.inputs[f"r{parameter.row}"]
                    seeds[own] = seeds.get(own, 0.0) + 1.0
                elif isinstance(parameter, OfOrigin):
                    seeds[changes[k]] = 1.0
                elif isinstance(parameter, OfMass):
                    seeds[changes[k]] = given.factors.get(parameter.link, 1.0)
                every += tangents([*found, *errors], seeds)
            self._errors = len(errors)
            self._program = Program(trace, every, keeps_inputs=True)

    def differentiated(
        self, rows: Prescribed, x: Array, seeds: Sequence[Array]
    ) -> tuple[list[Change], Array]:
        """Return changes with each parameter, and how unstable the elimination is, see `Found`.

        Args:
            rows: what is given.
            x: `(size, n)` closed coordinates.
            seeds: per parameter `(k, n)` or `(k, 1)` how the seeded rows change.
        """
        count = x.shape[1]
        given = [np.zeros((self._count, 1)), *self._with_x(rows, x), *seeds]
        results = self._program.run_rows(given, count)
        changes = []
        for own in results[_TOLD:].reshape(self._count, -1, count):
            end = len(own) - self._errors
            found = self._equations.found(np.concatenate([results[:_TOLD], own[:end]]))
            opened = np.abs(own[end:]).max(axis=0, initial=0.0)
            changes.append(
                Change(
                    *(found.x, found.v, found.a, found.ratios),
                    *(found.wrenches, found.efforts, found.couplings),
                    opened,
                )
            )
        return changes, self._equations.found(results).instability


def _changed(
    equations: Equations,
    parameters: Sequence[Parameter],
    changes: Sequence[Variable],
    numbers_at: Callable[[Mechanism], tuple[Tree, tuple[LinkKind, ...]]],
) -> tuple[Tree, tuple[LinkKind, ...]]:
    """Return a tree and links whose numbers change with parameters; see `_Differentiated`."""
    tree, links = equations.tree, equations.links
    for parameter, change in zip(parameters, changes, strict=True):
        if isinstance(parameter, OfMass) and parameter.body >= 0:
            bodies = list(tree.bodies)
            body = bodies[parameter.body]
            more = parameter.adds(change, tree.length)
            bodies[parameter.body] = body._replace(masses=(*body.masses, *more))
            tree = tree._replace(bodies=tuple(bodies))
    for parameter, change in zip(parameters, changes, strict=True):
        if isinstance(parameter, OfOrigin):
            of_tree, of_links = parameter.slopes(numbers_at)
            tree, links = _displaced(tree, of_tree, change), _moved(links, of_links, change)
    return tree, links


def _displaced(tree: Tree, slopes: Any, change: Scalar) -> Tree:
    """Return a tree that changes by some times slopes of it, which know less masses."""
    of = Tree(*slopes)
    bodies = []
    for body, of_body in zip(tree.bodies, of.bodies, strict=True):
        masses = body.masses[: len(of_body[-1])]
        moved = _moved(body._replace(masses=masses), of_body, change)
        bodies.append(moved._replace(masses=(*moved.masses, *body.masses[len(masses) :])))
    return tree._replace(
        axes=_moved(tree.axes, of.axes, change),
        bodies=tuple(bodies),
        loops=_moved(tree.loops, of.loops, change),
    )


def changes_of(
    taped: TapedSolver,
    x: Array,
    v: Array,
    inputs: Inputs,
    parameters: Sequence[Parameter],
) -> list[Change]:
    """Return how samples change with each parameter.

    Args:
        taped: solves them.
        x: `(N, size)` closed coordinates.
        v: `(N, nv)` their velocities.
        inputs: what is prescribed.
        parameters: some.
    """
    found = []
    for span in blocks(len(x)):  # So that memory is bounded.
        given = x[span], v[span], inputs.of_samples(np.arange(len(x))[span])
        found.append(_changes(taped, *given, parameters))
    return [
        Change._make(map(np.concatenate, zip(*parts, strict=True)))
        for parts in zip(*found, strict=True)
    ]


def _changes(
    taped: TapedSolver, x: Array, v: Array, inputs: Inputs, parameters: Sequence[Parameter]
) -> list[Change]:
    """Return the changes of a block; arguments as of `changes_of`."""
    problem, mechanism = taped.problem, taped.problem.mechanism
    links = [(name, load) for name, load in inputs.link_loads.items() if load.body >= 0]
    nothing: list[dict[int, Array]] = [{} for _ in parameters]
    if not problem.elements:
        return _Samples(taped, x, inputs, links).changes(parameters, nothing)
    coordinates = mechanism.coordinates
    units = 1.0 / coordinates.scale, coordinates.rate_scale
    turned = x + 2.0 * np.pi * inputs.turns
    pushing = _Pushing(mechanism, problem.elements, turned, v, inputs.time, units)
    acted = pushing.acted()
    loaded = inputs._replace(loads=inputs.loads + acted.efforts)
    names = [wrench.link for wrench in acted.wrenches]
    pushed = list(zip(names, acted.link_loads(mechanism), strict=True))
    samples = _Samples(taped, x, loaded, [*links, *pushed])
    moved = zip(parameters, samples.changes(parameters, nothing), strict=True)
    every = np.array([pushing.change(parameter, of.x, of.v) for parameter, of in moved])
    efforts = samples.first_effort + np.arange(mechanism.model.nv)
    exerted = efforts[-1] + 1 + 6 * len(links) + np.arange(6 * len(pushed))
    rows = [*efforts, *exerted]
    acting = np.flatnonzero(every.any(axis=(0, 2)))
    return samples.changes(parameters, [{int(rows[k]): own[k] for k in acting} for own in every])


class _Samples:
    """Closed samples and all that acts on them.

    Attributes:
        first_effort: row of `Prescribed` in which efforts begin.
    """

    def __init__(
        self, taped: TapedSolver, x: Array, inputs: Inputs, links: Sequence[tuple[str, LinkLoad]]
    ) -> None:
        """Keep them.

        Args:
            taped: solves them.
            x: `(n, size)` coordinates.
            inputs: what is prescribed.
            links: names of links, and all wrenches on them, what elements exert included.
        """
        self._taped, self._x = taped, np.ascontiguousarray(x.T)
        self._inputs, self._links = inputs, links
        self._kind = self._kind_at(taped.problem.mechanism)
        self._equations = taped.equations_of(self._kind)
        offsets = taped.offsets(self._equations.tree, inputs.turns)
        loads = vectors([load for _, load in links])
        self._rows = Prescribed.of(inputs, loads, offsets, self._kind)
        self.first_effort = 2 * len(inputs.speeds[0]) + 3

    def _kind_at(self, mechanism: Mechanism) -> Kind:
        """Return the kind of the samples, in a mechanism whose joints lie elsewhere."""
        loads = []
        for name, load in self._links:
            _, frame = mechanism.link_frame(name)
            loads.append(replace(load, rotation=frame.rotation, translation=frame.translation))
        return self._taped.kind_of(self._inputs, loads, False)

    def _numbers_at(self, mechanism: Mechanism) -> tuple[Tree, tuple[LinkKind, ...]]:
        """Return the tree of such a mechanism, and where links lie that wrenches act on."""
        tree = self._taped.tree_at(mechanism, self._kind.factored)
        return tree, self._kind_at(mechanism).links

    def changes(
        self, parameters: Sequence[Parameter], seeds: Sequence[Mapping[int, Array]]
    ) -> list[Change]:
        """Return how the samples change with each parameter.

        Args:
            parameters: some.
            seeds: for each, rows of `Prescribed` to how they change with it besides, `(n,)`; the
                same rows for all.
        """
        count = self._x.shape[1]
        acting = self._rows.acting()
        own = [item.row for item in parameters if isinstance(item, OfRow)]
        acting[[*own, *seeds[0]]] = True
        results: list[Change] | None = None
        left = np.arange(count)
        for order, shadows, lanes in self._orders(left):
            chosen = np.intersect1d(lanes, left)
            if not len(chosen):
                continue
            key = self._taped.key, self._kind, tuple(order.places), shadows.tobytes()
            names, seeded = tuple(item.name for item in parameters), tuple(seeds[0])
            loaded = tuple(name for name, _ in self._links)
            make = partial(
                _Differentiated,
                *(self._equations, order, shadows, acting, parameters, seeded),
                numbers_at=self._numbers_at,
            )
            try:
                tape = self._taped.problem.mechanism.kept.of(
                    "derivatives", (key, names, loaded, seeded, acting.tobytes()), make
                )
            except UnsuitableError:
                continue
            of_lanes = [
                np.reshape([values[chosen] for values in item.values()], (-1, len(chosen)))
                for item in seeds
            ]
            rows, x = self._rows.of_lanes(chosen, count), self._x[:, chosen]
            found, instability = tape.differentiated(rows, x, of_lanes)
            holds = instability <= 1.0
            if len(chosen) == count:
                results = found
            else:
                results = results or [
                    Change(*(np.empty((count, *part.shape[1:])) for part in change))
                    for change in found
                ]
                for result, change in zip(results, found, strict=True):
                    for values, part in zip(result, change, strict=True):
                        values[chosen] = part
            left = np.setdiff1d(left, chosen[holds])
            if not len(left):
                break
        assert results is not None
        return results

    def _orders(self, samples: Array) -> Iterator[tuple[Order, Array, Array]]:
        """Yield orders of elimination, where they were chosen, and samples that they may be for.

        First those of all samples, at last those that are chosen at each sample itself.
        """
        orders = self._taped.orders
        for index in range(MOST_TAPES):
            chosen = orders and orders.at(index)
            if chosen:
                yield chosen.order, chosen.at, samples
        yield from self._taped.orders_at(self._equations, self._x)
