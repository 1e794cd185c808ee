"""Reach: errors say what was asked for and what can be reached, as the user counts."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.planar_linkages import five_bar, four_bar, rocker_range

import cardan_dyn as cd
from cardan_dyn.core.kinematics.diagnosis.reach import degrees_hint, out_of_reach

pytestmark = pytest.mark.usefixtures("loaded_once")


def rocker() -> cd.Scene:
    return cd.Scene(four_bar(), drive="D")


@pytest.mark.parametrize(
    ("positions", "sample"),
    [
        (np.linspace(0.0, 3.0, 31), 7),
        ([0.1, 50.0, 60.0], 1),
        ([0.0, -0.1, -1e6], 2),
        # Several turns: whoever looks for a period notices the end first.
        (np.linspace(0.0, 40.0, 5), 1),
    ],
)
def test_the_first_sample_out_of_reach_is_named(positions: object, sample: int) -> None:
    with pytest.raises(cd.AssemblyError) as caught:
        rocker().sweep(positions)
    error = caught.value
    asked = np.asarray(positions)[sample]
    assert (error.sample, error.position) == (sample, asked)
    assert error.reach == pytest.approx(rocker_range(), abs=1e-8)
    assert error.nearest == pytest.approx(rocker_range()[int(asked > 0.0)], abs=1e-8)
    assert f"drive 'D' cannot be brought to {asked:.9g} (sample {sample}); it moves only" in str(
        error
    )
    assert error.finding in str(error)
    assert ("degrees were meant" in str(error)) == (abs(asked) > 2.0 * np.pi)


def test_samples_beyond_both_ends_name_one_that_belongs_to_the_end() -> None:
    with pytest.raises(cd.AssemblyError) as caught:
        rocker().sweep([2.0, -2.0])
    error = caught.value
    assert np.sign(error.position) == np.sign(error.nearest)
    assert error.position == [2.0, -2.0][error.sample or 0]


def test_what_lies_within_reach_is_solved_though_the_drive_cannot_turn_through() -> None:
    scene = cd.Scene(four_bar(), drive="D", near={"D": 0.3})
    low, high = scene.motion_range()
    scene.sweep(np.linspace(low + 1e-3, high - 1e-3, 20))


def test_singular_ends_say_where_and_what_moves() -> None:
    scene = cd.Scene(four_bar(1.0, 1.0, 2.0), drive="A")
    with pytest.raises(cd.SingularConfigurationError) as caught:
        scene.sweep([0.0, 1.0, 2.0])
    error = caught.value
    assert error.sample == 2
    assert error.position == pytest.approx(0.5 * np.pi, abs=5e-6)
    assert set(error.moving) == set("BCD")
    assert "drive 'A' cannot be brought to 2 (sample 2); it moves only between -1.57" in str(error)


def test_an_interval_out_of_reach_is_refused_as_it_was_given() -> None:
    with pytest.raises(cd.AssemblyError, match="a response from -1 to 2 goes beyond") as caught:
        rocker().response(interval=(-1.0, 2.0))
    assert caught.value.position in (-1.0, 2.0)
    assert caught.value.sample is None
    with pytest.raises(cd.CardanError, match=r"moves only between .* D cannot move there"):
        rocker().response()


def test_several_drives_name_the_sample() -> None:
    scene = cd.Scene(five_bar(), drive=["A", "D"])
    with pytest.raises(cd.AssemblyError, match=r"\(sample 1 of 3\)") as caught:
        scene.sweep([[0.0, 0.0], [1.5, -1.5], [0.0, 0.1]])
    assert caught.value.sample == 1
    np.testing.assert_array_equal(caught.value.position, [1.5, -1.5])
    assert np.shape(caught.value.nearest) == (2,)


def test_degrees_are_asked_for() -> None:
    with pytest.raises(cd.CardanError, match=r"if 50 degrees were meant, give 0\.872665") as caught:
        cd.Scene(cd.load("universal_joint"), drive="bearing_in", held={"joint_angle": 50.0})
    assert "held joint 'joint_angle' cannot be brought to 50: position 1.57" in str(caught.value)
    with pytest.raises(cd.AssemblyError, match=r"if 30 degrees were meant, give 0\.523599"):
        cd.Scene(four_bar(), drive="A", near={"D": 30.0})


def test_slides_have_no_degrees() -> None:
    assert degrees_hint(6.0) == ""
    assert "give 0.122173" in degrees_hint(7.0)
    error = cd.AssemblyError("inner", position=1.0, nearest=0.5, residual=1e-3, finding="stop")
    for slides in (True, False):
        found = out_of_reach("drive", "slide", 70.0, slides, error)
        assert ("degrees" in str(found)) != slides
        assert isinstance(found, cd.AssemblyError)
        assert (found.position, found.nearest, found.reach) == (70.0, 0.5, None)


def test_one_sided_ranges() -> None:
    error = cd.AssemblyError("inner", position=1.0, nearest=0.5, residual=1e-3, finding="stop")
    asked = "drive", "it", 1.0, True, error, 0
    assert "it moves up to 0.5:" in str(out_of_reach(*asked, (-np.inf, 0.5)))
    assert "it moves from 0 on:" in str(out_of_reach(*asked, (-1e-17, np.inf)))
