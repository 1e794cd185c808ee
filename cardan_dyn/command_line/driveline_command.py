"""What `cardan-dyn driveline` does with its options: a report on a line from a file and numbers."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import TYPE_CHECKING

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

if TYPE_CHECKING:
    from rich.console import Console

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
    from rich.console import Console

    if as_text:
        print_report(report, Console())
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
    for name, value in (("--speed-rpm", speed), ("--torque-nm", torque)):
        if value is None:
            raise ArgumentError(f"the line says no {name[2:].split('-')[0]}: give {name}")
    analysis = line.analyse(speed=speed, torque=torque)
    return LineReport(line, analysis, line.verdict(given), phasing)


def print_report(report: LineReport, console: Console) -> None:
    """Print joints, shafts, forks and the verdict."""
    from rich import box
    from rich.table import Table

    def table(title: str, headings: tuple[str, ...], rows: list[tuple[str, ...]]) -> None:
        shown = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
        for index, heading in enumerate(headings):
            shown.add_column(heading, justify="right" if index else "left", overflow="fold")
        for row in rows:
            shown.add_row(*row)
        console.print(shown)

    line = report.line
    shaft_headings = ("shaft", "length", "side", "plan", "fork offset", "tube", "bearings at")
    table(f"{line.name}: shafts", shaft_headings, shaft_rows(line))
    joint_headings = ("joint", "size", "side", "plan", "angle β", "plane offset", "fork phase")
    table("joints", joint_headings, joint_rows(line))
    console.print(phasing_text(report.phasing), highlight=False)
    if report.phasing is not None and report.phasing.value < report.phasing.given_value:
        table("forks", ("shaft", "given", "best"), phasing_rows(report.phasing))
    console.print(_verdict_table(report))
    console.print(f"Verdict: {report.verdict.summary}", highlight=False)
    for text in report.verdict.remarks:
        console.print(text, style="yellow", markup=False, highlight=False)
    for row in report.verdict.failed:
        place = row.where or "line"
        console.print(
            f"FAIL {place}: {row.quantity} {row.texts[3]}, limit {row.texts[5]} ({row.source})",
            style="red",
            markup=False,
            highlight=False,
        )


def _verdict_table(report: LineReport) -> object:
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    shown = Table(title="verdict", title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("where", "quantity"):
        shown.add_column(heading, overflow="fold")
    for heading in ("value", "by the rule", "limit", "margin"):
        shown.add_column(heading, justify="right", overflow="fold")
    shown.add_column("verdict")
    title = ""
    for row in report.verdict:
        if row.status == "not judged" and row.value is None:
            continue
        if row.texts[0] != title:
            title = row.texts[0]
            shown.add_row(f"[bold]{escape(title)}[/]")
        _, where, quantity, value, by_rule, limit, margin, status, *_ = map(escape, row.texts)
        mark = f"[{_MARKS[row.status]}]{status}[/]"
        shown.add_row(where, quantity, value, by_rule, limit, margin, mark)
    return shown


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
