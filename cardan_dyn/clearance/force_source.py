"""Force source: the forces of all pins over a period, from a sweep or from a response."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from ..arrays import Array
from ..checks import described
from ..errors import AccuracyError, ArgumentError, IndeterminateError
from ..response.operating_points import solved_motion
from ..response.response import Response
from .determinate import what_is_open
from .force_course import ForceCourse

if TYPE_CHECKING:
    from ..results.sweep import Sweep
    from ..scene.scene import Scene

_SAMPLES, _MOST_SAMPLES = 720, 11_520
"""Positions over a period; doubled until the forces' series ends."""
_TAIL = 1e-6
"""Last harmonics of a force, as a fraction of its greatest, at which the series ends."""
_ROUNDING = 1e-9
"""Greatest force of a joint, as a fraction of that of all joints, that is rounding and counts as
none: it would swing round hundreds of times."""
_PLACED: WeakKeyDictionary[Response, dict[int, Sweep]] = WeakKeyDictionary()
"""Responses to sweeps of them, by their numbers of positions, which know where joints are: that is
no part of a response, and the same at every speed."""


class PinForces(NamedTuple):
    """Forces across pins over a period.

    Attributes:
        position: of the drive `(N,)` [rad].
        forces: joint to the force across its pin `(N, 3)` in the world [N].
        courses: joint to the same as functions of the position.
    """

    position: Array
    forces: dict[str, Array]
    courses: dict[str, ForceCourse]


class ForceSource:
    """Where forces come from: sweeps of a scene, or its response, which takes none.

    Attributes:
        solver: of the scene.
        problem: what it solves.
    """

    def __init__(self, given: Scene | Response) -> None:
        from ..scene.scene import Scene  # Known to who has one.

        if not isinstance(given, (Scene, Response)):
            raise ArgumentError(f"scene is {described(given)}; expected a scene or its response")
        self._given = given
        self.solver = given.solver
        self.problem = self.solver.problem
        if isinstance(given, Response) and np.isfinite(given.interval[0]):
            raise ArgumentError(
                f"the response holds from {given.interval[0]:g} to {given.interval[1]:g} alone; "
                "make one of the whole turn: scene.response()"
            )

    @property
    def is_inertial(self) -> bool:
        """Whether inertia alone acts."""
        problem = self.problem
        acts = any(np.any(effort) for effort in problem.joint_loads.values())
        return not (acts or problem.link_loads or np.any(problem.gravity) or problem.elements)

    def closed(self, positions: list[float]) -> Array:
        """Return closed coordinates `(K, size)` at drive positions."""
        if not positions:
            return np.zeros((0, self.problem.mechanism.coordinates.size))
        zeros = np.zeros(len(positions))
        return np.asarray(solved_motion(self.solver, np.asarray(positions), zeros, zeros)._x)

    def forces(
        self, speed: float, period: float, wanted: list[str], left_out: dict[str, str] | None
    ) -> PinForces:
        """Return forces across pins.

        Args:
            speed: of the drive [rad/s].
            period: after which they repeat [rad].
            wanted: joints that turn about one axis.
            left_out: takes those whose force is indeterminate, and why; None if these are refused.

        Raises:
            IndeterminateError: a force is not unique, and refused.
            AccuracyError: the forces are too uneven.
        """
        count = _SAMPLES
        while True:
            positions = period / count * np.arange(count)
            turn = self._given.sweep(positions, speed)
            unique = [name for name in wanted if self._is_unique(turn, name, left_out)]
            forces = {name: self._across(turn, name) for name in unique}
            sizes = {name: float(np.max(np.abs(force))) for name, force in forces.items()}
            greatest = max(sizes.values(), default=0.0)
            for name, size in sizes.items():
                if size <= _ROUNDING * greatest:
                    forces[name] = np.zeros_like(forces[name])
            courses = {name: ForceCourse(force, period) for name, force in forces.items()}
            rough = [name for name in unique if courses[name].tail * sizes[name] > _TAIL * greatest]
            if not rough:
                break
            if count >= _MOST_SAMPLES:
                raise AccuracyError(
                    f"{count} positions do not resolve the force of joint {rough[0]!r} over a "
                    "period"
                )
            count *= 2
        if not (self.is_inertial or self.problem.elements):
            resting = self._given.sweep(positions, 0.0)
            for name, force in forces.items():
                inertial = force - self._across(resting, name)
                courses[name] = ForceCourse(force, period, inertial)
        return PinForces(positions, forces, courses)

    def _is_unique(self, turn: Sweep, name: str, left_out: dict[str, str] | None) -> bool:
        """Return whether the force across a pin follows from the laws of motion alone.

        Raises:
            IndeterminateError: it does not, and is refused.
        """
        reason = what_is_open(self.solver, turn, name)
        if reason and left_out is None:
            raise IndeterminateError(f"joint {name!r}: {reason}")
        if reason and left_out is not None:
            left_out[name] = reason
        return not reason

    def _across(self, turn: Sweep, name: str) -> Array:
        """Return the force across a pin `(N, 3)` in the world."""
        return across(turn, name, self._where_joints_are(turn))

    def _where_joints_are(self, turn: Sweep) -> Sweep:
        """Return a sweep over the same positions that need not solve its motion again."""
        if not isinstance(self._given, Response):
            return turn
        return _PLACED.setdefault(self._given, {}).setdefault(len(turn), turn)


def across(sweep: Sweep, name: str, placed: Sweep | None = None) -> Array:
    """Return the force across a pin `(N, 3)` in the world.

    Args:
        sweep: with the wrench.
        name: of the joint.
        placed: sweep over the same positions which knows where joints are; the same if None.
    """
    axis = sweep.mechanism.joint(name).parts[0].axis
    force = np.asarray(sweep[name].force)
    force = force - np.outer(force @ axis, axis)
    rotation = (sweep if placed is None else placed).rotation(name)
    return np.asarray((rotation @ force[:, :, None])[:, :, 0])
