"""Samples of campaigns that no other test runs, and the runner of all of them."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import contacts
import free_rotations
import long_swings
import pytest
import separatrices


@pytest.fixture(scope="module")
def runner() -> ModuleType:
    # By its path: other directories have a module of this name.
    found = importlib.util.spec_from_file_location("oracle_run", Path(__file__).parent / "run.py")
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_motions_close_to_separatrices(seed: int) -> None:
    assert separatrices.ask(seed)[0] == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", [*range(20), 40064])  # The last one swings by 6e-6 rad.
def test_long_swings_and_events_of_many_zeros(seed: int) -> None:
    assert long_swings.ask(seed)[0] == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_free_rotations(seed: int) -> None:
    assert free_rotations.ask(seed)[0] == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 7, 9, 10])
def test_energy_of_contacts(seed: int) -> None:
    assert contacts.ask(seed)[0] == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ["chains", "turned", "similar", "cut", "wound", "near_singular"])
def test_campaigns_by_name(runner: ModuleType, name: str, capsys) -> None:
    assert runner.main([name, "--seeds", "1", "--start", "2"]) == 0
    assert "0 of 1 seeds failed" in capsys.readouterr().out


def test_whatever_is_wrong_fails_a_campaign(runner: ModuleType, capsys, monkeypatch) -> None:
    def ask(seed: int) -> tuple[list[str], list[str]]:
        if seed == 3:
            raise ValueError("no such thing")
        return [f"off by 1.{seed}e-3"] * (seed % 2), ["odd"] * (seed % 2)

    monkeypatch.setitem(runner.CAMPAIGNS, "chains", runner.Campaign("nothing", ask))
    assert runner.main(["chains", "--seeds", "6"]) == 1
    out = capsys.readouterr().out
    assert "3 of 6 seeds failed" in out and "2  off by: [1, 5]" in out
    assert "ValueError (test_campaigns:" in out and "odd: 2, 2" in out
