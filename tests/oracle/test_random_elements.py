"""Elements on random chains: the work of the drives against slopes of the elastic energy."""

from __future__ import annotations

import numpy as np
import pytest
from compare import misjudged
from scenes import Case, draw

import cardan_dyn as cd
from cardan_dyn.core.elements.element import Element


def random_elements(case: Case, mechanism: cd.Mechanism, seed: int) -> list[Element]:
    """Return springs, a bushing and a torsion spring of about unit energy."""
    rng, size = np.random.default_rng(seed), case.chain.size
    links = list(mechanism.links)
    elements: list[Element] = []
    for _ in range(3):
        first, second = rng.choice(len(links), 2, replace=False)
        ends = links[first], links[second]
        if mechanism.links[ends[0]][0] == mechanism.links[ends[1]][0]:
            continue
        places = rng.uniform(-1.0, 1.0, (2, 3)) * size
        if len(elements) < 2:
            length = 0.2 * size * rng.integers(2)
            stiffness, damping = 3.0 / size**2, rng.uniform() / size**2
            elements.append(
                cd.PointSpring(ends[0], places[0], ends[1], places[1], stiffness, damping, length)
            )
        else:
            root = rng.uniform(-1.0, 1.0, (6, 6)) * ([1.0 / size] * 3 + [1.0] * 3)
            elements.append(cd.Bushing(*ends, places[0], root.T @ root, root.T @ root))
    name = list(mechanism.drivable)[rng.integers(len(mechanism.drivable))]
    unit = size if mechanism.drivable[name].slides else 1.0
    elements.append(cd.JointSpring(name, 2.0 / unit**2, 1.0 / unit**2, rest=0.5 * unit))
    return elements


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_the_work_of_the_drives_is_what_the_elements_store(seed: int) -> None:
    case = draw(seed)
    mechanism = cd.load(case.chain.text)
    elements = random_elements(case, mechanism, seed)
    scene = cd.Scene(mechanism, drive=case.drives, held=case.held, elements=elements)
    slides = [scene.mechanism.drivable[name].slides for name in case.drives]
    along = np.random.default_rng(seed).uniform(0.5, 1.0, len(slides))
    along *= np.where(slides, case.chain.size, 1.0)

    def swept(distance: float, **rates: float) -> cd.Sweep:
        positions = case.positions + distance * along
        return scene.sweep(positions if len(slides) > 1 else positions[:, 0], **rates)

    turn, step = swept(0.0), 3e-4
    slopes = [
        (swept(k * step).elastic_energy - swept(-k * step).elastic_energy) / (2.0 * k * step)
        for k in (1, 2, 3)
    ]
    slope = 1.5 * slopes[0] - 0.6 * slopes[1] + 0.1 * slopes[2]
    work = turn.drive_effort.reshape(len(turn), -1) @ along
    scale = np.max(np.abs(work)) + np.max(turn.elastic_energy)
    allowed = 1e-6 * max(1.0, 1e-3 * float(np.max(turn.condition)))
    np.testing.assert_allclose(work, slope, atol=allowed * scale)
    # At speed, the proof computes damping and inertia another way.
    moving = swept(0.0, speed=1.0, acceleration=0.5)
    assert all(np.all(force.dissipation >= 0.0) for force in moving.element_force.values())


@pytest.mark.parametrize("seed", range(15))
def test_a_wound_bushing_is_right_or_refused(seed: int) -> None:
    assert not misjudged(seed)
