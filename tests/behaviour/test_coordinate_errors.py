"""What names of coordinates mean, what is refused, and where the angles of a ball fail."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from testkit.compound_joints import X, Y, Z, body, crank_and_slider, joint, loop, robot

import cardan_dyn as cd

BALL = joint("ball", "spherical", "ground a")
A = body("a", 1.0)


def tree() -> cd.Mechanism:
    return cd.load(robot(A, BALL, body("b", 2.0), joint("u", "universal", "a b", "", (Y, Z))))


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"drive": "u.turn_1", "loads": {"ball": 1.0}}, cd.ArgumentError, "loaded joint 'ball' is"),
        (
            {"drive": "u.turn_1", "loads": {"ball": 1.0}},
            cd.ArgumentError,
            "a spherical joint; name one of its coordinates: ball.x, ball.y, ball.z$",
        ),
        ({"drive": "ball.w"}, cd.ModelError, "joint 'ball' has no coordinate 'w'; name .* ball.x"),
        ({"drive": "u.turn"}, cd.ModelError, "no coordinate 'turn'; .* u.turn_1, u.turn_2$"),
        ({"drive": "bal.x"}, cd.ModelError, r"no joint or coordinate 'bal.x'; .*\(did you mean"),
        ({"drive": "balls"}, cd.ModelError, "no joint 'balls'; joints: ball, u"),
        ({"drive": "ball.x", "held": {"u": 0.0}}, cd.ArgumentError, "held joint 'u' is a univ"),
        ({"drive": "ball.x", "near": {"u": 0.0}}, cd.ArgumentError, "near joint 'u' is a univ"),
        ({"drive": "ball.x", "loads": {"u": 0.0}}, cd.ArgumentError, "loaded joint 'u' is a univ"),
        ({"drive": "ball.x", "loads": {"u.x": 0.0}}, cd.ModelError, "'u' has no coordinate 'x'"),
        ({"drive": ["ball.x"] * 2}, cd.ArgumentError, "driven, free or held, and named once"),
        ({"drive": "ball.x", "held": {"ball.x": 0.0}}, cd.ArgumentError, "driven, free or held"),
        ({"drive": "ball.x", "held": {"u.turn_1": 7000.0}}, cd.ArgumentError, "7000 rad, .* turns"),
        ({"drive": "ball.x", "held": {"u.turn_1": [1.0]}}, cd.ArgumentError, "make it a drive"),
        (
            {"drive": []},
            cd.MobilityError,
            "at least one coordinate .* ball.x, ball.y, ball.z, u.turn_",
        ),
        ({"drive": "u.turn_1", "outputs": ["u.turn_1"]}, cd.ModelError, "is a coordinate; name it"),
        ({"drive": "u.turn_1", "compliance": {"ball.x": np.ones(6)}}, cd.ModelError, "joint, 'ba"),
    ],
)
def test_what_is_refused(arguments: dict[str, object], error: type, message: str) -> None:
    with pytest.raises(error, match=message):
        cd.Scene(tree(), **arguments)  # type: ignore[arg-type]


def test_one_coordinate_is_called_like_its_joint() -> None:
    with pytest.raises(cd.ModelError, match=r"'r' has no coordinate 'turn'; it has one .* called"):
        cd.Scene(cd.load(crank_and_slider()), drive="r.turn")
    bolt = loop("bolt", "fixed", "ground b")
    mechanism = cd.load(robot(A, BALL, body("b"), joint("u", "universal", "a b", "", (Y, Z)), bolt))
    with pytest.raises(cd.ArgumentError, match="'bolt' is a fixed joint; it has no coordinate; "):
        cd.Scene(mechanism, drive="bolt")


def test_what_nothing_decides_is_listed_by_coordinates() -> None:
    with pytest.raises(cd.MobilityError, match="drive or hold 2 of them") as caught:
        cd.Scene(tree(), drive="ball.y", held={"u.turn_2": 0.1, "ball.x": 0.1})
    assert caught.value.free == ["ball.z", "u.turn_1"] and caught.value.mobility == 3
    with pytest.raises(cd.MobilityError, match="4 of them") as caught:
        cd.Scene(tree(), drive="u.turn_1")
    # As long as no angle of a ball is named, its rates are none of its angles'.
    assert caught.value.free == ["ball.x", "ball.y", "ball.z", "u.turn_2"]
    everything = ["u.turn_1", *caught.value.free]
    assert cd.Scene(tree(), drive=everything).sweep(np.zeros((1, 5))).drive_effort.shape == (1, 5)


def test_independent_joints_are_driven_with_all_their_coordinates() -> None:
    text = robot(A, BALL.replace('type="spherical"', 'type="spherical" independent="true"'))
    scene = cd.Scene(cd.load(text), held={"ball.y": 0.1})
    assert scene.drives == ("ball.x", "ball.z")


def test_the_name_of_a_joint_or_link_comes_before_that_of_a_coordinate() -> None:
    """A hinge called `u.turn_1`, and a link called `u.turn_2`."""
    mechanism = cd.load(
        robot(
            A,
            joint("u.turn_1", "continuous", "ground a", "", (X,)),
            body("u.turn_2", 2.0),
            joint("u", "universal", "a u.turn_2", "", (Y, Z)),
        )
    )
    assert list(mechanism.drivable) == ["u.turn_1", "u.turn_2"]
    assert mechanism.drivable["u.turn_1"].joint == "u.turn_1"
    assert mechanism.drivable["u.turn_2"].joint == "u"
    # Nobody can name the other turn of `u`, so that nothing can decide it.
    with pytest.raises(cd.MobilityError, match="nothing decides the motion of: u;") as caught:
        cd.Scene(mechanism, drive=["u.turn_1", "u.turn_2"])
    assert caught.value.free == ["u"]
    with pytest.raises(cd.ArgumentError, match="a link takes force and moment"):
        cd.Scene(mechanism, drive="u.turn_1", loads={"u.turn_2": 3.0})


def test_joints_with_dots_in_their_names() -> None:
    mechanism = cd.load(
        robot(A, joint("a.b", "spherical", "ground a"), body("b", 1.0)).replace(
            "</robot>", joint("a", "cylindrical", "a b", "", ("0 0.6 0.8",)) + "</robot>"
        )
    )
    assert list(mechanism.drivable) == ["a.b.x", "a.b.y", "a.b.z", "a.slide", "a.turn"]
    scene = cd.Scene(
        mechanism,
        drive=["a.b.y", "a.turn"],
        held={"a.b.x": 0.3, "a.b.z": -0.2, "a.slide": 0.1},
        gravity=(0, 0, -9.81),
    )
    sweep = scene.sweep([[0.1, 0.2], [0.4, -3.0]], speed=2.0)
    np.testing.assert_allclose(
        sweep["a"].axial, sweep.holding_effort["a.slide"], rtol=1e-12, atol=1e-12
    )
    np.testing.assert_allclose(sweep["a"].torsion, sweep.drive_effort[:, 1], atol=1e-12)
    with pytest.raises(cd.ArgumentError, match=r"name one of its coordinates: a.b.x, a.b.y, a.b.z"):
        cd.Scene(mechanism, drive="a.turn", loads={"a.b": 1.0})


def test_tables_name_coordinates() -> None:
    pytest.importorskip("pandas")
    scene = cd.Scene(
        tree(),
        drive=["ball.y", "u.turn_1"],
        held={"ball.x": 0.1, "ball.z": 0.0, "u.turn_2": 0.3},
        loads={"u.turn_2": [1.0, 2.0]},
    )
    frame = scene.sweep([[0.1, 0.2], [0.3, 0.4]]).to_dataframe()
    assert frame["ball.y.drive_position"].tolist() == [0.1, 0.3]
    assert frame["u.turn_1.position"].tolist() == [0.2, 0.4]
    assert frame["load_u.turn_2"].tolist() == [1.0, 2.0]
    assert frame.attrs["units"]["ball.x.holding_effort"] == "N·m"


def spherical_linkage() -> cd.Mechanism:
    """A body in a ball, that a hinge and a universal joint carry as well, all about one point."""
    return cd.load(
        robot(
            A,
            BALL,
            body("b", 2.0),
            joint("h", "continuous", "ground b", "", (Z,)),
            loop("u", "universal", "b a", ("", ""), (X, Y)),
        )
    )


def test_gimbal_lock_is_called_so() -> None:
    held = {"h": 0.0, "u.turn_1": 0.0}
    scene = cd.Scene(spherical_linkage(), drive="ball.y", held=held)
    assert scene.motion_range() == pytest.approx((-np.pi / 2, np.pi / 2), abs=1e-6)
    message = r"'ball.y' is 90° there; .* axes of 'ball.x' and 'ball.z' coincide \(gimbal lock\)"
    for positions in ([1.6], [np.pi / 2]):
        with pytest.raises(cd.SingularConfigurationError, match=message):
            scene.sweep(positions)
    # Driven by the universal joint, without any angle of the ball, the body turns through.
    plain = cd.Scene(spherical_linkage(), drive="u.turn_2", held=held, gravity=(1.0, 2.0, -9.81))
    assert plain.motion_range() == (-np.inf, np.inf)
    named = plain.replace(loads={"ball.y": 0.0})
    with pytest.raises(cd.SingularConfigurationError, match="gimbal lock"):
        named.sweep(np.linspace(0.0, 3.0, 20))
    way = np.linspace(0.0, 1.5, 5)
    first, second = plain.sweep(way, speed=1.0), named.sweep(way, speed=1.0)
    np.testing.assert_allclose(first.drive_effort, second.drive_effort, atol=1e-10)
    np.testing.assert_allclose(first["ball"].moment, second["ball"].moment, atol=1e-10)


def test_gimbal_lock_is_called_so_where_a_scene_starts_or_several_drives_move() -> None:
    with pytest.raises(cd.SingularConfigurationError, match=r"'u.turn_2' cannot .*gimbal lock"):
        cd.Scene(
            spherical_linkage(),
            drive="h",
            held={"u.turn_1": 0.0, "u.turn_2": np.pi / 2},
            loads={"ball.x": 1.0},
        )
    several = cd.Scene(spherical_linkage(), drive=["ball.y", "h"], held={"u.turn_1": 0.0})
    with pytest.raises(cd.CardanError, match="gimbal lock"):
        several.sweep([[0.1, 0.0], [1.6, 0.0]])


def test_with_all_angles_prescribed_there_is_no_gimbal_lock() -> None:
    scene = cd.Scene(
        tree(), drive=["ball.y", "ball.x", "ball.z"], held={"u.turn_1": 0.2, "u.turn_2": 0.1}
    )
    way = np.linspace(0.0, np.pi, 5)[:, None] * [1.0, 0.2, 0.3]
    assert scene.sweep(way, speed=1.0).balance_residual < 1e-12


def test_configurations_with_named_angles_are_written(tmp_path: Path) -> None:
    """The angles become the zero; wrenches of balls that are balls or turns agree."""
    mechanism = tree()
    configuration = cd.assemble(mechanism, near={"ball.x": 0.3, "u.turn_1": 0.2})
    assert configuration.positions["ball"].shape == (3,)
    again = cd.load(cd.write(mechanism, tmp_path / "turned.urdf", at=configuration.positions))
    zero = cd.assemble(again)
    for name in ("ball", "u"):
        np.testing.assert_allclose(zero.origin(name), configuration.origin(name), atol=1e-14)
        np.testing.assert_allclose(zero.rotation(name), configuration.rotation(name), atol=1e-14)
