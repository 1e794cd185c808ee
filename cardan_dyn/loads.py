"""Loads: wrenches on links."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .coordinates import Array
from .frozen import read_only
from .twin import placement


@dataclass(frozen=True, eq=False, repr=False)
class LinkLoad:
    """A wrench that acts on a link.

    Attributes:
        body: number of the joint that moves the link (0-based).
        rotation, translation: placement of the link in that body.
        force, moment: `(N, 3)` or `(1, 3)`.
        in_world: whether they are given in world axes instead of the link's.
    """

    body: int
    rotation: Array
    translation: Array
    force: Array
    moment: Array
    in_world: bool

    def __post_init__(self) -> None:
        read_only(self.force)
        read_only(self.moment)

    def about_origin(self, actions: Array, place: int) -> Array:
        """Return the wrench `(N, 6)` in world axes about a twin's origin.

        Args:
            actions: of the twin.
            place: of the load's body in the twin.
        """
        rotation, position = placement(actions, place)
        force, moment = self.force.T, self.moment.T
        if not self.in_world:
            axes = np.einsum("ikn,kj->ijn", rotation, self.rotation)
            force, moment = (np.einsum("ijn,jn->in", axes, part) for part in (force, moment))
        point = position + np.einsum("ikn,k->in", rotation, self.translation)
        force = np.broadcast_to(force, point.shape)
        return np.concatenate([force, moment + np.cross(point, force, axis=0)]).T
