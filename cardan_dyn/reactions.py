"""Reactions: the wrench in every joint and the forces that keep the loops closed.

Inverse dynamics of the open tree leaves efforts in the passive joints. The closure forces of the
loops are what turns those efforts into the given loads, and RNEA's wrenches with the closure
forces added are the joint wrenches of the closed chain. Forces pass through the groups from the
load to the drive, against the order in which motion passes through them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .coordinates import Array
from .errors import ModelError
from .indeterminate import Choice, LeastNorm, Undetermined
from .kinematics import ClosedMechanism, Kinematics
from .loads import LinkLoad
from .mechanism import Mechanism
from .plan import Needs
from .solver import Closed
from .tree import ancestors
from .twin import placement

UNIQUE_TOLERANCE = 1e-9
"""Greatest influence of an undetermined closure force on a component that counts as unique."""


@dataclass(frozen=True, eq=False, repr=False)
class LoadCase:
    """What acts on a mechanism at closed positions.

    Attributes:
        dynamics: joint velocities and accelerations `(N, nv)`, or None where neither inertia nor
            gravity acts.
        loads: `(N, nv)` or `(1, nv)` efforts added at the joints [N·m, N].
        link_loads: wrenches on links.
        gravity: `(3,)` [m/s²].
    """

    dynamics: tuple[Array, Array] | None
    loads: Array
    link_loads: Sequence[LinkLoad]
    gravity: Array


@dataclass(frozen=True, eq=False, repr=False)
class Reactions:
    """Wrenches of one load case.

    Attributes:
        wrenches: `(N, b, 6)` wrench of every joint in its frame: the bodies of the model in order,
            then `fixed` loops in file order.
        closure: `(N, 6)` per loop: wrench of its predecessor on its successor, in world axes
            about the origin of its group's twin; then `(N, 1)` per coupling: its moment at its
            successor's joint.
        open_couplings: numbers of the couplings whose moment is not unique.
        influence: `(b, 6)` greatest change of a component per unit of undetermined closure force.
    """

    wrenches: Array
    closure: list[Array]
    open_couplings: set[int]
    influence: Array


def superposed(cases: Sequence[Reactions], factors: Sequence[float]) -> Reactions:
    """Return the reactions of load cases, each times a factor, that act together."""

    def total(parts: Sequence[Array]) -> Array:
        return np.asarray(sum(factor * part for factor, part in zip(factors, parts, strict=True)))

    first = cases[0]
    return Reactions(
        total([case.wrenches for case in cases]),
        [total([case.closure[k] for case in cases]) for k in range(len(first.closure))],
        first.open_couplings,
        first.influence,
    )


class ReactionSolver:
    """Computes reactions for the closed positions of one scene.

    Attributes:
        mechanism: the mechanism.
        kinematics: its groups.
        fixed: numbers of the `fixed` loops, which have a wrench but no body of their own.
        home: body to the number of the group in which its inertia is accounted for.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        kinematics: Kinematics,
        active: set[int],
        choice: Choice | None = None,
    ) -> None:
        """Make the solver.

        Args:
            mechanism: the mechanism.
            kinematics: the groups whose motion is solved.
            active: numbers of those whose closure forces are.
            choice: rule for what is undetermined; the least norm if None.
        """
        self.active = active
        self.mechanism = mechanism
        self.kinematics = kinematics
        self.fixed = [
            number
            for number, loop in enumerate(mechanism.loops)
            if not mechanism.joints[loop.joint].parts
        ]
        self.bodies = mechanism.model.njoints - 1
        self.home = {
            body: number
            for number, solver in enumerate(kinematics.solvers)
            for body in solver.group.massive
        }
        self._carriers = {
            body: number
            for number, solver in reversed(list(enumerate(kinematics.solvers)))
            for body in solver.twin.local
        }
        self._choice = choice or LeastNorm(mechanism.length, counted(mechanism))
        model = mechanism.model
        self._owners = np.array(
            [index - 1 for index in range(1, model.njoints) for _ in range(model.nvs[index])]
        )
        self.subspace = np.zeros((model.nv, 6))
        for solver in kinematics.solvers:
            carried = solver.twin.owner >= 0
            self.subspace[carried] = solver.twin.subspace[carried]

    def carrier(self, body: int) -> int:
        """Return the number of a group that tells where a body (0-based) is.

        Raises:
            ModelError: the outputs leave the body out.
        """
        if body not in self._carriers:
            name = self.mechanism.model.names[body + 1]
            raise ModelError(
                f"the outputs of the scene leave out joint {name!r}; name it among the outputs"
            )
        return self._carriers[body]

    def solve(self, here: ClosedMechanism, cases: Sequence[LoadCase]) -> list[Reactions]:
        """Return the reactions of every load case at closed positions.

        What depends on the positions alone is done once for all cases.
        """
        count = len(here.x)
        wrenches = np.zeros((count, self.bodies + len(self.fixed), 6, len(cases)))
        for number, case in enumerate(cases):
            self._inertial(wrenches[..., number], here, case)
            for load in case.link_loads:
                self._apply(wrenches[..., number], here, load)
        closure = [np.zeros((count, 6, len(cases))) for _ in self.mechanism.loops]
        closure += [np.zeros((count, 1, len(cases))) for _ in self.mechanism.couplings]
        undetermined: list[Undetermined] = []
        # Given efforts, and what couplings of later groups exert.
        given = np.empty((count, self.mechanism.model.nv, len(cases)))
        for number, case in enumerate(cases):
            given[..., number] = case.loads
        for place_of_group, closed in reversed(list(enumerate(here.groups))):
            group = closed.solver.group
            if not (group.loops or group.couplings) or place_of_group not in self.active:
                continue
            unmet = given[:, group.passives] - self._efforts_of(wrenches, group.passives)
            multipliers = closed.solve_transposed(unmet)
            for number, forces in self._forces(closed, multipliers).items():
                closure[number] += forces
            for place, number in enumerate(group.loops):
                joints, spread = self._on_path(closed, place, number, closure[number])
                wrenches[:, joints] += spread
            for number in group.couplings:
                coupling = self.mechanism.couplings[number]
                moment = closure[len(self.mechanism.loops) + number]
                given[:, coupling.successor_columns] += moment
                given[:, coupling.predecessor_columns] -= coupling.ratio * moment
            undetermined += self.undetermined(closed)
        influence = np.zeros(wrenches.shape[1:3])
        if undetermined:
            loaded = {joint for item in undetermined for joint in item.joints.tolist()}
            rotations = {
                joint: self._from_parent(here, joint)
                for joint in self._choice.oriented & loaded & set(range(self.bodies))
            }
            influence = self._choice.apply(wrenches, closure, undetermined, rotations)
        loops = len(self.mechanism.loops)
        open_couplings = {
            number - loops
            for item in undetermined
            for number, forces in item.forces.items()
            if number >= loops and np.max(np.abs(forces), initial=0.0) > UNIQUE_TOLERANCE
        }
        return [
            Reactions(
                wrenches[..., number],
                [forces[..., number] for forces in closure],
                open_couplings,
                influence,
            )
            for number in range(len(cases))
        ]

    def _inertial(self, wrenches: Array, here: ClosedMechanism, case: LoadCase) -> None:
        """Add what inertia and gravity ask of the open tree to wrenches `(N, b, 6)`."""
        if case.dynamics is None:
            return
        for number, closed in enumerate(here.groups):
            twin = closed.solver.twin
            # Without closure forces, virtual work needs the inertia of all that moves.
            if twin.heavy and (not self.active or number in self.active):
                v, a = (twin.velocity(rates) for rates in case.dynamics)
                found = twin.inverse_dynamics(closed.q, v, a, case.gravity)
                wrenches[:, consecutive(twin.bodies)] += found.reshape(len(v), -1, 6)

    def _apply(self, wrenches: Array, here: ClosedMechanism, load: LinkLoad) -> None:
        """Take a load on a link off wrenches `(N, b, 6)`."""
        home = self.home.get(load.body)
        if home is None:
            return  # On a body that was left out.
        twin, actions = self.kinematics.solvers[home].twin, here.groups[home].actions
        wrench = load.about_origin(actions, twin.local[load.body])
        for body in ancestors(self.mechanism.model, load.body + 1):
            first = 6 * twin.local[body]
            wrenches[:, body] -= np.matmul(actions[:, first : first + 6], wrench[:, :, None])[
                :, :, 0
            ]

    def solved(self, needed: Needs) -> tuple[list[str], Array]:
        """Return the joints whose wrenches are solved, and their places among all wrenches."""
        joints = {
            joint.name: joint.index - 1
            for joint in self.mechanism.joints.values()
            if joint.parts and joint.index - 1 in needed.complete
        }
        solved = {
            number
            for place, solver in enumerate(self.kinematics.solvers)
            if place in self.active
            for number in solver.group.loops
        }
        for place, number in enumerate(self.fixed):
            if number in solved:
                joints[self.mechanism.loops[number].joint] = self.bodies + place
        return list(joints), np.array(list(joints.values()), dtype=int)

    def efforts(self, wrenches: Array) -> Array:
        """Return the components of wrenches `(N, b, 6)` along the coordinates, `(N, nv)`."""
        return np.asarray(np.einsum("nki,ki->nk", wrenches[:, self._owners], self.subspace))

    def _efforts_of(self, wrenches: Array, coordinates: Array) -> Array:
        """Return components of wrenches `(N, b, 6, c)` along some coordinates, `(N, k, c)`."""
        chosen = wrenches[:, self._owners[coordinates]]
        return np.asarray(np.einsum("nkic,ki->nkc", chosen, self.subspace[coordinates]))

    def _from_parent(self, here: ClosedMechanism, body: int) -> Array:
        """Return rotations `(N, 3, 3)` from a joint's frame to its frame at coordinate zero."""
        model = self.mechanism.model
        joint = next(joint for joint in self.mechanism.joints.values() if joint.index == body + 1)
        first = joint.parts[0].index
        home = self.carrier(body)
        twin, actions = self.kinematics.solvers[home].twin, here.groups[home].actions
        own = placement(actions, twin.local[body])[0].transpose(2, 0, 1)
        zero = model.jointPlacements[first].rotation
        if model.parents[first]:
            parent = placement(actions, twin.local[model.parents[first] - 1])[0]
            zero = parent.transpose(2, 0, 1) @ zero
        return np.asarray(np.swapaxes(zero, -1, -2) @ own)

    def _forces(self, closed: Closed, multipliers: Array) -> dict[int, Array]:
        """Return closure forces `(N, 6, k)` and coupling moments `(N, 1, k)` by their number.

        Args:
            closed: positions of a group.
            multipliers: `(N, R, k)`.
        """
        result, start = {}, 0
        solver = closed.solver
        for place, number in enumerate(solver.group.loops):
            rows = solver.reduction.rows[place]
            part = multipliers[:, start : start + rows.shape[1]]
            result[number] = solver.closure.wrench(place, closed.actions, rows @ part)
            start += rows.shape[1]
        for number in solver.group.couplings:
            # The successor's coefficient in a coupling's row is -1, its effort the multiplier.
            result[len(self.mechanism.loops) + number] = multipliers[:, start : start + 1]
            start += 1
        return result

    def _on_path(
        self, closed: Closed, place: int, number: int, forces: Array
    ) -> tuple[slice | Array, Array]:
        """Return the joints on a loop and what closure forces `(N, 6, k)` add to their wrenches.

        Returns:
            Places of the joints among all wrenches, and `(N, J, 6, k)`.
        """
        solver = closed.solver
        signs = solver.closure.signs[place]
        (path,) = np.nonzero(signs)
        rows = consecutive((6 * path[:, None] + np.arange(6)).ravel())
        found = closed.actions[:, rows] @ forces
        found = found.reshape(len(found), len(path), 6, -1)
        found *= signs[path][:, None, None]
        joints = solver.twin.bodies[path]
        if number in self.fixed:
            rotation, position = solver.closure.sides[place][1].place(closed.actions)
            columns = rotation.transpose(2, 1, 0)
            action = np.zeros((len(found), 6, 6))
            action[:, :3, :3] = action[:, 3:, 3:] = columns
            action[:, 3:, :3] = np.cross(position.T[:, None, :], columns)
            joints = np.append(joints, self.bodies + self.fixed.index(number))
            found = np.concatenate([found, (action @ forces)[:, None]], axis=1)
        return consecutive(joints), found

    def undetermined(self, closed: Closed) -> list[Undetermined]:
        """Return the closure forces of a group that no passive effort feels."""
        solver, found = closed.solver, []
        if closed.null.shape[2]:
            found.append(self._forces(closed, closed.null))
        for place, number in enumerate(solver.group.loops):
            null = solver.reduction.null[place]
            if null.shape[1]:
                found.append({number: solver.closure.wrench(place, closed.actions, null)})
        return [Undetermined(item, *self._effect(closed, item)) for item in found]

    def _effect(self, closed: Closed, forces: dict[int, Array]) -> tuple[Array, Array]:
        """Return the joints that closure forces load, and what they add, `(N, J, 6, k)`."""
        every = np.arange(self.bodies + len(self.fixed))
        parts = [
            self._on_path(closed, place, number, forces[number])
            for place, number in enumerate(closed.solver.group.loops)
            if number in forces
        ]
        if len(parts) == 1:
            ((joints, spread),) = parts
            return every[joints], spread
        loaded = np.array(sorted({k for part, _ in parts for k in every[part].tolist()}), dtype=int)
        size = next(iter(forces.values())).shape[2]
        total = np.zeros((len(closed.q), len(loaded), 6, size))
        for joints, spread in parts:
            total[:, np.searchsorted(loaded, every[joints])] += spread
        return loaded, total


def counted(mechanism: Mechanism) -> frozenset[int]:
    """Return the places of wrenches that a norm over all joints counts: each joint once.

    The massless bodies between the parts of a joint pass its wrench on; `fixed` loops come last.
    """
    bodies = mechanism.model.njoints - 1
    own = {joint.index - 1 for joint in mechanism.joints.values() if joint.parts}
    fixed = sum(not joint.parts for joint in mechanism.joints.values())
    return frozenset(own | set(range(bodies, bodies + fixed)))


def consecutive(places: Array) -> slice | Array:
    """Return places as a slice if they follow one another, since slices make no copies."""
    if places.size and places[-1] - places[0] == places.size - 1 and np.all(np.diff(places) == 1):
        return slice(int(places[0]), int(places[-1]) + 1)
    return places
