"""Bodies that are drawn: which points they sweep, and how often they are animated."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

pytest.importorskip("meshcat", reason="the viewer needs meshcat")

import cardan_dyn as cd
from cardan_dyn.viewer.bodies import Bodies
from cardan_dyn.viewer.commands import Drawing

SAMPLES = np.arange(0, 25, 2)


def paths(drawing: Drawing) -> list[str]:
    return [item.path for item in drawing.objects]


def test_points_contain_every_joint_and_every_corner(loaded_turn: cd.Sweep) -> None:
    bodies = Bodies(loaded_turn, SAMPLES, visuals=True)
    points = bodies.points()
    for name in loaded_turn.mechanism.joints:
        for origin in loaded_turn.origin(name)[SAMPLES]:
            assert np.min(np.linalg.norm(points - origin, axis=1)) < 1e-15
    # The first sample's corners of the input shaft, placed by hand.
    shaft = next(shape for shape in bodies.shapes if shape.link == "shaft_in")
    rotation, origin = (f("bearing_in")[0] for f in (loaded_turn.rotation, loaded_turn.origin))
    for corner in shaft.corners():
        placed = rotation @ corner + origin
        assert np.min(np.linalg.norm(points - placed, axis=1)) < 1e-12


def test_each_shape_is_drawn_once_under_its_body(loaded_turn: cd.Sweep) -> None:
    bodies = Bodies(loaded_turn, SAMPLES, visuals=True)
    drawing = Drawing(1.0)
    bodies.draw(drawing, 1.0)
    drawn = paths(drawing)
    assert len(drawn) == len(set(drawn)) == len(bodies.shapes) > 3
    assert all(path.startswith("/mechanism/") for path in drawn)


def test_rods_stand_for_bodies_without_visuals() -> None:
    turn = cd.Scene(cd.load("four_bar"), drive="crank_bearing").sweep([0.0, 1.0])
    bodies = Bodies(turn, np.arange(2), visuals=False)
    assert bodies.shapes == []
    drawing = Drawing(1.0)
    bodies.draw(drawing, 1.0)
    rods = paths(drawing)
    # Base, crank, coupler and rocker have two joints each, and a rod to each of them.
    assert len(rods) == 8
    assert len({path.rsplit("/", 1)[0] for path in rods}) == 4


def test_loops_are_known_by_name(loaded_turn: cd.Sweep) -> None:
    names = {item.get("name") for item in loops(loaded_turn)}
    assert Bodies(loaded_turn, SAMPLES, visuals=False).loops == names


def loops(turn: cd.Sweep) -> list[ElementTree.Element]:
    return ElementTree.fromstring(turn.mechanism.description.source.text).findall("loop")
