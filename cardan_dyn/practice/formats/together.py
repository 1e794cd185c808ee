"""Together: the mass of several bodies that move as one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from ...kit.arrays import Array

Massive: TypeAlias = tuple[float, Array, Array]
"""Mass [kg], centre `(3,)` [m] and inertia `(3, 3)` about it [kg·m²]."""


def together(parts: Sequence[Massive]) -> Massive:
    """Return the mass of bodies as one; of all of them, seen in the same frame, it is not zero."""
    mass = sum(part[0] for part in parts)
    centre = np.asarray(sum(own * place for own, place, _ in parts) / mass)
    tensor = np.zeros((3, 3))
    for own, place, inertia in parts:
        arm = place - centre
        tensor += inertia + own * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return mass, centre, tensor
