"""Scenes with one and several coordinates, and what Pinocchio's trees and welds say of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin
from scipy.linalg import null_space

import cardan_dyn as cd
from cardan_dyn.kit.arrays import Array

from . import linkages

GRAVITY = (0.4, -0.3, -9.81)
LEGS = [f"leg_{k}" for k in range(1, 7)]
BARS = linkages.four_bar(linkages.loop("continuous"))


def scene_of(name: str) -> cd.Scene:
    """Return scenes with one and with several coordinates, driven and free."""
    made: dict[str, Callable[[], cd.Scene]] = {
        "four_bar": lambda: cd.Scene(cd.load(BARS), drive="a", gravity=GRAVITY),
        "free four-bar": lambda: cd.Scene(cd.load(BARS), free="a", gravity=GRAVITY),
        "slider_crank": lambda: cd.Scene(
            cd.load("slider_crank"), drive="crank_bearing", gravity=GRAVITY
        ),
        "universal": lambda: cd.Scene(
            cd.load("universal_joint"), drive=["bearing_in", "joint_angle"], gravity=GRAVITY
        ),
        "half free": lambda: cd.Scene(
            cd.load("universal_joint"), drive="joint_angle", free="bearing_in", gravity=GRAVITY
        ),
        "stewart": lambda: cd.Scene(cd.load("stewart_platform"), drive=LEGS, gravity=GRAVITY),
    }
    return made[name]()


SCENES = ("four_bar", "free four-bar", "slider_crank", "universal", "half free", "stewart")


def motion_of(scene: cd.Scene, count: int = 5) -> tuple[Array, Array, Array]:
    """Return positions near the start, speeds and accelerations `(count, n)`."""
    rng, n = np.random.default_rng(len(scene.coordinates)), len(scene.coordinates)
    mechanism = scene.mechanism
    start = [scene.configuration().positions[name] for name in scene.coordinates]
    sizes = np.array([0.02 if mechanism.drivable[c].slides else 0.6 for c in scene.coordinates])
    moved = rng.uniform(0.3, 1.0, (count, n)) * sizes
    return start + moved, rng.normal(size=(count, n)), 3.0 * rng.normal(size=(count, n))


def as_given(scene: cd.Scene, values: Array) -> Array:
    """Return values `(..., n)` as scenes take them: without a last axis for a single name."""
    return values if scene.problem.listed or values.shape[-1] > 1 else values[..., 0]


def all_driven(scene: cd.Scene, **changes: Any) -> cd.Scene:
    return scene.replace(drive=[*scene.coordinates], free=None, **changes)


def ratios_by_pinocchio(scene: cd.Scene, q: Array) -> tuple[pin.Data, Array]:
    """Return data at a configuration, and velocity ratios `(nv, n)` from welds' null space."""
    mechanism, rows = scene.mechanism, [np.zeros((0, scene.mechanism.model.nv))]
    model, data = mechanism.model, mechanism.model.createData()
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    for weld in mechanism.constraint_models:
        # Either weld as a twist of its own frame in world axes.
        ends = []
        for joint, placement in (
            (weld.joint1_id, weld.joint1_placement),
            (weld.joint2_id, weld.joint2_placement),
        ):
            at = (data.oMi[joint] * placement).translation
            own = pin.getJointJacobian(model, data, joint, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
            arm = at - data.oMi[joint].translation
            ends.append(np.vstack([own[:3] - pin.skew(arm) @ own[3:], own[3:]]))
        rows.append(ends[0] - ends[1])
    rates = mechanism.coordinates.rates_of
    held = np.eye(model.nv)[rates(scene.held)]
    motions = null_space(np.vstack([*rows, held]), rcond=1e-10)
    return data, motions @ np.linalg.inv(motions[rates(scene.coordinates)])


def sloped(values: Callable[[float], Array], step: float = 1e-3) -> Array:
    """Return a difference of fourth order."""
    far_back, back, ahead, far_ahead = (values(k * step) for k in (-2.0, -1.0, 1.0, 2.0))
    return (8.0 * (ahead - back) - (far_ahead - far_back)) / (12.0 * step)


def agree(found: Any, expected: Any, tolerance: float) -> None:
    """Compare arrays by the greatest of all numbers."""
    size = np.abs(expected).max()
    np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance * size)
