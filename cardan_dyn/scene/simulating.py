"""Simulating: the motion of a scene's drives where it is not prescribed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from .responding import SceneResponses

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ..simulation.equilibrium import Equilibrium
    from ..simulation.trajectory import Trajectory


class SceneSimulations(SceneResponses):
    """Simulations of a scene."""

    def simulate(
        self,
        duration: float,
        *,
        position: ArrayLike | Mapping[str, float] | None = None,
        speed: ArrayLike | Mapping[str, float] | None = None,
        motion: Mapping[str, Any] | None = None,
        loads: Mapping[str, Any] | None = None,
        rtol: float = 1e-10,
        atol: float | None = None,
        method: str | None = None,
        step: float | None = None,
        settle: bool = False,
        events: Any = (),
        most_touches: int = 100_000,
        progress: bool | Callable[[float], object] = False,
    ) -> Trajectory:
        """Simulate how the drives move when nobody moves them.

        The drives of the scene are its free coordinates; held joints hold. All loops stay closed to
        rounding, in positions and velocities.

        Args:
            duration: [s]; the simulation begins at time 0.
            position: of drives at the start [rad or m]: a number, `(d,)`, or names to numbers, of
                other joints as well; where the scene starts if None.
            speed: likewise [rad/s or m/s]; at rest if None.
            motion: drives that are moved: to a constant speed; a function of time that returns
                position, speed and acceleration; three functions; or times and positions.
            loads: joints and links to what acts there instead of in the scene: a value, or a
                function of `(time)` or `(time, position, speed)`, the latter two by joint names.
                What acts for less than 1/200 of the duration may be overlooked; a `step` that is
                shorter sees it.
            rtol: relative tolerance of each step.
            atol: absolute tolerance [rad, fractions of the characteristic length, and of the
                greatest speed at the start]; like `rtol` if None.
            method: see `cardan_dyn.simulation`; the first of them that suits if None.
            step: length of all steps [s], instead of tolerances.
            settle: start where the fast modes of stiff springs rest, near the given start.
            events: `Event`, or functions like those of loads that pass through zero.
            most_touches: touches of pins with play (`PinContact`) after which it ends.
            progress: True for a bar, or a function of the fraction done, or of that and of what is
                to be said, such as that steps are many and when they would end.

        Raises:
            ArgumentError: a value is not finite or out of range, start values that contradict each
                other, or a method that does not suit.
            ModelError: unknown joint or link, or no body has mass.
            MobilityError: the motion of every drive is prescribed.
            AssemblyError: the loops cannot be closed at the start.
            SingularConfigurationError: the start is a dead point of the drives.
            SimulationError: it could not go on; with the trajectory up to there.
        """
        from ..simulation.setup import Asked
        from ..simulation.simulate import simulated  # Most scripts simulate nothing.

        start, rest = (position, speed, motion, loads), (progress, step, settle, most_touches)
        return simulated(
            self._solver,
            Asked(duration, *start, rtol, atol, method, events, *rest),
        )

    def equilibrium(
        self,
        position: ArrayLike | Mapping[str, float] | None = None,
        *,
        loads: Mapping[str, object] | None = None,
        gravity: ArrayLike | None = None,
    ) -> Equilibrium:
        """Find where the drives rest when nobody holds them, near a position.

        Newton's method on the efforts that the drives need at rest finds stable and unstable
        equilibria alike; `Equilibrium.stability` tells which it is.

        Args:
            position: where to begin, see `simulate`.
            loads: joints and links to what acts on them instead of in the scene.
            gravity: `(3,)` [m/s²] instead of the scene's.

        Raises:
            ArgumentError: a value is not finite, or has a wrong shape.
            ModelError: unknown joint or link.
            EquilibriumError: none was found.
            CardanError: as `sweep`, at the start.
        """
        from ..simulation.equilibrium import equilibrium  # Most scripts ask for none.

        with np.errstate(over="ignore", invalid="ignore"):  # What overflows is no equilibrium.
            return equilibrium(self._solver, position, loads, gravity)
