"""The campaigns of killed workers, schedulers and clients, and of damaged stores, in short."""

import subprocess
import sys
from pathlib import Path

import pytest

CAMPAIGNS = Path(__file__).parents[2] / "campaigns"


def campaign(name: str, *words: str) -> subprocess.CompletedProcess[str]:
    words = (sys.executable, str(CAMPAIGNS / name), *words)
    ran = subprocess.run(words, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    return ran


@pytest.mark.slow
@pytest.mark.campaign
def test_a_study_that_was_killed_is_one_that_was_not() -> None:
    ran = campaign("killed_studies.py", "--cases", "400")
    assert ran.stdout.count("killed the") == 3
    assert "no finished case was called again" in ran.stdout
    assert "byte for byte" in ran.stdout


@pytest.mark.slow
@pytest.mark.campaign
def test_no_number_of_a_damaged_store_is_another_one_without_a_word() -> None:
    ran = campaign("damaged_studies.py", "--rounds", "100", "--seed", "7")
    assert "mended and said" in ran.stdout
    assert "refused to go on" in ran.stdout
    assert "no number was another one" in ran.stdout
