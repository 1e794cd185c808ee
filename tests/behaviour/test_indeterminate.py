"""What the laws of motion leave open: least norm, compliances, strict scenes."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from testkit.linkages import POSITIONS, RATES, four_bar, loop
from testkit.scenes import relative, universal

import cardan_dyn as cd

HELD = {"joint_angle": 0.6}
G = 9.81


def scene(joint: cd.Mechanism, **options: object) -> cd.Scene:
    return cd.Scene(joint, drive="bearing_in", held=HELD, gravity=(0.0, 0.0, -G), **options)


def masses(joint: cd.Mechanism) -> dict[str, float]:
    inertias = list(joint.model.inertias)
    by_name = {joint.model.names[k]: inertias[k].mass for k in range(1, joint.model.njoints)}
    return {
        "in": by_name["bearing_in"],
        "cross": by_name["pin_in"],
        "out": by_name["bearing_out"] + by_name["pin_out"],
        "housing": by_name["joint_angle"],
    }


def test_elastic_bearings_share_the_weight_like_springs(joint: cd.Mechanism) -> None:
    """Two radial bearings and the cross between them: X = (c_2 F_2 - c_1 F_1) / (c_1 + c_2)."""
    mass = masses(joint)
    c_1, c_2 = 2e-9, 5e-9
    compliance = {
        "bearing_in": [c_1, c_1, c_1, 0.0, 0.0, 0.0],
        "bearing_out": [c_2, c_2, c_2, 0.0, 0.0, 0.0],
    }
    turn = scene(joint, compliance=compliance).sweep(np.linspace(0.0, 6.0, 13))
    # Shafts and cross hang between both bearings; X of the cross' side goes to bearing_in.
    load_1, load_2 = G * mass["in"], G * (mass["cross"] + mass["out"])
    shift = (c_2 * load_2 - c_1 * load_1) / (c_1 + c_2)
    force = turn.wrench("bearing_in", "world").force
    np.testing.assert_allclose(force[:, 2], load_1 + shift, rtol=1e-12)
    assert np.max(np.abs(force[:, :2])) < 1e-9
    force = turn.wrench("bearing_out", "world").force
    np.testing.assert_allclose(force[:, 2], load_2 - shift, rtol=1e-12)
    np.testing.assert_allclose(
        turn.wrench("pin_out", "world").force[:, 2], shift - G * mass["cross"], rtol=1e-11
    )
    # The moments are unique, so no rule changes them; the forces stay flagged as not unique.
    plain = scene(joint).sweep(np.linspace(0.0, 6.0, 13))
    for name in joint.joint_names:
        np.testing.assert_allclose(turn[name].moment, plain[name].moment, atol=1e-10)
        np.testing.assert_array_equal(turn[name].unique, [False] * 3 + [True] * 3)


def test_a_compliance_stays_with_the_parent(joint: cd.Mechanism) -> None:
    """A bearing that gives only vertically keeps doing so while its shaft turns."""
    vertical = {
        "bearing_in": [0.0, 0.0, 1e-8, 0.0, 0.0, 0.0],
        "bearing_out": [0.0, 0.0, 1e-8, 0.0, 0.0, 0.0],
    }
    turn = scene(joint, compliance=vertical).sweep(np.linspace(0.0, 6.0, 13))
    first = turn.wrench("bearing_in", "world").force[:, 2]
    second = turn.wrench("bearing_out", "world").force[:, 2]
    np.testing.assert_allclose(first, second, rtol=1e-11)
    # Full matrices, and the horizontal share left to the least norm: no horizontal force.
    matrices = {name: np.diag(values) for name, values in vertical.items()}
    same = scene(joint, compliance=matrices).sweep(np.linspace(0.0, 6.0, 13))
    np.testing.assert_allclose(same["pin_in"].force, turn["pin_in"].force, atol=1e-9)
    assert np.max(np.abs(turn.wrench("pin_in", "world").force[:, :2])) < 1e-9


def test_elastic_solutions_minimise_the_elastic_energy() -> None:
    """Against the equations of a least squares problem, put together by the test."""
    rng = np.random.default_rng(3)
    flexible = {}
    for name in "abcd":
        root = rng.normal(size=(6, 6))
        flexible[name] = 1e-8 * root @ root.T
    mechanism = cd.load(four_bar(loop("continuous")))
    options = {"drive": "a", "gravity": (0.0, -5.0, -3.0), "loads": {"d": -2.0}}
    turn = cd.Scene(mechanism, **options, compliance=flexible).sweep(POSITIONS, **RATES)
    plain = cd.Scene(mechanism, **options).sweep(POSITIONS, **RATES)

    def energy(sweep_of: dict[str, np.ndarray]) -> np.ndarray:
        return sum(
            0.5 * np.einsum("ni,ij,nj->n", wrench, flexible[name], wrench)
            for name, wrench in sweep_of.items()
        )

    def wrenches(sweep: cd.Sweep) -> dict[str, np.ndarray]:
        by_name = {name: sweep.wrench(name, "parent") for name in "abcd"}
        return {name: np.concatenate([w.force, w.moment], axis=1) for name, w in by_name.items()}

    least, of_least_norm = wrenches(turn), wrenches(plain)
    # From the minimum the energy grows with the square of the step, in both directions alike.
    base = energy(least)
    for step in (1.0, -1.0, 0.5):
        moved = {n: least[n] + step * (of_least_norm[n] - least[n]) for n in "abcd"}
        grown = energy(moved) - base
        assert np.all(grown > 0.0)
        np.testing.assert_allclose(grown, step**2 * (energy(of_least_norm) - base), rtol=1e-6)
    assert turn.balance_residual < 1e-13
    force = plain.wrench("b", "world").force[:, :2]
    assert relative(turn.wrench("b", "world").force[:, :2], force) < 1e-12


def test_elastic_solution_does_not_depend_on_the_cut() -> None:
    flexible = {name: [1e-8, 2e-8, 3e-8, 4e-8, 5e-8, 6e-8] for name in "ab"}
    # The same about its axis from either side, as a bearing is that turns with neither link.
    flexible["c"] = [2e-8, 2e-8, 3e-8, 5e-8, 5e-8, 6e-8]
    sweeps = []
    for ends in (("coupler", "rocker"), ("rocker", "coupler")):
        mechanism = cd.load(four_bar(loop("continuous", *ends)))
        scene_ = cd.Scene(
            mechanism, drive="a", gravity=(0.0, 0.0, -G), compliance=flexible, loads={"d": -1.0}
        )
        sweeps.append(scene_.sweep(POSITIONS, **RATES))
    for name in "abd":
        force = sweeps[0].wrench(name, "world").force
        assert relative(sweeps[1].wrench(name, "world").force, force) < 1e-11


def test_bad_compliances(joint: cd.Mechanism) -> None:
    for value, message in (
        ([1.0, 2.0], r"has shape \(2,\); expected 6 values"),
        (np.ones((6, 5)), r"has shape \(6, 5\)"),
        (np.triu(np.ones((6, 6))), "symmetric"),
        ([-1.0] + [0.0] * 5, "negative in some direction"),
        ([float("nan")] * 6, "not finite"),
    ):
        with pytest.raises(cd.ArgumentError, match=message):
            scene(joint, compliance={"bearing_in": value})
    with pytest.raises(cd.ModelError, match="no joint 'bearing'"):
        scene(joint, compliance={"bearing": [0.0] * 6})


def test_strict_scenes_refuse_to_choose(joint: cd.Mechanism, shaft: cd.Mechanism) -> None:
    with pytest.raises(cd.IndeterminateError, match="pin_in: force x, force y, force z") as caught:
        scene(joint, strict=True).sweep([0.0, 1.0])
    assert set(caught.value.components) == set(joint.joint_names)
    with pytest.raises(cd.IndeterminateError, match="leave open: pin_out: force x"):
        scene(joint, strict=True, outputs=["pin_out"]).sweep([0.0])
    assert len(scene(joint, strict=True, outputs=[]).sweep([0.0])) == 1
    held = {"joint_angle_1": 0.3, "joint_angle_2": 0.3}
    assert len(cd.Scene(shaft, drive="bearing_in", held=held, strict=True).sweep([0.0])) == 1


def bennett(alpha: float, beta: float, theta: float) -> tuple[str, float]:
    """Bennett's four hinges in space, a / sin α = b / sin β, in a position of its motion."""
    a, b = 2.0, 2.0 * np.sin(beta) / np.sin(alpha)
    ratio = np.sin(0.5 * (beta + alpha)) / np.sin(0.5 * (beta - alpha))
    second = 2.0 * np.arctan(ratio / np.tan(0.5 * theta))

    def step(length: float, twist: float, turn: float) -> str:
        placed = pin.SE3(pin.utils.rotate("x", twist), np.array([length, 0.0, 0.0]))
        return origin(placed * pin.SE3(pin.utils.rotate("z", turn), np.zeros(3)))

    def origin(placed: pin.SE3) -> str:
        words = [
            " ".join(repr(float(value)) for value in values)
            for values in (placed.translation, pin.rpy.matrixToRpy(placed.rotation))
        ]
        return f'<origin xyz="{words[0]}" rpy="{words[1]}"/>'

    last = pin.SE3(pin.utils.rotate("x", beta), np.array([b, 0.0, 0.0])).inverse()
    axis = '<axis xyz="0 0 1"/>'
    return (
        f"""<robot name="bennett"><link name="l0"/><link name="l1"/><link name="l2"/>
<link name="l3"/><joint name="j1" type="continuous"><parent link="l0"/><child link="l1"/>
{step(0.0, 0.0, theta)}{axis}</joint>
<joint name="j2" type="continuous"><parent link="l1"/><child link="l2"/>
{step(a, alpha, second)}{axis}</joint>
<joint name="j3" type="continuous"><parent link="l2"/><child link="l3"/>
{step(b, beta, -theta)}{axis}</joint>
<loop name="j4" type="continuous"><predecessor link="l3">{step(a, alpha, -second)}</predecessor>
<successor link="l0">{origin(last)}</successor>{axis}</loop></robot>""",
        float(ratio),
    )


def test_a_mechanism_that_moves_by_its_dimensions_alone() -> None:
    """Six closure equations, three of them independent: only its dimensions let Bennett's move."""
    theta = 1.0
    urdf, ratio = bennett(np.deg2rad(60.0), np.deg2rad(35.0), theta)
    mechanism = cd.load(urdf)
    report = cd.describe(mechanism)
    assert (report.rank, report.mobility) == (3, 1)
    turn = cd.Scene(mechanism, drive="j1", loads={"j3": -1.0}).sweep(
        np.linspace(-0.6, 0.6, 9), speed=2.0
    )
    assert turn.loop_residual < 1e-12
    first = theta + turn.motion.position("j1")
    start = 2.0 * np.arctan(ratio / np.tan(0.5 * theta))
    second = start + turn.motion.position("j2")
    np.testing.assert_allclose(np.tan(0.5 * first) * np.tan(0.5 * second), ratio, rtol=1e-9)
    # Opposite hinges turn alike, so the load on one is the drive of the other.
    np.testing.assert_allclose(turn.motion.ratio("j3"), -1.0, rtol=1e-9)
    np.testing.assert_allclose(turn.drive_effort, -1.0, rtol=1e-8)
    assert turn.balance_residual < 1e-8
    for name in ("j1", "j2", "j3", "j4"):
        assert not np.all(turn[name].unique)


def test_universal_joint_alone_needs_no_rule(joint: cd.Mechanism) -> None:
    """Without weight the least norm puts no force through the cross, as Thoma assumes."""
    turn = universal(joint, 0.6).sweep(POSITIONS)
    for name in joint.joint_names:
        assert np.max(np.abs(turn[name].force)) < 1e-14


@pytest.mark.parametrize("tilt", [0.0, 0.5, np.pi / 2.0])
def test_flags_of_uniqueness_are_those_of_the_axes_asked_for(tilt: float) -> None:
    """A planar ring leaves open the force along its normal and the moments across it."""
    text = FLAT_RING.replace("TILT", repr(tilt))
    turn = cd.Scene(cd.load(text), drive="a", gravity=(1.0, 2.0, 3.0)).sweep([0.1, 0.4, 0.9])
    opened = [False, False, True, True, True, False]
    for name in "abcd":
        assert turn[name].unique.tolist() == [not is_open for is_open in opened]
        across = abs(np.sin(tilt)) > 1e-9
        along = abs(np.cos(tilt)) > 1e-9
        # World axes: x is shared, y and z are turned about it.
        expected = [False, across, along, True, along, across]
        assert turn.wrench(name, "world").unique.tolist() == [not flag for flag in expected]


FLAT_RING = (
    '<robot name="ring"><link name="world"/><link name="ground"/><joint name="tilt" type="fixed">'
    '<parent link="world"/><child link="ground"/><origin xyz="0 0 0" rpy="TILT 0 0"/></joint>'
    + "".join(
        f'<link name="{name}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" '
        'ixz="0" iyz="0"/></inertial></link>'
        for name in ("crank", "coupler", "rocker")
    )
    + "".join(
        f'<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{place}"/><axis xyz="0 0 1"/></joint>'
        for name, parent, child, place in (
            ("a", "ground", "crank", "0 0 0"),
            ("b", "crank", "coupler", "0 1 0"),
            ("d", "ground", "rocker", "3 0 0"),
        )
    )
    + '<loop name="c" type="continuous"><predecessor link="coupler"><origin xyz="3 1 0"/>'
    '</predecessor><successor link="rocker"><origin xyz="0 2 0"/></successor>'
    '<axis xyz="0 0 1"/></loop></robot>'
)
