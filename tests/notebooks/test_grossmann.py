"""What Grossmann's notebook shows: his equations, his polar diagrams, his wrong second form."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from stories import tell

from cardan_dyn.analytic import errata, grossmann


@pytest.fixture(scope="module")
def story() -> SimpleNamespace:
    return tell("grossmann")


def test_the_swing_of_the_moment(story: SimpleNamespace) -> None:
    phi, (psi_1, psi_2) = story.phi, story.found_psi
    np.testing.assert_allclose(story.found_psi, story.his_psi, atol=1e-12)
    np.testing.assert_allclose(
        story.found_psi, grossmann.swing_angles(phi, story.alpha_1), atol=1e-12
    )
    np.testing.assert_allclose(np.cos(psi_1) * np.cos(psi_2), np.cos(phi), rtol=1e-12)  # (2)
    np.testing.assert_allclose(
        np.sin(psi_2), np.sin(phi) * np.cos(story.alpha_1), atol=1e-12
    )  # (5)
    # His quarter turns: ψ₁ = 0, φ, 0, −φ and ψ₂ = φ, 0, −φ, 0.
    np.testing.assert_allclose(psi_1[[0, 180, 360, 540]], [0, phi, 0, -phi], atol=1e-12)
    np.testing.assert_allclose(psi_2[[0, 180, 360, 540]], [phi, 0, -phi, 0], atol=1e-12)


def test_the_torque_of_shaft_2(story: SimpleNamespace) -> None:
    phi, found = story.phi, story.found_torque
    np.testing.assert_allclose(found, story.his_torque, rtol=1e-13)
    second_form = 1.0 / (np.cos(phi) * (1.0 + np.tan(phi) ** 2 * np.cos(story.turned_2) ** 2))
    np.testing.assert_allclose(found, second_form, rtol=1e-12)
    assert (round(found.min(), 6), round(found.max(), 6)) == (0.642788, 1.555724)


def test_the_bending_of_both_shafts(story: SimpleNamespace) -> None:
    np.testing.assert_allclose(story.bending_1, story.his_bending_1, atol=1e-13)
    np.testing.assert_allclose(story.bending_2, story.his_bending_2, atol=1e-13)
    closed = grossmann.moments(story.phi, story.alpha_1)
    np.testing.assert_allclose(story.bending_2, closed.bending_2, atol=1e-13)
    np.testing.assert_allclose(story.turned_2, story.alpha_2, atol=1e-13)
    assert round(story.bending_1.max(), 6) == 1.191754
    assert round(story.bending_2[0], 6) == 0.766044
    assert (round(story.greatest, 6), round(np.rad2deg(story.where), 3)) == (0.777862, 22.622)
    there = story.scene.sweep([story.where])
    np.testing.assert_allclose(
        there["bearing_out"].bending / there["bearing_in"].torsion, story.greatest, rtol=1e-13
    )


def test_the_second_form_is_wrong(story: SimpleNamespace) -> None:
    np.testing.assert_allclose(story.bending_2, story.corrected, atol=1e-12)
    assert np.max(np.abs(story.printed - story.bending_2)) > 0.4
    there = story.scene.sweep([0.7])
    tan_cos = np.tan(story.phi) * np.cos(there.motion.position("bearing_out")[0])
    right = there["bearing_out"].bending[0] / there["bearing_in"].torsion[0]
    wrong = tan_cos / (np.cos(story.phi) * np.sqrt(1.0 + tan_cos**2))
    (entry,) = errata.errata("Grossmann 1939")
    assert entry.numbers[0].printed == round(float(wrong), 6) == 0.911503
    assert entry.numbers[0].right == round(float(right), 6) == 0.738665


def test_the_inertia_of_the_cross(story: SimpleNamespace) -> None:
    taken, expected, fast = story.taken, story.expected, story.fast
    np.testing.assert_allclose(taken, expected, atol=1e-10 * np.max(np.abs(expected)))
    greatest = np.max(np.linalg.norm(fast["pin_in"].moment, axis=1))
    for pin in ("pin_in", "pin_out"):
        np.testing.assert_allclose(fast[pin].torsion, 0.0, atol=1e-12 * greatest)
    # About the other pin the moment in pin 1 is zero only without inertia.
    along = np.sum(fast.wrench("pin_in", "world").moment * story.arms[1], axis=1)
    np.testing.assert_allclose(
        along, np.sum(expected * story.arms[1], axis=1), atol=1e-9 * greatest
    )
    assert (round(story.kept), round(story.about_pin_2)) == (95, 33)
