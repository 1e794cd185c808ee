"""Constrained model: accelerations of a mechanism whose loops are kept closed, chain by chain.

Chains are the parts that neither bodies nor loops nor couplings connect. What one of them does
changes the accelerations of no other: equations of each by itself grow with the number of chains,
those of all at once with its third power.

A `ChainTape` solves the equations of a chain in its independent coordinates. Where others should be
independent, another tape does, which is chosen by that state alone. The same tapes close loops that
have drifted open, in the metric of the kinetic energy. Where a closure equation is weak, close to a
singular configuration, and where directions have no mass, equations are solved by singular values.

A chain may be overclosed: Bennett's linkage moves although its four hinges leave no freedom by
count, as three closure equations follow from the others on closed positions, and nowhere else.
Within a step of an integration states are a little open, where all six equations are independent
and leave it no motion: taken as they are, accelerations jump with the size of the gap. There as
well the equations keep the rank that they have where loops are closed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias, cast

import numpy as np
import pinocchio

from ...core.dynamics.chain_tape import ChainTape, ChainTapes
from ...core.kinematics.tolerances import AROUND, CONFIGURATIONS
from ...core.mechanism.mechanism import Mechanism
from ...core.mechanism.welds import Loop
from ...kit.arrays import EPS, ROUNDED, Array, consecutive
from ...kit.errors import SingularConfigurationError
from .closed_directions import (
    ClosedDirections,
    CouplingRows,
    rank_of,
    refuse_open,
)
from .free_balls import WithBalls
from .turning_model import in_lengths, turning_model

UNBOUNDED = (
    "no effort of the actuated joints makes the task move as given: where it depends on free "
    "coordinates, these would have to be accelerated without bound"
)
_TOGETHER = 16
"""Velocity coordinates up to which chains are taken together: fewer cost as many calls."""
_WEAK = 1.0 / 30.0
"""Least singular value of closure equations, as a fraction of that elsewhere, below which they are
weak."""


_Orders: TypeAlias = tuple[tuple[int, ...], ...]
"""Orders of elimination."""


class ConstrainedModel:
    """The constrained chains of a mechanism, as one.

    Not for several threads at once, as its chains are not.

    Attributes:
        mechanism: the mechanism.
        prescribed: velocity coordinates `(p,)` that are driven or held, ascending.
        chains: one for each chain of the mechanism.
    """

    def __init__(
        self,
        mechanism: Mechanism | WithBalls,
        prescribed: Sequence[int],
        gravity: Array,
        state: Array,
        independent: Sequence[int] = (),
        resting: Sequence[int] | None = None,
    ) -> None:
        """Make the model.

        Args:
            mechanism: see the attribute.
            prescribed: see the attribute, in any order.
            gravity: `(3,)` [m/s²].
            state: `(size,)` closed coordinates, at which it is scaled.
            independent: velocity coordinates that rather decide others than the other way round.
            resting: where other joints carry what is prescribed, they and what is held.
        """
        self.mechanism = mechanism
        self.prescribed = np.unique(np.array(prescribed, dtype=int))
        chains = chains_of(mechanism)
        made_of = self.prescribed.tolist(), gravity, state, tuple(independent), resting
        self.chains = [ConstrainedChain(mechanism, chain, *made_of) for chain in chains]
        self._parts = [
            (
                model,
                consecutive(chain.columns),
                consecutive(chain.rates),
                np.isin(self.prescribed, chain.rates),
            )
            for model, chain in zip(self.chains, chains, strict=True)
        ]

    def rates(
        self, x: Array, v: Array, efforts: Array | None = None, prescribed: Array | None = None
    ) -> Array:
        """Return the rates `(size + nv,)` of coordinates and velocities, see `ConstrainedChain`."""
        result = np.empty(len(x) + len(v))
        of_x, of_v = result[: len(x)], result[len(x) :]
        for model, columns, rates, own in self._parts:
            acting = None if efforts is None else efforts[rates]
            told = None if prescribed is None else prescribed[own]
            found = model.rates(x[columns], v[rates], acting, told)
            of_v[rates] = found[-model.model.nv :]
            of_x[columns] = found[: -model.model.nv]
        return result

    def closed(self, x: Array, v: Array, *, crosses: bool = False) -> tuple[Array, Array]:
        """Return a state whose loops and couplings are closed again, see `ConstrainedChain`."""
        near, rates_near = np.empty_like(x), np.empty_like(v)
        for model, columns, rates, _ in self._parts:
            near[columns], rates_near[rates] = model.closed(x[columns], v[rates], crosses=crosses)
        return near, rates_near

    @property
    def rounding(self) -> float:
        """Greatest part of the speeds that rounding has decided where loops were closed."""
        return max((chain.rounding for chain in self.chains), default=0.0)

    def weakness(self, x: Array) -> float:
        """Return how strong the weakest closure equation is, see `ConstrainedChain`."""
        return min((model.weakness(x[columns]) for model, columns, *_ in self._parts), default=1.0)

    def singular_gap(self, x: Array) -> float:
        """Return the gap of the weakest chain in a singular configuration near coordinates."""
        model, columns, *_ = min(self._parts, key=lambda part: part[0].weakness(x[part[1]]))
        return model.singular_gap(x[columns])


class Chain(NamedTuple):
    """Bodies that are connected with others by the world alone, or some such parts together.

    Attributes:
        bodies: their indices in `Mechanism.model`, ascending.
        columns: their columns in a row of coordinates.
        rates: their velocity coordinates.
        loops: welds between them, whose bodies are counted within the chain, 0 for the world.
        couplings: indices of the couplings between them.
    """

    bodies: list[int]
    columns: Array
    rates: Array
    loops: list[Loop]
    couplings: list[int]


def chains_of(mechanism: Mechanism | WithBalls) -> list[Chain]:
    """Return the chains of a mechanism, small ones together."""
    model = mechanism.model
    body_of = np.repeat(np.arange(model.njoints), list(model.nvs))
    coupled = [
        set(body_of[[*item.predecessor_columns, *item.successor_columns]].tolist())
        for item in mechanism.couplings
    ]
    ends = [{body, model.parents[body]} for body in range(1, model.njoints)]
    ends += [{loop.predecessor, loop.successor} for loop in mechanism.loops]
    chains: list[set[int]] = []
    for bodies in (*ends, *coupled):
        meeting = [chain for chain in chains if chain & bodies]
        chains = [chain for chain in chains if not chain & bodies]
        chains.append((bodies - {0}).union(*meeting))
    bundles: list[list[int]] = []
    for chain in sorted(filter(None, chains), key=min):
        together = [*bundles[-1], *chain] if bundles else []
        if together and sum(model.nvs[body] for body in together) <= _TOGETHER:
            bundles[-1] = together
        else:
            bundles.append([*chain])
    return [
        _chain(
            mechanism,
            sorted(bodies),
            [index for index, own in enumerate(coupled) if own.issubset(bodies)],
        )
        for bodies in bundles
    ]


def _chain(mechanism: Mechanism | WithBalls, bodies: list[int], couplings: list[int]) -> Chain:
    coordinates, own = mechanism.coordinates, {0: 0}
    own.update({body: index for index, body in enumerate(bodies, start=1)})
    columns: list[int] = []
    rates: list[int] = []
    for part, column in zip(coordinates.parts, coordinates.starts, strict=True):
        if part.id in own:
            columns += range(column, column + (4 if part.kind == "spherical" else 1))
            start = mechanism.model.idx_vs[part.id]
            rates += range(start, start + part.nv)
    loops = [
        loop._replace(predecessor=own[loop.predecessor], successor=own[loop.successor])
        for loop in mechanism.loops
        if loop.predecessor in own
        and loop.successor in own
        and (loop.predecessor or loop.successor)
    ]
    return Chain(bodies, np.array(columns, dtype=int), np.array(rates, dtype=int), loops, couplings)


class ConstrainedChain:
    """A chain whose columns of coordinate rows are configurations.

    Not for several threads at once: it has one set of Pinocchio's data.

    Inside, lengths are in units of the characteristic length: so rows of gaps and of angles are of
    one size, whatever the size of the mechanism.

    Attributes:
        model: `pin.Model` of the chain.
        prescribed: velocity coordinates `(p,)` of the chain that are driven or held.
        rounding: greatest part of the speeds that rounding has decided where loops were closed.
        was_weak: becomes true where a closure equation is weak.
        closes_stages: whether accelerations are those of the closed state beside one.
    """

    def __init__(
        self,
        mechanism: Mechanism | WithBalls,
        chain: Chain,
        prescribed: Sequence[int],
        gravity: Array,
        state: Array,
        independent: Sequence[int] = (),
        resting: Sequence[int] | None = None,
    ) -> None:
        """Make the model.

        Args:
            mechanism: that the chain is part of.
            chain: the chain.
            prescribed: velocity coordinates of the mechanism that are driven or held.
            gravity: `(3,)` [m/s²].
            state: `(size,)` closed coordinates of the mechanism, at which it is scaled.
            independent: see `ConstrainedModel`.
            resting: likewise.
        """
        self._made_of = mechanism, chain, tuple(prescribed), gravity, state, independent, resting
        self.rounding, self.was_weak, self.closes_stages = 0.0, False, False
        if resting is not None:
            resting = np.intersect1d(chain.rates, resting).tolist()
            if resting == np.intersect1d(chain.rates, prescribed).tolist():
                resting = None  # No task moves this chain.
        coordinates, length = mechanism.coordinates, mechanism.characteristic_length
        self.prescribed = np.nonzero(np.isin(chain.rates, prescribed))[0]
        rate_scale = coordinates.rate_scale[chain.rates]
        self._of_positions, self._of_rates = coordinates.scale[chain.columns], 1.0 / rate_scale
        self._of_efforts = rate_scale / length**2
        self.model = turning_model(mechanism, gravity, length, chain.bodies)
        constraints = [
            loop._replace(
                predecessor_placement=in_lengths(loop.predecessor_placement, length),
                successor_placement=in_lengths(loop.successor_placement, length),
            ).constraint(self.model)
            for loop in chain.loops
        ]
        couplings = _couplings(mechanism, chain)
        self._is_open = not (constraints or len(couplings))
        state = state[chain.columns] * self._of_positions
        # Its size grows with the third power of the coordinates: there is one for all that works.
        data = self.model.createData()
        upper = np.triu(pinocchio.crba(self.model, data, state))
        self._free = np.delete(np.arange(self.model.nv), self.prescribed)
        self._lent = _lent_inertia(upper + np.triu(upper, 1).T, self._free)

        def directions(rank: int) -> ClosedDirections:
            made_of = self.model, constraints, couplings, self.prescribed, rank
            return ClosedDirections(*made_of, data=data, lent=self._lent)

        self._every = every = directions(self.model.nv)

        def moved(ways: Array) -> list[Array]:
            return [pinocchio.integrate(self.model, state, way) for way in ways]

        def measured() -> _Elsewhere:
            ways = np.random.default_rng(1).uniform(-1.0, 1.0, (CONFIGURATIONS, self.model.nv))
            anywhere = _Elsewhere.at(every, moved(ways))
            if every.rank(state) == anywhere.rank:
                return anywhere
            # Some may be redundant where loops are closed, and there alone.
            ways = np.zeros((CONFIGURATIONS - 1, self.model.nv))
            ways[:, every.free] = np.random.default_rng(0).normal(size=ways[:, every.free].shape)
            close, rest = directions(anywhere.rank).closed, np.zeros(self.model.nv)
            places = [close(place, rest)[0] for place in moved(AROUND * ways)]
            # The state itself may be singular.
            closed = _Elsewhere.at(every, [state, *places])
            return anywhere if closed.rank == anywhere.rank else closed

        bodies, kept = tuple(chain.bodies), mechanism.kept
        place = bodies, self.prescribed.tobytes(), state.tobytes()
        self._elsewhere = kept.of("closures elsewhere", place, measured)
        self._by_rank = directions(self._elsewhere.rank)
        self._tapes = ChainTapes(
            # With balls, it has all that a tree is read from.
            cast("Mechanism", mechanism),
            bodies,
            chain.rates[self.prescribed].tolist(),
            gravity,
            self._elsewhere.places / self._of_positions,
            resting,
        )
        self._rates, self._decided = chain.rates, [(self._free, self._elsewhere.rank)]
        if resting is not None:
            moving = np.nonzero(~np.isin(chain.rates, resting))[0]
            # Forces balance along as many motions as there are free ones.
            rank = moving.size - self._free.size + self._elsewhere.rank
            self._decided.append((moving, rank))
        self._nothing, self._untold = np.zeros(self.model.nv), np.zeros(self.prescribed.size)
        spared = [np.isin(chain.rates, independent)] * len(self._decided)

        def best() -> tuple[_Orders, Array]:
            # The state itself may be singular.
            places = [state, *self._elsewhere.places]
            chosen = [self._dependent(place, spared) for place in places]
            index = max(range(len(places)), key=lambda index: chosen[index][1])
            return chosen[index][0], places[index] / self._of_positions

        key = *place, spared[0].tobytes(), resting and tuple(resting)
        dependent, x = kept.of("chain orders", key, best)
        self._spared = [~np.isin(chain.rates, order) for order in dependent]
        self._main, rest = self._tapes.of(*dependent), (self._nothing, self._untold, self._nothing)
        if self._main and self._lent and self._main.rates(x, *rest, at_last=True) is None:
            self._main = None  # A direction moves no mass.
        self._traced = self._main.traced() if self._main is not None else None

    def __reduce__(self) -> tuple[object, ...]:
        # Pinocchio's data cannot be copied.
        return ConstrainedChain, self._made_of

    def _dependent(self, x: Array, spared: Sequence[Array]) -> tuple[_Orders, float]:
        """Return what others decide best at a configuration, and how well the last of them.

        Velocity coordinates of the mechanism, in an order of elimination; and those while others
        carry what is prescribed.

        Args:
            x: configuration of the model.
            spared: for each of these, which coordinates are to be independent.
        """
        from scipy.linalg import qr  # Only simulations need it.

        orders: list[tuple[int, ...]] = []
        worst = 1.0
        for (columns, rank), kept in zip(self._decided, spared, strict=True):
            if not rank:
                orders.append(())
                continue
            rows = self._every.jacobian(x)[:, columns] * np.where(kept[columns], _WEAK, 1.0)
            upper, order = qr(rows, mode="r", pivoting=True, check_finite=False)
            rates = self._rates[columns[order[:rank]]].tolist()
            orders.append(self._tapes.sparse_first(rates))
            worst = min(worst, abs(float(upper[rank - 1, rank - 1])))
        return tuple(orders), worst

    def rates(
        self, x: Array, v: Array, efforts: Array | None = None, prescribed: Array | None = None
    ) -> Array:
        """Return the rates `(size + nv,)` of coordinates and velocities that efforts cause.

        Args:
            x: coordinates `(size,)`, closed up to a small drift, quaternions of any length.
            v: velocities `(nv,)`.
            efforts: along all coordinates `(nv,)` [N·m, N], which are not changed; none if None.
            prescribed: accelerations of the prescribed coordinates `(p,)`; at rest if None.
        """
        if self.closes_stages:
            x, v = self._closed_by_rank(self._tapes.unit(x), v)
        acting = self._nothing if efforts is None else efforts
        told = self._untold if prescribed is None else prescribed
        found = self._main.rates(x, v, told, acting) if self._main is not None else None
        if found is None and (other := self._other(x)) is not None:
            found = other.rates(x, v, told, acting, at_last=True)
        if found is not None:
            return found
        x = self._tapes.unit(x)
        if len(self._decided) > 1:
            raise SingularConfigurationError(
                "the task is at the end of its reach, or where its ways of working meet"
                if self.weakness(x) < _WEAK
                else f"{UNBOUNDED}; or "
                "something moves freely that has no mass, such as a massless rod between two balls "
                "(write one of its ends as a universal joint)"
            )
        a = self._by_rank.accelerations(
            x * self._of_positions,
            v * self._of_rates,
            acting * self._of_efforts,
            told * self._of_rates[self.prescribed],
        )
        return np.concatenate((self._tapes.gains(x, v), a / self._of_rates))

    @property
    def traced(self) -> tuple[Any, Array, Array] | None:
        """What gives rates while nothing acts or is told to move, see `Traced`."""
        return None if self.closes_stages else self._traced

    def _other(self, x: Array) -> ChainTape | None:
        """Return the tape that suits a state best, which the main one does not.

        None where closures are weak, or nothing has mass.

        Args:
            x: coordinates `(size,)`.
        """
        place = x * self._of_positions
        if self._main is None or not np.all(np.isfinite(place)):
            return None
        if self._elsewhere.weakness(self._every, place) < _WEAK:
            self.was_weak = True
            return None
        return self._tapes.of(*self._dependent(place, self._spared)[0])

    def weakness(self, x: Array) -> float:
        """Return how strong the weakest closure equation is that is not redundant.

        As a fraction of what it is elsewhere; 0 in a singular configuration.

        Args:
            x: coordinates `(size,)`.
        """
        return self._elsewhere.weakness(self._every, x * self._of_positions)

    def singular_gap(self, x: Array) -> float:
        """Return the closure error in the singular configuration near coordinates `(size,)`.

        An angle [rad] or a gap as a fraction of the length; it is one of the mechanism if there is
        none.
        """
        return self._by_rank.singular_gap(x * self._of_positions)

    def closed(self, x: Array, v: Array, *, crosses: bool = False) -> tuple[Array, Array]:
        """Return a state whose loops and couplings are closed again, near one that drifted.

        What is prescribed stays where it is, and keeps its speed. It is the nearest one in the
        metric of the kinetic energy.

        Args:
            x: coordinates `(size,)`.
            v: velocities `(nv,)`.
            crosses: whether the state is close to a crossing, where weak equations are left to it.
        """
        if self._is_open:
            return x, v
        is_near, before, last = False, np.inf, np.inf
        while True:
            found = self._main.closer(x, v) if self._main is not None else None
            if found is None and (other := self._other(x)) is not None:
                found = other.closer(x, v, at_last=True)
            if found is None:
                x, v = self._closed_by_rank(x, v, strong_alone=crosses)
                if self._main is not None and not crosses:
                    rounding = self._by_rank.rounding(x * self._of_positions)
                    self.rounding = max(self.rounding, rounding)
                return x, v
            nearer, rates, error = found
            if is_near or error < 2.0 * EPS:
                return x, rates
            if not error < before:
                refuse_open(error)
            # The error of a step of Newton's method is the square of what it closes.
            x, is_near, before, last = nearer, error <= np.sqrt(EPS), last, error

    def _closed_by_rank(
        self, x: Array, v: Array, *, strong_alone: bool = False
    ) -> tuple[Array, Array]:
        x, v = x * self._of_positions, v * self._of_rates
        x, v = self._by_rank.closed(x, v, strong_alone=strong_alone)
        return x / self._of_positions, v / self._of_rates


class _Elsewhere(NamedTuple):
    """Closure equations of a chain at other configurations, against which they may be weak.

    Attributes:
        places: configurations `(P, size)`; loops are closed there if the chain is overclosed.
        rank: of the equations along free coordinates.
        typical: least singular value that is not zero, relative to the greatest.
    """

    places: Array
    rank: int
    typical: float

    @staticmethod
    def at(every: ClosedDirections, places: list[Array]) -> _Elsewhere:
        """Look at configurations."""
        values = [every.singular_values(place) for place in places]
        rank = max(map(rank_of, values))
        parts = [item[rank - 1] / item[0] for item in values if rank and rank_of(item) == rank]
        return _Elsewhere(np.array(places), rank, float(np.median(parts)) if rank else 1.0)

    def weakness(self, every: ClosedDirections, x: Array) -> float:
        """Return the least singular value, relative to the greatest, as a fraction of elsewhere.

        Args:
            every: the equations.
            x: a configuration.
        """
        if not self.rank:
            return 1.0
        values = every.singular_values(x)
        return float(values[self.rank - 1] / values[0] / self.typical)


def _couplings(mechanism: Mechanism | WithBalls, chain: Chain) -> CouplingRows:
    """Return the couplings of a chain."""
    coordinates = mechanism.coordinates
    chosen = [mechanism.couplings[index] for index in chain.couplings]
    first, last = np.zeros((2, len(chosen), mechanism.model.nv))
    powers = np.zeros((3 + max((len(item.higher) for item in chosen), default=0), len(chosen)))
    for index, item in enumerate(chosen):
        first[index, list(item.predecessor_columns)] = 1.0
        last[index, list(item.successor_columns)] = 1.0
        terms = item.offset, item.ratio, *item.higher
        powers[: len(terms), index] = terms
    first, last = ((part * coordinates.rate_scale)[:, chain.rates] for part in (first, last))
    columns, rates = coordinates.scalars
    own = np.isin(rates, chain.rates)
    column_of = np.full(len(chain.rates), -1)
    column_of[np.searchsorted(chain.rates, rates[own])] = np.searchsorted(
        chain.columns, columns[own]
    )
    return CouplingRows(first, last, powers, column_of)


def _lent_inertia(inertia: Array, free: Array) -> float:
    """Return the inertia that every joint is lent, 0 if there is one in all directions."""
    own = inertia[np.ix_(free, free)]
    scale = np.sqrt(np.diag(own))
    if not free.size:
        return 0.0
    if np.all(scale > 0.0):
        least = float(np.min(np.linalg.eigvalsh(own / scale / scale[:, None])))
        if least > ROUNDED and np.min(scale) > np.sqrt(ROUNDED) * np.max(scale):
            return 0.0
    return float(np.sqrt(EPS) * np.max(scale) ** 2) or 1.0
