"""Verdict case: a line, its operating points, limits and forces, as rules ask for them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from numbers import Real
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from cardan_dyn.analytic import single_joint, uniformity
from cardan_dyn.analytic.limits import CRITICAL_CONSTANTS, LIMITS, Limit

from ....kit.arrays import ROUNDED, Array
from ....kit.checks import described, mapping
from ....kit.errors import ArgumentError, CardanError, choices
from ....kit.periodic import resampled
from ..line.data import LineData
from .analysis import Analysis
from .extremes import COMPONENTS, SIGNED, greatest_of, greatest_over
from .rows import VerdictRow, judged, opened, stated, withheld
from .solving import Causes, LineSolver

GIVEN = "the caller"
"""Source of a limit that is given as a number."""
_BY_APPLICATION = {
    "": (
        *("residual_angle", "non_uniformity", "second_order_angle"),
        *("torsional_acceleration", "torsional_acceleration_greatest"),
        *("inertia_acceleration", "inertia_acceleration_greatest"),
        *("bending_speed_share", "half_critical_from", "half_critical_to", "torsional_distance"),
        *("mean_life_factor", "balancing_speed", "balance_grade_maker"),
        *("din_808_plain_speed", "din_808_needle_speed"),
    ),
    "vehicle": (
        *("angle_difference", "least_joint_angle", "speed_angle_share"),
        "bending_speed_share_automotive",
    ),
    "agricultural": ("pto_angle", "telescope_travel_left", "telescope_overlap"),
    "industrial": ("bending_speed_share_industrial",),
}
"""Names of `analytic.limits.LIMITS` by which the verdict goes, others decide no row: those of any
line, and those that hold for one application alone unless the caller gives them."""
_APPLICATION = {name: of for of, names in _BY_APPLICATION.items() for name in names}
KNOWN: Mapping[str, Limit] = MappingProxyType(
    {
        **{name: LIMITS[name] for name in _APPLICATION},
        "critical_constant": CRITICAL_CONSTANTS["steel"],
        "bounce_share": Limit(1.0, "1", GIVEN),
    }
)
"""What `limits` may give: also a maker's constant of bending speeds, and the greatest share of the
speed at which rigid shafts bounce on soft bearings, of which no source tells a limit."""
POSITIVE = frozenset(
    {"mean_life_factor", "balance_grade_maker", "critical_constant", "bounce_share"}
)
"""Names of what rules divide by."""
_OTHER = {"non_uniformity": "residual_angle", "residual_angle": "non_uniformity"}
"""Both are the limit of one angle: where one of them is given, so is the other."""


@dataclass(frozen=True)
class OperatingPoint:
    """A speed and a torque at which a line is judged.

    Attributes:
        name: for tables.
        speed: of the input shaft, its size [rad/s]; None if not known.
        torque: of the input shaft [N·m]; None if not known.
        share: of the time; 1 for the line's own speed and torque.
        steady: whether it is no row of the duty cycle.
    """

    name: str
    speed: float | None
    torque: float | None
    share: float = 1.0
    steady: bool = True


_NO_POINT = OperatingPoint("", None, None)


@dataclass(frozen=True)
class LoadCase:
    """What acts on a line in a load case.

    Attributes:
        point: the operating point.
        factors: of what forces are made of, in the order of `Case.causes`; empty for the analysis
            that the caller gave.
        how: what acts besides the torque, in words.
    """

    point: OperatingPoint
    factors: tuple[float, ...]
    how: str = ""


class Torques(NamedTuple):
    """Greatest torques at a place of a line over all load cases.

    Attributes:
        ahead: that drive what is behind in the sense of rotation, not less than 0 [N·m].
        back: of the other sense [N·m].
        condition: operating point of the greater one.
        how: its load case in words.
    """

    ahead: float
    back: float
    condition: str
    how: str

    @property
    def size(self) -> float:
        """The greater one of both [N·m]."""
        return max(self.ahead, self.back)


class Case:
    """What rules are told of a line.

    Attributes:
        line: the line.
        points: operating points: that of the line, then those of its duty cycle.
        given: names of the limits that the caller gave.
    """

    def __init__(
        self,
        line: LineData,
        limits: Mapping[str, Limit | float | str | None] | None,
        analysis: Analysis | None,
        solver: Callable[[], LineSolver],
    ) -> None:
        """Take a line.

        Args:
            line: the line.
            limits: see `DriveLine.verdict`.
            analysis: likewise.
            solver: returns what solves the line.

        Raises:
            ArgumentError: a limit is unknown or none, or the analysis is not one of the line.
        """
        self.line = line
        self._limits = _checked(limits)
        self.given = frozenset(self._limits)
        self._analysis = _of_line(line, analysis)
        self._solver = solver
        self.points = _points(line, self._analysis)
        # Quantities to their greatest sizes, and the indices of these load cases.
        self._worst: dict[str, tuple[Array, list[int]]] = {}

    def limit(self, name: str) -> Limit | None:
        """Return a limit; None if the caller has taken it out, or it does not hold for the line."""
        if name in self._limits:
            return self._limits[name]
        other = _OTHER.get(name)
        if other in self._limits:
            return _of_one_angle(name, self._limits[other])
        return LIMITS[name] if _APPLICATION.get(name) in ("", self.line.application) else None

    def of_application(self, name: str) -> str:
        """Return which limit of a kind decides, of any line or of one application.

        Those that the caller gave come first, then that of the line's application.

        Args:
            name: of the one of any line, with which the others' begin.
        """
        kind = {of: other for other, of in _APPLICATION.items() if other.startswith(name)}
        own = kind.get(self.line.application, name)
        return next((one for one in (name, own, *kind.values()) if one in self._limits), own)

    def held(self, row: VerdictRow, name: str) -> VerdictRow:
        """Return a row held against the limit of a name; a stated one if that does not apply."""
        limit = self.limit(name)
        if limit is not None:
            return judged(row, limit, "")
        return stated(row, self.why_not(name))

    def why_not(self, name: str) -> str:
        """Return why the limit of a name does not apply."""
        for given in (name, _OTHER.get(name, name)):
            if given in self._limits:
                return f"limits take {given} out"
        of = _APPLICATION.get(name)
        if of is None:
            return f"no source has a limit; limits[{name!r}] gives one"
        return f"a limit of {of} lines; give application = {of!r}, or limits[{name!r}]"

    @property
    def critical_constant(self) -> Limit | None:
        """Constant of bending speeds that the caller gave; None for the beam itself."""
        return self._limits.get("critical_constant")

    @property
    def service_factor(self) -> float:
        """K, 1 unless given."""
        return 1.0 if self.line.service_factor is None else self.line.service_factor

    @cached_property
    def fastest(self) -> tuple[float | None, OperatingPoint]:
        """Greatest speed [rad/s], and the operating point that has it; None if none is known."""
        known = [(point.speed, point) for point in self.points if point.speed is not None]
        return max(known, key=lambda item: item[0], default=(None, _NO_POINT))

    @cached_property
    def strongest(self) -> tuple[float | None, OperatingPoint]:
        """Greatest size of a torque [N·m], and the operating point that has it; likewise."""
        known = [(abs(point.torque), point) for point in self.points if point.torque is not None]
        return max(known, key=lambda item: item[0], default=(None, _NO_POINT))

    @cached_property
    def causes(self) -> Causes | None:
        """What forces are made of; None if they cannot be solved."""
        try:
            return self._solver().causes(np.array([0.0, 0.0, -9.81]))
        except CardanError as error:
            self._reason = str(error)
            return None

    @property
    def is_heavy(self) -> bool:
        """Whether any part of a line whose forces are known has mass."""
        return self.causes is not None and self.causes.is_heavy

    @cached_property
    def forces(self) -> tuple[LoadCase, ...]:
        """All load cases of all operating points: of what is not known none acts, see `lacking`."""
        if self.causes is None or self.strongest[0] is None:
            return ()
        result = []
        if self._analysis is not None:
            result.append(LoadCase(self.points[0], (), "the analysis"))
        for point in self.points:
            result += self._load_cases(self.causes, point)
        return tuple(result)

    def _load_cases(self, causes: Causes, point: OperatingPoint) -> Iterator[LoadCase]:
        """Yield the load cases of an operating point.

        Sizes of forces are convex in all that acts, so that the worst is at the ends of all ranges:
        of the torque from none to the shock torque, of the speed and of the acceleration, and of
        the friction of splines.
        """
        full = (point.torque or 0.0) * self.service_factor
        torques = [full, 0.0, *([-full] if self.line.reversing else [])] if full else [0.0]
        speeds = [point.speed or 0.0, 0.0] if causes.is_heavy and point.speed else [0.0]
        most = (self.line.acceleration or 0.0) if causes.is_heavy else 0.0
        for torque, speed, rate in itertools.product(
            torques, speeds, (most, -most) if most else (0.0,)
        ):
            acting = np.array([torque, speed**2, rate, 1.0])[: len(causes.parts)]
            how = _how(causes, torque, full, speed, rate)
            for senses in itertools.product((1.0, -1.0), repeat=len(causes.slides)):
                factors = np.concatenate([acting, *(sense * acting for sense in senses)])
                yield LoadCase(point, tuple(factors.tolist()), how)

    @property
    def no_forces(self) -> str:
        """Why there are no forces; empty if there are some."""
        if self.causes is None:
            return self._reason
        return "" if self.forces else "give torque"

    @property
    def lacking(self) -> str:
        """What more than in the load cases may act, as what would tell it; empty if nothing."""
        if self.no_forces:
            return self.no_forces
        if any(point.torque is None for point in self.points):
            return "give torque"
        is_slow = self.is_heavy and any(point.speed is None for point in self.points)
        return "give speed" if is_slow else ""

    def of_forces(
        self,
        row: VerdictRow,
        limit: Limit | None,
        missing: str,
        quantity: str = "",
        place: int = 0,
    ) -> VerdictRow:
        """Return the row of a force held against its limit, as far as all that acts is known.

        Args:
            row: with its value.
            limit: None if there is none.
            missing: what would give the limit.
            quantity: the force, if friction of splines acts on it; see `COMPONENTS`.
            place: which one of these.
        """
        held = judged(row, limit, missing)
        if limit is None:
            return held
        causes = self.causes
        if quantity and causes is not None and causes.is_open[quantity][place]:
            # The least forces are no bound of this one: it may be less as well as more.
            reasons = "; ".join(causes.indeterminate)
            return opened(held, f"statics leaves it open: {reasons}; leave out what holds too much")
        held = withheld(held, self.lacking)
        if quantity and self.unknown_frictions:
            named = ", ".join(self.unknown_frictions)
            held = withheld(held, f"give friction and radius of the spline of {named}, 0 for none")
        return held

    def worst(self, quantity: str) -> tuple[Array, list[LoadCase]]:
        """Return the greatest values of a quantity over a turn `(k,)`, and their load cases.

        Of equal cases, that is the first one.

        Args:
            quantity: see `COMPONENTS`.
        """
        if quantity not in self._worst:
            self._worst[quantity] = self._worst_of(quantity)
        sizes, cases = self._worst[quantity]
        return sizes, [self.forces[i] for i in cases]

    def joint_torque(self, k: int) -> Torques:
        """Return the greatest torques of joint k, counted from 0, in the shafts on both its sides.

        Where forces cannot be known, they are those of the input shaft.
        """
        return self._torques(k + 1, self.line.count + 1 + k)

    def driving_torque(self, k: int) -> Torques:
        """Return the greatest torques in the shaft before joint k; likewise."""
        return self._torques(self.line.count + 1 + k)

    def shaft_torque(self, k: int) -> Torques:
        """Return the greatest torques at both ends of shaft k; likewise."""
        return self._torques(k, self.line.count + 1 + k)

    def torques_over_a_turn(self, k: int, point: OperatingPoint) -> Array | None:
        """Return the torques before and behind joint k at equal steps of a turn `(P, 2)` [N·m].

        At the speed of an operating point under its torque alone, with inertia and weight, without
        the service factor and with splines that do not slide. None where forces cannot be known.
        """
        if self.causes is None:
            return None
        count = len(self.causes.parts)
        acting = np.array([point.torque or 0.0, (point.speed or 0.0) ** 2, 0.0, 1.0])[:count]
        places = [self.line.count + 1 + k, k + 1]
        parts = self._components("torque")[:count, :, places, 0]
        # A power of a sum of harmonics has more of them.
        return np.asarray(resampled(np.tensordot(acting, parts, 1), 4 * parts.shape[1], 0))

    def _torques(self, *places: int) -> Torques:
        if self.no_forces:
            torques = [self.service_factor * (point.torque or 0.0) for point in self.points]
            torques += [-torque for torque in torques] if self.line.reversing else []
            most, least, at = max(*torques, 0.0), min(*torques, 0.0), self.strongest[1].name
            return Torques(most, -least, at, f"torque of the input shaft: {self.no_forces}")
        found = []
        for name in ("torque", "torque_back"):
            sizes, cases = self.worst(name)
            place = max(places, key=lambda place: float(sizes[place]))
            found.append((max(float(sizes[place]), 0.0), cases[place]))
        (ahead, _), (back, _) = found
        worst = max(found, key=lambda item: item[0])[1]
        return Torques(ahead, back, worst.point.name, worst.how)

    def _worst_of(self, quantity: str) -> tuple[Array, list[int]]:
        """Return the greatest sizes, and the indices of their load cases."""
        cases, analysis = self.forces, self._analysis
        factors = np.array([case.factors for case in cases if case.factors])
        signed = quantity in SIGNED
        greatest = greatest_over(factors, self._components(quantity), signed=signed)
        if analysis is not None:
            own = greatest_of(COMPONENTS[quantity](analysis.total), signed=signed)
            greatest = np.concatenate([own[None], greatest])
        sizes = greatest.max(axis=0)
        return sizes, np.argmax(greatest >= sizes - ROUNDED * np.abs(sizes), axis=0).tolist()

    def _components(self, quantity: str) -> Array:
        """Return the components of a quantity in what forces are made of, `(causes, P, k, c)`."""
        causes = self.causes
        if causes is None:
            raise ValueError("there are no forces")
        parts = [*causes.parts, *(part for _, parts in causes.slides for part in parts)]
        return np.stack([COMPONENTS[quantity](part) for part in parts])

    @cached_property
    def unknown_frictions(self) -> tuple[str, ...]:
        """Names of the shafts whose spline has no coefficient of friction."""
        named = zip(self.line.shaft_names, self.line.shafts, strict=True)
        return tuple(n for n, shaft in named if shaft.spline and shaft.spline.friction is None)


def _of_one_angle(name: str, given: Limit | None) -> Limit | None:
    """Return the limit that follows from the other one of `_OTHER`, if that says something."""
    if given is None or not 0.0 <= given.value < math.pi / 2.0:
        return None
    if name == "non_uniformity":
        return Limit(float(single_joint.non_uniformity(given.value)), "1", given.source)
    angle = uniformity.angle_of_non_uniformity(given.value)
    return Limit(float(angle), "rad", given.source)


def _how(causes: Causes, torque: float, full: float, speed: float, rate: float) -> str:
    """Return a load case in words, as far as it is not that of the operating point itself."""
    listed = []
    if full and not torque:
        listed.append("without drive torque")
    if torque * full < 0.0:
        listed.append("torque reversed")
    if causes.is_heavy and not speed:
        listed.append("at rest")
    if rate:
        listed.append("running up" if rate > 0.0 else "braking")
    listed += [f"spline of {name} slides" for name, _ in causes.slides]
    return ", ".join(listed)


def _points(line: LineData, analysis: Analysis | None) -> tuple[OperatingPoint, ...]:
    speed, torque = line.speed, line.torque
    name = "rated"
    if analysis is not None:
        speed = analysis.speed
        driving = analysis.static.torsion_in[:, 0]
        torque, name = float(driving[np.abs(driving).argmax()]), "analysis"
    listed = []
    if speed is not None or torque is not None or not line.duty_cycle:
        listed.append(OperatingPoint(name, None if speed is None else abs(speed), torque))
    for index, point in enumerate(line.duty_cycle, 1):
        called = point.name or f"duty {index}"
        speed = abs(point.speed)
        listed.append(OperatingPoint(called, speed, point.torque, point.share, steady=False))
    return tuple(listed)


def _checked(
    limits: Mapping[str, Limit | float | str | None] | None,
) -> dict[str, Limit | None]:
    """Return the limits that the caller gave."""
    result: dict[str, Limit | None] = {}
    for name, value in mapping("limits", limits).items():
        if name not in KNOWN:
            listed = choices(KNOWN, name, most=len(KNOWN))
            raise ArgumentError(f"{name!r} is no limit of the verdict; limits: {listed}")
        if value is None:
            result[name] = value
        elif isinstance(value, Limit):
            result[name] = _fitting(name, value, KNOWN[name])
        elif name == "critical_constant" and isinstance(value, str):
            if value not in CRITICAL_CONSTANTS:
                raise ArgumentError(
                    f"critical_constant {value!r} is unknown; constants: "
                    f"{choices(CRITICAL_CONSTANTS, value)}"
                )
            result[name] = CRITICAL_CONSTANTS[value]
        elif not isinstance(value, bool) and isinstance(value, Real) and math.isfinite(value):
            result[name] = KNOWN[name].replaced(float(value), GIVEN)
        else:
            raise ArgumentError(
                f"limits[{name!r}] is {described(value)}, expected a finite number "
                f"[{KNOWN[name].unit}], a Limit, or None to take it out"
            )
    for name in POSITIVE & result.keys():
        given = result[name]
        if given is not None and given.value <= 0.0:
            raise ArgumentError(f"limits[{name!r}] is {given.value:g}, expected more than 0")
    ends = [{**LIMITS, **result}[f"half_critical_{end}"] for end in ("from", "to")]
    if None not in ends and ends[0].value >= ends[1].value:  # type: ignore[union-attr]
        raise ArgumentError(
            f"half_critical_from = {ends[0].value:g} is not below "  # type: ignore[union-attr]
            f"half_critical_to = {ends[1].value:g}"  # type: ignore[union-attr]
        )
    return result


def _fitting(name: str, given: Limit, known: Limit) -> Limit:
    """Return a limit whose unit and bound are those of the rule."""
    for field in ("unit", "bound"):
        if getattr(given, field) != getattr(known, field):
            raise ArgumentError(
                f"limits[{name!r}] has the {field} {getattr(given, field)!r}, expected "
                f"{getattr(known, field)!r}"
            )
    return given


def _of_line(line: LineData, analysis: Analysis | None) -> Analysis | None:
    """Return an analysis that is one of the line."""
    if analysis is None:
        return None
    if not isinstance(analysis, Analysis):
        raise ArgumentError(f"analysis is {described(analysis)}, expected what analyse() returns")
    if len(analysis.shape) != 1:
        raise ArgumentError("the analysis is of many designs, expected one of the line itself")
    if analysis.shafts != line.shaft_names or analysis.joints != line.joint_names:
        raise ArgumentError("the analysis is one of another line; make it of this one")
    return analysis
