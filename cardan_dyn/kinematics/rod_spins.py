"""Rod spins: which rates of idle motions keep idle rods from turning about their lines."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from .batch_model import BatchModel, placement
from .idle_rods import IdleRod
from .loop_geometry import LoopPath


class RodSpins:
    """The idle rods of a group, and the coordinates that move them."""

    def __init__(self, batch: BatchModel, rods: tuple[IdleRod, ...], moved_bodies: Array) -> None:
        """Find what moves the rods.

        Args:
            batch: of the group's bodies.
            rods: the k rods.
            moved_bodies: `(m,)` indices in the batch of the bodies that the movable coordinates
                move.
        """
        self._bodies = [batch.index_of[rod.body] for rod in rods]
        self._lines = [rod.line for rod in rods]
        # The base of the batch stands for what carries it.
        self._frames = [batch.index_of.get(rod.frame, -1) for rod in rods]
        # How a rod moves relative to its frame: what moves both alike makes no difference.
        self._moves = np.zeros((len(rods), len(moved_bodies)))
        for row, (body, frame) in enumerate(zip(self._bodies, self._frames, strict=True)):
            of_rod, of_frame = set(batch.path(body)), set(batch.path(frame))
            self._moves[row, np.isin(moved_bodies, list(of_rod - of_frame))] = 1.0
            self._moves[row, np.isin(moved_bodies, list(of_frame - of_rod))] = -1.0
        self._paths = [LoopPath.of(moves, moved_bodies) for moves in self._moves]

    def turned(self, actions: Array, at_zero: Array) -> Array:
        """Return `(N, k)` angles [rad] of the rods about their lines from where they settle.

        There a rod is turned from its orientation at the description's zero, as seen from its
        frame, by the least rotation that takes its line to where it is.

        Args:
            actions: of the batch at closed positions, see `BatchModel.actions`.
            at_zero: `(1, 6 n, 6)` those at the description's zero.
        """
        angles = []
        for body, frame, line in zip(self._bodies, self._frames, self._lines, strict=True):
            rotation, initial = (_relative(item, frame, body) for item in (actions, at_zero))
            start, now = initial[:, :, 0] @ line, np.einsum("ijn,j->in", rotation, line)
            settled = _least_rotations(start, now) @ initial[:, :, 0]
            # What is left is a rotation about the line; its trace and skew part show the angle.
            left = np.einsum("ijn,nkj->nik", rotation, settled)
            skew = np.stack([left[:, k, j] - left[:, j, k] for j, k in ((1, 2), (2, 0), (0, 1))])
            sine = 0.5 * np.einsum("in,in->n", skew, now)
            cosine = 0.5 * (np.trace(left, axis1=1, axis2=2) - 1.0)
            angles.append(np.arctan2(sine, cosine))
        return np.stack(angles, axis=1)

    def turning_back(self, actions: Array, twists: Array, idle: Array, angles: Array) -> Array:
        """Return combinations `(N, k)` of idle motions that turn the rods back by angles `(N, k)`.

        Args:
            actions: of the batch.
            twists: see `of`.
            idle: see `of`.
            angles: about the rods' lines [rad].
        """
        rates = []
        for row, (body, line) in enumerate(zip(self._bodies, self._lines, strict=True)):
            now = np.einsum("ijn,j->ni", placement(actions, body)[0], line)
            angular = twists[:, -idle.shape[1] :, 3:] * self._moves[row, -idle.shape[1] :, None]
            rates.append(np.einsum("ni,nmi,nmk->nk", now, angular, idle))
        return -(np.linalg.pinv(np.stack(rates, axis=1)) @ angles[:, :, None])[:, :, 0]

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


def _relative(actions: Array, frame: int, body: int) -> Array:
    """Return the rotations `(3, 3, N)` of a body relative to another one, -1 for the base."""
    rotation, _ = placement(actions, body)
    if frame < 0:
        return rotation
    return np.einsum("jin,jkn->ikn", placement(actions, frame)[0], rotation)


def _least_rotations(start: Array, now: Array) -> Array:
    """Return the least rotations `(N, 3, 3)` that take a unit vector `(3,)` to others `(3, N)`."""
    x, y, z = np.cross(start, now.T).T
    zero = np.zeros_like(x)
    skew = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)
    # At half a turn there is no least rotation; nearby, the result turns fast.
    scale = 1.0 / np.maximum(1.0 + start @ now, np.finfo(float).tiny)
    return np.eye(3) + skew + (skew @ skew) * scale[:, None, None]
