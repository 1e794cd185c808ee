"""Describe: mobility, redundant rows and statically indeterminate wrenches of a mechanism."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..dynamics.closure_forces import ClosureForces
from ..dynamics.indeterminate import SelfStress
from ..dynamics.reactions import UNIQUE_TOLERANCE
from ..errors import AssemblyError
from ..kinematics.all_groups import Kinematics
from ..kinematics.group_solver import GroupSolver
from ..kinematics.loop_groups import Group, partition
from ..kinematics.mobility import ranks
from ..kinematics.structure import Structure
from ..kinematics.tolerances import CLOSURE_TOLERANCE
from ..mechanism.coordinates import Coordinates
from ..mechanism.mechanism import Mechanism
from ..results.wrench import named_components

_MOST_BODIES = 24
"""Elementary parts of joints, each of them a body of the model, above which one model of the whole
mechanism is too large; ranks are then counted."""
_STATES = 6
"""Configurations in which ranks are measured: one alone may be singular."""
_AROUND_ZERO = 0.05
"""How far from the zero of the description these configurations start [rad, m]: far enough to
leave a singular zero, and near enough to be closed in the same assembly mode."""
_SEED = 1920
"""Of their random directions; any fixed number gives the same report each time."""
_MOST_STEPS = 60
"""Newton steps in which their loops have to close. Near a singular configuration steps converge
linearly, halving the error each time: 50 of them lower it by 1e-15."""


@dataclass(frozen=True)
class LoopReport:
    """One loop.

    Attributes:
        name: of its joint.
        type: of its joint.
        rank: how many of its six rows the motion of its joints can reach.
        indeterminate: joint to the components (`x y z` of force, then of moment, in its frame)
            that its redundant rows leave open; None if the mechanism is too large for
            that to be measured.
    """

    name: str
    type: str
    rank: int
    indeterminate: dict[str, str] | None

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
        is_counted: whether rank and mobility were counted from the structure alone, which misses
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
    is_counted: bool
    length: float
    loops: list[LoopReport]
    warnings: tuple[str, ...]

    def __str__(self) -> str:
        lines = [
            f"{self.name}: mobility {self._mobility}",
            f"  {self.coordinates} joint coordinates, {self.rank} independent closure equations",
            f"  loops: {self.notation}; characteristic length {self.length:.4g} m",
        ]
        for loop in self.loops:
            lines.append(
                f"  loop {loop.name} ({loop.type}): rank {loop.rank} of 6, "
                f"{loop.redundant} redundant"
            )
            for joint, components in (loop.indeterminate or {}).items():
                lines.append(f"    leaves open at {joint}: {components}")
        lines += [f"  warning: {warning}" for warning in self.warnings]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        from ..markup import element, listed, table  # Imported here: only notebooks show it.

        title = element("p", f"{self.name}: mobility {self._mobility}")
        facts = listed(
            "ul",
            (
                f"{self.coordinates} joint coordinates",
                f"{self.rank} independent closure equations",
                f"loops: {self.notation}",
                f"characteristic length {self.length:.4g} m",
            ),
        )
        header = ("loop", "type", "rank of 6", "redundant", "leaves open")
        rows = [
            (loop.name, loop.type, loop.rank, loop.redundant, _listed_components(loop))
            for loop in self.loops
        ]
        loops = table(header, rows) if rows else ""
        warnings = listed("ul", (f"warning: {warning}" for warning in self.warnings))
        return f"<div>{title}{facts}{loops}{warnings if self.warnings else ''}</div>"

    @property
    def _mobility(self) -> str:
        return f"{self.mobility} (counted)" if self.is_counted else str(self.mobility)


def _listed_components(loop: LoopReport) -> str:
    """Return what the redundant rows of a loop leave open, in one line."""
    if loop.indeterminate is None:
        return "not examined"
    return "; ".join(f"{joint}: {components}" for joint, components in loop.indeterminate.items())


def describe(mechanism: Mechanism) -> MechanismReport:
    """Return mobility, rank, redundant rows and what they leave open.

    Ranks are those of closed configurations around the zero of the description.

    Raises:
        AssemblyError: the loops cannot be closed there.
    """
    coordinates = mechanism.coordinates
    structure = Structure(mechanism)
    every_column = np.arange(mechanism.model.nv)
    no_columns = np.zeros(0, dtype=int)
    is_small = len(coordinates.parts) <= _MOST_BODIES
    groups = partition(
        structure, coordinates.neutral(), no_columns, every_column, together=is_small
    )
    if is_small:
        rank, loops = _measured(mechanism, groups)
    else:
        rank, loops = _counted(mechanism, structure, groups)
    return MechanismReport(
        mechanism.name,
        mechanism.notation,
        len(every_column),
        rank,
        len(every_column) - rank,
        not is_small,
        mechanism.characteristic_length,
        loops,
        mechanism.warnings,
    )


def _counted(
    mechanism: Mechanism, structure: Structure, groups: list[Group]
) -> tuple[int, list[LoopReport]]:
    """Return the rank of all closure equations and the loops, as far as the structure tells."""
    every_column = range(mechanism.model.nv)
    reached = structure.ranks(mechanism.coordinates.neutral(), set(every_column))
    rank = sum(
        min(
            sum(reached[index] for index in group.loops) + len(group.couplings),
            len(group.passives),
        )
        for group in groups
    )
    loops = [
        LoopReport(loop.joint, mechanism.joints[loop.joint].type, reached[index], None)
        for index, loop in enumerate(mechanism.loops)
    ]
    return rank, loops


def _measured(mechanism: Mechanism, groups: list[Group]) -> tuple[int, list[LoopReport]]:
    """Return the rank of all closure equations and the loops, from closed configurations.

    Raises:
        AssemblyError: the loops cannot be closed.
    """
    solvers = [GroupSolver(mechanism, group) for group in groups if group.loops or group.couplings]
    if not solvers:
        return 0, []
    kinematics = Kinematics(mechanism.coordinates, np.zeros(0, dtype=int), solvers)
    state = kinematics.close(_around_zero(mechanism.coordinates), most=_MOST_STEPS)
    is_closed = state.residual < CLOSURE_TOLERANCE
    if not np.any(is_closed):
        raise AssemblyError(
            f"{mechanism.name}: the loops cannot be closed near the description's zero (closure "
            f"error {np.min(state.residual):.1e}): check the origins of joints and loops",
            position=None,
            nearest=None,
            residual=float(np.min(state.residual)),
        )
    state = kinematics.evaluate(state.x[is_closed])
    group_state = state.groups[0]
    rank = int(np.max(ranks(group_state.scaled_rows), initial=0))
    kinematics = kinematics.with_reductions([group_state.reachable])
    group_state = kinematics.evaluate(state.x).groups[0]
    self_stresses = ClosureForces(mechanism).self_stresses(group_state)
    loops = []
    for index, loop in enumerate(mechanism.loops):
        stresses = [item for item in self_stresses if group_state.group.loops[index] in item.forces]
        indeterminate = _indeterminate(mechanism, stresses)
        reached = group_state.reduction.rows[index].shape[1]
        joint_type = mechanism.joints[loop.joint].type
        loops.append(LoopReport(loop.joint, joint_type, reached, indeterminate))
    return rank, loops


def _around_zero(coordinates: Coordinates) -> Array:
    """Return configurations `(_STATES, size)` at and around zero, always the same ones."""
    rng = np.random.default_rng(_SEED)
    x = np.repeat(coordinates.neutral()[None, :], _STATES, axis=0)
    every_column = np.arange(coordinates.model.nv)
    step = _AROUND_ZERO * rng.uniform(-1.0, 1.0, (_STATES, len(every_column)))
    step[0] = 0.0
    coordinates.moves(every_column).apply(x, step)
    return x


def _indeterminate(mechanism: Mechanism, self_stresses: list[SelfStress]) -> dict[str, str]:
    """Return which components of which joints self-stresses change."""
    lengths = np.repeat([mechanism.characteristic_length, 1.0], 3)
    components: dict[str, str] = {}
    for stress in self_stresses:
        for joint in mechanism.joints.values():
            body = joint.id - 1
            if not joint.parts or body not in stress.joints:
                continue
            is_open = (stress.size()[stress.joints == body][0] * lengths) > UNIQUE_TOLERANCE
            if np.any(is_open):
                components[joint.name] = named_components(is_open)
    return components
