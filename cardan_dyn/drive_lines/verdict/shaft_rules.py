"""Shaft rules: stress, critical speeds, lengths and balance of the shafts of a line, judged."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from cardan_dyn.analytic import bending_speed, installation, shaft_design, torsional_speed
from cardan_dyn.analytic.limits import Limit

from ...errors import ModelError
from ..line.geometry import centring_places
from ..line.parts import Shaft
from ..line.supports import Support, supports
from .case import Case
from .rows import FAIL, Inverse, VerdictRow, judged, not_judged, withheld

_STEEL = (2.1e11, 7850.0)
"""Modulus and density of the makers' constants [Pa, kg/m³]."""


def shaft_rules(case: Case) -> Iterator[VerdictRow]:
    """Yield the rows about shafts."""
    for k in range(case.line.count + 1):
        yield from _tube(case, k)
    critical = _critical(case)
    yield from _bending_speed(case, critical)
    for k in range(1, case.line.count):
        yield from _lengths(case, k)
    yield from _torsional_speed(case)
    for k in range(1, case.line.count):
        yield from _balance(case, k, critical)


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
    nominal = abs(strongest.torque) * case.service_factor
    torque, condition, how = nominal, strongest.name, ""
    if case.forces:
        sizes, cases = case.worst("torsion_in" if k < line.count else "torsion_out")
        index = min(k, line.count - 1)
        torque, condition, how = float(sizes[index]), cases[index].point.name, cases[index].how
    stress = [
        float(shaft_design.shear_stress(size, *_diameters(line.shafts[k])))
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
        note=how,
    )
    allowed = section.shear_limit
    if allowed is not None:
        row = replace(
            row,
            inverses=(Inverse("allowed torque T·K", torque * allowed / stress[0], "N m"),)
            if stress[0]
            else (),
        )
    limit = None if allowed is None else Limit(allowed, "Pa", "shear_limit of the tube")
    yield judged(row, limit, "give shear_limit of the tube")


def _diameters(shaft: Shaft) -> tuple[float, float]:
    section = shaft.tube
    return (0.0, 0.0) if section is None else (section.outer_diameter, section.inner_diameter)


def _span(case: Case, k: int) -> float:
    """Return the longest free length of a shaft between its joints and bearings [m].

    A bearing of the shaft stands for the joint at its rear.
    """
    places = sorted(item.distance for item in case.line.shafts[k].bearings)
    return float(max(np.diff([0.0, *places]), default=case.line.geometry.lengths[k]))


class _Critical(NamedTuple):
    """Critical bending speed of a line.

    Attributes:
        speed: [rad/s]; by the maker's constant if the caller gave one.
        shaft: that bends or moves most.
        by_rule: of that shaft alone, on rigid supports [rad/s].
        span: free length of that shaft [m].
        single: whether the line is one shaft on rigid supports, so that the rule is exact.
        soft: names of centre bearings whose stiffness is not known.
    """

    speed: float
    shaft: int
    by_rule: float
    span: float
    single: bool
    soft: tuple[str, ...]


def _critical(case: Case) -> _Critical | str:
    """Return the critical bending speed of a line; in words why there is none."""
    line, lengths = case.line, case.line.geometry.lengths
    inner = [k for k in range(1, line.count) if line.shafts[k].centring is None]
    if not inner:
        return "there is no shaft between joints"
    lacking = [line.shaft_names[k] for k in inner if line.shafts[k].tube is None]
    if lacking:
        return f"give tube of {', '.join(lacking)}"
    sections = [section for k in inner if (section := line.shafts[k].tube) is not None]
    heavy = [
        (section.density * section.area if (mass := line.shafts[k].mass) is None else mass / length)
        for k, section, length in zip(inner, sections, lengths[inner], strict=True)
    ]
    if not min(heavy) > 0.0:
        return "give mass of all shafts, or none to count with that of their tubes"
    ends = [_end_stiffness(line.shafts[0]), _end_stiffness(line.shafts[-1])]
    # E A i² with the radius of gyration i² = (D² + d²) / 16.
    rigidities = [
        s.modulus * s.area * (s.outer_diameter**2 + s.inner_diameter**2) / 16.0 for s in sections
    ]
    names = iter(item.name for item in _bearings(case))
    soft, bearings = [], []
    for k, shaft in enumerate(line.shafts):
        for item in shaft.bearings:
            name = next(names, "")
            if k in inner:
                stiffness = np.inf if item.stiffness is None else item.stiffness
                soft += [name] if item.stiffness is None else []
                place = item.distance + _extensions(case, k)[0]
                bearings.append(bending_speed.LineBearing(inner.index(k), place, stiffness))
    rigid = bool(np.isinf(ends).all())
    single = len(inner) == 1 and not bearings and rigid and not line.centred
    if single:
        # The beam itself, without the elements' last digits.
        found = float(np.sqrt(rigidities[0] / heavy[0]) * (np.pi / lengths[inner[0]]) ** 2)
        at = inner[0]
    else:
        try:
            bending = bending_speed.line_bending(
                [lengths[k] + sum(_extensions(case, k)) for k in inner],
                rigidities,
                heavy,
                _joint_masses(case),
                ends,
                bearings,
            )
        except ValueError as error:
            return str(error)
        found, at = bending.speed, inner[int(np.argmax(bending.shares))]
    span = _span(case, at)
    section = sections[inner.index(at)]
    both, material = _diameters(line.shafts[at]), (section.modulus, section.density)
    by_rule = float(shaft_design.critical_speed(*both, span, *material))
    constant = case.critical_constant
    if constant is not None:
        by_maker = float(bending_speed.critical_speed_by_constant(*both, span, constant.value))
        found, by_rule = found * by_maker / by_rule, by_maker
    return _Critical(found, at, by_rule, span, single, tuple(soft))


def _bearings(case: Case) -> tuple[Support, ...]:
    """Return the bearings of a line; none if they do not hold it."""
    try:
        return supports(case.line).bearings
    except ModelError:
        return ()


def _end_stiffness(shaft: Shaft) -> float:
    """Return the stiffness of an end shaft's bearings at its joint [N/m]; the shaft is rigid."""
    held = sorted(shaft.bearings, key=lambda item: item.distance)[:2]
    levers = [1.0]
    if len(held) == 2:
        lever = held[0].distance / (held[1].distance - held[0].distance)
        levers = [1.0 + lever, lever]
    give = sum(
        lever**2 / item.stiffness
        for lever, item in zip(levers, held, strict=False)
        if item.stiffness is not None
    )
    return 1.0 / give if give else np.inf


def _extensions(case: Case, k: int) -> tuple[float, float]:
    """Return by how much a shaft as a beam goes on to the centrings at its front and rear [m]."""
    places = {
        at: centring_places(case.line.shafts, case.line.geometry, at)
        for at in (k - 1, k + 1)
        if case.line.shafts[at].centring is not None
    }
    return places.get(k - 1, (0.0, 0.0))[1], places.get(k + 1, (0.0, 0.0))[0]


def _joint_masses(case: Case) -> list[float]:
    """Return the masses at the ends of beams [kg]; that of a coupling piece is with its joints."""
    line = case.line
    result = [joint.cross_mass for joint in line.joints]
    for k in range(line.count - 1, 0, -1):
        if line.shafts[k].centring is not None:
            result[k - 1 : k + 1] = [sum(result[k - 1 : k + 1]) + (line.shafts[k].mass or 0.0)]
    return result


def _bending_speed(case: Case, found: _Critical | str) -> Iterator[VerdictRow]:
    fastest, line = case.fastest, case.line
    quantity = "share of the critical speed"
    if line.count == 1:
        return
    if isinstance(found, str) or fastest is None or fastest.speed is None:
        reason = found if isinstance(found, str) else "give speed"
        yield not_judged("bending_speed", "", quantity, reason)
        return
    name = {
        "industrial": "bending_speed_share_industrial",
        "vehicle": "bending_speed_share_automotive",
    }.get(line.application, "bending_speed_share")
    name = "bending_speed_share" if "bending_speed_share" in case.given else name
    limit = case.limit(name)
    row = VerdictRow(
        rule="bending_speed",
        where=line.shaft_names[found.shaft],
        quantity=quantity,
        value=fastest.speed / found.speed,
        rule_value=fastest.speed / found.by_rule,
        condition=fastest.name,
        broken=_not_a_beam(case, found),
        inverses=_greatest_length(case, found, limit),
        note=_critical_text(case, found),
    )
    yield _unless_soft(judged(row, limit, case.why_not(name)), found)
    for half in _half_critical(case, found):
        yield _unless_soft(half, found)


def _unless_soft(row: VerdictRow, found: _Critical) -> VerdictRow:
    """Return the row of a line, which passes nothing while a bearing's stiffness is unknown."""
    if not found.soft:
        return row
    return withheld(
        row,
        f"give stiffness of {', '.join(found.soft)}, across the shaft and with its bracket; the "
        "value is that of rigid ones, which soft ones exceed",
    )


def _critical_text(case: Case, found: _Critical) -> str:
    constant = case.critical_constant
    by = "" if constant is None else f" by {constant.source}"
    rpm = found.speed * 30.0 / np.pi
    of = f"free length {found.span * 1e3:.0f} mm"
    if not found.single:
        of = "of all shafts together with joints and bearings"
    return f"critical speed {rpm:.0f} 1/min{by}, {of}"


def _greatest_length(case: Case, found: _Critical, limit: Limit | None) -> tuple[Inverse, ...]:
    """Return the greatest free length of a shaft on rigid supports."""
    fastest = case.fastest
    if limit is None or limit.value <= 0.0 or fastest is None or not fastest.speed:
        return ()
    if not found.single:
        return ()
    outer, inner = _diameters(case.line.shafts[found.shaft])
    # The beam or the constant that was used, in the form of the makers.
    maker = found.speed * found.span**2 / np.hypot(outer, inner)
    length = bending_speed.greatest_length(outer, inner, fastest.speed, maker, limit.value)
    return (Inverse("greatest free length", float(length), "m"),)


def _not_a_beam(case: Case, found: _Critical) -> tuple[str, ...]:
    section = case.line.shafts[found.shaft].tube
    broken = []
    if not found.single:
        broken.append(
            "one shaft on rigid supports close to its joints: the value counts with all shafts, "
            "joints and bearings"
        )
    constant = case.critical_constant
    material = None if section is None else (section.modulus, section.density)
    if constant is not None and material != _STEEL:
        broken.append("steel: the tube is of another material than the maker's constant")
    return tuple(broken)


def _half_critical(case: Case, found: _Critical) -> Iterator[VerdictRow]:
    line, where, critical = case.line, case.line.shaft_names[found.shaft], found.speed
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
    bends = float(max(line.uneven_angles))
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
        if case.is_heavy
        else (),
        note=f"natural frequency {frequency / (2 * np.pi):.4g} Hz, nearest: {nearest}",
    )
    yield judged(row, case.limit("torsional_distance"), case.why_not("torsional_distance"))
    yield _zone(case, frequency, ends[1] / (ends[0] + ends[1]))


def _zone(case: Case, frequency: float, share: float) -> VerdictRow:
    """Return the row of the first zone of parametric instability."""
    beta = float(max(case.line.uneven_angles))
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


def _balance(case: Case, k: int, critical: _Critical | str) -> Iterator[VerdictRow]:
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
        broken=_not_rigid(case, critical),
    )


def _not_rigid(case: Case, critical: _Critical | str) -> tuple[str, ...]:
    """Return that a line runs so close to its critical speed that it bends."""
    fastest = case.fastest
    if isinstance(critical, str) or fastest is None or not fastest.speed:
        return ()
    if fastest.speed <= critical.speed / 2.0:
        return ()
    return ("well below the critical speed: it runs above half of it",)
