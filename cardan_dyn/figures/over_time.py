"""Over time: wrenches of joints, and the energies of a trajectory with what is wrong with them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Unpack

import numpy as np

from ..kit.arrays import Array
from ..kit.checks import names
from ..kit.errors import ArgumentError
from .style import Abscissa, Figure, Onto, Swept, in_look, over, refuse_grid, sheet
from .wrenches import wrench_panels


@in_look
def over_time(
    turn: Swept,
    joints: str | Sequence[str],
    quantities: str | Sequence[str] = ("torsion", "bending"),
    *,
    peaks: bool | None = None,
    **onto: Unpack[Onto],
) -> Figure:
    """Draw torsion and bending of joints, or their forces, over time.

    What is drawn is exerted by the parent link on the child link, at the joint origin. A star marks
    what statics leaves open.

    Args:
        turn: a trajectory, or a sweep that was given its times (`sweep(..., time=)`).
        joints: one joint or several; each is a line.
        quantities: of `torsion`, `bending`, `axial`, `shear`; each has its own axes.
        peaks: see `over_angle`.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`;
            as many axes as there are quantities.

    Raises:
        ModelError: a joint is unknown, not among the outputs, or has no axis.
        ArgumentError: unknown quantity, a sweep without times, or one over several dimensions;
            another number of axes.
    """
    at, given = times_of(turn), names("quantities", quantities)
    return wrench_panels(turn, names("joints", joints), at, given, peaks=peaks, **onto)


@in_look
def energy_over_time(trajectory: Swept, **onto: Unpack[Onto]) -> Figure:
    """Draw the energies of a trajectory, the work done on it, and the residual of their balance.

    The residual at each time is the size of the change of kinetic and potential energy since the
    first of the times, less the work since then, as a fraction of `Trajectory.energy_scale`, to a
    logarithmic scale. `Trajectory.energy_residual` counts from the start of the simulation.

    Args:
        trajectory: the trajectory.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`;
            two axes.

    Raises:
        ArgumentError: it is no trajectory, or other than two axes.
        CardanError: as `Trajectory.work`.
    """
    if not hasattr(trajectory, "kinetic_energy"):
        raise ArgumentError(
            f"energies are those of a trajectory, not of a {type(trajectory).__name__}; "
            "Scene.simulate() returns one"
        )
    time = trajectory.time
    energies = {
        "kinetic energy": trajectory.kinetic_energy,
        "potential energy, from its start": trajectory.potential_energy
        - trajectory.potential_energy[0],
        "work": trajectory.work - trajectory.work[0],
    }
    kinetic, potential, work = energies.values()
    drawn = sheet(2, size=(7.2, 6.0), share_x=True, **onto)
    above, below = drawn.panels
    at = over("time", time, "s")
    at.draw(above, energies)
    scale = trajectory.energy_scale or 1.0
    residual = np.abs(kinetic - kinetic[0] + potential - work) / scale
    # A logarithm knows no zero: half the rounding of a number stands for it.
    shown = {"residual": np.maximum(residual, 1e-16)}
    at.draw(below, shown, color="0.25", linewidth=1.0, label="")
    below.set_yscale("log")
    above.set_ylabel("energy [J]")
    below.set_ylabel("residual of the balance [–]")
    drawn.over(at)
    return drawn.finish(columns=3)


def times_of(turn: Swept) -> Abscissa:
    """Return the times of the samples, to be drawn over."""
    refuse_grid(turn)
    if turn.time.ndim != 1:
        raise ArgumentError(
            "the sweep has no times over which it could be drawn: give sweep(..., time=), or draw "
            "it over_angle"
        )
    times: Array = np.broadcast_to(turn.time, turn.shape)
    return over("time", times, "s")
