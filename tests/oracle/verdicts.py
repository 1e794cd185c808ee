"""Verdicts recomputed: random drive lines, and what an engineer would fail them for.

Motion follows from pins that are turned by hand, forces from the equilibrium of all bodies in every
single load case, bending from an own beam, all other rules from their formulas. Only data of lines
are shared. Every row of a force, torque or stress is held against the greatest of all cases, and
every row that is open against what the data and the rank of the balances leave open.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from line_equilibrium import Equilibrium
from scipy.linalg import eigh, null_space
from testkit.line_statics import pins

from cardan_dyn import CardanError
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
from cardan_dyn.practice.drive_lines.line.supports import supports

Array = np.ndarray
RPM, HOUR = np.pi / 30, 3600.0
CLOSE = 1e-4
"""Distance to a limit, relative to it, within which positions 0.12° apart decide nothing."""


class Judged:
    """Values against limits: which fail, and which are too close to tell."""

    def __init__(self) -> None:
        self.failed: set[tuple[str, str]] = set()
        self.close: set[tuple[str, str]] = set()
        self.open: set[tuple[str, str]] = set()

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


class Worst(NamedTuple):
    """Greatest forces over all load cases, and which of them balances leave open."""

    sizes: dict[tuple[str, str], float]
    loose: set[tuple[str, str]]


def draw(seed: int) -> tuple[DriveLine, Worst]:
    """A random line whose limits are near what it has to bear, and its greatest forces."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 5))
    # Of a part of all lines everything is known; of another part bearings hold too much.
    told, tight = rng.random() < 0.4, rng.random() < 0.15
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
        if heavy and (told or rng.random() < 0.9):
            fields["tube"] = Tube(
                outer_diameter=rng.uniform(0.05, 0.1),
                wall=rng.uniform(0.003, 0.006),
                shear_limit=rng.uniform(4e7, 2e8) if told or rng.random() < 0.9 else None,
            )
        if k in (0, count):
            near = rng.uniform(0.05, 0.15)
            far = near + rng.uniform(0.1, 0.4)
            fields["bearings"] = [
                Bearing(name=f"{name}{k}", distance=at)
                for name, at in (("near", near), ("far", far))
            ]
            if tight and k == count and rng.random() < 0.5:
                fields["bearings"].append(Bearing(name="third", distance=far + 0.2))
            if rng.random() < 0.6 or told:
                fields |= {"mass": 20.0 * heavy, "inertia": rng.uniform(0.05, 2.0) * heavy}
        elif k == piece:
            del fields["slope_plan"], fields["slope_side"]
            fields |= {"length": 0.12, "centring": Centring(), "tube": None, "mass": 3.0 * heavy}
        else:
            fields["fork_offset"] = rng.choice([0.0, rng.uniform(-0.3, 0.3)])
            if k != free[-1]:
                bearing = Bearing(
                    name=f"centre{k}",
                    distance=rng.uniform(0.7, 0.95) * length,
                    stiffness=10 ** rng.uniform(5.5, 8) if told or rng.random() < 0.7 else None,
                )
                fields["bearings"] = [bearing]
            elif not (tight and rng.random() < 0.5):
                travel, pushed = rng.uniform(0.15, 0.3), length - rng.uniform(0.01, 0.1)
                fields["spline"] = Spline(
                    friction=rng.choice([0.0 if told else None, 0.0, 0.08, 0.15]),
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
            known = {"largest_speed": 400.0, "largest_n_beta": 100.0} if told else {}
            angle = rng.uniform(0.1, 0.5)
            joints.append(ShaftJoint(kind="constant_velocity", largest_angle=angle, **known))
            continue
        joints.append(
            ShaftJoint(
                largest_angle=0.5 if told else rng.choice([None, rng.uniform(0.1, 0.5)]),
                largest_speed=400.0 if told else rng.choice([None, rng.uniform(80, 400)]),
                largest_n_beta=100.0 if told else rng.choice([None, rng.uniform(11, 110)]),
                rated_torque=9e3 if told else rng.choice([None, None, rng.uniform(1000, 6000)]),
                capacity=None if told else rng.choice([None, None, 10 ** rng.uniform(-3, 0)]),
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
    return with_limits(line, worst.sizes, rng, told), worst


def with_limits(
    line: DriveLine, worst: dict[tuple[str, str], float], rng: np.random.Generator, told: bool
) -> DriveLine:
    """The line with limits of forces and torques a little above or below what it has."""

    def near(value: float) -> float | None:
        if not told and (rng.random() < 0.2 or value < 1e-3):
            return None
        return float(max(value, 1.0) * (rng.uniform(1.01, 3.0) if rng.random() < 0.97 else 0.8))

    shafts = []
    for shaft in line.shafts:
        bearings = [
            dataclasses.replace(
                item,
                radial_limit=near(worst["across", item.name]),
                axial_limit=near(worst.get(("along", item.name), 0.0)),
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
            torque_limit=near(worst["size", str(k)]),
            pulsating_limit=near(worst["size", str(k)]),
            reversing_limit=near(worst["size", str(k)]),
        )
        for k, joint in enumerate(line.joints)
    ]
    return line.replace(shafts=shafts, joints=joints)


def points(line: DriveLine) -> list[tuple[float, float]]:
    """Speeds and torques at which the line runs."""
    found = [] if line.speed is None else [(abs(line.speed), line.torque)]
    return found + [(abs(point.speed), point.torque) for point in line.duty_cycle]


def worst_forces(line: DriveLine) -> Worst:
    """Greatest forces of all load cases, each by the equilibrium of all bodies."""
    bodies = Equilibrium(line)
    parts, axes = bodies.courses(), line.geometry.directions
    shock, most = line.service_factor or 1.0, line.acceleration or 0.0
    found: dict[tuple[str, str], float] = {}
    cases = {
        case
        for speed, torque in points(line)
        for case in itertools.product(
            {torque * shock, 0.0} | ({-torque * shock} if line.reversing else set()),
            {speed, 0.0},
            {most, -most},
            (1.0, -1.0),
        )
    }
    for torque, speed, rate, sense in cases:
        acting = {"torque": torque, "speed": speed**2, "rate": rate, "weight": 1.0}

        def total(key: tuple[str, str], acting: dict[str, float] = acting) -> Array:
            return sum(factor * parts[name][key] for name, factor in acting.items())

        pushes = {}
        for k in bodies.slides:
            spline = line.shafts[k].spline
            torsion = total(("spline moment", str(k))) @ axes[k]
            pushes[k] = sense * spline.friction / spline.radius * np.abs(torsion)
            most_of(found, ("friction", line.shaft_names[k]), np.abs(pushes[k]))
        for key in parts["torque"]:
            if key[0] in ("across", "along", "centring"):
                course = total(key)
                for k, push in pushes.items():
                    course = course + push[:, None] * parts[f"push {k}"][key]
                most_of(found, key, np.linalg.norm(course, axis=1))
        ends = [total(("drive", "")) @ axes[0]]
        for k in range(line.count):
            sides = ("even", "even") if line.even[k] else ("in", "out")
            before, behind = (
                total((f"{side} moment", str(k))) @ axes[k + i] for i, side in enumerate(sides)
            )
            ends += [before, behind]
            most_of(found, ("ahead", str(k)), np.concatenate([before, behind]))
            most_of(found, ("back", str(k)), -np.concatenate([before, behind]))
            found["size", str(k)] = max(found["ahead", str(k)], found["back", str(k)])
        ends.append(total(("load", "")) @ axes[-1])
        for k in range(line.count + 1):
            most_of(found, ("shaft", str(k)), np.abs(ends[2 * k : 2 * k + 2]))
    for speed, torque in points(line):
        acting = {"torque": torque, "speed": speed**2, "weight": 1.0}
        for k in range(line.count):
            sides = ("even", "even") if line.even[k] else ("in", "out")
            means = []
            for i, side in enumerate(sides):
                key = (f"{side} moment", str(k))
                course = sum(factor * parts[name][key] for name, factor in acting.items())
                means.append(np.mean(np.abs(course @ axes[k + i]) ** (10 / 3)))
            found["worn", f"{k} {speed} {torque}"] = float(min(means)) ** 0.3
    loose = set()
    if not bodies.is_decided:
        _, values, vectors = np.linalg.svd(bodies.matrix[1])
        rank = int(np.sum(values > 1e-9 * values[0]))
        free = np.abs(vectors[rank:]).max(axis=0)
        loose = {key for (key, _), size in zip(bodies.columns, free, strict=True) if size > 1e-9}
    return Worst(found, loose)


def most_of(found: dict[tuple[str, str], float], key: tuple[str, str], course: Array) -> None:
    """Keep the greatest value of a course, 0 at least."""
    found[key] = max(found.get(key, 0.0), float(np.max(course)))


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


def critical(line: DriveLine) -> list[float] | None:
    """Critical bending speeds of shafts, by own beams with stiff springs for rigid supports.

    That of a shaft is the lowest at which more is stored in tubes than in springs, and no less in
    its own than in the others in the mean.
    """
    inner = [k for k in range(1, line.count) if line.shafts[k].centring is None]
    if not inner or any(line.shafts[k].tube is None for k in inner):
        return None
    nodes = 40
    size = sum(2 * nodes for _ in inner)
    K, M = np.zeros((size, size)), np.zeros((size, size))
    rigid = 1e13
    ends, tubes = [], np.zeros((len(inner), size, size))
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
            tubes[i, at, at] += bend / h**3 * c
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
    squares, modes = eigh(K + tubes.sum(axis=0), M)
    stored = np.array([np.diag(modes.T @ own @ modes) for own in tubes])
    bends = 2.0 * stored.sum(axis=0) >= squares
    own = stored >= (1.0 - 1e-9) * stored.mean(axis=0)
    return [float(np.sqrt(squares[np.flatnonzero(bends & part)[0]])) for part in own]


def judged(line: DriveLine, worst: Worst) -> Judged:
    """What fails and what is open, by rule and place."""
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
        if joint.largest_angle is None:
            found.open.add(("joint_angles", where))
        if not joint.size and None in (joint.largest_speed, joint.largest_n_beta):
            found.open.add(("n_beta", where))
        if joint.kind != "cross":
            continue
        if joint.rated_torque is None and joint.capacity is None:
            found.open.add(("joint_life", where))
        cycle = [(p.share, abs(p.speed), p.torque) for p in line.duty_cycle]
        cycle = cycle or [(1.0, abs(line.speed or 0.0), line.torque or 0.0)]
        cycle = [(q, n, worst.sizes["worn", f"{k} {n} {t}"]) for q, n, t in cycle]
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
    _torsion(line, found, running)
    speed = critical(line)
    inner = [k for k in range(1, line.count) if line.shafts[k].centring is None]
    if inner and speed is None:
        found.open.add(("bending_speed", ""))
    for k in (0, line.count):
        if line.shafts[k].tube is not None:
            _bends(line, found, running, end_critical(line, k))
    soft = [item.stiffness for k in inner for item in line.shafts[k].bearings]
    for k in range(1, line.count):
        if line.shafts[k].tube is None and not line.shafts[k].mass:
            found.open.add(("balancing", line.shaft_names[k]))
    if speed is not None:
        for own in speed:
            _bends(line, found, running, own)
        if None in soft:
            found.open.add(("bending_speed", ""))
    return found


def _bends(
    line: DriveLine, found: Judged, running: list[tuple[float, float]], speed: float
) -> None:
    share = {"industrial": 0.65, "vehicle": 0.7}.get(line.application, 0.75)
    found.most("bending_speed", "", max(n for n, _ in running) / speed, share)
    uneven = [b for b, j in zip(line.joint_angles, line.joints, strict=True) if j.kind == "cross"]
    if max(uneven, default=0.0) >= np.radians(3.0):
        found.least("bending_speed", "", min(abs(n / speed - 0.5) for n, _ in running), 0.08)


def end_critical(line: DriveLine, k: int) -> float:
    """Critical bending speed of an end shaft on rigid bearings, by polynomials that are 0 there."""
    shaft, tube = line.shafts[k], line.shafts[k].tube
    length = float(line.geometry.lengths[k])
    D, d = tube.outer_diameter, tube.inner_diameter
    bend = 2.1e11 * np.pi / 64 * (D**4 - d**4)
    heavy = 7850 * np.pi / 4 * (D**2 - d**2) if shaft.mass is None else shaft.mass / length
    points, weights = np.polynomial.legendre.leggauss(60)
    shapes = [np.polynomial.Legendre.basis(n) for n in range(40)]
    values, curved, held = (
        np.array([of(shape) for shape in shapes])
        for of in (
            lambda shape: shape(points),
            lambda shape: shape.deriv(2)(points) * 4 / length**2,
            lambda shape: shape(2 * np.array([b.distance for b in shaft.bearings]) / length - 1),
        )
    )
    joint = line.joints[0 if k == 0 else -1].cross_mass * np.outer(*[[s(-1.0) for s in shapes]] * 2)
    M = heavy * (values * weights) @ values.T * length / 2 + joint
    K = bend * (curved * weights) @ curved.T * length / 2
    free = null_space(held.T)
    return float(np.sqrt(eigh(free.T @ K @ free, free.T @ M @ free, eigvals_only=True)[0]))


def _torsion(line: DriveLine, found: Judged, running: list[tuple[float, float]]) -> None:
    """Orders 2 and 4 of all inertias, and the first zone in which they may shake themselves up."""
    uneven = [b for b, j in zip(line.joint_angles, line.joints, strict=True) if j.kind == "cross"]
    if not uneven:
        return
    ends = [line.shafts[k].inertia for k in (0, -1)]
    inner = [k for k in range(1, line.count) if line.shafts[k].centring is None]
    springs = [k for k in range(line.count + 1) if line.shafts[k].tube is not None]
    if not all(ends) or not springs or not {*inner} <= {*springs}:
        found.open.add(("torsional_speed", ""))
        return
    # By how much the line up to a place twists under a unit torque, and the inertia there.
    twist, at = 0.0, [(0.0, ends[0])]
    for k, shaft in enumerate(line.shafts):
        length, own, soft = float(line.geometry.lengths[k]), 0.0, 0.0
        if shaft.tube is not None:
            D, d = shaft.tube.outer_diameter, shaft.tube.inner_diameter
            soft = length * 32 / (8.08e10 * np.pi * (D**4 - d**4))
            mass = 7850 * np.pi / 4 * (D**2 - d**2) * length if shaft.mass is None else shaft.mass
            own = mass * (D**2 + d**2) / 8 * (0 < k < line.count)
        if k > 0:
            cross = line.joints[k - 1]
            at.append((twist, cross.cross_mass * cross.cross_span**2 / 12))
        at.append((twist + soft / 2, own))
        twist += soft
    at.append((twist, ends[1]))
    places = sorted({place for place, inertia in at if inertia})
    J = np.array([sum(inertia for place, inertia in at if place == one) for one in places])
    c = 1 / np.diff(places)
    K = np.diag([*c, 0.0]) + np.diag([0.0, *c]) - np.diag(c, 1) - np.diag(c, -1)
    modes = np.sqrt(eigh(K, np.diag(J), eigvals_only=True)[1:])
    half = (1 - J[0] / J.sum()) * max(uneven) ** 2 / 4
    for natural in modes:
        for order in (2, 4):
            gap = min(abs(n * order / natural - 1) for n, _ in running)
            found.least("torsional_speed", "", gap, 0.1)
        for n, _ in running:
            found.least("torsional_speed", "", abs(n / natural - 1), half)


def _forces(line: DriveLine, found: Judged, worst: Worst) -> None:
    sizes = worst.sizes
    unknown = any(s.spline is not None and s.spline.friction is None for s in line.shafts)
    held = [
        ("bearing_forces", support.name, way, limit)
        for support, item in zip(supports(line).bearings, line.bearings, strict=True)
        for way, limit in (("across", item.radial_limit), ("along", item.axial_limit))
    ]
    held += [
        ("centred_double_joint", line.shaft_names[k], "centring", kind.force_limit)
        for k in line.centred
        if (kind := line.shafts[k].centring)
    ]
    for rule, name, way, limit in held:
        size = sizes.get((way, name), 0.0)
        if limit is None:
            if (way, name) in sizes:  # Of bearings that are not locating there is none along.
                found.open.add((rule, name))
        elif (way, name) in worst.loose:
            found.open.add((rule, name))
        else:
            found.most(rule, name, size, limit)
            if unknown and size <= limit:
                found.open.add((rule, name))
    if unknown:
        splines = (k for k, s in enumerate(line.shafts) if s.spline and s.spline.friction is None)
        found.open |= {("axial_force", line.shaft_names[k]) for k in splines}
    for k, (joint, name) in enumerate(zip(line.joints, line.joint_names, strict=True)):
        found.most("static_ratings", name, sizes["size", str(k)], joint.torque_limit)
        if joint.torque_limit is None:
            found.open.add(("static_ratings", name))
        _fatigue(joint, name, found, sizes["ahead", str(k)], sizes["back", str(k)])
    for k, shaft in enumerate(line.shafts):
        name = line.shaft_names[k]
        if shaft.tube is not None:
            found.most(
                "tube", name, stress(shaft.tube, sizes["shaft", str(k)]), shaft.tube.shear_limit
            )
        lacks = shaft.tube is None or shaft.tube.shear_limit is None
        inner = 0 < k < line.count and shaft.centring is None
        if lacks and (inner or shaft.tube is not None):
            found.open.add(("tube", name))


def stress(tube: Tube, torque: float) -> float:
    D, d = tube.outer_diameter, tube.outer_diameter - 2 * tube.wall
    return 16 * torque * D / (np.pi * (D**4 - d**4))


def _fatigue(joint: ShaftJoint, name: str, found: Judged, ahead: float, back: float) -> None:
    """Amplitude and mean of the torque in Haigh's diagram, between the points of both ratings."""
    most, least = max(ahead, back), min(ahead, back)
    amplitude, mean = (most + least) / 2, (most - least) / 2
    pulsating, reversing = joint.pulsating_limit, joint.reversing_limit
    rule = "static_ratings"
    if least <= 1e-9 * most:
        found.most(rule, name, most, pulsating)
        if pulsating is None:
            found.open.add((rule, name))
    elif reversing is not None:
        slope = 0.0 if pulsating is None else min(reversing / (pulsating / 2) - 1, 1.0)
        if pulsating is None:
            found.most(rule, name, most, reversing)
        elif reversing <= pulsating:
            found.most(rule, name, amplitude + slope * mean, reversing)
        else:
            found.most(rule, name, most, reversing)
    elif pulsating is None:
        found.open.add((rule, name))
    else:
        found.most(rule, name, most, pulsating)
        if most <= pulsating < 2 * amplitude:
            found.open.add((rule, name))


def _angles(line: DriveLine, found: Judged, fastest: float) -> None:
    first, second = derivatives(line)
    output = line.shaft_names[-1]
    residual = np.arccos(min(1.0, 1.0 / first[:, -1].max()))
    found.most("uniformity", output, residual, np.radians(3.0))
    found.most("accelerations", output, np.abs(second[:, -1]).max() * fastest**2, 300.0)
    between = [k for k in range(1, line.count) if k not in line.centred]
    if between:
        drive = np.abs(second[:, between].sum(axis=1)).max()
        one, two = first[:, -1:], second[:, -1:]
        coast = np.abs(((second * one - first * two) / one**3)[:, between].sum(axis=1)).max()
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
            found.least("joint_angles", where, np.degrees(beta), 0.5)
    both = all(joint.kind == "cross" for joint in line.joints)
    if line.application == "vehicle" and line.count == 2 and both:
        apart = line.fork_phases[1] - line.fork_phases[0]
        if abs(np.cos(apart)) < 1e-6:
            gap = abs(np.diff(line.joint_angles)[0])
            found.most("joint_angles", line.shaft_names[1], gap, np.radians(1.0))


def values(line: DriveLine, worst: Worst) -> Iterator[tuple[str, str, str, float]]:
    """Yield what rows of forces, torques and stresses have to say: rule, place, quantity, value."""
    sizes = worst.sizes
    for key, size in sizes.items():
        kind, name = key
        if key in worst.loose:
            continue
        if kind in ("across", "along"):
            yield "bearing_forces", name, f"force {kind} the shaft", size
        elif kind == "centring":
            yield "centred_double_joint", name, "force in the centring", size
        elif kind == "friction":
            yield "axial_force", name, "force of the sliding spline", size
        elif kind == "size":
            yield "static_ratings", line.joint_names[int(name)], "shock torque", size
        elif kind == "shaft" and line.shafts[int(name)].tube is not None:
            size = stress(line.shafts[int(name)].tube, size)
            yield "tube", line.shaft_names[int(name)], "shear stress up to T·K", size


def differences(line: DriveLine, own: Judged, worst: Worst) -> Iterator[str]:
    """Yield where a verdict and the own one differ."""
    verdict = line.verdict()

    def keys(rows: object) -> set[tuple[str, str]]:
        return {(row.rule, "" if row.rule == "bending_speed" else row.where) for row in rows}

    failed, opened = keys(verdict.failed), keys(verdict.open)
    for key in sorted((own.failed ^ failed) - own.close):
        yield f"{key} {'passed' if key in own.failed else 'failed'} by the verdict alone"
    for key in sorted((own.open ^ opened) - own.close):
        yield f"{key} {'not open' if key in own.open else 'open'} by the verdict alone"
    if not own.close and verdict.passed != (not own.failed and not own.open):
        yield f"passed is {verdict.passed}"
    told = {(row.rule, row.where, row.quantity): row.value for row in verdict}
    scale = max(size for (kind, _), size in worst.sizes.items() if kind in ("across", "along"))
    for rule, where, quantity, value in values(line, worst):
        shown, least = told.get((rule, where, quantity)), 1e-6 * scale * (rule != "tube")
        if shown is None and value > least:
            yield f"{rule} {where}: no {quantity}, {value}"
        elif shown is not None and not abs(shown - value) <= 1e-4 * value + least:
            yield f"{rule} {where}: {quantity} {shown}, own {value}"


def ask(seed: int) -> tuple[list[str], list[str]]:
    """Return where a verdict and the own one differ, and what the line came to."""
    try:
        line, worst = draw(seed)
    except CardanError as error:  # A line that cannot be put together.
        return [], [f"cannot be built: {type(error).__name__}"]
    own = judged(line, worst)
    outcome = "fails" if own.failed else "is open" if own.open else "passes"
    more = ["bearings hold too much"] if worst.loose else []
    return list(differences(line, own, worst)), [outcome, *more]
