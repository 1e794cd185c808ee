"""System: the equations of motion as a differential equation, and what keeps its states closed."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from ..arrays import Array, quaternion_product
from ..errors import SingularConfigurationError
from .constrained_model import ConstrainedModel
from .forces import Forces, Named, StateNames
from .turning_model import turning_model

Motion = Callable[[float], tuple[float, float, float]]
"""Position, speed and acceleration of a prescribed joint at a time."""


_FARTHEST = 1e-2
"""Greatest displacement [rad, or a fraction of the length] by which loops are closed that drifted
open within a step: a greater one might end in another assembly mode."""


class System:
    """Derivatives of states: coordinates and velocities in a row `y (size + nv,)`.

    Attributes:
        model: gives accelerations and closes loops.
        physical: Pinocchio's model in metres, whose configurations are coordinate rows.
        size: number of coordinates.
        turns: whole turns `(size,)` that have been taken off the angles so far.
    """

    def __init__(
        self,
        model: ConstrainedModel,
        forces: Forces,
        motions: Mapping[str, Motion],
        start: Array,
    ) -> None:
        """Make the system.

        Args:
            model: of the mechanism.
            forces: what acts.
            motions: driven coordinates to how they move; all other prescribed ones rest.
            start: coordinates `(size,)` at which those rest.
        """
        coordinates = model.mechanism.coordinates
        self.model, self._forces = model, forces
        self.physical = turning_model(model.mechanism)
        self._data = self.physical.createData()
        self._names = StateNames(coordinates)
        self.size = coordinates.size
        self.turns = np.zeros(self.size)
        self._columns, self._rates = coordinates.scalars
        self._balls = list(zip(*map(np.ndarray.tolist, coordinates.balls), strict=True))
        self._is_plain = not self._balls
        prescribed = model.prescribed.tolist()
        self._motions = [
            (coordinates.named[name], prescribed.index(coordinates.named[name].rate), motion)
            for name, motion in motions.items()
        ]
        moving = {item.rate for item, _, _ in self._motions}
        self._resting = np.array([rate for rate in prescribed if rate not in moving], dtype=int)
        self._resting_columns = coordinates.column_of(self._resting)
        self._resting_at = start[self._resting_columns]
        self._scale = coordinates.scale
        coupled = {
            column
            for item in model.mechanism.couplings
            for column in (*item.predecessor_columns, *item.successor_columns)
        }
        # Ratios of couplings hold between all turns of their joints, not between angles.
        self._wrapped = np.array(
            [
                column
                for column, rate in zip(self._columns.tolist(), self._rates.tolist(), strict=True)
                if column in set(coordinates.angle_columns.tolist()) and rate not in coupled
            ],
            dtype=int,
        )

    def derivative(self, time: float, y: Array) -> Array:
        """Return the time derivative of a row."""
        x, v = y[: self.size], y[self.size :]
        result = np.empty_like(y)
        if self._is_plain:
            result[: self.size] = v
        else:
            x = self.unit(x)
            result[self._columns] = v[self._rates]
            for column, start in self._balls:
                spin = np.array([[*(0.5 * v[start : start + 3]), 0.0]])
                quaternion = y[None, column : column + 4]
                result[column : column + 4] = quaternion_product(quaternion, spin)[0]
        result[self.size :] = self.accelerations(time, x, v)
        return result

    def accelerations(self, time: float, x: Array, v: Array) -> Array:
        """Return accelerations `(nv,)` at coordinates and velocities."""
        model = self.model
        efforts = None
        if not self._forces.is_nothing:
            counted = x + 2.0 * np.pi * self.turns
            efforts = self._forces.efforts(self.physical, self._data, time, counted, v)
        prescribed = None
        if self._motions:
            prescribed = np.zeros(len(model.prescribed))
            for _, index, motion in self._motions:
                prescribed[index] = motion(time)[2]
        return model.accelerations(x, v, efforts, prescribed)

    def unit(self, x: Array) -> Array:
        """Return a copy of coordinates with quaternions of unit length."""
        x = x.copy()
        for column, _ in self._balls:
            x[column : column + 4] /= np.linalg.norm(x[column : column + 4])
        return x

    def restored(self, time: float, y: Array, *, crosses: bool = False) -> Array:
        """Return a row whose loops are closed again, in positions and in velocities.

        Args:
            time: [s].
            y: the row.
            crosses: whether it is on a step over a crossing.
        """
        x, v = self.unit(y[: self.size]), y[self.size :].copy()
        for coordinate, _, motion in self._motions:
            position, speed, _ = motion(time)
            x[coordinate.column] = position - 2.0 * np.pi * self.turns[coordinate.column]
            v[coordinate.rate] = speed
        # However great the inertia that holds it, what rests drifts in a thousand turns.
        x[self._resting_columns], v[self._resting] = self._resting_at, 0.0
        closed, rates = self.model.closed(x, v, crosses=crosses)
        moved = float(np.max(np.abs(closed - x) * self._scale, initial=0.0))
        if not moved <= _FARTHEST:
            raise SingularConfigurationError(
                f"at time {time:.6g} s the loops opened by {moved:.1e} within one step, so that "
                "closing them could lead to another assembly mode; the mechanism is close to a "
                "singular configuration, or the tolerance is too wide: give a smaller rtol"
            )
        return np.concatenate([closed, rates])

    def wrap(self, y: Array) -> Array:
        """Return a row without whole turns, which `turns` then counts."""
        turns = np.round(y[self._wrapped] / (2.0 * np.pi))
        if np.any(turns):
            y = y.copy()
            y[self._wrapped] -= 2.0 * np.pi * turns
            self.turns = self.turns.copy()
            self.turns[self._wrapped] += turns
        return y

    def named(self, y: Array, turns: Array) -> tuple[Named, Named]:
        """Return positions and speeds by name of a row."""
        x = y[: self.size] + 2.0 * np.pi * turns
        return self._names.positions(x), self._names.speeds(y[self.size :])
