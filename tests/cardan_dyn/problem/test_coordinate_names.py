"""Names of single coordinates, and why others are none."""

from __future__ import annotations

import pytest

import cardan_dyn as cd
from cardan_dyn.core.problem.coordinate_names import check_single, coordinates_of

CHAIN = (
    '<robot name="chain"><link name="ground"/><link name="a"/><link name="b"/><link name="c"/>'
    '<joint name="u" type="universal"><parent link="ground"/><child link="a"/>'
    '<axis xyz="1 0 0"/><axis2 xyz="0 1 0"/></joint>'
    '<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>'
    '<joint name="f" type="fixed" adjustable="revolute"><parent link="b"/><child link="c"/>'
    '<axis xyz="0 0 1"/></joint></robot>'
)


@pytest.fixture(scope="module")
def chain() -> cd.Mechanism:
    return cd.load(CHAIN)


@pytest.mark.parametrize("name", ["j", "u.turn_1", "u.turn_2"])
def test_single_coordinates_pass(chain: cd.Mechanism, name: str) -> None:
    check_single(chain, name, "drive")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("u", "drive 'u' is a universal joint; name one of its coordinates: u.turn_1, u.turn_2"),
        ("u.turn", "joint 'u' has no coordinate 'turn'; name one of its coordinates"),
        ("j.turn", "joint 'j' has no coordinate 'turn'; it has one coordinate, which is called"),
        ("x.turn", "no joint or coordinate 'x.turn'; there are: "),
        ("x", "no joint 'x'; joints: "),
        ("f", "drive 'f' is fixed in this scene; hold it there as well"),
    ],
)
def test_other_names_are_refused(chain: cd.Mechanism, name: str, message: str) -> None:
    with pytest.raises(cd.CardanError) as caught:
        check_single(chain, name, "drive")
    assert message in str(caught.value)


def test_coordinates_of_a_joint(chain: cd.Mechanism) -> None:
    assert coordinates_of(chain, "u") == "name one of its coordinates: u.turn_1, u.turn_2"
