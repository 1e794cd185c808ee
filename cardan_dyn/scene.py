"""Scene: a mechanism with its drive, held joints, loads and gravity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from .arguments import (
    Wrench,
    compliances,
    coordinate,
    held_positions,
    rows_of,
    split_loads,
    wanted_outputs,
)
from .assembly import Assembly
from .checks import flag, mapping, names, samples, text, vector
from .coordinates import Array, Coordinates
from .errors import ArgumentError, MobilityError, choices
from .frozen import Frozen, frozen, read_only
from .indeterminate import Choice, Elastic, LeastNorm
from .loads import LinkLoad
from .mechanism import Mechanism
from .motion import Motion
from .pipeline import Block, Inputs, Pipeline, joined
from .plan import Plan, plan_of
from .reactions import ReactionSolver, counted
from .results import ClosedPositions, collected, motion_of
from .sweep import Sweep

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .response import Response

_OVERFLOW: Any = {"over": "ignore", "invalid": "ignore"}  # Numbers that are none are refused.
_BLOCK = 768  # Samples worked on at a time, so that their arrays stay in the cache.


class Scene(Frozen):
    """A mechanism whose motion is prescribed, with what acts on it.

    A scene cannot be changed. It may be used by several threads at the same time; copies and
    pickles are made anew from its arguments.

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
        outputs: names of the joints whose wrenches are wanted; all joints if not given. Loops
            that they do not need are not solved. Drive efforts and what holds joints are among
            the results if the joint is; the empty list asks for the drive efforts alone, which
            then come without a balance of the bodies.
        compliance: joints to their compliance in the axes that stay with the parent: 6 values, or
            a symmetric `(6, 6)`, force first [m/N, rad/(N·m)]. What the laws of motion leave open
            is then what makes the elastic energy least, instead of the least norm.
        strict: refuse to choose what the laws of motion leave open.
        start: joints to positions [rad or m] to which they are brought before the drives take
            over, for a description whose zero is a dead point of the drives.
        branch: name of the way in which the loops are assembled, from `branches`; `A` is the
            description's own.

    Attributes:
        mechanism, drives, held, gravity, outputs, compliance, strict, start, branch: as given.
        joint_loads, link_loads: efforts at joints and wrenches on links, by name.
        elastic: whether compliances choose what the laws of motion leave open.
        heavy: whether any body has mass.
        coordinates: layout of joint coordinates.
        assembly: closes the loops.
        reactions, pipeline: compute wrenches at closed positions.

    Raises:
        ModelError: unknown joint or link.
        ArgumentError: a value is not finite or has the wrong shape.
        MobilityError: the drives do not match the mobility.
        SingularConfigurationError: the scene starts in a dead point of its drives.
        AssemblyError: the loops cannot be closed at the held positions, or not in this way.
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
        compliance: Mapping[str, ArrayLike] | None = None,
        strict: bool = False,
        start: Mapping[str, float] | None = None,
        branch: str = "A",
    ) -> None:
        if not isinstance(mechanism, Mechanism):
            raise ArgumentError(
                f"a scene needs a mechanism from load(), not {type(mechanism).__name__}"
            )
        held, loads = mapping("held", held), mapping("loads", loads)
        start, compliance = mapping("start", start), mapping("compliance", compliance)
        strict, branch = flag("strict", strict), text("branch", branch)
        self.mechanism = mechanism
        if drive is None:
            drive = [name for name in mechanism.independent if name not in held]
        self.drives = names("drive", drive)
        self.coordinates = Coordinates(mechanism)
        self.held = frozen(held_positions(mechanism, self.coordinates, held, "held"))
        self.start = frozen(held_positions(mechanism, self.coordinates, start, "start"))
        self.gravity = np.zeros(3) if gravity is None else vector("gravity", gravity, 3)
        read_only(self.gravity)
        self.outputs = wanted_outputs(mechanism, outputs)
        self._everything = outputs is None
        for name in self.drives:
            coordinate(mechanism, self.coordinates, name, "drive")
        if not self.drives:
            raise MobilityError(
                f"a scene needs at least one drive; joints: {choices(self.coordinates.columns)}"
            )
        doubled = {name for name in self.drives if name in self.held}
        if doubled or len(set(self.drives)) != len(self.drives):
            raise ArgumentError(
                f"a joint is driven once or held, not both: drives {list(self.drives)}, "
                f"held {list(self.held)}"
            )
        joint_loads, link_loads = split_loads(mechanism, self.coordinates, loads)
        self.joint_loads, self.link_loads = frozen(joint_loads), frozen(link_loads)
        self.strict = strict
        wanted = {mechanism.joints[name].index - 1 for name in self.outputs}
        fixed = {loop.joint: loop for loop in mechanism.loops}
        for name in self.outputs:
            # A `fixed` loop has no body; it is solved with the bodies that it connects.
            if not mechanism.joints[name].parts:
                wanted |= {fixed[name].predecessor - 1, fixed[name].successor - 1}
        self.assembly = Assembly(
            mechanism,
            self.coordinates,
            self.drives,
            self.held,
            None if self._everything else wanted - {-1},
            self.start,
        )
        if branch != "A":
            self.assembly.restart(self._other(branch))
        self.branch = branch
        kinematics, needed = self.assembly.kinematics, self.assembly.needed
        self.heavy = any(solver.twin.heavy for solver in kinematics.solvers)
        self.compliance = frozen(compliances(mechanism, compliance))
        joints = counted(mechanism)
        rule: Choice = LeastNorm(mechanism.length, joints)
        if self.compliance:
            places = {self.place(name): value for name, value in self.compliance.items()}
            rule = Elastic(mechanism.length, joints, places)
        self.elastic = bool(self.compliance)
        active = {place for place, number in enumerate(needed.motion) if number in needed.forces}
        self.reactions = ReactionSolver(mechanism, kinematics, active, rule)
        moving = np.concatenate([self._outside(), self.assembly.decided])
        prescribed: dict[str, float | None] = {**dict.fromkeys(self.drives), **self.held}
        self.pipeline = Pipeline(
            mechanism,
            kinematics,
            self.reactions,
            needed,
            self.gravity,
            self._outside(),
            prescribed,
            moving,
        )
        self._freeze()

    def __reduce__(self) -> tuple[object, ...]:
        wrenches = {
            name: Wrench(load.force, load.moment, "world" if load.in_world else "link")
            for name, load in self.link_loads.items()
        }
        given = {
            "drive": self.drives,
            "held": dict(self.held),
            "loads": {**self.joint_loads, **wrenches},
            "gravity": self.gravity,
            "outputs": None if self._everything else self.outputs,
            "compliance": dict(self.compliance),
            "strict": self.strict,
            "start": dict(self.start),
            "branch": self.branch,
        }
        return _made_again, (self.mechanism, given)

    def sweep(
        self,
        position: ArrayLike | ClosedPositions,
        speed: ArrayLike = 0.0,
        acceleration: ArrayLike = 0.0,
    ) -> Sweep:
        """Solve motion and reactions at given drive positions.

        Args:
            position: drive positions `(N,)` [rad or m], `(N, d)` for d drives, in any order; or
                what `close` made of them.
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
        with np.errstate(**_OVERFLOW):
            if isinstance(position, ClosedPositions):
                closed = self._own(position)
            else:
                closed = self._closed(samples("position", position, count, None))
            speeds = samples("speed", speed, count, len(closed))
            accelerations = samples("acceleration", acceleration, count, len(closed))
            return collected(self, self._solved(closed, speeds, accelerations), closed.turns)

    def close(self, position: ArrayLike) -> ClosedPositions:
        """Close the loops at given drive positions, for several sweeps over them.

        What depends on the position alone is kept, some kilobytes per sample, so that a sweep
        with another speed or acceleration has only the rest to do.

        Args:
            position: see `sweep`.

        Raises:
            ArgumentError: a value is not finite or has the wrong shape.
            AssemblyError: the loops cannot be closed at a position.
            SingularConfigurationError: a position is a dead point.
        """
        with np.errstate(**_OVERFLOW):
            closed = self._closed(samples("position", position, len(self.drives), None))
            return replace(closed, blocks=list(closed.blocks))

    def _closed(self, positions: Array) -> ClosedPositions:
        """Return drive positions `(N, d)` whose blocks are closed one by one as they are used."""
        guess = self.assembly.guesses(positions)
        # Blocks of equal size: a small one costs almost as much as a large one.
        count = max(1, -(-len(positions) // _BLOCK))
        ends = np.linspace(0, len(positions), count + 1).astype(int).tolist()
        spans = [slice(*span) for span in pairwise(ends)]
        blocks = (self.assembly.close(guess[span], positions[span]) for span in spans)
        return ClosedPositions(self, positions, guess.turns, spans, blocks, guess.kinematics)

    def _own(self, closed: ClosedPositions) -> ClosedPositions:
        """Return closed positions as they are if they hold for this scene.

        Raises:
            ArgumentError: they are those of another scene.
        """
        if closed.scene is not self:
            raise ArgumentError("these positions were closed by another scene; close them again")
        if closed.kinematics.rows != self.assembly.kinematics.rows:
            # Farther along the branch, other rows turned out to be redundant.
            return self._closed(closed.positions)
        return closed

    def _solved(self, closed: ClosedPositions, speeds: Array, accelerations: Array) -> Block:
        """Return all that is solved at closed positions, for rates `(N, d)`."""
        loads = self.loads_at(len(closed))
        link_loads = self._link_loads_at(len(closed))
        moving = bool(np.any(speeds) or np.any(accelerations))
        blocks: list[Block] = []
        for rows, here in zip(closed.spans, closed.blocks, strict=True):
            inputs = Inputs(
                closed.positions[rows],
                speeds[rows],
                accelerations[rows],
                loads[rows if len(loads) > 1 else slice(None)],
                {name: rows_of(load, rows) for name, load in link_loads.items()},
                closed.turns[rows],
                moving,
            )
            blocks.append(self.pipeline.run(here, inputs))
        found = joined(blocks, closed.positions)
        self.pipeline.prove_flags(found)
        return found

    def response(
        self, tolerance: float = 1e-13, *, low: float | None = None, high: float | None = None
    ) -> Response:
        """Return wrenches and efforts as functions of the drive's position.

        Built from a few hundred solved positions, they hold everywhere to rounding, at any speed,
        acceleration, load and gravity, for nanoseconds per value.

        Args:
            tolerance: error of the functions relative to the greatest wrench of their joint, or a
                tenth of the greatest of all joints; where rounding stops short of it, times the
                condition number. `Response.error` is what was reached.
            low: where the range of positions begins [rad or m]; without a range the drive has to
                come back to where it was.
            high: where it ends.

        Raises:
            ArgumentError: the range is empty, or the scene has several drives.
            AccuracyError: the tolerance cannot be reached; the message says what can.
            CardanError: the drive does not turn through and no range was given.
        """
        from .response_build import build

        return build(self, tolerance, low, high)

    def motion(self, positions: Array, speeds: Array, accelerations: Array) -> Motion:
        """Return the motion alone at positions, speeds and accelerations `(N,)` of one drive.

        As in a sweep, joints that no output needs are not solved, and have no numbers.
        """
        closed = self._closed(positions[:, None])
        parts = []
        for rows, here in zip(closed.spans, closed.blocks, strict=True):
            given = speeds[rows, None], accelerations[rows, None]
            parts.append((here.x, *self.pipeline.rates(here, *given)))
        x, transmission, v, a = (np.concatenate(part) for part in zip(*parts, strict=True))
        return motion_of(self, closed.turns, x, v, a, transmission)

    def plan(self) -> Plan:
        """Return what a sweep does, and what it leaves out; `print` shows it."""
        assembly = self.assembly
        return plan_of(
            self.mechanism,
            self.coordinates,
            assembly.groups,
            assembly.needed,
            self.outputs,
            heavy=self.heavy,
            weight=bool(np.any(self.gravity)),
        )

    def range(self) -> tuple[float, float]:
        """Return between which positions the drive can move [rad or m].

        `<limit>` elements of the description play no part: they are a maker's choice, and a sweep
        beyond them is as well computed as one within.

        Returns:
            The limits; they are dead points of the drive, or positions where ways of assembling
            the loops meet, which are found to some 1e-6. ±inf where it turns through.

        Raises:
            MobilityError: the scene has several drives.
        """
        if len(self.drives) > 1:
            raise MobilityError(
                f"the range of one drive depends on the positions of the others: {self.drives}"
            )
        return self.assembly.range()

    def branches(self) -> dict[str, dict[str, float]]:
        """Return the ways to assemble the loops with the drives where the scene starts.

        Returns:
            Name for `Scene(branch=...)` to the positions of all joints with one coordinate [m, or
            rad within half a turn either way]. `A` is the description's own, the others follow by
            their distance from it, whichever of them the scene is in. They are searched from many
            starts, so one that few starts lead to may be missing.
        """
        return {
            _name(number): {
                joint: self._within_a_turn(joint, float(state[columns][0]))
                for joint, columns in self.coordinates.columns.items()
                if columns.stop - columns.start == 1
            }
            for number, state in enumerate(self.assembly.others())
        }

    def _within_a_turn(self, joint: str, value: float) -> float:
        if joint in self.drives or self.mechanism.joints[joint].type == "prismatic":
            return value
        return value - 2.0 * np.pi * float(np.rint(value / (2.0 * np.pi)))

    def _other(self, branch: str) -> Array:
        states = self.assembly.others()
        names = [_name(number) for number in range(len(states))]
        if branch not in names:
            raise ArgumentError(f"branch {branch!r} does not exist; branches: {choices(names)}")
        return states[names.index(branch)]

    def _outside(self) -> Array:
        """Return the velocity coordinates that are driven or held."""
        velocities = self.coordinates.velocities
        names = (*self.drives, *self.held)
        return np.array([velocities[name].start for name in names], dtype=int)

    def place(self, joint: str) -> int:
        """Return a joint's place among the wrenches: bodies in order, then `fixed` loops."""
        record = self.mechanism.joints[joint]
        if record.parts:
            return record.index - 1
        fixed = [loop.joint for loop in self.mechanism.loops if not self._parts(loop.joint)]
        return self.mechanism.model.njoints - 1 + fixed.index(joint)

    def _parts(self, joint: str) -> int:
        return len(self.mechanism.joints[joint].parts)

    def loads_at(self, count: int) -> Array:
        """Return efforts added at the joints, `(1, nv)` or `(N, nv)`."""
        many = any(effort.ndim for effort in self.joint_loads.values())
        loads = np.zeros((count if many else 1, self.mechanism.model.nv))
        for name, effort in self.joint_loads.items():
            if effort.ndim and len(effort) != count:
                raise ArgumentError(
                    f"the load on {name!r} has {len(effort)} values, the sweep {count} positions"
                )
            loads[:, self.coordinates.velocities[name].start] += effort
        return loads

    def _link_loads_at(self, count: int) -> dict[str, LinkLoad]:
        for name, load in self.link_loads.items():
            for part in (load.force, load.moment):
                if len(part) not in (1, count):
                    raise ArgumentError(
                        f"the wrench on {name!r} has {len(part)} samples, the sweep {count}"
                    )
        return self.link_loads


def _made_again(mechanism: Mechanism, given: dict[str, Any]) -> Scene:
    """Return a scene of the same arguments."""
    return Scene(mechanism, **given)


def _name(number: int) -> str:
    letter = chr(ord("A") + number % 26)
    return letter if number < 26 else f"{letter}{number // 26}"
