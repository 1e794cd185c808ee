"""Simulations that begin close to singular configurations, against motions in regular coordinates.

Each either is within its tolerance of the reference, or is refused, or has notes.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from free_rotations import Body, turned
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
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


def tilted(parts: str, tilt: np.ndarray) -> str:
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
    return cd.load(tilted(text, tilt)), other


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
    moved = cd.Scene(mechanism, free="A").simulate(end, speed=1.0, method="DOP853")
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
    return cd.load(tilted(text, tilt))


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
    moved = cd.Scene(mechanism, free="A").simulate(end, speed=speed, method="DOP853")
    expected = np.array([state(float(p))[2] + state(float(p))[3] for p in found]) - (u + w)
    return float(np.max(np.abs(moved.at(times).position - expected)) / end), moved


def flat_error(count: int, before: float, speed: float, end: float) -> tuple[float, cd.Trajectory]:
    """Greatest error of parallelograms that begin a little before all bars are in line."""
    inertia, weight = parallelogram_law(count)
    start = 0.5 * math.pi - before
    scene = cd.Scene(parallelograms(count), free="pin_0", gravity=GRAVITY)
    moved = scene.simulate(end, position=start, speed=speed)
    times = np.linspace(0.0, end, 12)
    law = integrated(lambda t, x, v: weight * np.sin(x) / inertia, start, speed, times)
    return float(np.max(np.abs(moved.at(times).position - law[0]))), moved


def dead_point_error(
    near: float, a: float, b: float, by_slider: bool, speed: float, tilt: np.ndarray
) -> tuple[float, cd.Trajectory]:
    """Greatest error of a slider-crank's crank that begins `near` its outer dead point.

    It is simulated by its crank, or by its slider, whose way has no slope there; the crank's angle
    is the regular coordinate. Rod and slider are as in `rods`, a slope of the rod is -β.
    """

    def states(angle: float) -> tuple[float, float, float]:
        """Angle of the rod and slopes of that and of the slider."""
        rod = -math.asin(a * math.sin(angle) / b)
        slope = -a * math.cos(angle) / (b * math.cos(rod))
        return rod, slope, -a * math.sin(angle) - b * math.sin(rod) * slope

    def inertia(angle: float) -> float:
        rod, slope, slide = states(angle)
        centre = a * a + (b / 2 * slope) ** 2 + a * b * slope * math.cos(angle - rod)
        return 0.1 + a * a / 4 + 0.1 * slope**2 + centre + 2.0 * slide**2

    rod, _, slide = states(near)
    reach = a * math.cos(near) + b * math.cos(rod)
    text = f"""{link("crank", (a / 2, 0))}{link("rod", (b / 2, 0))}{link("slider", (0, 0), 2.0)}
    <joint name="A" type="continuous"><parent link="base"/><child link="crank"/>
    <origin rpy="0 0 {near!r}"/><axis xyz="0 0 1"/></joint>
    <joint name="B" type="continuous"><parent link="crank"/><child link="rod"/>
    <origin xyz="{a!r} 0 0" rpy="0 0 {rod - near!r}"/><axis xyz="0 0 1"/></joint>
    <joint name="S" type="prismatic"><parent link="base"/><child link="slider"/>
    <origin xyz="{reach!r} 0 0"/><axis xyz="1 0 0"/>
    <limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
    <loop name="C" type="continuous"><predecessor link="rod"><origin xyz="{b!r} 0 0"/>
    </predecessor><successor link="slider"/><axis xyz="0 0 1"/></loop>"""
    end = 1.0 / abs(speed)
    times, angles = free_time(inertia, near, speed, end)
    scene = cd.Scene(cd.load(tilted(text, tilt)), free="S" if by_slider else "A")
    moved = scene.simulate(end, speed=slide * speed if by_slider else speed)
    at = moved.at(times)
    found = at.motion.position("A") + near
    error = float(np.max(np.abs(found - angles)))
    places = np.array([a * math.cos(p) + b * math.cos(states(float(p))[0]) for p in angles])
    slid = float(np.max(np.abs(at.motion.position("S") + reach - places)))
    return max(error, slid), moved


class Branch:
    """Two coordinates with h² - y² = ±c², which miss the crossing h = y = 0 of two modes.

    The regular coordinate p: h = c cosh p, y = c sinh p, or the other way round.
    """

    def __init__(self, size: float, is_above: bool, along: float) -> None:
        self.size, self.is_above = size, is_above
        self.start = math.asinh(along / size)

    def at(self, p: float) -> tuple[float, float, float, float]:
        """Return h, y and their slopes."""
        most = math.log(1.5 / self.size)  # Steps that are tried may lead too far.
        p = max(-most, min(p, most))
        sine, cosine = self.size * math.sinh(p), self.size * math.cosh(p)
        return (cosine, sine, sine, cosine) if self.is_above else (sine, cosine, cosine, sine)

    def error(
        self,
        scene: cd.Scene,
        inertia: Callable[[float], float],
        angle: Callable[[float], tuple[float, float]],
        along: float,
        sign: float,
    ) -> tuple[float, cd.Trajectory]:
        """Greatest error of the driven angle, which is given with its slope, past the crossing."""
        begun, slope = angle(self.start)
        rate = sign / max(abs(slope), self.size)
        end = 2.0 * along if sign < 0 else 0.3
        times, found = free_time(inertia, self.start, rate, end)
        moved = scene.simulate(end, speed=rate * slope, method="DOP853")
        expected = np.array([angle(float(p))[0] for p in found]) - begun
        return float(np.max(np.abs(moved.at(times).position - expected)) / end), moved


def thin(name: str, end: np.ndarray, mass: float) -> str:
    """A uniform rod without thickness from its frame's origin to `end`.

    With velocities u and v of its ends its kinetic energy is m (u² + u·v + v²) / 6.
    """
    tensor = mass / 12.0 * ((end @ end) * np.eye(3) - np.outer(end, end))
    entries = " ".join(
        f'i{"xyz"[a]}{"xyz"[b]}="{float(tensor[a, b])!r}"' for a in range(3) for b in range(a, 3)
    )
    centre = " ".join(repr(float(value)) for value in 0.5 * end)
    return (
        f'<link name="{name}"><inertial><origin xyz="{centre}"/><mass value="{mass!r}"/>'
        f"<inertia {entries}/></inertial></link>"
    )


def spatial_error(
    size: float, is_above: bool, along: float, sign: float, a: float, e: float, tilt: np.ndarray
) -> tuple[float, cd.Trajectory]:
    """Greatest error of a crank about x whose rod nearly stands normal to its slider along x.

    The crank's pin is at a (cos ψ, sin ψ) in y and z, the slider at (x, -e, 0), so that
    x² - 4 a e sin² ψ/2 = L² - (a + e)². The rod has a universal joint and a ball.
    """
    branch = Branch(size, is_above, along)
    length = math.sqrt((a + e) ** 2 + (size**2 if is_above else -(size**2)))
    root = 2.0 * math.sqrt(a * e)
    mass = 1.5

    def angle(p: float) -> tuple[float, float]:
        _, y, _, slope = branch.at(p)
        s = max(-0.99, min(y / root, 0.99))  # As above.
        return 2.0 * math.asin(s), 2.0 * slope / (root * math.sqrt(1.0 - s * s))

    def inertia(p: float) -> float:
        turn, slide = angle(p)[1], branch.at(p)[2]
        return (0.1 + a * a / 4 + mass * a * a / 3) * turn**2 + (2.0 + mass / 3) * slide**2

    psi, x = angle(branch.start)[0], branch.at(branch.start)[0]
    across = math.hypot(e + a * math.cos(psi), a * math.sin(psi))
    lean = math.atan2(a * math.sin(psi), e + a * math.cos(psi))
    text = f"""{link("crank", (0.0, a / 2))}<link name="yoke"/>
    {thin("rod", np.array([0.0, -length, 0.0]), mass)}{link("slider", (0, 0), 2.0)}
    <joint name="A" type="continuous"><parent link="base"/><child link="crank"/>
    <origin rpy="{psi!r} 0 0"/><axis xyz="1 0 0"/></joint>
    <joint name="U" type="continuous"><parent link="crank"/><child link="yoke"/>
    <origin xyz="0 {a!r} 0" rpy="{lean - psi!r} 0 0"/><axis xyz="1 0 0"/></joint>
    <joint name="V" type="continuous"><parent link="yoke"/><child link="rod"/>
    <origin rpy="0 0 {math.atan2(x, across)!r}"/><axis xyz="0 0 1"/></joint>
    <joint name="S" type="prismatic"><parent link="base"/><child link="slider"/>
    <origin xyz="{x!r} {-e!r} 0"/><axis xyz="1 0 0"/>
    <limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
    <loop name="C" type="spherical"><predecessor link="rod"><origin xyz="0 {-length!r} 0"/>
    </predecessor><successor link="slider"/></loop>"""
    scene = cd.Scene(cd.load(tilted(text, tilt)), free="A")
    return branch.error(scene, inertia, angle, along, sign)


def geared_error(
    size: float, is_above: bool, along: float, sign: float, a: float, g: float, tilt: np.ndarray
) -> tuple[float, cd.Trajectory]:
    """Greatest error of a five-bar with cranks geared 1 : -1, whose couplers are nearly in line.

    The cranks at (∓g, 0) are at ψ from pointing outwards, mirrored; both couplers of length l end
    in a pin at height h above the cranks' ends: h² + (g + a cos ψ)² = l². With G = g + a, s =
    sin ψ/2 and y² = 4 a s² (G - a s²) that is h² - y² = l² - G².
    """
    branch = Branch(size, is_above, along)
    whole, mass = g + a, 0.8
    length = math.sqrt(whole**2 + (size**2 if is_above else -(size**2)))

    def angle(p: float) -> tuple[float, float]:
        _, y, _, slope = branch.at(p)
        y = max(-0.9 * whole, min(y, 0.9 * whole))  # As above.
        root = math.sqrt(whole**2 - y * y)
        under = math.sqrt(2.0 * a * (whole + root))
        s = max(-0.99, min(y / under, 0.99))
        by_y = 1.0 / under + y * y * a / (root * under**3)
        return 2.0 * math.asin(s), 2.0 * by_y * slope / math.sqrt(1.0 - s * s)

    def inertia(p: float) -> float:
        psi, turn = angle(p)
        one = a * turn * np.array([math.sin(psi), -math.cos(psi)])  # Of the left crank's end.
        two = np.array([0.0, branch.at(p)[2] - a * math.cos(psi) * turn])
        couplers = 2.0 * mass / 3.0 * float(one @ one + one @ two + two @ two)
        return 2.0 * (0.1 + a * a / 4) * turn**2 + couplers

    psi, h = angle(branch.start)[0], branch.at(branch.start)[0]
    left, right = math.pi + psi, -psi
    reach = g + a * math.cos(psi)
    up, down = math.atan2(h, reach), math.atan2(h, -reach)
    parts = [link("one", (a / 2, 0)), link("two", (a / 2, 0))]
    for name, at, turn in (("one", -g, left), ("two", g, right)):
        parts.append(
            f'<joint name="{name}_pin" type="continuous"><parent link="base"/>'
            f'<child link="{name}"/><origin xyz="{at!r} 0 0" rpy="0 0 {turn!r}"/>'
            '<axis xyz="0 0 1"/></joint>'
        )
    for name, turn in (("one", up - left), ("two", down - right)):
        parts.append(thin(f"{name}_bar", np.array([length, 0.0, 0.0]), mass))
        parts.append(
            f'<joint name="{name}_knee" type="continuous"><parent link="{name}"/>'
            f'<child link="{name}_bar"/><origin xyz="{a!r} 0 0" rpy="0 0 {turn!r}"/>'
            '<axis xyz="0 0 1"/></joint>'
        )
    parts.append(
        f'<loop name="top" type="continuous"><predecessor link="one_bar">'
        f'<origin xyz="{length!r} 0 0"/></predecessor><successor link="two_bar">'
        f'<origin xyz="{length!r} 0 0"/></successor><axis xyz="0 0 1"/></loop>'
        '<coupling name="mesh"><predecessor link="one"/><successor link="two"/>'
        '<ratio value="-1"/></coupling>'
    )
    scene = cd.Scene(cd.load(tilted("".join(parts), tilt)), free="one_pin")
    return branch.error(scene, inertia, angle, along, sign)


def platform_error(
    near: float, rng: np.random.Generator, tilt: np.ndarray
) -> tuple[float, cd.Trajectory]:
    """Greatest error of the legs of a platform that is `near` a quarter of a turn from its base.

    Six legs without mass, between hexagons that look alike after a third of a turn: at a quarter
    of a turn about their normal they do not hold the platform (Fichter 1986). It moves as a free
    body, which quaternions follow.
    """
    sides, thirds = np.tile([-1.0, 1.0], 3), np.repeat(np.arange(3), 2) * 2.0 * np.pi / 3.0

    def points(radius: float, apart: float) -> np.ndarray:
        angles = thirds + apart * sides
        return radius * np.stack([np.cos(angles), np.sin(angles), np.zeros(6)], axis=1)

    feet = points(1.0, rng.uniform(0.1, 0.3))
    heads = points(rng.uniform(0.4, 0.7), rng.uniform(0.7, 0.95))
    turn = Rotation.from_euler("z", 0.5 * np.pi - near)
    centre, inertia = np.array([0.0, 0.0, 0.9]), rng.uniform(0.1, 0.3, 3).tolist()
    inertia[2] = 0.5 * (inertia[0] + inertia[1])
    spin = np.array([*rng.normal(0.0, 0.3, 2), rng.choice([-1.0, 1.0])])
    speed = rng.normal(0.0, 0.2, 3)
    gravity = rng.normal(0.0, 1.0, 3)

    def words(values: np.ndarray) -> str:
        return " ".join(repr(float(value)) for value in values)

    parts = [
        f'<link name="top"><inertial><mass value="3.0"/><inertia ixx="{inertia[0]!r}" '
        f'iyy="{inertia[1]!r}" izz="{inertia[2]!r}"/></inertial></link>'
        f'<joint name="free" type="floating"><parent link="base"/><child link="top"/>'
        f'<origin xyz="{words(centre)}" rpy="0 0 {0.5 * np.pi - near!r}"/></joint>'
    ]
    ways = centre + turn.apply(heads) - feet
    for k, way in enumerate(ways):
        roll, pitch = math.atan2(-way[1], way[2]), math.atan2(way[0], math.hypot(way[1], way[2]))
        length = float(np.linalg.norm(way))
        origins = (f'xyz="{words(feet[k])}" rpy="{roll!r} 0 0"', f'rpy="0 {pitch!r} 0"')
        parts.append(
            f'<link name="v{k}"/><link name="w{k}"/><link name="leg{k}"/>'
            f'<joint name="U{k}" type="continuous"><parent link="base"/><child link="v{k}"/>'
            f'<origin {origins[0]}/><axis xyz="1 0 0"/></joint>'
            f'<joint name="V{k}" type="continuous"><parent link="v{k}"/><child link="w{k}"/>'
            f'<origin {origins[1]}/><axis xyz="0 1 0"/></joint>'
            f'<joint name="L{k}" type="prismatic"><parent link="w{k}"/><child link="leg{k}"/>'
            f'<origin xyz="0 0 {length!r}"/><axis xyz="0 0 1"/>'
            '<limit lower="-9" upper="9" effort="1" velocity="1"/></joint>'
            f'<loop name="ball{k}" type="spherical"><predecessor link="leg{k}"/>'
            f'<successor link="top"><origin xyz="{words(heads[k])}"/></successor></loop>'
        )
    arms = turn.apply(heads)
    rates = np.sum(ways * (speed + np.cross(turn.apply(spin), arms)), axis=1)
    rates /= np.linalg.norm(ways, axis=1)
    base = Rotation.from_euler("xyz", tilt)
    legs = [f"L{k}" for k in range(6)]
    scene = cd.Scene(cd.load(tilted("".join(parts), tilt)), free=legs, gravity=base.apply(gravity))
    end = 0.2
    times = np.linspace(0.0, end, 12)
    body = Body(3.0, np.zeros(3), np.diag(inertia), np.zeros(3))
    start = np.concatenate([turn.as_quat(), spin])
    turns = Rotation.from_quat(turned([body], start, gravity, end, 1e-13).sol(times)[:4].T)
    places = centre + times[:, None] * speed + 0.5 * times[:, None] ** 2 * gravity
    lengths = np.stack(
        [np.linalg.norm(places + turns.apply(heads[k]) - feet[k], axis=1) for k in range(6)], axis=1
    )
    moved = scene.simulate(end, speed=rates)
    found = moved.at(times).position
    return float(np.max(np.abs(found - (lengths - lengths[0])))) / end, moved


KINDS = ("rods", "bars", "flat", "dead point", "spatial", "geared", "platform")


def case(seed: int) -> tuple[str, float, str]:
    """Run one; return what it was, its error, and what was said of it."""
    random = np.random.default_rng(seed)
    near = 10.0 ** random.uniform(-9.0, -2.0)
    tilt = random.uniform(-3.0, 3.0, 3) * (random.random() < 0.7)
    kind = KINDS[seed % len(KINDS)]
    text = f"{kind} {near:.1e}"
    try:
        if kind == "rods":
            error, moved = rods_error(near, *random.uniform(0.3, 2.0, 2).tolist(), tilt)
        elif kind in ("bars", "spatial", "geared"):
            a, g = float(random.uniform(0.3, 1.0)), float(random.uniform(1.1, 2.0))
            off = random.choice([-1.0, 1.0]) * 10.0 ** random.uniform(-14.0, -3.0)
            along = max(near, 3.0 * math.sqrt(abs(off)))
            sign = random.choice([-1.0, 1.0])
            text += f" off {off:.1e} along {along:.1e} {sign:+.0f}"
            if kind == "bars":
                error, moved = bars_error(off, a, g, along, sign, tilt)
            else:
                size = math.sqrt(abs(off))
                run = spatial_error if kind == "spatial" else geared_error
                error, moved = run(size, off > 0.0, along, sign, a, g, tilt)
        elif kind == "dead point":
            r, by_slider = float(random.uniform(0.3, 1.0)), bool(random.random() < 0.6)
            speed = float(random.choice([-1.0, 1.0]) * 10.0 ** random.uniform(-1.0, 1.0))
            text += f" by its {'slider' if by_slider else 'crank'} {speed:+.2f}"
            rod = r * float(random.uniform(1.2, 4.0))
            error, moved = dead_point_error(near, r, rod, by_slider, speed, tilt)
        elif kind == "platform":
            error, moved = platform_error(float(random.choice([-1, 1]) * near), random, tilt)
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


def ask(seed: int) -> tuple[list[str], list[str]]:
    """Return what is wrong with one simulation and not said, and what became of it."""
    what, error, said = case(seed)
    kind = KINDS[seed % len(KINDS)]
    became = "refused" if "Error: " in said[:40] else "noted" if said else "not noted"
    wrong = [f"{what}: off by {error:.1e}"] if is_wrong(error, said) else []
    return wrong, [kind, f"{kind}, {became}"]
