"""Three hinges that meet in a point are a ball, more of them are a spherical linkage."""

from __future__ import annotations

import pytest

import cardan_dyn as cd
from cardan_dyn.core.kinematics.assembly_modes import hinges_in_balls

DIRECTIONS = ("1 0 0", "0 1 0", "0 0 1", "1 1 0", "0 1 1", "1 0 1")


def chain(*points: str, close: str = "") -> cd.Mechanism:
    """Hinges in a row, each of them through a point of the link before it, along other axes."""
    names = [f"l{index}" for index in range(len(points) + 1)]
    links = "".join(f'<link name="{name}"/>' for name in names)
    joints = "".join(
        f'<joint name="j{index}" type="continuous"><parent link="{names[index]}"/>'
        f'<child link="{names[index + 1]}"/><origin xyz="{point}"/>'
        f'<axis xyz="{DIRECTIONS[index]}"/></joint>'
        for index, point in enumerate(points)
    )
    return cd.load(f'<robot name="chain">{links}{joints}{close}</robot>')


def names(mechanism: cd.Mechanism) -> set[str]:
    columns = mechanism.coordinates.velocity_columns
    return {name for name in mechanism if columns[name].start in hinges_in_balls(mechanism)}


HERE, AWAY = "0 0 0", "0.3 0.2 0.1"


@pytest.mark.parametrize(
    ("points", "expected"),
    [
        ((AWAY, HERE, HERE), {"j0", "j1", "j2"}),
        ((AWAY, AWAY, HERE, HERE, AWAY), {"j1", "j2", "j3"}),
        ((AWAY, HERE, HERE, AWAY, HERE, HERE), {f"j{index}" for index in range(6)}),
        ((AWAY, HERE, AWAY), set()),
        # Along its axis a hinge may be placed anywhere.
        ((AWAY, HERE, "0 0 0.4"), {"j0", "j1", "j2"}),
        # The axis of the second hinge passes beside the centre of the first two.
        ((AWAY, HERE, "0.4 0 0"), set()),
        ((AWAY, HERE, HERE, HERE), set()),
    ],
)
def test_balls_are_three_hinges(points: tuple[str, ...], expected: set[str]) -> None:
    assert names(chain(*points)) == expected


def test_a_spherical_linkage_has_no_balls() -> None:
    close = (
        '<loop name="j3" type="continuous"><predecessor link="l3"/><successor link="l0">'
        f'<origin xyz="{AWAY}"/></successor><axis xyz="1 1 1"/></loop>'
    )
    assert names(chain(AWAY, HERE, HERE, close=close)) == set()


def test_the_wrist_of_the_stewart_platform_is_a_ball() -> None:
    assert names(cd.load("stewart_platform")) == {"ball_1_x", "ball_1_y", "ball_1_z"}
