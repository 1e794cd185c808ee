"""What an SDF text says in other than plain words."""

from __future__ import annotations

from itertools import count

import mujoco
import numpy as np
import pytest

import cardan_dyn as cd

HEAD = '<sdf version="1.9"><model name="own"><link name="base"><inertial/></link>'
FIXED = '<joint name="w" type="fixed"><parent>world</parent><child>base</child></joint>'
WEIGHT = (0.0, 0.0, -9.81)


def inertial(x: float, mass: float = 2.0) -> str:
    moments = "".join(f"<{tag}>0.02</{tag}>" for tag in ("ixx", "iyy", "izz"))
    return (
        f"<inertial><pose>{x} 0 0 0 0 0</pose><mass>{mass}</mass><inertia>{moments}</inertia>"
        "</inertial>"
    )


def model(inside: str, version: str = "1.9") -> str:
    head = HEAD.replace("1.9", version).replace("<inertial/>", inertial(0.0))
    return f"{head}{FIXED}{inside}</model></sdf>"


def pendulum(of_link: str, of_axis: str = "", version: str = "1.9") -> str:
    return model(
        f'<link name="arm">{of_link}</link><joint name="hinge" type="revolute">'
        f"<parent>base</parent><child>arm</child><axis><xyz>0 1 0</xyz>{of_axis}</axis></joint>",
        version,
    )


def effort(text: str, drive: str, at: float = 0.0, **given: object) -> float:
    swept = cd.Scene(cd.load(text), drive=drive, gravity=WEIGHT, **given).sweep(at)  # type: ignore[arg-type]
    assert swept.balance_residual < 1e-14
    return float(swept.drive_effort[0])


@pytest.mark.parametrize(
    "twice",
    [
        "<velocity_decay><linear>0</linear></velocity_decay>"
        "<velocity_decay><angular>0</angular></velocity_decay>",
        "<velocity_decay/><velocity_decay><linear>0.0</linear></velocity_decay>",
        "<gravity>true</gravity><gravity>true</gravity>",
        inertial(0.2),
    ],
)
def test_what_stands_twice_and_says_the_same_stands_once(twice: str) -> None:
    assert effort(pendulum(inertial(0.2) + twice), "hinge") == pytest.approx(-2.0 * 9.81 * 0.2)


@pytest.mark.parametrize(
    "twice",
    [
        inertial(0.3),
        inertial(0.2, 3.0),
        "<inertial><mass>2</mass></inertial><inertial><mass>0</mass></inertial>",
        "<gravity>true</gravity><gravity>false</gravity>",
        "<velocity_decay><linear>0</linear></velocity_decay>"
        "<velocity_decay><angular>0.1</angular></velocity_decay>",
    ],
)
def test_what_stands_twice_and_says_something_else_is_refused(twice: str) -> None:
    with pytest.raises(cd.ModelError, match="keep one"):
        cd.load(pendulum(inertial(0.2) + twice))


def test_empty_elements_mean_their_defaults() -> None:
    empty = "<limit><lower/><effort/></limit><dynamics><damping/><friction/></dynamics>"
    text = pendulum(inertial(0.2).replace("<ixx>", "<ixy/><ixx>"), empty)
    mechanism = cd.load(text)
    limits = mechanism.description.joints[-1].limits
    assert (limits.lower, limits.effort) == (-np.inf, np.inf)
    assert effort(text, "hinge") == pytest.approx(-2.0 * 9.81 * 0.2)


def test_axes_of_the_parent_model_where_both_readings_agree() -> None:
    flag = "<use_parent_model_frame>true</use_parent_model_frame>"
    assert effort(pendulum(inertial(0.2), flag), "hinge") == pytest.approx(-2.0 * 9.81 * 0.2)
    turned = pendulum(inertial(0.2), flag).replace(
        '<link name="arm">', '<link name="arm"><pose>0 0 0 0 0 0.1</pose>'
    )
    with pytest.raises(cd.ModelError, match="expressed_in"):
        cd.load(turned)


def test_a_second_axis_has_a_default() -> None:
    joint = (
        f'<link name="arm">{inertial(0.0)}</link><joint name="cross" type="universal">'
        "<parent>base</parent><child>arm</child><axis><xyz>1 0 0</xyz></axis>{}</joint>"
    )
    implied, stated = (
        cd.load(model(joint.replace("{}", axis)))
        for axis in ("", "<axis2><xyz>0 0 1</xyz></axis2>")
    )
    one, other = (item.description.joints[-1].axis_2 for item in (implied, stated))
    np.testing.assert_array_equal(one, other)


def test_models_of_a_world_by_name() -> None:
    world = '<sdf version="1.9"><world name="hall">{}</world></sdf>'.format(
        "".join(
            pendulum(inertial(x))
            .removeprefix('<sdf version="1.9">')
            .removesuffix("</sdf>")
            .replace('"own"', f'"{name}"')
            for name, x in (("left", 0.1), ("right", 0.2))
        )
    )
    with pytest.raises(cd.ModelError, match=r'2 models \(left, right\).*model="NAME"'):
        cd.load(world)
    with pytest.raises(cd.ModelError, match=r"model 'rigth' does not exist.*right"):
        cd.load(world, model="rigth")
    with pytest.raises(cd.ArgumentError, match="only SDF"):
        cd.load("four_bar", model="left")
    with pytest.raises(cd.ArgumentError, match="not 3"):
        cd.load(world, model=3)  # type: ignore[arg-type]
    for name, x in (("left", 0.1), ("right", 0.2)):
        mechanism = cd.load(world, model=name)
        assert mechanism.name == name and "left out" in mechanism.warnings[0]
        swept = cd.Scene(mechanism, drive="hinge", gravity=WEIGHT).sweep(0.0)
        assert swept.drive_effort == pytest.approx(-2.0 * 9.81 * x)
        assert swept.balance_residual < 1e-14


def test_a_closed_chain_of_models_in_models() -> None:
    """A four-bar whose coupler and rocker come from models that stand somewhere, turned."""
    pose = "<pose relative_to='crank'>0.05 0.1 0 0 0 0.7</pose>"
    coupler = (
        f'<model name="bar">{pose}<link name="coupler">{inertial(0.1)}</link><model name="end">'
        '<pose>0.3 0 0 0 0 -1.1</pose><link name="rocker"><pose>0 0 0 0 0 0.2</pose>'
        f'{inertial(0.15)}</link><frame name="pin" attached_to="rocker"><pose>0.1 0 0 0 0 0</pose>'
        "</frame></model>"
        '<joint name="C" type="revolute"><parent>coupler</parent><child>end::rocker</child>'
        '<axis><xyz expressed_in="__model__">0 0 1</xyz></axis></joint></model>'
    )

    def hinge(name: str, parent: str, child: str, at: str) -> str:
        return (
            f'<joint name="{name}" type="revolute"><pose relative_to="{at}"/>'
            f"<parent>{parent}</parent><child>{child}</child><axis><xyz>0 0 1</xyz></axis></joint>"
        )

    crank = f'<link name="crank"><pose>0 0.02 0 0 0 0.3</pose>{inertial(0.05)}</link>'
    nested = model(
        crank
        + coupler
        + hinge("A", "base", "crank", "crank")
        + hinge("B", "crank", "bar::coupler", "bar")
        + hinge("D", "base", "bar::end::rocker", "bar::end::pin")
    )
    # The same with all places in the world, by hand.
    turn = lambda angle, x, y: np.array(  # noqa: E731
        [[np.cos(angle), -np.sin(angle), x], [np.sin(angle), np.cos(angle), y], [0, 0, 1]]
    )
    at_crank = turn(0.3, 0.0, 0.02)
    at_bar = at_crank @ turn(0.7, 0.05, 0.1)
    at_rocker = at_bar @ turn(-1.1, 0.3, 0.0) @ turn(0.2, 0.0, 0.0)
    at_pin = at_rocker @ turn(0.0, 0.1, 0.0)

    def placed(at: np.ndarray) -> str:
        angle = np.arctan2(at[1, 0], at[0, 0])
        return f"<pose>{at[0, 2]:.17g} {at[1, 2]:.17g} 0 0 0 {angle:.17g}</pose>"

    flat = (
        "".join(
            f'<link name="{name}">{placed(at)}{inertial(x)}</link>'
            for name, at, x in (
                ("crank", at_crank, 0.05),
                ("coupler", at_bar, 0.1),
                ("rocker", at_rocker, 0.15),
            )
        )
        + f'<frame name="pin">{placed(at_pin)}</frame>'
        + hinge("C", "coupler", "rocker", "rocker")
        + hinge("A", "base", "crank", "crank")
        + hinge("B", "crank", "coupler", "coupler")
        + hinge("D", "base", "rocker", "pin")
    )
    sweeps = [
        cd.Scene(cd.load(text), drive="A", gravity=(0.0, -9.81, 0.0)).sweep([0.1, 0.2], speed=3.0)
        for text in (nested, model(flat))
    ]
    for swept in sweeps:
        assert max(swept.loop_residual, swept.balance_residual) < 1e-14
    np.testing.assert_allclose(*(swept.drive_effort for swept in sweeps), rtol=1e-12)
    for name in "ABD":
        forces = [swept[name].force for swept in sweeps]
        np.testing.assert_allclose(
            *(np.linalg.norm(force, axis=-1) for force in forces), rtol=1e-11
        )


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        ('<model name="inner"/>', "no <link>"),
        ('<model name="inner" placement_frame="x"><link name="x"/></model>', "placement_frame"),
        ('<model name="inner"><static>true</static><link name="x"/></model>', "static"),
        ('<model><link name="x"/></model>', "needs a name"),
        ('<model name="inner"><include/><link name="x"/></model>', "<include> in <model>"),
    ],
)
def test_models_in_models_that_are_refused(inside: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        cd.load(model(inside))


def test_models_in_models_of_versions_without_frames_are_refused() -> None:
    with pytest.raises(cd.ModelError, match=r"before SDF 1\.7"):
        cd.load(model('<model name="inner"><link name="x"/></model>', "1.6"))


@pytest.mark.parametrize("version", ["1.6", "1.10"])
@pytest.mark.parametrize(
    ("stated", "ratio"),
    [
        ("<screw_thread_pitch>0.005</screw_thread_pitch>", 0.005 / (2.0 * np.pi)),
        ("<thread_pitch>-250</thread_pitch>", 0.004),
    ],
)
def test_screws(stated: str, ratio: float, version: str) -> None:
    """Power: the torque on the thread times its rate is the force times the nut's."""
    text = model(
        f'<link name="nut"><pose>0.1 0.2 0.3 0 0 0.4</pose>{inertial(0.0, 3.0)}</link>'
        '<joint name="thread" type="screw"><pose>0 0 0.1 0 0 0</pose><parent>base</parent>'
        f"<child>nut</child><axis><xyz>0 0 1</xyz></axis>{stated}</joint>",
        version,
    )
    mechanism = cd.load(text)
    assert cd.describe(mechanism).mobility == 1
    assert effort(text, "thread", 0.7) == pytest.approx(3.0 * 9.81 * ratio, rel=1e-13)
    swept = cd.Scene(mechanism, drive="thread").sweep(0.7, speed=2.0)
    moved = swept.point("nut").velocity[0]
    np.testing.assert_allclose(moved, [0.0, 0.0, 2.0 * ratio], atol=1e-15)


@pytest.mark.parametrize(
    ("stated", "message"),
    [("", "screw_thread_pitch> is missing"), ("<thread_pitch>0</thread_pitch>", "is a hinge")],
)
def test_screws_without_a_pitch_are_refused(stated: str, message: str) -> None:
    screw = (
        f'<link name="nut">{inertial(0.0)}</link><joint name="thread" type="screw"><parent>base'
        f"</parent><child>nut</child><axis><xyz>0 0 1</xyz></axis>{stated}</joint>"
    )
    with pytest.raises(cd.ModelError, match=message):
        cd.load(model(screw))


def test_joints_of_plugins_between_links_of_the_model_are_joints() -> None:
    """They are loops, as the links that they hold are carried already."""
    plugin = (
        '<plugin filename="detachable" name="gz::sim::systems::DetachableJoint">'
        "<parent_link>base</parent_link><child_model>{}</child_model><child_link>arm</child_link>"
        "</plugin>"
    )
    free = pendulum(inertial(0.2))
    for named in ("own", "__model__"):
        held = cd.load(free.replace("</model>", f"{plugin.format(named)}</model>"))
        assert [loop.name for loop in held.description.loops] == ["base_to_arm"]
        assert cd.describe(held).mobility == 0
    other = cd.load(free.replace("</model>", f"{plugin.format('crate')}</model>"))
    assert not other.loops and "passed over" in other.warnings[-1]


def test_plugins_and_screws_of_models_in_models_are_their_own() -> None:
    """The outer model has links of the same names, which they have nothing to do with."""
    inner = (
        '<model name="inner"><pose>0 0 1 0 0 0.2</pose>'
        f'<link name="base">{inertial(0.0)}</link><link name="arm">{inertial(0.2)}</link>'
        f'<link name="nut">{inertial(0.0, 3.0)}</link>'
        '<joint name="hinge" type="revolute"><parent>base</parent><child>arm</child>'
        "<axis><xyz>0 1 0</xyz></axis></joint>"
        '<joint name="thread" type="screw"><parent>base</parent><child>nut</child>'
        "<axis><xyz>0 0 1</xyz></axis><screw_thread_pitch>0.005</screw_thread_pitch></joint>"
        '<plugin filename="detachable" name="gz::sim::systems::DetachableJoint">'
        "<parent_link>base</parent_link><child_model>__model__</child_model>"
        "<child_link>arm</child_link></plugin><enable_wind>false</enable_wind></model>"
        '<joint name="stand" type="fixed"><parent>base</parent><child>inner::base</child></joint>'
        "<enable_wind>false</enable_wind>"
    )
    text = pendulum(inertial(0.2)).replace("</model>", f"{inner}</model>")
    mechanism = cd.load(text)
    (loop,) = mechanism.description.loops
    assert (loop.predecessor, loop.successor) == ("inner::base", "inner::arm")
    assert set(mechanism.joint_names) >= {"hinge", "inner::thread", "inner::thread_slide"}
    assert cd.describe(mechanism).mobility == 2
    swept = cd.Scene(mechanism, drive=["hinge", "inner::thread"], gravity=WEIGHT).sweep([0.0, 0.5])
    assert swept.balance_residual < 1e-14
    efforts = [-2.0 * 9.81 * 0.2, 3.0 * 9.81 * 0.005 / (2.0 * np.pi)]
    np.testing.assert_allclose(swept.drive_effort[0], efforts, rtol=1e-12)


SHAPES = {
    "box": (("size", 3), "box", lambda size: 0.5 * size),
    "sphere": (("radius", 1), "sphere", lambda size: size),
    "ellipsoid": (("radii", 3), "ellipsoid", lambda size: size),
    "cylinder": (("radius length", 1), "cylinder", lambda size: size * [1.0, 0.5]),
    "capsule": (("radius length", 1), "capsule", lambda size: size * [1.0, 0.5]),
}


@pytest.mark.parametrize("seed", range(6))
def test_inertia_of_collision_shapes(seed: int) -> None:
    """Against MuJoCo, which has them of the same geoms; and the proof computes them otherwise."""
    random, names = np.random.default_rng(seed), count()
    collisions, geoms = "", ""
    for kind, ((tags, each), geom, half) in SHAPES.items():
        words = tags.split()
        size = random.uniform(0.05, 0.4, each * len(words))
        place, angles = random.uniform(-0.5, 0.5, 3), random.uniform(-3.0, 3.0, 3)
        density = random.uniform(500.0, 2000.0)
        text = lambda values: " ".join(f"{value:.17g}" for value in values)  # noqa: E731
        sizes = "".join(
            f"<{word}>{text(part)}</{word}>"
            for word, part in zip(words, np.split(size, len(words)), strict=True)
        )
        collisions += (
            f'<collision name="c{next(names)}"><density>{density:.17g}</density>'
            f"<pose>{text(place)} {text(angles)}</pose><geometry><{kind}>{sizes}</{kind}>"
            "</geometry></collision>"
        )
        geoms += (
            f'<geom type="{geom}" size="{text(half(size))}" density="{density:.17g}" '
            f'pos="{text(place)}" euler="{text(angles)}"/>'
        )
    mechanism = cd.load(pendulum(f'<inertial auto="true"/>{collisions}', version="1.11"))
    link = next(item for item in mechanism.description.links if item.name == "arm")
    reference = mujoco.MjModel.from_xml_string(
        '<mujoco><compiler angle="radian" eulerseq="XYZ"/><worldbody><body><joint/>'
        f"{geoms}</body></worldbody></mujoco>"
    )
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, reference.body_iquat[1])
    turn = turn.reshape(3, 3)
    assert link.mass == pytest.approx(reference.body_mass[1], rel=1e-12)
    np.testing.assert_allclose(link.centre, reference.body_ipos[1], atol=1e-12)
    expected = turn @ np.diag(reference.body_inertia[1]) @ turn.T
    np.testing.assert_allclose(link.inertia, expected, rtol=1e-9, atol=1e-9 * np.trace(expected))
    swept = cd.Scene(mechanism, drive="hinge", gravity=WEIGHT).sweep(0.3, speed=2.0)
    assert swept.balance_residual < 1e-13


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        ('<inertial auto="true"/>', "no <collision>"),
        ('<inertial auto="true"><mass>1</mass></inertial>', "exclude each other"),
        (
            '<inertial auto="true"/><collision name="c"><geometry><mesh><uri>a.stl</uri></mesh>'
            "</geometry></collision>",
            "<mesh> is not computed here.*expand-auto-inertials",
        ),
        (
            '<inertial auto="true"/><collision name="c"><geometry><sphere><radius>-1</radius>'
            "</sphere></geometry></collision>",
            "positive",
        ),
    ],
)
def test_collision_shapes_that_are_refused(inside: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        cd.load(pendulum(inside, version="1.11"))
