"""The report: table, JSON, figures, page and exit code."""

from __future__ import annotations

import builtins
import dataclasses
import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from cardan_dyn.command_line import commands as cli
from cardan_dyn.validation import comparisons


def run(*arguments: str):
    return CliRunner().invoke(cli.main, ["report", *arguments], catch_exceptions=False)


@pytest.fixture(scope="module")
def found() -> comparisons.Comparisons:
    return comparisons.run()


def test_report_writes_table_figures_and_page(tmp_path: Path) -> None:
    result = run("--out", str(tmp_path / "new" / "report"))
    assert result.exit_code == 0
    assert "universal joint" in result.output
    assert "double shaft" in result.output
    assert "Thoma (6)" in result.output
    assert "FAIL" not in result.output
    directory = tmp_path / "new" / "report"
    names = ["grossmann_abb_3", "grossmann_abb_4", "speed_ratio", "thoma_6_7"]
    for suffix in ("png", "svg"):
        assert sorted(path.stem for path in directory.glob(f"*.{suffix}")) == names
        assert all(path.stat().st_size > 10_000 for path in directory.glob(f"*.{suffix}"))
    page = (directory / "index.html").read_text(encoding="utf-8")
    assert page.count("data:image/svg+xml;base64,") == 4
    assert "http" not in page.replace("http-equiv", "")
    assert page.count('<td class="pass">pass</td>') == 17


def test_json_is_nothing_but_json(tmp_path: Path) -> None:
    result = run("--json", "--out", str(tmp_path))
    data = json.loads(result.stdout)
    assert data["passed"] is True
    assert len(data["comparisons"]) == 85
    assert (tmp_path / "index.html").exists()


def test_a_comparison_that_falls_short_fails_the_command(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, found: comparisons.Comparisons
) -> None:
    spoiled = comparisons.Comparisons([dataclasses.replace(found[0], error=2e-13), *found[1:]])
    monkeypatch.setattr(comparisons, "run", lambda: spoiled)
    result = run("--out", str(tmp_path))
    assert result.exit_code == 1
    assert "FAIL" in result.output
    assert "A comparison falls short." in (tmp_path / "index.html").read_text(encoding="utf-8")
    nan = dataclasses.replace(found[0], error=float("nan"))
    broken = comparisons.Comparisons([nan, *found[1:]])
    monkeypatch.setattr(comparisons, "run", lambda: broken)
    assert run("--no-figures").exit_code == 1


def test_without_the_extra_the_install_command_is_named(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    real = builtins.__import__

    def without(name: str, *rest: object, **more: object):
        if name.split(".")[0] == "matplotlib":
            raise ImportError(name)
        return real(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    result = run("--out", str(tmp_path))
    assert result.exit_code == 1
    assert 'pip install "cardan-dyn[viz]"' in result.output
    assert run("--no-figures").exit_code == 0


def test_a_directory_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("", encoding="utf-8")
    result = run("--out", str(tmp_path / "taken" / "report"))
    assert result.exit_code == 1
    assert "cannot be written" in result.output
