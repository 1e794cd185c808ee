"""Broken descriptions and wrong arguments end in an error of the package or in a proven result."""

from __future__ import annotations

import pytest
from harness import run


@pytest.mark.slow
@pytest.mark.parametrize("family", ["descriptions", "arguments"])
def test_nothing_else_comes_of_it(family: str) -> None:
    outcome = run(family, start=0, count=300)
    assert sum(outcome.outcomes.values()) == 300
    assert not outcome.findings, str(outcome)


@pytest.mark.slow
def test_cases_get_past_the_first_check() -> None:
    """A harness whose cases are all refused at once would prove nothing."""
    outcome = run("descriptions", start=1000, count=100)
    assert outcome.outcomes["proven"] >= 10, str(outcome)
