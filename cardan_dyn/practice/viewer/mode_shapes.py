"""Mode shapes: the free coordinates of a scene swinging as in one of its modes, for the viewer."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...core.results.sweep import Sweep
from ...kit.checks import described, number, numbers, whole
from ...kit.errors import ArgumentError


def mode_sweep(
    scene: Any,
    shape: ArrayLike,
    *,
    size: float = 0.1,
    position: float = 0.0,
    rest: ArrayLike = 0.0,
    turns: int = 0,
    cycles: int = 1,
    samples: int = 181,
) -> Sweep:
    """Return a scene whose free coordinates swing as in a mode, larger than life.

    `cd.view(mode_sweep(...), moments=False, forces=False, swings=scene.free)` shows it. The sweep
    is without inertia: what its joints carry is what the springs exert.

    Args:
        scene: one drive that turns, and n free coordinates.
        shape: of the mode `(n,)`, complex where coordinates are out of phase, as in whirl.
        size: greatest swing [rad, of slides characteristic lengths of the mechanism].
        position: of the drive [rad].
        rest: of the free coordinates, a number or `(n,)`, about which they swing [rad or m].
        turns: of the drive meanwhile, so that whirl can be told from rotation.
        cycles: of the mode.
        samples: of the sweep.

    Returns:
        A sweep over one dimension, whose last sample is where the first one is.

    Raises:
        ArgumentError: the shape does not fit the free coordinates, is not finite or zero, or a
            number is out of range.
        CardanError: as `Scene.sweep`; a smaller `size` may help where loops cannot be closed.
    """
    free = scene.free
    coordinates = np.asarray(shape)
    if coordinates.shape != (len(free),) or coordinates.dtype.kind not in "fciu":
        raise ArgumentError(
            f"shape is {described(shape)}, expected {len(free)} numbers, one for each of the free "
            f"coordinates {', '.join(free) or '(none)'}"
        )
    # What counts as one of each coordinate: 1 rad, or the characteristic length [m].
    slides = [scene.mechanism.drivable[name].slides for name in free]
    units = np.where(slides, scene.mechanism.characteristic_length, 1.0)
    greatest = float(np.max(np.abs(coordinates) / units, initial=0.0))
    if not (np.isfinite(greatest) and greatest > 0.0):
        raise ArgumentError(f"shape is {described(shape)}, expected finite numbers, not all zero")
    scale, start = number("size", size), number("position", position)
    phase = np.linspace(0.0, 2.0 * np.pi, whole("samples", samples))[:, None]
    swing = np.real(coordinates / greatest * np.exp(1j * whole("cycles", cycles) * phase))
    middle = np.broadcast_to(numbers("rest", rest), coordinates.shape)
    drive = start + _turns(turns) * phase
    every = scene.replace(drive=scene.coordinates)
    found: Sweep = every.sweep(np.concatenate([drive, middle + scale * swing], axis=1))
    return found


def _turns(value: int) -> int:
    """Return a whole number, of either sense."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise ArgumentError(f"turns is {described(value)}, expected a whole number")
    return int(value)
