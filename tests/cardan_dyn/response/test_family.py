"""Families of responses: against responses of scenes made one by one, and direct sweeps."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from testkit.bars_of_lengths import four_bar_of_lengths
from testkit.linkages import coupling, gears

import cardan_dyn as cd
from cardan_dyn.core.kinematics.assembly import Assembly
from cardan_dyn.core.response import build as build_module
from cardan_dyn.core.response.operating_points import OfDesign

ANGLES = np.array([0.1, 0.4, 0.9, 1.2])
POSITIONS = np.linspace(-4.0, 9.0, 31)


@pytest.fixture(scope="module")
def scene() -> cd.Scene:
    return cd.Scene(
        cd.load("universal_joint"),
        drive="bearing_in",
        held={"joint_angle": 0.5},
        loads={"bearing_out": -100.0, "cross": cd.Wrench((1.0, 2.0, 3.0))},
        gravity=(0.0, 1.0, -9.81),
    )


@pytest.fixture(scope="module")
def family(scene: cd.Scene) -> cd.Response:
    return scene.responses({"joint_angle": ANGLES})


def test_each_response_is_that_of_its_own_scene(scene: cd.Scene, family: cd.Response) -> None:
    assert family.shape == (4,)
    assert len(family) == len(list(family)) == 4
    for index, angle in enumerate(ANGLES.tolist()):
        own = scene.replace(held={"joint_angle": angle}).response()
        member = family[index]
        assert member.sample_count == own.sample_count == family.sample_count[index]
        assert member.columns == own.columns
        assert family.error[index] == member.error < 1e-11
        expected = own.sweep(POSITIONS, 7.0, -2.0, loads={"bearing_out": 30.0})
        turn = member.sweep(POSITIONS, 7.0, -2.0, loads={"bearing_out": 30.0})
        for name in expected:
            size = np.max(np.abs(expected[name].moment)) + 1.0
            for part in ("force", "moment"):
                first, second = getattr(turn[name], part), getattr(expected[name], part)
                np.testing.assert_allclose(first, second, rtol=0.0, atol=1e-11 * size)
        assert turn.held == {"joint_angle": angle}
        np.testing.assert_allclose(
            turn.motion.position("bearing_out"), expected.motion.position("bearing_out"), atol=1e-12
        )


def test_a_sweep_of_the_family_is_a_direct_one(scene: cd.Scene) -> None:
    angle = ANGLES[:, None]
    family = scene.responses({"joint_angle": angle})
    speed = np.linspace(0.0, 20.0, 31)
    turn = family.sweep(POSITIONS, speed, 3.0, loads={"bearing_out": -20.0}, gravity=(0, 0, -5.0))
    direct = scene.sweep(
        POSITIONS,
        speed,
        3.0,
        held={"joint_angle": angle},
        loads={"bearing_out": -20.0},
        gravity=(0.0, 0.0, -5.0),
    )
    assert turn.shape == direct.shape == (4, 31)
    for name in direct:
        for part in ("force", "moment", "bending", "torsion"):
            first, second = getattr(turn[name], part), getattr(direct[name], part)
            np.testing.assert_allclose(first, second, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(turn.drive_effort, direct.drive_effort, atol=1e-9)
    np.testing.assert_allclose(
        turn.holding_effort["joint_angle"], direct.holding_effort["joint_angle"], atol=1e-9
    )
    np.testing.assert_allclose(turn.motion.v, direct.motion.v, atol=1e-11)
    np.testing.assert_array_equal(turn.position, np.broadcast_to(POSITIONS, (4, 31)))
    np.testing.assert_array_equal(turn.unique, direct.unique)
    assert turn.balance_residual < 1e-10
    assert turn.to_xarray()["bending"].dims == ("sample_0", "sample_1", "joint")


def test_designs_of_several_dimensions_are_indexed_by_them() -> None:
    shaft = cd.load("double_shaft_z")
    held = {"joint_angle_1": np.array([[0.2], [0.3]]), "joint_angle_2": np.array([0.1, 0.4, 0.6])}
    scene = cd.Scene(
        shaft,
        drive="bearing_in",
        held={"joint_angle_1": 0.3, "joint_angle_2": 0.2},
        loads={"bearing_out": -100.0},
    )
    family = scene.responses(held)
    assert family.shape == family.error.shape == (2, 3)
    whole = family.sweep(1.0)
    assert whole.shape == (2, 3)
    for i, j in np.ndindex(2, 3):
        own = {
            "joint_angle_1": held["joint_angle_1"][i, 0],
            "joint_angle_2": held["joint_angle_2"][j],
        }
        expected = scene.replace(held=own).sweep(1.0)["bearing_out"].bending[0]
        assert whole["bearing_out"].bending[i, j] == pytest.approx(expected, rel=1e-10)
        assert family[i, j].sweep(1.0)["bearing_out"].bending[0] == pytest.approx(expected)
    for index in (0, (0, 1, 0), "a", (0.0, 1)):
        with pytest.raises(cd.ArgumentError, match="has 2 indices"):
            family[index]  # type: ignore[index]
    with pytest.raises(IndexError):
        family[2, 0]


def test_designs_that_are_all_that_of_the_scene(scene: cd.Scene) -> None:
    family = scene.responses({"joint_angle": np.full(3, 0.5)})
    assert family.shape == (3,)
    turn = family.sweep(POSITIONS[:, None])
    expected = scene.sweep(POSITIONS)["bearing_in"].bending
    np.testing.assert_allclose(turn["bearing_in"].bending, np.tile(expected, (3, 1)).T, atol=1e-10)


def test_copies_and_files(scene: cd.Scene, family: cd.Response, tmp_path: object) -> None:
    expected = family.sweep(POSITIONS[:, None])["bearing_in"].moment
    copy = pickle.loads(pickle.dumps(family))
    np.testing.assert_allclose(copy.sweep(POSITIONS[:, None])["bearing_in"].moment, expected)
    member = pickle.loads(pickle.dumps(family[2]))
    np.testing.assert_allclose(member.sweep(POSITIONS)["bearing_in"].moment, expected[:, 2])
    path = f"{tmp_path}/design.npz"
    family[2].save(path)
    restored = scene.replace(held={"joint_angle": float(ANGLES[2])}).load_response(path)
    np.testing.assert_array_equal(restored.sweep(POSITIONS)["bearing_in"].moment, expected[:, 2])
    with pytest.raises(cd.CardanError, match="held"):
        scene.load_response(path)
    with pytest.raises(cd.ImmutableError):
        family.shape = (1,)


@pytest.mark.slow
def test_what_cannot_be_reached_is_refused_by_design(scene: cd.Scene) -> None:
    with pytest.raises(cd.AssemblyError, match=r"^design 2: .*held joint 'joint_angle'"):
        scene.responses({"joint_angle": [0.1, 0.2, 2.0]})
    with pytest.raises(cd.AccuracyError, match=r"^design 1: the response reaches"):
        scene.responses({"joint_angle": [0.1, 1.5707]})
    with pytest.raises(cd.SingularConfigurationError, match=r"^design 1: .*is singular"):
        scene.responses({"joint_angle": [0.1, 0.5 * np.pi]})
    with pytest.raises(cd.ArgumentError, match="does not hold this joint"):
        scene.responses({"pin_in": [0.1, 2.0]})
    with pytest.raises(cd.ArgumentError, match="do not broadcast"):
        scene.responses({"joint_angle": ANGLES}).sweep(np.zeros(3))


def test_members_of_scenes_with_a_start_are_copied_with_their_motion() -> None:
    """A copy follows the same way to its design as the original, from the start of the scene."""
    bars = four_bar_of_lengths()
    scene = cd.Scene(bars, drive="drive", held={"frame": 0.0}, near={"bearing": -0.106})
    member = scene.responses({"frame": [0.0, 0.12]})[1]
    copy = pickle.loads(pickle.dumps(member))
    expected = member.sweep(POSITIONS).motion.position("bearing")
    np.testing.assert_allclose(copy.sweep(POSITIONS).motion.position("bearing"), expected)
    direct = scene.sweep(POSITIONS, held={"frame": 0.12}).motion.position("bearing")
    np.testing.assert_allclose(expected, direct, atol=1e-12)


@pytest.mark.parametrize(
    ("designs", "positions", "shape"),
    [
        ((3, 1), (4,), (3, 4)),
        ((3,), (4, 1), (4, 3)),
        ((3,), (3,), (3,)),
        ((2, 1, 3), (5, 1), (2, 5, 3)),
    ],
)
def test_designs_broadcast_with_positions(
    scene: cd.Scene,
    designs: tuple[int, ...],
    positions: tuple[int, ...],
    shape: tuple[int, ...],
) -> None:
    rng = np.random.default_rng(0)
    angle, position = rng.uniform(0.1, 0.9, designs), rng.uniform(-3.0, 3.0, positions)
    turn = scene.responses({"joint_angle": angle}).sweep(position)
    assert turn.shape == shape
    expected = scene.sweep(
        np.broadcast_to(position, shape), held={"joint_angle": np.broadcast_to(angle, shape)}
    )
    for part in ("force", "moment"):
        first, second = getattr(turn["pin_in"], part), getattr(expected["pin_in"], part)
        np.testing.assert_allclose(first, second, atol=1e-10)
    np.testing.assert_allclose(turn["pin_in"].bending, expected["pin_in"].bending, atol=1e-10)
    np.testing.assert_allclose(turn.motion.position("pin_in"), expected.motion.position("pin_in"))


def test_nothing_is_evaluated_that_is_not_read(
    scene: cd.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    evaluated: list[int] = []
    summed = OfDesign.sum

    def counting(self: OfDesign, function: int) -> np.ndarray:
        evaluated.append(function)
        return summed(self, function)

    monkeypatch.setattr(OfDesign, "sum", counting)
    turn = scene.responses({"joint_angle": [0.1, 0.2]}).sweep(1.0)
    assert not evaluated
    assert turn.drive_effort.shape == (2,)
    assert len(evaluated) == 2


def test_moments_of_couplings_are_evaluated_when_they_are_read() -> None:
    scene = cd.Scene(cd.load(gears(coupling("g", "a", "b", -3.0))), drive="a", loads={"b": -5.0})
    moments = scene.responses({}).sweep(np.zeros(3)).coupling_moment
    assert list(moments) == ["g"] and len(moments) == 1
    np.testing.assert_allclose(moments["g"], np.full(3, 5.0), rtol=1e-12)
    assert moments["g"] is moments["g"]
    with pytest.raises(KeyError):
        moments["nothing"]


def test_what_is_said_of_one_design_is_asked_of_it(family: cd.Response) -> None:
    for asked in (
        lambda: family.proof,
        lambda: family.uniform(8),
        lambda: family.turn(8),
        lambda: family.inertia(0.0),
        lambda: family.ratio("bearing_out", 0.0),
        lambda: family.save("designs.npz"),
    ):
        with pytest.raises(cd.ArgumentError, match=r"of one design: take one of \(4,\), as in"):
            asked()
    assert repr(family).startswith("<Response of 'universal_joint': 4 designs, ")
    with pytest.raises(TypeError, match="no length"):
        len(family[0])


def test_designs_are_closed_in_few_calls(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = cd.Scene(
        cd.load("universal_joint"),
        drive="bearing_in",
        held={"joint_angle": 0.5},
        loads={"bearing_out": -100.0},
    )
    calls, close = [], Assembly.close

    def counting(self: Assembly, *arguments: object) -> object:
        calls.append(1)
        return close(self, *arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(Assembly, "close", counting)
    family = scene.responses({"joint_angle": np.linspace(0.1, 0.8, 40)})
    assert np.all(family.sample_count >= 128)
    # Forty designs of 160 positions in blocks of some 1024 samples, and two calls for their ends.
    assert len(calls) < 20


def test_requests_are_divided_by_size(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(build_module, "LARGE_BLOCK", 1.25)
    sizes = {0: 4, 1: 12, 2: 6, 4: 4, 5: 1}
    requests = {index: np.zeros(size) for index, size in sizes.items()}
    assert build_module._portions(requests) == [[0], [1], [2, 4], [5]]


def test_designs_that_do_not_turn_through_are_named() -> None:
    """Grashof: the shortest and the longest bar are together no longer than the other two."""
    scene = cd.Scene(
        four_bar_of_lengths(), drive="drive", held={"frame": 0.0}, loads={"bearing": -1.0}
    )
    longer = np.array([0.0, 0.1, 0.14, 0.16])
    assert scene.responses({"frame": longer[:3]}).shape == (3,)
    with pytest.raises(cd.AssemblyError, match=r"^design 3: "):
        scene.responses({"frame": longer})
    part = scene.responses({"frame": longer}, interval=(-1.0, 1.0))
    expected = scene.sweep(0.7, held={"frame": longer})["pin"].force
    np.testing.assert_allclose(part.sweep(0.7)["pin"].force, expected, atol=1e-10)


def test_designs_that_do_not_come_back_after_the_period_of_the_scene_are_named() -> None:
    """What follows the second crank at half its speed: only of two cranks does it go half round."""
    bar = cd.load("""<robot name="bar"><link name="ground"/><link name="foot"/><link name="rod"/>
        <link name="crank"/><link name="rocker"/><link name="arm"><inertial><mass value="1"/>
        <inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial></link>
        <joint name="A" type="continuous"><parent link="ground"/><child link="crank"/>
        <axis xyz="0 0 1"/></joint>
        <joint name="B" type="continuous"><parent link="crank"/><child link="rod"/>
        <origin xyz="0 0.2 0"/><axis xyz="0 0 1"/></joint>
        <joint name="S" type="prismatic"><parent link="ground"/><child link="foot"/>
        <origin xyz="0.5 0 0"/></joint>
        <joint name="D" type="continuous"><parent link="foot"/><child link="rocker"/>
        <axis xyz="0 0 1"/></joint>
        <joint name="E" type="continuous"><parent link="rocker"/><child link="arm"/>
        <axis xyz="0 0 1"/></joint>
        <loop name="C" type="continuous"><predecessor link="rod"><origin xyz="0.45 0 0"/>
        </predecessor><successor link="rocker"><origin xyz="0 0.4 0"/></successor>
        <axis xyz="0 0 1"/></loop></robot>""")
    scene = cd.Scene(cd.couple(bar, "D", "E", 0.5), drive="A", held={"S": 0.0})
    assert scene.responses({"S": [0.0, -0.02]}).shape == (2,)
    with pytest.raises(cd.CardanError, match=r"bar: design 1 does not come back to where it was"):
        scene.responses({"S": [0.0, -0.45]})
