"""The gallery: every script has a title, asserts numbers, makes one figure and runs."""

from __future__ import annotations

import ast
import runpy
from pathlib import Path

import pytest

pyplot = pytest.importorskip("matplotlib.pyplot", reason="the gallery draws figures")
figure_module = pytest.importorskip("matplotlib.figure", reason="the gallery draws figures")

DIRECTORY = Path(__file__).parents[2] / "docs" / "gallery"
SCRIPTS = sorted(DIRECTORY.glob("*/*.py"))


def asserts(tree: ast.Module) -> int:
    return sum(
        isinstance(node, ast.Assert)
        or (isinstance(node, ast.Attribute) and node.attr.startswith("assert_"))
        for node in ast.walk(tree)
    )


def test_every_script_has_a_title_a_text_and_asserts() -> None:
    assert len(SCRIPTS) >= 30
    for path in SCRIPTS:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        title, line, empty, *text = (ast.get_docstring(tree) or "\n\n").splitlines()
        assert title and len(line) == len(title) and set(line) == {"="}, path.name
        assert not empty and len(" ".join(text)) > 80, path.name
        assert asserts(tree) >= 1, path.name


def test_titles_differ_and_sections_have_texts() -> None:
    titles = [path.read_text(encoding="utf-8").splitlines()[1] for path in SCRIPTS]
    assert len(set(titles)) == len(titles)
    for folder in {path.parent for path in SCRIPTS}:
        assert (folder / "README.rst").is_file()


@pytest.mark.slow
@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_runs(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MPLBACKEND", "Agg")
    monkeypatch.chdir(tmp_path)
    names = runpy.run_path(str(path), run_name="__main__")
    pyplot.close("all")
    assert isinstance(names["figure"], figure_module.Figure)
