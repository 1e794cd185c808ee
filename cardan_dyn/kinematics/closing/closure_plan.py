"""Closure plan: the closure equations of a group in the words of their compiled functions."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...compiled import Plan
from ...mechanism.coordinates import Coordinates, Moves
from .equations import ClosureEquations, LoopEnds, Reduction


class ClosurePlan(NamedTuple):
    """The plan of a group's closure equations.

    Attributes:
        reduction: the rows that are solved.
        plan: the plan.
        rows: number of rows, those of couplings included.
        whole: the same, with those of idle rods.
        inverts: whether the rows of the passives are inverted as they are found.
    """

    reduction: Reduction
    plan: Plan
    rows: int
    whole: int
    inverts: bool


def closure_plan(
    equations: ClosureEquations,
    reduction: Reduction,
    coordinates: Coordinates,
    step_scale: Array,
    row_scale: Array | None,
    most: int,
) -> ClosurePlan:
    """Return the plan of closure equations, whose arrays `compiled/closure.c` lists.

    Args:
        equations: of the group.
        reduction: the rows that are solved.
        coordinates: layout of coordinate rows.
        step_scale: `(p,)` what Newton steps are counted in.
        row_scale: `(p, 1)` what the passives' rows are counted in; None if all are 1.
        most: passives up to which their rows are inverted.
    """
    movable, loops, couplings = equations.movable, len(equations.loops), len(equations.couplings)
    passives = len(step_scale)
    units = equations.batch.subspace[movable]
    is_along = np.count_nonzero(units, axis=1) == 1
    along = np.where(is_along, np.argmax(np.abs(units), axis=1), -1)
    ends, places = np.zeros((loops, 2)), np.zeros((loops, 2, 12))
    indices, bodies = np.arange(loops), np.arange(len(equations.batch))
    for alike in equations.alike:
        for side, end in enumerate((alike.first, alike.second)):
            of = indices[alike.loops]
            ends[of, side] = -1 if end.bodies is None else bodies[end.bodies]
            places[of, side] = _places(end)
    rows = [rows.T for rows in reduction.rows]
    signs, lines, rods = list(equations.column_signs), np.zeros((0, 3)), []
    if hasattr(equations, "rod_spins"):
        spins = equations.rod_spins
        signs, lines, rods = [*signs, *spins.moves.T], spins.directions, spins.bodies
    paths = [_outwards(own, equations.moved_bodies) for own in signs]
    sizes = [len(bodies), len(movable), len(movable) - passives, loops, couplings, len(rods)]
    integers = [
        [*sizes, coordinates.size],
        movable,
        equations.moved_bodies,
        along,
        ends,
        [axes.body for axes in reduction.axes],
        [len(own) for own in rows],
        [_single(row) for own in rows for row in own],
        [len(path) for path in paths],
        np.concatenate([np.zeros(0), *paths]),
        coordinates.column_of(equations.coupled_columns),
        rods,
    ]
    numbers = [
        [equations.length],
        units,
        places,
        np.concatenate([np.zeros(0), *(axes.point for axes in reduction.axes)]),
        np.concatenate([np.zeros(0), *(own.ravel() for own in rows)]),
        np.concatenate([np.zeros(0), *(own[path] for own, path in zip(signs, paths, strict=True))]),
        equations.coupled_ratios,
        equations.coupled_offsets,
        equations.slip_units,
        equations.coupling_rows,
        step_scale,
        np.ones(passives) if row_scale is None else row_scale,
        lines,
    ]
    plan = Plan("closure", integers, numbers)
    reduced = sum(len(own) for own in rows) + couplings
    whole = reduced + len(rods)
    return ClosurePlan(reduction, plan, reduced, whole, whole == passives <= most)


def moves_plan(moves: Moves) -> Plan:
    """Return the plan of how rows of coordinates move."""
    quaternions, rotations = moves.quaternions[:, 0], moves.rotations[:, 0]
    return Plan("moves", [moves.columns, moves.steps, quaternions, rotations], [])


def _places(ends: LoopEnds) -> Array:
    """Return the rotations, row by row, and positions `(k, 12)` of loops' ends."""
    return np.concatenate([ends.rotations.reshape(-1, 9), ends.translations], axis=1)


def _single(row: Array) -> int:
    """Return the component that a reduced row `(6,)` is, -1 if it is a combination."""
    (found,) = np.nonzero(row)
    return int(found[0]) if len(found) == 1 and row[found[0]] == 1.0 else -1


def _outwards(signs: Array, moved_bodies: Array) -> Array:
    """Return the columns of a path outwards, first those on the predecessor's side.

    Args:
        signs: `(m,)` on which side each movable coordinate is.
        moved_bodies: `(m,)` body that each of them moves, the bodies outwards.
    """
    # The coordinates of a ball stay in their order, hence a stable sort.
    order = np.lexsort((np.arange(len(signs)), moved_bodies, -signs))
    return np.asarray(order[signs[order] != 0.0])
