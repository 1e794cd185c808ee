"""Momentum: weights of the bodies, and the rates at which their momentum changes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ..arrays import Array, consecutive
from ..mechanism.frames import Frames, RigidBody
from .twists import cross


class Inertial(NamedTuple):
    """Weights less momentum rates of the bodies that have mass.

    Attributes:
        wrenches: `(B, 2, 3, N)` in world axes about `Frames.corner`.
        size: `(N,)` size [N·m] of the terms that momentum rates are the sum of, forces times the
            characteristic length; what rounding leaves of these terms is in proportion to it.
    """

    wrenches: Array
    size: Array


class MassiveBodies:
    """The bodies that have mass.

    Attributes:
        indices: of these bodies in `Frames.bodies`; as a slice where they are without gaps.
        motions: likewise, per body the index of the elementary motion whose frame carries it.
        greatest_mass: of a body [kg].
    """

    def __init__(self, frames: Frames, bodies: Mapping[int, RigidBody], length: float) -> None:
        """Collect the bodies that have mass.

        Args:
            frames: of the description.
            bodies: by their indices in `Frames.bodies`.
            length: characteristic length [m].
        """
        self._length = length
        massive = {index: body for index, body in bodies.items() if body.mass > 0.0}
        self.indices = consecutive(np.array(list(massive), dtype=int))
        motions = [frames.last[index] for index in massive]
        self.motions = consecutive(np.array(motions, dtype=int))
        self._masses = np.array([body.mass for body in massive.values()])[:, None, None]
        self._centres = np.array([body.centre for body in massive.values()]).reshape(-1, 3)
        self._inertias = np.array([body.inertia for body in massive.values()]).reshape(-1, 3, 3)
        self.greatest_mass = float(np.max(self._masses, initial=0.0))

    def __len__(self) -> int:
        return len(self._masses)

    def greatest_weight(self, gravity: Array) -> Array:
        """Return the greatest weight of a body [N·m], the force times the characteristic length.

        Args:
            gravity: `(N, 3)` [m/s²].

        Returns:
            `(N,)`.
        """
        if not gravity.any():
            return np.zeros(len(gravity))
        with np.errstate(over="ignore"):  # A result that overflows is refused as a whole.
            weight = self._length * np.sqrt(np.vecdot(gravity, gravity)) * self.greatest_mass
        return np.asarray(weight)

    def weights(self, motion_frames: Array, gravity: Array) -> Inertial:
        """Return the weights of bodies at rest.

        Args:
            motion_frames: `(M, 4, 3, N)`, see `Frames.placed`.
            gravity: `(N, 3)` or `(1, 3)` [m/s²].
        """
        centres = self._centres_in_world(motion_frames[self.motions])
        wrenches = np.empty((len(centres), 2, *centres.shape[1:]))
        wrenches[:, 0] = self._masses * gravity.T
        wrenches[:, 1] = cross(centres, wrenches[:, 0])
        return Inertial(wrenches, np.zeros(centres.shape[-1]))

    def weights_less_momentum_rates(
        self, motion_frames: Array, velocities: Array, accelerations: Array, gravity: Array
    ) -> Inertial:
        """Return weights less momentum rates, with which joint wrenches and loads balance.

        Args:
            motion_frames: `(M, 4, 3, N)`, see `Frames.placed`.
            velocities: of these frames, `(M, 2, 3, N)`, see `Twists.absolute`.
            accelerations: likewise, from `Twists.relative_accelerations`.
            gravity: `(N, 3)` or `(1, 3)` [m/s²].
        """
        frames = motion_frames[self.motions]
        centres = self._centres_in_world(frames)
        velocities, accelerations = velocities[self.motions], accelerations[self.motions]
        spin, spin_rate = velocities[:, 1], accelerations[:, 1]
        speed = cross(spin, centres)
        speed += velocities[:, 0]
        wrenches = np.empty((len(centres), 2, *centres.shape[1:]))
        force, moment = wrenches[:, 0], wrenches[:, 1]
        np.add(accelerations[:, 0], cross(spin, speed), out=force)
        force += cross(spin_rate, centres)
        force -= gravity.T
        force *= -self._masses
        np.subtract(
            cross(centres, force), self._spin_momentum_rates(frames, spin, spin_rate), out=moment
        )
        turning = np.sqrt(np.einsum("bin,bin->bn", spin_rate, spin_rate))
        turning += np.einsum("bin,bin->bn", spin, spin)
        turning *= self._masses[:, 0] * self._length**2
        return Inertial(wrenches, np.maximum.reduce(turning, axis=0))

    def _centres_in_world(self, frames: Array) -> Array:
        """Return the centres of mass `(B, 3, N)` about `Frames.corner`."""
        return np.einsum("bc,bcin->bin", self._centres, frames[:, :3]) + frames[:, 3]

    def _spin_momentum_rates(self, frames: Array, spin: Array, spin_rate: Array) -> Array:
        """Return `(B, 3, N)` rates of the angular momenta about the centres, in world axes.

        By Euler's equations in the axes of each body, in which its inertia is constant.
        """
        body_spin, body_spin_rate = (
            np.einsum("bcin,bin->bcn", frames[:, :3], vectors) for vectors in (spin, spin_rate)
        )
        momentum, rate = (
            np.einsum("bcd,bdn->bcn", self._inertias, vectors)
            for vectors in (body_spin, body_spin_rate)
        )
        rate += cross(body_spin, momentum)
        return np.asarray(np.einsum("bcin,bcn->bin", frames[:, :3], rate))
