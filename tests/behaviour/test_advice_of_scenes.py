"""What a scene's refusal says to drive, hold, drop or give makes a scene that moves."""

from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd

MASS = '<inertial><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01"/></inertial>'
LINKS = '<link name="g"/>' + "".join(f'<link name="{name}">{MASS}</link>' for name in "abd")


def hinge(name: str, parent: str, child: str, xyz: str) -> str:
    return (
        f'<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}"/><axis xyz="0 0 1"/></joint>'
    )


CHAIN = hinge("A", "g", "a", "0 0 0") + hinge("B", "a", "b", "0 .1 0")
ROW = CHAIN + hinge("D", "b", "d", ".3 0 0")
CRANKS = CHAIN + hinge("D", "g", "d", ".3 0 0")
MECHANISMS = {
    "row": ROW,
    "bar": CRANKS + '<loop name="C" type="continuous"><predecessor link="b" xyz=".3 .15 0"/>'
    '<successor link="d" xyz="0 .25 0"/><axis xyz="0 0 1"/></loop>',
    "gears": CRANKS + '<coupling name="t"><predecessor link="a"/><successor link="d"/>'
    '<ratio value="-2"/></coupling>',
}


@pytest.mark.parametrize(
    ("name", "given", "said", "then"),
    [
        (
            "row",
            {"drive": "A"},
            "drive or hold 2 of them, such as B, D$",
            {"drive": ["A", "B", "D"]},
        ),
        (
            "row",
            {"drive": "A"},
            "drive or hold 2 of them, such as B, D$",
            {"drive": "A", "held": {"B": 0.1, "D": 0.2}},
        ),
        (
            "row",
            {"drive": "A", "held": {"B": 0.1}},
            "drive or hold one of: D$",
            {"drive": ["A", "D"], "held": {"B": 0.1}},
        ),
        (
            "bar",
            {"drive": ["A", "D"]},
            "drop a drive or stop holding a joint: one of: A, D$",
            {"drive": "D"},
        ),
        ("bar", {"drive": "A", "held": {"D": 0.0}}, "stop holding D$", {"drive": "A"}),
        (
            "gears",
            {"drive": ["A", "D"]},
            "couples A, D: drive or hold only one of them; .*drive or hold one of: B$",
            {"drive": ["A", "B"]},
        ),
        (
            "row",
            {"drive": ["A", "B", "D"], "gravity": "description"},
            r"give gravity=\(0, 0, -9\.81\)$",
            {"drive": ["A", "B", "D"], "gravity": (0, 0, -9.81)},
        ),
    ],
)
def test_what_a_scene_says_to_do_is_done(
    name: str, given: dict[str, object], said: str, then: dict[str, object]
) -> None:
    mechanism = cd.load(f'<robot name="{name}">{LINKS}{MECHANISMS[name]}</robot>')
    with pytest.raises(cd.CardanError, match=said):
        cd.Scene(mechanism, **given)
    scene = cd.Scene(mechanism, **then)
    turn = scene.sweep(np.full(len(scene.drives), 0.05), speed=1.0)
    assert turn.balance_residual < 1e-13 and turn.loop_residual < 1e-13


def test_what_names_are_said_to_stand_for_is_there() -> None:
    mechanism = cd.load(f'<robot name="row">{LINKS}{ROW}</robot>')
    placed = cd.assemble(mechanism, near={"A": 0.3})
    with pytest.raises(cd.ModelError, match=r"name one of them, or take origin\('B'\) and rot"):
        placed.point("B")
    np.testing.assert_allclose(placed.origin("B"), placed.point("b"), atol=1e-15)
    np.testing.assert_allclose(placed.rotation("B"), placed.orientation("a"), atol=1e-15)
    ball = mechanism.to_urdf().replace('name="A" type="continuous"', 'name="A" type="spherical"')
    with pytest.raises(cd.ModelError, match=r"'A\.x' is a coordinate; name its joint, 'A'"):
        cd.load(ball).joint("A.x")
    assert cd.load(ball).joint("A").coordinates == ("A.x", "A.y", "A.z")


@pytest.mark.parametrize(
    "written", ['forces="mesh" pressure_angle="0.35"', 'forces="none"'], ids=["mesh", "none"]
)
def test_what_is_open_of_gears_is_said_as_told(written: str) -> None:
    text = f'<robot name="gears">{LINKS}{MECHANISMS["gears"]}</robot>'
    report = str(cd.describe(cd.load(text)))
    assert 'write forces="mesh" and pressure_angle in it' in report
    assert 'forces="none" where nothing but moments' in report
    described = cd.describe(cd.load(text.replace('name="t"', f'name="t" {written}')))
    assert described.mobility == 2 and not described.silent
