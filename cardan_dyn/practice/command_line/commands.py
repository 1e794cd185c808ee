"""Command line: `cardan-dyn`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..._version import __version__
from . import names, options
from .group import EXIT_CODES, MISSED, Commands
from .motion_options import simulate, sweep
from .report_options import report
from .showing import present
from .vibration_options import vibration


def _say_version(context: click.Context, _option: click.Parameter, is_asked: bool) -> None:
    """Print the version, and whether compiled functions are used."""
    if not is_asked or context.resilient_parsing:
        return
    from ...core.compiled import absent

    click.echo(f"cardan-dyn, version {__version__}")
    click.echo(f"compiled functions: {f'no, {absent}' if absent else 'yes'}")
    context.exit()


@click.group(
    cls=Commands,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog=EXIT_CODES,
)
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_say_version,
    help="Show the version, and whether compiled functions are used.",
)
def main() -> None:
    """Joint wrenches of closed-chain mechanisms with Pinocchio.

    Values take other units than those that the help says behind them, as --speed 300rad/s.
    """


@main.command("list")
@options.as_json("Print names and descriptions as JSON.")
def list_(as_json: bool) -> None:
    """List the bundled mechanisms and drive lines."""
    rooms = {"mechanisms": names.mechanisms(), "drive lines": names.lines()}
    told = {
        room: {name: names.about(path) for name, path in files.items()}
        for room, files in rooms.items()
    }
    from .tables import crop, print_json, say

    if as_json:
        print_json(told)
        return
    width = max(len(name) for found in told.values() for name in found)
    for room, found in told.items():
        say(room, "bold")
        for name, text in found.items():
            crop(f"  {name.ljust(width)}  {text}")


@main.command()
@options.source
@options.strict
def describe(source: str, strict: bool) -> None:
    """Describe a mechanism: joints, mobility, redundancy.

    NAME_OR_FILE is a bundled description or a URDF, MJCF or SDF file.
    """
    from .mechanism_command import describe_source

    describe_source(source, strict=strict)


@main.command()
@options.source
@options.strict
@options.as_json("Print all of it as JSON, in SI units and radians.")
def check(source: str, strict: bool, as_json: bool) -> None:
    """Check a mechanism: what is wrong, how it can be driven.

    Says what statics determine and what not, which joints can drive the mechanism, and over which
    range each of them moves while the other drives are at rest.

    NAME_OR_FILE is a bundled description or a URDF, MJCF or SDF file. Exits with 1 if it cannot be
    swept.
    """
    from .mechanism_command import check_source

    if not check_source(source, strict=strict, as_json=as_json):
        raise SystemExit(MISSED)


@main.command()
@options.directory(
    "--out", "directory", "Directory for the figures and the HTML page.", Path("comparison")
)
@options.as_json("Print the comparisons as JSON.")
@click.option("--figures/--no-figures", default=True, help="Write figures and page, or only print.")
def compare(directory: Path, as_json: bool, figures: bool) -> None:
    """Compare bundled mechanisms with the closed forms.

    Those of Weisbach, Thoma (1920) and Grossmann (1939).

    Exits with 1 when a comparison falls short of its tolerance.
    """
    from ..report import comparisons
    from ..report import report as reporting
    from .tables import print_json, show

    compared = comparisons.run()
    if as_json:
        print_json(reporting.plain(compared))
    else:
        show(compared.header, [item.cells for item in compared], texts=(0, 1, 2))
    if figures:
        page = reporting.write(compared, directory)
        click.echo(f"Figures and page: {page}", err=as_json)
    if not compared.passed:
        raise SystemExit(MISSED)


@main.command()
@options.source
@options.drive
@options.near
@options.held
@options.loads
@options.speed("Speed of a drive that turns [1/min]; quasi-static without.")
@options.gravity
@options.repeated("--joint", "joints", "JOINT", "Draw only this joint")
@options.repeated("--hide", "hide", None, "Leave a part out", type=click.Choice(options.HIDDEN))
@click.option(
    "--duration",
    type=options.Quantity("time", "s"),
    help="Of one sweep [s]; its own time, or 8 s, if not given.",
)
@options.samples(721)
@options.strict
@options.written("--export", "file", "Write one HTML file that needs no network, and end.")
@options.opens("Open a browser.")
def view(source: str, file: Path | None, open_browser: bool, **given: Any) -> None:
    """Watch a mechanism move, with its moments and forces.

    NAME_OR_FILE is a bundled description or a file. The page is served on this machine until
    Ctrl-C; its address is printed, so that it can be opened where no browser opens it.
    """
    from .view_command import scene_of

    present(scene_of(source, **given), file, open_browser)


@main.command()
@options.line
@options.speed("Speed of the input shaft [1/min]; that of the file without.")
@click.option(
    "--torque",
    "torque",
    type=options.Quantity("torque", "N·m"),
    help="Torque of the input shaft [N·m], likewise.",
)
@options.repeated(
    "--limit", "limits", "NAME=VALUE", "Another limit with its unit, as residual_angle=3deg"
)
@options.flag("Judge the line with its best forks.", "--optimise-phases")
@click.option("--teeth", type=click.IntRange(2), help="Forks can be turned by 360°/TEETH alone.")
@options.written(
    "--page",
    "page",
    "Write one HTML page with data, figures and verdict; for a PDF print it from a browser.",
)
@click.option("--scene/--no-scene", default=True, help="Put the turning scene on the page.")
@click.option(
    "--units",
    type=click.Choice(["si", "imperial"]),
    help="Units of the page; those of most quantities of the file without.",
)
@click.option(
    "--language",
    type=click.Choice(["en", "de"]),
    default="en",
    show_default=True,
    help="Language of the page.",
)
@options.head("project", "customer", "author", "revision", "date")
@options.figures
@options.flag("Watch the line turn, in a browser.", "--view", "watch")
@options.written("--export", "file", "Write the turning scene as one HTML file.")
@options.opens("Open a browser to --view.")
@options.as_json("Print the verdict as JSON.")
@options.flag("Exit with 1 if a limit is missed, with 3 if rows are open.", "--check")
@options.flag("Print the JSON schema of the files, and end.", "--schema")
def driveline(source: str | None, **given: Any) -> None:
    """Hold a drive line against the rules of practice.

    NAME_OR_FILE is a TOML file (--schema lists its fields), or a line that comes with the package.
    """
    from .driveline_command import run

    run(source, **given)


@main.command()
@options.source
@options.speed("Speed of the drive [1/min].")
@options.repeated(
    "--clearance",
    "clearances",
    "[JOINT=]VALUE",
    "Difference of the diameters of bush and pin [m], of one joint, or of all that have no other",
    required=True,
)
@options.repeated(
    "--stiffness", "stiffnesses", "[JOINT=]VALUE", "Of a contact with its seat [N/m], likewise"
)
@click.option(
    "--pin",
    type=options.Quantity("length", "m"),
    nargs=2,
    metavar="LENGTH RADIUS",
    help="Steel pins of this size instead of a stiffness [m].",
)
@click.option(
    "--seat-stiffness",
    type=options.Quantity("rigidity", "N/m"),
    help="Of what holds these pins [N/m].",
)
@click.option(
    "--damping-ratio", type=float, default=0.0, show_default=True, help="Of a contact, a number."
)
@click.option(
    "--start",
    type=click.Choice(["release", "rest"]),
    default="release",
    show_default=True,
    help="How flights begin; 'rest' is for the paper's example.",
)
@click.option(
    "--rotor",
    type=options.Quantity("inertia", "kg·m²"),
    help="Inertia that turns with a drive that gives way [kg·m²].",
)
@options.flag("Simulate joints that strike as well; takes seconds for each.", "--verify")
@options.repeated(
    "--joint",
    "joints",
    "JOINT",
    "Scan only these joints; a universal joint by its name, or by the link that is its cross",
)
@options.repeated(
    "--radius",
    "radii",
    "[PIN=]VALUE",
    "Of a universal joint, from its centre to the bearings of its pins [m]",
)
@options.repeated(
    "--bearing",
    "bearings",
    "BEARING",
    "That has clearance in a universal joint, PIN+ or PIN-, or PIN for both; all if none",
)
@options.drive
@options.near
@options.held
@options.loads
@options.gravity
@options.strict
@options.figures
@options.as_json("Print the scan as JSON.")
def clearance(directory: Path | None, as_json: bool, **given: Any) -> None:
    """Tell which joints would hammer with clearance.

    NAME_OR_FILE is a bundled description or a file. Joints are listed by their greatest forces,
    with what speaks against these. Inertia alone acts unless loads or gravity are given.
    """
    from .clearance_command import run

    run(directory, as_json, **given)


@main.command()
@click.argument("file", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@options.flag("Tell the plan, from a few timed cases, and end.", "--dry-run")
@click.option("--workers", type=click.IntRange(1), help="Processes; one for each core without.")
@click.option("--scheduler", metavar="ADDRESS", help="A Dask scheduler that computes instead.")
@click.option("--store", metavar="PATH_OR_URL", help="Where results are kept, as the file says.")
@options.flag("Go on with what is there.", "--resume")
@options.flag("Compute what failed once more.", "--retry")
@options.flag("Read all that is there, and say what is damaged.", "--verify")
def study(file: Path, **given: Any) -> None:
    """Compute results over parameters, into a Zarr store.

    FILE is a TOML file with the mechanism, its scene, what is wanted of it, parameters, and where
    results are kept; docs/studies.md shows one. What is finished stays when this ends early.
    """
    from .study_command import run

    run(file, **given)


for _command in (report, vibration, sweep, simulate):
    main.add_command(_command)
