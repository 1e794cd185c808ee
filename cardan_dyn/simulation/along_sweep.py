"""Along sweep: what a trajectory shows of the sweep along its motion, under the sweep's names."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from functools import cached_property

from ..arrays import Array
from ..elements.link_loads import Wrench
from ..results.element_results import ElementResults
from ..results.motion import Motion
from ..results.prescribed import Prescribed
from ..results.sweep import Sweep
from ..results.wrench import JointWrench


class AlongSweep(Prescribed):
    """Results of a sweep over times; figures and views take it like a sweep.

    All of them are solved when the first is read, and raise what `sweep` raises.

    Attributes:
        time: times `(N,)` [s].
    """

    time: Array

    @property
    @abstractmethod
    def sweep(self) -> Sweep:
        """The motion as a sweep of the scene."""

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Shape of the times, `(N,)`."""

    @property
    def motion(self) -> Motion:
        """Positions, speeds and accelerations of all joints, as those of a sweep."""
        return self.sweep.motion

    def __getitem__(self, joint: str) -> JointWrench:
        return self.sweep[joint]

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names of the joints whose wrenches are results."""
        return iter(self.outputs)

    def __contains__(self, joint: object) -> bool:
        return isinstance(joint, str) and joint in self.outputs

    def wrench(self, joint: str, frame: str = "joint") -> JointWrench:
        """Return the wrench of a joint in other axes, see `Sweep.wrench`."""
        return self.sweep.wrench(joint, frame)

    def rotation(self, joint: str) -> Array:
        """Return the rotations of a joint's frame, see `Sweep.rotation`."""
        return self.sweep.rotation(joint)

    def origin(self, joint: str) -> Array:
        """Return the origins of a joint's frame, see `Sweep.origin`."""
        return self.sweep.origin(joint)

    @property
    def unique(self) -> Array:
        """Which components follow from the laws of motion alone, see `Sweep.unique`."""
        return self.sweep.unique

    @property
    def drive_effort(self) -> Array:
        """What the drives exert, see `Sweep.drive_effort`: of free ones zero but for errors."""
        return self.sweep.drive_effort

    @property
    def holding_effort(self) -> Mapping[str, Array]:
        """What holds the held joints, see `Sweep.holding_effort`."""
        return self.sweep.holding_effort

    @cached_property
    def element_force(self) -> ElementResults:
        """What the force elements exert, see `Sweep.element_force`; this needs no wrenches."""
        forces = self._problem.element_forces
        each = [] if forces is None else forces.each(*self._counted(), self.time)
        return ElementResults(forces, each)

    @abstractmethod
    def _counted(self) -> tuple[Array, Array]:
        """Return coordinates with all turns, and velocities."""

    @property
    def elastic_energy(self) -> Array:
        """Energy that springs and bushings store `(N,)` [J]."""
        return self.sweep.elastic_energy

    @property
    def loads(self) -> Mapping[str, Array | Wrench]:
        """Loaded joints and links to what acts there, see `Sweep.loads`."""
        return self.sweep.loads

    @property
    def gravity(self) -> Array:
        """Acceleration of free fall `(3,)` in world axes [m/s²]."""
        return self.sweep.gravity

    @property
    def condition(self) -> Array:
        """Condition number of the wrenches `(N,)`, see `Sweep.condition`."""
        return self.sweep.condition

    @property
    def loop_residual(self) -> float:
        """Worst closure error, see `Sweep.loop_residual`."""
        return self.sweep.loop_residual

    @property
    def balance_residual(self) -> float:
        """Worst imbalance of a body, see `Sweep.balance_residual`."""
        return self.sweep.balance_residual

    @property
    def power_residual(self) -> float:
        """Worst imbalance of power, see `Sweep.power_residual`."""
        return self.sweep.power_residual

    @property
    def rate_residual(self) -> float:
        """Worst violation of the loops by rates, see `Sweep.rate_residual`."""
        return self.sweep.rate_residual
