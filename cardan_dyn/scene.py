"""Scene: a mechanism with its drive, held joints, loads and gravity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .arguments import (
    coordinate,
    held_positions,
    rows_of,
    samples,
    split_loads,
    vector,
    wanted_outputs,
)
from .assembly import Assembly
from .coordinates import Array, Coordinates
from .errors import AccuracyError, ArgumentError, MobilityError, choices
from .kinematics import ClosedMechanism
from .loads import LinkLoad
from .mechanism import Mechanism
from .motion import Motion
from .reactions import UNIQUE_TOLERANCE, Reactions, ReactionSolver
from .residuals import FreeBodies, Rates
from .sweep import Sweep

BALANCE_TOLERANCE = 1e-8
"""Greatest Newton-Euler or power imbalance of a result, relative."""
_BLOCK = 512  # Samples worked on at a time, so that their arrays stay in the cache.


class Scene:
    """A mechanism whose motion is prescribed, with what acts on it.

    Args:
        mechanism: from `load`.
        drive: name of the joint whose motion is prescribed, or a list of names: as many as
            the mechanism has mobility once the held joints are held. If not given, the joints
            that the description calls independent, as far as they are not held.
        held: joints whose position the scene fixes, to their coordinates [rad or m]. The moment
            or force that holds them is a result.
        loads: what acts on the mechanism. A joint's name with an effort, a number or `(N,)`
            [N·m or N], positive in the sense of the joint's coordinate; a link's name with a
            `Wrench`, or with six numbers `(6,)` or `(N, 6)`: force and moment about the link's
            origin in the link's axes.
        gravity: `(3,)` acceleration of free fall in world axes [m/s²]; none unless given.
        outputs: names of the joints whose wrenches are wanted; all joints if not given.

    Raises:
        ModelError: unknown joint or link.
        ArgumentError: a value is not finite or has the wrong shape.
        MobilityError: the drives do not match the mobility.
        AssemblyError: the loops cannot be closed at the held positions.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        *,
        drive: str | list[str] | tuple[str, ...] | None = None,
        held: Mapping[str, float] | None = None,
        loads: Mapping[str, object] | None = None,
        gravity: ArrayLike | None = None,
        outputs: Sequence[str] | None = None,
    ) -> None:
        if not isinstance(mechanism, Mechanism):
            raise ArgumentError(
                f"a scene needs a mechanism from load(), not {type(mechanism).__name__}"
            )
        self.mechanism = mechanism
        if drive is None:
            drive = [name for name in mechanism.independent if name not in (held or {})]
        self.drives = tuple(drive) if isinstance(drive, (list, tuple)) else (drive,)
        self._coordinates = Coordinates(mechanism)
        self.held = held_positions(mechanism, self._coordinates, held or {})
        self.gravity = np.zeros(3) if gravity is None else vector("gravity", gravity, 3)
        self.outputs = wanted_outputs(mechanism, outputs)
        for name in self.drives:
            coordinate(mechanism, self._coordinates, name, "drive")
        if not self.drives:
            raise MobilityError(
                f"a scene needs at least one drive; joints: {choices(self._coordinates.columns)}"
            )
        doubled = {name for name in self.drives if name in self.held}
        if doubled or len(set(self.drives)) != len(self.drives):
            raise ArgumentError(
                f"a joint is driven once or held, not both: drives {list(self.drives)}, "
                f"held {list(self.held)}"
            )
        self._joint_loads, self._link_loads = split_loads(mechanism, self._coordinates, loads or {})
        velocities = self._coordinates.velocities
        self._drive_velocities = [velocities[name].start for name in self.drives]
        self._assembly = Assembly(
            mechanism, self._coordinates, self.drives, self.held, self.gravity
        )
        self._kinematics = self._assembly.kinematics
        self._reactions = ReactionSolver(mechanism, self._kinematics)
        self._bodies = FreeBodies(self._reactions, self.gravity, self._assembly.passives)
        self._heavy = any(solver.twin.heavy for solver in self._kinematics.solvers)

    def sweep(
        self, position: ArrayLike, speed: ArrayLike = 0.0, acceleration: ArrayLike = 0.0
    ) -> Sweep:
        """Solve motion and reactions at given drive positions.

        Args:
            position: drive positions `(N,)` [rad or m], `(N, d)` for d drives, in any order.
            speed: drive speeds [rad/s or m/s], a number or like `position`. The mechanism is
                quasi-static where it is zero.
            acceleration: drive accelerations [rad/s² or m/s²], a number or like `position`.

        Raises:
            ArgumentError: a value is not finite or has the wrong shape.
            AssemblyError: the loops cannot be closed at a position.
            SingularConfigurationError: a position is a dead point.
            AccuracyError: a result missed its tolerance.
        """
        count = len(self.drives)
        positions = samples("position", position, count, None)
        speeds = samples("speed", speed, count, len(positions))
        accelerations = samples("acceleration", acceleration, count, len(positions))
        loads = self._loads_at(len(positions))
        link_loads = self._link_loads_at(len(positions))
        guesses, turns = self._assembly.guesses(positions)

        moving = bool(np.any(speeds) or np.any(accelerations))
        dynamic = self._heavy and (moving or bool(np.any(self.gravity)))
        blocks: list[_Block] = []
        influence = np.zeros((self._reactions.bodies + len(self._reactions.fixed), 6))
        for start in range(0, len(positions), _BLOCK):
            rows = slice(start, start + _BLOCK)
            here = self._assembly.close(guesses[rows], turns[rows], positions[rows])
            block = self._solve(
                here,
                speeds[rows],
                accelerations[rows],
                loads[rows if len(loads) > 1 else slice(None)],
                [rows_of(load, rows) for load in link_loads],
                dynamic,
                moving,
            )
            influence = np.maximum(influence, block.influence)
            blocks.append(block)
        return self._result(positions, turns, blocks, influence)

    def _solve(
        self,
        here: ClosedMechanism,
        speeds: Array,
        accelerations: Array,
        loads: Array,
        link_loads: list[LinkLoad],
        dynamic: bool,
        moving: bool,
    ) -> _Block:
        kinematics, count = self._kinematics, len(here.x)
        transmission = np.empty((count, self.mechanism.model.nv, len(self.drives)))
        for number, unit in enumerate(np.eye(len(self.drives))):
            transmission[:, :, number] = kinematics.rates(here, np.tile(unit, (count, 1)))
        v = a = np.zeros(transmission.shape[:2])
        if moving:
            v = (transmission @ speeds[:, :, None])[:, :, 0]
            if np.any(speeds):
                a = kinematics.accelerations(here, v, accelerations)
            else:
                a = (transmission @ accelerations[:, :, None])[:, :, 0]
        reactions = self._reactions.solve(here, (v, a) if dynamic else None, loads, link_loads)
        efforts = self._reactions.efforts(reactions.wrenches)
        # Couplings act between joints: they are neither loads nor drives, and pass on no power.
        inner = self._coupling_efforts(reactions)
        external = efforts - inner
        passives = self._assembly.passives
        external[:, passives] = np.broadcast_to(loads, efforts.shape)[:, passives]
        residuals = self._bodies.check(
            here,
            reactions,
            Rates(v, a, transmission.sum(axis=2), moving),
            efforts - inner,
            external,
            [load.body for load in link_loads],
        )
        tooth = reactions.closure[len(self.mechanism.loops) :]
        return _Block(
            here.x,
            v,
            a,
            transmission,
            reactions.wrenches,
            external - loads,
            np.concatenate([np.zeros((count, 0)), *tooth], axis=1),
            reactions.open_couplings,
            reactions.influence,
            here.condition,
            here.residual,
            residuals.balance,
            residuals.power,
        )

    def _coupling_efforts(self, reactions: Reactions) -> Array:
        """Return the efforts `(N, nv)` that couplings exert at the joints."""
        count = len(reactions.wrenches)
        efforts = np.zeros((count, self.mechanism.model.nv))
        moments = reactions.closure[len(self.mechanism.loops) :]
        for coupling, moment in zip(self.mechanism.couplings, moments, strict=True):
            efforts[:, coupling.successor_columns] += moment
            efforts[:, coupling.predecessor_columns] -= coupling.ratio * moment
        return efforts

    def _result(
        self, positions: Array, turns: Array, blocks: list[_Block], influence: Array
    ) -> Sweep:
        joined = {
            name: np.concatenate([getattr(block, name) for block in blocks])
            for name in _Block.__dataclass_fields__
            if name not in ("influence", "open_couplings")
        }
        for name, tolerance in (("balance", BALANCE_TOLERANCE), ("power", BALANCE_TOLERANCE)):
            worst = int(np.argmax(joined[name]))
            if not joined[name][worst] <= tolerance:
                raise AccuracyError(
                    f"the {name} residual is {joined[name][worst]:.1e} at drive position "
                    f"{positions[worst].tolist()}, more than {tolerance:.0e}; the closure "
                    f"equations have condition {joined['condition'][worst]:.1e} there: stay away "
                    "from this position or choose another drive",
                    residual=float(joined[name][worst]),
                    tolerance=tolerance,
                    position=positions[worst],
                )
        numbers = [self._wrench_number(name) for name in self.outputs]
        wrenches = joined["wrenches"][:, numbers]
        unique = (influence < UNIQUE_TOLERANCE)[numbers]
        effort = joined["efforts"]
        velocities = self._coordinates.velocities
        drive_effort = effort[:, self._drive_velocities]
        return Sweep(
            mechanism=self.mechanism,
            solver=self._reactions,
            outputs=self.outputs,
            wrenches=wrenches,
            unique=unique,
            drive_effort=drive_effort[:, 0] if len(self.drives) == 1 else drive_effort,
            tooth_moment={
                coupling.name: joined["tooth"][:, number]
                for number, coupling in enumerate(self.mechanism.couplings)
            },
            tooth_unique={
                coupling.name: all(number not in block.open_couplings for block in blocks)
                for number, coupling in enumerate(self.mechanism.couplings)
            },
            holding_effort={name: effort[:, velocities[name].start] for name in self.held},
            motion=Motion(
                self.mechanism,
                self._coordinates,
                joined["x"],
                turns,
                joined["v"],
                joined["a"],
                joined["transmission"],
            ),
            condition=joined["condition"],
            loop_residual=float(np.max(joined["closure"])),
            balance_residual=float(np.max(joined["balance"])),
            power_residual=float(np.max(joined["power"])),
        )

    def _wrench_number(self, joint: str) -> int:
        """Return a joint's place among the wrenches: twin joints in order, then `fixed` loops."""
        index = self.mechanism.joints[joint].index
        if index:
            return index - 1
        fixed = [self.mechanism.loops[number].joint for number in self._reactions.fixed]
        return self._reactions.bodies + fixed.index(joint)

    def _loads_at(self, count: int) -> Array:
        """Return efforts added at the joints, `(1, nv)` or `(N, nv)`."""
        many = any(effort.ndim for effort in self._joint_loads.values())
        loads = np.zeros((count if many else 1, self.mechanism.model.nv))
        for name, effort in self._joint_loads.items():
            if effort.ndim and len(effort) != count:
                raise ArgumentError(
                    f"the load on {name!r} has {len(effort)} values, the sweep {count} positions"
                )
            loads[:, self._coordinates.velocities[name].start] += effort
        return loads

    def _link_loads_at(self, count: int) -> list[LinkLoad]:
        for name, load in self._link_loads.items():
            for part in (load.force, load.moment):
                if len(part) not in (1, count):
                    raise ArgumentError(
                        f"the wrench on {name!r} has {len(part)} samples, the sweep {count}"
                    )
        return list(self._link_loads.values())


@dataclass(frozen=True)
class _Block:
    """What a block of samples leaves behind."""

    x: Array
    v: Array
    a: Array
    transmission: Array
    wrenches: Array
    efforts: Array
    tooth: Array
    open_couplings: set[int]
    influence: Array
    condition: Array
    closure: Array
    balance: Array
    power: Array
