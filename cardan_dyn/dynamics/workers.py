"""Workers: blocks of samples divided among processes.

Threads would share Python's interpreter lock, and a block is hundreds of short operations on arrays
that fit into the cache, each of which needs it: two threads were measured to be no faster than one.
Forked processes share what is known, and write their results where those of all are.
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


def shares_of(count: int, workers: int) -> list[range]:
    """Return which blocks each worker does: as many workers as have enough to do.

    Args:
        count: number of blocks.
        workers: greatest number of processes, this one included.
    """
    used = max(1, min(workers, count // _FEWEST_PER_WORKER)) if can_fork() else 1
    ends = [round(count * share / used) for share in range(used + 1)]
    return [range(*ends[share : share + 2]) for share in range(used)]


def in_order(work: Callable[[range], _Result], shares: Sequence[range]) -> list[_Result]:
    """Return the results of shares of the work, in their order, whoever computed them.

    The first share is done here, the others by forked processes.

    Args:
        work: does a share. Apart from what it returns, and what it writes to shared memory, nothing
            that it does in a worker remains.
        shares: indices of blocks, from `shares_of`.

    Raises:
        CardanError: a worker was lost.
        Exception: what the first block that fails raises.
    """
    context: Any = multiprocessing.get_context("fork") if len(shares) > 1 else None
    started: list[tuple[Any, Connection]] = []
    try:
        for share in shares[1:]:
            mine, theirs = context.Pipe(duplex=False)
            process = context.Process(target=_work, args=(work, share, theirs), daemon=True)
            process.start()
            theirs.close()
            started.append((process, mine))
        results = [work(shares[0])]
        results += [_received(connection) for _, connection in started]
        return results
    finally:
        for process, connection in started:
            connection.close()
            process.terminate()
            process.join()


def _work(work: Callable[[range], object], share: range, connection: Connection) -> None:
    """Do a share in a process of its own, and send its result or the first error."""
    try:
        answer: tuple[bool, object] = True, work(share)
    except Exception as error:
        answer = False, error
    connection.send(answer)
    connection.close()


def _received(connection: Connection) -> Any:
    """Return what a worker sends, or raise its error."""
    try:
        is_done, answer = connection.recv()
    except EOFError as error:
        raise CardanError(
            "a worker process was lost, perhaps for want of memory; use fewer workers"
        ) from error
    if not is_done:
        raise answer
    return answer
