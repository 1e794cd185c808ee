"""Branch: one assembly mode of the mechanism, followed along its drive.

A branch keeps closed positions with their first and second derivatives as nodes and interpolates
between them. Its guesses are so near that Newton's method cannot change the assembly mode. It is
made longer at both of its ends at once, along two `Lines`: first the quick way, one Newton step per
node, of several lengths at once, with all nodes closed together and proven afterwards, which takes
80 % of the processor time of the careful way over a first sweep of the universal joint, its scene
included; where nodes are not proven, or an end is not reached, the careful way says why. Branches
that begin alike and are asked for the same share their nodes through what keeps them (`Kept`).
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...arrays import Array
from ...errors import AssemblyError, CardanError, SingularConfigurationError
from ...mechanism.coordinates import Coordinates
from ...mechanism.kept import Kept
from ..closing.all_groups import ClosedState, Kinematics
from ..closing.group_solver import LONGEST_STEP
from ..tolerances import CLOSURE_TOLERANCE, SAFE_CORRECTION, SINGULAR_CONDITION
from .lines import REJECTED, Lines, Rows, allowed_error, quintic

_UNLIMITED = 2**62
"""More nodes than a scene ever asks for: guesses are exact to rounding, and no node is missing."""
_TURNS_TRIED = 12
"""Turns of the drive after which a mechanism is tried for repetition. Velocity ratios of small
whole numbers repeat within them. A turn costs some 12 nodes, measured on the bundled universal
joint, four-bar, needle drive and double shaft."""
_SAME = 1e-7
"""Greatest difference [rad, or lengths of the mechanism] between coordinates one period apart. It
is far above the closure tolerance, and far below any motion that a mechanism would miss its start
by on purpose."""
_STEEP = 100.0
"""Derivative of a coordinate [per unit of the drive] from which on an end counts as near a dead
point of the drive, where derivatives grow without bound."""
_GREATEST_GAP = 1e-4
"""Greatest distance [units of the drive] between the last node and the estimated limit. The last
steps before a limit are much shorter, so a limit that lies farther away is a wrong estimate."""
_AT_LIMIT = 1e-9
"""Distance [units of the drive] from a limit within which a position is the singular one itself:
nobody can tell on which side it lies."""
_EXACT_CORRECTION = 2e-16
"""Error [rad] of a guess that needs no Newton step: the rounding of an angle of one radian."""
_SAFE_GUESS_CORRECTION = 0.1 * SAFE_CORRECTION
"""Error [rad] of a guess that is safe at every position of an interval. The error is estimated for
the middle of each half, and a tenth leaves room for what the estimate misses."""
_ERROR_RATIO = 64.0
"""How many times smaller the error of quintic Hermite interpolation is on half of an interval:
2 to the sixth power."""
_MOST_KEPT = 16
"""Tables that are kept with a mechanism: of each branch the one at its start, and one for each time
that it was made longer."""
_MOST_COVERED = _TURNS_TRIED
"""Times that a branch is made longer, and turns of the drive that it spans, up to which its tables
are kept: of some thousand nodes at most, as a period is found by."""
_MOST_HALVINGS = 2
"""Times that a node is put between neighbours that prove nothing: what one does not mend, such as
another assembly mode, seldom is."""
TURN = 2.0 * np.pi
"""One turn of the drive [rad]."""
TURN_PARTS = 6.28125, float.fromhex("0x1.fb54442dp-10"), 2.1561211432632476e-14
"""One turn as a sum of parts: whole multiples of the first two are exact up to a million."""
SAMPLES_PER_CALL = 24
"""Samples that a call counts as at least, where it is asked what pays for many of them: a Newton
step of a single sample takes as long as that of 25 among many."""
_NODES_PER_REFINEMENT = 100
"""Nodes that take as long as a refinement that makes few of them."""
_LOWER, _UPPER = 0, -1
"""Nodes at the ends of a table."""


@dataclass(frozen=True, eq=False)
class BranchTable:
    """Nodes of a branch in ascending order of the drive. It is never changed.

    Attributes:
        rows: of the K nodes, with derivatives with respect to the drive.
        drive_column: column of the drive in a row of coordinates.
        coordinates: layout of those rows.
    """

    rows: Rows
    drive_column: int
    coordinates: Coordinates

    def __post_init__(self) -> None:
        for values in self.rows:
            values.setflags(write=False)

    @property
    def states(self) -> Array:
        """Closed coordinates `(K, size)` of all nodes."""
        return self.rows.x

    @property
    def size(self) -> int:
        """Number of nodes."""
        return len(self.rows.x)

    @cached_property
    def positions(self) -> Array:
        """Drive positions `(K,)` of the nodes [rad or m]."""
        return self.rows.x[:, self.drive_column].copy()

    @property
    def span(self) -> tuple[float, float]:
        """Lowest and highest drive position of a node."""
        return float(self.positions[0]), float(self.positions[-1])

    @cached_property
    def _known_curves(self) -> dict[Hashable, Array]:
        """What `_curves` has made."""
        return {}

    def _curves(self, columns: Array | slice) -> Array:
        """Return polynomials `(6, K - 1, k)` of some coordinates between neighbouring nodes."""
        key: Hashable
        key = (columns.start, columns.stop) if isinstance(columns, slice) else columns.tobytes()
        if key not in self._known_curves:
            here, there = (
                Rows(*(values[nodes, columns] for values in self.rows))
                for nodes in (slice(-1), slice(1, None))
            )
            self._known_curves[key] = here.quintics(np.diff(self.positions), there)
        return self._known_curves[key]

    @cached_property
    def _served(self) -> int:
        """Samples that were interpolated so far."""
        return 0

    def with_nodes(self, rows: Rows) -> BranchTable:
        """Return a table that also holds new nodes, given in any order."""
        joined = Rows(*map(np.concatenate, zip(self.rows, rows, strict=True)))
        order = np.argsort(joined.x[:, self.drive_column], kind="stable")
        return replace(self, rows=joined.of(order))

    def guess(self, positions: Array) -> Array:
        """Return `(N, size)` coordinates near the branch, exact in the drive's coordinate.

        Interpolated by quintic Hermite polynomials; a single node is repeated.

        Args:
            positions: `(N,)` drive positions.
        """
        rows = self.values(positions, slice(None))
        rows[:, self.drive_column] = positions
        return self.coordinates.normalised(rows)

    def values(self, positions: Array, columns: Array | slice) -> Array:
        """Return `(N, k)` some coordinates near the branch; see `guess`.

        Args:
            positions: `(N,)` drive positions.
            columns: of a row; quaternions come without their unit length.
        """
        if self.size == 1:
            return np.repeat(self.rows.x[:, columns], len(positions), axis=0)
        left = self.positions[1:-1].searchsorted(positions)
        low = self.positions[left]
        width = self.positions[left + 1] - low
        share = (positions - low) / width
        # Made for many samples, or once few at a time add up to many.
        vars(self)["_served"] = served = self._served + max(len(positions), SAMPLES_PER_CALL)
        if served >= self.size:
            return quintic(self._curves(columns), left, share)
        here, there = (
            Rows(*(values[nodes][:, columns] for values in self.rows)) for nodes in (left, left + 1)
        )
        return quintic(here.quintics(width, there), np.arange(len(share)), share)


class Branch:
    """One assembly mode of the mechanism, followed along its drive.

    Attributes:
        kinematics: solves the branch.
        unit: drive displacement that counts as one radian: 1 for angles, a length for slides.
        period: drive displacement after which every body is where it was; None if not known.
        windings: `(size,)` whole turns of every coordinate in one period.
    """

    def __init__(self, kinematics: Kinematics, start: Array, kept: Kept | None = None) -> None:
        """Make a branch that is known at one position.

        Args:
            kinematics: solves the branch; it has one drive.
            start: `(size,)` closed coordinates.
            kept: of the mechanism, where other branches may find what this one finds.
        """
        coordinates = kinematics.coordinates
        (drive_column,) = coordinates.column_of(kinematics.drives).tolist()
        self.kinematics = kinematics
        self.unit = float(coordinates.rate_scale[kinematics.drives[0]])
        self.period: float | None = None
        self.windings = np.zeros(start.size)
        self._start = float(start[drive_column])
        self._kept = kept
        # All that the nodes follow from, as long as they are those of a branch that was only made
        # longer: its start, and what it was to cover.
        self._key: tuple[Hashable, ...] | None = None
        if kept is not None:
            self._key = (kinematics.key, start.tobytes())
        self._table, _ = self._shared(lambda: (self._at(start, drive_column), 0))
        # Why the branch cannot be followed beyond an end.
        self._errors: dict[int, CardanError] = {}
        # Number of nodes that it was last refined to; zero while guesses need not be safe.
        self._refined_to = 0
        # For a table, errors of guesses between its nodes.
        self._guess_errors: tuple[BranchTable, Array] | None = None

    @property
    def span(self) -> tuple[float, float]:
        """Drive positions between which the branch is known."""
        return self._table.span

    def states(self) -> Array:
        """Return closed coordinates `(K, size)` at positions distributed over the branch.

        They are the same object until the branch gets other nodes.
        """
        return self._table.states

    def cover(self, low: float, high: float) -> None:
        """Follow the branch until it spans drive positions `low` to `high`.

        What was reached is kept when an error is raised, and so is the error: another attempt
        from nearer by could step over what has stopped this one.

        Raises:
            AssemblyError: a position cannot be reached.
            SingularConfigurationError: a dead point lies on the way.
        """
        known_low, known_high = self.span
        targets = {_LOWER: low} if low < known_low else {}
        if high > known_high:
            targets[_UPPER] = high
        if not targets:
            return
        for end in targets:
            if end in self._errors:
                raise copy(self._errors[end])
        if self._key is not None:
            turns = (max(high, known_high) - min(low, known_low)) / (2.0 * np.pi * self.unit)
            is_small = max(turns, len(self._key)) <= _MOST_COVERED
            self._key = (*self._key, (low, high)) if is_small else None
        try:
            self._table, self._refined_to = self._shared(lambda: self._longer(targets))
        except CardanError:
            self._key = None
            raise

    def _at(self, start: Array, drive_column: int) -> BranchTable:
        """Return the table of one position `(size,)`."""
        rows = _rows(self.kinematics, self.kinematics.evaluate(start[None, :]))
        return BranchTable(rows, drive_column, self.kinematics.coordinates)

    def _shared(self, found: Callable[[], tuple[BranchTable, int]]) -> tuple[BranchTable, int]:
        """Return a table, and what it is refined to, that all branches with this key have."""
        if self._kept is None or self._key is None:
            return found()
        return self._kept.of("branch", self._key, found, most=_MOST_KEPT)

    def _longer(self, targets: dict[int, float]) -> tuple[BranchTable, int]:
        """Return the table that reaches targets, by end, and what it is refined to.

        Raises:
            AssemblyError, SingularConfigurationError: see `cover`.
        """
        was_safe = self._refined_to > 0 or self._table.size == 1
        self._refined_to = 0
        lines = self._followed(targets, quick=True)
        longer = self._with_nodes_of(lines, proven=True) if np.all(lines.share == 1.0) else None
        if longer is not None:
            return longer, longer.size if was_safe else 0
        lines = self._followed(targets, quick=False)
        self._table = self._with_nodes_of(lines) or self._table
        for line, (end, target) in enumerate(targets.items()):
            if lines.share[line] < 1.0:
                self._errors[end] = self._refused(end, target, lines, line)
        for end in targets:
            if end in self._errors:
                raise copy(self._errors[end])
        return self._table, 0

    def _followed(self, targets: dict[int, float], quick: bool) -> Lines:
        rows, ends = self._table.rows.of(list(targets)), np.array([*targets.values()])[:, None]
        lines = Lines(self.kinematics, rows.x, [self._table.drive_column], ends)
        lines.to_ends(rows, quick)
        return lines

    def _with_nodes_of(self, lines: Lines, proven: bool = False) -> BranchTable | None:
        """Return the table with the nodes of lines, all closed; None if they are to be proven.

        Where two neighbours are so far apart that they prove nothing, there is one more between.
        """
        table, (low, high) = self._table, self.span
        if not lines.nodes:
            return table
        ends = table.states[[_LOWER, _UPPER] if table.size > 1 else [_LOWER]]
        x = np.concatenate([ends, *(rows for _, rows in lines.nodes)])
        for _ in range(_MOST_HALVINGS + 1):
            x = x[np.argsort(x[:, table.drive_column], kind="stable")]
            state, positions = self.kinematics.close(x), x[:, table.drive_column]
            rows = _rows(self.kinematics, state)
            if not proven:
                return table.with_nodes(rows.of((positions < low) | (positions > high)))
            if not np.all(
                (state.residual < CLOSURE_TOLERANCE) & (state.correction < SAFE_CORRECTION)
            ):
                return None
            # Between the two ends of the old span lie nodes that were proven before.
            is_old = (positions[:-1] == low) & (positions[1:] == high)
            (left,) = np.nonzero(~(self._leads_on(state, rows) | is_old))
            if not left.size:
                return table.with_nodes(rows.of((positions < low) | (positions > high)))
            step = np.diff(positions)[left]
            curves = rows.of(left).quintics(step, rows.of(left + 1))
            between = quintic(curves, np.arange(len(left)), np.full(len(left), 0.5))
            between[:, table.drive_column] = positions[left] + 0.5 * step
            x = np.concatenate([state.x, between])
        return None

    def _leads_on(self, state: ClosedState, rows: Rows) -> Array:
        """Return `(K - 1,)` whether closed nodes lie on the same branch as those before them.

        They do if the extrapolations between them are as good, in both directions, as step control
        demands, with no singular configuration between them.
        """
        step = np.diff(state.x[:, self._table.drive_column])
        first, second = rows.of(slice(-1)), rows.of(slice(1, None))
        error = np.maximum(
            np.abs(first.after(step) - second.x), np.abs(second.after(-step) - first.x)
        )
        allowed = allowed_error(state.condition)
        leads_on = np.max(error * self._table.coordinates.scale, axis=1) < REJECTED * np.minimum(
            allowed[:-1], allowed[1:]
        )
        for group_state in state.groups:
            leads_on &= group_state.follows_on()
        return np.asarray(leads_on)

    def _refused(self, end: int, target: float, lines: Lines, line: int) -> CardanError:
        """Return why the branch cannot be followed beyond an end, after lines have tried."""
        from ..diagnosis.singularities import gimbal_note, singularity_at  # Only errors need it.

        kinematics, table = self.kinematics, self._table
        nearest, last = self._limit_at(end), table.states[end]
        singularity = singularity_at(kinematics, last, table.states[table.size // 2])
        passives = [column for solver in kinematics.solvers for column in solver.group.passives]
        hint = gimbal_note(kinematics.coordinates, last, passives)
        residual = float(lines.residual[line])
        # A step that was taken and leads to no further one ends where modes meet.
        at_limit = abs(target - nearest) < _AT_LIMIT * self.unit
        if at_limit or residual < CLOSURE_TOLERANCE or lines.condition[line] > SINGULAR_CONDITION:
            condition = float(kinematics.evaluate(last[None, :]).condition[0])
            return SingularConfigurationError(
                f"the mechanism cannot be followed past drive position {nearest:.9g}: the closure "
                f"equations become singular there (condition {condition:.1e}), "
                f"{singularity.text}{hint}",
                position=nearest,
                condition=condition,
                hint=hint,
                **singularity.details,
            )
        position = float(lines.tried_at(line)[0])
        return AssemblyError(
            f"the loops cannot be closed at drive position {position:.9g}; the nearest "
            f"position that can be reached is {nearest:.9g}, {singularity.text}{hint}",
            position=position,
            nearest=nearest,
            residual=residual,
            finding=singularity.text,
            hint=hint,
        )

    def _limit_at(self, end: int) -> float:
        """Return the drive position at which the range of the drive ends, near an end of the table.

        Near a dead point passive joints move like the square root of the distance that remains,
        which gives that distance from the first two derivatives. Where assembly modes meet, the
        reciprocal condition number falls to zero in proportion to it.
        """
        table = self._table
        position = float(table.positions[end])
        if table.size < 2:
            return position
        slope, half_curvature = table.rows.first[end], table.rows.second[end]
        steepest = int(np.argmax(np.abs(slope)))
        if abs(slope[steepest]) * self.unit < _STEEP:
            before = 1 if end == _LOWER else -2
            margin, margin_before = (
                1.0 / self.kinematics.evaluate(table.states[[end, before]]).condition
            )
            step = position - float(table.positions[before])
            remaining = 0.0
            if margin_before > margin:
                remaining = float(step * margin / (margin_before - margin))
        else:
            # A steep curve without curvature leads to no limit; its quotient, an infinity, is
            # refused.
            with np.errstate(divide="ignore"):
                remaining = float(slope[steepest] / (4.0 * half_curvature[steepest]))
        return position + remaining if abs(remaining) < _GREATEST_GAP * self.unit else position

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
            is_back, windings = whole_turns(self.kinematics, ends[:1], ends[1:])
            if is_back[0]:
                self.period, self.windings = period, windings[0]
                return True
        return False

    def may_refine(self, node_limit: int) -> bool:
        """Return whether `refine` would do anything.

        Every call takes the time of many nodes, however few it makes. Therefore nothing is done
        before the limit has doubled since the last call, and exceeds it by as many.
        """
        known = self._refined_to
        return known == 0 or node_limit >= 2 * known + _NODES_PER_REFINEMENT

    def refine(self, kinematics: Kinematics, node_limit: int) -> None:
        """Halve intervals until guesses are exact to rounding, or there are `node_limit` nodes.

        Guesses are made safe in any case, even with more nodes. See `may_refine`. Nodes are put
        where guesses are known not to be exact, or where nothing is known of them yet.

        Args:
            kinematics: with the rows that are known to be independent.
            node_limit: number of nodes from which on safe guesses suffice.

        Raises:
            SingularConfigurationError: the branch cannot be resolved.
        """
        if not self.may_refine(node_limit):
            return
        # What cannot be resolved is told once: many samples lie elsewhere.
        self._refined_to, errors = node_limit, self._errors_of_guesses()
        while True:
            is_open = errors > _EXACT_CORRECTION
            if not np.any(is_open):
                self._refined_to = _UNLIMITED
                break
            if self._table.size >= node_limit:
                is_open = errors > _SAFE_GUESS_CORRECTION
                if not np.any(is_open):
                    break
            self._key = None
            errors = self._halve(kinematics, is_open, errors)
        self._guess_errors = self._table, errors

    def _errors_of_guesses(self) -> Array:
        """Return errors of guesses between nodes `(K - 1,)`; infinity where they are not known."""
        table = self._table
        errors = np.full(table.size - 1, np.inf)
        if self._guess_errors is not None:
            before, known = self._guess_errors
            # A branch that was made longer has other nodes at its ends alone.
            left = np.searchsorted(table.positions, before.positions[0])
            errors[left : left + len(known)] = known
        return errors

    def _halve(self, kinematics: Kinematics, is_open: Array, errors: Array) -> Array:
        """Halve some intervals; return the errors of guesses in each of the new ones.

        With those of all intervals before, `(K - 1,)`.
        """
        table, (left,) = self._table, np.nonzero(is_open)
        middle = 0.5 * (table.positions[left] + table.positions[left + 1])
        state = kinematics.close(table.guess(middle))
        is_unsafe = state.correction > SAFE_CORRECTION
        if np.any(is_unsafe):
            nodes = kinematics.evaluate(table.states[left])
            is_lost = is_unsafe & ~kinematics.same_side(state, nodes.inverses)
            # Beyond the longest step, nothing shows any more that this is the same mode.
            is_lost |= state.correction > LONGEST_STEP
            if np.any(is_lost):
                first = int(np.argmax(is_lost))
                condition = float(nodes.condition[first])
                raise self._unresolved(kinematics, float(middle[first]), left[first], condition)
        self._table = table.with_nodes(_rows(kinematics, state))
        halved = errors.copy()
        halved[left] = state.correction / _ERROR_RATIO
        return halved.repeat(1 + is_open)

    def _unresolved(
        self, kinematics: Kinematics, position: float, left: int, condition: float
    ) -> SingularConfigurationError:
        from ..diagnosis.singularities import singularity_at  # Only errors need it.

        states = self._table.states
        singularity = singularity_at(kinematics, states[left], states[0])
        return SingularConfigurationError(
            f"the branch cannot be resolved near drive position {position:.9g}, which is "
            f"singular (condition {condition:.1e}): {singularity.text}",
            position=position,
            condition=condition,
            **singularity.details,
        )

    def guess(self, positions: Array) -> Array:
        """Return `(N, size)` coordinates near the branch, exact in the drive's coordinate.

        Args:
            positions: `(N,)` drive positions within the span.
        """
        return self._table.guess(positions)

    def values(self, positions: Array, columns: Array | slice) -> Array:
        """Return `(N, k)` some coordinates near the branch, see `BranchTable.values`."""
        return self._table.values(positions, columns)

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


def whole_turns(kinematics: Kinematics, first: Array, last: Array) -> tuple[Array, Array]:
    """Return `(N,)` whether rows are the same but for whole turns, and these turns `(N, size)`."""
    layout, windings = kinematics.coordinates, np.zeros_like(first)
    angles = layout.angle_columns
    windings[:, angles] = np.rint((last - first)[:, angles] / (2.0 * np.pi))
    missed = np.abs(last - first - 2.0 * np.pi * windings) * layout.scale
    for column in layout.balls.columns.tolist():
        # A quaternion and its negative are the same rotation.
        ball = slice(column, column + 4)
        missed[:, ball] = np.minimum(missed[:, ball], np.abs(last + first)[:, ball])
    # How far idle rods have turned about their lines says nothing about the motion.
    missed[:, kinematics.idle_columns] = 0.0
    return np.max(missed, axis=1, initial=0.0) < _SAME, windings


def _rows(kinematics: Kinematics, state: ClosedState) -> Rows:
    """Return closed positions with derivatives with respect to the only drive."""
    return Rows.along(kinematics, state, np.ones((len(state.x), 1)))
