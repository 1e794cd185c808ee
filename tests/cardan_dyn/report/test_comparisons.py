"""Comparisons with the closed forms: all pass, and a wrong formula or sweep would not."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.scenes import CrossGeometry

import cardan_dyn as cd
from cardan_dyn.practice.report import comparisons


@pytest.fixture(scope="module")
def made() -> comparisons.Comparisons:
    return comparisons.run()


@pytest.mark.slow
def test_every_comparison_passes_at_every_angle(made: comparisons.Comparisons) -> None:
    assert len(made) == 17
    for item in made:
        assert set(item.errors) == {1.0, 8.5, 30.0, 50.0, 80.0}
        assert item.passed, item
        assert item.worst <= 1e-13 or "1000 rad/s" in item.quantity
    sources = {item.source for item in made}
    assert {"Thoma (6)", "Thoma (7)", "Grossmann (6)", "Grossmann (7)"} <= sources


def test_wrong_references_are_noticed(made: comparisons.Comparisons) -> None:
    """The deviation measure itself: swapped or negated quantities are far outside."""
    closed = comparisons.grossmann.moments(0.5, comparisons.POSITIONS)
    assert comparisons.deviation(-closed.torsion_2, closed.torsion_2) > 1.0
    assert comparisons.deviation(closed.bending_2, closed.bending_1) > 0.1
    assert [item.worst for item in made] == [max(item.errors.values()) for item in made]


def test_deviation_is_relative_to_the_greatest_reference() -> None:
    assert comparisons.deviation(np.array([1.0, -3.0]), np.array([1.5, -4.0])) == 0.25


def test_main_positions_are_among_the_positions() -> None:
    np.testing.assert_allclose(
        comparisons.POSITIONS[[0, 180, 360, 540, 720]], np.pi * np.arange(5) / 2.0, rtol=1e-15
    )


def test_moments_of_thoma_are_those_of_the_cross(joint: cd.Mechanism) -> None:
    """The bearing balances the moment of the cross; about y and z across the output shaft."""
    beta = 0.7
    turn = comparisons.turn_of(joint, beta)
    assert turn.held == {"joint_angle": beta} and turn.drives == ("bearing_in",)
    np.testing.assert_array_equal(turn.motion.position("bearing_in"), comparisons.POSITIONS)
    geometry = CrossGeometry(beta, comparisons.POSITIONS)
    bearing = -geometry.moment(comparisons.TORQUE)
    in_plane = np.array([-np.sin(beta), np.cos(beta), 0.0])
    pairs = comparisons.of_joint(turn)
    m_x, m_z = (comparisons.TORQUE * pairs[f"bending M_{i}/M_t"].computed for i in "xz")
    np.testing.assert_allclose(m_x, bearing @ in_plane, atol=1e-11)
    np.testing.assert_allclose(m_z, bearing[:, 2], atol=1e-11)


def test_double_shaft_turns_evenly_under_its_load(shaft: cd.Mechanism) -> None:
    turn = comparisons.turn_of(shaft, 0.4, speed=20.0)
    assert turn.held == {"joint_angle_1": 0.4, "joint_angle_2": 0.4}
    np.testing.assert_allclose(turn.motion.ratio("bearing_out"), 1.0, rtol=1e-13)
    out, inside = (
        turn.motion.v[:, turn.mechanism.model.joints[turn.mechanism.joint(name).id].idx_v]
        for name in ("bearing_out", "bearing_in")
    )
    np.testing.assert_array_equal(inside, 20.0)
    np.testing.assert_allclose(out, 20.0, rtol=1e-12)


def test_a_wrong_closed_form_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    """Thoma's equation (7) with the wrong sign, at one angle."""
    right = comparisons.thoma.bending_moments

    def wrong(beta: float, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        m_x, m_z = right(beta, phi)
        return m_x, -m_z

    monkeypatch.setattr(comparisons, "BETAS_DEG", (30.0,))
    monkeypatch.setattr(comparisons.thoma, "bending_moments", wrong)
    made = comparisons.run()
    assert not made.passed
    assert [item.source for item in made if not item.passed] == ["Thoma (7)"]
    assert {beta for item in made for beta in item.errors} == {30.0}
