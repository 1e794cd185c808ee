"""Run-ups through resonances."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from testkit import elastic_rigs

from cardan_dyn import ArgumentError, vibration


def test_a_slow_run_up_follows_the_prediction() -> None:
    line = elastic_rigs.torsional_line(damping_in=0.2)
    found = vibration.run_up(elastic_rigs.scene(line, np.radians(10.0)), 0.35, 0.65, 2400.0)
    expected = np.interp(found.window, found.predicted_speed, found.predicted[:, 0])
    np.testing.assert_allclose(found.envelope[2:, 0], expected[2:], rtol=0.03)
    assert not found.is_captured
    assert found.speed[-1] == pytest.approx(0.65)
    # Of the greatest swing, in a wide resonance, the averaged equation misses little.
    np.testing.assert_allclose(found.linear, found.predicted, rtol=0.05)
    frame = found.to_dataframe()
    assert len(frame) == len(found.window)
    assert found.plot().axes
    with pytest.raises(ArgumentError, match="'twist' is not free; free: twist_in"):
        found.plot("twist")
    assert pickle.loads(pickle.dumps(found)).free == ("twist_in",)
    assert "0.35 to 0.65" in repr(found)


def test_a_fast_run_up_stays_below_the_steady_resonance() -> None:
    line = elastic_rigs.torsional_line(damping_in=0.02)
    scene = elastic_rigs.scene(line, np.radians(5.0))
    found = vibration.run_up(scene, 0.4, 0.6, 150.0)
    assert np.max(found.envelope) < 0.8 * np.nanmax(found.predicted)
    late = found.window[np.argmax(found.envelope[:, 0])]
    assert late > found.predicted_speed[np.nanargmax(found.predicted[:, 0])]


@pytest.mark.parametrize(
    ("start", "end", "duration"), [(0.0, 1.0, 9.0), (1.0, -1.0, 9.0), (1.0, 1.0, 9.0), (1, 2, 0)]
)
def test_what_is_asked_for_wrongly(start: float, end: float, duration: float) -> None:
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(), 0.1)
    with pytest.raises(ArgumentError):
        vibration.run_up(scene, start, end, duration)


def test_a_torque_of_several_values_is_refused() -> None:
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(), 0.1)
    with pytest.raises(ArgumentError, match="torque is"):
        vibration.run_up(scene, 0.3, 0.4, 9.0, torque=[1.0, 2.0])  # type: ignore[arg-type]
