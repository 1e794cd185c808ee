"""Linearisation about periodic motions."""

from __future__ import annotations

import numpy as np
import pytest
from shooting import periodic
from testkit import elastic_rigs
from tilting_shaft import TiltingShaft
from vibrating_lines import SpringInFront

from cardan_dyn import AccuracyError, Actuator, ArgumentError, vibration
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene
from cardan_dyn.motion.vibration.motions import search as searching
from cardan_dyn.motion.vibration.motions.search import MotionSearch
from cardan_dyn.motion.vibration.results.linearisation import _derivative_error

BETA = np.radians(20.0)


@pytest.mark.slow
def test_monodromy_against_shooting() -> None:
    speed = 0.8
    system = TiltingShaft(BETA, speed, 0.3, 1.2, 1.5, 0.02)
    scene = elastic_rigs.scene(elastic_rigs.elastic_rig(0.3, 1.2, 1.5, 0.02), BETA)
    found = vibration.linearise(scene, speed)
    shot = periodic(system, np.zeros(4))
    np.testing.assert_allclose(found.monodromy(), shot.monodromy, atol=1e-11)
    expected = sorted(shot.multipliers, key=lambda value: (round(abs(value), 9), value.imag))
    values = sorted(found.multipliers(), key=lambda value: (round(abs(value), 9), value.imag))
    np.testing.assert_allclose(values, expected, atol=1e-10)
    sizes = np.abs(found.multipliers())
    assert np.all(np.diff(sizes) < 1e-12) and sizes[0] > sizes[-1]
    assert 0.0 < found.derivative_error < 1e-8


@pytest.mark.slow
def test_disturbances_go_forwards_in_time_where_the_drive_turns_back() -> None:
    """By shooting over the drive's position, at negative speed backwards in time: the inverse."""
    speed = -0.8
    system = TiltingShaft(BETA, speed, 0.3, 1.2, 1.5, 0.02)
    scene = elastic_rigs.scene(elastic_rigs.elastic_rig(0.3, 1.2, 1.5, 0.02), BETA)
    found = vibration.linearise(scene, speed)
    shot = periodic(system, np.zeros(4))
    back = np.diag([1.0, 1.0, -1.0, -1.0])
    np.testing.assert_allclose(
        found.monodromy(), back @ np.linalg.inv(shot.monodromy) @ back, atol=1e-10
    )
    assert np.all(np.abs(found.multipliers()) < 1.0)


@pytest.mark.slow
def test_it_is_not_about_the_uniform_motion() -> None:
    """Near r = 1/2 the latter invents an instability."""
    r, zeta = 0.5, 0.02
    system = SpringInFront(BETA, r, 0.5, zeta)
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(damping_in=2.0 * zeta), BETA)
    found = vibration.linearise(scene, r)
    shot = periodic(system, np.r_[found.motion[0], 0.0])
    assert np.trace(found.monodromy()) == pytest.approx(shot.trace, abs=1e-10)


def test_gyroscopic_terms_and_fourier_coefficients() -> None:
    """At a small angle: A on the diagonal, ±Θ Ω beside the damping, c; forced at order 2."""
    speed, polar, beta = 0.9, 0.1, np.radians(0.5)
    scene = elastic_rigs.scene(elastic_rigs.elastic_rig(polar), beta)
    found = vibration.linearise(scene, speed)
    y, z = (found.free.index(name) for name in ("tilt_y", "tilt_z"))
    mean = found.fourier("damping")[0]
    assert mean[y, z] == pytest.approx(polar * speed, rel=1e-3)
    assert mean[z, y] == pytest.approx(-polar * speed, rel=1e-3)
    np.testing.assert_allclose(found.fourier("mass")[0].real, np.eye(2), atol=1e-4)
    np.testing.assert_allclose(found.fourier("stiffness")[0].real, np.eye(2), atol=1e-4)
    forcing = np.abs(found.fourier("forcing"))
    assert np.argmax(np.max(forcing, axis=1)[1:]) == 0
    assert found.order[:3].tolist() == [0.0, 2.0, 4.0]
    # The swing of Θ Ω² φ₂'' across the shaft, by Thoma's small-angle form.
    size = polar * speed**2 * beta * (1.0 - np.cos(beta))
    assert np.max(forcing[1]) == pytest.approx(size, rel=1e-3)


def test_forcing_swings_what_its_equation_says() -> None:
    """Σ M δq̈ + D δq̇ + K δq = forcing, averaged: off resonance that is the motion."""
    speed = 0.8
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(damping_in=0.1), np.radians(5.0))
    found = vibration.linearise(scene, speed)
    mean = {name: found.fourier(name)[0] for name in ("mass", "damping", "stiffness")}
    pace = 1j * found.order[1] * speed
    dynamic = pace**2 * mean["mass"] + pace * mean["damping"] + mean["stiffness"]
    expected = np.linalg.solve(dynamic, found.fourier("forcing")[1])
    np.testing.assert_allclose(found.fourier("motion")[1], expected, rtol=1e-3)


def test_derivatives_that_are_wrong_are_noticed() -> None:
    scene = elastic_rigs.scene(elastic_rigs.elastic_rig(), np.radians(20.0))
    search = MotionSearch(rotating_scene(scene))
    (motions,) = search.primary(np.array([0.8]))
    stiffness = motions.equation.stiffness[0]
    assert _derivative_error(motions, stiffness) < 1e-8
    for factor in (1.001, 0.9):
        error = _derivative_error(motions, factor * stiffness)
        assert error == pytest.approx(abs(1.0 - 1.0 / factor), rel=0.05)


def test_modes_and_tables() -> None:
    found = vibration.linearise(elastic_rigs.scene(elastic_rigs.torsional_line(), 0.1), 0.3)
    assert found.modes().frequency[0, 0] == pytest.approx(1.0, abs=1e-4)
    frame = found.to_dataframe()
    assert frame["stiffness[twist_in, twist_in].real"][0] == pytest.approx(1.0, rel=0.1)
    assert found.plot().axes
    with pytest.raises(ArgumentError, match="'speed' has no coefficients"):
        found.fourier("speed")


def test_one_speed_at_a_time() -> None:
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(), 0.1)
    with pytest.raises(ArgumentError, match=r"takes one speed; vibration\.campbell and floquet"):
        vibration.linearise(scene, [0.3, 0.4])  # type: ignore[arg-type]


@pytest.mark.parametrize("stiffness_out", [None, 0.6])
def test_a_table_with_a_corner_is_refused_before_branches_are_followed(
    monkeypatch: pytest.MonkeyPatch, stiffness_out: float | None
) -> None:
    """Beside a motion along which efforts do not vanish, no others are looked for."""
    line = elastic_rigs.torsional_line(
        damping_in=0.04, stiffness_out=stiffness_out, fork_inertia=0.1 if stiffness_out else 0.0
    )
    rig = elastic_rigs.scene(line, np.radians(10.0))
    table = np.array([[-2.0, 0.5], [0.0, 0.0], [2.0, -1.5]])
    pump = Actuator("twist_in", table, of="position")
    branches: list[object] = []
    monkeypatch.setattr(searching, "Branch", lambda *args, **kwargs: branches.append(args))
    with pytest.raises(AccuracyError, match="the law of an element has a corner"):
        vibration.linearise(rig.replace(elements=[*rig.elements, pump]), 0.45)
    assert not branches
