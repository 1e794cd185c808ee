"""The public face of sweeps: tables and markup, which no other sweep has to import."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from testkit.scenes import universal

import cardan_dyn as cd

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def turn(joint: cd.Mechanism) -> cd.Sweep:
    return universal(joint, 0.5).sweep(np.linspace(0.0, 1.0, 5), speed=2.0)


def test_tables_hold_the_motion_unless_told_otherwise(turn: cd.Sweep) -> None:
    assert turn.to_xarray().identical(turn.to_xarray(motion=True))
    assert turn.to_dataframe().equals(turn.to_dataframe(motion=True))
    with pytest.raises(TypeError):
        turn.to_xarray(False)  # type: ignore[misc]


def test_scenes_and_responses_return_the_same_kind(joint: cd.Mechanism, turn: cd.Sweep) -> None:
    evaluated = universal(joint, 0.5).response().sweep(turn.position, speed=2.0)
    assert type(turn) is type(evaluated) is cd.Sweep
    columns = turn.to_dataframe().columns
    assert list(evaluated.to_dataframe().columns) == list(columns)


def test_a_sweep_imports_tables_and_axes_only_when_asked() -> None:
    code = (
        "import sys, cardan_dyn as cd; "
        "turn = cd.Scene(cd.load('four_bar'), drive='crank_bearing').sweep([0.0]); "
        "print(*sorted(name for name in sys.modules if name.startswith(('xarray', 'pandas')) or "
        "name.startswith('cardan_dyn.core.results.') and name.endswith('axes')))"
        "; turn._repr_html_(); turn.wrench('crank_pin', 'world'); "
        "print('cardan_dyn.core.results.axes' in sys.modules)"
    )
    ran = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert ran.stdout.splitlines() == ["", "True"]
