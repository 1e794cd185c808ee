"""The package against free bodies and closed forms, for chains written by hand."""

from __future__ import annotations

import hand_written
import numpy as np
import pytest
from chains import placed, rotation
from compare import differences, sweep_of
from hand_written import SIDE
from scenes import Case

import cardan_dyn as cd

SWIVELS = [0.0, 1e-6, 1e-4, 0.3, 1.0]


def agreed(case: Case) -> cd.Sweep:
    """Return the sweep of a case, in agreement with the free bodies."""
    sweep = sweep_of(case)
    differing = differences(case, sweep)
    assert not differing, "; ".join(map(str, differing))
    return sweep


@pytest.mark.parametrize("swivel", SWIVELS)
def test_four_bar_on_a_turntable(swivel: float) -> None:
    agreed(hand_written.swivelled_four_bar([swivel]))


def test_four_bar_on_a_turntable_at_all_angles_together() -> None:
    agreed(hand_written.swivelled_four_bar(SWIVELS))


@pytest.mark.parametrize("swivels", [*([swivel] for swivel in SWIVELS), SWIVELS])
def test_flags_of_a_four_bar_on_a_turntable_do_not_need_loads(swivels: list[float]) -> None:
    sweep = agreed(hand_written.swivelled_four_bar(swivels, acting=False))
    for name in "abcd":
        assert sweep[name].unique.tolist() == [True, True, False, False, False, True], name
    assert np.all(sweep["swivel"].unique)
    for name in ("swivel", *"abcd"):
        assert not np.any(sweep[name].force) and not np.any(sweep[name].moment)


@pytest.mark.parametrize("kind", ["continuous", "prismatic"])
def test_two_supports_at_one_point_share_alike(kind: str) -> None:
    """Least norm counts every joint once, whatever it is made of."""
    sweep = agreed(hand_written.shared_support(kind))
    for name in ("first", "second"):
        np.testing.assert_allclose(sweep[name].force[:, 2], 9.8, rtol=1e-12)
        assert np.max(np.abs(sweep[name].moment)) < 1e-12
        assert not sweep[name].unique[2]


def test_a_fixed_loop_onto_the_world_carries_all_that_hangs_on_it() -> None:
    case = hand_written.hung_from_the_world()
    sweep = agreed(case)
    weld = sweep["weld"]
    assert np.all(weld.unique) and np.all(sweep["free"].unique)
    np.testing.assert_allclose(weld.force, [[0.0, 0.0, -100.0]] * 2, atol=1e-11)
    # The world gets both weights, with their levers about the weld.
    lever = 3.0 * 0.1 + 7.0 * (1.0 + 0.5 * np.cos(case.positions[:, 0]))
    np.testing.assert_allclose(weld.moment[:, 1], 10.0 * lever, rtol=1e-12)
    assert np.max(np.abs(sweep["free"].force)) < 1e-11
    assert np.max(np.abs(sweep["free"].moment)) < 1e-11


def test_a_compliance_where_nothing_is_open_changes_nothing() -> None:
    case = hand_written.decided_compliance()
    sweep = agreed(case)
    stiff = cd.Scene(cd.load(case.chain.text), drive="a", gravity=case.gravity).sweep(
        case.positions[:, 0]
    )
    for name in "abcd":
        np.testing.assert_allclose(sweep[name].force, stiff[name].force, atol=1e-11)
        np.testing.assert_allclose(sweep[name].moment, stiff[name].moment, atol=1e-11)
        assert np.any(np.abs(sweep[name].force[:, 2]) > 0.1)


@pytest.mark.parametrize("factor", [1e-6, 1e-3, 1e3, 1e6])
def test_the_unit_of_length_changes_nothing(factor: float) -> None:
    plain = sweep_of(hand_written.sliding_chain(1.0))
    scaled = agreed(hand_written.sliding_chain(factor))
    assert scaled.mechanism.characteristic_length == pytest.approx(
        factor * plain.mechanism.characteristic_length, rel=1e-12
    )
    for name in plain.mechanism.joint_names:
        one, other = plain[name], scaled[name]
        np.testing.assert_array_equal(other.unique, one.unique, err_msg=name)
        size = max(np.max(np.abs(one.force)), np.max(np.abs(one.moment)))
        np.testing.assert_allclose(other.force, one.force, atol=1e-9 * size, err_msg=name)
        np.testing.assert_allclose(
            other.moment / factor, one.moment, atol=1e-9 * size, err_msg=name
        )


@pytest.mark.parametrize("base", ["world", "table"])
def test_a_linkage_that_a_gear_locks_to_a_held_wheel(base: str) -> None:
    sweep = agreed(hand_written.locked_linkage(base))
    np.testing.assert_allclose(sweep.motion.position("a"), -0.15, atol=1e-12)
    for name in "abcd":
        assert sweep[name].unique.tolist() == [True, True, False, False, False, True], name


def test_slides_are_counted_in_the_frame_of_the_text() -> None:
    """The frame that this file's closed forms take for granted: R_z(yaw) R_y(pitch) R_x(roll)."""
    case = hand_written.shared_support("prismatic")
    sweep = sweep_of(case)
    expected = placed(rotation(SIDE), np.zeros(3))[:3, :3]
    for sample in sweep.rotation("first"):
        np.testing.assert_allclose(sample, expected, atol=1e-14)
