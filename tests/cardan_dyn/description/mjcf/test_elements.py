"""Settings, default classes and placements of MJCF: against Pinocchio's and SciPy's rotations."""

from __future__ import annotations

import math
from xml.etree.ElementTree import fromstring

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from testkit.mjcf import of_body

import cardan_dyn as cd
from cardan_dyn.description.mjcf import elements
from cardan_dyn.description.mjcf.elements import Compiler, DefaultClasses, merged, pose
from cardan_dyn.description.read import read


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (of_body("", head='<compiler coordinate="global"/>'), "coordinate 'global' is not"),
        (of_body("", head='<compiler angle="gon"/>'), "angle is 'gon', expected one of degree"),
        (of_body("", head='<compiler eulerseq="xyw"/>'), "eulerseq 'xyw' is not three letters"),
        (of_body("", head='<default class="a"/>'), "outermost <default> is class 'main'"),
        (of_body("", head="<default><default/></default>"), "needs a class name of its own"),
        (of_body('<joint class="x"/>'), "default class 'x' does not exist; classes: main"),
        (of_body('<body childclass="x"/>'), "default class 'x' does not exist"),
        (of_body('<body quat="0 0 0 0"/>'), "quat: a vector of zeros has no direction"),
        (of_body('<body quat="1 0 0 0" zaxis="1 0 0"/>'), "quat and zaxis both turn it"),
        (of_body('<body xyaxes="1 0 0 2 0 0"/>'), "xyaxes: both axes have the same direction"),
    ],
)
def test_refused(text: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        read(text)


def test_numbers() -> None:
    assert elements.number({"a": "2.5"}, "a", "1", "x") == 2.5
    assert elements.number({}, "a", "1", "x") == 1.0
    with pytest.raises(cd.ModelError, match=r"^x: a: '1 2' is not 1 finite number"):
        elements.number({"a": "1 2"}, "a", "1", "x")


@pytest.mark.parametrize(
    ("stated", "expected"), [({}, []), ({"a": "1"}, [1.0]), ({"a": " 1  2 3 "}, [1.0, 2.0, 3.0])]
)
def test_several_numbers(stated: dict[str, str], expected: list[float]) -> None:
    assert elements.several(stated, "a", 1, 3, "x").tolist() == expected


@pytest.mark.parametrize("value", ["", "1 2 3 4", "1 x", "nan"])
def test_other_than_one_to_three_numbers(value: str) -> None:
    with pytest.raises(cd.ModelError, match=rf"^x: a:? '{value}' is not .* finite number"):
        elements.several({"a": value}, "a", 1, 3, "x")


def test_flags() -> None:
    assert elements.flag({"a": "true"}, "a", "false", "x") is True
    assert elements.flag({"a": "false"}, "a", "true", "x") is False
    assert elements.flag({}, "a", "true", "x") is True
    with pytest.raises(cd.ModelError, match="x: a is '1', expected one of true, false"):
        elements.flag({"a": "1"}, "a", "false", "x")


def compiler(*attributes: str) -> Compiler:
    sections = "".join(f"<compiler {item}/>" for item in attributes)
    return Compiler.of(fromstring(f"<mujoco>{sections}</mujoco>"), "x")


def test_a_file_without_settings_has_those_of_mujoco() -> None:
    assert compiler() == Compiler()
    assert compiler("").angle == math.pi / 180.0
    assert compiler('angle="degree" coordinate="local"') == Compiler()


def test_all_settings() -> None:
    found = compiler(
        'angle="radian" eulerseq="zXy" autolimits="false" inertiafromgeom="true" '
        'inertiagrouprange="1 3" boundmass="0.1" boundinertia="0.2" balanceinertia="true" '
        'settotalmass="7"'
    )
    assert found == Compiler(1.0, "zXy", False, "true", (1.0, 3.0), 0.1, 0.2, True, 7.0)


def test_of_repeated_settings_the_last_counts() -> None:
    found = compiler('angle="radian" boundmass="1"', 'boundmass="2" eulerseq="zyx"')
    assert (found.angle, found.boundmass, found.eulerseq) == (1.0, 2.0, "zyx")


@pytest.mark.parametrize(
    ("attributes", "message"),
    [
        ('coordinate="global"', "coordinate 'global' is not supported; load and save the model"),
        ('angle="grad"', "angle is 'grad', expected one of degree, radian"),
        ('eulerseq="xy"', "eulerseq 'xy' is not three letters of xyzXYZ"),
        ('eulerseq="xyzx"', "eulerseq 'xyzx' is not three letters of xyzXYZ"),
        ('inertiagrouprange="1"', "inertiagrouprange: '1' is not 2 finite"),
        ('inertiafromgeom="yes"', "inertiafromgeom is 'yes', expected one of false, true, auto"),
        ('balanceinertia="1"', "balanceinertia is '1', expected one of true, false"),
        ('settotalmass="none"', "settotalmass: 'none' is not 1 finite"),
    ],
)
def test_settings_that_are_refused(attributes: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=f"^x: compiler: {message}"):
        compiler(attributes)


CLASSES = """<mujoco><default><joint axis="1 0 0" damping="1"/><geom size="1 2 3"/>
<default class="a"><joint axis="0 1 0"/><default class="b"><joint damping="2"/></default></default>
<default class="c"><geom size="4" quat="1 0 0 0"/></default></default>
<default><joint armature="3"/><default class="d"/></default></mujoco>"""


def classes(text: str = CLASSES) -> DefaultClasses:
    return DefaultClasses(fromstring(text), "x")


@pytest.mark.parametrize(
    ("element", "childclass", "expected"),
    [
        ("<joint/>", "main", {"axis": "1 0 0", "damping": "1", "armature": "3"}),
        ("<joint/>", "a", {"axis": "0 1 0", "damping": "1"}),
        ("<joint/>", "b", {"axis": "0 1 0", "damping": "2"}),
        ("<joint/>", "c", {"axis": "1 0 0", "damping": "1"}),
        ("<joint/>", "d", {"axis": "1 0 0", "damping": "1", "armature": "3"}),
        ("<joint class='a'/>", "b", {"axis": "0 1 0", "damping": "1", "class": "a"}),
        ("<joint axis='0 0 1'/>", "b", {"axis": "0 0 1", "damping": "2"}),
        ("<geom/>", "b", {"size": "1 2 3"}),
        ("<geom/>", "c", {"size": "4 2 3", "quat": "1 0 0 0"}),
        ("<geom euler='1 2 3' size='5 6'/>", "c", {"size": "5 6 3", "euler": "1 2 3"}),
        ("<site/>", "b", {}),
    ],
)
def test_defaults_of_nested_classes(
    element: str, childclass: str, expected: dict[str, str]
) -> None:
    """A class has the attributes that its parent had when it was read."""
    assert classes().of(fromstring(element), childclass, "x") == expected


def test_defaults_under_another_tag() -> None:
    """All equalities share the defaults of one element, `equality`."""
    found = classes('<mujoco><default><equality active="false"/></default></mujoco>')
    element = fromstring('<weld body1="a"/>')
    assert found.of(element, "main", "x", "equality") == {"active": "false", "body1": "a"}
    assert found.of(element, "main", "x") == {"body1": "a"}


def test_names_of_classes() -> None:
    assert classes().known("b", "x") == "b"
    with pytest.raises(
        cd.ModelError, match=r"^y: default class 'z' does not exist; classes: a, b, "
    ):
        classes().known("z", "y")
    with pytest.raises(cd.ModelError, match=r"^y: default class 'z' does not exist"):
        classes().of(fromstring("<joint class='z'/>"), "main", "y")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ('<default class="a"/>', "the outermost <default> is class 'main', not 'a'"),
        ("<default><default/></default>", "a class name of its own, not None"),
        ('<default><default class="main"/></default>', "a class name of its own, not 'main'"),
        (
            '<default><default class="a"/><default class="a"/></default>',
            "a class name of its own, not 'a'",
        ),
    ],
)
def test_default_classes_that_are_refused(content: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        classes(f"<mujoco>{content}</mujoco>")


def test_merging_leaves_its_arguments_as_they_are() -> None:
    base, over = {"quat": "1 0 0 0", "size": "1 2"}, {"zaxis": "0 1 0", "size": "3"}
    assert merged(base, over) == {"zaxis": "0 1 0", "size": "3 2"}
    assert base == {"quat": "1 0 0 0", "size": "1 2"}
    assert over == {"zaxis": "0 1 0", "size": "3"}
    assert merged({"size": "1"}, {"size": "3 4"}) == {"size": "3 4"}
    assert merged({}, {"size": "3 4"}) == {"size": "3 4"}


RADIAN = Compiler(angle=1.0)
ENTRIES = st.floats(-3.0, 3.0)
VECTORS = st.tuples(ENTRIES, ENTRIES, ENTRIES).filter(lambda v: math.hypot(*v) > 1e-3)


def words(values: object) -> str:
    return " ".join(repr(float(value)) for value in values)  # type: ignore[attr-defined]


def rotation_of(name: str, values: object, settings: Compiler = RADIAN) -> np.ndarray:
    placement = pose({name: words(values)}, settings, "x")
    np.testing.assert_array_equal(placement[:3, 3], np.zeros(3))
    np.testing.assert_array_equal(placement[3], [0.0, 0.0, 0.0, 1.0])
    return placement[:3, :3]


def test_a_pose_without_an_orientation() -> None:
    placement = pose({"pos": "1 2 3"}, RADIAN, "x")
    np.testing.assert_array_equal(placement[:3, 3], [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(placement[:3, :3], np.eye(3))
    np.testing.assert_array_equal(pose({}, RADIAN, "x"), np.eye(4))


@settings(derandomize=True, max_examples=50)
@given(st.tuples(ENTRIES, ENTRIES, ENTRIES, ENTRIES).filter(lambda v: math.hypot(*v) > 1e-3))
def test_quaternions_of_any_length(quaternion: tuple[float, ...]) -> None:
    """Scalar first, in contrast to Pinocchio's."""
    unit = np.array(quaternion) / math.hypot(*quaternion)
    expected = pin.Quaternion(np.array([*unit[1:], unit[0]])).matrix()
    for scale in (1.0, 1e-40, 1e40):
        found = rotation_of("quat", np.array(quaternion) * scale)
        np.testing.assert_allclose(found, expected, atol=2e-15)


@settings(derandomize=True, max_examples=50)
@given(VECTORS, st.floats(-7.0, 7.0))
def test_an_angle_about_an_axis(axis: tuple[float, ...], angle: float) -> None:
    direction = np.array(axis) / math.hypot(*axis)
    expected = pin.AngleAxis(angle, direction).matrix()
    np.testing.assert_allclose(rotation_of("axisangle", [*axis, angle]), expected, atol=2e-15)
    degrees = rotation_of("axisangle", [*axis, math.degrees(angle)], Compiler())
    np.testing.assert_allclose(degrees, expected, atol=5e-15)


@pytest.mark.parametrize("sequence", ["xyz", "XYZ", "zxz", "ZYX", "yzx", "ZXZ"])
def test_euler_angles_in_every_sequence(sequence: str) -> None:
    """SciPy's letters are the other way round: its capitals turn with the frame."""
    angles = np.array([0.3, -1.2, 2.5])
    expected = Rotation.from_euler(sequence.swapcase(), angles).as_matrix()
    settings = Compiler(angle=1.0, eulerseq=sequence)
    np.testing.assert_allclose(rotation_of("euler", angles, settings), expected, atol=1e-15)
    settings = Compiler(eulerseq=sequence)
    np.testing.assert_allclose(
        rotation_of("euler", np.rad2deg(angles), settings), expected, atol=1e-15
    )


def test_euler_angles_about_axes_of_both_kinds() -> None:
    """x turns first; Y stands still, so its rotation is outermost; z turns with the frame."""
    x, y, z = (
        pin.AngleAxis(angle, axis).matrix()
        for angle, axis in zip((0.3, 0.4, 0.5), np.eye(3), strict=True)
    )
    found = rotation_of("euler", [0.3, 0.4, 0.5], Compiler(angle=1.0, eulerseq="xYz"))
    np.testing.assert_allclose(found, y @ x @ z, atol=1e-15)


@settings(derandomize=True, max_examples=50)
@given(VECTORS)
def test_the_shortest_rotation_to_a_z_axis(axis: tuple[float, ...]) -> None:
    """Its trace is 1 + 2 cos of the angle between the axes, and z goes to the direction."""
    direction = np.array(axis) / math.hypot(*axis)
    turn = rotation_of("zaxis", axis)
    np.testing.assert_allclose(turn[:, 2], direction, atol=2e-10)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=2e-15)
    assert np.trace(turn) == pytest.approx(1.0 + 2.0 * direction[2], abs=2e-10)
    assert np.linalg.det(turn) == pytest.approx(1.0)


def test_opposite_z_axes_are_half_a_turn_about_x() -> None:
    for axis in ([0.0, 0.0, -2.0], [1e-11, 1e-11, -1.0]):
        found = rotation_of("zaxis", axis)
        np.testing.assert_allclose(found, np.diag([1.0, -1.0, -1.0]), atol=2e-11)
    np.testing.assert_array_equal(rotation_of("zaxis", [0.0, 0.0, 3.0]), np.eye(3))


@settings(derandomize=True, max_examples=50)
@given(VECTORS, VECTORS)
def test_two_axes_are_made_normal_to_each_other(x: tuple[float, ...], y: tuple[float, ...]) -> None:
    """Against the QR decomposition, whose columns have no certain signs."""
    a, b = np.array(x) / math.hypot(*x), np.array(y) / math.hypot(*y)
    if np.linalg.norm(np.cross(a, b)) < 1e-3:
        return
    q = np.linalg.qr(np.stack([a, b], axis=1))[0]
    q *= np.sign(np.sum(q * np.stack([a, b], axis=1), axis=0))
    expected = np.stack([*q.T, np.cross(*q.T)], axis=1)
    np.testing.assert_allclose(rotation_of("xyaxes", [*x, *y]), expected, atol=1e-12)


@pytest.mark.parametrize(
    ("attributes", "message"),
    [
        ({"quat": "1 0 0"}, "x: quat: '1 0 0' is not 4 finite"),
        ({"quat": "0 0 0 0"}, "x: quat: a vector of zeros has no direction"),
        ({"axisangle": "0 0 0 1"}, "x: axisangle: a vector of zeros has no direction"),
        ({"zaxis": "0 0 0"}, "x: zaxis: a vector of zeros has no direction"),
        ({"xyaxes": "1 0 0 0 0 0"}, "x: xyaxes: a vector of zeros has no direction"),
        ({"xyaxes": "1 0 0 1 1e-11 0"}, "x: xyaxes: both axes have the same direction"),
        ({"euler": "1 2"}, "x: euler: '1 2' is not 3 finite"),
        ({"quat": "1 0 0 0", "euler": "0 0 0"}, "x: quat and euler both turn it; keep one"),
        ({"pos": "1 2"}, "x: pos: '1 2' is not 3 finite"),
    ],
)
def test_poses_that_are_refused(attributes: dict[str, str], message: str) -> None:
    with pytest.raises(cd.ModelError, match=f"^{message}"):
        pose(attributes, RADIAN, "x")


def test_a_segment_stands_in_the_middle_and_points_to_its_first_end() -> None:
    placement, half = elements.segment({"fromto": "1 2 3 1 6 6"}, "x")
    assert half == pytest.approx(2.5)
    np.testing.assert_array_equal(placement[:3, 3], [1.0, 4.0, 4.5])
    np.testing.assert_allclose(placement[:3, 2], [0.0, -0.8, -0.6], atol=1e-15)
    with pytest.raises(cd.ModelError, match="x: fromto: a vector of zeros has no direction"):
        elements.segment({"fromto": "1 2 3 1 2 3"}, "x")


@pytest.mark.parametrize("size", [1e-200, 1e-100, 1.0, 1e40])
def test_unit_vectors_of_vectors_of_any_length(size: float) -> None:
    """The squares of components below 1e-160 would vanish."""
    found = elements.unit(np.array([0.0, 3.0, -4.0]) * size, "x")
    np.testing.assert_allclose(found, [0.0, 0.6, -0.8], rtol=1e-15)
