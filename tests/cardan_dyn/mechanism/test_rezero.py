"""The same mechanism, described from another closed configuration."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from compare import sweep_of
from scenes import draw
from testkit import linkages
from testkit.bundled import EVERY_KIND
from testkit.mixed_chain import rows
from testkit.sdf import compare

import cardan_dyn as cd
from cardan_dyn.core.description.description import Limits
from cardan_dyn.core.description.read import read
from cardan_dyn.core.mechanism.rezero import rezeroed
from cardan_dyn.scene.presets import PRESETS
from cardan_dyn.scene.usual_motion import usual_motion

KINDS = ("revolute", "prismatic", "cylindrical", "universal", "planar", "spherical", "floating")
CHAIN = """<robot name="r"><link name="l0"/>{}</robot>"""
JOINT = """<link name="l{next}"><inertial><origin xyz="0.1 0.2 0.3"/><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="{kind}" type="{kind}">
<parent link="l{this}"/><child link="l{next}"/><origin xyz="0.3 -0.2 0.5" rpy="0.3 0.4 0.5"/>
<axis xyz="0.36 0.48 0.8"/><axis2 xyz="0.8 -0.6 0"/></joint>"""


def placed(mechanism: cd.Mechanism, x: np.ndarray) -> dict[str, np.ndarray]:
    """Return the placements of all links in the world, by Pinocchio, at a row of coordinates."""
    data = mechanism.model.createData()
    pin.forwardKinematics(mechanism.model, data, mechanism.coordinates.configuration(x[None])[0])
    return {
        name: (data.oMi[body] * frame).homogeneous
        for name, (body, frame) in mechanism.links.items()
    }


def of_row(mechanism: cd.Mechanism, x: np.ndarray) -> dict[str, np.ndarray]:
    return {name: x[columns] for name, columns in mechanism.coordinates.columns.items()}


@pytest.mark.parametrize("kinds", [*((kind,) for kind in KINDS), KINDS], ids=str)
def test_links_stay_where_they_are(kinds: tuple[str, ...]) -> None:
    """Against Pinocchio's kinematics; one joint of every type about oblique axes, and all in a row.

    Beyond its new zero, a joint still moves as before: the twists of the links are the same.
    """
    parts = (
        JOINT.format(kind=kind, this=count, next=count + 1) for count, kind in enumerate(kinds)
    )
    mechanism = cd.load(CHAIN.format("".join(parts)))
    (x,) = rows(mechanism, 1)
    again = cd.Mechanism(
        rezeroed(mechanism.description, of_row(mechanism, x), mechanism.characteristic_length)
    )
    neutral = again.coordinates.neutral()
    expected, found = placed(mechanism, x), placed(again, neutral)
    for link, placement in expected.items():
        np.testing.assert_allclose(found[link], placement, atol=1e-14)
    columns = []
    for item, row in ((mechanism, x), (again, neutral)):
        q = item.coordinates.configuration(row[None])[0]
        index, _ = item.links[f"l{len(kinds)}"]
        data = item.model.createData()
        jacobian = pin.computeJointJacobian(item.model, data, q, index)
        columns.append(data.oMi[index].action @ jacobian)
    if "planar" in kinds or "floating" in kinds:
        # Their slides count along axes that turn; what they span is the same.
        spans = [np.linalg.qr(item)[0] for item in columns]
        projections = [span @ span.T for span in spans]
        np.testing.assert_allclose(projections[0], projections[1], atol=1e-13)
    else:
        np.testing.assert_allclose(columns[0], columns[1], atol=1e-13)


def test_angles_behind_the_new_zero() -> None:
    """Coordinates of joints with angles and slides are those from the old zero less the start."""
    kinds = ("revolute", "universal", "prismatic", "cylindrical")
    parts = (
        JOINT.format(kind=kind, this=count, next=count + 1) for count, kind in enumerate(kinds)
    )
    mechanism = cd.load(CHAIN.format("".join(parts)))
    x, beyond = rows(mechanism, 2)
    again = cd.Mechanism(
        rezeroed(mechanism.description, of_row(mechanism, x), mechanism.characteristic_length)
    )
    expected, found = placed(mechanism, beyond), placed(again, beyond - x)
    for link, placement in expected.items():
        np.testing.assert_allclose(found[link], placement, atol=1e-14)


@pytest.mark.parametrize("name", EVERY_KIND)
def test_bundled_mechanisms_have_the_same_wrenches(name: str) -> None:
    mechanism, preset = cd.load(name), PRESETS[name]
    motion = usual_motion(mechanism, samples=9).sweep().motion
    at = {joint: motion.position(joint)[3] for joint in mechanism if mechanism[joint].parts}
    again = cd.Mechanism(rezeroed(mechanism.description, at, mechanism.characteristic_length))
    held = {joint: float(at[joint]) for joint in preset.held_deg}
    origin = np.array([[float(at[joint]) for joint in preset.drive]])
    steps = np.linspace(0.0, 0.05, 3)[:, None] * np.ones(len(preset.drive))
    sweeps = []
    for item, positions, holding in (
        (again, steps, dict.fromkeys(held, 0.0)),
        (mechanism, origin + steps, held),
    ):
        options = {"loads": dict(preset.loads), "gravity": (0.3, -0.2, -9.0)}
        start = {name: x for name, x in at.items() if np.ndim(x) == 0 and name not in held}
        assembled = {"near": start} if item is mechanism else {}
        scene = cd.Scene(item, drive=list(preset.drive), held=holding, **options, **assembled)
        sweeps.append(scene.sweep(positions, speed=2.0, acceleration=-1.0))
    # In the joints' own axes: their frames move with the child as before.
    assert compare(*sweeps, tolerance=1e-12 * max(1.0, float(sweeps[1].condition.max()) / 10.0))
    for joint in mechanism.joint_names:
        np.testing.assert_array_equal(sweeps[0][joint].unique, sweeps[1][joint].unique)


class Text:
    """Stands for a chain of which only the text is read."""

    def __init__(self, text: str) -> None:
        self.text = text


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_random_chains_have_the_same_wrenches(seed: int) -> None:
    """At the configuration itself; rates of slides that turn would have other meanings."""
    drawn = draw(seed)
    reference = sweep_of(drawn)
    mechanism = reference.mechanism
    names = [name for name in mechanism if mechanism[name].parts]
    at = {name: np.atleast_1d(reference.motion.position(name)[0]) for name in names}
    again = cd.Mechanism(rezeroed(mechanism.description, at, mechanism.characteristic_length))
    zero = np.zeros((1, len(drawn.drives)))
    found = sweep_of(
        replace(
            drawn,
            chain=Text(again.to_urdf()),
            positions=zero,
            speeds=drawn.speeds[:1],
            accelerations=drawn.accelerations[:1],
            held=dict.fromkeys(drawn.held, 0.0),
        )
    )
    first = sweep_of(
        replace(
            drawn,
            positions=drawn.positions[:1],
            speeds=drawn.speeds[:1],
            accelerations=drawn.accelerations[:1],
        )
    )
    # The least norm weighs with the mechanism's length, which slides change.
    compare(found, first, 1e-9, decided=True)


def test_limits_are_counted_from_the_new_zero() -> None:
    text = linkages.four_bar(linkages.loop("continuous")).replace(
        '<axis xyz="0 0 1"/></joint>',
        '<axis xyz="0 0 1"/><limit lower="-1" upper="2" velocity="3" effort="4"/></joint>',
        1,
    )
    text = text.replace('name="a" type="continuous"', 'name="a" type="revolute"')
    mechanism = cd.load(text)
    motion = cd.Scene(mechanism, drive="a").sweep([0.25]).motion
    at = {name: motion.position(name)[0] for name in "abcd"}
    again = rezeroed(mechanism.description, at, mechanism.characteristic_length)
    assert again.joints[0].limits == Limits(-1.25, 1.75, 3.0, 4.0)
    assert again.source is None


def test_couplings_keep_holding() -> None:
    text = linkages.gears(linkages.coupling("g", "a", "b", -2.5))
    mechanism = cd.load(text)
    again = rezeroed(mechanism.description, {"a": 0.4, "b": -1.0}, mechanism.characteristic_length)
    turn = cd.Scene(cd.Mechanism(again), drive="a").sweep([0.1])
    np.testing.assert_allclose(turn.motion.position("b"), [-0.25], rtol=1e-13)
    with pytest.raises(cd.ArgumentError, match="'g' does not hold: its successor is at 1, its"):
        rezeroed(mechanism.description, {"a": 0.4, "b": 1.0}, mechanism.characteristic_length)


FOUR = {"a": 0.0, "b": 0.0, "c": 0.0, "d": 0.0}
BAD = {
    "missing": ({"a": 0.0, "b": 0.0}, "complete configuration; there is no position of c, d"),
    "unknown": ({**FOUR, "e": 0.0}, "at: no joint 'e' moves; joints: a, b, c, d"),
    "shape": ({**FOUR, "a": [0.0, 1.0]}, r"at\['a'\] has shape \(2,\); a continuous joint has 1"),
    "text": ({**FOUR, "a": "zero"}, r"at\['a'\]"),
    "nan": ({**FOUR, "a": np.nan}, "not finite"),
    "open": ({**FOUR, "a": 0.1}, "at: the loop 'c' is open by 0.3.* m"),
    "turned": ({**FOUR, "c": 0.1}, "at: the loop 'c' is open by .* m, 0.0998.* rad"),
    "no mapping": ([0.0], "at is .*, expected a mapping"),
}


@pytest.mark.parametrize(("at", "message"), BAD.values(), ids=BAD.keys())
def test_positions_that_are_refused(at: dict, message: str) -> None:
    description = read(linkages.four_bar(linkages.loop("continuous")))
    assert rezeroed(description, FOUR, 1.0).agrees(description, 1e-15)
    with pytest.raises(cd.ArgumentError, match=message):
        rezeroed(description, at, 1.0)


def test_a_quaternion_has_length_1() -> None:
    description = read(CHAIN.format(JOINT.format(kind="spherical", this=0, next=1)))
    rezeroed(description, {"spherical": [0.6, 0.0, 0.0, -0.8]}, 1.0)
    with pytest.raises(cd.ArgumentError, match="the quaternion has length 2, expected 1"):
        rezeroed(description, {"spherical": [0.0, 0.0, 0.0, 2.0]}, 1.0)


def spherical(noise: float) -> cd.Mechanism:
    """A spherical four-bar with its masses beside a point that the frames of its joints miss."""
    rng = np.random.default_rng(0)

    def origin() -> str:
        return f'<origin xyz="{" ".join(map(repr, (noise * rng.uniform(-1, 1, 3)).tolist()))}"/>'

    def joint(name: str, parent: str, child: str, axis: str) -> str:
        ends = f'<parent link="{parent}"/><child link="{child}"/>'
        return (
            f'<joint name="{name}" type="continuous">{ends}{origin()}<axis xyz="{axis}"/></joint>'
        )

    body = (
        '<inertial><origin xyz="0.1 0.02 0.03"/><mass value="1"/><inertia ixx="0.01" iyy="0.01" '
        'izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    return cd.load(
        '<robot name="spherical"><link name="base"/>'
        + "".join(f'<link name="{name}">{body}</link>' for name in "abc")
        + joint("in", "base", "a", "0 0 1")
        + joint("mid", "a", "b", "0.6 0 0.8")
        + joint("out", "base", "c", "0 0.6 0.8")
        + f'<loop name="end" type="continuous"><predecessor link="b">{origin()}</predecessor>'
        f'<successor link="c">{origin()}</successor><axis xyz="0.4 0.5 0.77"/></loop></robot>'
    )


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 1e-14, 1e-13])
def test_joints_meet_in_a_point_but_for_rounding(noise: float, tmp_path: Path) -> None:
    """How far a loop may be open is told by the masses, where joints are no distance apart."""
    mechanism = spherical(noise)
    turn = cd.Scene(mechanism, drive="in").sweep([0.3])
    at = {name: turn.motion.position(name) for name in mechanism}
    again = cd.load(cd.write(mechanism, tmp_path / "spherical.urdf", at=at))
    assert cd.Scene(again, drive="in").sweep([0.0]).loop_residual < 1e-11
    with pytest.raises(cd.ArgumentError, match=r"`assemble` or `Scene\.configuration` returns"):
        cd.write(mechanism, tmp_path / "open.urdf", at={**at, "in": 0.31})
