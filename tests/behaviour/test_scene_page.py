"""The page of a scene in a real browser: labels, slider, graph, selection, keys, light and dark."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from testkit.accessibility import grave
from testkit.browser import Page, open_page, running_browser
from testkit.bundled import EVERY_KIND

import cardan_dyn as cd
from cardan_dyn.practice.drive_lines.wording import Wording
from cardan_dyn.scene.usual_motion import usual_motion

pytestmark = pytest.mark.slow

WINDOWS = ((1280, 760), (390, 780))
MOMENTS = (0.05, 0.37, 0.72)
# Boxes [left, top, right, bottom] of what may be over the picture, of the page as it stands there.
BOXES = """(ids => {
  const frame = document.getElementById("view").getBoundingClientRect();
  const box = (item) => { const b = item.getBoundingClientRect();
    return [b.left - frame.left, b.top - frame.top, b.right - frame.left, b.bottom - frame.top]; };
  return { frame: [frame.width, frame.height],
    labels: [...document.querySelectorAll("#labels > div:not([hidden])")].map(box),
    cut: [...document.querySelectorAll("#labels > div:not([hidden])")]
      .filter((item) => item.scrollWidth > item.clientWidth).map((item) => item.textContent),
    others: ["views", "triad", "scales", "transport"].map(
      (id) => box(document.getElementById(id))) };
})()"""

# Triangles of the greatest mesh, and the corners of the box about those of its points it uses.
EXTENT = """(() => {
  const { geometry } = meshes.reduce((most, item) =>
    item.geometry.index.count > most.geometry.index.count ? item : most);
  const box = new THREE.Box3(), at = new THREE.Vector3();
  for (const index of geometry.index.array) {
    box.expandByPoint(at.fromBufferAttribute(geometry.attributes.position, index));
  }
  return [geometry.index.count / 3, [...box.min.toArray(), ...box.max.toArray()]]; })()"""

Opener = Callable[..., Page]


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with running_browser() as browser:
        yield browser


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """What exports the scene of a bundled mechanism, once."""
    directory = tmp_path_factory.mktemp("scenes")

    @cache
    def exported(name: str) -> Path:
        sweep = usual_motion(cd.load(name), samples=121).sweep()
        return cd.view(sweep).export(directory / f"{name}.html")

    return exported


@pytest.fixture
def opened(browser: Any) -> Iterator[Opener]:
    """What opens scenes in the browser, until the test ends; none of them may complain."""
    pages: list[Page] = []

    def opener(address: str | Path, **options: Any) -> Page:
        pages.append(open_page(browser, address, **options))
        return pages[-1]

    yield opener
    for shown in pages:
        assert shown.complaints == []
        shown.page.close()


@pytest.fixture
def four_bar(opened: Opener, files: Callable[[str], Path]) -> Page:
    return opened(files("four_bar"), size=WINDOWS[0])


def overlapping(boxes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Whether each box covers a part of each other one, `(n, m)`."""
    first, second = boxes[:, None], others[None]
    apart = (first[..., :2] >= second[..., 2:]) | (second[..., :2] >= first[..., 2:])
    return ~np.any(apart, axis=-1)


def selected(page: Page) -> list[str]:
    return page.evaluate(
        "[...document.querySelectorAll('[role=option][aria-selected=true]')]"
        ".map((item) => item.firstChild.textContent)"
    )


@pytest.mark.parametrize("name", EVERY_KIND)
def test_labels_neither_cover_each_other_nor_are_cut(
    name: str, opened: Opener, files: Callable[[str], Path]
) -> None:
    page = opened(files(name), size=WINDOWS[0])
    most = 0
    for width, height in WINDOWS:
        page.page.set_viewport_size({"width": width, "height": height})
        page.page.wait_for_function(f"innerWidth === {width} && size.width <= {width}")
        for where in ("bearings", "all"):
            page.page.select_option("#where", where) if page.page.is_visible("#where") else None
            for moment in MOMENTS:
                page.evaluate(f"scene.seek({moment})")
                found = page.evaluate(BOXES)
                boxes = np.array(found["labels"]).reshape(-1, 4)
                most = max(most, len(boxes))
                assert len(boxes) > 0
                assert np.sum(overlapping(boxes, boxes)) == len(boxes)  # Each covers itself alone.
                assert not np.any(overlapping(boxes, np.array(found["others"])))
                assert np.all(boxes[:, :2] >= 0.0)
                assert np.all(boxes[:, 2:] <= np.array(found["frame"]))
                assert found["cut"] == []
    assert most >= 4


def test_labels_stand_out_in_the_light_and_in_the_dark(
    opened: Opener, files: Callable[[str], Path]
) -> None:
    """Contrast 4.5 : 1 of every label with the background, as the guidelines ask of texts."""
    contrasts = """[...document.querySelectorAll("#labels > div:not([hidden])")].map((item) => {
      const rgb = (text) => text.match(/[\\d.]+/g).slice(0, 3).map((value) => value / 255);
      const sky = getComputedStyle(document.documentElement).getPropertyValue("--ground");
      return contrast(rgb(getComputedStyle(item).color), channels(sky.trim())); })"""
    grounds = []
    for theme in ("light", "dark"):
        page = opened(files("double_shaft_z"), size=WINDOWS[0], theme=theme)
        assert page.evaluate("document.documentElement.dataset.theme") == theme
        page.seek(0.2)
        found = page.evaluate(contrasts)
        assert len(found) > 4 and min(found) >= 4.5
        # Every swatch of the legend, and so every arrow, has 3 : 1.
        swatches = page.evaluate(
            """[...document.querySelectorAll(".swatch")].map((swatch) => contrast(
              getComputedStyle(swatch).backgroundColor.match(/[\\d.]+/g).slice(0, 3)
                .map((value) => value / 255), channels(BACKGROUNDS[theme])))"""
        )
        assert len(swatches) > 4 and min(swatches) >= 3.0
        grounds.append(page.picture(0.2)[400, 20].sum())
    assert grounds[0] > 600 > 200 > grounds[1]


def test_the_theme_can_be_switched_and_follows_the_system_until_then(four_bar: Page) -> None:
    theme = "document.documentElement.dataset.theme"
    four_bar.page.emulate_media(color_scheme="dark")
    four_bar.page.wait_for_function(f"{theme} === 'dark'")
    four_bar.page.click("#theme")
    assert four_bar.evaluate(theme) == "light"
    four_bar.page.emulate_media(color_scheme="light")
    four_bar.page.emulate_media(color_scheme="dark")
    assert four_bar.evaluate(theme) == "light"
    # Whoever has chosen finds that again on the next page.
    four_bar.page.emulate_media(color_scheme="dark")
    four_bar.page.reload()
    four_bar.page.wait_for_function("window.scene && scene.frames.count > 0")
    assert four_bar.evaluate(theme) == "light"


@pytest.mark.parametrize(("size", "theme"), [(WINDOWS[0], "light"), (WINDOWS[1], "dark")])
def test_axe_finds_nothing_grave(
    size: tuple[int, int], theme: str, opened: Opener, files: Callable[[str], Path]
) -> None:
    page = opened(files("slider_crank"), size=size, theme=theme)
    page.seek(0.3)
    page.page.click("#help summary")
    assert grave(page.page) == []


def test_the_slider_shows_the_drive_in_degrees(four_bar: Page) -> None:
    four_bar.page.evaluate(
        "(() => { const item = document.getElementById('slider');"
        "item.value = 90; item.dispatchEvent(new Event('input')); })()"
    )
    assert four_bar.page.inner_text("#at").endswith("90°")
    assert four_bar.page.get_attribute("#slider", "aria-valuetext") == "crank_bearing 90°"
    assert four_bar.page.get_attribute("#slider", "aria-label") == "crank_bearing in degrees"
    assert four_bar.evaluate("scene.place") == pytest.approx(30.0, abs=1e-6)
    # The scene is there as well: the crank stands a quarter of a turn from its start.
    four_bar.page.wait_for_function("scene.settled")
    assert "crank_bearing 90°" in four_bar.page.inner_text("#state")
    turn = four_bar.evaluate(
        "(() => { const now = scene.node('/mechanism/crank').quaternion.clone(); scene.seek(0);"
        "return now.angleTo(scene.node('/mechanism/crank').quaternion); })()"
    )
    assert turn == pytest.approx(np.pi / 2.0, abs=1e-5)


def test_the_graph_tells_the_numbers_of_the_sweep(four_bar: Page) -> None:
    sweep = usual_motion(cd.load("four_bar"), samples=121).sweep()
    four_bar.evaluate("scene.seek(50 / 120)")
    table = four_bar.page.inner_text("#graphs table")
    torsion = sweep["crank_bearing"].torsion
    row = next(line for line in table.splitlines() if line.startswith("torsion"))
    numbers = [float(word) for word in row.replace("−", "-").split() if word[-1].isdigit()]
    np.testing.assert_allclose(numbers, [torsion[50], torsion.min(), torsion.max()], rtol=1e-3)
    assert "N·m" in table
    # A click into the graph moves the scene there.
    box = four_bar.page.locator("#graphs svg").first.bounding_box()
    left, right = 46, 8
    four_bar.page.mouse.click(box["x"] + left + 0.5 * (box["width"] - left - right), box["y"] + 40)
    assert four_bar.evaluate("scene.place") == pytest.approx(60.0, abs=1.0)
    cursor = float(four_bar.page.locator("#graphs line.cursor").first.get_attribute("x1"))
    assert cursor == pytest.approx(left + 0.5 * (box["width"] - left - right), abs=2.0)


def test_ticks_of_great_numbers_fit_beside_the_graph(opened: Opener, tmp_path: Path) -> None:
    """As forces near a dead point are."""
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", loads={"rocker_bearing": -4e8})
    sweep = scene.sweep(np.linspace(0.0, 2.0 * np.pi, 25))
    page = opened(cd.view(sweep).export(tmp_path / "great.html"), size=WINDOWS[0])
    ticks = page.page.evaluate(
        "[...document.querySelectorAll('#graphs svg')].flatMap((svg) =>"
        " [...svg.querySelectorAll('text')].map((item) => [item.textContent,"
        " item.getBoundingClientRect().left - svg.getBoundingClientRect().left]))"
    )
    heads = page.page.evaluate(
        "[...document.querySelectorAll('#graphs th')].map((item) => item.textContent)"
    )
    assert "GN" in heads and all(len(text) < 7 for text, _ in ticks)
    assert min(left for _, left in ticks) >= 0.0


def test_what_statics_leaves_open_is_marked(four_bar: Page) -> None:
    text = four_bar.page.inner_text("#chosen")
    assert "Not unique: force z, moment xy, chosen by least norm" in text
    assert "shear, force" in text and "force *" not in text and "torsion *" not in text
    assert "that the parent exerts on the child" in text
    texts = [item["text"] for item in four_bar.evaluate("scene.labels()")]
    # The whole force is not known, but the force across the axis is.
    known = """Object.fromEntries(labels.filter(({ joint, kind }) => kind === "number"
      && joint.name === "crank_bearing").map(({ root, unique }) => [root, unique]))"""
    expected = {"torsion": True, "shear": True}
    assert four_bar.evaluate(known) == expected
    assert any(re.fullmatch(r"shear [\d.]+ N", text) for text in texts)
    chosen = "{ kind: 'number', root: 'axial', now: 3, told: toldUpTo(99, 'N', 3) }"
    assert four_bar.evaluate(f"textOf({chosen})") == "axial 3.0 N *"


def test_joints_and_links_are_selected_in_the_list_and_in_the_scene(four_bar: Page) -> None:
    page = four_bar.page
    assert selected(four_bar) == ["crank_bearing"]
    page.click("#list >> text=crank_pin")
    assert selected(four_bar) == ["crank_pin"]
    assert page.inner_text("#chosen-title") == "crank_pin"
    page.wait_for_function("scene.settled")
    assert "crank_pin" in [item["text"] for item in four_bar.evaluate("scene.labels()")]
    page.focus("#list")
    page.keyboard.press("ArrowDown")
    assert selected(four_bar) == ["rocker_bearing"]
    page.keyboard.press("End")
    assert selected(four_bar) == ["rocker"]
    assert page.inner_text("#chosen-title") == "rocker"
    page.click("#details >> text=rocker_bearing")
    assert selected(four_bar) == ["rocker_bearing"]
    page.wait_for_function("scene.settled")
    # The name of the other bearing, then the middle of the coupler, in the scene.
    name = "scene.labels().find((item) => item.text === 'crank_bearing').box"
    left, top, right, bottom = four_bar.evaluate(name)
    page.mouse.click((left + right) / 2, (top + bottom) / 2)
    assert selected(four_bar) == ["crank_bearing"]
    four_bar.seek(0.3)
    middle = """(() => {
      const box = new THREE.Box3().setFromObject(scene.node("/mechanism/coupler"));
      const point = box.getCenter(new THREE.Vector3()).project(camera);
      return [(point.x + 1) * size.width / 2, (1 - point.y) * size.height / 2]; })()"""
    page.mouse.click(*four_bar.evaluate(middle))
    assert selected(four_bar) == ["coupler"]
    page.keyboard.press("Escape")
    assert selected(four_bar) == []


def test_flat_linkages_are_seen_from_above_their_plane(
    opened: Opener, files: Callable[[str], Path]
) -> None:
    """However thick their links are drawn: the crank of the slider-crank is as tall as wide."""
    for name, is_flat in (("slider_crank", True), ("universal_joint", False)):
        assert (opened(files(name)).evaluate("orbit.elevation") > 0.8) == is_flat


def test_keys_play_step_and_look(four_bar: Page) -> None:
    page = four_bar.page
    page.focus("#canvas")
    four_bar.evaluate("scene.seek(0)")
    page.keyboard.press(" ")
    assert four_bar.evaluate("scene.playing")
    page.wait_for_function("scene.place > 0.5")
    page.keyboard.press(" ")
    assert not four_bar.evaluate("scene.playing")
    page.keyboard.press("Home")
    page.keyboard.press("ArrowRight")
    assert page.inner_text("#at").endswith("1°")
    page.keyboard.press("Shift+ArrowRight")
    assert page.inner_text("#at").endswith("11°")
    page.keyboard.press("End")
    assert four_bar.evaluate("scene.place") == 120
    page.keyboard.press("3")
    assert four_bar.evaluate("orbit.elevation") == pytest.approx(np.pi / 2.0, abs=1e-3)
    page.keyboard.press("1")
    assert four_bar.evaluate("orbit.elevation") == pytest.approx(0.0, abs=1e-9)
    far = four_bar.evaluate("orbit.distance")
    page.keyboard.press("+")
    assert four_bar.evaluate("orbit.distance") < far
    # Views along axes are drawings: what is behind is as large as what is in front.
    assert four_bar.evaluate("camera === parallel")
    assert page.get_attribute("#lens", "aria-pressed") == "true"
    apart = """[[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]].map((at) =>
      new THREE.Vector3(...at).project(camera).x)"""
    near, beside, behind, both = four_bar.evaluate(apart)
    assert beside - near == pytest.approx(both - behind, rel=1e-6)
    page.keyboard.press("5")
    near, beside, behind, both = four_bar.evaluate(apart)
    assert beside - near > 1.1 * (both - behind)
    page.keyboard.press("5")
    page.keyboard.press("0")
    assert four_bar.evaluate("orbit.distance") == pytest.approx(far)
    page.keyboard.press("n")
    assert selected(four_bar) == ["crank_pin"]
    # Focus goes through the controls in the order in which they stand, and is seen.
    page.focus("#canvas")
    order = []
    for _ in range(10):
        page.keyboard.press("Tab")
        order.append(four_bar.evaluate("document.activeElement.id || document.activeElement.title"))
        assert four_bar.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"
    assert order[5:] == ["lens", "play", "slider", "speed", "fold"]


def test_parts_are_switched_and_joints_chosen(four_bar: Page) -> None:
    page = four_bar.page
    kinds = "[...new Set(scene.labels().map((item) => item.kind))].sort()"
    four_bar.seek(0.3)
    assert four_bar.evaluate(kinds) == ["load", "name", "number"]
    page.uncheck("[data-part=numbers]")
    page.select_option("#where", "all")
    four_bar.seek(0.3)
    names = [item["text"] for item in four_bar.evaluate("scene.labels()")]
    assert {"crank_pin", "rocker_pin", "crank_bearing", "rocker_bearing"} <= set(names)
    for part, path in (("shapes", "/mechanism"), ("forces", "/shear"), ("axes", "/axes")):
        assert four_bar.evaluate(f"scene.node('{path}').visible")
        page.uncheck(f"[data-part={part}]")
        assert not four_bar.evaluate(f"scene.node('{path}').visible")
    page.select_option("#where", "bearings")
    assert not four_bar.evaluate("scene.node('/torsion/rocker_pin')?.visible ?? false")


def test_a_page_waits_where_people_want_no_motion(
    browser: Any, files: Callable[[str], Path]
) -> None:
    page = browser.new_page(reduced_motion="reduce")
    page.goto(files("four_bar").as_uri())
    page.wait_for_function("window.scene && scene.frames.count > 0")
    assert not page.evaluate("scene.playing")
    assert page.evaluate("scene.place") == 0
    # Nothing moves, so nothing is drawn once the page has its size and its fonts.
    counts = [page.evaluate("scene.frames.count")]
    for _ in range(20):
        page.wait_for_timeout(300)
        counts.append(page.evaluate("scene.frames.count"))
        if counts[-1] == counts[-2]:
            break
    assert counts[-1] == counts[-2]
    page.close()


def test_a_frame_draws_each_object_once_and_measures_nothing(four_bar: Page) -> None:
    """Boxes of the page are measured when it changes: that in each frame would halve their rate."""
    calls, reads, asked, objects = four_bar.evaluate(
        """(() => {
      let reads = 0, asked = 0;
      const measure = Element.prototype.getBoundingClientRect, ask = renderer.render;
      Element.prototype.getBoundingClientRect = function () { reads++; return measure.call(this); };
      renderer.render = (...all) => { asked++; ask.call(renderer, ...all); };
      for (let index = 0; index < 10; index++) { step(0.02); drawNow(); }
      Element.prototype.getBoundingClientRect = measure;
      renderer.render = ask;
      return [renderer.info.render.calls, reads, asked, meshes.length]; })()"""
    )
    assert reads == 0 and asked == 10
    assert 0 < calls <= objects


def test_meshes_are_coarser_in_motion_only_where_a_machine_is_too_slow(
    opened: Opener, tmp_path: Path
) -> None:
    """A wavy sheet of 80 000 triangles turns: fewer of them move, at the same place."""
    side = 200
    x, y = np.meshgrid(np.linspace(0.0, 1.0, side + 1), np.linspace(0.0, 1.0, side + 1))
    points = np.stack([x, y, 0.05 * np.sin(9.0 * x)], axis=-1)
    corner = points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]
    triangles = np.concatenate(
        [np.stack([corner[0], corner[k], corner[k + 1]], axis=2).reshape(-1, 9) for k in (1, 2)]
    )
    facets = np.zeros(
        len(triangles),
        dtype=[
            ("normal", "<f4", 3),
            ("corners", "<f4", 9),
            ("attribute", "<u2"),
        ],
    )
    facets["corners"] = triangles
    count = np.array([len(triangles)], dtype="<u4").tobytes()
    (tmp_path / "sheet.stl").write_bytes(bytes(80) + count + facets.tobytes())
    mechanism = tmp_path / "sheet.urdf"
    mechanism.write_text(
        '<robot name="r"><link name="a"/><link name="b"><visual><geometry>'
        '<mesh filename="sheet.stl"/></geometry></visual></link>'
        '<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint></robot>'
    )
    turn = cd.Scene(cd.load(mechanism), drive="j").sweep(np.linspace(0.0, 1.0, 5))
    page = opened(cd.view(turn).export(tmp_path / "scene.html"))
    page.seek(0.0)
    full, box = page.evaluate(EXTENT)
    assert full > 36_000
    light, light_box = page.evaluate(f"(useCoarse(true), {EXTENT})")
    assert 5_000 < light <= 36_000
    np.testing.assert_allclose(light_box, box, atol=0.02)
    page.evaluate("(drawnWith = 0, settle())")
    assert page.evaluate(EXTENT)[0] == full  # At rest all of them are there again.
    # Fewer pixels come first.
    slow = "(pace(100), [motionSharpness, isTooSlow])"
    levels = [page.evaluate(slow) for _ in range(40)]
    assert levels[0] == [1, False] and levels[-1] == [0.6, True]
    assert all(sharpness == 0.6 for sharpness, too_slow in levels if too_slow)


def test_a_scene_that_nobody_sees_stands_still(
    opened: Opener, files: Callable[[str], Path], tmp_path: Path
) -> None:
    """As in a report: further down than the window shows."""
    outer = tmp_path / "outer.html"
    frame = f'<iframe src="{files("four_bar").as_uri()}" width="900" height="600"></iframe>'
    outer.write_text(f'<!DOCTYPE html><title>t</title><div style="height: 3000px"></div>{frame}')
    page = opened(outer, scene=False).page
    inner = page.frames[1]
    inner.wait_for_function("window.scene && !onScreen")
    inner.wait_for_timeout(200)  # A frame that was asked for before.
    count = inner.evaluate("scene.frames.count")
    inner.wait_for_timeout(300)
    assert inner.evaluate("scene.playing") and inner.evaluate("scene.frames.count") == count
    page.evaluate("scrollTo(0, 3000)")
    inner.wait_for_function(f"scene.frames.count > {count} + 2")


def test_on_a_small_screen_the_panel_stands_below_and_folds(
    opened: Opener, files: Callable[[str], Path]
) -> None:
    page = opened(files("drive_line"), size=WINDOWS[1])
    wide = "document.documentElement.scrollWidth"
    assert page.evaluate(wide) <= 390 and page.evaluate("panel.scrollWidth") <= 390
    view, panel = (page.page.locator(name).bounding_box() for name in ("#view", "#panel"))
    assert panel["y"] >= view["y"] + view["height"] - 1
    page.page.click("#fold")
    assert not page.page.is_visible("#panel")
    assert page.page.get_attribute("#fold", "aria-expanded") == "false"
    assert page.page.locator("#view").bounding_box()["height"] == pytest.approx(780, abs=1)
    page.page.click("#fold")
    assert page.page.is_visible("#graphs svg")


def test_simulations_are_played_in_real_time(opened: Opener, tmp_path: Path) -> None:
    scene = cd.Scene(cd.load("four_bar"), free="crank_bearing", gravity=(0.0, -9.81, 0.0))
    path = cd.view(scene.simulate(3.0, position=0.3), frames=61).export(tmp_path / "swing.html")
    page = opened(path)
    page.evaluate("scene.seek(0.5)")
    assert page.page.inner_text("#at").endswith("1.50 s")
    assert page.page.inner_text("#speed option:checked") == "real time"
    page.evaluate("step(0.5)")
    assert page.page.inner_text("#at").endswith("2.00 s")


def test_quantities_are_told_in_the_units_of_the_reader(opened: Opener, tmp_path: Path) -> None:
    # From the definitions of NIST SP 811, by other products than the wording's.
    force, foot = 0.45359237 * 9.80665, 0.3048
    scene = cd.Scene(cd.load("slider_crank"), drive="crank_bearing", loads={"piston_guide": 900.0})
    sweep = scene.sweep(np.linspace(0.0, 1.5, 31), speed=np.pi)
    units = Wording(units="imperial").instead
    page = opened(cd.view(sweep, units=units).export(tmp_path / "imperial.html"))
    page.evaluate("scene.seek(1.0)")
    page.evaluate("select({ joint: told.joints.find((j) => j.name === 'crank_bearing') })")
    rows = dict(
        page.evaluate(
            "[...document.querySelectorAll('#graphs tbody tr')].map((row) =>"
            " [row.cells[0].textContent, Number(row.cells[1].textContent.replace('−', '-'))])"
        )
    )
    wrench = sweep["crank_bearing"]
    drive = float(sweep.drive_effort[-1]) / (force * foot)
    shear = float(np.linalg.norm(wrench.force[-1])) / force
    assert rows["torsion, drive"] == pytest.approx(drive, rel=1e-3)
    assert rows["shear, force"] == pytest.approx(shear, rel=1e-3)
    text = page.page.inner_text("body")
    assert "lbf·ft" in text and "lbf" in text and "30 rpm" in text
    assert re.search(r"Grid of [125]0* in\b", text)
    steps = page.evaluate("[...document.querySelectorAll('#scales span')].map((s) => s.innerText)")
    assert len(steps) == 3
    for step in filter(None, steps):
        assert re.match(r"(0\.)?0*[125]0* (in|lbf|lbf·ft)$", step), step
    for other in ("N·m", "kN", "N", "mm", "m", "1/min"):
        assert not re.search(rf"\d ?{other}\b", text), other
    page.evaluate("select({ joint: told.joints.find((j) => j.name === 'piston_guide') })")
    ends = sweep.motion.position("piston_guide") / 0.0254
    low, high = re.search(r"stroke (\S+) … (\S+) in", page.page.inner_text("#details")).groups()
    assert [float(low.replace("−", "-")), float(high.replace("−", "-"))] == pytest.approx(
        [np.min(ends), np.max(ends)], rel=1e-3
    )


def test_slides_are_told_in_metres_or_millimetres(opened: Opener, tmp_path: Path) -> None:
    scene = cd.Scene(cd.load("slider_crank"), drive="piston_guide", near={"crank_bearing": 1.0})
    rest = float(scene.configuration().positions["piston_guide"])
    sweep = scene.sweep(rest + np.linspace(0.0, 0.004, 9))
    page = opened(cd.view(sweep).export(tmp_path / "slide.html"))
    page.evaluate("scene.seek(1.0)")
    told = page.page.inner_text("#at").split()
    assert told[0] == "piston_guide" and told[2] == "mm"
    assert float(told[1].replace("−", "-")) == pytest.approx(1e3 * (rest + 0.004), abs=0.01)
    assert page.page.get_attribute("#slider", "aria-label") == "piston_guide in mm"


def test_a_sweep_at_speed_tells_how_much_slower_it_is_shown(opened: Opener, tmp_path: Path) -> None:
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing")
    sweep = scene.sweep(np.linspace(0.0, 2.0 * np.pi, 61), speed=50.0 * np.pi)
    page = opened(cd.view(sweep, duration=4.0).export(tmp_path / "fast.html"))
    page.evaluate("scene.seek(0.25)")
    assert page.page.inner_text("#at").split() == ["crank_bearing", "90°", "10.0", "ms"]
    assert page.page.inner_text("#speed option:checked") == "100× slower"
    assert "1500 1/min" in page.page.inner_text("#state")
    page.evaluate("step(1)")
    assert page.page.inner_text("#at").split()[1] == "180°"


def test_the_chosen_link_alone_glows(four_bar: Page) -> None:
    """Links of one colour have materials of their own."""
    glowing = """(link) => {
      select({ link: told.links.find(({ name }) => name === link) });
      return [...new Set(meshes.filter(({ material, userData }) => (
        userData.path.startsWith("/mechanism/") && material.emissive.getHex()))
        .map(({ userData }) => userData.path.split("/")[2]))]; }"""
    for link in ("crank", "coupler"):
        assert four_bar.page.evaluate(glowing, link) == [link]
    assert four_bar.page.evaluate(glowing, "none") == []
