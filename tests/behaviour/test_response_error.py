"""The error that a response reports, against deviations from direct sweeps between its samples."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from testkit.scenes import double, universal

import cardan_dyn as cd

EPS = float(np.finfo(float).eps)


def true_error(
    scene: Callable[[float], cd.Scene], response: cd.Response, positions: np.ndarray
) -> float:
    """Greatest deviation from direct sweeps, column by column, as `Proof.error` is defined."""
    worst = 0.0
    for load, speed, acceleration in ((-2.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)):
        loaded = scene(load)
        length = loaded.mechanism.characteristic_length
        loads = dict.fromkeys(loaded.loads, load)
        direct = loaded.sweep(positions, speed, acceleration)
        evaluated = response.sweep(positions, speed, acceleration, loads=loads)
        pairs = [(direct.drive_effort[:, None], evaluated.drive_effort[:, None])]
        for name in loaded.outputs:
            exact, approximate = (
                np.concatenate([length * sweep[name].force, sweep[name].moment], axis=1)
                for sweep in (direct, evaluated)
            )
            pairs += [(exact, approximate)]
        sizes = [float(np.max(np.abs(exact))) for exact, _ in pairs]
        for (exact, approximate), size in zip(pairs, sizes, strict=True):
            scale = max(size, 0.1 * max(sizes))
            worst = max(worst, float(np.max(np.abs(approximate - exact))) / scale)
    return worst


def near_the_ends(response: cd.Response) -> np.ndarray:
    """Positions everywhere, closer and closer towards the ends, and between the last samples."""
    low, high = response.interval
    share = np.concatenate([np.geomspace(1e-9, 0.5, 60), np.linspace(0.0, 0.5, 60)])
    share = np.append(
        share, 0.5 - 0.5 * np.cos(np.linspace(0.0, 12.0 * np.pi, 49) / response.sample_count)
    )
    return np.clip(
        np.concatenate([low + share * (high - low), high - share * (high - low)]), low, high
    )


RANGES: dict[str, dict[str, object]] = {
    "four_bar": {"drive": "rocker_bearing"},
    "slider_crank": {"drive": "piston_guide", "near": {"crank_bearing": 1.0}},
    "needle_drive": {"drive": "needle_guide", "near": {"main_shaft": 1.0}},
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "left"),
    [("four_bar", (1e-3, 1e-3)), ("slider_crank", (0.3, 1e-4)), ("needle_drive", (1e-2, 1e-2))],
)
def test_the_error_near_dead_points_is_reported_within_a_factor_of_30(
    name: str, left: tuple[float, float]
) -> None:
    mechanism = cd.load(name)
    loaded = "main_shaft" if name == "needle_drive" else "crank_bearing"

    def scene(load: float) -> cd.Scene:
        return cd.Scene(mechanism, loads={loaded: load}, **RANGES[name])

    low, high = scene(0.0).motion_range()
    for tolerance in (1e-4, 1e-6, 1e-9, 1e-12):
        response = scene(-2.0).response(
            tolerance, interval=(low + left[0] * (high - low), high - left[1] * (high - low))
        )
        true = true_error(scene, response, near_the_ends(response))
        assert response.error >= 0.3 * true
        assert response.error <= 30.0 * true
        # Rounding, which no number of samples lowers, may stop short of the tolerance.
        assert true <= tolerance + 10.0 * EPS * response.proof.condition


@pytest.mark.slow
@pytest.mark.parametrize(
    ("beta_deg", "tolerance"), [(8.5, 1e-13), (50.0, 1e-8), (80.0, 1e-4), (89.0, 1e-13)]
)
def test_the_error_of_a_cardan_joint_is_reported_within_a_factor_of_100(
    joint: cd.Mechanism, beta_deg: float, tolerance: float
) -> None:
    beta = np.deg2rad(beta_deg)
    response = universal(joint, beta).response(tolerance)
    # The peaks are narrow at 89°.
    peaks = np.outer([-1.0, 1.0], np.geomspace(1e-6, 1.0, 100)).ravel()
    positions = np.concatenate([np.linspace(0.0, 6.3, 400), 0.5 * np.pi + peaks])
    true = true_error(lambda load: universal(joint, beta, load), response, positions)
    assert 0.3 * true <= response.error <= 100.0 * true


@pytest.mark.parametrize("betas", [(0.7, 0.5), (0.1, 0.1), (1.2, 0.9)], ids=str)
def test_the_error_of_a_double_shaft_is_reported_within_a_factor_of_100(
    shaft: cd.Mechanism, betas: tuple[float, float]
) -> None:
    for tolerance in (1e-4, 1e-8, 1e-13):
        response = double(shaft, *betas).response(tolerance)
        positions = np.linspace(0.0, 6.3, 400)
        true = true_error(lambda load: double(shaft, *betas, load), response, positions)
        assert 0.3 * true <= response.error <= 100.0 * true
