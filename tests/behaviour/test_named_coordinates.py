"""Single coordinates of joints that have several: driven, held, started and loaded by name."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.ball_rods import as_a_floating_rod, as_balls, as_hinges
from testkit.compound_joints import LAST, NAMES, body, crank_and_slider, joint, plate_on_table

import cardan_dyn as cd

pytestmark = pytest.mark.usefixtures("loaded_once")

G = (0.5, 0.3, -9.81)
WAY = np.linspace(-0.12, 0.12, 7)
RATES = {"speed": 3.0, "acceleration": -5.0}
NOTATIONS = {"crank": crank_and_slider, "plate": plate_on_table}
COORDINATES = {
    "crank": ("r", "p", "u.turn_1", "u.turn_2", "s.x", "s.y", "s.z"),
    "plate": ("c.slide", "c.turn", "u.turn_1", "u.turn_2", "t.slide_1", "t.slide_2", "t.turn"),
}


def pair(mechanism: str, **arguments: object) -> tuple[cd.Scene, cd.Scene]:
    """Return the same scene in both notations."""
    single: dict[str, object] = {"drive": NAMES[str(arguments["drive"])]}
    for key in ("loads", "held", "near"):
        given = arguments.get(key, {})
        single[key] = {NAMES.get(name, name): value for name, value in given.items()}  # type: ignore
    notation = NOTATIONS[mechanism]
    return (
        cd.Scene(cd.load(notation()), gravity=G, **arguments),  # type: ignore[arg-type]
        cd.Scene(cd.load(notation(single=True)), gravity=G, **single),  # type: ignore[arg-type]
    )


def inner(scene: cd.Scene) -> np.ndarray:
    """Return positions in the middle of a drive's range."""
    low, high = scene.motion_range()
    return low + np.linspace(0.35, 0.6, 7) * (high - low)


def assert_same(found: cd.Sweep, reference: cd.Sweep) -> None:
    """Compare efforts, wrenches and motion of two notations."""
    scale = max(float(np.max(np.abs(reference[name].moment))) for name in reference)
    scale = max(scale, *(float(np.max(np.abs(reference[name].force))) for name in reference))
    np.testing.assert_allclose(found.drive_effort, reference.drive_effort, atol=1e-11 * scale)
    for name, effort in found.holding_effort.items():
        expected = reference.holding_effort[NAMES[name]]
        np.testing.assert_allclose(effort, expected, atol=1e-11 * scale)
    for name in found:
        wrench, expected_wrench = found[name], reference[LAST[name]]
        assert np.all(wrench.unique) and np.all(expected_wrench.unique)
        np.testing.assert_allclose(wrench.force, expected_wrench.force, atol=1e-11 * scale)
        np.testing.assert_allclose(wrench.moment, expected_wrench.moment, atol=1e-11 * scale)
    for name in found.mechanism.coordinates.named:
        for quantity in ("position", "velocity", "acceleration", "ratio"):
            np.testing.assert_allclose(
                getattr(found.motion, quantity)(name),
                getattr(reference.motion, quantity)(NAMES[name]),
                atol=1e-10,
                rtol=1e-10,
            )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mechanism", "drive"), [(name, item) for name, items in COORDINATES.items() for item in items]
)
def test_any_coordinate_drives_as_a_single_joint_would(mechanism: str, drive: str) -> None:
    loads = dict(zip(COORDINATES[mechanism], (1.0, -2.0, 0.5, 3.0, -1.5, 0.7, 2.5), strict=True))
    found, reference = pair(mechanism, drive=drive, loads=loads)
    way = inner(found)
    np.testing.assert_allclose(found.motion_range(), reference.motion_range(), atol=1e-7)
    assert_same(found.sweep(way, **RATES), reference.sweep(way, **RATES))


@pytest.mark.parametrize("drive", ["u.turn_2", "s.y"])
def test_a_response_along_a_coordinate(drive: str, tmp_path: object) -> None:
    found, reference = pair("crank", drive=drive, loads={"s.z": 2.0})
    way = inner(found)
    response = found.response(interval=(way[0] - 0.1, way[-1] + 0.1))
    assert_same(response.sweep(way, **RATES), reference.sweep(way, **RATES))
    np.testing.assert_allclose(
        response.sweep([way[1]], loads={"s.z": -4.0}).drive_effort,
        reference.replace(loads={"s3": -4.0}).sweep([way[1]]).drive_effort,
        rtol=1e-10,
    )
    path = f"{tmp_path}/response.npz"
    response.save(path)
    np.testing.assert_array_equal(
        found.load_response(path).sweep([way[2]]).drive_effort,
        response.sweep([way[2]]).drive_effort,
    )
    with pytest.raises(cd.CardanError, match="another scene; different: drives"):
        pair("crank", drive="s.x", loads={"s.z": 2.0})[0].load_response(path)
    with pytest.raises(cd.ArgumentError, match=r"has no single coordinate; .* loads on: s.z"):
        response.sweep([way[2]], loads={"s": 1.0})


@pytest.mark.slow
def test_a_scene_starts_with_coordinates_at_their_positions() -> None:
    found, reference = pair("crank", drive="r", near={"s.y": 0.1})
    positions = found.branches()["A"]
    assert positions["s.y"] == pytest.approx(0.1, abs=1e-12)
    assert_same(found.sweep([0.05, 0.1]), reference.sweep([0.05, 0.1]))
    expected = reference.branches()["A"]
    assert positions == pytest.approx({name: expected[NAMES[name]] for name in positions})
    # All of them together are a complete configuration, which is taken as it is.
    complete = cd.Scene(cd.load(crank_and_slider()), drive="u.turn_1", near=positions)
    turn = complete.sweep([positions["u.turn_1"]])
    for name, value in positions.items():
        assert turn.motion.position(name)[0] == pytest.approx(value, abs=1e-12)


def test_names_of_coordinates() -> None:
    mechanism = cd.load(crank_and_slider())
    names = ["r", "u.turn_1", "u.turn_2", "p", "s.x", "s.y", "s.z"]
    assert sorted(mechanism.drivable) == sorted(names)
    assert mechanism.drivable["p"].slides and not mechanism.drivable["s.x"].slides
    assert "p, r, u.turn_1, u.turn_2, s.x, s.y, s.z" in str(cd.describe(mechanism))
    table = cd.load(plate_on_table())
    assert {"c.slide", "c.turn", "t.slide_1", "t.slide_2", "t.turn"} < set(table.drivable)
    assert [item.slides for name, item in table.drivable.items() if name[0] == "t"] == [
        True,
        True,
        False,
    ]


def test_the_mechanism_that_was_loaded_stays_as_it_is() -> None:
    mechanism = cd.load(crank_and_slider())
    nq = mechanism.model.nq
    plain = cd.Scene(mechanism, drive="u.turn_1")
    named = cd.Scene(mechanism, drive="s.y")
    assert plain.mechanism is mechanism and mechanism.model.nq == nq
    assert named.mechanism is not mechanism and named.mechanism.base is mechanism
    # Every scene that names the same balls has the same mechanism.
    assert cd.Scene(mechanism, drive="r", loads={"s.z": 1.0}).mechanism is named.mechanism
    assert named.mechanism["s"].type == "spherical"
    turn = named.sweep(WAY)
    assert turn.motion.position("s").shape == (len(WAY), 3)
    assert turn.motion.q.shape == (len(WAY), turn.mechanism.model.nq)
    assert plain.sweep(WAY).motion.position("s").shape == (len(WAY), 4)
    with pytest.raises(cd.ModelError, match=r"'s.y' is a Cardan angle, but 's' was solved as"):
        plain.sweep(WAY).motion.position("s.y")


def test_a_wrench_does_not_depend_on_how_its_ball_is_solved() -> None:
    mechanism = cd.load(crank_and_slider())
    plain = cd.Scene(mechanism, drive="r", gravity=G)
    named = cd.Scene(mechanism, drive="r", gravity=G, loads={"s.x": 0.0})
    first, second = plain.sweep(WAY, **RATES), named.sweep(WAY, **RATES)
    for frame in ("joint", "parent", "world"):
        for name in first:
            one, other = first.wrench(name, frame), second.wrench(name, frame)
            np.testing.assert_allclose(one.force, other.force, atol=1e-10)
            np.testing.assert_allclose(one.moment, other.moment, atol=1e-10)
            if mechanism[name].type != "spherical":  # A ball has no axis.
                np.testing.assert_allclose(one.axis, other.axis, atol=1e-12)


def test_efforts_are_components_of_the_wrench_along_the_axes() -> None:
    """The first axis of a universal joint is its parent's, the second one its child's."""
    scene = cd.Scene(
        cd.load(crank_and_slider()), drive="u.turn_1", gravity=G, loads={"u.turn_2": 2.0}
    )
    turn = scene.sweep(WAY, **RATES)
    in_parent = turn.wrench("u", "parent").moment
    np.testing.assert_allclose(in_parent[:, 1], turn.drive_effort, atol=1e-11)
    np.testing.assert_allclose(turn["u"].moment @ [0.6, 0.0, -0.8], 2.0, atol=1e-11)


def test_scenes_are_replaced_back_and_forth() -> None:
    mechanism = cd.load(plate_on_table())
    scene = cd.Scene(mechanism, drive="c.turn", loads={"t.turn": 1.0, "u.turn_1": 2.0})
    assert dict(scene.replace(loads={"t.turn": None}).loads) == {"u.turn_1": 2.0}
    crank = cd.Scene(cd.load(crank_and_slider()), drive="r", loads={"s.x": 1.0})
    without = crank.replace(loads={"s.x": None})
    assert without.mechanism is crank.mechanism.base
    again = without.replace(loads={"s.x": 1.0}).sweep(WAY)
    np.testing.assert_allclose(again.drive_effort, crank.sweep(WAY).drive_effort, rtol=1e-12)
    with pytest.raises(cd.ModelError, match="joint 's' has no coordinate 'w'"):
        crank.replace(loads={"s.w": None})


def six_hinges_and_slides() -> str:
    """The floating rod of `ball_rods` on three slides and three hinges."""
    text = as_a_floating_rod()
    start = text.index('<joint name="b"')
    stop = text.index("</joint>", start) + len("</joint>")
    chain = ["ground", "m1", "m2", "m3", "m4", "m5", "rod"]
    elements = "".join(body(name) for name in chain[1:-1])
    for index, axis in enumerate(("1 0 0", "0 1 0", "0 0 1") * 2):
        kind = "prismatic" if index < 3 else "continuous"
        ends, origin = f"{chain[index]} {chain[index + 1]}", "" if index else 'xyz="0.3 0 0"'
        elements += joint(f"b{index + 1}", kind, ends, origin, (axis,))
    return text[:start] + elements + text[stop:]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "single", "named"),
    [
        (as_balls(), as_hinges(), {"b.z": "b3"}),
        (as_balls(), as_hinges(), {"c.x": "c1"}),
        (as_a_floating_rod(), six_hinges_and_slides(), {"b.turn_z": "b6"}),
    ],
)
def test_the_spin_of_a_rod_can_be_held_and_driven(
    text: str, single: str, named: dict[str, str]
) -> None:
    mechanism, reference = cd.load(text), cd.load(single)
    ((name, other),) = named.items()
    way = np.linspace(-0.4, 0.4, 5)
    both = np.stack([way, 0.5 * way], axis=1)
    for is_driven, positions in ((False, way), (True, both)):
        scenes = [
            cd.Scene(item, drive=["a", spin], gravity=G)
            if is_driven
            else cd.Scene(item, drive="a", held={spin: 0.1}, gravity=G)
            for item, spin in ((mechanism, name), (reference, other))
        ]
        found, expected = (scene.sweep(positions, speed=2.0, acceleration=1.0) for scene in scenes)
        assert not found.idle_rods
        np.testing.assert_allclose(found.drive_effort, expected.drive_effort, atol=1e-11)
        for link in "ad":
            np.testing.assert_allclose(found[link].force, expected[link].force, atol=1e-11)
            np.testing.assert_allclose(found[link].moment, expected[link].moment, atol=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "load"),
    [
        (as_balls(), "b.x"),
        (as_a_floating_rod(), "b.turn_y"),
    ],
)
def test_a_rod_stays_idle_where_its_ball_is_solved_with_angles(text: str, load: str) -> None:
    scene = cd.Scene(cd.load(text), drive="a", gravity=G)
    named = scene.replace(loads={load: 0.0})
    way = np.linspace(-0.4, 0.4, 5)
    first, second = scene.sweep(way, speed=2.0), named.sweep(way, speed=2.0)
    assert first.idle_rods == second.idle_rods and len(first.idle_rods) == 1
    np.testing.assert_allclose(first.drive_effort, second.drive_effort, atol=1e-11)
    np.testing.assert_allclose(first["d"].moment, second["d"].moment, atol=1e-11)


def test_a_plan_names_the_coordinates_that_loops_decide() -> None:
    steps = cd.Scene(cd.load(crank_and_slider()), drive="u.turn_1").plan().steps
    assert steps[0] == "close s: decides p, r, u.turn_2, s"
    steps = cd.Scene(cd.load(crank_and_slider()), drive="s.z").plan().steps
    assert steps[0] == "close s: decides p, r, u, s.x, s.y"
