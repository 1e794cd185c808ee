"""The catalogue's diagram: lines end at the bends, the arc between the planes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="figures need matplotlib")

from testkit.drawings import check_units_and_files

from cardan_dyn.drive_lines import arrangements


@pytest.mark.slow
def test_bild_18(tmp_path: Path) -> None:
    found = arrangements.graphical_method(*np.radians([15.0, 7.0, -11.5, 12.0]))
    figure = found.plot()
    check_units_and_files(figure, tmp_path)
    axes = figure.axes[0]
    lines = {line.get_label(): line for line in axes.get_lines()}
    first, second = (
        next(line for name, line in lines.items() if name.startswith(f"joint {joint}"))
        for joint in (1, 2)
    )
    assert first.get_xydata()[-1] == pytest.approx([7.0, 15.0])
    assert second.get_xydata()[-1] == pytest.approx([12.0, -11.5])
    assert (first.get_linestyle(), second.get_linestyle()) == ("--", "-")
    texts = [text.get_text() for text in axes.texts]
    assert "70.9°" in texts
    assert "-70.87°" in axes.get_title()


def test_planes_that_coincide_or_are_none() -> None:
    for bends in ([10.0, 0.0, -10.0, 0.0], [10.0, 3.0, 0.0, 0.0], [0.0] * 4):
        figure = arrangements.graphical_method(*np.radians(bends)).plot()
        assert not any("°" in text.get_text() for text in figure.axes[0].texts)
