"""Places: where axes of coordinates and points of links are at the samples that are shown."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...core.elements.link_motions import LinkMotion, LinkMotions
from ...core.mechanism.joints import Part
from ...core.results.sweep import Sweep
from ...kit.arrays import Array, quaternion_product
from . import shapes as forms
from .still import Still
from .vectors import beside


class Places:
    """Where coordinates and links are, as far as their motion was solved.

    Args:
        sweep: over one dimension.
        samples: `(n,)` indices of the samples that are shown.
        radius: of the scene [m].
    """

    def __init__(self, sweep: Sweep | Still, samples: Array, radius: float) -> None:
        self._mechanism, self.samples, self._radius = sweep.mechanism, samples, radius
        self._rows = sweep.motion.rows[samples]
        self._rates = sweep.motion.v.reshape(len(sweep.motion.rows), -1)[samples]
        self._time = np.broadcast_to(sweep.time, sweep.motion.shape).reshape(-1)[samples]
        every = self._mechanism.coordinates
        self._parts = dict(zip(every.starts, every.parts, strict=True))
        motions = LinkMotions(self._mechanism, (), (part.id for part in every.parts))
        self._bodies = {
            body: moved._replace(position=moved.position + motions.corner)
            for body, moved in motions.bodies_at(self._rows, self._rates).items()
        }

    def point(self, link: str, place: Array) -> Array:
        """Return where a point `(3,)` of a link is, `(n, 3)` [m]."""
        moved = self.link(link)
        return np.broadcast_to(moved.rotation @ place + moved.position, (len(self._rows), 3))

    def link(self, name: str) -> LinkMotion:
        """Return the motion of a link's frame, in the world."""
        body, frame = self._mechanism.link_frames[name]
        return self._bodies[body].placed(frame.homogeneous)

    def axis(self, name: str) -> Axis | None:
        """Return the axis of a coordinate; None where its motion was not solved."""
        item = self._mechanism.coordinates.named[name]
        part = self._parts[item.column]
        moved = self._bodies[part.id]
        if not (np.all(np.isfinite(moved.position)) and np.all(np.isfinite(moved.rotation))):
            return None
        joint = self._mechanism.joints[self._mechanism.drivable[name].joint]
        return Axis(
            part=part,
            child=moved,
            x=self._rows[:, item.column],
            v=self._rates[:, item.rate],
            time=self._time,
            shift=beside(self._mechanism, joint, self._radius) * joint.axis,
        )


class Axis(NamedTuple):
    """Where a coordinate's axis is at the samples that are shown.

    Attributes:
        part: the elementary part that turns about it or slides along it.
        child: motion of the body that the part moves.
        x: coordinate `(n,)` [rad or m].
        v: its rate `(n,)` [rad/s or m/s].
        time: `(n,)` [s].
        shift: `(3,)` from the origin of the joint to the drawing, in the joint's axes [m].
    """

    part: Part
    child: LinkMotion
    x: Array
    v: Array
    time: Array
    shift: Array

    @property
    def slides(self) -> bool:
        """Whether the coordinate is a slide."""
        return self.part.kind == "prismatic"

    @property
    def direction(self) -> Array:
        """Unit axis in world axes `(n, 3)`."""
        return np.broadcast_to(self.child.rotation @ self.part.axis, (len(self.x), 3))

    @property
    def origin(self) -> Array:
        """Point of the axis at which the drawing stands, moved by the part `(n, 3)` [m]."""
        at = self.child.position + self.child.rotation @ self.shift
        return np.broadcast_to(at, (len(self.x), 3))

    def quaternion(self, turn: Array | float = 0.0) -> Array:
        """Return the turns `(n, 4)` from a drawing about z to the axis.

        Args:
            turn: `(n,)` by which the drawing is turned about the axis against the child [rad].
        """
        half = np.broadcast_to(0.5 * np.asarray(turn), self.x.shape)
        about = np.stack([0.0 * half, 0.0 * half, np.sin(half), np.cos(half)], axis=1)
        upright = forms.quaternions(self.child.rotation @ forms.upright(self.part.axis))
        return quaternion_product(np.broadcast_to(upright, about.shape), about)
