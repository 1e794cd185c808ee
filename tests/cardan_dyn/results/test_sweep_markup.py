"""Sweeps in notebooks: greatest wrenches, residuals, escaped texts."""

from __future__ import annotations

import re
from html import unescape
from html.parser import HTMLParser

import numpy as np
import pytest
from testkit.linkages import coupling, gears
from testkit.scenes import universal

import cardan_dyn as cd
from cardan_dyn.core.results.sweep import Sweep
from cardan_dyn.core.results.wrench import JointWrench

POSITIONS = np.linspace(0.0, 6.0, 25)


class Balanced(HTMLParser):
    """Checks that every tag is closed by its own."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def table_rows(markup: str) -> list[list[str]]:
    """Return the texts of all cells, row by row."""
    return [
        [unescape(cell) for cell in re.findall(r"<t[hd]>(.*?)</t[hd]>", row)]
        for row in re.findall(r"<tr>(.*?)</tr>", markup)
    ]


def test_a_row_per_output_with_its_greatest_values(joint: cd.Mechanism) -> None:
    scene = universal(joint, 0.5, gravity=(0.0, 0.0, -9.81), outputs=["bearing_out", "pin_in"])
    turn = scene.sweep(POSITIONS)
    markup = turn._repr_html_()
    Balanced(markup)
    assert markup.startswith("<div><p>Sweep of universal_joint: 25 samples</p><table>")
    header, bearing, pin, *residuals = table_rows(markup)
    moments = [f"{name} [N·m]" for name in ("moment", "torsion", "bending")]
    assert header == ["joint", "force [N]", *moments, "unique"]
    for row, name in ((bearing, "bearing_out"), (pin, "pin_in")):
        force, moment, axis = turn[name].force, turn[name].moment, joint[name].axis
        across = moment - np.outer(moment @ axis, axis)
        greatest = (
            np.sqrt(np.max(np.sum(force**2, axis=1))),
            np.sqrt(np.max(np.sum(moment**2, axis=1))),
            np.max(np.abs(moment @ axis)),
            np.sqrt(np.max(np.sum(across**2, axis=1))),
        )
        assert row[0] == name
        # Four digits are shown.
        assert [float(cell) for cell in row[1:5]] == pytest.approx(greatest, rel=6e-4, abs=1e-12)
        assert row[5] == "not force xyz"
    assert residuals == [
        ["residual", "value"],
        ["loop", f"{turn.loop_residual:.1e}"],
        ["balance", f"{turn.balance_residual:.1e}"],
        ["power", f"{turn.power_residual:.1e}"],
        ["rate", f"{turn.rate_residual:.1e}"],
    ]


def test_what_is_unique_is_told_as_such() -> None:
    stated = gears(coupling("mesh", "a", "b", 2.0, 'forces="none"'))
    turn = cd.Scene(cd.load(stated), drive="a").sweep(POSITIONS)
    rows = table_rows(turn._repr_html_())
    assert [row[5] for row in rows[1:3]] == ["yes", "yes"]
    silent = cd.Scene(cd.load(stated.replace('forces="none"', "")), drive="a").sweep(POSITIONS)
    rows = table_rows(silent._repr_html_())
    assert [row[5] for row in rows[1:3]] == ["not force xyz, moment xyz"] * 2
    assert "which couples a and b, presses on their bearings is not described" in (
        silent._repr_html_()
    )


def test_what_is_known_of_an_open_force_is_told_beside_it() -> None:
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", loads={"rocker_bearing": -10.0})
    turn = scene.replace(gravity=(0.0, 0.0, -9.81)).sweep(POSITIONS)
    _, row, *_ = table_rows(turn._repr_html_())
    assert row[1].endswith(f"(shear up to {turn[row[0]].shear.max():.4g} N unique)")
    # Where all loads lie in the plane, what is open of it is nothing.
    _, row, *_ = table_rows(scene.sweep(POSITIONS)._repr_html_())
    assert row[1] == f"{turn[row[0]].shear.max():.4g}" and row[-1].startswith("not force z")


def test_texts_of_a_description_are_escaped() -> None:
    text = gears(coupling("mesh", "a", "b", 2.0))
    text = text.replace('"gears"', '"&lt;b&gt;gears &amp;amp; co"').replace(
        'name="b"', 'name="&lt;i&gt;"'
    )
    mechanism = cd.load(text)
    assert mechanism.name == "<b>gears &amp; co"
    markup = cd.Scene(mechanism, drive="a").sweep(POSITIONS)._repr_html_()
    Balanced(markup)
    assert "<b>" not in markup
    assert "<i>" not in markup
    assert "Sweep of &lt;b&gt;gears &amp;amp; co: 25 samples" in markup
    assert [row[0] for row in table_rows(markup)[1:3]] == ["a", "<i>"]


def test_grids_show_their_shape_and_large_ones_no_wrenches(
    joint: cd.Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    response = universal(joint, 0.5, outputs=["bearing_out"]).response()
    grid = response.sweep(POSITIONS, speed=np.array([[0.0], [1.0]]))
    markup = grid._repr_html_()
    assert "2 × 25 samples" in markup
    assert "bearing_out" in markup

    def refuse(*_: object) -> JointWrench:
        raise AssertionError("a wrench was evaluated")

    monkeypatch.setattr(Sweep, "wrench", refuse)
    large = response.sweep(POSITIONS, speed=np.zeros((4001, 1)))._repr_html_()
    Balanced(large)
    assert "Wrenches are not evaluated for a table of so many samples." in large
    assert "bearing_out" not in large
    assert table_rows(large)[0] == ["residual", "value"]


def test_sweeps_of_efforts_alone_show_their_residuals(joint: cd.Mechanism) -> None:
    markup = universal(joint, 0.5, outputs=[]).sweep(POSITIONS)._repr_html_()
    rows = table_rows(markup)
    assert len(rows) == 6
    assert ["balance", "not computed"] in rows
