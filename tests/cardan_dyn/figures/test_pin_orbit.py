"""The orbit of a pin: in the clearance where it is free, beyond its bounds where it is pressed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="figures need matplotlib")

from testkit.drawings import check_units_and_files
from testkit.loose_needle_drive import JOINT, PLAY, simulated

import cardan_dyn as cd
from cardan_dyn.motion.clearance import drawing

RADIUS = 0.5e6 * PLAY


@pytest.mark.slow
def test_states_are_on_their_side_of_the_play(tmp_path: Path) -> None:
    figure = drawing.pin_orbit(simulated(), JOINT)
    check_units_and_files(figure, tmp_path)
    (axes,) = figure.axes
    bounds, pressed, free, begun = (np.array(line.get_data()) for line in axes.get_lines())
    np.testing.assert_allclose(np.hypot(*bounds), RADIUS, rtol=1e-9)
    # A damper that holds as much as its spring pushes lets the pin go while it is in the wall, so
    # that free parts may be beyond the bounds, but none that is pressed within them.
    assert np.nanmin(np.hypot(*pressed)) > RADIUS * (1.0 - 1e-6)
    assert np.nanmin(np.hypot(*free)) < 0.7 * RADIUS
    assert np.nanmax(np.hypot(*free)) < np.nanmax(np.hypot(*pressed))
    impacts = simulated()[JOINT].struck
    assert begun.shape == (2, len(impacts))
    np.testing.assert_allclose(np.hypot(*begun), RADIUS, rtol=1e-6)


@pytest.mark.slow
def test_the_lines_are_the_simulated_orbit() -> None:
    (axes,) = drawing.pin_orbit(simulated(), JOINT, plane="yz").axes
    _, pressed, free, _ = (np.array(line.get_data()) for line in axes.get_lines())
    drawn = np.where(np.isnan(pressed), free, pressed)
    offset = 1e6 * simulated()[JOINT].offset[:, 1:]
    for point in offset[::50]:
        assert np.min(np.hypot(*(drawn - point[:, None]))) < 1e-6
    assert [axes.get_xlabel()[0], axes.get_ylabel()[0]] == ["y", "z"]


@pytest.mark.slow
def test_bad_input() -> None:
    with pytest.raises(cd.ModelError, match="has clearance"):
        drawing.pin_orbit(simulated(), "rocker_pin")
    with pytest.raises(cd.ArgumentError, match="plane"):
        drawing.pin_orbit(simulated(), JOINT, plane="xx")
    with pytest.raises(cd.ArgumentError, match="several times"):
        drawing.pin_orbit(simulated().at([0.001]), JOINT)
