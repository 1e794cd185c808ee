"""Workers: blocks of samples divided among processes.

Threads would share Python's interpreter lock, and a block is hundreds of short operations on arrays
that fit into the cache, each of which needs it: two threads were measured to be no faster than one.
Forked processes share what is known, and only results are copied.
"""

from __future__ import annotations

import multiprocessing
import sys
from collections.abc import Callable, Sequence
from multiprocessing.connection import Connection
from typing import Any, TypeVar

from ..errors import CardanError

_Result = TypeVar("_Result")

_FEWEST_PER_WORKER = 4
"""Blocks from which on a worker pays: starting it and copying its results takes about one."""


def can_fork() -> bool:
    """Return whether this process can fork others reliably, which on macOS none can."""
    if sys.platform == "darwin" or "fork" not in multiprocessing.get_all_start_methods():
        return False
    return not multiprocessing.current_process().daemon


def in_order(tasks: Sequence[Callable[[], _Result]], workers: int) -> list[_Result]:
    """Return the results of tasks, in their order, whoever computed them.

    The first share is done here, the others by forked processes.

    Args:
        tasks: what to call. Apart from what they return, nothing that they do in a worker remains.
        workers: greatest number of processes, this one included.

    Raises:
        CardanError: a worker was lost.
        Exception: what the first task that fails raises.
    """
    shares = _shares(len(tasks), workers) if can_fork() else [range(len(tasks))]
    context: Any = multiprocessing.get_context("fork") if len(shares) > 1 else None
    started: list[tuple[Any, Connection]] = []
    try:
        for share in shares[1:]:
            mine, theirs = context.Pipe(duplex=False)
            process = context.Process(target=_work, args=(tasks, share, theirs), daemon=True)
            process.start()
            theirs.close()
            started.append((process, mine))
        results = [tasks[index]() for index in shares[0]]
        for _, connection in started:
            results += _received(connection)
        return results
    finally:
        for process, connection in started:
            connection.close()
            process.terminate()
            process.join()


def _shares(count: int, workers: int) -> list[range]:
    """Return indices of tasks for each worker: as many workers as have enough to do."""
    used = max(1, min(workers, count // _FEWEST_PER_WORKER))
    ends = [round(count * share / used) for share in range(used + 1)]
    return [range(*ends[share : share + 2]) for share in range(used)]


def _work(tasks: Sequence[Callable[[], object]], share: range, connection: Connection) -> None:
    """Do some tasks in a process of their own, and send their results or the first error."""
    try:
        answer: tuple[bool, object] = True, [tasks[index]() for index in share]
    except Exception as error:
        answer = False, error
    connection.send(answer)
    connection.close()


def _received(connection: Connection) -> list[Any]:
    """Return what a worker sends, or raise its error."""
    try:
        is_done, answer = connection.recv()
    except EOFError as error:
        raise CardanError(
            "a worker process was lost, perhaps for want of memory; use fewer workers"
        ) from error
    if not is_done:
        raise answer
    results: list[Any] = answer
    return results
