"""The second reading takes all numbers from the text, whatever numbers the first reader found."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest
from testkit import sdf
from testkit.disturbing import disturbed

import cardan_dyn as cd
from cardan_dyn.core.description.read import read
from cardan_dyn.core.description.second_reading import reread
from cardan_dyn.core.mechanism.rezero import rezeroed
from cardan_dyn.scene.usual_motion import usual_motion

ROUNDING = 1e-14
"""Placements are multiplied in another order than by the first reader."""


def both_agree(text: str, strict: bool = True) -> None:
    description = read(text, strict)
    wrong = disturbed(description)
    assert not wrong.agrees(description, ROUNDING)
    again = reread(wrong)
    for name in ("links", "joints", "loops", "couplings"):
        for found, expected in zip(getattr(again, name), getattr(description, name), strict=True):
            for field in fields(found):
                one, other = getattr(found, field.name), getattr(expected, field.name)
                if isinstance(one, np.ndarray):
                    np.testing.assert_allclose(one, other, atol=ROUNDING, rtol=0.0)
                elif field.name not in ("limits",):
                    assert one == other


@pytest.mark.parametrize(
    ("name", "seed"), [("universal_joint", 0), ("stewart_platform", 1), ("drive_line", 2)]
)
def test_poses_and_axes_in_any_frame(name: str, seed: int) -> None:
    mechanism = cd.load(name)
    motion = usual_motion(mechanism, samples=9).sweep().motion
    at = {joint: motion.position(joint)[3] for joint in mechanism if mechanism[joint].parts}
    both_agree(
        sdf.SdfText(
            rezeroed(mechanism.description, at, mechanism.characteristic_length), seed
        ).text()
    )


A = f'<link name="a"><pose degrees="1">1 2 3 10 20 30</pose>{sdf.massive(2.0, "1 2 3")}</link>'
B = '<link name="b"><pose {}="a">1 0 0 0.1 0.2 0.3</pose></link>'
JOINT = """<joint name="{}" type="{}"><parent>{}</parent><child>{}</child><axis>
<xyz>0 3 4</xyz>{}</axis></joint>"""
STAND = JOINT.format("s", "fixed", "world", "a", "")
TURN = JOINT.format("t", "revolute", "a", "b", "{}")


@pytest.mark.parametrize(
    "text",
    [
        *(sdf.four_bar(order, version) for order in ("abdc", "cbda") for version in ("1.4", "1.9")),
        sdf.model(A),
        sdf.model(A + B.format("relative_to") + TURN.format("") + STAND),
        sdf.model(A + B.format("frame") + TURN.format("") + STAND, "1.4"),
        sdf.model(
            A
            + B.format("frame")
            + TURN.format("<use_parent_model_frame>True</use_parent_model_frame>")
            + STAND,
            "1.6",
        ),
        sdf.model(A + B.format("relative_to") + JOINT.format("f", "fixed", "b", "a", "") + STAND),
        sdf.model(
            '<pose>1 2 3 0.1 0.2 0.3</pose><frame name="f" attached_to="b"><pose>0 1 0 0 0 1</pose>'
            '</frame><link name="b"><pose relative_to="f">0 0 0 0 1 0</pose></link>'.replace(
                ' relative_to="f"', ""
            )
        ).replace('name="m"', 'name="m" placement_frame="f"'),
        sdf.model("<static>TRUE</static>" + A + B.format("relative_to") + TURN.format("") + STAND),
        sdf.model('<link name="a"><inertial><mass>3</mass></inertial></link>'),
        sdf.model(A.replace("<pose>1 2 3 0 0 0</pose>", "<pose>1 2 3 0.1 0.2 0.3</pose>")),
    ],
)
def test_both_readers_find_the_same_numbers(text: str) -> None:
    both_agree(text)


def test_the_moving_one_of_several_models() -> None:
    ground = '<model name="g"><static>true</static><link name="a"/></model>'
    text = sdf.four_bar().replace("<model", f"{ground}<model", 1)
    both_agree(text)


def test_ratios() -> None:
    wheels = "".join(
        f'<link name="{name}"><pose>{x} 0 0 0.1 0 0</pose>{sdf.massive(1.0, "0 0 0")}</link>'
        + sdf.JOINT.format(name=f"t_{name}", kind="continuous", parent="world", child=name, pose="")
        for x, name in enumerate("abc")
    ).replace("<xyz>0 0 1</xyz>", "<xyz>0 0 -1</xyz>", 1)
    gear = (
        '<joint name="g" type="gearbox"><parent>a</parent><child>b</child><gearbox_ratio>2.5'
        "</gearbox_ratio><gearbox_reference_body>world</gearbox_reference_body>"
        "<axis/><axis2/></joint>"
    )
    mimic = "<axis><mimic joint='t_a'><multiplier>0.3</multiplier></mimic>"
    text = sdf.model(mimic.join(wheels.rsplit("<axis>", 1)) + gear)
    assert [coupling.ratio for coupling in read(text).couplings] == [0.3, 2.5]
    both_agree(text)


def test_a_wrong_number_of_the_first_reader_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """The proof of a sweep fails if the first reader takes a wrong mass."""
    from cardan_dyn.practice.formats.sdf import reader

    scene = {"drive": "a", "gravity": (0.0, -9.0, 0.0)}
    assert cd.Scene(cd.load(sdf.four_bar()), **scene).sweep([0.1]).balance_residual < 1e-12
    right = reader.number
    monkeypatch.setattr(
        reader,
        "number",
        lambda item, tag, *rest: right(item, tag, *rest) * (1.001 if tag == "mass" else 1.0),
    )
    with pytest.raises(cd.AccuracyError):
        cd.Scene(cd.load(sdf.four_bar()), **scene).sweep([0.1])
