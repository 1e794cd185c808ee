"""Reports of 3 to 40 samples against closed forms of whole ranges, evaluated densely.

Slider-cranks (driven by the crank, with inertia, load and friction; or by the piston, near a dead
point) and universal joints up to 85° have formulas of their own here, which share nothing with the
package. A report tells their greatest and least values to a millionth; where a speed or a load
differs from sample to sample, it says that it cannot.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from testkit.simulated import joint, link

import cardan_dyn as cd

Array = np.ndarray
RIGHT = 1e-6
"""Part of the size of a quantity that a report may be off without a word."""
COARSE, PEAKS, FINE = 20_001, 8, 501
"""Positions of a range, how many peaks among them are looked at more closely, and positions of two
steps on both sides of each, three times."""


class Case(NamedTuple):
    """What is reported.

    Attributes:
        sweep: of few samples.
        low, high: range that they stand for.
        told: owners and quantities, and their formulas over the position.
        varies: whether something differs from sample to sample.
        features: what it is made of.
    """

    sweep: cd.Sweep
    low: float
    high: float
    told: Mapping[tuple[str, str], Callable[[Array], Array]]
    varies: bool
    features: list[str]


def greatest(formula: Callable[[Array], Array], low: float, high: float) -> float:
    """Return the greatest value of a formula between two positions."""
    # Friction changes its sign within 1e-6 rad of dead points, wherever a turn has them.
    beside = np.geomspace(1e-8, 0.1, 400)
    ends = np.pi * np.arange(np.floor(low / np.pi), np.ceil(high / np.pi) + 1)
    close = np.add.outer(ends, np.concatenate([-beside, beside])).ravel()
    positions = np.sort(np.concatenate([np.linspace(low, high, COARSE), close]))
    positions = positions[(positions >= low) & (positions <= high)]
    values = formula(positions)
    beside = np.concatenate([[-np.inf], values, [-np.inf]])
    peaks = np.flatnonzero((values >= beside[:-2]) & (values >= beside[2:]))
    best = -np.inf
    # What is a peak between positions may be less than another one at them.
    for index in peaks[np.argsort(-values[peaks])][:PEAKS]:
        at, of = positions, values
        for _ in range(3):
            first, last = max(index - 2, 0), min(index + 2, len(at) - 1)
            at = np.linspace(at[first], at[last], FINE)
            of = formula(at)
            index = int(of.argmax())
        best = max(best, float(of[index]))
    return best


def _slider(crank: float, rod: float, centre: float, mass: float, inertia: float, piston: float):
    loop = (
        '<loop name="pin" type="continuous"><predecessor link="rod">'
        f'<origin xyz="{rod!r} 0 0"/></predecessor><successor link="piston"/>'
        '<axis xyz="0 0 1"/></loop>'
    )
    guide = joint("guide", "base", "piston", (crank + rod, 0.0)).replace("continuous", "prismatic")
    guide = guide.replace(
        '<axis xyz="0 0 1"/>',
        '<axis xyz="1 0 0"/><limit lower="-9" upper="9" effort="0" velocity="0"/>',
    )
    parts = [
        '<link name="base"/>',
        link("crank", (0.0, 0.0)),
        link("rod", (centre, 0.0), mass, inertia),
        link("piston", (0.0, 0.0), piston),
        joint("main", "base", "crank"),
        joint("big_end", "crank", "rod", (crank, 0.0)),
        guide,
        loop,
    ]
    return cd.load(f'<robot name="slider">{"".join(parts)}</robot>')


def _positions(rng: np.random.Generator) -> tuple[Array, float, float]:
    """Return few positions of a turn or a part of it, and the range that they stand for."""
    count, start = int(rng.integers(3, 41)), float(rng.uniform(-3.0, 3.0))
    way = 2.0 * np.pi if rng.random() < 0.6 else float(rng.uniform(0.3, 5.5))
    at = np.linspace(start, start + way, count)
    if rng.random() < 0.2:
        at[1:-1] = np.sort(rng.uniform(start, start + way, count - 2))
    return rng.permutation(at) if rng.random() < 0.2 else at, start, start + way


def crank_driven(rng: np.random.Generator) -> Case:
    """A crank at constant speed: Newton's equations of piston and rod, one after the other."""
    r = float(rng.uniform(0.02, 0.1))
    rod_length = r * (1.0 + float(10.0 ** rng.uniform(-2.0, 0.5)))
    c, m, p = (
        rod_length * float(rng.uniform(0.2, 0.6)),
        float(rng.uniform(0.1, 2)),
        float(rng.uniform(0.1, 3)),
    )
    inertia = m * rod_length * rod_length * float(rng.uniform(0.04, 0.12))
    speed, load = float(rng.uniform(5, 300)), float(rng.choice([0.0, rng.uniform(-500, 500)]))
    rub = float(rng.uniform(1, 50)) if rng.random() < 0.3 else 0.0
    changes = 1e-3 * float(rng.uniform(1, 100))

    def rod(x: Array) -> tuple[Array, ...]:
        sine = -r / rod_length * np.sin(x)
        cosine = np.sqrt(1.0 - sine**2)
        rate = -r * np.cos(x) / (rod_length * cosine)
        return sine, cosine, rate, (r / rod_length * np.sin(x) + sine * rate**2) / cosine

    def forces(x: Array) -> tuple[Array, ...]:
        sine, cosine, rate, change = rod(x)
        slide = speed * (-r * np.sin(x) - rod_length * sine * rate)
        thrust = p * speed**2 * (-r * np.cos(x) - rod_length * (cosine * rate**2 + sine * change))
        thrust += rub * slide / np.sqrt(slide**2 + changes**2) - load
        ax = speed**2 * (-r * np.cos(x) - c * (cosine * rate**2 + sine * change))
        ay = speed**2 * (-r * np.sin(x) - c * (sine * rate**2 - cosine * change))
        turning = inertia * change * speed**2 + c * m * (cosine * ay - sine * ax)
        side = (sine * thrust - turning / rod_length) / cosine
        return thrust, side, m * ax + thrust, m * ay + side

    scene = cd.Scene(
        _slider(r, rod_length, c, m, inertia, p),
        drive="main",
        loads={"guide": load},
        elements=[cd.JointFriction("guide", rub, changes)] if rub else None,
    )
    at, low, high = _positions(rng)
    varies = rng.random() < 0.1
    speeds = speed * np.linspace(1.0, 1.5, len(at)) if varies else speed
    told = {
        ("pin", "shear"): lambda x: np.hypot(*forces(x)[:2]),
        ("guide", "shear"): lambda x: np.abs(forces(x)[1]),
        ("big_end", "shear"): lambda x: np.hypot(*forces(x)[2:]),
        ("main", "drive effort"): lambda x: (
            r * (np.cos(x) * forces(x)[3] - np.sin(x) * forces(x)[2])
        ),
    }
    features = ["crank", *["friction"] * bool(rub), *["speeds differ"] * varies]
    return Case(scene.sweep(at, speed=speeds), low, high, told, varies, features)


def piston_driven(rng: np.random.Generator) -> Case:
    """A piston at rest near a dead point: the torque at the crank by its lever at the rod."""
    r = float(rng.uniform(0.02, 0.1))
    rod_length = r * float(rng.uniform(1.5, 4.0))
    torque = float(rng.uniform(1, 100))
    near, far = float(10.0 ** rng.uniform(-6, -1)), float(rng.uniform(0.2, 0.9))
    # The slide counts from where rod and crank are stretched.
    start = r * np.cos(1.0) + np.sqrt(rod_length**2 - (r * np.sin(1.0)) ** 2) - r - rod_length
    scene = cd.Scene(
        _slider(r, rod_length, 0.3 * rod_length, 1.0, 0.01, 1.0),
        drive="guide",
        loads={"main": -torque},
        near={"main": 1.0, "guide": float(start)},
    )

    def lever(slide: Array) -> Array:
        whole = r + rod_length + slide
        angle = np.arccos((r * r + whole**2 - rod_length * rod_length) / (2.0 * r * whole))
        return r * np.sin(angle + np.arcsin(r / rod_length * np.sin(angle)))

    low, high = -2.0 * r * far, -2.0 * r * near
    at = np.linspace(low, high, int(rng.integers(3, 41)))
    told = {("pin", "shear"): lambda x: torque / lever(x)}
    return Case(scene.sweep(at), low, high, told, False, ["piston"])


def cross(rng: np.random.Generator) -> Case:
    """A universal joint: its closed forms (torsion and bending of the input shaft)."""
    beta = float(np.radians(rng.uniform(1.0, 85.0)))
    scene = cd.Scene(
        cd.load("universal_joint"),
        drive="bearing_in",
        held={"joint_angle": beta},
        loads={"bearing_out": -100.0},
    )

    def torsion(x: Array) -> Array:
        return 100.0 * np.cos(beta) / (1.0 - (np.sin(beta) * np.cos(x)) ** 2)

    at, low, high = _positions(rng)
    varies = rng.random() < 0.1
    loads = {"bearing_out": -100.0 * np.linspace(1.0, 0.5, len(at))} if varies else None
    told = {
        ("bearing_in", "torsion"): torsion,
        ("bearing_in", "bending"): lambda x: torsion(x) * np.tan(beta) * np.abs(np.sin(x)),
        ("bearing_in", "drive effort"): torsion,
    }
    features = ["cross", *["loads differ"] * varies]
    return Case(scene.sweep(at, loads=loads), low, high, told, varies, features)


def draw(seed: int) -> Case:
    """Return the case of a seed."""
    rng = np.random.default_rng(seed)
    kinds = crank_driven, piston_driven, cross
    return kinds[int(rng.choice(3, p=[0.5, 0.2, 0.3]))](rng)


def ask(seed: int) -> tuple[list[str], list[str]]:
    """Return what is wrong with the report of a seed, and what was counted."""
    case = draw(seed)
    report = cd.Report(case.sweep)
    found = {(item.owner, item.quantity): item for item in report.extremes}
    wrong, counted = [], list(case.features)
    for key, formula in case.told.items():
        item = found[key]
        counted += ["extremes", *["in doubt"] * (not item.settled)]
        if case.varies:
            told = "samples, as " in report.covered and "from sample to sample" in report.covered
            if report.is_exact or not told:
                wrong.append(f"{key} is sure of what differs from sample to sample")
            continue
        ends = {
            "greatest": (item.greatest, greatest(formula, case.low, case.high)),
            "least": (item.least, -greatest(lambda x, of=formula: -of(x), case.low, case.high)),
        }
        size = max(abs(value) for _, value in ends.values())
        for name, (value, expected) in ends.items():
            if abs(value - expected) > RIGHT * size:
                wrong.append(f"{key} {name} {value} not {expected}, settled: {item.settled}")
        # Nothing varies here, so that nothing is in doubt.
        if not item.settled:
            wrong.append(f"{key} does not settle: {item.error}")
    return wrong, counted
