"""What Weisbach's notebook shows is what his paragraph says, and what is right."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from stories import tell

from cardan_dyn.analytic import single_joint


@pytest.fixture(scope="module")
def story() -> SimpleNamespace:
    return tell("weisbach")


def test_both_paths_are_great_circles(story: SimpleNamespace) -> None:
    o, q, c = story.pin_o, story.pin_q, story.c
    np.testing.assert_allclose(o[:, 0], 0.0, atol=1e-13)
    np.testing.assert_allclose(np.sum(o * q, axis=1), 0.0, atol=1e-13)
    np.testing.assert_allclose(q @ [np.cos(c), np.sin(c), 0.0], 0.0, atol=1e-13)
    np.testing.assert_allclose((q[:, 1] / np.cos(c)) ** 2 + q[:, 2] ** 2, 1.0, rtol=1e-12)


def test_his_construction_and_the_pins_are_drawn_at_the_same_places(story: SimpleNamespace) -> None:
    np.testing.assert_allclose(story.pin_o @ story.seen.T, story.his_circle, atol=1e-13)
    np.testing.assert_allclose(story.pin_q @ story.seen.T, story.his_ellipse, atol=1e-13)
    assert round(np.rad2deg(story.alpha[story.at]), 12) == 50.0


def test_the_spherical_triangle(story: SimpleNamespace) -> None:
    alpha, beta, c = story.alpha, story.beta, story.c
    np.testing.assert_allclose(
        np.sin(beta) * np.cos(alpha), np.cos(c) * np.sin(alpha) * np.cos(beta), atol=1e-14
    )
    np.testing.assert_allclose(beta, single_joint.output_angle(c, alpha, zero="normal"), atol=1e-13)
    # "Always tan β < tan α" fails in the second quadrant: α = 135°.
    assert round(np.tan(beta[270]) - np.tan(alpha[270]), 6) == 0.133975


def test_the_ratio_of_the_speeds(story: SimpleNamespace) -> None:
    alpha, c = story.alpha, story.c
    formula = np.cos(c) / (1.0 - np.sin(alpha) ** 2 * np.sin(c) ** 2)
    np.testing.assert_allclose(story.omega, formula, rtol=1e-13)
    np.testing.assert_allclose(story.omega[[180, 540]], 1.0 / np.cos(c), rtol=1e-13)
    np.testing.assert_allclose(story.omega[[0, 360]], np.cos(c), rtol=1e-13)
    for his, ours in story.ratio_panels:
        for drawn, found in zip(his.lines, ours.lines, strict=True):
            np.testing.assert_allclose(found.get_ydata(), drawn.get_ydata(), atol=1e-11)


def test_the_example(story: SimpleNamespace) -> None:
    assert {name: found for name, (_, found) in story.example.items()} == {
        "greatest ratio 1/cos c": "1.1547",
        "least ratio cos c": "0.8660",
        "degree of non-uniformity": "0.28868",
        "tan α at equal speeds": "1.07457",
        "α at equal speeds": "47° 3.5′",
        "β at equal speeds": "42° 56.5′",
        "greatest deviation α − β": "4° 7.0′",
    }
    np.testing.assert_allclose(np.tan(story.equal), 1.0 / np.sqrt(np.cos(story.c)), rtol=1e-9)
    np.testing.assert_allclose(np.tan(story.beta_equal), np.sqrt(np.cos(story.c)), rtol=1e-9)
    np.testing.assert_allclose(
        story.equal - story.beta_equal, single_joint.greatest_lead(story.c), rtol=1e-9
    )


def test_ring_and_teeth(story: SimpleNamespace) -> None:
    np.testing.assert_allclose(story.ring_ratio, story.omega, rtol=1e-13)
    assert round(story.ring_bending, 4) == round((np.sqrt(2.0) - 1.0) / 4.0, 4) == 0.1036
    expected = {5.0: 0.218, 10.0: 0.877, 20.0: 3.562, 30.0: 8.213}
    assert {c: round(play, 3) for c, play in story.taylor.items()} == expected
