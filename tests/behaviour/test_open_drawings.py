"""Four-bars that are drawn open: closed as they are drawn, and never crossed without a word."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from testkit.compound_joints import Z, body, joint, loop, robot

import cardan_dyn as cd

CRANK, COUPLER, ROCKER = 0.1, 0.3, 0.2
AT = 0.05
"""Angle at which the crank is drawn [rad]."""


def tips(ground: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the crank's tip and both places of the rocker's, where two circles meet."""
    tip = CRANK * np.array([np.cos(AT), np.sin(AT)])
    way = np.array([ground, 0.0]) - tip
    size = float(np.linalg.norm(way))
    along = (COUPLER**2 - ROCKER**2 + size**2) / (2.0 * size)
    across = np.sqrt(max(COUPLER**2 - along**2, 0.0)) * np.array([-way[1], way[0]]) / size
    return tip, np.stack([tip + along * way / size + side * across for side in (1.0, -1.0)])


def drawn(ground: float, gap: tuple[float, float]) -> cd.Mechanism:
    """Return the four-bar as it is drawn at its first assembly, the rocker's tip off by a gap."""
    tip, (there, _) = tips(ground)
    foot = np.array([ground, 0.0])

    def xyz(place: np.ndarray) -> str:
        return f'xyz="{float(place[0])!r} {float(place[1])!r} 0"'

    ends = xyz(there - tip), xyz(there + np.array(gap) - foot)
    return cd.load(
        robot(
            body("crank_arm", 0.5, "0.05 0 0"),
            joint("crank", "continuous", "ground crank_arm", "", (Z,)),
            body("bar", 0.8, "0.1 0 0"),
            joint("coupler", "continuous", "crank_arm bar", xyz(tip), (Z,)),
            body("rocker_arm", 0.6, "0 0.1 0"),
            joint("rocker", "continuous", "ground rocker_arm", xyz(foot), (Z,)),
            loop("pin", "continuous", "bar rocker_arm", ends, (Z,)),
        )
    )


def assemblies(ground: float, gap: tuple[float, float]) -> list[np.ndarray]:
    """Return turns `(2,)` of coupler and rocker in both assemblies, by the circles of the links."""
    tip, (there, _) = tips(ground)
    foot = np.array([ground, 0.0])
    arms = there - tip, there + np.array(gap) - foot
    long, short = (float(np.linalg.norm(arm)) for arm in arms)
    way = foot - tip
    size = float(np.linalg.norm(way))
    along = (long**2 - short**2 + size**2) / (2.0 * size)
    across = np.sqrt(long**2 - along**2) * np.array([-way[1], way[0]]) / size
    turns = []
    for side in (1.0, -1.0):
        at = tip + along * way / size + side * across
        pairs = zip((at - tip, at - foot), arms, strict=True)
        turns.append(
            np.array([np.angle(complex(*after) / complex(*before)) for after, before in pairs])
        )
    return turns


def turned(scene: cd.Scene) -> np.ndarray:
    start = scene.configuration()
    return np.array([start["coupler"], start["rocker"]])


@pytest.mark.parametrize("gap", [(0.0, -0.004), (0.0, 0.004), (0.003, 0.0), (-0.003, -0.002)])
@pytest.mark.parametrize("ground", [0.4, 0.5, 0.585])
def test_what_is_drawn_bent_is_closed_as_drawn(ground: float, gap: tuple[float, float]) -> None:
    nearest, other = sorted(assemblies(ground, gap), key=np.linalg.norm)
    assert np.linalg.norm(other) > 5.0 * np.linalg.norm(nearest)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        np.testing.assert_allclose(turned(cd.Scene(drawn(ground, gap), drive="crank")), nearest)


STRETCHED, GAP = 0.5999, (0.0, -0.004)


def test_both_assemblies_beside_a_stretched_drawing_are_told() -> None:
    mechanism = drawn(STRETCHED, GAP)
    nearest, other = sorted(assemblies(STRETCHED, GAP), key=np.linalg.norm)
    with pytest.warns(UserWarning, match="two assemblies lie beside it") as said:
        scene = cd.Scene(mechanism, drive="crank")
        np.testing.assert_allclose(turned(scene), nearest, atol=1e-9)
    (text,) = (str(item.message) for item in said)
    for taken in (nearest, other):
        assert f"coupler {taken[0]:.4g}, " in text
        assert f"rocker {taken[1]:.4g}, " in text
        assert f"{np.linalg.norm(2.0 * np.sin(0.5 * taken)):.3g}" in text
    assert text.index(f"{nearest[1]:.4g}") < text.index("is taken") < text.index(f"{other[1]:.4g}")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        cd.Scene(mechanism, drive="crank").configuration()  # It was said.


def test_a_start_says_which_is_meant() -> None:
    _, other = sorted(assemblies(STRETCHED, GAP), key=np.linalg.norm)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        near = {"crank": 0.0, "coupler": round(other[0], 4), "rocker": round(other[1], 4)}
        scene = cd.Scene(drawn(STRETCHED, GAP), drive="crank", near=near)
        assert np.linalg.norm(turned(scene) - other) < 5e-3
