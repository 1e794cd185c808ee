"""Building of families: what is solved together, and designs that do not come back."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.bars_of_lengths import four_bar_of_lengths

import cardan_dyn as cd
from cardan_dyn.kinematics.assembly import Assembly
from cardan_dyn.response import family_build
from cardan_dyn.response.sampling import Request


def test_designs_are_closed_in_few_calls(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = cd.Scene(
        cd.load("universal_joint"),
        drive="bearing_in",
        held={"joint_angle": 0.5},
        loads={"bearing_out": -100.0},
    )
    calls, close = [], Assembly.close

    def counting(self: Assembly, *arguments: object) -> object:
        calls.append(1)
        return close(self, *arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(Assembly, "close", counting)
    family = scene.responses({"joint_angle": np.linspace(0.1, 0.8, 40)})
    assert np.all(family.sample_count >= 128)
    # Forty designs of 160 positions in blocks of some 1024 samples, and two calls for their ends.
    assert len(calls) < 20


def test_requests_are_divided_by_kind_and_size(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(family_build, "_MOST_SAMPLES", 10)
    sizes = {0: 4, 1: 12, 2: 6, 3: 4, 4: 4}
    requests = {index: Request(np.zeros(size), proven=index != 3) for index, size in sizes.items()}
    assert list(family_build._portions(requests)) == [[0], [1], [2, 4], [3]]


def test_designs_that_do_not_turn_through_are_named() -> None:
    """Grashof: the shortest and the longest bar are together no longer than the other two."""
    scene = cd.Scene(
        four_bar_of_lengths(), drive="drive", held={"frame": 0.0}, loads={"bearing": -1.0}
    )
    longer = np.array([0.0, 0.1, 0.14, 0.16])
    assert scene.responses({"frame": longer[:3]}).shape == (3,)
    with pytest.raises(cd.AssemblyError, match=r"^design 3: "):
        scene.responses({"frame": longer})
    part = scene.responses({"frame": longer}, interval=(-1.0, 1.0))
    expected = scene.sweep(0.7, held={"frame": longer})["pin"].force
    np.testing.assert_allclose(part.sweep(0.7)["pin"].force, expected, atol=1e-10)
