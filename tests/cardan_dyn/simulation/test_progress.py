"""Progress: calls of a function, or a bar that is taken off again."""

from __future__ import annotations

import pytest

import cardan_dyn as cd
from cardan_dyn.kit import time_left
from cardan_dyn.motion.simulation.progress import Progress


def test_a_function_gets_the_fraction_done() -> None:
    seen: list[float] = []
    progress = Progress(seen.append, 4.0)
    progress.show(1.0)
    progress.show(4.0)
    progress.close()
    assert seen == [0.25, 1.0]


def test_nothing_is_shown_unless_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    progress = Progress(False, 1.0)
    progress.show(0.5)
    progress.close()
    assert capsys.readouterr().out == ""


def test_a_line_is_shown_and_taken_off(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(time_left, "_PATIENCE", 0.0)
    progress = Progress(True, 2.0)
    progress.show(1.0)
    assert "simulation" in capsys.readouterr().err
    progress.close()
    assert not time_left._running


@pytest.mark.parametrize("wanted", [3, "yes"])
def test_other_wishes_are_refused(wanted: object) -> None:
    with pytest.raises(cd.ArgumentError, match="expected a bool or a function"):
        Progress(wanted, 1.0)


@pytest.mark.parametrize("method", ["quadrature", "response", "DOP853", "Radau"])
def test_every_method_shows_the_end_and_takes_the_bar_off(
    joint: cd.Mechanism, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    closed: list[Progress] = []
    monkeypatch.setattr(Progress, "close", lambda progress: closed.append(progress))
    seen: list[float] = []
    scene = cd.Scene(joint, free="bearing_in", held={"joint_angle": 0.4})
    scene.simulate(0.1, speed=3.0, method=method, progress=seen.append)
    assert closed
    assert seen[-1] == 1.0
