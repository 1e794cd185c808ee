"""Jacobian: how points and links move per unit speed of the coordinates of a scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from ...kit.arrays import BLOCK_SIZE, Array, blocks, cross
from ...kit.checks import flag, vector
from ...kit.errors import ArgumentError, ModelError
from ...kit.frozen import Hinting, Record, frozen
from ..dynamics.problem_solver import ProblemSolver
from ..kinematics.loops.idle_rods import idle_rods
from ..mechanism.carried import CarriedFrame
from ..problem.samples import Targets, drive_values, targets_of
from .sweep import Sweep
from .unloaded import rows_of, unloaded

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


class Matrices(Hinting, Record, NDArrayOperatorsMixin):
    """Matrices of samples, which NumPy's functions and operators take as an array.

    Attributes:
        value: `(..., r, c)` a matrix per sample.
    """

    value: Array

    _meant: ClassVar[Mapping[str, str]] = {
        "t transpose mt reshape dtype size copy astype dot sum": "it stands for an array: "
        "np.asarray(...) of it, or .value, has that",
    }

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.array(self.value, dtype, copy=copy)

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        arrays = (item.value if isinstance(item, Matrices) else item for item in inputs)
        return getattr(ufunc, method)(*arrays, **options)

    def __getitem__(self, key: Any) -> Any:
        return self.value[key]

    def __len__(self) -> int:
        return len(self.value)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the array."""
        return self.value.shape

    @property
    def ndim(self) -> int:
        """Number of its axes."""
        return self.value.ndim


@dataclass(frozen=True, eq=False, repr=False)
class Jacobian(Matrices):
    """Velocity of a point and angular velocity of its link per unit speed of each coordinate.

    `jacobian @ speed` is the twist, `jacobian[..., :3, :]` its part of the point; the transpose
    takes a force and a moment at the point to efforts along the coordinates. It stands for an
    array. Nothing in it can be changed.

    Attributes:
        value: `(..., 6, n)` in world axes, the point first [m or 1 per unit of the coordinate].
        link: that moves.
        point: `(3,)` of it, in its axes [m].
        coordinates: names of the columns.
    """

    value: Array
    link: str
    point: Array
    coordinates: tuple[str, ...]
    _rate: Array | None

    def __repr__(self) -> str:
        samples = " × ".join(map(str, self.shape[:-2]))
        return f"<Jacobian of {self.link!r} by {', '.join(self.coordinates)}: {samples} samples>"

    @property
    def rate(self) -> Array:
        """Its derivative by time `(..., 6, n)`, at the speeds for which it was made.

        Raises:
            ArgumentError: it was made without any.
        """
        if self._rate is None:
            raise ArgumentError("the rate depends on speeds: scene.jacobian(..., speed=...)")
        return self._rate


def jacobian_of(
    solver: ProblemSolver,
    link: object,
    point: ArrayLike,
    position: object,
    speed: object,
    held: Mapping[str, ArrayLike] | None,
    along_path: object,
) -> Jacobian:
    """Return the Jacobian of a point; see `Scene.jacobian`."""
    bare = solver.complete.without_elements
    problem = bare.problem
    still = np.zeros(len(problem.independent))
    speeds = still if speed is None else drive_values("speed", speed, problem)
    xyz = vector("point", point, 3)
    carrier = CarriedFrame(problem.mechanism, link, xyz)
    followed = flag("along_path", along_path)
    targets = targets_of(problem, position, held)
    sweep = unloaded(bare, targets, speeds, still, along_path=followed)
    value = jacobian_at(sweep, carrier, unit_motions(sweep))
    rate = None if speed is None else rate_at(bare, sweep, carrier, value)
    return Jacobian(value, carrier.name, xyz, problem.independent, rate)


def unit_motions(sweep: Sweep) -> tuple[Array, Array]:
    """Return coordinates and velocities `(n N, …)` of a sweep, its n drives moving in turn."""
    motion = sweep.motion
    count = len(motion.drives)
    ratios = np.concatenate([motion._all_ratios(index) for index in range(count)])
    return np.tile(motion.x, (count, 1)), ratios


def jacobian_at(sweep: Sweep, carrier: CarriedFrame, moves: tuple[Array, Array]) -> Array:
    """Return the Jacobian `(..., 6, n)` of a carried point over a sweep, by its `unit_motions`."""
    rates = carrier.rates(*moves)
    twists = np.concatenate([rates.velocity, rates.spin])
    columns = twists.reshape(6, len(sweep.coordinates), *sweep.shape)
    return np.ascontiguousarray(np.moveaxis(columns, (0, 1), (-2, -1)))


def rate_at(bare: ProblemSolver, sweep: Sweep, carrier: CarriedFrame, value: Array) -> Array:
    """Return the derivative by time `(..., 6, n)` of a Jacobian over a sweep.

    Without accelerations of the coordinates, the acceleration of the point is a quadratic form of
    the speeds. With column k of the Jacobian J, ∂J_k/∂q_j = ∂J_j/∂q_k for the point; for angular
    velocities, whose order counts, the difference of both is ω_j × ω_k. So the rate of a column is
    the bilinear form of the speeds and the column's unit, and for the link ½ ω × ω_k besides.

    Args:
        bare: the solver of the scene without elements.
        sweep: whose positions and speeds are taken.
        carrier: of the point.
        value: the Jacobian.

    Raises:
        ModelError: the link is a rod that spins idly.
    """
    problem, shape = sweep.problem, sweep.shape
    mechanism, names, own = problem.mechanism, problem.independent, set(carrier.columns.tolist())
    for rod in idle_rods(mechanism, set(problem.passive_columns.tolist())):
        if own & set(rod.columns) and not own.issuperset(rod.columns):
            raise ModelError(
                f"{carrier.name!r} turns about its line by a rule, not as its speed says: its "
                "Jacobian has no rate; drive or hold its spin",
                name=carrier.name,
            )
    length, drivable = mechanism.characteristic_length, mechanism.drivable
    units = np.array([length if drivable[name].slides else 1.0 for name in names])
    speeds = rows_of(sweep, sweep.speed)
    # As great as the speeds, so that sum and difference have the same digits.
    sizes = np.abs(speeds / units).max(axis=1)
    steps = np.where(sizes > 0.0, sizes, 1.0)[:, None] * units
    ways = np.eye(len(names))[:, None] * steps
    both = np.stack([speeds + ways, speeds - ways])
    positions = rows_of(sweep, sweep.position).reshape(*shape, -1)
    targets = Targets(shape, positions, frozen(sweep._held))
    columns = np.empty((6, len(names), len(speeds)))
    for own_block in blocks(len(speeds), max(1, BLOCK_SIZE // len(names))):
        samples, moves = np.arange(len(speeds))[own_block], both[:, :, own_block]
        known = sweep.motion.x[own_block], sweep.motion.turns[own_block]
        still = np.zeros(len(names))
        motion = unloaded(bare, targets.of_samples(samples), moves, still, near=known).motion
        rates = (values.reshape(len(motion.x), -1) for values in (motion.v, motion.a))
        found = carrier.rates(motion.x, *rates)
        every = np.concatenate([found.acceleration, found.spin_rate]).reshape(6, *moves.shape[:3])
        columns[:, :, own_block] = every[:, 0] - every[:, 1]
    columns /= 4.0 * steps.T
    rate = np.moveaxis(columns, (0, 1), (-2, -1)).reshape(value.shape)
    spins = np.moveaxis(value[..., 3:, :], -2, 0)
    turning = (spins * speeds.reshape(*shape, -1)).sum(axis=-1, keepdims=True)
    turning = np.broadcast_to(turning, spins.shape)
    flat = cross(turning.reshape(3, -1), spins.reshape(3, -1)).reshape(spins.shape)
    rate[..., 3:, :] += 0.5 * np.moveaxis(flat, 0, -2)
    return np.ascontiguousarray(rate)
