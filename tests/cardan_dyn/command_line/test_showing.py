"""Scenes that commands made are written, or served until they are interrupted."""

from __future__ import annotations

from pathlib import Path

import pytest

import cardan_dyn as cd
from cardan_dyn.practice.command_line.showing import export, serve
from cardan_dyn.practice.viewer.viewing import View

PAGE = cd.view(cd.assemble(cd.load("four_bar")))


def test_export_says_where(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    export(PAGE, tmp_path / "scene.html")
    assert capsys.readouterr().out == f"Scene: {tmp_path / 'scene.html'}\n"
    export(PAGE, tmp_path / "scene.html", aside=True)
    assert capsys.readouterr() == ("", f"Scene: {tmp_path / 'scene.html'}\n")
    with pytest.raises(cd.ArgumentError, match="cannot be written"):
        export(PAGE, tmp_path / "none" / "scene.html")


def test_serves_until_interrupted(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    calls: list[str] = []

    def interrupted(shown: View) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(View, "open", lambda shown: False)
    monkeypatch.setattr(View, "serve", interrupted)
    close = View.close
    monkeypatch.setattr(View, "close", lambda shown: calls.append("close") or close(shown))
    serve(PAGE, open_browser=True)
    said = capsys.readouterr()
    assert "Ctrl-C ends it" in said.out and "No browser has opened it here" in said.err
    assert calls == ["close"]
