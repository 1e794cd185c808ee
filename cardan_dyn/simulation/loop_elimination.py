"""Loop elimination: accelerations of a chain of many loops, at a cost linear in their number.

Pinocchio's `lcaba` (Sathya, Carpentier: Constrained articulated body dynamics algorithms, 2024)
eliminates one body after the other in the order of the graph that joints and loops make, so that a
row of loops costs as many steps as there are loops. Closures act as springs of great stiffness on
the way, and proximal iterations take their yielding out again: rounding of these stiffnesses leaves
five to ten digits. Refinement gives the others: what the accelerations still lack is computed by
`rnea`, and the same elimination corrects it.

Where a closure equation is weak, the iterations do not converge: nothing is returned then, and
who asked takes the decomposition of all equations at once.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio

from ..arrays import Array

_PROXIMAL = 1e-2
"""Proximal parameter, as a fraction of the least eigenvalue of J M⁻¹ Jᵀ that is not zero: each
iteration gains two digits. A smaller one makes closures stiffer, which costs digits at once."""
_ROUNDS = 10
"""Proximal iterations of a state."""
_MORE_ROUNDS = 40
"""Proximal iterations where closures are weaker than elsewhere."""
_CORRECTING_ROUNDS = 6
"""Proximal iterations of what a refinement adds."""
_WANTED = 1e-14
"""What closures lack before the last iteration, as a fraction of accelerations that occur: more
than this is worth more iterations..."""
_CONVERGED = 1e-13
"""...and more than this is not solved."""
_REFINED = 1e-14
"""Correction that is left undone, as a fraction of accelerations that occur."""
_MOST_REFINEMENTS = 4
_GAINS = 0.1
"""Greatest correction, as a fraction of the one before, that converges."""
_SLOW = 1e-30
"""Factor of speeds at which their squares vanish."""


class LoopElimination:
    """Solves for accelerations, and for what closes loops again, body by body.

    Not for several threads at once: it has one set of Pinocchio's data.
    """

    def __init__(self, model: Any, data: Any, constraints: Any, least: float) -> None:
        """Make it.

        Args:
            model: `pin.Model` of a chain, with armature.
            data: of the model, to work in with others.
            constraints: Pinocchio's constraints that close its loops.
            least: least eigenvalue of J M⁻¹ Jᵀ that is not zero.
        """
        self._model, self._closed = model, constraints
        self._gravity = _greatest(model.gravity.linear)
        self._weightless = model.copy()
        self._weightless.gravity.linear = np.zeros(3)
        self._rest = np.zeros(model.nv)
        self._data = data
        self._constraint_data = pinocchio.StdVec_RigidConstraintData()
        for item in constraints:
            self._constraint_data.append(item.createData())
        self._each = [self._constraint_data[k] for k in range(len(constraints))]
        pinocchio.computeJointMinimalOrdering(model, self._data, constraints)
        # Accelerations that the corrections of drift ask for are the displacements that undo it.
        self._closing = _corrected(constraints, of_gaps=1.0, of_speeds=0.0)
        self._slowing = _corrected(constraints, of_gaps=0.0, of_speeds=1.0)
        self._settings, self._patient, self._correcting = (
            pinocchio.ProximalSettings(0.0, _PROXIMAL * least, rounds)
            for rounds in (_ROUNDS, _MORE_ROUNDS, _CORRECTING_ROUNDS)
        )
        self._rates, self._loops, self._signs = _moved_by(model, constraints)

    def accelerations(self, x: Array, v: Array, efforts: Array) -> Array | None:
        """Return the accelerations `(nv,)` that efforts cause; None if a closure is weak.

        Args:
            x: configuration.
            v: velocities `(nv,)`.
            efforts: along all coordinates `(nv,)`.
        """
        for settings in (self._settings, self._patient):
            a = self._solved(self._model, self._closed, x, v, efforts, settings)
            # Where it stands still, weight is held.
            occurring = max(_greatest(a), _greatest(v) ** 2, self._gravity)
            if settings.absolute_residual <= _WANTED * occurring:
                break
        # Not so either if a step was so long that there are no numbers.
        if not settings.absolute_residual <= _CONVERGED * occurring:
            return None
        wrenches, before = self._wrenches(), occurring
        for _ in range(_MOST_REFINEMENTS):
            missing = efforts - pinocchio.rnea(self._model, self._data, x, v, a)
            missing -= self._along_coordinates(wrenches)
            more = self._solved(
                self._weightless, self._closed, x, self._rest, missing, self._correcting
            )
            correction = _greatest(more)
            if not correction <= _GAINS * before:
                return None
            a = a + more
            # The next one would be smaller by as much as this one is.
            if correction**2 <= _REFINED * occurring * before:
                return a
            wrenches, before = wrenches + self._wrenches(), correction
        return None

    def displacement(self, x: Array) -> tuple[Array, float] | None:
        """Return the displacement `(nv,)` that closes loops, and their gap; None if one is weak.

        It is the least in the metric of the kinetic energy, to five digits, where gaps are those
        that errors of a step have left.

        Args:
            x: configuration, not far from closed.
        """
        rest = self._rest
        step = self._solved(self._weightless, self._closing, x, rest, rest, self._settings)
        gap = _greatest(np.array([item.contact_placement_error.vector for item in self._each]))
        if not self._settings.absolute_residual <= _CONVERGED * max(gap, 1.0):
            return None
        return step, gap

    def slowing(self, x: Array, v: Array) -> Array | None:
        """Return the change of velocities `(nv,)` after which loops stay closed, the least one."""
        change = self._solved(
            self._weightless, self._slowing, x, _SLOW * v, self._rest, self._settings
        )
        change = change / _SLOW
        if not self._settings.absolute_residual / _SLOW <= _CONVERGED * _greatest(v):
            return None
        return change

    def _solved(
        self, model: Any, constraints: Any, x: Array, v: Array, efforts: Array, settings: Any
    ) -> Array:
        # `lcaba` takes accelerations of the call before as given: they have to be none.
        pinocchio.computeForwardKinematicsDerivatives(model, self._data, x, self._rest, self._rest)
        a = pinocchio.lcaba(
            model, self._data, x, v, efforts, constraints, self._constraint_data, settings
        )
        return np.asarray(a)

    def _wrenches(self) -> Array:
        """Return the wrenches `(L, 6)` of closures on their second bodies, in the world."""
        return np.array([item.oMc1.act(item.contact_force).vector for item in self._each])

    def _along_coordinates(self, wrenches: Array) -> Array:
        """Return the efforts `(nv,)` that do the work of wrenches of the closures."""
        moved = np.sum(self._data.J[:, self._rates].T * wrenches[self._loops], axis=1)
        return np.bincount(self._rates, moved * self._signs, minlength=self._rest.size)


def _corrected(constraints: Any, *, of_gaps: float, of_speeds: float) -> Any:
    """Return copies of constraints that correct their drift."""
    copies = pinocchio.StdVec_RigidConstraintModel()
    for item in constraints:
        copy = pinocchio.RigidConstraintModel(item)
        copy.setBaumgarteCorrectorParameters(
            pinocchio.BaumgarteCorrectorParameters(of_gaps, of_speeds)
        )
        copies.append(copy)
    return copies


def _moved_by(model: Any, constraints: Any) -> tuple[Array, Array, Array]:
    """Return rates, loops and signs: how rates between the bodies of a loop move them apart."""
    rates, loops, signs = [], [], []
    for loop, item in enumerate(constraints):
        first, second = (_path(model, body) for body in (item.joint1_id, item.joint2_id))
        for own, other, sign in ((first, second, 1.0), (second, first, -1.0)):
            found = sorted(own - other)
            rates += found
            loops += [loop] * len(found)
            signs += [sign] * len(found)
    return np.array(rates, dtype=int), np.array(loops, dtype=int), np.array(signs)


def _path(model: Any, body: int) -> set[int]:
    """Return the velocity coordinates that move a body."""
    rates: set[int] = set()
    while body:
        first = int(model.idx_vs[body])
        rates |= set(range(first, first + int(model.nvs[body])))
        body = int(model.parents[body])
    return rates


def _greatest(values: Array) -> float:
    return float(np.max(np.abs(values), initial=0.0))
