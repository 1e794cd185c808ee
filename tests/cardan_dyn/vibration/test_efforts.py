"""Terms of the efforts against sweeps, and against equations by hand."""

from __future__ import annotations

import numpy as np
import pytest
from testkit import elastic_rigs
from tilting_shaft import TiltingShaft

import cardan_dyn as cd
from cardan_dyn.motion.vibration.model.efforts import FreeEfforts, Terms
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene

BETA = np.radians(20.0)


@pytest.fixture(scope="module")
def rig() -> cd.Scene:
    return elastic_rigs.scene(elastic_rigs.elastic_rig(0.3, 1.2, 1.5, 0.02), BETA)


def assembled(terms: Terms, w: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
    return (
        np.einsum("nij,nj->ni", terms.mass, acceleration)
        + np.einsum("nijk,nj,nk->ni", terms.quadratic, w, w)
        + np.einsum("nij,nj->ni", terms.linear, w)
        + terms.static
    )


def test_terms_are_all_there_is(rig: cd.Scene) -> None:
    loaded = rig.replace(loads={"bearing_out": -0.4}, gravity=[0.0, -3.0, -9.81])
    efforts = FreeEfforts(rotating_scene(loaded))
    random = np.random.default_rng(1)
    positions = np.column_stack([random.uniform(-9.0, 9.0, 6), 0.3 * random.normal(size=(6, 2))])
    speeds, accelerations = random.normal(size=(2, 6, 3))
    accelerations[:, 0] = 0.0
    expected = (
        loaded.replace(drive=loaded.coordinates)
        .sweep(positions, speeds, accelerations)
        .drive_effort[:, 1:]
    )
    found = assembled(efforts.terms(positions), speeds, accelerations[:, 1:])
    np.testing.assert_allclose(found, expected, atol=1e-13)
    np.testing.assert_allclose(efforts(positions, speeds, accelerations), expected, atol=1e-14)


def test_accelerations_by_hand_need_no_effort(rig: cd.Scene) -> None:
    speed, phi = 0.8, 1.1
    q, rate = np.array([0.1, -0.2]), np.array([0.3, 0.05])
    bend = TiltingShaft(BETA, speed, 0.3, 1.2, 1.5, 0.02)(phi, q, rate)
    terms = FreeEfforts(rotating_scene(rig)).terms(np.array([[phi, *q]]))
    w = np.array([[speed, *(speed * rate)]])
    assert np.max(np.abs(assembled(terms, w, speed**2 * bend[None]))) < 1e-13


def test_terms_go_through_columns() -> None:
    columns = np.arange(2.0 * 30).reshape(2, 30)
    terms = Terms.of_flat(columns, 2)
    assert [item.shape for item in terms] == [(2, 2, 2), (2, 2, 3, 3), (2, 2, 3), (2, 2)]
    np.testing.assert_array_equal(terms.flat(), columns)


def test_terms_take_one_sweep(rig: cd.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """Springs and loads are swept and proven, and dampers that turn with others are swept."""
    sweeps = []
    sweep = cd.Scene.sweep

    def counted(*given: object, **others: object) -> cd.Sweep:
        sweeps.append(given)
        return sweep(*given, **others)  # type: ignore[arg-type]

    efforts = FreeEfforts(rotating_scene(rig))
    monkeypatch.setattr(cd.Scene, "sweep", counted)
    efforts.terms(np.zeros((5, 3)))
    assert len(sweeps) == 1
