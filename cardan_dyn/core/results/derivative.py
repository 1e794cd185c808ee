"""Derivative: how the results of a sweep change with a number that was given, sample by sample."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np

from ...kit.arrays import EPS, Array
from ...kit.checks import vector
from ...kit.errors import ArgumentError, ModelError, choices
from ...kit.frozen import Frozen, frozen, read_only
from ..description.origins import PREFIX, origin_of, with_origins, without_origins
from ..dynamics.differentiated import (
    Change,
    OfColumn,
    OfElement,
    OfMass,
    OfOrigin,
    OfRow,
    Parameter,
    changes_of,
)
from ..dynamics.inverse_dynamics import Inputs
from ..dynamics.problem_solver import ProblemSolver
from ..dynamics.velocity_ratios import VelocityRatios
from ..mechanics.bodies import Mass
from ..mechanism.carried import CarriedFrame
from ..mechanism.mechanism import Mechanism
from ..problem.acting import Acting
from ..problem.problem import Problem
from .motion import Motion

if TYPE_CHECKING:
    from numpy.typing import ArrayLike
    from pinocchio import SE3

    from ..description.description import LinkDescription
    from ..tape import Scalar

_AXES = "xyz"
_FORMS = (
    "a driven or held coordinate, 'speed:DRIVE', 'acceleration:DRIVE', 'load:JOINT', 'gravity.x', "
    "'mass:LINK', 'centre:LINK.x', 'inertia:LINK.xx', 'origin:JOINT.x' (y, z, roll, pitch, yaw), "
    "'stiffness:ELEMENT' or 'damping:ELEMENT'"
)


class Swept(NamedTuple):
    """What of a sweep its derivatives follow from.

    Attributes:
        problem: of the scene.
        acting: how fast the drives move, and what acts.
        varied: names of held coordinates whose positions differ from the scene's.
        motion: of all samples.
        unique: `(k, 6)` see `JointWrench.unique`, a row per output.
        coupling_unique: coupling to whether its moment is unique.
        knows_drives: whether the efforts of drives are known.
        holding: held coordinates whose efforts are known.
    """

    problem: Problem
    acting: Acting
    varied: tuple[str, ...]
    motion: Motion
    unique: Array
    coupling_unique: Mapping[str, bool]
    knows_drives: bool
    holding: tuple[str, ...]


class WrenchDerivative(NamedTuple):
    """How the wrench of a joint changes, in the joint's own axes.

    Components that do not follow from the laws of motion alone are NaN.

    Attributes:
        force: `(…, 3)` [N per unit].
        moment: `(…, 3)` [N·m per unit].
        unique: `(6,)` see `JointWrench.unique`.
    """

    force: Array
    moment: Array
    unique: Array


class MotionDerivative(NamedTuple):
    """How the motion of joints changes.

    Attributes:
        changes: positions, rates and ratios, which hold derivatives.
    """

    changes: Motion

    def position(self, joint: str) -> Array:
        """Return that of `Motion.position`, of turns and slides `(…)` [rad or m per unit]."""
        return self.changes.position(joint)

    def velocity(self, joint: str) -> Array:
        """Return that of `Motion.velocity`."""
        return self.changes.velocity(joint)

    def acceleration(self, joint: str) -> Array:
        """Return that of `Motion.acceleration`."""
        return self.changes.acceleration(joint)

    def ratio(self, joint: str, drive: int | str = 0) -> Array:
        """Return that of `Motion.ratio`."""
        return self.changes.ratio(joint, drive)


class Derivative(Frozen):
    """How the results of a sweep change with a number, per its unit; all else that is given stays.

    It is read like the sweep. Derivatives are exact: the equations themselves are differentiated.
    At places where a result has a kink, they are those of one of its sides. Sizes, such as bending
    moments, are no components: differentiate them by hand, where they are not zero.

    Attributes:
        parameter: the number, as it was named.
        loop_residual: greatest rate at which closure errors grow, which vanishes [lengths of the
            mechanism per unit].
    """

    parameter: str
    loop_residual: float
    _of: Swept
    _change: Change

    def __init__(self, parameter: str, of: Swept, change: Change) -> None:
        self._freeze(
            parameter=parameter,
            loop_residual=float(change.opened.max(initial=0.0)),
            _of=of,
            _change=change,
        )

    def __repr__(self) -> str:
        return f"<Derivative by {self.parameter!r}: {len(self._change.x)} samples>"

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the samples."""
        return self._of.motion.shape

    def __getitem__(self, joint: str) -> WrenchDerivative:
        """Return how the wrench of an output changes.

        Raises:
            ModelError: it is no output.
        """
        problem = self._of.problem
        if joint not in problem.outputs:
            raise ModelError(f"no output {joint!r}; outputs: {choices(problem.outputs, joint)}")
        output = problem.outputs.index(joint)
        unique = self._of.unique[output]
        every = self._change.wrenches.reshape(len(self._change.wrenches), -1, 6)
        own = every[:, np.arange(every.shape[1])[problem.output_indices][output]]
        values = read_only(np.where(unique, own, np.nan).reshape(*self.shape, 6))
        return WrenchDerivative(values[..., :3], values[..., 3:], unique)

    @cached_property
    def drive_effort(self) -> Array:
        """That of `Sweep.drive_effort`.

        Raises:
            ModelError: the outputs of the scene leave it out.
        """
        drives = self._of.problem.independent
        if not self._of.knows_drives:
            raise ModelError("the drive effort was not asked for; add the driven joint to outputs")
        values = self._efforts(drives).reshape(*self.shape, -1)
        return read_only(values[..., 0] if len(drives) == 1 else values)

    @cached_property
    def holding_effort(self) -> Mapping[str, Array]:
        """Held joint or coordinate to the derivative of what holds it."""
        return frozen(
            {name: self._efforts([name]).reshape(self.shape) for name in self._of.holding}
        )

    def _efforts(self, names: Iterable[str]) -> Array:
        return self._change.efforts[:, self._of.problem.mechanism.coordinates.rates_of(names)]

    @cached_property
    def coupling_moment(self) -> Mapping[str, Array]:
        """Coupling to the derivative of its moment; NaN where that is not unique."""
        names = [item.name for item in self._of.problem.mechanism.couplings]
        moments = self._change.couplings
        return frozen(
            {
                name: moments[:, names.index(name)].reshape(self.shape)
                * (1.0 if is_unique else np.nan)
                for name, is_unique in self._of.coupling_unique.items()
            }
        )

    def point(self, link: str, xyz: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
        """Return how a point of a link moves `(…, 3)` [m per unit], in world axes.

        Args:
            link: name of the link, or of a frame that is fixed in one.
            xyz: `(3,)` the point, from the origin of that and in its axes [m].

        Raises:
            ModelError: unknown link, or the parameter is a length or an angle that is not held.
            ArgumentError: `xyz` is no `(3,)` of finite numbers.
        """
        of = self._of.motion
        if self.parameter.startswith(PREFIX) and self.parameter not in of.mechanism.joints:
            raise ModelError(
                f"{self.parameter}: points that it moves are known where it is held: "
                f"Scene(..., held={{{self.parameter!r}: 0.0}})",
                name=self.parameter,
            )
        carrier = CarriedFrame(of.mechanism, link, vector("xyz", xyz, 3))
        v = of.mechanism.coordinates.velocity(of.x, self._change.x)
        return read_only(carrier.rates(of.x, v).velocity.T.reshape(*self.shape, 3))

    @cached_property
    def motion(self) -> MotionDerivative:
        """How positions, velocities, accelerations and velocity ratios change."""
        change, of = self._change, self._of.motion
        ratios = change.ratios.reshape(*change.v.shape, len(of.drives))
        rates = change.v, change.a, VelocityRatios.of(ratios, None)
        turns = np.zeros_like(change.x)
        return MotionDerivative(Motion(of.mechanism, of.drives, change.x, turns, rates, self.shape))


def derivatives_of(of: Swept, names: Sequence[str]) -> list[Derivative]:
    """Return how the results of a sweep change with numbers, see `Sweep.derivative`."""
    problem, motion = of.problem, of.motion
    acting = of.acting.flat(motion.shape)
    solver = ProblemSolver(problem).of_varied(of.varied)
    rates = motion.v.reshape(len(motion.x), -1)
    x, v = np.nan_to_num(motion.x), np.nan_to_num(rates)
    parameters = [_parameter(of, name) for name in names]
    count, drives = len(x), len(problem.independent)
    inputs = Inputs(
        positions=np.zeros((count, drives)),
        speeds=acting.speeds,
        accelerations=acting.accelerations,
        held=problem.held_row,
        loads=problem.load_rows(acting.joint_loads),
        link_loads=acting.link_loads,
        gravity=acting.gravity,
        inertia=acting.inertia,
        turns=motion.turns,
        time=acting.time,
        has_rates=True,
    )
    with np.errstate(all="ignore"):
        changes = changes_of(solver.taped, x, v, inputs, parameters)
    unsolved = np.isnan(motion.x), np.isnan(rates), np.isnan(rates)
    found = []
    for name, change in zip(names, changes, strict=True):
        for values, missing in zip(change[:3], unsolved, strict=True):
            values[missing] = np.nan
        result = Derivative(name, of, change)
        fastest = np.nanmax(np.abs(change.x * problem.mechanism.coordinates.scale), initial=1.0)
        if result.loop_residual > np.sqrt(EPS) * fastest:
            raise ModelError(
                f"{name}: no derivative exists, since a change of it opens a loop that closes "
                "only as long as its axes meet or are parallel; differentiate by something that "
                "keeps them so"
            )
        found.append(result)
    return found


def _parameter(swept: Swept, name: object) -> Parameter:
    """Return what a name says.

    Raises:
        ArgumentError: it says nothing.
        ModelError: no such joint, link or element.
    """
    if not isinstance(name, str):
        raise ArgumentError(f"parameters are named: {_FORMS}")
    problem, (kind, colon, of) = swept.problem, name.partition(":")
    drives, rates = problem.independent, problem.mechanism.model.nv
    prescribed = (*drives, *problem.held)
    first_effort = 2 * len(drives) + 3
    if name in prescribed:
        return OfColumn(name, problem.mechanism.coordinates.columns_of([name])[0])
    if not colon:
        if match := re.fullmatch(r"gravity\.([xyz])", name):
            return OfRow(name, 2 * len(drives) + _AXES.index(match[1]))
        raise ModelError(
            f"{name!r} is nothing that the scene drives or holds: {choices(prescribed, name)}; "
            f"a parameter is {_FORMS}",
            name=name,
        )
    if kind in ("speed", "acceleration"):
        if of not in drives:
            raise ModelError(f"{name!r}: drives are {choices(drives, of)}", name=of)
        return OfRow(name, drives.index(of) + len(drives) * (kind == "acceleration"))
    if kind == "load":
        named = problem.mechanism.coordinates.named
        if of in named:
            return OfRow(name, first_effort + named[of].rate)
        link, _, component = of.rpartition(".")
        loads = [key for key, load in swept.acting.link_loads.items() if load.body >= 0]
        match = re.fullmatch(r"(force|moment)_([xyz])", component)
        if link in loads and match:
            number = 6 * loads.index(link) + 3 * (match[1] == "moment") + _AXES.index(match[2])
            return OfRow(name, first_effort + rates + number)
        raise ModelError(
            f"{name!r}: name a joint, {choices(named, of)}, or a component of a link that has a "
            f"load in the sweep, such as 'load:LINK.force_x'; these links are {choices(loads)}",
            name=of,
        )
    if kind in ("mass", "centre", "inertia"):
        return _of_mass(problem, name, kind, of)
    if kind == "origin":
        return _of_origin(problem, name)
    if kind in ("stiffness", "damping"):
        return _of_element(problem, name, kind, of)
    raise ArgumentError(f"{name!r} says no parameter; one is {_FORMS}")


def _of_mass(problem: Problem, name: str, kind: str, of: str) -> OfMass:
    """Return mass, centre or inertia of a link; arguments and errors as of `_parameter`."""
    link, _, component = (of, "", "") if kind == "mass" else of.rpartition(".")
    wanted = {"mass": r"", "centre": r"[xyz]", "inertia": r"[xyz]{2}"}[kind]
    if not re.fullmatch(wanted, component):
        raise ArgumentError(f"{name!r} says no parameter; one is {_FORMS}")
    body, frame = problem.mechanism.link(link)
    described = next(item for item in problem.mechanism.description.links if item.name == link)
    at = frame.act(np.asarray(described.centre))
    return OfMass(name, link, body - 1, partial(_added_mass, kind, component, frame, described, at))


def _added_mass(
    kind: str,
    component: str,
    frame: SE3,
    link: LinkDescription,
    centre: Array,
    change: Scalar,
    length: float,
) -> tuple[Mass, ...]:
    """Return the masses that a change of a link by some amount adds to its body.

    Args:
        kind: `mass`, `centre` or `inertia`.
        component: of the centre, or of the inertia.
        frame: of the link in its body.
        link: as it is described.
        centre: of its mass in the body [m].
        change: by how much.
        length: unit of what is returned [m].
    """
    at, nothing = tuple((centre / length).tolist()), ((0.0, 0.0, 0.0),) * 3
    if kind == "mass":
        return (Mass(change, at, nothing, ""),)
    if kind == "centre":
        way = frame.rotation[:, _AXES.index(component)] / length
        moved = tuple(c + change * w for c, w in zip(at, way.tolist(), strict=True))
        return Mass(link.mass, moved, nothing, ""), Mass(-link.mass, at, nothing, "")
    unit = np.zeros((3, 3))
    row, column = map(_AXES.index, component)
    unit[row, column] = unit[column, row] = 1.0 / length**2
    turned = frame.rotation @ unit @ frame.rotation.T
    return (Mass(0.0, at, tuple(tuple(change * x for x in r) for r in turned.tolist()), ""),)


def _of_element(problem: Problem, name: str, kind: str, of: str) -> OfElement:
    """Return a number of an element; arguments and errors as of `_parameter`."""
    known = [item.name or f"elements[{k}]" for k, item in enumerate(problem.elements)]
    if of not in known:
        raise ModelError(f"{name!r}: elements are {choices(known, of)}", name=of)
    index = known.index(of)
    element = problem.elements[index]
    value = getattr(element, kind, None)
    if not isinstance(value, float):
        raise ModelError(f"{name!r}: the {kind} of {of} is no number", name=of)
    # What acts is linear in it: any difference is exact.
    ends = (1.5 * value, 0.5 * value) if value else (1.0, 0.0)
    more, less = (replace(cast("Any", element), **{kind: end}) for end in ends)
    return OfElement(name, index, (more, less), ends[0] - ends[1])


def _of_origin(problem: Problem, name: str) -> OfOrigin:
    """Return a length or an angle of a placement; arguments and errors as of `_parameter`."""
    mechanism = problem.mechanism
    description = mechanism.description
    plain = without_origins(description)
    origin = origin_of(plain, name)

    def displaced(by: float) -> Mechanism:
        changed = with_origins(origin.displaced(plain, by), description.origins)
        return Mechanism(changed, mechanism.base, mechanism.coordinates.cardan)

    if origin.turns:
        return OfOrigin.of_angle(name, displaced)
    return OfOrigin.of_length(name, displaced, mechanism.characteristic_length)
