"""Describe: mobility, redundant rows and indeterminate reactions of a mechanism, for people."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..dynamics.reactions import UNIQUE_TOLERANCE, ReactionSolver
from ..errors import AssemblyError
from ..kinematics.all_groups import Kinematics
from ..kinematics.group_solver import GroupSolver, GroupState
from ..kinematics.loop_groups import Group, partition
from ..kinematics.mobility import ranks
from ..kinematics.structure import Structure
from ..kinematics.tolerances import CLOSURE_TOLERANCE
from ..mechanism.coordinates import Coordinates
from ..mechanism.mechanism import Mechanism

_MOST_BODIES = 24  # Above, one model of everything is too large; counting has to do.
_STATES = 6


@dataclass(frozen=True)
class LoopReport:
    """One loop.

    Attributes:
        name: of its joint.
        type: of its joint.
        rank: how many of its six rows the motion of its joints can reach.
        blurred: joint to the components (`x y z` of force, then of moment, in the joint's frame)
            that its redundant rows leave open; None if the mechanism is too large to tell here.
    """

    name: str
    type: str
    rank: int
    blurred: dict[str, str] | None

    @property
    def redundant(self) -> int:
        """Number of redundant rows."""
        return 6 - self.rank


@dataclass(frozen=True)
class MechanismReport:
    """What `Mechanism.describe` returns; `print` shows it.

    Attributes:
        name: of the mechanism.
        notation: in which the loops are written.
        coordinates: number of joint coordinates.
        rank: number of independent closure equations.
        mobility: number of coordinates that remain free after the loops.
        counted: whether rank and mobility were counted from the structure alone, which misses
            mechanisms that move only because of special dimensions.
        length: characteristic length that weighs forces against moments [m].
        loops: the loops.
        warnings: what is wrong with the description and was accepted.
    """

    name: str
    notation: str
    coordinates: int
    rank: int
    mobility: int
    counted: bool
    length: float
    loops: list[LoopReport]
    warnings: tuple[str, ...]

    def __str__(self) -> str:
        how = " (counted)" if self.counted else ""
        lines = [
            f"{self.name}: mobility {self.mobility}{how}",
            f"  {self.coordinates} joint coordinates, {self.rank} independent closure equations",
            f"  loops: {self.notation}; characteristic length {self.length:.4g} m",
        ]
        for loop in self.loops:
            lines.append(
                f"  loop {loop.name} ({loop.type}): rank {loop.rank} of 6, "
                f"{loop.redundant} redundant"
            )
            for joint, components in (loop.blurred or {}).items():
                lines.append(f"    leaves open at {joint}: {components}")
        lines += [f"  warning: {warning}" for warning in self.warnings]
        return "\n".join(lines)


def describe(mechanism: Mechanism) -> MechanismReport:
    """Return mobility, rank, redundant rows and what they leave open.

    Ranks are those of closed positions around the zero of the description.
    """
    coordinates = mechanism.coordinates
    structure = Structure(mechanism)
    every = np.arange(mechanism.model.nv)
    none = np.zeros(0, dtype=int)
    small = len(coordinates.parts) <= _MOST_BODIES
    groups = partition(structure, coordinates.neutral(), none, every, together=small)
    if small:
        rank, loops = _measured(mechanism, groups)
    else:
        reached = structure.ranks(coordinates.neutral(), set(every.tolist()))
        rank = sum(
            min(
                sum(reached[number] for number in group.loops) + len(group.couplings),
                len(group.passives),
            )
            for group in groups
        )
        loops = [
            LoopReport(loop.joint, mechanism.joints[loop.joint].type, reached[number], None)
            for number, loop in enumerate(mechanism.loops)
        ]
    return MechanismReport(
        mechanism.name,
        mechanism.notation,
        len(every),
        rank,
        len(every) - rank,
        not small,
        mechanism.characteristic_length,
        loops,
        mechanism.warnings,
    )


def _measured(mechanism: Mechanism, groups: list[Group]) -> tuple[int, list[LoopReport]]:
    solvers = [GroupSolver(mechanism, group) for group in groups if group.loops or group.couplings]
    if not solvers:
        return 0, []
    kinematics = Kinematics(mechanism.coordinates, np.zeros(0, dtype=int), solvers)
    here = kinematics.close(_around_zero(mechanism.coordinates), most=60)
    good = here.residual < CLOSURE_TOLERANCE
    if not np.any(good):
        raise AssemblyError(
            f"{mechanism.name}: the loops cannot be closed near the description's zero (closure "
            f"error {np.min(here.residual):.1e}): check the origins of joints and loops",
            position=None,
            nearest=None,
            residual=float(np.min(here.residual)),
        )
    here = kinematics.evaluate(here.x[good])
    closed = here.groups[0]
    rank = int(np.max(ranks(closed.scaled_rows), initial=0))
    kinematics = kinematics.with_reductions([closed.reachable])
    closed = kinematics.evaluate(here.x).groups[0]
    reactions = ReactionSolver(mechanism, kinematics, {0})
    loops = []
    for place, loop in enumerate(mechanism.loops):
        blurred = _blurred(mechanism, reactions, closed, place)
        reached = closed.reduction.rows[place].shape[1]
        kind = mechanism.joints[loop.joint].type
        loops.append(LoopReport(loop.joint, kind, reached, blurred))
    return rank, loops


def _around_zero(coordinates: Coordinates) -> Array:
    rng = np.random.default_rng(1920)
    x = np.repeat(coordinates.neutral()[None, :], _STATES, axis=0)
    every = np.arange(coordinates.model.nv)
    step = 0.05 * rng.uniform(-1.0, 1.0, (_STATES, len(every)))
    step[0] = 0.0
    coordinates.moves(every).apply(x, step)
    return x


def _blurred(
    mechanism: Mechanism, reactions: ReactionSolver, closed: GroupState, place: int
) -> dict[str, str]:
    """Return which components of which joints the redundant rows of a loop leave open."""
    found: dict[str, str] = {}
    for item in reactions.self_stresses(closed):
        if closed.group.loops[place] not in item.forces:
            continue
        for joint in mechanism.joints.values():
            number = joint.id - 1 if joint.parts else None
            if number is None or number not in item.joints:
                continue
            lengths = np.repeat([mechanism.characteristic_length, 1.0], 3)
            marks = (item.size()[item.joints == number][0] * lengths) > UNIQUE_TOLERANCE
            if np.any(marks):
                force = "".join(axis for axis, mark in zip("xyz", marks[:3], strict=True) if mark)
                moment = "".join(axis for axis, mark in zip("xyz", marks[3:], strict=True) if mark)
                parts = [f"force {force}"] * bool(force) + [f"moment {moment}"] * bool(moment)
                found[joint.name] = ", ".join(parts)
    return found
