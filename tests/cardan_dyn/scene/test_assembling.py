"""Closed configurations before there is any scene."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.many_drives import COUPLER, ROCKER, linkage
from testkit.planar_linkages import COUPLER as BAR
from testkit.planar_linkages import four_bar

import cardan_dyn as cd


def test_a_closed_zero_stays_as_it_is() -> None:
    for name in ("four_bar", "stewart_platform", "universal_joint"):
        mechanism = cd.load(name)
        configuration = cd.assemble(mechanism)
        np.testing.assert_array_equal(configuration.x, mechanism.coordinates.neutral())
        assert configuration.loop_residual == configuration.zero_residual < 1e-14
        assert configuration.branch is None


def unclosed(coupler: float) -> cd.Mechanism:
    """A linkage whose coupler has another length than the one that closes its zero."""
    text = f'<robot name="linkage"><link name="base"/>{linkage(0, "base")}</robot>'
    return cd.load(
        text.replace(f'<origin xyz="{COUPLER!r} 0 0"/>', f'<origin xyz="{coupler} 0 0"/>')
    )


def test_an_unclosed_zero_is_closed_nearby() -> None:
    mechanism = unclosed(0.36)
    configuration = cd.assemble(mechanism)
    assert configuration.zero_residual > 1e-3
    assert configuration.loop_residual < 1e-12
    ends = [configuration.origin(name) for name in ("end_0", "rocker_0", "middle_0")]
    assert np.linalg.norm(ends[0] - ends[1]) == pytest.approx(ROCKER, rel=1e-12)
    assert np.linalg.norm(ends[0] - ends[2]) == pytest.approx(0.36, rel=1e-12)
    moved = [configuration.positions[name] for name in ("crank_0", "middle_0", "rocker_0")]
    assert np.max(np.abs(moved)) < 0.2


def test_joints_of_start_are_where_they_are_wanted() -> None:
    mechanism = cd.load("four_bar")
    for angle in (0.3, 3.0, -9.0):
        configuration = cd.assemble(mechanism, near={"crank_bearing": angle})
        assert configuration.positions["crank_bearing"] == angle
        assert configuration.loop_residual < 1e-12
        # The way there keeps the assembly mode, as a scene that starts there does.
        scene = cd.Scene(mechanism, drive="crank_bearing", near={"crank_bearing": angle})
        expected = scene.configuration()
        for joint in mechanism:
            a, b = configuration.rotation(joint), expected.rotation(joint)
            np.testing.assert_allclose(a, b, atol=1e-9)


def test_positions_that_close_are_taken_as_they_are() -> None:
    mechanism = cd.load("four_bar")
    crossed = cd.Scene(mechanism, drive="crank_bearing", branch="B").configuration()
    assert crossed.branch == "B"
    again = cd.assemble(mechanism, near=crossed.positions)
    np.testing.assert_array_equal(again.x, crossed.x)


def test_a_scene_may_start_in_a_configuration() -> None:
    mechanism = cd.load("four_bar")
    crossed = cd.Scene(mechanism, drive="crank_bearing", branch="B").configuration()
    scene = cd.Scene(mechanism, drive="crank_bearing", near=crossed.positions)
    sweep = scene.sweep([0.0, 0.1])
    assert sweep.motion.position("rocker_bearing")[0] == pytest.approx(
        crossed.positions["rocker_bearing"]
    )


def test_scenes_with_outputs_close_all_loops() -> None:
    mechanism = cd.load("needle_drive")
    drive = next(name for name in mechanism if mechanism[name].nv == 1)
    scene = cd.Scene(mechanism, drive=drive, near={drive: 0.4}, outputs=[drive])
    assert scene.configuration().loop_residual < 1e-10


def test_describe_looks_around_a_configuration() -> None:
    """In a parallelogram the zero is a change point, other configurations are not."""
    mechanism = four_bar(crank=1.0, rocker=1.0, base=BAR)
    moved = cd.assemble(mechanism, near={"A": 0.4})
    report, there = cd.describe(mechanism), cd.describe(moved)
    assert report.mobility == there.mobility == 1
    assert not there.components[0].is_singular_at_zero
    quarter = 0.5 * np.pi
    flat = cd.assemble(mechanism, near={"A": quarter, "B": -quarter, "C": quarter, "D": quarter})
    text = str(cd.describe(flat))
    assert "this configuration is a singular configuration of C" in text


@pytest.mark.slow
def test_what_cannot_be_closed_is_refused() -> None:
    mechanism = cd.load("four_bar")
    with pytest.raises(
        cd.AssemblyError,
        match=r"four_bar: the loops cannot be closed with the joints of start at their positions "
        r"\(crank_bearing: 2, rocker_bearing: 3\); the least closure error found .* is 5.7e-01",
    ) as caught:
        cd.assemble(mechanism, near={"crank_bearing": 2.0, "rocker_bearing": 3.0})
    assert caught.value.details["residual"] == pytest.approx(0.57, abs=0.01)
    with pytest.raises(cd.AssemblyError, match="check the origins of joints and loops"):
        cd.assemble(unclosed(9.0))


def test_wrong_arguments_are_refused() -> None:
    mechanism = cd.load("four_bar")
    with pytest.raises(cd.ModelError, match="no joint 'lever'"):
        cd.assemble(mechanism, near={"lever": 1.0})
    with pytest.raises(cd.ArgumentError, match="near"):
        cd.assemble(mechanism, near={"crank_bearing": np.nan})
