"""The command `view`: its words and units become the arguments of a sweep and of a scene."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

pytest.importorskip("meshcat", reason="the viewer needs meshcat")
pytest.importorskip("jinja2", reason="the page needs Jinja")

import cardan_dyn as cd
from cardan_dyn.practice.command_line import view_command
from cardan_dyn.practice.command_line.view_command import scene_of
from cardan_dyn.scene.usual_motion import usual_motion

KINDS = ("visuals", "moments", "forces", "axes", "traces", "labels")


Swept = Callable[..., cd.Sweep]


@pytest.fixture
def sweep(monkeypatch: pytest.MonkeyPatch) -> Swept:
    """What is drawn of a description with some options."""
    drawn: list[cd.Sweep] = []
    monkeypatch.setattr(view_command, "draw", lambda sweep, **_: drawn.append(sweep))

    def swept(source: str, **options: Any) -> cd.Sweep:
        scene_of(source, **{"samples": 3, **options})
        return drawn[-1]

    return swept


def test_degrees_are_converted(sweep: Swept) -> None:
    given = {"held": ("joint_angle=20",), "loads": ("bearing_out=-5",), "speed": np.pi}
    turn = sweep("universal_joint", samples=9, **given)
    assert turn.held == {"joint_angle": pytest.approx(np.pi / 9.0)}
    np.testing.assert_allclose(turn.motion.velocity("bearing_in"), np.pi, rtol=1e-15)
    assert len(turn) == 9


def test_slides_are_held_in_metres(sweep: Swept) -> None:
    text = (
        '<robot name="r"><link name="a"/><link name="b"/><link name="c"/>'
        '<joint name="turn" type="continuous"><parent link="a"/><child link="b"/></joint>'
        '<joint name="slide" type="prismatic"><parent link="b"/><child link="c"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
    )
    turn = sweep(text, drive=("turn",), held=("slide=0.25",))
    assert turn.held == {"slide": 0.25}


def test_coordinates_are_held_in_degrees_or_metres(sweep: Swept) -> None:
    text = (
        '<robot name="r"><link name="a"/><link name="b"/><link name="c"/>'
        '<joint name="ball" type="spherical"><parent link="a"/><child link="b"/></joint>'
        '<joint name="guide" type="cylindrical"><parent link="b"/><child link="c"/></joint></robot>'
    )
    held = ("ball.x=30", "ball.z=-60°", "guide.slide=250 mm", f"guide.turn={np.pi / 2}rad")
    turn = sweep(text, drive=("ball.y",), held=held)
    radians = {"ball.x": np.pi / 6, "ball.z": -np.pi / 3, "guide.turn": np.pi / 2}
    assert turn.held == pytest.approx({**radians, "guide.slide": 0.25})


def test_what_is_not_given_is_the_presets(sweep: Swept) -> None:
    turn = sweep("universal_joint", samples=5)
    assert turn.drives == ("bearing_in",)
    assert turn.held == {"joint_angle": np.deg2rad(35.0)}
    np.testing.assert_array_equal(turn.motion.v, 0.0)
    without_load = sweep("universal_joint", loads=("bearing_out=0",), samples=5)
    np.testing.assert_array_equal(without_load["bearing_in"].torsion, 0.0)
    assert np.all(turn["bearing_in"].torsion != 0.0)


def test_gravity_acts_on_the_sweep(sweep: Swept) -> None:
    forces = [
        sweep("four_bar", loads=("rocker_bearing=0",), gravity=gravity)["crank_bearing"].force
        for gravity in (None, (0.0, -9.81, 0.0))
    ]
    np.testing.assert_array_equal(forces[0], 0.0)
    assert np.all(np.linalg.norm(forces[1], axis=1) > 0.1)


def test_unknown_joints_are_refused(sweep: Swept) -> None:
    for name, word in (("held", "elbow=3"), ("drive", "elbow"), ("loads", "elbow=3")):
        with pytest.raises(cd.ModelError, match="'elbow'"):
            sweep("universal_joint", **{name: (word,)})


@pytest.mark.parametrize("hidden", [(), *((kind,) for kind in KINDS), KINDS])
def test_hidden_kinds_are_switched_off(
    hidden: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    given_options: dict[str, object] = {}
    monkeypatch.setattr(view_command, "draw", lambda sweep, **more: given_options.update(more))
    scene_of("four_bar", samples=3, joints=("crank_bearing",), hide=hidden, duration=2.5)
    assert {kind: given_options.pop(kind) for kind in KINDS} == {
        kind: kind not in hidden for kind in KINDS
    }
    assert given_options == {"joints": ("crank_bearing",), "duration": 2.5, "frames": 3}
    scene_of("four_bar", samples=3)
    assert given_options["joints"] is None


def test_scene_is_that_of_its_sweep() -> None:
    shown = scene_of("four_bar", samples=3)
    page = cd.view(usual_motion(cd.load("four_bar"), samples=3).sweep()).html
    # Each drawing gives its objects new identifiers, all of the same length.
    assert len(shown.html) == len(page)
    with pytest.raises(cd.CardanError, match="no_such_file"):
        scene_of("no_such_file.urdf")
