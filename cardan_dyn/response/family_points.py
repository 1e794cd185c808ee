"""Family points: a sweep over designs, each part of which its own response evaluates."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..arrays import Array
from ..dynamics.problem_solver import ProblemSolver
from ..elements.link_loads import LinkLoad
from ..frozen import frozen, read_only
from ..proof.residuals import Proven
from ..results.motion import Motion
from ..results.sweep import Sweep
from .operating_points import solved_motion


@dataclass(frozen=True, eq=False)
class FamilyPoints:
    """A `Source` of a sweep over designs, each part of which is evaluated by its own response.

    Attributes:
        solver: of the scene.
        sweeps: of the designs.
        chosen: which part of the whole each of them is.
        shape: of all samples.
        position, speed, acceleration: of the drive, of that shape.
        held, joint_loads, gravity: see `Source`.
    """

    solver: ProblemSolver
    sweeps: tuple[Sweep, ...]
    chosen: tuple[tuple[Any, ...], ...]
    shape: tuple[int, ...]
    position: Array
    speed: Array
    acceleration: Array
    held: Mapping[str, float | Array]
    joint_loads: Mapping[str, Array]
    gravity: Array

    def __len__(self) -> int:
        return self.shape[0]

    @property
    def link_loads(self) -> Mapping[str, LinkLoad]:
        """Loaded links and their wrenches."""
        return self.solver.problem.link_loads

    @property
    def inertia(self) -> Mapping[str, Array]:
        """Factors on mass and inertia of links: none."""
        return frozen({})

    @property
    def time(self) -> Array:
        """Time at which actuators act [s]: zero."""
        return np.zeros(())

    def wrench(self, output: int) -> FamilyComponents:
        """Return the wrench of an output, by its index, in its joint frame."""
        return FamilyComponents(self, output)

    def drive_effort(self) -> Array | None:
        """Return what the drive exerts, None if the outputs leave it out."""
        if not self.solver.knows_effort(self.solver.problem.independent[0]):
            return None
        return self.gathered([sweep.drive_effort for sweep in self.sweeps])

    def holding_effort(self) -> Mapping[str, Array]:
        """Return what holds the held joints."""
        names = list(self.sweeps[0].holding_effort)
        return frozen(
            {
                name: self.gathered([sweep.holding_effort[name] for sweep in self.sweeps])
                for name in names
            }
        )

    def motion(self) -> Motion:
        """Return the motion of all designs, solved directly."""
        held = {name: np.asarray(value) for name, value in self.held.items()}
        return solved_motion(
            self.solver,
            self.position,
            self.speed,
            self.acceleration,
            {name: value for name, value in held.items() if value.ndim},
        )

    def gathered(self, parts: Sequence[Array]) -> Array:
        """Return values of all samples from those of each design."""
        first = parts[0]
        rest = first.shape[self.sweeps[0].position.ndim :]
        result = np.empty((*self.shape, *rest))
        for where, part in zip(self.chosen, parts, strict=True):
            result[where] = part.reshape(np.shape(result[where]))
        return read_only(result)


@dataclass(frozen=True, eq=False)
class FamilyComponents:
    """Components of a wrench of all designs.

    Attributes:
        points: all samples.
        output: index of the joint among the outputs.
    """

    points: FamilyPoints
    output: int

    def component(self, index: int) -> Array:
        """Return a component of the wrench, in the shape of the samples."""
        name = self.points.solver.problem.outputs[self.output]
        kind, axis = ("force", index) if index < 3 else ("moment", index - 3)
        parts = [getattr(sweep[name], kind)[..., axis] for sweep in self.points.sweeps]
        return self.points.gathered(parts)

    def vector(self, first: int) -> Array:
        """Return three components, from the `first` on, on a last axis."""
        return np.stack([self.component(first + axis) for axis in range(3)], axis=-1)

    def vanishes(self, index: int) -> bool:
        """Return whether a component is zero throughout."""
        return not np.any(self.component(index))


@dataclass(frozen=True, eq=False)
class FamilyMoments(Mapping[str, Array]):
    """Moments of the couplings of all designs, each evaluated when it is first looked up.

    Attributes:
        points: all samples.
    """

    points: FamilyPoints
    _evaluated: dict[str, Array] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Array:
        if name not in self._evaluated:
            parts = [sweep.coupling_moment[name] for sweep in self.points.sweeps]
            self._evaluated[name] = self.points.gathered(parts)
        return self._evaluated[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.points.sweeps[0].coupling_moment)

    def __len__(self) -> int:
        return len(self.points.sweeps[0].coupling_moment)


def sweep_of(points: FamilyPoints) -> Sweep:
    """Return the sweeps of all designs as one."""
    sweeps = points.sweeps
    moments = FamilyMoments(points)

    return Sweep(
        problem=points.solver.problem,
        source=points,
        unique=np.logical_and.reduce([sweep.unique for sweep in sweeps]),
        coupling_moment=moments,
        coupling_unique=frozen(
            {name: all(sweep.coupling_unique[name] for sweep in sweeps) for name in moments}
        ),
        condition=np.max([sweep.condition for sweep in sweeps], axis=0),
        proven=Proven.worst([sweep.proven for sweep in sweeps]),
    )
