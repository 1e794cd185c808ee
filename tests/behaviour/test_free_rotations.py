"""Bodies that turn freely, against equations of their own in quaternions and closed forms."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from scipy.special import ellipj

import cardan_dyn as cd

INERTIA = np.array([1.0, 2.0, 2.5])
MASS, CENTRE = 1.5, np.array([0.1, -0.05, 0.2])
GRAVITY = np.array([0.0, 0.0, -9.81])
LINK = (
    '<link name="body"><inertial><origin xyz="{}"/><mass value="1.5"/><inertia ixx="1" iyy="2" '
    'izz="2.5" ixy="0" ixz="0" iyz="0"/></inertial></link>'
)


def described(kind: str, centre: np.ndarray) -> tuple[str, list[str]]:
    """Return a body that turns freely about the world's origin, and the names of its angles."""
    link = LINK.format(" ".join(map(repr, centre.tolist())))
    head = '<robot name="free"><link name="world"/>'
    if kind in ("spherical", "floating"):
        joint = f'<joint name="j" type="{kind}"><parent link="world"/><child link="body"/></joint>'
        names = [f"j.{axis}" if kind == "spherical" else f"j.turn_{axis}" for axis in "xyz"]
        return f"{head}{link}{joint}</robot>", names
    # The last hinge's origin is off the centre, along its own axis.
    ends = {
        "hinges": [("1 0 0", ""), ("0 1 0", ""), ("0 0 1", "")],
        "euler": [("0 0 1", ""), ("1 0 0", '<origin xyz="0 0 0" rpy="0 0 0.3"/>'), ("0 0 1", "")],
    }[kind]
    text, parents = head, ["world", "one", "two"]
    for index, (axis, origin) in enumerate(ends):
        child = ["one", "two", "body"][index]
        text += link if child == "body" else f'<link name="{child}"/>'
        text += (
            f'<joint name="h{index}" type="continuous">{origin}<parent link="{parents[index]}"/>'
            f'<child link="{child}"/><axis xyz="{axis}"/></joint>'
        )
    return f"{text}</robot>", ["h0", "h1", "h2"]


def rotation(kind: str, angles: np.ndarray) -> np.ndarray:
    if kind == "euler":
        first, second, third = angles.T
        zero = np.zeros_like(first)
        turns = [np.stack([zero, zero, first], -1), np.stack([second, zero, zero], -1)]
        offset = Rotation.from_rotvec([0.0, 0.0, 0.3])
        last = Rotation.from_rotvec(np.stack([zero, zero, third], -1))
        return (Rotation.from_rotvec(turns[0]) * offset * Rotation.from_rotvec(turns[1]) * last
                ).as_matrix()  # fmt: skip
    return Rotation.from_euler("XYZ", angles).as_matrix()


def reference(
    start: np.ndarray, spin: np.ndarray, times: np.ndarray, centre: np.ndarray, gravity: np.ndarray
) -> np.ndarray:
    """Return orientations `(N, 3, 3)` by Euler's equations about the origin."""
    about = np.diag(INERTIA) + MASS * (centre @ centre * np.eye(3) - np.outer(centre, centre))

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        q, w = y[:4], y[4:]
        turn = Rotation.from_quat(q).as_matrix()
        moment = np.cross(centre, turn.T @ (MASS * gravity))
        vector, scalar = q[:3], q[3]
        rate = [*(0.5 * (scalar * w + np.cross(vector, w))), -0.5 * vector @ w]
        return np.array([*rate, *np.linalg.solve(about, moment - np.cross(w, about @ w))])

    y = np.concatenate([Rotation.from_matrix(start).as_quat(), spin])
    found = solve_ivp(
        rates, (0.0, times[-1]), y, method="DOP853", rtol=1e-12, atol=1e-13, t_eval=times
    )
    return Rotation.from_quat(found.y[:4].T).as_matrix()


def spin_of(kind: str, angles: np.ndarray, speeds: np.ndarray) -> np.ndarray:
    """Return the angular velocity in the body's frame, by differences."""
    step = 1e-6
    before, after = (rotation(kind, (angles + sign * step * speeds)[None])[0] for sign in (-1, 1))
    skew = rotation(kind, angles[None])[0].T @ (after - before) / (2.0 * step)
    return np.array([skew[2, 1], skew[0, 2], skew[1, 0]])


def simulated(
    kind: str,
    angles: np.ndarray,
    speeds: np.ndarray,
    gravity: np.ndarray,
    centre: np.ndarray,
    duration: float = 3.0,
    **options: object,
) -> cd.Trajectory:
    text, names = described(kind, centre)
    mechanism = cd.load(text)
    scene = cd.Scene(mechanism, drive=list(mechanism.drivable), gravity=gravity)
    return scene.replace(free=scene.drives).simulate(
        duration,
        position=dict(zip(names, angles.tolist(), strict=True)),
        speed=dict(zip(names, speeds.tolist(), strict=True)),
        **options,
    )


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["spherical", "floating", "hinges"])
@pytest.mark.parametrize("miss", [0.0, 1e-9, 1e-3])
def test_no_stall_where_the_middle_angle_passes_a_right_angle(kind: str, miss: float) -> None:
    speeds = np.array([miss, 2.0, -0.7 * miss])
    found = simulated(kind, np.zeros(3), speeds, np.zeros(3), np.zeros(3))
    assert len(found.time) < 40 and found.time[-1] == 3.0
    times = np.linspace(0.0, 3.0, 400)
    angles = found.at(times).position[:, -3:]
    spin = spin_of(kind, np.zeros(3), speeds)
    expected = reference(np.eye(3), spin, times, np.zeros(3), np.zeros(3))
    np.testing.assert_allclose(rotation(kind, angles), expected, atol=1e-8)
    assert found.energy_residual < 1e-9
    if miss == 0.0:
        np.testing.assert_allclose(angles[:, 1], 2.0 * times, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(found.at(times).speed[:, -2], 2.0, rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["spherical", "euler"])
@pytest.mark.parametrize(
    "seed", [0, 1, *(pytest.param(seed, marks=pytest.mark.campaign) for seed in (2, 3))]
)
def test_heavy_top_and_branches_of_its_angles(kind: str, seed: int) -> None:
    """Angles are continuous: over short times they change as their speeds say."""
    rng = np.random.default_rng(seed)
    angles, speeds = rng.uniform(-3.0, 3.0, 3), rng.normal(size=3) * 3.0
    found = simulated(kind, angles, speeds, GRAVITY, CENTRE)
    times = np.linspace(0.0, 3.0, 6001)
    at = found.at(times)
    spin = spin_of(kind, angles, speeds)
    start = rotation(kind, angles[None])[0]
    expected = reference(start, spin, times[::20], CENTRE, GRAVITY)
    np.testing.assert_allclose(rotation(kind, at.position[::20]), expected, atol=1e-7)
    steps, rates = np.diff(at.position, axis=0), at.speed
    mean = 0.5 * (rates[1:] + rates[:-1]) * np.diff(times)[:, None]
    slow = np.max(np.abs(rates[1:]), axis=1) < 100.0
    assert np.count_nonzero(slow) > 5900
    np.testing.assert_allclose(steps[slow], mean[slow], atol=0.02)
    assert found.effort_residual < 1e-9 if np.all(slow) else True


def test_euler_poinsot_against_jacobis_elliptic_functions() -> None:
    """A body without moments, its angular velocity as Landau and Lifshitz (section 37) have it."""
    spin = np.array([0.3, 1e-9, 2.0])
    twice, moment = float(INERTIA @ spin**2), float(np.sum((INERTIA * spin) ** 2))
    a, b, c = INERTIA
    assert moment > twice * b
    rate = np.sqrt((c - b) * (moment - twice * a) / (a * b * c))
    modulus = (b - a) * (twice * c - moment) / ((c - b) * (moment - twice * a))
    times = np.linspace(0.0, 20.0, 300)
    sn, cn, dn, _ = ellipj(rate * times, modulus)
    expected = np.stack(
        [
            np.sqrt((twice * c - moment) / (a * (c - a))) * cn,
            np.sqrt((twice * c - moment) / (b * (c - b))) * sn,
            np.sqrt((moment - twice * a) / (c * (c - a))) * dn,
        ],
        axis=1,
    )
    found = simulated("spherical", np.zeros(3), spin, np.zeros(3), np.zeros(3), duration=20.0)
    at = found.at(times)
    turned = rotation("spherical", at.position)
    _, y, z = at.position.T
    dx, dy, dz = at.speed.T
    own = np.stack(
        [
            dx * np.cos(y) * np.cos(z) + dy * np.sin(z),
            -dx * np.cos(y) * np.sin(z) + dy * np.cos(z),
            dx * np.sin(y) + dz,
        ],
        axis=1,
    )
    np.testing.assert_allclose(own, expected, atol=1e-7)
    momentum = np.einsum("nij,nj->ni", turned, INERTIA * own)
    np.testing.assert_allclose(momentum, np.tile(INERTIA * spin, (300, 1)), atol=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("miss", [0.0, 1e-9, 1e-3, 0.2])
def test_elements_act_where_axes_coincide(miss: float) -> None:
    """Springs to the world, and along the middle angle: energy is kept, and no step is short."""
    text, names = described("spherical", CENTRE)
    mechanism = cd.load(text)
    for element in (
        cd.PointSpring("world", (0, 0, 1.0), "body", (0.1, 0, 0.5), stiffness=20.0),
        cd.Bushing("world", "body", (0.0, 0.0, 0.0), np.full(6, 15.0)),
        cd.JointSpring("j.y", 0.5),
    ):
        scene = cd.Scene(mechanism, free=names, elements=[element], gravity=GRAVITY)
        speeds = dict(zip(names, (miss, 4.0, -miss), strict=True))
        found = scene.simulate(2.0, speed=speeds)
        assert len(found.time) < 150 and found.energy_residual < 1e-8
        energy = found.kinetic_energy + found.potential_energy
        np.testing.assert_allclose(energy, energy[0], atol=1e-7)


def test_forces_without_bound_are_refused() -> None:
    text, names = described("spherical", np.zeros(3))
    scene = cd.Scene(cd.load(text), free=names, elements=[cd.JointSpring("j.x", 3.0)])
    with pytest.raises(cd.SimulationError, match=r"'j.x' and 'j.z' coincide"):
        scene.simulate(3.0, speed={"j.x": 1e-9, "j.y": 2.0, "j.z": 0.0})


def test_speeds_that_do_not_exist_are_marked() -> None:
    """At 90°, a body that turns across both other axes leaves no rates of the outer angles."""
    text, names = described("spherical", np.array([0.0, 0.3, 0.0]))
    mechanism = cd.load(text)
    load = {"body": cd.Wrench(moment=(0.0, 0.0, 0.0))}
    scene = cd.Scene(mechanism, free=names, loads=load, gravity=(0.0, 0.0, 0.0))
    found = scene.simulate(
        1.0, position={"j.y": np.pi / 2}, speed={"j.x": 1.0, "j.y": 2.0, "j.z": 0.5}
    )
    start = found.at([0.0]).speed[0]
    # Speeds of outer angles are known by their sum alone, and have a limit along the way.
    assert start[1] == pytest.approx(2.0) and start[0] + start[2] == pytest.approx(1.5)
    assert np.all(np.isfinite(found.speed))
    assert found.energy_residual < 1e-9


@pytest.mark.parametrize("miss", [0.0, 1e-12, 1e-9, 1e-3])
def test_points_near_a_right_angle_move_as_the_body_does_or_are_marked(miss: float) -> None:
    """Without moments, angular momentum stays; where angles cannot tell the speed, it is nan."""
    speeds = np.array([miss, 2.0, -0.7 * miss])
    found = simulated("spherical", np.zeros(3), speeds, np.zeros(3), np.zeros(3))
    near = np.array([-1e-3, -1e-6, -1e-9, 0.0, 1e-9, 1e-6])
    at = found.at(np.concatenate([np.linspace(0.0, 3.0, 100), 0.25 * np.pi + near]))
    point = at.point("body", (0.1, 0.2, 0.3))
    own = np.einsum("nji,nj->ni", point.orientation, point.angular_velocity)
    momentum = np.einsum("nij,nj->ni", point.orientation, INERTIA * own)
    known = np.all(np.isfinite(momentum), axis=1)
    assert np.count_nonzero(~known) <= 6 * (miss > 0.0)
    expected = INERTIA * spin_of("spherical", np.zeros(3), speeds)
    np.testing.assert_allclose(momentum[known], [expected] * np.sum(known), atol=1e-8)
    swept = np.cross(point.angular_velocity, point.position)
    np.testing.assert_allclose(point.velocity, swept, atol=1e-12)
    assert np.all(np.isfinite(point.position))


def test_copies_read_the_same_angles() -> None:
    speeds = np.array([1e-5, 2.0, 0.0])
    found = simulated("spherical", np.zeros(3), speeds, np.zeros(3), np.zeros(3))
    times = np.linspace(0.0, 3.0, 50)
    for other in (pickle.loads(pickle.dumps(found)), copy.deepcopy(found)):
        np.testing.assert_array_equal(other.at(times).position, found.at(times).position)


def test_times_at_which_axes_coincide_leave_the_others_their_wrenches() -> None:
    """A heavy body is released where first and last axis are one, and weight tips it across."""
    text, names = described("euler", CENTRE)
    scene = cd.Scene(cd.load(text), free=names, gravity=GRAVITY)
    found = scene.simulate(1.0)
    np.testing.assert_array_equal(found.singular, found.time == 0.0)
    assert found.effort_residual < 1e-8
    # Newton about the support: force is mass times the acceleration of the centre, less weight.
    times = np.linspace(0.2, 0.9, 8)[:, None] + 1e-3 * np.arange(-1, 2)
    turns = rotation("euler", found.at(times.ravel()).position).reshape(8, 3, 3, 3)
    centre = turns @ CENTRE
    pull = (centre[:, 0] - 2.0 * centre[:, 1] + centre[:, 2]) / 1e-6
    force = found.at(times[:, 1]).sweep.wrench(names[0], "world").force
    np.testing.assert_allclose(force, MASS * (pull - GRAVITY), atol=1e-3)
