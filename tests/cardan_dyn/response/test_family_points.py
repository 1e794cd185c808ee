"""Points of families: which part of a grid each design has, and what is evaluated when."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.linkages import coupling, gears

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


def test_moments_of_couplings_are_gathered_when_they_are_read(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    mechanism = cd.load(gears(coupling("g", "a", "b", -3.0)))
    scene = cd.Scene(mechanism, drive="a", loads={"b": -5.0})
    family, asked = scene.responses({}), []
    gathered = FamilyPoints.gathered
    monkeypatch.setattr(
        FamilyPoints, "gathered", lambda *given: asked.append(1) or gathered(*given)
    )
    moments = family.sweep(np.zeros(3)).coupling_moment
    assert list(moments) == ["g"] and len(moments) == 1
    assert not asked
    np.testing.assert_allclose(moments["g"], np.full(3, 5.0), rtol=1e-12)
    assert moments["g"] is moments["g"]
    assert asked == [1]
    with pytest.raises(KeyError):
        moments["nothing"]
