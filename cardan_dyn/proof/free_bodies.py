"""Free bodies: the proof of a result, which takes nothing from what it proves.

Every body of the description is cut free, with mass, centre and inertia as the text of a URDF gives
them, read a second time (those of MJCF are what its reader found), and placed by plain forward
kinematics. On it act its weight, the loads, and the
wrenches of its joints as they are returned, loops included; what is left over is Newton's and
Euler's imbalance. Loops have to be closed, by positions as well as by rates, along coordinates
nothing acts but loads, couplings, drives and what holds joints, and power has to balance.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array
from ..mechanism.coordinates import Coordinates
from ..mechanism.frames import Frames
from .constraints import Constraints
from .residuals import Claim, Residuals
from .self_stress import SelfStressProof, prove_flags
from .twists import Twists, cross

if TYPE_CHECKING:
    from ..description.description import Description
    from ..forces.link_loads import LinkLoad


class FreeBodies:
    """The bodies of a description, each by itself.

    Wrenches and twists are `(body or joint, 2, 3, N)`, in world axes about `Frames.corner`.

    Attributes:
        frames: where they are.
        length: what forces are multiplied with to compare them with moments [m].
        rate_scale: `(nv,)` the length for slides, 1 for angles.
        unproven: links with joints whose wrenches nobody claims to know.
    """

    def __init__(
        self,
        description: Description,
        coordinates: Coordinates,
        length: float,
        gravity: Array,
        claimed: Iterable[str],
        drives: tuple[str, ...],
        held: Mapping[str, float],
        moving: Array,
    ) -> None:
        """Cut the bodies free.

        Args:
            description: from `reread`.
            coordinates: what the columns of coordinates and rates mean.
            length: characteristic length [m].
            gravity: `(3,)` [m/s²].
            claimed: joints whose wrenches are claimed to be known.
            drives: names of the driven joints.
            held: held joints to their positions [rad or m].
            moving: velocity coordinates whose motion is claimed to be known.
        """
        self.frames = frames = Frames(description, coordinates)
        self.length = length
        self._twists = Twists(frames)
        self._gravity = gravity
        self._proven_flags: set[bytes] = set()
        self.claimed = [frames.joints.index(name) for name in claimed]
        self._order = np.argsort(self.claimed)
        self._sorted = sorted(self.claimed)
        every = self._sorted == list(range(len(frames.joints)))
        # A slice makes no copies.
        self._chosen: slice | list[int] = slice(None) if every else self._sorted
        self._known = np.zeros(coordinates.model.nv, dtype=bool)
        self._known[moving] = True
        self._covered = np.ones(frames.tree, dtype=bool)
        for joint in set(range(len(frames.joints))) - set(self.claimed):
            for body in (frames.parents[joint], frames.children[joint]):
                if body >= 0:
                    self._covered[body] = False
        self.unproven = tuple(
            link
            for link, (body, _) in frames.links.items()
            if body >= 0 and not self._covered[body]
        )
        self._heavy = [body for body, own in enumerate(frames.bodies) if own.mass > 0.0]
        heavy = [frames.bodies[body] for body in self._heavy]
        self._moved_by = [frames.last[body] for body in self._heavy]
        self._masses = np.array([body.mass for body in heavy])[:, None, None]
        self._centres = np.array([body.centre for body in heavy]).reshape(-1, 3)
        self._inertias = np.array([body.inertia for body in heavy]).reshape(-1, 3, 3)
        # The greatest weight [N·m], forces counted times the length.
        with np.errstate(over="ignore"):  # What overflows is refused with the result.
            heaviest = np.max(self._masses, initial=0.0)
            self._pulled = float(length * np.linalg.norm(gravity) * heaviest)
        self.rate_scale = np.ones(coordinates.model.nv)
        self.rate_scale[self._twists.rates[self._twists.sliding]] = length
        self._lay_out_efforts()
        self._constraints = Constraints(
            description, coordinates, frames, self._twists, length, drives, held, self._known
        )
        # Where no wrench is claimed, the drives' efforts are all the same.
        driving = {frames.joints.index(name) for name in drives}
        self._powered = bool(np.all(self._known)) and (
            not self.claimed or driving <= set(self.claimed)
        )
        rates = {coordinates.velocity_columns[name].start for name in (*drives, *held)}
        passives = [rate for rate in np.nonzero(self._known)[0].tolist() if rate not in rates]
        self._passives = np.array(passives, dtype=int)

    def _lay_out_efforts(self) -> None:
        """Say which component of which claimed wrench acts along each rate."""
        frames, twists = self.frames, self._twists
        owners = [frames.motions[owner].joint for owner in twists.owners]
        place = {joint: place for place, joint in enumerate(self._sorted)}
        rows = [row for row, joint in enumerate(owners) if joint in place]
        # In the frame of a joint's last motion its wrench is what was returned.
        last = [row for row in rows if frames.last[owners[row]] == twists.owners[row]]
        inner = [row for row in rows if row not in set(last)]
        self._last_rows, self._inner_rows = np.array(last, dtype=int), np.array(inner, dtype=int)
        self._last_joints = np.array([place[owners[row]] for row in last], dtype=int)
        self._inner_joints = np.array([place[owners[row]] for row in inner], dtype=int)
        self._last_parts = np.where(twists.sliding[self._last_rows], 0, 1)

    @cached_property
    def _stress(self) -> SelfStressProof:
        known = self._constraints
        gears = known.gears[known.geared]
        return SelfStressProof(
            self.frames, self._twists, known.loops, gears, self._passives, self.length
        )

    def prove_flags(self, x: Array, unique: Array, condition: float = 1.0) -> None:
        """Refuse flags that self-stresses contradict; those that were proven before pass.

        Args:
            x: `(N, size)` coordinates of the samples that they hold for.
            unique: `(J, 6)` which components of the claimed wrenches are flagged unique.
            condition: greatest condition number of the closure equations.

        Raises:
            AccuracyError: a component flagged unique changes, or one flagged open does not.
        """
        flags = unique.tobytes()
        if flags not in self._proven_flags:
            prove_flags(self._stress, x, unique, self.claimed, condition)
            self._proven_flags.add(flags)

    def check(self, claim: Claim) -> Residuals:
        """Return what is left over of a claim."""
        frames, twists, count = self.frames, self._twists, len(claim.x)
        placed = frames.placed(claim.x)
        at = frames.joint_frames(placed)
        directions = twists.directions(placed)
        own = np.ascontiguousarray(claim.wrenches[:, self._order].transpose(1, 2, 0))
        own = own.reshape(len(self.claimed), 2, 3, count)
        world = np.einsum("jkcn,jcin->jkin", own, at[self._chosen, :3])
        world[:, 1] += cross(at[self._chosen, 3], world[:, 0])
        left = np.zeros((frames.tree, 2, 3, count))
        for joint, wrench in zip(self._sorted, world, strict=True):
            parent, child = frames.parents[joint], frames.children[joint]
            if child >= 0:
                left[child] += wrench
            if parent >= 0:
                left[parent] -= wrench

        ratios = np.ascontiguousarray(claim.velocity_ratios.transpose(2, 1, 0))
        virtual = ratios[0] if len(ratios) == 1 else ratios.sum(axis=0)
        loads = np.ascontiguousarray(np.broadcast_to(claim.loads, claim.v.shape).T)
        exerted = np.ascontiguousarray(claim.exerted.T)
        power = [np.einsum("kn,kn->n", part, virtual) for part in (loads, exerted)]
        acting = [np.max(np.abs(loads) * self.rate_scale[:, None], axis=0, initial=0.0)]
        inertial = np.zeros(count)
        units = twists.units(placed, directions)
        constraints = self._constraints
        rate_error = constraints.missed(claim)
        for part in ratios:
            size = constraints.greatest(part)
            np.maximum(rate_error, constraints.slipping(part, size), out=rate_error)
            if constraints.loops:
                added = twists.own(units, part)
                np.maximum(rate_error, constraints.parting(placed, added, size), out=rate_error)
        velocity = acceleration = None
        if claim.has_rates:
            v, a = np.ascontiguousarray(claim.v.T), np.ascontiguousarray(claim.a.T)
            each = twists.own(units, v)
            velocity = twists.summed(each)
            changes = twists.changes(units, each, velocity, a)
            fastest = constraints.greatest(v)
            # Of an acceleration, centripetal terms are part.
            size = constraints.greatest(a) + fastest**2
            for part, added, scale in ((v, each, fastest), (a, changes, size)):
                np.maximum(rate_error, constraints.slipping(part, scale), out=rate_error)
                np.maximum(rate_error, constraints.parting(placed, added, scale), out=rate_error)
            if self._heavy:
                acceleration = twists.summed(changes)
        if claim.link_loads or (self._heavy and (claim.has_rates or self._pulled)):
            displaced = twists.summed(twists.own(units, virtual))
            for link, load in claim.link_loads.items():
                body, wrench = self._load(link, load, placed)
                left[body] += wrench
                power.append(np.einsum("kin,kin->n", wrench, displaced[frames.last[body]]))
                acting.append(self._size(wrench[None], placed[[frames.last[body]], 3]))
            if self._heavy:
                wrench, inertial = self._weight_and_inertia(placed, velocity, acceleration)
                if claim.has_rates and np.any(twists.sliding):
                    # Slides that make up for each other leave a body where it is.
                    slides = np.abs(a[twists.rates[twists.sliding]]).max(axis=0)
                    inertial = inertial + np.max(self._masses) * self.length * slides
                left[self._heavy] += wrench
                power.append(np.einsum("bkin,bkin->n", wrench, displaced[self._moved_by]))
                acting.append(np.full(count, self._pulled))
        left[~self._covered] = 0.0
        imbalance = self._size(left, at[: frames.tree, 3])
        imbalance = np.maximum(
            imbalance, self._effort_imbalance(own, world, placed, directions, loads, claim)
        )
        return Residuals(
            imbalance=imbalance,
            power_imbalance=np.abs(np.sum(power, axis=0)),
            loop_error=constraints.loop_error(placed, claim),
            rate_error=rate_error,
            wrench=self._size(own, None),
            applied=np.max(acting, axis=0),
            inertia=inertial,
            power_scale=np.sum(np.abs(power), axis=0),
            speed_scale=constraints.greatest(virtual),
            bodies_balanced=bool(np.any(self._covered)),
            power_balanced=self._powered,
        )

    def _load(self, link: str, load: LinkLoad, placed: Array) -> tuple[int, Array]:
        """Return a link's body and the wrench on it, about the corner."""
        body, placement = self.frames.links[link]
        frame = placed[self.frames.last[body]]
        axes = np.einsum("cj,cin->jin", placement[:3, :3], frame[:3])
        point = np.einsum("c,cin->in", placement[:3, 3], frame[:3]) + frame[3]
        parts = [load.force.T, load.moment.T]
        if not load.in_world:
            parts = [np.einsum("jn,jin->in", part, axes) for part in parts]
        force = np.broadcast_to(parts[0], point.shape)
        return body, np.stack([force, parts[1] + cross(point, force)])

    def _weight_and_inertia(
        self, placed: Array, velocity: Array | None, acceleration: Array | None
    ) -> tuple[Array, Array]:
        """Return weights less momentum rates of the massive bodies, about the corner.

        The second one is the size of the terms that momentum rates are the sum of, `(N,)`.
        """
        frames = placed[self._moved_by]
        centre = np.einsum("bc,bcin->bin", self._centres, frames[:, :3]) + frames[:, 3]
        if velocity is None or acceleration is None:
            pull = np.broadcast_to(self._masses * self._gravity[:, None], centre.shape)
            return np.stack([pull, cross(centre, pull)], axis=1), np.zeros(centre.shape[-1])
        velocity, acceleration = velocity[self._moved_by], acceleration[self._moved_by]
        spin, change = velocity[:, 1], acceleration[:, 1]
        speed = velocity[:, 0] + cross(spin, centre)
        force = acceleration[:, 0] + cross(change, centre) + cross(spin, speed)
        force -= self._gravity[:, None]
        force *= -self._masses
        # Euler's equations in the axes of the body, where its inertia stays the same.
        own_spin, own_change = (
            np.einsum("bcin,bin->bcn", frames[:, :3], part) for part in (spin, change)
        )
        momentum, rate = (
            np.einsum("bcd,bdn->bcn", self._inertias, part) for part in (own_spin, own_change)
        )
        rate += cross(own_spin, momentum)
        moment = -np.einsum("bcin,bcn->bin", frames[:, :3], rate)
        turning = np.sum(spin * spin, axis=1) + np.sqrt(np.sum(change * change, axis=1))
        size = np.max(self._masses[:, 0] * self.length**2 * turning, axis=0)
        moment += cross(centre, force)
        return np.stack([force, moment], axis=1), size

    def _effort_imbalance(
        self,
        own: Array,
        world: Array,
        placed: Array,
        directions: Array,
        loads: Array,
        claim: Claim,
    ) -> Array:
        """Return `(N,)` what acts along the coordinates and should not."""
        twists = self._twists
        efforts = np.zeros(claim.v.shape[::-1])
        rows = self._last_rows
        parts = own[self._last_joints, self._last_parts]
        efforts[twists.rates[rows]] = np.einsum("kcn,kc->kn", parts, twists.axes[rows])
        if self._inner_rows.size:
            rows, wrench = self._inner_rows, world[self._inner_joints]
            moment = wrench[:, 1] - cross(placed[twists.owners[rows], 3], wrench[:, 0])
            part = np.where(twists.sliding[rows, None, None], wrench[:, 0], moment)
            efforts[twists.rates[rows]] = np.einsum("kin,kin->kn", part, directions[rows])
        given = loads + claim.exerted.T + self._constraints.gears.T @ claim.couplings.T
        rates = twists.rates[np.concatenate([self._last_rows, self._inner_rows])]
        imbalance = np.abs(efforts[rates] - given[rates]) * self.rate_scale[rates, None]
        return np.asarray(np.max(imbalance, axis=0, initial=0.0))

    def _size(self, wrenches: Array, points: Array | None) -> Array:
        """Return the greatest size [N·m] of wrenches: of moments, and of forces times the length.

        Args:
            wrenches: `(B, 2, 3, N)`, about the corner.
            points: `(B, 3, N)` about which the moments are to be taken; None where they are.
        """
        if not len(wrenches):
            return np.zeros(wrenches.shape[-1])
        force, moment = wrenches[:, 0], wrenches[:, 1]
        if points is not None:
            moment = moment - cross(points, force)
        square = self.length**2 * _squared(force)
        np.maximum(square, _squared(moment), out=square)
        found = np.max(square, axis=0)
        if 1e-200 < np.max(found) < 1e200:
            return np.asarray(np.sqrt(found))
        # Squares overflow, or vanish, long before the wrenches do.
        scale = float(np.max(np.abs(wrenches)))
        if not 0.0 < scale < np.inf:
            return np.asarray(np.max(np.abs(wrenches), axis=(0, 1, 2)))
        found = self.length**2 * _squared(force / scale)
        np.maximum(found, _squared(moment / scale), out=found)
        return np.asarray(scale * np.sqrt(np.max(found, axis=0)))


def _squared(vectors: Array) -> Array:
    with np.errstate(over="ignore", under="ignore"):
        return np.asarray(np.einsum("bin,bin->bn", vectors, vectors))
