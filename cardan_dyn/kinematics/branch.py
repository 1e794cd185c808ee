"""Branch: follow one way of assembling the mechanism along its drive.

A branch keeps closed positions with their first and second derivatives as nodes and interpolates
between them. Its guesses are so near that Newton's method cannot jump to another way of
assembling the mechanism.
"""

from __future__ import annotations

from copy import copy
from functools import partial

import numpy as np

from ..arrays import Array
from ..errors import AssemblyError, CardanError, SingularConfigurationError
from .all_groups import ClosedState, Kinematics
from .stacked import same_side
from .step_control import WORST, StepControl, room
from .tolerances import CLOSURE_TOLERANCE, SAFE_CORRECTION, SINGULAR_CONDITION

_FOLLOWED = 1e7  # Condition from which on rounding decides which way goes on.
_STEEP = 100.0  # Rate of a joint near a dead point, where it grows without bound.
_GUESS_CORRECTION = 2e-16  # How far an interpolation may be off to need no Newton step.
_ENOUGH = 2**62  # More nodes than anybody asks for: the branch is known to rounding.
_TURNS_TRIED = 12


class Branch:
    """One way of assembling the mechanism, followed along its drive.

    Attributes:
        unit: what counts as one radian's worth of the drive: 1 for angles, a length for slides.
        period: drive displacement after which every body is where it was, or None.
        windings: `(size,)` turns of every coordinate in one period.
    """

    def __init__(
        self, kinematics: Kinematics, start: Array, drive_column: int, unit: float
    ) -> None:
        self.kinematics = kinematics
        self.drive_column = drive_column
        self.unit = unit
        self.period: float | None = None
        self.windings = np.zeros(start.size)
        self._most = 0
        self._closed: dict[int, CardanError] = {}
        self._positions = np.zeros(0)
        self._nodes = np.zeros((0, 3, start.size))
        self._insert(self._node(kinematics.evaluate(start[None, :])))

    @property
    def span(self) -> tuple[float, float]:
        """Drive positions between which the branch is known."""
        return float(self._positions[0]), float(self._positions[-1])

    def cover(self, low: float, high: float) -> None:
        """Follow the branch until it spans drive positions `low` to `high`.

        Raises:
            AssemblyError: a position cannot be reached.
            SingularConfigurationError: a dead point lies on the way.
        """
        known_low, known_high = self.span
        if low >= known_low and high <= known_high:
            return
        for end, beyond in ((0, low < known_low), (-1, high > known_high)):
            if beyond and end in self._closed:
                # What stopped it once is not to be got round by starting closer to it.
                raise copy(self._closed[end])
        known = self._positions, self._nodes, dict(self._closed)
        safe = self._most > 0 or len(self._positions) == 1
        self._most = 0  # What is new is as coarse as the steps that follow it.
        try:
            # One Newton step per node; the others are taken for all at once, and prove them.
            self._follow(low, high, roughly=True)
            if self._prove(known_low, known_high):
                self._most = len(self._positions) if safe else 0
                return
        except (AssemblyError, SingularConfigurationError):
            pass
        self._positions, self._nodes, self._closed = known
        self._follow(low, high, roughly=False)

    def _follow(self, low: float, high: float, roughly: bool) -> None:
        """Insert nodes step by step, on both sides at once; see `cover`.

        Args:
            low: drive position to reach.
            high: drive position to reach.
            roughly: take one Newton step per node, which leaves an error of its square.
        """
        targets = [
            (end, sign, target)
            for end, sign, target in ((0, -1.0, low), (-1, 1.0, high))
            if sign * (target - self._positions[end]) > 0.0
        ]
        here = self.kinematics.evaluate(self._nodes[[end for end, _, _ in targets], 0])
        fronts = []
        for (end, sign, target), condition in zip(targets, here.condition.tolist(), strict=True):
            if condition > SINGULAR_CONDITION:
                self._refuse(target, end, 0.0, condition)
            fronts.append(StepControl(end, sign, target, self.unit, 1.0 / condition))
        inverses = here.inverses
        while fronts:
            ends = [front.end for front in fronts]
            positions = np.array([front.ahead(self._positions[front.end]) for front in fronts])
            steps = np.abs(positions - self._positions[ends])
            guess = self._ahead(ends, positions)
            close = (
                self.kinematics.newton_step if roughly else partial(self.kinematics.close, most=6)
            )
            found = close(guess)
            with np.errstate(all="ignore"):  # What is not closed is not used.
                side = self.kinematics.same_side(found, inverses)
                nodes = self._node(found)
                off = np.maximum(found.correction, self._back(nodes, ends))
                should = room(found.condition)
                # A long step can land on another way of assembling it, just as closed.
                good = (off < WORST * should) & side & (found.condition < _FOLLOWED)
                good &= roughly | (found.residual < CLOSURE_TOLERANCE)
            self._insert(nodes[good])
            for row, (front, accepted, bad) in enumerate(
                zip(fronts, good.tolist(), (off / should).tolist(), strict=True)
            ):
                if accepted:
                    front.arrive(float(steps[row]), bad, 1.0 / float(found.condition[row]))
                else:
                    front.fall_back()
                if front.stopped and front.left(self._positions[front.end]) > 0.0:
                    # Where it could go on, it is the way on that is not unique.
                    residual = 0.0 if accepted else float(found.residual[row])
                    condition = float(found.condition[row])
                    self._refuse(positions[row], front.end, residual, condition)
            left = [
                row
                for row, front in enumerate(fronts)
                if front.left(self._positions[front.end]) > 0.0
            ]
            inverses = [
                np.where(good[:, None, None], new, old)[left]
                for new, old in zip(found.inverses, inverses, strict=True)
            ]
            fronts = [fronts[row] for row in left]

    def _prove(self, low: float, high: float) -> bool:
        """Close the nodes outside of a span for good; return whether each leads to the next."""
        new = (self._positions <= low) | (self._positions >= high)
        positions = self._positions[new]
        found = self.kinematics.close(self._nodes[new, 0])
        if np.any(~(found.residual < CLOSURE_TOLERANCE) | (found.correction > SAFE_CORRECTION)):
            return False
        nodes = self._node(found)
        step = np.diff(positions)
        ahead = self._extrapolated(nodes[:-1], step) - nodes[1:, 0]
        back = self._extrapolated(nodes[1:], -step) - nodes[:-1, 0]
        off = np.maximum(np.abs(ahead), np.abs(back)) * self.kinematics.coordinates.scale
        should = room(found.condition)
        fine = off.max(axis=1) < WORST * np.minimum(should[:-1], should[1:])
        for closed in found.groups:
            fine &= same_side(closed.passive_rows[1:], closed.inverse[:-1])
        # Between the ends of the span lie nodes that were proven before.
        fine |= (positions[:-1] == low) & (positions[1:] == high)
        self._nodes[new] = nodes
        return bool(np.all(fine))

    def find_period(self) -> bool:
        """Follow the branch over whole turns of the drive until it repeats, if it does."""
        for turns in range(1, _TURNS_TRIED + 1):
            period = turns * 2.0 * np.pi
            low, high = self.span
            missing = period - (high - low)
            if missing > 0.0:
                self.cover(low - 0.5 * missing, high + 0.5 * missing)
            low = self.span[0]
            ends = self.guess(np.array([low, low + period]))
            if missing < 0.0:
                ends = self.kinematics.close(ends).x
            moved = ends[1] - ends[0]
            windings = np.zeros(moved.size)
            angles = self.kinematics.coordinates.angle_columns
            windings[angles] = np.round(moved[angles] / (2.0 * np.pi))
            if np.allclose(moved, 2.0 * np.pi * windings, rtol=0.0, atol=1e-7):
                self.period, self.windings = period, windings
                return True
        return False

    def refine(self, kinematics: Kinematics, most: int) -> None:
        """Halve intervals until guesses are exact to rounding, or there are `most` nodes.

        Guesses are made safe in any case.

        Args:
            kinematics: with the rows that are known to be independent.
            most: number of nodes.

        Raises:
            AssemblyError: the branch cannot be resolved.
        """
        if most < 2 * self._most:
            return
        self._most = most
        open_intervals = np.ones(len(self._positions) - 1, dtype=bool)
        while np.any(open_intervals):
            left = np.nonzero(open_intervals)[0]
            middle = 0.5 * (self._positions[left] + self._positions[left + 1])
            found = kinematics.close(self.guess(middle))
            unsafe = found.correction > SAFE_CORRECTION
            if np.any(unsafe):
                nodes = kinematics.evaluate(self._nodes[left, 0])
                lost = unsafe & ~kinematics.same_side(found, nodes.inverses)
                lost |= found.correction > 0.5
                if np.any(lost):
                    first = int(np.argmax(lost))
                    raise SingularConfigurationError(
                        f"the branch cannot be resolved near drive position {middle[first]:.9g}: "
                        f"the closure equations have condition {nodes.condition[first]:.1e} there",
                        position=float(middle[first]),
                        condition=float(nodes.condition[first]),
                    )
            # Halving an interval divides the interpolation's error by 2**6.
            wanted = _GUESS_CORRECTION if len(self._positions) < most else 0.1 * SAFE_CORRECTION
            coarse = found.correction / 64.0 > wanted
            flags = np.zeros((len(open_intervals), 2), dtype=bool)
            flags[left] = coarse[:, None]
            split = np.stack([np.ones_like(open_intervals), open_intervals], axis=1)
            self._insert(self._node(found))
            open_intervals = flags[split]
            if not np.any(coarse) and wanted == _GUESS_CORRECTION:
                self._most = _ENOUGH

    def guess(self, positions: Array) -> Array:
        """Return `(N, size)` coordinates near the branch, exact in the drive's coordinate.

        Quintic Hermite interpolation of values, first and second derivatives.
        """
        known = self._positions
        if len(known) == 1:
            rows = np.repeat(self._nodes[:, 0], len(positions), axis=0)
        else:
            left = np.clip(np.searchsorted(known, positions) - 1, 0, len(known) - 2)
            width = known[left + 1] - known[left]
            t = ((positions - known[left]) / width)[:, None]
            h = width[:, None]
            f, g = self._nodes[left], self._nodes[left + 1]
            d = g[:, 0] - f[:, 0]
            f1, g1, f2, g2 = h * f[:, 1], h * g[:, 1], h * h * f[:, 2], h * h * g[:, 2]
            c3 = 10.0 * d - 6.0 * f1 - 4.0 * g1 - 1.5 * f2 + 0.5 * g2
            c4 = -15.0 * d + 8.0 * f1 + 7.0 * g1 + 1.5 * f2 - g2
            c5 = 6.0 * d - 3.0 * (f1 + g1) + 0.5 * (g2 - f2)
            rows = f[:, 0] + t * (f1 + t * (0.5 * f2 + t * (c3 + t * (c4 + t * c5))))
        rows[:, self.drive_column] = positions
        return self.kinematics.coordinates.normalised(rows)

    def states(self) -> Array:
        """Return coordinates `(K, size)` of closed positions all over the branch."""
        return self._nodes[:, 0]

    def _ahead(self, ends: list[int], positions: Array) -> Array:
        """Continue from ends of the branch by their Taylor polynomials, `(E, size)`."""
        rows = self._extrapolated(self._nodes[ends], positions - self._positions[ends])
        rows[:, self.drive_column] = positions
        return self.kinematics.coordinates.normalised(rows)

    def _back(self, nodes: Array, ends: list[int]) -> Array:
        """Return how far off the coordinates of ends new nodes' Taylor polynomials put them.

        Towards a dead point the derivatives grow without bound: a step can be short enough to
        extrapolate to its end, and too long to interpolate over it.
        """
        step = self._positions[ends] - nodes[:, 0, self.drive_column]
        away = self._extrapolated(nodes, step) - self._nodes[ends, 0]
        return np.asarray(np.max(np.abs(away) * self.kinematics.coordinates.scale, axis=1))

    @staticmethod
    def _extrapolated(nodes: Array, step: Array) -> Array:
        step = step[:, None]
        return np.asarray(nodes[:, 0] + step * (nodes[:, 1] + 0.5 * step * nodes[:, 2]))

    def _node(self, closed: ClosedState) -> Array:
        """Return coordinates, their first and their second derivative, `(N, 3, size)`."""
        kinematics, coordinates = self.kinematics, self.kinematics.coordinates
        ones = np.ones((len(closed.x), 1))
        v = kinematics.rates(closed, ones)
        a = kinematics.accelerations(closed, v, 0.0 * ones)
        return np.stack(
            [
                closed.x,
                coordinates.derivative(closed.x, v),
                coordinates.curvature(closed.x, v, a),
            ],
            axis=1,
        )

    def _insert(self, nodes: Array) -> None:
        positions = np.concatenate([self._positions, nodes[:, 0, self.drive_column]])
        order = np.argsort(positions, kind="stable")
        self._positions = positions[order]
        self._nodes = np.concatenate([self._nodes, nodes])[order]

    def limit(self, target: float) -> float:
        """Return how far towards `target` the branch can be followed, ±inf if all the way."""
        try:
            self.cover(min(target, self.span[0]), max(target, self.span[1]))
        except AssemblyError as error:
            return float(error.details["nearest"])  # type: ignore[arg-type]
        except SingularConfigurationError as error:
            return float(error.details["position"])  # type: ignore[arg-type]
        return float(np.copysign(np.inf, target - self._positions[0]))

    def _refuse(self, position: float, end: int, residual: float, condition: float) -> None:
        """Raise what stops the branch at one of its ends, on the way to `position`.

        Args:
            position: where the branch should go.
            end: which end.
            residual: closure error of what was found on the way.
            condition: its condition number.
        """
        nearest = self._last_position(end)
        if residual < CLOSURE_TOLERANCE or condition > SINGULAR_CONDITION:
            condition = float(self.kinematics.evaluate(self._nodes[[end], 0]).condition[0])
            self._closed[end] = SingularConfigurationError(
                f"the mechanism cannot be followed past drive position {nearest:.9g}: the closure "
                f"equations become singular there (condition {condition:.1e}), and the way on is "
                "not unique; sweep on one side of it or choose another drive",
                position=nearest,
                condition=condition,
            )
        else:
            self._closed[end] = AssemblyError(
                f"the loops cannot be closed at drive position {position:.9g}; the nearest "
                f"position that can be reached is {nearest:.9g}, a dead point of the drive",
                position=position,
                nearest=nearest,
                residual=residual,
            )
        raise self._closed[end]

    def _last_position(self, end: int) -> float:
        """Return where the drive's range ends, from the last nodes before it.

        Near a dead point passive joints move like the square root of what is left of the range.
        Where ways meet, the margin of the closure equations falls to zero in proportion to it.
        """
        position = float(self._positions[end])
        _, slope, curvature = self._nodes[end]
        steepest = int(np.argmax(np.abs(slope)))
        if curvature[steepest] == 0.0 or len(self._positions) < 2:
            return position
        left = float(slope[steepest] / (2.0 * curvature[steepest]))
        if abs(slope[steepest]) * self.unit < _STEEP:
            before = end + 1 if end == 0 else end - 1
            here = self.kinematics.evaluate(self._nodes[[end, before], 0])
            margin, farther = (1.0 / here.condition).tolist()
            moved = position - float(self._positions[before])
            left = moved * margin / (farther - margin) if farther > margin else 0.0
        return position + left if abs(left) < 1e-4 * self.unit else position
