"""Traced: a text of one sample as programs that run for many, one for each kind of sample."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np

from ..arrays import Array
from ..tape import Program, Scalar, Trace
from .placing import Fixed
from .samples import Sample
from .vectors import ZERO

Text: TypeAlias = Callable[[Sample], Sequence[Scalar]]

_ANY = ("x", "turns", "positions", "held", "wrenches")
"""Fields whose zeros make no other kind of sample: they come and go from block to block."""


class Programs:
    """What a text computes, traced when a kind of sample is first seen.

    Samples are of one kind if the same of their numbers are zero, the same for all, or apart.
    """

    def __init__(self) -> None:
        self.of_kinds: dict[tuple[Any, ...], Program] = {}

    def run(self, text: Text, sample: Sample, count: int) -> Array:
        """Return what a text computes of that many samples side by side, a row for each result."""
        values: list[Scalar] = []
        kind: list[Any] = [sample.moves, *sample.inertia]

        def noted(value: Scalar, is_any: bool) -> Scalar:
            if not is_any:
                kind.append(_kind(value))
            if is_any or kind[-1] is not None:
                values.append(value)
            return value

        _each(sample, noted, kind)
        names = list(map(str, range(len(values))))
        key = tuple(kind)
        if key not in self.of_kinds:
            self.of_kinds[key] = _program(text, sample)
        return self.of_kinds[key].run(dict(zip(names, values, strict=True)), count)


def _program(text: Text, sample: Sample) -> Program:
    trace = Trace()

    def variable(value: Scalar, is_any: bool) -> Scalar:
        is_uniform = False if is_any else _kind(value)
        # No decision is taken by shadows.
        return value if is_uniform is None else trace.input(str(len(trace.inputs)), 0.0, is_uniform)

    return Program(trace, text(_each(sample, variable, [])))


def _kind(value: Scalar) -> bool | None:
    """Return whether a scalar is one number for all samples; None if it is zero for all."""
    if type(value) is not float:
        return False
    return True if value else None


def _each(sample: Sample, replaced: Callable[[Scalar, bool], Scalar], kind: list[Any]) -> Sample:
    """Return a sample with each of its scalars replaced; what else it has is added to its kind."""

    def walked(item: Any, is_any: bool) -> Any:
        if isinstance(item, (float, np.ndarray)):
            return replaced(item, is_any)
        if item is ZERO and not is_any:
            kind.append(item)
            return item
        if isinstance(item, (list, tuple)) and not isinstance(item, Fixed):
            parts = [walked(part, is_any) for part in item]
            return parts if isinstance(item, list) else _alike(item, parts)
        if isinstance(item, dict):
            return {key: walked(part, is_any) for key, part in item.items()}
        kind.append(item)
        return item

    fields = {name: walked(part, name in _ANY) for name, part in sample._asdict().items()}
    return Sample(**fields)


def _alike(item: tuple[Any, ...], parts: list[Any]) -> Any:
    return item._make(parts) if hasattr(item, "_make") else tuple(parts)
