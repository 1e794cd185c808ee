"""Workspace: which positions of two coordinates are reached, and by what that is bordered."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import product
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...kit.arrays import Array, generic
from ...kit.checks import interval, mapping, number, numbers, whole
from ...kit.errors import ArgumentError, AssemblyError, choices
from ...kit.frozen import Frozen
from ...kit.roots import zeros
from ..kinematics.assembly_modes import mode_name
from ..kinematics.tolerances import MOVES
from ..problem.problem import FIRST_MODE
from ..results.limits import UNLIMITED, described_limits
from .chart import Chart

if TYPE_CHECKING:
    from ...figures.style import Figure, Into, Size


class BorderCurve(NamedTuple):
    """A curve in the plane of two coordinates at which something ends.

    Attributes:
        kind: `reach`: loops close no farther, a singularity of the first kind, where working modes
            meet; `hold`: the actuated do not hold the mechanism, one of the second kind, which
            they cannot pass; `limit`: a joint comes to its limit; `condition`: the condition number
            passes the bound.
        joint: whose limit it is; else empty.
        position: `(k, 2)` points in their order [rad or m], each exact but for rounding, where the
            curve passes the lines of the grid; the first is the last one again where it is closed.
        is_exact: whether they are; else some are known to 1e-8 of the grid's distance, since there
            neither side decides where the other one is.
    """

    kind: str
    joint: str
    position: Array
    is_exact: bool


class Section(NamedTuple):
    """A workspace in one working mode, while other coordinates rest.

    Attributes:
        mode: name of the working mode, as of `Scene.branches`; `A` is that of the scene, unless
            all were asked for.
        at: the others to their positions [rad or m].
        reached: `(S, S)` at which positions of both axes loops close, on ways that stay in the
            grid and in the working mode.
        usable: `(S, S)` which of these are within all limits, and the bound of the condition, and
            are come to from the start without leaving them or losing hold of the mechanism.
        borders: the curves.
    """

    mode: str
    at: Mapping[str, float]
    reached: Array
    usable: Array
    borders: tuple[BorderCurve, ...]

    def border(self, kind: str, joint: str = "") -> Array:
        """Return all points `(K, 2)` of borders of a kind, and of a joint if one is named."""
        chosen = [
            curve.position
            for curve in self.borders
            if curve.kind == kind and joint in ("", curve.joint)
        ]
        return np.concatenate([np.zeros((0, 2)), *chosen])


class Workspace(Frozen):
    """Where two coordinates can be, and its borders; `Transmission.workspace`.

    Attributes:
        names: of the two coordinates.
        units: theirs, `rad` or `m`.
        grid: `(S,)` positions of each.
        sections: by working mode, then by the positions at which others rest.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    grid: tuple[Array, Array]
    sections: tuple[Section, ...]

    def __init__(
        self,
        names: tuple[str, ...],
        units: tuple[str, ...],
        grid: tuple[Array, Array],
        sections: tuple[Section, ...],
    ) -> None:
        """Keep what it is."""
        self._freeze(names=names, units=units, grid=grid, sections=sections)

    def __repr__(self) -> str:
        return f"<Workspace of {', '.join(self.names)}: {len(self.sections)} sections>"

    def plot(self, *, title: str = "", ax: Into = None, figsize: Size | None = None) -> Figure:
        """Draw what is usable and all borders, a panel for each section.

        Args:
            title: of the figure.
            ax: axes to draw into, as many as there are sections; a new figure if None.
            figsize: width and height of a new figure [inch].
        """
        from ...figures.workspaces import regions

        labels = [f"{name} [{unit}]" for name, unit in zip(self.names, self.units, strict=True)]
        several = len({section.mode for section in self.sections}) > 1
        panels = []
        for section in self.sections:
            told = [f"mode {section.mode}"] * several
            told += [f"{name} = {value:.4g}" for name, value in section.at.items()]
            curves = [
                (_TOLD[item.kind].format(item.joint), item.position) for item in section.borders
            ]
            panels.append((", ".join(told), section.usable, curves))
        return regions(self.grid, labels, panels, title=title, ax=ax, figsize=figsize)


_TOLD = {
    "reach": "end of reach",
    "hold": "motors lose hold",
    "limit": "limit of {}",
    "condition": "condition bound",
}
"""Kinds of borders in the words of a legend."""


class Rows(NamedTuple):
    """What the given side of a chart is called, and given as.

    Attributes:
        names: of the m rows; those that can be varied are names of coordinates of that side.
        start: `(m,)` where the mechanism starts [rad or m].
        placed: from rows `(N, m)` to positions of the coordinates `(N, d)`.
    """

    names: tuple[str, ...]
    start: Array
    placed: Callable[[Array], Array]


def workspace(
    chart: Chart,
    rows: Rows,
    ranges: object,
    at: object,
    samples: int,
    condition: float | None,
    every_mode: bool,
) -> Workspace:
    """Return the workspace of two rows; arguments as of `Transmission.workspace`.

    Args:
        chart: of the side that the rows give.
        rows: the rows.
        ranges: two of them to their least and greatest positions.
        at: others to positions at which they rest.
        samples: of each range.
        condition: bound, if any.
        every_mode: whether all working modes are looked for.
    """
    varied = {
        name: interval(f"ranges[{name!r}]", ends)
        for name, ends in mapping("ranges", ranges).items()
    }
    others = {} if at is None else mapping("at", at)
    resting = {name: numbers(f"at[{name!r}]", values).ravel() for name, values in others.items()}
    for name in (*varied, *resting):
        if name not in rows.names or (name in varied and name in resting):
            raise ArgumentError(
                f"ranges and at: {name!r} is none of {choices(rows.names, name)}, or is in both"
            )
    if len(varied) != 2:
        raise ArgumentError(
            f"ranges names {len(varied)} coordinates; give two, as in {{name: (low, high), …}}, "
            f"and positions of others in at={{name: values}}; coordinates: {choices(rows.names)}"
        )
    bound = np.inf if condition is None else number("condition", condition, least=1.0)
    count = whole("samples", samples, 2)
    mechanism, assembly = chart.solver.problem.mechanism, chart.solver.assembly
    grid = [np.linspace(*ends, count) for ends in varied.values()]
    # Borders pass by generic positions, where round ones may lie on them, and on their crossings.
    for axis, off in zip(grid, generic(2, count), strict=True):
        axis[1:-1] += 0.25 * off[1:-1] * (axis[1] - axis[0])
    columns, own = ([*map(names.index, varied)] for names in (rows.names, chart.given))
    starts = {FIRST_MODE: assembly.start}
    if every_mode:
        starts = {mode_name(k): poses[0] for k, poses in enumerate(assembly.modes.poses)}
    sections = []
    for values in product(*resting.values()):
        asked = np.tile(rows.start, (count**2, 1))
        asked[:, [rows.names.index(name) for name in resting]] = values
        asked[:, columns] = np.stack(np.meshgrid(*grid, indexing="ij"), -1).reshape(-1, 2)
        nodes = rows.placed(asked)
        offset = asked[0, columns] - nodes[0, own]
        for mode, start in starts.items():
            sheet = _Sheet(chart, nodes, own, count, bound)
            if sheet.begin(start):
                told = dict(zip(resting, map(float, values), strict=True))
                sections.append(sheet.section(mode, told, offset))
    if not sections:
        asked_for = ", ".join(f"{name} {low:g} to {high:g}" for name, (low, high) in varied.items())
        raise AssemblyError(
            f"{mechanism.name}: nothing of {asked_for} is reached on straight ways from where "
            "the scene starts; give other ranges, or let it start there: near="
        )
    units = tuple(mechanism.drivable[name].unit for name in varied)
    return Workspace(tuple(varied), units, (grid[0], grid[1]), tuple(sections))


class _Sheet:
    """All places of a grid in one working mode, and the places between at which something ends.

    Places are counted row by row; an edge is a pair of neighbours.
    """

    def __init__(
        self, chart: Chart, nodes: Array, own: list[int], samples: int, condition: float
    ) -> None:
        """Begin with nothing reached, at positions `(S², d)` of the given side."""
        self._chart, self._nodes, self._own, self._samples = chart, nodes, own, samples
        self._condition = condition
        self._x = np.full((len(nodes), chart.solver.assembly.start.size), np.nan)
        self._is_there = np.zeros(len(nodes), dtype=bool)
        index = np.arange(len(nodes)).reshape(samples, samples)
        pairs = (index[:-1], index[1:]), (index[:, :-1], index[:, 1:])
        self._edges = np.concatenate([np.stack(pair, axis=-1).reshape(-1, 2) for pair in pairs])
        mechanism = chart.solver.problem.mechanism
        self._limits = {
            name: (mechanism.coordinates.named[name].column, *limits)
            for name in mechanism.coordinates.named
            if (limits := described_limits(mechanism, name)) != UNLIMITED
        }
        every = [("limit", name) for name in self._limits for _ in range(2)]
        self._hold = len(every)
        self._kinds = [*every, ("hold", ""), *[("condition", "")] * (condition < np.inf)]

    def begin(self, start: Array) -> bool:
        """Return whether any place is reached from where the mechanism starts `(size,)`."""
        chart, nodes = self._chart, self._nodes
        away = (nodes - start[chart.columns]) / chart.solver.problem.mechanism.characteristic_length
        order = np.argsort(np.sum(away**2, axis=1), kind="stable")
        for tried in order[:1], order[1:]:
            found, is_there = chart.led(start[None, :], nodes[tried])
            if np.any(is_there):
                first = int(np.argmax(is_there))
                self._first = int(tried[first])
                self._x[self._first], self._is_there[self._first] = found[first], True
                return True
        return False

    def _spread(self) -> tuple[Array, Array]:
        """Reach all that can be; return edges that lead no farther, and to where they do."""
        front, both = np.array([self._first]), np.concatenate([self._edges, self._edges[:, ::-1]])
        while True:
            while front.size:
                is_front = np.zeros(len(self._x), dtype=bool)
                is_front[front] = True
                pairs = both[is_front[both[:, 0]] & ~self._is_there[both[:, 1]]]
                front = self._take(pairs, *self._led(pairs, self._chart.step))
            # What a single step does not lead to is followed, from all that are beside it.
            pairs = both[self._is_there[both[:, 0]] & ~self._is_there[both[:, 1]]]
            found, ends = self._led(pairs, self._chart.led)
            front = self._take(pairs, found, ends)
            if not front.size:
                return pairs, found

    def _led(
        self, pairs: Array, by: Callable[[Array, Array], tuple[Array, Array]]
    ) -> tuple[Array, Array]:
        if not len(pairs):
            return np.zeros((0, self._x.shape[1])), np.zeros(0, dtype=bool)
        return by(self._x[pairs[:, 0]], self._nodes[pairs[:, 1]])

    def _take(self, pairs: Array, found: Array, ends: Array) -> Array:
        """Keep where edges lead; return the places that are new."""
        new, first = np.unique(pairs[ends, 1], return_index=True)
        self._x[new], self._is_there[new] = found[ends][first], True
        return new

    def _values(self, x: Array) -> Array:
        """Return functions `(N, f)` that pass through zero at borders, and are positive inside."""
        sides = []
        for column, low, high in self._limits.values():
            sides += [x[:, column] - low, high - x[:, column]]
        slopes = self._chart.slopes(x)
        sizes = np.linalg.svd(slopes, compute_uv=False)
        sides.append(np.linalg.det(slopes))
        if self._condition < np.inf:
            sides.append(self._condition * sizes[:, -1] - sizes[:, 0])
        return np.stack(sides, axis=1)

    def section(self, mode: str, at: Mapping[str, float], offset: Array) -> Section:
        """Return all of it; what is added to positions is `(2,)`."""
        pairs, stopped = self._spread()
        edges = self._edges[np.all(self._is_there[self._edges], axis=1)]
        found, ends = self._led(edges, self._chart.step)
        far = np.flatnonzero(~ends)
        found[far], ends[far] = self._led(edges[far], self._chart.led)
        torn = ~ends
        torn[ends] = self._chart.apart(found[ends], self._x[edges[ends, 1]])
        # Where both ends of an edge are reached, and not from each other, both are borders.
        again = edges[torn][:, ::-1]
        back, returned = self._led(again, self._chart.led)
        lost = np.concatenate([pairs, edges[torn & ~ends], again[~returned]])
        near = np.concatenate([stopped, found[torn & ~ends], back[~returned]])
        edges, ends = edges[~torn], found[~torn]
        known = np.flatnonzero(self._is_there)
        values = np.full((len(self._x), len(self._kinds)), np.nan)
        values[known] = self._values(self._x[known])
        curves = [*self._curves(edges, values, ends, offset), *self._ends(lost, near, offset)]
        values[:, self._hold] *= np.sign(values[self._first, self._hold])
        shape = self._samples, self._samples
        usable = self._usable(edges, values)
        return Section(
            mode, at, self._is_there.reshape(shape), usable.reshape(shape), tuple(curves)
        )

    def _usable(self, edges: Array, values: Array) -> Array:
        """Return `(S²,)` what is come to from the first place while all values are positive."""
        good = np.all(values >= 0.0, axis=1)
        inside = edges[np.all(good[edges], axis=1)]
        inside = np.concatenate([inside, inside[:, ::-1]])
        usable = np.zeros(len(good), dtype=bool)
        usable[self._first], known = good[self._first], -1
        while known < (known := int(np.sum(usable))):
            usable[inside[usable[inside[:, 0]], 1]] = True
        return usable

    def _curves(
        self, edges: Array, values: Array, to: Array, offset: Array
    ) -> Iterator[BorderCurve]:
        """Yield where values pass through zero on edges, which lead to `(E, size)` coordinates."""
        # Behind whole turns, joints count on from where edges begin.
        ends = values[edges[:, 0]], self._values(to) if len(to) else values[:0]
        which, kind = np.nonzero(ends[0] * ends[1] < 0.0)
        if not which.size:
            return
        chosen = edges[which]
        places = self._chart.between(self._x[chosen[:, 0]], to[which])

        def look(parts: Array, lines: Array) -> Array:
            values = self._values(places(parts, lines))
            return np.asarray(values[np.arange(len(lines)), kind[lines]])

        span = np.zeros(len(which)), np.ones(len(which))
        part = zeros(look, span, (ends[0][which, kind], ends[1][which, kind]))
        for index, (name, joint) in enumerate(self._kinds):
            own = kind == index
            if np.any(own):
                at = self._placed(chosen[own], part[own], offset)
                for order in self._linked(chosen[own], at):
                    yield BorderCurve(name, joint, at[order], True)

    def _ends(self, lost: Array, near: Array, offset: Array) -> Iterator[BorderCurve]:
        """Yield where edges lead no farther than to coordinates near the end of reach."""
        if not len(lost):
            return
        found = self._chart.turning(self._x[lost[:, 0]], self._nodes[lost[:, 1]], near)
        at = self._placed(lost, found.part, offset)
        # A place of the grid that lies on a border is the end of several edges.
        at, lost, is_exact = _apart(at, lost, found.is_exact)
        for order in self._linked(lost, at):
            yield BorderCurve("reach", "", at[order], bool(np.all(is_exact[order])))

    def _placed(self, pairs: Array, part: Array, offset: Array) -> Array:
        starts, ends = (self._nodes[pairs[:, k]][:, self._own] for k in (0, 1))
        return np.asarray(starts + part[:, None] * (ends - starts) + offset)

    def _linked(self, pairs: Array, at: Array) -> Iterator[list[int]]:
        """Yield points (index) of one curve after the other: those of a cell follow each other.

        Args:
            pairs: `(K, 2)` edges on which points lie.
            at: `(K, 2)` the points.
        """
        cells = dict[int, list[int]]()
        low = np.min(pairs, axis=1)
        row, column = np.divmod(low, self._samples)
        along = np.abs(pairs[:, 1] - pairs[:, 0]) == 1  # To the next column, else to the next row.
        for point in range(len(pairs)):
            beside = (1, 0) if along[point] else (0, 1)
            for back in (0, 1):
                cell = int(row[point]) - back * beside[0], int(column[point]) - back * beside[1]
                if min(cell) >= 0 and max(cell) < self._samples - 1:
                    cells.setdefault(cell[0] * self._samples + cell[1], []).append(point)
        links: list[list[int]] = [[] for _ in pairs]
        for points in cells.values():
            free = set(points)
            ways = sorted(
                (float(np.linalg.norm(at[one] - at[other])), one, other)
                for one, other in product(points, points)
                if one < other
            )
            for _, one, other in ways:
                if {one, other} <= free:
                    free -= {one, other}
                    links[one].append(other)
                    links[other].append(one)
        left = set(range(len(pairs)))
        for first in sorted(left, key=lambda point: len(links[point])):
            if first not in left:
                continue
            order, ahead = list[int](), [first]
            while ahead:
                order.append(ahead[0])
                left.discard(ahead[0])
                ahead = [point for point in links[ahead[0]] if point in left]
            if len(order) > 2 and order[0] in links[order[-1]]:
                order.append(order[0])
            yield order


def _apart(at: Array, pairs: Array, is_exact: Array) -> tuple[Array, Array, Array]:
    """Return points that differ, those that are exact before others."""
    order = np.argsort(~is_exact, kind="stable")
    at, pairs, is_exact = at[order], pairs[order], is_exact[order]
    off = np.max(np.abs(at[:, None] - at), axis=2) < MOVES * np.ptp(at)
    new = ~np.any(np.tril(off, -1), axis=1)
    return at[new], pairs[new], is_exact[new]
