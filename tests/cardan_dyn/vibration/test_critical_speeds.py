"""Tables of critical speeds."""

from __future__ import annotations

import copy
import pickle
from dataclasses import replace
from pathlib import Path

import half_power
import numpy as np
import pytest
from half_power import DrivenRig
from resonant_rigs import differences, stiffening
from testkit import elastic_rigs

import cardan_dyn as cd
from cardan_dyn import ArgumentError, vibration
from cardan_dyn.motion.vibration.motions import continuation
from cardan_dyn.vibration import CriticalSpeeds

PER_MINUTE = 30.0 / np.pi


@pytest.fixture(scope="module")
def rig() -> CriticalSpeeds:
    scene = elastic_rigs.scene(elastic_rigs.elastic_rig(), np.radians(5.0))
    return vibration.critical_speeds(scene, [0.2, 0.6], instabilities=False)


@pytest.mark.slow
def test_orders_two_and_four_of_thomas_rig(rig: CriticalSpeeds) -> None:
    rows = {(row.order, row.whirl): row for row in rig}
    for order, whirl, speed, size in (
        (2.0, "forward", 0.51303, 2.13018e-4),
        (2.0, "backward", 0.48789, 2.03884e-4),
        (4.0, "forward", 0.25320, 5.2991e-5),
    ):
        row = rows[order, whirl]
        assert row.speed == pytest.approx(speed, rel=1e-3)
        assert row.severity == pytest.approx(size, rel=5e-3)
        assert row.amplification == pytest.approx(50.0, rel=1e-2)
        assert row.frequency == pytest.approx(order * row.speed, rel=1e-3)
    assert rows[4.0, "backward"].severity < 0.01 * rows[4.0, "forward"].severity


@pytest.mark.slow
@pytest.mark.parametrize("polar", [0.01])
def test_half_and_quarter_of_the_natural_frequency(polar: float) -> None:
    """Thoma's conclusion, where the shaft has hardly a gyroscopic effect."""
    scene = elastic_rigs.scene(elastic_rigs.elastic_rig(polar), np.radians(5.0))
    found = vibration.critical_speeds(scene, [0.2, 0.6], orders=(2, 4), instabilities=False)
    strong = [row for row in found if row.severity > 1e-8]
    assert {row.order for row in strong} == {2.0, 4.0}
    for row in strong:
        assert row.speed == pytest.approx(1.0 / row.order, rel=0.01)


@pytest.mark.slow
def test_instabilities_stand_beside_resonances() -> None:
    line = elastic_rigs.torsional_line(damping_in=0.004)
    scene = elastic_rigs.scene(line, np.radians(15.0))
    found = vibration.critical_speeds(scene, [0.4, 1.2])
    kinds = {row.kind: row for row in found}
    assert kinds["instability"].lower == pytest.approx(0.9912, abs=1e-3)
    assert kinds["instability"].upper == pytest.approx(1.0085, abs=1e-3)
    assert kinds["resonance"].order == 2.0
    assert kinds["resonance"].speed == pytest.approx(0.5, abs=5e-3)


@pytest.mark.slow
def test_peak_of_a_strongly_damped_mode() -> None:
    """A spring behind the joint is forced by the series φ₂ = φ + Σ κᵏ sin(2 k φ)/k, κ = tan²(β/2).

    Amplitudes κ r²/|1 - r² + 2 i ζ r|, r = 2 Ω/ω_n, are greatest at r = 1/√(1 - 2 ζ²).
    """
    natural, ratio, beta = 20.0, 0.2, np.radians(5.0)
    line = elastic_rigs.torsional_line(
        0.4, 1.0, None, natural**2, damping_out=2.0 * ratio * natural
    )
    found = vibration.critical_speeds(
        elastic_rigs.scene(line, beta), [7.0, 14.0], orders=2, instabilities=False
    )
    (row,) = found
    assert row.speed == pytest.approx(0.5 * natural / np.sqrt(1.0 - 2.0 * ratio**2), rel=1e-3)
    size = np.tan(beta / 2.0) ** 2 / (2.0 * ratio * np.sqrt(1.0 - ratio**2))
    assert row.severity == pytest.approx(size, rel=1e-5)
    assert row.amplification == pytest.approx(0.5 / ratio, rel=1e-6)
    assert row.frequency == pytest.approx(2.0 * row.speed)
    # Half power is at r² = x with (h - 1) x² - h (2 - 4 ζ²) x + h = 0, h half the peak's square.
    half = 0.5 / (2.0 * ratio * np.sqrt(1.0 - ratio**2)) ** 2
    square = np.roots([half - 1.0, -half * (2.0 - 4.0 * ratio**2), half])
    ends = 0.5 * natural * np.sqrt(np.sort(square))
    assert (row.lower, row.upper) == pytest.approx(tuple(ends), rel=1e-5)
    # Neither the crossing nor the peak lies above 10.6 rad/s, but half of the resonance does.
    (twin,) = vibration.critical_speeds(found.scene, [10.6, 14.0], orders=2, instabilities=False)
    assert twin.speed == pytest.approx(row.speed) and twin.upper == pytest.approx(row.upper)


@pytest.mark.slow
@pytest.mark.parametrize("damping", [(0.2, 0.05), (0.6, 0.5)])
def test_severities_are_those_of_modes_alone(damping: tuple[float, float]) -> None:
    """Two twists in front of and behind a joint with κ = tan²(β/2), so small that it forces alone.

    J₁ q₁'' + d₁ q₁' + k₁ q₁ = k₂ q₂ + d₂ q₂' and J₂ (q₁'' + q₂'') + k₂ q₂ + d₂ q₂' =
    4 κ Ω² J₂ sin 2φ. Strongly damped, the second mode has no peak.
    """
    kappa, inertia = np.tan(np.radians(1.0)) ** 2, np.array([[0.5, 0.0], [0.5, 0.5]])
    drag, spring = (
        np.array([[first, -second], [0.0, second]]) for first, second in (damping, (1, 1))
    )
    line = elastic_rigs.torsional_line(0.5, 0.5, 1.0, 1.0, *damping)
    scene = elastic_rigs.scene(line, np.radians(2.0))
    first, second = (
        found := vibration.critical_speeds(scene, [0.2, 1.2], orders=2, instabilities=False)
    )
    matrix = np.block(
        [
            [np.zeros((2, 2)), np.eye(2)],
            [-np.linalg.solve(inertia, item) for item in (spring, drag)],
        ]
    )
    values, vectors = np.linalg.eig(matrix)
    upper = np.argsort(np.where(values.imag > 0.0, values.imag, np.inf))[:2]
    shapes, speeds = vectors[:2, upper], np.linspace(0.2, 1.5, 13001)

    def together(speed: float) -> np.ndarray:
        pace = 2.0 * speed
        force = [0.0, kappa * pace**2 * inertia[1, 1]]
        return np.linalg.solve(spring + 1j * pace * drag - pace**2 * inertia, force)

    def alone(mode: int, speed: float) -> float:
        share = np.linalg.solve(shapes, together(speed))[mode]
        return float(np.max(np.abs(share * shapes[:, mode])))

    for mode, row in enumerate((first, second)):
        known = max(alone(mode, speed) for speed in speeds)
        if mode and damping[0] == 0.6:
            known = alone(mode, 0.5 * values[upper[1]].imag)
            assert np.isnan(row.lower) and np.isnan(row.upper)
            assert any("mode 2: it has no peak of its own" in text for text in found.remarks)
        assert row.severity == pytest.approx(known, rel=2e-3) and row.outcome == "known"
        response = vibration.forced_response(scene, row.speed, joints=[])
        sizes = np.abs([response.of(name, 2)[0] for name in scene.free])
        assert sizes == pytest.approx(np.abs(together(row.speed)), rel=2e-3)
    assert abs(np.max(sizes) / second.severity - 1.0) > 0.04
    assert "at least" not in str(found)


def test_a_mode_that_the_order_does_not_move_has_its_row_with_the_cause() -> None:
    """Without unbalance, order 1 meets both modes at their damped frequencies alone."""
    rotor = elastic_rigs.scene(elastic_rigs.rotor(2.0, 0.0, (200.0, 450.0), 4.0), 0.0)
    found = vibration.critical_speeds(rotor, [8.0, 20.0], orders=1, instabilities=False)
    assert [row.speed for row in found] == pytest.approx([np.sqrt(99.0), np.sqrt(224.0)])
    assert [row.severity_text for row in found] == ["0, not moved"] * 2
    assert "amplitude of the mode alone 0, not moved, Q" in str(found)


@pytest.mark.slow
def test_half_power_at_the_ends_of_a_resonance() -> None:
    ratio = 1e-3
    urdf = elastic_rigs.elastic_rig(damping_ratio=ratio)
    scene = elastic_rigs.scene(urdf, np.radians(2.0))
    found = vibration.critical_speeds(scene, [0.45, 0.6], orders=2, instabilities=False)
    (row,) = (row for row in found if row.whirl == "forward")
    response = vibration.forced_response(scene, [row.lower, row.speed, row.upper], joints=[])
    size, _ = response.whirls("tilt_y", "tilt_z", 2)
    # The other mode has a share in these motions.
    assert size[[0, 2]] == pytest.approx(np.sqrt(0.5) * size[1], rel=1e-3)


def test_orders_that_force_are_found() -> None:
    """Without unbalance even ones alone, of which each is tan²(β/2) times the one before."""
    line = elastic_rigs.torsional_line(damping_in=0.02)
    scene = elastic_rigs.scene(line, np.radians(10.0))
    found = vibration.critical_speeds(scene, [0.2, 0.3], instabilities=False)
    assert found.orders == (2.0, 4.0, 6.0, 8.0)


@pytest.mark.slow
def test_a_drive_that_turns_back_has_the_same_critical_speeds(rig: CriticalSpeeds) -> None:
    back = vibration.critical_speeds(rig.scene, [-0.6, -0.2], orders=(2, 4), instabilities=False)
    expected = [row for row in rig if row.order in (2.0, 4.0)]
    assert len(back) == len(expected) == 4
    for row, other in zip(reversed(back.rows), expected, strict=True):
        assert (row.order, row.whirl) == (other.order, other.whirl)
        assert row.speed == pytest.approx(-other.speed, rel=1e-4)
        assert row.severity == pytest.approx(other.severity, rel=1e-3, abs=1e-8)
        assert (row.lower, row.upper) == pytest.approx((-other.upper, -other.lower), rel=1e-4)


@pytest.mark.slow
def test_severity_is_the_greatest_that_is_known_where_motions_are_too_large() -> None:
    """κ/(2 ζ) = 1.55 rad exceeds the range of one radian, whose greatest amplitude is no peak."""
    line = elastic_rigs.torsional_line(0.5, 1.0, None, 1.0, damping_out=0.02)
    scene = elastic_rigs.scene(line, np.radians(20.0))
    found = vibration.critical_speeds(scene, [0.45, 0.55], orders=2, instabilities=False)
    (row,) = found
    assert row.outcome == "open"
    kappa, r = np.tan(np.radians(10.0)) ** 2, 2.0 * row.speed
    own = kappa * r**2 / abs(1.0 - r**2 + 0.02j * r)
    assert 0.9 < row.severity == pytest.approx(own, rel=1e-6)
    assert np.isnan(row.lower) and np.isnan(row.upper)
    assert f"amplitude of the mode alone at least {row.severity:.3g}" in str(found)
    assert any("larger than `max_amplitude`" in remark for remark in found.remarks)
    points = found.peaks()
    assert points["mode alone, at least"].tolist() == [[row.speed, row.severity]]
    assert not len(points["mode alone"])


def test_a_remark_says_why_a_branch_was_not_followed_further(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A cap on points is no matter of `max_amplitude`."""
    monkeypatch.setattr(continuation, "_MOST_POINTS", 5)
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(damping_in=0.04), np.radians(5.0))
    found = vibration.critical_speeds(scene, [0.45, 0.55], orders=2, instabilities=False)
    (row,) = found
    assert row.outcome == "open"
    (remark,) = (text for text in found.remarks if "branch of its motions" in text)
    assert "followed for 5 points only" in remark
    assert "max_amplitude" not in remark


@pytest.mark.slow
def test_a_peak_that_was_not_met_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """The nearest motion that was followed then stands for it, and for a fold."""
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(damping_in=0.008), np.radians(20.0))

    def resonance() -> tuple[vibration.CriticalSpeed, str]:
        found = vibration.critical_speeds(scene, [0.45, 0.55], orders=2, instabilities=False)
        (row,) = found
        return row, "; ".join(found.remarks)

    known, remarks = resonance()
    assert known.outcome == "known" and "not met" not in remarks
    monkeypatch.setattr(continuation.Branch, "reached", lambda *_: None)
    row, remarks = resonance()
    assert row.outcome == "open"
    assert 0.98 * known.severity < row.severity < known.severity
    assert "its peak was not met: its amplitude is that of the nearest motion" in remarks
    for fold in (row.rising, row.falling):
        assert f"where its branch turns back at about {fold:.6g} rad/s was not met" in remarks


@pytest.mark.slow
def test_undamped_resonances_of_linear_lines_have_no_bound() -> None:
    line = elastic_rigs.torsional_line(stiffness_in=None, stiffness_out=0.5)
    found = vibration.critical_speeds(
        elastic_rigs.scene(line, 0.1), [0.4, 0.6], orders=2, instabilities=False
    )
    (row,) = found
    assert row.speed == pytest.approx(0.5, abs=1e-6)
    assert (row.severity, row.outcome) == (np.inf, "unbounded")
    assert "alone without bound" in str(found)


@pytest.mark.parametrize("most", [0.3, pytest.param(1.0, marks=pytest.mark.slow)])
def test_an_undamped_resonance_that_is_bent_is_followed_as_far_as_is_asked(most: float) -> None:
    """Its motions are finite at every speed: that of the row is one, and greater ones may be."""
    rig = DrivenRig(0.05, 0.08, 150.0**2 * 0.13, 0.0, np.radians(18.0))
    found = vibration.critical_speeds(
        half_power.scene(rig), [60.0, 90.0], orders=2, instabilities=False, max_amplitude=most
    )
    (row,) = found
    assert row.outcome == "open"
    assert 0.9 * most < row.severity <= 1.02 * most
    assert row.frequency == 2.0 * row.speed
    # The curve of own motions reaches the row's amplitude at the row's speed.
    sides = (rig.up_to(speed, row.severity) for speed in (78.0, 72.0))
    assert any(abs(at - row.speed) < 2e-4 * row.speed for at in sides)
    (remark,) = (text for text in found.remarks if "branch of its motions" in text)
    assert "not followed to its peak: its motions are larger than `max_amplitude`" in remark


@pytest.mark.parametrize("seed", [0, pytest.param(3, marks=pytest.mark.slow)])
def test_half_power_of_motions_by_shooting(seed: int) -> None:
    """At 0.40 rad, where the joint bends the resonance, and at 0.12 rad."""
    rig = half_power.draw(seed)
    row = half_power.row_of(rig)
    lower, peak, upper = (
        rig.amplitude(rig.motion(speed)) for speed in (row.lower, row.speed, row.upper)
    )
    assert row.severity == pytest.approx(peak, rel=1e-6)
    assert (lower, upper) == pytest.approx((peak / np.sqrt(2.0),) * 2, rel=1e-5)
    assert row.lower < row.speed < row.upper
    for beside in np.linspace(row.lower, row.upper, 6)[1:-1]:
        assert peak / np.sqrt(2.0) < rig.amplitude(rig.motion(beside)) < peak * (1.0 + 1e-7)


@pytest.mark.slow
def test_tables_figures_and_copies(rig: CriticalSpeeds, tmp_path: Path) -> None:
    frame = rig.to_dataframe()
    assert len(frame) == len(rig)
    assert np.all(np.diff(frame.speed) >= 0.0)
    # Modes are counted from 1 by texts, tables and figures alike.
    first = rig.rows[0]
    assert f"order {first.order:g} meets mode {first.mode} " in str(rig)
    assert {row.mode for row in rig} <= {1, 2}
    at = rig.campbell.to_dataframe().query("mode == @first.mode")
    of = np.interp(first.speed, at.speed, at.frequency)
    assert first.frequency == pytest.approx(of, rel=1e-3)
    assert rig.plot().axes
    for twin in (copy.deepcopy(rig), pickle.loads(pickle.dumps(rig))):
        assert repr(twin.rows) == repr(rig.rows)
    np.testing.assert_array_equal([row.speed for row in rig], frame.speed)
    rig.save(tmp_path / "speeds.npz")
    with np.load(tmp_path / "speeds.npz") as stored:
        np.testing.assert_array_equal(stored["table.speed"], frame.speed)
        assert stored["orders"].tolist() == list(rig.orders)
        assert stored["free"].tolist() == ["tilt_z", "tilt_y"]
        np.testing.assert_array_equal(stored["campbell.frequency"], rig.campbell.frequency)


@pytest.mark.slow
def test_what_is_asked_for_wrongly(rig: CriticalSpeeds) -> None:
    with pytest.raises(ArgumentError, match="two or more ascending"):
        vibration.critical_speeds(rig.scene, [0.6, 0.2])
    assert str(vibration.critical_speeds(rig.scene, [2.0, 2.1])).endswith("2.1 rad/s\nnone")
    for orders, message in (
        (-1, "orders holds -1, expected positive"),
        ("two", "orders is not an array of real numbers"),
        ([2.0, np.nan], "orders is not finite"),
    ):
        with pytest.raises(ArgumentError, match=message):
            vibration.critical_speeds(rig.scene, [0.2, 0.6], orders=orders)


@pytest.mark.slow
def test_unbalance_between_equal_springs_excites_forward_whirl_alone() -> None:
    """Laval's rotor: its greatest amplitude is e/(2ζ√(1 - ζ²)), at ω_n/√(1 - 2ζ²)."""
    mass, offset, stiffness, damping = 20.0, 1e-4, 2e6, 250.0
    scene = elastic_rigs.scene(elastic_rigs.rotor(mass, offset, (stiffness,) * 2, damping), 0.0)
    natural = np.sqrt(stiffness / mass)
    ratio = damping / (2.0 * mass * natural)
    found = vibration.critical_speeds(scene, [100.0, 600.0], orders=1, instabilities=False)
    rows = {row.whirl: row for row in found}
    assert set(rows) == {"forward", "backward"}
    peak = offset / (2.0 * ratio * np.sqrt(1.0 - ratio**2))
    assert rows["forward"].severity == pytest.approx(peak, rel=1e-5)
    assert rows["forward"].speed == pytest.approx(natural / np.sqrt(1.0 - 2.0 * ratio**2), rel=1e-4)
    assert rows["backward"].severity < 1e-9 * peak


@pytest.mark.slow
def test_half_power_of_a_whirl_that_runs_along_with_its_order() -> None:
    """Θ/A = 1.5, order 2 forwards: Ω = 1, p' = 1.2, so that it is 2 ζ wide to either side."""
    scene = elastic_rigs.scene(elastic_rigs.elastic_rig(1.5), np.radians(2.0))
    found = vibration.critical_speeds(scene, [0.8, 1.2], orders=2, instabilities=False)
    (row,) = found
    assert row.whirl == "forward"
    assert row.upper - row.lower == pytest.approx(0.04, rel=0.02)
    places = np.linspace(0.95, 1.05, 401)
    response = vibration.forced_response(scene, places, joints=[])
    size = response.whirls("tilt_y", "tilt_z", 2)[0]
    inside = places[size > np.max(size) / np.sqrt(2.0)]
    assert inside[0] == pytest.approx(row.lower, abs=2.5e-4)
    assert inside[-1] == pytest.approx(row.upper, abs=2.5e-4)


@pytest.mark.slow
def test_an_order_that_does_not_move_a_mode_has_no_severity() -> None:
    """Laval's rotor without damping: its unbalance goes round forwards alone."""
    scene = elastic_rigs.scene(elastic_rigs.rotor(damping=0.0), 0.0)
    found = vibration.critical_speeds(scene, [100.0, 600.0], orders=1, instabilities=False)
    assert {row.whirl: row.severity for row in found} == {"forward": np.inf, "backward": 0.0}


@pytest.mark.campaign
@pytest.mark.slow
def test_coarse_speeds_change_no_resonance() -> None:
    """Ends of a range as far apart as 1 and 1e4 rad/s, damped modes of a gyroscopic shaft."""
    scene = elastic_rigs.scene(elastic_rigs.elastic_rig(0.3), np.radians(5.0))
    fine, coarse = (
        vibration.critical_speeds(scene, speeds, orders=2, instabilities=False)
        for speeds in ([0.4, 0.6], [0.1, 100.0])
    )
    assert len(fine) == len(coarse) == 2
    for one, other in zip(fine, coarse, strict=True):
        assert other.whirl == one.whirl
        for name in ("speed", "severity", "amplification", "lower", "upper"):
            assert getattr(other, name) == pytest.approx(getattr(one, name), rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [0.0, 0.01, 0.1])
def test_an_order_that_moves_no_mode_is_critical_at_the_crossing(ratio: float) -> None:
    """Every map of a balanced rotor: order 1 meets ω_n √(1 - ζ²), and nothing has half a power."""
    mass, natural = 20.0, 2546.0 * np.pi / 30.0
    stiffness = (mass * natural**2,) * 2
    scene = elastic_rigs.scene(
        elastic_rigs.rotor(mass, 0.0, stiffness, 2.0 * ratio * mass * natural), 0.0
    )
    found = vibration.critical_speeds(scene, [150.0, 400.0], orders=1, instabilities=False)
    assert [row.whirl for row in found] == ["backward", "forward"]
    for row in found:
        assert row.speed == pytest.approx(natural * np.sqrt(1.0 - ratio**2), rel=1e-9)
        assert (row.severity, row.outcome) == (0.0, "known")
        assert np.isnan(row.lower) and np.isnan(row.upper)


@pytest.fixture(scope="module")
def front() -> cd.Scene:
    mechanism = cd.load("torsional_line_front")
    return cd.Scene(
        mechanism,
        drive="bearing_in",
        free="twist_in",
        held={"joint_angle": np.radians(20.0)},
        elements=cd.described_elements(mechanism),
    )


@pytest.mark.slow
def test_a_resonance_that_leans_over_is_one_whatever_the_range(front: cd.Scene) -> None:
    """Between its jumps two motions stay and one does not; the greatest is that of the branch."""
    ranges = [105.0, 116.0], [111.0, 111.6], [109.0, 1200.0]
    tables = [
        vibration.critical_speeds(front, ends, orders=2, instabilities=False) for ends in ranges
    ]
    rows = [next(row for row in found if row.order == 2.0) for found in tables]
    for row in rows:
        assert row.speed == pytest.approx(111.34, abs=0.01)
        assert row.severity == pytest.approx(0.740, abs=5e-4)
        assert row.falling < row.speed < row.rising
        # Its branch turns back before half power.
        assert (row.lower, row.upper) == (row.falling, row.rising)
        for name in row._fields:
            own, other = getattr(row, name), getattr(rows[0], name)
            assert own == other or own == pytest.approx(other, rel=1e-6)
    for inside, beside in ((row.rising - 0.01, row.rising + 0.01), (row.falling + 0.01, 110.68)):
        motions = vibration.periodic_motion(front, np.sort([inside, beside]))
        counts = {float(at): int(np.sum(motions.speed == at)) for at in motions.speed}
        assert counts == {inside: 3, beside: 1}
    text = str(tables[0])
    assert f"jumps at {row.rising:.6g} rad/s while the speed rises" in text
    assert f"at {row.falling:.6g} rad/s while it falls" in text
    frame = tables[0].to_dataframe()
    assert frame.rising[0] == tables[0].rows[0].rising
    assert frame.attrs["units"]["falling"] == "rad/s"


@pytest.mark.slow
def test_motions_that_nothing_survives_are_remarked(front: cd.Scene) -> None:
    found = vibration.critical_speeds(front, [105.0, 116.0], orders=2, instabilities=False)
    remarks = " ".join(found.remarks)
    said = "twist_in swings by 0.751 rad (43°), which hardly any elastic shaft or support survives"
    assert said in remarks
    assert "beyond its limits -0.2 to 0.2" in remarks
    # A jump is the end of a stretch of motions that stay, and none is greater than both.
    row = next(item for item in found if item.order == 2.0)
    most = max(row.rising_severity, row.falling_severity)
    said = f"is that of an unstable motion; of those that a rig stays at, {most:.3g} was found"
    assert said in remarks
    motions = vibration.periodic_motion(front, row.falling + 1e-4)
    sizes = np.abs(motions.amplitude[motions.index > 0, motions.order == 2.0, 0])
    assert 0.99 * most < np.max(sizes) < most
    assert "lower is where its branch turns back, at 0.6" in remarks
    assert "upper is where its branch turns back, at 0.6" in remarks
    assert all(f"({remark})" in str(found) for remark in found.remarks)
    calm = vibration.critical_speeds(front, [70.0, 80.0], instabilities=False)
    assert calm.remarks == ()


@pytest.mark.slow
def test_no_instability_is_invented_where_two_motions_stay(front: cd.Scene) -> None:
    places = np.array([111.3, 111.4, 111.45, 111.5, 111.55])
    found = vibration.floquet(front, places, edges=True)
    assert found.kind.tolist() == ["stable"] * 5
    assert found.regions == ()
    table = vibration.critical_speeds(front, [111.2, 111.6], orders=2)
    assert [row.kind for row in table] == ["resonance"]


@pytest.mark.slow
def test_wide_ranges_lose_no_instability() -> None:
    """Two modes that are unstable together, from a range and from one 100 times as wide."""
    line = elastic_rigs.torsional_line(0.5, 0.5, 1.0, 1.0, 1e-3, 1e-3)
    scene = elastic_rigs.scene(line, np.radians(20.0))
    tables = [
        [row for row in vibration.critical_speeds(scene, ends, orders=9.0) if not row.order > 0.0]
        for ends in ([1.5, 1.7], [1.5, 21.5])
    ]
    assert [row.kind for row in tables[0]] == ["combination"]
    assert [row.kind for row in tables[1] if row.lower < 1.7] == ["combination"]
    for row, other in zip(*tables, strict=False):
        for name in ("lower", "upper"):
            assert getattr(row, name) == pytest.approx(getattr(other, name), rel=1e-7)
        assert row.severity == pytest.approx(other.severity, rel=1e-4)
        assert row.lower < row.speed < row.upper


@pytest.mark.slow
def test_what_cannot_have_been_seen_is_said() -> None:
    line = elastic_rigs.torsional_line(damping_in=0.02)
    scene = elastic_rigs.scene(line, np.radians(10.0))
    slow = vibration.critical_speeds(scene, [0.05, 0.3], orders=9.0)
    assert any("narrow instabilities are not looked for" in remark for remark in slow.remarks)
    fast = vibration.critical_speeds(scene, [0.3, 0.4], orders=9.0)
    assert fast.remarks == ()


@pytest.mark.slow
def test_an_instability_that_goes_on_is_remarked() -> None:
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(), np.radians(30.0))
    found = vibration.critical_speeds(scene, [1.0, 1.2], orders=9.0)
    assert any("goes on below, beyond the range" in remark for remark in found.remarks)


@pytest.mark.slow
def test_figure_of_orders_has_the_peak_and_jumps_of_the_table() -> None:
    """Its curve, of the smallest motions, passes below them."""
    mechanism = cd.load("torsional_line_front")
    scene = cd.Scene(
        mechanism,
        drive="bearing_in",
        free="twist_in",
        held={"joint_angle": np.radians(20.0)},
        elements=cd.described_elements(mechanism),
    )
    found = vibration.critical_speeds(scene, [110.0, 112.5], orders=2.0, instabilities=False)
    (row,) = found
    response = vibration.forced_response(scene, np.linspace(110.0, 112.5, 11), joints=())
    (axes,) = response.plot(orders=found.orders, critical=found).axes
    lines = {line.get_label(): np.array(line.get_data()) for line in axes.lines}
    np.testing.assert_allclose(lines["mode alone"], [[row.speed * PER_MINUTE], [row.severity]])
    np.testing.assert_allclose(
        lines["jump"],
        [
            [row.rising * PER_MINUTE, row.falling * PER_MINUTE],
            [row.rising_severity, row.falling_severity],
        ],
    )
    assert np.max(lines["twist_in, 2×"][1]) < 0.75 * row.severity
    assert found.peaks([4.0])["jump"].shape == (0, 2)
    assert set(axes.figure.axes[0].get_legend_handles_labels()[1]) == set(lines)


@pytest.mark.campaign
@pytest.mark.slow
def test_a_resonance_of_a_rotor_that_swings_far() -> None:
    """Five times as far as its springs are away, with its jumps."""
    rig = stiffening(2.0, 100.0, 0.3, 0.5, 10.0**-1.8, 4.0, nodes=47, step=0.004)
    plain = replace(rig, options={**rig.options, "instabilities": False})
    assert differences(plain, ()) == []
