"""Polar diagrams with reversals: curves, arrows and labels against the scan."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="figures need matplotlib")

from testkit.drawings import check_units_and_files

import cardan_dyn as cd
from cardan_dyn.clearance import Scan, scan
from cardan_dyn.motion.clearance import drawing


@pytest.fixture(scope="module")
def scanned() -> Scan:
    drive = cd.Scene(cd.load("needle_drive"), drive="main_shaft")
    return scan(drive, 300.0, clearance=1e-4, stiffness=1e8)


@pytest.mark.slow
def test_every_joint_has_its_diagram_and_its_reversals(scanned: Scan, tmp_path: Path) -> None:
    figure = drawing.force_reversals(scanned, title="forces")
    check_units_and_files(figure, tmp_path)
    assert [axes.get_title().split("\n")[0] for axes in figure.axes] == scanned.ranking
    for axes, name in zip(figure.axes, scanned.ranking, strict=True):
        joint = scanned[name]
        curve = axes.get_lines()[0].get_xydata()
        # All pins are parallel to z; the curve is closed.
        np.testing.assert_array_equal(curve[:-1], joint.force[:, :2])
        np.testing.assert_array_equal(curve[0], curve[-1])
        tips = [text.xy for text in axes.texts if text.arrow_patch is not None]
        assert len(tips) == len(joint.reversals) == 2
        for tip, item in zip(tips, joint.reversals, strict=True):
            np.testing.assert_allclose(
                tip, 0.35 * joint.rigid_peak * item.direction[:2], rtol=1e-12
            )
        labels = {text.get_text() for text in axes.texts}
        assert {f"{np.rad2deg(item.position):.0f}°" for item in joint.reversals} <= labels
        assert {"90°", "270°"} <= labels


def test_arrows_of_what_does_not_strike_are_dashed() -> None:
    loads = {"piston_guide": -300.0}
    scene = cd.Scene(cd.load("slider_crank"), drive="crank_bearing", loads=loads)
    found = scan(scene, 120.0, clearance=1e-4, stiffness=1e8, damping_ratio=0.25)
    for name in ("piston_pin", "crank_pin"):
        (axes,) = drawing.force_reversals(found, name, plane="xy").axes
        styles = [text.arrow_patch.get_linestyle() for text in axes.texts if text.arrow_patch]
        assert styles == ["-" if item.strikes else "--" for item in found[name].reversals]
    assert found["piston_pin"].impacts == 2 and found["crank_pin"].impacts == 0


@pytest.mark.parametrize(("joints", "plane"), [("needle", None), ("needle_pin", "xx")])
def test_bad_input(scanned: Scan, joints: str, plane: Any) -> None:
    with pytest.raises(cd.CardanError):
        drawing.force_reversals(scanned, joints, plane=plane)
