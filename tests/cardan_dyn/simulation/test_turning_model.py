"""The turning model against the mechanism's own model."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from testkit.ball_rods import as_balls

import cardan_dyn as cd
from cardan_dyn.motion.simulation.turning_model import turning_model


@pytest.mark.parametrize("name", ["double_shaft_z", "needle_drive", "balls"])
def test_the_same_dynamics_with_angles_for_configurations(name: str) -> None:
    mechanism = cd.load(as_balls() if name == "balls" else name)
    gravity = np.array([1.0, 2.0, -9.81])
    model = turning_model(mechanism, gravity)
    random = np.random.default_rng(1)
    x = mechanism.coordinates.neutral()
    x[mechanism.coordinates.scalars.columns] += random.uniform(
        -2.0, 2.0, len(mechanism.coordinates.scalars.columns)
    )
    v, a = random.normal(size=(2, model.nv))
    own = mechanism.model.copy()
    own.gravity.linear = gravity
    q = mechanism.coordinates.configuration(x[None, :])[0]
    expected = pin.rnea(own, own.createData(), q, v, a)
    found = pin.rnea(model, model.createData(), x, v, a)
    np.testing.assert_allclose(found, expected, atol=1e-13 * np.max(np.abs(expected)))
    assert (model.nq, model.nv) == (mechanism.coordinates.size, own.nv)


def test_turns_count_as_they_are(joint: cd.Mechanism) -> None:
    model = turning_model(joint)
    assert not np.any(model.gravity.linear)
    x = pin.integrate(model, pin.neutral(model), np.full(model.nv, 20.0))
    np.testing.assert_array_equal(x, 20.0)
