"""A headless browser in which tests look at pages."""

from __future__ import annotations

import io
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
OPTIONS = (
    *("--no-sandbox", "--disable-quic", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync", "--no-first-run"),
    *("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
)


@dataclass
class Page:
    """A scene in a real browser, its animation stopped."""

    page: Any
    complaints: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def evaluate(self, script: str) -> Any:
        return self.page.evaluate(script)

    def seek(self, moment: float) -> None:
        """Show the moment at a fraction of the course."""
        self.evaluate(f"scene.seek({moment})")
        self.page.wait_for_function("scene.settled")

    def picture(self, moment: float) -> np.ndarray:
        """Pixels `(h, w, 3)` at a fraction of the animation."""
        from PIL import Image

        self.seek(moment)
        image = Image.open(io.BytesIO(self.page.screenshot()))
        return np.asarray(image.convert("RGB")).astype(int)


@contextmanager
def running_browser() -> Iterator[Any]:
    """Run a browser; the test that needs it is skipped if there is none."""
    sync_api = pytest.importorskip(
        "playwright.sync_api",
        reason="SKIPPED IN A BROWSER: scenes are not rendered without playwright "
        '(pip install "cardan-dyn[test]")',
    )
    executable = os.environ.get("CHROMIUM") or next(
        (path for name in BROWSERS if (path := shutil.which(name))), None
    )
    if executable is None:
        pytest.skip(
            "SKIPPED IN A BROWSER: scenes are not rendered, as none of "
            f"{', '.join(BROWSERS)} is installed (Debian: apt-get install chromium)"
        )
    with sync_api.sync_playwright() as driver:
        running = driver.chromium.launch(executable_path=executable, args=list(OPTIONS))
        yield running
        running.close()


def open_page(
    browser: Any,
    address: str | Path,
    scene: bool = True,
    *,
    size: tuple[int, int] = (1200, 760),
    theme: str = "light",
) -> Page:
    """Open a page, and stop its animation if it is a scene.

    Args:
        browser: that runs.
        address: of the page.
        scene: whether it is a scene.
        size: of the window [pixels].
        theme: `light` or `dark`, as the system would prefer it.
    """
    width, height = size
    page = browser.new_page(viewport={"width": width, "height": height}, color_scheme=theme)
    shown = Page(page)
    page.on("console", lambda item: shown.complaints.append(f"{item.type}: {item.text}"))
    page.on("pageerror", lambda error: shown.complaints.append(str(error)))
    page.on("request", lambda request: shown.requests.append(request.url))
    page.goto(address.as_uri() if isinstance(address, Path) else address)
    if scene:
        page.wait_for_function("window.scene && scene.frames.count > 0")
        page.evaluate("scene.pause()")
    return shown
