"""Reduced masses, against planar mechanics by hand and accelerations of opened descriptions."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.constrained import accelerations
from testkit.linkages import four_bar, loop

import cardan_dyn as cd
from cardan_dyn import ModelError
from cardan_dyn.motion.clearance.opened_joint import Mobility, OpenedJoint
from cardan_dyn.motion.simulation.constrained_model import ConstrainedModel

CRANK, ROD = 0.045, 0.15
"""Lengths of the bundled slider-crank [m]."""
CRANK_MASS, ROD_MASS, PISTON_MASS = 4.9746767871, 0.948158379888, 1.35426173899
ROD_CENTRE, ROD_INERTIA = 0.0576027966507, 0.00364236106647


def in_world(mobility: Mobility) -> np.ndarray:
    """W along the world's x and y."""
    return np.asarray((mobility.axes.T @ mobility.matrix @ mobility.axes)[:2, :2])


def by_hand(phi: float) -> dict[str, np.ndarray]:
    """W of the slider-crank's pins, the crank's angle prescribed: rod and piston in the plane."""
    theta = -np.arcsin(CRANK * np.sin(phi) / ROD)
    along, across = (
        np.array([np.cos(theta), np.sin(theta)]),
        np.array([-np.sin(theta), np.cos(theta)]),
    )
    x = np.array([1.0, 0.0])
    # Crank pin open: the piston's way and the rod's angle move the big end.
    centre = np.stack([x, -(ROD - ROD_CENTRE) * across], axis=1)
    mass = ROD_MASS * centre.T @ centre + np.diag([PISTON_MASS, ROD_INERTIA])
    end = np.stack([x, -ROD * across], axis=1)
    big_end = end @ np.linalg.solve(mass, end.T)
    # Piston pin open: the rod swings about the crank pin, the piston slides.
    swing = ROD_INERTIA + ROD_MASS * ROD_CENTRE**2
    small_end = np.outer(x, x) / PISTON_MASS + ROD**2 * np.outer(across, across) / swing
    # Crank bearing open: the crank moves along with the rod's big end and does not turn.
    crank = np.linalg.inv(CRANK_MASS * np.eye(2) + np.linalg.inv(big_end))
    assert along @ across == pytest.approx(0.0, abs=1e-15)
    return {"crank_pin": big_end, "piston_pin": small_end, "crank_bearing": crank}


@pytest.mark.parametrize("phi", [0.3, 1.7, 4.0])
def test_slider_crank_by_hand(phi: float) -> None:
    scene = cd.Scene(cd.load("slider_crank"), drive="crank_bearing")
    x = scene.sweep([phi]).motion.rows[0]
    for name, expected in by_hand(phi).items():
        found = OpenedJoint(scene.solver, None, name).mobility(x)
        np.testing.assert_allclose(in_world(found), expected, rtol=1e-10, atol=1e-12)


SLIDE = (
    '<link name="{child}"/><joint name="{name}" type="prismatic"><parent link="{parent}"/>'
    '<child link="{child}"/>{origin}<axis xyz="{axis}"/>'
    '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
)


def opened_text(name: str) -> str:
    """The four-bar of the tests with two slides in one of its pins."""
    text = four_bar(loop("continuous"))
    parent, origin = {
        "b": ("crank", '<origin xyz="0 0.5 0"/>'),
        "d": ("ground", '<origin xyz="2 0 0"/>'),
        "c": ("coupler", '<origin xyz="2 2 0"/>'),
    }[name]
    slides = SLIDE.format(child="s1", name="s_x", parent=parent, origin=origin, axis="1 0 0")
    slides += SLIDE.format(child="s2", name="s_y", parent="s1", origin="", axis="0 1 0")
    if name == "c":
        text = text.replace(
            '<predecessor link="coupler"><origin xyz="2 2 0"/>', "<predecessor LINK>"
        )
        text = text.replace("<predecessor LINK>", '<predecessor link="s2"><origin xyz="0 0 0"/>')
        return text.replace("</robot>", f"{slides}</robot>")
    start = text.index(f'<joint name="{name}"')
    joint = text[start : text.index("</joint>", start)]
    inserted = joint.replace(f'link="{parent}"', 'link="s2"', 1).replace(origin, "")
    return text.replace(joint, inserted).replace("</robot>", f"{slides}</robot>")


@pytest.mark.parametrize("name", ["b", "c", "d"])
@pytest.mark.parametrize("inertia", [None, 0.02])
def test_four_bar_gives_way_as_with_slides_in_its_description(
    name: str, inertia: float | None
) -> None:
    """Forces on the slides of another description, and what they accelerate."""
    plain = cd.load(four_bar(loop("continuous")))
    driven = cd.Scene(plain, drive="a")
    x = driven.sweep([0.4]).motion.rows[0]
    found = in_world(OpenedJoint(driven.solver, inertia, name).mobility(x))

    text = opened_text(name)
    if inertia is not None:
        was = '<inertia ixx="0.02" iyy="0.03" izz="0.025"'
        now = f'<inertia ixx="0.02" iyy="0.03" izz="{0.025 + inertia}"'
        text = text.replace(was, now, 1)
    opened = cd.load(text, strict=inertia is None)
    named = opened.coordinates.named
    scene = cd.Scene(opened, drive="a", held={"s_x": 0.0, "s_y": 0.0})
    at = scene.sweep([0.4])
    fixed = [named["a"].rate] if inertia is None else []
    model = ConstrainedModel(opened, fixed, np.zeros(3), at.motion.rows[0])
    rates = [named[slide].rate for slide in ("s_x", "s_y")]
    expected = np.empty((2, 2))
    for column, rate in enumerate(rates):
        efforts = np.zeros(opened.model.nv)
        efforts[rate] = 1.0
        expected[:, column] = accelerations(model, at.motion.rows[0], 0.0 * efforts, efforts)[rates]
    body = {"b": "b", "c": "b", "d": None}[name]
    turn = np.eye(2) if body is None else at.rotation("s_x")[0][:2, :2]
    np.testing.assert_allclose(found, turn @ expected @ turn.T, rtol=1e-9, atol=1e-9)


def test_reduced_masses_of_a_known_matrix() -> None:
    mobility = Mobility(
        np.eye(3)[:2], np.array([[2.0, 0.5], [0.5, 1.0]]), np.eye(3)[:, :2], np.eye(3)[None]
    )
    x = np.array([1.0, 0.0, 0.0])
    assert mobility.reduced_mass(x) == pytest.approx(0.5)
    assert mobility.deviation(x) == pytest.approx(np.arctan2(0.5, 2.0))


def test_what_has_no_mass_is_refused() -> None:
    text = four_bar(loop("continuous"))
    for link in ("coupler", "rocker"):
        start = text.index(f'<link name="{link}">')
        end = text.index("</link>", start) + len("</link>")
        text = text[:start] + f'<link name="{link}"/>' + text[end:]
    mechanism = cd.load(text)
    x = mechanism.coordinates.neutral()
    opened = OpenedJoint(cd.Scene(mechanism, drive="a").solver, None, "b")
    with pytest.raises(ModelError, match="without mass is free to move"):
        opened.mobility(x)
