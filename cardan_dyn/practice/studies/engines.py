"""Engines: where chunks are computed: here, by any executor, or by a cluster of Dask.

An engine takes chunks while it has room, and gives back those that are done, in any order. None of
them holds more than a few chunks at a time, so that memory does not grow with the number of cases.
"""

from __future__ import annotations

import concurrent.futures as futures
import hashlib
import math
from abc import abstractmethod
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from time import monotonic
from typing import Any, NamedTuple

from ..._version import __version__
from ...kit.arrays import Array
from ...kit.errors import CardanError
from .chunk import Box, Computed, compute

_PER_WORKER = 3
"""Chunks that an engine holds for each worker: one that is computed, and two that wait for it."""
_PATIENCE = 1.0
"""How long an engine waits before it looks whether all is well [s]."""
_JOINED_AFTER = 60.0
"""How long a cluster may take until its first worker is there [s]."""


class Task(NamedTuple):
    """A chunk to be computed.

    Attributes:
        box: which cases.
        wanted: which of them, of the shape of the box; all if None.
        alone: compute each by a copy of the function of its own.
    """

    box: Box
    wanted: Array | None = None
    alone: bool = False


Finished = tuple[Task, "Computed | Exception"]


class Engine:
    """Computes chunks.

    Attributes:
        room: how many chunks it holds at most.
        note: where else it can be watched; empty if nowhere.
    """

    room: int
    note: str = ""

    @abstractmethod
    def start(self, task: Task) -> None:
        """Take a chunk."""

    @abstractmethod
    def finished(self) -> Iterable[Finished]:
        """Return chunks that are done, after a while none; errors are those of workers."""

    def stop(self) -> None:
        """Give up what was not begun."""


class Here(Engine):
    """Computes chunks in this process, one after the other."""

    room = 1

    def __init__(self, job: bytes) -> None:
        self._job = job
        self._tasks: list[Task] = []

    def start(self, task: Task) -> None:
        """Take a chunk; see `Engine`."""
        self._tasks.append(task)

    def finished(self) -> Iterator[Finished]:
        """Compute what was taken; see `Engine`."""
        while self._tasks:
            task = self._tasks.pop()
            yield task, compute(self._job, task.box, task.wanted, alone=task.alone)


class OfExecutor(Engine):
    """Lets an executor of `concurrent.futures` compute chunks."""

    def __init__(self, executor: futures.Executor, job: bytes) -> None:
        self._workers = workers_of(executor)
        self.room = _PER_WORKER * self._workers
        self._executor, self._job, self._key = executor, job, _key(job)
        self._begun = 0
        self._running: dict[Any, Task] = {}

    def start(self, task: Task) -> None:
        """Take a chunk; see `Engine`."""
        # Nothing reaches each worker of an executor once: those first asked get the job, and who
        # has not got it says so.
        self._begun += 1
        self._submit(self._job if self._begun <= self._workers else None, task)

    def _submit(self, job: bytes | None, task: Task) -> None:
        try:
            future = self._executor.submit(_compute_received, self._key, job, task)
        except RuntimeError as error:
            raise _lost_workers(error) from error
        self._running[future] = task

    def finished(self) -> Iterator[Finished]:
        """Return chunks that are done; see `Engine`."""
        done, _ = futures.wait(
            self._running, timeout=_PATIENCE, return_when=futures.FIRST_COMPLETED
        )
        for future in done:
            task = self._running.pop(future)
            try:
                found = future.result()
            except futures.BrokenExecutor as error:
                raise _lost_workers(error) from error
            except Exception as error:
                yield task, error
                continue
            if found is None:
                self._submit(self._job, task)
            else:
                yield task, found

    def stop(self) -> None:
        """Give up what was not begun; see `Engine`."""
        for future in self._running:
            future.cancel()


def workers_of(executor: futures.Executor) -> int:
    """Return the number of workers of an executor; one where it does not say it."""
    return getattr(executor, "_max_workers", None) or 1


_RECEIVED: dict[str, bytes] = {}
"""The last job that this worker of an executor was sent, by its key."""


def _compute_received(key: str, job: bytes | None, task: Task) -> Computed | None:
    """Return the results of a chunk; None if the job was not sent, and has to be."""
    if job is None:
        job = _RECEIVED.get(key)
        if job is None:
            return None
    elif key not in _RECEIVED:
        _RECEIVED.clear()
        _RECEIVED[key] = job
    return compute(job, task.box, task.wanted, alone=task.alone)


def _key(job: bytes) -> str:
    """Return what tells a job from others."""
    return hashlib.sha256(job).hexdigest()


def _lost_workers(error: Exception) -> CardanError:
    return CardanError(
        f"the executor has lost its workers, or was shut down ({error}); what is finished is kept: "
        "run the study again with another executor, or with a Dask client, which replaces workers"
    )


class OfDask(Engine):
    """Lets a cluster of Dask compute chunks, which gives those of lost workers to others."""

    def __init__(self, client: Any, job: bytes) -> None:
        self._client = client
        self._refuse_unfit_workers()
        self.note = f"Dask's dashboard: {client.dashboard_link}" if client.dashboard_link else ""
        # A task and not a scattered value: the scheduler can make it again where workers are lost,
        # and each worker fetches it once.
        self._job = client.submit(_received, job, key=f"cardan-dyn-study-{_key(job)}", pure=True)
        self._running: dict[Any, Task] = {}
        self._threads, self._counted = 1, -math.inf

    @property
    def room(self) -> int:  # type: ignore[override]
        """How many chunks it holds at most: workers come and go."""
        if monotonic() - self._counted > _PATIENCE:
            with self._reaching():
                self._threads = threads_of(self._client)
            self._counted = monotonic()
        return _PER_WORKER * self._threads

    def _refuse_unfit_workers(self) -> None:
        """Refuse workers on which a chunk cannot be computed, before any is."""
        from distributed import TimeoutError as NoneThere

        with self._reaching():
            try:
                self._client.wait_for_workers(1, timeout=_JOINED_AFTER)
            except NoneThere as error:
                raise CardanError(
                    f"no worker has joined {self._client.scheduler.address} for {_JOINED_AFTER:g} "
                    "s: start one, or compute here, without client="
                ) from error
            told = self._client.run(eval, _ASKED, on_error="return")
        for address, answer in told.items():
            if not isinstance(answer, str):
                raise CardanError(
                    f"the worker {address} cannot import cardan_dyn ({answer}); install there what "
                    'is installed here: pip install "cardan-dyn[study]"'
                )
            if answer != __version__:
                raise CardanError(
                    f"the worker {address} has cardan_dyn {answer}, and here is {__version__}; "
                    "results would not be of one kind: install one version everywhere"
                )

    def start(self, task: Task) -> None:
        """Take a chunk; see `Engine`."""
        with self._reaching():
            future = self._client.submit(
                compute, self._job, task.box, task.wanted, alone=task.alone, pure=False
            )
        self._running[future] = task

    def finished(self) -> Iterator[Finished]:
        """Return chunks that are done; see `Engine`."""
        from distributed import TimeoutError as NoneDone
        from distributed import wait

        with self._reaching(), suppress(NoneDone):
            wait(list(self._running), timeout=_PATIENCE, return_when="FIRST_COMPLETED")
        for future in [future for future in self._running if future.done()]:
            if future.status == "cancelled":
                raise self._gone()
            task = self._running.pop(future)
            try:
                # What is lost on the way here, the scheduler has computed once more.
                yield task, future.result()
            except futures.CancelledError as error:
                raise self._gone() from error
            except Exception as error:
                yield task, error
            future.release()

    def stop(self) -> None:
        """Give up what was not begun; see `Engine`."""
        with suppress(Exception):
            self._client.cancel(list(self._running))

    @contextmanager
    def _reaching(self) -> Iterator[None]:
        """Say what to do where the scheduler cannot be reached."""
        if self._client.status not in ("running", "newly-created"):
            raise self._gone()
        try:
            yield
        except (OSError, futures.CancelledError) as error:
            raise self._gone() from error

    def _gone(self) -> CardanError:
        return CardanError(
            f"Dask's scheduler is out of reach ({self._client.status}); what is finished is kept: "
            "start another one, and run the study again with a client of it"
        )


def threads_of(client: Any) -> int:
    """Return the number of threads of a Dask cluster's workers, one before any has joined."""
    return max(1, sum(client.nthreads().values()))


def _received(job: bytes) -> bytes:
    """Return a job on a worker, where chunks then find it."""
    return job


_ASKED = "__import__('cardan_dyn.practice.studies.chunk') and __import__('cardan_dyn').__version__"
"""What a worker is asked; `eval` is known everywhere, and nothing of ours may be."""
