"""The source of a description that was read from a model of Pinocchio."""

from __future__ import annotations

from dataclasses import dataclass

import pinocchio

from ....core.description.description import Source
from ....kit.arrays import Array


@dataclass(frozen=True, eq=False)
class SourceModel(Source):
    """The `pin.Model` that a description was read from, and its constraints.

    Attributes:
        model: a copy of it.
        constraints: of each the joints (index) of its two ends, and its `(4, 4)` placements there
            [m].
    """

    model: pinocchio.Model
    constraints: tuple[tuple[int, Array, int, Array], ...]
