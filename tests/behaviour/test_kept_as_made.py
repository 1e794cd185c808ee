"""Scenes and results are kept as they were made: copied, pickled, shared, never changed."""

from __future__ import annotations

import copy
import pickle
import resource
import sys
import threading
from collections.abc import Callable

import numpy as np
import pytest

import cardan_dyn as cd

POSITIONS = np.linspace(0.1, 6.0, 40)
GRAVITY = (0.0, 0.0, -9.81)
COPIES = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "pickle": lambda item: pickle.loads(pickle.dumps(item)),
}


def four_bar(**options: object) -> cd.Scene:
    given = {"drive": "crank_bearing", "gravity": GRAVITY, "loads": {"rocker_bearing": -5.0}}
    return cd.Scene(cd.load("four_bar"), **{**given, **options})


def in_another_mode() -> cd.Scene:
    return four_bar(branch="B", near={"crank_bearing": 0.3})


def under_link_loads() -> cd.Scene:
    joint = cd.load("universal_joint")
    loads = {"shaft_out": cd.Wrench(force=[1.0, 2.0, 3.0], frame="world"), "bearing_out": -3.0}
    return cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.8}, loads=loads)


def in_mjcf() -> cd.Scene:
    model = """<mujoco><compiler angle="radian"/><worldbody><body name="crank">
      <joint name="a" axis="0 0 1"/><inertial pos="0.5 0 0" mass="1" diaginertia="1 1 1"/>
      <body name="coupler" pos="1 0 0"><joint name="b" axis="0 0 1"/>
        <inertial pos="1 1 0" mass="1" diaginertia="1 1 1"/></body></body>
      <body name="rocker" pos="3 -0.5 0"><joint name="c" axis="0 0 1"/>
        <inertial pos="0 1 0" mass="1" diaginertia="1 1 1"/></body></worldbody>
      <equality><connect body1="coupler" body2="rocker" anchor="2 2 0"/></equality></mujoco>"""
    return cd.Scene(cd.load(model), drive="a", gravity=GRAVITY)


SCENES: dict[str, Callable[[], cd.Scene]] = {
    "four-bar": four_bar,
    "other assembly mode": in_another_mode,
    "link loads": under_link_loads,
    "efforts alone": lambda: four_bar(outputs=[]),
    "compliance": lambda: four_bar(compliance={"crank_pin": [1e-8] * 6}),
    "drive line": lambda: drive_line_scene(),
    "MJCF": in_mjcf,
}


def drive_line_scene() -> cd.Scene:
    line = cd.load("drive_line")
    held = {name: 0.2 for name in line.joints if name.startswith("joint_angle")}
    loads = {"bearing_out": -7.0}
    return cd.Scene(line, drive="bearing_in", held=held, loads=loads, gravity=GRAVITY)


def equal(sweep: cd.Sweep, expected: cd.Sweep) -> None:
    assert tuple(sweep) == tuple(expected)
    for name in sweep:
        for quantity in ("force", "moment"):
            reference = getattr(expected[name], quantity)
            difference = getattr(sweep[name], quantity) - reference
            size = max(1.0, float(np.max(np.abs(reference), initial=0.0)))
            assert np.max(np.abs(difference), initial=0.0) < 1e-11 * size
        assert np.array_equal(sweep[name].unique, expected[name].unique)
    effort = np.max(np.abs(expected.drive_effort))
    assert np.max(np.abs(sweep.drive_effort - expected.drive_effort)) < 1e-11 * effort


@pytest.mark.parametrize(
    ("name", "made"),
    [*((name, "pickle") for name in SCENES), ("MJCF", "copy"), ("MJCF", "deepcopy")],
)
def test_a_copied_scene_solves_all_of_its_loops(name: str, made: str) -> None:
    scene = SCENES[name]()
    expected = scene.sweep(POSITIONS, speed=3.0)
    again = COPIES[made](scene)
    equal(again.sweep(POSITIONS, speed=3.0), expected)
    assert again.plan().steps == scene.plan().steps


@pytest.mark.parametrize("made", COPIES)
def test_mechanisms_sweeps_and_closed_positions_can_be_copied(made: str) -> None:
    scene = under_link_loads()
    turn = scene.sweep(POSITIONS, speed=3.0)
    mechanism = COPIES[made](scene.mechanism)
    assert list(mechanism.joints) == list(scene.mechanism.joints)
    assert np.array_equal(
        mechanism.model.inertias[2].matrix(), scene.mechanism.model.inertias[2].matrix()
    )
    again = COPIES[made](turn)
    equal(again, turn)
    assert np.array_equal(again.origin("pin_in"), turn.origin("pin_in"))
    assert np.array_equal(
        again.wrench("pin_in", "world").force, turn.wrench("pin_in", "world").force
    )
    closed = COPIES[made](scene.assemble(POSITIONS))
    equal(cd.Scene._of(closed.solver).sweep(closed, speed=3.0), turn)


def test_pickles_of_sweeps_stay_small() -> None:
    turn = four_bar().sweep(POSITIONS)
    assert len(pickle.dumps(turn)) < 100_000


def test_nothing_of_a_result_can_be_changed() -> None:
    scene = under_link_loads()
    turn = scene.sweep(POSITIONS, speed=3.0)
    bearing = turn["bearing_out"]
    arrays = [
        *(bearing.force, bearing.moment, bearing.torsion, bearing.axial, bearing.unique),
        *(turn.drive_effort, turn.condition, turn.holding_effort["joint_angle"]),
        *(turn.motion.x, turn.motion.v, turn.motion.a, turn.motion.turns),
        *(*turn.motion.velocity_ratios, turn.rotation("pin_in"), turn.origin("pin_in")),
        *(scene.assemble(POSITIONS).targets.positions, scene.assemble(POSITIONS).turns),
        *(
            scene.gravity,
            scene.problem.link_loads["shaft_out"].force,
            scene.problem.joint_loads["bearing_out"],
        ),
    ]
    for array in arrays:
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 7.0
    for mapping in (
        scene.held,
        scene.problem.joint_loads,
        scene.problem.link_loads,
        turn.holding_effort,
    ):
        with pytest.raises(cd.ImmutableError, match="cannot be changed"):
            mapping["joint_angle"] = 0.0
        with pytest.raises(cd.ImmutableError):
            mapping.clear()
    for item, name in ((scene, "held"), (scene.mechanism, "length"), (scene, "new")):
        with pytest.raises(cd.ImmutableError, match=f"{name} of a .* cannot be changed"):
            setattr(item, name, 0.0)
        with pytest.raises(cd.ImmutableError):
            delattr(item, "name")
    with pytest.raises(AttributeError):
        turn.balance_residual = 0.0


def test_arguments_changed_afterwards_change_no_scene() -> None:
    load, held, gravity = np.full(40, -3.0), {"joint_angle": 0.8}, np.array(GRAVITY)
    scene = cd.Scene(
        cd.load("universal_joint"),
        drive=["bearing_in"],
        held=held,
        loads={"bearing_out": load},
        gravity=gravity,
    )
    expected = scene.sweep(POSITIONS).drive_effort
    load[:], gravity[:], held["joint_angle"] = 0.0, 0.0, 0.1
    assert np.array_equal(scene.sweep(POSITIONS).drive_effort, expected)
    assert np.array_equal(copy.deepcopy(scene).sweep(POSITIONS).drive_effort, expected)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["four-bar", "efforts alone", "drive line"])
def test_threads_share_a_scene(name: str) -> None:
    """Every thread sweeps other positions, under constant switching; all begin with a new scene."""
    tasks = [(np.linspace(0.1 * k, 0.1 * k + 5.0, 30 + k), float(k)) for k in range(12)]
    expected = [SCENES[name]().sweep(positions, speed=speed) for positions, speed in tasks]
    sweeps: list[tuple[int, cd.Sweep]] = []
    scene, errors = SCENES[name](), []
    gate = threading.Barrier(4)

    def work(first: int) -> None:
        gate.wait()
        try:
            for index in range(first, len(tasks), 4):
                for _ in range(3):
                    positions, speed = tasks[index]
                    sweeps.append((index, scene.sweep(positions, speed=speed)))
        except Exception as error:  # An error in a thread would be lost.
            errors.append(error)

    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        threads = [threading.Thread(target=work, args=(first,)) for first in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    finally:
        sys.setswitchinterval(before)
    assert not errors
    assert len(sweeps) == 3 * len(tasks)
    for index, sweep in sweeps:
        equal(sweep, expected[index])


def test_scenes_of_several_gravities_share_nothing() -> None:
    mechanism = cd.load("four_bar")
    scenes = [
        cd.Scene(mechanism, drive="crank_bearing", gravity=[0.0, 0.0, pull])
        for pull in (0.0, -9.81, 5.0)
    ]
    first = [scene.sweep(POSITIONS).drive_effort for scene in scenes]
    again = [scene.sweep(POSITIONS).drive_effort for scene in reversed(scenes)][::-1]
    for effort, repeated in zip(first, again, strict=True):
        assert np.array_equal(effort, repeated)


@pytest.mark.slow
def test_positions_of_errors_are_numbers_for_one_drive_and_arrays_for_several() -> None:
    slider = cd.Scene(cd.load("slider_crank"), drive="piston_guide", near={"crank_bearing": 1.0})
    with pytest.raises(cd.CardanError) as caught:
        slider.sweep([10.0])
    assert isinstance(caught.value.position, float)
    robot = cd.load("stewart_platform")
    scene = cd.Scene(robot, drive=[name for name in robot.joints if name.startswith("leg")][:6])
    with pytest.raises(cd.CardanError) as caught:
        scene.sweep([[0.0, 0.0, 0.0, 0.0, 0.0, 50.0]])
    assert caught.value.position.shape == (6,)


@pytest.mark.slow
def test_a_long_chain_of_driven_links_stays_small() -> None:
    """pin.Data of 200 free bodies alone would take gigabytes."""
    links = "".join(
        f'<link name="l{k}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/>'
        f'</inertial></link><joint name="j{k}" type="continuous"><parent link="l{k - 1}"/>'
        f'<child link="l{k}"/>'
        f'<origin xyz="1 0 0"/><axis xyz="0 0 1"/></joint>'
        for k in range(1, 201)
    )
    chain = cd.load(f'<robot name="chain"><link name="l0"/>{links}</robot>')
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    scene = cd.Scene(chain, drive=list(chain.joints), gravity=[0.0, -9.81, 0.0])
    swept = scene.sweep(np.zeros((3, 200)))
    # Straight: link k hangs 200 - k + 1 links with a mean arm of half their number.
    assert swept["j1"].torsion[0] == pytest.approx(9.81 * 200 * 199 / 2)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 300_000
