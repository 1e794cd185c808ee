"""InverseDynamics: one block of samples through all steps, and blocks put together."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..arrays import Array
from ..forces.link_loads import LinkLoad
from ..kinematics.all_groups import ClosedState, Kinematics
from ..kinematics.needs import Needs
from ..problem.problem import Problem
from ..proof.residuals import Claim, Residuals, overflow
from .open_tree import LoadCase
from .reactions import UNIQUE_TOLERANCE, Reactions, ReactionSolver

if TYPE_CHECKING:
    from ..proof.free_bodies import FreeBodies


class Inputs(NamedTuple):
    """What is prescribed for a block of samples.

    Attributes:
        positions, speeds, accelerations: of the drives, `(N, d)`.
        loads: efforts added at the joints, `(N, nv)` or `(1, nv)`.
        link_loads: links and the wrenches on them.
        turns: whole turns `(N, size)` that angles lack.
        has_rates: whether the sweep has any speed or acceleration.
    """

    positions: Array
    speeds: Array
    accelerations: Array
    loads: Array
    link_loads: dict[str, LinkLoad]
    turns: Array
    has_rates: bool


@dataclass(frozen=True, eq=False, repr=False)
class Solution:
    """What a block of samples, or all of them, leave behind.

    Attributes:
        x: `(N, size)` coordinates.
        v, a: joint rates `(N, nv)`.
        velocity_ratios: `(N, nv, d)` joint velocities per unit speed of each drive.
        wrenches: `(N, b, 6)`, see `Reactions.wrenches`.
        efforts: `(N, nv)` what drives and held joints exert, loads taken off.
        coupling_moments: `(N, G)` moments of the couplings at their successors' joints.
        condition: `(N,)` see `Sweep.condition`.
        loop_error: `(N,)` closure error.
        residuals: balance of bodies and power.
        influence: `(b, 6)`, see `Reactions.influence`.
        indeterminate_couplings: numbers of the couplings whose moment is not unique.
    """

    x: Array
    v: Array
    a: Array
    velocity_ratios: Array
    wrenches: Array
    efforts: Array
    coupling_moments: Array
    condition: Array
    loop_error: Array
    residuals: Residuals
    influence: Array
    indeterminate_couplings: set[int]

    @property
    def unique(self) -> Array:
        """`(b, 6)` which components of all wrenches follow from the laws of motion alone."""
        return self.influence < UNIQUE_TOLERANCE


class InverseDynamics:
    """Motion, reactions and residuals of one problem.

    Attributes:
        has_mass: whether any body has mass.
    """

    def __init__(
        self,
        problem: Problem,
        kinematics: Kinematics,
        reactions: ReactionSolver,
        needed: Needs,
        decided: Array,
    ) -> None:
        """Make the inverse dynamics.

        Args:
            problem: what is prescribed and what acts.
            kinematics: the groups that are solved.
            reactions: their reactions.
            needed: what the outputs need.
            decided: velocity coordinates of the passive joints whose motion is solved.
        """
        self._problem = problem
        self._mechanism = mechanism = problem.mechanism
        self._kinematics = kinematics
        self._decided = decided
        self._claimed, self._claimed_indices = reactions.solved(needed)
        self._reactions = reactions
        self._needed = needed
        self._prescribed = problem.prescribed_columns
        self._has_weight = bool(np.any(problem.gravity))
        slides = np.any(reactions.subspace[:, :3] != 0.0, axis=1)
        scale = np.where(slides, mechanism.characteristic_length, 1.0)
        self._ratio_scale = scale[kinematics.drives] / scale[:, None]
        self.has_mass = any(solver.batch.has_mass for solver in kinematics.solvers)

    @cached_property
    def bodies(self) -> FreeBodies:
        """What proves results; the description's text is read again when it is first asked for."""
        from ..proof.constraints import Motion
        from ..proof.free_bodies import FreeBodies, Setup

        problem, mechanism = self._problem, self._mechanism
        known = np.zeros(mechanism.model.nv, dtype=bool)
        known[self._prescribed] = known[self._decided] = True
        motion = Motion(problem.drives, problem.held, known)
        return FreeBodies(
            mechanism.reread,
            mechanism.coordinates,
            mechanism.characteristic_length,
            Setup(problem.gravity, motion, self._claimed),
        )

    def prove_flags(self, found: Solution) -> None:
        """Refuse what a result says of uniqueness where self-stresses contradict it.

        Raises:
            AccuracyError: see `FreeBodies.prove_flags`.
        """
        if self._claimed:
            unique = found.unique[self._claimed_indices]
            self.bodies.prove_flags(found.x, unique, float(np.max(found.condition)))

    def solve(self, here: ClosedState, inputs: Inputs) -> Solution:
        """Return motion, reactions and residuals at closed positions."""
        velocity_ratios, v, a = self.rates(here, inputs.speeds, inputs.accelerations)
        dynamics = (v, a) if self.has_mass and (inputs.has_rates or self._has_weight) else None
        links = list(inputs.link_loads.values())
        case = LoadCase(dynamics, inputs.loads, links, self._problem.gravity)
        (reactions,) = self._reactions.solve(here, [case])
        return self.proven(here, inputs, (velocity_ratios, v, a), reactions)

    def proven(
        self,
        here: ClosedState,
        inputs: Inputs,
        rates: tuple[Array, Array, Array],
        reactions: Reactions,
    ) -> Solution:
        """Return reactions with the residuals that prove them, and all else that they tell.

        Args:
            here: closed positions.
            inputs: what is prescribed.
            rates: from `rates`.
            reactions: at those positions, rates and inputs.
        """
        count = len(here.x)
        velocity_ratios, v, a = rates
        efforts = self._reactions.efforts(reactions)
        exerted = np.zeros_like(efforts)
        if self._needed.efforts_alone:
            # Virtual work gives the drive efforts without closure forces.
            drive = (efforts - inputs.loads)[:, None, :] @ velocity_ratios
            exerted[:, self._kinematics.drives] = drive[:, 0]
        else:
            exerted[:, self._prescribed] = (efforts - inputs.loads)[:, self._prescribed]
        coupling_moments = reactions.closure_forces[len(self._mechanism.loops) :]
        couplings = np.concatenate([np.zeros((count, 0)), *coupling_moments], axis=1)
        residuals = self.bodies.check(
            Claim(
                x=here.x,
                turns=inputs.turns,
                v=v,
                a=a,
                positions=inputs.positions,
                speeds=inputs.speeds,
                accelerations=inputs.accelerations,
                velocity_ratios=velocity_ratios,
                wrenches=reactions.wrenches[:, self._claimed_indices],
                exerted=exerted,
                couplings=couplings,
                loads=inputs.loads,
                link_loads=inputs.link_loads,
                has_rates=inputs.has_rates,
            )
        )
        return Solution(
            x=here.x,
            v=v,
            a=a,
            velocity_ratios=velocity_ratios,
            wrenches=reactions.wrenches,
            efforts=exerted,
            coupling_moments=couplings,
            condition=self.condition(here, velocity_ratios) * residuals.cancellation,
            loop_error=np.maximum(here.residual, residuals.loop_error),
            residuals=residuals,
            influence=reactions.influence,
            indeterminate_couplings=reactions.indeterminate_couplings,
        )

    def rates(
        self, here: ClosedState, speeds: Array, accelerations: Array
    ) -> tuple[Array, Array, Array]:
        """Return velocity_ratios `(N, nv, d)`, velocities and accelerations `(N, nv)`."""
        kinematics, count = self._kinematics, len(here.x)
        velocity_ratios = np.empty((count, self._mechanism.model.nv, speeds.shape[1]))
        for number, unit in enumerate(np.eye(speeds.shape[1])):
            velocity_ratios[:, :, number] = kinematics.rates(here, np.tile(unit, (count, 1)))
        if np.any(speeds):
            v = (velocity_ratios @ speeds[:, :, None])[:, :, 0]
            return velocity_ratios, v, kinematics.accelerations(here, v, accelerations)
        v = np.zeros(velocity_ratios.shape[:2])
        if np.any(accelerations):
            return velocity_ratios, v, (velocity_ratios @ accelerations[:, :, None])[:, :, 0]
        return velocity_ratios, v, v

    def condition(self, here: ClosedState, velocity_ratios: Array) -> Array:
        """Return by how much rounding of positions is magnified in velocities `(N,)`.

        Args:
            here: closed positions.
            velocity_ratios: `(N, nv, d)`.
        """
        ratios = np.abs(velocity_ratios) * self._ratio_scale
        return here.condition * np.max(ratios, axis=(1, 2), initial=1.0)


def joined(blocks: list[Solution], positions: Array) -> Solution:
    """Return all blocks as one.

    Raises:
        AccuracyError: a residual misses its tolerance, or numbers overflow.
    """
    arrays = {
        field.name: np.concatenate([getattr(block, field.name) for block in blocks])
        for field in fields(Solution)
        if field.name not in ("influence", "indeterminate_couplings", "residuals")
    }
    for name in ("x", "v", "a", "wrenches", "efforts"):
        if not np.all(np.isfinite(arrays[name])):
            raise overflow(f"the {name}")
    residuals = Residuals.joined([block.residuals for block in blocks])
    residuals.prove(positions, arrays["condition"])
    return Solution(
        residuals=residuals,
        influence=np.max([block.influence for block in blocks], axis=0),
        indeterminate_couplings=set().union(*(block.indeterminate_couplings for block in blocks)),
        **arrays,
    )
