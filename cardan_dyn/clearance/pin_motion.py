"""Pin motion: what the pin of a scanned joint does in its bush, turn by turn, once it is asked."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..arrays import Array
from ..response.operating_points import solved_motion
from .planar_motion import MOST_STEPS, PinContactNumbers, PlanarModel, PlanarMotion, Touch

if TYPE_CHECKING:
    from .force_course import ForceCourse
    from .force_source import ForceSource
    from .opened_joint import OpenedJoint

_PLACES = 240
"""Positions over a period at which masses are asked for; their series goes on between."""
_PERIODS = 6.25
"""That a pin is followed: it never forgets how it slid, and no two turns are alike."""
_STEPS = 12.0
"""In a swing of the contact, at least."""
_SETTLED = 0.25
"""Of a period, after which reversals count, as in comparisons with simulations."""


class Passages(NamedTuple):
    """A reversal in each of `K` turns.

    Attributes:
        greatest: `(K,)` force until the next reversal [N].
        struck: `(K,)` greatest force until a swing of the contact after the hardest strike, or
            after the time of the flight along a line [N].
        speed: `(K,)` of this strike, normal to the wall [m/s]; 0 if the pin stays on its wall.
        gap: `(K,)` greatest distance from the wall on the way, as a fraction of half the play.
    """

    greatest: Array
    struck: Array
    speed: Array
    gap: Array


class PinMotion:
    """The motion of one pin, found when it is first asked for; the same for all reversals.

    Attributes:
        contact: what the pin touches.
        length: of the mechanism, beside which offsets are small [m].
        swing: duration of a swing of the contact with the joint's mean mass [s].
    """

    def __init__(
        self,
        opened: OpenedJoint,
        source: ForceSource,
        course: ForceCourse,
        contact: PinContactNumbers,
        mass: float,
        speed: float,
        period: float,
    ) -> None:
        """Keep what is needed.

        Args:
            opened: the mechanism with this joint open, its drive's motion prescribed.
            source: of closed positions.
            course: of the force without play.
            contact: what the pin touches.
            mass: mean of the joint [kg].
            speed: of the drive [rad/s].
            period: of the drive [rad].
        """
        self._asked = opened, source, course
        self.contact, self._speed, self._period = contact, speed, period
        self.length = source.problem.mechanism.characteristic_length
        self.swing = 2.0 * math.pi * math.sqrt(mass / contact.stiffness)

    def __getstate__(self) -> dict[str, object]:
        # A copy has what was found, and not the mechanism.
        self._motion  # noqa: B018
        return {name: value for name, value in vars(self).items() if name != "_asked"}

    @cached_property
    def _motion(self) -> PlanarMotion:
        opened, source, course = self._asked
        positions = self._period / _PLACES * np.arange(_PLACES)
        zeros = np.zeros(_PLACES)
        closed = solved_motion(source.solver, positions, zeros + 1.0, zeros)
        plane = opened.plane(closed._x, closed.v, course.at(positions), self._period)
        return PlanarModel(plane, self.contact, self._speed).run(_PERIODS)

    @property
    def is_followed(self) -> bool:
        """Whether the pin can be followed until every reversal has settled.

        Not where its contact swings more often in a turn than there is time for.
        """
        return _STEPS * (2.0 + _SETTLED) * self._turn < MOST_STEPS * self.swing

    @property
    def _turn(self) -> float:
        return self._period / abs(self._speed)

    def passages(self, position: float, way: float, flight: float) -> Passages:
        """Return what the pin did from a position on, in every turn.

        Args:
            position: of the drive [rad].
            way: that the drive turns from there [rad].
            flight: how long the pin flies along a line [s].
        """
        motion, turn = self._motion, self._turn
        begun, lasts = float(motion.time[0]), way / abs(self._speed)
        first = (position / self._speed - begun) % turn
        starts = begun + first + turn * np.arange(math.ceil(_PERIODS) + 1)
        starts = starts[(starts >= begun + _SETTLED * turn) & (starts + lasts <= motion.end)]
        rows = [self._passage(motion, start, start + lasts, flight) for start in starts.tolist()]
        return Passages(*np.array(rows).reshape(-1, 4).T)

    def _passage(
        self, motion: PlanarMotion, start: float, end: float, flight: float
    ) -> tuple[float, ...]:
        """Return the numbers of one passage."""
        inside = [item for item in motion.touches if start <= item.time < end]
        hardest = max(inside, key=lambda item: item.speed, default=Touch(start, 0.0, 0.0))
        until = max(hardest.time, start + flight) + self.swing
        gap = max((item.gap for item in inside), default=0.0) / (0.5 * self.contact.clearance)
        return (
            motion.greatest(start, end),
            motion.greatest(start, min(until, end)),
            max(hardest.speed, 0.0),
            gap,
        )
