"""Welds as Pinocchio has them."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from testkit.mixed_chain import MIXED

import cardan_dyn as cd
from cardan_dyn.mechanism.welds import characteristic_length, constraint_models


def test_loops_are_pinocchios_constraints() -> None:
    mechanism = cd.load(MIXED)
    models = constraint_models(mechanism.model, mechanism.loops)
    assert len(models) == 3
    for model, loop in zip(models, mechanism.loops, strict=True):
        assert (model.joint1_id, model.joint2_id) == (loop.predecessor, loop.successor)
        np.testing.assert_array_equal(
            model.joint2_placement.homogeneous, loop.successor_placement.homogeneous
        )
        assert model.type == pinocchio.ContactType.CONTACT_6D


def test_welds_count_in_the_length_of_a_mechanism() -> None:
    """The bolt is welded to the world 3 m from the hinge `turn`."""
    mechanism = cd.load(MIXED)
    ends = np.array([[1.0, 2.0, 3.0], [0.7, 1.5, 2.5]])
    apart = float(np.max(np.linalg.norm(ends - ends.mean(axis=0), axis=1)))
    alone = characteristic_length(mechanism.model, ())
    assert characteristic_length(mechanism.model, mechanism.loops) == max(alone, apart)
    assert mechanism.characteristic_length == pytest.approx(max(alone, apart))
    # It is the same however the balls are written.
    variant = mechanism.variant(["ball"])
    assert variant.characteristic_length == mechanism.characteristic_length
