"""Scenes whose model, text or solver is spoiled are refused, and what is unproven is named."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from testkit import elastic_rigs
from testkit.claims import (
    GRAVITY,
    POSITIONS,
    RATES,
    SCENES,
    claimed,
    four_bar,
    positions,
    refused,
    universal,
)
from testkit.scenes import text

import cardan_dyn as cd

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


@pytest.mark.slow
@pytest.mark.parametrize("fault", MODEL_FAULTS)
@pytest.mark.parametrize("name", ["universal", "four-bar", "spatial"])
def test_a_false_number_in_any_body_of_the_model_is_refused(name: str, fault: str) -> None:
    """The model is changed after it was made; the proof reads the description's text."""
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
    taped = scene.solver.taped
    blocks = tuple(block._replace(is_balanced=False) for block in taped._roles.blocks)
    taped._roles = taped._roles._replace(blocks=blocks)
    with pytest.raises(cd.AccuracyError, match="please report"):
        scene.sweep(positions(scene), **RATES)


def test_residuals_without_a_scale_are_nan() -> None:
    idle = four_bar(gravity=None, loads={})
    turn = idle.sweep(POSITIONS)
    assert np.isnan(turn.balance_residual)
    assert np.isnan(turn.power_residual)
    bodies, claim, where = claimed(four_bar(), **RATES)
    nothing = claim._replace(wrenches=np.zeros_like(claim.wrenches))
    assert bodies.check(nothing).balance > 0.1
    assert refused(bodies, nothing, where)


def test_bodies_that_are_not_proven_are_named() -> None:
    assert four_bar().sweep(POSITIONS).unproven == ()
    alone = four_bar(outputs=[]).sweep(POSITIONS, **RATES)
    assert set(alone.unproven) == {"crank", "coupler", "rocker"}
    assert np.isnan(alone.balance_residual)
    # The drive's effort is proven by power.
    assert alone.power_residual < 1e-13
    joint = universal(outputs=["bearing_in"]).sweep(POSITIONS)
    assert joint.unproven == ()


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


def test_bodies_that_slide_steadily_need_no_force() -> None:
    """However they are turned, what rounding leaves of it is no wrong wrench."""
    rotor = cd.load(elastic_rigs.sliding_rotor())
    scene = cd.Scene(rotor, drive=["turn", "x", "y", "z", "yaw"])
    angle = np.linspace(0.0, 2.0 * np.pi, 97)
    places = np.column_stack([angle, *np.zeros((3, 97)), 0.7 * angle])
    for speed in ([0.0, 1.0, -2.0, 3.0, 0.0], [0.0, 0.0, 1e4, 0.0, 0.0]):
        sweep = scene.sweep(places, speed)
        scale = 1.7 * np.max(np.abs(speed)) ** 2
        assert np.max(np.abs(sweep.drive_effort)) < 1e-14 * scale
        assert sweep.balance_residual < 1e-13
