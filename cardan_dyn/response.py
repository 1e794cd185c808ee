"""Response: a scene with one drive as functions of the drive's position.

Every wrench is A(φ) speed² + B(φ) acceleration + Σ C(φ) load + G(φ) · gravity. The columns are
periodic, or analytic on a range, so that a few hundred solved positions give them everywhere to
rounding, for any number of operating points.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from .arguments import numbers
from .coordinates import Array
from .errors import ArgumentError, CardanError, choices
from .operating_points import OperatingPoints
from .residuals import CHECK_ROUNDING
from .series import Series
from .sweep import Sweep

if TYPE_CHECKING:
    from .scene import Scene

GRAVITY = ("gravity x", "gravity y", "gravity z")
_MOST = 1e300


@dataclass(frozen=True)
class Proof:
    """How well a response holds at its own samples.

    Attributes:
        tolerance: what was asked for.
        error: greatest deviation from directly solved positions between the samples, relative to
            the greatest wrench of the joint (or a tenth of the greatest of all joints); at least
            the rounding of the solved positions, eps times `condition`.
        condition: greatest condition number of the solved positions, see `Sweep`.
        cancellation: by how much inertial terms exceed the greatest wrench of the column `speed²`.
        loop_residual, balance_residual, power_residual: worst of the first samples and of the
            positions between them, see `Sweep`.
    """

    tolerance: float
    error: float
    condition: float
    cancellation: float
    loop_residual: float
    balance_residual: float
    power_residual: float


@dataclass(frozen=True, eq=False)
class Response:
    """Joint wrenches and efforts as functions of the drive's position; `Scene.response` makes it.

    Attributes:
        scene: what it is the response of.
        columns: what wrenches are proportional to: `speed²`, `acceleration`, loads by name,
            `gravity x`, `gravity y`, `gravity z`.
        series: the functions, `(columns, outputs, 6)` and `(columns, efforts)` as one list.
        zero: `(C,)` which of them vanish.
        constant: `(C,)` which of the others do not change.
        unique: `(k, 6)` see `JointWrench.unique`.
        proof: how well it holds.
    """

    scene: Scene
    columns: tuple[str, ...]
    series: Series
    zero: Array
    constant: Array
    unique: Array
    proof: Proof

    @property
    def samples(self) -> int:
        """Number of solved positions."""
        return int(self.series.values.shape[1])

    @property
    def error(self) -> float:
        """Measured error, see `Proof`."""
        return self.proof.error

    @property
    def range(self) -> tuple[float, float]:
        """Drive positions between which it holds [rad or m], ±inf if it is periodic."""
        if self.series.periodic:
            return -np.inf, np.inf
        return self.series.origin - self.series.length, self.series.origin + self.series.length

    def __repr__(self) -> str:
        return (
            f"<Response of {self.scene.mechanism.name!r}: {self.samples} samples, "
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
            loads: efforts at joints instead of the scene's, by name [N·m or N].
            gravity: `(..., 3)` [m/s²] instead of the scene's.

        Raises:
            ArgumentError: not finite, shapes that do not match, or a position out of range.
        """
        positions = np.atleast_1d(numbers("position", position))
        low, high = self.range
        slack = 1e-12 * self.series.length
        if np.any(positions < low - slack) or np.any(positions > high + slack):
            raise ArgumentError(f"the response holds for positions from {low:.9g} to {high:.9g}")
        return self._sweep(positions, None, speed, acceleration, loads, gravity)

    def turn(
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
        if not self.series.periodic:
            raise ArgumentError("the drive does not turn through; use sweep() on its range")
        if not isinstance(count, (int, np.integer)) or count < 1:
            raise ArgumentError(f"count is {count!r}, expected a number of positions")
        return self._sweep(None, int(count), speed, acceleration, loads, gravity)

    def inertia(self, position: ArrayLike) -> Array:
        """Return the inertia [kg·m² or kg] that the drive feels at positions of any shape."""
        return self._effort("acceleration", position)

    def inertia_slope(self, position: ArrayLike) -> Array:
        """Return the derivative of `inertia` with respect to the drive's position.

        At constant speed the drive exerts half of it times the square of the speed.
        """
        return 2.0 * self._effort("speed²", position)

    def ratio(self, joint: str, position: ArrayLike) -> Array:
        """Return a joint's transmission ratio at positions `(N,)`, solved directly."""
        return self.scene.sweep(position).motion.ratio(joint)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the response to one file (`.npz`)."""
        import json  # Not before somebody saves something.

        header = {"columns": self.columns, "proof": vars(self.proof), **_identity(self.scene)}
        with open(path, "wb") as file:  # noqa: PTH123
            np.savez_compressed(
                file,
                header=np.array(json.dumps(header)),
                values=self.series.values,
                place=np.array([self.series.origin, self.series.length]),
                periodic=np.array(self.series.periodic),
                zero=self.zero,
                constant=self.constant,
                unique=self.unique,
            )

    @staticmethod
    def load(path: str | os.PathLike[str], scene: Scene) -> Response:
        """Read a response that `save` wrote.

        Args:
            path: the file.
            scene: the scene that it was made of, made again.

        Raises:
            CardanError: the file cannot be read, or is the response of another scene.
        """
        import json

        try:
            with np.load(path, allow_pickle=False) as file:
                header = json.loads(str(file["header"]))
                content = {name: file[name] for name in file.files if name != "header"}
            proof = Proof(**header.pop("proof"))
            columns = tuple(header.pop("columns"))
            origin, length = (float(value) for value in content["place"])
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise CardanError(f"{os.fspath(path)}: is not a saved response ({error})") from error
        own = json.loads(json.dumps(_identity(scene)))
        different = [name for name in own if header.get(name) != own[name]]
        if different:
            raise CardanError(
                f"{os.fspath(path)}: is the response of another scene; different: "
                f"{choices(different)}"
            )
        series = Series(content["values"], origin, length, bool(content["periodic"]))
        zero, constant, unique = (content[name] for name in ("zero", "constant", "unique"))
        return Response(scene, columns, series, zero, constant, unique, proof)

    def _sweep(
        self,
        positions: Array | None,
        count: int | None,
        speed: ArrayLike,
        acceleration: ArrayLike,
        loads: Mapping[str, ArrayLike] | None,
        gravity: ArrayLike | None,
    ) -> Sweep:
        speeds, accelerations = numbers("speed", speed), numbers("acceleration", acceleration)
        factors = self._factors(speeds, accelerations, loads, gravity)
        placed = (count,) if positions is None else positions.shape
        try:
            shape = np.broadcast_shapes(
                placed, *(part.shape for part in (speeds, accelerations, *factors.values()))
            )
        except ValueError as error:
            shapes = {name: part.shape for name, part in factors.items()}
            raise ArgumentError(
                f"shapes do not broadcast: position {placed}, speed {speeds.shape}, "
                f"acceleration {accelerations.shape}, {shapes}"
            ) from error
        points = OperatingPoints(self, positions, count, factors, shape, speeds, accelerations)
        scene = self.scene
        lost = self.proof.cancellation if "speed²" in factors else 1.0
        hidden = CHECK_ROUNDING * (lost - 1.0)
        return Sweep(
            mechanism=scene.mechanism,
            solver=scene.reactions,
            outputs=scene.outputs,
            source=points,
            unique=self.unique,
            tooth_moment={},
            tooth_unique={},
            condition=np.array([self.proof.condition * lost]),
            loop_residual=self.proof.loop_residual,
            balance_residual=self.proof.balance_residual + hidden,
            power_residual=self.proof.power_residual,
        )

    def _factors(
        self,
        speeds: Array,
        accelerations: Array,
        loads: Mapping[str, ArrayLike] | None,
        gravity: ArrayLike | None,
    ) -> dict[str, Array]:
        """Return what each column is multiplied with."""
        given = {**self.scene.joint_loads, **(loads or {})}
        with np.errstate(over="ignore"):  # What overflows is refused below.
            factors = {"speed²": speeds * speeds, "acceleration": accelerations}
        factors |= {name: numbers(f"loads[{name!r}]", value) for name, value in given.items()}
        factors |= {name: np.ones(()) for name in self.scene.link_loads}
        pull = self.scene.gravity if gravity is None else numbers("gravity", gravity)
        if pull.shape[-1:] != (3,):
            raise ArgumentError(f"gravity has shape {pull.shape}, expected (..., 3)")
        factors |= {name: pull[..., axis] for axis, name in enumerate(GRAVITY)}
        acting = {name: part for name, part in factors.items() if np.any(part)}
        missing = set(acting) - set(self.columns)
        # Inertia and weight have no columns where nothing has mass.
        missing -= {"speed²", "acceleration", *GRAVITY} if not self.scene.heavy else set()
        if missing:
            raise ArgumentError(
                f"the response has no columns for {choices(missing)}, only for "
                f"{choices(self.columns)}; give the scene such loads or a gravity"
            )
        acting = {name: part for name, part in acting.items() if name in self.columns}
        for name, part in acting.items():
            if not float(np.max(np.abs(part))) * self._greatest < _MOST:
                raise ArgumentError(f"{name} is so great that wrenches overflow")
        return acting

    @cached_property
    def _greatest(self) -> float:
        return max(1.0, float(np.max(np.abs(self.series.values), initial=0.0)))

    def _effort(self, column: str, position: ArrayLike) -> Array:
        positions = numbers("position", position)
        if column not in self.columns:
            return np.zeros(positions.shape)
        row = self.effort_rows(column)[0]
        return self.series.at(np.array([row]), self.series.locate(positions))[0]

    def wrench_rows(self, column: str, number: int) -> Array:
        """Return the places `(6,)` of an output's wrench in the series."""
        outputs = len(self.scene.outputs)
        first = 6 * (outputs * self.columns.index(column) + number)
        return np.arange(first, first + 6)

    def effort_rows(self, column: str) -> Array:
        """Return the places of the efforts of drive and held joints in the series."""
        count = 1 + len(self.scene.held)
        first = 6 * len(self.scene.outputs) * len(self.columns)
        first += count * self.columns.index(column)
        return np.arange(first, first + count)


def _identity(scene: Scene) -> dict[str, object]:
    return {
        "mechanism": scene.mechanism.name,
        "joints": scene.mechanism.joint_names,
        "drives": scene.drives,
        "held": scene.held,
        "outputs": scene.outputs,
        "branch": scene.branch,
        "links": sorted(scene.link_loads),
    }
