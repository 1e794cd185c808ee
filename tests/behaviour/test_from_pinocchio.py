"""Models that Pinocchio's users have, with their constraints."""

from __future__ import annotations

import copy
import importlib.util
import pickle
import sys
import types
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pinocchio as pin
import pytest
from testkit.bundled import EVERY_KIND

import cardan_dyn as cd
from cardan_dyn.core.description.second_reading import reread
from cardan_dyn.core.mechanism.rezero import rezeroed
from cardan_dyn.core.mechanism.tree import joint_model
from cardan_dyn.scene.presets import PRESETS

# Chains that are open at zero have two assemblies beside it, of which `describe` tells.
pytestmark = [
    pytest.mark.filterwarnings("ignore:.*two assemblies lie beside it"),
    pytest.mark.usefixtures("loaded_once"),
]

WEIGHT = np.array([0.3, -0.2, -9.0])


def linkage(joints: dict[str, pin.JointModel], seed: int = 0) -> tuple[pin.Model, list[int]]:
    """Return a chain of joints with random bodies."""
    random = np.random.default_rng(seed)
    model, ids = pin.Model(), [0]
    for name, joint in joints.items():
        placement = pin.exp6(random.uniform(-0.5, 0.5, 6))
        ids.append(model.addJoint(ids[-1], joint, placement, name))
        lever, root = random.uniform(-0.3, 0.3, 3), random.uniform(-0.3, 0.3, (3, 3))
        spread = root @ root.T
        tensor = np.trace(spread) * np.eye(3) - spread
        inertia = pin.Inertia(1.0 + random.random(), lever, tensor)
        place = pin.exp6(random.uniform(-0.5, 0.5, 6))
        model.appendBodyToJoint(ids[-1], inertia, pin.SE3.Identity())
        model.addFrame(pin.Frame(f"{name}_body", ids[-1], place, pin.FrameType.BODY))
        model.addFrame(
            pin.Frame(f"{name}_tool", ids[-1], place * place, pin.FrameType.OP_FRAME), False
        )
    model.name = "chain"
    return model, ids


HINGES = ["RX", "RY", "RZ", "RevoluteUnaligned", "RUBX", "RevoluteUnboundedUnaligned"]


def joint(kind: str) -> pin.JointModel:
    axis = np.array([0.6, 0.0, 0.8])
    made = getattr(pin, f"JointModel{kind}")
    if kind == "RevoluteUnboundedUnaligned":
        return joint_model("continuous", axis)
    if "Unaligned" in kind:
        return made(axis, 0.04) if "Helical" in kind else made(axis)
    if kind == "Universal":
        return made(axis, np.array([0.0, 1.0, 0.0]))
    return made(0.04) if kind.startswith("H") else made()


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    "kind",
    [
        *HINGES,
        *("PX", "PY", "PZ", "PrismaticUnaligned", "HX", "HelicalUnaligned", "Universal"),
        *("Translation", "Planar"),
    ],
)
def test_open_chains_against_rnea(kind: str, seed: int) -> None:
    """Efforts of all coordinates, and of those that make up one of Pinocchio's joints."""
    joints = {"first": joint("RZ"), "joint": joint(kind), "last": joint("RevoluteUnaligned")}
    model, _ = linkage(joints, seed)
    mechanism = cd.from_pinocchio(model)
    drives = [name for name in mechanism.coordinates.named if name != "joint_slide"]
    if kind in ("Translation", "Universal", "Planar"):
        drives = list(mechanism.coordinates.named)
    random = np.random.default_rng(seed + 10)
    x, speed, acceleration = random.uniform(-0.4, 0.4, (3, len(drives)))
    scene = cd.Scene(mechanism, drive=drives, gravity=WEIGHT)
    swept = scene.sweep(x, speed=speed, acceleration=acceleration)
    assert max(swept.balance_residual, swept.power_residual) < 1e-13
    model.gravity.linear = WEIGHT
    q = pin.neutral(model)
    if kind.startswith("RUB") or "Unbounded" in kind:
        index = model.idx_qs[model.getJointId("joint")]
        q[index : index + 2] = np.cos(x[1]), np.sin(x[1])
        q[0], q[-1] = x[0], x[-1]
    elif kind == "Planar":
        first, second = mechanism["joint"].parts[:2]
        # Slides of ours are along other axes of the plane than Pinocchio's.
        place = x[1] * first.axis + x[2] * second.axis
        q[:] = x[0], *place[:2], np.cos(x[3]), np.sin(x[3]), x[4]
        turn = np.array([[np.cos(x[3]), np.sin(x[3])], [-np.sin(x[3]), np.cos(x[3])]])
        across = np.array([first.axis[:2], second.axis[:2]]).T
        speed[1:3], acceleration = speed[1:3], acceleration.copy()
        moved = across @ speed[1:3]
        spin = speed[3]
        rates = turn @ moved
        changes = turn @ (across @ acceleration[1:3]) - spin * np.array([-rates[1], rates[0]])
        v = np.array([speed[0], *rates, spin, speed[4]])
        a = np.array([acceleration[0], *changes, acceleration[3], acceleration[4]])
        tau = pin.rnea(model, model.createData(), q, v, a)
        expected = [tau[0], *(across.T @ turn.T @ tau[1:3]), tau[3], tau[4]]
        np.testing.assert_allclose(swept.drive_effort[0], expected, rtol=1e-11, atol=1e-11)
        return
    else:
        q[:] = x
    tau = pin.rnea(model, model.createData(), q, speed, acceleration)
    np.testing.assert_allclose(swept.drive_effort[0], tau, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("name", EVERY_KIND)
def test_models_of_mechanisms(name: str) -> None:
    """Loops are welds there, so only what is unique can be the same."""
    mechanism, preset = cd.load(name), PRESETS[name]
    again = cd.from_pinocchio(mechanism.model, mechanism.constraint_models, strict=False)
    sweeps = []
    for item in (mechanism, again):
        scene = cd.Scene(
            item, drive=list(preset.drive), held=dict.fromkeys(preset.held_deg, 0.1), gravity=WEIGHT
        )
        steps = np.linspace(0.0, 0.1, 4)[:, None] * np.ones(len(preset.drive)) / len(preset.drive)
        sweeps.append(scene.sweep(steps, speed=2.0, acceleration=1.0))
    one, other = sweeps
    assert max(other.balance_residual, other.loop_residual) < 1e-13
    size = np.max(np.abs(one.drive_effort))
    np.testing.assert_allclose(one.drive_effort, other.drive_effort, atol=1e-9 * size)


def closed_chain(seed: int) -> tuple[pin.Model, np.ndarray, pin.RigidConstraintModel]:
    """Return a chain of five hinges whose end a ball holds, and where it does."""
    model, ids = linkage({f"j{k}": joint(HINGES[k % 4]) for k in range(5)}, seed)
    random = np.random.default_rng(seed)
    closed = random.uniform(-0.3, 0.3, model.nq)
    data = model.createData()
    pin.forwardKinematics(model, data, closed)
    here = pin.exp6(random.uniform(-0.2, 0.2, 6))
    ends = ids[-1], here, 0, data.oMi[ids[-1]] * here
    return model, closed, pin.RigidConstraintModel(pin.ContactType.CONTACT_3D, model, *ends)


def driven(mechanism: cd.Mechanism, closed: np.ndarray) -> cd.Scene:
    near = {f"j{k}": float(closed[k]) for k in range(5)}
    return cd.Scene(mechanism, drive=["j0", "j1"], near=near, gravity=WEIGHT)


@pytest.mark.parametrize(
    ("seed", "contact"), [(0, "rigid"), (1, "anchor"), (2, "wrapped"), (3, "rigid")]
)
def test_closed_chains_against_constraint_dynamics(seed: int, contact: str) -> None:
    """Efforts of a sweep give the accelerations of that sweep, by Pinocchio's own algorithm."""
    model, closed, constraint = closed_chain(seed)
    given = constraint
    if contact != "rigid":
        ends = (
            *(constraint.joint1_id, constraint.joint1_placement),
            *(constraint.joint2_id, constraint.joint2_placement),
        )
        given = pin.PointAnchorConstraintModel(model, *ends)
        if contact == "wrapped":
            given = pin.ConstraintModel(given)
    wrapper = pin.RobotWrapper(model)
    mechanism = cd.from_pinocchio(wrapper, [given], actuated=["j0", "j1"])
    assert mechanism.independent_joints == ("j0", "j1")
    assert cd.describe(mechanism).mobility == 2
    scene = driven(mechanism, closed)
    swept = scene.sweep(closed[:2], speed=[1.0, -2.0], acceleration=[0.5, 3.0])
    assert max(swept.balance_residual, swept.loop_residual) < 1e-12
    q, v, a = (
        np.array([getattr(swept.motion, rate)(f"j{k}")[0] for k in range(5)])
        for rate in ("position", "velocity", "acceleration")
    )
    model.gravity.linear = WEIGHT
    tau = np.zeros(model.nv)
    tau[:2] = swept.drive_effort[0]
    data, constraint.m_baumgarte_parameters.Kp = model.createData(), 0.0
    constraints, datas = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
    constraints.append(constraint)
    datas.append(constraint.createData())
    pin.initConstraintDynamics(model, data, constraints, datas)
    settings = pin.ProximalSettings(1e-14, 1e-12, 50)
    found = pin.constraintDynamics(model, data, q, v, tau, constraints, datas, settings)
    np.testing.assert_allclose(found, a, rtol=1e-7, atol=1e-7 * np.max(np.abs(a)))


@pytest.mark.slow
def test_copies_threads_and_another_zero() -> None:
    """What is made of a mechanism of a model is proven by the numbers that it then has."""
    model, closed, constraint = closed_chain(1)
    mechanism = cd.from_pinocchio(model, [constraint], actuated="j0")
    assert mechanism.independent_joints == ("j0",)
    swept = driven(mechanism, closed).sweep(closed[:2], speed=1.0)
    constraint.joint1_placement = pin.SE3.Random()  # The mechanism has its own.
    others = [
        copy.deepcopy(mechanism),
        pickle.loads(pickle.dumps(mechanism)),
        cd.from_pinocchio(model, [closed_chain(1)[2]]),
    ]
    with ThreadPoolExecutor(3) as pool:
        efforts = [
            again.drive_effort
            for again in pool.map(
                lambda item: driven(item, closed).sweep(closed[:2], speed=1.0), others
            )
        ]
    for effort in efforts:
        np.testing.assert_array_equal(effort, swept.drive_effort)
    at = {name: swept.motion.position(name)[0] for name in mechanism}
    moved = cd.Mechanism(rezeroed(mechanism.description, at, mechanism.characteristic_length))
    again = cd.Scene(moved, drive=["j0", "j1"], gravity=WEIGHT).sweep([0.0, 0.0], speed=1.0)
    assert again.balance_residual < 1e-13
    np.testing.assert_allclose(again.drive_effort, swept.drive_effort, rtol=1e-11, atol=1e-11)


def test_screws_within_composites_are_coupled() -> None:
    composite = pin.JointModelComposite()
    composite.addJoint(pin.JointModelRY(), pin.exp6(np.full(6, 0.1)))
    composite.addJoint(pin.JointModelHZ(0.05), pin.exp6(np.full(6, 0.2)))
    model, _ = linkage({"first": joint("RZ"), "both": composite})
    mechanism = cd.from_pinocchio(model)
    assert list(mechanism) == ["first", "both_1", "both_2", "both"]
    assert cd.describe(mechanism).mobility == 3
    scene = cd.Scene(mechanism, drive=["first", "both_1", "both_2"], gravity=WEIGHT)
    x, v, a = np.random.default_rng(0).uniform(-0.5, 0.5, (3, 3))
    swept = scene.sweep(x, speed=v, acceleration=a)
    model.gravity.linear = WEIGHT
    tau = pin.rnea(model, model.createData(), x, v, a)
    np.testing.assert_allclose(swept.drive_effort[0], tau, rtol=1e-12)


def test_composites_are_joints_in_a_row() -> None:
    composite = pin.JointModelComposite()
    places = [
        pin.exp6(np.array(part)) for part in ([0.1, 0.2, 0, 0.3, 0, 0.1], [0.0, 0.1, 0.3] * 2)
    ]
    for part, place in zip((pin.JointModelRY(), pin.JointModelPZ()), places, strict=True):
        composite.addJoint(part, place)
    model, _ = linkage({"first": joint("RZ"), "both": composite})
    mechanism = cd.from_pinocchio(model)
    assert list(mechanism) == ["first", "both_1", "both"]
    scene = cd.Scene(mechanism, drive=list(mechanism), gravity=WEIGHT)
    x, v, a = np.random.default_rng(0).uniform(-0.5, 0.5, (3, 3))
    swept = scene.sweep(x, speed=v, acceleration=a)
    model.gravity.linear = WEIGHT
    tau = pin.rnea(model, model.createData(), x, v, a)
    np.testing.assert_allclose(swept.drive_effort[0], tau, rtol=1e-12)


@pytest.mark.parametrize(
    ("least", "greatest"), [(-6.0, 9.0), (-9.0, 9.0), (-np.inf, 9.0), (-6.0, np.inf), (2.0, 3.0)]
)
def test_each_sense_of_effort_has_its_limit(least: float, greatest: float) -> None:
    model, _ = linkage({"ram": pin.JointModelPZ()})
    ends = np.nan_to_num([least, greatest])  # Pinocchio's word for none is the greatest number.
    model.lowerEffortLimit[:], model.upperEffortLimit[:] = ends
    (joint,) = cd.from_pinocchio(model).description.joints
    assert joint.limits.efforts == (least, greatest)


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_joints_that_mimic_others(kind: str) -> None:
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    link = '<link name="{}"><inertial><mass value="2"/>{}</inertial></link>'
    moments = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    robot = f"""<robot name="m"><link name="a"/>{link.format("b", moments)}
        {link.format("c", moments)}
        <joint name="j" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0 0 1"/>
        <axis xyz="1 0 0"/>{limit}</joint>
        <joint name="k" type="{kind}"><parent link="b"/><child link="c"/><origin xyz="0 1 0"/>
        <axis xyz="0.6 0 0.8"/>{limit}<mimic joint="j" multiplier="-2" offset="0.1"/></joint>
        </robot>"""
    model = pin.buildModelFromXML(robot, mimic=True)
    mechanism = cd.from_pinocchio(model)
    (coupling,) = mechanism.description.couplings
    assert (coupling.predecessor, coupling.successor) == ("j", "k")
    assert (coupling.ratio, coupling.offset) == (-2.0, 0.1)
    swept = cd.Scene(mechanism, drive="j", gravity=WEIGHT).sweep(0.3, speed=1.0, acceleration=2.0)
    assert swept.balance_residual < 1e-14
    model.gravity.linear = WEIGHT
    tau = pin.rnea(model, model.createData(), np.array([0.3]), np.array([1.0]), np.array([2.0]))
    np.testing.assert_allclose(swept.drive_effort, tau, rtol=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_the_proof_reads_the_model_by_other_functions(seed: int) -> None:
    kinds = {
        k: joint(kind)
        for k, kind in zip(
            "abcd", ["RX", "PrismaticUnaligned", "Universal", "Spherical"], strict=True
        )
    }
    model, ids = linkage(kinds, seed)
    weld = pin.RigidConstraintModel(
        pin.ContactType.CONTACT_6D, model, ids[-1], pin.exp6(np.full(6, 0.1)), 0, pin.SE3.Random()
    )
    description = cd.from_pinocchio(model, [weld]).description
    again = reread(description)
    for part in ("links", "joints", "loops"):
        for one, other in zip(getattr(description, part), getattr(again, part), strict=True):
            assert one is not other
            for name, value in vars(one).items():
                if isinstance(value, np.ndarray):
                    np.testing.assert_allclose(getattr(other, name), value, atol=1e-13)
                elif isinstance(value, float):
                    assert getattr(other, name) == pytest.approx(value, rel=1e-13)


def test_a_mechanism_of_a_model_is_written_and_pickled() -> None:
    model, _ = linkage({"a": joint("RX"), "b": joint("PY")})
    mechanism = cd.from_pinocchio(model)
    assert set(mechanism.description.frames) >= {"a_tool", "b_tool"}
    expected = cd.Scene(mechanism, drive=["a", "b"], gravity=WEIGHT).sweep([0.1, 0.2]).drive_effort
    for item in (pickle.loads(pickle.dumps(mechanism)), cd.load(mechanism.to_urdf())):
        found = cd.Scene(item, drive=["a", "b"], gravity=WEIGHT).sweep([0.1, 0.2]).drive_effort
        np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_robots_of_robot_descriptions_have_names(monkeypatch: pytest.MonkeyPatch) -> None:
    """By the functions of that package, which loads its robots from the internet."""
    if importlib.util.find_spec("robot_descriptions") is None:
        with pytest.raises(cd.ArgumentError, match="pip install robot_descriptions"):
            cd.from_pinocchio("arm_description")
    model, _ = linkage({"a": pin.JointModelRX(), "b": pin.JointModelPZ()})
    package, loader = (
        types.ModuleType(name)
        for name in ("robot_descriptions", "robot_descriptions.loaders.pinocchio")
    )
    package.DESCRIPTIONS = {"arm_description": object(), "leg_description": object()}
    loader.load_robot_description = {"arm_description": pin.RobotWrapper(model)}.__getitem__
    for name, module in (
        (package.__name__, package),
        ("robot_descriptions.loaders", types.ModuleType("robot_descriptions.loaders")),
        (loader.__name__, loader),
    ):
        monkeypatch.setitem(sys.modules, name, module)
    assert cd.from_pinocchio("arm_description").description == cd.from_pinocchio(model).description
    with pytest.raises(cd.ModelError, match=r"robot 'arm' does not exist.*arm_description"):
        cd.from_pinocchio("arm")


def test_what_is_refused() -> None:
    model, ids = linkage({"a": joint("RX"), "b": joint("PY")})
    with pytest.raises(cd.ArgumentError, match=r"takes a pin\.Model, not 4"):
        cd.from_pinocchio(4)  # type: ignore[arg-type]
    with pytest.raises(cd.ModelError, match="joint 'c' does not exist; joints: a, b"):
        cd.from_pinocchio(model, actuated=["c"])
    with pytest.raises(cd.ModelError, match="of 0 rows closes no loop here"):
        cd.from_pinocchio(model, [pin.JointLimitConstraintModel(model, [1])])
    same = pin.RigidConstraintModel(
        pin.ContactType.CONTACT_3D, model, ids[1], pin.SE3.Identity(), ids[1], pin.SE3.Identity()
    )
    with pytest.raises(cd.ModelError, match="already make one body"):
        cd.from_pinocchio(model, [same])
    for contact, name, value in (
        (pin.RigidConstraintModel, "desired_contact_placement", pin.SE3.Random()),
        (pin.RigidConstraintModel, "desired_contact_velocity", pin.Motion.Random()),
        (pin.PointAnchorConstraintModel, "desired_constraint_offset", np.ones(3)),
    ):
        kind = (pin.ContactType.CONTACT_3D,) * (contact is pin.RigidConstraintModel)
        placed = ids[1], pin.SE3.Identity(), ids[2], pin.SE3.Identity()
        constraint = contact(*kind, model, *placed)
        setattr(constraint, name, value)
        with pytest.raises(cd.ModelError, match=f"{name} is not read: place its two ends"):
            cd.from_pinocchio(model, [constraint])


def test_what_has_an_inertia_and_no_mass_is_told() -> None:
    model = pin.Model()
    index = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "j")
    model.appendBodyToJoint(index, pin.Inertia(0.0, np.zeros(3), np.eye(3)), pin.SE3.Identity())
    with pytest.raises(cd.ModelError, match="mass 0 kg is not positive"):
        cd.from_pinocchio(model)
    mechanism = cd.from_pinocchio(model, strict=False)
    (warning,) = mechanism.warnings
    assert warning.endswith("link 'j_link': mass 0 kg: an inertia without mass")
    turn = cd.Scene(mechanism, drive="j").sweep([0.1], speed=2.0, acceleration=3.0)
    np.testing.assert_allclose(turn.drive_effort, 3.0, rtol=1e-14)
    model.inertias[index] = pin.Inertia(float("nan"), np.zeros(3), np.eye(3))
    with pytest.raises(cd.ModelError, match="mass nan kg is not positive"):
        cd.from_pinocchio(model, strict=False)


def test_reference_configurations_are_near_by_name() -> None:
    """Bodies are where Pinocchio places them, whatever its joints are made of."""
    model = pin.Model()
    screw = pin.JointModelComposite(2)
    screw.addJoint(pin.JointModelHX(0.1))
    screw.addJoint(pin.JointModelRevoluteUnaligned(*np.array([0.6, 0.0, 0.8])), pin.SE3.Random())
    kinds = [
        *(pin.JointModelFreeFlyer(), pin.JointModelRY(), pin.JointModelSpherical(), screw),
        *(pin.JointModelSphericalZYX(), pin.JointModelPlanar(), pin.JointModelRUBZ()),
        *(pin.JointModelTranslation(), pin.JointModelPZ()),
    ]
    for parent, kind in enumerate(kinds):
        index = model.addJoint(parent, kind, pin.SE3.Random(), f"j{parent}")
        model.appendBodyToJoint(index, pin.Inertia.Random(), pin.SE3.Identity())
        model.addBodyFrame(f"b{parent}", index, pin.SE3.Random(), 0)
    bound = np.ones(model.nq)
    q = pin.randomConfiguration(model, -bound, bound)
    model.referenceConfigurations["ready"] = q
    mechanism = cd.from_pinocchio(model, strict=False)
    assert list(mechanism.description.keyframes) == ["ready"]
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    found = cd.assemble(mechanism, near="ready")
    for number in range(len(kinds)):
        expected = data.oMf[model.getFrameId(f"b{number}")]
        np.testing.assert_allclose(found.point(f"b{number}"), expected.translation, atol=1e-12)
        np.testing.assert_allclose(found.orientation(f"b{number}"), expected.rotation, atol=1e-12)
    with pytest.raises(cd.ArgumentError, match=r"no keyframe 'redy'.*mean 'ready'"):
        cd.assemble(mechanism, near="redy")
    model.referenceConfigurations["short"] = q[1:]
    with pytest.raises(cd.ModelError, match=r"reference configuration 'short' is not \d+ finite"):
        cd.from_pinocchio(model, strict=False)
