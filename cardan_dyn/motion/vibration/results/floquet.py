"""Floquet: multipliers of periodic motions over speed and design, and where they are unstable."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from itertools import groupby
from multiprocessing import get_all_start_methods, get_context
from threading import current_thread, main_thread
from typing import TYPE_CHECKING, Any

import numpy as np

from ....core.problem.arguments import held_designs
from ....core.results.plot import Plot, own_figure
from ....core.results.table import Table
from ....kit.arrays import Array
from ....kit.checks import flag, positive, whole
from ....kit.errors import ArgumentError, CardanError
from ....kit.time_left import Task
from ..model.rotating_scene import rotating_scene, speeds_of
from ..motions.regions import Region, StabilityOverSpeed, regions
from ..motions.residuals import refuse_unheld
from ..motions.search import MotionSearch
from ..motions.stability import NONE, STABLE, Stability, stability
from .result import VibrationResult, table_of

if TYPE_CHECKING:
    from ....figures.style import Figure
    from ....scene.scene import Scene

_STORED = ("multipliers", "trace", "determinant", "liouville", "kind", "coexisting")


class FloquetPlot(Plot):
    """Draws stability over speed."""

    @own_figure
    def __call__(self, *columns: Any, **options: Any) -> Figure:
        """Draw multipliers over speed, or a chart of what is unstable over speed and design.

        Unstable intervals are those of `region` if these are known, which may lie between two
        speeds; if not, speeds that are unstable stand for what is half way to their neighbours.
        The ordinate of a chart is the first joint whose positions all differ.

        Args:
            columns: of the table instead, see `Plot`.
            options: `title`, `ax` (one axes) and `figsize`.

        Raises:
            ArgumentError: there are several designs, and no such joint; or as `Plot`.
        """
        found = self._result
        if found.kind.ndim == 1 or len(found.kind) == 1:
            from ....figures.vibration import multipliers

            sizes = np.abs(found.multipliers).reshape(len(found.speed), -1)
            known = [row for of in found.region for row in of]
            spans = [(row.lower, row.upper, row.kind) for row in known]
            return multipliers(found.speed, sizes, intervals=spans, **options)
        from ....figures.critical_speeds import stability_chart

        name = next((key for key, of in found.held.items() if len(set(of.tolist())) == len(of)), "")
        if not name:
            raise ArgumentError(
                f"a chart needs a joint whose positions all differ, not {', '.join(found.held)}; "
                "draw `kind` yourself"
            )
        rows = np.argsort(found.held[name])
        others = [key for key in found.held if key != name]
        return stability_chart(
            found.held[name][rows],
            [found._intervals(row) for row in rows.tolist()],
            ends=(float(np.min(found.speed)), float(np.max(found.speed))),
            joint=f"{name} with {', '.join(others)}" if others else name,
            slides=found.scene.mechanism.coordinates.named[name].slides,
            **options,
        )


@dataclass(frozen=True, eq=False)
class Floquet(VibrationResult):
    """Multipliers over one period of the equation, about the smallest motion at each speed.

    Arrays have the shape `(S,)` of the speeds, or `(D, S)` for D designs.

    Attributes:
        scene: whose drive turns at constant speed.
        speed: of the drive `(S,)` [rad/s].
        held: joints that differ between the designs, to their positions `(D,)` [rad or m].
        period: over which the multipliers are taken, in the drive's position [rad]: half a
            revolution where the equation repeats after it.
        multipliers: complex `(..., 2n)`, the greatest first; NaN without a motion.
        trace, determinant: of the monodromy matrix of (δq, dδq/ds), s = |φ| the way of the drive.
        liouville: the determinant once more, by the integral of the damping.
        kind: `stable`; `instability`: a multiplier below -1, motions of twice the period grow;
            `fold`: above +1, motions of the same period meet, or, of an equation that repeats
            after whole revolutions alone, as by unbalance, those of twice a joint's half grow;
            `combination`: two modes together; `flutter`: by loads that turn with their links or
            whirl, in the averaged equation as well; `no motion`: none was found.
        coexisting: number of further motions found beside the smallest, near forced resonances.
            They come in pairs: where it is odd, one was not found, or lies beyond `max_amplitude`.
        change: greatest change of a monodromy matrix when its integration was refined last.
        region: unstable intervals of each design, in C order; empty lists unless asked for.
    """

    scene: Scene
    speed: Array
    held: Mapping[str, Array]
    period: float
    multipliers: Array
    trace: Array
    determinant: Array
    liouville: Array
    kind: Array
    coexisting: Array
    change: float
    region: tuple[tuple[Region, ...], ...] = field(default=())

    @property
    def growth(self) -> Array:
        """Growth rate of the fastest disturbance [1/s], negative where all decay."""
        size = np.log(np.abs(self.multipliers[..., 0]))
        return np.asarray(size * np.abs(self.speed) / self.period)

    @property
    def is_stable(self) -> Array:
        """Whether all disturbances stay bounded."""
        return np.asarray(self.kind == "stable")

    @property
    def regions(self) -> tuple[Region, ...]:
        """Unstable intervals of speed of a single design.

        Raises:
            ArgumentError: there are several designs, whose `region` has an entry for each.
        """
        if len(self.region) != 1:
            raise ArgumentError(
                f"{len(self.region)} designs have regions; `region` has an entry for each"
                if self.region
                else "the regions were not asked for; write floquet(..., edges=True)"
            )
        return self.region[0]

    def _intervals(self, design: int) -> list[tuple[float, float, str]]:
        """Return intervals of speed of a design that are not stable, and their kinds."""
        order = np.argsort(self.speed)
        speed, kind = self.speed[order], self.kind[design][order]
        between = np.concatenate([speed[:1], 0.5 * (speed[1:] + speed[:-1]), speed[-1:]])
        found = []
        for of, run in groupby(range(len(kind)), key=lambda at: str(kind[at])):
            places = list(run)
            if of == NONE or (of != STABLE and not self.region):
                found.append((float(between[places[0]]), float(between[places[-1] + 1]), of))
        known = self.region[design] if self.region else ()
        return found + [(row.lower, row.upper, row.kind) for row in known]

    def _records(self) -> Any:
        """See `VibrationResult._records`; with the design of each region."""
        every = [(design, *row) for design, found in enumerate(self.region) for row in found]
        columns = ("design", *Region._fields) if self.region else ()
        return {"region": ("region", columns, every)}

    def table(self) -> Table:
        """Return a row for each design and speed."""
        return table_of(
            {
                **{name: (of[:, None], "rad or m") for name, of in self.held.items()},
                "speed": (self.speed, "rad/s"),
                "kind": (self.kind, ""),
                "growth": (self.growth, "1/s"),
                "trace": (self.trace, "1"),
                "determinant": (self.determinant, "1"),
                "coexisting": (self.coexisting, "1"),
            }
        )

    @property
    def plot(self) -> FloquetPlot:
        """Figures: `found.plot()`, multipliers over speed, or a chart over speed and design."""
        return FloquetPlot(self)

    def __repr__(self) -> str:
        missed = int(np.sum(self.kind == NONE))
        unstable = int(np.sum(~self.is_stable)) - missed
        count = sum(map(len, self.region))
        parts = [f"{self.kind.size} points, {unstable} of them unstable"]
        parts += [f"{missed} without a motion"] if missed else []
        parts += [f"{count} unstable intervals"] if self.region else []
        return f"<Floquet of {', '.join(self.scene.free)}: {', '.join(parts)}>"


def floquet(
    scene: Scene,
    speed: Any,
    *,
    held: Mapping[str, Any] | None = None,
    edges: bool = False,
    max_amplitude: float = 1.0,
    workers: int = 1,
) -> Floquet:
    """Return the stability of periodic motions over speed, and over designs.

    Args:
        scene: with one drive and free coordinates.
        speed: of the drive, a number or `(S,)` [rad/s].
        held: joints that the scene holds, to their positions, one or `(D,)`, as many for each: a
            chart.
        edges: whether unstable intervals and their edges are found, to 1e-8 of the speed; speeds
            then ascend, and narrow intervals are looked for between them.
        max_amplitude: see `periodic_motion`.
        workers: processes that share the designs, where the platform can fork them: what is
            done is too small for threads. Other threads than the main one do without: they may
            hold locks, which a fork would never see free.

    Raises:
        CardanError: see `periodic_motion`; speeds without a motion are marked instead.
    """
    workers, edges = whole("workers", workers), flag("edges", edges)
    max_amplitude = positive("max_amplitude", max_amplitude)
    speeds, _ = speeds_of(speed)
    if edges and (np.any(np.diff(speeds) <= 0.0) or speeds[0] * speeds[-1] < 0.0):
        raise ArgumentError("edges: give ascending speeds of one sense")
    first = rotating_scene(scene)
    designs = held_designs(first.scene.held, held)
    rows = zip(*(values.tolist() for values in designs.values()), strict=True)
    places = [dict(zip(designs, row, strict=True)) for row in rows] or [{}]
    work = partial(_of_design, scene, max_amplitude, speeds, edges)
    done: list[_Done] = []
    with _mapped(min(workers, len(places))) as mapped, Task("stability", len(places)) as task:
        for found in mapped(work, places):
            done.append(found)
            task.tell(len(done))
    return _collected(first.scene, speeds, designs, done, edges)


@contextmanager
def _mapped(workers: int) -> Iterator[Callable[..., Iterable[Any]]]:
    """Lend what maps a function, by processes if there are several.

    Raises:
        CardanError: a process was lost.
    """
    from concurrent.futures import BrokenExecutor, ProcessPoolExecutor  # Most charts do without.

    forks = sys.platform != "darwin" and "fork" in get_all_start_methods()
    if workers == 1 or not forks or current_thread() is not main_thread():
        yield map
        return
    pool = ProcessPoolExecutor(workers, get_context("fork"))
    try:
        yield pool.map
    except BrokenExecutor as error:
        raise CardanError(
            "a worker process was lost, perhaps for want of memory; use fewer workers"
        ) from error
    finally:
        pool.shutdown(cancel_futures=True)


_Done = tuple[Stability, list[Region], float]
"""Stability, regions and period of a design."""


def _collected(
    scene: Scene, speeds: Array, designs: dict[str, Array], done: list[_Done], edges: bool
) -> Floquet:
    """Return what was found of all designs."""
    period = max(item[2] for item in done)
    if any(item[2] != period for item in done):
        raise ArgumentError(
            "some designs repeat after half a revolution and others after a whole one, so that "
            "their multipliers cannot be compared; ask for them one by one"
        )
    stacked = {name: np.stack([getattr(item[0], name) for item in done]) for name in _STORED}
    if not designs:
        stacked = {name: values[0] for name, values in stacked.items()}
    return Floquet(
        scene=scene,
        speed=speeds,
        held=designs,
        period=period,
        change=max(item[0].change for item in done),
        region=tuple(tuple(item[1]) for item in done) if edges else (),
        **stacked,
    )


def _of_design(
    scene: Scene, max_amplitude: float, speeds: Array, edges: bool, held: Mapping[str, float]
) -> _Done:
    """Return stability, regions and period of a scene that holds joints to other positions."""
    rotating = rotating_scene(scene.replace(held=held) if held else scene)
    search = MotionSearch(rotating, max_amplitude)
    refuse_unheld(search.primary(speeds[[0, -1]]))
    found = stability(search, speeds)
    unstable: list[Region] = []
    if edges:
        unstable = regions(StabilityOverSpeed(search, speeds, found), speeds, found)
    return found, unstable, search.model.period
