"""What axe, the checker of the web accessibility guidelines, finds on a page."""

from __future__ import annotations

from functools import cache
from importlib import resources
from typing import Any, NamedTuple

import pytest

GRAVE = frozenset({"serious", "critical"})


class Violation(NamedTuple):
    """A rule that a page breaks: its name, how grave that is, and the elements that break it."""

    rule: str
    impact: str
    elements: tuple[str, ...]


def violations(page: Any) -> list[Violation]:
    """Return what axe finds on a Playwright page that is open; `grave` keeps what must not be.

    The page must have its final state: animations, transitions and dialogs change contrasts.
    """
    page.evaluate(_axe())
    found = page.evaluate("axe.run(document, {resultTypes: ['violations']})")["violations"]
    return [
        Violation(
            item["id"],
            item["impact"],
            tuple(f"{node['target']}: {node['html']}" for node in item["nodes"]),
        )
        for item in found
    ]


def grave(page: Any) -> list[Violation]:
    """Return the serious and critical violations of a page."""
    return [item for item in violations(page) if item.impact in GRAVE]


@cache
def _axe() -> str:
    """Return the script of axe; the test that needs it is skipped if it is not installed."""
    package = pytest.importorskip(
        "axe_playwright_python",
        reason='SKIPPED: pages are not checked without axe (pip install "cardan-dyn[test]")',
    )
    return resources.files(package).joinpath("axe.min.js").read_text(encoding="utf-8")
