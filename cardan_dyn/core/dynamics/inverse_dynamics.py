"""Inverse dynamics: what is prescribed for samples, what is found of them, and its proof."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...kit.arrays import NOTHING, Array, consecutive
from ..elements.link_loads import LinkLoad
from ..kinematics.closing.all_groups import ClosedState, Kinematics
from ..kinematics.loops.groups import Group
from ..problem.acting import Acting
from ..problem.problem import Problem
from ..problem.samples import Targets
from ..proof.residuals import Claim, Residuals, overflow
from .velocity_ratios import VelocityRatios

if TYPE_CHECKING:
    from ..description.description import Description
    from ..elements.element import Element
    from ..mechanism.kept import Kept
    from ..proof.constraints import Motion
    from ..proof.free_bodies import FreeBodies

UNIQUE_TOLERANCE = NOTHING
"""Influence of self-stresses, forces times the length, below which a component counts as unique.

Rounding of what balances itself is some 1e-15 times the condition number of the closure equations,
which leaves room for a condition of 1e5. Self-stresses are of size 1, so a component that they
change at all usually changes by much more than this.
"""
FINITE = {
    "x": "positions of the joints",
    "v": "velocities of the joints",
    "a": "accelerations of the joints",
    "wrenches": "wrenches",
    "efforts": "efforts",
}
"""Arrays of a solution that are refused where numbers overflow, and what messages call them."""


class Inputs(NamedTuple):
    """What is prescribed for some samples.

    Attributes:
        positions: of the drives, `(N, d)`.
        speeds, accelerations: likewise, or `(1, d)`.
        held: positions of all held joints, `(N, h)` or `(1, h)` [rad or m].
        loads: efforts added at the joints, `(N, nv)` or `(1, nv)` [N·m, N].
        link_loads: links and the wrenches that act on them.
        gravity: `(N, 3)` or `(1, 3)` [m/s²].
        inertia: link to the factor on its mass and inertia, `(N,)` or `(1,)`.
        turns: whole turns `(N, size)` to be added to the angles of closed positions.
        time: at which actuators act, `(N,)` or `(1,)` [s].
        has_rates: whether any sample of the sweep, also of other blocks, has a drive speed or
            acceleration.
        is_closed: whether coordinates beside them are closed up to rounding.
    """

    positions: Array
    speeds: Array
    accelerations: Array
    held: Array
    loads: Array
    link_loads: Mapping[str, LinkLoad]
    gravity: Array
    inertia: Mapping[str, Array]
    turns: Array
    time: Array
    has_rates: bool
    is_closed: bool = False

    @staticmethod
    def of(
        problem: Problem,
        targets: Targets,
        acting: Acting,
        turns: Array,
        has_rates: bool | None = None,
        is_closed: bool = False,
    ) -> Inputs:
        """Return what is prescribed for samples.

        Args:
            problem: of the scene.
            targets: N samples.
            acting: flat over these samples.
            turns: see the attribute.
            has_rates: see the attribute; None if there are no other samples.
            is_closed: see the attribute.
        """
        if has_rates is None:
            has_rates = acting.has_rates
        held = problem.held_row
        if targets.held:
            held = np.repeat(held, targets.size, axis=0)
            names = list(problem.held)
            columns = [names.index(name) for name in targets.varied]
            held[:, columns] = targets.designs[targets.design_of]
        if acting is problem.acting_everywhere:
            loads = problem.loads_everywhere
        else:
            loads = problem.load_rows(acting.joint_loads)
        return Inputs(
            targets.positions,
            acting.speeds,
            acting.accelerations,
            held,
            loads,
            acting.link_loads,
            acting.gravity,
            acting.inertia,
            turns,
            acting.time,
            has_rates,
            is_closed,
        )

    def of_samples(self, samples: Array) -> Inputs:
        """Return what is prescribed for some samples, by their indices."""
        count = len(self.positions)

        def chosen(values: Array) -> Array:
            return values[samples] if len(values) == count else values

        return self._replace(
            positions=chosen(self.positions),
            speeds=chosen(self.speeds),
            accelerations=chosen(self.accelerations),
            held=chosen(self.held),
            loads=chosen(self.loads),
            link_loads={
                name: replace(load, force=chosen(load.force), moment=chosen(load.moment))
                for name, load in self.link_loads.items()
            },
            gravity=chosen(self.gravity),
            inertia={name: chosen(factor) for name, factor in self.inertia.items()},
            turns=self.turns[samples],
            time=chosen(self.time),
        )

    def changed(self, row: int = -1, prescribed: int = -1) -> Inputs:
        """Return how these change with a number among them; with none, they do not.

        Args:
            row: of the number, see `Prescribed`.
            prescribed: index of a position, of drives and then of held joints.
        """
        positions, held = np.zeros_like(self.positions), np.zeros_like(self.held)
        drives = positions.shape[1]
        if prescribed >= 0:
            part = positions if prescribed < drives else held
            part[:, prescribed - (0 if prescribed < drives else drives)] = 1.0
        links = {name: load for name, load in self.link_loads.items() if load.body >= 0}
        given = [self.speeds, self.accelerations, self.gravity, self.loads]
        given += [part for load in links.values() for part in (load.force, load.moment)]
        every = [np.zeros_like(part) for part in given]
        first = 0
        for part in every:
            if first <= row < first + part.shape[1]:
                part[:, row - first] = 1.0
            first += part.shape[1]
        speeds, accelerations, gravity, loads, *pairs = every
        moved = zip(links.items(), pairs[::2], pairs[1::2], strict=True)
        return self._replace(
            positions=positions,
            speeds=speeds,
            accelerations=accelerations,
            held=held,
            loads=loads,
            link_loads={
                **self.link_loads,
                **{
                    name: replace(load, force=force, moment=moment, point=np.zeros(3))
                    for (name, load), force, moment in moved
                },
            },
            gravity=gravity,
            inertia={name: np.zeros_like(factor) for name, factor in self.inertia.items()},
            turns=np.zeros_like(self.turns),
        )


class JointRates(NamedTuple):
    """Rates of all joints at closed positions.

    Attributes:
        velocity_ratios: `(N, nv, d)` joint velocities per unit speed of each drive.
        v, a: joint velocities and accelerations `(N, nv)`.
        depends: `(nv, d)` which velocity ratios may differ from zero; all if None.
    """

    velocity_ratios: Array
    v: Array
    a: Array
    depends: Array | None = None


class Solution(NamedTuple):
    """The solution of a block of samples, or what is kept of that of a whole sweep.

    Attributes:
        x: `(N, size)` coordinates.
        v, a: joint velocities and accelerations `(N, nv)`.
        velocity_ratios: joint velocities per unit speed of each drive. These rates are None where
            a sweep does not keep them, see `ProblemSolver.rates_at`.
        wrenches: `(N, k, 6)` of the outputs, each in its joint's frame.
        efforts: `(N, p)` what drives, then held joints exert beside the loads.
        coupling_moments: `(N, G)` moments of the couplings at their successors' joints.
        closure_condition: `(N,)` condition number of the closure equations alone, or how many
            times smaller a pivot of their elimination is than where its order was chosen.
        loop_error: `(N,)` closure error, see `Sweep.loop_residual`.
        residuals: violations of balances and constraints. Of a long sweep, as well as of the two
            quantities above, what decides about all samples is kept.
        influence: `(b, 6)` how much of a self-stress of unit norm a component of a wrench can be,
            or of forces that a coupling may exert, see `Undescribed`.
        indeterminate_couplings: indices of the couplings whose moment is not unique.
        cancellation: `(N,)` see `Residuals.cancellation`; None where the residuals of all samples
            tell it.
    """

    x: Array
    v: Array | None
    a: Array | None
    velocity_ratios: VelocityRatios | None
    wrenches: Array
    efforts: Array
    coupling_moments: Array
    closure_condition: Array
    loop_error: Array
    residuals: Residuals
    influence: Array
    indeterminate_couplings: set[int]
    cancellation: Array | None = None

    @property
    def unique(self) -> Array:
        """`(b, 6)` which components of all wrenches follow from the laws of motion alone."""
        return self.influence < UNIQUE_TOLERANCE

    @property
    def overflown(self) -> set[str]:
        """Names of the arrays in which numbers overflow."""
        arrays: tuple[Any, ...] = self.x, self.v, self.a, self.wrenches, self.efforts
        return overflown(dict(zip(FINITE, arrays, strict=True)))

    def prove(self, positions: Array) -> None:
        """Refuse a solution whose residuals are too great.

        Args:
            positions: of the drives `(N, d)`.

        Raises:
            AccuracyError: a residual exceeds its tolerance, or numbers overflow.
        """
        refuse_overflow(self.overflown)
        self.residuals.prove(positions, self.closure_condition)


class InverseDynamics:
    """Motion, reactions and residuals of one problem.

    Attributes:
        claimed: indices of the wrenches that are solved, ascending.
    """

    inputs_of = staticmethod(Inputs.of)

    @staticmethod
    def refuse_overflown(arrays: Mapping[str, Array]) -> None:
        """Refuse arrays in which numbers overflow, by their names in `FINITE`.

        Raises:
            AccuracyError: there are any.
        """
        refuse_overflow(overflown(arrays))

    def __init__(
        self,
        problem: Problem,
        kinematics: Kinematics,
        groups: Sequence[tuple[Group, bool]],
        known_bodies: Collection[int],
        decided: Array,
        start: Array,
    ) -> None:
        """Make the inverse dynamics.

        Args:
            problem: what is prescribed and what acts.
            kinematics: the groups that are solved.
            groups: these, and whether their forces are solved, too.
            known_bodies: bodies (0-based) on which every wrench is known.
            decided: velocity coordinates of the passive joints whose motion is solved.
            start: `(size,)` closed coordinates at which the drives start.
        """
        self._problem = problem
        self._mechanism = mechanism = problem.mechanism
        self._kinematics = kinematics
        self._decided = decided
        solved = {index for group, wanted in groups if wanted for index in group.loops}
        names = {joint.name for joint in mechanism.joints.values() if joint.id - 1 in known_bodies}
        names |= {
            mechanism.loops[index].joint for index in solved if mechanism.loops[index].is_fixed
        }
        indices = {
            name: mechanism.wrench_indices[name]
            for name in mechanism.wrench_indices
            if name in names
        }
        self._claimed = sorted(indices, key=indices.__getitem__)
        self.claimed = sorted(indices.values())
        self._claimed_indices = consecutive(np.array(self.claimed, dtype=int))
        self._prescribed = problem.prescribed_columns
        # Of scenes with the same motion, flags that were proven, and of which wrenches these are.
        motion = kinematics.key, start.tobytes(), self._prescribed.tobytes()
        self._proven_flags = mechanism.kept.of("proven flags", motion, set[tuple[object, ...]])
        scale = mechanism.coordinates.rate_scale
        self._ratio_scale = scale[kinematics.drives] / scale[:, None]

    @cached_property
    def has_mass(self) -> bool:
        """Whether any body of the solved groups has mass, or a joint a rotor."""
        model, solvers = self._mechanism.model, self._kinematics.solvers
        bodies = {body for item in solvers for body in item.group.inertial_bodies}
        bodies -= {index - 1 for index in self._mechanism.auxiliary_bodies}
        return any(model.armature) or any(
            model.inertias[body + 1].toDynamicParameters().any() for body in bodies
        )

    @property
    def depends(self) -> Array | None:
        """Which velocity ratios may differ from zero, see `JointRates`."""
        return self._kinematics.depends

    @cached_property
    def bodies(self) -> FreeBodies:
        """The proof of results.

        It is made when it is first used, since it reads the description's text again.
        """
        mechanism, motion = self._mechanism, self._motion

        def made() -> FreeBodies:
            return self.bodies_of(mechanism.second_reading, (), mechanism.kept)

        key = motion.drives, motion.held, motion.known.tobytes(), *self._claimed
        bare = mechanism.kept.of("free bodies", key, made)
        return bare.with_elements(self._problem.elements, mechanism.zero)

    def of(self, problem: Problem) -> InverseDynamics:
        """Return that of a problem which differs in elements and what sweeps say anew."""
        result = copy(self)
        result._problem = problem
        if problem.elements is not self._problem.elements:
            result.__dict__.pop("bodies", None)
        return result

    @property
    def _motion(self) -> Motion:
        """Which motion the scene decides."""
        from ..proof.constraints import Motion

        known = np.zeros(self._mechanism.model.nv, dtype=bool)
        known[self._prescribed] = known[self._decided] = True
        return Motion(self._problem.independent, tuple(self._problem.held), known)

    def bodies_of(
        self, description: Description, elements: Sequence[Element], kept: Kept | None = None
    ) -> FreeBodies:
        """Return the bodies of a description like that of the scene, with elements like its own."""
        from ..proof.free_bodies import FreeBodies, Setup

        mechanism = self._mechanism
        setup, length = Setup(self._motion, self._claimed), mechanism.characteristic_length
        bodies = FreeBodies(description, mechanism.coordinates, length, setup, kept)
        return bodies.with_elements(elements, mechanism.zero)

    def prove_flags(self, solution: Solution) -> None:
        """Refuse a solution whose flags of uniqueness are contradicted by self-stresses.

        Flags that were proven before are not proven again.

        Raises:
            AccuracyError: see `FreeBodies.prove_flags`.
        """
        unique = solution.unique[self._claimed_indices]
        flags = unique.tobytes(), *self.claimed
        if self.claimed and flags not in self._proven_flags:
            self.bodies.prove_flags(solution.x, unique, solution.closure_condition)
            self._proven_flags.add(flags)

    def claim(
        self,
        x: Array,
        inputs: Inputs,
        rates: JointRates,
        wrenches: Array,
        exerted: Array,
        couplings: Array,
    ) -> Claim:
        """Return what is to be proven of a solution.

        Args:
            x: `(N, size)` coordinates.
            inputs: what is prescribed.
            rates: of all joints.
            wrenches: `(N, b, 6)`.
            exerted: `(N, nv)` efforts of drives and held joints.
            couplings: `(N, G)` their moments.
        """
        return Claim(
            x=x,
            turns=inputs.turns,
            v=rates.v,
            a=rates.a,
            positions=inputs.positions,
            speeds=inputs.speeds,
            accelerations=inputs.accelerations,
            held=inputs.held,
            velocity_ratios=rates.velocity_ratios,
            wrenches=wrenches[:, self._claimed_indices],
            exerted=exerted,
            couplings=couplings,
            loads=inputs.loads,
            link_loads=inputs.link_loads,
            gravity=inputs.gravity,
            inertia=inputs.inertia,
            has_rates=inputs.has_rates,
            time=inputs.time,
        )

    def joint_rates(self, state: ClosedState, speeds: Array, accelerations: Array) -> JointRates:
        """Return the rates of all joints for drive rates.

        Args:
            state: closed positions.
            speeds: of the drives `(N, d)` or `(1, d)` [rad/s or m/s].
            accelerations: likewise [rad/s² or m/s²].
        """
        kinematics = self._kinematics
        velocity_ratios, depends = kinematics.velocity_ratios(state), kinematics.depends
        if np.count_nonzero(speeds):
            v = (velocity_ratios @ speeds[:, :, None])[:, :, 0]
            a = kinematics.accelerations(state, v, accelerations)
            return JointRates(velocity_ratios, v, a, depends)
        v = np.zeros(velocity_ratios.shape[:2])
        if np.count_nonzero(accelerations):
            # At zero speed, accelerations have the same ratios as velocities.
            a = (velocity_ratios @ accelerations[:, :, None])[:, :, 0]
            return JointRates(velocity_ratios, v, a, depends)
        return JointRates(velocity_ratios, v, v, depends)

    def condition(self, state: ClosedState, velocity_ratios: Array) -> Array:
        """Return `(N,)` the factor by which rounding of positions is magnified in velocities.

        It is the condition number of the closure equations times the greatest velocity ratio.

        Args:
            state: closed positions.
            velocity_ratios: `(N, nv, d)`; slides are compared with angles by the length.
        """
        ratios = np.abs(velocity_ratios) * self._ratio_scale
        return np.asarray(state.condition * ratios.max(axis=(1, 2), initial=1.0))


def overflown(arrays: Mapping[str, Array]) -> set[str]:
    """Return the names of arrays in which numbers overflow."""
    # A sum of squares is finite only if all its terms are, and takes less than looking at each.
    total = 0.0
    for array in arrays.values():
        flat = array.ravel("K")
        total += flat.dot(flat)
    if math.isfinite(total):
        return set()
    return {name for name, array in arrays.items() if not np.isfinite(array).all()}


def refuse_overflow(names: Collection[str]) -> None:
    """Refuse a solution in some arrays of which numbers overflow.

    Raises:
        AccuracyError: there are any; it names the first of `FINITE`.
    """
    for name, words in FINITE.items():
        if name in names:
            raise overflow(f"the {words}")
