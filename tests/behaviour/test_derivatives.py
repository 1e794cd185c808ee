"""Derivatives of results, against closed forms, 50-digit references, and what is linear."""

from __future__ import annotations

import pickle
from collections.abc import Callable

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.kit.arrays import Array

pytestmark = pytest.mark.usefixtures("loaded_once")

TORQUE = 100.0
PHI = np.radians([3.0, 10.0, 30.0, 60.0, 120.0, 200.0, 350.0])


def universal_joint(angle: float) -> cd.Scene:
    return cd.Scene(
        cd.load("universal_joint"),
        drive="bearing_in",
        held={"joint_angle": angle},
        loads={"bearing_out": -TORQUE},
        outputs=["bearing_in", "pin_out", "bearing_out"],
    )


@pytest.mark.parametrize("degrees", [1.0, 30.0, 60.0, 85.0])
def test_closed_forms_of_the_universal_joint(degrees: float) -> None:
    beta = np.radians(degrees)
    sine, cosine = np.sin(beta), np.cos(beta)
    square = 1.0 - sine**2 * np.sin(PHI) ** 2  # Poncelet's ratio is cos β / (1 − sin²β cos²φ).
    square = 1.0 - sine**2 * np.cos(PHI) ** 2
    sweep = universal_joint(beta).sweep(PHI)
    assert sweep.drive_effort == pytest.approx(TORQUE * cosine / square, rel=1e-13)
    found = sweep.derivative("bearing_in", "joint_angle")
    by_phi = -2.0 * TORQUE * cosine * sine**2 * np.sin(PHI) * np.cos(PHI) / square**2
    by_beta = TORQUE * sine * (2.0 * cosine**2 * np.cos(PHI) ** 2 - square) / square**2
    for name, effort in ("bearing_in", by_phi), ("joint_angle", by_beta):
        size = np.abs(effort).max()
        assert found[name].drive_effort == pytest.approx(effort, abs=1e-12 * size)
        assert found[name].loop_residual < 1e-13
    turned = found["joint_angle"].motion.position("bearing_out")
    expected = sine * np.sin(PHI) * np.cos(PHI) / square
    assert turned == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())
    ratio = found["bearing_in"].motion.position("bearing_out")
    assert ratio == pytest.approx(sweep.motion.ratio("bearing_out"), rel=1e-13)


# Bending moments in the bearings of both shafts, and the input torque, at 30°, with derivatives by
# the joint angle, then by the input angle: closed forms, and three-vectors differentiated with 50
# digits. Rows are input angles of 10°, 30°, 60° and 120°.
OUTPUT_BENDING = [
    [56.574292396219084, 129.35257926830301, -13.168406867490374],
    [48.03844614152614, 102.40619007234999, -34.135396690783331],
    [25.819888974716113, 47.702783519995514, -47.702783519995514],
    [25.819888974716113, 47.702783519995514, 47.702783519995514],
]
INPUT_BENDING = [
    [11.461344568925101, 32.559257966903741, 63.706847792036201],
    [30.769230769230769, 77.891042233866671, 45.094813924870178],
    [46.188021535170061, 90.666666666666667, 16.0],
    [46.188021535170061, 90.666666666666667, -16.0],
]
INPUT_TORQUE = [
    [114.32098731556364, 60.748756027559306, -12.903662477882956],
    [106.5877420042386, 23.668639053254438, -28.402366863905325],
    [92.376043070340122, -32.0, -21.333333333333333],
    [92.376043070340122, -32.0, 21.333333333333333],
]
# Of the angle of the output, the derivatives alone.
OUTPUT_TURN = [
    [0.11287220991421803, 1.1432098731556364],
    [0.26646935501059651, 1.065877420042386],
    [0.23094010767585031, 0.92376043070340122],
    [-0.23094010767585031, 0.92376043070340122],
]


def test_bending_moments_of_the_universal_joint() -> None:
    sweep = universal_joint(np.radians(30.0)).sweep(np.radians([10.0, 30.0, 60.0, 120.0]))
    by = sweep.derivative("joint_angle", "bearing_in").values()
    turned = np.column_stack([each.motion.position("bearing_out") for each in by])
    np.testing.assert_allclose(turned, OUTPUT_TURN, rtol=0, atol=1e-12)
    found = [sweep.drive_effort, *(each.drive_effort for each in by)]
    errors = [np.column_stack(found) - INPUT_TORQUE]
    for joint, expected in ("bearing_in", INPUT_BENDING), ("bearing_out", OUTPUT_BENDING):
        across = sweep[joint].moment[:, 1:]
        size = np.linalg.norm(across, axis=1)
        rates = [(across * each[joint].moment[:, 1:]).sum(axis=1) / size for each in by]
        errors.append(np.column_stack([size, *rates]) - expected)
    expected = np.array([INPUT_TORQUE, INPUT_BENDING, OUTPUT_BENDING])
    # Of the greatest over the sweep.
    assert np.max(np.abs(errors) / np.abs(expected).max(axis=1, keepdims=True)) < 1e-12


def link(name: str, mass: float, x: float, y: float, inertia: float) -> str:
    return (
        f'<link name="{name}"><inertial><origin xyz="{x} {y} 0"/><mass value="{mass}"/>'
        f'<inertia ixx="1" iyy="1" izz="{inertia}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


FOUR_BAR = f"""<robot name="four_bar"><link name="base"/>
{link("crank", 1.5, 0.03, 0.0, 0.002)}{link("coupler", 1.6, 0.2, 0.01, 0.029)}
{link("rocker", 2.3, 0.09, 0.0, 0.006)}
<joint name="A" type="continuous"><parent link="base"/><child link="crank"/><axis xyz="0 0 1"/>
</joint>
<joint name="B" type="continuous"><parent link="crank"/><child link="coupler"/>
<origin xyz="0.08 0 0"/><axis xyz="0 0 1"/></joint>
<joint name="E" type="continuous"><parent link="base"/><child link="rocker"/>
<origin xyz="0.47 0 0"/><axis xyz="0 0 1"/></joint>
<loop name="C" type="continuous"><predecessor link="coupler"><origin xyz="LENGTH 0 0"/>
</predecessor><successor link="rocker"><origin xyz="0.25 0 0"/></successor><axis xyz="0 0 1"/>
</loop></robot>"""
CRANK, COUPLER, ROCKER = np.radians(60.0), 0.44216574651924813, 1.8482178731155774
GIVEN = {"speed": 20.0, "acceleration": 5.0}

# What is differentiated: forces as below, then angle, rate and acceleration of coupler and rocker.
FORCES = """-70.741191755357995 -34.335664807662149 -61.546336039506496 -33.574707539542254
    -25.656375737223234 -17.660922267240577 2.710875641324513 30.758937233189095"""
MOTION = {
    "B": (COUPLER - CRANK, -2.9116896210202146 - 20.0, 48.495859509845712 - 5.0),
    "E": (ROCKER, 3.6902088845662217, 119.13243205445085),
}

# Derivatives of the drive torque T: nine free-body equations, differentiated with 50 digits.
OF_TORQUE = {
    "A": 1.168284498885597,
    "speed:A": 0.1843027394591594,
    "acceleration:A": 0.01006029796439151,
    "mass:coupler": 1.102800918414054,
    "centre:coupler.y": -2.793675486322327,
    "centre:rocker.x": 7.960029096833799,
    "load:E": -0.1845104442283111,
    "origin:C.predecessor.x": 4.260113782702678,
    "origin:C.successor.x": -12.14411523319025,
}
# Of forces at A, B, C and E, on the crank, the coupler, the rocker and the rocker, in world axes.
OF_FORCES = {
    "origin:C.predecessor.x": """-42.05988413545111 33.65298828450546 -42.05988413545111
        33.65298828450546 -53.27221501412718 -26.07649611726761 44.40464929721414
        120.4526168602302""",
    "origin:C.successor.x": """130.7330585201638 -77.16658124395728 130.7330585201638
        -77.16658124395728 179.9006900404083 -74.55223663375174 -139.015239239887
        112.2511575775486""",
    "A": """69.62006536967121 3.650840433933455 54.14410810155132 12.84569614978495
        6.17467470998314 31.85942466615098 21.05148817779607 -38.22608375631176""",
    "speed:A": """-5.568386374574536 -5.037159630458373 -4.668386374574536 -3.478313903646383
        -1.123796057002526 -0.3058903251136316 -1.15238729251306 -0.6353780013247385""",
    "acceleration:A": """-0.1387317130769705 0.01746707343940737 -0.09976056990667073
        -0.005032926560592627 -0.01094914459403815 -0.02792302916576083 -0.02578417555453318
        0.01746267523220443""",
    "mass:coupler": """-22.17646663554545 -10.84074398476942 -22.17646663554545
        -10.84074398476942 0.2547585533815854 -0.8946281895808679 -0.2547585533815854
        0.8946281895808679""",
    "centre:coupler.y": """-38.4296615011159 -136.4040133956646 -38.4296615011159
        -136.4040133956646 25.89702480140102 -90.9418274914843 -25.89702480140102
        90.9418274914843""",
    "centre:rocker.x": """-158.110024296958 -74.85386784743588 -158.110024296958
        -74.85386784743588 -158.110024296958 -74.85386784743588 -96.83997676858338
        -30.31263253091392""",
    "load:E": """3.664930173632742 1.735084161216359 3.664930173632742 1.735084161216359
        3.664930173632742 1.735084161216359 -3.664930173632742 -1.735084161216359""",
}
# Of the size of the force at C.
OF_SIZE = {
    "origin:C.predecessor.x": 58.66651829125145,
    "mass:coupler": 0.297417787889976,
    "A": -23.15081237955693,
}
# Of angle, rate and acceleration of the coupler and of the rocker.
OF_MOTION = {
    "origin:C.predecessor.x": (
        (-0.4156274549305308, 16.96092736641314, 144.240628973125),
        (-4.054901999322252, 4.450547340946808, -138.8844216172035),
    ),
    "A": (
        (-0.1455844810510107, 2.461189095755038, 12.58380400648892),
        (0.1845104442283111, 5.910493991665465, -115.5622140292008),
    ),
    "origin:E.x": (
        (-0.6940894756386791, -8.232752771354167, -284.9520553833413),
        (3.664930173632742, 1.029501402205539, -0.777870494729778),
    ),
}


def four_bar(length: float = 0.4, **options: object) -> cd.Scene:
    mechanism = cd.load(FOUR_BAR.replace("LENGTH", repr(length)))
    near = {"A": CRANK, "B": COUPLER - CRANK, "E": ROCKER}
    given = {"drive": "A", "near": near, "loads": {"E": -5.0}, "gravity": (0.0, -9.81, 0.0)}
    return cd.Scene(mechanism, **{**given, **options})


def test_four_bar_with_masses() -> None:
    sweep = four_bar().sweep(CRANK, **GIVEN)
    assert sweep.drive_effort == pytest.approx(3.1585419400236188, rel=1e-13)
    forces = [sweep.rotation(joint)[0] @ sweep[joint].force[0] for joint in "ABCE"]
    expected = np.array(FORCES.split(), dtype=float).reshape(4, 2)
    np.testing.assert_allclose(np.array(forces)[:, :2], expected, rtol=0, atol=1e-12 * 70.0)
    for joint, expected in MOTION.items():
        motion = [sweep.motion.position(joint), sweep.motion.velocity(joint)]
        motion.append(sweep.motion.acceleration(joint))
        np.testing.assert_allclose(np.ravel(motion), expected, rtol=1e-13)
    found = sweep.derivative(*OF_TORQUE, "origin:E.x")
    for name, expected in OF_TORQUE.items():
        assert found[name].drive_effort[0] == pytest.approx(expected, rel=1e-12), name
    for name, text in OF_FORCES.items():
        by, expected = found[name], np.array(text.split(), dtype=float).reshape(4, 2)
        crank = float(name == "A")
        coupler, rocker = crank + by.motion.position("B")[0], by.motion.position("E")[0]
        rates = []
        # The axes of a joint turn with one of its links.
        for joint, turned in ("A", crank), ("B", coupler), ("C", rocker), ("E", rocker):
            axes = sweep.rotation(joint)[0]
            turn = np.cross([0.0, 0.0, turned], axes @ sweep[joint].force[0])
            rates.append(turn + axes @ np.nan_to_num(by[joint].force[0]))
        rates = np.array(rates)[:, :2]
        assert rates == pytest.approx(expected, abs=1e-12 * np.abs(expected).max()), name
        if name in OF_SIZE:
            force = (sweep.rotation("C")[0] @ sweep["C"].force[0])[:2]
            size = force @ rates[2] / np.linalg.norm(force)
            assert size == pytest.approx(OF_SIZE[name], rel=1e-12), name
    for name, (coupler, rocker) in OF_MOTION.items():
        motion = found[name].motion
        for read, first, second in zip(
            (motion.position, motion.velocity, motion.acceleration), coupler, rocker, strict=True
        ):
            turned = read("B")[0] + (name == "A" and read == motion.position)
            assert turned == pytest.approx(first, rel=1e-12), name
            assert read("E")[0] == pytest.approx(second, rel=1e-12), name


def test_where_a_crank_lies_is_as_good_as_how_it_is_turned() -> None:
    sweep = four_bar().sweep(np.linspace(0.5, 6.0, 9), **GIVEN)
    found = sweep.derivative("A", "origin:A.yaw")
    first, second = found["A"], found["origin:A.yaw"]
    size = np.abs(first.drive_effort).max()
    assert second.drive_effort == pytest.approx(first.drive_effort, abs=1e-12 * size)
    assert second["C"].force[:, :2] == pytest.approx(first["C"].force[:, :2], abs=1e-9)


def all_of(results: cd.Sweep | object) -> Array:
    force, moment = results["C"].force, results["B"].moment
    return np.column_stack([force[:, :2], moment[:, 2], results.drive_effort])


def sloped(values: Callable[[float], Array], step: float) -> Array:
    """Return a difference of fourth order."""
    far_back, back, ahead, far_ahead = (values(k * step) for k in (-2.0, -1.0, 1.0, 2.0))
    return (8.0 * (ahead - back) - (far_ahead - far_back)) / (12.0 * step)


def elements(stiffness: float = 1000.0, damping: float = 20.0) -> dict[str, object]:
    ends = "base", (0.1, 0.3, 0.0), "coupler", (0.2, 0.05, 0.0)
    spring = cd.PointSpring(*ends, stiffness, damping=damping, length=0.1, name="spring")
    return {"elements": [spring, cd.JointSpring("E", 30.0, damping=2.0, rest=0.2)]}


def test_what_elements_exert_is_part_of_it() -> None:
    positions = np.linspace(0.5, 6.0, 9)
    sweep = four_bar(**elements()).sweep(positions, **GIVEN)
    found = sweep.derivative(
        "A", "speed:A", "stiffness:spring", "damping:spring", "stiffness:elements[1]",
        "origin:C.predecessor.x",
    )  # fmt: skip

    def swept(scene: cd.Scene, by: float = 0.0, faster: float = 0.0) -> Array:
        return all_of(scene.sweep(positions + by, speed=20.0 + faster, acceleration=5.0))

    scene = four_bar(**elements())
    expected = {
        "A": sloped(lambda by: swept(scene, by), 1e-3),
        "speed:A": sloped(lambda by: swept(scene, 0.0, by), 1e-2),
        # Forces are linear in these.
        "stiffness:spring": swept(four_bar(**elements(1100.0))) / 100.0 - swept(scene) / 100.0,
        "damping:spring": swept(four_bar(**elements(damping=21.0))) - swept(scene),
        "origin:C.predecessor.x": sloped(
            lambda by: swept(four_bar(0.4 + by, **elements())), 3e-4
        ),
    }  # fmt: skip
    for name, values in expected.items():
        size = np.abs(values).max()
        assert all_of(found[name]) == pytest.approx(values, abs=3e-9 * size), name
    turned = sweep.motion.position("E") - 0.2
    # The spring at the rocker turns it back; the drive holds that by the velocity ratio.
    effort = turned * sweep.motion.ratio("E")
    own = found["stiffness:elements[1]"].drive_effort
    assert own == pytest.approx(effort, abs=1e-11 * np.abs(effort).max())


def test_masses_add_up_to_factors() -> None:
    positions = np.linspace(0.5, 6.0, 9)
    scene = four_bar()
    names = [f"inertia:coupler.{axes}" for axes in ("xx", "yy", "zz", "xy", "xz", "yz")]
    for factor in 1.0, 2.5:
        sweep = scene.sweep(positions, inertia={"coupler": factor}, **GIVEN)
        found = sweep.derivative("mass:coupler", *names)
        link = next(x for x in scene.mechanism.description.links if x.name == "coupler")
        tensor = link.inertia[np.triu_indices(3)][[0, 3, 5, 1, 2, 4]]
        total = link.mass * all_of(found["mass:coupler"])
        total = total + sum(
            value * all_of(found[name]) for name, value in zip(names, tensor, strict=True)
        )
        more = scene.sweep(positions, inertia={"coupler": factor + 1.0}, **GIVEN)
        # What factors multiply, mass and inertia, is linear in them.
        change = factor * (all_of(more) - all_of(sweep))
        assert total == pytest.approx(change, abs=1e-11 * np.abs(change).max())


def test_shapes_of_many_drives_and_designs() -> None:
    scene = cd.Scene(
        cd.load("stewart_platform"),
        drive=[f"leg_{k}" for k in range(1, 7)],
        gravity=(0.0, 0.0, -9.81),
    )
    sweep = scene.sweep(np.zeros((2, 3, 6)) + np.linspace(0.0, 0.01, 3)[:, None])
    found = sweep.derivative("leg_2")
    assert found.drive_effort.shape == (2, 3, 6)
    back = scene.sweep(sweep.position - 1e-4 * np.eye(6)[1])
    ahead = scene.sweep(sweep.position + 1e-4 * np.eye(6)[1])
    change = (ahead.drive_effort - back.drive_effort) / 2e-4
    assert found.drive_effort == pytest.approx(change, abs=1e-5 * np.abs(change).max())
    scene = universal_joint(0.5)
    sweep = scene.sweep(PHI, held={"joint_angle": np.array([[0.2], [0.7]])})
    own = sweep.derivative("joint_angle").drive_effort
    alone = scene.sweep(PHI, held={"joint_angle": 0.7}).derivative("joint_angle").drive_effort
    assert own.shape == (2, 7)
    assert own[1] == pytest.approx(alone, abs=1e-12 * np.abs(alone).max())


def test_what_opens_a_loop_has_no_derivative() -> None:
    sweep = four_bar().sweep(CRANK)
    for name in "origin:E.z", "origin:E.roll", "origin:C.successor.pitch":
        with pytest.raises(cd.CardanError, match="opens a loop"):
            sweep.derivative(name)


def test_components_that_are_not_unique_are_missing() -> None:
    found = four_bar().sweep(CRANK, **GIVEN).derivative("A")["B"]
    assert found.unique.tolist() == [True, True, False, False, False, True]
    assert np.isnan(found.force[0]).tolist() == [False, False, True]
    assert np.isnan(found.moment[0]).tolist() == [True, True, False]


STRUT = """<robot name="strut"><link name="base"/><link name="wheel"/><link name="arm"/>
<link name="rod"/>
<joint name="drive" type="continuous"><parent link="base"/><child link="wheel"/><axis xyz="0 0 1"/>
</joint>
<joint name="swivel" type="continuous"><parent link="wheel"/><child link="arm"/>
<origin xyz="SIZE 0 0"/><axis xyz="0 0 1"/></joint>
<joint name="near" type="continuous"><parent link="wheel"/><child link="rod"/><axis xyz="0 0 1"/>
</joint>
<loop name="far" type="continuous"><predecessor link="rod"><origin xyz="SIZE 0 0"/></predecessor>
<successor link="arm"/><axis xyz="0 0 1"/></loop></robot>"""
"""A rod between its near hinge and the far one, which is at a swivel that is held. Its tension is
open; the forces across it, and the moment at the swivel, are not."""
OPEN = {f"{name}.{part}" for name in ("swivel", "near", "far") for part in ("force_x", "force_z")}
OPEN |= {f"{name}.moment_{axis}" for name in ("swivel", "near", "far") for axis in "xy"}
ACROSS = {"swivel.force_y", "far.force_y"}
TURNED: dict[str, set[str]] = {
    "swivel": ACROSS,
    "origin:swivel.y": ACROSS,
    "origin:near.y": ACROSS,
    "origin:swivel.yaw": ACROSS,
    # Forces at the near hinge are told in the rod's axes, in which the far one is then aside.
    "origin:far.predecessor.y": {"near.force_y"},
    # Then tension has a lever.
    "origin:far.successor.y": {*ACROSS, "swivel.moment_z", "swivel.holding_effort"},
    "drive": set(),
    "load:swivel": set(),
    "mass:arm": set(),
    "origin:near.yaw": set(),
    "origin:drive.pitch": set(),
}


@pytest.mark.parametrize("size", [1e-3, 2.0, 1e3])
def test_self_stress_turns_into_what_is_unique(size: float) -> None:
    mechanism = cd.load(STRUT.replace("SIZE", repr(size)))
    scene = cd.Scene(mechanism, drive="drive", held={"swivel": 0.0}, loads={"swivel": 3.0})
    sweep = scene.sweep([0.0, 1.0])
    for name, by in sweep.derivative(*TURNED).items():
        for joint in sweep.outputs:
            for kind in "force", "moment":
                told = {f"{joint}.{kind}_{axis}" for axis in "xyz"}
                missing = [part in OPEN | TURNED[name] for part in sorted(told)]
                assert np.isnan(getattr(by[joint], kind)).tolist() == [missing] * 2
                unique = by[joint].unique[:3] if kind == "force" else by[joint].unique[3:]
                assert unique.tolist() == np.logical_not(missing).tolist()
        is_turned = "swivel.holding_effort" in TURNED[name]
        assert np.isnan(by.holding_effort["swivel"]).tolist() == [is_turned] * 2
    for result in "swivel.force_y", "swivel.moment_z", "near.force_y", "swivel.holding_effort":
        known = sweep.gradient({result: 1.0, "far.position": 1.0}, "*").keys()
        assert known & TURNED.keys() == {name for name in TURNED if result not in TURNED[name]}
    with pytest.raises(cd.ModelError, match="does not follow from the laws of motion alone"):
        sweep.gradient({"swivel.moment_z": 1.0}, "origin:far.successor.y")


def test_self_stress_turns_while_a_task_is_held() -> None:
    mechanism = cd.load(STRUT.replace("SIZE", "2.0"))
    task = {"task": cd.PointTask("arm", axes="x"), "actuated": "drive", "near": {"drive": 1.0}}
    sweep = cd.Scene(mechanism, held={"swivel": 0.0}, **task).sweep(2.0 * np.cos([0.8, 1.2]))
    names = "swivel", "origin:swivel.y", "arm.x", "origin:near.yaw"
    for name, by in sweep.derivative(*names).items():
        turned = ACROSS & TURNED.get(name, set())
        assert by["swivel"].unique[1] == (not turned)
        assert np.isnan(by["swivel"].force[:, 1]).all() == bool(turned)
    assert [*sweep.gradient({"swivel.force_y": 1.0}, "*swivel*")] == ["load:swivel"]
    with pytest.raises(cd.ModelError, match="does not follow from the laws of motion alone"):
        sweep.gradient({"swivel.force_y": 1.0}, *names)


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("nobody", "nothing that the scene drives or holds"),
        ("B", "nothing that the scene drives or holds"),
        ("speed:B", "drives are A"),
        ("load:nobody", "name a joint"),
        ("load:coupler.force_x", "has a load in the sweep"),
        ("mass:nobody", "no link"),
        ("centre:coupler", "says no parameter"),
        ("inertia:coupler.x", "says no parameter"),
        ("stiffness:nobody", "elements are"),
        ("origin:nobody.x", "joints are"),
        ("origin:E.w", "name a component"),
        ("lenght:A", "says no parameter"),
    ],
)
def test_unknown_parameters_are_refused(name: str, told: str) -> None:
    with pytest.raises(cd.CardanError, match=told):
        four_bar().sweep(CRANK).derivative(name)


def test_loads_on_links_by_component() -> None:
    loads = {"coupler": cd.Wrench(force=(1.0, 2.0, 0.0), frame="world", point=(0.1, 0.0, 0.0))}
    scene = four_bar(loads=loads)
    sweep = scene.sweep(CRANK)
    more = {"coupler": cd.Wrench(force=(1.0, 3.0, 0.0), frame="world", point=(0.1, 0.0, 0.0))}
    change = all_of(scene.sweep(CRANK, loads=more)) - all_of(sweep)
    found = all_of(sweep.derivative("load:coupler.force_y"))
    assert found == pytest.approx(change, abs=1e-12 * np.abs(change).max())
    assert np.abs(found).max() > 0.1


ARM = """<robot name="arm"><link name="base"/><link name="arm"/><link name="tip"/>
<joint name="A" type="continuous"><parent link="base"/><child link="arm"/>
<axis xyz="0 0 1"/></joint><joint name="flange" type="fixed"><parent link="arm"/><child link="tip"/>
<origin xyz="0.5 0.2 0" rpy="0 0 0.3"/></joint></robot>"""


def rotated(angle: float, vector: Array) -> Array:
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([cosine * vector[0] - sine * vector[1], sine * vector[0] + cosine * vector[1]])


def crossed(first: Array, second: Array) -> float:
    return float(first[0] * second[1] - first[1] * second[0])


@pytest.mark.parametrize("kind", ["link", "world", "spring"])
def test_what_acts_on_a_link_moves_with_the_fixed_joint_that_carries_it(kind: str) -> None:
    angle, force, point, anchor = 0.7, np.array([3.0, 4.0]), np.array([0.1, 0.2]), (0.3, -0.4)
    if kind == "spring":  # Without free length, it pulls to its anchor in proportion.
        ends = "base", (*anchor, 0.0), "tip", (*point, 0.0)
        scene = cd.Scene(cd.load(ARM), drive="A", elements=[cd.PointSpring(*ends, 50.0)])
    else:
        load = cd.Wrench(force=(*force, 0.0), frame=kind, point=(*point, 0.0))
        scene = cd.Scene(cd.load(ARM), drive="A", loads={"tip": load})
    found = scene.sweep(angle).derivative("origin:flange.x", "origin:flange.yaw")
    whole = angle + 0.3
    lever = rotated(angle, np.array([0.5, 0.2])) + rotated(whole, point)
    along = rotated(angle, np.array([1.0, 0.0])), rotated(whole + np.pi / 2.0, point)
    for derivative, moved, turns in zip(found.values(), along, (0.0, 1.0), strict=True):
        if kind == "spring":
            torque = -50.0 * crossed(moved, np.array(anchor))
        elif kind == "world":
            torque = -crossed(moved, force)
        else:
            turned = turns * rotated(whole + np.pi / 2.0, force)
            torque = -crossed(moved, rotated(whole, force)) - crossed(lever, turned)
        assert derivative.drive_effort[0] == pytest.approx(torque, rel=1e-10), kind


@pytest.mark.parametrize("short", [0.1, 0.01, 0.001])
def test_springs_much_shorter_than_the_mechanism(short: float) -> None:
    free, gap = 0.4 * short, np.array([0.6 * short, 0.8 * short])
    arm = ARM.replace("0.5 0.2 0", "0.5 0 0")
    ends = "base", (0.5 + gap[0], gap[1], 0.0), "tip", (0.0, 0.0, 0.0)
    spring = cd.PointSpring(*ends, 100.0, length=free)
    found = cd.Scene(cd.load(arm), drive="A", elements=[spring]).sweep(0.0).derivative("A")
    # Across its line, a spring is as stiff as its force is by its length.
    across = 100.0 * (1.0 - free / short)
    along = gap / short
    force = across * gap
    stiffness = across * np.eye(2) + (100.0 - across) * np.outer(along, along)
    torque = 0.25 * stiffness[1, 1] + 0.5 * force[0]
    assert found.drive_effort[0] == pytest.approx(torque, rel=2e-10)


@pytest.mark.parametrize(
    "pitch", [0.4, 2.0, np.pi, np.pi / 2.0, -np.pi / 2.0, 1.5708, -1.5708, 1.571, 1.57]
)
def test_angles_of_an_origin(pitch: float) -> None:
    """A weight on a hinge whose rotation is written as angles, one of them beyond 90°."""
    roll, yaw, angle, weight = 0.3, 0.2, 0.7, np.array([0.0, 0.0, -5.0])

    def about(axis: int, by: float) -> Array:
        first, second = (axis + 1) % 3, (axis + 2) % 3
        result = np.eye(3)
        result[first, first] = result[second, second] = np.cos(by)
        result[second, first], result[first, second] = np.sin(by), -np.sin(by)
        return result

    def slope_about(axis: int, by: float) -> Array:
        result = about(axis, by + np.pi / 2.0)
        result[axis, axis] = 0.0
        return result

    text = f"""<robot name="arm"><link name="base"/><link name="arm"/>
    <joint name="A" type="continuous"><parent link="base"/><child link="arm"/>
    <origin rpy="{roll} {pitch} {yaw}"/><axis xyz="0 1 0"/></joint></robot>"""
    point = np.array([0.4, 0.3, 0.2])
    load = cd.Wrench(force=weight, frame="world", point=tuple(point))
    sweep = cd.Scene(cd.load(text), drive="A", loads={"arm": load}).sweep(angle)
    # The work of the weight: the drive holds its derivative by the angle.
    arm = slope_about(1, angle) @ point
    turns = [(2, yaw), (1, pitch), (0, roll)]
    for index, name in enumerate(("yaw", "pitch", "roll")):
        parts = [(slope_about if k == index else about)(*turn) for k, turn in enumerate(turns)]
        # All digits that are written of 90° stand for it.
        if name == "pitch" and abs(np.cos(pitch)) < 1e-3:
            with pytest.raises(cd.CardanError, match="pitch of 90°"):
                sweep.derivative("origin:A.pitch")
            continue
        sign = -1.0 if name == "pitch" and np.cos(pitch) < 0.0 else 1.0
        expected = -sign * (weight @ parts[0] @ parts[1] @ parts[2] @ arm)
        found = sweep.derivative(f"origin:A.{name}").drive_effort[0]
        assert found == pytest.approx(expected, abs=1e-13), name


SPINNING = """<robot name="rod"><link name="base"/><link name="crank"/><link name="rod">
<inertial><origin xyz="0.2 0 0"/><mass value="MASS"/>
<inertia ixx="0.01" iyy="0.03" izz="0.03" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="rocker"/><joint name="a" type="continuous"><parent link="base"/>
<child link="crank"/><axis xyz="0 0 1"/></joint><joint name="b" type="spherical">
<parent link="crank"/><child link="rod"/><origin xyz="0 0.1 0.02"/></joint>
<joint name="d" type="continuous"><parent link="base"/><child link="rocker"/>
<origin xyz="0.5 0.05 0.1" rpy="1.2 0.1 0.3"/><axis xyz="0 0 1"/></joint>
<loop name="c" type="spherical"><predecessor link="rod"><origin xyz="0.45 0 0"/></predecessor>
<successor link="rocker"><origin xyz="0.05 0.25 0.05"/></successor></loop></robot>"""


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:rod. loops are open")
def test_how_idle_rods_turn() -> None:
    def swept(by: float = 0.0, more: float = 0.0) -> cd.Sweep:
        scene = cd.Scene(
            cd.load(SPINNING.replace("MASS", repr(1.5 + more))),
            drive="a",
            loads={"d": -2.0},
            gravity=(1.0, 2.0, -9.81),
        )
        return scene.sweep([-0.5 + by, -1.0 + by], speed=3.0, acceleration=2.0)

    def read(of: cd.Sweep | object) -> Array:
        motion = of.motion
        every = [motion.position("b"), motion.position("c"), of["d"].moment]
        every += [motion.velocity("b"), motion.acceleration("b"), motion.acceleration("c")]
        return np.hstack([*every, of.drive_effort[:, None]])

    sweep = swept()
    found = sweep.derivative("a", "mass:rod")
    for name, values in (
        ("a", sloped(lambda by: read(swept(by)), 1e-3)),
        ("mass:rod", sloped(lambda more: read(swept(0.0, more)), 0.1)),
    ):
        size = np.nanmax(np.abs(values))
        assert read(found[name]) == pytest.approx(values, abs=1e-10 * size, nan_ok=True), name
    own = sweep.derivative("load:d").drive_effort
    assert own == pytest.approx(-sweep.motion.ratio("d"), rel=1e-12)
    with pytest.raises(cd.CardanError, match="idle rods"):
        sweep.derivative("origin:b.x")


def every_weight(sweep: cd.Sweep, seed: int) -> dict[str, Array]:
    """Return random weights of all that can be weighted."""
    rng = np.random.default_rng(seed)
    motion, names = sweep.motion, sweep.motion.mechanism.coordinates.columns
    shapes = {f"{name}.{kind}": np.shape(getattr(motion, kind)(name)) for name in names
              for kind in ("position", "velocity", "acceleration")}  # fmt: skip
    shapes |= {f"{name}.holding_effort": sweep.shape for name in sweep.holding_effort}
    shapes["drive_effort"] = np.shape(sweep.drive_effort)
    weights = {name: rng.normal(size=shape) for name, shape in shapes.items()}
    for name in sweep.outputs:
        unique = sweep[name].unique
        weights[f"{name}.force"] = rng.normal(size=(*sweep.shape, 3)) * unique[:3]
        weights[f"{name}.moment"] = rng.normal(size=(*sweep.shape, 3)) * unique[3:]
    return weights


def weighted(found: object, weights: dict[str, Array]) -> list[float]:
    """Return the products of weights and derivatives."""
    products: list[float] = []
    for name, own in weights.items():
        joint, _, kind = name.rpartition(".")
        if kind in ("position", "velocity", "acceleration"):
            values = getattr(found.motion, kind)(joint)
        elif kind == "holding_effort":
            values = found.holding_effort[joint]
        else:
            values = getattr(found[joint], kind) if joint else found.drive_effort
        # What is not unique is NaN, and has no weight.
        products += (own * np.where(own == 0.0, 0.0, values)).ravel().tolist()
    return products


def stewart() -> cd.Sweep:
    legs = [f"leg_{k}" for k in range(1, 7)]
    scene = cd.Scene(cd.load("stewart_platform"), drive=legs, gravity=(0.0, 0.0, -9.81))
    along = np.zeros((2, 3, 6)) + np.linspace(0.0, 0.01, 3)[:, None]
    return scene.sweep(along, speed=[0.1, 0.2, 0.3, 0.1, 0.2, 0.3])


def test_ratios_change_as_velocities_do_that_they_add_up_to() -> None:
    """Both are differentiated apart; of masses, no ratio changes."""
    sweep = stewart()
    speeds = [0.1, 0.2, 0.3, 0.1, 0.2, 0.3]
    found = sweep.derivative("leg_1", "origin:ball_2.successor.x", "speed:leg_3", "mass:platform")
    for name, by in found.items():
        ratios = [by.motion.ratio("base_1_x", f"leg_{k}") for k in range(1, 7)]
        total = sum(speed * ratio for speed, ratio in zip(speeds, ratios, strict=True))
        if "leg_3" in name:
            total = sweep.motion.ratio("base_1_x", "leg_3")
        expected = by.motion.velocity("base_1_x")
        size = np.abs(expected).max()
        np.testing.assert_allclose(total, expected, rtol=0, atol=1e-13 * size, err_msg=name)
        assert (size > 0.0) == np.any(total) == (name != "mass:platform")
        assert np.any(ratios) == (":" not in name or "origin" in name)


SWEEPS: dict[str, tuple[Callable[[], cd.Sweep], tuple[str, ...]]] = {
    "all of a four-bar": (lambda: four_bar().sweep(np.linspace(0.5, 6.0, 9), **GIVEN), ("*",)),
    "factors on masses": (
        lambda: four_bar().sweep(np.linspace(0.5, 6.0, 9), inertia={"coupler": 2.5}, **GIVEN),
        ("A", "mass:*", "centre:*"),
    ),
    "designs": (
        lambda: universal_joint(0.5).sweep(
            PHI, speed=2.0, held={"joint_angle": np.array([[0.2], [0.7]])}
        ),
        ("bearing_in", "joint_angle", "mass:*"),
    ),
    "several orders of elimination": (
        lambda: universal_joint(0.5).sweep(np.linspace(0.0, 6.0, 300)),
        ("bearing_in", "joint_angle", "load:bearing_out"),
    ),
    "balls and several drives": (stewart, ("leg_2", "speed:leg_3", "mass:platform")),
    "elements": (
        lambda: four_bar(**elements()).sweep(np.linspace(0.5, 6.0, 9), **GIVEN),
        ("A", "speed:A", "stiffness:*", "damping:*", "origin:C.*.x", "mass:*", "load:E"),
    ),
    "elements on links whose joints are elsewhere": (
        lambda: four_bar(**elements(), held={"origin:B.x": 0.0}).sweep(
            [0.5, 4.0], held={"origin:B.x": 0.01}, **GIVEN
        ),
        ("origin:A.*", "origin:B.x", "origin:B.y", "origin:E.*"),
    ),
    "elements at joints alone": (
        lambda: four_bar(elements=elements()["elements"][1:]).sweep([0.5, 4.0], **GIVEN),
        ("A", "origin:A.y", "origin:E.*", "mass:coupler"),
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", SWEEPS)
def test_backwards_is_the_same_as_forwards(case: str) -> None:
    swept, names = SWEEPS[case]
    sweep = swept()
    weights = every_weight(sweep, 3)
    found, slopes = sweep.derivative(*names), sweep.gradient(weights, *names)
    assert list(slopes) == list(found)
    sizes = {name: np.abs(weighted(of, weights)).sum() for name, of in found.items()}
    for name, slope in slopes.items():
        # Where nothing changes, rounding is that of others.
        size = sizes[name] + 1e-9 * max(sizes.values())
        tolerance = 1e-11 if case.startswith("elements") else 1e-13
        assert abs(slope - sum(weighted(found[name], weights))) <= tolerance * size, name
    assert max(sizes.values()) > 1.0


@pytest.mark.slow
@pytest.mark.parametrize("case", SWEEPS)
def test_balances_of_the_proof_hold_for_derivatives(case: str) -> None:
    swept, names = SWEEPS[case]
    found = swept().derivative(*names)
    assert max(of.loop_residual for of in found.values()) < 1e-12
    balances = [of.balance_residual for of in found.values()]
    known = [balance for balance in balances if not np.isnan(balance)]
    assert 0.0 < max(known) < (1e-10 if case.startswith("elements") else 1e-13)
    # Nothing changes with what a fixed link weighs, and the like.
    assert len(known) > len(found) / 2


def test_the_proof_takes_steps_that_suit_a_small_mechanism() -> None:
    """Friction changes within what a mechanism as small as this moves in a second."""
    slide = f"""<robot name="slide"><link name="base"/>
{link("rod", 1.0, 1e-3, 0.0, 1.0)}
<joint name="A" type="prismatic"><parent link="base"/><child link="rod"/><axis xyz="1 0 0"/>
</joint></robot>"""
    rubbing = cd.JointFriction("A", 2.4, 0.0016)
    scene = cd.Scene(cd.load(slide), drive="A", elements=[rubbing])
    by = scene.sweep([0.0, 1e-3, 2e-3], speed=[4.6e-3, 1e-3, -6e-3]).derivative("speed:A")
    assert by.drive_effort.min() > 10.0
    assert by.balance_residual < 1e-12


def wrong_gravity(vector: tuple[object, ...], factor: object) -> tuple[object, ...]:
    return tuple(part * -factor for part in vector)


def test_the_proof_finds_derivatives_that_are_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    from cardan_dyn.core.dynamics import differentiated

    right = four_bar().sweep(CRANK, **GIVEN).derivative("mass:coupler")
    assert right.balance_residual < 1e-14
    monkeypatch.setattr(differentiated, "times", wrong_gravity)
    # Of another mechanism: this one's equations are traced already.
    wrong = four_bar(0.4 + 1e-12).sweep(CRANK, **GIVEN).derivative("mass:coupler")
    assert wrong.balance_residual > 0.1
    assert abs(wrong.drive_effort[0] - OF_TORQUE["mass:coupler"]) > 0.1


def test_gradients_are_the_reference_derivatives() -> None:
    sweep = four_bar().sweep(CRANK, **GIVEN)
    slopes = sweep.gradient({"drive_effort": 1.0}, *OF_TORQUE)
    for name, expected in OF_TORQUE.items():
        assert slopes[name] == pytest.approx(expected, rel=1e-12), name
    # Of the size of the force at C, by components in its own axes.
    force = sweep["C"].force[:, :2]
    size = np.linalg.norm(force)
    weights = {"C.force_x": force[:, 0] / size, "C.force_y": force[:, 1] / size}
    slopes = sweep.gradient(weights, *OF_SIZE)
    assert slopes == pytest.approx(OF_SIZE, rel=1e-12)


def test_patterns_stand_for_what_has_a_derivative() -> None:
    sweep = four_bar().sweep(CRANK, **GIVEN)
    kept = [f"origin:C.{end}.{part}" for end in ("predecessor", "successor") for part in ("x", "y")]
    assert [name for name in sweep.derivative("origin:C*") if "yaw" not in name] == kept
    assert list(sweep.gradient({"drive_effort": 1.0}, "origin:C*.x")) == kept[::2]
    assert list(sweep.gradient({"drive_effort": 1.0}, "mass:c*")) == ["mass:crank", "mass:coupler"]
    assert list(sweep.derivative("mass:crank*")) == ["mass:crank"]
    for read in (sweep.derivative, lambda *names: sweep.gradient({"drive_effort": 1.0}, *names)):
        with pytest.raises(cd.CardanError, match="matches no parameter"):
            read("mass:z*")
        with pytest.raises(cd.CardanError, match="opens a loop"):
            read("mass:crank", "origin:E.z")
        with pytest.raises(cd.CardanError, match="name the parameters"):
            read()
        with pytest.raises(cd.CardanError, match="named by strings"):
            read(3)


@pytest.mark.parametrize(
    ("weights", "told"),
    [
        ({"effort": 1.0}, "says no result"),
        ({"nobody.force": 1.0}, "no output 'nobody'"),
        ({"nobody.position": 1.0}, "nobody"),
        ({"B.force": 1.0}, "does not follow from the laws of motion"),
        ({"B.force_z": 1.0}, "does not follow from the laws of motion"),
        ({"drive_effort": [1.0, 2.0]}, "does not broadcast"),
        ({"drive_effort": float("nan")}, "not finite"),
        ({"E.holding_effort": 1.0}, "known are those of"),
        ({"E.coupling_moment": 1.0}, "couplings are"),
        ({"B.drive_effort": 1.0}, "drives are"),
        (["drive_effort"], "mapping"),
    ],
)
def test_weights_that_say_nothing_are_refused(weights: object, told: str) -> None:
    with pytest.raises(cd.CardanError, match=told):
        four_bar().sweep(CRANK).gradient(weights, "mass:coupler")


def test_copies_differentiate_alike() -> None:
    sweep = four_bar().sweep(np.linspace(0.5, 6.0, 5), **GIVEN)
    copy = pickle.loads(pickle.dumps(sweep))
    names = "A", "origin:C.successor.x", "mass:coupler"
    own, theirs = (of.derivative(*names) for of in (sweep, copy))
    for name in names:
        np.testing.assert_array_equal(own[name].drive_effort, theirs[name].drive_effort)
        again = pickle.loads(pickle.dumps(own[name]))
        np.testing.assert_array_equal(again["C"].force, own[name]["C"].force)


def test_friction_is_linear_in_its_effort() -> None:
    def swept(effort: float) -> Array:
        friction = cd.JointFriction("E", effort, transition=0.1, name="rub")
        scene = four_bar(elements=[friction])
        return scene.sweep(np.linspace(0.5, 6.0, 9), **GIVEN).drive_effort

    friction = cd.JointFriction("E", 2.0, transition=0.1, name="rub")
    sweep = four_bar(elements=[friction]).sweep(np.linspace(0.5, 6.0, 9), **GIVEN)
    found = sweep.derivative("friction:rub").drive_effort
    change = swept(3.0) - swept(2.0)
    assert found == pytest.approx(change, abs=1e-11 * np.abs(change).max())
    with pytest.raises(cd.CardanError, match="no stiffness that is a number"):
        sweep.derivative("stiffness:rub")


def test_friction_of_pins_by_their_own_bearing_forces() -> None:
    """Friction m = G(m, p) of what the pins bear changes by (1 - G_m)⁻¹ G_p.

    Coulomb's law needs no element for that: it is solved, and differentiated, around the sweep. The
    torque at 30°, with friction of 0.1 on a quarter of the cross's radius, and how it changes with
    the coefficient, the joint angle and the input angle: a closed form, of 40 digits.
    """
    lever, friction, pins = 0.25, 0.1, ("pin_in", "pin_out")
    angle = np.radians(30.0)
    loads = [f"load:{pin}" for pin in pins]
    # Against how the cross turns on the input's fork, and the output's fork on the cross.
    sign = np.array([-1.0, 1.0])
    scene = universal_joint(angle).replace(outputs=[*pins])

    def at(moments: Array) -> tuple[cd.Sweep, Array]:
        own = dict(zip(pins, moments, strict=True))
        sweep = scene.sweep(angle, loads={"bearing_out": -TORQUE, **own})
        return sweep, np.array([sweep[pin].bending[0] for pin in pins])

    def slopes(sweep: cd.Sweep, by: cd.Derivative) -> Array:
        """Return how fast what the pins bear across their axes grows."""
        across = [np.delete(sweep[pin].moment[0], k) for pin, k in zip(pins, (1, 2), strict=True)]
        changes = [np.delete(by[pin].moment[0], k) for pin, k in zip(pins, (1, 2), strict=True)]
        pairs = zip(across, changes, strict=True)
        return np.array([moment @ change / np.linalg.norm(moment) for moment, change in pairs])

    moments = np.zeros(2)
    for _ in range(6):
        sweep, borne = at(moments)
        found = sweep.derivative(*loads, "joint_angle", "bearing_in")
        own = np.column_stack([slopes(sweep, found[name]) for name in loads])
        matrix = np.eye(2) - (sign * lever * friction)[:, None] * own
        moments = moments + np.linalg.solve(matrix, sign * lever * friction * borne - moments)
    sweep, borne = at(moments)
    assert moments == pytest.approx([-2.808102875113, 2.808102875113], abs=1e-12)
    assert sweep.drive_effort[0] == pytest.approx(108.6626170929832, rel=1e-14)
    by_moments = np.array([found[name].drive_effort[0] for name in loads])
    pushed = {
        "friction": (0.0, sign * lever * borne),
        **{
            name: (by.drive_effort[0], sign * lever * friction * slopes(sweep, by))
            for name, by in found.items()
            if name not in loads
        },
    }
    told = {
        name: direct + by_moments @ np.linalg.solve(matrix, right)
        for name, (direct, right) in pushed.items()
    }
    expected = {
        "friction": 21.01417798440156,
        "joint_angle": 28.7446447813123,
        "bearing_in": -28.54516791088958,
    }
    assert told == pytest.approx(expected, rel=1e-12)


def test_more_than_memory_is_refused_before(monkeypatch: pytest.MonkeyPatch) -> None:
    sweep = four_bar().sweep(np.linspace(0.0, 6.0, 20_000))
    monkeypatch.setattr("os.sysconf", lambda _: 1000)
    with pytest.raises(cd.CardanError, match="name fewer parameters"):
        sweep.derivative("mass:*", "centre:*", "inertia:*")


def test_samples_that_several_orders_of_elimination_serve() -> None:
    """Where one order ends, another one goes on: what the first makes of these samples is nothing.

    A shaft that tilts behind a joint, over a turn.
    """
    rig = cd.load("elastic_thoma_rig")
    names = ["bearing_in", *rig.joint_springs]
    scene = cd.Scene(rig, drive=names, held={"joint_angle": 0.15}, outputs=[])
    random = np.random.default_rng(0)
    turn = np.linspace(0.0, 2.0 * np.pi, 21)
    states = np.column_stack([turn, 0.01 * random.normal(size=(21, 2))])
    moves = random.normal(size=(2, *states.shape))
    by = scene.sweep(states, *moves).derivative("tilt_y").drive_effort
    way = 1e-5 * (np.array(names) == "tilt_y")
    ends = [scene.sweep(states + sense * way, *moves).drive_effort for sense in (1.0, -1.0)]
    assert by == pytest.approx((ends[0] - ends[1]) / 2e-5, abs=1e-7 * np.abs(by).max())
