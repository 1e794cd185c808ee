"""Polynomials: a way of a transmission within a range, as sums of products of polynomials.

Coefficients of Chebyshev polynomials follow from samples at Chebyshev points, and fall off
geometrically, since no singular configuration lies in the range. Degrees are doubled until those
left out are below the tolerance. A polynomial has no second solution: nothing can lead to another
assembly mode.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...kit.arrays import Array
from ...kit.errors import (
    AccuracyError,
    ArgumentError,
    AssemblyError,
    SingularConfigurationError,
    choices,
)
from ..tape import Program, Scalar, Trace, derivatives
from .way import SolvedWay, Way

_FIRST_DEGREE = 8
_MOST_SAMPLES = 100_000
"""Samples from which polynomials are made: a second of sweeps."""
_MOST_TERMS = 10_000
"""Products of polynomials that are added up: some seconds until they are traced."""
_MEASURED = 1000
"""Positions between the samples at which errors are measured."""


class FitError(NamedTuple):
    """How far polynomials are off: the greatest of what was measured between their samples.

    Attributes:
        position: of coordinates [rad or m].
        jacobian: of their derivatives [1, m/rad, rad/m].
    """

    position: float
    jacobian: float


class FittedWay(Way):
    """A way that polynomials go, within a range.

    Attributes:
        low, high: `(n,)` the range of the given side [rad or m].
        program: from positions to what they lead to, and to all derivatives row by row.
        values: the same without derivatives.
        error: how far it is off.
    """

    def __init__(self, solved: SolvedWay, low: Array, high: Array, tolerance: float) -> None:
        """Make the polynomials.

        Args:
            solved: what they stand for.
            low: see the attributes.
            high: likewise.
            tolerance: of coordinates [rad or m].

        Raises:
            AccuracyError: they do not reach it.
            AssemblyError, SingularConfigurationError: a position of the range is out of reach.
        """
        super().__init__(solved.given, solved.found)
        self.low, self.high = low, high
        points = self._placed(np.random.default_rng(0).uniform(-1.0, 1.0, (_MEASURED, len(low))))
        known = _looked(solved, points)
        most = int(_MOST_SAMPLES ** (1.0 / len(low))) - 1
        degrees, reached = np.full(len(low), max(1, min(_FIRST_DEGREE, most))), np.inf
        while np.prod(degrees + 1) <= _MOST_SAMPLES:
            coefficients = _coefficients(self._placed(_grid(degrees)), solved, degrees)
            last = _last(coefficients)
            slow, reached = last > 0.5 * tolerance, float(np.max(last))
            if not np.any(slow):
                kept = _without_small(coefficients, 0.5 * tolerance)
                if np.count_nonzero(kept) > _MOST_TERMS:
                    break
                self.program, self.values = _traced(kept, self.low, self.high)
                found = zip(self.at(points), known, strict=True)
                self.error = FitError(*(float(np.max(np.abs(a - b))) for a, b in found))
                if self.error.position <= tolerance:
                    return
                slow[:], reached = True, self.error.position
            degrees = np.where(slow, 2 * degrees, degrees)
        raise AccuracyError(
            f"polynomials in {choices(self.given.names)} miss {choices(self.found.names)} by some "
            f"{reached:.1e}, or have too many terms, and {tolerance:.1e} is asked for; give "
            "smaller ranges, farther from singular configurations, or a greater tolerance",
            residual=reached,
            tolerance=tolerance,
        )

    def _placed(self, parts: Array) -> Array:
        """Return positions in the range, from parts between -1 and 1."""
        return 0.5 * (self.low + self.high) + 0.5 * (self.high - self.low) * parts

    def at(self, position: Array) -> tuple[Array, Array]:
        """See `Way.at`."""
        outside = (position < self.low) | (position > self.high)
        if np.any(outside):
            *_, k = np.argwhere(outside)[0]
            raise ArgumentError(
                f"{self.given.names[k]} is {position[outside][0]:.12g}, outside of the range "
                f"{self.low[k]:.12g} to {self.high[k]:.12g} that was fitted"
            )
        shape, count = position.shape, position.shape[-1]
        if position.ndim == 1:
            rows = self._of_one(np.ascontiguousarray(position))
        else:
            lanes = position.reshape(-1, count).T
            rows = self.program.run_rows([lanes], lanes.shape[1])
        values, jacobian = rows[:count].T, rows[count:].T
        return values.reshape(shape), jacobian.reshape(*shape, count)

    @cached_property
    def _of_one(self) -> Callable[[Array], Array]:
        return self.program.of_one()

    def __getstate__(self) -> dict[str, object]:
        # What is bound to the machine is made again where it is needed.
        return {name: value for name, value in self.__dict__.items() if name != "_of_one"}


def _grid(degrees: Array) -> Array:
    """Return Chebyshev points `(d₁ + 1, ..., n)` of some degrees, between -1 and 1."""
    axes = [np.cos(np.pi * np.arange(degree + 1) / degree) for degree in degrees]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


def _coefficients(points: Array, way: SolvedWay, degrees: Array) -> Array:
    """Return the coefficients of Chebyshev polynomials `(d₁ + 1, ..., n)` through samples."""
    from scipy.fft import dct  # Few scripts need it.

    result, _ = _looked(way, points)
    for axis, degree in enumerate(degrees):
        result = dct(result, type=1, axis=axis) / degree
        ends = np.moveaxis(result, axis, 0)
        ends[[0, -1]] *= 0.5
    return result


def _looked(way: SolvedWay, points: Array) -> tuple[Array, Array]:
    """Return what a way finds at positions of a range; see `FittedWay` for errors."""
    try:
        return way.at(points)
    except (AssemblyError, SingularConfigurationError) as error:
        raise type(error)(
            f"positions in the ranges of {choices(way.given.names)} are out of reach, such as "
            f"{error.position}; give smaller ranges: Transmission.borders tells where they end",
            position=error.position,
        ) from error


def _last(coefficients: Array) -> Array:
    """Return the greatest of the last quarter of coefficients along each axis."""
    sizes, found = np.max(np.abs(coefficients), axis=-1), []
    for axis in range(sizes.ndim):
        rows = np.moveaxis(sizes, axis, 0)
        found.append(np.max(rows[3 * len(rows) // 4 :]))
    return np.array(found)


def _without_small(coefficients: Array, most: float) -> Array:
    """Return coefficients with zeros for the smallest, whose sum is at most some number."""
    result = coefficients.reshape(-1, coefficients.shape[-1]).copy()
    for column in result.T:
        order = np.argsort(np.abs(column))
        column[order[np.cumsum(np.abs(column[order])) <= most]] = 0.0
    return result.reshape(coefficients.shape)


def _traced(coefficients: Array, low: Array, high: Array) -> tuple[Program, Program]:
    """Return sums of polynomials with their derivatives as a program, and without them."""
    *sizes, count = coefficients.shape
    with Trace() as trace:
        given = [trace.input(f"x{k}", 0.0) for k in range(count)]
        middle, half = (0.5 * (high + low)).tolist(), (0.5 * (high - low)).tolist()
        polynomials = [
            _polynomials((x - at) * (1.0 / far), size)
            for x, at, far, size in zip(given, middle, half, sizes, strict=True)
        ]
        outputs = [_sum(coefficients[..., k], polynomials) for k in range(count)]
        slopes = derivatives(outputs, given)
        every = [*outputs, *(item for row in slopes for item in row)]
        return Program(trace, every, keeps_inputs=True), Program(trace, outputs, keeps_inputs=True)


def _polynomials(x: Scalar, count: int) -> list[Scalar]:
    """Return the first Chebyshev polynomials of a number."""
    found: list[Scalar] = [1.0, x]
    while len(found) < count:
        found.append(2.0 * x * found[-1] - found[-2])
    return found


def _sum(coefficients: Array, every: Sequence[Sequence[Scalar]]) -> Scalar:
    """Return the sum of products of polynomials, one of each row, times coefficients."""
    if not every:
        return float(coefficients)
    result: Scalar = 0.0
    for part, polynomial in zip(coefficients[::-1], every[0][::-1], strict=True):
        if np.any(part):
            result = result + _sum(part, every[1:]) * polynomial
    return result
