"""Energy: of bodies and their weight at given states, and work as the integral of power."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

import numpy as np

from ..arrays import Array
from ..elements.element_forces import ElementForces
from ..kinematics.closing.batch_model import BaseMotion, BatchModel, batch_model
from ..mechanism.mechanism import Mechanism
from .free_balls import WithBalls

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
        self._bodies = _every_body(mechanism)
        self._gravity = gravity

    def kinetic(self, x: Array, v: Array) -> Array:
        """Return kinetic energies `(N,)` at coordinates `(N, size)` and velocities `(N, nv)`."""
        return self._bodies.kinetic_energy(x, v)

    def potential(self, x: Array) -> Array:
        """Return potential energies `(N,)` of the weight at coordinates `(N, size)`."""
        return -(self._bodies.moment_of_mass(x) @ self._gravity)

    @property
    def weight(self) -> float:
        """Weight of all bodies that move [N]."""
        return float(self._bodies.mass.sum()) * float(np.linalg.norm(self._gravity))


def _every_body(mechanism: Mechanism | WithBalls) -> BatchModel:
    """Return the model of all bodies of a mechanism."""
    bodies = list(range(mechanism.model.njoints - 1))
    # With balls, it has all that a batch takes of a mechanism.
    return batch_model(cast(Mechanism, mechanism), bodies, set(bodies), np.zeros(3))


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
    bodies, rest = _every_body(mechanism), np.zeros_like(v)

    def efforts(gravity: Array, rates: Array, gains: Array) -> Array:
        base = BaseMotion.against(gravity, len(x))
        wrenches, _ = bodies.inverse_dynamics(base, x, rates, gains)
        return np.asarray(np.einsum("nki,ki->nk", wrenches[:, bodies.moved_body], bodies.subspace))

    unmoved = efforts(gravity, v, rest)
    inertial = efforts(np.zeros(3), rest, a)
    return np.maximum(np.abs(inertial), np.abs(unmoved))


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
