"""Linear model: state space of small deviations from an equilibrium or a motion."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from fnmatch import fnmatchcase
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from ..core.description.origins import PREFIX
from ..core.dynamics.problem_solver import ProblemSolver
from ..core.mechanism.carried import CarriedFrame
from ..core.results.derivative import Derivative
from ..core.results.jacobian import jacobian_at, rate_at, unit_motions
from ..core.results.sweep import Sweep
from ..kit.arrays import EPS, ROUNDED, Array
from ..kit.checks import described, mapping, names, vector
from ..kit.errors import (
    ArgumentError,
    IndeterminateError,
    MissingExtraError,
    ModelError,
    choices,
)
from ..kit.frozen import Record
from ..motion.simulation.equilibrium import Equilibrium
from ..motion.simulation.trajectory import Trajectory
from .task_sweep import TaskSweep

if TYPE_CHECKING:
    from numpy.typing import ArrayLike
    from scipy.signal import StateSpace

_SIGNALS = ("states", "inputs", "outputs")
_FORMS = (
    "a coordinate, 'JOINT.position' (velocity, acceleration), 'JOINT.force_x', 'JOINT.moment_x' "
    "(y, z), 'DRIVE.drive_effort', 'JOINT.holding_effort', 'COUPLING.coupling_moment', or "
    "'LINK.position_x', 'LINK.velocity_x' of a link or one of `points`"
)


@dataclass(frozen=True, eq=False, repr=False)
class LinearModel(Record):
    """What becomes of small deviations x from a motion: ẋ = A x + B u, y = C x + D u.

    Of an equilibrium, matrices have two axes; of a motion, its samples come first, and `model[k]`
    is that of a sample. Along a motion the matrices change with time, with its period if it has
    one: each is that of its instant.

    Attributes:
        A, B, C, D: `(..., 2f, 2f)`, `(..., 2f, m)`, `(..., p, 2f)`, `(..., p, m)` [SI units].
        mass, damping, stiffness: `(..., f, f)` of M δq̈ + C δq̇ + K δq = 0: damping with gyroscopic
            terms, stiffness with what weight, loads, speeds and accelerations add.
        states: deviations of the coordinates, `crank`, then of their speeds, `speed:crank`.
        inputs: names of u: deviations of what was given.
        outputs: names of y.
    """

    A: Array
    B: Array
    C: Array
    D: Array
    mass: Array
    damping: Array
    stiffness: Array
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    def __getitem__(self, sample: Any) -> LinearModel:
        """Return the model of some samples."""
        if self.A.ndim == 2:
            raise ArgumentError("the model is of one equilibrium: it has no samples")
        arrays = [item.name for item in fields(self) if item.type == "Array"]
        return replace(self, **{name: getattr(self, name)[sample] for name in arrays})

    def __repr__(self) -> str:
        shape = " × ".join(map(str, self.A.shape[:-2]))
        told = (f"{kind} {', '.join(getattr(self, kind))}" for kind in _SIGNALS)
        return f"<LinearModel: {f'{shape} samples; ' if shape else ''}{'; '.join(told)}>"

    def to_scipy(self) -> StateSpace:
        """Return it as a `scipy.signal.StateSpace`.

        Raises:
            ArgumentError: it has several samples.
        """
        from scipy.signal import StateSpace

        return StateSpace(*self._single())

    def to_control(self) -> Any:
        """Return it as a `control.StateSpace` of python-control, with names of signals.

        Points in names become underscores, which python-control wants.

        Raises:
            ArgumentError: it has several samples.
            MissingExtraError: python-control is not installed.
        """
        try:
            control = import_module("control")
        except ImportError as error:
            raise MissingExtraError("this needs python-control: pip install control") from error
        signals = {
            kind: [re.sub(r"\W", "_", name) for name in getattr(self, kind)] for kind in _SIGNALS
        }
        return control.ss(*self._single(), **signals)

    def _single(self) -> list[Array]:
        matrices = self.A, self.B, self.C, self.D
        if np.prod(self.A.shape[:-2], dtype=int) != 1:
            raise ArgumentError(
                f"{self.A.shape[:-2]} samples are as many models, of a motion whose equation "
                "changes with time: take one, model[k]; what becomes of small deviations over a "
                "period is cardan_dyn.vibration.floquet"
            )
        return [matrix.reshape(matrix.shape[-2:]) for matrix in matrices]


def linear_model(
    solver: ProblemSolver,
    at: object,
    inputs: Sequence[str] | None,
    outputs: Sequence[str] | None,
    points: Mapping[str, str | tuple[str, ArrayLike]] | None,
) -> LinearModel:
    """Return the linear model of a scene; see `Scene.linear`."""
    problem = solver.problem
    sweep = at.sweep if isinstance(at, (Equilibrium, Trajectory)) else at
    if isinstance(sweep, TaskSweep):
        sweep = sweep.of_machine
    states = problem.free or problem.drives
    if not isinstance(sweep, Sweep):
        raise ArgumentError(
            f"at is {described(at)}, expected an equilibrium, scene.equilibrium(near), a motion of "
            "all coordinates, scene.sweep(positions, speed=...), or a trajectory of scene.simulate"
        )
    other = [*sweep.mechanism.joints] != [*problem.mechanism.joints]
    if other or not set(states) <= set(sweep.coordinates):
        raise ArgumentError(
            f"at is {sweep!r} of {choices(sweep.coordinates)}, whereas the scene moves "
            f"{problem.mechanism.name!r} by {choices(problem.independent)}: take one of this scene"
        )
    rates, found = [f"speed:{name}" for name in states], [f"acceleration:{name}" for name in states]
    given = [f"load:{name}" for name in states] if inputs is None else names("inputs", inputs)
    for name in given:
        if name in (*states, *rates, *found):
            raise ArgumentError(
                f"{name!r} is found, and no input; what acts along it is 'load:{states[0]}' and "
                "the like"
            )
    by = sweep.derivative(*dict.fromkeys((*states, *rates, *found, *given)))
    assert isinstance(by, Mapping)
    # A pattern stands for all that it matches, but for what is found.
    others = [name for name in by if name not in (*states, *rates, *found)]
    given = tuple(
        every
        for name in given
        for every in ([name] if name in by else others)
        if name == every or fnmatchcase(every, name)
    )
    rows = [sweep.coordinates.index(name) for name in states]

    def efforts(of: Sequence[str]) -> Array:
        every = (np.reshape(by[name].drive_effort, (*sweep.shape, -1))[..., rows] for name in of)
        return _side_by_side(every, (*sweep.shape, len(rows)))

    mass, damping, stiffness = efforts(found), efforts(rates), efforts(states)
    _refuse_massless(sweep, states, mass)
    accelerations = -np.linalg.solve(
        mass, np.concatenate([stiffness, damping, efforts(given)], axis=-1)
    )
    to_state, to_input = np.split(accelerations, [2 * len(states)], axis=-1)
    wanted = states if outputs is None else names("outputs", outputs)
    reading = _Reading(solver, sweep, {} if points is None else mapping("points", points))
    readers = [reading.reader(name, states) for name in wanted]

    def read(of: Sequence[str]) -> Array:
        columns = ([reader(name, by[name]) for reader in readers] for name in of)
        every = (
            np.stack(column, -1) if column else np.zeros((*sweep.shape, 0)) for column in columns
        )
        return _side_by_side(every, (*sweep.shape, len(readers)))

    through = read(found)
    still, unit = np.zeros_like(mass), np.broadcast_to(np.eye(len(states)), mass.shape)
    model = LinearModel(
        A=np.concatenate([np.concatenate([still, unit], axis=-1), to_state], axis=-2),
        B=np.concatenate([np.zeros_like(to_input), to_input], axis=-2),
        C=read([*states, *rates]) + through @ to_state,
        D=read(given) + through @ to_input,
        mass=mass,
        damping=damping,
        stiffness=stiffness,
        states=(*states, *rates),
        inputs=tuple(given),
        outputs=tuple(wanted),
    )
    return model[0] if isinstance(at, Equilibrium) else model


def _side_by_side(columns: Any, shape: tuple[int, ...]) -> Array:
    """Return columns `(..., r)` as a matrix `(..., r, c)`, of that shape even if there are none."""
    every = list(columns)
    return np.stack(every, axis=-1) if every else np.zeros((*shape, 0))


def _refuse_massless(sweep: Sweep, states: Sequence[str], mass: Array) -> None:
    """Refuse directions in which nothing that has mass moves.

    Raises:
        ModelError: there is one.
    """
    mechanism = sweep.mechanism
    drivable, length = mechanism.drivable, mechanism.characteristic_length
    units = np.array([length if drivable[name].slides else 1.0 for name in states])
    values, ways = np.linalg.eigh(mass * units[:, None] * units)
    # What does not move at all moves by rounding.
    whole = sum(
        link.mass * length**2 + np.trace(link.inertia) for link in mechanism.description.links
    )
    whole += float(np.sum(mechanism.model.armature * mechanism.coordinates.rate_scale**2))
    if np.any(values[..., 0] <= np.maximum(ROUNDED * values[..., -1], EPS * whole)):
        lightest = np.abs(ways[..., 0]).reshape(-1, len(states)).max(axis=0)
        raise ModelError(
            f"nothing that has mass moves with {states[int(lightest.argmax())]!r}, so that no "
            "acceleration follows from what acts; give mass to what it moves, or hold it"
        )


class _Reading:
    """Reads outputs from derivatives of a sweep."""

    def __init__(self, solver: ProblemSolver, sweep: Sweep, points: Mapping[str, Any]) -> None:
        self._solver, self._sweep, self._points = solver, sweep, points

    def reader(self, name: str, states: Sequence[str]) -> Callable[[str, Derivative], Array]:
        """Return what takes the derivative `(...)` of an output from that by a parameter.

        Args:
            name: of the output.
            states: coordinates whose motion is found.

        Raises:
            ArgumentError: the name says no output.
            ModelError: no such joint or link, or the outputs of the scene leave it out.
            IndeterminateError: it is not unique.
        """
        mechanism = self._sweep.mechanism
        if name in mechanism.coordinates.named:
            return lambda _, by: by.motion.position(name)
        of, _, quantity = name.rpartition(".")
        if quantity in ("position", "velocity", "acceleration"):
            if of not in mechanism.coordinates.named:
                raise ModelError(
                    f"{name!r}: coordinates are {choices(mechanism.coordinates.named, of)}", name=of
                )
            return lambda _, by: getattr(by.motion, quantity)(of)
        kind, _, axis = quantity.rpartition("_")
        if kind in ("force", "moment") and axis in ("x", "y", "z"):
            component = "xyz".index(axis)
            flags = self._sweep[of].unique
            self._refuse_open(name, flags[component + 3 * (kind == "moment")])
            return lambda _, by: getattr(by[of], kind)[..., component]
        if kind in ("position", "velocity") and axis in ("x", "y", "z"):
            return self._of_point(name, of, "xyz".index(axis), kind == "velocity")
        if quantity == "drive_effort":
            others = [item for item in self._sweep.coordinates if item not in states]
            if of not in others:
                raise ArgumentError(
                    f"{name!r}: coordinates that move as given, whose efforts are found, are "
                    f"{choices(others, of) or 'none'}"
                )
            column = self._sweep.coordinates.index(of)
            return lambda _, by: np.reshape(by.drive_effort, (*self._sweep.shape, -1))[..., column]
        if quantity in ("holding_effort", "coupling_moment"):
            known = getattr(self._sweep, quantity)
            if of not in known:
                raise ModelError(f"{name!r}: there are {choices(known, of) or 'none'}", name=of)
            if quantity == "coupling_moment":
                self._refuse_open(name, self._sweep.coupling_unique[of])
            return lambda _, by: getattr(by, quantity)[of]
        raise ArgumentError(f"{name!r} says no output; one is {_FORMS}")

    def _refuse_open(self, name: str, is_unique: bool) -> None:
        if not is_unique:
            raise IndeterminateError(
                f"{name!r} does not follow from the laws of motion alone, and has no derivative"
            )

    def _of_point(
        self, name: str, of: str, axis: int, moves: bool
    ) -> Callable[[str, Derivative], Array]:
        """Return the reader of a point's position or velocity along a world axis."""
        sweep = self._sweep
        place = self._points.get(of, of)
        if isinstance(place, str):
            place = place, np.zeros(3)
        if not isinstance(place, (tuple, list)) or len(place) != 2:
            told = f"points[{of!r}] is {described(place)}"
            raise ArgumentError(f"{told}, expected a link or (link, (x, y, z))")
        link, xyz = place
        at = vector(f"points[{of!r}]", xyz, 3)
        carrier = CarriedFrame(sweep.mechanism, link, at)
        speeds = [f"speed:{name}" for name in sweep.coordinates]
        if not moves:
            return lambda _, by: by.point(link, at)[..., axis]
        jacobian = jacobian_at(sweep, carrier, unit_motions(sweep))
        own = ProblemSolver(sweep.problem, like=self._solver).complete.without_elements
        rate = rate_at(own, sweep, carrier, jacobian)

        def read(parameter: str, _: Derivative) -> Array:
            if parameter in sweep.coordinates:
                # The rate of a column is how the velocity changes with its coordinate.
                return np.asarray(rate[..., axis, sweep.coordinates.index(parameter)])
            if parameter in speeds:
                return np.asarray(jacobian[..., axis, speeds.index(parameter)])
            if parameter in sweep.held or parameter.startswith(PREFIX):
                raise ArgumentError(
                    f"{name!r} moves with {parameter!r}, of which its derivative is not known; "
                    "leave out one of both, or drive it"
                )
            return np.zeros(sweep.shape)

        return read
