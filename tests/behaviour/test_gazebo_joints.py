"""A URDF whose loop is a joint of SDF in `<gazebo>`, as Gazebo's users close theirs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from testkit.linkages import POSITIONS, RATES, four_bar, loop
from testkit.other_notations import TREE

import cardan_dyn as cd
from cardan_dyn.core.description.second_reading import reread

SCENE = {"drive": "a", "loads": {"d": -3.0}, "gravity": (0.0, -9.81, 0.0)}
PIN = """<gazebo><joint name="c" type="revolute"><parent>coupler</parent><child>rocker</child>
{pose}<axis><xyz{frame}>{axis}</xyz>{more}</axis></joint></gazebo>"""
PLACES = {
    "in the child": "<pose>0 2.5 0 0 0 0</pose>",
    "in the parent": '<pose relative_to="coupler">2 2 0 0 0 0.4</pose>',
    "in the model": '<pose relative_to="__model__">2 2.5 0 0 0 -2</pose>',
    "in a joint": '<pose relative_to="b">2 2 0 0 0 0</pose>',
    "in degrees": '<pose degrees="true">0 2.5 0 0 0 90</pose>',
}


def pinned(pose: str, frame: str = "", axis: str = "0 0 1", more: str = "") -> str:
    return TREE.format(PIN.format(pose=pose, frame=frame, axis=axis, more=more))


def same(found: cd.Sweep, expected: cd.Sweep) -> bool:
    np.testing.assert_allclose(found.drive_effort, expected.drive_effort, rtol=1e-11, atol=1e-10)
    for name in "abcd":
        np.testing.assert_allclose(
            found.wrench(name, "world").force, expected.wrench(name, "world").force, atol=1e-9
        )
    return found.loop_residual < 1e-13


@pytest.mark.parametrize("pose", PLACES.values(), ids=PLACES.keys())
def test_it_is_the_loop_that_it_says(pose: str) -> None:
    mechanism = cd.load(pinned(pose))
    assert "SDF <joint> in <gazebo>" in mechanism.notation
    assert not any("gazebo" in line for line in mechanism.warnings)
    expected = cd.Scene(cd.load(four_bar(loop("continuous"))), **SCENE).sweep(POSITIONS, **RATES)
    assert same(cd.Scene(mechanism, **SCENE).sweep(POSITIONS, **RATES), expected)
    # The proof reads the text by itself.
    (first,), (second,) = mechanism.description.loops, reread(mechanism.description).loops
    assert first is not second
    for name in ("predecessor_origin", "successor_origin", "axis"):
        np.testing.assert_allclose(getattr(first, name), getattr(second, name), atol=1e-15)


def test_the_proof_sees_a_false_place() -> None:
    text = pinned(PLACES["in the child"])
    mechanism = cd.load(text)
    assert reread(mechanism.description).loops[0].successor_origin[1, 3] == 2.5
    axis = pinned(PLACES["in the child"], axis="0 0.6 0.8")
    with pytest.raises(cd.CardanError):
        cd.Scene(cd.load(axis), **SCENE).sweep(POSITIONS)


def test_axes_are_seen_in_the_joints_frame_or_in_one_that_is_named() -> None:
    """A tree that is tilted in the model: rocker and pin lie in other planes than the model's."""
    tilt = Rotation.from_rotvec([0.7, -0.4, 0.3])
    rpy = " ".join(map(repr, tilt.as_euler("xyz").tolist()))
    turn = (
        f'<link name="bed"/><joint name="tilt" type="fixed"><parent link="bed"/>'
        f'<child link="ground"/><origin xyz="1 2 3" rpy="{rpy}"/></joint></robot>'
    )
    expected = cd.Scene(cd.load(four_bar(loop("continuous"))), drive="a").sweep(POSITIONS)

    def tilted(**given: str) -> cd.Mechanism:
        text = pinned("<pose>0 2.5 0 0 0 0</pose>", **given)
        return cd.load(text.replace("</robot>", turn))

    own = tilted()
    assert sum("older versions see it in the model's frame" in x for x in own.warnings) == 1
    in_model = " ".join(map(repr, tilt.apply([0.0, 0.0, 1.0]).tolist()))
    named = tilted(frame=' expressed_in="__model__"', axis=in_model)
    flagged = tilted(axis=in_model, more="<use_parent_model_frame>1</use_parent_model_frame>")
    for mechanism in (own, named, flagged):
        swept = cd.Scene(mechanism, drive="a").sweep(POSITIONS)
        np.testing.assert_allclose(
            swept.motion.position("d"), expected.motion.position("d"), atol=1e-12
        )
        loops = mechanism.description.loops, reread(mechanism.description).loops
        np.testing.assert_allclose(loops[0][0].axis, loops[1][0].axis, atol=1e-15)
    assert not any("older versions" in line for line in (*named.warnings, *flagged.warnings))


def test_a_ball_and_a_joint_to_the_world() -> None:
    ball = (
        '<gazebo><joint name="c" type="ball"><parent>coupler</parent><child>rocker</child>'
        "<pose>0 2.5 0 0 0 0</pose></joint></gazebo>"
    )
    found = cd.Scene(cd.load(TREE.format(ball)), **SCENE).sweep(POSITIONS)
    expected = cd.Scene(cd.load(four_bar(loop("spherical"))), **SCENE).sweep(POSITIONS)
    assert same(found, expected)
    # The rocker's bearing as the loop, and its end as a joint of the tree.
    text = four_bar(loop("continuous"))
    start = text.index('<joint name="d"')
    text = (
        text[:start]
        + """<joint name="c" type="continuous"><parent link="coupler"/>
      <child link="rocker"/><origin xyz="2 2 0"/><axis xyz="0 0 1"/></joint>
      <gazebo><joint name="d" type="revolute"><parent>world</parent><child>rocker</child>
      <pose>0 -2.5 0 0 0 0</pose><axis><xyz>0 0 1</xyz></axis></joint></gazebo></robot>"""
    )
    text = text.replace('<inertial><origin xyz="0 1.25 0"/>', '<inertial><origin xyz="0 -1.25 0"/>')
    other = cd.Scene(cd.load(text), drive="a", gravity=SCENE["gravity"]).sweep(POSITIONS)
    plain = cd.Scene(
        cd.load(four_bar(loop("continuous"))), drive="a", gravity=SCENE["gravity"]
    ).sweep(POSITIONS)
    np.testing.assert_allclose(other.drive_effort, plain.drive_effort, rtol=1e-10, atol=1e-9)


def test_what_fixes_the_root_to_the_world_is_no_loop() -> None:
    base = (
        '<gazebo><joint name="base" type="fixed"><parent>world</parent><child>ground</child>'
        "</joint></gazebo></robot>"
    )
    mechanism = cd.load(pinned(PLACES["in the child"]).replace("</robot>", base))
    assert [item.joint for item in mechanism.loops] == ["c"]


REFUSED = {
    "reference": ('<gazebo reference="rocker"><joint name="c" type="ball"/></gazebo>', "without a"),
    "screw": (PIN.replace("revolute", "screw"), "type 'screw' is not supported"),
    "gearbox": (PIN.replace("revolute", "gearbox"), "couplings are not read here"),
    "link": (PIN.replace("rocker", "roker"), "frame 'roker' does not exist; frames: "),
    "root": (
        '<gazebo><joint name="c" type="revolute"><parent>world</parent><child>ground</child>'
        "<axis><xyz>0 0 1</xyz></axis></joint></gazebo>",
        "its child is the root 'ground'",
    ),
    "word": (PIN.replace("<axis>", "<axsis/><axis>"), "'axsis' is unknown"),
    "same name": (PIN.replace('name="c"', 'name="b"'), "occur twice: b"),
}


@pytest.mark.parametrize(("text", "message"), REFUSED.values(), ids=REFUSED.keys())
def test_what_cannot_be_read_is_refused(text: str, message: str) -> None:
    text = text.format(pose="", frame="", axis="0 0 1", more="") if "{pose}" in text else text
    with pytest.raises(cd.ModelError, match=message):
        cd.load(TREE.format(text))


def test_it_may_repeat_another_notation_and_must_not_contradict_it() -> None:
    both = four_bar(loop("continuous")).replace(
        "</robot>", PIN.format(pose=PLACES["in the child"], frame="", axis="0 0 1", more="")
    )
    mechanism = cd.load(
        both.replace('<gazebo><joint name="c"', '<gazebo><joint name="e"') + "</robot>"
    )
    assert mechanism.notation == (
        "URDF+ <loop>; SDF <joint> in <gazebo> closes the same links and is not used"
    )
    wrong = both.replace("<child>rocker</child>", "<child>crank</child>") + "</robot>"
    with pytest.raises(cd.ModelError, match="close different loops"):
        cd.load(wrong)


@pytest.mark.parametrize("name", ["c", "another"])
def test_a_file_beside_may_repeat_it_under_any_name(name: str, tmp_path: Path) -> None:
    """The proof reads the numbers of the one that is used: the file's point lies elsewhere."""
    path = tmp_path / "bar.urdf"
    path.write_text(pinned(PLACES["in the child"]))
    (tmp_path / "loop_closures.yaml").write_text(
        f"pin_loops: [{{name: {name}, parent: coupler, child: rocker, parent_xyz: [2.1, 2, 0], "
        "child_xyz: [0, 2.5, 0], axis: [0, 0, 1]}]"
    )
    mechanism = cd.load(path)
    assert mechanism.notation == (
        "SDF <joint> in <gazebo>; loop_closures.yaml closes the same links and is not used"
    )
    alone = cd.load(pinned(PLACES["in the child"]))
    found, expected = (cd.Scene(item, **SCENE).sweep(POSITIONS) for item in (mechanism, alone))
    assert same(found, expected) and found.balance_residual < 1e-12


def test_other_things_for_gazebo_are_passed_over_with_a_word() -> None:
    text = pinned(PLACES["in the child"]).replace(
        "</robot>", "<gazebo><plugin/></gazebo><gazebo><static>0</static></gazebo></robot>"
    )
    (line,) = (line for line in cd.load(text).warnings if "gazebo" in line)
    assert "<gazebo> (2 times) is for other programs" in line
