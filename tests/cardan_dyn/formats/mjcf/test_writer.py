"""What is written as MJCF is read back as the same mechanism; MuJoCo reads it where it is there."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest
from compare import sweep_of
from scenes import draw
from testkit import linkages
from testkit.mjcf import placed
from testkit.sdf import compare

import cardan_dyn as cd
from cardan_dyn.core.description.description import CouplingDescription, LinkDescription
from cardan_dyn.core.description.read import read
from cardan_dyn.core.mechanism.rezero import link_placements, rezeroed
from cardan_dyn.practice.formats.mjcf.writer import to_mjcf
from cardan_dyn.scene.presets import PRESETS
from cardan_dyn.scene.usual_motion import usual_motion

MOST = 300.0
"""Greatest condition in these sweeps, but for a cross without mass, of which it is not known."""


class Text:
    """Stands for a chain of which only the text is read."""

    def __init__(self, text: str) -> None:
        self.text = text


@pytest.mark.slow
@pytest.mark.parametrize("is_closed", [False, True])
@pytest.mark.parametrize("name", cd.bundled_names())
def test_bundled_mechanisms(name: str, is_closed: bool) -> None:
    mechanism, preset = cd.load(name), PRESETS[name]
    motion = usual_motion(mechanism, samples=9).sweep().motion
    at = {joint: motion.position(joint)[3] for joint in mechanism if mechanism[joint].parts}
    if is_closed:
        mechanism = cd.Mechanism(
            rezeroed(mechanism.description, at, mechanism.characteristic_length)
        )
        at = dict.fromkeys(at, 0.0)
    again = cd.load(to_mjcf(mechanism.description))
    expected = ("limits of", "elements=described_elements")
    assert not [line for line in again.warnings if not any(words in line for words in expected)]
    assert again.joint_springs == mechanism.joint_springs
    positions = np.array([[float(at[joint]) for joint in preset.drive]])
    steps = np.linspace(0.0, 0.05, 4)[:, None]
    sweeps = [
        cd.Scene(
            item,
            drive=list(preset.drive),
            held={joint: float(at[joint]) for joint in preset.held_deg},
            loads=dict(preset.loads),
            gravity=(0.3, -0.2, -9.0),
        ).sweep(positions + steps, speed=2.0, acceleration=-1.0)
        for item in (again, mechanism)
    ]
    reference = sweeps[1]
    condition = min(float(reference.condition.max()), MOST)
    assert compare(*sweeps, tolerance=1e-12 * condition, decided=True)


WRITTEN = [0, 1, 3, 6, 8, 10, 11, 13, 17, 18, 19, 20, 21, 24, 32, 33, 34, 36, 38, 41, 48, 51]
"""Random chains in which every body has a mass, and couplings are those of two joints."""


@pytest.mark.slow
@pytest.mark.parametrize("seed", WRITTEN)
def test_random_chains(seed: int) -> None:
    case = draw(seed)
    text = to_mjcf(read(case.chain.text))
    links = {link.name for link in read(text).links}
    # A massless link between two joints is no body, and nothing can act on it.
    loads = {name: load for name, load in case.link_loads.items() if name in links}
    case = replace(case, compliance={}, link_loads=loads)
    found, reference = sweep_of(replace(case, chain=Text(text))), sweep_of(case)
    compare(found, reference, 1e-8, decided=True)


@pytest.mark.parametrize(
    ("seed", "message"), [(2, "moves and has no mass"), (4, "MJCF couples two joints")]
)
def test_random_chains_that_mujoco_does_not_know(seed: int, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        to_mjcf(read(draw(seed).chain.text))


LINK = """<link name="{}"><inertial><origin xyz="0.1 0.2 0.3"/><mass value="{}"/>
<inertia ixx="1" iyy="1.5" izz="2" ixy="0.1"/></inertial></link>"""
JOINT = """<joint name="{0}" type="{0}"><parent link="{1}"/><child link="{2}"/>
<origin xyz="0.3 -0.2 0.5" rpy="0.3 0.4 0.5"/><axis xyz="0.36 0.48 0.8"/><axis2 xyz="0.8 -0.6 0"/>
</joint>"""
KINDS = ("revolute", "prismatic", "cylindrical", "universal", "planar", "spherical", "floating")


def robot(*parts: str) -> str:
    return f'<robot name="r">{"".join(parts)}</robot>'


@pytest.mark.parametrize("kind", [*KINDS, "fixed"])
@pytest.mark.parametrize("base", ["world", "base", "moving"])
def test_joints_of_every_type(kind: str, base: str) -> None:
    """Bodies and freedoms are the same: inertia matrices, up to the order of rates."""
    carrier = "arm" if base == "moving" else base
    parts = [LINK.format("b", 2), JOINT.format(kind, carrier, "b")]
    if base == "moving":
        parts = [
            '<link name="base"/>',
            LINK.format("arm", 3),
            JOINT.format("continuous", "base", "arm"),
            *parts,
        ]
    else:
        parts.insert(0, f'<link name="{base}"/>')
    mechanism = cd.load(robot(*parts))
    again = cd.load(to_mjcf(mechanism.description))
    for link, placement in placed(mechanism, {}).items():
        np.testing.assert_allclose(
            placed(again, {})[link].homogeneous, placement.homogeneous, atol=1e-14
        )
    matrices = []
    for item in (mechanism, again):
        model = item.model
        matrix = pin.crba(model, model.createData(), pin.neutral(model))
        matrix = np.triu(matrix) + np.triu(matrix, 1).T
        matrices.append(np.linalg.eigvalsh(matrix) if matrix.size else np.zeros(0))
    np.testing.assert_allclose(matrices[0], matrices[1], rtol=1e-12)


def test_free_bodies() -> None:
    text = to_mjcf(
        read(
            robot('<link name="base"/>', LINK.format("b", 2), JOINT.format("floating", "base", "b"))
        )
    )
    root = ElementTree.fromstring(text)
    bodies = [body.get("name") for body in root.findall("worldbody/body")]
    assert bodies == ["base", "b"]
    assert root.find("worldbody/body[@name='b']/freejoint") is not None
    # On a body that moves, MuJoCo has no such joint.
    moving = read(
        robot(
            '<link name="base"/>',
            LINK.format("a", 1),
            LINK.format("b", 2),
            JOINT.format("prismatic", "base", "a"),
            JOINT.format("floating", "a", "b"),
        )
    )
    assert [joint.type for joint in read(to_mjcf(moving)).joints] == [
        *("fixed", "prismatic", "prismatic", "prismatic", "prismatic", "spherical"),
    ]


def test_settings() -> None:
    root = ElementTree.fromstring(to_mjcf(read("four_bar")))
    compiler, option = root.find("compiler"), root.find("option")
    assert compiler is not None and compiler.attrib == {"angle": "radian", "autolimits": "true"}
    assert option is None, "nothing is known of gravity"
    assert root.get("model") == "four_bar"


@pytest.mark.parametrize(
    ("kind", "found"),
    [("spherical", ["connect"]), ("fixed", ["weld"]), ("continuous", ["weld"])],
)
def test_loops(kind: str, found: list[str]) -> None:
    text = to_mjcf(read(linkages.four_bar(linkages.loop(kind))))
    root = ElementTree.fromstring(text)
    assert [item.tag for item in root.findall("equality/*")] == found
    half = root.find(".//body[@name='coupler']/body[@name='c_half']/joint[@name='c']")
    assert (half is not None) is (kind == "continuous")
    again = read(text)
    masses = {link.name: link.mass for link in again.links}
    if kind == "continuous":
        assert (masses["rocker"], masses["c_half"]) == (1.5, 1.5)
        assert [(loop.name, loop.type) for loop in again.loops] == [("c_weld", "fixed")]
    else:
        assert masses["rocker"] == 3.0
        assert [(loop.name, loop.type) for loop in again.loops] == [("c", kind)]


def test_loops_that_are_open_at_zero_stay_as_they_are() -> None:
    """Sites hold the loop wherever it is; MuJoCo takes anchors from its initial configuration."""
    text = linkages.four_bar(linkages.loop("spherical"), rocker="2.6")
    sweeps = [
        cd.Scene(cd.load(item), drive="a", loads={"d": -3.0}).sweep([0.3, 0.4], speed=1.0)
        for item in (to_mjcf(read(text)), text)
    ]
    compare(*sweeps, tolerance=1e-10, decided=True)


def test_couplings() -> None:
    """A coupling of links that one joint each moves becomes one of these joints."""
    text = linkages.gears(linkages.coupling("g", "a", "b", -2.5))
    (found,) = read(to_mjcf(read(text))).couplings
    assert found == CouplingDescription("g", "a", "b", -2.5, of_joints=True)
    rack = read(linkages.rack("wheel", "rack"))
    joints = {joint.child: joint.name for joint in rack.joints}
    (stated,), (found,) = rack.couplings, read(to_mjcf(rack)).couplings
    ends = joints[stated.predecessor], joints[stated.successor]
    assert found == CouplingDescription(stated.name, *ends, stated.ratio, of_joints=True)
    mimics = read(
        text.replace("</joint>", '<mimic joint="b" multiplier="3" offset="-0.2"/></joint>', 1)
    )
    (stated,) = (item for item in mimics.couplings if item.of_joints)
    assert stated in read(to_mjcf(mimics)).couplings
    row = robot(
        *('<link name="base"/>', LINK.format("a", 1), LINK.format("b", 2), LINK.format("c", 3)),
        JOINT.format("revolute", "base", "a"),
        JOINT.format("prismatic", "a", "b"),
        JOINT.format("continuous", "base", "c"),
        '<coupling name="g"><predecessor link="b"/><successor link="c"/><ratio value="2"/>'
        "</coupling>",
    )
    with pytest.raises(
        cd.ModelError,
        match=r"coupling 'g': MJCF couples two .* 'b' .* 'c' are prismatic \(prismatic\), rev",
    ):
        to_mjcf(read(row))


def massless(*kinds: str) -> str:
    """Return a chain whose links have no mass, but the last one."""
    parts = ['<link name="l0"/>']
    for count, kind in enumerate(kinds, start=1):
        link = LINK.format(f"l{count}", 2) if count == len(kinds) else f'<link name="l{count}"/>'
        parts += [link, JOINT.format(kind, f"l{count - 1}", f"l{count}")]
    return robot(*parts)


def test_massless_links_between_joints() -> None:
    """They are no bodies: the next one has the joints before and behind them."""
    text = massless("revolute", "prismatic", "universal")
    root = ElementTree.fromstring(to_mjcf(read(text)))
    joints = root.findall("worldbody/body/body[@name='l3']/joint")
    assert [joint.get("name") for joint in joints] == [
        *("revolute", "prismatic", "universal_1", "universal"),
    ]
    sweeps = []
    for item, drives in (
        (text, ["revolute", "prismatic"]),
        (to_mjcf(read(text)), ["revolute", "prismatic", "universal_1", "universal"]),
    ):
        mechanism = cd.load(item)
        if item is text:
            # A universal joint of a tree has two rates; here it is at rest.
            hinges = text.replace('type="universal"', 'type="fixed"')
            mechanism = cd.load(hinges)
        positions = np.array([[0.3, 0.2, 0.0, 0.0][: len(drives)]])
        rates = np.array([[1.0, -2.0, 0.0, 0.0][: len(drives)]])
        scene = cd.Scene(mechanism, drive=drives, gravity=(0.0, 0.0, -9.81))
        sweeps.append(scene.sweep(positions, speed=rates, acceleration=2.0 * rates))
    for name in ("revolute", "prismatic"):
        one, other = (sweep.wrench(name, "world") for sweep in sweeps)
        np.testing.assert_allclose(one.force, other.force, atol=1e-12)
        np.testing.assert_allclose(one.moment, other.moment, atol=1e-12)


APART = """<mujoco model="apart"><worldbody><body name="a" pos="0.1 0.2 0.3" euler="30 40 50">
<joint name="one" axis="1 2 2" pos="0.3 0.1 0.2"/><joint name="two" type="slide" axis="0 3 4"/>
<joint name="three" axis="0 1 0" pos="-0.2 0.4 0.1"/>
<inertial pos="0.1 0 0" mass="2" diaginertia="1 1.2 1.3" quat="1 2 3 4"/>
<body name="b" pos="0 0 1" euler="10 0 20"><joint name="four" type="ball" pos="0.1 0 -0.4"/>
<inertial pos="0 0.1 0" mass="1" diaginertia="1 1.2 1.3"/></body></body></worldbody></mujoco>"""


def test_joints_that_stand_apart_from_their_bodies() -> None:
    """Placements and inertia matrix at a generic configuration, joint by joint."""
    mechanisms = [cd.load(text) for text in (APART, to_mjcf(read(APART)))]
    found = []
    for mechanism in mechanisms:
        model = mechanism.model
        assert list(mechanism) == ["one", "two", "three", "four"]
        q = pin.integrate(model, pin.neutral(model), np.array([0.3, -0.4, 0.5, 0.6, -0.7, 0.8]))
        data = model.createData()
        matrix = np.triu(pin.crba(model, data, q))
        pin.forwardKinematics(model, data, q)
        places = [
            (data.oMi[body] * frame).homogeneous
            for body, frame in (mechanism.links["a"], mechanism.links["b"])
        ]
        found.append((matrix, np.array(places)))
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-13)


BAD = {
    "leaf": (
        robot('<link name="a"/><link name="b"/>', JOINT.format("revolute", "a", "b")),
        "r: link 'b' moves and has no mass, which MuJoCo does not accept; give it one",
    ),
    "fork": (
        robot(
            *('<link name="a"/><link name="b"/>', LINK.format("c", 1), LINK.format("d", 1)),
            JOINT.format("revolute", "a", "b"),
            JOINT.format("continuous", "b", "c"),
            JOINT.format("prismatic", "b", "d"),
        ),
        "link 'b' moves and has no mass",
    ),
    "turn after ball": (massless("spherical", "revolute"), "ball, hinge cannot be its joints"),
    "floating": (massless("floating", "revolute"), "7|cannot be its joints together"),
    "world": (
        robot(
            *('<link name="base"/>', LINK.format("world", 1)),
            JOINT.format("revolute", "base", "world"),
        ),
        "MJCF keeps the name 'world' for the world",
    ),
}


@pytest.mark.parametrize(("text", "message"), BAD.values(), ids=BAD.keys())
def test_what_mujoco_does_not_know(text: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        to_mjcf(read(text))


def test_what_no_notation_has() -> None:
    description = read(
        robot('<link name="a"/>', LINK.format("b", 1), JOINT.format("fixed", "a", "b"))
    )
    mirror = replace(description.joints[0], origin=np.diag([1.0, 1.0, -1.0, 1.0]))
    with pytest.raises(cd.ModelError, match=r"'b': .* is no rotation"):
        to_mjcf(replace(description, joints=(mirror,)))
    link = LinkDescription("b", 0.0, np.zeros(3), np.eye(3))
    with pytest.raises(cd.ModelError, match="link 'b': an inertia without a mass"):
        to_mjcf(replace(description, links=(description.links[0], link)))


def test_generated_names_are_new() -> None:
    text = linkages.four_bar(linkages.loop("continuous")).replace('"ground"', '"c_half"')
    text = text.replace('name="d"', 'name="c_weld"')
    again = read(to_mjcf(read(text)))
    assert {"c_half", "c_half_2"} <= {link.name for link in again.links}
    assert [loop.name for loop in again.loops] == ["c_weld_2"]


@pytest.mark.slow
def test_long_chains() -> None:
    """Deeper than Python's recursion would reach."""
    parts = ['<link name="l0"/>']
    for count in range(1, 1500):
        parts += [
            LINK.format(f"l{count}", 1),
            f'<joint name="j{count}" type="continuous"><parent link="l{count - 1}"/>'
            f'<child link="l{count}"/></joint>',
        ]
    bodies = ElementTree.fromstring(to_mjcf(read(robot(*parts)))).iter("body")
    assert [body.get("name") for body in bodies] == [f"l{count}" for count in range(1500)]


@pytest.mark.parametrize("source", [*cd.bundled_names(), *WRITTEN])
def test_mujoco_places_the_bodies_alike(
    source: str | int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And its equalities hold at zero, where the loops are closed."""
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo reads what is written")
    # Where inertias are very different, it writes a log beside the caller.
    monkeypatch.chdir(tmp_path)
    description = read(source if isinstance(source, str) else draw(source).chain.text)
    model = mujoco.MjModel.from_xml_string(to_mjcf(description))
    data = mujoco.MjData(model)
    for step in (mujoco.mj_kinematics, mujoco.mj_comPos, mujoco.mj_makeConstraint):
        step(model, data)
    for link, placement in link_placements(description).items():
        body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, link)
        # A massless link between joints is no body.
        if body >= 0:
            np.testing.assert_allclose(data.xpos[body], placement[:3, 3], atol=1e-12)
            turn = data.xmat[body].reshape(3, 3)
            np.testing.assert_allclose(turn, placement[:3, :3], atol=1e-12)
    assert data.nefc or not description.loops
    np.testing.assert_allclose(data.efc_pos, 0.0, atol=1e-12)


def test_driven_joints_have_motors() -> None:
    """What the author drives is driven in both notations."""
    parts = [
        '<link name="l0"/>',
        LINK.format("a", 1),
        LINK.format("b", 2),
        JOINT.format("revolute", "l0", "a").replace("<joint ", '<joint independent="true" '),
        JOINT.format("prismatic", "a", "b"),
    ]
    description = read(robot(*parts))
    assert description.independent_joints == ("revolute",)
    again = read(to_mjcf(description), strict=False)
    assert again.independent_joints == ("revolute",)
    assert cd.Scene(cd.Mechanism(again), held={"prismatic": 0.0}).drives == ("revolute",)


def test_limits_of_a_universal_joint_are_those_of_both_hinges() -> None:
    text = """<robot name="wrist"><link name="arm"/><link name="hand"><inertial><mass value="1"/>
      <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <joint name="w" type="universal"><parent link="arm"/><child link="hand"/><axis xyz="1 0 0"/>
      <axis2 xyz="0 1 0"/><limit lower="-0.5" upper="0.4" velocity="1" effort="3"/></joint>
      </robot>"""
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(to_mjcf(read(text)))
    assert model.jnt_limited.tolist() == model.jnt_actfrclimited.tolist() == [1, 1]
    np.testing.assert_allclose(model.jnt_range, [[-0.5, 0.4]] * 2)
    np.testing.assert_allclose(model.jnt_actfrcrange, [[-3.0, 3.0]] * 2)


def test_motors_are_as_weak_as_the_limits_of_effort_say() -> None:
    """MuJoCo lets no actuator exert more on a joint, and what is read back is what was written."""
    text = """<robot name="arm"><link name="base"/><link name="arm"><inertial><mass value="2"/>
      <inertia ixx="1" iyy="3" izz="4"/></inertial></link>
      <joint name="a" type="{kind}" independent="true"><parent link="base"/><child link="arm"/>
      <axis xyz="0 0 1"/><limit {bounds} velocity="inf" effort="3"/></joint></robot>"""
    mujoco = pytest.importorskip("mujoco")
    for kind, bounds, inertia in (
        ("revolute", 'lower="-1" upper="2"', 4.0),
        ("continuous", "", 4.0),
        ("prismatic", 'lower="-1" upper="2"', 2.0),
    ):
        description = read(text.format(kind=kind, bounds=bounds))
        written = to_mjcf(description)
        assert read(written).joints[-1].limits == description.joints[0].limits
        model = mujoco.MjModel.from_xml_string(written)
        model.opt.gravity[:] = 0.0
        data = mujoco.MjData(model)
        for asked, exerted in ((2.0, 2.0), (5.0, 3.0), (-5.0, -3.0)):
            data.ctrl[:] = asked
            mujoco.mj_forward(model, data)
            np.testing.assert_allclose(inertia * data.qacc, exerted, rtol=1e-14)
