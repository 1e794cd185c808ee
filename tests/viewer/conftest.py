from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.validation import comparisons

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
OPTIONS = (
    *("--no-sandbox", "--disable-quic", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync", "--no-first-run"),
    *("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
)


@pytest.fixture(scope="session")
def joint_turn() -> cd.Sweep:
    return comparisons.universal_joint_turn(cd.load("universal_joint"), float(np.deg2rad(50.0)))


@pytest.fixture(scope="session")
def shaft_turn() -> cd.Sweep:
    return comparisons.double_shaft_turn(cd.load("double_shaft_z"), float(np.deg2rad(30.0)))


@dataclass
class Page:
    """A scene in a real browser, its animation stopped."""

    page: object
    complaints: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def evaluate(self, script: str) -> object:
        return self.page.evaluate(script)

    def picture(self, moment: float) -> np.ndarray:
        """Pixels `(h, w, 3)` at a fraction of the animation."""
        import io

        from PIL import Image

        self.evaluate(f"viewer.animator.seek({moment} * viewer.animator.duration); viewer.render()")
        self.evaluate("new Promise((done) => requestAnimationFrame(() => setTimeout(done, 50)))")
        image = Image.open(io.BytesIO(self.page.screenshot()))
        return np.asarray(image.convert("RGB")).astype(int)


@pytest.fixture(scope="session")
def browser() -> Iterator[object]:
    sync_api = pytest.importorskip(
        "playwright.sync_api",
        reason="SKIPPED IN A BROWSER: scenes are not rendered without playwright "
        '(pip install "cardan-dyn[test]")',
    )
    found = os.environ.get("CHROMIUM") or next(
        (path for name in BROWSERS if (path := shutil.which(name))), None
    )
    if found is None:
        pytest.skip(
            "SKIPPED IN A BROWSER: scenes are not rendered, as none of "
            f"{', '.join(BROWSERS)} is installed (Debian: apt-get install chromium)"
        )
    with sync_api.sync_playwright() as driver:
        running = driver.chromium.launch(executable_path=found, args=list(OPTIONS))
        yield running
        running.close()


@pytest.fixture
def opened(browser: object) -> Iterator[Callable[[str], Page]]:
    pages = []

    def open_page(address: str | Path, scene: bool = True) -> Page:
        page = browser.new_page(viewport={"width": 1200, "height": 760})
        shown = Page(page)
        pages.append(page)
        page.on("console", lambda item: shown.complaints.append(f"{item.type}: {item.text}"))
        page.on("pageerror", lambda error: shown.complaints.append(str(error)))
        page.on("request", lambda request: shown.requests.append(request.url))
        page.goto(address.as_uri() if isinstance(address, Path) else address)
        if scene:
            page.wait_for_function("viewer.animator.playing")
            page.evaluate("viewer.animator.pause()")
        return shown

    yield open_page
    for page in pages:
        page.close()
