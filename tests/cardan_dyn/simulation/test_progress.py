"""Progress: calls of a function, or a bar that is taken off again."""

from __future__ import annotations

import pytest

import cardan_dyn as cd
from cardan_dyn.simulation.progress import Progress


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


def test_a_bar_is_taken_off() -> None:
    progress = Progress(True, 2.0)
    progress.show(1.0)
    assert progress._bar.tasks[0].completed == 1.0
    progress.close()
    assert not progress._bar.live.is_started


@pytest.mark.parametrize("wanted", [None, 3, "yes"])
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
