"""Damped closure: loops closed from anywhere, and the least gap where they cannot be closed."""

from __future__ import annotations

import contextlib
import re

import numpy as np
import pytest
from testkit.planar_linkages import COUPLER, CRANK, ROCKER, four_bar, geared, pin_distance

import cardan_dyn as cd
from cardan_dyn.core.kinematics.closing.far import closed_from
from cardan_dyn.core.kinematics.closing.group_solver import GroupSolver
from cardan_dyn.core.kinematics.loops.groups import independent_groups
from cardan_dyn.core.kinematics.loops.structure import Structure


def solver_of(mechanism: cd.Mechanism) -> GroupSolver:
    """All loops of a linkage, with every joint free to move."""
    (group,) = independent_groups(Structure(mechanism), np.arange(mechanism.model.nv))
    return GroupSolver(mechanism, group)


def scattered(mechanism: cd.Mechanism, count: int) -> np.ndarray:
    angles = np.random.default_rng(3).uniform(-np.pi, np.pi, (count, mechanism.model.nv))
    return np.asarray(mechanism.coordinates.neutral() + angles)


def test_a_four_bar_closes_from_anywhere() -> None:
    mechanism = four_bar()
    starts = scattered(mechanism, 200)
    kept = starts.copy()
    reached, residual = closed_from(solver_of(mechanism), starts)
    np.testing.assert_array_equal(starts, kept)
    assert np.max(residual) < 1e-8
    np.testing.assert_allclose(pin_distance(mechanism, reached), COUPLER, atol=1e-7)


def test_a_closed_start_stays_as_it_is() -> None:
    mechanism = four_bar()
    start = mechanism.coordinates.neutral()[None, :]
    reached, residual = closed_from(solver_of(mechanism), start)
    np.testing.assert_array_equal(reached, start)
    assert residual[0] < 1e-15


@pytest.mark.parametrize("scale", [1e-9, 1e-12])
def test_equations_that_are_nearly_singular_stay_regular(scale: float) -> None:
    """Links that are short beside 1 m: what turns them is lost in the rounding of the rest."""
    text = four_bar().to_urdf()
    origins = re.compile(r'<origin xyz="([^"]*)"')

    def short(found: re.Match[str]) -> str:
        values = [repr(scale * float(word)) for word in found[1].split()]
        return f'<origin xyz="{" ".join(values)}"'

    mechanism = cd.load(origins.sub(short, text))
    reached, residual = closed_from(solver_of(mechanism), scattered(mechanism, 50))
    assert np.all(np.isfinite(reached))
    assert np.all(np.isfinite(residual))


@pytest.mark.parametrize("height", [1.0, 1e3, 1e6, 1e9, 1e12])
def test_bodies_far_away_end_in_scenes_or_in_words(height: float) -> None:
    body = '<inertial pos="0 0 0.1" mass="1" diaginertia="0.1 0.1 0.1"/>'

    def hinge(name: str) -> str:
        return f'<joint name="{name}" type="hinge" axis="0 1 0"/>'

    text = (
        f'<mujoco model="far"><worldbody><body name="b1">{body}{hinge("j1")}'
        f'<body name="b2" pos="1 0 0">{body}{hinge("j2")}</body></body>'
        f'<body name="b3" pos="2 0 {height!r}">{body}{hinge("j3")}</body></worldbody>'
        '<equality><connect name="e" body1="b2" body2="b3" anchor="1 0 0"/></equality></mujoco>'
    )
    with contextlib.suppress(cd.CardanError):
        cd.Scene(cd.load(text), drive="j1", gravity=[0.0, 0.0, -9.81])


def test_couplings_are_closed_as_well() -> None:
    mechanism = geared(-2.5)
    reached, residual = closed_from(solver_of(mechanism), scattered(mechanism, 5))
    assert np.max(residual) < 1e-8
    columns = [mechanism.coordinates.columns[name].start for name in "AB"]
    first, second = reached[:, columns].T
    np.testing.assert_allclose(second, -2.5 * first, atol=1e-7)


@pytest.mark.parametrize("base", [2.5, 7.0])
def test_what_cannot_close_reaches_the_least_gap(base: float) -> None:
    """Ground pivots too far apart for the links in line: what is missing is the gap's minimum."""
    mechanism = four_bar(base=base)
    # The coupler's length follows from the pins at zero, where the rocker is upright at the base.
    coupler = float(np.hypot(base, ROCKER - CRANK))
    reach = CRANK + coupler + ROCKER
    assert reach > base
    # Move the rocker's pivot farther away than all links together reach.
    text = cd.load(mechanism.to_urdf()).to_urdf()
    far = reach + 1.3
    moved = text.replace(f'xyz="{base!r} 0.0 0.0"', f'xyz="{far!r} 0.0 0.0"', 1)
    assert moved != text
    apart = cd.load(moved)
    reached, residual = closed_from(solver_of(apart), scattered(apart, 40))
    gap = np.min(residual) * apart.characteristic_length
    assert gap == pytest.approx(1.3, rel=1e-5)
    assert np.all(np.isfinite(reached))
