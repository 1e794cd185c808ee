"""Pictures: where a mechanism's bodies are on paper."""

from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd

pytest.importorskip("matplotlib")
pytest.importorskip("meshcat")

from cardan_dyn.practice.viewer.picture import picture


def _corners(figure: object) -> np.ndarray:
    (collection,) = figure.axes[0].collections  # type: ignore[attr-defined]
    return np.concatenate([path.vertices for path in collection.get_paths()])


def test_a_flat_linkage_is_seen_from_straight_ahead() -> None:
    """Names stand beside the joints, x to the right and y upwards."""
    sweep = cd.Scene(cd.load("four_bar"), drive="crank_bearing").sweep([0.7])
    figure = picture(sweep)
    places = {text.get_text(): text.xy for text in figure.axes[0].texts}
    for name in ("rocker_pin", "rocker_bearing"):
        np.testing.assert_allclose(places[name], sweep.origin(name)[0, :2], atol=0.03)
    low, high = _corners(figure).min(axis=0), _corners(figure).max(axis=0)
    assert np.all(low <= sweep.origin("crank_bearing")[0, :2])
    assert np.all(high >= sweep.origin("rocker_pin")[0, :2])


@pytest.mark.parametrize("name", ["universal_joint", "stewart_platform", "needle_drive"])
def test_every_corner_is_on_paper(name: str) -> None:
    mechanism = cd.load(name)
    drives = cd.describe(mechanism).drives
    scene = cd.Scene(mechanism, drive=drives.default, held=drives.held)
    figure = picture(scene.sweep(np.zeros((1, len(drives.default)))))
    axes = figure.axes[0]
    corners = _corners(figure)
    assert len(corners) > 100 and np.all(np.isfinite(corners))
    for values, limits in zip(corners.T, (axes.get_xlim(), axes.get_ylim()), strict=True):
        assert limits[0] <= values.min() and values.max() <= limits[1]
    assert axes.get_aspect() == 1.0


def test_names_are_written_letter_by_letter() -> None:
    """Two names with a dollar each, in one label, are no formula."""
    mechanism = cd.load(
        '<robot name="arm"><link name="a"/><link name="b"/><link name="c"/>'
        '<joint name="m$1" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/>'
        '</joint><joint name="n$2" type="revolute"><parent link="b"/><child link="c"/>'
        '<axis xyz="1 0 0"/></joint></robot>',
        strict=False,
    )
    figure = picture(cd.Scene(mechanism, drive=["m$1", "n$2"]).sweep([[0.1, 0.2]]))
    (label,) = figure.axes[0].texts
    assert label.get_text() == "m\\$1,\nn\\$2"


def test_a_picture_is_of_one_design(joint: cd.Mechanism) -> None:
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.3})
    grid = scene.sweep(np.zeros(3), held={"joint_angle": np.array([[0.1], [0.2]])})
    with pytest.raises(cd.ArgumentError, match=r"one dimension, not of shape \(2, 3\)"):
        picture(grid)
