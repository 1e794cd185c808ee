"""Pipeline: one block of samples through all steps, and blocks put together."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from .coordinates import Array
from .kinematics import ClosedMechanism, Kinematics
from .loads import LinkLoad
from .mechanism import Mechanism
from .plan import Needs
from .reactions import UNIQUE_TOLERANCE, LoadCase, Reactions, ReactionSolver
from .residuals import Claim, Residuals, overflow

if TYPE_CHECKING:
    from .free_bodies import FreeBodies


@dataclass(frozen=True, eq=False, repr=False)
class Inputs:
    """What is prescribed for a block of samples.

    Attributes:
        positions, speeds, accelerations: of the drives, `(N, d)`.
        loads: efforts added at the joints, `(N, nv)` or `(1, nv)`.
        link_loads: links and the wrenches on them.
        turns: whole turns `(N, size)` that angles lack.
        moving: whether the sweep has any speed or acceleration.
    """

    positions: Array
    speeds: Array
    accelerations: Array
    loads: Array
    link_loads: dict[str, LinkLoad]
    turns: Array
    moving: bool


@dataclass(frozen=True, eq=False, repr=False)
class Block:
    """What a block of samples, or all of them, leave behind.

    Attributes:
        x: `(N, size)` coordinates.
        v, a: joint rates `(N, nv)`.
        transmission: `(N, nv, d)` joint velocities per unit speed of each drive.
        wrenches: `(N, b, 6)`, see `Reactions.wrenches`.
        efforts: `(N, nv)` what drives and held joints exert, loads taken off.
        tooth: `(N, G)` moments of the couplings at their successors' joints.
        condition: `(N,)` see `Sweep.condition`.
        closure: `(N,)` closure error.
        residuals: balance of bodies and power.
        influence: `(b, 6)`, see `Reactions.influence`.
        open_couplings: numbers of the couplings whose moment is not unique.
    """

    x: Array
    v: Array
    a: Array
    transmission: Array
    wrenches: Array
    efforts: Array
    tooth: Array
    condition: Array
    closure: Array
    residuals: Residuals
    influence: Array
    open_couplings: set[int]


class Pipeline:
    """Motion, reactions and residuals of one scene."""

    def __init__(
        self,
        mechanism: Mechanism,
        kinematics: Kinematics,
        reactions: ReactionSolver,
        needed: Needs,
        gravity: Array,
        outside: Array,
        prescribed: dict[str, float | None],
        moving: Array,
    ) -> None:
        """Make the pipeline.

        Args:
            mechanism: the mechanism.
            kinematics: the groups that are solved.
            reactions: their reactions.
            needed: what the outputs need.
            gravity: `(3,)` [m/s²].
            outside: velocity coordinates that are driven or held.
            prescribed: held joints to their positions, drives, in their order, to None.
            moving: velocity coordinates whose motion is solved, `outside` included.
        """
        self._mechanism = mechanism
        self._kinematics = kinematics
        self._coordinates = kinematics.coordinates
        self._moving = moving
        self._claimed, self._claimed_places = reactions.solved(needed)
        self._reactions = reactions
        self._needed = needed
        self._outside = outside
        self._gravity = gravity
        self._weight = bool(np.any(gravity))
        self._drives = kinematics.drives
        self._prescribed = prescribed
        slides = np.any(reactions.subspace[:, :3] != 0.0, axis=1)
        scale = np.where(slides, mechanism.length, 1.0)
        self._ratio_scale = scale[kinematics.drives] / scale[:, None]
        self._heavy = any(solver.twin.heavy for solver in kinematics.solvers)

    @cached_property
    def bodies(self) -> FreeBodies:
        """What proves results; the description's text is read again when it is first asked for."""
        from .free_bodies import FreeBodies

        return FreeBodies(
            self._mechanism.reread,
            self._coordinates,
            self._mechanism.length,
            self._gravity,
            self._claimed,
            self._prescribed,
            self._moving,
        )

    def prove_flags(self, found: Block) -> None:
        """Refuse what a result says of uniqueness where self-stresses contradict it.

        Raises:
            AccuracyError: see `FreeBodies.prove_flags`.
        """
        if self._claimed:
            unique = found.influence[self._claimed_places] < UNIQUE_TOLERANCE
            self.bodies.prove_flags(found.x, unique, float(np.max(found.condition)))

    def run(self, here: ClosedMechanism, inputs: Inputs) -> Block:
        """Return motion, reactions and residuals at closed positions."""
        transmission, v, a = self.rates(here, inputs.speeds, inputs.accelerations)
        dynamics = (v, a) if self._heavy and (inputs.moving or self._weight) else None
        links = list(inputs.link_loads.values())
        case = LoadCase(dynamics, inputs.loads, links, self._gravity)
        (reactions,) = self._reactions.solve(here, [case])
        return self.proven(here, inputs, (transmission, v, a), reactions)

    def proven(
        self,
        here: ClosedMechanism,
        inputs: Inputs,
        rates: tuple[Array, Array, Array],
        reactions: Reactions,
    ) -> Block:
        """Return reactions with the residuals that prove them, and all else that they tell.

        Args:
            here: closed positions.
            inputs: what is prescribed.
            rates: from `rates`.
            reactions: at those positions, rates and inputs.
        """
        count = len(here.x)
        transmission, v, a = rates
        efforts = self.efforts(reactions)
        exerted = np.zeros_like(efforts)
        if self._needed.efforts_alone:
            # Virtual work gives the drive efforts without closure forces.
            drive = (efforts - inputs.loads)[:, None, :] @ transmission
            exerted[:, self._drives] = drive[:, 0]
        else:
            exerted[:, self._outside] = (efforts - inputs.loads)[:, self._outside]
        tooth = reactions.closure[len(self._mechanism.loops) :]
        couplings = np.concatenate([np.zeros((count, 0)), *tooth], axis=1)
        residuals = self.bodies.check(
            Claim(
                x=here.x,
                turns=inputs.turns,
                v=v,
                a=a,
                positions=inputs.positions,
                speeds=inputs.speeds,
                accelerations=inputs.accelerations,
                transmission=transmission,
                wrenches=reactions.wrenches[:, self._claimed_places],
                exerted=exerted,
                couplings=couplings,
                loads=inputs.loads,
                link_loads=inputs.link_loads,
                moving=inputs.moving,
            )
        )
        return Block(
            x=here.x,
            v=v,
            a=a,
            transmission=transmission,
            wrenches=reactions.wrenches,
            efforts=exerted,
            tooth=couplings,
            condition=self.condition(here, transmission) * residuals.cancellation,
            closure=np.maximum(here.residual, residuals.open),
            residuals=residuals,
            influence=reactions.influence,
            open_couplings=reactions.open_couplings,
        )

    def rates(
        self, here: ClosedMechanism, speeds: Array, accelerations: Array
    ) -> tuple[Array, Array, Array]:
        """Return transmission `(N, nv, d)`, velocities and accelerations `(N, nv)`."""
        kinematics, count = self._kinematics, len(here.x)
        transmission = np.empty((count, self._mechanism.model.nv, speeds.shape[1]))
        for number, unit in enumerate(np.eye(speeds.shape[1])):
            transmission[:, :, number] = kinematics.rates(here, np.tile(unit, (count, 1)))
        if np.any(speeds):
            v = (transmission @ speeds[:, :, None])[:, :, 0]
            return transmission, v, kinematics.accelerations(here, v, accelerations)
        v = np.zeros(transmission.shape[:2])
        if np.any(accelerations):
            return transmission, v, (transmission @ accelerations[:, :, None])[:, :, 0]
        return transmission, v, v

    def condition(self, here: ClosedMechanism, transmission: Array) -> Array:
        """Return by how much rounding of positions is magnified in velocities `(N,)`.

        Args:
            here: closed positions.
            transmission: `(N, nv, d)`.
        """
        ratios = np.abs(transmission) * self._ratio_scale
        return here.condition * np.max(ratios, axis=(1, 2), initial=1.0)

    def efforts(self, reactions: Reactions) -> Array:
        """Return what loads, drives and held joints exert along the coordinates, `(N, nv)`.

        Couplings act between joints: they are neither of these, and pass on no power.
        """
        efforts = self._reactions.efforts(reactions.wrenches)
        moments = reactions.closure[len(self._mechanism.loops) :]
        for coupling, moment in zip(self._mechanism.couplings, moments, strict=True):
            efforts[:, coupling.successor_columns] -= moment
            efforts[:, coupling.predecessor_columns] += coupling.ratio * moment
        return efforts


def joined(blocks: list[Block], positions: Array) -> Block:
    """Return all blocks as one.

    Raises:
        AccuracyError: a residual misses its tolerance, or numbers overflow.
    """
    arrays = {
        field.name: np.concatenate([getattr(block, field.name) for block in blocks])
        for field in fields(Block)
        if field.name not in ("influence", "open_couplings", "residuals")
    }
    for name in ("x", "v", "a", "wrenches", "efforts"):
        if not np.all(np.isfinite(arrays[name])):
            raise overflow(f"the {name}")
    residuals = Residuals.joined([block.residuals for block in blocks])
    residuals.prove(positions, arrays["condition"])
    return Block(
        residuals=residuals,
        influence=np.max([block.influence for block in blocks], axis=0),
        open_couplings=set().union(*(block.open_couplings for block in blocks)),
        **arrays,
    )
