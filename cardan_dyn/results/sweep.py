"""Sweep: the result of a scene over given positions, with the residuals that prove it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property

import numpy as np

from ..arrays import Array
from ..checks import described
from ..errors import ArgumentError, ModelError, choices
from ..forces.link_loads import Wrench
from ..frozen import Frozen, frozen, read_only
from ..mechanism.mechanism import Mechanism
from ..problem.problem import Problem
from .motion import Motion
from .source import Source
from .wrench import GivenComponents, JointWrench

FRAMES = ("joint", "parent", "world")
_SOLVED = (
    *("unique", "coupling_moment", "coupling_unique", "condition", "loop_residual"),
    *("balance_residual", "power_residual", "rate_residual", "unproven"),
)


class Sweep(Frozen):
    """Joint wrenches, drive efforts and motion of a scene over N samples.

    `sweep["bearing_out"]` is the `JointWrench` of a joint in its own frame; `wrench(name, frame)`
    gives it in other axes. A sweep of a `Response` may have operating points in several
    dimensions: then `(N,)` stands for their shape. Nothing in it can be changed.

    Attributes:
        unique: `(k, 6)` see `JointWrench.unique`, a row per output.
        coupling_moment: coupling to the moment `(N,)` [N·m] that it exerts on its successor's
            joint.
        coupling_unique: coupling to whether its moment follows from the laws of motion alone.
        condition: `(N,)` condition number of the wrenches: that of the closure equations, times
            the greatest velocity ratio if that exceeds 1, times by how much inertial terms
            exceed what is left of them. Errors are some eps times it. One value, the greatest of
            its samples, if it comes from a `Response`.
        loop_residual: worst closure error: angle [rad], or gap as a fraction of
            `Mechanism.characteristic_length`; couplings, drives and held joints count as well.
        balance_residual: worst Newton-Euler imbalance over all bodies, relative to the greatest
            wrench of all samples (to inertial terms where wrenches are mere rounding of them).
            It proves what is unique; of what the laws of motion leave open, it proves that the
            choice is one in balance, not that it is the least;
            nan if only the drive efforts were asked for, and where nothing acts, so that there
            is nothing to compare.
        rate_residual: worst violation of the loops, couplings and drives by speeds and
            accelerations, relative to the greatest ones.
        power_residual: worst imbalance of drive, load, weight and inertia power, relative to the
            power that flows and to the greatest wrench times the greatest joint speed;
            nan where the outputs leave part of that flow out, and where nothing acts.
        unproven: links whose balance `balance_residual` does not know of, since the outputs leave
            out what acts on them.
    """

    def __init__(
        self,
        *,
        problem: Problem,
        source: Source,
        unique: Array,
        coupling_moment: Mapping[str, Array],
        coupling_unique: Mapping[str, bool],
        condition: Array,
        loop_residual: float,
        balance_residual: float,
        power_residual: float,
        rate_residual: float,
        unproven: tuple[str, ...],
    ) -> None:
        # For `problem` see what was solved, for `source` where the arrays come from as far as they
        # are asked for; the others are the attributes.
        self._problem = problem
        self._source = source
        self.unique = read_only(unique)
        self.coupling_moment = coupling_moment
        self.coupling_unique = coupling_unique
        self.condition = read_only(condition)
        self.loop_residual = loop_residual
        self.balance_residual = balance_residual
        self.power_residual = power_residual
        self.rate_residual = rate_residual
        self.unproven = unproven
        self._freeze()

    def __reduce__(self) -> tuple[object, ...]:
        # Through the constructor, which closes the arrays of a copy to writing as well.
        values = {name: getattr(self, name) for name in _SOLVED}
        return _restored, ({"problem": self._problem, "source": self._source, **values},)

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism."""
        return self._problem.mechanism

    @property
    def drives(self) -> tuple[str, ...]:
        """Names of the driven joints."""
        return self._problem.drives

    @property
    def held(self) -> Mapping[str, float]:
        """Held joints and their positions [rad or m]."""
        return self._problem.held

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the joints whose wrenches are kept."""
        return self._problem.outputs

    @property
    def position(self) -> Array:
        """Drive positions `(N,)` [rad or m], `(N, d)` for d drives."""
        return self._source.position

    @property
    def speed(self) -> Array:
        """Drive speeds [rad/s or m/s], like `position`."""
        return self._source.speed

    @property
    def acceleration(self) -> Array:
        """Drive accelerations [rad/s² or m/s²], like `position`."""
        return self._source.acceleration

    @cached_property
    def loads(self) -> Mapping[str, Array | Wrench]:
        """Loaded joint to its effort, a number or `(N,)` [N·m or N]; link to its `Wrench`."""
        links = {name: load.wrench for name, load in self._problem.link_loads.items()}
        return frozen({**self._source.joint_loads, **links})

    @property
    def gravity(self) -> Array:
        """Acceleration of free fall in world axes, `(3,)` or `(..., 3)` [m/s²]."""
        return self._source.gravity

    @cached_property
    def drive_effort(self) -> Array:
        """What the drive exerts `(N,)` [N·m or N], `(N, d)` for d drives.

        Raises:
            ModelError: the outputs of the scene leave it out.
        """
        effort = self._source.drive_effort()
        if effort is None:
            raise ModelError(
                "the drive effort was not asked for; add the driven joint to the outputs, which "
                f"are: {choices(self.outputs)}"
            )
        return effort

    @cached_property
    def holding_effort(self) -> Mapping[str, Array]:
        """Held joint to what holds it, `(N,)` [N·m or N]."""
        return self._source.holding_effort()

    @cached_property
    def motion(self) -> Motion:
        """Positions, speeds and accelerations of all joints."""
        return self._source.motion()

    def __len__(self) -> int:
        return len(self._source)

    def __getitem__(self, joint: str) -> JointWrench:
        return self.wrench(joint)

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names of the joints whose wrenches are kept, as a mapping does."""
        return iter(self.outputs)

    def __contains__(self, joint: object) -> bool:
        return isinstance(joint, str) and joint in self.outputs

    def keys(self) -> tuple[str, ...]:
        """Return the names of the joints whose wrenches are kept."""
        return self.outputs

    def items(self) -> Iterator[tuple[str, JointWrench]]:
        """Iterate over joints and their wrenches."""
        return ((name, self.wrench(name)) for name in self.outputs)

    def __repr__(self) -> str:
        return (
            f"<Sweep of {self.mechanism.name!r}: {len(self)} samples, "
            f"residuals: loop {self.loop_residual:.1e}, balance {self.balance_residual:.1e}, "
            f"power {self.power_residual:.1e}>"
        )

    def wrench(self, joint: str, frame: str = "joint") -> JointWrench:
        """Return the wrench exerted by a joint's parent on its child, at the joint origin.

        Args:
            joint: one of `outputs`.
            frame: axes of the components: `joint` turns with the child; `parent` stays with the
                parent link, which for an end bearing means fixed axes; `world`.

        Raises:
            ModelError: the joint is unknown or was not asked for.
            ArgumentError: unknown frame, or one that needs a sweep over one dimension.
        """
        if not isinstance(joint, str) or joint not in self.outputs:
            self.mechanism.joint(joint)
            raise ModelError(
                f"the wrench of {joint!r} was not asked for; outputs: {choices(self.outputs)}"
            )
        if not isinstance(frame, str) or frame not in FRAMES:
            raise ArgumentError(f"frame {described(frame)} is unknown; frames: {choices(FRAMES)}")
        number = self.outputs.index(joint)
        record = self.mechanism.joints[joint]
        components = self._source.wrench(number)
        axis = record.axis
        if frame != "joint":
            force, moment = components.vector(0), components.vector(3)
            if force.ndim != 2:
                raise ArgumentError(
                    "only sweeps over one dimension turn wrenches into other axes, not those of "
                    f"shape {force.shape[:-1]}"
                )
            rotation = self._parent_rotation(joint) if frame == "parent" else self.rotation(joint)
            turned = [np.einsum("nij,nj->ni", rotation, part) for part in (force, moment)]
            components = GivenComponents(np.concatenate(turned, axis=1))
            if frame == "world" or record.type in ("spherical", "universal", "floating"):
                axis = rotation @ axis
        return JointWrench(joint, frame, components, axis, self.unique[number])

    def rotation(self, joint: str) -> Array:
        """Return rotations `(N, 3, 3)` that take components in a joint's frame to world axes.

        Raises:
            ModelError: unknown joint, or one whose motion the outputs leave out.
        """
        return self._placement(joint)[0]

    def origin(self, joint: str) -> Array:
        """Return the origin of a joint's frame in the world `(N, 3)` [m].

        Raises:
            ModelError: unknown joint, or one whose motion the outputs leave out.
        """
        return self._placement(joint)[1]

    def _placement(self, joint: str) -> tuple[Array, Array]:
        name = self.mechanism.joint(joint).name
        if name not in self._placements:
            # Computed only here: most scripts never ask where a joint was.
            rotation, origin = self.motion.joint_placement(name)
            if not (np.all(np.isfinite(rotation)) and np.all(np.isfinite(origin))):
                raise ModelError(
                    f"the outputs of the scene leave out joint {name!r}; name it among the outputs"
                )
            self._placements[name] = read_only(rotation), read_only(origin)
        return self._placements[name]

    def _parent_rotation(self, joint: str) -> Array:
        """Return rotations from a joint's own frame to its frame at coordinate zero."""
        record = self.mechanism.joints[joint]
        if not record.parts:
            return np.broadcast_to(np.eye(3), (len(self), 3, 3))
        # The joint's frame at coordinate zero stands still in its parent.
        frames = self.mechanism.frames
        number = frames.joints.index(joint)
        first = next(motion for motion in frames.motions if motion.joint == number)
        at_zero, parent = first.placement[:3, :3], frames.parents[number]
        if parent >= 0:
            at_zero = self.rotation(frames.joints[parent]) @ at_zero
        return np.asarray(np.swapaxes(at_zero, -1, -2) @ self.rotation(joint))

    @cached_property
    def _placements(self) -> dict[str, tuple[Array, Array]]:
        return {}


def _restored(values: dict[str, object]) -> Sweep:
    return Sweep(**values)  # type: ignore[arg-type]
