"""What `cardan-dyn driveline` does with its options: a report on a line from a file and numbers."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import click
import numpy as np

from ...drive_lines import DriveLine, TitleBlock, VerdictRow
from ...kit.errors import ArgumentError
from ..drive_lines.verdict.rows import STATED
from ..drive_lines.wording import Wording
from ..report.drive_line_page import LineReport, save_figures, scene, write
from ..report.line_tables import (
    Listing,
    best_forks,
    joint_listing,
    phasing_listing,
    phasing_text,
    shaft_listing,
)
from . import quantities
from .showing import export
from .tables import say, show

_MARKS = {"pass": "green", "fail": "bold red", "open": "yellow", "stated": "default"}


def run(
    report: LineReport,
    *,
    page: Path | None,
    with_scene: bool,
    directory: Path | None,
    file: Path | None,
    as_text: bool,
    language: str = "en",
    units: str = "si",
) -> None:
    """Print a report and write what is wanted.

    Args:
        report: what is told.
        page: path of the HTML page.
        with_scene: whether the page has the turning scene in it.
        directory: of the figures.
        file: path of the turning scene.
        as_text: print tables; JSON otherwise.
        language: of the page, see `Wording`.
        units: of the page, likewise.

    Raises:
        MissingExtraError: an extra is not installed.
        ArgumentError: a file cannot be written.
    """
    wording = Wording(language, units)
    if as_text:
        print_report(report, Wording(units=units))
    else:
        click.echo(as_json(report))
    if directory is not None:
        save_figures(report, directory, wording)
        click.echo(f"Figures: {directory}", err=not as_text)
    if page is not None:
        write(report, page, with_scene=with_scene, language=language, units=units)
        click.echo(f"Page: {page}", err=not as_text)
    if file is not None:
        export(scene(report, wording), file, aside=not as_text)


def report_on(
    source: str,
    *,
    speed: float | None,
    torque: float | None,
    limits: tuple[str, ...],
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
    if (built := report.built(wording)) is not None:
        _show(built)
    units = wording.units
    _print_verdict(report, units)
    say(f"Verdict: {report.verdict.summary}")
    headlines: dict[str, list[str]] = {}
    for row in report.verdict.failed:
        place, at = row.where or "line", f" at {row.condition}" if row.condition else ""
        texts = row.texts(units)
        limit = f", limit {texts[5]}" if row.limit else ""
        told = f"{_told(row, units)} {texts[3]}{at}{limit} ({row.source})"
        headlines.setdefault(told, []).append(place)
    for told, places in headlines.items():
        say(f"FAIL {', '.join(places)}: {told}", "red")
    unjudged = [row for row in report.verdict if row.status == STATED and "give " in row.note]
    for word, rows, style in (
        ("OPEN", report.verdict.open, "yellow"),
        ("not judged", unjudged, ""),
    ):
        # Places of which the same is asked share a line.
        alike: dict[tuple[str, str], list[str]] = {}
        for row in rows:
            told = "; ".join(dataclasses.replace(row, broken=()).remarks(units))
            alike.setdefault((row.quantity, told), []).append(row.where or "line")
        for (quantity, told), places in alike.items():
            say(f"{word} {', '.join(dict.fromkeys(places))}: {quantity}: {told}", style)


def _show(listing: Listing, lead: str = "") -> None:
    texts = tuple(range(listing.left))
    headings = [heading.replace(" [", "\n[") for heading in listing.header]
    show(headings, listing.rows, title=lead + listing.caption, texts=texts)


def _print_verdict(report: LineReport, units: str) -> None:
    from rich.text import Text

    rows: list[tuple[str | Text, ...] | str] = []
    title = ""
    for row in report.verdict:
        heading, where, _, value, by_rule, limit, margin, status = row.texts(units)[:8]
        if heading != title:
            title = heading
            rows.append(title)
        place = ", ".join(filter(None, [_told(row, units), where, row.condition]))
        rows.append((place, value, by_rule, limit, margin, Text(status, _MARKS[row.status])))
    headings = ("quantity, where, at", "value", "by the\nrule", "limit", "margin", "verdict")
    show(headings, rows, title="verdict")


def _told(row: VerdictRow, units: str) -> str:
    """Return the quantity of a row, with what it takes to know what is meant."""
    # Distances and shares of critical speeds say nothing without the speed.
    listed = [item.told(units) for item in row.inverses if row.rule.endswith("_speed")]
    if row.rule == "torsional_speed":
        listed += filter(None, [row.note])
    if row.value is None and row.status == STATED:
        listed = [row.note]
    return f"{row.quantity} ({'; '.join(listed)})" if listed else row.quantity


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
        "outcome": report.verdict.summary,
        "rows": [{key: _finite(value) for key, value in row.items()} for row in rows],
        "phasing": forks,
    }
    return json.dumps(content, ensure_ascii=False, indent=1)


def _finite(value: object) -> object:
    """Return a value that JSON has; infinite lives are texts."""
    return str(value) if isinstance(value, float) and not np.isfinite(value) else value
