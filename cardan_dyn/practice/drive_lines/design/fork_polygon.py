"""Fork polygon: the least residual angles that free forks can give a line, exactly.

A joint takes the direction of its pin, W = exp(2 i phi), through the map W -> (W - z) / (1 -
conj(z) W) with z = kappa exp(-2 i gamma), kappa = tan^2(beta/2): a translation of the hyperbolic
plane by d = -ln cos(beta) in the direction of its phase. A line is a polygon with these sides; the
residual angle of its first k joints is the distance of corner k from the start, and turning a fork
turns the polygon at a corner. So the polygon closes if and only if its longest side is not longer
than all others together, and otherwise falls short of closing by just the difference:

    cos beta_E = cos beta_max / product of the other cos beta_k, or beta_E = 0 if that exceeds 1.

A distance can be followed by any distance that makes a triangle with the next side. Limits of
distances therefore pass along the line as intervals, and what is found is the global optimum.

Source:
    Own derivation from Thoma 1920 (4); `analytic.drive_line` has the maps and their composition.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from cardan_dyn.analytic import drive_line

from ....kit.arrays import EPS, Array

_SLACK = 8.0 * EPS
"""Rounding of sums of distances, relative to the sum of all."""
_IN_LINE = 16.0 * _SLACK
"""Distance that sides in line may be longer or shorter than their sum by, relative to half of it:
what rounding and slack make of it, of which the turn would have the root."""
_MOST_TURNS = 6
"""Corners at which both senses of turning are listed; 64 polygons of the same distances."""


def distance(beta: Array) -> Array:
    """Return the distances -ln cos(beta) of angles [rad], any shape; accurate for small ones."""
    return -np.log1p(-2.0 * np.sin(np.asarray(beta) / 2.0) ** 2)


def angle(distances: Array) -> Array:
    """Return the angles [rad] of distances, any shape: the inverse of `distance`."""
    return 2.0 * np.arcsin(np.sqrt(-np.expm1(-np.asarray(distances)) / 2.0))


def added(corner: Array, step: Array) -> Array:
    """Return the next corner (u + z) / (1 + conj(z) u) of complex corners u and steps z.

    |u| is tan^2(beta_E/2) of the joints so far; z = tan^2(beta/2) exp(-2 i gamma).
    """
    return np.asarray((corner + step) / (1.0 + np.conj(step) * corner))


def least_shortfall(sides: Array) -> Array:
    """Return what is missing for polygons to close, 0 if they do.

    Args:
        sides: `(..., m)` distances.

    Returns:
        `(...)`: max(0, 2 max - sum).
    """
    # The sum of the others, so that sides that close exactly give exactly 0.
    ordered = np.sort(sides, axis=-1)
    return np.maximum(ordered[..., -1] - np.sum(ordered[..., :-1], axis=-1), 0.0)


def least_greatest(sides: Array, corners: Iterable[int]) -> Array:
    """Return the least values that the greatest distance of chosen corners can have.

    Args:
        sides: `(..., m)` distances of the joints.
        corners: numbers 1 … m of the joints behind which the distance counts.

    Returns:
        `(...)` distances.

    Source:
        Between two chosen corners, and from the start to one of them, a polygon has to close whose
        remaining sides are not greater than the result.
    """
    chosen = sorted(set(corners))
    found = np.zeros(sides.shape[:-1])
    for end in chosen:
        found = np.maximum(found, least_shortfall(sides[..., :end]))
        for start in (corner for corner in chosen if corner < end):
            found = np.maximum(found, least_shortfall(sides[..., start:end]) / 2.0)
    return found


def least_distances(sides: Array, corners: Iterable[int]) -> Array:
    """Return the distances `(n + 1,)` of all corners of an optimal polygon.

    Of all polygons with the least greatest distance of the chosen corners, it is one with the least
    greatest distance of the others.
    """
    count = len(sides)
    total = float(np.sum(sides))
    chosen = set(corners)
    limits = np.full(count + 1, total)
    limits[list(chosen)] = least_greatest(sides, chosen)
    rest = [corner for corner in range(2, count) if corner not in chosen]
    if rest:
        low, high = 0.0, total
        while low < (middle := 0.5 * (low + high)) < high:
            limits[rest] = middle
            low, high = (low, middle) if _reachable(sides, limits)[1] else (middle, high)
        limits[rest] = high
    return _traced(sides, _reachable(sides, limits)[0])


def _reachable(sides: Array, limits: Array) -> tuple[Array, bool]:
    """Return the intervals `(n + 1, 2)` of the distances of the corners, and whether they exist.

    An interval that is empty holds the distance that comes nearest to its limit.
    """
    slack = _SLACK * float(np.sum(sides))
    exist = True
    intervals = np.zeros((len(sides) + 1, 2))
    for k, side in enumerate(sides):
        low, high = intervals[k]
        nearest = max(low - side, side - high, 0.0)
        furthest = min(high + side, float(limits[k + 1]))
        exist = exist and nearest <= furthest + slack
        intervals[k + 1] = nearest, max(furthest, nearest)
    return intervals, exist


def _traced(sides: Array, intervals: Array) -> Array:
    """Return distances in all intervals, each a triangle with the next side; from the end."""
    result = np.zeros(len(sides) + 1)
    result[-1] = intervals[-1, 0]
    for k in range(len(sides) - 1, 0, -1):
        low = max(abs(result[k + 1] - sides[k]), intervals[k, 0])
        result[k] = min(low, intervals[k, 1])
    return result


class Link(NamedTuple):
    """Joints with forks between them that do not turn against each other: one side of a polygon.

    Attributes:
        betas: `(m,)` joint angles [rad].
        phases: `(m,)` fork phases [rad], the first 0.
    """

    betas: Array
    phases: Array

    @property
    def side(self) -> float:
        """Distance of the joint that moves like this one."""
        return float(distance(drive_line.residual_angle(self.betas, self.phases)))


def polygon_phases(links: Sequence[Link], distances: Array, senses: Array) -> Array:
    """Return fork phases `(n,)` [rad] that give the corners between links these distances.

    Args:
        links: m links with n joints.
        distances: `(m + 1,)` of the corners, 0 at the start.
        senses: `(m - 1,)` ±1, sense in which the polygon turns at each corner.

    Returns:
        Phases as in `analytic.drive_line`, the first 0.
    """
    corner, phases = np.zeros((), dtype=complex), []
    for k, link in enumerate(links):
        of_link = link.phases
        if k:
            turn = _turn(float(distances[k]), link.side, float(distances[k + 1]))
            aimed = -(np.angle(corner) + senses[k - 1] * turn) / 2.0
            equivalent = drive_line.equivalent_joint(link.betas, link.phases)
            of_link = link.phases + (aimed - equivalent.phase)
        phases.append(of_link)
        for beta, phase in zip(link.betas, of_link, strict=True):
            corner = added(corner, np.tan(beta / 2.0) ** 2 * np.exp(-2j * phase))
    return np.concatenate(phases)


def _turn(before: float, side: float, after: float) -> float:
    """Return the outer angle of a hyperbolic triangle between two sides [rad], 0 in line."""
    half = (before + side + after) / 2.0
    gaps = [half - length for length in (before, side, after)]
    front, middle, rear = (np.sinh(gap) if gap > _IN_LINE * half else 0.0 for gap in gaps)
    opened, closed = np.sinh(half) * rear, front * middle
    return float(2.0 * np.arctan2(np.sqrt(opened), np.sqrt(closed))) if opened or closed else 0.0


def turning_senses(sides: Array, distances: Array) -> Array:
    """Return the senses `(s, m - 1)` of the polygons of m sides with these distances that differ.

    A corner that is straight or turns back is the same in both senses, and so is one at the start.
    """
    both = []
    for k in range(1, len(sides)):
        turn = _turn(float(distances[k]), float(sides[k]), float(distances[k + 1]))
        is_away = distances[k] > _SLACK * float(np.sum(sides))
        both.append(is_away and 0.0 < turn < np.pi)
    turning = [k for k, is_free in enumerate(both) if is_free][:_MOST_TURNS]
    senses = np.ones((2 ** len(turning), len(sides) - 1))
    senses[:, turning] = list(itertools.product((1.0, -1.0), repeat=len(turning)))
    return senses
