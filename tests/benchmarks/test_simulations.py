"""Benchmarks of simulations: the exact references, our errors, and complete records."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mpmath")

from scipy.integrate import quad

import cardan_dyn as cd
from benchmarks import (
    four_bars,
    free_spin,
    hammering,
    long_time,
    stability_charts,
    stress_simulation,
    thousand_periods,
)
from benchmarks.engines import spinning
from benchmarks.records import Record
from benchmarks.spin import CROSS, SHAFT, SPEED, description, spin

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("beta_deg", [30.0, 80.0])
@pytest.mark.parametrize("ratio", [1.0, 1e3])
def test_exact_duration_is_the_integral_of_a_reaction_free_sweep(
    beta_deg: float, ratio: float
) -> None:
    """The inertia along the drive, by inverse dynamics of a sweep, gives the same time."""
    beta = float(np.deg2rad(beta_deg))
    task = spin(beta, shaft=ratio)
    scene = cd.Scene(cd.load(description(beta, shaft=ratio)), drive="bearing_in")
    count = 4096
    positions = 2.0 * np.pi * np.arange(count) / count
    inertia = scene.sweep(positions, acceleration=1.0).drive_effort
    revolution = 2.0 * np.pi * np.mean(np.sqrt(inertia / inertia[0])) / SPEED
    assert task.duration == pytest.approx(10.0 * revolution, rel=1e-12)
    assert task.end == pytest.approx(20.0 * np.pi, abs=1e-13)


def test_energy_at_the_start_is_that_of_the_closed_form() -> None:
    beta = 0.6
    speeds = spin(beta).start_speeds
    scene = cd.Scene(cd.load(description(beta)), free="bearing_in")
    start = scene.simulate(0.1, speed=SPEED)
    energy = 0.5 * SHAFT * (speeds[0] ** 2 + speeds[2] ** 2)
    energy += 0.5 * CROSS * (speeds[0] ** 2 + speeds[1] ** 2)
    assert start.kinetic_energy[0] == pytest.approx(energy, rel=1e-13)


@pytest.mark.campaign
def test_our_spins_are_exact() -> None:
    methods = [replace(method, levels=method.levels[:2]) for method in free_spin.library()]
    records = free_spin.measure(fast=True, candidates=methods)
    assert {record.method for record in records} == {method.name for method in methods}
    bounds = {"rtol 0.0001": 0.05, "rtol 1e-06": 1e-3, "rtol 1e-10": 1e-12}
    for record in records:
        assert record.error is not None
        assert record.error < bounds[record.parameters["level"]], record
        assert record.ratio and record.microseconds
    assert free_spin.table(records).count("\n") == 1 + 2 * len(methods)
    assert "No other engine" in free_spin.answer(records)


@pytest.mark.filterwarnings("ignore")  # Other packages' warnings are theirs.
def test_engines_that_are_installed_converge() -> None:
    """From 60 to 600 steps or from 1e-4 to 1e-8 the error falls; fixed defaults do not."""
    task = spin(0.5, revolutions=2)
    for method in spinning.spinners():
        if "defaults" in method.name:
            continue
        coarse, fine = method.levels[0], method.levels[2]
        errors = [abs(method.prepare(task, level)() - task.end) for level in (coarse, fine)]
        assert errors[1] < 0.5 * errors[0], (method.name, errors)
        assert errors[1] < 0.1, (method.name, errors)


def test_a_row_of_others_that_is_in_front_is_named(tmp_path: Path) -> None:
    def row(method: str, error: float | None, ratio: float | None) -> Record:
        parameters = {"beta_deg": 30.0, "level": "rtol 1"}
        return Record("free_spin", method, parameters=parameters, error=error, ratio=ratio)

    records = [
        row("cardan_dyn a", 1e-9, 100.0),
        row("quick", 1e-3, 10.0),
        row("slow", 1e-3, 200.0),
        row("exact", 1e-12, 1e5),
        row("lost", 3.0, 1.0),
        row("failed", None, None),
    ]
    found = free_spin.in_front(records)
    assert [sentence.split()[3] for sentence in found] == ["quick", "exact"]
    assert "10 times faster" in found[0] and "fails" in free_spin.table(records)
    free_spin.picture(records, tmp_path / "spin.png")
    assert (tmp_path / "spin.png").stat().st_size < 150_000


def test_the_pendulum_of_the_four_bars_takes_its_time() -> None:
    rods = 3
    inertia, moment = (rods + 1) / 3 + rods, four_bars.GRAVITY * ((rods + 1) / 2 + rods)
    # With sin(φ/2) = sin(60°/2) sin u, the integral over a quarter of a swing is regular.
    part = np.sin(0.5 * four_bars.START)
    quarter, _ = quad(lambda u: 1.0 / np.sqrt(1.0 - (part * np.sin(u)) ** 2), 0.0, 0.5 * np.pi)
    expected = 21.0 * np.sqrt(inertia / moment) * quarter
    assert four_bars.duration(rods) == pytest.approx(expected, rel=1e-12)


def test_four_bars_swing_as_a_pendulum() -> None:
    records = [r for r in four_bars.measure(fast=True, others=False) if r.error is not None]
    assert {record.parameters["loops"] for record in records} == {1, 2, 4}
    bounds = {"cardan_dyn DOP853, rtol 1e-06": 1e-3, "cardan_dyn DOP853, rtol 1e-10": 1e-7}
    for record in records:
        bound = bounds.get(record.method, 1e-10)
        assert record.error is not None and record.error < bound, record
        assert record.parameters["energy"] < bound, record
        assert record.ratio
    assert "4; error up to" in four_bars.answer(records)


def test_long_spins_stay_closed() -> None:
    for record in long_time.measure(fast=True, others=False):
        assert record.parameters["closure"] < 1e-14
        assert record.parameters["energy"] < 1e-6
        assert record.error is not None and record.error < 1e-5
        assert "10 revolutions" in long_time.answer([record])


CORNERS = {
    "joint angle [°]": (0.5, 80.0),
    "inertia ratio": (1e-6, 1e6),
    "speed [rad/s]": (1e-3, 1e5),
    "length ratio": (1e-3, 1e3),
}


@pytest.fixture(scope="module")
def corners() -> list[Record]:
    return stress_simulation.points(CORNERS)


def test_corners_of_the_maps_keep_closure_and_energy(corners: list[Record]) -> None:
    assert len(corners) == 16
    for record in corners:
        found = record.parameters
        assert "refused" not in found, record
        assert found["closure"] < 1e-13, record
        assert found["energy"] < (1e-12 if found["used"] == "quadrature" else 1e-8), record
        assert record.error is None or record.error < 1e-7, record


def test_maps_have_a_table_a_picture_and_an_answer(corners: list[Record], tmp_path: Path) -> None:
    refused = Record(
        "stress_simulation",
        "DOP853",
        parameters={"map": "length ratio", "parameter": 1e9, "refused": "AssemblyError"},
    )
    records = [*corners, refused]
    assert "AssemblyError" in stress_simulation.table(records)
    assert "refused: 1e+09." in stress_simulation.answer(records)
    stress_simulation.picture(records, tmp_path / "map.png")
    assert (tmp_path / "map.png").stat().st_size < 150_000


def test_energy_of_other_chains_is_kept() -> None:
    records = thousand_periods.measure(fast=True)
    assert len(records) == 4
    for record in records:
        assert record.parameters["energy"] < 3e-10
        assert record.parameters["closure"] < 1e-14
    assert "Bennett" in thousand_periods.answer(records)


@pytest.mark.campaign
def test_hammering_is_timed_and_its_peaks_converge() -> None:
    records = hammering.measure(fast=True)
    scan, *simulated = records
    assert scan.ratio and scan.parameters["seconds"] > 0.0
    coarse, fine = simulated
    assert coarse.error is not None and fine.error is not None
    assert fine.error < 1e-5 and fine.error < coarse.error < 1e-2
    assert "needle" in (hammering.__doc__ or "") and "R;" in hammering.answer(records)


@pytest.mark.campaign
def test_charts_of_stability_are_timed_and_exact() -> None:
    records = stability_charts.measure(fast=True)
    assert len(records) == 3
    first = records[0]
    assert first.method == "one elastic shaft"
    assert first.error is not None and first.error < 1e-11
    assert all(record.ratio and record.parameters["unstable"] < 32 for record in records)
    # At 45° the tilting shaft has speeds at which its motion is larger than can be computed.
    assert [record.parameters["without motion"] for record in records[:2]] == [0, 0]
    assert "8 speeds at 4 angles" in stability_charts.answer(records)
