"""Build responses: solve their functions at more and more positions until they reach rounding.

What the responses of many designs ask for in a round is solved together.
"""

from __future__ import annotations

import re
from collections.abc import Generator, Mapping

import numpy as np

from ...kit.arrays import EPS, LARGE_BLOCK, ROUNDED, Array
from ...kit.checks import described, number
from ...kit.errors import (
    AccuracyError,
    ArgumentError,
    AssemblyError,
    CardanError,
    SingularConfigurationError,
)
from ...kit.frozen import frozen
from ...kit.time_left import Task
from ..dynamics.problem_solver import ProblemSolver
from ..kinematics.following.branch import whole_turns
from ..problem.problem import Problem
from ..problem.samples import Targets, targets_of
from .data import Proof, ResponseData
from .domain import Domain
from .response import Response
from .sampling import FunctionSampler, Sampled, in_blocks
from .scales import FEW_ROUNDINGS, Scales
from .series import Series

_FIRST_COUNT = 128
"""Positions to begin with: enough for a Cardan joint at 50°, and little more work than 64."""
_GREATEST_COUNT = 2**15
"""Positions to end with. A range that stops 1e-4 of its length short of its dead points takes 2049
for 1e-12, a Cardan joint at 89° 8192 for 1e-13."""
_COUNTED = r" \(sample \d+( of \d+)?\)|; \d+ other samples? (is|are) out of reach too"
"""What messages say of the number of a sample."""

_Building = Generator[Array, Sampled, ResponseData]
"""A response that is built: it asks for its functions at positions until they reach rounding."""


def build(
    solver: ProblemSolver, tolerance: object, interval: object, held: object = None
) -> Response:
    """Return the response of a scene, or of its designs; see `Scene.response` and `responses`."""
    checked = number("tolerance", tolerance)
    if not EPS <= checked < 1.0:  # Less is below the rounding of a single number.
        raise ArgumentError(f"tolerance is {checked:g}, expected {EPS:.2g} … 1")
    problem = solver.problem
    _refuse_unsuitable(problem)
    domain = _domain(solver, interval)
    if held is None:
        data = _built(solver, Targets((), np.zeros(1)), domain, checked)
        return Response(solver, (), frozen({}), data)
    start = problem.mechanism.coordinates.named[problem.independent[0]].column
    designs = targets_of(problem, float(solver.assembly.start[start]), held)
    every = solver.of_varied(designs.varied)
    _refuse_what_does_not_come_back(every, designs, domain)
    # Where all designs are that of the scene, they share one response.
    different = designs if designs.held else designs.of_samples(np.zeros(1, dtype=int))
    return Response(every, designs.shape, designs.held, _built(every, different, domain, checked))


def _built(
    solver: ProblemSolver, designs: Targets, domain: Domain, tolerance: float
) -> tuple[ResponseData, ...]:
    """Return the functions of all designs, or of the scene where they have no dimension."""
    sampler, shape = FunctionSampler(solver), designs.shape
    building = [_response_in(domain, solver, sampler, tolerance) for _ in range(designs.size)]
    requests = {index: next(item) for index, item in enumerate(building)}
    data, is_first = dict[int, ResponseData](), True
    with Task("responses", designs.size) as task:
        while requests:
            waiting, requests = requests, {}
            for indices in _portions(waiting):
                positions = [waiting[index] for index in indices]
                counts = list(map(len, positions))
                samples = np.repeat(indices, counts)
                targets = designs.of_samples(samples).at(np.concatenate(positions))
                try:
                    answers = sampler.samples(targets, counts, is_first)
                except (AssemblyError, SingularConfigurationError) as error:
                    if not shape:
                        raise _beyond_reach(solver.problem, domain, error) from error
                    raise _of_design(error, designs, samples) from error
                for index, answer in zip(indices, answers, strict=True):
                    try:
                        requests[index] = building[index].send(answer)
                    except StopIteration as end:
                        data[index] = end.value
                    except CardanError as error:
                        if shape:
                            error.args = f"{_name(shape, index)}: {error.args[0]}", *error.args[1:]
                        raise
                task.tell(len(data))
            is_first = False  # What is asked first proves the response.
    return tuple(data[index] for index in range(designs.size))


def _portions(requests: Mapping[int, Array]) -> list[list[int]]:
    """Return the designs that ask for functions, as many at a time as are followed together.

    Memory then does not grow with the designs.
    """
    designs = iter(requests)
    together = in_blocks(map(len, requests.values()), 8 * LARGE_BLOCK)
    return [[next(designs) for _ in spans] for spans in together]


def _response_in(
    domain: Domain, solver: ProblemSolver, sampler: FunctionSampler, tolerance: float
) -> _Building:
    """Build the functions of a response in a domain, from answers to its requests.

    Args:
        domain: of the drive.
        solver: of the scene.
        sampler: which functions there are.
        tolerance: see `Scene.response`.

    Raises:
        AccuracyError: the tolerance is out of reach.
        IndeterminateError: see `ProblemSolver.refuse_indeterminate`.
    """
    scales = Scales(solver.problem.mechanism, sampler.layout)
    nodes, between = domain.nodes(_FIRST_COUNT), _check_positions(domain)
    # One request costs less than two, and the positions in between prove the result.
    samples = yield np.concatenate([nodes, between])
    residuals, loop_error = samples.proven, samples.loop_error
    assert residuals is not None and loop_error is not None
    # A component that is indeterminate at a few positions is so at all of them: if the scene is
    # strict, no more need to be solved.
    solver.refuse_indeterminate(samples.unique)
    values = samples.values[:, len(nodes) :]
    cancellation = scales.cancellation(values, residuals)
    first = samples.first(len(nodes))
    refining = _refined(scales, tolerance, domain, first, between, values, cancellation)
    samples, reached = yield from refining
    solver.refuse_indeterminate(samples.unique)
    # Which functions vanish, and which of the others do not change.
    scale, empty = scales.of(samples.values), scales.empty(samples.values)
    size = np.max(np.abs(samples.values), axis=1) / scale
    change = np.ptp(samples.values, axis=1) / scale
    zero = empty | (size <= FEW_ROUNDINGS)
    constant = (change <= FEW_ROUNDINGS) & ~zero
    left_out = max(
        float(np.max(size, where=zero & ~empty, initial=0.0)),
        float(np.max(change, where=constant, initial=0.0)),
    )
    loose = samples.indeterminate_couplings
    return ResponseData(
        sampler.layout,
        Series(samples.values, domain),
        zero,
        constant,
        samples.unique,
        frozen({name: index not in loose for index, name in solver.couplings.items()}),
        Proof(
            tolerance=tolerance,
            error=max(reached, left_out, EPS * samples.condition),
            condition=samples.condition,
            cancellation=cancellation,
            **vars(residuals.proven(loop_error, solver.inverse_dynamics.bodies.unproven)),
        ),
    )


def _refined(
    scales: Scales,
    tolerance: float,
    domain: Domain,
    samples: Sampled,
    between: Array,
    values: Array,
    cancellation: float,
) -> Generator[Array, Sampled, tuple[Sampled, float]]:
    """Double the samples until both what they leave out and their deviations are small enough.

    What a series leaves out (its remainder) its coefficients tell. How far it deviates from
    directly solved positions costs a sum over the series, so that it is measured only once the
    remainder lets the refinement end.

    Args:
        scales: what errors are relative to.
        tolerance: relative to the scale of each function.
        domain: a period or a range.
        samples: the first ones.
        between: positions `(K,)` between them.
        values: `(C, K)` all functions there, directly solved.
        cancellation: of inertial terms, see `Proof`.

    Returns:
        The samples and their greatest error.
    """
    before, deviated_before = np.inf, np.inf
    while True:
        series = Series(samples.values, domain)
        scale, empty = scales.of(samples.values), scales.empty(samples.values)
        inertial = scales.rounding(cancellation, samples.condition)
        rounding = ROUNDED * samples.condition + inertial
        remainder = np.where(empty, 0.0, series.remainder(rounding * scale) / scale)
        error = float(np.max(remainder, initial=0.0))
        # A doubling squares the ratio of coefficients that fall off geometrically. What it does not
        # even halve is rounding, if it is small: half of the digits are no function's.
        is_hopeless = 0.5 * before < error < EPS**0.5
        before = error
        if error <= tolerance or (is_hopeless and np.all(remainder <= rounding)):
            deviation = np.abs(series.summed(between) - values) / scale[:, None]
            deviation = np.where(empty, 0.0, np.max(deviation, axis=1))
            deviated = float(np.max(deviation, initial=0.0))
            error = max(error, deviated)
            if np.all(deviation <= np.maximum(tolerance, rounding)):
                return samples, error
            # More samples do not lower a deviation that has another cause than too few of them.
            is_hopeless |= deviated > 0.5 * deviated_before
            deviated_before = deviated
        count = domain.steps(samples.values.shape[1])
        if is_hopeless or count >= _GREATEST_COUNT:
            raise AccuracyError(
                f"the response reaches {error:.1e} with {count} samples, not {tolerance:.0e}: the "
                f"closure equations have condition {samples.condition:.1e}; ask for a greater "
                "tolerance, or for a range farther from dead points",
                residual=error,
                tolerance=tolerance,
                position=None,
            )
        # Every other position of the finer series is one of this one's.
        samples = samples.interleaved((yield domain.nodes(2 * count)[1::2]))


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


def _of_design(
    error: AssemblyError | SingularConfigurationError, designs: Targets, sample_of: Array
) -> CardanError:
    """Return an error that names the design of its sample."""
    sample = getattr(error, "sample", None)
    if sample is None:
        return error
    name = _name(designs.shape, int(sample_of[sample]))
    # Nobody asked for these samples, of which the message counts some.
    finding = re.sub(_COUNTED, "", str(error))
    return type(error)(f"{name}: {finding}", **{**error.details, "sample": None})


def _name(shape: tuple[int, ...], index: int) -> str:
    """Return how messages call a design."""
    place = tuple(int(item) for item in np.unravel_index(index, shape))
    return f"design {place[0] if len(place) == 1 else place}"


def _refuse_what_does_not_come_back(
    solver: ProblemSolver, designs: Targets, domain: Domain
) -> None:
    """Refuse designs whose drive does not turn through as that of the scene does.

    Raises:
        CardanError: there is one; the message names it.
    """
    if not (domain.periodic and designs.held):
        return
    assembly = solver.assembly
    ends = designs.positions + domain.length
    try:
        first, last = (
            assembly.close(assembly.guesses(designs.at(positions)), positions)
            for positions in (designs.positions, ends)
        )
    except (AssemblyError, SingularConfigurationError) as error:
        raise _of_design(error, designs, np.arange(designs.size)) from error
    is_back, _ = whole_turns(assembly.kinematics, first.x, last.x)
    if not is_back.all():
        name = _name(designs.shape, int(np.argmin(is_back)))
        raise CardanError(
            f"{solver.problem.mechanism.name}: {name} does not come back to where it was after the "
            "period of the scene; give an interval: responses(held, interval=(low, high))"
        )


def _refuse_unsuitable(problem: Problem) -> None:
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


def _domain(solver: ProblemSolver, interval: object) -> Domain:
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
        # Of nearer ends, positions between them could not be told apart.
        if not length > ROUNDED * abs(origin):
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
    share = (np.arange(1.0, _FIRST_COUNT // 4 + 1.0) * (0.5 * np.sqrt(5.0) - 0.5)) % 1.0
    if not domain.periodic:
        round_count = (_GREATEST_COUNT // _FIRST_COUNT).bit_length()
        ends = 0.5 / (_FIRST_COUNT * 2.0 ** np.arange(round_count))
        share = np.concatenate([share, ends, 1.0 - ends])
    return domain.at_share(share)
