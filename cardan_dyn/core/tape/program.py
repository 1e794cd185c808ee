"""Program: what was traced, run for as many samples as there are."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from ...kit.arrays import Array
from ...kit.errors import ArgumentError, choices
from .. import compiled
from .graph import Graph, live_part
from .on_arrays import MOST_LANES, ArrayBlock, lanes_of_block, parts
from .on_machine import Code, block_for, code_of, filled, machine_is_at_hand
from .trace import Scalar, Trace


class Program:
    """Outputs of a trace as functions of its inputs, for any number of lanes side by side.

    It is plain data: it can be pickled, and does not need the trace any more.

    Attributes:
        graph: what is computed.
        inputs: names of the inputs that outputs depend on, or of all.
        outputs: number of outputs.
    """

    def __init__(self, trace: Trace, outputs: Sequence[Scalar], keeps_inputs: bool = False) -> None:
        """Take what outputs depend on out of a trace.

        Args:
            trace: the trace.
            outputs: variables of the trace, and numbers. The same one may be given several times.
            keeps_inputs: whether inputs that no output depends on stay, for `run_rows`.

        Raises:
            ArgumentError: an output is neither a variable of the trace nor a number.
        """
        self._begin(live_part(trace, outputs, keeps_inputs))

    @classmethod
    def of(cls, graph: Graph) -> Program:
        """Return the program of a graph."""
        result = cls.__new__(cls)
        result._begin(graph)
        return result

    def _begin(self, graph: Graph) -> None:
        self.graph, self.inputs, self.outputs = graph, graph.inputs, len(graph.outputs)
        self._blocks: dict[int, ArrayBlock] = {}
        self._handles: dict[int, Any] = {}

    def run(self, inputs: Mapping[str, Any], count: int) -> Array:
        """Return the outputs `(outputs, count)`.

        Args:
            inputs: values by name, at least of `inputs`: a number, or `(count,)`, which uniform
                inputs do not take.
            count: number of lanes.

        Raises:
            ArgumentError: an input is missing, or has another shape.
        """
        if not count or not machine_is_at_hand():
            return self.run_on_arrays(inputs, count)
        values = self.checked(inputs, count)
        return self._run_on_machine([values[name] for name in self.inputs], count)

    def run_rows(self, rows: Sequence[Array], count: int) -> Array:
        """Return what `run` does, with inputs that stand in arrays one below the other.

        Args:
            rows: arrays `(k, count)`, or `(k, 1)` of numbers, with a row for each of `inputs` in
                their order. Uniform inputs take numbers alone.
            count: number of lanes.

        Raises:
            ValueError: there are more rows than inputs, or fewer, or rows of another length.
        """
        if count and machine_is_at_hand():
            return self._run_on_machine(rows, count)
        every = [row if len(row) == count else row[0] for part in rows for row in part]
        return self.run_on_arrays(dict(zip(self.inputs, every, strict=True)), count)

    def _run_on_machine(self, inputs: Sequence[Array], count: int) -> Array:
        block = block_for(count)
        lanes = max(block, count)
        # A single lane has numbers alone, which hold for those that the block has beside it.
        arrays = inputs if count == 1 else [filled(values, lanes) for values in inputs]
        outputs = np.empty((self.outputs, lanes))
        compiled.kernel.run_program(self.handle(block), arrays, outputs)
        return outputs[:, :count]

    @property
    def single(self) -> Any:
        """The program as the machine keeps it for one lane; None where there is no machine."""
        return self.handle(block_for(1)) if machine_is_at_hand() else None

    def of_one(self) -> Callable[[Array], Array]:
        """Return the outputs `(outputs,)` of one lane as a function of its inputs `(inputs,)`.

        It does what `run_rows` does, but sooner.
        """
        handle, count = self.single, self.outputs
        if handle is None:
            return lambda row: self.run_rows([row[:, None]], 1)[:, 0]

        def found(row: Array) -> Array:
            outputs = np.empty(count)
            compiled.kernel.run_one(handle, row, outputs)
            return outputs

        return found

    def run_on_arrays(
        self, inputs: Mapping[str, Any], count: int, block: int = MOST_LANES
    ) -> Array:
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
        values = {
            name: filled(value, padded) for name, value in self.checked(inputs, count).items()
        }
        outputs = np.empty((self.outputs, padded))
        with self.array_block(lanes) as bound, np.errstate(all="ignore"):
            for part in parts(count, lanes):
                bound.begin(values, part)
                bound.run()
                outputs[:, part] = bound.outputs
        return outputs[:, :count]

    @property
    def code(self) -> Code:
        """Instructions of the machine, which there has to be.

        Raises:
            ValueError: the program is too large.
        """
        return code_of(self.graph)

    def handle(self, block: int) -> Any:
        """Return the program as the machine keeps it, for blocks of so many lanes."""
        if block not in self._handles:
            prologue, body, registers = self.code
            sizes = registers, len(self.inputs), self.outputs, block
            self._handles[block] = compiled.kernel.program(
                prologue, self.graph.constants, body, *sizes
            )
        return self._handles[block]

    @contextmanager
    def array_block(self, lanes: int) -> Iterator[ArrayBlock]:
        """Lend the program bound to NumPy arrays of a number of lanes.

        It is kept for the next call; meanwhile others, of other threads, get one of their own.
        """
        block = self._blocks.pop(lanes, None) or ArrayBlock(self.graph, lanes)
        try:
            yield block
        finally:
            self._blocks[lanes] = block

    def checked(
        self, inputs: Mapping[str, Any], count: int, left_out: Container[str] = ()
    ) -> dict[str, Array]:
        """Return the values of all inputs but those left out, each `()` or `(count,)`.

        Raises:
            ArgumentError: one is missing, or has another shape.
        """
        values = {}
        for name in self.inputs:
            if name in left_out:
                continue
            if name not in inputs:
                raise ArgumentError(
                    f"no value of the input {name!r}; given are: {choices(inputs, name)}"
                )
            value = np.asarray(inputs[name], dtype=float)
            if value.size == 1:
                value = value.reshape(()) if value.ndim else value
            elif value.shape != (count,) or name in self.graph.uniform_inputs:
                wanted = (
                    "it is one number for all lanes"
                    if name in self.graph.uniform_inputs
                    else f"give a number, or one for each of {count} lanes"
                )
                raise ArgumentError(f"the input {name!r} has the shape {value.shape}; {wanted}")
            values[name] = value
        return values

    def __getstate__(self) -> dict[str, Any]:
        # What is bound to blocks is made again where it is needed.
        return {**self.__dict__, "_blocks": {}, "_handles": {}}
