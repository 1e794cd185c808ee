"""Loops that are added in Python are those that a file would have stated."""

from __future__ import annotations

import copy
import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio
import pytest

import cardan_dyn as cd

# The bar is drawn in a line, beside which it has two assemblies: scenes tell of both.
pytestmark = [
    pytest.mark.filterwarnings("ignore:.*two assemblies lie beside it"),
    pytest.mark.usefixtures("loaded_once"),
]

LINKS = """<robot name="bar"><link name="base"/>
<link name="crank"><inertial><origin xyz="0.05 0 0"/><mass value="0.4"/>
  <inertia ixx="1e-4" iyy="4e-4" izz="4e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="coupler"><inertial><origin xyz="0.15 0 0"/><mass value="0.9"/>
  <inertia ixx="1e-4" iyy="7e-3" izz="7e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="rocker"><inertial><origin xyz="0.12 0 0"/><mass value="0.8"/>
  <inertia ixx="1e-4" iyy="4e-3" izz="4e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="A" type="continuous"><parent link="base"/><child link="crank"/>
  <axis xyz="0 0 1"/></joint>
<joint name="B" type="continuous"><parent link="crank"/><child link="coupler"/>
  <origin xyz="0.1 0 0"/><axis xyz="0 0 1"/></joint>
<joint name="C" type="continuous"><parent link="coupler"/><child link="rocker"/>
  <origin xyz="0.3 0 0"/><axis xyz="0 0 1"/></joint>{}</robot>"""
LOOP = """<loop name="D" type="{}"><predecessor link="base"><origin xyz="0.3 0 0"/></predecessor>
<successor link="rocker"><origin xyz="0.25 0 0"/></successor>{}</loop>"""
AXES = {
    "revolute": {"axis": (0.0, 0.0, 1.0)},
    "continuous": {"axis": (0.0, 0.0, 2.0)},
    "cylindrical": {"axis": (0.0, 0.0, 1.0)},
    "spherical": {},
    "universal": {"axis": (0.0, 0.0, 1.0), "axis_2": (1.0, 0.0, 0.0)},
}
PLACES = {"at": (0.3, 0.0, 0.0), "at_b": (0.25, 0.0, 0.0)}


def tree() -> cd.Mechanism:
    return cd.load(LINKS.format(""))


def closed(kind: str = "revolute") -> cd.Mechanism:
    return cd.close(tree(), "base", "rocker", kind, **PLACES, **AXES[kind], name="D")


def turn(mechanism: cd.Mechanism) -> cd.Sweep:
    scene = cd.Scene(mechanism, drive="A", gravity=(0.0, -9.81, 0.0))
    return scene.sweep(np.linspace(0.0, 6.0, 13), speed=7.0)


@pytest.mark.parametrize("kind", AXES)
def test_a_loop_of_any_type_is_that_of_a_file(kind: str) -> None:
    tags = {"axis": "axis", "axis_2": "axis2"}
    axes = "".join(
        f'<{tags[name]} xyz="{" ".join(map(str, axis))}"/>' for name, axis in AXES[kind].items()
    )
    written, given = cd.load(LINKS.format(LOOP.format(kind, axes))), closed(kind)
    assert given.description == written.description
    assert given.joint("D").type == kind
    one, other = turn(written), turn(given)
    np.testing.assert_array_equal(one.drive_effort, other.drive_effort)
    np.testing.assert_array_equal(one["D"].force, other["D"].force)


def test_the_given_mechanism_stays_as_it_is() -> None:
    before = tree()
    cd.close(before, "base", "rocker", "spherical", **PLACES)
    assert before.loops == ()
    assert before.description.loops == ()
    assert cd.describe(before).notation == "no loops"
    assert cd.describe(closed()).notation == "cd.close"
    more = cd.close(closed("spherical"), "base", "coupler", "planar", at=(0, 0, 0), axis=(0, 0, 1))
    assert cd.describe(more).notation == "cd.close"
    written = cd.load(LINKS.format(LOOP.format("spherical", "")))
    more = cd.close(written, "base", "coupler", "planar", at=(0, 0, 0), axis=(0, 0, 1))
    assert cd.describe(more).notation == "URDF+ <loop>, cd.close"
    assert cd.describe(before).mobility == 3


def test_one_place_says_where_the_other_is_at_zero() -> None:
    """A point of the coupler where the crank's end is at zero: 0.2 m along it."""
    first = cd.close(tree(), "base", "coupler", "revolute", at=(0.3, 0, 0), axis=(0, 0, 1))
    second = cd.close(tree(), "base", "coupler", "revolute", at_b=(0.2, 0, 0), axis=(0, 0, 1))
    for mechanism in (first, second):
        (loop,) = mechanism.description.loops
        np.testing.assert_allclose(loop.predecessor_origin[:3, 3], [0.3, 0, 0], atol=1e-15)
        np.testing.assert_allclose(loop.successor_origin[:3, 3], [0.2, 0, 0], atol=1e-15)
        assert not any("open" in text for text in mechanism.warnings)
    assert loop.name == "loop_1"


def test_a_point_has_the_axes_of_the_other_end_at_zero() -> None:
    turned = LINKS.replace('<origin xyz="0.3 0 0"/>', '<origin xyz="0.3 0 0" rpy="0 0 0.7"/>')
    placed = pinocchio.SE3(pinocchio.rpy.rpyToMatrix(0.1, 0.4, 0.0), np.array([0.3, 0.0, 0.0]))
    mechanism = cd.close(
        cd.load(turned.format("")), "base", "rocker", "spherical", at=placed, at_b=(0.25, 0, 0)
    )
    (loop,) = mechanism.description.loops
    np.testing.assert_allclose(loop.predecessor_origin, placed.homogeneous, atol=1e-15)
    rocker = pinocchio.rpy.rpyToMatrix(0.0, 0.0, 0.7)
    np.testing.assert_allclose(
        rocker @ loop.successor_origin[:3, :3], placed.rotation, rtol=0, atol=1e-15
    )


def test_places_count_from_a_turned_frame_and_placements_keep_their_axes() -> None:
    """A weld on the rocker, shifted and turned: what is given there is turned with it."""
    weld = """<link name="tip"/><joint name="weld" type="fixed"><parent link="rocker"/>
    <child link="tip"/><origin xyz="0.2 0.01 0" rpy="0.3 0.5 0"/></joint>"""
    turned = pinocchio.rpy.rpyToMatrix(0.3, 0.5, 0.0)
    there = turned.T @ np.array([0.05, -0.01, 0.0])
    axes = pinocchio.rpy.rpyToMatrix(0.0, 0.0, 0.7)
    at_b = pinocchio.SE3(turned.T @ axes, there)
    for end in ("weld", "tip"):
        mechanism = cd.close(
            cd.load(LINKS.format(weld)), "base", end, "revolute",
            at=(0.3, 0, 0), at_b=at_b, axis=(0, 0, 1), name="D",
        )  # fmt: skip
        np.testing.assert_allclose(turn(mechanism).drive_effort, turn(closed()).drive_effort)
    (loop,) = cd.close(
        cd.load(LINKS.format(weld)), "base", "weld", "spherical", at=(0.3, 0, 0), at_b=at_b
    ).description.loops
    np.testing.assert_allclose(loop.successor_origin[:3, 3], [0.25, 0, 0], rtol=0, atol=1e-15)
    np.testing.assert_allclose(loop.successor_origin[:3, :3], axes, rtol=0, atol=1e-15)


@pytest.mark.parametrize("how", [copy.copy, copy.deepcopy, lambda m: pickle.loads(pickle.dumps(m))])
def test_copies_have_the_loop(how: object) -> None:
    mechanism = closed()
    again = how(mechanism)  # type: ignore[operator]
    assert again.description == mechanism.description
    np.testing.assert_array_equal(turn(again).drive_effort, turn(mechanism).drive_effort)


@pytest.mark.parametrize("suffix", ["urdf", "xml"])
def test_a_written_file_has_the_loop(tmp_path: Path, suffix: str) -> None:
    mechanism = cd.close(tree(), "base", "rocker", "spherical", **PLACES, name="D")
    path = cd.write(mechanism, tmp_path / f"bar.{suffix}")
    again = cd.load(path)
    assert [loop.joint for loop in again.loops] == ["D"]
    # Its zero is the closed configuration nearest to the old one.
    start = cd.assemble(mechanism).positions["A"]
    given = cd.Scene(mechanism, drive="A", gravity=(0.0, -9.81, 0.0)).sweep(start + 0.4)
    read = cd.Scene(again, drive="A", gravity=(0.0, -9.81, 0.0)).sweep(0.4)
    np.testing.assert_allclose(read.drive_effort, given.drive_effort, rtol=1e-10)


def test_the_proof_reads_the_loop_from_its_own_text() -> None:
    """A number that the solution has otherwise than the text leaves loops open in the proof."""
    description = closed().description
    (loop,) = description.loops
    wrong = loop.successor_origin.copy()
    wrong[0, 3] += 1e-3
    moved = replace(description, loops=(replace(loop, successor_origin=wrong),))
    (read,) = cd.Mechanism(moved).second_reading.loops
    assert read == loop
    with pytest.raises(cd.AccuracyError, match=r"loop residual is 3\.3e-03"):
        turn(cd.Mechanism(moved))


def test_several_loops_and_a_mechanism_that_was_closed_already() -> None:
    """Two rods of a parallelogram's third link, of which one is superfluous."""
    text = """<robot name="three"><link name="base"/>{}{}</robot>"""
    links = "".join(f'<link name="r{k}"/>' for k in range(3)) + '<link name="plate"/>'
    joints = "".join(
        f'<joint name="j{k}" type="continuous"><parent link="base"/><child link="r{k}"/>'
        f'<origin xyz="{k} 0 0"/><axis xyz="0 0 1"/></joint>'
        for k in range(3)
    )
    joints += (
        '<joint name="p" type="continuous"><parent link="r0"/><child link="plate"/>'
        '<origin xyz="0 1 0"/><axis xyz="0 0 1"/></joint>'
    )
    mechanism = cd.load(text.format(links, joints))
    for k in (1, 2):
        mechanism = cd.close(mechanism, f"r{k}", "plate", "revolute", at=(0, 1, 0), axis=(0, 0, 1))
    assert [loop.joint for loop in mechanism.loops] == ["loop_1", "loop_2"]
    assert cd.describe(mechanism).mobility == 1
    assert [loop.name for loop in mechanism.second_reading.loops] == ["loop_1", "loop_2"]
    swept = cd.Scene(mechanism, drive="j0", gravity=(0.0, 0.0, 0.0)).sweep([0.2, 0.7])
    np.testing.assert_allclose(swept.motion.position("j2"), [0.2, 0.7], rtol=0, atol=1e-12)


def test_digits_of_a_file_are_made_exact_with_the_loop() -> None:
    """An axis is off by four millionths: with the loop, not before, it is locked."""
    text = LINKS.format("")
    for place, turned, axis in (("0.1", "1.5708", "0 1 0"), ("0.3", "-1.5708", "0 0 1")):
        text = text.replace(
            f'xyz="{place} 0 0"/><axis xyz="0 0 1"/>',
            f'xyz="{place} 0 0" rpy="{turned} 0 0"/><axis xyz="{axis}"/>',
        )
    assert text.count("1.5708") == 2
    before = cd.load(text)
    assert not any("made exact" in item for item in before.warnings)
    mechanism = cd.close(before, "base", "rocker", "revolute", at=(0.3, 0.2, 0), axis=(0, 0, 1))
    assert sum("made exact" in item for item in mechanism.warnings) == 1
    assert cd.describe(mechanism).mobility == 1
    again = cd.close(mechanism, "base", "coupler", "planar", at=(0.1, 0, 0), axis=(0, 0, 1))
    assert sum("made exact" in item for item in again.warnings) == 1
    assert cd.describe(again).mobility == 1


def test_a_model_of_pinocchio_is_closed() -> None:
    model = pinocchio.buildModelFromXML(LINKS.format(""))
    mechanism = cd.close(
        cd.from_pinocchio(model), "base", "rocker", "revolute", **PLACES, axis=(0, 0, 1), name="D"
    )
    sweep = turn(mechanism)
    assert np.max(sweep.loop_residual) < 1e-12
    np.testing.assert_allclose(sweep.drive_effort, turn(closed()).drive_effort, rtol=1e-10)


def test_sites_of_mjcf_are_places() -> None:
    pytest.importorskip("mujoco")
    text = """<mujoco><compiler angle="radian"/><worldbody><site name="ground" pos="0.3 0 0"/>
    <body name="crank"><joint name="A" axis="0 0 1"/>
     <inertial pos="0.05 0 0" mass="0.4" diaginertia="1e-4 4e-4 4e-4"/>
     <body name="coupler" pos="0.1 0 0"><joint name="B" axis="0 0 1"/>
      <inertial pos="0.15 0 0" mass="0.9" diaginertia="1e-4 7e-3 7e-3"/>
      <body name="rocker" pos="0.3 0 0"><joint name="C" axis="0 0 1"/>
       <site name="tip" pos="0.25 0 0"/>
       <inertial pos="0.12 0 0" mass="0.8" diaginertia="1e-4 4e-3 4e-3"/>
      </body></body></body></worldbody></mujoco>"""
    mechanism = cd.close(cd.load(text), "ground", "tip", "revolute", axis=(0, 0, 1), name="D")
    sweep = turn(mechanism)
    assert np.max(sweep.loop_residual) < 1e-12
    np.testing.assert_allclose(sweep.drive_effort, turn(closed()).drive_effort, rtol=1e-9)


def test_a_response_of_a_file_holds_for_the_added_loop(tmp_path: Path) -> None:
    loop = LOOP.format("revolute", '<axis xyz="0 0 1"/>')
    written, given = cd.load(LINKS.format(loop)), closed()
    path = tmp_path / "response.nc"
    cd.Scene(written, drive="A").response(interval=(0.0, 1.0)).save(path)
    scene = cd.Scene(given, drive="A")
    effort = scene.load_response(path).sweep(0.4, speed=7.0).drive_effort
    np.testing.assert_allclose(effort, scene.sweep(0.4, speed=7.0).drive_effort, rtol=1e-10)


def test_what_nothing_moves_any_more_says_so() -> None:
    mechanism = cd.close(tree(), "base", "rocker", "fixed", at=(0.3, 0, 0), name="weld")
    told = "with 'weld' none of the 3 coordinates that it couples moves any more"
    assert any(told in one for one in mechanism.warnings)
    assert cd.describe(mechanism).mobility == 0


def test_what_locks_a_part_says_so() -> None:
    """The crank stands still, the other joints move."""
    mechanism = cd.close(tree(), "base", "crank", "fixed", at=(0, 0, 0), name="brake")
    assert any("with 'brake' none of the 1 coordinates" in one for one in mechanism.warnings)
    assert cd.describe(mechanism).mobility == 2


@pytest.mark.parametrize(
    ("given", "error", "words"),
    [
        ({"type": "sphericl"}, cd.ModelError, "did you mean 'spherical'"),
        ({"link_b": "rockr"}, cd.ModelError, "did you mean 'rocker'"),
        ({"link_b": "base"}, cd.ModelError, "connects 'base' and 'base'"),
        ({"at": None}, cd.ArgumentError, "Give at="),
        ({"name": "A"}, cd.ModelError, "occur twice: A"),
        ({"type": "revolute"}, cd.ArgumentError, "axis is missing"),
        ({"axis": (0, 0, 1)}, cd.ArgumentError, "axis is too much: a spherical joint has no axis"),
        ({"axis_2": (0, 0, 1)}, cd.ArgumentError, "axis_2 is too much"),
        (
            {"type": "universal", "axis": (0, 0, 1), "axis_2": (0, 0, 1)},
            cd.ModelError,
            "at right angles",
        ),
        ({"type": "revolute", "axis": (0, 0, 0)}, cd.ModelError, "has no direction"),
        ({"at": (np.nan, 0, 0)}, cd.ArgumentError, "close: at"),
        ({"at": np.diag([1.0, 1.0, -1.0, 1.0])}, cd.ArgumentError, "is no placement"),
        ({"mechanism": "four_bar"}, cd.ArgumentError, "needs a mechanism from load"),
        ({"closure_tolerance": -1.0}, cd.ArgumentError, "closure_tolerance"),
        (
            {"at": (3, 0, 0), "at_b": (0.25, 0, 0)},
            cd.AssemblyError,
            r"is \(-2.35, 0, 0\) m in world axes, 2.35 m in all\. bar",
        ),
        (
            {
                **{"type": "cylindrical", "axis": (0, 0, 1)},
                "at_b": pinocchio.SE3(pinocchio.rpy.rpyToMatrix(0.2, 0.0, 0.9), np.zeros(3)),
            },
            cd.AssemblyError,
            r"the axes of its ends are 0\.2 rad apart",
        ),
    ],
)
def test_what_cannot_be_closed_is_refused(
    given: dict[str, object], error: type[Exception], words: str
) -> None:
    usual = {"mechanism": tree(), "link_a": "base", "link_b": "rocker", "type": "spherical"}
    with pytest.raises(error, match=words):
        cd.close(**{**usual, "at": (0.3, 0.0, 0.0), **given})  # type: ignore[arg-type]
