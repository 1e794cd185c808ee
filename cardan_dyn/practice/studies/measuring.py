"""Measuring: what the first case returns, and how long a case takes, before anything is kept."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from time import perf_counter

import numpy as np

from ...kit.errors import ArgumentError, CardanError, choices
from .chunk import FAILED, Box, Computed, Job, called, compute, failure, packed
from .chunking import filled
from .outcomes import Outcomes, Schema, schema_of

_TRIED = 8
"""Cases that are tried for a first one that does not fail."""
_TIMED = 0.3
"""How long cases are timed [s], the first one aside."""
_ONE_CALL = 0.1
"""Time of a call with many cases in which what every call takes hardly counts [s]."""
_GROWTH = 8
"""Factor between the numbers of cases in the calls that are timed."""
_MOST_TIMED = 64
"""Cases that are timed one by one."""
_AGREE = 1e-6
"""Relative difference between cases that are computed together and alone which is no rounding of
any method, but says that a function is not vectorized."""


def first_schema(job: Job) -> Schema:
    """Return what cases return, by the first one that does not fail.

    Raises:
        CardanError: all that were tried fail.
        ArgumentError: a result is called like a parameter.
    """
    parameters = job.parameters
    tried = np.linspace(0, parameters.count - 1, min(_TRIED, parameters.count)).astype(int)
    first: Exception | None = None
    for place in tried:
        index = _index(job, int(place))
        try:
            found = schema_of(_of_one(job, index), len(index) if job.broadcasts else 0)
        except Exception as error:
            first = first or error
            continue
        _refuse_clashes(found, job)
        return found
    raise CardanError(
        f"none of {len(tried)} cases succeeded; that of {parameters.case(_index(job, 0))} ended "
        f"with: {failure(first or CardanError('nothing'))}"
    ) from first


def _refuse_clashes(schema: Schema, job: Job) -> None:
    """Refuse names that two things would have in one Dataset."""
    taken = {*job.parameters.units, *job.parameters.dims}
    results = {*schema.variables, *schema.coordinates}
    results |= {dim for item in schema.variables.values() for dim in item.dims}
    own = {dim for item in schema.variables.values() for dim in item.dims}
    if clash := own & set(schema.variables):
        raise ArgumentError(f"{choices(clash)} is a result and a dimension of one: rename it")
    if clash := taken & results:
        raise ArgumentError(
            f"{choices(clash)} is a parameter, or its dimension, and a result besides: "
            "give it another name"
        )


def refuse_not_vectorized(job: Job) -> None:
    """Refuse a function whose cases are others together than alone.

    Raises:
        ArgumentError: they are.
    """
    data, shape = packed(job), job.parameters.shape
    sizes = [min(size, 3) if axis < 4 else 1 for axis, size in enumerate(shape)]
    ends = [size - some for size, some in zip(shape, sizes, strict=True)]
    # At both ends: what sorts its values, say, is right where these rise.
    for start in ([0] * len(shape), ends):
        box: Box = tuple(slice(at, at + size) for at, size in zip(start, sizes, strict=True))
        _refuse_others(compute(data, box), compute(data, box, alone=True))


def _refuse_others(together: Computed, alone: Computed) -> None:
    """Refuse cases that are others together than alone; those that fail alone fail together."""
    there = together.state != FAILED
    for name, values in alone.arrays.items():
        is_same = np.array_equal(there, alone.state != FAILED) and np.allclose(
            together.arrays[name][there], values[there], rtol=_AGREE, atol=0.0, equal_nan=True
        )
        if not is_same:
            raise ArgumentError(
                f"{name} is another number where cases are computed together than alone: the "
                "function is not vectorized; leave vectorized=True out"
            )


def seconds_per_case(job: Job, axes: Sequence[int]) -> float:
    """Return how long a case takes here [s].

    Args:
        job: whose cases are timed.
        axes: dimensions that one call takes; none of a function of single cases.
    """
    found = _in_calls(job, axes) if axes else None
    return _one_by_one(job) if found is None else found


def _in_calls(job: Job, axes: Sequence[int]) -> float | None:
    """Return how long a case takes in a call of many; None if such calls fail."""
    shape = job.parameters.shape
    most = math.prod(shape[axis] for axis in axes)
    size, found = 1, None
    while True:
        box = [slice(0, length) for length in filled(shape, size, reversed(axes))]
        try:
            spent = _of_call(job, box)
            if size >= most or spent > _ONE_CALL:
                # Once more: the first call of a kind imports and learns what the others know.
                spent = min(spent, _of_call(job, box))
        except Exception:  # One of them fails.
            return found
        found = spent / math.prod(span.stop for span in box)
        if size >= most or spent > _ONE_CALL:
            return found
        size *= _GROWTH


def _of_call(job: Job, box: Sequence[slice]) -> float:
    """Return how long a call with the cases of a box takes [s]."""
    before = perf_counter()
    called(job, job.parameters.mesh(box))
    return perf_counter() - before


def _one_by_one(job: Job) -> float:
    """Return how long a case takes by itself."""
    began = perf_counter()
    cases = np.linspace(0, job.parameters.count - 1, _MOST_TIMED).astype(int)
    spent, timed = 0.0, 0
    for place in cases:
        with suppress(Exception):  # What fails takes its time, too.
            _of_one(job, _index(job, int(place)))
        spent, timed = perf_counter() - began, timed + 1
        if spent > _TIMED:
            break
    return spent / timed


def _of_one(job: Job, index: Sequence[int]) -> Outcomes:
    """Return what the function returns for one case."""
    if job.broadcasts:
        return called(job, job.parameters.mesh([slice(at, at + 1) for at in index]))
    return called(job, job.parameters.case(index))


def _index(job: Job, place: int) -> list[int]:
    """Return the index of a case in each dimension."""
    return [int(at) for at in np.unravel_index(place, job.parameters.shape)]
