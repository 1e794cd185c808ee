"""Random planar linkages with clearance in one pin: four-bars, slider-cranks, six-bars.

Lengths, masses, centres, loads, speeds and contacts are drawn; a crank always turns through, and
its linkage stays away from dead positions. Nothing here looks at what the package makes of it but
for the stiffness, which is chosen for a wanted tau of the first reversal.
"""

from __future__ import annotations

import re
from typing import Any, NamedTuple

import numpy as np

import cardan_dyn as cd
from cardan_dyn import clearance

KINDS = ("four_bar", "slider_crank", "six_bar_slider", "six_bar_rocker")
LEAST_ANGLE = np.radians(30.0)
"""Between the bars that meet at the last pin of a group of two."""


class Loose(NamedTuple):
    """A linkage with play in one pin, and how it runs."""

    kind: str
    text: str
    joint: str
    speed: float
    contact: dict[str, float]
    loads: dict[str, float]
    gravity: tuple[float, float, float]

    @property
    def scene(self) -> cd.Scene:
        mechanism = cd.load(self.text)
        return cd.Scene(mechanism, drive="crank", loads=self.loads, gravity=self.gravity)


class _Drawer:
    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.parts = ['<link name="ground"/>']
        self.origins = {"ground": np.zeros(2)}

    def link(self, name: str, tip: np.ndarray, origin: np.ndarray) -> None:
        """A body between its first pin, where its frame is, and a tip, both in the world."""
        rng, along = self.rng, tip - origin
        length = float(np.linalg.norm(along)) or 0.1
        mass = float(np.exp(rng.uniform(np.log(0.1), np.log(4.0))))
        beside = rng.normal(0.0, 0.05) * np.array([-along[1], along[0]])
        x, y = (rng.uniform(0.2, 0.8) * along + beside).tolist()
        inertia = mass * (rng.uniform(0.2, 0.4) * length) ** 2
        self.parts.append(
            f'<link name="{name}"><inertial><origin xyz="{x!r} {y!r} 0"/><mass value="{mass!r}"/>'
            f'<inertia ixx="{inertia / 2!r}" iyy="{inertia / 2!r}" izz="{inertia!r}" ixy="0" '
            'ixz="0" iyz="0"/></inertial></link>'
        )
        self.origins[name] = origin

    def pin(self, name: str, parent: str, child: str, place: np.ndarray) -> None:
        x, y = (place - self.origins[parent]).tolist()
        self.parts.append(
            f'<joint name="{name}" type="continuous"><parent link="{parent}"/>'
            f'<child link="{child}"/><origin xyz="{x!r} {y!r} 0"/><axis xyz="0 0 1"/></joint>'
        )

    def guide(self, name: str, child: str, place: np.ndarray, way: np.ndarray) -> None:
        (x, y), (a, b) = place.tolist(), way.tolist()
        self.parts.append(
            f'<joint name="{name}" type="prismatic"><parent link="ground"/><child link="{child}"/>'
            f'<origin xyz="{x!r} {y!r} 0"/><axis xyz="{a!r} {b!r} 0"/>'
            '<limit lower="-9" upper="9" effort="0" velocity="0"/></joint>'
        )

    def loop(self, name: str, first: str, second: str, place: np.ndarray) -> None:
        ends = [(place - self.origins[link]).tolist() for link in (first, second)]
        self.parts.append(
            f'<loop name="{name}" type="continuous"><predecessor link="{first}">'
            f'<origin xyz="{ends[0][0]!r} {ends[0][1]!r} 0"/></predecessor>'
            f'<successor link="{second}"><origin xyz="{ends[1][0]!r} {ends[1][1]!r} 0"/>'
            '</successor><axis xyz="0 0 1"/></loop>'
        )


def _meets(
    first: np.ndarray, radius_1: float, second: np.ndarray, radius_2: float
) -> np.ndarray | None:
    """Where two circles about points `(N, 2)` meet; None where bars come too near to one line."""
    line = second - first
    distance = np.linalg.norm(line, axis=1)
    cosine = (radius_1**2 + radius_2**2 - distance**2) / (2.0 * radius_1 * radius_2)
    if np.max(np.abs(cosine)) > np.cos(LEAST_ANGLE):
        return None
    along = (radius_1**2 - radius_2**2 + distance**2) / (2.0 * distance)
    height = np.sqrt(radius_1**2 - along**2)
    unit = line / distance[:, None]
    normal = np.stack([-unit[:, 1], unit[:, 0]], axis=1)
    return np.asarray(first + along[:, None] * unit + height[:, None] * normal)


def _cranks(length: float) -> np.ndarray:
    angles = np.linspace(0.0, 2.0 * np.pi, 73)[:-1]
    return length * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _mechanism(drawer: _Drawer, kind: str) -> tuple[list[str], str]:
    """Describe a linkage; return its pins, and the joint that may be loaded."""
    rng = drawer.rng
    zero, base = np.zeros(2), np.zeros(2)
    if kind == "slider_crank":
        while True:
            crank, rod, offset = rng.uniform(0.02, 0.1), rng.uniform(0.1, 0.5), 0.0
            offset = rng.uniform(-0.3, 0.3) * rod
            if crank + abs(offset) < 0.7 * rod:
                break
        piston = np.array([crank + np.sqrt(rod**2 - offset**2), offset])
        drawer.link("a", np.array([crank, 0.0]), zero)
        drawer.link("b", piston, np.array([crank, 0.0]))
        drawer.link("c", piston + np.array([0.05, 0.0]), piston)
        drawer.pin("crank", "ground", "a", zero)
        drawer.pin("crank_pin", "a", "b", np.array([crank, 0.0]))
        drawer.guide("guide", "c", piston, np.array([1.0, 0.0]))
        drawer.loop("piston_pin", "b", "c", piston)
        return ["crank", "crank_pin", "piston_pin"], "guide"
    while True:
        crank, coupler, rocker, ground = rng.uniform([0.02, 0.1, 0.1, 0.1], [0.1, 0.5, 0.5, 0.5])
        base = np.array([ground, 0.0])
        cranks = _cranks(crank)
        knees = _meets(cranks, coupler, np.tile(base, (72, 1)), rocker)
        if knees is None:
            continue
        if kind == "four_bar":
            break
        # A point of the rocker carries a rod to a second rocker, or to a slider.
        aside, part = rng.uniform(-0.4, 0.4), rng.uniform(0.6, 1.5)
        arm = knees - base
        tips = base + part * arm + aside * np.stack([-arm[:, 1], arm[:, 0]], axis=1)
        rod = rng.uniform(0.1, 0.5)
        if kind == "six_bar_rocker":
            last = rng.uniform(0.1, 0.5)
            far = base + rng.uniform(-0.5, 0.5, 2)
            ends = _meets(tips, rod, np.tile(far, (72, 1)), last)
            if ends is None or np.linalg.norm(far - base) < 0.1:
                continue
            break
        height = rng.uniform(-0.4, 0.4) * rod + np.mean(tips[:, 1])
        sines = (height - tips[:, 1]) / rod
        if np.max(np.abs(sines)) > 0.8:
            continue
        ends = tips + rod * np.stack([np.sqrt(1.0 - sines**2), sines], axis=1)
        break
    drawer.link("a", cranks[0], zero)
    drawer.link("b", knees[0], cranks[0])
    drawer.link("c", knees[0], base)
    drawer.pin("crank", "ground", "a", zero)
    drawer.pin("crank_pin", "a", "b", cranks[0])
    drawer.pin("rocker", "ground", "c", base)
    drawer.loop("knee", "b", "c", knees[0])
    pins = ["crank", "crank_pin", "rocker", "knee"]
    if kind == "four_bar":
        return pins, "rocker"
    drawer.link("d", ends[0], tips[0])
    drawer.pin("rod_pin", "c", "d", tips[0])
    if kind == "six_bar_rocker":
        drawer.link("e", ends[0], far)
        drawer.pin("lever", "ground", "e", far)
        drawer.loop("end_pin", "d", "e", ends[0])
        return [*pins, "rod_pin", "lever", "end_pin"], "lever"
    drawer.link("e", ends[0] + np.array([0.05, 0.0]), ends[0])
    drawer.guide("guide", "e", ends[0], np.array([1.0, 0.0]))
    drawer.loop("end_pin", "d", "e", ends[0])
    return [*pins, "rod_pin", "end_pin"], "guide"


def draw(seed: int) -> Loose | None:
    """Return a case; None if no force of the pin that was drawn swings round."""
    drawer = _Drawer(seed)
    rng = drawer.rng
    kind = KINDS[seed % len(KINDS)]
    pins, loaded = _mechanism(drawer, kind)
    text = f'<robot name="{kind}">{"".join(drawer.parts)}</robot>'
    speed = float(np.exp(rng.uniform(np.log(20.0), np.log(400.0)))) * float(rng.choice([-1.0, 1.0]))
    gap = float(np.exp(rng.uniform(np.log(1e-5), np.log(3e-4))))
    loose = Loose(kind, text, pins[0], speed, {"clearance": gap}, {}, (0.0, 0.0, 0.0))
    if rng.random() < 0.35:
        plain = loose.scene.sweep(np.linspace(0.0, 2.0 * np.pi, 90), speed)
        most = float(np.max(np.linalg.norm(plain[loaded].force, axis=1)))
        unit = 0.2 if loaded in pins else 1.0
        loose = loose._replace(loads={loaded: float(rng.uniform(-0.4, 0.4)) * most * unit})
    ratio, tau = float(rng.uniform(0.1, 0.5)), float(np.exp(rng.uniform(np.log(2.0), np.log(20.0))))
    scanned = clearance.scan(
        loose.scene, speed, clearance=gap, stiffness=1e8, joints=pins, start="rest"
    )
    least = {
        name: min(scanned[name].reversals, key=lambda item: item.turn_through)
        for name in pins
        if scanned[name].reversals
    }
    near = sorted(least, key=lambda name: least[name].turn_through)
    if not near:
        return None
    joint = near[0] if rng.random() < 0.6 else str(rng.choice(near))
    stiffness = 1e8 * (tau / least[joint].tau) ** 2
    contact: dict[str, Any] = {
        "clearance": gap,
        "stiffness": stiffness,
        "damping_ratio": ratio,
    }
    return loose._replace(joint=joint, contact=contact)


TURNS, RTOL = 2.6, 1e-8
"""Of simulations: every reversal is passed once or twice after a quarter of a turn."""
UNSAFE = 0.1
"""By which an estimate without a doubt may be below a simulation."""


class Passed(NamedTuple):
    """A reversal as it was stated, and as it was simulated."""

    item: clearance.ForceReversal
    simulated: float

    @property
    def is_inside(self) -> bool:
        """Whether the interval holds what was simulated."""
        return self.item.least <= self.simulated <= self.item.greatest

    @property
    def is_unsafe(self) -> bool:
        """Whether the estimate is too low, and nothing is said against it."""
        return not self.item.doubts and self.item.estimate < (1.0 - UNSAFE) * self.simulated


def passed(loose: Loose, rtol: float = RTOL) -> list[Passed]:
    """Scan and simulate a linkage; the greatest forces are taken from the simulation's own times.

    They are found by their positions alone, not by the package's comparison.
    """
    given: dict[str, Any] = loose.contact
    found = clearance.scan(loose.scene, loose.speed, joints=loose.joint, **given)[loose.joint]
    simulation = clearance.simulate(
        loose.scene, loose.speed, joints=loose.joint, turns=TURNS, rtol=rtol, **given
    )
    steps = simulation.steps
    parts = np.linspace(0.0, 1.0, 8, endpoint=False)
    times = (steps[:-1, None] + np.diff(steps)[:, None] * parts).ravel()
    course = simulation.at(times)[loose.joint]
    sense, turn = np.sign(loose.speed), 2.0 * np.pi
    begun, ended = sense * course.position[[0, -1]]
    result = []
    for item in found.reversals:
        way = sense * (course.position - item.position)
        first = np.ceil((begun + 0.25 * turn - sense * item.position) / turn)
        peaks = []
        while sense * item.position + first * turn + item.way <= ended:
            inside = (way >= first * turn) & (way <= first * turn + item.way)
            peaks.append(float(np.max(course.force[inside])))
            first += 1.0
        if peaks:
            result.append(Passed(item, float(np.mean(peaks))))
    return result


def ask(seed: int) -> tuple[list[str], list[str]]:
    """Return estimates that are too low without a doubt, and how reversals fared."""
    loose = draw(seed)
    if loose is None:
        return [], ["no force swings round"]
    wrong, counted = [], []
    for item in passed(loose):
        counted.append("reversal inside" if item.is_inside else f"reversal outside, seed {seed}")
        if item.is_unsafe:
            stated = f"{item.item.least:.5g} to {item.item.greatest:.5g}; {item.item.verdict}"
            wrong.append(f"{loose.kind} {loose.joint}: {item.simulated:.5g} N, stated {stated}")
    return wrong, counted


def _number(text: str, pattern: str) -> float:
    found = re.search(pattern, text)
    return float(found[1]) if found else np.nan


def misprinted(loose: Loose, found: clearance.Scan) -> list[str]:
    """Return what is printed of the joints of a scan and is less than something that is known.

    Of forces without clearance those of an own, denser sweep. Printed are four digits.
    """
    wrong = []
    lines = {line[2:].split(":")[0]: line for line in str(found).splitlines() if line[:2] == "- "}
    rows, tops = found.rows(), []
    positions = np.linspace(0.0, 2.0 * np.pi, 1501)
    plain = loose.scene.sweep(positions, loose.speed)
    for name in found.ranking:
        joint = found[name]
        known = {"without clearance": float(np.max(np.linalg.norm(plain[name].force, axis=1)))}
        for item in joint.reversals:
            known[f"at {item.position:.2f} rad"] = float(np.nanmax([item.least, item.greatest]))
            if np.isnan(item.greatest):
                known[f"estimate at {item.position:.2f} rad"] = item.estimate
        known["interval"] = joint.greatest
        known["table"] = max(row["peak"] for row in rows if row["joint"] == name)
        top = _number(lines[name], r": (?:up to )?(\S+) N (?:at most|in |estimated)")
        tops.append(top)
        for what, force in known.items():
            if force > 1.001 * top:
                wrong.append(f"{name}: {top} N printed, {force:.5g} N known: {what}")
        if not np.isclose(joint.peak, max(joint.rigid_peak, known["table"]), rtol=1e-12):
            wrong.append(f"{name}: peak of {joint.peak:.6g} N, table of {known['table']:.6g} N")
        if not top > 0.0:
            wrong.append(f"{name}: {top} N printed")
        if not joint.doubts and np.isnan(joint.greatest):
            wrong.append(f"{name}: no interval, and no word of it")
    if tops != sorted(tops, reverse=True):
        wrong.append(f"ranked as {tops}")
    return wrong


EVERY = 6
"""Of so many linkages one is simulated."""
STEP, JUMP = 1e-6, 0.02
"""Change of the speed, as a fraction, and what a peak without a doubt changes by no more than."""


def ask_peaks(seed: int) -> tuple[list[str], list[str]]:
    """Return what a scan of all pins prints too low, and how forces of turns fared.

    Of some linkages, the speed is changed a little, and one pin is simulated.
    """
    loose = draw(seed)
    if loose is None:
        return [], ["no force swings round"]
    given: dict[str, Any] = loose.contact
    found = clearance.scan(loose.scene, loose.speed, **given)
    wrong = misprinted(loose, found)
    counted = ["joint with a doubt" if joint.doubts else "joint" for joint in found.values()]
    if seed % EVERY:
        return wrong, counted
    near = clearance.scan(loose.scene, (1.0 + STEP) * loose.speed, **given)
    for name, joint in found.items():
        change = near[name].peak / joint.peak - 1.0
        if not joint.doubts and not near[name].doubts and abs(change) > JUMP:
            wrong.append(f"{name}: jumps by {100 * change:.1f} %")
    name = found.ranking[(seed // EVERY) % len(found)]
    joint, turn = found[name], 2.0 * np.pi
    simulation = clearance.simulate(
        loose.scene, loose.speed, joints=name, turns=TURNS, rtol=1e-6, **given
    )
    steps = simulation.steps
    parts = np.linspace(0.0, 1.0, 8, endpoint=False)
    course = simulation.at((steps[:-1, None] + np.diff(steps)[:, None] * parts).ravel())[name]
    turns = np.floor(np.abs(course.position - course.position[0]) / turn - 0.25)
    for k in (0, 1):
        force = float(np.max(course.force[turns == k]))
        if joint.least <= force <= joint.peak:
            counted.append("turn inside")
            continue
        said = "above" if force > joint.peak else "below"
        doubt = " with a doubt" if joint.doubts else ""
        counted.append(f"turn {said}{doubt}, seed {seed}")
        if said == "above" and not doubt:
            wrong.append(f"{name}: {force:.5g} N simulated; {joint.summary}")
    return wrong, counted
