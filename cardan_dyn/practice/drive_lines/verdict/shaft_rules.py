"""Shaft rules: stress, critical speeds, lengths and balance of the shafts of a line, judged."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from cardan_dyn.analytic import bending_speed, installation, shaft_design, torsional_speed
from cardan_dyn.analytic.limits import Limit

from ....kit.arrays import EPS, ROUNDED, Array
from ....kit.roots import zero
from ..line.closed_chain import cross_inertia, shaft_bodies
from ..line.data import LineData
from ..line.geometry import centring_places
from ..line.parts import Shaft, Tube
from ..line.supports import bearings_of
from .case import Case
from .rows import FAIL, Inverse, VerdictRow, judged, opened, stated, withheld


def shaft_rules(case: Case) -> Iterator[VerdictRow]:
    """Yield the rows about shafts."""
    for k in range(case.line.count + 1):
        yield from _tube(case, k)
    inner = _inner_beams(case)
    if any(shaft.centring is None for shaft in case.line.shafts[1:-1]):
        yield from _bending_speeds(case, inner)
    for k in (0, case.line.count):
        if case.line.shafts[k].tube is not None:
            yield from _bending_speeds(case, _end_beam(case, k), case.line.shaft_names[k])
    for k in range(1, case.line.count):
        yield from _lengths(case, k)
    yield from _torsional_speed(case)
    for k in range(1, case.line.count):
        yield from _balance(case, k, inner)


def _tube(case: Case, k: int) -> Iterator[VerdictRow]:
    line, torque = case.line, case.strongest[0]
    shaft, where = line.shafts[k], line.shaft_names[k]
    section = shaft.tube
    row = VerdictRow("tube", where, "shear stress up to T·K", unit="Pa")
    if section is None:
        if 0 < k < line.count and shaft.centring is None:
            yield opened(row, f"give tube of {where}")
        return
    if torque is None:
        yield opened(row, "give torque")
        return
    found, nominal = case.shaft_torque(k), torque * case.service_factor
    stress, by_rule = (
        float(shaft_design.shear_stress(size, *section.diameters)) for size in (found.size, nominal)
    )
    allowed = section.shear_limit
    row = replace(
        row,
        value=stress,
        rule_value=by_rule,
        condition=found.condition,
        note=found.how,
        inverses=(Inverse("allowed torque T·K", found.size * allowed / stress, "N m"),)
        if stress and allowed is not None
        else (),
    )
    limit = None if allowed is None else Limit(allowed, "Pa", "shear_limit of the tube")
    yield case.of_forces(row, limit, "give shear_limit of the tube")


def _span(case: Case, k: int) -> float:
    """Return the longest free length of a shaft between its joints and bearings [m].

    A bearing of the shaft stands for the joint at its rear.
    """
    places = sorted(item.distance for item in case.line.shafts[k].bearings)
    return float(max(np.diff([0.0, *places]), default=case.line.geometry.lengths[k]))


class _Critical(NamedTuple):
    """Critical speed at which a shaft bends.

    Attributes:
        shaft: its index.
        speed: [rad/s]; by the maker's constant if the caller gave one.
        by_rule: of that shaft alone, on rigid supports [rad/s].
        span: its free length [m].
    """

    shaft: int
    speed: float
    by_rule: float
    span: float


class _Beams:
    """Shafts that bend together, as beams on springs.

    Attributes:
        shafts: their indices.
        springs: names and stiffnesses of the bearings that give way [N/m].
        soft: names of the bearings whose stiffness is not known.
        single: whether they are one shaft on rigid supports, so that the rule is exact.
        found: their modes.
    """

    def __init__(
        self,
        case: Case,
        shafts: list[int],
        lengths: Sequence[float],
        joint_masses: list[float],
        ends: list[float],
        bearings: list[tuple[str, bending_speed.LineBearing]],
        soft: tuple[str, ...] = (),
    ) -> None:
        """Take shafts with tubes, and as `bending_speed.line_bending` does what carries them.

        Raises:
            ValueError: masses or bearings with which there are no modes, in words.
        """
        line = case.line
        self.case, self.shafts, self.soft = case, shafts, soft
        tubes = [tube for k in shafts if (tube := line.shafts[k].tube) is not None]
        heavy = [
            line.shafts[k].mass_at(length) / length
            for k, length in zip(shafts, line.geometry.lengths[shafts], strict=True)
        ]
        if not min(heavy) > 0.0:
            raise ValueError("give mass of all shafts, or none to count with that of their tubes")
        rigidities = [tube.modulus * tube.polar_moment / 2.0 for tube in tubes]

        def modes(give: float) -> bending_speed.LineBending:
            """Return the modes with springs that are so much softer; 0 makes them rigid."""
            scale = 1.0 / give if give else np.inf
            return bending_speed.line_bending(
                lengths,
                rigidities,
                heavy,
                joint_masses,
                [end * scale if end else 0.0 for end in ends],
                [item._replace(stiffness=item.stiffness * scale) for _, item in bearings],
            )

        self._tubes, self._modes, self.found = tubes, modes, modes(1.0)
        self.springs = {
            name: item.stiffness for name, item in bearings if np.isfinite(item.stiffness)
        }
        self.single = len(shafts) == 1 and not bearings and ends == [np.inf] * 2
        # The beam itself, without the elements' last digits.
        self._exact = float(np.sqrt(rigidities[0] / heavy[0]) * (np.pi / lengths[0]) ** 2)

    @property
    def bending(self) -> list[_Critical]:
        """Critical speed of each shaft: its lowest mode whose energy lies in tubes.

        It is one in which the shaft has a mean share of that energy at least.
        """
        found = []
        for index, (k, tube) in enumerate(zip(self.shafts, self._tubes, strict=True)):
            strain = self.found.strain
            part = strain[:, index] >= (1.0 - ROUNDED) * strain.mean(axis=1)
            at = np.argmax((strain.sum(axis=1) >= 0.5) & part)
            speed = self._exact if self.single else float(self.found.speeds[at])
            span = _span(self.case, k)
            material = (tube.modulus, tube.density)
            by_rule = float(shaft_design.critical_speed(*tube.diameters, span, *material))
            if constant := self.case.critical_constant:
                by_constant = bending_speed.critical_speed_by_constant
                maker = float(by_constant(*tube.diameters, span, constant.value))
                speed, by_rule = speed * maker / by_rule, maker
            found.append(_Critical(k, speed, by_rule, span))
        return found

    @property
    def bounce(self) -> tuple[float, int] | None:
        """Lowest speed [rad/s] whose energy lies in springs, and the shaft that moves most.

        None where shafts bend at lower ones.
        """
        in_tubes = self.found.strain.sum(axis=1) >= 0.5
        last = max(int(np.argmax(in_tubes & (part > 0.0))) for part in self.found.strain.T)
        at = int(np.argmin(in_tubes))
        if in_tubes[at] or at > last:
            return None
        return float(self.found.speeds[at]), self.shafts[int(np.argmax(self.found.kinetic[at]))]

    def stiffer(self, speed: float) -> tuple[Inverse, ...]:
        """Return the stiffnesses with which no critical speed is below one [rad/s], if any are."""

        def room(give: float) -> float:
            return self._modes(give).speed - speed

        if room(0.0) <= 0.0 or room(1.0) >= 0.0:
            return ()
        give = zero(room, 0.0, 1.0)
        return tuple(
            Inverse(f"stiffness of {name}", stiffness / give, "N/m")
            for name, stiffness in self.springs.items()
        )


def _inner_beams(case: Case) -> _Beams | str:
    """Return the shafts between joints; in words why they have no critical speed."""
    line, lengths = case.line, case.line.geometry.lengths
    inner = [k for k in range(1, line.count) if line.shafts[k].centring is None]
    if not inner:
        return "there is no shaft between joints"
    lacking = [line.shaft_names[k] for k in inner if line.shafts[k].tube is None]
    if lacking:
        return f"give tube of {', '.join(lacking)}"
    names = iter(item.name for item in bearings_of(line))
    soft, bearings = [], []
    for k, shaft in enumerate(line.shafts):
        for item in shaft.bearings:
            name = next(names, "")
            if k in inner:
                stiffness = np.inf if item.stiffness is None else item.stiffness
                soft += [name] if item.stiffness is None else []
                place = item.distance + _extensions(case, k)[0]
                beam = bending_speed.LineBearing(inner.index(k), place, stiffness)
                bearings.append((name, beam))
    ends = [_end_stiffness(line.shafts[0]), _end_stiffness(line.shafts[-1])]
    long = [float(lengths[k] + sum(_extensions(case, k))) for k in inner]
    try:
        return _Beams(case, inner, long, _joint_masses(case), ends, bearings, tuple(soft))
    except ValueError as error:
        return str(error)


def _end_beam(case: Case, k: int) -> _Beams | str:
    """Return an end shaft with a tube; in words why it has no critical speed.

    It is a beam on its bearings, as stiff as they are said to be. Its ends are free: two bearings
    hold the joint too. A shaft with one bearing hangs by its joint, which is rigid then.
    """
    line, shaft = case.line, case.line.shafts[k]
    if not shaft.bearings:
        return f"give bearings of {line.shaft_names[k]}"
    given = float(line.geometry.lengths[k])
    length = float(np.fmax(given, max(item.distance for item in shaft.bearings)))
    names = iter(item.name for item in bearings_of(line) if item.shaft == k)
    bearings = [
        (next(names, ""), bending_speed.LineBearing(0, item.distance, item.stiffness or np.inf))
        for item in shaft.bearings
    ]
    masses = [line.joints[0 if k == 0 else -1].cross_mass, 0.0]
    ends = [np.inf if len(bearings) == 1 else 0.0, 0.0]
    try:
        return _Beams(case, [k], [length], masses, ends, bearings)
    except ValueError as error:
        return str(error)


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
            piece = line.shafts[k].mass_at(float(line.geometry.lengths[k]))
            result[k - 1 : k + 1] = [sum(result[k - 1 : k + 1]) + piece]
    return result


def _bending_speeds(case: Case, beams: _Beams | str, where: str = "") -> Iterator[VerdictRow]:
    """Yield the rows of shafts that bend together, between joints or the end shaft of a name."""
    (speed, at), line = case.fastest, case.line
    row = VerdictRow("bending_speed", where, "share of the critical speed")
    if isinstance(beams, str) or speed is None:
        yield opened(row, beams if isinstance(beams, str) else "give speed")
        return
    name, soft = case.of_application("bending_speed_share"), ""
    if beams.soft:
        soft = (
            f"give stiffness of {', '.join(beams.soft)}, across the shaft and with its bracket; "
            "the value is that of rigid ones, which soft ones exceed"
        )
    for found in beams.bending:
        note, broken = _of_beam(case, beams, found)
        of_shaft = replace(
            row,
            where=line.shaft_names[found.shaft],
            value=speed / found.speed,
            rule_value=speed / found.by_rule,
            condition=at.name,
            broken=broken,
            inverses=(
                Inverse("critical speed", found.speed, "rad/s"),
                *_greatest_length(case, beams, found, case.limit(name)),
            ),
            note=note,
        )
        for held in (case.held(of_shaft, name), _half_critical(case, found)):
            yield withheld(withheld(held, soft), _unknown_speed(case))
    yield from _bounce(case, beams)


def _bounce(case: Case, beams: _Beams) -> Iterator[VerdictRow]:
    """Yield the row of rigid shafts that bounce on soft bearings, which bend no tube."""
    if beams.bounce is None:
        return
    speed, shaft = beams.bounce
    fastest, at = case.fastest
    row = VerdictRow(
        "bending_speed",
        case.line.shaft_names[shaft],
        "speed at which rigid shafts bounce on their bearings",
        value=speed,
        unit="rad/s",
        condition=at.name,
        note="running through it is usual, staying at it or at half of it is not",
    )
    share = case.limit("bounce_share")
    if share is None or not fastest:
        near = "" if "bounce_share" in case.given else _inside(case, speed)
        if near:
            yield opened(row, f"{near}; {case.why_not('bounce_share')}")
        else:
            yield stated(row, "" if share else case.why_not("bounce_share"))
        return
    least = fastest / share.value
    row = replace(row, inverses=beams.stiffer(least))
    yield judged(row, Limit(least, "rad/s", share.source, "least"), "")


def _inside(case: Case, speed: float) -> str:
    """Return in words which part of a speed [rad/s] the operating points lie around, if any."""
    speeds = [point.speed for point in case.points if point.speed is not None]
    if min(speeds) <= speed <= max(speeds):
        return "it lies within the speeds of the line and its duty cycle"
    if min(speeds) <= speed / 2.0 <= max(speeds):
        return "half of it lies within the speeds of the line and its duty cycle"
    return ""


def _greatest_length(
    case: Case, beams: _Beams, found: _Critical, limit: Limit | None
) -> tuple[Inverse, ...]:
    """Return the greatest free length of a shaft on rigid supports."""
    speed, _ = case.fastest
    tube = case.line.shafts[found.shaft].tube
    if not (beams.single and tube and limit and limit.value > 0.0 and speed):
        return ()
    # The beam or the constant that was used, in the form of the makers.
    maker = found.speed * found.span**2 / np.hypot(*tube.diameters)
    length = bending_speed.greatest_length(*tube.diameters, speed, maker, limit.value)
    return (Inverse("greatest free length", float(length), "m"),)


def _of_beam(case: Case, beams: _Beams, found: _Critical) -> tuple[str, tuple[str, ...]]:
    """Return of what a critical speed is, and the assumptions of its rule that do not hold."""
    notes, broken, tube = list[str](), list[str](), case.line.shafts[found.shaft].tube
    constant, is_end = case.critical_constant, found.shaft in (0, case.line.count)
    if constant is not None:
        notes.append(f"critical speed by {constant.source}")
    if is_end or beams.single:
        notes.append(f"free length {found.span * 1e3:.0f} mm")
    if is_end:
        notes.append("on its own bearings")
        broken.append(
            "one shaft on rigid supports at its ends: the value counts with its bearings where "
            "they are, and with what overhangs"
        )
    elif not beams.single:
        notes.append("of all shafts together with joints and bearings")
        broken.append(
            "one shaft on rigid supports close to its joints: the value counts with all shafts, "
            "joints and bearings"
        )
    if constant and tube and (tube.modulus, tube.density) != (Tube.modulus, Tube.density):
        broken.append("steel: the tube is of another material than the maker's constant")
    return "; ".join(notes), tuple(broken)


def _half_critical(case: Case, found: _Critical) -> VerdictRow:
    line, where, critical = case.line, case.line.shaft_names[found.shaft], found.speed
    low, high = case.limit("half_critical_from"), case.limit("half_critical_to")
    angle = case.limit("second_order_angle")
    quantity = "distance from half the critical speed"
    row = VerdictRow("bending_speed", where, quantity)
    if low is None or high is None:
        name = "half_critical_from" if low is None else "half_critical_to"
        return stated(row, case.why_not(name))
    middle, half = (low.value + high.value) / 2.0, (high.value - low.value) / 2.0
    points = [point for point in case.points if point.speed is not None]
    distances = [abs((point.speed or 0.0) / critical - middle) for point in points]
    worst = int(np.argmin(distances))
    both = high.source if low.source in high.source else f"{low.source}; {high.source}"
    row = replace(
        row,
        value=distances[worst],
        condition=points[worst].name,
        inverses=(
            Inverse("zone from", low.value * critical, "rad/s"),
            Inverse("zone to", high.value * critical, "rad/s"),
        ),
    )
    if angle is not None and float(max(line.uneven_angles)) < angle.value:
        shown = f"joint angles below {np.degrees(angle.value):.3g}° excite no second order"
        return stated(row, shown)
    return judged(row, Limit(half, "1", both, "least"), "")


def _torsional_speed(case: Case) -> Iterator[VerdictRow]:
    line, speed = case.line, case.fastest[0]
    quantity = "distance from a torsional critical speed"
    row = VerdictRow("torsional_speed", "", quantity)
    beta = float(max(line.uneven_angles))
    # Unevenness is proportional to the square of the angle: rounding alone is none.
    if beta**2 <= EPS:
        yield stated(row, "no joint turns unevenly, so that nothing excites torsion")
        return
    ends = zip(("input", "output"), (line.shafts[0], line.shafts[-1]), strict=True)
    soft = _compliances(case)
    lacking = [name for name, value in zip(line.shaft_names, soft, strict=True) if value is None]
    if not lacking and not any(soft):  # One of them has to twist, if nothing else can.
        lacking = [line.shaft_names[0], line.shaft_names[-1]]
    missing = [
        f"{'inertia' if shaft.mass else 'mass and inertia'} of the {name} shaft"
        for name, shaft in ends
        if not shaft.inertia
    ]
    missing += [f"tube or torsional_stiffness of {'/'.join(lacking)}"] if lacking else []
    missing += ["speed"] if speed is None else []
    if missing:
        yield opened(row, "give " + ", ".join(missing))
        return
    inertias, stiffnesses = _chain(line, [value or 0.0 for value in soft])
    modes = torsional_speed.chain_frequencies(inertias, stiffnesses)
    speeds = torsional_speed.critical_speeds(modes)
    found = [
        (abs((point.speed or 0.0) / float(speed) - 1.0), name, mode, point)
        for point in case.points
        if point.speed is not None
        for name, by_order in (("order 2", speeds.order_2), ("order 4", speeds.order_4))
        for mode, speed in enumerate(by_order)
    ]
    distance, nearest, mode, point = min(found, key=lambda item: item[0])
    critical = {"order 2": speeds.order_2[mode], "order 4": speeds.order_4[mode]}
    rpm = critical[nearest] * 30.0 / np.pi
    row = replace(
        row,
        value=distance,
        condition=point.name,
        inverses=tuple(Inverse(name, float(speed), "rad/s") for name, speed in critical.items()),
        note=f"natural frequency {modes[mode] / (2 * np.pi):.4g} Hz, nearest: {nearest} at "
        f"{rpm:.4g} 1/min",
    )
    yield withheld(case.held(row, "torsional_distance"), _unknown_speed(case))
    yield _zone(case, modes, beta, 1.0 - inertias[0] / sum(inertias))


def _unknown_speed(case: Case) -> str:
    """Return what would tell the speed of all operating points; empty if it is known."""
    return "give speed" if any(point.speed is None for point in case.points) else ""


def _zone(case: Case, modes: Array, beta: float, share: float) -> VerdictRow:
    """Return the row of the first zone of parametric instability of a mode.

    It is the mode in whose zone a point is; the lowest one if there is none.
    """
    zone = torsional_speed.parametric_zone(beta, share)
    lows, highs = float(zone.least) * modes, float(zone.greatest) * modes
    held = [
        (point, mode)
        for point in case.points
        for mode in range(len(modes))
        if point.speed and lows[mode] <= point.speed <= highs[mode]
    ]
    mode = held[0][1] if held else 0
    low, high = float(lows[mode]), float(highs[mode])
    row = VerdictRow(
        "torsional_speed",
        "",
        "damping that closes the first parametric zone",
        value=float(zone.damping),
        condition=held[0][0].name if held else "",
        inverses=(Inverse("zone from", low, "rad/s"), Inverse("zone to", high, "rad/s")),
        broken=("of one joint with the spring in front of it: the greatest joint angle is taken",),
    )
    if not held or low == high:
        return stated(replace(row, note="no operating point is in the zone"))
    note = "in the zone: damping has to exceed the value"
    return replace(stated(row), status=FAIL, note=note)


def _chain(line: LineData, compliances: list[float]) -> tuple[list[float], list[float]]:
    """Return inertias of a line in a row [kg·m²], and the stiffness between them [N·m/rad].

    Each shaft between joints has its inertia in its middle, the end shafts have it at their ends,
    and crosses are at the joints. What has no inertia, or is rigid, leaves no place of its own.
    """
    ends = [line.shafts[end].inertia or 0.0 for end in (0, -1)]
    # In the order of the flow: the softness in front of an inertia, and the inertia.
    row = [(0.0, ends[0])]
    before = compliances[0]
    for k in range(1, line.count):
        half = compliances[k] / 2.0
        inertia = sum(body.inertia for body in shaft_bodies(line, k) if body is not None)
        row += [(before, cross_inertia(line.joints[k - 1])[1]), (half, inertia)]
        before = half
    row += [(before, cross_inertia(line.joints[-1])[1]), (compliances[-1], ends[1])]
    inertias, stiffnesses, soft = [row[0][1]], [], 0.0
    for compliance, inertia in row[1:]:
        soft += compliance
        if not inertia:
            continue
        if soft:
            inertias.append(inertia)
            stiffnesses.append(1.0 / soft)
        else:
            inertias[-1] += inertia
        soft = 0.0
    return inertias, stiffnesses


def _compliances(case: Case) -> list[float | None]:
    """Return the torsional softness of each shaft [rad/(N·m)]; None where it does not tell it.

    An end shaft or a coupling piece is rigid unless it tells otherwise.
    """
    line = case.line
    found: list[float | None] = []
    for k, shaft in enumerate(line.shafts):
        length = float(line.geometry.lengths[k])
        if shaft.torsional_stiffness is not None:
            found.append(1.0 / shaft.torsional_stiffness)
        elif shaft.tube is not None and np.isfinite(length):
            found.append(1.0 / shaft.tube.torsional_stiffness(length))
        else:
            is_rigid = k in (0, line.count) or shaft.centring is not None
            found.append(0.0 if is_rigid else None)
    return found


def _lengths(case: Case, k: int) -> Iterator[VerdictRow]:
    line, where = case.line, case.line.shaft_names[k]
    spline, length = line.shafts[k].spline, float(line.geometry.lengths[k])
    if spline is None:
        return
    shortest = min(length, spline.shortest or length)
    longest = max(length, spline.longest or length)
    row = VerdictRow("lengths", where, "travel left when shortest", unit="m")
    if spline.compressed is None:
        yield opened(row, f"give compressed of the spline of {where}")
        return
    left = replace(
        row,
        value=shortest - spline.compressed,
        note="" if spline.shortest else "no shortest: the length of the shaft",
    )
    limit = case.limit("telescope_travel_left")
    yield judged(left, limit or Limit(0.0, "m", "the spline strikes", "least"), "")
    overlap_limit = case.limit("telescope_overlap")
    if spline.travel is not None:
        found = installation.operating_lengths(spline.compressed, spline.travel)
        drawn = replace(
            row,
            quantity="length when longest",
            value=longest,
            inverses=(Inverse("recommended length", float(found.recommended), "m"),),
        )
        yield judged(drawn, Limit(float(found.greatest), "m", "L_z + L_a of the spline"), "")
    row = replace(row, quantity="overlap when longest")
    if spline.profile is not None:
        parts_at = spline.compressed + spline.profile
        overlap = installation.telescope_margins(spline.compressed, parts_at, shortest, longest)
        row = replace(
            row,
            value=float(overlap.overlap),
            note="" if spline.longest else "no longest: the length of the shaft",
        )
        yield judged(row, overlap_limit or Limit(0.0, "m", "the profiles part", "least"), "")
    elif overlap_limit is not None or spline.travel is None:
        fields = "profile" if overlap_limit is not None else "travel or profile"
        yield opened(row, f"give {fields} of the spline of {where}")


def _balance(case: Case, k: int, inner: _Beams | str) -> Iterator[VerdictRow]:
    line, where, (speed, at) = case.line, case.line.shaft_names[k], case.fastest
    shaft, length = line.shafts[k], float(line.geometry.lengths[k])
    mass = shaft.mass_at(length)
    row = VerdictRow("balancing", where, "allowed residual unbalance")
    grade = case.limit("balance_grade_maker")
    if grade is None:
        yield stated(row, case.why_not("balance_grade_maker"))
        return
    if not speed or not mass:
        yield opened(row, "give speed and mass or tube")
        return
    needed = case.limit("balancing_speed")
    text = ""
    if needed is not None:
        text = "needed" if speed > needed.value else "not needed"
        text = f"balancing {text}: limit {needed.value * 30 / np.pi:.0f} 1/min"
    yield replace(
        row,
        value=float(installation.residual_unbalance(grade.value, mass, speed)),
        unit="kg m",
        condition=at.name,
        source=grade.source,
        note=text,
        broken=_not_rigid(case, k, inner),
    )


def _not_rigid(case: Case, k: int, inner: _Beams | str) -> tuple[str, ...]:
    """Return that a shaft runs so close to its critical speed that it bends."""
    speed = case.fastest[0]
    if isinstance(inner, str) or not speed:
        return ()
    found = [item.speed for item in inner.bending if item.shaft == k]
    if not found or speed <= found[0] / 2.0:
        return ()
    return ("well below the critical speed: it runs above half of it",)
