"""Directions that closed loops leave, where inertia is missing or of very different sizes."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.simulated import joint, link

import cardan_dyn as cd


def five_bar(heavy: float) -> cd.Mechanism:
    """Two wheels of inertias `heavy` and 1 about their pins, joined by two links without mass."""
    wheels = link("left", (0.0, 0.0), heavy, heavy) + link("right", (0.0, 0.0), 1.0, 1.0)
    pins = joint("p", "base", "left") + joint("q", "base", "right", (3.0, 0.0))
    knees = joint("u", "left", "a", (1.0, 0.0)) + joint("w", "right", "b", (0.0, 1.0))
    loop = (
        '<loop name="top" type="continuous"><predecessor link="a"><origin xyz="1.5 1 0"/>'
        '</predecessor><successor link="b"><origin xyz="-0.5 0 0"/></successor>'
        '<axis xyz="0 0 1"/></loop>'
    )
    links = '<link name="base"/><link name="a"/><link name="b"/>'
    return cd.load(f'<robot name="five">{links}{wheels}{pins}{knees}{loop}</robot>')


@pytest.mark.parametrize("heavy", [1.0, 1e9])
def test_links_without_mass_do_not_slow_light_wheels(heavy: float) -> None:
    scene = cd.Scene(five_bar(heavy), free=["p", "q"], loads={"q": 0.1})
    pushed = scene.simulate(1.0)
    np.testing.assert_allclose(pushed.position[-1], [0.0, 0.05], atol=1e-13)
    assert pushed.effort_residual < 1e-8


@pytest.mark.parametrize("light", [1e-6, 1.0])
def test_pendulums_of_very_different_masses(light: float) -> None:
    bodies = link("a", (1.0, 0.0), 1e6, 1e5) + link("b", (1.0, 0.0), light, 0.1 * light)
    pins = joint("p", "base", "a") + joint("q", "base", "b", (0.0, 5.0))
    both = cd.load(f'<robot name="two"><link name="base"/>{bodies}{pins}</robot>')
    scene = cd.Scene(both, free=["p", "q"], loads={"p": 1.1e6, "q": 2.2 * light})
    np.testing.assert_allclose(scene.simulate(1.0).position[-1], [0.5, 1.0], rtol=1e-12)


def test_what_moves_no_mass_is_pushed_by_nothing() -> None:
    body = '<link name="base"/><link name="a"/>' + link("b", (1.0, 0.0))
    pins = joint("p", "base", "a") + joint("q", "base", "b", (0.0, 5.0))
    mechanism = cd.load(f'<robot name="two">{body}{pins}</robot>')
    scene = cd.Scene(mechanism, free=["p", "q"], loads={"q": 2.2})
    np.testing.assert_allclose(scene.simulate(1.0, speed=[3.0, 0.0]).position[-1], [3.0, 1.0])
    with pytest.raises(cd.SingularConfigurationError, match="nothing that moves has mass"):
        scene.simulate(1.0, loads={"p": 1e-3})
    alone = cd.Scene(mechanism, free="p", held={"q": 0.0})
    with pytest.raises(cd.SingularConfigurationError, match="nothing that moves has mass"):
        alone.simulate(1.0, loads={"p": 1e-3})
