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
        loops: indices of the loops whose joints all move as is claimed.
        coupling_factors: `(G, nv)`: the rates of a coupling's joints times its row add up to zero;
            also the effort along each rate per unit moment of the coupling.
        couplings: indices of the couplings whose joints all move as is claimed.
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
        self._drive_rates = [item.rate for item in driven]
        self._unit_ratios = np.eye(len(motion.drives))
        self._held_rates = [item.rate for item in held]
        self._held_scale = self.rate_scale[self._held_rates, None]
        prescribed = [*driven, *held]
        self._prescribed_columns = np.array([item.column for item in prescribed], dtype=int)
        # What the errors of angles and slides are divided by.
        self._prescribed_scale = self.rate_scale[[item.rate for item in prescribed]]
        self._lay_out_couplings(description, coordinates)
        self._signs = [self._signs_around(loop) for loop in range(len(self._frames.ends))]
        self._around = [np.flatnonzero(signs) for signs in self._signs]
        self._is_around = np.array(self._signs).reshape(-1, len(self._frames.motions)) != 0.0
        self._known_rates = consecutive(np.flatnonzero(motion.known))
        self._known_scale = self.rate_scale[self._known_rates, None]
        self.loops = [
            loop
            for loop, signs in enumerate(self._signs)
            if np.all(motion.known[twists.rates[signs[twists.owners] != 0.0]])
        ]

    @property
    def known_coupling_factors(self) -> Array:
        """The rows of `coupling_factors` that belong to `couplings`."""
        return self.coupling_factors[self.couplings]

    def _lay_out_couplings(self, description: Description, coordinates: Coordinates) -> None:
        """Lay out the factors of the rates, and of the coordinates, that couplings connect."""
        frames, count = self._frames, len(description.couplings)
        self.coupling_factors = np.zeros((count, coordinates.model.nv))
        self._column_factors = np.zeros((count, coordinates.size))
        self._offsets = np.array([coupling.offset for coupling in description.couplings])
        for row, coupling in enumerate(description.couplings):
            predecessors, successors = coupled_joints(coupling, frames)
            factors = dict.fromkeys(predecessors, -coupling.ratio) | dict.fromkeys(successors, 1.0)
            for name, factor in factors.items():
                rate = coordinates.velocity_columns[name].start
                self.coupling_factors[row, rate] = factor
                self._column_factors[row, coordinates.columns[name].start] = factor
        self.couplings = [
            row for row in range(count) if np.all(self._known[self.coupling_factors[row] != 0])
        ]
        self._slip_scale = self._slip_scales()[self.couplings][:, None]
        self._slips_of_rates = SparseRows(self.coupling_factors[self.couplings])
        self._slips_of_columns = SparseRows(self._column_factors[self.couplings])
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
            slip -= self._offsets[self.couplings][:, None]
            worst = np.maximum(worst, np.max(np.abs(slip) / self._slip_scale, axis=0))
        columns, drives = self._prescribed_columns, len(self._drive_rates)
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
        frames, worst = self._frames, np.zeros(state.motion_frames.shape[-1])
        for loop in self.loops:
            predecessor_end = state.joint_frames[frames.tree + loop]
            gap = predecessor_end - frames.ended(state.motion_frames, loop)
            # Between frames that are turned by an angle φ, the squared differences of the three
            # axes add up to 2 (2 sin φ/2)², which is 2 φ² for small angles.
            gap[3] /= self._length
            gap *= gap
            square = np.add.reduce(gap[:3].reshape(9, -1))
            np.maximum(worst, 0.5 * square, out=worst)
            np.maximum(worst, np.add.reduce(gap[3]), out=worst)
        return np.sqrt(worst)

    def drive_rate_error(self, claim: Claim) -> Array:
        """Return `(N,)` how far rates of the drives are from the prescribed ones, relative.

        Velocity ratios of drives have to be one and zero. Where a claim has no rates, all of them
        have to be zero, or the error is infinite.
        """
        unit = np.abs(claim.velocity_ratios.take(self._drive_rates, 1) - self._unit_ratios)
        worst = np.asarray(np.maximum.reduce(unit, axis=(1, 2)))
        if not claim.has_rates:
            still = claim.a is claim.v or not np.count_nonzero(claim.a)
            if not still or np.count_nonzero(claim.v):
                worst[:] = np.inf
            return worst
        for rates, prescribed in ((claim.v, claim.speeds), (claim.a, claim.accelerations)):
            error = np.abs(rates.take(self._drive_rates, 1) - prescribed).max(axis=1)
            np.maximum(worst, ratio(error, np.abs(prescribed).max(axis=1)), out=worst)
        return worst

    def slip(self, rates: Array) -> Array:
        """Return `(N,)` how fast couplings slip and held joints move.

        Slides count over the length.

        Args:
            rates: velocities or accelerations `(nv, N)`.
        """
        worst = np.zeros(rates.shape[1])
        if self._held_rates:
            moving = np.abs(rates.take(self._held_rates, 0)) / self._held_scale
            np.maximum(worst, np.maximum.reduce(moving, axis=0), out=worst)
        if self.couplings:
            slip = np.abs(self._slips_of_rates.times(rates)) / self._slip_scale
            np.maximum(worst, slip.max(axis=0), out=worst)
        return worst

    def coupled_efforts(self, moments: Array) -> Array:
        """Return the efforts `(nv, N)` of couplings along all rates for their moments `(G, N)`."""
        efforts = np.zeros((len(self.rate_scale), moments.shape[1]))
        efforts[self._efforts_of_moments.rows] = self._efforts_of_moments.times(moments)
        return efforts

    def moved_loops(self, relative: Array) -> list[int]:
        """Return which of `loops` have a joint that moves, see `opening`."""
        moves = np.flatnonzero(np.any(relative.reshape(len(relative), -1), axis=1))
        moved = np.any(self._is_around[:, moves], axis=1)
        return [loop for loop in self.loops if moved[loop]]

    def opening(self, state: State, relative: Array, loops: list[int] | None = None) -> Array:
        """Return `(…, N)` how fast the two ends of a loop move apart [rad/s], gaps over the length.

        Args:
            state: of the mechanism.
            relative: what each motion adds to the twists, or to the accelerations,
                `(M, 2, …, 3, N)`, see `Twists.relative`.
            loops: those to look at; all of `loops` if None.
        """
        worst = np.zeros((*relative.shape[2:-2], relative.shape[-1]))
        for loop in self.loops if loops is None else loops:
            around = self._around[loop]
            signs = self._signs[loop][around]
            difference = np.matmul(signs, relative.take(around, 0).reshape(len(around), -1))
            difference = difference.reshape(relative.shape[1:])
            last = self._frames.last[self._frames.tree + loop]
            if last >= 0:  # The gap opens at the loop's joint, not at the corner.
                difference[0] += cross(difference[1], state.motion_frames[last, 3])
            gaps, angles = np.maximum.reduce(np.abs(difference), axis=-2)
            np.maximum(worst, gaps / self._length, out=worst)
            np.maximum(worst, angles, out=worst)
        return worst

    def greatest_rate(self, rates: Array) -> Array:
        """Return `(N,)` the greatest of the known rates `(nv, N)`, slides over the length."""
        known = np.abs(rates[self._known_rates]) / self._known_scale
        return np.asarray(np.maximum.reduce(known, axis=0, initial=0.0))


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
