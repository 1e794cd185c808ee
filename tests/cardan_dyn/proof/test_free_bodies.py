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
from testkit.scenes import text

import cardan_dyn as cd


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
    for load in scene._problem.joint_loads:
        loaded = scene.mechanism.coordinates.velocity_columns[load].start
        assert refused(bodies, claim._replace(loads=bent(claim.loads, (0, loaded), 1e-4)), where)
    for coupling in range(claim.couplings.shape[1]):
        false = bent(claim.couplings, (4, coupling), 1e-6)
        assert refused(bodies, claim._replace(couplings=false), where)
    for link, load in scene._problem.link_loads.items():
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
    false[:, scene._problem.passive_columns, 0] += 0.5
    false[:, scene._problem.passive_columns, 1] -= 0.5
    assert not refused(bodies, claim, where)
    assert refused(bodies, claim._replace(velocity_ratios=false), where)
