"""Constraints: what positions and rates have to satisfy, checked for the proof.

Loops stay closed, couplings keep their ratio and offset, drives have the prescribed positions and
rates, and held joints rest. Everything is computed from frames and twists of plain forward
kinematics, not from the closure equations that the motion was solved with.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..arrays import Array, consecutive
from ..mechanism.coordinates import Coordinates
from ..mechanism.frames import Offsets
from .named_motions import named_motions
from .residuals import Claim, ratio
from .twists import State, Twists, cross

if TYPE_CHECKING:
    from ..description.description import CouplingDescription, Description
    from ..mechanism.frames import ElementaryMotion, Frames


class Motion(NamedTuple):
    """Which joints are driven or held, and which move as is claimed.

    Attributes:
        drives: names of the driven joints and coordinates.
        held: names of the held joints and coordinates.
        known: `(nv,)` whether a joint velocity is claimed to be known.
    """

    drives: tuple[str, ...]
    held: tuple[str, ...]
    known: Array


def prescribed_motions(
    frames: Frames, motion: Motion
) -> tuple[list[ElementaryMotion], list[ElementaryMotion]]:
    """Return the turns and slides that are driven, and those that are held."""
    named = named_motions(frames)
    return [named[name] for name in motion.drives], [named[name] for name in motion.held]


class Constraints:
    """The loops, couplings, drives and held joints of a scene.

    Attributes:
        rate_scale: `(nv,)` the characteristic length for slides, 1 for angles: what rates are
            divided by, and efforts multiplied with, to compare those of slides with those of turns.
        known_rates: indices of the joint velocities that are claimed to be known.
        drive_rates, held_rates: those of the driven and of the held joints.
        prescribed_columns: columns in coordinate rows of the drives, then of the held joints.
        loops: indices of the loops whose joints all move as is claimed.
        signs: per loop of these, `(M,)` 1 for motions on its predecessor's side, -1 on its
            successor's, else 0.
        coupling_factors: `(G, nv)`: the rates of a coupling's joints times its row add up to zero;
            also the effort along each rate per unit moment of the coupling.
        column_factors: `(G, size)` likewise, of the coordinates, which add up to an offset.
        couplings: indices of the couplings whose joints all move as is claimed.
        offsets, slip_scales: of these, the offset, and what a slip is divided by.
    """

    def __init__(
        self,
        description: Description,
        coordinates: Coordinates,
        twists: Twists,
        length: float,
        motion: Motion,
    ) -> None:
        """Lay out the constraints.

        Args:
            description: with the numbers of the second reading.
            coordinates: layout of coordinates and rates.
            twists: of the description's joints.
            length: characteristic length [m].
            motion: what is driven, held and known.
        """
        self._frames, self._length, self._known = twists.frames, length, motion.known
        self.rate_scale = np.ones(coordinates.model.nv)
        self.rate_scale[twists.rates[twists.sliding]] = length
        driven, held = prescribed_motions(self._frames, motion)
        self.drive_rates = [item.rate for item in driven]
        self._unit_ratios = np.eye(len(motion.drives))
        self.held_rates = [item.rate for item in held]
        self._held_scale = _scale_of(self.rate_scale[self.held_rates])
        prescribed = [*driven, *held]
        self.prescribed_columns = np.array([item.column for item in prescribed], dtype=int)
        # What the errors of angles and slides are divided by.
        self._prescribed_scale = self.rate_scale[[item.rate for item in prescribed]]
        self._lay_out_couplings(description, coordinates)
        signs = [self._signs_around(loop) for loop in range(len(self._frames.ends))]
        self.known_rates = np.flatnonzero(motion.known)
        self._known_rates = consecutive(self.known_rates)
        self._known_scale = _scale_of(self.rate_scale[self._known_rates])
        self.loops = [
            loop
            for loop, around in enumerate(signs)
            if np.all(motion.known[twists.rates[around[twists.owners] != 0.0]])
        ]
        self.signs = [signs[loop] for loop in self.loops]
        # A gap counts over the length. Between frames that are turned by an angle φ, the squared
        # differences of the three axes add up to 2 (2 sin φ/2)², which is 2 φ² for small angles.
        self._gap_scale = np.array([0.5, 0.5, 0.5, length**-2])[:, None, None]
        self._closing = LoopsClosing.of(self._frames, self.loops)
        self._opening = LoopsOpening.of(self._frames, self.loops, signs)

    @property
    def known_coupling_factors(self) -> Array:
        """The rows of `coupling_factors` that belong to `couplings`."""
        return self.coupling_factors[self.couplings]

    def _lay_out_couplings(self, description: Description, coordinates: Coordinates) -> None:
        """Lay out the factors of the rates, and of the coordinates, that couplings connect."""
        frames, count = self._frames, len(description.couplings)
        self.coupling_factors = np.zeros((count, coordinates.model.nv))
        self.column_factors = np.zeros((count, coordinates.size))
        offsets = np.array([coupling.offset for coupling in description.couplings])
        for row, coupling in enumerate(description.couplings):
            predecessors, successors = coupled_joints(coupling, frames)
            factors = dict.fromkeys(predecessors, -coupling.ratio) | dict.fromkeys(successors, 1.0)
            for name, factor in factors.items():
                rate = coordinates.velocity_columns[name].start
                self.coupling_factors[row, rate] = factor
                self.column_factors[row, coordinates.columns[name].start] = factor
        self.couplings = [
            row for row in range(count) if np.all(self._known[self.coupling_factors[row] != 0])
        ]
        self.offsets = offsets[self.couplings]
        self.slip_scales = self._slip_scales()[self.couplings]
        self._slips_of_rates = SparseRows(self.coupling_factors[self.couplings])
        self._slips_of_columns = SparseRows(self.column_factors[self.couplings])
        self._efforts_of_moments = SparseRows(self.coupling_factors.T)

    def _slip_scales(self) -> Array:
        """Return `(G,)` what the slip of each coupling is divided by: a length where it is one.

        A slip is a motion of the successor. Where only the predecessor's joints are left, it is one
        of these times the ratio.
        """
        factors = self.coupling_factors
        decisive = np.array(
            [row == 1.0 if np.any(row == 1.0) else row != 0.0 for row in factors]
        ).reshape(factors.shape)
        sizes = np.abs(factors) * self.rate_scale * decisive
        return np.asarray(np.max(sizes, axis=1, initial=0.0))

    def _signs_around(self, loop: int) -> Array:
        """Return `(M,)` 1 for motions on a loop's predecessor side, -1 on its successor's."""
        frames = self._frames
        joint = frames.tree + loop
        predecessors = {joint, *frames.path(frames.parents[joint])}
        successors = set(frames.path(frames.children[joint]))
        return np.array(
            [
                (motion.joint in predecessors) - float(motion.joint in successors)
                for motion in frames.motions
            ]
        )

    def position_error(self, state: State, claim: Claim) -> Array:
        """Return `(N,)` the greatest violation of loops, couplings, drives and held joints.

        Angles [rad], lengths as fractions of the characteristic length; see `Sweep.loop_residual`.
        """
        worst = self._loop_error(state)
        if self.couplings:
            positions = claim.x + 2.0 * np.pi * claim.turns
            slip = self._slips_of_columns.times(positions.T)
            slip -= self.offsets[:, None]
            worst = np.maximum(worst, np.max(np.abs(slip) / self.slip_scales[:, None], axis=0))
        columns, drives = self.prescribed_columns, len(self.drive_rates)
        if columns.size:
            prescribed = np.empty((len(claim.x), columns.size))
            prescribed[:, :drives], prescribed[:, drives:] = claim.positions, claim.held
            error = np.abs(claim.x.take(columns, 1) - prescribed)
            # A position of many turns is known only up to the rounding of its great number.
            error /= np.maximum(self._prescribed_scale, np.abs(prescribed))
            np.maximum(worst, np.maximum.reduce(error, axis=1), out=worst)
        return worst

    def _loop_error(self, state: State) -> Array:
        """Return `(N,)` the greatest angle or relative gap between the two ends of a loop."""
        worst = np.zeros(state.motion_frames.shape[-1])
        for closing in self._closing:
            gap = state.joint_frames[closing.joints] - closing.ends.frames(state.motion_frames)
            gap *= gap
            gap *= self._gap_scale
            squares = gap.reshape(len(gap), 12, -1)
            for part in (squares[:, :9], squares[:, 9:]):
                each = np.add.reduce(part, axis=1)
                greatest = each[0] if len(each) == 1 else np.maximum.reduce(each, axis=0)
                np.maximum(worst, greatest, out=worst)
        return np.sqrt(worst)

    def drive_rate_error(self, claim: Claim) -> Array:
        """Return `(N,)` how far rates of the drives are from the prescribed ones, relative.

        Velocity ratios of drives have to be one and zero. Where a claim has no rates, all of them
        have to be zero, or the error is infinite.
        """
        unit = np.abs(claim.velocity_ratios.take(self.drive_rates, 1) - self._unit_ratios)
        worst = np.asarray(np.maximum.reduce(unit, axis=(1, 2)))
        if not claim.has_rates:
            still = claim.a is claim.v or not np.count_nonzero(claim.a)
            if not still or np.count_nonzero(claim.v):
                worst[:] = np.inf
            return worst
        for rates, prescribed in ((claim.v, claim.speeds), (claim.a, claim.accelerations)):
            error = np.abs(rates.take(self.drive_rates, 1) - prescribed).max(axis=1)
            np.maximum(worst, ratio(error, np.abs(prescribed).max(axis=1)), out=worst)
        return worst

    def slip(self, rates: Array) -> Array:
        """Return `(N,)` how fast couplings slip and held joints move.

        Slides count over the length.

        Args:
            rates: velocities or accelerations `(nv, N)`.
        """
        worst = np.zeros(rates.shape[1])
        if self.held_rates:
            moving = np.abs(rates.take(self.held_rates, 0))
            if self._held_scale is not None:
                moving /= self._held_scale
            np.maximum.reduce(moving, axis=0, out=worst)
        if self.couplings:
            slip = np.abs(self._slips_of_rates.times(rates)) / self.slip_scales[:, None]
            np.maximum(worst, slip.max(axis=0), out=worst)
        return worst

    def coupled_efforts(self, moments: Array) -> Array:
        """Return the efforts `(nv, N)` of couplings along all rates for their moments `(G, N)`."""
        efforts = np.zeros((len(self.rate_scale), moments.shape[1]))
        efforts[self._efforts_of_moments.rows] = self._efforts_of_moments.times(moments)
        return efforts

    def opening(self, state: State, relative: Array, moved: Array | None = None) -> Array:
        """Return `(…, N)` how fast the two ends of a loop move apart [rad/s], gaps over the length.

        Args:
            state: of the mechanism.
            relative: what each motion adds to the twists, or to the accelerations,
                `(M, 2, …, 3, N)`, see `Twists.relative`.
            moved: `(M,)` which motions move at all, if few do: loops without them stay closed.
        """
        worst = np.zeros((*relative.shape[2:-2], relative.shape[-1]))
        more = relative.ndim - 4
        for every in self._opening:
            loops = every if moved is None else every.with_any(moved)
            if not len(loops.around):
                continue
            parts = relative.take(loops.around, 0)
            difference = np.matmul(loops.signs, parts.reshape(*loops.around.shape, -1))
            difference = difference.reshape(len(difference), *relative.shape[1:])
            if loops.last is not None:  # The gap opens at the loop's joint, not at the corner.
                points = state.motion_frames[:, 3].take(loops.last, 0)
                if more:
                    points = points.reshape(len(points), *[1] * more, *points.shape[1:])
                difference[:, 0] += cross(difference[:, 1], points)
            difference[:, 0] /= self._length
            np.abs(difference, out=difference)
            if more:
                difference = np.maximum.reduce(difference, axis=-2)
            greatest = np.maximum.reduce(difference.reshape(-1, *worst.shape), axis=0)
            np.maximum(worst, greatest, out=worst)
        return worst

    def greatest_rate(self, rates: Array) -> Array:
        """Return `(N,)` the greatest of the known rates `(nv, N)`, slides over the length."""
        known = np.abs(rates[self._known_rates])
        if self._known_scale is not None:
            known /= self._known_scale
        return np.asarray(np.maximum.reduce(known, axis=0, initial=0.0))


class LoopsClosing(NamedTuple):
    """Loops whose two ends are compared together.

    Attributes:
        joints: of the loops, in `Frames.joints`.
        ends: where their successors are joined.
    """

    joints: slice | Array
    ends: Offsets

    @staticmethod
    def of(frames: Frames, loops: list[int]) -> list[LoopsClosing]:
        """Return some loops, those with ends on the ground apart from the others."""
        sets: dict[bool, list[int]] = {}
        for loop in loops:
            sets.setdefault(frames.loop_ends[loop].in_world is None, []).append(loop)
        return [
            LoopsClosing(
                consecutive(frames.tree + np.array(own)),
                Offsets.of([frames.loop_ends[loop] for loop in own]),
            )
            for own in sets.values()
        ]


class LoopsOpening(NamedTuple):
    """Loops around which equally many motions lie, so that their rates are compared together.

    Attributes:
        around: `(l, k)` the motions (index).
        signs: `(l, 1, k)` 1 on the predecessor's side, -1 on the successor's.
        last: `(l,)` the motions at whose origins gaps open; None at the corner.
    """

    around: Array
    signs: Array
    last: Array | None

    @staticmethod
    def of(frames: Frames, loops: list[int], signs: list[Array]) -> list[LoopsOpening]:
        """Return some loops, with the signs `(M,)` of all motions of every loop."""
        sets: dict[tuple[int, bool], list[tuple[Array, Array, int]]] = {}
        for loop in loops:
            around, last = np.flatnonzero(signs[loop]), frames.last[frames.tree + loop]
            item = around, signs[loop][None, around], last
            sets.setdefault((len(around), last >= 0), []).append(item)
        found = []
        for (_, on_body), items in sets.items():
            of, factors, lasts = (np.array(part) for part in zip(*items, strict=True))
            found.append(LoopsOpening(of, factors, lasts if on_body else None))
        return found

    def with_any(self, moved: Array) -> LoopsOpening:
        """Return those around which any of the motions lies that move, `(M,)`."""
        own = np.logical_or.reduce(moved.take(self.around), axis=1)
        last = None if self.last is None else self.last[own]
        return LoopsOpening(self.around[own], self.signs[own], last)


class SparseRows:
    """A matrix few of whose entries differ from zero, for products with many columns at once.

    Attributes:
        rows: indices of the rows that have such entries, ascending.
    """

    def __init__(self, matrix: Array) -> None:
        rows, self._columns = np.nonzero(matrix)
        self._entries = matrix[rows, self._columns][:, None]
        self.rows, self._starts = np.unique(rows, return_index=True)

    def times(self, values: Array) -> Array:
        """Return the product with `(columns, N)`, of the `rows` alone."""
        products = values.take(self._columns, 0) * self._entries
        return np.asarray(np.add.reduceat(products, self._starts, axis=0))


def _scale_of(scale: Array) -> Array | None:
    """Return units `(k, 1)` of rates, None if all are 1, since few mechanisms slide."""
    return None if np.all(scale == 1.0) else scale[:, None]


def coupled_joints(
    coupling: CouplingDescription, frames: Frames
) -> tuple[Collection[str], Collection[str]]:
    """Return the joints that move the predecessor of a coupling, and those of its successor."""
    if coupling.of_joints:
        return [coupling.predecessor], [coupling.successor]
    first, second = (
        {frames.joints[joint] for joint in frames.path(frames.links[link][0])}
        for link in (coupling.predecessor, coupling.successor)
    )
    # Joints on both paths move both links alike, which the coupling does not feel.
    return first - second, second - first
