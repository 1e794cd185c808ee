"""Layout: lengths, slopes and places of bearings that may vary between bounds, with the forks."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic

import numpy as np

from ....kit.arrays import NOTHING, Array
from ....kit.checks import described, interval
from ....kit.errors import ArgumentError, ModelError, choices
from ..line.geometry import residual_angles
from ..line.supports import supports
from .fork_choice import Allowed, least_residual, phases_of, tooth_offsets
from .fork_polygon import angle, distance, least_greatest
from .fork_search import descended
from .phasing import (
    FINE,
    ROUGH,
    ForkTask,
    Line,
    Phasing,
    fork_task,
    in_words,
    phased,
    squares_of,
    with_forks,
)
from .support_loads import SupportLoads, support_loads

Place = tuple[int | str, ...]
"""Where a variable stands in the shafts of a line: their fields and indices, from the outside."""
_FORKS = 128
"""Fork positions that each layout is judged by while the search goes on."""
_POPULATION, _GENERATIONS = 8, 30
"""Layouts per variable and generations of differential evolution: some hundreds per variable."""
_ROUNDS = 3
"""Times that layout and forks descend together after the search, and forks are searched anew."""


@dataclass(frozen=True, eq=False, repr=False)
class Layout(Generic[Line]):
    """The best values of what may vary, and the best forks with them.

    Attributes:
        values: name of each variable to its value [m or rad].
        at_bounds: names of the variables that stand at a bound: room beyond it would help.
        idle: names of variables without influence on the best value, wherever they are within their
            bounds; they stay as they were given, or at the bound next to that.
        phasing: forks of the line with these values; `phasing.given` is that line with the forks
            as they were.
        given: the line that was given.
        given_value: value of the objective of the line that was given [rad or N].
        given_phased_value: its value with the best forks alone [rad or N].
        searched: number of layouts that were looked at. The optimum of the forks may be proven,
            that of the layout is searched for.
    """

    values: Mapping[str, float]
    at_bounds: tuple[str, ...]
    idle: tuple[str, ...]
    phasing: Phasing[Line]
    given: Line
    given_value: float
    given_phased_value: float
    searched: int

    def __repr__(self) -> str:
        objective = self.phasing.objective
        best, given = (in_words(objective, item) for item in (self.value, self.given_value))
        values = ", ".join(f"{name} {value:.5g}" for name, value in self.values.items())
        idle = f"; without influence: {', '.join(self.idle)}" if self.idle else ""
        told = f"{best}, given {given}; {values}{idle}"
        return f"<Layout of {self.line.name!r} by {objective}: {told}>"

    @property
    def line(self) -> Line:
        """The best line."""
        return self.phasing.line

    @property
    def value(self) -> float:
        """Value of the objective of the best line [rad or N]."""
        return self.phasing.value


def layout(
    line: Line,
    free: Mapping[str, Sequence[float]],
    objective: str = "residual_angle",
    **options: Any,
) -> Layout[Line]:
    """Return values of lengths, slopes and places that make an objective least, with the forks.

    Forks are put as `phasing` does, for every layout that is looked at. Layouts are searched
    for by differential evolution and a local search after it.

    Args:
        line: the line.
        free: variables with their bounds [m or rad]: `SHAFT.length`, `SHAFT.slope_side`,
            `SHAFT.slope_plan`, `SHAFT.start_x` … `SHAFT.end_z` of shafts given by points, and
            `BEARING.distance`. Layouts that cannot be put together are left out.
        objective: as of `phasing`.
        options: others of `phasing`.

    Raises:
        ArgumentError: bounds that are none, and as `phasing` does.
        ModelError: there is no such variable, and as `phasing` does.
    """
    places, bounds = _variables(line, free)
    task = fork_task(line, objective, **options)
    before = phased(line, task)
    start = np.clip(_values(line, places), *bounds.T)
    if objective == "residual_angle":
        least = _residual(line, places, task)
    else:
        least = _force(line, places, task, _sampled(task.allowed, before.fork_offsets))
    found, searched = _searched(least, bounds, start)
    result = phased(_with(line, places, found), task)
    for _ in range(_ROUNDS if objective == "bearing_force" else 0):
        refined = _with_forks(result.line, places, bounds, task)
        again = phased(refined, task)
        if again.value >= result.value:
            break
        result, found = again, _values(refined, places)
    idle = _idle(least, bounds, start, found)
    if np.any(found[idle] != start[idle]):
        found = np.where(idle, start, found)
        result = phased(_with(result.line, places, found), task)
    if result.value >= before.value and np.all(start == _values(line, places)):
        result, found = before, start
    gaps = np.minimum(found - bounds[:, 0], bounds[:, 1] - found) / np.ptp(bounds, axis=1)
    return Layout(
        values={name: float(value) for name, value in zip(places, found, strict=True)},
        at_bounds=tuple(np.array([*places])[~idle & (gaps <= NOTHING)].tolist()),
        idle=tuple(np.array([*places])[idle].tolist()),
        phasing=result,
        given=line,
        given_value=before.given_value,
        given_phased_value=before.value,
        searched=searched,
    )


def _variables(line: Line, free: Mapping[str, Sequence[float]]) -> tuple[dict[str, Place], Array]:
    """Return where variables stand, and their bounds `(v, 2)`."""
    if not isinstance(free, Mapping) or not free:
        raise ArgumentError(
            f"free is {described(free)}, expected names of variables with their bounds, like "
            '{"shaft_1.length": (0.8, 1.2)}'
        )
    known = _known(line)
    bounds = []
    for name, limits in free.items():
        if name not in known:
            raise ModelError(
                f"the line has no variable {name!r}; variables: {choices(known, name)}",
                name=name if isinstance(name, str) else None,
            )
        bounds.append(interval(f"bounds of {name}", limits))
    return {name: known[name] for name in free}, np.array(bounds)


def _known(line: Line) -> dict[str, Place]:
    known: dict[str, Place] = {}
    for index, (name, shaft) in enumerate(zip(line.shaft_names, line.shafts, strict=True)):
        for end in ("start", "end"):
            if getattr(shaft, end) is not None:
                known |= {f"{name}.{end}_{axis}": (index, end, i) for i, axis in enumerate("xyz")}
        if shaft.end is None:
            fields = [] if shaft.centring is not None else ["slope_side", "slope_plan"]
            fields += [] if shaft.length is None else ["length"]
            known |= {f"{name}.{field}": (index, field) for field in fields}
    if line.bearings:
        numbers = [i for shaft in line.shafts for i in range(len(shaft.bearings))]
        for item, number in zip(supports(line).bearings, numbers, strict=True):
            known[f"{item.name}.distance"] = (item.shaft, "bearings", number, "distance")
    return known


def _value(holder: Any, place: Place) -> float:
    for step in place:
        holder = getattr(holder, step) if isinstance(step, str) else holder[step]
    return float(holder or 0.0)


def _changed(holder: Any, place: Place, value: float) -> Any:
    """Return a dataclass or a tuple with another value at a place in it."""
    if not place:
        return value
    step, rest = place[0], place[1:]
    if isinstance(step, str):
        return dataclasses.replace(holder, **{step: _changed(getattr(holder, step), rest, value)})
    return (*holder[:step], _changed(holder[step], rest, value), *holder[step + 1 :])


def _values(line: Line, places: Mapping[str, Place]) -> Array:
    return np.array([_value(line.shafts, place) for place in places.values()])


def _with(line: Line, places: Mapping[str, Place], values: Array) -> Line:
    """Return a line with other values of its variables."""
    shafts = line.shafts
    for place, value in zip(places.values(), values.tolist(), strict=True):
        shafts = _changed(shafts, place, value)
    return dataclasses.replace(line, shafts=shafts)


Value = Callable[[Array], float]
"""Values of the variables `(v,)` to the objective; infinite where no line can be put together."""


def _residual(line: Line, places: Mapping[str, Place], task: ForkTask) -> Value:
    """Return the least residual angle of layouts with their best forks."""
    corners, allowed = task.corners, task.allowed

    def least(values: Array) -> float:
        try:
            varied = _with(line, places, values)
        except ModelError:
            return np.inf
        betas, planes = varied.uneven_angles, varied.geometry.plane_offsets
        if all(item is None for item in allowed):
            return float(angle(least_greatest(distance(betas), corners)))
        found = least_residual(betas, planes, allowed, corners, varied.fork_offsets, 1)
        angles = residual_angles(betas, phases_of(found.offsets, planes))
        return float(angles[:, np.array(corners) - 1].max(axis=1).min())

    return least


def _force(line: Line, places: Mapping[str, Place], task: ForkTask, forks: Array) -> Value:
    """Return the greatest force per torque of layouts with the best of some forks `(c, n - 1)`."""

    def least(values: Array) -> float:
        try:
            varied = _with(line, places, values)
            loads = support_loads(varied, task.bearings)
        except ModelError:
            return np.inf
        squares = squares_of(loads, forks, varied.geometry.plane_offsets, ROUGH)
        return float(np.sqrt(squares.max(axis=1).min()))

    return least


def _with_forks(line: Line, places: Mapping[str, Place], bounds: Array, task: ForkTask) -> Line:
    """Return a line whose layout and free forks have descended together to the least force."""
    free = np.array([item is None for item in task.allowed])
    span, count, known = (
        np.ptp(bounds, axis=1),
        len(places),
        dict[bytes, tuple[SupportLoads, Array]](),
    )

    def put(variables: Array) -> tuple[Array, Array]:
        """Values of variables of the layout, which count in parts of their range, and forks."""
        offsets = np.array(line.fork_offsets)
        offsets[free] = variables[count:]
        return bounds[:, 0] + span * variables[:count], offsets

    def squares(candidates: Array) -> Array:
        rows = []
        for values, offsets in map(put, candidates):
            key = values.tobytes()
            if key not in known:
                varied = _with(line, places, values)
                loads = support_loads(varied, task.bearings)
                known[key] = loads, varied.geometry.plane_offsets
            loads, planes = known[key]
            rows.append(squares_of(loads, offsets[None], planes, FINE))
        return np.concatenate(rows)

    unlimited = np.full(int(free.sum()), np.inf)
    start = np.append((_values(line, places) - bounds[:, 0]) / span, line.fork_offsets[free])
    low, high = np.append(np.zeros(count), -unlimited), np.append(np.ones(count), unlimited)
    try:
        values, offsets = put(descended(squares, start, low, high)[0])
    except ModelError:  # A layout nearby cannot be put together.
        return line
    return with_forks(_with(line, places, values), offsets)


def _sampled(allowed: Allowed, best: Array) -> Array:
    """Return forks `(c, n - 1)` drawn evenly from what they can take, and the best known ones."""
    from scipy.stats import qmc  # Imported here: only searches need it.

    points = qmc.Halton(len(allowed), seed=0).random(_FORKS)
    columns = []
    for column, values in zip(points.T, allowed, strict=True):
        listed = tooth_offsets(0.0, 360) if values is None else values
        columns.append(listed[np.minimum((column * len(listed)).astype(int), len(listed) - 1)])
    return np.vstack([best, np.stack(columns, axis=1)])


def _searched(least: Value, bounds: Array, start: Array) -> tuple[Array, int]:
    """Return the best values of a global search with a local one after it, and its evaluations."""
    from scipy.optimize import differential_evolution  # Imported here: as above.

    result = differential_evolution(
        least,
        bounds,
        x0=start,
        popsize=_POPULATION,
        maxiter=_GENERATIONS,
        tol=1e-4,
        polish=False,
        seed=0,
        callback=lambda best, convergence: least(best) <= NOTHING,
    )
    if result.fun <= NOTHING:
        return result.x, int(result.nfev)
    found, more = _refined(least, bounds, result.x)
    return found, int(result.nfev) + more


def _idle(least: Value, bounds: Array, start: Array, found: Array) -> Array:
    """Return which variables `(v,)` may stand anywhere: at both bounds and where they began."""
    found, best, idle = found.copy(), least(found), np.zeros(len(found), dtype=bool)
    rounding = NOTHING * max(best, 1.0)
    for index, places in enumerate(np.column_stack([bounds, start])):
        others = [np.where(np.arange(len(found)) == index, place, found) for place in places]
        idle[index] = all(abs(least(values) - best) <= rounding for values in others)
        if idle[index]:  # So that all of them together have none.
            found[index] = start[index]
    return idle


def _refined(least: Value, bounds: Array, start: Array) -> tuple[Array, int]:
    from scipy.optimize import minimize  # Imported here: as above.

    options = {"xatol": 1e-9, "fatol": 1e-12, "maxiter": 100 * len(start)}
    result = minimize(least, start, method="Nelder-Mead", bounds=bounds, options=options)
    is_better = result.fun < least(start)
    return (result.x if is_better else start), int(result.nfev)
