"""Residuals: proofs of a result that use none of the equations it was computed with.

Newton's and Euler's laws are written for every body by itself, with its velocity and acceleration
summed up from joint twists in world axes and with the joint wrenches as they are returned. RNEA,
which computed them, takes no part.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .reactions import Reactions, ReactionSolver
from .solver import Closed
from .twin import Array, Twin, cross


@dataclass(frozen=True)
class Residuals:
    """Relative residuals per sample `(N,)`.

    Attributes:
        balance: wrench that a body is left with, over the greatest wrench of the sample.
        power: power that is left over, over the power that flows and the greatest wrench times
            the greatest joint speed.
    """

    balance: Array
    power: Array


class FreeBodies:
    """Newton-Euler balance of the bodies of one scene.

    Attributes:
        gravity: `(3,)` [m/s²].
    """

    def __init__(self, reactions: ReactionSolver, gravity: Array) -> None:
        self.reactions = reactions
        self.gravity = gravity
        self.twin: Twin = reactions.solver.twin
        inertias = list(self.twin.model.inertias)[1:]
        self.mass = np.array([body.mass for body in inertias])
        self.lever = np.array([body.lever for body in inertias])
        self.inertia = np.array([body.inertia for body in inertias])
        mechanism = reactions.solver.closure.mechanism
        self.length = mechanism.length
        slides = np.any(self.twin.subspace[:, :3] != 0.0, axis=1)
        self._rate_scale = np.where(slides, self.length, 1.0)
        self.welds = [(loop.predecessor - 1, loop.successor - 1) for loop in mechanism.loops]

    def check(
        self,
        here: Closed,
        reactions: Reactions,
        motion: tuple[Array, Array, Array],
        loads: Array,
        link_bodies: list[int],
    ) -> Residuals:
        """Return the residuals of a block of samples.

        Args:
            here: closed positions.
            reactions: what is checked.
            motion: joint velocities and accelerations `(N, nv)`, and the joint velocities of the
                motion for which power is balanced (that of the drive at unit speed).
            loads: `(N, nv)` efforts added at the joints, drive and holding efforts included.
            link_bodies: bodies on which `reactions.link_wrenches` act.
        """
        count = len(here.x)
        frames = np.ascontiguousarray(here.actions[:, :, :3].transpose(2, 1, 0))
        frames = frames.reshape(3, -1, 6, count)
        axes, moments = frames[:, :, :3], frames[:, :, 3:]
        position = 0.5 * cross(axes.swapaxes(1, 2), moments.swapaxes(1, 2)).sum(axis=1)

        v, a, virtual = motion
        twists = self._joint_twists(here.actions, v), self._joint_twists(here.actions, virtual)
        velocity, displacement = (self._accumulated(part) for part in twists)
        acceleration = self._accelerations(here.actions, twists[0], velocity, a)
        centre = position + np.einsum("bi,xbin->xbn", self.lever, axes)
        rate = self._momentum_rate(axes, centre, velocity, acceleration)
        weight = self._weight(centre)

        # Left over on every body, about the twin's origin: wrenches on it minus momentum rate.
        wrenches = reactions.wrenches.reshape(count, -1, 6).transpose(1, 2, 0)[: len(self.mass)]
        force = np.einsum("bin,xbin->xbn", wrenches[:, :3], axes)
        moment = np.einsum("bin,xbin->xbn", wrenches[:, 3:], axes) + np.einsum(
            "bin,xbin->xbn", wrenches[:, :3], moments
        )
        left = np.concatenate([force, moment]) + weight - rate
        for body, parent in enumerate(self.reactions.parents):
            if parent >= 0:
                left[:3, parent] -= force[:, body]
                left[3:, parent] -= moment[:, body]
        for number, (predecessor, successor) in enumerate(self.welds):
            for body, sign in ((predecessor, -1.0), (successor, 1.0)):
                if body >= 0:
                    left[:, body] += sign * reactions.closure[:, number].T
        for body, wrench in zip(link_bodies, reactions.link_wrenches, strict=True):
            left[:, body] += wrench.T
        left[3:] -= cross(position, left[:3])

        size = self._size(np.concatenate([wrenches[:, :3], wrenches[:, 3:]], axis=1).swapaxes(0, 1))
        spin = np.sum(velocity[3:] ** 2, axis=0) + np.linalg.norm(acceleration[3:], axis=0)
        scale = np.max(size + self.mass[:, None] * self.length**2 * spin, axis=0)
        efforts = self.reactions.efforts(reactions.wrenches)
        passives = self.reactions.solver.passives
        unmet = np.abs(efforts[:, passives] - loads[:, passives])
        worst = np.maximum(np.max(self._size(left), axis=0), np.max(unmet, axis=1, initial=0.0))

        power = [
            np.einsum("nk,nk->n", loads, virtual),
            np.einsum("xbn,xbn->n", weight, displacement),
            -np.einsum("xbn,xbn->n", rate, displacement),
        ]
        power += [
            np.einsum("nx,xn->n", wrench, displacement[:, body])
            for body, wrench in zip(link_bodies, reactions.link_wrenches, strict=True)
        ]
        # A balanced mechanism passes no power on; then its wrenches say how exact zero can be.
        fastest = np.max(np.abs(virtual) / self._rate_scale, axis=1, initial=0.0)
        through = sum(np.abs(part) for part in power) + np.max(size, axis=0) * fastest
        return Residuals(_relative(worst, scale), _relative(np.abs(sum(power)), through))

    def _joint_twists(self, actions: Array, rates: Array) -> Array:
        """Return the twist of every joint `(6, b, N)` for joint rates `(N, nv)`."""
        result = np.zeros((6, len(self.mass), len(rates)))
        units = self.twin.twists(actions, np.arange(rates.shape[1]))
        for coordinate, owner in enumerate(self.twin.owner):
            result[:, owner] += (units[:, coordinate] * rates[:, coordinate, None]).T
        return result

    def _accumulated(self, joint_twists: Array) -> Array:
        """Return the bodies' twists `(6, b, N)`: those of all joints between them and the root."""
        result = joint_twists.copy()
        for body, parent in enumerate(self.reactions.parents):
            if parent >= 0:
                result[:, body] += result[:, parent]
        return result

    def _accelerations(
        self, actions: Array, joint_twists: Array, velocity: Array, a: Array
    ) -> Array:
        """Return the bodies' spatial accelerations `(6, b, N)`."""
        result = self._joint_twists(actions, a)
        carried = velocity - joint_twists
        result[:3] += cross(carried[3:], joint_twists[:3]) + cross(carried[:3], joint_twists[3:])
        result[3:] += cross(carried[3:], joint_twists[3:])
        return self._accumulated(result)

    def _momentum_rate(
        self, axes: Array, centre: Array, velocity: Array, acceleration: Array
    ) -> Array:
        """Return the rates of momentum and moment of momentum `(6, b, N)` about the origin."""
        speed = velocity[:3] + cross(velocity[3:], centre)
        force = (
            acceleration[:3] + cross(acceleration[3:], centre) + cross(velocity[3:], speed)
        ) * self.mass[:, None]
        spin, change = (
            np.einsum("xbin,xbn->ibn", axes, part[3:]) for part in (velocity, acceleration)
        )
        momentum, moment = (
            np.einsum("bij,jbn->ibn", self.inertia, part) for part in (spin, change)
        )
        moment += cross(spin, momentum)
        return np.concatenate(
            [force, np.einsum("xbin,ibn->xbn", axes, moment) + cross(centre, force)]
        )

    def _weight(self, centre: Array) -> Array:
        force = np.multiply.outer(self.gravity, self.mass)[:, :, None] * np.ones(centre.shape[2])
        return np.concatenate([force, cross(centre, force)])

    def _size(self, wrenches: Array) -> Array:
        """Return sizes `(b, N)` [N·m] of wrenches `(6, b, N)`: moments, and forces times length."""
        return np.maximum(
            np.linalg.norm(wrenches[3:], axis=0),
            self.length * np.linalg.norm(wrenches[:3], axis=0),
        )


def _relative(error: Array, scale: Array) -> Array:
    return np.asarray(np.divide(error, scale, out=np.zeros_like(error), where=scale > 0.0))
