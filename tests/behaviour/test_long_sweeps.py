"""Long sweeps: what they keep, what they compute when it is read, and what they refuse."""

from __future__ import annotations

import pickle
import subprocess
import sys
import tracemalloc

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.core.dynamics import problem_solver

COUNT = 10_000
POSITIONS = np.linspace(0.0, 2.0 * np.pi, COUNT)


@pytest.fixture(scope="module")
def joint() -> cd.Mechanism:
    return cd.load("universal_joint")


def scene(joint: cd.Mechanism, **changes: object) -> cd.Scene:
    given = {"drive": "bearing_in", "held": {"joint_angle": 0.5}, "loads": {"bearing_out": -1.0}}
    return cd.Scene(joint, **(given | changes))


@pytest.mark.parametrize("outputs", [None, ["bearing_in"]])
def test_rates_that_are_not_kept_are_those_that_are(
    joint: cd.Mechanism, monkeypatch: pytest.MonkeyPatch, outputs: list[str] | None
) -> None:
    speed = np.linspace(1.0, 3.0, COUNT)
    one = scene(joint, outputs=outputs)
    kept = one.sweep(POSITIONS, speed, 5.0).motion
    monkeypatch.setattr(problem_solver, "_MOST_RATES", 0)
    turn = one.sweep(POSITIONS, speed, 5.0)
    again = pickle.loads(pickle.dumps(turn)).motion
    for motion in (turn.motion, again):
        for name in ("v", "a"):
            found, expected = getattr(motion, name), getattr(kept, name)
            np.testing.assert_allclose(found, expected, rtol=1e-13, atol=1e-12)
            assert not found.flags.writeable
        for name in kept.mechanism.drivable:
            np.testing.assert_allclose(motion.ratio(name), kept.ratio(name), atol=1e-13)
            np.testing.assert_allclose(motion.position(name), kept.position(name), atol=1e-13)
    assert len(turn.motion) == COUNT
    assert turn.motion.v is turn.motion.v


def test_what_no_output_needs_is_not_known_later_either(
    shaft: cd.Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Joints whose motion is not solved are NaN, whenever their rates are computed."""
    monkeypatch.setattr(problem_solver, "_MOST_RATES", 0)
    held = {"joint_angle_1": 0.4, "joint_angle_2": 0.3}
    given = {"drive": "bearing_in", "held": held, "outputs": ["bearing_in"]}
    motion = cd.Scene(shaft, **given).sweep(POSITIONS, 1.0).motion
    for joint in motion.mechanism.joint_names:
        assert np.all(np.isnan(motion.velocity(joint)) == np.isnan(motion.position(joint)))


def test_a_long_sweep_keeps_what_it_was_asked_for(
    joint: cd.Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Positions, coordinates, wrenches of the outputs, two efforts, the condition."""
    monkeypatch.setattr(problem_solver, "_MOST_RATES", 0)
    for outputs, wrenches in ((None, 5), (["bearing_out"], 1)):
        one = scene(joint, outputs=outputs)
        for _ in range(12):  # What is learned of the motion is kept by the scene.
            one.sweep(POSITIONS, 1.0)
        tracemalloc.start()
        turn = one.sweep(POSITIONS, 1.0)
        kept, _ = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert len(turn) == COUNT
        # Whole turns count here as well, though zeros that are never written take no memory.
        numbers = 1 + 2 * 5 + 6 * wrenches + 2 + 1
        assert kept / COUNT < 8 * numbers + 16


def test_rates_are_computed_once_and_only_if_they_are_read(
    joint: cd.Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(problem_solver, "_MOST_RATES", 0)
    rates_at, counted = problem_solver.ProblemSolver.rates_at, []

    def counting(self: object, *given: object) -> object:
        counted.append(given)
        return rates_at(self, *given)

    monkeypatch.setattr(problem_solver.ProblemSolver, "rates_at", counting)
    turn = scene(joint).sweep(POSITIONS, 1.0)
    assert turn["bearing_out"].bending.shape == turn.motion.position("pin_in").shape
    assert not counted
    assert turn.motion.velocity("pin_in").shape == turn.motion.ratio("pin_out").shape
    assert len(counted) == 1


def test_what_does_not_fit_into_memory_is_refused_before_it_is_computed(
    joint: cd.Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(problem_solver, "_memory", lambda: 4e9)
    positions, speeds = np.linspace(0.0, 6.0, 10_000)[:, None], np.linspace(1.0, 2.0, 5000)
    # 43 numbers: ten for coordinates, thirty of wrenches, two efforts, the condition.
    expected = r"50000000 samples keep 17\.2 GB, more than the 4 GB .*fewer outputs.*response\(\)"
    with pytest.raises(cd.ArgumentError, match=expected):
        scene(joint).sweep(positions, speeds)
    with pytest.raises(cd.ArgumentError, match=r"keep 7\.6 GB, .* fewer at a time, or sweep"):
        scene(joint, outputs=["bearing_out"]).sweep(positions, speeds)
    with pytest.raises(cd.ArgumentError, match=r"1000000 samples keep 4\.08 GB, .* at a time$"):
        scene(joint).assemble(np.zeros(1_000_000))
    spring = cd.JointSpring("bearing_out", stiffness=1.0)
    with pytest.raises(cd.ArgumentError, match=r"at a time, or fewer outputs, or let a study"):
        scene(joint, elements=[spring]).sweep(positions, speeds)


def test_positions_that_are_too_many_are_not_copied(
    joint: cd.Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(problem_solver, "_memory", lambda: 4e9)
    swept, positions = scene(joint), np.broadcast_to(0.1, (50_000_000,))
    tracemalloc.start()
    try:
        with pytest.raises(cd.ArgumentError, match=r"study of studies\.Sweeps"):
            swept.sweep(positions)
        assert tracemalloc.get_traced_memory()[1] < 4e6  # A copy takes 400 MB.
    finally:
        tracemalloc.stop()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="counts what the C library asks Linux for")
def test_blocks_use_the_memory_of_those_before_them() -> None:
    """Each page that the system hands out anew costs as much as several samples' sines."""
    pytest.importorskip("resource")
    code = """
import resource, numpy as np, cardan_dyn as cd
scene = cd.Scene(cd.load("universal_joint"), drive="bearing_in", held={"joint_angle": 0.5})
positions = np.linspace(0.0, 6.0, 700)
faults = []
for _ in range(30):
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    scene.sweep(positions, 3.0)
    faults.append(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
print(sorted(faults)[15])
"""
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert int(run.stdout) < 100
