"""Pages: what all reports have in common."""

from __future__ import annotations

import datetime
import html
import re
from pathlib import Path

import pytest

pytest.importorskip("jinja2", reason="pages are made by Jinja")

from cardan_dyn.practice.report import page


def written(path: Path, title: str) -> str:
    block = [("Project", "Mill <3>"), ("Revision", "")]
    return page.write(path, "base.html", title=title, title_block=block).read_text("utf-8")


def test_title_block_is_at_the_head_and_texts_are_escaped(tmp_path: Path) -> None:
    text = written(tmp_path / "new" / "a.html", "<b>")
    assert "<dt>Project</dt><dd>Mill &lt;3&gt;</dd>" in text and "<b>" not in text
    assert not re.search(r"(src|href)=|@import|url\(", text)


@pytest.mark.parametrize("title", ['a"; } body { display: none', "</style><script>", "a\\"])
def test_no_title_gets_out_of_the_style(tmp_path: Path, title: str) -> None:
    style = re.search("<style>(.*?)</style>", written(tmp_path / "a.html", title), re.S)
    assert style is not None
    (foot,) = re.findall(r'@bottom-left { content: "([^"]*)"; font', style[1])
    shown = re.sub(r"\\([0-9a-f]+) ", lambda found: chr(int(found[1], 16)), foot)
    assert html.unescape(shown) == title
    assert "</style" not in foot and '"' not in foot


def test_day_is_that_of_the_build(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(page.EPOCH, "86399")
    assert page.today() == datetime.date(1970, 1, 1)
    monkeypatch.setenv(page.EPOCH, "86400")
    assert page.today() == datetime.date(1970, 1, 2)
    monkeypatch.delenv(page.EPOCH)
    assert abs((page.today() - datetime.datetime.now(datetime.UTC).date()).days) <= 1


@pytest.mark.slow
def test_equal_figures_give_equal_images() -> None:
    pytest.importorskip("matplotlib")
    from cardan_dyn.figures.style import axes_grid

    texts = set()
    for _ in range(2):
        figure, axes = axes_grid()
        axes.plot([0.0, 1.0], [0.0, 1.0])
        texts.add(page.image(figure))
    (text,) = texts
    assert text.startswith("data:image/svg+xml;base64,")


def test_names_break_between_their_words_alone() -> None:
    pytest.importorskip("markupsafe", reason="it is a page")
    for text, parts in {
        "coupling_shaft": ("coupling_", "shaft"),
        "leftUpperArm.turn_1": ("left", "Upper", "Arm.", "turn_", "1"),
        "1.352 kN·m at 0.5 1/min": ("1.352 kN·m at 0.5 1/min",),
        "I<xx>_a": ("I&lt;xx&gt;_", "a"),
    }.items():
        assert page.soft(text) == "<wbr>".join(parts)
