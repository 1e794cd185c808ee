"""Limits of effort in a URDF: in both senses, of commands, and written so that others read them."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import cardan_dyn as cd
from cardan_dyn.core.description.description import Limits
from cardan_dyn.core.description.read import read
from cardan_dyn.core.description.write import to_urdf
from cardan_dyn.core.results.limits import exceeded

ROD = """<robot name="r"><link name="a"/><link name="b"/><joint name="ram" type="{kind}">
<parent link="a"/><child link="b"/>{limit}{more}</joint>{control}</robot>"""


def rod(limit: str = "", kind: str = "prismatic", more: str = "", effort: str = "") -> str:
    control = (
        '<ros2_control name="c" type="system"><joint name="ram"><command_interface name="effort">'
        f"{effort}</command_interface></joint></ros2_control>"
    )
    return ROD.format(kind=kind, limit=limit, more=more, control=control if effort else "")


@pytest.mark.parametrize(
    ("limit", "efforts"),
    [
        ('<limit effort="9" velocity="1" least_effort="-6"/>', (-6.0, 9.0)),
        ('<limit effort="9" velocity="1"/>', (-9.0, 9.0)),
        ('<limit effort="9" velocity="1" least_effort="-inf"/>', (-np.inf, 9.0)),
        ('<limit effort="inf" velocity="inf" lower="-inf" upper="inf"/>', (-np.inf, np.inf)),
        ("", (-np.inf, np.inf)),
    ],
)
@pytest.mark.parametrize("kind", ["prismatic", "revolute", "continuous"])
@pytest.mark.parametrize("more", ["", '<dynamics armature="2"/>'])
def test_they_are_written_for_every_reader(
    limit: str, efforts: tuple[float, float], kind: str, more: str
) -> None:
    found = read(rod(limit, kind, more))
    assert found.joints[0].limits.efforts == efforts
    assert read(to_urdf(found)) == found
    model = pin.buildModelFromXML(to_urdf(found))
    most = np.nan_to_num(efforts[1])
    if kind != "continuous" or np.isfinite(efforts[1]):
        np.testing.assert_array_equal(model.upperEffortLimit, most)
    own = cd.Mechanism(found).model
    np.testing.assert_array_equal([own.lowerEffortLimit[0], own.upperEffortLimit[0]], efforts)


@pytest.mark.parametrize(
    ("limit", "least", "greatest"),
    [("", -6.0, 9.0), ('<limit effort="7" velocity="1"/>', -6.0, 7.0), ("<limit/>", -6.0, 9.0)],
)
def test_the_tightest_of_joint_and_command_holds(limit: str, least: float, greatest: float) -> None:
    effort = '<param name="min">-6</param><param name="max">9</param>'
    assert read(rod(limit, effort=effort)).joints[0].limits.efforts == (least, greatest)
    one = read(rod(effort='<param name="max">9</param>')).joints[0].limits
    assert one == Limits(effort=9.0, least_effort=-np.inf)


@pytest.mark.parametrize(
    ("limit", "told"),
    [
        ('lower="0" upper="inf"', ["exceeds limit of ram (0 m): -100 mm at ram -100 mm"]),
        ('upper="0.05" lower="-inf"', ["exceeds limit of ram (50 mm): 100 mm at ram 100 mm"]),
        ('lower="0" upper="1e6"', ["exceeds limit of ram (0 m): -100 mm at ram -100 mm"]),
        ('lower="-1e5" upper="1e6"', []),
        ('lower="0" upper="0"', []),
    ],
)
def test_a_slide_with_one_end_is_judged_by_it(limit: str, told: list[str]) -> None:
    limit = f'<limit {limit} effort="inf" velocity="inf"/>'
    found = cd.Scene(cd.load(rod(limit)), drive="ram").sweep([-0.1, 0.0, 0.1])
    assert [*exceeded(found)] == told


@pytest.mark.parametrize("ends", [(3.0, 3.0), (4.0, 3.0)])
def test_efforts_that_hardly_anything_meets_are_judged(ends: tuple[float, float]) -> None:
    """Also where bounds of a motor and of its joint leave nothing."""
    least, greatest = ends
    limit = f'<limit effort="{greatest}" least_effort="{least}" velocity="1"/>'
    found = cd.Scene(cd.load(rod(limit)), drive="ram").sweep([0.0])
    assert "exceeds effort limit of ram" in str(exceeded(found))


def test_commands_that_nothing_can_meet_are_refused() -> None:
    effort = '<param name="min">6</param><param name="max">-9</param>'
    with pytest.raises(cd.ModelError, match="'ram': effort: min 6 is above max -9"):
        read(rod(effort=effort))
