"""Sweep: the result of a scene over drive positions, with the residuals that prove it.

As a table (`Sweep.to_xarray`, `Sweep.to_dataframe`) it has the dimensions
- `sample`, or `sample_0`, `sample_1` … where a response was evaluated on a grid,
- `joint`: the outputs, with wrenches in the joints' own axes,
- `component`: x, y, z, and `wrench_component`: the six flags of `unique`,
- `drive`, where there are several, `held` and `coupling`,
- `moving_joint`: joints with one coordinate, and the coordinates of others that turn or slide
  (`joint.turn_1`),
- `point`: those that were asked for (`point_position` … by `component`, in world axes),
- `element`: force elements by name, `elements[0]` where one has none; those along coordinates
  (`joint_element`, with `element_effort`), between points (`point_spring`, with `element_tension`,
  `element_length`, `element_force`) and `bushing` (`element_wrench` by `wrench_component`,
  `element_deformation` by `deformation_component`) once more by themselves.

`position`, `speed`, `acceleration`, and times, loads and gravity that vary, are coordinates. What
the outputs of a scene leave out is missing, or NaN for the motion of single joints. Every variable
has the attributes `units` and `long_name`. Where rotations and slides stand side by side, `units`
names both, and the coordinates `drive_unit`, `held_unit`, `coupling_unit` (of the efforts),
`effort_unit` (of joint elements) and `unit` (of the coordinates of moving joints; velocities are
per s, accelerations per s²) tell them apart.

A DataFrame has a row per sample (of a grid: in C order, with an index per dimension), and a flat
column per value. Flat names select by `frame.filter(like=".bending")`, plot by
`frame.plot("position", "bearing_out.bending")`, and go through any file format:

- `position`, `speed`, `acceleration`, `drive_effort`, `condition`; with several drives
  `leg_1.drive_position`, `leg_1.drive_effort` and so on,
- `bearing_out.force_x` … `bearing_out.moment_z`, `.force_magnitude`, `.moment_magnitude`,
  `.torsion`, `.bending`, `.axial`, `.shear`,
- `joint_angle.holding_effort`, `mesh.coupling_moment`, `load_bearing_out` where a load varies,
- `spring.element_tension`, `motor.element_effort`, `rubber.element_wrench_force_x`,
  `spring.element_energy`, `spring.element_dissipation`, and `elastic_energy` of all,
- `pin_in.position`, `pin_in.velocity`, `pin_in.acceleration`,
- of points that were asked for, `coupler.position_x` … `coupler.angular_acceleration_z`.

Those of a trajectory have its times, and its energies, besides: see `Trajectory.table`.

Its `attrs` hold `units` (column to unit), `unique` and `coupling_unique`, and the attributes of a
Dataset.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._version import __version__
from ...kit.arrays import Array, spread
from ...kit.checks import described
from ...kit.errors import ArgumentError, ModelError, SingularConfigurationError, choices
from ...kit.frozen import frozen, made, read_only
from ..elements.link_loads import WRENCH_COMPONENTS, Wrench
from ..kinematics.loops.idle_rods import rods_of
from ..problem.acting import Acting
from ..problem.problem import Problem
from ..proof.residuals import Proven
from .case_line import Lead
from .limits import exceeded
from .motion import Motion
from .prescribed import MotionResult
from .source import Source
from .table import Table, Variable
from .wrench import WITHOUT_AXIS, JointWrench, lengths

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ..dynamics.problem_solver import ProblemSolver
    from .derivative import Derivative, Swept
    from .element_results import ElementResults
    from .left_open import LeftOpen
    from .point_motion import Points
    from .rods import RodForce

FRAMES = ("joint", "parent", "world")
_STORED = ("unique", "coupling_moment", "coupling_unique", "condition", "proven")
"""Attributes that a copy takes over as they are."""
_FLAG_ATTRIBUTES = {
    "units": "1",
    "long_name": "whether it follows from the laws of motion alone",
}
_AXES = ("x", "y", "z")
_VECTORS = {"force": ("N", "force"), "moment": ("N·m", "moment")}
_SCALARS = {
    "force_magnitude": ("N", "size of the force"),
    "moment_magnitude": ("N·m", "size of the moment"),
    "torsion": ("N·m", "moment along the joint axis; nan where a joint has none"),
    "bending": ("N·m", "size of the moment across the joint axis; nan where a joint has none"),
    "axial": ("N", "force along the joint axis; nan where a joint has none"),
    "shear": ("N", "size of the force across the joint axis; nan where a joint has none"),
}
_SIGN = (
    "exerted by the parent link on the child link, at the joint's origin, in the joint's axes; "
    "loads and efforts of drives at the joint are part of them"
)
"""What a wrench is, in one sentence, wherever wrenches are written down."""
_RATES = {"position": "", "speed": "/s", "acceleration": "/s²"}
_MOTIONS = {"position": "", "velocity": "/s", "acceleration": "/s²"}
_UNITS = {
    "drive_effort": "drive_unit",
    "holding_effort": "held_unit",
    "coupling_moment": "coupling_unit",
    "element_effort": "effort_unit",
    "joint_position": "unit",
}
"""Variables to the coordinates that tell their units apart."""
_OF_MOMENTS = ("moment", "torsion", "bending")
_MOST_EVALUATED = 100_000
"""Operating points above which a notebook shows no wrenches: a response evaluates them when they
are read, and a grid of millions would take seconds for a cell that only names it."""


class Sweep(MotionResult):
    """Joint wrenches, drive efforts and motion of a scene over N samples.

    `sweep["bearing_out"]` is the `JointWrench` of a joint in its own frame; `wrench(name, frame)`
    gives it in other axes. A sweep of a `Response` may have operating points in several
    dimensions: then `(N,)` stands for their shape. Nothing in it can be changed.

    Attributes:
        unique: `(k, 6)` see `JointWrench.unique`, a row per output.
        coupling_moment: coupling to the moment or force `(N,)` [N·m or N] that it exerts on its
            successor's joint.
        coupling_unique: coupling to whether its moment follows from the laws of motion alone.
    """

    _held: Mapping[str, Array]
    _acting: Acting
    _source: Source
    _proven: Proven | Callable[[], Proven]
    unique: Array
    coupling_moment: Mapping[str, Array]
    coupling_unique: Mapping[str, bool]
    _condition: Array | Callable[[], Array]
    _solved_by: ProblemSolver | None

    def __init__(
        self,
        *,
        problem: Problem,
        held: Mapping[str, Array],
        acting: Acting,
        source: Source,
        unique: Array,
        coupling_moment: Mapping[str, Array],
        coupling_unique: Mapping[str, bool],
        condition: Array | Callable[[], Array],
        proven: Proven | Callable[[], Proven],
        solver: ProblemSolver | None = None,
    ) -> None:
        # `problem`, `held` (where not as in that) and `acting` are what was asked, `source` is
        # where the rest comes from when it is first read; the others are the attributes. `proven`
        # and `condition` may be computed when they are read. `solver` is that of the scene.
        unique.setflags(write=False)
        self._freeze(
            _problem=problem,
            _held=held,
            _acting=acting,
            _source=source,
            unique=unique,
            coupling_moment=coupling_moment,
            coupling_unique=coupling_unique,
            _condition=condition,
            _proven=proven,
            _solved_by=solver,
        )

    def __reduce__(self) -> tuple[object, ...]:
        # Through the constructor, which closes the arrays of a copy to writing as well.
        stored = {name: getattr(self, name) for name in _STORED}
        asked = {"problem": self._problem, "held": self._held, "acting": self._acting}
        # A response solves the motion when it is first read, to other roundings each time.
        known = {name: self.__dict__[name] for name in ("motion",) if name in self.__dict__}
        return made, (type(self), {**asked, "source": self._source, **stored}, known)

    @cached_property
    def condition(self) -> Array:
        """Condition number of the wrenches `(N,)`; their errors are some eps times it.

        It is that of the closure equations, times the greatest velocity ratio if that exceeds 1,
        times by how much inertial terms exceed what is left of them. One value, the greatest of its
        samples, if it comes from a `Response`.
        """
        return read_only(self._condition() if callable(self._condition) else self._condition)

    @cached_property
    def proven(self) -> Proven:
        """What follows of residuals, as one record."""
        return self._proven() if callable(self._proven) else self._proven

    @property
    def loop_residual(self) -> float:
        """Worst closure error.

        It is an angle [rad], or a gap as a fraction of `Mechanism.characteristic_length`;
        couplings, drives and held joints count as well.
        """
        return self.proven.loop_residual

    @property
    def balance_residual(self) -> float:
        """Worst Newton-Euler imbalance over all bodies, relative to the greatest wrench.

        The latter is that of all samples (inertial terms where wrenches are mere rounding of them).
        It proves what is unique. Of what the laws of motion leave open it proves that the choice is
        in balance, not that it is the least. NaN if only the drive efforts were asked for, and
        where nothing acts, so that there is nothing to compare.
        """
        return self.proven.balance_residual

    @property
    def power_residual(self) -> float:
        """Worst imbalance of drive, load, weight and inertia power.

        It is relative to the power that flows and to the greatest wrench times the greatest joint
        speed. NaN where the outputs leave part of that flow out, and where nothing acts.
        """
        return self.proven.power_residual

    @property
    def rate_residual(self) -> float:
        """Worst violation of the loops, couplings and drives by speeds and accelerations.

        It is relative to the greatest ones.
        """
        return self.proven.rate_residual

    @property
    def unproven(self) -> tuple[str, ...]:
        """Links that `balance_residual` leaves out.

        Not all that acts on them is among the outputs.
        """
        return self.proven.unproven

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the samples: of all arguments together, `(N,)` if they have one dimension."""
        return self._source.shape

    @cached_property
    def position(self) -> Array:
        """Drive positions `(N,)` [rad or m], `(N, d)` for d drives."""
        return self._of_drives(self._source.position)

    @cached_property
    def speed(self) -> Array:
        """Drive speeds [rad/s or m/s], like `position`."""
        return self._of_drives(self._acting.speeds)

    @cached_property
    def acceleration(self) -> Array:
        """Drive accelerations [rad/s² or m/s²], like `position`."""
        return self._of_drives(self._acting.accelerations)

    def _of_drives(self, values: Array) -> Array:
        """Return values `(..., d)` in the shape of the samples, without an axis for one drive."""
        values = spread(values, (*self.shape, values.shape[-1]))
        return read_only(values[..., 0] if values.shape[-1] == 1 else values)

    @cached_property
    def held(self) -> Mapping[str, float | Array]:  # type: ignore[override]
        """Held joints and coordinates, and their positions [rad or m]; arrays where they vary."""
        return frozen({**self._problem.held, **self._held})

    @property
    def inertia(self) -> Mapping[str, Array]:
        """Links to the factors on their mass and inertia, of any shape."""
        return self._acting.inertia

    @cached_property
    def loads(self) -> Mapping[str, Array | Wrench]:
        """Loaded joint to its effort, of any shape [N·m or N]; link to its `Wrench`."""
        links = {name: load.wrench for name, load in self._acting.link_loads.items()}
        return frozen({**self._acting.joint_loads, **links})

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
        return rods_of(self._problem)

    @property
    def gravity(self) -> Array:
        """Acceleration of free fall in world axes, `(3,)` or `(..., 3)` [m/s²]."""
        return read_only(self._acting.gravity)

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
        return self._of_drives(effort)

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
        return read_only(self._acting.time)

    @cached_property
    def element_force(self) -> ElementResults:
        """Elements to what they exert: by index or name.

        `JointSpring`, `JointFriction`, `Actuator`: `.effort`; `PointSpring`, `PointActuator`:
        `.tension`, `.length`, `.force`; `Bushing`: `.wrench`, `.deformation`; and all of them
        `.energy`, `.dissipation`.
        """
        from .element_results import ElementResults  # Imported here: most scenes have no elements.

        x, v = self.motion.rows, self.joint_velocities
        return ElementResults.of(self._problem, x, v, self.time, self.shape)

    @cached_property
    def elastic_energy(self) -> Array:
        """Energy that springs and bushings store `(N,)` [J]."""
        return read_only(sum((f.energy for f in self.element_force.values()), np.zeros(self.shape)))

    def __len__(self) -> int:
        return self.shape[0]

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
        checks = [f"loop {self.loop_residual:.1e}"]
        if not math.isnan(self.balance_residual):
            checks.append(f"balance {self.balance_residual:.1e}")
        if not math.isnan(self.power_residual):
            checks.append(f"power {self.power_residual:.1e}")
        beware = "".join(f"; {text}" for text in (self.left_open.brief, *self.beware) if text)
        return (
            f"<Sweep of {self.mechanism.name!r}: {' × '.join(map(str, self.shape))} samples, "
            f"{self._driven()}{self._unchecked()}residuals: {', '.join(checks)}{beware}>"
        )

    @property
    def beware(self) -> tuple[str, ...]:
        """In words that wrenches are close to singular, and where limits are exceeded.

        Of samples too many to be evaluated for a text, nothing is told.
        """
        if math.prod(self.shape) > _MOST_EVALUATED:
            return ()
        return tuple(filter(None, [self.near_singular(), self.near_reach, *exceeded(self)]))

    def near_singular(self, *wrenches: JointWrench) -> str:
        """Return in words that the greatest wrenches come from close to a singular configuration.

        Nothing where they do not, nor, unless wrenches are given, of samples too many to be
        evaluated for a text.

        Args:
            wrenches: of the sweep; all of them if none is given.
        """
        from .lost_digits import (  # Imported here: only texts tell it.
            WELL,
            lost_part,
            near_singular,
        )

        is_large = not wrenches and math.prod(self.shape) > _MOST_EVALUATED
        if is_large or np.max(self.condition, initial=0.0) <= WELL:
            return ""
        length, sizes, most = self.mechanism.characteristic_length, np.zeros(self.shape), 0.0
        for wrench in wrenches or self.values():
            force, moment = wrench.magnitude
            sizes = np.fmax(sizes, np.fmax(force, moment / length))
            most = max(most, float(np.nanmax(force, initial=0.0)))
        told = near_singular(lost_part(self.condition, sizes))
        return f"{told}, where forces reach {most:.3g} N" if told else ""

    @property
    def near_reach(self) -> str:
        """In words that what moves as given is close to where its reach ends; see `TaskSweep`."""
        return ""

    def _driven(self) -> str:
        """Return over which range a single drive moves, for `repr`: it shows degrees as turns."""
        if len(self.coordinates) != 1:
            return ""
        (name,) = self.coordinates
        low, high = float(np.min(self.position)), float(np.max(self.position))
        unit, turns = self.mechanism.drivable[name].unit, (high - low) / (2.0 * np.pi)
        if not low < high:
            return ""
        how_often = f" ({turns:.3g} turns)" if unit == "rad" and turns > 1.001 else ""
        return f"{name} {low:.4g} to {high:.4g} {unit}{how_often}, "

    def _unchecked(self) -> str:
        """Return in words what residuals that are nan mean, for `repr`."""
        if math.isnan(self.balance_residual):
            return "nothing acts, " if self.outputs else "drive efforts alone, "
        return ""

    @property
    def rule(self) -> str:
        """By which rule wrenches are chosen that statics leaves open."""
        return "least elastic energy" if self._problem.compliance else "least norm"

    @cached_property
    def left_open(self) -> LeftOpen:
        """What of its outputs does not follow from the laws of motion, and why."""
        from .left_open import LeftOpen  # Imported here: scripts that print nothing do without.

        unique = dict(zip(self.outputs, self.unique, strict=True))
        return LeftOpen.of(self.rule, self.mechanism.undescribed, unique, self.coupling_unique)

    def wrench(self, joint: str, frame: str = "joint") -> JointWrench:
        """Return the wrench exerted by a joint's parent on its child, at the joint origin.

        Args:
            joint: one of `outputs`.
            frame: axes of the components: `joint` turns with the child; `parent` stays with the
                parent link, which for an end bearing means fixed axes; `world`; or the name of a
                link, or of a frame in one. The moment is about the joint's origin, see
                `JointWrench.at`.

        Raises:
            ModelError: the joint is unknown or none of the outputs.
            ArgumentError: unknown frame.
        """
        outputs, mechanism = self._problem.outputs, self._problem.mechanism
        if not isinstance(joint, str) or joint not in outputs:
            mechanism.joint(joint)
            raise ModelError(
                f"the wrench of {joint!r} was not asked for; add it to the outputs of the scene, "
                f"which are: {choices(outputs)}"
            )
        is_text = type(frame) is str or isinstance(frame, str)
        if not is_text or (frame not in FRAMES and frame not in mechanism.link_frames):
            links = f"; or those of a link: {choices(mechanism.link_frames, frame)}"
            raise ArgumentError(
                f"frame {described(frame)} is unknown; frames: {choices(FRAMES, frame)}{links}"
            )
        index = outputs.index(joint)
        components, item = self._source.wrench(index), mechanism.joints[joint]
        axis = item.axis
        if frame != "joint":
            from .axes import turned  # Imported here: most scripts use the joints' own axes.

            components, axis = turned(self, joint, frame, components)
        has_axis = item.type not in WITHOUT_AXIS
        flags = partial(self._unique_in, index, frame)
        return JointWrench(joint, frame, components, axis if has_axis else None, flags, self)

    def _unique_in(self, output: int, frame: str) -> Array:
        """Return which components `(6,)` of the wrench of an output are unique in some axes."""
        unique, joint = self.unique[output], self.outputs[output]
        if frame == "joint" or np.all(unique):
            return unique
        rotation = self._rotation_from_joint(joint, frame)
        maps = np.zeros((*rotation.shape[:-2], 6, 6))
        maps[..., :3, :3] = maps[..., 3:, 3:] = rotation
        return read_only(self._unique_sums(joint, maps, np.repeat([True, False], 3)))

    def _rotation_from_joint(self, joint: str, frame: str) -> Array:
        """Return rotations `(N, 3, 3)`, or `(3, 3)`, from a joint's own axes to others.

        Args:
            joint: name of the joint.
            frame: see `wrench`.

        Raises:
            ModelError: unknown joint, or one whose motion the outputs leave out.
        """
        if frame == "joint":
            return np.eye(3)
        from .axes import rotation_to

        return rotation_to(self, joint, frame)

    def _unique_sums(self, joint: str, maps: Array, are_forces: Array) -> Array:
        """Return `(k,)` which sums of the components of a wrench are unique, at all positions.

        Args:
            joint: one of the outputs.
            maps: `(..., k, 6)` factors on force and moment, in the joint's own axes.
            are_forces: `(k,)` which sums are forces; the others are moments.
        """
        from .axes import unique_of

        unique = self.unique[self.outputs.index(joint)]
        rows = self.motion.rows
        if maps.ndim == len(self.shape) + 2:
            maps = maps.reshape(len(rows), *maps.shape[-2:])
        return unique_of(self._problem, joint, unique, rows, maps, are_forces)

    def derivative(self, *parameters: str) -> Derivative | Mapping[str, Derivative]:
        """Return how the results change with numbers that were given, exactly.

        Derivatives are of the equations themselves, not of differences: closed positions follow
        from the implicit function of the loops, rates and wrenches by the chain rule. What elements
        exert is differentiated by differences whose steps are made finer until they agree, to some
        1e-11; all numbers of elements that parameters name are exact.

        Args:
            parameters: one, or several, in SI units: a driven or held coordinate (which a length
                or an angle of the mechanism may be, see `Mechanism.adjustable`); `speed:DRIVE`,
                `acceleration:DRIVE`; `load:JOINT`, or `load:LINK.force_x` (… `moment_z`) of a link
                with a load in the sweep, in the load's axes; `gravity.x` (`.y`, `.z`); `mass:LINK`,
                with its centre and inertia about it as they are; `centre:LINK.x` and
                `inertia:LINK.xx` (… `xy`), in the link's axes; `origin:JOINT.x` (… `z`, `roll`,
                `pitch`, `yaw`), or `origin:LOOP.predecessor.x`, in the axes of the link that
                carries it, with a pitch between ±90° whatever angles the text has;
                `stiffness:ELEMENT`, `damping:ELEMENT`, and `friction:ELEMENT`, the effort of a
                `JointFriction`. With `*` in it, a name stands for all that it matches and by which
                there is a derivative.

        Returns:
            What is read like the sweep: `["joint"].force`, `.drive_effort`,
            `.motion.position("joint")`. Of several parameters, and of those that a `*` stands for,
            a mapping from their names.

        Raises:
            ArgumentError: a name that says no parameter, or more than fits into memory.
            ModelError: no such joint, link or element; or a loop closes only as long as the
                parameter is what it is.
            SingularConfigurationError: a time of a simulation is a dead point of what is free.
        """
        from .derivative import derivatives_of  # Few sweeps are differentiated.

        found = derivatives_of(self._swept(parameters), parameters)
        if len(parameters) > 1 or "*" in parameters[0]:
            return frozen(found)
        return found[parameters[0]]

    def gradient(self, weights: Mapping[str, ArrayLike], *parameters: str) -> Mapping[str, float]:
        """Return how a weighted sum of results changes with numbers that were given.

        It is what `derivative` gives, times the weights, summed up over all samples; but found
        backwards, so that thousands of parameters take about as long as one. Weights of a function
        of results are its derivatives by these.

        Args:
            weights: results to weights, in the shape of the result or one that broadcasts with it:
                `drive_effort`, or `DRIVE.drive_effort`; `JOINT.force` and `JOINT.moment`, in the
                joint's axes, or a component such as `JOINT.force_x`; `JOINT.position`, `.velocity`
                and `.acceleration`; `JOINT.holding_effort`; `COUPLING.coupling_moment`.
            parameters: one or several, as of `derivative`.

        Returns:
            Parameter to the derivative [units of results times weights, per its unit].

        Raises:
            ArgumentError: as `derivative`; weights that are no numbers, or have another shape.
            ModelError: as `derivative`; no such result, or one that is not unique, or whose change
                with a parameter is not.
        """
        from .derivative import slopes_of

        return slopes_of(self._swept(parameters), weights, parameters)

    def _swept(self, parameters: tuple[object, ...]) -> Swept:
        """Return what derivatives follow from; errors as of `derivative`."""
        from .derivative import Swept

        if not parameters:
            raise ArgumentError("name the parameters, such as derivative('bearing_in')")
        # Drives decide where all is driven: rates that a sweep did not keep are not found for it.
        free = self._problem.free
        if free and (undecided := np.isnan(self.motion.velocity_ratios.values).all(axis=1)).any():
            sample = int(np.argmax(undecided))
            raise SingularConfigurationError(
                f"{choices(self.coordinates)} do not decide the motion at sample {sample}, so that "
                "nothing has a derivative there: leave such times out with at()",
                sample=sample,
            )
        uniqueness = self.unique, self.coupling_unique
        return Swept(self._solver, self._acting, self.motion, *uniqueness)

    @cached_property
    def _solver(self) -> ProblemSolver:
        """Solves what was asked, at the same positions of held coordinates."""
        from ..dynamics.problem_solver import ProblemSolver

        solver = self._solved_by or ProblemSolver(self._problem)
        return solver.of_varied(tuple(self._held))

    def rod_force(self, link: str) -> RodForce:
        """Return the force along a rod between two balls, positive in tension.

        Args:
            link: name of a link with two joints, balls or universal ones.

        Raises:
            ModelError: unknown link, one that is no such rod, or whose joints are no outputs.
        """
        from .rods import rod_force  # Imported here: few mechanisms have such rods.

        return rod_force(self, link)

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
            from .axes import refuse_unsolved  # Imported here: most scripts need no placements.

            refuse_unsolved(name, *(found := self.motion.joint_placement(name)))
            self._placements[name] = read_only(found[0]), read_only(found[1])
        return self._placements[name]

    @cached_property
    def _placements(self) -> dict[str, tuple[Array, Array]]:
        """Joints to the placements computed so far."""
        return {}

    @property
    def leads(self) -> list[Lead]:
        """What moves as given, one by one, for titles and axes of figures."""
        position, speed = (
            np.reshape(values, (*self.shape, -1)) for values in (self.position, self.speed)
        )
        drivable = self.mechanism.drivable
        return [
            Lead(name, drivable[name].slides, position[..., k], speed[..., k])
            for k, name in enumerate(self.coordinates)
        ]

    def given(self) -> Table:
        """Return drive positions, and what was given besides and varies, without results."""
        return Table(
            variables=list(_given(self)),
            samples=dict(zip(_sample_dims(self), self.shape, strict=True)),
            labels={"drive": self.coordinates, "component": _AXES},
            attributes={"mechanism": self.mechanism.name, "cardan_dyn_version": __version__},
        )

    def table(self, *, motion: bool = True, points: Points = ()) -> Table:
        """Return all results as a table, see the top of this module.

        Args:
            motion: whether to include the motion of the joints.
            points: see `to_dataframe`.
        """
        return self._with_points(_table_of(self, motion), points)

    def _repr_html_(self) -> str:
        """Return the greatest wrenches, then the residuals."""
        from ...kit.markup import element, table  # Imported here: only notebooks show it.

        shape = " × ".join(str(size) for size in self.shape)
        title = element("p", f"Sweep of {self.mechanism.name}: {shape} samples")
        if math.prod(self.shape) > _MOST_EVALUATED:
            wrenches = element("p", "Wrenches are not evaluated for a table of so many samples.")
        else:
            quantities = ("force [N]", *(f"{name} [N·m]" for name in _OF_MOMENTS))
            header = ("joint", *quantities, "unique")
            told = f"Greatest values; wrenches are {_SIGN}."
            for text in filter(None, (self.left_open.text, self.near_singular())):
                told += f" {text[0].upper()}{text[1:]}."
            wrenches = table(header, (_greatest(wrench) for wrench in self.values()))
            wrenches += element("p", told)
        # That of the power is left out as well where the outputs leave out part of its flow.
        idle = self.outputs and math.isnan(self.balance_residual)
        unknown = "nothing acts" if idle else "not computed"
        residuals = (
            (
                name.removesuffix("_residual"),
                unknown if math.isnan(residual) else f"{residual:.1e}",
            )
            for name, residual in self.proven.residuals.items()
        )
        return f"<div>{title}{wrenches}{table(('residual', 'value'), residuals)}</div>"


def _greatest(wrench: JointWrench) -> tuple[str, ...]:
    """Return the greatest force, moment and shares of it in a joint, and what of them is unique."""
    from .left_open import named_components  # Imported here: only notebooks show it.

    parts: list[Array] = [wrench.torsion, wrench.bending] if wrench.has_axis else []
    force, moment, *shares = (
        f"{float(np.nanmax(np.abs(values), initial=0.0)):.4g}"
        for values in (*wrench.magnitude, *parts)
    )
    unique = "yes" if np.all(wrench.unique) else f"not {named_components(~wrench.unique)}"
    force += wrench._unique_parts("force")
    return (wrench.joint, force, moment, *(shares or ["no axis"] * 2), unique)


def _table_of(sweep: Sweep, motion: bool) -> Table:
    """Return the table of a sweep; see `Sweep.to_xarray`."""
    unique = np.array(sweep.unique)
    coupling_unique = np.array(list(sweep.coupling_unique.values()), dtype=bool)
    flags: dict[str, Any] = {}
    if sweep.outputs:
        flags["unique"] = (("joint", "wrench_component"), unique, _FLAG_ATTRIBUTES)
    if coupling_unique.size:
        flags["coupling_unique"] = (("coupling",), coupling_unique, _FLAG_ATTRIBUTES)
    variables = [*_given(sweep), *_found(sweep, motion)]
    gravity = sweep.gravity.tolist() if sweep.gravity.ndim == 1 else "see coordinate gravity"
    return Table(
        variables=variables,
        samples=dict(zip(_sample_dims(sweep), sweep.shape, strict=True)),
        labels=_labels(sweep),
        units={
            _UNITS[name]: (item.dims[-1], list(item.units))
            for name, item in variables
            if name in _UNITS and not isinstance(item.units, str)
        },
        # Numbers and texts, so that any file format takes them.
        attributes={
            "mechanism": sweep.mechanism.name,
            "drives": ", ".join(sweep.coordinates),
            "held": json.dumps(
                {
                    name: f"see coordinate held_{name}" if np.ndim(value) else float(value)
                    for name, value in sweep.held.items()
                },
                ensure_ascii=False,
            ),
            "loads": json.dumps(
                {name: _constant(name, load) for name, load in sweep.loads.items()},
                ensure_ascii=False,
            ),
            "gravity": gravity,
            "wrenches": _SIGN,
            "not_unique": sweep.left_open.text,
            **sweep.proven.residuals,
            "unproven": ", ".join(sweep.unproven),
            "cardan_dyn_version": __version__,
        },
        flags=flags,
        frame_attributes={
            "unique": dict(zip(sweep.outputs, unique.tolist(), strict=True)),
            "coupling_unique": dict(sweep.coupling_unique),
        },
    )


def _given(sweep: Sweep) -> Iterator[tuple[str, Variable]]:
    """Return positions and rates of the drives, and what else was given and varies."""
    drivable, names, gravity = sweep.mechanism.drivable, sweep.coordinates, sweep.gravity
    entries: list[tuple[Any, ...]] = []
    for name, per_time in _RATES.items():
        values, units = getattr(sweep, name), tuple(drivable[n].unit + per_time for n in names)
        if len(names) > 1:
            dims = *_sample_dims(sweep), "drive"
            yield name, Variable(dims, values, units, f"{name} of the drive", True)
        else:
            entries.append((name, values, units[0], f"{name} of the drive {names[0]}"))
    if sweep.time.ndim:
        entries.append(("time", sweep.time, "s", "time"))
    for name, load in sweep.loads.items():
        if not isinstance(load, Wrench):
            unit = drivable[name].effort_unit if load.ndim else ""
            entries.append((f"load_{name}", load, unit, f"load on joint {name}"))
            continue
        for quantity, (unit, _) in _VECTORS.items():
            label = f"{quantity} on link {name}, in {load.frame} axes"
            values = np.asarray(getattr(load, quantity))
            entries.append((f"load_{name}_{quantity}", values, unit, label, "component"))
    for name, position in sweep.held.items():
        label = f"position at which {name} is held"
        entries.append((f"held_{name}", np.asarray(position), drivable[name].unit, label))
    for name, factor in sweep.inertia.items():
        label = f"factor on mass and inertia of link {name}"
        entries.append((f"inertia_{name}", np.atleast_1d(factor), "1", label))
    label = "acceleration of free fall, in world axes"
    entries.append(("gravity", gravity, "m/s²", label, "component"))
    for name, values, unit, label, *along in entries:
        if values.ndim > len(along):
            kept, values = _varying_dims(values, sweep, len(along))
            yield name, Variable((*kept, *along), values, unit, label, True)


def _found(sweep: Sweep, motion: bool) -> Iterator[tuple[str, Variable]]:
    """Return what was found, as far as it was solved."""
    dims, drivable = _sample_dims(sweep), sweep.mechanism.drivable
    if wrenches := list(sweep.values()):
        vectors = {
            name: np.stack([getattr(wrench, name) for wrench in wrenches], axis=-2)
            for name in _VECTORS
        }
        for name, (unit, label) in _VECTORS.items():
            long_name = f"{label} of the parent on the child, in the joint's axes"
            yield name, Variable((*dims, "joint", "component"), vectors[name], unit, long_name)
        nothing = np.full(sweep.shape, np.nan)
        for name, (unit, label) in _SCALARS.items():
            whole = name.removesuffix("_magnitude")
            if whole != name:
                values = lengths(vectors[whole])
            else:
                parts = [getattr(item, name) if item.has_axis else nothing for item in wrenches]
                values = np.stack(parts, axis=-1)
            yield name, Variable((*dims, "joint"), values, unit, label)
    units = tuple(drivable[name].effort_unit for name in sweep.coordinates)
    label = f"effort of {sweep.coordinates[0]}" if len(units) == 1 else "effort of the drives"
    along = ("drive",) if len(units) > 1 else ()
    with suppress(ModelError):  # The outputs leave it out.
        effort = sweep.drive_effort
        yield "drive_effort", Variable((*dims, *along), effort, units if along else units[0], label)
    if holding := sweep.holding_effort:
        units = tuple(drivable[name].effort_unit for name in holding)
        values = np.stack(list(holding.values()), axis=-1)
        yield "holding_effort", Variable((*dims, "held"), values, units, "effort that holds it")
    if moments := sweep.coupling_moment:
        units = tuple(coupling_unit(sweep, name) for name in moments)
        label = "effort on the joint of the coupling's successor"
        values = np.stack(list(moments.values()), axis=-1)
        yield "coupling_moment", Variable((*dims, "coupling"), values, units, label)
    if sweep.elements:
        yield from _of_elements(sweep)
    if motion:
        units_of = [drivable[joint].unit for joint in sweep.mechanism.coordinates.named]
        for (name, per_time), values in zip(_MOTIONS.items(), sweep.motion.of_named, strict=True):
            units = tuple(unit + per_time for unit in units_of)
            label = f"{name} of the joint's coordinate"
            yield f"joint_{name}", Variable((*dims, "moving_joint"), values, units, label)
    over_samples = sweep.condition.shape == sweep.shape
    condition = sweep.condition if over_samples else sweep.condition[0]
    dims = dims if over_samples else ()
    yield "condition", Variable(dims, condition, "1", "condition number of the wrenches")


def _of_elements(sweep: Sweep) -> Iterator[tuple[str, Variable]]:
    """Return what elements exert and store, a variable per quantity."""
    dims, forces = _sample_dims(sweep), list(sweep.element_force.values())
    drivable = sweep.mechanism.drivable
    for group, members in _groups(sweep).items():
        for quantity in sweep.elements[members[0]].quantities:
            along = (quantity.components,) if quantity.components else ()
            values = [getattr(forces[index], quantity.field) for index in members]
            units: str | tuple[str, ...] = quantity.units or tuple(
                drivable[sweep.elements[index].joints[0]].effort_unit for index in members
            )
            whole = np.stack(values, -1 - len(along))
            yield quantity.name, Variable((*dims, group, *along), whole, units, quantity.label)
    for name, unit, label in (
        ("energy", "J", "energy that the element stores"),
        ("dissipation", "W", "power that the element turns into heat"),
    ):
        values = [getattr(force, name) for force in forces]
        whole = np.stack(values, axis=-1)
        yield f"element_{name}", Variable((*dims, "element"), whole, unit, label)
    label = "energy that all springs and bushings store"
    yield "elastic_energy", Variable(dims, sweep.elastic_energy, "J", label)


def _sample_dims(sweep: Sweep) -> tuple[str, ...]:
    """Return the names of the dimensions of the operating points."""
    count = len(sweep.shape)
    return ("sample",) if count == 1 else tuple(f"sample_{index}" for index in range(count))


def _varying_dims(values: Array, sweep: Sweep, trailing: int = 0) -> tuple[tuple[str, ...], Array]:
    """Return the dimensions along which values `(..., trailing)` were given, and the values there.

    In a sweep over one dimension all coordinates have it. On a grid each has only the dimensions
    along which it varies, since otherwise it would be as large as the grid.
    """
    names, rest = _sample_dims(sweep), values.shape[values.ndim - trailing :]
    if len(names) == 1:
        return names, np.broadcast_to(values, (*sweep.shape, *rest))
    missing = len(names) + trailing - values.ndim
    padded = values.reshape((1,) * missing + values.shape)
    # Along an axis without stride, all values are the same one.
    once: Any = tuple(
        slice(None) if size > 1 and stride else slice(0, 1)
        for size, stride in zip(padded.shape, padded.strides, strict=True)
    )
    padded = padded[(*once[: len(names)], ...)]
    kept = [axis for axis, size in enumerate(padded.shape[: len(names)]) if size > 1]
    dims = tuple(names[axis] for axis in kept)
    return dims, padded.reshape([*(padded.shape[axis] for axis in kept), *rest])


def _labels(sweep: Sweep) -> dict[str, Sequence[str]]:
    """Return the names along each dimension that is not one of the operating points."""
    found: dict[str, Sequence[str]] = {
        "joint": sweep.outputs,
        "component": _AXES,
        "wrench_component": WRENCH_COMPONENTS,
        "drive": sweep.coordinates,
        "held": tuple(sweep.holding_effort),
        "coupling": tuple(sweep.coupling_moment),
        "moving_joint": tuple(sweep.mechanism.coordinates.named),
        "element": _element_names(sweep),
    }
    for group, members in _groups(sweep).items():
        found[group] = tuple(found["element"][index] for index in members)
        for quantity in sweep.elements[members[0]].quantities:
            if quantity.components:
                found.setdefault(quantity.components, quantity.component_names)
    return found


def _groups(sweep: Sweep) -> dict[str, list[int]]:
    """Return dimensions of tables, and the indices of the elements that stand along each."""
    groups: dict[str, list[int]] = {}
    for index, element in enumerate(sweep.elements):
        groups.setdefault(element.group, []).append(index)
    return groups


def _element_names(sweep: Sweep) -> tuple[str, ...]:
    """Return names of elements, `elements[0]` where one has none."""
    names = [element.name or f"elements[{index}]" for index, element in enumerate(sweep.elements)]
    for name in names:
        if names.count(name) > 1:
            raise ModelError(
                f"an element is called {name!r}, by which tables show the one that has no name; "
                "give it another name"
            )
    return tuple(names)


def coupling_unit(sweep: Sweep, name: str) -> str:
    """Return the unit of what a coupling exerts on its successor's joint, a slide or a rotation."""
    mechanism = sweep.mechanism
    (coupling,) = (item for item in mechanism.couplings if item.name == name)
    # No joint moves a successor that carries the predecessor: the ratio is taken as a plain number.
    column = (coupling.successor_columns or coupling.predecessor_columns)[0]
    named = mechanism.coordinates.named
    (joint,) = (name for name, coordinate in named.items() if coordinate.rate == column)
    return sweep.mechanism.drivable[joint].effort_unit


def _constant(name: str, load: Array | Wrench) -> Any:
    """Return a load as JSON holds it; the name of its coordinate if it varies."""
    if isinstance(load, Wrench):
        vectors = {"force": np.asarray(load.force), "moment": np.asarray(load.moment)}
        values = {
            quantity: samples.tolist()
            if samples.ndim == 1
            else f"see coordinate load_{name}_{quantity}"
            for quantity, samples in vectors.items()
        }
        return {**values, "frame": load.frame, "point": np.asarray(load.point).tolist()}
    return f"see coordinate load_{name}" if load.ndim else float(load)
