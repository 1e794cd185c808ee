"""Forms of elements: their sizes, and that all their faces look outwards."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from cardan_dyn.practice.viewer import shapes as forms

Surface = tuple[np.ndarray, np.ndarray]
SOLIDS: dict[str, tuple[Callable[[], Surface], float]] = {
    # Volumes by hand: cylinders, rings and sectors of rings.
    "dashpot": (lambda: forms.dashpot(0.1), np.pi * (0.025**2 + 0.45 * 0.1**2)),
    "shoes": (lambda: forms.brake_shoes(0.1), 0.9 * (0.13**2 - 0.104**2) * 0.04),
    "pads": (lambda: forms.pads(0.1), 1.4 * (0.07**2 - 0.025**2) * 0.2),
}


def volume(surface: Surface) -> float:
    """Return the volume that faces enclose, which look outwards if it is positive."""
    corners = surface[0][surface[1]]
    return float(np.sum(np.linalg.det(corners)) / 6.0)


@pytest.mark.parametrize("name", SOLIDS)
def test_faces_enclose_the_volume_of_the_form(name: str) -> None:
    make, expected = SOLIDS[name]
    # A polygon of 20 sides has 1.6 % less area than its circle.
    assert volume(make()) == pytest.approx(expected, rel=0.03)
    assert volume(make()) < expected


def test_an_arc_arrow_points_in_the_sense_of_the_turn() -> None:
    vertices, faces = forms.arc_arrow()
    assert volume((vertices, faces)) > 0.0
    radius, angle = np.hypot(*vertices[:, :2].T), np.arctan2(vertices[:, 1], vertices[:, 0])
    widest, farthest = np.argmax(radius), np.argmin(np.abs(angle - (4.9 - 2.0 * np.pi)))
    # The head is widest where the shaft ends, and its tip is further on in the same sense.
    assert angle[widest] == pytest.approx(4.2 - 2.0 * np.pi)
    assert angle[farthest] == pytest.approx(4.9 - 2.0 * np.pi)
    assert radius[farthest] == pytest.approx(0.94, abs=0.01)
    assert 1.0 < radius[widest] < 1.2


def test_a_coil_has_the_length_one() -> None:
    points = forms.coil(0.1)
    assert points[0].tolist() == [0.0, 0.0, 0.0]
    assert points[-1].tolist() == [0.0, 0.0, 1.0]
    assert np.max(np.hypot(*points[:, :2].T)) == pytest.approx(0.1)


def test_a_spiral_ends_on_x_at_its_radius() -> None:
    points = forms.spiral(0.2)
    np.testing.assert_allclose(points[-1], [0.2, 0.0, 0.0], atol=1e-15)
    assert points[0].tolist() == [0.0, 0.0, 0.0]
    sizes = np.hypot(*points[:, :2].T)
    assert np.all(np.diff(sizes) > 0.0)
    assert not np.any(points[:, 2])
