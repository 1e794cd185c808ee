"""Nearest: the closed configuration nearest to positions that no closed one has altogether.

Encoders tell more positions than decide where a mechanism is, and none of them exactly. The sum of
the squares of what they are off is least where no motion that the loops allow lowers it
(Gauss-Newton's method along these motions).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ....kit.arrays import Array
from ....kit.errors import AssemblyError
from ..loops.groups import independent_groups
from ..loops.structure import Structure
from ..tolerances import CLOSURE_TOLERANCE, LONGEST_WAY, RANK_TOLERANCE, SAFE_CORRECTION
from .far import assembled_near, closed_from, starts_about
from .group_solver import MOST_STEPS, solver_of


def nearest_to(
    structure: Structure,
    x: Array,
    wanted: Mapping[str, float],
    free: Array,
    needed: Array,
    error: AssemblyError,
) -> Array:
    """Return closed coordinates `(size,)` nearest to positions of more joints than decide them.

    Args:
        structure: of the mechanism.
        x: `(size,)` coordinates near which the others are; those wanted are at their positions.
        wanted: coordinates to positions [rad or m].
        free: velocity coordinates that may move.
        needed: velocity coordinates whose loops are closed.
        error: that says that the positions cannot all be met.

    Raises:
        AssemblyError: as many joints decide them as are given, or nothing closed is near.
    """
    coordinates = structure.mechanism.coordinates
    columns, rates = coordinates.columns_of(wanted), coordinates.rates_of(wanted)
    values, scale = np.array(list(wanted.values())), coordinates.scale[columns]
    best, away = None, np.full(len(values), np.inf)
    # Which assembly mode is meant is known of no joint alone: others may be anywhere.
    starts = x
    for group in independent_groups(structure, free):
        starts = starts_about(solver_of(structure.mechanism, group), starts, np.pi, rates)
    for begun in np.vstack([x, starts]):
        start, residual = assembled_near(structure, begun, free, needed)
        if residual < CLOSURE_TOLERANCE:
            found, exceeds = _least(structure, start, dict(zip(rates, values, strict=True)), free)
            if not exceeds:
                raise error
            if found is not None:
                off = np.abs(found[columns] - values) * scale
                if np.linalg.norm(off) < np.linalg.norm(away):
                    best, away = found, off
        if np.max(away) <= SAFE_CORRECTION:
            break  # No other assembly mode is that near.
    if best is None:
        raise error
    if np.max(away) > SAFE_CORRECTION:
        places = ", ".join(
            f"{name}: {value:.6g}" for name, value in zip(wanted, best[columns], strict=True)
        )
        raise AssemblyError(
            f"{error}; the nearest closed configuration that was found has {places}, up to "
            f"{np.max(away):.2g} away; only what is within {SAFE_CORRECTION:g} rad, or lengths of "
            "the mechanism, is taken for what was meant",
            **error.details,
        )
    return best


def _least(
    structure: Structure, x: Array, wanted: Mapping[int, float], free: Array
) -> tuple[Array | None, bool]:
    """Return closed coordinates `(size,)` that are least off, near others; None without them.

    And whether more joints of some loops are given than decide where these are.

    Args:
        structure: of the mechanism.
        x: `(size,)` closed coordinates.
        wanted: velocity coordinates to positions.
        free: velocity coordinates that may move.
    """
    coordinates, exceeds = structure.mechanism.coordinates, False
    column_of = {item.rate: item.column for item in coordinates.named.values()}
    for group in independent_groups(structure, free):
        own = [index for index, rate in enumerate(group.passives) if rate in wanted]
        if not own:
            continue
        rates = group.passives[own]
        columns = np.array([column_of[rate] for rate in rates])
        values = np.array([wanted[rate] for rate in rates])
        solver = solver_of(structure.mechanism, group)
        for _ in range(MOST_STEPS):
            rows = solver.linearised(x[None, :])[0][0]
            left, sizes, _ = np.linalg.svd(rows)
            rank = int(np.sum(sizes > RANK_TOLERANCE * np.max(sizes, initial=0.0)))
            allowed = left[:, rank:]
            exceeds |= len(own) > allowed.shape[1]
            off = (values - x[columns]) * coordinates.scale[columns]
            step = allowed @ np.linalg.lstsq(allowed[own], off, rcond=RANK_TOLERANCE)[0]
            longest = float(np.max(np.abs(step), initial=0.0))
            step *= LONGEST_WAY / max(longest, LONGEST_WAY)
            moved, residual = closed_from(solver, solver.moved(x[None, :], step[None, :]))
            if not residual[0] < CLOSURE_TOLERANCE:
                return None, exceeds
            x = moved[0]
            if longest < CLOSURE_TOLERANCE:
                break
        else:
            return None, exceeds
    return x, exceeds
