"""Response: a scene with one drive as functions of the drive's position.

Every wrench is A(φ) speed² + B(φ) acceleration + Σ C(φ) load + G(φ) · gravity. The columns are
periodic, or analytic on a range, so that a few hundred solved positions give them everywhere to
rounding, for any number of operating points.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from decimal import Decimal
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Array
from ..checks import described, mapping, numbers
from ..dynamics.problem_solver import ProblemSolver
from ..errors import ArgumentError, choices
from ..frozen import Frozen, read_only
from ..proof.residuals import CHECK_ROUNDING
from ..results.sweep import Sweep
from .columns import ACCELERATION, GRAVITY, SPEED_SQUARED, Column, Kind
from .data import ResponseData
from .operating_points import CouplingMoments, OperatingPoints, solved_motion

_MOST = 1e300
_MOST_POINTS = 2**30
"""Operating points of one sweep; a component of a wrench takes 8 bytes for each."""


class Response(Frozen):
    """Joint wrenches and efforts as functions of the drive's position; `Scene.response` makes it.

    Nothing in it can be changed.

    Attributes:
        proof: how well it holds.
    """

    def __init__(self, solver: ProblemSolver, data: ResponseData) -> None:
        """Make the response.

        Args:
            solver: of the scene; motions are solved by it.
            data: the functions.
        """
        self._solver = solver
        self._problem = solver.problem
        self._data = data
        self.proof = data.proof
        self._freeze()

    def __reduce__(self) -> tuple[object, ...]:
        return Response, (self._solver, self._data)

    @property
    def columns(self) -> tuple[str, ...]:
        """What wrenches are proportional to: `speed²`, `acceleration`, loads, `gravity x` …."""
        return tuple(column.label for column in self._data.layout.columns)

    @property
    def sample_count(self) -> int:
        """Number of solved positions."""
        return int(self._data.series.values.shape[1])

    @property
    def error(self) -> float:
        """Measured error, see `Proof`."""
        return self.proof.error

    @property
    def interval(self) -> tuple[float, float]:
        """Drive positions between which it holds [rad or m], ±inf if it is periodic."""
        if self._data.series.periodic:
            return -np.inf, np.inf
        return (
            self._data.series.origin - self._data.series.length,
            self._data.series.origin + self._data.series.length,
        )

    def __repr__(self) -> str:
        return (
            f"<Response of {self._problem.mechanism.name!r}: {self.sample_count} samples, "
            f"columns {', '.join(self.columns)}, error {self.error:.1e}>"
        )

    def sweep(
        self,
        position: ArrayLike,
        speed: ArrayLike = 0.0,
        acceleration: ArrayLike = 0.0,
        *,
        loads: Mapping[str, ArrayLike] | None = None,
        gravity: ArrayLike | None = None,
    ) -> Sweep:
        """Return wrenches at any operating points; nothing is computed before it is asked for.

        Args:
            position: drive positions [rad or m] of any shape.
            speed: drive speeds [rad/s or m/s].
            acceleration: drive accelerations [rad/s² or m/s²]. All arguments broadcast.
            loads: efforts at joints instead of the scene's, by name [N·m or N]. Wrenches on links
                stay the scene's.
            gravity: `(..., 3)` [m/s²] instead of the scene's.

        Raises:
            ArgumentError: not finite, shapes that do not match, a load that the response was not
                built for, or a position out of range.
        """
        positions = np.atleast_1d(_numbers("position", position))
        low, high = self.interval
        # The limits are rounded as sums of the middle and half of the range.
        slack = 1e-12 * self._data.series.length + 1e-15 * abs(self._data.series.origin)
        if np.any(positions < low - slack) or np.any(positions > high + slack):
            raise ArgumentError(f"the response holds for positions from {low:.9g} to {high:.9g}")
        return self._sweep(positions, None, speed, acceleration, loads, gravity)

    def uniform(
        self,
        count: int,
        speed: ArrayLike = 0.0,
        acceleration: ArrayLike = 0.0,
        *,
        loads: Mapping[str, ArrayLike] | None = None,
        gravity: ArrayLike | None = None,
    ) -> Sweep:
        """Return wrenches at `count` equal steps of one period, by FFT.

        The first position is the scene's start, 0 unless it starts elsewhere. Other arguments as
        for `sweep`.

        Raises:
            ArgumentError: as for `sweep`, or the response is not periodic.
        """
        if not self._data.series.periodic:
            raise ArgumentError("the drive does not turn through; use sweep() on its range")
        # NumPy counts durations among the integers.
        whole = isinstance(count, (int, np.integer)) and not isinstance(
            count, (bool, np.timedelta64)
        )
        if not whole or count < 1:
            raise ArgumentError(f"count is {described(count)}, expected a number of positions")
        _refuse_size((int(count),))
        return self._sweep(None, int(count), speed, acceleration, loads, gravity)

    def inertia(self, position: ArrayLike) -> Array:
        """Return the inertia [kg·m² or kg] that the drive feels at positions of any shape."""
        return self._effort(ACCELERATION, position)

    def inertia_derivative(self, position: ArrayLike) -> Array:
        """Return the derivative of `inertia` with respect to the drive's position.

        At constant speed the drive exerts half of it times the square of the speed.
        """
        return read_only(2.0 * self._effort(SPEED_SQUARED, position))

    def ratio(self, joint: str, position: ArrayLike) -> Array:
        """Return a joint's velocity ratio at positions `(N,)`, solved directly.

        Raises:
            ModelError: unknown joint.
            ArgumentError: positions that are not finite or have another shape.
        """
        positions = np.atleast_1d(_numbers("position", position))
        if positions.ndim > 1:
            raise ArgumentError(f"position has shape {positions.shape}, expected (N,)")
        still = np.zeros_like(positions)
        return solved_motion(self._solver, positions, still, still).ratio(joint)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the response to one file (NumPy's `.npz`).

        Raises:
            ArgumentError: no path.
            CardanError: the file cannot be written.
        """
        from .file import write  # Not before somebody saves something.

        write(path, self._problem, self._data)

    def _sweep(
        self,
        positions: Array | None,
        count: int | None,
        speed: ArrayLike,
        acceleration: ArrayLike,
        loads: Mapping[str, ArrayLike] | None,
        gravity: ArrayLike | None,
    ) -> Sweep:
        speeds, accelerations = _numbers("speed", speed), _numbers("acceleration", acceleration)
        factors = self._factors(speeds, accelerations, loads, gravity)
        placed = (count,) if positions is None else positions.shape
        try:
            shape = np.broadcast_shapes(
                placed, *(part.shape for part in (speeds, accelerations, *factors.values()))
            )
        except ValueError as error:
            shapes = {column.label: part.shape for column, part in factors.items()}
            raise ArgumentError(
                f"shapes do not broadcast: position {placed}, speed {speeds.shape}, "
                f"acceleration {accelerations.shape}, {shapes}"
            ) from error
        _refuse_size(shape)
        problem = self._problem
        points = OperatingPoints(
            self._solver,
            self._data,
            positions,
            count,
            factors,
            shape,
            speeds,
            accelerations,
            {**problem.joint_loads, **self._efforts(loads)},
            problem.gravity if gravity is None else _numbers("gravity", gravity),
        )
        lost = self.proof.cancellation if SPEED_SQUARED in factors else 1.0
        hidden = CHECK_ROUNDING * (lost - 1.0)
        return Sweep(
            problem=problem,
            source=points,
            unique=self._data.unique,
            # Reads like a dictionary, but evaluates what is looked up.
            coupling_moment=CouplingMoments(points),
            coupling_unique=self._data.coupling_unique,
            condition=read_only(np.array([self.proof.condition * lost])),
            loop_residual=self.proof.loop_residual,
            balance_residual=self.proof.balance_residual + hidden,
            power_residual=self.proof.power_residual,
            rate_residual=self.proof.rate_residual,
            unproven=self.proof.unproven,
        )

    def _factors(
        self,
        speeds: Array,
        accelerations: Array,
        loads: Mapping[str, ArrayLike] | None,
        gravity: ArrayLike | None,
    ) -> dict[Column, Array]:
        """Return what each column is multiplied with."""
        problem = self._problem
        with np.errstate(over="ignore"):  # What overflows is refused below.
            factors = {SPEED_SQUARED: speeds * speeds, ACCELERATION: accelerations}
        for name, value in {**problem.joint_loads, **self._efforts(loads)}.items():
            factors[Column(Kind.JOINT_LOAD, name)] = value
        factors |= {Column(Kind.LINK_LOAD, name): np.ones(()) for name in problem.link_loads}
        pull = problem.gravity if gravity is None else _numbers("gravity", gravity)
        if pull.shape[-1:] != (3,):
            raise ArgumentError(f"gravity has shape {pull.shape}, expected (..., 3)")
        factors |= {column: pull[..., axis] for axis, column in enumerate(GRAVITY)}
        acting = {column: part for column, part in factors.items() if np.any(part)}
        missing = set(acting) - set(self._data.layout.columns)
        # Inertia and weight have no columns where nothing has mass.
        missing -= {SPEED_SQUARED, ACCELERATION, *GRAVITY} if not self._solver.has_mass else set()
        if missing:
            raise ArgumentError(
                f"the response has no columns for {choices(item.label for item in missing)}, only "
                f"for {choices(self.columns)}; give the scene such loads or a gravity"
            )
        acting = {
            column: acting[column] for column in self._data.layout.columns if column in acting
        }
        for column, part in acting.items():
            if not float(np.max(np.abs(part))) * self._greatest < _MOST:
                raise ArgumentError(f"{column.label} is so great that wrenches overflow")
        return acting

    def _efforts(self, loads: object) -> dict[str, Array]:
        """Return the efforts at joints that replace the scene's.

        Raises:
            ArgumentError: no mapping of joints to numbers, or a wrench on a link.
        """
        result, mechanism = {}, self._problem.mechanism
        for name, value in mapping("loads", loads).items():
            if name in self._problem.link_loads or (
                name in mechanism.links and name not in mechanism.joints
            ):
                raise ArgumentError(
                    f"loads[{name!r}]: {name!r} is a link; a response keeps the wrenches of its "
                    "scene, and replaces efforts at joints only: build one of a scene with this "
                    "wrench"
                )
            if name not in mechanism.joints:
                raise ArgumentError(
                    f"loads[{name!r}]: no joint has this name; the response has loads on: "
                    f"{choices(self._problem.joint_loads)}"
                )
            result[name] = _numbers(f"loads[{name!r}]", value)
        return result

    @cached_property
    def _greatest(self) -> float:
        return max(1.0, float(np.max(np.abs(self._data.series.values), initial=0.0)))

    def _effort(self, column: Column, position: ArrayLike) -> Array:
        positions = numbers("position", position)
        if column not in self._data.layout.columns:
            return read_only(np.zeros(positions.shape))
        row = self._data.layout.effort(column, 0)
        return read_only(
            self._data.series.at(np.array([row]), self._data.series.locate(positions))[0]
        )


def _numbers(name: str, value: object) -> Array:
    """Return an argument as an array of finite numbers, one at least."""
    array = numbers(name, value)
    if not array.size:
        raise ArgumentError(f"{name} is empty")
    return array


def _refuse_size(shape: tuple[int, ...]) -> None:
    """Refuse more operating points than a computer can hold."""
    count = math.prod(shape)
    if count > _MOST_POINTS:
        # As a decimal, since a double holds no number of any size.
        size = Decimal(8 * count) / 10**9
        raise ArgumentError(
            f"{Decimal(count):.3g} operating points take {size:.3g} GB of memory per component of "
            f"a wrench; at most {_MOST_POINTS} are evaluated at once"
        )
