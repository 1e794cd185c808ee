"""Describe: mobility, redundant rows and statically indeterminate wrenches of a mechanism."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ..core.dynamics.inverse_dynamics import UNIQUE_TOLERANCE
from ..core.kinematics.closing.far import GenericStates, generic_states
from ..core.kinematics.closing.stacked import ranks
from ..core.kinematics.loops.idle_rods import rods_by_name
from ..core.kinematics.loops.structure import Structure
from ..core.kinematics.tolerances import RANK_TOLERANCE
from ..core.mechanics import closure
from ..core.mechanics.bodies import Tree, massless
from ..core.mechanics.placements import Placed, placed
from ..core.mechanics.reactions import Closed
from ..core.mechanics.vectors import seen, times
from ..core.mechanism.configuration import Configuration
from ..core.mechanism.mechanism import Mechanism
from ..core.results.left_open import named_components
from ..core.results.limits import UNLIMITED, described_limits
from ..kit.arrays import Array
from ..kit.errors import ArgumentError, choices
from .drives import MOST_COORDINATES
from .mechanism_report import ComponentReport, LoopReport, MechanismReport
from .presets import preset_of


def describe(mechanism: Mechanism | Configuration) -> MechanismReport:
    """Return mobility, rank, redundant rows and what they leave open.

    Ranks are those of generic closed configurations: around the zero of the description, or around
    where the loops can be closed near it.

    Args:
        mechanism: from `load`; or a configuration of one, around which it is described.

    Raises:
        ArgumentError: it is neither.
        AssemblyError: the loops cannot be closed.
    """
    place, start, described = "the description's zero", None, mechanism
    if isinstance(mechanism, Configuration):
        place, start, mechanism = "this configuration", mechanism.x, mechanism.mechanism
    if not isinstance(mechanism, Mechanism):
        raise ArgumentError(
            f"describe() takes a mechanism from load(), or a configuration of one, not "
            f"{type(mechanism).__name__}"
        )
    start = mechanism.zero if start is None else start
    structure = Structure(mechanism)
    components, loops = [], dict[int, LoopReport]()
    for item in generic_states(structure, MOST_COORDINATES, start):
        is_measured = isinstance(item, GenericStates)
        if isinstance(item, GenericStates):
            group, rank, at_start = item.group.group, item.rank, item.rank_at_start
            loops |= _measured_loops(mechanism, item)
        else:
            # Of the largest ones the structure alone is known: rows that open loops can reach.
            group, every_column = item.group, set(range(mechanism.model.nv))
            reached = structure.ranks(mechanism.coordinates.neutral(), every_column)
            equations = sum(reached[index] for index in group.loops) + len(group.couplings)
            rank = at_start = min(equations, len(group.passives))
            loops |= {k: LoopReport(*_named(mechanism, k), reached[k], None) for k in group.loops}
        components.append(
            ComponentReport(
                loops=tuple(mechanism.loops[index].joint for index in group.loops),
                couplings=tuple(mechanism.couplings[index].name for index in group.couplings),
                coordinates=len(group.passives),
                rank=rank,
                rank_at_zero=at_start,
                is_counted=not is_measured,
            )
        )
    coordinates = mechanism.model.nv
    named = mechanism.coordinates.named.values()
    driven = {item.rate for item in named if item.joint in mechanism.independent_joints}
    rank = sum(component.rank for component in components)
    rods = rods_by_name(mechanism, set(range(coordinates)) - driven)
    return MechanismReport(
        name=mechanism.name,
        notation=mechanism.notation,
        coordinates=coordinates,
        rank=rank,
        mobility=coordinates - rank,
        length=mechanism.characteristic_length,
        components=components,
        loops=[loops[index] for index in sorted(loops)],
        idle_rods=rods,
        drivable=_as_drives(mechanism),
        warnings=(*mechanism.warnings, *_of_motors(mechanism, coordinates - rank - len(rods))),
        silent=tuple(item.told() for item in mechanism.undescribed),
        place=place,
        described=described,
    )


def _as_drives(mechanism: Mechanism) -> tuple[str, ...]:
    """Return coordinates as they come to mind as drives: motors, what has limits, slides, hinges.

    Turns of balls, which seldom have a motor, are the last ones.
    """
    preset = preset_of(mechanism)
    motors = (*mechanism.independent_coordinates, *(preset.drive if preset else ()))

    def key(name: str) -> tuple[bool, ...]:
        item = mechanism.drivable[name]
        has_limits = described_limits(mechanism, name) != UNLIMITED
        several = mechanism.joints[item.joint].nv > 1
        return name not in motors, not has_limits, not item.slides, several

    return tuple(sorted(mechanism.drivable, key=key))


def _of_motors(mechanism: Mechanism, mobility: int) -> Iterator[str]:
    """Yield that the description drives more or fewer coordinates than decide the motion."""
    motors = [name for name in mechanism.independent_coordinates if name in mechanism.drivable]
    if not motors or len(motors) == mobility:
        return
    advice = "say which of them are driven, the loops move the others"
    if len(motors) < mobility:
        advice = (
            f"drive or hold {mobility - len(motors)} more, as the command line does by itself and "
            "describe(mechanism).drives says"
        )
    yield (
        f"{mechanism.name}: coordinates that the description drives: {len(motors)} "
        f"({choices(motors)}); coordinates that decide the motion: {mobility}; {advice}"
    )


def _measured_loops(mechanism: Mechanism, states: GenericStates) -> dict[int, LoopReport]:
    """Return reports on loops by their index, with what their redundant rows leave open."""
    group = states.group.group
    tree = massless(mechanism, group.loops, group.couplings)
    passives = group.passives.tolist()
    columns = {rate: column for column, rate in enumerate(passives)}
    every, count = states.group.x, 6 * len(group.loops) + len(group.couplings)
    at = placed(tree, dict(enumerate((every / tree.coordinate_units(every.shape[1])).T)))
    rows = np.zeros((len(every), len(passives), count))
    for index, row in enumerate(closure.rows(tree, at, passives)):
        for rate, entry in row.items():
            rows[:, columns[rate], index] = entry
    # The last right singular vectors are the multipliers that no joint feels.
    _, _, right = np.linalg.svd(rows)
    null = right[:, states.rank :]
    stresses = [Closed.of(tree, at, dict(enumerate(own.T))) for own in np.swapaxes(null, 0, 1)]
    result = {}
    for local, index in enumerate(group.loops):
        on_loop = slice(6 * local, 6 * local + 6)
        rank = int(np.max(ranks(rows[:, :, on_loop])))
        opened = _indeterminate(mechanism, tree, at, stresses, null[:, :, on_loop])
        result[index] = LoopReport(*_named(mechanism, index), rank, opened)
    return result


def _named(mechanism: Mechanism, index: int) -> tuple[str, str]:
    name = mechanism.loops[index].joint
    return name, mechanism.joints[name].type


def _indeterminate(
    mechanism: Mechanism,
    tree: Tree,
    at: Placed,
    stresses: Sequence[Closed],
    multipliers: Array,
) -> dict[str, str]:
    """Return which components of which joints the self-stresses that load a loop change.

    Args:
        mechanism: the mechanism.
        tree: the loops and couplings of its component.
        at: where its bodies are in K configurations.
        stresses: k self-stresses there.
        multipliers: `(K, k, 6)` of the loop's rows in them.
    """
    if not multipliers.size:
        return {}
    # Only combinations of self-stresses that load the loop count.
    left, values, _ = np.linalg.svd(multipliers, full_matrices=False)
    loading = left * (values > RANK_TOLERANCE)[:, None, :]
    components: dict[str, str] = {}
    for name, index in mechanism.wrench_indices.items():
        spread = np.zeros((*multipliers.shape[:2], 6))
        for item, own in zip(stresses, np.swapaxes(spread, 0, 1), strict=True):
            if (found := item.counted(tree, at, index)) is not None:
                rotation, force, moment = found
                seen_force = times(seen(rotation, force), tree.norm_length)
                for component, value in enumerate((*seen_force, *seen(rotation, moment))):
                    own[:, component] = value
        changes = np.abs(loading.transpose(0, 2, 1) @ spread).max(axis=(0, 1))
        if np.any(changes > UNIQUE_TOLERANCE):
            components[name] = named_components(changes > UNIQUE_TOLERANCE)
    return components
