"""Pin scan: what clearance in the bearings of a universal joint would do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from .joint_scan import JointScan, Reversal

if TYPE_CHECKING:
    import pandas

_TOGETHER = 0.05
"""Part of the play, as a fraction, by which bearings may differ where they close together."""
_NO_INTERVAL = (
    "pins are not followed in the planes of their bearings, and so no interval is known: simulate"
)


@dataclass(frozen=True, eq=False)
class PinReversal(Reversal):
    """What happens where the forces of open bearings swing round together.

    Forces, speeds and masses are those of the bearing that carries most: its force moves the
    reduced mass across the mean play. The direction is that of its force.

    Attributes:
        share: force of each open bearing as a fraction of the greatest.
        split: part of the play, as a fraction, that cannot close at once in all open bearings,
            since the mechanism ties their motions together.
    """

    share: tuple[float, ...] = ()
    split: float = 0.0

    @property
    def energy(self) -> float:
        """Kinetic energy of the impact in all open bearings [J]."""
        return sum(share**2 for share in self.share) * super().energy

    @property
    def doubts(self) -> tuple[str, ...]:
        """Why the estimate may be wrong; empty if its assumptions hold."""
        doubts = super().doubts
        if self.split > _TOGETHER:
            part = f"{100 * self.split:.0f} % of the clearance"
            doubts = (*doubts, f"the bearings do not close together ({part})")
        return (*doubts, _NO_INTERVAL)

    def row(self) -> dict[str, Any]:
        """Return its numbers by name, exponents, verdict, and the doubts as text."""
        return {**super().row(), "split": self.split}


@dataclass(frozen=True, eq=False)
class PinScan(JointScan):
    """What play in bearings of a universal joint would do: an estimate, no simulation.

    Attributes:
        name: of the joint, or of its cross.
        position: of the drive over a period `(N,)` [rad].
        force: that each open bearing carries across its pin `(N, B, 3)` in the world, exerted on
            the pin's child link [N].
        reversals: where their forces swing round, a `PinReversal` each, in order of position.
        turning: number of positions at which the forces are least but far from zero.
        periods: per second [1/s].
        bearings: names of the open bearings.
        freedoms: in how many ways they can move, the drive prescribed.
        radius: of each pin that has open bearings: from the joint's centre to their middle [m].
        clearance: of the bearings of each of these pins [m].
        stiffness: of one of these bearings [N/m].
        speed: of the drive [rad/s].
        made_of: see `Scan`.
    """

    bearings: tuple[str, ...]
    freedoms: int
    radius: Mapping[str, float]
    clearance: Mapping[str, float]
    stiffness: Mapping[str, float]
    speed: float
    made_of: Mapping[str, str] = field(default_factory=dict)

    @property
    def torsional_clearance(self) -> float:
        """Angle between both ends, by which one side of the joint turns against the other [rad].

        2 s / r of each pin with both bearings open.
        """
        return sum(
            self.clearance[pin] / self.radius[pin]
            for pin in self.radius
            if {f"{pin}+", f"{pin}-"} <= set(self.bearings)
        )

    def by_bearing(self) -> dict[str, JointScan]:
        """Return what is said of each open bearing: its force, and its share of the peaks."""
        return {
            name: JointScan(
                name,
                self.position,
                self.force[:, index],
                tuple(_shared(item, index) for item in self.reversals),
                self.turning,
                self.periods,
            )
            for index, name in enumerate(self.bearings)
        }

    def to_dataframe(self) -> pandas.DataFrame:
        """Return a row for each reversal, SI units, in order of position."""
        import pandas

        return pandas.DataFrame([{"joint": self.name, **item.row()} for item in self.reversals])

    def __str__(self) -> str:
        opened = ", ".join(self.bearings)
        return f"clearance in {opened} of {self.name} at {self.speed:g} rad/s: {self.summary}"

    __repr__ = __str__


def _shared(item: Reversal, index: int) -> Reversal:
    """Return a reversal with the forces of one bearing."""
    if not isinstance(item, PinReversal):
        return item
    share = item.share[index]
    forces = {name: share * getattr(item, name) for name in ("peak", "rigid", "added")}
    return replace(item, **forces)
