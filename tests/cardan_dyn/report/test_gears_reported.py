"""Reports of gears: nothing that is not known is reported as zero."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from testkit.linkages import coupling, gears

import cardan_dyn as cd
from cardan_dyn.report.reporting import Report


@pytest.mark.parametrize(
    ("stated", "told", "summary"),
    [
        ("", "presses on their bearings is not described", "What joints carry is not known"),
        ('forces="none"', "All wrenches follow", "Joints carry nothing; the greatest drive effort"),
        ('forces="mesh"', "All wrenches follow", "The greatest force is"),
    ],
)
def test_geared_shafts_that_bear_a_torque(
    stated: str, told: str, summary: str, tmp_path: Path
) -> None:
    mechanism = cd.load(gears(coupling("teeth", "a", "b", -2.5, stated)))
    scene = cd.Scene(mechanism, drive="a", loads={"b": -50.0})
    report = Report(scene.sweep(np.linspace(0.0, 2.0 * np.pi, 13)))
    text = report.save(tmp_path / "gears.html", scene=False).read_text(encoding="utf-8")
    assert told in text
    assert summary in text
    assert ("Zero throughout" in text) == ("mesh" in stated)
    assert ("not described" in str(report)) == (not stated)
    assert ("nothing acts" in repr(scene.sweep([0.0])["a"])) == ("none" in stated)


def test_what_is_not_known_is_not_reported_as_zero(tmp_path: Path) -> None:
    """Weight lies across the shafts: nothing would be along them, if nothing but weight acted."""
    for stated, listed in (("", False), ('forces="none"', True)):
        mechanism = cd.load(gears(coupling("teeth", "a", "b", -2.5, stated)))
        scene = cd.Scene(mechanism, drive="a", loads={"b": -50.0}, gravity=(0.0, -9.81, 0.0))
        report = Report(scene.sweep(np.linspace(0.0, 2.0 * np.pi, 13)))
        text = report.save(tmp_path / "gears.html", scene=False).read_text(encoding="utf-8")
        assert ("Zero throughout" in text) == listed
