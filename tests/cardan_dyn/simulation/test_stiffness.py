"""Stiffness: modes of systems whose modes are known, and starts that ring or rest."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from testkit.simulated import link

import cardan_dyn as cd
from cardan_dyn.motion.simulation.stiffness import Modes, Stiffness, judged

SLOW, FAST = 3.0, 3e4


def rates(y: np.ndarray) -> np.ndarray:
    """Two oscillators: a slow one, and a fast one that is pulled along by the slow one."""
    slow, fast, slow_rate, fast_rate = y
    return np.array([slow_rate, fast_rate, -(SLOW**2) * slow, -(FAST**2) * (fast - 1e-3 * slow)])


FINE, COARSE = 1e-8, 1e-6
RINGING = np.array([1.0, 0.0, 0.0, 0.0])
RESTING = np.array([1.0, 1e-3, 0.0, 0.0])


def looking(tolerance: float, of: Callable[[np.ndarray], np.ndarray] = rates) -> Stiffness:
    return Stiffness(lambda time, y: of(y), 2, np.ones(4), 0.0, tolerance, 1.0)


def modes(y: np.ndarray, tolerance: float) -> Modes:
    return looking(tolerance).modes(0.0, y)


def test_modes_have_the_frequencies_of_the_oscillators() -> None:
    found = modes(RINGING, FINE)
    sizes = np.sort(np.abs(found.values))
    np.testing.assert_allclose(sizes, [SLOW, SLOW, FAST, FAST], rtol=1e-6)
    # The fast one is 1e-3 away from where it would rest: half of it in either of two modes.
    fast = np.abs(found.values) > 1e3
    away = found.amplitudes[fast] * 1e-8
    np.testing.assert_allclose(away * np.abs(found.values[fast]) / FAST, 0.5e-3 * FAST, rtol=1e-3)


def test_a_start_that_rests_is_stiff_and_one_that_rings_is_not() -> None:
    rings = judged(modes(RINGING, FINE), 1.0, 0.0)
    assert not rings.is_stiff
    assert rings.frequency == pytest.approx(FAST / (2.0 * np.pi), rel=1e-6)
    # The fast one follows the slow one with a lag of 3e-7 in speed.
    rests = judged(modes(RESTING, COARSE), 1.0, 0.0)
    assert rests.is_stiff
    assert rests.frequency == 0.0


def test_few_steps_are_not_worth_another_method() -> None:
    assert not judged(modes(RESTING, COARSE), 1e-3, 0.0).is_stiff


def test_what_rings_is_settled_and_what_is_slow_stays() -> None:
    found = looking(FINE).settled(RINGING, lambda y: y, 1.0)
    assert found[0] == pytest.approx(1.0, abs=1e-6)
    assert found[1] == pytest.approx(1e-3, rel=1e-6)
    assert judged(modes(found, FINE), 1.0, 0.0).is_stiff


def test_without_a_gap_between_modes_nothing_is_settled() -> None:
    def alike(y: np.ndarray) -> np.ndarray:
        return np.array([y[2], y[3], -9.0 * y[0], -16.0 * y[1]])

    found = looking(FINE, alike).settled(RINGING, lambda y: y, 1.0)
    np.testing.assert_array_equal(found, RINGING)


def pendulum_on_rubber() -> cd.Scene:
    """A pendulum whose pivot slides against a stiff bushing, under gravity."""
    text = (
        '<robot name="rubber"><link name="ground"/>'
        + link("pivot", (0.0, 0.0))
        + link("arm", (0.5, 0.0))
        + '<joint name="slide" type="prismatic"><parent link="ground"/><child link="pivot"/>'
        '<axis xyz="0 1 0"/></joint><joint name="hinge" type="continuous"><parent link="pivot"/>'
        '<child link="arm"/><axis xyz="0 0 1"/></joint></robot>'
    )
    stiff = cd.Bushing("ground", "pivot", (0, 0, 0), [1e9] * 3 + [1e6] * 3)
    return cd.Scene(
        cd.load(text), free=["slide", "hinge"], gravity=(0.0, -9.81, 0.0), elements=[stiff]
    )


@pytest.mark.slow
@pytest.mark.parametrize("rtol", [1e-6, 1e-8])
def test_a_settled_start_takes_no_more_steps_than_a_rigid_one(rtol: float) -> None:
    scene = pendulum_on_rubber()
    rigid = cd.Scene(
        scene.mechanism, free="hinge", held={"slide": 0.0}, gravity=(0.0, -9.81, 0.0)
    ).simulate(2.0, position=0.3, rtol=rtol, method="Radau")
    soft = scene.simulate(2.0, position={"hinge": 0.3}, rtol=rtol, settle=True)
    assert soft.method == "Radau"
    assert any("stiff" in note for note in soft.notes)
    assert len(soft) <= 3 * len(rigid)
    assert soft.position[-1, 1] == pytest.approx(rigid.position[-1], abs=1e-5)


@pytest.mark.slow
def test_a_start_that_rings_is_told_with_its_frequency() -> None:
    scene = pendulum_on_rubber()
    begun = scene.simulate(5e-3, position={"hinge": 0.3, "slide": 1e-4}, rtol=1e-8)
    (note,) = [note for note in begun.notes if "oscillatory" in note]
    told = float(note.split(" Hz")[0].split()[-1])
    # Of the pivot and what of the arm goes with it, on the spring.
    bare = scene.equilibrium({"hinge": -0.5 * np.pi})
    assert 0.3 < told / (bare.frequencies[-1] / (2.0 * np.pi)) < 3.0
    column = begun.at(np.linspace(0.0, 5e-3, 2001)).position[:, 0]
    crossings = np.count_nonzero(np.diff(np.sign(column - np.mean(column))))
    assert crossings / 1e-2 == pytest.approx(told, rel=0.05)


@pytest.mark.slow
def test_a_start_that_does_not_settle_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    scene, start = pendulum_on_rubber(), {"hinge": 0.3, "slide": 1e-2}
    settled_one = scene.simulate(5e-3, position=start, rtol=1e-8, settle=True)
    assert not any("oscillatory" in note for note in settled_one.notes)
    assert "note" not in repr(settled_one)
    monkeypatch.setattr(Stiffness, "settled", lambda stiffness, y, *given: y)
    left = scene.simulate(5e-3, position=start, rtol=1e-8, settle=True)
    (note,) = left.notes
    assert repr(left).endswith("; 1 note>")
    assert note.endswith("settle=True did not bring it to rest")
