"""Contact laws: the force that presses two sides apart, of how deep and how fast they press in.

Depth δ [m] and its rate δ̇ [m/s] are positive inwards. A touch lasts as long as the depth is
positive; its force is that of the law where this pushes, and none where the law would pull.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...kit.arrays import Array
from ...kit.checks import number, positive
from ...kit.errors import ArgumentError
from ...kit.roots import zero
from .contact_law import ContactLaw, ranged
from .restitutions import loss_of_restitution, restitution_of_damping_ratio, restitution_of_loss
from .stepping import advance

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .contact_law import Numbers

__all__ = [
    "ContactLaw",
    "HuntCrossley",
    "ImpactFunction",
    "LankaraniNikravesh",
    "LinearContact",
]

_LEAST_RESTITUTION = 1e-3
"""Of a Hunt-Crossley law: below, its damper is more than a thousand times its spring."""
_RTOL, _ATOL = 1e-13, 1e-15
"""Tolerances of a free impact that is integrated, near rounding."""


@dataclass(frozen=True, eq=False)
class LinearContact(ContactLaw):
    """A spring beside a damper: F = c δ + d δ̇. The damper makes it jump at the touch.

    Attributes:
        stiffness: c [N/m], positive.
        damping: d [N·s/m], not negative.

    Raises:
        ArgumentError: a value is no finite number, or out of its range.
    """

    stiffness: float
    damping: float = 0.0

    def __post_init__(self) -> None:
        self._set(
            stiffness=positive(self._label("stiffness"), self.stiffness),
            damping=number(self._label("damping"), self.damping, 0.0),
        )

    @classmethod
    def of_ratio(cls, stiffness: float, ratio: float, mass: float) -> LinearContact:
        """Return the contact with a ratio d / (2 √(c m)) of damping to critical damping.

        Args:
            stiffness: c [N/m], positive.
            ratio: not negative.
            mass: reduced mass m of both sides [kg], positive.

        Raises:
            ArgumentError: a value is no finite number, or out of its range.
        """
        stiffness = positive("LinearContact: stiffness", stiffness)
        critical = 2.0 * np.sqrt(stiffness * positive("LinearContact: mass", mass))
        return cls(stiffness, number("LinearContact: ratio", ratio, 0.0) * critical)

    def force(self, depth: Numbers, rate: Numbers, touch_speed: Numbers = 0.0) -> Array:
        """Return c δ + d δ̇, see `ContactLaw.force`."""
        if isinstance(depth, float) and isinstance(rate, float):
            # What integrators ask for, a tenth of the time.
            return np.asarray(self.stiffness * depth + self.damping * rate)
        return self.stiffness * np.asarray(depth, dtype=float) + self.damping * np.asarray(
            rate, dtype=float
        )

    def _restitution(self, touch_speed: float, mass: float) -> float:
        ratio = self.damping / (2.0 * np.sqrt(self.stiffness * mass))
        return restitution_of_damping_ratio(float(ratio))


class _PowerLaw(ContactLaw):
    """What laws F = k δⁿ (1 + h δ̇ / v₀) have in common.

    Attributes:
        exponent: n.
        wanted: restitution that was asked for; None if a factor was.
        factor: λ = h / v₀ [s/m] if it is constant, else None.
    """

    exponent: float
    wanted: float | None
    factor: float | None = None

    @property
    def needs_touch_speed(self) -> bool:
        """Whether the force depends on the speed at which the touch began."""
        return self.factor is None

    @property
    def order(self) -> float:
        """Exponent n of the spring part k δⁿ."""
        return self.exponent

    def loss(self, touch_speed: ArrayLike) -> Array:
        """Return h for speeds of touch [m/s]: of a wanted restitution the same for all."""
        speed = np.asarray(touch_speed, dtype=float)
        return np.full_like(speed, self._loss) if self.factor is None else self.factor * speed

    @property
    def _loss(self) -> float:
        """Loss h of the restitution that was asked for."""
        raise NotImplementedError

    def force(self, depth: Numbers, rate: Numbers, touch_speed: Numbers = 0.0) -> Array:
        """Return k δⁿ (1 + h δ̇ / v₀), see `ContactLaw.force`."""
        if isinstance(depth, float) and isinstance(rate, float) and isinstance(touch_speed, float):
            # What integrators ask for, a tenth of the time.
            return np.asarray(self._spring_of(depth) * (1.0 + self._damping_of(touch_speed) * rate))
        rate = np.asarray(rate, dtype=float)
        if self.factor is not None:
            return self._spring(depth) * (1.0 + self.factor * rate)
        speed = np.asarray(touch_speed, dtype=float)
        factor = np.where(speed > 0.0, self._loss, 0.0) / np.where(speed > 0.0, speed, 1.0)
        return self._spring(depth) * (1.0 + factor * rate)

    def _damping_of(self, touch_speed: float) -> float:
        """Return h / v₀ of one touch."""
        if self.factor is not None:
            return self.factor
        return self._loss / touch_speed if touch_speed > 0.0 else 0.0

    def _restitution(self, touch_speed: float, mass: float) -> float:
        return restitution_of_loss(float(self.loss(touch_speed)))


@dataclass(frozen=True, eq=False, init=False)
class HuntCrossley(_PowerLaw):
    """A spring whose damper grows with its force: F = k δⁿ (1 + h δ̇ / v₀).

    Either the restitution e is given, which a free impact at any speed v₀ then has exactly: h
    follows from h (1 + e) = ln[(1 + h) / (1 - h e)]. Or the factor λ of F = k δⁿ (1 + λ δ̇) is,
    which needs no speed of touch; the restitution then falls as the speed grows.

    Attributes:
        stiffness: k [N/mⁿ], positive.
        exponent: n, not less than 1: 1.5 of balls, near 1 of a pin along its bush.
        wanted: e that was asked for, from 0.001 to 1; None if a factor was.
        factor: λ [s/m], not negative; None if a restitution was asked for.

    Raises:
        ArgumentError: a value is no finite number or out of its range, or not exactly one of
            restitution and factor is given.

    Source:
        Hunt and Crossley 1975 for the law, h from the energy of a free impact.
    """

    stiffness: float
    exponent: float
    wanted: float | None
    factor: float | None

    def __init__(
        self,
        stiffness: float,
        exponent: float = 1.5,
        restitution: float | None = None,
        factor: float | None = None,
    ) -> None:
        if (restitution is None) == (factor is None):
            raise ArgumentError(
                "HuntCrossley needs one of restitution and factor; give restitution=, from "
                f"{_LEAST_RESTITUTION:g} to 1, or factor= [s/m]"
            )
        self._set_spring(stiffness, exponent)
        if restitution is not None:
            restitution = ranged(self._label("restitution"), restitution, _LEAST_RESTITUTION)
        if factor is not None:
            factor = number(self._label("factor"), factor, 0.0)
        loss = None if restitution is None else loss_of_restitution(restitution)
        self._set(wanted=restitution, factor=factor, _known_loss=loss)

    @property
    def _loss(self) -> float:
        return float(vars(self)["_known_loss"])


@dataclass(frozen=True, eq=False, init=False)
class LankaraniNikravesh(_PowerLaw):
    """The law F = k δⁿ (1 + h δ̇ / v₀) with h = 3 (1 - e²) / 4, an approximation for e near 1.

    A free impact has another restitution than e, at any speed the same: see `true_restitution`.

    Attributes:
        stiffness: k [N/mⁿ], positive.
        exponent: n, not less than 1.
        wanted: e, from 0 to 1.

    Raises:
        ArgumentError: a value is no finite number, or out of its range.

    Source:
        Lankarani and Nikravesh 1990.
    """

    stiffness: float
    exponent: float
    wanted: float

    def __init__(self, stiffness: float, exponent: float = 1.5, restitution: float = 1.0) -> None:
        self._set_spring(stiffness, exponent)
        self._set(wanted=ranged(self._label("restitution"), restitution, 0.0))

    @property
    def true_restitution(self) -> float:
        """Restitution that a free impact has, at any speed and mass."""
        return restitution_of_loss(self._loss)

    @property
    def _loss(self) -> float:
        return 0.75 * (1.0 - self.wanted) * (1.0 + self.wanted)


@dataclass(frozen=True, eq=False)
class ImpactFunction(ContactLaw):
    """The IMPACT law of commercial programs: max(0, k δⁿ + STEP(δ, 0, 0, D, d) δ̇).

    The damping grows from 0 at the touch to d at the depth D as 3 u² - 2 u³, u = δ / D.

    Attributes:
        stiffness: k [N/mⁿ], positive.
        exponent: n, not less than 1.
        damping: d [N·s/m], not negative.
        full_depth: D [m], positive.

    Raises:
        ArgumentError: a value is no finite number, or out of its range.
    """

    stiffness: float
    exponent: float
    damping: float
    full_depth: float

    def __post_init__(self) -> None:
        self._set_spring(self.stiffness, self.exponent)
        self._set(
            damping=number(self._label("damping"), self.damping, 0.0),
            full_depth=positive(self._label("full_depth"), self.full_depth),
        )

    @property
    def order(self) -> float:
        """Exponent n of the spring part k δⁿ."""
        return self.exponent

    @property
    def kinks(self) -> tuple[float, ...]:
        """The depth at which the damping is full."""
        return (self.full_depth,)

    def force(self, depth: Numbers, rate: Numbers, touch_speed: Numbers = 0.0) -> Array:
        """Return k δⁿ + STEP(δ) δ̇, see `ContactLaw.force`; it is not clipped."""
        if isinstance(depth, float) and isinstance(rate, float):  # What integrators ask for.
            part = min(max(depth / self.full_depth, 0.0), 1.0)
            drag = self.damping * part * part * (3.0 - 2.0 * part) * rate
            return np.asarray(self._spring_of(depth) + drag)
        u = np.clip(np.asarray(depth, dtype=float) / self.full_depth, 0.0, 1.0)
        damping = self.damping * u * u * (3.0 - 2.0 * u)
        return self._spring(depth) + damping * np.asarray(rate, dtype=float)

    def _restitution(self, touch_speed: float, mass: float) -> float:
        # In units of the depth without damping and of the speed before.
        power = self.exponent + 1.0
        unit = (0.5 * mass * touch_speed**2 * power / self.stiffness) ** (1.0 / power)
        per_mass = unit / (mass * touch_speed**2)

        def pressure(_: float, y: Array) -> float:
            return per_mass * float(self.force(float(unit * y[0]), float(touch_speed * y[1])))

        def rate(_: float, y: Array) -> Array:
            return np.array([y[1], -pressure(0.0, y)])

        full, is_deep, time, y = self.full_depth / unit, False, 0.0, np.array([0.0, 1.0])
        while True:
            sign = 1.0 if is_deep else -1.0  # The damping has a bend at its full depth.
            watches = (
                lambda _, y: float(y[0]),
                pressure,
                lambda _, y, sign=sign: sign * (float(y[0]) - full),
            )
            found = advance(rate, time, y, np.inf, watches, rtol=_RTOL, atol=np.full(2, _ATOL))
            time, y = found.time, found.state
            if found.event == 2:
                is_deep = not is_deep
                continue
            back = self._back(unit * y[0], touch_speed * y[1]) / unit if found.event == 1 else 0.0
            if back == 0.0:
                return -float(y[1])
            y, is_deep = np.array([back, y[1]]), False

    def _back(self, depth: float, rate: float) -> float:
        """Return the depth at which a force that has vanished comes back on the way out, or 0."""
        n, full = self.exponent, self.full_depth
        if n >= 2.0:
            return 0.0
        # STEP is below 3 u² and falls faster than uⁿ up to the second of these parts.
        spring = self.stiffness * full**n / (3.0 * self.damping * abs(rate))
        low = full * min(spring ** (1.0 / (2.0 - n)), 1.0)
        high = min(depth, full * min(3.0 * (2.0 - n) / (6.0 - 2.0 * n), 1.0))
        if low >= high or self.force(low, rate) <= 0.0 or self.force(high, rate) >= 0.0:
            return 0.0
        return zero(lambda x: float(self.force(x, rate)), low, high)
