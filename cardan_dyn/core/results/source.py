"""Source: where a sweep takes from what was found, when it is first read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, Protocol

import numpy as np

from ...kit.arrays import Array
from ...kit.frozen import frozen, read_only
from .motion import Motion
from .wrench import Components, StoredComponents


class Source(Protocol):
    """Where a sweep takes from what was found, when it is first read."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the samples."""
        ...

    @property
    def position(self) -> Array:
        """Drive positions `(..., d)`, which broadcast with that shape."""
        ...

    def wrench(self, output: int) -> Components:
        """Return the wrench of an output, by its index, in its joint frame."""
        ...

    def drive_effort(self) -> Array | None:
        """Return what the drives exert `(..., d)`, None if the outputs leave it out."""
        ...

    def holding_effort(self) -> Mapping[str, Array]:
        """Return what holds the held joints, in the shape of the samples."""
        ...

    def motion(self) -> Motion:
        """Return positions, speeds and accelerations."""
        ...


class SolvedSource(NamedTuple):
    """A `Source` of what was solved before, of all N samples in one dimension.

    Its arrays are read-only where it is made.

    Attributes:
        shape: of the samples.
        position: of the drives `(..., d)`.
        wrenches: `(N, k, 6)` of the outputs.
        efforts: `(N, p)` what drives, then held joints exert.
        knows_drives: whether those of the drives are known.
        holding: held joints whose efforts are known, to their columns.
        solved_motion: the motion, or what returns it.
    """

    shape: tuple[int, ...]
    position: Array
    wrenches: Array
    efforts: Array
    knows_drives: bool
    holding: Mapping[str, int]
    solved_motion: Motion | Callable[[], Motion]

    def __reduce__(self) -> tuple[object, ...]:
        return _restored, (*self[:-1], self.motion())

    def wrench(self, output: int) -> Components:
        """Return the wrench of an output, by its index, in its joint frame."""
        values = self.wrenches[:, output]
        return StoredComponents(values if len(self.shape) == 1 else values.reshape(*self.shape, 6))

    def drive_effort(self) -> Array | None:
        """Return what the drives exert `(..., d)`, None if the outputs leave it out."""
        drives = self.position.shape[-1]
        return self.efforts[:, :drives].reshape(*self.shape, -1) if self.knows_drives else None

    def holding_effort(self) -> Mapping[str, Array]:
        """Return what holds the held joints."""
        return frozen(
            {name: self.efforts[:, k].reshape(self.shape) for name, k in self.holding.items()}
        )

    def motion(self) -> Motion:
        """Return positions, speeds and accelerations."""
        return self.solved_motion() if callable(self.solved_motion) else self.solved_motion


def _restored(*fields: Any) -> SolvedSource:
    for item in fields:
        if isinstance(item, np.ndarray):
            read_only(item)
    return SolvedSource(*fields)
