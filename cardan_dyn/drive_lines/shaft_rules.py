"""Shaft rules: stress, critical speeds, lengths and balance of the shafts of a line, judged."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from analytic import bending_speed, installation, shaft_design, torsional_speed, tube
from analytic.limits import Limit

from .parts import Shaft
from .verdict_case import Case
from .verdict_rows import FAIL, Inverse, VerdictRow, judged, not_judged

_STEEL = (2.1e11, 7850.0)
"""Modulus and density of the makers' constants [Pa, kg/m³]."""
_SHORT_OVERHANG = 0.1
"""Overhang of a tube beyond its centre bearing, relative to its span, that still is close."""


def shaft_rules(case: Case) -> Iterator[VerdictRow]:
    """Yield the rows about shafts."""
    for k in range(case.line.count + 1):
        yield from _tube(case, k)
    for k in range(1, case.line.count):
        yield from _bending_speed(case, k)
        yield from _lengths(case, k)
    yield from _torsional_speed(case)
    for k in range(1, case.line.count):
        yield from _balance(case, k)


def _tube(case: Case, k: int) -> Iterator[VerdictRow]:
    line, where = case.line, case.line.shaft_names[k]
    section = line.shafts[k].tube
    if section is None:
        if 0 < k < line.count:
            yield not_judged("tube", where, "shear stress", f"give tube of {where}")
        return
    strongest = case.strongest
    if strongest is None or strongest.torque is None:
        yield not_judged("tube", where, "shear stress", "give torque")
        return
    nominal, torque, condition = abs(strongest.torque), abs(strongest.torque), strongest.name
    if case.forces:
        sizes, points = case.worst(
            lambda item: item.torsion_in if k < line.count else item.torsion_out
        )
        index = min(k, line.count - 1)
        torque, condition = float(sizes[index]), points[index].name
    stress = [
        float(tube.shear_stress(size * case.service_factor, *_diameters(line.shafts[k])))
        for size in (torque, nominal)
    ]
    row = VerdictRow(
        rule="tube",
        where=where,
        quantity="shear stress under T·K",
        value=stress[0],
        unit="Pa",
        rule_value=stress[1],
        condition=condition,
    )
    allowed = section.shear_limit
    if allowed is not None:
        row = replace(
            row,
            inverses=(
                Inverse(
                    "allowed torque T·K", torque * case.service_factor * allowed / stress[0], "N m"
                ),
            )
            if stress[0]
            else (),
        )
    limit = None if allowed is None else Limit(allowed, "Pa", "shear_limit of the tube")
    yield judged(row, limit, "give shear_limit of the tube")


def _diameters(shaft: Shaft) -> tuple[float, float]:
    section = shaft.tube
    return (0.0, 0.0) if section is None else (section.outer_diameter, section.inner_diameter)


def _span(case: Case, k: int) -> tuple[float, float, float | None]:
    """Return the longest free length of a shaft, its overhang, and the softest bearing's stiffness.

    Both ends are supports, unless a bearing of the shaft stands for the joint at its rear.
    """
    length = float(case.line.geometry.lengths[k])
    bearings = sorted(case.line.shafts[k].bearings, key=lambda item: item.distance)
    if not bearings:
        return length, 0.0, None
    places = [0.0, *(item.distance for item in bearings)]
    soft = [item.stiffness for item in bearings if item.stiffness is not None]
    return max(np.diff(places)), length - places[-1], min(soft, default=None)


def _bending_speed(case: Case, k: int) -> Iterator[VerdictRow]:
    line, where, fastest = case.line, case.line.shaft_names[k], case.fastest
    shaft = line.shafts[k]
    if shaft.tube is None or fastest is None or fastest.speed is None:
        missing = f"tube of {where}" if shaft.tube is None else "speed"
        yield not_judged("bending_speed", where, "share of the critical speed", f"give {missing}")
        return
    span, overhang, stiffness = _span(case, k)
    both = _diameters(shaft)
    material = shaft.tube.modulus, shaft.tube.density
    rigid = float(shaft_design.critical_speed(*both, span, *material))
    exact = rigid
    if stiffness is not None:
        exact = float(bending_speed.on_elastic_bearing(*both, span, stiffness, *material))
    constant = case.critical_constant
    by_rule = rigid
    if constant is not None:
        by_rule = float(bending_speed.critical_speed_by_constant(*both, span, constant.value))
    name = {
        "industrial": "bending_speed_share_industrial",
        "vehicle": "bending_speed_share_automotive",
    }.get(line.application, "bending_speed_share")
    name = "bending_speed_share" if "bending_speed_share" in case.given else name
    limit = case.limit(name)
    used = exact if constant is None or stiffness is not None else by_rule
    row = VerdictRow(
        rule="bending_speed",
        where=where,
        quantity="share of the critical speed",
        value=fastest.speed / used,
        rule_value=fastest.speed / by_rule,
        condition=fastest.name,
        broken=_not_a_beam(case, k, overhang / span, stiffness),
        inverses=_greatest_length(case, k, used * span**2, limit),
        note=_critical_text(used, span, constant),
    )
    yield judged(row, limit, case.why_not(name))
    yield from _half_critical(case, k, used)


def _critical_text(critical: float, span: float, constant: Limit | None) -> str:
    by = "" if constant is None else f" by {constant.source}"
    rpm = critical * 30.0 / np.pi
    return f"critical speed {rpm:.0f} 1/min{by}, free length {span * 1e3:.0f} mm"


def _greatest_length(
    case: Case, k: int, constant: float, limit: Limit | None
) -> tuple[Inverse, ...]:
    """Return the greatest free length of a shaft on rigid supports."""
    fastest = case.fastest
    soft = any(item.stiffness is not None for item in case.line.shafts[k].bearings)
    if limit is None or limit.value <= 0.0 or fastest is None or not fastest.speed or soft:
        return ()
    outer, inner = _diameters(case.line.shafts[k])
    # The beam or the constant that was used, in the form of the makers.
    maker = constant / np.hypot(outer, inner)
    length = bending_speed.greatest_length(outer, inner, fastest.speed, maker, limit.value)
    return (Inverse("greatest free length", float(length), "m"),)


def _not_a_beam(case: Case, k: int, overhang: float, stiffness: float | None) -> tuple[str, ...]:
    section = case.line.shafts[k].tube
    broken = []
    if stiffness is not None:
        broken.append("rigid supports: the centre bearing is elastic, which the value counts with")
    if overhang > _SHORT_OVERHANG:
        broken.append(
            f"supports close to the joints: the tube goes on {100 * overhang:.0f} % of its free "
            "length beyond its bearing and carries a joint there, which lowers the critical speed"
        )
    constant = case.critical_constant
    material = None if section is None else (section.modulus, section.density)
    if constant is not None and material != _STEEL:
        broken.append("steel: the tube is of another material than the maker's constant")
    return tuple(broken)


def _half_critical(case: Case, k: int, critical: float) -> Iterator[VerdictRow]:
    line, where = case.line, case.line.shaft_names[k]
    low, high = case.limit("half_critical_from"), case.limit("half_critical_to")
    angle = case.limit("second_order_angle")
    quantity = "distance from half the critical speed"
    if low is None or high is None:
        reason = case.why_not("half_critical_from" if low is None else "half_critical_to")
        yield not_judged("bending_speed", where, quantity, reason)
        return
    middle, half = (low.value + high.value) / 2.0, (high.value - low.value) / 2.0
    points = [point for point in case.points if point.speed is not None]
    distances = [abs((point.speed or 0.0) / critical - middle) for point in points]
    worst = int(np.argmin(distances))
    both = high.source if low.source in high.source else f"{low.source}; {high.source}"
    bound = Limit(half, "1", both, "least")
    row = VerdictRow(
        rule="bending_speed",
        where=where,
        quantity=quantity,
        value=distances[worst],
        condition=points[worst].name,
        inverses=(
            Inverse("zone from", low.value * critical, "rad/s"),
            Inverse("zone to", high.value * critical, "rad/s"),
        ),
    )
    bends = max(float(line.joint_angles[k - 1]), float(line.joint_angles[k]))
    if angle is not None and bends < angle.value:
        shown = f"joint angles below {np.degrees(angle.value):.3g}° excite no second order"
        yield judged(row, None, shown)
        return
    yield judged(row, bound)


def _torsional_speed(case: Case) -> Iterator[VerdictRow]:
    line, fastest = case.line, case.fastest
    quantity = "distance from a torsional critical speed"
    ends = [line.shafts[end].inertia or 0.0 for end in (0, -1)]
    names = [name for name, inertia in zip(("input", "output"), ends, strict=True) if not inertia]
    soft = _stiffness(case)
    missing = [f"inertia of the {name} shaft" for name in names]
    missing += [] if soft is not None else ["tube or torsional_stiffness of intermediate shafts"]
    missing += [] if fastest is not None else ["speed"]
    if missing or soft is None or fastest is None:
        yield not_judged("torsional_speed", "", quantity, "give " + ", ".join(missing))
        return
    frequency = float(torsional_speed.two_inertia_frequency(ends[0], ends[1], soft))
    orders = torsional_speed.critical_speeds(frequency)
    critical = {
        "order 2": float(orders.order_2),
        "order 4": float(orders.order_4),
        "parametric": frequency,
    }
    points = [point for point in case.points if point.speed is not None]
    found = [
        (abs((point.speed or 0.0) / speed - 1.0), name, point)
        for point in points
        for name, speed in critical.items()
    ]
    distance, nearest, point = min(found, key=lambda item: item[0])
    row = VerdictRow(
        rule="torsional_speed",
        where="",
        quantity=quantity,
        value=distance,
        condition=point.name,
        inverses=tuple(Inverse(name, speed, "rad/s") for name, speed in critical.items()),
        broken=("two inertias alone: shafts and joints between them are taken as massless",)
        if case.unit is not None and case.unit.inertial is not None
        else (),
        note=f"natural frequency {frequency / (2 * np.pi):.4g} Hz, nearest: {nearest}",
    )
    yield judged(row, case.limit("torsional_distance"), case.why_not("torsional_distance"))
    yield _zone(case, frequency, ends[1] / (ends[0] + ends[1]))


def _zone(case: Case, frequency: float, share: float) -> VerdictRow:
    """Return the row of the first zone of parametric instability."""
    beta = float(max(case.line.joint_angles))
    zone = torsional_speed.parametric_zone(beta, share)
    low, high = float(zone.least) * frequency, float(zone.greatest) * frequency
    inside = [point for point in case.points if point.speed and low <= point.speed <= high]
    row = VerdictRow(
        rule="torsional_speed",
        where="",
        quantity="damping that closes the first parametric zone",
        value=float(zone.damping),
        condition=inside[0].name if inside else "",
        inverses=(Inverse("zone from", low, "rad/s"), Inverse("zone to", high, "rad/s")),
        broken=("of one joint with the spring in front of it: the greatest joint angle is taken",),
    )
    stated = judged(row, None)
    if not inside:
        return replace(stated, note="no operating point is in the zone")
    return replace(stated, status=FAIL, note="in the zone: damping has to exceed the value")


def _stiffness(case: Case) -> float | None:
    """Return the torsional stiffness of all intermediate shafts in a row [N·m/rad]."""
    soft = 0.0
    for shaft, length in zip(case.line.shafts[1:-1], case.line.geometry.lengths[1:-1], strict=True):
        if shaft.torsional_stiffness is not None:
            soft += 1.0 / shaft.torsional_stiffness
        elif shaft.tube is not None:
            soft += 1.0 / shaft.tube.torsional_stiffness(float(length))
        else:
            return None
    return 1.0 / soft if soft else None


def _lengths(case: Case, k: int) -> Iterator[VerdictRow]:
    line, where = case.line, case.line.shaft_names[k]
    spline, length = line.shafts[k].spline, float(line.geometry.lengths[k])
    if spline is None:
        return
    shortest = min(length, spline.shortest or length)
    longest = max(length, spline.longest or length)
    if spline.compressed is None:
        reason = f"give compressed of the spline of {where}"
        yield not_judged("lengths", where, "travel left when shortest", reason)
        return
    left = VerdictRow(
        rule="lengths",
        where=where,
        quantity="travel left when shortest",
        value=shortest - spline.compressed,
        unit="m",
        note="" if spline.shortest else "no shortest: the length of the shaft",
    )
    limit = case.limit("telescope_travel_left")
    yield judged(left, limit or Limit(0.0, "m", "the spline strikes", "least"))
    if spline.travel is not None:
        found = installation.operating_lengths(spline.compressed, spline.travel)
        row = VerdictRow(
            rule="lengths",
            where=where,
            quantity="length when longest",
            value=longest,
            unit="m",
            inverses=(Inverse("recommended length", float(found.recommended), "m"),),
        )
        yield judged(row, Limit(float(found.greatest), "m", "L_z + L_a of the spline"))
    if spline.profile is not None:
        parts_at = spline.compressed + spline.profile
        overlap = installation.telescope_margins(spline.compressed, parts_at, shortest, longest)
        row = VerdictRow(
            rule="lengths",
            where=where,
            quantity="overlap when longest",
            value=float(overlap.overlap),
            unit="m",
            note="" if spline.longest else "no longest: the length of the shaft",
        )
        limit = case.limit("telescope_overlap")
        yield judged(row, limit or Limit(0.0, "m", "the profiles part", "least"))


def _balance(case: Case, k: int) -> Iterator[VerdictRow]:
    line, where, fastest = case.line, case.line.shaft_names[k], case.fastest
    shaft, length = line.shafts[k], float(line.geometry.lengths[k])
    mass = shaft.mass
    if mass is None and shaft.tube is not None:
        mass = shaft.tube.area * length * shaft.tube.density
    grade = case.limit("balance_grade_maker")
    if fastest is None or not fastest.speed or not mass or grade is None:
        missing = "speed and mass or tube" if grade is not None else "limits['balance_grade_maker']"
        yield not_judged("balancing", where, "residual unbalance", f"give {missing}")
        return
    needed = case.limit("balancing_speed")
    text = ""
    if needed is not None:
        text = "needed" if fastest.speed > needed.value else "not needed"
        text = f"balancing {text}: limit {needed.value * 30 / np.pi:.0f} 1/min"
    yield VerdictRow(
        rule="balancing",
        where=where,
        quantity="allowed residual unbalance",
        value=float(installation.residual_unbalance(grade.value, mass, fastest.speed)),
        unit="kg m",
        condition=fastest.name,
        source=grade.source,
        note=text,
        broken=_not_rigid(case, k),
    )


def _not_rigid(case: Case, k: int) -> tuple[str, ...]:
    """Return that a shaft runs so close to its critical speed that it bends."""
    shaft, fastest = case.line.shafts[k], case.fastest
    if shaft.tube is None or fastest is None or not fastest.speed:
        return ()
    material = shaft.tube.modulus, shaft.tube.density
    critical = float(shaft_design.critical_speed(*_diameters(shaft), _span(case, k)[0], *material))
    if fastest.speed <= critical / 2.0:
        return ()
    return ("well below the critical speed: it runs above half of it",)
