"""Silent couplings: which components are open because couplings state no forces, for the proof."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...kit.arrays import NOTHING, Array
from .constraints import coupled_joints

if TYPE_CHECKING:
    from ..description.description import CouplingDescription, Description
    from ..mechanism.frames import Frames


def open_by_couplings(description: Description, frames: Frames) -> Array:
    """Return `(J, 6)` which components of all joints the forces of couplings may change.

    A coupling that states no forces may exert any on the links of the joints that it couples. These
    pass through each joint that parts some of these joints from the others, and around its loops.
    """
    count = len(frames.joints)
    result = np.zeros((count, 6), dtype=bool)
    silent = [item for item in description.couplings if not item.forces]
    if not silent:
        return result
    # Row i: which joints of the tree carry body i; joints of loops carry none.
    carries = np.zeros((frames.tree, frames.tree), dtype=bool)
    for body in range(frames.tree):
        carries[body, frames.path(body)] = True
    around = np.zeros((len(frames.ends), count), dtype=bool)
    for loop, row in enumerate(around):
        for body in (frames.parents[frames.tree + loop], frames.children[frames.tree + loop]):
            if body >= 0:
                row[: frames.tree] ^= carries[body]
        row[frames.tree + loop] = True
    for item in silent:
        coupled = _coupled(item, frames)
        carried = carries[coupled].sum(axis=0)
        passed = np.zeros(count, dtype=bool)
        passed[: frames.tree] = (carried > 0) & (carried < len(coupled))
        passed[coupled] = False
        reached = np.zeros(len(around), dtype=bool)
        while np.any(more := ~reached & np.any(around & passed, axis=1)):
            reached |= more
            passed |= np.any(around[more], axis=0)
        for joint in np.flatnonzero(passed).tolist():
            result[joint] |= _free(frames, joint)
        result[coupled] = True
    return result


def _coupled(coupling: CouplingDescription, frames: Frames) -> list[int]:
    """Return the indices of the joints that a coupling couples."""
    return [frames.joints.index(name) for side in coupled_joints(coupling, frames) for name in side]


def _free(frames: Frames, joint: int) -> Array:
    """Return `(6,)` which components the last motion of a joint does not decide."""
    result = np.ones(6, dtype=bool)
    if joint in frames.fixed_placement:
        return result
    motion = frames.motions[frames.last[joint]]
    if motion.kind == "ball":
        result[3:] = False
        return result
    across = np.array([np.hypot(*np.delete(motion.axis, k)) for k in range(3)])
    result[slice(3) if motion.kind == "slide" else slice(3, 6)] = across > NOTHING
    return result
