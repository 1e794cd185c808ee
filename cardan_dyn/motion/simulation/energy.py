"""Energy: of bodies and their weight at given states, and work as the integral of power."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, cast

import numpy as np

from ...core.elements.element_forces import ElementForces
from ...core.mechanics.bodies import Tree, tree_of
from ...core.mechanics.placements import moving, placed
from ...core.mechanics.reactions import momentum_rates
from ...core.mechanics.vectors import ZERO, Vector, added, times, turned
from ...core.mechanism.mechanism import Mechanism
from ...core.tape import Program, Trace
from ...kit.arrays import Array
from .free_balls import WithBalls

_NODES = 8
"""Gauss nodes per step over which power is integrated: exact for polynomials of degree 15, while
steps are interpolated by polynomials of degree 7."""


class _OpenTree(NamedTuple):
    """All bodies of a mechanism while no loop is closed.

    Attributes:
        tree: the bodies.
        program: efforts along all velocity coordinates, then the sum of all masses times where
            their centres are [kg m], of coordinates, velocities, accelerations and gravity.
    """

    tree: Tree
    program: Program

    @staticmethod
    def of(mechanism: Mechanism | WithBalls) -> _OpenTree:
        """Return the bodies of a mechanism, which all who ask it share."""

        def made() -> _OpenTree:
            # With balls, it has all that a tree is read from.
            tree = tree_of(cast(Mechanism, mechanism))
            columns = tree.coordinate_units(mechanism.coordinates.size)
            with Trace() as trace:

                def inputs(name: str, units: Array) -> list[Vector]:
                    return [
                        trace.input(f"{name}{k}", 0.0) / unit
                        for k, unit in enumerate(units.tolist())
                    ]

                x = dict(enumerate(inputs("x", columns)))
                v, a = (dict(enumerate(inputs(name, tree.units))) for name in "va")
                gravity = inputs("g", np.full(3, tree.length))
                at = placed(tree, x)
                motion = moving(tree, at, v, a, times(gravity, -1.0))
                open_tree = momentum_rates(tree, at, motion, {}).passed_on(tree, at)
                efforts = open_tree.along(tree, at, v)
                for rate, taken in tree.of_rotors(a).items():
                    efforts[rate] = efforts[rate] + taken
                moment = ZERO
                for body, point, rotation in zip(tree.bodies, at.points, at.rotations, strict=True):
                    for mass in body.masses:
                        centre = added(point, turned(rotation, mass.centre))
                        moment = added(moment, times(centre, mass.mass * tree.length))
                units = tree.effort_units.tolist()
                outputs = [efforts[rate] * unit for rate, unit in enumerate(units)]
                return _OpenTree(tree, Program(trace, [*outputs, *moment], keeps_inputs=True))

        return mechanism.kept.of("open tree", "", made)

    def at(self, gravity: Array, x: Array, v: Array, a: Array) -> tuple[Array, Array]:
        """Return efforts `(N, nv)` [N·m, N], and masses times where their centres are `(N, 3)`.

        The latter are in the axes of the tree, from its origin [kg m].

        Args:
            gravity: `(3,)` [m/s²].
            x: coordinates `(N, size)`.
            v: velocities `(N, nv)`.
            a: accelerations `(N, nv)`.
        """
        given = x.T, v.T, a.T, self.tree.in_axes(gravity)[:, None]
        found = self.program.run_rows(given, len(x)).T
        return found[:, :-3], found[:, -3:]

    @property
    def mass(self) -> float:
        """Of all bodies that move [kg]."""
        return sum(mass.mass for body in self.tree.bodies for mass in body.masses)


class WeightEnergy:
    """Energies of the bodies of a mechanism."""

    def __init__(self, mechanism: Mechanism | WithBalls, gravity: Array) -> None:
        """Make it.

        Args:
            mechanism: the mechanism.
            gravity: `(3,)` [m/s²].
        """
        self._bodies = _OpenTree.of(mechanism)
        self._gravity = gravity

    def kinetic(self, x: Array, v: Array) -> Array:
        """Return kinetic energies `(N,)` at coordinates `(N, size)` and velocities `(N, nv)`.

        They are half of the power of what accelerations as great as the velocities need from rest.
        """
        efforts, _ = self._bodies.at(np.zeros(3), x, np.zeros_like(v), v)
        return np.asarray(0.5 * np.sum(efforts * v, axis=1))

    def potential(self, x: Array) -> Array:
        """Return potential energies `(N,)` of the weight at coordinates `(N, size)`."""
        rest, tree = np.zeros((len(x), len(self._bodies.tree.units))), self._bodies.tree
        _, moment = self._bodies.at(np.zeros(3), x, rest, rest)
        begun = self._bodies.mass * (tree.origin @ self._gravity)
        return np.asarray(-(moment @ tree.in_axes(self._gravity)) - begun)

    @property
    def weight(self) -> float:
        """Weight of all bodies that move [N]."""
        return self._bodies.mass * float(np.linalg.norm(self._gravity))


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
    bodies, rest = _OpenTree.of(mechanism), np.zeros_like(v)
    unmoved, _ = bodies.at(gravity, x, v, rest)
    inertial, _ = bodies.at(np.zeros(3), x, rest, a)
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
