"""Angle rules: joint angles, uniformity and accelerations of a drive line, judged."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from cardan_dyn.analytic import drive_line, installation, single_joint, uniformity
from cardan_dyn.analytic.limits import JOINT_SIZES, SPEED_ANGLES, Limit

from ....kit.arrays import ROUNDED, Array
from ....kit.errors import choices
from ....kit.extremes import greatest
from ....kit.roots import zeros
from ..line.geometry import MEETING, residual_angles
from ..line.parts import ShaftJoint
from .case import Case
from .rows import Inverse, VerdictRow, judged, opened, stated, withheld

COARSE = 0.01
"""Relative error from which on a rule is said to be wrong."""
PIECE = (
    "both forks of the coupling piece of a centred joint stand in line, which makes the output "
    "even: its fork offset parts them"
)
"""What is said of a coupling piece that has a fork offset."""
_POSITIONS = 1440
"""In half a turn, which decide the greatest sum of accelerations."""
_USUAL_LENGTH = (1.0, 2.0)
"""Lengths that are near the 1.5 m of the makers' values of speed times angle [m]."""


def angle_rules(case: Case) -> Iterator[VerdictRow]:
    """Yield the rows about angles and accelerations."""
    yield from _joint_angles(case)
    yield from _slopes(case)
    yield from _uniformity(case)
    yield from _accelerations(case)
    yield from _n_beta(case)


def first_order(exact: float, rule: float) -> tuple[str, ...]:
    """Return what a rule of first order misses, if that is much."""
    if abs(rule - exact) <= COARSE * abs(exact):
        return ()
    # Near zero a percentage says nothing.
    if abs(exact) <= COARSE * abs(rule):
        return ("of first order in the squares of the angles: the rule is far off here",)
    return (
        "of first order in the squares of the angles: "
        f"the rule is {100.0 * (rule / exact - 1.0):+.1f} % off here",
    )


def signs_hold(case: Case) -> tuple[str, ...]:
    """Return that sums with signs do not hold, where forks are not at 0° or 90°."""
    phases = case.line.fork_phases[case.line.uneven_angles > 0.0]
    steps = np.diff(phases) / (np.pi / 2)
    if np.all(np.abs(steps - np.round(steps)) * np.pi / 2 <= MEETING):
        return ()
    return (
        "sums with signs hold for planar lines with forks at 0 or 90 degrees: this line is "
        "spatial or its forks stand otherwise; the rule's value is the sum of phase vectors",
    )


def _joint_angles(case: Case) -> Iterator[VerdictRow]:
    line = case.line
    views = line.geometry.views
    for k, (joint, beta) in enumerate(zip(line.joints, line.joint_angles, strict=True)):
        row = VerdictRow(
            "joint_angles",
            line.joint_names[k],
            "joint angle",
            value=float(beta),
            unit="rad",
            rule_value=float(np.hypot(*views[k])) if np.isfinite(views[k]).all() else None,
        )
        most = joint.largest_angle
        own = None if most is None else Limit(most, "rad", "largest_angle of the joint")
        yield judged(row, own, "give largest_angle of the joint")
        # Rules of single joints with a cross: others turn evenly, alone or in pairs.
        if joint.kind == "cross" and not {k, k + 1} & set(line.centred):
            yield from _practical_angles(case, row)
    for k in range(line.count - 1):
        row = VerdictRow(
            "joint_angles",
            line.shaft_names[k + 1],
            "difference of both joint angles",
            value=_difference(*line.joint_angles[k : k + 2].tolist()),
            unit="rad",
        )
        other = _compensated_otherwise(case)
        yield stated(row, other) if other else case.held(row, "angle_difference")


def _difference(one: float, other: float) -> float:
    """Return by how much two angles differ; 0 within their rounding."""
    apart = abs(other - one)
    return 0.0 if apart <= ROUNDED * max(one, other) else apart


def _practical_angles(case: Case, row: VerdictRow) -> Iterator[VerdictRow]:
    """Yield the rows of an angle that makers want at least, and at most by application."""
    yield case.held(replace(row, quantity="least joint angle"), "least_joint_angle")
    if case.limit("pto_angle") is not None or not case.line.application:
        yield case.held(replace(row, quantity="joint angle, continuous, PTO"), "pto_angle")
    row = replace(row, quantity="joint angle at the greatest speed")
    share, (speed, at) = case.limit("speed_angle_share"), case.fastest
    if share is None:
        yield stated(row, case.why_not("speed_angle_share"))
    elif speed is None:
        yield opened(row, "give speed")
    else:
        most = share.value * float(installation.greatest_joint_angle(speed))
        held = replace(row, condition=at.name)
        held = judged(held, Limit(most, "rad", share.source), "")
        end = max(SPEED_ANGLES)
        reason = f"the table ends at {end * 30 / np.pi:.0f} 1/min; ask the maker of the joint"
        yield withheld(held, reason) if speed > end else held


def _compensated_otherwise(case: Case) -> str:
    """Return why the angles of a shaft's two joints need not be equal; empty if they do."""
    line = case.line
    crosses = sum(joint.kind == "cross" for joint in line.joints)
    if line.count > 2 or crosses < 2:
        return "more joints than those of this shaft compensate each other; see residual angle"
    apart = float(line.fork_phases[1] - line.fork_phases[0])
    if abs(np.cos(apart)) > MEETING:
        return "the forks do not stand so that both joints compensate; see residual angle"
    return ""


def _slopes(case: Case) -> Iterator[VerdictRow]:
    views = case.line.geometry.views
    if not np.isfinite(views).all():
        row = VerdictRow("slopes", "", "joint angles by their views")
        yield stated(row, "a shaft leads not forward")
        return
    pairs = zip(np.hypot(*views.T).tolist(), case.line.joint_angles.tolist(), strict=True)
    worst = max(_difference(*pair) for pair in pairs)
    yield VerdictRow(
        "slopes",
        "",
        "error of joint angles from sums of squares of both views",
        value=worst,
        unit="rad",
        source="exact joint angles are judged",
    )


def _uniformity(case: Case) -> Iterator[VerdictRow]:
    line = case.line
    betas, phases, count = line.uneven_angles, line.fork_phases, line.count
    found = residual_angles(betas, phases).tolist()
    exact = found[-1]
    by_rule = float(drive_line.residual_angle_approximate(betas, phases))
    broken = (*signs_hold(case), *first_order(exact, by_rule))
    limit = case.limit("residual_angle")
    is_joint = line.joints[-1].kind == "cross" and line.count - 1 not in line.centred
    rest = _allowed_last(case, limit) if limit is not None and count > 1 and is_joint else ()
    where = line.shaft_names[-1]
    residual = VerdictRow(
        "uniformity",
        where,
        "residual angle",
        value=exact,
        unit="rad",
        rule_value=by_rule,
        broken=broken,
        inverses=rest,
        note=_lead(exact),
    )
    held = case.held(residual, "residual_angle")
    yield held
    non_uniformity = VerdictRow(
        "uniformity",
        where,
        "degree of non-uniformity U",
        value=float(single_joint.non_uniformity(exact)),
        rule_value=float(uniformity.added_non_uniformity(betas, phases)),
        broken=broken[:1] if signs_hold(case) else (),
        inverses=_allowed_by_u(case.limit("non_uniformity")),
    )
    of_u = case.held(non_uniformity, "non_uniformity")
    # Unless both are given, both are the limit of one angle: rounding must not part them.
    yield (
        of_u
        if {"residual_angle", "non_uniformity"} <= case.given
        else replace(of_u, status=held.status)
    )
    for k in range(1, count):
        beta = found[k - 1]
        yield VerdictRow(
            "uniformity",
            line.shaft_names[k],
            "residual angle",
            value=beta,
            unit="rad",
            source="stated: it moves the shaft alone",
            broken=(PIECE,) if k in line.centred and line.fork_offsets[k - 1] % np.pi else (),
            note=_lead(beta),
        )


def _lead(beta: float) -> str:
    lead = np.degrees(float(single_joint.greatest_lead(beta)))
    return f"angle error ±{lead:.3g}°"


def _allowed_by_u(limit: Limit | None) -> tuple[Inverse, ...]:
    if limit is None or limit.value < 0.0:
        return ()
    angle = float(uniformity.angle_of_non_uniformity(limit.value))
    return (Inverse("allowed residual angle", angle, "rad"),)


def _allowed_last(case: Case, limit: Limit) -> tuple[Inverse, ...]:
    """Return the angles of the last joint between which the residual angle keeps its limit.

    Exact: 1/cos² along the line adds as vectors of the joints' maps; found on a grid of the angle
    and between its places to rounding.
    """
    line = case.line
    phases = line.fork_phases

    def excess(last: Array) -> Array:
        betas = np.tile(line.uneven_angles, (len(last), 1))
        betas[:, -1] = last
        return np.asarray(drive_line.residual_angle(betas, phases)) - limit.value

    grid = np.linspace(0.0, np.radians(60.0), 241)
    values = excess(grid)
    crossings = np.flatnonzero(np.diff(np.sign(values)))
    found = zeros(
        lambda last, _: excess(last),
        (grid[crossings], grid[crossings + 1]),
        (values[crossings], values[crossings + 1]),
    )
    name = line.joint_names[-1]
    names = [f"allowed angle of {name}"] if len(found) == 1 else []
    if len(found) == 2:
        names = [f"least angle of {name}", f"greatest angle of {name}"]
    return tuple(
        Inverse(what, float(value), "rad") for what, value in zip(names, found, strict=False)
    )


def inertia_ratio(betas: Array, phases: Array, left_out: Collection[int] = ()) -> float:
    """Return the greatest sum of the second derivatives of intermediate shafts' rotations.

    By the rotation of the shaft that turns evenly [1/rad], over half a turn.

    Args:
        betas: `(n,)` joint angles, from the shaft that turns evenly [rad].
        phases: `(n,)` fork phases [rad].
        left_out: numbers of the shafts, from the one that turns evenly, that do not count.
    """
    turn = np.linspace(0.0, np.pi, _POSITIONS, endpoint=False)
    total = np.zeros_like(turn)
    uneven = np.flatnonzero(residual_angles(betas, phases)[:-1]) + 1
    for end in set(uneven.tolist()) - set(left_out):
        total += drive_line.acceleration_ratio(betas[:end], phases[:end], turn)
    return float(np.sqrt(greatest(total[:, None] ** 2)[0])[0])


def _accelerations(case: Case) -> Iterator[VerdictRow]:
    line, (speed, at) = case.line, case.fastest
    if speed is None:
        row = VerdictRow("accelerations", "", "torsional acceleration")
        yield opened(row, "give speed")
        return
    betas, phases = line.uneven_angles, line.fork_phases
    residual = float(residual_angles(betas, phases)[-1])
    # Seen from the output, every joint has its other pin as the driving one.
    back = betas[::-1], phases[::-1] + np.pi / 2
    listed: list[tuple[str, str, float, Any]] = [
        (
            "torsional_acceleration",
            "torsional acceleration of the output",
            float(single_joint.greatest_acceleration(residual)),
            drive_line.residual_angle_approximate(betas, phases),
        )
    ]
    short = line.centred
    if line.count - len(short) > 1:
        from_rear = [line.count - k for k in short]
        for quantity, ratio, rule in (
            (
                "inertia acceleration in drive",
                inertia_ratio(betas, phases, short),
                uniformity.inertia_drive_angle,
            ),
            (
                "inertia acceleration in coast",
                inertia_ratio(*back, from_rear),
                uniformity.inertia_coast_angle,
            ),
        ):
            theta = None if short else rule(betas, phases)
            listed.append(("inertia_acceleration", quantity, ratio, theta))
    for name, quantity, ratio, theta in listed:
        exact = float(ratio * np.square(speed))
        by_rule = None
        if theta is not None:
            by_rule = float(uniformity.angular_acceleration(theta, speed))
        limit, greatest, note = case.limit(name), case.limit(f"{name}_greatest"), ""
        if greatest is not None:
            side = "within" if exact <= greatest.value else "beyond"
            note = f"{side} {greatest.value:g} rad/s² at most"
        row = VerdictRow(
            "accelerations",
            line.shaft_names[-1] if name.startswith("t") else "",
            quantity,
            value=exact,
            unit="rad/s^2",
            rule_value=by_rule,
            condition=at.name,
            broken=() if by_rule is None else (*signs_hold(case), *first_order(exact, by_rule)),
            inverses=_allowed_speed(limit, ratio, speed),
            note=note,
        )
        yield case.held(row, name)
    for k in short:
        residual = float(residual_angles(betas[:k], phases[:k])[-1])
        yield VerdictRow(
            "accelerations",
            line.shaft_names[k],
            "angular acceleration of the coupling piece",
            value=float(single_joint.greatest_acceleration(residual) * np.square(speed)),
            unit="rad/s^2",
            condition=at.name,
            source="stated: the rule is that of shafts between joints, not of short pieces",
        )


def _allowed_speed(limit: Limit | None, ratio: float, speed: float) -> tuple[Inverse, ...]:
    if limit is None or limit.value <= 0.0 or ratio <= 0.0:
        return ()
    angles: tuple[Inverse, ...] = ()
    if speed > 0.0:
        angle = float(uniformity.allowed_angle(limit.value, speed))
        angles = (Inverse("allowed equivalent angle", angle, "rad"),)
    return (Inverse("allowed speed", float(np.sqrt(limit.value / ratio)), "rad/s"), *angles)


def _unknown_size(size: str) -> str:
    """Return that a size is in no table, if one is given."""
    if not size.strip() or size.strip().upper() in _sizes():
        return ""
    return f"; its size {size!r} is none of Dana's: {choices(_sizes(), size)}"


@cache
def _sizes() -> dict[str, Any]:
    return {size.upper(): entry for size, entry in JOINT_SIZES.items()}


def _n_beta(case: Case) -> Iterator[VerdictRow]:
    line, (speed, at), told = case.line, case.fastest, set[str]()
    for k, joint in enumerate(line.joints):
        row = VerdictRow("n_beta", line.joint_names[k], "speed")
        known = _sizes().get(joint.size.strip().upper())
        if speed is None:
            yield opened(row, "give speed")
            continue
        beta = float(line.joint_angles[k])
        row = replace(row, value=speed, unit="rad/s", condition=at.name)
        unknown = _unknown_size(joint.size) if joint.size not in told else ""
        told.add(joint.size)
        yield _by_size(row, joint, "largest_speed", known.speed if known else None, unknown)
        product = replace(row, quantity="speed times angle", value=speed * beta, unit="rad^2/s")
        held = _by_size(product, joint, "largest_n_beta", known.n_beta if known else None)
        if held.limit is None:
            yield held
            continue
        room = held.limit.value / speed if speed > 0.0 else None
        inverses = () if room is None else (Inverse("allowed joint angle", room, "rad"),)
        yield replace(held, inverses=inverses, broken=_far_from_usual(case, k))


def _by_size(
    row: VerdictRow, joint: ShaftJoint, field: str, known: float | None, unknown: str = ""
) -> VerdictRow:
    """Return a row held against a field of a joint, or what its size says."""
    given = getattr(joint, field)
    source = f"Dana, size {joint.size}" if given is None else f"{field} of the joint"
    bound = known if given is None else given
    limit = None if bound is None else Limit(bound, row.unit, source)
    missing = f"give {field} of the joint, or its size{unknown}"
    return judged(row, limit, missing)


def _far_from_usual(case: Case, k: int) -> tuple[str, ...]:
    """Return that a shaft at a joint is much shorter or longer than those of the makers' values."""
    lengths = case.line.geometry.lengths[1:-1]
    near = [float(lengths[i]) for i in (k - 1, k) if 0 <= i < len(lengths)]
    far = [length for length in near if not _USUAL_LENGTH[0] <= length <= _USUAL_LENGTH[1]]
    if not far:
        return ()
    return (f"makers' values are those of shafts of some 1.5 m: this one has {max(far):.3g} m",)
