"""Build a response: solve its functions at more and more positions until they reach rounding."""

from __future__ import annotations

from collections.abc import Generator
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..checks import described, number
from ..dynamics.problem_solver import ProblemSolver
from ..errors import (
    AccuracyError,
    ArgumentError,
    AssemblyError,
    CardanError,
    SingularConfigurationError,
)
from ..frozen import FrozenDict, frozen
from ..problem.problem import Problem
from .columns import Layout
from .convergence import Convergence
from .data import Proof, ResponseData
from .domain import Domain
from .sampling import Answer, FunctionSampler, Request, Samples
from .scales import Scales
from .series import Series

_FIRST_COUNT = 128
"""Positions to begin with: enough for a Cardan joint at 50°, and little more work than 64."""
_GREATEST_COUNT = 2**15
"""Positions to end with. A range that stops 1e-4 of its length short of its dead points takes 2049
for 1e-12, a Cardan joint at 89° 8192 for 1e-13."""
_CHECK_COUNT = 32
"""Positions anywhere between the samples at which functions are compared with direct solutions."""
_LEAST_TOLERANCE = 1e-15
"""Smaller tolerances lie below the rounding of a single number, 2.2e-16, times a few operations."""
_SAMPLE_ROUNDING = 1e-12
"""Rounding of samples, and so of what they deviate by, per condition number. Measured: 2e-15 in a
Cardan joint, 2e-14 in a double shaft, 4e-14 in a line of three joints."""
_VANISHING = 2e-15
"""Functions, or their changes, below this part of their scale are rounding, and are left out. It is
the least that samples were measured to deviate by, see `_SAMPLE_ROUNDING`."""
_SHORTEST_INTERVAL = 1e3
"""Half the length of an interval has to exceed the rounding of its middle by this factor: closer
positions could not be told apart to three digits."""
_EPS = float(np.finfo(float).eps)


class Checks(NamedTuple):
    """Directly solved positions between the samples.

    Attributes:
        positions: `(K,)`.
        values: `(C, K)` all functions there.
        cancellation: of inertial terms, see `Proof`.
    """

    positions: Array
    values: Array
    cancellation: float


Building = Generator[Request, Answer, ResponseData]
"""A response that is built: it asks for its functions until they reach rounding."""


def build(solver: ProblemSolver, tolerance: object, interval: object) -> ResponseData:
    """Return the functions of a response; see `Scene.response`."""
    checked = checked_tolerance(tolerance)
    refuse_unsuitable(solver.problem)
    domain = domain_of(solver, interval)
    sampler = FunctionSampler(solver)
    building = response_in(domain, solver, sampler.layout, checked)
    request = next(building)
    try:
        while True:
            try:
                answer = sampler.answer(request)
            except (AssemblyError, SingularConfigurationError) as error:
                raise _beyond_reach(solver.problem, domain, error) from error
            request = building.send(answer)
    except StopIteration as end:
        data: ResponseData = end.value
        return data


def response_in(
    domain: Domain, solver: ProblemSolver, layout: Layout, tolerance: float
) -> Building:
    """Build the functions of a response in a domain, from answers to its requests.

    Args:
        domain: of the drive.
        solver: of the scene.
        layout: which functions there are.
        tolerance: see `Scene.response`.

    Raises:
        AccuracyError: the tolerance is out of reach.
        IndeterminateError: see `ProblemSolver.refuse_indeterminate`.
    """
    scales = Scales(solver.problem.mechanism, layout)
    nodes, between = domain.nodes(_FIRST_COUNT), _check_positions(domain)
    # One request costs less than two, and the positions in between prove the result.
    samples, loop_error, residuals = yield Request(np.concatenate([nodes, between]), proven=True)
    if residuals is None or loop_error is None:
        raise ValueError("residuals were asked for")
    # A component that is indeterminate at a few positions is so at all of them: if the scene is
    # strict, no more need to be solved.
    solver.refuse_indeterminate(samples.unique)
    values = samples.values[:, len(nodes) :]
    checks = Checks(between, values, scales.cancellation(values, residuals))
    first = samples.first(len(nodes))
    samples, reached = yield from _refined(scales, tolerance, domain, first, checks)
    solver.refuse_indeterminate(samples.unique)
    zero, constant, left_out = _simplified(samples.values, scales)
    return ResponseData(
        layout,
        Series(samples.values, domain),
        zero,
        constant,
        samples.unique,
        _unique_couplings(solver, samples),
        Proof(
            tolerance=tolerance,
            error=max(reached, left_out, _EPS * samples.condition),
            condition=samples.condition,
            cancellation=checks.cancellation,
            **vars(residuals.proven(loop_error, solver.inverse_dynamics.bodies.unproven)),
        ),
    )


def _beyond_reach(
    problem: Problem, domain: Domain, error: AssemblyError | SingularConfigurationError
) -> CardanError:
    """Return the error for an interval that the drive cannot move through.

    Args:
        problem: what is solved.
        domain: the interval.
        error: of one of its positions, which nobody asked for.
    """
    if domain.periodic or error.reach is None:
        return error
    low, high = error.reach
    ends = domain.interval
    details = {**error.details, "sample": None}
    if isinstance(error, AssemblyError):
        nearest = error.nearest
        details["position"] = ends[0] if nearest == low else ends[1]
    return type(error)(
        f"{problem.mechanism.name}: a response from {ends[0]:.9g} to {ends[1]:.9g} goes beyond "
        f"what drive {problem.independent[0]!r} can reach, {low:.9g} to {high:.9g}: at the end "
        f"{error.finding}; give an interval within this range",
        **details,
    )


def _refined(
    scales: Scales, tolerance: float, domain: Domain, samples: Samples, checks: Checks
) -> Generator[Request, Answer, tuple[Samples, float]]:
    """Double the samples until both what they leave out and their deviations are small enough.

    Args:
        scales: what errors are relative to.
        tolerance: relative to the scale of each function.
        domain: a period or a range.
        samples: the first ones.
        checks: directly solved positions between them.

    Returns:
        The samples and their greatest error.
    """
    convergence: Convergence | None = None
    while True:
        series = Series(samples.values, domain)
        scale, empty = scales.of(samples.values), scales.empty(samples.values)
        inertial = scales.rounding(checks.cancellation, samples.condition)
        rounding = _SAMPLE_ROUNDING * samples.condition + inertial
        remainder = np.where(empty, 0.0, series.remainder(rounding * scale) / scale)
        if convergence is None:
            convergence = Convergence(tolerance, remainder, rounding)
        else:
            convergence = convergence.next_round(remainder, rounding)
        if convergence.may_end:
            deviation = np.abs(series.summed(checks.positions) - checks.values) / scale[:, None]
            deviation = np.where(empty, 0.0, np.max(deviation, axis=1))
            convergence = convergence.with_deviation(deviation)
        if convergence.is_reached:
            return samples, convergence.error
        count = domain.steps(samples.values.shape[1])
        if convergence.is_hopeless or count >= _GREATEST_COUNT:
            raise _out_of_reach(convergence, count, samples.condition)
        # Every other position of the finer series is one of this one's.
        between = domain.nodes(2 * count)[1::2]
        answer = yield Request(between)
        samples = samples.interleaved(answer.samples)


def _out_of_reach(convergence: Convergence, count: int, condition: float) -> AccuracyError:
    return AccuracyError(
        f"the response reaches {convergence.error:.1e} with {count} samples, not "
        f"{convergence.tolerance:.0e}: the closure equations have condition {condition:.1e}; ask "
        "for a greater tolerance, or for a range farther from dead points",
        residual=convergence.error,
        tolerance=convergence.tolerance,
        position=None,
    )


def _simplified(values: Array, scales: Scales) -> tuple[Array, Array, float]:
    """Return which functions vanish, which do not change, and the error of taking them so.

    Args:
        values: `(C, M)` all functions.
        scales: what their errors are relative to.

    Returns:
        `(C,)` which functions vanish; `(C,)` which of the others are constant; the greatest
        value or change, relative to the scale, that is left out.
    """
    scale, empty = scales.of(values), scales.empty(values)
    size, change = np.max(np.abs(values), axis=1) / scale, np.ptp(values, axis=1) / scale
    zero = empty | (size <= _VANISHING)
    constant = (change <= _VANISHING) & ~zero
    left_out = max(
        float(np.max(size, where=zero & ~empty, initial=0.0)),
        float(np.max(change, where=constant, initial=0.0)),
    )
    return zero, constant, left_out


def _unique_couplings(solver: ProblemSolver, samples: Samples) -> FrozenDict[str, bool]:
    """Return which couplings' moments follow from the laws of motion alone."""
    return frozen(
        {
            name: index not in samples.indeterminate_couplings
            for index, name in solver.couplings.items()
        }
    )


def checked_tolerance(tolerance: object) -> float:
    """Return the tolerance as a number.

    Raises:
        ArgumentError: it is no number or out of range.
    """
    value = number("tolerance", tolerance)
    if not _LEAST_TOLERANCE <= value < 1.0:
        raise ArgumentError(f"tolerance is {value:g}, expected {_LEAST_TOLERANCE:g} … 1")
    return value


def refuse_unsuitable(problem: Problem) -> None:
    """Refuse a problem whose wrenches are no functions of one drive's position.

    Raises:
        ArgumentError: it has several drives, elements, teeth, or a wrench on a link that changes
            from sample to sample.
    """
    refuse_elements(problem)
    if problem.mechanism.teeth:
        raise ArgumentError(
            "a response takes no gears with teeth, whose radial force is the same for either sign "
            "of the torque; sweep the scene directly: scene.sweep(position, ...)"
        )
    if len(problem.independent) != 1:
        raise ArgumentError(f"a response needs one drive, not {list(problem.independent)}")
    for name, load in problem.link_loads.items():
        if max(load.force.size, load.moment.size) > 3:
            raise ArgumentError(
                f"the wrench on {name!r} changes from sample to sample; a response needs one that "
                "stays the same"
            )


def refuse_elements(problem: Problem) -> None:
    """Refuse a problem with elements.

    Raises:
        ArgumentError: it has some.
    """
    if problem.elements:
        raise ArgumentError(
            "a response takes no elements, whose forces are no multiples of speed², acceleration, "
            "loads and gravity; sweep the scene directly: scene.sweep(position, ...)"
        )


def domain_of(solver: ProblemSolver, interval: object) -> Domain:
    """Return the interval, or the period of the drive if there is no interval.

    Raises:
        ArgumentError: the interval is empty or no pair of numbers.
        CardanError: there is none, and the drive does not come back to where it was.
    """
    problem = solver.problem
    (drive,) = problem.drives
    if interval is not None:
        low, high = _pair(interval)
        origin, length = 0.5 * low + 0.5 * high, 0.5 * high - 0.5 * low
        if not length > _SHORTEST_INTERVAL * _EPS * abs(origin):
            raise ArgumentError(f"the interval from {low:.9g} to {high:.9g} is empty")
        return Domain(origin, length, False)
    try:
        period = solver.assembly.period()
    except (AssemblyError, SingularConfigurationError) as error:
        low, high = solver.assembly.motion_range()
        raise CardanError(
            f"{problem.mechanism.name}: drive {drive!r} moves only between {low:.9g} "
            f"and {high:.9g}: at the end {error.finding}; give an interval between them: "
            "response(interval=(low, high))"
        ) from error
    if period is None:
        raise CardanError(
            f"{problem.mechanism.name}: drive {drive!r} does not come back to where it "
            "was within a few turns; give the interval: response(interval=(low, high))"
        )
    # A period begins where the scene starts.
    column = problem.mechanism.coordinates.named[drive].column
    return Domain(float(solver.assembly.start[column]), period, True)


def _pair(interval: object) -> tuple[float, float]:
    # An array without a dimension has no length.
    has_length = not isinstance(interval, np.ndarray) or interval.ndim > 0
    if not (isinstance(interval, (tuple, list, np.ndarray)) and has_length and len(interval) == 2):
        raise ArgumentError(f"interval is {described(interval)}, expected (low, high)")
    return number("interval[0]", interval[0]), number("interval[1]", interval[1])


def _check_positions(domain: Domain) -> Array:
    """Return positions between the samples, spread by the golden section.

    On a range they lie closer together towards its ends, as its samples do. There the errors of
    all orders add up, so that further positions lie in the middle between the last two samples of
    every round.
    """
    share = (np.arange(1.0, _CHECK_COUNT + 1.0) * (0.5 * np.sqrt(5.0) - 0.5)) % 1.0
    if domain.periodic:
        return domain.at_share(share)
    round_count = (_GREATEST_COUNT // _FIRST_COUNT).bit_length()
    ends = 0.5 / (_FIRST_COUNT * 2.0 ** np.arange(round_count))
    share = np.concatenate([share, ends, 1.0 - ends])
    return domain.at_share(share)
