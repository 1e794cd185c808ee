"""Verdict case: a line, its operating points, limits and forces, as rules ask for them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from numbers import Real
from types import MappingProxyType

import numpy as np

from analytic.limits import CRITICAL_CONSTANTS, LIMITS, Limit

from ..arrays import Array
from ..checks import described, mapping
from ..errors import ArgumentError, CardanError, choices
from .analysis import Analysis
from .forces import LineForces
from .line_data import LineData

GIVEN = "the caller"
"""Source of a limit that is given as a number."""
OWN: Mapping[str, Limit] = MappingProxyType(
    {
        "torsional_distance": Limit(0.2, "1", "no published one", "least"),
        "critical_constant": CRITICAL_CONSTANTS["steel"],
    }
)
"""Names that `limits` may give besides those of `analytic.limits.LIMITS`: the distance of speeds
from torsional critical ones, relative to these, and a maker's constant of bending speeds."""
USED = frozenset(
    {
        *("residual_angle", "non_uniformity", "joint_angle", "angle_difference", "pto_angle"),
        *("torsional_acceleration", "torsional_acceleration_greatest"),
        *("inertia_acceleration", "inertia_acceleration_greatest"),
        *("bending_speed_share", "bending_speed_share_industrial"),
        *("bending_speed_share_automotive", "second_order_angle"),
        *("half_critical_from", "half_critical_to", "mean_life_factor"),
        *("balancing_speed", "balance_grade_maker"),
        *("telescope_travel_left", "telescope_overlap"),
        *("din_808_plain_speed", "din_808_needle_speed"),
    }
)
"""Names of `analytic.limits.LIMITS` by which the verdict goes; others decide no row."""
POSITIVE = frozenset({"mean_life_factor", "balance_grade_maker", "critical_constant"})
"""Names of what rules divide by."""
_FOR = {
    "vehicle": {
        "joint_angle",
        "angle_difference",
        "bending_speed_share_automotive",
    },
    "agricultural": {"pto_angle", "telescope_travel_left", "telescope_overlap"},
    "industrial": {"bending_speed_share_industrial"},
}
"""Limits that hold for one application alone, unless the caller gives them."""


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


@dataclass(frozen=True)
class Forces:
    """Forces of a line at an operating point; see `LineForces`.

    Attributes:
        point: the operating point.
        total: with inertia.
    """

    point: OperatingPoint
    total: LineForces


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
        analyse: Callable[[], Analysis],
    ) -> None:
        """Take a line.

        Args:
            line: the line.
            limits: see `DriveLine.verdict`.
            analysis: likewise.
            analyse: analyses the line at 1 rad/s and 1 N·m.

        Raises:
            ArgumentError: a limit is unknown or none, or the analysis is not one of the line.
        """
        self.line = line
        self._limits = _checked(limits)
        self.given = frozenset(self._limits)
        self._analysis = _of_line(line, analysis)
        self._analyse = analyse
        self.points = _points(line, self._analysis)

    def limit(self, name: str) -> Limit | None:
        """Return a limit; None if the caller has taken it out, or it does not hold for the line."""
        if name in self._limits:
            return self._limits[name]
        of = [kind for kind, names in _FOR.items() if name in names]
        if of and self.line.application not in of:
            return None
        return LIMITS.get(name)

    def why_not(self, name: str) -> str:
        """Return why there is no limit of a name."""
        if name in self._limits:
            return f"limits take {name} out"
        of = [kind for kind, names in _FOR.items() if name in names]
        if of:
            return f"a limit of {of[0]} lines; give application = {of[0]!r}, or limits[{name!r}]"
        return f"give limits[{name!r}]"

    @property
    def critical_constant(self) -> Limit | None:
        """Constant of bending speeds that the caller gave; None for the beam itself."""
        return self._limits.get("critical_constant")

    @property
    def service_factor(self) -> float:
        """K, 1 unless given."""
        return 1.0 if self.line.service_factor is None else self.line.service_factor

    @cached_property
    def fastest(self) -> OperatingPoint | None:
        """Operating point of the greatest speed."""
        known = [point for point in self.points if point.speed is not None]
        return max(known, key=lambda point: point.speed or 0.0, default=None)

    @cached_property
    def strongest(self) -> OperatingPoint | None:
        """Operating point of the greatest torque."""
        known = [point for point in self.points if point.torque is not None]
        return max(known, key=lambda point: abs(point.torque or 0.0), default=None)

    @cached_property
    def unit(self) -> Analysis | None:
        """Analysis at 1 rad/s and 1 N·m, or the one that was given; None if there is none."""
        if self._analysis is not None:
            return self._analysis
        try:
            return self._analyse()
        except CardanError as error:
            self._reason = str(error)
            return None

    @cached_property
    def forces(self) -> tuple[Forces, ...]:
        """Forces at all operating points whose torque is known."""
        found = self.unit
        if found is None:
            return ()
        if self._analysis is not None:
            return (Forces(self.points[0], self._analysis.total),)
        result = []
        for point in self.points:
            if point.torque is None or (found.inertial is not None and point.speed is None):
                continue
            total = found.static.times(np.array(point.torque))
            if found.inertial is not None:
                # Inertia forces of a steady drive grow with the square of its speed.
                total = total.plus(found.inertial.times(np.array((point.speed or 0.0) ** 2)))
            result.append(Forces(point, total))
        return tuple(result)

    @property
    def no_forces(self) -> str:
        """Why there are no forces; empty if there are some."""
        if self.forces:
            return ""
        if self.unit is None:
            return self._reason
        return "give speed and torque" if self.unit.inertial is not None else "give torque"

    def worst(self, pick: Callable[[LineForces], Array]) -> tuple[Array, list[OperatingPoint]]:
        """Return the greatest sizes of a quantity `(k,)`, and the operating points they are at.

        Args:
            pick: takes the quantity `(P, k)` of all positions from forces.
        """
        sizes = np.array([np.abs(pick(item.total)).max(axis=0) for item in self.forces])
        return sizes.max(axis=0), [self.forces[i].point for i in sizes.argmax(axis=0)]


def _points(line: LineData, analysis: Analysis | None) -> tuple[OperatingPoint, ...]:
    """Return all operating points."""
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
    """Return the limits that the caller gave.

    Raises:
        ArgumentError: one is unknown, or none.
    """
    result: dict[str, Limit | None] = {}
    for name, value in mapping("limits", limits).items():
        known = {**{key: LIMITS[key] for key in USED}, **OWN}
        if name not in known:
            listed = choices(known, name, most=len(known))
            raise ArgumentError(f"{name!r} is no limit of the verdict; limits: {listed}")
        if value is None:
            result[name] = value
        elif isinstance(value, Limit):
            result[name] = _fitting(name, value, known[name])
        elif name == "critical_constant" and isinstance(value, str):
            if value not in CRITICAL_CONSTANTS:
                raise ArgumentError(
                    f"critical_constant {value!r} is unknown; constants: "
                    f"{choices(CRITICAL_CONSTANTS, value)}"
                )
            result[name] = CRITICAL_CONSTANTS[value]
        elif _is_number(value):
            result[name] = known[name].replaced(float(value), GIVEN)
        else:
            raise ArgumentError(
                f"limits[{name!r}] is {described(value)}, expected a finite number "
                f"[{known[name].unit}], a Limit, or None to take it out"
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
    """Return a limit whose unit and bound are those of the rule.

    Raises:
        ArgumentError: they are others.
    """
    for field in ("unit", "bound"):
        if getattr(given, field) != getattr(known, field):
            raise ArgumentError(
                f"limits[{name!r}] has the {field} {getattr(given, field)!r}, expected "
                f"{getattr(known, field)!r}"
            )
    return given


def _is_number(value: object) -> bool:
    return not isinstance(value, bool) and isinstance(value, Real) and math.isfinite(value)


def _of_line(line: LineData, analysis: Analysis | None) -> Analysis | None:
    """Return an analysis that is one of the line.

    Raises:
        ArgumentError: it is none, of another line or of many designs.
    """
    if analysis is None:
        return None
    if not isinstance(analysis, Analysis):
        raise ArgumentError(f"analysis is {described(analysis)}, expected what analyse() returns")
    if len(analysis.shape) != 1:
        raise ArgumentError("the analysis is of many designs, expected one of the line itself")
    if analysis.shafts != line.shaft_names or analysis.joints != line.joint_names:
        raise ArgumentError("the analysis is one of another line; make it of this one")
    return analysis
