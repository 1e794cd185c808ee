"""Link loads: wrenches that act on links, as users give them and as they are solved."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ..arrays import Array
from ..frozen import Record

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


WRENCH_COMPONENTS = ("force x", "force y", "force z", "moment x", "moment y", "moment z")
"""Names of the components of a wrench, in their order."""


@dataclass(frozen=True, eq=False)
class Wrench:
    """A wrench that acts on a link, for `Scene(loads={"link": Wrench(...)})`.

    Attributes:
        force: `(3,)` or `(..., 3)` [N].
        moment: `(3,)` or `(..., 3)` [N·m], about the link's origin.
        frame: `link` or `world`: the axes of both.
    """

    force: ArrayLike = (0.0, 0.0, 0.0)
    moment: ArrayLike = (0.0, 0.0, 0.0)
    frame: str = "link"


@dataclass(frozen=True, eq=False, repr=False)
class LinkLoad(Record):
    """A wrench that acts on a link, checked and placed in the body that carries the link.

    Attributes:
        body: index of the joint that moves the link (0-based).
        rotation, translation: `(3, 3)` and `(3,)` placement of the link in that body [m].
        force, moment: `(..., 3)` [N, N·m], about the link's origin; while they are solved, `(N, 3)`
            or `(1, 3)`.
        in_world: whether they are given in world axes instead of the link's.
    """

    body: int
    rotation: Array
    translation: Array
    force: Array
    moment: Array
    in_world: bool

    @property
    def wrench(self) -> Wrench:
        """The wrench as a user would give it."""
        return Wrench(self.force, self.moment, "world" if self.in_world else "link")

    def of_samples(self, samples: slice) -> LinkLoad:
        """Return the load of some samples; a force or moment with one sample holds for all."""
        force, moment = (
            values[samples] if len(values) > 1 else values for values in (self.force, self.moment)
        )
        return replace(self, force=force, moment=moment)
