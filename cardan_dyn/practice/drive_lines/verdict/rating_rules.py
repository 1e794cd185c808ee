"""Rating rules: design torque, ratings and lives of the joints of a drive line, judged."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from cardan_dyn.analytic import installation, shaft_design
from cardan_dyn.analytic.limits import DIN_808_FACTORS, LIMITS, Limit

from ....kit.arrays import NOTHING
from ....kit.units import HOUR
from ..line.parts import ShaftJoint
from .angle_rules import COARSE
from .case import Case, OperatingPoint
from .rows import FAIL, Inverse, VerdictRow, judged, opened, stated, withheld


def rating_rules(case: Case) -> Iterator[VerdictRow]:
    """Yield the rows about torques and lives of joints."""
    yield from _design_torque(case)
    yield from _static(case)
    for k in range(case.line.count):
        yield from _life(case, k)
        yield from _precision(case, k)
        yield from _efficiency(case, k)


def _design_torque(case: Case) -> Iterator[VerdictRow]:
    torque, at = case.strongest
    row = VerdictRow("design_torque", "", "shock torque T·K", unit="N m")
    if torque is None:
        yield opened(row, "give torque")
        return
    given = case.line.service_factor is not None
    power = "" if at.speed is None else f"{torque * at.speed:.4g} W"
    yield replace(
        row,
        value=torque * case.service_factor,
        condition=at.name,
        source="none: ratings of joints are held against it",
        note="; ".join(filter(None, [power, "" if given else "no service_factor: K = 1"])),
    )


def _static(case: Case) -> Iterator[VerdictRow]:
    line, torque = case.line, case.strongest[0]
    if torque is None:
        yield opened(VerdictRow("static_ratings", "", "torque"), "give torque")
        return
    for k, joint in enumerate(line.joints):
        found, nominal = case.joint_torque(k), torque * case.service_factor
        row = VerdictRow(
            "static_ratings",
            line.joint_names[k],
            "shock torque",
            value=found.size,
            unit="N m",
            rule_value=nominal,
            condition=found.condition,
            note=found.how,
            broken=_uneven(found.size, nominal),
        )
        limit = _rating(joint, "torque_limit", "T_CS")
        yield case.of_forces(row, limit, "give torque_limit of the joint (T_CS)")
        yield _fatigue(case, joint, row, min(found.ahead, found.back))


def _rating(joint: ShaftJoint, field: str, symbol: str) -> Limit | None:
    rating = getattr(joint, field)
    return None if rating is None else Limit(rating, "N m", f"{field} of the joint, {symbol}")


def _fatigue(case: Case, joint: ShaftJoint, row: VerdictRow, back: float) -> VerdictRow:
    """Return the row of the torque that a joint bears for ever.

    Between -a and b, a < b, the straight line between both ratings in Haigh's diagram bears
    a / T_DW + (b - a) / T_DSch = 1. It is told against that rating for which the torque is the
    nearer to the one that occurs: T_DSch, unless much of it reverses. As a mean torque never adds
    to the amplitude that is borne, T_DW is at least half of T_DSch: where it is not known, the
    whole swing a + b counts against this.

    Args:
        case: the case.
        joint: the joint.
        row: that of its greatest torque b, of whichever sense.
        back: greatest torque a of the other sense [N·m].
    """
    most = row.value or 0.0
    pulsating = _rating(joint, "pulsating_limit", "T_DSch")
    reversing = _rating(joint, "reversing_limit", "T_DW")
    steady = "shock torque, pulsating"
    if back <= NOTHING * most:
        held = replace(row, quantity=steady)
        return case.of_forces(held, pulsating, "give pulsating_limit of the joint (T_DSch)")
    row = replace(
        row,
        quantity="shock torque, reversing",
        note="; ".join(filter(None, [row.note, f"{back:.4g} N·m in the other sense"])),
    )
    missing = "give reversing_limit of the joint (T_DW)"
    if reversing is not None:
        share = 1.0 if pulsating is None else min(reversing.value / pulsating.value, 1.0)
        if pulsating is not None and share < 1.0 and back / share < most - back:
            held = replace(row, quantity=steady, value=back / share + most - back)
            return case.of_forces(held, pulsating, "")
        held = replace(row, value=back + (most - back) * share)
        return case.of_forces(held, reversing, "")
    if pulsating is None or most > pulsating.value:
        return case.of_forces(row, pulsating, missing)
    held = case.of_forces(replace(row, value=most + back), pulsating, "")
    if held.status == FAIL:
        return opened(held, f"{missing}; without it the whole swing counts")
    return held


def _uneven(torque: float, nominal: float) -> tuple[str, ...]:
    if abs(torque - nominal) <= COARSE * nominal:
        return ()
    if nominal == 0.0:
        return ("the rule takes the torque of the input shaft: here inertia alone acts",)
    return (
        "the rule takes the torque of the input shaft: joints and inertia make it "
        f"{100.0 * (torque / nominal - 1.0):+.1f} % in this joint",
    )


def _life(case: Case, k: int) -> Iterator[VerdictRow]:
    line, joint = case.line, case.line.joints[k]
    row = VerdictRow("joint_life", line.joint_names[k], "B10 life", unit="s")
    kinds = [kind for kind in ("rated_torque", "capacity") if getattr(joint, kind) is not None]
    points = [p for p in case.points if p.speed is not None and p.torque is not None]
    if joint.kind != "cross":
        yield stated(row, "the rule is that of joints with a cross; ask the maker of the joint")
        return
    duty = [point for point in points if not point.steady]
    if not kinds or not points:
        missing = "give speed and torque" if kinds else "give rated_torque or capacity of the joint"
        if line.life is None:
            missing = f"{missing}; give life of the line"
        # What a catalogue is searched for, before any rating is known.
        needed = [_needed(case, kind, k, duty or points) for kind in ("rated_torque", "capacity")]
        yield opened(replace(row, inverses=tuple(itertools.chain(*needed))), missing)
        return
    limit = None if line.life is None else Limit(line.life, "s", "life of the line", "least")

    def held(row: VerdictRow) -> VerdictRow:
        return withheld(judged(row, limit, "give life of the line"), case.no_forces)

    for kind in kinds:
        for point in points:
            if point.steady:
                steady = _steady_life(case, k, kind, point)
                # A duty cycle says better than one point what the joint has to live through.
                yield (
                    stated(steady, "the duty cycle is judged") if line.duty_cycle else held(steady)
                )
        if duty and any(point.speed for point in duty):
            yield held(_duty_life(case, k, kind, duty))
        elif duty:
            yield stated(replace(row, rule="duty_cycle"), "the duty cycle never turns")


def _occurring(case: Case, k: int, point: OperatingPoint) -> OperatingPoint:
    """Return an operating point with the torque that joint k is worn by instead of the given one.

    The rule's exponent 10/3 makes it: the mean over a turn of this power of the torque, with
    inertia. The rule means a torque that is steady on one side of a joint, whose other side it then
    varies on; so the steadier side counts.
    """
    turn = case.torques_over_a_turn(k, point)
    if turn is None:
        return point
    greatest = float(np.abs(turn).max())
    if not 0.0 < greatest < math.inf:
        return replace(point, torque=greatest)
    means = np.mean((np.abs(turn) / greatest) ** (10.0 / 3.0), axis=0)
    return replace(point, torque=greatest * float(means.min()) ** 0.3)


def _steady_life(case: Case, k: int, kind: str, point: OperatingPoint) -> VerdictRow:
    occurring = _occurring(case, k, point)
    torques = abs(occurring.torque or 0.0), abs(point.torque or 0.0)
    lives = [_life_at(case, k, kind, at) for at in (occurring, point)]
    note = "" if torques[0] == torques[1] else f"T_eq {torques[0]:.4g} N·m"
    return _row_of_life(case, k, kind, [point], lives, torques, note)


def _duty_life(case: Case, k: int, kind: str, duty: list[OperatingPoint]) -> VerdictRow:
    shares, speeds = [point.share for point in duty], [point.speed or 0.0 for point in duty]
    betas = [float(case.line.joint_angles[k])] * len(duty)
    lives, torques = [], []
    for points in ([_occurring(case, k, point) for point in duty], duty):
        of_points = [_life_at(case, k, kind, point) for point in points]
        lives.append(float(shaft_design.duty_cycle_life(shares, of_points)))
        sizes = [abs(point.torque or 0.0) for point in points]
        torques.append(float(shaft_design.equivalent_duty(shares, sizes, speeds, betas).torque))
    note, factor = f"T_eq {torques[0]:.4g} N·m", case.limit("mean_life_factor")
    if factor is not None:
        note = f"{note}; mean life {lives[0] * factor.value:.3g} h"
    return _row_of_life(case, k, kind, duty, lives, torques, note)


def _row_of_life(
    case: Case,
    k: int,
    kind: str,
    points: list[OperatingPoint],
    lives: Sequence[float],
    torques: Sequence[float],
    note: str,
) -> VerdictRow:
    """Return the row of a life at one point, or over a duty cycle.

    Args:
        case: the case.
        k: number of the joint, from 0.
        kind: of the rating.
        points: one that is steady, or all of the duty cycle.
        lives: with the torque that occurs, and by the rule [h].
        torques: that occur, and by the rule [N·m].
        note: of the row.
    """
    is_low = bool(case.line.joint_angles[k] < LIMITS["least_life_angle"].value)
    rule, at = ("joint_life", points[0].name) if points[0].steady else ("duty_cycle", "duty cycle")
    return VerdictRow(
        rule,
        case.line.joint_names[k],
        f"B10 life by {kind.replace('_', ' ')}",
        value=lives[0] * HOUR,
        unit="s",
        rule_value=lives[1] * HOUR,
        condition=at,
        inverses=_needed(case, kind, k, points),
        note="; ".join(filter(None, [note, "its angle counts as 3°" * is_low])),
        broken=_uneven(*torques),
    )


def _life_at(case: Case, k: int, kind: str, point: OperatingPoint) -> float:
    """Return the B10 life at a point [h]; infinite at rest or without torque."""
    torque, speed = abs(point.torque or 0.0), point.speed or 0.0
    if torque == 0.0 or speed == 0.0:
        return math.inf
    is_torque = kind == "rated_torque"
    life = shaft_design.joint_life if is_torque else shaft_design.joint_life_from_capacity
    rating, beta = getattr(case.line.joints[k], kind), float(case.line.joint_angles[k])
    return float(life(speed, beta, torque, rating, case.service_factor))


def _needed(case: Case, kind: str, k: int, points: list[OperatingPoint]) -> tuple[Inverse, ...]:
    """Return the rating that gives joint k the life that is asked for."""
    life, beta = case.line.life, float(case.line.joint_angles[k])
    turning = [_occurring(case, k, point) for point in points if point.speed]
    loads = [point for point in turning if point.torque]
    if life is None or not loads:
        return ()
    # Damage adds up, and goes with T_D to the power of -10/3, with L_C to that of -1.
    rating_for, exponent, what, unit = (
        (shaft_design.required_rated_torque, 10.0 / 3.0, "required T_D", "N m")
        if kind == "rated_torque"
        else (shaft_design.required_capacity, 1.0, "required L_C", "1")
    )
    needed = [
        rating_for(abs(p.torque or 0), p.speed or 0, beta, life / HOUR, case.service_factor)
        for p in loads
    ]
    damage = np.array([p.share for p in loads]) @ np.float_power(needed, exponent)
    return (Inverse(what, float(damage ** (1.0 / exponent)), unit),)


def _precision(case: Case, k: int) -> Iterator[VerdictRow]:
    joint, beta = case.line.joints[k], float(case.line.joint_angles[k])
    if not joint.din_808:
        return
    (speed, at), torque = case.fastest, case.strongest[0]
    row = VerdictRow("precision_joint", case.line.joint_names[k], "speed")
    if speed is None:
        yield opened(row, "give speed")
    else:
        held = replace(row, value=speed, unit="rad/s", condition=at.name)
        yield case.held(held, f"din_808_{joint.din_808}_speed")
    row = replace(row, quantity="torque T·k", unit="N m")
    factors = DIN_808_FACTORS[joint.din_808]
    if torque is None:
        yield opened(row, "give torque")
        return
    if math.degrees(beta) > max(factors):
        reason = f"its angle exceeds the {max(factors):g}° of the table"
        yield opened(row, f"{reason}; ask the maker of the joint")
        return
    # What the angle makes of the torque behind the joint is in the factor.
    found = case.driving_torque(k)
    factor = float(shaft_design.precision_joint_factor(beta, factors))
    row = replace(
        row,
        value=factor * found.size,
        rule_value=float(shaft_design.precision_joint_torque(torque, beta, factors)),
        condition=found.condition,
        note="; ".join(filter(None, [found.how, f"k = {factor:.3g}"])),
    )
    rated = joint.table_torque
    limit = None if rated is None else Limit(rated, "N m", "table_torque of the joint")
    yield case.of_forces(row, limit, "give table_torque of the joint")


def _efficiency(case: Case, k: int) -> Iterator[VerdictRow]:
    joint, beta = case.line.joints[k], float(case.line.joint_angles[k])
    if joint.pin_radius is None or joint.pin_friction is None or not joint.cross_span:
        return
    arm = joint.cross_span / 2.0
    yield VerdictRow(
        "efficiency",
        case.line.joint_names[k],
        "efficiency",
        value=float(installation.joint_efficiency(beta, joint.pin_friction, joint.pin_radius, arm)),
        source="none",
        broken=("for small angles: the loss is 2 % too small at 15°, 8 % at 30°",)
        if beta > math.radians(15.0)
        else (),
        note="half the cross_span counts as the arm of the pin bearings",
    )
