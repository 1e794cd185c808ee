"""Pin geometry: the stiffness of a contact from pin, bush and what holds them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from cardan_dyn.analytic.contact_stiffness import contact_stiffness, cylinder_compliance

from ...kit.arrays import NOTHING, Array
from ...kit.checks import number, positive
from ...kit.errors import ArgumentError

_NEARLY_EQUAL = 0.1
"""Difference of the radii, as a fraction of the pin's, up to which they count as nearly equal, as
the formula of the contact takes them to be."""
_WIDE = 0.5
"""Half the width of the contact, as a fraction of the radius, beyond which pin and bush are no
half-spaces to each other any more."""


@dataclass(frozen=True)
class PinGeometry:
    """A pin in its bush, as a stiffness that depends on the force.

    Line contact of two cylinders, and in series with it what pin and seat give way. The contact
    alone is some hundred times stiffer than that, so that a scan without `seat_stiffness` says so.

    Attributes:
        length: of the contact along the pin [m].
        radius: of the pin [m].
        seat_stiffness: of pin, bush and their seats in the links, all in series [N/m]; None if
            they count as rigid.
        pin_modulus, bush_modulus: Young's moduli [Pa]; steel unless given.
        pin_poisson, bush_poisson: Poisson's ratios.
    """

    length: float
    radius: float
    seat_stiffness: float | None = None
    pin_modulus: float = 2.1e11
    bush_modulus: float = 2.1e11
    pin_poisson: float = 0.3
    bush_poisson: float = 0.3

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if value is None and field.name == "seat_stiffness":
                continue
            if field.name.endswith("poisson"):
                checked = number(field.name, value)
                if not -1.0 < checked <= 0.5:
                    raise ArgumentError(f"{field.name} is {checked:g}; it lies above -1 up to 0.5")
            else:
                checked = positive(field.name, value)
            object.__setattr__(self, field.name, checked)

    @property
    def compliance(self) -> float:
        """K₁ + K₂ of the materials of pin and bush [1/Pa]."""
        pin = cylinder_compliance(self.pin_modulus, self.pin_poisson)
        return float(pin + cylinder_compliance(self.bush_modulus, self.bush_poisson))

    def limit(self, clearance: float) -> float:
        """Return the force from which on the formula of the contact gives no stiffness [N].

        Args:
            clearance: difference of the diameters of bush and pin [m].

        Raises:
            ArgumentError: the radii are not nearly equal.
        """
        if clearance > 2.0 * _NEARLY_EQUAL * self.radius:
            raise ArgumentError(
                f"clearance is {clearance:g} m in a bush about a pin of radius {self.radius:g} m; "
                f"the line contact is of nearly equal radii, up to {2.0 * _NEARLY_EQUAL:g} of it"
            )
        return 2.0 * self.length * clearance / self.compliance

    def stiffness(self, force: Array, clearance: float) -> Array:
        """Return the stiffness of contact and seat in series at forces [N/m].

        Args:
            force: [N], of any shape.
            clearance: difference of the diameters of bush and pin [m].

        Raises:
            ArgumentError: a force is beyond `limit`, or the radii are not nearly equal.

        Source:
            ESDU 78035, see `analytic.contact_stiffness`.
        """
        limit = self.limit(clearance)
        if np.any(force >= limit):
            raise ArgumentError(
                f"a force of {np.max(force):.4g} N is beyond what a line contact of "
                f"{self.length:g} m with a clearance of {clearance:g} m has a stiffness for, "
                f"{limit:.4g} N"
            )
        contact = contact_stiffness(force, self.compliance, self.length, 0.5 * clearance)
        if self.seat_stiffness is None:
            return np.asarray(contact)
        return np.asarray(contact * (self.seat_stiffness / (contact + self.seat_stiffness)))

    def hardening(self, force: Array, clearance: float) -> Array:
        """Return by which power of the force the stiffness grows, d ln c / d ln F.

        It falls with the same power of the clearance.

        Args:
            force: [N], of any shape, below `limit`.
            clearance: difference of the diameters of bush and pin [m].
        """
        alone = 1.0 / np.log(self.limit(clearance) / force)
        if self.seat_stiffness is None:
            return np.asarray(alone)
        contact = contact_stiffness(force, self.compliance, self.length, 0.5 * clearance)
        return np.asarray(alone * (self.seat_stiffness / (contact + self.seat_stiffness)))

    def spreads(self, force: float, clearance: float) -> float:
        """Return half the width of the contact as a fraction of the radius; Hertz."""
        return 4.0 * float(np.sqrt(force / self.limit(clearance)))

    def doubts(self, force: float, clearance: float) -> tuple[str, ...]:
        """Return what speaks against the stiffness at a force."""
        found = []
        if self.seat_stiffness is None:
            found.append(
                "a line contact alone is some hundred times too stiff: give seat_stiffness"
            )
        if (width := self.spreads(force, clearance)) > _WIDE:
            found.append(f"the contact is {width:.2f} of the radius wide to each side: no line")
        return tuple(found)


@dataclass(frozen=True)
class InSeries:
    """The contacts of several bearings as one, in which the greatest of their forces acts.

    Attributes:
        laws: stiffness of each, or what decides it.
        shares: force of each as a fraction of their norm.
        clearances: of each as a fraction of that of all together.
    """

    laws: tuple[float | PinGeometry, ...]
    shares: tuple[float, ...]
    clearances: tuple[float, ...]

    @property
    def _geometries(self) -> list[tuple[PinGeometry, float, float]]:
        """Geometries with their forces as fractions of the greatest, and their clearances."""
        most = max(self.shares)
        every = zip(self.laws, self.shares, self.clearances, strict=True)
        return [
            (law, share / most, part)
            for law, share, part in every
            if isinstance(law, PinGeometry) and share > NOTHING * most
        ]

    def limit(self, clearance: float) -> float:
        """Return the force from which on one of them gives no stiffness [N]."""
        return min(law.limit(part * clearance) / share for law, share, part in self._geometries)

    def _compliances(self, force: Array, clearance: float) -> list[Array]:
        """Return what each gives way, those of numbers together first [m/N]."""
        numbers = zip(self.laws, self.shares, strict=True)
        fixed = sum(s**2 / law for law, s in numbers if not isinstance(law, PinGeometry))
        found = [np.asarray(fixed)]
        for law, share, part in self._geometries:
            carried = max(self.shares) * share
            found.append(carried**2 / law.stiffness(share * force, part * clearance))
        return found

    def stiffness(self, force: Array, clearance: float) -> Array:
        """Return the stiffness at forces [N/m]."""
        return np.asarray(1.0 / sum(self._compliances(force, clearance)))

    def hardening(self, force: Array, clearance: float) -> Array:
        """Return by which power of the force the stiffness grows."""
        fixed, *parts = self._compliances(force, clearance)
        grown = [
            compliance * law.hardening(share * force, part * clearance)
            for compliance, (law, share, part) in zip(parts, self._geometries, strict=True)
        ]
        return np.asarray(sum(grown) / (fixed + sum(parts)))

    def doubts(self, force: float, clearance: float) -> tuple[str, ...]:
        """Return what speaks against the stiffness at a force, of any of them."""
        every = (law.doubts(s * force, part * clearance) for law, s, part in self._geometries)
        return tuple(dict.fromkeys(doubt for doubts in every for doubt in doubts))


StiffnessLaw = PinGeometry | InSeries
"""A stiffness that depends on the force, and with the same power inversely on the clearance."""


def in_series(
    laws: Sequence[float | PinGeometry], shares: Array, clearances: Array, whole: float
) -> float | StiffnessLaw:
    """Return the stiffness of bearings together [N/m], a number if all of theirs are.

    Args:
        laws: stiffness of each, or what decides it.
        shares: force of each as a fraction of their norm.
        clearances: of each [m].
        whole: clearance of all together [m].
    """
    if not any(isinstance(law, PinGeometry) for law in laws):
        return 1.0 / float(np.sum(shares**2 / np.asarray(laws, dtype=float)))
    return InSeries(tuple(laws), tuple(shares.tolist()), tuple((clearances / whole).tolist()))
