"""Edges of unstable regions against shooting, theory and simulation."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from shooting import edge, periodic
from testkit import elastic_rigs
from vibrating_lines import SpringInFront

from cardan_dyn import vibration
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene
from cardan_dyn.motion.vibration.motions.regions import StabilityOverSpeed, regions
from cardan_dyn.motion.vibration.motions.search import MotionSearch
from cardan_dyn.motion.vibration.motions.stability import FOLD, NONE, STABLE, stability


@pytest.mark.slow
def test_first_region_of_a_spring_in_front() -> None:
    """15°, a = 1/2: 0.9911629395 … 1.0084989812, found between coarse steps."""
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(), np.radians(15.0))
    (found,) = vibration.floquet(scene, [0.7, 0.85, 0.97, 1.1, 1.2], edges=True).regions
    assert found.kind == "instability"
    assert found.lower == pytest.approx(0.9911629395, abs=1e-8)
    assert found.upper == pytest.approx(1.0084989812, abs=1e-8)
    assert found.is_closed
    assert found.width == pytest.approx(0.0173, abs=1e-4)
    beta = np.radians(15.0)
    shot = periodic(SpringInFront(beta, found.speed), np.array([0.0, 0.05]))
    # A half turn takes π/Ω.
    growth = np.log(np.max(np.abs(shot.multipliers))) * found.speed / np.pi
    assert found.growth == pytest.approx(growth, rel=1e-6)


@pytest.mark.slow
def test_narrow_third_region() -> None:
    """45°: 3.9e-3 wide about 1/3."""
    beta = np.radians(45.0)
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(), beta)
    (found,) = vibration.floquet(scene, np.linspace(0.31, 0.37, 7), edges=True).regions
    assert found.width == pytest.approx(3.9e-3, abs=5e-5)

    def trace(speed: float) -> float:
        return periodic(SpringInFront(beta, speed), np.array([0.0, 0.05])).trace + 2.0

    assert found.lower == pytest.approx(edge(trace, 0.3372, 0.3374, 1e-10), abs=1e-6)


def test_damping_closes_the_first_region() -> None:
    """From ζ = a β²/4 on."""
    beta = np.radians(15.0)
    limit = float(0.125 * beta**2)
    for factor, count in ((0.9, 1), (1.1, 0)):
        line = elastic_rigs.torsional_line(damping_in=2.0 * factor * limit)
        found = vibration.floquet(
            elastic_rigs.scene(line, beta), np.linspace(0.95, 1.05, 11), edges=True
        )
        assert len(found.regions) == count


def test_a_region_that_goes_on_is_not_closed() -> None:
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(), np.radians(30.0))
    (found,) = vibration.floquet(scene, [0.98, 1.0, 1.2], edges=True).regions
    assert found.lower == 0.98
    assert not found.is_closed


@pytest.mark.slow
def test_a_simulation_grows_inside_and_stays_bounded_outside() -> None:
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(), np.radians(20.0))
    (found,) = vibration.floquet(scene, np.linspace(0.9, 1.1, 9), edges=True).regions
    sizes = {}
    for name, speed in (
        ("inside", found.lower + 0.02 * found.width),
        ("outside", found.lower - 0.02 * found.width),
    ):
        motion = vibration.periodic_motion(scene, speed)
        begin = motion.at(0.0)
        duration = 200.0 * np.pi / speed
        run = scene.simulate(
            duration,
            position={"twist_in": begin.position[0, 0, 0] + 1e-7},
            speed={"twist_in": begin.velocity[0, 0, 0] + 1e-7},
            motion={"bearing_in": speed},
            rtol=1e-10,
        )
        times = np.linspace(0.0, duration, 4001)
        gap = np.asarray(run.at(times).position)[:, 1] - motion.at(speed * times).position[0, :, 0]
        sizes[name] = np.max(np.abs(gap[3600:]))
    assert sizes["outside"] < 5e-6
    assert sizes["inside"] > 10.0 * sizes["outside"]


def test_what_lies_beyond_a_speed_without_a_motion_is_not_known() -> None:
    """The first region of 30°, from 0.966 to 1.033, of whose middle nothing is told."""
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(), np.radians(30.0))
    search = MotionSearch(rotating_scene(scene))
    speeds = np.array([0.9, 0.98, 1.0, 1.02, 1.1])
    known = stability(search, speeds)
    known.kind[2] = NONE
    known.multipliers[2] = np.nan
    below, above = regions(StabilityOverSpeed(search, speeds, known), speeds, known)
    assert (below.upper, above.lower) == (0.98, 1.02)
    (whole,) = vibration.floquet(scene, speeds, edges=True).regions
    assert (below.lower, above.upper) == pytest.approx((whole.lower, whole.upper), rel=1e-7)
    assert whole.is_closed and not below.is_closed and not above.is_closed
    known.kind[:] = NONE
    assert regions(StabilityOverSpeed(search, speeds, known), speeds, known) == []


def test_the_greatest_growth_of_several_is_found() -> None:
    """Growth has two tops in a region; the lower one lies next to a speed that was looked at."""

    def judged(speeds: np.ndarray) -> SimpleNamespace:
        first, second = (
            size * np.exp(-(((speeds - at) / 0.02) ** 2)) for size, at in ((0.9, 1.0), (1.0, 1.12))
        )
        excess = first + second - 0.1
        grows = excess > 0.0
        size, kind = len(speeds), np.where(grows, FOLD, STABLE)
        values = np.column_stack([1.0 + excess, np.zeros(size)]).astype(complex)
        return SimpleNamespace(
            excess=excess, kind=kind, grows=grows, multipliers=values, decays=np.zeros(size, bool)
        )

    speeds = np.array([0.9, 0.98, 1.0, 1.02, 1.05, 1.08, 1.1, 1.14, 1.2])
    known = judged(speeds)
    known.kind[3:6], known.excess[3:6] = FOLD, 1e-6  # One region.
    assert known.excess[2] > max(known.excess[6:])
    over = SimpleNamespace(at=judged, period=np.pi)
    (found,) = regions(over, speeds, known)
    assert found.speed == pytest.approx(1.12, abs=1e-3)
    assert found.growth == pytest.approx(np.log1p(0.9) * 1.12 / np.pi, rel=1e-3)
