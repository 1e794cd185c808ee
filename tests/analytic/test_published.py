"""Values printed in the sources, each within what its printing allows; the wrong ones outside."""

import json
from pathlib import Path

import numpy as np
import pytest

from cardan_dyn.analytic import compound_angle, impact, single_joint

TABLE = Path(__file__).parents[1] / "reference" / "published.json"
PUBLISHED = json.loads(TABLE.read_text(encoding="utf-8"))

BETA = np.radians(30.0)
ALPHA = single_joint.equal_speed_angle(BETA, zero="normal")
SMALLEST, GREATEST = single_joint.speed_ratio_range(BETA)
PEAK = impact.reversal(mass=3.6, stiffness=1e7, half_clearance=0.5e-4, ramp=360e3).peak

COMPUTED = {
    "weisbach_greatest_ratio": GREATEST,
    "weisbach_smallest_ratio": SMALLEST,
    "weisbach_ratio_of_ratios": GREATEST / SMALLEST,
    "weisbach_non_uniformity": single_joint.non_uniformity(BETA),
    "weisbach_tangent_alpha": np.tan(ALPHA),
    "weisbach_tangent_beta": np.tan(single_joint.output_angle(BETA, ALPHA, zero="normal")),
    "weisbach_alpha_minutes": 60 * np.degrees(ALPHA),
    "weisbach_beta_minutes": 60 * np.degrees(single_joint.output_angle(BETA, ALPHA, zero="normal")),
    "weisbach_lead_minutes": 60 * np.degrees(single_joint.greatest_lead(BETA)),
    "thoma_square_of_versine": (1 - np.cos(np.radians(8.5))) ** 2,
    "catalogue_beta_1_deg": np.degrees(compound_angle.compound_angle(*np.radians([7.0, 15.0]))),
    "catalogue_fork_offset_deg": -np.degrees(
        compound_angle.fork_offset(*np.radians([7.0, 15.0, 12.0, -11.5]))
    ),
    "dresig_peak": PEAK,
    "dresig_percent_of_measured": 100 * PEAK / 2250,
}


@pytest.mark.parametrize("entry", PUBLISHED, ids=lambda entry: entry["quantity"])
def test_printed_value(entry):
    deviation = abs(COMPUTED[entry["quantity"]] - entry["printed"])
    if entry["right"]:
        assert deviation <= entry["tolerance"]
    else:
        assert deviation > entry["tolerance"]


def test_both_lists_name_the_same_quantities():
    assert [entry["quantity"] for entry in PUBLISHED] == list(COMPUTED)


# Digits beyond the printed ones, for the worked examples and figures of the sources.


def test_weisbachs_example_in_full():
    values = (GREATEST, SMALLEST, single_joint.non_uniformity(BETA))
    assert values == pytest.approx((1.154701, 0.866025, 0.288675), abs=5e-7)
    beta = np.degrees(single_joint.output_angle(BETA, ALPHA, zero="normal"))
    assert np.degrees(ALPHA) == pytest.approx(47.0586, abs=5e-5)
    assert beta == pytest.approx(42.9414, abs=5e-5)
    assert np.degrees(ALPHA) - beta == pytest.approx(4.1172, abs=5e-5)


def test_bild_19_in_full():
    angles = compound_angle.compound_angle(np.radians([7.0, 12.0]), np.radians([15.0, -11.5]))
    assert np.degrees(angles) == pytest.approx([16.4225, 16.3956], abs=5e-5)


def test_example_of_dresig_and_thuemmel_in_full():
    result = impact.reversal(mass=3.6, stiffness=1e7, half_clearance=0.5e-4, ramp=360e3)
    assert result.t_1 == pytest.approx(1.81712e-3, abs=5e-9)
    assert result.v_1 == pytest.approx(0.165096, abs=5e-7)
    assert result.tau == pytest.approx(3.02853, abs=5e-6)
    assert np.degrees(result.theta_m) == pytest.approx(142.484, abs=5e-4)
    assert result.peak == pytest.approx(2181.89, abs=5e-3)
    assert result.rigid == pytest.approx(1191.31, abs=5e-3)
    assert result.added == pytest.approx(990.58, abs=5e-3)
