"""Family build: the functions of many designs' responses, solved together round by round."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ..arrays import Array
from ..dynamics.problem_solver import ProblemSolver
from ..errors import AssemblyError, CardanError, SingularConfigurationError
from ..problem.samples import Targets
from ..time_left import Task
from .build import Building, response_in
from .data import ResponseData
from .domain import Domain
from .sampling import Answer, FunctionSampler, Request

_COUNTED = r" \(sample \d+( of \d+)?\)|; \d+ other samples? (is|are) out of reach too"
"""What messages say of the number of a sample."""
_MOST_SAMPLES = 65_536
"""Samples that are followed at a time, so that memory does not grow with the designs."""
_BEFORE_THE_END = 1e-9
"""Part of a period by which designs are followed less than it, to see whether they come back."""
_COMES_BACK = 1e-6
"""Sine of half an angle by which a joint may miss where it started, besides what it has to go."""


def refuse_what_does_not_come_back(solver: ProblemSolver, designs: Targets, domain: Domain) -> None:
    """Refuse designs whose drive does not turn through as that of the scene does.

    Raises:
        CardanError: there is one; the message names it.
    """
    if not (domain.periodic and designs.held):
        return
    assembly = solver.assembly
    ends = designs.positions + (1.0 - _BEFORE_THE_END) * domain.length
    try:
        first, last = (
            assembly.close(assembly.guesses(designs.at(positions)), positions)
            for positions in (designs.positions, ends)
        )
    except (AssemblyError, SingularConfigurationError) as error:
        raise _of_design(error, designs, np.arange(designs.size)) from error
    angles = solver.problem.mechanism.coordinates.angle_columns
    moved = last.x[:, angles] - first.x[:, angles]
    missed = np.max(np.abs(np.sin(0.5 * moved)), axis=1, initial=0.0)
    ones = np.ones_like(designs.positions)
    ratios = solver.inverse_dynamics.joint_rates(first, ones, 0.0 * ones).v
    still_to_go = _BEFORE_THE_END * domain.length * np.max(np.abs(ratios), axis=1)
    is_off = missed > _COMES_BACK + still_to_go
    if np.any(is_off):
        name = _name(designs.shape, int(np.argmax(is_off)))
        raise CardanError(
            f"{solver.problem.mechanism.name}: {name} does not come back to where it was after the "
            "period of the scene; give an interval: responses(held, interval=(low, high))"
        )


def built(
    solver: ProblemSolver,
    sampler: FunctionSampler,
    designs: Targets,
    domain: Domain,
    tolerance: float,
) -> list[ResponseData]:
    """Return the functions of all designs; what they ask for in a round is solved together."""
    buildings = [
        response_in(domain, solver, sampler.layout, tolerance) for _ in range(designs.size)
    ]
    requests = {index: next(building) for index, building in enumerate(buildings)}
    data: dict[int, ResponseData] = {}
    with Task("responses", designs.size) as task:
        while requests:
            waiting, requests = requests, {}
            for indices in _portions(waiting):
                answers = _answers(sampler, designs, indices, waiting)
                for index, answer in zip(indices, answers, strict=True):
                    request = _next(buildings[index], answer, designs.shape, index, data)
                    if request is not None:
                        requests[index] = request
                task.tell(len(data))
    return [data[index] for index in range(designs.size)]


def _next(
    building: Building,
    answer: Answer,
    shape: tuple[int, ...],
    index: int,
    data: dict[int, ResponseData],
) -> Request | None:
    """Return what a design asks for next; None if it is built, and then in `data`."""
    try:
        return building.send(answer)
    except StopIteration as end:
        data[index] = end.value
        return None
    except CardanError as error:
        error.args = (f"{_name(shape, index)}: {error.args[0]}", *error.args[1:])
        raise


def _portions(requests: Mapping[int, Request]) -> Iterator[list[int]]:
    """Yield the designs that ask for functions, as many at a time as are followed together.

    Those of a portion either all want residuals or none of them does.
    """
    for proven in (True, False):
        portion, count = list[int](), 0
        for index, request in requests.items():
            if request.proven is not proven:
                continue
            if portion and count + len(request.positions) > _MOST_SAMPLES:
                yield portion
                portion, count = [], 0
            portion.append(index)
            count += len(request.positions)
        if portion:
            yield portion


def _answers(
    sampler: FunctionSampler,
    designs: Targets,
    indices: Sequence[int],
    requests: Mapping[int, Request],
) -> list[Answer]:
    """Return the answers to the requests of some designs."""
    positions = [requests[index].positions for index in indices]
    ends = np.cumsum([len(item) for item in positions])
    spans = [
        slice(int(end) - len(item), int(end)) for end, item in zip(ends, positions, strict=True)
    ]
    sample_of = np.repeat(indices, [len(item) for item in positions])
    targets = designs.of_samples(sample_of).at(np.concatenate(positions))
    try:
        return sampler.answers(targets, spans, requests[indices[0]].proven)
    except (AssemblyError, SingularConfigurationError) as error:
        raise _of_design(error, designs, sample_of) from error


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
    place = [int(item) for item in np.unravel_index(index, shape)]
    return f"design {place[0] if len(place) == 1 else tuple(place)}"
