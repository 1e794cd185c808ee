"""Following several drives: closed samples in one assembly mode, in any steps, or a refusal."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.planar_linkages import ARM, five_bar, meeting_points, solver, tips, values

import cardan_dyn as cd
from cardan_dyn.core.kinematics.following.lines import follow


def followed(positions: np.ndarray) -> tuple[cd.Mechanism, np.ndarray]:
    mechanism = five_bar()
    kinematics, start = solver(mechanism, "A", "D")
    columns = [mechanism.coordinates.columns[name].start for name in "AD"]
    return mechanism, follow(kinematics, start, columns, positions)


def circle(count: int) -> np.ndarray:
    angle = np.linspace(0.0, 2.0 * np.pi, count)
    return np.stack([0.5 * np.sin(angle), 0.4 * np.cos(angle)], axis=1)


@pytest.mark.parametrize("count", [1, 2, 9, 700])
def test_samples_are_closed_in_the_mode_of_the_start(count: int) -> None:
    positions = circle(count)
    mechanism, x = followed(positions)
    for index, name in enumerate("AD"):
        np.testing.assert_array_equal(values(mechanism, x, name), positions[:, index])
    np.testing.assert_allclose(meeting_points(mechanism, x), tips(positions), atol=1e-13)


def test_far_samples_are_reached_in_small_steps() -> None:
    positions = np.array([[0.7, -0.7], [-0.9, 0.3], [0.0, 0.0], [0.7, -0.7]])
    mechanism, x = followed(positions)
    np.testing.assert_allclose(meeting_points(mechanism, x), tips(positions), atol=1e-13)
    np.testing.assert_allclose(x[0], x[3], atol=1e-13)


def test_whole_turns_are_counted() -> None:
    """Both cranks turn together five times, in steps of half a turn."""
    turns = np.linspace(0.0, 10.0 * np.pi, 11)
    mechanism, x = followed(np.stack([turns, turns], axis=1))
    np.testing.assert_allclose(values(mechanism, x, "B"), -turns, atol=1.2)
    np.testing.assert_allclose(values(mechanism, x, "B")[::2], -turns[::2], atol=1e-12)


def test_no_samples() -> None:
    _, x = followed(np.zeros((0, 2)))
    assert len(x) == 0


def test_a_sample_out_of_reach_is_refused_with_what_was_reached() -> None:
    """The pins move apart until the arms are in line; the nearest positions lie before that."""
    target = np.array([1.5, -1.5])
    with pytest.raises(cd.AssemblyError) as caught:
        followed(np.array([[0.1, -0.1], target, [0.0, 0.0]]))
    error = caught.value
    assert str(error).startswith("the loops cannot be closed at drive positions 1.5, -1.5; on the")
    np.testing.assert_array_equal(error.position, target)
    # 1 + 0.8 sin(angle) is the distance of the pins, twice the length of an arm at the end.
    end = np.arcsin((2.0 * ARM - 1.0) / 0.8)
    np.testing.assert_allclose(error.nearest, [end, -end], atol=1e-6)
    assert error.residual > 0.0
    assert f"the nearest that were reached are {error.nearest[0]:.12g}" in str(error)


def test_every_sample_is_followed_from_the_one_before_it() -> None:
    """A long way in small steps takes one attempt per batch, none of which is thrown away."""
    mechanism = five_bar()
    kinematics, start = solver(mechanism, "A", "D")
    columns = [mechanism.coordinates.columns[name].start for name in "AD"]
    sizes: list[int] = []

    class Counted:
        """The kinematics, with a record of how many samples each call closes."""

        def __getattr__(self, name: str) -> object:
            return getattr(kinematics, name)

        def close(self, x: np.ndarray, **options: int) -> object:
            sizes.append(len(x))
            return kinematics.close(x, **options)

    turns = np.linspace(0.0, 4.0 * np.pi, 1200)
    positions = np.stack([turns, turns + 0.5 * np.sin(turns)], axis=1)
    x = follow(Counted(), start, columns, positions)
    np.testing.assert_allclose(meeting_points(mechanism, x), tips(positions), atol=1e-13)
    np.testing.assert_allclose(values(mechanism, x, "B")[-1], -4.0 * np.pi, atol=1e-12)
    assert sum(sizes) < 3 * len(turns)
    assert len(sizes) < 0.05 * len(turns)
