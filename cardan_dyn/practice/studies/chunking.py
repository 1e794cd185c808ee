"""Chunking: how many cases a chunk has, along which dimension, and in which order chunks go."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import product

from .chunk import Box

SECONDS = 1.0
"""Time that a chunk takes: a thousand times what Dask needs to hand it out (about 1 ms), and a
hundred times what it takes to write it."""
MOST_BYTES = 32_000_000
"""Size of the results of a chunk, a few of which every worker and the client hold."""
MOST_CASES = 2**18
"""Cases of a chunk: more of them per call gain nothing, and failures are searched for in them."""


def chunk_shape(
    shape: Sequence[int],
    seconds: float,
    bytes_per_case: int,
    first: Sequence[int] = (),
) -> tuple[int, ...]:
    """Return the shape of chunks for cases of a shape.

    The number of cases is a power of two times what fits, so that it does not follow the noise of
    a measurement.

    Args:
        shape: of all cases.
        seconds: that a case takes.
        bytes_per_case: size of its results.
        first: dimensions that are filled first, since one call takes all of them.
    """
    wanted = min(SECONDS / max(seconds, 1e-12), MOST_BYTES / max(bytes_per_case, 1), MOST_CASES)
    room = 2 ** max(0, round(math.log2(max(wanted, 1.0))))
    others = (axis for axis in reversed(range(len(shape))) if axis not in first)
    return filled(shape, room, [*first, *others])


def filled(shape: Sequence[int], room: int, order: Iterable[int]) -> tuple[int, ...]:
    """Return the shape of a box of no more cases than there is room for, at least one.

    Args:
        shape: of all cases.
        room: number of cases.
        order: in which dimensions are filled; of others it has one point.
    """
    box = [1] * len(shape)
    for axis in order:
        box[axis] = max(1, min(shape[axis], room))
        room //= box[axis]
    return tuple(box)


def count(shape: Sequence[int], chunk: Sequence[int]) -> int:
    """Return the number of chunks."""
    return math.prod(-(-size // of_chunk) for size, of_chunk in zip(shape, chunk, strict=True))


def boxes(shape: Sequence[int], chunk: Sequence[int], inside: Box | None = None) -> Iterator[Box]:
    """Iterate over the boxes of all chunks, in C order.

    Args:
        shape: of all cases.
        chunk: of a chunk.
        inside: only those of a box whose ends are ends of chunks.
    """
    spans = inside or tuple(slice(0, size) for size in shape)
    starts = (range(span.start, span.stop, size) for span, size in zip(spans, chunk, strict=True))
    for place in product(*starts):
        yield tuple(
            slice(at, min(at + size, whole))
            for at, size, whole in zip(place, chunk, shape, strict=True)
        )


def slabs(shape: Sequence[int], chunk: Sequence[int], most: int) -> Iterator[Box]:
    """Iterate over boxes of whole chunks with about as many cases as can be looked at together."""
    size = list(chunk)
    # Whole dimensions from the last one on, as long as they fit; then as much of the next.
    for axis in reversed(range(len(shape))):
        others = math.prod(size) // size[axis]
        room = max(1, most // (others * chunk[axis]))
        size[axis] = min(room, -(-shape[axis] // chunk[axis])) * chunk[axis]
        if size[axis] < shape[axis]:
            break
    yield from boxes(shape, size)
