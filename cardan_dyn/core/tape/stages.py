"""Stages: programs that run one after the other on each block of lanes.

What a stage hands on stays in the cache. A stage repeats its program until a row of its outputs is
small in all lanes of the block, so that its lanes should be left as they are where they are done.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...kit.arrays import Array
from ...kit.errors import ArgumentError
from .. import compiled
from .on_arrays import MOST_LANES, ArrayBlock, lanes_of_block, parts
from .on_machine import block_for, filled, machine_is_at_hand
from .program import Program


@dataclass(frozen=True)
class Stage:
    """A program, and how often it runs on what.

    Inputs that its outputs do not depend on are ignored, here as where a program runs.

    Attributes:
        program: the program.
        carried: inputs that are a row of the program's own last pass, from the second one on.
        taken: inputs that are a row of the outputs of the stage before: where they are carried as
            well, in the first pass.
        until: the row of outputs that ends passes; None where `most` alone does.
        most: how many passes there are at most, 1 or more.
        within: passes end once the row is at most this in all lanes of a block. NaN is not.
        kept: whether outputs of the last pass are returned.
    """

    program: Program
    carried: Mapping[str, int] = field(default_factory=dict)
    taken: Mapping[str, int] = field(default_factory=dict)
    until: int | None = None
    most: int = 1
    within: float = 0.0
    kept: bool = False


class Stages:
    """Several stages, one after the other."""

    def __init__(self, stages: Sequence[Stage]) -> None:
        """Check and keep stages.

        Args:
            stages: in their order.

        Raises:
            ArgumentError: a stage asks for a row that there is not, or gives one to a uniform
                input, or has no pass.
        """
        self.stages = tuple(stages)
        for place, stage in enumerate(self.stages):
            before = self.stages[place - 1].program.outputs if place else 0
            own = stage.program.outputs
            until = {} if stage.until is None else {"until": stage.until}
            for name, row in (*stage.carried.items(), *until.items()):
                _check(place, name, row, own, "its outputs")
            for name, row in stage.taken.items():
                _check(place, name, row, before, "outputs of the stage before")
            for name in stage.program.graph.uniform_inputs & {*stage.carried, *stage.taken}:
                raise ArgumentError(
                    f"input {name!r} of stage {place} is uniform, and cannot be a row of outputs"
                )
            if stage.most < 1:
                raise ArgumentError(f"stage {place} has most={stage.most}; it needs a pass")
        # Of each input, the row that it is of its own outputs and of those before; -1 for none.
        self._rows = [
            [
                np.array([among.get(name, -1) for name in stage.program.inputs], dtype=np.int32)
                for among in (stage.carried, stage.taken)
            ]
            for stage in self.stages
        ]

    def run(self, inputs: Sequence[Mapping[str, Any]], count: int) -> list[Array]:
        """Return the outputs `(outputs, count)` of each stage that is kept.

        Args:
            inputs: of each stage, values as for `Program.run`, but for inputs that are taken.
            count: number of lanes.

        Raises:
            ArgumentError: an input is missing, or has another shape.
        """
        given = [
            [values.get(name) for name in stage.program.inputs]
            for stage, values in zip(self.stages, self._checked(inputs, count), strict=True)
        ]
        return self.run_rows(given, count)

    def run_rows(self, inputs: Sequence[Sequence[Array | None]], count: int) -> list[Array]:
        """Return what `run` does, with inputs that stand in arrays one below the other.

        Args:
            inputs: of each stage, arrays as of `Program.run_rows`, or `()` and `(count,)` of a
                single input; None for each that is taken.
            count: number of lanes.
        """
        if not (count and self.stages and machine_is_at_hand()):
            named = []
            for stage, own in zip(self.stages, inputs, strict=True):
                every: list[Array | None] = []
                for part in own:
                    every.extend([part] if part is None or part.ndim < 2 else part)
                named.append(dict(zip(stage.program.inputs, every, strict=True)))
            return self.run_on_arrays(named, count)
        block = block_for(count)
        lanes = max(block, count)
        outputs, fields = [], []
        for stage, own, (carried, taken) in zip(self.stages, inputs, self._rows, strict=True):
            rows = np.empty((stage.program.outputs, lanes)) if stage.kept else None
            # As of programs, a single lane has numbers alone.
            arrays = own
            if count > 1:
                arrays = [v if v is None or not v.ndim else filled(v, lanes) for v in own]
            until = -1 if stage.until is None else stage.until
            ends = (until, stage.within, stage.most)
            handle = stage.program.handle(block)
            fields.append((handle, arrays, carried, taken, *ends, None, rows))
            outputs.append(rows)
        compiled.kernel.run_stages(fields, lanes, block)
        return [rows[:, :count] for rows in outputs if rows is not None]

    def run_on_arrays(
        self, inputs: Sequence[Mapping[str, Any]], count: int, block: int = MOST_LANES
    ) -> list[Array]:
        """Return what `run` returns, computed by NumPy alone.

        Args:
            inputs: as for `run`.
            count: number of lanes.
            block: how many of them are computed at a time, at most.

        Raises:
            ArgumentError: as `run`.
        """
        lanes = lanes_of_block(count, block)
        padded = max(count, lanes)
        given = [
            {name: filled(value, padded) for name, value in values.items()}
            for values in self._checked(inputs, count)
        ]
        outputs = [
            np.empty((stage.program.outputs, padded)) if stage.kept else None
            for stage in self.stages
        ]
        with ExitStack() as lent, np.errstate(all="ignore"):
            bound = [lent.enter_context(x.program.array_block(lanes)) for x in self.stages]
            for part in parts(count, lanes):
                before = np.empty((0, lanes))
                for stage, block_of, values, rows in zip(
                    self.stages, bound, given, outputs, strict=True
                ):
                    _run_passes(stage, block_of, values, before, part)
                    before = block_of.outputs
                    if rows is not None:
                        rows[:, part] = before
        return [rows[:, :count] for rows in outputs if rows is not None]

    def _checked(self, inputs: Sequence[Mapping[str, Any]], count: int) -> list[dict[str, Array]]:
        """Return values of the inputs of each stage that are not taken, each `()` or `(count,)`."""
        if len(inputs) != len(self.stages):
            raise ArgumentError(f"give inputs of {len(self.stages)} stages, not of {len(inputs)}")
        return [
            stage.program.checked(values, count, left_out=stage.taken)
            for stage, values in zip(self.stages, inputs, strict=True)
        ]


def _check(place: int, name: str, row: int, rows: int, among: str) -> None:
    if not 0 <= row < rows:
        raise ArgumentError(
            f"stage {place} asks for row {row} of {among} as {name!r}; there are {rows}"
        )


def _run_passes(
    stage: Stage, bound: ArrayBlock, values: dict[str, Array], before: Array, part: slice
) -> None:
    """Run a stage on a block, on outputs of the stage before."""
    bound.begin(values, part)
    for name, row in stage.taken.items():
        if name in bound.inputs:
            bound.inputs[name][...] = before[row]
    for _ in range(stage.most - 1):
        bound.run()
        if stage.until is not None and np.all(bound.outputs[stage.until] <= stage.within):
            return
        for name, row in stage.carried.items():
            if name in bound.inputs:
                bound.inputs[name][...] = bound.outputs[row]
    bound.run()
