"""Methods: how simulations are run, each from a checked setup to a trajectory."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from ...kit.arrays import NOTHING, Array
from ...kit.errors import CardanError, SimulationError
from .constrained_model import UNBOUNDED, ConstrainedModel
from .contact_following import ContactFollowing
from .continuity import MOST_STATES
from .crossings import Crossings, notes_of_rounding, refuse_rounding
from .energy_functions import energy_functions
from .energy_integral import EnergyIntegral
from .events import EventSearch, Happened
from .forces import State
from .free_balls import NEARLY, WithBalls, with_free_balls
from .integration import Equations, Integration
from .progress import INTERRUPTED
from .runs import ConstrainedRun, IntegratedLaw, OneCoordinateRun, Run
from .scalar_equation import ScalarEquation
from .setup import Setup, refuse_distances
from .stiffness import Stiffness, judged
from .system import System
from .trajectory import PER_PERIOD, Course, Trajectory


def by_quadrature(setup: Setup) -> Trajectory:
    """Simulate one conservative free coordinate by its energy integral."""
    functions = energy_functions(setup.solver, setup.forces)
    integral = EnergyIntegral(functions, *setup.drive_start)
    refuse_distances(integral.fastest, setup.duration, integral.reach)
    count = 1 + PER_PERIOD
    if np.isfinite(integral.period):
        count += int(PER_PERIOD * setup.duration / integral.period)
    times = np.linspace(0.0, setup.duration, min(count, MOST_STATES))
    run = OneCoordinateRun(setup.solver, times, integral)
    search, ended, reason = _searched(setup, run)
    setup.progress.close()
    if ended < setup.duration:
        run.times = np.append(times[times < ended], ended)
    notes = *setup.notes, *_doubt(integral, ended), *search.notes
    happened = tuple(search.happened)
    course = Course(setup, run, setup.start, "quadrature", reason, happened, notes)
    return Trajectory(course, run.times)


def _doubt(integral: EnergyIntegral, duration: float) -> list[str]:
    """Return what rounding leaves open of a quadrature, in words."""
    if np.isinf(integral.doubt):
        return ["rests in an unstable equilibrium, which it would leave at any push"]
    late = float(integral.late(np.array([duration]))[0])
    if late * integral.fastest < NOTHING:
        return []
    what = f"of {duration / integral.period:.2g} periods, what rounding leaves open adds up"
    if integral.doubt * integral.fastest >= NOTHING:
        what = (
            "close to an unstable equilibrium, where rounding of inertia and forces decides how "
            "long it stays"
        )
    return [
        f"{what}: what follows may be early or late by {late:.1e} s, or off by "
        f"{late * integral.fastest:.1e} rad"
    ]


def _lingering(setup: Setup, run: Run) -> list[str]:
    """Return what steps leave open of a motion that lingers at an unstable equilibrium, in words.

    There errors grow as the motion away from it does.
    """
    problem, times = setup.solver.problem, run.times
    drives = problem.independent
    is_told = setup.motions or setup.forces.has_functions or setup.contacts
    if len(drives) > 1 or is_told or len(times) < 2:
        return []
    alone = run.drives_alone(times)
    (own,) = problem.mechanism.coordinates.rates_of(drives)
    speeds = run.rows(times).v[:, own] if alone is None else alone.v[:, 0]
    accelerations = np.gradient(speeds, times)
    # What never moves, or never gains speed, has no rate, and does not grow.
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = np.max(np.abs(accelerations)) / np.max(np.abs(speeds))
        # Zero where it rests: distance from all equilibria, in rad/s.
        distance = np.hypot(speeds, accelerations / rate)
        later = np.maximum.accumulate(distance[::-1])[::-1]
        # Damping may bring it to rest where nothing grows any more.
        earlier = np.maximum.accumulate(distance) if setup.forces.is_constant else later
        fastest = np.maximum(earlier, later)
        swings = fastest / rate
        growth = np.nan_to_num((fastest / distance) * (later / distance), nan=0.0)
    worst = int(np.argmax(growth))
    # It is told where half of the digits that were asked for are lost, of a swing or of a radian.
    off = setup.rtol * float(growth[worst]) * min(float(swings[worst]), 1.0)
    if not off > setup.rtol**0.5:
        return []
    size = f"be off by {off:.0e} rad" if off < 1.0 else "be any other motion"
    return [
        f"lingers near an unstable equilibrium at {times[worst]:.6g} s, where errors of steps grow "
        f"about {growth[worst]:.0e}-fold: what follows may {size}; give a "
        "smaller rtol"
    ]


def _searched(setup: Setup, run: Run) -> tuple[EventSearch, float, str]:
    """Return events of a run, and when and why they or an interruption ended it, if they did."""
    names = setup.forces.names
    count = max(4 * int(np.ceil(setup.duration / run.period)), 4) if setup.events else 1

    def reading(times: list[float]) -> list[State]:
        rows = run.rows(np.array(times))
        states = zip(rows.counted, rows.v, strict=True)
        return [names.of(*state) for state in states]

    search, reached, reason = EventSearch(setup.events, reading), 0.0, ""
    try:
        for index in range(1, count + 1):
            end = setup.duration * (index / count)
            stopped = search.step(reached, end, reading)
            reached = end if stopped is None else stopped
            if stopped is not None:
                reason = search.reason
            setup.progress.show(reached)
            if reason:
                break
    except KeyboardInterrupt:
        # At the end all was computed.
        reason = reason or ("" if reached == setup.duration else INTERRUPTED)
    return search, reached, reason


def by_response(setup: Setup) -> Trajectory:
    """Simulate one free coordinate by its scalar equation."""
    solver = setup.solver
    equation = ScalarEquation(solver, energy_functions(solver), setup.forces)
    y = np.array(setup.drive_start)
    unit = np.array([1.0, _speed(equation.derivative(0.0, y))])
    stiffness = _stiffness(setup, equation, unit, 1)
    integration = Integration(
        equation,
        y,
        setup.duration,
        rtol=setup.rtol,
        atol=setup.atol * unit,
        step=setup.step,
        longest=setup.longest_step,
        is_stiff=None if setup.forces.is_nothing else stiffness.limits,
    )

    def run() -> Run:
        law = IntegratedLaw(integration, equation)
        return OneCoordinateRun(solver, integration.times, law)

    return _integrated(setup, integration, run, "response", setup.start)


def in_all_coordinates(setup: Setup) -> Trajectory:
    """Simulate by constrained dynamics in all coordinates."""
    method = setup.method
    system = System(_model(setup), setup.forces, setup.motions, setup.x)
    y = system.begin(setup.x, setup.turns, setup.v)
    following = None
    if setup.contacts:
        following = ContactFollowing(system, setup.contacts, setup.max_touches)
        following.begin(y)
    coordinates = system.model.mechanism.coordinates
    v, gains = y[system.size :], system.derivative(0.0, y)[system.size :]
    speed = _speed(np.concatenate([v, gains]) / np.tile(coordinates.rate_scale, 2))
    unit = np.concatenate([1.0 / coordinates.scale, speed * coordinates.rate_scale])
    system.model.closed(y[: system.size], y[system.size :])
    refuse_rounding(system.model.rounding)
    stiffness, notes = _stiffness(setup, system, unit, system.size), list[str]()
    if setup.solver.problem.elements and setup.step is None and not following:
        if setup.settle:
            y = stiffness.settled(y, lambda row: system.restored(0.0, row), speed)
        begins = judged(stiffness.modes(0.0, y), setup.duration, speed)
        method = method or ("Radau" if begins.is_stiff else None)
        notes = begins.notes(settle=setup.settle)
    # Before the integration takes whole turns off the row.
    begun = system.rows(y[None], system.turns[None], np.zeros_like(y)[None])
    start = begun.counted[0], begun.v[0]
    integration = Integration(
        system,
        y,
        setup.duration,
        method=method or "DOP853",
        rtol=setup.rtol,
        atol=setup.atol * unit,
        step=setup.step,
        longest=setup.longest_step,
        crossings=Crossings(system.model, system.size),
        stops=sorted({time for times in setup.kinks.values() for time in times}),
        is_stiff=None if setup.forces.is_nothing else stiffness.limits,
    )
    if following:
        integration.strictness = following.strictness
    return _integrated(
        setup,
        integration,
        lambda: ConstrainedRun(integration, system),
        integration.method,
        start,
        notes,
        following,
    )


def _stiffness(setup: Setup, equations: Equations, unit: Array, size: int) -> Stiffness:
    tolerances = setup.rtol, setup.atol, setup.duration
    return Stiffness(equations.derivative, size, unit, *tolerances)


def _speed(rates: Array) -> float:
    """Return how fast joints move [rad/s]: at the start, or soon after it, 1 at most then.

    Args:
        rates: speeds and accelerations at the start `(2 n,)`.
    """
    v, a = (float(np.max(np.abs(part), initial=0.0)) for part in np.split(rates, 2))
    return max(v, min(np.sqrt(a), 1.0)) or 1.0


def _model(setup: Setup) -> ConstrainedModel:
    problem = setup.solver.problem
    coordinates = problem.mechanism.coordinates
    rates = coordinates.rates_of((*setup.motions, *problem.held))
    carried = coordinates.rates_of(setup.carried)
    mechanism = with_free_balls(problem.mechanism, [*rates, *carried], setup.forces.bodies)
    x = mechanism.row(setup.x) if isinstance(mechanism, WithBalls) else setup.x
    independent = coordinates.rates_of(problem.independent)
    resting = [*carried, *coordinates.rates_of(problem.held)] if carried else None
    return ConstrainedModel(mechanism, rates, problem.gravity, x, independent, resting)


def _integrated(
    setup: Setup,
    integration: Integration,
    run_of: Callable[[], Run],
    method: str,
    start: tuple[Array, Array],
    notes: Sequence[str] = (),
    contacts: ContactFollowing | None = None,
) -> Trajectory:
    """Step to the end, to an event, to the last touch, or to where it fails."""
    equations, begun = integration.equations, integration.points[0]
    search = EventSearch(setup.events, lambda _: [equations.named(begun.y, begun.turns)])
    reason, failure = "", None
    # A step that was too long leads beyond all numbers, and is taken anew.
    heed = np.seterr(over="ignore", invalid="ignore")
    try:
        while integration.is_running and not reason:
            failure = integration.advance()
            if failure is not None:
                last = integration.points[-1]
                failure = equations.boundless(*last[:3], NEARLY) or failure
                failure += setup.forces.limits
                if setup.carried:
                    failure += f"; it may be that {UNBOUNDED}"
                break
            if contacts is not None:
                reason = contacts.follow(integration)
            setup.progress.step(integration.time)
            if setup.events:
                reason = search.follow(integration) or reason
    except KeyboardInterrupt:
        reason = INTERRUPTED
    except CardanError as error:
        failure = str(error)
    finally:
        np.seterr(**heed)
        setup.progress.close()
    run, reason = run_of(), failure or reason
    notes = [*setup.notes, *notes, *setup.progress.notes, *search.notes]
    if integration.stiff_from is not None:
        notes.append(f"stiff from {integration.stiff_from:g} s on, where Radau took over")
        method += ", then Radau"
    notes += _lingering(setup, run)
    if integration.crossings is not None:
        notes += notes_of_rounding(integration.crossings.model.rounding, setup.rtol)
    kinks = [
        Happened(f"kink of {name}", math.nextafter(time, math.inf))
        for name, times in setup.kinks.items()
        for time in times
        if time < integration.time
    ]
    course = Course(
        setup,
        run,
        start,
        method,
        reason,
        tuple(sorted([*search.happened, *kinks], key=lambda event: event.time)),
        tuple(notes),
        integration.equations.evaluations,
        contacts.closed(integration.time) if contacts else (),
    )
    trajectory = Trajectory(course, run.times)
    if failure is not None:
        raise SimulationError(
            f"the simulation ended at {integration.time:.6g} s of {setup.duration:g} s: {failure}",
            trajectory=trajectory,
            time=integration.time,
        )
    return trajectory
