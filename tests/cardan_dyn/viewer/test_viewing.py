"""Scenes that can be shown: what a page contains, what it costs, who serves it, what is refused."""

from __future__ import annotations

import builtins
import html
import json
import re
import subprocess
import sys
import urllib.error
import urllib.request
import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("meshcat", reason="the viewer needs meshcat")
pytest.importorskip("jinja2", reason="the page needs Jinja")

import cardan_dyn as cd
from cardan_dyn.practice.viewer import commands, viewing
from cardan_dyn.practice.viewer.scenery import Parts, Scenery
from cardan_dyn.practice.viewer.viewing import View


def test_a_720_frame_double_shaft_stays_small(shaft_turn: cd.Sweep, tmp_path: Path) -> None:
    file = cd.view(shaft_turn, frames=720).export(tmp_path / "scene.html")
    assert file.stat().st_size < 8_000_000


def test_page_loads_nothing(joint_turn: cd.Sweep) -> None:
    page = cd.view(joint_turn).html
    assert re.findall(r"<(?:script|img|iframe)[^>]*\ssrc=", page) == []
    assert re.findall(r'<link[^>]*href="(?!data:)', page) == []


def tracks(page: str) -> dict[str, list[str]]:
    """Moving node to what changes of it."""
    (text,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', page)
    return {
        node["path"]: changing
        for node in json.loads(text)["scene"]["nodes"]
        if (changing := [key for key, value in node.items() if value[-1:] == ["f4"]])
    }


def test_standing_bodies_have_no_tracks(joint_turn: cd.Sweep) -> None:
    bare = {"moments": False, "forces": False, "traces": False, "axes": False, "labels": False}
    # Three bodies turn, and none of them goes anywhere.
    assert tracks(cd.view(joint_turn, **bare).html) == {
        f"/mechanism/{link}": ["quaternion"] for link in ("shaft_in", "cross", "shaft_out")
    }


def test_library_prints_nothing_and_hangs_nowhere(
    joint_turn: cd.Sweep, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    shown = cd.view(joint_turn)
    assert shown.url.startswith("http://127.0.0.1:")
    assert shown.open() is False
    with urllib.request.urlopen(shown.url, timeout=10) as answer:
        assert answer.read().decode("utf-8") == shown.html
    shown.close()
    assert capfd.readouterr() == ("", "")


def test_notebooks_show_it_as_it_is(joint_turn: cd.Sweep) -> None:
    element = cd.view(joint_turn)._repr_html_()
    assert element.startswith('<iframe title="Moving scene" srcdoc=')
    assert "http" not in element


def test_without_the_extra_the_install_command_is_named(
    monkeypatch: pytest.MonkeyPatch, joint_turn: cd.Sweep
) -> None:
    real: Callable[..., object] = builtins.__import__

    def without(name: str, *rest: object, **more: object) -> object:
        if name.split(".")[0] == "meshcat":
            raise ImportError(name)
        return real(name, *rest, **more)

    commands.meshcat.cache_clear()
    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(cd.MissingExtraError, match=re.escape('pip install "cardan-dyn[viz]"')):
        cd.view(joint_turn)


def test_importing_the_package_loads_no_viewer() -> None:
    script = (
        "import sys, cardan_dyn\n"
        "assert not {'meshcat', 'jinja2', 'cardan_dyn.practice.viewer'} & set(sys.modules)\n"
        "cardan_dyn.view\n"
        "assert 'meshcat' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", script], check=True)
    with pytest.raises(AttributeError, match="no attribute 'viewers'"):
        _ = cd.viewers


def test_wrong_arguments_are_refused(joint_turn: cd.Sweep) -> None:
    for wrong in ({"duration": 0.0}, {"duration": np.nan}, {"frames": 0}):
        with pytest.raises(cd.ArgumentError):
            cd.view(joint_turn, **wrong)
    with pytest.raises(cd.ArgumentError, match="sweep"):
        cd.view("universal_joint")
    with pytest.raises(cd.ModelError, match="elbow"):
        cd.view(joint_turn, joints=["elbow"])


def test_a_pruned_sweep_and_a_single_sample_are_shown() -> None:
    mechanism = cd.load("double_shaft_z")
    scene = cd.Scene(
        mechanism,
        drive="bearing_in",
        held={"joint_angle_1": 0.3, "joint_angle_2": 0.3},
        loads={"bearing_out": -1.0},
        outputs=["bearing_in"],
    )
    assert "bearing_in" in cd.view(scene.sweep([0.0, 0.5])).html
    assert "bearing_in" in cd.view(scene.sweep([0.2])).html


@pytest.mark.parametrize(
    ("frames", "samples"),
    [(5, [0, 180, 360, 540, 720]), (4, [0, 240, 480, 720]), (1, [0]), (9999, range(721))],
)
def test_frames_are_chosen_evenly_and_shown_in_the_duration(
    frames: int, samples: list[int], joint_turn: cd.Sweep, monkeypatch: pytest.MonkeyPatch
) -> None:
    chosen: list[np.ndarray] = []
    build = viewing.build

    def recorded(
        sweep: cd.Sweep,
        names: tuple[str, ...],
        parts: Parts,
        samples: np.ndarray,
        *others: Any,
    ) -> Scenery:
        chosen.append(samples)
        return build(sweep, names[:1], parts, samples, *others)

    monkeypatch.setattr(viewing, "build", recorded)
    page = cd.view(joint_turn, frames=frames, duration=3.0).html
    np.testing.assert_array_equal(chosen[0], samples)
    assert '"duration": 3.0' in page


def test_each_frame_costs_its_tracks(joint_turn: cd.Sweep) -> None:
    """721 samples in 9 frames: the page gets shorter by the tracks of the others."""
    bare = {"moments": False, "forces": False, "traces": False, "axes": False, "labels": False}
    few, most, more = (len(cd.view(joint_turn, frames=n, **bare).html) for n in (9, 721, 5000))
    every = len(cd.view(joint_turn, frames=721, joints=[], **bare).html)
    # Three bodies turn, each with a quaternion of single precision, in base64; the angle of the
    # drive is written for the slider in double precision, and for the state in single.
    assert every - len(cd.view(joint_turn, frames=9, joints=[], **bare).html) == pytest.approx(
        712 * (3 * 4 * 4 + 8 + 4) * 4 / 3, rel=0.05
    )
    assert most - few < 100 * 712 * 4 * 4 / 3
    assert most == more


def test_each_number_that_is_refused_is_named(joint_turn: cd.Sweep) -> None:
    for wrong, message in (
        ({"duration": -1.0}, r"duration is -1, expected a positive number"),
        ({"duration": np.inf}, "duration is not finite"),
        ({"duration": "long"}, "duration is not an array of real numbers"),
        ({"frames": 0}, "frames is 0, expected a whole number from 1 on"),
        ({"frames": 1.5}, r"frames is 1\.5, expected a whole number from 1 on"),
        ({"joints": 3}, "joints is 3, expected a name or a sequence of names"),
    ):
        with pytest.raises(cd.ArgumentError, match=message):
            cd.view(joint_turn, **wrong)
    with pytest.raises(cd.ArgumentError, match="a sweep or a configuration, not str"):
        cd.view("universal_joint")


def test_only_lines_of_samples_are_shown(joint: cd.Mechanism) -> None:
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.3})
    grid = scene.response().sweep(np.zeros((2, 1)), speed=[1.0, 2.0, 3.0])
    with pytest.raises(cd.ArgumentError, match="show sweeps over one dimension"):
        cd.view(grid)


def test_title_is_the_mechanisms_name_unless_given(loaded_turn: cd.Sweep) -> None:
    assert "<title>universal_joint</title>" in cd.view(loaded_turn).html
    assert "<title>mine</title>" in cd.view(loaded_turn, title="mine").html


def test_exported_page_is_the_scenes_own(tmp_path: Path) -> None:
    shown = View("<p>ü</p>")
    path = shown.export(str(tmp_path / "scene.html"))
    assert path == tmp_path / "scene.html"
    assert path.read_text(encoding="utf-8") == "<p>ü</p>"
    with pytest.raises(cd.ArgumentError, match="cannot be written"):
        shown.export(tmp_path / "none" / "scene.html")


def test_embedded_page_is_the_same_page() -> None:
    text = "<a href=\"http://x\" title='y'>&amp;</a>"
    element = View(text).embedded(height=123, title='5" & more')
    assert "height: 123px" in element and "http" not in element
    assert 'title="5&quot; &amp; more"' in element
    (source,) = re.findall(r'srcdoc="([^"]*)"', element)
    assert html.unescape(source) == text


def test_server_starts_when_its_address_is_asked_for() -> None:
    shown = View("x" * 2_300_000)
    assert repr(shown) == "<View of 2.3 MB, not served yet>"
    shown.close()  # Nothing to be closed yet.
    url = shown.url
    assert shown.url == url and repr(shown) == f"<View of 2.3 MB, at {url}>"
    shown.close()
    with pytest.raises(urllib.error.URLError):
        urllib.request.urlopen(url, timeout=2)
    assert repr(shown) == "<View of 2.3 MB, not served yet>"


@pytest.fixture
def display(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setenv("WAYLAND_DISPLAY", "wayland-0")


@pytest.mark.usefixtures("display")
def test_open_waits_until_the_browser_has_the_page(monkeypatch: pytest.MonkeyPatch) -> None:
    def fetch(url: str, new: int = 0) -> bool:
        with urllib.request.urlopen(url, timeout=10) as answer:
            assert answer.read() == b"<p>page</p>"
        return True

    monkeypatch.setattr(webbrowser, "open", fetch)
    shown = View("<p>page</p>")
    assert shown.open() is True
    # A browser that says that it has not started is believed.
    monkeypatch.setattr(webbrowser, "open", lambda url, new=0: not fetch(url))
    assert shown.open() is False
    shown.close()


@pytest.mark.slow
@pytest.mark.usefixtures("display")
def test_a_browser_that_does_not_start_or_fetch_is_reported(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def failing(url: str, new: int = 0) -> bool:
        raise webbrowser.Error("no browser")

    for replacement in (failing, lambda url, new=0: False, lambda url, new=0: True):
        monkeypatch.setattr(webbrowser, "open", replacement)
        shown = View("<p>page</p>")
        assert shown.open(timeout=0.01) is False
        shown.close()


@pytest.mark.slow
@pytest.mark.parametrize("platform", ["win32", "darwin"])
def test_other_systems_always_have_a_display(
    platform: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr(sys, "platform", platform)
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", lambda url, new=0: bool(opened.append(url)))
    shown = View("<p>page</p>")
    assert shown.open() is False
    assert opened == [shown.url]
    shown.close()


def test_paths_are_those_of_points_and_of_what_a_task_leads() -> None:
    arm = cd.load("four_bar")
    turn = cd.Scene(arm, drive="crank_bearing").sweep(np.linspace(0.0, 1.0, 7))
    assert "path of coupler" in cd.view(turn, points=["coupler"]).html
    assert "path of tip" in cd.view(turn, points={"tip": ("coupler", (0.1, 0.0, 0.0))}).html
    with pytest.raises(cd.ModelError, match="tip"):
        cd.view(turn, points=["tip"])
    with pytest.raises(cd.ArgumentError, match="no paths"):
        cd.view(cd.Scene(arm, drive="crank_bearing").configuration(), points=["coupler"])
    legs = [f"leg_{index}" for index in range(1, 7)]
    robot = cd.Scene(cd.load("stewart_platform"), task=cd.PoseTask("platform"), actuated=legs)
    height = robot.configuration().point("platform")[2]
    rows = np.array([[0.0, y, height, 0.0, 0.0, 0.0] for y in (0.0, 0.02)])
    assert "path of platform" in cd.view(robot.sweep(rows, along_path=True)).html


@pytest.mark.parametrize("told", ["in", ("in",), (39.37, "in"), ("in", 0.0), ("in", "39.37")])
def test_units_of_the_page_come_with_their_factors(told: object) -> None:
    still = cd.Scene(cd.load("four_bar"), drive="crank_bearing").configuration()
    with pytest.raises(cd.ArgumentError, match=r"units\['m'\]"):
        cd.view(still, units={"m": told})
