"""Design variables: numbers of a scene as SciPy's solvers take them, with exact gradients."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..core.results.derivative import Derivative
from ..core.results.sweep import Sweep
from ..kit.arrays import NOTHING, Array
from ..kit.checks import described, mapping, number, whole
from ..kit.errors import (
    AccuracyError,
    ArgumentError,
    AssemblyError,
    CardanError,
    SingularConfigurationError,
)
from ..kit.frozen import FrozenDict, frozen
from ..kit.units import read_any

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


class DesignVariables:
    """Numbers that a search varies, each from 0 to 1 between its bounds.

    `quantity` makes functions of them with exact gradients, as `scipy.optimize` takes them. A
    solver's array may be longer than n; what follows n belongs to others.

    Attributes:
        names: of the n variables, in the order of a solver's array.
        low, high: `(n,)` bounds [SI units].
        bounds: those of a solver, zeros and ones `(n,)`; `minimize` and `least_squares` take
            `scipy.optimize.Bounds(*variables.bounds)`.
    """

    def __init__(
        self, solve: Callable[[Mapping[str, float]], Sweep], bounds: Mapping[str, Any]
    ) -> None:
        """Name the variables.

        Args:
            solve: returns the sweep of a design, which has all these values [SI units] by name.
            bounds: what varies, as `Sweep.derivative` names it, to its least and its greatest
                value: numbers in SI units, or texts such as "20 mm".

        Raises:
            ArgumentError: nothing is named, or by a pattern; or bounds are no two finite numbers in
                this order.
            ModelError: a unit is not known.
        """
        ends = [_ends(*item) for item in mapping("bounds", bounds).items()]
        if not ends:
            raise ArgumentError("bounds name no variable: {'origin:JOINT.x': (-0.01, 0.01)} does")
        self.names, (self.low, self.high) = tuple(bounds), np.transpose(ends)
        self.bounds = np.zeros(len(ends)), np.ones(len(ends))

        def swept(x: bytes) -> Sweep | CardanError:
            try:
                sweep = solve(self.values(np.frombuffer(x)))
                if not isinstance(sweep, Sweep):
                    raise ArgumentError(f"solve returned {described(sweep)}, expected a sweep")
                return sweep
            except (AssemblyError, SingularConfigurationError, AccuracyError) as error:
                return error

        def changes(x: bytes, sweep: Sweep) -> list[Derivative]:
            found: Any = sweep.derivative(*self.names)
            return [found] if len(self.names) == 1 else list(found.values())

        # An objective, its gradient and constraints ask for the same design.
        self._swept, self._changes = lru_cache(1)(swept), lru_cache(1)(changes)

    def values(self, x: ArrayLike) -> Mapping[str, float]:
        """Return the values [SI units] of a solver's array."""
        found = self.low + self._own(x) * (self.high - self.low)
        return FrozenDict(dict(zip(self.names, found.tolist(), strict=True)))

    def _own(self, x: ArrayLike) -> Array:
        own = np.ravel(np.asarray(x, dtype=float))[: len(self.names)]
        if len(own) < len(self.names):
            raise ArgumentError(f"x has {len(own)} numbers, fewer than the {len(self.names)} names")
        return own

    def starts(self, count: int, seed: int = 0) -> Iterator[Array]:
        """Yield arrays `(n,)`: those of some random designs that can be driven.

        Args:
            count: how many designs are drawn.
            seed: of the random numbers.

        Raises:
            CardanError: none of them can be driven; what the last one lacks.
        """
        drawn = np.random.default_rng(seed).random((whole("count", count), len(self.names)))
        swept: Sweep | CardanError | None = None
        driven = 0
        for x in drawn:
            swept = self._swept(x.tobytes())
            if isinstance(swept, Sweep):
                driven += 1
                yield x
        if isinstance(swept, CardanError) and not driven:
            raise swept

    def quantity(
        self, value: Callable[[Sweep], Any], change: Callable[[Sweep, Derivative], Any]
    ) -> Quantity:
        """Return a quantity of designs, with its gradient.

        Args:
            value: returns it, a number or an array, of a sweep.
            change: returns, in the same shape, how it changes with a variable, of the sweep and its
                derivative by that.
        """
        return Quantity(self, value, change)

    def review(
        self,
        result: Any,
        constraints: Sequence[Mapping[str, Any]] = (),
        *,
        within: float = 1e-3,
    ) -> Optimum:
        """Return how good a solver's result is, and what limits it.

        Args:
            result: of `minimize` or `least_squares`.
            constraints: as `minimize` had them: mappings with `type`, `fun` and `jac`.
            within: how near a limit must be to push back [widths of the bounds]. Solvers end
                before the limits that they lean on, or behind them; `optimality` counts how far.

        Raises:
            ArgumentError: `within` is no number, or negative.

        Source: Karush (1939), Kuhn and Tucker (1951).
        """
        from scipy.optimize import nnls

        within = number("within", within, least=0.0)
        x = np.asarray(result.x)
        gradient = np.ravel(result.grad if "grad" in result else result.jac)
        rows: list[tuple[str, Array, float]] = []
        for name, unit, place in zip(self.names, np.eye(len(x)), x, strict=False):
            rows += [(f"{name} least", unit, place), (f"{name} greatest", -unit, 1.0 - place)]
        own = len(rows)
        for index, item in enumerate(constraints):
            left, slopes = np.ravel(item["fun"](x)), np.atleast_2d(item["jac"](x))
            for k, (apart, slope) in enumerate(zip(left, slopes, strict=True)):
                label = f"constraints[{index}][{k}]"
                rows += [(label, slope, apart)]
                rows += [(label, -slope, -apart)] * (item["type"] == "eq")
        felt = gradient.astype(bool) | np.any([slope for _, slope, _ in rows[own:]], axis=0)
        sizes = np.array([np.linalg.norm(slope) for _, slope, _ in rows])
        room = np.maximum([apart for *_, apart in rows], 0.0)
        nearest = np.argsort(room / np.where(sizes > 0.0, sizes, np.inf), kind="stable")
        order = [k for k in nearest.tolist() if room[k] <= within * sizes[k]]
        pushing, called = np.array([slope for _, slope, _ in rows]), [name for name, *_ in rows]
        # Limits push back from the nearest one on, as far away as it takes to push best.
        best, limits = float(np.linalg.norm(gradient)), {}
        for count in range(1, len(order) + 1):
            taken = order[:count]
            multipliers, left_over = nnls(pushing[taken].T, gradient)
            # Along d, what was missed not growing:
            # -gradient·d <= left over |d| + multipliers·room.
            optimality = float(left_over + multipliers @ room[taken])
            if optimality < best:
                pairs = zip(taken, multipliers.tolist(), strict=True)
                best, limits = optimality, {called[k]: value for k, value in pairs if value}
            if left_over <= NOTHING * np.linalg.norm(gradient):  # Those farther off push no better.
                break
        return Optimum(
            values=self.values(x),
            optimality=best,
            violation=max((-float(apart) for _, _, apart in rows[own:]), default=0.0),
            limits=frozen(limits),
            idle=tuple(name for name, moves in zip(self.names, felt, strict=False) if not moves),
        )


class Quantity:
    """A quantity of designs, with its gradient; `DesignVariables.quantity` makes it.

    Where a design cannot be driven, all of it is infinite, which solvers take for too long a step;
    where the first one cannot, the reason is raised.
    """

    def __init__(
        self,
        variables: DesignVariables,
        value: Callable[[Sweep], Any],
        change: Callable[[Sweep, Derivative], Any],
    ) -> None:
        """Keep how it is computed, see `DesignVariables.quantity`."""
        self._variables, self._value, self._change = variables, value, change
        self._shape: tuple[int, ...] | None = None

    def __call__(self, x: ArrayLike) -> Any:
        """Return the quantity of a solver's array, a number or an array.

        Raises:
            CardanError: the first design of all cannot be driven.
            ArgumentError: the quantity is not finite, or `solve` returns no sweep; of a gradient,
                changes have another shape.
        """
        sweep = self._variables._swept(self._variables._own(x).tobytes())
        if isinstance(sweep, Sweep):
            values = self._finite(x, self._value(sweep))
            self._shape = values.shape
            return values[()]
        if self._shape is None:
            raise sweep
        return np.full(self._shape, np.inf)[()]

    def jac(self, x: ArrayLike) -> Array:
        """Return its gradient `(…, n)` by a solver's array; see a call for errors."""
        of, shape = self._variables, np.shape(self(x))
        key = of._own(x).tobytes()
        sweep = of._swept(key)
        if not isinstance(sweep, Sweep):
            return np.zeros((*shape, len(of.names)))
        found = [self._change(sweep, by) for by in of._changes(key, sweep)]
        for name, change in zip(of.names, found, strict=True):
            if np.shape(change) != shape:
                raise ArgumentError(
                    f"the change with {name!r} has the shape {np.shape(change)}, whereas that of "
                    f"the quantity is {shape}"
                )
        return self._finite(x, np.stack(found, axis=-1) * (of.high - of.low))

    def _finite(self, x: ArrayLike, found: Any) -> Array:
        values = np.asarray(found, dtype=float)
        if not np.all(np.isfinite(values)):
            raise ArgumentError(
                f"a quantity or its gradient is not finite at {dict(self._variables.values(x))}: "
                "components that are not unique are none, nor are changes of sizes that are zero; "
                "take others"
            )
        return values


class Optimum(NamedTuple):
    """How good a solver's result is, and what limits it.

    Attributes:
        values: of the variables [SI units].
        optimality: by how much the objective can fall at most, to first order, on a step as wide as
            the bounds: what is left of its gradient once all that limits the search has pushed
            back, and the way that is left to those limits; zero at an optimum.
        violation: by how much the worst constraint is missed; not positive where all are met, zero
            without any.
        limits: bounds and constraints that push back, to their multipliers: what the objective
            would fall by, to first order, per width of the bounds or unit of the constraint.
        idle: names of variables that nothing depends on.
    """

    values: Mapping[str, float]
    optimality: float
    violation: float
    limits: Mapping[str, float]
    idle: tuple[str, ...]


def _ends(name: str, ends: Any) -> tuple[float, float]:
    """Return the least and greatest value of a variable [SI units]."""
    label = f"bounds[{name!r}]"
    if "*" in name:
        raise ArgumentError(f"{label}: a variable has bounds of its own; name each by itself")
    if not isinstance(ends, (tuple, list, np.ndarray)) or len(ends) != 2:
        raise ArgumentError(f"{label} is {ends!r}, expected (least, greatest)")
    low, high = (
        read_any(end, label)[0] if isinstance(end, str) else number(label, end) for end in ends
    )
    if not low < high:
        raise ArgumentError(f"{label}: {low:g} is not less than {high:g}")
    return low, high
