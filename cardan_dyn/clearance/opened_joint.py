"""Opened joint: how easily the two sides of a pin move apart where its bush has play."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio

from ..arrays import Array
from ..errors import ModelError
from ..mechanism.mechanism import Mechanism
from ..mechanism.welds import constraint_models
from ..simulation.closed_directions import ClosedDirections

_ZERO = 1e-9
"""Singular value of the closure equations, as a fraction of the greatest, that counts as zero."""
_WEIGHTLESS = 1e-13
"""Eigenvalue of the inertia along the ways that are left, as a fraction of the greatest, that
counts as none."""


class Mobility(NamedTuple):
    """How an opened joint gives way at one position.

    Attributes:
        axes: `(2, 3)` unit vectors across the pin, in the world.
        matrix: `(2, 2)` W: acceleration of one side relative to the other per force between them,
            along these axes [1/kg].
    """

    axes: Array
    matrix: Array

    def reduced_mass(self, direction: Array, *, is_guided: bool = False) -> float:
        """Return the mass that a force along a direction `(3,)` in the world has to move [kg].

        Args:
            direction: across the pin.
            is_guided: whether the sides are held from moving across the direction; otherwise they
                are free to.
        """
        along = self.axes @ direction
        along = along / np.linalg.norm(along)
        across = np.array([-along[1], along[0]])
        moved = float(along @ self.matrix @ along)
        if is_guided:
            beside = float(along @ self.matrix @ across)
            moved -= beside**2 / float(across @ self.matrix @ across)
        return 1.0 / moved

    def deviation(self, direction: Array) -> float:
        """Return the angle between a force along a direction and the motion it causes [rad]."""
        along = self.axes @ direction
        moved = self.matrix @ along
        return float(np.arctan2(abs(along[0] * moved[1] - along[1] * moved[0]), along @ moved))


class OpenedJoint:
    """A mechanism in which a turning joint has two slides across its axis.

    All its other joints and loops are closed, its drives prescribed or of a finite inertia:
    W = J [M⁻¹ − M⁻¹Aᵀ(A M⁻¹ Aᵀ)⁻¹A M⁻¹] Jᵀ, computed by the directions that the closure equations
    leave, so that redundant equations do no harm.
    """

    def __init__(
        self, mechanism: Mechanism, joint: str, fixed: Sequence[int], rotors: dict[int, float]
    ) -> None:
        """Open a joint.

        Args:
            mechanism: that has the joint.
            joint: name of a joint that turns about one axis.
            fixed: velocity coordinates that are driven or held.
            rotors: velocity coordinates that move freely to inertias that turn with them [kg m²].
        """
        self._name, self._length = joint, mechanism.characteristic_length
        (part,) = mechanism.joint(joint).parts
        model, own = _opened(mechanism, part.id, part.axis)
        loops = [
            loop._replace(predecessor=own[loop.predecessor], successor=own[loop.successor])
            for loop in mechanism.loops
        ]
        self._column = mechanism.coordinates.columns[joint].start
        rate = mechanism.coordinates.velocity_columns[joint].start
        self._slides = np.array([rate, rate + 1])
        moved = {index: index + 2 * (index >= rate) for index in range(mechanism.model.nv)}
        none = np.array([], dtype=int)
        couplings = np.zeros((len(mechanism.couplings), model.nv))
        for row, coupling in zip(couplings, mechanism.couplings, strict=True):
            row[[moved[index] for index in coupling.predecessor_columns]] += coupling.ratio
            row[[moved[index] for index in coupling.successor_columns]] -= 1.0
        constraints = constraint_models(model, loops)
        self._closure = ClosedDirections(model, constraints, couplings, none, rank=model.nv)
        self._free = np.delete(np.arange(model.nv), [moved[index] for index in fixed])
        self._scale = np.ones(model.nv)
        self._scale[
            [moved[k] for k in np.nonzero(mechanism.coordinates.rate_scale != 1.0)[0].tolist()]
        ] = self._length
        self._scale[self._slides] = self._length
        self._armature = np.zeros(model.nv)
        for index, inertia in rotors.items():
            self._armature[moved[index]] = inertia
        self._model, self._data = model, model.createData()
        self._first = own[part.id] - 2

    def mobility(self, x: Array) -> Mobility:
        """Return how the joint gives way.

        Args:
            x: `(size,)` closed coordinates of the mechanism.

        Raises:
            ModelError: what would move has no mass.
        """
        x = np.insert(x, self._column, [0.0, 0.0])
        pinocchio.forwardKinematics(self._model, self._data, x)
        inertia = np.triu(pinocchio.crba(self._model, self._data, x))
        inertia += np.triu(inertia, 1).T
        inertia += np.diag(self._armature)
        rows = self._closure.jacobian(x) * self._scale
        rows[: len(rows) // 6 * 6].reshape(-1, 6, rows.shape[1])[:, :3] /= self._length
        _, values, right = np.linalg.svd(rows[:, self._free])
        rank = int(np.count_nonzero(values > _ZERO * np.max(values, initial=0.0)))
        ways = np.zeros((len(self._scale), len(self._free) - rank))
        ways[self._free] = right[rank:].T
        ways *= self._scale[:, None]
        own = ways.T @ inertia @ ways
        sizes = np.linalg.eigvalsh(own)
        if not sizes.size or sizes[0] <= _WEIGHTLESS * max(sizes[-1], 0.0):
            raise ModelError(
                f"joint {self._name!r}: where it is open, something without mass is free to move; "
                "give all links between it and the drive a mass"
            )
        apart = ways[self._slides]
        frame = self._data.oMi[self._first].rotation
        return Mobility((frame @ self._axes.T).T, apart @ np.linalg.solve(own, apart.T))

    @property
    def _axes(self) -> Array:
        """Unit vectors `(2, 3)` along which the slides move, in the joint's frame."""
        joints = [self._model.joints[self._first + k] for k in range(2)]
        return np.array([np.asarray(item.extract().axis) for item in joints])


def _opened(mechanism: Mechanism, body: int, axis: Array) -> tuple[Any, dict[int, int]]:
    """Return the model with two slides before a body's joint, and where its bodies are in it."""
    source, model, own = mechanism.model, pinocchio.Model(), {0: 0}
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    for part in mechanism.coordinates.parts:
        index = part.id
        joint, placement = source.joints[index], source.jointPlacements[index]
        parent = own[source.parents[index]]
        if index == body:
            for way in (first, np.cross(axis, first)):
                slide = pinocchio.JointModelPrismaticUnaligned(way)
                parent = model.addJoint(parent, slide, placement, f"slide_{model.njoints}")
                placement = pinocchio.SE3.Identity()
        if part.kind == "revolute":
            joint = pinocchio.JointModelRevoluteUnaligned(part.axis)
        own[index] = model.addJoint(parent, joint, placement, source.names[index])
        model.inertias[own[index]] = source.inertias[index]
    model.gravity.linear = np.zeros(3)
    return model, own
