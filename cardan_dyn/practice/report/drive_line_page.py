"""Drive-line page: one HTML file about a line, with data, figures and verdict, to be handed on."""

from __future__ import annotations

import datetime
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ... import figures
from ...drive_lines import Analysis, DriveLine, Phasing, TitleBlock, Verdict
from ...figures.style import Figure, require_matplotlib
from ..drive_lines.drawing import arrangement
from ..drive_lines.line.supports import supports
from ..drive_lines.wording import Wording
from ..viewer.viewing import View, view
from . import line_figures as drawn
from . import line_tables as tables
from . import page
from .grids import stem_of


@dataclass(frozen=True)
class LineReport:
    """What the command and the page tell of a line.

    Attributes:
        line: with the speed and the torque of the analysis.
        analysis: at these.
        verdict: of the line at all its operating points.
        phasing: the best forks; None if the line has none to be put.
    """

    line: DriveLine
    analysis: Analysis
    verdict: Verdict
    phasing: Phasing[DriveLine] | None

    @property
    def torque(self) -> float:
        """Torque of the input shaft in the analysis, the greatest of a turn [N·m]."""
        driving = self.analysis.static.torsion_in[:, 0]
        return float(driving[np.abs(driving).argmax()])

    def drawn(self, wording: Wording) -> list[tuple[str, str, Figure]]:
        """Return names, captions and figures.

        Args:
            wording: language and units.

        Raises:
            MissingExtraError: matplotlib is not installed.
        """
        analysis = self.analysis
        alone = " " + wording("Splines do not slide; without service factor and weight.")
        at = {
            "speed": wording.quantity(analysis.speed, "speed"),
            "torque": wording.quantity(self.torque, "torque"),
        }
        found = [
            (
                "arrangement",
                wording(
                    "Arrangement at rest, seen from its right side and from above, to one scale, "
                    "with the forks as they stand while the pin of the input fork is horizontal."
                ),
                arrangement(self.line, wording=wording),
            ),
            (
                "motion",
                wording("Angle errors and speed ratios over a turn at {speed}.", speed=at["speed"]),
                drawn.motion(analysis, wording),
            ),
            (
                "forces",
                wording(
                    "Bending moments of the shafts before and behind each joint, and forces of the "
                    "bearings across their shafts, over a turn at {speed} and {torque}.",
                    **at,
                )
                + alone,
                drawn.forces(analysis, wording),
            ),
        ]
        if drawn.has_orders(analysis):
            caption = wording(
                "Amplitudes of the orders of angle errors and bearing forces at {speed} and "
                "{torque}: of a force the greatest length of its vector at that order, of order 0 "
                "its mean.",
                **at,
            )
            found.append(("orders", caption + alone, drawn.orders(analysis, wording)))
        return found


def scene(report: LineReport, wording: Wording) -> View:
    """Return the turning scene of a line.

    Args:
        report: on the line.
        wording: of its title and its quantities.

    Raises:
        MissingExtraError: meshcat is not installed.
    """
    line, analysis = report.line, report.analysis
    held = {f"joint_angle_{k}": 0.0 for k in range(1, line.count + 1)}
    torque = float(np.mean(analysis.static.torsion_out[:, -1]))
    built = line.scene(held=held, loads={"bearing_out": -torque})
    sweep = built.sweep(np.linspace(0.0, 2.0 * np.pi, page.FRAMES))
    bearings = {"bearing_in", "bearing_out", *(item.joint for item in supports(line).bearings)}
    shown = [name for name in sweep.outputs if name in bearings]
    title = f"{line.name}, {wording.quantity(torque, 'torque')}"
    return view(sweep, joints=shown, frames=page.FRAMES, title=title, units=wording.instead)


def write(
    report: LineReport,
    path: Path,
    *,
    with_scene: bool = True,
    language: str = "en",
    units: str = "si",
) -> Path:
    """Write the page.

    Args:
        report: what it tells.
        path: of the HTML file; its directory is made if it does not exist.
        with_scene: whether it has the turning scene in it, some megabytes.
        language: `en` or `de`.
        units: `si` or `imperial`.

    Raises:
        MissingExtraError: matplotlib, meshcat or Jinja is not installed.
        ArgumentError: no such language or units, or it cannot be written.
    """
    wording = Wording(language, units)
    require_matplotlib()
    line, analysis, verdict = report.line, report.analysis, report.verdict
    return page.write(
        path,
        "drive_line.html",
        title=wording("Drive line {name}", name=line.name),
        title_block=title_rows(line.report or TitleBlock(), wording),
        language=language,
        _=wording,
        line=line,
        verdict=verdict,
        outcome=outcome(verdict, wording),
        statement=", ".join(
            f"{count} {wording(status)}" for status, count in verdict.counts.items()
        ),
        failed=tables.headlines(verdict, wording),
        indeterminate=[wording.sentence(text) for text in analysis.indeterminate],
        groups=tables.verdict_groups(verdict, wording),
        assumptions=tables.assumption_rows(verdict, wording),
        pairs_of_line=tables.line_pairs(line, wording),
        data=tables.data_listings(line, wording),
        geometry=[
            found
            for listing in (
                tables.shaft_listing,
                tables.joint_listing,
                tables.place_listing,
                tables.end_listing,
            )
            if (found := listing(line, wording)) is not None
        ],
        found=[
            tables.motion_listing(analysis, wording),
            tables.moment_listing(analysis, wording),
            tables.extreme_listing(analysis, verdict, wording),
        ],
        phasing=None if report.phasing is None else tables.phasing_listing(report.phasing, wording),
        built=tables.built_listing(report.phasing, report.torque, wording),
        headline=tables.phasing_text(report.phasing, wording),
        speed=wording.quantity(analysis.speed, "speed"),
        torque=wording.quantity(report.torque, "torque"),
        figures=[(caption, page.image(figure)) for _, caption, figure in report.drawn(wording)],
        scene=scene(report, wording).embedded(title=wording("Turning scene")) if with_scene else "",
        residuals=[
            residual(analysis.loop_residual) + " m",
            residual(analysis.balance_residual),
            residual(analysis.power_residual),
        ],
        toml=line.to_toml(),
    )


def title_rows(block: TitleBlock, wording: Wording) -> list[tuple[str, str]]:
    """Return names and values of a title block; its day is today's unless given."""
    day = datetime.date.fromisoformat(block.date) if block.date else page.today()
    return [
        (wording("Project"), block.project),
        (wording("Customer"), block.customer),
        (wording("Author"), block.author),
        (wording("Date"), wording.day(day)),
        (wording("Revision"), block.revision),
    ]


def outcome(verdict: Verdict, wording: Wording) -> str:
    """Return in words whether a line passes, and how many rows are open."""
    told, count = wording("failed" if verdict.failed else "passed"), len(verdict.open)
    if not count:
        return told
    rows = "{count} row open" if count == 1 else "{count} rows open"
    return f"{told}, {wording(rows, count=str(count))}"


def save_figures(report: LineReport, directory: Path, wording: Wording) -> list[Path]:
    """Write all figures of a line as SVG and PNG into a directory, and return their paths.

    Args:
        report: on the line.
        directory: that they are written to.
        wording: language and units.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ArgumentError: they cannot be written.
    """
    paths: list[Path] = []
    for name, _, figure in report.drawn(wording):
        paths += figures.save(figure, directory / stem_of(f"{report.line.name}_{name}"))
    return paths


def residual(value: float) -> str:
    """Return a residual; a dash where nothing acts."""
    return "–" if np.isnan(value) else f"{value:.0e}"
