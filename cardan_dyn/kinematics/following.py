"""Following: closed positions for several drives, from sample to sample.

Positions of several drives have no order along which a branch could be kept. Samples are therefore
closed one after the other as they are given: as many at once as an extrapolation from the last one
reaches safely, and by smaller steps where it does not reach even the next one.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..errors import AssemblyError, as_text
from ..problem.problem import Problem
from .all_groups import ClosedState, Kinematics
from .drive_motion import Followed
from .loop_system import LoopSystem
from .redundancy import STATES_STUDIED
from .tolerances import CLOSURE_TOLERANCE

_SAFE_CORRECTION = 0.1
"""Error [rad] up to which an extrapolation is taken to end in the same assembly mode. It may be
greater than `SAFE_CORRECTION`, since nothing is interpolated between these samples, and every step
is also checked for a change of side of a singular configuration."""
_SMALLEST_BATCH, _LARGEST_BATCH = 8, 512
"""Samples tried at once: few where most of them would be thrown away, and not so many that arrays
become large. Between the two, a batch is twice as large as the last one was successful."""
_SMALLEST_SHARE = 1e-9
"""Share of the remaining way to a sample that is tried last, before the sample counts as out of
reach."""
_NEWTON_STEPS = 6
"""Greatest number of Newton steps per sample. Convergence is quadratic: from a safe extrapolation
about four steps reach rounding. What needs more is tried again from nearer by."""


class JointMotion:
    """The motion of what several drives move together, followed from sample to sample.

    Attributes:
        groups: indices of the groups whose passives they move.
        is_exact: see `DriveMotion`.
    """

    is_exact = False

    def __init__(
        self,
        problem: Problem,
        system: LoopSystem,
        kinematics: Kinematics,
        start: Array,
        drives: list[int],
        groups: list[int],
    ) -> None:
        """Begin at the start; arguments as of `DriveMotion`, with several drives."""
        del system  # No branch leads along several drives.
        self.groups = groups
        self._drives = drives
        self._names = tuple(problem.drives[index] for index in drives)
        self._kinematics = kinematics.part(drives, groups)
        self._start = start
        coordinates = problem.mechanism.coordinates
        self._drive_columns = coordinates.columns_of(self._names)
        self._columns = coordinates.columns_moved_by(self._kinematics.moved)
        self.states = start[None, :]

    @property
    def amplitudes(self) -> Array | None:
        """None: how far joints move is not known."""
        return None

    def more_states(self) -> Array:
        """Return no states `(0, size)` besides those that were followed."""
        return self.states[:0]

    def followed(self, positions: Array) -> Followed:
        """Follow the motion to drive positions `(N, d)`, of all drives of the scene.

        Raises:
            AssemblyError: a position is out of reach.
        """
        own = positions[:, self._drives]
        try:
            x = follow(self._kinematics, self._start, self._drive_columns, own)
        except AssemblyError as error:
            from .reach import all_out_of_reach  # Imported here: only errors need it.

            raise all_out_of_reach(self._names, own, error) from error
        self.states = x[:: 1 + len(x) // STATES_STUDIED]
        return Followed(x[:, self._columns], True)

    def write(
        self, followed: Followed, positions: Array, x: Array, turns: Array, kinematics: Kinematics
    ) -> None:
        """Write closed coordinates into those of all joints, see `DriveMotion.write`."""
        x[:, self._columns] = followed.values


def follow(kinematics: Kinematics, start: Array, columns: list[int], positions: Array) -> Array:
    """Return closed coordinates `(N, size)` at drive positions `(N, d)`.

    Args:
        kinematics: of the scene.
        start: `(size,)` closed coordinates to begin at.
        columns: columns of the drives in a row of coordinates.
        positions: in the order in which they are followed [rad or m].

    Raises:
        AssemblyError: the loops cannot be closed on the way to a sample.
    """
    result = np.empty((len(positions), start.size))
    last, count, batch_size = start, 0, _SMALLEST_BATCH
    while count < len(positions):
        targets = positions[count : count + batch_size]
        state, is_safe = _one_step(kinematics, last, columns, targets)
        reached = len(targets) if np.all(is_safe) else int(np.argmin(is_safe))
        batch_size = min(max(2 * reached, _SMALLEST_BATCH), _LARGEST_BATCH)
        if reached:
            result[count : count + reached] = state.x[:reached]
        else:
            result[count] = _several_steps(kinematics, last, columns, targets[0], count)
            reached = 1
        count += reached
        last = result[count - 1]
    return result


def _one_step(
    kinematics: Kinematics, last: Array, columns: list[int], targets: Array
) -> tuple[ClosedState, Array]:
    """Close the loops at targets `(K, d)`, each in one step from closed coordinates `(size,)`.

    Returns:
        The states, and `(K,)` whether they are in the same assembly mode.
    """
    coordinates = kinematics.coordinates
    before = kinematics.evaluate(last[None, :])
    x = np.broadcast_to(last, (len(targets), last.size))
    step = targets - last[columns]
    with np.errstate(all="ignore"):  # Targets out of reach may overflow; they are not safe.
        v = kinematics.rates(before, step)
        a = kinematics.accelerations(before, v, np.zeros_like(step))
        guess = x + (coordinates.derivative(x, v) + 0.5 * coordinates.curvature(x, v, a))
        guess[:, columns] = targets
        state = kinematics.close(guess, most=_NEWTON_STEPS)
        is_safe = (state.residual < CLOSURE_TOLERANCE) & (state.correction < _SAFE_CORRECTION)
        is_safe &= kinematics.same_side(state, before.inverses)
    return state, is_safe


def _several_steps(
    kinematics: Kinematics, last: Array, columns: list[int], target: Array, sample: int
) -> Array:
    """Return closed coordinates `(size,)` at a target `(d,)`, in as many steps as it takes.

    All drives move along the straight line from where they are.

    Raises:
        AssemblyError: the target, of this sample, cannot be reached.
    """
    share = 0.5
    while True:
        remaining = target - last[columns]
        position = target if share == 1.0 else last[columns] + share * remaining
        state, is_safe = _one_step(kinematics, last, columns, position[None, :])
        if is_safe[0]:
            last = state.x[0]
            if share == 1.0:
                return last
            share = min(1.0, 2.0 * share)
            continue
        share *= 0.5
        if share < _SMALLEST_SHARE:
            from .gimbal_lock import gimbal_note  # Only errors need it.

            passives = [column for solver in kinematics.solvers for column in solver.group.passives]
            note = gimbal_note(kinematics.coordinates, last, passives)
            raise AssemblyError(
                f"the loops cannot be closed at drive positions {as_text(target)}; on the way "
                f"there the nearest that were reached are {as_text(last[columns])}{note}",
                position=target.copy(),
                nearest=last[columns].copy(),
                residual=float(state.residual[0]),
                sample=sample,
                hint=note,
            )
