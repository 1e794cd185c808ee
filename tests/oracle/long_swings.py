"""Pendulums that swing or turn for long, and events of many zeros within one step.

Positions are those of θ̈ = -ω² sin θ by elliptic functions of mpmath, with as many digits as the
number of periods takes; times at which an angle is reached are elliptic integrals.
"""

from __future__ import annotations

from typing import NamedTuple

import mpmath as mp
import numpy as np
from scipy.special import ellipk, ellipkinc
from testkit.simulated import joint, link

import cardan_dyn as cd

G = 9.81
LONGEST = 1e12
"""Way [rad, or reaches of a swing] beyond which a simulation is refused."""
BESIDE = 1e-6
"""Distance [rad] from where a swing turns back within which an event may or may not happen."""
APART = {"quadrature": 1e-9, "response": 1e-6, "DOP853": 1e-6, "Radau": 1e-5}
"""Errors of the times of events, in ways of the fastest motion [rad]."""


class Pendulum(NamedTuple):
    """A body on a pin that hangs below it at zero.

    Attributes:
        scene: to simulate.
        squared: ω² of small swings [1/s²].
        angle, speed: at the start.
    """

    scene: cd.Scene
    squared: mp.mpf
    angle: float
    speed: float

    @property
    def rate(self) -> float:
        return float(mp.sqrt(self.squared))

    @property
    def modulus(self) -> float:
        """Energy, as a fraction of that of the upright position."""
        half = float(np.sin(0.5 * self.angle))
        return (self.speed / (2.0 * self.rate)) ** 2 + half * half

    @property
    def fastest(self) -> float:
        return float(2.0 * self.rate * np.sqrt(self.modulus))

    @property
    def reach(self) -> float:
        """Half the way of a swing [rad]; inf if it turns."""
        return float(2.0 * np.arcsin(np.sqrt(self.modulus))) if self.modulus < 1.0 else np.inf

    @property
    def period(self) -> float:
        if self.modulus < 1.0:
            return float(4.0 * ellipk(self.modulus) / self.rate)
        return float(2.0 * ellipk(1.0 / self.modulus) / (self.rate * np.sqrt(self.modulus)))


def pendulum(rng: np.random.Generator, *, tiny: bool = False) -> Pendulum:
    """A random one that is not close to an unstable equilibrium."""
    mass, arm = float(10.0 ** rng.uniform(-2, 2)), float(10.0 ** rng.uniform(-1.5, 1))
    inertia = float(mass * arm**2 * 10.0 ** rng.uniform(-3, 0))
    parts = link("bob", (0.0, -arm), mass, inertia) + joint("pin", "base", "bob")
    text = f'<robot name="long"><link name="base"/>{parts}</robot>'
    scene = cd.Scene(cd.load(text), free="pin", gravity=(0.0, -G, 0.0))
    squared = mp.mpf(G) * mp.mpf(mass) * mp.mpf(arm)
    squared /= mp.mpf(inertia) + mp.mpf(mass) * mp.mpf(arm) ** 2
    rate, kind = float(mp.sqrt(squared)), rng.integers(3)
    angle = float(rng.uniform(-2.8, 2.8))
    if tiny:
        angle *= 10.0 ** rng.uniform(-6, -1)
    if kind == 0:
        return Pendulum(scene, squared, angle, 0.0)
    modulus = rng.uniform(0.02, 0.95) if kind == 1 else 1.0 + 10.0 ** rng.uniform(-1, 1.5)
    if tiny and kind == 1:
        modulus *= 10.0 ** rng.uniform(-10, -2)
    sine = np.sqrt(min(modulus, 1.0)) * rng.uniform(-0.99, 0.99)
    angle = float(2.0 * np.arcsin(sine))
    speed = float(2.0 * rate * np.sqrt(modulus - np.sin(0.5 * angle) ** 2) * rng.choice([-1, 1]))
    return Pendulum(scene, squared, angle, speed)


def at(body: Pendulum, times: np.ndarray) -> np.ndarray:
    """Angles at times, all turns counted."""
    digits = 40 + int(np.log10(1.0 + np.max(times) * body.rate))
    with mp.workdps(digits):
        rate, sense = mp.sqrt(body.squared), -1 if body.speed < 0.0 else 1
        angle, speed = sense * mp.mpf(body.angle), abs(mp.mpf(body.speed))
        m = (speed / (2 * rate)) ** 2 + mp.sin(angle / 2) ** 2
        found = []
        for time in map(mp.mpf, times.tolist()):
            if m < 1:
                sine = max(mp.mpf(-1), min(mp.sin(angle / 2) / mp.sqrt(m), mp.mpf(1)))
                u = mp.ellipf(mp.asin(sine), m) + rate * time
                u -= 4 * mp.ellipk(m) * mp.floor(u / (4 * mp.ellipk(m)))
                place = 2 * mp.asin(mp.sqrt(m) * mp.ellipfun("sn", u, m=m))
            else:
                half = mp.ellipk(1 / m)
                u = mp.ellipf(angle / 2, 1 / m) + rate * mp.sqrt(m) * time
                turns = mp.nint(u / (2 * half))
                sn, cn = (mp.ellipfun(n, u - 2 * half * turns, m=1 / m) for n in ("sn", "cn"))
                place = 2 * (mp.atan2(sn, cn) + mp.pi * turns)
            found.append(float(sense * place))
    return np.array(found)


def reached(body: Pendulum, levels: np.ndarray, end: float) -> np.ndarray:
    """Times up to an end at which the angle passes levels, ascending."""
    rate, m, sense = body.rate, body.modulus, -1.0 if body.speed < 0.0 else 1.0
    levels, angle = sense * levels, sense * body.angle
    if m < 1.0:
        inside = levels[np.abs(levels) < body.reach]
        whole = ellipk(m)

        def phase(angles: np.ndarray) -> np.ndarray:
            return ellipkinc(np.arcsin(np.clip(np.sin(0.5 * angles) / np.sqrt(m), -1.0, 1.0)), m)

        begun, own = float(phase(np.array([angle]))[0]), phase(inside)
        last = int(np.ceil((begun + rate * end) / (2.0 * whole))) + 1
        ways = [2.0 * j * whole + (-1.0) ** j * own for j in range(-1, last + 1)]
        times = (np.concatenate(ways) - begun) / rate
    else:
        rate *= np.sqrt(m)
        times = (ellipkinc(0.5 * levels, 1.0 / m) - ellipkinc(0.5 * angle, 1.0 / m)) / rate
    return np.sort(times[(times > 0.0) & (times <= end)])


def ask(seed: int) -> tuple[list[str], list[str]]:
    """Return what is wrong with one motion, and what became of it."""
    rng = np.random.default_rng([seed, 42])
    return (_long, _events)[seed % 2](rng)


def _long(rng: np.random.Generator) -> tuple[list[str], list[str]]:
    body = pendulum(rng, tiny=bool(rng.integers(2)))
    duration = float(10.0 ** rng.uniform(2, 16) / body.rate)
    times = np.sort(np.append(rng.uniform(0.0, duration, 3), duration))
    far = body.fastest / min(body.reach, 1.0) * duration
    what = f"reach {body.reach:.2g}, {duration / body.period:.1e} periods"
    try:
        moved = body.scene.simulate(duration, position=body.angle, speed=body.speed)
        found = moved.at(times)
        positions = found.position
    except cd.ArgumentError as refused:
        wrong = [] if far > 0.9 * LONGEST else [f"{what}: refused: {refused}"]
        return wrong, ["long: refused"]
    if far > 1.1 * LONGEST:
        return [f"{what}: not refused"], ["long: not refused"]
    error = float(np.max(np.abs(positions - at(body, times))))
    way = 2.0 * min(body.reach, np.pi)
    told = found.time_residual * way
    wrong = [] if error <= told else [f"{what}: off by {error:.1e} rad, time_residual {told:.1e}"]
    if error > 1e-8 * (1.0 + way) and not moved.notes:
        wrong.append(f"{what}: off by {error:.1e} rad and no note")
    return wrong, ["long: right" if error < 1e-8 * way else "long: off, and told"]


def _events(rng: np.random.Generator) -> tuple[list[str], list[str]]:
    body = pendulum(rng)
    method = rng.choice(["quadrature", "quadrature", "response", "DOP853", "Radau"])
    duration = float(rng.uniform(0.3, 6.0)) * body.period
    often, phase = float(10.0 ** rng.uniform(0, 2.3)), float(rng.uniform(-np.pi, np.pi))
    kind = rng.integers(4)

    def event(time: float, position: object, speed: object) -> float:
        if kind == 0:
            return float(np.sin(often * time / body.period + phase))
        if kind == 1:
            return float(speed["pin"])
        if kind == 2:  # Two zeros that are a hundredth of a radian apart, or less.
            return float(np.abs(position["pin"] - 0.3 * phase) - 1.0 / often**2)
        return float(np.sin(often * position["pin"] + phase))

    what = f"kind {kind}, {often:.3g} per rad, {duration / body.period:.2g} periods by {method}"
    asked = {} if method == "quadrature" else {"rtol": 1e-9 if method == "Radau" else 1e-11}
    begun = {"position": body.angle, "speed": body.speed}
    moved = body.scene.simulate(duration, method=method, events=event, **begun, **asked)
    times = np.array([item.time for item in moved.events])
    if kind == 0:
        first, last = phase / np.pi, (phase + often * duration / body.period) / np.pi
        counts = np.arange(np.floor(first) + 1, np.floor(last) + 1)
        expected = (counts * np.pi - phase) * body.period / often
    elif kind == 1:
        if body.reach == np.inf:
            expected = np.zeros(0)
        else:
            m, sense = body.modulus, -1.0 if body.speed < 0.0 else 1.0
            sine = sense * np.sin(0.5 * body.angle) / np.sqrt(m)
            begins = ellipkinc(np.arcsin(np.clip(sine, -1.0, 1.0)), m)
            turns = (np.arange(-1, 31, 2) * ellipk(m) - begins) / body.rate
            # From rest, the start is where it turns back.
            expected = turns[(turns > 1e-6 * body.period) & (turns <= duration)]
    else:
        if kind == 2:
            levels = 0.3 * phase + np.array([-1.0, 1.0]) / often**2
        else:
            most = (7.0 * duration / body.period + 4.0) if body.reach == np.inf else np.pi
            counts = np.arange(-np.ceil(often * most / np.pi) - 2, often * most / np.pi + 3)
            levels = (counts * np.pi - phase) / often
        if np.any(np.abs(np.abs(levels) - body.reach) < BESIDE):
            return [], ["events: beside a turning point"]
        if np.any(np.abs(levels - body.angle) < BESIDE):
            return [], ["events: at the start"]
        expected = reached(body, levels, duration)
    if np.any(np.abs(expected - duration) < 1e-6 * body.period):
        return [], ["events: at the end"]
    if len(times) != len(expected):
        return [f"{what}: {len(times)} of {len(expected)} events, notes {moved.notes}"], []
    error = float(np.max(np.abs(times - expected), initial=0.0)) * body.fastest
    steep = 0.02 if kind in (1, 3) else 1.0  # Beside turning points times move more than angles.
    if error * steep > APART[method]:
        return [f"{what}: times off by {error:.1e} rad"], []
    return [], [f"events: {method}", *["events"] * len(times)]
