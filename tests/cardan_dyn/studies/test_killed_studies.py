"""The campaign of killed workers, schedulers and clients, in short."""

import subprocess
import sys
from pathlib import Path

import pytest

CAMPAIGN = Path(__file__).parents[2] / "campaigns" / "killed_studies.py"


@pytest.mark.slow
@pytest.mark.campaign
def test_a_study_that_was_killed_is_one_that_was_not() -> None:
    ran = subprocess.run(
        [sys.executable, str(CAMPAIGN), "--cases", "400"], capture_output=True, text=True
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert ran.stdout.count("killed the") == 3
    assert "no finished case was called again" in ran.stdout
    assert "byte for byte" in ran.stdout
