"""Verdicts recomputed: random drive lines, and what an engineer would fail them for.

Motion follows from pins that are turned by hand, forces from an analysis of every single load case,
bending from an own beam, all other rules from their formulas. Only data of lines are shared.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator

import numpy as np
from scipy.linalg import eigh
from testkit.line_statics import pins

from cardan_dyn.drive_lines import (
    Bearing,
    Centring,
    DriveLine,
    DutyPoint,
    Shaft,
    ShaftJoint,
    Spline,
    Tube,
)

Array = np.ndarray
RPM, HOUR = np.pi / 30, 3600.0
CLOSE = 3e-3
"""Distance to a limit, relative to it, within which positions 3° apart decide nothing."""
STEP = np.radians(3.0)


class Judged:
    """Values against limits: which fail, and which are too close to tell."""

    def __init__(self) -> None:
        self.failed: set[tuple[str, str]] = set()
        self.close: set[tuple[str, str]] = set()

    def most(self, rule: str, where: str, value: float, limit: float | None) -> None:
        if limit is None:
            return
        if abs(value - limit) <= CLOSE * abs(limit):
            self.close.add((rule, where))
        elif value > limit:
            self.failed.add((rule, where))

    def least(self, rule: str, where: str, value: float, limit: float | None) -> None:
        if limit is not None:
            self.most(rule, where, -value, -limit)


Worst = dict[tuple[str, str], float]


def draw(seed: int) -> tuple[DriveLine, Worst]:
    """A random line whose limits are near what it has to bear, and its greatest forces."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 5))
    application = str(rng.choice(["", "vehicle", "agricultural", "industrial"]))
    bend = {"vehicle": 0.06, "": 0.2, "agricultural": 0.2, "industrial": 0.1}[application]
    gentle = rng.random() < 0.8
    if gentle:
        bend *= 0.4
    heavy = rng.random() < 0.5
    piece = int(rng.integers(1, count)) if count > 2 and rng.random() < 0.3 else 0
    free = [k for k in range(1, count) if k != piece]
    shafts, turn = [], rng.uniform(-bend, bend, (count + 1, 2))
    if rng.random() < 0.5:
        turn[:, 1] = 0.0
    if count == 2 and rng.random() < 0.6:
        turn[2] = turn[0] + rng.normal(0.0, 0.01, 2) * (turn[2] != 0.0)
    for k in range(count + 1):
        length = float(rng.uniform(0.5, 1.4))
        fields: dict[str, object] = {
            "length": length,
            "slope_plan": turn[k, 0],
            "slope_side": turn[k, 1],
        }
        if rng.random() < 0.9 and heavy:
            fields["tube"] = Tube(
                outer_diameter=rng.uniform(0.05, 0.1),
                wall=rng.uniform(0.003, 0.006),
                shear_limit=rng.uniform(4e7, 2e8),
            )
        if k in (0, count):
            near = rng.uniform(0.05, 0.15)
            far = near + rng.uniform(0.1, 0.4)
            fields["bearings"] = [
                Bearing(name=f"{name}{k}", distance=at)
                for name, at in (("near", near), ("far", far))
            ]
        elif k == piece:
            del fields["slope_plan"], fields["slope_side"]
            fields |= {"length": 0.12, "centring": Centring(), "tube": None, "mass": 3.0 * heavy}
        else:
            fields["fork_offset"] = rng.choice([0.0, rng.uniform(-0.3, 0.3)])
            if k != free[-1]:
                bearing = Bearing(
                    name=f"centre{k}",
                    distance=rng.uniform(0.7, 0.95) * length,
                    stiffness=10 ** rng.uniform(5.5, 8) if rng.random() < 0.7 else None,
                )
                fields["bearings"] = [bearing]
            else:
                travel, pushed = rng.uniform(0.15, 0.3), length - rng.uniform(0.01, 0.1)
                fields["spline"] = Spline(
                    friction=rng.choice([None, 0.0, 0.08, 0.15]),
                    radius=rng.uniform(0.02, 0.05),
                    travel=travel,
                    compressed=pushed,
                    profile=rng.uniform(0.2, 0.5),
                    shortest=length - 0.02,
                    longest=length + rng.uniform(0.0, 0.1),
                )
        shafts.append(Shaft(**fields))
    joints = []
    for k in range(1, count + 1):
        if rng.random() < 0.15 and not {k - 1, k} & {piece}:
            joints.append(ShaftJoint(kind="constant_velocity", largest_angle=rng.uniform(0.1, 0.5)))
            continue
        joints.append(
            ShaftJoint(
                largest_angle=rng.choice([None, rng.uniform(0.1, 0.5)]),
                largest_speed=rng.choice([None, rng.uniform(800, 4000) * RPM]),
                largest_n_beta=rng.choice([None, np.radians(rng.uniform(6000, 60000)) * RPM]),
                rated_torque=rng.choice([None, None, rng.uniform(1000, 6000)]),
                capacity=rng.choice([None, None, 10 ** rng.uniform(-3, 0)]),
                cross_mass=2.0 * heavy,
                cross_span=0.1 * heavy,
            )
        )
    fields = {
        "application": application,
        "speed": rng.uniform(300, 900 if gentle else 3500) * RPM,
        "torque": rng.uniform(100, 1000) * rng.choice([-1, 1]),
        "service_factor": rng.choice([None, 1.5, 2.5]),
        "reversing": bool(rng.random() < 0.3),
        "acceleration": rng.choice([None, rng.uniform(50, 1000)]),
        "life": 10 ** rng.uniform(1.5, 4) * HOUR,
    }
    if rng.random() < 0.4:
        share = rng.uniform(0.2, 0.8)
        fields["duty_cycle"] = [
            DutyPoint(share=share, speed=fields["speed"] * 0.8, torque=rng.uniform(50, 900)),
            DutyPoint(share=1 - share, speed=rng.uniform(-800, 800) * RPM, torque=-90.0),
        ]
    line = DriveLine(shafts=shafts, joints=joints, **fields)
    worst = worst_forces(line)
    return with_limits(line, worst, rng), worst


def with_limits(line: DriveLine, worst: Worst, rng: np.random.Generator) -> DriveLine:
    """The line with limits of forces and torques a little above or below what it has."""

    def near(value: float) -> float | None:
        if rng.random() < 0.2 or value < 1e-3:
            return None
        return float(value * (rng.uniform(1.01, 3.0) if rng.random() < 0.97 else 0.8))

    shafts = []
    for shaft in line.shafts:
        bearings = [
            dataclasses.replace(
                item,
                radial_limit=near(worst["across", item.name]),
                axial_limit=near(worst["along", item.name]),
            )
            for item in shaft.bearings
        ]
        shafts.append(dataclasses.replace(shaft, bearings=bearings))
    for k in line.centred:
        centring = Centring(force_limit=near(worst["centring", line.shaft_names[k]]))
        shafts[k] = dataclasses.replace(shafts[k], centring=centring)
    joints = [
        dataclasses.replace(
            joint,
            torque_limit=near(worst["in", str(k)]),
            pulsating_limit=near(worst["in", str(k)]),
            reversing_limit=near(worst["in", str(k)]),
        )
        for k, joint in enumerate(line.joints)
    ]
    return line.replace(shafts=shafts, joints=joints)


def points(line: DriveLine) -> list[tuple[float, float]]:
    """Speeds and torques at which the line runs."""
    found = [] if line.speed is None else [(abs(line.speed), line.torque)]
    return found + [(abs(point.speed), point.torque) for point in line.duty_cycle]


def worst_forces(line: DriveLine) -> Worst:
    """Greatest forces of all load cases, each analysed by itself."""
    found: Worst = {}
    has_mass = any(shaft.mass or shaft.tube for shaft in line.shafts)
    has_mass = has_mass or any(joint.cross_mass for joint in line.joints)
    slides = any(shaft.spline is not None and shaft.spline.friction for shaft in line.shafts)
    shock, most = line.service_factor or 1.0, line.acceleration or 0.0
    turn = np.arange(0.0, 2 * np.pi - 1e-9, STEP)
    cases = {
        case
        for speed, torque in points(line)
        for case in itertools.product(
            ({torque * shock, 0.0} if has_mass else {torque * shock})
            | ({-torque * shock} if line.reversing else set()),
            {speed, 0.0} if has_mass else {0.0},
            {most, -most} if has_mass else {0.0},
            ("in", "out") if slides else (None,),
        )
    }
    listed = line.analyse(speed=0.0, torque=0.0, positions=[0.0])
    for torque, speed, rate, slipping in cases:
        if torque == 0.0 and slipping == "in":
            continue
        total = line.analyse(
            speed=speed, torque=torque, acceleration=rate, slipping=slipping,
            gravity=(0.0, 0.0, -9.81), positions=turn,
        ).total  # fmt: skip
        values = {
            **{("across", n): total.bearing_radial[:, i] for i, n in enumerate(listed.bearings)},
            **{("along", n): total.bearing_axial[:, i] for i, n in enumerate(listed.bearings)},
            **{("centring", n): total.centring[:, i] for i, n in enumerate(listed.centrings)},
            **{("in", str(k)): total.torsion_in[:, k] for k in range(line.count)},
            **{("out", str(k)): total.torsion_out[:, k] for k in range(line.count)},
        }
        for key, course in values.items():
            found[key] = max(found.get(key, 0.0), float(np.abs(course).max()))
    return found


def rotations(line: DriveLine, count: int = 180) -> Array:
    """Rotations of all shafts over half a turn of the input `(count, n + 1)`, by their pins."""
    turn = np.arange(count) * (np.pi / count)
    columns = [turn]
    axes = line.geometry.directions
    marks = [[] for _ in range(line.count)]
    for position in turn:
        fork = None
        for k, pair in enumerate(pins(line, float(position))):
            if pair is None:
                marks[k].append(None)
            else:
                fork = pair[1]
                marks[k].append(fork)
    for k in range(line.count):
        if marks[k][0] is None:
            columns.append(columns[-1])
            continue
        first = marks[k][0]
        across = np.cross(axes[k + 1], first)
        angle = [np.arctan2(mark @ across, mark @ first) for mark in marks[k]]
        columns.append(np.unwrap(angle))
    return np.stack(columns, axis=1)


def derivatives(line: DriveLine) -> tuple[Array, Array]:
    """First and second derivatives of all rotations by that of the input, by Fourier series."""
    angles = rotations(line)
    count = len(angles)
    turn = angles[:, 0]
    waves = np.fft.rfft(angles - turn[:, None], axis=0)
    order = 2j * np.arange(len(waves))[:, None]
    # Of few positions, at angles this small, the series knows all others.
    fine = [
        8.0 * np.fft.irfft(item, n=8 * count, axis=0) for item in (order * waves, order**2 * waves)
    ]
    return fine[0] + 1.0, fine[1]


def critical(line: DriveLine) -> float | None:
    """First critical bending speed, by an own beam with stiff springs for rigid supports."""
    inner = [k for k in range(1, line.count) if line.shafts[k].centring is None]
    if not inner or any(line.shafts[k].tube is None for k in inner):
        return None
    nodes = 40
    size = sum(2 * nodes for _ in inner)
    K, M = np.zeros((size, size)), np.zeros((size, size))
    rigid = 1e13
    ends = []
    for i, k in enumerate(inner):
        shaft, tube = line.shafts[k], line.shafts[k].tube
        before = line.shafts[k - 1].centring is not None
        behind = line.shafts[k + 1].centring is not None
        beta = line.joint_angles
        front = 0.06 / np.cos((beta[k - 2] + beta[k - 1]) / 2) if before else 0.0
        rear = 0.06 / np.cos((beta[k] + beta[k + 1]) / 2) if behind else 0.0
        length = float(line.geometry.lengths[k]) + front + rear
        d = tube.outer_diameter - 2 * tube.wall
        bend = tube.modulus * np.pi / 64 * (tube.outer_diameter**4 - d**4)
        mass = tube.density * np.pi / 4 * (tube.outer_diameter**2 - d**2)
        if shaft.mass is not None:
            mass = shaft.mass / float(line.geometry.lengths[k])
        places = np.linspace(0.0, length, nodes)
        for item in shaft.bearings:
            places[np.argmin(np.abs(places - item.distance - front))] = item.distance + front
        start = 2 * nodes * i
        for e, h in enumerate(np.diff(places)):
            at = slice(start + 2 * e, start + 2 * e + 4)
            c = np.array(
                [
                    [12, 6 * h, -12, 6 * h],
                    [6 * h, 4 * h * h, -6 * h, 2 * h * h],
                    [-12, -6 * h, 12, -6 * h],
                    [6 * h, 2 * h * h, -6 * h, 4 * h * h],
                ]
            )
            m = np.array(
                [
                    [156, 22 * h, 54, -13 * h],
                    [22 * h, 4 * h * h, 13 * h, -3 * h * h],
                    [54, 13 * h, 156, -22 * h],
                    [-13 * h, -3 * h * h, -22 * h, 4 * h * h],
                ]
            )
            K[at, at] += bend / h**3 * c
            M[at, at] += mass * h / 420 * m
        for item in shaft.bearings:
            node = int(np.argmin(np.abs(places - item.distance - front)))
            K[start + 2 * node, start + 2 * node] += item.stiffness or rigid
        ends.append((start, start + 2 * nodes - 2))
    for (_, rear), (front, _), k in zip(ends, ends[1:], inner, strict=False):
        K[np.ix_([rear, front], [rear, front])] += rigid * np.array([[1, -1], [-1, 1]])
        between = line.joints[k : k + 1]
        extra = 0.0
        if line.shafts[k + 1].centring is not None:
            between, extra = line.joints[k : k + 2], line.shafts[k + 1].mass or 0.0
        M[rear, rear] += sum(joint.cross_mass for joint in between) + extra
    for at in (ends[0][0], ends[-1][1]):
        K[at, at] += rigid
    return float(np.sqrt(eigh(K, M, eigvals_only=True, subset_by_index=[0, 0])[0]))


def judged(line: DriveLine, worst: Worst) -> Judged:
    """What fails, by rule and place."""
    found = Judged()
    running, shock = points(line), line.service_factor or 1.0
    fastest = max(speed for speed, _ in running)
    betas = line.joint_angles
    _forces(line, found, worst)
    _angles(line, found, fastest)
    for k, (joint, where) in enumerate(zip(line.joints, line.joint_names, strict=True)):
        found.most("joint_angles", where, betas[k], joint.largest_angle)
        found.most("n_beta", where, fastest, joint.largest_speed)
        found.most("n_beta", where, fastest * betas[k], joint.largest_n_beta)
        if joint.kind != "cross":
            continue
        cycle = [(p.share, abs(p.speed), abs(p.torque)) for p in line.duty_cycle]
        cycle = cycle or [(1.0, abs(line.speed or 0.0), abs(line.torque or 0.0))]
        degrees = max(np.degrees(betas[k]), 3.0)
        damage = sum(q * n / RPM * degrees * (t / 1e3) ** (10 / 3) for q, n, t in cycle) * shock
        rule = "duty_cycle" if line.duty_cycle else "joint_life"
        capacities = [joint.capacity]
        capacities += [joint.rated_torque and 1.5e-4 * (joint.rated_torque / 1e3) ** (10 / 3)]
        for capacity in filter(None, capacities):
            found.least(rule, where, capacity * 1e10 / damage * HOUR, line.life)
    for k in range(1, line.count):
        spline, where = line.shafts[k].spline, line.shaft_names[k]
        if spline is None:
            continue
        is_pto = line.application == "agricultural"
        length = float(line.geometry.lengths[k])
        short = min(spline.shortest or length, length)
        long = max(spline.longest or length, length)
        found.least("lengths", where, short - spline.compressed, 0.025 if is_pto else 0.0)
        found.most("lengths", where, long, spline.compressed + spline.travel)
        if spline.profile is not None:
            overlap = spline.compressed + spline.profile - long
            found.least("lengths", where, overlap, 0.15 if is_pto else 0.0)
    speed = critical(line)
    if speed is not None:
        share = {"industrial": 0.65, "vehicle": 0.7}.get(line.application, 0.75)
        found.most("bending_speed", "", fastest / speed, share)
        uneven = [b for b, j in zip(betas, line.joints, strict=True) if j.kind == "cross"]
        if max(uneven, default=0.0) >= np.radians(3.0):
            gaps = [abs(n / speed - 0.5) for n, _ in running]
            found.least("bending_speed", "", min(gaps), 0.08)
    return found


def _forces(line: DriveLine, found: Judged, worst: Worst) -> None:
    for shaft in line.shafts:
        for item in shaft.bearings:
            for way, limit in (("across", item.radial_limit), ("along", item.axial_limit)):
                if limit is not None:
                    found.most("bearing_forces", item.name, worst[way, item.name], limit)
    for k in line.centred:
        name = line.shaft_names[k]
        limit = line.shafts[k].centring.force_limit
        found.most("centred_double_joint", name, worst["centring", name], limit)
    for k, joint in enumerate(line.joints):
        turning = joint.reversing_limit if line.reversing else joint.pulsating_limit
        for limit in (joint.torque_limit, turning):
            found.most("static_ratings", line.joint_names[k], worst["in", str(k)], limit)
    for k, shaft in enumerate(line.shafts):
        if shaft.tube is not None:
            D, d = shaft.tube.outer_diameter, shaft.tube.outer_diameter - 2 * shaft.tube.wall
            torque = worst["in", str(k)] if k < line.count else worst["out", str(k - 1)]
            stress = 16 * torque * D / (np.pi * (D**4 - d**4))
            found.most("tube", line.shaft_names[k], stress, shaft.tube.shear_limit)


def _angles(line: DriveLine, found: Judged, fastest: float) -> None:
    first, second = derivatives(line)
    output = line.shaft_names[-1]
    residual = np.arccos(min(1.0, 1.0 / first[:, -1].max()))
    found.most("uniformity", output, residual, np.radians(3.0))
    found.most("accelerations", output, np.abs(second[:, -1]).max() * fastest**2, 300.0)
    if line.count > 1:
        drive = np.abs(second[:, 1:-1].sum(axis=1)).max()
        one, two = first[:, -1:], second[:, -1:]
        coast = np.abs(((second * one - first * two) / one**3)[:, 1:-1].sum(axis=1)).max()
        for value in (drive, coast):
            found.most("accelerations", "", value * fastest**2, 1000.0)
    centred = {joint for k in line.centred for joint in (k - 1, k)}
    for k, joint in enumerate(line.joints):
        if joint.kind != "cross" or k in centred:
            continue
        where, beta = line.joint_names[k], float(line.joint_angles[k])
        if line.application == "agricultural":
            found.most("joint_angles", where, beta, np.radians(15.0))
        if line.application == "vehicle":
            rpm = np.array([1500, 2000, 2500, 3000, 3500, 4000, 4500, 5000.0])
            table = np.array([11.5, 8.7, 7.0, 5.8, 5.0, 4.2, 3.7, 3.2])
            n = max(fastest / RPM, 1500.0)
            found.most("joint_angles", where, np.degrees(beta), np.interp(n, rpm, rpm * table) / n)
            found.most("joint_angles", where, np.degrees(beta), 6.0)
            found.least("joint_angles", where, np.degrees(beta), 0.5)
    both = all(joint.kind == "cross" for joint in line.joints)
    if line.application == "vehicle" and line.count == 2 and both:
        apart = line.fork_phases[1] - line.fork_phases[0]
        if abs(np.cos(apart)) < 1e-6:
            gap = abs(np.diff(line.joint_angles)[0])
            found.most("joint_angles", line.shaft_names[1], gap, np.radians(1.0))


def differences(line: DriveLine, own: Judged) -> Iterator[str]:
    """Yield where a verdict and the own one differ."""
    verdict = line.verdict()
    theirs = {
        (row.rule, "" if row.rule == "bending_speed" else row.where) for row in verdict.failed
    }
    for key in sorted((own.failed ^ theirs) - own.close):
        yield f"{key} {'passed' if key in own.failed else 'failed'} by the verdict alone"
    if not own.close and verdict.passed != (not own.failed):
        yield f"passed is {verdict.passed}"


def ask(seed: int) -> tuple[list[str], list[str]]:
    """Return where a verdict and the own one differ, and what the line came to."""
    try:
        line, worst = draw(seed)
    except Exception as error:  # A line that cannot be put together.
        return [], [f"cannot be built: {type(error).__name__}"]
    own = judged(line, worst)
    return list(differences(line, own)), ["fails" if own.failed else "passes"]
