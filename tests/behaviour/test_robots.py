"""Real robots: open chains balance their weight, closed ones mark what they leave open."""

from __future__ import annotations

import importlib.metadata
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest

import cardan_dyn as cd

pytestmark = pytest.mark.usefixtures("loaded_once")

G = 9.81
GRAVITY = (0.0, 0.0, -G)


def robot(name: str) -> Path:
    files = importlib.metadata.files("example-robot-data")
    assert files is not None
    (found,) = (file for file in files if file.name == name)
    return Path(str(found.locate()))


@pytest.mark.parametrize(
    "name", ["panda.urdf", "ur5_robot.urdf", "talos_full_v2.urdf", "talos_reduced.urdf"]
)
def test_open_chains_carry_what_hangs_on_them(name: str) -> None:
    """Every joint carries the weight of its subtree at the subtree's centre of mass."""
    mechanism = cd.load(robot(name), strict=False)
    names = mechanism.joint_names
    following = {item.successor: item for item in mechanism.description.couplings}
    drives = [joint for joint in names if joint not in following]
    rng = np.random.default_rng(5)
    positions = rng.uniform(-0.5, 0.5, (3, len(drives)))
    turn = cd.Scene(mechanism, drive=drives, gravity=GRAVITY).sweep(positions)
    assert turn.balance_residual < 1e-13
    model, data = mechanism.model, mechanism.model.createData()
    model.gravity.linear = np.array(GRAVITY)
    total = G * sum(inertia.mass for inertia in list(model.inertias)[1:])
    for sample, q in enumerate(turn.motion.q):
        pin.centerOfMass(model, data, q)
        rnea = pin.rnea(model, data, q, np.zeros(model.nv), np.zeros(model.nv))
        for name_ in names:
            index = mechanism.joints[name_].id
            wrench = turn.wrench(name_, "world")
            weight = np.array([0.0, 0.0, G * data.mass[index]])
            frame = data.oMi[index]
            # A body of no mass has no centre.
            arm = frame.rotation @ data.com[index] if data.mass[index] > 0.0 else np.zeros(3)
            np.testing.assert_allclose(wrench.force[sample], weight, atol=1e-10 * total)
            moment = np.cross(arm, weight)
            np.testing.assert_allclose(wrench.moment[sample], moment, atol=1e-10 * total)
        for column, drive in enumerate(drives):
            # A joint that mimics others passes on what they would need, times its multiplier.
            expected = rnea[model.idx_vs[mechanism.joints[drive].id]]
            for joint, item in following.items():
                if item.predecessor == drive:
                    expected += item.ratio * rnea[model.idx_vs[mechanism.joints[joint].id]]
            assert turn.drive_effort[sample, column] == pytest.approx(expected, abs=1e-10 * total)


def test_robots_with_impossible_inertias_say_so() -> None:
    with pytest.raises(cd.ModelError, match=r"load\(..., strict=False\)"):
        cd.load(robot("panda.urdf"))
    mechanism = cd.load(robot("panda.urdf"), strict=False)
    assert any("taken as massless" in remark for remark in mechanism.warnings)
    assert "warning: " in str(cd.describe(mechanism))


def placement(mechanism: cd.Mechanism, link: str, positions: dict[str, float]) -> pin.SE3:
    """Where a link is when joints are at positions, the rest at zero."""
    model = mechanism.model
    q = pin.neutral(model)
    for name, value in positions.items():
        index = mechanism.joints[name].id
        if model.nqs[index] == 2:
            q[model.idx_qs[index] : model.idx_qs[index] + 2] = np.cos(value), np.sin(value)
        else:
            q[model.idx_qs[index]] = value
    data = model.createData()
    pin.forwardKinematics(model, data, q)
    body, frame = mechanism.links[link]
    return data.oMi[body] * frame


def origin(placed: pin.SE3) -> str:
    words = [
        " ".join(repr(float(value)) for value in part)
        for part in (placed.translation, pin.rpy.matrixToRpy(placed.rotation))
    ]
    return f'<origin xyz="{words[0]}" rpy="{words[1]}"/>'


def test_talos_stands_on_both_feet() -> None:
    """A floating base on two fixed feet: their sum is the weight, the share is open."""
    text = robot("talos_reduced.urdf").read_text(encoding="utf-8")
    plain = cd.load(text, strict=False)
    bent = {}
    for side in ("left", "right"):
        bent |= {f"leg_{side}_3_joint": -0.4, f"leg_{side}_4_joint": 0.8}
        bent |= {f"leg_{side}_5_joint": -0.4}
    feet = {side: placement(plain, f"leg_{side}_6_link", bent) for side in ("left", "right")}
    loops = "".join(
        f'<loop name="foot_{side}" type="fixed"><predecessor link="ground">{origin(foot)}'
        f'</predecessor><successor link="leg_{side}_6_link"/></loop>'
        for side, foot in feet.items()
    )
    floor = (
        '<link name="ground"/><joint name="floating_base" type="floating"><parent link="ground"/>'
        '<child link="base_link"/></joint>'
    )
    standing = text.replace("</robot>", floor + loops + "</robot>")
    # The description's legs are straight at zero: the feet then are not where the loops are.
    straight = cd.load(standing, strict=False)
    drive = "head_1_joint"
    held = {
        name: bent.get(name, 0.0)
        for name in straight.joint_names
        if name not in (drive, "floating_base", "foot_left", "foot_right")
    }
    zero = dict.fromkeys(held, 0.0)
    first = cd.Scene(
        cd.load(at_rest(standing, bent), strict=False), drive=drive, held=zero, gravity=GRAVITY
    )
    turn = first.sweep(np.array([0.0, 0.4, -0.7]))
    assert turn.balance_residual < 1e-12
    total = G * sum(inertia.mass for inertia in plain.model.inertias)
    left, right = (turn.wrench(f"foot_{side}", "world") for side in ("left", "right"))
    carried = left.force + right.force
    np.testing.assert_allclose(carried, [[0.0, 0.0, total]] * 3, atol=1e-9 * total)
    assert not np.any(left.unique)
    assert not np.any(right.unique)
    # The base hangs on nothing: its six coordinates are free, and their efforts zero.
    assert np.max(np.abs(turn["floating_base"].force)) < 1e-9 * total
    # About any point the moments balance as well.
    moments = left.moment + np.cross(turn.origin("foot_left"), left.force)
    moments = moments + right.moment + np.cross(turn.origin("foot_right"), right.force)
    weight = np.zeros((3, 3))
    for name, record in turn.mechanism.joints.items():
        if not record.parts:
            continue
        inertia = turn.mechanism.model.inertias[record.id]
        centre = turn.origin(name) + turn.rotation(name) @ inertia.lever
        weight += np.cross(centre, [0.0, 0.0, -G * inertia.mass])
    np.testing.assert_allclose(moments, -weight, atol=1e-8 * total)
    # Open chains above the legs are not touched by what the feet leave open.
    assert np.all(turn["arm_left_1_joint"].unique)
    assert not np.all(turn["leg_left_4_joint"].unique)


def at_rest(urdf: str, bent: dict[str, float]) -> str:
    """Build joint positions into the origins, so that zero is the bent posture."""
    root = ElementTree.fromstring(urdf)
    for joint in root.findall("joint"):
        value = bent.get(joint.get("name", ""))
        if value is None:
            continue
        element = joint.find("origin")
        axis = np.array(joint.find("axis").get("xyz").split(), dtype=float)
        xyz = np.array(element.get("xyz").split(), dtype=float)
        rpy = [float(word) for word in element.get("rpy", "0 0 0").split()]
        turned = pin.rpy.rpyToMatrix(*rpy) @ pin.exp3(axis * value)
        placed = origin(pin.SE3(turned, xyz))
        joint.remove(element)
        joint.append(ElementTree.fromstring(placed))
    return ElementTree.tostring(root, encoding="unicode")


def test_baxter_holds_a_bar_in_both_hands() -> None:
    """Fourteen held arm joints and a bar between the hands: six internal forces are open."""
    text = robot("baxter.urdf").read_text(encoding="utf-8")
    plain = cd.load(text, strict=False)
    arms = [name for name in plain.joint_names if name.startswith(("left_", "right_"))]
    hands = {side: placement(plain, f"{side}_gripper_base_link", {}) for side in ("left", "right")}
    across = hands["left"].actInv(hands["right"])
    length = float(np.linalg.norm(across.translation))
    bar = (
        '<link name="bar"><inertial><origin xyz="0 0 0"/><mass value="3"/>'
        f'<inertia ixx="0.01" iyy="{length**2 / 4!r}" izz="{length**2 / 4!r}" ixy="0" ixz="0" '
        'iyz="0"/></inertial></link>'
        '<joint name="left_grip" type="fixed"><parent link="left_gripper_base_link"/>'
        '<child link="bar"/></joint>'
        f'<loop name="right_grip" type="fixed"><predecessor link="bar">{origin(across)}'
        '</predecessor><successor link="right_gripper_base_link"/></loop>'
    )
    mechanism = cd.load(text.replace("</robot>", bar + "</robot>"), strict=False)
    held = {name: 0.0 for name in mechanism.joint_names if name not in ("head_pan", "right_grip")}
    scene = cd.Scene(mechanism, drive="head_pan", held=held, gravity=GRAVITY)
    turn = scene.sweep([0.0, 0.5])
    assert turn.balance_residual < 1e-13
    total = G * sum(inertia.mass for inertia in list(mechanism.model.inertias)[1:])
    first, second = (turn.wrench(f"{side}_s0", "world") for side in ("left", "right"))
    fingers = [name for name in mechanism.joint_names if "gripper" in name]
    carried = sum(
        mechanism.model.inertias[mechanism.joints[name].id].mass for name in (*arms, *fingers)
    )
    np.testing.assert_allclose(
        first.force + second.force, [[0.0, 0.0, G * carried]] * 2, atol=1e-9 * total
    )
    for name in (*arms, "right_grip"):
        assert not np.all(turn[name].unique), name
    assert np.all(turn["head_pan"].unique)
    assert len(turn.holding_effort) == len(held)
    # Least norm: every way of squeezing the bar harder makes the squares of all wrenches more.
    strict = cd.Scene(mechanism, drive="head_pan", held=held, gravity=GRAVITY, strict=True)
    with pytest.raises(cd.IndeterminateError, match="right_grip: force x"):
        strict.sweep([0.0])
