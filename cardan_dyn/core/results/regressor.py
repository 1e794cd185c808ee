"""Regressor: efforts of drives as linear functions of masses, first moments and inertias."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy.linalg

from ...kit.arrays import EPS, NOTHING, Array
from ...kit.checks import flag
from ...kit.errors import AccuracyError, ModelError
from ...kit.frozen import Record
from ..dynamics.problem_solver import ProblemSolver
from ..mechanism.carried import CarriedFrame
from ..problem.samples import drive_values, targets_of
from .jacobian import Matrices, jacobian_at, unit_motions
from .sweep import Sweep
from .unloaded import rows_of, unloaded

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

_PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
"""Components of an inertia in the order of its parameters."""
_OF_LINK = (
    "mass:{}",
    *(f"first_moment:{{}}.{axis}" for axis in "xyz"),
    *(f"inertia:{{}}.{'xyz'[row]}{'xyz'[column]}" for row, column in _PAIRS),
)


class Combination(NamedTuple):
    """A sum of parameters that efforts tell apart from all others.

    Attributes:
        parameter: the one that stands for it, with the factor 1.
        terms: those that are counted with it, to their factors [in SI units of both].
        value: of the sum, by the description.
    """

    parameter: str
    terms: Mapping[str, float]
    value: float

    def __str__(self) -> str:
        others = (f" {value:+.6g} {name}" for name, value in self.terms.items())
        return f"{self.parameter}{''.join(others)} = {self.value:.6g}"


@dataclass(frozen=True, eq=False)
class BaseParameters(Record):
    """What efforts of drives tell of masses and inertias, over the samples of a regressor.

    `regressor[..., base.columns] @ base.values` are the efforts.

    Attributes:
        combinations: `b` sums of parameters that are told apart, each numbered by its place.
        columns: `(b,)` of the regressor, of the parameters that stand for them.
        values: `(b,)` of the sums, by the description.
        silent: parameters that no effort depends on.
        condition: condition number of these columns over the samples, lengths in units of the
            mechanism: by how much errors of efforts may be magnified in the values.
        gap: by how much the last of them stands out of what is left, which is rounding: where it
            is small, samples hardly tell how many there are.
    """

    combinations: tuple[Combination, ...]
    columns: Array
    values: Array
    silent: tuple[str, ...]
    condition: float
    gap: float

    def __len__(self) -> int:
        return len(self.combinations)

    def __str__(self) -> str:
        return "\n".join(f"{number}: {item}" for number, item in enumerate(self.combinations))


@dataclass(frozen=True, eq=False, repr=False)
class Regressor(Matrices):
    """How efforts of drives depend on masses, first moments and inertias: linearly.

    `regressor @ values + rotors` are the efforts that move the bodies and carry their weight;
    loads and elements are left out. It stands for an array. Nothing in it can be changed.

    Attributes:
        value: `(..., n, 10 k)` for k links, ten columns each.
        parameters: `(10 k)` names of the columns: `mass:LINK`, `first_moment:LINK.x`,
            `inertia:LINK.xx` (xy, xz, yy, yz, zz), of the link about its origin, in its axes.
        values: `(10 k)` of the description [kg, kg·m, kg·m²]; products of inertia with the signs
            of the inertia matrix.
        rotors: `(..., n)` efforts that accelerate rotors (`armature`) [N·m or N].
        coordinates: names of the rows.
    """

    value: Array
    parameters: tuple[str, ...]
    values: Array
    rotors: Array
    coordinates: tuple[str, ...]
    _units: tuple[Array, Array]
    """Of rows and of columns, in which all of them are moments per mass."""
    _rounding: tuple[float, float]
    """Part of the greatest column, and of a column in these units, that is rounding."""

    def __repr__(self) -> str:
        samples = " × ".join(map(str, self.shape[:-2]))
        return (
            f"<Regressor of {', '.join(self.coordinates)}: {samples} samples, "
            f"{len(self.parameters)} parameters>"
        )

    def base_parameters(self) -> BaseParameters:
        """Return which sums of parameters the efforts at the samples tell apart.

        By a factorisation that takes the columns in turn which differ most from those before.
        Samples that move too little tell less than the mechanism would.

        Raises:
            ModelError: nothing that the drives move has mass, or all samples rest without gravity.

        Source: Gautier (1991), Numerical calculation of the base inertial parameters of robots.
        """
        rows, units = self._units
        scaled = (self.value * rows[:, None] * units).reshape(-1, len(units))
        triangle, order = scipy.linalg.qr(scaled, mode="r", pivoting=True)
        sizes = np.abs(np.diag(triangle))
        part, floor = self._rounding
        least = max(part * max(scaled.shape) * float(np.max(sizes, initial=0.0)), floor)
        rank = int(np.count_nonzero(sizes > least))
        if not rank:
            raise ModelError(
                "no effort depends on any mass: give speeds, accelerations or the scene gravity"
            )
        chosen, others = order[:rank], order[rank:]
        own = triangle[:rank, :rank]
        shares = scipy.linalg.solve_triangular(own, triangle[:rank, rank:])
        # Columns in units of the mechanism, so that rounding is small beside 1.
        shares[np.abs(shares) <= np.linalg.cond(own) * least / sizes[0]] = 0.0
        factors = shares * units[chosen][:, None] / units[others]
        names = self.parameters
        combinations = tuple(
            Combination(
                names[column],
                {names[others[k]]: float(row[k]) for k in np.flatnonzero(row)},
                float(self.values[column] + row @ self.values[others]),
            )
            for column, row in zip(chosen.tolist(), factors, strict=True)
        )
        left = float(np.max(sizes[rank:], initial=0.0))
        return BaseParameters(
            combinations=combinations,
            columns=chosen,
            values=np.array([item.value for item in combinations]),
            silent=tuple(
                names[k] for k, row in zip(others, shares.T, strict=True) if not row.any()
            ),
            condition=float(np.linalg.cond(own)),
            gap=float(sizes[rank - 1]) / left if left else np.inf,
        )


def regressor_of(
    solver: ProblemSolver,
    position: object,
    speed: object,
    acceleration: object,
    held: Mapping[str, ArrayLike] | None,
    along_path: object,
) -> Regressor:
    """Return the regressor of a scene; see `Scene.regressor`."""
    bare = solver.complete.without_elements
    problem, mechanism = bare.problem, bare.problem.mechanism
    targets = targets_of(problem, position, held)
    speeds = drive_values("speed", speed, problem)
    accelerations = drive_values("acceleration", acceleration, problem)
    sweep = unloaded(
        bare,
        targets,
        speeds,
        accelerations,
        problem.gravity,
        along_path=flag("along_path", along_path),
    )
    moves = unit_motions(sweep)
    description = mechanism.description
    links = [
        item
        for item in description.links
        if mechanism.links[item.name][0] and item.name not in description.origins
    ]
    parts: list[Array] = []
    fastest = 0.0
    values: list[float] = []
    names: list[str] = []
    for link in links:
        own, falling = _of_link(sweep, moves, link.name)
        parts.append(own)
        fastest = max(fastest, falling)
        inertia = link.inertia + link.mass * (
            link.centre @ link.centre * np.eye(3) - np.outer(link.centre, link.centre)
        )
        values += [link.mass, *(link.mass * link.centre), *(inertia[pair] for pair in _PAIRS)]
        names += [form.format(link.name) for form in _OF_LINK]
    regressor, rotors = np.concatenate(parts, axis=-1), _rotors(sweep, moves[1])
    length, drivable = mechanism.characteristic_length, mechanism.drivable
    columns = np.tile(np.repeat([1.0, length, length**2], [1, 3, 6]), len(links))
    slides = np.array([drivable[name].slides for name in problem.independent])
    rows = np.where(slides, length, 1.0)
    _prove(sweep, regressor, np.array(values), rotors, rows)
    part = EPS * float(np.max(sweep.condition))
    return Regressor(
        value=regressor,
        parameters=tuple(names),
        values=np.array(values),
        rotors=rotors,
        coordinates=problem.independent,
        _units=(rows, columns),
        _rounding=(part, part * length * fastest),
    )


def _of_link(sweep: Sweep, moves: tuple[Array, Array], name: str) -> tuple[Array, float]:
    """Return the ten columns `(..., n, 10)` of a link, and its greatest acceleration [m/s²].

    Args:
        sweep: of the motion.
        moves: its `unit_motions`.
        name: of the link.
    """
    carrier = CarriedFrame(sweep.mechanism, name, np.zeros(3))
    x, a = sweep.joint_coordinates, sweep.joint_accelerations
    rates = carrier.rates(x, sweep.joint_velocities, a)
    rotation, _ = carrier.placed(x)
    own = rotation.transpose(0, 2, 1)
    falling = rates.acceleration.T - sweep.gravity
    along, spin, turning = (
        (own @ vector[..., None])[..., 0] for vector in (falling, rates.spin.T, rates.spin_rate.T)
    )
    spinning, into = _crossing(spin), _of_inertia(spin)
    force = np.zeros((len(x), 3, 10))
    force[:, :, 0] = along
    force[:, :, 1:4] = _crossing(turning) + spinning @ spinning
    moment = np.zeros_like(force)
    moment[:, :, 1:4] = -_crossing(along)
    moment[:, :, 4:] = _of_inertia(turning) + spinning @ into
    jacobian = jacobian_at(sweep, carrier, moves).reshape(len(x), 6, -1)
    columns = (own @ jacobian[:, :3]).transpose(0, 2, 1) @ force
    columns += (own @ jacobian[:, 3:]).transpose(0, 2, 1) @ moment
    return columns.reshape(*sweep.shape, -1, 10), float(np.max(np.abs(falling)))


def _crossing(vectors: Array) -> Array:
    """Return matrices `(N, 3, 3)` that make cross products with vectors `(N, 3)` in front."""
    return np.cross(vectors[:, None], np.eye(3)).transpose(0, 2, 1)


def _of_inertia(vectors: Array) -> Array:
    """Return matrices `(N, 3, 6)` that take the six numbers of an inertia to its products."""
    found = np.zeros((len(vectors), 3, len(_PAIRS)))
    for index, (row, column) in enumerate(_PAIRS):
        found[:, row, index] = vectors[:, column]
        found[:, column, index] = vectors[:, row]
    return found


def _rotors(sweep: Sweep, ratios: Array) -> Array:
    """Return the efforts `(..., n)` that accelerate rotors, by velocity ratios `(n N, nv)`."""
    carried = sweep.joint_accelerations * sweep.mechanism.model.armature
    efforts = (ratios.reshape(-1, *carried.shape) * carried).sum(axis=-1)
    return efforts.T.reshape(*sweep.shape, -1)


def _prove(sweep: Sweep, regressor: Array, values: Array, rotors: Array, units: Array) -> None:
    """Refuse a regressor that does not give the efforts of inverse dynamics.

    Args:
        sweep: that has them.
        regressor: `(..., n, p)`.
        values: `(p,)` of its parameters.
        rotors: `(..., n)` what is left.
        units: `(n,)` which make moments of efforts.

    Raises:
        AccuracyError: it does not.
    """
    found = (regressor @ values + rotors).reshape(-1, len(units))
    length = sweep.mechanism.characteristic_length
    # Efforts are rounded like the wrenches that they are parts of.
    greatest = max(
        float(np.max(np.abs(wrench), initial=0.0)) * unit
        for joint in sweep.values()
        for wrench, unit in ((joint.force, length), (joint.moment, 1.0))
    )
    apart = float(np.max(np.abs(found - rows_of(sweep, sweep.drive_effort)) * units))
    if not apart <= NOTHING * greatest:
        raise AccuracyError(
            f"{sweep.mechanism.name}: the regressor misses the efforts of inverse dynamics by "
            f"{apart:.1e} N·m, where wrenches reach {greatest:.1e}: keep away from singular "
            "configurations",
            residual=apart / greatest if greatest else np.inf,
            tolerance=NOTHING,
        )
