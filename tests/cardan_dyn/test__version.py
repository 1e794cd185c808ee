"""The version is one that installers understand, and the same wherever the project states it."""

from __future__ import annotations

from pathlib import Path

import pytest

import cardan_dyn as cd
from cardan_dyn._version import __version__

CITATION = Path(__file__).parents[2] / "CITATION.cff"


def test_the_version_has_three_numbers() -> None:
    numbers = __version__.split(".")
    assert len(numbers) == 3
    assert all(str(int(number)) == number for number in numbers)
    assert cd.__version__ is __version__


@pytest.mark.skipif(not CITATION.is_file(), reason="tests without the sources of the project")
def test_the_citation_states_the_version() -> None:
    assert f"\nversion: {__version__}\n" in CITATION.read_text(encoding="utf-8")
