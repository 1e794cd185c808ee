"""Energy: of bodies and their weight at given states, and work as the integral of power."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio

from ..arrays import Array
from ..elements.element_forces import ElementForces
from ..mechanism.mechanism import Mechanism
from .free_balls import WithBalls
from .turning_model import turning_model

_NODES = 8
"""Gauss nodes per step over which power is integrated: exact for polynomials of degree 15, while
steps are interpolated by polynomials of degree 7."""


class WeightEnergy:
    """Energies of the bodies of a mechanism."""

    def __init__(self, mechanism: Mechanism | WithBalls, gravity: Array) -> None:
        """Make it.

        Args:
            mechanism: the mechanism.
            gravity: `(3,)` [m/s²].
        """
        self._model = turning_model(mechanism, gravity)
        # What carries a loop's joint to the world is no body of the description.
        for index in mechanism.auxiliary_bodies:
            self._model.inertias[index] = pinocchio.Inertia.Zero()
        self._data = self._model.createData()

    def kinetic(self, x: Array, v: Array) -> Array:
        """Return kinetic energies `(N,)` at coordinates `(N, size)` and velocities `(N, nv)`."""
        energy, model, data = pinocchio.computeKineticEnergy, self._model, self._data
        return np.array([energy(model, data, *state) for state in zip(x, v, strict=True)])

    def potential(self, x: Array) -> Array:
        """Return potential energies `(N,)` of the weight at coordinates `(N, size)`."""
        energy, model, data = pinocchio.computePotentialEnergy, self._model, self._data
        return np.array([energy(model, data, row) for row in x])

    @property
    def weight(self) -> float:
        """Weight of all bodies that move [N]."""
        mass = sum(float(inertia.mass) for inertia in list(self._model.inertias)[1:])
        return mass * float(np.linalg.norm(self._model.gravity.linear))


def open_efforts(
    mechanism: Mechanism | WithBalls, gravity: Array, x: Array, v: Array, a: Array
) -> Array:
    """Return how great the efforts `(N, nv)` are that a motion needs where no loop is closed.

    Those of the accelerations and those of the speeds and the weight count by themselves: their sum
    vanishes where nothing else acts on an open chain.

    Args:
        mechanism: the mechanism.
        gravity: `(3,)` [m/s²].
        x: coordinates `(N, size)`.
        v: velocities `(N, nv)`.
        a: accelerations `(N, nv)`.
    """
    model = turning_model(mechanism, gravity)
    data = model.createData()
    efforts = np.empty_like(v)
    rest = np.zeros(model.nv)
    for index, (row, rates, gains) in enumerate(zip(x, v, a, strict=True)):
        unmoved = pinocchio.rnea(model, data, row, rates, rest)
        inertial = pinocchio.rnea(model, data, row, rates, gains) - unmoved
        efforts[index] = np.maximum(np.abs(inertial), np.abs(unmoved))
    return efforts


def gained(power: Callable[[Array], Array], steps: Array, times: Array, is_nothing: bool) -> Array:
    """Return the work `(N,)` done between time 0 and some times.

    Args:
        power: at times `(K,)` [W].
        steps: times between which it is smooth `(S,)`, from 0.
        times: `(N,)` within them.
        is_nothing: whether there is no power.
    """
    if is_nothing:
        return np.zeros(len(times))
    indices = np.clip(np.searchsorted(steps, times, side="right") - 1, 0, max(len(steps) - 2, 0))
    starts = np.concatenate([steps[:-1], steps[indices]])
    ends = np.concatenate([steps[1:], times])
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    half = 0.5 * (ends - starts)
    is_long = half > 0.0  # Times that are ends of steps have nothing left.
    if not np.any(is_long):
        return np.zeros(len(times))
    points = starts[is_long, None] + half[is_long, None] * (1.0 + nodes)
    values = power(points.ravel()).reshape(points.shape)
    pieces = np.zeros(len(half))
    pieces[is_long] = half[is_long] * (values @ weights)
    whole = np.concatenate([[0.0], np.cumsum(pieces[: len(steps) - 1])])
    return np.asarray(whole[indices] + pieces[len(steps) - 1 :])


def element_power(elements: ElementForces, x: Array, v: Array, times: Array) -> Array:
    """Return the power `(N,)` of actuators, less what dampers and friction take [W].

    Args:
        elements: of the scene.
        x: coordinates `(N, size)`, all turns counted.
        v: velocities `(N, nv)`.
        times: `(N,)` [s].
    """
    power = np.zeros(len(x))
    for element, done in zip(elements.elements, elements.exerted(x, v, times), strict=True):
        power -= done.force.dissipation
        if element.gives_power:
            power += done.power
    return power
