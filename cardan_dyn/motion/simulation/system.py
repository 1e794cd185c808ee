"""System: the equations of motion as a differential equation, and what keeps its states closed."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...core.elements.stepping import Traced
from ...core.kinematics.tolerances import SAFE_CORRECTION
from ...kit.arrays import Array
from ...kit.errors import SingularConfigurationError
from .constrained_model import ConstrainedModel
from .continuity import States
from .forces import Forces, State
from .free_balls import COINCIDE, WithBalls
from .turning_model import turning_model

Motion = Callable[[float], tuple[float, float, float]]
"""Position, speed and acceleration of a prescribed joint at a time."""


class Rows(NamedTuple):
    """States at N times.

    Attributes:
        x: coordinates `(N, size)` with closed loops.
        turns: whole turns `(N, size)` that angles lack.
        v, a: velocities and accelerations `(N, nv)`.
        exist: which of them are decided `(N, nv)`. Where axes of a ball coincide, the rates of its
            angles may have no limit; what stands there moves the body otherwise.
        bodies: the same states in coordinates that are regular wherever bodies are, those of
            `Run.regular`; None where they are the mechanism's own.
        read: coordinates, all turns counted, and velocities that forces were told of when the
            method found `a`; None where they are those above to the last digit.
    """

    x: Array
    turns: Array
    v: Array
    a: Array
    exist: Array
    bodies: States | None = None
    read: tuple[Array, Array] | None = None

    def at(self, chosen: Array) -> Rows:
        """Return some of them."""
        bodies = self.bodies and self.bodies.at(chosen)
        read = self.read and (self.read[0][chosen], self.read[1][chosen])
        x, turns, v, a, exist = (values[chosen] for values in self[:5])
        return Rows(x, turns, v, a, exist, bodies, read)

    @property
    def counted(self) -> Array:
        """Coordinates, all turns counted."""
        return self.x + 2.0 * np.pi * self.turns

    @property
    def regular(self) -> States:
        """The states in regular coordinates, see `bodies`."""
        return self.bodies or States(self.x, self.v, self.a)


class System:
    """Derivatives of states: coordinates and velocities in a row `y (size + nv,)`.

    Attributes:
        model: gives accelerations and closes loops.
        size: length of a row's coordinates: the mechanism's, but for quaternions of free balls.
        turns: whole turns `(size,)` that have been taken off the angles so far; of a free ball, the
            three angles near which it is, in turns.
        evaluations: see `Equations`.
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
            start: coordinates of the mechanism at which those rest.
        """
        coordinates = model.mechanism.coordinates
        self.model, self._forces = model, forces
        # Called for every stage of every step: what only passes on is left out of the way.
        self._rates_of = (model.chains[0] if len(model.chains) == 1 else model).rates
        free = None
        if isinstance(model.mechanism, WithBalls):
            free, self.mechanism = model.mechanism, model.mechanism.source
        else:
            self.mechanism = model.mechanism
        self._free: WithBalls | None = free
        self._reads_angles = free is not None and forces.depend_on(
            {ball.rate + k for ball in free.balls for k in range(3)}
        )
        start = free.row(start) if free else start
        named = self.mechanism.coordinates.named
        self.size = coordinates.size
        self.turns, self.evaluations = np.zeros(self.size), 0
        self._balls = coordinates.balls[0].tolist()
        self._reads_balls = bool(self._balls) and (free is not None or forces.act_on_links)
        prescribed = model.prescribed.tolist()
        moving = [named[name].rate for name in motions]
        columns = coordinates.column_of(np.array(moving, dtype=int)).tolist()
        self._motions = [
            (column, rate, prescribed.index(rate), motion)
            for column, rate, motion in zip(columns, moving, motions.values(), strict=True)
        ]
        acts = bool(self._motions) or not forces.is_nothing
        # A single chain on which nothing acts is integrated by its program alone.
        self._chain = model.chains[0]
        self._is_alone = len(model.chains) == 1 and not acts
        self._resting = np.array([rate for rate in prescribed if rate not in moving], dtype=int)
        self._resting_columns = coordinates.column_of(self._resting)
        self._resting_at = start[self._resting_columns]
        # Whether a row is what the model takes, with nothing in it that is given.
        self._is_free = not (self._balls or self._motions or self._resting.size)
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
                for column, rate in zip(*map(np.ndarray.tolist, coordinates.scalars), strict=True)
                if column in set(coordinates.angle_columns.tolist()) and rate not in coupled
            ],
            dtype=int,
        )

    def traced(self) -> Traced | None:
        """Return what gives derivatives sooner, see `Stepper`."""
        given = self._chain.traced if self._is_alone else None
        return None if given is None else Traced(given, self._counted)

    def _counted(self, evaluations: int) -> None:
        self.evaluations += evaluations

    @cached_property
    def physical(self) -> Any:
        """Pinocchio's model of the mechanism in metres, see `placed`; forces ask for it."""
        return turning_model(self.mechanism)

    @cached_property
    def _data(self) -> Any:
        return self.physical.createData()

    def derivative(self, time: float, y: Array) -> Array:
        """Return the time derivative of a row."""
        self.evaluations += 1
        x, v = y[: self.size], y[self.size :]
        efforts = None if self._forces.is_nothing else self._efforts(time, y)
        prescribed = None
        if self._motions:
            prescribed = np.zeros(len(self.model.prescribed))
            for _, _, index, motion in self._motions:
                prescribed[index] = motion(time)[2]
        return self._rates_of(x, v, efforts, prescribed)

    def _read(self, y: Array, turns: Array) -> tuple[Array, Array]:
        """Return the mechanism's coordinates, all turns counted, and their rates, of a row."""
        x, v = y[: self.size], y[self.size :]
        if self._free is None:
            return x + 2.0 * np.pi * turns, v
        counted = self._free.positions(self.unit(x), turns)
        rates, *_ = self._free.rates(counted, v, np.zeros_like(v))
        return counted, rates

    def _efforts(self, time: float, y: Array) -> Array:
        """Return what acts along all velocities `(nv,)`."""
        forces, free, data = self._forces, self._free, self._data
        if self._reads_balls:
            y = np.concatenate((self.unit(y[: self.size]), y[self.size :]))
        counted, rates = self._read(y, self.turns)
        if free is None:
            return forces.efforts(self.physical, data, time, counted, rates)
        efforts = free.efforts(counted, forces.along_coordinates(time, counted, rates))
        if forces.act_on_links:
            placed = self.placed(y[: self.size], y[self.size :])
            on_links = forces.on_links(self.physical, data, time, *placed, counted, rates)
            efforts += free.regular_moments(on_links)
        return efforts

    def boundless(self, time: float, y: Array, turns: Array, apart: float = COINCIDE) -> str:
        """Return why forces on a row have no bound; empty if they have one.

        Args:
            time: [s].
            y: the row.
            turns: of the row.
            apart: sine of the angle between outer axes of a ball up to which they coincide.
        """
        if not self._reads_angles or self._free is None:
            return ""
        counted, rates = self._read(y, turns)
        locked = [ball for ball in self._free.balls if ball.apart(counted) < apart]
        if not locked:
            return ""
        efforts = self._forces.along_coordinates(time, counted, rates)
        names = {item.rate: name for name, item in self.mechanism.coordinates.named.items()}
        for ball in locked:
            if efforts[ball.rate] or efforts[ball.rate + 2]:
                first, middle, last = (names[ball.rate + k] for k in range(3))
                return (
                    f"{middle!r} is where the axes of {first!r} and {last!r} coincide (gimbal "
                    "lock), and forces act along these two, whose moment has no limit there; let "
                    "forces act on the links (Bushing, PointSpring, Wrench) or along the middle "
                    "angle alone, or turn the joint's origin"
                )
        return ""

    def placed(self, x: Array, v: Array) -> tuple[Array, Array]:
        """Return configuration and velocities of `physical` for coordinates and velocities.

        All bodies are where they are; hinges of free balls are placed so that axes differ.
        """
        if self._free is None:
            return x, v
        counted = self._free.positions(x, self.turns)
        return self._free.regular(self.physical, counted, x, v)

    def unit(self, x: Array) -> Array:
        """Return a copy of coordinates with quaternions of unit length."""
        x = x.copy()
        for column in self._balls:
            x[column : column + 4] /= np.linalg.norm(x[column : column + 4])
        return x

    def restored(self, time: float, y: Array, *, crosses: bool = False) -> Array:
        """Return a row whose loops are closed again, in positions and in velocities.

        Args:
            time: [s].
            y: the row.
            crosses: whether it is on a step over a crossing.
        """
        x, v = y[: self.size], y[self.size :]
        if not self._is_free:
            x, v = self.unit(x), v.copy()
        for column, rate, _, motion in self._motions:
            position, speed, _ = motion(time)
            x[column] = position - 2.0 * np.pi * self.turns[column]
            v[rate] = speed
        if self._reads_angles and (reason := self.boundless(time, y, self.turns)):
            raise SingularConfigurationError(reason)
        if self._resting.size:
            # However great the inertia that holds it, what rests drifts in a thousand turns.
            x[self._resting_columns], v[self._resting] = self._resting_at, 0.0
        try:
            closed, rates = self.model.closed(x, v, crosses=crosses)
        except SingularConfigurationError as error:
            raise SingularConfigurationError(f"at time {time:.6g} s {error}") from error
        moved = ((closed - x) * self._scale).tolist()
        for part in moved:
            if -SAFE_CORRECTION <= part <= SAFE_CORRECTION:
                continue
            farthest = float(np.max(np.abs(moved)))
            raise SingularConfigurationError(
                f"at time {time:.6g} s the loops opened by {farthest:.1e} within one step, so that "
                "closing them could lead to another assembly mode; the mechanism is close to a "
                "singular configuration, or the tolerance is too wide: give a smaller rtol"
            )
        return np.concatenate((closed, rates))

    def wrap(self, y: Array) -> Array:
        """Return a row without whole turns, which `turns` then counts."""
        angles = y[self._wrapped]
        for angle in angles.tolist():
            if not -math.pi <= angle <= math.pi:
                break
        else:
            return y
        turns = np.round(angles / (2.0 * np.pi))
        y = y.copy()
        y[self._wrapped] -= 2.0 * np.pi * turns
        self.turns = self.turns.copy()
        self.turns[self._wrapped] += turns
        return y

    def begin(self, x: Array, turns: Array, v: Array) -> Array:
        """Return the first row, and count its turns.

        Args:
            x: coordinates of the mechanism.
            turns: that they lack.
            v: velocities of the mechanism `(nv,)`.
        """
        if self._free is None:
            self.turns = turns.copy()
            return np.concatenate([x, v])
        self.turns = self._free.turns(x, turns)
        return np.concatenate([self._free.row(x), self._free.velocities(x, v)])

    def followed(
        self,
        turns: Array,
        ends: tuple[float, float],
        rows: tuple[Array, Array],
        way: Callable[[float], Array],
    ) -> Array:
        """Return the turns at the end of a part of a step, see `Equations`."""
        if self._free is None:
            return turns

        def state(row: Array) -> tuple[Array, Array]:
            return self.unit(row[: self.size]), row[self.size :]

        states = state(rows[0]), state(rows[1])
        return self._free.followed(turns, ends, states, lambda time: state(way(time)))

    def is_misread(self, y: Array, turns: Array) -> bool:
        """Return whether forces saw other angles at a step's end than those it led to."""
        if not self._reads_angles or self._free is None:
            return False
        seen, true = (self._read(y, item)[0] for item in (self.turns, turns))
        return bool(np.max(np.abs(seen - true)) > 1.0)

    def rows(self, y: Array, turns: Array, rates: Array) -> Rows:
        """Return what N rows, their turns and their derivatives mean for the mechanism."""
        x, v, a = y[:, : self.size], y[:, self.size :], rates[:, self.size :]
        if self._free is None:
            return Rows(x, turns, v, a, np.ones(v.shape, dtype=bool))
        bodies, places = States(x, v, a), zip(map(self.unit, x), turns, strict=True)
        counted = np.array([self._free.positions(*place) for place in places])
        found = [self._free.rates(*state) for state in zip(counted, v, a, strict=True)]
        v, a, exist = map(np.array, zip(*found, strict=True))
        wound, angles = np.zeros_like(counted), self.mechanism.coordinates.angle_columns
        wound[:, angles] = np.round(counted[:, angles] / (2.0 * np.pi))
        x = counted - 2.0 * np.pi * wound
        return Rows(x, wound, v, a, exist, bodies, (counted, v))

    def named(self, y: Array, turns: Array) -> State:
        """Return positions and speeds by name of a row."""
        return self._forces.names.of(*self._read(y, turns))
