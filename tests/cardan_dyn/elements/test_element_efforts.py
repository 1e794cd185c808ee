"""Element efforts one state at a time, against slopes of energies and virtual work by Pinocchio."""

from __future__ import annotations

from typing import cast

import numpy as np
import pytest
from testkit.element_work import energy_of, generalised, slopes
from testkit.mixed_chain import MIXED, rows

import cardan_dyn as cd
from cardan_dyn.core.elements.element import Acting, Element
from cardan_dyn.core.elements.element_efforts import ElementEfforts
from cardan_dyn.core.elements.element_forces import ElementForces
from cardan_dyn.motion.simulation.turning_model import turning_model

SPRINGS: dict[str, list[Element]] = {
    "joints": [
        cd.JointSpring("swing", 7.0, rest=0.3),
        cd.JointSpring("slide", 40.0),
        cd.JointSpring("swing", 1.0),
    ],
    "many joints": [
        cd.JointSpring(name, 7.0 + index, rest=0.1 * index)
        for index, name in enumerate(["swing", "slide"] * 6)
    ],
    "points": [cd.PointSpring("left", (0.1, 0.2, 0.3), "right", (-0.2, 0.1, 0.5), 30.0, 0.0, 0.4)],
    "world": [cd.PointSpring("base", (1.0, 2.0, 4.0), "slider", (0.1, 0.0, 0.2), 30.0, 0.0, 0.4)],
    "bushing": [cd.Bushing("platform", "left", (0.1, 0.3, -0.2), np.arange(1.0, 7.0))],
}
DAMPERS: list[Element] = [
    cd.JointSpring("swing", 7.0, damping=2.0),
    cd.JointFriction("slide", 3.0, transition=0.5),
    cd.PointSpring("left", (0.1, 0.2, 0.3), "right", (-0.2, 0.1, 0.5), 30.0, 4.0, 0.4),
    cd.PointSpring("slider", (0.1, 0.0, 0.2), "base", (1.0, 2.0, 4.0), 30.0, 4.0),
    cd.Bushing("right", "base", (0.1, 0.2, 0.3), np.arange(1.0, 7.0), np.arange(6.0)),
    cd.Actuator("swing", lambda time: 2.0 * time),
]


@pytest.fixture(scope="module")
def mechanism() -> cd.Mechanism:
    return cd.load(MIXED)


def found(
    mechanism: cd.Mechanism, elements: list[Element], x: np.ndarray, v: np.ndarray, time: float
) -> np.ndarray:
    model, efforts = turning_model(mechanism), ElementEfforts(mechanism, elements)
    data, result = model.createData(), np.zeros((len(x), model.nv))
    for index in range(len(x)):
        efforts.add_along_coordinates(result[index], time, x[index], v[index])
        state = x[index], v[index]
        efforts.add_on_links(result[index], model, data, time, state, *state)
    return result


@pytest.mark.parametrize("name", SPRINGS)
def test_springs_pull_down_the_slopes_of_their_energy(mechanism: cd.Mechanism, name: str) -> None:
    x = rows(mechanism, 10, seed=4)
    elements = SPRINGS[name]
    expected = -slopes(mechanism, energy_of(ElementForces(mechanism, elements), mechanism), x)
    efforts = found(mechanism, elements, x, np.zeros((10, mechanism.model.nv)), 0.0)
    # Differences of order six with steps of 1e-3.
    np.testing.assert_allclose(efforts, expected, atol=1e-9 * np.max(np.abs(expected)))
    assert ElementEfforts(mechanism, elements).is_conservative


def test_all_together_in_motion_against_virtual_work(mechanism: cd.Mechanism) -> None:
    x = rows(mechanism, 10, seed=5)
    v = np.random.default_rng(6).uniform(-2.0, 2.0, (10, mechanism.model.nv))
    acted = ElementForces(mechanism, DAMPERS).at(x, v, np.full(10, 1.5))
    expected = generalised(mechanism, x, acted)
    np.testing.assert_allclose(
        found(mechanism, DAMPERS, x, v, 1.5), expected, atol=1e-13 * np.max(np.abs(expected))
    )


@pytest.mark.parametrize("index", range(len(DAMPERS)))
def test_what_damps_or_drives_is_not_conservative(mechanism: cd.Mechanism, index: int) -> None:
    efforts = ElementEfforts(mechanism, [DAMPERS[index]])
    assert not efforts.is_conservative
    assert efforts


def test_none_do_nothing(mechanism: cd.Mechanism) -> None:
    none = ElementEfforts(mechanism, [])
    assert none.is_conservative
    assert not none.act_on_links and not none.rates


CONTACT = cd.PinContact(
    "left", (0.1, 0.2, 0.3), (0.3, -0.4, 0.8), "right", (-0.2, 0.1, 0.5), 1e-2,
    cd.LinearContact(50.0, 3.0), friction=0.4, radius=0.05, transition=0.3,
)  # fmt: skip


@pytest.mark.parametrize("element", [*DAMPERS, CONTACT], ids=lambda item: type(item).__name__)
def test_kinds_that_know_arrays_alone_act_alike(mechanism: cd.Mechanism, element: Element) -> None:
    class ByArrays:
        """The same element as a new kind may be that is asked by arrays alone."""

        links, joints, conserves = element.links, element.joints, element.conserves
        name, has_functions = "", element.has_functions

        class _Acting:
            def __init__(self, acting: Acting) -> None:
                self.at = acting.at

        def on(self, mechanism: cd.Mechanism, label: str) -> Acting:
            """See `Element.on`."""
            return self._Acting(element.on(mechanism, label))

    x = rows(mechanism, 5, seed=7)
    v = np.random.default_rng(8).uniform(-2.0, 2.0, (5, mechanism.model.nv))
    expected = found(mechanism, [element], x, v, 1.5)
    plain = cast("Element", ByArrays())
    assert np.max(np.abs(expected)) > 0.1
    atol = 1e-13 * np.max(np.abs(expected))
    np.testing.assert_allclose(found(mechanism, [plain], x, v, 1.5), expected, atol=atol)
