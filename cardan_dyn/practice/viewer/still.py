"""Still: a configuration as the viewer draws it, a motion of one sample without any wrench.

Force elements stand in it as they would at rest, at the time zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...core.dynamics.velocity_ratios import VelocityRatios
from ...core.elements.element import Element
from ...core.mechanism.configuration import Configuration
from ...core.problem.element_arguments import elements_on, listed
from ...core.results.motion import Motion
from ...kit.arrays import Array
from ...kit.errors import ArgumentError


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
        elements: the force elements that are drawn.
        time: at which actuators act [s].
        shape: of the samples, like that of a sweep.
    """

    shape = (1,)

    def __init__(self, configuration: Configuration, elements: Sequence[Element] = ()) -> None:
        """Take a configuration.

        Args:
            configuration: where the mechanism is.
            elements: force elements, which act along its coordinates and between its links.

        Raises:
            ArgumentError: an element is none, or does not fit the mechanism.
            ModelError: a joint or link of one is unknown.
        """
        self.mechanism = configuration.mechanism
        self.time = np.zeros(1)
        self.elements = elements_on(self.mechanism, listed(elements))
        for name in (name for element in self.elements for name in element.joints):
            if name not in self.mechanism.coordinates.named:
                raise ArgumentError(
                    f"{name!r} is an angle of a ball, which this configuration has as a whole; "
                    "take the configuration of a scene that has the element"
                )
        self.outputs = tuple(self.mechanism)
        x, rest = configuration.x[None, :], np.zeros((1, self.mechanism.model.nv))
        ratios = VelocityRatios.of(np.zeros((1, rest.size, 0)))
        self.motion = Motion(self.mechanism, (), x, np.zeros_like(x), (rest, rest, ratios))

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
