"""Many designs in one sweep: held joints, loads, gravity and inertia that vary, and grids."""

from __future__ import annotations

import pickle
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from testkit.bundled import EVERY_KIND
from testkit.design_line import design_line, designs, nominal

import cardan_dyn as cd
from cardan_dyn.core.kinematics.closing.group_solver import GroupSolver
from cardan_dyn.scene.presets import PRESETS

pytestmark = pytest.mark.usefixtures("loaded_once")

TURN = 2.0 * np.pi
COUNT = 6
WITH_HELD = [name for name in EVERY_KIND if PRESETS[name].held_deg]


def scene_of(name: str, **options: object) -> cd.Scene:
    preset = PRESETS[name]
    held = {joint: float(np.deg2rad(angle)) for joint, angle in preset.held_deg.items()}
    arguments = {"drive": list(preset.drive), "held": held, "loads": preset.loads, **options}
    return cd.Scene(cd.load(name), **arguments)


def random_positions(scene: cd.Scene, count: int, seed: int = 0) -> np.ndarray:
    """Return positions `(count,)` or `(count, d)`: up to 1 rad from the start, or 0.05 m."""
    rng = np.random.default_rng(seed)
    slides = [scene.mechanism.drivable[name].slides for name in scene.drives]
    positions = rng.uniform(-1.0, 1.0, size=(count, len(slides))) * np.where(slides, 0.05, 1.0)
    return positions[:, 0] if len(slides) == 1 else positions


def assert_same(first: cd.Sweep, second: cd.Sweep, index: object, tolerance: float) -> None:
    """All wrenches, efforts and joint positions of a part of one sweep are those of another."""
    size = max(
        np.max(np.abs(getattr(second[joint], part)))
        for joint in second
        for part in ("force", "moment")
    )
    for joint in second:
        for part in ("force", "moment"):
            np.testing.assert_allclose(
                getattr(first[joint], part)[index],
                getattr(second[joint], part),
                rtol=0.0,
                atol=tolerance * size,
                err_msg=f"{part} of {joint}",
            )
    for joint in second.holding_effort:
        np.testing.assert_allclose(
            first.holding_effort[joint][index],
            second.holding_effort[joint],
            rtol=0.0,
            atol=tolerance * size,
        )
    np.testing.assert_allclose(
        first.drive_effort[index], second.drive_effort, rtol=0.0, atol=tolerance * size
    )
    for joint in second.mechanism.coordinates.named:
        np.testing.assert_allclose(
            first.motion.position(joint)[index], second.motion.position(joint), atol=1e-11
        )


@pytest.mark.slow
@pytest.mark.parametrize("name", WITH_HELD)
def test_a_grid_of_designs_is_that_of_scenes_made_one_by_one(name: str) -> None:
    scene = scene_of(name, gravity=(0.0, 1.0, -9.81))
    rng = np.random.default_rng(1)
    held = {joint: value + rng.uniform(-0.1, 0.1, (4, 1)) for joint, value in scene.held.items()}
    position = np.linspace(-3.0, 9.0, 25)
    grid = scene.sweep(position, speed=4.0, acceleration=-1.0, held=held)
    assert grid.shape == (4, 25)
    assert grid.motion.q.shape == (4, 25, grid.mechanism.model.nq)
    assert grid.balance_residual < 1e-14
    for k in range(4):
        one = {joint: float(values[k, 0]) for joint, values in held.items()}
        alone = scene.replace(held=one).sweep(position, speed=4.0, acceleration=-1.0)
        assert_same(grid, alone, k, 1e-12)


@pytest.mark.slow
def test_a_line_of_many_design_variables_is_that_of_scenes_made_one_by_one() -> None:
    """Angles, phases and lengths together; every loop has a centre that the lengths move."""
    line = cd.load(design_line(4))
    scene = cd.Scene(line, drive="bearing_0", held=nominal(4), loads={"bearing_4": -100.0})
    held = designs(4, (5, 1))
    position = np.linspace(0.0, TURN, 24)
    grid = scene.sweep(position, 9.0, held=held)
    for k in range(5):
        one = {name: float(values[k, 0]) for name, values in held.items()}
        alone = cd.Scene(line, drive="bearing_0", held=one, loads={"bearing_4": -100.0})
        assert_same(grid, alone.sweep(position, 9.0), k, 1e-11)


@pytest.mark.slow
def test_samples_with_designs_of_their_own_are_those_of_the_grid() -> None:
    """Whatever the order, and whether many or few samples share what was followed."""
    line = cd.load(design_line(3))
    scene = cd.Scene(line, drive="bearing_0", held=nominal(3), loads={"bearing_3": -100.0})
    held, position = designs(3, (40, 1), seed=3), np.linspace(-3.0, 3.0, 30)
    grid = scene.sweep(position, held=held)
    rng = np.random.default_rng(4)
    some = rng.permutation(40 * 30)[:100]
    rows, columns = np.unravel_index(some, (40, 30))
    mixed = scene.sweep(
        position[columns], held={name: values[rows, 0] for name, values in held.items()}
    )
    moment = grid["bearing_2"].moment[rows, columns]
    np.testing.assert_allclose(mixed["bearing_2"].moment, moment, atol=1e-10)
    for k in (0, 50, 99):
        alone = scene.sweep(
            position[columns[k]], held={name: values[rows[k]] for name, values in held.items()}
        )
        np.testing.assert_allclose(alone["bearing_2"].moment[0], moment[k], atol=1e-10)


def test_whole_turns_cost_nothing_and_are_kept(joint: cd.Mechanism) -> None:
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.3})
    turns = np.array([0.0, -3.0, 100_000.0])
    position = 0.7 + TURN * turns
    beta = np.array([[0.1], [0.9]])
    motion = scene.sweep(position, held={"joint_angle": beta}).motion
    expected = np.arctan2(np.sin(0.7), np.cos(0.7) * np.cos(beta)) + TURN * turns
    at_turns = np.abs(motion.position("bearing_out") - expected)
    assert np.max(at_turns / (1.0 + np.abs(expected))) < 1e-15 * 10


@pytest.mark.parametrize("name", EVERY_KIND)
def test_gravity_that_varies_is_that_of_other_scenes(name: str) -> None:
    scene = scene_of(name)
    position = random_positions(scene, COUNT)
    speed, acceleration = np.random.default_rng(2).normal(size=(2, *position.shape))
    gravity = np.random.default_rng(3).normal(size=(COUNT, 3))
    sweep = scene.sweep(position, speed, acceleration, gravity=gravity)
    for k in range(COUNT):
        rates = (values[[k]] for values in (position, speed, acceleration))
        alone = scene.replace(gravity=gravity[k]).sweep(*rates)
        assert_same(sweep, alone, slice(k, k + 1), 1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("name", EVERY_KIND)
def test_factors_on_inertia_are_those_of_other_descriptions(name: str) -> None:
    scene = scene_of(name)
    mechanism, rng = scene.mechanism, np.random.default_rng(5)
    moving = [link for link in mechanism.links if mechanism.links[link][0] > 0]
    masses = {link.name: link.mass for link in mechanism.description.links}
    factors = {link: rng.uniform(0.0, 3.0, COUNT) for link in moving if masses[link] > 0.0}
    position = random_positions(scene, COUNT)
    speed, acceleration = rng.normal(size=(2, *position.shape))
    gravity = rng.normal(size=(COUNT, 3))
    sweep = scene.sweep(position, speed, acceleration, gravity=gravity, inertia=factors)
    for k in range(COUNT):
        other = with_factors(
            mechanism, {link: float(values[k]) for link, values in factors.items()}
        )
        options = {"drive": scene.drives, "held": scene.held, "loads": scene.loads}
        alone = cd.Scene(cd.load(other), gravity=gravity[k], **options)
        rates = (values[[k]] for values in (position, speed, acceleration))
        assert_same(sweep, alone.sweep(*rates), slice(k, k + 1), 1e-12)


def with_factors(mechanism: cd.Mechanism, factors: dict[str, float]) -> str:
    """Return a description in which masses and inertias of links are multiplied by factors."""
    root = ElementTree.fromstring(mechanism.to_urdf())
    for link in root.iter("link"):
        factor = factors.get(link.get("name", ""))
        for element in [] if factor is None else [*link.iter("mass"), *link.iter("inertia")]:
            for key, value in list(element.items()):
                element.set(key, repr(float(value) * factor))
    return ElementTree.tostring(root, encoding="unicode")


def test_factors_on_one_of_several_links_of_a_body() -> None:
    """Only the named link changes, though fixed joints make it one body with others."""
    body = (
        '<inertial><origin xyz="{at}"/><mass value="{mass}"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    arm = (
        '<robot name="arm"><link name="base"/>'
        f'<link name="arm">{body.format(at="1 0 0", mass=2.0)}</link>'
        f'<link name="weight">{body.format(at="0 0 0", mass=3.0)}</link>'
        '<joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/>'
        '<axis xyz="0 0 1"/></joint>'
        '<joint name="weld" type="fixed"><parent link="arm"/><child link="weight"/>'
        '<origin xyz="2 0 0"/></joint></robot>'
    )
    scene = cd.Scene(cd.load(arm), drive="hinge")
    factor = np.array([0.0, 1.0, 2.5])
    turn = scene.sweep(0.3, acceleration=1.0, inertia={"weight": factor})
    # Steiner's theorem about the hinge.
    np.testing.assert_allclose(turn.drive_effort, (1.0 + 2.0) + factor * (1.0 + 12.0), rtol=1e-14)


def test_loads_that_vary_are_those_of_other_scenes() -> None:
    scene = scene_of("double_shaft_z")
    torque, force = (
        np.linspace(-50.0, 20.0, 3)[:, None],
        np.random.default_rng(6).normal(size=(4, 6)),
    )
    position = np.linspace(0.0, 2.0, 4)
    grid = scene.sweep(position, loads={"bearing_out": torque, "tube": force})
    assert grid.shape == (3, 4)
    for k in range(3):
        loads = {"bearing_out": float(torque[k, 0]), "tube": force}
        assert_same(grid, scene.replace(loads=loads).sweep(position), k, 1e-13)
    assert grid.loads["bearing_out"].shape == (3, 1)


@pytest.mark.slow
def test_positions_and_designs_may_be_reached_or_not(joint: cd.Mechanism) -> None:
    """What the mask leaves is solved; each of the others is refused."""
    platform = scene_of("stewart_platform")
    position = np.random.default_rng(7).uniform(-0.35, 0.35, size=(300, 6))
    mask = platform.reachable(position)
    assert 20 < np.sum(mask) < 290
    assert platform.sweep(position[mask]).loop_residual < 1e-12
    for k in np.nonzero(~mask)[0][:20]:
        with pytest.raises((cd.AssemblyError, cd.SingularConfigurationError)):
            platform.sweep(position[[k]])
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.3})
    beta = np.array([[0.0], [1.5], [0.5 * np.pi], [2.0]])
    mask = scene.reachable(np.linspace(0.1, 6.0, 5), held={"joint_angle": beta})
    np.testing.assert_array_equal(mask, np.repeat(beta < 1.55, 5, axis=1))


def test_the_range_of_one_drive_is_what_can_be_reached() -> None:
    crank = cd.load("slider_crank")
    scene = cd.Scene(crank, drive="piston_guide", near={"crank_bearing": 1.0})
    low, high = scene.motion_range()
    inside = np.linspace(low, high, 9)[1:-1]
    position = np.array([low - 0.01, *inside, high + 0.01])
    np.testing.assert_array_equal(scene.reachable(position), [False, *[True] * 7, False])
    assert not np.any(scene.reachable([low - 1.0, high + 1.0]))
    scene.sweep(inside)


def test_an_unreachable_design_is_named_with_its_sample() -> None:
    scene = scene_of("universal_joint")
    angle = np.full(500, 0.2)
    angle[[123, 400]] = 1.7  # Past 90°, where the joint locks on the way.
    with pytest.raises(cd.CardanError, match="sample 123 of 500") as caught:
        scene.sweep(np.linspace(0.5, 1.0, 500), held={"joint_angle": angle})
    assert "1 other sample is out of reach too" in str(caught.value)
    mask = scene.reachable(np.linspace(0.5, 1.0, 500), held={"joint_angle": angle})
    np.testing.assert_array_equal(np.nonzero(~mask)[0], [123, 400])


def test_bad_input_is_named() -> None:
    scene = scene_of("universal_joint")
    bad = np.ones(5)
    bad[3] = np.nan
    cases = {
        r"held\['joint_angle'\] is not finite at index \[3\]": {"held": {"joint_angle": bad}},
        r"held\['pin_in'\]: the scene does not hold": {"held": {"pin_in": 0.1}},
        r"do not broadcast: .*held\['joint_angle'\] \(5,\)": {
            "held": {"joint_angle": np.ones(5)},
            "position": np.ones(3),
        },
        r"inertia\['cross'\] is not finite at index \[3\]": {"inertia": {"cross": bad}},
        r"inertia\['cross'\] is -1; factors are not negative": {"inertia": {"cross": -bad[:2]}},
        r"inertia\['base'\]: the link is fixed to the world": {"inertia": {"base": 2.0}},
        r"gravity has shape \(4,\)": {"gravity": np.ones(4)},
        r"loads\['nothing'\]: no joint or link": {"loads": {"nothing": 1.0}},
    }
    for message, arguments in cases.items():
        with pytest.raises(cd.ArgumentError, match=message):
            scene.sweep(**{"position": 0.0, **arguments})
    with pytest.raises(cd.ModelError, match="no link 'crss'"):
        scene.sweep(0.0, inertia={"crss": 1.0})


def test_grids_are_copied_and_tabulated(joint: cd.Mechanism) -> None:
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.3})
    grid = scene.sweep(
        np.linspace(0.0, 1.0, 4),
        2.0,
        held={"joint_angle": np.array([[0.1], [0.2], [0.3]])},
        inertia={"cross": np.array([[1.0], [2.0], [3.0]])},
    )
    copy = pickle.loads(pickle.dumps(grid))
    np.testing.assert_array_equal(copy["bearing_in"].moment, grid["bearing_in"].moment)
    np.testing.assert_array_equal(copy.motion.q, grid.motion.q)
    np.testing.assert_array_equal(copy.held["joint_angle"], [[0.1], [0.2], [0.3]])
    data = grid.to_xarray()
    assert data["held_joint_angle"].dims == ("sample_0",)
    assert data["inertia_cross"].dims == ("sample_0",)
    assert data["bending"].dims == ("sample_0", "sample_1", "joint")
    np.testing.assert_array_equal(
        data["bending"].sel(joint="bearing_in"), grid["bearing_in"].bending
    )
    assert len(grid.to_dataframe()) == 12
    world = grid.wrench("bearing_out", "world").force
    rotated = np.einsum("...ij,...j->...i", grid.rotation("bearing_out"), grid["bearing_out"].force)
    np.testing.assert_allclose(world, rotated, atol=1e-12)


def test_assembled_designs_serve_several_sweeps() -> None:
    scene = scene_of("universal_joint")
    held = {"joint_angle": np.array([[0.1], [0.7]])}
    closed = scene.assemble(np.linspace(0.0, 3.0, 7), held=held)
    assert closed.shape == (2, 7)
    direct = scene.sweep(np.linspace(0.0, 3.0, 7), 5.0, held=held)
    copies = pickle.loads(pickle.dumps((scene, closed)))
    for whose, again in ((scene, closed), copies):
        assert again.shape == (2, 7)
        moment = whose.sweep(again, 5.0)["bearing_in"].moment
        np.testing.assert_allclose(moment, direct["bearing_in"].moment, atol=1e-12)
    with pytest.raises(cd.ArgumentError, match=r"write assemble\(\.\.\., held="):
        scene.sweep(closed, held=held)
    with pytest.raises(cd.ArgumentError, match="assembled in shape"):
        scene.sweep(closed, loads={"bearing_out": np.ones((3, 1, 1))})


@pytest.mark.slow
def test_a_design_costs_few_evaluations_per_sample(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of each group: about four per sample where 72 positions share the way to their design."""
    line = cd.load(design_line(3))
    scene = cd.Scene(line, drive="bearing_0", held=nominal(3), loads={"bearing_3": -100.0})
    held, position = designs(3, (50, 1)), np.linspace(0.0, TURN, 72, endpoint=False)
    scene.sweep(position, held=held)
    counted, evaluate = [], GroupSolver.evaluate

    def counting(self: GroupSolver, x: np.ndarray, *rest: object) -> object:
        counted.append(len(x))
        return evaluate(self, x, *rest)

    monkeypatch.setattr(GroupSolver, "evaluate", counting)
    scene.sweep(position, held=held)
    groups = sum(bool(group.loops) for group in scene.solver.assembly.groups)
    assert sum(counted) < 5.0 * groups * 50 * 72
    # All designs advance together: as many calls as if they were one.
    assert len(counted) < 150 * groups


def test_figures_and_the_viewer_ask_for_one_design(joint: cd.Mechanism) -> None:
    figures, draw = cd.figures, cd.view
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.3})
    grid = scene.sweep(np.linspace(0.0, 1.0, 4), held={"joint_angle": np.array([[0.1], [0.2]])})
    for drawn in (
        lambda: figures.over_angle(grid, "bearing_in"),
        lambda: figures.ratio_and_angle_error({"grid": grid}),
        lambda: figures.force_polar(grid, "pin_in"),
        lambda: figures.moment_polar(grid, "pin_in"),
        lambda: draw(grid, joints=[]),
    ):
        with pytest.raises(cd.ArgumentError, match=r"one dimension, not of shape \(2, 4\)"):
            drawn()


def test_any_number_of_gravities_takes_no_more_memory(joint: cd.Mechanism) -> None:
    """Nothing is kept for a value that may never come again."""
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.3})
    for count in (3, 100, 300):
        for number in range(5):
            gravity = (0.0, float(number), 1.0 / count)
            scene.sweep(np.linspace(0.0, 1.0, count), 1.0, gravity=gravity)
    assert len(scene.solver.taped._tapes) <= 1


def test_columns_of_positions_are_as_good_assembled_as_given(joint: cd.Mechanism) -> None:
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.3})
    column, row = np.linspace(0.0, 1.0, 4)[:, None], np.ones(4)
    assert scene.sweep(column, column).shape == (4, 1)
    assert scene.sweep(scene.assemble(column), column).shape == (4, 1)
    assert scene.sweep(column, row).shape == (4, 4)
    with pytest.raises(cd.ArgumentError, match=r"assembled in shape \(4, 1\), which these exceed"):
        scene.sweep(scene.assemble(column), row)
