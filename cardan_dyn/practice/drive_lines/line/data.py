"""Line data: shafts and joints along the power flow, with a speed, a torque and a duty cycle."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ....kit.arrays import NOTHING
from ....kit.errors import ModelError
from ....kit.frozen import read_only
from .fields import flag, implausible, part, parts, positive, quantity, settle, text
from .geometry import Geometry, Zero, called, geometry, zero
from .parts import Bearing, DutyPoint, Shaft, ShaftJoint, TitleBlock

if TYPE_CHECKING:
    from ....kit.arrays import Array


@dataclass(frozen=True, kw_only=True, repr=False)
class LineData:
    """The data of a `DriveLine` and what follows from them alone; attributes are told there."""

    shafts: tuple[Shaft, ...] = parts(Shaft, dataclasses.MISSING)
    joints: tuple[ShaftJoint, ...] = parts(ShaftJoint)
    name: str = text("drive_line")
    speed: float | None = quantity("speed", None)
    torque: float | None = quantity("torque", None)
    duty_cycle: tuple[DutyPoint, ...] = parts(DutyPoint)
    application: str = text(known=("", "vehicle", "agricultural", "industrial"))
    service_factor: float | None = positive("number")
    reversing: bool = flag(default=False)
    acceleration: float | None = quantity("angular_acceleration", None, least=0.0)
    life: float | None = positive("time")
    report: TitleBlock | None = part(TitleBlock)

    def __post_init__(self) -> None:
        settle(self)
        count = len(self.shafts) - 1
        if count < 1:
            raise ModelError(
                f"shafts of a DriveLine: there are {count + 1}; a line has two shafts at least, "
                "with a joint between them"
            )
        if not self.joints:
            object.__setattr__(self, "joints", (ShaftJoint(),) * count)
        if len(self.joints) != count:
            raise ModelError(
                f"joints of a DriveLine: there are {len(self.joints)} joints between {count + 1} "
                f"shafts; give {count}, or none if nothing is to be said about them"
            )
        total = math.fsum(point.share for point in self.duty_cycle)
        if self.duty_cycle and abs(total - 1.0) > NOTHING:
            raise ModelError(
                f"duty_cycle of a DriveLine: its shares have the sum {total:.12g}; it has to be 1"
            )
        self._check_shafts()
        _check_names([bearing.name for bearing in self.bearings if bearing.name], "bearings")
        _check_names(self.joint_names, "joints")
        _check_names(self.shaft_names, "shafts")

    @property
    def uneven_angles(self) -> Array:
        """Joint angles as far as they make the line uneven: 0 at constant velocity `(n,)` [rad]."""
        return np.where(self.even, 0.0, self.joint_angles)

    @cached_property
    def even(self) -> Array:
        """Which joints are those of constant velocity `(n,)`."""
        return read_only(np.array([joint.kind == "constant_velocity" for joint in self.joints]))

    @property
    def centred(self) -> tuple[int, ...]:
        """Indices of the shafts that are coupling pieces of centred double joints."""
        return tuple(k for k, shaft in enumerate(self.shafts) if shaft.centring is not None)

    def _check_shafts(self) -> None:
        """Refuse what the place of a shaft in the line does not allow."""
        lengths, last = self.geometry.lengths, len(self.shafts) - 1
        for index, (shaft, length) in enumerate(zip(self.shafts, lengths, strict=True)):
            at = called(self.shafts, index)
            if wrong := implausible(float(length), "length"):
                raise ModelError(f"the length of {at} between its ends is {wrong}")
            places = [bearing.distance for bearing in shaft.bearings]
            if len(set(places)) < len(places):
                repeated = max(places, key=places.count)
                raise ModelError(
                    f"distance = {repeated:.9g} m of bearings of {at}: two of them are at one "
                    "place; give different distances"
                )
            if shaft.centring is not None and index not in (0, last):
                kinds = {joint.kind for joint in self.joints[index - 1 : index + 1]}
                if kinds != {"cross"}:
                    raise ModelError(
                        f"centring of {at}: both joints of a centred double joint have a cross; "
                        "a joint of constant velocity needs no centring"
                    )
            if index in (0, last):
                for field in ("fork_offset", "spline"):
                    if getattr(shaft, field):
                        raise ModelError(f"{field} of {at}: only intermediate shafts have one")
                if shaft.tube is not None and shaft.mass is None and math.isnan(length):
                    raise ModelError(f"tube of {at} needs a length to have a mass; give length")
                continue
            for what, distance in [
                *((f"bearings[{i}]", item.distance) for i, item in enumerate(shaft.bearings)),
                ("spline", shaft.spline.distance if shaft.spline else None),
            ]:
                if distance is not None and distance > length:
                    raise ModelError(
                        f"distance = {distance:.9g} m of {what} of {at} exceeds the shaft's "
                        f"length {length:.9g} m"
                    )

    def __repr__(self) -> str:
        shown = np.degrees(self.joint_angles[:6])
        angles = [*(f"{angle:.4g}°" for angle in shown), *["…"] * (self.count > len(shown))]
        return (
            f"<{type(self).__name__} {self.name!r}: {self.count} joints at {', '.join(angles)}; "
            f"{len(self.bearings)} bearings>"
        )

    def __getstate__(self) -> dict[str, Any]:
        # What was computed from the data is computed again where a copy is asked for it.
        return {item.name: getattr(self, item.name) for item in dataclasses.fields(self)}

    @property
    def count(self) -> int:
        """Number n of joints."""
        return len(self.joints)

    @cached_property
    def geometry(self) -> Geometry:
        """Where shafts and joints are; see `Geometry`."""
        return geometry(self.shafts)

    @cached_property
    def zero(self) -> Zero:
        """How pins and shafts stand while the input fork's pin is horizontal."""
        return zero(self.geometry, self.fork_offsets, self.even)

    @property
    def joint_angles(self) -> Array:
        """Joint angles β_k `(n,)` [rad]."""
        return self.geometry.joint_angles

    @property
    def fork_phases(self) -> Array:
        """Fork phases γ_k `(n,)` [rad]; see `Geometry`."""
        return self.geometry.fork_phases

    @property
    def fork_offsets(self) -> Array:
        """Angles between the forks of the intermediate shafts `(n - 1,)` [rad]; see `Shaft`."""
        return np.array([shaft.fork_offset for shaft in self.shafts[1:-1]])

    @property
    def bearings(self) -> tuple[Bearing, ...]:
        """All support bearings along the power flow, shaft by shaft."""
        return tuple(bearing for shaft in self.shafts for bearing in shaft.bearings)

    @property
    def shaft_names(self) -> tuple[str, ...]:
        """Names of the shafts; `input`, `shaft_1` …, `output` unless given."""
        last = len(self.shafts) - 1
        plain = ["input", *(f"shaft_{k}" for k in range(1, last)), "output"]
        return tuple(shaft.name or name for shaft, name in zip(self.shafts, plain, strict=True))

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints; `joint_1` … unless given."""
        return tuple(joint.name or f"joint_{k}" for k, joint in enumerate(self.joints, 1))


def _check_names(names: Sequence[str], what: str) -> None:
    repeated = sorted({name for name in names if names.count(name) > 1})
    if repeated:
        raise ModelError(
            f"{what} of a DriveLine: the name {repeated[0]!r} occurs twice, counting those that "
            f"{what} without a name have; give different names"
        )
