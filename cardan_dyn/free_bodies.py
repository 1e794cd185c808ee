"""Free bodies: Newton's and Euler's laws written for every body by itself.

Its velocity and acceleration are summed up from joint twists in world axes, and the joint wrenches
are taken as they are returned. RNEA, which computed them, takes no part.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .coordinates import Array
from .kinematics import ClosedMechanism
from .plan import Needs, columns_of
from .reactions import Reactions, ReactionSolver, consecutive
from .residuals import Residuals
from .solver import Closed, Solver
from .twin import UnitTwists, cross, positions


@dataclass(frozen=True, eq=False, repr=False)
class Rates:
    """Joint rates of a block of samples.

    Attributes:
        v, a: joint velocities and accelerations `(N, nv)`.
        virtual: joint velocities of the drives at unit speed, for which power is balanced.
        moving: whether `v` or `a` is not zero anywhere.
    """

    v: Array
    a: Array
    virtual: Array
    moving: bool


class FreeBodies:
    """Newton-Euler balance of the bodies of one scene.

    Attributes:
        gravity: `(3,)` [m/s²].
        rate_scale: `(nv,)` the length for slides, 1 for angles.
    """

    def __init__(self, reactions: ReactionSolver, gravity: Array, needed: Needs) -> None:
        self.reactions = reactions
        self.gravity = gravity
        self._open = sorted(set(range(reactions.bodies)) - needed.complete)
        self._whole = needed.everything
        self.passives = columns_of(
            [solver.group for solver in reactions.kinematics.solvers if reactions.solves(solver)]
        )
        self.length = reactions.mechanism.length
        self._groups = [
            _GroupBalance(solver, gravity, self.length) for solver in reactions.kinematics.solvers
        ]
        slides = np.any(reactions.subspace[:, :3] != 0.0, axis=1)
        self.rate_scale = np.where(slides, self.length, 1.0)

    def check(
        self,
        here: ClosedMechanism,
        reactions: Reactions,
        rates: Rates,
        efforts: Array,
        loads: Array,
        link_bodies: list[int],
    ) -> Residuals:
        """Return the residuals of a block of samples.

        Args:
            here: closed positions.
            reactions: what is checked.
            rates: of the motion.
            efforts: `(N, nv)` components of the wrenches along the coordinates, without what
                couplings exert there.
            loads: `(N, nv)` efforts that act from outside: loads, drives and what holds joints.
            link_bodies: bodies on which `reactions.link_wrenches` act.
        """
        solver = self.reactions
        wrenches = np.ascontiguousarray(reactions.wrenches[:, : solver.bodies].transpose(2, 1, 0))
        left = np.zeros(wrenches.shape)
        inertia = np.zeros(len(here.x))
        power = [np.einsum("nk,nk->n", loads, rates.virtual)]
        for number, (group, closed) in enumerate(zip(self._groups, here.groups, strict=True)):
            if not solver.solves(group.solver):
                continue
            external = [
                (body, wrench)
                for body, wrench in zip(link_bodies, reactions.link_wrenches, strict=True)
                if solver.home.get(body) == number
            ]
            group.add(left, inertia, power, closed, wrenches, reactions.closure, rates, external)
        left[:, self._open] = 0.0
        unmet = np.abs(efforts[:, self.passives] - loads[:, self.passives])
        unmet *= self.rate_scale[self.passives]
        return Residuals(
            unmet=np.maximum(
                np.max(self._size(left), axis=0, initial=0.0), np.max(unmet, axis=1, initial=0.0)
            ),
            unspent=np.abs(sum(power)),
            wrench=np.max(self._size(wrenches), axis=0, initial=0.0),
            inertia=inertia,
            flow=np.asarray(sum(np.abs(part) for part in power)),
            fastest=np.max(np.abs(rates.virtual) / self.rate_scale, axis=1, initial=0.0),
            # Power also flows through what was left out.
            power_balanced=self._whole,
        )

    def _size(self, wrenches: Array) -> Array:
        """Return sizes [N·m] of wrenches `(6, b, N)`: moments, and forces times the length."""
        force, moment = _squares(wrenches)
        square = np.maximum(moment, self.length**2 * force)
        if 1e-200 < np.max(square, initial=0.0) < 1e200:
            return np.asarray(np.sqrt(square))
        # Squares overflow, or vanish, long before the wrenches do.
        scale = float(np.max(np.abs(wrenches), initial=0.0))
        force, moment = _squares(wrenches / (scale or 1.0))
        return np.asarray(scale * np.sqrt(np.maximum(moment, self.length**2 * force)))


class _GroupBalance:
    """What one group adds to the balance of the bodies. Arrays are `(component, body, N)`."""

    def __init__(self, solver: Solver, gravity: Array, length: float) -> None:
        self.solver = solver
        twin = solver.twin
        own = [twin.local[body] for body in sorted(solver.group.massive)]
        self.own = np.array(own, dtype=int)
        self.gravity = gravity
        self.length = length
        inertias = list(twin.model.inertias)[1:]
        self.heavy = np.array([place for place in own if twin.mass[place] > 0.0], dtype=int)
        self.mass = twin.mass[self.heavy]
        self.lever = np.array([inertias[place].lever for place in self.heavy]).reshape(-1, 3)
        self.inertia = np.array([inertias[place].inertia for place in self.heavy]).reshape(-1, 3, 3)
        self.columns = np.nonzero(twin.owner >= 0)[0]
        self.unit_twists = UnitTwists(twin, self.columns)
        self.owners = twin.owner[self.columns]
        self.single = len(set(self.owners.tolist())) == len(self.owners)

    def add(
        self,
        left: Array,
        inertia: Array,
        power: list[Array],
        closed: Closed,
        wrenches: Array,
        closure: list[Array],
        rates: Rates,
        external: list[tuple[int, Array]],
    ) -> None:
        """Add this group's wrenches to what is left on the bodies.

        Args:
            left: `(6, b, N)` in world axes about each joint's origin, added to in place.
            inertia: `(N,)` size of the inertial wrenches, raised in place.
            power: terms `(N,)`, appended to.
            closed: this group's closed positions.
            wrenches: `(6, b, N)` of all joints in their frames.
            closure: see `Reactions.closure`.
            rates: of the motion.
            external: bodies and the wrenches on them about this group's origin.
        """
        twin = self.solver.twin
        count, bodies = len(closed.q), len(twin)
        frames = np.ascontiguousarray(closed.actions[:, :, :3].transpose(2, 1, 0))
        frames = frames.reshape(3, bodies, 6, count)
        axes, moments = frames[:, :, :3], frames[:, :, 3:]
        position = positions(axes, moments)

        # On every body, about the twin's origin: its own joint's wrench, its children's, loops.
        total = np.zeros((6, bodies, count))
        own = wrenches[:, consecutive(twin.bodies[self.own])]
        total[:, self.own] = self._about_origin(axes, moments, own)
        world = total[:, self.own]
        for place, joint in enumerate(self.own):
            parent = twin.parents[joint]
            if parent >= 0:
                total[:, parent] -= world[:, place]
        for number, sides in zip(self.solver.group.loops, self.solver.closure.sides, strict=True):
            for side, sign in zip(sides, (-1.0, 1.0), strict=True):
                if side.body >= 0:
                    total[:, side.body] += sign * closure[number].T
        inertial = bool(self.heavy.size and (rates.moving or np.any(self.gravity)))
        if inertial or external:
            units = np.ascontiguousarray(self.unit_twists.of(closed.actions).transpose(2, 1, 0))
            displacement = self._accumulated(self._joint_twists(units, rates.virtual))
            for body, wrench in external:
                place = twin.local[body]
                total[:, place] += wrench.T
                power.append(np.einsum("nx,xn->n", wrench, displacement[:, place]))
            if inertial:
                wrench = self._inertial(axes, position, units, rates, inertia)
                total[:, self.heavy] += wrench
                power.append(np.einsum("xbn,xbn->n", wrench, displacement[:, self.heavy]))
        # Origins differ between groups, joints do not.
        total[3:] -= cross(position, total[:3])
        left[:, twin.bodies] += total

    def _about_origin(self, axes: Array, moments: Array, wrenches: Array) -> Array:
        """Return wrenches `(6, b, N)` in joint frames as seen in world axes about the origin."""
        if len(self.own) != axes.shape[1]:
            axes, moments = axes[:, self.own], moments[:, self.own]
        force, moment = wrenches[:3], wrenches[3:]
        return np.concatenate(
            [
                np.einsum("ibn,xbin->xbn", force, axes),
                np.einsum("ibn,xbin->xbn", moment, axes)
                + np.einsum("ibn,xbin->xbn", force, moments),
            ]
        )

    def _inertial(
        self, axes: Array, position: Array, units: Array, rates: Rates, inertia: Array
    ) -> Array:
        """Return weight minus momentum rates of the massive bodies."""
        if len(self.heavy) != axes.shape[1]:
            axes, position = axes[:, self.heavy], position[:, self.heavy]
        centre = position + np.einsum("bi,xbin->xbn", self.lever, axes)
        force = self.gravity[:, None, None] * self.mass[:, None] * np.ones(centre.shape[2])
        moment = np.zeros_like(force)
        if rates.moving:
            joint_twists = self._joint_twists(units, rates.v)
            velocity = self._accumulated(joint_twists)
            acceleration = self._accelerations(units, joint_twists, velocity, rates.a)
            velocity, acceleration = velocity[:, self.heavy], acceleration[:, self.heavy]
            speed = velocity[:3] + cross(velocity[3:], centre)
            force = force - self.mass[:, None] * (
                acceleration[:3] + cross(acceleration[3:], centre) + cross(velocity[3:], speed)
            )
            spin, change = (
                np.einsum("xbin,xbn->ibn", axes, part[3:]) for part in (velocity, acceleration)
            )
            momentum, rate = (
                np.einsum("bij,jbn->ibn", self.inertia, part) for part in (spin, change)
            )
            moment = -np.einsum("xbin,ibn->xbn", axes, rate + cross(spin, momentum))
            turning = np.sum(spin * spin, axis=0) + np.sqrt(np.sum(change * change, axis=0))
            size = np.max(self.mass[:, None] * self.length**2 * turning, axis=0)
            np.maximum(inertia, size, out=inertia)
        return np.concatenate([force, moment + cross(centre, force)])

    def _joint_twists(self, units: Array, rates: Array) -> Array:
        """Return the twist of every joint for unit twists and joint rates `(N, nv)`."""
        twists = units * rates[:, self.columns].T
        result = np.zeros((6, len(self.solver.twin), len(rates)))
        if self.single:
            result[:, self.owners] = twists
        else:
            for place, owner in enumerate(self.owners):
                result[:, owner] += twists[:, place]
        return result

    def _accumulated(self, joint_twists: Array) -> Array:
        """Return the bodies' twists: those of all joints between them and the root."""
        result = joint_twists.copy()
        for body, parent in enumerate(self.solver.twin.parents):
            if parent >= 0:
                result[:, body] += result[:, parent]
        return result

    def _accelerations(self, units: Array, joint_twists: Array, velocity: Array, a: Array) -> Array:
        """Return the bodies' spatial accelerations."""
        result = self._joint_twists(units, a)
        carried = velocity - joint_twists
        result[:3] += cross(carried[3:], joint_twists[:3]) + cross(carried[:3], joint_twists[3:])
        result[3:] += cross(carried[3:], joint_twists[3:])
        return self._accumulated(result)


def _squares(wrenches: Array) -> tuple[Array, Array]:
    with np.errstate(over="ignore", under="ignore"):
        return np.sum(wrenches[:3] ** 2, axis=0), np.sum(wrenches[3:] ** 2, axis=0)
