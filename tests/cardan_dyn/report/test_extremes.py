"""Extremes: where wrenches are greatest and least, against closed forms and dense sampling."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.core.results.wrench import JointWrench
from cardan_dyn.practice.report.extremes import Extreme, extremes
from cardan_dyn.scene.usual_motion import usual_motion

DENSE = 36_001


def by_name(sweep: cd.Sweep) -> Mapping[tuple[str, str], Extreme]:
    return {(item.owner, item.quantity): item for item in extremes(sweep).rows}


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
    assert torsion.determined and torsion.settled
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
    for item in extremes(sweep).rows:
        for places in (item.greatest_at, item.least_at):
            assert np.all((places >= 0.2) & (places <= 0.9))
    assert by_name(sweep)["crank_bearing", "torsion"].greatest_at[0, 0] in (0.2, 0.9)


def test_order_of_samples_makes_no_difference() -> None:
    turn = joint_turn(0.02)
    scene = cd.Scene(
        turn.mechanism, drive="bearing_in", held=dict(turn.held), loads=dict(turn.loads)
    )
    mixed = scene.sweep(np.random.default_rng(1).permutation(turn.position))
    for first, second in zip(extremes(turn).rows, extremes(mixed).rows, strict=True):
        scale = 1e-12 * first.size
        assert first.greatest == pytest.approx(second.greatest, rel=1e-12)
        assert first.least == pytest.approx(second.least, rel=1e-12, abs=scale)
        assert np.allclose(first.greatest_at, second.greatest_at, atol=1e-7)


@pytest.mark.parametrize("samples", [2, 3, 8])
def test_few_samples_stand_for_their_range(samples: int) -> None:
    """A slider-crank whose efforts vanish at all samples but swing to ±47 N·m between them."""
    scene = cd.Scene(cd.load("slider_crank"), drive="crank_bearing", loads={"piston_guide": -1e3})
    few = by_name(scene.sweep(np.linspace(0.0, 2.0 * np.pi, samples)))
    # The closed form of the lever of the piston force: r (sin φ + sin 2φ / 2 √(q² − sin² φ)).
    dense = scene.response().uniform(2**18)
    effort = few["crank_bearing", "drive effort"]
    assert effort.greatest == pytest.approx(dense.drive_effort.max(), rel=1e-9)
    assert effort.least == pytest.approx(dense.drive_effort.min(), rel=1e-9)
    shear = few["crank_pin", "shear"]
    assert shear.greatest == pytest.approx(dense["crank_pin"].shear.max(), rel=1e-9)
    assert shear.settled and effort.settled


def test_a_range_of_many_turns_is_that_of_a_period() -> None:
    turns = joint_turn(0.0, samples=7)
    scene = cd.Scene(
        turns.mechanism, drive="bearing_in", held=dict(turns.held), loads=dict(turns.loads)
    )
    many = extremes(scene.sweep(np.linspace(0.0, 2000.0 * np.pi, 9)))
    assert many.search is not None and not many.unknown
    assert many.search.ends == (0.0, pytest.approx(2.0 * np.pi))
    item = next(row for row in many.rows if row.quantity == "torsion")
    assert item.greatest == pytest.approx(100.0 / np.cos(0.6), rel=1e-12)


def test_friction_that_changes_its_sign_is_followed_to_both_sides() -> None:
    """Within 1e-6 rad the friction of the shaft's brake jumps from one torque to the other."""
    scene = cd.Scene(
        cd.load("slider_crank"),
        drive="crank_bearing",
        elements=[cd.JointFriction("piston_guide", 100.0, 1e-6)],
    )
    sweep = scene.sweep(np.linspace(0.1, 6.0, 5), speed=2.0)
    rub = by_name(sweep)["piston_guide", "axial"]
    assert rub.settled
    element = by_name(sweep)["elements[0]", "effort"]
    assert (element.greatest, element.least) == pytest.approx((100.0, -100.0), rel=1e-6)
    assert element.settled


@pytest.mark.parametrize("what", ["speed", "acceleration", "loads", "held", "gravity"])
def test_what_varies_is_told_at_the_samples(what: str) -> None:
    scene = cd.Scene(
        cd.load("universal_joint"),
        drive="bearing_in",
        held={"joint_angle": 0.6},
        loads={"bearing_out": -100.0},
        gravity=(0.0, 0.0, -9.81),
    )
    angles = np.linspace(0.0, 2.0 * np.pi, 50)
    change = np.linspace(1.0, 2.0, 50)
    given = {
        "speed": {"speed": change},
        "acceleration": {"acceleration": change},
        "loads": {"loads": {"bearing_out": -100.0 * change}},
        "held": {"held": {"joint_angle": 0.3 * change}},
        "gravity": {"gravity": change[:, None] * np.array([0.0, 0.0, -9.81])},
    }[what]
    sweep = scene.sweep(angles, **given)  # type: ignore[arg-type]
    found = extremes(sweep)
    assert what in found.covered and "the 50 samples, as" in found.covered and not found.unknown
    item = next(row for row in found.rows if row.quantity == "torsion")
    torsion = sweep["bearing_in"].torsion
    assert item.settled and np.isnan(item.error)
    assert item.greatest == torsion.max() and item.greatest_at[0, 0] == angles[torsion.argmax()]
    assert item.least == torsion.min()


@pytest.mark.slow
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_what_does_not_settle_is_in_doubt(side: float) -> None:
    """Values that differ each time that they are asked for, the great ones or the small ones."""
    sweep = joint_turn(0.0, samples=9)
    noise = np.random.default_rng(1)
    original = JointWrench.torsion

    class Noisy:
        def __get__(self, item: Any, _: Any = None) -> np.ndarray:
            values = np.asarray(original.__get__(item))
            rough = 1e-3 * noise.standard_normal(values.shape)
            return values * (1.0 + np.where(side * values > side * 100.0, rough, 0.0))

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(JointWrench, "torsion", Noisy())
        found = extremes(sweep)
    assert "torsion" in found.unknown and "does not settle" in found.unknown
    rows = {(row.owner, row.quantity): row for row in found.rows}
    assert not rows["bearing_in", "torsion"].settled and rows["bearing_in", "bending"].settled


def test_positions_that_cannot_be_solved_leave_doubt(monkeypatch: pytest.MonkeyPatch) -> None:
    sweep = joint_turn(0.0, samples=9)

    def refused(*_: object, **__: object) -> cd.Sweep:
        raise cd.CardanError("not there")

    monkeypatch.setattr(cd.Scene, "sweep", refused)
    found = extremes(sweep)
    assert "cannot be solved: not there" in found.unknown
    assert not any(row.settled for row in found.rows if row.quantity == "torsion")


def test_several_drives_and_a_single_sample() -> None:
    scene = usual_motion(cd.load("stewart_platform"), samples=25)
    sweep = scene.sweep()
    found = extremes(sweep)
    assert "25 samples, as several drives" in found.covered
    for item in found.rows:
        for place in item.greatest_at:
            assert np.any(np.all(sweep.position == place, axis=1))
    effort = by_name(sweep)["leg_3", "drive effort"]
    assert effort.unit == "N" and effort.greatest == sweep.drive_effort[:, 2].max()
    one = cd.Scene(cd.load("four_bar"), drive="crank_bearing", loads={"rocker_bearing": 1.0})
    item = by_name(one.sweep(0.3))["crank_pin", "shear"]
    assert item.greatest == item.least > 0.0 and item.settled


def test_solves_few_positions(monkeypatch: pytest.MonkeyPatch) -> None:
    """Batches for all joints and quantities together."""
    sweep, calls = joint_turn(0.0123), []
    original = cd.Scene.sweep

    def counted(self: cd.Scene, *given: object, **named: object) -> cd.Sweep:
        found = original(self, *given, **named)  # type: ignore[arg-type]
        calls.append(len(found))
        return found

    monkeypatch.setattr(cd.Scene, "sweep", counted)
    extremes(sweep)
    assert len(calls) <= 12 and sum(calls) < 1200


def test_figures_show_the_range_however_few_its_samples() -> None:
    scene = cd.Scene(cd.load("slider_crank"), drive="crank_bearing", loads={"piston_guide": -1.0})
    few = cd.Report(scene.sweep(np.linspace(0.0, 2.0 * np.pi, 3)))
    drawn, told = few.drawn
    (top,) = [item for item in few.extremes if item.quantity == "drive effort"]
    assert told == ""
    # The table and the curve have one greatest value, at one place.
    assert drawn.drive_effort.max() == pytest.approx(top.greatest, rel=1e-12)
    assert drawn.position[drawn.drive_effort.argmax()] in top.greatest_at
    assert drawn.position[[0, -1]] == pytest.approx([0.0, 2.0 * np.pi])
    varied = cd.Report(scene.sweep(np.linspace(0.0, 2.0 * np.pi, 3), speed=[0.0, 1.0, 2.0]))
    assert varied.drawn == (varied.sweep, " Of the 3 samples alone.")


def test_a_function_of_the_users_is_in_doubt() -> None:
    """No number of positions tells that it is nothing else in between."""
    pump = cd.Actuator("bearing_out", lambda angle: -5.0 + 0.0 * angle, of="position")
    scene = cd.Scene(
        cd.load("universal_joint"), drive="bearing_in", held={"joint_angle": 0.4}, elements=[pump]
    )
    report = cd.Report(scene.sweep(np.linspace(0.0, 2.0 * np.pi, 9)))
    assert any("'bearing_out' is a function of yours" in doubt for doubt in report.doubts)
