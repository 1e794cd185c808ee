"""Extremes: the greatest and least wrenches and efforts of a sweep, and where they occur."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ...core.description.origins import PREFIX
from ...core.dynamics.problem_solver import ProblemSolver
from ...core.elements.link_loads import Wrench
from ...core.results.lost_digits import lost_part
from ...core.results.sweep import Sweep, coupling_unit
from ...figures.wrenches import PARTS, QUANTITIES, determined, values_of
from ...kit.arrays import BLOCK_SIZE, EPS, NOTHING, ROUNDED, Array
from ...kit.errors import CardanError, ModelError
from ...kit.quantities import amount, span
from ...motion.simulation.trajectory import Trajectory
from ...scene.scene import Scene
from .panels import DEGREE, MOST, Known, Tolerance, greatest

RIGHT = 1e-6
"""Error of an extreme, as a part of the size of its quantity, above which it is in doubt."""
SIZES = ("force", "shear", "moment", "bending")
"""Those that are sizes, whose squares are smooth where they vanish."""


class Extreme(NamedTuple):
    """A quantity over the sweep: how great and how small it is, and where.

    Attributes:
        owner: name of the joint, drive, coupling or element.
        quantity: `force`, `axial`, `shear`, `moment`, `torsion`, `bending` of a `JointWrench`, or
            `drive effort`, `holding effort`, `coupling effort`, or what an element exerts.
        unit: of the values.
        greatest, least: values; the same where it is constant.
        greatest_at, least_at: `(n, d)` drive positions where these occur [rad or m], or times
            `(n, 1)` [s] of a sweep over time; empty where it is constant.
        determined: whether it follows from the laws of motion alone. If not, it was chosen by the
            `rule` of the sweep.
        error: by how much the quantity may exceed them anywhere in the range, measured, infinite
            where that is not known; NaN if they are those of the samples alone.
    """

    owner: str
    quantity: str
    unit: str
    greatest: float
    greatest_at: Array
    least: float
    least_at: Array
    determined: bool
    error: float

    @property
    def acts(self) -> bool:
        """Whether it is ever different from zero."""
        return bool(self.greatest or self.least)

    @property
    def size(self) -> float:
        """Greatest absolute value."""
        return abs(self.ends[0][0])

    @property
    def ends(self) -> tuple[tuple[float, Array], tuple[float, Array]]:
        """Both with their places: what is greatest in size, with its sign, and the other end."""
        up, down = (self.greatest, self.greatest_at), (self.least, self.least_at)
        return (up, down) if abs(up[0]) >= abs(down[0]) else (down, up)

    @property
    def settled(self) -> bool:
        """Whether nothing is known to exceed it by more than a millionth of its size."""
        return not self.error > RIGHT * self.size

    @property
    def marked(self) -> str:
        """The quantity, with a star if statics leaves it open, and a ? if it may be exceeded."""
        return f"{self.quantity}{' *' * (not self.determined)}{' ?' * (not self.settled)}"


class Quantity(NamedTuple):
    """Something that is sought: whose and which it is, its unit, and of which drive or element."""

    owner: str
    name: str
    unit: str
    determined: bool
    place: int = -1

    def values(self, sweep: Sweep) -> Array:
        """Return what it is `(N,)` in a sweep."""
        if self.name == "drive effort":
            return np.reshape(sweep.drive_effort, (len(sweep), -1))[:, self.place]
        if self.place >= 0:
            return np.asarray(getattr(sweep.element_force[self.place], self.name))
        if self.name in QUANTITIES:
            return values_of(sweep[self.owner], self.name)
        of = sweep.holding_effort if self.name == "holding effort" else sweep.coupling_moment
        return of[self.owner]


class Extremes(NamedTuple):
    """What was found, and what could not be known.

    Attributes:
        rows: an extreme each, joint by joint.
        search: over the range of the only drive, or the time of a trajectory; None if they were
            not sought between samples.
        covered: what they are the extremes of, if not of a range.
        unknown: why they may be exceeded; empty if they are not.
        rounding: of the greatest wrench, as a part of it, by the condition where it is great.
    """

    rows: tuple[Extreme, ...]
    search: Search | None
    covered: str
    unknown: str
    rounding: float


def places_of(sweep: Sweep) -> Array:
    """Return where its samples are: times `(N, 1)` of a sweep over time, or its drives `(N, d)`."""
    if is_over_time(sweep):
        return sweep.time[:, None]
    return np.reshape(sweep.position, (len(sweep), -1))


def is_over_time(sweep: Sweep) -> bool:
    """Return whether each sample of a sweep is later than the one before."""
    return sweep.time.ndim == 1 and len(sweep) > 1 and bool(np.all(np.diff(sweep.time) > 0.0))


def extremes(
    sweep: Sweep, box: Array | None = None, trajectory: Trajectory | None = None
) -> Extremes:
    """Return the extremes of the wrenches and efforts of a sweep, joint by joint.

    Those of a sweep with one drive at constant rates and loads are those of the whole range between
    its first and last position, however few samples it has: see `panels`; likewise those of a
    trajectory between its first and last time. Several drives are looked through on a grid, from
    the best positions of which the way is followed uphill. All others are those of the samples.

    Args:
        sweep: over one dimension.
        box: `(d, 2)` ranges of several drives at rest, if all of them are meant.
        trajectory: that it is the sweep along.
    """
    quantities = [*quantities_of(sweep)]
    at = places_of(sweep)
    samples = _values(quantities, sweep)
    rounding = _Rounding.of(sweep, quantities, samples)
    error, known_search = np.full(len(quantities), np.nan), None
    given, varies = _fixed_case(sweep)
    covered, unknown = f"the {counted(len(sweep))}", ""
    if np.isnan(samples).any():
        unknown = "some samples are not known themselves"
    elif box is not None and len(box) > 1:
        at, samples, covered, unknown = _uphill(sweep, quantities, box, at, samples)
    elif is_over_time(sweep) and trajectory is None:
        covered += f" from {span(float(sweep.time[0]), float(sweep.time[-1]), 's', ' to ')}"
    elif varies and not (trajectory and is_over_time(sweep)):
        covered += f", as {varies}"
    elif len(np.unique(at)) == 1:
        error[:] = 0.0
    else:
        try:
            search = Search.along(trajectory) if trajectory else Search.of_drive(sweep, given)
            at, samples, error, rounding = search.found(quantities, samples)
            known_search, covered = search, ""
        except CardanError as failure:
            unknown = f"what is between them cannot be solved: {failure}"
    if unknown:
        error[:] = np.inf
    floor, is_turn = rounding.floor, known_search is not None and known_search.is_turn
    samples = np.where(np.abs(samples) <= floor, 0.0, samples)
    rows = []
    for index, item in enumerate(quantities):
        up, down = (_places(at, side * samples[:, index], is_turn) for side in (1.0, -1.0))
        top, bottom = up[0] + 0.0, 0.0 - down[0]  # Without the sign of a negative zero.
        is_constant = top - bottom <= NOTHING * max(abs(top), abs(bottom))
        nowhere = np.zeros((0, at.shape[1]))
        rows.append(
            Extreme(
                item.owner,
                item.name,
                item.unit,
                top,
                nowhere if is_constant else up[1],
                top if is_constant else bottom,
                nowhere if is_constant else down[1],
                item.determined,
                0.0 if error[index] <= floor[index] else float(error[index]),
            )
        )
    loose = [item for item in rows if not item.settled]
    if loose and not unknown:
        worst = max(loose, key=lambda item: item.error / item.size if item.size else np.inf)
        unknown = (
            f"{worst.quantity} of {worst.owner} may exceed what was found by {worst.error:.2g} "
            f"{worst.unit}, as it does not settle however close positions are to each other"
        )
    return Extremes(tuple(rows), known_search, covered, unknown, rounding.part)


def with_extremes(trajectory: Trajectory) -> tuple[Trajectory, str]:
    """Return a trajectory at its times and those of its extremes, and why these may be exceeded."""
    found = extremes(trajectory.sweep, trajectory=trajectory)
    places = [end[:, 0] for row in found.rows for end in (row.greatest_at, row.least_at)]
    return trajectory.at(np.unique(np.concatenate([trajectory.time, *places]))), found.unknown


def counted(count: int, name: str = "sample") -> str:
    """Return how many there are of what has a name."""
    return f"{count} {name}{'s' * (count != 1)}"


def _values(quantities: list[Quantity], sweep: Sweep) -> Array:
    """Return `(N, K)` all quantities of a sweep."""
    return np.stack([item.values(sweep) for item in quantities], axis=1)


def _fixed_case(sweep: Sweep) -> tuple[dict[str, Any], str]:
    """Return the arguments that all samples of a sweep have in common, or why there are none."""
    if sweep.free:
        return {}, "joints are free to move between them"
    if len(sweep.coordinates) != 1:
        return {}, "several drives move, and which way from sample to sample is not known"
    rates = {name: getattr(sweep, name) for name in ("speed", "acceleration", "time")}
    given = {name: dict(getattr(sweep, name)) for name in ("held", "loads", "inertia")}
    every = [(rates, name, name) for name in rates]
    every += [(part, name, f"{what} {name}") for what, part in given.items() for name in part]
    gravity, differing = np.reshape(sweep.gravity, (-1, 3)), []
    for part, name, said in every:
        value = part[name]
        if isinstance(value, Wrench):
            varies = max(np.ndim(value.force), np.ndim(value.moment)) > 1
        else:
            part[name] = float(np.ravel(value)[0])
            varies = bool(np.any(value != part[name]))
        differing += [said] * varies
    differing += ["gravity"] * bool(np.any(gravity != gravity[0]))
    if differing:
        return {}, f"{differing[0]} differs from sample to sample"
    return {**rates, "gravity": gravity[0], **{k: part or None for k, part in given.items()}}, ""


def _range(sweep: Sweep, solver: ProblemSolver) -> tuple[tuple[float, float], int, bool]:
    """Return between which positions a drive moves, a number of panels, and if it is a turn.

    Raises:
        CardanError: it is too long.
    """
    at = np.unique(sweep.position)
    low, high = float(at[0]), float(at[-1])
    if sweep.mechanism.drivable[sweep.coordinates[0]].slides:
        return (low, high), 2 * DEGREE, False
    turn = 2.0 * np.pi
    steps = np.diff(at)
    # Even samples of a turn may leave out its end, where it begins again.
    around = high + float(np.mean(steps))
    closes = round((around - low) / turn)
    slack = NOTHING * around - NOTHING * low
    if len(at) > 2 and closes and abs(around - low - turn * closes) <= slack:
        high = low + turn * closes if np.ptp(steps) <= slack else high
    period = np.inf
    if high - low > turn * (1.0 - NOTHING):
        with suppress(CardanError):
            period = solver.assembly.period() or np.inf
    high = min(high, low + period)
    is_turn = high - low > period * (1.0 - NOTHING)
    count = int(np.ceil((high - low) / turn * 2 * DEGREE))
    if count * DEGREE > MOST:
        raise ModelError(f"{(high - low) / turn:.4g} turns do not bring it back to where it was")
    return (low, high), count, is_turn


def quantities_of(sweep: Sweep) -> Iterator[Quantity]:
    """Return what is sought: of wrenches, then of drives, held joints, couplings and elements.

    What holds a length or an angle (`origin:JOINT.x`) is no part of the machine, and carries what
    the joint behind it does; only where one is driven its effort is sought.
    """
    for joint, wrench in sweep.items():
        if joint.startswith(PREFIX):
            continue
        # The axis of a universal joint is that of its cross, along which nothing is sized.
        is_cross = sweep.mechanism.joint(joint).type == "universal"
        along_and_across = ("force", *PARTS["force"], *PARTS["moment"])
        for name in along_and_across if wrench.has_axis and not is_cross else PARTS:
            yield Quantity(joint, name, QUANTITIES[name], determined(wrench, name))
    units = {name: item.effort_unit for name, item in sweep.mechanism.drivable.items()}
    try:
        count = np.reshape(sweep.drive_effort, (len(sweep), -1)).shape[1]
    except ModelError:  # The outputs leave them out.
        count = 0
    for index, name in enumerate(sweep.coordinates[:count]):
        if name not in sweep.free:  # What is free moves without any effort.
            yield Quantity(name, "drive effort", units[name], True, index)
    for name in sweep.holding_effort:
        if not name.startswith(PREFIX):
            yield Quantity(name, "holding effort", units[name], True)
    for name in sweep.coupling_moment:
        is_unique = sweep.coupling_unique[name]
        yield Quantity(name, "coupling effort", coupling_unit(sweep, name), is_unique)
    for index, element in enumerate(sweep.elements):
        for item in element.quantities:
            if not item.components:
                unit = str(item.units or units.get(element.joints[0], "N·m"))
                owner = element.name or f"elements[{index}]"
                yield Quantity(owner, item.field, unit, True, index)


class Search(NamedTuple):
    """Looks for extremes over the range of a drive, all else being constant, or over time.

    Attributes:
        ends: between which positions of the drive [rad or m], or times [s].
        panels: how many to begin with.
        is_turn: whether the last position is the first one again.
        known: `(N,)` positions or times at which the quantities are known.
        solved: returns the sweep at others.
        rough: what a solution may be off, as a part of the size of a quantity.
    """

    ends: tuple[float, float]
    panels: int
    is_turn: bool
    known: Array
    solved: Callable[[Array], Sweep]
    rough: float = 0.0

    @classmethod
    def of_drive(cls, sweep: Sweep, given: dict[str, Any]) -> Search:
        """Return that over a drive, with the arguments that all samples have in common."""
        solver = ProblemSolver(sweep.problem)
        ends, count, is_turn = _range(sweep, solver)
        solved = partial(Scene._of(solver).sweep, **given)
        return cls(ends, count, is_turn, np.ravel(sweep.position), solved)

    @classmethod
    def along(cls, trajectory: Trajectory) -> Search:
        """Return that over the time of a trajectory, which is known to the errors of its steps."""
        time = trajectory.time
        count = int(np.ceil(len(time) / DEGREE))
        if count * DEGREE > MOST:
            raise ModelError(f"there are {len(time)} times")

        def solved(at: Array) -> Sweep:
            found = trajectory.at(at)
            if found.singular.any():
                first = amount(float(found.time[found.singular][0]), "s")
                raise ModelError(
                    f"at t = {first} the configuration is singular, and no free coordinate decides "
                    "the motion there"
                )
            return found.sweep

        return cls((float(time[0]), float(time[-1])), count, False, time, solved, 0.1 * RIGHT)

    def evenly(self, count: int) -> Sweep:
        """Return a sweep at so many even steps over the range, without its end."""
        return self.solved(np.linspace(*self.ends, count, endpoint=False))

    def found(
        self, quantities: list[Quantity], samples: Array
    ) -> tuple[Array, Array, Array, _Rounding]:
        """Return where quantities are known, what they are there, and how much that may miss.

        Args:
            quantities: K of them.
            samples: `(N, K)` of the sweep.

        Returns:
            `(M, 1)` positions; `(M, K)` quantities; `(K,)` errors of their extremes; what
            rounding makes of them.

        Raises:
            CardanError: a position cannot be solved.
        """
        even = np.linspace(*self.ends, self.panels * DEGREE // 2 + 1)
        first = self.solved(even)
        values, is_size = _values(quantities, first), np.isin([q.name for q in quantities], SIZES)
        rounding = _Rounding.of(first, quantities, values)
        inside = (self.known >= self.ends[0]) & (self.known <= self.ends[1])
        at = np.concatenate([self.known[inside], even])
        values = np.concatenate([samples[inside], values])
        size = np.abs(values).max(axis=0)
        # The least size that is not zero is found as well as the greatest one by its square.
        enough = np.where(is_size, (0.3 * RIGHT * size) ** 2, 1e-3 * RIGHT * size)
        tolerance = Tolerance(
            np.tile(np.maximum(enough, np.where(is_size, 0.0, rounding.floor)), 2),
            np.tile(np.maximum(rounding.each, self.rough * size), 2),
            np.tile(is_size, 2),
        )

        def smooth(values: Array) -> Array:
            """Return `(N, 2 K)` quantities, of sizes their squares, with both signs."""
            smooth = np.where(is_size, values**2, values)
            return np.concatenate([smooth, -smooth], axis=1)

        def both(at: Array) -> Array:
            return smooth(_values(quantities, self.solved(at)))

        known, error = greatest(both, self.ends, self.panels, Known(at, smooth(values)), tolerance)
        values = known.values[:, : len(size)]
        values = np.where(is_size, np.sqrt(np.abs(values)), values)
        more, less = np.split(error, 2)
        # A size is the root of what was looked for.
        top, bottom = values.max(axis=0), values.min(axis=0)
        more = np.where(is_size, np.sqrt(top**2 + more) - top, more)
        less = np.where(is_size, bottom - np.sqrt(np.maximum(bottom**2 - less, 0.0)), less)
        return known.at[:, None], values, np.maximum(more, less), rounding


def _uphill(
    sweep: Sweep, quantities: list[Quantity], box: Array, at: Array, samples: Array
) -> tuple[Array, Array, str, str]:
    """Return where quantities are known within a box of drives, what they are, what was covered.

    Args:
        sweep: of d drives.
        quantities: K of them.
        box: `(d, 2)`.
        at: `(N, d)` positions of the samples.
        samples: `(N, K)`.
    """
    scene, count = Scene._of(ProblemSolver(sweep.problem)), len(box)
    covered = f"the {counted(len(at))}"
    steps = int(BLOCK_SIZE ** (1.0 / count) * (1.0 + NOTHING))
    if steps < 2:
        return at, samples, covered, f"a box of {count} drives has too many corners"
    sides = [np.linspace(low, high, steps) for low, high in box]
    grid = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, count)

    def told(positions: Array) -> tuple[Array, Array]:
        """Return which of positions are within reach, and quantities there, which are kept."""
        nonlocal at, samples
        within = scene.reachable(positions)
        found = np.full((len(positions), 2 * len(quantities)), -np.inf)
        if within.any():
            values = _values(quantities, scene.sweep(positions[within]))
            found[within] = np.concatenate([values, -values], axis=1)
            at = np.concatenate([at, positions[within]])
            samples = np.concatenate([samples, values])
        return within, found

    try:
        within, _ = told(grid)
        covered += f" and {within.sum()} of {len(grid)} positions of a grid over all ranges"
        both = np.concatenate([samples, -samples], axis=1)
        place, top = at[both.argmax(axis=0)], both.max(axis=0)
        step = np.full(len(top), 0.5 / (steps - 1))
        moves = np.concatenate([np.eye(count), -np.eye(count)]) * np.ptp(box, axis=1)
        asked = len(at)
        climbing = np.flatnonzero(np.ptp(both, axis=0) > NOTHING * np.abs(both).max(axis=0))
        while len(climbing) and len(at) - asked < 4 * BLOCK_SIZE:
            around = place[climbing, None] + step[climbing, None, None] * moves
            around = np.clip(around, box[:, 0], box[:, 1])
            distinct, back = np.unique(around.reshape(-1, count), axis=0, return_inverse=True)
            within, values = told(distinct)
            back = back.reshape(around.shape[:2])
            beside = values[back, climbing[:, None]]
            best = beside.argmax(axis=1)
            higher = beside.max(axis=1) > top[climbing]
            moved = climbing[higher]
            place[moved] = distinct[back[higher, best[higher]]]
            top[moved] = beside.max(axis=1)[higher]
            step[climbing[~higher]] *= 0.5
            # At a peak the value then misses the square of the step.
            climbing = climbing[step[climbing] > NOTHING**0.5]
    except CardanError as failure:
        return at, samples, covered, f"positions between them cannot be solved: {failure}"
    covered += ", from the best of which the way was followed uphill"
    unknown = "other positions of the drives may exceed them"
    if not within.all():
        unknown += ", and at the edge of what loops allow wrenches grow without limit"
    if len(climbing):
        unknown += ", as the way uphill was too long to be followed to its end"
    return at, samples, covered, unknown


class _Rounding(NamedTuple):
    """What rounding makes of quantities.

    Attributes:
        floor: `(K,)` up to which size they count as zero.
        each: `(K,)` rounding.
        part: of the greatest wrench, relative to it.
    """

    floor: Array
    each: Array
    part: float

    @classmethod
    def of(cls, sweep: Sweep, quantities: list[Quantity], values: Array) -> _Rounding:
        """Return that of a sweep, whose quantities are `values` `(N, K)`."""
        length = sweep.mechanism.characteristic_length
        to_moment = np.array([length if item.unit == "N" else 1.0 for item in quantities])
        sizes = np.max(np.abs(values) * to_moment, axis=1, initial=0.0)
        most = float(np.nanmax(sizes, initial=0.0))
        # Where wrenches vanish, what they are sums of is as great as ever, and so is its rounding.
        condition = np.where(np.isfinite(sweep.condition), sweep.condition, 1.0)
        lost = 8.0 * most * lost_part(condition, sizes)
        part = lost_part(sweep.condition, sizes)
        return cls(max(ROUNDED * most, lost) / to_moment, lost / to_moment, part)


def _places(at: Array, values: Array, is_turn: bool) -> tuple[float, Array]:
    """Return the greatest of values `(N,)`, and at which of the positions `(N, d)` it occurs.

    Args:
        at: positions; those of a single drive in any order.
        values: there.
        is_turn: whether the last position is the first one again.
    """
    top = float(np.nanmax(values))
    order = np.argsort(at[:, 0], kind="stable") if at.shape[1] == 1 else np.arange(len(at))
    near = values[order] >= top - NOTHING * float(np.nanmax(np.abs(values)))
    # Positions beside each other are one place: that of the greatest value, and of the first one
    # that was known where only rounding tells them apart, as it is a round number.
    starts = np.flatnonzero(near & ~np.concatenate([[False], near[:-1]]))
    ends = np.flatnonzero(near & ~np.concatenate([near[1:], [False]])) + 1
    found = []
    for start, end in zip(starts, ends, strict=True):
        own = np.sort(order[start:end])
        equal = values[own] >= values[own].max() - 16.0 * EPS * abs(top)
        found.append(int(own[equal.argmax()]))
    if is_turn and len(found) > 1 and starts[0] == 0 and ends[-1] == len(at):
        found.pop()
    # More of them tell nobody where to look.
    return top, at[found[:8]]
