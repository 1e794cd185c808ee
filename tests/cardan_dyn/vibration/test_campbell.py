"""Natural frequencies and modes over speed."""

from __future__ import annotations

import numpy as np
import pytest
from testkit import elastic_rigs

import cardan_dyn as cd
from cardan_dyn import ArgumentError, VibrationError, vibration
from cardan_dyn.analytic.whirl import whirl_frequencies
from cardan_dyn.motion.vibration.results.campbell import followed
from cardan_dyn.vibration import Campbell

POLAR = 0.1


@pytest.fixture(scope="module")
def found() -> Campbell:
    scene = elastic_rigs.scene(elastic_rigs.elastic_rig(POLAR), np.radians(1.0))
    return vibration.campbell(scene, [0.1, 0.7, 1.9])


def test_frequencies_of_the_gyroscopic_rotor(found: Campbell) -> None:
    """A λ² + (d ∓ i Θ Ω) λ + c = 0."""
    for row, speed in enumerate(found.speed):
        for mode, sense in ((0, -1.0), (1, 1.0)):
            roots = np.roots([1.0, 0.02 - 1j * sense * POLAR * speed, 1.0])
            expected = roots[np.argmax(roots.imag)]
            assert found.frequency[row, mode] == pytest.approx(expected.imag, rel=1e-4)
            assert found.decay[row, mode] == pytest.approx(expected.real, rel=1e-3)
            assert found.whirl[row, mode] == pytest.approx(sense, abs=0.01)
            decrement = -2.0 * np.pi * expected.real / expected.imag
            assert found.log_decrement[row, mode] == pytest.approx(decrement, rel=1e-3)
            factor = -0.5 * abs(expected) / expected.real
            assert found.amplification[row, mode] == pytest.approx(factor, rel=1e-3)


def test_a_drive_that_turns_back_swaps_forward_and_backward() -> None:
    scene = elastic_rigs.scene(elastic_rigs.elastic_rig(POLAR), np.radians(1.0))
    back = vibration.campbell(scene, [-1.9])
    slow, fast = np.argsort(back.frequency[0])
    assert back.whirl[0, slow] == pytest.approx(-1.0, abs=0.01)
    assert back.whirl[0, fast] == pytest.approx(1.0, abs=0.01)


def test_modes_keep_their_sense_in_space_where_the_drive_turns_back() -> None:
    """What whirls forwards, faster by its gyroscopic moment, is backward for the other rotation."""
    scene = elastic_rigs.scene(elastic_rigs.elastic_rig(POLAR), np.radians(1.0))
    found = vibration.campbell(scene, [1.9, -1.9])
    np.testing.assert_allclose(found.whirl, [[-1.0, 1.0], [1.0, -1.0]], atol=0.01)
    np.testing.assert_allclose(found.frequency[1], found.frequency[0, ::-1], rtol=1e-9)


@pytest.mark.parametrize("count", [3, 7])
def test_modes_arefollowed_by_their_shapes(count: int) -> None:
    """Whether all orders are compared or not."""
    random = np.random.default_rng(count)
    shapes = random.normal(size=(count, count)) + 1j * random.normal(size=(count, count))
    value = 1j * np.arange(1.0, count + 1.0)
    order = random.permutation(count)
    near = shapes + 0.01 * random.normal(size=shapes.shape)
    found = followed(value, shapes, value[order], near[:, order])
    np.testing.assert_array_equal(order[found], np.arange(count))


@pytest.mark.parametrize("count", [2, 6])
def test_modes_of_nearly_one_shape_arefollowed_by_their_frequencies(count: int) -> None:
    random = np.random.default_rng(count)
    before, after = 1.0 + 0.03 * random.normal(size=(2, count, count)) + 0.0j
    value, order = 1j * np.arange(1.0, count + 1.0), np.roll(np.arange(count), 1)
    found = followed(value, before, 1.01 * value[order], after)
    np.testing.assert_array_equal(order[found], np.arange(count))


def test_separation_margin(found: Campbell) -> None:
    margin = found.separation_margin((1, 4))
    frequency = found.frequency[1, 0]
    expected = min(abs(frequency - n * 0.7) / (n * 0.7) for n in (1, 4))
    assert margin[1, 0] == pytest.approx(expected)
    with pytest.raises(ArgumentError, match="expected positive numbers"):
        found.separation_margin((0, 1))
    with pytest.raises(ArgumentError, match="orders is not finite"):
        found.separation_margin(np.nan)
    with pytest.raises(ArgumentError, match="orders is not"):
        found.separation_margin("first")
    with pytest.raises(ArgumentError, match="orders is not"):
        found.plot(orders="first")


@pytest.mark.slow
def test_modes_keep_their_columns_where_frequencies_cross() -> None:
    """A weight on a spring by itself, which forward whirl overtakes: p² - Θ/A Ω p - 1 = 0."""
    weight = (
        '<link name="weight"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" '
        'ixz="0" iyz="0"/></inertial></link><joint name="hang" type="prismatic"><parent '
        'link="base"/><child link="weight"/><axis xyz="0 1 0"/><dynamics spring_stiffness="1.44" '
        'damping="0.01"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
    )
    rig = elastic_rigs.elastic_rig(1.0).replace("</robot>", weight)
    speed = np.linspace(0.1, 0.9, 5)
    found = vibration.campbell(elastic_rigs.scene(rig, np.radians(1.0)), speed)
    forward, backward = whirl_frequencies(speed, 1.0, 1.0)
    assert forward[0] < 1.2 < forward[2]
    expected = np.column_stack([backward, forward, np.full(5, 1.2)])
    np.testing.assert_allclose(found.frequency, expected, rtol=1e-3)


def test_tables_and_figures(found: Campbell) -> None:
    frame = found.to_dataframe()
    assert frame.whirl.tolist() == ["backward", "forward"] * 3
    (axes,) = found.plot(orders=2).axes
    assert [text.get_text() for text in axes.texts] == ["2×"]
    assert axes.get_legend_handles_labels()[1] == ["mode 1, backward", "mode 2, forward"]
    for orders in ("two", None):
        with pytest.raises(ArgumentError, match="orders is not an array of real numbers"):
            found.plot(orders=orders)
    assert "3 speeds" in repr(found)


def test_a_rotor_on_slides() -> None:
    """It whirls in no sense: one mode along each slide, √(k/m)."""
    stiffness, mass = np.array([100.0, 130.0]), 1.7
    rig = cd.load(elastic_rigs.sliding_rotor(mass, stiffness=stiffness.tolist()))
    scene = cd.Scene(
        rig,
        drive="turn",
        free=["y", "z"],
        held={"x": 0.0, "yaw": 0.0},
        elements=cd.described_elements(rig),
    )
    found = vibration.campbell(scene, [3.0, 12.0])
    np.testing.assert_allclose(found.frequency, [np.sqrt(stiffness / mass)] * 2, rtol=1e-12)
    np.testing.assert_allclose(found.whirl, np.zeros((2, 2)), atol=1e-9)
    assert set(found.to_dataframe().whirl) == {"planar"}


def test_without_any_motion() -> None:
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(), 0.3)
    with pytest.raises(VibrationError):
        vibration.campbell(scene, 0.5, max_amplitude=0.05)


def test_torsion_is_named_without_a_whirl() -> None:
    """Rounding of either sign, of the senses of planar modes, names nothing."""
    line = elastic_rigs.torsional_line(0.5, 0.5, 1.0, 1.0)
    found = vibration.campbell(elastic_rigs.scene(line, 0.1), [0.3, 0.4])
    assert found.plot().axes[0].get_legend_handles_labels()[1] == ["mode 1", "mode 2"]
    assert set(found.to_dataframe().whirl) == {"planar"}


@pytest.mark.slow
def test_modes_arefollowed_past_speeds_without_a_motion() -> None:
    """A circle keeps its sense in space, and is backward or forward by the drive's sense."""
    scene = elastic_rigs.scene(elastic_rigs.elastic_rig(POLAR), np.radians(5.0))
    found = vibration.campbell(scene, [0.9, 0.51303, -0.9], max_amplitude=1e-4)
    assert np.isnan(found.frequency[1]).all()
    assert np.isnan(found.amplification[1]).all()
    np.testing.assert_allclose(found.whirl[0], [-1.0, 1.0], atol=0.02)
    np.testing.assert_allclose(found.whirl[2], [1.0, -1.0], atol=0.02)
    np.testing.assert_allclose(found.frequency[2], found.frequency[0, ::-1], rtol=1e-6)
