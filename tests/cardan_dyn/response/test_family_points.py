"""Points of families: which part of a grid each design has, and what is evaluated when."""

from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.response.family_points import FamilyPoints
from cardan_dyn.response.operating_points import OperatingPoints


@pytest.fixture(scope="module")
def scene() -> cd.Scene:
    return cd.Scene(
        cd.load("universal_joint"),
        drive="bearing_in",
        held={"joint_angle": 0.5},
        loads={"bearing_out": -100.0},
    )


@pytest.mark.parametrize(
    ("designs", "positions", "shape"),
    [
        ((3, 1), (4,), (3, 4)),
        ((3,), (4, 1), (4, 3)),
        ((3,), (3,), (3,)),
        ((2, 1, 3), (5, 1), (2, 5, 3)),
    ],
)
def test_designs_broadcast_with_positions(
    scene: cd.Scene,
    designs: tuple[int, ...],
    positions: tuple[int, ...],
    shape: tuple[int, ...],
) -> None:
    rng = np.random.default_rng(0)
    angle, position = rng.uniform(0.1, 0.9, designs), rng.uniform(-3.0, 3.0, positions)
    turn = scene.responses({"joint_angle": angle}).sweep(position)
    assert turn.shape == shape
    expected = scene.sweep(
        np.broadcast_to(position, shape), held={"joint_angle": np.broadcast_to(angle, shape)}
    )
    for part in ("force", "moment"):
        first, second = getattr(turn["pin_in"], part), getattr(expected["pin_in"], part)
        np.testing.assert_allclose(first, second, atol=1e-10)
    np.testing.assert_allclose(turn["pin_in"].bending, expected["pin_in"].bending, atol=1e-10)
    np.testing.assert_allclose(turn.motion.position("pin_in"), expected.motion.position("pin_in"))


def test_nothing_is_evaluated_that_is_not_read(
    scene: cd.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    evaluated: list[int] = []
    combined = OperatingPoints.combined

    def counting(self: OperatingPoints, rows: object) -> object:
        evaluated.append(1)
        return combined(self, rows)  # type: ignore[arg-type]

    monkeypatch.setattr(OperatingPoints, "combined", counting)
    turn = scene.responses({"joint_angle": [0.1, 0.2]}).sweep(1.0)
    assert isinstance(turn._source, FamilyPoints)
    assert not evaluated
    assert turn.drive_effort.shape == (2,)
    assert len(evaluated) == 2
