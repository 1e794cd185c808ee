"""Four-bar, slider-crank and six-bar against the free-body diagrams of their links.

Everything is compared over the full turn, with masses, at speed, under acceleration, gravity and
a load: positions with circle geometry, joint forces and drive torque with Newton's and Euler's
equations of the plane. Dimensions and masses are read from the files a second time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from testkit.planar import (
    FreeBodies,
    Moving,
    angle_of,
    circles,
    planar_link,
    turned,
    two_rates,
)
from testkit.urdf_reader import Reader, text

import cardan_dyn as cd

GRAVITY = 9.81
POSITIONS = np.linspace(0.0, 2.0 * np.pi, 361)
NAMES = ("four_bar", "slider_crank", "needle_drive")


@dataclass(frozen=True)
class Run:
    """How a mechanism is driven and loaded: rates of the drive, load on the output."""

    drive: str
    output: str
    speed: float
    acceleration: float
    load: float


RUNS = {
    "four_bar": Run("crank_bearing", "rocker_bearing", 30.0, -45.0, -60.0),
    "slider_crank": Run("crank_bearing", "piston_guide", 314.0, 900.0, -4000.0),
    "needle_drive": Run("main_shaft", "needle_guide", 209.0, -700.0, -150.0),
}


@dataclass(frozen=True)
class Solution:
    """Coordinates of the joints, and what each joint's parent exerts on its child."""

    coordinates: dict[str, np.ndarray]
    unknowns: dict[str, np.ndarray]

    def force(self, joint: str) -> np.ndarray:
        return np.stack([self.unknowns[f"{joint}.x"], self.unknowns[f"{joint}.y"]], axis=1)


def fixed_axis(pivot: np.ndarray, angle: np.ndarray, speed: np.ndarray, rate: np.ndarray) -> Moving:
    still = np.zeros((len(angle), 2))
    return Moving(still + pivot, still, angle, speed, rate)


def four_bar(reader: Reader, run: Run) -> Solution:
    links = {name: planar_link(reader, name) for name in ("crank", "coupler", "rocker")}
    crank_pin, pivot = reader.origin("crank_pin")[:2], reader.origin("rocker_bearing")[:2]
    coupler_end, rocker_end = (end[:2] for end in reader.ends("rocker_pin"))
    length_2, length_3 = np.linalg.norm(coupler_end), np.linalg.norm(rocker_end)
    phi, one = POSITIONS, np.ones_like(POSITIONS)

    crank = fixed_axis(np.zeros(2), phi, run.speed * one, run.acceleration * one)
    tip = crank.point(crank_pin)
    # The open branch: the rocker's pin to the left of the line from crank pin to pivot.
    pin = circles(tip, length_2, np.broadcast_to(pivot, tip.shape), length_3, side=1.0)
    arm_1, arm_2, arm_3 = tip, pin - tip, pin - pivot
    # ω₁ k×r₁ + ω₂ k×r₂ = ω₃ k×r₃, and its derivative.
    speed_2, speed_3 = two_rates(turned(arm_2), -turned(arm_3), -run.speed * turned(arm_1))
    centripetal = (
        run.speed**2 * arm_1 + (speed_2**2)[:, None] * arm_2 - (speed_3**2)[:, None] * arm_3
    )
    right = centripetal - run.acceleration * turned(arm_1)
    rate_2, rate_3 = two_rates(turned(arm_2), -turned(arm_3), right)
    coupler = Moving(tip, crank.point_acceleration(crank_pin), angle_of(arm_2), speed_2, rate_2)
    rocker = fixed_axis(pivot, angle_of(arm_3), speed_3, rate_3)

    bodies = FreeBodies(len(phi))
    for name, motion in (("crank", crank), ("coupler", coupler), ("rocker", rocker)):
        bodies.link(name, links[name], motion, GRAVITY)
    bodies.hinge("crank_bearing", "base", "crank", crank.origin)
    bodies.hinge("crank_pin", "crank", "coupler", tip)
    bodies.hinge("rocker_pin", "coupler", "rocker", pin)
    bodies.hinge("rocker_bearing", "base", "rocker", rocker.origin)
    bodies.couple("drive", "base", "crank")
    bodies.load("base", "rocker", rocker.origin, np.zeros(2), run.load)
    return Solution(
        {
            "crank_pin": coupler.angle - coupler.angle[0] - phi,
            "rocker_bearing": rocker.angle - rocker.angle[0],
        },
        bodies.solve(),
    )


def slider_crank(reader: Reader, run: Run) -> Solution:
    links = {name: planar_link(reader, name) for name in ("crank", "rod", "piston")}
    crank_pin, start = reader.origin("crank_pin")[:2], reader.origin("piston_guide")[:2]
    rod_end, piston_end = (end[:2] for end in reader.ends("piston_pin"))
    assert not np.any(piston_end)
    length = np.linalg.norm(rod_end)
    phi, one = POSITIONS, np.ones_like(POSITIONS)
    along = np.array([1.0, 0.0])

    crank = fixed_axis(np.zeros(2), phi, run.speed * one, run.acceleration * one)
    tip = crank.point(crank_pin)
    # The line of the pin cuts the rod's circle twice; the piston is on the side of the head.
    height = start[1] - tip[:, 1]
    pin = np.stack([tip[:, 0] + np.sqrt(length**2 - height**2), start[1] * one], axis=1)
    arm_1, arm_2 = tip, pin - tip
    # ω₁ k×r₁ + ω₂ k×r₂ = v e, and its derivative.
    slide = np.broadcast_to(-along, tip.shape)
    speed_2, _ = two_rates(turned(arm_2), slide, -run.speed * turned(arm_1))
    centripetal = run.speed**2 * arm_1 + (speed_2**2)[:, None] * arm_2
    right = centripetal - run.acceleration * turned(arm_1)
    rate_2, sliding = two_rates(turned(arm_2), slide, right)
    rod = Moving(tip, crank.point_acceleration(crank_pin), angle_of(arm_2), speed_2, rate_2)
    piston = Moving(pin, sliding[:, None] * along, 0.0 * phi, 0.0 * phi, 0.0 * phi)

    bodies = FreeBodies(len(phi))
    for name, motion in (("crank", crank), ("rod", rod), ("piston", piston)):
        bodies.link(name, links[name], motion, GRAVITY)
    bodies.hinge("crank_bearing", "base", "crank", crank.origin)
    bodies.hinge("crank_pin", "crank", "rod", tip)
    bodies.hinge("piston_pin", "rod", "piston", pin)
    bodies.force("piston_guide.across", "base", "piston", pin, turned(along))
    bodies.couple("piston_guide.couple", "base", "piston")
    bodies.couple("drive", "base", "crank")
    bodies.load("base", "piston", pin, run.load * along)
    return Solution(
        {"crank_pin": rod.angle - phi, "piston_guide": pin[:, 0] - start[0]}, bodies.solve()
    )


def needle_drive(reader: Reader, run: Run) -> Solution:
    names = ("eccentric", "coupler_1", "rocker", "coupler_2", "needle_bar")
    links = {name: planar_link(reader, name) for name in names}
    eccentric_pin, pivot = reader.origin("eccentric_pin")[:2], reader.origin("rocker_bearing")[:2]
    coupler_pin, start = reader.origin("coupler_pin")[:2], reader.origin("needle_guide")[:2]
    coupler_1_end, rocker_end = (end[:2] for end in reader.ends("rocker_pin"))
    coupler_2_end, bar_end = (end[:2] for end in reader.ends("needle_pin"))
    assert not np.any(bar_end)
    phi, one = POSITIONS, np.ones_like(POSITIONS)
    along = np.array([0.0, 1.0])

    eccentric = fixed_axis(np.zeros(2), phi, run.speed * one, run.acceleration * one)
    tip = eccentric.point(eccentric_pin)
    pivots = np.broadcast_to(pivot, tip.shape)
    length_2, length_3 = np.linalg.norm(coupler_1_end), np.linalg.norm(rocker_end)
    pin = circles(tip, length_2, pivots, length_3, side=1.0)
    arm_1, arm_2, arm_3 = tip, pin - tip, pin - pivot
    # First loop: ω₁ k×r₁ + ω₂ k×r₂ = ω₃ k×r₃.
    speed_2, speed_3 = two_rates(turned(arm_2), -turned(arm_3), -run.speed * turned(arm_1))
    centripetal = (
        run.speed**2 * arm_1 + (speed_2**2)[:, None] * arm_2 - (speed_3**2)[:, None] * arm_3
    )
    right = centripetal - run.acceleration * turned(arm_1)
    rate_2, rate_3 = two_rates(turned(arm_2), -turned(arm_3), right)
    tip_acceleration = eccentric.point_acceleration(eccentric_pin)
    coupler_1 = Moving(tip, tip_acceleration, angle_of(arm_2), speed_2, rate_2)
    rocker = fixed_axis(pivot, angle_of(arm_3) - angle_of(rocker_end), speed_3, rate_3)

    # Second loop: ω₃ k×r₄ + ω₅ k×r₅ = v e, the needle bar above the rocker.
    arm_4, end = rocker.arm(coupler_pin), rocker.point(coupler_pin)
    length_5, aside = np.linalg.norm(coupler_2_end), start[0] - end[:, 0]
    needle = np.stack([start[0] * one, end[:, 1] + np.sqrt(length_5**2 - aside**2)], axis=1)
    arm_5 = needle - end
    slide = np.broadcast_to(-along, tip.shape)
    speed_5, _ = two_rates(turned(arm_5), slide, -speed_3[:, None] * turned(arm_4))
    right = (speed_3**2)[:, None] * arm_4 + (speed_5**2)[:, None] * arm_5
    rate_5, sliding = two_rates(turned(arm_5), slide, right - rate_3[:, None] * turned(arm_4))
    end_acceleration = rocker.point_acceleration(coupler_pin)
    coupler_2 = Moving(end, end_acceleration, angle_of(arm_5), speed_5, rate_5)
    bar = Moving(needle, sliding[:, None] * along, 0.0 * phi, 0.0 * phi, 0.0 * phi)

    bodies = FreeBodies(len(phi))
    motions = (eccentric, coupler_1, rocker, coupler_2, bar)
    for name, motion in zip(names, motions, strict=True):
        bodies.link(name, links[name], motion, GRAVITY)
    bodies.hinge("main_shaft", "base", "eccentric", eccentric.origin)
    bodies.hinge("eccentric_pin", "eccentric", "coupler_1", tip)
    bodies.hinge("rocker_pin", "coupler_1", "rocker", pin)
    bodies.hinge("rocker_bearing", "base", "rocker", rocker.origin)
    bodies.hinge("coupler_pin", "rocker", "coupler_2", end)
    bodies.hinge("needle_pin", "coupler_2", "needle_bar", needle)
    bodies.force("needle_guide.across", "base", "needle_bar", needle, turned(along))
    bodies.couple("needle_guide.couple", "base", "needle_bar")
    bodies.couple("drive", "base", "eccentric")
    bodies.load("base", "needle_bar", needle, run.load * along)
    return Solution(
        {
            "eccentric_pin": coupler_1.angle - coupler_1.angle[0] - phi,
            "rocker_bearing": rocker.angle,
            "coupler_pin": (coupler_2.angle - coupler_2.angle[0]) - rocker.angle,
            "needle_guide": needle[:, 1] - start[1],
        },
        bodies.solve(),
    )


SOLUTIONS = {"four_bar": four_bar, "slider_crank": slider_crank, "needle_drive": needle_drive}
SLIDERS = {
    "slider_crank": ("piston_guide", [1.0, 0.0]),
    "needle_drive": ("needle_guide", [0.0, 1.0]),
}


def scene(name: str, **options: object) -> cd.Scene:
    run = RUNS[name]
    return cd.Scene(
        cd.load(name),
        drive=run.drive,
        loads={run.output: run.load},
        gravity=(0.0, -GRAVITY, 0.0),
        **options,
    )


@pytest.fixture(scope="module", params=NAMES)
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def solution(name: str) -> Solution:
    return SOLUTIONS[name](Reader(text(name)), RUNS[name])


@pytest.fixture(scope="module")
def turn(name: str) -> cd.Sweep:
    run = RUNS[name]
    return scene(name).sweep(POSITIONS, speed=run.speed, acceleration=run.acceleration)


def test_positions(name: str, solution: Solution, turn: cd.Sweep) -> None:
    for joint, expected in solution.coordinates.items():
        computed = turn.motion.position(joint)
        # The branch of the reference is the one of the file: both start at zero.
        assert abs(expected[0]) < 1e-15
        wrapped = np.unwrap(expected) if joint not in dict(SLIDERS.values()) else expected
        assert np.max(np.abs(computed - wrapped)) < 1e-12 * np.max(np.abs(wrapped)), joint


def test_joint_forces(name: str, solution: Solution, turn: cd.Sweep) -> None:
    hinges = {key.removesuffix(".x") for key in solution.unknowns if key.endswith(".x")}
    reader = Reader(text(name))
    count = len(reader.robot.findall("joint")) + len(reader.robot.findall("loop"))
    assert len(hinges) == count - len({name} & set(SLIDERS))
    for joint in hinges:
        expected = solution.force(joint)
        computed = turn.wrench(joint, "world").force[:, :2]
        assert np.max(np.abs(computed - expected)) < 1e-12 * np.max(np.abs(expected)), joint


def test_drive_torque(name: str, solution: Solution, turn: cd.Sweep) -> None:
    expected = solution.unknowns["drive"]
    assert np.max(np.abs(turn.drive_effort - expected)) < 1e-12 * np.max(np.abs(expected))
    along = turn.wrench(RUNS[name].drive, "world").moment[:, 2]
    assert np.max(np.abs(along - expected)) < 1e-12 * np.max(np.abs(expected))


@pytest.mark.parametrize("mechanism", SLIDERS)
def test_guides(mechanism: str) -> None:
    """A slider's guide: force across it, couple about the normal, and the load along it."""
    run, (guide, along) = RUNS[mechanism], SLIDERS[mechanism]
    expected = SOLUTIONS[mechanism](Reader(text(mechanism)), run).unknowns
    turn = scene(mechanism).sweep(POSITIONS, speed=run.speed, acceleration=run.acceleration)
    wrench = turn.wrench(guide, "world")
    scale = np.max(np.abs(expected[f"{guide}.across"]))
    across = wrench.force[:, :2] @ turned(np.array(along))
    assert np.max(np.abs(across - expected[f"{guide}.across"])) < 1e-12 * scale
    # The slide's centre of mass decides the couple; it can vanish, so a length gives its scale.
    couple = wrench.moment[:, 2] - expected[f"{guide}.couple"]
    assert np.max(np.abs(couple)) < 1e-12 * scale * 0.1
    np.testing.assert_allclose(wrench.axial, run.load, rtol=1e-13)


def test_residuals(turn: cd.Sweep) -> None:
    assert turn.loop_residual < 1e-13
    assert turn.balance_residual < 1e-12
    assert turn.power_residual < 1e-12


def test_quasi_static_torque_is_virtual_work(name: str) -> None:
    """Without mass forces the drive torque is -load times the velocity ratio."""
    run = RUNS[name]
    mechanism = cd.load(name)
    turn = cd.Scene(mechanism, drive=run.drive, loads={run.output: run.load}).sweep(POSITIONS)
    expected = -run.load * turn.motion.ratio(run.output)
    assert np.max(np.abs(turn.drive_effort - expected)) < 1e-12 * np.max(np.abs(expected))


def test_crank_rocker_swings_as_its_dead_centres_say() -> None:
    """Swing from both positions in which crank and coupler lie in line (law of cosines)."""
    turn = cd.Scene(cd.load("four_bar"), drive="crank_bearing").sweep(
        np.linspace(0.0, 2.0 * np.pi, 7201)
    )
    crank, coupler, rocker, frame = 0.08, 0.4, 0.25, 0.47

    def angle(reach: float) -> float:
        return float(np.arccos((rocker**2 + frame**2 - reach**2) / (2.0 * rocker * frame)))

    swing = np.ptp(turn.motion.position("rocker_bearing"))
    assert swing == pytest.approx(angle(coupler + crank) - angle(coupler - crank), abs=1e-7)
    assert np.degrees(swing) == pytest.approx(37.3, abs=0.05)


def test_strokes_of_the_descriptions() -> None:
    """Stroke 90 mm of the piston, 16 mm of the needle bar, as the headers say."""
    positions = np.linspace(0.0, 2.0 * np.pi, 721)
    piston = cd.Scene(cd.load("slider_crank"), drive="crank_bearing").sweep(positions)
    travel = piston.motion.position("piston_guide")
    assert np.max(travel) == pytest.approx(0.0, abs=1e-15)
    assert np.min(travel) == pytest.approx(-0.09, abs=1e-15)
    needles = cd.Scene(cd.load("needle_drive"), drive="main_shaft").sweep(positions)
    stroke = np.ptp(needles.motion.position("needle_guide"))
    assert stroke == pytest.approx(0.016, abs=5e-5)
