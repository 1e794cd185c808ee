"""Masses and inertias of MJCF's bodies: against closed forms, integrals and MuJoCo's numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from testkit.mjcf import INERTIAL, of_body

import cardan_dyn as cd
from cardan_dyn.core.description.read import read


def link_of(text: str, strict: bool = True) -> tuple[float, list[float], np.ndarray]:
    link = read(text, strict).links[-1]
    return link.mass, link.centre.tolist(), link.inertia


@pytest.mark.parametrize(
    ("shape", "volume", "moments"),
    [
        ('type="sphere" size=".3"', 4 / 3 * np.pi * 0.027, [0.036] * 3),
        ('type="box" size="1 2 3"', 48.0, [13 / 3, 10 / 3, 5 / 3]),
        ('type="ellipsoid" size="1 2 3"', 8 * np.pi, [13 / 5, 10 / 5, 5 / 5]),
        (
            'type="cylinder" size="1 2"',
            4 * np.pi,
            [(3 + 16) / 12, (3 + 16) / 12, 1 / 2],
        ),
    ],
)
def test_solids(shape: str, volume: float, moments: list[float]) -> None:
    mass, centre, inertia = link_of(of_body(f'<joint/><geom {shape} pos="1 2 3"/>'))
    assert mass == pytest.approx(1000.0 * volume, rel=1e-14)
    assert centre == [1.0, 2.0, 3.0]
    np.testing.assert_allclose(inertia, mass * np.diag(moments), atol=1e-13 * mass)


def test_a_capsule_by_integration() -> None:
    """Slices along its axis: discs of the radius r(z)."""
    radius, half = 0.4, 0.7
    nodes, weights = np.polynomial.legendre.leggauss(20)
    area, across, along = 0.0, 0.0, 0.0
    for low, high, cap in ((0.0, half, False), (half, half + radius, True)):
        z = low + 0.5 * (high - low) * (nodes + 1.0)
        w = (high - low) * weights  # of both halves
        square = radius**2 - (z - half) ** 2 if cap else np.full_like(z, radius**2)
        area += np.sum(w * np.pi * square)
        along += np.sum(w * np.pi * square**2 / 2.0)
        across += np.sum(w * np.pi * (square**2 / 4.0 + square * z**2))
    text = of_body(f'<joint/><geom type="capsule" size="{radius} {half}" density="1"/>')
    mass, _, inertia = link_of(text)
    assert mass == pytest.approx(area, rel=1e-13)
    np.testing.assert_allclose(inertia, np.diag([across, across, along]), atol=1e-13)


BALL = '<geom size="1" mass="5"/>'


@pytest.mark.parametrize(
    ("compiler", "content", "mass", "moments"),
    [
        ("", INERTIAL.format("1 2 3") + BALL, 1.0, [1, 2, 3]),
        ('inertiafromgeom="true"', INERTIAL.format("1 2 3") + BALL, 5.0, [2, 2, 2]),
        ('inertiafromgeom="true"', INERTIAL.format("1 2 3"), 1.0, [1, 2, 3]),
        ('inertiafromgeom="false"', BALL, 0.0, [0, 0, 0]),
        ('inertiagrouprange="1 2"', BALL, 0.0, [0, 0, 0]),
        ("", '<geom size="1" mass="0"/>', 0.0, [0, 0, 0]),
        ("", "", 0.0, [0, 0, 0]),
        # As MuJoCo 4.0 has them.
        ('balanceinertia="true"', INERTIAL.format("1 1 5"), 1.0, [7 / 3] * 3),
        ('boundmass="3" boundinertia="2"', "", 3.0, [2, 2, 2]),
        (
            'balanceinertia="true" boundmass="3" boundinertia="2"',
            INERTIAL.format(".1 .1 5"),
            3.0,
            [3, 3, 3],
        ),
        ('settotalmass="7"', INERTIAL.format("1 2 3"), 7.0, [7, 14, 21]),
    ],
)
def test_what_the_compiler_makes_of_masses(
    compiler: str, content: str, mass: float, moments: list[float]
) -> None:
    found = link_of(of_body("<joint/>" + content, head=f"<compiler {compiler}/>"))
    assert found[0] == mass
    np.testing.assert_allclose(found[2], np.diag(moments), atol=1e-14)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (of_body('<inertial pos="0 0 0"/>'), "required attribute missing: 'mass'"),
        (of_body('<inertial mass="1"/>'), "required attribute missing: 'pos'"),
        (of_body('<inertial pos="0 0 0" mass="-1"/>'), "no body has the mass -1 kg"),
        (
            of_body('<inertial pos="0 0 0" mass="1" quat="1 0 0 0" fullinertia="1 1 1 0 0 0"/>'),
            "at most one of .fullinertia., .quat.",
        ),
        (of_body('<joint/><geom type="mesh" mesh="m"/>'), "mesh 'm' not found"),
        (of_body('<joint/><geom type="box" size="1 1"/>'), "must be positive in geom"),
        (
            of_body('<joint/><inertial pos="0 0 0" mass="0" diaginertia="1 1 1"/>'),
            "no body has the mass 0 kg and moments of inertia 1 kg",
        ),
        (of_body('<joint/><inertial pos="0 0 0" mass="1e-16"/>'), "the least mass that MuJoCo"),
        (of_body('<joint/><geom size="1" density="-1"/>'), "density"),
        (of_body('<joint/><geom size="0"/>'), "must be positive in geom"),
        (of_body('<joint/><geom size="1" fromto="0 0 0 1 0 0"/>'), "fromto"),
        (of_body(INERTIAL.format("1 1 5")), "inertia must satisfy A . B >= C"),
        (
            of_body('<joint/><geom type="box" size="1e50 1e50 1e50" density="1e50"/>'),
            "mass or inertia is beyond 1e[+]50",
        ),
    ],
)
def test_refused(text: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        read(text)


VERTICES = '<asset><mesh name="t" vertex="0 0 0 .5 0 0 0 .5 0 0 0 .5"/></asset>'


def test_a_tetrahedron_by_its_closed_form() -> None:
    """Three edges of 0.5 m at right angles: a³/6, centre at a/4, moments 3/40 of m a² about it."""
    mass, centre, inertia = link_of(of_body('<joint/><geom type="mesh" mesh="t"/>', head=VERTICES))
    assert mass == pytest.approx(1000.0 * 0.5**3 / 6.0, rel=1e-13)
    np.testing.assert_allclose(centre, [0.125] * 3, rtol=1e-13)
    expected = mass * 0.25 * (3.0 / 40.0 * np.eye(3) + (np.ones((3, 3)) - np.eye(3)) / 80.0)
    np.testing.assert_allclose(inertia, expected, rtol=1e-12)


def test_meshes_that_give_no_mass_need_no_file(tmp_path: Path) -> None:
    """MuJoCo itself would look for it, and for what its shape is like."""
    asset = '<asset><mesh name="m" file="nowhere.stl"/></asset>'
    geom = '<joint/><geom type="mesh" mesh="m"{}/>'
    for without in (geom.format("") + INERTIAL.format("1 2 3"), geom.format(' mass="0"')):
        read(of_body(without, head=asset))
    with pytest.raises(cd.ModelError, match=r"nowhere\.stl"):
        read(of_body(geom.format(""), head=asset))
    # What stands still has no inertia to be asked for, and robots without a floating base stand so.
    still = '<worldbody><geom type="mesh" mesh="m"/>'
    heavy = of_body("<joint/>" + INERTIAL.format("1 2 3"), head=asset)
    assert heavy.count("<worldbody>") == 1
    read(heavy.replace("<worldbody>", still))


def test_a_point_mass_is_said() -> None:
    text = of_body('<joint/><inertial pos="1 0 0" mass="2"/>')
    assert link_of(text)[0] == 2.0
    np.testing.assert_array_equal(link_of(text)[2], np.zeros((3, 3)))
    assert "a point mass" in read(text).warnings[0]
