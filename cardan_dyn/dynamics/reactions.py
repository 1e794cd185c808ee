"""Reactions: the wrench in every joint and the forces that keep the loops closed.

Inverse dynamics of the open tree gives efforts in the passive joints that differ from the given
loads. The closure forces of the loops make up for the difference, and the wrenches of the open tree
with the closure forces added are the joint wrenches of the closed chain. The groups are solved from
the load to the drive, against the order in which their motion is solved.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from ..arrays import Array, consecutive
from ..kinematics.closing.all_groups import ClosedState, Kinematics
from ..kinematics.closing.batch_model import placement
from ..kinematics.loops.needs import Needs
from ..mechanism.mechanism import Mechanism
from .closure_forces import ClosureForces
from .indeterminate import IndeterminacyRule, LeastNorm, SelfStress, influence
from .open_tree import Along, LoadCase, OpenTree

UNIQUE_TOLERANCE = 1e-9
"""Influence of self-stresses, forces times the length, below which a component counts as unique.

Rounding of the null spaces is some 1e-15 times the condition number of the closure equations, which
leaves room for a condition of 1e5. Self-stresses are of size 1, so a component that they change at
all usually changes by much more than this.
"""


class Reactions(NamedTuple):
    """Wrenches of one load case.

    Attributes:
        wrenches: `(N, b, 6)` wrench of every joint in its frame: the bodies of the model in order,
            then `fixed` loops in file order.
        closure_forces: per loop `(N, 6)`, the wrench of its predecessor on its successor in the
            axes of the base of its group's batch model, about its origin; then per coupling
            `(N, 1)`, its moment (a force at a slide) at its successor's joint.
        indeterminate_couplings: indices of the couplings whose moment is not unique.
        influence: `(b, 6)` greatest change of a component per unit of self-stress, or of forces
            that a coupling may exert, see `Undescribed`.
        idle_accelerations: `(N, nv)` what idle rods add to the joint accelerations, see
            `IdleSpins`; None without such rods.
        teeth: couplings (index) to moments `(N, 1)` that teeth exert in their place.
    """

    wrenches: Array
    closure_forces: list[Array]
    indeterminate_couplings: set[int]
    influence: Array
    idle_accelerations: Array | None = None
    teeth: Mapping[int, Array] = MappingProxyType({})


def superposed(cases: Sequence[Reactions], factors: Sequence[float]) -> Reactions:
    """Return the sum of the reactions of load cases, each times its factor."""

    def total(arrays: Sequence[Array]) -> Array:
        return np.asarray(sum(factor * term for factor, term in zip(factors, arrays, strict=True)))

    first = cases[0]
    spins = [case.idle_accelerations for case in cases if case.idle_accelerations is not None]
    return Reactions(
        total([case.wrenches for case in cases]),
        [total(forces) for forces in zip(*(case.closure_forces for case in cases), strict=True)],
        first.indeterminate_couplings,
        first.influence,
        total(spins) if spins else None,
    )


class ReactionSolver:
    """Computes reactions for the closed positions of one problem.

    Attributes:
        size: number b of wrenches: of the bodies, then of the `fixed` loops.
        subspace: `(nv, 6)` unit twist of each velocity coordinate in its joint's frame.
        along: the same coordinates, along which wrenches have components.
        opened: `(b, 6)` how far couplings change components that state no forces; None if all do.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        kinematics: Kinematics,
        active: set[int],
        rule: IndeterminacyRule | None = None,
    ) -> None:
        """Make the solver.

        Args:
            mechanism: the mechanism.
            kinematics: the groups whose motion is solved.
            active: indices of the groups whose closure forces are solved.
            rule: chooses what is statically indeterminate; the least norm if None.
        """
        self._mechanism = mechanism
        self._tree = OpenTree(mechanism, kinematics, active)
        self._closure = ClosureForces(mechanism)
        self.size = self._closure.size
        self._solved_loops = {
            loop for index in active for loop in kinematics.solvers[index].group.loops
        }
        self._slip_units = {
            coupling: unit
            for solver in kinematics.solvers
            for coupling, unit in zip(
                solver.group.couplings, solver.equations.slip_units.tolist(), strict=True
            )
        }
        # Of the groups that carry a body, the first one.
        self._carrying_group = {
            body: index
            for index, solver in reversed(list(enumerate(kinematics.solvers)))
            for body in solver.group.bodies
        }
        self._rule = rule or LeastNorm(mechanism.characteristic_length, wrenches_in_norm(mechanism))
        self.opened = self._opened_by_couplings()
        model = mechanism.model
        owners = np.array(
            [joint - 1 for joint in range(1, model.njoints) for _ in range(model.nvs[joint])]
        )
        self.subspace = np.zeros((model.nv, 6))
        for solver in kinematics.solvers:
            carried = solver.batch.moved_body >= 0
            self.subspace[carried] = solver.batch.subspace[carried]
        self.along, self._coordinates = Along(owners, self.subspace), np.arange(model.nv)
        groups = [solver.group for solver in kinematics.solvers]
        # From the load to the drive.
        self._active = [
            index
            for index in range(len(groups) - 1, -1, -1)
            if index in active and (groups[index].loops or groups[index].couplings)
        ]
        self._spins = None
        if any(solver.group.idle for solver in kinematics.solvers):
            from .idle_spins import IdleSpins  # Few mechanisms have idle rods.

            mass = sum(float(inertia.mass) for inertia in model.inertias)
            greatest = mass * mechanism.characteristic_length**2
            self._spins = IdleSpins(self._tree, self.along, greatest)

    def solve(self, state: ClosedState, cases: Sequence[LoadCase]) -> list[Reactions]:
        """Return the reactions of every load case at closed positions.

        What depends on the positions alone is computed once for all cases.
        """
        wrenches = self._tree.wrenches(state, cases, self.size)
        spins = self._spins.added(state, cases, wrenches) if self._spins else None
        forces, changes, indeterminate = self._closed(state, cases, wrenches)
        if self.opened is not None:
            np.maximum(changes, self.opened, out=changes)
        for teeth in self._mechanism.teeth:
            if teeth.coupling in indeterminate:
                changes[[self._mechanism.joints[name].id - 1 for name in teeth.joints]] = 1.0
        return [
            Reactions(
                wrenches[..., case],
                [force[..., case] for force in forces],
                indeterminate,
                changes,
                None if spins is None else spins[..., case],
            )
            for case in range(len(cases))
        ]

    def _opened_by_couplings(self) -> Array | None:
        """Return what `opened` is."""
        mechanism = self._mechanism
        if not mechanism.undescribed:
            return None
        from ..mechanism.undescribed import greatest_changes  # Few mechanisms have couplings.

        indices = {name: joint.id - 1 for name, joint in mechanism.joints.items() if joint.parts}
        for loop, index in self._closure.fixed_loops.items():
            indices[mechanism.loops[loop].joint] = index
        result = np.zeros((self.size, 6))
        result[list(indices.values())] = greatest_changes(mechanism.undescribed, indices)
        return result

    def _closed(
        self, state: ClosedState, cases: Sequence[LoadCase], wrenches: Array
    ) -> tuple[list[Array], Array, set[int]]:
        """Return closure forces, and what of them and of the wrenches is not unique.

        Args:
            state: closed positions.
            cases: c load cases.
            wrenches: `(N, b, 6, c)` of the open tree; they become those of the closed chain.

        Returns:
            Closure forces `(N, 6, c)` or `(N, 1, c)`, see `Reactions`, as well as its influence and
            the indices of indeterminate couplings.
        """
        forces, self_stresses = self._one_solution(state, cases, wrenches)
        amounts = self._amounts(state, wrenches, self_stresses)
        for item, amount in zip(self_stresses, amounts, strict=True):
            wrenches[:, item.joints] += item.wrenches(amount)
            for index, unit_forces in item.forces.items():
                forces[index] += unit_forces @ amount
        changes = influence(self_stresses, self.size, self._mechanism.characteristic_length)
        loops = len(self._mechanism.loops)
        indeterminate = {
            index - loops
            for item in self_stresses
            for index, unit_forces in item.forces.items()
            if index >= loops
            and self._slip_units[index - loops] * np.abs(unit_forces).max(initial=0.0)
            > UNIQUE_TOLERANCE
        }
        return forces, changes, indeterminate

    def solved(self, needed: Needs) -> tuple[list[str], slice | Array]:
        """Return the joints whose wrenches are solved, and their indices among all wrenches.

        The latter ascend, and are a slice if there are no gaps, since slices make no copies.
        """
        joints = {
            joint.name: joint.id - 1
            for joint in self._mechanism.joints.values()
            if joint.parts and joint.id - 1 in needed.known_bodies
        }
        for loop, index in self._closure.fixed_loops.items():
            if loop in self._solved_loops:
                joints[self._mechanism.loops[loop].joint] = index
        names = sorted(joints, key=joints.__getitem__)
        return names, consecutive(np.array([joints[name] for name in names], dtype=int))

    def efforts(self, reactions: Reactions) -> Array:
        """Return what loads, drives and held joints exert along the coordinates, `(N, nv)`.

        The moments of couplings are taken off, since they are neither of these.
        """
        efforts = self.along.efforts(reactions.wrenches[..., None], self._coordinates)[..., 0]
        moments = reactions.closure_forces[len(self._mechanism.loops) :]
        for coupling, moment in zip(self._mechanism.couplings, moments, strict=True):
            efforts[:, coupling.successor_columns] -= moment
            efforts[:, coupling.predecessor_columns] += coupling.ratio * moment
        return efforts

    def _amounts(
        self, state: ClosedState, wrenches: Array, self_stresses: list[SelfStress]
    ) -> list[Array]:
        """Return how much of each self-stress the rule adds, see `IndeterminacyRule.amounts`."""
        if not self_stresses:
            return []
        rotations = {}
        if self._rule.oriented:
            loaded = {joint for item in self_stresses for joint in item.joints.tolist()}
            rotations = {
                joint: self._rotation_from_zero(state, joint)
                for joint in self._rule.oriented & loaded & set(range(self._tree.bodies))
            }
        return self._rule.amounts(wrenches, self_stresses, rotations)

    def _one_solution(
        self, state: ClosedState, cases: Sequence[LoadCase], wrenches: Array
    ) -> tuple[list[Array], list[SelfStress]]:
        """Return one solution of the equations of motion, and the self-stresses it may differ by.

        Args:
            state: closed positions.
            cases: c load cases.
            wrenches: `(N, b, 6, c)` of the open tree; what closure forces add to them is added.

        Returns:
            Closure forces `(N, 6, c)` or `(N, 1, c)`, see `Reactions`, and the self-stresses of all
            groups.
        """
        mechanism, count = self._mechanism, len(state.x)
        # What acts along the coordinates: loads, then also the couplings of groups solved so far.
        given = np.empty((count, mechanism.model.nv, len(cases)))
        for index, case in enumerate(cases):
            given[..., index] = case.loads
        forces = [np.zeros((count, 6, len(cases))) for _ in mechanism.loops]
        forces += [np.zeros((count, 1, len(cases))) for _ in mechanism.couplings]
        self_stresses: list[SelfStress] = []
        for index in self._active:
            group_state = state.groups[index]
            group = group_state.group
            missing = given.take(group.passives, 1)
            missing -= self.along.efforts(wrenches, group.passives)
            forces_of_group = self._closure.of_multipliers(
                group_state, group_state.solve_transposed(missing)
            )
            for item, force in forces_of_group.items():
                forces[item] += force
            for local, loop in enumerate(group.loops):
                joints, added = self._closure.on_path(group_state, local, loop, forces[loop])
                wrenches[:, joints] += added
            for coupling_index in group.couplings:
                coupling = mechanism.couplings[coupling_index]
                moment = forces[len(mechanism.loops) + coupling_index]
                given[:, coupling.successor_columns] += moment
                given[:, coupling.predecessor_columns] -= coupling.ratio * moment
            self_stresses += self._closure.self_stresses(group_state)
        return forces, self_stresses

    def _rotation_from_zero(self, state: ClosedState, body: int) -> Array:
        """Return rotations `(N, 3, 3)` from a joint's frame to its frame at coordinate zero.

        The latter stays with the parent, as compliances do.
        """
        joint = next(item for item in self._mechanism.joints.values() if item.id == body + 1)
        group_state = state.groups[self._carrying_group[body]]
        batch, actions = group_state.batch, group_state.actions
        turned = placement(actions, batch.index_of[body])[0].transpose(2, 0, 1)
        first = batch.index_of[joint.parts[0].id - 1]
        zero, carrier = batch.rotation_at_zero(first), int(batch.parents[first])
        if carrier >= 0:
            zero = placement(actions, carrier)[0].transpose(2, 0, 1) @ zero
        return np.asarray(np.swapaxes(zero, -1, -2) @ turned)


def wrenches_in_norm(mechanism: Mechanism) -> frozenset[int]:
    """Return the indices of the wrenches that a norm over all joints counts: each joint once.

    A joint of several parts has a body per part; the inner ones are massless and transmit the same
    wrench. The wrenches of `fixed` loops follow those of the bodies.
    """
    bodies = mechanism.model.njoints - 1
    joints = {joint.id - 1 for joint in mechanism.joints.values() if joint.parts}
    return frozenset(
        joints | set(range(bodies, bodies + sum(loop.is_fixed for loop in mechanism.loops)))
    )
