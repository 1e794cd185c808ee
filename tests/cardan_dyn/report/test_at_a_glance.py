"""At a glance: what is read first of twenty mechanisms, against the arrays of their sweeps."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from testkit import linkages, planar_linkages

import cardan_dyn as cd
from cardan_dyn.practice.command_line.commands import main

pytestmark = pytest.mark.usefixtures("loaded_once")

OWN = {
    "long rocker": linkages.four_bar(linkages.loop("continuous")),
    "guided": linkages.slider_crank("prismatic"),
    "tilted": linkages.tilted_slider_crank(0.3, True),
    "in space": linkages.tilted_slider_crank(0.3, False),
    "geared": linkages.gears(linkages.coupling("mesh", "a", "b", -2.0)),
    "double rocker": planar_linkages.four_bar().to_urdf(),
    "three cranks": planar_linkages.three_cranks().to_urdf(),
}
BUNDLED = (
    *("four_bar", "slider_crank", "needle_drive", "universal_joint", "double_shaft_z"),
    *("double_shaft_w", "double_shaft_spatial", "ring_joint", "thoma_rig", "elastic_thoma_rig"),
    *("torsional_line_front", "torsional_line_both", "drive_line"),
)
QUICK = {"four_bar", "universal_joint", "tilted", "geared", "slider_crank"}
EVERY = [
    pytest.param(name, marks=() if name in QUICK else pytest.mark.slow) for name in (*BUNDLED, *OWN)
]
PARTS = {"axial": (0, "along"), "shear": (0, "across"), "torsion": (3, "along")}
PARTS["bending"] = 3, "across"
WHOLES = {"force": ("force", "axial", "shear"), "moment": ("moment", "torsion", "bending")}
NUMBER = re.compile(r"(?<![\w.:-])-?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w.])")
ROUNDING = 1e-9


def sizes(sweep: cd.Sweep) -> dict[tuple[str, str], tuple[float, bool]]:
    """Return the greatest size of each part of each wrench at the samples, and if it is unique.

    By components in the axes of the joints alone, of joints along one of these.
    """
    found = {}
    for name, wrench in sweep.items():
        values = np.concatenate([wrench.force, wrench.moment], axis=1)
        for quantity, start in (("force", 0), ("moment", 3)):
            part = slice(start, start + 3)
            size = float(np.linalg.norm(values[:, part], axis=1).max())
            found[name, quantity] = size, follows(values[:, part], wrench.unique[part])
        if not wrench.has_axis:
            continue
        axis = np.reshape(wrench.axis, (-1, 3))[0]
        for quantity, (start, which) in PARTS.items():
            part = slice(start, start + 3)
            along = values[:, part] @ axis
            size = np.abs(along)
            if which == "across":
                size = np.linalg.norm(values[:, part] - np.outer(along, axis), axis=1)
            on = np.abs(axis) > ROUNDING if which == "along" else np.abs(axis) < 1.0 - ROUNDING
            own = values[:, part][:, on], wrench.unique[part][on]
            found[name, quantity] = float(size.max()), follows(*own)
    return found


def follows(values: np.ndarray, unique: np.ndarray) -> bool:
    """Return whether what statics leaves open carries nothing, beside what it determines."""
    known, opened = (np.abs(values[:, of]).max(initial=0.0) for of in (unique, ~unique))
    return bool(np.all(unique)) or bool(opened < ROUNDING * known)


def significant(text: str) -> int:
    """Return how many digits a number has that is written."""
    digits = re.sub(r"e.*|[-.]", "", text).lstrip("0")
    return len(digits)


@pytest.mark.parametrize("name", EVERY)
def test_what_is_read_first(name: str, tmp_path: Path) -> None:
    """The headline is the greatest that statics determines, and stars are where it does not."""
    file = name
    if name in OWN:
        file = str(tmp_path / "own.urdf")
        Path(file).write_text(OWN[name], encoding="utf-8")
    mechanism = cd.load(file)
    scene = cd.Report(mechanism).sweep
    assert scene is not None
    acting = {name: 3.0 for name in scene.mechanism.drivable if name not in scene.coordinates}
    acting = {name: acting[name] for name in list(acting)[:1] if name not in scene.held}
    problem = cd.Scene(
        mechanism,
        drive=list(scene.coordinates),
        held={name: float(np.ravel(at)[0]) for name, at in scene.held.items()},
        loads=acting or None,
        gravity=(0.0, -9.81, 0.0),
    )
    report = cd.Report(problem.sweep(scene.position))
    sweep = report.sweep
    assert sweep is not None
    arrays = sizes(sweep)
    most = max(size for size, _ in arrays.values())
    for item in report.headline:
        if item.quantity in PARTS:
            rivals = [
                size
                for (_, quantity), (size, is_unique) in arrays.items()
                if quantity == item.quantity and is_unique
            ]
            assert arrays.get((item.owner, item.quantity), (0.0, item.determined))[1]
            # Between samples it may be a little greater, and rounding beside the rest is nothing.
            assert item.size >= max(rivals, default=0.0) * (1.0 - 1e-6) - ROUNDING * most
        elif item.quantity in WHOLES:
            rivals = [
                size
                for (_, quantity), (size, is_unique) in arrays.items()
                if quantity in WHOLES[item.quantity] and is_unique
            ]
            assert item.size >= max(rivals) * (1.0 - 1e-6) - ROUNDING * most
    told = {item.quantity for item in report.headline}
    for (owner, quantity), (size, is_unique) in arrays.items():
        if is_unique and size > 5e-4 * most and quantity in ("shear", "bending"):
            assert quantity in told, (owner, quantity)
    text = str(report)
    rows = (line.split() for line in text.splitlines())
    stars = {(row[0], row[1]) for row in rows if row[2:3] == ["*"]}
    for key in stars:
        assert not arrays[key][1], key
    for item in report.told:
        if (item.owner, item.quantity) in arrays and item.quantity in PARTS:
            assert ((item.owner, item.quantity) in stars) == (not item.determined)
    assert text.count("not determined by statics") <= 1
    rows = [(item.owner, item.greatest, item.least, item.unit) for item in report.headline]
    assert len(set(rows)) == len(rows)
    outputs = [text]
    for command in ("describe", "check", "sweep"):
        found = CliRunner(env={"COLUMNS": "200"}).invoke(main, [command, file])
        assert found.exit_code == 0, found.output
        outputs.append(found.output.replace(file, ""))
    facts, _, _ = outputs[1].partition("\njoint ")
    assert len(facts.splitlines()) <= 10
    for output in outputs:
        for number in NUMBER.findall(output):
            assert significant(number) <= 4, (number, output)
