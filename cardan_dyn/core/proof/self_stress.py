"""Self-stress: which components of which wrenches the laws of motion leave open, for the proof.

A mechanism with redundant constraints can be under stress without any load. At single positions
such self-stresses are found from the loops cut open: closure wrenches and coupling moments that
cause no effort along a passive coordinate. A component that is flagged unique must not change under
any of them, and a component that is flagged not unique must change under at least one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType

import numpy as np

from ...kit.arrays import NOTHING, Array
from ...kit.errors import AccuracyError
from ..elements.link_loads import WRENCH_COMPONENTS
from .placing import Frame, stacked
from .residuals import SUM_ROUNDING
from .screws import Screws

_ZERO, _CLEAR = 1e-11, 1e-7
"""Relative singular values of equilibrium up to which it is singular, and from which it is not.

Coordinates are exact to some 1e-15, so that self-stresses come out with singular values of that
size; four digits are left for loops whose shape magnifies rounding. Values in between occur next to
singular configurations, where neither answer can be trusted, so such positions are not judged.

Where all are clear, rounding turns null vectors by up to eps / 1e-7 = 2e-9. A change of a component
of up to `_CLEAR`, per unit of self-stress, counts as none: the factor of 50 is left for the lever
arms by which wrenches are moved to their joints. The solver flags a component as open only from a
change of 1e-9 on, so one that changes by rounding alone, `SUM_ROUNDING`, is proven to be unique.
"""
_POSITIONS_AT_ONCE = 64
"""Positions whose equilibrium is decomposed together.

It bounds the memory: 64 matrices of 600 × 600 numbers take 184 MB.
"""
MOST_UNKNOWNS = 600
"""Greatest number of unknown closure forces that are decomposed; beyond, flags are not proven.

The time of a decomposition grows with the third power of this number.
"""


class SelfStressProof:
    """The states of stress of the loops of a description.

    Attributes:
        joints: names of the joints.
        unknowns: number of components of all closure wrenches and coupling moments.
    """

    def __init__(
        self,
        screws: Screws,
        loops: list[int],
        couplings: int,
        coupling_factors: Callable[[Array], Array],
        passives: Sequence[int],
        length: float,
        geared: Mapping[int, tuple[int, int]] = MappingProxyType({}),
    ) -> None:
        """Lay out the equations of equilibrium.

        Args:
            screws: of the description's joints.
            loops: indices of the loops that are closed.
            couplings: how many there are.
            coupling_factors: returns `(N, G, nv)` the effort along each rate per unit moment of a
                coupling, at coordinates `(N, size)`.
            passives: velocity coordinates that are neither driven nor held.
            length: characteristic length, that forces are multiplied with to compare them with
                moments [m].
            geared: coupling, as they are counted there, to the joints that its teeth press on.
        """
        frames = screws.frames
        self._geared = geared
        self._screws = screws
        self.joints = frames.joints
        # A closure wrench acts on the loop's successor, against the predecessor; what holds both
        # in equilibrium passes through the joints between them and their common ancestor.
        self._signs = np.zeros((len(frames.joints), len(loops)))
        for column, loop in enumerate(loops):
            joint = frames.tree + loop
            self._signs[joint, column] = 1.0
            for body, sign in ((frames.parents[joint], 1.0), (frames.children[joint], -1.0)):
                self._signs[frames.path(body), column] += sign
        self._rows = [row for row, rate in enumerate(screws.rates) if rate in passives]
        owners = [frames.motions[screws.owners[row]].joint for row in self._rows]
        self._row_signs = self._signs[owners]
        scale = [length if screws.sliding[row] else 1.0 for row in self._rows]
        self._row_scale = np.array(scale)[:, None]
        self._rates = [screws.rates[row] for row in self._rows]
        self._coupling_factors = coupling_factors
        self._lengths = np.repeat([length, 1.0], 3)
        self.unknowns = 6 * len(loops) + couplings

    def influence(self, x: Array) -> Iterator[tuple[Array, Array]]:
        """Yield how far self-stresses change each component, for some positions at a time.

        Args:
            x: `(N, size)` coordinates with closed loops.

        Yields:
            `(n, J, 6)` greatest change of every joint's wrench in its frame, forces times the
            length, per unit of self-stress; and `(n,)` whether the rank at a position is beyond
            doubt.
        """
        for changes, clear in self._changes(x):
            sizes = [np.sqrt(np.sum(change**2, axis=3)).reshape(-1, 6) for change in changes]
            yield np.array(sizes) * self._lengths, clear

    def unique_of(self, joint: int, x: Array, maps: Array, are_forces: Array) -> Array | None:
        """Return `(k,)` which sums of the components of a wrench are unique.

        Args:
            joint: its index.
            x: `(N, size)` coordinates with closed loops.
            maps: `(N, k, 6)` factors on force and moment, in the joint's frame.
            are_forces: `(k,)` which of these sums are forces; the others are moments.

        Returns:
            Whether each changes at no position; None where self-stresses are too many to be
            decomposed, or their rank is in doubt at all positions.
        """
        if self.unknowns > MOST_UNKNOWNS:
            return None
        lengths = np.where(are_forces, self._lengths[0], 1.0)
        greatest, judged, left = np.zeros(len(lengths)), False, iter(maps)
        for changes, clear in self._changes(x):
            for change, is_clear, factors in zip(changes, clear, left, strict=False):
                if is_clear:
                    judged = True
                    sums = factors @ change[joint].reshape(6, -1)
                    greatest = np.maximum(greatest, np.sqrt(np.sum(sums**2, axis=1)) * lengths)
        return greatest <= _CLEAR if judged else None

    def _equilibrium(self, placed: Sequence[Frame], x: Array) -> Array:
        """Return `(N, R, C)` the effort along each passive rate per unit of each unknown.

        Unknowns are all closure wrenches, their forces times the length, then couplings' efforts;
        efforts of slides are multiplied with the length likewise.
        """
        units, count = self._screws.units(placed), len(x)
        vectors = [vector for row in self._rows for vector in units[row]]
        # Unknown forces count times the length, so that their factors are divided by it.
        factors = stacked(vectors, count).reshape(-1, 6, count).transpose(2, 0, 1) / self._lengths
        matrix = factors[:, :, None, :] * self._row_signs[:, :, None]
        matrix = matrix.reshape(count, len(self._rows), 6 * self._row_signs.shape[1])
        columns = -np.swapaxes(self._coupling_factors(x)[:, :, self._rates], 1, 2) * self._row_scale
        # A moment, or the force at a slide, counts by its greatest effort.
        sizes = np.max(np.abs(columns), axis=1, keepdims=True, initial=0.0)
        couplings = columns / np.where(sizes > 0.0, sizes, 1.0)
        return np.concatenate([matrix * self._row_scale, couplings], axis=2)

    def _changes(self, x: Array) -> Iterator[tuple[list[Array], Array]]:
        """Yield per position what self-stresses add to the wrenches, see `_on_joints`.

        And `(n,)` whether the rank at a position is beyond doubt; some positions at a time.
        """
        for start in range(0, len(x), _POSITIONS_AT_ONCE):
            block = x[start : start + _POSITIONS_AT_ONCE]
            placed, count = self._screws.placing.placed(list(block.T)), len(block)
            null_spaces, clear = _null_spaces(self._equilibrium(placed, block))
            frames = self._screws.placing.joint_frames(placed)
            vectors = [vector for axes, origin in frames for vector in (*axes, origin)]
            joint_frames = stacked(vectors, count).reshape(-1, 4, 3, count).transpose(3, 0, 1, 2)
            yield list(map(self._on_joints, null_spaces, joint_frames)), clear

    def _on_joints(self, stresses: Array, joint_frames: Array) -> Array:
        """Return what a basis of self-stresses `(C, k)` adds to all wrenches, `(J, 2, 3, k)`.

        Force and moment, in the joints' frames `(J, 4, 3)`.
        """
        loops = self._signs.shape[1]
        # Of every loop, force over the length and moment about the corner.
        wrenches = stresses[: 6 * loops].reshape(loops, 2, 3, stresses.shape[1])
        wrenches = wrenches / self._lengths[::3, None, None]
        on_joints = np.einsum("jl,lkis->jkis", self._signs, wrenches)
        on_joints[:, 1] -= np.cross(joint_frames[:, 3, :, None], on_joints[:, 0], axis=1)
        changes = np.einsum("jci,jkis->jkcs", joint_frames[:, :3], on_joints)
        for row, joints in self._geared.items():
            # Where its moment is open, nothing is known of what teeth press on.
            pressed = np.zeros((*changes.shape[:3], 6))
            size = np.linalg.norm(stresses[6 * loops + row])
            pressed[list(joints)] = (
                size * np.eye(6).reshape(2, 3, 6) / self._lengths[::3, None, None]
            )
            changes = np.concatenate([changes, pressed], axis=3)
        return np.asarray(changes)


def prove_flags(
    stress: SelfStressProof,
    x: Array,
    unique: Array,
    joints: list[int],
    condition: float,
    silent: Array | bool = False,
) -> None:
    """Refuse flags of uniqueness that self-stresses contradict, or couplings that state no forces.

    Args:
        stress: states of stress of the mechanism.
        x: `(N, size)` coordinates of a sweep.
        unique: `(J, 6)` flags of the claimed joints.
        joints: indices of these joints in `Frames`.
        condition: condition number of the closure equations, whose rounding may make the solver
            flag a component.
        silent: `(J, 6)` which components couplings leave open.

    Raises:
        AccuracyError: a component flagged unique changes, or one flagged not unique does not.
    """
    if np.any(unique & silent):
        raise _contradiction("unique, but changes", stress, joints, unique & silent)
    if not stress.unknowns or stress.unknowns > MOST_UNKNOWNS:
        return
    last = len(x) - 1
    first = sorted({0, last // 2, last})
    changes, judged = np.zeros(unique.shape), False
    # Some components are open at special positions only; all positions are judged where the first
    # ones leave a flag unproven.
    for positions in (x[first], x) if last > 2 else (x,):
        for influence, clear in stress.influence(positions):
            judged = judged or bool(np.any(clear))
            changes = np.maximum(changes, influence[clear][:, joints].max(axis=0, initial=0.0))
        wrong = unique & (changes > _CLEAR)
        if np.any(wrong):
            raise _contradiction("unique, but changes", stress, joints, wrong)
        if np.all(unique | silent | (changes > SUM_ROUNDING)):
            return
    # The rank is in doubt near singular positions; and the flag is where rounding, magnified by the
    # condition, may look like the influence from which on the solver sets it.
    if not judged or SUM_ROUNDING * condition > NOTHING:
        return
    wrong = ~unique & ~np.asarray(silent) & (changes <= SUM_ROUNDING)
    raise _contradiction("open, but does not change", stress, joints, wrong)


def _contradiction(
    finding: str, stress: SelfStressProof, joints: list[int], wrong: Array
) -> AccuracyError:
    """Return the error for the first component `(J, 6)` whose flag is wrong."""
    joint, component = np.argwhere(wrong)[0].tolist()
    name = stress.joints[joints[joint]]
    return AccuracyError(
        f"{WRENCH_COMPONENTS[component]} of the wrench at {name!r} is flagged {finding} under "
        "self-stress or the forces of couplings: please report this with the scene",
        residual=float("nan"),
        tolerance=_CLEAR,
        position=None,
    )


def _null_spaces(matrices: Array) -> tuple[list[Array], Array]:
    """Return bases `(C, k)` of the null spaces of `(N, R, C)`, and whether their ranks are clear.

    Orthonormal; `(N,)` whether no singular value lies between zero and not zero.
    """
    count, rows, columns = matrices.shape
    if not rows:
        return [np.eye(columns)] * count, np.ones(count, dtype=bool)
    _, values, right = np.linalg.svd(matrices)
    greatest = np.maximum(values[:, :1], np.finfo(float).tiny)
    relative = values / greatest
    clear = ~np.any((relative > _ZERO) & (relative < _CLEAR), axis=1)
    # Where the rank is clear, any bound between both gives it; this one is in the middle.
    ranks = np.sum(relative > np.sqrt(_ZERO * _CLEAR), axis=1)
    return [right[k, rank:].T.copy() for k, rank in enumerate(ranks)], clear
