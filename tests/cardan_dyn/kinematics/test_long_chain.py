"""Long chains against batches that Pinocchio computes."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.drive_lines import drive_line
from testkit.mixed_chain import rows

import cardan_dyn as cd
from cardan_dyn.kinematics.closing import batch_model
from cardan_dyn.kinematics.closing.batch_model import BaseMotion, BatchModel, LongChain


@pytest.mark.parametrize("most_placed", [0, 64])
def test_a_long_chain_is_the_batch_of_the_same_bodies(
    most_placed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(batch_model, "_MOST_PLACED", most_placed)
    mechanism = cd.load(drive_line(3))
    bodies = list(range(mechanism.model.njoints - 1))
    massive, origin = set(bodies[::2]), np.array([0.5, 0.1, -0.2])
    chain, batch = (kind(mechanism, bodies, massive, origin) for kind in (LongChain, BatchModel))
    x = rows(mechanism, 6)
    random = np.random.default_rng(4)
    v, a = random.uniform(-3.0, 3.0, (2, 6, mechanism.model.nv))
    base = BaseMotion(*random.uniform(-3.0, 3.0, (2, 6, 6)))
    np.testing.assert_allclose(chain.actions(x), batch.actions(x), atol=1e-13)
    each = (item.inverse_dynamics(base, x, v, a) for item in (chain, batch))
    for found, expected in zip(*each, strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-13 * np.max(np.abs(expected)))
    # Long chains are made to do without Pinocchio's data: of free-flyers they have none.
    assert [calls.model.nv for calls in vars(chain._of_thread).values()] == (
        [mechanism.model.nv] if most_placed else []
    )
