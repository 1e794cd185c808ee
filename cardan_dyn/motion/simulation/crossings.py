"""Crossings: steps over configurations in which assembly modes meet.

A parallelogram passes the position in which all its bars are in line, where an antiparallelogram
begins as well. There closure equations lose rank, while the motion is as smooth as elsewhere. What
accelerations are worth falls with the square of the distance from there, so a step is placed so
that none of its stages is near, and stages are closed before they are asked for accelerations: off
the closed positions these change with the inverse of the distance.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

from ...core.kinematics.tolerances import SINGULAR_CONDITION
from ...kit.arrays import EPS, NOTHING, ROUNDED, Array
from ...kit.errors import SingularConfigurationError
from ...kit.extremes import peak
from .constrained_model import ConstrainedModel

Path = Callable[[float], Array]
"""Coordinates `(size,)` at a time."""

_LOOKED_AT = 12
"""Pieces of two steps, of which one is ahead, at whose ends closures are looked at."""


def refuse_rounding(part: float) -> None:
    """Refuse a start of whose speeds rounding decides a part.

    Raises:
        SingularConfigurationError: too great a part.
    """
    if part > EPS * SINGULAR_CONDITION:
        raise SingularConfigurationError(
            "the start is so close to a singular configuration that rounding decides "
            f"{part:.0e} of its speeds; begin farther from there"
        )


def notes_of_rounding(part: float, rtol: float) -> list[str]:
    """Return what a user should know where rounding decides a part of speeds.

    Args:
        part: of the speeds.
        rtol: relative tolerance of a step.

    Raises:
        SingularConfigurationError: all of them.
    """
    if part > 1.0:
        raise SingularConfigurationError(
            "the motion comes so close to a singular configuration that rounding decides all of "
            "its speeds, and with them the way on: begin with another speed or position, end "
            "before, or give the mechanism clearance, a spring or other lengths there"
        )
    if part <= max(NOTHING, rtol):
        return []
    return [
        "close to a singular configuration: there rounding of lengths and positions decides "
        f"{part:.0e} of the speeds"
    ]


class Crossings:
    """Finds crossings on the way of a simulation.

    Attributes:
        model: of the mechanism.
    """

    def __init__(self, model: ConstrainedModel, size: int) -> None:
        """Make it.

        Args:
            model: see the attribute.
            size: number of coordinates in a row of the integration.
        """
        self.model, self._size = model, size

    def begin(self) -> None:
        """Forget what closures were like so far."""
        for chain in self.model.chains:
            chain.was_weak = False

    @property
    def may_be_near(self) -> bool:
        """Whether a closure equation has been weak since `begin`."""
        # At every step: of so few, `any` over a generator takes three times as long.
        for chain in self.model.chains:  # noqa: SIM110
            if chain.was_weak:
                return True
        return False

    @contextmanager
    def stages_closed(self) -> Iterator[None]:
        """Let accelerations be those of the closed states beside those that are asked for."""
        for chain in self.model.chains:
            chain.closes_stages = True
        try:
            yield
        finally:
            for chain in self.model.chains:
                chain.closes_stages = False

    def time(self, rows: Path, start: float, end: float) -> float | None:
        """Return when a crossing is reached, None if there is none.

        Args:
            rows: of the integration, also a little after the end.
            start: of a step [s].
            end: of the step [s].
        """
        # A crossing may be close to the start.
        parts = (np.arange(_LOOKED_AT + 1) / _LOOKED_AT) ** 2
        times = start + 2.0 * (end - start) * parts
        weakness = np.array([self._weakness(rows, time) for time in times.tolist()])
        least = int(np.argmin(weakness))
        if least in (0, _LOOKED_AT):
            return None
        around = float(times[least - 1]), float(times[least + 1])
        # Weakness falls and rises linearly: its square is a parabola.
        return peak(lambda time: -(self._weakness(rows, time) ** 2), *around)[0]

    def is_one(self, row: Array) -> bool:
        """Return whether loops are closed in the singular configuration that is near a row."""
        return self.model.singular_gap(row[: self._size]) <= ROUNDED

    def _weakness(self, rows: Path, time: float) -> float:
        return self.model.weakness(rows(time)[: self._size])
