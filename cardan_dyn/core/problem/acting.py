"""Acting: how fast the drives of a sweep move, and what acts on its bodies."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...kit.arrays import Array, part
from ...kit.frozen import FrozenDict, frozen, read_only
from ..elements.link_loads import LinkLoad

AT_ZERO = read_only(np.zeros(()))
"""The time of a sweep that gives none [s]."""


class Acting(NamedTuple):
    """How fast the drives move and what acts; each array broadcasts with the shape of the samples.

    Attributes:
        speeds, accelerations: of the drives `(..., d)` [rad/s or m/s, per s].
        joint_loads: loaded coordinate to the effort added there [N·m or N].
        link_loads: link to the wrench that acts on it.
        gravity: `(..., 3)` [m/s²].
        inertia: link to the factor on its mass and inertia.
        time: at which actuators act [s].
    """

    speeds: Array
    accelerations: Array
    joint_loads: FrozenDict[str, Array]
    link_loads: FrozenDict[str, LinkLoad]
    gravity: Array
    inertia: FrozenDict[str, Array]
    time: Array

    @property
    def shapes(self) -> dict[str, tuple[int, ...]]:
        """Shapes of the samples of each argument, by the names that messages use."""
        shapes = {
            "speed": self.speeds.shape[:-1],
            "acceleration": self.accelerations.shape[:-1],
            "gravity": self.gravity.shape[:-1],
            "time": self.time.shape,
        }
        for name, effort in self.joint_loads.items():
            shapes[f"loads[{name!r}]"] = effort.shape
        for name, load in self.link_loads.items():
            shapes[f"loads[{name!r}].force"] = load.force.shape[:-1]
            shapes[f"loads[{name!r}].moment"] = load.moment.shape[:-1]
        for name, factor in self.inertia.items():
            shapes[f"inertia[{name!r}]"] = factor.shape
        return shapes

    @property
    def has_rates(self) -> bool:
        """Whether any drive moves or accelerates at any sample."""
        return bool(np.count_nonzero(self.speeds) or np.count_nonzero(self.accelerations))

    def flat(self, shape: tuple[int, ...], span: slice = slice(None)) -> Acting:
        """Return the same with arrays over `(N,)`, or `(1,)` where all samples have one value.

        Args:
            shape: of all samples.
            span: which of them are wanted.
        """

        def over(values: Array, trailing: int = 0) -> Array:
            rest = values.shape[values.ndim - trailing :]
            alone = values.size == math.prod(rest)
            return values.reshape(1, *rest) if alone else part(values, shape, span, trailing)

        efforts, links, inertia = self.joint_loads, self.link_loads, self.inertia
        if efforts:
            efforts = frozen({name: over(effort) for name, effort in efforts.items()})
        if links:
            links = frozen(
                {
                    name: replace(load, force=over(load.force, 1), moment=over(load.moment, 1))
                    for name, load in links.items()
                }
            )
        if inertia:
            inertia = frozen({name: over(factor) for name, factor in inertia.items()})
        speeds = part(self.speeds, shape, span, 1)
        accelerations = part(self.accelerations, shape, span, 1)
        gravity, time = over(self.gravity, 1), over(self.time)
        return Acting(speeds, accelerations, efforts, links, gravity, inertia, time)
