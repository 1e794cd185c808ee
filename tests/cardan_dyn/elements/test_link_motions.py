"""Motions of links against Pinocchio's frames, for joints of every kind."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from testkit.mixed_chain import MIXED, rows

import cardan_dyn as cd
from cardan_dyn.core.elements.link_motions import LinkMotions


@pytest.mark.parametrize("cardan", [(), ("ball",)])
def test_links_are_where_pinocchio_has_them(cardan: tuple[str, ...]) -> None:
    mechanism = cd.load(MIXED).variant(cardan)
    x = rows(mechanism, 6, seed=3)
    v = np.random.default_rng(4).uniform(-2.0, 2.0, (6, mechanism.model.nv))
    motions = LinkMotions(mechanism, mechanism.links)
    found = motions.at(x, v)
    model, data = mechanism.model, mechanism.model.createData()
    for sample, q in enumerate(mechanism.coordinates.configuration(x)):
        pinocchio.forwardKinematics(model, data, q, v[sample])
        for link, (body, frame) in mechanism.links.items():
            motion, placed = found[link], data.oMi[body] * frame
            at = min(sample, len(motion.position) - 1)
            np.testing.assert_allclose(motion.rotation[at], placed.rotation, atol=1e-14)
            position = motion.position[at] + motions.corner
            np.testing.assert_allclose(position, placed.translation, atol=1e-13)
            twist = pinocchio.Motion.Zero() if body == 0 else data.v[body]
            local = frame.actInv(twist)
            np.testing.assert_allclose(
                motion.velocity[at], placed.rotation @ local.linear, atol=1e-12
            )
            np.testing.assert_allclose(motion.spin[at], placed.rotation @ local.angular, atol=1e-12)


def test_bodies_that_move_no_link_are_left_alone() -> None:
    mechanism = cd.load(MIXED)
    x = rows(mechanism, 2)
    x[:, mechanism.coordinates.columns["hinge"]] = np.nan
    found = LinkMotions(mechanism, ["left"]).at(x, np.zeros((2, mechanism.model.nv)))
    assert np.all(np.isfinite(found["left"].position))
