"""Chains that are overclosed on closed positions alone, against virtual work and quadrature."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin
import pytest
from testkit.constrained import accelerations, closure_error
from testkit.hinge_loops import (
    Hinge,
    altmann,
    bennett,
    bricard,
    description,
    goldberg_5,
    planar,
    rank,
    robot,
    sarrus,
    spherical,
)

import cardan_dyn as cd
from cardan_dyn.motion.simulation.constrained_model import ConstrainedModel
from cardan_dyn.motion.simulation.turning_model import turning_model

GRAVITY = np.array([0.5, -9.81, 2.0])
Maker = Callable[[], list[Hinge]]


def moving(hinges: list[Hinge]) -> tuple[cd.Scene, cd.Sweep, ConstrainedModel]:
    """A loop of heavy links, a state of it in motion, and its model made at zero."""
    mechanism = cd.load(robot(description(hinges)))
    scene = cd.Scene(mechanism, drive="h0", gravity=GRAVITY)
    turn = scene.sweep([0.02], [1.7])
    zero = scene.sweep([0.0]).motion.x[0]
    return scene, turn, ConstrainedModel(mechanism, [], GRAVITY, zero)


@pytest.mark.parametrize("maker", [bennett, bricard, goldberg_5, altmann])
def test_no_free_drive_needs_an_effort(maker: Maker) -> None:
    """Inverse dynamics of what comes out; the rank is that of the hinges' screws."""
    hinges = maker()
    scene, turn, model = moving(hinges)
    assert model.chains[0]._elsewhere.rank == rank(hinges)
    a = accelerations(model, turn.motion.x[0], turn.motion.v[0])
    drive = a[scene.mechanism.coordinates.named["h0"].rate]
    needed = scene.sweep([0.02, 0.02], 1.7, [drive, 0.0]).drive_effort
    assert abs(needed[0]) < 1e-11 * abs(needed[1])


@pytest.mark.parametrize("maker", [bennett, goldberg_5, altmann])
def test_accelerations_are_smooth_where_loops_are_open(maker: Maker) -> None:
    """Opened a hundredfold less, they change a hundredfold less."""
    scene, turn, model = moving(maker())
    x, v = turn.motion.x[0], turn.motion.v[0]
    at_rest = accelerations(model, x, v)
    way = np.random.default_rng(5).normal(size=v.size)
    plain = turning_model(scene.mechanism)
    changes = [
        np.max(np.abs(accelerations(model, pin.integrate(plain, x, size * way), v) - at_rest))
        for size in (1e-4, 1e-6)
    ]
    assert 80.0 < changes[0] / changes[1] < 120.0


@pytest.mark.parametrize("maker", [planar, spherical, sarrus])
def test_what_is_redundant_everywhere_is_known_where_loops_are_open(maker: Maker) -> None:
    """Axes that are parallel on the same bodies, or meet there, do so wherever those are."""
    hinges = maker()
    *_, model = moving(hinges)
    elsewhere = model.chains[0]._elsewhere
    assert elsewhere.rank == rank(hinges)
    assert min(closure_error(model.mechanism, x) for x in elsewhere.places) > 1e-3


def test_what_is_prescribed_moves_as_it_is_told() -> None:
    scene, turn, _ = moving(bennett())
    mechanism = scene.mechanism
    rate = mechanism.coordinates.named["h0"].rate
    x, v = turn.motion.x[0], turn.motion.v[0]
    model = ConstrainedModel(mechanism, [rate], GRAVITY, x)
    a = accelerations(model, x, v, None, np.array([-3.0]))
    expected = scene.sweep([0.02], [1.7], [-3.0]).motion.a[0]
    np.testing.assert_allclose(a, expected, rtol=1e-12, atol=1e-12)


def test_a_motion_of_bennett_s_linkage_is_that_of_its_energy() -> None:
    mechanism = cd.load(robot(description(bennett())))
    scene = cd.Scene(mechanism, free="h0", gravity=GRAVITY)
    exact = scene.simulate(1.0, speed=9.0, method="quadrature")
    found = scene.simulate(1.0, speed=9.0, method="DOP853", rtol=1e-12)
    assert found.position[-1] == pytest.approx(exact.position[-1], abs=2e-11)
    assert found.energy_residual < 1e-11
    # As many steps as accuracy asks for; where accelerations jump, there are some hundreds more.
    assert len(found) < 300
