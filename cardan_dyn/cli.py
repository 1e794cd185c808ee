"""Command line: `cardan-dyn`."""

from __future__ import annotations

from pathlib import Path

import click

from . import __version__
from .errors import CardanError


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
    from . import comparisons
    from . import report as reporting

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
