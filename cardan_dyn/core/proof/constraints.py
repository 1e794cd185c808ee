"""Constraints: what positions and rates have to satisfy, checked for the proof.

Loops stay closed, couplings keep their ratio and offset, drives have the prescribed positions and
rates, and held joints rest. Everything is computed from frames and screws of plain forward
kinematics, not from the closure equations that the motion was solved with.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...kit.arrays import Array
from ..mechanism.coordinates import Coordinates
from ..tape import Scalar, absolute, greater, sqrt
from .named_motions import named_motions
from .placing import Frame
from .samples import Sample
from .screws import Screw, Screws, minus, total_of, velocity_at
from .vectors import Vector, dot, greatest, ratio, subtract, times, total

if TYPE_CHECKING:
    from ..description.description import CouplingDescription, Description
    from ..mechanism.frames import Frames


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


class Coupling(NamedTuple):
    """A coupling: a sum of factors times rates, or coordinates, that is zero, or its offset.

    Where it has higher powers of the predecessor's motion p, with coefficients a, the sum is
    offset + a_2 p² + a_3 p³ …, and factors of the predecessor's rates change with p.

    Attributes:
        coupling: its index.
        rates: joint velocities to their factors where p is zero; also the effort along each of them
            per unit moment of the coupling.
        columns: coordinates to the same factors.
        offset: [rad, or m].
        scale: what a slip is divided by.
        first: coordinates whose sum is p, to their joint velocities.
        higher: powers of p to their coefficients.
    """

    coupling: int
    rates: dict[int, float]
    columns: dict[int, float]
    offset: float
    scale: float
    first: dict[int, int]
    higher: dict[int, float]

    def factors(self, x: Sequence[Scalar]) -> dict[int, Scalar]:
        """Return joint velocities to their factors at coordinates."""
        result: dict[int, Scalar] = dict(self.rates)
        if self.higher:
            first = total([x[column] for column in self.first])
            slopes = [value * power * _power(first, power - 1) for power, value in self.items]
            for rate in self.first.values():
                result[rate] = total([result[rate], *(-slope for slope in slopes)])
        return result

    @property
    def items(self) -> list[tuple[int, float]]:
        """Its higher powers and their coefficients."""
        return list(self.higher.items())

    def bent(self, x: Sequence[Scalar], v: Sequence[Scalar]) -> Scalar:
        """Return how fast factors times constant rates change."""
        if not self.higher:
            return 0.0
        first = total([x[column] for column in self.first])
        rate = total([v[rate] for rate in self.first.values()])
        terms = [
            value * power * (power - 1) * _power(first, power - 2) for power, value in self.items
        ]
        return -(total(terms) * rate * rate)


class Around(NamedTuple):
    """A loop whose joints all move as is claimed.

    Attributes:
        loop: its index.
        ahead, behind: motions around it on its predecessor's side, and on its successor's.
        last: the motion at whose origin its gap opens, -1 at the corner.
    """

    loop: int
    ahead: list[int]
    behind: list[int]
    last: int


def _power(x: Scalar, power: int) -> Scalar:
    """Return a whole power."""
    result: Scalar = 1.0
    for _ in range(power):
        result = result * x
    return result


class Constraints:
    """The loops, couplings, drives and held joints of a scene.

    Attributes:
        rate_scale: `(nv,)` the characteristic length for slides, 1 for angles: what rates are
            divided by, and efforts multiplied with, to compare those of slides with those of turns.
        known_rates: joint velocities that are claimed to be known.
        driven, held: turns and slides of the drives and of the held joints.
        around: the loops whose joints all move as is claimed.
        every_coupling: the couplings of the description.
        couplings: those whose joints all move as is claimed.
    """

    def __init__(
        self,
        description: Description,
        coordinates: Coordinates,
        screws: Screws,
        length: float,
        motion: Motion,
    ) -> None:
        """Lay out the constraints.

        Args:
            description: with the numbers of the second reading.
            coordinates: layout of coordinates and rates.
            screws: of the description's joints.
            length: characteristic length [m].
            motion: what is driven, held and known.
        """
        self._screws, self._length = screws, length
        frames, known = screws.frames, motion.known
        self.rate_scale = [1.0] * coordinates.model.nv
        for rate in screws.slides:
            self.rate_scale[rate] = length
        named = named_motions(frames)
        self.driven = [named[name] for name in motion.drives]
        self.held = [named[name] for name in motion.held]
        self.known_rates = np.flatnonzero(known).tolist()
        self.every_coupling = [
            self._coupling(index, item, coordinates)
            for index, item in enumerate(description.couplings)
        ]
        self.couplings = [item for item in self.every_coupling if all(known[[*item.rates]])]
        self.around = []
        for loop in range(len(frames.ends)):
            ahead, behind = self._motions_around(loop)
            owned = zip(screws.rates, screws.owners, strict=True)
            if np.all(known[[rate for rate, owner in owned if owner in (*ahead, *behind)]]):
                last = frames.last[frames.tree + loop]
                self.around.append(Around(loop, ahead, behind, last))

    def coupling_factors(self, x: Array) -> Array:
        """Return `(N, G, nv)` the factors on rates of `couplings` at coordinates `(N, size)`."""
        factors = np.zeros((len(x), len(self.couplings), len(self.rate_scale)))
        for row, item in enumerate(self.couplings):
            for rate, factor in item.factors(list(x.T)).items():
                factors[:, row, rate] = factor
        return factors

    def _coupling(
        self, index: int, item: CouplingDescription, coordinates: Coordinates
    ) -> Coupling:
        predecessors, successors = coupled_joints(item, self._screws.frames)
        factors = dict.fromkeys(predecessors, -item.ratio) | dict.fromkeys(successors, 1.0)
        rates = {coordinates.velocity_columns[name].start: factors[name] for name in factors}
        columns = {coordinates.columns[name].start: factors[name] for name in factors}
        # A slip is a motion of the successor. Where only the predecessor's joints are left, it is
        # one of these times the ratio.
        decisive = [rate for rate, factor in rates.items() if factor == 1.0] or [*rates]
        sizes = [abs(rates[rate]) * self.rate_scale[rate] for rate in decisive]
        first = {
            coordinates.columns[name].start: coordinates.velocity_columns[name].start
            for name in predecessors
        }
        higher = dict(enumerate(item.higher, 2))
        scale = max(sizes, default=0.0)
        return Coupling(index, rates, columns, item.offset, scale, first, higher)

    def _motions_around(self, loop: int) -> tuple[list[int], list[int]]:
        """Return the motions around a loop on either side, see `Around`."""
        frames = self._screws.frames
        joint = frames.tree + loop
        first = {joint, *frames.path(frames.parents[joint])}
        second = set(frames.path(frames.children[joint]))
        ahead, behind = (
            [index for index, motion in enumerate(frames.motions) if motion.joint in joints]
            for joints in (first - second, second - first)
        )
        return ahead, behind

    def position_error(self, sample: Sample, placed: Sequence[Frame]) -> Scalar:
        """Return the greatest violation of loops, couplings, drives and held joints.

        Angles [rad], lengths as fractions of the characteristic length; see `Sweep.loop_residual`.
        """
        return greater(
            sqrt(greatest(self._squared_gaps(placed))), greatest(self._position_errors(sample))
        )

    def _position_errors(self, sample: Sample) -> Iterator[Scalar]:
        """Yield those of couplings, drives and held joints."""
        for item in self.couplings:
            terms = [
                times(total([sample.x[column], math.tau * sample.turns[column]]), factor)
                for column, factor in item.columns.items()
            ]
            if item.higher:
                moved = total([sample.x[column] for column in item.first])
                terms += [-value * _power(moved, power) for power, value in item.items]
            yield (total(terms) - item.offset) / item.scale
        prescribed = (*sample.positions, *sample.held)
        for motion, position in zip((*self.driven, *self.held), prescribed, strict=True):
            # A position of many turns is known only up to the rounding of its great number.
            scale = greater(self.rate_scale[motion.rate], absolute(position))
            yield (sample.x[motion.column] - position) / scale

    def openings(self, sample: Sample, placed: Sequence[Frame]) -> list[Scalar]:
        """Return what should be zero of loops, couplings, drives and held joints.

        Of loops, differences of axes between both ends, and the relative gap.
        """
        gaps = [part for vectors in self._gaps(placed) for vector in vectors for part in vector]
        return [*gaps, *self._position_errors(sample)]

    def _gaps(self, placed: Sequence[Frame]) -> Iterator[list[Vector]]:
        """Yield by what the axes at both ends of each loop differ, and the relative gap."""
        placing, length = self._screws.placing, self._length
        for item in self.around:
            start = placing.at(placed, placing.joints[self._screws.frames.tree + item.loop])
            end = placing.at(placed, placing.loop_ends[item.loop])
            apart = [subtract(one, other) for one, other in zip(start.axes, end.axes, strict=True)]
            gap = subtract(start.origin, end.origin)
            yield [*apart, (gap[0] / length, gap[1] / length, gap[2] / length)]

    def _squared_gaps(self, placed: Sequence[Frame]) -> Iterator[Scalar]:
        """Yield the squares of the angle and of the relative gap between both ends of each loop.

        Between frames that are turned by an angle φ, the squared differences of the three axes
        add up to 2 (2 sin φ/2)², which is 2 φ² for small angles.
        """
        for *apart, gap in self._gaps(placed):
            squares: Scalar = 0.0
            for difference in apart:
                squares = squares + dot(difference, difference)
            yield 0.5 * squares
            yield dot(gap, gap)

    def drive_rate_error(self, sample: Sample) -> Scalar:
        """Return how far rates of the drives are from the prescribed ones, relative.

        Velocity ratios of drives have to be one and zero.
        """
        errors = [
            ratios[motion.rate] - (1.0 if drive == other else 0.0)
            for drive, ratios in enumerate(sample.ratios)
            for other, motion in enumerate(self.driven)
        ]
        given = ((sample.v, sample.speeds), (sample.a, sample.accelerations))
        for rates, prescribed in given if sample.moves else ():
            apart = [
                rates[motion.rate] - own
                for motion, own in zip(self.driven, prescribed, strict=True)
            ]
            errors.append(ratio(greatest(apart), greatest(prescribed)))
        return greatest(errors)

    def slip(
        self, rates: Sequence[Scalar], x: Sequence[Scalar], v: Sequence[Scalar] | None = None
    ) -> Scalar:
        """Return how fast couplings slip and held joints move, slides over the length.

        Args:
            rates: joint velocities, or accelerations.
            x: coordinates.
            v: joint velocities where rates are accelerations.
        """
        slips = [self._as_angle(rates, item.rate) for item in self.held]
        for item in self.couplings:
            terms = [times(rates[rate], factor) for rate, factor in item.factors(x).items()]
            if v is not None:
                terms.append(item.bent(x, v))
            slips.append(total(terms) / item.scale)
        return greatest(slips)

    def opening(self, placed: Sequence[Frame], relative: Sequence[Screw]) -> Scalar:
        """Return how fast the two ends of a loop move apart [rad/s], gaps over the length.

        Around a closed loop, the twists of the joints add up to zero, and so do their rates with
        what carries them: Σ ± S q̇ = 0, Σ ± (S q̈ + Ṡ q̇) = 0 (Featherstone 2008, chapter 8).

        Args:
            placed: frames of all motions.
            relative: what each motion adds to twists, or to their rates.
        """
        gaps: list[Scalar] = []
        angles: list[Scalar] = []
        for item in self.around:
            ahead, behind = (
                total_of([relative[motion] for motion in side])
                for side in (item.ahead, item.behind)
            )
            apart = minus(ahead, behind)
            # The gap opens at the loop's joint, not at the corner.
            gaps += apart[0] if item.last < 0 else velocity_at(placed[item.last].origin, apart)
            angles += apart[1]
        return greater(greatest(gaps) / self._length, greatest(angles))

    def greatest_rate(self, rates: Sequence[Scalar]) -> Scalar:
        """Return the greatest of the known rates, slides over the length."""
        return greatest([self._as_angle(rates, rate) for rate in self.known_rates])

    def _as_angle(self, rates: Sequence[Scalar], rate: int) -> Scalar:
        scale = self.rate_scale[rate]
        return rates[rate] if scale == 1.0 else rates[rate] / scale


def coupled_joints(
    coupling: CouplingDescription, frames: Frames
) -> tuple[Collection[str], Collection[str]]:
    """Return the joints that move the predecessor of a coupling, and those of its successor."""
    if coupling.of_joints:
        return [coupling.predecessor], [coupling.successor]
    first, second = (
        {frames.joints[joint] for joint in frames.path(frames.links[link][0])} - frames.origins
        for link in (coupling.predecessor, coupling.successor)
    )
    # Joints on both paths move both links alike, which the coupling does not feel.
    return first - second, second - first
