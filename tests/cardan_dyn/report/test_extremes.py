"""Extremes: where wrenches are greatest and least, against closed forms and dense sampling."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.report.extremes import Extreme, extremes
from cardan_dyn.scene.usual_motion import usual_motion

DENSE = 36_001


def by_name(sweep: cd.Sweep) -> Mapping[tuple[str, str], Extreme]:
    return {(item.owner, item.quantity): item for item in extremes(sweep)}


def joint_turn(start: float, samples: int = 97, beta: float = 0.6) -> cd.Sweep:
    scene = cd.Scene(
        cd.load("universal_joint"),
        drive="bearing_in",
        held={"joint_angle": beta},
        loads={"bearing_out": -100.0},
    )
    return scene.sweep(np.linspace(start, start + 2.0 * np.pi, samples))


@pytest.mark.parametrize("start", [0.0, 0.0123])
def test_universal_joint_against_its_closed_forms(start: float) -> None:
    """Torsion M₂ cos β … M₂/cos β, bending M₂ sin β and M₂ tan β, both shafts across the fork."""
    beta, found = 0.6, by_name(joint_turn(start))
    torsion = found["bearing_in", "torsion"]
    assert torsion.greatest == pytest.approx(100.0 / np.cos(beta), rel=1e-13)
    assert torsion.least == pytest.approx(100.0 * np.cos(beta), rel=1e-13)
    places = torsion.greatest_at.ravel() / np.pi
    assert np.allclose(places, np.round(places), atol=1e-7) and len(places) == 2
    assert np.allclose(torsion.least_at.ravel() / np.pi % 1.0, 0.5, atol=1e-7)
    assert found["bearing_in", "bending"].greatest == pytest.approx(100 * np.sin(beta), rel=1e-13)
    assert found["bearing_out", "bending"].greatest == pytest.approx(100 * np.tan(beta), rel=1e-13)
    for name in ("bearing_in", "bearing_out"):
        assert found[name, "bending"].least == pytest.approx(0.0, abs=1e-5)
    out = found["bearing_out", "torsion"]
    assert out.greatest == out.least == pytest.approx(-100.0) and not len(out.greatest_at)
    assert found["bearing_in", "drive effort"].greatest == pytest.approx(torsion.greatest)
    assert torsion.determined and torsion.located
    assert not found["bearing_in", "force"].determined
    assert not found["bearing_in", "force"].acts


@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "needle_drive", "thoma_rig"])
def test_against_dense_sampling(name: str) -> None:
    """A response evaluated every hundredth of a degree knows nothing of the search."""
    sweep = usual_motion(cd.load(name), samples=91).sweep()
    scene = cd.Scene(
        sweep.mechanism, drive=sweep.drives[0], held=dict(sweep.held), loads=dict(sweep.loads)
    )
    angles = np.linspace(0.0, 2.0 * np.pi, DENSE)
    dense = scene.response().sweep(angles, speed=float(np.ravel(sweep.speed)[0]))
    found = by_name(sweep)
    for joint, wrench in dense.items():
        sizes = {
            "force": np.linalg.norm(wrench.force, axis=-1),
            "axial": wrench.axial,
            "shear": wrench.shear,
            "torsion": wrench.torsion,
            "bending": wrench.bending,
        }
        for quantity, values in sizes.items():
            item = found[joint, quantity]
            scale = 1e-9 * max(float(np.max(np.abs(each))) for each in sizes.values()) + 1e-9
            # Beyond every sample, and by no more than a parabola through the samples is.
            slack = float(np.max(np.abs(np.diff(values, 2)))) + scale
            assert -scale <= item.greatest - values.max() <= slack, (joint, quantity)
            assert -scale <= values.min() - item.least <= slack, (joint, quantity)
            for place in item.greatest_at.ravel():
                nearest = round(place / angles[1])
                assert values[nearest] == pytest.approx(
                    item.greatest, abs=slack + 4 * scale + _steep(values)
                )


def _steep(values: np.ndarray) -> float:
    """By how much neighbours differ."""
    return float(np.max(np.abs(np.diff(values))))


def test_open_turn_reaches_its_end() -> None:
    """The greatest value lies between the last sample and the first one of the next turn."""
    sweep = joint_turn(0.01)
    scene = cd.Scene(
        sweep.mechanism, drive="bearing_in", held=dict(sweep.held), loads=dict(sweep.loads)
    )
    open_turn = scene.sweep(0.01 + np.arange(96) * 2.0 * np.pi / 96)
    closed, opened = by_name(sweep), by_name(open_turn)
    for key, item in closed.items():
        assert opened[key].greatest == pytest.approx(item.greatest, rel=1e-12, abs=1e-9)
        assert opened[key].least == pytest.approx(item.least, rel=1e-12, abs=1e-5)


def test_range_stays_within_its_ends() -> None:
    scene = cd.Scene(cd.load("slider_crank"), drive="crank_bearing", loads={"piston_guide": -1e3})
    sweep = scene.sweep(np.linspace(0.2, 0.9, 30))
    for item in extremes(sweep):
        for places in (item.greatest_at, item.least_at):
            assert np.all((places >= 0.2) & (places <= 0.9))
    assert by_name(sweep)["crank_bearing", "torsion"].greatest_at[0, 0] in (0.2, 0.9)


def test_order_of_samples_makes_no_difference() -> None:
    turn = joint_turn(0.02)
    scene = cd.Scene(
        turn.mechanism, drive="bearing_in", held=dict(turn.held), loads=dict(turn.loads)
    )
    mixed = scene.sweep(np.random.default_rng(1).permutation(turn.position))
    for first, second in zip(extremes(turn), extremes(mixed), strict=True):
        assert first.greatest == second.greatest and first.least == second.least
        assert np.array_equal(first.greatest_at, second.greatest_at)


def test_samples_count_where_what_acts_varies() -> None:
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", loads={"rocker_bearing": 1.0})
    angles = np.linspace(0.0, 2.0 * np.pi, 50)
    loads = {"rocker_bearing": np.linspace(-40.0, 60.0, 50)}
    sweep = scene.sweep(angles, loads=loads)
    item = by_name(sweep)["rocker_pin", "force"]
    size = np.linalg.norm(sweep["rocker_pin"].force, axis=1)
    assert not item.located
    assert item.greatest == size.max() and item.greatest_at[0, 0] == angles[size.argmax()]
    assert item.least == size.min()


def test_several_drives_and_a_single_sample() -> None:
    sweep = usual_motion(cd.load("stewart_platform"), samples=25).sweep()
    for item in extremes(sweep):
        assert not item.located
        for place in item.greatest_at:
            assert np.any(np.all(sweep.position == place, axis=1))
    effort = by_name(sweep)["leg_3", "drive effort"]
    assert effort.unit == "N" and effort.greatest == sweep.drive_effort[:, 2].max()
    one = cd.Scene(cd.load("four_bar"), drive="crank_bearing", loads={"rocker_bearing": 1.0})
    item = by_name(one.sweep(0.3))["crank_pin", "shear"]
    assert item.greatest == item.least > 0.0


def test_solves_few_positions(monkeypatch: pytest.MonkeyPatch) -> None:
    """A batch for each step of the search, not a solution for every joint and quantity."""
    sweep, calls = joint_turn(0.0123), []
    original = cd.Scene.sweep

    def counted(self: cd.Scene, *given: object, **named: object) -> cd.Sweep:
        found = original(self, *given, **named)  # type: ignore[arg-type]
        calls.append(len(found))
        return found

    monkeypatch.setattr(cd.Scene, "sweep", counted)
    extremes(sweep)
    assert len(calls) <= 72 and sum(calls) < 72 * 120
