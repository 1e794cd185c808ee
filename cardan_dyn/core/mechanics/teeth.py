"""Teeth: what two gears exert on each other, as wrenches on both, from the moment between them.

A coupling that teeth keep exerts nothing by itself: its moment is that of the teeth about the axes
of the gears, whose forces load bearings besides (see `mechanism.teeth` for their directions).
"""

from __future__ import annotations

from collections.abc import Mapping

from ..mechanism.mechanism import Mechanism
from ..tape import absolute, cos, sin
from .bodies import Gear, Tree
from .placements import Placed
from .reactions import Push, Wrenches
from .vectors import Scalar, Vector, about, added, times, turned


def gears_of(tree: Tree, mechanism: Mechanism) -> tuple[Gear, ...]:
    """Return the gears of couplings that are solved, but for those that stand in the world."""
    places = {coupling.number: place for place, coupling in enumerate(tree.couplings)}

    def in_units(wrench: list[float]) -> tuple[Vector, Vector]:
        """Return force and moment per moment in units of the length."""
        return times(wrench[:3], tree.length), tuple(wrench[3:])

    return tuple(
        Gear(
            places[teeth.coupling],
            gear.body,
            tuple(map(tuple, gear.rotation.T.tolist())),
            tuple((gear.translation / tree.length).tolist()),
            tuple(gear.axis.tolist()),
            mechanism.coordinates.columns[gear.joint].start,
            gear.sense,
            in_units(gear.linear.tolist()),
            in_units(gear.radial.tolist()),
        )
        for teeth in mechanism.teeth
        if teeth.coupling in places
        for gear in teeth.gears
    )


def pushes(
    tree: Tree, at: Placed, x: Mapping[int, Scalar], moments: Mapping[int, Scalar]
) -> Wrenches:
    """Return what holds all gears against the forces of teeth.

    Args:
        tree: the mechanism.
        at: where it is.
        x: column to coordinate.
        moments: of couplings at their successors' joints.
    """
    result = Wrenches.none(tree)
    for gear in tree.gears:
        moment = moments.get(gear.coupling, 0.0)
        angle = x[gear.column] * -gear.sense
        turn = about(gear.axis, sin(angle), cos(angle))
        # From the joint's frame at zero to the gear's side of the joint, and on to the gear's axes.
        force, about_origin = (
            turned(gear.rotation, turned(turn, vector))
            for vector in (
                added(times(linear, moment), times(radial, absolute(moment)))
                for linear, radial in zip(gear.linear, gear.radial, strict=True)
            )
        )
        result.against(Push(gear.body, gear.lever, force, about_origin))
    return result
