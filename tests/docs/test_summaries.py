"""What a person acts on: every summary of a result is in the table, with a test that there is."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import cardan_dyn

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "summaries.md").read_text(encoding="utf-8")
ROOMS = (
    *("core/results", "core/response", "scene", "motion/simulation", "motion/vibration/results"),
    *("motion/clearance", "practice/drive_lines", "practice/report", "practice/studies"),
)
WORDS = frozenset(
    {
        *("peak", "peaks", "worst", "best", "passed", "failed"),
        *("open", "severity", "greatest", "least", "lower", "upper"),
        *("verdict", "summary", "ranking", "margin", "extremes", "status"),
    }
)
"""A name that has one of these words tells a summary."""
STEPS = frozenset(
    {
        *("Case", "Causes", "Continuity", "Convergence", "Entry", "Estimates"),
        *("ForceCourse", "Group", "Judged", "LineReport", "Passages"),
        *("PlanarModel", "PlanarMotion", "Resonance", "Store", "Surroundings", "Swing"),
        *("Touch", "BearingForces"),
    }
)
"""Classes on the way to results, which users do not get to see."""


def summaries() -> Iterator[str]:
    """Yield the summaries of all classes of results."""
    package = Path(cardan_dyn.__file__).parent
    for path in sorted(path for room in ROOMS for path in (package / room).rglob("*.py")):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if not isinstance(node, ast.ClassDef) or node.name in STEPS:
                continue
            for part in node.body:
                name = ""
                if isinstance(part, ast.FunctionDef):
                    name = part.name
                elif isinstance(part, ast.AnnAssign) and isinstance(part.target, ast.Name):
                    name = part.target.id
                words = WORDS.intersection(name.split("_"))
                if words and not (node.name.startswith("_") or name.startswith("_")):
                    yield f"{node.name}.{name}"


@pytest.mark.parametrize("summary", [*summaries()])
def test_a_summary_is_in_the_table(summary: str) -> None:
    assert f"`{summary}`" in PAGE


@pytest.mark.slow
def test_all_that_is_in_the_table_is_there() -> None:
    there = {*summaries()}
    told = set(re.findall(r"`([A-Z]\w+\.\w+)`", PAGE))
    words = {name for name in told if WORDS.intersection(name.partition(".")[2].split("_"))}
    assert words <= there


@pytest.mark.parametrize("test", sorted({*re.findall(r"`(tests/[\w/.:]+)`", PAGE)}))
def test_what_holds_a_summary_is_a_test(test: str) -> None:
    path, _, name = test.partition("::")
    text = (ROOT / path).read_text(encoding="utf-8")
    assert re.search(rf"^def {name or 'test_'}", text, re.MULTILINE)
