"""Sweep data: inputs and results of a scene over drive positions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array
from ..checks import described
from ..errors import ArgumentError, ModelError, choices
from ..forces.link_loads import Wrench
from ..frozen import frozen, read_only
from ..kinematics.idle_rods import rods_by_name
from ..problem.problem import Problem
from .motion import Motion
from .prescribed import Prescribed
from .source import Source
from .wrench import WITHOUT_AXIS, JointWrench

if TYPE_CHECKING:
    from .element_results import ElementResults

FRAMES = ("joint", "parent", "world")
_STORED = (
    *("unique", "coupling_moment", "coupling_unique", "condition", "loop_residual"),
    *("balance_residual", "power_residual", "rate_residual", "unproven"),
)
"""Attributes that a copy takes over as they are."""


class SweepData(Prescribed):
    """Inputs, wrenches, motion and residuals of a sweep; see `Sweep`."""

    _source: Source
    unique: Array
    coupling_moment: Mapping[str, Array]
    coupling_unique: Mapping[str, bool]
    condition: Array
    loop_residual: float
    balance_residual: float
    power_residual: float
    rate_residual: float
    unproven: tuple[str, ...]

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
        # `problem` is what was solved, `source` where arrays come from when they are first read;
        # the others are the attributes.
        self._freeze(
            _problem=problem,
            _source=source,
            unique=read_only(unique),
            coupling_moment=coupling_moment,
            coupling_unique=coupling_unique,
            condition=read_only(condition),
            loop_residual=loop_residual,
            balance_residual=balance_residual,
            power_residual=power_residual,
            rate_residual=rate_residual,
            unproven=unproven,
        )

    def __reduce__(self) -> tuple[object, ...]:
        # Through the constructor, which closes the arrays of a copy to writing as well.
        stored = {name: getattr(self, name) for name in _STORED}
        values = {"problem": self._problem, "source": self._source, **stored}
        return _restored, (type(self), values)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the samples: of all arguments together, `(N,)` if they have one dimension."""
        return self._source.shape

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

    @property
    def held(self) -> Mapping[str, float | Array]:  # type: ignore[override]
        """Held joints and coordinates, and their positions [rad or m]; arrays where they vary."""
        return self._source.held

    @property
    def inertia(self) -> Mapping[str, Array]:
        """Links to the factors on their mass and inertia, of any shape."""
        return self._source.inertia

    @cached_property
    def loads(self) -> Mapping[str, Array | Wrench]:
        """Loaded joint to its effort, of any shape [N·m or N]; link to its `Wrench`."""
        links = {name: load.wrench for name, load in self._source.link_loads.items()}
        return frozen({**self._source.joint_loads, **links})

    @cached_property
    def idle_rods(self) -> list[tuple[str, ...]]:
        """Joints at the ends of every rod that may spin about its line.

        Nothing decides these spins; they are felt elsewhere only as far as a rod is not symmetric
        about its line. By rule, as seen from the nearest body from which both neighbours of a rod
        hang, it is turned about its line as the least rotation from its direction at the
        description's zero has it, and its rates have no part along the line; its acceleration is
        the one that inertia, weight and loads cause, since no moment acts about the line.
        Positions, rates and accelerations about the line are therefore not derivatives of each
        other.
        """
        return rods_by_name(self.mechanism, set(self._problem.passive_columns.tolist()))

    @property
    def gravity(self) -> Array:
        """Acceleration of free fall in world axes, `(3,)` or `(..., 3)` [m/s²]."""
        return self._source.gravity

    @cached_property
    def drive_effort(self) -> Array:
        """What the drive exerts `(N,)` [N·m or N], `(N, d)` for d drives.

        With the load there, it is the component of the joint's wrench along the driven coordinate's
        axis where that then is: see `Mechanism.drivable`.

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
        """Held joint or coordinate to what holds it, `(N,)` [N·m or N], like `drive_effort`."""
        return self._source.holding_effort()

    @cached_property
    def motion(self) -> Motion:
        """Positions, speeds and accelerations of all joints."""
        return self._source.motion()

    @property
    def time(self) -> Array:
        """Times at which actuators act, of any shape [s]."""
        return self._source.time

    @cached_property
    def element_force(self) -> ElementResults:
        """Elements to what they exert: by index or name.

        `JointSpring`, `JointFriction`, `Actuator`: `.effort`; `PointSpring`: `.tension`, `.length`,
        `.force`; `Bushing`: `.wrench`, `.deformation`; and all of them `.energy`, `.dissipation`.
        """
        from .element_results import element_results  # Imported here: most scenes have no elements.

        return element_results(self._problem.element_forces, self.motion, self.time)

    @cached_property
    def elastic_energy(self) -> Array:
        """Energy that springs and bushings store `(N,)` [J]."""
        return read_only(sum((f.energy for f in self.element_force.values()), np.zeros(self.shape)))

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

    def values(self) -> Iterator[JointWrench]:
        """Iterate over the wrenches."""
        return (self.wrench(name) for name in self.outputs)

    def __repr__(self) -> str:
        return (
            f"<Sweep of {self.mechanism.name!r}: {' × '.join(map(str, self.shape))} samples, "
            f"residuals: loop {self.loop_residual:.1e}, balance {self.balance_residual:.1e}, "
            f"power {self.power_residual:.1e}{self._chosen()}>"
        )

    @property
    def rule(self) -> str:
        """By which rule wrenches are chosen that statics leaves open."""
        return "least elastic energy" if self._problem.compliance else "least norm"

    def _chosen(self) -> str:
        """Return which wrenches statics leaves open and a rule has chosen, for `repr`."""
        opened = [
            name for name, row in zip(self.outputs, self.unique, strict=True) if not np.all(row)
        ]
        opened += [name for name, unique in self.coupling_unique.items() if not unique]
        if not opened:
            return ""
        more = f" and {len(opened) - 3} more" if len(opened) > 3 else ""
        return f"; not determined by statics, chosen by {self.rule}: {', '.join(opened[:3])}{more}"

    def wrench(self, joint: str, frame: str = "joint") -> JointWrench:
        """Return the wrench exerted by a joint's parent on its child, at the joint origin.

        Args:
            joint: one of `outputs`.
            frame: axes of the components: `joint` turns with the child; `parent` stays with the
                parent link, which for an end bearing means fixed axes; `world`.

        Raises:
            ModelError: the joint is unknown or none of the outputs.
            ArgumentError: unknown frame.
        """
        if not isinstance(joint, str) or joint not in self.outputs:
            self.mechanism.joint(joint)
            raise ModelError(
                f"the wrench of {joint!r} was not asked for; add it to the outputs of the scene, "
                f"which are: {choices(self.outputs)}"
            )
        if not isinstance(frame, str) or frame not in FRAMES:
            raise ArgumentError(
                f"frame {described(frame)} is unknown; frames: {choices(FRAMES, frame)}"
            )
        index = self.outputs.index(joint)
        components, axis = self._source.wrench(index), self.mechanism.joints[joint].axis
        if frame != "joint":
            from .axes import turned  # Imported here: most scripts use the joints' own axes.

            components, axis = turned(self.mechanism, joint, frame, components, self.rotation)
        has_axis = self.mechanism.joints[joint].type not in WITHOUT_AXIS
        flags = partial(self._unique_in, index, frame)
        return JointWrench(joint, frame, components, axis if has_axis else None, flags)

    def _unique_in(self, output: int, frame: str) -> Array:
        """Return which components `(6,)` of the wrench of an output are unique in some axes."""
        unique, joint = self.unique[output], self.outputs[output]
        if frame == "joint" or np.all(unique):
            return unique
        from .axes import rotation_to, unique_in

        rotation = rotation_to(self.mechanism, joint, frame, self.rotation)
        return unique_in(self._problem, joint, unique, rotation, self.motion.rows)

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
        """Return rotations and origins of a joint's frame, which are computed once."""
        name = self.mechanism.joint(joint).name
        if name not in self._placements:
            from .axes import solved_placement  # Imported here: most scripts need no placements.

            self._placements[name] = solved_placement(self.motion, name)
        return self._placements[name]

    @cached_property
    def _placements(self) -> dict[str, tuple[Array, Array]]:
        """Joints to the placements computed so far."""
        return {}


def _restored(kind: type[SweepData], values: dict[str, object]) -> SweepData:
    """Return a copy; `__reduce__` needs a function without keyword arguments."""
    return kind(**values)  # type: ignore[arg-type]
