"""The proof is handed something false of every kind, and refuses it."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from testkit.scenes import text

import cardan_dyn as cd
from cardan_dyn.proof.free_bodies import FreeBodies
from cardan_dyn.proof.residuals import Claim

POSITIONS = np.linspace(0.2, 1.4, 30)
GRAVITY = (1.0, -2.0, -9.0)
RATES = {"speed": 3.0, "acceleration": 2.0}


def universal(**options: object) -> cd.Scene:
    loads = {"bearing_out": -5.0, "shaft_out": cd.Wrench([1.0, 2.0, 3.0], [0.5, 0.0, 1.0])}
    given = {"drive": "bearing_in", "held": {"joint_angle": 0.8}, "loads": loads}
    return cd.Scene(cd.load("universal_joint"), **{**given, "gravity": GRAVITY, **options})


def four_bar(**options: object) -> cd.Scene:
    given = {"drive": "crank_bearing", "gravity": GRAVITY, "loads": {"rocker_bearing": -5.0}}
    return cd.Scene(cd.load("four_bar"), **{**given, **options})


def spatial(**options: object) -> cd.Scene:
    angles = (("1_h", 0.4), ("1_v", 0.1), ("2_h", 0.3), ("2_v", -0.2))
    held = {f"joint_angle_{name}": angle for name, angle in angles}
    given = {"drive": "bearing_in", "held": held, "gravity": GRAVITY, "loads": {"bearing_out": -3}}
    return cd.Scene(cd.load("double_shaft_spatial"), **{**given, **options})


def geared(**options: object) -> cd.Scene:
    """Two wheels on a swinging arm, one of which carries a mass that a fixed loop holds."""
    inertia = '<mass value="2"/><inertia ixx="1" iyy="1" izz="1"/>'
    mass = f'<inertial><origin xyz="0.2 0 0.1"/>{inertia}</inertial>'
    text = f"""<robot name="gears"><link name="base"/><link name="arm">{mass}</link>
      <link name="first">{mass}</link><link name="second">{mass}</link>
      <link name="bob">{mass}</link>
      <joint name="swing" type="continuous"><parent link="base"/><child link="arm"/>
        <axis xyz="0 1 0"/></joint>
      <joint name="in" type="continuous"><parent link="arm"/><child link="first"/>
        <axis xyz="0 0 1"/></joint>
      <joint name="out" type="continuous"><parent link="arm"/><child link="second"/>
        <origin xyz="1 0 0"/><axis xyz="0 0 1"/></joint>
      <joint name="hang" type="planar"><parent link="second"/><child link="bob"/>
        <axis xyz="0 0 1"/></joint>
      <loop name="bolt" type="fixed"><predecessor link="second"/><successor link="bob"/></loop>
      <coupling name="gear"><predecessor link="first"/><successor link="second"/>
        <ratio value="-2"/></coupling></robot>"""
    given = {"drive": ["in", "swing"], "gravity": GRAVITY, "loads": {"out": -3.0}}
    return cd.Scene(cd.load(text), **{**given, **options})


SCENES = {"universal": universal, "four-bar": four_bar, "spatial": spatial, "gears": geared}


def positions(scene: cd.Scene) -> np.ndarray:
    return np.stack([(k + 1.0) * POSITIONS for k in range(len(scene.drives))], axis=1)


def claimed(scene: cd.Scene, **rates: float) -> tuple[FreeBodies, Claim, np.ndarray]:
    """Return the proof, and the claim that a sweep hands to it."""
    seen: list[Claim] = []
    bodies = scene._solver.inverse_dynamics.bodies
    check = bodies.check

    def watched(claim: Claim) -> object:
        seen.append(claim)
        return check(claim)

    bodies.check = watched
    try:
        scene.sweep(positions(scene), **rates)
    finally:
        del bodies.check
    return bodies, seen[0], positions(scene)


def refused(bodies: FreeBodies, claim: Claim, where: np.ndarray) -> bool:
    try:
        bodies.check(claim).prove(where, np.ones(len(where)))
    except cd.AccuracyError:
        return True
    return False


def bent(array: np.ndarray, place: tuple[int, ...], by: float) -> np.ndarray:
    """Return an array with one number changed."""
    result = np.array(array)
    size = np.max(np.abs(array)) or 1.0
    result[place] += by * size
    return result


@pytest.mark.parametrize("rates", [{}, RATES], ids=["at rest", "moving"])
@pytest.mark.parametrize("name", SCENES)
def test_what_is_right_is_not_refused(name: str, rates: dict[str, float]) -> None:
    bodies, claim, where = claimed(SCENES[name](), **rates)
    found = bodies.check(claim)
    found.prove(where, np.ones(len(where)))
    assert found.balance < 1e-13
    assert found.power < 1e-13
    assert np.max(found.loop_error) < 1e-13
    assert found.rate < 1e-13


@pytest.mark.parametrize("rates", [{}, RATES], ids=["at rest", "moving"])
@pytest.mark.parametrize("name", SCENES)
def test_a_false_component_of_any_wrench_is_refused(name: str, rates: dict[str, float]) -> None:
    bodies, claim, where = claimed(SCENES[name](), **rates)
    for sample in (0, 17):
        for joint in range(claim.wrenches.shape[1]):
            for component in range(6):
                false = bent(claim.wrenches, (sample, joint, component), 1e-6)
                assert refused(bodies, claim._replace(wrenches=false), where)


@pytest.mark.parametrize("name", SCENES)
def test_false_motion_efforts_and_loads_are_refused(name: str) -> None:
    scene = SCENES[name]()
    bodies, claim, where = claimed(scene, **RATES)
    assert not refused(bodies, claim, where)
    for rate in range(claim.v.shape[1]):
        assert refused(bodies, claim._replace(v=bent(claim.v, (4, rate), 1e-6)), where)
        assert refused(bodies, claim._replace(a=bent(claim.a, (4, rate), 1e-6)), where)
        false = bent(claim.velocity_ratios, (4, rate, 0), 1e-6)
        assert refused(bodies, claim._replace(velocity_ratios=false), where)
    for column in range(claim.x.shape[1]):
        assert refused(bodies, claim._replace(x=bent(claim.x, (4, column), 1e-6)), where)
    for drive in range(len(scene.drives)):
        outside = scene.mechanism.coordinates.velocity_columns[scene.drives[drive]].start
        false = bent(claim.exerted, (4, outside), 1e-6)
        assert refused(bodies, claim._replace(exerted=false), where)
        for part in ("positions", "speeds", "accelerations"):
            false = bent(getattr(claim, part), (4, drive), 1e-6)
            assert refused(bodies, claim._replace(**{part: false}), where)
    for load in scene._problem.joint_loads:
        place = scene.mechanism.coordinates.velocity_columns[load].start
        assert refused(bodies, claim._replace(loads=bent(claim.loads, (0, place), 1e-4)), where)
    for number in range(claim.couplings.shape[1]):
        false = bent(claim.couplings, (4, number), 1e-6)
        assert refused(bodies, claim._replace(couplings=false), where)
    for link, load in scene._problem.link_loads.items():
        for part in ("force", "moment"):
            for axis in range(3):
                false = replace(load, **{part: bent(getattr(load, part), (0, axis), 1e-4)})
                assert refused(bodies, claim._replace(link_loads={link: false}), where)
        assert refused(bodies, claim._replace(link_loads={}), where)


def test_an_open_chain_elsewhere_than_asked_is_refused() -> None:
    """It would be in balance anywhere."""
    arm = """<robot name="arm"><link name="base"/><link name="upper"/><link name="lower"/>
      <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/>
        <axis xyz="0 1 0"/></joint>
      <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
        <origin xyz="1 0 0"/><axis xyz="0 1 0"/></joint></robot>"""
    scene = cd.Scene(
        cd.load(arm), drive="shoulder", held={"elbow": 0.4}, loads={"lower": [1.0] * 6}
    )
    bodies, claim, where = claimed(scene, **RATES)
    assert not refused(bodies, claim, where)
    for column in range(2):
        assert refused(bodies, claim._replace(x=bent(claim.x, (4, column), 1e-6)), where)
    elbow = scene.mechanism.coordinates.velocity_columns["elbow"].start
    for part in ("v", "a"):
        false = bent(getattr(claim, part), (4, elbow), 1e-6)
        assert refused(bodies, claim._replace(**{part: false}), where)


def test_whole_turns_count_where_couplings_do() -> None:
    bodies, claim, where = claimed(geared(), **RATES)
    turns = claim.turns.copy()
    column = geared().mechanism.coordinates.columns["in"].start
    turns[:, column] += 1.0
    assert refused(bodies, claim._replace(turns=turns), where)


MODEL_FAULTS: dict[str, Callable[[pin.Model, int], None]] = {
    "mass": lambda model, k: setattr(model.inertias[k], "mass", model.inertias[k].mass * 1.001),
    "no mass": lambda model, k: setattr(model.inertias[k], "mass", 0.0),
    "centre": lambda model, k: setattr(
        model.inertias[k], "lever", np.add(model.inertias[k].lever, [1e-5, 2e-5, -1e-5])
    ),
    "inertia": lambda model, k: setattr(
        model.inertias[k], "inertia", model.inertias[k].inertia * 1.01
    ),
    "origin": lambda model, k: setattr(
        model.jointPlacements[k],
        "translation",
        np.add(model.jointPlacements[k].translation, [1e-5, -2e-5, 1e-5]),
    ),
    "orientation": lambda model, k: setattr(
        model.jointPlacements[k],
        "rotation",
        model.jointPlacements[k].rotation @ pin.exp3(np.array([1e-5, 2e-5, -1e-5])),
    ),
}


@pytest.mark.parametrize("fault", MODEL_FAULTS)
@pytest.mark.parametrize("name", ["universal", "four-bar", "spatial"])
def test_a_false_number_in_any_body_of_the_model_is_refused(name: str, fault: str) -> None:
    """The model is spoiled behind the description's back; the text knows better."""
    count = SCENES[name]().mechanism.model.njoints
    still = SCENES[name]().held
    tried = 0
    for body in range(1, count):
        mechanism = cd.load(SCENES[name]().mechanism.description.source.text)
        inertia = mechanism.model.inertias[body]
        if fault == "inertia" and mechanism.model.names[body] in still:
            continue
        if fault in ("mass", "no mass", "centre", "inertia") and not (
            inertia.mass > 0.0 and body not in mechanism.auxiliary_bodies
        ):
            continue
        MODEL_FAULTS[fault](mechanism.model, body)
        tried += 1
        with pytest.raises((cd.AccuracyError, cd.AssemblyError)):
            given = SCENES[name]()
            scene = cd.Scene(mechanism, drive=given.drives, held=given.held, gravity=GRAVITY)
            scene.sweep(positions(scene), speed=20.0, acceleration=7.0)
    assert tried


@pytest.mark.parametrize("name", SCENES)
def test_closure_forces_that_are_lost_are_refused(name: str) -> None:
    scene = SCENES[name]()
    scene._solver.reactions._active.clear()
    with pytest.raises(cd.AccuracyError, match="please report"):
        scene.sweep(positions(scene), **RATES)


@pytest.mark.parametrize("name", ["universal", "four-bar"])
def test_false_flags_are_refused(name: str) -> None:
    bodies, claim, _ = claimed(SCENES[name](), **RATES)
    scene = SCENES[name]()
    turn = scene.sweep(positions(scene), **RATES)
    joints = [bodies.frames.joints[number] for number in bodies.claimed]
    flags = np.array([turn[joint].unique for joint in joints])
    bodies.prove_flags(claim.x, flags)
    for joint, component in np.ndindex(flags.shape):
        false = flags.copy()
        false[joint, component] ^= True
        with pytest.raises(cd.AccuracyError, match=f"{joints[joint]}' is flagged"):
            bodies.prove_flags(claim.x, false)


def test_a_residual_is_never_zero_for_want_of_a_scale() -> None:
    idle = four_bar(gravity=None, loads={})
    turn = idle.sweep(POSITIONS)
    assert np.isnan(turn.balance_residual)
    assert np.isnan(turn.power_residual)
    bodies, claim, where = claimed(four_bar(), **RATES)
    nothing = claim._replace(wrenches=np.zeros_like(claim.wrenches))
    assert bodies.check(nothing).balance > 0.1
    assert refused(bodies, nothing, where)


def test_what_the_proof_cannot_see_it_says() -> None:
    assert four_bar().sweep(POSITIONS).unproven == ()
    alone = four_bar(outputs=[]).sweep(POSITIONS, **RATES)
    assert set(alone.unproven) == {"crank", "coupler", "rocker"}
    assert np.isnan(alone.balance_residual)
    # The drive's effort is proven by power.
    assert alone.power_residual < 1e-13
    joint = universal(outputs=["bearing_in"]).sweep(POSITIONS)
    assert joint.unproven == ()


def test_a_false_drive_effort_alone_is_refused() -> None:
    bodies, claim, where = claimed(four_bar(outputs=[]), **RATES)
    place = np.argmax(np.abs(claim.exerted[4]))
    false = bent(claim.exerted, (4, int(place)), 1e-6)
    assert refused(bodies, claim._replace(exerted=false), where)


@pytest.mark.parametrize("outputs", [None, []])
def test_false_rates_of_massless_scenes_are_refused_at_any_sample(
    outputs: list[str] | None,
) -> None:
    bare = re.sub("<inertial>.*?</inertial>", "", text("four_bar"), flags=re.DOTALL)
    for loads in ({"rocker_bearing": 2.0}, {"coupler": cd.Wrench([1.0, 0.0, 2.0])}):
        scene = cd.Scene(cd.load(bare), drive="crank_bearing", loads=loads, outputs=outputs)
        bodies, claim, where = claimed(scene, **RATES)
        assert not refused(bodies, claim, where)
        passive = scene.mechanism.coordinates.velocity_columns["rocker_bearing"].start
        for sample in range(len(where)):
            for part in ("v", "a"):
                false = bent(getattr(claim, part), (sample, passive), 1e-6)
                assert refused(bodies, claim._replace(**{part: false}), where)
            false = bent(claim.velocity_ratios, (sample, passive, 0), 1e-6)
            assert refused(bodies, claim._replace(velocity_ratios=false), where)


def test_velocity_ratios_of_every_drive_are_proven() -> None:
    robot = cd.load("stewart_platform")
    legs = [name for name in robot.joints if name.startswith("leg")]
    scene = cd.Scene(robot, drive=legs, gravity=GRAVITY)
    bodies = scene._solver.inverse_dynamics.bodies
    seen: list[Claim] = []
    check = bodies.check
    bodies.check = lambda claim: seen.append(claim) or check(claim)
    where = 0.01 * np.sin(np.arange(18.0)).reshape(3, 6)
    scene.sweep(where)
    del bodies.check
    false = np.array(seen[0].velocity_ratios)
    false[:, scene._problem.passive_columns, 0] += 0.5
    false[:, scene._problem.passive_columns, 1] -= 0.5
    assert not refused(bodies, seen[0], where)
    assert refused(bodies, seen[0]._replace(velocity_ratios=false), where)


def test_the_text_is_read_a_second_time() -> None:
    """Numbers that the first reader got wrong are seen by the second one."""
    mechanism = cd.load(text("four_bar"))
    description = mechanism.description
    for factor in (1.001, 0.0):
        others = tuple(
            replace(link, mass=factor * link.mass) if link.mass else link
            for link in description.links
        )
        spoiled = cd.Mechanism(replace(description, links=others))
        scene = cd.Scene(spoiled, drive="crank_bearing", gravity=GRAVITY)
        with pytest.raises(cd.AccuracyError, match=r"balance|power"):
            scene.sweep(POSITIONS)
