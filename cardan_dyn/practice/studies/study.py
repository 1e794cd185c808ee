"""Study: a function over many parameters, computed chunk by chunk and kept as it is computed."""

from __future__ import annotations

import concurrent.futures as futures
import math
import warnings
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import ExitStack, closing, contextmanager
from multiprocessing import current_process
from typing import TYPE_CHECKING, Any

import numpy as np

from ...kit.arrays import Array
from ...kit.checks import described, flag, mapping, text, whole
from ...kit.errors import ArgumentError, CardanError, choices
from ...kit.threads import cores
from .chunk import FAILED, Box, Computed, Job, entry, failure, missing, packed, unpacked
from .chunking import MOST_BYTES, boxes, chunk_shape, count, filled, slabs
from .engines import Engine, Here, OfDask, OfExecutor, Task, threads_of, workers_of
from .fingerprint import descriptions, fingerprint
from .measuring import first_schema, refuse_not_vectorized, seconds_per_case
from .outcomes import Schema
from .parameters import Parameters, checked_parameters
from .plan import StudyPlan, in_bytes, in_words
from .progress import Told, shown
from .store import Damage, Store, of_cases, refuse_different, within
from .sweeps import Sweeps

if TYPE_CHECKING:
    import os

    import pandas
    import xarray

    from .looking import StudyPlot

_MOST_CASES = 100_000_000
"""Cases from which on a study is taken for a mistake, unless it says that it is not."""
_STARTED = 6.0
"""Time of all cases above which processes are started for them [s]: two or three seconds each."""


class Study:
    """A function over named parameters; `cardan_dyn.study` makes it.

    Attributes:
        parameters: what varies.
        store: where results are kept.
    """

    def __init__(
        self,
        job: Job,
        store: Store,
        *,
        client: Any,
        executor: futures.Executor | None,
        workers: int | None,
        chunk: Mapping[str, int],
        name: str,
    ) -> None:
        self.parameters = job.parameters
        self.store = store
        self._job, self._trial, self._name, self._chunk_given = job, job, name, chunk
        self._client, self._executor, self._workers = client, executor, workers
        self._seconds = math.nan
        self._told: dict[str, Any] | None = None
        self._damaged: list[Damage] = []
        self._chunk: tuple[int, ...] | None = None

    def __repr__(self) -> str:
        return f"<Study of {self._name}: {self.parameters!r}, kept in {self.store}>"

    def plan(self) -> StudyPlan:
        """Return what is computed and how, and what it takes, after timing a few cases.

        Raises:
            CardanError: no case succeeds, the store is that of another study, or the function
                cannot be sent to workers.
        """
        self._prepare()
        schema, chunk = self._schema, self._chunk_shape
        done, failed = self._count()
        left = self.parameters.count - done
        if left and math.isnan(self._seconds):
            self._time()
        where, workers = self._where(left)
        seconds = left * self._seconds / workers if left else 0.0
        held = schema.bytes_per_case * math.prod(chunk) * (3 * workers if workers > 1 else 1)
        dims = self.parameters.dims
        return StudyPlan(
            cases=self.parameters.count,
            done=done,
            failed=failed,
            damaged=self._damaged_cases,
            shape=dict(zip(dims, self.parameters.shape, strict=True)),
            chunk=dict(zip(dims, chunk, strict=True)),
            chunks=count(self.parameters.shape, chunk),
            how=self._how(chunk),
            seconds_per_case=self._seconds if left else math.nan,
            workers=workers,
            where=where,
            seconds=seconds,
            memory=held,
            disk=schema.bytes_per_case * self.parameters.count,
            results=in_words(schema),
            store=str(self.store),
        )

    def run(self, *, retry: bool = False, progress: bool | Told | None = None) -> Study:
        """Compute what is missing, and return the study.

        All that is there is read first. What is damaged, or was lost after it was written, is
        computed again, and a warning says what it was.

        Args:
            retry: compute the cases that failed, and these alone.
            progress: show a bar; in terminals and notebooks if None. Or a function that takes the
                numbers of cases that are done and that failed.

        Raises:
            CardanError: no case succeeds, or the store, workers or a scheduler fail; the message
                says what to do. What is finished is kept.
            KeyboardInterrupt: Ctrl-C; what is finished is kept.
        """
        retry = flag("retry", retry)
        self._prepare()
        self._told = None  # Others may have gone on with it.
        there = self._read()
        if retry and there is None:
            raise CardanError("nothing was computed, so that nothing failed: run() without retry")
        if there is not None and self._damaged:
            self.store.mend(there, self.parameters, self._damaged)
            again = "this run writes it anew"
            if self._damaged_cases:
                again = f"{'run()' if retry else 'this run'} makes it again"
            warnings.warn(f"{self._damage_in_words()}; {again}", stacklevel=2)
            self._damaged = []
        done, failed = self._count()
        left = failed if retry else self.parameters.count - done
        if there is None:
            self._make()
        elif tuple(of_cases(there)) != self.parameters.shape:
            self.store.extend(there, self.parameters)
            self._told = self.store.found()
        if left:
            self.store.open(self._told or {}, writable=True)
        if not left:
            return self
        total, done = self.parameters.count, done - (failed if retry else 0)
        with ExitStack() as stack:
            engine = stack.enter_context(self._engine(left))
            told = stack.enter_context(shown(progress, total, done, engine.note))
            failed = 0 if retry else failed
            every = stack.enter_context(closing(self._computed(engine, self._tasks(retry))))
            for computed in every:
                done += int(np.count_nonzero(computed.state))
                failed += len(computed.failures)
                told(done, failed)
        return self

    def _computed(self, engine: Engine, tasks: Iterator[Task]) -> Generator[Computed, None, None]:
        """Iterate over chunks as they are computed and written."""
        running, more, alone = 0, True, False
        # Chunks whose workers were lost again and again. Some of them only waited at the same
        # workers: in the end each is tried alone, when nothing else can be the cause.
        suspects: list[Task] = []
        try:
            while more or running or suspects:
                while more and running < engine.room:
                    task = next(tasks, None)
                    more = task is not None
                    if task is not None:
                        engine.start(task)
                        running += 1
                if suspects and not more and not running:
                    engine.start(suspects.pop())
                    running, alone = 1, True
                for finished, found in engine.finished() if running else ():
                    running -= 1
                    if _is_lost(found) and not alone:
                        suspects.append(finished)
                    else:
                        yield self._kept(finished, found)
        except KeyboardInterrupt:
            for finished, found in engine.finished():  # What was done meanwhile is kept.
                self._kept(finished, found)
            raise
        finally:
            engine.stop()

    @property
    def dataset(self) -> xarray.Dataset:
        """All results that are there, with parameters as coordinates; read when they are used.

        Cases that failed or are missing are NaN; `state` says which: 1 is done, 2 failed.

        Raises:
            CardanError: nothing was computed, or the store cannot be read or is damaged.
        """
        told = self._read()
        if told is None:
            raise CardanError("nothing was computed yet: run() the study")
        self._refuse_damage()
        return self.store.dataset(told)

    @property
    def plot(self) -> StudyPlot:
        """Figures: `study.plot("force")`, `study.plot.tornado("force")`; they need extra `viz`."""
        from .looking import StudyPlot  # Imported here: few scripts draw.

        return StudyPlot(self)

    @property
    def failures(self) -> pandas.DataFrame:
        """The cases that failed: a row each, with index, parameters, type and message.

        Raises:
            CardanError: the store cannot be read, or is damaged.
        """
        import pandas

        self._read()
        self._refuse_damage()
        rows = []
        for box, states in self._states():
            found = self.store.failures(box, states)
            mesh = self.parameters.mesh(box) if found else {}
            for place, said in found:
                kind, _, message = said.partition(": ")
                starts = zip(self.parameters.dims, box, place, strict=True)
                row = {f"{dim}_index": span.start + at for dim, span, at in starts}
                row |= {name: entry(values, place) for name, values in mesh.items()}
                rows.append(row | {"type": kind, "message": message})
        names = [f"{dim}_index" for dim in self.parameters.dims]
        return pandas.DataFrame(rows, columns=[*names, *self.parameters.units, "type", "message"])

    @property
    def damage(self) -> pandas.DataFrame:
        """What was written and is not there as it was: a row for each array and chunk.

        Everything is read for it, once: by the first of `plan`, `dataset`, `failures` and this,
        and by every `run`, which computes it again. `cases` is 0 where nothing has to be computed.

        Raises:
            CardanError: the store cannot be read.
        """
        import pandas

        self._read()
        rows = [(item.array, item.cases, self._place(item), item.message) for item in self._damaged]
        return pandas.DataFrame(rows, columns=["array", "cases", "place", "message"])

    def _place(self, item: Damage) -> str:
        """Return which cases are lost, in words."""
        spans = zip(self.parameters.dims, item.box or (), strict=False)
        return ", ".join(f"{dim} {span.start} to {span.stop - 1}" for dim, span in spans)

    @property
    def _damaged_cases(self) -> int:
        """Number of cases that have to be computed again, since they are damaged."""
        found: dict[str, int] = {}
        for item in self._damaged:
            found[str(item.box)] = max(item.cases, found.get(str(item.box), 0))
        return sum(found.values())

    def _damage_in_words(self) -> str:
        first = self._damaged[0]
        more = f" and {len(self._damaged) - 1} more" if len(self._damaged) > 1 else ""
        where = " ".join(filter(None, (first.array, self._place(first))))
        count = self._damaged_cases
        lost = f"in {count} cases" if count else "beside its cases"
        return f"{self.store} is damaged {lost} ({where}: {first.message}{more})"

    def _refuse_damage(self) -> None:
        """Refuse to show what is not what was computed."""
        if self._damaged:
            raise CardanError(
                f"{self._damage_in_words()}; study.damage lists all of it, run() "
                f"{'computes it again' if self._damaged_cases else 'writes it anew'}"
            )

    def _kept(self, task: Task, found: Computed | Exception) -> Computed:
        """Write a chunk, and return it; where workers were lost again and again, that failed."""
        if isinstance(found, Exception):
            if not _is_lost(found):
                raise CardanError(
                    f"a worker cannot compute chunks: {failure(found)}. Workers need the packages "
                    "that are installed here, in the same versions; what is finished is kept"
                ) from found
            found = self._lost(task, found)
        self.store.put(task.box, found)
        return found

    def _lost(self, task: Task, error: Exception) -> Computed:
        """Return a chunk that ends each worker that computes it, as failures."""
        shape = tuple(span.stop - span.start for span in task.box)
        state = np.full(shape, FAILED, np.int8)
        if task.wanted is not None:
            state[~task.wanted] = 0
        said = failure(error).split("\n")[0]
        lost = [(int(index), said) for index in np.flatnonzero(state)]
        return Computed(self._schema.empty(shape), state, lost)

    # What there is, and what is left.

    def _states(self) -> Iterator[tuple[Box, Array]]:
        """Iterate over chunks and the states of their cases."""
        told = self._read()
        if told is not None:
            for slab in slabs(of_cases(told), told["chunk"], MOST_BYTES):  # A state is a byte.
                states = self.store.states(slab, self._damaged)
                for box in boxes(of_cases(told), told["chunk"], slab):
                    yield box, states[within(box, slab)]

    def _count(self) -> tuple[int, int]:
        """Return the number of cases that were computed, and of those that failed."""
        every = [np.bincount(states.ravel(), minlength=3) for _, states in self._states()]
        _, done, failed = np.sum(every, axis=0, dtype=int) if every else (0, 0, 0)
        return int(done + failed), int(failed)

    def _tasks(self, retry: bool) -> Iterator[Task]:
        """Iterate over what is to be computed."""
        for box, states in self._states():
            wanted = states == FAILED if retry else states == 0
            if wanted.any():
                yield Task(box, None if wanted.all() and not retry else wanted, retry)

    # What is known before.

    def _prepare(self) -> None:
        """Find out what cases return and how a chunk is computed, or read it from the store."""
        if self._chunk is not None:
            return
        # What is tried and timed is a copy: the function is sent as it came.
        self._trial = unpacked(packed(self._job))
        told = self._read()
        if told is not None:
            self._use(Schema.from_json(told["schema"]))
            self._chunk = tuple(told["chunk"])
            return
        self._use(first_schema(self._trial))
        if self._job.broadcasts and not isinstance(self._job.function, Sweeps):
            refuse_not_vectorized(self._job)
        self._chunk = self._chosen_chunk()

    def _use(self, schema: Schema) -> None:
        known = [*schema.variables, *schema.coordinates]
        if unknown := sorted(set(self._job.units) - set(known)):
            raise ArgumentError(
                f"units[{unknown[0]!r}]: no such result; results: {choices(known, unknown[0])}"
            )
        self._job, self._trial = (job._replace(schema=schema) for job in (self._job, self._trial))

    def _read(self) -> dict[str, Any] | None:
        """Return what is said of the study in the store, which is this one; None without any.

        Raises:
            CardanError: it is another one, or cannot be read.
        """
        if self._told is None:
            told = self.store.found()
            if told is not None:
                refuse_different(told, self._name, self._prints, self.parameters, self.store)
                self._damaged = self.store.damage(told)
            self._told = told
        return self._told

    @property
    def _prints(self) -> dict[str, str]:
        prints = fingerprint(self._job.function)
        return prints | {f"the unit of {name}": unit for name, unit in self._job.units.items()}

    @property
    def _schema(self) -> Schema:
        schema = self._job.schema
        if schema is None:
            raise RuntimeError("the study was not prepared")
        return schema

    @property
    def _chunk_shape(self) -> tuple[int, ...]:
        if self._chunk is None:
            raise RuntimeError("the study was not prepared")
        return self._chunk

    def _chosen_chunk(self) -> tuple[int, ...]:
        given, parameters = self._chunk_given, self.parameters
        if given:
            sizes = zip(parameters.dims, parameters.shape, strict=True)
            return tuple(min(given.get(dim, size), size) for dim, size in sizes)
        self._time()
        size, first = self._schema.bytes_per_case, self._taken_at_once()[::-1]
        return chunk_shape(parameters.shape, self._seconds, size, first)

    def _time(self) -> None:
        """Measure how long a case takes."""
        self._seconds = seconds_per_case(self._trial, self._taken_at_once())

    def _taken_at_once(self) -> list[int]:
        """Return the dimensions that one call takes."""
        function, blocks = self._job.function, self.parameters.blocks
        if isinstance(function, Sweeps):
            swept = [function.swept(list(block.units)) == list(block.units) for block in blocks]
            return [axis for axis, is_swept in enumerate(swept) if is_swept]
        return list(range(len(blocks))) if self._job.broadcasts else []

    def _make(self) -> None:
        """Make the store."""
        needed = self._schema.bytes_per_case * self.parameters.count
        free = self.store.free
        if needed > free:
            raise CardanError(
                f"{self.store}: all results may take {in_bytes(needed)}, and {in_bytes(free)} are "
                "free; name a store with more room, or want less of each case"
            )
        function = self._job.function
        self.store.make(
            self._name,
            self.parameters,
            self._schema,
            self._chunk_shape,
            self._prints,
            descriptions(function),
        )
        self._told = self.store.found()

    # Where it is computed.

    def _how(self, chunk: tuple[int, ...]) -> str:
        function = self._job.function
        if isinstance(function, Sweeps):
            return function.plan(self.parameters, chunk)
        if self._job.broadcasts:
            return "one call of the function with arrays"
        calls = math.prod(chunk)
        return f"{'one call' if calls == 1 else f'a loop over {calls} calls'} of {self._name}"

    def _where(self, left: int) -> tuple[str, int]:
        """Return what computes, in words, and the number of its workers."""
        if self._client is not None:
            workers = threads_of(self._client)
            return (
                f"{workers} threads of the Dask cluster {self._client.scheduler.address}",
                workers,
            )
        if self._executor is not None:
            workers = workers_of(self._executor)
            return f"{type(self._executor).__name__} of {workers} workers", workers
        own = cores() if self._workers is None else self._workers
        if self._workers is None and left * self._seconds < _STARTED:
            return "this process, since it does not take long", 1
        return ("this process", 1) if own == 1 else (f"{own} processes of this machine", own)

    @contextmanager
    def _engine(self, left: int) -> Iterator[Engine]:
        """Return what computes, until the study is done or fails."""
        job = packed(self._job)
        if self._client is not None:
            yield OfDask(self._client, job)
            return
        if self._executor is not None:
            yield OfExecutor(self._executor, job)
            return
        if self._workers is None and math.isnan(self._seconds):
            self._time()
        _, workers = self._where(left)
        if workers == 1:
            yield Here(job)
            return
        with local_client(workers) as client:
            yield OfDask(client, job)


def _is_lost(found: object) -> bool:
    """Return whether Dask gave a chunk up, since its workers were lost again and again."""
    return type(found).__name__ == "KilledWorker"


def study(
    function: Callable[..., object],
    parameters: object,
    *,
    store: str | os.PathLike[str] | Any = None,
    client: Any = None,
    executor: futures.Executor | None = None,
    workers: int | None = None,
    chunk: int | Mapping[str, int] | None = None,
    vectorized: bool = False,
    units: Mapping[str, str] | None = None,
    most_cases: int = _MOST_CASES,
    storage_options: Mapping[str, Any] | None = None,
) -> Study:
    """Study a function of parameters: plan it, run it, go on with it, and look at its results.

    The function is called with a parameter by each name, and returns a number, an array, a mapping
    of names to these, or an `xarray.Dataset`, of the same names and shapes for all cases; what it
    raises is recorded and does not stop the others. `studies.Sweeps` is such a function, of a scene
    and what is wanted of it, that takes all cases of a chunk in one call.

    Results depend on the function, the parameters and the shape of the chunks, and not on who
    computes them, how many do, and in which order: to the last bit on machines of one kind. The
    shape of the chunks is chosen once, when a store is begun.

    Args:
        function: of the parameters; one that can be pickled, in scripts and notebooks any.
        parameters: names to values `(N,)`, or to pairs of these and a unit: the cases are their
            product. Or `studies.points`, `studies.samples`, or a list of these: the product of all
            of them. Long even axes are `studies.Line`.
        store: path or URL (`s3://…`, `memory://…`) of a Zarr store, in which what is finished
            stays; a run goes on with what is missing. In memory if None.
        client: a `dask.distributed.Client` that computes.
        executor: of `concurrent.futures`, likewise.
        workers: without these, processes on this machine: as many as it has cores if None, or none
            but this one where all takes a few seconds; 1 is this one.
        chunk: cases of a chunk, or dimensions to sizes, those left out as a whole; cases of a
            second if None. A store that was begun keeps its own.
        vectorized: the function takes arrays that broadcast, one axis for each dimension of the
            study, and returns arrays that begin with their common shape.
        units: names of results to units, where these do not say them.
        most_cases: from how many cases on it is taken for a mistake.
        storage_options: of the file system of a URL, see fsspec.

    Raises:
        ArgumentError: parameters are empty, not finite or too many, or an argument is of no use.
        MissingExtraError: zarr, xarray, pandas or dask is not installed.
    """
    _refuse_missing()
    if not callable(function):
        raise ArgumentError(f"function is {described(function)}, expected a function of parameters")
    found = checked_parameters(parameters)
    limit = whole("most_cases", most_cases)
    if found.count > limit:
        sizes = " × ".join(f"{block.dim} {block.count:,}" for block in found.blocks)
        raise ArgumentError(
            f"{sizes} are {found.count:,} cases; take studies.samples of the parameters, fewer "
            f"values, or say most_cases={found.count} if all of them are meant"
        )
    if client is not None and executor is not None:
        raise ArgumentError("client and executor are given; name the one that computes")
    if client is not None and not hasattr(client, "scheduler"):
        raise ArgumentError(f"client is {described(client)}, expected a dask.distributed.Client")
    if executor is not None and not hasattr(executor, "submit"):
        raise ArgumentError(
            f"executor is {described(executor)}, expected one of concurrent.futures"
        )
    at_once = flag("vectorized", vectorized) or isinstance(function, Sweeps)
    if isinstance(function, Sweeps):
        function.refuse_unknown(found.units)
        function.refuse_units(found.units)
    given_units = {
        name: text(f"units[{name!r}]", unit) for name, unit in mapping("units", units).items()
    }
    return Study(
        Job(function, found, None, given_units, at_once),
        Store(store, storage_options),
        client=client,
        executor=executor,
        workers=None if workers is None else whole("workers", workers),
        chunk=_chunk_sizes(chunk, found),
        name=getattr(function, "__qualname__", None) or type(function).__name__,
    )


def _chunk_sizes(given: object, parameters: Parameters) -> dict[str, int]:
    """Return sizes of chunks along the dimensions that are given."""
    if given is None:
        return {}
    if isinstance(given, Mapping):
        sizes = {
            name: whole(f"chunk[{name!r}]", size) for name, size in mapping("chunk", given).items()
        }
        if unknown := set(sizes) - set(parameters.dims):
            raise ArgumentError(
                f"chunk[{min(unknown)!r}]: dimensions are {choices(parameters.dims, min(unknown))}"
            )
        return sizes
    shape = parameters.shape
    chunk = filled(shape, whole("chunk", given), reversed(range(len(shape))))
    return dict(zip(parameters.dims, chunk, strict=True))


@contextmanager
def local_client(workers: int) -> Iterator[Any]:
    """Return a Dask client of processes on this machine, which end with the context."""
    from distributed import Client, LocalCluster

    if getattr(current_process(), "_inheriting", False):
        raise CardanError(_UNGUARDED)
    with ExitStack() as stack:
        try:
            cluster = stack.enter_context(
                LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    processes=True,
                    host="127.0.0.1",
                    dashboard_address="127.0.0.1:0",
                    silence_logs=50,
                    preload=["cardan_dyn.practice.studies.preloaded"],
                )
            )
            client = stack.enter_context(Client(cluster))
        except (RuntimeError, OSError) as error:
            raise CardanError(
                f"worker processes cannot be started ({error}); {_UNGUARDED}"
            ) from error
        yield client


_UNGUARDED = (
    'processes begin by importing the script that starts them: put what it does under "if __name__ '
    "== '__main__':\", or compute in one process, workers=1"
)


def _refuse_missing() -> None:
    """Refuse to begin what would end for want of a package."""
    from importlib.util import find_spec

    for package in ("zarr", "xarray", "pandas", "distributed", "threadpoolctl"):
        if find_spec(package) is None:
            raise missing(package)
