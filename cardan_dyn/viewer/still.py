"""Still: a configuration as the viewer draws it, a motion of one sample without any wrench."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..dynamics.velocity_ratios import VelocityRatios
from ..mechanism.configuration import Configuration
from ..results.motion import Motion


class NoWrench(NamedTuple):
    """The wrench of a joint in a still.

    Attributes:
        force, moment: `(1, 3)` zeros.
    """

    force: Array
    moment: Array


class Still:
    """What the viewer asks a sweep for, of a configuration.

    Attributes:
        mechanism: the mechanism.
        outputs: names of all joints.
        motion: of one sample.
    """

    def __init__(self, configuration: Configuration) -> None:
        self.mechanism = configuration.mechanism
        self.outputs = tuple(self.mechanism)
        x, rest = configuration.x[None, :], np.zeros((1, self.mechanism.model.nv))
        ratios = VelocityRatios.of(np.zeros((1, rest.size, 0)))
        self.motion = Motion(self.mechanism, (), x, np.zeros_like(x), rest, rest, ratios)

    def __len__(self) -> int:
        return 1

    def __getitem__(self, joint: str) -> NoWrench:
        self.mechanism.joint(joint)
        return NoWrench(np.zeros((1, 3)), np.zeros((1, 3)))

    def rotation(self, joint: str) -> Array:
        """Return the rotation `(1, 3, 3)` of a joint's frame in the world."""
        return self.motion.joint_placement(joint)[0]

    def origin(self, joint: str) -> Array:
        """Return the origin `(1, 3)` of a joint's frame in the world [m]."""
        return self.motion.joint_placement(joint)[1]
