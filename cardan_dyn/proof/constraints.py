"""Constraints: what positions and rates have to satisfy, checked for the proof.

Loops stay closed, couplings keep their ratio, drives are where and as fast as they were asked to
be, and held joints rest. All of it is seen from placements and twists by plain forward kinematics.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array
from ..mechanism.coordinates import Coordinates
from ..mechanism.frames import Frames
from .residuals import Claim, ratio
from .twists import Twists, cross

if TYPE_CHECKING:
    from ..description.description import Description


class Constraints:
    """The loops, couplings, drives and held joints of a scene.

    Attributes:
        loops: numbers of the loops whose joints all move as is claimed.
        gears: `(G, nv)` factors of the rates that couplings make proportional; also the effort
            along each rate per unit moment of a coupling.
        geared: numbers of the couplings whose joints all move as is claimed.
    """

    def __init__(
        self,
        description: Description,
        coordinates: Coordinates,
        frames: Frames,
        twists: Twists,
        length: float,
        drives: tuple[str, ...],
        held: Mapping[str, float],
        known: Array,
    ) -> None:
        """Lay out the constraints.

        Args:
            description: from `reread`.
            coordinates: what the columns of coordinates and rates mean.
            frames: where everything is.
            twists: of its joints.
            length: characteristic length [m].
            drives: names of the driven joints.
            held: held joints to their positions [rad or m].
            known: `(nv,)` whether a rate is claimed to be known.
        """
        self._frames, self._twists, self._length = frames, twists, length
        self._known = known
        self._rate_scale = np.ones(coordinates.model.nv)
        self._rate_scale[twists.rates[twists.sliding]] = length
        self._drives = [coordinates.velocity_columns[name].start for name in drives]
        self._unit = np.eye(len(drives))
        self._drive_columns = [coordinates.columns[name].start for name in drives]
        self._held = [coordinates.velocity_columns[name].start for name in held]
        self._held_columns = [coordinates.columns[name].start for name in held]
        self._held_at = np.array(list(held.values()), dtype=float)
        self._lay_out_couplings(description, coordinates)
        self._signs = [self._signs_around(loop) for loop in range(len(frames.ends))]
        self.loops = [
            loop
            for loop, signs in enumerate(self._signs)
            if np.all(known[twists.rates[signs[twists.owners] != 0.0]])
        ]

    def _lay_out_couplings(self, description: Description, coordinates: Coordinates) -> None:
        """Lay out the couplings: factors of the rates, and coordinates, that they couple."""
        frames, count = self._frames, len(description.couplings)
        self.gears = np.zeros((count, coordinates.model.nv))
        self._gear_columns = np.zeros((count, coordinates.size))
        for row, coupling in enumerate(description.couplings):
            first, second = (
                frames.path(frames.links[link][0])
                for link in (coupling.predecessor, coupling.successor)
            )
            for path, other, factor in ((first, second, -coupling.ratio), (second, first, 1.0)):
                for joint in set(path) - set(other):
                    name = frames.joints[joint]
                    self.gears[row, coordinates.velocity_columns[name].start] = factor
                    self._gear_columns[row, coordinates.columns[name].start] = factor
        self.geared = [row for row in range(count) if np.all(self._known[self.gears[row] != 0])]
        # A slip is a motion of the successor, and a length where that slides.
        ends = np.array([row == 1.0 if np.any(row == 1.0) else row != 0.0 for row in self.gears])
        sizes = np.abs(self.gears) * self._rate_scale * ends.reshape(self.gears.shape)
        self._gear_units = np.max(sizes, axis=1, initial=0.0)[self.geared]

    def _signs_around(self, loop: int) -> Array:
        """Return `(M,)` 1 for motions on a loop's predecessor side, -1 on its successor's."""
        frames = self._frames
        joint = frames.tree + loop
        first = {joint, *frames.path(frames.parents[joint])}
        second = set(frames.path(frames.children[joint]))
        return np.array(
            [(motion.joint in first) - float(motion.joint in second) for motion in frames.motions]
        )

    def loop_error(self, placed: Array, claim: Claim) -> Array:
        """Return `(N,)` how far positions are from what they have to be.

        See `Sweep.loop_residual`; drives and held joints count as loops do.
        """
        frames, worst = self._frames, np.zeros(len(claim.x))
        for loop in self.loops:
            joint = frames.tree + loop
            if joint in frames.fixed_placement:
                start = frames.joint_frames(placed)[joint]
            else:
                start = placed[frames.last[joint]]
            gap = start - frames.ended(placed, loop)
            gap[3] /= self._length
            # The chord of an angle is twice the sine of its half; three axes have two of it.
            square = np.einsum("cin,cin->n", gap[:3], gap[:3])
            np.maximum(worst, 0.5 * square, out=worst)
            np.maximum(worst, np.einsum("in,in->n", gap[3], gap[3]), out=worst)
        worst = np.sqrt(worst)
        if self.geared:
            slip = (claim.x + 2.0 * np.pi * claim.turns) @ self._gear_columns[self.geared].T
            worst = np.maximum(worst, np.max(np.abs(slip) / self._gear_units, axis=1))
        for columns, wanted, rates in (
            (self._drive_columns, claim.positions, self._drives),
            (self._held_columns, self._held_at, self._held),
        ):
            off = np.abs(claim.x[:, columns] - wanted) / self._rate_scale[rates]
            # Positions of many turns are exact to their own rounding.
            off /= np.maximum(1.0, np.abs(wanted) / self._rate_scale[rates])
            worst = np.maximum(worst, off.max(axis=1, initial=0.0))
        return worst

    def missed(self, claim: Claim) -> Array:
        """Return `(N,)` how far the drives' rates are from what was asked for."""
        unit = np.abs(claim.velocity_ratios[:, self._drives] - self._unit)
        worst = np.asarray(unit.max(axis=(1, 2)))
        if not claim.has_rates:
            if np.any(claim.v) or np.any(claim.a):
                worst[:] = np.inf
            return worst
        for rates, wanted in ((claim.v, claim.speeds), (claim.a, claim.accelerations)):
            off = np.abs(rates[:, self._drives] - wanted).max(axis=1)
            np.maximum(worst, ratio(off, np.abs(wanted).max(axis=1)), out=worst)
        return worst

    def slipping(self, rates: Array, size: Array) -> Array:
        """Return `(N,)` how fast couplings slip and held joints move, relative to the greatest.

        Args:
            rates: `(nv, N)`.
            size: see `parting`.
        """
        worst = np.zeros(rates.shape[1])
        if self._held:
            off = np.abs(rates[self._held]) / self._rate_scale[self._held, None]
            np.maximum(worst, ratio(off.max(axis=0), size), out=worst)
        if self.geared:
            slip = np.abs(self.gears[self.geared] @ rates) / self._gear_units[:, None]
            np.maximum(worst, ratio(slip.max(axis=0), size), out=worst)
        return worst

    def parting(self, placed: Array, added: Array, size: Array) -> Array:
        """Return `(N,)` how fast the ends of loops part, relative to the greatest rate.

        Args:
            placed: frames, see `Frames.placed`.
            added: what each motion adds to the twists, or to the accelerations, `(M, 2, 3, N)`.
            size: `(N,)` greatest rate [rad/s, or rad/s²], slides over the length.
        """
        worst = np.zeros(placed.shape[-1])
        for loop in self.loops:
            signs = self._signs[loop]
            (around,) = np.nonzero(signs)
            apart = np.einsum("m,mcin->cin", signs[around], added[around])
            end = self._frames.last[self._frames.tree + loop]
            gap = apart[0] if end < 0 else apart[0] + cross(apart[1], placed[end, 3])
            np.maximum(worst, np.abs(gap).max(axis=0) / self._length, out=worst)
            np.maximum(worst, np.abs(apart[1]).max(axis=0), out=worst)
        return ratio(worst, size)

    def greatest(self, rates: Array) -> Array:
        """Return `(N,)` the greatest of the known rates `(nv, N)`, slides over the length."""
        known = np.abs(rates[self._known]) / self._rate_scale[self._known, None]
        return np.asarray(np.max(known, axis=0, initial=0.0))
