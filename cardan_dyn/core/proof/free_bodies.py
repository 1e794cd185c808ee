"""Free bodies: the proof of a result, independent of how the result was computed.

Every body of the description is cut free. Mass, centre and inertia are those of the URDF text, read
a second time (of MJCF, those that its reader returned), and bodies are placed by plain forward
kinematics. On a body act its weight, the loads, and the returned wrenches of its joints, loops
included; the difference between their sum and its momentum rates is an imbalance. Loops have to be
closed in positions and in rates, along each coordinate only loads, couplings, drives and holding
efforts may act, less what accelerates the rotors there, and power has to balance.

All this is written once, as plain arithmetic of one sample, see `samples`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from copy import copy
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...kit.arrays import Array
from ..mechanism.coordinates import Coordinates
from ..mechanism.frames import Frames, RigidBody, merged
from ..mechanism.kept import Kept
from ..tape import Scalar, absolute, greater
from .constraints import Constraints, Motion
from .effort_balance import EffortBalance
from .momentum import Massive
from .placing import Frame
from .residuals import Claim, Residuals
from .samples import Rows, Sample, Scalars
from .screws import NOTHING, Screw, Screws, about, by, in_world, minus, power, total_of
from .self_stress import SelfStressProof, prove_flags
from .traced import Programs
from .vectors import ZERO, greatest, greatest_norm, norm, ratio, times, total

if TYPE_CHECKING:
    from ..description.description import Description
    from ..elements.element import Element
    from .element_loads import ElementLoads, ProvenElements
    from .tooth_forces import MeshingGears


class Setup(NamedTuple):
    """What a problem prescribes, and what is claimed to be solved of it.

    Attributes:
        motion: what is driven, held and known.
        joints: names of those whose wrenches are claimed to be known.
    """

    motion: Motion
    joints: list[str]


class _Rates(NamedTuple):
    """The rates of a sample.

    Attributes:
        error: greatest violation of loops, couplings, drives and held joints, relative.
        unit: twists of all motions' frames with every drive at unit speed.
        motions: twists of these frames, and their rates; None at rest.
    """

    error: Scalar
    unit: Sequence[Screw]
    motions: Sequence[tuple[Screw, Screw]] | None


class _Applied(NamedTuple):
    """What acts on bodies beside their joints.

    Attributes:
        wrenches: bodies (index) and wrenches on them, about the corner.
        power: with every drive at unit speed [W].
        size: of the greatest load or weight [N·m].
        inertia: see `Residuals.inertia`.
    """

    wrenches: Sequence[tuple[int, Screw]]
    power: Scalar
    size: Scalar
    inertia: Scalar = 0.0

    def by(self, factor: Scalar) -> _Applied:
        """Return the product with a factor."""
        wrenches = [(body, by(wrench, factor)) for body, wrench in self.wrenches]
        size = absolute(factor)
        return _Applied(wrenches, self.power * factor, self.size * size, self.inertia * size)


class FreeBodies:
    """The bodies of a description, each cut free.

    Attributes:
        frames: frames of the description.
        claimed: indices of the joints whose wrenches are claimed to be known.
        unproven: links with joints whose wrenches are not claimed to be known.
    """

    def __init__(
        self,
        description: Description,
        coordinates: Coordinates,
        length: float,
        setup: Setup,
        kept: Kept | None = None,
    ) -> None:
        """Cut the bodies free.

        Args:
            description: with the numbers of the second reading.
            coordinates: layout of coordinates and rates.
            length: characteristic length, that forces are multiplied with to compare them with
                moments [m].
            setup: what is prescribed and claimed.
            kept: of the description; nothing yet if None.
        """
        kept, motion = kept or Kept(), setup.motion
        self._screws = kept.of(
            "screws of the proof", None, lambda: Screws(Frames(description, coordinates))
        )
        self.frames = frames = self._screws.frames
        self._length = length
        # The same for other elements, held positions and loads.
        key = motion.drives, motion.held, motion.known.tobytes(), *setup.joints
        self._programs = kept.of("programs of the proof", key, Programs)
        self.claimed = [frames.joints.index(name) for name in setup.joints]
        self._children = [frames.children[joint] for joint in self.claimed]
        self._parents = [frames.parents[joint] for joint in self.claimed]
        self._covered = _covered_bodies(frames, self.claimed)
        self.unproven = tuple(
            link
            for link, (body, _) in frames.links.items()
            if body >= 0 and body not in self._covered
        )
        self._gears: list[MeshingGears] = []
        self._by_couplings = np.zeros((len(frames.joints), 6), dtype=bool)
        if description.couplings:
            from .silent_couplings import open_by_couplings  # Few mechanisms have couplings.
            from .tooth_forces import MeshingGears

            self._gears = MeshingGears.of(description, frames)
            self._by_couplings = open_by_couplings(description, frames)
        self._massive = _massive(dict(enumerate(frames.bodies)))
        self._described = {link.name: link for link in description.links}
        self._rotors = _rotors(description, coordinates)
        self._constraints = Constraints(
            description, coordinates, self._screws, length, setup.motion
        )
        rate_scale = self._constraints.rate_scale
        self._efforts = EffortBalance(self._screws, self.claimed, rate_scale)
        known = setup.motion.known
        # The drives' efforts are all solved if the wrenches at their joints are, or if none is:
        # then virtual work gives the efforts.
        drives, held = self._constraints.driven, self._constraints.held
        driven = {motion.joint for motion in drives}
        self._power_known = bool(np.all(known)) and (
            not self.claimed or driven <= set(self.claimed)
        )
        prescribed = {motion.rate for motion in (*drives, *held)}
        self._passives = [rate for rate in np.flatnonzero(known).tolist() if rate not in prescribed]
        self._elements: ProvenElements | None = None

    def with_elements(self, elements: Sequence[Element], zero: Array) -> FreeBodies:
        """Return the same bodies with what else acts on them.

        Args:
            elements: springs, bushings, friction and actuators.
            zero: `(size,)` coordinates of the description's zero; bushings need it.
        """
        if not elements:
            return self
        from .element_loads import ProvenElements  # Most scenes have none.

        result = copy(self)
        result._elements = ProvenElements(self._screws, elements, zero, self._length)
        return result

    @cached_property
    def _stress(self) -> SelfStressProof:
        constraints = self._constraints
        indices = [item.coupling for item in constraints.couplings]
        geared = {
            indices.index(gears.coupling): gears.joints
            for gears in self._gears
            if gears.coupling in indices
        }
        loops = [item.loop for item in constraints.around]
        factors = len(indices), constraints.coupling_factors
        return SelfStressProof(self._screws, loops, *factors, self._passives, self._length, geared)

    def prove_flags(self, x: Array, unique: Array, condition: Array | float = 1.0) -> None:
        """Refuse flags of uniqueness that self-stresses contradict.

        Args:
            x: `(N, size)` coordinates of the samples that they hold for.
            unique: `(J, 6)` which components of the claimed wrenches are flagged unique.
            condition: condition numbers of the closure equations.

        Raises:
            AccuracyError: a component flagged unique changes under a self-stress, or one flagged
                not unique does not.
        """
        greatest, silent = float(np.max(condition)), self._by_couplings[self.claimed]
        prove_flags(self._stress, x, unique, self.claimed, greatest, silent)

    def check(self, claim: Claim) -> Residuals:
        """Return the residuals of a claim."""
        elements = self.exerted(claim)
        given = Rows(claim, elements), self.frames
        results = self._programs.results(self.residuals, *given)
        terms = None if elements is None else elements.terms
        return Residuals._make((*results, bool(self._covered), self._power_known, terms))

    def exerted(self, claim: Claim) -> ElementLoads | None:
        """Return what elements exert where it is claimed that they are; None without elements."""
        if self._elements is None:
            return None
        x = claim.x + 2.0 * np.pi * claim.turns
        screws, v = self._screws, list(claim.v.T)
        # What overflows is refused by those who judge residuals.
        with np.errstate(over="ignore", invalid="ignore"):
            placed, velocities = list[Frame](), None
            if self._elements.act_on_links:
                placed = screws.placing.placed(list(claim.x.T))
                if claim.has_rates:
                    velocities = screws.absolute(screws.relative(screws.units(placed), v))
            return self._elements.on(placed, velocities, x, claim.v, claim.time)

    def residuals(self, sample: Sample) -> tuple[Scalar, ...]:
        """Return the first nine fields of `Residuals` of a sample."""
        lacking, along, others = self._checked(sample)
        return greater(self._size(lacking), greatest(along)), *others

    def openings(self, sample: Sample) -> list[Scalar]:
        """Return what should be zero of positions, see `Constraints.openings`."""
        placed = self._screws.placing.placed(sample.x)
        return self._constraints.openings(sample, placed)

    def imbalances(self, sample: Sample) -> list[Scalar]:
        """Return what should be zero of wrenches [N·m].

        Net wrenches of bodies, forces times the length, and efforts along coordinates.
        """
        lacking, along, _ = self._checked(sample)
        forces = [times(part, self._length) for force, _ in lacking for part in force]
        return [*forces, *[part for _, moment in lacking for part in moment], *along]

    def _checked(self, sample: Sample) -> tuple[list[Screw], list[Scalar], tuple[Scalar, ...]]:
        """Return net wrenches of bodies, efforts along coordinates, and fields of `Residuals`."""
        constraints, scales = self._constraints, self._constraints.rate_scale
        rotors = self._rotors if sample.moves else {}
        accelerated = {rate: sample.a[rate] * inertia for rate, inertia in rotors.items()}
        if accelerated:
            loads = list(sample.loads)
            for rate, effort in accelerated.items():
                loads[rate] = loads[rate] - effort
            sample = sample._replace(loads=loads)
        still = [0.0] * len(scales)
        placed = self._screws.placing.placed(sample.x)
        joint_frames = self._screws.placing.joint_frames(placed)
        unit = [total(of_drives) for of_drives in zip(still, *sample.ratios, strict=True)]
        rates = self._rates(sample, placed, unit)
        on_children = [
            in_world(wrench, joint_frames[joint])
            for joint, wrench in zip(self.claimed, sample.wrenches, strict=True)
        ]
        applied = [*self._loads(sample, placed, rates), *self._inertia(sample, placed, rates)]
        teeth = [
            gears.wrench(self.frames, placed, sample.couplings[gears.coupling])
            for gears in self._gears
        ]
        acting = [wrench for item in applied for wrench in item.wrenches]
        acting += zip(self._children, on_children, strict=True)
        acting += zip([gears.bodies[1] for gears in self._gears], teeth, strict=True)
        reacting = [*zip(self._parents, on_children, strict=True)]
        reacting += zip([gears.bodies[0] for gears in self._gears], teeth, strict=True)
        lacking = [
            about(joint_frames[body].origin, minus(_sum_on(body, acting), _sum_on(body, reacting)))
            for body in self._covered
        ]
        given = placed, sample.wrenches, on_children, self._given(sample)
        along = self._efforts.imbalances(*given)
        powers = [_power_along(sample.loads, unit), _power_along(sample.exerted, unit)]
        powers += [item.power for item in applied]
        loads = [times(load, scale) for load, scale in zip(sample.loads, scales, strict=True)]
        inertia = [times(absolute(effort), scales[rate]) for rate, effort in accelerated.items()]
        others = (
            absolute(total(powers)),
            constraints.position_error(sample, placed),
            rates.error,
            self._size(sample.wrenches),
            greatest([*loads, *[item.size for item in applied]]),
            total([*[item.inertia for item in applied], *inertia]),
            total(map(absolute, powers)),
            constraints.greatest_rate(unit),
        )
        return lacking, along, others

    def _rates(self, sample: Sample, placed: Sequence[Frame], unit: Scalars) -> _Rates:
        """Return the rates of a sample and their errors, see `_Rates`.

        Args:
            sample: of a claim.
            placed: frames of all motions.
            unit: joint velocities with every drive at unit speed.
        """
        screws, constraints = self._screws, self._constraints
        units = screws.units(placed)

        def violation(
            rates: Scalars, relative: Sequence[Screw], v: Scalars | None = None
        ) -> Scalar:
            slip = constraints.slip(rates, sample.x, v)
            return greater(slip, constraints.opening(placed, relative))

        errors, relative = [constraints.drive_rate_error(sample)], [NOTHING] * len(placed)
        for ratios in sample.ratios:
            relative = screws.relative(units, ratios)
            errors.append(ratio(violation(ratios, relative), constraints.greatest_rate(ratios)))
        if len(sample.ratios) > 1:
            relative = screws.relative(units, unit)
        unit_twists = screws.absolute(relative)
        if not sample.moves:
            # Then every rate is an error.
            errors.append(ratio(greatest([*sample.v, *sample.a]), 0.0))
            return _Rates(greatest(errors), unit_twists, None)
        relative = screws.relative(units, sample.v)
        velocities = screws.absolute(relative)
        changes = screws.changes(units, sample.a, relative, velocities)
        fastest = constraints.greatest_rate(sample.v)
        # Accelerations contain centripetal terms, which grow with the square of the speed.
        size = constraints.greatest_rate(sample.a) + fastest * fastest
        errors.append(ratio(violation(sample.v, relative), fastest))
        errors.append(ratio(violation(sample.a, changes, sample.v), size))
        motions = list(zip(velocities, screws.absolute(changes), strict=True))
        return _Rates(greatest(errors), unit_twists, motions)

    def _loads(self, sample: Sample, placed: Sequence[Frame], rates: _Rates) -> Iterator[_Applied]:
        """Yield loads on links, and what elements exert."""
        for push in sample.pushes:
            motion = self.frames.last[push.body]
            wrench = push.on(placed)
            size = self._size([about(placed[motion].origin, wrench)])
            yield _Applied([(push.body, wrench)], power(wrench, rates.unit[motion]), size)

    def _inertia(
        self, sample: Sample, placed: Sequence[Frame], rates: _Rates
    ) -> Iterator[_Applied]:
        """Yield weights and inertia of all bodies together, then what factors on links add."""
        if sample.gravity is ZERO and rates.motions is None:
            return
        yield self._inertial(self._massive, sample, placed, rates)
        for link, factor in sample.inertia.items():
            body, placement = self.frames.links[link]
            alone = _massive({body: merged(self._described, {link: placement})})
            yield self._inertial(alone, sample, placed, rates).by(factor - 1.0)

    def _inertial(
        self,
        bodies: Mapping[int, Massive],
        sample: Sample,
        placed: Sequence[Frame],
        rates: _Rates,
    ) -> _Applied:
        """Return weights less momentum rates of bodies that have mass."""
        wrenches, powers, turning = [], [], []
        for body, massive in bodies.items():
            last = self.frames.last[body]
            motion = None if rates.motions is None else rates.motions[last]
            wrench = massive.inertial_wrench(placed[last], sample.gravity, motion)
            wrenches.append((body, wrench))
            powers.append(power(wrench, rates.unit[last]))
            if motion is not None:
                turning.append(massive.turning(motion, self._length))
        heaviest = max((massive.mass for massive in bodies.values()), default=0.0)
        weight = norm(sample.gravity) * (self._length * heaviest)
        inertia = total([greatest(turning), self._of_slides(sample) * heaviest])
        return _Applied(wrenches, total(powers), weight, inertia)

    def _of_slides(self, sample: Sample) -> Scalar:
        """Return what the rounding of slides adds to the size of inertial terms [N·m/kg].

        Slides whose motions cancel leave a body where it is, but their rounding does not cancel.
        Nor does that of a velocity times the momentum along it, all there is where a body slides
        steadily.
        """
        slides = self._screws.slides
        fastest, most = (greatest([of[rate] for rate in slides]) for of in (sample.v, sample.a))
        return self._length * most + fastest * fastest

    def _given(self, sample: Sample) -> list[Scalar]:
        """Return what loads, drives, held joints and couplings exert along all rates [N·m, N]."""
        given = [total(efforts) for efforts in zip(sample.loads, sample.exerted, strict=True)]
        geared = {gears.coupling for gears in self._gears}
        for item in self._constraints.every_coupling:
            # Teeth exert what their coupling would.
            for rate, factor in () if item.coupling in geared else item.factors(sample.x).items():
                given[rate] = total([given[rate], times(sample.couplings[item.coupling], factor)])
        return given

    def _size(self, wrenches: Sequence[Screw]) -> Scalar:
        """Return the greatest size [N·m] of wrenches: moments, and forces times the length."""
        forces = greatest_norm([force for force, _ in wrenches])
        moments = greatest_norm([moment for _, moment in wrenches])
        return greater(self._length * forces, moments)


def _covered_bodies(frames: Frames, claimed: Collection[int]) -> set[int]:
    """Return the bodies the wrenches of all of whose joints are claimed."""
    others = set(range(len(frames.joints))) - set(claimed)
    return set(range(frames.tree)) - {
        body for joint in others for body in (frames.parents[joint], frames.children[joint])
    }


def _sum_on(body: int, wrenches: Sequence[tuple[int, Screw]]) -> Screw:
    """Return the sum of those wrenches that act on a body."""
    return total_of([wrench for on, wrench in wrenches if on == body])


def _rotors(description: Description, coordinates: Coordinates) -> dict[int, float]:
    """Return rates to the inertia of rotors along them, where there are any."""
    found: dict[int, float] = {}
    for item in description.joints_and_loops:
        if item.armature and item.type != "fixed":
            span = coordinates.velocity_columns[item.name]
            rates = range(span.start, span.stop)
            # One more number for each of a ball's further rates.
            every = [*item.armature, *item.armature[-1:] * (len(rates) - len(item.armature))]
            found |= {rate: x for rate, x in zip(rates, every, strict=True) if x}
    return found


def _massive(bodies: Mapping[int, RigidBody]) -> dict[int, Massive]:
    """Return those bodies that have mass or inertia, by their index."""
    return {
        index: Massive.of(body)
        for index, body in bodies.items()
        if body.mass > 0.0 or np.any(body.inertia)
    }


def _power_along(efforts: Scalars, rates: Scalars) -> Scalar:
    """Return the power of efforts at rates [W]."""
    return total([effort * rate for effort, rate in zip(efforts, rates, strict=True)])
