"""Plan: what a study computes, and what that takes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from .outcomes import Schema


@dataclass(frozen=True, repr=False)
class StudyPlan:
    """What a study computes, and what that takes; `print` shows it.

    Attributes:
        cases: number of them.
        done: number of those that are in the store.
        failed: number of those among them that failed, which are not computed again by themselves.
        damaged: number of those that were in the store and are computed again, since they cannot
            be read as they were written.
        shape: of the cases, by dimension.
        chunk: of a chunk, likewise.
        chunks: number of them.
        how: how a chunk is computed, in words.
        seconds_per_case: measured on this machine, by one process [s]; nan if nothing is left.
        workers: processes or threads that share the work.
        where: what computes, in words.
        seconds: estimate of the time that is left [s].
        memory: greatest size of the results of the chunks that are held at a time [bytes].
        disk: size of all results before they are compressed [bytes].
        results: names of results to dimensions of a case and units, in words.
        store: where results are kept.
    """

    cases: int
    done: int
    failed: int
    damaged: int
    shape: Mapping[str, int]
    chunk: Mapping[str, int]
    chunks: int
    how: str
    seconds_per_case: float
    workers: int
    where: str
    seconds: float
    memory: int
    disk: int
    results: Mapping[str, str]
    store: str

    def rows(self) -> list[tuple[str, str]]:
        """Return what is said, as pairs of words."""
        done = f", {self.done:,} of them done" if self.done else ""
        done += f" ({self.failed:,} failed)" if self.failed else ""
        done += f", {self.damaged:,} damaged" if self.damaged else ""
        is_timed = math.isfinite(self.seconds_per_case)
        return [
            ("cases", f"{self.cases:,}{done}: {_sizes(self.shape)}"),
            ("results", "; ".join(f"{name} {what}".strip() for name, what in self.results.items())),
            ("chunks", f"{self.chunks:,} of {_sizes(self.chunk)}: {self.how}"),
            ("where", f"{self.where}; results in {self.store}"),
            ("per case", in_time(self.seconds_per_case) if is_timed else "nothing is left"),
            ("time", f"about {in_time(self.seconds)}" if is_timed else "none"),
            ("memory", f"{in_bytes(self.memory)} for results on their way to the store"),
            ("disk", f"at most {in_bytes(self.disk)}"),
        ]

    def __str__(self) -> str:
        return "\n".join(f"{name + ':':10}{what}" for name, what in self.rows())

    def __repr__(self) -> str:
        return str(self)

    def _repr_html_(self) -> str:
        from ...kit.markup import table  # Imported here: only notebooks show it.

        return table(("plan", ""), self.rows())


def in_words(schema: Schema) -> dict[str, str]:
    """Return names of results to their dimensions and units."""
    found = {}
    for name, item in schema.variables.items():
        unit = item.attributes.get("units", "")
        dims = f"({', '.join(item.dims)})" if item.dims else ""
        found[name] = f"{dims} [{unit}]".strip() if unit else dims
    return found


def _sizes(shape: Mapping[str, int]) -> str:
    # What has one value only says nothing of the size.
    sizes = {name: size for name, size in shape.items() if size > 1} or shape
    return " × ".join(f"{name} {size:,}" for name, size in sizes.items())


def in_time(seconds: float) -> str:
    """Return a time in words."""
    for size, unit in ((86400.0, "days"), (3600.0, "h"), (60.0, "min"), (1.0, "s"), (1e-3, "ms")):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e6:.3g} µs"


def in_bytes(size: float) -> str:
    """Return a number of bytes in words."""
    for least, unit in ((1e12, "TB"), (1e9, "GB"), (1e6, "MB"), (1e3, "kB")):
        if size >= least:
            return f"{size / least:.3g} {unit}"
    return f"{size:.0f} bytes"
