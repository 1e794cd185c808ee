"""Proof plan: the tables along which the compiled proof works, made once per scene.

They hold what `Frames`, `Twists`, `Constraints`, `EffortBalance` and `MassiveBodies` found, one row
per item, in the order of the structures of compiled/proof_plan.h.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..compiled import Plan

if TYPE_CHECKING:
    from ..elements.link_loads import LinkLoad
    from ..mechanism.frames import ElementaryMotion, Frames, Offset, RigidBody
    from .constraints import Constraints
    from .momentum import MassiveBodies
    from .twists import Twists

_KINDS = {"turn": 3, "slide": 4, "ball": 5}
"""Numbers of the kinds of motions; turns about an axis of the frame before them have its index."""
RESULTS = 9
"""How many arrays of `Residuals` are computed."""
_PLACE = 14
"""Numbers that say on what a load on a link acts."""
_NO_LOADS = np.zeros((0, 6, 1)), np.zeros((0, _PLACE))


class ProofTables(NamedTuple):
    """What is known of a scene before anything is claimed.

    Attributes:
        frames: of the description.
        twists: of its joints.
        constraints: of the scene.
        massive: the bodies that have mass.
        claimed: indices of the joints whose wrenches are claimed, in the order of a claim.
        covered: `(B,)` whether the wrenches of all joints of a body are claimed.
        length: characteristic length [m].
    """

    frames: Frames
    twists: Twists
    constraints: Constraints
    massive: MassiveBodies
    claimed: Sequence[int]
    covered: Array
    length: float

    def plan(self) -> Plan:
        """Return the plan."""
        frames, constraints, twists = self.frames, self.constraints, self.twists
        offsets: list[Offset] = []
        joints = self._joints(offsets)
        loops, around = self._loops(offsets)
        coupled, coupled_at, coupled_by = self._couplings()
        moments = np.argwhere(constraints.coupling_factors.T)
        motions, motion_numbers = self._motions()
        efforts, effort_numbers = self._efforts()
        bodies = np.arange(frames.tree)[self.massive.indices].tolist()
        couplings, size = constraints.column_factors.shape
        counts = size, len(constraints.rate_scale), len(twists.rates)
        prescribed = [*constraints.drive_rates, *constraints.held_rates]
        integers: list[Any] = [
            [*counts, couplings, len(constraints.drive_rates)],
            motions,
            [offset.before for offset in offsets],
            joints,
            [(frames.last[body], self.covered[body]) for body in range(frames.tree)],
            efforts,
            loops,
            around,
            coupled,
            coupled_at,
            moments,
            list(zip(prescribed, constraints.prescribed_columns, strict=True)),
            constraints.known_rates,
            twists.rates[twists.sliding],
            [(body, frames.last[body]) for body in bodies],
        ]
        numbers: list[Any] = [
            [self.length, self.massive.greatest_mass],
            constraints.rate_scale,
            [_matrix(offset) for offset in offsets],
            coupled_by,
            constraints.coupling_factors.T[tuple(moments.T)],
            motion_numbers,
            effort_numbers,
            list(zip(constraints.offsets, constraints.slip_scales, strict=True)),
            [_mass(frames.bodies[body]) for body in bodies],
        ]
        return Plan("proof", integers, numbers)

    def _motions(self) -> tuple[list[Any], list[Any]]:
        """Return the motions: what they are, then where they are and their axes."""
        twists, integers, numbers = self.twists, [], []
        row = 0
        for motion, start in zip(self.frames.motions, self.frames.starts, strict=True):
            along = int(np.argmax(np.abs(motion.axis)))
            integers.append(
                (
                    _kind(motion, along),
                    motion.before,
                    start.transposed is not None,
                    motion.column,
                    motion.rate,
                    row,
                    along if twists.along_frame_axes else -1,
                )
            )
            numbers.append([*_matrix(start), *motion.axis])
            row += motion.size
        return integers, numbers

    def _joints(self, offsets: list[Offset]) -> list[Any]:
        """Return the claimed joints in ascending order; what frames they need is added."""
        frames, order = self.frames, np.argsort(self.claimed).tolist()
        return [
            (column, self._frame(joint, offsets), frames.children[joint], frames.parents[joint])
            for column, joint in zip(order, sorted(self.claimed), strict=True)
        ]

    def _frame(self, joint: int, offsets: list[Offset]) -> int:
        """Return the index of a joint's frame; if it is not that of a motion, it is added."""
        if joint not in self.frames.fixed:
            return self.frames.last[joint]
        return self._added(self.frames.fixed[joint], offsets)

    def _added(self, offset: Offset, offsets: list[Offset]) -> int:
        """Return the index of an offset among the frames, to which it is added if it is none."""
        if offset.in_world is None and offset.transposed is None:
            return offset.before
        offsets.append(offset)
        return len(self.frames.motions) + len(offsets) - 1

    def _loops(self, offsets: list[Offset]) -> tuple[list[Any], list[Any]]:
        """Return the loops, and the motions around them one loop after the other."""
        frames = self.frames
        loops: list[Any] = []
        around: list[Any] = []
        for loop, signs in zip(self.constraints.loops, self.constraints.signs, strict=True):
            joint, first = frames.tree + loop, len(around)
            around += [(motion, signs[motion]) for motion in np.flatnonzero(signs)]
            start = self._frame(joint, offsets)
            end = self._added(frames.loop_ends[loop], offsets)
            loops.append((start, end, frames.last[joint], first, len(around)))
        return loops, around

    def _couplings(self) -> tuple[list[Any], list[Any], list[Any]]:
        """Return spans of the factors of rates and of coordinates, their indices and factors."""
        spans: list[Any] = []
        at: list[int] = []
        by: list[float] = []
        constraints = self.constraints
        for coupling in constraints.couplings:
            stops = [len(at)]
            for factors in (constraints.coupling_factors, constraints.column_factors):
                found = np.flatnonzero(factors[coupling])
                at += found.tolist()
                by += factors[coupling, found].tolist()
                stops += [len(at)]
            spans.append((*stops[:2], *stops[1:]))
        return spans, at, by

    def _efforts(self) -> tuple[list[Any], list[Any]]:
        """Return along which rates claimed wrenches have to do what efforts do."""
        frames, twists, integers, numbers = self.frames, self.twists, [], []
        index_of = {joint: index for index, joint in enumerate(sorted(self.claimed))}
        for row, motion in enumerate(twists.owners.tolist()):
            joint, rate, axis = frames.motions[motion].joint, twists.rates[row], twists.axes[row]
            if joint in index_of:
                is_last, is_moment = frames.last[joint] == motion, not twists.sliding[row]
                along = np.argmax(np.abs(axis)) if twists.along_frame_axes else -1
                integers.append((index_of[joint], is_last, is_moment, along, motion, row, rate))
                numbers.append((*axis, self.constraints.rate_scale[rate]))
        return integers, numbers


def link_loads(frames: Frames, loads: Mapping[str, LinkLoad]) -> tuple[Array, Array]:
    """Return loads on links as arrays.

    Args:
        frames: of the description.
        loads: links and the wrenches that act on them, with `(N, 3)` or `(1, 3)` vectors.

    Returns:
        Forces and moments `(L, 6, N)` or `(L, 6, 1)`, and per load the index of its body, whether
        it is in world axes, the link's axes and its point in the body's frame, `(L, 14)`.
    """
    if not loads:
        return _NO_LOADS
    samples = max(max(len(load.force), len(load.moment)) for load in loads.values())
    wrenches, places = np.empty((len(loads), 2, 3, samples)), np.empty((len(loads), _PLACE))
    for wrench, place, (link, load) in zip(wrenches, places, loads.items(), strict=True):
        wrench[0], wrench[1] = load.force.T, load.moment.T
        body, placement = frames.links[link]
        rotation = placement[:3, :3]
        place[0], place[1], place[2:11] = body, load.in_world, rotation.ravel()
        place[11:] = rotation @ load.point + placement[:3, 3]
    return wrenches.reshape(-1, 6, samples), places


def _kind(motion: ElementaryMotion, along: int) -> int:
    is_along = motion.kind == "turn" and np.count_nonzero(motion.axis) == 1
    return along if is_along else _KINDS[motion.kind]


def _matrix(offset: Offset) -> list[float]:
    """Return the transposed placement of an offset, `(16,)`, of the world without last column."""
    matrix = np.eye(4) if offset.transposed is None else np.array(offset.transposed)
    if offset.in_world is not None:
        matrix[:, :3] = offset.in_world[:, :, 0]
    result: list[float] = matrix.ravel().tolist()
    return result


def _mass(body: RigidBody) -> list[float]:
    return [body.mass, *body.centre.tolist(), *body.inertia.ravel().tolist()]
