"""Chunk: a box of cases, computed wherever a worker is.

A chunk is computed by a copy of the function that no other chunk has used, so that what a scene
learns while it is used makes no difference: results depend on the chunk alone, to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import product
from threading import Lock
from typing import Any, NamedTuple

import numpy as np

from ...kit.arrays import Array
from ...kit.errors import ArgumentError, CardanError, MissingExtraError
from ...kit.threads import on_cores
from .outcomes import Outcome, Outcomes, Schema, outcomes_of
from .parameters import Parameters

DONE, FAILED = 1, 2
"""States of a case; 0 where it was not computed."""
_LONGEST = 4000
"""Characters of a message that are kept."""

Box = tuple[slice, ...]
"""A span of each dimension, with both ends."""


class Job(NamedTuple):
    """What all chunks of a study have in common.

    Attributes:
        function: of the parameters.
        parameters: of the study.
        schema: of the results; None while the first case is still to be computed.
        units: of results, by name.
        broadcasts: whether the function takes the arrays of a whole box at once.
    """

    function: Callable[..., object]
    parameters: Parameters
    schema: Schema | None
    units: Mapping[str, str]
    broadcasts: bool


class Computed(NamedTuple):
    """The results of a chunk.

    Attributes:
        arrays: variables to results, of the shape of the box and of a case.
        state: of the cases, of the shape of the box.
        failures: pairs of a case's flat index in the box, and `Type: message`.
    """

    arrays: dict[str, Array]
    state: Array
    failures: list[tuple[int, str]]


def packed(job: Job) -> bytes:
    """Return a job as bytes, with functions of scripts and notebooks by value.

    Raises:
        CardanError: it cannot be pickled.
    """
    import cloudpickle

    with _sending():
        return bytes(cloudpickle.dumps(job))


def unpacked(data: bytes) -> Job:
    """Return a copy of a job that nothing has used.

    Raises:
        CardanError: no copy can be made of what was pickled.
    """
    import cloudpickle

    with _sending():
        job: Job = cloudpickle.loads(data)
    return job


@contextmanager
def _sending() -> Iterator[None]:
    """Say what to do where a function cannot be sent."""
    try:
        yield
    except Exception as error:
        raise CardanError(
            f"the function cannot be sent to workers: it cannot be pickled ({error}). Let it make "
            "files, locks and connections itself, instead of taking them from outside"
        ) from error


def missing(package: str) -> MissingExtraError:
    """Return the error that says how to install what studies need."""
    return MissingExtraError(
        f'a study needs {package}: pip install "cardan-dyn[study]", with Python 3.11 or later'
    )


def compute(job: bytes, box: Box, wanted: Array | None = None, *, alone: bool = False) -> Computed:
    """Return the results of a chunk.

    Args:
        job: from `packed`.
        box: which cases.
        wanted: which of them, of the shape of the box; all if None.
        alone: compute each by a copy of the function of its own.
    """
    # Workers would fight for cores, and sums of linear algebra depend on the number of threads.
    with _one_thread(), on_cores(1):
        run = _Run(unpacked(job), box)
        if not alone:
            run.cases(wanted)
        else:
            for index in np.argwhere(np.ones(run.state.shape) if wanted is None else wanted):
                run.job = unpacked(job)
                run.case(tuple(index.tolist()))
    return Computed(run.arrays, run.state, run.failures)


_LOCK = Lock()
_LIMITED: list[Any] = [0, None]
"""How many chunks are computed by threads of this process, and what ends their limit."""


@contextmanager
def _one_thread() -> Iterator[None]:
    """Let linear algebra use one thread, until the last chunk that is computed here is done."""
    from threadpoolctl import threadpool_limits

    with _LOCK:
        _LIMITED[0] += 1
        if _LIMITED[0] == 1:
            _LIMITED[1] = threadpool_limits(1)
    try:
        yield
    finally:
        with _LOCK:
            _LIMITED[0] -= 1
            if _LIMITED[0] == 0:
                _LIMITED[1].restore_original_limits()


class _Run:
    """Results of a chunk while they are computed."""

    def __init__(self, job: Job, box: Box) -> None:
        if job.schema is None:
            raise RuntimeError("a chunk needs the schema of the first case")
        self.job, self.box = job, box
        shape = tuple(span.stop - span.start for span in box)
        self.schema = job.schema
        self.arrays = job.schema.empty(shape)
        self.state = np.zeros(shape, np.int8)
        self.failures: list[tuple[int, str]] = []

    def cases(self, wanted: Array | None) -> None:
        """Compute the cases that are wanted."""
        every = tuple(slice(0, size) for size in self.state.shape)
        if self.job.broadcasts:
            self.at_once(every, wanted)
            return
        mesh = self.job.parameters.mesh(self.box)
        for place in product(*(range(size) for size in self.state.shape)):
            if wanted is None or wanted[place]:
                given = {name: entry(values, place) for name, values in mesh.items()}
                self._one(place, given)

    def case(self, place: tuple[int, ...]) -> None:
        """Compute one case, by its place in the box."""
        index = [span.start + at for span, at in zip(self.box, place, strict=True)]
        if self.job.broadcasts:
            self.at_once(tuple(slice(at, at + 1) for at in place), None)
        else:
            self._one(place, self.job.parameters.case(index))

    def at_once(self, part: Box, wanted: Array | None) -> None:
        """Compute a part of the box in one call; in two halves where that fails."""
        if wanted is not None and not wanted[part].all():
            if wanted[part].any():
                self._halves(part, wanted)
            return
        spans = tuple(
            slice(span.start + inner.start, span.start + inner.stop)
            for span, inner in zip(self.box, part, strict=True)
        )
        try:
            self._write(part, self.job.parameters.mesh(spans))
            self.state[part] = DONE
        except Exception as error:
            if self.state[part].size > 1:
                self._halves(part, wanted)
            else:
                self._failed(tuple(inner.start for inner in part), error)

    def _halves(self, part: Box, wanted: Array | None) -> None:
        """Compute both halves of a part, cut across its longest axis."""
        sizes = [span.stop - span.start for span in part]
        axis = int(np.argmax(sizes))
        middle = part[axis].start + sizes[axis] // 2
        for half in (slice(part[axis].start, middle), slice(middle, part[axis].stop)):
            self.at_once((*part[:axis], half, *part[axis + 1 :]), wanted)

    def _one(self, place: tuple[int, ...], given: Mapping[str, object]) -> None:
        try:
            self._write(place, given)
            self.state[place] = DONE
        except Exception as error:
            self._failed(place, error)

    def _write(self, place: Any, given: Mapping[str, Any]) -> None:
        returned = called(self.job, given)
        found = returned.variables
        if self.job.broadcasts:
            found = self._over_the_box(found, self.state[place].shape)
        else:
            self.schema.refuse_other_axes(returned)
        self.schema.put(self.arrays, place, found)

    def _over_the_box(
        self, found: Mapping[str, Outcome], shape: tuple[int, ...]
    ) -> dict[str, Outcome]:
        """Return results that do not depend on some parameters over all of them."""
        expanded = {}
        for name, item in found.items():
            rest = item.values.shape[len(shape) :]
            sizes = zip(item.values.shape, shape, strict=False)
            fits = item.values.ndim >= len(shape) and all(size in (1, one) for size, one in sizes)
            values = np.broadcast_to(item.values, (*shape, *rest)) if fits else item.values
            expanded[name] = item._replace(values=values)
        return expanded

    def _failed(self, place: tuple[int, ...], error: Exception) -> None:
        self.state[place] = FAILED
        index = int(np.ravel_multi_index(place, self.state.shape))
        self.failures.append((index, failure(error)))


def called(job: Job, given: Mapping[str, Any]) -> Outcomes:
    """Return what the function returns for parameters.

    Raises:
        ArgumentError: a parameter is not finite, which samples may be.
        Exception: what the function raises.
    """
    for name, value in given.items():
        if not isinstance(value, str) and not _is_finite(value):
            raise ArgumentError(f"{name} is not finite: its distribution has no such quantile")
    try:
        returned = job.function(**given)
    except SystemExit as error:
        raise CardanError(
            f"the function ends its process (SystemExit: {error}); let it raise an error"
        ) from error
    return outcomes_of(returned, job.units)


def failure(error: BaseException) -> str:
    """Return type and message of an error as they are kept."""
    try:
        said = str(error)
    except Exception:  # Its own method fails.
        said = "no message"
    # Names of files may hold what no text file can.
    said = said.encode("utf-8", "backslashreplace").decode()
    return f"{type(error).__name__}: {said}"[:_LONGEST]


def _is_finite(value: Any) -> bool:
    if isinstance(value, np.ndarray) and value.dtype.kind == "U":
        return True
    return bool(np.isfinite(value).all())


def entry(values: Array, place: Sequence[int]) -> Any:
    """Return the entry of an array that broadcasts, as a plain number or word."""
    return values[
        tuple(at if size > 1 else 0 for at, size in zip(place, values.shape, strict=True))
    ].item()
