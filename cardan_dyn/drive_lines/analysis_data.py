"""Analysis data: motion of a drive line and what acts along it, over positions and designs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from ..arrays import Array
from ..frozen import read_only
from .forces import LineForces

_ARRAYS = ("position", "rotation", "ratio", "acceleration", "slip", "mean_lead")


@dataclass(frozen=True, eq=False)
class AnalysisData:
    """Motion of a line of n joints, and what acts along it; `Analysis` is its public face.

    `(…)` stands for `(P,)` positions, or `(D, P)` for D designs. Arrays cannot be written to.

    Attributes:
        name: of the line.
        shafts: names of its n + 1 shafts.
        joints: names of its n joints.
        bearings: names of its m bearings; `bearing_in` and `bearing_out` are those at the joints
            of end shafts without bearings of their own.
        splines: names of the s shafts that have a spline.
        centrings: names of the c coupling pieces of centred double joints.
        speed: of the input shaft [rad/s].
        position: `(P,)` of the input shaft [rad], 0 where its fork's pin is horizontal.
        designs: adjustable joints to their positions `(D,)` in each design [rad or m]; empty
            without variants.
        rotation: `(…, n + 1)` rotation of each shaft about its axis [rad]. All count from where
            they would be if the joints were straight, from shaft to shaft by the shortest swing.
        ratio: `(…, n + 1)` speed of each shaft over that of the input shaft.
        acceleration: `(…, n + 1)` angular acceleration of each shaft about its axis [rad/s²].
        static: forces without inertia and weight: from the torque, and the friction of splines.
        inertial: forces of inertia and weight alone; None if there are none.
        slip: `(…, s)` by how much each spline is drawn out against the data [m].
        mean_lead: `(n + 1,)`, or `(D, n + 1)` of designs: mean of each shaft's rotation minus that
            of the input shaft, over a turn of this [rad].
        indeterminate: what statics leaves open; forces there are the ones of least norm.
        loop_residual: worst closure error; see `Sweep`.
        balance_residual: worst imbalance of a body; see `Sweep`. NaN where nothing acts.
        power_residual: worst imbalance of power; see `Sweep`.
    """

    name: str
    shafts: tuple[str, ...]
    joints: tuple[str, ...]
    bearings: tuple[str, ...]
    splines: tuple[str, ...]
    centrings: tuple[str, ...]
    speed: float
    position: Array
    designs: Mapping[str, Array]
    rotation: Array
    ratio: Array
    acceleration: Array
    static: LineForces
    inertial: LineForces | None
    slip: Array
    mean_lead: Array
    indeterminate: tuple[str, ...]
    loop_residual: float
    balance_residual: float
    power_residual: float

    def __post_init__(self) -> None:
        arrays = [getattr(self, name) for name in _ARRAYS]
        for array in (*arrays, *self.static, *(self.inertial or ()), *self.designs.values()):
            read_only(array)

    def __reduce__(self) -> tuple[object, ...]:
        # Through the constructor, which closes the arrays of a copy to writing as well.
        return _restored, (
            type(self),
            {item.name: getattr(self, item.name) for item in fields(self)},
        )

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the samples."""
        return self.rotation.shape[:-1]

    @property
    def total(self) -> LineForces:
        """Forces with inertia and weight."""
        return self.static if self.inertial is None else self.static.plus(self.inertial)

    @property
    def angle_error(self) -> Array:
        """Lead of each shaft over the input shaft, without its mean over a turn `(…, n + 1)` [rad].

        Whatever positions there are.
        """
        mean = self.mean_lead if len(self.shape) == 1 else self.mean_lead[:, None]
        return self.rotation - self.rotation[..., :1] - mean

    def __len__(self) -> int:
        return self.shape[0]

    def __repr__(self) -> str:
        return (
            f"<Analysis of {self.name!r}: {' × '.join(map(str, self.shape))} samples, "
            f"{len(self.joints)} joints, {len(self.bearings)} bearings>"
        )


def _restored(kind: type[AnalysisData], values: dict[str, Any]) -> AnalysisData:
    """Return a copy; `__reduce__` needs a function without keyword arguments."""
    return kind(**values)
