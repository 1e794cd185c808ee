"""Mechanism page: the report on a mechanism as one HTML file that needs nothing else."""

from __future__ import annotations

import platform
from collections.abc import Iterator
from contextlib import suppress
from importlib.metadata import version as version_of
from pathlib import Path
from typing import Any

import numpy as np

from ..._version import __version__
from ...core.elements.link_loads import Wrench
from ...core.results.sweep import Sweep
from ...figures.orders import draw_bars
from ...figures.style import axes_grid, require_matplotlib
from ...figures.wrenches import QUANTITIES
from ...kit.arrays import NOTHING
from ...kit.errors import ArgumentError, CardanError
from ...kit.quantities import amount, number
from ..viewer.bodies import Bodies
from ..viewer.picture import picture
from ..viewer.viewing import view
from . import page
from .cases import Cases
from .courses import courses
from .described import described, drives_grid, elements_of, mobility_grids
from .extremes import RIGHT, counted, places_of, quantities_of
from .findings import Findings, between, gravity_of, sentence, way_of
from .grids import Grid, Row, stem_of

_COURSES = {
    "axial": "Axial force",
    "shear": "Radial force",
    "torsion": "Torsion",
    "bending": "Bending moment",
}
"""Quantities that are drawn over the drive, and how captions call them."""


def write(cases: Cases, path: Path, with_scene: bool) -> Path:
    """Write the page of one case or of several; see `Report.save`.

    Raises:
        MissingExtraError: Matplotlib, Jinja or meshcat is not installed.
        ArgumentError: it cannot be written.
        CardanError: the mechanism cannot be described.
    """
    require_matplotlib()
    first, told = cases.reports[0], [item for _, item in cases.governing]
    mechanism, found = first.mechanism, first.description
    # Figures are those of cases that govern something, and one scene alone, which is a megabyte.
    drawn = [case for case, _ in cases.governing] or [0]
    is_drawn = told and all(report.drives for report in cases.reports)
    source = mechanism.description.text
    file = "text" if source is None or source.path is None else source.path.name
    grids = mobility_grids(found)
    with suppress(CardanError):
        ways = [one for report in cases.reports for one in report.ways]
        drives = drives_grid(found.drives, {one.name for one in ways if one.kind == "drive"})
        grids += [drives] if drives.rows else []
    block = {
        "Mechanism": mechanism.name,
        "Project": first.project,
        "Author": first.author,
        "Date": first.date,
        "Revision": first.revision,
        "Description": f"{file}, SHA-256 {first.sha256[:8]}…",
    }
    return page.write(
        path,
        "mechanism.html",
        title=first.title,
        title_block=[(name, value or "–") for name, value in block.items()],
        stem=stem_of(mechanism.name),
        summary=_summary(cases),
        told_apart=cases.told_apart if cases.labels else [],
        headline=cases.sized,
        drawing=_drawing(cases),
        figure=page.image(courses(cases, told)) if is_drawn else "",
        warnings=_warnings(cases),
        beside=[
            cases.beside(start, page.BESIDE)
            for start in range(0, len(cases.reports), page.BESIDE)
            if cases.compared
        ],
        cases=[
            _case_parts(report, label, index in drawn, with_scene and index == drawn[0])
            for index, (report, label) in enumerate(
                zip(cases.reports, cases.labels or [""], strict=True)
            )
        ],
        mobility=[
            ("mobility", str(found.mobility)),
            ("joint coordinates", str(found.coordinates)),
            ("independent closure equations (rank)", str(found.rank)),
            ("redundant equations", str(sum(item.self_stresses for item in found.components))),
            ("ranks around", found.place),
            ("loops are written as", found.notation),
            ("characteristic length", amount(found.length, "m")),
        ],
        mobility_remarks=[sentence(text) for text in found.mobility_remarks],
        mobility_grids=grids,
        described=described(mechanism),
        left_out=mechanism.warnings,
        versions=[
            ("cardan_dyn", __version__),
            *((name, version_of(name)) for name in ("pin", "numpy", "matplotlib")),
            ("Python", platform.python_version()),
            ("SHA-256 of the description", first.sha256),
        ],
    )


def _summary(cases: Cases) -> str:
    """Return in one line what there is, what moves it and what acts."""
    reports = cases.reports
    report, mechanism = reports[0], reports[0].mechanism
    parts = ((mechanism.links, "link"), (mechanism.joints, "joint"), (mechanism.loops, "loop"))
    counts = ", ".join(counted(len(items), name) for items, name in parts)
    text = f"{mechanism.name}: {counts}, mobility {report.description.mobility}."
    if len(reports) > 1:
        text += f" {cases.in_words}."
    elif report.sweep is None:
        return text
    else:
        kinds = dict.fromkeys(one.kind for one in report.task or report.ways)
        moved = " and ".join(kinds).replace("drive", "driven").capitalize()
        moved = f"{moved}: " * bool(report.drives)
        text += f" {moved}{'; '.join(report.case_lines)}."
    told = [item for one in reports for item in one.told]
    if not told:
        return f"{text} Nothing acts: there is no load, weight, inertia or element in this case."
    if not any(item.quantity in QUANTITIES for item in told):
        # As where a coupling passes on all that acts, or the outputs leave wrenches out.
        is_known = all(item.determined for one in reports for item in one.extremes)
        text += " Joints carry nothing." if is_known else " What joints carry is not known."
    elif not cases.governing:
        text += " Statics determines nothing of what joints carry."
    return f"{text} There are doubts, see below." if any(one.doubts for one in reports) else text


def _warnings(cases: Cases) -> list[str]:
    """Return what has to be known before any number is used, once where cases have it in common."""
    told = "; all that is tabled here is determined" * bool(cases.governing)
    found = [
        sentence(f"{report.opened.brief}{told}")
        for report in cases.reports
        if report.opened is not None and report.left_open
    ]
    found += [text for report in cases.reports for text in report.beware] + cases.remarks
    if cases.reports[0].description.is_counted:
        found.append(
            "Ranks were counted from the structure alone, as loops are too many to be measured; "
            "that misses mechanisms that move only because of special dimensions."
        )
    return list(dict.fromkeys(found))


def _case_parts(report: Findings, label: str, is_drawn: bool, with_scene: bool) -> dict[str, Any]:
    """Return what the page shows of a case, with figures or without."""
    sweep = report.sweep
    residuals = [(name, f"{value:.1e}", text) for name, value, text in report.judgement]
    heading = f"Residuals and condition{', ' * bool(label)}{label}"
    parts: dict[str, Any] = {
        "label": label,
        "said": report.said,
        "exceeded": report.exceeded if len(report.beware) > len(report.doubts) + 3 else (),
        "drawn": sweep is not None and is_drawn,
        "proof": Grid("proof", heading, ("what", "value", "which means"), residuals),
    }
    if sweep is None:
        return parts | {"case": [("computed", "nothing; see below")]}
    parts |= {
        "case": list(_case(report, sweep)),
        "case_grids": [*_loads(sweep), *elements_of(sweep)],
    }
    parts["unproven"] = ", ".join(sweep.unproven)
    parts["is_unique"] = bool(sweep.outputs) and not report.left_open
    return parts | _extremes(report) | (_figures(report, sweep, with_scene) if is_drawn else {})


def _case(report: Findings, sweep: Sweep) -> Iterator[tuple[str, str]]:
    """Yield names and values of what moves and what acts."""
    rest = [] if any(one.pace for one in report.ways) else ["quasi-static"]
    for one in report.ways:
        yield f"{one.kind} {one.name}", ", ".join([one.span, *rest, *one.pace])
    yield "positions", str(len(sweep))
    for name, value in sweep.held.items():
        yield f"held {name}", way_of(value, sweep.mechanism.drivable[name].slides)
    yield "gravity in world axes", gravity_of(sweep) or "none"
    if not sweep.loads:
        yield "loads", "none"
    if not sweep.elements:
        yield "elements", "none act"
    for name, factor in sweep.inertia.items():
        yield f"inertia of {name}", f"{between(factor)} times"


def _loads(sweep: Sweep) -> Iterator[Grid]:
    """Yield the loads of the case."""
    rows: list[Row] = []
    for name, load in sweep.loads.items():
        if isinstance(load, Wrench):
            for quantity, unit in (("force", "N"), ("moment", "N·m")):
                vectors = np.reshape(getattr(load, quantity), (-1, 3))
                listed = ", ".join(between(vectors[:, i]) for i in range(3))
                rows.append((name, f"{quantity} on the link, {load.frame} axes", listed, unit))
            at = ", ".join(number(float(value)) for value in np.ravel(load.point))
            rows.append((name, "point of application, link axes", at, "m"))
        else:
            unit = sweep.mechanism.drivable[name].effort_unit
            rows.append((name, "effort at the joint", between(load), unit))
    if rows:
        yield Grid("loads", "Loads", ("joint or link", "what", "value", "unit"), rows)


def _extremes(report: Findings) -> dict[str, Any]:
    """Return the tables of extremes."""
    if not report.acts:
        return {}
    zero: dict[str, list[str]] = {}
    for item in report.extremes:
        if not item.acts and item.determined:
            zero.setdefault(item.owner, []).append(item.quantity)
    text = ""
    if report.drives:
        text = f"They are the extremes of {report.covered}"
        text += ", and exact to the digits shown." if report.is_exact else "."
    return {
        "extremes": [*report.grids(), *_places(report)],
        "located": text,
        "opened": sentence(report.left_open and report.left_open + report.what_is_determined),
        "is_marked": report.is_marked,
        "idle": "; ".join(f"{name} ({', '.join(what)})" for name, what in zero.items()),
    }


def _places(report: Findings) -> Iterator[Grid]:
    """Yield rows of the task, or positions of several drives, at the places of the extremes."""
    sweep, places = report.sweep, report.places
    if sweep is None or not report.has_places:
        return
    told, caption = report.ways, "Positions of the drives at these places"
    if report.task:
        told, caption = report.told_rows, "The task at these places"
        positions = np.reshape(sweep.position, (len(sweep), -1))
        samples = [int(np.all(positions == at, axis=1).argmax()) for at in places]
        known = np.stack([row.position[samples] for row in told], axis=1)
    else:
        # What is rounding beside the way of a drive is nothing.
        most = np.stack([np.abs(one.position).max() for one in told])
        known = np.where(np.abs(places) <= NOTHING * most, 0.0, places)
    named = [f"{one.name} [{one.unit}]" for one in told]
    names = (report.at(at[None], word="") for at in places)
    rows: list[Row] = [(name, *row) for name, row in zip(names, known.tolist(), strict=True)]
    header: tuple[str, ...] = ("place", *named)
    if len(named) > page.BESIDE:
        rows = [(name, ", ".join(map(number, row))) for name, *row in rows]
        caption, header = f"{caption}: {', '.join(named)}", ("place", "positions")
    yield Grid("positions", caption, header, rows)


def _drawing(cases: Cases) -> tuple[str, str] | None:
    """Return a picture of the mechanism and its caption; None if nothing of it can be drawn."""
    case, item = next(iter(cases.governing), (0, None))
    report, sample, said = cases.reports[case], 0, "where it starts"
    sweep = report.sweep
    if sweep is None:
        return None
    if item is not None:
        (of,) = (one for one in quantities_of(sweep) if one[:2] == item[:2])
        sample = int(np.nanargmax(np.abs(of.values(sweep))))
        said = report.at(places_of(sweep)[sample : sample + 1]) or f"sample {sample + 1}"
        said = f"at {said}, about where {item.quantity} of {item.owner} is greatest"
    try:
        return page.image(picture(sweep, sample)), f"{sentence(said)[:-1]}, with drives and loads."
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
    # What turns in what stands still comes first.
    on_ground = Bodies(sweep, np.arange(len(sweep)), visuals=False).on_ground()
    joints = [name for name in acting if name in on_ground] or list(acting)

    def carrying(quantity: str) -> list[str]:
        return [name for name in joints if quantity in acting[name]][: page.BESIDE]

    for quantity, text in _COURSES.items():
        if names := carrying(quantity):
            figure = drawn.plot(*names, quantities=quantity, figsize=(7.2, 3.4))
            found["courses"].append((page.image(figure), f"{text} in {', '.join(names)}.{told}"))
    without = [name for name in joints if "moment" in acting[name] or not sweep[name].has_axis][:2]
    if without and not found["courses"]:
        columns = [f"{name}.force_{axis}" for name in without for axis in "xyz"]
        caption = f"Force in {', '.join(without)}, in the axes of the joints.{told}"
        found["courses"].append((page.image(drawn.plot(*columns)), caption))
    for quantity, part in (("force", "shear"), ("moment", "bending")):
        if names := carrying(part):
            caption = (
                f"{_COURSES[part]} in {', '.join(names)}: the curve of the vector in axes fixed in "
                f"the parent, across the joint's axis; all diagrams have one scale.{told}"
            )
            found["polars"].append((page.image(drawn.plot.polar(names, of=quantity)), caption))
    return found | _orders(report)


def _orders(report: Findings) -> dict[str, Any]:
    """Return the table and the figure of orders, if there are any."""
    rows: list[Row] = [
        (owner, quantity, unit, *map(float, amplitudes))
        for (owner, quantity, unit), amplitudes in report.orders.items()
        if np.any(amplitudes[1:])
    ]
    if not rows:
        return {"no_orders": report.no_orders or "all quantities are constant"}
    every = range(page.HIGHEST + 1)
    header = ("of", "quantity", "unit", *(f"order {order}" for order in every))
    name, quantity, unit, *sizes = next((row for row in rows if row[1] == "drive effort"), rows[0])
    figure, axes = axes_grid(size=(7.2, 3.4))
    draw_bars(axes, every[1:], {name: np.array(sizes[1:])})
    axes.set_xlabel("order: swings per revolution of the drive [–]")
    axes.set_ylabel(f"amplitude [{unit}]")
    axes.set_xticks(every[1:])
    error = report.orders_error
    return {
        "orders_doubt": f"Known to {error:.0e} of the greatest: something jumps, or the motion "
        "does not come back."
        if error > RIGHT
        else "",
        "orders": Grid("orders", "Amplitudes by order", header, rows, unit=2),
        "order_figure": (
            page.image(figure),
            f"Orders of {name}, {quantity}, about a mean of {amount(sizes[0], unit)}.",
        ),
    }
