"""Exhaustive search for the best forks of a line, refined: slow, and blind to how lines move."""

from __future__ import annotations

import itertools

import numpy as np
from scipy.optimize import minimize

from cardan_dyn.analytic import drive_line
from cardan_dyn.drive_lines import DriveLine, Shaft

Array = np.ndarray

_GRID = {1: 360, 2: 60, 3: 20, 4: 10}
"""Values of each offset, by their number."""
_STARTS = 2


def slopes_line(count: int, rng: np.random.Generator) -> DriveLine:
    """A line of `count` joints with slopes and forks by chance."""
    return DriveLine(
        shafts=[
            Shaft(
                length=1.0,
                slope_side=rng.uniform(-0.3, 0.3),
                slope_plan=rng.uniform(-0.3, 0.3),
                fork_offset=rng.uniform(-1.5, 1.5) if 0 < k < count else 0.0,
            )
            for k in range(count + 1)
        ]
    )


def least_residual(line: DriveLine) -> float:
    """Return the least residual angle at the output [rad]."""
    betas, planes = line.joint_angles, line.geometry.plane_offsets[1:]

    def cosine(offsets: Array) -> Array:
        phases = drive_line.fork_phases(np.broadcast_to(planes, offsets.shape), offsets)
        return np.asarray(-np.cos(drive_line.residual_angle(betas, phases)))

    values = np.linspace(-np.pi / 2, np.pi / 2, _GRID[len(planes)], endpoint=False)
    every = np.array(list(itertools.product(values, repeat=len(planes))))
    found = cosine(every)
    best = float(found.min())
    for start in every[np.argsort(found)[:_STARTS]]:
        options = {"xatol": 1e-5, "fatol": 1e-12, "maxiter": 300}
        refined = minimize(lambda x: float(cosine(x)), start, method="Nelder-Mead", options=options)
        best = min(best, float(refined.fun))
    return float(np.arccos(min(-best, 1.0)))
