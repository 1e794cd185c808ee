"""Drive-line page in a real browser: on phones, in the dark, on paper, and for screen readers."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("matplotlib", reason="the page has figures")

from testkit.accessibility import grave
from testkit.browser import running_browser
from testkit.line_data import random_line

from cardan_dyn.drive_lines import DriveLine, Shaft, TitleBlock
from cardan_dyn.practice.report import drive_line_page as page
from cardan_dyn.practice.report.line_tables import best_forks

pytestmark = pytest.mark.slow

SHEETS = {"A4": 794, "Letter": 816}
"""Widths of sheets [px], of which the margins take 28 mm."""
MARGINS = round(28 * 96 / 25.4)
WIDER = """() => [...document.querySelectorAll('body *')].filter((one) => {
    const box = one.getBoundingClientRect();
    return box.width > 0 && (box.right > document.documentElement.clientWidth + 1 || box.left < -1);
}).map((one) => one.tagName + ' ' + one.className + ' ' + one.textContent.slice(0, 40))"""
CUT = """() => [...document.querySelectorAll('body *')].filter((one) =>
    one.scrollWidth > one.clientWidth + 1 && one.clientWidth > 0
    && getComputedStyle(one).overflowX !== 'visible').map((one) => one.tagName)"""


def long_names() -> DriveLine:
    line = random_line(5, 1, mass=True)
    names = [f"shaft_{k}_of_a_name_without_any_blank_in_it" for k in range(6)]
    shafts = [
        Shaft(**{**vars(old), "name": new}) for old, new in zip(line.shafts, names, strict=True)
    ]
    block = TitleBlock(project="P" * 60, customer="Papierfabrik", date="2026-01-31")
    return line.replace(shafts=shafts, name="N" * 70, speed=90.0, torque=200.0, report=block)


@pytest.fixture(scope="module", params=["truck", "long names"])
def files(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    line = long_names() if request.param == "long names" else DriveLine.from_toml(request.param)
    report = page.LineReport(line, line.analyse(), line.verdict(), best_forks(line))
    room = tmp_path_factory.mktemp("pages")
    return [
        page.write(
            report, room / f"{language}.html", with_scene=False, language=language, units=units
        )
        for language, units in (("en", "imperial"), ("de", "si"))
    ]


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with running_browser() as running:
        yield running


def opened(browser: Any, path: Path, width: int, scheme: str = "light") -> Any:
    shown = browser.new_page(viewport={"width": width, "height": 800}, color_scheme=scheme)
    shown.goto(path.as_uri())
    return shown


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [390, 700, 1280])
def test_nothing_is_wider_than_the_screen(
    browser: Any, files: list[Path], width: int, scheme: str
) -> None:
    for path in files:
        shown = opened(browser, path, width, scheme)
        assert shown.evaluate("document.documentElement.scrollWidth") <= width
        assert shown.evaluate(WIDER) == []
        assert shown.evaluate(CUT) == []
        if width != 700:
            assert grave(shown) == []
        shown.close()


@pytest.mark.parametrize("sheet", SHEETS)
def test_paper_loses_nothing(browser: Any, files: list[Path], sheet: str) -> None:
    for path in files:
        shown = opened(browser, path, SHEETS[sheet] - MARGINS, "dark")
        on_screen = shown.evaluate("document.querySelector('main').innerText.length")
        shown.emulate_media(media="print", color_scheme="dark")
        assert shown.evaluate("document.documentElement.scrollWidth") <= SHEETS[sheet] - MARGINS
        assert shown.evaluate(WIDER) == []
        assert shown.evaluate("document.querySelector('main').innerText.length") >= on_screen
        # Dark letters on white, whatever the screen is.
        style = "getComputedStyle(document.body)"
        assert shown.evaluate(f"{style}.color") == "rgb(28, 31, 34)"
        assert shown.evaluate(f"{style}.backgroundColor") == "rgb(255, 255, 255)"
        heights = "[...document.querySelectorAll('figure')].map((one) => one.offsetHeight)"
        # Less than the height of a sheet of Letter without margins.
        assert max(shown.evaluate(heights)) < (279 - 34) * 96 / 25.4
        printed = shown.pdf(format=sheet)
        assert printed.startswith(b"%PDF") and len(printed) > 50_000
        shown.close()


def test_a_turning_scene_stays_on_the_screen(browser: Any, tmp_path: Path) -> None:
    pytest.importorskip("meshcat", reason="the page has a scene")
    line = DriveLine.from_toml("truck")
    report = page.LineReport(line, line.analyse(), line.verdict(), best_forks(line))
    shown = opened(browser, page.write(report, tmp_path / "a.html"), 390)
    frame = "document.querySelector('iframe')"
    assert shown.evaluate(f"{frame}.getBoundingClientRect().width") > 300
    assert shown.evaluate("document.documentElement.scrollWidth") <= 390
    assert shown.evaluate(f"{frame}.title") == "Turning scene"
    shown.emulate_media(media="print")
    assert shown.evaluate(f"{frame}.getBoundingClientRect().width") == 0
    # What takes its place: the drawing.
    assert shown.evaluate("document.querySelector('figure.drawing img').offsetWidth") > 200
    shown.close()
