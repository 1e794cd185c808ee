"""What a response is asked: columns, loads, couplings, strict scenes, and what is no argument."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.linkages import coupling, gears
from testkit.scenes import text, universal

import cardan_dyn as cd

POSITIONS = np.linspace(-3.0, 9.0, 40)


@pytest.fixture(scope="module")
def response(joint: cd.Mechanism) -> cd.Response:
    return universal(joint, 0.5).response()


def test_a_strict_scene_refuses_in_a_response_as_it_does_in_a_sweep(joint: cd.Mechanism) -> None:
    strict = universal(joint, 0.5, strict=True)
    with pytest.raises(cd.IndeterminateError) as of_sweep:
        strict.sweep(0.0)
    with pytest.raises(cd.IndeterminateError) as of_response:
        strict.response()
    assert of_response.value.components == of_sweep.value.components
    assert str(of_response.value) == str(of_sweep.value)
    # Compliances choose, and what is unique need not be chosen.
    chosen = universal(
        joint,
        0.5,
        strict=True,
        compliance={name: np.full(6, 1e-6) for name in ("bearing_in", "bearing_out")},
    )
    assert chosen.response().error < 1e-12
    assert universal(joint, 0.5, strict=True, outputs=[]).response().error < 1e-12


def test_moments_of_couplings_are_functions_like_the_others() -> None:
    mechanism = cd.load(gears(coupling("mesh", "a", "b", -2.5)))
    scene = cd.Scene(mechanism, drive="a", loads={"b": 7.0})
    response = scene.response()
    direct = scene.sweep(POSITIONS, speed=3.0, acceleration=2.0)
    found = response.sweep(POSITIONS, 3.0, 2.0)
    assert list(found.coupling_moment) == ["mesh"]
    np.testing.assert_allclose(
        found.coupling_moment["mesh"], direct.coupling_moment["mesh"], rtol=1e-13
    )
    assert found.coupling_unique == direct.coupling_unique == {"mesh": True}
    grid = response.sweep(POSITIONS[:, None], loads={"b": np.array([0.0, 7.0, -1.0])})
    np.testing.assert_allclose(grid.coupling_moment["mesh"][5], [0.0, -7.0, 1.0], atol=1e-13)
    with pytest.raises(KeyError):
        grid.coupling_moment["b"]


def test_open_moments_of_couplings_are_marked_and_survive_a_file(tmp_path: object) -> None:
    train = [("ab", "a", "b", -2.0), ("bc", "b", "c", -3.0), ("ca", "c", "a", 1.0 / 6.0)]
    closed = cd.load(gears(*(coupling(*item) for item in train), third=True))
    scene = cd.Scene(closed, drive="a", loads={"c": -4.0})
    response = scene.response()
    response.save(f"{tmp_path}/train")
    direct = scene.sweep(POSITIONS, speed=1.0)
    for each in (response, scene.load_response(f"{tmp_path}/train")):
        found = each.sweep(POSITIONS, 1.0)
        assert found.coupling_unique == {"ab": False, "bc": False, "ca": False}
        for name, moment in direct.coupling_moment.items():
            np.testing.assert_allclose(found.coupling_moment[name], moment, atol=1e-12)


@pytest.mark.parametrize("name", ["acceleration", "speed²", "gravity x"])
def test_a_loaded_joint_may_be_called_like_a_column(name: str) -> None:
    urdf = text("universal_joint").replace('"bearing_out"', f'"{name}"')
    scene = cd.Scene(
        cd.load(urdf),
        drive="bearing_in",
        held={"joint_angle": 0.5},
        loads={name: -2.0},
        gravity=(1.0, 0.0, -9.81),
    )
    response = scene.response()
    direct = scene.sweep(POSITIONS, speed=4.0, acceleration=5.0)
    found = response.sweep(POSITIONS, 4.0, 5.0)
    assert response.columns.count(name) == 2
    for joint in scene.outputs:
        scale = np.max(np.abs(direct[joint].moment)) + np.max(np.abs(direct[joint].force))
        assert np.max(np.abs(found[joint].moment - direct[joint].moment)) < 1e-12 * scale
    heavier = response.sweep(POSITIONS, loads={name: -20.0}).drive_effort
    light = response.sweep(POSITIONS, loads={name: 0.0}).drive_effort
    plain = response.sweep(POSITIONS).drive_effort
    np.testing.assert_allclose(heavier - light, 10.0 * (plain - light), atol=1e-11)


def test_a_load_never_acts_as_a_column_of_its_name(response: cd.Response) -> None:
    for name in ("acceleration", "speed²", "gravity x", "nowhere", ""):
        with pytest.raises(cd.ArgumentError, match="no joint has this name"):
            response.sweep(POSITIONS, loads={name: 7.0})


def test_wrenches_on_links_are_not_replaced_and_the_message_says_so(joint: cd.Mechanism) -> None:
    push = {"shaft_out": cd.Wrench(force=(0.0, 3.0, 10.0))}
    response = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.4}, loads=push).response()
    for value in (7.0, cd.Wrench(force=(1.0, 0.0, 0.0)), np.ones(6)):
        with pytest.raises(cd.ArgumentError, match="'shaft_out' is a link; a response keeps"):
            response.sweep(POSITIONS, loads={"shaft_out": value})
    with pytest.raises(cd.ArgumentError, match="'cross' is a link; a response keeps"):
        response.sweep(POSITIONS, loads={"cross": 7.0})


def test_ratios_are_told_where_the_scene_has_a_load_per_sample(joint: cd.Mechanism) -> None:
    loads = {"bearing_out": np.linspace(-1.0, -2.0, 40)}
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.5}, loads=loads)
    expected = scene.sweep(POSITIONS).motion.ratio("bearing_out")
    response = scene.response()
    np.testing.assert_allclose(response.ratio("bearing_out", POSITIONS), expected, rtol=1e-13)
    np.testing.assert_allclose(response.ratio("bearing_out", 0.0), [1.0 / np.cos(0.5)], rtol=1e-13)
    for wrong in ("x", [], np.zeros((2, 2)), [None], 1j):
        with pytest.raises(cd.ArgumentError):
            response.ratio("bearing_out", wrong)  # type: ignore[arg-type]
    with pytest.raises(cd.ModelError, match="no joint"):
        response.ratio("nothing", 0.0)


def test_joints_that_no_output_needs_have_no_ratio_and_no_motion() -> None:
    scene = cd.Scene(cd.load("drive_line"), outputs=["bearing_in"], **_held("drive_line"))
    unsolved = scene.sweep(POSITIONS).motion
    response = scene.response()
    found = response.sweep(POSITIONS).motion
    for name in scene.mechanism.coordinates.columns:
        np.testing.assert_allclose(response.ratio(name, POSITIONS), unsolved.ratio(name))
        np.testing.assert_allclose(found.velocity(name), unsolved.velocity(name), atol=1e-12)


def _held(name: str) -> dict[str, object]:
    joints = cd.load(name).joints
    held = {joint: 0.2 for joint in joints if joint.startswith("joint_angle")}
    return {"drive": "bearing_in", "held": held}


WRONG = ("a", 1j, [None], ["a"], [1j], {}, {"a": 1.0}, object(), np.array("a"), True, b"x")


@pytest.mark.parametrize("wrong", WRONG, ids=lambda item: type(item).__name__)
def test_what_is_no_number_is_an_argument_error(
    joint: cd.Mechanism, response: cd.Response, wrong: object
) -> None:
    scene = universal(joint, 0.5)
    for call in (
        lambda: scene.response(wrong),  # type: ignore[arg-type]
        lambda: scene.response(interval=(wrong, 1.0)),  # type: ignore[arg-type]
        lambda: scene.response(interval=(0.0, wrong)),  # type: ignore[arg-type]
        lambda: response.sweep(wrong),  # type: ignore[arg-type]
        lambda: response.sweep(0.0, wrong),  # type: ignore[arg-type]
        lambda: response.sweep(0.0, 0.0, wrong),  # type: ignore[arg-type]
        lambda: response.sweep(0.0, gravity=wrong),  # type: ignore[arg-type]
        lambda: response.sweep(0.0, loads={"bearing_out": wrong}),  # type: ignore[dict-item]
        lambda: response.uniform(wrong),  # type: ignore[arg-type]
        lambda: response.inertia(wrong),  # type: ignore[arg-type]
        lambda: response.inertia_derivative(wrong),  # type: ignore[arg-type]
    ):
        with pytest.raises(cd.ArgumentError):
            call()


def test_numbers_of_a_wrong_shape_or_size_are_argument_errors(
    joint: cd.Mechanism, response: cd.Response
) -> None:
    scene = universal(joint, 0.5)
    for call in (
        lambda: scene.response([1e-9]),  # type: ignore[arg-type]
        lambda: scene.response(np.nan),
        lambda: scene.response(interval=([0.0], [1.0])),  # type: ignore[arg-type]
        lambda: scene.response(interval=(1.0, 1.0 + 1e-15)),
        lambda: scene.response(interval=(0.0, np.inf)),
        lambda: response.sweep([]),
        lambda: response.sweep(0.0, []),
        lambda: response.sweep([0.0, np.nan]),
        lambda: response.sweep(0.0, loads=[1.0]),  # type: ignore[arg-type]
        lambda: response.sweep(0.0, loads={3: 1.0}),  # type: ignore[dict-item]
        lambda: response.sweep(0.0, loads={"bearing_out": []}),
        lambda: response.sweep(0.0, gravity=[1.0, 2.0]),
        lambda: response.sweep(0.0, gravity=9.81),
        lambda: response.sweep(0.0, 1e200),
        lambda: response.uniform(2.5),  # type: ignore[arg-type]
        lambda: response.uniform(0),
        lambda: response.uniform(-3),
    ):
        with pytest.raises(cd.ArgumentError):
            call()


def test_more_operating_points_than_memory_holds_are_refused(response: cd.Response) -> None:
    for count in (10**12, 2**63, 10**400):
        with pytest.raises(cd.ArgumentError, match="GB of memory per component"):
            response.uniform(count)
    many = np.linspace(0.0, 1.0, 10**5)
    with pytest.raises(cd.ArgumentError, match="80 GB of memory per component"):
        response.sweep(many[:, None], many)
