"""Self-stress: which components of which wrenches the laws of motion leave open, for the proof.

A mechanism that is held together more often than it needs to be can be under stress without any
load. At single positions such self-stresses are found from the loops cut open: closure wrenches and
coupling moments that no passive coordinate feels. A component that is flagged unique must not
change along any of them, and one that is flagged open must change along some.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..arrays import Array
from ..errors import AccuracyError
from ..mechanism.frames import Frames
from .twists import Twists

_UNIQUE = 1e-7
"""Greatest change, per unit of self-stress, of a component that passes for unique."""
_OPEN = 1e-13
"""Greatest change of a component that passes for open nowhere."""
_ZERO, _CLEAR = 1e-11, 1e-7
"""Relative singular values of equilibrium up to which it is singular, and from which it is not."""
_CERTAIN = 1e4  # Condition number up to which rounding cannot pass for a self-stress.
_AT_ONCE = 64  # Positions whose equilibrium is decomposed together.
MOST_UNKNOWNS = 600
"""Greatest number of closure wrench components that are decomposed; beyond, nothing is said."""


class SelfStressProof:
    """The states of stress of the loops of a description.

    Attributes:
        joints: their names.
        unknowns: number of components of all closure wrenches and coupling moments.
    """

    def __init__(
        self,
        frames: Frames,
        twists: Twists,
        loops: list[int],
        gears: Array,
        passives: Array,
        length: float,
    ) -> None:
        """Lay out the equations of equilibrium.

        Args:
            frames: where everything is.
            twists: of its joints.
            loops: numbers of the loops that are closed.
            gears: `(G, nv)` effort along each rate per unit moment of a coupling.
            passives: velocity coordinates that are neither driven nor held.
            length: what forces are multiplied with to compare them with moments [m].
        """
        self._frames, self._twists = frames, twists
        self.joints = frames.joints
        # A closure wrench acts on the loop's successor, against the predecessor; what holds both
        # in equilibrium passes through the joints between them and their common ancestor.
        self._signs = np.zeros((len(frames.joints), len(loops)))
        for place, loop in enumerate(loops):
            joint = frames.tree + loop
            self._signs[joint, place] = 1.0
            for body, sign in ((frames.parents[joint], 1.0), (frames.children[joint], -1.0)):
                self._signs[frames.path(body), place] += sign
        rows = [row for row, rate in enumerate(twists.rates) if rate in set(passives.tolist())]
        self._rows = np.array(rows, dtype=int)
        owners = [frames.motions[twists.owners[row]].joint for row in rows]
        self._row_signs = self._signs[owners]
        self._gears = -gears[:, twists.rates[self._rows]].T
        scale = np.where(twists.sliding[self._rows], length, 1.0)
        self._row_scale = scale[:, None]
        self._lengths = np.repeat([length, 1.0], 3)
        self.unknowns = 6 * len(loops) + len(gears)

    def influence(self, x: Array) -> Iterator[tuple[Array, Array]]:
        """Yield how far self-stresses change each component, over some positions at a time.

        Args:
            x: `(N, size)` coordinates with closed loops.

        Yields:
            `(N, J, 6)` greatest change of every joint's wrench in its frame, forces times the
            length, per unit of self-stress; and `(N,)` whether the position leaves no doubt.
        """
        for start in range(0, len(x), _AT_ONCE):
            yield self._influence(x[start : start + _AT_ONCE])

    def _influence(self, x: Array) -> tuple[Array, Array]:
        frames, count = self._frames, len(x)
        placed = frames.placed(x)
        directions = self._twists.directions(placed)
        units = self._twists.units(placed, directions)[self._rows]
        # Unknown forces count times the length, so that their factors are divided by it.
        feel = units.reshape(len(units), 6, count).transpose(2, 0, 1) / self._lengths
        loops = self._row_signs.shape[1]
        matrix = feel[:, :, None, :] * self._row_signs[:, :, None]
        matrix = matrix.reshape(count, len(self._rows), 6 * loops)
        gears = np.broadcast_to(self._gears, (count, *self._gears.shape))
        matrix = np.concatenate([matrix, gears], axis=2) * self._row_scale
        null, clear = _null_spaces(matrix)
        result = np.zeros((count, len(frames.joints), 6))
        at = frames.joint_frames(placed).transpose(3, 0, 1, 2)
        for sample, stresses in enumerate(null):
            # Of every loop, force over the length and moment about the corner.
            wrench = stresses[: 6 * loops].reshape(loops, 2, 3, stresses.shape[1])
            wrench[:, 0] /= self._lengths[0]
            on_joints = np.einsum("jl,lkis->jkis", self._signs, wrench)
            frame = at[sample]
            on_joints[:, 1] -= np.cross(frame[:, 3, :, None], on_joints[:, 0], axis=1)
            own = np.einsum("jci,jkis->jkcs", frame[:, :3], on_joints)
            sizes = np.sqrt(np.sum(own**2, axis=3)).reshape(len(own), 6)
            result[sample] = sizes * self._lengths
        return result, clear


def prove_flags(
    stress: SelfStressProof, x: Array, unique: Array, joints: list[int], condition: float
) -> None:
    """Refuse flags that self-stresses contradict.

    Args:
        stress: of the mechanism.
        x: `(N, size)` coordinates of a sweep.
        unique: `(J, 6)` flags of the claimed joints.
        joints: their numbers in `Frames`.
        condition: of the closure equations, whose rounding may make a component look open.

    Raises:
        AccuracyError: a component flagged unique changes, or one flagged open does not.
    """
    if not stress.unknowns or stress.unknowns > MOST_UNKNOWNS:
        return
    few = sorted(set(np.linspace(0, len(x) - 1, 3).astype(int).tolist()))
    changed, told = np.zeros(unique.shape), False
    # A component may be open at special positions only: those decide where the few do not.
    for positions in (x[few], x):
        for found, clear in stress.influence(positions):
            told = told or bool(np.any(clear))
            changed = np.maximum(changed, found[clear][:, joints].max(axis=0, initial=0.0))
        wrong = unique & (changed > _UNIQUE)
        if np.any(wrong):
            raise _contradiction("unique, but changes", stress, joints, wrong)
        if np.all(unique | (changed > _OPEN)):
            return
    if not told or condition > _CERTAIN:
        return  # Rank is in doubt, next to singular positions or for want of digits.
    wrong = ~unique & (changed <= _OPEN)
    raise _contradiction("open, but does not change", stress, joints, wrong)


def _contradiction(
    what: str, stress: SelfStressProof, joints: list[int], where: Array
) -> AccuracyError:
    joint, component = np.argwhere(where)[0].tolist()
    name = stress.joints[joints[joint]]
    part = ("force x", "force y", "force z", "moment x", "moment y", "moment z")[component]
    return AccuracyError(
        f"{part} of the wrench at {name!r} is flagged {what} under self-stress: please report this "
        "with the scene",
        residual=float("nan"),
        tolerance=_UNIQUE,
        position=None,
    )


def _null_spaces(matrices: Array) -> tuple[list[Array], Array]:
    """Return bases of null spaces `(C, k)` of stacked matrices `(N, R, C)`, and which are clear."""
    count, rows, columns = matrices.shape
    if not rows:
        return [np.eye(columns)] * count, np.ones(count, dtype=bool)
    _, values, right = np.linalg.svd(matrices)
    greatest = np.maximum(values[:, :1], np.finfo(float).tiny)
    relative = values / greatest
    clear = ~np.any((relative > _ZERO) & (relative < _CLEAR), axis=1)
    ranks = np.sum(relative > np.sqrt(_ZERO * _CLEAR), axis=1)
    return [right[k, rank:].T.copy() for k, rank in enumerate(ranks)], clear
