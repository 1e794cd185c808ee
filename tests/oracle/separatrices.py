"""Motions close to separatrices, of bodies on pins and of linkages with one freedom.

Pendulums, geared pendulums and trammels obey θ̈ = -ω² sin θ, by elliptic functions of mpmath;
slider-cranks with a spring are held against the time integral of their own kinetic energy.
"""

from __future__ import annotations

import re
from typing import NamedTuple

import mpmath as mp
import numpy as np
from testkit.simulated import joint, link

import cardan_dyn as cd

Array = np.ndarray
G = 9.81
EXACT, STEPS = 1e-9, 2e-5
"""Errors [rad, and of speeds in rates of the unstable position] of a quadrature, and of steps."""
SAID = 3.0
"""By how much more than a note says a motion may be off."""
DIGITS = 45
"""Of the elliptic functions: a fall from an unstable position forgets up to a dozen."""


class Swinging(NamedTuple):
    """A mechanism whose drive turns as `zero + way θ`, where θ is a pendulum's angle from below.

    Attributes:
        text: its description; gravity acts along -y.
        drive: a joint.
        squared: ω² [1/s²].
        zero: position of the drive where θ = 0.
        way: 1 or -1.
    """

    text: str
    drive: str
    squared: mp.mpf
    zero: mp.mpf
    way: int


def _robot(*parts: str) -> str:
    return f'<robot name="swinging"><link name="base"/>{"".join(parts)}</robot>'


def _pendulum(rng: np.random.Generator, geared: bool) -> Swinging:
    """A body on a pin whose centre hangs anywhere, and a wheel that turns n times as fast."""
    mass, length = 10.0 ** rng.uniform(-2, 2), 10.0 ** rng.uniform(-1.5, 1)
    inertia = mass * length**2 * 10.0 ** rng.uniform(-3, 0)
    angle = rng.uniform(-3, 3) if rng.random() < 0.5 else 0.0
    centre = float(length * np.sin(angle)), float(-length * np.cos(angle))
    parts = [link("bob", centre, float(mass), float(inertia)), joint("pin", "base", "bob")]
    about = mp.mpf(inertia) + mp.mpf(mass) * (mp.mpf(centre[0]) ** 2 + mp.mpf(centre[1]) ** 2)
    if geared:
        wheel, ratio = float(inertia * 10.0 ** rng.uniform(-1, 1)), float(rng.uniform(-4, 4))
        parts += [link("wheel", (0.0, 0.0), float(mass), wheel)]
        parts += [
            joint("axle", "base", "wheel", (2.0, 0.0)).replace(
                "</joint>", f'<mimic joint="pin" multiplier="{ratio!r}"/></joint>'
            )
        ]
        about += mp.mpf(ratio) ** 2 * mp.mpf(wheel)
    arm = mp.sqrt(mp.mpf(centre[0]) ** 2 + mp.mpf(centre[1]) ** 2)
    below = -mp.atan2(mp.mpf(centre[0]), -mp.mpf(centre[1]))
    return Swinging(_robot(*parts), "pin", mp.mpf(G) * mp.mpf(mass) * arm / about, below, 1)


def _trammel(rng: np.random.Generator) -> Swinging:
    """A bar whose ends slide along x and y, by equal sliders: its inertia does not change.

    Its centre circles, T = (I + m l²/4 + M l²) φ̇² / 2 and V = g (m l/2 + M l) sin φ, with M
    the mass of a slider and its end at l sin φ on y. At zero, φ = π.
    """
    mass, slider = (float(10.0 ** rng.uniform(-1, 1)) for _ in range(2))
    length = float(10.0 ** rng.uniform(-1, 0.5))
    inertia = float(mass * length**2 * rng.uniform(0.02, 0.3))
    parts = [link("bar", (0.5 * length, 0.0), mass, inertia)]
    for name, axis, at in (("x", "1 0 0", -length), ("y", "0 1 0", 0.0)):
        parts.append(link(name, (0.0, 0.0), slider))
        parts.append(
            f'<joint name="guide_{name}" type="prismatic"><parent link="base"/>'
            f'<child link="{name}"/><origin xyz="{at!r} 0 0"/><axis xyz="{axis}"/>'
            '<limit lower="-99" upper="99" effort="1" velocity="1"/></joint>'
        )
    parts.append(joint("turn", "x", "bar"))
    parts.append(
        f'<loop name="end" type="continuous"><predecessor link="bar"><origin xyz="{length!r} 0 0"/>'
        '</predecessor><successor link="y"/><axis xyz="0 0 1"/></loop>'
    )
    whole = mp.mpf(inertia) + (mp.mpf(mass) / 4 + mp.mpf(slider)) * mp.mpf(length) ** 2
    weight = mp.mpf(G) * (mp.mpf(mass) / 2 + mp.mpf(slider)) * mp.mpf(length)
    return Swinging(_robot(*parts), "turn", weight / whole, 3 * mp.pi / 2, -1)


def swung(squared: mp.mpf, start: mp.mpf, speed: mp.mpf, times: Array) -> tuple[list, list]:
    """Angles and speeds of θ̈ = -ω² sin θ by Jacobi's functions, all turns counted."""
    rate = mp.sqrt(squared)
    turns = 2 * mp.pi * mp.floor((start + mp.pi) / (2 * mp.pi))
    sense = 1 if speed >= 0 else -1
    angle, speed = sense * (start - turns), abs(speed)
    m = (speed / (2 * rate)) ** 2 + mp.sin(angle / 2) ** 2
    k = mp.sqrt(m)
    angles, speeds = [], []
    if m < 1:
        begun = mp.ellipf(mp.asin(max(-1, min(mp.sin(angle / 2) / k, 1))), m)
        for time in times:
            u = begun + rate * mp.mpf(float(time))
            angles.append(sense * 2 * mp.asin(k * mp.ellipfun("sn", u, m=m)) + turns)
            speeds.append(sense * 2 * k * rate * mp.ellipfun("cn", u, m=m))
        return angles, speeds
    half, begun = mp.ellipk(1 / m), mp.ellipf(angle / 2, 1 / m)
    for time in times:
        u = begun + rate * k * mp.mpf(float(time))
        count = mp.nint(u / (2 * half))
        sn, cn, dn = (
            mp.ellipfun(name, u - 2 * half * count, m=1 / m) for name in ("sn", "cn", "dn")
        )
        angles.append(sense * 2 * (mp.atan2(sn, cn) + mp.pi * count) + turns)
        speeds.append(sense * 2 * rate * k * dn)
    return angles, speeds


def _said(notes: tuple[str, ...]) -> float:
    """Return by how much notes say a motion may be off; infinite if by an unknown angle."""
    text = " ".join(notes)
    found = re.search(r"off by ([\de.+-]+) rad", text)
    return float(found.group(1)) if found else np.inf if text else 0.0


def _judged(what: str, moved: cd.Trajectory, error: float) -> tuple[list[str], list[str]]:
    allowed = EXACT if moved.method == "quadrature" else STEPS
    if error <= allowed:
        return [], [f"{moved.method} right{', noted' * bool(moved.notes)}"]
    if error <= SAID * _said(moved.notes) + allowed:
        return [], [f"{moved.method} off, and told"]
    told = f", but notes say {_said(moved.notes):.0e}" if moved.notes else ""
    return [f"{what} by {moved.method}: off by {error:.1e} rad{told}"], [f"{moved.method} wrong"]


def ask(seed: int) -> tuple[list[str], list[str]]:
    """Return what is wrong with one motion, and what became of it."""
    rng = np.random.default_rng([seed, 1])
    distance = float(10.0 ** rng.uniform(-12, -1) * rng.choice([-1, 1]))
    kind = ("pendulum", "gear", "trammel", "pendulum", "slider-crank")[seed % 5]
    with mp.workdps(DIGITS if kind != "slider-crank" else 25):
        if kind == "slider-crank":
            return _slider_crank(rng, distance)
        swinging = _trammel(rng) if kind == "trammel" else _pendulum(rng, kind == "gear")
        return _swing(rng, distance, kind, swinging)


def _swing(
    rng: np.random.Generator, distance: float, kind: str, swinging: Swinging
) -> tuple[list[str], list[str]]:
    rate = float(mp.sqrt(swinging.squared))
    how = ("released", "at the top", "near", "turns away")[rng.integers(4)]
    speed = 0.0
    if how == "released":
        angle = np.pi - np.sqrt(abs(distance)) * rng.choice([-1, 1])
    elif how == "at the top":
        angle, speed = np.pi + rng.normal() * 1e-3 * np.sqrt(abs(distance)), abs(distance)
        speed = 2.0 * rate * np.sqrt(speed)
    else:
        angle = rng.uniform(-3, 3) if how == "near" else rng.uniform(-12, 12)
        speed = rate * np.sqrt(max(2.0 * (2.0 * (1.0 + distance) - (1.0 - np.cos(angle))), 0.0))
    position = float(swinging.way * angle + float(swinging.zero))
    speed = float(speed * rng.choice([-1, 1]))
    duration = float(rng.uniform(3, 60) / rate)
    times = np.sort(np.concatenate([[0.0, duration], rng.uniform(0.0, duration, 9)]))
    methods = (None, None, None, None, "response", "DOP853")
    if kind == "trammel":
        methods = (None, None, None, "response")
    method = methods[rng.integers(len(methods))]
    what = f"{kind} {how}, {distance:.1e} from the separatrix"
    scene = cd.Scene(cd.load(swinging.text), free=swinging.drive, gravity=(0.0, -G, 0.0))
    try:
        moved = scene.simulate(duration, position=position, speed=speed, method=method)
        found = moved.at(times)
        positions, speeds = found.position, found.speed
    except cd.CardanError as refused:
        return [], [f"{method} refused: {type(refused).__name__}"]
    start = swinging.way * (mp.mpf(position) - swinging.zero)
    angles, rates = swung(swinging.squared, start, swinging.way * mp.mpf(speed), times)
    expected = [float(swinging.zero + swinging.way * item) for item in angles]
    error = float(np.max(np.abs(positions - expected)))
    slip = np.max(np.abs(speeds - swinging.way * np.array([float(item) for item in rates])))
    wrong, counted = _judged(what, moved, max(error, float(slip) / rate))
    energy = mp.mpf(speed) ** 2 / (4 * swinging.squared) + mp.sin(start / 2) ** 2
    steps = np.sign(speed) * np.diff(moved.position)
    if energy > 1 + mp.mpf("1e-11") and not moved.notes and not np.all(steps > -1e-12):
        wrong.append(f"{what} by {moved.method}: turns back at {np.min(steps):.1e} rad")
    return wrong, [kind, *counted]


class _SliderCrank:
    """Crank and rod with the slider along x, by the crank's angle; the rod is turned by -β."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.crank = float(rng.uniform(0.1, 1.0))
        self.rod = float(self.crank * rng.uniform(1.3, 4.0))
        self.masses = [float(10.0 ** rng.uniform(-1, 1)) for _ in range(3)]
        lengths = (self.crank, self.rod)
        self.inertias = [
            float(0.1 * m * x * x) for m, x in zip(self.masses[:2], lengths, strict=True)
        ]
        self.centres = (
            float(self.crank * rng.uniform(0.2, 1)),
            float(self.rod * rng.uniform(0.2, 0.8)),
        )
        self.stiffness = float(rng.choice([0.0, 10.0 ** rng.uniform(0, 2)]))
        way = rng.uniform(-np.pi, np.pi)
        self.gravity = float(G * np.cos(way)), float(G * np.sin(way))

    def scene(self) -> cd.Scene:
        crank, rod = self.crank, self.rod
        text = _robot(
            link("crank", (self.centres[0], 0.0), self.masses[0], self.inertias[0]),
            link("rod", (self.centres[1], 0.0), self.masses[1], self.inertias[1]),
            link("slider", (0.0, 0.0), self.masses[2]),
            joint("a", "base", "crank"),
            joint("b", "crank", "rod", (crank, 0.0)),
            f'<joint name="s" type="prismatic"><parent link="base"/><child link="slider"/>'
            f'<origin xyz="{crank + rod!r} 0 0"/><axis xyz="1 0 0"/>'
            '<limit lower="-99" upper="99" effort="1" velocity="1"/></joint>'
            f'<loop name="e" type="continuous"><predecessor link="rod"><origin xyz="{rod!r} 0 0"/>'
            '</predecessor><successor link="slider"/><axis xyz="0 0 1"/></loop>',
        )
        springs = [cd.JointSpring("s", self.stiffness, rest=0.0)] if self.stiffness else None
        return cd.Scene(cd.load(text), free="a", gravity=(*self.gravity, 0.0), elements=springs)

    def _rod(self, angle: mp.mpf) -> tuple[mp.mpf, ...]:
        """Return sines and cosines of crank and rod, and the slope of β by the angle."""
        s, c = mp.sin(angle), mp.cos(angle)
        sine = -self.crank * s / mp.mpf(self.rod)
        cosine = mp.sqrt(1 - sine * sine)
        return s, c, sine, cosine, -self.crank * c / (self.rod * cosine)

    def inertia(self, angle: mp.mpf) -> mp.mpf:
        s, c, sine, cosine, slope = self._rod(angle)
        r, along = self.crank, self.centres[1]
        x, y = -r * s - along * sine * slope, r * c + along * cosine * slope
        slide = -r * s - self.rod * sine * slope
        turning = self.inertias[0] + self.masses[0] * mp.mpf(self.centres[0]) ** 2
        moving = self.masses[1] * (x**2 + y**2) + self.masses[2] * slide**2
        return turning + self.inertias[1] * slope**2 + moving

    def potential(self, angle: mp.mpf) -> mp.mpf:
        s, c, sine, cosine, _ = self._rod(angle)
        r, (one, two), (gx, gy) = self.crank, self.centres, self.gravity
        slide = r * c + self.rod * cosine
        weight = self.masses[0] * one * (gx * c + gy * s) + self.masses[2] * gx * slide
        weight += self.masses[1] * (gx * (r * c + two * cosine) + gy * (r * s + two * sine))
        stretch = slide - (mp.mpf(self.crank) + mp.mpf(self.rod))
        return mp.mpf(self.stiffness) / 2 * stretch**2 - weight


def _slider_crank(rng: np.random.Generator, distance: float) -> tuple[list[str], list[str]]:
    """Hold speeds against the energy, and times against the integral of the way to a turning."""
    system = _SliderCrank(rng)
    around = np.linspace(0.0, 2.0 * np.pi, 361)[:-1]
    heights = np.array([float(system.potential(mp.mpf(float(item)))) for item in around])
    near = mp.mpf(float(around[np.argmax(heights)]))
    slope = mp.mpf("0.008")
    top = mp.findroot(lambda p: mp.diff(system.potential, p), (near - slope, near + slope))
    rise = system.potential(top) - mp.mpf(float(heights.min()))
    if rng.integers(2):
        position = float(top) + float(rng.choice([-1, 1]) * np.sqrt(abs(distance)))
        speed = 0.0
    else:
        position = float(rng.uniform(0.0, 2.0 * np.pi))
        left = system.potential(top) + distance * rise - system.potential(mp.mpf(position))
        way = float(rng.choice([-1, 1]))
        speed = way * float(mp.sqrt(2 * max(left, 0) / system.inertia(mp.mpf(position))))
    start = mp.mpf(position)
    energy = system.inertia(start) * mp.mpf(speed) ** 2 / 2 + system.potential(start)
    rate = float(mp.sqrt(abs(mp.diff(system.potential, top, 2)) / system.inertia(top)))
    duration = float(rng.uniform(2, 12) / rate)
    times = np.sort(rng.uniform(0.0, duration, 3))
    what = f"slider-crank, {distance:.1e} from the separatrix"
    try:
        moved = system.scene().simulate(duration, position=position, speed=speed)
        found = moved.at(times)
        places, speeds = found.position, found.speed
    except cd.CardanError as refused:
        return [], [f"slider-crank refused: {type(refused).__name__}"]
    sense = int(np.sign(speed)) or (1 if mp.diff(system.potential, start) < 0 else -1)
    turns = energy < system.potential(top) or not speed
    worst, checked = 0.0, 0
    for time, place, fast in zip(times.tolist(), places.tolist(), speeds.tolist(), strict=True):
        end = mp.mpf(place)
        left = energy - system.potential(end)
        if left > rise * mp.mpf("1e-6"):
            worst = max(
                worst, abs(float(mp.sqrt(2 * left / system.inertia(end))) - abs(fast)) / rate
            )
        before = (
            moved.at(np.linspace(1e-3 * time, time, 400)).speed if turns else np.ones(1) * sense
        )
        if np.all(before * sense > 0.0):
            taken = _taken(system, energy, start, end, top, sense, from_rest=not speed)
            worst, checked = max(worst, abs(float(taken - mp.mpf(time)) * fast)), checked + 1
    wrong, counted = _judged(what, moved, worst)
    return wrong, ["slider-crank", *counted, *["time integral"] * checked]


def _taken(
    system: _SliderCrank,
    energy: mp.mpf,
    start: mp.mpf,
    end: mp.mpf,
    top: mp.mpf,
    sense: int,
    from_rest: bool,
) -> mp.mpf:
    """Time of the way between two angles, on which the crank does not turn back."""

    def slowness(angle: mp.mpf) -> mp.mpf:
        return mp.sqrt(system.inertia(angle) / 2 / abs(energy - system.potential(angle)))

    # Pieces as long as their distance from the unstable position.
    pieces = [start + (end - start) * k / 8 for k in range(1, 8)]
    for turn in range(-6, 7):
        middle = top + 2 * mp.pi * turn
        pieces += [middle, *(middle + way * mp.mpf(10) ** -k for k in range(8) for way in (-1, 1))]
    low, high = min(start, end), max(start, end)
    ends = [start, *sorted((p for p in pieces if low < p < high), reverse=sense < 0), end]
    if not from_rest:
        return abs(mp.quad(slowness, ends))
    roots = [mp.sqrt(abs(item - start)) for item in ends]
    return mp.quad(lambda q: 2 * q * slowness(start + sense * q * q) if q else mp.mpf(0), roots)
