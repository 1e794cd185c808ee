"""Masses and inertias of MJCF's bodies: against closed forms, integrals and MuJoCo's numbers."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from testkit.mjcf import INERTIAL, of_body

import cardan_dyn as cd
from cardan_dyn.description.description import LinkDescription
from cardan_dyn.description.mjcf.elements import Compiler
from cardan_dyn.description.mjcf.inertia import MassElement, frame_of, link, scaled_to
from cardan_dyn.description.read import read


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
        ("", '<geom size="1" mass="0"/><geom type="mesh" mass="0"/>', 0.0, [0, 0, 0]),
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


def test_inertias_that_no_body_can_have() -> None:
    text = of_body("<joint/>" + INERTIAL.format("1 1 5"))
    with pytest.raises(cd.ModelError, match=r"body 'b': principal moments 1, 1, 5 .*strict=False"):
        read(text)
    assert "violate the triangle inequality" in read(text, strict=False).warnings[0]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (of_body('<inertial pos="0 0 0"/>'), 'mass="..." is missing'),
        (of_body('<inertial mass="1"/>'), 'pos="..." is missing'),
        (of_body('<inertial pos="0 0 0" mass="-1"/>'), "mass -1 kg is not positive"),
        (of_body('<inertial pos="0 0 0" mass="0" diaginertia="1 1 1"/>'), "needs a mass; load"),
        (
            of_body('<inertial pos="0 0 0" mass="1" quat="1 0 0 0" fullinertia="1 1 1 0 0 0"/>'),
            "fullinertia and quat exclude each other",
        ),
        (of_body('<joint/><geom type="mesh" mesh="m"/>'), "of type 'mesh' is not .*<inertial>"),
        (of_body('<joint/><geom type="sdf" mesh="m"/>'), "of type 'sdf' is not computed here"),
        (of_body('<joint/><geom type="box" mesh="m"/>'), "of type 'box' fitted to a mesh"),
        (of_body('<joint/><geom size="1" shellinertia="true"/>'), "shellinertia is not supported"),
        (of_body('<joint/><geom size="1" density="-1"/>'), "mass or density is negative"),
        (of_body('<joint/><geom type="box" size="1 1"/>'), "a box needs 3 positive size"),
        (of_body('<joint/><geom size="0"/>'), "a sphere needs 1 positive size"),
        (of_body('<joint/><geom size="1" fromto="0 0 0 1 0 0"/>'), "fromto does not suit"),
        (
            of_body('<joint/><geom type="box" pos="0 0 0" size="1" fromto="0 0 0 1 0 0"/>'),
            "pos and fromto both place it",
        ),
        (
            of_body('<joint/><geom type="box" size="1e50 1e50 1e50" density="1e50"/>'),
            "mass or inertia is beyond 1e[+]50",
        ),
        (of_body("", head='<compiler settotalmass="1"/>'), "but no body has a mass"),
    ],
)
def test_refused(text: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        read(text)


NOWHERE = np.eye(4)


def shape(placement: np.ndarray = NOWHERE, **attributes: str) -> MassElement:
    return MassElement(attributes, placement, "x: geom")


def of_geoms(*geoms: MassElement, compiler: Compiler | None = None) -> LinkDescription:
    return link("b", None, list(geoms), compiler or Compiler(), "x", True)[0]


def test_the_halves_of_a_box_are_the_box() -> None:
    """The parallel axes theorem, turned and moved by frames around the geoms."""
    placement = pin.SE3(pin.rpy.rpyToMatrix(0.3, -0.5, 0.7), np.array([1.0, 2.0, 3.0])).homogeneous
    whole = of_geoms(shape(placement, type="box", size="1 2 3"))
    halves = of_geoms(
        *(shape(placement, type="box", size="1 2 1.5", pos=f"0 0 {z}") for z in (-1.5, 1.5))
    )
    assert whole.mass == pytest.approx(48_000.0, rel=1e-15)
    assert whole.agrees(halves, 1e-14)
    turn = placement[:3, :3]
    principal = 48_000.0 / 3.0 * np.diag([13.0, 10.0, 5.0])
    np.testing.assert_allclose(whole.inertia, turn @ principal @ turn.T, rtol=1e-13)
    np.testing.assert_allclose(whole.centre, [1.0, 2.0, 3.0], rtol=1e-15)


@pytest.mark.parametrize("kind", ["capsule", "cylinder", "box", "ellipsoid"])
def test_a_shape_between_two_points_is_the_one_with_its_half_length(kind: str) -> None:
    """Along z, from 1 to 5: half the length is 2, and the middle at 3."""
    sizes = "0.3 2" if kind in ("capsule", "cylinder") else "0.3 0.3 2"
    placed = of_geoms(shape(type=kind, size=sizes, pos="0 0 3"))
    for ends in ("0 0 1 0 0 5", "0 0 5 0 0 1"):
        between = of_geoms(shape(type=kind, size="0.3", fromto=ends))
        assert between.agrees(placed, 1e-14)


def test_a_long_capsule_is_nearly_a_cylinder_and_a_short_one_a_ball() -> None:
    capsule, cylinder = (
        of_geoms(shape(type=kind, size="1e-3 1")) for kind in ("capsule", "cylinder")
    )
    assert capsule.mass == pytest.approx(cylinder.mass, rel=1e-3)
    np.testing.assert_allclose(capsule.inertia, cylinder.inertia, rtol=3e-3, atol=1e-20)
    capsule, ball = (
        of_geoms(shape(type=kind, size=size))
        for kind, size in (("capsule", "1 1e-9"), ("sphere", "1"))
    )
    assert capsule.agrees(ball, 1e-8)


def test_mass_and_density_scale_the_inertia() -> None:
    plain = of_geoms(shape(type="box", size="1 2 3"))
    for attributes, factor in (({"density": "500"}, 0.5), ({"mass": "12000"}, 0.25)):
        scaled = of_geoms(shape(type="box", size="1 2 3", **attributes))
        assert scaled.mass == pytest.approx(factor * plain.mass)
        np.testing.assert_allclose(scaled.inertia, factor * plain.inertia, rtol=1e-14)


@pytest.mark.parametrize(
    "attributes",
    [
        {"type": "plane", "size": "1 1 1"},
        {"type": "hfield", "hfield": "h"},
        {"size": "1", "mass": "0"},
        {"size": "1", "density": "0"},
        {"size": "1", "group": "6"},
        {"type": "mesh", "mesh": "m", "density": "0"},
    ],
)
def test_geoms_without_a_mass(attributes: dict[str, str]) -> None:
    assert of_geoms(shape(**attributes)) == LinkDescription("b")
    ball = of_geoms(shape(size="1"))
    assert of_geoms(shape(**attributes), shape(size="1")) == ball


def test_groups_of_geoms() -> None:
    compiler = Compiler(groups=(1.0, 2.0))
    geoms = [shape(size="1", mass=str(10**group), group=str(group)) for group in range(4)]
    assert of_geoms(*geoms, compiler=compiler).mass == 110.0


def test_an_inertial_in_a_turned_frame() -> None:
    """A quarter turn about z, 1 m along x: x of the frame is y of the body."""
    placement = np.array([[0.0, -1, 0, 1], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    stated = shape(placement, pos="1 0 0", mass="2", fullinertia="1 2 2.5 0.1 0.2 0.3")
    found, warnings = link("b", stated, [], Compiler(), "x", True)
    assert warnings == []
    assert found.mass == 2.0
    np.testing.assert_allclose(found.centre, [1.0, 1.0, 0.0], atol=1e-15)
    expected = [[2.0, -0.1, -0.3], [-0.1, 1.0, 0.2], [-0.3, 0.2, 2.5]]
    np.testing.assert_allclose(found.inertia, expected, atol=1e-15)


def test_a_massless_body() -> None:
    assert link("b", None, [], Compiler(), "x", True) == (LinkDescription("b"), [])
    stated = shape(pos="1 2 3", mass="0", diaginertia="1 1 1")
    with pytest.raises(
        cd.ModelError, match=r"^x: an inertia needs a mass; load\(..., strict=False\)"
    ):
        link("b", stated, [], Compiler(), "x", True)
    found, warnings = link("b", stated, [], Compiler(), "x", False)
    assert found == LinkDescription("b")
    assert warnings == ["x: mass 0 kg with an inertia: taken as massless"]


def test_masses_that_are_too_small_to_compute_with() -> None:
    with pytest.raises(
        cd.ModelError, match=r"^x: mass 1e-51 kg is not positive; a massless body has"
    ):
        of_geoms(shape(size="1", mass="1e-51"))


def test_scaling_to_a_total_mass() -> None:
    links = [
        LinkDescription("a"),
        LinkDescription("b", 1.0, np.array([1.0, 2.0, 3.0]), np.diag([1.0, 2.0, 2.5])),
        LinkDescription("c", 3.0),
    ]
    scaled = scaled_to(links, 8.0, "x")
    assert [item.mass for item in scaled] == [0.0, 2.0, 6.0]
    np.testing.assert_array_equal(scaled[1].inertia, np.diag([2.0, 4.0, 5.0]))
    np.testing.assert_array_equal(scaled[1].centre, [1.0, 2.0, 3.0])
    with pytest.raises(
        cd.ModelError, match=r"^x: compiler: settotalmass 8 kg, but no body has a mass"
    ):
        scaled_to(links[:1], 8.0, "x")
    with pytest.raises(
        cd.ModelError, match=r"^x: compiler: settotalmass 1e-51 kg leaves masses of none"
    ):
        scaled_to(links, 1e-51, "x")


def test_frames_of_sites() -> None:
    """A site has no size here: of `fromto` only the placement counts."""
    found = frame_of({"type": "capsule", "fromto": "0 0 2 0 0 0"}, Compiler(), "x")
    np.testing.assert_array_equal(found[:3, 3], [0.0, 0.0, 1.0])
    np.testing.assert_array_equal(found[:3, :3], np.eye(3))
    np.testing.assert_array_equal(frame_of({"pos": "1 2 3"}, Compiler(), "x")[:3, 3], [1, 2, 3])
    for attributes, message in (
        ({"fromto": "0 0 0 1 0 0"}, "x: fromto does not suit the type 'sphere'"),
        ({"type": "mesh", "fromto": "0 0 0 1 0 0"}, "x: fromto does not suit the type 'mesh'"),
        ({"type": "box", "pos": "0 0 0", "fromto": "0 0 0 1 0 0"}, "x: pos and fromto both place"),
    ):
        with pytest.raises(cd.ModelError, match=f"^{message}"):
            frame_of(attributes, Compiler(), "x")
