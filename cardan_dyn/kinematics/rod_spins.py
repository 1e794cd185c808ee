"""Rod spins: which rates of idle motions keep idle rods from turning about their lines."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from .batch_model import BatchModel
from .loop_geometry import LoopPath


class RodSpins:
    """The idle rods of a group, and the coordinates that move them."""

    def __init__(self, batch: BatchModel, bodies: tuple[int, ...], moved_bodies: Array) -> None:
        """Find what moves the rods.

        Args:
            batch: of the group's bodies.
            bodies: the k rods (0-based joints of the mechanism's model).
            moved_bodies: `(m,)` indices in the batch of the bodies that the movable coordinates
                move.
        """
        self._moves = np.zeros((len(bodies), len(moved_bodies)))
        for row, body in enumerate(bodies):
            index = batch.index_of[body]
            while index >= 0:
                self._moves[row, moved_bodies == index] = 1.0
                index = int(batch.parents[index])
        self._paths = [LoopPath.of(moves, moved_bodies) for moves in self._moves]

    def of(self, twists: Array, rates: Array, idle: Array, v: Array | None = None) -> Array:
        """Return combinations `(N, k)` of idle motions that turn the rods like given rates do.

        Args:
            twists: `(N, m, 6)` unit twists of the movable coordinates.
            rates: `(N, m)` of these coordinates; or accelerations.
            idle: `(N, p, k)` idle motions of the passives, the last ones of these coordinates.
            v: `(N, m)` rates, where `rates` are accelerations.
        """
        angular = twists[:, None, :, 3:] * self._moves[:, :, None]
        of_idle = np.einsum("nrmi,nmk->nrik", angular[:, :, -idle.shape[1] :], idle)
        # Every idle motion that turns a rod does so about its line; the longest vector shows it.
        sizes = np.linalg.norm(of_idle, axis=2, keepdims=True)
        longest = np.argmax(sizes, axis=3)[..., None]
        lines = np.take_along_axis(of_idle, longest, axis=3)
        lines = lines[..., 0] / np.max(sizes, axis=3)
        turned = np.einsum("nrmi,nm->nri", angular, rates)
        if v is not None:
            # A line is fixed in its rod, so its own motion adds nothing along it.
            drifts = [path.drift(twists, v)[3:].T for path in self._paths]
            turned = turned + np.stack(drifts, axis=1)
        along = np.einsum("nri,nrik->nrk", lines, of_idle)
        wanted = np.einsum("nri,nri->nr", lines, turned)
        # Regular unless the drives leave other motions undecided, which is refused elsewhere.
        return np.asarray((np.linalg.pinv(along) @ wanted[:, :, None])[:, :, 0])
