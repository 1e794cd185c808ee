"""Critical speeds of random rigs against closed forms and a continuation of their own.

`python tests/oracle/run.py rotors --seeds 40` tests more of them, from wider ranges as well.
"""

from __future__ import annotations

import half_power
import numpy as np
import pytest
from continuation import Branch
from resonant_rigs import Stiffening, differences, draw
from shooting import Acceleration, periodic
from vibrating_lines import SpringInFront

WIDTHS = {0: (30.0,), 2: (100.0,), 4: (10.0,), 6: (), 40: (10.0,), 41: ()}


@pytest.mark.slow
@pytest.mark.parametrize("seed", WIDTHS)
def test_table_of_a_random_rig(seed: int) -> None:
    assert differences(draw(seed), WIDTHS[seed]) == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", [5, 8, 9, 12])
def test_half_power_along_a_branch_by_shooting(seed: int) -> None:
    assert half_power.ask(seed)[0] == []


def test_continuation_of_duffings_backbone() -> None:
    """The spring's first harmonic tells the frequency at a small amplitude a.

    ω²/ω_n² = 1 + s/(1 - s) (3/8 a² - 15/64 a⁴ + …), s the length of the springs; at its peak it is
    e r²/(2 ζ r) with r² = ω²/ω_n², up to the third harmonic and ζ².
    """
    ratio, offset, slack = 2e-3, 8e-4, 0.5

    def system(speed: float) -> Acceleration:
        return Stiffening(speed, ratio, offset, slack)

    branch = Branch(system, 1, 2.0 * np.pi, 31, 0.1)
    curve = branch.follow(0.8, 1.2)
    assert len(curve.folds) == 2
    sizes = np.abs(curve.order(1)[:, 0])
    speed, size = branch.extremum(
        curve, int(np.argmax(sizes)), lambda of: np.abs(of.order(1)[:, 0])
    )
    bend = slack / (1.0 - slack) * (0.375 * size**2 - 15.0 / 64.0 * size**4)
    assert speed**2 - 1.0 == pytest.approx(bend, rel=5e-3)
    assert size == pytest.approx(offset * speed / (2.0 * ratio), rel=1e-3)


@pytest.mark.slow
def test_continuation_ends_in_motions_by_shooting() -> None:
    beta = np.radians(20.0)

    def system(speed: float) -> Acceleration:
        return SpringInFront(beta, speed, 0.5, 4e-3)

    curve = Branch(system, 1, np.pi, 47, 0.3).follow(0.45, 0.56)
    top = int(np.argmax(np.abs(curve.order(2)[:, 0])))
    for index in (0, top, len(curve.speed) - 1):
        rate = np.fft.ifft(2j * np.fft.fftfreq(47, 1.0 / 47) * np.fft.fft(curve.q[index, 0])).real
        start = np.array([curve.q[index, 0, 0], rate[0]])
        shot = periodic(system(float(curve.speed[index])), start)
        np.testing.assert_allclose(shot.start, start, atol=1e-9)
