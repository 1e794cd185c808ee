"""Spins: how weight and inertia turn rods about lines about which no moment acts."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from testkit.ball_rods import ALONG, SLENDER, WAYS

import cardan_dyn as cd
from benchmarks.robots import delta

GRAVITY = np.array([0.0, 0.0, -9.81])
ASKEW = SLENDER + np.array([[0.0, 1e-3, 2e-3], [1e-3, 0.0, -1e-3], [2e-3, -1e-3, 0.0]])
BESIDE = 0.5 * ALONG + np.array([0.0, 0.012, 0.004])


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("speed", [0.0, 6.0])
def test_the_moment_about_the_line_vanishes(way: str, speed: float) -> None:
    """Newton and Euler for the rod alone, moved by Pinocchio as the sweep says."""
    mechanism = cd.load(WAYS[way](inertia=ASKEW, centre=BESIDE))
    scene = cd.Scene(mechanism, drive="a", gravity=GRAVITY)
    turn = scene.sweep(np.linspace(-0.8, 0.8, 5), speed=speed, acceleration=0.3 * speed)
    assert turn.balance_residual < 1e-13
    model, data = mechanism.model, mechanism.model.createData()
    body, placement = mechanism.link("rod")
    motion = turn.motion
    greatest = 0.0
    for q, v, a in zip(motion.q, motion.v, motion.a, strict=True):
        pinocchio.forwardKinematics(model, data, q, v, a)
        rotation = data.oMi[body].rotation @ placement.rotation
        omega, alpha = (data.oMi[body].rotation @ w.angular for w in (data.v[body], data.a[body]))
        inertia = rotation @ ASKEW @ rotation.T
        lever = rotation @ BESIDE
        classical = pinocchio.getClassicalAcceleration(
            model, data, body, pinocchio.LOCAL_WORLD_ALIGNED
        )
        centre = classical.linear + np.cross(alpha, lever) + np.cross(omega, np.cross(omega, lever))
        moment = inertia @ alpha + np.cross(omega, inertia @ omega)
        moment += np.cross(lever, 1.5 * (centre - GRAVITY))
        line = rotation @ ALONG / np.linalg.norm(ALONG)
        # The balls pass forces through points on the line, so nothing balances this.
        assert abs(moment @ line) < 1e-12
        greatest = max(greatest, float(np.linalg.norm(moment)))
    assert greatest > 0.1


def test_balanced_rods_do_not_spin_at_rest() -> None:
    scene = cd.Scene(cd.load(WAYS["balls"]()), drive="a", gravity=GRAVITY)
    turn = scene.sweep([0.0, 0.4])
    assert np.max(np.abs(turn.motion.a)) < 1e-12


@pytest.mark.slow
def test_rods_without_mass_are_balanced_as_they_are() -> None:
    text = WAYS["balls"]()
    start = text.index('<link name="rod">')
    massless = text[:start] + '<link name="rod"/>' + text[text.index("</link>", start) + 7 :]
    scene = cd.Scene(cd.load(massless), drive="a", loads={"d": -3.0}, gravity=GRAVITY)
    turn = scene.sweep(np.linspace(-0.5, 0.5, 5), speed=3.0)
    assert turn.balance_residual < 1e-12
    assert len(turn.idle_rods) == 1
    assert np.all(np.isfinite(turn.motion.a))


@pytest.mark.slow
def test_six_rods_spin_each_by_itself() -> None:
    arms = [f"arm_{k}" for k in (1, 2, 3)]
    scene = cd.Scene(cd.load(delta(True)), drive=arms, gravity=GRAVITY)
    positions = np.random.default_rng(0).uniform(-0.3, 0.3, (20, 3))
    turn = scene.sweep(positions, speed=[3.0, -2.0, 1.0], acceleration=[-5.0, 4.0, 3.0])
    assert len(turn.idle_rods) == 6
    assert turn.balance_residual < 1e-13
