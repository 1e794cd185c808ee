"""Link loads: wrenches that act on links, as users give them and as they are solved."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from ...kit.arrays import Array
from ...kit.frozen import Record

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


WRENCH_COMPONENTS = ("force x", "force y", "force z", "moment x", "moment y", "moment z")
"""Names of the components of a wrench, in their order."""


@dataclass(frozen=True, eq=False)
class Wrench:
    """A wrench that acts on a link, for `Scene(loads={"link": Wrench(...)})`.

    Attributes:
        force: `(3,)` or `(..., 3)` [N].
        moment: `(3,)` or `(..., 3)` [N·m], about the point.
        frame: `link` or `world`: the axes of both.
        point: `(3,)` at which the force acts, from the link's origin and in the link's axes
            whatever the frame is: it moves with the link [m].
    """

    force: ArrayLike = (0.0, 0.0, 0.0)
    moment: ArrayLike = (0.0, 0.0, 0.0)
    frame: str = "link"
    point: ArrayLike = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False, repr=False)
class LinkLoad(Record):
    """A wrench that acts on a link, checked and placed in the body that carries the link.

    Attributes:
        body: index of the joint that moves the link (0-based).
        rotation, translation: `(3, 3)` and `(3,)` placement of the link in that body [m].
        force, moment: `(..., 3)` [N, N·m], about the point; while they are solved, `(N, 3)` or
            `(1, 3)`.
        in_world: whether they are given in world axes instead of the link's.
        point: `(3,)` at which the force acts, from the link's origin in its axes [m].
    """

    body: int
    rotation: Array
    translation: Array
    force: Array
    moment: Array
    in_world: bool
    point: Array = field(default_factory=lambda: np.zeros(3))

    @property
    def place(self) -> Array:
        """Point at which the force acts, in the frame of the body `(3,)` [m]."""
        return self.translation + self.rotation @ self.point

    @property
    def wrench(self) -> Wrench:
        """The wrench as a user would give it."""
        return Wrench(self.force, self.moment, "world" if self.in_world else "link", self.point)

    def of_samples(self, samples: slice) -> LinkLoad:
        """Return the load of some samples; a force or moment with one sample holds for all."""
        force, moment = (
            values[samples] if len(values) > 1 else values for values in (self.force, self.moment)
        )
        return replace(self, force=force, moment=moment)
