"""What `cardan-dyn driveline` does with its options: a report on a line from a file and numbers."""

from __future__ import annotations

import dataclasses
from itertools import groupby
from pathlib import Path
from typing import Any

import click

from ...drive_lines import DriveLine, TitleBlock, VerdictRow, examples, toml_schema
from ...kit.errors import ArgumentError
from ...scene.mechanism_report import grouped
from ..drive_lines.line.files import units_of
from ..drive_lines.verdict.rows import STATED
from ..drive_lines.wording import Wording
from ..report.drive_line_page import LineReport, save_figures, write
from ..report.drive_line_page import scene as turning
from ..report.line_tables import (
    Listing,
    best_forks,
    built_listing,
    joint_listing,
    phasing_listing,
    phasing_text,
    shaft_listing,
)
from . import quantities
from .group import MISSED, OPEN
from .options import Words
from .showing import export, serve
from .tables import print_json, say, show


def run(
    source: str | None,
    *,
    schema: bool,
    page: Path | None,
    scene: bool,
    directory: Path | None,
    file: Path | None,
    as_json: bool,
    language: str,
    units: str | None,
    watch: bool,
    open_browser: bool,
    check: bool,
    **given: Any,
) -> None:
    """Print a report on a line, write and show what is wanted; see `commands.driveline`.

    Raises:
        MissingExtraError: an extra is not installed.
        ArgumentError: a file cannot be written.
        CardanError: as `report_on`.
    """
    if schema:
        print_json(toml_schema())
        return
    if source is None:
        names = ", ".join(examples())
        raise click.UsageError(f"NAME_OR_FILE is missing; lines of the package: {names}")
    report = report_on(source, **given)
    wording = Wording(language, units or units_of(report.line))
    if as_json:
        # Infinite lives are texts.
        print_json(plain(report), lambda word: word.lower().removesuffix("inity"))
    else:
        print_report(report, Wording(units=wording.units))
    if directory is not None:
        save_figures(report, directory, wording)
        click.echo(f"Figures: {directory}", err=as_json)
    if page is not None:
        write(report, page, with_scene=scene, language=language, units=wording.units)
        click.echo(f"Page: {page}", err=as_json)
    if file is not None:
        export(turning(report, wording), file, aside=as_json)
    if watch:
        serve(turning(report, wording), open_browser)
    if check and not report.verdict.passed:
        raise SystemExit(MISSED if report.verdict.failed else OPEN)


def report_on(
    source: str,
    *,
    speed: float | None,
    torque: float | None,
    limits: Words,
    optimise_phases: bool,
    teeth: int | None,
    **title_block: str | None,
) -> LineReport:
    """Return the report on a line.

    Args:
        source: path of a TOML file, or name of a line that comes with the package.
        speed: of the input shaft [rad/s]; that of the line, or of its duty cycle at its greatest
            torque, unless given.
        torque: of the input shaft [N·m]; likewise.
        limits: as NAME=VALUE, see `quantities.limits` and `DriveLine.verdict`.
        optimise_phases: take the best forks.
        teeth: on which forks can be turned; they are free unless given.
        title_block: fields of `TitleBlock` that replace those of the file; None leaves them.

    Raises:
        ArgumentError: there is no speed or torque.
        CardanError: as `DriveLine.from_toml`, `phasing`, `analyse` and `verdict` do.
    """
    given = quantities.limits(limits)
    line = DriveLine.from_toml(source)
    changes = {"speed": speed, "torque": torque}
    line = line.replace(**{name: value for name, value in changes.items() if value is not None})
    said = {name: value for name, value in title_block.items() if value is not None}
    if said:
        line = line.replace(report=dataclasses.replace(line.report or TitleBlock(), **said))
    phasing = best_forks(line, teeth)
    if optimise_phases and phasing is not None:
        line = phasing.line
    hardest = max(line.duty_cycle, key=lambda point: abs(point.torque), default=None)
    speed = line.speed if hardest is None or line.speed is not None else hardest.speed
    torque = line.torque if hardest is None or line.torque is not None else hardest.torque
    for name, value in (("speed", speed), ("torque", torque)):
        if value is None:
            raise ArgumentError(f"the line says no {name}: give --{name}")
    analysis = line.analyse(speed=speed, torque=torque)
    return LineReport(line, analysis, line.verdict(given), phasing)


def print_report(report: LineReport, wording: Wording) -> None:
    """Print joints, shafts, forks and the verdict."""
    for listing in (shaft_listing(report.line, wording), joint_listing(report.line, wording)):
        _show(listing, f"{report.line.name}: ")
    say(phasing_text(report.phasing, wording))
    if report.phasing is not None and report.phasing.value < report.phasing.given_value:
        _show(phasing_listing(report.phasing, wording))
    if (built := built_listing(report.phasing, report.torque, wording)) is not None:
        _show(built)
    units, verdict = wording.units, report.verdict
    rows: list[Words | str] = []
    for heading, members in groupby(verdict, key=lambda row: row.texts()[0]):
        rows.append(heading)
        for row in members:
            _, where, _, *numbers = row.texts(units)[:8]
            place = ", ".join(filter(None, [_told(row, units), where, row.condition]))
            rows.append((place, *numbers))
    headings = ("quantity, where, at", "value", "by the\nrule", "limit", "margin", "verdict")
    show(headings, rows, title="verdict")
    say(f"Verdict: {verdict.summary}")

    def missed(row: VerdictRow) -> str:
        _, _, _, value, _, limit, *_ = row.texts(units)
        at = f" at {row.condition}" * bool(row.condition)
        return f"{_told(row, units)} {value}{at}{f', limit {limit}' * bool(limit)} ({row.source})"

    def asked(row: VerdictRow) -> str:
        return f"{row.quantity}: {'; '.join(dataclasses.replace(row, broken=()).remarks(units))}"

    unjudged = [row for row in verdict if row.status == STATED and "give " in row.note]
    for word, style, of, said in (
        ("FAIL", "red", verdict.failed, missed),
        ("OPEN", "yellow", verdict.open, asked),
        ("not judged", "", unjudged, asked),
    ):
        # Places of which the same is told share a line.
        for text, places in grouped((row.where or "line", said(row)) for row in of).items():
            say(f"{word} {', '.join(dict.fromkeys(places))}: {text}", style)


def _show(listing: Listing, lead: str = "") -> None:
    texts = tuple(range(listing.left))
    headings = [heading.replace(" [", "\n[") for heading in listing.header]
    show(headings, listing.rows, title=lead + listing.caption, texts=texts)


def _told(row: VerdictRow, units: str) -> str:
    """Return the quantity of a row, with what it takes to know what is meant."""
    # Distances and shares of critical speeds say nothing without the speed.
    listed = [item.told(units) for item in row.inverses if row.rule.endswith("_speed")]
    if row.rule == "torsional_speed":
        listed += filter(None, [row.note])
    if row.value is None and row.status == STATED:
        listed = [row.note]
    return f"{row.quantity} ({'; '.join(listed)})" if listed else row.quantity


def plain(report: LineReport) -> dict[str, Any]:
    """Return the verdict and the forks as plain data, in SI units and radians."""
    phasing = report.phasing
    forks = phasing and {
        "fork_offsets": phasing.fork_offsets.tolist(),
        "residual_angle": phasing.value,
        "given_residual_angle": phasing.given_value,
        "proven": phasing.proven,
    }
    return {
        "line": report.line.name,
        "passed": report.verdict.passed,
        "outcome": report.verdict.summary,
        "rows": [
            {**dataclasses.asdict(row), "margin": row.margin, "inverses": row.inverses}
            for row in report.verdict
        ],
        "phasing": forks,
    }
