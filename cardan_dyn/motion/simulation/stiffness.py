"""Stiffness: how fast a system could move near its start, and how much of that the start excites.

Stiff springs have fast modes. Where the start does not excite them, an explicit method still has to
take steps as short as their periods, an implicit one has not. Where it does, their ringing is part
of the solution, and has to be followed.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...kit.arrays import EPS, Array

Rates = Callable[[Array], Array]
"""Time derivative of a row."""

_EXCITED = 10.0
"""Amplitude of a mode, in tolerances, from which on steps have to follow it."""
_FAST = 30.0
"""How much faster than all that is excited a mode has to be to make a system stiff."""
_STRAIGHT = 0.1
"""Part of a difference by which it is checked whether rates are straight over it, and greatest
change of them by that, as a fraction."""
_MANY = 1500.0
"""Duration times the greatest rate below which no other method is worth its price: some five of it
are a step of DOP853 that is stable."""


class Modes(NamedTuple):
    """Modes of a system, linearised about a row.

    Attributes:
        values: eigenvalues `(n,)` [1/s].
        vectors: eigenvectors `(n, n)`, a column for each.
        shares: how fast each moves at the row `(n,)`, complex.
        amplitudes: how far each is from where it would rest `(n,)`, in tolerances.
    """

    values: Array
    vectors: Array
    shares: Array
    amplitudes: Array

    @property
    def is_excited(self) -> Array:
        """Which modes the row excites `(n,)`."""
        return np.asarray(self.amplitudes > _EXCITED)


def jacobian(rates: Rates, y: Array, unit: Array) -> Array:
    """Return the derivatives `(n, n)` of rates, by differences.

    Friction that sets in within a small part of the speeds has slopes that great differences do not
    see: they are made finer until two of them agree; where none do, rounding is what they see.

    Args:
        rates: of the system.
        y: the row `(n,)`.
        unit: `(n,)` sizes of entries that differences are taken by at least.
    """
    rate = rates(y)
    result = np.empty((y.size, y.size))

    def column(index: int, difference: float) -> Array:
        moved = y.copy()
        moved[index] += difference
        return (rates(moved) - rate) / (moved[index] - y[index])

    for index, size in enumerate(np.maximum(np.abs(y), unit).tolist()):
        difference = float(np.sqrt(EPS)) * size
        result[:, index] = coarse = column(index, difference)
        while (difference := _STRAIGHT * difference) > 2.0 * EPS * size:
            fine = column(index, difference)
            if np.max(np.abs(fine - coarse)) <= _STRAIGHT * np.max(np.abs(fine)):
                result[:, index] = coarse
                break
            coarse = fine
    return result


class Judgement(NamedTuple):
    """What a method of integration needs to know of a start.

    Attributes:
        is_stiff: whether steps would be limited by stability.
        frequency: of the fastest mode that rings [Hz]; 0 if none does.
    """

    is_stiff: bool
    frequency: float

    def notes(self, *, settle: bool) -> list[str]:
        """Return what a user should know of it.

        Args:
            settle: whether fast modes were to rest.
        """
        notes = []
        if self.is_stiff:
            notes.append("stiff: fast modes rest, which an implicit method need not follow")
        if self.frequency:
            advice = "settle=True starts where fast modes rest"
            if settle:
                advice = "settle=True did not bring it to rest"
            notes.append(
                f"oscillatory: the start rings at {self.frequency:.6g} Hz, which steps have to "
                f"follow; {advice}"
            )
        return notes


def judged(found: Modes, duration: float, speed: float) -> Judgement:
    """Return whether a start is stiff, and whether it rings.

    Args:
        found: modes about the start.
        duration: of the simulation [s].
        speed: greatest speed of a joint [rad/s]: what turns is no ringing.
    """
    sizes = np.abs(found.values)
    greatest = float(np.max(sizes, initial=0.0))
    excited = float(np.max(sizes[found.is_excited], initial=0.0))
    slow = max(float(np.max(sizes[sizes < greatest / _FAST], initial=0.0)), speed)
    is_many = greatest * duration > _MANY
    is_stiff = is_many and excited * _FAST < greatest
    rings = found.is_excited & (np.abs(found.values.imag) > _FAST * max(slow, 1.0 / duration))
    fastest = float(np.max(np.abs(found.values.imag[rings]), initial=0.0))
    return Judgement(is_stiff, fastest / (2.0 * np.pi))


class Stiffness(NamedTuple):
    """Looks at the modes of equations about rows.

    Attributes:
        derivative: of rows at times.
        size: number of the first entries of a row, whose rates are speeds.
        unit: `(n,)` sizes of entries that differences are taken by.
        rtol: relative tolerance of a step.
        atol: absolute tolerance of a step, in these sizes.
        duration: of the simulation [s].
    """

    derivative: Callable[[float, Array], Array]
    size: int
    unit: Array
    rtol: float
    atol: float
    duration: float

    def modes(self, time: float, y: Array) -> Modes:
        """Return the modes about a row."""

        def rates(row: Array) -> Array:
            return self.derivative(time, row)

        values, vectors = np.linalg.eig(jacobian(rates, y, self.unit))
        shares = np.linalg.lstsq(vectors, rates(y).astype(complex), rcond=None)[0]
        is_moving = _moving(np.abs(values))
        away = np.abs(vectors * np.where(is_moving, shares / np.where(is_moving, values, 1.0), 0.0))
        tolerance = self.atol * self.unit + self.rtol * np.abs(y)
        return Modes(values, vectors, shares, np.max(away / tolerance[:, None], axis=0))

    def limits(self, time: float, y: Array, length: float) -> bool:
        """Return whether stability, not accuracy, limits the steps of an explicit method.

        Args:
            time: reached [s].
            y: row there.
            length: of the last step [s].
        """
        found, size = self.modes(time, y), self.size
        speeds = self.derivative(time, y)[:size] / self.unit[:size]
        greatest = float(np.max(np.abs(found.values), initial=0.0))
        # Shorter steps follow all modes.
        return (
            length * greatest > 1.0
            and judged(
                found, self.duration - time, float(np.max(np.abs(speeds), initial=0.0))
            ).is_stiff
        )

    def settled(self, y: Array, restored: Callable[[Array], Array], speed: float) -> Array:
        """Return a row near one at time 0 in which fast modes rest.

        Fast are those that are faster by a factor of 30 than any mode below them; where there is no
        such gap, all modes stay as they are.

        Args:
            y: the row.
            restored: returns the row that obeys the constraints.
            speed: of joints [rad/s], which counts as the rate of a slow mode.
        """
        away = np.inf
        while True:
            found = self.modes(0.0, y)
            is_fast = np.abs(found.values) > _gap(np.abs(found.values), speed)
            last, away = away, float(np.max(found.amplitudes[is_fast], initial=0.0))
            if not 0.1 < away < 0.5 * last:
                return y
            step = found.vectors[:, is_fast] @ (found.shares[is_fast] / found.values[is_fast])
            y = restored(y - step.real)


def _moving(sizes: Array) -> Array:
    """Return which frequencies of modes are more than what differences leave of zero."""
    return np.asarray(sizes > np.sqrt(EPS) * np.max(sizes, initial=0.0))


def _gap(sizes: Array, speed: float) -> float:
    """Return a size between slow and fast ones, inf if there is no gap between them."""
    ordered = np.sort(np.append(sizes[_moving(sizes)], speed))
    ratios = ordered[1:] / ordered[:-1]
    widest = int(np.argmax(ratios))
    if ratios[widest] < _FAST:
        return np.inf
    return float(np.sqrt(ordered[widest] * ordered[widest + 1]))
