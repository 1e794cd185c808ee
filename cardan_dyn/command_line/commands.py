"""Command line: `cardan-dyn`."""

from __future__ import annotations

from pathlib import Path

import click

from .._version import __version__
from ..errors import ArgumentError, CardanError


class _Commands(click.Group):
    """Shows the package's errors as messages, without a traceback."""

    def invoke(self, ctx: click.Context) -> object:
        try:
            return super().invoke(ctx)
        except CardanError as error:
            raise click.ClickException(str(error)) from error


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="cardan-dyn")
def main() -> None:
    """Joint wrenches of closed-chain mechanisms with Pinocchio."""


@main.command()
@click.option(
    "--out",
    "directory",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path("report"),
    show_default=True,
    help="Directory for the figures and the HTML page.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the comparisons as JSON.")
@click.option("--figures/--no-figures", default=True, help="Write figures and page, or only print.")
def report(directory: Path, as_json: bool, figures: bool) -> None:
    """Compare the bundled descriptions with Thoma (1920) and Grossmann (1939).

    Exits with 1 when a comparison falls short of its tolerance.
    """
    from ..report import report as reporting
    from ..validation import comparisons

    found = comparisons.run()
    passed = all(comparison.passed for comparison in found)
    if as_json:
        click.echo(reporting.as_json(found))
    else:
        _print_table(reporting.rows(found))
    if figures:
        try:
            page = reporting.write(found, directory)
        except OSError as error:
            raise click.ClickException(f"{directory}: cannot be written ({error})") from error
        click.echo(f"Figures and page: {page}", err=as_json)
    if not passed:
        raise SystemExit(1)


@main.command()
@click.argument("source", metavar="NAME_OR_FILE")
@click.option("--drive", multiple=True, metavar="JOINT", help="Driven joint; may be repeated.")
@click.option(
    "--held",
    multiple=True,
    metavar="JOINT=VALUE",
    help="Joint that is held, in degrees (slides: metres); may be repeated.",
)
@click.option(
    "--load",
    "loads",
    multiple=True,
    metavar="JOINT=VALUE",
    help="Effort on a joint [N·m, slides: N]; may be repeated.",
)
@click.option("--speed-rpm", type=float, help="Speed of a drive that turns; quasi-static without.")
@click.option("--gravity", type=float, nargs=3, help="Free fall in world axes [m/s²].")
@click.option("--joint", "joints", multiple=True, metavar="JOINT", help="Draw only these joints.")
@click.option(
    "--hide",
    multiple=True,
    type=click.Choice(["visuals", "moments", "forces", "axes", "traces", "labels"]),
    help="Leave a part out; may be repeated.",
)
@click.option("--duration", type=float, default=8.0, show_default=True, help="Of one sweep [s].")
@click.option("--samples", type=click.IntRange(2), default=721, show_default=True)
@click.option("--strict/--no-strict", default=True, help="Refuse inertias that no body can have.")
@click.option(
    "--export",
    "file",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Write one HTML file that needs no network, and end.",
)
@click.option("--open/--no-open", "open_browser", default=True, help="Open a browser.")
def view(
    source: str,
    drive: tuple[str, ...],
    held: tuple[str, ...],
    loads: tuple[str, ...],
    speed_rpm: float | None,
    gravity: tuple[float, float, float] | None,
    joints: tuple[str, ...],
    hide: tuple[str, ...],
    duration: float,
    samples: int,
    strict: bool,
    file: Path | None,
    open_browser: bool,
) -> None:
    """Watch a mechanism move, with its moments and forces drawn on it.

    NAME_OR_FILE is a bundled description or a file. The page is served on this machine until
    Ctrl-C; its address is printed, so it can be opened where no browser starts by itself.
    """
    import math

    from ..mechanism.mechanism import load
    from ..viewer.commands import meshcat
    from ..viewer.viewing import view as draw
    from .presets import default_sweep

    meshcat()  # A missing extra is told before anything is computed.
    mechanism = load(source, strict=strict)
    positions = {
        name: value if mechanism.joint(name).type == "prismatic" else math.radians(value)
        for name, value in _assigned(held, "--held").items()
    }
    sweep = default_sweep(
        mechanism,
        drive=drive,
        held=positions,
        loads=_assigned(loads, "--load") if loads else None,
        gravity=gravity,
        speed=None if speed_rpm is None else speed_rpm * math.pi / 30.0,
        samples=samples,
    )
    shown = draw(
        sweep,
        joints=joints or None,
        duration=duration,
        frames=samples,
        visuals="visuals" not in hide,
        moments="moments" not in hide,
        forces="forces" not in hide,
        axes="axes" not in hide,
        traces="traces" not in hide,
        labels="labels" not in hide,
    )
    if file is not None:
        try:
            click.echo(f"Scene: {shown.export(file)}")
        except OSError as error:
            raise click.ClickException(f"{file}: cannot be written ({error})") from error
        return
    click.echo(f"Scene: {shown.url} (Ctrl-C ends it)")
    if open_browser and not shown.open():
        click.echo("No browser has opened it here: open the address, or --export a file.", err=True)
    try:
        shown.serve()
    except KeyboardInterrupt:
        shown.close()


def _assigned(pairs: tuple[str, ...], option: str) -> dict[str, float]:
    """Return names and values from `NAME=VALUE`."""
    found: dict[str, float] = {}
    for pair in pairs:
        name, separator, value = pair.rpartition("=")
        try:
            found[name] = float(value)
        except ValueError:
            separator = ""
        if not separator or not name:
            raise ArgumentError(f"{option} {pair!r} is not JOINT=VALUE, as joint_angle=30")
    return found


def _print_table(rows: list[dict[str, object]]) -> None:
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("quantity", overflow="fold")
    table.add_column("formula", overflow="fold")
    for heading in ("worst error", "tolerance", "verdict"):
        table.add_column(heading, justify="right", no_wrap=True)
    previous = None
    for row in rows:
        if row["scene"] != previous:
            if previous is not None:
                table.add_section()
            table.add_row(f"[bold]{row['scene']}[/]")
            previous = row["scene"]
        table.add_row(
            str(row["quantity"]),
            str(row["source"]),
            f"{row['worst']:.1e}",
            f"{row['tolerance']:.0e}",
            "[green]pass[/]" if row["passed"] else "[bold red]FAIL[/]",
        )
    Console().print(table)
