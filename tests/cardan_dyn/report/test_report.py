"""The report: its JSON, the files it writes, and what stands on its page."""

from __future__ import annotations

import base64
import builtins
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import cardan_dyn as cd

pytest.importorskip("matplotlib", reason="the report has figures")
pytest.importorskip("meshcat", reason="the report has scenes")
pytest.importorskip("jinja2", reason="the report is a page made by Jinja")

from cardan_dyn.practice.report import report
from cardan_dyn.practice.report.comparisons import turn_of
from cardan_dyn.practice.report.verdicts import Comparison, Comparisons

PASSED = Comparison("shaft", "torque <T>", "theory (1)", 1e-13, {10.0: 1.25e-15})
FAILED = Comparison("shaft", "speed & angle", "theory (2)", 1e-13, {10.0: 2e-13})
BOTH = Comparisons([PASSED, FAILED])
FIGURES = ["grossmann_abb_3", "grossmann_abb_4", "speed_ratio", "thoma_6_7"]


@pytest.fixture(scope="module")
def directory(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report of two comparisons, in a directory below one that did not exist."""
    directory = tmp_path_factory.mktemp("parent") / "new" / "report"
    assert report.write(BOTH, directory) == directory / "index.html"
    return directory


@pytest.fixture(scope="module")
def lines() -> dict[str, list[np.ndarray]]:
    """Ordinates of the closed forms: the lines of figures at 40°, without the points on them."""
    beta = float(np.deg2rad(40.0))
    turns = (turn_of(cd.load(name), beta) for name in ("universal_joint", "double_shaft_z"))
    found = {}
    for name, (caption, figure) in report.drawn(*turns).items():
        (axes,) = figure.axes
        assert axes.get_title().endswith(", β = 40°") and axes.get_title().split(",")[0] in caption
        drawn = {line.get_label(): line.get_xydata().T for line in axes.get_lines()}
        closed = {label: xy for label, xy in drawn.items() if label.endswith("closed form")}
        for label, (x, y) in closed.items():
            at, values = drawn[label.replace("closed form", "Pinocchio")]
            period = 2.0 * np.pi if name == "grossmann_abb_4" else 360.0
            assert 10 < len(at) < len(x)
            order = np.argsort(x % period)
            expected = np.interp(at % period, (x % period)[order], y[order], period=period)
            np.testing.assert_allclose(values, expected, atol=1e-4)
        found[name] = [y for _, y in closed.values()]
    return found


def test_lines_keep_the_power(lines: dict[str, list[np.ndarray]]) -> None:
    """Without losses D₁ ω₁ = D₂ ω₂; a double shaft with equal angles turns evenly."""
    speed, even = lines["speed_ratio"]
    np.testing.assert_allclose(lines["grossmann_abb_3"][0] * speed, 1.0, rtol=1e-13)
    np.testing.assert_array_equal(even, 1.0)


def test_lines_are_components_of_one_moment(lines: dict[str, list[np.ndarray]]) -> None:
    """The cross passes one moment on: D₁² + B₁² = D₂² + B₂², and B₂ is Thoma's M_x and M_z."""
    (torque,), (bending_1, bending_2) = lines["grossmann_abb_3"], lines["grossmann_abb_4"]
    np.testing.assert_allclose(1.0 + bending_1**2, torque**2 + bending_2**2, rtol=1e-12)
    m_x, m_z = lines["thoma_6_7"]
    np.testing.assert_allclose(np.hypot(m_x, m_z), bending_2 / torque, rtol=1e-12, atol=1e-14)


@pytest.fixture(scope="module")
def page(directory: Path) -> str:
    return (directory / "index.html").read_text(encoding="utf-8")


def test_plain_data_hold_every_comparison() -> None:
    data = report.plain(BOTH)
    assert data["version"] == cd.__version__ and data["passed"] is False
    first, second = data["comparisons"]
    assert first == {
        "scene": "shaft",
        "quantity": "torque <T>",
        "source": "theory (1)",
        "beta_deg": 10.0,
        "error": 1.25e-15,
        "tolerance": 1e-13,
        "passed": True,
    }
    assert second["passed"] is False
    assert report.plain(Comparisons([PASSED]))["passed"] is True


@pytest.mark.slow
def test_figures_and_scenes_are_files(directory: Path) -> None:
    scenes = ["index.html", "scene_double_shaft.html", "scene_universal_joint.html"]
    files = sorted(path.name for path in directory.iterdir())
    assert files == sorted(
        [*scenes, *(f"{name}.{end}" for name in FIGURES for end in ("png", "svg"))]
    )


@pytest.mark.slow
def test_page_shows_the_figures_that_were_written(directory: Path, page: str) -> None:
    shown = [
        base64.b64decode(text)
        for text in re.findall(r'src="data:image/svg\+xml;base64,([^"]*)"', page)
    ]
    written = [(directory / f"{name}.svg").read_bytes() for name in FIGURES]
    assert len(shown) == 4 and sorted(shown) == sorted(written)
    assert "Grossmann 1939, Abb. 3" in page and "Thoma 1920, eqs 6 and 7" in page


def test_page_tells_which_comparison_fails(page: str) -> None:
    rows = re.findall(r"<tr><td>(.*?)</tr>", page, re.DOTALL)
    assert len(rows) == 2
    assert "torque &lt;T&gt;" in rows[0] and '<td class="pass">pass</td>' in rows[0]
    assert "1.2e-15" in rows[0] and "1e-13" in rows[0]
    assert "speed &amp; angle" in rows[1] and '<td class="fail">FAIL</td>' in rows[1]
    assert '<strong class="fail">A comparison falls short.</strong>' in page


def test_page_holds_both_scenes_and_needs_no_network(page: str) -> None:
    assert page.count("<iframe title=") == 2
    assert "Universal joint, β = 50°, load 100 N·m" in page
    assert "Double shaft, β = 50°, load 100 N·m" in page
    assert "http" not in page


@pytest.mark.slow
@pytest.mark.parametrize("missing", ["matplotlib", "jinja2", "meshcat"])
def test_without_an_extra_no_page_is_written(
    missing: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from cardan_dyn.practice.viewer.commands import meshcat

    real: Callable[..., object] = builtins.__import__

    def without(name: str, *rest: object, **more: object) -> object:
        if name.split(".")[0] == missing:
            raise ImportError(name)
        return real(name, *rest, **more)

    meshcat.cache_clear()
    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(cd.MissingExtraError, match=re.escape('pip install "cardan-dyn[viz]"')):
        report.write(BOTH, tmp_path / "out")
    assert not (tmp_path / "out" / "index.html").exists()


def test_a_file_in_the_place_of_the_directory_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("", encoding="utf-8")
    with pytest.raises(cd.ArgumentError, match="cannot be written"):
        report.write(BOTH, tmp_path / "taken")
