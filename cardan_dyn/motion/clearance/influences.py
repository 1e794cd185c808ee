"""Influence: how the peak of an impact changes with one of its parameters (Bild 8)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ...core.results.result import Result
from ...core.results.table import Table
from ...kit.arrays import Array
from ...kit.checks import described, positives
from ...kit.errors import ArgumentError, choices
from ...kit.frozen import Record
from .impact_model import Estimates, ImpactModel
from .pin_geometry import StiffnessLaw
from .row_tables import variable
from .scan_results import FLOWN, LEAST_TAU, TURNED, ForceReversal

PARAMETERS = ("speed", "slope", "clearance", "mass", "stiffness")
"""What a peak depends on."""
_FACTORS = np.geomspace(0.2, 5.0, 97)
"""Of a parameter, unless others are given; the middle one is 1."""


@dataclass(frozen=True, eq=False)
class Influence(Result, Record):
    """The peak of an impact over one of its parameters, the others staying as they are.

    Attributes:
        parameter: its name, one of `PARAMETERS`.
        factor: on the parameter `(N,)`.
        value: of the parameter `(N,)`, SI units; of the speed, which no model knows, the factor.
        tau: characteristic number `(N,)`.
        impact_speed: v₁ `(N,)` [m/s].
        peak: greatest force `(N,)` [N]; NaN where there is none.
        rigid, added: parts of the undamped peak `(N,)` [N].
        model: what is varied.
        exponent: d ln peak / d ln parameter at the factor 1.
        flown: angle that the drive turns during the flight, as a fraction of that to the next
            greatest force of the rigid mechanism `(N,)`; NaN of a two-mass model by itself.
        turn_through: ρ, least force as a fraction of what the ramp gains over the flight `(N,)`;
            likewise.
    """

    parameter: str
    factor: Array
    value: Array
    tau: Array
    impact_speed: Array
    peak: Array
    rigid: Array
    added: Array
    model: ImpactModel
    exponent: float
    flown: Array
    turn_through: Array

    @property
    def holds(self) -> Array:
        """Whether the estimate holds `(N,)`: `ForceReversal.doubts` by what varies here.

        There is a peak, τ is not so small that the estimate has not been checked there, the ramp of
        the force does not bend over the flight, and the force vanishes before it, as far as that is
        known.
        """
        known = np.isfinite(self.peak) & (self.tau >= LEAST_TAU)
        return np.asarray(known & ~(self.flown > FLOWN) & ~(self.turn_through > TURNED))

    def table(self) -> Table:
        """Return everything over the factor on the parameter."""
        unit = {"slope": "N/s", "clearance": "m", "mass": "kg", "stiffness": "N/m"}
        told = {
            "factor": ("1", f"on the {self.parameter}"),
            "value": (unit.get(self.parameter, "1"), f"of the {self.parameter}"),
            "peak": ("N", "greatest force after the impact"),
            "rigid": ("N", "part of an undamped peak of the ramp"),
        }
        numbers = "tau", "impact_speed", "peak", "rigid", "added", "flown", "turn_through"
        return Table(
            [
                variable(
                    name,
                    getattr(self, name),
                    "factor",
                    told=told.get(name),
                    given=name not in numbers,
                )
                for name in ("factor", "value", *numbers)
            ],
            {"factor": len(self.factor)},
            attributes={"parameter": self.parameter, "exponent": float(self.exponent)},
        )


def influence(
    of: ForceReversal | ImpactModel, parameter: str, factors: ArrayLike | None = None
) -> Influence:
    """Return the peak of an impact over one of its parameters.

    Args:
        of: a reversal of a scan, or the numbers of any two-mass model.
        parameter: "speed", "slope", "clearance", "mass" or "stiffness". A stiffness from a geometry
            is varied from what it is at the peak; otherwise it follows force and clearance.
        factors: `(N,)` on the parameter; from 0.2 to 5 if None.

    Raises:
        ArgumentError: no such parameter, a factor that is not positive, a speed where more than
            inertia acts, or a peak beyond what a geometry has a stiffness for.

    Source:
        Dresig and Thümmel, Bild 8.
    """
    model = of.model if isinstance(of, ForceReversal) else of
    if not isinstance(model, ImpactModel):
        raise ArgumentError(f"of is {described(of)}, expected a reversal or an ImpactModel")
    if not isinstance(parameter, str) or parameter not in PARAMETERS:
        raise ArgumentError(
            f"parameter {described(parameter)} is unknown; parameters: "
            f"{choices(PARAMETERS, parameter)}"
        )
    if parameter == "speed" and isinstance(of, ForceReversal) and of.slope_growth != 3.0:
        raise ArgumentError(
            "more than inertia acts, so that reversals move with the speed: scan at each speed"
        )
    factor = _FACTORS if factors is None else positives("factors", factors)
    law = model.stiffness
    if isinstance(law, StiffnessLaw) and parameter == "stiffness":
        model = replace(model, stiffness=float(model.estimate.stiffness))
    varied = _varied(model, parameter, factor)
    value = factor if parameter == "speed" else factor * float(getattr(model, parameter))
    flown, through = _judged(of, parameter, factor, varied.pop("contact_time"))
    return Influence(
        parameter=parameter,
        factor=np.array(factor),
        value=np.array(value),
        model=model,
        exponent=getattr(model.exponents, parameter),
        flown=flown,
        turn_through=through,
        **varied,
    )


def _varied(model: ImpactModel, parameter: str, factor: Array) -> dict[str, Array]:
    """Return estimates `(N,)` for factors on a parameter."""
    name = "slope" if parameter == "speed" else parameter
    values = getattr(model, name) * (factor**3 if parameter == "speed" else factor)
    if name == "clearance" and isinstance(model.stiffness, StiffnessLaw):
        # A law takes one clearance at a time.
        every = [model.of(clearance=value) for value in values.tolist()]
        found = Estimates(*(np.array(column) for column in zip(*every, strict=True)))
    else:
        found = model.of(**{name: values})
    names = ("contact_time", "tau", "impact_speed", "peak", "rigid", "added")
    return {name: np.array(np.broadcast_to(getattr(found, name), factor.shape)) for name in names}


def _judged(
    of: ForceReversal | ImpactModel, parameter: str, factor: Array, time: Array
) -> tuple[Array, Array]:
    """Return `Influence.flown` and `turn_through` `(N,)` for flights that last a time."""
    if isinstance(of, ImpactModel):
        return np.full(factor.shape, np.nan), np.full(factor.shape, np.nan)
    longer = time / of.contact_time
    faster = factor if parameter == "speed" else 1.0
    # By inertia alone, the least force grows with the square of the speed, its slope with the cube.
    steeper = factor if parameter in ("speed", "slope") else 1.0
    return np.asarray(of.flown * faster * longer), np.asarray(of.turn_through / (steeper * longer))
