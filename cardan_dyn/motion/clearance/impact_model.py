"""Impact model: what the two-mass model of Dresig and Thümmel says of impacts, as whole arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from cardan_dyn.analytic.damped_impact import damped_peak, flight
from cardan_dyn.analytic.damped_impact import peak_exponents as damped_exponents
from cardan_dyn.analytic.impact import Start
from cardan_dyn.analytic.impact import reversal as undamped
from cardan_dyn.analytic.peak_exponents import PeakExponents, peak_exponents

from ...kit.arrays import EPS, ROUNDED, Array
from ...kit.checks import positive
from ...kit.errors import ArgumentError
from .arguments import damping_ratio_of, start_of
from .pin_geometry import StiffnessLaw


class Estimates(NamedTuple):
    """What impacts are estimated to be, each `(K,)` or a number.

    Attributes:
        stiffness: c at the peak [N/m].
        contact_time: t₁ from the reversal to the impact [s].
        impact_speed: v₁ [m/s].
        tau: characteristic number.
        peak: greatest force after the impact [N]; NaN if there is none.
        rigid, added: parts of the undamped peak: of the ramp, and of the clearance [N].
    """

    stiffness: Array
    contact_time: Array
    impact_speed: Array
    tau: Array
    peak: Array
    rigid: Array
    added: Array


@dataclass(frozen=True)
class ImpactModel:
    """The two-mass model at one reversal, by its numbers.

    Attributes:
        mass: reduced mass m [kg].
        stiffness: c of the contact [N/m], or a geometry that decides it at the peak.
        clearance: difference 2 s of the diameters of bush and pin [m].
        slope: of the force at its reversal, F₀/t₀ [N/s].
        damping_ratio: as a fraction of critical damping with the reduced mass.
        start: "release", as a contact that unloads lets go, or "rest", as in the paper.
    """

    mass: float
    stiffness: float | StiffnessLaw
    clearance: float
    slope: float
    damping_ratio: float = 0.0
    start: Start = "release"

    def __post_init__(self) -> None:
        for name in ("mass", "stiffness", "clearance", "slope"):
            value = getattr(self, name)
            if not isinstance(value, StiffnessLaw) or name != "stiffness":
                object.__setattr__(self, name, positive(name, value))
        object.__setattr__(self, "damping_ratio", damping_ratio_of(self.damping_ratio))
        start_of(self.start)

    def of(self, **numbers: Any) -> Estimates:
        """Return what impacts are estimated to be with other numbers, which broadcast.

        Flight, impact and peak are those of a contact with its damping.

        Args:
            numbers: fields of the model by name, `(K,)` each; but one clearance where a law decides
                the stiffness.

        Raises:
            ArgumentError: a peak is beyond what the contact has a stiffness for.

        Source:
            Dresig and Thümmel (14) to (17), (22) to (27), (32) to (34); own derivation with
            damping.
        """
        given = {**vars(self), **numbers}
        law, clearance, slope = (given[name] for name in ("stiffness", "clearance", "slope"))
        others = clearance, slope, given["damping_ratio"], given["start"]
        if not isinstance(law, StiffnessLaw):
            return _at(given["mass"], law, *others)
        limit = law.limit(clearance)
        # At the limit itself a contact has no stiffness.
        most = (1.0 - ROUNDED) * limit
        # Peaks depend on stiffness little, and it on them less: steps converge from any force.
        force = np.full(np.broadcast_shapes(np.shape(given["mass"]), np.shape(slope)), 0.1 * limit)
        stays = np.zeros(force.shape, dtype=bool)
        for _ in range(100):
            found = _at(given["mass"], law.stiffness(force, clearance), *others)
            # Without a peak the force goes on rising, and the contact with it gets stiffer.
            after = np.minimum(np.where(np.isnan(found.peak), 2.0 * force, found.peak), most)
            stays = np.abs(after - force) <= 64.0 * EPS * force
            if stays.all():
                break
            force = after
        if np.any(found.peak > most):
            raise ArgumentError(
                f"the peak exceeds {limit:.4g} N, from which on a line contact with a clearance of "
                f"{clearance:g} m has no stiffness; make it longer, or its seat softer"
            )
        # Where no force has a stiffness that stops it there, there is no peak.
        return found._replace(
            **{name: np.where(stays, getattr(found, name), np.nan) for name in found._fields[4:]}
        )

    @cached_property
    def estimate(self) -> Estimates:
        """What the impact is estimated to be.

        Raises:
            ArgumentError: the peak is beyond what the contact has a stiffness for.
        """
        return Estimates(*(np.asarray(value)[()] for value in self.of()))

    @cached_property
    def exponents(self) -> PeakExponents:
        """By which powers of its parameters the peak grows; NaN if there is none.

        Closed forms, by the chain rule through f(τ). The damping ratio stays as it is, and `speed`
        is that of inertia forces, whose slope grows with its cube. Where a geometry decides the
        stiffness, that follows force and clearance; `stiffness` is then a factor on what it gives.
        """
        found = self.estimate
        if self.damping_ratio:
            plain = damped_exponents(found.tau, self.damping_ratio, start=self.start)
        else:
            plain = peak_exponents(found.tau, start=self.start)
        law = self.stiffness
        if isinstance(law, StiffnessLaw) and not np.isnan(found.peak):
            follows = plain.stiffness * law.hardening(found.peak, self.clearance)
            followed = plain._replace(clearance=plain.clearance - follows)
            plain = PeakExponents(*(value / (1.0 - follows) for value in followed))
        return plain


def _at(
    mass: Any, stiffness: Any, clearance: Any, slope: Any, ratio: Any, start: Start
) -> Estimates:
    """Return estimates with a given stiffness."""
    numbers = mass, stiffness, 0.5 * np.asarray(clearance), slope
    found = undamped(*numbers, start=start)
    time, speed, peak = found.t_1, found.v_1, found.peak
    if np.any(ratio):
        time, speed = flight(*numbers, ratio, start=start)
        peak = damped_peak(*numbers, ratio, start=start)
    stiffness = np.broadcast_to(stiffness, np.shape(found.tau))
    return Estimates(stiffness, time, speed, found.tau, peak, found.rigid, found.added)


def estimate(models: Sequence[tuple[str, ImpactModel]]) -> None:
    """Find the estimates of many models in few calls: each costs more than its arrays.

    Args:
        models: which start alike, with the names of their joints.
    """
    groups: dict[Any, list[ImpactModel]] = {}
    for name, model in models:
        # A law takes one clearance at a time.
        law = model.stiffness if isinstance(model.stiffness, StiffnessLaw) else None
        groups.setdefault(law and (name, law), []).append(model)
    for key, some in groups.items():
        varied = ["mass", "slope", "damping_ratio", *(() if key else ("stiffness", "clearance"))]
        try:
            with np.errstate(over="raise"):
                values = some[0].of(
                    **{name: np.array([getattr(model, name) for model in some]) for name in varied}
                )
        except FloatingPointError:
            raise ArgumentError(
                "clearance and stiffness are so great, or so small, that impacts overflow; "
                "clearance is in m, stiffness in N/m"
            ) from None
        except ArgumentError as error:
            raise ArgumentError(f"joint {key[0]!r}: {error}" if key else str(error)) from error
        for place, model in enumerate(some):
            # What the model would find itself.
            vars(model)["estimate"] = Estimates(*(value[place] for value in values))
