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
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Array
from ..checks import numbers, whole
from ..dynamics.problem_solver import ProblemSolver
from ..errors import ArgumentError, ModelError, choices
from ..frozen import Frozen, read_only
from ..problem.samples import drive_values
from ..proof.residuals import CHECK_ROUNDING
from ..results.motion import Motion
from ..results.sweep import Sweep
from .columns import ACCELERATION, SPEED_SQUARED, Column
from .data import ResponseData
from .factors import Operation, checked_operation, column_factors
from .operating_points import CouplingMoments, OperatingPoints, solved_motion

if TYPE_CHECKING:
    from .plot import ResponsePlot

_GREATEST_COUNT = 2**30
"""Operating points of one sweep; a component of a wrench takes 8 bytes for each."""
_LENGTH_SLACK = 1e-12
"""How far beyond a range, as a part of half its length, positions are taken for its ends: the ends
are sums of the middle and half of the range, and users compute theirs with rounding as well."""
_ORIGIN_SLACK = 1e-15
"""The same as a part of the middle of the range: the rounding of that sum, some eps."""


class Response(Frozen):
    """Joint wrenches and efforts as functions of the drive's position; `Scene.response` makes it.

    Nothing in it can be changed.

    Attributes:
        proof: how well it holds.
    """

    _meant: ClassVar[Mapping[str, str]] = {
        "run solve evaluate at": "response.sweep(positions, speed=...), or response.uniform(count)",
        "wrench force forces moment torque torques motion position": "sweeps of it have these: "
        "response.sweep(positions)['joint'].force",
        "point orientation rod_force": "response.sweep(positions).point('link')",
        "to_dataframe to_xarray to_csv": "response.uniform(count).to_dataframe()",
    }

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

    @property
    def solver(self) -> ProblemSolver:
        """The solver of its scene: for what is built on responses."""
        return self._solver

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
        return self._data.series.domain.interval

    def __repr__(self) -> str:
        return (
            f"<Response of {self._problem.mechanism.name!r}: {self.sample_count} samples, "
            f"columns {', '.join(self.columns)}, error {self.error:.1e}>"
        )

    @property
    def plot(self) -> ResponsePlot:
        """Figures: `response.plot("bearing_out", speed=3.0)`, those of a sweep over a period."""
        from .plot import ResponsePlot  # Imported here: few scripts draw.

        domain = self._data.series.domain
        low = domain.origin if domain.periodic else domain.interval[0]
        return ResponsePlot(self, low, low + domain.length * (1.0 if domain.periodic else 2.0))

    def sweep(
        self,
        position: ArrayLike,
        speed: ArrayLike = 0.0,
        acceleration: ArrayLike = 0.0,
        *,
        loads: Mapping[str, ArrayLike] | None = None,
        gravity: ArrayLike | None = None,
    ) -> Sweep:
        """Return wrenches at any operating points; each is evaluated when it is first read.

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
        positions = np.atleast_1d(drive_values("position", position, self._problem)[..., 0])
        self._refuse_outside(positions)
        operation = checked_operation(self._problem, speed, acceleration, loads, gravity)
        return self._sweep(positions, None, operation)

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
        if not self._data.series.domain.periodic:
            raise ArgumentError("the drive does not turn through; use sweep() on its range")
        count = whole("count", count)
        _refuse_size((count,))
        operation = checked_operation(self._problem, speed, acceleration, loads, gravity)
        return self._sweep(None, count, operation)

    def turn(self, count: int) -> Motion:
        """Return the motion at `count` equal steps of one period from 0, the drive at rest.

        It is solved directly, once: no part of the functions, and the same at every speed.

        Raises:
            ArgumentError: the response is not periodic.
        """
        if not self._data.series.domain.periodic:
            raise ArgumentError("the drive does not turn through; there is no period")
        if count not in self._turns:
            positions = self._data.series.domain.length / count * np.arange(count)
            zeros = np.zeros(count)
            # Two threads may both solve it: either's is as good.
            self._turns[count] = solved_motion(self._solver, positions, zeros, zeros)
        return self._turns[count]

    @cached_property
    def _turns(self) -> dict[int, Motion]:
        """Numbers of steps to the motions solved so far."""
        return {}

    def inertia(self, position: ArrayLike) -> Array:
        """Return the inertia [kg·m² or kg] that the drive accelerates, at positions of any shape.

        Raises:
            ArgumentError: a position is not finite or out of range.
            ModelError: the outputs of the scene leave the drive's effort out.
        """
        return self._effort(ACCELERATION, position)

    def inertia_derivative(self, position: ArrayLike) -> Array:
        """Return the derivative of `inertia` with respect to the drive's position.

        At constant speed the drive exerts half of it times the square of the speed.

        Raises:
            ArgumentError: a position is not finite or out of range.
            ModelError: the outputs of the scene leave the drive's effort out.
        """
        return read_only(2.0 * self._effort(SPEED_SQUARED, position))

    def ratio(self, joint: str, position: ArrayLike) -> Array:
        """Return a joint's velocity ratio at positions `(N,)`, solved directly.

        Raises:
            ModelError: unknown joint.
            ArgumentError: positions that are not finite or have another shape.
        """
        positions = np.atleast_1d(drive_values("position", position, self._problem)[..., 0])
        if positions.ndim > 1:
            raise ArgumentError(f"position has shape {positions.shape}, expected (N,)")
        zeros = np.zeros_like(positions)
        return solved_motion(self._solver, positions, zeros, zeros).ratio(joint)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the response to one file (NumPy's `.npz`).

        Raises:
            ArgumentError: no path.
            CardanError: the file cannot be written.
        """
        from .file import write  # Imported here, since few scripts save anything.

        write(path, self._problem, self._data)

    def _sweep(
        self, positions: Array | None, step_count: int | None, operation: Operation
    ) -> Sweep:
        """Return a sweep at positions, or else at equal steps of a period."""
        factors = column_factors(self._solver, self._data, operation, self._greatest)
        position_shape = (step_count or 0,) if positions is None else positions.shape
        shape = _shape(position_shape, operation, factors)
        _refuse_size(shape)
        points = OperatingPoints(
            self._solver,
            self._data,
            positions,
            step_count,
            factors,
            shape,
            *operation,
        )
        cancellation = self.proof.cancellation if SPEED_SQUARED in factors else 1.0
        # The samples were proven at unit speed and acceleration, where inertial terms are larger
        # than what is left of them; imbalances below their rounding could not be seen.
        unseen = CHECK_ROUNDING * (cancellation - 1.0)
        return Sweep(
            problem=self._problem,
            source=points,
            unique=self._data.unique,
            # Reads like a dictionary, but evaluates what is looked up.
            coupling_moment=CouplingMoments(points),
            coupling_unique=self._data.coupling_unique,
            condition=read_only(np.array([self.proof.condition * cancellation])),
            proven=self.proof.with_unseen(unseen),
        )

    def _refuse_outside(self, positions: Array) -> None:
        """Refuse positions beyond the ends of a range by more than rounding."""
        low, high = self.interval
        domain = self._data.series.domain
        slack = _LENGTH_SLACK * domain.length + _ORIGIN_SLACK * abs(domain.origin)
        if (positions < low - slack).any() or (positions > high + slack).any():
            raise ArgumentError(f"the response holds for positions from {low:.9g} to {high:.9g}")

    @cached_property
    def _greatest(self) -> float:
        """The greatest value of all functions, 1 at least."""
        return max(1.0, float(np.max(np.abs(self._data.series.values), initial=0.0)))

    def _effort(self, column: Column, position: ArrayLike) -> Array:
        """Return what the drive exerts for a column, at positions of any shape."""
        positions = numbers("position", position)
        self._refuse_outside(positions)
        if not self._solver.knows_effort(self._problem.independent[0]):
            raise ModelError(
                "the inertia at the drive is not known; add the driven joint to the outputs, which "
                f"are: {choices(self._problem.outputs)}"
            )
        if column not in self._data.layout.columns:
            return read_only(np.zeros(positions.shape))
        row = self._data.layout.effort(column, 0)
        return read_only(
            self._data.series.at(np.array([row]), self._data.series.locate(positions))[0]
        )


def _shape(
    positions: tuple[int, ...], operation: Operation, factors: Mapping[Column, Array]
) -> tuple[int, ...]:
    """Return the shape of all operating points."""
    speed, acceleration = operation.speed.shape, operation.acceleration.shape
    shapes = {column.label: factor.shape for column, factor in factors.items()}
    try:
        return np.broadcast_shapes(
            positions, speed, acceleration, *(factor.shape for factor in factors.values())
        )
    except ValueError as error:
        raise ArgumentError(
            f"shapes do not broadcast: position {positions}, speed {speed}, "
            f"acceleration {acceleration}, {shapes}"
        ) from error


def _refuse_size(shape: tuple[int, ...]) -> None:
    """Refuse more operating points than a computer can hold."""
    count = math.prod(shape)
    if count > _GREATEST_COUNT:
        # As a decimal: the count may exceed the greatest double.
        size = Decimal(8 * count) / 10**9
        raise ArgumentError(
            f"{Decimal(count):.3g} operating points take {size:.3g} GB of memory per component of "
            f"a wrench; at most {_GREATEST_COUNT} are evaluated at once"
        )
