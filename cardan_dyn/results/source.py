"""Source: where a sweep takes its arrays from, when they are first read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from ..arrays import Array
from ..elements.link_loads import LinkLoad
from ..frozen import Record
from .motion import Motion
from .wrench import Components, StoredComponents


class Source(Protocol):
    """Where a sweep takes its arrays from, when they are first read."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the operating points."""
        ...

    @property
    def position(self) -> Array:
        """Drive positions `(...)`, or `(..., d)`."""
        ...

    @property
    def speed(self) -> Array:
        """Drive speeds, like `position`."""
        ...

    @property
    def acceleration(self) -> Array:
        """Drive accelerations, like `position`."""
        ...

    @property
    def held(self) -> Mapping[str, float | Array]:
        """Held joints and their positions."""
        ...

    @property
    def joint_loads(self) -> Mapping[str, Array]:
        """Loaded joints and their efforts."""
        ...

    @property
    def link_loads(self) -> Mapping[str, LinkLoad]:
        """Loaded links and their wrenches."""
        ...

    @property
    def gravity(self) -> Array:
        """Acceleration of free fall, `(3,)` or `(..., 3)`."""
        ...

    @property
    def inertia(self) -> Mapping[str, Array]:
        """Links and the factors on their mass and inertia."""
        ...

    @property
    def time(self) -> Array:
        """Times at which actuators act [s]."""
        ...

    def __len__(self) -> int:
        """Return the number of samples."""
        ...

    def wrench(self, output: int) -> Components:
        """Return the wrench of an output, by its index, in its joint frame."""
        ...

    def drive_effort(self) -> Array | None:
        """Return what the drive exerts, None if the outputs leave it out."""
        ...

    def holding_effort(self) -> Mapping[str, Array]:
        """Return what holds the held joints."""
        ...

    def motion(self) -> Motion:
        """Return positions, speeds and accelerations."""
        ...


@dataclass(frozen=True, eq=False)
class SolvedSource(Record):
    """A `Source` whose arrays were computed before; `...` is the shape of the samples.

    Attributes:
        shape: of the samples.
        wrenches: `(..., k, 6)` of the outputs.
        drive_efforts: `(...)`, `(..., d)`, or None if the outputs leave them out.
        holding_efforts: held joint to what holds it `(...)`.
        solved_motion: the motion.
        position, speed, acceleration: of the drives `(...)`, or `(..., d)`.
        held, joint_loads, link_loads, gravity, inertia, time: see `Source`; as they were given.
    """

    shape: tuple[int, ...]
    wrenches: Array
    drive_efforts: Array | None
    holding_efforts: Mapping[str, Array]
    solved_motion: Motion
    position: Array
    speed: Array
    acceleration: Array
    held: Mapping[str, float | Array]
    joint_loads: Mapping[str, Array]
    link_loads: Mapping[str, LinkLoad]
    gravity: Array
    inertia: Mapping[str, Array]
    time: Array = field(default_factory=lambda: np.zeros(()))

    def __len__(self) -> int:
        return self.shape[0]

    def wrench(self, output: int) -> Components:
        """Return the wrench of an output, by its index, in its joint frame."""
        return StoredComponents(self.wrenches[..., output, :])

    def drive_effort(self) -> Array | None:
        """Return what the drive exerts, None if the outputs leave it out."""
        return self.drive_efforts

    def holding_effort(self) -> Mapping[str, Array]:
        """Return what holds the held joints."""
        return self.holding_efforts

    def motion(self) -> Motion:
        """Return positions, speeds and accelerations."""
        return self.solved_motion
