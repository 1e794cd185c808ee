"""What `cardan-dyn driveline` does with its options: a report on a line from a file and numbers."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import click
import numpy as np

from ..drive_lines import DriveLine
from ..errors import ArgumentError
from ..report.drive_line_page import (
    LineReport,
    best_forks,
    joint_rows,
    phasing_rows,
    phasing_text,
    save_figures,
    scene,
    shaft_rows,
    write,
)
from . import quantities
from .showing import export
from .tables import say, show

_MARKS = {"pass": "green", "fail": "bold red", "stated": "default", "not judged": "yellow"}


def run(
    report: LineReport,
    *,
    page: Path | None,
    with_scene: bool,
    directory: Path | None,
    file: Path | None,
    as_text: bool,
) -> None:
    """Print a report and write what is wanted.

    Args:
        report: what is told.
        page: path of the HTML page.
        with_scene: whether the page has the turning scene in it.
        directory: of the figures.
        file: path of the turning scene.
        as_text: print tables; JSON otherwise.

    Raises:
        MissingExtraError: an extra is not installed.
        ArgumentError: a file cannot be written.
    """
    if as_text:
        print_report(report)
    else:
        click.echo(as_json(report))
    if directory is not None:
        save_figures(report, directory)
        click.echo(f"Figures: {directory}", err=not as_text)
    if page is not None:
        write(report, page, with_scene=with_scene)
        click.echo(f"Page: {page}", err=not as_text)
    if file is not None:
        export(scene(report), file, aside=not as_text)


def report_on(
    source: str,
    *,
    speed: float | None,
    torque: float | None,
    limits: tuple[str, ...],
    optimise: bool,
    teeth: int | None,
) -> LineReport:
    """Return the report on a line.

    Args:
        source: path of a TOML file, or name of a line that comes with the package.
        speed: of the input shaft [rad/s]; that of the line, or of its duty cycle at its greatest
            torque, unless given.
        torque: of the input shaft [N·m]; likewise.
        limits: as NAME=VALUE, see `quantities.limits` and `DriveLine.verdict`.
        optimise: take the best forks.
        teeth: on which forks can be turned; they are free unless given.

    Raises:
        ArgumentError: there is no speed or torque.
        CardanError: as `DriveLine.from_toml`, `phasing`, `analyse` and `verdict` do.
    """
    given = quantities.limits(limits)
    line = DriveLine.from_toml(source)
    changes = {"speed": speed, "torque": torque}
    line = line.replace(**{name: value for name, value in changes.items() if value is not None})
    phasing = best_forks(line, teeth)
    if optimise and phasing is not None:
        line = phasing.line
    hardest = max(line.duty_cycle, key=lambda point: abs(point.torque), default=None)
    speed = line.speed if hardest is None or line.speed is not None else hardest.speed
    torque = line.torque if hardest is None or line.torque is not None else hardest.torque
    for name, value in (("--speed", speed), ("--torque", torque)):
        if value is None:
            raise ArgumentError(f"the line says no {name[2:]}: give {name}")
    analysis = line.analyse(speed=speed, torque=torque)
    return LineReport(line, analysis, line.verdict(given), phasing)


def print_report(report: LineReport) -> None:
    """Print joints, shafts, forks and the verdict."""
    line = report.line
    shaft_headings = ("shaft", "length", "side", "plan", "fork\noffset", "tube", "bearings\nat")
    show(shaft_headings, shaft_rows(line), title=f"{line.name}: shafts", texts=(0, 5, 6))
    joint_headings = ("joint", "size", "side", "plan", "angle β", "plane\noffset", "fork\nphase")
    show(joint_headings, joint_rows(line), title="joints")
    say(phasing_text(report.phasing))
    if report.phasing is not None and report.phasing.value < report.phasing.given_value:
        show(("shaft", "given", "best"), phasing_rows(report.phasing), title="forks")
    _print_verdict(report)
    say(f"Verdict: {report.verdict.summary}")
    for text in report.verdict.remarks:
        say(text, "yellow")
    for row in report.verdict.failed:
        place = row.where or "line"
        say(
            f"FAIL {place}: {row.quantity} {row.texts[3]}, limit {row.texts[5]} ({row.source})",
            "red",
        )


def _print_verdict(report: LineReport) -> None:
    from rich.text import Text

    rows: list[tuple[str | Text, ...] | str] = []
    title = ""
    for row in report.verdict:
        if row.status == "not judged" and row.value is None:
            continue
        if row.texts[0] != title:
            title = row.texts[0]
            rows.append(title)
        _, where, quantity, *numbers, status = row.texts[:8]
        place = f"{quantity}, {where}" if where else quantity
        rows.append((place, *numbers, Text(status, _MARKS[row.status])))
    headings = ("quantity, where", "value", "by the\nrule", "limit", "margin", "verdict")
    show(headings, rows, title="verdict")


def as_json(report: LineReport) -> str:
    """Return the verdict and the forks as JSON text, in SI units and radians."""
    rows = [
        {**dataclasses.asdict(row), "margin": row.margin, "inverses": row.inverses}
        for row in report.verdict
    ]
    phasing = report.phasing
    forks = None
    if phasing is not None:
        forks = {
            "fork_offsets": phasing.fork_offsets.tolist(),
            "residual_angle": phasing.value,
            "given_residual_angle": phasing.given_value,
            "proven": phasing.proven,
        }
    content = {
        "line": report.line.name,
        "passed": report.verdict.passed,
        "remarks": report.verdict.remarks,
        "rows": [{key: _finite(value) for key, value in row.items()} for row in rows],
        "phasing": forks,
    }
    return json.dumps(content, ensure_ascii=False, indent=1)


def _finite(value: object) -> object:
    """Return a value that JSON has; infinite lives are texts."""
    return str(value) if isinstance(value, float) and not np.isfinite(value) else value
