"""Inspection: what a scene tells of itself without a sweep."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..dynamics.problem_solver import ProblemSolver
from ..errors import MobilityError, choices
from .arguments import SceneArguments
from .solving import Asked, reachable

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ..arrays import Array
    from ..mechanism.configuration import Configuration
    from .branches import Branches
    from .plan import Plan


class SceneInspection(SceneArguments):
    """Plan, range, start and assembly modes of a scene."""

    _solver: ProblemSolver

    def plan(self) -> Plan:
        """Return what sweeps and simulations do, and what they leave out; `print` shows it."""
        from ..simulation.simulate import planned
        from .plan import plan_of  # Imported here: most scripts show no plan.

        assembly = self._solver.assembly
        return plan_of(
            self.mechanism,
            assembly.groups,
            assembly.needed,
            self.outputs,
            has_mass=self._solver.has_mass,
            has_weight=bool(np.any(self.gravity)),
            elements=self.elements,
            simulation=planned(self._solver),
        )

    def motion_range(self) -> tuple[float, float]:
        """Return between which positions the drive can move [rad or m].

        `<limit>` elements of the description are not regarded: a sweep may go beyond them.

        They are dead points of the drive or positions where assembly modes meet; ±inf where it
        turns through, or slides by more than ten lengths of the mechanism.

        Raises:
            MobilityError: the scene has several drives.
        """
        if len(self.drives) > 1:
            raise MobilityError(
                f"the range of one drive depends on the positions of the others: "
                f"{choices(self.drives)}; hold all but one of them",
                mobility=len(self.drives),
            )
        return self._solver.assembly.motion_range()

    def reachable(
        self, position: ArrayLike, *, held: Mapping[str, ArrayLike] | None = None
    ) -> Array:
        """Return at which drive positions a sweep can be solved: a robot's workspace.

        A sweep refuses positions beyond a dead point, or where the loops cannot be closed on the
        way from the start.

        Args:
            position: see `Scene.sweep`.
            held: see `Scene.sweep`.

        Returns:
            Array of bool, in the common shape of the arguments.

        Raises:
            ArgumentError: a value is not finite, shapes do not broadcast, or a joint is not held.
            ModelError: no such joint.
            MobilityError: the drives do not decide the motion.
        """
        return reachable(self._solver, Asked(position, held=held))

    def configuration(self) -> Configuration:
        """Return the closed configuration in which the scene starts, of all loops."""
        from .assembled import configuration_of  # Most scenes show none.

        return configuration_of(self._solver)

    def branches(self) -> Branches:
        """Return the assembly modes with the drives where the scene starts.

        `A` is that of the description, the others follow by their distance from it.
        """
        from .branches import Branches  # Most scenes need no other mode.

        return Branches(self.mechanism, self.drives, self._solver.assembly.modes())
