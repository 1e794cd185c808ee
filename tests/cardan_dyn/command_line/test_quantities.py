"""Words of the command line: names and values, in the unit that they or their option say."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import cardan_dyn as cd
from cardan_dyn.practice.command_line.quantities import (
    assigned,
    by_joint,
    efforts,
    limits,
    positions,
)

NAMES = st.text("ab_1=ä", min_size=1, max_size=6)


@given(st.dictionaries(NAMES, st.floats(allow_nan=False), max_size=4))
def test_assignments_are_read_back(values: dict[str, float]) -> None:
    """The name may contain equals signs itself: the last one separates."""
    pairs = tuple(f"{name}={value!r}" for name, value in values.items())
    assert {name: float(text) for name, text in assigned(pairs, "--held").items()} == values


def test_a_name_that_comes_twice_is_refused() -> None:
    """The first of two loads would vanish without a word."""
    with pytest.raises(cd.ArgumentError, match=r"^--load a is given twice, 1 and -3$"):
        assigned(("a=1", "b=2e3", "a=-3"), "--load")


@pytest.mark.parametrize("pair", ["a", "a=", "=3", "", "=", "a= "])
def test_other_forms_are_refused(pair: str) -> None:
    with pytest.raises(cd.ArgumentError) as caught:
        assigned(("ok=1", pair), "--load")
    assert str(caught.value) == f"--load {pair!r} is not JOINT=VALUE"


def test_joints_have_angles_and_slides_lengths() -> None:
    slider = cd.load("slider_crank")
    given = ("crank_bearing=30", "crank_pin=0.5rad", "piston_guide=2e-3")
    expected = {"crank_bearing": math.pi / 6, "crank_pin": 0.5, "piston_guide": 2e-3}
    assert positions(slider, given) == pytest.approx(expected, rel=1e-15)
    assert positions(slider, ["piston_guide=2 mm"]) == {"piston_guide": 2e-3}
    assert efforts(slider, ["crank_pin=-5", "piston_guide=2kN"]) == {
        "crank_pin": -5.0,
        "piston_guide": 2000.0,
    }
    for text in ("piston_guide=3deg", "crank_pin=3 m", "crank_pin=a", "crank_pin=1,5"):
        with pytest.raises(cd.ModelError, match=f"--held {text.partition('=')[0]}"):
            positions(slider, [text])
    with pytest.raises(cd.ModelError, match="no joint 'elbow'"):
        efforts(slider, ["elbow=3"])


def test_links_have_forces_and_moments() -> None:
    """As `loads` of a scene takes them, by the drive effort of a lever whose arm is known."""
    lever = cd.load(
        """<robot name="lever"><link name="base"/><link name="arm"/><link name="end"/>
        <joint name="pin" type="continuous"><parent link="base"/><child link="arm"/>
        <axis xyz="0 1 0"/></joint><joint name="payload" type="fixed"><parent link="arm"/>
        <child link="end"/><origin xyz="3 0 0"/></joint></robot>"""
    )
    for text, at_30_degrees in {
        "payload=0 0 -20kN world": -3.0 * 20e3 * math.cos(math.pi / 6),
        "end=0 0 -20000": -3.0 * 20e3,
        "arm=0 0 -20000 0 7 0 link": -7.0,
    }.items():
        loads = efforts(lever, [text])
        sweep = cd.Scene(lever, drive="pin", loads=loads).sweep(math.pi / 6)
        # The drive balances the load's moment about y, which is -x times its force along z.
        assert sweep.drive_effort.item() == pytest.approx(at_30_degrees, rel=1e-12)
    for text in ("payload=-20000", "payload=1 2", "end=1 2 3 4 world"):
        with pytest.raises(cd.ArgumentError, match="a link takes a force, three numbers"):
            efforts(lever, [text])
    with pytest.raises(cd.ModelError, match="--load end"):
        efforts(lever, ["end=1 2 3m"])


def test_one_number_is_of_all_joints_that_have_no_other() -> None:
    slider = cd.load("slider_crank")
    kind = "length", "m"
    assert by_joint(["0.1 mm"], "--clearance", kind, slider) == pytest.approx(1e-4)
    found = by_joint(["1e-4", "crank_pin=0.2mm"], "--clearance", kind, slider)
    assert found == pytest.approx({**dict.fromkeys(slider.joints, 1e-4), "crank_pin": 2e-4})


def test_limits_say_their_unit_where_they_have_one() -> None:
    given = ("residual_angle=3deg", "balance_grade_maker=16 mm/s", "non_uniformity=0.01")
    found = limits((*given, "critical_constant=steel", "balancing_speed=3000rpm"))
    assert found == {
        "residual_angle": pytest.approx(math.radians(3.0)),
        "balance_grade_maker": pytest.approx(0.016),
        "non_uniformity": 0.01,
        "critical_constant": "steel",
        "balancing_speed": pytest.approx(100.0 * math.pi),
    }
    for text in ("residual_angle=3", "least_joint_angle=0.1", "telescope_overlap=5"):
        with pytest.raises(cd.ModelError, match="has no unit; write"):
            limits([text])
