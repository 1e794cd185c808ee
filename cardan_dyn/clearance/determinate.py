"""Determinate: whether the force across a pin is known, and if not, which part of it is open.

Flags of uniqueness belong to the components along a joint's frame. Where the pin's axis is along
none of these, a force along the pin that is open makes all of them open, and what decides is
whether the pin gives way once its joint is open: a force is unique if what it presses can move.
Where it is not, compliances may decide the force, but rigid links leave no mass that it moves.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..dynamics.problem_solver import ProblemSolver
from ..response.operating_points import solved_motion
from .opened_joint import OpenedJoint

if TYPE_CHECKING:
    from ..results.sweep import Sweep

_ALONG = 1e-9
"""Component of a unit vector that counts as none."""
_POSITIONS = 12
"""At which it is tried whether a pin gives way."""


def what_is_open(solver: ProblemSolver, sweep: Sweep, name: str) -> str:
    """Return why the force across a pin is not known; empty if it is.

    Args:
        solver: of the scene.
        sweep: of it, with the joint among its outputs.
        name: of a joint that turns about one axis.
    """
    axis = np.abs(sweep.mechanism.joint(name).parts[0].axis)
    is_open = ~np.asarray(sweep[name].unique[:3]) & (axis < 1.0 - _ALONG)
    if not np.any(is_open):
        return ""
    if np.count_nonzero(axis > _ALONG) > 1 and _gives_way(solver, sweep, name):
        return ""
    names = "".join(letter for letter, bad in zip("xyz", is_open, strict=True) if bad)
    return (
        f"its force {names} is statically indeterminate: other joints hold its pin there, whatever "
        "its clearance; free the mechanism of what holds it twice"
    )


def _gives_way(solver: ProblemSolver, sweep: Sweep, name: str) -> bool:
    """Return whether an open joint can move along both directions across its pin."""
    problem = solver.problem
    fixed = problem.mechanism.coordinates.rates_of([*problem.independent, *problem.held])
    opened = OpenedJoint(problem.mechanism, name, fixed, {})
    chosen = np.linspace(0, len(sweep) - 1, min(len(sweep), _POSITIONS)).astype(int)
    positions = np.asarray(sweep.position)[chosen]
    zeros = np.zeros(len(positions))
    return all(opened.gives_way(x) for x in solved_motion(solver, positions, zeros, zeros)._x)
