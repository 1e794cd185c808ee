"""Exported scenes in a real headless browser: what they show, and that they stay offline."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from testkit.accessibility import grave, violations
from testkit.browser import Page, open_page, running_browser

import cardan_dyn as cd
from cardan_dyn.practice.report import comparisons, report
from cardan_dyn.scene.usual_motion import usual_motion

# Hues of the bundled descriptions' materials: channel that leads, channel that trails.
BLUE, ORANGE = (2, 0), (0, 2)
Opener = Callable[..., Page]


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with running_browser() as browser:
        yield browser


@pytest.fixture
def opened(browser: Any) -> Iterator[Opener]:
    """What opens pages in the browser, until the test ends."""
    pages: list[Page] = []

    def opener(address: str | Path, scene: bool = True) -> Page:
        pages.append(open_page(browser, address, scene))
        return pages[-1]

    yield opener
    for shown in pages:
        shown.page.close()


@pytest.fixture(scope="module")
def joint_turn(joint: cd.Mechanism) -> cd.Sweep:
    return comparisons.turn_of(joint, float(np.deg2rad(50.0)))


def share(picture: np.ndarray, hue: tuple[int, int], gap: int = 70) -> float:
    """Fraction of the pixels in the scene whose colour has this hue."""
    scene = picture[50:620, :850]
    lead, trail = (scene[..., channel] for channel in hue)
    middle = scene[..., 1]
    seen = (lead - trail > gap) & (middle < lead) & (middle > trail)
    return float(np.mean(seen))


def changed(first: np.ndarray, second: np.ndarray) -> float:
    """Fraction of the pixels in the scene that differ visibly."""
    return float(np.mean(np.max(np.abs(first - second)[50:620, :850], axis=2) > 20))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["universal_joint", "double_shaft_z"])
def test_scene_shows_both_shafts_turning(name: str, opened: Opener, tmp_path: Path) -> None:
    sweep = usual_motion(cd.load(name)).sweep()
    file = cd.view(sweep).export(tmp_path / "scene.html")
    page = opened(file)
    pictures = [page.picture(moment) for moment in (0.0, 0.1, 0.3)]
    for picture in pictures:
        assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 500
        assert share(picture, BLUE) > 0.004
        assert share(picture, ORANGE) > 0.003
        # Nothing is cut off: the outermost pixels of the scene show the background alone.
        border = np.concatenate(
            [picture[:3, :780], picture[50:690, :3].reshape(1, -1, 3)], axis=None
        )
        assert np.max(np.ptp(border.reshape(-1, 3), axis=1)) < 25
    assert changed(pictures[0], pictures[1]) > 0.005
    assert changed(pictures[1], pictures[2]) > 0.005
    # The revolution closes, up to a last frame that differs by rounding.
    assert changed(pictures[0], page.picture(1.0)) < 0.002
    assert page.complaints == []
    assert page.requests == [file.as_uri()]


@pytest.mark.slow
def test_arrows_end_where_the_wrench_says(
    opened: Opener, joint_turn: cd.Sweep, tmp_path: Path
) -> None:
    """Length and direction of the bending arrow at a sample, as the browser places it."""
    page = opened(cd.view(joint_turn, frames=721).export(tmp_path / "scene.html"))
    greatest = max(np.max(np.linalg.norm(joint_turn[k].moment, axis=1)) for k in joint_turn.outputs)
    for sample in (40, 250):
        page.picture(sample / 720)
        tips = []
        for kind in ("torsion", "bending"):
            node = f'scene.node("/{kind}/bearing_in")'
            tips.append(
                page.evaluate(
                    f"(() => {{ const n = {node}; const v = new THREE.Vector3(0, 0, 1);"
                    "v.applyQuaternion(n.quaternion).multiplyScalar(n.scale.x);"
                    "return [v.x, v.y, v.z]; })()"
                )
            )
        wrench = joint_turn.wrench("bearing_in", "world")
        torsion = wrench.torsion[sample] * np.broadcast_to(wrench.axis, (721, 3))[sample]
        bending = wrench.bending_vector[sample]
        for tip, expected in zip(tips, (torsion, bending), strict=True):
            ratio = np.linalg.norm(tip) / np.linalg.norm(expected)
            np.testing.assert_allclose(np.array(tip) / ratio, expected, atol=1e-4 * greatest)
        assert np.linalg.norm(tips[0]) / np.linalg.norm(tips[1]) == pytest.approx(
            np.linalg.norm(torsion) / np.linalg.norm(bending), rel=1e-4
        )


@pytest.mark.slow
def test_served_page_is_the_exported_one(opened: Opener, joint_turn: cd.Sweep) -> None:
    with_url = cd.view(joint_turn)
    page = opened(with_url.url)
    assert share(page.picture(0.1), BLUE) > 0.004
    assert page.complaints == []
    assert page.requests == [with_url.url]
    with_url.close()
    # The page is complete: it goes on without its server.
    assert changed(page.picture(0.1), page.picture(0.3)) > 0.005


@pytest.mark.slow
def test_without_visuals_rods_and_axes_are_shown(opened: Opener, tmp_path: Path) -> None:
    from xml.etree import ElementTree

    from cardan_dyn.core.description.read import bundled_directory

    root = ElementTree.parse(bundled_directory() / "four_bar.urdf").getroot()
    for link in root.findall("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
    mechanism = cd.load(ElementTree.tostring(root, encoding="unicode"))
    page = opened(cd.view(usual_motion(mechanism).sweep()).export(tmp_path / "scene.html"))
    first, second = page.picture(0.0), page.picture(0.3)
    assert len(np.unique(first.reshape(-1, 3), axis=0)) > 300
    assert changed(first, second) > 0.002
    assert page.complaints == []


@pytest.mark.slow
def test_report_page_shows_both_scenes_offline(opened: Opener, tmp_path: Path) -> None:
    path = report.write(comparisons.run(), tmp_path)
    page = opened(path, scene=False)
    assert page.evaluate("document.querySelectorAll('iframe').length") == 2
    for index in (0, 1):
        page.evaluate(f"document.querySelectorAll('iframe')[{index}].scrollIntoView()")
        page.page.wait_for_function(
            f"document.querySelectorAll('iframe')[{index}].contentWindow.eval("
            "'typeof scene === \"object\" && scene.frames.count > 0')"
        )
        page.page.wait_for_timeout(300)
    assert page.complaints == []
    assert [url for url in page.requests if not url.startswith(("file:", "data:", "about:"))] == []
    # On a telephone its table is wider than the page.
    page.page.set_viewport_size({"width": 390, "height": 780})
    assert grave(page.page) == []


@pytest.mark.slow
def test_what_axe_finds_is_told_with_its_elements(opened: Opener, tmp_path: Path) -> None:
    """A page without flaws, and one with a button and a picture that have no names."""
    page = '<!DOCTYPE html><html lang="en"><title>t</title><main><h1>t</h1>{}</main></html>'
    bare, flawed = tmp_path / "bare.html", tmp_path / "flawed.html"
    bare.write_text(page.format(""))
    flawed.write_text(page.format('<button></button><img src="data:,">'))
    assert violations(opened(bare, scene=False).page) == []
    found = grave(opened(flawed, scene=False).page)
    assert {item.rule for item in found} == {"button-name", "image-alt"}
    assert all("<button" in item.elements[0] or "<img" in item.elements[0] for item in found)
