"""Links of texts that are read in the repository, and the checker of those of the site."""

from __future__ import annotations

import importlib.util
import json
import re
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]
TEXTS = sorted(
    [*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), *(ROOT / "notebooks").glob("*.ipynb")]
)
LINK = re.compile(r"(?<!\\)\]\((?!https?:|mailto:)([^)\s]+)\)")


def text_of(path: Path) -> str:
    """Return the prose of a file, without its code."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".ipynb":
        cells = json.loads(text)["cells"]
        text = "\n".join("".join(c["source"]) for c in cells if c["cell_type"] == "markdown")
    return re.sub(r"```.*?```|`[^`\n]*`", "", text, flags=re.DOTALL)


def anchors(path: Path) -> set[str]:
    """Return the anchors of a text's headings, as hosts of repositories make them."""
    headings = re.findall(r"^#+ (.+)$", path.read_text(encoding="utf-8"), flags=re.MULTILINE)
    names = (re.sub(r"[^\w\- ]", "", heading.strip().lower()) for heading in headings)
    return {name.replace(" ", "-") for name in names}


@pytest.mark.parametrize("path", TEXTS, ids=[str(path.relative_to(ROOT)) for path in TEXTS])
def test_links_lead_somewhere(path: Path) -> None:
    for link in LINK.findall(text_of(path)):
        name, _, anchor = link.partition("#")
        target = path.parent / name if name else path
        # Pages that the site makes are checked in it.
        if path.parent.name == "docs" and name.startswith(("api/", "examples/", "notebooks/")):
            continue
        assert target.exists(), link
        if anchor and target.suffix == ".md":
            assert anchor in anchors(target), link


def test_words_of_other_programs_are_told() -> None:
    page = (ROOT / "docs" / "questions.md").read_text(encoding="utf-8")
    table = page.split("## What is it called here?")[1].split("\n## ")[0].lower()
    looked_for = (
        *("hydraulic cylinder", "payload", "end effector", "inverse kinematics", "optimization"),
        *("jacobian", "backlash", "bump stop", "gear", "torque limit", "pdf", "workspace"),
        *("forward kinematics", "stiffness", "preload", "friction", "tolerance", "unit"),
        *("torque sensor", "gearbox", "trajectory", "sensitivity"),
    )
    told = [row.split("|")[1] for row in table.splitlines() if row.startswith("|")]
    assert [words for words in looked_for if not any(words in row for row in told)] == []


@pytest.fixture(scope="module")
def checker() -> ModuleType:
    spec = importlib.util.spec_from_file_location("check_links", ROOT / "docs" / "check_links.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_broken_links_of_a_site_are_found(checker: ModuleType, tmp_path: Path) -> None:
    (tmp_path / "deeper").mkdir()
    (tmp_path / "index.html").write_text(
        '<a href="deeper/page.html#here">1</a><a href="#top">2</a><h1 id="top">x</h1>'
        '<a href="https://example.org/none">3</a><img src="picture%20one.png">',
        encoding="utf-8",
    )
    (tmp_path / "picture one.png").write_bytes(b"")
    page = tmp_path / "deeper" / "page.html"
    page.write_text('<p id="here"><a href="../index.html#top">back</a>', encoding="utf-8")
    assert checker.broken(tmp_path) == []
    checker.page.cache_clear()
    page.write_text(
        '<p id="here"><a href="../index.html#nowhere">a</a><img src="gone.png">', encoding="utf-8"
    )
    assert checker.broken(tmp_path) == [
        "deeper/page.html: ../index.html#nowhere: no such place in that page",
        "deeper/page.html: gone.png does not exist",
    ]
