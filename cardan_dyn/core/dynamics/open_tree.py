"""Open tree: energies of bodies, and efforts of motions that no loop constrains."""

from __future__ import annotations

from functools import partial

import numpy as np

from ...kit.arrays import Array
from ..mechanics.bodies import Tree, tree_of
from ..mechanics.placements import moving, placed
from ..mechanics.reactions import momentum_rates
from ..mechanics.vectors import ZERO, Vector, added, times, turned
from ..mechanism.mechanism import Mechanism
from ..tape import Program, Trace


class OpenTree:
    """All bodies of a mechanism under gravity, while no loop is closed."""

    def __init__(self, mechanism: Mechanism, gravity: Array) -> None:
        """Trace it, unless somebody has done so.

        Args:
            mechanism: the mechanism.
            gravity: `(3,)` [m/s²].
        """
        traced = partial(_traced, mechanism)
        self._tree, self._program = mechanism.kept.of("open tree", "", traced)
        self._mass = sum(mass.mass for body in self._tree.bodies for mass in body.masses)
        self._gravity = gravity

    def kinetic(self, x: Array, v: Array) -> Array:
        """Return kinetic energies `(N,)` at coordinates `(N, size)` and velocities `(N, nv)`.

        They are half of the power of what accelerations as great as the velocities need from rest.
        """
        efforts, _ = self._at(np.zeros(3), x, np.zeros_like(v), v)
        return np.asarray(0.5 * np.sum(efforts * v, axis=1))

    def potential(self, x: Array) -> Array:
        """Return potential energies `(N,)` of the weight at coordinates `(N, size)`."""
        rest, tree = np.zeros((len(x), len(self._tree.units))), self._tree
        _, moment = self._at(np.zeros(3), x, rest, rest)
        begun = self._mass * (tree.origin @ self._gravity)
        return np.asarray(-(moment @ tree.in_axes(self._gravity)) - begun)

    @property
    def weight(self) -> float:
        """Weight of all bodies that move [N]."""
        return self._mass * float(np.linalg.norm(self._gravity))

    def efforts(self, x: Array, v: Array, a: Array) -> Array:
        """Return how great the efforts `(N, nv)` are that a motion needs where no loop is closed.

        Those of the accelerations and those of the speeds and the weight count by themselves: their
        sum vanishes where nothing else acts on an open chain.

        Args:
            x: coordinates `(N, size)`.
            v: velocities `(N, nv)`.
            a: accelerations `(N, nv)`.
        """
        rest = np.zeros_like(v)
        unmoved, _ = self._at(self._gravity, x, v, rest)
        inertial, _ = self._at(np.zeros(3), x, rest, a)
        return np.maximum(np.abs(inertial), np.abs(unmoved))

    def _at(self, gravity: Array, x: Array, v: Array, a: Array) -> tuple[Array, Array]:
        """Return efforts `(N, nv)` [N·m, N], and masses times where their centres are `(N, 3)`.

        The latter are in the axes of the tree, from its origin [kg m].
        """
        given = x.T, v.T, a.T, self._tree.in_axes(gravity)[:, None]
        found = self._program.run_rows(given, len(x)).T
        return found[:, :-3], found[:, -3:]


def _traced(mechanism: Mechanism) -> tuple[Tree, Program]:
    """Return the bodies of a mechanism, and a program of what `OpenTree._at` returns.

    Of coordinates, velocities, accelerations and gravity.
    """
    tree = tree_of(mechanism)
    columns = tree.coordinate_units(mechanism.coordinates.size)
    with Trace() as trace:

        def inputs(name: str, units: Array) -> list[Vector]:
            return [trace.input(f"{name}{k}", 0.0) / unit for k, unit in enumerate(units.tolist())]

        x = dict(enumerate(inputs("x", columns)))
        v, a = (dict(enumerate(inputs(name, tree.units))) for name in "va")
        gravity = inputs("g", np.full(3, tree.length))
        at = placed(tree, x)
        motion = moving(tree, at, v, a, times(gravity, -1.0))
        open_tree = momentum_rates(tree, motion, {}).passed_on(tree, at)
        efforts = open_tree.along(tree, v)
        for rate, taken in tree.of_rotors(a).items():
            efforts[rate] = efforts[rate] + taken
        moment = ZERO
        for body, point, rotation in zip(tree.bodies, at.points, at.rotations, strict=True):
            for mass in body.masses:
                centre = added(point, turned(rotation, mass.centre))
                moment = added(moment, times(centre, mass.mass * tree.length))
        units = tree.effort_units.tolist()
        outputs = [efforts[rate] * unit for rate, unit in enumerate(units)]
        return tree, Program(trace, [*outputs, *moment], keeps_inputs=True)
