"""Names in figures: written letter by letter, whatever Matplotlib would make of them."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.text import Text

import cardan_dyn as cd

NAMES = (r"$\frac{a$", "_a$b$c", "%s {x} \\n")


def renamed(name: str) -> cd.Mechanism:
    """The four-bar, with names that all contain a given one."""
    text = cd.load("four_bar").to_urdf()
    for joint in cd.load("four_bar").joint_names:
        text = text.replace(f'"{joint}"', f'"{name} {joint}"')
    return cd.load(text)


def written(figure: object) -> str:
    """All text of a figure as it is drawn; what Matplotlib cannot parse raises."""
    figure.canvas.draw()
    texts = [item for item in figure.findobj(Text) if item.get_visible()]
    drawn = []
    for item in texts:
        words, is_math = item._preprocess_math(item.get_text())
        drawn.append("formula" if is_math is True else words)
    return "\n".join(drawn).replace("\u200b", "")


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_names_are_no_formulas(name: str) -> None:
    mechanism = renamed(name)
    drive, pin = f"{name} crank_bearing", f"{name} rocker_pin"
    scene = cd.Scene(mechanism, drive=drive, gravity=(0.0, -9.81, 0.0))
    turn = scene.sweep(np.linspace(0.0, 2.0 * np.pi, 73), speed=1.0)
    response = scene.response()
    scanned = cd.clearance.scan(response, speed=300.0, clearance=1e-4, stiffness=1e8)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        figures = {
            "wrenches": turn.plot(pin, drive),
            "columns": turn.plot(f"{drive}.torsion", f"{pin}.force_x", x=f"{name} crank_pin"),
            "polar": turn.plot.polar([pin], of="force"),
            "orders": turn.plot.orders(f"{pin}.force_x", f"{pin}.force_y"),
            "response": response.plot(),
            "ranking": scanned.plot(),
            "reversals": scanned.plot.reversals(),
        }
        drawn = {kind: written(figure) for kind, figure in figures.items()}
    told = name.replace("\n", " ")
    for kind, texts in drawn.items():
        assert told in texts.replace("\n", " "), (kind, texts)


def test_a_drive_line_may_have_any_name() -> None:
    line = replace(cd.drive_lines.DriveLine.from_toml(cd.drive_lines.examples()[0]), name=NAMES[0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert NAMES[0] in written(line.plot())
