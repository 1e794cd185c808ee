"""Derivative: how the results of a sweep change with a number that was given, sample by sample."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...kit.arrays import EPS, Array
from ...kit.checks import mapping, numbers, vector
from ...kit.errors import ArgumentError, ModelError, choices
from ...kit.frozen import Frozen, frozen, read_only
from ..description.origins import PREFIX
from ..dynamics.differentiated import Change, Differentiated, changes_of
from ..dynamics.inverse_dynamics import Inputs
from ..dynamics.parameters import Parameter
from ..dynamics.problem_solver import (
    AssembledPositions,
    ProblemSolver,
    Work,
    refuse_beyond_memory,
)
from ..dynamics.velocity_ratios import VelocityRatios
from ..elements.link_loads import WRENCH_COMPONENTS
from ..mechanism.carried import CarriedFrame
from ..problem.acting import Acting
from ..problem.problem import Problem
from ..proof.residuals import overflow
from .motion import Motion, Rates
from .named_parameters import parameters_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


class Swept(NamedTuple):
    """What of a sweep its derivatives follow from.

    Attributes:
        solver: of the scene; for other positions of held coordinates where these vary.
        acting: how fast the drives move, and what acts.
        motion: of all samples.
        unique: `(k, 6)` see `JointWrench.unique`, a row per output.
        coupling_unique: coupling to whether its moment is unique.
        shared: driven and held coordinates whose efforts depend on how others share theirs.
    """

    solver: ProblemSolver
    acting: Acting
    motion: Motion
    unique: Array
    coupling_unique: Mapping[str, bool]
    shared: Collection[str] = ()

    @property
    def problem(self) -> Problem:
        """That of the scene."""
        return self.solver.problem

    def parameters(self, names: Sequence[object]) -> dict[str, Parameter]:
        """Return the parameters of names and of patterns; errors as of `parameters_of`."""
        own = tuple(name for name in names if isinstance(name, str))
        if len(own) < len(names):
            raise ArgumentError("parameters are named by strings, such as 'mass:LINK'")
        return self.solver.parameters.of(
            "parameters",
            (own, *self.acting.link_loads),
            lambda: parameters_of(self.problem, self.acting, own),
        )

    @property
    def differentiated(self) -> Differentiated:
        """All samples; those whose motion is not solved stand somewhere."""
        problem, motion = self.problem, self.motion
        acting = self.acting.flat(motion.shape)
        count = len(motion.x)
        inputs = Inputs(
            positions=np.zeros((count, len(problem.independent))),
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
        # Rates may have to be found first.
        v = motion.v.reshape(count, -1) if problem.elements else np.zeros((count, 0))
        x, v = (np.where(np.isnan(values), 0.0, values) for values in (motion.x, v))
        return Differentiated(self.solver, x, v, inputs)


class WrenchDerivative(NamedTuple):
    """How the wrench of a joint changes, in the joint's own axes.

    Components that do not follow from the laws of motion alone are NaN, and so are those that no
    longer do where the number is another: self-stress turns into them.

    Attributes:
        force: `(…, 3)` [N per unit].
        moment: `(…, 3)` [N·m per unit].
        unique: `(6,)` which components are not NaN.
    """

    force: Array
    moment: Array
    unique: Array


class MotionDerivative(NamedTuple):
    """How the motion of joints changes.

    Attributes:
        changes: positions and rates, which hold derivatives.
        ratios: a motion whose velocity ratios do, which are found where they are read.
    """

    changes: Motion
    ratios: Motion

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
        return self.ratios.ratio(joint, drive)


class Derivative(Frozen):
    """How the results of a sweep change with a number, per its unit; all else that is given stays.

    It is read like the sweep. Derivatives are exact: the equations themselves are differentiated.
    At places where a result has a kink, they are those of one of its sides. Sizes, such as bending
    moments, are no components: differentiate them by hand, where they are not zero.

    Attributes:
        parameter: the number, as it was named.
    """

    parameter: str
    _of: Swept
    _change: Change

    def __init__(self, parameter: str, of: Swept, change: Change) -> None:
        self._freeze(parameter=parameter, _of=of, _change=change)

    def __repr__(self) -> str:
        return f"<Derivative by {self.parameter!r}: {len(self._of.motion.x)} samples>"

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the samples."""
        return self._of.motion.shape

    @property
    def loop_residual(self) -> float:
        """Greatest rate at which loops, couplings, drives and held joints get away from positions.

        It is of angles [rad per unit], or of gaps as fractions of the characteristic length.
        Residuals are computed when they are read, in some hundredths of a second, by the text of
        the proof, which shares with how derivatives are found no more than what `origin` means.
        """
        return self._residuals[0]

    @property
    def balance_residual(self) -> float:
        """Greatest rate at which bodies get out of balance, relative to what keeps them there.

        That is the rate of wrenches and efforts. To it counts how fast they turn with joints, and,
        of numbers of the description, the greatest of them for a change by about all there is.
        Where elements act, it is some 1e-11 by which differences are off. NaN where nothing
        changes, or no balance is known.
        """
        return self._residuals[1]

    @cached_property
    def _residuals(self) -> tuple[float, float]:
        with np.errstate(all="ignore"):
            return self._of.differentiated.residuals(self._parameter, self._change)

    def __getitem__(self, joint: str) -> WrenchDerivative:
        """Return how the wrench of an output changes.

        Raises:
            ModelError: it is no output.
        """
        names = [f"{joint}.{kind}" for kind in ("force", "moment")]
        force, moment = map(self._read, names)
        unique = np.concatenate([self._unique(_rows_of(self._of, name)) for name in names])
        return WrenchDerivative(force, moment, read_only(unique))

    @cached_property
    def drive_effort(self) -> Array:
        """That of `Sweep.drive_effort`; NaN of drives that share it with other actuated joints.

        Raises:
            ModelError: the outputs of the scene leave it out.
        """
        return self._read("drive_effort")

    @cached_property
    def holding_effort(self) -> Mapping[str, Array]:
        """Held joint or coordinate to the derivative of what holds it."""
        names = self._of.solver.known_holding_efforts
        return frozen({name: self._read(f"{name}.holding_effort") for name in names})

    @cached_property
    def coupling_moment(self) -> Mapping[str, Array]:
        """Coupling to the derivative of its moment; NaN where that is not unique."""
        return frozen(
            {name: self._read(f"{name}.coupling_moment") for name in self._of.coupling_unique}
        )

    def _read(self, name: str) -> Array:
        """Return the derivative of a result by its name; errors as of `_rows_of`."""
        rows = _rows_of(self._of, name)
        values = self._change.of(rows.field, rows.columns)
        values[:, ~self._unique(rows)] = np.nan
        return read_only(values.reshape(*self.shape, *rows.shape))

    def _unique(self, rows: _Rows) -> Array:
        """Return which columns of a result are unique, and change uniquely."""
        return np.asarray(rows.flags & ~self._change.picks(rows.field, rows.columns))

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
        v = of.mechanism.coordinates.velocity(of.x, self._change.of("x"))
        return read_only(carrier.rates(of.x, v).velocity.T.reshape(*self.shape, 3))

    @cached_property
    def motion(self) -> MotionDerivative:
        """How positions, velocities, accelerations and velocity ratios change."""
        change, of = self._change, self._of.motion
        x, v, a = map(change.of, ("x", "v", "a"))
        x[np.isnan(of.x)] = np.nan
        v[np.isnan(of.v.reshape(v.shape))] = np.nan
        a[np.isnan(of.a.reshape(a.shape))] = np.nan
        dense = *v.shape, len(of.drives)

        def changes(rates: Rates | Callable[[], Rates]) -> Motion:
            return Motion(of.mechanism, of.drives, x, np.zeros_like(x), rates, self.shape)

        def ratios() -> Rates:
            with np.errstate(all="ignore"):
                found = self._of.differentiated.ratios(self._parameter)
            return v, a, VelocityRatios.of(found.reshape(dense))

        known = v, a, VelocityRatios.of(np.full(dense, np.nan))
        return MotionDerivative(changes(known), changes(ratios))

    @property
    def _parameter(self) -> Parameter:
        return self._of.parameters([self.parameter])[self.parameter]


class _Rows(NamedTuple):
    """Where a result stands among what is found.

    Attributes:
        field: of `Found`.
        columns: of it.
        shape: of the result at a sample.
        unique: for each column, whether it follows from the laws of motion alone; all if None.
    """

    field: str
    columns: Sequence[int]
    shape: tuple[int, ...] = ()
    unique: Sequence[bool] | None = None

    @property
    def flags(self) -> Array:
        """`unique`, of all columns."""
        return np.array(self.unique or [True] * len(self.columns))


def _rows_of(of: Swept, name: str) -> _Rows:
    """Return where a result stands, by its name as in the tables of a sweep.

    Raises:
        ArgumentError: it says no result.
        ModelError: no such joint, coordinate or coupling, or the outputs leave it out.
    """
    problem, coordinates = of.problem, of.problem.mechanism.coordinates
    joint, _, kind = name.rpartition(".")
    if kind == "drive_effort":
        drives = problem.independent
        if not of.solver.knows_drive_efforts:
            raise ModelError("the drive effort was not asked for; add the driven joint to outputs")
        if joint and joint not in drives:
            raise ModelError(f"{name!r}: drives are {choices(drives, joint)}", name=joint)
        names = [joint] if joint else drives
        own, unique = coordinates.rates_of(names), [name not in of.shared for name in names]
        return _Rows("efforts", own, () if len(own) == 1 else (len(own),), unique)
    if kind == "holding_effort":
        known = of.solver.known_holding_efforts
        if joint not in known:
            raise ModelError(f"{name!r}: known are those of {choices(known, joint)}", name=joint)
        return _Rows("efforts", coordinates.rates_of([joint]), unique=[joint not in of.shared])
    if kind == "coupling_moment":
        if joint not in of.coupling_unique:
            told = choices(of.coupling_unique, joint)
            raise ModelError(f"{name!r}: couplings are {told}", name=joint)
        names = [item.name for item in problem.mechanism.couplings]
        return _Rows("couplings", [names.index(joint)], unique=[of.coupling_unique[joint]])
    if kind in _OF_MOTION:
        x, v = of.motion.spans(joint)
        span = x if kind == "position" else v
        moved = range(span.start, span.stop)
        return _Rows(_OF_MOTION[kind], moved, () if len(moved) == 1 else (len(moved),))
    if kind not in _OF_WRENCH:
        raise ArgumentError(
            f"{name!r} says no result; one is 'drive_effort', 'JOINT.force' or '.moment' (a "
            "component is '.force_x'), 'JOINT.position', '.velocity', '.acceleration', "
            "'JOINT.holding_effort' or 'COUPLING.coupling_moment'"
        )
    if joint not in problem.outputs:
        raise ModelError(f"no output {joint!r}; outputs: {choices(problem.outputs, joint)}")
    output, parts = problem.outputs.index(joint), _OF_WRENCH[kind]
    first = 6 * int(np.arange(problem.mechanism.wrench_count)[problem.output_indices][output])
    columns, shape = [first + part for part in parts], (len(parts),) if len(parts) > 1 else ()
    return _Rows("wrenches", columns, shape, of.unique[output, parts].tolist())


_OF_MOTION = {"position": "x", "velocity": "v", "acceleration": "a"}
_OF_WRENCH = {"force": [0, 1, 2], "moment": [3, 4, 5]} | {
    name.replace(" ", "_"): [index] for index, name in enumerate(WRENCH_COMPONENTS)
}
"""Results to the components of a wrench that they are."""


def derivatives_of(of: Swept, names: Sequence[str]) -> dict[str, Derivative]:
    """Return derivatives by some numbers, see `Sweep.derivative`."""
    parameters = of.parameters(names)
    refuse_beyond_memory(
        len(of.motion.x),
        len(parameters) * (3 * of.problem.mechanism.model.nv + 6 * len(of.problem.outputs)),
        "; name fewer parameters, take fewer samples, or weigh results by Sweep.gradient",
    )
    with np.errstate(all="ignore"):
        changes = of.differentiated.changes([*parameters.values()])
    found = {}
    for name, change in zip(parameters, changes, strict=True):
        if not _refused(name, change.opened, change.farthest, name in names):
            found[name] = Derivative(name, of, change)
    return found


def slopes_of(
    of: Swept, weights: Mapping[str, ArrayLike], names: Sequence[str]
) -> Mapping[str, float]:
    """Return derivatives of a weighted sum, see `Sweep.gradient`."""
    parameters = of.parameters(names)
    rows: dict[int, Array] = {}
    samples = of.differentiated
    for field, column, own in weighed(of, weights):
        row = samples.row(field, column)
        rows[row] = rows.get(row, 0.0) + own
    with np.errstate(all="ignore"):
        slopes, opened = samples.slopes([*parameters.values()], rows)
    each = zip(parameters, slopes.tolist(), opened.tolist(), strict=True)
    found = {
        name: slope for name, slope, rate in each if not _refused(name, rate, 1.0, name in names)
    }
    for name in samples.picking([parameters[name] for name in found], rows):
        refuse_turned(name, name in names)
        del found[name]
    return frozen(found)


def refuse_turned(name: str, is_asked: bool) -> None:
    """Refuse the derivative of a sum by a parameter if self-stress turns into what is weighted.

    Args:
        name: of the parameter.
        is_asked: whether it was asked for by its name.

    Raises:
        ModelError: it was.
    """
    if is_asked:
        raise ModelError(
            f"{name}: how a weighted component changes with it does not follow from the laws of "
            f"motion alone: leave out what is NaN in derivative({name!r})",
            name=name,
        )


def weighed(of: Swept, weights: Mapping[str, ArrayLike]) -> Iterator[tuple[str, int, Array]]:
    """Yield fields of `Found`, columns of them and the weights `(N,)` of these.

    Raises:
        ArgumentError, ModelError: see `Sweep.gradient`.
    """
    for name, given in mapping("weights", weights).items():
        told = _rows_of(of, name)
        shape, values = (*of.motion.shape, *told.shape), numbers(f"weights[{name!r}]", given)
        try:
            values = np.broadcast_to(values, shape)
        except ValueError as error:
            raise ArgumentError(
                f"weights[{name!r}] have the shape {values.shape}, which does not broadcast with "
                f"{shape}, that of the result"
            ) from error
        for column, own, unique in zip(
            told.columns, values.reshape(-1, len(told.columns)).T, told.flags, strict=True
        ):
            if not own.any():
                continue
            if not unique:
                raise ModelError(
                    f"weights[{name!r}] are of a component that does not follow from the laws of "
                    "motion alone: leave it out, see `unique`",
                    name=name,
                )
            yield told.field, column, own


def efforts_by(
    solver: ProblemSolver, assembled: AssembledPositions, acting: Acting, names: Sequence[str]
) -> tuple[Array, Array]:
    """Return efforts of the drives `(N, d)`, and their derivatives by numbers `(N, d, k)`.

    They are not proven, which a sweep does, and take a part of its time.

    Args:
        solver: of the scene.
        assembled: N samples of it.
        acting: how fast the drives move and what acts.
        names: of the numbers.

    Raises:
        CardanError: as `Sweep.derivative`.
    """
    drives = solver.assembly.kinematics.drives
    parameters = solver.parameters.of(
        "parameters",
        (tuple(names), *acting.link_loads),
        lambda: parameters_of(solver.problem, acting, names),
    )
    work, efforts, slopes = Work(solver, assembled, acting), [], []
    for index in range(len(assembled.spans)):
        x, given, close = work.given(index)
        found = solver.taped.found(x, given, close)[0]
        with np.errstate(all="ignore"):
            samples = Differentiated(solver, found.x, found.v, given)
            changes = samples.changes([*parameters.values()])
        for name, change in zip(parameters, changes, strict=True):
            _refused(name, change.opened, change.farthest, is_asked=True)
        efforts.append(found.efforts[:, drives])
        slopes.append(changes_of(changes, "efforts", drives))
    return np.concatenate(efforts), np.concatenate(slopes)


_OPEN = math.sqrt(EPS)
"""Rate of closure errors, beside that of coordinates, above which a loop opens."""


def _refused(name: str, opened: float, farthest: float, is_asked: bool) -> bool:
    """Return whether a derivative does not exist, since a loop opens.

    Args:
        name: of the parameter.
        opened: greatest rate at which closure errors grow, in units of the mechanism.
        farthest: greatest rate of coordinates, likewise.
        is_asked: whether it was asked for by its name.

    Raises:
        ModelError: it was.
        AccuracyError: rates are no numbers.
    """
    if not math.isfinite(opened + farthest):
        raise overflow(f"the derivative by {name!r}")
    if opened <= _OPEN * max(1.0, farthest):
        return False
    if is_asked:
        raise ModelError(
            f"{name}: no derivative exists, since a change of it opens a loop that closes "
            "only as long as its axes meet or are parallel; differentiate by something that "
            "keeps them so"
        )
    return True
