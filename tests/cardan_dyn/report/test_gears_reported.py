"""Reports of gears: nothing that is not known is reported as zero."""

from __future__ import annotations

import html
import re
from pathlib import Path

import numpy as np
import pytest
from testkit.linkages import LINK, coupling, gears

import cardan_dyn as cd
from cardan_dyn.practice.report.reporting import Report


@pytest.mark.usefixtures("without_pictures")
@pytest.mark.parametrize(
    ("stated", "told", "summary"),
    [
        ("", "presses on their bearings is not described", "What joints carry is not known"),
        ('forces="none"', "All wrenches follow", "Joints carry nothing."),
        ('forces="mesh"', "All wrenches follow", "What joints are sized by"),
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
    assert ("Zero throughout" in text) == bool(stated)
    assert ">drive effort<" in text  # Also where no joint carries anything.
    assert ("not described" in str(report)) == (not stated)
    assert ("nothing acts" in repr(scene.sweep([0.0])["a"])) == ("none" in stated)


@pytest.mark.slow
@pytest.mark.usefixtures("without_pictures")
def test_what_is_not_known_is_not_reported_as_zero(tmp_path: Path) -> None:
    """Weight lies across the shafts: nothing would be along them, if nothing but weight acted."""
    for stated, listed in (("", False), ('forces="none"', True)):
        mechanism = cd.load(gears(coupling("teeth", "a", "b", -2.5, stated)))
        scene = cd.Scene(mechanism, drive="a", loads={"b": -50.0}, gravity=(0.0, -9.81, 0.0))
        report = Report(scene.sweep(np.linspace(0.0, 2.0 * np.pi, 13)))
        text = report.save(tmp_path / "gears.html", scene=False).read_text(encoding="utf-8")
        assert ("Zero throughout" in text) == listed


RIG = f"""<robot name="rig"><link name="ground"/>
  {LINK.format(name="wheel_a", com="0 0 0", mass="1")}
  {LINK.format(name="wheel_b", com="0 0 0", mass="1")}
  {LINK.format(name="door", com="0 1 0", mass="1")}
  <joint name="a" type="continuous"><parent link="ground"/><child link="wheel_a"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="b" type="continuous"><parent link="ground"/><child link="wheel_b"/>
    <origin xyz="1 0 0"/><axis xyz="0 0 1"/></joint>
  <joint name="hinge" type="continuous"><parent link="wheel_b"/><child link="door"/>
    <origin xyz="0 1 0"/><axis xyz="0 0 1"/></joint>
  <loop name="second_hinge" type="continuous"><predecessor link="wheel_b">
    <origin xyz="0 1 2"/></predecessor><successor link="door"><origin xyz="0 0 2"/></successor>
    <axis xyz="0 0 1"/></loop>
  {coupling("teeth", "a", "b", -2.5)}</robot>"""
"""Shafts whose teeth say nothing; at one of them a door on two hinges, of which statics decides
neither."""
SILENT = "how 'teeth', which couples a and b, presses on their bearings is not described"
CHOSEN = "not determined by statics, chosen by least norm"


@pytest.mark.usefixtures("without_pictures")
@pytest.mark.parametrize(
    ("outputs", "chosen", "silent"),
    [(["a", "b"], (), ("a", "b")), (None, ("hinge", "second_hinge"), ("a", "b"))],
)
def test_a_star_is_explained_by_what_leaves_its_row_open(
    outputs: list[str] | None, chosen: tuple[str, ...], silent: tuple[str, ...], tmp_path: Path
) -> None:
    scene = cd.Scene(cd.load(RIG), drive="a", held={"hinge": 0.0}, outputs=outputs)
    turn = scene.replace(gravity=(0.0, -9.81, 0.0)).sweep(np.linspace(0.0, 1.0, 3))
    report = Report(turn)
    starred = {item.owner for item in report.extremes if item.acts and not item.determined}
    assert starred == {*chosen, *silent}
    (line,) = (line for line in str(report).splitlines() if line.startswith("* "))
    page = report.save(tmp_path / "rig.html", scene=False).read_text(encoding="utf-8")
    (shown,) = re.findall(r'<p class="open"><span class="mark">\*</span> (.*?)</p>', page)
    note = turn.plot(*silent).legends[0].get_title().get_text().replace("\n", " ")
    assert SILENT in note and "chosen by" not in note
    for text in (line, html.unescape(shown)):
        text = text.lower()
        rule, _, told = text.rpartition(SILENT)
        assert told.startswith(": ") and all(re.search(rf"\b{name}\b", told) for name in silent)
        assert (CHOSEN in rule) == bool(chosen)
        assert all(name in rule and name not in told for name in chosen)
        assert not any(re.search(rf"\b{name}[,\s(]", rule) for name in silent)
