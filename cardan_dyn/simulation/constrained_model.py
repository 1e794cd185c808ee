"""Constrained model: accelerations of a mechanism whose loops are kept closed, chain by chain.

Chains are the parts that neither bodies nor loops nor couplings connect. What one of them does
changes the accelerations of no other: equations of each by itself grow with the number of chains,
those of all at once with its third power.

Pinocchio's `constraintDynamics` gives the accelerations of a chain, redundant closures included:
its proximal iterations need three rounds if their regularisation suits the scene. What is
prescribed is a joint with an inertia so great that nothing else moves it; the same decomposition
then closes loops that have drifted open, in the metric of the kinetic energy. Close to a singular
configuration a closure equation is weaker than what this regularisation takes for redundant: there
the equations keep the rank that they have elsewhere, by singular values. Many loops are eliminated
one after the other instead, see `loop_elimination`, wherever none of them is weak.

A chain may be overclosed: Bennett's linkage moves although its four hinges leave no freedom by
count, as three closure equations follow from the others on closed positions, and nowhere else.
Within a step of an integration states are a little open, where all six equations are independent
and leave it no motion: taken as they are, accelerations jump with the size of the gap. There as
well the equations keep the rank that they have where loops are closed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import pinocchio

from ..arrays import Array, consecutive
from ..mechanism.mechanism import Mechanism
from ..mechanism.welds import Loop, constraint_models
from .closed_directions import ZERO, ClosedDirections, rank_of, refuse_open
from .free_balls import WithBalls
from .loop_elimination import LoopElimination
from .turning_model import in_lengths, turning_model

_TOGETHER = 16
"""Velocity coordinates up to which chains are taken together: fewer cost as many calls."""
_IMMOVABLE = 1e15
"""Inertia of prescribed joints, as a multiple of the greatest other one: what acts on them changes
their acceleration by less than rounding."""
_REGULARISATION = 1e-8
"""Proximal parameter, as a fraction of the least eigenvalue of J M⁻¹ Jᵀ that is not zero."""
_ROUNDS = 3
"""Proximal iterations: each gains the eight digits of the regularisation."""
_ELSEWHERE = 0.3
"""Displacement [rad, or a fraction of the length] after which equations have the rank and the size
that they have elsewhere, whether or not loops are closed there."""
_PLACES = 3
"""Number of configurations at which these are looked at."""
_MANY = 13
"""Loops from which on bodies are eliminated one after the other: fewer take as long at once."""
_WEAK = 1e-3
"""Eigenvalue of J M⁻¹ Jᵀ, as a fraction of the least elsewhere, below which singular values are
taken: three proximal iterations leave (1e-8 / 1e-3)³ of its equation."""
_WEIGHTLESS = 1e-11
"""Inertia along a direction, as a fraction of that along the coordinates themselves, that counts as
none, so that the inertia matrix has no inverse."""
_LENT = 1e-4
"""Inertia lent to every joint of a chain with weightless parts where its loops are closed, as a
fraction of the greatest; accelerations are those without it."""
_MOST_STEPS = 4
"""Greatest number of Newton steps that close loops which have drifted open."""
_CLOSED = 4e-16
"""Closure error at which they end, see `ConstrainedChain.closure_error`."""
_NO_GAINS, _NO_GAPS = np.zeros((0, 0)), np.zeros(0)
_NEAR = 1e-8
"""Error of which one Newton step, or one proximal iteration, leaves rounding."""
_STALE = 1e-5
"""Displacement [rad, or a fraction of the length] up to which equations that were decomposed before
it close loops: each step leaves at most as much of the error, and costs a third of one with
equations decomposed anew."""
_OPEN = 1e-3
"""Displacement [rad, or a fraction of the length] by which loops are opened to see their rank."""
_MOVED = (0.02, 0.05)
"""Displacements after which they are closed again to see it."""


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
    ) -> None:
        """Make the model.

        Args:
            mechanism: see the attribute.
            prescribed: see the attribute, in any order.
            gravity: `(3,)` [m/s²].
            state: `(size,)` closed coordinates, at which it is scaled.
        """
        self.mechanism = mechanism
        self.prescribed = np.unique(np.array(prescribed, dtype=int))
        chains = chains_of(mechanism)
        made_of = self.prescribed.tolist(), gravity, state
        self.chains = [ConstrainedChain(mechanism, chain, *made_of) for chain in chains]
        # A single chain takes and returns rows as they are.
        self._only = self.chains[0] if len(self.chains) == 1 else None
        self._parts = [
            (
                model,
                consecutive(chain.columns),
                consecutive(chain.rates),
                np.isin(self.prescribed, chain.rates),
            )
            for model, chain in zip(self.chains, chains, strict=True)
        ]

    def accelerations(
        self, x: Array, v: Array, efforts: Array | None = None, prescribed: Array | None = None
    ) -> Array:
        """Return the accelerations `(nv,)` that efforts cause, see `ConstrainedChain`."""
        if self._only is not None:
            return self._only.accelerations(x, v, efforts, prescribed)
        a = np.empty_like(v)
        for model, columns, rates, own in self._parts:
            acting = None if efforts is None else efforts[rates]
            told = None if prescribed is None else prescribed[own]
            a[rates] = model.accelerations(x[columns], v[rates], acting, told)
        return a

    def closed(self, x: Array, v: Array, *, crosses: bool = False) -> tuple[Array, Array]:
        """Return a state whose loops and couplings are closed again, see `ConstrainedChain`."""
        if self._only is not None:
            return self._only.closed(x, v, crosses=crosses)
        near, rates_near = np.empty_like(x), np.empty_like(v)
        for model, columns, rates, _ in self._parts:
            near[columns], rates_near[rates] = model.closed(x[columns], v[rates], crosses=crosses)
        return near, rates_near

    def weakness(self, x: Array) -> float:
        """Return how strong the weakest closure equation is, see `ConstrainedChain`."""
        return min((model.weakness(x[columns]) for model, columns, *_ in self._parts), default=1.0)

    def singular_gap(self, x: Array) -> float:
        """Return the gap of the weakest chain in a singular configuration near coordinates."""
        model, columns, *_ = min(self._parts, key=lambda part: part[0].weakness(x[part[1]]))
        return model.singular_gap(x[columns])

    def closure_error(self, x: Array) -> float:
        """Return the greatest closure error, see `ConstrainedChain`."""
        errors = [model.closure_error(x[columns]) for model, columns, *_ in self._parts]
        return max(errors, default=0.0)


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
    ends = [[body, int(model.parents[body])] for body in range(1, model.njoints)]
    ends += [[loop.predecessor, loop.successor] for loop in mechanism.loops]
    coupled = [
        body_of[[*item.predecessor_columns, *item.successor_columns]].tolist()
        for item in mechanism.couplings
    ]
    bundles: list[list[int]] = []
    for bodies in _connected(model.njoints, [*ends, *coupled]):
        if bundles and _size(mechanism, [*bundles[-1], *bodies]) <= _TOGETHER:
            bundles[-1] += bodies
        else:
            bundles.append(bodies)
    return [
        _chain(
            mechanism,
            sorted(bodies),
            [index for index, own in enumerate(coupled) if set(own).issubset(bodies)],
        )
        for bodies in bundles
    ]


def _connected(count: int, connections: list[list[int]]) -> list[list[int]]:
    """Return which of the numbers from 1 on are connected, 0 connecting nothing."""
    first = list(range(count))

    def root(number: int) -> int:
        while first[number] != number:
            number = first[number]
        return number

    for numbers in connections:
        roots = sorted({root(number) for number in numbers if number})
        for other in roots[1:]:
            first[other] = roots[0]
    members: dict[int, list[int]] = {}
    for number in range(1, count):
        members.setdefault(root(number), []).append(number)
    return list(members.values())


def _size(mechanism: Mechanism | WithBalls, bodies: list[int]) -> int:
    return sum(int(mechanism.model.nvs[body]) for body in bodies)


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
    """Pinocchio's model of a chain in which its columns of coordinate rows are configurations.

    Not for several threads at once: it has one set of Pinocchio's data.

    Inside, lengths are in units of the characteristic length: so rows of gaps and of angles are of
    one size, whatever the size of the mechanism, and one regularisation suits both.

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
    ) -> None:
        """Make the model.

        Args:
            mechanism: that the chain is part of.
            chain: the chain.
            prescribed: velocity coordinates of the mechanism that are driven or held.
            gravity: `(3,)` [m/s²].
            state: `(size,)` closed coordinates of the mechanism, at which it is scaled.
        """
        self._made_of = mechanism, chain, tuple(prescribed), gravity, state
        self.rounding, self.was_weak, self.closes_stages = 0.0, False, False
        coordinates, length = mechanism.coordinates, mechanism.characteristic_length
        self.prescribed = np.nonzero(np.isin(chain.rates, prescribed))[0]
        rate_scale = coordinates.rate_scale[chain.rates]
        self._of_positions, self._of_rates = coordinates.scale[chain.columns], 1.0 / rate_scale
        self._of_efforts = rate_scale / length**2
        self._slides = bool(np.any(rate_scale != 1.0))
        self.model = turning_model(mechanism, gravity, length, chain.bodies)
        loops = [
            loop._replace(
                predecessor_placement=in_lengths(loop.predecessor_placement, length),
                successor_placement=in_lengths(loop.successor_placement, length),
            )
            for loop in chain.loops
        ]
        self._constraints = constraint_models(self.model, loops)
        self._constraint_data = pinocchio.StdVec_RigidConstraintData()
        for item in self._constraints:
            self._constraint_data.append(item.createData())
        self._rows = 6 * len(self._constraints)
        self._couplings = _Couplings(mechanism, chain)
        self._has_couplings = len(self._couplings.rows) > 0
        state = state[chain.columns] * self._of_positions
        # Its size grows with the third power of the coordinates: there is one for all that works.
        self.data = self.model.createData()
        inertia = self._inertia(state)
        free = np.delete(np.arange(self.model.nv), self.prescribed)
        self._scale = float(np.max(np.diag(inertia), initial=0.0)) or 1.0
        armature = np.zeros(self.model.nv)
        self._lent = _lent_inertia(inertia, free)
        armature[:] = self._lent
        armature[self.prescribed] = _IMMOVABLE * self._scale
        self.model.armature = self._armature = armature
        self._nothing = np.zeros(self.model.nv)
        self._start_data()
        made_of = self.model, self._constraints, self._couplings.rows, self.prescribed

        def directions(rank: int, gaps: Callable[[Array], Array] | None = None) -> ClosedDirections:
            return ClosedDirections(*made_of, rank=rank, gaps=gaps, data=self.data)

        every, gaps = directions(self.model.nv), self._couplings.gaps
        self._every = every
        self._is_overclosed, self._directions = False, None
        self._elimination: LoopElimination | None = None

        def know(elsewhere: _Elsewhere) -> None:
            self._elsewhere = elsewhere
            self._by_rank = directions(elsewhere.rank, gaps)
            self._mu = _REGULARISATION * elsewhere.least
            rank, strong = elsewhere.loops, -_WEAK * elsewhere.least
            self._last_loop, self._strong = (rank - 1, strong) if rank else (0, np.inf)
            self._settings = pinocchio.ProximalSettings(0.0, self._mu, _ROUNDS)

        def measured() -> tuple[_Elsewhere, int | None]:
            elsewhere = _Elsewhere.of(every, state)
            know(elsewhere)
            return elsewhere, _overclosed_rank(every, state, self._closed_positions)

        key = tuple(chain.bodies), self.prescribed.tobytes(), state.tobytes()
        elsewhere, overclosed = mechanism.kept.of("closures elsewhere", key, measured)
        know(elsewhere)
        self._is_overclosed = overclosed is not None
        if overclosed is not None:
            self._by_rank = self._directions = directions(overclosed, gaps)
        elif self._lent:
            self._directions = every
        if self._suits_elimination(loops):
            least = elsewhere.least
            self._elimination = LoopElimination(self.model, self.data, self._constraints, least)
        # Whether accelerations are those of the constrained dynamics as they are.
        self._is_plain = not (self._slides or self._has_couplings)
        self._is_plain &= self._directions is None and self._elimination is None
        # Loops were closed elsewhere to see it.
        self.rounding, self.was_weak = 0.0, False

    def _suits_elimination(self, loops: list[Loop]) -> bool:
        if len(loops) < _MANY or self._has_couplings or self._directions is not None:
            return False
        return all(loop.predecessor for loop in loops)

    def _closed_positions(self, x: Array) -> Array:
        """Return a closed configuration of the model near one that is a little open."""
        return self.closed(x / self._of_positions, self._nothing)[0] * self._of_positions

    def __reduce__(self) -> tuple[object, ...]:
        # Pinocchio's data cannot be copied.
        return ConstrainedChain, self._made_of

    def _start_data(self) -> None:
        pair = self._constraints, self._constraint_data
        # Going through Pinocchio's vector anew takes longer than all that is read, and so does
        # asking for the decomposition of the dynamics each time.
        self._each_model = list(self._constraints)
        self._each_constraint = [self._constraint_data[k] for k in range(len(self._constraints))]
        self._decomposition = self.data.constraint_chol
        pinocchio.initConstraintDynamics(self.model, self.data, *pair)
        pivots = self._decomposition.D
        # They change with the dynamics, unless who uses eigenpy has it copy its memory.
        self._pivots: Callable[[], list[float]] = pivots.tolist
        if pivots.flags.owndata:
            self._pivots = lambda: self._decomposition.D.tolist()

    def _inertia(self, x: Array) -> Array:
        """Return the inertia matrix `(nv, nv)` at coordinates."""
        upper = np.triu(pinocchio.crba(self.model, self.data, x))
        return np.asarray(upper + np.triu(upper, 1).T)

    def _loop_jacobian(self) -> Array:
        """Return the rows `(6 L, nv)` of the loops, of the state that was prepared."""
        jacobian = pinocchio.getConstraintsJacobian(
            self.model, self.data, self._constraints, self._constraint_data
        )
        return np.asarray(jacobian)

    def _constrained(self, x: Array, v: Array, efforts: Array) -> Array:
        """Prepare a state: return its accelerations and see whether a loop's equation is weak."""
        a: Array = pinocchio.constraintDynamics(
            self.model,
            self.data,
            x,
            v,
            efforts,
            self._constraints,
            self._constraint_data,
            self._settings,
        )
        # Pivots of J M⁻¹ Jᵀ are negative, those of redundant rows the regularisation; those of the
        # inertia are positive. This is every stage of every step: of so few numbers NumPy's
        # comparisons take three times as long.
        pivots = sorted(self._pivots())
        self._is_weak = not pivots[self._last_loop] <= self._strong
        return a

    def accelerations(
        self, x: Array, v: Array, efforts: Array | None = None, prescribed: Array | None = None
    ) -> Array:
        """Return the accelerations `(nv,)` that efforts cause.

        Args:
            x: coordinates `(size,)`, closed up to a small drift.
            v: velocities `(nv,)`.
            efforts: along all coordinates `(nv,)` [N·m, N], which are not changed; none if None.
            prescribed: accelerations of the prescribed coordinates `(p,)`; at rest if None.
        """
        if efforts is None and prescribed is None and self._is_plain and not self.closes_stages:
            # At every stage of every step.
            a = self._constrained(x, v, self._nothing)
            if not self._is_weak:
                return a
        given = self._nothing
        if efforts is not None:
            given = efforts * self._of_efforts
            given[self.prescribed] = 0.0
        if prescribed is not None:
            given = given.copy()
            inertia = self._armature[self.prescribed]
            given[self.prescribed] = inertia * prescribed * self._of_rates[self.prescribed]
        if self._slides:
            x, v = x * self._of_positions, v * self._of_rates
        if self.closes_stages:
            x, v = self._by_rank.closed(x, v)
        if self._directions is not None:
            told = self._nothing[self.prescribed] if prescribed is None else prescribed
            a = self._directions.accelerations(x, v, given, told * self._of_rates[self.prescribed])
            return a / self._of_rates
        if self._elimination is not None:
            found = self._elimination.accelerations(x, v, given)
            if found is not None:
                return np.asarray(found / self._of_rates) if self._slides else found
        a = self._constrained(x, v, given)
        is_weak = self._is_weak
        if self._has_couplings and not is_weak:
            factors = self._coupling_factors()
            is_weak = self._elsewhere.is_weak_coupled(factors[1])
            a = a if is_weak else self._coupled(a, *factors)
        if is_weak:
            self.was_weak = True
            told = self._nothing[self.prescribed] if prescribed is None else prescribed
            told = told * self._of_rates[self.prescribed]
            a = self._by_rank.forced(x, v, given, told)
        return np.asarray(a / self._of_rates) if self._slides else a

    def weakness(self, x: Array) -> float:
        """Return how strong the weakest closure equation is that is not redundant.

        As a fraction of what it is elsewhere; 0 in a singular configuration.

        Args:
            x: coordinates `(size,)`.
        """
        return self._elsewhere.weakness(self._every, x * self._of_positions)

    def singular_gap(self, x: Array) -> float:
        """Return the closure error in the singular configuration near coordinates `(size,)`.

        As `closure_error`; it is one of the mechanism if there is none.
        """
        return self._by_rank.singular_gap(x * self._of_positions)

    def _solved(self, gaps: Array, efforts: Array, rounds: int) -> Array:
        """Return the least displacements `(nv,)`, in the metric of the kinetic energy.

        At the state that was prepared: its dynamics have decomposed the equations.
        """
        rhs = np.concatenate((gaps, efforts))
        solution = self._decomposition.solve(rhs)
        for _ in range(rounds - 1):
            rhs[: self._rows] = gaps - self._mu * solution[: self._rows]
            solution = self._decomposition.solve(rhs)
        return np.asarray(solution[self._rows :])

    def _coupling_factors(self) -> tuple[Array, Array]:
        """Return what efforts along each coupling move `(k, nv)`, and the couplings `(k, k)`."""
        rows = self._couplings.rows
        if not self._has_couplings:
            return rows, _NO_GAINS
        none = np.zeros(self._rows)
        units = np.array([self._solved(none, row, _ROUNDS) for row in rows]).reshape(rows.shape)
        return units, units @ rows.T

    def _coupled(
        self, rates: Array, units: Array, gains: Array, gaps: Array | None = None
    ) -> Array:
        """Return rates with the least change after which the couplings gain `gaps (k,)`."""
        rows = self._couplings.rows
        if not self._has_couplings:
            return rates
        wanted = np.zeros(len(rows)) if gaps is None else gaps
        factors, *_ = np.linalg.lstsq(gains, wanted - rows @ rates, rcond=ZERO)
        return np.asarray(rates + factors @ units)

    def closed(self, x: Array, v: Array, *, crosses: bool = False) -> tuple[Array, Array]:
        """Return a state whose loops and couplings are closed again, near one that drifted.

        What is prescribed stays where it is, and keeps its speed.

        Args:
            x: coordinates `(size,)`.
            v: velocities `(nv,)`.
            crosses: whether the state is close to a crossing, where weak equations are left to it.
        """
        if not (self._rows or self._has_couplings):
            return x, v
        if not self._slides:
            return self._closed(x, v, crosses)
        x, v = self._closed(x * self._of_positions, v * self._of_rates, crosses)
        return x / self._of_positions, v / self._of_rates

    def _closed(self, x: Array, v: Array, crosses: bool) -> tuple[Array, Array]:
        """Return a closed state, see `closed`, in units of the characteristic length.

        One decomposition serves positions and speeds, as long as they are near it.
        """
        if self._is_overclosed:
            return self._by_rank.closed(x, v, strong_alone=crosses)
        if self._elimination is not None and not crosses:
            found = self._eliminated(self._elimination, x, v)
            if found is not None:
                return found
        rest, is_coupled, off = self._nothing, self._has_couplings, np.inf
        for _ in range(_MOST_STEPS):
            if off > _STALE:
                self._constrained(x, v, rest)
                factors, off = self._coupling_factors(), 0.0
                if self._is_weak or (is_coupled and self._elsewhere.is_weak_coupled(factors[1])):
                    self.was_weak = True
                    x, v = self._by_rank.closed(x, v, strong_alone=crosses)
                    if not crosses:
                        self.rounding = max(self.rounding, self._by_rank.rounding(x))
                    return x, v
            gaps, ratios = self._gaps(), self._couplings.gaps(x) if is_coupled else _NO_GAPS
            error = _greatest(gaps, ratios) if is_coupled else _greatest(gaps)
            if error <= _CLOSED:
                break
            step = self._solved(gaps, rest, 1)
            step = self._coupled(step, *factors, ratios) if is_coupled else step
            x = np.asarray(pinocchio.integrate(self.model, x, step))
            off += error
            self._place(x)
            # A step leaves as much of the error as its equations are off.
            if error <= _NEAR and error * off <= _CLOSED:
                break
        else:
            refuse_open(_greatest(self._gaps(), self._couplings.gaps(x)))
        jacobian = self._loop_jacobian()
        for _ in range(_MOST_STEPS):
            opening = lacking = jacobian.dot(v)
            if is_coupled:
                lacking = np.concatenate((opening, self._couplings.rows.dot(v)))
            # Of both only the order of magnitude counts.
            error = math.sqrt(lacking.dot(lacking) / (v.dot(v) or 1.0))
            v = v - self._solved(opening, rest, 1)
            v = self._coupled(v, *factors) if is_coupled else v
            if error <= _NEAR and error * off <= _CLOSED:
                break
        else:
            refuse_open(error)
        return x, v

    def _place(self, x: Array) -> None:
        """Put bodies and loops where they are at coordinates, for the rows of the loops there."""
        pinocchio.computeJointJacobians(self.model, self.data, x)
        for item, data in zip(self._each_model, self._each_constraint, strict=True):
            item.calc(self.model, self.data, data)

    def _eliminated(
        self, elimination: LoopElimination, x: Array, v: Array
    ) -> tuple[Array, Array] | None:
        """Return a closed state near one that drifted; None if a closure is weak, or stays open."""
        for _ in range(_MOST_STEPS):
            found = elimination.displacement(x)
            if found is None:
                return None
            step, error = found
            if error <= _CLOSED:
                break
            x = np.asarray(pinocchio.integrate(self.model, x, step))
            if error <= _NEAR:
                break
        else:
            return None
        change = elimination.slowing(x, v)
        return None if change is None else (x, v + change)

    def closure_error(self, x: Array) -> float:
        """Return the greatest closure error: angle [rad], or gap as a fraction of the length."""
        rest, x = np.zeros(self.model.nv), x * self._of_positions
        self._constrained(x, rest, rest)
        return _greatest(self._gaps(), self._couplings.gaps(x))

    def _gaps(self) -> Array:
        """Return closure errors `(6 L,)` of the state that was prepared, as the rows count them."""
        gaps = np.empty(self._rows)
        for index, item in enumerate(self._each_constraint):
            gaps[6 * index : 6 * index + 6] = pinocchio.log6(item.c1Mc2).vector
        return gaps


class _Elsewhere(NamedTuple):
    """Closure equations of a chain at other configurations, against which they may be weak.

    Whether loops are closed there makes no difference: what is redundant on closed positions alone
    is left to `_overclosed_rank`.

    Attributes:
        loops: rank of the loops' equations along free coordinates.
        coupled: what the couplings add to it.
        least: least eigenvalue of J M⁻¹ Jᵀ of the loops that is not zero.
        least_coupled: that of the couplings, as loops allow them.
        typical: least singular value of all equations that is not zero, relative to the greatest.
    """

    loops: int
    coupled: int
    least: float
    least_coupled: float
    typical: float

    @property
    def rank(self) -> int:
        """Rank of all equations."""
        return self.loops + self.coupled

    @staticmethod
    def of(every: ClosedDirections, state: Array) -> _Elsewhere:
        """Look at some configurations about a state.

        Args:
            every: the equations.
            state: a configuration.
        """
        random = np.random.default_rng(1)
        found = []
        for _ in range(_PLACES):
            way = random.uniform(-_ELSEWHERE, _ELSEWHERE, size=every.model.nv)
            found.append(_measured(every, pinocchio.integrate(every.model, state, way)))
        loops, coupled = max(item[:2] for item in found)
        full = [item[2:] for item in found if item[:2] == (loops, coupled)]
        return _Elsewhere(loops, coupled, *np.median(full, axis=0).tolist())

    def is_weak_coupled(self, gains: Array) -> bool:
        """Return whether a coupling is weak, as loops allow it.

        Args:
            gains: what efforts along the couplings move them `(k, k)`.
        """
        if not self.coupled:
            return False
        values = np.linalg.svd(gains, compute_uv=False)
        return bool(np.count_nonzero(values > _WEAK * self.least_coupled) < self.coupled)

    def weakness(self, every: ClosedDirections, x: Array) -> float:
        """Return the least singular value, relative to the greatest, as a fraction of elsewhere.

        Args:
            every: the equations.
            x: a configuration.
        """
        if not self.rank:
            return 1.0
        values = np.linalg.svd(every.jacobian(x)[:, every.free], compute_uv=False)
        return float(values[self.rank - 1] / values[0] / self.typical)


def _measured(every: ClosedDirections, x: Array) -> tuple[int, int, float, float, float]:
    """Return ranks and least values of loops and of couplings, and of all equations."""
    rows = every.jacobian(x)[:, every.free]
    root = np.linalg.cholesky(every.metric(x))
    weighted = np.linalg.solve(root, rows.T).T
    count = every.loop_rows
    left = weighted[count:]
    rank, least = 0, 1.0
    if count and every.free.size:
        _, values, right = np.linalg.svd(weighted[:count], full_matrices=False)
        rank = rank_of(values)
        least = float(values[rank - 1]) ** 2 if rank else 1.0
        left = left - left @ right[:rank].T @ right[:rank]
    coupled, least_coupled = 0, 1.0
    if len(left) and every.free.size:
        values = np.linalg.svd(left, compute_uv=False)
        sizes = np.linalg.norm(weighted[count:], axis=1)
        coupled = int(np.count_nonzero(values > ZERO * np.max(sizes)))
        least_coupled = float(values[coupled - 1]) ** 2 if coupled else 1.0
    values = np.linalg.svd(rows, compute_uv=False)
    both = rank + coupled
    typical = float(values[both - 1] / values[0]) if both else 1.0
    return rank, coupled, least, least_coupled, typical


class _Couplings:
    """The couplings of a chain.

    Attributes:
        rows: `(k, nv)`, whose products with rates vanish where couplings hold.
    """

    def __init__(self, mechanism: Mechanism | WithBalls, chain: Chain) -> None:
        coordinates = mechanism.coordinates
        chosen = [mechanism.couplings[index] for index in chain.couplings]
        rows = np.zeros((len(chosen), mechanism.model.nv))
        for row, coupling in zip(rows, chosen, strict=True):
            row[list(coupling.predecessor_columns)] += coupling.ratio
            row[list(coupling.successor_columns)] -= 1.0
        self.rows = (rows * coordinates.rate_scale)[:, chain.rates]
        self._offsets = np.array([item.offset for item in chosen])
        columns, rates = coordinates.scalars
        own = np.isin(rates, chain.rates)
        self._columns = np.searchsorted(chain.columns, columns[own])
        self._rates = np.searchsorted(chain.rates, rates[own])

    def gaps(self, x: Array) -> Array:
        """Return by how much they are off `(k,)` at coordinates, as their rows count it."""
        if not len(self.rows):
            return _NO_GAPS
        moved = np.zeros(self.rows.shape[1])
        moved[self._rates] = x[self._columns]
        return -(self.rows @ moved + self._offsets)


def _lent_inertia(inertia: Array, free: Array) -> float:
    """Return the inertia that every joint is lent, 0 if there is one in all directions."""
    own = inertia[np.ix_(free, free)]
    scale = np.sqrt(np.diag(own))
    if not free.size:
        return 0.0
    if np.all(scale > 0.0):
        least = float(np.min(np.linalg.eigvalsh(own / scale / scale[:, None])))
        if least > _WEIGHTLESS and np.min(scale) > np.sqrt(_WEIGHTLESS) * np.max(scale):
            return 0.0
    return _LENT * float(np.max(scale)) ** 2 or 1.0


def _greatest(*values: Array) -> float:
    """Return the greatest absolute value of arrays, of which some may be empty."""
    # Of so few numbers NumPy's reductions take five times as long.
    sizes = [abs(size) for item in values for size in item.tolist()]
    # Whether Python's greatest of them is a NaN would depend on their order; a sum always is.
    return max(sizes, default=0.0) if sum(sizes) < np.inf else np.inf


def _overclosed_rank(
    every: ClosedDirections, state: Array, closed: Callable[[Array], Array]
) -> int | None:
    """Return the rank of equations that are redundant only where loops are closed; None if not."""
    if not every.loop_rows:
        return None
    nv, free = every.model.nv, every.free
    ways = np.zeros((len(_MOVED) + 1, nv))
    ways[:, free] = np.random.default_rng(0).normal(size=(len(ways), free.size))

    def displaced(size: float, way: Array) -> Array:
        return np.asarray(pinocchio.integrate(every.model, state, size * way))

    opened = every.rank(displaced(_OPEN, ways[-1]))
    here = every.rank(state)
    if here == opened:
        return None
    # The state itself may be singular.
    moved = [closed(displaced(size, way)) for size, way in zip(_MOVED, ways, strict=False)]
    rank = max(here, *map(every.rank, moved))
    return None if rank == opened else rank
