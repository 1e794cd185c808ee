"""A mechanism as SDF has the wrenches that it has as URDF+."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from compare import sweep_of
from scenes import draw
from testkit import linkages, sdf
from testkit.bundled import EVERY_KIND

import cardan_dyn as cd
from cardan_dyn.core.description.description import Description
from cardan_dyn.core.mechanism.rezero import rezeroed
from cardan_dyn.scene.presets import PRESETS
from cardan_dyn.scene.usual_motion import usual_motion

pytestmark = pytest.mark.usefixtures("loaded_once")

SEEDS = [2, 8, 15, 37, 67, 69, 71, 72, 76]
"""Random chains whose joints SDF has words for, and that have no couplings."""


class Text:
    """Stands for a chain of which only the text is read."""

    def __init__(self, text: str) -> None:
        self.text = text


def again(description: Description, text: str) -> cd.Mechanism:
    """Return the mechanism that a text of a description is; nothing about it is remarkable."""
    mechanism = cd.load(text)
    assert not mechanism.warnings
    assert len(mechanism.loops) == len(description.loops)
    assert {link.name for link in description.links} <= set(mechanism.link_names)
    return mechanism


@pytest.mark.parametrize(("seed", "name"), list(enumerate(EVERY_KIND)))
def test_bundled_mechanisms(seed: int, name: str) -> None:
    """From a closed configuration, in any order, with poses relative to any frame."""
    mechanism, preset = cd.load(name), PRESETS[name]
    motion = usual_motion(mechanism, samples=9).sweep().motion
    at = {joint: motion.position(joint)[3] for joint in mechanism if mechanism[joint].parts}
    description = rezeroed(mechanism.description, at, mechanism.characteristic_length)
    sweeps = []
    for item in (
        cd.Mechanism(description),
        again(description, sdf.SdfText(description, seed).text()),
    ):
        scene = cd.Scene(
            item,
            drive=list(preset.drive),
            held=dict.fromkeys(preset.held_deg, 0.0),
            loads=dict(preset.loads),
            gravity=(0.3, -0.2, -9.0),
        )
        steps = np.linspace(0.0, 0.1, 4)[:, None] * np.ones(len(preset.drive)) / len(preset.drive)
        sweeps.append(scene.sweep(steps, speed=2.0, acceleration=1.0))
    found, reference = sweeps
    assert sdf.compare(found, reference, 1e-10)
    for joint in reference.outputs:
        np.testing.assert_array_equal(
            found.wrench(joint, "world").unique, reference.wrench(joint, "world").unique
        )


@pytest.mark.parametrize("seed", SEEDS)
def test_random_chains(seed: int) -> None:
    case = draw(seed)
    reference = sweep_of(case)
    text = sdf.SdfText(reference.mechanism.description, 1 + seed).text()
    again(reference.mechanism.description, text)
    sdf.compare(sweep_of(replace(case, chain=Text(text))), reference, 1e-9)


@pytest.mark.parametrize(
    ("order", "version"),
    [("abdc", "1.4"), ("cdba", "1.6"), ("dcab", "1.9"), ("bcda", "1.12"), ("acbd", "1.12")],
)
def test_four_bar(order: str, version: str) -> None:
    """A link with two parents: whichever joint closes the loop, wrenches keep their signs."""
    found, reference = (
        cd.Scene(cd.load(text), drive="a", loads={"d": -3.0}, gravity=(0.0, -9.0, 0.0)).sweep(
            linkages.POSITIONS, **linkages.RATES
        )
        for text in (
            sdf.four_bar(order, version),
            linkages.four_bar(linkages.loop("continuous")),
        )
    )
    sdf.compare(found, reference, 1e-11)
    for joint in "abcd":
        np.testing.assert_allclose(
            found.motion.position(joint), reference.motion.position(joint), atol=1e-12
        )


def test_a_joint_whose_child_is_carried_by_another_one() -> None:
    """No chain of joints carries the coupler: it floats, and its joints close loops.

    The joint b is the reverse of what the tree would want: its coordinate and its wrench have the
    signs of the file, the opposite ones of the same joint with parent and child swapped.
    """
    swapped = sdf.JOINT.format(
        name="b",
        kind="revolute",
        parent="coupler",
        child="crank",
        pose="<pose>0 0.5 0 0 0 0</pose>",
    )
    mechanism = cd.load(sdf.four_bar(b=swapped))
    assert [joint.name for joint in mechanism.description.joints] == ["coupler_floating", "a", "d"]
    assert [loop.joint for loop in mechanism.loops] == ["b", "c"]
    assert "link 'coupler' floats" in mechanism.warnings[0]
    found, reference = (
        cd.Scene(item, drive="a", loads={"d": -3.0}).sweep(linkages.POSITIONS, **linkages.RATES)
        for item in (mechanism, cd.load(sdf.four_bar()))
    )
    for joint, sign in (("a", 1.0), ("b", -1.0), ("c", 1.0), ("d", 1.0)):
        position = found.motion.position(joint) - sign * reference.motion.position(joint)
        np.testing.assert_allclose(np.sin(0.5 * position), 0.0, atol=1e-12)
        force, expected = (
            sweep.wrench(joint, "world").force[:, :2] for sweep in (found, reference)
        )
        np.testing.assert_allclose(force, sign * expected, atol=1e-10 * np.max(np.abs(expected)))
    assert np.max(np.abs(found["coupler_floating"].force)) < 1e-10
    np.testing.assert_allclose(found.drive_effort, reference.drive_effort, atol=1e-9)


SHAFTS = """<link name="in">{mass}</link>
<link name="out"><pose>0 0 0 0 0 {angle}</pose>{mass}</link>
<joint name="bearing_in" type="revolute"><parent>world</parent><child>in</child>
<axis><xyz>1 0 0</xyz></axis></joint>
<joint name="bearing_out" type="revolute"><parent>world</parent><child>out</child>
<axis><xyz>1 0 0</xyz></axis></joint>
<joint name="cross" type="{kind}"><parent>{parent}</parent><child>{child}</child>
<axis><xyz expressed_in="__model__">{first}</xyz></axis>
<axis2><xyz expressed_in="__model__">{second}</xyz></axis2></joint>"""
IN, OUT = "0 1 0", "0 0 1"
"""Axes of the pins, in the plane of the shafts and normal to it."""


@pytest.mark.parametrize("kind", ["universal", "revolute2"])
@pytest.mark.parametrize("ends", [("in", "out", IN, OUT), ("out", "in", OUT, IN)])
def test_universal_joint(kind: str, ends: tuple[str, ...]) -> None:
    """Its first axis moves with the parent: as the cross of the bundled one with four pins."""
    words = dict(zip(("parent", "child", "first", "second"), ends, strict=True))
    mass = sdf.massive(1.0, "0 0 0")
    text = sdf.model(SHAFTS.format(mass=mass, angle=0.6, kind=kind, **words))
    positions = np.linspace(0.0, 6.0, 13)
    scene = {"drive": "bearing_in", "loads": {"bearing_out": -10.0}}
    found = cd.Scene(cd.load(text), **scene).sweep(positions)
    reference = cd.Scene(cd.load("universal_joint"), held={"joint_angle": 0.6}, **scene).sweep(
        positions
    )
    np.testing.assert_allclose(found.drive_effort, reference.drive_effort, rtol=1e-12)
    out = [sweep.motion.position("bearing_out") for sweep in (found, reference)]
    np.testing.assert_allclose(out[0], out[1], atol=1e-12)
    for joint in ("bearing_in", "bearing_out"):
        np.testing.assert_allclose(
            found[joint].bending, reference[joint].bending, atol=1e-11, rtol=0.0
        )


def test_gearbox() -> None:
    """Against the formula: the driven wheel's inertia counts with the square of the ratio."""
    wheels = "".join(
        f'<link name="{name}"><pose>{x} 0 0 0 0 0</pose>{sdf.massive(1.0, "0 0 0")}</link>'
        for name, x in (("ground", 5), ("one", 0), ("two", 1))
    )
    hinges = "".join(
        sdf.JOINT.format(
            name=f"turn_{name}", kind="continuous", parent="ground", child=name, pose=""
        )
        for name in ("one", "two")
    )
    gear = (
        '<joint name="mesh" type="gearbox"><parent>one</parent><child>two</child>'
        "<gearbox_ratio>2.5</gearbox_ratio><gearbox_reference_body>ground</gearbox_reference_body>"
        "<axis><xyz>0 0 1</xyz></axis><axis2><xyz>0 0 {}</xyz></axis2></joint>"
    )
    stand = '<joint name="s" type="fixed"><parent>world</parent><child>ground</child></joint>'
    for sense in (1, -1):
        text = sdf.model(wheels + hinges + gear.format(sense) + stand)
        turn = cd.Scene(cd.load(text), drive="turn_one").sweep([0.1, 0.2], acceleration=2.0)
        np.testing.assert_allclose(
            turn.motion.position("turn_two"), -sense * 2.5 * np.array([0.1, 0.2]), rtol=1e-13
        )
        np.testing.assert_allclose(turn.drive_effort, 2.0 * 0.025 * (1.0 + 2.5**2), rtol=1e-13)
