"""Response: a scene with one drive as functions of the drive's position.

Every wrench is A(φ) speed² + B(φ) acceleration + Σ C(φ) load + G(φ) · gravity. The columns are
periodic, or analytic on a range, so that a few hundred solved positions give them everywhere to
rounding, for any number of operating points.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ...kit.arrays import EPS, ROUNDED, Array
from ...kit.checks import numbers, whole
from ...kit.errors import ArgumentError, ModelError, choices
from ...kit.frozen import Frozen, FrozenDict, frozen, read_only
from ..dynamics.problem_solver import ProblemSolver
from ..problem.samples import Targets, common_shape, drive_values
from ..proof.residuals import CHECK_ROUNDING, Proven
from ..results.collect import motion_at
from ..results.motion import Motion
from ..results.sweep import Sweep
from .columns import ACCELERATION, SPEED_SQUARED, Column
from .data import Proof, ResponseData
from .operating_points import (
    CouplingMoments,
    OfDesign,
    OperatingPoints,
    checked_acting,
    column_factors,
)

if TYPE_CHECKING:
    from .plot import ResponsePlot

_GREATEST_COUNT = 2**30
"""Operating points of one sweep; a component of a wrench takes 8 bytes for each."""


class Response(Frozen):
    """Joint wrenches and efforts as functions of the drive's position; `Scene.response` makes it.

    `Scene.responses` makes one of many designs, in a `shape` of their own: `response[index]` is
    that of a design, with as many indices as the shape has dimensions. What is said of one design
    alone is asked of that. Nothing in it can be changed.

    Attributes:
        shape: of the designs; () of the scene alone.
        held: held joints and their positions [rad or m]; arrays where designs differ.
    """

    _meant: ClassVar[Mapping[str, str]] = {
        "run solve evaluate at": "response.sweep(positions, speed=...), or response.uniform(count)",
        "wrench force forces moment torque torques motion position": "sweeps of it have these: "
        "response.sweep(positions)['joint'].force",
        "point orientation rod_force": "response.sweep(positions).point('link')",
        "to_dataframe to_xarray to_csv": "response.uniform(count).to_dataframe()",
    }

    def __init__(
        self,
        solver: ProblemSolver,
        shape: tuple[int, ...],
        varied: FrozenDict[str, Array],
        data: tuple[ResponseData, ...],
    ) -> None:
        """Make the response.

        Args:
            solver: of the scene, for positions of the varied joints; motions are solved by it.
            shape: see the attribute.
            varied: held joints that are not where the scene holds them, and their positions.
            data: the functions of each design; of the only one where all are the same.
        """
        self._solver, self._problem, self.shape = solver, solver.problem, shape
        self._varied, self._data = varied, data
        self.held: Mapping[str, float | Array] = frozen({**self._problem.held, **varied})
        self._freeze()

    @property
    def solver(self) -> ProblemSolver:
        """The solver of its scene: for what is built on responses."""
        return self._solver

    def __reduce__(self) -> tuple[object, ...]:
        return Response, (self._solver, self.shape, self._varied, self._data)

    def __len__(self) -> int:
        """Return the number of designs, along the first of several dimensions."""
        if not self.shape:
            raise TypeError("a response of one design has no length")
        return self.shape[0]

    def __bool__(self) -> bool:
        return True

    def __getitem__(self, index: int | tuple[int, ...]) -> Response:
        """Return the response of a design.

        Raises:
            ArgumentError: no whole numbers, or not one for every dimension.
            IndexError: there is no such design.
        """
        place = index if isinstance(index, tuple) else (index,)
        if len(place) != len(self.shape) or not all(
            isinstance(k, (int, np.integer)) for k in place
        ):
            raise ArgumentError(f"a design of shape {self.shape} has {len(self.shape)} indices")
        return self._designs[int(np.arange(math.prod(self.shape)).reshape(self.shape)[place])]

    def __iter__(self) -> Iterator[Response]:
        """Iterate over the responses of all designs, in C order."""
        return iter(self._designs)

    @cached_property
    def _designs(self) -> list[Response]:
        if not self._varied:
            alone = Response(self._solver, (), self._varied, self._data)
            return [alone] * math.prod(self.shape)
        positions = np.stack(np.broadcast_arrays(*self._varied.values()), axis=-1)
        rows = np.broadcast_to(positions, (*self.shape, len(self._varied)))
        return [
            Response(
                self._solver.at_design(dict(zip(self._varied, row, strict=True))),
                (),
                frozen({}),
                (data,),
            )
            for row, data in zip(
                rows.reshape(len(self._data), -1).tolist(), self._data, strict=True
            )
        ]

    @property
    def _alone(self) -> ResponseData:
        """The functions of the only design."""
        if self.shape:
            raise ArgumentError(
                f"this is said of one design: take one of {self.shape}, as in response[0].…"
            )
        return self._data[0]

    @property
    def proof(self) -> Proof:
        """How well it holds, of one design."""
        return self._alone.proof

    @property
    def columns(self) -> tuple[str, ...]:
        """What wrenches are proportional to: `speed²`, `acceleration`, loads, `gravity x` …."""
        return tuple(column.label for column in self._data[0].layout.columns)

    @property
    def sample_count(self) -> Any:
        """Number of solved positions; an array of those of all designs."""
        return self._each([data.series.values.shape[1] for data in self._data])

    @property
    def error(self) -> Any:
        """Measured error, see `Proof`; an array of those of all designs."""
        return self._each([data.proof.error for data in self._data])

    def _each(self, values: list[Any]) -> Any:
        """Return a value, or an array with one for each design."""
        if not self.shape:
            return values[0]
        one = np.array(values * (math.prod(self.shape) // len(values)))
        return read_only(one.reshape(self.shape))

    @property
    def interval(self) -> tuple[float, float]:
        """Drive positions between which it holds [rad or m], ±inf if it is periodic."""
        return self._data[0].series.domain.interval

    def __repr__(self) -> str:
        told = f"{self.sample_count} samples, columns {', '.join(self.columns)}"
        if self.shape:
            size = " × ".join(map(str, self.shape))
            told = f"{size} designs, {int(np.sum(self.sample_count))} samples"
        name, error = self._problem.mechanism.name, np.max(self.error)
        return f"<Response of {name!r}: {told}, error {error:.1e}>"

    @property
    def plot(self) -> ResponsePlot:
        """Figures: `response.plot("bearing_out", speed=3.0)`, those of a sweep over a period.

        Of designs, `response.plot("bearing_out.bending", speed=3.0)` draws a line each.
        """
        from .plot import ResponsePlot  # Imported here: few scripts draw.

        domain = self._data[0].series.domain
        low = domain.origin if domain.periodic else domain.interval[0]
        return ResponsePlot(self, low, low + domain.length * (1.0 if domain.periodic else 2.0))

    def sweep(
        self,
        position: ArrayLike,
        speed: ArrayLike = 0.0,
        acceleration: ArrayLike = 0.0,
        *,
        loads: Mapping[str, ArrayLike] | None = None,
        gravity: ArrayLike | str | None = None,
    ) -> Sweep:
        """Return wrenches at any operating points; each is evaluated when it is first read.

        All arguments broadcast, with the shape of the designs as well.

        Args:
            position: drive positions [rad or m] of any shape.
            speed: drive speeds [rad/s or m/s].
            acceleration: drive accelerations [rad/s² or m/s²].
            loads: efforts at joints instead of the scene's, by name [N·m or N]. Wrenches on links
                stay the scene's.
            gravity: `(..., 3)` [m/s²] or `"description"` instead of the scene's.

        Raises:
            ArgumentError: not finite, shapes that do not match, a load that the response was not
                built for, or a position out of range.
        """
        positions = drive_values("position", position, self._problem)
        self._refuse_outside(positions)
        return self._sweep(positions, None, speed, acceleration, loads, gravity)

    def uniform(
        self,
        count: int,
        speed: ArrayLike = 0.0,
        acceleration: ArrayLike = 0.0,
        *,
        loads: Mapping[str, ArrayLike] | None = None,
        gravity: ArrayLike | str | None = None,
    ) -> Sweep:
        """Return wrenches at `count` equal steps of one period, by FFT.

        The first position is the scene's start, 0 unless it starts elsewhere. Other arguments as
        for `sweep`.

        Raises:
            ArgumentError: as for `sweep`, or the response is not periodic.
        """
        if not self._alone.series.domain.periodic:
            raise ArgumentError("the drive does not turn through; use sweep() on its range")
        count = whole("count", count)
        return self._sweep(None, count, speed, acceleration, loads, gravity)

    def _sweep(self, positions: Array | None, step_count: int | None, *given: object) -> Sweep:
        """Return a sweep at positions `(..., 1)`, or else at equal steps of a period."""
        acting = checked_acting(self._problem, *given)
        of_positions = (step_count or 0,) if positions is None else positions.shape[:-1]
        shapes = {"position": of_positions, **acting.shapes, "designs": self.shape}
        shape = common_shape(shapes) or (1,)
        count = math.prod(shape)
        if count > _GREATEST_COUNT:
            # As a decimal: the count may exceed the greatest double.
            size = Decimal(8 * count) / 10**9
            raise ArgumentError(
                f"{Decimal(count):.3g} operating points take {size:.3g} GB of memory per component "
                f"of a wrench; at most {_GREATEST_COUNT} are evaluated at once"
            )
        columns = self._data[0].layout.columns
        factors = column_factors(self._solver, columns, acting, self._greatest)
        at = None if positions is None else np.atleast_1d(positions[..., 0])
        parts = [OfDesign(self._data[0], ..., at, step_count, factors)]
        if self._varied:
            parts = []
            for data, where in zip(self._data, _places(self.shape, shape), strict=True):
                own = [(column, _at(factor, shape, where)) for column, factor in factors]
                parts.append(OfDesign(data, where, _at(at, shape, where), None, own))
        points = OperatingPoints(self._solver, shape, parts, acting, self._varied, positions)
        moves = any(column == SPEED_SQUARED for column, _ in factors)
        return Sweep(
            problem=self._problem,
            held=self._varied,
            acting=acting,
            source=points,
            unique=self._unique,
            # Reads like a dictionary, but evaluates what is looked up.
            coupling_moment=CouplingMoments(points),
            coupling_unique=self._coupling_unique,
            condition=partial(_condition, self._data, moves),
            proven=partial(_proven, self._data, moves),
        )

    @cached_property
    def _unique(self) -> Array:
        return np.asarray(np.logical_and.reduce([data.unique for data in self._data]))

    @cached_property
    def _coupling_unique(self) -> Mapping[str, bool]:
        each = [data.coupling_unique for data in self._data]
        return frozen({name: all(of[name] for of in each) for name in each[0]})

    def turn(self, count: int) -> Motion:
        """Return the motion at `count` equal steps of one period from 0, the drive at rest.

        It is solved directly, once: no part of the functions, and the same at every speed.

        Raises:
            ArgumentError: the response is not periodic.
        """
        domain = self._alone.series.domain
        if not domain.periodic:
            raise ArgumentError("the drive does not turn through; there is no period")
        if count not in self._turns:
            # Two threads may both solve it: either's is as good.
            at = domain._replace(origin=0.0).nodes(count)
            self._turns[count] = motion_at(self._solver, Targets.of_positions(at[:, None]))
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
        self._alone  # noqa: B018 (of designs there are several)
        positions = np.atleast_1d(drive_values("position", position, self._problem)[..., 0])
        if positions.ndim > 1:
            raise ArgumentError(f"position has shape {positions.shape}, expected (N,)")
        return motion_at(self._solver, Targets.of_positions(positions[:, None])).ratio(joint)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the response to one file (NumPy's `.npz`).

        Raises:
            ArgumentError: no path.
            CardanError: the file cannot be written.
        """
        from .file import write  # Imported here, since few scripts save anything.

        write(path, self._problem, self._alone)

    def _refuse_outside(self, positions: Array) -> None:
        """Refuse positions beyond the ends of a range by more than rounding."""
        low, high = self.interval
        domain = self._data[0].series.domain
        # Ends are sums of the middle and half of the range, and users compute theirs with rounding.
        slack = ROUNDED * domain.length + 4.0 * EPS * abs(domain.origin)
        if (positions < low - slack).any() or (positions > high + slack).any():
            raise ArgumentError(f"the response holds for positions from {low:.9g} to {high:.9g}")

    @cached_property
    def _greatest(self) -> float:
        """The greatest value of all functions, 1 at least."""
        return max(1.0, *(np.abs(data.series.values).max(initial=0.0) for data in self._data))

    def _effort(self, column: Column, position: ArrayLike) -> Array:
        """Return what the drive exerts for a column, at positions of any shape."""
        data, positions = self._alone, numbers("position", position)
        self._refuse_outside(positions)
        if not self._solver.knows_drive_efforts:
            raise ModelError(
                "the inertia at the drive is not known; add the driven joint to the outputs, which "
                f"are: {choices(self._problem.outputs)}"
            )
        if column not in data.layout.columns:
            return read_only(np.zeros(positions.shape))
        row = np.array([data.layout.row(column, data.layout.wrenches)])
        return read_only(data.series.at(row, data.series.locate(positions))[0])


def _condition(every: Sequence[ResponseData], moves: bool) -> Array:
    """Return the greatest condition number `(1,)`, see `Sweep`, where speeds act or not."""
    proofs = [data.proof for data in every]
    return np.array([max(of.condition * (of.cancellation if moves else 1.0) for of in proofs)])


def _proven(every: Sequence[ResponseData], moves: bool) -> Proven:
    """Return the worst of all designs, where speeds act or not."""
    # The samples were proven at unit speed and acceleration, where inertial terms are larger
    # than what is left of them; imbalances below their rounding could not be seen.
    unseen = CHECK_ROUNDING * moves
    proofs = [data.proof for data in every]
    return Proven.worst([of.with_unseen(unseen * (of.cancellation - 1.0)) for of in proofs])


def _places(designs: tuple[int, ...], shape: tuple[int, ...]) -> list[tuple[Any, ...]]:
    """Return what to index arrays of a shape with to have the part of each design, in C order."""
    padded = (1,) * (len(shape) - len(designs)) + designs
    return [
        tuple(k if size > 1 else slice(None) for k, size in zip(place, padded, strict=True))
        for place in np.ndindex(*padded)
    ]


def _at(values: Any, shape: tuple[int, ...], where: tuple[Any, ...]) -> Array:
    """Return a part of values that broadcast with a shape, as they are where they have none."""
    return np.broadcast_to(values, shape)[where] if np.ndim(values) else values
