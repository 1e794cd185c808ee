"""What `cardan-dyn report` does: the case that its options tell, its numbers and a page."""

from __future__ import annotations

from pathlib import Path

import click

from .. import units
from ..mechanism.mechanism import Mechanism, load
from ..report.case import case_of
from ..report.grids import stem_of
from ..report.reporting import Report
from ..scene.usual_motion import default_scene, slides
from .options import Written
from .quantities import efforts
from .quantities import positions as positions_of


def run(
    source: str,
    file: Path | None,
    *,
    with_scene: bool,
    drive: tuple[str, ...],
    ends: tuple[str, str] | None,
    speed: str | None,
    held: tuple[str, ...],
    loads: tuple[str, ...],
    gravity: tuple[float, float, float] | None,
    elements: bool,
    samples: int,
    title: str,
    project: str,
    author: str,
    date: str,
    revision: str,
    strict: bool,
) -> None:
    """Report on a mechanism; see `report_options`.

    Raises:
        CardanError: as `load` and `Scene` do, or an option has another form.
        MissingExtraError: Matplotlib, Jinja or meshcat is not installed.
    """
    mechanism = load(source, strict=strict)
    if file is None:
        file = Written().convert(f"{stem_of(mechanism.name)}_report.html", None, None)
    if file.suffix == ".html":
        from ..figures.style import require_matplotlib

        require_matplotlib()
    fixed = positions_of(mechanism, held)
    acting = efforts(mechanism, loads) if loads else None
    slide = False
    if ends is not None or speed is not None:
        slide = _slides(mechanism, drive, fixed)
    kind, rate = ("length", "velocity") if slide else ("angle", "speed")
    bare, bare_rate = ("m", "m/s") if slide else ("deg", "rpm")
    interval = None
    if ends is not None:
        low, high = (units.read(text, kind, "--range", bare) for text in ends)
        interval = low, high
    case = case_of(
        mechanism,
        drive=drive,
        held=fixed,
        loads=acting,
        gravity=gravity,
        speed=None if speed is None else units.read(speed, rate, "--speed", bare_rate),
        interval=interval,
        elements=elements,
        samples=samples,
    )
    found = Report.of_case(
        mechanism,
        case,
        title=title,
        project=project,
        author=author,
        date=date,
        revision=revision,
    )
    click.echo(found)
    click.echo(f"Report: {found.save(file, scene=with_scene)}")


def _slides(mechanism: Mechanism, drive: tuple[str, ...], held: dict[str, float]) -> bool:
    """Return whether the drive slides, in which units of its numbers are."""
    drives = drive or default_scene(mechanism, held=held).drives
    return slides(mechanism, drives[0])
