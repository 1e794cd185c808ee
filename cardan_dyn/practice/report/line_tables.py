"""Tables of a drive line: its data, its geometry, what acts in it and how it is judged."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import chain, groupby, pairwise
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from cardan_dyn.analytic.rules import RULES

from ...drive_lines import Analysis, DriveLine, Phasing, Verdict, VerdictRow
from ...kit.arrays import ROUNDED, Array
from ...kit.errors import CardanError
from ...kit.quantities import NONE
from ...scene.mechanism_report import grouped
from ..drive_lines.design.fork_choice import phases_of
from ..drive_lines.design.phasing import peak, with_forks
from ..drive_lines.design.support_loads import support_loads
from ..drive_lines.line.closed_chain import shaft_bodies
from ..drive_lines.line.fields import entries
from ..drive_lines.line.geometry import residual_angles
from ..drive_lines.line.supports import supports
from ..drive_lines.verdict.rows import OPEN, STATED
from ..drive_lines.wording import BY_UNIT, Wording
from .page import BESIDE

_PLACED = {
    *("name", "length", "slope_side", "slope_plan", "start", "end", "fork_offset"),
    *("tube", "spline", "centring", "bearings"),
}
"""Fields of shafts that have tables of their own."""


class Listing(NamedTuple):
    """A table: its caption, its header and rows of texts, the first `left` columns no numbers."""

    caption: str
    header: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    left: int = 1


_Column: TypeAlias = tuple[str, Sequence[str]]


def _listing(
    wording: Wording, caption: str, texts: Mapping[str, Sequence[str]], *numbers: list[_Column]
) -> Listing:
    """Return a table of columns of texts, by title, and of numbers behind them."""
    every = [*((wording(title), cells) for title, cells in texts.items()), *chain(*numbers)]
    titles, cells = zip(*every, strict=True)
    return Listing(wording(caption), titles, list(zip(*cells, strict=True)), len(texts))


def _columns(
    wording: Wording, how: str, dimension: str, titles: Sequence[str], values: Any
) -> list[_Column]:
    """Return columns of numbers [SI units], shown as a method of `Wording` does; NaN is unknown."""
    show: Any = partial(getattr(wording, how), dimension=dimension)
    if how == "number":
        show, values = wording.number, np.asarray(values) * wording.measure(dimension).factor
    return [
        (wording(title) + wording.unit(dimension), [show(float(value)) for value in column])
        for title, column in zip(titles, values, strict=True)
    ]


def line_pairs(line: DriveLine, wording: Wording) -> list[tuple[str, str]]:
    """Return names and values of what is said of a line as a whole."""
    found = [(wording("number of joints"), str(line.count))]
    for name, (_, entry) in entries(type(line)).items():
        value = getattr(line, name)
        if (
            entry.kind in ("quantity", "text", "flag")
            and name != "name"
            and value not in (None, "")
        ):
            shown = _cell(value, name, entry.dimension, wording)
            if entry.kind == "quantity":
                shown = wording.with_unit(shown, entry.dimension)
            found.append((wording(_label(name)), shown))
    return found


def data_listings(line: DriveLine, wording: Wording) -> list[Listing]:
    """Return tables of all data of a line that are not its geometry."""
    shafts = [
        (name, dataclasses.replace(shaft, **_of_tube(line, k)))
        for k, (name, shaft) in enumerate(zip(line.shaft_names, line.shafts, strict=True))
    ]
    listed: list[tuple[str, list[tuple[str, Any]], set[str]]] = [
        ("Shafts: masses and stiffness", shafts, _PLACED),
        *(
            (caption, [(name, part) for name, of in shafts if (part := getattr(of, field))], set())
            for caption, field in (
                ("Tubes", "tube"),
                ("Splines", "spline"),
                ("Centrings of double joints", "centring"),
            )
        ),
        ("Joints: data", list(zip(line.joint_names, line.joints, strict=True)), {"name"}),
    ]
    sheets = [bearing_listing(line, wording)] if line.bearings else []
    for caption, parts, left_out in listed:
        sheets += _part_listings(wording(caption), parts, left_out, wording)
    duty = [
        (point.name or wording("duty {index}", index=str(index)), point)
        for index, point in enumerate(line.duty_cycle, 1)
    ]
    return sheets + list(_part_listings(wording("Duty cycle"), duty, {"name"}, wording))


def _of_tube(line: DriveLine, k: int) -> dict[str, Any]:
    """Return the mass and the inertia of a shaft that follow from its tube, where none is given."""
    shaft = line.shafts[k]
    if shaft.tube is None or shaft.mass is not None:
        return {}
    bodies = [body for body in shaft_bodies(line, k) if body is not None]
    found = {"mass": sum(body.mass for body in bodies)}
    if shaft.inertia is None:
        found["inertia"] = sum(body.inertia for body in bodies)
    return found


def _part_listings(
    caption: str, parts: Sequence[tuple[str, Any]], left_out: set[str], wording: Wording
) -> Iterator[Listing]:
    """Yield tables of parts of one kind, a row each, with the fields that any of them has."""
    if not parts:
        return
    columns = []
    for name, (item, entry) in entries(type(parts[0][1])).items():
        values = [getattr(part, name) for _, part in parts]
        is_said = any(value not in (None, "") for value in values) and not (
            item.default in (0.0, False) and all(value == item.default for value in values)
        )
        if name not in left_out and is_said:
            cells = [_cell(value, name, entry.dimension, wording) for value in values]
            title = wording(_label(name)) + wording.unit(_dimension(name, entry.dimension))
            columns.append((title, cells))
    count = -(-len(columns) // BESIDE)
    ends = [round(len(columns) * index / count) for index in range(count + 1)] if count else []
    for start, end in pairwise(ends):
        chosen = columns[start:end]
        rows = zip((name for name, _ in parts), *(cells for _, cells in chosen), strict=True)
        yield Listing(caption, (wording("name"), *(title for title, _ in chosen)), list(rows))


def _cell(value: Any, name: str, dimension: str, wording: Wording) -> str:
    if value is None or value == "":
        return NONE
    if isinstance(value, bool):
        return wording("yes" if value else "no")
    if isinstance(value, str):
        return (
            wording(_label(value))
            if name in ("kind", "fixed_to", "application", "din_808")
            else value
        )
    return wording.given(value, _dimension(name, dimension))


def _dimension(name: str, dimension: str) -> str:
    # The only field of the dimension of moduli that is a stress.
    return "stress" if name == "shear_limit" else dimension


def _label(name: str) -> str:
    return name.replace("_", " ")


def shaft_listing(line: DriveLine, wording: Wording) -> Listing:
    """Return a row per shaft: name, length, slopes and fork offset."""
    along, *across = line.geometry.directions.T
    plan, side = (np.arctan2(part, along) for part in across)
    offsets = [shaft.fork_offset for shaft in line.shafts]
    offsets[0] = offsets[line.count] = np.nan
    angles = ("slope side", "slope plan", "fork offset"), (side, plan, offsets)
    return _listing(
        wording,
        "Shafts: geometry",
        {"shaft": line.shaft_names},
        _columns(wording, "fixed", "length", ["length"], [line.geometry.lengths]),
        _columns(wording, "fixed", "angle", *angles),
    )


def joint_listing(line: DriveLine, wording: Wording) -> Listing:
    """Return a row per joint: name, bends in both views, angle, plane and fork phase."""
    found = line.geometry
    phases = (found.fork_phases + np.pi / 2) % np.pi - np.pi / 2
    angles = *found.views.T[::-1], found.joint_angles, found.plane_offsets, phases
    titles = ("bend side", "bend plan", "joint angle β", "plane offset", "fork phase")
    columns = _columns(wording, "fixed", "angle", titles, angles)
    return _listing(wording, "Joints: angles", {"joint": line.joint_names}, columns)


_AXES = ("x forward", "y to the left", "z up")


def place_listing(line: DriveLine, wording: Wording) -> Listing:
    """Return a row per joint with where its centre is."""
    centres = np.transpose(line.geometry.centres)
    columns = _columns(wording, "fixed", "length", _AXES, centres)
    caption = "Joints: places of their centres"
    return _listing(wording, caption, {"joint": line.joint_names}, columns)


def end_listing(line: DriveLine, wording: Wording) -> Listing | None:
    """Return a row per point that the data give; None if shafts are given by slopes alone."""
    rows = [
        (name, wording(end), point)
        for name, shaft in zip(line.shaft_names, line.shafts, strict=True)
        for end, point in (("front", shaft.start), ("rear", shaft.end))
        if point is not None
    ]
    if not rows:
        return None
    shafts, ends, points = zip(*rows, strict=True)
    columns = _columns(wording, "given", "length", _AXES, np.transpose(points))
    return _listing(wording, "Ends of shafts as given", {"shaft": shafts, "end": ends}, columns)


def bearing_listing(line: DriveLine, wording: Wording) -> Listing:
    """Return a row per bearing: shaft, distance from its joint, what it carries and stands."""
    items = supports(line).bearings
    data = [(one.stiffness, one.radial_limit, one.axial_limit) for one in line.bearings]
    stiffness, *limits = np.array(data, dtype=float).T
    names, shafts = zip(*((item.name, line.shaft_names[item.shaft]) for item in items), strict=True)
    locating = [wording("yes" if item.locating else "no") for item in items]
    distances = [item.distance for item in items]
    return _listing(
        wording,
        "Bearings",
        {"bearing": names, "shaft": shafts},
        _columns(wording, "given", "length", ["distance"], [distances]),
        [(wording("locating"), locating)],
        _columns(wording, "given", "rigidity", ["stiffness"], [stiffness]),
        _columns(wording, "given", "force", ["radial limit", "axial limit"], limits),
    )


def motion_listing(analysis: Analysis, wording: Wording) -> Listing:
    """Return a row per shaft behind a joint: angle error, deviation of speeds, acceleration."""
    titles = ("least speed deviation", "greatest speed deviation")
    apart, most = analysis.ratio[:, 1:] - 1.0, np.abs(analysis.angle_error).max(axis=0)[1:]
    rates = _cleared(np.abs(analysis.acceleration).max(axis=0))[1:]
    return _listing(
        wording,
        "Motion over a turn",
        {"shaft": analysis.shafts[1:]},
        _columns(wording, "number", "angle", ["angle error ±"], [most]),
        _columns(wording, "number", "share", titles, [apart.min(axis=0), apart.max(axis=0)]),
        _columns(wording, "number", "angular_acceleration", ["greatest acceleration"], [rates]),
    )


def moment_listing(analysis: Analysis, wording: Wording) -> Listing:
    """Return a row per joint: greatest torques and bending moments before and behind it."""
    forces = analysis.total
    names = ("torsion_in", "torsion_out", "bending_in", "bending_out")
    sizes = _cleared(np.array([np.abs(getattr(forces, name)).max(axis=0) for name in names]))
    titles = ("torque before", "torque behind", "bending before", "bending behind")
    columns = _columns(wording, "number", "torque", titles, sizes)
    return _listing(wording, "Greatest moments over a turn", {"joint": analysis.joints}, columns)


def extreme_listing(analysis: Analysis, verdict: Verdict, wording: Wording) -> Listing:
    """Return a row per bearing: forces at the operating point of the analysis, and of all cases.

    At this point, those are the greatest across, the mean across and the greatest along; of all
    load cases the greatest across and along, as the verdict has them.
    """
    forces, names = analysis.total, analysis.bearings
    worst = {(row.where, row.quantity): row.value for row in verdict}
    kinds = ("force across the shaft", "force along the shaft")
    sizes = np.array(
        [
            forces.bearing_radial.max(axis=0),
            np.linalg.norm(forces.bearing_force[..., 1:].mean(axis=0), axis=-1),
            np.abs(forces.bearing_axial).max(axis=0),
        ]
    )
    every = np.array([[worst.get((name, kind)) for name in names] for kind in kinds], dtype=float)
    titles = [
        "greatest across",
        "mean across",
        "greatest along",
        "across, all load cases",
        "along, all load cases",
    ]
    columns = _columns(wording, "number", "force", titles, [*_cleared(sizes), *every])
    return _listing(wording, "Bearing forces over a turn", {"bearing": names}, columns)


def _cleared(sizes: Array) -> Array:
    """Return sizes, those of them 0 that are the rounding of none."""
    return np.where(sizes < ROUNDED * sizes.max(initial=0.0), 0.0, sizes)


def best_forks(line: DriveLine, teeth: int | None = None) -> Phasing[DriveLine] | None:
    """Return where forks stand best; None for a line that has none to be put."""
    try:
        return line.phasing(teeth=teeth)
    except CardanError:
        if line.count > 1:
            raise
        return None


def phasing_text(phasing: Phasing[DriveLine] | None, wording: Wording) -> str:
    """Return in a sentence what other forks would give."""
    if phasing is None:
        return wording(
            "The line has one joint: there are no forks that could be put to each other."
        )
    now, best = (
        wording.with_unit(wording.fixed(angle, "angle"), "angle")
        for angle in (phasing.given_value, phasing.value)
    )
    if now == best or phasing.value > phasing.given_value:
        return wording("The forks stand as well as they can: the residual angle is {now}.", now=now)
    proof = wording("the global optimum" if phasing.proven else "the best that was found")
    return wording(
        "Other forks would lower the residual angle from {now} to {best}, {proof} ({method}).",
        now=now,
        best=best,
        proof=proof,
        method=wording.sentence(phasing.method),
    )


def phasing_listing(phasing: Phasing[DriveLine], wording: Wording) -> Listing:
    """Return a row per intermediate shaft: name, fork offset now and at the best."""
    offsets = phasing.given.fork_offsets, phasing.fork_offsets
    columns = _columns(wording, "fixed", "angle", ("fork offset", "best fork offset"), offsets)
    return _listing(wording, "Forks", {"shaft": phasing.line.shaft_names[1:-1]}, columns)


def built_listing(
    phasing: Phasing[DriveLine] | None, torque: float, wording: Wording
) -> Listing | None:
    """Return a row per way to put the forks that can be built: as given, best, and at 0° or 90°.

    Each with its residual angle, and the greatest force of the centre bearings, of all bearings
    where there are none, over a turn without inertia, weight and friction.

    Args:
        phasing: the best forks of a line, if it has any to be put.
        torque: of the input shaft [N·m].
        wording: language and units.

    Returns:
        None where no fork can be put, or too many can.
    """
    if phasing is None:
        return None
    line = phasing.given
    inner = list(enumerate(line.shafts[1:-1], 1))
    free = [k for k, shaft in inner if shaft.centring is None]
    if not 0 < len(free) < BESIDE - 2:
        return None
    straight = np.array([0.0 if k in free else shaft.fork_offset for k, shaft in inner])
    square = with_forks(line, straight).phasing(teeth=4, count=3)
    ways = [
        ("as given", line.fork_offsets),
        ("best", phasing.fork_offsets),
        ("at 0° or 90°", square.fork_offsets),
        *(("at 0° or 90°", item.fork_offsets) for item in square.alternatives),
    ]
    offsets = np.array([way for _, way in ways])
    phases = phases_of(offsets, line.geometry.plane_offsets)
    residual = residual_angles(line.uneven_angles, phases)[..., -1]
    force, title = np.full(len(ways), np.nan), "greatest bearing force"
    with contextlib.suppress(CardanError):
        held = [item.name for item in supports(line).bearings if 0 < item.shaft < line.count]
        loads = support_loads(line, held or None)
        force = abs(torque) * np.array([peak(loads, of_line) for of_line in phases])
        title = "greatest force of centre bearings" if held else title
    forks: list[_Column] = [
        (
            line.shaft_names[k] + wording.unit("angle"),
            [wording.fixed(float(angle), "angle") for angle in offsets[:, k - 1]],
        )
        for k in free
    ]
    return _listing(
        wording,
        "Ways to put the forks",
        {"forks": [wording(name) for name, _ in ways]},
        forks,
        _columns(wording, "fixed", "angle", ["residual angle"], [residual]),
        _columns(wording, "number", "force", [title], [force]),
    )


class Judged(NamedTuple):
    """A row of the verdict as the page shows it."""

    where: str
    quantity: str
    condition: str
    value: str
    by_rule: str
    limit: str
    margin: str
    status: str
    mark: str
    source: str
    source_language: str
    needed: tuple[str, ...]
    remarks: tuple[str, ...]


class Group(NamedTuple):
    """Rows of one rule on the page.

    Attributes:
        title: of the rule.
        shared: assumptions that fail for all of its rows.
        rows: rows that have a value, each with its own remarks.
        open: places and notes of all rows that are open, with a value or without.
        idle: likewise of those without a value that do not apply.
    """

    title: str
    shared: tuple[str, ...]
    rows: list[Judged]
    open: list[tuple[str, str]]
    idle: list[tuple[str, str]]


def judged(row: VerdictRow, wording: Wording, left_out: Sequence[str] = ()) -> Judged:
    """Return a row in the words of a page, without remarks that are said elsewhere."""
    dimension = BY_UNIT[row.unit]

    def shown(value: float | None) -> str:
        return "" if value is None else wording.quantity(value, dimension)

    limit = ""
    if row.limit is not None:
        bound = "≥" if row.limit.bound == "least" else "≤"
        limit = f"{bound} {wording.given_quantity(row.limit.value, dimension)}"
    source = wording.sentence(row.source) if row.limit or row.status == STATED else ""
    needed = _needed(row, wording)
    remarks = needed + [wording.sentence(row.note)] * bool(row.note)
    remarks += [f"! {wording.sentence(text)}" for text in row.broken if text not in left_out]
    return Judged(
        row.where or wording("whole line"),
        wording.sentence(row.quantity),
        wording.sentence(row.condition),
        shown(row.value),
        shown(row.rule_value),
        limit,
        reserve(row, wording),
        wording(row.status),
        row.status,
        source,
        wording.language if source != row.source else "en",
        tuple(needed),
        tuple(remarks),
    )


def _needed(row: VerdictRow, wording: Wording) -> list[str]:
    """Return what would meet the limit of a row."""
    return [
        f"{wording.sentence(item.what)} {wording.quantity(item.value, BY_UNIT[item.unit])}"
        for item in row.inverses
    ]


def headlines(verdict: Verdict, wording: Wording) -> list[Judged]:
    """Return the rows that fail, the worst first; places of which the same is told share one."""
    told = [judged(row, wording) for row in verdict.failed]
    alike = grouped((one.where, one._replace(where="", by_rule="", remarks=())) for one in told)
    return [one._replace(where=", ".join(places)) for one, places in alike.items()]


def reserve(row: VerdictRow, wording: Wording) -> str:
    """Return a margin in whole percents with its sign; from a limit of 0, the room itself.

    Open rows have none: more may act than their values are of.
    """
    margin = row.margin
    if margin is None or row.limit is None or row.status == OPEN:
        return ""
    sign = "+" if margin >= 0.0 else ""
    if not row.limit.value:
        # The margin is then not relative: it is the room in SI units.
        return sign + wording.quantity(margin, BY_UNIT[row.unit])
    return wording.with_unit(sign + wording.fixed(round(100.0 * margin), "whole"), "share")


def verdict_groups(verdict: Verdict, wording: Wording) -> list[Group]:
    """Return the rows of a verdict by rule; what all rows of a rule say is said once."""
    found = []
    for rule, members in groupby(verdict, key=lambda row: row.rule):
        rows = list(members)
        valued = [row for row in rows if row.value is not None]
        broken = valued[0].broken if len(valued) > 1 else ()
        shared = [text for text in broken if all(text in row.broken for row in valued)]
        # Places of which the same is told share a line.
        places: dict[str, list[tuple[str, str]]] = {OPEN: [], STATED: []}
        for (status, quantity, note), names in grouped(
            (row.where, (row.status, row.quantity, _asked(row, wording)))
            for row in rows
            if row.value is None or row.status == OPEN
        ).items():
            what = ", ".join([*filter(None, names), wording.sentence(quantity)])
            places[status].append((what, note))
        found.append(
            Group(
                wording(RULES[rule].title),
                tuple(wording.sentence(text) for text in shared),
                [judged(row, wording, shared) for row in valued],
                places[OPEN],
                places[STATED],
            )
        )
    return found


def _asked(row: VerdictRow, wording: Wording) -> str:
    """Return what an open row asks for, or why a row without a value does not apply."""
    told = [row.note] if row.value is not None else [*_needed(row, wording), row.note]
    if row.status == STATED:
        told = [text for text in row.note.split("; ") if not text.startswith("give ")]
    return "; ".join(map(wording.sentence, told))


def assumption_rows(verdict: Verdict, wording: Wording) -> list[tuple[str, list[str], str]]:
    """Return title, assumptions and source of each rule that the verdict goes by."""
    return [
        (
            wording(RULES[rule].title),
            [wording(text) for text in RULES[rule].assumptions],
            wording.sentence(RULES[rule].source),
        )
        for rule in dict.fromkeys(row.rule for row in verdict)
    ]
