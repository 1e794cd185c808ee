"""Free bodies: the proof of a result, independent of how the result was computed.

Every body of the description is cut free. Mass, centre and inertia are those of the URDF text, read
a second time (of MJCF, those that its reader returned), and bodies are placed by plain forward
kinematics. On a body act its weight, the loads, and the returned wrenches of its joints, loops
included; the difference between their sum and its momentum rates is an imbalance. Loops have to be
closed in positions and in rates, along each coordinate only loads, couplings, drives and holding
efforts may act, and power has to balance.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .. import compiled
from ..arrays import Array, consecutive
from ..mechanism.coordinates import Coordinates
from ..mechanism.frames import Frames, in_steps, merged
from .constraints import Constraints, Motion, prescribed_motions
from .effort_balance import EffortBalance
from .momentum import MassiveBodies
from .proof_plan import RESULTS, ProofTables, link_loads
from .residuals import Claim, Residuals, ratio
from .self_stress import SelfStressProof, prove_flags
from .twists import State, Twists, cross
from .wrenches import (
    JointWrenches,
    greatest_size,
    greatest_sizes,
    placed_in_world,
    taken_about,
)

if TYPE_CHECKING:
    from ..compiled import Plan
    from ..description.description import Description
    from ..elements.element import Element
    from ..elements.link_loads import LinkLoad
    from .element_loads import ElementLoads, ProvenElements
    from .tooth_forces import MeshingGears


_RATES_TOGETHER = 256
"""Samples, times drives, whose velocity ratios are checked together."""


class Setup(NamedTuple):
    """What a problem prescribes, and what is claimed to be solved of it.

    Attributes:
        motion: what is driven, held and known.
        joints: names of those whose wrenches are claimed to be known.
        elements: springs, bushings, friction and actuators.
        zero: `(size,)` coordinates of the description's zero; bushings need it.
    """

    motion: Motion
    joints: list[str]
    elements: Sequence[Element] = ()
    zero: Array = np.zeros(0)


class _Rates(NamedTuple):
    """The rates of a claim, and the twists that they cause.

    Attributes:
        unit: `(nv, N)` joint velocities with every drive at unit speed.
        greatest: `(N,)` the greatest of them that is known, of slides over the length.
        error: `(N,)` greatest violation of loops, couplings, drives and held joints, relative.
        velocities: `(M, 2, 3, N)` of the motions' frames; None at rest.
        accelerations: likewise; None also where no body has mass.
    """

    unit: Array
    greatest: Array
    error: Array
    velocities: Array | None
    accelerations: Array | None


class _Applied(NamedTuple):
    """Loads, weights and inertia that act on bodies.

    Attributes:
        bodies: indices of those on which they act.
        wrenches: `(B, 2, 3, N)` in world axes about `Frames.corner`.
        power: `(N,)` [W] with every drive at unit speed.
        size: `(N,)` or `(1,)` greatest load or weight [N·m].
        inertia: `(N,)` see `Residuals.inertia`.
    """

    bodies: slice | Array
    wrenches: Array
    power: Array
    size: Array
    inertia: Array


class FreeBodies:
    """The bodies of a description, each cut free.

    Wrenches and twists are `(body or joint, 2, 3, N)`, in world axes about `Frames.corner`.

    Attributes:
        frames: frames of the description.
        claimed: indices of the joints whose wrenches are claimed to be known.
        unproven: links with joints whose wrenches are not claimed to be known.
    """

    def __init__(
        self, description: Description, coordinates: Coordinates, length: float, setup: Setup
    ) -> None:
        """Cut the bodies free.

        Args:
            description: with the numbers of the second reading.
            coordinates: layout of coordinates and rates.
            length: characteristic length, that forces are multiplied with to compare them with
                moments [m].
            setup: what is prescribed and claimed.
        """
        self.frames = frames = Frames(description, coordinates)
        self._twists = twists = Twists(frames)
        self._length = length
        self._proven_flags: set[bytes] = set()
        self.claimed = [frames.joints.index(name) for name in setup.joints]
        self._order = np.argsort(self.claimed)
        self._sorted = sorted(self.claimed)
        self._is_ordered = self._sorted == self.claimed
        all_claimed = self._sorted == list(range(len(frames.joints)))
        # A slice makes no copies.
        self._chosen: slice | list[int] = slice(None) if all_claimed else self._sorted
        parents, children = (
            [of[joint] for joint in self._sorted] for of in (frames.parents, frames.children)
        )
        of_tree = [joint for joint in self._sorted if joint < frames.tree]
        self._of_tree, first = consecutive(np.array(of_tree, dtype=int)), len(of_tree)
        self._all_of_tree = first == frames.tree
        self._tree_joints = slice(first)
        self._of_loops = _in_rounds(children, first)
        self._against = _in_rounds(parents)
        self._covered = _covered_bodies(frames, self.claimed)
        self._uncovered, self._balances = (
            np.flatnonzero(~self._covered),
            bool(np.any(self._covered)),
        )
        self.unproven = tuple(
            link
            for link, (body, _) in frames.links.items()
            if body >= 0 and not self._covered[body]
        )
        self._gears: list[MeshingGears] = []
        self._by_couplings = np.zeros((len(frames.joints), 6), dtype=bool)
        if description.couplings:
            from .silent_couplings import open_by_couplings  # Few mechanisms have couplings.
            from .tooth_forces import MeshingGears

            self._gears = MeshingGears.of(description, frames)
            self._by_couplings = open_by_couplings(description, frames)
        self._massive = MassiveBodies(frames, dict(enumerate(frames.bodies)), length)
        self._described = {link.name: link for link in description.links}
        self._constraints = Constraints(description, coordinates, twists, length, setup.motion)
        self._rate_scale = self._constraints.rate_scale[:, None]
        self._efforts = EffortBalance(twists, self._sorted, self._constraints.rate_scale)
        known = setup.motion.known
        # The drives' efforts are all solved if the wrenches at their joints are, or if none is:
        # then virtual work gives the efforts.
        drives, held = prescribed_motions(frames, setup.motion)
        driven = {motion.joint for motion in drives}
        self._power_known = bool(np.all(known)) and (
            not self.claimed or driven <= set(self.claimed)
        )
        prescribed = {motion.rate for motion in (*drives, *held)}
        passives = [rate for rate in np.nonzero(known)[0].tolist() if rate not in prescribed]
        self._passives = np.array(passives, dtype=int)
        self._elements: ProvenElements | None = None
        if setup.elements:
            from .element_loads import ProvenElements  # Most scenes have none.

            self._elements = ProvenElements(frames, setup.elements, setup.zero, length)

    @cached_property
    def _stress(self) -> SelfStressProof:
        constraints = self._constraints
        factors = constraints.known_coupling_factors
        geared = {
            constraints.couplings.index(gears.coupling): gears.joints
            for gears in self._gears
            if gears.coupling in constraints.couplings
        }
        return SelfStressProof(
            self._twists, constraints.loops, factors, self._passives, self._length, geared
        )

    def prove_flags(self, x: Array, unique: Array, condition: Array | float = 1.0) -> None:
        """Refuse flags of uniqueness that self-stresses contradict.

        Flags that were proven before are not proven again.

        Args:
            x: `(N, size)` coordinates of the samples that they hold for.
            unique: `(J, 6)` which components of the claimed wrenches are flagged unique.
            condition: condition numbers of the closure equations.

        Raises:
            AccuracyError: a component flagged unique changes under a self-stress, or one flagged
                not unique does not.
        """
        flags = unique.tobytes()
        if flags not in self._proven_flags:
            greatest, silent = float(np.max(condition)), self._by_couplings[self.claimed]
            prove_flags(self._stress, x, unique, self.claimed, greatest, silent)
            self._proven_flags.add(flags)

    def check(self, claim: Claim) -> Residuals:
        """Return the residuals of a claim."""
        # Elements, changed inertia and teeth are left to NumPy.
        is_plain = self._elements is None and not (claim.inertia or self._gears)
        if compiled.kernel is not None and is_plain:
            return self._compiled_residuals(claim)
        # What overflows is refused by those who judge residuals.
        with np.errstate(over="ignore", invalid="ignore"):
            return self._residuals(claim)

    @cached_property
    def _plan(self) -> Plan:
        return ProofTables(
            self.frames,
            self._twists,
            self._constraints,
            self._massive,
            self.claimed,
            self._covered,
            self._length,
        ).plan()

    def _compiled_residuals(self, claim: Claim) -> Residuals:
        """Return what `_residuals` does, of claims without elements, teeth, factors on inertia."""
        results = np.empty((RESULTS, len(claim.x)))
        compiled.kernel.proven(
            self._plan.handle,
            results,
            *claim[:13],  # From `x` to `loads`.
            claim.gravity,
            *link_loads(self.frames, claim.link_loads),
            claim.has_rates,
        )
        return Residuals._make((*results, self._balances, self._power_known, None))

    def _residuals(self, claim: Claim) -> Residuals:
        """See `check`."""
        # Twin: `proven` of compiled/proof.c.
        state = self._twists.state(claim.x)
        every = self._nets_and_wrenches(claim)
        chosen = state.joint_frames[self._chosen]
        wrenches = placed_in_world(every[self.frames.tree :], chosen)
        rates = self._rates(state, claim)
        constraints = self._constraints
        loads, exerted = claim.loads.T, claim.exerted.T
        elements = None
        if self._elements is not None:
            x = claim.x + 2.0 * np.pi * claim.turns
            elements = self._elements.on(state, rates.velocities, x, claim.v, claim.time)
            loads = loads + elements.efforts
        net = every[: self.frames.tree]
        self._add_joint_wrenches(net, wrenches)
        power = _power(loads, rates.unit)
        of_drives = _power(exerted, rates.unit)
        power_imbalance, power_scale = power + of_drives, np.abs(power) + np.abs(of_drives)
        sizes = np.abs(loads) * self._rate_scale
        greatest = np.maximum.reduce(sizes, axis=0, initial=0.0)
        inertia = np.zeros(len(claim.x))
        for applied in self._applied(state, claim, rates, elements):
            net[applied.bodies] += applied.wrenches
            power_imbalance += applied.power
            power_scale += np.abs(applied.power)
            greatest = np.maximum(greatest, applied.size)
            inertia += applied.inertia
        for gears in self._gears:
            wrench = gears.wrench(state, self.frames, claim.couplings[:, gears.coupling])
            for body, sign in zip(gears.bodies, (-1.0, 1.0), strict=True):
                if body >= 0:
                    net[body] += sign * wrench
        if self._uncovered.size:
            net[self._uncovered] = 0.0
        taken_about(state.joint_frames[: self.frames.tree, 3], net)
        body_imbalance, wrench = greatest_sizes(every, self._length, self.frames.tree)
        given = loads + exerted
        if claim.couplings.shape[1]:
            moments = claim.couplings.T
            if self._gears:
                # Teeth exert what their couplings would.
                moments = moments.copy()
                moments[[gears.coupling for gears in self._gears]] = 0.0
            given += constraints.coupled_efforts(moments)
        effort_imbalance = self._efforts.imbalance(state, wrenches, given)
        if len(greatest) < len(inertia):
            greatest = greatest.repeat(len(inertia))
        return Residuals(
            imbalance=np.maximum(body_imbalance, effort_imbalance),
            power_imbalance=np.abs(power_imbalance),
            loop_error=constraints.position_error(state, claim),
            rate_error=rates.error,
            wrench=wrench,
            applied=greatest,
            inertia=inertia,
            power_scale=power_scale,
            speed_scale=rates.greatest,
            bodies_balanced=self._balances,
            power_balanced=self._power_known,
            elastic=None if elements is None else elements.terms,
        )

    def _nets_and_wrenches(self, claim: Claim) -> Array:
        """Return room for a wrench on every body, then the claimed ones of the joints, ascending.

        In one array `(B + J, 2, 3, N)`, so that the sizes of all are found at once.
        """
        bodies, joints = self.frames.tree, len(self.claimed)
        every = np.empty((bodies + joints, 2, 3, len(claim.x)))
        wrenches = claim.wrenches if self._is_ordered else claim.wrenches.take(self._order, 1)
        rows = wrenches.transpose(1, 2, 0)
        every[bodies:] = rows.reshape(joints, *every.shape[1:])
        return every

    def _add_joint_wrenches(self, net: Array, wrenches: JointWrenches) -> None:
        """Write the sum of the joint wrenches on each body into `net (B, 2, 3, N)`."""
        in_world = wrenches.in_world
        if not self._all_of_tree:
            net[:] = 0.0
        # Every joint of the tree acts on a body of its own.
        net[self._of_tree] = in_world[self._tree_joints]
        for joints, bodies in self._of_loops:
            net[bodies] += in_world[joints]
        for joints, bodies in self._against:
            net[bodies] -= in_world[joints]

    def _rates(self, state: State, claim: Claim) -> _Rates:
        """Return the rates of a claim, their errors and the twists of all frames."""
        twists, constraints = self._twists, self._constraints
        velocity_ratios = np.ascontiguousarray(claim.velocity_ratios.transpose(1, 2, 0))
        rates, drives, count = velocity_ratios.shape
        unit = velocity_ratios[:, 0] if drives == 1 else velocity_ratios.sum(axis=1)
        error = constraints.drive_rate_error(claim)
        together = max(1, _RATES_TOGETHER // count)
        for first in range(0, drives, together):
            ratios = velocity_ratios[:, first : first + together]
            flat = ratios.reshape(rates, -1)
            violation = constraints.slip(flat).reshape(-1, count)
            if constraints.loops:
                relative = twists.relative(state, ratios)
                # One of many drives moves few loops.
                moved = None
                if drives > 1:
                    flat_twists = relative.reshape(len(relative), -1)
                    moved = np.logical_or.reduce(flat_twists, axis=1)
                np.maximum(violation, constraints.opening(state, relative, moved), out=violation)
            scale = constraints.greatest_rate(flat).reshape(-1, count)
            worst = ratio(violation, scale)
            worst = worst[0] if len(worst) == 1 else np.maximum.reduce(worst, axis=0)
            np.maximum(error, worst, out=error)
        greatest = scale[0] if drives == 1 else constraints.greatest_rate(unit)
        if not claim.has_rates:
            return _Rates(unit, greatest, error, None, None)
        v, a = np.ascontiguousarray(claim.v.T), np.ascontiguousarray(claim.a.T)
        relative = twists.relative(state, v)
        velocities = twists.absolute(relative)
        changes = twists.relative_accelerations(state, relative, velocities, a)
        fastest = constraints.greatest_rate(v)
        # Accelerations contain centripetal terms, which grow with the square of the speed.
        size = constraints.greatest_rate(a) + fastest**2
        for rates, added, scale in ((v, relative, fastest), (a, changes, size)):
            violation = np.maximum(constraints.slip(rates), constraints.opening(state, added))
            np.maximum(error, ratio(violation, scale), out=error)
        accelerations = twists.absolute(changes) if self._massive else None
        return _Rates(unit, greatest, error, velocities, accelerations)

    def _applied(
        self, state: State, claim: Claim, rates: _Rates, elements: ElementLoads | None
    ) -> Iterator[_Applied]:
        """Yield loads and elements on links, weights and inertia together, what factors add."""
        forceless = not (claim.has_rates or np.count_nonzero(claim.gravity))
        massive = None if forceless or not self._massive else self._massive
        pushed = [] if elements is None else elements.wrenches
        if not claim.link_loads and massive is None and not pushed:
            return
        unit_twists = self._twists.absolute(self._twists.relative(state, rates.unit))
        zero = np.zeros(len(claim.x))
        wrenches = [*pushed]
        for link, load in claim.link_loads.items():
            body, placement = self.frames.links[link]
            frame = state.motion_frames[self.frames.last[body]]
            wrenches.append((body, _load_wrench(load, placement, frame)))
        for body, wrench in wrenches:
            motion = self.frames.last[body]
            power = np.einsum("kin,kin->n", wrench, unit_twists[motion])
            at_joint = taken_about(state.motion_frames[motion, None, 3], wrench[None].copy())
            size = greatest_size(at_joint, self._length)
            yield _Applied(slice(body, body + 1), wrench, power, size, zero)
        if massive is None:
            return
        yield self._weights_and_inertia(massive, state, claim, rates, unit_twists)
        for link, factor in claim.inertia.items():
            body, placement = self.frames.links[link]
            alone = merged(self._described, {link: placement})
            of_link = MassiveBodies(self.frames, {body: alone}, self._length)
            if of_link:
                whole = self._weights_and_inertia(of_link, state, claim, rates, unit_twists)
                added = factor - 1.0
                yield _Applied(
                    whole.bodies,
                    added * whole.wrenches,
                    added * whole.power,
                    np.abs(added) * whole.size,
                    np.abs(added) * whole.inertia,
                )

    def _weights_and_inertia(
        self, massive: MassiveBodies, state: State, claim: Claim, rates: _Rates, unit_twists: Array
    ) -> _Applied:
        """Return weights less momentum rates of bodies that have mass."""
        if rates.velocities is None or rates.accelerations is None:
            inertial = massive.weights(state.motion_frames, claim.gravity)
        else:
            inertial = massive.weights_less_momentum_rates(
                state.motion_frames, rates.velocities, rates.accelerations, claim.gravity
            )
            of_slides = _of_slides(self._twists, massive, claim, self._length)
            inertial = inertial._replace(size=inertial.size + of_slides)
        power = np.einsum("bkin,bkin->n", inertial.wrenches, unit_twists[massive.motions])
        size = massive.greatest_weight(claim.gravity)
        return _Applied(massive.indices, inertial.wrenches, power, size, inertial.size)


def _in_rounds(bodies: list[int], first: int = 0) -> list[tuple[slice | Array, slice | Array]]:
    """Return wrenches, and the bodies on which they act, in rounds that have a body once each.

    Args:
        bodies: per wrench, the body on which it acts, -1 for the world.
        first: index of the first wrench that counts.
    """
    rounds: list[list[tuple[int, int]]] = []
    count: dict[int, int] = {}
    for wrench, body in enumerate(bodies):
        if wrench < first or body < 0:
            continue
        number = count[body] = count.get(body, -1) + 1
        if number == len(rounds):
            rounds.append([])
        rounds[number].append((wrench, body))
    result = []
    for found in rounds:
        wrenches, on = ([*indices] for indices in zip(*found, strict=True))
        result.append((in_steps(wrenches), in_steps(on)))
    return result


def _covered_bodies(frames: Frames, claimed: Collection[int]) -> Array:
    """Return `(B,)` whether the wrenches of all joints of a body are claimed."""
    covered = np.ones(frames.tree, dtype=bool)
    for joint in set(range(len(frames.joints))) - set(claimed):
        for body in (frames.parents[joint], frames.children[joint]):
            if body >= 0:
                covered[body] = False
    return covered


def _of_slides(twists: Twists, massive: MassiveBodies, claim: Claim, length: float) -> Array:
    """Return `(N,)` what the rounding of slides adds to the size of inertial terms [N·m].

    Slides whose motions cancel leave a body where it is, but their rounding does not cancel. Nor
    does that of a velocity times the momentum along it, all there is where a body slides steadily.
    """
    slides = twists.rates[twists.sliding]
    fastest, greatest = (
        np.abs(values.take(slides, 1)).max(axis=1, initial=0.0) for values in (claim.v, claim.a)
    )
    return np.asarray(massive.greatest_mass * (length * greatest + fastest**2))


def _power(efforts: Array, rates: Array) -> Array:
    """Return `(N,)` the power of efforts `(nv, N)` or `(nv, 1)` at rates `(nv, N)` [W]."""
    return np.asarray(np.add.reduce(efforts * rates, axis=0))


def _load_wrench(load: LinkLoad, placement: Array, frame: Array) -> Array:
    """Return a load on a link as a wrench `(2, 3, N)` in world axes about `Frames.corner`.

    The link is placed `(4, 4)` in its body, whose frame is `(4, 3, N)`.
    """
    axes = np.einsum("cj,cin->jin", placement[:3, :3], frame[:3])
    place = placement[:3, :3] @ load.point + placement[:3, 3]
    point = np.einsum("c,cin->in", place, frame[:3]) + frame[3]
    force, moment = load.force.T, load.moment.T
    if not load.in_world:
        force, moment = (np.einsum("jn,jin->in", vector, axes) for vector in (force, moment))
    force = np.broadcast_to(force, point.shape)
    return np.stack([force, moment + cross(point, force)])
