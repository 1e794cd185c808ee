"""Simulate: choose a method for a scene, run it, and return its trajectory."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..checks import described, mapping, numbers
from ..dynamics.problem_solver import ProblemSolver
from ..errors import ArgumentError, CardanError, SimulationError, choices
from ..problem.arguments import split_loads
from .constrained_model import ConstrainedModel
from .energy_functions import NotSuitableError, energy_functions
from .energy_integral import EnergyIntegral
from .events import EventSearch, Happened, Watched, watched
from .forces import Forces, Named, StateFunction, state_function
from .integration import Integration
from .prescribed_motion import begun_at, prescribed_motions
from .progress import Progress
from .runs import ConstrainedRun, IntegratedLaw, OneCoordinateRun, Run
from .scalar_equation import ScalarEquation
from .start_state import closed_start, drive_positions
from .system import Motion, System
from .trajectory import Course, Trajectory

METHODS = ("quadrature", "response", "DOP853", "Radau")
"""Names of the methods, see `Scene.simulate`."""
_FINEST = 2.5e-14
"""Least relative tolerance: below, steps cannot be judged in rounding arithmetic."""
_SAMPLES_PER_PERIOD = 64
"""Times per turn or swing that a quadrature returns."""
_MOST_SAMPLES = 20_000
"""Greatest number of these times; `Trajectory.at` gives others."""


class Asked(NamedTuple):
    """What a simulation is asked for, unchecked; see `Scene.simulate`."""

    duration: Any
    position: Any = None
    speed: Any = None
    motion: Any = None
    loads: Any = None
    rtol: Any = 1e-10
    atol: Any = None
    method: Any = None
    events: Any = ()
    progress: Any = False
    step: Any = None


class Setup(NamedTuple):
    """A checked simulation.

    Attributes:
        solver: of the scene, all of whose loops it closes.
        duration: [s].
        motions: prescribed drives to how they move.
        x, turns, v: closed coordinates and velocities at the start.
        forces: what acts beside the weight.
        rtol, atol: tolerances of a step; atol for angles and lengths as fractions, or None.
        step: length of all steps [s]; None where the error decides.
        events: to be located.
        progress: shows how far it got.
    """

    solver: ProblemSolver
    duration: float
    motions: dict[str, Motion]
    x: Array
    turns: Array
    v: Array
    forces: Forces
    rtol: float
    atol: float
    step: float | None
    events: list[Watched]
    progress: Progress

    @property
    def is_one_coordinate(self) -> bool:
        """Whether one drive moves freely and the motion of no other is prescribed."""
        return len(self.solver.problem.drives) == 1 and not self.motions


def simulated(solver: ProblemSolver, asked: Asked) -> Trajectory:
    """Return a simulation; see `Scene.simulate`."""
    setup = _setup(_with_all_loops(solver), asked)
    method = asked.method
    if method is not None and method not in METHODS:
        raise ArgumentError(f"method {described(method)} is unknown; methods: {choices(METHODS)}")
    # Steps of a given length are those of the general method.
    for candidate in [method] if method else METHODS[2 if setup.step else 0 : 3]:
        try:
            _refuse_unsuitable(setup, candidate)
            return _RUNNERS[candidate](setup)
        except NotSuitableError as error:
            if method is not None:
                raise ArgumentError(f"method {method!r} does not suit the scene: {error}") from None
    raise AssertionError("the last candidate suits every scene")


def _refuse_unsuitable(setup: Setup, method: str) -> None:
    """Refuse a method that would leave out what is asked for.

    Raises:
        NotSuitableError: it would.
    """
    if method in METHODS[:2] and not setup.is_one_coordinate:
        raise NotSuitableError("it takes one drive that moves freely")
    if method == "quadrature" and not setup.forces.is_constant:
        raise NotSuitableError("it takes constant loads and springs without damping alone")
    if method in ("quadrature", "Radau") and setup.step is not None:
        raise NotSuitableError("it takes no steps of a given length")


def _with_all_loops(solver: ProblemSolver) -> ProblemSolver:
    """Return the solver that closes all loops, and keeps the outputs where they need all."""
    decided = set(solver.assembly.decided.tolist())
    if decided.issuperset(solver.problem.passive_columns.tolist()):
        return solver
    problem = solver.problem
    joints = tuple(problem.mechanism.joints)
    return ProblemSolver(replace(problem, outputs=joints, all_outputs=True))


def _setup(solver: ProblemSolver, asked: Asked) -> Setup:
    """Return a simulation after all its arguments were checked.

    Raises:
        ArgumentError, ModelError, AssemblyError, SingularConfigurationError: see `Scene.simulate`.
    """
    problem = solver.problem
    duration = _positive("duration", asked.duration)
    rtol = _positive("rtol", asked.rtol)
    if rtol < _FINEST:
        raise ArgumentError(f"rtol is {rtol:g}, below rounding; the least is {_FINEST:g}")
    if rtol >= 1.0:
        raise ArgumentError(f"rtol is {rtol:g}; expected a fraction, such as 1e-10")
    motions, starts = prescribed_motions(problem.drives, asked.motion, duration)
    positions = drive_positions(solver, asked.position, starts)
    motions = begun_at(motions, dict(zip(problem.drives, positions.tolist(), strict=True)))
    speeds = {name: motion(0.0)[1] for name, motion in motions.items()}
    begun = closed_start(solver, positions, asked.speed, speeds)
    return Setup(
        solver,
        duration,
        motions,
        begun._x[0].copy(),
        begun._turns[0].copy(),
        begun.v[0].copy(),
        _forces(solver, asked.loads),
        rtol,
        rtol if asked.atol is None else _positive("atol", asked.atol),
        None if asked.step is None else _positive("step", asked.step),
        watched(asked.events),
        Progress(asked.progress, duration),
    )


def _positive(label: str, value: Any) -> float:
    """Return a positive number.

    Raises:
        ArgumentError: it is none.
    """
    number = numbers(label, value)
    if number.ndim or not number > 0.0:
        raise ArgumentError(f"{label} is {described(value)}, expected a positive number")
    return float(number)


def _forces(solver: ProblemSolver, loads: Any) -> Forces:
    """Return what acts, with the loads of the simulation instead of those of the scene.

    Raises:
        ArgumentError, ModelError: see `Scene.simulate`.
    """
    problem = solver.problem
    functions: dict[str, StateFunction] = {}
    constant = {}
    for name, value in mapping("loads", loads).items():
        if callable(value):
            if name not in problem.mechanism.coordinates.named:
                problem.mechanism.link(name)
            functions[name] = state_function(f"loads[{name!r}]", value)
        else:
            constant[name] = value
    joints, links = split_loads(problem.mechanism, constant)
    joints, links = {**problem.joint_loads, **joints}, {**problem.link_loads, **links}
    for name, effort in joints.items():
        if np.size(effort) != 1:
            raise ArgumentError(
                f"loads[{name!r}] has shape {np.shape(effort)}; a simulation takes one value, or a "
                "function of time"
            )
    for name, load in links.items():
        if load.force.size != 3 or load.moment.size != 3:
            raise ArgumentError(f"loads[{name!r}]: a simulation takes one wrench, or a function")
    return Forces(problem.mechanism, joints, links, functions, problem.elements)


def _by_quadrature(setup: Setup) -> Trajectory:
    """Simulate one conservative free coordinate by its energy integral."""
    solver = setup.solver
    problem = solver.problem
    coordinate = problem.mechanism.coordinates.named[problem.drives[0]]
    position = setup.x[coordinate.column] + 2.0 * np.pi * setup.turns[coordinate.column]
    functions = energy_functions(solver, setup.forces)
    integral = EnergyIntegral(functions, float(position), float(setup.v[coordinate.rate]))
    count = 1 + _SAMPLES_PER_PERIOD
    if np.isfinite(integral.period):
        count += int(_SAMPLES_PER_PERIOD * setup.duration / integral.period)
    times = np.linspace(0.0, setup.duration, min(count, _MOST_SAMPLES))
    run = OneCoordinateRun(solver, times, integral.at)
    happened: list[Happened] = []
    reason = ""
    if setup.events:

        def reading(time: float) -> tuple[Named, Named]:
            rows = run.rows(np.array([time]))
            return forces_names(setup, rows.x[0] + 2.0 * np.pi * rows.turns[0], rows.v[0])

        search = EventSearch(setup.events, reading)
        for start, end in zip(times[:-1].tolist(), times[1:].tolist(), strict=True):
            stopped = search.step(start, end, reading)
            if stopped is not None:
                run.times = np.append(times[times < stopped], stopped)
                reason = f"event {search.happened[-1].name!r}"
                break
        happened = search.happened
    setup.progress.show(float(run.times[-1]))
    setup.progress.close()
    return _trajectory(setup, run, "quadrature", reason, happened)


def forces_names(setup: Setup, x: Array, v: Array) -> tuple[Named, Named]:
    """Return positions and speeds by name."""
    names = setup.forces.names
    return names.positions(x), names.speeds(v)


def _by_response(setup: Setup) -> Trajectory:
    """Simulate one free coordinate by its scalar equation."""
    solver, problem = setup.solver, setup.solver.problem
    coordinate = problem.mechanism.coordinates.named[problem.drives[0]]
    functions = energy_functions(solver)
    equation = ScalarEquation(solver, functions, setup.forces, _model(setup))
    position = setup.x[coordinate.column] + 2.0 * np.pi * setup.turns[coordinate.column]
    y = np.array([position, setup.v[coordinate.rate]])
    atol = setup.atol * np.array([1.0, abs(y[1]) or 1.0])
    integration = Integration(
        equation, y, setup.duration, rtol=setup.rtol, atol=atol, step=setup.step
    )

    def run() -> Run:
        times = np.array([point.time for point in integration.points])
        return OneCoordinateRun(solver, times, IntegratedLaw(integration))

    return _integrated(setup, integration, equation.named, run, "response")


def _in_all_coordinates(setup: Setup, method: str) -> Trajectory:
    """Simulate by constrained dynamics in all coordinates."""
    system = System(_model(setup), setup.forces, setup.motions)
    system.turns = setup.turns.copy()
    length = setup.solver.problem.mechanism.characteristic_length
    scale = np.ones(setup.x.size)
    scale[np.nonzero(setup.solver.problem.mechanism.coordinates.scale != 1.0)[0]] = length
    rates = np.max(np.abs(setup.v), initial=0.0) or 1.0
    atol = setup.atol * np.concatenate([scale, np.full(setup.v.size, rates)])
    integration = Integration(
        system,
        np.concatenate([setup.x, setup.v]),
        setup.duration,
        method=method,
        rtol=setup.rtol,
        atol=atol,
        step=setup.step,
    )
    return _integrated(
        setup,
        integration,
        system.named,
        lambda: ConstrainedRun(setup.solver, integration),
        method,
    )


def _model(setup: Setup) -> ConstrainedModel:
    problem = setup.solver.problem
    rates = problem.mechanism.coordinates.rates_of((*setup.motions, *problem.held))
    return ConstrainedModel(problem.mechanism, rates, problem.gravity, setup.x)


def _integrated(
    setup: Setup,
    integration: Integration,
    named: Callable[[Array, Array], tuple[Named, Named]],
    run: Callable[[], Run],
    method: str,
) -> Trajectory:
    """Integrate to the end, to an event, or to where it fails.

    Raises:
        SimulationError: it failed; with the trajectory up to there.
    """
    start = integration.points[0]
    search = EventSearch(setup.events, lambda _: named(start.y, start.turns))
    reason, failure = "", None
    try:
        while integration.is_running:
            failure = integration.advance()
            if failure is not None:
                break
            setup.progress.show(integration.time)
            segment = integration.segments[-1]

            def reading(time: float, segment: Any = segment) -> tuple[Named, Named]:
                return named(integration.row_on(segment, time), segment.turns)

            stopped = search.step(segment.start, segment.end, reading) if setup.events else None
            if stopped is not None:
                integration.cut(integration.on(segment, stopped))
                reason = f"event {search.happened[-1].name!r}"
    except KeyboardInterrupt:
        reason = "interrupted"
    except CardanError as error:
        failure = str(error)
    finally:
        setup.progress.close()
    notes = []
    if integration.stiff_from is not None:
        notes.append(f"stiff from {integration.stiff_from:g} s on, where Radau took over")
        method += ", then Radau"
    course = method, failure or reason, search.happened, notes, integration.evaluations
    trajectory = _trajectory(setup, run(), *course)
    if failure is not None:
        raise SimulationError(
            f"the simulation ended at {integration.time:.6g} s of {setup.duration:g} s: {failure}",
            trajectory=trajectory,
            time=integration.time,
        )
    return trajectory


def _trajectory(
    setup: Setup,
    run: Run,
    method: str,
    reason: str,
    happened: list[Happened],
    notes: list[str] | None = None,
    evaluations: int = 0,
) -> Trajectory:
    course = Course(
        method, reason, tuple(happened), tuple(notes or ()), tuple(setup.motions), evaluations
    )
    return Trajectory(setup.solver, run, setup.forces, course, run.times)


_RUNNERS: Mapping[str, Callable[[Setup], Trajectory]] = {
    "quadrature": _by_quadrature,
    "response": _by_response,
    "DOP853": lambda setup: _in_all_coordinates(setup, "DOP853"),
    "Radau": lambda setup: _in_all_coordinates(setup, "Radau"),
}
