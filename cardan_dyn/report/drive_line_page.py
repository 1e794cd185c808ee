"""Drive-line page: one HTML file about a line, with data, figures and verdict, to be handed on."""

from __future__ import annotations

import base64
import io
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .. import figures
from .._version import __version__
from ..checks import writing
from ..drive_lines import Analysis, DriveLine, Phasing, Verdict, VerdictRow
from ..drive_lines.line.supports import supports
from ..errors import CardanError
from ..figures.style import LOOK, Figure, require_matplotlib
from ..viewer.viewing import View, view
from .page import template

ROUNDING = 1e-12
"""Forces, relative to the greatest, that are the rounding of none."""
FRAMES = 181
"""Positions of the turning scene."""


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
    def drawn(self) -> list[tuple[str, str, Figure]]:
        """Names, captions and figures.

        Raises:
            MissingExtraError: matplotlib is not installed.
        """
        rpm = self.analysis.speed * 30.0 / np.pi
        torque = float(self.analysis.static.torsion_in[:, 0].max())
        return [
            (
                "arrangement",
                "Arrangement in the side and in the plan view. Circles are joints, triangles "
                "bearings; the scale across is larger than along.",
                self.line.plot(),
            ),
            (
                "over_angle",
                f"Angle errors, speed ratios, bending moments and bearing forces over one turn at "
                f"{rpm:.4g} 1/min and {torque:.4g} N·m.",
                self.analysis.plot(),
            ),
        ]


def scene(report: LineReport) -> View:
    """Return the turning scene of a line.

    Raises:
        MissingExtraError: meshcat is not installed.
    """
    line, analysis = report.line, report.analysis
    held = {f"joint_angle_{k}": 0.0 for k in range(1, line.count + 1)}
    torque = float(np.mean(analysis.static.torsion_out[:, -1]))
    built = line.scene(held=held, loads={"bearing_out": -torque})
    sweep = built.sweep(np.linspace(0.0, 2.0 * np.pi, FRAMES))
    bearings = {"bearing_in", "bearing_out", *(item.joint for item in supports(line).bearings)}
    shown = [name for name in sweep.outputs if name in bearings]
    title = f"{line.name}, {torque:.4g} N·m"
    return view(sweep, joints=shown, frames=FRAMES, title=title)


def write(report: LineReport, path: Path, *, with_scene: bool = True) -> Path:
    """Write the page.

    Args:
        report: what it tells.
        path: of the HTML file; its directory is made if it does not exist.
        with_scene: whether it has the turning scene in it, some megabytes.

    Raises:
        MissingExtraError: matplotlib, meshcat or Jinja is not installed.
        ArgumentError: it cannot be written.
    """
    require_matplotlib()
    line = report.line
    text = template("drive_line.html").render(
        version=__version__,
        line=line,
        verdict=report.verdict,
        groups=verdict_groups(report.verdict),
        analysis=report.analysis,
        rpm=report.analysis.speed * 30.0 / np.pi,
        shafts=shaft_rows(line),
        joints=joint_rows(line),
        extremes=extreme_rows(report.analysis),
        phasing=phasing_rows(report.phasing),
        headline=phasing_text(report.phasing),
        figures=[(caption, _svg(figure)) for _, caption, figure in report.drawn],
        scene=scene(report).embedded() if with_scene else "",
        toml=line.to_toml(),
    )
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return path


def save_figures(report: LineReport, directory: Path) -> list[Path]:
    """Write all figures of a line as SVG and PNG into a directory, and return their paths.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ArgumentError: they cannot be written.
    """
    paths: list[Path] = []
    for name, _, figure in report.drawn:
        paths += figures.save(figure, directory / f"{report.line.name}_{name}")
    return paths


def shaft_rows(line: DriveLine) -> list[tuple[str, ...]]:
    """Return a row of texts per shaft: name, length, slopes, fork offset, tube and bearings."""
    rows: list[tuple[str, ...]] = []
    found = line.geometry
    for k, (name, shaft) in enumerate(zip(line.shaft_names, line.shafts, strict=True)):
        length, axis = float(found.lengths[k]), found.directions[k]
        size = shaft.tube
        section = "" if size is None else f"{size.outer_diameter * 1e3:g} × {size.wall * 1e3:g} mm"
        side, plan = (_degrees(np.arctan2(axis[i], axis[0])) for i in (2, 1))
        rows.append(
            (
                name,
                "" if np.isnan(length) else f"{length * 1e3:.1f} mm",
                side,
                plan,
                "" if k in (0, line.count) else f"{np.degrees(shaft.fork_offset):.2f}°",
                section,
                ", ".join(f"{item.distance * 1e3:g} mm" for item in shaft.bearings),
            )
        )
    return rows


def joint_rows(line: DriveLine) -> list[tuple[str, ...]]:
    """Return a row of texts per joint: name, size, bends in both views, angle, plane and phase."""
    found = line.geometry
    return [
        (
            name,
            joint.size,
            _degrees(found.views[k, 1]),
            _degrees(found.views[k, 0]),
            _degrees(found.joint_angles[k]),
            _degrees(found.plane_offsets[k]),
            _degrees((found.fork_phases[k] + np.pi / 2) % np.pi - np.pi / 2),
        )
        for k, (name, joint) in enumerate(zip(line.joint_names, line.joints, strict=True))
    ]


def extreme_rows(analysis: Analysis) -> list[tuple[str, ...]]:
    """Return a row of texts per bearing: greatest force across, mean force across and along."""
    forces = analysis.total
    sizes = np.array(
        [
            forces.bearing_radial.max(axis=0),
            np.linalg.norm(forces.bearing_force[..., 1:].mean(axis=0), axis=-1),
            np.abs(forces.bearing_axial).max(axis=0),
        ]
    )
    sizes[sizes < ROUNDING * sizes.max()] = 0.0
    return [
        (name, *(f"{size:.4g} N" for size in column))
        for name, column in zip(analysis.bearings, sizes.T, strict=True)
    ]


class Group(NamedTuple):
    """Rows of one rule on the page.

    Attributes:
        title: of the rule.
        shared: assumptions that fail for all of its rows.
        rows: rows that have a value, each with its own remarks.
        missing: places and notes of the rows without a value.
    """

    title: str
    shared: tuple[str, ...]
    rows: list[tuple[VerdictRow, list[str]]]
    missing: list[tuple[str, str]]


def verdict_groups(verdict: Verdict) -> list[Group]:
    """Return the rows of a verdict by rule; what all rows of a rule say is said once."""
    found = []
    for title, members in groupby(verdict, key=lambda row: row.texts[0]):
        rows = list(members)
        valued = [row for row in rows if row.value is not None]
        broken = valued[0].broken if len(valued) > 1 else ()
        shared = [text for text in broken if all(text in row.broken for row in valued)]
        own = [
            (row, [text for text in row.remarks if text.removeprefix("! ") not in shared])
            for row in valued
        ]
        missing = [
            (f"{row.where} {row.quantity}".strip(), row.note.removeprefix("not judged: "))
            for row in rows
            if row.value is None
        ]
        found.append(Group(title, tuple(shared), own, missing))
    return found


def best_forks(line: DriveLine, teeth: int | None = None) -> Phasing[DriveLine] | None:
    """Return where forks stand best; None for a line that has none to be put."""
    try:
        return line.phasing(teeth=teeth)
    except CardanError:
        if line.count > 1:
            raise
        return None


def phasing_text(phasing: Phasing[DriveLine] | None) -> str:
    """Return in a sentence what other forks would give."""
    if phasing is None:
        return "The line has one joint: there are no forks that could be put to each other."
    now, best = np.degrees([phasing.given_value, phasing.value])
    if best > now - 1e-3:
        return f"The forks stand as well as they can: the residual angle is {now:.3f}°."
    proof = "the global optimum" if phasing.proven else "the best that was found"
    return (
        f"Other forks would lower the residual angle from {now:.3f}° to {best:.3f}°, {proof} "
        f"({phasing.method})."
    )


def phasing_rows(phasing: Phasing[DriveLine] | None) -> list[tuple[str, ...]]:
    """Return a row of texts per intermediate shaft: name, fork offset now and at the best."""
    if phasing is None:
        return []
    offsets = zip(phasing.given.fork_offsets, phasing.fork_offsets, strict=True)
    return [
        (name, _degrees(now), _degrees(best))
        for name, (now, best) in zip(phasing.line.shaft_names[1:-1], offsets, strict=True)
    ]


def _degrees(angle: float) -> str:
    return f"{np.degrees(angle):.3f}°".replace("-0.000", "0.000")


def _svg(figure: Figure) -> str:
    """Return a figure as SVG text in base64."""
    import matplotlib

    buffer = io.BytesIO()
    with matplotlib.rc_context(LOOK):
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    return base64.b64encode(buffer.getvalue()).decode("ascii")
