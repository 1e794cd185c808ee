"""Derivatives of random chains: forwards, backwards, by the proof, and by differences of sweeps."""

from __future__ import annotations

import numpy as np
import pytest
from compare import scene_of
from scenes import draw

import cardan_dyn as cd

STEP = 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(40))
def test_derivatives_of_a_random_chain(seed: int) -> None:
    case, rng = draw(seed), np.random.default_rng(seed)
    scene = scene_of(case)

    def swept(by: float = 0.0) -> cd.Sweep:
        positions = case.positions.copy()
        positions[:, 0] += by
        return scene.sweep(positions, speed=case.speeds, acceleration=case.accelerations)

    sweep, drive = swept(), scene.drives[0]
    units = np.repeat([scene.mechanism.characteristic_length, 1.0], 3)

    def wrenches(of: object) -> np.ndarray:
        """Components that are unique, forces times the length."""
        parts = [np.hstack([of[name].force, of[name].moment]) for name in sweep.outputs]
        kept = [sweep[name].unique for name in sweep.outputs]
        return np.array(
            [np.where(own, part * units, 0.0) for part, own in zip(parts, kept, strict=True)]
        )

    rounding = max(1.0, float(np.max(sweep.condition)) / 1e3)
    # With `*`, those that open loops are left out.
    names = drive, f"speed:{drive}", "gravity.*", "mass:*", "origin:*.x"
    found = sweep.derivative(*names)
    weights = {}
    for name in sweep.outputs:
        unique = sweep[name].unique
        weights[f"{name}.force"] = rng.normal(size=(*sweep.shape, 3)) * unique[:3]
        weights[f"{name}.moment"] = rng.normal(size=(*sweep.shape, 3)) * unique[3:]
    slopes = sweep.gradient(weights, *names)
    assert list(slopes) == list(found)
    own = np.array(
        [
            np.hstack([weights[f"{name}.force"], weights[f"{name}.moment"]]) / units
            for name in sweep.outputs
        ]
    )
    products = {name: own * wrenches(of) for name, of in found.items()}
    greatest = max(np.abs(product).sum() for product in products.values())
    for name, product in products.items():
        # Where nothing changes, rounding is that of others.
        size = np.abs(product).sum() + 1e-2 * greatest
        assert abs(slopes[name] - product.sum()) <= 1e-12 * rounding * size, name
        assert found[name].loop_residual < 1e-10 * rounding, name
        assert not found[name].balance_residual > 1e-12 * rounding, name
    far_back, back, ahead, far_ahead = (wrenches(swept(k * STEP)) for k in (-2, -1, 1, 2))
    change = (8.0 * (ahead - back) - (far_ahead - far_back)) / (12.0 * STEP)
    size = np.abs(change).max() + 1e-3 * np.abs(wrenches(sweep)).max()
    assert np.abs(change - wrenches(found[drive])).max() <= 1e-6 * rounding * size
