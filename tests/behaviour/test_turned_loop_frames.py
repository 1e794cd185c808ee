"""Loops whose two frames are turned about, or shifted along, what their joints leave free.

Where the tree is at zero, only the coordinates of such loops are not: no body is to move.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from compare import scene_of
from scenes import draw
from scipy.spatial.transform import Rotation
from testkit.linkages import POSITIONS, RATES, four_bar, loop
from testkit.other_notations import TREE

import cardan_dyn as cd

TURNS = (-3.0, -2.1, -0.9, 0.5, 1.3, 2.5, float(np.pi))
SCENE = {"drive": "a", "loads": {"d": -3.0}, "gravity": (0.0, -9.81, 0.0)}
LEGS = tuple(f"leg_{k}" for k in range(6))


def urdf_plus(turn: float) -> str:
    origin = '<origin xyz="2 2 0"/>'
    text = four_bar(loop("revolute"))
    return text.replace(origin, f'<origin xyz="2 2 0" rpy="0 0 {turn}"/>')


def isaac(turn: float) -> str:
    return TREE.format(
        f'<loop_joint name="c" type="revolute"><link1 link="coupler" xyz="2 2 0" rpy="0 0 {turn}"/>'
        '<link2 link="rocker" xyz="0 2.5 0" rpy="0 0 0"/><axis xyz="0 0 1"/></loop_joint>'
    )


def constraint(turn: float) -> str:
    return TREE.format(
        '<constraint name="c" type="revolute"><parent link="coupler"/>'
        '<parent_origin xyz="2 2 0"/><parent_axis xyz="0 0 1"/><child link="rocker"/>'
        f'<child_origin xyz="0 2.5 0" rpy="0 0 {-turn}"/></constraint>'
    )


def rocker_angles(crank: np.ndarray) -> np.ndarray:
    """The rocker of `four_bar`, as the triangle of its end, the crank's end and the pivot has it.

    At zero its end is to the left of the way from the pivot to the crank's end, seen from above.
    """
    pin, pivot = 0.5j * np.exp(1j * crank), 2.0
    way = pin - pivot
    distance = np.abs(way)
    cosine = (distance**2 + 2.5**2 - 8.0) / (2.0 * distance * 2.5)
    end = way / distance * np.exp(-1j * np.arccos(cosine))
    return np.unwrap(np.angle(end / 1j))


@pytest.mark.parametrize("turn", TURNS[::3])
@pytest.mark.parametrize("notation", [urdf_plus, isaac, constraint])
def test_a_pin_may_be_turned_about_its_axis(notation: object, turn: float) -> None:
    aligned = cd.Scene(cd.load(four_bar(loop("revolute"))), **SCENE)
    turned = cd.Scene(cd.load(notation(turn)), **SCENE)  # type: ignore[operator]
    expected, found = (scene.sweep(POSITIONS, **RATES) for scene in (aligned, turned))
    rocker = found.motion.position("d")
    np.testing.assert_allclose(rocker, rocker_angles(POSITIONS), atol=1e-13)
    np.testing.assert_allclose(found.drive_effort, expected.drive_effort, rtol=1e-11, atol=1e-10)
    own = found.motion.position("c") - expected.motion.position("c")
    np.testing.assert_allclose(own, -turn if turn < np.pi else np.pi, atol=1e-12)
    assert cd.assemble(turned.mechanism).zero_residual < 1e-14


@pytest.mark.parametrize("turn", [*TURNS, -float(np.pi), 3.12, float(np.pi) - 1e-10])
def test_a_bushing_at_a_turned_pin_is_not_wound(turn: float) -> None:
    """It has no deformation at the tree's zero, wherever the angle of the pin counts from."""
    stiffness = 5.0

    def energy(crank: np.ndarray) -> np.ndarray:
        rocker = rocker_angles(crank)
        bar = 2.0 + 2.5j * np.exp(1j * rocker) - 0.5j * np.exp(1j * crank)
        twist = rocker - np.angle(bar / (2.0 + 2.0j))
        return 0.5 * stiffness * (twist - twist[0]) ** 2

    way, step = np.linspace(0.0, 2.0, 9), 1e-5
    ahead, behind = (energy(np.append(0.0, way + sign * step))[1:] for sign in (1.0, -1.0))
    bushing = cd.Bushing("coupler", "rocker", (2.0, 2.0, 0.0), (0, 0, 0, stiffness, 1.0, stiffness))
    found = cd.Scene(cd.load(urdf_plus(turn)), drive="a", elements=[bushing]).sweep(way)
    np.testing.assert_allclose(found.drive_effort, (ahead - behind) / (2.0 * step), atol=1e-8)


def test_gepetto_may_turn_a_ball(tmp_path: Path) -> None:
    text = TREE.format("")
    frames = (("one", "coupler", "2 2 0", "0.4 -1.2 2.2"), ("two", "rocker", "0 2.5 0", "0 2 -0.6"))
    for name, host, place, rpy in frames:
        text = text.replace(
            "</robot>",
            f'<link name="{name}"/><joint name="{name}_frame" type="fixed"><parent link="{host}"/>'
            f'<child link="{name}"/><origin xyz="{place}" rpy="{rpy}"/></joint></robot>',
        )
    path = tmp_path / "bars.urdf"
    path.write_text(text, encoding="utf-8")
    path.with_suffix(".yaml").write_text(
        "closed_loop: [[one, two]]\ntype: [3d]\nname_mot: [a]\n", encoding="utf-8"
    )
    found = cd.Scene(cd.load(path), **SCENE).sweep(POSITIONS, **RATES)
    expected = cd.Scene(cd.load(four_bar(loop("spherical"))), **SCENE).sweep(POSITIONS, **RATES)
    np.testing.assert_allclose(found.motion.position("d"), rocker_angles(POSITIONS), atol=1e-13)
    np.testing.assert_allclose(found.drive_effort, expected.drive_effort, rtol=1e-11, atol=1e-10)


def gough_platform(rng: np.random.Generator) -> tuple[str, np.ndarray]:
    """A general platform on six legs, closed at zero by balls whose frames stand anyhow."""

    def turned(values: np.ndarray) -> str:
        return " ".join(repr(float(value)) for value in values)

    parts = ['<robot name="gough"><link name="ground"/>']
    inertial = (
        '<inertial><origin xyz="0.05 -0.02 0.1"/><mass value="{}"/>'
        '<inertia ixx="0.2" iyy="0.3" izz="0.25"/></inertial>'
    )
    centre = np.array([0.1, -0.2, 1.5])
    turn = Rotation.from_rotvec([0.2, -0.1, 0.4])
    parts.append(f'<link name="top">{inertial.format(4.0)}</link>')
    parts.append(
        '<joint name="free" type="floating"><parent link="ground"/><child link="top"/>'
        f'<origin xyz="{turned(centre)}" rpy="{turned(turn.as_euler("xyz"))}"/></joint>'
    )
    for k, name in enumerate(LEGS):
        angle = np.pi / 3.0 * k
        foot = np.array([np.cos(angle), np.sin(angle), 0.0]) + rng.uniform(-0.2, 0.2, 3)
        corner = 0.6 * np.array([np.cos(angle + 0.5), np.sin(angle + 0.5), 0.0])
        corner = corner + rng.uniform(-0.1, 0.1, 3)
        way = centre + turn.apply(corner) - foot
        length = float(np.linalg.norm(way))
        frame, _ = Rotation.align_vectors([way / length], [[0.0, 0.0, 1.0]])
        parts += [
            f'<link name="foot_{k}">{inertial.format(1.0)}</link>',
            f'<link name="rod_{k}">{inertial.format(0.5)}</link>',
            f'<joint name="base_{k}" type="universal"><parent link="ground"/>'
            f'<child link="foot_{k}"/><origin xyz="{turned(foot)}" '
            f'rpy="{turned(frame.as_euler("xyz"))}"/><axis xyz="1 0 0"/><axis2 xyz="0 1 0"/>'
            f'</joint><joint name="{name}" type="prismatic"><parent link="foot_{k}"/>'
            f'<child link="rod_{k}"/><origin xyz="0 0 {length!r}"/><axis xyz="0 0 1"/>'
            '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
            f'<loop name="ball_{k}" type="spherical"><predecessor link="rod_{k}">'
            f'<origin xyz="0 0 0" rpy="{turned(rng.uniform(-np.pi, np.pi, 3))}"/></predecessor>'
            f'<successor link="top"><origin xyz="{turned(corner)}" '
            f'rpy="{turned(rng.uniform(-np.pi, np.pi, 3))}"/></successor></loop>',
        ]
    return "\n".join([*parts, "</robot>"]), centre


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_a_platform_on_balls_stays_where_it_is_described(seed: int) -> None:
    text, centre = gough_platform(np.random.default_rng(seed))
    mechanism = cd.load(text)
    gravity = (0.0, 0.0, -9.81)
    scene = cd.Scene(mechanism, drive=list(LEGS), gravity=gravity)
    start = scene.configuration()
    for name in (*LEGS, "base_0", "base_5"):
        np.testing.assert_allclose(start.positions[name], 0.0, atol=1e-12)
    np.testing.assert_allclose(start.origin("free"), centre, atol=1e-12)
    # The feet carry the whole weight.
    turn = scene.sweep(np.zeros((1, 6)))
    total = sum(turn.wrench(f"base_{k}", "world").force[0] for k in range(6))
    np.testing.assert_allclose(total, [0.0, 0.0, 9.81 * (4.0 + 6 * 1.5)], atol=1e-9)


@pytest.mark.parametrize("seed", range(15, 28))
def test_the_zero_has_loops_where_they_were_turned_to(seed: int) -> None:
    """Against how the frames were turned when the chain was drawn."""
    case = draw(seed, turns=True)
    mechanism = cd.load(case.chain.text)
    for name, joint in case.chain.joints.items():
        if name not in mechanism.coordinates.columns:
            continue
        zero = mechanism.zero[mechanism.coordinates.columns[name]]
        expected = mechanism.coordinates.neutral()[mechanism.coordinates.columns[name]]
        expected = expected if joint.zero is None else joint.zero
        if joint.type == "spherical":
            zero, expected = zero * np.sign(zero[3]), expected * np.sign(expected[3])
        np.testing.assert_allclose(zero, expected, atol=1e-13 * max(1.0, case.chain.size))


def test_balls_as_turns_fit_as_well() -> None:
    turns = Rotation.from_rotvec([0.8, -1.1, 0.6])
    rpy = " ".join(map(repr, turns.as_euler("xyz").tolist()))
    text = four_bar(loop("spherical")).replace(
        '<origin xyz="2 2 0"/>', f'<origin xyz="2 2 0" rpy="{rpy}"/>'
    )
    variant = cd.load(text).variant(cardan=["c"])
    found = variant.zero[variant.coordinates.columns["c"]]
    np.testing.assert_allclose(found, turns.inv().as_euler("XYZ"), atol=1e-15)


def test_a_start_of_the_tree_alone_is_taken_as_it_is() -> None:
    """The other way of putting the bars together, which no way from zero leads to."""
    text = urdf_plus(1.9)
    crank = np.array([0.4])
    rocker = rocker_angles(crank)[0]
    way = 0.5j * np.exp(1j * crank[0]) - 2.0
    # Reflected in the way from the pivot to the crank's end.
    mirrored = 2.0 * np.angle(way / 1j) - rocker
    end = 2.0 + 2.5j * np.exp(1j * mirrored)
    coupler = np.angle((end - 0.5j * np.exp(1j * crank[0])) / (2.0 + 2.0j)) - crank[0]
    start = {"a": 0.4, "b": coupler, "d": mirrored}
    mechanism = cd.load(text)
    assert cd.assemble(mechanism, start).positions["d"] == mirrored
    turn = cd.Scene(mechanism, drive="a", near=start).sweep([0.4])
    np.testing.assert_allclose(turn.motion.position("d"), mirrored, atol=1e-13)


@pytest.mark.parametrize("suffix", ["urdf", "xml"])
def test_what_is_written_keeps_the_zero_of_the_tree(tmp_path: Path, suffix: str) -> None:
    mechanism = cd.load(urdf_plus(-2.4))
    again = cd.load(cd.write(mechanism, tmp_path / f"bars.{suffix}"))
    for item in (mechanism, again):
        assert cd.assemble(item).zero_residual < 1e-14
        np.testing.assert_allclose(cd.assemble(item).positions["d"], 0.0, atol=1e-14)


def test_describing_moves_nothing() -> None:
    turned, aligned = (cd.describe(cd.load(urdf_plus(turn))) for turn in (2.0, 0.0))
    assert turned.components == aligned.components
    assert [loop.rank for loop in turned.loops] == [loop.rank for loop in aligned.loops]


def test_the_proof_sees_a_closed_zero_that_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cd.Mechanism, "fitted", lambda self, x, fixed=(): x)
    for turn in (-2.1, 1.3):
        mechanism = cd.load(urdf_plus(turn))
        with pytest.raises(cd.AccuracyError, match=r"closed to .* bodies were moved"):
            cd.Scene(mechanism, drive="a")
        with pytest.raises(cd.AccuracyError, match=r"closed to .* bodies were moved"):
            cd.assemble(mechanism)


@pytest.mark.parametrize("seed", range(8))
def test_no_random_chain_starts_elsewhere(seed: int) -> None:
    case = draw(500 + seed, turns=True)
    mechanism = scene_of(case).mechanism
    tree = [joint.name for joint in case.chain.joints.values() if not joint.closes]
    zero = cd.assemble(mechanism)
    assert zero.zero_residual < 1e-13
    for name in tree:
        if name in zero.positions:
            expected = mechanism.coordinates.neutral()[mechanism.coordinates.columns[name]]
            np.testing.assert_array_equal(np.atleast_1d(zero.positions[name]), expected)
