"""Branch: one assembly mode of the mechanism, followed along its drive.

A branch keeps closed positions with their first and second derivatives as nodes and interpolates
between them. Its guesses are so near that Newton's method cannot change the assembly mode. It is
made longer at both of its ends at once: every step has a predictor (extrapolation from the end), a
corrector (Newton's method) and step control. Steps are so short that Newton's method cannot change
the assembly mode, and shorter towards singular configurations, where assembly modes meet.
"""

from __future__ import annotations

from copy import copy
from typing import NamedTuple, Protocol

import numpy as np

from ...arrays import Array
from ...errors import AssemblyError, CardanError, SingularConfigurationError
from ...mechanism.coordinates import Coordinates
from ..closing.all_groups import ClosedState, Kinematics
from ..tolerances import CLOSURE_TOLERANCE, SAFE_CORRECTION, SINGULAR_CONDITION

_UNLIMITED = 2**62
"""More nodes than a scene ever asks for: guesses are exact to rounding, and no node is missing."""
_TURNS_TRIED = 12
"""Turns of the drive after which a mechanism is tried for repetition. Velocity ratios of small
whole numbers repeat within them. A turn costs 11 to 13 nodes, measured on the bundled universal
joint, four-bar, needle drive and double shaft."""
_PERIOD_TOLERANCE = 1e-7
"""Greatest difference [rad or m] between coordinates one period apart. It is far above the closure
tolerance, and far below any motion that a mechanism would miss its start by on purpose."""


class Branch:
    """One assembly mode of the mechanism, followed along its drive.

    Attributes:
        kinematics: solves the branch.
        unit: drive displacement that counts as one radian: 1 for angles, a length for slides.
        period: drive displacement after which every body is where it was; None if not known.
        windings: `(size,)` whole turns of every coordinate in one period.
    """

    def __init__(self, kinematics: Kinematics, start: Array) -> None:
        """Make a branch that is known at one position.

        Args:
            kinematics: solves the branch; it has one drive.
            start: `(size,)` closed coordinates.
        """
        coordinates = kinematics.coordinates
        (drive_column,) = coordinates.column_of(kinematics.drives).tolist()
        self.kinematics = kinematics
        self.unit = float(coordinates.rate_scale[kinematics.drives[0]])
        self.period: float | None = None
        self.windings = np.zeros(start.size)
        self._start = float(start[drive_column])
        self._table = table_of(kinematics, kinematics.evaluate(start[None, :]), drive_column)
        self._states_of, self._states = self._table, self._table.states
        self._ends = (LOWER, UPPER)
        # Number of nodes that it was last refined to; zero while guesses need not be safe.
        self._refined_to = 0

    @property
    def span(self) -> tuple[float, float]:
        """Drive positions between which the branch is known."""
        return self._table.span

    def cover(self, low: float, high: float) -> None:
        """Follow the branch until it spans drive positions `low` to `high`.

        What was reached is kept when an error is raised, and so is the error: another attempt
        from nearer by could step over what has stopped this one.

        Raises:
            AssemblyError: a position cannot be reached.
            SingularConfigurationError: a dead point lies on the way.
        """
        known_low, known_high = self.span
        if low >= known_low and high <= known_high:
            return
        for end, target in zip(self._ends, (low, high), strict=True):
            if end.error is not None and end.is_before(target, self._table):
                raise copy(end.error)
        was_safe = self._refined_to > 0 or self._table.size == 1
        self._refined_to = 0
        quick = BranchFollower(self.kinematics, self.unit, OneNewtonStep())
        followed = quick.follow(self._table, low, high)
        if followed.refused is None:
            table = proven(self.kinematics, followed.table, known_low, known_high)
            if table is not None:
                self._table = table
                self._refined_to = table.size if was_safe else 0
                return
        careful = BranchFollower(self.kinematics, self.unit, FullClosure())
        self._table, refused = careful.follow(self._table, low, high)
        if refused is not None and refused.error is not None:
            lower, upper = self._ends
            self._ends = (refused, upper) if refused.node == LOWER.node else (lower, refused)
            raise copy(refused.error)

    def find_period(self) -> bool:
        """Follow the branch over whole turns of the drive until it repeats, if it does.

        Returns:
            Whether it repeats; `period` and `windings` are set then.

        Raises:
            AssemblyError: the drive cannot turn through.
            SingularConfigurationError: a dead point lies on the way.
        """
        for turns in range(1, _TURNS_TRIED + 1):
            period = turns * 2.0 * np.pi
            low, high = self.span
            missing = period - (high - low)
            if missing > 0.0:
                self.cover(low - 0.5 * missing, high + 0.5 * missing)
            low = self.span[0]
            ends = self.guess(np.array([low, low + period]))
            if missing < 0.0:
                # The second position lies between nodes, where a guess is not closed.
                ends = self.kinematics.close(ends).x
            displacement = ends[1] - ends[0]
            # How far idle rods have turned about their lines says nothing about the motion.
            displacement[self.kinematics.idle_columns] = 0.0
            windings = np.zeros(displacement.size)
            angles = self.kinematics.coordinates.angle_columns
            windings[angles] = np.round(displacement[angles] / (2.0 * np.pi))
            whole_turns = 2.0 * np.pi * windings
            if np.allclose(displacement, whole_turns, rtol=0.0, atol=_PERIOD_TOLERANCE):
                self.period, self.windings = period, windings
                return True
        return False

    def refine(self, kinematics: Kinematics, node_limit: int) -> None:
        """Halve intervals until guesses are exact to rounding, or there are `node_limit` nodes.

        Guesses are made safe in any case, even with more nodes. Nothing is done before the limit
        has doubled since the last call: every call tries each interval again.

        Args:
            kinematics: with the rows that are known to be independent.
            node_limit: number of nodes from which on safe guesses suffice.

        Raises:
            SingularConfigurationError: the branch cannot be resolved.
        """
        if node_limit < 2 * self._refined_to:
            return
        self._refined_to = node_limit
        is_open = np.ones(self._table.size - 1, dtype=bool)
        while np.any(is_open):
            to_rounding = self._table.size < node_limit
            allowed = EXACT_CORRECTION if to_rounding else SAFE_GUESS_CORRECTION
            self._table, is_open = halved(self._table, kinematics, is_open, allowed)
            if to_rounding and not np.any(is_open):
                self._refined_to = _UNLIMITED

    def guess(self, positions: Array) -> Array:
        """Return `(N, size)` coordinates near the branch, exact in the drive's coordinate.

        Args:
            positions: `(N,)` drive positions within the span.
        """
        return self._table.guess(positions)

    def values(self, positions: Array, columns: Array | slice) -> Array:
        """Return `(N, k)` some coordinates near the branch, see `BranchTable.values`."""
        return self._table.values(positions, columns)

    def states(self) -> Array:
        """Return closed coordinates `(K, size)` at positions distributed over the branch.

        They are the same object until the branch gets other nodes.
        """
        if self._states_of is not self._table:
            self._states_of, self._states = self._table, self._table.states
        return self._states

    def limit(self, target: float) -> float:
        """Return how far towards `target` the branch can be followed from its start.

        Args:
            target: drive position, not that of the start.

        Returns:
            The drive position where the branch ends; ±inf, with the sign of the direction from the
            start, if it leads all the way.
        """
        try:
            self.cover(min(target, self.span[0]), max(target, self.span[1]))
        except AssemblyError as error:
            return float(error.details["nearest"])  # type: ignore[arg-type]
        except SingularConfigurationError as error:
            return float(error.details["position"])  # type: ignore[arg-type]
        return float(np.copysign(np.inf, target - self._start))


_HERMITE = np.array(
    [
        [0.0, 1.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.5, 0.0, 0.0],
        [10.0, -6.0, -1.5, -4.0, 0.5],
        [-15.0, 8.0, 1.5, 7.0, -1.0],
        [6.0, -3.0, -0.5, -3.0, 0.5],
    ]
)
"""Quintic Hermite polynomials on an interval of width one, a row per power of the share from the
first on. The columns are factors of the difference of both values, of the left node's derivatives
and of the right node's."""


class BranchTable(NamedTuple):
    """Nodes of a branch in ascending order of the drive. It is never changed.

    Attributes:
        positions: `(K,)` drive positions of the nodes [rad or m].
        nodes: `(K, 3, size)` coordinates, their first and their second derivatives with respect
            to the drive.
        drive_column: column of the drive in a row of coordinates.
        coordinates: layout of those rows.
    """

    positions: Array
    nodes: Array
    drive_column: int
    coordinates: Coordinates

    @property
    def size(self) -> int:
        """Number of nodes."""
        return len(self.positions)

    @property
    def span(self) -> tuple[float, float]:
        """Lowest and highest drive position of a node."""
        return float(self.positions[0]), float(self.positions[-1])

    @property
    def states(self) -> Array:
        """Closed coordinates `(K, size)` of all nodes."""
        return self.nodes[:, 0]

    def with_nodes(self, nodes: Array) -> BranchTable:
        """Return a table that also holds new nodes `(M, 3, size)`, given in any order."""
        positions = np.concatenate([self.positions, nodes[:, 0, self.drive_column]])
        order = np.argsort(positions, kind="stable")
        joined = np.concatenate([self.nodes, nodes])[order]
        return _table(positions[order], joined, self.drive_column, self.coordinates)

    def with_replaced(self, chosen: Array, nodes: Array) -> BranchTable:
        """Return a table in which the nodes chosen by a mask `(K,)` are replaced.

        Args:
            chosen: true for M nodes.
            nodes: `(M, 3, size)` at the same drive positions.
        """
        replaced = self.nodes.copy()
        replaced[chosen] = nodes
        return _table(self.positions, replaced, self.drive_column, self.coordinates)

    def guess(self, positions: Array) -> Array:
        """Return `(N, size)` coordinates near the branch, exact in the drive's coordinate.

        Quintic Hermite interpolation of values, first and second derivatives; a single node is
        repeated.

        Args:
            positions: `(N,)` drive positions.
        """
        return self._with_drive(self.values(positions, slice(None)), positions)

    def values(self, positions: Array, columns: Array | slice) -> Array:
        """Return `(N, k)` some coordinates near the branch; see `guess`.

        Args:
            positions: `(N,)` drive positions.
            columns: of a row; quaternions come without their unit length.
        """
        if self.size == 1:
            return np.repeat(self.nodes[:, 0, columns], len(positions), axis=0)
        left = self.positions[1:-1].searchsorted(positions)
        right, low = left + 1, self.positions[left]
        width = self.positions[right] - low
        nodes = self.nodes
        if len(positions) < self.size:
            left_nodes, right_nodes = nodes[left][:, :, columns], nodes[right][:, :, columns]
        else:
            nodes = nodes[:, :, columns]
            left_nodes, right_nodes = nodes[left], nodes[right]
        return _hermite(left_nodes, right_nodes, width, (positions - low) / width)

    def extrapolated(self, indices: list[int], positions: Array) -> Array:
        """Return coordinates `(E, size)` beyond nodes, by Taylor polynomials of second order.

        Args:
            indices: of E nodes.
            positions: `(E,)` drive positions.
        """
        rows = taylor(self.nodes[indices], positions - self.positions[indices])
        return self._with_drive(rows, positions)

    def error_back(self, nodes: Array, indices: list[int]) -> Array:
        """Return how far new nodes' Taylor polynomials miss the nodes that they come from.

        Towards a dead point the derivatives grow without bound: a step can be short enough to
        extrapolate to its end, and too long to interpolate over it.

        Args:
            nodes: `(E, 3, size)` new nodes.
            indices: of the nodes of this table that they come from.

        Returns:
            `(E,)` greatest deviation of a coordinate [rad, or characteristic lengths].
        """
        step = self.positions[indices] - nodes[:, 0, self.drive_column]
        deviation = taylor(nodes, step) - self.states[indices]
        return np.asarray(np.max(np.abs(deviation) * self.coordinates.scale, axis=1))

    def _with_drive(self, rows: Array, positions: Array) -> Array:
        rows[:, self.drive_column] = positions
        return self.coordinates.normalised(rows)


def table_of(kinematics: Kinematics, state: ClosedState, drive_column: int) -> BranchTable:
    """Return the table of a single node, at a closed state of one sample."""
    nodes = nodes_of(kinematics, state)
    return _table(nodes[:, 0, drive_column], nodes, drive_column, kinematics.coordinates)


def nodes_of(kinematics: Kinematics, state: ClosedState) -> Array:
    """Return coordinates, their first and their second derivatives `(N, 3, size)`.

    The derivatives are taken with respect to the only drive of the kinematics.
    """
    coordinates = kinematics.coordinates
    ones = np.ones((len(state.x), 1))
    v = kinematics.rates(state, ones)
    a = kinematics.accelerations(state, v, 0.0 * ones)
    first, second = coordinates.derivative(state.x, v), coordinates.curvature(state.x, v, a)
    return np.stack([state.x, first, second], axis=1)


def taylor(nodes: Array, step: Array) -> Array:
    """Return Taylor polynomials of second order `(N, size)`, from nodes `(N, 3, size)`.

    Args:
        nodes: values, first and second derivatives.
        step: `(N,)` drive displacements from there.
    """
    step = step[:, None]
    return np.asarray(nodes[:, 0] + step * (nodes[:, 1] + 0.5 * step * nodes[:, 2]))


def _table(
    positions: Array, nodes: Array, drive_column: int, coordinates: Coordinates
) -> BranchTable:
    """Return a table whose arrays cannot be written to."""
    positions.setflags(write=False)
    nodes.setflags(write=False)
    return BranchTable(positions, nodes, drive_column, coordinates)


def _hermite(left: Array, right: Array, width: Array, share: Array) -> Array:
    """Return quintic Hermite polynomials `(N, size)` between nodes `(N, 3, size)`.

    Args:
        left: nodes at the share 0.
        right: nodes at the share 1.
        width: `(N,)` drive displacements between them.
        share: `(N,)` share of the width.
    """
    powers = np.multiply.accumulate(np.repeat(share[:, None], 5, axis=1), axis=1)
    weights = powers @ _HERMITE
    # Derivatives are taken with respect to the drive: first ones count times the width, second
    # ones times its square.
    weights[:, 1:] *= width[:, None]
    weights[:, 2::2] *= width[:, None]
    known = np.concatenate((right[:, :1] - left[:, :1], left[:, 1:], right[:, 1:]), axis=1)
    return np.asarray(left[:, 0] + np.matmul(weights[:, None], known)[:, 0])


_AMBIGUOUS_CONDITION = 1e7
"""Condition number from which on rounding decides in which assembly mode a branch goes on: modes
are about its reciprocal apart, 1e-7 rad, and positions near a dead point known to the root of
rounding, 1e-8."""


class Followed(NamedTuple):
    """What following a branch has led to.

    Attributes:
        table: with all nodes that were reached.
        refused: the end that could not be followed to its target; None if both targets were
            reached.
    """

    table: BranchTable
    refused: BranchEnd | None


class _MovingEnd(NamedTuple):
    """An end of a branch that is being followed.

    Attributes:
        end: which end.
        control: chooses its steps.
        inverses: per group `(R, p)`, inverse closure equations at its node.
    """

    end: BranchEnd
    control: StepControl
    inverses: list[Array]


class _Trial(NamedTuple):
    """One step that was tried at E ends at once.

    Attributes:
        positions: `(E,)` drive positions that were tried.
        state: what the corrector found there.
        nodes: `(E, 3, size)` of that state.
        excess: `(E,)` ratio of the extrapolation's error to the allowed correction.
        is_accepted: `(E,)` whether the nodes lie on the branch.
    """

    positions: Array
    state: ClosedState
    nodes: Array
    excess: Array
    is_accepted: Array


class BranchFollower:
    """Follows a branch beyond its ends. Nothing in it changes."""

    def __init__(self, kinematics: Kinematics, unit: float, corrector: Corrector) -> None:
        """Make the follower.

        Args:
            kinematics: solves the branch; it has one drive.
            unit: drive displacement that counts as one radian [rad or m].
            corrector: brings extrapolations to closed loops.
        """
        self._kinematics = kinematics
        self._unit = unit
        self._corrector = corrector

    def follow(self, table: BranchTable, low: float, high: float) -> Followed:
        """Return a table that reaches from drive position `low` to `high`, where it can.

        If an end is refused, the table holds what was reached at both ends until then.
        """
        moving, refusal = self._begin(table, low, high)
        while moving and refusal is None:
            trial = self._try(table, moving)
            longer = table.with_nodes(trial.nodes[trial.is_accepted])
            moving, refusal = self._control(table, longer, moving, trial)
            table = longer
        return Followed(table, refusal)

    def _begin(
        self, table: BranchTable, low: float, high: float
    ) -> tuple[list[_MovingEnd], BranchEnd | None]:
        """Return the ends that have a way to go, and the one that cannot even start."""
        targets = [
            (end, target)
            for end, target in ((LOWER, low), (UPPER, high))
            if end.is_before(target, table)
        ]
        state = self._kinematics.evaluate(table.states[[end.node for end, _ in targets]])
        moving = []
        for row, (end, target) in enumerate(targets):
            condition = float(state.condition[row])
            if condition > SINGULAR_CONDITION:
                return [], self._refused(table, end, Attempt(target, 0.0, condition))
            control = StepControl(end.sign, target, self._unit, 1.0 / condition)
            moving.append(_MovingEnd(end, control, [inverse[row] for inverse in state.inverses]))
        return moving, None

    def _try(self, table: BranchTable, moving: list[_MovingEnd]) -> _Trial:
        """Take a step at every moving end: predict, correct and judge."""
        indices = [item.end.node for item in moving]
        positions = np.array(
            [item.control.next_position(table.positions[item.end.node]) for item in moving]
        )
        guess = table.extrapolated(indices, positions)
        state = self._corrector.correct(self._kinematics, guess)
        inverses = [
            np.stack(of_group) for of_group in zip(*(m.inverses for m in moving), strict=True)
        ]
        with np.errstate(all="ignore"):  # What did not converge is rejected, whatever it holds.
            nodes = nodes_of(self._kinematics, state)
            error = np.maximum(state.correction, table.error_back(nodes, indices))
            allowed = allowed_correction(state.condition)
            # A long step can end in another assembly mode, whose loops are closed as well.
            is_accepted = self._kinematics.same_side(state, inverses)
            is_accepted &= error < REJECTED_EXCESS * allowed
            is_accepted &= state.condition < _AMBIGUOUS_CONDITION
            is_accepted &= self._corrector.is_usable(state)
            return _Trial(positions, state, nodes, error / allowed, is_accepted)

    def _control(
        self, table: BranchTable, longer: BranchTable, moving: list[_MovingEnd], trial: _Trial
    ) -> tuple[list[_MovingEnd], BranchEnd | None]:
        """Choose the next steps; return the ends still on the way, and the one to be refused.

        Args:
            table: before the trial.
            longer: with the accepted nodes of the trial.
            moving: the ends that have moved.
            trial: how they have moved.
        """
        still_moving = []
        for row, item in enumerate(moving):
            end, control = item.end, item.control
            condition = float(trial.state.condition[row])
            is_accepted = bool(trial.is_accepted[row])
            if is_accepted:
                step = abs(float(trial.positions[row]) - float(table.positions[end.node]))
                control.accept(step, float(trial.excess[row]), 1.0 / condition)
                inverses = [inverse[row] for inverse in trial.state.inverses]
                item = item._replace(inverses=inverses)
            else:
                control.reject()
            if control.remaining(float(longer.positions[end.node])) <= 0.0:
                continue
            if control.is_stopped:
                # An accepted step that leads to no further one ends where modes meet.
                residual = 0.0 if is_accepted else float(trial.state.residual[row])
                attempt = Attempt(float(trial.positions[row]), residual, condition)
                return [], self._refused(longer, end, attempt)
            still_moving.append(item)
        return still_moving, None

    def _refused(self, table: BranchTable, end: BranchEnd, attempt: Attempt) -> BranchEnd:
        return refused(self._kinematics, table, end, self._unit, attempt)


_STEEP = 100.0
"""Derivative of a coordinate [per unit of the drive] from which on an end counts as near a dead
point of the drive, where derivatives grow without bound."""
_GREATEST_GAP = 1e-4
"""Greatest distance [units of the drive] between the last node and the estimated limit. The last
steps before a limit are much shorter, so a limit that lies farther away is a wrong estimate."""


class BranchEnd(NamedTuple):
    """One end of a branch.

    Attributes:
        node: index of its node in the table, 0 or -1.
        sign: direction of the drive that leads on from there, -1 or 1.
        error: why the branch cannot be followed beyond it; None if nothing is known against it.
    """

    node: int
    sign: float
    error: CardanError | None = None

    def is_before(self, target: float, table: BranchTable) -> bool:
        """Return whether a drive position lies beyond this end of a table."""
        return self.sign * (target - float(table.positions[self.node])) > 0.0


LOWER = BranchEnd(0, -1.0)
UPPER = BranchEnd(-1, 1.0)


class Attempt(NamedTuple):
    """A position beyond an end that was tried without success.

    Attributes:
        position: of the drive [rad or m].
        residual: closure error of what was found there.
        condition: condition number of the closure equations there.
    """

    position: float
    residual: float
    condition: float


def refused(
    kinematics: Kinematics, table: BranchTable, end: BranchEnd, unit: float, attempt: Attempt
) -> BranchEnd:
    """Return an end with the reason for which it cannot be followed.

    Args:
        kinematics: solves the branch.
        table: known part of the branch.
        end: where it ends.
        unit: drive displacement that counts as one radian [rad or m].
        attempt: the last one to go on.
    """
    from ..diagnosis.singularities import (
        gimbal_note,  # Imported here: only errors need it.
        singularity_at,
    )

    nearest = limit(kinematics, table, end, unit)
    middle, last = table.states[table.size // 2], table.states[end.node]
    singularity = singularity_at(kinematics, last, middle)
    passives = [column for solver in kinematics.solvers for column in solver.group.passives]
    finding, hint = singularity.text, gimbal_note(kinematics.coordinates, last, passives)
    error: CardanError
    if attempt.residual < CLOSURE_TOLERANCE or attempt.condition > SINGULAR_CONDITION:
        condition = float(kinematics.evaluate(table.states[[end.node]]).condition[0])
        error = SingularConfigurationError(
            f"the mechanism cannot be followed past drive position {nearest:.9g}: the closure "
            f"equations become singular there (condition {condition:.1e}), {finding}{hint}",
            position=nearest,
            condition=condition,
            hint=hint,
            **singularity.details,
        )
    else:
        error = AssemblyError(
            f"the loops cannot be closed at drive position {attempt.position:.9g}; the nearest "
            f"position that can be reached is {nearest:.9g}, {finding}{hint}",
            position=attempt.position,
            nearest=nearest,
            residual=attempt.residual,
            finding=finding,
            hint=hint,
        )
    return end._replace(error=error)


def limit(kinematics: Kinematics, table: BranchTable, end: BranchEnd, unit: float) -> float:
    """Return the drive position at which the range of the drive ends, near an end of a table.

    Near a dead point passive joints move like the square root of the distance that remains, which
    gives that distance from the first two derivatives. Where assembly modes meet, the reciprocal
    condition number falls to zero in proportion to it.

    Args:
        kinematics: solves the branch.
        table: known part of the branch.
        end: the end before the limit.
        unit: drive displacement that counts as one radian [rad or m].
    """
    position = float(table.positions[end.node])
    _, slope, curvature = table.nodes[end.node]
    steepest = int(np.argmax(np.abs(slope)))
    if table.size < 2:
        return position
    if abs(slope[steepest]) * unit < _STEEP:
        remaining = _distance_to_singularity(kinematics, table, end)
    else:
        # A steep curve without curvature leads to no limit; its quotient, an infinity, is refused.
        with np.errstate(divide="ignore"):
            remaining = float(slope[steepest] / (2.0 * curvature[steepest]))
    return position + remaining if abs(remaining) < _GREATEST_GAP * unit else position


def _distance_to_singularity(kinematics: Kinematics, table: BranchTable, end: BranchEnd) -> float:
    """Return the drive displacement after which the reciprocal condition number vanishes."""
    last, before = end.node, end.node - int(end.sign)
    state = kinematics.evaluate(table.states[[last, before]])
    margin, margin_before = (1.0 / state.condition).tolist()
    step = float(table.positions[last]) - float(table.positions[before])
    return step * margin / (margin_before - margin) if margin_before > margin else 0.0


EXACT_CORRECTION = 2e-16
"""Error [rad] of a guess that needs no Newton step: the rounding of an angle of one radian."""
SAFE_GUESS_CORRECTION = 0.1 * SAFE_CORRECTION
"""Error [rad] of a guess that is safe at every position of an interval. The error is estimated for
the middle of each half, and a tenth leaves room for what the estimate misses."""
_ERROR_RATIO = 64.0
"""How many times smaller the error of quintic Hermite interpolation is on half of an interval:
2 to the sixth power."""
_LOST_CORRECTION = 0.5
"""Correction [rad] from which on a guess counts as lost: nothing shows any more that what Newton's
method found lies in the same assembly mode. It is the longest step that the solver takes."""


def halved(
    table: BranchTable, kinematics: Kinematics, is_open: Array, allowed: float
) -> tuple[BranchTable, Array]:
    """Halve the open intervals of a table, and find which halves are still too coarse.

    Args:
        table: `K` nodes.
        kinematics: with the rows that are known to be independent.
        is_open: `(K - 1,)` which intervals are to be halved.
        allowed: greatest error of a guess [rad].

    Returns:
        The table with a new node in the middle of every open interval, and which intervals of
        that table are open.

    Raises:
        SingularConfigurationError: the branch cannot be resolved.
    """
    left = np.nonzero(is_open)[0]
    middle = 0.5 * (table.positions[left] + table.positions[left + 1])
    state = kinematics.close(table.guess(middle))
    _check_mode(table, kinematics, left, middle, state)
    is_coarse = np.zeros((len(is_open), 2), dtype=bool)
    is_coarse[left] = (state.correction / _ERROR_RATIO > allowed)[:, None]
    # An interval that was not halved is still one interval, and stays closed.
    exists = np.stack([np.ones_like(is_open), is_open], axis=1)
    return table.with_nodes(nodes_of(kinematics, state)), is_coarse[exists]


def _check_mode(
    table: BranchTable, kinematics: Kinematics, left: Array, middle: Array, state: ClosedState
) -> None:
    """Check that states in the middle of intervals are in the assembly mode of the branch.

    Args:
        table: the branch.
        kinematics: that closed the states.
        left: `(M,)` indices of the nodes at the lower ends of the intervals.
        middle: `(M,)` drive positions of the states.
        state: that was found there.

    Raises:
        SingularConfigurationError: one of them may not be.
    """
    is_unsafe = state.correction > SAFE_CORRECTION
    if not np.any(is_unsafe):
        return
    nodes = kinematics.evaluate(table.states[left])
    is_lost = is_unsafe & ~kinematics.same_side(state, nodes.inverses)
    is_lost |= state.correction > _LOST_CORRECTION
    if np.any(is_lost):
        from ..diagnosis.singularities import singularity_at  # Imported here: only errors need it.

        first = int(np.argmax(is_lost))
        singularity = singularity_at(kinematics, table.states[left[first]], table.states[0])
        raise SingularConfigurationError(
            f"the branch cannot be resolved near drive position {middle[first]:.9g}, which is "
            f"singular (condition {nodes.condition[first]:.1e}): {singularity.text}",
            position=float(middle[first]),
            condition=float(nodes.condition[first]),
            **singularity.details,
        )


_NEWTON_STEPS = 6
"""Greatest number of Newton steps per node. Convergence is quadratic: from the allowed correction
of 0.03 rad about four steps reach rounding. A node that needs more steps is rejected, and a shorter
step of the branch is tried."""


class Corrector(Protocol):
    """How a node is corrected, and whether it can be used as it is."""

    def correct(self, kinematics: Kinematics, guess: Array) -> ClosedState:
        """Return states near guesses `(E, size)`."""

    def is_usable(self, state: ClosedState) -> Array:
        """Return `(E,)` whether corrected states may become nodes."""


class OneNewtonStep:
    """The quick way: one Newton step per node, which leaves an error of its square.

    All nodes are closed together afterwards, and the branch is then proven, see `proven`.
    """

    def correct(self, kinematics: Kinematics, guess: Array) -> ClosedState:
        """Return states after one Newton step from guesses `(E, size)`."""
        return kinematics.newton_step(guess)

    def is_usable(self, state: ClosedState) -> Array:
        """Return true for all states: the proof judges them later."""
        return np.ones(len(state.x), dtype=bool)


class FullClosure:
    """The careful way: every node is closed before the next one is tried."""

    def correct(self, kinematics: Kinematics, guess: Array) -> ClosedState:
        """Return states that Newton's method finds from guesses `(E, size)`."""
        return kinematics.close(guess, most=_NEWTON_STEPS)

    def is_usable(self, state: ClosedState) -> Array:
        """Return `(E,)` whether the loops are closed."""
        return np.asarray(state.residual < CLOSURE_TOLERANCE)


def proven(
    kinematics: Kinematics, table: BranchTable, low: float, high: float
) -> BranchTable | None:
    """Close the nodes of a table that `OneNewtonStep` has added, and check that each leads on.

    Neighbouring nodes lie on the same branch if the extrapolations between them are as good, in
    both directions, as step control demands, with no singular configuration between them.

    Args:
        kinematics: solves the branch.
        table: with new nodes below `low` and above `high`.
        low: lower end of the span whose nodes were proven before.
        high: upper end of that span.

    Returns:
        The table with closed nodes, or None if they are not proven to lie on one branch.
    """
    new = (table.positions <= low) | (table.positions >= high)
    positions = table.positions[new]
    state = kinematics.close(table.states[new])
    if np.any(~(state.residual < CLOSURE_TOLERANCE) | (state.correction > SAFE_CORRECTION)):
        return None
    nodes = nodes_of(kinematics, state)
    step = np.diff(positions)
    error_on = np.abs(taylor(nodes[:-1], step) - nodes[1:, 0])
    error_back = np.abs(taylor(nodes[1:], -step) - nodes[:-1, 0])
    error = np.max(np.maximum(error_on, error_back) * kinematics.coordinates.scale, axis=1)
    allowed = allowed_correction(state.condition)
    leads_on = error < REJECTED_EXCESS * np.minimum(allowed[:-1], allowed[1:])
    for group_state in state.groups:
        leads_on &= group_state.follows_on()
    # The two ends of the old span are neighbours here, but proven nodes lie between them.
    leads_on |= (positions[:-1] == low) & (positions[1:] == high)
    return table.with_replaced(new, nodes) if np.all(leads_on) else None


REJECTED_EXCESS = 4.0
"""Ratio of an extrapolation's error to the allowed correction from which on its step is rejected.
The error grows with the third power of the step, so such a step is 1.6 times too long."""
_FIRST_STEP = 2.0 * np.pi / 16.0
"""Step [units of the drive] that is tried first; step control corrects it after one trial."""
_LONGEST_STEP = 2.0 * np.pi / 8.0
"""Longest step [units of the drive], so that even a motion without any error has eight nodes per
turn."""
_SHORTEST_STEP = 1e-9
"""Step [units of the drive] below which the end cannot be followed any farther. It is far above
the rounding of drive positions, so that a step always moves."""
_SINGULAR_DISTANCE = 3.0
"""Distance to a singular configuration times the condition number there, as a lower bound: at a
distance δ from where assembly modes meet, the condition number is about 3/δ or more."""
_APPROACH = 0.7
"""Share of the estimated way to a singular configuration that one step may go. Below one, the
margin stays positive and the singular configuration is never stepped over."""
_GREATEST_GROWTH = 2.5
"""Factor by which a step may grow at once: the error of the last step says little about the error
of a much longer one."""
_LEAST_EXCESS = 1e-3
"""Lower bound of the error ratio in the formula for the next step, where zero has no negative
power. It changes nothing else: `_GREATEST_GROWTH` limits the step at any ratio below 0.064."""
_SHRINKAGE = 0.35
"""Factor by which a rejected step shrinks: the error of an extrapolation falls to a 23rd, which is
accepted if it was up to 90 times the allowed correction."""
_EXTRAPOLATION_ORDER = 3.0
"""Power of the step with which the error of an extrapolation by two derivatives grows."""
_ALLOWED_CORRECTION = 0.03
"""Allowed error [rad] of an extrapolation where the closure equations are well conditioned: small
against the distance between assembly modes, so that Newton's method cannot change the mode."""
_WELL_CONDITIONED = 100.0
"""Condition number up to which `_ALLOWED_CORRECTION` holds undiminished."""


class StepControl:
    """Chooses the steps of one end of a branch on the way to a target.

    Attributes:
        sign: direction of motion, 1 or -1.
        target: drive position to reach [rad or m].
        unit: drive displacement that counts as one radian [rad or m].
        margin: reciprocal condition number at the end of the branch; zero if singular.
        step: length of the step to try next, positive [rad or m].
    """

    def __init__(self, sign: float, target: float, unit: float, margin: float) -> None:
        self.sign = sign
        self.target = target
        self.unit = unit
        self.margin = margin
        self.step = min(_FIRST_STEP, _SINGULAR_DISTANCE * margin) * unit

    @property
    def is_stopped(self) -> bool:
        """Whether steps have become too short to go on."""
        return self.step < _SHORTEST_STEP * self.unit

    def remaining(self, position: float) -> float:
        """Return the distance from a drive position to the target, negative beyond it."""
        return self.sign * (self.target - position)

    def next_position(self, position: float) -> float:
        """Return the position to try next: at last the target itself, not a sum of steps."""
        if self.remaining(position) <= self.step:
            return self.target
        return position + self.sign * self.step

    def accept(self, step: float, excess: float, margin: float) -> None:
        """Choose the next step after a successful one.

        Beyond a singular configuration the branch may go on in several ways. It is therefore
        approached in ever shorter steps, so that it is found, and never stepped over.

        Args:
            step: length of the successful step [rad or m].
            excess: ratio of the extrapolation's error to the allowed correction.
            margin: reciprocal condition number at the position that was reached.
        """
        growth = max(excess, _LEAST_EXCESS) ** (-1.0 / _EXTRAPOLATION_ORDER)
        self.step = min(step * min(_GREATEST_GROWTH, growth), _LONGEST_STEP * self.unit)
        if margin < self.margin:
            # The margin is taken to fall in proportion to the distance from where it vanishes.
            self.step = min(self.step, _APPROACH * step * margin / (self.margin - margin))
        self.margin = margin

    def reject(self) -> None:
        """Choose a shorter step after one that failed."""
        self.step *= _SHRINKAGE


def allowed_correction(condition: Array) -> Array:
    """Return how far extrapolations may be off [rad], from the condition numbers they lead to.

    Other assembly modes come nearer in proportion to the condition number.
    """
    return _ALLOWED_CORRECTION * np.minimum(1.0, _WELL_CONDITIONED / condition)
