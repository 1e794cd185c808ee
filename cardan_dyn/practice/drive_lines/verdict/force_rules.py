"""Force rules: fork couples, bearing forces and axial forces of a drive line, judged."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from cardan_dyn.analytic import support_forces
from cardan_dyn.analytic.limits import Limit

from ....kit.arrays import Array
from ....kit.extremes import greatest
from ..line.geometry import residual_angles
from ..line.parts import Shaft
from ..line.supports import supports
from .case import Case
from .rows import Inverse, VerdictRow, opened


def force_rules(case: Case) -> Iterator[VerdictRow]:
    """Yield the rows about forces and moments."""
    reason = case.no_forces
    if reason:
        yield opened(VerdictRow("fork_couples", "", "bending moments"), reason)
        yield opened(VerdictRow("bearing_forces", "", "bearing forces"), reason)
    else:
        yield from _couples(case)
        yield from _bearings(case)
        yield from _centrings(case)
    yield from _axial(case)


def _couples(case: Case) -> Iterator[VerdictRow]:
    line, torque = case.line, (case.strongest[0] or 0.0) * case.service_factor
    sides = ("before", *case.worst("bending_in")), ("behind", *case.worst("bending_out"))
    for k, beta in enumerate(line.joint_angles):
        rule = support_forces.fork_couples(float(beta), torque)
        couples = (float(rule.input_normal), float(rule.output_in_plane))
        is_even = line.even[k]
        if is_even:
            couples = (torque * math.tan(beta / 2.0),) * 2
        for (text, sizes, cases), by_rule in zip(sides, couples, strict=True):
            broken = list(_with_mass(case))
            if text == "behind" and beta > math.pi / 4 and not is_even:
                broken.append("up to 45°: the shaft behind is bent more between both positions")
            if k > 0:
                broken.append("torque of the input shaft: joints before this one vary it")
            yield VerdictRow(
                "fork_couples",
                line.joint_names[k],
                f"bending moment {text} the joint",
                value=float(sizes[k]),
                unit="N m",
                rule_value=by_rule,
                condition=cases[k].point.name,
                note=cases[k].how,
                source="none: bearings and shafts carry it",
                broken=tuple(broken),
            )


def _with_mass(case: Case) -> tuple[str, ...]:
    if not case.is_heavy:
        return ()
    return ("massless crosses and shafts: the value is with inertia",)


def _bearings(case: Case) -> Iterator[VerdictRow]:
    causes = case.causes
    if causes is None:
        return
    across = case.worst("bearing_radial")
    along = case.worst("bearing_axial")
    by_rule, reason = _by_statics(case)
    held_by = supports(case.line).bearings
    by_name = dict(zip([item.name for item in held_by], case.line.bearings, strict=True))
    floating = {item.name for item in held_by if not item.locating}
    sliding = ["no axial force in the spline: the value is with its friction"]
    broken = [*_with_mass(case), *([reason] if reason else [])]
    slides = any(shaft.spline is not None and shaft.spline.friction for shaft in case.line.shafts)
    broken += sliding if slides else []
    for index, name in enumerate(causes.bearings):
        bearing = by_name.get(name)
        for (sizes, cases), of, quantity, field, by_its_rule in (
            (across, "bearing_radial", "across", "radial_limit", by_rule.get(name)),
            (along, "bearing_axial", "along", "axial_limit", None),
        ):
            size, where = float(sizes[index]), cases[index]
            most = getattr(bearing, field) if bearing else None
            if quantity == "along" and most is None and name in floating:
                continue
            row = VerdictRow(
                "bearing_forces",
                name,
                f"force {quantity} the shaft",
                value=size,
                unit="N",
                rule_value=by_its_rule,
                condition=where.point.name,
                note=where.how,
                broken=tuple(broken),
            )
            torque = abs(where.point.torque or 0.0)
            if most is not None and size and torque and not case.is_heavy:
                # Forces are proportional to it.
                inverse = Inverse("allowed torque", torque * most / size, "N m")
                row = replace(row, inverses=(inverse,))
            if bearing is None:
                yield opened(row, "a bearing at the joint itself; give the shaft's own bearings")
                continue
            limit = None if most is None else Limit(most, "N", field)
            yield case.of_forces(row, limit, f"give {field} of the bearing", of, index)


def _centrings(case: Case) -> Iterator[VerdictRow]:
    """Yield the rows of centred double joints: how evenly they turn, and the force inside."""
    line = case.line
    if not line.centred:
        return
    forces, cases = case.worst("centring")
    for index, k in enumerate(line.centred):
        kind, where = line.shafts[k].centring, line.shaft_names[k]
        pair = slice(k - 1, k + 1)
        yield VerdictRow(
            "centred_double_joint",
            where,
            "residual angle of both joints together",
            value=float(residual_angles(line.joint_angles[pair], line.fork_phases[pair])[-1]),
            unit="rad",
            source="stated: the whole line is judged",
        )
        row = VerdictRow(
            "centred_double_joint",
            where,
            "force in the centring",
            value=float(forces[index]),
            unit="N",
            condition=cases[index].point.name,
            note=cases[index].how,
            broken=_with_mass(case),
        )
        most = None if kind is None else kind.force_limit
        limit = None if most is None else Limit(most, "N", "force_limit of the centring")
        missing = "give force_limit of the centring"
        yield case.of_forces(row, limit, missing, "centring", index)


def _by_statics(case: Case) -> tuple[dict[str, float], str]:
    """Return the rule's greatest bearing forces of a turn, and why there are none."""
    line, torque = case.line, case.strongest[0]
    spans = _spans(line.shafts)
    inner = line.shafts[1:-1]
    counts = [len(shaft.bearings) for shaft in inner]
    others = line.centred or any(joint.kind != "cross" for joint in line.joints)
    if others or spans is None or line.count < 2 or counts != [1] * (line.count - 2) + [0]:
        return {}, (
            "two bearings on both end shafts, one centre bearing on each intermediate shaft but "
            "the last, and joints with a cross: this line has others, no closed form"
        )
    if not torque:
        return {}, ""
    found = support_forces.line_support_forces(
        line.geometry.directions,
        np.linspace(0.0, np.pi, 1440, endpoint=False),
        torque * case.service_factor,
        line.geometry.lengths[1:-1],
        np.array([shaft.bearings[0].distance for shaft in inner[:-1]]),
        spans,
        line.fork_offsets,
    )
    # A and B, the centres, E and F.
    ordered = sorted(supports(line).bearings, key=lambda item: (item.shaft, item.along))
    centres = np.moveaxis(found.centres, -2, 0) if line.count > 2 else np.zeros((0, 1, 3))
    listed: list[Array] = [found.A, found.B, *centres, found.E, found.F]
    # All positions come back after half a turn.
    sizes = [float(np.sqrt(greatest((force**2).sum(axis=-1)[:, None])[0])[0]) for force in listed]
    return {item.name: size for item, size in zip(ordered, sizes, strict=True)}, ""


def _spans(shafts: tuple[Shaft, ...]) -> support_forces.Spans | None:
    """Return the distances of the end shafts' bearings; None unless both have two."""
    ends = [sorted(item.distance for item in shafts[end].bearings) for end in (0, -1)]
    if [len(end) for end in ends] != [2, 2]:
        return None
    (b, far), (e, rear) = ends
    return support_forces.Spans(a=far - b, b=b, e=e, f=rear - e)


def _axial(case: Case) -> Iterator[VerdictRow]:
    line, torque = case.line, case.strongest[0]
    for k, shaft in enumerate(line.shafts):
        spline, where = shaft.spline, line.shaft_names[k]
        if spline is None:
            continue
        row = VerdictRow("axial_force", where, "force of the sliding spline", unit="N")
        if spline.friction is None or torque is None:
            missing = "friction and radius of the spline" if spline.friction is None else "torque"
            yield opened(row, f"give {missing}")
            continue
        if case.causes is None:
            yield opened(row, case.no_forces)
            continue
        beta = float(line.joint_angles[k - 1])
        most = torque * case.service_factor
        # The torque in this shaft varies as joints turn unevenly, and with inertia.
        sizes, cases = case.worst("spline_friction")
        index = case.causes.splines.index(where)
        friction, radius = spline.friction, spline.radius or 1.0
        notes = [cases[index].how, f"μ = {friction:g}"]
        notes.append("lubrication pressure times area comes on top")
        row = replace(
            row,
            value=float(sizes[index]),
            rule_value=float(support_forces.axial_force(most, beta, radius, friction)),
            condition=cases[index].point.name,
            source="none: locating bearings carry it",
            note="; ".join(filter(None, notes)),
            broken=(
                "μ T cos β / r: the torque in the shaft is the one that varies over the turn, "
                "between T cos β and T / cos β",
            )
            if beta > 0.0
            else (),
        )
        yield opened(row, case.lacking) if case.lacking else row
