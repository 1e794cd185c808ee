"""Program: what was traced, run for as many samples as there are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..arrays import BLOCK_SIZE, Array
from ..errors import ArgumentError, choices
from .graph import Graph, live_part
from .on_arrays import ArrayBlock
from .trace import Scalar, Trace


class Program:
    """Outputs of a trace as functions of its inputs, for any number of lanes side by side.

    It is plain data: it can be pickled, and does not need the trace any more.

    Attributes:
        inputs: names of the inputs that outputs depend on.
        outputs: number of outputs.
    """

    def __init__(self, trace: Trace, outputs: Sequence[Scalar]) -> None:
        """Take what outputs depend on out of a trace.

        Args:
            trace: the trace.
            outputs: variables of the trace, and numbers. The same one may be given several times.

        Raises:
            ArgumentError: an output is neither a variable of the trace nor a number.
        """
        self._graph: Graph = live_part(trace, outputs)
        self.inputs = self._graph.inputs
        self.outputs = len(outputs)
        self._blocks: dict[int, ArrayBlock] = {}

    def run(self, inputs: Mapping[str, Any], count: int, threads: int = 1) -> Array:
        """Return the outputs `(outputs, count)`.

        Args:
            inputs: values by name, at least of `inputs`: a number, or `(count,)`, which uniform
                inputs do not take.
            count: number of lanes.
            threads: how many of them compute, each a part of the lanes. The results are the same.

        Raises:
            ArgumentError: an input is missing, or has another shape.
        """
        return self.run_on_arrays(inputs, count)

    def run_on_arrays(
        self, inputs: Mapping[str, Any], count: int, block: int = BLOCK_SIZE
    ) -> Array:
        """Return what `run` returns, computed by NumPy alone.

        Args:
            inputs: as for `run`.
            count: number of lanes.
            block: how many of them are computed at a time.

        Raises:
            ArgumentError: as `run`.
        """
        values = self.checked(inputs, count)
        outputs = np.empty((self.outputs, count))
        if not count:
            return outputs
        lanes = min(block, count)
        bound = self.array_block(lanes)
        with np.errstate(all="ignore"):
            for name in self._graph.uniform_inputs:
                bound.inputs[name][...] = values[name]
            bound.begin()
            for first in range(0, count, lanes):
                # The last block overlaps the one before it, so that all are of one size.
                part = slice(min(first, count - lanes), min(first + lanes, count))
                for name, array in bound.inputs.items():
                    if array.ndim:
                        value = values[name]
                        array[...] = value[part] if value.ndim else value
                bound.run()
                outputs[:, part] = bound.outputs
        return outputs

    def array_block(self, lanes: int) -> ArrayBlock:
        """Return the program bound to NumPy arrays of a number of lanes; it is kept."""
        if lanes not in self._blocks:
            self._blocks[lanes] = ArrayBlock(self._graph, lanes)
        return self._blocks[lanes]

    def checked(self, inputs: Mapping[str, Any], count: int) -> dict[str, Array]:
        """Return the values of all inputs, each `()` or `(count,)`.

        Raises:
            ArgumentError: one is missing, or has another shape.
        """
        values = {}
        for name in self.inputs:
            if name not in inputs:
                raise ArgumentError(
                    f"no value of the input {name!r}; given are: {choices(inputs, name)}"
                )
            value = np.asarray(inputs[name], dtype=float)
            if value.size == 1:
                value = value.reshape(())
            elif value.shape != (count,) or name in self._graph.uniform_inputs:
                wanted = (
                    "it is one number for all lanes"
                    if name in self._graph.uniform_inputs
                    else f"give a number, or one for each of {count} lanes"
                )
                raise ArgumentError(f"the input {name!r} has the shape {value.shape}; {wanted}")
            values[name] = value
        return values

    def __getstate__(self) -> dict[str, Any]:
        # Arrays of blocks are made again where they are needed.
        return {**self.__dict__, "_blocks": {}}
