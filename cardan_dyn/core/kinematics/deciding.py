"""Deciding: which free coordinates decide the motion of a scene where its own ones do not."""

from __future__ import annotations

from dataclasses import replace

from ...kit.arrays import Array
from ...kit.frozen import frozen
from ..problem.problem import FIRST_MODE, Problem
from .diagnosis.imbalance import Surroundings
from .loops.structure import Structure


def decided_at(problem: Problem, x: Array) -> Problem | None:
    """Return a problem with the same drives, and those free that decide the motion at a position.

    It starts there, and has all joints as outputs. None where nothing decides the motion beside the
    drives: one of these is in a dead point, or assembly modes meet.

    Args:
        problem: of a scene.
        x: `(size,)` closed coordinates.
    """
    mechanism, coordinates = problem.mechanism, problem.mechanism.coordinates
    named, driven = coordinates.named, coordinates.rates_of(problem.drives)
    held, passive = set(coordinates.rates_of(problem.held)), problem.passive_columns.tolist()
    needed = {*coordinates.rates_of(problem.independent), *passive}
    (there,) = Surroundings(Structure(mechanism), x, held, needed).freedoms(driven, here=True)
    # Those that are free already stay where they are as good as others.
    names = {named[name].rate: name for name in (*problem.free, *named)}
    chosen = there.chosen([rate for rate in names if rate not in held.union(driven)], driven)
    decided = there.rank_of([*driven, *chosen])
    if not decided == there.number == len(problem.independent):
        return None
    free = tuple(names[rate] for rate in chosen)
    columns, balls = coordinates.columns, coordinates.balls.columns.tolist()
    return replace(
        problem,
        independent=(*problem.drives, *free),
        free=free,
        near=frozen(
            {name: float(x[at.column]) for name, at in named.items() if name not in problem.held}
        ),
        near_balls=frozen(
            {name: x[at.stop - 4 : at.stop] for name, at in columns.items() if at.stop - 4 in balls}
        ),
        branch=FIRST_MODE,
        outputs=tuple(mechanism.joints),
        all_outputs=True,
        strict=False,
    )
