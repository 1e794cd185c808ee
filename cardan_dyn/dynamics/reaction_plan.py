"""Reaction plan: what the compiled reactions of a mechanism work along, as arrays of indices.

`compiled/reactions_plan.h` reads it; its arrays are described there by the same words.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import accumulate, pairwise
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..compiled import Plan
from ..kinematics.closing.equations import Reduction, successor_ends
from ..kinematics.closing.group_solver import GroupState
from ..mechanism.mechanism import Mechanism
from .closure_forces import ClosureForces
from .indeterminate import LeastNorm
from .open_tree import Along

_NONE = -1


class ReactionPlan(NamedTuple):
    """What the compiled reactions work along, as long as the same rows are redundant.

    Attributes:
        reductions: index and reduction of every group whose closure forces are solved.
        plan: of the compiled function.
        columns: per loop, then per coupling, where its force is among those of all.
        rows: number of these.
        slip_units: `(G,)` of the couplings, see `ClosureEquations`; None if no coupling's moment
            can be changed by self-stresses.
    """

    reductions: list[tuple[int, Reduction]]
    plan: Plan
    columns: list[slice]
    rows: int
    slip_units: Array | None


class _Item(NamedTuple):
    """A self-stress: where it is among all, and what it loads.

    Attributes:
        amounts: their number.
        joints: what they load.
        targets: rows of all closure forces that they consist of.
    """

    amounts: int
    joints: list[int]
    targets: list[int]


class _Writer:
    """Collects the groups one after the other."""

    def __init__(self, mechanism: Mechanism, closure: ClosureForces, along: Along) -> None:
        self._mechanism, self._closure, self._along = mechanism, closure, along
        self.groups: list[tuple[int, ...]] = []
        self.passives: list[tuple[int, int]] = []
        self.units: list[Array] = []
        self.loops: list[tuple[int, ...]] = []
        self.matrices: list[Array] = []
        self.paths: list[tuple[int, int, int]] = []
        self.signs: list[float] = []
        self.couplings: list[tuple[int, ...]] = []
        self.coupled: list[int] = []
        self.ratios: list[tuple[float, float]] = []
        self.items: list[_Item] = []
        self.slip_units = np.zeros(len(mechanism.couplings))
        self.weights = np.ones(6)

    def add(self, state: GroupState) -> None:
        """Add a group."""
        group, equations = state.group, state.equations
        self.weights = equations.weights
        amounts, loop_count = state.null.shape[2], len(self._mechanism.loops)
        paths = [self._path(state, local, loop) for local, loop in enumerate(group.loops)]
        by_null = sorted({joint for path in paths for _, joint, _ in path})
        slots = {joint: slot for slot, joint in enumerate(by_null)}
        coupled = [6 * loop_count + index for index in group.couplings]
        null_item = _NONE
        if amounts:
            null_item = len(self.items)
            targets = [6 * loop + row for loop in group.loops for row in range(6)] + coupled
            self.items.append(_Item(amounts, by_null, targets))
        rows = sum(item.shape[1] for item in state.reduction.rows) + len(coupled)
        sizes = group.passives.size, state.inverse.shape[1], rows, amounts
        first = len(self.passives)
        counts = len(group.loops), len(coupled)
        self.groups.append((*sizes, state.actions.shape[1], first, *counts, null_item))
        for column in group.passives.tolist():
            self.passives.append((column, self._along.row_of(column)))
            self.units.append(self._along.units_of(column))
        for local, (loop, path) in enumerate(zip(group.loops, paths, strict=True)):
            self._add_loop(state, local, loop, path, slots)
        for index, unit in zip(group.couplings, equations.slip_units.tolist(), strict=True):
            coupling = self._mechanism.couplings[index]
            columns = [*coupling.successor_columns], [*coupling.predecessor_columns]
            self.couplings.append((index, len(self.coupled), *map(len, columns)))
            self.coupled += [*columns[0], *columns[1]]
            self.ratios.append((unit, coupling.ratio))
            self.slip_units[index] = unit

    def _path(self, state: GroupState, local: int, loop: int) -> list[tuple[int, int, float]]:
        """Return the first row, the joint and the sign of each body on a loop; then its own."""
        (on_loop,) = np.nonzero(state.equations.signs[local])
        path = [
            (6 * body, int(state.batch.bodies[body]), float(state.equations.signs[local, body]))
            for body in on_loop.tolist()
        ]
        if loop in self._closure.fixed_loops:
            path.append((_NONE, self._closure.fixed_loops[loop], 1.0))
        return path

    def _add_loop(
        self,
        state: GroupState,
        local: int,
        loop: int,
        path: list[tuple[int, int, float]],
        slots: dict[int, int],
    ) -> None:
        """Add a loop of a group, with its own self-stress if it has one."""
        reduction = state.reduction
        rows, null, axes = reduction.rows[local], reduction.null[local], reduction.axes[local]
        item, fixed = _NONE, self._closure.fixed_loops.get(loop, _NONE)
        if null.shape[1]:
            item = len(self.items)
            targets = [6 * loop + row for row in range(6)]
            self.items.append(_Item(null.shape[1], [joint for _, joint, _ in path], targets))
        end = successor_ends([state.equations.loops[local]], state.batch)
        end_body = _NONE
        if end.bodies is not None:
            end_body = int(np.arange(len(state.batch))[end.bodies][0])
        bodies = [entry for entry in path if entry[0] != _NONE]
        first, fixed_slot = len(self.paths), slots[fixed] if fixed != _NONE else _NONE
        of_path = first, len(bodies), fixed, end_body, item, fixed_slot
        self.loops.append((loop, rows.shape[1], axes.body, *of_path))
        for row, joint, sign in bodies:
            self.paths.append((row, joint, slots[joint]))
            self.signs.append(sign)
        placed = axes.point, end.rotations[0].ravel(), end.translations[0]
        self.matrices.append(np.concatenate([_padded(rows), _padded(null), *placed]))

    def places(self) -> Iterator[tuple[int, ...]]:
        """Yield, per self-stress, its sizes and where its parts are, in the order of `Item`."""
        starts = [0] * 5
        for item in self.items:
            joints, rows = len(item.joints), len(item.targets)
            amount, joint, spread, target, unit = starts
            yield item.amounts, amount, joints, joint, spread, rows, target, unit
            sizes = item.amounts, joints, 6 * joints * item.amounts, rows, rows * item.amounts
            starts = [start + size for start, size in zip(starts, sizes, strict=True)]


def reaction_plan(
    mechanism: Mechanism,
    closure: ClosureForces,
    along: Along,
    rule: LeastNorm,
    states: Mapping[int, GroupState],
) -> ReactionPlan:
    """Return the plan for groups whose closure forces are solved in this order.

    Args:
        mechanism: the mechanism.
        closure: of its loops.
        along: its velocity coordinates.
        rule: chooses the self-stresses.
        states: of the groups, by their indices, whose redundant rows it is for.
    """
    writer = _Writer(mechanism, closure, along)
    for state in states.values():
        writer.add(state)
    pairs, shared, rows, normal_size = _normal_equations(writer.items, rule)
    loops, couplings = len(mechanism.loops), len(mechanism.couplings)
    joints = [joint for item in writer.items for joint in item.joints]
    targets = [target for item in writer.items for target in item.targets]
    sizes = [
        *(mechanism.model.nv, closure.size, loops, couplings, int(along.is_along_axes)),
        max((passives for passives, *_ in writer.groups), default=0),
        max((multipliers for _, multipliers, *_ in writer.groups), default=0),
        max((item.amounts for item in writer.items), default=0),
        sum(6 * len(item.joints) * item.amounts for item in writer.items),
        sum(len(item.targets) * item.amounts for item in writer.items),
        normal_size,
    ]
    tables = [
        *(sizes, writer.groups, writer.passives, writer.loops, writer.paths, writer.couplings),
        *(writer.coupled, list(writer.places()), joints, targets, pairs, shared, rows),
    ]
    scales = [*writer.weights, *rule.squared_lengths, mechanism.characteristic_length]
    numbers = (scales, writer.units, writer.matrices, writer.signs, writer.ratios)
    ends = list(accumulate([6] * loops + [1] * couplings, initial=0))
    is_coupled = any(target >= 6 * loops for target in targets)
    return ReactionPlan(
        [(index, state.reduction) for index, state in states.items()],
        Plan("reactions", tables, numbers),
        [slice(first, last) for first, last in pairwise(ends)],
        ends[-1],
        writer.slip_units if is_coupled else None,
    )


def _normal_equations(
    items: list[_Item], rule: LeastNorm
) -> tuple[list[tuple[int, ...]], list[tuple[int, int]], list[tuple[int, int]], int]:
    """Return which self-stresses load the same joints, and the rows of their normal equations.

    Returns:
        Pairs, the later one first, with where their shared joints are; of these the places in both;
        per row its first column and where it starts; and the size of all rows.
    """
    slots = [
        {joint: slot for slot, joint in enumerate(item.joints) if joint in rule.counted}
        for item in items
    ]
    starts = list(accumulate((item.amounts for item in items), initial=0))
    loading: dict[int, list[int]] = {}
    for index, own in enumerate(slots):
        for joint in own:
            loading.setdefault(joint, []).append(index)
    connected: list[set[int]] = [{index} for index in range(len(items))]
    for indices in loading.values():
        for second in indices:
            connected[second].update(first for first in indices if first < second)
    pairs: list[tuple[int, ...]] = []
    shared: list[tuple[int, int]] = []
    rows: list[tuple[int, int]] = []
    size = 0
    for second, others in enumerate(connected):
        for first in sorted(others):
            both = [
                (slot, slots[first][joint])
                for joint, slot in slots[second].items()
                if joint in slots[first]
            ]
            pairs.append((second, first, len(shared), len(both)))
            shared += both
        for row in range(starts[second], starts[second + 1]):
            rows.append((starts[min(others)], size))
            size += row + 1 - starts[min(others)]
    return pairs, shared, rows, size


def exerted_plan(mechanism: Mechanism, size: int, along: Along, prescribed: Array) -> Plan:
    """Return the plan for what is exerted along some coordinates, see `inverse_dynamics.c`.

    Args:
        mechanism: the mechanism.
        size: number b of wrenches.
        along: its velocity coordinates.
        prescribed: the coordinates; nothing is exerted along the others.
    """
    efforts: list[tuple[int, ...]] = []
    moments: list[int] = []
    factors: list[float] = []
    for column in prescribed.tolist():
        start = len(moments)
        for index, coupling in enumerate(mechanism.couplings):
            if column in coupling.successor_columns:
                moments.append(index)
                factors.append(-1.0)
            if column in coupling.predecessor_columns:
                moments.append(index)
                factors.append(coupling.ratio)
        body, component = divmod(along.row_of(column), 6)
        efforts.append((column, body, component, start, len(moments)))
    sizes = len(along), size, len(mechanism.couplings), int(along.is_along_axes)
    units = [along.units_of(column) for column in prescribed.tolist()]
    return Plan("exerted", (sizes, efforts, moments), (units, factors))


def _padded(matrix: Array) -> Array:
    """Return a matrix `(6, k)`, row by row, behind which zeros stand for what six columns have."""
    padded = np.zeros(36)
    padded[: matrix.size] = matrix.ravel()
    return padded
