"""Bases: valid descriptions in every notation, before anything is broken."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from random import Random
from xml.etree import ElementTree

URDF = Path(__file__).parents[2] / "urdf"

LINK = """<link name="{name}"><inertial><origin xyz="{com}"/><mass value="{mass}"/>
<inertia ixx="0.02" iyy="0.03" izz="0.025" ixy="0" ixz="0" iyz="0"/></inertial></link>"""

JOINT = """<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/><limit effort="9" velocity="9"/></joint>"""

BUNDLED: dict[str, tuple[tuple[str, ...], dict[str, float]]] = {
    "universal_joint": (("bearing_in",), {"joint_angle": 0.4}),
    "double_shaft_w": (("bearing_in",), {"joint_angle_1": 0.3, "joint_angle_2": 0.3}),
    "double_shaft_z": (("bearing_in",), {"joint_angle_1": 0.3, "joint_angle_2": 0.3}),
    "ring_joint": (("bearing_in",), {"joint_angle": 0.4}),
    "thoma_rig": (("bearing_in",), {"joint_angle": 0.4}),
    "four_bar": (("crank_bearing",), {}),
    "slider_crank": (("crank_bearing",), {}),
    "needle_drive": (("main_shaft",), {}),
    "stewart_platform": (tuple(f"leg_{index}" for index in range(1, 7)), {}),
}
SLOW = ("stewart_platform", "double_shaft_w", "double_shaft_z", "needle_drive")


@dataclass(frozen=True)
class Base:
    """A valid description.

    Attributes:
        text: the main text.
        drives, held: a scene that it allows.
        name: of the main file; None where it can be handed over as text.
        beside: other files by name.
    """

    text: str
    drives: tuple[str, ...] = ()
    held: Mapping[str, float] = field(default_factory=dict)
    name: str | None = None
    beside: Mapping[str, str] = field(default_factory=dict)


@cache
def _bundled_text(name: str) -> str:
    """Return a bundled description without what only a viewer reads, which takes most time."""
    root = ElementTree.fromstring((URDF / f"{name}.urdf").read_text(encoding="utf-8"))
    for link in root.findall("link"):
        for visual in link.findall("visual")[1:]:
            link.remove(visual)
    return ElementTree.tostring(root, encoding="unicode")


def bundled(rng: Random) -> Base:
    """Return a bundled description, seldom a slow one."""
    quick = [name for name in BUNDLED if name not in SLOW]
    name = rng.choice(quick if rng.random() < 0.93 else list(BUNDLED))
    drives, held = BUNDLED[name]
    return Base(_bundled_text(name), drives, held)


def _loop(kind: str, predecessor: str, successor: str) -> str:
    origins = {"coupler": "2 2 0", "rocker": "0 2.5 0", "tip": "0 0 0", "ground": "2 0 0"}
    return (
        f'<loop name="c" type="{kind}"><predecessor link="{predecessor}">'
        f'<origin xyz="{origins[predecessor]}"/></predecessor><successor link="{successor}">'
        f'<origin xyz="{origins[successor]}"/></successor><axis xyz="0 0 1"/>'
        + '<axis2 xyz="1 0 0"/>' * (kind == "universal")
        + "</loop>"
    )


def _tree(rng: Random, ends: str = "") -> str:
    """Return a four-bar without its closing joint: crank, coupler and rocker on the ground."""
    masses = [rng.choice(["1", "2.5", "3e-1", "10"]) for _ in range(3)]
    turning = {"axis": "0 0 1", "rpy": "0 0 0", "kind": rng.choice(["continuous", "revolute"])}
    ground = LINK.format(name="ground", com="0 0 0", mass="50")
    return (
        '<robot name="four_bar">'
        + rng.choice(['<link name="ground"/>', ground])
        + LINK.format(name="crank", com="0 0.25 0", mass=masses[0])
        + LINK.format(name="coupler", com="1 1 0.1", mass=masses[1])
        + LINK.format(name="rocker", com="0 1.25 0", mass=masses[2])
        + JOINT.format(name="a", parent="ground", child="crank", xyz="0 0 0", **turning)
        + JOINT.format(name="b", parent="crank", child="coupler", xyz="0 0.5 0", **turning)
        + JOINT.format(name="d", parent="ground", child="rocker", xyz="2 0 0", **turning)
        + ends
    )


def _tips() -> str:
    """Return links at the ends of coupler and rocker, as frames for a closure."""
    still = {"rpy": "0 0 0", "axis": "1 0 0", "kind": "fixed"}
    return (
        LINK.format(name="tip", com="0 0 0.1", mass="0.25")
        + '<link name="end"/>'
        + JOINT.format(name="tip_joint", parent="coupler", child="tip", xyz="2 2 0", **still)
        + JOINT.format(name="end_joint", parent="rocker", child="end", xyz="0 2.5 0", **still)
    )


def four_bar(rng: Random) -> Base:
    """Return a four-bar, closed by a loop of any type, some with weights on fixed joints."""
    kind = rng.choice(
        (
            "continuous",
            "continuous",
            "revolute",
            "spherical",
            "universal",
            "cylindrical",
            "fixed",
            "planar",
            "prismatic",
        )
    )
    tips = rng.random() < 0.4
    sides = ["tip" if tips else "coupler", "rocker"]
    if kind != "universal" and rng.random() < 0.5:
        sides.reverse()
    text = _tree(rng, _tips() if tips else "") + _loop(kind, *sides) + "</robot>"
    return Base(text, ("a",))


def hung(rng: Random) -> Base:
    """Return a four-bar whose rocker hangs on the ground by the loop."""
    tree = _tree(rng)
    tree = tree[: tree.index('<joint name="d"')] + JOINT.format(
        name="d",
        parent="coupler",
        child="rocker",
        kind="continuous",
        xyz="2 2 0",
        rpy="0 0 0",
        axis="0 0 1",
    )
    ends = ['<{} link="rocker"><origin xyz="0 -2.5 0"/></{}>', '<{} link="ground">{}</{}>']
    sides = ["predecessor", "successor"]
    rng.shuffle(sides)
    at_rocker = ends[0].format(sides[0], sides[0])
    at_ground = ends[1].format(sides[1], '<origin xyz="2 0 0"/>', sides[1])
    kind = rng.choice(["continuous", "continuous", "spherical", "cylindrical"])
    return Base(
        f'{tree}<loop name="c" type="{kind}">{at_rocker}{at_ground}<axis xyz="0 0 1"/></loop>'
        "</robot>",
        ("a",),
    )


def arm(rng: Random) -> Base:
    """Return an open chain or a bush of joints of all types."""
    count = rng.randint(1, 5)
    parts = ['<robot name="arm"><link name="link_0"/>']
    drives = []
    for index in range(1, count + 1):
        kind = rng.choice(
            ["revolute", "continuous", "prismatic", "fixed", "continuous"]
            + ["planar", "floating"] * (rng.random() < 0.2)
        )
        parts += [
            LINK.format(name=f"link_{index}", com="0.1 0.2 0", mass=f"{index}.5"),
            JOINT.format(
                name=f"joint_{index}",
                kind=kind,
                parent=f"link_{rng.randrange(index) if rng.random() < 0.3 else index - 1}",
                child=f"link_{index}",
                xyz="0.3 0 0.1",
                rpy=rng.choice(["0 0 0", "0.1 0.2 0.3", "1.5707963267948966 0 0"]),
                axis=rng.choice(["0 0 1", "0 1 0", "1 0 0", "0 -1 0", "1 1 0"]),
            ),
        ]
        if kind in ("revolute", "continuous", "prismatic"):
            drives.append(f"joint_{index}")
    return Base("".join([*parts, "</robot>"]), tuple(drives))


def geared(rng: Random) -> Base:
    """Return two shafts, coupled by a gear."""
    turning = {"kind": "continuous", "parent": "house", "axis": "0 0 1", "rpy": "0 0 0"}
    text = (
        '<robot name="gear"><link name="house"/>'
        + LINK.format(name="one", com="0.1 0 0", mass="1")
        + LINK.format(name="two", com="0 0.1 0", mass="2")
        + JOINT.format(name="first", child="one", xyz="0 0 0", **turning)
        + JOINT.format(name="second", child="two", xyz="1 0 0", **turning)
        + '<coupling name="teeth"><predecessor link="one"/><successor link="two"/>'
        f'<ratio value="{rng.choice(["-2", "0.5", "1"])}"/></coupling></robot>'
    )
    if rng.random() < 0.5:
        mimic = f'<mimic joint="first" multiplier="-2" offset="{rng.choice(["0", "0.7", "-9"])}"/>'
        text = text[: text.index("<coupling")] + "</robot>"
        text = text.replace('<child link="two"/>', f'<child link="two"/>{mimic}')
    return Base(text, ("first",))


def isaac(rng: Random) -> Base:
    """Return a four-bar with NVIDIA Isaac's `<loop_joint>`."""
    kind = rng.choice(["continuous", "revolute", "spherical", "fixed"])
    text = (
        f'{_tree(rng)}<loop_joint name="c" type="{kind}">'
        '<link1 link="coupler" rpy="0 0 0" xyz="2 2 0"/>'
        '<link2 link="rocker" rpy="0 0 0" xyz="0 2.5 0"/><axis xyz="0 0 1"/></loop_joint></robot>'
    )
    if rng.random() < 0.2:
        text = text.replace("</robot>", _loop(kind, "coupler", "rocker") + "</robot>")
    return Base(text, ("a",))


def constraint(rng: Random) -> Base:
    """Return a four-bar with the `<constraint>` that is proposed for ROS."""
    kind = rng.choice(["revolute", "revolute_joint", "spherical", "link", "universal"])
    second = '<child_axis xyz="0 1 0"/>' if kind == "universal" else ""
    text = (
        f'{_tree(rng)}<constraint name="c" type="{kind}"><parent link="coupler"/>'
        '<parent_origin xyz="2 2 0" rpy="0 0 0"/><parent_axis xyz="0 0 1"/><child link="rocker"/>'
        f'<child_origin xyz="0 2.5 0"/>{second}</constraint></robot>'
    )
    return Base(text, ("a",))


def loop_closures(rng: Random) -> Base:
    """Return a four-bar with `loop_closures.yaml` beside it, in one of its formats."""
    kind = rng.choice(["closures", "pin_loops", "ball_loops"])
    if kind == "closures":
        yaml = (
            "closures: [{link_a: coupler, link_b: rocker, point: [2, 2.5, 0], axis: [0, 0, 1]}]\n"
        )
        yaml += "dependent: [b, d]\nindependent: [a]\n"
    else:
        axis = ", axis: [0, 0, 1]" if kind == "pin_loops" else ""
        yaml = f"{kind}: [{{name: c, parent: coupler, child: rocker, parent_xyz: [2, 2, 0], "
        yaml += f"child_xyz: [0, 2.5, 0]{axis}}}]\nball_upgrades: []\nactuated_joints: [a]\n"
    beside = {"loop_closures.yaml": yaml}
    return Base(f"{_tree(rng)}</robot>", ("a",), name="robot.urdf", beside=beside)


GEPETTO = """closed_loop: [['{one}', '{two}']]
type: ['{kind}']
name_mot: ['a']
"""


def gepetto(rng: Random) -> Base:
    """Return a four-bar with Gepetto's YAML file beside it."""
    yaml = GEPETTO.format(
        one=rng.choice(["tip", "tip_joint"]),
        two=rng.choice(["end", "end_joint"]),
        kind=rng.choice(["3d", "6d", "3D"]),
    )
    if rng.random() < 0.4:
        kind = rng.choice(["revolute", "spherical", "SPHERICAL", "continuous", "fixed", "planar"])
        yaml += f"joint_name: ['{rng.choice('bd')}']\njoint_type: ['{kind}']\n"
    suffix = rng.choice([".yaml", ".yml"])
    text = _tree(rng, _tips()) + "</robot>"
    return Base(text, ("a",), name="robot.urdf", beside={f"robot{suffix}": yaml})


MJCF = """<mujoco model="four_bar"><compiler angle="radian"/>{head}<worldbody>{sites}
<body name="crank" pos="0 0 0"><inertial pos="0 0.25 0" mass="1" diaginertia="0.02 0.03 0.025"/>
  <joint name="a" type="hinge" axis="0 0 1"{a}/>
  <body name="coupler" pos="0 0.5 0"><inertial pos="1 1 0" mass="2" {inertia}/>
  <joint name="b" type="hinge" axis="0 0 1"{b}/><site name="s_1" pos="2 2 0"/>{more}</body></body>
{rocker}</worldbody><equality>{equality}</equality></mujoco>"""
ROCKER = """<body name="rocker" pos="2 0 0"><inertial pos="0 1.25 0" mass="3"
  diaginertia="0.02 0.03 0.025"/><joint name="{d}" type="hinge" axis="0 0 1"/>
  <site name="s_2" pos="0 2.5 0"/></body>"""


def mjcf(rng: Random) -> Base:
    """Return a four-bar as MJCF, or a crank and coupler closed to the world."""
    to_world = rng.random() < 0.3
    equality = rng.choice(
        [
            '<weld name="c" body1="coupler"/>',
            '<connect name="c" body1="coupler" anchor="2 2 0"/>',
            '<connect name="c" site1="s_1" site2="s_0"/>',
        ]
        if to_world
        else [
            '<connect name="c" body1="coupler" body2="rocker" anchor="2 2 0"/>',
            '<connect body1="coupler" body2="rocker" anchor="2 2 0"/>',
            '<connect name="c" body1="rocker" body2="coupler" anchor="0 2.5 0"/>',
            '<weld name="c" body1="coupler" body2="rocker"/>',
            '<weld name="c" body1="coupler" body2="rocker" relpose="2 -0.5 0 1 0 0 0"/>',
            '<connect name="c" site1="s_1" site2="s_2"/>',
            '<weld name="c" site1="s_1" site2="s_2"/>',
        ]
    )
    if rng.random() < 0.15:
        equality = equality.replace("/>", ' active="false"/>')
    extras = ("", "", "", ' armature="0.1"', ' damping="2"', ' stiffness="30" springref="0.2"')
    more = rng.choice(
        [
            "",
            "",
            "",
            '<geom type="sphere" size="0.1" mass="0.5"/>',
            '<site name="s_9"/>',
            '<body name="nut" pos="1 0 0"><inertial pos="0 0 0" mass="0.7"/></body>',
            '<joint name="b_2" type="slide" axis="1 0 0"/>',
            '<joint name="b_3" axis="1 0 0"/>',
            '<body name="ball"><joint type="ball"/><inertial pos="0 0 0" mass="1"/></body>',
            '<body name="free"><freejoint/><inertial pos="0 0 0" mass="1"/></body>',
        ]
    )
    head = rng.choice(
        [
            "",
            "",
            "",
            '<default><joint damping="1"/></default>',
            '<option gravity="0 0 -9"/>',
            '<default><default class="k"><joint axis="0 1 0"/></default></default>',
        ]
    )
    rocker = "" if to_world else ROCKER.format(d=rng.choice(["d", "d", "d", "universe", "world"]))
    beside = {}
    if rng.random() < 0.1:
        beside["rest.xml"] = f"<mujocoinclude>{rocker}</mujocoinclude>"
        rocker = '<include file="rest.xml"/>'
    text = MJCF.format(
        head=head,
        sites='<site name="s_0" pos="2 2.5 0"/>' if to_world else "",
        a=rng.choice(extras),
        b=rng.choice(extras),
        inertia=rng.choice(
            ['diaginertia="0.02 0.03 0.025"', 'fullinertia="0.02 0.03 0.025 0 0 0"']
        ),
        more=more,
        rocker=rocker,
        equality=equality,
    )
    name = "model.xml" if beside or rng.random() < 0.2 else None
    return Base(text, ("a",), name=name, beside=beside)


def deep(rng: Random) -> Base:
    """Return a chain of very many links, or bodies nested as deep."""
    count = rng.choice([300, 300, 300, 1500, 1500, 5000])
    if rng.random() < 0.4:
        body = '<body name="n_{0}" pos="0 0 .1"><inertial pos="0 0 0" mass="1" '
        body += 'diaginertia="1 1 1"/><joint name="j_{0}" axis="0 1 0"/>'
        nested = "".join(body.format(index) for index in range(count)) + "</body>" * count
        return Base(f"<mujoco><worldbody>{nested}</worldbody></mujoco>", ("j_0",))
    parts = ['<robot name="chain"><link name="link_0"/>']
    for index in range(1, count + 1):
        kind = "continuous" if index == 1 or rng.random() < 0.3 else "fixed"
        parts += [
            LINK.format(name=f"link_{index}", com="0 0 0", mass="1"),
            JOINT.format(
                name=f"joint_{index}",
                kind=kind,
                parent=f"link_{index - 1}",
                child=f"link_{index}",
                xyz="0 0 0.1",
                rpy="0 0 0",
                axis="0 1 0",
            ),
        ]
    return Base("".join([*parts, "</robot>"]), ("joint_1",))


BASES: tuple[tuple[float, Callable[[Random], Base]], ...] = (
    (14.0, bundled),
    (24.0, four_bar),
    (8.0, hung),
    (10.0, arm),
    (4.0, geared),
    (8.0, isaac),
    (4.0, constraint),
    (6.0, loop_closures),
    (12.0, gepetto),
    (20.0, mjcf),
    (0.25, deep),
)


def base(rng: Random) -> Base:
    """Return one of them."""
    (make,) = rng.choices([make for _, make in BASES], [weight for weight, _ in BASES])
    return make(rng)
