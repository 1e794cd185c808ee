"""Random rigs whose critical speeds are known by closed forms or a continuation of their own.

Each is drawn by its seed: rotors with unbalance between springs alike or not, a rotor between
springs that stiffen, one that hangs, a shaft that tilts under torque, torsional lines whose
resonances lean over and whose motions are unstable in intervals of speed. What is expected comes
from equations written down by hand.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from continuation import Branch, Curve
from shooting import Acceleration, periodic
from testkit import elastic_rigs
from tilting_shaft import TiltingShaft
from vibrating_lines import ElasticMiddleShaft, SpringInFront, SpringsOnBothSides

import cardan_dyn as cd

Array = np.ndarray
WIDER = (3.0, 10.0, 30.0, 100.0)
"""Factors on the width of a range that change no row of its table."""
LATER = 40
"""Seed from which on rigs soften or tilt."""


@dataclass(frozen=True)
class Row:
    """What is known of a row of the table.

    Attributes:
        values: of its fields; a function of the speed at which it is found, if it depends on that.
        order: of a resonance; an instability if 0.
        whirl: of its mode, if more than one crosses the order.
    """

    values: dict[str, float | Callable[[float], float]]
    order: float = 0.0
    whirl: str = ""


@dataclass(frozen=True)
class Rig:
    """A scene, a range of speed and what is known of the table there."""

    name: str
    scene: cd.Scene
    low: float
    high: float
    orders: tuple[float, ...]
    rows: list[Row]
    others: bool = False
    options: dict[str, object] = field(default_factory=dict)
    goes_on: bool = False
    """Whether its rows go on beyond the range, and so are others in wider ones."""


def draw(seed: int) -> Rig:
    """Return the rig of a seed."""
    random = np.random.default_rng([seed, 27])
    kinds = (_laval, _uneven, _balanced, _stiffening, _front, _front_region, _middle, _both)
    if seed >= LATER:
        kinds = (_swinging, _tilting)
    return kinds[seed % len(kinds)](random)


def ask(seed: int) -> tuple[list[str], list[str]]:
    """Return what is wrong with the table of a rig, and the rig's name."""
    rig = draw(seed)
    return differences(rig), [rig.name]


def differences(rig: Rig, wider: tuple[float, ...] = WIDER) -> list[str]:
    """Return what is wrong with the table of a rig, and of ranges as many times as wide."""
    found = _table(rig, rig.low, rig.high)
    wrong = _against(rig, found)
    for factor in () if rig.goes_on else wider:
        width = factor * (rig.high - rig.low)
        low = max(rig.low - 0.1 * (width - (rig.high - rig.low)), 0.3 * rig.low)
        other = _table(rig, low, low + width)
        wrong += [f"{factor:g} times as wide: {text}" for text in _unlike(rig, found, other)]
    return wrong


def _table(rig: Rig, low: float, high: float) -> list[cd.vibration.CriticalSpeed]:
    found = cd.vibration.critical_speeds(
        rig.scene, [low, high], orders=rig.orders or None, **rig.options
    )
    return list(found)


def _against(rig: Rig, found: list[cd.vibration.CriticalSpeed]) -> list[str]:
    wrong, left = [], list(found)
    for row in rig.rows:
        # Instabilities that are known are the fastest growing ones.
        mine = [
            item
            for item in left
            if (np.isnan(item.order) if not row.order else item.order == row.order)
            and (not row.whirl or item.whirl == row.whirl)
        ]
        if not mine:
            wrong.append(f"{rig.name}: no row for {row}")
            continue
        at = row.values.get("speed", row.values.get("lower", 0.0))
        item = min(mine, key=lambda item: abs(item.speed - at))
        left.remove(item)
        for name, known in row.values.items():
            own, value = getattr(item, name), known(item.speed) if callable(known) else known
            tolerance = _TOLERANCES[name]
            if not _is_like(own, value, tolerance):
                wrong.append(
                    f"{rig.name} {row.order:g}× {row.whirl}: {name} is {own:.9g}, not {value:.9g}"
                )
    if not rig.others:
        wrong += [f"{rig.name}: a row too many, {item}" for item in left]
    return wrong


_TOLERANCES = {
    "speed": 1e-5,
    "severity": 1e-4,
    "lower": 1e-6,
    "upper": 1e-6,
    "rising": 1e-6,
    "falling": 1e-6,
    "rising_severity": 1e-3,
    "falling_severity": 1e-3,
    "frequency": 1e-6,
    "amplification": 1e-6,
}


def _is_like(first: float, second: float, tolerance: float) -> bool:
    if np.isnan(first) or np.isnan(second):
        return bool(np.isnan(first) and np.isnan(second))
    return bool(abs(first - second) <= tolerance * max(abs(first), abs(second)))


def _unlike(
    rig: Rig,
    found: list[cd.vibration.CriticalSpeed],
    other: list[cd.vibration.CriticalSpeed],
) -> list[str]:
    """Return the rows that differ between two tables within the first one's range."""
    inside = [row for row in other if rig.low <= row.speed <= rig.high]
    mine = [row for row in found if rig.low <= row.speed <= rig.high]
    if len(inside) != len(mine):
        return [f"{rig.name}: {len(inside)} rows, not {len(mine)}"]
    wrong = []
    for row, twin in zip(mine, inside, strict=True):
        for name in cd.vibration.CriticalSpeed._fields:
            own, value = getattr(row, name), getattr(twin, name)
            if isinstance(own, str) or name in ("order", "mode"):
                same = own == value or (own != own and value != value)
            elif name in ("lower", "upper") and own in (rig.low, rig.high):
                continue  # The interval goes on beyond the range, which is remarked.
            else:
                same = _is_like(own, value, 1e-5 if name != "speed" else 1e-4)
                same |= name == "severity" and max(own, value) < 1e-12
            if not same:
                wrong.append(f"{rig.name} {row.kind}: {name} is {value}, not {own}")
    return wrong


def _laval(random: np.random.Generator) -> Rig:
    """Springs alike: forward whirl alone is moved; the other row is the crossing itself."""
    mass, natural = float(random.uniform(1.0, 30.0)), float(random.uniform(50.0, 400.0))
    ratio, offset = float(10.0 ** random.uniform(-3.0, -0.7)), float(10.0 ** random.uniform(-5, -4))
    text = elastic_rigs.rotor(mass, offset, (mass * natural**2,) * 2, 2.0 * ratio * mass * natural)
    damped = natural * np.sqrt(1.0 - ratio**2)
    rows = [
        Row({**_unbalance(offset, natural, ratio), "amplification": 0.5 / ratio}, 1.0, "forward"),
        Row({"speed": damped, "severity": 0.0}, 1.0, "backward"),
    ]
    low, high = _around(random, natural, 0.3)
    return Rig("springs alike", elastic_rigs.scene(text, 0.0), low, high, (1.0,), rows)


def _uneven(random: np.random.Generator) -> Rig:
    """Springs that differ: both modes are moved, each as one of a single coordinate."""
    mass, natural = float(random.uniform(1.0, 30.0)), float(random.uniform(50.0, 400.0))
    other = natural * float(random.uniform(1.1, 1.6))
    damping, offset = (
        float(10.0 ** random.uniform(-2.7, -1.3)),
        float(10.0 ** random.uniform(-5, -4)),
    )
    drag = 2.0 * damping * mass * natural
    text = elastic_rigs.rotor(mass, offset, (mass * natural**2, mass * other**2), drag)
    rows = [Row(_unbalance(offset, at, drag / (2.0 * mass * at)), 1.0) for at in (natural, other)]
    low, high = 0.7 * natural, 1.3 * other
    return Rig("springs that differ", elastic_rigs.scene(text, 0.0), low, high, (1.0,), rows)


def _unbalance(offset: float, natural: float, ratio: float) -> dict[str, float]:
    """Greatest e r²/|1 - r² + 2 i ζ r|, at r = 1/√(1 - 2 ζ²), and half of its square h e²."""
    half = 0.5 / (2.0 * ratio * np.sqrt(1.0 - ratio**2)) ** 2
    square = np.sort(np.roots([half - 1.0, -half * (2.0 - 4.0 * ratio**2), half]))
    lower, upper = natural * np.sqrt(square)
    return {
        "speed": natural / np.sqrt(1.0 - 2.0 * ratio**2),
        "severity": offset / (2.0 * ratio * np.sqrt(1.0 - ratio**2)),
        "lower": lower,
        "upper": upper,
    }


def _balanced(random: np.random.Generator) -> Rig:
    """No unbalance: order 1 meets both modes at their damped frequencies and moves none."""
    mass, natural = float(random.uniform(1.0, 30.0)), float(random.uniform(50.0, 400.0))
    other = natural * float(random.uniform(1.1, 1.6))
    ratio = float(10.0 ** random.uniform(-3.0, -0.7))
    drag = 2.0 * ratio * mass * natural
    text = elastic_rigs.rotor(mass, 0.0, (mass * natural**2, mass * other**2), drag)
    rows = []
    for at in (natural, other):
        damped = at * np.sqrt(1.0 - (drag / (2.0 * mass * at)) ** 2)
        values = {"speed": damped, "severity": 0.0, "frequency": damped}
        rows.append(Row({**values, "lower": np.nan, "upper": np.nan}, 1.0))
    return Rig("balanced", elastic_rigs.scene(text, 0.0), 0.6 * natural, 1.5 * other, (1.0,), rows)


@dataclass(frozen=True)
class Stiffening:
    """M y'' + c y' + 2 k (1 - l/√(h² + y²)) y = m e Ω² cos φ, derivatives by φ, y in units of h.

    Attributes:
        speed: Ω/ω_n with ω_n² = 2 k (1 - l/h) / M.
        ratio: ζ.
        offset: e/h.
        slack: l/h.
    """

    speed: float
    ratio: float
    offset: float
    slack: float

    def __call__(self, phi: Array, q: Array, rate: Array) -> Array:
        stiffness = (1.0 - self.slack / np.sqrt(1.0 + q**2)) / (1.0 - self.slack)
        force = stiffness * q / self.speed**2 + 2.0 * self.ratio / self.speed * rate
        return self.offset * np.cos(phi) - force


def _stiffening(random: np.random.Generator) -> Rig:
    """A rotor that slides between two springs across its way, which stiffen it."""
    mass, natural = float(random.uniform(1.0, 5.0)), float(random.uniform(20.0, 200.0))
    height, slack = float(random.uniform(0.1, 0.5)), float(random.uniform(0.2, 0.8))
    ratio, peak = float(10.0 ** random.uniform(-2.3, -1.3)), float(random.uniform(0.05, 0.35))
    return stiffening(mass, natural, height, slack, ratio, peak)


def stiffening(
    mass: float,
    natural: float,
    height: float,
    slack: float,
    ratio: float,
    peak: float,
    nodes: int = 31,
    step: float = 0.02,
) -> Rig:
    """Return a rotor that slides between two springs across its way.

    Args:
        mass: M [kg].
        natural: ω_n of small motions [rad/s].
        height: h of the springs' feet beside the way [m].
        slack: l/h.
        ratio: ζ.
        peak: amplitude of a linear spring at resonance, as a fraction of h.
        nodes: of the continuation.
        step: of it.
    """
    offset = 2.0 * ratio * peak
    stiffness = mass * natural**2 / (2.0 * (1.0 - slack))
    text = elastic_rigs.rotor(mass, offset * height, (0.0, 1.0), 2.0 * ratio * mass * natural)
    springs = [
        cd.PointSpring(
            "base", [0.0, 0.0, side * height], "slide", [0.0, 0.0, 0.0], stiffness,
            length=slack * height,
        )
        for side in (-1.0, 1.0)
    ]  # fmt: skip
    mechanism = cd.load(text)
    scene = cd.Scene(
        mechanism,
        drive="bearing_in",
        free="y",
        held={"z": 0.0},
        elements=[*cd.described_elements(mechanism), *springs],
    )

    def system(speed: float) -> Acceleration:
        return Stiffening(speed, ratio, offset, slack)

    branch = Branch(system, 1, 2.0 * np.pi, nodes, peak)
    curve = branch.follow(0.5, 1.6, step)
    row = _resonant(branch, curve, 1.0, natural, height)
    low, high = 0.8 * natural, 1.3 * natural
    within = {"max_amplitude": 2.0 * peak * height / mechanism.characteristic_length}
    return Rig("stiffening", scene, low, high, (1.0,), [row], options=within)


@dataclass(frozen=True)
class Swinging:
    """An unbalanced disc on an arm that hangs: its weight pulls back less, the farther it swings.

    With the centre of mass at L u(θ) + e u(θ + φ), u the direction down, turned, by Lagrange:

        (M L² + M e² + J + 2 M L e cos φ) θ'' =
            M L e Ω (2 θ' + Ω) sin φ - M g (L sin θ + e sin (θ + φ)) - c θ'

    In units of M L² and ω_n² = g/L; derivatives by φ.

    Attributes:
        speed: Ω/ω_n.
        ratio: c/(2 M L² ω_n).
        offset: e/L.
        inertia: J/(M L²).
    """

    speed: float
    ratio: float
    offset: float
    inertia: float

    def __call__(self, phi: Array, q: Array, rate: Array) -> Array:
        e = self.offset
        mass = 1.0 + e**2 + self.inertia + 2.0 * e * np.cos(phi)
        back = (np.sin(q) + e * np.sin(q + phi)) / self.speed**2
        drag = 2.0 * self.ratio / self.speed * rate
        return (e * (2.0 * rate + 1.0) * np.sin(phi) - back - drag) / mass


def _swinging(random: np.random.Generator) -> Rig:
    """A resonance that leans to lower speeds."""
    mass, length = float(random.uniform(1.0, 5.0)), float(10.0 ** random.uniform(-1.5, 0.5))
    inertia, gravity = float(random.uniform(0.05, 0.5)), 9.81
    ratio, peak = float(10.0 ** random.uniform(-2.5, -1.5)), float(random.uniform(0.1, 0.8))
    offset = 2.0 * ratio * peak
    unit = float(np.sqrt(gravity / length))
    polar = inertia * mass * length**2
    text = (
        '<robot name="swinging"><link name="base"/><link name="arm"/><link name="disc"><inertial>'
        f'<origin xyz="0 0 {-offset * length!r}"/><mass value="{mass!r}"/>'
        f'<inertia ixx="{polar!r}" iyy="{polar!r}" izz="{polar!r}" ixy="0" ixz="0" iyz="0"/>'
        '</inertial></link><joint name="swing" type="continuous"><parent link="base"/>'
        '<child link="arm"/><axis xyz="1 0 0"/></joint><joint name="turn" type="continuous">'
        f'<parent link="arm"/><child link="disc"/><origin xyz="0 0 {-length!r}"/>'
        '<axis xyz="1 0 0"/></joint></robot>'
    )
    drag = 2.0 * ratio * mass * length**2 * unit
    scene = cd.Scene(
        cd.load(text),
        drive="turn",
        free="swing",
        elements=[cd.JointSpring("swing", 0.0, drag)],
        gravity=[0.0, 0.0, -gravity],
    )

    def system(speed: float) -> Acceleration:
        return Swinging(speed, ratio, offset, inertia)

    natural = 1.0 / np.sqrt(1.0 + inertia)
    branch = Branch(system, 1, 2.0 * np.pi, 31, peak)
    curve = branch.follow(0.5 * natural, 1.4 * natural, 0.01)
    row = _resonant(branch, curve, 1.0, unit, 1.0)
    low, high = _around(random, row.values["speed"], 0.2)
    return Rig("softening", scene, low, high, (1.0,), [row])


def _tilting(random: np.random.Generator) -> Rig:
    """Thoma's rig: its shaft tilts on springs, and a torque makes both whirls grow together."""
    beta = float(np.radians(random.uniform(5.0, 15.0)))
    share, ratio = float(random.uniform(0.1, 0.5)), float(10.0 ** random.uniform(-3.0, -2.5))
    natural, inertia = float(random.uniform(1.0, 300.0)), float(10.0 ** random.uniform(-2.0, 1.0))
    load = float(random.uniform(0.03, 0.1))
    text = elastic_rigs.elastic_rig(share * inertia, inertia, inertia * natural**2, ratio)
    torque = load * inertia * natural**2
    acts = {"shaft_out": [0.0, 0.0, 0.0, -torque, 0.0, 0.0]}
    scene = elastic_rigs.scene(text, beta, loads=acts)

    def system(speed: float) -> Acceleration:
        return TiltingShaft(beta, speed, share, 1.0, 1.0, ratio, load)

    # Whether the torque outweighs the dampers hardly depends on the speed.
    growth = max(_growth(system, speed, 2) for speed in np.linspace(0.9, 1.1, 5))

    def severity(at: float) -> float:
        # Near some speeds the joint drives it as well: what is found there has to be so.
        return natural * max(growth, _growth(system, at / natural, 2))

    low, high = 0.9 * natural, 1.1 * natural
    rows = []
    if growth > 0.0:
        rows.append(Row({"lower": low, "upper": high, "severity": severity}))
    return Rig("tilting", scene, low, high, (7.0,), rows, goes_on=True)


def _resonant(branch: Branch, curve: Curve, order: float, speed: float, size: float) -> Row:
    """Return the row of the greatest amplitude of an order along a branch of one coordinate.

    Args:
        branch: that was followed.
        curve: its motions.
        order: cycles per revolution.
        speed: unit of speeds.
        size: unit of amplitudes.
    """

    def amplitude(of: Curve) -> Array:
        return np.abs(of.order(order)[:, 0])

    top = int(np.argmax(amplitude(curve)))
    at, severity = branch.extremum(curve, top, amplitude)
    values = {"speed": at * speed, "severity": severity * size}
    names = ("rising", "falling")
    values |= dict.fromkeys((*names, *(f"{name}_severity" for name in names)), np.nan)
    for name, index in zip(names, curve.folds, strict=False):
        sense = 1.0 if name == "rising" else -1.0
        at, extreme = branch.extremum(curve, index, lambda of, sense=sense: sense * of.speed)
        values[name] = sense * extreme * speed
        # The amplitude right there, by its course over the branch.
        part = slice(index - 2, index + 3)
        ways = np.arange(-2.0, 3.0)
        speeds = np.polyfit(ways, curve.speed[part], 4)
        roots = np.roots(np.polyder(speeds))
        place = roots[np.argmin(np.abs(roots))].real
        sizes = np.polyfit(ways, amplitude(curve)[part], 4)
        values[f"{name}_severity"] = float(np.polyval(sizes, place)) * size
    return Row(values, order)


def _line(random: np.random.Generator) -> tuple[cd.Scene, Callable[[float], Acceleration], float]:
    """A spring in front of the joint: its scene, its system by Ω/ω_n, and ω_n."""
    beta, share = np.radians(random.uniform(10.0, 22.0)), float(random.uniform(0.3, 0.7))
    ratio = float(10.0 ** random.uniform(-2.5, -1.7))
    natural, inertia = float(random.uniform(1.0, 300.0)), float(10.0 ** random.uniform(-2.0, 1.0))
    text = elastic_rigs.torsional_line(
        *(inertia * (1.0 - share), inertia * share, inertia * natural**2),
        damping_in=2.0 * ratio * natural * inertia,
    )

    def system(speed: float) -> Acceleration:
        return SpringInFront(beta, speed, share, ratio)

    return elastic_rigs.scene(text, beta), system, natural


def _front(random: np.random.Generator) -> Rig:
    """Half of the natural frequency, where the resonance leans over to both sides."""
    scene, system, natural = _line(random)
    branch = Branch(system, 1, np.pi, 47, 0.3)
    curve = branch.follow(0.4, 0.62)
    row = _resonant(branch, curve, 2.0, natural, 1.0)
    low, high = _around(random, row.values["speed"], 0.1)
    return Rig("bent", scene, low, high, (2.0,), [row], options={"instabilities": True})


def _front_region(random: np.random.Generator) -> Rig:
    """Near the natural frequency the line is unstable, unless damping prevents it."""
    scene, system, natural = _line(random)
    low, high = 0.9 * natural, 1.1 * natural
    rows = []
    region = _region(system, 0.9, 1.1, 1)
    if region is not None:
        lower, upper, growth = region
        values = {"lower": lower * natural, "upper": upper * natural, "severity": growth * natural}
        rows.append(Row(values))
    return Rig("unstable", scene, low, high, (7.0,), rows)


def _growth(system: Callable[[float], Acceleration], speed: float, free: int) -> float:
    """Return how fast disturbances of the small motion grow, in units of the speed's [1/s]."""
    shot = periodic(system(speed), np.zeros(2 * free))
    return float(np.log(np.max(np.abs(shot.multipliers))) * speed / np.pi)


def _region(
    system: Callable[[float], Acceleration], low: float, high: float, free: int, count: int = 21
) -> tuple[float, float, float] | None:
    """Return edges and greatest growth [1/s] of the only unstable interval between two speeds."""

    def growth(speed: float) -> float:
        return _growth(system, speed, free)

    places = np.linspace(low, high, count)
    sizes = np.array([growth(place) for place in places])
    inside = np.nonzero(sizes > 0.0)[0]
    if not inside.size:
        return None
    from scipy.optimize import brentq, minimize_scalar

    first, last = inside[0], inside[-1]
    lower = float(brentq(growth, places[first - 1], places[first], xtol=1e-11))
    upper = float(brentq(growth, places[last], places[last + 1], xtol=1e-11))
    best = minimize_scalar(
        lambda speed: -growth(speed), bounds=(lower, upper), method="bounded",
        options={"xatol": 1e-6},
    )  # fmt: skip
    return lower, upper, -float(best.fun)


def _middle(random: np.random.Generator) -> Rig:
    """A double joint whose output is uniform: no order moves it, yet it is unstable."""
    beta, ratio = np.radians(random.uniform(15.0, 25.0)), float(10.0 ** random.uniform(-3.0, -2.2))
    natural = float(random.uniform(1.0, 200.0))
    text = elastic_rigs.double_joint(1.0, natural**2, 2.0 * ratio * natural)

    def system(speed: float) -> Acceleration:
        return ElasticMiddleShaft(beta, speed, 0.0, ratio)

    region = _region(system, 0.92, 1.09, 1)
    rows = []
    if region is not None:
        lower, upper, growth = region
        values = {"lower": lower * natural, "upper": upper * natural, "severity": growth * natural}
        rows.append(Row(values))
    low, high = 0.9 * natural, 1.12 * natural
    return Rig("elastic middle shaft", elastic_rigs.scene(text, beta), low, high, (7.0,), rows)


def _both(random: np.random.Generator) -> Rig:
    """Springs on both sides: two modes that are unstable together."""
    beta, damping = (
        np.radians(random.uniform(18.0, 25.0)),
        float(10.0 ** random.uniform(-3.5, -2.7)),
    )
    text = elastic_rigs.torsional_line(0.5, 0.5, 1.0, 1.0, damping, damping)

    def system(speed: float) -> Acceleration:
        return SpringsOnBothSides(beta, speed, damping=(damping, damping))

    # ω² = 3 ∓ √5 in units of k/(2 J).
    middle = float(np.mean(np.sqrt(3.0 + np.array([-1.0, 1.0]) * np.sqrt(5.0))))
    region = _region(system, 0.96 * middle, 1.04 * middle, 2, 21)
    rows = []
    if region is not None:
        lower, upper, growth = region
        rows.append(Row({"lower": lower, "upper": upper, "severity": growth}))
    scene = elastic_rigs.scene(text, beta)
    return Rig("both sides", scene, 0.96 * middle, 1.04 * middle, (7.0,), rows)


def _around(random: np.random.Generator, speed: float, share: float) -> tuple[float, float]:
    below, above = random.uniform(0.5 * share, share, 2)
    return speed * (1.0 - float(below)), speed * (1.0 + float(above))
