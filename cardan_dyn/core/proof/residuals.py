"""Residuals: how far a result violates balances and constraints, and whether that is allowed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, NoReturn

import numpy as np

from ...kit.arrays import EPS, Array
from ...kit.errors import AccuracyError, as_position, as_text
from ..tape import Scalar, greater, select
from .vectors import ratio

if TYPE_CHECKING:
    from ..elements.link_loads import LinkLoad

BALANCE_TOLERANCE = 1e-8
"""Greatest relative residual of a result: of bodies, of power, of loops and of rates.

Rounding leaves some 1e-14 of well-conditioned mechanisms, and more in proportion to the condition
number of the closure equations; a mistake in an equation or a number leaves far more.
"""
CHECK_ROUNDING = 0.1 * EPS
"""Imbalance of bodies that rounding may hide, as a part of `Residuals.inertia`.

The size of inertial terms is estimated with the length of the whole mechanism, some ten times that
of its bodies; hence the tenth.
"""
SUM_ROUNDING = 1e-13
"""Part of the terms of a sum that rounding leaves of it where they cancel.

It is some hundred times the rounding of a single term, since the balance of a body adds up about as
many terms.
"""


class Claim(NamedTuple):
    """A result that is to be proven, for a block of N samples.

    Attributes:
        x: `(N, size)` coordinates of all joints.
        turns: `(N, size)` whole turns to be added to their angles.
        v, a: joint velocities and accelerations `(N, nv)`.
        positions: prescribed drive positions `(N, d)`.
        speeds, accelerations: prescribed drive speeds and accelerations `(N, d)` or `(1, d)`.
        held: prescribed positions of the held joints `(N, h)` or `(1, h)`.
        velocity_ratios: `(N, nv, d)` joint velocities per unit speed of each drive.
        wrenches: `(N, J, 6)` of the claimed joints, each in its frame, see `FreeBodies.claimed`.
        exerted: `(N, nv)` efforts of drives and held joints.
        couplings: `(N, G)` moments of the couplings at their successors' joints.
        loads: `(N, nv)` or `(1, nv)` efforts added at the joints.
        link_loads: links and the wrenches that act on them.
        gravity: `(N, 3)` or `(1, 3)` [m/s²].
        inertia: link to the factor on its mass and inertia, `(N,)` or `(1,)`.
        has_rates: whether any sample of the sweep has a drive speed or acceleration; if not, `v`
            and `a` are zero.
        time: at which actuators act, `(N,)` or `(1,)` [s].
    """

    x: Array
    turns: Array
    v: Array
    a: Array
    positions: Array
    speeds: Array
    accelerations: Array
    held: Array
    velocity_ratios: Array
    wrenches: Array
    exerted: Array
    couplings: Array
    loads: Array
    link_loads: Mapping[str, LinkLoad]
    gravity: Array
    inertia: Mapping[str, Array]
    has_rates: bool
    time: Array = np.zeros(1)


@dataclass(frozen=True)
class Proven:
    """What proves a result: its worst residuals, all of which results show under these names.

    Attributes:
        loop_residual, balance_residual, power_residual, rate_residual: see `Sweep`.
        unproven: links that `balance_residual` leaves out.
    """

    loop_residual: float
    balance_residual: float
    power_residual: float
    rate_residual: float
    unproven: tuple[str, ...]

    @property
    def residuals(self) -> dict[str, float]:
        """The residuals by their names."""
        return {name: vars(self)[name] for name in vars(self) if name.endswith("_residual")}

    def with_unseen(self, imbalance: float) -> Proven:
        """Return the same with an imbalance of bodies that rounding may hide."""
        balance = self.balance_residual + imbalance
        rest = self.power_residual, self.rate_residual, self.unproven
        return Proven(self.loop_residual, balance, *rest)

    @staticmethod
    def worst(each: Sequence[Proven]) -> Proven:
        """Return the worst of results that leave out the same links."""
        greatest = {
            name: float(np.max([getattr(one, name) for one in each])) for name in each[0].residuals
        }
        return Proven(**greatest, unproven=each[0].unproven)


class Residuals(NamedTuple):
    """Violations of balances and constraints, and what they are compared with, per sample.

    All arrays are `(N,)`. To be compared with moments, forces are multiplied with the
    characteristic length.

    Attributes:
        imbalance: greatest net wrench of a body, or effort along a coordinate, that should be zero
            [N·m].
        power_imbalance: sum of all powers, which should be zero [W, with all drives at unit speed].
        loop_error: violation of loops, couplings, drives and held joints by positions, see
            `Sweep.loop_residual`.
        rate_error: violation of these by velocities and accelerations, relative.
        wrench: greatest joint wrench [N·m].
        applied: greatest load or weight [N·m].
        inertia: greatest size of the terms that inertial wrenches are the sum of [N·m].
        power_scale: sum of the magnitudes of all powers [W, with all drives at unit speed].
        speed_scale: greatest joint speed at unit drive speeds, of slides over the length.
        bodies_balanced: whether the wrenches of all joints of any body are claimed.
        power_balanced: whether everything is claimed that the balance of power needs.
        elastic: size of the terms that forces of elements are differences of [N·m]; None without
            elements.
    """

    imbalance: Array
    power_imbalance: Array
    loop_error: Array
    rate_error: Array
    wrench: Array
    applied: Array
    inertia: Array
    power_scale: Array
    speed_scale: Array
    bodies_balanced: bool
    power_balanced: bool
    elastic: Array | None = None

    @staticmethod
    def joined(blocks: list[Residuals]) -> Residuals:
        """Return the residuals of the blocks of one sweep as one."""
        fields = zip(*blocks, strict=True)
        return Residuals._make(
            np.concatenate(of) if isinstance(of[0], np.ndarray) else of[0] for of in fields
        )

    def of_samples(self, span: slice | Array) -> Residuals:
        """Return the residuals of some samples."""
        return Residuals._make(own[span] if isinstance(own, np.ndarray) else own for own in self)

    @property
    def cancellation(self) -> Array:
        """By how much terms of inertia and elements exceed the greatest wrench they leave, `(N,)`.

        One is added, so that it is 1 at rest and rounding grows in proportion to it.
        """
        if len(self.inertia) == 1:
            return np.array([self._scalars()._cancellation()])
        if not np.count_nonzero(self.inertia):
            return np.ones(len(self.inertia))
        with np.errstate(over="ignore", invalid="ignore"):
            return np.asarray(self._cancellation())

    def _cancellation(self) -> Scalar:
        remaining = greater(self.wrench, self.applied)
        remaining = select(remaining, remaining, self.inertia)
        terms = self.inertia if self.elastic is None else self.inertia + self.elastic
        return 1.0 + ratio(terms, remaining)

    def proven(self, loop_error: Array, unproven: tuple[str, ...]) -> Proven:
        """Return the worst of all samples.

        Args:
            loop_error: `(N,)` of the closed loops, as the solution found it.
            unproven: see `Proven`.
        """
        with np.errstate(over="ignore", invalid="ignore"):  # As while they were judged.
            return Proven(
                loop_residual=float(np.max(loop_error)),
                balance_residual=self.balance,
                power_residual=self.power,
                rate_residual=self.rate,
                unproven=unproven,
            )

    @property
    def balance(self) -> float:
        """Greatest imbalance of the bodies relative to the greatest wrench of all samples.

        It includes the imbalance that the rounding of inertial terms may hide. It is nan where no
        body's balance is known, and where no load, weight or inertia acts, since there is nothing
        to compare with.
        """
        if not self.bodies_balanced:
            return float("nan")
        return _worst(self.imbalance + CHECK_ROUNDING * self.inertia, self._greatest_wrench())

    @property
    def rate(self) -> float:
        """Greatest violation of loops, couplings and drives by rates, relative."""
        return float(self.rate_error.max())

    @property
    def power(self) -> float:
        """Greatest imbalance of power relative to the power that flows.

        The greatest wrench times the greatest joint speed is added to that power, since powers
        cannot cancel more exactly than its rounding where none flows, as of balanced weights.
        """
        if not self.power_balanced:
            return float("nan")
        scale = self.power_scale + self._greatest_wrench() * self.speed_scale
        return _worst(self.power_imbalance, scale)

    def prove(self, positions: Array, condition: Array) -> None:
        """Refuse a result whose residuals exceed the tolerance at any sample.

        Each is relative to its sample's own loads, wrenches and inertial terms, the rounding of
        which no balance can go below.

        Args:
            positions: of the drives `(N, d)`.
            condition: `(N,)` condition numbers of the closure equations, for the message.

        Raises:
            AccuracyError: a residual exceeds its tolerance, or is not a number.
        """
        if self.is_proven():
            return
        for name, (error, scale) in self._judged().items():
            if not np.all(_is_small(error, scale)):
                _refuse(name, error, scale, positions, condition)

    def is_proven(self) -> bool:
        """Return whether `prove` accepts the result."""
        judged = [_is_small(*of_name) for of_name in self._scalars()._judged().values()]
        return all(judged if len(self.loop_error) == 1 else map(np.all, judged))

    def _scalars(self) -> Residuals:
        """Return the same with floats where there is a single sample: much faster than arrays."""
        if len(self.loop_error) > 1:
            return self
        return Residuals._make(
            [value.item() if type(value) is np.ndarray else value for value in self]
        )

    def _judged(self) -> dict[str, tuple[Scalar, Scalar]]:
        """Return the residuals by name: errors `(N,)`, and what they are part of."""
        # Errors of loops and rates are relative already.
        judged: dict[str, tuple[Scalar, Scalar]]
        judged = {"loop": (self.loop_error, 1.0), "rate": (self.rate_error, 1.0)}
        size = self.wrench + self.applied + self.inertia
        if self.elastic is not None:
            # Times the tolerance, what rounding leaves of differences, however stiff an element is.
            size = size + SUM_ROUNDING / BALANCE_TOLERANCE * self.elastic
        if self.bodies_balanced:
            judged["balance"] = self.imbalance, size
        if self.power_balanced:
            scale = self.power_scale + size * self.speed_scale
            judged["power"] = self.power_imbalance, scale
        return judged

    def _greatest_wrench(self) -> Array:
        """Return the greatest wrench or load of all samples [N·m], as an array per sample.

        Where it is mere rounding of the sample's inertial terms, these take its place.
        """
        greatest = np.maximum(self.wrench, self.applied).max()
        return np.where(self.cancelled(greatest), self.inertia, greatest)

    def cancelled(self, greatest: float) -> Array:
        """Return `(N,)` where the greatest wrench of all samples is rounding of inertial terms."""
        is_cancelled: Array = greatest <= SUM_ROUNDING * self.inertia
        return is_cancelled


def overflow(what: str) -> AccuracyError:
    """Return the error that numbers are too great, or too different, for doubles."""
    return AccuracyError(
        f"{what} cannot be computed, since numbers overflow; choose units in which lengths, "
        "masses, speeds and loads are not so far from 1",
        residual=float("nan"),
        tolerance=BALANCE_TOLERANCE,
        position=None,
    )


def _is_small(error: Scalar, scale: Scalar) -> Scalar:
    """Return where residuals are within the tolerance times their scale, see `Residuals.prove`.

    Comparisons with what is not a number are false, so that it is no proof.
    """
    return (error <= BALANCE_TOLERANCE * scale) & (scale < np.inf)


def _refuse(name: str, error: Array, scale: Scalar, positions: Array, condition: Array) -> NoReturn:
    """Raise the error for a residual `(N,)` that exceeds the tolerance times its scale."""
    scale = np.broadcast_to(scale, error.shape)
    with np.errstate(over="ignore", invalid="ignore"):
        relative, bad = ratio(error, scale), ~_is_small(error, scale)
    worst = int(np.argmax(np.where(bad, np.nan_to_num(relative, nan=np.inf), -1.0)))
    at = f"drive position {as_text(positions[worst])}"
    if not np.isfinite(relative[worst]) or not np.isfinite(scale[worst]):
        raise overflow(f"the {name} residual at {at}")
    if SUM_ROUNDING * condition[worst] < BALANCE_TOLERANCE:
        advice = "which explains no such error: please report it with the scene"
    else:
        advice = "stay away from this position or choose another drive"
    raise AccuracyError(
        f"the {name} residual is {relative[worst]:.1e} at {at}, more than "
        f"{BALANCE_TOLERANCE:.0e}; the closure equations have condition "
        f"{condition[worst]:.1e} there: {advice}",
        residual=float(relative[worst]),
        tolerance=BALANCE_TOLERANCE,
        position=as_position(positions[worst]),
    )


def _worst(error: Array, scale: Array) -> float:
    """Return the greatest relative error, nan where there is nothing to compare."""
    if not scale.any() and not error.any():
        return float("nan")
    with np.errstate(over="ignore", invalid="ignore"):
        return float(ratio(error, scale).max())
