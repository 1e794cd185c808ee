"""What a sweep costs, as counts, which no busy machine can change."""

from __future__ import annotations

import pickle
import tracemalloc
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from testkit.calls import calls
from testkit.compiled_functions import needs_kernel
from testkit.design_line import design_line, designs, nominal
from testkit.line_data import random_line
from testkit.scenes import double

import cardan_dyn as cd
import cardan_dyn.drive_lines as dl
from cardan_dyn.core import compiled
from cardan_dyn.core.dynamics.problem_solver import ProblemSolver
from cardan_dyn.core.dynamics.tape import Tape
from cardan_dyn.core.dynamics.taped import TapedSolver
from cardan_dyn.core.kinematics.closing.group_solver import GroupSolver
from cardan_dyn.kit.threads import on_cores


def known(shaft: cd.Mechanism) -> cd.Scene:
    """Return a scene whose motion is known to rounding."""
    scene = double(shaft, 0.5, 0.4)
    for _ in range(3):
        scene.sweep(np.linspace(0.0, 2.0 * np.pi, 20_000))
    return scene


def test_a_block_takes_as_many_calls_whatever_its_samples(shaft: cd.Mechanism) -> None:
    """Arrays are worked on as a whole: no Python per sample but the calls into Pinocchio."""
    scene = known(shaft)
    counts = []
    # Of many samples, Pinocchio takes several in a call.
    for samples in (64, 128, 300, 600):
        positions = np.linspace(0.1, 6.0, samples)
        for rates in ({}, {"speed": 9.0}):
            scene.sweep(positions, **rates)
        counts.append(calls(lambda positions=positions: scene.sweep(positions, speed=9.0)))
    # Pinocchio's functions are no C functions of Python's, so they do not count. Without the
    # machine, some 2600 of them are the proof on arrays and 1000 are closed loops: one call for all
    # samples in each step.
    assert counts[0] == counts[1] <= counts[2] == counts[3] < (650 if compiled.kernel else 4300)


def test_an_equilibrium_is_proven_where_it_is_found_alone() -> None:
    """Six places are looked at, each with four beside it; proven are those of the last one."""
    bar = cd.load("four_bar")
    spring = cd.JointSpring("rocker_bearing", stiffness=3.0, rest=0.2, name="spring")
    acting = {"gravity": (0.0, -9.81, 0.0), "elements": [spring]}
    free = cd.Scene(bar, free="crank_bearing", **acting)
    driven = cd.Scene(bar, drive="crank_bearing", **acting)
    for place in (0.3, 0.30001):  # The first one makes what is kept.
        once = calls(partial(driven.sweep, place))
        found = calls(partial(free.equilibrium, place))
    assert found < 7.5 * once


def test_the_range_of_a_drive_is_found_once() -> None:
    scene = cd.Scene(cd.load("four_bar"), drive="rocker_bearing")
    found = scene.motion_range()
    assert calls(lambda: scene.motion_range()) < 30
    assert scene.motion_range() == found


def test_what_a_scene_knows_serves_others_that_differ_in_what_acts() -> None:
    """Other loads and gravity are solved and proven by what was made; modes are found once."""
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", loads={"rocker_bearing": -5.0})
    scene.sweep(np.linspace(0.0, 2.0 * np.pi, 400))
    given = iter(np.linspace(0.1, 2.0, 100).tolist())

    def replaced(**changes: Any) -> Any:
        return lambda: scene.replace(**changes).sweep([next(given)])

    loads, gravity = replaced(loads={"rocker_bearing": 3.0}), replaced(gravity=(0.0, -9.81, 0.0))
    springs = replaced(elements=[cd.JointSpring("rocker_bearing", stiffness=3.0)])
    for run in 3 * (loads, gravity, springs, scene.branches):  # The first ones make what is kept.
        run()
    once = calls(lambda: scene.sweep([next(given)]))
    assert max(calls(loads), calls(gravity)) < 3 * once
    assert calls(springs) < 3.6 * once
    assert calls(scene.branches) < 150
    # What they share depends on nothing in which they differ.
    spring = [cd.JointSpring("crank_pin", stiffness=8.0)]
    for changes in ({"elements": spring}, {"outputs": ["crank_pin"]}, {"loads": None}):
        found = scene.replace(**changes).sweep([0.7], speed=2.0)
        arguments = {"loads": {"rocker_bearing": -5.0}, **changes}
        expected = cd.Scene(scene.mechanism, drive="crank_bearing", **arguments)
        wanted = expected.sweep([0.7], speed=2.0)["crank_pin"].force
        np.testing.assert_allclose(found["crank_pin"].force, wanted, rtol=0.0, atol=1e-12)


def test_scenes_that_differ_in_elements_share_all_else() -> None:
    """Whichever came first, and whether it was swept, each has its own elements and their proof."""
    bar, at = cd.load("four_bar"), {"position": [0.7], "speed": 2.0}
    along = [cd.JointSpring("crank_pin", stiffness=8.0)]
    across = [cd.PointSpring("base", (0.1, 0.2, 0.0), "coupler", (0.0, 0.1, 0.0), 50.0, length=0.1)]
    scene = cd.Scene(bar, drive="crank_bearing", loads={"rocker_bearing": -5.0})
    for changes in (
        {"elements": along},
        {"elements": across},
        {"loads": {"rocker_bearing": 4.0}},
        {"elements": None},
        {"elements": along + across, "gravity": (0.0, -9.81, 0.0)},
        {"elements": along, "loads": {"rocker_bearing": 0.5}},
    ):
        scene = scene.replace(**changes)
        found = scene.sweep(**at)
        fresh = cd.Scene(
            cd.load("four_bar"),
            **{name: getattr(scene, name) for name in ("loads", "gravity", "elements")},
            drive="crank_bearing",
        ).sweep(**at)
        assert found.balance_residual < 1e-12
        for joint in found:
            wanted = np.hstack([fresh[joint].force, fresh[joint].moment])
            np.testing.assert_allclose(
                np.hstack([found[joint].force, found[joint].moment]), wanted, rtol=0.0, atol=1e-12
            )


def test_the_first_derivative_by_all_numbers_of_a_kind() -> None:
    """Equations are written down once for all, and lengths of several bodies compared at once."""
    bar = cd.Scene(cd.load("four_bar"), drive="crank_bearing")
    bar.sweep([0.1]).derivative("mass:*")  # It imports what is needed.
    held = {"joint_angle_1": 0.14, "joint_angle_2": -0.2, "joint_angle_3": 0.17}
    for names in "mass:*", "origin:*.x", "origin:pin_1_in.*":
        found = []
        line = cd.load("drive_line")
        scene = cd.Scene(line, drive="bearing_in", held=held, loads={"bearing_out": -100.0})
        first = calls(lambda: found.append(scene.sweep(np.linspace(0.0, 1.0, 73))))  # noqa: B023
        assert calls(lambda: found[0].derivative(names)) < 3 * first  # noqa: B023


def test_a_derivative_by_a_spring() -> None:
    """Elements are asked for what changes, and no more often."""
    spring = cd.PointSpring(
        "base", (0.1, 0.2, 0.0), "coupler", (0.0, 0.1, 0.0), 50.0, name="spring"
    )
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", elements=[spring])
    given = iter(np.linspace(0.5, 3.0, 9).tolist())

    def swept() -> cd.Sweep:
        return scene.sweep([next(given)], speed=2.0)

    swept().derivative("stiffness:spring")
    swept()
    assert calls(lambda: swept().derivative("stiffness:spring")) < 3 * calls(swept)


def test_calls_of_tables(tmp_path: Path) -> None:
    """Columns are made of whole arrays, however many there are."""
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing")
    one, many = scene.sweep([0.3]), scene.sweep(np.linspace(0.0, 6.0, 72))
    for sweep in (one, many):
        for run in (sweep.to_dataframe, lambda sweep=sweep: sweep.to_csv(tmp_path / "a.csv")):
            for _ in range(2):  # The first ones import what is needed.
                run()
            assert calls(run) < 1700


@needs_kernel
def test_a_design_out_of_reach_is_searched_for_once() -> None:
    """Its line is followed to where it ends by one set of rows, and the drives not from there."""
    length = "origin:rocker_pin.successor.x"
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", held={length: 0.0})

    def refused() -> None:
        with pytest.raises(cd.AssemblyError, match="has the farthest to go"):
            scene.sweep([0.3], held={length: 2.0})

    refused()
    assert calls(refused) < 60_000


def test_calls_for_what_computes_little() -> None:
    """One position costs its calls, not its numbers; of a response, likewise; and so do scenes."""
    joint = cd.load("universal_joint")

    def scene(angle: float = 0.9) -> cd.Scene:
        held = {"joint_angle": angle}
        return cd.Scene(joint, drive="bearing_in", held=held, loads={"bearing_out": -1.0})

    once = scene()
    response = once.response()
    once.sweep(np.linspace(0.0, 2.0 * np.pi, 2000))
    for sweep in (once.sweep, response.sweep):
        for _ in range(3):  # The first ones make what is kept.
            assert sweep([0.3])["bearing_out"].bending.shape == (1,)
    # Without the machine, some 600 of them are the proof with floats and 700 are closed loops.
    assert calls(lambda: once.sweep([0.3])) < (350 if compiled.kernel else 1750)
    assert calls(lambda: response.sweep([0.3])["bearing_out"].bending) < 240
    assert calls(scene) < 650
    # A task is followed before its machine is swept, and nothing of what it is left at is asked for
    # twice.
    legs = [f"leg_{k}" for k in range(1, 7)]
    robot = cd.Scene(cd.load("stewart_platform"), task=cd.PoseTask("platform"), actuated=legs)
    pose = [[0.0, 0.0, float(robot.configuration().point("platform")[2]), 0.1, 0.0, 0.0]]
    driven, lengths = robot.machine, robot.sweep(pose).position
    for scene_of, given in ((robot, pose), (driven, lengths)):
        for _ in range(3):
            scene_of.sweep(given)
    if compiled.kernel:
        ratio = calls(lambda: robot.sweep(pose)) / calls(lambda: driven.sweep(lengths))
        assert ratio < 2.1
    # Some 1300 of them read it, and 130 ask whether only exact numbers let its loop close.
    assert calls(lambda: cd.load("universal_joint")) < 2200
    # Where the held joint is elsewhere, the way there is followed, along what others were.
    assert calls(lambda: scene(0.8)) < 2500
    assert calls(lambda: scene(0.7)) < (1400 if compiled.kernel else 2500)


@needs_kernel
def test_calls_of_a_scene_that_holds_a_joint_elsewhere() -> None:
    """It is followed there as drives are, again and again from where it was; nothing is tabled."""
    held = {"origin:rocker_pin.successor.x": 0.01}
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", held=held)
    scene.sweep(np.linspace(0.0, 6.0, 100))

    def elsewhere(length: float) -> None:
        nonlocal scene
        scene = scene.replace(held={"origin:rocker_pin.successor.x": length})
        scene.sweep([0.3])

    elsewhere(0.02)
    once = calls(lambda: scene.sweep([0.4]))
    assert calls(lambda: elsewhere(0.011)) < 3 * 340
    assert calls(lambda: elsewhere(-0.02)) < 3 * 340 < 3 * once
    alone = cd.Scene(scene.mechanism, drive="crank_bearing", held=scene.held)
    for copy in (scene, pickle.loads(pickle.dumps(scene))):
        at_start = copy.configuration().positions
        assert at_start == pytest.approx(alone.configuration().positions, abs=1e-14)
        assert copy.motion_range() == alone.motion_range()


@needs_kernel
@pytest.mark.parametrize(
    ("name", "drive", "held"),
    [
        (
            "four_bar",
            "crank_bearing",
            {
                f"origin:{of}.x": 0.0
                for of in ("rocker_pin.successor", "crank_pin", "rocker_bearing")
            },
        ),
        ("drive_line", "bearing_in", {f"joint_angle_{k}": 0.1 * k for k in (1, 2, 3)}),
    ],
)
def test_calls_of_a_scene_that_holds_several_joints_elsewhere(
    name: str, drive: str, held: dict[str, float]
) -> None:
    """One after the other, as a new scene brings them there: also one that others follow."""
    scene = cd.Scene(cd.load(name), drive=drive, held=held)
    scene.sweep(np.linspace(0.0, 6.0, 100))
    once = calls(lambda: scene.sweep([0.4]))

    def elsewhere(by: float, joints: int, told: cd.Scene) -> cd.Scene:
        new = {joint: value + by for joint, value in list(held.items())[:joints]}
        replaced = told.replace(held=new)
        replaced.sweep([0.3])
        return replaced

    last = scene
    for joints in 1, 3:
        last = elsewhere(0.001, joints, last)
    for told in scene, last:
        for joints in range(1, len(held) + 1):
            elsewhere(0.002, joints, told)
            assert calls(lambda: elsewhere(0.011, joints, told)) < 4 * once  # noqa: B023
    moved = elsewhere(0.011, 3, last)
    alone = cd.Scene(scene.mechanism, drive=drive, held=moved.held)
    for copy in (moved, pickle.loads(pickle.dumps(moved))):
        found, wanted = (of.sweep([0.3, 40.0], speed=2.0).motion for of in (copy, alone))
        np.testing.assert_allclose(found.x, wanted.x, rtol=0.0, atol=1e-13)
        np.testing.assert_array_equal(found.turns, wanted.turns)


def test_calls_of_the_first_sweep_of_another_scene() -> None:
    """What a scene of the same motion has proven, and how bodies are cut free, is known by then."""
    platform, legs = cd.load("stewart_platform"), [f"leg_{index}" for index in range(1, 7)]
    positions = np.random.default_rng(0).uniform(-0.1, 0.1, (24, 6))
    cd.Scene(platform, drive=legs, gravity=(0.0, 0.0, -1.62)).sweep(positions)
    scene = cd.Scene(platform, drive=legs, gravity=(0.0, 0.0, -9.81))
    first, later = (calls(lambda: scene.sweep(positions)) for _ in range(2))
    assert first < 3 * later


def test_calls_of_a_quadrature() -> None:
    """Of a known mechanism, those of its integral and of the proof of its motion."""
    mechanism = cd.load("universal_joint")

    def spin() -> np.ndarray:
        scene = cd.Scene(mechanism, free="bearing_in", held={"joint_angle": 1.4}, outputs=[])
        return scene.simulate(6.0, speed=10.0, method="quadrature").at(6.0).position

    spin()
    # A third of them are small ones of NumPy's Chebyshev polynomials.
    assert calls(spin) < (6250 if compiled.kernel else 6650)


@needs_kernel
def test_single_positions_of_several_drives_take_programs_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As in the loop of a controller: nothing is evaluated by NumPy, near the last one or not."""
    legs = [f"leg_{k}" for k in range(1, 7)]
    scene = cd.Scene(cd.load("stewart_platform"), drive=legs)
    scene.sweep(np.full(6, 0.01))

    def refused(*_: object, **__: object) -> None:
        raise AssertionError

    monkeypatch.setattr(GroupSolver, "evaluate", refused)
    for position in (0.05, 0.051, 0.068, 0.07, -0.05):
        count = calls(lambda at=position: scene.sweep(at * np.arange(1.0, 7.0) / 6.0))
        assert count < 640


@pytest.mark.parametrize("asked", [2, 300])
def test_single_positions_take_one_newton_step(asked: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever was asked before: guesses are so near that a step leaves rounding."""
    joint = cd.load("universal_joint")
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": np.deg2rad(50.0)})
    scene.sweep(np.linspace(0.0, 2.0 * np.pi, asked))
    scene.sweep([0.3])
    evaluations = []
    evaluate = Tape.run

    def counted(*arguments: object, **options: object) -> object:
        evaluations.append(1)
        return evaluate(*arguments, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(Tape, "run", counted)
    for position in (0.3, 0.31, -2.0, 3.0, 100.0):
        evaluations.clear()
        scene.sweep([position])
        assert len(evaluations) == 1


@pytest.mark.slow
def test_memory_of_a_sweep(shaft: cd.Mechanism) -> None:
    """What is kept per sample is the result; what is needed in between is one block's."""
    scene = known(shaft)
    scene.sweep(np.linspace(0.0, 2.0 * np.pi, 10_000), speed=9.0)  # Its tape is kept by the scene.
    peaks = []
    for samples in (16_384, 40_960):  # Blocks are of one size in both.
        positions = np.linspace(0.0, 2.0 * np.pi, samples)
        tracemalloc.start()
        with on_cores(1):  # Each has a block.
            turn = scene.sweep(positions, speed=9.0)
        kept, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert len(turn["slip"].moment) == samples
        assert kept < 1000 * samples
        peaks.append(peak)
    per_sample = (peaks[1] - peaks[0]) / 24_576
    # Not more than the result itself; beside it, the arrays of one block.
    assert per_sample < 1000
    assert peaks[0] - 16_384 * per_sample < 13e6


def test_derivatives_copy_nothing_of_what_they_are() -> None:
    scene = cd.Scene(cd.load("stewart_platform"), drive=[f"leg_{k}" for k in range(1, 7)])
    sweep = scene.sweep(np.zeros((4000, 6)), speed=0.1)
    names = "leg_1", "mass:platform", "speed:leg_2", "origin:ball_2.successor.x"
    sweep.derivative(*names)  # Its tape is kept.
    tracemalloc.start()
    by = sweep.derivative(*names)
    kept, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(by) == 4
    assert peak < 1.3 * kept


def test_derivatives_ask_for_no_rates_that_sweeps_did_not_keep(
    shaft: cd.Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Long sweeps of many joints find rates again where they are read, which takes longer."""
    monkeypatch.setattr(ProblemSolver, "keeps_rates", lambda *_: False)
    sweep = double(shaft, 0.5, 0.4).sweep(np.linspace(0.0, 6.0, 40_000), speed=9.0)

    def found_again(*_: object) -> None:
        raise NotImplementedError

    monkeypatch.setattr(ProblemSolver, "rates_at", found_again)
    assert sweep.derivative("speed:bearing_in").drive_effort.any()
    assert sweep.gradient({"bearing_out.moment": 1.0}, "mass:*")
    with pytest.raises(NotImplementedError):
        _ = sweep.motion.v


@pytest.mark.campaign
@pytest.mark.slow
def test_calls_grow_with_the_joints_of_a_line() -> None:
    positions, counts = np.linspace(0.0, 2.0 * np.pi, 16), []
    for joints in (16, 32, 64):
        line = random_line(joints, seed=0, bend=0.08, mass=True)
        scene = line.scene(loads={"bearing_out": -100.0})
        scene.sweep(positions, 100.0)
        counts.append(calls(lambda scene=scene: scene.sweep(positions, 100.0)))
    # Most are orders of the samples at which no order that was chosen before serves.
    assert all(count < 25_000 * joints for count, joints in zip(counts, (16, 32, 64), strict=True))


@pytest.fixture
def solved_alone(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return how many samples no tape held for, of each block that had some."""
    counts: list[int] = []
    own_tapes = TapedSolver._own_tapes

    def counted(self: TapedSolver, *given: Any) -> object:
        counts.append(len(given[3]))
        return own_tapes(self, *given)

    monkeypatch.setattr(TapedSolver, "_own_tapes", counted)
    return counts


def test_tapes_hold_for_lines_of_short_levers(solved_alone: list[int]) -> None:
    """Orders of elimination are judged beside the sizes of rows: a lever of 70 mm is no fault."""
    dl.DriveLine.from_toml("truck").analyse()
    assert not solved_alone


@pytest.mark.slow
def test_tapes_hold_for_most_designs(solved_alone: list[int]) -> None:
    scene = cd.Scene(cd.load(design_line(3)), drive="bearing_0", held=nominal(3))
    phi = np.linspace(0.0, 2.0 * np.pi, 24)
    scene.sweep(phi, held=designs(3, (100, 1)))
    assert sum(solved_alone) < 0.25 * len(phi) * 100
