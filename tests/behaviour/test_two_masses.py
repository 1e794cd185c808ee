"""Two masses across a clearance, as a scene: one slide, a pin contact and a force over time.

References: Dresig and Thümmel's numbers, the closed forms of `analytic`, motions that SciPy
integrates from equations written down here, and closed forms of the joint without clearance.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import cardan_dyn as cd
from cardan_dyn.analytic import impact
from cardan_dyn.analytic.damped_impact import damped_peak, flight
from cardan_dyn.clearance import ContactLaw, HuntCrossley, ImpactFunction, LinearContact

MASS, HALF, RAMP, STIFFNESS = 3.6, 0.5e-4, 360e3, 1e7
SPRING = LinearContact(STIFFNESS)


def scene(
    law: ContactLaw, force: Callable[[float], float] | None = None, half: float = HALF
) -> cd.Scene:
    """The reduced mass on a slide, 0 in the middle of the play 2 s."""
    pair = cd.load(
        '<robot name="pair"><link name="left"/><link name="right"><inertial>'
        f'<mass value="{MASS!r}"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
        '</inertial></link><joint name="gap" type="prismatic"><parent link="left"/>'
        '<child link="right"/><axis xyz="1 0 0"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
    )
    pin = cd.PinContact("left", (0, 0, 0), (0, 0, 1), "right", (0, 0, 0), 2.0 * half, law)  # type: ignore[arg-type]
    acts = [] if force is None else [cd.Actuator("gap", force)]
    return cd.Scene(pair, free="gap", elements=[pin, *acts])


def released(law: LinearContact, start: str, ramp: float = RAMP, half: float = HALF) -> Any:
    """The motion under a ramp until its first peak is over: from rest, or as a contact unloads."""
    rate = ramp / law.stiffness if start == "release" else 0.0
    # Pressed steadily, the damper carries its part of the ramp.
    depth = law.damping * rate / law.stiffness
    ratio = law.damping / (2.0 * np.sqrt(law.stiffness * MASS))
    found = flight(MASS, law.stiffness, half, ramp, ratio, start=start)  # type: ignore[arg-type]
    end = float(found.t_1) + np.pi * np.sqrt(MASS / law.stiffness)
    return scene(law, lambda time: ramp * time, half).simulate(
        end, position=-half - depth, speed=rate, rtol=1e-12
    )


@pytest.mark.slow
@pytest.mark.parametrize(("start", "peak"), [("rest", 2181.89), ("release", 1833.27)])
def test_the_papers_example(start: str, peak: float) -> None:
    motion = released(SPRING, start)
    touch = motion.touches[-1]
    assert touch.peak == pytest.approx(peak, abs=0.005)
    if start == "rest":
        assert touch.start == pytest.approx(1.81712e-3, abs=5e-9)
        assert touch.speed == pytest.approx(0.165096, abs=5e-7)
        rigid = RAMP * touch.peak_time
        assert (rigid, touch.peak - rigid) == pytest.approx((1191.31, 990.58), abs=0.005)
    assert motion.energy_residual < 1e-12


@pytest.mark.parametrize("start", ["rest", "release"])
@pytest.mark.parametrize("tau", [2.5, 7.0, 20.0])
def test_the_peak_is_that_of_the_closed_form(tau: float, start: Any) -> None:
    ramp = 12.0 * MASS * HALF * (STIFFNESS / MASS) ** 1.5 / tau**3
    expected = impact.reversal(MASS, STIFFNESS, HALF, ramp, start=start)
    assert float(expected.tau) == pytest.approx(tau)
    peak = released(SPRING, start, ramp).touches[-1].peak
    assert peak == pytest.approx(float(expected.peak), rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [0.05, 0.25, 0.7])
@pytest.mark.parametrize("start", ["rest", "release"])
def test_a_damped_peak(ratio: float, start: Any) -> None:
    touch = released(LinearContact.of_ratio(STIFFNESS, ratio, MASS), start).touches[-1]
    found = flight(MASS, STIFFNESS, HALF, RAMP, ratio, start=start)
    assert touch.start == pytest.approx(float(found.t_1), rel=1e-9)
    assert touch.speed == pytest.approx(float(found.v_1), rel=1e-9)
    wanted = damped_peak(MASS, STIFFNESS, HALF, RAMP, ratio, start=start)
    assert touch.peak == pytest.approx(float(wanted), rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    "law",
    [
        SPRING,
        LinearContact.of_ratio(STIFFNESS, 0.5, MASS),
        HuntCrossley(3e9, 1.5, factor=3.0),
        ImpactFunction(3e9, 1.5, 3e3, 2e-5),
    ],
)
def test_a_force_that_swings_drives_from_side_to_side(law: ContactLaw) -> None:
    """Against the same equations, clipped on both sides, by SciPy."""

    def force(time: float) -> float:
        return float(900.0 * np.sin(400.0 * time))

    def rate(time: float, y: np.ndarray) -> list[float]:
        far, near = float(y[0]) - HALF, -float(y[0]) - HALF
        pressed = max(float(law.force(far, float(y[1]))), 0.0) if far > 0.0 else 0.0
        pressed -= max(float(law.force(near, -float(y[1]))), 0.0) if near > 0.0 else 0.0
        return [float(y[1]), (force(time) - pressed) / MASS]

    motion = scene(law, force).simulate(0.03, position=0.0, speed=0.0, rtol=1e-11)
    assert len({round(float(item.direction[0])) for item in motion.touches}) == 2
    run = solve_ivp(
        rate, (0.0, 0.03), [0.0, 0.0], method="DOP853",
        rtol=1e-11, atol=1e-15, max_step=1e-5, t_eval=np.linspace(0.0, 0.03, 301),
    )  # fmt: skip
    state = motion.at(run.t)
    np.testing.assert_allclose(state.position.ravel(), run.y[0], atol=1e-6 * 1e-4)
    np.testing.assert_allclose(state.speed.ravel(), run.y[1], atol=1e-5 * 0.2)


@pytest.mark.slow
@pytest.mark.parametrize(
    "law", [LinearContact.of_ratio(STIFFNESS, 0.2, MASS), HuntCrossley(3e9, 1.5, 0.8)]
)
def test_free_impacts_lose_what_the_law_says(law: ContactLaw) -> None:
    motion = scene(law).simulate(1.0, position=0.0, speed=0.3, rtol=1e-11, max_touches=4)
    speeds = [item.speed for item in motion.touches]
    assert len(speeds) == 4
    for before, after in pairwise(speeds):
        assert after / before == pytest.approx(law.restitution(before, MASS), abs=1e-8)


@pytest.mark.slow
def test_a_vanishing_play_gives_the_elastic_joint() -> None:
    """Its force c q of m q'' + c q = A sin Ωt in closed form, from the same pressed rest."""
    amplitude, speed = 900.0, 400.0
    lasts = np.pi / speed
    times = np.linspace(0.0, lasts, 2001)[1:-1]
    omega = np.sqrt(STIFFNESS / MASS)
    forced = amplitude / (1.0 - MASS * speed**2 / STIFFNESS)
    elastic = -forced * np.cos(speed * times) + (forced - amplitude) * np.cos(omega * times)
    errors = []
    for clearance in (1e-7, 1e-8):
        pair = scene(SPRING, lambda time: float(-amplitude * np.cos(speed * time)), 0.5 * clearance)
        begun = -0.5 * clearance - amplitude / STIFFNESS
        motion = pair.simulate(lasts, position=begun, speed=0.0, rtol=1e-11).at(times)
        pressed = -motion.element_force[0].force[:, 0]
        errors.append(float(np.max(np.abs(pressed - elastic))) / amplitude)
    assert errors[0] < 2e-3
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.05)


@pytest.mark.slow
def test_undamped_impacts_are_chaotic_after_the_first() -> None:
    """Starts that differ by 1e-12 of the play agree in three impacts, and no longer later on."""

    def impacts(shift: float) -> list[float]:
        pair = scene(LinearContact(1e8), lambda time: float(900.0 * np.sin(400.0 * time)), 5e-4)
        motion = pair.simulate(
            1.0, position=-5e-4 + 1e-3 * shift, speed=0.0, rtol=1e-12, max_touches=26
        )
        return [item.peak for item in motion.touches]

    first, second = np.array(impacts(0.0)), np.array(impacts(1e-12))
    gap = np.abs(first / second - 1.0)
    assert np.all(gap[:3] < 1e-10)
    assert gap[-1] > 1e-3
