"""Threads: pieces of work done beside each other, on all cores that this process may use.

Compiled programs and NumPy's operations on large arrays let other threads run meanwhile. What is
found does not depend on how many threads there are: pieces read what is known when they begin, and
those that have to learn more are done in turn.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar, copy_context
from threading import Thread
from typing import TypeVar

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")

_given: ContextVar[int] = ContextVar("_given", default=0)
_is_beside: ContextVar[bool] = ContextVar("_is_beside", default=False)


def cores() -> int:
    """Return how many cores work may use: all that this process may, unless some were given."""
    if given := _given.get():
        return given
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def on_cores(count: int) -> Iterator[None]:
    """Let work use so many cores."""
    before = _given.set(count)
    try:
        yield
    finally:
        _given.reset(before)


def in_turn() -> None:
    """Say that what follows changes what others read, which nothing does beside other work."""
    if _is_beside.get():
        raise _NotBesideError


def in_threads(
    work: Callable[[_Item], _Result],
    items: Sequence[_Item],
    tell: Callable[[int], None] = lambda done: None,
) -> list[_Result]:
    """Return what work gives for each item, in their order; this thread does its part.

    Items that call `in_turn` are begun again: the first of them alone, then the others beside each
    other as before, and so on with twice as many alone each time.

    Args:
        work: does an item. NumPy warns there of what it does here, and work within starts no
            threads itself.
        items: what there is to do; each is worth starting a thread for.
        tell: is called with how many are done.

    Raises:
        BaseException: what the first item raises of those that fail. No others are begun then, nor
            once this is interrupted; those that were begun are waited for.
    """
    if len(items) == 1:  # Nothing is beside it.
        result = work(items[0])
        tell(1)
        return [result]
    results: dict[int, _Result] = {}
    left, alone = list(range(len(items))), 1
    while left:
        waiting = _beside(work, items, left, results, tell)
        for index in waiting[:alone]:
            results[index] = work(items[index])
            tell(len(results))
        left, alone = waiting[alone:], 2 * alone
    return [results[index] for index in range(len(items))]


class _NotBesideError(BaseException):
    """Work has to be done in turn."""


def _beside(
    work: Callable[[_Item], _Result],
    items: Sequence[_Item],
    left: Sequence[int],
    results: dict[int, _Result],
    tell: Callable[[int], None],
) -> list[int]:
    """Do the items that are left, by their indices, and return those that have to be alone."""
    rest = iter(left)  # Of all threads, each of which takes the next one.
    waiting: list[int] = []
    failed: dict[int, BaseException] = {}

    def run(tell: Callable[[int], None] = lambda done: None) -> None:
        _is_beside.set(True)
        _given.set(1)
        for index in rest:
            try:
                results[index] = work(items[index])
                tell(len(results))
            except _NotBesideError:
                waiting.append(index)
            except BaseException as error:
                failed[index] = error
                list(rest)

    count = min(cores(), len(left)) - 1
    others = [Thread(target=copy_context().run, args=(run,)) for _ in range(count)]
    try:
        for thread in others:
            thread.start()
        copy_context().run(run, tell)
    finally:
        list(rest)
        for thread in others:
            if thread.is_alive():
                thread.join()
    if failed:
        raise failed[min(failed)]
    return sorted(waiting)
