"""What `cardan-dyn report` does: the case that its options tell, its numbers and a page."""

from __future__ import annotations

from pathlib import Path

import click

from ...core.mechanics.exact import load
from ...scene.usual_motion import default_scene
from ..report.case import case_of
from ..report.grids import stem_of
from ..report.reporting import Report
from .options import Written
from .quantities import efforts, value_of
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
    gravity: tuple[float, float, float] | str | None,
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
        from ...figures.style import require_matplotlib

        require_matplotlib()
    fixed = positions_of(mechanism, held)
    acting = efforts(mechanism, loads) if loads else None
    interval = rate = None
    if ends is not None or speed is not None:
        driven = (drive or default_scene(mechanism, held=fixed).drives)[0]
        if ends is not None:
            low, high = (value_of(mechanism, driven, "position", end, "--range") for end in ends)
            interval = low, high
        if speed is not None:
            rate = value_of(mechanism, driven, "speed", speed, "--speed")
    case = case_of(
        mechanism,
        drive=drive,
        held=fixed,
        loads=acting,
        gravity=gravity,
        speed=rate,
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
