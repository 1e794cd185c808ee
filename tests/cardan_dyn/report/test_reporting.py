"""Reports on mechanisms: the cases that are chosen, numbers, texts and pages."""

from __future__ import annotations

import base64
import csv
import hashlib
import io
import re
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from testkit.simulated import parallelograms

import cardan_dyn as cd
from cardan_dyn.kit.quantities import amount
from cardan_dyn.practice.report.case import case_of
from cardan_dyn.practice.report.grids import Grid, place
from cardan_dyn.practice.report.reporting import Report
from cardan_dyn.practice.viewer.bodies import Bodies

pytestmark = pytest.mark.usefixtures("loaded_once")

SLOW = pytest.mark.slow  # Six drives: extremes over all ranges, and a page that takes as long.
ROOF = """<robot name="roof"><link name="ground"/>
<link name="left"><inertial><origin xyz="0.5 0 0.5"/><mass value="2"/>
<inertia ixx="0.1" iyy="0.2" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="right"><inertial><origin xyz="-0.5 0 0.5"/><mass value="2"/>
<inertia ixx="0.1" iyy="0.2" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="foot_left" type="continuous"><parent link="ground"/><child link="left"/>
<origin xyz="0 0 0"/><axis xyz="0 1 0"/></joint>
<joint name="foot_right" type="continuous"><parent link="ground"/><child link="right"/>
<origin xyz="2 0 0"/><axis xyz="0 1 0"/></joint>
<loop name="ridge" type="continuous"><predecessor link="left"><origin xyz="1 0 1"/></predecessor>
<successor link="right"><origin xyz="-1 0 1"/></successor><axis xyz="0 1 0"/></loop></robot>"""
PENDULUM = """<robot name="a&lt;b"><link name="ground"/><link name="rod"><inertial>
<origin xyz="0 0 -0.5"/><mass value="2"/>
<inertia ixx="0.2" iyy="0.2" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="pivot" type="revolute"><parent link="ground"/><child link="rod"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="2" effort="1" velocity="1"/><dynamics damping="0.1" friction="0.5"/>
</joint></robot>"""
TABLE = """<robot name="table"><link name="ground"/>
<link name="left"/><link name="right"/><link name="hanger"/>
<link name="top"><inertial><origin xyz="0.5 0 0"/><mass value="100"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="a" type="prismatic"><parent link="ground"/><child link="left"/><axis xyz="0 0 1"/>
<limit lower="0" upper="2" effort="0" velocity="0"/></joint>
<joint name="b" type="prismatic"><parent link="ground"/><child link="right"/>
<origin xyz="1.03 0 0.1"/><axis xyz="0 0 1"/><limit lower="0" upper="2" effort="0" velocity="0"/>
</joint>
<joint name="hinge" type="continuous"><parent link="left"/><child link="top"/><axis xyz="0 1 0"/>
</joint>
<joint name="swing" type="continuous"><parent link="right"/><child link="hanger"/>
<axis xyz="0 1 0"/></joint>
<loop name="pin" type="continuous"><predecessor link="top"><origin xyz="1 0 0"/></predecessor>
<successor link="hanger"><origin xyz="-0.03 0 -0.1"/></successor><axis xyz="0 1 0"/></loop>
</robot>"""
"""A table of 100 kg on two lifting columns; a hanger lets them differ by a part of the stroke."""


BROKEN = """() => {
    const broken = [], range = document.createRange();
    for (const cell of document.querySelectorAll("td, th, dd, p, li, caption")) {
        const texts = document.createTreeWalker(cell, NodeFilter.SHOW_TEXT);
        for (let node; (node = texts.nextNode()); )
            for (const word of node.data.matchAll(/[\\p{L}\\p{N}.°]+/gu)) {
                range.setStart(node, word.index);
                range.setEnd(node, word.index + word[0].length);
                const tops = [...range.getClientRects()].map(box => Math.round(box.top));
                if (new Set(tops).size > 1) broken.push(word[0]);
            }
    }
    return broken;
}"""
"""Words, between separators, that lie on two lines."""


def by_name(report: Report) -> dict[tuple[str, str], Any]:
    return {(item.owner, item.quantity): item for item in report.extremes}


def test_structure_at_rest() -> None:
    """Two rods of 2 kg that lean on each other: 2 mg at each foot's side, mg/2 across the ridge."""
    mechanism = cd.load(ROOF)
    found = by_name(Report(case_of(mechanism, gravity=(0.0, 0.0, -9.81)), date="2020-01-01"))
    weight = 2.0 * 9.81
    assert found["ridge", "shear"].greatest == pytest.approx(weight / 2.0, rel=1e-12)
    assert found["foot_left", "shear"].least == pytest.approx(weight * np.hypot(1.0, 0.5))
    assert found["foot_left", "shear"].determined
    assert not found["foot_left", "axial"].determined
    assert {name for name, _ in found} == {"foot_left", "foot_right", "ridge"}


def test_nothing_acts() -> None:
    report = Report(cd.load(ROOF))
    assert not report.acts and "Nothing acts" in str(report) and report.no_orders == "nothing moves"
    assert np.isnan(report.judgement[1][1]) and "nothing to compare" in report.judgement[1][2]


def test_a_single_sample_is_one() -> None:
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", gravity=(0.0, -9.81, 0.0))
    report = Report(scene.sweep([0.3]))
    assert "Extremes of the 1 sample.\n" in str(report) and "1 sample>" in repr(report)


def test_range_is_shortened_at_dead_points() -> None:
    mechanism = cd.load("four_bar")
    case = case_of(
        mechanism,
        drive=("rocker_bearing",),
        interval=(-4.0, 4.0),
        loads={"crank_bearing": 3.0},
        samples=50,
    )
    assert case.sweep is not None and len(case.sweep) == 50
    low, high = cd.Scene(mechanism, drive="rocker_bearing").motion_range()
    assert low < case.sweep.position[0] < low + 0.06 * (high - low)
    assert high - 0.06 * (high - low) < case.sweep.position[-1] < high
    assert "shortened" in case.said[-1] and place(low, False) in case.said[-1]


def test_what_was_asked_is_computed() -> None:
    case = case_of(
        cd.load("four_bar"), interval=(0.1, 0.4), speed=12.0, gravity=(0.0, 0.0, -9.81), samples=7
    )
    assert case.sweep is not None
    assert np.allclose(case.sweep.position, np.linspace(0.1, 0.4, 7))
    assert np.all(case.sweep.speed == 12.0) and case.sweep.gravity[2] == -9.81
    with pytest.raises(cd.ArgumentError, match="empty"):
        case_of(cd.load("four_bar"), interval=(0.4, 0.1))
    with pytest.raises(cd.ArgumentError, match="single drive"):
        case_of(cd.load("stewart_platform"), interval=(0.0, 0.1))
    with pytest.raises(cd.ArgumentError, match="a speed are those of a single drive"):
        case_of(cd.load("stewart_platform"), speed=1.0)
    with pytest.raises(cd.ModelError, match="crank"):
        case_of(cd.load("four_bar"), drive=("crank",))


def test_few_samples_reach_both_ends_of_a_swing() -> None:
    """Six samples of a sine miss its ends by a twentieth."""
    ends = [
        np.ravel(sweep.position)[[0, -1]]
        for sweep in (
            case_of(cd.load("four_bar"), drive=("rocker_bearing",), samples=count).sweep
            for count in (6, 721)
        )
        if sweep is not None
    ]
    np.testing.assert_allclose(ends[0], ends[1], rtol=1e-12)


def test_limits_of_trees_and_elements() -> None:
    """Damping acts at a speed, and only where it is asked for."""
    mechanism = cd.load(PENDULUM)
    free = case_of(mechanism, interval=(-1.0, 2.0), speed=3.0)
    damped = case_of(mechanism, interval=(-1.0, 2.0), speed=3.0, elements=True)
    assert free.sweep is not None and damped.sweep is not None
    difference = damped.sweep.drive_effort - free.sweep.drive_effort
    assert np.allclose(difference, 0.1 * 3.0 + 0.5)
    usual = case_of(mechanism).sweep
    assert usual is not None and np.allclose(usual.position[[0, -1]], [-1.0, 2.0])
    report = Report(damped.sweep)
    assert "orders need whole turns" in report.no_orders
    assert any("damping" in item for item in report.mechanism.warnings)


def test_orders_of_a_universal_joint() -> None:
    """The output's torsion is constant; the input's has even orders alone, of mean M₂ (Fourier)."""
    report = Report(cd.load("universal_joint"))
    orders = report.orders["bearing_in", "torsion", "N·m"]
    # 1/ratio(φ) = (1 − sin²β cos²φ)/cos β, inverted: its mean is 1.
    assert orders[0] == pytest.approx(100.0, rel=1e-12)
    step = np.tan(np.radians(35.0) / 2.0) ** 2
    assert orders[2:9:2] == pytest.approx([200.0 * step**k for k in (1, 2, 3, 4)], rel=1e-10)
    assert not orders[1::2].any()


@pytest.mark.slow
@pytest.mark.parametrize("samples", [3, 20])
def test_orders_of_few_samples_are_those_of_the_turn(samples: int) -> None:
    """At 80° each even order still has 70 % of the one before: what is left out folds down."""
    scene = cd.Scene(
        cd.load("universal_joint"),
        drive="bearing_in",
        held={"joint_angle": np.radians(80.0)},
        loads={"bearing_out": -100.0},
    )
    report = Report(scene.sweep(np.linspace(0.0, 2.0 * np.pi, samples)))
    orders = report.orders["bearing_in", "torsion", "N·m"]
    step = np.tan(np.radians(40.0)) ** 2
    assert orders[2:9:2] == pytest.approx([200.0 * step**k for k in (1, 2, 3, 4)], rel=1e-8)
    assert report.orders_error < 1e-8


def test_table_and_text(tmp_path: Path) -> None:
    report = Report(cd.load("four_bar"))
    frame = report.to_dataframe()
    assert list(frame.columns[:6]) == [
        *("owner", "quantity", "unit"),
        *("greatest", "least", "determined"),
    ]
    assert (frame.error <= 1e-6 * frame.greatest.abs().max()).all()
    item = by_name(report)["crank_bearing", "torsion"]
    row = frame[(frame.owner == "crank_bearing") & (frame.quantity == "torsion")].iloc[0]
    assert row.greatest == item.greatest
    assert row.greatest_at_crank_bearing == item.greatest_at[0, 0]
    assert report.save(tmp_path / "all.csv").read_text("utf-8").count("\n") == len(frame) + 1
    text = str(report)
    assert "\nnot determined by statics, chosen by least norm" in text and " *" not in text
    assert "; all that is tabled is determined\n" in text
    assert "114.2°" in text and "to rounding" in text


@pytest.mark.slow
@pytest.mark.usefixtures("without_pictures")
def test_page_begins_with_what_statics_determines(tmp_path: Path) -> None:
    """No force in a flat linkage is determined as a whole; the shear of its pins is."""
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", loads={"rocker_bearing": -10.0})
    sweep = scene.sweep(np.linspace(0.0, 2.0 * np.pi, 361))
    most = {name: sweep[name].shear.max() for name in sweep.outputs}
    page = Report(sweep).save(tmp_path / "bar.html", scene=False).read_text("utf-8")
    headline = page[page.index("What joints are sized by") :]
    row = r'<th scope="row">shear</th>.*?>N<.*?>([\d.]+)<.*?>([\w<>]+)</td>'
    told = re.search(row, headline)
    assert told is not None
    assert float(told[1]) == pytest.approx(max(most.values()), rel=1e-3)
    assert most[told[2].replace("<wbr>", "")] == pytest.approx(max(most.values()), rel=1e-12)
    assert '<th scope="row">force</th>' not in headline and "force *" not in page


def test_refuses_other_things() -> None:
    with pytest.raises(cd.ArgumentError, match="on a sweep, or on a mechanism"):
        Report("four_bar")  # type: ignore[arg-type]
    scene = cd.Scene(cd.load("universal_joint"), drive="bearing_in", held={"joint_angle": 0.3})
    grid = scene.sweep([0.0, 1.0], held={"joint_angle": [[0.1], [0.2]]})
    with pytest.raises(cd.ArgumentError, match="one dimension"):
        Report(grid)


def test_fingerprint_is_that_of_the_file() -> None:
    path = Path(__file__).parents[3] / "urdf" / "four_bar.urdf"
    mechanism = cd.load(path)
    source = mechanism.description.source
    assert source is not None
    assert Report(mechanism).sha256 == hashlib.sha256(source.text.encode("utf-8")).hexdigest()
    assert Report(mechanism).sha256 != Report(cd.load(ROOF)).sha256


def test_bearings_are_between_what_stands_and_what_moves() -> None:
    report = Report(cd.load("universal_joint"))
    assert report.sweep is not None
    bodies = Bodies(report.sweep, np.arange(len(report.sweep)), visuals=False)
    assert bodies.on_ground() == {"bearing_in", "bearing_out"}


def test_grid_keeps_all_digits() -> None:
    grid = Grid("a", "b", ("x", "y [m]"), [("one, two", 1.0 / 3.0)])
    assert grid.shown == [["one, two", "0.333333"]] and grid.numeric == [False, True]
    data = grid.url.partition("base64,")[2]
    rows = list(csv.reader(io.StringIO(base64.b64decode(data).decode("utf-8"))))
    assert rows[0] == ["x", "y [m]"] and float(rows[1][1]) == 1.0 / 3.0


@cache
def lifted() -> Report:
    mechanism = cd.load(TABLE)
    return Report(case_of(mechanism, drive=("a", "b"), gravity=(0, 0, -9.81)))


def four_bars() -> Report:
    head = {"project": "Press <7>", "author": "A. B.", "date": "2026-01-02", "revision": "C"}
    return Report(cd.load("four_bar"), title="Four bars", **head)


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Return what writes the page of a mechanism, once: figures and ranges take their time."""
    pytest.importorskip("matplotlib", reason="the page has figures")
    pytest.importorskip("jinja2", reason="the page is a template")

    @cache
    def page(name: str) -> Path:
        made = {"four_bar": four_bars, "table": lifted}.get(name)
        report = made() if made else Report(cd.load(name))
        return report.save(tmp_path_factory.mktemp(name) / "new" / "page.html", scene=False)

    return page


class TestPage:
    @pytest.fixture(autouse=True)
    def _drawn(self) -> None:
        pytest.importorskip("matplotlib", reason="the page has figures")
        pytest.importorskip("jinja2", reason="the page is a template")

    def page(self, report: Report, tmp_path: Path, scene: bool = False) -> str:
        return report.save(tmp_path / "page.html", scene=scene).read_text("utf-8")

    @pytest.mark.slow
    def test_stands_alone_and_is_reproducible(
        self, pages: Callable[[str], Path], tmp_path: Path
    ) -> None:
        report = four_bars()
        text = pages("four_bar").read_text("utf-8")
        assert "Press &lt;7&gt;" in text and "2026-01-02" in text and "<h1>Four bars</h1>" in text
        assert not re.search(r'(src|href)="(?!data:)', text)
        assert report.sha256 in text and cd.__version__ in text
        assert "Moving scene" not in text
        assert text == self.page(report, tmp_path)
        for link in ("links", "joints", "loops", "extremes", "efforts", "orders", "drives"):
            assert f'download="four_bar_{link}.csv"' in text

    @pytest.mark.slow
    @pytest.mark.usefixtures("without_pictures")
    def test_scene_has_a_name(self, tmp_path: Path) -> None:
        pytest.importorskip("meshcat", reason="the page has a scene")
        text = self.page(Report(cd.load("four_bar")), tmp_path, scene=True)
        assert '<iframe title="Moving scene"' in text

    @pytest.mark.usefixtures("without_pictures")
    @pytest.mark.parametrize("description", [ROOF, PENDULUM])
    def test_whatever_is_described_has_a_page(self, description: str, tmp_path: Path) -> None:
        mechanism = cd.load(description)
        for gravity in (None, (0.0, 0.0, -9.81)):
            report = Report(case_of(mechanism, gravity=gravity, samples=31))
            text = self.page(report, tmp_path)
            assert ("Nothing acts" in text) == (gravity is None)
            assert "There are none" in text
            determined = "All wrenches follow from the laws of motion alone." in text
            assert determined == (description is PENDULUM)

    @pytest.mark.usefixtures("without_pictures")
    def test_what_is_left_out_is_said(self, tmp_path: Path) -> None:
        text = self.page(Report(cd.load(PENDULUM)), tmp_path)
        assert "damping or friction of 1 joint (pivot): " in text
        assert "other scenes are without it" in text
        assert "a&lt;b" in text and "<b>" not in text

    @pytest.mark.usefixtures("without_pictures")
    def test_rotors_are_described(self, tmp_path: Path) -> None:
        """They are part of all efforts, whatever the case lists."""
        assert "armature" not in self.page(Report(cd.load(PENDULUM)), tmp_path)
        driven = cd.load(PENDULUM.replace("<dynamics", '<dynamics armature="0.0375"'))
        text = self.page(Report(driven), tmp_path)
        assert "armature [kg·m² or kg]" in text and "0.0375" in text

    def test_what_was_chosen_is_told(self, pages: Callable[[str], Path]) -> None:
        text = pages("four_bar").read_text("utf-8")
        # What is open carries nothing where loads lie in the plane: it is told, without a star.
        assert '<p class="open">Not determined by statics, chosen by least norm: ' in text
        assert "and 1 more; all that is tabled here is determined." in text
        assert "; all that is tabled is determined." in text

    @pytest.mark.slow
    @pytest.mark.parametrize("name", [pytest.param("stewart_platform", marks=SLOW), "table"])
    def test_places_of_several_drives_are_a_table(
        self, pages: Callable[[str], Path], name: str
    ) -> None:
        text = pages(name).read_text("utf-8")
        determined = "All wrenches follow from the laws of motion alone." in text
        assert determined == (name == "stewart_platform")
        assert '<th scope="col">place</th>' in text or ">place<" in text
        assert "Positions of the drives at these places" in text
        assert "There are doubts" in text and "of a grid over all ranges" in text


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    from testkit.browser import running_browser

    with running_browser() as found:
        yield found


@pytest.mark.parametrize(
    "name",
    [
        "four_bar",
        pytest.param("table", marks=pytest.mark.slow),
        pytest.param("stewart_platform", marks=SLOW),
    ],
)
def test_in_a_browser(browser: Any, pages: Callable[[str], Path], name: str) -> None:
    """No sideways scrolling at any width, nothing serious that axe finds, no network."""
    from testkit.accessibility import grave

    path = pages(name)
    for width, scheme in ((1280, "light"), (390, "dark")):
        view = browser.new_page(viewport={"width": width, "height": 900}, color_scheme=scheme)
        asked: list[str] = []
        view.on("request", lambda request, asked=asked: asked.append(request.url))
        view.goto(path.as_uri())
        assert view.evaluate("document.documentElement.scrollWidth") <= width
        for medium in ("screen", "print"):
            view.emulate_media(media=medium, color_scheme=scheme)
            # A digest of 64 letters is no word.
            assert [word for word in view.evaluate(BROKEN) if len(word) < 30] == []
        assert not grave(view)
        assert not [address for address in asked if address.startswith("http")]
        view.close()


@pytest.mark.slow
def test_few_digits_are_said(monkeypatch: pytest.MonkeyPatch) -> None:
    """The condition where wrenches are great counts, not where they vanish."""
    report = Report(cd.load("thoma_rig"))
    assert report.sweep is not None and report.sweep.condition.max() > 1e15
    assert report.digits >= 10 and not report.doubts
    sweep = Report(cd.load("four_bar")).sweep
    assert sweep is not None and Report(sweep).digits >= 14
    of = property(lambda item: np.full(len(item), 1e12))
    monkeypatch.setattr(cd.Sweep, "condition", of, raising=False)
    worse = Report(sweep)
    assert worse.digits in (3, 4) and "loops nearly depend" in str(worse)
    assert "close to a singular configuration" in repr(worse)


def test_what_comes_close_to_a_dead_point_is_said() -> None:
    """A torque of 10 N·m at the crank, held by the rocker 1e-8 rad before its dead point."""
    scene = cd.Scene(cd.load("four_bar"), drive="rocker_bearing", loads={"crank_bearing": -10.0})
    low, high = scene.motion_range()
    for end, is_near in ((low + 1e-8, True), (low + 0.1, False)):
        sweep = scene.sweep(np.linspace(end, high - 0.1, 5))
        assert ("close to a singular" in repr(sweep)) == is_near
        assert ("close to a singular" in repr(sweep["crank_pin"])) == is_near
        assert bool(Report(sweep).doubts) == is_near
        # What is along the pin is open and none, what is across it is told.
        greatest = amount(sweep["crank_pin"].shear.max(), "N")
        assert f"force up to {greatest}, " in repr(sweep["crank_pin"])
        if is_near:
            reached = np.linalg.norm(sweep["crank_pin"].force, axis=-1).max()
            assert f"forces reach {reached:.3g} N" in repr(sweep)


GEARS = """<robot name="gears"><link name="box"/><link name="pinion"/><link name="wheel"/>
<joint name="shaft_in" type="continuous"><parent link="box"/><child link="pinion"/>
<axis xyz="0 0 1"/></joint>
<joint name="shaft_out" type="continuous"><parent link="box"/><child link="wheel"/>
<origin xyz="0.14 0 0"/><axis xyz="0 0 1"/></joint>
<coupling name="mesh"><predecessor link="pinion"/><successor link="wheel"/><ratio value="-0.4"/>
</coupling></robot>"""


@pytest.mark.usefixtures("without_pictures")
def test_efforts_alone_have_a_page(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    pytest.importorskip("jinja2")
    mechanism = cd.load(GEARS)
    report = Report(case_of(mechanism, loads={"shaft_out": -50.0}))
    text = report.save(tmp_path / "gears.html", scene=False).read_text("utf-8")
    assert "he greatest" in text and "N·m at" in text
    assert by_name(report)["shaft_in", "drive effort"].greatest == pytest.approx(-20.0)


@pytest.mark.usefixtures("without_pictures")
def test_a_wrench_has_its_point_in_the_table_of_loads(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    pytest.importorskip("jinja2")
    load = cd.Wrench(force=(0.0, -30.0, 0.0), frame="world", point=(0.123, 0.0, 0.045))
    links = cd.load("four_bar").links
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", loads={list(links)[2]: load})
    report = Report(scene.sweep(np.linspace(0.0, 6.0, 5)))
    text = report.save(tmp_path / "page.html", scene=False).read_text("utf-8")
    assert "0.123, 0, 0.045" in text and "point of application, link axes" in text


def test_orders_are_those_of_components_in_axes_that_stand_still() -> None:
    """Bending of both shafts at 35° has next to no orders 6 and 8; its size has, as it has kinks.

    The moment on the cross is normal to its plane, T₁ (1, tan β sin² φ …): of tan β T₁ |sin φ| the
    components are tan β T₁ sin φ (sin φ, cos φ), with T₁ = M₂ cos β / (1 − sin² β cos² φ).
    """
    scene = cd.Scene(
        cd.load("universal_joint"),
        drive="bearing_in",
        held={"joint_angle": np.radians(35.0)},
        loads={"bearing_out": -100.0},
    )
    phi = np.arange(4096) * 2.0 * np.pi / 4096
    beta = np.radians(35.0)
    torque = 100.0 * np.cos(beta) / (1.0 - (np.sin(beta) * np.cos(phi)) ** 2)
    size = torque * np.tan(beta) * np.sin(phi)
    for samples in (5, 361):
        report = Report(scene.sweep(np.linspace(0.0, 2.0 * np.pi, samples)))
        assert not [key for key in report.orders if key[1] in ("bending", "shear", "force")]
        found = {key[1]: value for key, value in report.orders.items() if key[0] == "bearing_in"}
        own = []
        for component in (size * np.sin(phi), size * np.cos(phi)):
            amplitudes = np.abs(np.fft.rfft(component))[:9] / 4096
            amplitudes[1:] *= 2.0
            own.append(amplitudes)
        for name, expected in zip(("moment y", "moment z"), own, strict=True):
            np.testing.assert_allclose(found[name], expected, atol=1e-7)
        assert report.orders_error < 1e-6
        kinked = np.abs(np.fft.rfft(np.abs(size)))[:9] / 2048
        assert kinked[8] > 10.0 * max(item[8] for item in own)


def test_several_drives_go_over_their_common_stroke() -> None:
    report = lifted()
    sweep = report.sweep
    assert sweep is not None
    together = np.abs(sweep.position[:, 0] - sweep.position[:, 1]) < 1e-12
    assert np.ptp(sweep.position[together], axis=0) == pytest.approx([2.0, 2.0], rel=1e-3)
    assert "together over 100% of their ranges" in report.said[0]
    assert "of a grid over all ranges" in report.covered
    # Own search: all that the hanger lets be, on a fine grid of strokes.
    scene = cd.Scene(cd.load(TABLE), drive=["a", "b"], gravity=(0.0, 0.0, -9.81))
    pairs = np.stack(
        [np.repeat(np.linspace(0.3, 1.7, 3), 81), np.tile(np.linspace(-0.2, 0.2, 81), 3)], 1
    )
    pairs[:, 1] += pairs[:, 0]
    pairs = pairs[scene.reachable(pairs)]
    dense = scene.sweep(pairs)
    for item in report.extremes:
        if item.quantity == "drive effort":
            values = dense.drive_effort[:, ["a", "b"].index(item.owner)]
            assert item.greatest >= values.max() * (1.0 - 1e-3)
            assert item.least <= values.min() + 1e-3 * values.max()
    # Uphill from the grid, whose steps are 65 mm: where the hanger is all but stretched.
    column = np.linspace(0.25, 0.298, 97)
    stretched = scene.sweep(np.column_stack([np.zeros(97), column]))["swing"].shear.max()
    assert by_name(report)["swing", "shear"].greatest >= stretched
    assert "?" in str(report) and "in doubt" in repr(report)
    assert "at the edge of what loops allow" in report.doubts[0]


@pytest.mark.slow
def test_drives_are_followed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ranges of drives take most of the time of large mechanisms."""
    from cardan_dyn.scene import usual_motion

    calls = []
    original = usual_motion.drives_of
    monkeypatch.setattr(usual_motion, "drives_of", lambda *at: calls.append(at) or original(*at))
    case_of(cd.load(PENDULUM), samples=5)
    assert len(calls) == 1


@pytest.mark.usefixtures("without_pictures")
def test_each_force_is_told_once() -> None:
    """In pins of a flat linkage all that is determined is across the axis; a drive's torsion is
    its effort.
    """
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", gravity=(0.0, -9.81, 0.0))
    report = Report(scene.sweep(np.linspace(0.0, 2.0 * np.pi, 91), speed=30.0))
    told = {(item.owner, item.quantity) for item in report.told}
    assert ("crank_pin", "shear") in told and ("crank_pin", "force") not in told
    assert {item.quantity: item.owner for item in report.headline} == {
        name: max(
            (item for item in report.extremes if item.determined and item.quantity == name),
            key=lambda item: item.size,
        ).owner
        for name in ("shear", "drive effort")
    }
    torsion, effort = by_name(report)["crank_bearing", "torsion"], report.headline[-1]
    assert (torsion.greatest, torsion.least) == pytest.approx((effort.greatest, effort.least))
    assert ("crank_bearing", "torsion") not in told
    # Of a ball, whose force has no axis, the whole is told.
    stewart = Report(cd.load("stewart_platform"))
    assert ("ball_2", "force") in {(item.owner, item.quantity) for item in stewart.told}
    for item in report.extremes:
        (first, _), (second, _) = item.ends
        assert {first, second} == {item.greatest, item.least} and abs(first) >= abs(second)


ARM = """<robot name="arm"><link name="base"/><link name="beam"><inertial><origin xyz="0.5 0 0"/>
<mass value="4"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial></link>
<joint name="wrist" type="revolute"><parent link="base"/><child link="beam"/><axis xyz="0 -1 0"/>
<limit lower="-0.5" upper="0.5" effort="15" velocity="0"/></joint></robot>"""


@pytest.mark.usefixtures("without_pictures")
def test_limits_that_are_exceeded_are_told(tmp_path: Path) -> None:
    pytest.importorskip("jinja2", reason="it is a page")
    spring = cd.JointSpring("wrist", stiffness=2.5e3, damping=0.125, rest=0.1, name="stay")
    scene = cd.Scene(cd.load(ARM), drive="wrist", gravity=(0, 0, -9.81), elements=[spring])
    within, beyond = (Report(scene.sweep(np.linspace(-0.5, end, 9))) for end in (0.5, 0.6))
    effort = 4 * 9.81 * 0.5 * np.cos(0.5) + 2.5e3 * (-0.5 - 0.1)
    told = "Exceeds limit of wrist (28.65°): 34.38° at wrist 34.38°."
    assert told in beyond.beware and f"! {told}" in str(beyond)
    (of_effort,) = (text for text in beyond.exceeded if "effort limit of wrist (-15 N·m)" in text)
    assert amount(effort, "N·m") in of_effort
    assert not any("limit of wrist (28" in text for text in within.beware)
    text = beyond.save(tmp_path / "page.html", scene=False).read_text("utf-8")
    first, _, rest = text.partition("<section>")
    assert told in first and told not in rest
    assert "limits −28.65° … 28.65°; efforts −15 … 15 N·m" in rest
    # Elements are told with their units.
    assert "stiffness 2.5 kN·m/rad; damping 0.125 N·m·s/rad; rest 0.1 rad" in rest


@pytest.mark.usefixtures("without_pictures")
@pytest.mark.parametrize(
    ("limit", "told"),
    [
        ('effort="9e3" least_effort="-6e3"', "; efforts −6 … 9 kN<"),
        (
            'effort="inf" least_effort="-6e3" lower="-inf" upper="0"',
            "limits up to 0 m; efforts from −6 kN<",
        ),
        ('effort="0"', "driven by its author<"),
    ],
)
def test_limits_on_one_side_are_told(limit: str, told: str, tmp_path: Path) -> None:
    pytest.importorskip("jinja2", reason="it is a page")
    text = ARM.replace("revolute", "prismatic").replace(
        'type="pris', 'independent="true" type="pris'
    )
    text = re.sub("<limit .*?/>", f'<limit velocity="0" upper="inf" lower="-inf" {limit}/>', text)
    if limit.count("upper"):
        text = text.replace('upper="inf" lower="-inf" eff', "eff")
    page = Report(cd.Scene(cd.load(text), drive="wrist").sweep(np.zeros(2)))
    assert told in page.save(tmp_path / "page.html", scene=False).read_text("utf-8")


def test_a_universal_joint_has_a_force_and_a_moment() -> None:
    """Along the normal of its cross is no axis by which it could be sized."""
    crossed = """<robot name="shaft"><link name="base"/><link name="a"/><link name="b"/>
    <joint name="in" type="continuous"><parent link="base"/><child link="a"/><axis xyz="1 0 0"/>
    </joint><joint name="cross" type="universal"><parent link="a"/><child link="b"/>
    <axis xyz="0 1 0"/><axis2 xyz="0 0 1"/></joint><loop name="out" type="continuous">
    <predecessor link="base"><origin xyz="0 0 0" rpy="0 0 0.3"/></predecessor>
    <successor link="b"/><axis xyz="1 0 0"/></loop></robot>"""
    scene = cd.Scene(cd.load(crossed), drive="in", loads={"out": -10.0})
    report = Report(scene.sweep(np.linspace(0.0, 2.0 * np.pi, 91)))
    told = {item.quantity: item for item in report.extremes if item.owner == "cross"}
    assert set(told) == {"force", "moment"}
    # The moment is normal to the plane of both pins: between M₂ and M₂ / cos β.
    assert told["moment"].greatest == pytest.approx(10.0 / np.cos(0.3), rel=1e-9)
    assert told["moment"].least == pytest.approx(10.0, rel=1e-9)


BOB = """<robot name="pendulum"><link name="base"/><link name="bob"><inertial>
    <origin xyz="0 0 -0.5"/><mass value="2"/>
    <inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="pin" type="continuous"><parent link="base"/><child link="bob"/>
    <axis xyz="0 1 0"/></joint></robot>"""


@pytest.mark.parametrize(("rtol", "error"), [(1e-10, 1e-7), (1e-3, 1e-3)])
def test_a_trajectory_is_reported_over_its_whole_time(rtol: float, error: float) -> None:
    """A pendulum pulls most where it passes below its pin, by m g (3 - 2 cos of where it began)."""
    scene = cd.Scene(cd.load(BOB), free="pin", gravity=(0.0, 0.0, -9.81))
    # Without a damper its swing would be an integral of its energy.
    damper = cd.JointSpring("pin", 0.0, damping=1e-12)
    run = scene.replace(elements=[damper]).simulate(0.6, position=2.0, rtol=rtol)
    report = Report(run)
    item = by_name(report)["pin", "shear"]
    pull = 2.0 * 9.81 * (3.0 - 2.0 * np.cos(2.0))
    assert item.greatest == pytest.approx(pull, rel=error)
    assert item.settled
    # None of its steps ends there.
    assert run["pin"].shear.max() < pull * (1.0 - 2e-3)
    ((place,),) = item.greatest_at
    assert run.at(place).position[0] == pytest.approx(0.0, abs=1e-3)
    assert "Extremes of the whole time from 0 to 0.6 s." in str(report)
    assert "  t = " in str(report) and not report.doubts and not report.orders
    assert "greatest_at_time" in report.to_dataframe().columns
    # Later times alone are a range as well; in any other order they are samples.
    later = by_name(Report(run.at([0.5, 0.6])))["pin", "shear"]
    assert later.greatest_at == pytest.approx(np.array([[0.5]])) and later.least_at[0, 0] == 0.6
    assert Report(run.at([0.6, 0.5, 0.55])).covered.startswith("the 3 samples")


def test_a_trajectory_that_passes_a_dead_point_tells_what_its_crank_tells() -> None:
    """The rod of a slider-crank, moved by its piston, is straight at a time between two steps."""
    start = {"crank_bearing": 1.0}
    mechanism, gravity = cd.load("slider_crank"), (0.0, -9.81, 0.0)
    by_piston, by_crank = (
        Report(
            cd.Scene(mechanism, free=name, near=start, gravity=gravity).simulate(
                0.5, position=start, speed={"crank_bearing": 20.0}
            )
        )
        for name in ("piston_guide", "crank_bearing")
    )
    assert not by_piston.doubts
    found, expected = by_name(by_piston), by_name(by_crank)
    for name in ("crank_bearing", "crank_pin", "piston_guide", "piston_pin"):
        shear, known = found[name, "shear"], expected[name, "shear"]
        assert shear.settled and shear.greatest == pytest.approx(known.greatest, rel=1e-8)
    acting = [item for item in by_piston.extremes if item.acts]
    assert "drive effort" not in {item.quantity for item in acting}  # It is free.


def test_a_trajectory_through_meeting_modes_tells_what_it_does_not_know() -> None:
    """There no free coordinate decides the motion, whichever it is."""
    scene = cd.Scene(parallelograms(1), free="pin_0", gravity=(0.0, -9.81, 0.0))
    report = Report(scene.simulate(0.3, position=0.3, speed=12.0))
    (doubt,) = report.doubts
    assert "the configuration is singular, and no free coordinate decides the motion" in doubt
    assert doubt.endswith("; a ? marks what may be exceeded.")
    assert all(row[0].endswith(" ?") for row in report.cases.sized.rows)
    acting = [item for item in report.extremes if item.acts]
    assert acting and not any(item.settled for item in acting)


def test_a_slotted_lever_is_sized_by_what_acts_in_its_plane() -> None:
    """A force on a slide is carried as it is told, and no guide is sized by that."""
    scene = cd.Scene(cd.load("slider_crank"), drive="crank_bearing", loads={"piston_guide": -9e3})
    sweep = scene.sweep(np.linspace(0.0, 2.0 * np.pi, 61))
    report = Report(sweep)
    guide = sweep["piston_guide"]
    assert not guide.unique[:3].all()
    item = by_name(report)["piston_guide", "shear"]
    (across,) = (k for k in range(3) if guide.unique[k] and not guide.axis[k])
    assert item.determined and item.size == pytest.approx(np.abs(guide.force[:, across]).max())
    assert {item.quantity for item in report.headline} == {"shear", "drive effort"}


def test_a_length_that_is_held_or_driven_is_no_joint(tmp_path: Path) -> None:
    crank = cd.load("slider_crank")
    name, grown = "origin:crank_pin.x", 0.01
    moved = ElementTree.fromstring(crank.to_urdf())
    (origin,) = moved.findall("joint[@name='crank_pin']/origin")
    x, *others = origin.get("xyz", "").split()
    origin.set("xyz", " ".join([repr(float(x) + grown), *others]))
    longer = cd.load(ElementTree.tostring(moved, encoding="unicode"))
    turn, given = np.linspace(0.0, 2.0 * np.pi, 9), {"loads": {"piston_guide": -5e3}}
    scene = cd.Scene(crank, drive="crank_bearing", held={name: grown}, **given)
    own = Report(scene.sweep(turn, speed=10.0))
    other = Report(cd.Scene(longer, drive="crank_bearing", **given).sweep(turn, speed=10.0))
    assert [item[:3] for item in own.extremes] == [item[:3] for item in other.extremes]
    for ours, theirs in zip(own.extremes, other.extremes, strict=True):
        np.testing.assert_allclose(ours.greatest, theirs.greatest, rtol=1e-9, atol=1e-6)
    assert own.left_open == other.left_open and name not in own.left_open
    # Where it is driven, something sets it, and has to exert what it takes.
    drawn_out = scene.replace(drive=name, held={"crank_bearing": 0.3})
    swept = drawn_out.sweep(np.linspace(0.0, grown, 5))
    report = Report(swept)
    (effort,) = (item for item in report.extremes if item.owner == name)
    assert effort.quantity == "drive effort"
    assert effort.greatest >= swept.drive_effort.max() > 0.0
    assert report.covered == "the whole range from 0 to 10 mm"
    report.save(tmp_path / "driven.html", scene=False)
    report.save(tmp_path / "driven.csv")


@pytest.mark.usefixtures("without_pictures")
def test_a_task_that_is_simulated_is_told_beside_what_is_free(tmp_path: Path) -> None:
    """A trolley keeps the load at its height while the rope swings as it may."""
    crane = cd.load(
        '<robot name="crane"><link name="rail"/><link name="rope"/><link name="trolley"><inertial>'
        '<mass value="50"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="load">'
        '<inertial><mass value="20"/><inertia/></inertial></link><joint name="travel" '
        'type="prismatic"><parent link="rail"/><child link="trolley"/><axis xyz="1 0 0"/></joint>'
        '<joint name="swing" type="continuous"><parent link="trolley"/><child link="rope"/>'
        '<axis xyz="0 -1 0"/></joint><joint name="hoist" type="prismatic"><parent link="rope"/>'
        '<child link="load"/><origin xyz="0 0 -5"/><axis xyz="0 0 -1"/></joint></robot>'
    )
    level = cd.Scene(
        crane,
        task=["travel", cd.PointTask("load", axes="z")],
        actuated=["travel", "hoist"],
        free="swing",
        gravity=(0.0, 0.0, -9.81),
    )

    def start(time: float) -> tuple[float, float, float]:
        return 0.2 * time**2, 0.4 * time, 0.4

    run = level.simulate(1.0, motion={"travel": start, "load.z": 0.0})
    report = Report(run)
    low = np.degrees(run.motion.position("swing").min())
    assert f"swing {low:.4g}° … 0°" in report.case_lines
    assert {"travel 0 … 200 mm", "load.z at -5 m"} <= {*report.case_lines}
    assert not any(line.startswith("hoist") for line in report.case_lines)
    efforts = {item.owner for item in report.extremes if item.quantity == "drive effort"}
    assert efforts == {"travel", "hoist"} == {*run.actuated_effort}
    text = report.save(tmp_path / "crane.html", scene=False).read_text("utf-8")
    for name in ("free swing", "drive hoist", "task travel", "task load.<wbr>z"):
        assert f'<th scope="row">{name}</th>' in text
    assert "drive swing" not in text and " Task: " in text
    free = cd.Scene(cd.load(PENDULUM), free="pivot", gravity=(0.0, 0.0, -9.81)).simulate(0.1)
    text = Report(free).save(tmp_path / "free.html", scene=False).read_text("utf-8")
    assert " Free: " in text and '<th scope="row">free pivot</th>' in text
    assert "Driven" not in text and ">driven<" not in text


def test_places_of_one_row_of_a_task_are_those_of_the_row() -> None:
    """A crank leads, a piston drives: a bare length would be taken for that of what leads."""
    scene = cd.Scene(
        cd.load("slider_crank"),
        task=["crank_bearing"],
        actuated=["piston_guide"],
        near={"crank_bearing": 0.5},
        loads={"crank_bearing": -3.0},
    )
    found = cd.Report(scene.sweep(np.radians([20.0, 30.0, 60.0, 120.0])))
    told = str(found)
    assert "the whole range of piston_guide from -" in told
    first = next(line for line in told.splitlines() if "drive effort" in line)
    assert "crank_bearing 20°" in first
    # The other end lies between samples, and is named by what drives there.
    assert re.search(r"piston_guide -\d+\.\d mm", first)
