"""Free bodies: claims with a false number of any kind are refused, and hand-cut bodies."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from testkit.claims import (
    GRAVITY,
    RATES,
    SCENES,
    bent,
    claimed,
    coupled_wheels,
    four_bar,
    positions,
    refused,
)
from testkit.kinematics import frames_of
from testkit.scenes import text

import cardan_dyn as cd
from cardan_dyn.core.description.second_reading import reread
from cardan_dyn.core.elements.link_loads import LinkLoad
from cardan_dyn.core.proof.constraints import Motion
from cardan_dyn.core.proof.free_bodies import FreeBodies, Setup
from cardan_dyn.core.proof.residuals import Claim

pytestmark = pytest.mark.usefixtures("loaded_once")


@pytest.mark.parametrize("rates", [{}, RATES], ids=["at rest", "moving"])
@pytest.mark.parametrize("name", SCENES)
def test_right_claims_are_not_refused(name: str, rates: dict[str, float]) -> None:
    bodies, claim, where = claimed(SCENES[name](), **rates)
    residuals = bodies.check(claim)
    residuals.prove(where, np.ones(len(where)))
    assert residuals.balance < 1e-13
    assert residuals.power < 1e-13
    assert np.max(residuals.loop_error) < 1e-13
    assert residuals.rate < 1e-13


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
        driven = scene.mechanism.coordinates.velocity_columns[scene.drives[drive]].start
        false = bent(claim.exerted, (4, driven), 1e-6)
        assert refused(bodies, claim._replace(exerted=false), where)
        for field in ("positions", "speeds", "accelerations"):
            false = bent(getattr(claim, field), (4, drive), 1e-6)
            assert refused(bodies, claim._replace(**{field: false}), where)
    for load in scene.problem.joint_loads:
        loaded = scene.mechanism.coordinates.velocity_columns[load].start
        assert refused(bodies, claim._replace(loads=bent(claim.loads, (0, loaded), 1e-4)), where)
    for coupling in range(claim.couplings.shape[1]):
        false = bent(claim.couplings, (4, coupling), 1e-6)
        assert refused(bodies, claim._replace(couplings=false), where)
    for joint in range(claim.held.shape[1]):
        assert refused(bodies, claim._replace(held=bent(claim.held, (0, joint), 1e-6)), where)
    for axis in range(3):
        assert refused(bodies, claim._replace(gravity=bent(claim.gravity, (0, axis), 1e-4)), where)
    for link in {link.name for link in scene.mechanism.description.links if link.mass > 0.0}:
        if scene.mechanism.link(link)[0]:
            false = {link: np.array([1.0 + 1e-4])}
            assert refused(bodies, claim._replace(inertia=false), where)
    for link, load in claim.link_loads.items():
        for field in ("force", "moment"):
            for axis in range(3):
                false = replace(load, **{field: bent(getattr(load, field), (0, axis), 1e-4)})
                assert refused(bodies, claim._replace(link_loads={link: false}), where)
        assert refused(bodies, claim._replace(link_loads={}), where)


def test_an_open_chain_elsewhere_than_prescribed_is_refused() -> None:
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
    for field in ("v", "a"):
        false = bent(getattr(claim, field), (4, elbow), 1e-6)
        assert refused(bodies, claim._replace(**{field: false}), where)


def test_whole_turns_count_where_couplings_do() -> None:
    bodies, claim, where = claimed(coupled_wheels(), **RATES)
    turns = claim.turns.copy()
    column = coupled_wheels().mechanism.coordinates.columns["in"].start
    turns[:, column] += 1.0
    assert refused(bodies, claim._replace(turns=turns), where)


@pytest.mark.parametrize("name", ["universal", "four-bar"])
def test_false_flags_are_refused(name: str) -> None:
    bodies, claim, _ = claimed(SCENES[name](), **RATES)
    scene = SCENES[name]()
    turn = scene.sweep(positions(scene), **RATES)
    joints = [bodies.frames.joints[index] for index in bodies.claimed]
    flags = np.array([turn[joint].unique for joint in joints])
    bodies.prove_flags(claim.x, flags)
    for joint, component in np.ndindex(flags.shape):
        false = flags.copy()
        false[joint, component] ^= True
        with pytest.raises(cd.AccuracyError, match=f"{joints[joint]}' is flagged"):
            bodies.prove_flags(claim.x, false)


def test_a_false_drive_effort_alone_is_refused() -> None:
    bodies, claim, where = claimed(four_bar(outputs=[]), **RATES)
    driven = int(np.argmax(np.abs(claim.exerted[4])))
    false = bent(claim.exerted, (4, driven), 1e-6)
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
            for field in ("v", "a"):
                false = bent(getattr(claim, field), (sample, passive), 1e-6)
                assert refused(bodies, claim._replace(**{field: false}), where)
            false = bent(claim.velocity_ratios, (sample, passive, 0), 1e-6)
            assert refused(bodies, claim._replace(velocity_ratios=false), where)


def test_velocity_ratios_of_every_drive_are_proven() -> None:
    robot = cd.load("stewart_platform")
    legs = [name for name in robot.joints if name.startswith("leg")]
    scene = cd.Scene(robot, drive=legs, gravity=GRAVITY)
    bodies, claim, where = claimed(scene, 0.01 * np.sin(np.arange(18.0)).reshape(3, 6))
    false = np.array(claim.velocity_ratios)
    false[:, scene.problem.passive_columns, 0] += 0.5
    false[:, scene.problem.passive_columns, 1] -= 0.5
    assert not refused(bodies, claim, where)
    assert refused(bodies, claim._replace(velocity_ratios=false), where)


RADIUS, MASS, INERTIA, LENGTH = 0.5, 2.0, 0.3, 0.7
SPEED, ACCELERATION = 3.0, 4.0
DISC = f"""<robot name="disc"><link name="base"/><link name="disc"><inertial>
  <origin xyz="{RADIUS} 0 0"/><mass value="{MASS}"/>
  <inertia ixx="0.2" iyy="0.2" izz="{INERTIA}"/></inertial></link><link name="rim"/>
  <joint name="axle" type="continuous"><parent link="base"/><child link="disc"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="weld" type="fixed"><parent link="disc"/><child link="rim"/>
    <origin xyz="0 1 0" rpy="0 0 1.5707963267948966"/></joint></robot>"""
ABOUT_AXLE = INERTIA + MASS * RADIUS**2


def disc_bodies(claims_wrench: bool = True, drives: tuple[str, ...] = ("axle",)) -> FreeBodies:
    mechanism = cd.load(DISC)
    motion = Motion(drives, (), np.ones(1, dtype=bool))
    setup = Setup(motion, ["axle"] if claims_wrench else [])
    return FreeBodies(reread(mechanism.description), mechanism.coordinates, LENGTH, setup)


def disc_claim(wrench: list[float], effort: float, has_rates: bool = True, **more: object) -> Claim:
    """Return a claim about two positions of the disc, driven at its axle."""
    x, v, a = np.array([[0.0], [2.0]]), np.full((2, 1), SPEED), np.full((2, 1), ACCELERATION)
    rest = np.zeros((2, 1))
    values: dict[str, object] = {
        "x": x,
        "turns": np.zeros((2, 1)),
        "v": v if has_rates else rest,
        "a": a if has_rates else rest,
        "positions": x,
        "speeds": v if has_rates else rest,
        "accelerations": a if has_rates else rest,
        "held": np.zeros((1, 0)),
        "velocity_ratios": np.ones((2, 1, 1)),
        "wrenches": np.array([[wrench], [wrench]]),
        "exerted": np.full((2, 1), effort),
        "couplings": np.zeros((2, 0)),
        "loads": np.zeros((1, 1)),
        "link_loads": {},
        "gravity": np.array([[0.0, 0.0, -10.0]]),
        "inertia": {},
        "has_rates": has_rates,
    }
    return Claim(**{**values, **more})  # type: ignore[arg-type]


TURNING = [
    *(-MASS * RADIUS * SPEED**2, MASS * RADIUS * ACCELERATION, 10.0 * MASS),
    *(0.0, -10.0 * MASS * RADIUS, ABOUT_AXLE * ACCELERATION),
]
"""What the axle exerts on the disc in the axes that turn with it: it pulls the centre inwards,
accelerates it, and carries its weight."""


def test_a_disc_cut_free_by_hand() -> None:
    effort = ABOUT_AXLE * ACCELERATION
    residuals = disc_bodies().check(disc_claim(TURNING, effort))
    for name in ("imbalance", "power_imbalance", "loop_error", "rate_error"):
        np.testing.assert_allclose(getattr(residuals, name), 0.0, atol=1e-14)
    force = np.linalg.norm(TURNING[:3])
    np.testing.assert_allclose(residuals.wrench, max(LENGTH * force, np.hypot(10.0, effort)))
    np.testing.assert_allclose(residuals.applied, LENGTH * MASS * 10.0)
    np.testing.assert_allclose(residuals.inertia, MASS * LENGTH**2 * (SPEED**2 + ACCELERATION))
    # Of the drive, and of inertia against it, at unit speed.
    np.testing.assert_allclose(residuals.power_scale, 2.0 * effort)
    np.testing.assert_allclose(residuals.speed_scale, 1.0)
    assert residuals.bodies_balanced
    assert residuals.power_balanced


def test_what_a_body_lacks_is_its_imbalance() -> None:
    """Forces are multiplied with the length; moments are taken about the joint."""
    effort = ABOUT_AXLE * ACCELERATION
    for component, change, expected in ((0, 0.5, 0.5 * LENGTH), (3, 0.5, 0.5)):
        wrench = [*TURNING]
        wrench[component] += change
        residuals = disc_bodies().check(disc_claim(wrench, effort))
        np.testing.assert_allclose(residuals.imbalance, expected, rtol=1e-12)
        np.testing.assert_allclose(residuals.power_imbalance, 0.0, atol=1e-14)
    residuals = disc_bodies().check(disc_claim(TURNING, effort + 0.25))
    # The wrench at the axle lacks the effort, and the power of the drive is too great.
    np.testing.assert_allclose(residuals.imbalance, 0.25, rtol=1e-12)
    np.testing.assert_allclose(residuals.power_imbalance, 0.25, rtol=1e-12)


def test_a_disc_at_rest_has_no_inertial_terms() -> None:
    resting = [0.0, 0.0, 10.0 * MASS, 0.0, -10.0 * MASS * RADIUS, 0.0]
    residuals = disc_bodies().check(disc_claim(resting, 0.0, has_rates=False))
    np.testing.assert_allclose(residuals.imbalance, 0.0, atol=1e-14)
    np.testing.assert_array_equal(residuals.inertia, [0.0, 0.0])


@pytest.mark.parametrize("factors", [[3.0], [0.0], [0.5, 2.0]])
def test_factors_multiply_weight_and_inertia_of_a_link(factors: list[float]) -> None:
    """Of one value for all samples, or of one for each; the rim has no mass."""
    effort, factor = ABOUT_AXLE * ACCELERATION, np.array(factors)
    times = np.broadcast_to(factor, 2)[:, None]
    claim = disc_claim(
        TURNING,
        effort,
        wrenches=times[:, None] * np.array(TURNING),
        exerted=times * effort,
        inertia={"disc": factor, "rim": np.array([7.0])},
    )
    residuals = disc_bodies().check(claim)
    np.testing.assert_allclose(residuals.imbalance, 0.0, atol=1e-13)
    np.testing.assert_allclose(residuals.power_imbalance, 0.0, atol=1e-13)
    # Both are rounded: all of the disc, and what its factor adds or takes.
    added = np.abs(times[:, 0] - 1.0)
    terms = MASS * LENGTH**2 * (SPEED**2 + ACCELERATION)
    np.testing.assert_allclose(residuals.inertia, (1.0 + added) * terms, rtol=1e-14)
    np.testing.assert_allclose(residuals.applied, LENGTH * MASS * 10.0 * np.maximum(1.0, added))
    residuals = disc_bodies().check(claim._replace(inertia={}))
    # What the disc lacks without them is what they add.
    force, moment = np.linalg.norm(TURNING[:3]), np.linalg.norm(TURNING[3:])
    size = np.maximum(LENGTH * force, moment)
    np.testing.assert_allclose(residuals.imbalance, added * size, rtol=1e-12)
    np.testing.assert_allclose(residuals.power_imbalance, added * effort, rtol=1e-12)


def test_gravity_may_differ_from_sample_to_sample() -> None:
    """The axle pulls the disc against it, in the axes that turn with the disc."""
    gravity, angles = np.array([[3.0, 0.0, 0.0], [0.0, -4.0, 5.0]]), np.array([0.0, 2.0])
    pull = -MASS * gravity
    c, s = np.cos(angles), np.sin(angles)
    held = np.stack([c * pull[:, 0] + s * pull[:, 1], c * pull[:, 1] - s * pull[:, 0], pull[:, 2]])
    wrenches = np.zeros((2, 1, 6))
    wrenches[:, 0, :3] = held.T
    wrenches[:, 0, 3:] = np.cross([RADIUS, 0.0, 0.0], held.T)
    claim = disc_claim(
        TURNING,
        0.0,
        has_rates=False,
        wrenches=wrenches,
        exerted=wrenches[:, :, 5],
        gravity=gravity,
    )
    residuals = disc_bodies().check(claim)
    np.testing.assert_allclose(residuals.imbalance, 0.0, atol=1e-14)
    np.testing.assert_allclose(residuals.power_imbalance, 0.0, atol=1e-14)
    np.testing.assert_allclose(
        residuals.applied, LENGTH * MASS * np.linalg.norm(gravity, axis=1), rtol=1e-14
    )
    swapped = disc_bodies().check(claim._replace(gravity=gravity[::-1]))
    assert np.all(swapped.imbalance > 1.0)


@pytest.mark.parametrize("in_world", [False, True])
def test_a_load_on_a_link_acts_at_its_origin_and_in_its_axes(in_world: bool) -> None:
    """The rim is a metre off the axle along y, its axes turned by a quarter."""
    mechanism = cd.load(DISC)
    body, placement = frames_of(mechanism).links["rim"]
    force, moment = np.array([[3.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 4.0]])
    load = LinkLoad(body, placement[:3, :3], placement[:3, 3], force, moment, in_world)
    angles = np.array([0.0, 2.0])
    # Along the rim's x axis, which is the disc's y axis and points at the axle, or the world's.
    zero, one = np.zeros(2), np.ones(2)
    x_axis = np.stack([np.cos(angles), -np.sin(angles), zero]) if in_world else [zero, one, zero]
    on_disc = 3.0 * np.asarray(x_axis)
    about_axle = 4.0 - on_disc[0]
    resting = np.zeros((2, 1, 6))
    resting[:, 0, :3] = -on_disc.T
    resting[:, 0, 2] = 10.0 * MASS
    resting[:, 0, 4] = -10.0 * MASS * RADIUS
    resting[:, 0, 5] = -about_axle
    claim = disc_claim(
        TURNING,
        0.0,
        has_rates=False,
        wrenches=resting,
        exerted=-about_axle[:, None],
        link_loads={"rim": load},
    )
    residuals = disc_bodies().check(claim)
    np.testing.assert_allclose(residuals.imbalance, 0.0, atol=1e-14)
    np.testing.assert_allclose(residuals.power_imbalance, 0.0, atol=1e-14)
    np.testing.assert_allclose(residuals.applied, LENGTH * MASS * 10.0)


def test_a_load_at_a_point_is_one_at_the_origin_with_the_moment_of_its_arm() -> None:
    """The point is given in the axes of the rim, which are not those of the disc."""
    body, placement = frames_of(cd.load(DISC)).links["rim"]
    force, moment = np.array([[3.0, -1.0, 2.0]]), np.array([[0.5, 0.0, 4.0]])
    point = np.array([0.2, -0.3, 0.1])
    placed = body, placement[:3, :3], placement[:3, 3]
    at_point = LinkLoad(*placed, force, moment, False, point)
    at_origin = LinkLoad(*placed, force, moment + np.cross(point, force), False)
    found, expected = (
        disc_bodies().check(disc_claim(TURNING, 0.0, link_loads={"rim": load}))
        for load in (at_point, at_origin)
    )
    for one, other in zip(found[:9], expected, strict=False):
        np.testing.assert_allclose(one, other, rtol=1e-14)


def test_bodies_whose_wrenches_are_not_claimed_are_unproven() -> None:
    bodies = disc_bodies(claims_wrench=False)
    assert bodies.claimed == []
    assert bodies.unproven == ("disc", "rim")
    effort = ABOUT_AXLE * ACCELERATION
    claim = disc_claim(TURNING, effort, wrenches=np.zeros((2, 0, 6)))
    residuals = bodies.check(claim)
    assert not residuals.bodies_balanced
    np.testing.assert_array_equal(residuals.imbalance, [0.0, 0.0])
    # Virtual work still gives the effort of the drive.
    assert residuals.power_balanced
    np.testing.assert_allclose(residuals.power_imbalance, 0.0, atol=1e-14)
    assert disc_bodies().unproven == ()


def test_motions_of_slides_are_inertial_terms() -> None:
    """Slides against each other leave a body where it is, up to the rounding of each of them.

    So does the product of a body's speed and its momentum, which is along it.
    """
    slide = DISC.replace('type="continuous"', 'type="prismatic"')
    bodies, with_rotor = (
        FreeBodies(
            reread(mechanism.description),
            mechanism.coordinates,
            LENGTH,
            Setup(Motion(("axle",), (), np.ones(1, dtype=bool)), ["axle"]),
        )
        for mechanism in (
            cd.load(text)
            for text in (slide, slide.replace("<axis", '<dynamics armature="0.6"/><axis'))
        )
    )
    push = MASS * ACCELERATION
    wrench = [0.0, 0.0, push, 0.0, -push * RADIUS, 0.0]
    residuals = bodies.check(disc_claim(wrench, push, gravity=np.zeros((1, 3))))
    np.testing.assert_allclose(residuals.imbalance, 0.0, atol=1e-14)
    terms = MASS * (LENGTH * ACCELERATION + SPEED**2)
    np.testing.assert_allclose(residuals.inertia, terms, rtol=1e-14)
    # A rotor is a mass along the slide, whose force counts by the length.
    effort = push + 0.6 * ACCELERATION
    residuals = with_rotor.check(disc_claim(wrench, effort, gravity=np.zeros((1, 3))))
    np.testing.assert_allclose(residuals.imbalance, 0.0, atol=1e-14)
    terms += 0.6 * ACCELERATION * LENGTH
    np.testing.assert_allclose(residuals.inertia, terms, rtol=1e-14)
