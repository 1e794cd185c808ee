"""Violations of loops, couplings, drives and held joints, of linkages by hand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from testkit.claims import coupled_wheels
from testkit.kinematics import frames_of
from testkit.planar_linkages import BASE, ROCKER, described, four_bar, joint, link, solver

import cardan_dyn as cd
from cardan_dyn.core.description.second_reading import reread
from cardan_dyn.core.proof.constraints import Constraints, Motion
from cardan_dyn.core.proof.placing import Frame
from cardan_dyn.core.proof.residuals import Claim
from cardan_dyn.core.proof.samples import Rows, Sample
from cardan_dyn.core.proof.screws import Screws
from cardan_dyn.core.proof.vectors import ratio

LENGTH = 0.4
END = np.array([BASE, ROCKER])
"""Where coupler and rocker of the four-bar are joined at zero."""


def constraints(
    mechanism: cd.Mechanism,
    drives: Sequence[str] = (),
    held: Sequence[str] = (),
    unknown: Sequence[str] = (),
) -> tuple[Constraints, Screws]:
    screws = Screws(frames_of(mechanism))
    known = np.ones(mechanism.model.nv, dtype=bool)
    for name in unknown:
        known[mechanism.coordinates.velocity_columns[name]] = False
    motion = Motion(tuple(drives), tuple(held), known)
    layout = mechanism.coordinates
    return Constraints(reread(mechanism.description), layout, screws, LENGTH, motion), screws


def claim(mechanism: cd.Mechanism, x: np.ndarray, **changes: object) -> Claim:
    """Return a claim at coordinates `(N, size)`, at rest and without drives unless changed."""
    count, nv = len(x), mechanism.model.nv
    none = np.zeros((count, 0))
    values: dict[str, object] = {
        "x": x,
        "turns": np.zeros_like(x),
        "v": np.zeros((count, nv)),
        "a": np.zeros((count, nv)),
        "positions": none,
        "speeds": none,
        "accelerations": none,
        "held": none,
        "velocity_ratios": np.zeros((count, nv, 0)),
        "wrenches": np.zeros((count, 0, 6)),
        "exerted": np.zeros((count, nv)),
        "couplings": none,
        "loads": np.zeros((1, nv)),
        "link_loads": {},
        "gravity": np.zeros((1, 3)),
        "inertia": {},
        "has_rates": False,
    }
    return Claim(**{**values, **changes})  # type: ignore[arg-type]


def row(mechanism: cd.Mechanism, **positions: float) -> np.ndarray:
    """Return coordinates `(1, size)` with some joints away from zero."""
    x = mechanism.coordinates.neutral()[None]
    for name, value in positions.items():
        x[0, mechanism.coordinates.columns[name]] = value
    return x


def rate(mechanism: cd.Mechanism, **rates: float) -> list[float]:
    """Return joint rates `(nv,)` of some joints."""
    v = [0.0] * mechanism.model.nv
    for name, value in rates.items():
        v[mechanism.coordinates.velocity_columns[name].start] = value
    return v


def sample(mechanism: cd.Mechanism, x: np.ndarray, **changes: object) -> Sample:
    rows = Rows(claim(mechanism, x, **changes), None)
    return rows.sample(rows.scalars, frames_of(mechanism))


def placed(screws: Screws, x: np.ndarray) -> list[Frame]:
    return screws.placing.placed(list(x.T))


def position_error(
    item: Constraints, screws: Screws, mechanism: cd.Mechanism, x: np.ndarray, **changes: object
) -> np.ndarray:
    error = item.position_error(sample(mechanism, x, **changes), placed(screws, x))
    return np.broadcast_to(error, len(x))


@pytest.fixture(scope="module")
def rack() -> cd.Mechanism:
    """A pinion that drives a rack by 0.1 m per radian."""
    slide = (
        '<joint name="rack" type="prismatic"><parent link="ground"/><child link="b"/>'
        '<axis xyz="1 0 0"/></joint><coupling name="mesh"><predecessor link="a"/>'
        '<successor link="b"/><ratio value="0.1"/></coupling>'
    )
    return described(link("a"), link("b"), joint("A", "ground", "a"), slide)


def test_rates_of_slides_are_compared_with_the_length(rack: cd.Mechanism) -> None:
    item, _ = constraints(rack)
    columns = rack.coordinates.velocity_columns
    assert item.rate_scale[columns["A"].start] == 1.0
    assert item.rate_scale[columns["rack"].start] == LENGTH
    rates = rate(rack, A=-2.0, rack=1.0)
    assert item.greatest_rate(rates) == pytest.approx(1.0 / LENGTH)
    unknown, _ = constraints(rack, unknown=["rack"])
    assert unknown.greatest_rate(rates) == 2.0


def test_a_closed_loop_has_no_error() -> None:
    mechanism = four_bar()
    item, screws = constraints(mechanism)
    assert [of.loop for of in item.around] == [0]
    assert position_error(item, screws, mechanism, row(mechanism))[0] < 1e-15


@pytest.mark.parametrize("angle", [1e-6, 0.3, 3.0])
def test_a_gap_of_a_loop_is_compared_with_the_length(angle: float) -> None:
    """With the crank turned, the end of the coupler runs along a circle; C turns it back."""
    mechanism = four_bar()
    item, screws = constraints(mechanism)
    x = row(mechanism, A=angle, C=-angle)
    chord = 2.0 * np.sin(0.5 * angle) * np.linalg.norm(END)
    error = position_error(item, screws, mechanism, x)
    np.testing.assert_allclose(error, chord / LENGTH, rtol=1e-9)


@pytest.mark.parametrize("angle", [1e-6, 0.3, 3.0])
def test_an_angle_between_the_ends_of_a_loop(angle: float) -> None:
    mechanism = four_bar()
    item, screws = constraints(mechanism)
    error = position_error(item, screws, mechanism, row(mechanism, C=angle))
    np.testing.assert_allclose(error, 2.0 * np.sin(0.5 * angle), rtol=1e-9)


def test_loops_with_joints_of_unknown_motion_are_not_proven() -> None:
    mechanism = four_bar()
    item, screws = constraints(mechanism, unknown=["B"])
    assert item.around == []
    assert position_error(item, screws, mechanism, row(mechanism, A=1.0)) == [0.0]


def test_velocities_part_the_ends_of_a_loop() -> None:
    """The crank alone turns the end of the coupler about the origin; C turns it in its place."""
    mechanism = four_bar()
    item, screws = constraints(mechanism)
    frames = screws.placing.placed(row(mechanism)[0].tolist())
    units = screws.units(frames)
    for rates, expected in (
        ({"A": 2.0}, 2.0 * np.max(np.abs(END)) / LENGTH),
        ({"C": 2.0}, 2.0),
        ({"D": 2.0}, 2.0 * ROCKER / LENGTH),
        ({"A": 2.0, "D": 2.0}, 2.0 * BASE / LENGTH),
    ):
        relative = screws.relative(units, rate(mechanism, **rates))
        error = ratio(item.opening(frames, relative), 5.0)
        assert error == pytest.approx(expected / 5.0, rel=1e-12)


def test_rates_of_a_closed_loop_keep_it_closed() -> None:
    """Rates of the solver pass; a change of any of them, velocity or acceleration, does not."""
    mechanism = four_bar()
    item, screws = constraints(mechanism)
    kinematics, start = solver(mechanism, "A")
    guess = np.repeat(start[None], 3, axis=0)
    guess[:, mechanism.coordinates.columns["A"].start] = [0.0, 0.1, 0.2]
    closed = kinematics.close(guess)
    v = kinematics.rates(closed, np.full((3, 1), 2.0))
    a = kinematics.accelerations(closed, v, np.full((3, 1), -3.0))
    frames = placed(screws, closed.x)
    units = screws.units(frames)

    def error(velocities: np.ndarray, accelerations: np.ndarray) -> float:
        relative = screws.relative(units, list(velocities.T))
        absolute = screws.absolute(relative)
        changes = screws.changes(units, list(accelerations.T), relative, absolute)
        return float(np.max([item.opening(frames, added) for added in (relative, changes)]))

    assert error(v, a) < 1e-13
    for column in range(mechanism.model.nv):
        change = np.zeros_like(v)
        change[1, column] = 1e-6
        assert error(v + change, a) > 1e-7
        assert error(v, a + change) > 1e-7


def test_factors_of_a_coupling_leave_out_common_joints() -> None:
    mechanism = coupled_wheels().mechanism
    item, _ = constraints(mechanism)
    expected = rate(mechanism, **{"in": 2.0, "out": 1.0})
    x = row(mechanism)[None]
    np.testing.assert_array_equal(item.coupling_factors(x), [[expected]])
    unknown, _ = constraints(mechanism, unknown=["out"])
    assert unknown.couplings == []
    assert unknown.every_coupling == item.couplings
    assert unknown.coupling_factors(x).shape == (1, 0, mechanism.model.nv)


def test_slips_of_couplings_by_positions_and_rates() -> None:
    """Ratio -2: the second wheel turns back twice as far as the first one turns."""
    mechanism = coupled_wheels().mechanism
    item, screws = constraints(mechanism)
    for positions, slip in (
        ({"in": 0.5, "out": -1.0, "swing": 3.0}, 0.0),
        ({"in": 0.5, "out": -0.9}, 0.1),
    ):
        x = row(mechanism, **positions)
        assert position_error(item, screws, mechanism, x) == pytest.approx([slip], abs=1e-15)
        error = ratio(item.slip(rate(mechanism, **positions), x), 0.5)
        assert error == pytest.approx(2.0 * slip, abs=1e-15)


def test_whole_turns_count_in_couplings() -> None:
    mechanism = coupled_wheels().mechanism
    item, screws = constraints(mechanism)
    x = row(mechanism)
    turns = row(mechanism, **{"in": 1.0}) - x
    error = position_error(item, screws, mechanism, x, turns=turns)
    assert error == pytest.approx([4.0 * np.pi])


def test_a_slip_of_a_slide_is_compared_with_the_length(rack: cd.Mechanism) -> None:
    item, screws = constraints(rack)
    x = row(rack, A=1.0, rack=0.3)
    assert position_error(item, screws, rack, x) == pytest.approx([0.2 / LENGTH])
    slip = item.slip(rate(rack, A=1.0, rack=0.3), x)
    assert slip == pytest.approx(0.2 / LENGTH)


def test_a_coupling_to_the_ground_slips_by_the_motion_of_its_predecessor() -> None:
    coupling = (
        '<coupling name="brake"><predecessor link="a"/><successor link="ground"/>'
        '<ratio value="0.5"/></coupling>'
    )
    mechanism = described(link("a"), joint("A", "ground", "a"), coupling)
    item, screws = constraints(mechanism)
    error = position_error(item, screws, mechanism, row(mechanism, A=0.2))
    assert error == pytest.approx([0.2])


def test_a_coupling_may_have_an_offset() -> None:
    follower = (
        '<joint name="B" type="continuous"><parent link="ground"/><child link="b"/>'
        '<axis xyz="0 0 1"/><mimic joint="A" multiplier="2" offset="0.5"/></joint>'
    )
    mechanism = described(link("a"), link("b"), joint("A", "ground", "a"), follower)
    item, screws = constraints(mechanism)
    for position, slip in ((0.7, 0.0), (0.4, 0.3), (-0.3, 1.0)):
        x = row(mechanism, A=0.1, B=position)
        assert position_error(item, screws, mechanism, x) == pytest.approx([slip], abs=1e-15)


def test_drives_and_held_joints_have_the_prescribed_positions(rack: cd.Mechanism) -> None:
    mechanism = described(
        link("a"), link("b"), joint("A", "ground", "a"), joint("B", "ground", "b")
    )
    item, screws = constraints(mechanism, ["A"], ["B"])
    x = np.repeat(row(mechanism, A=0.3, B=0.5), 4, axis=0)
    x[2, mechanism.coordinates.columns["B"]] = 0.3
    prescribed = np.array([[0.3], [0.2], [0.3], [0.3]])
    # One position of the held joint for all samples, or one for each.
    for held, expected in (
        ([[0.5]], [0.0, 0.1, 0.2, 0.0]),
        ([[0.5], [0.5], [0.3], [0.9]], [0.0, 0.1, 0.0, 0.4]),
    ):
        given = {"positions": prescribed, "held": np.array(held)}
        error = position_error(item, screws, mechanism, x, **given)
        np.testing.assert_allclose(error, expected, atol=1e-16)
    # Positions of many turns are compared with their own size, those of slides with the length.
    far = {"positions": np.array([[1e6]]), "held": np.array([[0.5]])}
    many = position_error(item, screws, mechanism, x[:1], **far)
    assert many == pytest.approx([1.0], rel=1e-6)
    item, screws = constraints(rack, ["rack"], unknown=["A"])
    x = row(rack, rack=0.02)
    error = position_error(item, screws, rack, x, positions=np.array([[0.01]]))
    assert error == pytest.approx([0.01 / LENGTH])


def test_rates_of_drives_are_the_prescribed_ones() -> None:
    mechanism = described(
        link("a"), link("b"), joint("A", "ground", "a"), joint("B", "ground", "b")
    )
    item, _ = constraints(mechanism, ["A", "B"])
    columns = [mechanism.coordinates.velocity_columns[name].start for name in "AB"]
    velocity_ratios = np.zeros((1, 2, 2))
    velocity_ratios[0, columns] = np.eye(2)
    exact: dict[str, object] = {
        "velocity_ratios": velocity_ratios,
        "has_rates": True,
        "v": np.array([[2.0, -4.0]])[:, columns],
        "a": np.array([[5.0, 0.0]])[:, columns],
        "speeds": np.array([[2.0, -4.0]]),
        "accelerations": np.array([[5.0, 0.0]]),
    }

    def error(**changes: object) -> float:
        of = sample(mechanism, row(mechanism), **{**exact, **changes})
        return float(item.drive_rate_error(of))

    assert error() == 0.0
    # Relative to the greatest speed, or acceleration, of all drives.
    assert error(speeds=np.array([[2.0, -5.0]])) == pytest.approx(1.0 / 5.0)
    assert error(accelerations=np.array([[4.0, 0.0]])) == pytest.approx(1.0 / 4.0)
    assert error(velocity_ratios=velocity_ratios + 0.3) == pytest.approx(0.3)


def test_held_joints_rest() -> None:
    mechanism = described(
        link("a"), link("b"), joint("A", "ground", "a"), joint("B", "ground", "b")
    )
    item, _ = constraints(mechanism, ["A"], ["B"])
    error = ratio(item.slip(rate(mechanism, A=7.0, B=-0.5), row(mechanism)), 2.0)
    assert error == pytest.approx(0.25)


def test_states_of_several_samples_are_judged_one_by_one() -> None:
    mechanism = four_bar()
    item, screws = constraints(mechanism)
    x = np.concatenate([row(mechanism), row(mechanism, C=0.1), row(mechanism, C=-0.2)])
    error = position_error(item, screws, mechanism, x)
    np.testing.assert_allclose(error, 2.0 * np.sin([0.0, 0.05, 0.1]), atol=1e-15)
