"""Simulations that begin close to singular configurations, against motions in regular coordinates.

`python tests/oracle/near_singular.py 2000` runs many. Each either is within its tolerance of the
reference, or is refused, or has notes.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from testkit.simulated import (
    GRAVITY,
    integrated,
    link,
    parallelogram_law,
    parallelograms,
)

import cardan_dyn as cd

ALLOWED = 1e-6
"""Error, as a fraction of the motion, that is wrong if nothing is said of it; rtol is 1e-10."""


def turned(parts: str, tilt: np.ndarray) -> str:
    """A mechanism whose base stands obliquely in the world."""
    rpy = " ".join(repr(float(angle)) for angle in tilt)
    return (
        f'<robot name="m"><link name="world"/><link name="base"/><joint name="stand" type="fixed">'
        f'<parent link="world"/><child link="base"/><origin xyz="0.1 0.2 0" rpy="{rpy}"/></joint>'
        f"{parts}</robot>"
    )


def free_time(inertia, start: float, speed: float, end: float, count: int = 12):
    """Parameters at some times of a free motion with kinetic energy `inertia(p) p'^2 / 2`."""
    begun = inertia(start)
    times = np.linspace(0.0, end, count)
    found = solve_ivp(
        lambda t, p: [speed * math.sqrt(begun / inertia(float(p[0])))],
        (0.0, end),
        [start],
        "DOP853",
        times,
        rtol=3e-14,
        atol=1e-15,
    )
    return times, found.y[0]


def rods(bend: float, a: float, b: float, tilt: np.ndarray) -> tuple[cd.Mechanism, float]:
    """Two rods `bend` from in line along x, whose end slides along y; the second one's angle."""
    other = -math.asin(a * math.sin(bend) / b)
    reach = a * math.cos(bend) + b * math.cos(other)
    text = f"""{link("one", (a / 2, 0))}{link("two", (b / 2, 0))}{link("slider", (0, 0), 2.0)}
    <joint name="A" type="continuous"><parent link="base"/><child link="one"/>
    <origin rpy="0 0 {bend!r}"/><axis xyz="0 0 1"/></joint>
    <joint name="B" type="continuous"><parent link="one"/><child link="two"/>
    <origin xyz="{a!r} 0 0" rpy="0 0 {other - bend!r}"/><axis xyz="0 0 1"/></joint>
    <joint name="S" type="prismatic"><parent link="base"/><child link="slider"/>
    <origin xyz="{reach!r} 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
    <loop name="C" type="continuous"><predecessor link="two"><origin xyz="{b!r} 0 0"/>
    </predecessor><successor link="slider"/><axis xyz="0 0 1"/></loop>"""
    return cd.load(turned(text, tilt)), other


def rods_error(bend: float, a: float, b: float, tilt: np.ndarray) -> tuple[float, cd.Trajectory]:
    """Greatest error of the first rod's angle, as a fraction of its bend.

    Both angles lie on an oval: 2 a sin² θ₁/2 = c sin² ψ and 2 b sin² θ₂/2 = c cos² ψ.
    """
    mechanism, other = rods(bend, a, b, tilt)
    c = 2 * a * math.sin(bend / 2) ** 2 + 2 * b * math.sin(other / 2) ** 2
    p, q = math.sqrt(c / (2 * a)), math.sqrt(c / (2 * b))
    start = math.atan2(math.sin(bend / 2) / p, math.sin(other / 2) / q)

    def slopes(psi: float) -> tuple[float, float, float, float]:
        s, t = p * math.sin(psi), q * math.cos(psi)
        one = 2 * p * math.cos(psi) / math.sqrt(1 - s * s)
        two = -2 * q * math.sin(psi) / math.sqrt(1 - t * t)
        return 2 * math.asin(s), 2 * math.asin(t), one, two

    def inertia(psi: float) -> float:
        x, y, one, two = slopes(psi)
        centre = (a * one) ** 2 + (b / 2 * two) ** 2 + a * b * one * two * math.cos(x - y)
        slide = a * math.cos(x) * one + b * math.cos(y) * two
        return (0.1 + a * a / 4) * one**2 + 0.1 * two**2 + centre + 2.0 * slide**2

    end = 10.0 * abs(bend)
    times, psi = free_time(inertia, start, 1.0 / slopes(start)[2], end)
    moved = cd.Scene(mechanism, drive="A").simulate(end, speed=1.0, method="DOP853")
    found = moved.at(times).position + bend
    expected = np.array([slopes(float(item))[0] for item in psi])
    return float(np.max(np.abs(found - expected)) / abs(bend)), moved


def bars(a: float, g: float, c: float, u: float, w: float, tilt: np.ndarray) -> cd.Mechanism:
    """A four-bar with equal cranks a at u + w and u - w to the base g, and coupler c."""
    one, two = u + w, u - w
    across = math.atan2(
        a * (math.sin(two) - math.sin(one)), g + a * (math.cos(two) - math.cos(one))
    )
    text = f"""{link("one", (a / 2, 0))}{link("two", (a / 2, 0))}{link("bar", (c / 2, 0))}
    <joint name="A" type="continuous"><parent link="base"/><child link="one"/>
    <origin rpy="0 0 {one!r}"/><axis xyz="0 0 1"/></joint>
    <joint name="D" type="continuous"><parent link="base"/><child link="two"/>
    <origin xyz="{g!r} 0 0" rpy="0 0 {two!r}"/><axis xyz="0 0 1"/></joint>
    <joint name="B" type="continuous"><parent link="one"/><child link="bar"/>
    <origin xyz="{a!r} 0 0" rpy="0 0 {across - one!r}"/><axis xyz="0 0 1"/></joint>
    <loop name="C" type="continuous"><predecessor link="bar"><origin xyz="{c!r} 0 0"/>
    </predecessor><successor link="two"><origin xyz="{a!r} 0 0"/></successor>
    <axis xyz="0 0 1"/></loop>"""
    return cd.load(turned(text, tilt))


def bars_error(
    off: float, a: float, g: float, along: float, sign: float, tilt: np.ndarray
) -> tuple[float, cd.Trajectory]:
    """Greatest error of the first crank's angle where a parallelogram's coupler is too long by off.

    With S = sin w and X = a S + g sin u, the loop is closed where S X = K: it misses the
    configuration in line, S = X = 0, and turns from one assembly mode to the other.
    """
    c = g * math.sqrt(1.0 + off)
    k = g * g * off / (4 * a)
    size = math.sqrt(abs(k))

    def state(p: float) -> tuple[float, float, float, float, float, float]:
        p = max(math.log(size), min(p, -math.log(size)))  # Steps that are tried may lead too far.
        s, x = size * math.exp(p), math.copysign(size, k) * math.exp(-p)
        u = math.asin(max(-0.99, min((x - a * s) / g, 0.99)))
        w = math.asin(max(-0.99, min(s, 0.99)))
        return s, x, u, w, (-x - a * s) / (g * math.cos(u)), s / math.cos(w)

    def inertia(p: float) -> float:
        s, _, u, w, du, dw = state(p)
        one, two = du + dw, du - dw
        bar = np.array([g + 2 * a * s * math.sin(u), -2 * a * s * math.cos(u)])
        turn = (
            2
            * a
            * np.array(
                [s * math.sin(u) + s * math.cos(u) * du, -s * math.cos(u) + s * math.sin(u) * du]
            )
        )
        spin = (bar[0] * turn[1] - bar[1] * turn[0]) / float(bar @ bar)
        centre = a * one * np.array([-math.sin(u + w), math.cos(u + w)]) + turn / 2
        pins = (0.1 + a * a / 4) * (one**2 + two**2)
        return float(pins + centre @ centre + 0.1 * spin**2)

    start = math.log(size / along)
    _, _, u, w, du, dw = state(start)
    rate = sign / abs(du + dw)
    mechanism = bars(a, g, c, u, w, tilt)
    speed = rate * (du + dw)
    end = 2.0 * along if sign > 0 else 0.3
    times, found = free_time(inertia, start, rate, end)
    moved = cd.Scene(mechanism, drive="A").simulate(end, speed=speed, method="DOP853")
    expected = np.array([state(float(p))[2] + state(float(p))[3] for p in found]) - (u + w)
    return float(np.max(np.abs(moved.at(times).position - expected)) / end), moved


def flat_error(count: int, before: float, speed: float, end: float) -> tuple[float, cd.Trajectory]:
    """Greatest error of parallelograms that begin a little before all bars are in line."""
    inertia, weight = parallelogram_law(count)
    start = 0.5 * math.pi - before
    scene = cd.Scene(parallelograms(count), drive="pin_0", gravity=GRAVITY)
    moved = scene.simulate(end, position=start, speed=speed)
    times = np.linspace(0.0, end, 12)
    law = integrated(lambda t, x, v: weight * np.sin(x) / inertia, start, speed, times)
    return float(np.max(np.abs(moved.at(times).position - law[0]))), moved


def case(seed: int) -> tuple[str, float, str]:
    """Run one; return what it was, its error, and what was said of it."""
    random = np.random.default_rng(seed)
    near = 10.0 ** random.uniform(-9.0, -2.0)
    tilt = random.uniform(-3.0, 3.0, 3) * (random.random() < 0.7)
    kind = ("rods", "bars", "flat")[seed % 3]
    text = f"{kind} {near:.1e}"
    try:
        if kind == "rods":
            error, moved = rods_error(near, *random.uniform(0.3, 2.0, 2).tolist(), tilt)
        elif kind == "bars":
            a, g = float(random.uniform(0.3, 1.0)), float(random.uniform(1.1, 2.0))
            off = random.choice([-1.0, 1.0]) * 10.0 ** random.uniform(-14.0, -3.0)
            along = max(near, 3.0 * math.sqrt(abs(off)))
            sign = random.choice([-1.0, 1.0])
            text += f" off {off:.1e} along {along:.1e} {sign:+.0f}"
            error, moved = bars_error(off, a, g, along, sign, tilt)
        else:
            before = near
            speed = random.choice([-1.0, 1.0]) * 10.0 ** random.uniform(-1.0, 1.0)
            count = int(random.integers(1, 4))
            text += f" {count} before {before:+.1e} speed {speed:.2f}"
            error, moved = flat_error(count, before, speed, min(1.0, 1.5 / abs(speed)))
    except cd.CardanError as refused:
        return text, 0.0, f"{type(refused).__name__}: {refused}"
    return text, error, "; ".join(moved.notes)


def is_wrong(error: float, said: str) -> bool:
    """Whether a simulation is wrong and nothing was said of it."""
    return not error <= ALLOWED and not said


if __name__ == "__main__":
    first, last = (0, int(sys.argv[1])) if len(sys.argv) == 2 else map(int, sys.argv[1:3])
    wrong = refused = noted = 0
    for number in range(first, last):
        what, off_by, words = case(number)
        refused += ":" in words[:40] and "Error" in words[:40]
        noted += bool(words)
        if is_wrong(off_by, words):
            wrong += 1
            print(f"WRONG {number}: {what}: {off_by:.1e}", flush=True)
    print(f"{last - first} cases: {wrong} wrong, {refused} refused, {noted - refused} with notes")
