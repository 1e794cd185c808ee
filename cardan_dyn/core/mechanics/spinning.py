"""Spinning: what turns rods about lines about which their joints pass no moment.

Gravity, inertia and loads alone do. With unit rates u of a spin and the forces f of the motion
without it, its acceleration is uᵀ(τ - f) / uᵀ M u, rotors along its rates included. No spin moves
another rod, and closure forces do no work on it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from ...kit.arrays import NOTHING
from ..tape import absolute, greater, select
from .bodies import Tree
from .elimination import Eliminated, combined, product
from .placements import Placed, moving
from .reactions import Wrenches, momentum_rates
from .vectors import ZERO, Scalar, times

_MASSLESS = 1e-14
"""Inertia against a spin, relative to all masses at the characteristic length, up to which it is
the rounding of other inertias: such a rod is balanced at any acceleration, and does not spin."""


class Spun(NamedTuple):
    """What turns rods.

    Attributes:
        accelerations: velocity coordinate to what they add to it.
        wrenches: what they add to what moves each body by itself.
        unheld: per rod, above 0 where a moment acts about a line against which nothing resists.
    """

    accelerations: dict[int, Scalar]
    wrenches: Wrenches
    unheld: list[Scalar]


def spun(
    tree: Tree,
    at: Placed,
    factors: Eliminated,
    open_tree: Wrenches,
    loads: Mapping[int, Scalar],
    inertia: Mapping[str, Scalar],
) -> Spun:
    """Return what turns the rods of a mechanism.

    Args:
        tree: the mechanism.
        at: where it is.
        factors: of its closure rows for the passive coordinates, those of spins being the last.
        open_tree: what joints carry while all loops are open and no rod spins.
        loads: velocity coordinate to the effort added there, less what rotors take.
        inertia: link to the factor on its mass and inertia.
    """
    count = 6 * len(tree.loops) + len(tree.couplings)
    units: list[dict[int, Scalar]] = []
    for index, spin in enumerate(tree.spins):
        right = [0.0] * (count + len(tree.spins))
        right[count + index] = 1.0
        rates = factors.solve(right)
        units.append({rate: rates[rate] for rate in spin.rates if rate in rates})
    every = {rate for unit in units for rate in unit}

    def moved_by(accelerations: Mapping[int, Scalar]) -> Wrenches:
        return momentum_rates(tree, moving(tree, at, {}, accelerations, ZERO), inertia)

    together = combined(units, [1.0] * len(units))
    resisting = moved_by(together).passed_on(tree, at).along(tree, every)
    for rate, taken in tree.of_rotors(together).items():
        resisting[rate] = resisting[rate] + taken
    acting = open_tree.along(tree, every)
    greatest: Scalar = 0.0
    for force, moment in zip(*open_tree, strict=True):
        for value in (*times(force, tree.norm_length), *moment):
            greatest = greater(greatest, absolute(value))
    masses = sum(mass.mass for body in tree.bodies for mass in body.masses)
    least = _MASSLESS * masses * tree.norm_length**2
    amounts, unheld = [], []
    for unit in units:
        about = sum((u * (loads.get(r, 0.0) - acting[r]) for r, u in unit.items()), 0.0)
        against = product(unit, resisting)
        resists = against - least
        amounts.append(select(resists, about / select(resists, against, 1.0), 0.0))
        # Forces that pass through the line have such a moment by rounding.
        unheld.append(select(resists, 0.0, absolute(about) - NOTHING * greatest))
    accelerations = combined(units, amounts)
    return Spun(accelerations, moved_by(accelerations), unheld)
