import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from testkit.line_data import random_line

from cardan_dyn.practice.drive_lines.line.geometry import lead, zero


@pytest.mark.parametrize("seed", range(5))
def test_pins_and_shafts_by_rotations(seed: int) -> None:
    line = random_line(6, seed, bend=0.6)
    found = line.geometry
    stand = zero(found, line.fork_offsets)
    # The input fork's axes; its pin along y is horizontal.
    axes = found.frames[0]
    for k in range(6):
        if k:
            axes = axes @ Rotation.from_euler("x", np.pi / 2 + line.fork_offsets[k - 1]).as_matrix()
        axes = axes @ Rotation.from_euler("YZ", [stand.driving[k], stand.driven[k]]).as_matrix()
        assert axes[:, 0] == pytest.approx(found.directions[k + 1], abs=1e-14)
        about = Rotation.from_euler("x", stand.rotations[k + 1]).as_matrix()
        assert axes == pytest.approx(found.frames[k + 1] @ about, abs=1e-14)


def test_the_lead_is_the_twist_of_both_turns() -> None:
    rng = np.random.default_rng(0)
    a, b = rng.uniform(-1.5, 1.5, (2, 200))
    both = Rotation.from_euler("YZ", np.stack([a, b], axis=1))
    x, _, _, w = both.as_quat().T
    assert np.tan(lead(a, b) / 2) == pytest.approx(x / w, rel=1e-12)


def test_a_straight_joint_leads_by_nothing() -> None:
    assert lead(0.0, 0.0) == 0.0
    assert lead(1e-9, 1e-9) == pytest.approx(5e-19, rel=1e-12)
