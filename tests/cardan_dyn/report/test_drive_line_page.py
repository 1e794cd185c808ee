"""Drive-line page: what is on it, that it stands alone, that its numbers are the API's."""

from __future__ import annotations

import dataclasses
import html
import json
import math
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="the page has figures")
pytest.importorskip("meshcat", reason="the page has a scene")

from testkit.line_data import FAN, double_shaft, random_line

from cardan_dyn.drive_lines import DriveLine, ShaftJoint, TitleBlock
from cardan_dyn.practice.command_line import driveline_command
from cardan_dyn.practice.drive_lines.verdict.analysis import LineForces
from cardan_dyn.practice.drive_lines.wording import Wording
from cardan_dyn.practice.report import drive_line_page as page
from cardan_dyn.practice.report import line_tables

STYLES = [(language, units) for language in ("en", "de") for units in ("si", "imperial")]
# What one of these is in SI units and radians, from the definitions of NIST SP 811.
UNITS = {
    "": 1.0,
    "%": 0.01,
    "mm": 1e-3,
    "in": 0.0254,
    "°": math.pi / 180.0,
    "1/min": 2.0 * math.pi / 60.0,
    "rpm": 2.0 * math.pi / 60.0,
    "°/min": math.pi / 180.0 * 2.0 * math.pi / 60.0,
    "rad/s²": 1.0,
    "N·m": 1.0,
    "kN·m": 1e3,
    "lbf·ft": 1.3558179483314004,
    "N": 1.0,
    "kN": 1e3,
    "lbf": 4.4482216152605,
    "kg": 1.0,
    "lb": 0.45359237,
    "kg·m²": 1.0,
    "lb·ft²": 0.042140110093804806,
    "kg/m³": 1.0,
    "lb/in³": 27679.904710203125,
    "GPa": 1e9,
    "Mpsi": 6.894757293168361e9,
    "MPa": 1e6,
    "ksi": 6.894757293168361e6,
    "N/mm": 1e3,
    "lbf/in": 175.12683524647636,
    "N·m/rad": 1.0,
    "lbf·ft/rad": 1.3558179483314004,
    "h": 3600.0,
    "g·mm": 1e-6,
    "oz·in": 0.028349523125 * 0.0254,
}
NUMBER = re.compile(
    r"([≤≥+]? ?)(−?\d+(?:\u202f\d{3})*(?:[.,]\d+)?)(?:\u202f×\u202f10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?\xa0?(.*)"
)
RAISED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
FOUR = 5.01e-4
"""Relative error of a number of four significant digits."""


class Table(NamedTuple):
    """A table of a page: texts of its caption, header and rows."""

    caption: str
    header: list[str]
    rows: list[list[str]]


class Tables(HTMLParser):
    """Reads the tables of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: list[Table] = []
        self._cell: list[str] | None = None
        self._is_head = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        if tag == "table":
            self.found.append(Table("", [], []))
        elif tag in ("thead", "tbody"):
            self._is_head = tag == "thead"
        elif tag == "tr" and not self._is_head:
            self.found[-1].rows.append([])
        elif tag in ("td", "th", "caption"):
            self._cell = []

    def handle_data(self, data: str) -> None:
        if self._cell is not None:
            self._cell.append(data)

    def handle_endtag(self, tag: str) -> None:
        if tag not in ("td", "th", "caption"):
            return
        text = "".join(self._cell or [])
        self._cell = None
        if tag == "caption":
            self.found[-1] = self.found[-1]._replace(caption=text)
        elif self._is_head:
            self.found[-1].header.append(text)
        else:
            self.found[-1].rows[-1].append(text)


def read(text: str, unit: str | None = None) -> float:
    """A number of a page in SI units; its unit is read behind it unless given."""
    found = NUMBER.fullmatch(text)
    assert found is not None, text
    digits = found[2].replace("\u202f", "").replace(",", ".").replace("−", "-")
    power = int((found[3] or "0").translate(RAISED))
    return float(digits) * 10.0**power * UNITS[found[4] if unit is None else unit]


def column(table: Table, index: int) -> list[float]:
    """A column of numbers in SI units; NaN where there is none."""
    unit = re.search(r" \[(.*)\]$", table.header[index])
    return [
        math.nan if row[index] == "–" else read(row[index], unit[1] if unit else "")
        for row in table.rows
    ]


def reported(line: DriveLine, speed: float = 100.0, torque: float = 200.0) -> page.LineReport:
    line = line.replace(speed=speed, torque=torque)
    return page.LineReport(line, line.analyse(), line.verdict(), line_tables.best_forks(line))


@pytest.fixture(scope="module")
def report() -> page.LineReport:
    line = random_line(3, 2).replace(name="<line>", joints=[ShaftJoint(size="2040")] * 3)
    return reported(line)


@pytest.fixture(scope="module", params=["truck", "pto", "heavy", "one", "missed"])
def judged(request: pytest.FixtureRequest) -> page.LineReport:
    if request.param == "missed":
        worn = [ShaftJoint(largest_angle=0.01, rated_torque=50.0, torque_limit=90.0)] * 2
        line = double_shaft((0.0, 0.2, 0.05)).replace(application="vehicle", joints=worn)
        return reported(line, 900.0, 4321.5)
    if request.param == "heavy":
        return reported(random_line(5, 1, mass=True))
    if request.param == "one":
        return reported(random_line(1, 1))
    line = DriveLine.from_toml(request.param)
    analysis = line.analyse(speed=line.speed or 56.5, torque=line.torque or 796.0)
    return page.LineReport(line, analysis, line.verdict(), line_tables.best_forks(line))


def without_figures(patch: pytest.MonkeyPatch) -> None:
    """Leave figures out of pages, which take longer than all the rest."""
    patch.setattr(page.LineReport, "drawn", lambda *_: [("a", "a", None)])
    patch.setattr(page.page, "image", lambda _: "data:,")


@pytest.fixture
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    without_figures(monkeypatch)


def written(report: page.LineReport, path: Path, style: tuple[str, str] = ("en", "si")) -> str:
    target = path / "line.html"
    page.write(report, target, with_scene=False, language=style[0], units=style[1])
    return target.read_text("utf-8")


@pytest.fixture(scope="module")
def texts(
    judged: page.LineReport, tmp_path_factory: pytest.TempPathFactory
) -> dict[tuple[str, str], str]:
    """Return the page of a line in every style, without figures."""
    with pytest.MonkeyPatch.context() as patch:
        without_figures(patch)
        return {style: written(judged, tmp_path_factory.mktemp("page"), style) for style in STYLES}


@pytest.fixture(scope="module")
def one_case(judged: page.LineReport) -> LineForces:
    """Return the forces of one load case of a line, whose spline slips outwards."""
    return judged.line.analyse(
        speed=judged.analysis.speed,
        torque=judged.torque,
        gravity=[0.0, 0.0, -9.81],
        slipping="out",
    ).total


@pytest.mark.parametrize("style", STYLES)
def test_numbers_of_the_verdict(
    judged: page.LineReport, texts: dict[tuple[str, str], str], style: tuple[str, str]
) -> None:
    caption = Wording(*style)("Values, limits and reserves")
    text = texts[style]
    (table,) = [item for item in Tables(text).found if item.caption == caption]
    shown = [row for row in table.rows if len(row) == 7]
    rows = [row for row in judged.verdict if row.value is not None]
    assert len(shown) == len(rows)
    decimal = {"en": ",", "de": "."}[style[0]]
    for cells, row in zip(shown, rows, strict=True):
        where, _, value, by_rule, limit, reserve, status = cells
        assert row.where in where
        exact = (row.value, row.rule_value, row.limit.value if row.limit else None)
        for told, expected in zip((value, by_rule, limit), exact, strict=True):
            assert (told == "") == (expected is None)
            if expected is not None:
                # Below that, a number is the rounding of zero.
                assert read(told) == pytest.approx(expected, rel=FOUR, abs=2e-9)
                assert decimal not in told and " " not in told.lstrip("≤≥ ")
        if row.limit is not None:
            assert limit[0] == {"least": "≥"}.get(row.limit.bound, "≤")
        if row.status == "open":
            assert reserve == ""
        elif row.margin is not None and row.limit and row.limit.value:
            assert read(reserve) == pytest.approx(row.margin, abs=0.00501)
        elif row.margin is not None:
            assert read(reserve) == pytest.approx(row.margin, rel=FOUR)
        assert status == Wording(style[0])(row.status)
    for row in judged.verdict.failed:
        assert Wording(*style).sentence(row.quantity) in html.unescape(text)


@pytest.mark.parametrize("style", STYLES)
def test_numbers_of_the_geometry_and_the_analysis(
    judged: page.LineReport,
    one_case: LineForces,
    texts: dict[tuple[str, str], str],
    style: tuple[str, str],
) -> None:
    words = Wording(*style)
    tables = {item.caption: item for item in Tables(texts[style]).found}
    line, found, analysis = judged.line, judged.line.geometry, judged.analysis
    place = {"si": 5.01e-5, "imperial": 0.000501 * 0.0254}[style[1]]
    degree = math.radians(0.000501)

    def agrees(name: str, index: int, expected: Any, error: float = 0.0) -> None:
        told = np.array(column(tables[words(name)], index))
        bound = {"abs": error} if error else {"rel": FOUR, "abs": 2e-9}
        assert told == pytest.approx(np.asarray(expected), nan_ok=True, **bound)

    agrees("Shafts: geometry", 1, found.lengths, place)
    sides = np.arctan2(found.directions[:, 1:].T, found.directions[:, 0])
    agrees("Shafts: geometry", 2, sides[1], degree)
    agrees("Shafts: geometry", 3, sides[0], degree)
    agrees("Shafts: geometry", 4, [math.nan, *line.fork_offsets, math.nan], degree)
    agrees("Joints: angles", 3, found.joint_angles, degree)
    agrees("Joints: angles", 4, found.plane_offsets, degree)
    phases = column(tables[words("Joints: angles")], 5)
    # A fork is the same after half a turn.
    assert np.sin(np.subtract(phases, found.fork_phases)) == pytest.approx(0.0, abs=degree)
    for axis in range(3):
        agrees("Joints: places of their centres", 1 + axis, found.centres[:, axis], place)
    forces = analysis.total
    agrees("Motion over a turn", 1, np.abs(analysis.angle_error).max(axis=0)[1:])
    agrees("Motion over a turn", 2, analysis.ratio.min(axis=0)[1:] - 1.0)
    agrees("Motion over a turn", 3, analysis.ratio.max(axis=0)[1:] - 1.0)
    agrees("Greatest moments over a turn", 1, np.abs(forces.torsion_in).max(axis=0))
    agrees("Greatest moments over a turn", 4, forces.bending_out.max(axis=0))
    agrees("Bearing forces over a turn", 1, forces.bearing_radial.max(axis=0))
    force = 1e-9 * float(forces.bearing_radial.max())
    along = np.array(column(tables[words("Bearing forces over a turn")], 3))
    expected = np.abs(forces.bearing_axial).max(axis=0)
    assert along == pytest.approx(expected, rel=FOUR, abs=force)
    # Those of all load cases are the verdict's, and no smaller than at one of them.
    one = one_case
    for index, kind, least in (
        (4, "across", one.bearing_radial.max(axis=0)),
        (5, "along", np.abs(one.bearing_axial).max(axis=0)),
    ):
        worst = {
            row.where: row.value for row in judged.verdict if f"force {kind} the" in row.quantity
        }
        told = [worst.get(name, math.nan) for name in analysis.bearings]
        agrees("Bearing forces over a turn", index, told)
        assert kind == "along" or not np.isnan(told).any()
        assert not np.any(told < least * (1.0 - FOUR) - force)


FIELDS = {
    "Tubes": ("tube", ["outer_diameter", "wall", "density", "modulus", "shear_modulus"]),
    "Splines": ("spline", ["distance", "friction", "radius", "travel", "compressed", "longest"]),
    "Duty cycle": ("", ["share", "speed", "torque"]),
    "Joints: data": ("", ["cross_mass", "cross_span", "rated_torque", "largest_angle"]),
}


@pytest.mark.parametrize("style", STYLES)
def test_all_data_of_the_line_are_on_the_page(
    judged: page.LineReport, texts: dict[tuple[str, str], str], style: tuple[str, str]
) -> None:
    words, line = Wording(*style), judged.line
    text = texts[style]
    tables = Tables(text).found
    compared = 0
    for caption, (part, names) in FIELDS.items():
        parts: list[Any] = {
            "Duty cycle": list(line.duty_cycle),
            "Joints: data": list(line.joints),
        }.get(
            caption,
            [getattr(shaft, part) for shaft in line.shafts if part and getattr(shaft, part)],
        )
        for name in names:
            values = [getattr(item, name) for item in parts]
            label = words(name.replace("_", " "))
            columns = [
                (item, index)
                for item in tables
                if item.caption == words(caption)
                for index, title in enumerate(item.header)
                if title.partition(" [")[0] == label
            ]
            if all(value in (None, 0.0) for value in values):
                assert not columns
                continue
            ((table, index),) = columns
            expected = np.array([math.nan if value is None else value for value in values])
            # What is given has six digits at least.
            assert np.array(column(table, index)) == pytest.approx(
                expected, rel=5.01e-6, nan_ok=True
            )
            compared += 1
    assert compared >= (4 if line.name in ("truck", "pto") else 0)
    (bearings,) = [item for item in tables if item.caption == words("Bearings")]
    assert column(bearings, 2) == pytest.approx([item.distance for item in line.bearings], rel=1e-5)
    # The file of the line is on the page, and open.
    assert "<details" not in text
    (file,) = re.findall(r'<pre class="file">(.*?)</pre>', text, re.S)
    assert DriveLine.from_toml(html.unescape(file)) == line


def test_no_english_sentence_is_left_on_a_german_page(texts: dict[tuple[str, str], str]) -> None:
    text = re.sub(
        r'<span class="source" lang="en">.*?</span>|<pre.*?</pre>|<style.*?</style>',
        "",
        texts["de", "si"],
        flags=re.S,
    )
    rules = text.index("Regeln der Beurteilung")
    shown = html.unescape(re.sub(r"<[^>]*>", " ", text[:rules]))
    assert not re.findall(r".*\b(?:the|give|of|not|is|and|with|on|at|its|this)\b.*", shown)


@pytest.mark.slow
def test_page_stands_alone_and_is_reproducible(
    report: page.LineReport, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    line = report.line.replace(report=TitleBlock(project="A & B", date="2026-01-31"))
    told = dataclasses.replace(report, line=line)
    text = written(told, tmp_path / "new")
    assert "&lt;line&gt;" in text and "<line>" not in text and "A &amp; B" in text
    assert "2026-01-31" in text and 'lang="en"' in text
    assert not re.search(r'(src|href)="(?!data:)', text)
    assert text.count("data:image/svg+xml;base64,") == 4
    for row in report.verdict:
        assert row.quantity in html.unescape(text)
    assert "Turning scene" not in text
    assert f"{report.analysis.loop_residual:.0e}" in text
    again = reported(report.line)
    assert written(dataclasses.replace(again, line=line), tmp_path) == text
    request.getfixturevalue("plain")
    german = written(told, tmp_path, ("de", "si"))
    assert "31.01.2026" in german and '<html lang="de">' in german


def test_a_page_without_a_date_has_that_of_the_build(
    report: page.LineReport, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1000000000")
    assert ("Date", "2001-09-09") in page.title_rows(TitleBlock(), Wording())


@pytest.mark.usefixtures("plain")
def test_scene_is_part_of_the_page(report: page.LineReport, tmp_path: Path) -> None:
    text = page.write(report, tmp_path / "line.html").read_text("utf-8")
    assert "Turning scene" in text and "support_C1" in text and len(text) > 1_000_000


@pytest.mark.usefixtures("plain")
@pytest.mark.parametrize(("units", "told"), [("si", {}), ("imperial", {"N·m": "lbf·ft"})])
def test_scene_tells_quantities_as_the_page_does(
    units: str, told: dict[str, str], report: page.LineReport
) -> None:
    shown = page.scene(report, Wording(units=units))
    data = json.loads(re.search(r'id="data"[^>]*>(.*?)</script>', shown.html, re.DOTALL)[1])
    others = data["told"]["units"]
    assert bool(others) == bool(told)
    for unit, other in told.items():
        assert others[unit][0] == other
    for unit, (other, factor) in others.items():
        # What is in SI units is so many times as much in others.
        if unit in ("m", "N", "N·m", "rad/s"):
            assert factor * UNITS[other] == pytest.approx(1.0, rel=1e-12)


@pytest.mark.slow
def test_figures_are_saved(tmp_path: Path) -> None:
    plain = reported(double_shaft((0.0, 0.1, 0.0)))
    paths = page.save_figures(plain, tmp_path / "figures", Wording())
    names = ("arrangement", "motion", "forces", "orders")
    assert [path.name for path in paths] == [
        f"drive_line_{name}.{kind}" for name in names for kind in ("svg", "png")
    ]
    assert all(path.stat().st_size > 8_000 for path in paths)


def test_forks_in_words(report: page.LineReport) -> None:
    words = Wording()
    assert "global optimum" in line_tables.phasing_text(report.phasing, words)
    assert report.phasing is not None
    assert len(line_tables.phasing_listing(report.phasing, words).rows) == 2
    best = reported(double_shaft((0.0, 0.1, 0.0)))
    assert "as well as they can" in line_tables.phasing_text(best.phasing, words)
    single = random_line(1, 1)
    assert line_tables.best_forks(single) is None
    assert "one joint" in line_tables.phasing_text(None, words)


def test_what_all_rows_of_a_rule_say_is_said_once(report: page.LineReport) -> None:
    words = Wording()
    groups = line_tables.verdict_groups(report.verdict, words)
    valued = sum(len(group.rows) for group in groups)
    assert valued == sum(row.value is not None for row in report.verdict)
    idle = sum(len(group.idle) for group in groups)
    assert idle == sum(row.value is None and row.status == "stated" for row in report.verdict)
    told = {text for group in groups for text in group.shared}
    assert told
    for group in groups:
        for row in group.rows:
            assert not {f"! {text}" for text in group.shared} & set(row.remarks)


def test_every_open_row_is_listed_with_what_to_give(
    judged: page.LineReport, texts: dict[tuple[str, str], str]
) -> None:
    text = html.unescape(texts["en", "si"])
    _, _, after = text.partition("<h3>What is open")
    listed = after[: after.find("<h3>")] if after else ""
    items = re.findall(r"<li>(.*?)</li>", listed)
    told = {(row.rule, row.quantity, row.note, row.inverses) for row in judged.verdict.open}
    # Places of which the same is asked share a line.
    assert bool(told) <= len(items) <= len(told)
    for row in judged.verdict.open:
        (item,) = (
            item
            for item in items
            if f", {row.quantity}: " in item
            and row.where in [*item.partition(f", {row.quantity}: ")[0].split(", ")[1:], ""]
        )
        # Without what the value stands for.
        assert not re.search("open: ", item.replace("leaves it open: ", ""))
        _, _, reason = row.note.partition("open: ")
        assert Wording().sentence(reason) in item


def test_open_rows_have_no_reserve() -> None:
    silent = FAN.replace("friction = 0.1, radius_mm = 25, ", "")
    rows = [row for row in DriveLine.from_toml(silent).verdict() if row.limit]
    opened = [row for row in rows if row.status == "open"]
    assert any(row.margin is not None and row.margin > 0.0 for row in opened)
    assert len(opened) < len(rows)
    for row in rows:
        assert (line_tables.reserve(row, Wording()) == "") == (row.status == "open")


def test_says_of_what_the_forces_over_a_turn_are(
    judged: page.LineReport, texts: dict[tuple[str, str], str]
) -> None:
    text = html.unescape(texts["en", "si"])
    section = text[text.index("<h2>Motion and forces") : text.index('<h2 class="sheet">')]
    words = Wording()
    at = words.quantity(judged.analysis.speed, "speed"), words.quantity(judged.torque, "torque")
    assert f"operating point of the analysis alone, {at[0]} and {at[1]}, without weight" in section
    assert "splines do not slide" in section and "service factor" in section


def test_figures_of_forces_say_what_they_leave_out(report: page.LineReport) -> None:
    captions = {name: caption for name, caption, _ in report.drawn(Wording())}
    for name in ("forces", "orders"):
        assert "Splines do not slide; without service factor and weight." in captions[name]


@pytest.mark.slow
@pytest.mark.usefixtures("plain")
def test_the_headline_is_green_only_where_everything_was_judged(tmp_path: Path) -> None:
    def headline(found: page.LineReport) -> str:
        text = written(found, tmp_path)
        (kind,) = re.findall(r'<p class="statement"><strong class="(\w+)">', text)
        return kind

    line = double_shaft((0.1, 0.0, 0.1))
    found = reported(line)
    rows = found.verdict.rows
    assert found.verdict.open and not found.verdict.failed
    assert headline(found) == "open"
    said = f"passed, {len(found.verdict.open)} rows open"
    assert said in written(found, tmp_path)
    german = written(found, tmp_path, ("de", "si"))
    assert f"bestanden, {len(found.verdict.open)} Zeilen offen" in german
    assert driveline_command.plain(found)["outcome"] == found.verdict.summary
    judged = tuple(row for row in rows if row.status != "open")
    complete = dataclasses.replace(found.verdict, rows=judged)
    assert headline(dataclasses.replace(found, verdict=complete)) == "pass"
    failing = reported(double_shaft((0.1, 0.0, 0.3)))
    assert not failing.verdict.passed
    assert headline(failing) == "fail"


def test_no_heading_stands_above_an_empty_list(texts: dict[tuple[str, str], str]) -> None:
    for text in texts.values():
        assert re.search(r"<ul[^>]*>\s*</ul>", text) is None
