"""Double shafts in W and spatial arrangement: uniform output, and the force between the joints.

Everything is compared with pins and shafts as vectors, the support forces also with the formulas
that the catalogues of cardan shafts print for two positions.
"""

from __future__ import annotations

import re

import numpy as np
import pytest
from testkit.shaft_line import ShaftLine, about, across, dot
from testkit.urdf_reader import Reader, text

import cardan_dyn as cd
from cardan_dyn.analytic import support_forces

LENGTH = 0.9
POSITIONS = np.linspace(0.0, 2.0 * np.pi, 721)
# Exactly representable main positions, beside those that linspace rounds.
POSITIONS[[0, 180, 360, 540, 720]] = [0.0, 0.5 * np.pi, np.pi, 1.5 * np.pi, 2.0 * np.pi]
X, Y, Z = np.eye(3)
# Catalogue 6.3, Bild 19: side view (V) and plan view (H).
V_1, H_1, V_2, H_2 = np.radians([15.0, 7.0, -11.5, 12.0])


def w_line(beta_1: float, beta_2: float) -> ShaftLine:
    """The W arrangement: both joints bend about z in the same sense."""
    shafts = np.array([X, about("z", beta_1) @ X, about("z", beta_1 + beta_2) @ X])
    return ShaftLine.turn(shafts, Y, POSITIONS, (0.0,))


def w_scene(beta_1: float, beta_2: float, load: float = -50.0, **options: object) -> cd.Scene:
    held = {"joint_angle_1": beta_1, "joint_angle_2": beta_2}
    return scene("double_shaft_w", held, load, **options)


def scene(urdf: str, held: dict[str, float], load: float, **options: object) -> cd.Scene:
    return cd.Scene(
        cd.load(urdf), drive="bearing_in", held=held, loads={"bearing_out": load}, **options
    )


def slopes(v: float, h: float) -> np.ndarray:
    """Direction with these angles in side view and plan view, and one along x."""
    return np.array([1.0, np.tan(h), np.tan(v)])


def held_angles(v_1: float, h_1: float, v_2: float, h_2: float) -> dict[str, float]:
    """The held joints that show these projections, as the description's header says."""
    return {
        "joint_angle_1_h": h_1,
        "joint_angle_1_v": float(np.arctan(np.tan(v_1) * np.cos(h_1))),
        "joint_angle_2_h": h_2,
        "joint_angle_2_v": float(np.arctan(np.tan(v_2) * np.cos(h_2))),
    }


def offset(v_1: float, h_1: float, v_2: float, h_2: float) -> float:
    """Angle about x from the bending plane of joint 1 to that of joint 2, to half a turn."""
    plane_1, plane_2 = (np.arctan2(np.tan(v), np.tan(h)) for v, h in ((v_1, h_1), (v_2, h_2)))
    return float((plane_2 - plane_1) % np.pi)


def matching(v_1: float, h_1: float, v_2: float, h_2: float) -> tuple[float, float]:
    """The second joint's projections in the same plane, with the angle of the first joint."""
    tan_1, tan_2 = (np.hypot(np.tan(v), np.tan(h)) for v, h in ((v_1, h_1), (v_2, h_2)))
    return tuple(float(np.arctan(np.tan(angle) * tan_1 / tan_2)) for angle in (v_2, h_2))


def spatial_frames(angles: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """Axes of both housings: x along the shaft, y horizontal, in columns."""
    housing_in = about("z", -angles["joint_angle_1_h"]) @ about("y", angles["joint_angle_1_v"])
    housing_out = about("z", angles["joint_angle_2_h"]) @ about("y", -angles["joint_angle_2_v"])
    return housing_in, housing_out


def spatial_line(angles: dict[str, float], gamma: float) -> ShaftLine:
    housing_in, housing_out = spatial_frames(angles)
    shafts = np.array([housing_in[:, 0], X, housing_out[:, 0]])
    return ShaftLine.turn(shafts, housing_in[:, 1], POSITIONS, (gamma,))


def pin_in_plane(housing_in: np.ndarray) -> float:
    """Rotation at which the input fork's pin lies in the bending plane of joint 1."""
    along, level, upright = housing_in.T
    plane = across(X, along)
    return float(np.arctan2(plane @ upright, plane @ level))


def fork_offset_of_the_file() -> float:
    element = Reader(text("double_shaft_spatial")).element("joint", "slip").find("origin")
    return float(element.get("rpy").split()[0])


@pytest.mark.parametrize("beta_deg", [0.0, 1.0, 8.5, 25.0, 44.0])
def test_w_with_equal_angles_turns_uniformly(beta_deg: float) -> None:
    beta = np.deg2rad(beta_deg)
    turn = w_scene(beta, beta, load=-1.0).sweep(POSITIONS)
    assert np.max(np.abs(turn.motion.position("bearing_out") - POSITIONS)) < 1e-13
    assert np.max(np.abs(turn.motion.ratio("bearing_out") - 1.0)) < 1e-13
    assert np.max(np.abs(turn.drive_effort - 1.0)) < 1e-13
    assert np.max(np.abs(turn.motion.position("slip"))) < 1e-13
    assert np.all([turn[name].unique for name in turn.outputs])


def test_fork_offset_of_the_spatial_shaft() -> None:
    """The angle of the catalogue's example: 71° read from its diagram, 70.873° computed."""
    gamma = fork_offset_of_the_file()
    assert gamma == pytest.approx(offset(V_1, H_1, V_2, H_2), abs=1e-15)
    assert np.degrees(gamma) == pytest.approx(70.873, abs=5e-4)
    assert round(np.degrees(gamma)) == 71


def test_spatial_shaft_shows_the_projections() -> None:
    """The held angles are those of Bild 19 in both views, and make its joint angles."""
    angles = held_angles(V_1, H_1, V_2, H_2)
    turn = scene("double_shaft_spatial", angles, -1.0).sweep([0.4])
    e_1, e_3 = (turn.wrench(name, "world").axis[0] for name in ("bearing_in", "bearing_out"))
    e_2 = turn.wrench("slip", "world").axis[0]
    np.testing.assert_allclose(e_2, X, atol=1e-14)
    # The next shaft rises and turns left against the one before.
    np.testing.assert_allclose(e_1 / e_1[0], slopes(-V_1, -H_1), atol=1e-14)
    np.testing.assert_allclose(e_3 / e_3[0], slopes(V_2, H_2), atol=1e-14)
    for first, second, beta_deg in ((e_1, e_2, 16.4225), (e_2, e_3, 16.3956)):
        angle = np.degrees(np.arctan2(np.linalg.norm(np.cross(first, second)), first @ second))
        assert angle == pytest.approx(beta_deg, abs=5e-5)
    header = text("double_shaft_spatial").split("-->")[0]
    stated = [float(value) for value in re.findall(r"-?\d+\.\d{4}(?=°)", header)]
    assert stated[:2] == pytest.approx(
        [np.degrees(angles[f"joint_angle_{k}_v"]) for k in (1, 2)], abs=5e-5
    )


def test_spatial_shaft_with_equal_angles_turns_uniformly() -> None:
    """Equal joint angles in the planes of Bild 19, for which the fork offset is made."""
    v_2, h_2 = matching(V_1, H_1, V_2, H_2)
    assert offset(V_1, H_1, v_2, h_2) == pytest.approx(fork_offset_of_the_file(), abs=1e-15)
    turn = scene("double_shaft_spatial", held_angles(V_1, H_1, v_2, h_2), -1.0).sweep(POSITIONS)
    lead = turn.motion.position("bearing_out") - POSITIONS
    assert np.max(np.abs(lead - lead[0])) < 1e-13
    assert np.max(np.abs(turn.motion.ratio("bearing_out") - 1.0)) < 1e-13
    assert np.max(np.abs(turn.drive_effort - 1.0)) < 1e-13
    assert np.all([turn[name].unique for name in turn.outputs])


def test_spatial_shaft_as_in_the_example() -> None:
    """With its slightly different angles a residual is left: cos β_E = cos β₁ / cos β₂."""
    angles = held_angles(V_1, H_1, V_2, H_2)
    beta_1, beta_2 = (
        np.arctan(np.hypot(np.tan(v), np.tan(h))) for v, h in ((V_1, H_1), (V_2, H_2))
    )
    # Main positions: the driving pin of joint 1 in its bending plane, or normal to it.
    in_plane = pin_in_plane(spatial_frames(angles)[0])
    turn = scene("double_shaft_spatial", angles, -1.0).sweep(in_plane + 0.5 * np.pi * np.arange(4))
    residual = np.cos(beta_1) / np.cos(beta_2)
    expected = [1.0 / residual, residual, 1.0 / residual, residual]
    np.testing.assert_allclose(turn.motion.ratio("bearing_out"), expected, rtol=1e-13)
    assert 1e-4 < 1.0 - residual < 2e-4


@pytest.mark.parametrize("gamma_deg", [None, 0.0, -70.873, 30.0])
def test_spatial_motion_follows_the_pins(gamma_deg: float | None) -> None:
    """Right and wrong fork offsets: the motion of the pins as vectors."""
    urdf, gamma = text("double_shaft_spatial"), fork_offset_of_the_file()
    if gamma_deg is not None:
        wrong = float(np.deg2rad(gamma_deg))
        assert urdf.count(f'rpy="{gamma!r} 0 0"') >= 2  # the slip joint and the closing loop
        urdf = urdf.replace(f'rpy="{gamma!r} 0 0"', f'rpy="{wrong!r} 0 0"')
        gamma = wrong
    v_2, h_2 = matching(V_1, H_1, V_2, H_2)
    angles = held_angles(V_1, H_1, v_2, h_2)
    turn = scene(urdf, angles, -1.0).sweep(POSITIONS)
    line = spatial_line(angles, gamma)
    y, z = spatial_frames(angles)[1][:, 1:].T
    # At bearing_out = 0 the output fork's pin is turned by the offset, like the second cross.
    expected = line.output_rotation(y, z) - gamma
    expected -= np.pi * np.round(expected[0] / np.pi)
    assert np.max(np.abs(turn.motion.position("bearing_out") - expected)) < 1e-13
    moments = line.moments(1.0)
    torque = dot(moments[0], line.shafts[0])
    assert np.max(np.abs(turn.drive_effort - torque)) < 1e-13 * np.max(torque)
    spread = np.ptp(turn.motion.ratio("bearing_out"))
    assert (spread < 1e-13) if gamma_deg is None else (spread > 0.05)


CASES = {
    "W 25° 25°": (25.0, 25.0),
    "W 10° 30°": (10.0, 30.0),
    "Bild 19": None,
}


@pytest.fixture(params=CASES, scope="module")
def loaded(request: pytest.FixtureRequest) -> tuple[cd.Sweep, ShaftLine]:
    """A sweep under an output torque of 50 N·m, and its pins and shafts."""
    case = CASES[request.param]
    if case is not None:
        beta_1, beta_2 = np.radians(case)
        return w_scene(beta_1, beta_2).sweep(POSITIONS), w_line(beta_1, beta_2)
    angles = held_angles(V_1, H_1, V_2, H_2)
    turn = scene("double_shaft_spatial", angles, -50.0).sweep(POSITIONS)
    return turn, spatial_line(angles, fork_offset_of_the_file())


def test_moments_of_both_crosses(loaded: tuple[cd.Sweep, ShaftLine]) -> None:
    turn, line = loaded
    moment_1, moment_2 = line.moments(50.0)
    scale = np.max(np.abs(moment_1))
    for name, expected in (
        ("bearing_in", moment_1),
        ("pin_1_in", moment_1),
        ("pin_1_out", moment_1),
        ("slip", moment_2),  # about the centre of joint 2
        ("pin_2_in", moment_2),
        ("pin_2_out", moment_2),
        ("bearing_out", -moment_2),
    ):
        computed = turn.wrench(name, "world").moment
        assert np.max(np.abs(computed - expected)) < 1e-13 * scale, name
    assert np.max(np.abs(turn["bearing_out"].torsion + 50.0)) < 1e-13 * scale


def test_force_of_the_intermediate_shaft(loaded: tuple[cd.Sweep, ShaftLine]) -> None:
    """P = (M₁ - M₂) × e₂ / L goes through the whole line, with its sign in every joint."""
    turn, line = loaded
    moment_1, moment_2 = line.moments(50.0)
    force = np.cross(moment_1 - moment_2, line.shafts[1]) / LENGTH
    scale = np.max(np.abs(moment_1)) / LENGTH
    assert np.max(np.abs(force)) > 0.2 * scale
    for name, sign in (
        ("bearing_in", 1.0),
        ("pin_1_in", 1.0),
        ("pin_1_out", 1.0),
        ("slip", 1.0),
        ("pin_2_in", 1.0),
        ("pin_2_out", 1.0),
        ("bearing_out", -1.0),
    ):
        computed = turn.wrench(name, "world").force
        assert np.max(np.abs(computed - sign * force)) < 1e-13 * scale, name
    assert np.max(np.abs(turn["slip"].axial)) < 1e-13 * scale


def test_closed_forms_of_the_spatial_shaft() -> None:
    """Moments and force of Bild 19 as the closed forms for any arrangement give them."""
    angles = held_angles(V_1, H_1, V_2, H_2)
    turn = scene("double_shaft_spatial", angles, -50.0).sweep(POSITIONS)
    housing_in, housing_out = spatial_frames(angles)
    axes = np.array([housing_in[:, 0], X, housing_out[:, 0]])
    rotation = POSITIONS - pin_in_plane(housing_in)
    closed = support_forces.double_shaft_wrenches(axes, rotation, turn.drive_effort, LENGTH)
    scale = np.max(np.abs(closed.moment_1))
    for name, moment in (("pin_1_out", closed.moment_1), ("pin_2_out", closed.moment_2)):
        computed = turn.wrench(name, "world")
        assert np.max(np.abs(computed.moment - moment)) < 1e-13 * scale, name
        assert np.max(np.abs(computed.force - closed.force)) < 1e-13 * scale / LENGTH, name


@pytest.mark.parametrize(("beta_1_deg", "beta_2_deg"), [(25.0, 25.0), (10.0, 30.0), (20.0, 5.0)])
def test_support_forces_of_the_catalogues(beta_1_deg: float, beta_2_deg: float) -> None:
    """Bearings A, B of the input and E, F of the output in both extreme positions.

    Near bearings at b and e from their joint, far ones another a and f away. Pin in the plane of
    the shafts: P = T cos β₁ (tan β₁ + tan β₂) / L, A = P b/a, B = P (a+b)/a, F = P e/f,
    E = P (e+f)/f. Pin normal to it: A = B = T tan β₁ / a, E = F = T sin β₂ / (f cos β₁).
    """
    beta_1, beta_2 = np.radians([beta_1_deg, beta_2_deg])
    turn = w_scene(beta_1, beta_2).sweep([0.0, 0.5 * np.pi])
    a, b, e, f = 0.30, 0.12, 0.15, 0.25
    torque = turn.drive_effort
    A, B = supports(turn, "bearing_in", away=-1.0, near=b, span=a)
    F, E = supports(turn, "bearing_out", away=1.0, near=e, span=f)
    P = torque[0] * np.cos(beta_1) * (np.tan(beta_1) + np.tan(beta_2)) / LENGTH
    in_plane = {"A": P * b / a, "B": P * (a + b) / a, "F": P * e / f, "E": P * (e + f) / f}
    input_ = torque[1] * np.tan(beta_1) / a
    output = torque[1] * np.sin(beta_2) / (f * np.cos(beta_1))
    normal = {"A": input_, "B": input_, "F": output, "E": output}
    for name, computed in (("A", A), ("B", B), ("E", E), ("F", F)):
        sizes = np.linalg.norm(computed, axis=1)
        np.testing.assert_allclose(sizes, [in_plane[name], normal[name]], rtol=1e-13)


def supports(
    turn: cd.Sweep, bearing: str, away: float, near: float, span: float
) -> tuple[np.ndarray, np.ndarray]:
    """Forces of the far and the near bearing that make up the wrench of an end bearing."""
    wrench = turn.wrench(bearing, "world")
    outwards = away * wrench.axis
    force, moment = across(wrench.force, wrench.axis), across(wrench.moment, wrench.axis)
    # Moment about the joint's centre: near u × N + (near + span) u × F, with N + F given.
    far = (np.cross(moment, outwards) - near * force) / span
    return far, force - far
