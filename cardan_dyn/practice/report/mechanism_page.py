"""Mechanism page: the report on a mechanism as one HTML file that needs nothing else."""

from __future__ import annotations

import platform
from collections.abc import Iterator, Sequence
from importlib.metadata import version as version_of
from pathlib import Path
from typing import Any

import numpy as np

from ..._version import __version__
from ...core.elements.link_loads import Wrench
from ...core.mechanism.mechanism import Mechanism
from ...core.results.sweep import Sweep
from ...figures.style import axes_grid, line_style, require_matplotlib
from ...figures.wrenches import QUANTITIES
from ...kit.arrays import NOTHING
from ...kit.errors import ArgumentError, CardanError
from ...kit.quantities import amount, number
from ...scene.mechanism_report import MechanismReport
from ..viewer.picture import picture
from ..viewer.viewing import view
from . import page
from .courses import MOST_DRAWN, courses
from .described import described, mobility_grids, remarks_of
from .extremes import RIGHT, Extreme
from .findings import (
    Findings,
    between,
    cases_apart,
    cases_in_words,
    cases_with,
    compared,
    governing,
    speed_text,
    task_rows,
)
from .grids import Grid, place, stem_of
from .grids import way as way_of

_MOST_COLUMNS = 8
"""Numbers that stand beside each other in a row of a table on paper."""
_COURSES = {
    "axial": "Axial force",
    "shear": "Radial force",
    "torsion": "Torsion",
    "bending": "Bending moment",
}
"""Quantities that are drawn over the drive, and how captions call them."""


def write(reports: Sequence[Findings], labels: Sequence[str], path: Path, with_scene: bool) -> Path:
    """Write the page of a case without a label, or of several; see `Report.save`.

    Raises:
        MissingExtraError: Matplotlib, Jinja or meshcat is not installed.
        ArgumentError: it cannot be written.
        CardanError: the mechanism cannot be described.
    """
    require_matplotlib()
    first, mechanism = reports[0], reports[0].mechanism
    found, headline = first.description, governing(reports)
    # Figures are those of cases that govern something, and one scene alone, which is a megabyte.
    drawn = [case for case, _ in headline] or [0]
    source = mechanism.description.text
    file = "" if source is None or source.path is None else source.path.name
    block = [
        ("Mechanism", mechanism.name),
        ("Project", first.project),
        ("Author", first.author),
        ("Date", first.date),
        ("Revision", first.revision),
        ("Description", f"{file or 'text'}, SHA-256 {first.sha256[:8]}…"),
    ]
    return page.write(
        path,
        "mechanism.html",
        title=first.title,
        title_block=[(name, value or "–") for name, value in block],
        stem=stem_of(mechanism.name),
        summary=_summary(reports),
        told_apart=cases_apart(reports, labels) if labels else [],
        headline=_headline(reports, labels, headline),
        drawing=_drawing(first),
        warnings=_warnings(reports),
        side_by_side=_side_by_side(reports, labels, [item for _, item in headline])
        if labels
        else None,
        cases=[
            _case_parts(report, label, index in drawn, with_scene and index == drawn[0])
            for index, (report, label) in enumerate(zip(reports, labels or [""], strict=True))
        ],
        mobility=_mobility(found),
        mobility_remarks=list(remarks_of(found)),
        mobility_grids=[*mobility_grids(found), *_drives(found)],
        described=described(mechanism),
        left_out=mechanism.warnings,
        versions=[
            ("cardan_dyn", __version__),
            *((name, version_of(name)) for name in ("pin", "numpy", "matplotlib")),
            ("Python", platform.python_version()),
            ("SHA-256 of the description", first.sha256),
        ],
    )


def _case_parts(report: Findings, label: str, is_drawn: bool, with_scene: bool) -> dict[str, Any]:
    """Return what the page shows of a case, with figures or without."""
    sweep = report.sweep
    parts = {
        "label": label,
        "case": _case(report),
        "said": report.said,
        "drawn": sweep is not None and is_drawn,
        "proof": _proof(report, label),
        "proof_remarks": _proof_remarks(report),
    }
    if sweep is None:
        return parts
    shown = {"case_grids": list(_acting(sweep))} | _extremes(report)
    return parts | shown | (_figures(report, sweep, with_scene) if is_drawn else {})


def _side_by_side(
    reports: Sequence[Findings], labels: Sequence[str], told: Sequence[Extreme]
) -> dict[str, Any]:
    """Return what acts in all cases beside each other, as a table and a figure."""
    rows = []
    for row in compared(reports):
        first = next(item for item in row if item is not None)
        sizes = [item.ends[0][0] if item else 0.0 for item in row]
        rows.append((first.owner, first.quantity, first.unit, sizes))
    parts = [slice(start, start + _MOST_COLUMNS) for start in range(0, len(labels), _MOST_COLUMNS)]
    is_drawn = told and all(report.drives for report in reports)
    return {
        "grids": [
            Grid(
                f"load_cases_{index}",
                "Greatest in size, by load case",
                ("of", "quantity", "unit", *labels[part]),
                [(*names, *sizes[part]) for *names, sizes in rows],
                unit=2,
            )
            for index, part in enumerate(parts, 1)
        ],
        "figure": page.image(courses(reports, labels, told)) if is_drawn else "",
    }


def _summary(reports: Sequence[Findings]) -> str:
    """Return in one line what there is, what moves it and what acts."""
    report = reports[0]
    found = report.description
    text = (
        f"{report.mechanism.name}: {_count(len(report.mechanism.links), 'link')}, "
        f"{_count(len(report.mechanism.joints), 'joint')}, "
        f"{_count(len(report.mechanism.loops), 'loop')}, mobility {found.mobility}."
    )
    if len(reports) > 1:
        text += f" {cases_in_words(reports)}."
    elif report.sweep is None:
        return text
    else:
        moved = "Task" if task_rows(report.sweep) else "Driven"
        text += f" {f'{moved}: ' * bool(report.drives)}{'; '.join(report.case_lines)}."
    told = [item for one in reports for item in one.told]
    if not told:
        return f"{text} Nothing acts: there is no load, weight, inertia or element in this case."
    if not any(item.quantity in QUANTITIES for item in told):
        # As where a coupling passes on all that acts, or the outputs leave wrenches out.
        is_known = all(item.determined for one in reports for item in one.extremes)
        text += " Joints carry nothing." if is_known else " What joints carry is not known."
    elif not governing(reports):
        text += " Statics determines nothing of what joints carry."
    return f"{text} There are doubts, see below." if any(one.doubts for one in reports) else text


def _headline(
    reports: Sequence[Findings], labels: Sequence[str], found: Sequence[tuple[int, Extreme]]
) -> Grid | None:
    """Return how big what joints are sized by is, where, and in which of several cases."""
    rows = []
    for case, item in found:
        (most, place), _ = item.ends
        row = (item.quantity, item.unit, most, item.owner, reports[case].at(place))
        rows.append((*row, cases_with(reports, labels, (case, item))) if labels else row)
    header = ("quantity", "unit", "greatest in size", "in", "at", *["load case"] * bool(labels))
    return Grid("headline", "What joints are sized by", header, rows, unit=1) if rows else None


def _sentence(text: str) -> str:
    return text and f"{text[0].upper()}{text[1:]}."


def _of(text: str, label: str) -> str:
    """Return a heading of one of several cases."""
    return f"{text}, {label}" if label else text


def _count(count: int, name: str) -> str:
    return f"{count} {name}{'s' * (count != 1)}"


def _warnings(reports: Sequence[Findings]) -> list[str]:
    """Return what has to be known before any number is used, once where cases have it in common."""
    found = [
        _sentence(report.sweep.left_open.brief)
        for report in reports
        if report.sweep is not None and report.left_open
    ]
    found += [doubt for report in reports for doubt in report.doubts]
    if reports[0].description.is_counted:
        found.append("Ranks were counted, not measured.")
    return list(dict.fromkeys(found))


def _case(report: Findings) -> list[tuple[str, str]]:
    """Return names and values of the case."""
    sweep = report.sweep
    if sweep is None:
        return [("computed", "nothing; see below")]
    rows = []
    for index, name in enumerate(report.drives):
        slides = sweep.mechanism.drivable[name].slides
        way, speed, acceleration = (
            np.reshape(values, (len(sweep), -1))[:, index]
            for values in (sweep.position, sweep.speed, sweep.acceleration)
        )
        low, high = float(way.min()), float(way.max())
        text = f"{'from ' * (low < high)}{way_of(low, high, slides, ' to ')}"
        text += f", {speed_text(speed, slides)}" if np.any(speed) else ", quasi-static"
        if np.any(acceleration):
            text += f", acceleration {between(acceleration, 'm/s²' if slides else 'rad/s²')}"
        rows.append((f"drive {name}", text))
    for name, (values, unit) in task_rows(sweep).items():
        low, high = float(values.min()), float(values.max())
        text = f"{'from ' * (low < high)}{way_of(low, high, unit == 'm', ' to ')}"
        rows.append((f"task {name}", text))
    rows.append(("positions", str(len(sweep))))
    for name, value in sweep.held.items():
        slides = sweep.mechanism.drivable[name].slides
        every = np.ravel(np.asarray(value, dtype=float))
        rows.append((f"held {name}", way_of(float(every.min()), float(every.max()), slides)))
    gravity = np.reshape(sweep.gravity, (-1, 3))
    if not np.any(gravity):
        rows.append(("gravity", "none"))
    elif np.all(gravity == gravity[0]):
        listed = ", ".join(number(float(value)) for value in gravity[0])
        rows.append(("gravity in world axes", f"({listed}) m/s²"))
    else:
        rows.append(("gravity", "varies over the samples"))
    rows.append(("loads", _count(len(sweep.loads), "load") if sweep.loads else "none"))
    rows.append(
        ("elements", _count(len(sweep.elements), "element") if sweep.elements else "none act")
    )
    for name, factor in sweep.inertia.items():
        every = np.ravel(np.asarray(factor, dtype=float))
        rows.append((f"inertia of {name}", f"{between(every)} times"))
    return rows


def _acting(sweep: Sweep) -> Iterator[Grid]:
    """Yield the loads and the elements of the case."""
    rows: list[tuple[Any, ...]] = []
    for name, load in sweep.loads.items():
        if isinstance(load, Wrench):
            for quantity, unit in (("force", "N"), ("moment", "N·m")):
                vectors = np.reshape(getattr(load, quantity), (-1, 3))
                listed = ", ".join(between(vectors[:, i]) for i in range(3))
                rows.append((name, f"{quantity} on the link, {load.frame} axes", listed, unit))
            at = ", ".join(number(float(value)) for value in np.ravel(load.point))
            rows.append((name, "point of application, link axes", at, "m"))
        else:
            every = np.ravel(np.asarray(load, dtype=float))
            unit = sweep.mechanism.drivable[name].effort_unit
            rows.append((name, "effort at the joint", between(every), unit))
    if rows:
        yield Grid("loads", "Loads", ("joint or link", "what", "value", "unit"), rows)
    if sweep.elements:
        listed_elements = [
            (item.name or f"elements[{index}]", type(item).__name__, repr(item))
            for index, item in enumerate(sweep.elements)
        ]
        yield Grid("elements", "Force elements", ("element", "kind", "data"), listed_elements)


def _mobility(found: MechanismReport) -> list[tuple[str, str]]:
    return [
        ("mobility", str(found.mobility)),
        ("joint coordinates", str(found.coordinates)),
        ("independent closure equations (rank)", str(found.rank)),
        ("redundant equations", str(sum(item.self_stresses for item in found.components))),
        ("ranks around", found.place),
        ("loops are written as", found.notation),
        ("characteristic length", amount(found.length, "m")),
    ]


def _drives(found: MechanismReport) -> Iterator[Grid]:
    """Yield how the mechanism can be driven, and over which range."""
    try:
        drives = found.drives
    except CardanError:
        return
    rows = []
    for item in drives.ranked:
        role = "default" if item.name in drives.default else ""
        if item.name in drives.held:
            role = f"held at {place(drives.held[item.name], item.slides)}"
        elif not role and item.determines and item.instead_of:
            role = f"instead of {', '.join(item.instead_of[:3])}"
        low, high = item.range or (np.nan, np.nan)
        rows.append(
            (
                item.name,
                "slide" if item.slides else "angle",
                "yes" if item.is_grounded else "no",
                place(low, item.slides) if np.isfinite(low) else "",
                place(high, item.slides) if np.isfinite(high) else "",
                item.ends,
                role,
            )
        )
    header = ("coordinate", "kind", "at the ground", "from", "to", "what ends the range", "role")
    if rows:
        yield Grid(
            "drives", f"How it can be driven, from where it starts ({drives.reason}).", header, rows
        )


def _extremes(report: Findings) -> dict[str, Any]:
    """Return the tables of extremes."""
    if not report.acts:
        return {}
    acting = report.told
    # What joints can be sized by comes first.
    acting = sorted(acting, key=lambda item: not item.determined)
    wrenches = [item for item in acting if item.quantity in QUANTITIES]
    others = [item for item in acting if item.quantity not in QUANTITIES]
    zero: dict[str, list[str]] = {}
    for item in report.extremes:
        if not item.acts and item.determined:
            zero.setdefault(item.owner, []).append(item.quantity)
    at = "place" if len(report.drives) > 1 else "at"
    header = ("quantity", "unit", "greatest in size", at, "other end", f"{at} ")
    text = ""
    if report.drives:
        text = f"They are the extremes of {report.covered}"
        text += "." if report.doubts else ", and exact to the digits shown."
        if not all(item.settled for item in acting):
            text += " A ? marks what may be exceeded."
    return {
        "wrenches": Grid(
            "extremes",
            "Greatest in size and the other end of the range, with the drive's position",
            ("joint", *header),
            [_extreme(report, item) for item in wrenches],
            unit=2,
        )
        if wrenches
        else None,
        "efforts": Grid(
            "efforts",
            "Efforts of drives, of what is held, of couplings and elements",
            ("of", *header),
            [_extreme(report, item) for item in others],
            unit=2,
        )
        if others
        else None,
        "located": text,
        "opened": _sentence(report.left_open),
        "idle": "; ".join(f"{name} ({', '.join(what)})" for name, what in zero.items()),
        "places": _places(report),
    }


def _extreme(report: Findings, item: Extreme) -> tuple[Any, ...]:
    mark = " *" * (not item.determined) + " ?" * (not item.settled)
    (most, first), (other, last) = item.ends
    what = (item.owner, f"{item.quantity}{mark}", item.unit)
    ends = (other, report.at(last, word="")) if len(last) else ("", "")
    return *what, most, report.at(first, word=""), *ends


def _places(report: Findings) -> Grid | None:
    """Return the positions of several drives at the places that the extremes name."""
    sweep = report.sweep
    if sweep is None or len(report.drives) < 2:
        return None
    units = [sweep.mechanism.drivable[name].unit for name in report.drives]
    header = (
        "place",
        *(f"{name} [{unit}]" for name, unit in zip(report.drives, units, strict=True)),
    )
    caption = "Positions of the drives at these places"
    # What is rounding beside the way of a drive is nothing.
    size = NOTHING * np.abs(np.reshape(sweep.position, (len(sweep), -1))).max(axis=0)
    known = np.where(np.abs(report.places) <= size, 0.0, report.places).tolist()
    names = [report.at(at[None], word="") for at in report.places]
    rows = list(zip(names, known, strict=True))
    if len(units) > _MOST_COLUMNS:
        listed = [(name, ", ".join(map(number, row))) for name, row in rows]
        return Grid(
            "positions", f"{caption}: {', '.join(header[1:])}", ("place", "positions"), listed
        )
    return Grid("positions", caption, header, [(name, *row) for name, row in rows])


def _proof(report: Findings, label: str) -> Grid | None:
    rows = [(name, f"{value:.1e}", text) for name, value, text in report.judgement]
    return (
        Grid("proof", _of("Residuals and condition", label), ("what", "value", "which means"), rows)
        if rows
        else None
    )


def _proof_remarks(report: Findings) -> list[str]:
    sweep = report.sweep
    if sweep is None:
        return []
    found = []
    if sweep.unproven:
        found.append(
            f"Not proven by a balance, as not all that acts on them was asked for: "
            f"{', '.join(sweep.unproven)}."
        )
    if sweep.outputs and not report.left_open:
        found.append("All wrenches follow from the laws of motion alone.")
    return found


def _drawing(report: Findings) -> tuple[str, str] | None:
    """Return a picture of the mechanism and its caption; None if nothing of it can be drawn."""
    if report.sweep is None:
        return None
    try:
        return page.image(picture(report.sweep)), "Where it starts, with its drives and loads."
    except ArgumentError:  # The outputs leave nothing to draw.
        return None


def _figures(report: Findings, sweep: Sweep, with_scene: bool) -> dict[str, Any]:
    """Return the figures and the scene."""
    found: dict[str, Any] = {"courses": [], "polars": [], "no_orders": report.no_orders}
    drawn, told = report.drawn
    if with_scene and report.drives:
        shown = view(sweep, title=report.title, frames=page.FRAMES)
        found["scene"] = shown.embedded()
    if drawn is None or not (report.acts and report.drives):
        return found
    acting: dict[str, set[str]] = {}
    for item in report.extremes:
        if item.acts and item.quantity in QUANTITIES:
            acting.setdefault(item.owner, set()).add(item.quantity)
    joints = [name for name in bearings(sweep) if name in acting] or list(acting)
    for quantity, text in _COURSES.items():
        names = [name for name in joints if quantity in acting[name]][:MOST_DRAWN]
        if names:
            figure = drawn.plot(*names, quantities=quantity, figsize=(7.2, 3.4))
            found["courses"].append((page.image(figure), f"{text} in {', '.join(names)}.{told}"))
    without = [name for name in joints if "moment" in acting[name] or not sweep[name].has_axis][:2]
    if without and not found["courses"]:
        columns = [f"{name}.force_{axis}" for name in without for axis in "xyz"]
        caption = f"Force in {', '.join(without)}, in the axes of the joints.{told}"
        found["courses"].append((page.image(drawn.plot(*columns)), caption))
    for quantity, part, text in (
        ("force", "shear", "Radial force"),
        ("moment", "bending", "Bending moment"),
    ):
        names = [name for name in joints if part in acting[name]][:MOST_DRAWN]
        if names:
            figure = drawn.plot.polar(names, of=quantity)
            caption = (
                f"{text} in {', '.join(names)}: the curve of the vector in axes fixed in the "
                f"parent, across the joint's axis; all diagrams have one scale.{told}"
            )
            found["polars"].append((page.image(figure), caption))
    if report.orders:
        found |= _order_parts(report)
    return found


def _order_parts(report: Findings) -> dict[str, Any]:
    """Return the table and the figure of orders."""
    rows: list[tuple[Any, ...]] = [
        (owner, quantity, unit, *map(float, amplitudes))
        for (owner, quantity, unit), amplitudes in report.orders.items()
        if np.any(amplitudes[1:])
    ]
    if not rows:
        return {"no_orders": "all quantities are constant", "orders": None}
    header = ("of", "quantity", "unit", *(f"order {order}" for order in range(9)))
    drawn = [row for row in rows if row[1] == "drive effort"] or rows[:1]
    name, quantity, unit = drawn[0][:3]
    figure, axes = axes_grid(size=(7.2, 3.4))
    axes.bar(range(1, 9), drawn[0][4:], 0.6, color=line_style(0)["color"])
    axes.set_xlabel("order: swings per revolution of the drive [–]")
    axes.set_ylabel(f"amplitude [{unit}]")
    axes.set_xticks(range(1, 9))
    error = report.orders_error
    return {
        "orders_doubt": f"Known to {error:.0e} of the greatest: something jumps, or the motion "
        "does not come back."
        if error > RIGHT
        else "",
        "orders": Grid("orders", "Amplitudes by order", header, rows, unit=2),
        "order_figure": (
            page.image(figure),
            f"Orders of {name}, {quantity}, about a mean of {amount(drawn[0][3], unit)}.",
        ),
    }


def bearings(sweep: Sweep) -> list[str]:
    """Return the joints between what stands still over a sweep and what moves."""
    mechanism = sweep.mechanism
    ends = _links_of_joints(mechanism)
    carrier = {joint.child: joint for joint in mechanism.description.joints}

    def stands(link: str) -> bool:
        while link in carrier and carrier[link].type == "fixed":
            link = carrier[link].parent
        if link not in carrier:
            return True
        name = carrier[link].name
        spread = [np.ptp(part, axis=0).max() for part in (sweep.rotation(name), sweep.origin(name))]
        return bool(max(spread) < 1e-9 * (1.0 + mechanism.characteristic_length))

    known: dict[str, bool] = {}
    for link in {link for pair in ends.values() for link in pair}:
        known[link] = stands(link)
    return [name for name in sweep.outputs if known[ends[name][0]] != known[ends[name][1]]]


def _links_of_joints(mechanism: Mechanism) -> dict[str, tuple[str, str]]:
    """Return joints and loops with the two links that they connect."""
    found = {joint.name: (joint.parent, joint.child) for joint in mechanism.description.joints}
    loops = mechanism.description.loops
    return found | {loop.name: (loop.predecessor, loop.successor) for loop in loops}
