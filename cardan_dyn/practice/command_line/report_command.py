"""What `cardan-dyn report` does: the case that its options tell, its numbers and a page."""

from __future__ import annotations

import itertools
import re
from pathlib import Path

import click

from ...core.mechanics.exact import load
from ...scene.usual_motion import default_scene
from ..report.case import case_of
from ..report.grids import stem_of
from ..report.reporting import Report, Reports
from .group import end_by
from .options import Words, Written
from .quantities import assigned, efforts, ends_of, nearest, value_of
from .quantities import positions as positions_of


def run(
    source: str,
    file: Path | None,
    *,
    with_scene: bool,
    drive: Words,
    ends: tuple[str, str] | None,
    speed: str | None,
    near: Words,
    held: Words,
    loads: Words,
    gravity: tuple[float, float, float] | str | None,
    elements: bool,
    samples: int,
    strict: bool,
    **head: str | None,
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
    fixed, begun = positions_of(mechanism, held), nearest(mechanism, near)
    interval: tuple[float, float] | None = None
    rates: list[float | None] = [None]
    if ends is not None or speed is not None:
        driven = (drive or default_scene(mechanism, held=fixed, near=begun).drives)[0]
        interval = None if ends is None else ends_of(mechanism, driven, ends)
        if speed is not None:
            every = _several(speed, "--speed")
            rates = [value_of(mechanism, driven, "speed", one, "--speed") for one in every]
    given = assigned(loads, "--load")
    listed = {name: _several(text, f"--load {name}") for name, text in given.items()}
    reports = []
    for rate, values in itertools.product(rates, itertools.product(*listed.values())):
        pairs = zip(listed, values, strict=True)
        ways: dict[str, tuple[float, int]] = {}
        acting = efforts(mechanism, [f"{name}={value}" for name, value in pairs], ways)
        case = case_of(
            mechanism,
            drive=drive,
            near=begun,
            held=fixed,
            loads=acting if listed else None,
            ways=ways,
            gravity=gravity,
            speed=rate,
            interval=interval,
            elements=elements,
            samples=samples,
        )
        reports.append(Report(case, **{name: text or "" for name, text in head.items()}))
    found: Report | Reports = reports[0] if len(reports) == 1 else Reports(reports)
    click.echo(found)
    click.echo(f"Report: {found.save(file, scene=with_scene)}")
    end_by(any(report.exceeded for report in reports))


def _several(text: str, option: str) -> list[str]:
    """Return values with commas between them, and say how one is read that may be a decimal."""
    values = text.split(",")
    pair = re.fullmatch(r"\s*[-+]?(\d+),(\d+)\D*", text)
    if pair and (len(pair[1]) == 1 or len(pair[2]) < len(pair[1])):
        click.echo(
            f"{option} {text} is read as two load cases, {' and '.join(values)}; one number with "
            f"decimals has a point: {'.'.join(values)}",
            err=True,
        )
    return values
