"""Tasks: what an analysis of a drive line is asked for, checked."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..arrays import Array
from ..checks import described, number, numbers, several, vector, whole
from ..errors import ArgumentError
from .line_data import LineData
from .variants import Variants

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

_DEGREES = {False: 1, True: 5}
"""Step of the positions, without and with variants [°]."""
_SLIPPING = {None: 0, "out": 1, "in": -1}


class Task(NamedTuple):
    """What is asked for.

    Attributes:
        speed: of the input shaft [rad/s].
        acceleration: of the input shaft [rad/s²].
        torque: `()` or `(P,)` [N·m].
        at_output: whether the torque is that of the output shaft, not of the input shaft.
        positions: `(P,)` of the input shaft [rad].
        gravity: `(3,)` [m/s²].
        slipping: 1 if splines are drawn out, -1 if they are pushed in, 0 without friction.
        variants: designs; None for the line as it is.
        workers: see `Scene.sweep`.
    """

    speed: float
    acceleration: float
    torque: Array
    at_output: bool
    positions: Array
    gravity: Array
    slipping: int
    variants: Variants | None
    workers: int


def task(
    line: LineData,
    *,
    speed: float | None,
    torque: ArrayLike | None,
    positions: ArrayLike | None,
    acceleration: float,
    torque_at: str,
    gravity: ArrayLike | None,
    slipping: str | None,
    variants: Variants | None,
    workers: int,
) -> Task:
    """Return a task; see `DriveLine.analyse`."""
    if variants is not None and not isinstance(variants, Variants):
        raise ArgumentError(f"variants is {described(variants)}, expected what variants() returns")
    if variants is not None and variants.shafts != line.shafts:
        raise ArgumentError("variants are those of another line; make them of this one")
    if not isinstance(torque_at, str) or torque_at not in ("input", "output"):
        raise ArgumentError(f"torque_at is {described(torque_at)}, expected 'input' or 'output'")
    if slipping is not None and (not isinstance(slipping, str) or slipping not in _SLIPPING):
        raise ArgumentError(f"slipping is {described(slipping)}, expected 'in', 'out' or None")
    step = _DEGREES[variants is not None]
    if positions is None:
        angles = np.radians(np.arange(0.0, 360.0, step))
    else:
        angles = several("positions", positions)
    torques = numbers("torque", _given("torque", torque, line.torque))
    if torques.shape not in ((), angles.shape):
        raise ArgumentError(
            f"torque has shape {torques.shape}, expected a number or a value per position "
            f"{angles.shape}"
        )
    return Task(
        speed=number("speed", _given("speed", speed, line.speed)),
        acceleration=number("acceleration", acceleration),
        torque=torques,
        at_output=torque_at == "output",
        positions=angles,
        gravity=np.zeros(3) if gravity is None else vector("gravity", gravity, 3),
        slipping=_SLIPPING[slipping],
        variants=variants,
        workers=whole("workers", workers),
    )


def _given(name: str, value: ArrayLike | None, of_line: float | None) -> ArrayLike:
    """Return an argument, or what the line says."""
    if value is not None:
        return value
    if of_line is None:
        raise ArgumentError(f"{name} is given neither here nor by the line; give {name}=")
    return of_line
