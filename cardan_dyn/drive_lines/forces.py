"""Forces: what acts in joints, bearings and splines of a line, over all samples.

`(…)` stands for the samples: positions, or designs × positions.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array


class LineForces(NamedTuple):
    """Moments and forces along a line.

    Attributes:
        moment_in: `(…, n, 3)` moment of the shaft before each joint on the cross, at its centre
            [N·m], in axes that turn with this shaft: x along it, y along the driving pin of the
            straight joint.
        moment_out: `(…, n, 3)` moment of the cross on the shaft behind it [N·m], in axes that turn
            with that shaft: x along it, z along the driven pin.
        bearing_force: `(…, m, 3)` force of each bearing on its shaft [N]: along the shaft, to the
            left, and upwards across it, as the shaft lies by slopes, joint angles and planes;
            misalignments do not turn these axes. The bearing feels the opposite.
        spline_force: `(…, s, 3)` force of the front piece on the rear piece at each spline [N], in
            axes that turn with the shaft; x is its friction. In
            all designs a spline is at the distance from the front joint that the data say.
        spline_moment: `(…, s, 3)` moment likewise [N·m]; x is the torque through it.
        centring_force: `(…, c, 3)` force of the centring of each coupling piece on the shaft that
            its ball is fixed to, of a disc on the shaft behind the piece [N], in axes that turn
            with the shaft that the ball slides along, or with the piece.
        holding_moment: `(…, n)` moment that keeps each joint angle, positive if it acts on what
            lies behind the joint in the sense in which its angle grows [N·m].
        drive_torque: `(…)` torque that drives the input shaft [N·m].
        load_torque: `(…)` torque that acts on the output shaft, negative where it resists [N·m].
    """

    moment_in: Array
    moment_out: Array
    bearing_force: Array
    spline_force: Array
    spline_moment: Array
    centring_force: Array
    holding_moment: Array
    drive_torque: Array
    load_torque: Array

    @property
    def torsion_in(self) -> Array:
        """Torque in the shaft before each joint, positive if it drives the joint `(…, n)` [N·m]."""
        return self.moment_in[..., 0]

    @property
    def torsion_out(self) -> Array:
        """Torque in the shaft behind each joint `(…, n)` [N·m]."""
        return self.moment_out[..., 0]

    @property
    def bending_in(self) -> Array:
        """Bending moment of the shaft before each joint `(…, n)` [N·m]."""
        return np.hypot(self.moment_in[..., 1], self.moment_in[..., 2])

    @property
    def bending_out(self) -> Array:
        """Bending moment of the shaft behind each joint `(…, n)` [N·m]."""
        return np.hypot(self.moment_out[..., 1], self.moment_out[..., 2])

    @property
    def bearing_radial(self) -> Array:
        """Size of each bearing's force across its shaft `(…, m)` [N]."""
        return np.hypot(self.bearing_force[..., 1], self.bearing_force[..., 2])

    @property
    def bearing_axial(self) -> Array:
        """Force of each bearing along its shaft `(…, m)` [N]."""
        return self.bearing_force[..., 0]

    @property
    def spline_friction(self) -> Array:
        """Friction force of each spline, with its sign on the rear piece `(…, s)` [N]."""
        return self.spline_force[..., 0]

    @property
    def spline_torque(self) -> Array:
        """Torque through each spline `(…, s)` [N·m]."""
        return self.spline_moment[..., 0]

    @property
    def spline_bending(self) -> Array:
        """Bending moment at the middle of each spline `(…, s)` [N·m]."""
        return np.hypot(self.spline_moment[..., 1], self.spline_moment[..., 2])

    @property
    def centring(self) -> Array:
        """Size of the force in the centring of each coupling piece `(…, c)` [N]."""
        return np.asarray(np.linalg.norm(self.centring_force, axis=-1))

    def times(self, factor: Array) -> LineForces:
        """Return these forces times a factor `(…)`; what acts on a line without inertia is so."""
        return LineForces(
            *(
                values * factor.reshape(factor.shape + (1,) * (values.ndim - factor.ndim))
                for values in self
            )
        )

    def plus(self, other: LineForces) -> LineForces:
        """Return the sum of what acts for two reasons; forces follow linearly from what acts."""
        return LineForces(*(one + two for one, two in zip(self, other, strict=True)))
