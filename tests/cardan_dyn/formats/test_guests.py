"""Guests: a notation of a package that nobody here knows, read, proven and drawn."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.core.description.description import GUESTS
from cardan_dyn.practice.formats.visuals import visuals_of

PENDULUM = '<pendulum length="0.7" mass="3"/>'
READER = """
import numpy as np
from cardan_dyn.core.description.description import (
    Description, JointDescription, LinkDescription
)

def parse(root, given, where, strict):
    length, mass = (float(root.get(name)) * {SCALE} for name in ("length", "mass"))
    bob = LinkDescription("bob", mass, np.array([0.0, 0.0, -length]))
    hinge = JointDescription("hinge", "continuous", "frame", "bob", np.eye(4))
    return Description(
        "pendulum", (LinkDescription("frame"), bob), (hinge,), ("hinge",), (), source=given
    )
"""
SECOND = """
from dataclasses import replace
from xml.etree.ElementTree import fromstring

def reread(description, source):
    frame, bob = description.links
    stated = fromstring(source.text).attrib
    mass, length = float(stated["mass"]), float(stated["length"])
    return replace(description, links=(frame, replace(bob, mass=mass, centre=[0, 0, -length])))
"""
VISUALS = """
def visuals(source):
    return [], ["a pendulum is not drawn"]
"""


def guest(folder: Path, scale: str) -> None:
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "reader.py").write_text(READER.replace("{SCALE}", scale))
    (folder / "second_reading.py").write_text(SECOND)
    (folder / "visuals.py").write_text(VISUALS)


@pytest.fixture
def strangers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    guest(tmp_path / "right_guest", "1.0")
    guest(tmp_path / "wrong_guest", "1.001")
    monkeypatch.syspath_prepend(tmp_path)
    return monkeypatch


def test_a_stranger_reads_a_notation(strangers: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with pytest.raises(cd.ModelError, match=r"<pendulum>, expected <robot>, <mujoco> or <sdf>$"):
        cd.load(PENDULUM)
    strangers.setitem(GUESTS, "pendulum", "right_guest")
    file = tmp_path / "a.pendulum"
    file.write_text(PENDULUM)
    for source in (PENDULUM, file):
        mechanism = pickle.loads(pickle.dumps(cd.load(source)))
        scene = cd.Scene(mechanism, drive="hinge", gravity=(0, 0, -10))
        effort = scene.sweep([0.0, np.pi / 6.0]).drive_effort
        np.testing.assert_allclose(effort, [0.0, 3.0 * 10.0 * 0.7 * 0.5], rtol=0, atol=1e-13)
        assert visuals_of(mechanism.description) == ([], ["a pendulum is not drawn"])


def test_a_stranger_is_proven_like_all_others(strangers: pytest.MonkeyPatch) -> None:
    strangers.setitem(GUESTS, "pendulum", "wrong_guest")
    scene = cd.Scene(cd.load(PENDULUM), drive="hinge", gravity=(0, 0, -10))
    with pytest.raises(cd.AccuracyError):
        scene.sweep([0.5])
