"""Generalised forces of elements: by Pinocchio's virtual work, and as slopes of the energy."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio

import cardan_dyn as cd
from cardan_dyn.core.elements.element_forces import Acted, ElementForces


def generalised(mechanism: cd.Mechanism, x: np.ndarray, acted: Acted) -> np.ndarray:
    """Return `(N, nv)` efforts and wrenches as efforts along the coordinates, by Pinocchio."""
    model, result = mechanism.model, acted.efforts.copy()
    data = model.createData()
    for sample, q in enumerate(mechanism.coordinates.configuration(x)):
        pinocchio.computeJointJacobians(model, data, q)
        for wrench in acted.wrenches:
            body, placement = mechanism.links[wrench.link]
            origin = (data.oMi[body] * placement).translation
            jacobian = pinocchio.getJointJacobian(
                model, data, body, pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
            )
            force, moment = wrench.force[sample], wrench.moment[sample]
            about_body = moment + np.cross(origin - data.oMi[body].translation, force)
            result[sample] += jacobian.T @ np.concatenate([force, about_body])
    return result


def slopes(
    mechanism: cd.Mechanism,
    energy: Callable[[np.ndarray], np.ndarray],
    x: np.ndarray,
    step: float = 1e-3,
) -> np.ndarray:
    """Return `(N, nv)` derivatives of an energy along the velocity coordinates, by differences."""
    moves = mechanism.coordinates.moves(np.arange(mechanism.model.nv))
    result = np.empty((len(x), mechanism.model.nv))
    for column in range(mechanism.model.nv):

        def at(distance: float, column: int = column) -> np.ndarray:
            row, displacement = x.copy(), np.zeros((len(x), mechanism.model.nv))
            displacement[:, column] = distance
            moves.apply(row, displacement)
            return energy(row)

        first, second, third = (
            (at(k * step) - at(-k * step)) / (2.0 * k * step) for k in (1.0, 2.0, 3.0)
        )
        result[:, column] = 1.5 * first - 0.6 * second + 0.1 * third
    return result


def energy_of(forces: ElementForces, mechanism: cd.Mechanism) -> Callable[[np.ndarray], np.ndarray]:
    """Return the potential energy of elements as a function of rows `(N, size)`."""

    def energy(x: np.ndarray) -> np.ndarray:
        return forces.at(x, np.zeros((len(x), mechanism.model.nv))).potential_energy

    return energy
